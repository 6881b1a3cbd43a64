"""Stops in equilibria, in vibrations about them, and in motions that are given."""

import math

import numpy as np
import pytest

import rattle as rt
from rattle.errors import TraceError

G = 9.81


def rod(stop, more="", g=G, angle=-1.0):
    """A uniform rod, 1 m, 1 kg, on a hinge; angle 0 is level."""
    return rt.loads(f"""
format = 1
gravity = [0, {-g}]
[ground.points]
O = [0, 0]
A = [0, 1]
[bodies.rod]
bar = ["O", "E"]
length = 1
mass = 1
[joints.hinge]
type = "revolute"
connect = ["ground.O", "rod.O"]
stop = {stop}
{more}
[initial]
rod = {{ angle = {angle} }}
""")


def test_a_rod_rests_on_the_stop_that_holds_it_and_only_there():
    found = rod('{ min = "-30 deg", max = "80 deg" }', angle=0.0).equilibrium()
    at_min = next(one for one in found if one.resting == {"hinge": 1})
    moment = 0.5 * G * math.cos(math.pi / 6)
    assert at_min["hinge.stop"] == pytest.approx(moment, rel=1e-9)
    assert (at_min["hinge.moment"], at_min["hinge.fy"]) == pytest.approx((moment, G), rel=1e-9)
    assert at_min.admissible
    assert at_min.stable
    assert "hinge rests on its stop with 4.248 N*m" in str(at_min)
    # it would have to be pulled up at the other end, and neither hanging nor standing is possible
    assert [(one.resting, one.admissible) for one in found] == [({"hinge": 1}, True), ({"hinge": -1}, False)]


def test_hanging_freely_needs_no_stop_and_both_ends_may_hold():
    found = rod('{ min = "-170 deg", max = "-20 deg" }').equilibrium()
    best = found[0]
    assert (best.resting, best["hinge.stop"]) == ({}, 0.0)
    assert best["rod.angle"] == pytest.approx(-math.pi / 2, abs=1e-9)
    assert all(not one.admissible for one in found[1:])


def test_a_compliant_stop_gives_way_and_the_rod_vibrates_on_it():
    k = 2000.0
    law = f'contact = {{ model = "hertz", stiffness = {k}, exponent = 1 }}'
    m = rod(f'{{ min = "-30 deg", max = "80 deg", {law} }}', angle=0.0)
    one = next(one for one in m.equilibrium() if one.resting)
    angle = one["rod.angle"]
    assert angle < -math.pi / 6
    assert one["hinge.stop"] == pytest.approx(0.5 * G * math.cos(angle), rel=1e-8)
    assert one["hinge.stop"] == pytest.approx(k * (-math.pi / 6 - angle), rel=1e-8)
    modes = m.modes(equilibrium=one)
    assert modes.omega == pytest.approx([math.sqrt(3 * (k - 0.5 * G * math.sin(angle)))], rel=1e-6)


def test_a_block_rests_on_a_stop_of_its_guide():
    m = rt.loads("""
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.block]
points = { C = [0, 0] }
mass = 2
inertia = 1
[joints.guide]
type = "prismatic"
connect = ["ground.O", "block.C"]
axis = "-30 deg"
angle = 0
stop = { max = "0.4 m" }
""")
    one = m.equilibrium()[0]
    assert one["block.x"] == pytest.approx(0.4 * math.cos(math.pi / 6), abs=1e-12)
    assert one["guide.stop"] == pytest.approx(-2 * G / 2, rel=1e-9)  # along the line, up
    assert (one["guide.fx"], one["guide.fy"]) == pytest.approx((0.0, 2 * G), abs=1e-9)
    assert one.admissible
    assert len(m.modes(equilibrium=one)) == 0  # it presses: nothing is left that could vibrate


def test_a_driven_motion_says_when_it_passes_a_stop():
    drive = '[drivers.motor]\njoint = "hinge"\nangle = "2*t"\n'
    m = rod('{ min = "-30 deg", max = "60 deg" }', drive)
    for r in (m.kinematics([0.0, 0.4, 0.8]), m.inverse_dynamics([0.0, 0.4, 0.8])):
        (note,) = [one for one in r.trust.notes if "beyond its stop" in one]
        assert "'hinge' goes beyond its stop (max), by up to 31.7 deg, first at t = 0.5236 s" in note
    assert not any("stop" in one for one in m.kinematics([0.0, 0.5]).trust.notes)


def test_a_driven_motion_that_turns_back_between_two_instants_is_seen_to_pass():
    drive = '[drivers.motor]\njoint = "hinge"\nangle = "sin(t)"\n'
    r = rod("{ min = -2, max = 0.95 }", drive, angle=0.0).kinematics(np.linspace(0, math.pi, 5))
    assert any("beyond its stop" in one for one in r.trust.notes)


def test_a_driver_that_holds_a_joint_beyond_its_stop_leaves_no_equilibrium_and_that_is_said():
    drive = '[drivers.motor]\njoint = "hinge"\nangle = "2*t"\n'
    m = rod('{ min = "-30 deg", max = "60 deg" }', drive)
    assert len(m.equilibrium(0.5)) == 1
    found = m.equilibrium(0.8)
    assert not found
    assert found.note == "the positions of balance without stops are beyond those of hinge"


def test_sensitivities_say_that_stops_are_in_the_way():
    stop = '{ min = "-30 deg", contact = { model = "impact", restitution = 0.3, restitution_law = "poisson" } }'
    m = rod(stop, 'friction = { model = "coulomb", mu = 0.1, pin_radius = 0.01 }', angle=0.0)
    m = m.set({"parameters.m": 1.0, "bodies.rod.mass": "m"})
    with pytest.raises(
        TraceError, match=r"have derivatives with .*newton.*without stops \(set joints.hinge.stop to None\)"
    ):
        m.sensitivity(["rod.angle"], ["m"], [0.0, 0.1])


def test_check_lists_stops():
    said = str(rod('{ min = "-30 deg", contact = { model = "impact", restitution = 0.3 } }', angle=0).check())
    assert "stop: hinge from -30 deg, impact" in said


def test_the_ideal_mechanism_keeps_its_stops_and_a_saved_one_has_them():
    m = rod('{ min = "-30 deg" }', 'clearance = "1 mm"')
    assert m.ideal().model.joints["hinge"].stop is not None
    again = rt.loads(m.to_toml())
    assert again.model.joints["hinge"].stop == m.model.joints["hinge"].stop
    assert m.set({"joints.hinge.stop.min": "-20 deg"}).model.joints["hinge"].stop.minimum == pytest.approx(-math.pi / 9)
