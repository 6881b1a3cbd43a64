"""Compliant contacts at one instant: geometry, normal and friction force, and what they store and lose.

force on B  = -N n - T t   at the contact point (t = n turned by 90 degrees)
force on A  = +N n + T t
power taken from the motion = N ddelta + T u = (stored: F_static ddelta) + (lost: the rest)
"""

from __future__ import annotations

from rattle.jit.functions import call_clearance, call_friction, call_normal, call_stiffness, compiled, native
from rattle.jit.layout import (
    A_BODY,
    B_BODY,
    BRISTLE,
    CLOSED,
    CORNER,
    DBRISTLE,
    DGAP,
    FRICTION,
    FRICTION_P,
    GAP,
    IMPACT,
    LOSS,
    NORMAL,
    NORMAL_LAW,
    NORMAL_P,
    NX,
    NY,
    OPEN,
    PAX,
    PAY,
    PBX,
    PBY,
    PHI,
    SHAPE,
    SHAPE_P,
    SLIP,
    SPEED,
    STATIC,
    STATIC_P,
    STORE,
    TANGENT,
    X,
    Y,
)  # fmt: skip
from rattle.jit.workspace import (
    BODY,
    BRISTLE_RATE,
    CLEARANCE_TABLE,
    CONTACT,
    FORCE,
    FRICTION_TABLE,
    GRIP,
    NORMAL_TABLE,
    STIFFNESS_TABLE,
    TOUCH,
    VALUES,
    imat,
    ivec,
    mat,
    vec,
)  # fmt: skip


@native("void", "h")
def touch_all(m):
    """Geometry of every contact at the state in `body`."""
    contact, body, values, touch, table = (
        imat(m, CONTACT),
        mat(m, BODY),
        vec(m, VALUES),
        mat(m, TOUCH),
        ivec(m, CLEARANCE_TABLE),
    )
    for n in range(contact.shape[0]):
        call_clearance(
            table[contact[n, SHAPE]],
            (body, contact[n, A_BODY], contact[n, B_BODY], values, contact[n, SHAPE_P], contact[n, CORNER], n, touch),
        )


@native("void", "h")
def press(m):
    """Forces of all compliant contacts on their bodies, added to Q; N, T and rates go to `touch`."""
    contact, values, touch, grip, force = imat(m, CONTACT), vec(m, VALUES), mat(m, TOUCH), mat(m, GRIP), mat(m, FORCE)
    static_table, normal_table, friction_table = (
        ivec(m, STIFFNESS_TABLE),
        ivec(m, NORMAL_TABLE),
        ivec(m, FRICTION_TABLE),
    )
    rate = vec(m, BRISTLE_RATE)
    for n in range(contact.shape[0]):
        if contact[n, IMPACT] == 1:
            continue
        touch[n, NORMAL], touch[n, TANGENT], touch[n, DBRISTLE], touch[n, LOSS], touch[n, STORE] = (
            0.0,
            0.0,
            0.0,
            0.0,
            0.0,
        )
        delta, ddelta = -touch[n, GAP], -touch[n, DGAP]
        if delta <= 0.0 or grip[n, CLOSED] == OPEN:
            continue
        static = call_stiffness(static_table[contact[n, STATIC]], (delta, values, contact[n, STATIC_P]))
        arguments = (static, delta, ddelta, grip[n, SPEED], values, contact[n, NORMAL_P])
        normal = call_normal(normal_table[contact[n, NORMAL_LAW]], arguments)
        tangent = 0.0
        if contact[n, FRICTION] >= 0:
            arguments_t = (touch[n, SLIP], normal, touch[n, BRISTLE], values, contact[n, FRICTION_P], rate)
            tangent = call_friction(friction_table[contact[n, FRICTION]], arguments_t)
            touch[n, DBRISTLE] = rate[0]
        touch[n, NORMAL], touch[n, TANGENT] = normal, tangent
        touch[n, STORE] = static * ddelta
        touch[n, LOSS] = (normal - static) * ddelta + tangent * touch[n, SLIP]
        push(force, touch, contact[n, A_BODY], contact[n, B_BODY], n, normal, tangent)


@compiled
def push(force, touch, a, b, n, normal, tangent):
    """Add the force (normal, tangent) of contact n to both bodies."""
    fx = normal * touch[n, NX] - tangent * touch[n, NY]
    fy = normal * touch[n, NY] + tangent * touch[n, NX]
    force[a, X] += fx
    force[a, Y] += fy
    force[a, PHI] += touch[n, PAX] * fy - touch[n, PAY] * fx
    force[b, X] -= fx
    force[b, Y] -= fy
    force[b, PHI] -= touch[n, PBX] * fy - touch[n, PBY] * fx
