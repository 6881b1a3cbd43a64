"""Samples whose loads switch, side by side: steps end where expressions switch, as those of single runs do."""

import numpy as np
import pytest

import rattle as rt
from balls import ball
from lane_runs import FINE, assert_alike, side_by_side

PIN = ', clearance = 1e-3, contact = { model = "impact", restitution = 0.3 }'
BUSH = ', clearance = 1e-3, contact = { model = "lankarani-nikravesh", stiffness = 1e8, restitution = 0.5 }'


def pendulum(torque, joint="", start="omega = 1"):
    return rt.loads(f"""
format = 1
gravity = [0, -9.81]
parameters = {{ k = 10.0, later = 0.1, w = 30.0 }}
ground.points.O = [0, 0]
tables.ramp = {{ x = [0, 0.05, 0.1, 0.2, 0.4], y = [0, 1, 1, -1, 0], kind = "linear", period = 0.4 }}
tables.once = {{ x = [-9, 0.03, 0.1, 0.2, 9], y = [0, 1, 1, -1, 0], kind = "linear" }}
tables.measured = {{ x = [0, 0.05, 0.2], y = [0, 1, -1] }}
bodies.b = {{ points = {{ C = [0.1, 0] }}, mass = 1, inertia = 0.02 }}
joints.O = {{ type = "revolute", connect = ["ground.O", "b.C"]{joint} }}
loads.push = {{ type = "torque", body = "b", torque = "{torque}" }}
initial = {{ b = {{ angle = 0, {start} }} }}
""")


LOADS = [
    "k*(1 if t < later else 0)", "k*step(t - later) - k*step(t - later - 1e-4)", "k*step(sin(w*t))", "k*abs(sin(w*t))",
    "k*max(0, 1 - 3*t)", "k*min(max(5*sin(w*t), -1), 1)", "-0.1*abs(b.omega)*b.omega", "-k*sign(b.angle)",
    "-k*mod(b.angle, 0.5)", "k*floor(7*t)", "k*ramp(t)", "k*ramp(b.angle)", "k*once(t)",
    "-k*max(abs(b.omega) - 0.5, 0)*b.omega", "k*(sqrt(t - later) if t > later else 0)",
    "k*(sin(t)/t if t > 0 else 1)", "k*(1 if b.angle > 0.01 and mod(t, 0.1) < 0.03 else 0)",
]  # fmt: skip


@pytest.mark.parametrize("load", LOADS)
def test_samples_are_what_they_are_alone(load):
    outputs = ["final(b.angle)", "final(b.omega)", "at(b.angle, 0.21)", "final(energy.work)", "mean(b.omega)"]
    assert_alike(pendulum(load), {"k": np.array([9.0, 11.0])}, outputs, 0.45, rel=1e-8, abs=1e-9)


@pytest.mark.parametrize("joint", [PIN, BUSH])
@pytest.mark.parametrize("load", ["k*step(t - later)", "k*ramp(t)", "-0.2*k*sign(b.omega) + 2*k*sin(w*t)"])
def test_beside_contacts(load, joint):
    """What a load that jumps does to a pin that rests is decided anew."""
    outputs = ["final(b.angle)", "count(O.contacts)", "time(O.contacts, 4)", "final(energy.dissipated)"]
    m = pendulum(load, joint)
    assert_alike(m, {"k": np.array([9.0, 11.0])}, outputs, 0.2, rel=1e-5, abs=1e-7)


def test_beside_friction_that_sticks():
    """A push that begins and ends: held, broken away, and slowed to rest: v = (F - mu m g) 0.1/m, x = v^2 ..."""
    m = rt.loads("""
format = 1
gravity = [0, -9.81]
parameters = { F = 8.0 }
ground.points.O = [0, 0]
bodies.b = { points = { C = [0, 0] }, mass = 1, inertia = 1 }
[joints.guide]
type = "prismatic"
connect = ["ground.O", "b.C"]
axis = 0
friction = { model = "coulomb", mu = 0.3 }
[loads.push]
type = "force"
at = "b.C"
force = ["F if t > 0.1 and t < 0.2 else 0", 0]
""")
    force = np.array([2.0, 4.0, 8.0])
    _, (x, v) = side_by_side(m, {"F": force}, ["final(b.x)", "max(b.vx)"], 1.0, **FINE)
    brake = 0.3 * 9.81
    gained = np.maximum(force - brake, 0.0)
    assert v == pytest.approx(0.1 * gained, abs=1e-9)
    assert x == pytest.approx(0.005 * gained * (1.0 + gained / brake), abs=1e-9)


def test_a_square_wave_whose_period_differs_from_sample_to_sample():
    """w' = M sign(sin(2 pi t/T))/J without gravity: a triangle of half M T/(2 J)."""
    m = rt.loads("""
format = 1
parameters = { T = 0.1 }
ground.points.O = [0, 0]
bodies.b = { points = { C = [0, 0] }, mass = 1, inertia = 2 }
joints.O = { type = "revolute", connect = ["ground.O", "b.C"] }
loads.push = { type = "torque", body = "b", torque = "3*sign(sin(2*pi*t/T))" }
initial = { b = { angle = 0, omega = 0 } }
""")
    period = np.array([0.011, 0.037, 0.1, 0.5])
    found, (most, mean) = side_by_side(m, {"T": period}, ["max(b.omega)", "at(b.omega, 0.26)"], 1.003)
    assert most == pytest.approx(0.75 * period, rel=1e-9)
    phase = np.mod(0.26 / period, 1.0)
    assert mean == pytest.approx(1.5 * period * np.where(phase < 0.5, phase, 1.0 - phase), abs=1e-9)
    assert found.stats["turns"] >= int((2.0 / period).sum()) - 4


@pytest.mark.parametrize("load", ["-lift*abs(ball.vy)*ball.vy", "lift*step(ball.y - 0.01)", "lift*max(-ball.y, 0)"])
def test_an_impact_that_turns_a_switch_is_counted(load):
    push = f'loads.push = {{ type = "force", at = "ball.C", force = [0, "{load}"] }}'
    m = rt.loads(ball(h=0.1, more=push)).set(lift=0.3)
    outputs = ["count(rail.contacts)", "time(rail.contacts, 2)", "speed(rail.contacts, 2)", "max(ball.vy)"]
    assert_alike(m, {"e": np.array([0.8, 0.5, 0.0])}, outputs, 0.8, rel=1e-5, abs=1e-7)


def test_what_switches_to_and_fro_stops_as_alone():
    found = pendulum("-k*sign(b.omega)").many({"k": [9.0, 10.0]}, t_end=0.5, outputs=["final(b.angle)"], threads=1)
    assert len(found.generic) == 2
    assert "switches to and fro without end" in found.messages[0]


def test_steps_of_equal_length_run_alone():
    found = pendulum("k*abs(sin(t))").many({"k": [9.0]}, t_end=0.1, outputs=["final(b.angle)"], method="rk4", step=1e-3)
    assert "steps of equal length do not end where expressions switch" in found.stats["how"]


def test_a_table_that_goes_on_for_ever_is_not_read_before_its_beginning():
    """Its last span is long, its first one short."""
    text = pendulum("k*once(t - later)").to_toml().replace("-9, 0.03, 0.1, 0.2, 9", "-1e-9, 1e-9, 0.1, 0.2, 2e9")
    assert "2e9" in text
    m = rt.loads(text)
    assert "outside of the table 'once'" in m.simulate(0.2).message
    found = m.many({"k": [9.0, 10.0]}, t_end=0.2, outputs=["final(b.angle)"])
    assert "outside of the table 'once'" in found.messages[0]


def slider_crank(driver, gravity="[0, -9.81]"):
    """Moved by a driver, or hanging."""
    return rt.loads(f"""
format = 1
gravity = {gravity}
parameters = {{ r = 0.1, l = 0.3, v = 8.0, up = 0.12 }}
tables.line = {{ x = [0, 0.1, 0.3, 0.5], y = [0, 5, 2, 7], units = ["s", "rad/s"] }}
tables.soft = {{ x = [0, 0.1, 0.3, 0.5], y = [0, 0.4, 1, 3], units = ["s", "rad"], kind = "monotone" }}
tables.wave = {{ x = [0, 0.05, 0.1, 0.15], y = [0, 5, 2, 0], units = ["s", "rad/s"], period = 0.15 }}
ground.points.O = [0, 0]
bodies.crank = {{ points = {{ P = [0, 0], Q = ["r", 0] }}, mass = 1, inertia = 0.01 }}
bodies.rod = {{ points = {{ P = [0, 0], Q = ["l", 0] }}, mass = 1, inertia = 0.01 }}
bodies.slider = {{ points = {{ C = [0, 0] }}, mass = 1, inertia = 0.01 }}
joints.O = {{ type = "revolute", connect = ["ground.O", "crank.P"] }}
joints.A = {{ type = "revolute", connect = ["crank.Q", "rod.P"] }}
joints.B = {{ type = "revolute", connect = ["rod.Q", "slider.C"] }}
joints.G = {{ type = "prismatic", connect = ["ground.O", "slider.C"], angle = 0 }}
{f'drivers.motor = {{ joint = "O", {driver} }}' if driver else "initial.crank = { angle = 0.3, omega = 0 }"}
""")


DRIVERS = [
    'speed = "v*min(t/up, 1)"', 'speed = "v*max(0, t - up)"', 'speed = "v*abs(sin(20*t))"', 'speed = "line(t)"',
    'speed = "wave(t)"', 'angle = "soft(t)"', 'angle = "v*max(0, t - up)**2"',
    'angle = "v*t**2/2/up if t < up else (v*(t - up/2) if t < 3*up else 2.5*up*v + v*(t - 3*up) - v*(t - 3*up)**2)"',
]  # fmt: skip


@pytest.mark.parametrize("driver", DRIVERS)
def test_drivers_whose_acceleration_jumps(driver):
    """Ramps, tables and pieces of functions that fit: the instants differ from sample to sample."""
    outputs = ["final(slider.x)", "max(O.force)", "final(slider.vx)", "final(energy.work)"]
    assert_alike(slider_crank(driver), {"up": np.array([0.11, 0.13])}, outputs, 0.44, rel=1e-7, abs=1e-8)


@pytest.mark.parametrize(
    "gravity", ['["0", "-9.81*min(1, t/up)"]', '["9.81*sin(max(0, t - up))", "-9.81*cos(max(0, t - up))"]']
)
def test_gravity_that_has_a_kink(gravity):
    outputs = ["final(slider.x)", "max(O.force)", "final(energy.work)"]
    assert_alike(slider_crank("", gravity), {"up": np.array([0.11, 0.13])}, outputs, 0.45, rel=1e-7, abs=1e-8)


@pytest.mark.parametrize(
    ("driver", "gravity"),
    [
        ('angle = "max(0, v*(t - up))"', "[0, 0]"),
        ('speed = "v*floor(1 + 5*t)"', "[0, 0]"),
        ("", '[0, "-9.81 if t > up else 0"]'),
    ],
)
def test_jolts_are_followed_alone(driver, gravity):
    a = slider_crank(driver, gravity).many({"up": [0.11, 0.13]}, ["final(slider.x)"], t_end=0.25)
    assert list(a.generic) == [0, 1]
    assert "a jump of a driver or its speed, or of gravity" in str(a)
    assert np.isfinite(a["final(slider.x)"]).all()


@pytest.mark.parametrize(
    "motor", ['speed = "speed*min(1, t/0.004)"', 'speed = "speed*(2*t/0.004 if t < 0.002 else 1)"']
)
def test_a_motor_that_runs_up_rattles_as_alone(motor):
    m = rt.loads(rt.example("slider_crank_play").to_toml().replace('angle = "speed*t"', motor))
    outputs = ["final(slider.x)", "time(B.contacts, 3)", "speed(B.contacts, 3)", "count(B.contacts)"]
    assert_alike(m, {"c": m.parameters["c"] * np.array([0.9, 1.1])}, outputs, 0.006, rel=1e-6)


RESTS = [
    "k*(1 if max(0, t - later) > 0 else 0)", "k*sign(max(0, t - later))", "k*step(step(t - later) - 1)",
    "k*(1 if floor(t/later) > 0 else 0)", "k*floor(min(2, t/later))", "k*(1 if ramp(t) >= 1 else 0)",
]  # fmt: skip


@pytest.mark.parametrize("load", RESTS)
def test_what_rests_where_it_jumps_is_left_to_single_runs(load):
    """At its switch an expression has a value of its own: 0 > 0 does not hold, sign(0) = 0."""
    m = pendulum(load)
    a = m.many({"later": [0.05, 0.1]}, ["final(b.omega)"], t_end=0.23, **FINE)
    assert list(a.generic) == [0, 1]
    assert "rests where an expression jumps" in str(a)


def test_a_kink_that_rests_runs_on():
    outputs = ["final(b.angle)", "final(b.omega)"]
    for load in ("k*abs(max(0, t - later))", "k*max(0, min(0, t - later)) + 1", "-0.1*abs(b.omega)*b.omega"):
        assert_alike(pendulum(load, start="omega = 0"), {"later": np.array([0.05, 0.1])}, outputs, 0.23, rel=1e-7)


@pytest.mark.parametrize("load", ["k*step(t - later)", "k*(1 if t < later else 0)", "k*floor(t/later)"])
def test_a_jump_just_at_the_end_is_left_to_single_runs(load):
    a = pendulum(load).many({"later": [0.1, 0.2]}, ["max(O.force)"], t_end=0.2, **FINE)
    assert 1 in a.generic
    assert "jumps just where it ends" in str(a)


def test_a_table_may_end_with_the_run():
    """As a measured torque does."""
    m = pendulum("k*measured(t)")
    assert_alike(m, {"k": np.array([9.0, 11.0])}, ["final(b.angle)", "final(energy.work)"], 0.2, rel=1e-7)
