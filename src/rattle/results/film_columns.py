"""Columns of the oil film in a joint: from where its pin is and how it moves, by the law of the film."""

from __future__ import annotations

import math
from typing import Any

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
    fx, fy, loss, peak, leakage = _forces(film, e, v, rates, clearance)
    size, force = np.hypot(*e), np.hypot(fx, fy)
    normal, friction = raw[:, c + at.JOINT_NORMAL], raw[:, c + at.JOINT_TANGENT]
    regime = np.where(normal > 0.0, np.where(force < LITTLE * normal, DRY, MIXED), FILM)
    values, turns = film.law.values, np.abs(rates[0] + rates[1]) / (2.0 * math.pi)
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
        "friction_torque": ("N*m", raw[:, c + at.MOMENT]),
        "friction_power": ("W", loss + friction * _slip(e, v, rates, contact.bush_radius, clearance)),
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


def _forces(film: OilFilm, e: Array, v: Array, rates: Array, clearance: float) -> Array:
    """(5, n): force on B [N, N], loss [W], largest pressure [Pa] and leakage [m^3/s]."""
    law, values = registry.kinds("film")[film.law.kind], film.law.values
    kernel: Any = law.kernel
    p = np.array(law.leaf.pack(values, clearance, film.boundary), dtype=float)
    table, out, n = np.array(law.leaf.table(values)), np.zeros(5), e.shape[1]
    mu, length, radius = (float(values[key]) for key in ("viscosity", "length", "bush_radius"))
    found = np.empty((5, n))
    wm = 0.5 * (rates[0] + rates[1])
    ux, uy = v[0] + wm * e[1], v[1] - wm * e[0]
    speed = np.hypot(ux, uy)
    alpha = np.abs(np.arctan2(e[0] * uy - e[1] * ux, e[0] * ux + e[1] * uy))
    part = np.minimum(np.hypot(*e), clearance - film.boundary) / clearance
    for k, state in enumerate(np.concatenate([e, v, rates]).T.tolist()):
        kernel(*state, p, 0, table, out)
        found[:3, k] = out[0], out[1], out[4]
        moves = speed[k] > 0.0
        found[3, k] = law.leaf.peak(values, part[k], alpha[k]) if moves else 0.0
        found[4, k] = law.leaf.leakage(values, part[k], alpha[k]) if moves else 0.0
    found[3] *= mu * length**2 * speed / clearance**3
    found[4] *= 2.0 * radius * length * speed
    return found


def _slip(e: Array, v: Array, rates: Array, radius: float, clearance: float) -> Array:
    """Speed (n,) [m/s] at which the pin slips along the bush where they are nearest, see the clearance `pin`."""
    size = np.hypot(*e)
    with np.errstate(divide="ignore", invalid="ignore"):
        across = np.where(size > 0.0, (e[0] * v[1] - e[1] * v[0]) / size, 0.0)
    on_a = radius - 0.5 * (clearance - size)
    return np.asarray(across + rates[1] * (on_a - size) - rates[0] * on_a)
