"""Operations of one operand, a record each; see `operation`.

Sources: derivatives, Griewank and Walther, Evaluating Derivatives, 2nd ed. (2008), ch. 13; bounds, Moore, Kearfott and
Cloud, Introduction to Interval Analysis (2009), ch. 5.
"""

from __future__ import annotations

import math

import numpy as np

from rattle.jit.choices import select
from rattle.jit.functions import compiled
from rattle.language.arithmetic import INF, LARGEST, NAN, held, quotient, wave, whole
from rattle.language.operation import Units, operation
from rattle.language.span import (
    chain,
    least,
    most,
    negative,
    square,
    steady,
    switched,
    wave_span,
    whole_span,
)

TURN = 2.0 * math.pi

NEG = operation(
    "neg", Units.KEPT, function=False,
    value=lambda x: -x, slope=lambda x, f: -1.0, bend=lambda x, f, f1: 0.0, span=negative, array=np.negative,
)  # fmt: skip


@compiled
def square_span(x):
    """x**2."""
    low, high = square(x.low, x.high)
    return chain(low, high, 2.0 * x.low, 2.0 * x.high, x)


SQUARE = operation(
    "square", Units.KEPT, function=False,  # what x**2 becomes in a program
    value=lambda x: x * x, slope=lambda x, f: 2.0 * x, bend=lambda x, f, f1: 2.0, span=square_span, array=np.square,
)  # fmt: skip


# ---------------------------------------------------------------- angles
@compiled
def sin(x):
    """sin x; nan where x is infinite."""
    return math.sin(x) if abs(x) < INF else NAN


@compiled
def cos(x):
    """cos x; nan where x is infinite."""
    return math.cos(x) if abs(x) < INF else NAN


@compiled
def next_at(x, first, apart):
    """The first of the numbers first + n apart that is not below x."""
    return -whole(-(x - first) / apart) * apart + first


@compiled
def sine_range(low, high):
    """Range of sin(x)."""
    a, b = sin(low), sin(high)
    above = 1.0 if next_at(low, 0.25 * TURN, TURN) <= high else most(a, b)
    below = -1.0 if next_at(low, -0.25 * TURN, TURN) <= high else least(a, b)
    return below, above


@compiled
def shifted_sine_span(x, shift):
    """sin(x + shift)."""
    low, high = sine_range(x.low + shift, x.high + shift)
    slope_low, slope_high = sine_range(x.low + (shift + 0.25 * TURN), x.high + (shift + 0.25 * TURN))
    return chain(low, high, slope_low, slope_high, x)


SIN = operation(
    "sin", Units.PLAIN, recorded="sin",
    value=sin, slope=lambda x, f: cos(x), bend=lambda x, f, f1: -f,
    span=lambda x: shifted_sine_span(x, 0.0), array=np.sin,
)  # fmt: skip
COS = operation(
    "cos", Units.PLAIN, recorded="cos",
    value=cos, slope=lambda x, f: -sin(x), bend=lambda x, f, f1: -f,
    span=lambda x: shifted_sine_span(x, 0.25 * TURN), array=np.cos,
)  # fmt: skip


@compiled
def tan(x):
    """tan x; nan where x is infinite."""
    return math.tan(x) if abs(x) < INF else NAN


@compiled
def tan_span(x):
    """tan x; -inf to inf where there is a pole."""
    low, high = tan(x.low), tan(x.high)
    if next_at(x.low, 0.25 * TURN, 0.5 * TURN) <= x.high:
        low, high = -INF, INF
    a, b = square(low, high)
    return chain(low, high, 1.0 + a, 1.0 + b, x)


TAN = operation(
    "tan", Units.PLAIN, recorded="tan",
    value=tan, slope=lambda x, f: 1.0 + f * f, bend=lambda x, f, f1: 2.0 * f * f1, span=tan_span, array=np.tan,
)  # fmt: skip


# ---------------------------------------------------------------- functions with a limited domain
@compiled
def sqrt(x):
    """Square root; nan below 0."""
    return math.sqrt(x) if x >= 0.0 else NAN


@compiled
def log(x):
    """Natural logarithm; -inf at 0, nan below."""
    return math.log(x) if x > 0.0 else (-INF if x == 0.0 else NAN)


@compiled
def asin(x):
    """asin x; nan beyond +-1."""
    return math.asin(x) if -1.0 <= x <= 1.0 else NAN


@compiled
def acos(x):
    """acos x; nan beyond +-1."""
    return math.acos(x) if -1.0 <= x <= 1.0 else NAN


@compiled
def within(x, start, end):
    """The values of a span that lie in start..end; nan if there are none."""
    if x.high < start or x.low > end:
        return NAN, NAN
    return least(most(x.low, start), end), least(most(x.high, start), end)


@compiled
def sqrt_span(x):
    """sqrt x."""
    low, high = within(x, 0.0, INF)
    a, b = sqrt(low), sqrt(high)
    return chain(a, b, quotient(0.5, b), quotient(0.5, a), x)


@compiled
def log_span(x):
    """ln x."""
    low, high = within(x, 0.0, INF)
    return chain(log(low), log(high), quotient(1.0, high), quotient(1.0, low), x)


@compiled
def arc_slope(x):
    """1/sqrt(1 - x^2)."""
    return quotient(1.0, sqrt((1.0 - x) * (1.0 + x)))


@compiled
def arc_slopes(low, high):
    """The least and the largest slope of asin x in low..high."""
    small, large = square(low, high)
    return quotient(1.0, math.sqrt(1.0 - small)), quotient(1.0, math.sqrt(1.0 - large))


@compiled
def asin_span(x):
    """asin x."""
    low, high = within(x, -1.0, 1.0)
    flat, steep = arc_slopes(low, high)
    return chain(asin(low), asin(high), flat, steep, x)


@compiled
def acos_span(x):
    """acos x."""
    low, high = within(x, -1.0, 1.0)
    flat, steep = arc_slopes(low, high)
    return chain(acos(high), acos(low), -steep, -flat, x)


ASIN = operation(
    "asin", Units.PLAIN, recorded="asin",
    value=asin, slope=lambda x, f: arc_slope(x), bend=lambda x, f, f1: quotient(x * f1, (1.0 - x) * (1.0 + x)),
    span=asin_span, array=np.arcsin,
)  # fmt: skip
ACOS = operation(
    "acos", Units.PLAIN, recorded="acos",
    value=acos, slope=lambda x, f: -arc_slope(x), bend=lambda x, f, f1: quotient(x * f1, (1.0 - x) * (1.0 + x)),
    span=acos_span, array=np.arccos,
)  # fmt: skip
SQRT = operation(
    "sqrt", Units.ROOT, recorded="sqrt",
    value=sqrt, slope=lambda x, f: quotient(0.5, f), bend=lambda x, f, f1: -quotient(0.5 * f1, x),
    span=sqrt_span, array=np.sqrt,
)  # fmt: skip
LOG = operation(
    "log", Units.PLAIN, recorded="log", also="ln", meaning="natural logarithm",
    value=log, slope=lambda x, f: select(x >= 0.0, quotient(1.0, x), NAN), bend=lambda x, f, f1: -f1 * f1,
    span=log_span, array=np.log,
)  # fmt: skip


# ---------------------------------------------------------------- functions that rise everywhere
@compiled
def exp(x):
    """e^x."""
    return INF if x > LARGEST else math.exp(x)


@compiled
def exp_span(x):
    """e^x."""
    low, high = exp(x.low), exp(x.high)
    return chain(low, high, low, high, x)


@compiled
def atan_span(x):
    """atan x."""
    a, b = square(x.low, x.high)
    return chain(math.atan(x.low), math.atan(x.high), 1.0 / (1.0 + b), 1.0 / (1.0 + a), x)


@compiled
def tanh_span(x):
    """tanh x."""
    low, high = math.tanh(x.low), math.tanh(x.high)
    a, b = square(low, high)
    return chain(low, high, 1.0 - b, 1.0 - a, x)


EXP = operation(
    "exp", Units.PLAIN, recorded="exp",
    value=exp, slope=lambda x, f: f, bend=lambda x, f, f1: f, span=exp_span, array=np.exp,
)  # fmt: skip
ATAN = operation(
    "atan", Units.PLAIN, recorded="atan",
    value=lambda x: math.atan(x), slope=lambda x, f: 1.0 / (1.0 + x * x), bend=lambda x, f, f1: -2.0 * x * f1 * f1,
    span=atan_span, array=np.arctan,
)  # fmt: skip
TANH = operation(
    "tanh", Units.PLAIN, recorded="tanh",
    value=lambda x: math.tanh(x), slope=lambda x, f: (1.0 - f) * (1.0 + f), bend=lambda x, f, f1: -2.0 * f * f1,
    span=tanh_span, array=np.tanh,
)  # fmt: skip


# ---------------------------------------------------------------- switches
@compiled
def sign_on(side, x):
    """Sign of x on a side of 0."""
    return select(x != x, x, 1.0 if side > 0 else -1.0)


@compiled
def step_on(side, x):
    """Step at 0, on a side of it."""
    return select(x != x, x, 1.0 if side > 0 else 0.0)


ABS = operation(
    "abs", Units.KEPT, meaning="absolute value",
    value=lambda x: abs(x), slope=lambda x, f: select(x >= 0.0, 1.0, -1.0), bend=lambda x, f, f1: 0.0,
    sides={"value": lambda side, x: x if side > 0 else -x, "slope": lambda side: float(side)},
    span=lambda side, x: switched(side, x, x, negative(x), x, False), array=np.abs,
)  # fmt: skip
SIGN = operation(
    "sign", Units.NUMBER, meaning="-1, 0 or 1",
    value=lambda x: select(x > 0.0, 1.0, select(x < 0.0, -1.0, x)),
    slope=lambda x, f: 0.0, bend=lambda x, f, f1: 0.0, sides={"value": sign_on},
    span=lambda side, x: switched(side, x, steady(1.0), steady(-1.0), steady(0.0), True), array=np.sign,
)  # fmt: skip
STEP = operation(
    "step", Units.NUMBER, meaning="0 below zero, 1 from zero on",
    value=lambda x: select(x >= 0.0, 1.0, select(x < 0.0, 0.0, x)),
    slope=lambda x, f: 0.0, bend=lambda x, f, f1: 0.0, sides={"value": step_on},
    span=lambda side, x: switched(side, x, steady(1.0), steady(0.0), steady(1.0), True),
    array=lambda x: np.where(np.isnan(x), x, np.where(x >= 0.0, 1.0, 0.0)),
)  # fmt: skip
FLOOR = operation(
    "floor", Units.PLAIN, reserved=False, meaning="largest whole number that is not above x",
    value=whole, slope=lambda x, f: 0.0, bend=lambda x, f, f1: 0.0,
    sides={"value": held, "switching": wave, "switching_span": wave_span},
    span=lambda side, x: whole_span(x, side), array=np.floor,
)  # fmt: skip

OPERATIONS = (
    NEG, SQUARE, SIN, COS, TAN, ASIN, ACOS, ATAN, TANH, SQRT, EXP, LOG, ABS, SIGN, STEP, FLOOR,
)  # fmt: skip
