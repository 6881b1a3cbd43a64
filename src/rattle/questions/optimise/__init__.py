"""Values of parameters that make a number, such as a peak force or an error, as small as possible."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from rattle.language.times import Seconds, seconds_or_none
from rattle.question import question

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.optimise.optimum import Optimum


@question(
    asks="Values of parameters that make a number, such as a peak force or an error, as small as possible.",
    order=180,
    wants=(("which dimensions make a force or an error smallest", "optimisation"),),
    examples=(('rattle optimise F --minimise "..." --vary l2=0.5:0.7', 'm.optimise("...", {"l2": (0.5, 0.7)})'),),
)
def optimise(
    m: Mechanism, minimise: str, vary: Mapping[str, Sequence[float | str]], subject_to: Sequence[str] = (), *,
    t_end: Seconds | None = None, analysis: str = "simulate", starts: int = 5, seed: int = 0,
    progress: bool = False,
) -> Optimum:  # fmt: skip
    """Values of parameters that make an output least: `m.optimise("rms(P.y)", {"l2": (0.5, 0.8)})`.

    minimise: a number such as "rms(rocker.angle - ideal.rocker.angle)" or "(final(block.x) - 0.3)**2"; reductions
    as in `many`.  vary: parameters with their lower and upper bound, numbers in SI or texts such as "5 mm"; they
    are never left.  subject_to: comparisons that must hold, such as "max(O3.force) <= 500" or "l2 + l3 == 0.9".
    t_end: end of the runs [s] (default: as in the model).  analysis: "simulate", "kinematics" or
    "inverse-dynamics".  starts: searches, the first from the present design, the others from designs drawn between
    the bounds with this seed.  progress: show a progress bar.

    A search follows exact derivatives of the curves where there are any, otherwise differences of runs, and the
    report says so.  A sum of squares is recognised and searched as one.  Returns the best design:
    `o.mechanism`, `o.value` and `o.values` [SI], `o.active`, `o.report`, `o.success`.
    Raises ValueError, UnknownName, ModelError with what is wrong in the question; ValueError if the present design
    cannot be evaluated.

    Source: Nocedal, Wright, Numerical Optimization (2006), sections 10.3 and 18.1.
    """
    from rattle.questions.optimise.compute import optimise

    return optimise(
        m, minimise, vary, subject_to, t_end=seconds_or_none(t_end, "t_end"), analysis=analysis, starts=starts,
        seed=seed, progress=progress,
    )  # fmt: skip
