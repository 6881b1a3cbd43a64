"""The number that an output is, computed from a result: see `results.reductions` for what each reduction means.

Times are those of the result: from its first to its last instant, with cubic polynomials between them.  Peaks and RMS
of forces, efforts and penetrations come from within the steps where the result has them, see `Result.peak`: they are
the same numbers whatever the instants.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rattle.errors import InputError
from rattle.language import arrays
from rattle.language.syntax import Apply, Name, Node, names
from rattle.results.contact_summary import RISING, most_readable, towering
from rattle.results.event import Event
from rattle.results.reductions import (
    CONDITIONS,
    EVENTS,
    HARDEST,
    IDEAL,
    MAY_LACK,
    OF_EVENTS,
    READ_OFF,
    Meeting,
    Output,
    Reduction,
    argument,
    meetings,
)
from rattle.results.result import Result
from rattle.results.sampled_curve import SampledCurve

AT_INSTANTS = ("at", "final", "quantile")  # reductions that may miss where a curve towers
FIELDS = {"time": "t", "peak": "peak_force"}  # of an event
TOLD = (*CONDITIONS, *OF_EVENTS)  # those that the height of a curve does not change
SIGNED = ("normal", "penetration", "tight")  # quantities whose peak is the largest value, not the largest magnitude


def evaluate(
    output: Output, result: Result, parameters: Mapping[str, float] | None = None, ideal: Result | None = None
) -> float:
    """Value of an output [SI]; nan where something that it needs is not finite, or towers without meaning.

    parameters: values [SI], by default those of the result's provenance.  ideal: result of the mechanism without play
    at the same instants, if the output needs one.  Of a run that stopped early only what happened before is known: an
    `at` in that time, a `first` that came true, a contact.
    Raises InputError for an `at` outside the run, an `ideal` that is missing or has other instants, a result without
    an instant, and for events of a result that is no run in time; UnknownName for a curve that the result lacks.
    """
    if parameters is None:
        parameters = result.provenance.get("parameters", {})
    if output.ideal_names:
        _require_ideal(output, result, ideal)
    curves = _Curves(result, parameters, ideal)
    if any(_unread(part, curves) for part in output.reductions):
        return math.nan
    values = {f"#{k}": _reduce(reduction, curves) for k, reduction in enumerate(output.reductions)}
    if not all(map(math.isfinite, values.values())):
        return math.nan
    number = float(arrays.evaluate(output.outer, lambda name: values[name] if name in values else parameters[name]))
    return number if math.isfinite(number) else math.nan


def may_tower(outputs: Iterable[Output], unit_of: Callable[[str], str], joints: Mapping[str, Any]) -> list[str]:
    """Joints with rigid contacts beside which a curve of these outputs may tower; none where no output needs one.

    unit_of: the SI unit of a curve, "" of other names; joints: of a geometry, see `columns.geometry`.
    """
    told = (part for output in outputs for part in output.reductions if part.kind not in TOLD)
    rises = any(unit_of(name) in RISING for part in told for name in names(part.inner))
    return [name for name, form in joints.items() if form.get("rigid")] if rises else []


def unread_curves(output: Output, result: Result) -> tuple[str, ...]:
    """Curves that tower without meaning in a result with rigid contacts, so that the output is no number."""
    curves = _Curves(result, result.provenance.get("parameters", {}), None)
    return tuple(dict.fromkeys(name for part in output.reductions for name in _unread(part, curves)))


def missing_curves(output: Output, result: Result) -> tuple[str, ...]:
    """Curves that are left out at every instant, so that the output is no number."""
    if not len(result.t) or not result.left_out.all():
        return ()
    read = dict.fromkeys(name for part in output.reductions for name in names(part.inner) if name in result)
    return tuple(name for name in read if not np.isfinite(result[name]).any())


def _unread(part: Reduction, curves: _Curves) -> tuple[str, ...]:
    """Curves that tower without meaning and on which the number of a reduction depends."""
    towers = () if part.kind in TOLD else towering(curves.outputs, names(part.inner))
    if not towers or part.kind not in AT_INSTANTS:
        return towers
    name = watched(part.inner, towers)[0]
    small = name and abs(_reduce(part, curves)) <= most_readable(curves.outputs, name)
    return () if small else towers


def curve_of(
    node: Node, result: Result, parameters: Mapping[str, float], ideal: Result | None = None
) -> SampledCurve:  # fmt: skip
    """The curve of an expression over result names, parameters [SI] and t through the outputs of a result."""
    return _Curves(result, parameters, ideal, broken=False).curve(node)


def _require_ideal(output: Output, result: Result, ideal: Result | None) -> None:
    """Raise InputError if the result without play is missing or has other instants."""
    if ideal is None:
        raise InputError(f"{output.text!r} needs a result of the mechanism without play (ideal)")
    if ideal.success and result.success and not np.array_equal(ideal.t, result.t):
        raise InputError("the results with and without play must have the same instants")


class _Curves:
    """Curves by name, parameters and `t` of one run."""

    def __init__(
        self, result: Result, parameters: Mapping[str, float], ideal: Result | None, broken: bool = True
    ) -> None:
        """broken: with both sides of every event."""
        shared = len(result.t) if ideal is None else min(len(result.t), len(ideal.t))  # of a run that stopped early
        self.whole = result.success and (ideal is None or ideal.success)
        end = result.t[:shared][-1] if shared else -math.inf
        self.outputs = result  # without both sides of events
        self.result = result.with_breaks if broken else result
        self.count = int(np.searchsorted(self.result.t, end, side="right"))
        self.parameters, self.ideal = parameters, ideal
        self.t = self.result.t[: self.count]
        self.left_out = self.result.left_out[: self.count]

    def of_name(self, name: str) -> NDArray[np.float64] | float:
        if name == "t":
            return self.t
        if name in self.parameters:
            return self.parameters[name]
        if name.startswith(IDEAL) and name not in self.result and self.ideal is not None:
            return self.of_ideal(name[len(IDEAL) :])
        return self.result[name][: self.count]

    def of_ideal(self, name: str) -> NDArray[np.float64]:
        """A curve of the mechanism without play at these instants: it has other events, and mostly none."""
        assert self.ideal is not None
        if len(self.ideal.t) >= len(self.t) and np.array_equal(self.ideal.t[: len(self.t)], self.t):
            return self.ideal[name][: len(self.t)]
        whole = self.ideal.with_breaks
        curve = SampledCurve(whole.t, whole[name])
        return np.array([curve.at(float(t)) for t in self.t])

    def curve(self, node: Node) -> SampledCurve:
        """The values of an expression at all instants but those at which they are left out of the result."""
        values = np.broadcast_to(arrays.evaluate(node, self.of_name), self.t.shape)
        for name in names(node) if self.left_out.any() else ():  # a condition on what is left out has no value either
            values = np.where(self.left_out & ~np.isfinite(self.of_name(name)), np.nan, values)
        kept = np.flatnonzero(np.isfinite(values) | ~self.left_out)
        if not len(kept):  # a curve without any value
            kept = np.arange(len(values))
        beside = np.diff(kept) > 1  # the curve is straight across what is left out: both ends are breaks
        kept = np.sort(np.concatenate([kept, kept[:-1][beside], kept[1:][beside]]))
        return SampledCurve(self.t[kept], values[kept])


def _reduce(reduction: Reduction, curves: _Curves) -> float:
    """Value of one reduction [SI]."""
    if reduction.kind in OF_EVENTS:
        return _of_events(reduction, curves.result)
    curve = curves.curve(reduction.inner)
    if reduction.kind == "at":
        return _at(reduction, curve, curves)
    if not curve.finite:
        return math.nan
    if reduction.kind == "first":
        return _first(curve, reduction.strict)
    if not curves.whole:
        return math.nan
    if reduction.kind in CONDITIONS:
        return _share(curve, reduction.strict)
    if reduction.kind == "quantile":
        share = argument(reduction, curves.parameters)
        return curve.quantile(share) if 0.0 <= share <= 1.0 else math.nan
    return _number(reduction, curve, curves.result)


def _number(reduction: Reduction, curve: SampledCurve, result: Result) -> float:
    """Reductions of a whole curve."""
    if reduction.kind == "max":
        return _greatest(reduction.inner, curve, result)
    if reduction.kind == "min":
        return curve.least()
    if reduction.kind == "range":
        return _greatest(reduction.inner, curve, result) - curve.least()
    if reduction.kind == "mean":
        return curve.mean()
    if reduction.kind == "integral":
        return curve.integral()
    if reduction.kind == "final":
        return float(curve.values[-1])
    if reduction.kind == "sd":
        return math.sqrt(curve.mean_square(curve.mean()))
    name = watched(reduction.inner, result.peaks)[0] if _covers(result) else ""
    return result.peaks[name].rms if name else math.sqrt(curve.mean_square())


def _greatest(node: Node, curve: SampledCurve, result: Result) -> float:
    """The greatest value of a curve: the peak from within the steps, where there is one."""
    name = peak_of(node, result.peaks, result.geometry.get("joints", {})) if _covers(result) else ""
    return result.peaks[name].value if name else curve.greatest()


def _at(reduction: Reduction, curve: SampledCurve, curves: _Curves) -> float:
    """Value at an instant; nan after the end of a run that stopped early."""
    t, first, last = argument(reduction, curves.parameters), float(curve.t[0]), float(curve.t[-1])
    if first <= t <= last:
        k = int(np.searchsorted(curve.t, t))
        beside = (curves.t > curve.t[max(k - 1, 0)]) & (curves.t < curve.t[k])
        if curve.t[k] != t and curves.left_out[beside].any():
            raise InputError(
                f"at(..., {t:g}): forces are not determined from {curve.t[k - 1]:.6g} to {curve.t[k]:.6g} s, next to a"
                " singular position; ask for another instant"
            )
        return curve.at(t)
    if t > last and not curves.whole:
        return math.nan
    raise InputError(f"at(..., {t:g}): the instant is outside the run, which goes from {first:g} to {last:g} s")


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


def _of_events(part: Reduction, result: Result) -> float:
    """Number of events of a joint, or the largest impulse of its impacts [N s or N m s]; nan if the run stopped.

    Or when one of its contacts begins, its speed or its largest force; nan if it did not come.
    """
    analysis = result.provenance.get("analysis", "simulate")
    if analysis != "simulate":
        raise InputError(f"events are counted in a run in time (simulate), and this is a result of {analysis}")
    joint, _, events = part.inner.name.rpartition(".") if isinstance(part.inner, Name) else ("", "", "")
    if not result.success and part.kind not in MAY_LACK:
        return math.nan
    mine = [event for event in result.events if event.joint == joint]
    if part.kind == HARDEST:
        return max((event.impulse for event in mine if event.kind == "impact"), default=0.0)
    asked = _counted(mine, events, meetings(result.geometry).get(joint))
    if part.kind == "count":
        return float(len(asked))
    if part.number > len(asked):
        return math.nan
    contact = asked[part.number - 1]
    if part.kind == "speed":  # of a clutch that takes up with an impact, that of the impact
        return max(event.normal_speed for event in mine if event.t == contact.t)
    return float(getattr(contact, FIELDS[part.kind]))


def _counted(events: Sequence[Event], word: str, meeting: Meeting | None) -> list[Event]:
    """Those of the events of a joint that a word stands for, each contact once.

    A rigid contact that stays shut has begun by an impact, and a clutch that takes up with an impact takes up once.
    """
    kinds = set(EVENTS[word])
    if meeting is not None and not meeting.lasting:
        kinds.discard("contact")
    locks = {event.t for event in events if event.kind == "lock" and "lock" in kinds}
    return [event for event in events if event.kind in kinds and not (event.kind == "impact" and event.t in locks)]


# ---------------------------------------------------------------- from within the steps
def needs_curve(reduction: Reduction, quantities: Collection[str], joints: Collection[str]) -> bool:
    """True if a reduction of a run needs instants between those that it reads off.

    quantities: names of those that a run of the mechanism watches from within its steps.  joints: names of its joints.
    """
    if reduction.kind == "max":
        return not peak_of(reduction.inner, quantities, joints)
    if reduction.kind == "rms":
        return not watched(reduction.inner, quantities)[0]
    return reduction.kind not in READ_OFF


def _covers(result: Result) -> bool:
    """True if the result has the instants of its run from start to end, as its peaks have."""
    return not (result.t[0] > 0.0 or result.t[-1] < result.trust.t_end)


def watched(node: Node, quantities: Collection[str]) -> tuple[str, bool]:
    """The quantity that a curve is, and whether it is its magnitude; "" if it is not one that a run watches."""
    magnitude = isinstance(node, Apply) and node.name == "abs"
    inside = node.operands[0] if isinstance(node, Apply) and magnitude else node
    return (inside.name if isinstance(inside, Name) and inside.name in quantities else ""), magnitude


def peak_of(node: Node, quantities: Collection[str], joints: Collection[str]) -> str:
    """The quantity whose peak from within the steps is the maximum of this curve, "" if there is none."""
    name, magnitude = watched(node, quantities)
    owner, _, quantity = name.rpartition(".")
    if magnitude:
        return name
    if owner in joints and quantity == "normal":  # of a massless link, which may also pull, `normal` is the magnitude
        pressing = f"{owner}.pressing"
        return pressing if pressing in quantities else name
    return name if owner in joints and (quantity == "force" or quantity in SIGNED) else ""
