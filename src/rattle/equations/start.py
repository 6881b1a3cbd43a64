"""The start of a mechanism: compiled parts of the assembly.

`analyses.assembly` calls some of them; `find_start` is all of it, for pages and programs.  What they need beside the
mechanism are the arrays `start_` of workspaces.  They return what became of the start; words are made of it elsewhere.
"""

from __future__ import annotations

import math

from rattle.equations import start_columns as of
from rattle.equations.closure import ITERATIONS, SHUT, close_position, open_by
from rattle.equations.compliant import locate_contacts
from rattle.equations.kept_values import MOVED, NOT_CLOSED, NOT_FINITE, hold_pins, keep_given, keep_given_rates
from rattle.equations.motion import drive, solve_motion
from rattle.equations.start_search import ALONG, arm, copy_numbers, find_closing, least_open
from rattle.jit import layout as at
from rattle.jit.choices import select
from rattle.jit.functions import compiled, native

TOO_FAR, NOT_HELD = range(4, 6)  # what became of positions, besides those of `kept_values`
FAR = 0.1  # rotation of a body that pins pressed on their bushes may cause [rad]
BESIDE = 0.5  # change from a start near by [rad, mechanism sizes] up to which this one is on its branch, as recorded
STEEP = 1e-6  # cosine of a line with an axis, from which on the place on that axis tells how far along the line
NO_FORCE = 1e-12  # of the largest mass: a reaction [N] below it has no direction
CLOSED_NEAR = 1e-3  # of SHUT, to which Newton's method goes beside a start


@native("ii", "h", "f", "v", "v", "f", "m")
def close_near(m, t, q, prescribed, size, scratch):
    """Closed positions beside q (3 nb,), in place, that keep given values (3 nb,) as far as joints allow.

    size: of the mechanism [m]; scratch: (2, 3 nb) or more.  Returns what became of q, and the number of iterations.
    """
    start = scratch[1]
    for k in range(q.shape[0]):
        start[k] = q[k]
    least = SHUT * size
    gap, iterations = close_position(m, t, q, scratch[0], CLOSED_NEAR * least, ITERATIONS)
    if not gap <= least:
        return NOT_CLOSED, iterations
    if keep_given(m, t, q, prescribed, size) == NOT_FINITE:
        return NOT_FINITE, iterations
    for k in range(q.shape[0]):
        off = abs((q[k] - start[k]) / (1.0 if k % 3 == 2 else size))
        if not off <= BESIDE:
            return TOO_FAR, iterations
    return MOVED, iterations


# ---------------------------------------------------------------- rates
@compiled
def enter_given(numbers, prescribed):
    """Given values (3 nb,), nan if not given, into positions or rates."""
    for k in range(numbers.shape[0]):
        if prescribed[k] == prescribed[k]:
            numbers[k] = prescribed[k]


@native("void", "h", "v", "v", "v", "n")
def place_rates(m, q, v, prescribed, ways):
    """Set vx and vy [m/s] in v (3 nb,) from its angular velocities [rad/s], by the joints from the ground outwards.

    q: (3 nb,) closed positions; prescribed: (3 nb,) rates, kept, nan if not given.  Where joints do not determine the
    position of a body its rates stay.
    """
    for n in range(ways.shape[0]):
        if ways[n, of.ISLAND] > 0:
            continue
        body, parent, p = ways[n, of.WAY_BODY], ways[n, of.PARENT], ways[n, of.WAY_P]
        k, first = 3 * body - 3, body == ways[n, of.WAY_B]
        if ways[n, of.FREEDOM] == of.FIXED:
            own_x, own_y = arm(m, q, body, p + 2 if first else p)
            x, y = 0.0, 0.0
            if parent > 0:
                other_x, other_y = arm(m, q, parent, p if first else p + 2)
                x = v[3 * parent - 3] - v[3 * parent - 1] * other_y
                y = v[3 * parent - 2] + v[3 * parent - 1] * other_x
            v[k] = x - (0.0 - v[k + 2] * own_y)
            v[k + 1] = y - (0.0 + v[k + 2] * own_x)
        if prescribed[k] == prescribed[k]:
            v[k] = prescribed[k]
        if prescribed[k + 1] == prescribed[k + 1]:
            v[k + 1] = prescribed[k + 1]


@native("i", "h", "f", "v", "v", "v", "f", "n")
def rates_near(m, t, q, v, prescribed, size, ways):
    """Rates (3 nb,) at closed positions q, in place, from those that joints do not determine; what became of them."""
    enter_given(v, prescribed)
    place_rates(m, q, v, prescribed, ways)
    return keep_given_rates(m, t, q, v, prescribed, size)


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
        size = select(pressed, force, 1.0)
        pins[n, 1] = select(pressed, -x / size, 1.0) * pins[n, 0]
        pins[n, 2] = select(pressed, -y / size, 0.0) * pins[n, 0]


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
def find_start(m, ideal, shut, every, t):
    """Positions and rates of a start into `start_q` and `start_v`; what became of them.

    ideal: the mechanism without play, at its start; shut: with joints closed whose pins are held, every: with all that
    have play closed.  Where `start_form` says that there is none it is m.
    """
    if not drivers_have_values(m, t):
        return NOT_FINITE
    became = find_positions(m, ideal, shut, t)
    if became == NOT_CLOSED and m.start_form[of.SMALL] > 0:
        least_open(m, t, m.start_q)
    if became != MOVED:
        open_by(m, t, m.start_q, m.start_v)
        return became
    put_inside(m, ideal, shut, every, t)
    for k in range(m.start_v.shape[0]):
        m.start_v[k] = ideal.start_v[k] if m.start_form[of.WITHOUT_PLAY] > 0 else 0.0
    return rates_near(m, t, m.start_q, m.start_v, m.start_rates, m.start_size[0], m.start_ways)


@compiled
def drivers_have_values(m, t):
    """Whether all drivers have finite values at t [s]; nothing is searched for otherwise."""
    drive(m, t)
    for n in range(m.jet.shape[0]):
        if not abs(m.values[m.jet[n, at.TARGET]]) < math.inf:
            return False
    return True


@native("i", "h", "h", "h", "f")
def find_positions(m, ideal, shut, t):
    """The positions of `find_start`, with pins at their offsets where these are given, or pressed by reactions."""
    if m.start_form[of.WITHOUT_PLAY] == 0:
        became, _iterations = find_closing(m, t, m.start_q, m.start_q, 0)
        if became == MOVED:
            keep_if_inside(m, t)
        return became
    if m.start_missing.shape[0] > 0:
        press_pins(ideal, t, ideal.start_q, ideal.start_v, m.start_first, m.start_pressed)
    return close_with(m, ideal, shut, t, m.start_form[of.HELD], 0)


@native("void", "h", "h", "h", "h", "f")
def put_inside(m, ideal, shut, every, t):
    """Move pins that are outside their bushes to where the mechanism without play has them, if all are inside then.

    Given values are too rough for the play.  Massless links stand in other directions than the reactions have.
    """
    form, q, before = m.start_form, m.start_q, m.start_v
    if form[of.WITHOUT_PLAY] == 0 or form[of.PINS] == 0 or outside(m, t) < 0:
        return
    copy_numbers(q, before)
    for turn in range(4 if m.start_missing.shape[0] > 0 else 1):
        again = turn > 0 or form[of.EVERY] == 0
        if again and close_with(m, ideal, shut, t, 1, turn) == MOVED and outside(m, t) < 0:
            return
        if form[of.EVERY] > 0 and close_with(m, ideal, every, t, 1, turn) == MOVED and outside(m, t) < 0:
            return
    copy_numbers(before, q)


@compiled
def close_with(m, ideal, shut, t, holds, turn):
    """Close the mechanism beside the one without play; what became of it.

    holds: 1 or more to hold the pins of the joints that are closed in shut; turn: quarters of a turn by which pins that
    reactions press are aside.
    """
    q, form, missing = m.start_q, m.start_form, m.start_missing.shape[0] > 0
    turn_pins(m, 0.5 * math.pi * turn)
    held = False
    if holds > 0:
        became = hold_offsets(m, ideal, shut, t)
        held = became == MOVED
        if not held:
            if form[of.LINKS] == 0:
                return became
            missing = False  # pins placed by reactions that are not unique may not fit
    if not held:
        became, _iterations = find_closing(m, t, q, ideal.start_q, 1)
        if became != MOVED:
            return became
    if missing and form[of.SMALL] > 0:
        keep_places(m, t)
    elif form[of.OFFSETS] == 0:
        keep_if_inside(m, t)
    return MOVED


@compiled
def turn_pins(m, angle):
    """Enter the offsets of pins that reactions press, turned by an angle [rad]."""
    c, s, pressed = math.cos(angle), math.sin(angle), m.start_pressed
    for n in range(m.start_missing.shape[0]):
        pin, joint = m.start_missing[n, of.PIN], m.start_missing[n, of.PIN_JOINT]
        x, y = pressed[n, 1], pressed[n, 2]
        if angle != 0.0:
            x, y = c * x - s * y, s * x + c * y
        m.start_held[pin, 2] = x
        m.start_held[pin, 3] = y
        m.start_offsets[joint, 0] = x
        m.start_offsets[joint, 1] = y


@compiled
def hold_offsets(m, ideal, shut, t):
    """Close the mechanism with pins at their offsets, in `start_q`; what became of it.

    shut: with the joints of these pins closed.
    """
    q, size, scratch, missing = m.start_q, m.start_size[0], m.start_scratch, m.start_missing.shape[0] > 0
    copy_numbers(ideal.start_q, q)
    became, iterations = hold_pins(
        shut, t, q, m.start_given, size, shut.start_pins, m.start_held, m.start_form[of.SMALL], scratch
    )
    m.start_search[of.ITERATIONS] = iterations
    if became == NOT_CLOSED:
        return NOT_HELD
    if became != MOVED:
        return became
    gap, _iterations = close_position(m, t, q, scratch[0], ALONG * size, ITERATIONS)
    if not gap <= SHUT * size:
        return NOT_CLOSED
    for k in range(2, q.shape[0], 3):
        if missing and abs(q[k] - ideal.start_q[k]) > FAR:
            return NOT_CLOSED
    return MOVED


@compiled
def keep_if_inside(m, t):
    """Go on to given values as far as joints allow, unless a pin would then be outside its bush."""
    q, before = m.start_q, m.start_scratch[2]
    if m.start_form[of.SMALL] > 0:
        copy_numbers(q, before)
        if keep_given(m, t, q, m.start_given, m.start_size[0]) != MOVED or outside(m, t) >= 0:
            copy_numbers(before, q)


@compiled
def keep_places(m, t):
    """Go on to all given values, if the start misses a given x or y and no pin is then outside its bush.

    A massless link may stand on either side of its bush: the side on which the user placed the body is preferred to the
    one to which its force presses it.  Angles alone do not decide: usually they are those of the ideal mechanism.
    """
    q, before, size = m.start_q, m.start_scratch[2], m.start_size[0]
    if off_given(m, 2):
        copy_numbers(q, before)
        enter_given(q, m.start_given)
        gap, _iterations = close_position(m, t, q, m.start_scratch[0], ALONG * size, ITERATIONS)
        if not gap <= SHUT * size:
            copy_numbers(before, q)
            return
        keep_given(m, t, q, m.start_given, size)
        if off_given(m, 3) or outside(m, t) >= 0:
            copy_numbers(before, q)


@compiled
def off_given(m, coordinates):
    """Whether `start_q` is off given values; of every body the first coordinates count."""
    q, prescribed = m.start_q, m.start_given
    for k in range(q.shape[0]):
        if k % 3 < coordinates and abs(q[k] - prescribed[k]) > SHUT * m.start_size[0]:
            return True
    return False


@native("void", "h", "h", "f")
def count_constants(m, loose, t):
    """Constants [m or rad] with which rows that count from the start vanish there, into `start_constants`.

    m: with constants 0; loose: without these rows, at its start.
    """
    constants, n = m.start_constants, 0
    open_by(m, t, loose.start_q, loose.start_v)
    for number in range(m.start_counting.shape[0]):
        joint = m.start_counting[number]
        rows, p = 1 if joint[of.POLAR] > 0 else joint[of.COUNT_ROWS], joint[of.COUNT_P]
        for k in range(rows):
            constants[n + k] = m.rows[joint[of.COUNT_ROW] + k, at.RES]
        n += rows
        if joint[of.POLAR] > 0:
            ax, ay = point_of(m, joint[of.COUNT_A], p)
            bx, by = point_of(m, joint[of.COUNT_B], p + 2)
            constants[n] = math.hypot(bx - ax, by - ay)
            constants[n + 1] = math.atan2(by - ay, bx - ax)
            constants[n + 2] = 0.0
            n += 3


@compiled
def point_of(m, body, p):
    """A point of a body, which stands in `values` at p [m]."""
    c, s, x, y = m.body[body, at.COS], m.body[body, at.SIN], m.values[p], m.values[p + 1]
    return m.body[body, at.X] + c * x - s * y, m.body[body, at.Y] + s * x + c * y
