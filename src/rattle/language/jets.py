"""Jets: the programs of `language.bytecode` run on values with their first and second time derivative.

For z = f(x):

    dz  = f' dx
    ddz = f'' dx**2 + f' ddx

At a switch with side 0 and s = 0 the derivatives are one-sided, those of the side that s enters next.

Source: Griewank and Walther, Evaluating Derivatives, 2nd ed. (2008), ch. 13 (Taylor arithmetic).
"""

from __future__ import annotations

from rattle.jit.choices import select
from rattle.jit.functions import compiled
from rattle.language.arithmetic import INF, NAN, heading
from rattle.language.bytecode import (
    AT_MOST,
    BENT,
    CHOOSE,
    CONST,
    CURVE,
    FIRST_OF_TWO,
    LESS,
    ONE,
    SIDE,
    SIGNAL,
    STATE,
    TIME,
    TWO,
    branch,
    holds,
    read_table,
    unary,
)
from rattle.language.operation import dispatch


def _rates(record):
    """What gives an operation of two operands with its rates; those of one that jumps are zero on both sides."""
    if record.jet is not None:
        return "return jet(side, x, dx, ddx, y, dy, ddy)", {"jet": record.jet}
    if record.branches is None:
        text = "z = value(x, y)\ndz, ddz = rates(x, dx, ddx, y, dy, ddy, z)\nreturn z, dz, ddz"
        return text, {"value": record.value, "rates": record.rates}
    text = "if side == 0:\n    side = heading(x - y, dx - dy, ddx - ddy)\n"
    text += "return (value(x, y) if side == 0 else branch(side, x, y)), 0.0, 0.0"
    return text, {"heading": heading, "value": record.value, "branch": record.branches.value}


# first and second derivative of the function `op` at x [SI], where its value is f
slopes = dispatch(
    __name__, "slopes", "x, f", {
        code: ("f1 = slope(x, f)\nreturn f1, bend(x, f, f1)", {"slope": record.slope, "bend": record.bend})
        for code, record in ONE.items()
    },
)  # fmt: skip
# first derivative on a side of a switch of one operand
BENDS = {code: record.branches.slope for code, record in ONE.items() if record.branches and record.branches.slope}
HEADED = tuple(BENDS)  # at s = 0 their derivatives are those of the side that s enters next
slope_on = dispatch(
    __name__, "slope_on", "side", {code: ("return slope(side)", {"slope": slope}) for code, slope in BENDS.items()},
    "return 0.0",
)  # fmt: skip
# a function of two operands in jet arithmetic: value, first and second time derivative [SI, 1/s, 1/s^2]
binary_jet = dispatch(
    __name__, "binary_jet", "side, x, dx, ddx, y, dy, ddy", {code: _rates(record) for code, record in TWO.items()}
)


@compiled
def unary_jet(op, side, x, dx, ddx):
    """A function of one operand in jet arithmetic: value, first and second time derivative [SI, 1/s, 1/s^2]."""
    if op in HEADED and side == 0:
        side = heading(x, dx, ddx)
    if side == 0:
        f = unary(op, x)
        f1, f2 = slopes(op, x, f)
    else:
        f = branch(op, side, x, 0.0)
        f1, f2 = slope_on(op, side), 0.0
    return f, f1 * dx, f2 * dx * dx + f1 * ddx


@compiled
def put_jet(stack, top, z, dz, ddz):
    """Write a value and its derivatives to place `top` of a stack."""
    stack[top] = z
    stack[top + 1] = dz
    stack[top + 2] = ddz


@compiled
def choose_jet(stack, top):
    """A choice by the condition at place `top` of the stack between the two jets after it; see `bytecode.chosen`."""
    yes, no = top + 3, top + 6
    condition = stack[top] > 0.0
    if abs(stack[top]) < 1.0:
        taken = yes if condition else no
        if not abs(stack[taken]) + abs(stack[taken + 1]) + abs(stack[taken + 2]) < INF:
            condition = not condition
    for n in range(3):
        stack[top + n] = select(condition, stack[yes + n], stack[no + n])


@compiled
def compare_jet(op, side, stack, top):
    """A choice by the first two of four jets at place `top` of the stack between the other two."""
    s = float(stack[top]) - float(stack[top + 3])
    if side == 0:
        side = heading(
            s,
            float(stack[top + 1]) - float(stack[top + 4]),
            float(stack[top + 2]) - float(stack[top + 5]),
        )
    taken, condition = -1, holds(op, stack[top], stack[top + 3])
    if side != 0:
        taken = top + 6 if (side < 0) == (op <= AT_MOST) else top + 9
        if s == 0.0 and not abs(stack[taken]) + abs(stack[taken + 1]) + abs(stack[taken + 2]) < INF:
            taken = -1
    for n in range(3):
        if taken >= 0:
            stack[top + n] = stack[taken + n]
        else:
            stack[top + n] = select(condition, stack[top + 6 + n], stack[top + 9 + n])


@compiled
def operate_jet(op, side, table, k, stack, top):
    """Operation `op` on the last jets of a stack, three numbers each, of which the last begins at `top`.

    table, k: block of numbers of a table, and where it begins.  Returns the place of the result.
    """
    if op in (CURVE, BENT):
        x, dx, ddx = float(stack[top]), float(stack[top + 1]), float(stack[top + 2])
        f, f1, f2 = read_table(table, k, side, x, dx, ddx)
        put_jet(stack, top, f, f1 * dx, f2 * dx * dx + f1 * ddx)
    elif op < FIRST_OF_TWO:
        z, dz, ddz = unary_jet(op, side, float(stack[top]), float(stack[top + 1]), float(stack[top + 2]))
        put_jet(stack, top, z, dz, ddz)
    elif op < LESS:
        top -= 3
        z, dz, ddz = binary_jet(
            op,
            side,
            float(stack[top]),
            float(stack[top + 1]),
            float(stack[top + 2]),
            float(stack[top + 3]),
            float(stack[top + 4]),
            float(stack[top + 5]),
        )
        put_jet(stack, top, z, dz, ddz)
    elif op == CHOOSE:
        top -= 6
        choose_jet(stack, top)
    else:
        top -= 9
        compare_jet(op, side, stack, top)
    return top


@compiled
def run_jet(code, row, const, stack, top):
    """The operation in a row of a program on the last jets of a stack, see `operate_jet`."""
    return operate_jet(code[row, 0], code[row, SIDE], const, code[row, 1], stack, top)


@compiled
def evaluate_jet(code, const, first, last, t, jets, stack, out):
    """Value, first and second time derivative [SI] of the program in rows first..last-1 at time t [s], into out (3,).

    jets: (ns, 3) signals with their time derivatives [SI]; stack: (3 depth,) scratch.  A program that uses the state
    gives nan.
    """
    top = -3
    for row in range(first, last):
        op = code[row, 0]
        k = code[row, 1]
        if op <= STATE:
            top += 3
            stack[top] = const[k] if op == CONST else (t if op == TIME else NAN)
            stack[top + 1] = NAN if op == STATE else (1.0 if op == TIME else 0.0)
            stack[top + 2] = NAN if op == STATE else 0.0
        elif op == SIGNAL:
            top += 3
            for n in range(3):
                stack[top + n] = jets[k, n]
        else:
            top = run_jet(code, row, const, stack, top)
    for n in range(3):
        out[n] = stack[n]
