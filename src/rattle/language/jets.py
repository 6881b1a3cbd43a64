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
from rattle.language.bytecode import (
    ABOVE_OR_AT,
    ABS,
    ADD,
    ASIN,
    AT_MOST,
    ATAN,
    ATAN2,
    BELOW,
    BENT,
    BOTH,
    CHOOSE,
    CONST,
    COS,
    CURVE,
    DIV,
    EXP,
    FLOOR,
    HYPOT,
    INF,
    LESS,
    LOG,
    MIN,
    MOD,
    MUL,
    NAN,
    NEG,
    POW,
    SIDE,
    SIGN,
    SIGNAL,
    SIN,
    SQRT,
    SQUARE,
    STATE,
    STEP,
    SUB,
    TAN,
    TANH,
    TIME,
    binary,
    branch,
    held,
    holds,
    power,
    quotient,
    read_table,
    unary,
    whole,
)


@compiled
def heading(s, ds, dds):
    """Side of a switching function s with time derivatives ds, dds: the sign of the first of them that is not zero.

    At s = 0 this is the side that s enters next; 0 if it stays at zero or is nan.
    """
    for n in range(3):
        value = s if n == 0 else (ds if n == 1 else dds)
        if value > 0.0:
            return 1
        if value < 0.0:
            return -1
        if value != value:
            return 0
    return 0


@compiled
def slopes(op, x, f):
    """First and second derivative of the function `op` at x [SI], where its value is f."""
    if op == NEG:
        return -1.0, 0.0
    if op == SQUARE:
        return 2.0 * x, 2.0
    if op == ABS:
        return select(x >= 0.0, 1.0, -1.0), 0.0
    if op in (SIGN, STEP, FLOOR):
        return 0.0, 0.0
    if op == SQRT:
        f1 = quotient(0.5, f)
        return f1, -quotient(0.5 * f1, x)
    if op == EXP:
        return f, f
    if op == LOG:
        f1 = select(x >= 0.0, quotient(1.0, x), NAN)
        return f1, -f1 * f1
    if op == SIN:
        return unary(COS, x), -f
    if op == COS:
        return -unary(SIN, x), -f
    if op == TAN:
        f1 = 1.0 + f * f
        return f1, 2.0 * f * f1
    if op == TANH:
        f1 = (1.0 - f) * (1.0 + f)
        return f1, -2.0 * f * f1
    if op == ATAN:
        f1 = 1.0 / (1.0 + x * x)
        return f1, -2.0 * x * f1 * f1
    rest = (1.0 - x) * (1.0 + x)
    f1 = quotient(1.0, unary(SQRT, rest))
    f2 = quotient(x * f1, rest)
    return (f1, f2) if op == ASIN else (-f1, -f2)


@compiled
def unary_jet(op, side, x, dx, ddx):
    """A function of one operand in jet arithmetic: value, first and second time derivative [SI, 1/s, 1/s^2]."""
    if op == ABS and side == 0:
        side = heading(x, dx, ddx)
    if side == 0:
        f = unary(op, x)
        f1, f2 = slopes(op, x, f)
    else:
        f = branch(op, side, x, 0.0)
        f1, f2 = (float(side) if op == ABS else 0.0), 0.0
    return f, f1 * dx, f2 * dx * dx + f1 * ddx


@compiled
def power_jet(x, dx, ddx, y, dy, ddy, z):
    """First and second time derivative [1/s, 1/s^2] of z = x ** y."""
    if dy == 0.0 and ddy == 0.0:
        z1 = select(x != 0.0, quotient(y * z, x), select(y != 0.0, y * power(x, y - 1.0), 0.0))
        bent = select((y != 0.0) & (y != 1.0), y * (y - 1.0) * power(x, y - 2.0), 0.0)
        z2 = select(x != 0.0, quotient((y - 1.0) * z1, x), bent)
        return z1 * dx, z2 * dx * dx + z1 * ddx
    # z = exp(y log x)
    log_x = unary(LOG, x)
    u = quotient(dx, x)
    rate = dy * log_x + y * u
    drate = ddy * log_x + 2.0 * dy * u + y * (quotient(ddx, x) - u * u)
    return z * rate, z * (rate * rate + drate)


@compiled
def binary_jet(op, side, x, dx, ddx, y, dy, ddy):
    """A function of two operands in jet arithmetic: value, first and second time derivative [SI, 1/s, 1/s^2]."""
    if op >= MIN:
        if side == 0:
            side = heading(x - y, dx - dy, ddx - ddy)
        if side != 0:
            if (side < 0) == (op == MIN):
                return x, dx, ddx
            return y, dy, ddy
    if op == MOD:
        n = whole(quotient(x, y)) if side == 0 else held(side, quotient(x, y))
        return x - y * n, dx - dy * n, ddx - ddy * n
    if op >= BELOW and op <= ABOVE_OR_AT:
        if side == 0:
            side = heading(x - y, dx - dy, ddx - ddy)
        return (binary(op, x, y) if side == 0 else branch(op, side, x, y)), 0.0, 0.0
    z = binary(op, x, y)
    dz = NAN
    ddz = NAN
    if op == ADD:
        dz = dx + dy
        ddz = ddx + ddy
    elif op == SUB:
        dz = dx - dy
        ddz = ddx - ddy
    elif op == MUL:
        dz = dx * y + x * dy
        ddz = ddx * y + 2.0 * dx * dy + x * ddy
    elif op == DIV:
        dz = quotient(dx - z * dy, y)
        ddz = quotient(ddx - 2.0 * dz * dy - z * ddy, y)
    elif op == POW:
        dz, ddz = power_jet(x, dx, ddx, y, dy, ddy, z)
    elif op == ATAN2:  # angle of the vector (y, x): the first operand is the ordinate
        size = x * x + y * y
        dz = quotient(y * dx - x * dy, size)
        ddz = quotient(y * ddx - x * ddy - 2.0 * dz * (x * dx + y * dy), size)
    elif op == HYPOT:
        dz = quotient(x * dx + y * dy, z)
        ddz = quotient(dx * dx + x * ddx + dy * dy + y * ddy - dz * dz, z)
    else:  # MIN or MAX, BOTH or EITHER
        first = (x <= y) if op in (MIN, BOTH) else (x >= y) | (x != x)
        dz = select(first, dx, dy)
        ddz = select(first, ddx, ddy)
    return z, dz, ddz


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
    elif op < ADD:
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
            top = operate_jet(op, code[row, SIDE], const, k, stack, top)
    for n in range(3):
        out[n] = stack[n]
