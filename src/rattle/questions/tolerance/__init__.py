"""What each tolerance does to a number, which to tighten, and which tolerances keep an accuracy."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rattle.language.times import Seconds, seconds_or_none
from rattle.question import question

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.ensemble.fields import Vary
    from rattle.questions.tolerance.report import Tolerance


@question(
    asks="What each tolerance does to a number, which to tighten, and which tolerances keep an accuracy.",
    order=170,
    wants=(("what inexact parts do, which tolerance to tighten, how wide they may be", "[tolerances](tolerances.md)"),),
    examples=(('rattle tolerance F --of "at(rocker.angle, 0.3)"', 'm.tolerance("at(rocker.angle, 0.3)")'),),
)
def tolerance(
    m: Mechanism, of: str, vary: Vary = None, *, analysis: str = "simulate", t_end: Seconds | None = None,
    n: int | None = None, seed: int = 0, threads: int | None = None, progress: bool = False,
) -> Tolerance:  # fmt: skip
    """What tolerances do to an output: `print(m.tolerance("at(rocker.angle, 0.3)", analysis="kinematics"))`.

    of: a number of a run as in `many`.  vary, analysis, t_end: as in `ensemble`.  n: rows of samples, a power of
    two (default 1024 side by side, 512 one by one); with d independent tolerances n (d + 2) mechanisms are run,
    and all 2^d corners for d up to ten.
    seed: of the samples.  threads: default one per core.  progress: show a progress bar.

    Bands (low, high) in SI, side by side: `t.worst_case` at the corners, `t.root_sum_square` from exact slopes
    (`t.slopes`, `t.how`), `t.monte_carlo` with 99.73 % of the samples.  `t.sobol`: shares of the variance by
    parameter, with 95 % bounds; a group is one, "l2, l3".  `t.tighten`: what to tighten first.
    `t.yield_within("0.1 deg")`, `t.allocate("0.1 deg")`.  str(t) is a report.
    Raises what `ensemble` raises; ValueError if the output has no value without deviations.

    Source: Chase, Parkinson, Research in Engineering Design 3 (1991) 23-37; Saltelli et al., Comput. Phys. Comm.
    181 (2010) 259-270.
    """
    from rattle.questions.tolerance.compute import tolerance

    return tolerance(
        m, of, vary, analysis=analysis, t_end=seconds_or_none(t_end, "t_end"), n=n, seed=seed, threads=threads,
        progress=progress,
    )  # fmt: skip
