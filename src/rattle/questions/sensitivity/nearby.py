"""Curves of a motion whose parameters are a little different, to first order.

Curves that jump where contacts begin and end change by the change of their values on both sides of each such instant,
and by that of the instant itself: rows of both sides move along with it, so that any number that is made of the curves
(a maximum, a mean, the time above a limit) can be differenced as if the motion had been run again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from rattle.errors import TraceError
from rattle.questions.sensitivity.contacts import ContactMotion
from rattle.questions.sensitivity.events import Met
from rattle.questions.sensitivity.motion import Moment, Motion
from rattle.results.event import Event
from rattle.results.reductions import Output, needed_instants

MOVED = 1e-7  # share of the run by which the instants of events are moved at most
ROOM = 0.2  # share of the way to the next event by which an instant that is read off is moved at most
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
    def of(cls, run: Motion, read_off: np.ndarray | None) -> Nearby:
        """Those of a motion: outputs, and both sides of events.

        read_off: instants [s] that rows must keep.  Raises TraceError where an event comes at one of them.
        """
        values, slopes = np.array(run.values), np.array(run.derivatives)
        t, still = run.t_eval[: len(values)], np.zeros(slopes.shape[2])
        if read_off is None or not run.moments:
            return cls(t, np.tile(still, (len(t), 1)), values, slopes, *_contacts(run))
        events = {moment.t: moment.shift for moment in run.moments if moment.shift is not None}
        clear, at = CLEAR * MOVED * run.t_end, np.array(sorted(events))
        fixed, moving = np.flatnonzero(np.isin(t, read_off)), np.array([time for time in at if events[time].any()])
        if (near := t[fixed][_distance(t[fixed], moving) <= clear]).size:
            raise TraceError(f"no sensitivities: a contact begins or ends at t = {near[0]:.6g} s, which is read off")
        rows = [Moment(t[n], values[n], slopes[n], np.zeros(len(values[n])), still) for n in fixed]
        rows += [row for row in run.moments if row.shift is not None or _distance(row.t, at) > clear]
        rows.sort(key=lambda row: row.t)  # both sides of an event stay as they are
        shift = _shifts(rows, {**dict.fromkeys([0.0, *t[fixed].tolist(), run.t_end], still), **events})
        along = np.array([row.slopes for row in rows])
        along += np.array([row.rates for row in rows])[:, :, None] * shift[:, None, :]
        instants, values = (np.array([row[part] for row in rows]) for part in (0, 1))
        return cls(instants, shift, values, along, *_contacts(run))

    def holds(self, output: Output, parameters: Mapping[str, float]) -> bool:
        """Whether the instants that an output reads off are among the rows."""
        return bool(np.isin(needed_instants(output, parameters), self.t).all())

    def scale(self, k: int) -> float:
        """Change of parameter k [SI] that changes a curve by about its size; at most 1."""
        sizes = np.abs(self.values).max(axis=0, initial=0.0)
        changes = np.abs(self.slopes[:, :, k]).max(axis=0, initial=0.0)
        return float(np.min(sizes[changes > sizes] / changes[changes > sizes], initial=1.0))

    def reach(self, k: int) -> float:
        """The largest change of parameter k [SI] that moves no event too far."""
        fastest = max((float(np.abs(met.by_time[k])) for met in self.met), default=0.0)
        fastest = max(fastest, float(np.abs(self.shift[:, k]).max(initial=0.0)))
        return MOVED * float(self.t[-1]) / fastest if fastest > 0.0 else np.inf

    def passes_none(self, before: np.ndarray, after: np.ndarray) -> float:
        """Share of a change up to which instants (n,) [s] that move from `before` to `after` meet no event."""
        events = np.array([met.time for met in self.met] + self.t[self.shift.any(axis=1)].tolist())
        share = 1.0
        for first, last in zip(before, after, strict=True):
            room = np.abs(events - first).min(initial=np.inf)
            share = min(share, ROOM * room / abs(last - first)) if last != first else share
        return share

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


def _contacts(run: Motion) -> tuple[Sequence[Met], frozenset[str]]:
    """Those of a motion, and the joints whose contacts are rigid."""
    if not isinstance(run, ContactMotion):
        return (), frozenset()
    are = run.touching.are
    return run.met, frozenset(joint for joint, rigid in zip(are.joints, are.rigid, strict=True) if rigid)


def _shifts(rows: Sequence[Moment], knots: Mapping[float, np.ndarray]) -> np.ndarray:
    """(n, k) derivatives of the instants of rows: their own, or between those of the knots, by time [s]."""
    times = np.array(sorted(knots))
    own, at_knots = np.array([row.t for row in rows]), np.array([knots[time] for time in times])
    shifts = np.stack([np.interp(own, times, column) for column in at_knots.T], axis=1)
    for n, row in enumerate(rows):
        shifts[n] = shifts[n] if row.shift is None else row.shift
    return shifts
