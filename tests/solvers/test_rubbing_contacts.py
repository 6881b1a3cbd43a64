"""Contacts beside joints that rub by their own reactions: what is set-valued in both is decided together."""

from __future__ import annotations

import numpy as np
import pytest

import rattle as rt

SPEED = 1500 * np.pi / 30
TURN = 2 * np.pi / SPEED


def lever(friction: str) -> str:
    """A torque on a crank, whose pin plays in the slot of a lever that rubs in its shaft."""
    return f"""
format = 1
[ground.points]
O = [0, 0]
W = [0.07, 0]
[bodies.crank]
points = {{ O = [0, 0], P = [0.05, 0] }}
mass = 0.3
inertia = 2e-4
[bodies.lever]
points = {{ W = [0, 0], S = [0.03, 0] }}
mass = 0.6
inertia = 2e-3
[joints.axis]
type = "revolute"
connect = ["ground.O", "crank.O"]
[joints.shaft]
type = "revolute"
connect = ["ground.W", "lever.W"]
{friction}
[joints.slot]
type = "slot"
connect = ["lever.S", "crank.P"]
clearance = "0.1 mm"
contact = {{ model = "impact", restitution = 0, bush_radius = "4 mm" }}
[loads.push]
type = "torque"
body = "crank"
torque = 0.1
[initial]
crank = {{ angle = 0.3, omega = 2 }}
lever = {{ angle = 2.5 }}
"""


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


@pytest.mark.parametrize("mu", [0.1, 0.21, 0.3])
@pytest.mark.parametrize(("end", "way"), [(0.1, 0.4), (-0.2, 0.1), (-0.6, 0.13)])
def test_a_body_that_is_pressed_against_its_stop_may_bear_nothing_in_its_rough_pin(mu, end, way):
    """Without gravity the moment of the stop is that of its spring: the pin has no force at rest, nor friction."""
    for place in (0.04, 0.043):
        r = rt.loads(f"""
format = 1
gravity = [0, 0]
ground.points.P = [0, 0]
bodies.arm = {{ mass = 1.3, inertia = 0.06, points = {{ P = [{place}, 0.08] }} }}
[joints.pin]
type = "revolute"
connect = ["ground.P", "arm.P"]
friction = {{ model = "coulomb", mu = {mu}, pin_radius = "23 mm" }}
stop = {{ min = -2, max = {end}, contact = {{ model = "impact", restitution = 0.3 }} }}
[loads.spring]
type = "torsion-spring"
connect = ["ground", "arm"]
stiffness = 2
free_angle = 0.6
[initial.arm]
angle = {end - way}
""").simulate(t_end=1.0)
        assert r.success, r.message
        assert sum(event.kind == "impact" for event in r.events) > 5
        assert r["arm.angle"][-1] == pytest.approx(end, abs=1e-9)
        assert abs(r["pin.stop"][-1]) == pytest.approx(2.0 * (0.6 - end), rel=1e-6)


def test_a_lever_turns_back_under_the_pin_that_presses_on_it_as_without_friction_if_that_is_weak():
    """Where its rate is zero the pin still pushes: no joint at rest may hold it."""
    times = np.linspace(0, 0.08, 9)
    dry, smooth = (
        rt.loads(lever(friction)).simulate(times[-1], t_eval=times, rtol=1e-9)
        for friction in ('friction = { mu = 1e-6, pin_radius = "8 mm" }', "")
    )
    assert dry.success, dry.message
    assert smooth["lever.omega"][0] < 0 < smooth["lever.omega"][-1]
    assert dry["lever.omega"] == pytest.approx(smooth["lever.omega"], abs=1e-3)


@pytest.mark.parametrize("mu", [0.05, 0.2])
def test_a_lever_that_rubs_in_its_shaft_turns_back_at_the_end_of_its_way(mu):
    run = rt.loads(lever(f'friction = {{ mu = {mu}, pin_radius = "8 mm" }}')).simulate(0.3)
    assert run.success, run.message
    assert run["lever.omega"][0] < 0 < run["lever.omega"][-1]
    force = np.hypot(run["shaft.fx"], run["shaft.fy"])
    slips = abs(run["lever.omega"]) > 1e-6
    assert abs(run["shaft.friction"])[slips] == pytest.approx(mu * 8e-3 * force[slips], rel=1e-9)
    assert abs(run["energy.balance"]).max() < 1e-7


def test_a_slider_goes_with_the_first_impact_of_its_pin_as_without_friction_if_that_is_weak():
    """It was at rest: after the impact it slips, and would jam the contact if it still stuck."""
    times = np.linspace(0, 0.1 * TURN, 11)
    dry, smooth = (
        rt.loads(slider_crank(mu, 0.1, 0.0)).simulate(times[-1], t_eval=times, rtol=1e-9) for mu in (1e-6, 0.0)
    )
    assert dry.success, dry.message
    assert min(smooth["slider.vx"]) < -1.0
    assert dry["slider.vx"] == pytest.approx(smooth["slider.vx"], abs=1e-3)


def test_friction_of_a_guide_and_of_a_loose_pin_follow_their_forces_through_three_turns():
    """The pin may turn the force on the guide around, so that its friction is not linear in that of the pin."""
    times = np.linspace(0, 3 * TURN, 601)
    run = rt.loads(slider_crank(0.1, 0.1, 0.2)).simulate(times[-1], t_eval=times, rtol=1e-9)
    assert run.success, run.message
    slides = abs(run["slider.vx"]) > 1e-6
    assert abs(run["guide.friction"])[slides] == pytest.approx(0.1 * abs(run["guide.fy"])[slides], rel=1e-9)
    assert (abs(run["B.tangential"]) <= 0.1 * run["B.normal"] * (1 + 1e-9) + 1e-9).all()
    assert abs(run["energy.balance"]).max() < 1e-6


def test_a_guide_that_a_driven_pin_moves_turns_back_at_the_dead_centres():
    """There it is at rest, and the contact that moves it is closed; no friction ever pushes along its motion."""
    run = rt.loads("""
format = 1
gravity = [0, -9.81]
ground.points.O = [0, 0]
bodies.crank = { points = { O = [0, 0], A = [0.05, 0] }, mass = 0.3, inertia = 1e-4 }
bodies.yoke = { points = { B = [0, 0] }, mass = 0.3, inertia = 1e-3 }
drivers.motor = { joint = "O", angle = "60*t" }
loads.push = { type = "force", at = "yoke.B", force = ["max(0, 30*cos(5*t))", 0] }
initial.yoke.x = 0.05
[joints.O]
type = "revolute"
connect = ["ground.O", "crank.O"]
friction = { model = "coulomb", mu = 0.7857, pin_radius = "20 mm" }
[joints.S]
type = "slot"
connect = ["yoke.B", "crank.A"]
axis = "90 deg"
clearance = 0.0003217193361872735
contact = { model = "impact", restitution = 0.3 }
[joints.guide]
type = "prismatic"
connect = ["ground.O", "yoke.B"]
axis = 0
friction = { force = 39.285 }
""").simulate(0.2, rtol=1e-10)
    assert run.success, run.message
    assert (run["guide.friction"] * run["yoke.vx"]).max() <= 0.0
    assert np.diff(run["energy.dissipated"]).min() >= -1e-12
    turns = [event.t for event in run.events if event.joint == "guide"]
    assert min(abs(np.array(turns) - 3.0 * np.pi / 60.0)) < 1e-9
