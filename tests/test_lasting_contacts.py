"""Lasting rigid contacts let go when their force says, however short that is against a step."""

import math

import numpy as np
import pytest

import rattle as rt


def pressed(share, w):
    """1 kg in a vertical slot, pressed onto its wall by 10 kN (1 + share cos(w t)), with no gravity."""
    return rt.loads(f"""
format = 1
gravity = [0, 0]
[ground.points]
O = [0, 0]
[bodies.mass]
points = {{ P = [0, 0] }}
mass = 1
inertia = 1e-3
[joints.track]
type = "prismatic"
connect = ["ground.O", "mass.P"]
axis = "90 deg"
[joints.wall]
type = "revolute"
connect = ["ground.O", "mass.P"]
clearance = 0.001
contact = {{ model = "impact", restitution = 0, friction = 0 }}
[loads.press]
type = "force"
at = "mass.P"
force = [0, "-1e4*(1 + {share}*cos({w}*t))"]
[initial.mass]
x = 0
y = -0.001
vx = 0
""")


@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-10])
@pytest.mark.parametrize(("share", "w"), [(1.02, 300.0), (1.001, 300.0), (1.02, 2500.0), (1.0001, 8.0)])
def test_a_contact_lets_go_as_often_as_its_load_turns_however_short_and_long_the_steps(share, w, rtol):
    # N = 1e4 (1 + share cos(w t)) is below zero for 2 to 6 % of a turn, or less; nothing moves before, so that steps
    # would go to the end of the run.  It flies for three times as long or so and lands without a bounce.
    first = (math.pi - math.acos(1.0 / share)) / w
    true = np.arange(first, 6.5 * math.pi / w, 2.0 * math.pi / w)
    assert len(true) == 3
    r = pressed(share, w).simulate(6.5 * math.pi / w, rtol=rtol, t_eval=[0.0, 6.5 * math.pi / w])
    assert r.success, r.message
    released = [one.t for one in r.events if one.kind == "release"]
    assert released == pytest.approx(true, rel=1e-9)
