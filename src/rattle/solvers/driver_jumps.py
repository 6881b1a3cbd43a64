"""Where drivers jump: the instants of the timetable at which their functions, or the speeds, have two values.

`driver_leap` tells of jumps in position, which no body can follow; `driver_jump` lists those in speed.
"""

from __future__ import annotations

import math

from rattle.equations.motion import drive
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.language.bytecode import SIDE
from rattle.language.instants import SAME, find_instants, merge, row_at, take_sides_of
from rattle.language.span import most

BEYOND = 1e-6  # share of a run by which the search extends beyond its end, so that a switch at the very end counts
LEAP = 1e-9  # change of a driver's function that counts as a jump, as a share of 1 rad or of the mechanism's size
KICK = 1e-9  # change of its speed that counts as a jump, as a share of its largest speed


@native("i", "h", "f", "f")
def find_timetable(m, start, end):
    """Instants, sides and jumps of drivers of a run between two times [s], start before end.

    Returns 0, or how many rows of `switchings` are needed.  Room for jumps: as many rows for every driver.
    """
    if m.timed.shape[0] == 0:
        return 0
    beyond = end + BEYOND * (end - start)
    needed = find_instants(m, start, beyond)
    if needed == 0:
        count = merge(m, start, end, beyond)
        if m.driver_leap.shape[0] > 0:
            keep_jumps(m, note_jumps(m, count, 2.0 * SAME * (end - start)))
    return needed


@compiled
def note_jumps(m, count, near):
    """Look at every driver beside its instants, and at the start; how many rows of `driver_jump` are filled.

    near: within it [s] an instant is that of a switch.
    """
    timed, leap, values, filled = m.timed, m.driver_leap, m.values, 0
    for d in range(leap.shape[0]):
        leap[d, at.FASTEST], leap[d, at.LEAP_COUNT] = 0.0, 0.0
    for n in range(timed.shape[0]):  # before the start there is no piece: values of the definition are used
        m.code[timed[n, at.OWN_CODE], SIDE] = 0
    for piece in range(count + 1):
        t = m.edges[piece]
        if piece > 0 and not drives_at(m, t, near):
            continue
        if piece > 0:
            take_sides_of(m, piece - 1)
        drive(m, t)
        for d in range(leap.shape[0]):
            slot = int(leap[d, at.LEAP_SLOT])
            leap[d, at.VALUE_BEFORE], leap[d, at.SPEED_BEFORE] = values[slot], values[slot + 1]
        take_sides_of(m, piece)
        drive(m, t)
        for d in range(leap.shape[0]):
            kick = compare(m, d, t)
            if piece > 0:  # the rates at the start are given by the start values
                note_jump(m, filled, d, t, kick)
                filled += 1
    return filled


@compiled
def drives_at(m, t, near):
    """True if a switch on which a driver depends changes its side at t [s], to within `near` [s]."""
    timed = m.timed
    for n in range(timed.shape[0]):
        if timed[n, at.DRIVES] == 1:
            k = row_at(m, n, t + near)
            if k > timed[n, at.FIRST_FOUND] and m.switchings[k, at.SWITCHES_AT] >= t - near:
                return True
    return False


@compiled
def compare(m, d, t):
    """Change of the speed of driver d at the instant t [s]; a leap in position is noted."""
    leap, slot = m.driver_leap, int(m.driver_leap[d, at.LEAP_SLOT])
    before, speed_before = float(leap[d, at.VALUE_BEFORE]), float(leap[d, at.SPEED_BEFORE])
    after, speed = float(m.values[slot]), float(m.values[slot + 1])
    if abs(after - before) > LEAP * (leap[d, at.LEAP_SCALE] + max(abs(before), abs(after))):
        if leap[d, at.LEAP_COUNT] == 0.0:
            leap[d, at.LEAP_AT], leap[d, at.LEAP_SIZE] = t, after - before
        leap[d, at.LEAP_COUNT] += 1.0
    leap[d, at.FASTEST] = most(float(leap[d, at.FASTEST]), most(abs(speed_before), abs(speed)))
    return speed - speed_before


@compiled
def note_jump(m, k, d, t, size):
    """Write a jump of driver d by `size` at t [s] into row k of `driver_jump`."""
    jump = m.driver_jump
    jump[k, at.JUMP_AT], jump[k, at.JUMP_ROW], jump[k, at.JUMP_DRIVER] = t, m.driver_leap[d, at.LEAP_ROW], d
    jump[k, at.JUMP_SIZE], jump[k, at.JUMP_IMPULSE], jump[k, at.JUMP_WORK] = size, 0.0, 0.0


@compiled
def keep_jumps(m, filled):
    """Of the rows of `driver_jump` that are filled, keep those that are no rounding."""
    jump, kept = m.driver_jump, 0
    for k in range(filled):
        d, size = int(jump[k, at.JUMP_DRIVER]), jump[k, at.JUMP_SIZE]
        if abs(size) > KICK * m.driver_leap[d, at.FASTEST]:
            note_jump(m, kept, d, jump[k, at.JUMP_AT], size)
            kept += 1
    for k in range(kept, jump.shape[0]):
        jump[k, at.JUMP_AT] = math.inf
