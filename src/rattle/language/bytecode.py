"""Expressions at run time: small stack programs and the loop that executes them.

A program is an integer array with rows (op, argument, side, crossed).  An op takes its operands from the top of the
stack and leaves its result there.  A choice takes four operands (the two compared, then, otherwise), so that
there are no jumps; CHOOSE takes three (condition, then, otherwise).  A condition is a number: positive where it holds.
Outside its domain a function gives nan or inf and never raises: the guards below give what
C would give, and keep plain Python from raising.  All values are in SI units.

Switches (abs, sign, step, min, max, if, comparisons, floor, mod, tables with kinks) have a switching function s: their
operand, or the difference of the two operands that are compared; of floor(x), and of mod(x, y) with x/y, the distance
from the nearest integer, positive after even integers and negative after odd ones (`wave`), and of a table the same of
its knot coordinate.  A side of +1 or -1 in the program selects the branch for s > 0 or s < 0 whatever the value of s,
so that the right-hand side is smooth between two switching instants; `crossed` is set to 1 when s has the other sign.
With side 0 the value of s decides: at s = 0 values are those of the definition (sign(0) = 0, step(0) = 1).  A branch
without a finite value at s = 0 is not taken there, so that "sin(t)/t if t > 0 else 1" is allowed.

`language.jets` runs the same programs on values with their time derivatives.
"""

from __future__ import annotations

import math

from rattle.jit.choices import select
from rattle.jit.functions import compiled, native
from rattle.language.table_reading import knot_coordinate, on_segment

# operands, then functions of one operand, of two, and choices: the loops rely on this order
CONST, TIME, STATE, SIGNAL = range(4)
NEG, SQUARE, ABS, SIGN, STEP, FLOOR, SQRT, EXP, LOG, SIN, COS, TAN, ASIN, ACOS, ATAN, TANH = range(4, 20)
CURVE, BENT = range(20, 22)  # tables, without and with kinks; their argument is the place of their block in `const`
ADD, SUB, MUL, DIV, POW, ATAN2, HYPOT, MOD = range(22, 30)
BELOW, BELOW_OR_AT, ABOVE, ABOVE_OR_AT, BOTH, EITHER, MIN, MAX = range(30, 38)
LESS, AT_MOST, MORE, AT_LEAST, CHOOSE = range(38, 43)
COMPARED = LESS - BELOW  # from a comparison to the choice by it

SIDE, CROSSED = 2, 3  # columns of a program

NAN = math.nan
INF = math.inf
LARGEST = 709.78  # exp of more than this is inf
WHOLE = 2.0**52  # numbers of this size and beyond have no fraction


def operands_of(op: int) -> int:
    """Number of operands of an operation."""
    if op <= SIGNAL:
        return 0
    if op < ADD:
        return 1
    return 2 if op < LESS else (3 if op == CHOOSE else 4)


@compiled
def quotient(x, y):
    """x / y [SI]; inf or nan for y = 0."""
    if y != 0.0:
        return x / y
    if x == 0.0 or x != x:
        return NAN
    return math.copysign(INF, x) * math.copysign(1.0, y)


@compiled
def power(x, y):
    """x ** y [SI]; nan for a negative x with an exponent that is not an integer."""
    if y == 0.0 or x == 1.0:
        return 1.0
    if x != x or y != y:
        return NAN
    size = abs(x)
    if size == 0.0:
        result = 0.0 if y > 0.0 else INF
    else:
        exponent = y * math.log(size)
        if exponent > LARGEST:
            result = INF
        elif exponent != exponent:
            result = 1.0
        elif exponent == -INF or abs(y) == INF or size == INF:
            result = 0.0
        else:
            result = math.pow(size, y)
    if x < 0.0 and abs(y) < INF:
        if y % 1.0 != 0.0:
            return NAN
        if y % 2.0 != 0.0:
            return -result
    return result


@compiled
def whole(x):
    """Largest integer that is not above x."""
    return float(math.floor(x)) if abs(x) < WHOLE else x


@compiled
def wave(x):
    """Distance of x from the nearest integer, positive from an even integer to the next, negative from an odd one."""
    nearest = whole(x + 0.5)
    return x - nearest if nearest % 2.0 == 0.0 else nearest - x


@compiled
def held(side, x):
    """Largest integer not above x, where `wave` of x has this sign, or had it less than half ago."""
    n = whole(x)
    if (n % 2.0 == 0.0) == (side > 0):
        return n
    return n - 1.0 if x - n < 0.5 else n + 1.0


@compiled
def read_table(table, k, side, x, dx, ddx):
    """Value and first and second derivative at x of the table whose block begins at table[k]; see `language.tables`.

    side: as of any switch.  dx, ddx: rates of x, which decide at a knot if there is no side.
    """
    z = knot_coordinate(table, k, x)
    if z != z:
        return NAN, NAN, NAN
    segment = whole(z) if side == 0 else held(side, z)
    if side == 0 and segment == z and (dx < 0.0 or (dx == 0.0 and ddx < 0.0)):
        segment -= 1.0
    return on_segment(table, k, segment, x)


@compiled
def switching(op, x, y):
    """Switching function of the switch `op`; y is 0 for one operand."""
    if op == FLOOR:
        return wave(x)
    if op == MOD:
        return wave(quotient(x, y))
    return x - y


@compiled
def unary(op, x):
    """Value of the function `op` of one operand [SI]."""
    if op == NEG:
        return -x
    if op == SQUARE:
        return x * x
    if op == ABS:
        return abs(x)
    if op == SIGN:
        return 1.0 if x > 0.0 else (-1.0 if x < 0.0 else x)
    if op == STEP:
        return 1.0 if x >= 0.0 else (0.0 if x < 0.0 else x)
    if op == FLOOR:
        return whole(x)
    if op == SQRT:
        return math.sqrt(x) if x >= 0.0 else NAN
    if op == EXP:
        return INF if x > LARGEST else math.exp(x)
    if op == LOG:
        return math.log(x) if x > 0.0 else (-INF if x == 0.0 else NAN)
    if op == ATAN:
        return math.atan(x)
    if op == TANH:
        return math.tanh(x)
    if op == ASIN:
        return math.asin(x) if -1.0 <= x <= 1.0 else NAN
    if op == ACOS:
        return math.acos(x) if -1.0 <= x <= 1.0 else NAN
    if not abs(x) < INF:
        return NAN
    if op == SIN:
        return math.sin(x)
    if op == COS:
        return math.cos(x)
    return math.tan(x)


@compiled
def binary(op, x, y):
    """Value of the function `op` of two operands [SI]."""
    if op == ADD:
        return x + y
    if op == SUB:
        return x - y
    if op == MUL:
        return x * y
    if op == DIV:
        return quotient(x, y)
    if op == POW:
        return power(x, y)
    if op == ATAN2:
        return math.atan2(x, y)
    if op == HYPOT:
        return math.hypot(x, y)
    if op == MOD:
        return x - y * whole(quotient(x, y))
    if op <= ABOVE_OR_AT:
        return 1.0 if holds(op + COMPARED, x, y) else -1.0
    if op in (BOTH, MIN):
        return x if x <= y or x != x else y
    return x if x >= y or x != x else y


@compiled
def holds(op, x, y):
    """True if the comparison of the choice `op` between x and y holds."""
    if op == LESS:
        return x < y
    if op == AT_MOST:
        return x <= y
    if op == MORE:
        return x > y
    return x >= y


@compiled
def branch(op, side, x, y):
    """Value [SI] of a switch on a given side of its switching function; those of one operand do not use y.

    A comparison is 1 where it holds and -1 where not; half as large at s = 0, where it could be otherwise.
    """
    if op == ABS:
        return x if side > 0 else -x
    if op == FLOOR:
        return held(side, x)
    if op == MOD:
        return x - y * held(side, quotient(x, y))
    if BELOW <= op <= ABOVE_OR_AT:
        sure = 0.5 if x == y else 1.0
        return sure if (side < 0) == (op <= BELOW_OR_AT) else -sure
    if op == MIN:
        return y if side > 0 else x
    if op == MAX:
        return x if side > 0 else y
    if x != x:
        return x
    if op == SIGN:
        return 1.0 if side > 0 else -1.0
    return 1.0 if side > 0 else 0.0


@compiled
def chosen(condition, yes, no):
    """Value [SI] of a choice; where the condition could be otherwise, a branch without a finite value is not taken."""
    value = yes if condition > 0.0 else no
    if abs(condition) < 1.0 and not abs(value) < INF:
        value = no if condition > 0.0 else yes
    return value


@native("f", "n", "v", "i", "i", "f", "m", "v", "v")
def evaluate(code, const, first, last, t, body, signals, stack):
    """Value [SI] of the program in rows first..last-1 of `code` (n, 4); marks the switches that were crossed in `code`.

    const: (nc,) constants of all programs [SI]; t: time [s]; body: (nb+1, 8) state [SI], the argument k of STATE means
    body[k >> 3, k & 7]; signals: (ns,) values [SI]; stack: scratch, at least as long as the program's depth.
    """
    top = -1
    for row in range(first, last):
        op = code[row, 0]
        k = code[row, 1]
        if op == CONST:
            top += 1
            stack[top] = const[k]
        elif op == STATE:
            top += 1
            stack[top] = body[k >> 3, k & 7]
        elif op == TIME:
            top += 1
            stack[top] = t
        elif op == SIGNAL:
            top += 1
            stack[top] = signals[k]
        elif op in (CURVE, BENT):
            x = float(stack[top])
            side = code[row, SIDE]
            value, _, _ = read_table(const, k, side, x, 0.0, 0.0)
            stack[top] = value
            if side != 0 and wave(knot_coordinate(const, k, x)) * side < 0.0:
                code[row, CROSSED] = 1
        elif op < ADD:
            x = float(stack[top])
            side = code[row, SIDE]
            if side == 0:
                stack[top] = unary(op, x)
            else:
                stack[top] = branch(op, side, x, 0.0)
                if switching(op, x, 0.0) * side < 0.0:
                    code[row, CROSSED] = 1
        elif op < LESS:
            top -= 1
            x = float(stack[top])
            y = float(stack[top + 1])
            side = code[row, SIDE]
            if side == 0:
                stack[top] = binary(op, x, y)
            else:
                stack[top] = branch(op, side, x, y)
                if switching(op, x, y) * side < 0.0:
                    code[row, CROSSED] = 1
        elif op == CHOOSE:
            top -= 2
            stack[top] = chosen(stack[top], stack[top + 1], stack[top + 2])
        else:
            top -= 3
            side = code[row, SIDE]
            value = select(holds(op, stack[top], stack[top + 1]), stack[top + 2], stack[top + 3])
            if side != 0:
                s = stack[top] - stack[top + 1]
                far = top + 2 if (side < 0) == (op <= AT_MOST) else top + 3
                if s != 0.0 or abs(stack[far]) < INF:
                    value = stack[far]
                if s * side < 0.0:
                    code[row, CROSSED] = 1
            stack[top] = value
    return float(stack[0])
