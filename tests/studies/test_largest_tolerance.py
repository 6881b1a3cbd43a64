"""The largest tolerance or clearance that keeps an accuracy, and allocation, against closed forms."""

import copy
import math

import numpy as np
import pytest
from scipy.optimize import brentq, minimize

import rattle as rt
from rattle.questions.tolerance.allocation import closed_form
from rattle.questions.tolerance.bracket import NARROW, NotReachedError, edge
from springs import SPRING

LINEAR = (
    SPRING.replace(", tol = 1 }", " }")
    .replace('x0 = { value = "0.5 m", tol = 0.01 }', "a = { value = 0.3, tol = 0.01 }\nb = { value = 0.1, tol = 0.02 }")
    .replace('x = "x0"', 'x = "a + 2*b"')
)
HANGING = """
format = 1
gravity = [0, -9.81]
[parameters]
r = "1 mm"
l = { value = "1 m", tol = "0.5 mm" }
[ground.points]
O = [0, 0]
[bodies.rod]
bar = ["A", "B"]
length = "l"
mass = 2
[joints.pin]
type = "revolute"
connect = ["ground.O", "rod.A"]
clearance = "r"
contact = "massless-link"
[initial]
rod = { angle = "-90 deg" }
pin = { offset = [0, "-r"] }
"""
X = "final(block.x)"
T = 0.1 * math.pi  # [s]
FACTOR = math.cos(math.sqrt(15.0) * T)
ALONE = {"k": {"tol": 0.5}}


def exact(k, x0=0.5):
    return x0 * np.cos(np.sqrt(k) * T)


def share_within(tol, half, quantile=lambda u: 2.0 * u - 1.0):
    u = (np.arange(200_000) + 0.5) / 200_000
    return (np.abs(exact(15.0 + tol * quantile(u)) - exact(15.0)) <= half).mean()


# ---------------------------------------------------------------- the search
@pytest.mark.nojit
@pytest.mark.parametrize("power", [0.3, 1.0, 4.0])
@pytest.mark.parametrize("root", [1e-4, 0.9, 1.1, 3e3])
def test_the_edge_of_a_rising_function_is_found_from_any_start(power, root):
    looked = []

    def q(x):
        looked.append(x)
        return (x / root) ** power - 1.0

    found = edge(q, 1.0, 1e-6, 1e6)
    assert found.value <= root < found.over
    assert found.over - found.value <= NARROW * found.over
    assert math.isnan(found.gap)
    assert len(looked) < 45


@pytest.mark.nojit
def test_the_edge_stops_at_a_wall_of_what_cannot_be_run():
    found = edge(lambda x: math.inf if x > 2.5 else x / 10.0 - 1.0, 1.0, 1e-6, 1e6)
    assert 2.5 * (1.0 - NARROW) <= found.value <= 2.5


@pytest.mark.nojit
def test_bounds_of_the_search():
    assert math.isnan(edge(lambda x: -1.0, 1.0, 1e-6, 7.0).over)
    assert edge(lambda x: -1.0, 1.0, 1e-6, 7.0).value == 7.0
    with pytest.raises(NotReachedError):
        edge(lambda x: 1.0, 1.0, 1e-6, 7.0)


@pytest.mark.nojit
def test_what_holds_again_beyond_a_gap_is_not_taken():
    found = edge(lambda x: 0.5 if 0.4 < x < 0.6 or x > 2.0 else -0.5, 1.0, 1e-6, 10.0)
    assert found.value == pytest.approx(0.4, rel=1e-3)
    assert 0.4 < found.gap < 0.6


# ---------------------------------------------------------------- tolerances
def test_the_largest_tolerance_of_one_part_is_that_of_the_closed_form():
    m = rt.loads(SPRING)
    found = m.tolerance_for(X, 0.01, "k", vary=ALONE, t_end=T)
    want = brentq(lambda tol: share_within(tol, 0.01) - 0.997, 0.3, 0.9, xtol=1e-5)
    assert found == pytest.approx(want, rel=2e-3)  # 0.1 % is the search, the rest 16 384 samples
    assert found.share >= 0.997
    assert found.unit == "N/m"
    report = found.report
    assert "largest tolerance of k: +-0.52" in report
    assert "99.7 % of the mechanisms keep final(block.x) within 10 mm of 173.36 mm" in report
    assert "nothing else varies" in report


def test_a_normal_field_allows_a_wider_tolerance():
    from scipy.special import ndtr, ndtri

    beyond = ndtr(-3.0)
    vary = {"k": {"tol": 0.5, "dist": "normal"}}
    found = rt.loads(SPRING).tolerance_for(X, "10 mm", "k", 0.95, vary=vary, t_end=T)
    z = lambda u: ndtri(beyond + u * (1.0 - 2.0 * beyond)) / 3.0  # noqa: E731
    want = brentq(lambda tol: share_within(tol, 0.01, z) - 0.95, 0.3, 3.0, xtol=1e-5)
    assert found == pytest.approx(want, rel=5e-3)


def test_the_others_keep_their_fields():
    m = rt.loads(SPRING)
    found = m.tolerance_for(X, 0.01, "k", 0.99, t_end=T)
    u = (np.arange(1500) + 0.5) / 1500
    k, x0 = np.meshgrid(15.0 + float(found) * (2.0 * u - 1.0), 0.49 + 0.02 * u)
    assert (np.abs(exact(k, x0) - exact(15.0)) <= 0.01).mean() == pytest.approx(0.99, abs=5e-4)
    assert "the others keep their fields: x0 +-10 mm" in found.report


def test_two_limits_and_a_parameter_that_has_no_tolerance_yet():
    text = SPRING.replace(", tol = 1 }", " }").replace(", tol = 0.01", "")
    found = rt.loads(text).tolerance_for(X, (0.165, 0.19), "k", 1.0, t_end=T, n=256)
    # all of 256 samples: the outermost ones are one in 256 from the ends
    want = brentq(lambda k: exact(k) - 0.165, 15.0, 17.0) - 15.0
    assert found == pytest.approx(want, rel=0.01)


def test_limits_of_the_model_end_the_search():
    m = rt.loads(SPRING)
    found = m.tolerance_for(X, 0.5, "k", vary=ALONE, t_end=T, n=64)
    assert found == 14.0  # min = 1
    assert "the limit that the model sets" in found.report
    assert found.share == 1.0


def test_an_accuracy_that_the_others_spoil_is_refused():
    with pytest.raises(
        ValueError, match=r"not even tolerance of k = \+-0 .*: .* of 64 samples.*other tolerances alone"
    ):
        rt.loads(SPRING).tolerance_for(X, 1e-3, "k", t_end=T, n=64)


def test_limits_that_the_nominal_output_does_not_keep_are_not_laid_to_the_other_tolerances():
    with pytest.raises(ValueError, match=r"the output without deviations, .*, is not between the limits"):
        rt.loads(SPRING).tolerance_for(X, (0.6, 0.7), "k", t_end=T, n=4)


@pytest.mark.nojit
def test_the_result_is_a_number_that_can_be_copied():
    found = rt.loads(SPRING).tolerance_for(X, 0.01, "k", vary=ALONE, t_end=T, n=64)
    again = copy.deepcopy(found)
    assert again == found
    assert again.report == found.report == str(found)
    assert isinstance(2.0 * found, float)


# ---------------------------------------------------------------- clearances
def test_the_largest_clearance_of_a_rod_that_hangs_is_what_it_may_sink():
    m = rt.loads(HANGING)
    found = m.tolerance_for("final(rod.B.y)", "2 mm", "r", analysis="equilibrium", vary=[])
    assert found == pytest.approx(2e-3, rel=1.1e-3)
    assert found.report.startswith("largest clearance r of pin: 2 mm")
    assert "from the mechanism without play" in found.report
    # a rod that is up to 0.5 mm longer may sink less; all have to keep the limit
    less = m.tolerance_for("final(rod.B.y)", "2 mm", "r", 1.0, analysis="equilibrium", n=16)
    assert less == pytest.approx(1.5e-3, abs=0.5e-3 / 8)  # of 16 samples the longest is within two steps of the end


def test_a_clearance_with_a_tolerance_is_a_parameter_like_others():
    m = rt.loads(HANGING)
    found = m.tolerance_for("final(rod.B.y)", "0.2 mm", "r", vary={"r": "0.1 mm"}, analysis="equilibrium", n=8)
    assert found.report.startswith("largest tolerance of r")
    assert 0.2e-3 <= found < 0.2e-3 * 4.0 / 3.0  # of 8 samples one is in the outermost eighth


def test_the_clearance_of_a_driven_mechanism_is_that_of_the_whole_band():
    """The rocker of the paper's four-bar, with the free vector of length r3 + r4 in any direction."""
    at, r4 = 0.05, 0.005

    def rocker(r3, free):
        frame = 0.2 + 0.6 + r3 + r4
        o2 = 0.2 * np.array([math.cos(10.0 * at), math.sin(10.0 * at)])
        d = np.array([frame, 0.0])[:, None] + free - o2[:, None]
        far = np.hypot(*d)
        pin = o2[:, None] + 0.5 * d + np.sqrt(0.36 - 0.25 * far**2) * np.array([-d[1], d[0]]) / far
        end = np.array([frame, 0.0])[:, None] + free
        return np.arctan2(*(end - pin)[::-1])

    def deviation(r3):
        turn = np.linspace(0.0, 2.0 * math.pi, 4001)
        free = (r3 + r4) * np.array([np.cos(turn), np.sin(turn)])
        return np.abs(rocker(r3, free) - rocker(r3, np.zeros((2, 1)))).max()

    allowed = math.radians(1.2)
    found = rt.example("fourbar").tolerance_for(
        f"at(rocker.angle, {at})", "1.2 deg", "r3", analysis="kinematics", vary=[], t_end=at
    )
    assert found == pytest.approx(brentq(lambda r3: deviation(r3) - allowed, 5e-4, 1e-2), rel=1.1e-3)
    assert "the whole band counts" in found.report


@pytest.mark.parametrize(
    ("asked", "error", "said"),
    [
        ({"parameter": "kk"}, KeyError, "did you mean 'k'"),
        ({"within": "3 N"}, ValueError, "expected a length"),
        ({"within": 0.0}, ValueError, "must be positive"),
        ({"within": (0.2, 0.1)}, ValueError, "lower limit comes first"),
        ({"within": (0.1, 0.2, 0.3)}, ValueError, "two limits"),
        ({"share": 99.7}, ValueError, "99.7 % is 0.997"),
        ({"parameter": "x0", "vary": {"x0": {"dist": {"values": [0.4, 0.5]}}}}, ValueError, "table of values"),
    ],
)
def test_questions_that_make_no_sense_are_refused(asked, error, said):
    with pytest.raises(error, match=said):
        rt.loads(SPRING).tolerance_for(**{"of": X, "within": 0.01, "parameter": "k", **asked}, t_end=T)


def test_the_band_is_known_of_single_curves_only():
    with pytest.raises(ValueError, match=r"the band .* is known of at, final.*range\(rocker.angle\)"):
        rt.example("fourbar").tolerance_for("range(rocker.angle)", 0.1, "r3", analysis="kinematics", vary=[])


# ---------------------------------------------------------------- allocation
S, C = np.array([2.0, 1.0, 0.5]), np.array([1.0, 2.0, 1.0])
FREE = np.full(3, np.inf)


@pytest.mark.nojit
def test_tolerances_of_least_cost_are_those_of_the_closed_form():
    worst = closed_form(S, C, 0.01, 1.0, 1, FREE)
    np.testing.assert_allclose(worst, [0.002, 0.004, 0.004], rtol=1e-12)
    assert (C / worst).sum() == pytest.approx(1250.0, rel=1e-12)
    rss = closed_form(S, C, 0.01, 1.0, 2, FREE)
    np.testing.assert_allclose(rss, [0.00322961, 0.00645921, 0.00813810], rtol=2e-6)
    assert (C / rss).sum() == pytest.approx(742.149417, rel=1e-8)
    assert (C / closed_form(S, C, 0.01, 2.0, 1, FREE) ** 2).sum() == pytest.approx(420455.436, rel=1e-8)


@pytest.mark.nojit
def test_the_largest_product_is_that_of_equal_contributions():
    np.testing.assert_allclose(S * closed_form(S, np.ones(3), 0.01, 0.0, 1, FREE), 0.01 / 3.0, rtol=1e-12)
    np.testing.assert_allclose(S * closed_form(S, np.ones(3), 0.01, 0.0, 2, FREE), 0.01 / math.sqrt(3.0), rtol=1e-12)


@pytest.mark.nojit
@pytest.mark.parametrize("order", [1, 2])
def test_tolerances_at_their_limits_leave_the_rest_to_the_others(order):
    most = np.array([0.0015, 1.0, 0.003])
    found = closed_form(S, C, 0.01, 1.0, order, most)

    def left(x):
        return 1.0 - ((S * x / 10.0) ** order).sum()

    best = minimize(
        lambda x: (C / x).sum(), [0.5, 0.5, 0.5], bounds=[(1e-3, 1e3 * one) for one in most],
        constraints={"type": "ineq", "fun": left}, options={"ftol": 1e-14},
    )  # fmt: skip
    np.testing.assert_allclose(1e3 * found, best.x, rtol=1e-5)


def test_allocated_tolerances_of_a_linear_output_are_those_by_slopes():
    t = rt.loads(LINEAR).tolerance(X, t_end=T, n=64)
    found = t.allocate("3 mm", "worst-case")
    slope = abs(FACTOR) * np.array([1.0, 2.0])
    np.testing.assert_allclose(list(found.tolerances.values()), 0.0015 / slope, rtol=1.1e-3)
    assert found.share == 1.0
    cheap = t.allocate("3 mm", "worst-case", cost={"a": 1.0, "b": 4.0})
    want = closed_form(slope, np.array([1.0, 4.0]), 0.003, 1.0, 1, np.full(2, np.inf))
    np.testing.assert_allclose(list(cheap.tolerances.values()), want, rtol=1.1e-3)
    assert cheap.cost == pytest.approx((np.array([1.0, 4.0]) / want).sum(), rel=1.1e-3)
    assert "cheapest tolerances" in cheap.report


def test_allocated_tolerances_keep_the_limits_of_an_output_that_is_not_linear():
    m = rt.loads(SPRING)
    t = m.tolerance(X, t_end=T, n=64)
    worst = t.allocate("30 mm", "worst-case")
    low, high = m.tolerance(X, worst.vary, t_end=T, n=64).worst_case
    middle = exact(15.0)
    assert max(middle - low, high - middle) == pytest.approx(0.03, rel=2e-3)
    for share in (0.9, 0.9973):
        found = t.allocate("10 mm", share=share)
        k, x0 = found.tolerances["k"], found.tolerances["x0"]
        u = 2.0 * (np.arange(1500) + 0.5) / 1500 - 1.0
        inside = np.abs(exact(*np.meshgrid(15.0 + k * u, 0.5 + x0 * u)) - middle) <= 0.01
        assert inside.mean() == pytest.approx(share, abs=1e-3)


@pytest.mark.long
def test_no_tolerance_goes_beyond_the_limits_of_the_model():
    t = rt.loads(LINEAR.replace("value = 0.3,", "value = 0.3, min = 0.299,")).tolerance(X, ["b"], t_end=T, n=16)
    assert t.contributors == ("b",)
    text = LINEAR.replace("a = { value = 0.3, tol = 0.01 }", "a = { value = 0.3, min = 0.299, tol = 0.001 }")
    t = rt.loads(text).tolerance(X, t_end=T, n=16)
    found = t.allocate("3 mm", "worst-case")
    assert found.tolerances["a"] == pytest.approx(0.001, rel=1e-12)
    rest = (0.003 / abs(FACTOR) - 0.001) / 2.0
    assert found.tolerances["b"] == pytest.approx(rest, rel=2e-3)
    assert "or the nominal value, allow: a" in found.report


def test_tables_of_values_stay_and_take_their_part():
    table = {"dist": {"values": [0.299, 0.3, 0.301]}}
    t = rt.loads(LINEAR).tolerance(X, {"a": table, "b": 0.02}, t_end=T, n=64)
    found = t.allocate("3 mm", "worst-case")
    assert list(found.tolerances) == ["b"]
    assert found.tolerances["b"] == pytest.approx((0.003 / abs(FACTOR) - 0.001) / 2.0, rel=2e-3)
    assert found.vary["a"]["dist"]["values"] == [0.299, 0.3, 0.301]
    with pytest.raises(ValueError, match=r"tables of values \(a\) alone"):
        t.allocate("0.1 mm", "worst-case")


@pytest.mark.parametrize(
    ("asked", "error", "said"),
    [
        ({"method": "worst"}, ValueError, "did you mean 'worst-case'"),
        ({"cost": {"k": 1.0}}, ValueError, "what x0 cost is missing"),
        ({"cost": {"k": 1.0, "x1": 2.0}}, ValueError, "known: k, x0"),
        ({"cost": {"k": 1.0, "x0": -2.0}}, ValueError, "must be positive"),
        ({"within": (0.2, 0.3)}, ValueError, "is not between the limits"),
        ({"share": 0.0}, ValueError, "from 0 to 1"),
    ],
)
def test_allocations_that_make_no_sense_are_refused(asked, error, said):
    t = rt.loads(SPRING).tolerance(X, t_end=T, n=2)
    with pytest.raises(error, match=said):
        t.allocate(**{"within": "10 mm", **asked})
