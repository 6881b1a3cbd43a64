"""Driven motion: position, velocity, acceleration, dead centres."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rattle.language.times import Seconds, times
from rattle.question import question

if TYPE_CHECKING:
    import numpy as np

    from rattle.mechanism import Mechanism
    from rattle.results.result import Result


@question(
    asks="Driven motion: position, velocity, acceleration, dead centres.",
    order=90,
    wants=(("positions, speeds, accelerations of a driven mechanism", "kinematics"),),
    examples=(("rattle kinematics F", "m.kinematics(t)"),),
)
def kinematics(m: Mechanism, t_eval: Seconds | Sequence[Seconds] | np.ndarray, *, strict: bool = False) -> Result:
    """Position, velocity and acceleration [SI] of a fully driven mechanism at increasing times [s].

    Starts from the assembled position at t = 0 and keeps its branch.  A position that cannot be reached ends
    the result there, with success = False and a message and an event that say when, where and why (strict=True
    raises SolverError); points where branches meet are events and notes of `trust`.
    Raises ModelError if a degree of freedom is not driven, and says which bodies can still move.

    Source: Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989), sections 3.6 and 4.5.
    """
    from rattle.questions.kinematics import compute as kinematics

    return kinematics.analyse(m.system, m._start_or_none(), times(t_eval, "t_eval"), forces=False, strict=strict)
