"""Planar bodies with pins, as all programs get them, and their motion by the obvious formulas: slow, and independent.

The reference solves M a + J' l = F, J a = -J' v for accelerations with dense matrices and integrates them with SciPy.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

G = 9.81  # [m/s^2]
GROUND = -1
Arm = tuple[float, float]


class Body(NamedTuple):
    """Mass centre, angle and rates at the start; SI units."""

    mass: float
    inertia: float
    x: float
    y: float
    angle: float
    vx: float = 0.0
    vy: float = 0.0
    omega: float = 0.0


class Pin(NamedTuple):
    """A pin between body `a` (or GROUND) and body `b`: where it is, from their mass centres, in their own axes."""

    a: int
    at_a: Arm
    b: int
    at_b: Arm


class Bodies(NamedTuple):
    """Bodies with pins; those of `sliders` move along x only.  The first pin of a body holds it in a tree."""

    bodies: tuple[Body, ...]
    pins: tuple[Pin, ...]
    sliders: tuple[int, ...] = ()


def bar(length: float, mass: float, foot: Arm, angle: float, omega: float = 0.0, rate: Arm = (0.0, 0.0)) -> Body:
    """A uniform bar; `foot` is one of its ends, `rate` the velocity of this."""
    c, s, half = math.cos(angle), math.sin(angle), length / 2
    centre, v = (foot[0] + half * c, foot[1] + half * s), (rate[0] - omega * half * s, rate[1] + omega * half * c)
    return Body(mass, mass * length**2 / 12, *centre, angle, *v, omega)


def turned(angle: float, arm: Arm) -> Arm:
    """An arm in the axes of the ground."""
    c, s = math.cos(angle), math.sin(angle)
    return c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]


def positions_at(model: Bodies, end: float) -> np.ndarray:
    """x and y of all mass centres at `end` [m]."""
    n = len(model.bodies)
    mass = np.diag([value for one in model.bodies for value in (one.mass, one.mass, one.inertia)])
    weight = np.array([value for one in model.bodies for value in (0.0, -one.mass * G, 0.0)])

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        q, v = y[: 3 * n], y[3 * n :]
        jacobian, bias = _rows(model, q, v)
        m = len(bias)
        matrix = np.block([[mass, jacobian.T], [jacobian, np.zeros((m, m))]])
        both = np.linalg.lstsq(matrix, np.concatenate([weight, bias]), rcond=1e-13)[0]
        return np.concatenate([v, both[: 3 * n]])

    start = [value for one in model.bodies for value in (one.x, one.y, one.angle)]
    speed = [value for one in model.bodies for value in (one.vx, one.vy, one.omega)]
    done = solve_ivp(rates, (0.0, end), np.array(start + speed), method="DOP853", rtol=3e-14, atol=1e-14)
    return done.y[: 3 * n, -1].reshape(n, 3)[:, :2].ravel()


def _rows(model: Bodies, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the constraints, and what their product with the accelerations must be."""
    jacobian, bias = [], []
    for pin in model.pins:
        block, must = np.zeros((2, len(q))), np.zeros(2)
        for body, arm, sign in ((pin.a, pin.at_a, -1.0), (pin.b, pin.at_b, 1.0)):
            if body != GROUND:
                x, y = turned(q[3 * body + 2], arm)
                block[:, 3 * body : 3 * body + 3] = sign * np.array([[1.0, 0.0, -y], [0.0, 1.0, x]])
                must += sign * v[3 * body + 2] ** 2 * np.array([x, y])
        jacobian.append(block)
        bias.append(must)
    for body in model.sliders:
        block = np.zeros((2, len(q)))
        block[0, 3 * body + 1] = block[1, 3 * body + 2] = 1.0
        jacobian.append(block)
        bias.append(np.zeros(2))
    return np.vstack(jacobian), np.concatenate(bias)


# ---------------------------------------------------------------- cases
def double_pendulum() -> Bodies:
    """Two bars of 1 m and 1 kg, let go from 60 deg and 0 from the horizontal."""
    first = bar(1.0, 1.0, (0.0, 0.0), math.radians(-60.0))
    tip = turned(first.angle, (1.0, 0.0))
    second = bar(1.0, 1.0, tip, 0.0)
    return Bodies((first, second), (Pin(GROUND, (0.0, 0.0), 0, (-0.5, 0.0)), Pin(0, (0.5, 0.0), 1, (-0.5, 0.0))))


def four_bar() -> Bodies:
    """Crank 0.3 m, coupler 0.8 m, rocker 0.6 m, ground 0.9 m; the crank turns at 2 rad/s at the start."""
    lengths, ground, angle, omega = (0.3, 0.8, 0.6), 0.9, math.radians(60.0), 2.0
    x, y = turned(angle, (lengths[0], 0.0))
    from_end = math.hypot(ground - x, y)
    cos = (lengths[1] ** 2 + from_end**2 - lengths[2] ** 2) / (2 * lengths[1] * from_end)
    coupler = math.acos(cos) + math.atan2(-y, ground - x)
    p = np.array([x, y]) + turned(coupler, (lengths[1], 0.0))
    rocker = math.atan2(p[1], p[0] - ground)
    # v_B + w2 perp(BC) = w3 perp(DC)
    b, c = turned(coupler, (lengths[1], 0.0)), turned(rocker, (lengths[2], 0.0))
    v = (-omega * y, omega * x)
    w2, w3 = np.linalg.solve([[-b[1], c[1]], [b[0], -c[0]]], [-v[0], -v[1]])
    bodies = (
        bar(lengths[0], 1.0, (0.0, 0.0), angle, omega),
        bar(lengths[1], 2.0, (x, y), coupler, float(w2), v),
        bar(lengths[2], 1.5, (ground, 0.0), rocker, float(w3)),
    )
    half = [length / 2 for length in lengths]
    pins = (
        Pin(GROUND, (0.0, 0.0), 0, (-half[0], 0.0)),
        Pin(0, (half[0], 0.0), 1, (-half[1], 0.0)),
        Pin(GROUND, (ground, 0.0), 2, (-half[2], 0.0)),
        Pin(1, (half[1], 0.0), 2, (half[2], 0.0)),
    )
    return Bodies(bodies, pins)


def slider_crank() -> Bodies:
    """Crank 0.2 m, rod 0.6 m and a slider of 1 kg; the crank turns at 10 rad/s at the start."""
    crank, rod, angle, omega = 0.2, 0.6, math.radians(40.0), 10.0
    x, y = turned(angle, (crank, 0.0))
    lean = -math.asin(y / rod)
    v = (-omega * y, omega * x)
    w = -v[1] / (rod * math.cos(lean))
    bodies = (
        bar(crank, 0.5, (0.0, 0.0), angle, omega),
        bar(rod, 0.8, (x, y), lean, w, v),
        Body(1.0, 0.001, x + rod * math.cos(lean), 0.0, 0.0, v[0] - w * rod * math.sin(lean)),
    )
    pins = (
        Pin(GROUND, (0.0, 0.0), 0, (-crank / 2, 0.0)),
        Pin(0, (crank / 2, 0.0), 1, (-rod / 2, 0.0)),
        Pin(1, (rod / 2, 0.0), 2, (0.0, 0.0)),
    )
    return Bodies(bodies, pins, (2,))


def windows(count: int) -> Bodies:
    """Parallelogram four-bars side by side, bars of 1 m and 1 kg, upper points start with 1 m/s (IFToMM A02)."""
    posts = [bar(1.0, 1.0, (float(k), 0.0), math.pi / 2, -1.0) for k in range(count + 1)]
    bars = [bar(1.0, 1.0, (float(k), 1.0), 0.0, 0.0, (1.0, 0.0)) for k in range(count)]
    pins = [Pin(GROUND, (float(k), 0.0), k, (-0.5, 0.0)) for k in range(count + 1)]
    for k in range(count):
        pins += [Pin(k, (0.5, 0.0), count + 1 + k, (-0.5, 0.0)), Pin(count + 1 + k, (0.5, 0.0), k + 1, (0.5, 0.0))]
    return Bodies((*posts, *bars), tuple(pins))


def windows_at(count: int, end: float) -> np.ndarray:
    """The same as `positions_at`: all posts swing as one pendulum, phi'' = -g cos(phi) (9 n + 3)/(8 n + 2)."""
    share = G * (9 * count + 3) / (8 * count + 2)
    done = solve_ivp(
        lambda _, y: (y[1], -share * math.cos(y[0])), (0.0, end), (math.pi / 2, -1.0), "DOP853", rtol=3e-14, atol=1e-14
    )
    x, y = turned(done.y[0, -1], (1.0, 0.0))
    posts = [(k + x / 2, y / 2) for k in range(count + 1)]
    return np.ravel(posts + [(k + 0.5 + x, y) for k in range(count)])


def tree(model: Bodies) -> tuple[dict[int, Pin], Sequence[Pin]]:
    """The pin that holds each body in a tree (its first as `b`), and all others, which close loops."""
    holds: dict[int, Pin] = {}
    rest = []
    for pin in model.pins:
        if pin.b in holds or pin.b in model.sliders:
            rest.append(pin)
        else:
            holds[pin.b] = pin
    return holds, rest
