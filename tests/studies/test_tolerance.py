"""Tolerance studies against closed forms: a mass on a spring, x = x0 cos(sqrt(k/m) t), and a four-bar."""

import itertools
import math

import numpy as np
import pytest

import rattle as rt
from rattle.questions.tolerance.sobol import indices
from springs import SPRING

X = "final(block.x)"
T = 0.1 * math.pi  # [s]
OMEGA = math.sqrt(15.0)
SLOPE_K = -0.5 * math.sin(OMEGA * T) * T / (2.0 * OMEGA)
SLOPE_X = math.cos(OMEGA * T)
RUN = 1e-7  # errors of runs with rtol = 1e-8 [m]


def exact(k, x0, t=T):
    return x0 * np.cos(np.sqrt(k) * t)


@pytest.mark.nojit
def test_worst_case_and_root_sum_square_are_those_of_the_closed_form():
    t = rt.loads(SPRING).tolerance(X, t_end=T, n=64)
    ends = [exact(k, x0) for k, x0 in itertools.product((14.0, 16.0), (0.49, 0.51))]
    np.testing.assert_allclose(t.worst_case, (min(ends), max(ends)), rtol=0.0, atol=RUN)
    half = math.hypot(SLOPE_K * 1.0, SLOPE_X * 0.01)
    middle = exact(15.0, 0.5)
    np.testing.assert_allclose(t.root_sum_square, (middle - half, middle + half), rtol=0.0, atol=RUN)
    np.testing.assert_allclose([t.slopes["k"], t.slopes["x0"]], [SLOPE_K, SLOPE_X], rtol=1e-6)
    assert t.how == "exact derivatives"
    assert t.tighten == ("k", "x0")
    report = str(t)
    assert "half its tolerance makes the root sum square" in report
    assert "Monte Carlo, all 128" in report  # too few for the band of 99.73 %
    assert t._repr_html_().count("<table>") == 2


def test_samples_fill_the_band_of_the_closed_form():
    t = rt.loads(SPRING).tolerance(X, t_end=T, n=4096)
    u = (np.arange(1500) + 0.5) / 1500
    grid = np.sort(exact(*(one.ravel() for one in np.meshgrid(14.0 + 2.0 * u, 0.49 + 0.02 * u))))
    want = np.quantile(grid, [0.00135, 0.99865])
    # 8192 samples, 11 beyond each end, of a density that falls to the ends
    np.testing.assert_allclose(t.monte_carlo, want, rtol=0.0, atol=0.01 * (want[1] - want[0]))
    assert t.mean == pytest.approx(grid.mean(), abs=1e-5)
    assert t.sd == pytest.approx(grid.std(), rel=1e-3)
    share = (np.abs(grid - exact(15.0, 0.5)) <= 0.015).mean()
    found = t.yield_within("15 mm")
    assert found.value == pytest.approx(share, abs=2e-3)
    assert found.low < share < found.high
    assert t.yield_within((0.16, 0.18)).value == pytest.approx(((grid >= 0.16) & (grid <= 0.18)).mean(), abs=2e-3)


def test_sobol_indices_are_those_by_quadrature():
    """A wide field of k, so that k and x0 interact."""
    t = rt.loads(SPRING).tolerance("final(block.x)**2", {"k": 10.0, "x0": 0.4}, t_end=T)
    z, w = np.polynomial.legendre.leggauss(60)
    w = 0.5 * w
    k, x0 = 15.0 + 10.0 * z, 0.5 + 0.4 * z
    f = exact(k[:, None], x0[None, :]) ** 2
    mean = w @ f @ w
    variance = w @ (f - mean) ** 2 @ w
    of_k, of_x = w @ (f @ w - mean) ** 2 / variance, w @ (w @ f - mean) ** 2 / variance
    assert 1.0 - of_k - of_x > 0.02  # they do interact
    want = {"k": (of_k, 1.0 - of_x), "x0": (of_x, 1.0 - of_k)}
    for name, (first, total) in want.items():
        row = t.sobol.loc[name]
        assert row["first"] == pytest.approx(first, abs=0.01)  # 1024 rows of Sobol's sequence
        assert row["total"] == pytest.approx(total, abs=0.01)
        assert row["first_low"] < first < row["first_high"]
        assert row["total_low"] < total < row["total_high"]


@pytest.mark.nojit
def test_intervals_of_indices_cover_independent_rows_about_as_often_as_they_say():
    """F = x1 + 2 x2 + 3 x1 x2 of independent uniform x: exact indices, 60 sets of independent rows."""
    d, n = 2, 256
    parts = np.array([(1 + 1.5) ** 2, (2 + 1.5) ** 2]) / 12.0
    both = 9.0 / 144.0
    first, total = parts / (parts.sum() + both), (parts + both) / (parts.sum() + both)
    generator = np.random.default_rng(7)
    inside = []
    for seed in range(60):
        a, b = generator.random((2, d, n))
        rows = [a, b, *(np.where(np.arange(d)[:, None] == i, b, a) for i in range(d))]
        found = indices(np.array([x[0] + 2.0 * x[1] + 3.0 * x[0] * x[1] for x in rows]), seed)
        inside += [(found.first_low < first) & (first < found.first_high)]
        inside += [(found.total_low < total) & (total < found.total_high)]
    share = np.mean(inside)
    assert 0.88 < share < 0.99  # 95 %, of 240 cases of which those of one set hang together


def test_same_seed_same_numbers_and_another_seed_others():
    m = rt.loads(SPRING)
    one, again, other = (m.tolerance(X, t_end=T, n=32, seed=seed) for seed in (3, 3, 4))
    assert one.sobol.equals(again.sobol)
    assert one.monte_carlo == again.monte_carlo
    assert not np.array_equal(one.drawn, other.drawn)


@pytest.mark.nojit
def test_one_tolerance_alone_causes_all():
    t = rt.loads(SPRING).tolerance(X, ["x0"], t_end=T, n=16)
    assert t.sobol.loc["x0", "first"] == pytest.approx(1.0, abs=0.25)  # the error of 16 rows
    np.testing.assert_allclose(t.worst_case, exact(15.0, np.array([0.49, 0.51])), atol=RUN)
    # x is proportional to x0
    np.testing.assert_allclose(t.root_sum_square, t.worst_case, atol=RUN)


@pytest.mark.nojit
def test_a_group_is_one_contributor_whose_effects_add_with_their_signs():
    text = SPRING + '\n[tolerances]\ngroups = [["k", "x0"]]\n'
    t = rt.loads(text).tolerance(X, t_end=T, n=64)
    assert t.contributors == t.tighten == ("k, x0",)
    assert list(t.sobol.index) == ["k, x0"]
    ends = sorted([exact(14.0, 0.49), exact(16.0, 0.51)])
    np.testing.assert_allclose(t.worst_case, ends, rtol=0.0, atol=RUN)
    half = abs(SLOPE_K * 1.0 + SLOPE_X * 0.01)  # slopes of opposite signs
    assert 0.5 * (t.root_sum_square[1] - t.root_sum_square[0]) == pytest.approx(half, rel=1e-6)
    assert t.sobol.loc["k, x0", "total"] == pytest.approx(1.0, abs=0.1)
    assert "half their tolerances" in str(t)


def test_a_worst_case_inside_of_the_fields_is_told():
    """At sqrt(k/m) t = pi the mass is at its turning point: least for the nominal stiffness."""
    turn = math.pi / OMEGA
    t = rt.loads(SPRING).tolerance(X, t_end=turn, n=64)
    ends = [exact(k, x0, turn) for k, x0 in itertools.product((14.0, 16.0), (0.49, 0.51))]
    np.testing.assert_allclose(t.worst_case, (min(ends), max(ends)), rtol=0.0, atol=RUN)
    assert t.drawn.min() < min(ends)
    assert "not monotone in k: the worst case is inside of the fields" in str(t)


def test_an_output_that_slopes_do_not_tell_is_said_to_be_not_linear():
    t = rt.loads(SPRING).tolerance(X, ["k"], t_end=math.pi / OMEGA, n=64)
    assert t.root_sum_square[1] - t.root_sum_square[0] < 1e-6
    assert "not linear over the tolerances" in str(t)
    assert "not linear" not in str(rt.loads(SPRING).tolerance(X, t_end=T, n=64))


def test_a_corner_that_cannot_be_run_leaves_the_worst_case_unknown():
    text = SPRING.replace("[ground", 'k2 = { value = "k", max = 15.5 }\n[ground', 1).replace('= "k"\nf', '= "k2"\nf')
    t = rt.loads(text).tolerance(X, t_end=T, n=64)
    assert np.isnan(t.worst_case).all()
    report = str(t)
    assert "worst case unknown: 2 of 4 corners have no value" in report
    assert "max = 15.5" in report
    assert "others stand in for them" in report  # rows without a value
    assert t.indices.rows == 64
    assert np.isfinite(t.sobol.to_numpy()).all()
    assert np.isnan(t.drawn).mean() == pytest.approx(0.25, abs=0.05)
    low, high = t.yield_within(1.0)[1:]
    assert low < 0.75 < high
    assert high == pytest.approx(1.0, abs=0.02)  # samples without a value might be within


def test_many_contributors_are_followed_to_the_worst_corner():
    """x0 = 0.5 + a1 - 2 a2 + 3 a3 ...: linear, so that the corner is where the slopes point."""
    names = [f"a{n}" for n in range(1, 13)]
    lines = [f'{name} = {{ value = "0 m", tol = 0.001 }}' for name in names]
    total = " ".join(f"{'+' if n % 2 else '-'} {n}*a{n}" for n in range(1, 13))
    text = SPRING.replace(", tol = 1 }", " }").replace("[ground", "\n".join(lines) + "\n[ground", 1)
    text = text.replace('x0 = { value = "0.5 m", tol = 0.01 }', "").replace('x = "x0"', f'x = "0.5 {total}"')
    t = rt.loads(text).tolerance(X, t_end=T, n=2)
    half = abs(SLOPE_X) * 0.001 * 78
    np.testing.assert_allclose(t.worst_case, (exact(15.0, 0.5) - half, exact(15.0, 0.5) + half), rtol=0.0, atol=RUN)
    assert "of the 2^12 corners" in str(t)


def test_a_table_of_values_counts_with_its_greatest_deviation():
    table = {"dist": {"values": [0.48, 0.5, 0.51], "weights": [1, 2, 1]}}
    t = rt.loads(SPRING).tolerance(X, {"x0": table}, t_end=T, n=64)
    np.testing.assert_allclose(t.worst_case, exact(15.0, np.array([0.48, 0.51])), rtol=0.0, atol=RUN)
    assert t.effects[0] == pytest.approx(SLOPE_X * 0.02, rel=1e-6)


def test_slopes_of_an_analysis_without_derivatives_are_differences():
    """A mass that hangs on a spring: x = 10/k."""
    text = SPRING.replace("[initial]", '[loads.f]\ntype = "force"\nat = "block.P"\nforce = [10, 0]\n[initial]')
    t = rt.loads(text).tolerance("final(block.x)", ["k"], analysis="equilibrium", n=8)
    assert t.nominal == pytest.approx(10.0 / 15.0, abs=1e-9)
    assert t.slopes["k"] == pytest.approx(-10.0 / 15.0**2, rel=1e-5)
    assert t.how.startswith("differences of whole runs, because equilibrium")
    np.testing.assert_allclose(t.worst_case, (10.0 / 16.0, 10.0 / 14.0), atol=1e-9)


@pytest.mark.parametrize(
    ("asked", "error", "said"),
    [
        ({"of": X, "n": 100}, ValueError, "power of two.*take 128"),
        ({"of": [X]}, TypeError, "one output"),
        ({"of": X, "vary": ["kk"]}, KeyError, "did you mean 'k'"),
        ({"of": "final(block.z)"}, rt.ModelError, "no curve"),
        ({"of": "first(block.x > 5)"}, ValueError, "no value without deviations"),
        ({"of": X, "analysis": "statics"}, ValueError, "unknown analysis"),
    ],
)
def test_questions_that_make_no_sense_are_refused(asked, error, said):
    with pytest.raises(error, match=said):
        rt.loads(SPRING).tolerance(**asked, t_end=T)


def angle_of_fourbar(l1, l2, l3, t):
    """Rocker of the example without play: where two circles meet; the frame is made for the links."""
    a = math.radians(60.0)
    frame = l1 + (l2 + l3) * math.cos(a) + 0.01
    d = np.array([frame - l1 * math.cos(10.0 * t), -l1 * math.sin(10.0 * t)])
    far = math.hypot(*d)
    along = (far**2 + l2**2 - l3**2) / (2.0 * far)
    up = math.sqrt(l2**2 - along**2)
    pin = along * d / far + up * np.array([-d[1], d[0]]) / far  # O3 from O2
    return math.atan2(*(d - pin)[::-1])


def test_positions_of_a_driven_four_bar():
    m, at = rt.example("fourbar").ideal(), 0.05
    t = m.tolerance(f"at(rocker.angle, {at})", ["l1", "l2", "l3"], analysis="kinematics", t_end=at, n=2)
    sides = np.array([0.2, 0.6, 0.6])
    tol = np.array([1e-4, 2e-4, 2e-4])
    corners = [angle_of_fourbar(*(sides + tol * signs), at) for signs in itertools.product((-1, 1), repeat=3)]
    np.testing.assert_allclose(t.worst_case, (min(corners), max(corners)), rtol=0.0, atol=1e-9)
    h = 1e-6
    slopes = [
        (angle_of_fourbar(*(sides + h * e), at) - angle_of_fourbar(*(sides - h * e), at)) / (2 * h) for e in np.eye(3)
    ]
    half = math.sqrt(np.sum((np.array(slopes) * tol) ** 2))
    np.testing.assert_allclose(t.root_sum_square, (t.nominal - half, t.nominal + half), rtol=0.0, atol=1e-9)
    assert t.how == "exact derivatives"
    assert " deg/mm" in str(t)
