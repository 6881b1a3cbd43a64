"""What tolerances do: statistics over many mechanisms of one drawing, and the share within a limit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rattle.language.times import Seconds, seconds_or_none
from rattle.question import FormField, Tab, question

if TYPE_CHECKING:
    import os
    from concurrent.futures import Executor

    from rattle.mechanism import Mechanism
    from rattle.questions.ensemble.compute import Ensemble
    from rattle.questions.ensemble.fields import Vary


@question(
    asks="What tolerances do: statistics over many mechanisms of one drawing, and the share within a limit.",
    order=150,
    tab=Tab(
        "ensemble",
        "Ensemble",
        50,
        (FormField("of", "number", usual="force", size=22), FormField("n", "mechanisms", "64", size=6)),
    ),
)
def ensemble(
    m: Mechanism, n: int, outputs: Sequence[str], vary: Vary = None, *, seed: int = 0, analysis: str = "simulate",
    t_end: Seconds | None = None, design: str = "sobol", histories: Sequence[str] = (),
    rtol: float | None = None, method: str | None = None, threads: int | None = None,
    executor: Executor | None = None, scheduler: str | None = None,
    workers: int | None = None, folder: str | os.PathLike[str] | None = None, resume: bool = True,
    progress: bool = False,
) -> Ensemble:  # fmt: skip
    """Statistics of n mechanisms with tolerances: `m.ensemble(1000, ["max(O3.force)"]).summary()`.

    outputs: numbers of a run as in `many`.  vary: parameters and their tolerances: all that have one in the model
    file (default), a list of names, or {"l2": "0.1 mm", "r3": {"tol": 1e-4, "dist": "normal"}}.
    seed: sample i depends on it and on i alone (and on n for lhs).  design: sobol, halton, lhs (spread evenly) or
    random (independent).
    analysis: simulate, kinematics, inverse-dynamics, equilibrium, accuracy (outputs of "rocker.angle.high",
    .low, .nominal, .worst, .rss) or modes ("mode1.frequency", .damping, .growth).
    t_end: [s] (default: as in the model; t = 0 alone for equilibrium and modes).  rtol (default 1e-8), method: of
    motions.  histories: curves of all samples that are kept at 201 instants, `e.histories("rocker.angle")`; such
    samples run one by one, and beyond 1 GB need a folder.  progress: show a progress bar with rate and time left.
    threads: of this process, default one per core.  Instead of them, executor: any concurrent.futures.Executor;
    workers: so many processes on this machine; scheduler: address of a Dask scheduler, "tcp://10.0.0.1:8786".
    All give the same bits; laws written in Python must be known in the other processes.
    folder: where samples are kept, piece by piece, as Parquet files, histories as netCDF.  The same call goes on
    where it ended, in whatever way, also with a larger n (not for lhs); the folder of another run is refused.
    resume: False refuses every folder with a run.

    Returns the samples, `e["max(O3.force)"]`, `e.table`, `e.sample(17)`, and what follows from them: `e.summary()`,
    `e.yield_below("max(O3.force)", 5000)`, and pictures: `e.plot("max(O3.force)", limit="5 kN")`,
    `e.plot_scatter()`, `e.plot_band("rocker.angle")`, `e.plot_contributions("max(O3.force)")`.  A sample that
    cannot be run is a row with its message.  Ctrl-C returns the samples so far.
    Raises ModelError, UnknownName, ValueError for a question that makes no sense; MissingPackage without pandas
    where tables are asked for, pyarrow for a folder, distributed for workers; ConnectionError for a scheduler that
    does not answer, WorkerError for workers that end, OSError if the folder cannot be written: what is finished
    is kept in the folder, and the same call goes on.
    """
    from rattle.questions.ensemble.compute import ensemble

    return ensemble(
        m, n, outputs, vary, seed=seed, analysis=analysis, t_end=seconds_or_none(t_end, "t_end"), design=design,
        histories=histories, rtol=rtol, method=method, threads=threads, executor=executor, scheduler=scheduler,
        workers=workers, folder=folder, resume=resume, progress=progress,
    )  # fmt: skip
