"""Interval arithmetic for expressions of time: bounds of a program and of its rate over many spans of time at once.

A `Span` holds bounds of a value and of its time derivative, one per interval [low, high] of time.  The bounds hold for
exact arithmetic; the caller allows for rounding.  nan means that the value is not defined in the interval.

Source: Moore, Kearfott, Cloud, Introduction to Interval Analysis (2009), chapters 2, 5 and 6.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from rattle.language import bytecode as p
from rattle.language.span import Array, Span, wave, whole_numbers
from rattle.language.table_intervals import knot_span, table_span

TURN = 2.0 * math.pi


def enclose(
    code: Array, const: Array, first: int, last: int, low: Array, high: Array, signals: Mapping[int, Span],
    side_of: Callable[[int], Array | None],
) -> list[Span]:  # fmt: skip
    """Bounds of what the program in rows first..last-1 leaves on its stack, over the intervals low..high (n,) [s].

    signals: spans of the signals it uses.  side_of: side of the switch in a row, per interval; None if not known.
    """
    none = np.zeros_like(low)
    stack: list[Span] = []
    for row in range(first, last):
        op, k = int(code[row, 0]), int(code[row, 1])
        if op == p.CONST:
            value = np.full_like(low, const[k])
            stack.append(Span(value, value, none, none))
        elif op == p.TIME:
            stack.append(Span(low, high, none + 1.0, none + 1.0))
        elif op == p.STATE:
            stack.append(_undefined(none))
        elif op == p.SIGNAL:
            stack.append(signals[k])
        elif op in SWITCHES:
            count = SWITCHES[op]
            operands = stack[-count:]
            del stack[-count:]
            if op == p.BENT:
                stack.append(table_span(const, k, operands[0], side_of(row)))
            else:
                stack.append(_switch(op, operands, side_of(row)))
        elif op == p.CURVE:
            stack.append(table_span(const, k, stack.pop(), None))
        elif op < p.ADD:
            stack.append(_unary(op, stack.pop()))
        elif op == p.CHOOSE:
            operands = stack[-3:]
            del stack[-3:]
            stack.append(_choice(*operands))
        else:
            right = stack.pop()
            stack.append(_binary(op, stack.pop(), right))
    return stack


SWITCHES = {
    p.ABS: 1, p.SIGN: 1, p.STEP: 1, p.MIN: 2, p.MAX: 2, p.LESS: 4, p.AT_MOST: 4, p.MORE: 4, p.AT_LEAST: 4,
    p.BELOW: 2, p.BELOW_OR_AT: 2, p.ABOVE: 2, p.ABOVE_OR_AT: 2, p.FLOOR: 1, p.MOD: 2,
    p.BENT: 1,
}  # fmt: skip
COMPARISONS = (p.BELOW, p.BELOW_OR_AT, p.ABOVE, p.ABOVE_OR_AT)


def minus(x: Span, y: Span) -> Span:
    """x - y."""
    return Span(x.low - y.high, x.high - y.low, x.slow - y.fast, x.fast - y.slow)


def _undefined(like: Array) -> Span:
    nothing = np.full_like(like, math.nan)
    return Span(nothing, nothing, nothing, nothing)


def _product(a: Array, b: Array, c: Array, d: Array) -> tuple[Array, Array]:
    """[a, b] * [c, d]; zero times infinity is zero, because an infinite bound is never reached."""
    with np.errstate(invalid="ignore", over="ignore"):
        every = np.array([a * c, a * d, b * c, b * d])
    unknown = np.isnan(a + 0.0) | np.isnan(b) | np.isnan(c) | np.isnan(d)
    every = np.where(np.isnan(every), 0.0, every)
    low, high = every.min(axis=0), every.max(axis=0)
    return np.where(unknown, math.nan, low), np.where(unknown, math.nan, high)


def _times(x: Span, y: Span) -> Span:
    low, high = _product(x.low, x.high, y.low, y.high)
    one, two = _product(x.slow, x.fast, y.low, y.high), _product(x.low, x.high, y.slow, y.fast)
    return Span(low, high, one[0] + two[0], one[1] + two[1])


def _chain(low: Array, high: Array, least: Array, most: Array, x: Span) -> Span:
    """Chain rule: a function of x with values low..high and derivative least..most."""
    return Span(low, high, *_product(least, most, x.slow, x.fast))


def _square(low: Array, high: Array) -> tuple[Array, Array]:
    one, two = low * low, high * high
    return np.where((low <= 0.0) & (high >= 0.0), 0.0, np.minimum(one, two)), np.maximum(one, two)


def _sine(low: Array, high: Array, shift: float = 0.0) -> tuple[Array, Array]:
    """Range of sin(x + shift)."""
    one, two = np.sin(low + shift), np.sin(high + shift)
    top = np.ceil((low + shift - 0.25 * TURN) / TURN) * TURN + 0.25 * TURN
    bottom = np.ceil((low + shift + 0.25 * TURN) / TURN) * TURN - 0.25 * TURN
    most = np.where(top <= high + shift, 1.0, np.maximum(one, two))
    least = np.where(bottom <= high + shift, -1.0, np.minimum(one, two))
    return least, most


def _reciprocal(low: Array, high: Array) -> tuple[Array, Array]:
    """1 / [low, high]; -inf..inf if zero lies inside."""
    inside = (low <= 0.0) & (high >= 0.0)
    return np.where(inside, -math.inf, 1.0 / high), np.where(inside, math.inf, 1.0 / low)


def _unary(op: int, x: Span) -> Span:
    """A smooth function of one operand."""
    low, high = x.low, x.high
    if op == p.NEG:
        return Span(-high, -low, -x.fast, -x.slow)
    if op == p.SQUARE:
        return _chain(*_square(low, high), 2.0 * low, 2.0 * high, x)
    if op == p.EXP:
        one, two = np.exp(low), np.exp(high)
        return _chain(one, two, one, two, x)
    if op in (p.SIN, p.COS):
        shift = 0.0 if op == p.SIN else 0.25 * TURN
        return _chain(*_sine(low, high, shift), *_sine(low, high, shift + 0.25 * TURN), x)
    if op == p.TAN:
        pole = np.ceil((low - 0.25 * TURN) / (0.5 * TURN)) * 0.5 * TURN + 0.25 * TURN <= high
        one, two = np.where(pole, -math.inf, np.tan(low)), np.where(pole, math.inf, np.tan(high))
        least, most = _square(one, two)
        return _chain(one, two, 1.0 + least, 1.0 + most, x)
    if op == p.TANH:
        one, two = np.tanh(low), np.tanh(high)
        least, most = _square(one, two)
        return _chain(one, two, 1.0 - most, 1.0 - least, x)
    if op == p.ATAN:
        least, most = _square(low, high)
        return _chain(np.arctan(low), np.arctan(high), 1.0 / (1.0 + most), 1.0 / (1.0 + least), x)
    return _bounded(op, x)


def _bounded(op: int, x: Span) -> Span:
    """A function with a limited domain: sqrt, log, asin, acos."""
    least, most = (0.0, math.inf) if op in (p.SQRT, p.LOG) else (-1.0, 1.0)
    outside = (x.high < least) | (x.low > most)
    low, high = np.clip(x.low, least, most), np.clip(x.high, least, most)
    low, high = np.where(outside, math.nan, low), np.where(outside, math.nan, high)
    if op == p.SQRT:
        return _chain(np.sqrt(low), np.sqrt(high), 0.5 / np.sqrt(high), 0.5 / np.sqrt(low), x)
    if op == p.LOG:
        return _chain(np.log(low), np.log(high), 1.0 / high, 1.0 / low, x)
    small, large = _square(low, high)
    slope = 1.0 / np.sqrt(1.0 - small), 1.0 / np.sqrt(1.0 - large)
    if op == p.ASIN:
        return _chain(np.arcsin(low), np.arcsin(high), *slope, x)
    return _chain(np.arccos(high), np.arccos(low), -slope[1], -slope[0], x)


def _binary(op: int, x: Span, y: Span) -> Span:
    """A smooth function of two operands."""
    if op == p.ADD:
        return Span(x.low + y.low, x.high + y.high, x.slow + y.slow, x.fast + y.fast)
    if op == p.SUB:
        return minus(x, y)
    if op == p.MUL:
        return _times(x, y)
    if op == p.DIV:
        return _quotient(x, y)
    if op == p.POW:
        return _power(x, y)
    if op in (p.BOTH, p.EITHER):
        least = np.minimum if op == p.BOTH else np.maximum
        slow, fast = np.minimum(x.slow, y.slow), np.maximum(x.fast, y.fast)
        return Span(least(x.low, y.low), least(x.high, y.high), slow, fast)
    if op == p.ATAN2:
        return _angle(x, y)
    squares = Span(*_square(x.low, x.high), *_times(x, x)[2:]), Span(*_square(y.low, y.high), *_times(y, y)[2:])
    return _unary(p.SQRT, Span(*(one + two for one, two in zip(*squares, strict=True))))


def _quotient(x: Span, y: Span) -> Span:
    inverse = _reciprocal(y.low, y.high)
    low, high = _product(x.low, x.high, *inverse)
    down, up = _product(low, high, y.slow, y.fast)
    return Span(low, high, *_product(x.slow - up, x.fast - down, *inverse))


def _power(x: Span, y: Span) -> Span:
    exponent = float(y.low[0]) if len(y.low) else 0.0
    if not (y.low == exponent).all() or not (y.high == exponent).all() or exponent % 1.0 or abs(exponent) > 100.0:
        return _unary(p.EXP, _times(y, _unary(p.LOG, x)))
    result = Span(np.ones_like(x.low), np.ones_like(x.low), np.zeros_like(x.low), np.zeros_like(x.low))
    n = int(abs(exponent))
    if n:
        one, two = x.low**n, x.high**n
        low, high = np.minimum(one, two), np.maximum(one, two)
        if n % 2 == 0:
            low = np.where((x.low <= 0.0) & (x.high >= 0.0), 0.0, low)
        slopes = n * x.low ** (n - 1), n * x.high ** (n - 1)
        least, most = np.minimum(*slopes), np.maximum(*slopes)
        if n % 2:
            least = np.where((x.low <= 0.0) & (x.high >= 0.0) & (n > 1), 0.0, least)
        result = _chain(low, high, least, most, x)
    one_over = Span(*np.ones((2, len(x.low))), *np.zeros((2, len(x.low))))
    return result if exponent >= 0 else _quotient(one_over, result)


def _angle(y: Span, x: Span) -> Span:
    """atan2(y, x): the angle jumps where x < 0 and y passes zero."""
    cut = (y.low <= 0.0) & (y.high >= 0.0) & (x.low <= 0.0)
    corners = np.array([np.arctan2(a, b) for a in (y.low, y.high) for b in (x.low, x.high)])
    one, two = _times(Span(*x[:2], *x[:2]), y), _times(Span(*y[:2], *y[:2]), x)
    left = _product(x.low, x.high, y.slow, y.fast)
    right = _product(y.low, y.high, x.slow, x.fast)
    size = Span(*_square(x.low, x.high), *one[2:]), Span(*_square(y.low, y.high), *two[2:])
    rate = _product(
        left[0] - right[1], left[1] - right[0], *_reciprocal(size[0].low + size[1].low, size[0].high + size[1].high)
    )
    return Span(
        np.where(cut, -math.pi, corners.min(axis=0)), np.where(cut, math.pi, corners.max(axis=0)),
        np.where(cut, -math.inf, rate[0]), np.where(cut, math.inf, rate[1]),
    )  # fmt: skip


# ---------------------------------------------------------------- switches
def switching_function(const: Array, op: int, k: int, operands: list[Span]) -> Span:
    """The switching function of the switch (op, k) of a program, see `language.bytecode`."""
    return wave(knot_span(const, k, operands[0])) if op == p.BENT else argument(op, operands)


def argument(op: int, operands: list[Span]) -> Span:
    """The switching function of a switch that is no table, see `bytecode.switching`."""
    if op in (p.FLOOR, p.MOD):
        return wave(_counted(op, operands))
    return operands[0] if SWITCHES[op] == 1 else minus(operands[0], operands[1])


def _counted(op: int, operands: list[Span]) -> Span:
    """What floor and mod count integers of."""
    return operands[0] if op == p.FLOOR else _quotient(operands[0], operands[1])


def _choice(condition: Span, yes: Span, no: Span) -> Span:
    """One of two branches, or their union where the condition is not known."""
    both = Span(
        np.minimum(yes.low, no.low), np.maximum(yes.high, no.high),
        np.full_like(yes.low, -math.inf), np.full_like(yes.low, math.inf),
    )  # fmt: skip
    holds, fails = condition.low > 0.0, condition.high <= 0.0
    return Span(*(np.where(holds, a, np.where(fails, b, c)) for a, b, c in zip(yes, no, both, strict=True)))


def _switch(op: int, operands: list[Span], side: Array | None) -> Span:
    """A switch on a known side, or the union of both branches if the side is not known."""
    if op in (p.FLOOR, p.MOD):
        whole = whole_numbers(_counted(op, operands), side)
        return whole if op == p.FLOOR else minus(operands[0], _times(operands[1], whole))
    s = argument(op, operands)
    way = np.where(s.low > 0.0, 1.0, 0.0) - np.where(s.high < 0.0, 1.0, 0.0)
    if side is not None:
        way = np.where(side != 0.0, side, way)
    above, below, leaps = _branches(op, operands)
    still = (s.low == 0.0) & (s.high == 0.0) & (way == 0.0)  # the switching function stays at zero
    both = Span(
        np.minimum(above.low, below.low), np.maximum(above.high, below.high),
        np.where(leaps, -math.inf, np.minimum(above.slow, below.slow)),
        np.where(leaps, math.inf, np.maximum(above.fast, below.fast)),
    )  # fmt: skip
    at_zero = _at_zero(op, operands, above, below)
    return Span(
        *(
            np.where(way > 0.0, a, np.where(way < 0.0, b, np.where(still, z, c)))
            for a, b, c, z in zip(above, below, both, at_zero, strict=True)
        )
    )


def _branches(op: int, operands: list[Span]) -> tuple[Span, Span, bool]:
    """Spans of a switch for s > 0 and for s < 0, and whether its value jumps between them."""
    x = operands[0]
    zero = np.zeros_like(x.low)
    if op == p.ABS:
        return x, _unary(p.NEG, x), False
    if op in (p.SIGN, p.STEP):
        below = zero - 1.0 if op == p.SIGN else zero
        return Span(zero + 1.0, zero + 1.0, zero, zero), Span(below, below, zero, zero), True
    if op in COMPARISONS:
        holds, fails = Span(zero + 1.0, zero + 1.0, zero, zero), Span(zero - 1.0, zero - 1.0, zero, zero)
        return (fails, holds, True) if op <= p.BELOW_OR_AT else (holds, fails, True)
    if op in (p.MIN, p.MAX):
        return (operands[1], x, False) if op == p.MIN else (x, operands[1], False)
    then, otherwise = operands[2], operands[3]
    return (otherwise, then, True) if op <= p.AT_MOST else (then, otherwise, True)


def _at_zero(op: int, operands: list[Span], above: Span, below: Span) -> Span:
    """Span of a switch while s = 0."""
    if op == p.SIGN:
        zero = np.zeros_like(above.low)
        return Span(zero, zero, zero, zero)
    if op == p.STEP:
        return above
    if op in (p.ABS, p.MIN, p.MAX):
        return operands[0]
    if op in COMPARISONS:
        holds = np.ones_like(above.low) if op in (p.BELOW_OR_AT, p.ABOVE_OR_AT) else -np.ones_like(above.low)
        return Span(holds, holds, 0.0 * holds, 0.0 * holds)
    return operands[2] if op in (p.AT_MOST, p.AT_LEAST) else operands[3]
