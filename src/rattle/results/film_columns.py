"""Columns of the oil film in a joint: from where its pin is and how it moves, by the law of the film."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from rattle import registry
from rattle.description.model import Joint, OilFilm, Point
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.value_types import Tree

Array = np.ndarray
FILM, MIXED, DRY = 0.0, 1.0, 2.0  # regimes
LITTLE = 0.01  # force of the film over that of the dry contact, below which the joint counts as dry


class PinMotion(NamedTuple):
    """Where the pin is in its bush and how it moves, and what acts on it, at n instants."""

    place: Sequence[Array]  # (2, n) e [m], from the centre of the bush to that of the pin
    rate: Sequence[Array]  # (2, n) e' [m/s]
    turning: Sequence[Array]  # (2, n) rates of bush and pin [rad/s]
    force: Sequence[Array]  # (2, n) of film and dry contact together, on the pin [N]
    moment: Array  # (n,) of both about the centre of the pin [N*m]
    normal: Array  # (n,) of the dry contact [N]
    tangential: Array  # (n,) its friction [N]


def film_columns(
    system: System, joint: Joint, raw: Array, c: int, turning: Array | None = None
) -> dict[str, tuple[str, Array]]:
    """Units and values (n,) [SI] of the columns of a film, see `film_values`; c: first raw column of the joint.

    turning (n, nb + 1): rates of the ground and of all bodies [rad/s] that the film sees while its pin stays in place;
    default: the motion in the rows.
    """
    a, b = (
        _point_rate(system, end, raw) if turning is None else _turning_only(system, end, turning)
        for end in (joint.a, joint.b)
    )
    moment = raw[:, c + at.MOMENT] - (raw[:, c + at.STOP] if joint.stops_angle else 0.0)
    place, force = (raw[:, c + at.EX], raw[:, c + at.EY]), (raw[:, c + at.FX], raw[:, c + at.FY])
    dry = raw[:, c + at.JOINT_NORMAL], raw[:, c + at.JOINT_TANGENT]
    return film_values(joint, PinMotion(place, (b[0] - a[0], b[1] - a[1]), (a[2], b[2]), force, moment, *dry))


def film_values(joint: Joint, pin: PinMotion) -> dict[str, tuple[str, Array]]:
    """Units and values (n,) [SI] of the columns of a film.

    `friction_torque` is the moment on B about the centre of the pin; `friction_power` what film and dry friction lose;
    `leakage` leaves both ends together; `sommerfeld` is mu N (2 R L/W) (R/c)^2 with N the sum of both rates in
    revolutions per second and W the force of the film, nan where it has none; `regime`: 0 film, 1 mixed, 2 dry (the
    film has less than 1 % of the dry force); `lambda_ratio` is the thickness over the roughness, or three times that
    over the boundary film.
    """
    contact = joint.contact
    assert contact is not None, "called for a joint with a contact"
    assert contact.film is not None, "called for a joint with oil"
    film, clearance = contact.film, float(joint.clearance)
    e, v, (wa, wb), normal, friction = pin.place, pin.rate, pin.turning, pin.normal, pin.tangential
    size, mean = np.hypot(*e), 0.5 * (wa + wb)
    on_a = float(contact.bush_radius) - 0.5 * (clearance - size)  # see the clearance `pin`
    fx, fy = _of_film(pin)
    u = v[0] + mean * e[1], v[1] + mean * -e[0]
    on_pin = pin.moment + friction * (on_a - size)  # of the film alone
    shear = -on_pin - 0.5 * (e[0] * fy - e[1] * fx)  # T_c, see `rattle.elements.film`
    slip = _across(e, v) + wb * (on_a - size) - wa * on_a
    peak, leakage = _pressure(film, e, u, clearance)
    force = np.hypot(fx, fy)
    regime = np.where(normal > 0.0, np.where(force < LITTLE * normal, DRY, MIXED), FILM)
    turns = np.abs(wa + wb) / (2.0 * math.pi)
    mu, length, radius = (float(film.law.number(key)) for key in ("viscosity", "length", "bush_radius"))
    with np.errstate(divide="ignore", invalid="ignore"):
        unit = mu * turns * 2.0 * radius * length * (radius / clearance) ** 2
        sommerfeld = np.where(force > 0.0, unit / force, np.nan)
    return {
        "eccentricity": ("", size / clearance),
        "film_thickness": ("m", clearance - size),
        "film_pressure": ("Pa", peak),
        "film_fx": ("N", fx),
        "film_fy": ("N", fy),
        "friction_torque": ("N*m", pin.moment),
        "friction_power": ("W", shear * (wb - wa) - fx * u[0] - fy * u[1] + friction * slip),
        "leakage": ("m^3/s", leakage),
        "sommerfeld": ("", sommerfeld),
        "regime": ("", regime),
        "lambda_ratio": ("", (clearance - size) / float(film.roughness)),
    }


def _point_rate(system: System, end: Point, raw: Array) -> Sequence[Array]:
    """(3, n): velocity of a point of a body [m/s], and the rate of the body [rad/s]."""
    if end.body == "ground":
        still = np.zeros_like(raw[:, 0])
        return still, still, still
    k = at.PER_BODY * system.bodies.index(end.body)
    angle, vx, vy, w = (raw[:, k + n] for n in (at.PLACE + 2, at.RATE, at.RATE + 1, at.RATE + 2))
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = cos * end.at[0] - sin * end.at[1], sin * end.at[0] + cos * end.at[1]
    return vx - w * y, vy + w * x, w


def _turning_only(system: System, end: Point, turning: Array) -> Sequence[Array]:
    """(3, n): no velocity of the point, and the rate of its body [rad/s]."""
    still = np.zeros_like(turning[:, 0])
    return still, still, still if end.body == "ground" else turning[:, 1 + system.bodies.index(end.body)]


def _of_film(pin: PinMotion) -> Sequence[Array]:
    """Force (2, n) [N] of the film on B: what the dry contact leaves of that of the joint."""
    size = np.hypot(*pin.place)
    with np.errstate(divide="ignore", invalid="ignore"):
        nx, ny = (np.where(size > 0.0, x / size, 0.0) for x in pin.place)
    fx, fy = pin.force
    return fx + pin.normal * nx + pin.tangential * -ny, fy + pin.normal * ny + pin.tangential * nx


def _pressure(film: OilFilm, e: Sequence[Array], u: Sequence[Array], clearance: float) -> tuple[Array, Array]:
    """(n,): largest pressure [Pa] and leakage [m^3/s]; u: the velocity [m/s] that the film sees."""
    law, values = registry.kinds("film")[film.law.kind].leaf, film.law.values
    mu, length, radius = (float(film.law.number(key)) for key in ("viscosity", "length", "bush_radius"))
    speed = np.hypot(*u)
    alpha = np.abs(np.arctan2(e[0] * u[1] - e[1] * u[0], e[0] * u[0] + e[1] * u[1]))
    part = np.minimum(np.hypot(*e), clearance - float(film.boundary)) / clearance
    peak = mu * length**2 * speed / clearance**3 * of_law(law.peak, values, part, alpha)
    return peak, 2.0 * radius * length * speed * of_law(law.leakage, values, part, alpha)


def of_law(method: Callable[..., Array], values: Tree, e: Array, alpha: Array) -> Array:
    """What a film law says: a place where another way to call it may be put."""
    return method(values, e, alpha)


def _across(e: Sequence[Array], v: Sequence[Array]) -> Array:
    """Velocity (n,) [m/s] of the centre of the pin across the eccentricity."""
    size = np.hypot(*e)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(size > 0.0, (e[0] * v[1] - e[1] * v[0]) / size, 0.0)
