"""A model text as it is drawn: where its bodies and points stand, what stays open, and which freedoms are left.

A text that cannot be put together is drawn all the same, with its joints as nearly closed as they can be: one draws
what does not work yet.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from rattle.analyses.assembly.assembly import has_play, without_play
from rattle.analyses.assembly.start_constants import as_guessed
from rattle.description import file as model_file
from rattle.description.model import Model, is_ground, point_of_ground
from rattle.equations.closure import close_position, open_by
from rattle.equations.dense import dense_rows
from rattle.equations.system import System
from rattle.errors import AssemblyError
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.mechanism import Mechanism

PINS = ("revolute", "fixed")  # joints whose two points are one place
OPEN = 1e-6  # share of the size of the drawing from which on joints that are apart are told
SHUT = 1e-9  # share of the size up to which joints count as closed
POINT = 1e-12  # extent below which a drawing is one place [m], and share of how far away it is
ROUNDS = 60  # of Newton's method
STAND_IN = "nothing"  # a body that a text without bodies is given, so that it can be read
NEARNESS = 1e-6  # weight of the change of a place beside what is open, where joints cannot be closed

Place = tuple[float, float, float]  # x, y, angle [m, m, rad]
Spot = tuple[float, float]  # [m]


def placed(place: Place, spot: Spot) -> Spot:
    """Where a spot of a body that stands at a place is in the plane [m]."""
    c, s = math.cos(place[2]), math.sin(place[2])
    return place[0] + c * spot[0] - s * spot[1], place[1] + s * spot[0] + c * spot[1]


def framed(place: Place, spot: Spot) -> Spot:
    """Where a spot of the plane is in the frame of a body that stands at a place [m]."""
    c, s, dx, dy = math.cos(place[2]), math.sin(place[2]), spot[0] - place[0], spot[1] - place[1]
    return c * dx + s * dy, -s * dx + c * dy


class Pin(NamedTuple):
    """A joint as it is drawn."""

    name: str
    kind: str
    ends: tuple[str, str]  # "body.point" of A and B
    at: Spot  # of A's point [m]
    apart: float  # distance of its points where they should be one [m]


@dataclass(frozen=True)
class Drawn:
    """What a model text looks like at its start, without play.

    Raises ModelError where the text cannot be read.
    """

    text: str
    document: dict[str, Any]
    mechanism: Mechanism
    places: Mapping[str, Place]  # of all bodies
    trouble: str = ""  # why it cannot be put together
    system: System | None = None  # None for a text without bodies
    stand_in: bool = False

    @property
    def model(self) -> Model:
        """What the text says."""
        return self.mechanism.model

    @property
    def bodies(self) -> list[str]:
        """The bodies that move."""
        return [] if self.stand_in else [name for name in self.model.bodies if not is_ground(name)]

    @cached_property
    def points(self) -> dict[str, Spot]:
        """Where all points of the ground and of bodies are, by "body.point" [m]."""
        spots = {f"ground.{name}": (float(x), float(y)) for name, (x, y) in self.model.ground.items()}
        for body in self.bodies:
            spots |= {
                f"{body}.{name}": self.in_plane(body, spot) for name, spot in self.model.bodies[body].points.items()
            }
        return spots

    def in_plane(self, body: str, spot: Spot) -> Spot:
        """Where a spot in the frame of a body is in the plane [m]."""
        return spot if body == "ground" else placed(self.places[body], spot)

    def in_frame(self, body: str, spot: Spot) -> Spot:
        """Where a spot of the plane is in the frame of a body [m]."""
        return spot if body == "ground" else framed(self.places[body], spot)

    @cached_property
    def size(self) -> float:
        """Largest extent of the drawing [m]; 1 where there is none, or rounding alone."""
        spots = np.array(list(self.points.values()) or [(0.0, 0.0)])
        size = float(np.ptp(spots, axis=0).max(initial=0.0))
        return size if size > POINT * (1.0 + float(np.abs(spots).max())) else 1.0

    @cached_property
    def pins(self) -> list[Pin]:
        """All joints with two ends."""
        return list(self._pins())

    def _pins(self) -> Iterator[Pin]:
        for name, joint in {} if self.stand_in else self.model.joints.items():
            ends = [self._end(name, k) for k in range(2)]
            if not all(end in self.points for end in ends):
                continue
            a, b = (self.points[end] for end in ends)
            apart = math.dist(a, b) if joint.kind in PINS else 0.0
            yield Pin(name, joint.kind, (ends[0], ends[1]), a, apart)

    def _end(self, joint: str, side: int) -> str:
        point = (self.model.joints[joint].a, self.model.joints[joint].b)[side]
        moving = point_of_ground(point.body)
        return f"ground.{moving}" if moving else f"{point.body}.{point.name}"

    def joined(self, point: str) -> list[str]:
        """All points that joints put at the place of this one, itself first; a block is where it is drawn."""
        group, ahead = [point], [point]
        while ahead:
            now = ahead.pop()
            for pin in self.pins:
                if now in pin.ends and self.together(pin):
                    other = pin.ends[1] if pin.ends[0] == now else pin.ends[0]
                    if other not in group:
                        group.append(other)
                        ahead.append(other)
        return group

    def together(self, pin: Pin) -> bool:
        """True for a joint whose points are one place, which a drag takes along."""
        if pin.kind == "prismatic":
            return math.dist(*(self.points[end] for end in pin.ends)) <= 1e-9 * self.size
        return pin.kind in PINS

    @cached_property
    def grounded(self) -> set[str]:
        """Bodies that joints connect with the ground, directly or by others."""
        return reached(self.document)

    @cached_property
    def open_joints(self) -> list[Pin]:
        """Pins whose points are apart."""
        return [pin for pin in self.pins if pin.apart > OPEN * self.size]


def reached(document: Mapping[str, Any], start: str = "ground", moving: bool = False) -> set[str]:
    """Bodies that joints of a document connect with this one; moving: not by way of the ground."""
    near: dict[str, set[str]] = {}
    for joint in document.get("joints", {}).values():
        ends = joint.get("connect", ()) if isinstance(joint, Mapping) else ()
        bodies = [str(end).partition(".")[0] for end in ends]
        if len(bodies) == 2:
            near.setdefault(bodies[0], set()).add(bodies[1])
            near.setdefault(bodies[1], set()).add(bodies[0])
    known, ahead = {start}, [start]
    while ahead:
        for body in near.get(ahead.pop(), ()):
            if body not in known and not (moving and body == "ground"):
                known.add(body)
                ahead.append(body)
    return known - {"ground"}


def drawn(text: str, file: str = "", before: Mapping[str, Place] | None = None) -> Drawn:
    """Draw a model text; before: where bodies were, for what cannot be put together.  Raises ModelError."""
    document = model_file.parse(text)
    if not document.get("bodies"):
        return _without_bodies(text, document, file)
    return drawn_mechanism(text, document, Mechanism.from_text(text, file), before or {})


def drawn_mechanism(text: str, document: dict[str, Any], m: Mechanism, before: Mapping[str, Place]) -> Drawn:
    """Draw a mechanism whose text has been read.  Raises ModelError."""
    functions.start()  # one drawing follows the other: machine code pays
    guess = _Guess(m, before) if before else None
    if guess is not None and not guess.closes():  # to look everywhere for a closing would take seconds
        return Drawn(text, document, m, _by_body(*guess.nearly()), guess.why, guess.system)
    try:
        system, q = _closed(m)
        trouble = ""
    except AssemblyError as error:
        system, q = (guess or _Guess(m, before)).nearly()
        trouble = str(error)
    return Drawn(text, document, m, _by_body(system, q), trouble, system)


def _without_bodies(text: str, document: dict[str, Any], file: str) -> Drawn:
    body = {STAND_IN: {"points": {"P": [0, 0]}, "mass": 1, "inertia": 1}}
    m = Mechanism.from_text(model_file.dump_json({**document, "bodies": body}), file)
    return Drawn(text, document, m, {STAND_IN: (0.0, 0.0, 0.0)}, stand_in=True)


def _by_body(system: System, q: np.ndarray) -> dict[str, Place]:
    rows = q.reshape(-1, 3)
    return {name: (float(x), float(y), float(angle)) for name, (x, y, angle) in zip(system.bodies, rows, strict=True)}


def _closed(m: Mechanism) -> tuple[System, np.ndarray]:
    """The mechanism without play where it closes.  Raises AssemblyError."""
    system = m.system
    if has_play(system.model):
        shut, start = without_play(system)
        if isinstance(start, AssemblyError):
            raise start
        return shut, start.q
    return system, m.start.q


class _Guess:
    """A mechanism as [initial] has it and as it was before: whether it closes near there, and how nearly it does."""

    def __init__(self, m: Mechanism, before: Mapping[str, Place]) -> None:
        self.system, guess = as_guessed(m.model)
        self.workspace = self.system.workspace()
        self.rates = np.zeros_like(guess)
        as_before = guess.copy()
        for k, name in enumerate(self.system.bodies):
            as_before[3 * k : 3 * k + 3] = before.get(name, guess[3 * k : 3 * k + 3])
        self.guesses = [guess, as_before]

    @property
    def why(self) -> str:
        """That it is open, in words."""
        return "the joints do not close near where they are drawn"

    def residuals(self, q: np.ndarray) -> np.ndarray:
        """What the joints are open by at these positions [m or rad]."""
        open_by(self.workspace, 0.0, q, self.rates)
        return np.array(self.workspace.rows[:, at.RES])

    def closes(self) -> bool:
        """True if Newton's method closes the joints from one of the guesses."""
        return any(self._closes(guess.copy()) for guess in self.guesses)

    def _closes(self, q: np.ndarray) -> bool:
        if not np.isfinite(self.residuals(q)).all():
            return False
        shut = SHUT * self.system.size
        gap, _ = close_position(self.workspace, 0.0, q, np.zeros_like(q), shut, ROUNDS)
        return bool(gap <= shut)

    def nearly(self) -> tuple[System, np.ndarray]:
        """Places where the joints are as nearly closed as can be, near the better guess."""
        from scipy.optimize import least_squares

        gaps = [float(np.linalg.norm(np.nan_to_num(self.residuals(q), nan=math.inf))) for q in self.guesses]
        start, system = self.guesses[int(np.argmin(gaps))], self.system
        if not len(system.rows) or not math.isfinite(min(gaps)):
            return system, start
        scale = np.tile([1.0, 1.0, 1.0 / system.size], system.body_count)

        def merit(z: np.ndarray) -> np.ndarray:
            return np.concatenate([np.nan_to_num(self.residuals(start + z * scale), nan=1e3), NEARNESS * z])

        def slope(z: np.ndarray) -> np.ndarray:
            self.residuals(start + z * scale)
            return np.vstack([dense_rows(system, self.workspace) * scale, NEARNESS * np.eye(len(z))])

        solved = least_squares(merit, np.zeros_like(start), slope, max_nfev=60)
        return system, start + solved.x * scale
