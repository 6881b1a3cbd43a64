"""Closed positions from first guesses: compiled, with what `closings` finds and Newton's method.

Bodies are placed by the joints from the ground outwards, then by all closings of the loops; angles that are not given
are tried where the loops do not determine all.  Of all positions that are found those count that change given values
least, and where several do not change them, those whose other angles are nearest to where they are looked for.
"""

from __future__ import annotations

import math

from rattle.equations import start_columns as of
from rattle.equations.closings import begin_search, begin_turn, next_closing, rounded
from rattle.equations.closure import ITERATIONS, SHUT, close_position, merit_at
from rattle.equations.kept_values import MOVED, NOT_CLOSED, NOT_FINITE, REST, ROOT, SIDE, keep_given, take_rows
from rattle.equations.motion import drive
from rattle.jit import layout as at
from rattle.jit.choices import TINY
from rattle.jit.functions import compiled, native
from rattle.jit.small_matrices import solve_square

ALONG = 1e-12  # sizes of the mechanism to which Newton's method goes
# squared change of given values that counts as none [rad^2, sizes^2]: rounding of what came from elsewhere
KEPT = 1e-18
ALIKE = 1e-9  # share by which squared changes of given values differ that are equal but for rounding
WORTH = 25.0  # times the least squared change: a closing beyond it is not looked at more closely
MOST_CLOSINGS = 64  # of all choices of given values that count as exact; LEAST of each
LEAST_CLOSINGS = 4
MOST_TURNS = 16  # choices of given values
HARD = 8  # guesses from which it is tried hard to close, until one does
STEEP = 1e-6  # cosine of a line with an axis, from which on the place on that axis tells how far along the line
DOWN = -0.5 * math.pi  # where a rod points that nothing is known of [rad]
FINE = 1e-9  # parts of angles away from where they are looked for that count [rad^2]
DAMPING = 1e-2  # of the mean square of the rows, at the start of `least_open`
LEAST_DAMPING, MOST_DAMPING = 1e-12, 1e8  # less is none; with more no step is an improvement
EASES, HARDENS = 5.0, 4.0  # factors of the damping after a step, and after one that fails
LEVEL = 1e-14  # slope of |Phi|^2 [sizes] at which it is least
HARDLY = 1e-9  # share by which a step must decrease |Phi|^2 for another one to be worth it
MOST_TURN = 0.5  # rotation of a body in one step [rad]
ROUNDS_DOWN = 80  # of `least_open`


# ---------------------------------------------------------------- from the ground outwards
@compiled
def arm(m, q, body, p):
    """A point of a body, which stands in `values` at p, from its mass centre in ground axes [m]."""
    angle = q[3 * body - 1] if body > 0 else 0.0
    c, s, x, y = math.cos(angle), math.sin(angle), m.values[p], m.values[p + 1]
    return c * x - s * y, s * x + c * y


@compiled
def points_of(m, q, ways, n):
    """The point of the joint of way n on the parent [m], and that on the body, from its mass centre."""
    body, parent, p = ways[n, of.WAY_BODY], ways[n, of.PARENT], ways[n, of.WAY_P]
    first = body == ways[n, of.WAY_B]
    own_x, own_y = arm(m, q, body, p + 2 if first else p)
    x, y = arm(m, q, parent, p if first else p + 2)
    if parent > 0:
        x, y = q[3 * parent - 3] + x, q[3 * parent - 2] + y
    return x, y, own_x, own_y


@compiled
def place_outward(m, q, closing):
    """Place bodies by their joints, from the ground outwards, with the angles in q (3 nb,); in place.

    closing: 1 with the slides and rods in `start_unknown`, 0 with given places, which are kept, and offsets.
    """
    ways, prescribed = m.start_ways, m.start_given
    for k in range(q.shape[0]):
        if k % 3 < 2:
            q[k] = prescribed[k] if prescribed[k] == prescribed[k] else 0.0
    for n in range(m.start_moving.shape[0]):
        k = 3 * m.start_moving[n, of.MOVING_POINT] - 3
        q[k], q[k + 1] = m.values[m.start_moving[n, of.POINT_X]], m.values[m.start_moving[n, of.POINT_Y]]
    for n in range(ways.shape[0]):
        k, sign = 3 * ways[n, of.WAY_BODY] - 3, 1.0 if ways[n, of.WAY_BODY] == ways[n, of.WAY_B] else -1.0
        x, y, own_x, own_y = points_of(m, q, ways, n)
        x0, y0 = x - own_x, y - own_y
        if closing > 0:
            gap_x, gap_y = gap_of_closing(m, q, ways, n)
        elif ways[n, of.FREEDOM] == of.ALONG_LINE:
            gap_x, gap_y = gap_along(m, q, n, x0, y0)
        elif ways[n, of.FREEDOM] == of.ABOUT_POINT:
            gap_x, gap_y = gap_about(
                sign * (prescribed[k] - x0),
                sign * (prescribed[k + 1] - y0),
                m.start_lines[ways[n, of.WAY_JOINT], of.DISTANCE],
            )
        else:
            gap_x, gap_y = m.start_offsets[ways[n, of.WAY_JOINT], 0], m.start_offsets[ways[n, of.WAY_JOINT], 1]
        if closing > 0 or prescribed[k] != prescribed[k]:
            q[k] = x + sign * gap_x - own_x
        if closing > 0 or prescribed[k + 1] != prescribed[k + 1]:
            q[k + 1] = y + sign * gap_y - own_y


@compiled
def gap_of_closing(m, q, ways, n):
    """The gap of a joint: its slide along a line of A, its rod; point of B minus point of A [m]."""
    a, joint, freedom = ways[n, of.WAY_A], ways[n, of.WAY_JOINT], ways[n, of.FREEDOM]
    if freedom == of.FIXED:
        return 0.0, 0.0
    value = m.start_unknown[ways[n, of.WAY_UNKNOWN]] if ways[n, of.WAY_UNKNOWN] >= 0 else math.nan
    if freedom == of.ALONG_LINE:
        length = value if value == value else 0.0
        angle = (q[3 * a - 1] if a > 0 else 0.0) + m.start_lines[joint, of.DIRECTION]
    else:
        length, angle = m.start_lines[joint, of.DISTANCE], value if value == value else DOWN
    return length * math.cos(angle), length * math.sin(angle)


@compiled
def gap_along(m, q, n, x0, y0):
    """The gap of a joint along a line of A [m]: as its driver says, up to given places of its body, or out of a cam.

    x0, y0: of the body without gap [m].
    """
    ways, prescribed, parts = m.start_ways, m.start_given, m.start_parts
    a, body, joint = ways[n, of.WAY_A], ways[n, of.WAY_BODY], ways[n, of.WAY_JOINT]
    k, sign = 3 * body - 3, 1.0 if body == ways[n, of.WAY_B] else -1.0
    axis = (q[3 * a - 1] if a > 0 else 0.0) + m.start_lines[joint, of.DIRECTION]
    c, s = math.cos(axis), math.sin(axis)
    knows_x, knows_y = prescribed[k] == prescribed[k], prescribed[k + 1] == prescribed[k + 1]
    along = math.nan
    for row in range(parts[of.KNOWN], parts[of.KNOWN + 1]):
        if m.start_map[row, of.UNKNOWN] == ways[n, of.WAY_UNKNOWN]:
            along = m.values[m.start_map[row, of.KNOWN_AT]]
    if along == along:
        return c * along, s * along
    if knows_x and knows_y:
        along = sign * (c * (prescribed[k] - x0) + s * (prescribed[k + 1] - y0))
    elif knows_x and abs(c) > STEEP:
        along = sign * (prescribed[k] - x0) / c
    elif knows_y and abs(s) > STEEP:
        along = sign * (prescribed[k + 1] - y0) / s
    else:
        along = out_of_cams(m, q, n, x0, y0, sign * c, sign * s)
    return c * along, s * along


@compiled
def gap_about(x, y, distance):
    """The gap of a joint that keeps a distance [m] in the direction (x, y); downwards if that is not known."""
    size = math.hypot(x, y)
    if size > 0.0:
        return distance * (x / size), distance * (y / size)
    return 0.0, -distance


@compiled
def out_of_cams(m, q, n, x0, y0, ux, uy):
    """Travel [m] along u at which a body that slides is out of the cam that it follows; 0 if it begins outside.

    x0, y0: its position [m] without travel.  Near the centre of a cam no row says which way is out.
    """
    table, parts = m.start_map, m.start_parts
    for row in range(parts[of.CAMS], parts[of.CAMS + 1]):
        if table[row, of.WAY] != n:
            continue
        other, distance = table[row, of.OTHER], m.start_lines[table[row, of.CAM], of.DISTANCE]
        own_x, own_y = arm(m, q, m.start_ways[n, of.WAY_BODY], table[row, of.OWN_POINT])
        far_x, far_y = arm(m, q, other, table[row, of.OTHER_POINT])
        x = x0 + own_x - far_x - (q[3 * other - 3] if other > 0 else 0.0)
        y = y0 + own_y - far_y - (q[3 * other - 2] if other > 0 else 0.0)
        inside, ahead = distance * distance - (x * x + y * y), x * ux + y * uy
        if inside > 0.0:
            return math.sqrt(ahead * ahead + inside) - ahead
    return 0.0


# ---------------------------------------------------------------- guesses
@compiled
def known_angles(m, q):
    """Angles that are given, passed on by joints, or of a start near by, into q (3 nb,)."""
    for body in range(1, m.start_bodies.shape[1]):
        q[3 * body - 1] = m.start_bodies[of.ANGLE, body]


@compiled
def closing_angles(m, q):
    """Angles of a closing into q (3 nb,), in the turns of given ones."""
    bodies, table, first = m.start_bodies, m.start_map, m.start_parts[of.GROUPS]
    for body in range(1, bodies.shape[1]):
        group = table[first + body, of.GROUP]
        near = bodies[of.NEAR, group] if bodies[of.NEAR, group] == bodies[of.NEAR, group] else 0.0
        angle = m.start_unknown[group]
        if angle != angle:
            angle = near
        if group != 0:
            angle += math.tau * round((near - angle) / math.tau)
        q[3 * body - 1] = angle + bodies[of.AHEAD, body]


@compiled
def is_new(m, q):
    """Whether these positions of a closing were not seen before; they are noted."""
    seen, search = m.start_found, m.start_search
    for row in range(of.FIRST_SEEN, of.FIRST_SEEN + search[of.SEEN]):
        most = 0.0
        for k in range(q.shape[0]):
            most = max(most, abs(seen[row, k] - q[k]))
        if not most > SHUT * m.start_size[0]:
            return False
    if of.FIRST_SEEN + search[of.SEEN] < seen.shape[0]:
        copy_numbers(q, seen[of.FIRST_SEEN + search[of.SEEN]])
        search[of.SEEN] += 1
    return True


@compiled
def copy_numbers(numbers, into):
    """Copy a vector into another one."""
    for k in range(into.shape[0]):
        into[k] = numbers[k]


# ---------------------------------------------------------------- positions at which a mechanism is least open
@compiled
def residuals_at(m, q, phi):
    """Residuals at q into phi (nr,); the sum of their squares."""
    square = merit_at(m, q)
    for r in range(m.rows.shape[0]):
        phi[r] = m.rows[r, at.RES]
    return square


@compiled
def weigh_rows(m, phi):
    """Phi_q in `kept_rows`, weighted by mass: the steepest slope of |Phi|^2 / 2, and the sum of all squares."""
    rows, root, steepest, trace = m.kept_rows, m.kept_places[ROOT], 0.0, 0.0
    for k in range(rows.shape[1]):
        slope = 0.0
        for r in range(rows.shape[0]):
            rows[r, k] *= root[k]
            slope += rows[r, k] * phi[r]
            trace += rows[r, k] * rows[r, k]
        steepest = max(steepest, abs(slope))
    return steepest, trace


@compiled
def damped_normal(m, damping):
    """Rows times rows into `kept_left`, with damping on its diagonal."""
    rows, normal = m.kept_rows, m.kept_left
    for r in range(rows.shape[0]):
        for i in range(rows.shape[0]):
            value = damping if i == r else 0.0
            for k in range(rows.shape[1]):
                value += rows[r, k] * rows[i, k]
            normal[r, i] = value


@native("void", "h", "f", "v")
def least_open(m, t, q):
    """Minimise |Phi|^2 over q (3 nb,), in place: Levenberg-Marquardt, weighted by mass, also where rank is lost."""
    rows, normal, places = m.kept_rows, m.kept_left, m.kept_places
    root, step, trial = places[ROOT], places[0], places[1]
    phi, right, solved = m.kept_sides[0], m.kept_sides[SIDE], m.kept_sides[REST]
    nr, n, most = rows.shape[0], q.shape[0], 0.0
    for k in range(n):
        most = max(most, m.weight[k // 3 + 1, k % 3])
    for k in range(n):
        root[k] = math.sqrt(m.weight[k // 3 + 1, k % 3] / most)
    damping = DAMPING
    drive(m, t)
    square = residuals_at(m, q, phi)
    for _ in range(ROUNDS_DOWN):
        if not take_rows(m):
            break
        steepest, trace = weigh_rows(m, phi)
        if not steepest < math.inf or steepest < LEVEL:
            break
        damped_normal(m, damping * trace / n)
        for r in range(nr):
            right[r] = phi[r]
        solve_square(normal, nr, m.kept_order[0], m.kept_pivot_tall, right, 0.0, m.kept_sides[4], solved)
        turn = TINY
        for k in range(n):
            value = 0.0
            for r in range(nr):
                value += rows[r, k] * solved[r]
            step[k] = -root[k] * value
            if k % 3 == 2:
                turn = max(turn, abs(step[k]))
        share = min(1.0, MOST_TURN / turn)
        for k in range(n):
            trial[k] = q[k] + share * step[k]
        now = merit_at(m, trial)
        if now < square:
            small = now > (1.0 - HARDLY) * square
            copy_numbers(trial, q)
            square = residuals_at(m, q, phi)
            damping = max(damping / EASES, LEAST_DAMPING)
            if small:
                break
        else:
            damping *= HARDENS
            merit_at(m, q)
            if damping > MOST_DAMPING:
                break


# ---------------------------------------------------------------- closings
@compiled
def change_of_given(m, q):
    """Sum of the squared changes of given positions, angles in rad and lengths in sizes of the mechanism."""
    total, prescribed, size = 0.0, m.start_given, m.start_size[0]
    for k in range(q.shape[0]):
        if prescribed[k] == prescribed[k]:
            off = q[k] - prescribed[k]
            if k % 3 < 2:
                off /= size
            total += off * off
    return total


@compiled
def angles_away(m, q):
    """How far angles that are sought are from 0, squared, without whole turns and with them [rad^2].

    From those of a start near by where there is one.  Rounded, for those that are equal but for rounding.
    """
    less, more, parts = 0.0, 0.0, m.start_parts
    for row in range(parts[of.FREE], parts[of.FREE + 1]):
        body = m.start_map[row, of.TO]
        off = q[3 * body - 1] - m.start_bodies[of.ANGLE, body]
        more += off * off
        off -= math.tau * round(off / math.tau)
        less += off * off
    return rounded(less, 1.0 / FINE), rounded(more, 1.0 / FINE)


@compiled
def close_hard(m, t, q):
    """Close the mechanism from q (3 nb,), in place; returns the gap [m or rad]."""
    search, positions, size = m.start_search, m.start_found, m.start_size[0]
    number = search[of.TRIED]
    search[of.TRIED] += 1
    copy_numbers(q, positions[of.BEFORE])
    gap, iterations = close_position(m, t, q, m.start_scratch[0], ALONG * size, ITERATIONS)
    search[of.ITERATIONS] += iterations
    if not gap <= SHUT * size and m.start_form[of.SMALL] > 0 and search[of.CLOSINGS] == 0 and number < HARD:
        copy_numbers(positions[of.BEFORE], q)
        least_open(m, t, q)
        gap, iterations = close_position(m, t, q, m.start_scratch[0], ALONG * size, ITERATIONS)
        search[of.ITERATIONS] += iterations
    return gap


@compiled
def consider(m, t, beside):
    """Close the mechanism from the guess in `start_found` and judge what is found; True if no other is needed.

    beside: whether it is beside the mechanism without play, and taken if it closes.
    """
    search, positions, judged, size = m.start_search, m.start_found, m.start_judged, m.start_size[0]
    q = positions[of.NOW]
    gap = close_hard(m, t, q)
    if not gap <= SHUT * size:
        if search[of.TRIED] == 1 or gap < judged[of.GAP]:
            judged[of.GAP] = gap
            copy_numbers(q, positions[of.LEAST_OPEN])
        return False
    small, first = m.start_form[of.SMALL] > 0, search[of.CLOSINGS] == 0
    search[of.CLOSINGS] += 1
    if first and small and not beside and keep_given(m, t, q, m.start_given, size) == NOT_FINITE:
        search[of.NO_VALUE] = 1
        return True
    change = change_of_given(m, q)
    if not beside and small:
        return enter_closing(m, q, change, first)
    if first or change < judged[of.OF_FIRST]:
        enter_first(m, q, change)
    return beside or change <= KEPT


@compiled
def enter_closing(m, q, change, first):
    """Note a closing; True if no other is needed."""
    judged = m.start_judged
    if first:
        enter_first(m, q, change)
    elif judged[of.OF_FIRST] > KEPT >= change:  # those before change given values
        enter_first(m, q, change)
        return False
    else:
        enter_later(m, q, change)
    return judged[of.OF_FIRST] <= KEPT and (m.start_search[of.SETTLED] > 0 or change > KEPT)


@compiled
def enter_first(m, q, change):
    """Note the first closing, and forget all others."""
    judged = m.start_judged
    copy_numbers(q, m.start_found[of.FIRST])
    m.start_search[of.LATER] = 0
    judged[of.OF_FIRST] = change
    judged[of.AWAY_LESS] = math.inf
    enter_by_angle(m, q, change)


@compiled
def enter_by_angle(m, q, change):
    """Note a closing that keeps given values, if its other angles are nearer than those of the ones before."""
    judged = m.start_judged
    if change <= KEPT:
        less, more = angles_away(m, q)
        if less < judged[of.AWAY_LESS] or (less == judged[of.AWAY_LESS] and more < judged[of.AWAY_MORE]):
            judged[of.AWAY_LESS] = less
            judged[of.AWAY_MORE] = more
            copy_numbers(q, m.start_found[of.BY_ANGLE])


@compiled
def enter_later(m, q, change):
    """Note a further closing, those first that change given values least."""
    search, positions, changes = m.start_search, m.start_found, m.start_judged
    enter_by_angle(m, q, change)
    place = search[of.LATER]
    for k in range(search[of.LATER]):
        if change < changes[of.OF_LATER + k]:
            place = k
            break
    if place == of.LOOKED:
        return
    search[of.LATER] = min(search[of.LATER] + 1, of.LOOKED)
    for k in range(search[of.LATER] - 1, place, -1):
        changes[of.OF_LATER + k] = changes[of.OF_LATER + k - 1]
        copy_numbers(positions[of.NEXT + k - 1], positions[of.NEXT + k])
    changes[of.OF_LATER + place] = change
    copy_numbers(q, positions[of.NEXT + place])


@compiled
def move_to_nearest(m, t):
    """Of the closings that change given values, move those to change them less that may then change them least.

    The best becomes the first.
    """
    positions, judged, q, size = m.start_found, m.start_judged, m.start_found[of.NOW], m.start_size[0]
    for k in range(m.start_search[of.LATER]):
        change = judged[of.OF_LATER + k]
        if change > WORTH * judged[of.OF_FIRST]:
            break
        copy_numbers(positions[of.NEXT + k], q)
        if keep_given(m, t, q, m.start_given, size) == NOT_FINITE:
            m.start_search[of.NO_VALUE] = 1
            return
        change = min(change, change_of_given(m, q))  # moved by mass, it may count more than before
        if change < (1.0 - ALIKE) * judged[of.OF_FIRST]:
            judged[of.OF_FIRST] = change
            copy_numbers(q, positions[of.FIRST])


@compiled
def try_beside(m, t, ideal):
    """Guesses beside the mechanism without play, at ideal (3 nb,).

    The first with its angles where none is given; given ones may be rough: those of the second are right within play.
    """
    q, parts = m.start_found[of.NOW], m.start_parts
    known_angles(m, q)
    for row in range(parts[of.FREE], parts[of.FREE + 1]):
        q[3 * m.start_map[row, of.TO] - 1] = ideal[3 * m.start_map[row, of.TO] - 1]
    place_outward(m, q, 0)
    if not consider(m, t, True):
        for k in range(2, q.shape[0], 3):
            q[k] = ideal[k]
        place_outward(m, q, 0)
        consider(m, t, True)


@compiled
def try_closings(m, t, turn, most):
    """At most so many closings of the loops, of one choice of given values; True if no other guess is needed."""
    q, parts, search = m.start_found[of.NOW], m.start_parts, m.start_search
    begin_turn(m)
    for _ in range(most):
        if not next_closing(m, turn):
            return False
        closing_angles(m, q)
        place_outward(m, q, 1)
        if is_new(m, q):
            search[of.SETTLED] = 1 if parts[of.FREE + 1] == parts[of.FREE] or search[of.COMPLETE] == 0 else 0
            if consider(m, t, False):
                return True
    return False


@compiled
def try_all(m, t):
    """All guesses, until no other is needed; True if all closings are known that keep the given values."""
    q, parts, search = m.start_found[of.NOW], m.start_parts, m.start_search
    free, wishes = parts[of.FREE + 1] - parts[of.FREE], parts[of.WISHES + 1] - parts[of.WISHES]
    search[of.SETTLED] = 1 if free == 0 else 0
    known_angles(m, q)
    place_outward(m, q, 0)
    if consider(m, t, False) or m.start_form[of.LOOPED] == 0:
        return False
    if wishes + parts[of.WISH_LOOPS] - parts[of.LOOPS] > 0:
        turns = min(max(1, wishes), MOST_TURNS)
        for turn in range(turns):
            if try_closings(m, t, turn, max(LEAST_CLOSINGS, MOST_CLOSINGS // turns)):
                return search[of.COMPLETE] > 0
    if free == 0 or search[of.COMPLETE] > 0 or m.start_form[of.SMALL] == 0:
        return search[of.COMPLETE] > 0
    for n in range(m.start_turns.shape[0]):
        known_angles(m, q)
        for row in range(parts[of.FREE], parts[of.FREE + 1]):
            q[3 * m.start_map[row, of.TO] - 1] = m.start_turns[n, row - parts[of.FREE]]
        place_outward(m, q, 0)
        if consider(m, t, False):
            break
    return False


@native("void", "h", "f", "v")
def guess_first(m, t, q):
    """The first guess of positions at t [s] into q (3 nb,)."""
    drive(m, t)
    begin_search(m)
    known_angles(m, q)
    place_outward(m, q, 0)


@native("ii", "h", "f", "v", "v", "i")
def find_closing(m, t, q, ideal, beside):
    """Closed positions into q (3 nb,) that change given values least among all that are found.

    Where several do, the first of them.  beside: 1 to look beside the mechanism without play at ideal (3 nb,) only.
    Returns what became of q, and the number of iterations; where nothing closes q is where the gap is least.
    """
    drive(m, t)
    begin_search(m)
    search, positions = m.start_search, m.start_found
    discrete = False
    if beside > 0:
        try_beside(m, t, ideal)
    else:
        discrete = try_all(m, t)
    if search[of.NO_VALUE] == 0 and search[of.CLOSINGS] == 0:
        copy_numbers(positions[of.LEAST_OPEN], q)
        return NOT_CLOSED, search[of.ITERATIONS]
    by_angle = discrete and m.start_judged[of.AWAY_LESS] < math.inf
    if not by_angle and beside == 0 and m.start_form[of.SMALL] > 0 and search[of.NO_VALUE] == 0:
        move_to_nearest(m, t)
    copy_numbers(positions[of.BY_ANGLE] if by_angle else positions[of.FIRST], q)
    return NOT_FINITE if search[of.NO_VALUE] > 0 else MOVED, search[of.ITERATIONS]
