"""What a curve reaches between the outputs of a run: its largest magnitude within the steps, and short contacts.

Pictures and pages mark both, so that none shows less than the tables say.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple, Protocol

import numpy as np

from rattle.results.event import Event, Peak

UNSEEN = 2.0  # output intervals: a contact that is shorter may lie between two outputs, or show one value of many


class Value(NamedTuple):
    """One value of a curve."""

    t: float  # [s]
    y: float  # in the SI unit of the curve


class Curves(Protocol):
    """The part of a result that is read here; `result[name]` is a curve (n,) in SI units."""

    @property
    def t(self) -> np.ndarray: ...
    @property
    def events(self) -> tuple[Event, ...]: ...
    @property
    def peaks(self) -> Mapping[str, Peak]: ...
    def __getitem__(self, name: str) -> np.ndarray: ...
    def __contains__(self, name: object) -> bool: ...


def summit(result: Curves, name: str) -> Value | None:
    """The largest magnitude of a curve within the steps, with the sign that the curve has there; None if unknown."""
    peak = result.peaks.get(name)
    if peak is None or name not in result or not len(result.t) or not 0.0 < peak.value < math.inf:
        return None
    return Value(peak.t, math.copysign(peak.value, _sign_at(result, name, peak.t)))


def _sign_at(result: Curves, name: str, instant: float) -> float:
    """Sign of a curve at an instant [s]: of the larger of the two outputs around it; positive where both are zero."""
    k = int(np.searchsorted(result.t, instant))
    around = result[name][max(0, k - 1) : k + 1]
    return float(around[np.argmax(np.abs(around))]) if np.isfinite(around).all() and around.any() else 1.0


def bursts(result: Curves, name: str) -> list[Value]:
    """Contacts too short to be seen between two outputs, of a curve `<joint>.normal`: the force that each reaches."""
    joint, _, what = name.rpartition(".")
    if what != "normal" or len(result.t) < 2:
        return []
    short = UNSEEN * float(result.t[-1] - result.t[0]) / (len(result.t) - 1)
    mine = [event for event in result.events if event.joint == joint and event.kind == "contact"]
    unseen = [event for event in mine if event.peak_force > 0.0 and event.duration < short]
    return [Value(event.t + 0.5 * event.duration, event.peak_force) for event in unseen]


def largest(result: Curves, name: str) -> float:
    """Largest magnitude of a curve that is known: at an output, within the steps, in a short contact; 0 if none is."""
    values = result[name]
    marks = [abs(one.y) for one in (summit(result, name), *bursts(result, name)) if one is not None]
    return max([float(np.abs(values[np.isfinite(values)]).max(initial=0.0)), *marks])
