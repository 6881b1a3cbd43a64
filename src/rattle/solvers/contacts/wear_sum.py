"""What wears in a run: work of sliding in the bins of bush and pin, and the loads under which they slide.

w_i = int N_i |u_i| dt [J], by the trapezoid rule over accepted steps; the depth lost at bin i is k w_i/(R L d).

Loads are kept as rows (s, s F_x, s F_y, s psi): sliding distance s [m], force F of the pin on the bush in the frame of
the bush [N], angle psi = phi_A - phi_B [rad].  When there is no room, neighbours are put together.
"""

from __future__ import annotations

import numpy as np

from rattle.elements.worn_bins import COUNT
from rattle.equations.compliant import locate_contacts
from rattle.equations.motion import place
from rattle.equations.system import System
from rattle.equations.worn_contact import DAMPED, OF_N, OF_SLIP, OF_X, OF_Y, sum_nodes
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native

LOADS = 2048  # rows for the loads of a contact; means over the blows of a hammering pin wear a narrower arc
SLIDING, FORCE_X, FORCE_Y, TURNED = range(4)
FILLED, STEPS_IN_ROW, STEPS_PER_ROW = range(3)  # of `wear_count`


def wear_arrays(system: System) -> dict[str, np.ndarray]:
    """Workspace arrays of a run in which wear is summed."""
    contact, values = system.arrays["contact"], system.arrays["values"]
    worn = contact[contact[:, at.WORN] == 1, at.SHAPE_P]
    bins = int(values[worn + COUNT].max())
    count = np.zeros((len(contact), 3), np.int64)
    count[:, STEPS_PER_ROW] = 1
    shape = (len(contact), 2 * bins)
    return {
        "wear_rate": np.zeros(shape),
        "wear_last": np.zeros(shape),
        "wear_work": np.zeros(shape),
        "wear_load": np.zeros((len(contact) * LOADS, 4)),
        "wear_load_last": np.zeros((len(contact), 4)),
        "wear_speed": np.zeros(len(contact)),
        "wear_count": count,
    }


@native("void", "h")
def keep_speeds(m):
    """Give contacts that last from before the run the approach speeds that they had."""
    memory, speeds = m.contact_memory, m.wear_speed
    for c in range(speeds.shape[0]):
        if memory[c, at.CLOSED] == at.SHUT:
            memory[c, at.SPEED] = max(memory[c, at.SPEED], speeds[c])


@native("void", "h", "f")
def add_wear(m, dt):
    """Add the wear of a step of length dt [s] that has ended at `state`; dt = 0 begins."""
    y, contact, memory = m.state, m.contact, m.contact_memory
    rate, last, work, nq = m.wear_rate, m.wear_last, m.wear_work, m.change.shape[0]
    place(m, y[:nq], y[nq : 2 * nq])
    locate_contacts(m)
    for c in range(contact.shape[0]):
        if contact[c, at.WORN] != 1:
            continue
        for q in range(rate.shape[1]):
            rate[c, q] = 0.0
        touches = m.contact_kinematics[c, at.GAP] < 0.0 and memory[c, at.CLOSED] != at.OPEN
        damped = 0.0
        if touches:
            sum_nodes(m, c, 1)
            damped = m.bin_sums[DAMPED]
        for q in range(rate.shape[1]):
            value = damped * rate[c, q]
            work[c, q] += 0.5 * dt * (last[c, q] + value)
            last[c, q] = value
        add_load(m, c, dt, damped)


@compiled
def add_load(m, c, dt, damped):
    """Add the load of contact c in a step of length dt [s] to its rows; `bin_sums` are those at its end."""
    loads, last, count, sums, contact = m.wear_load, m.wear_load_last, m.wear_count, m.bin_sums, m.contact
    speed = 0.0
    if damped > 0.0:
        speed = abs(sums[OF_SLIP] / sums[OF_N])
    first, row = c * LOADS, c * LOADS + count[c, FILLED]
    for q in range(4):
        value = 0.0
        if speed > 0.0:
            value = speed
            if q == FORCE_X:
                value = speed * damped * sums[OF_X]
            elif q == FORCE_Y:
                value = speed * damped * sums[OF_Y]
            elif q == TURNED:
                value = speed * (m.body[contact[c, at.A_BODY], at.PHI] - m.body[contact[c, at.B_BODY], at.PHI])
        loads[row, q] += 0.5 * dt * (last[c, q] + value)
        last[c, q] = value
    if dt > 0.0:
        count[c, STEPS_IN_ROW] += 1
    if count[c, STEPS_IN_ROW] == count[c, STEPS_PER_ROW]:
        count[c, STEPS_IN_ROW] = 0
        count[c, FILLED] += 1
        if count[c, FILLED] == LOADS:
            put_together(loads, first)
            count[c, FILLED] = LOADS // 2
            count[c, STEPS_PER_ROW] = 2 * count[c, STEPS_PER_ROW]


@compiled
def put_together(loads, first):
    """Add every second row of a contact to the one before it."""
    for r in range(LOADS // 2):
        for q in range(4):
            loads[first + r, q] = loads[first + 2 * r, q] + loads[first + 2 * r + 1, q]
    for r in range(LOADS // 2, LOADS):
        for q in range(4):
            loads[first + r, q] = 0.0
