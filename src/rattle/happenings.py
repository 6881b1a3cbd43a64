"""Events of a run, from the rows the steppers wrote, and what they say about how far to trust it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from rattle import catalog
from rattle.memory import Memory
from rattle.plane import (
    CLOSED,
    IMPULSE_0,
    LOSS_0,
    OWNER,
    PEAK,
    SHUT,
    SINCE,
    SPEED,
)  # fmt: skip
from rattle.result import Event
from rattle.system import Compiled

KINDS = ("contact", "release", "impact", "stick", "slip")  # in the order of their numbers in `plane`


def contact_events(ready: Compiled, rows: Sequence[np.ndarray], memory: Memory, t: float) -> tuple[Event, ...]:
    """Events in order of time; contacts still going on at the end (time t) come with what they have so far."""
    owner = ready.arrays["contact"][:, OWNER]
    found = []
    for row in np.concatenate(rows) if rows else np.zeros((0, 8)):
        joint = ready.joints[owner[int(row[1])]]
        kind = KINDS[int(row[2])]
        values = row[3:8] if kind in ("contact", "impact") else row[3:4]
        found.append(Event(float(row[0]), joint, kind, *(float(x) for x in values)))
    grip, y = memory["grip"], memory["y"]
    for n in np.flatnonzero(grip[:, CLOSED] == SHUT):
        k = len(y) - 4 * len(grip) + 4 * n
        since, speed, peak = (float(grip[n, c]) for c in (SINCE, SPEED, PEAK))
        impulse, lost = float(y[k + 1] - grip[n, IMPULSE_0]), float(y[k + 2] - grip[n, LOSS_0])
        found.append(Event(since, ready.joints[owner[n]], "contact", speed, t - since, peak, impulse, lost))
    return tuple(sorted(found, key=lambda event: event.t))


def contact_counts(ready: Compiled, events: Sequence[Event], fewest: float) -> dict[str, Any]:
    """What `Trust` says of contacts: how many, impacts, steps of the shortest."""
    if not len(ready.arrays["contact"]):
        return {}
    return {
        "contacts": sum(event.kind == "contact" for event in events),
        "impacts": sum(event.kind == "impact" for event in events),
        "fewest_steps": fewest if fewest < math.inf else None,
    }


def contact_notes(ready: Compiled, events: Sequence[Event]) -> tuple[str, ...]:
    """Remarks on contacts: laws outside their range."""
    found = []
    for name, joint in ready.model.joints.items():
        contact = joint.contact
        if contact is None or contact.normal is None or contact.static is None:
            continue
        peak = max((event.peak_force for event in events if event.joint == name), default=0.0)
        static, normal = catalog.kinds("stiffness")[contact.static.kind], catalog.kinds("normal")[contact.normal.kind]
        found += [f"{name}, {contact.static.kind}: {one}" for one in static.leaf.notes(contact.static.values, peak)]
        if contact.normal.values.get("effective_mass", 1.0) > 0.0:
            found += [f"{name}, {contact.normal.kind}: {one}" for one in normal.leaf.notes(contact.normal.values)]
    return tuple(found)
