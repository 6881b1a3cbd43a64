"""Expressions that switch with the state beside contacts: both sides of an impact, flights far shorter than steps.

A ball that is thrown up from a stop has closed forms: its flights are parabolas.
"""

import math

import numpy as np
import pytest

import rattle as rt


def ball(contact, force, rate, t_end=2.0):
    return rt.loads(f"""
format = 1
gravity = [0, 0]
[ground.points]
O = [0, 0]
[bodies.ball]
points = {{ C = [0, 0] }}
mass = 1
inertia = 0.1
[joints.rail]
type = "prismatic"
connect = ["ground.O", "ball.C"]
stop = {{ min = 0, contact = {contact} }}
[loads.push]
type = "force"
at = "ball.C"
force = ["{force}", 0]
[states.sum]
rate = "{rate}"
[initial]
ball = {{ x = 0, vx = 1 }}
[simulate]
t_end = {t_end}
""")


ELASTIC = '{ model = "impact", restitution = 1 }'


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10, 1e-12])
def test_a_path_grows_on_both_sides_of_every_impact(rtol):
    """200 flights of 0.1 s up to 25 mm, within steps that would be a hundred times longer."""
    r = ball(ELASTIC, -20, "abs(ball.vx)", 20.0).simulate(rtol=rtol)
    assert r["sum"][-1] == pytest.approx(10.0, abs=1e-9)
    assert r.success


@pytest.mark.parametrize("t_end", [0.26, 2.0, 20.0])
@pytest.mark.parametrize("force", ["-20 - 8*sign(ball.vx)", "-28 if ball.vx > 0 else -12"])
def test_a_force_against_the_motion_brakes_after_an_impact_too(force, t_end):
    r = ball('{ model = "impact", restitution = 0.6 }', force, "abs(ball.vx)", t_end).simulate()
    t, v, expected, path = 0.0, 1.0, [], 0.0
    for _ in range(4):
        height = v * v / 56
        down = math.sqrt(2 * height / 12)
        t, path = t + v / 28 + down, path + 2 * height
        expected.append((t, 12 * down))
        v = 0.6 * 12 * down
    impacts = [one for one in r.events if one.kind == "impact"][:4]
    assert [one.t for one in impacts] == pytest.approx([one for one, _ in expected], abs=1e-9)
    assert [one.normal_speed for one in impacts] == pytest.approx([one for _, one in expected], rel=1e-7)
    assert r["sum"][-1] == pytest.approx(2 / 56 / (1 - 0.36 * 12 / 28), rel=1e-6)  # all flights


def test_time_above_a_height_is_counted_in_every_flight():
    """Starts and ends of a compliant contact cut steps short as impacts do; each flight is above 10 mm for 77 ms."""
    contact = '{ model = "hertz", stiffness = "1e6 N/m", exponent = 1 }'
    r = ball(contact, -20, "1 if ball.x > 0.01 else 0", 20.0).simulate()
    above = 2 * math.sqrt(2 * (0.025 - 0.01) / 20)
    period = 0.1 + math.pi / 1e3  # half an oscillation in contact, and what the force adds to it
    flights = 20.0 / period
    assert r["sum"][-1] == pytest.approx(above * flights, abs=1.5 * above)
    short = ball(contact, -20, "1 if ball.x > 0.01 else 0", 20.0).simulate(step=0.01)
    assert r["sum"][-1] == pytest.approx(short["sum"][-1], rel=1e-4)


def after(r, t, name):
    """The value of a curve just after the event at t [s]."""
    k = int(np.flatnonzero(np.abs(r.breaks.t - t) < 1e-9)[-1])
    return r.breaks.data[k, list(r.stored).index(name)]


@pytest.mark.parametrize("force", ["-20 - 8*sign(ball.vx)", "-28 if ball.vx > 0 else -12"])
def test_the_force_just_after_an_impact_is_that_of_the_new_side(force):
    r = ball('{ model = "impact", restitution = 0.6 }', force, "abs(ball.vx)", 0.15).simulate()
    hit = next(event.t for event in r.events if event.kind == "impact" and event.t > 0)
    assert after(r, hit, "ball.ax") == pytest.approx(-28.0, rel=1e-12)


CARRIED = """
format = 1
gravity = [0, 0]
ground.points.O = [0, 0]
bodies.cart = { points = { C = [0, 0] }, mass = 1, inertia = 0.1 }
bodies.load = { points = { C = [0, 0] }, mass = 1, inertia = 0.1 }
joints.rail = { type = "prismatic", connect = ["ground.O", "cart.C"] }
drivers.motor = { joint = "rail", position = "0.1*t - 0.5*max(0, t - 0.5)" }
loads.push = { type = "force", at = "load.C", force = ["-5 if cart.vx > 0 else -1", 0] }
initial.load = { x = 0, vx = 0.1 }
simulate.t_end = 0.55
[joints.slide]
type = "prismatic"
connect = ["cart.C", "load.C"]
stop = { min = 0, contact = { model = "impact", restitution = 0 } }
"""


def test_the_force_just_after_a_jolt_is_that_of_the_new_side():
    """A driven cart turns back in one instant; what it has carried at its stop flies on."""
    r = rt.loads(CARRIED).simulate()
    assert after(r, 0.5, "load.vx") == pytest.approx(0.1, abs=1e-9)
    assert after(r, 0.5, "load.ax") == pytest.approx(-1.0, rel=1e-12)


def test_a_visit_that_only_a_stage_of_a_long_step_falls_into_is_counted_in_full():
    """2 ms of a free flight of 2 s in four steps: between the even shares of a step at which it is searched."""
    seen = []
    for place in np.linspace(0.5, 1.9, 200, endpoint=False):
        r = ball(ELASTIC, 0, f"1 if (ball.x - {place})**2 < 1e-6 else 0").simulate(t_eval=[0.0, 2.0])
        seen.append(r["sum"][-1])
    seen = np.array(seen)
    assert seen.max() == pytest.approx(2e-3, rel=1e-6)
    assert ((seen < 1e-9) | (np.abs(seen - 2e-3) < 1e-8)).all()  # not by a part of it
