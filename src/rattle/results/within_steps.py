"""What a curve reaches between the outputs of a run: its largest magnitude within the steps, and short contacts.

Pictures and pages mark both, so that none shows less than the tables say, and nothing of what towers without meaning
in rigid contacts: curves are cut there, and `cut` says so.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rattle.results import contact_summary
from rattle.results.contact_summary import Curves

GREATEST = ("penetration", "tight")  # quantities whose peak is their greatest value, not their largest magnitude
CUT = "cut where it towers"  # said of a curve of a rigid contact of which not all is shown
UNSEEN = 2.0  # output intervals: a contact that is shorter may lie between two outputs, or show one value of many


class Value(NamedTuple):
    """One value of a curve."""

    t: float  # [s]
    y: float  # in the SI unit of the curve


def shown_limit(result: Curves, name: str) -> float:
    """The magnitude [SI] up to which a curve is shown; inf where all of it is."""
    if not contact_summary.towering(result, [name]):
        return math.inf
    return contact_summary.TOWERS * contact_summary.usual(result, name)


def shown_curve(result: Curves, name: str) -> np.ndarray:
    """A curve (n,) [SI] as it is shown: nan where the force of a rigid contact towers without meaning."""
    values, limit = result[name], shown_limit(result, name)
    return values if limit == math.inf else np.where(np.abs(values) <= limit, values, math.nan)


def cut(result: Curves, name: str) -> str:
    """What is said of a curve of which not all is shown; "" if all is."""
    return CUT if shown_limit(result, name) < math.inf else ""


def summit(result: Curves, name: str) -> Value | None:
    """The largest magnitude of a curve within the steps, with the sign that the curve has there.

    None if it is not known, or is not to be read.
    """
    peak = result.peaks.get(name)
    if peak is None or name not in result or not len(result.t) or not 0.0 < peak.value < math.inf:
        return None
    if cut(result, name) or contact_summary.gap_beside(result, name) is not None:
        return None
    return Value(peak.t, math.copysign(peak.value, _sign_at(result, name, peak.t)))


def _sign_at(result: Curves, name: str, instant: float) -> float:
    """Sign of a curve at an instant [s]: of the larger of the two outputs around it; positive where both are zero.

    A penetration and a tight strand are largest where they are positive, however far apart the surfaces are beside it.
    """
    if name.rpartition(".")[2] in GREATEST:
        return 1.0
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
    limit = shown_limit(result, name)
    unseen = [event for event in mine if 0.0 < event.peak_force <= limit and event.duration < short]
    return [Value(event.t + 0.5 * event.duration, event.peak_force) for event in unseen]


def largest(result: Curves, name: str) -> float:
    """Largest magnitude of a curve that is shown: at an output, within the steps, in a short contact; 0 if none is."""
    values = shown_curve(result, name)
    marks = [abs(extreme.y) for extreme in (summit(result, name), *bursts(result, name)) if extreme is not None]
    return max([float(np.abs(values[np.isfinite(values)]).max(initial=0.0)), *marks])
