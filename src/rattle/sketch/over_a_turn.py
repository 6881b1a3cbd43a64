"""What is drawn over a turn of the motor: paths of places, and the curves of instant centres."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rattle.analyses.driver_period import driver_period
from rattle.description.model import GROUND
from rattle.errors import InputError, suggest
from rattle.mechanism import Mechanism
from rattle.sketch.measure import unused_name
from rattle.sketch.spots import Place, spot

if TYPE_CHECKING:
    from rattle.results.result import Result

POINTS = 181  # positions over a turn, every two degrees
FAR = 100.0  # sizes of the mechanism from which on an instant centre is not drawn: bodies hardly turn there


class Path(NamedTuple):
    """The path of a place."""

    label: str
    t: np.ndarray  # (n,) [s]
    x: np.ndarray  # (n,) [m], in the ground plane
    y: np.ndarray
    signals: Mapping[str, str]  # entries of [signals] for x and y: name and expression
    words: str  # why it is no whole turn, "" if it is one


class Centrodes(NamedTuple):
    """Instant centres of a body relative to another: of those curves one rolls on the other without slip."""

    label: str
    t: np.ndarray  # (n,) [s]
    fixed: np.ndarray  # (n, 2) [m] in the frame of the other body; nan where both hardly turn relative to each other
    moving: np.ndarray  # (n, 2) [m] in the frame of the body
    signals: Mapping[str, str]  # of the centre in the ground plane
    words: str  # why it is no whole turn, "" if it is one


def path(m: Mechanism, place: Place) -> Path:
    """The path of a place over a turn of the motor, every play closed; see `paths`."""
    return paths(m, [place])[0]


def paths(m: Mechanism, places: Sequence[Place]) -> list[Path]:
    """Paths of places over a turn of the first motor that turns steadily, else over the time of a run.

    Raises InputError for an unknown place, ModelError unless motors determine the motion, AssemblyError.
    """
    spots = [spot(m, place) for place in places]
    turn, words = _turn(m)
    drawn, taken = [], list[str]()
    for end in spots:
        point = end.point
        x, y = point.at
        origin, angle = _frame(turn, point.body)
        c, s = np.cos(angle), np.sin(angle)
        names = [unused_name(m, f"path_{key}", taken) for key in "xy"]
        taken += names
        at = origin + np.stack([c * x - s * y, s * x + c * y], axis=1)
        signals = dict(zip(names, (end.x, end.y), strict=True))
        drawn.append(Path(f"path of {end.label}", turn.t, at[:, 0], at[:, 1], signals, words))
    return drawn


def centrodes(m: Mechanism, body: str, other: str = GROUND) -> Centrodes:
    """Fixed and moving centrode of a body relative to another one, over a turn of the motor; see `paths`."""
    known = [*m.model.moving_bodies, GROUND]
    for name in (body, other):
        if name not in known:
            raise InputError(f"there is no body '{name}'{suggest(name, known)}")
    if body == other:
        raise InputError(f"centrodes are of two bodies, got '{body}' twice")
    turn, words = _turn(m)
    turning, at_origin = _rates(turn, body, other)
    with np.errstate(divide="ignore", invalid="ignore"):
        centre = np.stack([-at_origin[:, 1] / turning, at_origin[:, 0] / turning], axis=1)
    size = m.system.size
    near = np.hypot(*(centre - _frame(turn, body)[0]).T) < FAR * size  # False for nan too
    centre[~near] = np.nan
    if not near.any():
        words = f"'{body}' does not turn relative to '{other}': there is no instant centre"
    names = [unused_name(m, f"centre_{key}") for key in "xy"]
    signals = dict(zip(names, _centre(body, other), strict=True))
    label = f"instant centre of {body} relative to {other}"
    return Centrodes(label, turn.t, _seen(turn, other, centre), _seen(turn, body, centre), signals, words)


def _turn(m: Mechanism) -> tuple[Result, str]:
    """Positions over a turn of the motor, and why they are not a whole one."""
    if not m.model.motors:
        raise InputError("nothing drives the mechanism: a path over a turn needs a motor")
    ideal = m.ideal()
    period = driver_period(ideal.system)
    end = period if period is not None else m.model.settings.t_end
    turn = ideal.kinematics(np.linspace(0.0, end, POINTS))
    if not turn.success:
        return turn, turn.message
    return turn, "" if period is not None else f"no motor turns steadily: over the {end:g} s of a run"


def _frame(turn: Result, body: str) -> tuple[np.ndarray, np.ndarray]:
    """Origin (n, 2) [m] and angle (n,) [rad] of the frame of a body."""
    if body == GROUND:
        return np.zeros((len(turn.t), 2)), np.zeros(len(turn.t))
    return np.stack([turn[f"{body}.x"], turn[f"{body}.y"]], axis=1), np.asarray(turn[f"{body}.angle"])


def _rates(turn: Result, body: str, other: str) -> tuple[np.ndarray, np.ndarray]:
    """Rate (n,) [rad/s] of a body relative to another, and its velocity (n, 2) [m/s] where the ground's origin is."""
    turning, velocity = np.zeros(len(turn.t)), np.zeros((len(turn.t), 2))
    for sign, name in ((1.0, body), (-1.0, other)):
        if name != GROUND:
            x, y, vx, vy, omega = (turn[f"{name}.{key}"] for key in ("x", "y", "vx", "vy", "omega"))
            turning += sign * omega
            velocity += sign * np.stack([vx + omega * y, vy - omega * x], axis=1)
    return turning, velocity


def _centre(body: str, other: str) -> tuple[str, str]:
    """Expressions of the instant centre in the ground plane."""
    turning, x, y = "", "", ""
    for sign, name in (("", body), (" - ", other)):
        if name != GROUND:
            turning += f"{sign}{name}.omega"
            x += f"{sign}({name}.vx + {name}.omega*{name}.y)"
            y += f"{sign}({name}.vy - {name}.omega*{name}.x)"
    return f"(0 - ({y}))/({turning})", f"({x})/({turning})"


def _seen(turn: Result, body: str, places: np.ndarray) -> np.ndarray:
    """Places (n, 2) of the ground plane in the frame of a body [m]."""
    origin, angle = _frame(turn, body)
    (x, y), c, s = (places - origin).T, np.cos(angle), np.sin(angle)
    return np.stack([c * x + s * y, c * y - s * x], axis=1)
