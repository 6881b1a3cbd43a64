"""Pawls of ratchets: the tooth behind which each one is, and when it drops behind the next one."""

from __future__ import annotations

import math

from rattle.equations.complementarity import OFF
from rattle.jit import layout as at
from rattle.jit.functions import compiled
from rattle.solvers.contacts.gap_search import NONE, may_reach, search

SEATED = 1e-9  # share of a pitch by which a pawl may be inside its tooth by rounding


@compiled
def pitch_of(m, n):
    """Pitch of the toothed contact n [rad]."""
    return m.values[m.contact[n, at.SHAPE_P] + at.PITCH]


@compiled
def drop_pawl(m, n, teeth):
    """Put the pawl of contact n behind the tooth that is so many teeth further; its gap must then be located anew."""
    m.values[m.contact[n, at.SHAPE_P] + at.TOOTH] -= teeth


@compiled
def seat_pawls(m, back):
    """Put every pawl behind the tooth next to it, so that its gap is less than a pitch; back: and not negative.

    Gaps must be up to date, and are afterwards.
    """
    contact, kinematics = m.contact, m.contact_kinematics
    for n in range(contact.shape[0]):
        if contact[n, at.TOOTHED] == 1:
            teeth = math.floor(kinematics[n, at.GAP] / pitch_of(m, n) + SEATED)
            teeth = teeth if back else max(teeth, 0)
            drop_pawl(m, n, teeth)
            kinematics[n, at.GAP] -= teeth * pitch_of(m, n)


@compiled
def first_drop(m, h, until):
    """Share of the step, up to `until`, at which the first pawl drops behind its next tooth (NONE if none does, or
    GAVE_UP), and its contact.

    That is where p - g becomes negative: it is the gap to the next tooth, which is searched from its other side.
    """
    contact, mode, memory, best, who = m.contact, m.mode, m.contact_memory, NONE, -1
    for n in range(contact.shape[0]):
        if contact[n, at.TOOTHED] == 0 or mode[n] != OFF:
            continue
        share, pitch = NONE, pitch_of(m, n)
        drop_pawl(m, n, 1.0)
        memory[n, at.GAP_0] -= pitch
        memory[n, at.GAP_1] -= pitch
        if may_reach(m, h, n, -1.0):
            share = search(m, h, n, -1.0, min(best, until))
        memory[n, at.GAP_0] += pitch
        memory[n, at.GAP_1] += pitch
        drop_pawl(m, n, -1.0)
        if share > NONE:
            return share, -1
        if share < best:
            best, who = share, n
    return best, who
