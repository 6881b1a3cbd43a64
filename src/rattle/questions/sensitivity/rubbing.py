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
from rattle.trace.lane_program import Compile
from rattle.trace.recorded_friction import Joint, ended, settled


class Rubbed(NamedTuple):
    """Joints that rub at an instant; rows by joint (n,)."""

    left: np.ndarray  # what is above zero while a mode lasts
    by_left: np.ndarray  # (n, k) its derivatives by parameters
    left_in_time: np.ndarray
    joints: list[Joint]

    @property
    def rests(self) -> np.ndarray:
        """(n,) True where a rate may be rounding."""
        return np.array([joint.rate == 0.0 for joint in self.joints])


class Rubbing:
    """The joints of a model that rub; `modes` (n,): 0 sticks, 1 or -1 slips, 2 or -2 rests at its limit."""

    def __init__(self, functions: Functions, rubs: RubbingFunctions, compile_function: Compile) -> None:
        self.functions, graph, joints = functions, functions.model.graph, rubs.joints
        self._look = Linearised(graph, [*rubs.left, *(x for joint in joints for x in joint)], compile_function)
        self._rest = Linearised(graph, rubs.rested, compile_function)
        self.modes = np.zeros(len(joints))

    def seen(self, t: float, z: np.ndarray, rate: np.ndarray) -> Rubbed:
        """The joints at t [s] and z; rate: dy/dt (ny,)."""
        values, slopes = self._look(*self.functions.directions(t, z, rate))
        count = len(self.modes)
        joints = [Joint(*row) for row in values[count:].reshape(count, -1).tolist()]
        return Rubbed(values[:count], slopes[:count, :-1], slopes[:count, -1], joints)

    def rested(self, t: float, z: np.ndarray, rate: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """z (ny, 1 + k) with joints that stick at rest, and how y changes along the motion then (ny,)."""
        values, slopes = self._rest(*self.functions.directions(t, z, rate))
        return np.column_stack([values, slopes[:, :-1]]), slopes[:, -1]

    def ended(self, n: int, seen: Rubbed) -> float:
        """The mode that joint n tries first once its own has ended."""
        return float(ended(float(self.modes[n]), seen.joints[n]))

    def settled(self, seen: Rubbed) -> np.ndarray:
        """(n,) modes to which the forces at an instant lead: the same ones if these can last."""
        return np.array(settled(self.modes.tolist(), seen.joints))
