"""Bounds hold the truth as often as they say."""

import math

import numpy as np
import pytest

from rattle.studies.ensemble import statistics

pytestmark = [pytest.mark.nojit, pytest.mark.plain]  # NumPy alone
RUNS = 2000


def coverage(draw, estimate, truth):
    """Share of runs in which the bounds hold the truth."""
    found = [estimate(draw()) for _ in range(RUNS)]
    return np.mean([one.low <= truth <= one.high for one in found])


@pytest.mark.parametrize(
    ("estimate", "truth"),
    [
        (statistics.mean, 1.0),
        (lambda x: statistics.quantile(np.sort(x), 0.5), math.log(2.0)),
        (lambda x: statistics.quantile(np.sort(x), 0.95), -math.log(0.05)),
    ],
)
def test_bounds_of_a_skew_distribution_hold_the_truth_nineteen_times_of_twenty(estimate, truth):
    random = np.random.default_rng(1)
    found = coverage(lambda: random.exponential(size=400), estimate, truth)
    assert 0.93 < found < 0.985  # 0.95 +- 3 sd of 2000 runs; order statistics are a little too wide


def test_bounds_of_a_standard_deviation_need_no_normal_distribution():
    random = np.random.default_rng(2)
    for draw, truth in (
        (lambda: random.uniform(-1.0, 1.0, 400), 1 / math.sqrt(3)),
        (lambda: random.normal(size=400), 1.0),
    ):
        assert 0.93 < coverage(draw, statistics.sd, truth) < 0.97


def test_bounds_of_a_share_are_exact_and_count_what_is_not_known_both_ways():
    # Clopper and Pearson: P(X >= 3 | n = 10, low) = P(X <= 3 | n = 10, high) = 0.025
    found = statistics.share(3, 10)
    tail = sum(math.comb(10, k) * found.low**k * (1 - found.low) ** (10 - k) for k in range(3, 11))
    assert tail == pytest.approx(0.025, abs=1e-9)
    tail = sum(math.comb(10, k) * found.high**k * (1 - found.high) ** (10 - k) for k in range(4))
    assert tail == pytest.approx(0.025, abs=1e-9)
    unknown = statistics.share(3, 8, unknown=2)
    assert unknown.value == 0.3
    assert (unknown.low, unknown.high) == (found.low, statistics.share(5, 10).high)


def test_a_quantile_without_enough_values_has_no_bound():
    found = statistics.quantile(np.arange(10.0), 0.95)
    assert found.high == math.inf
    assert found.low <= found.value


def test_few_and_no_values():
    assert math.isnan(statistics.statistics(np.array([math.nan])).mean.value)
    one = statistics.statistics(np.array([2.0, math.nan]))
    assert (one.n, one.mean.value, one.least, one.most) == (1, 2.0, 2.0, 2.0)
    assert math.isnan(one.sd.value)
    assert statistics.sd(np.full(5, 3.0)) == (0.0, 0.0, 0.0)
