"""The number that an output is, computed from a result: see `results.reductions` for what each reduction means.

Times are those of the result: from its first to its last instant, with cubic polynomials between them.  Peaks and RMS
of forces, efforts and penetrations come from within the steps where the result has them, see `Result.peak`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from rattle.language import arrays
from rattle.language.syntax import Apply, Name, Node
from rattle.results.event import Peak
from rattle.results.reductions import CONDITIONS, EVENTS, IDEAL, Output, Reduction, argument
from rattle.results.result import Result
from rattle.results.sampled_curve import SampledCurve

SIGNED = ("normal", "penetration")  # quantities whose peak is the largest value, not the largest magnitude


def evaluate(
    output: Output, result: Result, parameters: Mapping[str, float] | None = None, ideal: Result | None = None
) -> float:
    """Value of an output [SI]; nan where something that it needs is not finite.

    parameters: values [SI], by default those of the result's provenance.  ideal: result of the mechanism without play
    at the same instants, if the output needs one.  Of a run that stopped early only what happened before is known: an
    `at` in that time, a `first` that came true.
    Raises ValueError for an `at` outside the run, an `ideal` that is missing or has other instants, a result without
    an instant, and for events of a result that is no run in time; UnknownName for a curve that the result lacks.
    """
    if parameters is None:
        parameters = result.provenance.get("parameters", {})
    if output.ideal_names:
        _require_ideal(output, result, ideal)
    known = _Curves(result, parameters, ideal)
    values = {f"#{k}": _reduce(one, known) for k, one in enumerate(output.reductions)}
    if not all(map(math.isfinite, values.values())):
        return math.nan
    number = float(arrays.evaluate(output.outer, lambda name: values[name] if name in values else parameters[name]))
    return number if math.isfinite(number) else math.nan


def curve_of(
    node: Node, result: Result, parameters: Mapping[str, float], ideal: Result | None = None
) -> SampledCurve:  # fmt: skip
    """The curve of an expression over result names, parameters [SI] and t, as it stands inside a reduction."""
    return _Curves(result, parameters, ideal).curve(node)


def _require_ideal(output: Output, result: Result, ideal: Result | None) -> None:
    """Raise ValueError if the result without play is missing or has other instants."""
    if ideal is None:
        raise ValueError(f"{output.text!r} needs a result of the mechanism without play (ideal)")
    if ideal.success and result.success and not np.array_equal(ideal.t, result.t):
        raise ValueError("the results with and without play must have the same instants")


class _Curves:
    """Curves by name, parameters and `t` of one run."""

    def __init__(self, result: Result, parameters: Mapping[str, float], ideal: Result | None) -> None:
        self.result, self.parameters, self.ideal = result, parameters, ideal
        shared = len(result.t) if ideal is None else min(len(result.t), len(ideal.t))  # of a run that stopped early
        self.t = result.t[:shared]
        self.whole = result.success and (ideal is None or ideal.success)

    def of_name(self, name: str) -> NDArray[np.float64] | float:
        if name == "t":
            return self.t
        if name in self.parameters:
            return self.parameters[name]
        if name.startswith(IDEAL) and name not in self.result and self.ideal is not None:
            return self.ideal[name[len(IDEAL) :]][: len(self.t)]
        return self.result[name][: len(self.t)]

    def curve(self, node: Node) -> SampledCurve:
        """The values of an expression at all instants."""
        values = arrays.evaluate(node, self.of_name)
        return SampledCurve(self.t, np.broadcast_to(values, self.t.shape))


def _reduce(one: Reduction, known: _Curves) -> float:
    """Value of one reduction [SI]."""
    if one.kind == "count":
        return _count(one, known.result)
    curve = known.curve(one.inner)
    if one.kind == "at":
        return _at(one, curve, known)
    if not curve.finite:
        return math.nan
    if one.kind == "first":
        return _first(curve, one.strict)
    if not known.whole:
        return math.nan
    if one.kind in CONDITIONS:
        return _share(curve, one.strict)
    if one.kind == "quantile":
        share = argument(one, known.parameters)
        return curve.quantile(share) if 0.0 <= share <= 1.0 else math.nan
    return _number(one, curve, known.result)


def _number(one: Reduction, curve: SampledCurve, result: Result) -> float:
    """Reductions of a whole curve."""
    peak = _peak(one.inner, result)
    if one.kind == "max":
        return max(curve.greatest(), peak.value if peak else -math.inf)
    if one.kind == "min":
        return curve.least()
    if one.kind == "range":
        return max(curve.greatest(), peak.value if peak else -math.inf) - curve.least()
    if one.kind == "mean":
        return curve.mean()
    if one.kind == "integral":
        return curve.integral()
    if one.kind == "final":
        return float(curve.values[-1])
    if one.kind == "sd":
        return math.sqrt(curve.mean_square(curve.mean()))
    known = _rms(one.inner, result)
    return math.sqrt(curve.mean_square()) if known is None else known


def _at(one: Reduction, curve: SampledCurve, known: _Curves) -> float:
    """Value at an instant; nan after the end of a run that stopped early."""
    t, first, last = argument(one, known.parameters), float(curve.t[0]), float(curve.t[-1])
    if first <= t <= last:
        return curve.at(t)
    if t > last and not known.whole:
        return math.nan
    raise ValueError(f"at(..., {t:g}): the instant is outside the run, which goes from {first:g} to {last:g} s")


def _share(curve: SampledCurve, strict: bool) -> float:
    """Share of the time in which the curve is positive, or not negative."""
    if not curve.span:
        return float(curve.values[0] > 0.0 or (not strict and curve.values[0] == 0.0))
    if strict:
        return curve.time_above(0.0) / curve.span
    return 1.0 - _negative(curve).time_above(0.0) / curve.span


def _first(curve: SampledCurve, strict: bool) -> float:
    """First instant [s] at which the curve is positive, or not negative; nan if there is none."""
    holds = curve.values > 0.0 if strict else curve.values >= 0.0
    best = float(curve.t[np.argmax(holds)]) if holds.any() else math.inf  # at the latest
    if strict:
        start, _ = curve.spans_above(0.0)
        best = min(best, float(start[0])) if len(start) else best
    else:  # the end of the first time in which it is negative
        start, end = _negative(curve).spans_above(0.0)
        gaps = np.flatnonzero(start[1:] > end[:-1])
        last = end[gaps[0]] if len(gaps) else (end[-1] if len(end) else math.inf)
        best = min(best, float(last)) if last < curve.t[-1] else best
    return best if best < math.inf else math.nan


def _negative(curve: SampledCurve) -> SampledCurve:
    return SampledCurve(curve.t, -curve.values)


def _count(one: Reduction, result: Result) -> float:
    """Number of events of a joint; nan of a run that stopped early."""
    analysis = result.provenance.get("analysis", "simulate")
    if analysis != "simulate":
        raise ValueError(f"events are counted in a run in time (simulate), and this is a result of {analysis}")
    joint, _, events = one.inner.name.rpartition(".") if isinstance(one.inner, Name) else ("", "", "")
    found = sum(event.joint == joint and event.kind == EVENTS[events] for event in result.events)
    return float(found) if result.success else math.nan


# ---------------------------------------------------------------- from within the steps
def _within(node: Node, result: Result) -> tuple[str, str, bool] | None:
    """Owner and quantity of a curve or of its magnitude (True), if the result covers the run from its start."""
    magnitude = isinstance(node, Apply) and node.name == "abs"
    inside = node.operands[0] if isinstance(node, Apply) and magnitude else node
    if not isinstance(inside, Name) or inside.name not in result.peaks or inside.name not in result:
        return None
    if result.t[0] > 0.0 or result.t[-1] < result.trust.t_end:
        return None
    owner, _, quantity = inside.name.rpartition(".")
    return owner, quantity, magnitude


def _peak(node: Node, result: Result) -> Peak | None:
    """The peak from within the steps that is the maximum of this curve."""
    found = _within(node, result)
    if found is None:
        return None
    owner, quantity, magnitude = found
    joint = owner in result.geometry.get("joints", {})
    if magnitude:
        return result.peaks[f"{owner}.{quantity}"]
    if joint and quantity == "normal":  # of a massless link, which may also pull, the peak is that of the magnitude
        return result.peaks.get(f"{owner}.pressing") or result.peaks[f"{owner}.normal"]
    if joint and (quantity == "force" or quantity in SIGNED):
        return result.peaks[f"{owner}.{quantity}"]
    return None


def _rms(node: Node, result: Result) -> float | None:
    """The RMS from within the steps of this curve, if the result has it."""
    found = _within(node, result)
    return result.peaks[f"{found[0]}.{found[1]}"].rms if found is not None else None
