"""Running what is still missing of an ensemble, piece by piece, on the threads of this process or elsewhere."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from contextlib import contextmanager
from socket import gethostname

from rattle.analyses import arguments
from rattle.analyses.dynamics.run import stop
from rattle.errors import InputError, WorkerError
from rattle.questions.ensemble.engines import Done, Engine, engine, job_of, work
from rattle.questions.ensemble.pieces import WAITING, run_piece
from rattle.questions.ensemble.plans import Plan
from rattle.questions.ensemble.store import Store
from rattle.studies.runs.ctrl_c import noticed
from rattle.studies.runs.progress import Bar
from rattle.studies.runs.runner import Progress, Runner, cores
from rattle.studies.runs.task import Task

PIECE_TIME = 10.0  # seconds of work in a piece, about
FIRST_PIECE = {True: 4096, False: 16}  # samples of the first piece, side by side or one by one
LARGEST_PIECE = 65_536
LEAST_UNDER_WAY = 8  # pieces that are under way elsewhere while it is not known how many workers there are
MOST_NUMBERS = 1_000_000  # of a piece
GLANCE = 1.0  # seconds between two looks for Ctrl-C
PATIENCE = 2.0  # seconds for which runs in threads may take to end after Ctrl-C
LEAST_SHARE = 8  # samples of each thread in a piece, at least: threads wait for each other at its end


def run_missing(
    task: Task, plan: Plan, store: Store, *, executor: Executor | None = None, scheduler: str | None = None,
    workers: int | None = None, threads: int | None = None, progress: bool = False, what: str = "ensemble",
) -> tuple[str, bool]:  # fmt: skip
    """Run all samples that the store misses; returns how they were run, in words, and whether the user stopped it.

    executor, scheduler, workers: run them there, see `engines`; otherwise on so many threads of this process.
    Raises InputError and TypeError for engines that exclude each other or cannot be, ConnectionError, WorkerError,
    and OSError if a piece cannot be written; what is finished is kept.
    """
    if threads is not None and (executor, scheduler, workers) != (None, None, None):
        raise InputError("threads is for runs in this process; leave it out with executor, scheduler or workers")
    threads = cores() if threads is None else arguments.whole("threads", threads, 1)
    done = plan.count - sum(b - a for a, b in store.missing())
    bar = Bar(plan.count, what, done) if progress else None
    where, interrupted = "", False
    try:
        with engine(executor, scheduler, workers, needed=done < plan.count) as other:
            if other is not None:
                with noticed() as pressed:
                    where = run_elsewhere(other, task, plan, store, pressed, bar)
            elif done < plan.count:
                where = f"on {threads} thread{'s' if threads > 1 else ''}"
                run_here(Runner(task), plan, store, threads, bar)
    except KeyboardInterrupt:
        interrupted = True
    finally:
        if bar is not None:
            bar.close()
    return how(store, where), interrupted


def how(store: Store, where: str) -> str:
    """How the samples were run, and why so, in words."""
    run, generic = int((store.status() != WAITING).sum()), int(store.generic().sum())
    if not run:
        return ""
    side = run - generic
    parts = [f"{side} run side by side" if side else "", f"{generic} one by one" if generic else ""]
    reasons = [reason if count == run else f"{count} x {reason}" for reason, count in store.reasons().items()]
    because = f": {'; '.join(reasons)}" if generic and reasons else ""
    kept = f", kept in {store.place}" if store.place else ""
    return ", ".join(part for part in parts if part) + f" {where}".rstrip() + kept + because


def run_here(runner: Runner, plan: Plan, store: Store, threads: int, progress: Progress | None = None) -> None:
    """Run all samples that the store misses.  Raises KeyboardInterrupt; finished pieces are kept."""
    size, most = max(FIRST_PIECE[runner.side_by_side], LEAST_SHARE * threads), _most(runner.task)
    missing = store.missing()
    done = plan.count - sum(b - a for a, b in missing)
    for first, end in missing:
        while first < end:
            last, began = min(end, first + min(size, most)), time.perf_counter()
            told = None if progress is None else _from(progress, done, plan.count)
            store.add(run_piece(runner, first, plan.values(first, last), threads, told))
            done += last - first
            taken = time.perf_counter() - began
            if last - first == size:
                size = _next_size(size, taken, LEAST_SHARE * threads)
            first = last


def _from(progress: Progress, before: int, total: int) -> Progress:
    """Progress of a piece as that of the whole, of which so many samples were done before."""
    return lambda done, _: progress(before + done, total)


def _next_size(size: int, taken: float, least: int) -> int:
    """Samples of the next piece when one of this size took so many seconds: twice or half as many."""
    if taken < PIECE_TIME / 2:
        return min(2 * size, LARGEST_PIECE)
    return max(size // 2, least) if taken > 2 * PIECE_TIME else size


# ---------------------------------------------------------------- elsewhere
def run_elsewhere(
    engine: Engine, task: Task, plan: Plan, store: Store, pressed: Callable[[], bool], progress: Progress | None = None
) -> str:
    """Run all samples that the store misses; returns where, in words.  pressed: whether the user has pressed Ctrl-C.

    Pieces come back in any order.  So many are under way that no worker waits, but not more, whatever n is.
    Raises KeyboardInterrupt, WorkerError, OSError; finished pieces are kept.
    """
    job, most, missing = job_of(task), _most(task), store.missing()
    left = sum(b - a for a, b in missing)  # not yet handed out
    done, size, crew = plan.count - left, FIRST_PIECE[False], Crew()
    running: dict[Future[Done], int] = {}  # by number of the first sample
    try:
        while missing or running:
            if pressed():
                raise KeyboardInterrupt
            while missing and len(running) < max(LEAST_UNDER_WAY, 2 * len(crew)):
                first, end = missing.pop(0)
                last = min(end, first + min(size, _share(left, len(crew)), most))
                if last < end:
                    missing.insert(0, (last, end))
                values = plan.values(first, last)
                with _in_words(first, store):
                    running[engine.executor.submit(work, job, first, values)] = first
                left -= last - first
            ended = wait(running, timeout=GLANCE, return_when=FIRST_COMPLETED).done
            if not ended:
                with _in_words(min(running.values()), store):
                    engine.look()
            for future in ended:
                with _in_words(running.pop(future), store):
                    done_piece = future.result()
                store.add(done_piece.piece)
                crew.add(done_piece.worker)
                count = done_piece.piece.last - done_piece.piece.first
                done += count
                if count == size:
                    size = _next_size(size, done_piece.seconds, LEAST_SHARE)
                if progress is not None:
                    progress(done, plan.count)
    except KeyboardInterrupt:
        _abandon(running, store)
        raise
    finally:
        for future in running:
            future.cancel()
    return crew.words(engine.name)


def _share(left: int, workers: int) -> int:
    """Samples of a piece, at most, for all workers to end at about the same time."""
    return max(LEAST_SHARE, left // (2 * max(workers, 1)))


def _most(task: Task) -> int:
    """Samples of a piece, at most, for its numbers to be sent in one message and written in one file."""
    numbers = len(task.names) + len(task.outputs) + len(task.histories) * len(task.history_times)
    return max(LEAST_SHARE, MOST_NUMBERS // numbers)


@contextmanager
def _in_words(first: int, store: Store) -> Iterator[None]:
    """Say what went wrong with a piece elsewhere.  Raises WorkerError."""
    cause: Exception
    try:
        yield
        return
    except WorkerError as error:
        why, cause = str(error), error
    except BrokenExecutor as error:
        why, cause = "a worker process ended (killed, or out of memory)", error
    except CancelledError as error:
        why, cause = "the connection to the workers was lost", error
    except Exception as error:  # whatever the executor, or a worker without this package, has raised
        why, cause = f"the samples from {first} on could not be run: {type(error).__name__}: {error}", error
    raise WorkerError(f"{why}; {_kept(store)}") from cause


def _kept(store: Store) -> str:
    """What is said of finished samples when a run ends early."""
    if not store.place:
        return "give a folder, and what is finished is kept"
    return f"what is finished is kept in {store.place}, and the same call goes on"


def _abandon(running: dict[Future[Done], int], store: Store) -> None:
    """End what is under way: keep what is finished, and end runs in threads of this process."""
    for future in running:
        future.cancel()
    stop.set()
    try:
        wait(running, timeout=PATIENCE)
    finally:
        stop.clear()
    for future in running:
        if future.done() and not future.cancelled() and future.exception() is None:
            store.add(future.result().piece)


class Crew:
    """The workers that have been seen."""

    def __init__(self) -> None:
        self._seen: set[tuple[str, int, int]] = set()

    def add(self, worker: tuple[str, int, int]) -> None:
        """Note a machine, process and thread."""
        self._seen.add(worker)

    def __len__(self) -> int:
        return len(self._seen)

    def words(self, name: str) -> str:
        """Where they are, and through which engine: "in 2 processes (Dask)"."""
        machines = {machine for machine, _, _ in self._seen}
        processes = {(machine, process) for machine, process, _ in self._seen}
        if processes == {(gethostname(), os.getpid())}:
            return f"on {_counted(len(self), 'thread')} ({name})"
        where = f" on {len(machines)} machines" if len(machines) > 1 else ""
        return f"in {_counted(len(processes), 'process')}{where} ({name})"


def _counted(count: int, what: str) -> str:
    plural = "es" if what.endswith("s") else "s"
    return f"{count} {what}{plural if count != 1 else ''}"
