"""Summary of the contacts of a run, joint by joint: share of time, number, forces, energy lost."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from rattle.errors import InputError
from rattle.results.display import quantity, scale
from rattle.results.event import Event, Peak
from rattle.results.sampled_curve import SampledCurve
from rattle.results.trust import Trust
from rattle.value_types import Tree

ROUNDING = 1e-12  # share of the largest kinetic energy, or force, below which a loss, or a force, is rounding
TOWERS = 20.0  # ratio of largest and usual force of a mechanism with rigid contacts, above which it is not shown
ELASTIC = 2.0  # ratio to the largest force of elastic bushes up to which it is shown all the same
ON_EDGE = 1e-6  # share of a gap within which a peak lies on its edge
USUAL, ENOUGH = 0.9, 20  # quantile of the outputs with a force, if there are so many
RISING = ("N", "N*m", "W", "m/s^2", "rad/s^2")  # units of what rises with the force of a contact
SENTENCES = {  # of the contacts of a joint, also in pages
    "impulse": "largest impulse {impulse} (t = {t})",
    "lasting": "lasting contact up to {force}",
    "towers": f"the force of lasting contact rises beyond {TOWERS:g} times the usual one, not to be read as a force",
    "torque": "largest torque {torque} (t = {t})",
    "no_torque": "no torque",
}
OFTEN = (("locks", "lock"), ("slips", "slip"), ("frees", "free"))  # words and events of clutches
SMOOTH = 0.1  # allowed error of the polynomial through five outputs at the two beside them, as a share of the change
REAL = 1e-9  # imaginary part [output intervals] of a root that is rounding


class Curves(Protocol):
    """The part of a result that is summarised here; `result[name]` is a curve (n,) in SI units."""

    @property
    def t(self) -> np.ndarray: ...
    @property
    def geometry(self) -> Tree: ...
    @property
    def trust(self) -> Trust: ...
    @property
    def events(self) -> tuple[Event, ...]: ...
    @property
    def peaks(self) -> Mapping[str, Peak]: ...
    @property
    def with_breaks(self) -> Curves: ...
    def unit(self, name: str) -> str: ...
    def __getitem__(self, name: str) -> np.ndarray: ...
    def __contains__(self, name: object) -> bool: ...


def peak(result: Curves, name: str) -> tuple[float, float]:
    """Largest magnitude of a curve [SI] and its time [s], see `Result.peak`. Raises InputError without an output."""
    within_steps = result.peaks.get(name)
    if within_steps is not None:
        return within_steps.value, within_steps.t
    values = np.abs(result[name])
    if not len(values):
        raise InputError(f"no output, so {name!r} has no peak")
    best = extreme(result.t, values)
    whole = result.with_breaks
    beside = np.abs(whole[name])
    k = int(np.argmax(np.where(np.isfinite(beside), beside, -math.inf)))  # one side of an impact, or in a contact
    if not beside[k] > best[0]:
        return best
    between = SampledCurve(whole.t, whole[name])
    highest = max(between.greatest(), -between.least()) if between.finite else 0.0
    return max(float(beside[k]), highest), float(whole.t[k])


def readable(result: Curves, name: str) -> bool:
    """False if the largest value of a curve says nothing of a real contact, or was not found at all.

    In a mechanism with rigid contacts forces between impacts may rise by orders of magnitude for microseconds: where a
    pin turns in its play with very different masses along and across its path, and where friction nearly locks it.
    What elastic bushes would bear too is left.  Moments, powers, efforts and accelerations rise with the forces.
    Beside a singular position what is largest where forces begin to be left out is a number of that choice.
    """
    value = peak(result, name)[0]
    if not math.isfinite(value) or gap_beside(result, name) is not None:
        return False
    return bool(not rigid_joints(result) or value <= most_readable(result, name))


def gap_beside(result: Curves, name: str) -> float | None:
    """The singular position [s] towards which a curve grows: its peak lies where values begin to be left out."""
    within_steps = result.peaks.get(name)
    if within_steps is None:
        return None
    for instant, gap in zip(result.trust.singular, result.trust.gaps, strict=False):
        if any(abs(within_steps.t - edge) <= ON_EDGE * (gap[1] - gap[0]) for edge in gap):
            return instant
    return None


def why_unread(result: Curves, name: str) -> str:
    """Why the largest value of a curve is not to be read, in words."""
    gap = gap_beside(result, name)
    return "it towers with a rigid contact" if gap is None else f"it grows towards t = {quantity(gap, 's')}"


def most_readable(result: Curves, name: str) -> float:
    """The magnitude [SI] up to which a curve of a mechanism with rigid contacts is to be read; inf where any is."""
    unit, (owner, _, quantity) = result.unit(name), name.rpartition(".")
    if unit not in RISING:
        return math.inf
    of_contact = owner in result.geometry["joints"] and (unit == "N" or quantity == "stop")
    if not of_contact and not result.trust.unread:
        return math.inf
    elastic = max((high for _, high in result.trust.elastic.values()), default=0.0) if unit == "N" else 0.0
    return max(TOWERS * usual(result, name), ELASTIC * elastic)


def towering(result: Curves, names: Iterable[str]) -> tuple[str, ...]:
    """Those of some curves whose largest value says nothing of a real contact; none without rigid contacts."""
    if not len(result.t) or not rigid_joints(result):
        return ()
    return tuple(name for name in sorted(names) if name in result and not readable(result, name))


def no_number(name: str) -> str:
    """Why a curve that towers has no largest value, and what to ask for in its place."""
    return f"{name} towers with a rigid contact; ask for its impulse, or take an elastic one"


def usual(result: Curves, name: str) -> float:
    """A force that is usual while there is one, in its SI unit: at most its RMS, which short towers raise."""
    pressing = np.abs(result[name])
    pressing = pressing[np.isfinite(pressing) & (pressing > 0.0)]
    mean = rms_of(result, name)
    return min(mean, float(np.quantile(pressing, USUAL))) if len(pressing) >= ENOUGH else mean


def unread(result: Curves) -> tuple[str, ...]:
    """Joints whose largest force is not to be read."""
    if not len(result.t) or not rigid_joints(result):
        return ()
    forces = [joint for joint in result.geometry["joints"] if f"{joint}.force" in result]
    return tuple(joint for joint in forces if not readable(result, f"{joint}.force"))


def rigid_joints(result: Curves) -> tuple[str, ...]:
    """Joints with play whose contacts nothing can penetrate: their impacts have impulses, not forces."""
    joints = result.geometry.get("joints", {})
    return tuple(name for name, form in joints.items() if form.get("rigid"))


def rms_of(result: Curves, name: str) -> float:
    """Root mean square of a curve over time, in its SI unit, see `Result.rms`."""
    within_steps = result.peaks.get(name)
    if within_steps is not None:
        return within_steps.rms
    whole = result.with_breaks
    curve = SampledCurve(whole.t, whole[name]) if len(whole.t) else None
    return math.sqrt(curve.mean_square()) if curve is not None and curve.finite else rms(whole.t, whole[name])


def extreme(t: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Maximum of a sampled curve (its unit) and its time [s], interpolated if the curve is smooth there.

    t: (n,) increasing [s], the same one on both sides of a jump.  The polynomial through the five samples around the
    largest must also fit the two beside them; at kinks, jumps and poles it does not, and the largest sample is
    returned.
    """
    finite = np.isfinite(values)
    if not finite.any():
        return math.nan, math.nan
    k = int(np.argmax(np.where(finite, values, -math.inf)))
    best = (float(values[k]), float(t[k]))
    if not 3 <= k < len(t) - 3 or not finite[k - 3 : k + 4].all() or not (np.diff(t[k - 3 : k + 4]) > 0.0).all():
        return best
    near, wide = values[k - 3 : k + 4] - values[k], float(np.ptp(values[k - 3 : k + 4]))
    x = (t[k - 3 : k + 4] - t[k]) / (t[k + 1] - t[k])
    polynomial = np.polynomial.Polynomial.fit(x[1:-1], near[1:-1], 4)
    if wide == 0.0 or np.abs(polynomial(x) - near).max() > SMOOTH * wide:
        return best
    roots = polynomial.deriv().roots()
    at = roots[(abs(roots.imag) < REAL) & (roots.real > x[2]) & (roots.real < x[4])].real
    if not len(at) or float(polynomial(at).max()) <= 0.0:
        return best
    top = at[int(np.argmax(polynomial(at)))]
    return best[0] + float(polynomial(top)), float(t[k] + (t[k + 1] - t[k]) * top)


class ContactSummary(NamedTuple):
    """The contacts of one joint with clearance or a stop over a whole run.

    Forces are normal forces [N] in the clearance; of a joint with a stop only, those of the stop, in its unit.
    """

    share: float  # share of the time in which pin and bush press on each other, 0 to 1
    contacts: int  # contacts that started
    impacts: int  # impacts without duration
    peak: float  # largest force [N or N m], from within the steps
    rms: float  # of the force over the whole run [N or N m]
    longest_flight: float  # longest time without contact [s]
    impulse: float  # largest impulse of an impact [N s or N m s]
    impulse_at: float  # its time [s]; NaN without impacts
    readable: bool  # False: a rigid contact whose largest force says nothing of a real one
    energy_lost: float  # in impacts and contacts, friction included [J]
    power_lost: float  # mean power lost over the run [W]


def contacts(result: Curves) -> dict[str, ContactSummary]:
    """Summary of every joint with a stop or a clearance that is not closed (ideal); units as in `ContactSummary`."""
    return {name: _summary(result, name, force) for name, force in _touching(result)}


def _touching(result: Curves) -> list[tuple[str, str]]:
    """Joints with a stop, or with clearance that is not closed, and the name of the force of their contacts."""
    joints = []
    for name, form in result.geometry["joints"].items() if len(result.t) else ():
        loose = form.get("contact", "") not in ("", "ideal") and f"{name}.normal" in result
        if loose or (form.get("stop") and f"{name}.stop" in result):
            joints.append((name, f"{name}.normal" if loose else f"{name}.stop"))
    return joints


def _pressed(
    result: Curves, joint: str, events: list[Event], normal: np.ndarray, span: float, end: float
) -> tuple[float, float]:
    """Share of the time of a run up to `end`, `span` long [s], in which a joint presses, and its longest flight [s]."""
    t, spans = result.t, pressing_spans(events)
    if joint in result.trust.pulled:  # a massless link presses whenever it does not pull
        return 1.0 - result.trust.pulled[joint], 0.0
    if not spans and span:
        return float(np.trapezoid((normal > 0.0).astype(float), t) / span), _longest_gap(t, normal > 0.0, span)
    share = math.fsum(b - a for a, b in spans) / span if span else float(normal[0] > 0.0)
    edges = [float(t[0]), *(edge for pair in spans for edge in pair), end]
    return share, max(b - a for a, b in zip(edges[::2], edges[1::2], strict=True))


def _energy_lost(result: Curves, events: list[Event]) -> float:
    """Energy [J] that events have taken; 0 if it is rounding."""
    lost = math.fsum(event.energy_lost for event in events)
    rounding = ROUNDING * float(result["energy.kinetic"].max()) if "energy.kinetic" in result else 0.0
    return 0.0 if abs(lost) < rounding else lost


def _summary(result: Curves, joint: str, force: str) -> ContactSummary:
    t, normal = result.t, result[force] if force.endswith(".normal") else np.abs(result[force])
    end = max(float(t[-1]), result.trust.t_end)
    span = end - float(t[0])
    events = [event for event in result.events if event.joint == joint]
    lasting = [event for event in events if event.kind == "contact"]
    hits = [event for event in events if event.kind == "impact"]
    hardest = max(hits, key=lambda event: event.impulse, default=None)
    lost = _energy_lost(result, events)
    share, flight = _pressed(result, joint, events, normal, span, end)
    return ContactSummary(
        share=share,
        contacts=len(lasting),
        impacts=len(hits),
        peak=max([_pressing(result, joint, force), *(event.peak_force for event in lasting)]),
        rms=rms_of(result, force),
        longest_flight=flight,
        impulse=hardest.impulse if hardest else 0.0,
        impulse_at=hardest.t if hardest else math.nan,
        readable=readable(result, force),
        energy_lost=lost,
        power_lost=lost / span if span else 0.0,
    )


def _pressing(result: Curves, joint: str, force: str) -> float:
    """Largest magnitude of a contact force [SI]; of a massless link, which may pull, the largest while it presses."""
    within_steps = result.peaks.get(f"{joint}.pressing") or result.peaks.get(force)
    if within_steps is not None:
        return within_steps.value
    values = result[force] if force.endswith(".normal") else np.abs(result[force])
    return float(np.nanmax(values))


def pressing_spans(events: list[Event]) -> list[tuple[float, float]]:
    """Intervals (start, end) [s] in which any contact of one joint presses: the union of its closed contacts."""
    union: list[tuple[float, float]] = []
    for a, b in sorted((event.t, event.t + event.duration) for event in events if event.kind == "contact"):
        if union and a <= union[-1][1]:
            union[-1] = (union[-1][0], max(b, union[-1][1]))
        else:
            union.append((a, b))
    return union


def _longest_gap(t: np.ndarray, pressing: np.ndarray, span: float) -> float:
    times = t[pressing]
    if not len(times):
        return span
    return float(max(times[0] - t[0], t[-1] - times[-1], np.diff(times).max(initial=0.0)))


def rms(t: np.ndarray, values: np.ndarray) -> float:
    """Root mean square over time of a sampled curve, in its unit; t, values: (n,) [s], any unit.

    Intervals that touch an instant without a value (NaN) are left out.
    """
    finite = np.isfinite(values)
    if not finite.all():
        whole = finite[:-1] & finite[1:]
        parts = 0.5 * (values[:-1] ** 2 + values[1:] ** 2)[whole] * np.diff(t)[whole]
        return math.sqrt(float(parts.sum()) / float(np.diff(t)[whole].sum())) if whole.any() else math.nan
    span = float(t[-1] - t[0])
    return math.sqrt(float(np.trapezoid(values**2, t)) / span) if span else abs(float(values[0]))


def _force_cells(result: Curves, joint: str, readables: Sequence[str], rounding: float) -> tuple[str, ...]:
    """Name of a joint, its peak force and time, and its RMS force; "-" where they say nothing."""
    if joint not in readables:
        gap = gap_beside(result, f"{joint}.force")
        return joint, "-", "-" if gap is None else f"gap {quantity(gap, 's')}", "-"
    (force, when), mean = peak(result, f"{joint}.force"), rms_of(result, f"{joint}.force")
    if not force > rounding:
        return joint, quantity(0.0, "N"), "-", quantity(0.0, "N")
    return joint, quantity(force, "N"), quantity(when, "s"), quantity(mean, "N")


def joint_rows(result: Curves) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """Heading and one row per joint, with units: peak force and its time, RMS force; with play the contact summary.

    Peak and RMS of a run in time are found within its steps, otherwise on a smooth curve through the positions.  With
    rigid contacts the force is that between impacts, and "-" where it says nothing of a real one; their largest impulse
    stands beside the number of impacts.
    """
    loose, rigid = contacts(result), rigid_joints(result)
    head: tuple[str, ...] = ("joint", "lasting force" if rigid else "peak force", "at t", "RMS force")
    if loose:
        head += ("pressing", "contacts", "impacts", "energy lost", "mean power")
        head += ("largest impulse", "at t") if rigid else ()
    rows = []
    loaded = [name for name in result.geometry["joints"] if f"{name}.fx" in result and len(result.t)]
    readables = [name for name in loaded if readable(result, f"{name}.force")]
    rounding = force_rounding(result)
    for joint in loaded:
        row = _force_cells(result, joint, readables, rounding)
        if summary := loose.get(joint):
            row += (f"{100 * summary.share:.0f} %", str(summary.contacts), str(summary.impacts))
            part = " dry" if f"{joint}.film_thickness" in result else ""  # what its oil loses stands in the oil's table
            row += (quantity(summary.energy_lost, "J") + part, quantity(summary.power_lost, "W") + part)
            row += (quantity(summary.impulse, "N*s", 3), quantity(summary.impulse_at, "s")) if summary.impacts else ()
        rows.append(row + ("-",) * (len(head) - len(row)))
    return head, rows


def force_rounding(result: Curves) -> float:
    """Force [N] at and below which that of a joint is rounding."""
    forces = [f"{name}.force" for name in result.geometry["joints"] if f"{name}.fx" in result and len(result.t)]
    return ROUNDING * max((rms_of(result, name) for name in forces if readable(result, name)), default=0.0)


def far_apart(result: Curves) -> dict[str, float]:
    """Rigid joints whose largest force is far below that of elastic bushes, and the latter [N]."""
    apart = {}
    for joint, (_, high) in result.trust.elastic.items():
        if f"{joint}.force" in result and len(result.t) and high > ELASTIC * peak(result, f"{joint}.force")[0]:
            apart[joint] = high
    return apart


def bracket(result: Curves, joint: str) -> str:
    """The largest forces of elastic bushes in place of a rigid contact, in words: "11 to 70 kN"."""
    low, high = result.trust.elastic[joint]
    factor, unit = scale("N", high)
    return f"{' to '.join(dict.fromkeys((_two(factor * low), _two(factor * high))))} {unit}"


def _two(value: float) -> str:
    """A number with two digits, without an exponent where that is short."""
    return f"{float(f'{value:.2g}'):g}"


def contact_lines(result: Curves) -> tuple[str, ...]:
    """What rigid contacts show, joint by joint: impulses, force of lasting contact, and that of elastic bushes."""
    lines = []
    for joint in rigid_joints(result):
        summary = contacts(result).get(joint)
        if summary is None:
            continue
        phrases = (
            [
                SENTENCES["impulse"].format(
                    impulse=quantity(summary.impulse, "N*s", 3), t=quantity(summary.impulse_at, "s")
                )
            ]
            if summary.impacts
            else []
        )
        if not summary.readable:
            phrases.append(SENTENCES["towers"])
        elif summary.peak > 0.0:
            phrases.append(SENTENCES["lasting"].format(force=quantity(summary.peak, "N")))
        if joint in result.trust.elastic:
            phrases.append(f"elastic bushes would show about {bracket(result, joint)} ({result.trust.bushes[joint]})")
        lines += [f"{joint}: {'; '.join(phrases)}"] if phrases else []
    return (*lines, *clutch_lines(result))


def clutch_lines(result: Curves) -> tuple[str, ...]:
    """How often each clutch locks, slips and lets go, and its largest torque."""
    lines = []
    for joint in result.geometry["joints"] if len(result.t) else ():
        if f"{joint}.locked" not in result:
            continue
        kinds = [event.kind for event in result.events if event.joint == joint]
        often = [
            f"{words} {count} time{'s' if count > 1 else ''}" for words, kind in OFTEN if (count := kinds.count(kind))
        ]
        torque, instant = peak(result, f"{joint}.torque")
        most = SENTENCES["no_torque"]
        if torque:
            most = SENTENCES["torque"].format(torque=quantity(torque, "N*m"), t=quantity(instant, "s"))
        lines.append(f"{joint}: {', '.join([*often, most])}")
    return tuple(lines)


WIDTHS = (14, 12, 14, 10, 10, 9, 14, 13, 17, 12)  # of the columns after the name


def joint_table(result: Curves) -> str:
    """The rows of `joint_rows` as text in columns."""
    head, rows = joint_rows(result)
    wide = max([10, *(len(joint) for joint in result.geometry["joints"])]) + 2
    longest = max(len(row) for row in (head, *rows)) - 1
    widths = [
        max([width, *(len(row[k + 1]) + 2 for row in rows if len(row) > k + 1)])
        for k, width in enumerate(WIDTHS[:longest])
    ]  # long numbers, in units that a user asked for
    return "\n".join(
        f"{name:{wide}s}" + "".join(f"{cell:>{width}s}" for cell, width in zip(cells, widths, strict=False))
        for name, *cells in (head, *rows)
    )
