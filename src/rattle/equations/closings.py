"""All ways in which the loops of a mechanism close, in closed form where two unknowns are left in a loop.

Around a loop, in complex numbers,

    sum_k exp(i theta_k) (d_k + sum_j s_j u_j) = 0

theta_k is the angle of bodies that turn together, d_k what they span in the loop, s_j how far a block or a pin has slid
along u_j on them; a rod spans its length at an angle of its own.  Known parts add up to c.  What two unknowns can be:

    two angles                       a triangle with the sides |d_1|, |d_2|, |c|
    an angle, a slide s              |c + s u| = |d|, or |d + s u| = |c| where the slide turns with the angle
    two slides                       linear

so that there are at most two solutions.  Where every loop has more unknowns, a given value counts as exact, every one
in its turn; all of them are wishes otherwise: those closings come first that change them least.

Which loops there are, and through what they lead, belongs to the form of a mechanism: `analyses.assembly.loop_map`
writes it into `start_map`.  Unknowns have numbers: the angle of a group of bodies that turn together has that of its
first body, 0 is the ground; angles of rods follow, then slides.
"""

from __future__ import annotations

import math

from rattle.equations import start_columns as of
from rattle.jit.functions import compiled

TINY = 1e-12  # share of the mechanism's size that spans nothing
PARALLEL = 2e-12  # sine of the angle between two slides that are one
MOST_NODES = 3000  # parts of loops that are solved for one of them: a value at the end of ten four-bars decides late
PARTS = 1e14  # of 1, to which changes are rounded before they are compared
WHOLE = 1e18  # numbers so large are whole numbers


# ---------------------------------------------------------------- angles that are known, what loops span
@compiled
def tie(m, row):
    """By how much a body is ahead of another one in a row of TIED or PASSED [rad]."""
    entry = m.start_map[row]
    angle = m.values[entry[of.SLOT]] if entry[of.SLOT] >= 0 else m.start_lines[entry[of.TIE], of.KEPT_ANGLE]
    return angle if entry[of.SIGN] > 0 else -angle


@compiled
def begin_search(m):
    """Angles that are given or passed on, what is near, and what loops span; values of drivers are in `values`."""
    bodies, parts, table = m.start_bodies, m.start_parts, m.start_map
    for body in range(bodies.shape[1]):
        near = m.start_near[3 * body - 1] if body > 0 else 0.0
        prescribed = m.start_given[3 * body - 1] if body > 0 else 0.0
        bodies[of.ANGLE, body] = prescribed if prescribed == prescribed else near if near == near else 0.0
        bodies[of.AHEAD, body] = 0.0
        bodies[of.NEAR, body] = math.nan
        bodies[of.EXACT, body] = math.nan
    for row in range(parts[of.TIED], parts[of.TIED + 1]):
        bodies[of.AHEAD, table[row, of.TO]] = bodies[of.AHEAD, table[row, of.FROM]] + tie(m, row)
    for row in range(parts[of.PASSED], parts[of.PASSED + 1]):
        bodies[of.ANGLE, table[row, of.TO]] = bodies[of.ANGLE, table[row, of.FROM]] + tie(m, row)
    for body in range(1, bodies.shape[1]):
        group, near = table[parts[of.GROUPS] + body, of.GROUP], m.start_near[3 * body - 1]
        if bodies[of.NEAR, group] != bodies[of.NEAR, group]:
            bodies[of.NEAR, group] = near - bodies[of.AHEAD, body]
    for row in range(parts[of.WISHES], parts[of.WISHES + 1]):
        if table[row, of.WISH] < 0:
            body = table[row, of.OF_BODY]
            group = table[parts[of.GROUPS] + body, of.GROUP]
            bodies[of.EXACT, group] = m.start_given[3 * body - 1] - bodies[of.AHEAD, body]
            bodies[of.NEAR, group] = bodies[of.EXACT, group]
    add_terms(m)
    search = m.start_search
    for k in range(search.shape[0]):
        search[k] = 0
    search[of.COMPLETE] = 1


@compiled
def add_terms(m):
    """What groups and rods span in loops at their angle 0, and directions of slides, into `start_spans`."""
    spans, table, parts = m.start_spans, m.start_map, m.start_parts
    for k in range(spans.shape[0]):
        spans[k, 0] = 0.0
        spans[k, 1] = 0.0
    for row in range(parts[of.TERMS], parts[of.TERMS + 1]):
        term = table[row]
        into, kind, sign = spans[term[of.INTO]], term[of.TERM], 1.0 if term[of.SENSE] > 0 else -1.0
        if kind == of.POINT:
            x, y = 0.0, 0.0
            if term[of.PLUS] >= 0:
                x, y = m.values[term[of.PLUS]], m.values[term[of.PLUS] + 1]
            if term[of.MINUS] >= 0:
                x -= m.values[term[of.MINUS]]
                y -= m.values[term[of.MINUS] + 1]
            ahead = m.start_bodies[of.AHEAD, term[of.BODY]]
            c, s = math.cos(ahead), math.sin(ahead)
            into[0] += c * x - s * y
            into[1] += c * y + s * x
        elif kind == of.ROD:
            into[0] += sign * m.start_lines[term[of.PLUS], of.DISTANCE]
        elif kind == of.LINE:
            angle = m.start_bodies[of.AHEAD, term[of.BODY]] + m.start_lines[term[of.PLUS], of.DIRECTION]
            into[0] = sign * math.cos(angle)
            into[1] = sign * math.sin(angle)
        elif kind == of.AXIS:
            into[term[of.PLUS]] = -1.0
        else:
            value = m.start_given[term[of.PLUS]] if kind == of.GIVEN else m.values[term[of.PLUS]]
            into[term[of.MINUS]] -= sign * value


# ---------------------------------------------------------------- what is known at a node
@compiled
def know(m, node):
    """Enter what is known at a node into `start_unknown`, and which given values do not count yet.

    Returns how many loops through given values do: they are listed in `start_wishes`, in their order.
    """
    value, wishes, steps, parts = m.start_unknown, m.start_wishes, m.start_steps, m.start_parts
    for k in range(value.shape[0]):
        value[k] = math.nan
    value[0] = 0.0
    for row in range(parts[of.KNOWN], parts[of.KNOWN + 1]):
        value[m.start_map[row, of.UNKNOWN]] = m.values[m.start_map[row, of.KNOWN_AT]]
    for k in range(wishes.shape[1]):
        wishes[of.PENDING, k] = 1
    depth, active, at_node = 0, 0, node
    for _ in range(wishes.shape[1]):
        if steps[at_node, of.NODE] < 0:
            break
        wishes[of.PATH, depth] = at_node
        depth += 1
        at_node = steps[at_node, of.NODE]
    for k in range(depth - 1, -1, -1):
        ancestor = wishes[of.PATH, k]
        if steps[ancestor, of.EVENT] == of.WITH_LOOP:
            wishes[of.PENDING, steps[ancestor, of.WHICH]] = 0
            wishes[of.ACTIVE, active] = m.start_map[parts[of.WISHES] + steps[ancestor, of.WHICH], of.WISH]
            active += 1
        elif steps[ancestor, of.EVENT] == of.NO_MORE_WISHES:
            for n in range(wishes.shape[1]):
                wishes[of.PENDING, n] = 0
        else:
            if steps[ancestor, of.ONE] >= 0:
                value[steps[ancestor, of.ONE]] = m.start_nodes[ancestor, of.ONE_VALUE]
            if steps[ancestor, of.ANOTHER] >= 0:
                value[steps[ancestor, of.ANOTHER]] = m.start_nodes[ancestor, of.OTHER_VALUE]
    return active


@compiled
def span(m, loop, vector):
    """What a group spans in a loop at its angle 0, with slides that are known [m].  loop, vector: rows of the map."""
    table, parts = m.start_map, m.start_parts
    first, slides = m.start_spans[vector - parts[of.VECTORS]], parts[of.VECTORS]
    x, y = first[0], first[1]
    for row in range(table[loop, of.FIRST_SLIDE], table[loop, of.END_SLIDE]):
        way = m.start_unknown[table[row, of.SLIDE]]
        if table[row, of.TURNS] == table[vector, of.GROUP] and way == way:
            unit = m.start_spans[row - slides]
            x += way * unit[0]
            y += way * unit[1]
    return x, y


@compiled
def unknown_parts(m, loop):
    """How many angles and slides a loop may determine, and the rows of the first two of each."""
    table, value, tiny = m.start_map, m.start_unknown, TINY * m.start_size[0]
    angles, first, second, slides, slide, more = 0, -1, -1, 0, -1, -1
    for row in range(table[loop, of.FIRST_SLIDE], table[loop, of.END_SLIDE]):
        if value[table[row, of.SLIDE]] != value[table[row, of.SLIDE]]:
            slides += 1
            if slides == 1:
                slide = row
            elif slides == 2:
                more = row
    for row in range(table[loop, of.FIRST_VECTOR], table[loop, of.END_VECTOR]):
        group = table[row, of.GROUP]
        if value[group] == value[group]:
            continue
        sliding = False
        for k in range(table[loop, of.FIRST_SLIDE], table[loop, of.END_SLIDE]):
            if table[k, of.TURNS] == group and value[table[k, of.SLIDE]] != value[table[k, of.SLIDE]]:
                sliding = True
        x, y = span(m, loop, row)
        if sliding or math.hypot(x, y) > tiny:
            angles += 1
            if angles == 1:
                first = row
            elif angles == 2:
                second = row
    return angles, first, second, slides, slide, more


@compiled
def easiest_loop(m, active):
    """The loop with the fewest unknowns, -1 if all are closed; how many these are, and how many loops are open."""
    parts = m.start_parts
    base, best, least, open_loops = parts[of.WISH_LOOPS] - parts[of.LOOPS], -1, 0, 0
    for k in range(base + active):
        loop = parts[of.LOOPS] + k if k < base else m.start_wishes[of.ACTIVE, k - base]
        angles, _one, _other, slides, _slide, _more = unknown_parts(m, loop)
        if angles + slides > 0:
            open_loops += 1
            if best < 0 or angles + slides < least:
                best, least = loop, angles + slides
    return best, least, open_loops


# ---------------------------------------------------------------- two unknowns
@compiled
def direction(x, y, along_x, along_y):
    """The angle of (x, y) from a direction [rad]: of their quotient as complex numbers."""
    if abs(along_x) >= abs(along_y):
        share = along_y / along_x
        whole = along_x + along_y * share
        return math.atan2((y - x * share) / whole, (x + y * share) / whole)
    share = along_x / along_y
    whole = along_x * share + along_y
    return math.atan2((y * share - x) / whole, (x * share + y) / whole)


@compiled
def triangle(ax, ay, bx, by, cx, cy):
    """Angles of a and b [rad] with exp(i alpha) a + exp(i beta) b + c = 0: how many pairs, and both.

    And by how much the sides are too short.
    """
    long, wide, across = math.hypot(ax, ay), math.hypot(bx, by), math.hypot(cx, cy)
    if across == 0.0 or long == 0.0 or wide == 0.0:
        return 0, 0.0, 0.0, 0.0, 0.0, 0.0
    short = max(max(across - long - wide, long - across - wide), max(wide - across - long, 0.0))
    cosine = (long * long + across * across - wide * wide) / (2.0 * long * across)
    bend = math.acos(min(1.0, max(-1.0, cosine)))
    back = math.atan2(-cy, -cx)
    alpha, beta = third_side(ax, ay, bx, by, cx, cy, back + bend)
    if bend == 0.0 or bend == math.pi:
        return 1, alpha, beta, 0.0, 0.0, short
    alpha_2, beta_2 = third_side(ax, ay, bx, by, cx, cy, back - bend)
    return 2, alpha, beta, alpha_2, beta_2, short


@compiled
def third_side(ax, ay, bx, by, cx, cy, angle):
    """Angles of a and b [rad] where a has a direction [rad] and b leads from its end back to -c."""
    long = math.hypot(ax, ay)
    x, y = long * math.cos(angle), long * math.sin(angle)
    back_x, back_y = -cx - x, -cy - y
    beta = direction(back_x, back_y, bx, by) if back_x != 0.0 or back_y != 0.0 else 0.0
    return direction(x, y, ax, ay), beta


@compiled
def onto_circle(x, y, ux, uy, radius):
    """Ways s [m] along the unit u with |(x, y) + s u| = radius [m]: how many, and both.

    And by how much the radius is too short.
    """
    along, beside = -(x * ux + y * uy), abs(x * uy - y * ux)
    half = math.sqrt(max(0.0, (radius - beside) * (radius + beside)))
    return (2 if half > 0.0 else 1), along + half, along - half, max(0.0, beside - radius)


@compiled
def solve_loop(m, loop):
    """Values of at most two unknowns with which a loop closes: how many pairs, their numbers, both pairs.

    And by how much lengths are too short, in sizes of the mechanism, squared.
    """
    table, value, parts = m.start_map, m.start_unknown, m.start_parts
    angles, first, second, slides, slide, more = unknown_parts(m, loop)
    cx, cy = 0.0, 0.0
    for row in range(table[loop, of.FIRST_VECTOR], table[loop, of.END_VECTOR]):
        angle = value[table[row, of.GROUP]]
        if angle == angle:
            x, y = span(m, loop, row)
            c, s = math.cos(angle), math.sin(angle)
            cx += c * x - s * y
            cy += c * y + s * x
    count, unknown, other, short = 0, -1, -1, 0.0
    a1, b1, a2, b2 = 0.0, 0.0, 0.0, 0.0
    if angles == 2:
        ax, ay = span(m, loop, first)
        bx, by = span(m, loop, second)
        unknown, other = table[first, of.GROUP], table[second, of.GROUP]
        count, a1, b1, a2, b2, short = triangle(ax, ay, bx, by, cx, cy)
    elif angles == 1:
        dx, dy = span(m, loop, first)
        unknown = table[first, of.GROUP]
        if slides == 0:
            count, a1 = 1, direction(-cx, -cy, dx, dy)
        else:
            other = table[slide, of.SLIDE]
            ux, uy = m.start_spans[slide - parts[of.VECTORS], 0], m.start_spans[slide - parts[of.VECTORS], 1]
            if table[slide, of.TURNS] == unknown:
                count, b1, b2, short = onto_circle(dx, dy, ux, uy, math.hypot(cx, cy))
                a1 = turned_to(-cx, -cy, dx + b1 * ux, dy + b1 * uy)
                a2 = turned_to(-cx, -cy, dx + b2 * ux, dy + b2 * uy)
            else:
                turn = value[table[slide, of.TURNS]]
                c, s = math.cos(turn), math.sin(turn)
                ux, uy = ux * c - uy * s, ux * s + uy * c
                count, b1, b2, short = onto_circle(cx, cy, ux, uy, math.hypot(dx, dy))
                a1 = turned_to(-(cx + b1 * ux), -(cy + b1 * uy), dx, dy)
                a2 = turned_to(-(cx + b2 * ux), -(cy + b2 * uy), dx, dy)
    else:
        count, unknown = 1, table[slide, of.SLIDE]
        ux, uy = unit_now(m, slide)
        a1 = -(ux * cx + uy * cy)
        if slides == 2:
            other = table[more, of.SLIDE]
            wx, wy = unit_now(m, more)
            turn = ux * wy - uy * wx
            if abs(turn) > PARALLEL:
                a1, b1 = -(cx * wy - cy * wx) / turn, -(ux * cy - uy * cx) / turn
            else:
                a1, b1 = 0.5 * a1, -0.5 * (wx * cx + wy * cy)
    short /= m.start_size[0]
    return count, unknown, other, a1, b1, a2, b2, short * short


@compiled
def turned_to(x, y, from_x, from_y):
    """`direction`, 0 from a point."""
    return direction(x, y, from_x, from_y) if from_x != 0.0 or from_y != 0.0 else 0.0


@compiled
def unit_now(m, slide):
    """The direction of a slide whose group has a known angle."""
    unit, turn = m.start_spans[slide - m.start_parts[of.VECTORS]], m.start_unknown[m.start_map[slide, of.TURNS]]
    c, s = math.cos(turn), math.sin(turn)
    return unit[0] * c - unit[1] * s, unit[0] * s + unit[1] * c


# ---------------------------------------------------------------- nodes; those that change given values least first
@compiled
def before(m, node, other):
    """True if a node is to be looked at before another one."""
    for key in range(of.AWAY + 1):
        if m.start_nodes[node, key] != m.start_nodes[other, key]:
            return m.start_nodes[node, key] < m.start_nodes[other, key]
    return node < other


@compiled
def push(m, parent, event, which):
    """A new node, like another one, on the heap; returns it."""
    search, nodes, steps = m.start_search, m.start_nodes, m.start_steps
    node = search[of.NODES]
    search[of.NODES] += 1
    steps[node, of.NODE] = parent
    steps[node, of.EVENT] = event
    steps[node, of.WHICH] = which
    steps[node, of.ONE] = -1
    steps[node, of.ANOTHER] = -1
    for k in range(nodes.shape[1]):
        nodes[node, k] = nodes[parent, k] if parent >= 0 else 0.0
    return node


@compiled
def onto_heap(m, node):
    """Put a node onto the heap, once its numbers are known."""
    search, heap = m.start_search, m.start_heap
    k = search[of.HEAPED]
    search[of.HEAPED] += 1
    heap[k] = node
    for _ in range(64):
        if k == 0 or not before(m, node, heap[(k - 1) // 2]):
            break
        heap[k] = heap[(k - 1) // 2]
        k = (k - 1) // 2
        heap[k] = node


@compiled
def from_heap(m):
    """The first node, taken from the heap."""
    search, heap = m.start_search, m.start_heap
    first = heap[0]
    search[of.HEAPED] -= 1
    count, k = search[of.HEAPED], 0
    last = heap[count]
    for _ in range(64):
        child = 2 * k + 1
        if child >= count:
            break
        if child + 1 < count and before(m, heap[child + 1], heap[child]):
            child += 1
        if not before(m, heap[child], last):
            break
        heap[k] = heap[child]
        k = child
    heap[k] = last
    return first


@compiled
def rounded(x, parts):
    """A number that is rounded to parts of 1, for those that are equal but for rounding."""
    return round(x * parts) / parts if abs(x) < WHOLE / parts else x


@compiled
def miss(angle, near):
    """Squared angle between two directions [rad^2]."""
    off = angle - near
    off -= math.tau * round(off / math.tau)
    return off * off


@compiled
def branch(m, node, loop, open_loops):
    """New nodes for the solutions of a loop."""
    count, first, second, a1, b1, a2, b2, short = solve_loop(m, loop)
    nodes, bodies = m.start_nodes, m.start_bodies
    for n in range(count):
        child = push(m, node, of.SET, 0)
        change, away = 0.0, 0.0
        for k in range(2):
            unknown, value = first if k == 0 else second, (a1 if n == 0 else a2) if k == 0 else (b1 if n == 0 else b2)
            m.start_steps[child, of.ONE + k] = unknown
            nodes[child, of.ONE_VALUE + k] = value
            if 0 <= unknown < m.start_form[of.ANGLES]:
                near = bodies[of.NEAR, unknown] if unknown < bodies.shape[1] else math.nan
                off = miss(value, near if near == near else 0.0)
                away += off
                if unknown < bodies.shape[1] and bodies[of.EXACT, unknown] == bodies[of.EXACT, unknown]:
                    change += off
        nodes[child, of.CHANGE] = rounded(nodes[node, of.CHANGE] + change + short, PARTS)
        nodes[child, of.OPEN] = open_loops - 1
        nodes[child, of.AWAY] = nodes[node, of.AWAY] + away
        onto_heap(m, child)


@compiled
def add_wish(m, node, loop, turn):
    """A new node with the next of the given values that says something, or else with an angle or a slide of 0.

    loop: whose first unknown that is, -1: no given value counts any more.
    """
    table, parts, value = m.start_map, m.start_parts, m.start_unknown
    count = parts[of.WISHES + 1] - parts[of.WISHES]
    for k in range(count):
        wish = (turn + k) % count
        if m.start_wishes[of.PENDING, wish] == 0:
            continue
        row = parts[of.WISHES] + wish
        if table[row, of.WISH] >= 0:
            angles, _one, _other, slides, _slide, _more = unknown_parts(m, table[row, of.WISH])
            if angles + slides <= 2:
                onto_heap(m, push(m, node, of.WITH_LOOP, wish))
                return
        else:
            group = table[parts[of.GROUPS] + table[row, of.OF_BODY], of.GROUP]
            if value[group] != value[group]:
                set_one(m, node, group, m.start_bodies[of.EXACT, group])
                return
    if loop < 0:
        onto_heap(m, push(m, node, of.NO_MORE_WISHES, 0))
        return
    m.start_search[of.COMPLETE] = 0
    angles, first, _other, _slides, slide, _more = unknown_parts(m, loop)
    if angles > 0:
        group = table[first, of.GROUP]
        near = m.start_bodies[of.NEAR, group] if group < m.start_bodies.shape[1] else 0.0
        set_one(m, node, group, near if near == near else 0.0)
    else:
        set_one(m, node, table[slide, of.SLIDE], 0.0)


@compiled
def set_one(m, node, unknown, value):
    """A new node with a value of one unknown."""
    child = push(m, node, of.SET, 0)
    m.start_steps[child, of.ONE] = unknown
    m.start_nodes[child, of.ONE_VALUE] = value
    onto_heap(m, child)


@compiled
def begin_turn(m):
    """Look for closings from the beginning."""
    for k in (of.HEAPED, of.NODES, of.LOOKED_AT):
        m.start_search[k] = 0
    node = push(m, -1, of.BEGUN, 0)
    m.start_nodes[node, of.OPEN] = m.start_parts[of.WISH_LOOPS] - m.start_parts[of.LOOPS]
    onto_heap(m, node)


@compiled
def next_closing(m, turn):
    """Whether there is another closing, whose unknowns are then in `start_unknown`.

    turn: the first of the given values that count as exact.
    """
    search = m.start_search
    for _ in range(MOST_NODES):
        full = search[of.NODES] + 2 > m.start_nodes.shape[0]  # as no search of finite numbers is
        if full or search[of.HEAPED] == 0 or search[of.LOOKED_AT] == MOST_NODES:
            return False
        search[of.LOOKED_AT] += 1
        node = from_heap(m)
        active = know(m, node)
        loop, unknown, open_loops = easiest_loop(m, active)
        wishing = False
        for k in range(m.start_parts[of.WISHES + 1] - m.start_parts[of.WISHES]):
            wishing = wishing or m.start_wishes[of.PENDING, k] > 0
        if loop >= 0 and unknown <= 2:
            branch(m, node, loop, open_loops)
        elif loop >= 0 or wishing:
            add_wish(m, node, loop, turn)
        else:
            return True
    return False
