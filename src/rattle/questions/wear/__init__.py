"""Where pins and bushes wear over many cycles, how deep, and how long they last."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from rattle.language.times import Seconds, seconds_or_none
from rattle.question import FormField, Tab, question

if TYPE_CHECKING:
    import os

    from rattle.mechanism import Mechanism
    from rattle.questions.wear.worn import Worn


@question(
    asks="Where pins and bushes wear over many cycles, how deep, and how long they last.",
    order=250,
    wants=(("where its joints wear, and how long they last", "[wear](wear.md)"),),
    examples=(("rattle wear F --cycles 1e6", "m.wear(cycles=1e6)"),),
    tab=Tab("wear", "Oil and wear", 70, (FormField("cycles", "cycles", "1e5", needs="wear", size=8),)),
)
def wear(
    m: Mechanism, cycles: float | None = None, jump: float | str | None = None, cycle: Seconds | None = None,
    stop: Mapping[str, float] | None = None, out: str | os.PathLike[str] | None = None, *,
    rtol: float | None = None, progress: bool | Callable[[float, float], None] = False,
) -> Worn:  # fmt: skip
    """Wear of pins and bushes over many cycles: `w = m.wear(cycles=1e6); print(w); w.plot()`.

    Joints wear that have `wear = { bush = "1e-6 mm^3/(N*m)", pin = 0 }`.  A cycle is simulated, its wear carried
    over a jump of many cycles, and so on.
    cycles: how many (default: as in the model).  cycle: its duration [s] (default: one turn of the driver).
    jump: "auto" chooses jumps by their error, 1 % of the depth each; a number of cycles, cut where it is unstable.
    stop: {"depth": 1e-4, "volume": 1e-9} ends the study there [m, m^3]; worn through at `wall` ends it too.
    out: folder in which it is kept after every jump; the same call goes on there, in whatever way it ended.
    rtol: of the motion (default: as in the model, or 1e-6).  progress: show a progress bar.

    `w.profile("pin").bush.depth` [m], .angle [rad], .volume [m^3], .deepest; .pin likewise; `w.history`,
    `w.mechanism` (worn, for every other analysis), `w.plot("pin")`, `w.limiting`, `w.trust`.
    Raises ModelError, ValueError for a question that makes no sense or a folder of another study, SolverError for
    a cycle that cannot be simulated, OSError.

    Source: docs/wear.md; Archard, J. Appl. Phys. 24 (1953) 981-988.
    """
    from rattle.questions.wear.compute import wear

    return wear(m, cycles, jump, seconds_or_none(cycle, "cycle"), stop, out, rtol=rtol, progress=progress)
