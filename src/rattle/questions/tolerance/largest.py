"""The largest tolerance, or clearance, with which a share of the mechanisms keeps a required accuracy.

All values that are tried have the same points u of the fields (common random numbers), so that the share falls evenly
with the value and its edge is found with few runs (see `edge`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from rattle.analyses import arguments
from rattle.analyses.straight_line.recorded_model import require_parameters
from rattle.errors import AssemblyError, InputError, ModelError, SolverError, WrongType
from rattle.questions.ensemble.fields import Vary, fields_of, varies
from rattle.questions.ensemble.sampling import MOST, points
from rattle.questions.tolerance.bracket import Edge, NotReachedError, edge
from rattle.questions.tolerance.required_accuracy import Within
from rattle.questions.tolerance.what_is_sought import Asked, Sought, scale_of, tolerance_of
from rattle.results.display import lines
from rattle.studies.runs.analyses import analysis_named

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

SIDE_BY_SIDE, ONE_BY_ONE, BANDS = 16_384, 1024, 512  # samples unless given; BANDS: of all positions of the pins
ROUND = 1e-9  # of a number of samples
INSIDE = -1e-3  # excess at 0, at most, for the search: it aims by the rise from there, with 0 at nothing


class Largest(float):
    """The largest tolerance or clearance [SI]; `report` says what it keeps."""

    report: str
    share: float  # of the samples that keep the limits with it
    unit: str  # SI
    parameter: str

    def __new__(
        cls, value: float, report: str = "", share: float = math.nan, unit: str = "", parameter: str = ""
    ) -> Largest:
        largest = super().__new__(cls, value)
        largest.report, largest.share, largest.unit, largest.parameter = report, share, unit, parameter
        return largest

    def __getnewargs__(self) -> Any:
        return float(self), self.report, self.share, self.unit, self.parameter

    def __repr__(self) -> str:
        return f"<rattle.Largest: {self.parameter} {float(self)!r} {self.unit}".rstrip() + ">"

    def __str__(self) -> str:
        return self.report

    def _repr_html_(self) -> str:
        return lines(self.report)


def tolerance_for(
    m: Mechanism, of: str, within: Within, parameter: str, share: float = 0.997, *, vary: Vary = None,
    analysis: str = "simulate", t_end: float | None = None, n: int | None = None, seed: int = 0,
    threads: int | None = None, progress: bool = False,
) -> Largest:  # fmt: skip
    """The largest tolerance or clearance; see `Mechanism.tolerance_for`."""
    for what, text in (("of", of), ("parameter", parameter)):
        if not isinstance(text, str):
            raise WrongType(f"{what}: expected a text, got {text!r:.60}")
    require_parameters(m.system, [parameter])
    kept = arguments.positive("share", share)
    if kept > 1.0:
        raise InputError(f"share must be from 0 to 1, got {share!s:.60}; 99.7 % is 0.997")
    count = None if n is None else arguments.whole("n", n, 1, MOST)
    named = _with_entries(m, vary)
    asked = Asked(m, of, within, m.model.parameters[parameter], named, analysis_named(analysis), t_end)
    play = m.joints_with_clearance(parameter) if parameter not in named else []
    sought = scale_of(asked, play, threads, progress) if play else tolerance_of(asked, threads, progress)
    return _Search(sought, kept, count, seed).result()


def _with_entries(m: Mechanism, vary: Vary) -> Mapping[str, Any]:
    """Parameters that vary, with the entries in which they differ from the file."""
    if isinstance(vary, Mapping):
        if vary:
            fields_of(m, vary)
        return vary
    if vary is not None:
        names = fields_of(m, vary).names if len(vary) or isinstance(vary, str) else ()
        return {name: {} for name in names}
    return {name: {} for name, parameter in m.model.parameters.items() if varies(parameter)}


class _Search:
    """Looks for the largest value, with samples at the same points for all values."""

    def __init__(self, sought: Sought, share: float, n: int | None, seed: int) -> None:
        self.sought, self.share = sought, share
        self.shares: dict[float, float] = {}  # of the samples that keep the limits, by value
        self._known: dict[float, float] = {}
        self.u = np.zeros((1, 0))  # (n, d)
        if sought.draws:
            alone = BANDS if sought.trials.task.analysis == "accuracy" else ONE_BY_ONE
            n = n or (SIDE_BY_SIDE if sought.trials.side_by_side else alone)
            self.u = points("sobol", seed, sought.draws, n).points(0, n)

    def result(self) -> Largest:
        """The largest value.  Raises InputError if there is none."""
        sought = self.sought
        try:
            rest = -1.0
            if sought.from_nothing and (rest := self.excess(0.0)) > 0.0:
                raise NotReachedError(0.0)
            result = edge(self.excess, sought.start, sought.least, sought.most, min(rest, INSIDE))
        except NotReachedError as error:
            raise InputError(self._none(error.least)) from None
        report = "\n".join(self._report(result))
        return Largest(result.value, report, self.shares[result.value], sought.parameter.unit, sought.parameter.name)

    def excess(self, x: float) -> float:
        """How far the worst of the mechanisms that have to keep the limits is beyond them, see `edge`."""
        if x not in self._known:
            try:
                limits = self.sought.limits(x)
            except (ModelError, AssemblyError, SolverError):  # the mechanism from which they are measured has no run
                over = np.full(len(self.u), np.inf)
            else:
                samples = self.sought.trials.run(self.sought.values(x, self.u))
                over = np.max([limits.excess(samples[output]) for output in samples.outputs], axis=0)
            needed = max(math.ceil(self.share * len(over) - ROUND), 1)
            self.shares[x] = float((over <= 0.0).mean())
            self._known[x] = float(np.sort(over)[needed - 1])
        return self._known[x]

    # ---------------------------------------------------------------- words
    def _keep(self) -> str:
        return f"{_percent(self.share)} of the mechanisms keep" if len(self.u) > 1 else "the mechanism keeps"

    def _none(self, least: float) -> str:
        """That no value is small enough."""
        sought = self.sought
        try:
            limits = sought.limits(least).text
        except (ModelError, AssemblyError, SolverError) as error:
            return f"no {sought.what}: {sought.shown(least)}: {error}"
        words = f"not even {sought.what} = {sought.shown(least)} keeps {sought.of} {limits}"
        if len(self.u) > 1:
            kept = _percent(self.shares[least])
            words += f": {kept} of {len(self.u)} samples, expected are {_percent(self.share)}"
        return f"{words}; {sought.remedy}"

    def _report(self, result: Edge) -> list[str]:
        sought, x = self.sought, result.value
        lines = [f"largest {sought.what}: {sought.shown(x)}"]
        lines.append(f"with it {self._keep()} {sought.of} {sought.limits(x).text}")
        if len(self.u) > 1:
            lines.append(f"sampled: {_percent(self.shares[x])} of {len(self.u)} samples")
        if math.isnan(result.over):
            lines.append(f"that is {sought.bound}: what would be beyond was not looked at")
        else:
            lines[-1] += f"; {sought.shown(result.over)} is too much"
            lines[-1] += f" ({_percent(self.shares[result.over])})" if len(self.u) > 1 else ""
        if not math.isnan(result.gap):
            lines.append(
                f"NOT MONOTONE: {sought.shown(result.gap)} is too much, though larger values keep the limits again"
            )
        return [*lines, *sought.notes, f"{sought.trials.count} samples were run for {len(self._known)} values"]


def _percent(share: float) -> str:
    return f"{100.0 * share:.5g} %"
