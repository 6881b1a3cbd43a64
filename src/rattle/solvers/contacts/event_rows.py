"""Rows of the array `events`: changes of contacts and their times."""

from __future__ import annotations

from rattle.equations.state import IMPULSE, LOSS, STORED, account_at
from rattle.jit import layout as at
from rattle.jit.functions import compiled


@compiled
def note(m, kind, n, t, speed):
    """Write a row for contact n at t [s], with its normal speed [m/s]; returns its index, -1 if there is no room."""
    tally, events = m.tally, m.events
    k = tally[at.EVENT_COUNT]
    if k == events.shape[0]:
        return -1
    for column in range(events.shape[1]):
        events[k, column] = 0.0
    events[k, at.EVENT_T], events[k, at.EVENT_CONTACT], events[k, at.EVENT_KIND] = t, n, kind
    events[k, at.EVENT_SPEED] = speed
    tally[at.EVENT_COUNT] = k + 1
    return k


@compiled
def note_impact(m, n, t, speed, impulse, lost):
    """Record an impact of contact n at t [s]: speed [m/s], impulse [N s], energy lost [J]."""
    k = note(m, at.IMPACT_EVENT, n, t, speed)
    if k >= 0:
        m.events[k, at.EVENT_IMPULSE], m.events[k, at.EVENT_LOSS] = impulse, lost


@compiled
def note_end(m, n, t, y, speed):
    """Record the end of contact n at (t, y), which opens at `speed` [m/s]: completes its event, adds its release."""
    memory, events, account = m.contact_memory, m.events, account_at(m, n)
    k = note(m, at.CONTACT_EVENT, n, memory[n, at.SINCE], memory[n, at.SPEED])
    if k >= 0:
        events[k, at.EVENT_DURATION] = max(t - memory[n, at.SINCE], 0.0)
        events[k, at.EVENT_PEAK] = memory[n, at.PEAK]
        events[k, at.EVENT_IMPULSE] = y[account + IMPULSE] - memory[n, at.IMPULSE_0]
        events[k, at.EVENT_LOSS] = y[account + LOSS] + y[account + STORED] - memory[n, at.LOSS_0]
    note(m, at.RELEASE_EVENT, n, t, speed)
