"""What tests of oil films share: one bearing, random states of it, the force of a law in polar parts."""

import math

import numpy as np

import rattle as rt

OIL = {"viscosity": 0.05, "length": 0.01, "radius": 0.01, "clearance": 5e-5}
LAWS = [
    ("short", "reynolds"),
    ("short", "full"),
    ("finite", "reynolds"),
    ("finite", "full"),
    ("pinkus-sternlicht", "reynolds"),
]


def film(model="finite", cavitation="reynolds", ratio=0.5, **more):
    """A film of the bearing above with this L/D."""
    return rt.Film(**{**OIL, "length": 2 * ratio * OIL["radius"], **more}, model=model, cavitation=cavitation)


def unit(one):
    """mu R L^3/c^3 [N s/m], in which forces over speeds are given."""
    return one.viscosity * one.radius * one.length**3 / one.clearance**3


def parts(one, e, alpha, turned=0.7, speed=1e-3):
    """I_n, I_t: minus the force along the eccentricity and across it, for a velocity at alpha [rad] from it."""
    nx, ny, a = math.cos(turned), math.sin(turned), turned + alpha
    place = e * one.clearance
    fx, fy = one.force(place * nx, place * ny, speed * math.cos(a), speed * math.sin(a))[:2]
    return -np.array([fx * nx + fy * ny, fy * nx - fx * ny]) / (unit(one) * speed)


def states(one, count, seed, most=0.98):
    """Random states: e [m], its rate [m/s], rates of bush and pin [rad/s]."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        r, a = most * one.clearance * math.sqrt(rng.random()), 2 * math.pi * rng.random()
        vx, vy = 0.01 * rng.normal(size=2)
        yield (r * math.cos(a), r * math.sin(a), vx, vy, *(300 * rng.normal(size=2)))
