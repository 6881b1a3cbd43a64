"""Operations of two operands, a record each; see `operation`.

Sources: as of `functions_of_one`.
"""

from __future__ import annotations

import math
import operator

import numpy as np

from rattle.jit.choices import select
from rattle.jit.functions import compiled
from rattle.language.arithmetic import INF, heading, held, power, quotient, wave, whole
from rattle.language.functions_of_one import exp_span, log, log_span, sqrt_span
from rattle.language.operation import Operation, Units, operation
from rattle.language.span import (
    Span,
    chain,
    least,
    minus,
    most,
    over,
    product,
    reciprocal,
    square,
    steady,
    switched,
    times,
    wave_span,
    whole_span,
)

LARGEST_POWER = 100.0  # whole exponents up to this one are powers, others logarithms


# ---------------------------------------------------------------- arithmetic
@compiled
def quotient_rates(x, dx, ddx, y, dy, ddy, z):
    """First and second time derivative of z = x / y."""
    dz = quotient(dx - z * dy, y)
    return dz, quotient(ddx - 2.0 * dz * dy - z * ddy, y)


@compiled
def power_rates(x, dx, ddx, y, dy, ddy, z):
    """First and second time derivative [1/s, 1/s^2] of z = x ** y."""
    if dy == 0.0 and ddy == 0.0:
        z1 = select(x != 0.0, quotient(y * z, x), select(y != 0.0, y * power(x, y - 1.0), 0.0))
        bent = select((y != 0.0) & (y != 1.0), y * (y - 1.0) * power(x, y - 2.0), 0.0)
        z2 = select(x != 0.0, quotient((y - 1.0) * z1, x), bent)
        return z1 * dx, z2 * dx * dx + z1 * ddx
    # z = exp(y log x)
    log_x = log(x)
    u = quotient(dx, x)
    rate = dy * log_x + y * u
    drate = ddy * log_x + 2.0 * dy * u + y * (quotient(ddx, x) - u * u)
    return z * rate, z * (rate * rate + drate)


@compiled
def power_span(x, y):
    """x ** y."""
    size = abs(y.low)
    if not (y.low == y.high and y.slow == 0.0 and y.fast == 0.0 and size % 1.0 == 0.0 and size <= LARGEST_POWER):
        return exp_span(times(y, log_span(x)))
    if size == 0.0:
        return steady(1.0)
    around = x.low <= 0.0 and x.high >= 0.0
    even = size % 2.0 == 0.0
    a, b = power(x.low, size), power(x.high, size)
    low, high = 0.0 if even and around else least(a, b), most(a, b)
    a, b = size * power(x.low, size - 1.0), size * power(x.high, size - 1.0)
    slope_low = 0.0 if not even and around and size > 1.0 else least(a, b)
    raised = chain(low, high, slope_low, most(a, b), x)
    return raised if y.low > 0.0 else over(steady(1.0), raised)


def power_of_arrays(x, y):
    """x ** y as `arithmetic.power` has it: without the sign of a zero, and no root of -inf."""
    root = (x < 0.0) & np.isfinite(y) & (y % 1.0 != 0.0)
    return np.where(root, np.nan, np.power(x + 0.0, y))


ADD = operation(
    "+", Units.COMMON, function=False,
    value=lambda x, y: x + y, rates=lambda x, dx, ddx, y, dy, ddy, z: (dx + dy, ddx + ddy),
    span=lambda x, y: Span(x.low + y.low, x.high + y.high, x.slow + y.slow, x.fast + y.fast), array=np.add,
)  # fmt: skip
SUB = operation(
    "-", Units.COMMON, function=False,
    value=lambda x, y: x - y, rates=lambda x, dx, ddx, y, dy, ddy, z: (dx - dy, ddx - ddy),
    span=minus, array=np.subtract,
)  # fmt: skip
MUL = operation(
    "*", Units.PRODUCT, function=False,
    value=lambda x, y: x * y,
    rates=lambda x, dx, ddx, y, dy, ddy, z: (dx * y + x * dy, ddx * y + 2.0 * dx * dy + x * ddy),
    span=times, array=np.multiply,
)  # fmt: skip
DIV = operation(
    "/", Units.QUOTIENT, function=False, recorded="div",
    value=quotient, rates=quotient_rates, span=over, array=np.divide,
)  # fmt: skip
POW = operation(
    "**", Units.POWER, function=False, recorded="pow",
    value=power, rates=power_rates, span=power_span, array=power_of_arrays,
)  # fmt: skip


# ---------------------------------------------------------------- functions
@compiled
def angle_rates(y, dy, ddy, x, dx, ddx, z):
    """First and second time derivative of the angle of the vector (x, y)."""
    size = y * y + x * x
    dz = quotient(x * dy - y * dx, size)
    return dz, quotient(x * ddy - y * ddx - 2.0 * dz * (y * dy + x * dx), size)


@compiled
def angle_span(y, x):
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


@compiled
def hypot_rates(x, dx, ddx, y, dy, ddy, z):
    """First and second time derivative of the length of the vector (x, y)."""
    dz = quotient(x * dx + y * dy, z)
    return dz, quotient(dx * dx + x * ddx + dy * dy + y * ddy - dz * dz, z)


@compiled
def hypot_span(x, y):
    """hypot(x, y)."""
    (a, b), (c, d) = square(x.low, x.high), square(y.low, y.high)
    xx, yy = times(x, x), times(y, y)
    return sqrt_span(Span(a + c, b + d, xx.slow + yy.slow, xx.fast + yy.fast))


@compiled
def mod_jet(side, x, dx, ddx, y, dy, ddy):
    """mod(x, y) with its rates."""
    n = whole(quotient(x, y)) if side == 0 else held(side, quotient(x, y))
    return x - y * n, dx - dy * n, ddx - ddy * n


ATAN2 = operation(
    "atan2", Units.ANGLE, recorded="atan2", arguments="y, x", meaning="angle of the direction (x, y)",
    value=lambda y, x: math.atan2(y, x), rates=angle_rates, span=angle_span, array=np.arctan2,
    partials=(
        lambda y, x, z: x / (y * y + x * x),
        lambda y, x, z: -(y / (y * y + x * x)),
    ),
)  # fmt: skip
HYPOT = operation(
    "hypot", Units.COMMON, recorded="hypot", meaning="sqrt(x**2 + y**2)",
    value=lambda x, y: math.hypot(x, y), rates=hypot_rates, span=hypot_span, array=np.hypot,
    partials=(
        lambda x, y, z: x / z,
        lambda x, y, z: y / z,
    ),
)  # fmt: skip
MOD = operation(
    "mod", Units.COMMON, reserved=False, meaning="x - y*floor(x/y), between 0 and y: mod(-7.5, 2) = 0.5",
    value=lambda x, y: x - y * whole(quotient(x, y)), jet=mod_jet,
    sides={
        "value": lambda side, x, y: x - y * held(side, quotient(x, y)),
        "switching": lambda x, y: wave(quotient(x, y)),
        "switching_span": lambda x, y: wave_span(over(x, y)),
    },
    span=lambda side, x, y: minus(x, times(y, whole_span(over(x, y), side))),
    array=lambda x, y: x - y * np.floor(x / y),
)  # fmt: skip


# ---------------------------------------------------------------- comparisons
@compiled
def below_on(side, x, y):
    """1 where x is below y and -1 where not, on a side of x = y; half as large there, where it could be otherwise."""
    sure = select(x == y, 0.5, 1.0)
    return sure if side < 0 else -sure


@compiled
def above_on(side, x, y):
    """1 where x is above y and -1 where not, likewise."""
    sure = select(x == y, 0.5, 1.0)
    return -sure if side < 0 else sure


def compared(test):
    """A comparison of arrays as a number: 1 where it holds, -1 where not."""
    return lambda x, y: np.where(test(x, y), 1.0, -1.0)


BELOW = operation(
    "<", Units.COMPARISON, function=False,
    value=lambda x, y: select(x < y, 1.0, -1.0), sides={"value": below_on}, array=compared(operator.lt),
    span=lambda side, x, y: switched(side, minus(x, y), steady(-1.0), steady(1.0), steady(-1.0), True),
)  # fmt: skip
BELOW_OR_AT = operation(
    "<=", Units.COMPARISON, function=False,
    value=lambda x, y: select(x <= y, 1.0, -1.0), sides={"value": below_on}, array=compared(operator.le),
    span=lambda side, x, y: switched(side, minus(x, y), steady(-1.0), steady(1.0), steady(1.0), True),
)  # fmt: skip
ABOVE = operation(
    ">", Units.COMPARISON, function=False,
    value=lambda x, y: select(x > y, 1.0, -1.0), sides={"value": above_on}, array=compared(operator.gt),
    span=lambda side, x, y: switched(side, minus(x, y), steady(1.0), steady(-1.0), steady(-1.0), True),
)  # fmt: skip
ABOVE_OR_AT = operation(
    ">=", Units.COMPARISON, function=False,
    value=lambda x, y: select(x >= y, 1.0, -1.0), sides={"value": above_on}, array=compared(operator.ge),
    span=lambda side, x, y: switched(side, minus(x, y), steady(1.0), steady(-1.0), steady(1.0), True),
)  # fmt: skip


# ---------------------------------------------------------------- the smaller and the larger
@compiled
def lower(x, y):
    """The smaller number; nan if one is nan."""
    return select((x <= y) | (x != x), x, y)


@compiled
def higher(x, y):
    """The larger number; nan if one is nan."""
    return select((x >= y) | (x != x), x, y)


@compiled
def lower_rates(x, dx, ddx, y, dy, ddy, z):
    """Rates of the smaller number."""
    first = x <= y
    return select(first, dx, dy), select(first, ddx, ddy)


@compiled
def higher_rates(x, dx, ddx, y, dy, ddy, z):
    """Rates of the larger number."""
    first = (x >= y) | (x != x)
    return select(first, dx, dy), select(first, ddx, ddy)


@compiled
def lower_jet(side, x, dx, ddx, y, dy, ddy):
    """The smaller number with its rates."""
    if side == 0:
        side = heading(x - y, dx - dy, ddx - ddy)
    if side < 0:
        return x, dx, ddx
    if side > 0:
        return y, dy, ddy
    dz, ddz = lower_rates(x, dx, ddx, y, dy, ddy, x)
    return lower(x, y), dz, ddz


@compiled
def higher_jet(side, x, dx, ddx, y, dy, ddy):
    """The larger number with its rates."""
    if side == 0:
        side = heading(x - y, dx - dy, ddx - ddy)
    if side > 0:
        return x, dx, ddx
    if side < 0:
        return y, dy, ddy
    dz, ddz = higher_rates(x, dx, ddx, y, dy, ddy, x)
    return higher(x, y), dz, ddz


@compiled
def lower_span(x, y):
    """Conditions of which both have to hold."""
    return Span(least(x.low, y.low), least(x.high, y.high), least(x.slow, y.slow), most(x.fast, y.fast))


@compiled
def higher_span(x, y):
    """Conditions of which one has to hold."""
    return Span(most(x.low, y.low), most(x.high, y.high), least(x.slow, y.slow), most(x.fast, y.fast))


BOTH = operation(
    "and", Units.JOINING, function=False, value=lower, rates=lower_rates, span=lower_span, array=np.minimum,
)  # fmt: skip
EITHER = operation(
    "or", Units.JOINING, function=False, value=higher, rates=higher_rates, span=higher_span, array=np.maximum,
)  # fmt: skip
MIN = operation(
    "min", Units.COMMON, more=True, meaning="smallest of two or more",
    value=lower, jet=lower_jet, sides={"value": lambda side, x, y: y if side > 0 else x},
    span=lambda side, x, y: switched(side, minus(x, y), y, x, x, False), array=np.minimum,
)  # fmt: skip
MAX = operation(
    "max", Units.COMMON, more=True, meaning="largest of two or more",
    value=higher, jet=higher_jet, sides={"value": lambda side, x, y: x if side > 0 else y},
    span=lambda side, x, y: switched(side, minus(x, y), x, y, x, False), array=np.maximum,
)  # fmt: skip

OPERATIONS: tuple[Operation, ...] = (
    ADD, SUB, MUL, DIV, POW, ATAN2, HYPOT, MOD, BELOW, BELOW_OR_AT, ABOVE, ABOVE_OR_AT, BOTH, EITHER, MIN, MAX,
)  # fmt: skip
