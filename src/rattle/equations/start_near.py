"""A start near one that is known: compiled parts of the assembly in which nothing is searched for.

`analyses.assembly` calls some of them; `find_near` is all of it, for pages and programs.  What they need beside the
mechanism are the arrays `start_` of workspaces.  They return what became of the start; words are made of it elsewhere.
"""

from __future__ import annotations

import math

from rattle.equations.closure import close_position, open_by
from rattle.equations.compliant import locate_contacts
from rattle.equations.kept_values import MOVED, NOT_CLOSED, NOT_FINITE, hold_pins, keep_given, keep_given_rates
from rattle.equations.motion import solve_motion
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native

TOO_FAR = 4  # what became of positions, besides those of `kept_values`
ITERATIONS = 60  # of Newton's method
SHUT = 1e-9  # sizes of the mechanism by which joints may stay open, and given places be missed
ALONG = 1e-12  # the same, to which Newton's method goes where pins have offsets
FAR = 0.1  # rotation of a body that pins pressed on their bushes may cause [rad]
BESIDE = 0.5  # change from a start near by [rad, mechanism sizes] up to which this one is on its branch, as recorded
STEEP = 1e-6  # cosine of a line with an axis, from which on the place on that axis tells how far along the line
NO_FORCE = 1e-12  # of the largest mass: a reaction [N] below it has no direction
# columns of the ways outward: a body, its parent, the joint between them
BODY, PARENT, WAY_A, WAY_B, WAY_P, FREEDOM = range(6)
FIXED, ALONG_LINE, ABOUT_POINT = range(3)  # what a joint leaves of the place of B's point on A
LINE, DISTANCE = range(2)  # columns of their numbers: direction in A's frame [rad], distance [m]
# places in `start_form`: 1 if a mechanism without play is put together first; how many pins are held; 1 if more can be;
# 1 if given values are kept, as no offsets are given
WITHOUT_PLAY, HELD, EVERY, KEEPS = range(4)
# columns of `start_counting`: first row and number of rows of a joint, 1 if its constants are a residual, distance and
# direction of its points and 0; its bodies, and where its points stand in `values`
COUNT_ROW, COUNT_ROWS, POLAR, COUNT_A, COUNT_B, COUNT_P = range(6)


@native("ii", "h", "f", "v", "v", "f", "m")
def close_near(m, t, q, given, size, scratch):
    """Closed positions beside q (3 nb,), in place, that keep given values (3 nb,) as far as joints allow.

    size: of the mechanism [m]; scratch: (2, 3 nb) or more.  Returns what became of q, and the number of iterations.
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
@native("void", "h", "f", "v", "v", "w", "m")
def press_pins(m, t, q, v, first, pins):
    """Offsets [m] at which pins press on their bushes in the directions of the reactions without play.

    m: without play, started at (t, q, v); first (k,): the first row of each joint; pins (k, 3): its clearance [m],
    then the offset that is written.
    """
    solve_motion(m, t, q, v)
    most = 0.0
    for i in range(m.mass.shape[0]):
        for k in range(3):
            most = max(most, m.mass[i, k])
    for n in range(first.shape[0]):
        x, y = -m.multiplier[first[n]], -m.multiplier[first[n] + 1]  # on B
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


@native("i", "h", "f")
def outside(m, t):
    """`first_outside` at the start in `start_q` and `start_v`."""
    open_by(m, t, m.start_q, m.start_v)
    return first_outside(m, m.start_least)


# ---------------------------------------------------------------- a whole start
@native("i", "h", "h", "h", "h", "f")
def find_near(m, ideal, shut, every, t):
    """Positions and rates near `start_before` into `start_q` and `start_v`; what became of them.

    ideal: the mechanism without play, at its start; shut: with joints closed whose pins are held, every: with all that
    have play closed.  Where `start_form` says that there is none it is m.
    """
    became = find_places(m, ideal, shut, every, t)
    if became != MOVED:
        return became
    q, v, before = m.start_q, m.start_v, m.start_before
    for k in range(q.shape[0]):
        if not abs(q[k] - before[k]) <= BESIDE * (1.0 if k % 3 == 2 else m.start_size[0]):
            return TOO_FAR
    for k in range(v.shape[0]):
        v[k] = ideal.start_v[k] if m.start_form[WITHOUT_PLAY] > 0 else 0.0
    return rates_near(m, t, q, v, m.start_rates, m.start_size[0], m.start_ways)


@compiled
def find_places(m, ideal, shut, every, t):
    """The positions of `find_near`."""
    if m.start_form[WITHOUT_PLAY] == 0:
        copy_numbers(m.start_before, m.start_q)
        became, _iterations = close_near(m, t, m.start_q, m.start_given, m.start_size[0], m.start_scratch)
        return became
    if not closes_beside(m, ideal, shut, t):
        return NOT_CLOSED
    keep_in_play(m, ideal, every, t)
    return MOVED


@compiled
def closes_beside(m, ideal, shut, t):
    """Whether the mechanism closes beside the one without play: with its pins held, or from the ground outwards."""
    if m.start_form[HELD] > 0:
        if hold_offsets(m, ideal, shut, t):
            return True
        if m.start_missing.shape[0] == 0:
            return False
    copy_numbers(ideal.start_q, m.start_q)
    place_outward(m, m.start_q, m.start_given, m.start_offsets, m.start_lines, m.start_ways)
    return closes(m, t)


@compiled
def keep_in_play(m, ideal, every, t):
    """Go on to given values, each time back to the positions before where a pin is then outside its bush."""
    q, form, before = m.start_q, m.start_form, m.start_scratch[2]
    if m.start_missing.shape[0] > 0 and off_given(m, 2):  # on which side of its bush a pin stands
        copy_numbers(q, before)
        if not at_given(m, t) or outside(m, t) >= 0:
            copy_numbers(before, q)
    if form[KEEPS] > 0:
        copy_numbers(q, before)
        if keep_given(m, t, q, m.start_given, m.start_size[0]) != MOVED or outside(m, t) >= 0:
            copy_numbers(before, q)
    if form[EVERY] > 0 and outside(m, t) >= 0:  # given values are too rough for the play
        copy_numbers(q, before)
        if not hold_offsets(m, ideal, every, t) or outside(m, t) >= 0:
            copy_numbers(before, q)


@compiled
def copy_numbers(numbers, into):
    """Copy a vector into another one."""
    for k in range(into.shape[0]):
        into[k] = numbers[k]


@compiled
def closes(m, t):
    """Whether `start_q` can be closed, in place."""
    size = m.start_size[0]
    gap, _iterations = close_position(m, t, m.start_q, m.start_scratch[0], ALONG * size, ITERATIONS)
    return gap <= SHUT * size


@compiled
def off_given(m, coordinates):
    """Whether `start_q` is off given values; of every body the first coordinates count."""
    q, given = m.start_q, m.start_given
    for k in range(q.shape[0]):
        if k % 3 < coordinates and abs(q[k] - given[k]) > SHUT * m.start_size[0]:
            return True
    return False


@compiled
def at_given(m, t):
    """Whether the mechanism closes at all given values, in `start_q`."""
    enter_given(m.start_q, m.start_given)
    if not closes(m, t):
        return False
    keep_given(m, t, m.start_q, m.start_given, m.start_size[0])
    return not off_given(m, 3)


@compiled
def hold_offsets(m, ideal, shut, t):
    """Whether the mechanism closes with pins at their offsets, given or along the reactions without play; `start_q`.

    shut: with the joints of these pins closed.
    """
    q, held, missing, pressed = m.start_q, m.start_held, m.start_missing, m.start_pressed
    if missing.shape[0] > 0:
        press_pins(ideal, t, ideal.start_q, ideal.start_v, m.start_first, pressed)
        for n in range(missing.shape[0]):
            held[missing[n], 2] = pressed[n, 1]
            held[missing[n], 3] = pressed[n, 2]
    copy_numbers(ideal.start_q, q)
    size, scratch = m.start_size[0], m.start_scratch
    became, _iterations = hold_pins(shut, t, q, m.start_given, size, shut.start_pins, held, 1, scratch)
    if became != MOVED or not closes(m, t):
        return False
    for k in range(2, q.shape[0], 3):
        if missing.shape[0] > 0 and abs(q[k] - ideal.start_q[k]) > FAR:
            return False
    return True


@native("void", "h", "h", "f")
def count_constants(m, loose, t):
    """Constants [m or rad] with which rows that count from the start vanish there, into `start_constants`.

    m: with constants 0; loose: without these rows, at its start.
    """
    constants, n = m.start_constants, 0
    open_by(m, t, loose.start_q, loose.start_v)
    for number in range(m.start_counting.shape[0]):
        joint = m.start_counting[number]
        rows, p = 1 if joint[POLAR] > 0 else joint[COUNT_ROWS], joint[COUNT_P]
        for k in range(rows):
            constants[n + k] = m.rows[joint[COUNT_ROW] + k, at.RES]
        n += rows
        if joint[POLAR] > 0:
            ax, ay = point_of(m, joint[COUNT_A], p)
            bx, by = point_of(m, joint[COUNT_B], p + 2)
            constants[n] = math.hypot(bx - ax, by - ay)
            constants[n + 1] = math.atan2(by - ay, bx - ax)
            constants[n + 2] = 0.0
            n += 3


@compiled
def point_of(m, body, p):
    """A point of a body, which stands in `values` at p [m]."""
    c, s, x, y = m.body[body, at.COS], m.body[body, at.SIN], m.values[p], m.values[p + 1]
    return m.body[body, at.X] + c * x - s * y, m.body[body, at.Y] + s * x + c * y
