"""Drivers that the joints contradict: rows that repeat each other, with right sides that do not.

Where rows are dependent, N^T Phi_q = 0, a motion exists only if also N^T nu = 0 and N^T gamma = 0, now and later.
"""

from __future__ import annotations

import numpy as np

from rattle.closing import close_position, close_rate, open_by
from rattle.memory import Memory
from rattle.plane import GAMMA, NU
from rattle.singular import left_null, row_lengths
from rattle.system import Compiled

NOISE = 1e-9  # share of the terms of N^T nu that is rounding
CLEAR = 1e-3  # the same where the position has been shaken
SHAKE = 1e-5  # by this much [rad, mechanism sizes]: dependence that goes away is that of a singular position
SHORT = 0.1  # longest step on the way to a later instant [rad, mechanism sizes]
MOST_STEPS = 200
LATER = 8  # instants looked at after the start, the nearest a 2^LATER part of the span away


def contradicted(ready: Compiled, t: float, q: np.ndarray, v: np.ndarray, span: float) -> str:
    """Which drivers the joints (or other drivers) contradict at the state (t, q, v) or soon after it; empty when none.

    span: how far to look ahead [s].  A dead centre is no contradiction: there another position would do.
    """
    if not ready.model.drivers:
        return ""
    memory = ready.memory()
    open_by(memory.handle, t, q, v)
    found = _at_odds(ready, memory, left_null(ready, memory))
    if found and _shaken(ready, t, q, v):
        return _said(ready, found)
    if not found and left_null(ready, memory).shape[1] and np.isfinite(span) and span > 0.0:
        return _later(ready, memory, t, q.copy(), v.copy(), span)
    return ""


def _at_odds(ready: Compiled, memory: Memory, null: np.ndarray, share: float = NOISE) -> tuple[str, ...]:
    """Owners of the dependent rows whose right sides do not go together, at the state in the memory."""
    rows, length = memory["rows"], row_lengths(ready, memory)
    for column in (NU, GAMMA):
        side = rows[:, column] / length
        for k in range(null.shape[1]):
            terms = null[:, k] * side
            if abs(terms.sum()) > share * np.abs(terms).sum() + 1e-12 * np.abs(side).max(initial=0.0):
                return _taking_part(ready, null[:, k : k + 1])
    return ()


def _shaken(ready: Compiled, t: float, q: np.ndarray, v: np.ndarray) -> bool:
    """True when the contradiction is still there a little beside the position."""
    memory = ready.memory()
    near = q + SHAKE * np.random.default_rng(0).uniform(-1.0, 1.0, len(q)) * np.tile(
        [ready.size, ready.size, 1.0], ready.body_count
    )
    open_by(memory.handle, t, near, v)
    return bool(_at_odds(ready, memory, left_null(ready, memory), CLEAR))


def _later(ready: Compiled, memory: Memory, t: float, q: np.ndarray, v: np.ndarray, span: float) -> str:
    """The same at some later instants, as far as positions can be followed."""
    scratch = np.empty_like(q)
    scale = np.tile([1.0 / ready.size, 1.0 / ready.size, 1.0], ready.body_count)
    now, steps = t, 0
    for k in range(LATER, -1, -1):
        mark = t + span * 2.0**-k
        while now < mark:
            if steps == MOST_STEPS:
                return ""
            ahead = min(mark, now + SHORT / max(float(np.abs(scale * v).max()), 1e-300))
            owners = _taking_part(ready, left_null(ready, memory))
            q += (ahead - now) * v
            if not close_position(memory.handle, ahead, q, scratch, 1e-12 * ready.size, 30)[0] <= 1e-9 * ready.size:
                return f"{_said(ready, owners)} (at t = {ahead:.4g} s)" if owners else ""
            close_rate(memory.handle, ahead, q, v)
            now, steps = ahead, steps + 1
        found = contradicted(ready, now, q, v, 0.0)
        if found:
            return f"{found} (at t = {now:.4g} s)"
    return ""


def _taking_part(ready: Compiled, null: np.ndarray) -> tuple[str, ...]:
    """Owners of all dependent rows."""
    size = np.abs(null).max(axis=1, initial=0.0)
    return tuple(dict.fromkeys(ready.rows[int(r)].owner for r in np.argsort(-size) if size[r] > 1e-6))


def _said(ready: Compiled, owners: tuple[str, ...]) -> str:
    drivers = [f"'{one}'" for one in ready.model.drivers if one in owners]
    joints = ", ".join(f"'{one}'" for one in ready.model.joints if one in owners)
    if not drivers:
        return ""
    if len(drivers) > 1:
        listed = f"{', '.join(drivers[:-1])} and {drivers[-1]}"
        many = f"take {'one' if len(drivers) == 2 else 'some'} of them out"
        between = f" (through joints {joints})" if joints else ""
        return f"drivers {listed} drive the same freedom{between} with functions that do not go together; {many}"
    return (
        f"driver {drivers[0]} is contradicted by joints {joints}: they leave its freedom no motion (one driver"
        " too many); take it out, or free a joint"
    )
