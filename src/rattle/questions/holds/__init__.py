"""The values of one load for which friction in the joints holds the mechanism at rest."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rattle.language.times import Seconds, seconds
from rattle.question import question

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.equilibrium.position import Equilibrium
    from rattle.questions.holds.holding_range import HoldingRange


@question(
    asks="The values of one load for which friction in the joints holds the mechanism at rest.",
    order=113,
    command="",
    wants=(("which load friction holds, whether it locks itself or jams", "[impending motion](contact.md)"),),
    examples=(("rattle equilibrium F --holds push", 'm.holds("push")'),),
)
def holds(m: Mechanism, load: str, t: Seconds = 0.0, *, at: Equilibrium | None = None) -> HoldingRange:
    """The values of one load for which friction in the joints holds the mechanism at rest: `m.holds("push")`.

    load: name of a load, of a driver (then of its effort) or "gravity"; all other loads stay as they are.  Values
    are [N] of a force along its present direction, [N*m] of a torque, multiples of what has no single value.
    t: time of the drivers [s].  The position is that of the start, or, at=E[0], of an equilibrium.
    One degree of freedom has to be left, without contacts and play.

    Both ends are where motion is impending, all joints at mu_static and pressed by the load that overcomes them:
    `h.low`, `h.high`; `h.free` without friction.  `h.jams`: an end is infinite, no load of any size moves it that
    way; `h.jams_from`: with how many times the friction it would.  `h.self_locking`: the other loads alone do not
    move it.  `h.rests`: as it is.  str(h) says it in words.
    Raises ModelError, AssemblyError, ValueError for a load that is not there or cannot move the mechanism.

    Source: docs/contact.md; Meriam, Kraige, Engineering Mechanics: Statics, chapter 6.
    """
    from rattle.analyses import arguments
    from rattle.questions.holds.compute import holding_range

    return holding_range(m.system, load, arguments.number("t", seconds(t, "t")), at)
