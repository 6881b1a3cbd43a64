"""Orders of the steppers and of their dense output, seen as slopes of the error against the step.

The exact solution: a bar that swings about its end, sin(angle/2) = k sn(K(k) + w t, k) from rest at the amplitude.
"""

import math

import numpy as np
import pytest
from scipy.integrate._ivp import dop853_coefficients
from scipy.special import ellipj, ellipk

import rattle as rt
from rattle.registry import Kind, kinds, names
from rattle.solvers import dop853_tableau
from rattle.solvers.stepper import FREE

LENGTH, AMPLITUDE, T_END = 0.5, 2.0, 3.0
W = math.sqrt(1.5 * 9.81 / LENGTH)  # of small swings


def pendulum(contacts: str = FREE) -> rt.Mechanism:
    """Held by two rows, so that the projection after every step takes part.

    With set-valued contacts a ring falls around a pin that it never touches: the motion is as smooth as without.
    """
    m = rt.Mechanism("bar", gravity=[0, -9.81]).ground(O=[0, 0]).bar("bar", "O", "P", length=LENGTH, mass=1)
    m = m.revolute("O", "ground.O", "bar.O").initial("bar", angle=AMPLITUDE - math.pi / 2, omega=0)
    if contacts == FREE:
        return m
    m = m.bar("ring", "C", "D", length=LENGTH, mass=1)
    return m.revolute("far", "ground.O", "ring.C", clearance=1e3, contact="impact").initial("ring", x=0, y=0, angle=0)


def exact(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angle from the vertical and its rate."""
    k = math.sin(AMPLITUDE / 2)
    sn, cn, _, _ = ellipj(ellipk(k**2) + W * np.asarray(t), k**2)
    return 2 * np.arcsin(k * sn), 2 * k * W * cn


def error(times: np.ndarray, contacts: str = FREE, **how) -> float:
    r = pendulum(contacts).simulate(T_END, t_eval=times, **how)
    assert r.success, r.message
    assert not r.events
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


def order_seen(stepper: Kind, shares: tuple[float, ...], times: np.ndarray) -> float:
    """Slope over steps that are shares of one with errors of 1e-3 to 1e-6, by order; tolerances are out of the way."""
    leaf = stepper.leaf
    longest = T_END / (40 * 15 ** ((8 - leaf.order) / 4))
    loose = {"rtol": 0.9, "atol": 1e3} if leaf.adaptive else {}
    steps = longest * np.array(shares)
    errors = [error(times, leaf.works_with[0], method=stepper.name, step=h, **loose) for h in steps]
    return slope(steps, errors)


@pytest.mark.parametrize("stepper", kinds("stepper").values(), ids=lambda one: one.name)
def test_stepper_has_its_order(stepper):
    # more than its order: terms above the first still count in the long steps of dop853, and Moreau-Jean has order 1
    # where contacts close and does better in smooth motion
    more = {8: 1.8, 1: 1.0}.get(stepper.leaf.order, 0.2)
    seen = order_seen(stepper, (1.0, 0.7, 0.5, 0.36, 0.25), np.array([T_END]))
    assert stepper.leaf.order - 0.2 < seen < stepper.leaf.order + more


@pytest.mark.nojit
def test_files_of_steppers_are_named_after_them():
    assert set(names("stepper")) == set(kinds("stepper"))


def test_dop853_keeps_its_tolerance():
    tolerances = 10.0 ** -np.arange(5, 13)
    errors = [error(np.array([T_END]), rtol=tol, atol=tol) for tol in tolerances]
    assert all(e < 300 * tol for e, tol in zip(errors, tolerances, strict=True))  # an error per step, some 50 steps
    assert slope(tolerances, errors) == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize(("name", "order"), [("rk4", 4), ("dop853", 7), ("event", 7), ("radau", 5)])
def test_dense_output_has_its_order(name, order):
    """Between the steps: Hermite's cubic has error h^4, that of radau h^5, that of dop853, of order 7, at least h^7."""
    assert order_seen(kinds("stepper")[name], (1.0, 0.7, 0.5), np.linspace(0.1, T_END - 0.1, 977)) > order - 0.4


def test_dense_output_changes_no_step():
    few = pendulum().simulate(T_END, t_eval=[T_END])
    many = pendulum().simulate(T_END, t_eval=np.linspace(0, T_END, 1234))
    assert many["bar.angle"][-1] == few["bar.angle"][-1]
    assert many.stats["steps"] == few.stats["steps"]
