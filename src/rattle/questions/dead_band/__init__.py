"""The positions at which friction in the joints holds the mechanism under its loads."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rattle.language.times import Seconds, seconds
from rattle.question import question

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.dead_band.compute import DeadBand
    from rattle.questions.equilibrium.position import Equilibrium


@question(
    asks="The positions at which friction in the joints holds the mechanism under its loads.",
    order=116,
    command="",
    wants=(("between which positions friction holds it", "[dead band](contact.md)"),),
    examples=(("rattle equilibrium F", "m.dead_band()"),),
)
def dead_band(m: Mechanism, t: Seconds = 0.0, *, at: Equilibrium | None = None) -> DeadBand:
    """The positions at which friction in the joints holds the mechanism under its loads, `band["door.angle"]`.

    They are those around the start, or, at=E[0], around an equilibrium; one degree of freedom has to be left, as
    for `holds`.  t: time of the drivers [s].  The motion is followed in steps of a thirty-second of the size of the
    mechanism; where it would not rest for less than that, nothing is noticed.

    `band["door.angle"]`: both ends [SI], of any position of a result.  str(band) says it in words.
    Raises ModelError, AssemblyError, ValueError if friction does not hold it there.

    Source: docs/contact.md.
    """
    from rattle.analyses import arguments
    from rattle.questions.dead_band.compute import dead_band

    return dead_band(m.system, arguments.number("t", seconds(t, "t")), at)
