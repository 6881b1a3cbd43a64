"""Kernels in LLVM's language: all constructs give the bits of plain Python; others are refused with their place."""

import importlib.util
import math
import warnings
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from random_kernels import Source
from rattle.jit import functions, mode
from rattle.jit.functions import compiled, native

pytestmark = pytest.mark.skipif(not mode.is_native(), reason="runs without machine code")
TABLE, CHOICES, SHIFT = np.array([[1.0, 2.0], [3.0, 4.0]]), np.array([2, 0, 1]), 0.25
numbers = st.floats(-1e6, 1e6) | st.sampled_from([0.0, -0.0, 1.0, math.inf, -math.inf, math.nan])
wholes = st.integers(-50, 50)


def same(a, b):
    if isinstance(a, tuple):
        return isinstance(b, tuple) and len(a) == len(b) and all(same(x, y) for x, y in zip(a, b, strict=True))
    return a == b and math.copysign(1.0, a) == math.copysign(1.0, b) if a == a else b != b


def agree(function, *args):
    """Machine code and Python, with arrays of their own, give the same bits and leave the same arrays."""
    if not functions.start():
        pytest.skip("runs without machine code")
    mine, theirs = ([np.copy(one) if isinstance(one, np.ndarray) else one for one in args] for _ in range(2))
    found, expected = function(*mine), function.python(*theirs)
    assert same(found, expected), (function.__name__, args, found, expected)
    for one, other in zip(mine, theirs, strict=True):
        np.testing.assert_array_equal(one, other)
    return found


# ---------------------------------------------------------------- arithmetic
@compiled
def floats(x, y):
    largest, smallest = max(x, y, SHIFT), min(x, 0.5, y)
    cut = x % y if y != 0.0 and abs(x) < math.inf else y
    return x + y - x * y, largest, smallest, abs(x), -x, cut, math.copysign(x, y), float(x < y)


@given(numbers, numbers)
@example(-1.0, 0.5)
@example(1.0, -0.75)
def test_arithmetic_of_floats(x, y):
    agree(floats, x, y)


def test_a_whole_power_is_a_product():
    @compiled
    def powers(x):
        return x**2, x**3, x**5, x**0, x**1

    for x in (1.7, -0.3, 1e-200, 1e200):
        assert functions.start() is False or powers(x) == (x * x, x * (x * x), x * ((x * x) * (x * x)), 1.0, x)


@compiled
def integers(i, j):
    rest, quotient = (i % j, i // j) if j != 0 else (0, 0)
    return rest, quotient, i * j - 3, abs(i), -j, i**3, i & 7, j >> 1, i | 1, max(i, j, 2), i / 4, int(i * 0.3), i + 0.5


@given(wholes, wholes)
@example(-7, 2)
@example(7, -2)
def test_arithmetic_of_integers(i, j):
    agree(integers, i, j)


@compiled
def library(x):
    y = abs(x)
    bounded = x / (1.0 + y)
    found = math.sin(x) + math.cos(x) + math.tanh(x) + math.atan2(x, 2.0) + math.asin(bounded) + math.acos(bounded)
    return found, math.sqrt(y), math.exp(-y), math.log(1.0 + y), math.floor(x), (1.0 + y) ** 0.3, math.expm1(bounded)


@given(st.floats(-100.0, 100.0))
def test_functions_of_the_library(x):
    agree(library, x)


# ---------------------------------------------------------------- choices and loops
@compiled
def choices(x, y, k):
    inside = 0.0 < x <= y < 10.0
    either = x > 5.0 or (y > 5.0 and x != y)
    word = 1 if k in (2, 3) else 0.5
    if inside and not either:
        kind = 1
    elif k not in (0, 1):
        kind = 2
    else:
        kind = 3
    return inside, either, word, kind, bool(k), k != 2


@given(st.floats(-2.0, 12.0), st.floats(-2.0, 12.0), st.integers(0, 4))
def test_choices(x, y, k):
    agree(choices, x, y, k)


@compiled
def loops(n, step, row):
    total, seen, last = 0, 0, 0
    for i in range(n):
        if i == 3:
            continue
        if i > 8:
            break
        for j in range(i, 0, -2):
            total += j
        last = i
    while n > 0:
        n -= step
        seen += 1
        if seen > 100:
            break
    for sign in (1.0, -2.0, 0.5):
        if sign < 0.0 and seen % 2:
            continue
        total += sign * row[0]
    for k in range(1, row.shape[0]):
        row[k] += row[k - 1]
    return total, seen, last


@given(st.integers(-2, 15), st.integers(1, 4))
def test_loops(n, step):
    agree(loops, n, step, np.linspace(0.5, 2.0, 5))


def test_the_variable_of_a_loop_keeps_its_last_value_and_may_be_changed_inside():
    @compiled
    def after(n):
        k = -1
        for k in range(n):
            k = 10 * k
        return k

    for n in range(4):
        agree(after, n)


# ---------------------------------------------------------------- arrays and tuples
@compiled
def pair(row, k):
    return row[k], k + 1


@compiled
def arrays(table, row, counts, k):
    line, part, rest = table[k], row[1:4], row[k:]
    line[0], line[1] = line[1], line[0]
    value, following = pair(rest, 0)
    table[k, 2] += value
    counts[k] += following
    rest[0] = following
    beyond = row[2:50]
    grid = TABLE[CHOICES[k] % 2, 1]
    both = (value, part[1])
    return table.shape[0], table.shape[1], len(part), len(beyond), both[1], pair(part, 1)[0], grid, counts[k] > 2


@given(st.integers(0, 2))
def test_arrays_rows_parts_and_tuples(k):
    agree(arrays, np.arange(12.0).reshape(3, 4), np.linspace(-1.0, 1.0, 6), np.array([1, 2, 3]), k)


def test_a_variable_that_is_an_integer_first_and_a_float_later_is_a_float():
    @compiled
    def mean(row):
        total = 0
        for n in range(row.shape[0]):
            total += row[n]
        return total / row.shape[0] if row.shape[0] > 0 else 0

    assert agree(mean, np.array([1.0, 2.5])) == 1.75
    assert agree(mean, np.zeros(0)) == 0.0


def test_an_operand_that_does_not_decide_is_not_computed():
    @compiled
    def guarded(row, k):
        return k < row.shape[0] and row[k] > 0.0, 0.0 if k >= row.shape[0] else row[k]

    for k in range(4):
        agree(guarded, np.array([1.0, -1.0]), k)


def test_functions_of_one_name_and_versions_of_one_function_are_told_apart():
    def made(factor):
        @native("f", "f")
        def scaled(x):
            return factor * x

        return scaled

    @compiled
    def half(x):
        return x // 2 if x > 4 else x / 2

    functions.start()
    assert [made(one)(3.0) for one in (1.0, 2.0, 5.0)] == [3.0, 6.0, 15.0]
    assert agree(half, 3.0) == 1.5
    assert agree(half, 3) == agree(half, np.int64(3)) == 1.5
    assert agree(half, np.bool_(True)) == agree(half, True) == 0.5
    assert agree(half, 7) == 3.0


def test_an_array_with_gaps_is_refused():
    @compiled
    def last(row):
        return row[row.shape[0] - 1]

    if functions.start():
        assert last(np.arange(4.0)) == 3.0
        with pytest.raises(TypeError, match=r"contiguous array of .* with steps of"):
            last(np.arange(4.0)[::2])


# ---------------------------------------------------------------- what is refused
def refused(function, *args):
    functions.start()
    from rattle.jit.translation import unit, values

    with pytest.raises(values.TranslationError) as raised:
        unit.with_result(function, values.kinds_given(args))
    return str(raised.value)


def makes_a_list(x):
    return [x, x]


def counts_from_the_end(row):
    return row[-1]


def has_no_such_array(m):
    return m.nowhere[0]


def mixes(x, row):
    y = x
    if x > 0.0:
        y = row
    return y


def calls_python(x):
    return sorted(x)


def indexes_by_a_float(row, x):
    return row[x]


def uses_too_early(x):
    if x > 1e9:
        return later  # noqa: F821  # what is tested
    return x


class Somewhere:
    address = 0


@pytest.mark.parametrize(
    ("function", "args", "said"),
    [
        (makes_a_list, (1.0,), "'[x, x]' is not known here"),
        (counts_from_the_end, (np.ones(2),), "an index cannot count from the end"),
        (has_no_such_array, (Somewhere(),), "no array 'nowhere'"),
        (mixes, (1.0, np.ones(2)), "a float in one place and a vector in another"),
        (calls_python, (1.0,), "is no compiled function"),
        (indexes_by_a_float, (np.ones(2), 1.0), "an index must be an integer"),
        (uses_too_early, (1.0,), "'later' is used before it has a value"),
        (mixes, (1.0,), "2 arguments are expected, 1 are given"),
    ],
)
def test_what_kernels_cannot_use_is_refused_with_its_place(function, args, said):
    words = refused(function, *args)
    assert said in words
    assert f"test_translation.{function.__name__}, line " in words


# ---------------------------------------------------------------- kernels made at random
def require_agreement(seed, folder):
    """A random kernel gives the bits of Python for several arguments, where Python raises nothing."""
    file, rng = folder / f"kernel{seed}.py", np.random.default_rng(seed)
    file.write_text(Source(seed).text)
    spec = importlib.util.spec_from_file_location(f"rattle.random{seed}", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    compared = 0
    for _ in range(12):
        arrays = rng.normal(size=5), rng.normal(size=(3, 4)), rng.integers(0, 9, 3)
        given = float(rng.normal()), float(rng.normal()), int(rng.integers(-5, 9)), int(rng.integers(0, 9)), *arrays
        with warnings.catch_warnings(), suppress(OverflowError, ZeroDivisionError, ValueError, UnboundLocalError):
            warnings.simplefilter("ignore")
            agree(module.kernel, *given)
            compared += 1
    return compared


@pytest.mark.parametrize("seed", range(15))
def test_random_kernels(seed, tmp_path):
    assert require_agreement(seed, tmp_path) > 0


def nested(inner):
    @compiled
    def step(x):
        return inner(x) * 2.0

    return step


@compiled
def last_of_all(x):
    return x + 1.0


def test_parts_of_one_name_that_contain_each_other_are_told_apart():
    if functions.start():
        assert nested(nested(nested(nested(last_of_all))))(1.0) == 32.0


def changes_a_constant(x):
    TABLE[0, 0] = x
    return TABLE[0, 0]


def looks_in_a_vector(row, x):
    return x in row


def has_three(x):
    return math.hypot(x, x, x)


@pytest.mark.parametrize(
    ("function", "args", "said"),
    [
        (changes_a_constant, (1.0,), "an array from outside does not change"),
        (looks_in_a_vector, (np.ones(2), 1.0), "`in` is for tuples"),
        (has_three, (2.0,), "hypot with 3 arguments is not known here"),
    ],
)
def test_what_would_be_another_calculation_is_refused(function, args, said):
    assert said in refused(function, *args)


def test_the_end_of_a_chain_is_computed_only_if_it_decides():
    @compiled
    def counted(row):
        row[0] += 1.0
        return row[0]

    @compiled
    def chain(row, i):
        return 0 <= i < row.shape[0] < counted(row)

    for i in (-1, 0, 1, 7):
        agree(chain, np.array([2.5, 0.0]), i)
