"""What the contacts of a run amount to, joint by joint: share of time, number, forces, energy lost."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from rattle.result import Event, Result


class ContactSummary(NamedTuple):
    """One joint with play over a whole run."""

    share: float  # of the time in which pin and bush press on each other, 0 to 1
    contacts: int  # contacts that started
    impacts: int  # impacts without duration
    peak: float  # largest normal force [N], located within the contacts where events know it
    rms: float  # of the normal force over the whole run [N]
    longest_flight: float  # longest time without contact [s]
    energy_lost: float  # in impacts and contacts, friction included [J]
    power_lost: float  # the same per time, mean over the run [W]


def contacts(result: Result) -> dict[str, ContactSummary]:
    """Summary of every joint with play that is not ideal, by name."""
    return {name: _summary(result, name) for name in _loose(result)}


def _loose(result: Result) -> list[str]:
    """Joints whose play the result shows."""
    found = []
    for name, form in result.geometry["joints"].items():
        if form.get("clearance") and form.get("contact") != "ideal" and f"{name}.normal" in result and len(result.t):
            found.append(name)
    return found


def _summary(result: Result, joint: str) -> ContactSummary:
    t, normal = result.t, result[f"{joint}.normal"]
    start, end = float(t[0]), max(float(t[-1]), result.trust.t_end)
    span = end - start
    events = [event for event in result.events if event.joint == joint]
    lasting = [event for event in events if event.kind == "contact"]
    spans = pressing_spans(events)
    lost = math.fsum(event.energy_lost for event in events)
    if joint in result.trust.pulled:  # the massless link: it presses wherever it need not pull
        share, flight = 1.0 - result.trust.pulled[joint], 0.0
    elif spans or not span:
        share = math.fsum(b - a for a, b in spans) / span if span else float(normal[0] > 0.0)
        edges = [start, *(edge for one in spans for edge in one), end]
        flight = max(b - a for a, b in zip(edges[::2], edges[1::2], strict=True))
    else:
        share = float(np.trapezoid((normal > 0.0).astype(float), t) / span)
        flight = _longest_gap(t, normal > 0.0, span)
    return ContactSummary(
        share=share,
        contacts=len(lasting),
        impacts=sum(event.kind == "impact" for event in events),
        peak=max([float(normal.max()), *(event.peak_force for event in lasting)]),
        rms=rms(t, normal),
        longest_flight=flight,
        energy_lost=lost,
        power_lost=lost / span if span else 0.0,
    )


def pressing_spans(events: list[Event]) -> list[tuple[float, float]]:
    """Times in which any contact of one joint presses: the union of its lasting contacts [s]."""
    found: list[tuple[float, float]] = []
    for a, b in sorted((event.t, event.t + event.duration) for event in events if event.kind == "contact"):
        if found and a <= found[-1][1]:
            found[-1] = (found[-1][0], max(b, found[-1][1]))
        else:
            found.append((a, b))
    return found


def _longest_gap(t: np.ndarray, pressing: np.ndarray, span: float) -> float:
    times = t[pressing]
    if not len(times):
        return span
    return float(max(times[0] - t[0], t[-1] - times[-1], np.diff(times).max(initial=0.0)))


def rms(t: np.ndarray, values: np.ndarray) -> float:
    """Root mean square over time of a sampled curve."""
    span = float(t[-1] - t[0])
    return math.sqrt(float(np.trapezoid(values**2, t)) / span) if span else abs(float(values[0]))


def joint_table(result: Result) -> str:
    """Per joint: peak and RMS force; with play also share of time in contact, impacts, energy lost.

    Peak and RMS are those of the outputs; where events know the peak inside a contact it is that.
    """
    loose = contacts(result)
    wide = max([10, *(len(joint) for joint in result.geometry["joints"])]) + 2
    head = f"{'joint':{wide}s}{'peak force':>14s}{'RMS force':>14s}"
    if loose:
        head += f"{'pressing':>10s}{'impacts':>9s}{'energy lost':>14s}{'mean power':>13s}"
    lines = [head]
    for joint in result.geometry["joints"]:
        if f"{joint}.fx" not in result or not len(result.t):
            continue
        force, one = result[f"{joint}.force"], loose.get(joint)
        peak = max(float(force.max()), one.peak) if one else float(force.max())
        line = f"{joint:{wide}s}{peak:12.4g} N{rms(result.t, force):12.4g} N"
        if one:
            line += f"{100 * one.share:8.0f} %{one.contacts + one.impacts:9d}"
            line += f"{one.energy_lost:12.4g} J{one.power_lost:11.4g} W"
        elif loose:
            line += f"{'-':>10s}{'-':>9s}{'-':>14s}{'-':>13s}"
        lines.append(line)
    return "\n".join(lines)
