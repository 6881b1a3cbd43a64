"""Points of every design are where theory says, and the same in whatever pieces they are made."""

import pickle
import threading
import warnings
from itertools import pairwise

import numpy as np
import pytest
from scipy import stats
from scipy.stats import qmc

from rattle.questions.ensemble.sampling import BELOW_ONE, BITS, DESIGNS, MOST_DRAWS, points

pytestmark = [pytest.mark.nojit, pytest.mark.plain]  # NumPy alone

SEQUENCES = ("sobol", "halton")
ENDLESS = (*SEQUENCES, "random")  # whose points do not depend on their number


def every(design, seed=1, draws=3, n=1000):
    return points(design, seed, draws, n).points(0, n)


# ---------------------------------------------------------------- the same bits
@pytest.mark.parametrize("design", DESIGNS)
@pytest.mark.parametrize("draws", [1, 3, 4, 5, 21])
def test_points_do_not_depend_on_the_pieces_and_their_order(design, draws):
    n = 1000
    whole = every(design, 7, draws, n)
    assert whole.shape == (n, draws)
    cuts = [0, 1, 2, 3, 64, 65, 100, 613, 999, n]
    pieces = list(pairwise(cuts))
    for order in (pieces, pieces[::-1], [pieces[k] for k in np.random.default_rng(0).permutation(len(pieces))]):
        made = points(design, 7, draws, n)
        for first, last in order:
            assert np.array_equal(made.points(first, last), whole[first:last])
    assert np.array_equal(points(design, 7, draws, n).points(613, 614), whole[613:614])


@pytest.mark.parametrize("design", ENDLESS)
def test_points_do_not_depend_on_their_number(design):
    assert np.array_equal(every(design, n=1234)[:100], every(design, n=100))


@pytest.mark.parametrize("design", DESIGNS)
def test_pieces_may_be_empty_and_may_overlap(design):
    made = points(design, 0, 2, 50)
    assert made.count == 50
    assert made.points(20, 20).shape == (0, 2)
    assert np.array_equal(made.points(10, 30)[10:], made.points(20, 40)[:10])
    assert np.array_equal(made.points(0, 50), made.points(0, 50))


@pytest.mark.parametrize("design", DESIGNS)
def test_points_survive_pickling(design):
    made = points(design, 4, 3, 64)
    made.points(5, 9)
    sent = pickle.dumps(made)
    assert len(sent) < 200  # what is asked, not the points
    assert np.array_equal(pickle.loads(sent).points(3, 50), made.points(3, 50))


@pytest.mark.parametrize("design", SEQUENCES)
def test_threads_do_not_disturb_each_other(design):
    made, whole = points(design, 4, 3, 4000), every(design, 4, 3, 4000)
    wrong = []

    def work(own):
        for first in np.random.default_rng(own).integers(0, 3990, 100):
            if not np.array_equal(made.points(int(first), int(first) + 10), whole[first : first + 10]):
                wrong.append(first)

    threads = [threading.Thread(target=work, args=(n,)) for n in range(4)]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    assert not wrong


@pytest.mark.parametrize("design", DESIGNS)
def test_seeds_make_different_points(design):
    seeds = (0, 1, 2**31, 2**64, 2**200 + 1)
    first = {every(design, seed, 2, 16).tobytes() for seed in seeds}
    assert len(first) == len(seeds)
    assert np.array_equal(every(design, np.int64(5)), every(design, 5))


# ---------------------------------------------------------------- where they are
@pytest.mark.parametrize("design", DESIGNS)
def test_points_are_uniform_in_every_dimension(design):
    made = every(design, 3, 6, 5000)
    assert np.all((made >= 0.0) & (made <= BELOW_ONE))
    for row in made.T:
        assert stats.kstest(row, "uniform").pvalue > 1e-3
    assert np.abs(np.corrcoef(made.T) - np.eye(6)).max() < 0.06  # four standard errors of independent points


def test_random_points_are_independent_of_their_neighbours():
    made = every("random", 3, 3, 20_000)  # three of the four numbers of each block
    following = np.array([stats.pearsonr(a, b)[0] for a in made[:-1].T for b in made[1:].T])
    assert np.abs(following).max() < 4.0 / np.sqrt(len(made))


def test_random_points_are_those_of_philox_as_published():
    key = np.random.SeedSequence(11).generate_state(2, np.uint64)
    stream = np.random.Generator(np.random.Philox(key=key)).random(4 * 10)
    assert np.array_equal(every("random", 11, 4, 10), stream.reshape(10, 4))


def test_sobol_points_are_a_net():
    made = every("sobol", 2, 2, 1024)
    for boxes in [(1, 1024), (2, 512), (32, 32), (1024, 1)]:  # elementary boxes of area 1/1024 hold one point each
        places = (made * boxes).astype(int)
        assert len(np.unique(places, axis=0)) == 1024


def test_halton_points_fill_the_intervals_of_their_bases():
    made = every("halton", 2, 3, 30**2)
    for row, base in zip(made.T, (2, 3, 5), strict=True):
        counts = np.bincount((row * base**2).astype(int), minlength=base**2)
        assert np.ptp(counts[: base**2]) <= 1


@pytest.mark.parametrize("n", [1, 10, 1000])
def test_latin_hypercube_has_one_value_in_each_interval(n):
    for row in every("lhs", 2, 4, n).T:
        assert sorted((row * n).astype(int)) == list(range(n))


@pytest.mark.parametrize("design", SEQUENCES)
def test_sequences_fill_the_cube_more_evenly_than_random_points(design):
    assert qmc.discrepancy(every(design, 1, 4, 1024)) < 0.2 * qmc.discrepancy(every("random", 1, 4, 1024))


@pytest.mark.parametrize("design", DESIGNS)
@pytest.mark.parametrize("n", [1, 2, 3, 1000])
def test_nobody_is_warned_of_what_he_cannot_change(design, n):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        made = points(design, 1, 2, n)
        made.points(0, n)
        made.points(n - 1, n)


# ---------------------------------------------------------------- what cannot be
@pytest.mark.parametrize(
    ("given", "error", "match"),
    [
        (("sobl", 0, 2, 8), ValueError, "unknown design 'sobl'; did you mean 'sobol'"),
        ((None, 0, 2, 8), ValueError, "unknown design None; known: sobol, lhs, halton, random"),
        (("sobol", -1, 2, 8), ValueError, "seed must be an integer from 0 on"),
        (("sobol", 1.5, 2, 8), TypeError, "seed must be an integer, got 1.5"),
        (("sobol", None, 2, 8), TypeError, "seed must be an integer, got None"),
        (("sobol", True, 2, 8), TypeError, "seed must be an integer, got True"),
        (("sobol", 0, 0, 8), ValueError, "draws must be from 1"),
        (("sobol", 0, 2, 0), ValueError, "n must be from 1"),
        (("sobol", 0, 2, 2.0), TypeError, "n must be an integer"),
        (("sobol", 0, 2, 2**BITS + 1), ValueError, f"n must be from 1 to {2**BITS}"),
        (("random", 0, 2, 2**BITS + 1), ValueError, f"n must be from 1 to {2**BITS}"),
        (("sobol", 0, 21202, 8), ValueError, "design 'sobol' has at most 21201 independent parameters, got 21202"),
        (("halton", 0, 1001, 8), ValueError, "design 'halton' has at most 1000 independent parameters"),
        (("lhs", 0, 100, 10**7), ValueError, r"'lhs' makes all its points at once: .* 32.0 GB, .* take 'sobol'"),
    ],
)
def test_what_cannot_be_is_refused_with_a_reason(given, error, match):
    with pytest.raises(error, match=match):
        points(*given)


def test_as_many_parameters_as_scipy_has_direction_numbers_for():
    assert MOST_DRAWS["sobol"] == qmc.Sobol.MAXDIM
    assert every("sobol", draws=2000, n=4).shape == (4, 2000)


def test_sequence_that_was_stopped_starts_anew(monkeypatch):
    made, whole = points("halton", 1, 2, 100), every("halton", 1, 2, 100)
    engine = made._engine
    whole_step = engine.random

    def stopped(n):
        whole_step(n)
        raise KeyboardInterrupt

    monkeypatch.setattr(engine, "random", stopped)
    with pytest.raises(KeyboardInterrupt):
        made.points(0, 10)
    monkeypatch.undo()
    assert np.array_equal(made.points(5, 100), whole[5:])


@pytest.mark.parametrize(("first", "last"), [(-1, 3), (0, 9), (5, 4), (9, 9)])
@pytest.mark.parametrize("design", DESIGNS)
def test_points_that_are_not_there_are_refused(design, first, last):
    with pytest.raises(ValueError, match="are not among 0 to 8"):
        points(design, 0, 2, 8).points(first, last)


def test_last_points_of_the_longest_sequence_can_be_reached():
    made = points("random", 0, 3, 2**BITS)
    assert np.array_equal(made.points(2**BITS - 3, 2**BITS)[2:], made.points(2**BITS - 1, 2**BITS))
