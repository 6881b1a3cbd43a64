"""Graphs: shared and folded operations, elementary functions to 2 ulp, the same bits from NumPy and C."""

import ctypes
import math
import shutil
import subprocess

import numpy as np
import pytest

from rattle.errors import TraceError
from rattle.trace import c, elementary
from rattle.trace.graph import FUNCTIONS, Graph, select

SAMPLES = 4000
ANGLES = [
    0.0,
    -0.0,
    *(k * math.pi / 2 for k in range(-636_000, 636_000, 131)),
]  # next to zeros of functions
DOMAIN = {
    "sin": (-1e6, 1e6), "cos": (-1e6, 1e6), "tan": (-1e6, 1e6), "exp": (-708.0, 709.0), "log": (0.0, 1e6),
    "atan": (-40.0, 40.0), "asin": (-1.0, 1.0), "acos": (-1.0, 1.0), "tanh": (-25.0, 25.0),
}  # fmt: skip
LONG = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "atan2": "arctan2", "pow": "power"}
ODD = [0.0, -0.0, 1.0, -1.0, 0.5, -2.5, 2.0, 3.0, -3.0, math.inf, -math.inf, math.nan, 5e-324, 1e-310, 1e300]


def made(name, *columns):
    """A function of the graph, at columns of numbers."""
    graph = Graph()
    result = elementary.FUNCTIONS[name](*(graph.input() for _ in columns))
    return graph.evaluate([result], np.array(columns))[0]


def ulps(got, true):
    """Distance from a value in long double, in units of the last place of a double."""
    with np.errstate(all="ignore"):
        return np.abs((got.astype(np.longdouble) - true) / np.spacing(np.abs(true.astype(float))))


def long_value(name, *columns):
    with np.errstate(all="ignore"):
        return getattr(np, LONG.get(name, name))(*(np.asarray(x).astype(np.longdouble) for x in columns))


pytestmark = [pytest.mark.nojit, pytest.mark.plain]
long_double = pytest.mark.skipif(np.finfo(np.longdouble).nmant < 63, reason="no longer double to compare with")


@long_double
@pytest.mark.parametrize("name", DOMAIN)
def test_a_function_is_within_two_units_of_the_last_place(name):
    low, high = DOMAIN[name]
    random = np.random.default_rng(1)
    x = random.uniform(low, high, SAMPLES)
    small = 10.0 ** random.uniform(-300, 0, SAMPLES) * (1.0 if low == 0.0 else random.choice([-1.0, 1.0], SAMPLES))
    x = np.concatenate([x, small, ANGLES if name in ("sin", "cos", "tan") else [], 1.0 - small[:100] ** 2])
    x = np.concatenate([x, np.nextafter(x, 0.0), np.nextafter(x, high)])
    x = x[(x >= low) & (x <= high) & ((x > 0.0) | (name != "log"))]
    assert ulps(made(name, x), long_value(name, x)).max() < 2.0


@long_double
def test_functions_of_two_numbers_are_within_two_units_of_the_last_place():
    random = np.random.default_rng(2)
    a, b = random.normal(size=(2, SAMPLES)) * 10.0 ** random.uniform(-8, 8, (2, SAMPLES))
    for name in ("atan2", "hypot"):
        assert ulps(made(name, a, b), long_value(name, a, b)).max() < 2.0, name
    x, y = 10.0 ** random.uniform(-50, 50, SAMPLES), random.uniform(-5, 5, SAMPLES)
    near, steep = 1.0 + 1e-6 * random.normal(size=SAMPLES), 1e7 * random.normal(size=SAMPLES)
    for one, other in ((x, y), (near, steep)):
        assert ulps(made("pow", one, other), long_value("pow", one, other)).max() < 2.0


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_zeros_infinities_and_nan_give_what_c_gives(name):
    count = FUNCTIONS[name]
    columns = [np.array(ODD)] if count == 1 else list(map(np.ravel, np.meshgrid(ODD, ODD)))
    if name in ("sin", "cos", "tan"):
        columns = [np.array([x for x in ODD if x != 1e300])]  # beyond the range of the reduction
    if name == "pow":  # NumPy's and C's 1 for a broken power of -inf is not the kernels' nan
        from rattle.language.bytecode import power

        want = np.array([power.python(float(x), float(y)) for x, y in zip(*columns, strict=True)])
    else:
        with np.errstate(all="ignore"):
            want = getattr(np, LONG.get(name, name))(*columns)
    np.testing.assert_allclose(made(name, *columns), want, rtol=5e-16, atol=0.0)


def test_equal_operations_are_one_and_numbers_are_folded():
    graph = Graph()
    x, y = graph.input(), graph.input()
    assert (x + y).place == (y + x).place
    assert ((x + y) * (y + x)).op == "mul"
    assert graph.count([(x + y) * (x + y)]) == 2
    assert x * 0.0 == 0.0
    assert (x * 1.0).place == x.place
    assert (x + (-y)).place == (x - y).place
    assert (x / 1.0 - 0.0).place == x.place
    assert select(x < y, 3.0, 3.0) == 3.0
    known, (sine,) = elementary.lower(graph, [graph.apply("sin", 0.5)])
    assert sine == pytest.approx(math.sin(0.5), abs=1e-16)
    assert known.count([sine]) == 0


def test_signs_go_outwards_until_a_sum_takes_them():
    """x (-y) + z is z - x y, for all numbers to the bit, zeros with their signs."""
    graph = Graph()
    x, y, z = (graph.input() for _ in range(3))
    outputs = [x * -y + z, z - -x / y, -x * -y, 3.0 * -x, -x / 3.0]
    assert not any(graph.ops[place] == "neg" for place in graph.live(outputs))
    a, b, c = np.array([[1.5, -0.0, 2.0, -2.0], [3.7, 2.0, -0.0, 5.0], [0.1, 0.0, -0.0, math.inf]])
    with np.errstate(all="ignore"):
        want = [a * -b + c, c - -a / b, -a * -b, 3.0 * -a, -a / 3.0]
    made = graph.evaluate(outputs, [a, b, c])
    assert np.array_equal(made, want, equal_nan=True)
    assert np.array_equal(np.signbit(made), np.signbit(want))


def test_a_branch_on_a_symbol_is_refused_and_named():
    def kernel(x):
        return 1.0 if x > 0.0 else 2.0

    with pytest.raises(TraceError, match=r"test_graph\.py, line \d+ \(kernel\): \"return 1\.0 if x > 0\.0 else 2\.0\""):
        kernel(Graph().input())
    with pytest.raises(TraceError, match="expected a number"):
        math.sin(Graph().input())


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_a_function_of_known_numbers_is_folded_to_the_same_bits(name):
    columns = [np.array(ODD)] if FUNCTIONS[name] == 1 else list(map(np.ravel, np.meshgrid(ODD, ODD)))
    want = made(name, *columns)
    for k, row in enumerate(zip(*columns, strict=True)):
        graph = Graph()
        known, (result,) = elementary.lower(graph, [graph.apply(name, *map(float, row))])
        assert known.count([result]) == 0
        np.testing.assert_array_equal(known.evaluate([result], np.zeros((0, 1)))[0, 0], want[k])


# ---------------------------------------------------------------- C


def everything():
    """All functions at two inputs, as one calculation."""
    graph = Graph()
    inputs = [graph.input(), graph.input()]
    outputs = [elementary.FUNCTIONS[name](*inputs[: FUNCTIONS[name]]) for name in sorted(FUNCTIONS)]
    return graph, [*outputs, inputs[0] < inputs[1]]


def numbers():
    random = np.random.default_rng(5)
    return np.concatenate([random.normal(size=(2, 300)) * 3.0, random.choice(ODD, (2, 150))], axis=1)


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_c_has_the_bits_of_the_reference(tmp_path):
    graph, outputs = everything()
    source = tmp_path / "model.c"
    function = c.function(graph, outputs, "straight")
    text = "\n".join([c.INCLUDES, *c.helpers([function]), function])
    source.write_text(text.replace("static void straight", "void straight"))
    library = tmp_path / "model.so"
    strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-O2", "-fPIC", "-shared"]
    subprocess.run(["cc", *strict, "-o", library, source, "-lm"], check=True, timeout=120)
    straight = ctypes.CDLL(str(library)).straight
    inputs = numbers()
    result, row = np.empty((len(outputs), inputs.shape[1])), np.empty(len(outputs))
    for k in range(inputs.shape[1]):
        column = np.ascontiguousarray(inputs[:, k])
        straight(column.ctypes.data_as(ctypes.c_void_p), row.ctypes.data_as(ctypes.c_void_p))
        result[:, k] = row
    np.testing.assert_array_equal(result, graph.evaluate(outputs, inputs))
