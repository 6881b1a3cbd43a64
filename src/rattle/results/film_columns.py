"""Columns of the oil film in a joint: from where its pin is and how it moves, by the law of the film."""

from __future__ import annotations

import math

import numpy as np

from rattle import registry
from rattle.description.model import Joint, OilFilm, Point
from rattle.equations.system import System
from rattle.jit import layout as at

Array = np.ndarray
FILM, MIXED, DRY = 0.0, 1.0, 2.0  # regimes
LITTLE = 0.01  # force of the film over that of the dry contact, below which the joint counts as dry


def film_columns(system: System, joint: Joint, raw: Array, c: int) -> dict[str, tuple[str, Array]]:
    """Units and values (n,) [SI] of the columns of a film; c: first raw column of the joint.

    `friction_torque` is the moment on B about the centre of the pin; `friction_power` what film and dry friction lose;
    `leakage` leaves both ends together; `sommerfeld` is mu N (2 R L/W) (R/c)^2 with N the sum of both rates in
    revolutions per second and W the force of the film, nan where it has none; `regime`: 0 film, 1 mixed, 2 dry (the
    film has less than 1 % of the dry force); `lambda_ratio` is the thickness over the roughness, or three times that
    over the boundary film.
    """
    contact = joint.contact
    assert contact is not None, "called for a joint with a contact"
    assert contact.film is not None, "called for a joint with oil"
    film, clearance = contact.film, joint.clearance
    e, v, rates = _motion(system, joint, raw, c)
    size, (wa, wb) = np.hypot(*e), rates
    on_a = contact.bush_radius - 0.5 * (clearance - size)  # see the clearance `pin`
    moment = raw[:, c + at.MOMENT] - (raw[:, c + at.STOP] if joint.stops_angle else 0.0)
    fx, fy = _force(raw, c, e)
    u = v + 0.5 * (wa + wb) * np.array([e[1], -e[0]])
    on_pin = moment + raw[:, c + at.JOINT_TANGENT] * (on_a - size)  # of the film alone
    shear = -on_pin - 0.5 * (e[0] * fy - e[1] * fx)  # T_c, see `rattle.elements.film`
    slip = _across(e, v) + wb * (on_a - size) - wa * on_a
    normal, friction = raw[:, c + at.JOINT_NORMAL], raw[:, c + at.JOINT_TANGENT]
    peak, leakage = _pressure(film, e, u, clearance)
    force = np.hypot(fx, fy)
    regime = np.where(normal > 0.0, np.where(force < LITTLE * normal, DRY, MIXED), FILM)
    values, turns = film.law.values, np.abs(wa + wb) / (2.0 * math.pi)
    mu, length, radius = (float(values[key]) for key in ("viscosity", "length", "bush_radius"))
    with np.errstate(divide="ignore", invalid="ignore"):
        unit = mu * turns * 2.0 * radius * length * (radius / clearance) ** 2
        sommerfeld = np.where(force > 0.0, unit / force, np.nan)
    return {
        "eccentricity": ("", size / clearance),
        "film_thickness": ("m", clearance - size),
        "film_pressure": ("Pa", peak),
        "film_fx": ("N", fx),
        "film_fy": ("N", fy),
        "friction_torque": ("N*m", moment),
        "friction_power": ("W", shear * (wb - wa) - fx * u[0] - fy * u[1] + friction * slip),
        "leakage": ("m^3/s", leakage),
        "sommerfeld": ("", sommerfeld),
        "regime": ("", regime),
        "lambda_ratio": ("", (clearance - size) / film.roughness),
    }


def _motion(system: System, joint: Joint, raw: Array, c: int) -> tuple[Array, Array, Array]:
    """(2, n): place of the pin in the bush [m], its rate [m/s], and the rates of bush and pin [rad/s]."""
    a, b = (_point_rate(system, end, raw) for end in (joint.a, joint.b))
    return raw[:, [c + at.EX, c + at.EY]].T, b[:2] - a[:2], np.array([a[2], b[2]])


def _point_rate(system: System, end: Point, raw: Array) -> Array:
    """(3, n): velocity of a point of a body [m/s], and the rate of the body [rad/s]."""
    if end.body == "ground":
        return np.zeros((3, len(raw)))
    k = at.PER_BODY * system.bodies.index(end.body)
    angle, (vx, vy, w) = raw[:, k + at.PLACE + 2], raw[:, k + at.RATE : k + at.RATE + 3].T
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = cos * end.at[0] - sin * end.at[1], sin * end.at[0] + cos * end.at[1]
    return np.array([vx - w * y, vy + w * x, w])


def _force(raw: Array, c: int, e: Array) -> tuple[Array, Array]:
    """Force (n,) [N] of the film on B along x and y: what the dry contact leaves of that of the joint."""
    size = np.hypot(*e)
    with np.errstate(divide="ignore", invalid="ignore"):
        nx, ny = np.where(size > 0.0, e / size, 0.0)
    normal, tangent = raw[:, c + at.JOINT_NORMAL], raw[:, c + at.JOINT_TANGENT]
    fx = raw[:, c + at.FX] + normal * nx - tangent * ny
    fy = raw[:, c + at.FY] + normal * ny + tangent * nx
    return fx, fy


def _pressure(film: OilFilm, e: Array, u: Array, clearance: float) -> tuple[Array, Array]:
    """(n,): largest pressure [Pa] and leakage [m^3/s]; u: the velocity [m/s] that the film sees."""
    law, values = registry.kinds("film")[film.law.kind].leaf, film.law.values
    mu, length, radius = (float(values[key]) for key in ("viscosity", "length", "bush_radius"))
    speed = np.hypot(*u)
    alpha = np.abs(np.arctan2(e[0] * u[1] - e[1] * u[0], e[0] * u[0] + e[1] * u[1]))
    part = np.minimum(np.hypot(*e), clearance - film.boundary) / clearance
    peak = mu * length**2 * speed / clearance**3 * law.peak(values, part, alpha)
    return peak, 2.0 * radius * length * speed * law.leakage(values, part, alpha)


def _across(e: Array, v: Array) -> Array:
    """Velocity (n,) [m/s] of the centre of the pin across the eccentricity."""
    size = np.hypot(*e)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(size > 0.0, (e[0] * v[1] - e[1] * v[0]) / size, 0.0)
