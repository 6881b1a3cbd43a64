"""Natural frequencies about an equilibrium."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rattle.language.times import Seconds, seconds
from rattle.question import question

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.equilibrium.position import Equilibrium
    from rattle.questions.modes.compute import Modes


@question(
    asks="Natural frequencies about an equilibrium.",
    order=120,
    wants=(("at which frequencies it vibrates about that equilibrium", "modes"),),
    examples=(("rattle modes F", "m.modes()"),),
)
def modes(m: Mechanism, t: Seconds = 0.0, equilibrium: Equilibrium | None = None, *, effort: float = 1.0) -> Modes:
    """Natural frequencies [Hz], damping ratios, growth [1/s] and shapes about an equilibrium, all forces together.

    Pins with clearance are massless links that press, those in oil float.  The stiffness of a film under a pin that
    turns is not symmetric: a mode that grows by it is oil whirl, and named so with its frequency over the turning
    speed (`.whirl`: the film of each mode).  Matrices are exact derivatives or differences: see `.how`.
    t: time of the drivers [s].  equilibrium: default the first of `equilibrium(t)`.  effort: as of `equilibrium`.
    Raises ValueError if there is no equilibrium, or the one given is not one of this mechanism.
    """
    from rattle.analyses import arguments
    from rattle.questions.equilibrium.compute import static_problem
    from rattle.questions.modes.compute import modes, own_problem

    effort = arguments.effort(effort)
    if equilibrium is not None:
        return modes(own_problem(m.system, equilibrium), equilibrium)
    equilibria = m.equilibrium(seconds(t, "t"), effort=effort)
    first = equilibria.first_at(seconds(t, "t"))
    return modes(static_problem(m.system, first, sticks=True), first, equilibria.note)
