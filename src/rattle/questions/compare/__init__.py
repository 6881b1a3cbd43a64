"""One page: ideal joint, massless link, one-sided impact and compliant contact side by side."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rattle.language.times import Seconds, seconds_or_none
from rattle.question import question

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.compare.compute import Comparison


@question(
    asks="One page: ideal joint, massless link, one-sided impact and compliant contact side by side.",
    order=70,
)
def compare(
    m: Mechanism, *, joint: str | None = None, curve: str | Sequence[str] | None = None, t_end: Seconds | None = None,
    law: str | None = None, progress: bool = False,
) -> Comparison:  # fmt: skip
    """The mechanism with ideal joints, massless links, impact, compliant contacts and oil, side by side.

    joint: whose force and orbit are shown (default: the first with clearance).  curve: of the motion, or
    several (default: one of the last body).  t_end: [s] (default: one turn of the driver).  law: normal force law
    of the compliant run.  Raises ModelError if no joint has a clearance, UnknownName.
    """
    from rattle.questions.compare.compute import compare

    return compare(m, joint=joint, curve=curve, t_end=seconds_or_none(t_end, "t_end"), law=law, progress=progress)
