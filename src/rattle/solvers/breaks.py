"""Output rows on both sides of an event: between two of them every curve is smooth, at one of them it jumps or bends.

`break_rows` holds pairs of rows, just before and just after; `break_times` the number of rows, then their times [s].
When there is no room for a pair the event is left out; without such arrays all are.
"""

from __future__ import annotations

from rattle.jit.functions import compiled, native
from rattle.solvers.output_row import record


@compiled
def rows_filled(m):
    """Number of rows; 0 without arrays for them."""
    return int(m.break_times[0]) if m.break_rows.shape[0] > 0 else 0


@native("void", "h", "f", "v")
def before_break(m, t, y):
    """Write the row just before an event at (t [s], y)."""
    k = rows_filled(m)
    if k % 2 == 1:  # the event before was not finished
        k -= 1
    if k + 1 < m.break_rows.shape[0]:
        record(m, t, y, m.break_rows[k])
        m.break_times[k + 1] = t
        m.break_times[0] = k + 1.0


@native("void", "h", "f", "v")
def after_break(m, t, y):
    """Write the row just after it, if there is one just before."""
    k = rows_filled(m)
    if k % 2 == 1:
        record(m, t, y, m.break_rows[k])
        m.break_times[k + 1] = t
        m.break_times[0] = k + 1.0
