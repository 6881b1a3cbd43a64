"""Contacts beside joints that rub by their own reactions: what is set-valued in both is decided together."""

from __future__ import annotations

import numpy as np
import pytest

import rattle as rt

SPEED = 1500 * np.pi / 30
TURN = 2 * np.pi / SPEED


def slider_crank(guide: float, pin: float, e: float) -> str:
    """A slider-crank at 1500/min with 0.1 mm of play at the slider; friction in its guide and in the loose pin."""
    return f"""
format = 1
[ground.points]
O = [0, 0]
[bodies.crank]
points = {{ O = [0, 0], A = ["50 mm", 0] }}
mass = 0.3
inertia = 1e-4
[bodies.rod]
bar = ["A", "B"]
length = "120 mm"
mass = 0.21
inertia = 2.5e-4
[bodies.slider]
points = {{ B = [0, 0] }}
mass = 0.14
inertia = 1e-4
[joints.O]
type = "revolute"
connect = ["ground.O", "crank.O"]
[joints.A]
type = "revolute"
connect = ["crank.A", "rod.A"]
[joints.B]
type = "revolute"
connect = ["slider.B", "rod.B"]
clearance = "0.1 mm"
contact = {{ model = "impact", restitution = {e}, friction = {pin}, bush_radius = "10 mm" }}
[joints.guide]
type = "prismatic"
connect = ["ground.O", "slider.B"]
axis = 0
{f"friction = {guide}" if guide else ""}
[drivers.motor]
joint = "O"
angle = "{SPEED!r}*t"
[initial]
rod = {{ angle = 0 }}
slider = {{ x = "170 mm" }}
B = {{ offset = [0, 0] }}
"""


def test_friction_of_a_guide_and_of_a_loose_pin_follow_their_forces_through_three_turns():
    """The pin may turn the force on the guide around, so that its friction is not linear in that of the pin."""
    times = np.linspace(0, 3 * TURN, 601)
    run = rt.loads(slider_crank(0.1, 0.1, 0.2)).simulate(times[-1], t_eval=times, rtol=1e-9)
    assert run.success, run.message
    slides = abs(run["slider.vx"]) > 1e-6
    assert abs(run["guide.friction"])[slides] == pytest.approx(0.1 * abs(run["guide.fy"])[slides], rel=1e-9)
    assert (abs(run["B.tangential"]) <= 0.1 * run["B.normal"] * (1 + 1e-9) + 1e-9).all()
    assert abs(run["energy.balance"]).max() < 1e-6
