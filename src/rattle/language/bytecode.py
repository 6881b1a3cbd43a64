"""Expressions at run time: small stack programs and the loop that executes them.

A program is an integer array with rows (op, argument, side, crossed).  An op takes its operands from the top of the
stack and leaves its result there.  A choice takes four operands (the two compared, then, otherwise), so that
there are no jumps; CHOOSE takes three (condition, then, otherwise).  A condition is a number: positive where it holds.
Outside its domain a function gives nan or inf and never raises.  All values are in SI units.  What an operation does
stands in its record, see `operation`; the functions that choose by its code are made of the records.

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

from rattle.jit.choices import select
from rattle.jit.functions import compiled, native
from rattle.language import operations
from rattle.language.arithmetic import INF, NAN, held
from rattle.language.arithmetic import power as power
from rattle.language.arithmetic import quotient as quotient
from rattle.language.arithmetic import wave as wave
from rattle.language.arithmetic import whole as whole
from rattle.language.operation import dispatch
from rattle.language.table_reading import knot_coordinate, on_segment

# operands, then operations of one operand, of two, and choices: the loops rely on this order
CONST, TIME, STATE, SIGNAL = range(4)
ONE = dict(enumerate(operations.OF_ONE, SIGNAL + 1))  # records by code
CURVE = SIGNAL + 1 + len(ONE)  # tables, without and with kinks; their argument is the place of their block in `const`
BENT = CURVE + 1
TWO = dict(enumerate(operations.OF_TWO, BENT + 1))
FIRST_OF_TWO, LESS = BENT + 1, BENT + 1 + len(TWO)
AT_MOST, MORE, AT_LEAST, CHOOSE = range(LESS + 1, LESS + 5)
RECORDS = {**ONE, **TWO}
CODE = {  # by the name of an operation in a tree
    **{record.name: code for code, record in RECORDS.items()},
    **dict(zip((*operations.CHOICES, operations.CHOOSE), range(LESS, CHOOSE + 1), strict=True)),
}
CODE["not"] = CODE["neg"]
SQUARE, POW, HYPOT, SQRT = CODE["square"], CODE["**"], CODE["hypot"], CODE["sqrt"]
SIN, COS, ACOS, LOG = CODE["sin"], CODE["cos"], CODE["acos"], CODE["log"]
FLOOR, MOD, MIN, MAX = CODE["floor"], CODE["mod"], CODE["min"], CODE["max"]
ADD, MUL = CODE["+"], CODE["*"]
BRANCHES = {code: record.branches for code, record in RECORDS.items() if record.branches is not None}
SWITCHES = frozenset((*BRANCHES, BENT, *range(LESS, CHOOSE)))
JUMPS = SWITCHES | {CODE["and"], CODE["or"], CHOOSE}  # of these values or derivatives may jump

SIDE, CROSSED = 2, 3  # columns of a program


def operands_of(op: int) -> int:
    """Number of operands of an operation."""
    if op <= SIGNAL:
        return 0
    if op < FIRST_OF_TWO:
        return 1
    return 2 if op < LESS else (3 if op == CHOOSE else 4)


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


# switching function of the switch `op` of x and y; y is 0 for one operand
switching = dispatch(
    __name__, "switching", "x, y", {
        code: (f"return switching({'x' if code in ONE else 'x, y'})", {"switching": sides.switching})
        for code, sides in BRANCHES.items() if sides.switching is not None
    }, "return x - y",
)  # fmt: skip
# value of the function `op` of one operand [SI], and of two
unary = dispatch(
    __name__, "unary", "x", {code: ("return value(x)", {"value": record.value}) for code, record in ONE.items()}
)
binary = dispatch(
    __name__, "binary", "x, y", {code: ("return value(x, y)", {"value": record.value}) for code, record in TWO.items()}
)
# value [SI] of a switch on a given side of its switching function; those of one operand do not use y
branch = dispatch(
    __name__, "branch", "side, x, y", {
        code: (f"return value({'side, x' if code in ONE else 'side, x, y'})", {"value": sides.value})
        for code, sides in BRANCHES.items()
    },
)  # fmt: skip


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
def chosen(condition, yes, no):
    """Value [SI] of a choice; where the condition could be otherwise, a branch without a finite value is not taken."""
    value = yes if condition > 0.0 else no
    if abs(condition) < 1.0 and not abs(value) < INF:
        value = no if condition > 0.0 else yes
    return value


@compiled
def run_one(code, row, x):
    """Value of the operation of one operand in a row of a program."""
    op, side = code[row, 0], code[row, SIDE]
    if side == 0:
        return unary(op, x)
    if switching(op, x, 0.0) * side < 0.0:
        code[row, CROSSED] = 1
    return branch(op, side, x, 0.0)


@compiled
def run_two(code, row, x, y):
    """Value of the operation of two operands in a row of a program."""
    op, side = code[row, 0], code[row, SIDE]
    if side == 0:
        return binary(op, x, y)
    if switching(op, x, y) * side < 0.0:
        code[row, CROSSED] = 1
    return branch(op, side, x, y)


@compiled
def run_table(code, row, const, x):
    """Value at x of the table in a row of a program."""
    k, side = code[row, 1], code[row, SIDE]
    value, _, _ = read_table(const, k, side, x, 0.0, 0.0)
    if side != 0 and wave(knot_coordinate(const, k, x)) * side < 0.0:
        code[row, CROSSED] = 1
    return value


@compiled
def run_choice(code, row, stack, top):
    """Value of the choice in a row of a program, between the last two of the four numbers at `top` of the stack."""
    op, side = code[row, 0], code[row, SIDE]
    value = select(holds(op, stack[top], stack[top + 1]), stack[top + 2], stack[top + 3])
    if side != 0:
        s = stack[top] - stack[top + 1]
        far = top + 2 if (side < 0) == (op <= AT_MOST) else top + 3
        if s != 0.0 or abs(stack[far]) < INF:
            value = stack[far]
        if s * side < 0.0:
            code[row, CROSSED] = 1
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
            stack[top] = run_table(code, row, const, float(stack[top]))
        elif op < FIRST_OF_TWO:
            stack[top] = run_one(code, row, float(stack[top]))
        elif op < LESS:
            top -= 1
            stack[top] = run_two(code, row, float(stack[top]), float(stack[top + 1]))
        elif op == CHOOSE:
            top -= 2
            stack[top] = chosen(stack[top], stack[top + 1], stack[top + 2])
        else:
            top -= 3
            stack[top] = run_choice(code, row, stack, top)
    return float(stack[0])
