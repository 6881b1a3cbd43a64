"""How far the play of the joints lets an output deviate, and which joint to tighten first."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rattle.language.times import Seconds, times
from rattle.question import FormField, Tab, question

if TYPE_CHECKING:
    import numpy as np

    from rattle.mechanism import Mechanism
    from rattle.questions.accuracy.compute import Accuracy


@question(
    asks="How far the play of the joints lets an output deviate, and which joint to tighten first.",
    order=130,
    wants=(("how accurate it is when its joints have play", "accuracy"),),
    examples=(("rattle accuracy F --of rocker.angle", 'm.accuracy("rocker.angle", t)'),),
    tab=Tab("accuracy", "Accuracy", 30, (FormField("of", "of", usual="output", offers_curves=True, size=22),)),
)
def accuracy(
    m: Mechanism,
    of: str,
    t_eval: Seconds | Sequence[Seconds] | np.ndarray,
    *,
    extremes: bool = True,
    loaded: bool = True,
) -> Accuracy:
    """How far the play of the joints lets one output deviate [SI], at given times [s].

    of: a name of a result of `inverse_dynamics`, such as "rocker.angle" or "coupler.P.x", or a signal.
    extremes: also the exact extremes over all positions of the pins in their circles.
    loaded: also the deviation where the loads press the pins (equilibrium), for comparison.
    Raises ModelError if the mechanism without play is not fully driven or no joint has a clearance, UnknownName.

    Source: docs/theory.md, section 7; Ting, Zhu, Watkins, The effects of joint clearance on position and
    orientation deviation of linkages and manipulators, Mech. Mach. Theory 35 (2000) 391-401.
    """
    from rattle.questions.accuracy.compute import accuracy

    return accuracy(m.system, of, times(t_eval, "t_eval"), extremes=extremes, loaded=loaded)
