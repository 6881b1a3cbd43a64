"""Curves of a motion whose parameters are a little different, to first order.

Curves that jump where contacts begin and end change by the change of their values on both sides of each such instant,
and by that of the instant itself: rows of both sides move along with it, so that any number that is made of the curves
(a maximum, a mean, the time above a limit) can be differenced as if the motion had been run again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from rattle.errors import TraceError
from rattle.questions.sensitivity.contacts import ContactMotion, Met
from rattle.questions.sensitivity.motion import Moment, Motion
from rattle.results.event import Event

MOVED = 1e-7  # share of the run by which the instants of events are moved at most
CLEAR = 2.5  # times as much, within which other rows are left out


@dataclass(frozen=True, eq=False)
class Nearby:
    """Rows of curves with their derivatives by parameters, n rows of nc curves by k parameters."""

    t: np.ndarray  # (n,) [s], in order, an event twice
    shift: np.ndarray  # (n, k) derivatives of these instants
    values: np.ndarray  # (n, nc)
    slopes: np.ndarray  # (n, nc, k) of the values at the instants, which may move
    met: Sequence[Met] = ()  # contacts
    rigid: frozenset[str] = field(default_factory=frozenset)  # joints whose contacts are rigid

    @classmethod
    def of(cls, run: Motion, read_off: np.ndarray) -> Nearby:
        """Those of a motion: outputs, and both sides of events.

        read_off: instants [s] that rows must keep.  Raises TraceError where an event comes at one of them.
        """
        values, slopes = np.array(run.values), np.array(run.derivatives)
        t = run.t_eval[: len(values)]
        rows = [Moment(*row) for row in zip(t, np.zeros(slopes[:, 0].shape), values, slopes, strict=True)]
        events = np.unique([moment.t for moment in run.moments or () if moment.shift.any()])
        near = _distance(t, events) <= CLEAR * MOVED * run.t_end
        if (near & np.isin(t, read_off)).any():
            when = t[near & np.isin(t, read_off)][0]
            raise TraceError(f"no sensitivities: a contact begins or ends at t = {when:.6g} s, which is read off")
        rows += [moment for moment in run.moments or ()]
        kept = [row for row in rows if row.shift.any() or _distance(row.t, events) > CLEAR * MOVED * run.t_end]
        kept.sort(key=lambda row: row.t)  # both sides of an event stay as they are
        columns = (np.array(column) for column in zip(*kept, strict=True))
        if not isinstance(run, ContactMotion):
            return cls(*columns)
        are = run.touching.are
        rigid = frozenset(joint for joint, is_rigid in zip(are.joints, are.rigid, strict=True) if is_rigid)
        return cls(*columns, run.met, rigid)

    def reach(self, k: int) -> float:
        """The largest change of parameter k [SI] that moves no event too far."""
        fastest = max((float(np.abs(met.by_time[k])) for met in self.met), default=0.0)
        fastest = max(fastest, float(np.abs(self.shift[:, k]).max(initial=0.0)))
        return MOVED * float(self.t[-1]) / fastest if fastest > 0.0 else np.inf

    def moved(self, k: int, change: float) -> tuple[np.ndarray, np.ndarray, list[Event]]:
        """Instants (n,) [s], curves (n, nc) and contacts where parameter k has changed [SI]."""
        t = np.maximum.accumulate(self.t + change * self.shift[:, k])
        events = [
            Event(
                met.time + change * met.by_time[k],
                met.joint,
                "impact" if met.joint in self.rigid else "contact",
                met.speed + change * met.by_speed[k],
                peak_force=met.peak + change * met.by_peak[k] if len(met.by_peak) else 0.0,
            )
            for met in self.met
        ]
        return t, self.values + change * self.slopes[:, :, k], events


def _distance(t: np.ndarray | float, events: np.ndarray) -> np.ndarray:
    """(n,) from instants t (n,) to the nearest of events (m,), in order [s]."""
    after = np.searchsorted(events, t)
    bounded = np.concatenate([[-np.inf], events, [np.inf]])
    return np.asarray(np.minimum(t - bounded[after], bounded[after + 1] - t))
