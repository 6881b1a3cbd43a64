"""Interval arithmetic for expressions of time: bounds of a program and of its rate over a span of time.

Source: Moore, Kearfott, Cloud, Introduction to Interval Analysis (2009), chapters 2, 5 and 6.
"""

from __future__ import annotations

import math

from rattle.jit.functions import compiled, native
from rattle.language import bytecode as p
from rattle.language.bytecode import SIDE, power, quotient, unary, whole
from rattle.language.span import INF, NAN, Span, chain, least, most, product, steady, wave_span, whole_span
from rattle.language.table_intervals import knot_span, table_span

TURN = 2.0 * math.pi
LARGEST_POWER = 100.0  # whole exponents up to this one are powers, others logarithms


@native("void", "n", "v", "i", "i", "f", "f", "m", "m")
def enclose(code, const, first, last, low, high, signals, stack):
    """Bounds of what the program in rows first..last-1 leaves on its stack, over the times low..high [s].

    signals (ns, 4 or more), stack (depth, 4): spans.  Switches are on the sides in `code`; 0: not known.
    """
    top = -1
    for row in range(first, last):
        op, k, side = code[row, 0], code[row, 1], code[row, SIDE]
        if op <= p.SIGNAL:
            top += 1
            put_span(stack, top, operand(op, k, const, low, high, signals))
        elif op == p.CURVE or op == p.BENT:
            put_span(stack, top, table_span(const, k, span_at(stack, top), side))
        elif op < p.ADD:
            put_span(stack, top, of_one(op, side, span_at(stack, top)))
        elif op < p.LESS:
            top -= 1
            put_span(stack, top, of_two(op, side, span_at(stack, top), span_at(stack, top + 1)))
        elif op == p.CHOOSE:
            top -= 2
            put_span(stack, top, choice(span_at(stack, top), span_at(stack, top + 1), span_at(stack, top + 2)))
        else:
            top -= 3
            then, otherwise = span_at(stack, top + 2), span_at(stack, top + 3)
            above, below = (otherwise, then) if op <= p.AT_MOST else (then, otherwise)
            still = then if op == p.AT_MOST or op == p.AT_LEAST else otherwise
            compared = minus(span_at(stack, top), span_at(stack, top + 1))
            put_span(stack, top, switched(side, compared, above, below, still, True))


@compiled
def span_at(stack, n):
    """The span in row n of a stack."""
    return Span(float(stack[n, 0]), float(stack[n, 1]), float(stack[n, 2]), float(stack[n, 3]))


@compiled
def put_span(stack, n, x):
    """Write a span into row n of a stack."""
    stack[n, 0], stack[n, 1], stack[n, 2], stack[n, 3] = x.low, x.high, x.slow, x.fast


@compiled
def operand(op, k, const, low, high, signals):
    """Span of a constant, of time, of a signal; of a state nothing is known."""
    if op == p.CONST:
        return steady(float(const[k]))
    if op == p.TIME:
        return Span(low, high, 1.0, 1.0)
    if op == p.SIGNAL:
        return span_at(signals, k)
    return Span(NAN, NAN, NAN, NAN)


@compiled
def switching_span(const, op, k, stack):
    """Span of the switching function of the switch (op, k) with its operands on the stack; see `bytecode.switching`."""
    x = span_at(stack, 0)
    if op == p.BENT:
        return wave_span(knot_span(const, k, x))
    if op == p.FLOOR:
        return wave_span(x)
    if op < p.ADD:
        return x
    y = span_at(stack, 1)
    return wave_span(over(x, y)) if op == p.MOD else minus(x, y)


# ---------------------------------------------------------------- arithmetic
@compiled
def negative(x):
    """-x."""
    return Span(-x.high, -x.low, -x.fast, -x.slow)


@compiled
def minus(x, y):
    """x - y."""
    return Span(x.low - y.high, x.high - y.low, x.slow - y.fast, x.fast - y.slow)


@compiled
def times(x, y):
    """x y."""
    low, high = product(x.low, x.high, y.low, y.high)
    slow, fast = product(x.slow, x.fast, y.low, y.high)
    down, up = product(x.low, x.high, y.slow, y.fast)
    return Span(low, high, slow + down, fast + up)


@compiled
def over(x, y):
    """x / y."""
    a, b = reciprocal(y.low, y.high)
    low, high = product(x.low, x.high, a, b)
    down, up = product(low, high, y.slow, y.fast)
    slow, fast = product(x.slow - up, x.fast - down, a, b)
    return Span(low, high, slow, fast)


@compiled
def reciprocal(low, high):
    """1 / [low, high]; -inf..inf if zero lies inside."""
    if low <= 0.0 and high >= 0.0:
        return -INF, INF
    return quotient(1.0, high), quotient(1.0, low)


@compiled
def square(low, high):
    """[low, high]**2."""
    a, b = low * low, high * high
    return 0.0 if low <= 0.0 and high >= 0.0 else least(a, b), most(a, b)


@compiled
def next_at(x, first, apart):
    """The first of the numbers first + n apart that is not below x."""
    return -whole(-(x - first) / apart) * apart + first


@compiled
def sine(low, high):
    """Range of sin(x)."""
    a, b = unary(p.SIN, low), unary(p.SIN, high)
    above = 1.0 if next_at(low, 0.25 * TURN, TURN) <= high else most(a, b)
    below = -1.0 if next_at(low, -0.25 * TURN, TURN) <= high else least(a, b)
    return below, above


# ---------------------------------------------------------------- functions
@compiled
def of_one(op, side, x):
    """Span of the function `op` of one operand."""
    if op == p.NEG:
        return negative(x)
    if op == p.ABS:
        return switched(side, x, x, negative(x), x, False)
    if op == p.SIGN:
        return switched(side, x, steady(1.0), steady(-1.0), steady(0.0), True)
    if op == p.STEP:
        return switched(side, x, steady(1.0), steady(0.0), steady(1.0), True)
    if op == p.FLOOR:
        return whole_span(x, side)
    if op == p.SQUARE:
        low, high = square(x.low, x.high)
        return chain(low, high, 2.0 * x.low, 2.0 * x.high, x)
    if op == p.SIN or op == p.COS:
        shift = 0.0 if op == p.SIN else 0.25 * TURN
        low, high = sine(x.low + shift, x.high + shift)
        slope_low, slope_high = sine(x.low + (shift + 0.25 * TURN), x.high + (shift + 0.25 * TURN))
        return chain(low, high, slope_low, slope_high, x)
    if op == p.SQRT or op == p.LOG or op == p.ASIN or op == p.ACOS:
        return bounded(op, x)
    return rising(op, x)


@compiled
def rising(op, x):
    """exp, tan, tanh and atan, which rise wherever they have a value."""
    low, high = unary(op, x.low), unary(op, x.high)
    if op == p.EXP:
        return chain(low, high, low, high, x)
    if op == p.ATAN:
        a, b = square(x.low, x.high)
        return chain(low, high, 1.0 / (1.0 + b), 1.0 / (1.0 + a), x)
    if op == p.TAN and next_at(x.low, 0.25 * TURN, 0.5 * TURN) <= x.high:  # a pole
        low, high = -INF, INF
    a, b = square(low, high)
    return chain(low, high, 1.0 + a, 1.0 + b, x) if op == p.TAN else chain(low, high, 1.0 - b, 1.0 - a, x)


@compiled
def bounded(op, x):
    """A function with a limited domain: sqrt, log, asin, acos."""
    start, end = (0.0, INF) if op == p.SQRT or op == p.LOG else (-1.0, 1.0)
    if x.high < start or x.low > end:
        return Span(NAN, NAN, NAN, NAN)
    low, high = least(most(x.low, start), end), least(most(x.high, start), end)
    a, b = unary(op, low), unary(op, high)
    if op == p.SQRT:
        return chain(a, b, quotient(0.5, b), quotient(0.5, a), x)
    if op == p.LOG:
        return chain(a, b, quotient(1.0, high), quotient(1.0, low), x)
    small, large = square(low, high)
    flat, steep = quotient(1.0, math.sqrt(1.0 - small)), quotient(1.0, math.sqrt(1.0 - large))
    return chain(a, b, flat, steep, x) if op == p.ASIN else chain(b, a, -steep, -flat, x)


@compiled
def of_two(op, side, x, y):
    """Span of the function `op` of two operands."""
    if op == p.ADD:
        return Span(x.low + y.low, x.high + y.high, x.slow + y.slow, x.fast + y.fast)
    if op == p.SUB:
        return minus(x, y)
    if op == p.MUL:
        return times(x, y)
    if op == p.DIV:
        return over(x, y)
    if op == p.POW:
        return to_power(x, y)
    if op == p.ATAN2:
        return angle(x, y)
    if op == p.HYPOT:
        return distance(x, y)
    if op == p.MOD:
        return minus(x, times(y, whole_span(over(x, y), side)))
    return of_compared(op, side, x, y)


@compiled
def of_compared(op, side, x, y):
    """Comparisons, what joins them, min and max."""
    if op == p.BOTH or op == p.EITHER:
        low, high = least(x.low, y.low), least(x.high, y.high)
        if op == p.EITHER:
            low, high = most(x.low, y.low), most(x.high, y.high)
        return Span(low, high, least(x.slow, y.slow), most(x.fast, y.fast))
    s = minus(x, y)
    if op == p.MIN:
        return switched(side, s, y, x, x, False)
    if op == p.MAX:
        return switched(side, s, x, y, x, False)
    above = -1.0 if op <= p.BELOW_OR_AT else 1.0
    still = 1.0 if op == p.BELOW_OR_AT or op == p.ABOVE_OR_AT else -1.0
    return switched(side, s, steady(above), steady(-above), steady(still), True)


@compiled
def distance(x, y):
    """hypot(x, y)."""
    (a, b), (c, d) = square(x.low, x.high), square(y.low, y.high)
    one, two = times(x, x), times(y, y)
    return bounded(p.SQRT, Span(a + c, b + d, one.slow + two.slow, one.fast + two.fast))


@compiled
def to_power(x, y):
    """x ** y."""
    size = abs(y.low)
    if not (y.low == y.high and y.slow == 0.0 and y.fast == 0.0 and size % 1.0 == 0.0 and size <= LARGEST_POWER):
        return rising(p.EXP, times(y, bounded(p.LOG, x)))
    if size == 0.0:
        return steady(1.0)
    around = x.low <= 0.0 and x.high >= 0.0
    even = size % 2.0 == 0.0
    a, b = power(x.low, size), power(x.high, size)
    low, high = 0.0 if even and around else least(a, b), most(a, b)
    a, b = size * power(x.low, size - 1.0), size * power(x.high, size - 1.0)
    slope_low = 0.0 if not even and around and size > 1.0 else least(a, b)
    found = chain(low, high, slope_low, most(a, b), x)
    return found if y.low > 0.0 else over(steady(1.0), found)


@compiled
def angle(y, x):
    """atan2(y, x): the angle jumps where x < 0 and y passes zero."""
    if y.low <= 0.0 and y.high >= 0.0 and x.low <= 0.0:
        return Span(-math.pi, math.pi, -INF, INF)
    a, b = math.atan2(y.low, x.low), math.atan2(y.low, x.high)
    c, d = math.atan2(y.high, x.low), math.atan2(y.high, x.high)
    down, up = product(x.low, x.high, y.slow, y.fast)
    falls, rises = product(y.low, y.high, x.slow, x.fast)
    (e, f), (g, h) = square(x.low, x.high), square(y.low, y.high)
    near, far = reciprocal(e + g, f + h)
    slow, fast = product(down - rises, up - falls, near, far)
    return Span(least(least(a, b), least(c, d)), most(most(a, b), most(c, d)), slow, fast)


# ---------------------------------------------------------------- switches
@compiled
def joined(x, y, leaps):
    """What holds both spans; leaps: True if the value jumps from one to the other."""
    slow = -INF if leaps else least(x.slow, y.slow)
    fast = INF if leaps else most(x.fast, y.fast)
    return Span(least(x.low, y.low), most(x.high, y.high), slow, fast)


@compiled
def choice(condition, yes, no):
    """One of two branches, or both where the condition is not known."""
    if condition.low > 0.0:
        return yes
    return no if condition.high <= 0.0 else joined(yes, no, True)


@compiled
def switched(side, s, above, below, still, leaps):
    """A switch with the switching function s on a side, or both branches if its side is not known.

    above, below, still: spans for s > 0, s < 0 and s = 0.  leaps: True if the value jumps between the first two.
    """
    way = side
    if side == 0:
        way = 1 if s.low > 0.0 else (-1 if s.high < 0.0 else 0)
    if way > 0:
        return above
    if way < 0:
        return below
    if s.low == 0.0 and s.high == 0.0:  # the switching function stays at zero
        return still
    return joined(above, below, leaps)
