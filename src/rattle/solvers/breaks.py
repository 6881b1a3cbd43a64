"""Output rows beside events: pairs of them at an event, just before and just after, and single ones in short contacts.

Between two of them every curve is smooth, at a pair it jumps or bends.  A compliant contact may begin and end between
two outputs: rows at the ends of its steps, and where its force is largest, tell how forces and accelerations rise and
fall in it.

`break_rows` holds the rows; `break_times` their number, which has 0.5 more while a pair waits for its second row, then
their times [s].  When there is no room for a pair the event is left out; without such arrays all are.
"""

from __future__ import annotations

from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.solvers.output_row import record


@compiled
def keeps_breaks(m):
    """True if the run keeps rows beside events."""
    return m.break_rows.shape[0] > 0


@compiled
def rows_filled(m):
    """Number of rows but that of an unfinished pair; 0 without arrays for them."""
    return int(m.break_times[0]) if keeps_breaks(m) else 0


@native("void", "h", "f", "v")
def before_break(m, t, y):
    """Write the row just before an event at (t [s], y)."""
    k = rows_filled(m)
    if k + 1 < m.break_rows.shape[0]:
        record(m, t, y, m.break_rows[k])
        m.break_times[k + 1] = t
        m.break_times[0] = k + 0.5


@native("void", "h", "f", "v")
def after_break(m, t, y):
    """Write the row just after it, if there is one just before."""
    k = rows_filled(m)
    if keeps_breaks(m) and m.break_times[0] > k:
        record(m, t, y, m.break_rows[k + 1])
        m.break_times[k + 2] = t
        m.break_times[0] = k + 2.0


@compiled
def in_contact(m):
    """True if a compliant contact has begun and not ended."""
    contact, memory = m.contact, m.contact_memory
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 0 and contact[n, at.LEVEL] == 0 and memory[n, at.CLOSED] == at.SHUT:
            return True
    return False


@native("void", "h", "f", "v")
def row_within(m, t, y):
    """Write a row at (t [s], y), in a compliant contact."""
    k = rows_filled(m)
    if k < m.break_rows.shape[0]:
        record(m, t, y, m.break_rows[k])
        m.break_times[k + 1] = t
        m.break_times[0] = k + 1.0


@native("void", "h", "f", "i", "i")
def rows_at_end(m, t, bends, written):
    """Write the row after a step that has ended at (t [s], state): just after an event if it `bends` there, or in a
    compliant contact where outputs, of which there were `written` before, are not closer to each other than steps."""
    if bends == 1:
        after_break(m, t, m.state)
    elif m.tally[at.OUTPUTS] <= written + 1 and in_contact(m):
        row_within(m, t, m.state)
