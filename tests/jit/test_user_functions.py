"""Functions of users in LLVM's language: every construct gives the bits of plain Python, others are told by line."""

import math
import struct
from collections import namedtuple

import numpy as np
import pytest
from numpy import sin as sine

from rattle.jit import functions, mode
from rattle.jit.functions import KernelFunction

pytestmark = pytest.mark.skipif(not mode.is_native(), reason="runs without machine code")
GRID, CURVE, TABLE = np.array([0.0, 0.5, 2.0, 3.0]), [1.0, -1.0, 4.0, 0.5], [[1.0, 2.0], [3.0, 4.0]]
LIMIT, PAIR = 2.5, (3.0, 0.25)
Point = namedtuple("Point", "x y")
ARGUMENTS = [(-3.7, 0.5), (-1.0, -2.0), (-0.0, 1.0), (0.0, 0.25), (0.5, 3.0), (1.0, 1.0), (2.0, -0.75), (2.6, 7.0)]


def machine_code(law):
    """The function called by a kernel: (x, y) -> float."""

    def run(x, y):
        return float(law(x, y))

    functions.start()
    return KernelFunction(run, letters="fff")


def bits(x):
    return struct.pack("<d", float(x)) if x == x else b"nan"


# ---------------------------------------------------------------- functions of NumPy, `math` and Python
def exact_of_numpy(x, y):
    bounded = np.clip(x, -2.0, LIMIT) + np.minimum(x, y) * np.maximum(y, 0.5) + np.where(x > y, x, 2.0)
    whole = np.floor(x) + 3.0 * np.ceil(y) + 5.0 * np.trunc(x) + 7.0 * np.rint(y)
    truths = np.isnan(x) + 2.0 * np.isfinite(y) + 4.0 * np.isinf(x / 1e-320) + 8.0 * np.logical_and(x > 0, y > 0)
    return bounded + whole + np.sign(x) + np.abs(y) + np.sqrt(np.fabs(x)) + truths + np.copysign(x, y) * np.pi


def more_of_numpy(x, y):
    turned = np.square(x) + np.mod(x, y) + np.heaviside(x, 0.5) + np.float64(y) + np.int64(3) + np.logical_not(x)
    return turned + np.logical_or(x, y) + np.floor_divide(x, y) + np.sum([x, y, 1.0]) + np.max([x, y]) + np.bool_(x)


def interpolated(x, y):
    return np.interp(x, GRID, CURVE) + 10.0 * np.interp(y, (0.0, 1.0), (2.0, 5.0))


def exact_of_math(x, y):
    whole = math.floor(x) + 3 * math.ceil(y) + 5 * math.trunc(x) + 7 * round(y) + 9 * int(x) + bool(y)
    return whole + math.sqrt(abs(x)) + math.copysign(y, x) + math.fmod(x, y) + math.isnan(x) + math.isfinite(y)


def library(x, y):
    return math.sin(x) + math.exp(y) + math.atan2(x, y) + math.tanh(x) + math.log(1.0 + x * x) + math.erf(y)


def logarithm(x, y):
    return math.log(1.0 + abs(x), 3.0) + math.log2(1.0 + abs(y)) + math.log10(3.0 + x * x) + math.asinh(x)


# ---------------------------------------------------------------- flow
def branches(x, y):
    if x < -1.0:
        found = -1.0
    elif -1.0 <= x < 1.0 <= y and x != 0.5 and not y == 2.0:  # noqa: SIM201  # what is tested
        found = 2.0
    elif x in (2.0, 0.5) or y > 5.0:
        found = 3
    else:
        found = x if y < 0 else y
    return found + (x and y) + (x or 1.0)


def loops(x, y):
    total, n = 0.0, 0
    for i in range(1, 12, 2):
        if i == 5:
            continue
        total += x / i
        if total > 4.0:
            break
    while n < 7:
        n += 1
        total -= 0.125 * y
        if total < -20:
            break
    for k, one in enumerate((x, y, 2.0)):
        total += k * one
    for one, other in zip([1.0, 2.0], (x, y), strict=True):
        total *= one
        total += other
    return total + n


def arithmetic(x, y):
    i, j = int(3 * x), int(4 * y) or 5
    x **= 2
    rest = i % j + 3 * (i // j) + (i & 3) - (7 >> 1) + i**2
    return x + x % y + x // y + abs(y) ** 0.5 + rest + max(x, y, 1) - min([x, y]) + sum((x, y)) + pow(2.0, y)


def annotated(x: float, y: float) -> float:
    found: float = x
    (a, b), c = (found, y), 3.0
    a, b = b, a
    return a * c + b


# ---------------------------------------------------------------- functions that it calls
def scaled(value, factor=2.0, *, shift=0.25):
    """Has defaults."""
    return factor * value + shift


def inner(a):
    return a * LIMIT, a + PAIR[1]


square = lambda a: a * a  # noqa: E731  # what is tested


def several(x, y):
    first, second = inner(x)
    point = Point(x, y)
    return scaled(first) + scaled(second, shift=y) + scaled(y, 3) + square(x) + scaled(factor=x, value=y) + point.x


def made(gain):
    rates = np.array([gain, 2.0, 3.0])

    def law(x, y):
        return rates[0] * x + rates[-1] * y + len(rates) + gain

    return law


# ---------------------------------------------------------------- arrays and tuples
def arrays(x, y):
    values, counts = np.zeros(4), np.array([1, 2, 3])
    for k in range(len(values)):
        values[k] = x + k
        values[k] *= y
    values[-1] += 1.0
    matrix = np.array([[x, y], [1.0, 2.0]])
    matrix[1, 0] = matrix[0, 1] + matrix[1][1]
    total = 0.0
    for one in values:
        total += one
    for row in range(matrix.shape[0]):
        for column in range(2):
            total += matrix[row, column]
    counts[0] = 2.7
    a, b = np.array([x, total])
    return total + counts[0] + sum(values) + max(values) + min(counts) + np.ones(3)[2] + np.full(2, y)[1] + a + b


def lookup(x, y):
    state = (x, y, 1.0, 2.0)
    total = 0.0
    for k in range(4):
        total += state[k] * (k + 1)
    return total + state[-1] + CURVE[int(abs(x)) % 4] + TABLE[1][0] + GRID[-2] + sum(GRID[1:3])


def array_in_a_loop(x, y):
    total = 0.0
    for n in range(3):
        step = np.array([x * n, y])
        total += step[0] - step[1]
    return total


EXACT = [
    exact_of_numpy, more_of_numpy, interpolated, exact_of_math, library, logarithm, branches, loops, arithmetic,
    annotated, several, made(1.5), arrays, lookup, array_in_a_loop, lambda x, y: x * y - 1,
]  # fmt: skip


@pytest.mark.parametrize("law", EXACT, ids=lambda law: law.__qualname__)
def test_machine_code_gives_the_bits_of_python(law):
    found = machine_code(law)
    for x, y in ARGUMENTS:
        with np.errstate(all="ignore"):
            assert bits(found(x, y)) == bits(law(x, y)), (x, y)


def transcendental(x, y):
    first = np.sin(x) + np.cos(y) + np.tan(x) + np.arcsin(0.1 * x) + np.arccos(0.1 * y) + np.arctan(x)
    second = np.arctan2(x, y) + np.sinh(x) + np.cosh(y) + np.tanh(x) + np.exp(y) + np.expm1(x) + np.exp2(x)
    third = np.log(1 + x * x) + np.log1p(x * x) + np.log2(1 + y * y) + np.log10(2 + y * y) + np.hypot(x, y)
    fourth = np.cbrt(x) + np.arcsinh(x) + np.arccosh(1 + x * x) + np.arctanh(0.1 * y) + np.power(abs(x), 1.5)
    return first + second + third + fourth + sine(y) + np.degrees(x) + np.radians(y) + math.hypot(x, y)


def test_functions_of_numpy_agree_but_for_the_last_digit():
    found = machine_code(transcendental)
    for x, y in ARGUMENTS:
        assert found(x, y) == pytest.approx(float(transcendental(x, y)), rel=1e-14)


# ---------------------------------------------------------------- what fails as in Python
def raises(x, y):
    if x > 1.0:
        raise ValueError("too deep")
    assert y < 5.0, "too fast"
    return x


def outside(x, y):
    return GRID[int(x) + 2]


def divides(x, y):
    return int(y) // int(x)


@pytest.mark.parametrize(
    ("law", "given", "error", "said"),
    [
        (raises, (2.0, 0.0), ValueError, "too deep .*raises, line "),
        (raises, (0.0, 7.0), AssertionError, "raises, line "),
        (outside, (2.0, 0.0), IndexError, "outside, line "),
        (outside, (-7.0, 0.0), IndexError, "outside, line "),
        (divides, (0.0, 7.0), ZeroDivisionError, "divides, line "),
    ],
)
def test_what_python_refuses_machine_code_refuses(law, given, error, said):
    found = machine_code(law)
    with pytest.raises(error, match=said):
        found(*given)
    with pytest.raises(error):
        law(*given)
    assert found(1.0, 4.0) == law(1.0, 4.0)


# ---------------------------------------------------------------- what is not translated
def imports(x, y):
    import json

    return float(json.dumps(x))


def has_a_dictionary(x, y):
    return {"x": x}["x"]


def tries(x, y):
    try:
        return 1.0 / x
    except ZeroDivisionError:
        return 0.0


def second_name_in_a_loop(x, y):
    last = np.zeros(1)
    for n in range(3):
        step = np.array([x * n])
        if n == 1:
            last = step
    return last[0]


def returned_array(x, y):
    found = np.zeros(2)
    return found


def grows(x, y):
    return np.zeros(int(x))[0]


def vector(x, y):
    return (np.array([x, y]) * 2.0)[0]


def to_digits(x, y):
    return round(x, 2)


def forever(x, y):
    return x if x > 10.0 else forever(x + 1.0, y)


def many(x, *others):
    return x


@pytest.mark.parametrize(
    ("law", "said"),
    [
        (imports, "'import json' is not known here"),
        (has_a_dictionary, "'{'x': x}' is not known here"),
        (tries, "'try' is not known here"),
        (second_name_in_a_loop, "within a loop a variable cannot become a vector"),
        (returned_array, "a vector cannot be returned here"),
        (grows, "the size of an array must be a known number"),
        (vector, "a number is needed here"),
        (to_digits, "rint with 2 arguments is not known here"),
        (forever, "forever calls itself"),
        (many, "its arguments are not those of many"),
    ],
)
def test_what_is_not_translated_is_told_with_its_line(law, said):
    found = machine_code(law)
    with pytest.raises(TypeError) as raised:
        found(1.0, 2.0)
    assert said in str(raised.value)
    assert ", line " in str(raised.value)


def test_numbas_own_functions_are_translated_from_their_source():
    numba = pytest.importorskip("numba")
    law = numba.njit(scaled)

    def calls(x, y):
        return law(x) + y

    assert machine_code(law.py_func)(1.0, 3.0) == 3.25
    assert machine_code(calls)(1.0, 4.0) == 6.25
