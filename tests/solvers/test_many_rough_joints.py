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


FOURBAR = """
format = 1
parameters = {{ since = {since} }}
gravity = ["{fx}*{ramp}", "{fy}*{ramp}"]
ground.points = {{ O = [0, 0], Q = [0.4, 0] }}
bodies.a = {{ points = {{ P = [0, 0], Q = [0.1, 0] }}, mass = 1, inertia = 0.01 }}
bodies.b = {{ points = {{ P = [0, 0], Q = [0.35, 0] }}, mass = 1.5, inertia = 0.02, center = [0.15, 0.01] }}
bodies.c = {{ points = {{ P = [0, 0], Q = [0.25, 0] }}, mass = 0.7, inertia = 0.01 }}
initial.a = {{ angle = {angle}, omega = 0 }}
initial.c = {{ angle = 1.5 }}
joints.A = {{ type = "revolute", connect = ["ground.O", "a.P"], friction = {{ mu = {mu}, pin_radius = {r} }} }}
joints.B = {{ type = "revolute", connect = ["a.Q", "b.P"], friction = {{ mu = {mu}, pin_radius = {r} }} }}
joints.C = {{ type = "revolute", connect = ["b.Q", "c.Q"], friction = {{ mu = {mu}, pin_radius = {r} }} }}
joints.D = {{ type = "revolute", connect = ["ground.Q", "c.P"], friction = {{ mu = {mu}, pin_radius = {r} }} }}
loads.turn = {{ type = "torque", body = "a", torque = "{torque}*{ramp}" }}
"""


RAMPS = [
    "max(0, t - since)", "min(1, max(0, (t - since)/0.05))", "max(0, t - since)**2",
    "0.5*(1 - cos(pi*min(1, max(0, t - since)/0.05)))", "(exp(3*max(0, t - since)) - 1)",  # rounding for a while
]  # fmt: skip


@pytest.mark.parametrize("seed", range(20))
def test_a_mechanism_without_force_begins_to_move_when_its_loads_begin(seed):
    """All joints rest without any force, until all forces begin at once: as from the start on, but later."""
    rng = np.random.default_rng(seed)
    ramp = RAMPS[seed % len(RAMPS)]
    form = {"mu": rng.uniform(0.05, 0.25), "r": rng.uniform(0.003, 0.02), "angle": rng.uniform(0.3, 2.8), "ramp": ramp}
    form |= {"fx": rng.uniform(-9.0, 9.0), "fy": rng.uniform(-9.0, 9.0), "torque": rng.uniform(-1.0, 1.0)}
    ends = []
    for since in (0.0, rng.uniform(0.01, 0.1)):
        run = rt.loads(FOURBAR.format(since=since, **form)).simulate(since + 0.3, t_eval=[0.0, since + 0.3], rtol=1e-9)
        assert run.success, run.message
        ends.append(run["a.angle"][-1])
    assert ends[1] == pytest.approx(ends[0], abs=1e-7)
