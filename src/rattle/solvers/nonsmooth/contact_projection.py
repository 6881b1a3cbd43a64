"""Projection of states with set-valued contacts onto joints and walls; tolerances for contact and for zero slip."""

from __future__ import annotations

from rattle.equations.complementarity import FORWARD, OFF, STICK, B
from rattle.equations.compliant import locate_contacts
from rattle.equations.motion import constraints, free_motion, place
from rattle.equations.state import take_states
from rattle.equations.unilateral import contact_rows, push_all, reach, shift, solve_modes, velocity_scale
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.solvers.contacts.penetration import OF_COORDINATES, OF_SCALE, scale_of
from rattle.solvers.projection import project

NEAR = 100.0  # roundings of a gap within which a contact is at its wall
AT_ONCE = 1e-11  # share of the size of the mechanism within which contacts hit at the same instant, by errors of steps
AT_ONCE_OF_GAP = 1e-6  # the same, as a share of the scale of the gap, where that is less
FAR = 100.0  # how far a contact may move along its wall, in gaps, when it is projected onto the wall
EXACT = 1e-16  # share of the typical size of a gap to which closed ones are brought onto their walls
STILL = 1e-12  # share of its terms below which a contact velocity counts as zero
STILL_OF_GAP = 1e-14  # rate [1/s] that is rounding, by the typical size of a gap


@compiled
def noise(m, n):
    """Penetration of contact n that may be rounding [m or rad]: a wide gap does not make it larger."""
    size = OF_COORDINATES * m.lever[n, at.GAP_SIZE]
    return min(OF_SCALE * scale_of(m, n), size) + size


@compiled
def note_open(m, n, gap):
    """Count the error of a gap [m or rad] of contact n as drift."""
    column = at.OPEN_ANGLE if m.lever[n, at.ANGULAR] > 0.0 else at.OPEN_LENGTH
    m.audit[column] = max(m.audit[column], gap)


@compiled
def at_wall(m, n):
    """True if open contact n is at its wall (its gap must be up to date); near ones that hit are projected there."""
    return m.contact_kinematics[n, at.GAP] <= NEAR * noise(m, n)


@compiled
def nearness(m, n):
    """Gap [m or rad] up to which contact n hits with another one that is at its wall, and is put there too.

    It is a loss of energy that no impact accounts for, so that it does not grow with the clearance.
    """
    return max(NEAR * noise(m, n), min(AT_ONCE * m.lever[n, at.GAP_SIZE], AT_ONCE_OF_GAP * scale_of(m, n)))


@compiled
def closed_contacts(m, count, level):
    """Choose all closed contacts of a level after `count` others, with their modes; returns their number."""
    contact, mode, active, candidate = m.contact, m.mode, m.active, m.candidate
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 1 and mode[n] != OFF and contact[n, at.LEVEL] == level:
            active[count], candidate[count] = n, mode[n]
            count += 1
    return count


@compiled
def add_hitting(m, count, who):
    """Add contact `who` and all open ones equally near after the `count` closed ones; returns their number.

    Where the wall moves by itself, the gap at a located instant is off by the error of its dense output, for all alike.
    """
    contact, mode, kinematics, active = m.contact, m.mode, m.contact_kinematics, m.active
    closed = count
    for n in range(contact.shape[0]):
        if who < 0 or contact[n, at.IMPACT] == 0 or mode[n] != OFF or contact[n, at.LEVEL] == 1:
            continue
        off, apart = abs(kinematics[n, at.GAP]), abs(kinematics[n, at.GAP] - kinematics[who, at.GAP])
        if n == who or min(off, apart) <= nearness(m, n):
            active[closed] = n
            closed += 1
    return closed


@compiled
def goes_far(m, count, gap):
    """True if the present forces, taken as displacements, move contact points by more than FAR times a gap.

    gap: as a share of the typical size of such a gap.
    """
    dv, active = m.velocity_change, m.active
    push_all(m, count)
    for k in range(count):
        far = FAR * gap * m.lever[active[k], at.GAP_SIZE]
        if reach(m, 2 * k, active[k], dv, 0) > far or reach(m, 2 * k + 1, active[k], dv, 0) > far:
            return True
    return False


@native("void", "h", "f", "v", "i")
def project_on_contacts(m, t, y, who):
    """Project y onto the constraints and its closed contacts, positions and rates; rows and factor stay up to date.

    who: a contact that hits now (or -1); it and all that are equally near are put onto their walls too.  Near ones
    that would move the bodies far, such as the other corner of a short tilted block, stay where they are.
    """
    project(m, t, y)
    locate_contacts(m)
    count = closed_contacts(m, 0, 0)
    closed = add_hitting(m, count, who)
    if closed == 0 and closed_contacts(m, 0, 1) == 0:
        return
    active, candidate, side, kinematics = m.active, m.candidate, m.side, m.contact_kinematics
    nq = m.change.shape[0]
    q, v = y[:nq], y[nq : 2 * nq]
    bend = 1.0
    for attempt in range(4):
        worst, left = 0.0, bend  # as shares of the typical sizes of gaps
        bend = 0.0
        for k in range(closed):
            size = m.lever[active[k], at.GAP_SIZE]
            gap = abs(kinematics[active[k], at.GAP])
            worst, bend = max(worst, gap / size), max(bend, gap * gap / (scale_of(m, active[k]) * size))
        if worst < EXACT or left < EXACT or attempt == 3:  # error by curved walls: gap^2 / clearance
            for k in range(closed):
                note_open(m, active[k], abs(kinematics[active[k], at.GAP]))
            break
        contact_rows(m, closed)
        for k in range(closed):
            side[B, 2 * k] = -kinematics[active[k], at.GAP]
            candidate[k] = FORWARD
        solve_modes(m, closed, 0)
        if closed > count + 1 and goes_far(m, closed, worst):
            closed, bend, active[count] = count + 1, 1.0, who
            continue
        shift(m, closed, q, 1.0)
        project(m, t, y)
        locate_contacts(m)
    count = closed_contacts(m, count, 1)
    contact_rows(m, count)
    for k in range(count):
        n = active[k]
        side[B, 2 * k], side[B, 2 * k + 1] = kinematics[n, at.DGAP], -kinematics[n, at.SLIP]
        candidate[k] = STICK if m.mode[n] == STICK else FORWARD
    solve_modes(m, count, 0)
    shift(m, count, v, -1.0)
    place(m, q, v)
    constraints(m)
    locate_contacts(m)


@compiled
def motion_without(m, t, y):
    """The equations of motion at y without the forces of closed contacts."""
    nq = m.change.shape[0]
    take_states(m, y)
    free_motion(m, t, y[:nq], y[nq : 2 * nq])


@compiled
def largest_acceleration(m, n):
    """Largest acceleration of a mass centre along x or y [m/s^2]; for a contact n with angular gap, of an angle."""
    acceleration, angular = m.acceleration, m.lever[n, at.ANGULAR] > 0.0
    total = 0.0
    for i in range(1, acceleration.shape[0]):
        if angular:
            total = max(total, abs(acceleration[i, 2]))
        else:
            total = max(total, abs(acceleration[i, 0]), abs(acceleration[i, 1]))
    return total


@compiled
def at_rest(m, r, n, u, before):
    """True if the velocity u [m/s or rad/s] of row r of contact n is rounding; before: magnitude of its terms before
    an impact, and of those that its impulses add."""
    return abs(u) <= STILL * max(velocity_scale(m, r, n), before) + STILL_OF_GAP * m.lever[n, at.GAP_SIZE]
