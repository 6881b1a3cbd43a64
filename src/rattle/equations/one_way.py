"""Corners over a segment, which bears on one side: when they are below it and touch nothing, when they leave its end.

A located zero of the gap is no impact where a corner that was below comes up, or one that was beside the segment comes
under it: there the gap jumps.  A closed contact ends where its corner leaves the segment, with whatever force it has.
See `elements.one_sided.on_segment`.
"""

from __future__ import annotations

from rattle.equations.compliant import locate_contacts
from rattle.jit import layout as at
from rattle.jit.functions import compiled

BELOW = 10.0  # times the rounding of a gap: a corner not farther below a segment is on it
AT_END = 1e-6  # share of the segment: a corner deeper than it is over it, and no more than that, has come from its side
LEAST = 1e-300  # force [N] that counts as negative


@compiled
def from_side(m, n):
    """True if open contact n has just come under its segment from beside it, not from above: its gap has jumped."""
    if m.lever[n, at.ONE_WAY] == 0.0 or m.contact_kinematics[n, at.PHASE] != at.AWAKE:
        return False
    depth, over = -m.contact_kinematics[n, at.ABOVE], -m.contact_kinematics[n, at.BEYOND]
    return 0.0 <= over < depth and over <= AT_END * m.lever[n, at.GAP_SCALE]


@compiled
def passes(m, n, slight):
    """True if contact n has found its gap to be zero without touching: it is asleep now, or awake.

    slight: depth that is rounding [m].
    """
    if m.lever[n, at.ONE_WAY] == 0.0:
        return False
    row = m.contact_kinematics[n]
    if row[at.PHASE] == at.ASLEEP:
        row[at.PHASE] = at.AWAKE
    elif not goes_under(m, n, slight):
        return False
    locate_contacts(m)
    return True


@compiled
def goes_under(m, n, slight):
    """True if open contact n has come under its segment from its side, by more than `slight`: it is asleep from now on.

    Its geometry remains to be found.
    """
    if not from_side(m, n) or not m.contact_kinematics[n, at.ABOVE] < -BELOW * slight:
        return False
    m.contact_kinematics[n, at.PHASE], m.contact_memory[n, at.LEFT_END] = at.ASLEEP, 1.0
    return True


@compiled
def any_one_way(m):
    """True if there are corners over segments, or edges on ends of one."""
    for n in range(m.contact.shape[0]):
        if m.lever[n, at.ONE_WAY] > 0.0:
            return True
    return False


@compiled
def follow_sides(m):
    """In the middle and at the end of a step of fixed length: corners below and beside their segment, and above it."""
    changed = False
    for n in range(m.contact.shape[0]):
        if m.lever[n, at.ONE_WAY] == 0.0:
            continue
        row = m.contact_kinematics[n]
        asleep = row[at.PHASE] == at.ASLEEP
        if (asleep and row[at.ABOVE] > 0.0) or (not asleep and row[at.ABOVE] < 0.0 and row[at.BEYOND] > 0.0):
            row[at.PHASE], changed = at.AWAKE if asleep else at.ASLEEP, True
            if not asleep:
                m.contact_memory[n, at.LEFT_END] = 1.0
    if changed:
        locate_contacts(m)


@compiled
def hold(m, n, closed):
    """Contact n is closed from now on, or open: while it is closed its gap is that of the whole line."""
    if m.lever[n, at.ONE_WAY] > 0.0 and m.contact_kinematics[n, at.PHASE] != at.ASLEEP:
        m.contact_kinematics[n, at.PHASE] = at.HELD if closed else at.AWAKE


@compiled
def off_end(m, n):
    """True if the corner of closed contact n is beyond the end of its segment."""
    return m.contact_kinematics[n, at.PHASE] == at.HELD and m.contact_kinematics[n, at.BEYOND] > 0.0


@compiled
def pressing(m, n):
    """N of closed contact n [N]; where its wall has ended negative, as there it lets go."""
    normal = m.contact_kinematics[n, at.NORMAL]
    return -abs(normal) - LEAST if off_end(m, n) else normal
