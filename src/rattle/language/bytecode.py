"""Expressions at run time: small stack programs and the two loops that execute them.

A program is an integer array with rows (op, argument, side, crossed).  An op takes its operands from the top of the
stack and leaves its result there.  A choice takes four operands (the two compared, then, otherwise), so that
there are no jumps.  Outside its domain a function gives nan or inf and never raises: the guards below give what
C would give, and keep plain Python from raising.  All values are in SI units.

`evaluate_jet` runs the same program on 2-jets (value, first and second time derivative), for z = f(x):

    dz  = f' dx
    ddz = f'' dx**2 + f' ddx

Switches (abs, sign, step, min, max, if) have a switching function s: their operand, or the difference of the two
operands that are compared.  A side of +1 or -1 in the program selects the branch for s > 0 or s < 0 whatever the value
of s, so that the right-hand side is smooth between two switching instants; `crossed` is set to 1 when s has the other
sign.  With side 0 the value of s decides: at s = 0 values are those of the definition (sign(0) = 0, step(0) = 1), and
the derivatives of a jet are one-sided, those of the side that s enters next.  A branch without a finite value at s = 0
is not taken there, so that "sin(t)/t if t > 0 else 1" is allowed.

Source: Griewank and Walther, Evaluating Derivatives, 2nd ed. (2008), ch. 13 (Taylor arithmetic).
"""

from __future__ import annotations

import math

from rattle.jit.functions import compiled, native

# operands, then functions of one operand, of two, and choices: the loops rely on this order
CONST, TIME, STATE, SIGNAL = range(4)
NEG, SQUARE, ABS, SIGN, STEP, SQRT, EXP, LOG, SIN, COS, TAN, ASIN, ACOS, ATAN, TANH = range(4, 19)
ADD, SUB, MUL, DIV, POW, ATAN2, HYPOT, MIN, MAX = range(19, 28)
LESS, AT_MOST, MORE, AT_LEAST = range(28, 32)

SIDE, CROSSED = 2, 3  # columns of a program

NAN = math.nan
INF = math.inf
LARGEST = 709.78  # exp of more than this is inf


@compiled
def quotient(x, y):
    """x / y; inf or nan for y = 0."""
    if y != 0.0:
        return x / y
    if x == 0.0 or x != x:
        return NAN
    return math.copysign(INF, x) * math.copysign(1.0, y)


@compiled
def power(x, y):
    """x ** y; nan for a negative x with an exponent that is not an integer."""
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
    if op == MIN:
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
    """Value [SI] of a switch on a given side of its switching function; abs, sign and step do not use y."""
    if op == ABS:
        return x if side > 0 else -x
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
        elif op < ADD:
            x = float(stack[top])
            side = code[row, SIDE]
            if side == 0:
                stack[top] = unary(op, x)
            else:
                stack[top] = branch(op, side, x, 0.0)
                if x * side < 0.0:
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
                if (x - y) * side < 0.0:
                    code[row, CROSSED] = 1
        else:
            top -= 3
            side = code[row, SIDE]
            s = stack[top] - stack[top + 1]
            taken = top + 2 if holds(op, stack[top], stack[top + 1]) else top + 3
            if side != 0:
                far = top + 2 if (side < 0) == (op <= AT_MOST) else top + 3
                if s != 0.0 or abs(stack[far]) < INF:
                    taken = far
                if s * side < 0.0:
                    code[row, CROSSED] = 1
            stack[top] = stack[taken]
    return float(stack[0])


@compiled
def slopes(op, x, f):
    """First and second derivative of the function `op` at x [SI], where its value is f."""
    if op == NEG:
        return -1.0, 0.0
    if op == SQUARE:
        return 2.0 * x, 2.0
    if op == ABS:
        return (1.0 if x >= 0.0 else -1.0), 0.0
    if op in (SIGN, STEP):
        return 0.0, 0.0
    if op == SQRT:
        f1 = quotient(0.5, f)
        return f1, -quotient(0.5 * f1, x)
    if op == EXP:
        return f, f
    if op == LOG:
        f1 = quotient(1.0, x) if x >= 0.0 else NAN
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
def power_jet(x, dx, ddx, y, dy, ddy, z):
    """First and second time derivative [1/s, 1/s^2] of z = x ** y."""
    if dy == 0.0 and ddy == 0.0:
        if x != 0.0:
            z1 = quotient(y * z, x)
            z2 = quotient((y - 1.0) * z1, x)
        else:
            z1 = y * power(x, y - 1.0) if y != 0.0 else 0.0
            z2 = y * (y - 1.0) * power(x, y - 2.0) if y != 0.0 and y != 1.0 else 0.0
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
    elif (x <= y) == (op == MIN) or (x == y):  # MIN or MAX
        dz = dx
        ddz = ddx
    else:
        dz = dy
        ddz = ddy
    return z, dz, ddz


@compiled
def evaluate_jet(code, const, first, last, t, jets, stack, out):
    """Value, first and second time derivative [SI] of the program in rows first..last-1 at time t [s], into out (3,).

    jets: (ns, 3) signals with their time derivatives [SI]; stack: (depth, 3) scratch.  A program that uses the state
    gives nan.
    """
    top = -1
    for row in range(first, last):
        op = code[row, 0]
        k = code[row, 1]
        if op <= STATE:
            top += 1
            stack[top, 0] = const[k] if op == CONST else (t if op == TIME else NAN)
            stack[top, 1] = NAN if op == STATE else (1.0 if op == TIME else 0.0)
            stack[top, 2] = NAN if op == STATE else 0.0
        elif op == SIGNAL:
            top += 1
            for n in range(3):
                stack[top, n] = jets[k, n]
        elif op < ADD:
            x = float(stack[top, 0])
            dx = float(stack[top, 1])
            side = code[row, SIDE]
            if op == ABS and side == 0:
                side = heading(x, dx, float(stack[top, 2]))
            if side == 0:
                f = unary(op, x)
                f1, f2 = slopes(op, x, f)
            else:
                f = branch(op, side, x, 0.0)
                f1, f2 = (float(side) if op == ABS else 0.0), 0.0
            stack[top, 0] = f
            stack[top, 1] = f1 * dx
            stack[top, 2] = f2 * dx * dx + f1 * float(stack[top, 2])
        elif op < LESS:
            top -= 1
            z, dz, ddz = binary_jet(
                op,
                code[row, SIDE],
                float(stack[top, 0]),
                float(stack[top, 1]),
                float(stack[top, 2]),
                float(stack[top + 1, 0]),
                float(stack[top + 1, 1]),
                float(stack[top + 1, 2]),
            )
            stack[top, 0] = z
            stack[top, 1] = dz
            stack[top, 2] = ddz
        else:
            top -= 3
            side = code[row, SIDE]
            s = float(stack[top, 0]) - float(stack[top + 1, 0])
            if side == 0:
                side = heading(
                    s,
                    float(stack[top, 1]) - float(stack[top + 1, 1]),
                    float(stack[top, 2]) - float(stack[top + 1, 2]),
                )
            taken = top + 2 if holds(op, stack[top, 0], stack[top + 1, 0]) else top + 3
            if side != 0:
                far = top + 2 if (side < 0) == (op <= AT_MOST) else top + 3
                if s != 0.0 or abs(stack[far, 0]) + abs(stack[far, 1]) + abs(stack[far, 2]) < INF:
                    taken = far
            for n in range(3):
                stack[top, n] = stack[taken, n]
    for n in range(3):
        out[n] = stack[0, n]
