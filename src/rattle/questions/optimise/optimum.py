"""The best design that was found, and the report on it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rattle.questions.optimise.asked import Question
from rattle.questions.optimise.search import Held
from rattle.results.display import lines, quantity
from rattle.results.reductions import EQUAL

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

ALIKE = 1e-4  # share of the range within which designs are the same
AGREES = 1e-6  # share by which the check may differ
MISSED = 1e-4  # share of a constraint's size by which the check may miss it: curves between outputs are interpolated
WIDEST = 60  # characters of the objective beside its values


def _or_inf(value: float) -> float:
    return value if math.isfinite(value) else math.inf


@dataclass(frozen=True)
class Search:
    """One search: where it began, where it ended."""

    number: int  # 0: the present design
    begun: dict[str, float]  # parameters [SI]
    ended: dict[str, float]
    begun_value: float  # of the objective [SI]
    value: float  # at the end
    feasible: bool
    designs: int  # that were looked at
    message: str  # "" if it converged


@dataclass(frozen=True, eq=False)
class Check:
    """Numbers of the best design by a run of its own, with tighter tolerances and more instants."""

    numbers: np.ndarray  # (1 + m,) [SI]
    message: str
    sizes: np.ndarray  # (m,) sizes of the margins [SI]
    doubt: float = 0.0  # an objective below this is as good as zero [SI]


@dataclass(frozen=True, eq=False, repr=False)
class Optimum:
    """The best design: `mechanism`, `value` of the objective, `values` of the parameters; `report` says all."""

    question: Question
    mechanism: Mechanism  # with the values found
    numbers: np.ndarray  # (1 + m,) objective, margins of the constraints [SI]
    held: Held | None  # None where the optimum has no derivatives
    searches: tuple[Search, ...]
    feasible: bool  # it meets all constraints
    check: Check
    runs: int
    derived: int  # designs at which derivatives were taken
    failures: Mapping[str, int]  # why designs could not be evaluated
    differenced: Mapping[str, int]  # why derivatives were not exact
    squares: bool  # the objective is a sum of squares and was searched as one
    interrupted: bool

    @property
    def value(self) -> float:
        """The objective at the best design [SI]."""
        return float(self.numbers[0])

    @property
    def values(self) -> dict[str, float]:
        """The parameters that varied [SI]."""
        return {name: self.mechanism.parameters[name] for name in self.question.names}

    @property
    def active(self) -> tuple[str, ...]:
        """Constraints and bounds that hold the optimum where it is."""
        asked, held = self.question, self.held
        if held is None:
            return ()
        texts = [asked.constraints[j].text for j in held.constraints]
        texts += [f"{asked.names[k]} >= {self._shown(asked.names[k], asked.low[k])}" for k in held.low]
        texts += [f"{asked.names[k]} <= {self._shown(asked.names[k], asked.high[k])}" for k in held.high]
        return tuple(texts)

    @property
    def success(self) -> bool:
        """True if the best design meets the constraints, its search converged, and the check agrees."""
        return self.feasible and not self.interrupted and not self.best_search.message and self.confirmed

    @property
    def confirmed(self) -> bool:
        """True if the check agrees on the objective within 1e-6 of it or of the change, or errors alone are left, and
        meets the constraints, but for 1e-4 of the size of each."""
        change = abs(self.value - self.searches[0].begun_value)
        enough = max(AGREES * abs(self.value), AGREES * change, self.check.doubt)
        close = abs(self.check.numbers[0] - self.value) <= enough
        return bool(close and not self.check.message and not self.missed)

    @property
    def missed(self) -> tuple[str, ...]:
        """Constraints that the check does not meet."""
        margins = [
            -abs(margin) if constraint.comparison == EQUAL else margin
            for constraint, margin in zip(self.question.constraints, self.check.numbers[1:], strict=True)
        ]
        bad = margins < -MISSED * self.check.sizes
        return tuple(constraint.text for constraint, lacks in zip(self.question.constraints, bad, strict=True) if lacks)

    @property
    def best_search(self) -> Search:
        """The search that ended at the best design."""
        return min(self.searches, key=lambda search: (not search.feasible, _or_inf(search.value)))

    @property
    def report(self) -> str:
        """What changed, what it gained, what holds it, and how it was found."""
        asked, first = self.question, self.searches[0]
        text = f"minimise {asked.objective.text}"
        text = text if len(text) <= WIDEST else text[: WIDEST - 4] + " ..."
        rows = [(text, f"{self._number(first.begun_value)} -> {self._number(self.value)}")]
        present = asked.mechanism.parameters
        for k, name in enumerate(asked.names):
            change = f"{self._shown(name, present[name])} -> {self._shown(name, self.values[name])}"
            bounds = f"(from {self._shown(name, asked.low[k])} to {self._shown(name, asked.high[k])})"
            rows.append((f"  {name}", f"{change}  {bounds}"))
        wide = max(len(left) for left, _ in rows)
        lines = [f"{left:{wide}s}  {right}" for left, right in rows]
        return "\n".join([*lines, *self._holding(), *self._finding()])

    def _of_constraint(self, j: int) -> str:
        """Line on a constraint: whether it holds, and what it costs."""
        asked, constraint = self.question, self.question.constraints[j]
        margin, unit = float(self.numbers[1 + j]), constraint.margin.unit
        multiplier = None if self.held is None else self.held.constraints.get(j)
        line = f"subject to {constraint.text}: "
        if constraint.comparison == EQUAL:
            if multiplier is None:
                return line + ("met" if self.feasible else f"missed by {quantity(abs(margin), unit)}")
            rate = quantity(-multiplier, asked.objective.unit, 4)
            return (
                line
                + f"met; a right side greater by 1 {unit or 'unit'} changes the objective by {rate}, to first order"
            )
        if multiplier is not None:
            rate = f"{multiplier:.4g} {asked.objective.unit}".rstrip()
            return line + f"active; loosened, it lets the objective fall by {rate} per {unit or 'unit'}"
        return line + (
            f"holds, {quantity(margin, unit)} to spare" if margin >= 0.0 else f"missed by {quantity(-margin, unit)}"
        )

    def _holding(self) -> list[str]:
        """Lines on the constraints and bounds."""
        asked, held = self.question, self.held
        lines = [self._of_constraint(j) for j in range(len(asked.constraints))]
        bounds = self.active[len(held.constraints) :] if held is not None else ()
        if bounds:
            lines.append(f"at its bound: {', '.join(bounds)}")
        if held is not None and held.idle:
            idle = ", ".join(asked.names[k] for k in held.idle)
            lines.append(f"without effect on what is asked, near this design at least: {idle}")
        if held is None:
            lines.append("no derivatives at the optimum: what holds it there is not known")
        elif self.feasible and (not self.squares or self.value > 0.0):
            lines.append(f"what is left of the gradient: {self._number(held.left)} per 1 % of the ranges")
        if not self.feasible:
            lines.append("NO DESIGN MEETS ALL CONSTRAINTS: this one misses them least")
        return lines

    def _finding(self) -> list[str]:
        """Lines on how it was found."""
        method = "least squares (Gauss-Newton, trust region)" if self.squares else "sequential quadratic programming"
        lines = [f"{method}; {self.runs} runs, derivatives at {self.derived} designs"]
        whole = sum(self.differenced.values())
        if whole:
            reasons = "; ".join(self.differenced)
            lines.append(f"at {whole} of these derivatives are differences of whole runs, because: {reasons}")
        lost = sum(self.failures.values())
        if lost:
            worst = sorted(self.failures.items(), key=lambda failure: -failure[1])[:3]
            reasons = "; ".join(f"{n} x {why}" for why, n in worst)
            lines.append(f"{lost} design{'s'[: lost > 1]} on the way could not be evaluated: {reasons}")
        lines += [*self._ends(), self._confirmation()]
        if self.interrupted:
            lines.append("stopped by the user; this is the best design until then")
        return lines

    def _ends(self) -> list[str]:
        """Where the searches ended."""
        best = self.best_search
        same = [search for search in self.searches if search.ended and self._distance(search, best) <= ALIKE]
        others = [search for search in self.searches if search.ended and search not in same]
        lines = [f"{len(same)} of {len(self.searches)} searches ended at this design"]
        if others:
            values = ", ".join(
                f"{self._number(search.value, 4)}{'' if search.feasible else ' (misses a constraint)'}"
                for search in sorted(others, key=lambda search: search.value)[:5]
            )
            lines[0] += f", the others at {values}{' ...' if len(others) > 5 else ''}"
        empty = sum(not search.ended for search in self.searches)
        if empty:
            lines[0] += f"; for {empty} no design between the bounds was found that can be evaluated"
        if best.message:
            lines.append(f"its search did not converge: {best.message}")
        return lines

    def _distance(self, search: Search, other: Search) -> float:
        """Largest difference of the designs at the end, as a share of the ranges."""
        asked = self.question
        apart = [abs(search.ended[name] - other.ended[name]) for name in asked.names]
        return float(np.max(apart / asked.width))

    def _confirmation(self) -> str:
        if self.check.message:
            return f"NOT CONFIRMED: a run of its own with tighter tolerances failed: {self.check.message}"
        how = "a run with 100 times tighter tolerances" if self.question.analysis == "simulate" else "a run of its own"
        again = f"{how} and finer output gives {self._number(float(self.check.numbers[0]), 8)}"
        again += f", where {' and '.join(self.missed)} does not hold" if self.missed else ""
        return f"confirmed: {again}" if self.confirmed else f"NOT CONFIRMED: {again}; refine [simulate] output"

    # ---------------------------------------------------------------- numbers in words
    def _number(self, value: float, digits: int = 6) -> str:
        """A value of the objective with its unit."""
        return quantity(value, self.question.objective.unit, digits)

    def _shown(self, name: str, value: float) -> str:
        """A value of a parameter in the unit that the model file uses for it."""
        parameter = self.question.mechanism.model.parameters[name]
        return quantity(value, parameter.unit, 6, self.question.mechanism.written_unit(name)[1])

    def __repr__(self) -> str:
        return f"<rattle.Optimum: {self.question.objective.text[:60]} = {self._number(self.value)}>"

    def __str__(self) -> str:
        return self.report

    def _repr_html_(self) -> str:
        return lines(self.report)
