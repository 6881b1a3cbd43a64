"""Duty cases: what a machine does for which share of its time, and the run of each."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from rattle.analyses.driver_period import last_turn
from rattle.description.model import DutyCase
from rattle.errors import InputError, ModelError, SolverError, WrongType
from rattle.mechanism import Mechanism
from rattle.results.result import Result

LIKE = '"0.7: M=30; 0.3: M=60, speed=20"'
Duty = Sequence[Mapping[str, Any]] | str | None


class Case(NamedTuple):
    """A duty case and its run."""

    name: str
    share: float  # of all time
    mechanism: Mechanism
    run: Result

    @property
    def duration(self) -> float:
        """Length of the run [s]."""
        return float(self.run.t[-1] - self.run.t[0])

    def mean(self, values: np.ndarray) -> float:
        """Mean over time of a curve (n,): over the last turn of the driver, or the whole run."""
        t = self.run.t
        start = last_turn(self.mechanism.system, float(t[-1]))
        start = max(start, float(t[0]))
        inside = t > start
        times = np.concatenate([[start], t[inside]])
        curve = np.concatenate([[np.interp(start, t, values)], values[inside]])
        return float(np.trapezoid(curve, times) / (t[-1] - start))


def with_duty(m: Mechanism, duty: Duty) -> Mechanism:
    """The mechanism with these cases in place of its own.  Raises ModelError, InputError."""
    if duty is None:
        return m
    written = _written(duty) if isinstance(duty, str) else duty
    if not isinstance(written, Sequence) or not all(isinstance(case, Mapping) for case in written):
        raise WrongType(f"duty: expected [{{'share': 0.7, 'set': {{'M': 30}}}}, ...] or {LIKE}; got {duty!r:.60}")
    try:
        return m.set({"duty.cases": [dict(case) for case in written]})
    except ModelError as error:
        raise InputError("; ".join(f"{problem.key}: {problem.message}" for problem in error.problems)) from None


def _written(text: str) -> list[dict[str, Any]]:
    """Cases of a text such as LIKE."""
    cases = []
    for part in filter(str.strip, re.split("[;\n]", text)):
        share, colon, changes = part.partition(":")
        pairs = [change.partition("=") for change in changes.split(",") if change.strip()]
        if not colon or not all(equals for _, equals, _ in pairs):
            raise InputError(f"duty: expected {LIKE}, got {part.strip()!r:.60}")
        case = {name.strip(): _number_or_text(value.strip()) for name, _, value in pairs}
        cases.append({"share": _number_or_text(share.strip()), "set": case})
    return cases


def _number_or_text(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def cases_of(m: Mechanism) -> Iterator[Case]:
    """All cases with their runs, one after the other.  Raises SolverError for a run that fails."""
    duty = m.model.duty or (DutyCase(1.0, {}),)
    whole = sum(case.share for case in duty)
    for number, case in enumerate(duty):
        mechanism = m.set(case.changes)  # a copy, even without any: its run holds its model, that of a sample does not
        run = mechanism.simulate()
        if run.interrupted:
            raise KeyboardInterrupt
        name = case.name or f"case {number + 1}"
        if not run.success:
            raise SolverError(f"{name}: its loads are not known: {run.message}", run)
        yield Case(name, case.share / whole, mechanism, run)
