"""Several searches for the best design, from the present one and from others between the bounds."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from rattle.analyses import arguments
from rattle.errors import AssemblyError, InputError, ModelError, SolverError
from rattle.progress_bar import progress_bar
from rattle.questions.optimise.asked import RTOL, Bound, Question, question
from rattle.questions.optimise.designs import Design, Designs
from rattle.questions.optimise.optimum import Check, Optimum, Search
from rattle.questions.optimise.search import MET, Found, held, search
from rattle.results.evaluation import evaluate
from rattle.results.reductions import READ_OFF

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

log = logging.getLogger("rattle")
TRIES = 64  # designs drawn for one search until one can be evaluated
REFINEMENTS = 2  # searches with FINER times as many instants each, if the check wants them
FINER = 4  # times as many instants, where they matter, for the check of the optimum
TIGHTER = 1e-2  # times the tolerance for that check


def optimise(
    m: Mechanism, minimise: str, vary: Mapping[str, Sequence[Bound]], subject_to: Sequence[str] = (), *,
    t_end: float | None = None, analysis: str = "simulate", starts: int = 5, seed: int = 0, progress: bool = False,
) -> Optimum:  # fmt: skip
    """The best design; see `Mechanism.optimise`."""
    arguments.whole("starts", starts, 1, 10_000)
    arguments.whole("seed", seed, 0)
    asked, _ = question(m, minimise, vary, subject_to, t_end, analysis)
    designs = Designs(asked)
    bar = _Bar(starts) if progress else None
    if bar is not None:
        designs.on_run = bar.run
    searches: list[Search] = []
    best: Found | None = None
    interrupted = False
    level = log.level
    log.setLevel(max(level, logging.ERROR))  # designs that cannot be evaluated are counted, not told one by one
    try:
        for number, begin in enumerate(_begins(designs, starts, seed)):
            result = search(designs, begin) if begin is not None else None
            searches.append(_search(asked, number, result))
            best = _better(best, result)
            if bar is not None and best is not None:
                bar.search(best, asked)
    except KeyboardInterrupt:
        if best is None:
            raise
        interrupted = True
    finally:
        log.setLevel(level)
        if bar is not None:
            bar.close()
    assert best is not None  # the first search always begins
    try:
        log.setLevel(max(level, logging.ERROR))
        return _confirmed(designs, best, searches, interrupted)
    finally:
        log.setLevel(level)


def _confirmed(designs: Designs, best: Found, searches: list[Search], interrupted: bool) -> Optimum:
    """The optimum; where more instants give other numbers, the best design is searched for anew with them."""
    optimum = _optimum(designs, best, searches, interrupted)
    whole = any(part.kind not in READ_OFF for output in designs.question.outputs for part in output.reductions)
    for _ in range(REFINEMENTS if whole else 0):
        if optimum.confirmed or optimum.check.message or not optimum.feasible or interrupted:
            break
        finer = Designs(replace(designs.question, finer=FINER * designs.question.finer), designs)
        begin = finer.at(best.best.x)
        if not begin.sound:
            break
        number = searches.index(optimum.best_search)
        designs, best = finer, search(finer, begin)
        ended = _search(finer.question, searches[number].number, best)
        old = searches[number]
        searches[number] = replace(
            ended, begun=old.begun, begun_value=old.begun_value, designs=old.designs + ended.designs
        )
        optimum = _optimum(designs, best, searches, interrupted)
    return optimum


def _begins(designs: Designs, starts: int, seed: int) -> Any:
    """The present design, then others between the bounds; None where none of those drawn can be evaluated."""
    from scipy.stats import qmc

    asked = designs.question
    present = designs.at(asked.places(asked.mechanism.parameters))
    if not present.sound:
        text = asked.objective.text
        raise InputError(f"minimise: {text!r} cannot be evaluated for the present design: {present.message}")
    yield present
    if starts == 1:
        return
    sobol = qmc.Sobol(len(asked.names), scramble=True, rng=np.random.default_rng(seed))
    drawn = iter(sobol.random_base2(math.ceil(math.log2(TRIES * starts))))
    for _ in range(starts - 1):
        tried = (designs.at(next(drawn)) for _ in range(TRIES))
        yield next((design for design in tried if design.sound), None)


def _better(best: Found | None, other: Found | None) -> Found | None:
    """The one whose design meets the constraints, or misses them less, and has the lesser objective."""
    if best is None or other is None:
        return other if best is None else best
    ours, theirs = (max(result.missed(result.best) - MET, 0.0) for result in (other, best))
    if ours != theirs:
        return other if ours < theirs else best
    return other if other.best.numbers[0] < best.best.numbers[0] else best


def _search(asked: Question, number: int, result: Found | None) -> Search:
    if result is None:
        return Search(number, {}, {}, float("nan"), float("nan"), False, 0, "no design was found that can be evaluated")
    begun, best = result.begun, result.best
    return Search(
        number, asked.values(begun.x), asked.values(best.x), float(begun.numbers[0]), float(best.numbers[0]),
        result.missed(best) <= MET, result.designs, result.message,
    )  # fmt: skip


# ---------------------------------------------------------------- the optimum
def _optimum(designs: Designs, best: Found, searches: list[Search], interrupted: bool) -> Optimum:
    asked = designs.question
    m = _written(asked, best.best)
    confirmed = replace(_checked(asked, m, best.scale), doubt=designs.doubt(best.best))
    return Optimum(
        question=asked, mechanism=m, numbers=best.best.numbers, held=held(designs, best), searches=tuple(searches),
        feasible=best.meets, check=confirmed, runs=designs.runs, derived=designs.derived,
        failures=dict(designs.failures), differenced=dict(designs.differenced),
        squares=designs.by_squares(best.best), interrupted=interrupted,
    )  # fmt: skip


def _written(asked: Question, design: Design) -> Mechanism:
    """The mechanism with the values of a design, written in the units of the model file."""
    written: dict[str, float | str] = {}
    for name, value in asked.values(design.x).items():
        scale, unit = asked.mechanism.written_unit(name)
        written[name] = f"{value / scale!r} {unit}" if unit else value
    return asked.mechanism.neighbour(written)


def _checked(asked: Question, m: Mechanism, sizes: np.ndarray) -> Check:
    """The numbers of a design by a run of its own, with tighter tolerances and more instants; sizes of its margins."""
    try:
        result = asked.run(m, TIGHTER * RTOL, FINER)
        ideal = asked.run(m.ideal(), TIGHTER * RTOL, FINER) if asked.ideal_curves else None
        numbers = [evaluate(output, result, m.parameters, ideal) for output in asked.outputs]
    except (ModelError, AssemblyError, SolverError) as error:
        return Check(np.full(len(asked.outputs), np.nan), str(error), sizes)
    return Check(np.array(numbers), result.message, sizes)


class _Bar:
    """A progress bar over the searches, with the runs and the best objective so far."""

    def __init__(self, total: int) -> None:
        self._bar = progress_bar(total, "optimise", unit="start", delay=1.0, miniters=0)
        self._runs, self._best = 0, ""

    def run(self) -> None:
        """One more run."""
        self._runs += 1
        self._bar.set_postfix_str(f"{self._runs} runs{self._best}", refresh=False)
        self._bar.update(0)

    def search(self, best: Found, asked: Question) -> None:
        """One more search."""
        self._best = f", best {best.best.numbers[0]:.6g} {asked.objective.unit}".rstrip()
        self._bar.update()

    def close(self) -> None:
        """The end."""
        self._bar.close()
