"""Equations of contacts that depend on each other: how many do is no matter of rounding, and their forces are least."""

import numpy as np
import pytest

from rattle.equations.complementarity import diagonalise, place_of, solve_least

pytestmark = pytest.mark.nojit


def least(g, b):
    """The number of independent equations, and the solution that is taken."""
    size = len(g)
    system, pivot = np.column_stack([g, b]), np.zeros(size, np.int64)
    solve_least(system, pivot, size, np.abs(np.diag(g)).max())
    return int((pivot >= 0).sum()), np.array([system[place_of(pivot, c), size] for c in range(size)])


@pytest.mark.parametrize("seed", range(40))
def test_forces_of_dependent_contacts_are_those_of_the_pseudoinverse(seed):
    """Rows of a few bodies with contacts that nearly coincide, as those of boxes that are flush."""
    rng = np.random.default_rng(seed)
    rank, size = int(rng.integers(1, 8)), 16
    w = rng.normal(size=(rank, rank))[rng.integers(0, rank, size)] * rng.choice([-1.0, 1.0], (size, 1))
    g = (w + 1e-15 * rng.normal(size=w.shape)) @ np.diag(10.0 ** rng.uniform(-1, 1, rank)) @ w.T
    b = g @ rng.normal(size=size)
    independent, forces = least(g, b)
    assert independent == np.linalg.matrix_rank(g, tol=1e-11 * np.abs(g).max())
    np.testing.assert_allclose(g @ forces, b, atol=1e-10 * np.abs(b).max())
    wanted = np.linalg.pinv(g, rcond=1e-11) @ b
    np.testing.assert_allclose(forces, wanted, atol=1e-6 * np.abs(wanted).max())


@pytest.mark.parametrize("seed", range(20))
def test_the_sign_is_that_of_the_determinant(seed):
    rng = np.random.default_rng(seed)
    g = rng.normal(size=(seed % 7 + 1,) * 2) * 10.0 ** rng.uniform(-6, 0, (seed % 7 + 1, 1))
    system, pivot = np.column_stack([g, np.zeros(len(g))]), np.zeros(len(g), np.int64)
    assert diagonalise(system, pivot, len(g), np.abs(g).max()) == np.sign(np.linalg.det(g))
