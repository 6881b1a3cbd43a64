"""Numbers over all combinations of values of parameters, as table, curve or map."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from rattle.language.times import Seconds, seconds_or_none
from rattle.question import question

if TYPE_CHECKING:
    import os
    from concurrent.futures import Executor

    import numpy as np

    from rattle.mechanism import Mechanism
    from rattle.questions.sweep.compute import Sweep


@question(
    asks="Numbers over all combinations of values of parameters, as table, curve or map.",
    order=160,
)
def sweep(
    m: Mechanism, values: Mapping[str, Sequence[float | str] | np.ndarray], outputs: Sequence[str], *,
    analysis: str = "simulate", t_end: Seconds | None = None, rtol: float | None = None, method: str | None = None,
    threads: int | None = None, executor: Executor | None = None, scheduler: str | None = None,
    workers: int | None = None, folder: str | os.PathLike[str] | None = None, resume: bool = True,
    progress: bool = False,
) -> Sweep:  # fmt: skip
    """Outputs over all combinations of values: `m.sweep({"r3": [1e-3, 2e-3]}, ["max(O3.force)"]).table`.

    values: by parameter, numbers in SI or texts such as "1 mm"; the last parameter changes fastest.
    All else as in `ensemble`.  `w.grid(output)` is an array with one axis per parameter.
    """
    from rattle.questions.sweep.compute import sweep

    return sweep(
        m, values, outputs, analysis=analysis, t_end=seconds_or_none(t_end, "t_end"), rtol=rtol, method=method,
        threads=threads, executor=executor, scheduler=scheduler, workers=workers, folder=folder, resume=resume,
        progress=progress,
    )  # fmt: skip
