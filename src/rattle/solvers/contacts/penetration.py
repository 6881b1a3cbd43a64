"""Contacts inside their walls: a contact that was missed ends a run."""

from __future__ import annotations

from rattle.equations.complementarity import OFF
from rattle.equations.compliant import locate_contacts
from rattle.equations.motion import place
from rattle.equations.one_way import from_side
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native

DEEP = 1e-6  # share of its scale that a gap may be below zero: errors of integration and rounding are far smaller
ESCAPED = 21  # end of a run: a contact is inside its wall
OF_SCALE = 1e-12  # share of the scale of a gap that may be rounding
OF_COORDINATES = 1e-15  # the same of the coordinates of its bodies and the arms: a few spacings of numbers


@compiled
def scale_of(m, n):
    """Size of the gap of contact n by which tolerances are set [m or rad]: for a pin or a block its clearance."""
    return m.lever[n, at.GAP_SCALE]


@native("i", "h", "v")
def escaped(m, y):
    """True if an open contact is inside its wall in the state y, deeper than DEEP of its scale.

    One that was inside after the projection may be as deep as at the start of the step.
    """
    nq = m.change.shape[0]
    if m.contact.shape[0] == 0:
        return False
    place(m, y[:nq], y[nq : 2 * nq])
    locate_contacts(m)
    return inside_wall(m)


@compiled
def is_open(m, n):
    """True if contact n touches nothing: a rigid one by its mode, a compliant one by its memory."""
    return m.mode[n] == OFF if m.contact[n, at.IMPACT] == 1 else m.contact_memory[n, at.CLOSED] == at.OPEN


@compiled
def inside_wall(m):
    """`escaped` at the present state."""
    kinematics, memory = m.contact_kinematics, m.contact_memory
    for n in range(kinematics.shape[0]):
        deepest_gap = min(memory[n, at.GAP_0], 0.0) - DEEP * scale_of(m, n)
        if is_open(m, n) and not kinematics[n, at.GAP] >= deepest_gap and not from_side(m, n):
            return True
    return False


@compiled
def deepest(m):
    """Largest depth of a set-valued contact in its wall, as a share of its scale, from the present gaps."""
    kinematics, worst = m.contact_kinematics, 0.0
    for n in range(kinematics.shape[0]):
        if m.contact[n, at.IMPACT] == 1:
            worst = max(worst, -kinematics[n, at.GAP] / scale_of(m, n))
    return worst
