"""The shipped table of oil films against solutions of Reynolds' equation, and these against closed forms."""

import math

import numpy as np
import pytest

from oil_films import film, parts
from rattle.elements.film_table import NODES, RATIOS, directions, eccentricities, nodes
from rattle.elements.short_film import short_integrals, short_peak
from rattle.questions.film.build_table import full_films, potential
from rattle.questions.film.reynolds import Grid, cavitated_pressure, solve_film

pytestmark = [pytest.mark.nojit, pytest.mark.plain]


@pytest.mark.parametrize("ratio", [0.05, 0.5, 1.0, 2.0])
def test_a_full_film_about_the_centre_has_the_damping_of_the_closed_form(ratio):
    state = solve_film(0.0, 0.4, ratio, full=True, fine=(64, 32))
    known = math.pi * 3 * (1 - math.tanh(ratio) / ratio) / ratio**2
    assert state.normal == pytest.approx(known * math.cos(0.4), rel=2e-5)
    assert state.tangential == pytest.approx(known * math.sin(0.4), rel=2e-5)
    assert state.peak == pytest.approx(1.5 * (1 - 1 / math.cosh(ratio)) * 2 / ratio**2, rel=1e-4)


@pytest.mark.parametrize(("e", "alpha"), [(0.3, 1.0), (0.8, 0.5), (0.8, 2.5), (0.95, 1.5)])
def test_a_very_short_film_is_the_closed_form(e, alpha):
    state = solve_film(e, alpha, 0.005)
    a, b, s = e * math.cos(alpha), -e * math.sin(alpha), math.sqrt(1 - e * e)
    _, first, second = short_integrals.python(a, b, s)
    along = state.normal * math.cos(alpha) + state.tangential * math.sin(alpha)
    across = state.tangential * math.cos(alpha) - state.normal * math.sin(alpha)
    # the volumes leave 1e-4, the length of the bearing (L/D)^2/(1 - e)
    assert math.hypot(along - first, across - second) < 1e-3 * math.hypot(first, second)
    assert state.peak == pytest.approx(short_peak.python(e, alpha), rel=1e-3)
    assert state.leakage == pytest.approx(1.0, rel=1e-3)


def test_a_film_has_no_tension_and_leaves_no_flow_unbalanced():
    grid = Grid(0.7, 1.0, 64, 8)
    pressure = cavitated_pressure(grid, 2.0)
    rest = grid.outflow(pressure) - grid.source(2.0)[:, None] * grid.weight
    assert pressure.min() == 0.0
    assert np.abs(rest[pressure > 0]).max() < 1e-13
    assert rest[pressure == 0].min() >= 0.0  # where the film is torn, oil would be missing


@pytest.mark.parametrize(
    ("ratio", "e", "degrees", "normal", "tangential"),
    [  # an independent two-dimensional program, accurate to 1e-4
        (0.25, 0.3, 60, 2.029872, 1.814304),
        (0.5, 0.6, 90, 2.20789, 2.474626),
        (0.5, 0.9, 30, 181.6787, 8.383628),
        (0.5, 0.98, 105, 11.2787, 7.52553),
        (1, 0.5, 120, -0.057571, 0.933766),
        (1, 0.8, 90, 3.562693, 2.664214),
        (1, 0.95, 0, 245.773, 0.0),
        (1, 0.98, 150, -0.196555, 0.308710),
    ],
)
def test_finite_films_of_another_program(ratio, e, degrees, normal, tangential):
    found = parts(film(ratio=ratio), e, math.radians(degrees))
    assert np.hypot(*(found - (normal, tangential))) < 1e-3 * math.hypot(normal, tangential)


def test_random_nodes_of_the_table_are_what_they_are_said_to_be():
    rng = np.random.default_rng(5)
    for _ in range(10):
        i, j, k = rng.integers(len(RATIOS)), rng.integers(1, NODES), rng.integers(NODES)
        ratio, e = float(RATIOS[i]), float(eccentricities()[j])
        alpha = float(directions(e)[k])
        state = solve_film(e, alpha, ratio, fine=(256, 16))
        # coarser volumes than those of the table
        assert potential(state, e, alpha) == pytest.approx(nodes()["potential"][i, j, k], abs=2e-3)
        assert math.log(state.peak / short_peak.python(e, alpha)) == pytest.approx(nodes()["peak"][i, j, k], abs=5e-3)
        assert math.log(state.leakage) == pytest.approx(nodes()["leakage"][i, j, k], abs=5e-3)


def test_between_its_nodes_the_table_is_the_solution():
    rng = np.random.default_rng(6)
    for _ in range(8):
        ratio, e, alpha = math.exp(rng.uniform(-3.2, 0.69)), 1 - 10 ** rng.uniform(-2.5, 0), math.pi * rng.random()
        state = solve_film(e, alpha, ratio, fine=(768, 24))
        known = np.array([state.normal, state.tangential])
        one = film(ratio=ratio)
        assert np.hypot(*(parts(one, e, alpha) - known)) < 1e-3 * np.hypot(*known)
        c, v = one.clearance, 1e-3
        motion = e * c, 0.0, v * math.cos(alpha), v * math.sin(alpha)
        assert one.peak_pressure(*motion) == pytest.approx(
            state.peak * one.viscosity * one.length**2 * v / c**3, rel=5e-3
        )
        assert one.leakage(*motion) == pytest.approx(state.leakage * 2 * one.radius * one.length * v, rel=5e-3)


def test_without_cavitation_too():
    for ratio, e in ((0.3, 0.42), (1.2, 0.9)):
        along, across = full_films(ratio, e, np.zeros(0))[1]
        one = film(cavitation="full", ratio=ratio)
        np.testing.assert_allclose(parts(one, e, 0.0), [along.normal, 0.0], rtol=1e-3, atol=1e-9)
        np.testing.assert_allclose(parts(one, e, math.pi / 2), [0.0, across.tangential], rtol=1e-3, atol=1e-9)


def test_shorter_bearings_than_those_of_the_table_go_over_to_the_short_law():
    for e, alpha in ((0.3, 1.0), (0.9, 0.3), (0.95, 1.6)):
        state = solve_film(e, alpha, 1 / 32, fine=(256, 16))
        known = np.array([state.normal, state.tangential])
        assert np.hypot(*(parts(film(ratio=1 / 32), e, alpha) - known)) < 1e-3 * np.hypot(*known)
