"""Running what is still missing of an ensemble, piece by piece, on the threads of this process."""

from __future__ import annotations

import time

from rattle.analyses import arguments
from rattle.studies.ensemble.pieces import WAITING, run_piece
from rattle.studies.ensemble.plans import Plan
from rattle.studies.ensemble.store import Store
from rattle.studies.runs.runner import Progress, Runner, cores
from rattle.studies.runs.task import Task

PIECE_TIME = 10.0  # seconds of work in a piece, about
FIRST_PIECE = {True: 4096, False: 16}  # samples of the first piece, side by side or one by one
LARGEST_PIECE = 65_536
LEAST_SHARE = 8  # samples of each thread in a piece, at least: threads wait for each other at its end


def run_missing(
    task: Task, plan: Plan, store: Store, *, threads: int | None = None, progress: bool = False, what: str = "ensemble"
) -> tuple[str, bool]:
    """Run all samples that the store misses; returns how they were run, in words, and whether the user stopped it."""
    threads = cores() if threads is None else arguments.whole("threads", threads, 1)
    runner, interrupted = Runner(task), False
    bar = Bar(plan.count, what) if progress else None
    try:
        run_here(runner, plan, store, threads, bar)
    except KeyboardInterrupt:
        interrupted = True
    finally:
        if bar is not None:
            bar.close()
    return how(runner.why, store, f"on {threads} thread{'s' if threads > 1 else ''}"), interrupted


def how(why: str, store: Store, where: str) -> str:
    """How the samples were run, and why so, in words."""
    run, generic = int((store.status() != WAITING).sum()), int(store.generic().sum())
    side = run - generic
    parts = [f"{side} run side by side" if side else "", f"{generic} one by one" if generic else ""]
    reasons = [why, *(f"{count} x {said}" for said, count in store.reasons().items())]
    because = "; ".join(one for one in reasons if one) if generic else ""
    return ", ".join(one for one in parts if one) + f" {where}" + (f": {because}" if because else "")


def run_here(runner: Runner, plan: Plan, store: Store, threads: int, progress: Progress | None = None) -> None:
    """Run all samples that the store misses.  Raises KeyboardInterrupt; finished pieces are kept."""
    size = max(FIRST_PIECE[runner.side_by_side], LEAST_SHARE * threads)
    missing = store.missing()
    done = plan.count - sum(b - a for a, b in missing)
    for first, end in missing:
        while first < end:
            last, began = min(end, first + size), time.perf_counter()
            told = None if progress is None else _from(progress, done, plan.count)
            store.add(run_piece(runner, plan, first, last, threads, told))
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


class Bar:
    """A progress bar over samples with their rate and the time left, called with those done and all."""

    def __init__(self, total: int, what: str) -> None:
        from tqdm import tqdm

        self._bar = tqdm(total=total, desc=what, unit=" samples", delay=1.0)

    def __call__(self, done: int, total: int) -> None:
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        self._bar.close()
