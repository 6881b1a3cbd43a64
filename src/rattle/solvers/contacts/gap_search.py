"""Zeros of a gap inside a step: a search of the dense output that misses no contact.

A step may be as long as a free flight, with many turns of its bodies in it, so that sampling it at some places
proves nothing.  A proof needs a bound on the second derivative of the gap.  With e the offset of the joint's point
on B from that on A, s_A and s_B the longest lever arms from the mass centres to points that may touch,

    |e''| <= |a_B - a_A| + s_B (w_B^2 + |alpha_B|) + s_A (w_A^2 + |alpha_A|) = E

(walls that turn with A, at most D away from its point, add (w_A^2 + |alpha_A|) D + 2 |w_A| |e'|).  Between two samples,
dt apart, no gap is more than E dt^2 / 8 below the smaller of the two: |e| is convex and the gap of a block is linear
in e.  If this does not decide, three samples and the rates give a cubic, whose error is its deviation from the middle
sample plus a bound for the rotation, (E + (n')^2 |e|) (W dt)^2 dt^2 / 384; if that does not decide either, the
interval is halved.  Contacts out of reach need no sample at all.

Walls that turn with B take its angular velocity instead.  A gap that depends on angles and on the offset in another
way, as of a cam or a tooth, adds SLOPE (|alpha_A| + |alpha_B|) + CURVE (|w_A| + |w_B|)^2 + BOW |e'|^2, where the
constants bound its derivatives (`layout`, lever).  Its normal turns at BOW |e'| too.

A point outside a round of radius c (ROUNDED = 2: the least distance of two points) adds |e'|^2 / c.  Inside of it the
gap bends more, but then the chord of its way passes through the round, and the bound on what is below the samples
holds.

A contact in a round (ROUNDED = 1) that is shut ends where |e| comes below c.  A way through the round, from wall to
wall, bends |e| without bound, so that a chord proves nothing there, nor a cubic where the way is not short beside c;
but |e| is convex in e and so never below the tangents that follow.

Where a contact ends at a point (ONE_WAY) BOW bounds the gap as long as it is more than 1/BOW.  Nearer to that point
there is no such bound, but what is touched is convex: the gap is not less than the distance from the tangent at either
sample, so that it is above both

    g_0 + g_0' t - E t^2 / 2,        g_1 - g_1' (dt - t) - E (dt - t)^2 / 2

A gap that is an angle between two bodies has |g''| <= |alpha_B - alpha_A| = E.

Accelerations are bounded by those of the stages of the step plus their spread.

Source: Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems (1996), on bounds for the time to
collision; the remainders of linear and cubic interpolation.
"""

from __future__ import annotations

import math

from rattle.equations.compliant import measure
from rattle.jit import layout as at  # fmt: skip
from rattle.jit.choices import TINY, assume, select
from rattle.jit.functions import compiled, native
from rattle.solvers.contacts.penetration import OF_COORDINATES, OF_SCALE, scale_of
from rattle.solvers.dense_output import HALVINGS, INSTANT, OF_STEP

INSIDE, OUTSIDE = 1.0, 2.0  # ROUNDED of a contact whose B is inside, or outside, a round
NONE = 2.0  # a share of the step that does not exist
WHOLE_TURN = 0.5  # angle [rad] up to which a cubic is tried
BOW_TURNS = 2.0  # of the normal by BOW |e'|: |e| has a fourth derivative of 3 |e'|^4/|e|^3 where it is least
GAVE_UP = 3.0  # the same, of a search without result: the step is too long for its dense output to be trusted
MOST_LOOKS = 1_000_000
FEW_LOOKS = 20_000  # for contacts whose step may be repeated with a shorter length
STILL_SHARE = 1e-12  # as that of the rows of contacts; test_a_start_in_contact_with_a_speed_of_rounding_is_no_impact
SAME_TIME = 4e-16  # share of the time: an interval of two spacings of numbers is not halved
SAME_SHARE = 1e-12  # share of a step that is not halved either
ASIDE = 1e-3  # share of an interval by which the next place of a search for a zero stays away from its ends


@compiled
def rounding(m, n):
    """Penetration of contact n that may be rounding [m or rad]: coordinates and angles may be large."""
    contact, lever, y = m.contact, m.lever, m.state
    size, angular = 0.0, lever[n, at.ANGULAR] > 0.0
    for end in range(2):
        i = contact[n, at.A_BODY + end]
        size += lever[n, end]
        if i > 0 and angular:
            size += abs(y[3 * i - 1])
        elif i > 0:
            size += abs(y[3 * i - 3]) + abs(y[3 * i - 2]) + lever[n, end] * abs(y[3 * i - 1])
    return OF_SCALE * scale_of(m, n) + OF_COORDINATES * size


@compiled
def rate_rounding(m, n):
    """Speed of contact n that may be rounding [m/s or rad/s]: a share of those of its bodies in `m.body`."""
    contact, lever, body = m.contact, m.lever, m.body
    size, angular = 0.0, lever[n, at.ANGULAR] > 0.0
    for end in range(2):
        i = contact[n, at.A_BODY + end]
        turn = abs(body[i, at.W])
        arm = lever[n, end] + lever[n, at.SLOPE]
        size += turn if angular else abs(body[i, at.VX]) + abs(body[i, at.VY]) + arm * turn
    return STILL_SHARE * size


@compiled
def largest(m, a, b, q):
    """Bound on component q of the acceleration of body b minus that of body a over the step [m/s^2, rad/s^2]."""
    k, nq = m.slopes, m.change.shape[0]
    first, top, spread = 0.0, 0.0, 0.0
    for s in range(m.stepper[at.SLOPES]):
        value = 0.0
        if b > 0:
            value += k[s, nq + 3 * b - 3 + q]
        if a > 0:
            value -= k[s, nq + 3 * a - 3 + q]
        if s == 0:
            first = value
        top, spread = max(top, abs(value)), max(spread, abs(value - first))
    return top + spread


@compiled
def fastest(m, h, i):
    """Bounds on the angular velocity [rad/s] and acceleration [rad/s^2] of body i over the step of length h [s]."""
    if i == 0:
        return 0.0, 0.0
    k, alpha = m.change.shape[0] + 3 * i - 1, largest(m, 0, i, 2)
    return max(abs(m.state[k]), abs(m.state_new[k])) + 0.5 * h * alpha, alpha


@compiled
def apart(m, y, a, b, k):
    """Distance of two mass centres [m] (k = 0), or their relative speed [m/s] (k = 3 nb), in the state y."""
    x = (y[k + 3 * b - 3] if b > 0 else 0.0) - (y[k + 3 * a - 3] if a > 0 else 0.0)
    z = (y[k + 3 * b - 2] if b > 0 else 0.0) - (y[k + 3 * a - 2] if a > 0 else 0.0)
    return math.sqrt(x * x + z * z)


@compiled
def bounds(m, h, n):
    """Of contact n over the step of length h [s]: E with BOW and without it, the largest angular velocity W, and |e'|.

    In m/s^2 or rad/s^2, rad/s, m/s; |e'| is 0 where it is not needed.
    """
    contact, lever, y, y_new = m.contact, m.lever, m.state, m.state_new
    a, b, s_a, s_b = contact[n, at.A_BODY], contact[n, at.B_BODY], lever[n, at.ARM_A], lever[n, at.ARM_B]
    wa, alpha_a = fastest(m, h, a)
    wb, alpha_b = fastest(m, h, b)
    if lever[n, at.ANGULAR] > 0.0:
        alone = largest(m, a, b, 2)
        return alone, alone, max(wa, wb), 0.0
    ax, ay = largest(m, a, b, 0), largest(m, a, b, 1)
    linear = math.sqrt(ax * ax + ay * ay)
    bend = linear + s_b * (wb * wb + alpha_b) + s_a * (wa * wa + alpha_a)
    bow_bend, speed = 0.0, 0.0
    w, alpha = (wb, alpha_b) if lever[n, at.WALLS_TURN] > 1.5 else (wa, alpha_a)
    walls, bow, turning = lever[n, at.WALLS_TURN] > 0.0, lever[n, at.BOW], max(wa, wb)
    if lever[n, at.ROUNDED] == OUTSIDE:
        bow += 1.0 / scale_of(m, n)
    if walls or assume(bow > 0.0):
        nq = m.change.shape[0]
        speed = max(apart(m, y, a, b, nq), apart(m, y_new, a, b, nq)) + 0.5 * h * linear + s_a * wa + s_b * wb
        away = max(apart(m, y, a, b, 0), apart(m, y_new, a, b, 0)) + 0.125 * h * h * linear + s_a + s_b
        if walls:
            bend += (w * w + alpha) * away + 2.0 * w * speed
            speed += w * away
        bow_bend = bow * speed * speed
        turning = max(turning, BOW_TURNS * bow * speed)
    bend += lever[n, at.SLOPE] * (alpha_a + alpha_b) + lever[n, at.CURVE] * (wa + wb) * (wa + wb)
    return bend + bow_bend, bend, turning, speed


@compiled
def near_point(m, n, side, gap, end, speed, dt):
    """True if contact n may come nearer than 1/BOW to the point at which it ends, in an interval of length dt [s]."""
    bow = m.lever[n, at.BOW]
    return m.lever[n, at.ONE_WAY] > 0.0 and side > 0.0 and (0.5 * (gap + end) - 0.5 * speed * dt) * bow < 1.0


@compiled
def least_by_tangents(gap, rate, end, end_rate, dt, bend):
    """Least gap [m] in an interval of length dt [s], by the tangents at its ends: of convex things.

    bend: bound of the acceleration of what it is convex in [m/s^2].
    """
    before, after = gap - end + end_rate * dt + 0.5 * bend * dt * dt, rate - end_rate - bend * dt
    t = min(max(select(after < 0.0, -before / min(after, -TINY), 0.0), 0.0), dt)
    return min(min(gap, end), gap + t * (rate - 0.5 * bend * t))


@compiled
def least_between(m, n, side, gap, rate, end, end_rate, dt, bend):
    """Least value [m or rad] of side * gap of contact n in an interval of length dt [s], by values at its ends.

    bend: bound of its second derivative, of contacts in a round that of e.
    """
    chord = min(gap, end) - 0.125 * bend * dt * dt
    if m.lever[n, at.ROUNDED] != INSIDE:
        return chord
    return select(side < 0.0, least_by_tangents(gap, rate, end, end_rate, dt, bend), chord)


@compiled
def sweep(m, n, bend, dt, gap):
    """Angular velocity of the normal of contact n as the pin moves round its bush [rad/s], and |e| there [m]."""
    c = scale_of(m, n)
    distance = max(0.25 * c, c - gap)
    if m.lever[n, at.ROUNDED] == 0.0:
        return 0.0, distance
    if m.lever[n, at.ROUNDED] == OUTSIDE:
        distance = c
    return (abs(m.contact_kinematics[n, at.ACROSS]) + bend * dt) / distance, distance


@compiled
def across_round(m, n, side, rate, end_rate, dt, bend):
    """Bound on the way of a shut contact in a round through it in an interval of length dt [s], as a share of c."""
    if m.lever[n, at.ROUNDED] != INSIDE:
        return 0.0
    way = (max(abs(rate), abs(end_rate)) + bend * dt) * dt
    return select(side < 0.0, way / scale_of(m, n), 0.0)


@native("i", "h", "f", "i", "f")
def may_reach(m, h, n, side):
    """True unless the ends of the step (length h [s]) prove that side * gap of contact n stays positive in it."""
    memory = m.contact_memory[n]
    gap, rate = side * memory[at.GAP_0], side * memory[at.DGAP_0]
    end, end_rate = side * memory[at.GAP_1], side * memory[at.DGAP_1]
    slight = rounding(m, n)
    least = min(gap, 0.0) - slight
    if end < least:
        return True
    bend, plain, _, speed = bounds(m, h, n)
    if near_point(m, n, side, gap, end, speed, h):
        return least_by_tangents(gap, rate, end, end_rate, h, plain) < least
    if least_between(m, n, side, gap, rate, end, end_rate, h, bend) >= least:
        return False
    round_, distance = sweep(m, n, bend, h, max(abs(gap), abs(end)) if side > 0.0 else 0.0)
    curve = bend + round_ * round_ * distance
    return abs(rate + end_rate) < curve * h


@compiled
def gap_at(m, theta, n):
    """Gap of contact n [m] and its rate [m/s] at the share theta of the step; needs the dense output."""
    contact, kinematics, body, y, dense = m.contact, m.contact_kinematics, m.body, m.state, m.dense
    nq, rest = m.change.shape[0], 1.0 - theta
    for end in range(2):
        i = contact[n, at.A_BODY + end]
        if i == 0:
            continue
        for q in range(6):
            k = 3 * i - 3 + q if q < 3 else nq + 3 * i - 6 + q
            value = 0.0
            for row in range(6, -1, -1):
                value = (value + dense[row, k]) * (theta if row % 2 == 0 else rest)
            body[i, at.X + q] = y[k] + value
        body[i, at.COS], body[i, at.SIN] = math.cos(body[i, at.X + 2]), math.sin(body[i, at.X + 2])
    measure(m, n, contact[n, at.CORNER])
    return kinematics[n, at.GAP], kinematics[n, at.DGAP]


@compiled
def lowest(left, slope_left, right, slope_right):
    """Smallest value on the interval from 0 to 1 of the cubic with these values and slopes at its ends."""
    low = min(left, right)
    c2 = 3.0 * (right - left) - 2.0 * slope_left - slope_right
    c3 = 2.0 * (left - right) + slope_left + slope_right
    inside = c2 * c2 - 3.0 * c3 * slope_left
    if inside >= 0.0:
        root = c2 + math.copysign(math.sqrt(inside), c2)
        for turn in range(2):  # slope_left + 2 c2 x + 3 c3 x^2 = 0
            above, below = (-root, 3.0 * c3) if turn == 0 else (-slope_left, root)
            if below != 0.0:
                x = above / below
                if 0.0 < x < 1.0:
                    low = min(low, left + x * (slope_left + x * (c2 + x * c3)))
    return low


@compiled
def first_below(m, h, n, side, left, gap, rate, right, end):
    """Share between left and right at which side * gap, negative at the right end, becomes negative.

    A gap that is rounding as it starts to grow has no zero there, whatever its sign: it returns after its maximum.
    """
    t = m.clock[0]
    if gap <= rounding(m, n) and rate > 0.0:
        top = right
        for _ in range(HALVINGS):
            middle = 0.5 * (left + top)
            value, slope = gap_at(m, middle, n)
            if side * slope > 0.0:
                left, gap = middle, side * value
            else:
                top = middle
    if gap <= 0.0:
        return left
    for turn in range(100):
        if not (right - left) * h > INSTANT * abs(t) + OF_STEP * h:
            break
        middle = 0.5 * (left + right)
        if turn % 3 < 2:
            middle = left + min(max(gap / (gap - end), ASIDE), 1.0 - ASIDE) * (right - left)
        if middle <= left or middle >= right:
            break
        value = side * gap_at(m, middle, n)[0]
        if value < 0.0:
            right, end = middle, value
            gap *= 0.5 if turn % 3 == 1 else 1.0
        else:
            left, gap = middle, value
            end *= 0.5 if turn % 3 == 1 else 1.0
    return right


@compiled
def signed_gap(m, theta, n, side):
    """`gap_at` times side."""
    gap, rate = gap_at(m, theta, n)
    return side * gap, side * rate


@compiled
def judge(m, n, side, dt, tiny, bend, turning, gap, rate, end, end_rate, least):
    """What the ends of an interval of length dt [s] prove of the gap of contact n, there with these rates.

    True if it becomes less than `least` and falls all the time; True if it does not become less between the ends; a
    bound for its curvature; the angle by which the normal turns.  tiny: the interval is not divided further.
    """
    round_, distance = sweep(m, n, bend, dt, max(gap, end) if side > 0.0 else 0.0)
    curve = bend + round_ * round_ * distance
    falling, rising = rate + end_rate <= -curve * dt, rate + end_rate >= curve * dt
    free = falling or rising or tiny or least_between(m, n, side, gap, rate, end, end_rate, dt, bend) >= least
    wide = max(max(turning, round_) * dt, across_round(m, n, side, rate, end_rate, dt, bend))
    return end < least and (falling or tiny), free, curve, wide


@compiled
def cubic_stays(gap, rate, end, end_rate, value, dt, wide, curve, least):
    """True if the cubic through both ends of an interval of length dt [s], and what it may be off, is not below least.

    value: gap in the middle.  A cubic says nothing where the normal turns by more than WHOLE_TURN.
    """
    if value < least or wide > WHOLE_TURN:
        return False
    missed = abs(value - 0.5 * (gap + end) - 0.125 * dt * (rate - end_rate))
    margin = 2.0 * missed + curve * (wide * dt) ** 2 / 384.0
    return lowest(gap, rate * dt, end, end_rate * dt) - margin >= least


@compiled
def is_tiny(share, h, t):
    """True if a share of the step from t [s] of length h [s] is not divided further."""
    return share * h <= SAME_TIME * abs(t) or share <= SAME_SHARE


@compiled
def growth(near, wide, least, bent):
    """By what the next interval is longer: 2, unless the normal turns far in one and the gap may bend to zero.

    least: of the gaps at both ends [m]; bent: by how much it may bend between them.
    """
    return 2.0 if near or wide <= 0.5 * WHOLE_TURN or least > bent else 1.0


@native("f", "h", "f", "i", "f", "f")
def search(m, h, n, side, until):
    """Share of the step, up to `until`, at which side * gap of contact n first becomes negative; NONE if it does not.

    Returns GAVE_UP after too many samples.
    side: 1 for a contact that may close, -1 for one that may open.  The dense output must be ready, gaps and rates at
    the start of the step in `contact_memory`.  A gap that starts negative (by rounding) must become more negative.
    """
    memory, t = m.contact_memory[n], m.clock[0]
    bend, plain, turning, speed = bounds(m, h, n)
    slight = rounding(m, n)
    left, gap, rate, right = 0.0, side * memory[at.GAP_0], side * memory[at.DGAP_0], until
    least = min(gap, 0.0) - slight  # of all samples: between two a slow gap may fall by less than rounding
    begin, at_begin, rate_begin = left, gap, rate  # the last sample that was positive, or rising
    end, end_rate = signed_gap(m, right, n, side)
    for _ in range(FEW_LOOKS if m.contact[n, at.IMPACT] == 1 else MOST_LOOKS):
        dt, tiny = (right - left) * h, is_tiny(right - left, h, t)
        near = near_point(m, n, side, gap, end, speed, dt)
        below, free, curve, wide = judge(m, n, side, dt, tiny, bend, turning, gap, rate, end, end_rate, least)
        if near:
            free = tiny or least_by_tangents(gap, rate, end, end_rate, dt, plain) >= least
        if below:
            return first_below(m, h, n, side, begin, at_begin, rate_begin, right, end)
        if end < least or not free:
            middle = 0.5 * (left + right)
            value, slope = signed_gap(m, middle, n, side)
            if near or not cubic_stays(gap, rate, end, end_rate, value, dt, wide, curve, least):
                right, end, end_rate = middle, value, slope
                continue
        if right >= until:
            return NONE
        step = growth(near, wide, min(gap, end), bend * dt * dt) * (right - left)
        left, gap, rate = right, end, end_rate
        if gap > 0.0 or rate > 0.0:
            begin, at_begin, rate_begin = left, gap, rate
        right = min(until, left + step)
        end, end_rate = signed_gap(m, right, n, side)
    return GAVE_UP
