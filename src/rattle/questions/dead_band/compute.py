"""Positions around one at which friction holds the mechanism under the loads as they are: its dead band.

The one degree of freedom is followed to both sides.  At every position the force along the motion that friction would
hold is an interval (`one_motion`); the mechanism rests where it contains zero.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from rattle.equations.system import System
from rattle.errors import InputError
from rattle.questions.equilibrium.balance import StaticProblem
from rattle.questions.equilibrium.position import Equilibrium
from rattle.questions.equilibrium.starts import apart
from rattle.questions.holds.compute import left_out, position_asked
from rattle.questions.holds.one_motion import evaluated, impending, one_motion
from rattle.results.display import lines, scale

STRIDES = 32  # positions looked at over a way as long as the mechanism is large
MOST = 320  # positions looked at on either side, at most
MOST_SHOWN = 3  # coordinates in words
HALVINGS = 50  # of the stride in which the end lies
SLIPS, ENDS, OPEN, CLOSED = "it slips", "the motion ends", "it still rests, no farther looked", "it rests all around"


@dataclass(frozen=True, repr=False)
class DeadBand:
    """Two positions between which friction holds the mechanism at rest: `band["door.angle"]` are both values [SI]."""

    t: float  # [s]
    first: Equilibrium = field(repr=False)  # one end; its forces are those without friction
    last: Equilibrium = field(repr=False)  # the other
    ends: tuple[str, str]  # what ends it there, in words
    shown: tuple[str, ...] = ()  # coordinates of the joints that rub
    notes: tuple[str, ...] = ()  # what is left out

    def __getitem__(self, name: str) -> tuple[float, float]:
        """A position by its result name at both ends [m or rad].  Raises UnknownName, ValueError for a force."""
        if self.first.unit(name) not in ("m", "rad"):
            raise InputError(f"'{name}' is no position; m.holds gives what friction holds")
        return self.first[name], self.last[name]

    def __repr__(self) -> str:
        return f"<rattle.DeadBand: {str(self).splitlines()[0]}>"

    def _repr_html_(self) -> str:
        return lines(str(self))

    def __str__(self) -> str:
        if CLOSED in self.ends:
            words = "friction holds it in every position of its motion"
        else:
            ways = [f"{name} {self._said(name, 0)} to {self._said(name, 1)}" for name in self.shown[:MOST_SHOWN]]
            words = f"friction holds it from {', '.join(ways)}"
            others = [f"at {self._said(self.shown[0], k)} {end}" for k, end in enumerate(self.ends) if end != SLIPS]
            words += f" ({'; '.join(others)})" if others else ""
        return "\n".join([words, *(f"note: {note}" for note in self.notes)])

    def _said(self, name: str, end: int) -> str:
        values = self[name]
        factor, unit = scale(self.first.unit(name), max(map(abs, values)))
        return f"{factor * values[end]:.6g} {unit}"


def dead_band(system: System, t: float, at_rest: Equilibrium | None) -> DeadBand:
    """The dead band around the start or around an equilibrium; see `Mechanism.dead_band`."""
    original, system, t, q = position_asked(system, t, at_rest)
    problem = StaticProblem(system, t)
    z = one_motion(system, evaluated(system, t, q), None).z
    if not _rests(system, t, q):
        raise InputError("friction does not hold it at this position: it moves under the loads as they are")
    followed = []
    for direction in (z, -z):
        followed.append(_followed(problem, q, direction))
        if followed[0][1] == CLOSED:
            followed.append(followed[0])
            break
    ends = [(problem.finish(position, 0), beyond) for position, beyond in followed]
    shown = _coordinates(system)
    ends.sort(key=lambda end: end[0][shown[0]])
    (first, before), (last, beyond) = ends
    return DeadBand(t, first, last, (before, beyond), shown, left_out(original))


def _coordinates(system: System) -> tuple[str, ...]:
    """Names of the coordinates of the joints whose friction holds."""
    joints = {
        name: joint for name, joint in system.model.joints.items() if joint.friction and joint.friction.law is None
    }
    return tuple(f"{name}.{joint.leaf.coordinate}" for name, joint in joints.items())


def _rests(system: System, t: float, q: np.ndarray) -> bool:
    """True if friction holds the mechanism at q (3 nb,) [m, m, rad].  Raises InputError where that is not known."""
    workspace = evaluated(system, t, q)
    motion = one_motion(system, workspace, None)
    if motion.free == 0.0:
        return True
    sense = -math.copysign(1.0, motion.free)  # the way it would move without friction
    return sense * impending(system, workspace, motion, sense, far=False).load >= 0.0


def _followed(problem: StaticProblem, start: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, str]:
    """The last position (3 nb,) at which it rests on the way in a direction (3 nb,), and what is beyond."""
    system, stride = problem.system, problem.system.size / STRIDES
    q, way = start.copy(), direction.copy()
    for n in range(MOST):
        ahead, turned = q.copy(), way.copy()
        if not problem.walk(ahead, turned, stride)[0]:
            return q, ENDS
        if n > 2 and apart(system, ahead, start[None])[0] < stride:
            return start, CLOSED
        try:
            holds = _rests(system, problem.t, ahead)
        except ValueError:  # a singular position, or loads without a value
            return q, ENDS
        if not holds:
            return _end(problem, q, way, stride), SLIPS
        q, way = ahead, turned
    return q, OPEN


def _end(problem: StaticProblem, start: np.ndarray, direction: np.ndarray, stride: float) -> np.ndarray:
    """The last position (3 nb,) at which it rests, less than `stride` [m] beyond a position, by bisection."""
    low, high, resting = 0.0, 1.0, start
    for _ in range(HALVINGS):
        share = 0.5 * (low + high)
        q = start.copy()
        went = problem.walk(q, direction.copy(), share * stride)[0]
        if went and _rests(problem.system, problem.t, q):
            low, resting = share, q
        else:
            high = share
    return resting
