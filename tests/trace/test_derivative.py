"""Derivatives of graphs: those the complex step finds, the same forward and in reverse, at switches, of kernels."""

import functools

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

import rattle as rt
from rattle.equations import motion
from rattle.errors import TraceError
from rattle.trace import elementary
from rattle.trace.derivative import gradient, jacobian, tangent
from rattle.trace.graph import FLAGS, FUNCTIONS, Graph, Symbol, select

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
LONG, STEP = np.clongdouble, 1e-100  # far below every rounding error, yet its square's effect is nothing
EPS = float(np.finfo(np.longdouble).eps)
NAN = complex(np.nan, np.nan)
COUNT = {"add": 2, "sub": 2, "mul": 2, "div": 2, "neg": 1, "abs": 1, "sqrt": 1, "floor": 1, **FUNCTIONS}


# ---------------------------------------------------------------- the reference: complex numbers near the real axis
def _power(z, w):
    if w == 0.0:
        return LONG(1.0)
    if z.real < 0.0 and w.imag == 0.0 and w.real == np.floor(w.real):
        return _power(-z, w) * (-1.0 if w.real % 2.0 else 1.0)
    return np.exp(w * np.log(z)) if z.real > 0.0 else LONG(NAN)


def _root(z):
    """The root; at 0 it has a value, but no slope."""
    if z.real > 0.0:
        return np.sqrt(z)
    return LONG(complex(0.0, np.nan)) if z.real == 0.0 else LONG(NAN)


def _angle(y, x):
    if abs(x.real) >= abs(y.real):
        return np.arctan(y / x) + (0.0 if x.real > 0.0 else np.copysign(np.longdouble(np.pi), y.real))
    return np.copysign(np.longdouble(np.pi) / 2, y.real) - np.arctan(x / y)


COMPLEX = {
    "add": lambda z, w: z + w, "sub": lambda z, w: z - w, "mul": lambda z, w: z * w, "div": lambda z, w: z / w,
    "neg": lambda z: -z, "abs": lambda z: -z if z.real < 0.0 else z, "floor": lambda z: LONG(np.floor(z.real)),
    "sqrt": _root, "less": lambda z, w: z.real < w.real,
    "at_most": lambda z, w: z.real <= w.real, "equal": lambda z, w: z.real == w.real, "both": lambda a, b: a and b,
    "either": lambda a, b: a or b, "not": lambda a: not a, "select": lambda c, z, w: z if c else w,
    "sin": np.sin, "cos": np.cos, "tan": lambda z: np.sin(z) / np.cos(z), "exp": np.exp,
    "log": lambda z: np.log(z) if z.real >= 0.0 else LONG(NAN), "atan": np.arctan, "tanh": np.tanh,
    "asin": lambda z: np.arctan(z / np.sqrt((1 - z) * (1 + z))) if abs(z.real) < 1.0 else LONG(NAN),
    "acos": lambda z: -np.arctan(z / np.sqrt((1 - z) * (1 + z))) if abs(z.real) < 1.0 else LONG(NAN),
    "atan2": _angle, "hypot": lambda z, w: _root(z * z + w * w), "pow": _power,
    "copysign": lambda z, s: (-z if z.real < 0.0 else z) * np.copysign(1.0, s.real),
}  # fmt: skip


def at(graph, outputs, point):
    """Values of outputs at a point of (complex) numbers, and the largest number on the way; functions need not be
    taken apart."""
    values, rank = {}, {place: n for n, place in enumerate(graph.inputs)}
    with np.errstate(all="ignore"):
        for place in graph.live(outputs):
            op = graph.ops[place]
            if op in ("input", "number"):
                values[place] = LONG(point[rank[place]] if op == "input" else graph.numbers[place])
            else:
                values[place] = COMPLEX[op](*(values[k] for k in graph.operands[place]))
    sizes = [abs(z.real) for z in values.values() if np.isfinite(z)]
    return np.array([values[graph.place(x)] for x in outputs], dtype=LONG), float(max(sizes))


def complex_step(graph, outputs, point):
    """d outputs/d inputs at a point, (n_out, n_in)."""
    columns = []
    for k in range(len(point)):
        moved = np.array(point, dtype=LONG)
        moved[k] += STEP * 1j
        columns.append(at(graph, outputs, moved)[0].imag / STEP)
    return np.array(columns).T


def lowered(graph, outputs, point):
    """Values of outputs in double precision, functions taken apart, as every target computes them."""
    exact, made = elementary.lower(graph, outputs)
    return exact.evaluate(made, np.array(point, dtype=float)[:, None])[:, 0]


# ---------------------------------------------------------------- random calculations
steps = st.lists(
    st.tuples(st.sampled_from([*COUNT, "choice"]), *(st.integers(0, 30) for _ in range(4))), min_size=3, max_size=14
)
points = st.tuples(*(st.integers(-250, 250) for _ in range(3)))


def calculation(drawn):
    """A graph of three inputs, and its last two numbers; every step takes numbers made before."""
    graph = Graph()
    inputs = [graph.input() for _ in range(3)]
    made = [*inputs, 0.5, 2.0, -1.5]
    for op, *picked in drawn:
        a, b, c, d = (made[k % len(made)] for k in picked)
        if op == "choice":
            made.append(select(graph.apply("less", a, b), c, d))
        else:
            made.append(graph.apply(op, *(a, b)[: COUNT[op]]))
    return graph, inputs, made[-2:]


def position(drawn):
    """A point without two coordinates, or sums of them, that are equal or zero by accident."""
    return [n / 97.0 + odd for n, odd in zip(drawn, (0.00142857, 0.00271828, 0.00314159), strict=True)]


@settings(max_examples=300, suppress_health_check=[HealthCheck.filter_too_much])
@given(steps, points)
def test_both_modes_find_the_derivative_that_the_complex_step_finds(drawn, where):
    graph, inputs, outputs = calculation(drawn)
    point = position(where)
    want = complex_step(graph, outputs, point)
    columns = [tangent(graph, outputs, {x.place: 1.0}) for x in inputs]
    rows = [gradient(graph, x, inputs) for x in outputs]
    for made in (np.array(columns, dtype=object).T, np.array(rows, dtype=object)):
        got, scale = at(graph, list(made.ravel()), point)
        assume(np.isfinite(want).all() and scale < 1e4)
        assert np.abs(got.real.reshape(want.shape) - want).max() <= 1e4 * EPS * max(1.0, scale) ** 2


@settings(max_examples=150, suppress_health_check=[HealthCheck.filter_too_much])
@given(steps, points)
def test_a_derivative_can_be_derived_again(drawn, where):
    graph, inputs, outputs = calculation(drawn)
    point = position(where)
    first = gradient(graph, outputs[-1], inputs)
    want = complex_step(graph, first, point)
    for made in (jacobian(graph, first, inputs), [gradient(graph, x, inputs) for x in first]):
        got, scale = at(graph, [x for row in made for x in row], point)
        assume(np.isfinite(want).all() and scale < 1e4)
        matrix = got.real.reshape(3, 3)
        tolerance = 1e5 * EPS * max(1.0, scale) ** 2
        assert np.abs(matrix - want).max() <= tolerance
        assert np.abs(matrix - matrix.T).max() <= tolerance


@pytest.mark.parametrize("op", sorted(COUNT))
def test_every_operation_has_its_derivative_in_double_precision(op):
    graph = Graph()
    inputs = [graph.input() for _ in range(COUNT[op])]
    outputs = [graph.apply(op, *inputs)]
    made = jacobian(graph, outputs, inputs)[0]
    for point in ([0.3, 0.7], [0.9, -0.2], [0.05, 2.5], *([[-0.6, 1.2], [-0.4, -3.0]] if op != "log" else [])):
        if op == "sqrt" or (op == "pow" and point[1] != -3.0):
            point[0] = abs(point[0])
        want = complex_step(graph, outputs, point[: COUNT[op]])[0].astype(float)
        got = lowered(graph, made, point[: COUNT[op]])
        known = np.isfinite(want)  # the derivative of a negative number's power by its exponent is not
        np.testing.assert_allclose(got[known], want[known], rtol=4e-15, atol=4e-16)
        assert known[0]
        assert not np.isfinite(got[~known]).any()


# ---------------------------------------------------------------- switches and singular points
def slope(make, *point, seeds=None):
    """Derivatives by all inputs, forward and in reverse, in double precision."""
    graph = Graph()
    inputs = [graph.input() for _ in point]
    output = make(graph, *inputs)
    forward = [tangent(graph, [output], {x.place: 1.0})[0] for x in inputs]
    reverse = gradient(graph, output, inputs)
    both = [lowered(graph, made, point).tolist() for made in (forward, reverse)]
    np.testing.assert_array_equal(both[0], both[1])
    return both[0]


def roots(graph, x):
    return graph.apply("sqrt", x) * graph.apply("log", x)


@pytest.mark.parametrize(
    ("make", "point", "want"),
    [
        (lambda g, x: select(x > 0.0, roots(g, x), x * x), (-3.0,), [-6.0]),
        (lambda g, x: select(x > 0.0, roots(g, x) + 1.0 / x, 5.0), (0.0,), [0.0]),
        # a part that both branches use, one of them singular there
        (lambda g, x: select(x * x > 0.5, g.apply("sqrt", x * x - 0.5), x * x), (0.5,), [1.0]),
        # a part used in a branch that is taken and in one that is not
        (lambda g, x: select(x > 0.0, roots(g, x - 1.0), 2.0) + 3.0 * (x - 1.0), (-1.0,), [3.0]),
        # branches inside branches, three ways to the same part
        (
            lambda g, x, y: select(
                x < 0.0,
                select(y < 0.0, g.apply("sqrt", x * y), g.apply("sqrt", -(x * y))),
                select(y < 0.0, 1.0 / (x * y + 6.0), x * y),
            ),
            (2.0, 3.0), [3.0, 2.0],
        ),
        # infinite times nothing: the exponent does not change where the base is negative
        (lambda g, x, p: g.apply("pow", x, select(x < 0.0, 2.0, p)), (-3.0, 2.5), [-6.0, 0.0]),
        (lambda g, x, lo: select(x < lo, lo, select(x > 1.0, 1.0, g.apply("asin", x))), (1.5, 0.0), [0.0, 0.0]),
        (lambda g, x, lo: select(x < lo, lo, select(x > 1.0, 1.0, g.apply("asin", x))), (-0.5, 0.0), [0.0, 1.0]),
    ],
)  # fmt: skip
def test_a_branch_that_is_not_taken_goes_nowhere(make, point, want):
    np.testing.assert_allclose(slope(make, *point), want, rtol=1e-15)


def test_a_negated_condition_chooses_the_other_branch():
    """The part counts where x > 0 or y <= 0, which no single flag says; its slope is infinite at 0."""

    def make(graph, x, y, z):
        part, sign = graph.apply("sqrt", z), ~(y > 0.0)
        return select(x > 0.0, 2.0 * part, 1.0) + select(sign & (z < 5.0), 3.0 * part, 1.0)

    assert slope(make, -1.0, 1.0, 0.0)[2] == 0.0
    assert slope(make, 1.0, 1.0, 4.0)[2] == 0.5
    assert slope(make, -1.0, -1.0, 4.0)[2] == 0.75
    assert slope(make, 1.0, -1.0, 4.0)[2] == 1.25


def test_many_branches_that_share_a_part_count_only_where_they_are_taken():
    def make(graph, x, *flags):
        part = graph.apply("sqrt", x)  # infinite slope at 0
        total = 0.0
        for k in range(0, len(flags) - 1, 2):
            total = total + select((flags[k] > 0.0) & (flags[k + 1] > float(k)), (k + 1.0) * part, 1.0)
        return total

    count = 24
    assert slope(make, 0.0, *([-1.0] * count))[0] == 0.0
    for k in range(0, count, 2):
        flags = np.full(count, -1.0)
        flags[k : k + 2] = 100.0
        assert slope(make, 4.0, *flags)[0] == pytest.approx((k + 1.0) / 4.0, rel=1e-15)
        assert slope(make, 0.0, *flags)[0] == np.inf


INF = np.inf


@pytest.mark.parametrize(
    ("make", "point", "want"),
    [
        (lambda g, x: g.apply("sqrt", x), (0.0,), [INF]),
        (lambda g, x: g.apply("asin", x), (1.0,), [INF]),
        (lambda g, x: g.apply("acos", x), (1.0,), [-INF]),
        (lambda g, x: g.apply("log", x), (0.0,), [INF]),
        (lambda g, x: g.apply("log", x), (-1.0,), [np.nan]),
        (lambda g, x, y: g.apply("hypot", x, y), (0.0, 0.0), [np.nan, np.nan]),
        (lambda g, y, x: g.apply("atan2", y, x), (0.0, 0.0), [np.nan, np.nan]),
        (lambda g, x: abs(x), (0.0,), [1.0]),  # as expressions have it
        (lambda g, x: g.apply("floor", x), (2.0,), [0.0]),
        (lambda g, x: x % 2.0, (3.5,), [1.0]),
        (lambda g, x: g.apply("pow", x, 0.0), (0.0,), [0.0]),
        (lambda g, x: g.apply("pow", x, 1.0), (0.0,), [1.0]),
        (lambda g, x: g.apply("pow", x, 2.0), (-3.0,), [-6.0]),
        (lambda g, x: g.apply("pow", x, -1.0), (-2.0,), [-0.25]),
        (lambda g, x: g.apply("pow", x, 0.5), (0.0,), [INF]),
        (lambda g, x, y: g.apply("pow", x, y), (0.0, 0.0), [0.0, -INF]),
        (lambda g, x, y: g.apply("pow", x, y), (0.0, 2.0), [0.0, 0.0]),
        (lambda g, x, y: g.apply("pow", x, y), (-2.0, 3.0), [12.0, np.nan]),
        (lambda g, y: g.apply("pow", 2.0, y), (3.0,), [8.0 * np.log(2.0)]),
        (lambda g, x, s: g.apply("copysign", x, s), (-2.0, -0.0), [1.0, 0.0]),
        (lambda g, x, s: g.apply("copysign", x, s), (-2.0, 1.0), [-1.0, 0.0]),
    ],
)
def test_singular_points_have_the_values_of_the_formula(make, point, want):
    np.testing.assert_allclose(slope(make, *point), want, rtol=1e-15)


def test_an_exponent_that_does_not_change_needs_no_logarithm():
    graph = Graph()
    x, y, change = (graph.input() for _ in range(3))
    (made,) = tangent(graph, [graph.apply("pow", x, y)], {x.place: 1.0, y.place: change})
    assert lowered(graph, [made], [-2.0, 3.0, 0.0])[0] == pytest.approx(12.0, rel=1e-15)
    assert np.isnan(lowered(graph, [made], [-2.0, 3.0, 1.0])[0])


# ---------------------------------------------------------------- structure
def test_zeros_and_ones_take_no_operations():
    graph = Graph()
    x, y, z = (graph.input() for _ in range(3))
    matrix = jacobian(graph, [x * y, 2.0 * x - z / 4.0, 7.0, x < y], [x, y, z])
    assert [one.place for one in matrix[0][:2]] == [y.place, x.place]
    assert matrix[0][2] == 0.0
    assert matrix[1:] == [[2.0, 0.0, -0.25], [0.0] * 3, [0.0] * 3]
    assert gradient(graph, x * y, [z]) == [0.0]
    assert tangent(graph, [x, x + y], {x.place: 0.0}) == [0.0, 0.0]
    # the same whichever way it goes: one output, many inputs
    assert [one.place for one in jacobian(graph, [x * y], [x, y])[0]] == [y.place, x.place]


def test_a_direction_may_be_symbols_and_is_linear():
    graph = Graph()
    x, y, u, v = (graph.input() for _ in range(4))
    out = graph.apply("sin", x * y) / y
    (along,) = tangent(graph, [out], {x.place: u, y.place: v})
    by = gradient(graph, out, [x, y])
    point = [0.7, -1.3, 2.0, 0.25]
    got, *slopes = lowered(graph, [along, *by], point)
    assert got == pytest.approx(2.0 * slopes[0] + 0.25 * slopes[1], rel=1e-14)


def test_what_cannot_be_derived_is_refused():
    graph = Graph()
    x = graph.input()
    exact, made = elementary.lower(graph, [graph.apply("exp", x)])
    with pytest.raises(TraceError, match="before its functions are taken apart"):
        tangent(exact, made, {exact.inputs[0]: 1.0})
    with pytest.raises(TraceError, match="before its functions are taken apart"):
        gradient(exact, made[0], [Symbol(exact, exact.inputs[0])])
    with pytest.raises(TraceError, match="inputs of the graph"):
        gradient(graph, x * x, [x * x])


# ---------------------------------------------------------------- recorded kernels
MODELS = ["double_pendulum", "slider_crank", "fourbar", "quick_return", "toggle", "five_bar"]


@functools.cache
def recorded(name):
    """A model's graph, its inputs, right-hand side and system, and a moving state off its start."""
    m = rt.example(name)
    model = m.recorded()
    y = model.start_state
    nq = (len(y) - 2) // 2
    y += np.random.default_rng(3).normal(size=len(y)) * np.where(np.arange(len(y)) < nq, 0.01, 0.5)
    inputs = [Symbol(model.graph, place) for place in model.graph.inputs]
    return model.graph, inputs, model.derivative[:-1], m.system, y


@pytest.mark.parametrize("name", MODELS)
def test_a_right_hand_side_has_the_derivatives_of_its_kernel(name):
    """Against central differences of the kernel, extrapolated.  Their error is bounded by what two extrapolations
    differ by and by rounding, which six values of the kernel carry into the last one, each over h."""
    graph, inputs, rate, system, y = recorded(name)
    made = jacobian(graph, rate, inputs[1:-1])
    got = lowered(graph, [x for row in made for x in row], [0.01, *y, 0.0]).reshape(len(y), len(y))
    workspace, h = system.plain_workspace(), 1e-3

    def kernel(state):
        out = np.zeros(len(y))
        motion.derivative.python(workspace, 0.01, state, out)
        return out

    wobble = 1.0 + np.finfo(float).eps * np.random.default_rng(4).uniform(-1.0, 1.0, (20, len(y)))
    rounding = max(np.abs(kernel(y * one) - kernel(y)).max() for one in wobble)
    for k in range(len(y)):
        change = np.eye(len(y))[k]
        d1, d2, d3 = ((kernel(y + s * change) - kernel(y - s * change)) / (2.0 * s) for s in (h, h / 2, h / 4))
        better, best = (4.0 * d2 - d1) / 3.0, (4.0 * d3 - d2) / 3.0
        bound = np.abs(best - better) + 6.0 * rounding / h
        assert (np.abs(got[:, k] - best) <= bound).all(), (k, np.abs(got[:, k] - best) - bound)
        nothing = [n for n in range(len(y)) if not isinstance(made[n][k], Symbol) and made[n][k] == 0.0]
        assert np.abs(d1[nothing]).max(initial=0.0) == 0.0
        assert bound.max() < 1e-3 * max(1.0, np.abs(got).max())  # else it says nothing


@pytest.mark.parametrize("name", MODELS)
def test_positions_change_by_their_rates_alone_and_nothing_by_work(name):
    graph, inputs, rate, _, y = recorded(name)
    made = jacobian(graph, rate, inputs[1:-1])
    nq = (len(y) - 2) // 2
    for n in range(nq):
        assert made[n] == [1.0 if k == nq + n else 0.0 for k in range(len(y))]
    assert all(row[k] == 0.0 for row in made for k in (2 * nq, 2 * nq + 1))


def test_a_gradient_costs_a_small_multiple_of_its_function():
    """Griewank and Walther, (4.21): at most 5, however many inputs (here 32 states); measured less."""
    graph, inputs, rate, _, y = recorded("quick_return")
    output = sum((x * x for x in rate if isinstance(x, Symbol)), 0.0)
    by = gradient(graph, output, inputs[1:-1])
    assert sum(isinstance(x, Symbol) for x in by) > len(y) // 2
    assert graph.count([*by, output]) <= 4 * graph.count([output])
    assert not any(graph.ops[place] in FLAGS for place in graph.live(by))
