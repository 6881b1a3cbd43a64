"""Friction that locks a contact (a jam), and how a run passes it: an impact without collision.

A sliding contact needs dg''/dN = G_nn +- mu G_nt > 0: otherwise the force that presses it together makes it approach
(Painleve), and no finite force holds it.  Slip then ends at once, by impulses that leave the contact closed:

    a+ = G f + a-,   a+_n = 0 <= N,  a+_t = 0,  |T| <= mu N           with |T|/N = G_nn/|G_nt| < mu for one contact

They bring rates to zero, so they remove energy, f . G f / 2.

Source: Genot, Brogliato, New results on Painleve paradoxes, Eur. J. Mech. A 18 (1999) 653-677.
"""

from __future__ import annotations

from rattle.equations.complementarity import FORWARD, OFF, STICK, B, F, friction_of
from rattle.equations.motion import OK
from rattle.equations.unilateral import LOCKED, contact_rows, lasting_side, shift, solve_contacts, solve_modes
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.solvers.nonsmooth.contact_projection import (
    at_rest,
    closed_contacts,
    motion_without,
    project_on_contacts,
)
from rattle.solvers.nonsmooth.impact_path import as_full_matrix
from rattle.solvers.nonsmooth.impacts import count_impulses, gather_touching
from rattle.solvers.nonsmooth.rubbing_impacts import forget_rubbing

ABOUT = 1e-6  # gap of a contact that is about to close, as a share of its size; rate of a clutch [rad/s]
NEARLY = 1e-3  # share by which T may exceed mu N if the lock is about to occur


@compiled
def passes_jams(m, n):
    """True if contact n passes jams (`jam = "impact"`)."""
    return m.values[m.contact[n, at.NORMAL_P] + at.JAM] > 0.0


@native("i", "h", "i")
def touches(m, n):
    """True if the set-valued contact n is closed, or about to."""
    contact, kinematics = m.contact, m.contact_kinematics
    near = kinematics[n, at.GAP] < ABOUT * m.lever[n, at.GAP_SIZE]
    if contact[n, at.LEVEL] == 1:  # a clutch has no gap, and may be overrun
        near = near and kinematics[n, at.DGAP] < ABOUT
    return contact[n, at.IMPACT] == 1 and (m.mode[n] != OFF or near)


@native("f", "h", "f")
def lock_share(m, t):
    """Smallest (G_nn +- mu G_nt) / G_nn of the contacts that slide in the present state: one locks if it is <= 0.

    G and b of the closed contacts remain in the workspace.
    """
    y, mode, active, delassus = m.state, m.mode, m.active, m.delassus
    project_on_contacts(m, t, y, -1)
    motion_without(m, t, y)
    count = closed_contacts(m, closed_contacts(m, 0, 0), 1)
    contact_rows(m, count)
    as_full_matrix(m, count)
    lasting_side(m, count)
    share = 1.0
    for k in range(count):
        n, r = active[k], 2 * k
        if mode[n] != STICK and friction_of(m, n) > 0.0 and delassus[r, r] > 0.0:
            sense = 1.0 if mode[n] == FORWARD else -1.0
            share = min(share, 1.0 + sense * friction_of(m, n) * delassus[r, r + 1] / delassus[r, r])
    return share


@compiled
def holds(m, count):
    """True if normal impulses press and tangential ones stay within the friction limit, or nearly so."""
    side, active, pressed = m.side, m.active, False
    for k in range(count):
        pressed = pressed or side[F, 2 * k] > 0.0
        limit = friction_of(m, active[k]) * side[F, 2 * k] * (1.0 + NEARLY)
        if side[F, 2 * k] < 0.0 or abs(side[F, 2 * k + 1]) > limit:
            return False
    return pressed


@compiled
def ends_slip(m, count):
    """True if a contact that slides, and may pass jams, sticks after the present impulses.

    Closed contacts always have another solution, with no or almost no impulse: it passes no jam.
    """
    kinematics, candidate, active, memory = m.contact_kinematics, m.candidate, m.active, m.contact_memory
    for k in range(count):
        n = active[k]
        slides = not at_rest(m, 2 * k + 1, n, kinematics[n, at.SLIP], memory[n, at.ROUNDING])
        if slides and candidate[k] == STICK and passes_jams(m, n):
            return True
    return False


@compiled
def solve_jam(m, count, whole):
    """Solve for impulses after which contacts that pass jams stick; whole: 1 with all modes, 0 with these only."""
    kinematics, side = m.contact_kinematics, m.side
    for k in range(count):
        n = m.active[k]
        side[B, 2 * k], side[B, 2 * k + 1], m.slide[k] = kinematics[n, at.DGAP], -kinematics[n, at.SLIP], 0
        m.candidate[k] = STICK if passes_jams(m, n) and friction_of(m, n) > 0.0 else m.mode[n]
    if whole == 1:
        return solve_contacts(m, count) and holds(m, count) and ends_slip(m, count)
    solve_modes(m, count, 0)
    return holds(m, count) and ends_slip(m, count)


@native("i", "h", "f", "i")
def pass_jam(m, t, late):
    """Impact without collision of the closed contacts that may pass a jam; rates jump in the present state.

    late: 1 if the state is that of an event whose new modes were not found.  Returns OK, or LOCKED if sticking at
    once needs more than friction can give: then nothing is changed.
    """
    y, y_new, before, nq = m.state, m.state_new, m.rate_new, m.change.shape[0]
    if late == 1:
        for c in range(y.shape[0]):
            y[c] = y_new[c]
    project_on_contacts(m, t, y, -1)
    motion_without(m, t, y)
    count = gather_touching(m, -1)
    contact_rows(m, count)
    if not (solve_jam(m, count, 1) or solve_jam(m, count, 0)):
        return LOCKED
    v = y[nq : 2 * nq]
    for c in range(nq):
        before[c] = v[c]
    shift(m, count, v, -1.0)
    if m.dry.shape[0] > 0:
        forget_rubbing(m)
    count_impulses(m, t, y, count, before)
    return OK
