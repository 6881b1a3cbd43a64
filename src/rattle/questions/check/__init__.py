"""Is the model as meant? Bodies, joints, mobility, redundant joints, loops, range of the driver."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rattle.question import question

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.check.compute import Check


@question(
    asks="Is the model as meant? Bodies, joints, mobility, redundant joints, loops, range of the driver.",
    order=30,
    wants=(("is it assembled as meant, how far can the driver go", "check"),),
    examples=(("rattle check F", "m.check()"),),
)
def check(m: Mechanism) -> Check:
    """Bodies, joints, mobility, redundant constraints, loops, branch, range of the driver; str() is a short report.

    Ranges of drivers in deg or m.  Raises ModelError, AssemblyError.
    """
    from rattle.analyses.assembly.computable import computable
    from rattle.questions.check.compute import check

    system, start = m.system, m.start
    with computable(m._file):
        return check(system, start, {name: m.written_unit(name) for name in m.model.parameters})
