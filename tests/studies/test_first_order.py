"""First-order indices from samples: closed forms, whatever the form of an effect, with bounds that hold them."""

import math

import numpy as np
import pytest

import rattle as rt
from rattle.questions.ensemble.fields import Field, Fields
from rattle.questions.ensemble.first_order import first_order
from rattle.questions.ensemble.sampling import points

pytestmark = pytest.mark.nojit
T = math.pi / 3
OF = "final(block.x)"
SPRING = """
format = 1
[parameters]
k = { value = 15, tol = 6 }
mass = { value = 1, tol = 0.3 }
x0 = { value = 0.5, tol = 0.1 }
[ground.points]
O = [0, 0]
[bodies.block]
points = { P = [0, 0] }
mass = "mass"
inertia = 1
[joints.guide]
type = "prismatic"
connect = ["ground.O", "block.P"]
[loads.s]
type = "spring"
connect = ["ground.O", "block.P"]
stiffness = "k"
free_length = 0
[initial]
block = { x = "x0", vx = 0 }
"""


def field(name, dist="uniform", nominal=0.0, tol=1.0):
    return Field(name, "", nominal, tol, dist, nominal - tol, nominal + tol)


def found(fields, f, n=1024, seed=0, design="sobol", draw=None, **more):
    """Indices of f(columns) from n samples of the fields."""
    every = Fields(tuple(fields), tuple(range(len(fields))) if draw is None else draw)
    columns = every.values(points(design, seed, every.draws, n).points(0, n))
    return first_order(every, list(columns), f(*columns), **more)


def quadratic(a, b, c):
    return a + 2 * b**2 + 1.5 * a * b + 0 * c


# variances of a, 2 b^2, 1.5 a b over [-1, 1]: 1/3, 4*4/45, 2.25/9
QUADRATIC = np.array([1 / 3, 16 / 45, 0.0]) / (1 / 3 + 16 / 45 + 0.25)


def test_an_oscillator_has_the_indices_of_its_closed_form():
    e = rt.loads(SPRING).ensemble(1024, [OF], t_end=T, seed=1)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    k, m, x0 = np.meshgrid(15 + 6 * nodes, 1 + 0.3 * nodes, 0.5 + 0.1 * nodes, indexing="ij")
    x, w = x0 * np.cos(np.sqrt(k / m) * T), weights / 2
    mean = np.einsum("ijk,i,j,k", x, w, w, w)
    variance = np.einsum("ijk,i,j,k", (x - mean) ** 2, w, w, w)
    alone = [np.einsum(to, x, w, w) - mean for to in ("ijk,j,k->i", "ijk,i,k->j", "ijk,i,j->k")]
    exact = [float(w @ one**2 / variance) for one in alone]
    assert min(exact) < 0.05 < 0.2 < max(exact)  # k and mass pass the turning point: not monotone
    got = e.contributions(OF)
    assert got.names == ("k", "mass", "x0")
    assert [one.value for one in got.indices] == pytest.approx(exact, abs=4e-3)
    assert got.explained.value == pytest.approx(sum(exact), abs=5e-3)
    for one, true in zip((*got.indices, got.explained), (*exact, sum(exact)), strict=True):
        assert one.low <= true <= one.high


def test_effects_that_rise_and_fall_again_count_and_interactions_do_not():
    got = found([field("a"), field("b"), field("c")], quadratic)
    assert [one.value for one in got.indices] == pytest.approx(QUADRATIC, abs=4e-3)
    assert got.explained.value == pytest.approx(QUADRATIC.sum(), abs=4e-3)
    only = found([field("a", "normal"), field("b", "triangular")], lambda a, b: a * b, seed=3, design="random")
    assert all(one.low == 0.0 and one.value < 0.05 for one in only.indices)


@pytest.mark.plain
@pytest.mark.parametrize("design", ["lhs", pytest.param("random", marks=pytest.mark.long)])
def test_bounds_hold_the_index_in_nineteen_of_twenty_ensembles(design):
    fields, held = [field("a"), field("b"), field("c")], np.zeros(3)
    for seed in range(30):
        got = found(fields, quadratic, n=400, seed=seed, design=design)
        held += [one.low <= true <= one.high for one, true in zip(got.indices, QUADRATIC, strict=True)]
    assert (held >= 25).all()  # 28.5 are expected, with a standard deviation of 1.2


@pytest.mark.parametrize("dist", ["uniform", "normal", "triangular"])
def test_shares_of_a_sum_are_those_of_the_variances(dist):
    fields = [field("a", dist), field("b", "uniform", 5.0, 0.2)]
    got = found(fields, lambda a, b: 3 * a - 10 * b, n=64, design="random")
    parts = np.array([3 * fields[0].sd, 10 * fields[1].sd]) ** 2
    assert [one.value for one in got.indices] == pytest.approx(parts / parts.sum(), abs=1e-5)
    assert got.explained.low == pytest.approx(1.0, abs=1e-9)


def test_parts_that_are_made_together_are_one_contributor_and_tables_are_steps():
    table = Field("t", "", 2.0, 1.0, "table", 1.0, 3.0, (1.0, 2.0, 3.0), (0.25, 0.25, 0.5))
    fields = [field("a"), table, field("b")]
    got = found(fields, lambda a, t, b: a + b + (t == 2.0), draw=(0, 1, 0))
    assert got.names == ("a, b", "t")
    together, alone = 4 / 3, 0.25 * 0.75  # a + b = 2 a moves as one
    shares = np.array([together, alone]) / (together + alone)
    assert [one.value for one in got.indices] == pytest.approx(shares, abs=4e-3)
    assert got.explained.value == pytest.approx(1.0, abs=1e-9)


def test_a_few_outliers_do_not_decide():
    fields = [field("a"), field("b")]

    def hit(a, b):
        return 3 * a + b + 1e9 * (np.arange(len(a)) == 7)

    got = found(fields, hit)
    clean = found(fields, lambda a, b: 3 * a + b, ranks=True)
    assert (got.ranks, clean.ranks) == (True, True)
    assert not found(fields, lambda a, b: 3 * a + b).ranks
    assert [one.value for one in got.indices] == pytest.approx([one.value for one in clean.indices], abs=0.01)
    assert found(fields, hit, ranks=False).explained.value < 0.1


def test_what_cannot_be_told_is_refused():
    fields = [field("a"), field("b")]
    with pytest.raises(ValueError, match=r"8 samples with a finite value are too few to tell 2 contributors apart.*9"):
        found(fields, lambda a, b: np.where(np.arange(len(a)) < 8, a, np.nan), n=50)
    with pytest.raises(ValueError, match="all 64 samples have the value 2: nothing varies"):
        found(fields, lambda a, b: 0 * a + 2, n=64)
    table = Field("t", "", 1.0, 1.0, "table", 1.0, 2.0, (1.0, 2.0), (0.5, 0.5))
    with pytest.raises(ValueError, match="a parameter has the same value in all samples that could be run"):
        found([field("a"), table], lambda a, t: np.where(t == 1.0, a, np.nan))
