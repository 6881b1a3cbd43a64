"""Bounds hold the truth as often as they say."""

import math

import numpy as np
import pytest

from rattle.questions.ensemble import statistics
from rattle.studies.runs.reasons import counted

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


@pytest.mark.parametrize("unit", [1e300, 1e90, 1e-90, 1e-300])
def test_statistics_do_not_depend_on_the_unit(unit):
    values = np.random.default_rng(3).exponential(size=200)
    one, other = statistics.statistics(values), statistics.statistics(unit * values)
    for a, b in ((one.mean, other.mean), (one.sd, other.sd)):
        np.testing.assert_allclose(np.array(b) / unit, a, rtol=1e-12)


def test_reasons_keep_the_numbers_that_they_have_in_common():
    said = [f"parameters.a: {x} is not between min = 0 and max = 5\nmore" for x in (-1, 7.5, 1e9)]
    assert counted([*said, "no start at 0.2 s"]) == {
        "parameters.a: ... is not between min = 0 and max = 5": 3,
        "no start at 0.2 s": 1,
    }
    assert counted(["1 of 3", "2 of 3", "1 of 3"]) == {"... of 3": 3}
