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
from rattle.equations.closure import open_by
from rattle.equations.dense import dense_rows
from rattle.equations.system import System
from rattle.errors import AssemblyError
from rattle.jit import layout as at
from rattle.mechanism import Mechanism

OPEN = 1e-6  # share of the size of the drawing from which on joints that are apart are told
TOGETHER = 1e-6  # share of the size within which points that joints connect are one place
STAND_IN = "nothing"  # a body that a text without bodies is given, so that it can be read
NEARNESS = 1e-6  # weight of the change of a place beside what is open, where joints cannot be closed

Place = tuple[float, float, float]  # x, y, angle [m, m, rad]
Spot = tuple[float, float]  # [m]


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
        if body == "ground":
            return spot
        x, y, angle = self.places[body]
        c, s = math.cos(angle), math.sin(angle)
        return x + c * spot[0] - s * spot[1], y + s * spot[0] + c * spot[1]

    def in_frame(self, body: str, spot: Spot) -> Spot:
        """Where a spot of the plane is in the frame of a body [m]."""
        if body == "ground":
            return spot
        x, y, angle = self.places[body]
        c, s = math.cos(angle), math.sin(angle)
        dx, dy = spot[0] - x, spot[1] - y
        return c * dx + s * dy, -s * dx + c * dy

    @cached_property
    def size(self) -> float:
        """Largest extent of the drawing [m]; 1 where there is none."""
        spots = np.array(list(self.points.values()) or [(0.0, 0.0)])
        return float(np.ptp(spots, axis=0).max(initial=0.0)) or 1.0

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
            apart = math.dist(a, b) if joint.kind in ("revolute", "weld", "fixed") else 0.0
            yield Pin(name, joint.kind, (ends[0], ends[1]), a, apart)

    def _end(self, joint: str, side: int) -> str:
        point = (self.model.joints[joint].a, self.model.joints[joint].b)[side]
        moving = point_of_ground(point.body)
        return f"ground.{moving}" if moving else f"{point.body}.{point.name}"

    def joined(self, point: str) -> list[str]:
        """All points that pins put at the place of this one, itself first."""
        group, ahead = [point], [point]
        while ahead:
            now = ahead.pop()
            for pin in self.pins:
                if pin.kind == "revolute" and now in pin.ends:
                    other = pin.ends[1] if pin.ends[0] == now else pin.ends[0]
                    if other not in group:
                        group.append(other)
                        ahead.append(other)
        return group

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
    m.model  # noqa: B018  reads it: problems of the text are problems here
    try:
        system, q = _closed(m)
        trouble = ""
    except AssemblyError as error:
        trouble = str(error)
        system, q = _nearly_closed(m, before)
    return Drawn(text, document, m, _by_body(system, q), trouble, system)


def _without_bodies(text: str, document: dict[str, Any], file: str) -> Drawn:
    body = {STAND_IN: {"points": {"P": [0, 0]}, "mass": 1, "inertia": 1}}
    m = Mechanism.from_text(model_file.dump_json({**document, "bodies": body}), file)
    m.model  # noqa: B018
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


def _nearly_closed(m: Mechanism, before: Mapping[str, Place]) -> tuple[System, np.ndarray]:
    """Places where the joints are as nearly closed as can be, near those that bodies had."""
    from scipy.optimize import least_squares

    system, guess = as_guessed(m.model)
    rates = np.zeros_like(guess)
    workspace = system.workspace()
    as_before = guess.copy()
    for k, name in enumerate(system.bodies):
        as_before[3 * k : 3 * k + 3] = before.get(name, guess[3 * k : 3 * k + 3])

    def residuals(q: np.ndarray) -> np.ndarray:
        open_by(workspace, 0.0, q, rates)
        return np.array(workspace.rows[:, at.RES])

    gaps = [(float(np.linalg.norm(np.nan_to_num(residuals(q), nan=math.inf))), q) for q in (guess, as_before)]
    start = min(gaps, key=lambda pair: pair[0])[1]
    if not len(system.rows) or not np.isfinite(residuals(start)).all():
        return system, start
    scale = np.tile([1.0, 1.0, 1.0 / system.size], system.body_count)

    def merit(z: np.ndarray) -> np.ndarray:
        return np.concatenate([np.nan_to_num(residuals(start + z * scale), nan=1e3), NEARNESS * z])

    def slope(z: np.ndarray) -> np.ndarray:
        residuals(start + z * scale)
        return np.vstack([dense_rows(system, workspace) * scale, NEARNESS * np.eye(len(z))])

    solved = least_squares(merit, np.zeros_like(start), slope, max_nfev=60)
    return system, start + solved.x * scale
