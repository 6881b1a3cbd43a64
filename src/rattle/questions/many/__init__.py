"""Numbers of runs with many sets of parameters, side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from rattle.language.times import Seconds, seconds_or_none
from rattle.question import question

if TYPE_CHECKING:
    import numpy as np

    from rattle.mechanism import Mechanism
    from rattle.questions.many.compute import Many


@question(
    asks="Numbers of runs with many sets of parameters, side by side.",
    order=145,
    command="",
    wants=(("what a thousand of them do, each with its own dimensions", "[many runs](many-runs.md)"),),
    examples=(("", "m.many(samples, outputs)"),),
)
def many(
    m: Mechanism, samples: Mapping[str, Sequence[float] | np.ndarray], outputs: Sequence[str],
    t_end: Seconds | None = None, *, rtol: float | None = None, atol: float | None = None,
    method: str | None = None, step: Seconds | None = None, threads: int | None = None, progress: bool = False,
) -> Many:  # fmt: skip
    """Outputs of runs with many sets of parameters: `m.many({"l2": values}, ["max(abs(O3.normal))"], 0.05)`.

    samples: parameter names with their values (n,) [SI].  outputs: numbers such as "max(abs(O3.normal))",
    "at(rocker.angle, 0.05)", "final(x)", "first(x > 0)": max min mean rms sd range integral at final share first
    quantile count, inside them expressions over result names, outside them arithmetic.
    t_end: [s].  rtol (default 1e-8), atol, method, step: as in `simulate`.  threads: default one per core.

    Returns `found[output]`, an array (n,) [SI], nan where it has no value: `found.failed`, `found.message(i)`.
    Samples run side by side, with contacts too, where sample i gives the same bits whatever stands beside it;
    what that cannot vouch for runs one by one: `found.generic`, and `found.stats["how"]` says why.
    Whether a massless link pulls is not checked: ask for "min(O3.normal)".
    Raises ModelError for an output that cannot be read, UnknownName for a parameter, ValueError.
    """
    from rattle.questions.many.compute import many

    return many(
        m, samples, outputs, t_end=seconds_or_none(t_end, "t_end"), rtol=rtol, atol=atol, method=method,
        step=seconds_or_none(step, "step"), threads=threads, progress=progress,
    )  # fmt: skip
