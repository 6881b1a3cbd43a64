"""Starts and ends of compliant contacts inside a step: noticed, located on the dense output, remembered.

A contact has memory: in contact or not, approach speed v0, bristle state.  It changes only here, at the
located instants, so that each step has one smooth right-hand side.

No contact and no release is missed because it is shorter than a step: see `searching`.
"""

from __future__ import annotations

from rattle.equations.compliant import press, touch_all
from rattle.equations.motion import place, set_bristles
from rattle.jit import layout as at  # fmt: skip
from rattle.jit.functions import call_stiffness, compiled, native
from rattle.solvers.gap_search import NONE, may_reach, search

LATER = 1e-7  # share of a step after which a contact changes that was on the wrong side at its start by rounding


@compiled
def interpolate(m, theta, out):
    """State at the share theta of the step into `out`."""
    y, dense = m.state, m.dense
    rest = 1.0 - theta
    for n in range(out.shape[0]):
        value = (dense[4, n] + (dense[5, n] + dense[6, n] * theta) * rest) * theta
        out[n] = (
            y[n] + (dense[0, n] + (dense[1, n] + (dense[2, n] + (dense[3, n] + value) * rest) * theta) * rest) * theta
        )


@native("void", "h", "f", "v")
def start_contacts(m, t, y):
    """Set the memory of every compliant contact at the start of a run."""
    contact, touch, grip, nq = m.contact, m.touch, m.grip, m.change.shape[0]
    place(m, y[:nq], y[nq : 2 * nq])
    touch_all(m)
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 1:
            continue
        grip[n, at.CLOSED] = at.OPEN
        if touch[n, at.GAP] < 0.0:
            shut(m, n, t, y)


@compiled
def shut(m, n, t, y):
    """Contact n starts at (t, y); its geometry is in `touch`."""
    touch, grip = m.touch, m.grip
    k = y.shape[0] - 4 * touch.shape[0] + 4 * n
    grip[n, at.CLOSED] = at.SHUT
    grip[n, at.SPEED] = max(-touch[n, at.DGAP], 0.0)
    grip[n, at.SINCE] = t
    grip[n, at.PEAK] = 0.0
    grip[n, at.N_0] = 0.0
    grip[n, at.STEPS_IN] = 0.0
    y[k] = 0.0
    grip[n, at.IMPULSE_0] = y[k + 1]
    grip[n, at.LOSS_0] = y[k + 2]


@compiled
def note(m, found, kind, n, t, y, speed):
    """Write event number `found`: contact n, over at (t, y) or still going on."""
    touch, grip, event = m.touch, m.grip, m.events[found]
    k = y.shape[0] - 4 * touch.shape[0] + 4 * n
    event[0], event[1], event[2] = grip[n, at.SINCE] if kind == at.CONTACT_EVENT else t, n, kind
    event[3] = speed
    event[4], event[5] = t - grip[n, at.SINCE], grip[n, at.PEAK]
    event[6], event[7] = y[k + 1] - grip[n, at.IMPULSE_0], y[k + 2] + y[k + 3] - grip[n, at.LOSS_0]


@compiled
def contact_time(m, n):
    """An estimate of how long contact n will last, from its static force and approach speed [s]; 0 if unknown."""
    contact, mass, speed = m.contact, m.mass, m.grip[n, at.SPEED]
    a, b = contact[n, at.A_BODY], contact[n, at.B_BODY]
    light = mass[b, 0] if a == 0 else (mass[a, 0] if b == 0 else min(mass[a, 0], mass[b, 0]))
    if speed <= 0.0:
        return 0.0
    delta = 1e-15
    for _ in range(60):
        force = call_stiffness(m.stiffness_table[contact[n, at.STATIC]], (delta, m.values, contact[n, at.STATIC_P]))
        if force * delta > light * speed * speed:
            break
        delta *= 2.0
    return 3.0 * delta / speed


@compiled
def remember_end(m):
    """Keep gaps, rates and forces at the end of the step just computed."""
    touch, grip = m.touch, m.grip
    for n in range(touch.shape[0]):
        grip[n, at.GAP_1], grip[n, at.DGAP_1], grip[n, at.N_1] = (
            touch[n, at.GAP],
            touch[n, at.DGAP],
            touch[n, at.NORMAL],
        )


@compiled
def pass_on(m):
    """The end of this step is the start of the next."""
    grip = m.grip
    for n in range(grip.shape[0]):
        grip[n, at.GAP_0], grip[n, at.DGAP_0], grip[n, at.N_0] = grip[n, at.GAP_1], grip[n, at.DGAP_1], grip[n, at.N_1]


@compiled
def may_any_change(m, h):
    """True when any contact may start or end in the step."""
    contact, grip = m.contact, m.grip
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 0 and may_reach(m, h, n, -1.0 if grip[n, at.CLOSED] == at.SHUT else 1.0):
            return True
    return False


@native("fi", "h", "f")
def first_change(m, h):
    """Share of the step at which the first contact starts or ends (NONE if none does), and which."""
    contact, grip, best, who = m.contact, m.grip, NONE, -1
    for n in range(contact.shape[0]):
        side = -1.0 if grip[n, at.CLOSED] == at.SHUT else 1.0
        if contact[n, at.IMPACT] == 0 and may_reach(m, h, n, side):
            share = search(m, h, n, side, min(best, 1.0))
            if share < best:
                best, who = max(share, LATER), n
    return best, who


@compiled
def near_peak(m):
    """True when the force of a contact may have its maximum inside the step."""
    grip = m.grip
    for n in range(grip.shape[0]):
        if grip[n, at.CLOSED] == at.SHUT and max(grip[n, at.N_0], grip[n, at.N_1]) > 0.7 * grip[n, at.PEAK]:
            return True
    return False


@compiled
def normal_at(m, theta, n):
    """Normal force of contact n at the share theta of the step."""
    touch, stage, nq = m.touch, m.stage, m.change.shape[0]
    interpolate(m, theta, stage)
    set_bristles(m, stage)
    place(m, stage[:nq], stage[nq : 2 * nq])
    touch_all(m)
    press(m)
    return touch[n, at.NORMAL]


@native("void", "h", "f", "i")
def find_peaks(m, until, sampled):
    """Largest force of every contact up to the share `until` of the step; with `sampled` from the dense output too."""
    grip = m.grip
    for n in range(grip.shape[0]):
        if grip[n, at.CLOSED] != at.SHUT:
            continue
        grip[n, at.STEPS_IN] += 1.0
        high = max(grip[n, at.N_0], grip[n, at.N_1] if until >= 1.0 else 0.0)
        if sampled and max(grip[n, at.N_0], grip[n, at.N_1]) > 0.7 * grip[n, at.PEAK]:
            best = 0
            for part in range(1, 8):
                force = normal_at(m, until * part / 8.0, n)
                if force > high:
                    high, best = force, part
            if best > 0 and high > grip[n, at.PEAK]:
                low, top = until * (best - 1) / 8.0, until * (best + 1) / 8.0
                for _ in range(14):
                    one, two = low + 0.382 * (top - low), low + 0.618 * (top - low)
                    first, second = normal_at(m, one, n), normal_at(m, two, n)
                    high = max(high, first, second)
                    if first > second:
                        top = two
                    else:
                        low = one
        grip[n, at.PEAK] = max(grip[n, at.PEAK], high)


@compiled
def change_contacts(m, who, t, y, found):
    """Contact `who` starts or ends at (t, y), others with it; returns the number of events."""
    contact, touch, grip, nq = m.contact, m.touch, m.grip, m.change.shape[0]
    place(m, y[:nq], y[nq : 2 * nq])
    touch_all(m)
    was_shut = grip[who, at.CLOSED] == at.SHUT
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 1:
            continue
        if grip[n, at.CLOSED] == at.OPEN:
            if (n == who and not was_shut) or (touch[n, at.GAP] <= 0.0 and touch[n, at.DGAP] < 0.0):
                shut(m, n, t, y)
        elif n == who and was_shut:
            k = y.shape[0] - 4 * touch.shape[0] + 4 * n
            note(m, found, at.CONTACT_EVENT, n, t, y, grip[n, at.SPEED])
            note(m, found + 1, at.RELEASE_EVENT, n, t, y, max(touch[n, at.DGAP], 0.0))
            found += 2
            y[k + 2] += y[k + 3]  # what rounding left stored is lost
            y[k + 3] = 0.0
            y[k] = 0.0
            grip[n, at.CLOSED] = at.OPEN
    return found
