"""How the mean of an output changes with the parameters: closed forms, and bounds that hold them."""

import numpy as np
import pytest

import rattle as rt
from rattle.questions.ensemble.fields import Field, Fields
from rattle.questions.ensemble.mean_slopes import mean_slopes
from rattle.questions.ensemble.sampling import points

G = 9.81
BLOCK = """
format = 1
gravity = [0, -9.81]
parameters = { mu = { value = 0.2, tol = 0.05 }, v = { value = 1.0, tol = 0.3 } }
ground.points.O = [0, 0]
bodies.block = { points = { C = [0, 0] }, mass = 2, inertia = 1 }
[joints.rail]
type = "prismatic"
connect = ["ground.O", "block.C"]
axis = 0
friction = { model = "coulomb", mu = "mu" }
[initial]
block = { x = 0, vx = "v" }
"""


def test_the_way_of_a_block_that_rubs_to_rest_has_its_closed_form():
    """x = v^2/(2 mu g): over uniform fields, Cov(x, v)/Var(v) = 2 v0 E(1/mu)/(2 g), and so on."""
    e = rt.loads(BLOCK).ensemble(2048, ["final(block.x)"], t_end=1.5)
    slopes = e.slopes("final(block.x)")
    inverse = np.log(0.25 / 0.15) / 0.1  # the mean of 1/mu
    by_v = 2.0 * 1.0 * inverse / (2.0 * G)
    by_mu = (1.0 - 0.2 * inverse) / (0.05**2 / 3.0) * (1.0 + 0.3**2 / 3.0) / (2.0 * G)
    assert set(slopes) == {"mu", "v"}
    for name, want in (("v", by_v), ("mu", by_mu)):
        value, low, high = slopes[name]
        assert value == pytest.approx(want, rel=2e-3)
        assert low < want < high
    assert e.slopes("final(block.x)") == slopes


def test_bounds_hold_the_slopes_of_what_scatters():
    """Of 1.5 a + sin(3 b) and noise of the same size, from 80 draws: 95 % of the bounds hold them."""
    fields = Fields(
        (Field("a", "", 0.0, 1.0, "uniform", -1.0, 1.0), Field("b", "", 2.0, 0.5, "normal", 1.5, 2.5)), (0, 1)
    )
    held = np.zeros(2)
    nodes = fields.fields[1].quantile((np.arange(100_000) + 0.5) / 100_000)
    by_b = np.cov(np.sin(3.0 * nodes), nodes)[0, 1] / nodes.var()
    for seed in range(200):
        a, b = fields.values(points("random", seed, 2, 80).points(0, 80))
        noise = np.random.default_rng(seed).normal(size=80)
        found = mean_slopes(fields, [a, b], 1.5 * a + np.sin(3.0 * b) + noise)
        held += [low < want < high for (_, low, high), want in zip(found.values(), (1.5, by_b), strict=True)]
    assert (held >= 180).all()
    assert (held < 200).any()


def test_few_samples_and_constant_parameters_are_refused():
    fields = Fields((Field("a", "", 0.0, 1.0, "uniform", -1.0, 1.0),), (0,))
    with pytest.raises(ValueError, match="too few for 1 slopes; run at least 6"):
        mean_slopes(fields, [np.linspace(-1.0, 1.0, 5)], np.arange(5.0))
    with pytest.raises(ValueError, match="the same value in all samples"):
        mean_slopes(fields, [np.zeros(9)], np.arange(9.0))


def test_a_value_that_was_drawn_once_has_no_bounds():
    values, shares = (0.8, 1.2), (0.999, 0.001)
    fields = Fields((Field("a", "", 0.8, 0.4, "table", 0.8, 1.2, values, shares),), (0,))
    a = np.where(np.arange(200) == 7, 1.2, 0.8)
    slope = mean_slopes(fields, [a], a**2 + np.random.default_rng(0).normal(size=200))["a"]
    assert slope.low == -np.inf
    assert slope.high == np.inf


def test_values_that_are_given_twice_and_outputs_that_do_not_vary():
    values = (0.8, 0.8, 1.2, 1.4)
    fields = Fields((Field("a", "", 1.0, 0.4, "table", 0.8, 1.4, values, (0.25,) * 4),), (0,))
    a = np.tile(values, 64)
    slope = mean_slopes(fields, [a], 3.0 * a)["a"]
    assert slope.value == pytest.approx(3.0)
    assert mean_slopes(fields, [a], 3.0 + 1e-15 * a)["a"] == (0.0, 0.0, 0.0)
