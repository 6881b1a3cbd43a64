"""Joints that rub in a motion with its derivatives: in which sense each slips, or that it sticks, and until when.

    slips:   g = s w.v = 0       ends it, and it sticks if it can
    sticks:  g = mu_static L - |tau| = 0       ends it, and it slips as tau pushed

g ends a mode as the gap does a contact, with the same jump of the derivatives: see `contacts`.  What is brought to
rest has no rate any more, and no derivative of it.  Forces may jump with a mode, so others are looked at then.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rattle.analyses.straight_line.linearised import Linearised
from rattle.analyses.straight_line.recorded_model import RubbingFunctions
from rattle.questions.sensitivity.functions import Functions
from rattle.solvers.dry_friction_modes import OVER
from rattle.trace.lane_program import Compile

FIRM = 2.0  # size of a mode: it rests at its limit, as others hold it that stick


class Rubbed(NamedTuple):
    """Joints that rub at an instant; rows by joint (n,)."""

    left: np.ndarray  # what is above zero while a mode lasts
    by_left: np.ndarray  # (n, k) its derivatives by parameters
    left_in_time: np.ndarray
    rate: np.ndarray  # [m/s or rad/s], 0 where it may be rounding
    force: np.ndarray  # [N or N m]
    limit: np.ndarray  # of it
    ahead: np.ndarray  # acceleration against that of sticking, 0 where friction takes care of it
    held: np.ndarray  # True: it can move only as others do that stick


class Rubbing:
    """The joints of a model that rub; `modes` (n,): 0 sticks, 1 or -1 slips, 2 or -2 rests at its limit."""

    def __init__(self, functions: Functions, rubs: RubbingFunctions, compile_function: Compile) -> None:
        self.functions, graph, joints = functions, functions.model.graph, rubs.joints
        told = [
            *rubs.left, *(x.rate for x in joints), *(x.force for x in joints),
            *(x.reserve + abs(x.force) for x in joints), *(x.ahead for x in joints), *(x.stuck for x in joints),
        ]  # fmt: skip
        self._look = Linearised(graph, told, compile_function)
        self._rest = Linearised(graph, rubs.rested, compile_function)
        self.modes = np.zeros(len(joints))

    def seen(self, t: float, z: np.ndarray, rate: np.ndarray) -> Rubbed:
        """The joints at t [s] and z; rate: dy/dt (ny,)."""
        values, slopes = self._look(*self.functions.directions(t, z, rate))
        left, slip, force, limit, ahead, held = values.reshape(6, -1)
        by_left = slopes[: len(left)]
        return Rubbed(left, by_left[:, :-1], by_left[:, -1], slip, force, limit, ahead, held > 0.5)

    def rested(self, t: float, z: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """z (ny, 1 + k) with joints that stick at rest, and how y changes along the motion then (ny,)."""
        values, slopes = self._rest(*self.functions.directions(t, z, rate))
        return np.column_stack([values, slopes[:, :-1]]), slopes[:, -1]

    def ended(self, n: int, seen: Rubbed) -> float:
        """The mode that joint n tries first once its own has ended."""
        if self.modes[n] != 0.0:
            return 0.0
        return float(-FIRM * np.sign(seen.force[n]) if seen.force[n] != 0.0 else np.sign(seen.ahead[n]))

    def settled(self, seen: Rubbed) -> np.ndarray:
        """(n,) modes to which the forces at an instant lead: the same ones if these can last.

        What others move slips as they do.  Of those that stick beyond their limits the worst one rests at its limit
        first, and slips if no others hold it.
        """
        sticks, ahead = self.modes == 0.0, np.sign(seen.ahead)
        size = np.abs(seen.force)
        beyond = np.where(sticks & (size > seen.limit * (1.0 + OVER)), (size - seen.limit) / (size + seen.limit), 0.0)
        over = (beyond > 0.0) & (beyond >= beyond.max(initial=0.0))
        stuck = np.where(ahead != 0.0, ahead, np.where(over, -FIRM * np.sign(seen.force), 0.0))
        sense, rests = np.sign(self.modes), seen.rate == 0.0
        back = rests & (sense * ahead < 0.0)
        slips = np.where(back, 0.0, np.where(seen.held & rests, FIRM * sense, sense))
        return np.where(sticks, stuck, slips)
