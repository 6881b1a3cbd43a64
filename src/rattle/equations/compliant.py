"""Compliant contacts at one instant: geometry, normal and friction force, stored and lost power.

force on B  = -N n - T t   at the contact point (t = n turned by 90 degrees)
force on A  = +N n + T t
couple on B = -N m, on A = +N m         m of the normal; with n = 0 the gap is an angle and N a moment [N m]
power taken from the motion = N ddelta + T u = (stored: F_static ddelta) + (lost: the remainder)    [W]

The forces of a shut contact that is followed go on beyond its end, mirrored there, if they are 0 at it: a step may
pass the end before it is cut at it, and its dense output is only as good as they are smooth.  No motion has them.

Oil in the clearance acts in parallel, see `rattle.elements.film`: its force at the points of the joint, its moments on
both bodies.  What it loses counts as lost by the mechanism, not by the contact.
"""

from __future__ import annotations

import math

from rattle.equations.worn_contact import add_worn_force
from rattle.jit import layout as at  # fmt: skip
from rattle.jit.choices import select
from rattle.jit.families import call_clearance, call_film, call_friction, call_normal, call_stiffness
from rattle.jit.functions import compiled, native
from rattle.jit.geometry import ends

START_BELOW = 0.01  # share of a segment: a corner that is deeper below it does not touch, the others may by mistake
LEAST_PENETRATION = 1e-15  # [m] from which on that of an impact is looked for, by doubling
FAINT = 1e-30  # normal force [N] at which friction is what does not depend on it


@compiled
def measure(m, n, corner):
    """Geometry of a corner of contact n by its kind."""
    contact = m.contact
    a, b, p = contact[n, at.A_BODY], contact[n, at.B_BODY], contact[n, at.SHAPE_P]
    call_clearance(
        m.clearance_table[contact[n, at.SHAPE]], (m.body, a, b, m.values, p, corner, n, m.contact_kinematics)
    )


@compiled
def locate(m, n):
    """Geometry of contact n; of what bears on one side, where no motion is followed, by its place: below is asleep."""
    by_place = m.lever[n, at.ONE_WAY] > 0.0 and m.contact_memory[n, at.CLOSED] == at.AUTO
    row, corner = m.contact_kinematics[n], m.contact[n, at.CORNER]
    if by_place:
        row[at.PHASE] = at.AWAKE
    measure(m, n, corner)
    if by_place and row[at.ABOVE] < -START_BELOW * m.lever[n, at.GAP_SCALE]:
        row[at.PHASE] = at.ASLEEP
        measure(m, n, corner)


@native("void", "h")
def locate_contacts(m):
    """Geometry of every contact at the state in `body`, into `contact_kinematics` [m, m/s]."""
    for n in range(m.contact.shape[0]):
        locate(m, n)


@native("void", "h")
def locate_near(m):
    """The same, but contacts of a surface that are all open and apart get a bound for their gaps instead."""
    kinematics, n = m.contact_kinematics, 0
    while n < m.contact.shape[0]:
        span = m.contact[n, at.SPAN]
        if span > 0 and all_open(m, n, span):
            measure(m, n, -1)
            least = kinematics[n, at.GAP]
            if least > 0.0:
                for k in range(n, n + span):
                    kinematics[k, at.GAP] = least
                n += span
                continue
        locate(m, n)
        n += 1


@compiled
def all_open(m, first, count):
    """True if none of these contacts is closed."""
    for n in range(first, first + count):
        if m.contact_memory[n, at.CLOSED] != at.OPEN:
            return False
    return True


@native("void", "h")
def add_contact_forces(m):
    """Add the forces of all compliant contacts to Q [N, N m]; N, T and rates go to `contact_kinematics`."""
    contact, kinematics, memory = m.contact, m.contact_kinematics, m.contact_memory
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 1:
            if memory[n, at.SLIPS] == 1.0:
                most = m.values[contact[n, at.NORMAL_P] + at.MOST_TORQUE]
                add_contact_force(m.force, kinematics, contact[n, at.A_BODY], contact[n, at.B_BODY], n, most, 0.0)
            continue
        for column in range(at.NORMAL, at.STORE + 1):
            kinematics[n, column] = 0.0
        if contact[n, at.FILM_LAW] >= 0:
            add_film_force(m, n)
        first = contact[n, at.FIRST_STATE]
        for k in range(first, first + contact[n, at.STATES]):
            m.element_rate[k] = 0.0
        if contact[n, at.LEVEL] == 1:
            add_clutch_torque(m, n)
        elif presses(m, n):
            if contact[n, at.WORN] == 1:
                add_worn_contact(m, n)
            else:
                add_force_of_laws(m, n)


@compiled
def presses(m, n):
    """True if contact n exerts a force, or goes on with one beyond its end."""
    contact, closed = m.contact, m.contact_memory[n, at.CLOSED]
    if closed == at.SHUT and (contact[n, at.BY_FORCE] == 1 or contact[n, at.VANISHES] == 1):
        return True
    return (closed == at.SHUT or closed == at.AUTO) and m.contact_kinematics[n, at.GAP] < 0.0


@compiled
def push(m, n, gap, rate):
    """Static force and normal force [N] of contact n at a gap [m] and its rate [m/s]; where it ends they are mirrored.

    Those of one that ends by its force go on as they are, below zero where it would pull.
    """
    contact, values, side = m.contact, m.values, math.copysign(1.0, -gap)
    static = call_stiffness(m.stiffness_table[contact[n, at.STATIC]], (abs(gap), values, contact[n, at.STATIC_P]))
    law, p, speed = m.normal_table[contact[n, at.NORMAL_LAW]], contact[n, at.NORMAL_P], m.contact_memory[n, at.SPEED]
    if contact[n, at.BY_FORCE] == 1:
        return side * static, call_normal(law, (side * static, -gap, -rate, speed, values, p))
    return side * static, side * call_normal(law, (static, abs(gap), -rate, speed, values, p))


@compiled
def rub(m, n, normal):
    """Friction [N] of contact n, whose states move, under a normal force [N]; mirrored where that is below zero."""
    contact, slip, p = m.contact, m.contact_kinematics[n, at.SLIP], m.contact[n, at.FRICTION_P]
    law, first = m.friction_table[contact[n, at.FRICTION]], contact[n, at.FIRST_STATE]
    z, dz = m.element_state[first:], m.element_rate[first:]
    end = call_friction(law, (slip, FAINT, z, m.values, p, dz))
    tangent = call_friction(law, (slip, size_of(normal), z, m.values, p, dz))
    return select(normal < 0.0, 2.0 * end - tangent, tangent)


@compiled
def size_of(normal):
    """Size of a normal force [N]; recordings say that it is positive."""
    return abs(normal)


@compiled
def add_force_of_laws(m, n):
    """Add the force of contact n, which touches, by its laws of stiffness, normal force and friction."""
    contact, kinematics, ddelta = m.contact, m.contact_kinematics, -m.contact_kinematics[n, at.DGAP]
    static, normal = push(m, n, kinematics[n, at.GAP], kinematics[n, at.DGAP])
    if contact[n, at.BY_FORCE] == 1 and m.contact_memory[n, at.CLOSED] == at.AUTO:
        normal = max(0.0, normal)
    tangent = 0.0
    if contact[n, at.FRICTION] >= 0:
        tangent = rub(m, n, normal)
    kinematics[n, at.NORMAL], kinematics[n, at.TANGENT] = normal, tangent
    kinematics[n, at.STORE] = static * ddelta
    kinematics[n, at.LOSS] = (normal - static) * ddelta + tangent * kinematics[n, at.SLIP]
    add_contact_force(m.force, kinematics, contact[n, at.A_BODY], contact[n, at.B_BODY], n, normal, tangent)


@compiled
def add_clutch_torque(m, n):
    """Add the torque k x + c x' [N*m] of a clutch that is engaged, x' = -g' [rad/s]; without stiffness x is no state.

    In statics it is engaged where the driving body gets ahead.
    """
    contact, values, kinematics, memory, force = m.contact, m.values, m.contact_kinematics, m.contact_memory, m.force
    rate = -kinematics[n, at.DGAP]
    shut = memory[n, at.CLOSED] == at.SHUT or (memory[n, at.CLOSED] == at.AUTO and rate > 0.0)
    if not shut:
        return
    p, wound = contact[n, at.NORMAL_P], 0.0
    if contact[n, at.STATES] == 1:
        first = contact[n, at.FIRST_STATE]
        wound = values[p + at.WIND_UP] * m.element_state[first]
        m.element_rate[first] = rate
    oil = values[p + at.OIL] * rate
    kinematics[n, at.NORMAL] = wound + oil
    kinematics[n, at.STORE], kinematics[n, at.LOSS] = wound * rate, oil * rate
    add_contact_force(force, kinematics, contact[n, at.A_BODY], contact[n, at.B_BODY], n, wound + oil, 0.0)


@compiled
def add_film_force(m, n):
    """Add force and moments of the oil film of contact n to both bodies, and what it loses to the losses."""
    contact, kinematics, values, force = m.contact, m.contact_kinematics, m.values, m.force
    a, b = contact[n, at.A_BODY], contact[n, at.B_BODY]
    sax, say, sbx, sby, ex, ey, dex, dey = ends(m.body, a, b, values, contact[n, at.SHAPE_P])
    ta, tb, out = m.turning[a], m.turning[b], m.film_force
    wa, wb = m.body[a, at.W] + ta, m.body[b, at.W] + tb
    arguments = (ex, ey, dex, dey, wa, wb, values, contact[n, at.FILM_P], m.film_coefficients, out)
    call_film(m.film_table[contact[n, at.FILM_LAW]], arguments)
    for k in range(5):
        kinematics[n, at.FILM_X + k] = out[k]
    fx, fy = out[0], out[1]
    force[a, at.X] -= fx
    force[a, at.Y] -= fy
    force[a, at.PHI] += kinematics[n, at.FILM_A] - (sax * fy - say * fx)
    force[b, at.X] += fx
    force[b, at.Y] += fy
    force[b, at.PHI] += kinematics[n, at.FILM_B] + (sbx * fy - sby * fx)
    m.power[at.LOSS_RATE] += kinematics[n, at.FILM_LOSS]
    if ta != 0.0 or tb != 0.0:  # the dry contact rubs by them too, see the clearance `pin`
        p, gap = contact[n, at.SHAPE_P], kinematics[n, at.GAP]
        on_a, size = values[p + at.RADIUS] - 0.5 * gap, values[p + at.CLEARANCE] - gap
        kinematics[n, at.SLIP] += tb * (on_a - size) - ta * on_a


@compiled
def add_worn_contact(m, n):
    """Add the force of contact n, a worn pin in its bush, to both bodies."""
    add_worn_force(m, n)
    kinematics, a, b = m.contact_kinematics, m.contact[n, at.A_BODY], m.contact[n, at.B_BODY]
    add_contact_force(m.force, kinematics, a, b, n, kinematics[n, at.NORMAL], kinematics[n, at.TANGENT])


@compiled
def add_contact_force(force, kinematics, a, b, n, normal, tangent):
    """Add the force (normal, tangent) [N] of contact n, its moment and its couple to both bodies."""
    fx = normal * kinematics[n, at.NX] - tangent * kinematics[n, at.NY]
    fy = normal * kinematics[n, at.NY] + tangent * kinematics[n, at.NX]
    couple = normal * kinematics[n, at.TURN]
    force[a, at.X] += fx
    force[a, at.Y] += fy
    force[a, at.PHI] += kinematics[n, at.PAX] * fy - kinematics[n, at.PAY] * fx + couple
    force[b, at.X] -= fx
    force[b, at.Y] -= fy
    force[b, at.PHI] -= kinematics[n, at.PBX] * fy - kinematics[n, at.PBY] * fx + couple


@compiled
def contact_duration(stiffness, values, p, mass, speed):
    """Rough time [s] that an impact of `mass` [kg] at `speed` [m/s] lasts, from the static force of its contact.

    stiffness: entry of the table of its kernels; p: place of its parameters in `values`.
    """
    delta = LEAST_PENETRATION
    for _ in range(60):
        if call_stiffness(stiffness, (delta, values, p)) * delta > mass * speed * speed:
            break
        delta *= 2.0
    return 3.0 * delta / speed
