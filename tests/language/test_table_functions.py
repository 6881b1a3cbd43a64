"""Tables: values and derivatives against SciPy, kinks as switches, motion of drivers and loads, traces."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PchipInterpolator

import rattle as rt
from rattle.jit.functions import compiled
from rattle.language import bytecode, jets
from rattle.language.expression import compile_program, concatenate, parse
from rattle.language.span import Span
from rattle.language.table_intervals import table_span
from rattle.language.tables import curve, tables_of
from rattle.trace.elementary import lower
from rattle.trace.graph import Graph
from rattle.trace.recording import Recorder
from timed_switches import switches

KNOTS = np.random.default_rng(5)
X = np.cumsum(KNOTS.uniform(0.2, 1.0, 8))
Y = KNOTS.normal(size=8)
CLOSED = np.append(Y[:-1], Y[0])
PERIOD = X[-1] - X[0]


class Straight:
    """Straight lines through points, called as SciPy's interpolators are."""

    def __init__(self, x, y):
        self.x, self.y = x, y

    def __call__(self, x, k=0):
        slopes = np.diff(self.y) / np.diff(self.x)
        i = np.clip(np.searchsorted(self.x, x, side="right") - 1, 0, len(slopes) - 1)
        return (np.interp(x, self.x, self.y), slopes[i], 0.0 * x)[k]


def periodic_pchip(x, k=0):
    """PCHIP of points that go on for a period on either side."""
    longer = np.concatenate([X[:-1] - PERIOD, X, X[1:] + PERIOD])
    return PchipInterpolator(longer, np.concatenate([CLOSED[:-1], CLOSED, CLOSED[1:]]))(x, k)


CASES = {
    "linear": (Y, 0.0, Straight(X, Y)),
    "monotone": (Y, 0.0, PchipInterpolator(X, Y)),
    "spline": (Y, 0.0, CubicSpline(X, Y)),
    "periodic linear": (CLOSED, PERIOD, Straight(X, CLOSED)),
    "periodic monotone": (CLOSED, PERIOD, periodic_pchip),
    "periodic spline": (CLOSED, PERIOD, CubicSpline(X, CLOSED, bc_type="periodic")),
}


def made(case):
    y, period, truth = CASES[case]
    return tables_of({"f": curve(X.tolist(), y.tolist(), case.split()[-1], float(period))}), truth


def read(block, side, x, dx, ddx):
    """Value, first and second derivative of a table at x."""
    return bytecode.read_table.python(np.array(block), 0, side, x, dx, ddx)


def program(text, tables):
    return concatenate([compile_program(parse(text, tables=tables.curves), {}, {}, {"a": 0}, tables)], tables)


@pytest.mark.nojit
@pytest.mark.parametrize("case", CASES)
def test_values_and_derivatives_are_those_of_scipy(case):
    tables, truth = made(case)
    code, const, first, depth = program("f(a)", tables)
    where = np.linspace(X[0], X[-1], 47)
    turns = (-3.0, 0.0, 2.0) if "periodic" in case else (0.0,)
    for x in where[1:-1]:
        for n in turns:
            out, given = np.empty(3), np.array([[x + n * PERIOD, 1.0, 0.0]])
            jets.evaluate_jet(code, const, 0, int(first[1]), 0.0, given, np.empty(3 * depth), out)
            # a table of several turns rounds its argument; slopes and bends of these points are up to 4 and 30
            np.testing.assert_allclose(out, [truth(x, k) for k in range(3)], rtol=1e-12, atol=1e-12)
            value = bytecode.evaluate(
                code, const, 0, int(first[1]), 0.0, np.zeros((1, 8)), given[:, 0], np.empty(depth)
            )
            assert value == out[0]


@pytest.mark.nojit
@pytest.mark.parametrize("n", [2, 3, 4])
def test_few_points_are_enough(n):
    x = np.linspace(X[0], X[-1], 9)[1:-1]
    for kind, truth in (("spline", CubicSpline(X[:n], Y[:n])), ("monotone", PchipInterpolator(X[:n], Y[:n]))):
        one = curve(X[:n].tolist(), Y[:n].tolist(), kind)
        inside = x[(x > X[0]) & (x < X[n - 1])]
        found = [read(one.block, 0, float(v), 1.0, 0.0)[0] for v in inside]
        np.testing.assert_allclose(found, truth(inside), rtol=1e-13)
    closed = np.append(Y[:3], Y[0])
    one = curve(X[:4].tolist(), closed.tolist(), "spline", float(X[3] - X[0]))
    inside = np.linspace(X[0], X[3], 7)[:-1]
    found = [read(one.block, 0, float(v), 1.0, 0.0)[0] for v in inside]
    np.testing.assert_allclose(found, CubicSpline(X[:4], closed, bc_type="periodic")(inside), rtol=1e-12)


@pytest.mark.nojit
def test_a_monotone_table_does_not_overshoot():
    one = curve([0.0, 1.0, 2.0, 3.0, 4.0], [0.0, 0.1, 5.0, 5.0, 5.1], "monotone")
    found = np.array([read(one.block, 0, float(x), 1.0, 0.0) for x in np.linspace(0, 4, 201)])
    assert (found[:, 1] >= 0.0).all()
    assert (found[100:151, 0] == 5.0).all()


@pytest.mark.nojit
def test_outside_there_is_no_value_and_rounding_is_not_outside():
    one = curve([1.0, 2.0, 3.0], [0.0, 1.0, 0.0], "linear")
    for x in (0.9, 3.1, math.nan, math.inf, -math.inf, 1e300):
        assert all(map(math.isnan, read(one.block, 0, x, 1.0, 0.0)))
    assert read(one.block, 0, 3.0 + 4e-16, 1.0, 0.0)[0] == pytest.approx(0.0, abs=1e-15)
    assert read(one.block, 0, 1.0 - 1e-12, 1.0, 0.0)[0] == pytest.approx(0.0, abs=1e-11)


@pytest.mark.nojit
def test_at_a_kink_the_derivative_is_that_ahead():
    block = curve([1.0, 2.0, 3.0], [0.0, 1.0, -1.0], "linear").block
    assert read(block, 0, 2.0, 1.0, 0.0)[1] == -2.0
    assert read(block, 0, 2.0, -1.0, 0.0)[1] == 1.0
    assert read(block, 0, 2.0, 0.0, -1.0)[1] == 1.0
    assert read(block, 1, 2.0, -1.0, 0.0) == (1.0, 1.0, 0.0)  # the side of segment 0


@compiled
def span_of_table(numbers, low, high):
    """Bounds of a table whose argument changes at the rate 2."""
    x = table_span(numbers, 0, Span(low, high, 2.0, 2.0), 0)
    return x.low, x.high, x.slow, x.fast


@pytest.mark.nojit
@pytest.mark.parametrize("case", CASES)
def test_intervals_enclose_value_and_rate(case):
    tables, truth = made(case)
    random = np.random.default_rng(6)
    ends = np.repeat(X[-1], 20)  # of intervals that reach the end of the table, and from its start
    low = np.concatenate([random.uniform(X[0], X[-1], 300), ends - 1e-5, np.repeat(X[0], 20)])
    high = np.minimum(low + 10.0 ** random.uniform(-6, 0.5, 340), X[-1])
    numbers = np.array(tables.numbers)
    found = np.array([span_of_table(numbers, a, b) for a, b in zip(low, high, strict=True)])
    found = Span(*found.T)
    for share in np.linspace(0.0, 1.0, 9):
        x = low + share * (high - low)
        values, rates = truth(x), 2.0 * truth(x, 1)
        assert (found.low - 1e-12 <= values).all()
        assert (values <= found.high + 1e-12).all()
        assert (found.slow - 1e-11 <= rates).all()
        assert (rates <= found.fast + 1e-11).all()
    narrow = high - low < 1e-4
    assert (found.high - found.low)[narrow].max() < 1e-3


@pytest.mark.nojit
def test_kinks_are_located():
    tables = tables_of({"f": curve([0.0, 0.3, 1.0, 1.4], [0.0, 1.0, -1.0, 0.0], "linear", 1.4)})
    (bent, sign), _, _ = switches("sign(f(2*t) - 0.2)", 1.0, tables)
    apart = bent.instants[np.diff(bent.instants, prepend=0.0) > 1e-13]  # rounding may find one twice
    np.testing.assert_allclose(apart, [0.15, 0.5, 0.7, 0.85], atol=1e-14)
    # f = 0.2 at 2t = 0.06, 0.3 + 0.28 and 1.4 + 0.06, 1.4 + 0.58
    np.testing.assert_allclose(sign.instants, [0.03, 0.29, 0.73, 0.99], atol=1e-13)


@pytest.mark.nojit
@pytest.mark.plain
@pytest.mark.parametrize("case", CASES)
def test_a_record_has_the_values_and_derivatives(case):
    tables, truth = made(case)
    code, const, first, depth = program("f(a)", tables)
    graph = Graph()
    given = np.array([[graph.input(), 1.0, 0.0]], dtype=object)
    out = np.zeros(3, dtype=object)
    run = Recorder(graph).recorded(jets.evaluate_jet.python)
    run(code, const, 0, int(first[1]), 0.0, given, np.zeros(3 * depth, dtype=object), out)
    x = np.linspace(X[0], X[-1], 33)[1:-1]
    exact, outputs = lower(graph, list(out))
    shift = 2 * PERIOD if "periodic" in case else 0.0
    found = exact.evaluate(outputs, [x + shift])
    np.testing.assert_allclose(found, [truth(x, k) + 0.0 * x for k in range(3)], rtol=1e-11, atol=1e-12)
    if not shift:
        assert np.isnan(exact.evaluate(outputs, [[X[0] - 0.1, X[-1] + 0.1]])[0]).all()


# ---------------------------------------------------------------- motion
def block(**load):
    m = rt.Mechanism("block").ground(O=[0, 0]).body("block", points={"C": [0, 0]}, mass=1.0, inertia=1.0)
    m.prismatic("guide", "ground.O", "block.C", angle=0)
    return m.load("F", "force", at="block.C", **load) if load else m


def test_a_driver_has_the_exact_derivatives_of_its_table():
    m = block().driver("motor", "guide", position="0.1*lift(3*t)")
    m.table("lift", X.tolist(), CLOSED.tolist(), kind="spline", period=PERIOD)
    spline = CubicSpline(X, CLOSED, bc_type="periodic")
    r = m.simulate(2.0, rtol=1e-11)
    for k, name in enumerate(("x", "vx", "ax")):
        np.testing.assert_allclose(r[f"block.{name}"], 0.1 * 3**k * spline(3 * r.t, k), atol=1e-11)


def test_a_spring_given_by_points_swings_as_its_straight_pieces_do():
    """Stiffness 100 on one side and 25 on the other: each half swing is a half period of its own."""
    m = block(force=["-pull(block.x)", 0]).table("pull", [-1.0, 0.0, 1.0], [-100.0, 0.0, 25.0]).initial("block", x=0.1)
    period = math.pi / 10 + math.pi / 5
    r = m.simulate(t_eval=[0.0, 5 * period], rtol=1e-12)
    assert r["block.x"][1] == pytest.approx(0.1, abs=1e-10)
    assert r.stats["switchings"] == 10


def test_a_load_that_leaves_its_table_ends_the_run():
    m = block(force=["1 + 0*pull(block.x)", 0]).table("pull", [0.0, 0.5], [0.0, 0.0])
    r = m.simulate(2.0)
    assert not r.success
    assert r.t[-1] == pytest.approx(1.0, abs=1e-6)  # x = t^2/2
    assert "outside of the table 'pull', which goes from 0 to 0.5" in r.message


def test_sensitivities_know_how_a_table_follows_from_parameters():
    m = block().parameter("h", 0.3).driver("motor", "guide", position="lift(3*t)")
    m.table("lift", [0.0, 1.0, 2.0, 4.0], [0, "h", "h**2", 0], kind="spline", period=4)
    s = m.sensitivity(["block.x"], ["h"], [0.2, 0.7, 1.1], analysis="kinematics")
    e = 1e-6
    up, down = (m.set(h=0.3 + d).kinematics(s.t)["block.x"] for d in (e, -e))
    np.testing.assert_allclose(s["d(block.x)/d(h)"], (up - down) / (2 * e), atol=1e-9)


def test_samples_side_by_side_read_tables():
    m = block(force=["-pull(block.x)", 0]).parameter("x0", 0.1).initial("block", x="x0", vx=0)
    m.table("pull", [-1.0, -0.2, 0.0, 0.4, 1.0], [-100.0, -4.0, 0.0, 9.0, 50.0], kind="spline")
    x0 = np.array([0.1, 0.5, 0.9])
    a = m.many({"x0": x0}, t_end=0.5, outputs=["at(block.x, 0.5)"], rtol=1e-10)
    one = [m.set(x0=x).simulate(0.5, t_eval=[0, 0.5], rtol=1e-10)["block.x"][-1] for x in x0]
    np.testing.assert_allclose(a["at(block.x, 0.5)"], one, atol=1e-8)
    assert not len(a.generic)
