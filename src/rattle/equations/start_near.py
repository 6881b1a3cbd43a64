"""A start near one that is known: compiled parts of the assembly in which nothing is searched for.

Python puts them together in `analyses.assembly`, pages in `pages/viewer/core_start.js`.  They return what became of
the start; words are made of it elsewhere.
"""

from __future__ import annotations

import math

from rattle.equations.closure import close_position, open_by
from rattle.equations.compliant import locate_contacts
from rattle.equations.kept_values import MOVED, NOT_CLOSED, NOT_FINITE, keep_given, keep_given_rates
from rattle.equations.motion import solve_motion
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native

TOO_FAR = 4  # what became of positions, besides those of `kept_values`
ITERATIONS = 60  # of Newton's method
SHUT = 1e-9  # sizes of the mechanism by which joints may stay open
BESIDE = 0.5  # change from a start near by [rad, mechanism sizes] up to which this one is on its branch, as recorded
STEEP = 1e-6  # cosine of a line with an axis, from which on the place on that axis tells how far along the line
NO_FORCE = 1e-12  # of the largest mass: a reaction [N] below it has no direction
# columns of the ways outward: a body, its parent, the joint between them
BODY, PARENT, WAY_A, WAY_B, WAY_P, FREEDOM = range(6)
FIXED, ALONG_LINE, ABOUT_POINT = range(3)  # what a joint leaves of the place of B's point on A
LINE, DISTANCE = range(2)  # columns of their numbers: direction in A's frame [rad], distance [m]


@native("ii", "h", "f", "v", "v", "f", "m")
def close_near(m, t, q, given, size, scratch):
    """Closed positions beside q (3 nb,), in place, that keep given values (3 nb,) as far as joints allow.

    size: of the mechanism [m]; scratch: (2, 3 nb).  Returns what became of q, and the number of iterations.
    """
    start = scratch[1]
    for k in range(q.shape[0]):
        start[k] = q[k]
    least = SHUT * size
    gap, iterations = close_position(m, t, q, scratch[0], 1e-3 * least, ITERATIONS)
    if not gap <= least:
        return NOT_CLOSED, iterations
    if keep_given(m, t, q, given, size) == NOT_FINITE:
        return NOT_FINITE, iterations
    for k in range(q.shape[0]):
        off = abs((q[k] - start[k]) / (1.0 if k % 3 == 2 else size))
        if not off <= BESIDE:
            return TOO_FAR, iterations
    return MOVED, iterations


# ---------------------------------------------------------------- from the ground outwards
@compiled
def enter_given(made, given):
    """Given values (3 nb,), nan if not given, into positions or rates."""
    for k in range(made.shape[0]):
        if given[k] == given[k]:
            made[k] = given[k]


@compiled
def arm(m, q, body, p):
    """A point of a body, which stands in `values` at p, from its mass centre in ground axes [m]."""
    angle = q[3 * body - 1] if body > 0 else 0.0
    c, s, x, y = math.cos(angle), math.sin(angle), m.values[p], m.values[p + 1]
    return c * x - s * y, s * x + c * y


@native("void", "h", "v", "v", "m", "m", "n")
def place_outward(m, q, given, offsets, lines, ways):
    """Place bodies by their joints, from the ground outwards, with the angles in q (3 nb,); in place.

    given: (3 nb,), kept, nan if not given; offsets (n, 2): of the joints of the ways [m]; lines (n, 2): see above.
    What a joint leaves free stays as it is in q, unless given values determine it.
    """
    enter_given(q, given)
    for n in range(ways.shape[0]):
        k, sign = 3 * ways[n, BODY] - 3, 1.0 if ways[n, BODY] == ways[n, WAY_B] else -1.0
        x0, y0 = without_gap(m, q, ways, n)
        gap_x, gap_y = offsets[n, 0], offsets[n, 1]  # point of B minus point of A
        if ways[n, FREEDOM] == ALONG_LINE:
            gap_x, gap_y = gap_along(q, given, ways, n, lines[n, LINE], x0, y0)
        elif ways[n, FREEDOM] == ABOUT_POINT:
            gap_x, gap_y = gap_about(q[k] - x0, q[k + 1] - y0, sign, lines[n, DISTANCE])
        if given[k] != given[k]:
            q[k] = x0 + sign * gap_x
        if given[k + 1] != given[k + 1]:
            q[k + 1] = y0 + sign * gap_y


@compiled
def without_gap(m, q, ways, n):
    """Where the body of way n is when the points of its joint coincide [m]."""
    body, parent, p = ways[n, BODY], ways[n, PARENT], ways[n, WAY_P]
    first = body == ways[n, WAY_B]
    own_x, own_y = arm(m, q, body, p + 2 if first else p)
    other_x, other_y = arm(m, q, parent, p if first else p + 2)
    x0 = other_x - own_x + (q[3 * parent - 3] if parent > 0 else 0.0)
    y0 = other_y - own_y + (q[3 * parent - 2] if parent > 0 else 0.0)
    return x0, y0


@compiled
def gap_along(q, given, ways, n, direction, x0, y0):
    """The gap of a joint along a line of A [m]: up to the one given coordinate of its body, or else up to q.

    direction: of the line in A's frame [rad]; x0, y0: of the body without gap [m].
    """
    a, body = ways[n, WAY_A], ways[n, BODY]
    k, sign = 3 * body - 3, 1.0 if body == ways[n, WAY_B] else -1.0
    axis = (q[3 * a - 1] if a > 0 else 0.0) + direction
    c, s = math.cos(axis), math.sin(axis)
    knows_x, knows_y = given[k] == given[k], given[k + 1] == given[k + 1]
    if knows_x and not knows_y and abs(c) > STEEP:
        along = sign * (q[k] - x0) / c
    elif knows_y and not knows_x and abs(s) > STEEP:
        along = sign * (q[k + 1] - y0) / s
    else:
        along = sign * (c * (q[k] - x0) + s * (q[k + 1] - y0))
    return c * along, s * along


@compiled
def gap_about(x, y, sign, distance):
    """The gap of a joint that keeps a distance [m] in the direction (x, y) of its body; sign: 1.0 if that is B."""
    gap_x, gap_y = sign * x, sign * y
    size = math.hypot(gap_x, gap_y)
    if size > 0.0:
        gap_x, gap_y = distance * (gap_x / size), distance * (gap_y / size)
    return gap_x, gap_y


@native("void", "h", "v", "v", "v", "n")
def place_rates(m, q, v, given, ways):
    """Set vx and vy [m/s] in v (3 nb,) from its angular velocities [rad/s], by the joints from the ground outwards.

    q: (3 nb,) closed positions; given: (3 nb,) rates, kept, nan if not given.  Where joints do not determine the
    position of a body its rates stay.
    """
    for n in range(ways.shape[0]):
        body, parent, p = ways[n, BODY], ways[n, PARENT], ways[n, WAY_P]
        k, first = 3 * body - 3, body == ways[n, WAY_B]
        if ways[n, FREEDOM] == FIXED:
            own_x, own_y = arm(m, q, body, p + 2 if first else p)
            x, y = 0.0, 0.0
            if parent > 0:
                other_x, other_y = arm(m, q, parent, p if first else p + 2)
                x = v[3 * parent - 3] - v[3 * parent - 1] * other_y
                y = v[3 * parent - 2] + v[3 * parent - 1] * other_x
            v[k] = x - (0.0 - v[k + 2] * own_y)
            v[k + 1] = y - (0.0 + v[k + 2] * own_x)
        if given[k] == given[k]:
            v[k] = given[k]
        if given[k + 1] == given[k + 1]:
            v[k + 1] = given[k + 1]


@native("i", "h", "f", "v", "v", "v", "f", "n")
def rates_near(m, t, q, v, given, size, ways):
    """Rates (3 nb,) at closed positions q, in place, from those that joints do not determine; what became of them."""
    enter_given(v, given)
    place_rates(m, q, v, given, ways)
    return keep_given_rates(m, t, q, v, given, size)


# ---------------------------------------------------------------- pins
@native("void", "h", "f", "v", "v", "n", "m")
def press_pins(m, t, q, v, first, pins):
    """Offsets [m] at which pins press on their bushes in the directions of the reactions without play.

    m: without play, started at (t, q, v); first (k, 1): the first row of each joint; pins (k, 3): its clearance [m],
    then the offset that is written.
    """
    solve_motion(m, t, q, v)
    most = 0.0
    for i in range(m.mass.shape[0]):
        for k in range(3):
            most = max(most, m.mass[i, k])
    for n in range(first.shape[0]):
        x, y = -m.multiplier[first[n, 0]], -m.multiplier[first[n, 0] + 1]  # on B
        force = math.hypot(x, y)
        pressed = force > NO_FORCE * most
        pins[n, 1] = (-x / force if pressed else 1.0) * pins[n, 0]
        pins[n, 2] = (-y / force if pressed else 0.0) * pins[n, 0]


@native("i", "h", "v")
def first_outside(m, least):
    """The first contact, at the state in `body`, whose gap [m or rad] is below its least (nc,); -1 if none is.

    Gaps are in `contact_kinematics`.
    """
    locate_contacts(m)
    for n in range(least.shape[0]):
        if least[n] > -math.inf and not m.contact_kinematics[n, at.GAP] >= least[n]:
            return n
    return -1


@native("i", "h", "f", "v", "v", "v")
def outside_at(m, t, q, v, least):
    """`first_outside` at a state."""
    open_by(m, t, q, v)
    return first_outside(m, least)
