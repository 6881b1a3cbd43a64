"""Steps are no longer than a stiff contact allows: what lies within them is as right as their ends."""

import numpy as np
import pytest

import rattle as rt

STIFFNESS, MASS = 1e8, 0.5  # natural frequency 14 000 rad/s under a load that changes within seconds
AT_REST = f"""
format = 1
gravity = [0, 0]
[ground.points]
O = [0, 0]
[bodies.block]
points = {{ C = [0, 0] }}
mass = {MASS}
inertia = 1
[joints.guide]
type = "prismatic"
connect = ["ground.O", "block.C"]
HELD
[loads.push]
type = "force"
at = "block.C"
force = ["-4 - 2*sin(7*t)", 0]
[initial]
block = {{ x = 0, vx = 0 }}
"""
LAW = f"stiffness = {STIFFNESS}, exponent = 1, restitution = 0.4"
STOP = f'stop = {{ min = 0, contact = {{ model = "exact", {LAW} }} }}'
SPRING = f"""
[loads.spring]
type = "spring"
connect = ["ground.O", "block.C"]
stiffness = {STIFFNESS}
damping = 2000
free_length = 0
"""


@pytest.mark.parametrize("held", [STOP, SPRING], ids=["stop", "spring"])
@pytest.mark.parametrize("rtol", [1e-5, 1e-6, 1e-8])
def test_outputs_within_steps_of_a_body_at_rest_on_something_stiff_are_its_load(held, rtol):
    t = np.linspace(0.0, 0.5, 2501)
    r = rt.loads(AT_REST.replace("HELD", held)).simulate(0.5, t_eval=t, rtol=rtol)
    late = t > 0.1
    load = 4 + 2 * np.sin(7 * t[late])
    assert -r["block.x"][late] * STIFFNESS == pytest.approx(load, abs=0.05)
    assert abs(r["block.ax"][late]).max() * MASS < 0.05  # against 4 N: it follows the load


def test_a_stiff_contact_costs_few_steps_that_are_repeated():
    stats = rt.loads(AT_REST.replace("HELD", STOP)).simulate(0.5).stats
    assert stats["rejected"] < 0.1 * stats["steps"]
