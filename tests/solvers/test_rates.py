"""Orders of the steppers and of their dense output, seen as slopes of the error against the step.

The exact solution: a bar that swings about its end, sin(angle/2) = k sn(K(k) + w t, k) from rest at the amplitude.
"""

import math

import numpy as np
import pytest
from scipy.integrate._ivp import dop853_coefficients
from scipy.special import ellipj, ellipk

import rattle as rt
from rattle.solvers import dop853_tableau

LENGTH, AMPLITUDE, T_END = 0.5, 2.0, 3.0
W = math.sqrt(1.5 * 9.81 / LENGTH)  # of small swings


def pendulum() -> rt.Mechanism:
    """Held by two rows, so that the projection after every step takes part."""
    m = rt.Mechanism("bar", gravity=[0, -9.81]).ground(O=[0, 0]).bar("bar", "O", "P", length=LENGTH, mass=1)
    return m.revolute("O", "ground.O", "bar.O").initial("bar", angle=AMPLITUDE - math.pi / 2, omega=0)


def exact(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angle from the vertical and its rate."""
    k = math.sin(AMPLITUDE / 2)
    sn, cn, _, _ = ellipj(ellipk(k**2) + W * np.asarray(t), k**2)
    return 2 * np.arcsin(k * sn), 2 * k * W * cn


def error(times: np.ndarray, **how) -> float:
    r = pendulum().simulate(T_END, t_eval=times, **how)
    assert r.success, r.message
    angle, omega = exact(times)
    return max(np.abs(r["bar.angle"] + math.pi / 2 - angle).max(), np.abs(r["bar.omega"] - omega).max())


def slope(steps: np.ndarray, errors: list[float]) -> float:
    return float(np.polyfit(np.log(steps), np.log(errors), 1)[0])


@pytest.mark.nojit
@pytest.mark.parametrize("name", ["A", "B", "C", "D", "E3", "E5"])
def test_coefficients_of_dop853_are_those_that_scipy_has(name):
    assert (getattr(dop853_tableau, name) == getattr(dop853_coefficients, name)).all()


@pytest.mark.nojit
def test_the_exact_solution_is_one():
    t = np.linspace(0, T_END, 3001)
    angle, omega = exact(t)
    assert angle[0] == pytest.approx(AMPLITUDE)
    assert np.gradient(angle, t)[1:-1] == pytest.approx(omega[1:-1], abs=1e-3)
    assert omega**2 / 2 - W**2 * np.cos(angle) == pytest.approx(
        np.full(len(t), -(W**2) * math.cos(AMPLITUDE)), abs=1e-9
    )


def test_rk4_has_order_4():
    steps = T_END / np.array([600, 1200, 2400, 4800])
    errors = [error(np.array([T_END]), method="rk4", step=h) for h in steps]
    assert slope(steps, errors) == pytest.approx(4.0, abs=0.1)


def test_dop853_has_order_8():
    # the tolerance is out of the way, so that all steps but the first are of the largest size; errors 1e-6 to 1e-12,
    # where those of order 9 still count
    steps = T_END / np.array([40, 56, 80, 112, 160])
    errors = [error(np.array([T_END]), method="dop853", step=h, rtol=0.9, atol=1e3) for h in steps]
    assert 7.8 < slope(steps, errors) < 9.8


def test_dop853_keeps_its_tolerance():
    tolerances = 10.0 ** -np.arange(5, 13)
    errors = [error(np.array([T_END]), rtol=tol, atol=tol) for tol in tolerances]
    assert all(e < 300 * tol for e, tol in zip(errors, tolerances, strict=True))  # an error per step, some 50 steps
    assert slope(tolerances, errors) == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize(("method", "counts", "order"), [("rk4", (300, 600, 1200), 4), ("dop853", (40, 56, 80), 7)])
def test_dense_output_has_its_order(method, counts, order):
    """Between the steps: Hermite's cubic has error h^4, the interpolant of dop853, of order 7, at least h^7."""
    steps = T_END / np.array(counts)
    loose = {} if method == "rk4" else {"rtol": 0.9, "atol": 1e3}
    between = np.linspace(0.1, T_END - 0.1, 977)
    errors = [error(between, method=method, step=h, **loose) for h in steps]
    assert slope(steps, errors) > order - 0.4


def test_dense_output_changes_no_step():
    few = pendulum().simulate(T_END, t_eval=[T_END])
    many = pendulum().simulate(T_END, t_eval=np.linspace(0, T_END, 1234))
    assert many["bar.angle"][-1] == few["bar.angle"][-1]
    assert many.stats["steps"] == few.stats["steps"]
