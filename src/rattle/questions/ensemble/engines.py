"""Who runs pieces of an ensemble outside of this process: any executor, or Dask on one or many machines.

A worker gets a `Job`, plain data from which it makes its runner once, and the values of the parameters of a piece;
what it sends back is the piece.  So a worker needs nothing but the package, and may die at any time.
"""

from __future__ import annotations

import logging
import math
import os
import socket
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from rattle.analyses import arguments
from rattle.errors import InputError, WorkerError, WrongType
from rattle.mechanism import Mechanism
from rattle.questions.ensemble.identity import python_laws, unknown_laws
from rattle.questions.ensemble.local_workers import local_workers
from rattle.questions.ensemble.pieces import Piece, run_piece
from rattle.results.archive import package
from rattle.studies.runs.analyses import Stepping
from rattle.studies.runs.runner import Runner
from rattle.studies.runs.task import Task, task_of
from rattle.version import __version__

log = logging.getLogger("rattle")

CONNECTION = 10.0  # seconds to wait for a scheduler
ALONE = 10.0  # seconds that a scheduler may be without its workers before this is said
MOST_WORKERS = 1024  # processes on one machine
JOBS_KEPT = 4  # runners that a worker keeps


@dataclass(frozen=True)
class Job:
    """A task as plain data."""

    version: str  # of rattle
    model: str  # text
    laws: tuple[tuple[str, str], ...]  # written in Python, which the text only names; see `python_laws`
    names: tuple[str, ...]
    outputs: tuple[str, ...]
    analysis: str
    t_end: float  # [s]
    how: Stepping
    histories: tuple[str, ...]


class Done(NamedTuple):
    """A piece, and who ran it."""

    piece: Piece
    seconds: float  # without making the runner
    worker: tuple[str, int, int]  # machine, process, thread


class Engine(NamedTuple):
    """Something that runs pieces elsewhere."""

    executor: Executor
    name: str
    look: Callable[[], None] = lambda: None  # whether anybody is left to run them.  Raises WorkerError


def job_of(task: Task) -> Job:
    """What a worker needs to run samples of a task."""
    laws = tuple(python_laws(task.mechanism.model).items())
    return Job(
        __version__, task.mechanism.to_toml(), laws, task.names, tuple(task.texts), task.analysis, task.t_end, task.how,
        task.histories,
    )  # fmt: skip


# ---------------------------------------------------------------- in a worker
_making = threading.Lock()


def work(job: Job, first: int, parameters: np.ndarray) -> Done:
    """Run the samples from `first` on, with values (k, c) [SI], in this process.  Raises WorkerError."""
    with _making:
        runner = _runner(job)
    began = time.perf_counter()
    piece = run_piece(runner, first, parameters)
    return Done(piece, time.perf_counter() - began, (socket.gethostname(), os.getpid(), threading.get_ident()))


@lru_cache(maxsize=JOBS_KEPT)
def _runner(job: Job) -> Runner:
    """The runner of a job.  Raises WorkerError if this process would run something else."""
    here = f"worker process {os.getpid()} on {socket.gethostname()}"
    if job.version != __version__:
        raise WorkerError(f"{here} has rattle {__version__}, not {job.version}; install the same version there")
    if unknown := unknown_laws(dict(job.laws)):
        raise WorkerError(
            f"{here} does not know the {unknown[0]} of the model, which is written in Python; run it with threads, or"
            " define it in a module that every worker imports"
        )
    how = job.how
    return Runner(
        task_of(
            Mechanism.from_text(job.model), job.names, job.outputs, analysis=job.analysis, t_end=job.t_end,
            method=how.method, rtol=how.rtol, atol=how.atol, step=how.step, histories=job.histories,
        )
    )  # fmt: skip


# ---------------------------------------------------------------- the engines
@contextmanager
def engine(
    executor: Executor | None, scheduler: str | None, workers: int | None, needed: bool = True
) -> Iterator[Engine | None]:
    """The engine that is asked for, None if it is this process or none is needed; what is started is closed again.

    Raises InputError and TypeError for a question that makes no sense, ConnectionError, WorkerError, MissingPackage.
    """
    engines = {"executor": executor, "scheduler": scheduler, "workers": workers}
    asked = [key for key, choice in engines.items() if choice is not None]
    if len(asked) > 1:
        raise InputError(f"{' and '.join(asked)} exclude each other; give one of them")
    if executor is not None:
        _require_executor(executor)
    if scheduler is not None:
        _require_address(scheduler)
    if workers is not None:
        arguments.whole("workers", workers, 1, MOST_WORKERS)
    if executor is not None and needed:
        yield Engine(executor, type(executor).__name__)
    elif scheduler is not None and needed:
        with _client(scheduler) as client:
            yield Engine(_OnDask(client), f"Dask, {scheduler}", _Watch(client, scheduler).look)
    elif workers is not None and needed:
        with local_workers(workers) as (address, look), _client(address) as client:
            yield Engine(_OnDask(client), "Dask", look)
    else:
        yield None


class _OnDask(Executor):
    """Calls on the workers of a Dask client.

    `client.get_executor()` loses a result whose worker ends as it is fetched; `result` of a Dask future waits until it
    has been made again.
    """

    def __init__(self, client: Any) -> None:
        self._client = client

    def submit(self, function: Callable[..., Any], /, *args: Any, **options: Any) -> Future[Any]:
        """The outcome of a call; who cancels it takes the call back."""
        asked = self._client.submit(function, *args, pure=False, **options)
        outcome: Future[Any] = Future()

        def deliver(done: Any) -> None:
            if not outcome.set_running_or_notify_cancel():
                return
            try:
                outcome.set_result(done.result())
            except BaseException as error:  # whatever it is: who waits must hear of it
                outcome.set_exception(error)

        asked.add_done_callback(deliver)
        outcome.add_done_callback(lambda ended: asked.cancel() if ended.cancelled() else None)
        return outcome


class _Watch:
    """Says that a scheduler has no workers: at once, or after some patience if it had some."""

    def __init__(self, client: Any, address: str) -> None:
        self._client, self._address = client, address
        self._left, self._said = -math.inf, False  # when it had workers [s]
        self.look()

    def look(self) -> None:
        """To be called now and then."""
        now = time.monotonic()
        if self._client.scheduler_info()["workers"]:
            self._left, self._said = now, False
        elif not self._said and now - self._left > ALONE:
            self._said = True
            log.warning(f"{self._address} has no workers: waiting for one; start it with `dask worker {self._address}`")


def _require_executor(executor: object) -> None:
    if isinstance(executor, Executor):
        return
    hint = (
        "; of a Dask client give client.get_executor()" if type(executor).__module__.startswith("distributed") else ""
    )
    raise WrongType(f"executor: expected a concurrent.futures.Executor, got {executor!r:.60}{hint}")


def _require_address(scheduler: object) -> None:
    if not isinstance(scheduler, str) or "://" not in scheduler:
        raise InputError(f"scheduler: expected an address such as tcp://10.0.0.1:8786, got {scheduler!r:.60}")


@contextmanager
def _client(address: str) -> Iterator[Any]:
    """A client of the Dask scheduler at an address.  Raises ConnectionError, ValueError."""
    distributed = package("distributed", "running on Dask")
    loggers = [logging.getLogger(name) for name in ("distributed", "distributed.client")]
    levels = [logger.level for logger in loggers]
    try:
        for logger in loggers:
            logger.setLevel(logging.CRITICAL)  # what goes wrong is said by our own errors
        with _connected(distributed, address) as client:
            yield client
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


@contextmanager
def _connected(distributed: Any, address: str) -> Iterator[Any]:
    """See `_client`."""
    try:
        client = distributed.Client(address, timeout=CONNECTION, set_as_default=False)
    except (OSError, TimeoutError) as error:
        raise ConnectionError(
            f"no Dask scheduler answers at {address} within {CONNECTION:g} s; start one with `dask scheduler`, and"
            f" workers with `dask worker {address}`"
        ) from error
    try:
        yield client
    finally:
        client.close()
