"""Mechanisms in which every pin rubs: all of them come to rest at once, and one could hold the others."""

import numpy as np
import pytest

import rattle as rt


def leg(friction):
    """Jansen's leg without its motor."""
    m = rt.load(rt.examples()["jansen_leg"])
    return m.set({**{f"joints.{name}.friction": friction for name in m.model.joints}, "drivers": None})


@pytest.mark.parametrize(("mu", "radius"), [(0.1, 0.02), (0.3, 0.02), (0.5, 0.005)])
def test_a_leg_swings_to_rest_as_with_a_smooth_law(mu, radius):
    """The limit of friction that is regularised, which needs no modes; at rest that creeps on at less than v1."""
    t = np.linspace(0.0, 2.5, 26)
    rubs = leg({"model": "coulomb", "mu": mu, "pin_radius": radius}).simulate(t_eval=t)
    smooth = leg({"model": "ambrosio", "mu": mu, "v0": 1e-6, "v1": 1e-5, "pin_radius": radius}).simulate(t_eval=t)
    assert rubs.success, rubs.message
    assert rubs["crank.angle"] == pytest.approx(smooth["crank.angle"], abs=5e-4)
    assert np.abs(rubs["energy.balance"]).max() < 1e-8 * rubs["energy.kinetic"].max()


def test_a_leg_that_its_friction_holds_stays():
    held = leg({"model": "coulomb", "mu": 0.5, "pin_radius": 0.08}).simulate(t_end=1.0)
    assert held.success, held.message
    assert np.abs(held["crank.omega"]).max() < 1e-10
    assert np.ptp(held["crank.angle"]) < 1e-10
