"""Starts and ends of compliant contacts inside a step: noticed, located on the dense output, remembered.

A contact has memory: in contact or not, approach speed v0, bristle state.  It changes only here, at the
located instants, so that each step has one smooth right-hand side.

No contact and no release is missed because it is shorter than a step: see `searching`.
"""

from __future__ import annotations

from rattle.equations.compliant import press, touch_all
from rattle.equations.motion import place, set_bristles
from rattle.jit.functions import call_stiffness, compiled, native
from rattle.jit.layout import (
    A_BODY,
    B_BODY,
    CLOSED,
    CONTACT_EVENT,
    DGAP,
    DGAP_0,
    DGAP_1,
    GAP,
    GAP_0,
    GAP_1,
    IMPACT,
    IMPULSE_0,
    LOSS_0,
    N_0,
    N_1,
    NORMAL,
    OPEN,
    PEAK,
    RELEASE_EVENT,
    SHUT,
    SINCE,
    SPEED,
    STATIC,
    STATIC_P,
    STEPS_IN,
)  # fmt: skip
from rattle.jit.workspace import (
    CHANGE,
    CONTACT,
    DENSE,
    EVENTS,
    GRIP,
    MASS,
    STAGE,
    STATE,
    STIFFNESS_TABLE,
    TOUCH,
    VALUES,
    imat,
    ivec,
    mat,
    vec,
)  # fmt: skip
from rattle.solvers.gap_search import NONE, may_reach, search

LATER = 1e-7  # share of a step after which a contact changes that was on the wrong side at its start by rounding


@compiled
def interpolate(m, theta, out):
    """State at the share theta of the step into `out`."""
    y, dense = vec(m, STATE), mat(m, DENSE)
    rest = 1.0 - theta
    for n in range(out.shape[0]):
        value = (dense[4, n] + (dense[5, n] + dense[6, n] * theta) * rest) * theta
        out[n] = (
            y[n] + (dense[0, n] + (dense[1, n] + (dense[2, n] + (dense[3, n] + value) * rest) * theta) * rest) * theta
        )


@native("void", "h", "f", "v")
def start_contacts(m, t, y):
    """Set the memory of every compliant contact at the start of a run."""
    contact, touch, grip, nq = imat(m, CONTACT), mat(m, TOUCH), mat(m, GRIP), vec(m, CHANGE).shape[0]
    place(m, y[:nq], y[nq : 2 * nq])
    touch_all(m)
    for n in range(contact.shape[0]):
        if contact[n, IMPACT] == 1:
            continue
        grip[n, CLOSED] = OPEN
        if touch[n, GAP] < 0.0:
            shut(m, n, t, y)


@compiled
def shut(m, n, t, y):
    """Contact n starts at (t, y); its geometry is in `touch`."""
    touch, grip = mat(m, TOUCH), mat(m, GRIP)
    k = y.shape[0] - 4 * touch.shape[0] + 4 * n
    grip[n, CLOSED] = SHUT
    grip[n, SPEED] = max(-touch[n, DGAP], 0.0)
    grip[n, SINCE] = t
    grip[n, PEAK] = 0.0
    grip[n, N_0] = 0.0
    grip[n, STEPS_IN] = 0.0
    y[k] = 0.0
    grip[n, IMPULSE_0] = y[k + 1]
    grip[n, LOSS_0] = y[k + 2]


@compiled
def note(m, found, kind, n, t, y, speed):
    """Write event number `found`: contact n, over at (t, y) or still going on."""
    touch, grip, event = mat(m, TOUCH), mat(m, GRIP), mat(m, EVENTS)[found]
    k = y.shape[0] - 4 * touch.shape[0] + 4 * n
    event[0], event[1], event[2] = grip[n, SINCE] if kind == CONTACT_EVENT else t, n, kind
    event[3] = speed
    event[4], event[5] = t - grip[n, SINCE], grip[n, PEAK]
    event[6], event[7] = y[k + 1] - grip[n, IMPULSE_0], y[k + 2] + y[k + 3] - grip[n, LOSS_0]


@compiled
def contact_time(m, n):
    """An estimate of how long contact n will last, from its static force and approach speed [s]; 0 if unknown."""
    contact, mass, speed = imat(m, CONTACT), mat(m, MASS), mat(m, GRIP)[n, SPEED]
    a, b = contact[n, A_BODY], contact[n, B_BODY]
    light = mass[b, 0] if a == 0 else (mass[a, 0] if b == 0 else min(mass[a, 0], mass[b, 0]))
    if speed <= 0.0:
        return 0.0
    delta = 1e-15
    for _ in range(60):
        force = call_stiffness(
            ivec(m, STIFFNESS_TABLE)[contact[n, STATIC]], (delta, vec(m, VALUES), contact[n, STATIC_P])
        )
        if force * delta > light * speed * speed:
            break
        delta *= 2.0
    return 3.0 * delta / speed


@compiled
def remember_end(m):
    """Keep gaps, rates and forces at the end of the step just computed."""
    touch, grip = mat(m, TOUCH), mat(m, GRIP)
    for n in range(touch.shape[0]):
        grip[n, GAP_1], grip[n, DGAP_1], grip[n, N_1] = touch[n, GAP], touch[n, DGAP], touch[n, NORMAL]


@compiled
def pass_on(m):
    """The end of this step is the start of the next."""
    grip = mat(m, GRIP)
    for n in range(grip.shape[0]):
        grip[n, GAP_0], grip[n, DGAP_0], grip[n, N_0] = grip[n, GAP_1], grip[n, DGAP_1], grip[n, N_1]


@compiled
def may_any_change(m, h):
    """True when any contact may start or end in the step."""
    contact, grip = imat(m, CONTACT), mat(m, GRIP)
    for n in range(contact.shape[0]):
        if contact[n, IMPACT] == 0 and may_reach(m, h, n, -1.0 if grip[n, CLOSED] == SHUT else 1.0):
            return True
    return False


@native("fi", "h", "f")
def first_change(m, h):
    """Share of the step at which the first contact starts or ends (NONE if none does), and which."""
    contact, grip, best, who = imat(m, CONTACT), mat(m, GRIP), NONE, -1
    for n in range(contact.shape[0]):
        side = -1.0 if grip[n, CLOSED] == SHUT else 1.0
        if contact[n, IMPACT] == 0 and may_reach(m, h, n, side):
            share = search(m, h, n, side, min(best, 1.0))
            if share < best:
                best, who = max(share, LATER), n
    return best, who


@compiled
def near_peak(m):
    """True when the force of a contact may have its maximum inside the step."""
    grip = mat(m, GRIP)
    for n in range(grip.shape[0]):
        if grip[n, CLOSED] == SHUT and max(grip[n, N_0], grip[n, N_1]) > 0.7 * grip[n, PEAK]:
            return True
    return False


@compiled
def normal_at(m, theta, n):
    """Normal force of contact n at the share theta of the step."""
    touch, stage, nq = mat(m, TOUCH), vec(m, STAGE), vec(m, CHANGE).shape[0]
    interpolate(m, theta, stage)
    set_bristles(m, stage)
    place(m, stage[:nq], stage[nq : 2 * nq])
    touch_all(m)
    press(m)
    return touch[n, NORMAL]


@native("void", "h", "f", "i")
def find_peaks(m, until, sampled):
    """Largest force of every contact up to the share `until` of the step; with `sampled` from the dense output too."""
    grip = mat(m, GRIP)
    for n in range(grip.shape[0]):
        if grip[n, CLOSED] != SHUT:
            continue
        grip[n, STEPS_IN] += 1.0
        high = max(grip[n, N_0], grip[n, N_1] if until >= 1.0 else 0.0)
        if sampled and max(grip[n, N_0], grip[n, N_1]) > 0.7 * grip[n, PEAK]:
            best = 0
            for part in range(1, 8):
                force = normal_at(m, until * part / 8.0, n)
                if force > high:
                    high, best = force, part
            if best > 0 and high > grip[n, PEAK]:
                low, top = until * (best - 1) / 8.0, until * (best + 1) / 8.0
                for _ in range(14):
                    one, two = low + 0.382 * (top - low), low + 0.618 * (top - low)
                    first, second = normal_at(m, one, n), normal_at(m, two, n)
                    high = max(high, first, second)
                    if first > second:
                        top = two
                    else:
                        low = one
        grip[n, PEAK] = max(grip[n, PEAK], high)


@compiled
def change_contacts(m, who, t, y, found):
    """Contact `who` starts or ends at (t, y), others with it; returns the number of events."""
    contact, touch, grip, nq = imat(m, CONTACT), mat(m, TOUCH), mat(m, GRIP), vec(m, CHANGE).shape[0]
    place(m, y[:nq], y[nq : 2 * nq])
    touch_all(m)
    was_shut = grip[who, CLOSED] == SHUT
    for n in range(contact.shape[0]):
        if contact[n, IMPACT] == 1:
            continue
        if grip[n, CLOSED] == OPEN:
            if (n == who and not was_shut) or (touch[n, GAP] <= 0.0 and touch[n, DGAP] < 0.0):
                shut(m, n, t, y)
        elif n == who and was_shut:
            k = y.shape[0] - 4 * touch.shape[0] + 4 * n
            note(m, found, CONTACT_EVENT, n, t, y, grip[n, SPEED])
            note(m, found + 1, RELEASE_EVENT, n, t, y, max(touch[n, DGAP], 0.0))
            found += 2
            y[k + 2] += y[k + 3]  # what rounding left stored is lost
            y[k + 3] = 0.0
            y[k] = 0.0
            grip[n, CLOSED] = OPEN
    return found
