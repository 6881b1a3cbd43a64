"""Between its samples a curve is a cubic: bounds from the remainder of interpolation, and no reach across a jump."""

import numpy as np
import pytest

from rattle.results.sampled_curve import SampledCurve

pytestmark = pytest.mark.nojit

W, SPAN = 2 * np.pi, 3.0  # three periods of sin(W t + PHASE), which is cut at no special place
PHASE = 0.4


def even(n):
    return np.linspace(0.0, SPAN, n)


def uneven(n):
    steps = np.random.default_rng(7).uniform(0.3, 1.0, n - 1)
    return np.concatenate([[0.0], np.cumsum(steps)]) * SPAN / steps.sum()


def wave(t):
    return np.sin(W * t + PHASE)


def bound(t):
    """Largest error of a cubic through four neighbours: |product of distances| <= (h/2)^2 2h 3h, over 4!."""
    return (W * np.diff(t).max()) ** 4 / 16


GRIDS = [even(30), even(100), even(1000), uneven(60), uneven(200), uneven(2000)]


@pytest.fixture(params=GRIDS, ids=lambda t: f"{len(t)}-{'even' if np.ptp(np.diff(t)) < 1e-9 else 'uneven'}")
def sine(request):
    return SampledCurve(request.param, wave(request.param)), bound(request.param)


def test_values_between_samples(sine):
    curve, error = sine
    t = np.linspace(0.0, SPAN, 1237)
    assert max(abs(curve.at(x) - wave(x)) for x in t) <= error


def test_values_at_samples_are_the_samples(sine):
    curve, _ = sine
    assert [curve.at(x) for x in curve.t] == curve.values.tolist()


def test_integral_mean_and_mean_square(sine):
    curve, error = sine
    a, b = PHASE, W * SPAN + PHASE
    mean = (np.cos(a) - np.cos(b)) / (W * SPAN)
    square = 0.5 - (np.sin(2 * b) - np.sin(2 * a)) / (4 * W * SPAN)
    assert abs(curve.integral() - mean * SPAN) <= error * SPAN
    assert abs(np.sqrt(curve.mean_square()) - np.sqrt(square)) <= error  # the RMS is a norm
    assert abs(curve.mean() - mean) <= error


def test_extremes(sine):
    curve, error = sine
    assert abs(curve.greatest() - 1.0) <= error + 1e-15
    assert abs(curve.least() + 1.0) <= error + 1e-15


@pytest.mark.parametrize("level", [-0.9, 0.0, 0.5])
def test_time_above_a_level(sine, level):
    curve, error = sine
    share = 0.5 - np.arcsin(level) / np.pi
    # six crossings; the smallest slope on the way is that of the sine where it is the level plus the error
    moved = error / (W * np.sqrt(1 - (abs(level) + error) ** 2))
    assert abs(curve.time_above(level) - share * SPAN) <= 6 * moved


@pytest.mark.parametrize("share", [0.0, 0.05, 0.5, 0.9, 1.0])
def test_quantile_is_that_of_the_arcsine_distribution(sine, share):
    curve, error = sine
    assert abs(curve.quantile(share) + np.cos(np.pi * share)) <= error + 1e-15  # moves by no more than the curve does


@pytest.mark.parametrize("grid", [even, uneven])
def test_errors_fall_with_the_fourth_power_of_the_interval(grid):
    def errors(n):
        t = grid(n)
        curve = SampledCurve(t, wave(t))
        inside = np.linspace(0.0, SPAN, 2000)
        return np.array(
            [max(abs(curve.at(x) - wave(x)) for x in inside), abs(curve.quantile(0.3) + np.cos(0.3 * np.pi))]
        )

    order = np.log(errors(60)[0] / errors(960)[0]) / np.log(959 / 59)
    assert 3.6 < order < 4.4


def test_cubics_are_exact_on_any_instants():
    t = np.array([0.0, 0.1, 0.35, 0.4, 0.9, 1.0])

    def f(x):
        return 2.0 - 3.0 * x + 5.0 * x**2 - 4.0 * x**3

    curve = SampledCurve(t, f(t))
    assert [curve.at(x) for x in (0.05, 0.2, 0.6, 0.95)] == pytest.approx(
        [f(x) for x in (0.05, 0.2, 0.6, 0.95)], rel=1e-14
    )
    assert curve.integral() == pytest.approx(2.0 - 3.0 / 2 + 5.0 / 3 - 1.0, rel=1e-14)


# ---------------------------------------------------------------- jumps, kinks, few samples
def test_beside_a_jump_nothing_overshoots():
    t = np.linspace(0.0, 1.0, 41)
    curve = SampledCurve(t, np.where(t < 0.512, np.sin(t), 5.0 + np.cos(t)))
    inside = np.linspace(0.0, 1.0, 4001)
    values = np.array([curve.at(x) for x in inside])
    before, after = inside <= t[t < 0.512][-1], inside >= t[t >= 0.512][0]
    assert np.abs(values - np.sin(inside))[before].max() < 1e-7
    assert np.abs(values - 5.0 - np.cos(inside))[after].max() < 1e-7
    assert values.min() >= -1e-15
    assert values.max() <= 5.0 + np.cos(0.5)


@pytest.mark.parametrize("begin", [0.02, 0.1, 0.3, 0.97])
def test_a_force_that_is_zero_without_contact_stays_zero_there(begin):
    t = np.linspace(0.0, 2.0, 101)
    curve = SampledCurve(t, np.where((t > begin) & (t < begin + 1.0), np.sin(np.pi * (t - begin)), 0.0))
    assert curve.least() == 0.0
    # both ends lie in an interval of 0.02, known to half of it
    assert curve.time_above(0.0) == pytest.approx(1.0, abs=0.02 + 1e-12)
    assert SampledCurve(t, -curve.values).time_above(0.0) == 0.0


@pytest.mark.parametrize(
    "pulses",
    [
        [0, 0, 5, 0, 0, 0, 9, 3, 0, 0],
        [0, 0, 3, 5, 0, 0, 1, 8, 1, 0],
        [5, 0.1, 7, 0.1, 9, 2, 0.1, 0.2, 9, 9],
        [5, 5, 0.1, 0.1, 6, 7, 0.3, 4, 0.3, 4],
    ],
)
def test_a_force_in_too_few_samples_is_not_said_to_pull(pulses):
    t = np.arange(10.0)
    curve = SampledCurve(t, pulses)
    assert len(SampledCurve(t, -curve.values).spans_above(0.0)[0]) == 0
    assert SampledCurve(t, -curve.values).time_above(0.0) == 0.0


def test_at_a_kink_the_curve_does_not_turn():
    t = np.linspace(-1.0, 1.03, 30)
    curve = SampledCurve(t, np.abs(t))
    assert curve.least() >= 0.0
    # the tip lies between two samples: the error is at most half of that interval
    assert max(abs(curve.at(x) - abs(x)) for x in np.linspace(-1.0, 1.0, 999)) <= 0.5 * (t[1] - t[0])
    assert curve.integral() == pytest.approx((1.0 + 1.03**2) / 2, abs=0.25 * (t[1] - t[0]) ** 2)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_few_samples_are_a_polynomial_of_lower_degree(n):
    t = np.array([0.0, 0.3, 1.0])[:n]
    curve = SampledCurve(t, 1.0 + (t if n == 2 else t**2))
    assert curve.mean() == pytest.approx([1.0, 1.15, 1.0 + 1 / 3][n - 1], rel=1e-14)
    assert curve.quantile(0.5) == pytest.approx([1.0, 1.15, 1.25][n - 1], rel=1e-12)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_near_a_value_that_is_not_finite_there_is_none(bad):
    t = even(60)
    values = wave(t)
    values[[0, 20]] = bad
    curve = SampledCurve(t, values)
    assert not curve.finite
    assert curve.at(t[21]) == values[21]
    for x in np.linspace(0.0, SPAN, 500):  # a value is right or not finite
        got = curve.at(x)
        assert not np.isfinite(got) or abs(got - wave(x)) <= bound(t)
    assert not np.isfinite(curve.at(t[20] + 1e-3))
    assert np.isfinite(curve.at(t[30] + 1e-3))


@pytest.mark.parametrize("t", [[], [0.0, 1.0, 0.9], [1.0, 0.5]])
def test_instants_must_increase(t):
    with pytest.raises(ValueError, match="instant"):
        SampledCurve(t, t)
