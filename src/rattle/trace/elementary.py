"""Sine, exponential and the like as exact operations without a branch, so that all targets compute the same bits.

Every function is at most 2 ulp from the true value (most below 1); outside its domain it gives nan or inf as the
kernels do.  Angles may be up to 1e6 rad (the first 120 bits of pi/2 are used); beyond, sin, cos and tan lose digits.

Source: the polynomials are those of fdlibm (Sun Microsystems 1993, freely distributable) and Cephes (Moshier 1984,
tanh); reduction of angles after Cody and Waite, Software Manual for the Elementary Functions (1980); pow by log and
exp in pairs of doubles, Dekker, A floating-point technique for extending the available precision (1971).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from rattle.language.recorded import Flag, Operand
from rattle.trace.copying import copied
from rattle.trace.graph import EXACT, ROUND, Graph, Symbol, apply, select

INF, NAN = math.inf, math.nan
SPLIT = 134217729.0  # 2^27 + 1

# pi/2 in parts: a whole number below 2^20 times one of the first two, of 33 bits, is exact
HALF_PI = (1.57079632673412561417e00, 6.07710050630396597660e-11, 2.02226624879595063154e-21)
TWO_OVER_PI = 6.36619772367581382433e-01
SIN = (
    -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04, 2.75573137070700676789e-06,
    -2.50507602534068634195e-08, 1.58969099521155010221e-10,
)  # fmt: skip
COS = (
    4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05, -2.75573143513906633035e-07,
    2.08757232129817482790e-09, -1.13596475577881948265e-11,
)  # fmt: skip
LN2_HIGH, LN2_LOW, ONE_OVER_LN2 = 6.93147180369123816490e-01, 1.90821492927058770002e-10, 1.44269504088896338700
EXP = (
    1.66666666666666019037e-01, -2.77777777770155933842e-03, 6.61375632143793436117e-05, -1.65339022054652515390e-06,
    4.13813679705723846039e-08,
)  # fmt: skip
LOG = (
    6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01, 2.222219843214978396e-01,
    1.818357216161805012e-01, 1.531383769920937332e-01, 1.479819860511658591e-01,
)  # fmt: skip
ATAN_AT = (
    (4.63647609000806093515e-01, 2.26987774529616870924e-17),  # 1/2
    (7.85398163397448278999e-01, 3.06161699786838301793e-17),  # 1
    (9.82793723247329054082e-01, 1.39033110312309984516e-17),  # 3/2
    (1.57079632679489655800e00, 6.12323399573676603587e-17),  # infinity
)
ATAN = (
    3.33333333333329318027e-01, -1.99999999998764832476e-01, 1.42857142725034663711e-01, -1.11111104054623557880e-01,
    9.09088713343650656196e-02, -7.69187620504482999495e-02, 6.66107313738753120669e-02, -5.83357013379057348645e-02,
    4.97687799461593236017e-02, -3.65315727442169155270e-02, 1.62858201153657823623e-02,
)  # fmt: skip
ASIN_P = (
    1.66666666666666657415e-01, -3.25565818622400915405e-01, 2.01212532134862925881e-01, -4.00555345006794114027e-02,
    7.91534994289814532176e-04, 3.47933107596021167570e-05,
)  # fmt: skip
ASIN_Q = (
    1.0, -2.40339491173441421878e00, 2.02094576023350569471e00, -6.88283971605453293030e-01, 7.70381505559019352791e-02,
)  # fmt: skip
PI_HALF_HIGH, PI_HALF_LOW, PI_LOW = 1.57079632679489655800e00, 6.12323399573676603587e-17, 1.2246467991473531772e-16
TANH_P = (-1.61468768441708447952e3, -9.92877231001918586564e1, -9.64399179425052238628e-1)
TANH_Q = (4.84406305325125486048e3, 2.23548839060100448583e3, 1.12811678491632931402e2, 1.0)


def polynomial(x: Operand, coefficients: Sequence[float]) -> Operand:
    """c0 + c1 x + c2 x^2 + ... by Horner's rule."""
    result: Operand = coefficients[-1]
    for c in reversed(coefficients[:-1]):
        result = result * x + c
    return result


def _equal(a: Operand, b: Operand) -> Flag:
    return apply("equal", a, b)


def _floor(x: Operand) -> Operand:
    return apply("floor", x)


def _nearest(x: Operand) -> Operand:
    """The nearest whole number of |x| < 2^51."""
    return (x + ROUND) - ROUND


def _with_sign_of(x: Operand, sign: Operand) -> Operand:
    """|x| with the sign of another number, which may be -0."""
    size = abs(x)
    return select((sign < 0.0) | (_equal(sign, 0.0) & (apply("div", 1.0, sign) < 0.0)), -size, size)


# ---------------------------------------------------------------- pairs: a number and the rounding error left of it
def _two_sum(a: Operand, b: Operand) -> tuple[Operand, Operand]:
    s = a + b
    t = s - a
    return s, (a - (s - t)) + (b - t)


def _split(a: Operand) -> tuple[Operand, Operand]:
    t = a * SPLIT
    high = t - (t - a)
    return high, a - high


def _two_product(a: Operand, b: Operand) -> tuple[Operand, Operand]:
    p = a * b
    a1, a2 = _split(a)
    b1, b2 = _split(b)
    return p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2


def _product(a: tuple[Operand, Operand], b: tuple[Operand, Operand]) -> tuple[Operand, Operand]:
    p, e = _two_product(a[0], b[0])
    return _two_sum(p, e + (a[0] * b[1] + a[1] * b[0]))


# ---------------------------------------------------------------- angles
def reduced(x: Operand) -> tuple[Operand, Operand, Operand]:
    """x = n pi/2 + r + s with |r| <= pi/4, s its rounding error: the remainder of n by 4, r, s."""
    n = _nearest(x * TWO_OVER_PI)
    first, second = x - n * HALF_PI[0], n * HALF_PI[1]  # both exact
    r = first - second
    rest = ((first - r) - second) - n * HALF_PI[2]
    high = r + rest
    return n - 4.0 * _floor(n * 0.25), high, rest - (high - r)


def _sine_and_cosine(x: Operand) -> tuple[Operand, Operand, Operand, Operand, Operand]:
    """Quarter turns in x, by 4; sine and cosine of what is left, then the rounding errors of both."""
    quarter, r, s = reduced(x)
    sine, sine_low = _sine_of_rest(r, s)
    cosine, cosine_low = _cosine_of_rest(r, s)
    return quarter, sine, cosine, sine_low, cosine_low


def _sine_of_rest(r: Operand, s: Operand) -> tuple[Operand, Operand]:
    """Sine of r + s, as `reduced` leaves them, and its rounding error."""
    z = r * r
    v = z * r
    less = (z * (0.5 * s - v * polynomial(z, SIN[1:])) - s) - v * SIN[0]
    sine = r - less
    return sine, (r - sine) - less


def _cosine_of_rest(r: Operand, s: Operand) -> tuple[Operand, Operand]:
    """Cosine of r + s, and its rounding error."""
    z = r * r
    half = 0.5 * z
    w = 1.0 - half
    more = ((1.0 - w) - half) + (z * (z * polynomial(z, COS)) - r * s)
    cosine = w + more
    return cosine, (w - cosine) + more


def sine_of_rest(r: Operand, s: Operand) -> Operand:
    """Sine of r + s, as `reduced` leaves them."""
    return _sine_of_rest(r, s)[0]


def cosine_of_rest(r: Operand, s: Operand) -> Operand:
    """Cosine of r + s, as `reduced` leaves them."""
    return _cosine_of_rest(r, s)[0]


def sine(x: Operand) -> Operand:
    """sin x; nan where x is infinite."""
    quarter, s, c, _, _ = _sine_and_cosine(x)
    odd = _equal(quarter, 1.0) | _equal(quarter, 3.0)
    size = select(odd, c, s)
    return select(quarter >= 2.0, -size, size)


def cosine(x: Operand) -> Operand:
    """cos x; nan where x is infinite."""
    quarter, s, c, _, _ = _sine_and_cosine(x)
    odd = _equal(quarter, 1.0) | _equal(quarter, 3.0)
    size = select(odd, s, c)
    return select(_equal(quarter, 1.0) | _equal(quarter, 2.0), -size, size)


def tangent(x: Operand) -> Operand:
    """tan x; nan where x is infinite."""
    quarter, s, c, s_low, c_low = _sine_and_cosine(x)
    odd = _equal(quarter, 1.0) | _equal(quarter, 3.0)
    top, top_low = select(odd, -c, s), select(odd, -c_low, s_low)
    bottom, bottom_low = select(odd, s, c), select(odd, s_low, c_low)
    ratio = top / bottom
    p, e = _two_product(ratio, bottom)
    return ratio + (((top - p) - e) + (top_low - ratio * bottom_low)) / bottom


# ---------------------------------------------------------------- exp and log
def _exponential(high: Operand, low: Operand) -> Operand:
    """exp(high + low), |low| a rounding error of high."""
    x = select(high > 710.0, 710.0, select(high < -750.0, -750.0, high))
    n = _nearest(x * ONE_OVER_LN2)
    first = x - n * LN2_HIGH
    rest = n * LN2_LOW - low
    r = first - rest
    z = r * r
    c = r - z * polynomial(z, EXP)
    y = 1.0 - ((rest - (r * c) / (2.0 - c)) - first)
    half = _floor(n * 0.5)
    result = y * apply("power_of_two", half) * apply("power_of_two", n - half)
    return select(high > 710.0, INF, result)


def exponential(x: Operand) -> Operand:
    """e^x."""
    return _exponential(x, 0.0)


def _fraction(x: Operand) -> tuple[Operand, Operand]:
    """x = f 2^n with f from sqrt(1/2) to sqrt(2), for x > 0: f - 1 and n."""
    tiny = x < 2.2250738585072014e-308
    x = select(tiny, x * 18014398509481984.0, x)
    m, n = apply("mantissa", x), apply("exponent", x)
    large = m > 1.4142135623730951
    n = n + select(large, 1.0, 0.0) - select(tiny, 54.0, 0.0)
    return select(large, 0.5 * m, m) - 1.0, n


def _outside_log(x: Operand, result: Operand) -> Operand:
    """The values of a logarithm where x is not a positive number."""
    result = select(_equal(x, INF), INF, result)
    return select(x > 0.0, result, select(_equal(x, 0.0), -INF, NAN))


def logarithm(x: Operand) -> Operand:
    """ln x; -inf at 0, nan below."""
    f, n = _fraction(x)
    s = f / (2.0 + f)
    z = s * s
    half = 0.5 * f * f
    r = z * polynomial(z, LOG)
    return _outside_log(x, s * (half + r) + n * LN2_LOW - half + f + n * LN2_HIGH)


def _logarithm_pair(x: Operand) -> tuple[Operand, Operand]:
    """ln x for x > 0 to some 70 bits: 2 artanh(s) with s = f/(2 + f)."""
    f, n = _fraction(x)
    d, d_low = _two_sum(2.0, f)
    s = f / d
    p, e = _two_product(s, d)
    s_pair = s, (((f - p) - e) - s * d_low) / d
    z = _product(s_pair, s_pair)
    tail = z[0] * polynomial(z[0], tuple(1.0 / k for k in range(5, 25, 2)))
    q, q_low = _two_sum(1.0 / 3.0, tail)
    w = _product(z, (q, q_low + 1.850371707708594e-17))  # 1/3 - fl(1/3)
    more = _product(s_pair, w)
    high, low = _two_sum(2.0 * s_pair[0], n * LN2_HIGH)
    swapped = _two_sum(high, 2.0 * more[0])
    return _two_sum(swapped[0], low + swapped[1] + (2.0 * (s_pair[1] + more[1]) + n * LN2_LOW))


def power(x: Operand, y: Operand) -> Operand:
    """x^y; nan for a negative x with a broken exponent, 1 for y = 0 or x = 1."""
    size = abs(x)
    zero, infinite = _equal(size, 0.0), _equal(size, INF)
    usual = (size > 0.0) & (size < INF)
    bounded = select(y > 1e18, 1e18, select(y < -1e18, -1e18, y))
    high, low = _logarithm_pair(select(usual, size, 2.0))
    p, e = _two_product(bounded, high)
    result = _exponential(p, e + bounded * low)
    result = select(zero, select(y > 0.0, 0.0, INF), select(infinite, select(y > 0.0, INF, 0.0), result))
    odd = _equal(y - 2.0 * _floor(0.5 * y), 1.0)
    whole = _equal(_floor(y), y)
    result = select(x < 0.0, select(whole, select(odd, -result, result), NAN), result)
    result = select(_equal(x, x) & _equal(y, y), result, NAN)
    return select(_equal(y, 0.0) | _equal(x, 1.0), 1.0, result)


# ---------------------------------------------------------------- arcs
def arc_tangent(x: Operand) -> Operand:
    """atan x."""
    size = abs(x)
    top, bottom = size, select(size < 0.0, 0.0, 1.0)
    base: Operand = 0.0
    base_low: Operand = 0.0
    steps = (  # from where on, numerator and denominator of tan(atan x - atan c)
        (0.4375, 2.0 * size - 1.0, 2.0 + size, *ATAN_AT[0]),
        (0.6875, size - 1.0, size + 1.0, *ATAN_AT[1]),
        (1.1875, size - 1.5, 1.0 + 1.5 * size, *ATAN_AT[2]),
        (2.4375, -1.0, size, *ATAN_AT[3]),
    )
    for start, a, b, high, low in steps:
        beyond = size >= start
        top, bottom = select(beyond, a, top), select(beyond, b, bottom)
        base, base_low = select(beyond, high, base), select(beyond, low, base_low)
    r = top / bottom
    z = r * r
    result = base - ((r * (z * polynomial(z, ATAN)) - base_low) - r)
    return _with_sign_of(select(_equal(size, size), result, size), x)


def arc_tangent_2(y: Operand, x: Operand) -> Operand:
    """The angle of the point (x, y), -pi to pi."""
    up, wide = abs(y), abs(x)
    ratio = select(_equal(up, INF) & _equal(wide, INF), 1.0, apply("div", up, wide))
    ratio = select(_equal(up, 0.0), 0.0, ratio)
    z = arc_tangent(ratio)
    behind = (x < 0.0) | (_equal(x, 0.0) & (apply("div", 1.0, x) < 0.0))
    angle = select(behind, 2.0 * PI_HALF_HIGH - (z - PI_LOW), z)
    angle = select(_equal(x, x) & _equal(y, y), angle, NAN)
    return _with_sign_of(angle, y)


def _arc(z: Operand) -> Operand:
    """(asin s - s)/s for s = sqrt(z)."""
    return z * polynomial(z, ASIN_P) / polynomial(z, ASIN_Q)


def _root_and_rest(z: Operand) -> tuple[Operand, Operand, Operand]:
    """sqrt(z), its upper half, and what is missing to it."""
    s = apply("sqrt", z)
    high, _ = _split(s)
    return s, high, select(_equal(s, 0.0), 0.0, apply("div", z - high * high, s + high))


def arc_sine(x: Operand) -> Operand:
    """asin x; nan beyond +-1."""
    size = abs(x)
    z = (1.0 - size) * 0.5
    s, high, rest = _root_and_rest(select(size < 0.5, 0.25, z))
    half = 0.5 * PI_HALF_HIGH
    outer = half - (2.0 * s * _arc(z) - (PI_HALF_LOW - 2.0 * rest) - (half - 2.0 * high))
    return _with_sign_of(select(size < 0.5, size + size * _arc(size * size), outer), x)


def arc_cosine(x: Operand) -> Operand:
    """acos x; nan beyond +-1."""
    inner = PI_HALF_HIGH - (x - (PI_HALF_LOW - x * _arc(x * x)))
    z = (1.0 - abs(x)) * 0.5
    s, high, rest = _root_and_rest(select(abs(x) < 0.5, 0.25, z))
    r = _arc(z)
    right = 2.0 * (high + (r * s + rest))
    left = 2.0 * (PI_HALF_HIGH - (s + (r * s - PI_HALF_LOW)))
    return select(abs(x) < 0.5, inner, select(x < 0.0, left, right))


def hyperbolic_tangent(x: Operand) -> Operand:
    """tanh x."""
    size = abs(x)
    z = x * x
    inner = x + x * (z * polynomial(z, TANH_P) / polynomial(z, TANH_Q))
    outer = _with_sign_of(1.0 - 2.0 / (_exponential(2.0 * size, 0.0) + 1.0), x)
    return select(size < 0.625, inner, outer)


def hypotenuse(x: Operand, y: Operand) -> Operand:
    """sqrt(x^2 + y^2) without overflow on the way."""
    a, b = abs(x), abs(y)
    large, small = select(a < b, b, a), select(a < b, a, b)
    # a power of two takes the size away and costs no rounding
    shift = apply("power_of_two", _bounded_exponent(large))
    u, v = large / shift, small / shift
    result = apply("sqrt", u * u + v * v) * shift
    return select(_equal(a, INF) | _equal(b, INF), INF, select(_equal(large, 0.0), a + b, result))


def _bounded_exponent(x: Operand) -> Operand:
    n = apply("exponent", x)
    return select(n > 1000.0, 1000.0, select(n < -1000.0, -1000.0, n))


FUNCTIONS: dict[str, Callable[..., Operand]] = {
    "sin": sine, "cos": cosine, "tan": tangent, "exp": exponential, "log": logarithm, "pow": power,
    "atan": arc_tangent, "atan2": arc_tangent_2, "asin": arc_sine, "acos": arc_cosine, "tanh": hyperbolic_tangent,
    "hypot": hypotenuse, "copysign": lambda x, sign: _with_sign_of(x, sign),
}  # fmt: skip


def lower(source: Graph, outputs: Sequence[Operand]) -> tuple[Graph, list[Operand]]:
    """The same calculation in exact operations alone: a graph with the same inputs, and its outputs.

    It is one graph for all that is asked of a source.
    """
    return copied(source, outputs, _lowered)


def _lowered(graph: Graph, op: str, *operands: Operand) -> Operand:
    return graph.apply(op, *operands) if op in EXACT else FUNCTIONS[op](*(_symbol(graph, x) for x in operands))


def _symbol(graph: Graph, x: Operand) -> Symbol:
    """A number as a symbol, so that functions need not tell the two apart."""
    return x if isinstance(x, Symbol) else Symbol(graph, graph.place(x))
