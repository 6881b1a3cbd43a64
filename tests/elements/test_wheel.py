"""Wheels that roll on a line: slopes, a beam that tilts under them, ceilings, friction that lets them slip."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rattle as rt
from rattle.errors import ModelError

G, R, MASS = 9.81, 0.1, 2.0
INERTIA = 0.5 * MASS * R * R


def disc(axis=0.0, start=(0.0, R, 0.0, 0.0, 0.0, 0.0), joint="", more="", inertia=INERTIA, gravity=G):
    """A disc on a line of the ground; start: x, y, angle, vx, vy, omega."""
    keys = ("x", "y", "angle", "vx", "vy", "omega")
    written = ", ".join(f"{key} = {value}" for key, value in zip(keys, start, strict=True))
    return rt.loads(f"""
format = 1
gravity = [0, {-gravity}]
[ground.points]
O = [0, 0]
S = [-1, {R}]
[bodies.disc]
points = {{ C = [0, 0] }}
center = [0, 0]
mass = {MASS}
inertia = {inertia}
[joints.wheel]
type = "wheel"
connect = ["ground.O", "disc.C"]
axis = "{axis} deg"
radius = {R}
{joint}
[initial]
disc = {{ {written} }}
{more}
""")


def on_slope(slope, angle=0.0):
    """Start at rest on a line that falls to the right by `slope` [rad]."""
    return (R * math.sin(slope), R * math.cos(slope), angle, 0.0, 0.0, 0.0)


def test_a_disc_rolls_down_a_slope_with_two_thirds_of_the_pull():
    """v' = 2/3 g sin, N = m g cos, a third of the pull as friction; the angle that is written is where it starts."""
    slope = math.radians(20.0)
    r = disc(-20.0, on_slope(slope, 0.3)).simulate(1.0, t_eval=[0.0, 0.5, 1.0], rtol=1e-11)
    way = G * math.sin(slope) / 3 * r.t**2
    assert np.hypot(r["disc.x"] - r["disc.x"][0], r["disc.y"] - r["disc.y"][0]) == pytest.approx(way, abs=1e-10)
    assert r["disc.angle"] == pytest.approx(0.3 - way / R, abs=1e-9)
    assert r["wheel.normal"] == pytest.approx(MASS * G * math.cos(slope), rel=1e-10)
    pull = -MASS * G * math.sin(slope) / 3
    assert r["wheel.tangential"] == pytest.approx(pull, rel=1e-10)
    assert r["wheel.moment"] == pytest.approx(R * pull, rel=1e-10)  # about the centre: both act where it touches
    assert r["wheel.fx"] == pytest.approx(
        MASS * G * math.cos(slope) * math.sin(slope) + pull * math.cos(slope), rel=1e-9
    )


def test_a_disc_hangs_from_a_ceiling_by_a_negative_normal_force():
    r = disc(180.0, (0.0, -R, 0.0, 0.0, 0.0, 0.0)).simulate(0.1)
    assert r["wheel.normal"] == pytest.approx(-MASS * G, rel=1e-12)
    assert r["wheel.fy"] == pytest.approx(MASS * G, rel=1e-12)


def beam(t, y, inertia):
    """Beam with a disc on it: angle, way of the disc along it, and their rates; Lagrange's equations."""
    angle, s, w, v = y
    turned = inertia + MASS * s * s
    dw = (MASS * R * s * w * w - 2 * MASS * s * v * w - MASS * G * s * math.cos(angle)) / turned
    pulled = (MASS * s * w * w - MASS * G * math.sin(angle)) / (MASS + INERTIA / R**2)
    return [w, v, dw, pulled + R * dw]


def test_a_disc_on_a_beam_moves_as_lagrange_says():
    """L = I w^2/2 + (m + J/r^2) sigma^2/2 + m s^2 w^2/2 - m g (s sin + r cos), sigma = s' - r w."""
    inertia, begins = 0.5, (0.2, 0.3, 0.4, -0.5)
    angle, s, w, v = begins
    along, across = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
    (x, y), (vx, vy) = s * along + R * across, (v - R * w) * along + s * w * across
    r = rt.loads(f"""
format = 1
gravity = [0, {-G}]
[ground.points]
O = [0, 0]
[bodies.beam]
points = {{ O = [0, 0] }}
center = [0, 0]
mass = 1
inertia = {inertia}
[bodies.disc]
points = {{ C = [0, 0] }}
center = [0, 0]
mass = {MASS}
inertia = {INERTIA}
[joints.hinge]
type = "revolute"
connect = ["ground.O", "beam.O"]
[joints.wheel]
type = "wheel"
connect = ["beam.O", "disc.C"]
radius = {R}
[initial]
beam = {{ angle = {angle}, omega = {w} }}
disc = {{ x = {x}, y = {y}, angle = 0, vx = {vx}, vy = {vy} }}
""").simulate(0.6, rtol=1e-11, atol=1e-13)
    wanted = solve_ivp(beam, (0.0, 0.6), begins, t_eval=r.t, args=(inertia,), rtol=1e-11, atol=1e-12).y
    assert r["beam.angle"] == pytest.approx(wanted[0], abs=1e-8)
    reach = r["disc.x"] * np.cos(r["beam.angle"]) + r["disc.y"] * np.sin(r["beam.angle"])
    assert reach == pytest.approx(wanted[1], abs=1e-8)
    # what the disc has turned by on the beam
    assert r["disc.angle"] == pytest.approx(wanted[0] - angle - (wanted[1] - s) / R, abs=1e-7)
    assert r["energy.balance"] == pytest.approx(np.zeros(len(r.t)), abs=1e-8)
    assert np.ptp(wanted[0]) > 0.5


SPRING = """
[loads.spring]
type = "spring"
connect = ["ground.S", "disc.C"]
stiffness = 300
free_length = 1
"""


def test_a_disc_at_a_spring_has_the_frequency_of_one_and_a_half_times_its_mass():
    modes = disc(more=SPRING).modes()
    assert list(modes.frequency) == pytest.approx([math.sqrt(300 / 3.0) / (2 * math.pi)], rel=1e-9)


def test_a_torque_on_a_resting_disc_presses_the_spring_by_its_road():
    """k x = M/r forwards, and the road gives it."""
    more = SPRING + '[loads.torque]\ntype = "torque"\nbody = "disc"\ntorque = -1.5\n'
    rest = disc(more=more).equilibrium()[0]
    assert rest["disc.x"] == pytest.approx(1.5 / R / 300, rel=1e-9)
    assert rest["disc.angle"] == pytest.approx(-1.5 / R**2 / 300, rel=1e-9)
    assert rest["wheel.tangential"] == pytest.approx(1.5 / R, rel=1e-9)


def test_a_driven_disc_needs_the_torque_of_the_mass_that_it_moves():
    """x = 0.2 t^2: angle -x/r, torque -(m r^2 + J) x''/r by inverse dynamics."""
    more = '[drivers.motor]\nbody = "disc"\ncoordinate = "angle"\nangle = "-0.2*t**2/0.1"\n'
    r = disc(more=more, start=(0.0, R, 0.0, 0.0, 0.0, 0.0)).inverse_dynamics(1.0)
    assert r["disc.x"] == pytest.approx(0.2 * r.t**2, abs=1e-12)
    assert r["motor.torque"] == pytest.approx(-(MASS * R * R + INERTIA) * 0.4 / R, rel=1e-9)


@pytest.mark.parametrize(("v0", "w0"), [(3.0, 0.0), (3.0, 60.0), (-1.0, -80.0)])
def test_a_disc_with_friction_slips_until_it_rolls(v0, w0):
    """Slip v0 + r w0 falls by 3 mu g; then it rolls, and nothing is lost any more."""
    mu, slip = 0.2, v0 + R * w0
    ends, sense = abs(slip) / (3 * mu * G), math.copysign(1.0, slip)
    r = disc(start=(0, R, 0, v0, 0, w0), joint=f"friction = {mu}").simulate(
        ends + 0.2, t_eval=[0.0, 0.5 * ends, ends + 0.2], rtol=1e-11
    )
    v, w = v0 - sense * mu * G * ends, w0 - sense * 2 * mu * G / R * ends
    assert v == pytest.approx(-R * w, rel=1e-12)
    assert [r["disc.vx"][-1], r["disc.omega"][-1]] == pytest.approx([v, w], rel=1e-9)
    assert r["wheel.friction"] == pytest.approx([-sense * mu * MASS * G] * 2 + [0.0], abs=1e-9)
    assert r["wheel.tangential"] == pytest.approx(r["wheel.friction"], abs=1e-12)
    (stick,) = [event for event in r.events if event.kind == "stick"]
    assert stick.t == pytest.approx(ends, abs=1e-9)
    lost = 0.5 * MASS * (v0**2 - v**2) + 0.5 * INERTIA * (w0**2 - w**2)
    assert r["energy.dissipated"][-1] == pytest.approx(lost, rel=1e-9)


def test_friction_counts_the_size_of_a_pulling_normal_force():
    """Under a ceiling N = -m g: the disc slips and stops slipping as on a floor."""
    mu, v0 = 0.2, 1.0
    start = (0.0, -R, 0.0, v0, 0.0, 0.0)
    r = disc(180.0, start, f"friction = {mu}").simulate(1.0, rtol=1e-10)
    (stick,) = [event for event in r.events if event.kind == "stick"]
    assert stick.t == pytest.approx(v0 / (3 * mu * G), abs=1e-9)
    assert [r["disc.vx"][-1], r["disc.omega"][-1]] == pytest.approx([2 / 3 * v0, 2 / 3 * v0 / R], rel=1e-8)


@pytest.mark.parametrize(("slope", "rolls"), [(29.0, True), (32.0, False)])
def test_a_disc_rolls_on_slopes_up_to_three_times_its_friction(slope, rolls):
    mu, b = 0.2, math.radians(slope)
    assert (math.tan(b) <= 3 * mu) == rolls
    r = disc(-slope, on_slope(b), f"friction = {mu}").simulate(0.5, rtol=1e-10)
    way = math.hypot(r["disc.x"][-1] - r["disc.x"][0], r["disc.y"][-1] - r["disc.y"][0])
    pull = 2 / 3 * G * math.sin(b) if rolls else G * (math.sin(b) - mu * math.cos(b))
    assert way == pytest.approx(0.125 * pull, rel=1e-8)
    turned = way if rolls else 0.125 * 2 * mu * G * math.cos(b)
    assert r["disc.angle"][-1] == pytest.approx(-turned / R, rel=1e-8)


def test_a_wheel_with_a_contact_falls_slips_and_rolls_as_a_disc_on_a_surface():
    mu, v0, drop = 0.2, 1.0, 0.05
    wheel = disc(start=(0, R + drop, 0, v0, 0, 0), joint=f'contact = {{ model = "impact", friction = {mu} }}')
    r = wheel.simulate(1.5, t_eval=[0.0, 1.5], rtol=1e-11)
    # the impact takes mu times its momentum downwards, or all that makes it roll
    slip = v0 - 3 * mu * math.sqrt(2 * G * drop)
    (touch,) = [event for event in r.events if event.kind == "impact"]
    assert touch.t == pytest.approx(math.sqrt(2 * drop / G), abs=1e-9)
    stick = next(event.t for event in r.events if event.kind == "stick")
    assert stick == pytest.approx(touch.t + slip / (3 * mu * G), abs=1e-8)
    assert [r["disc.vx"][-1], r["disc.omega"][-1]] == pytest.approx([2 / 3 * v0, -2 / 3 * v0 / R], rel=1e-8)
    assert r["wheel.normal"][-1] == pytest.approx(MASS * G, rel=1e-9)


def test_mobility_counts_the_row_that_friction_gives_up():
    assert [disc(joint=joint).check().mobility for joint in ("", "friction = 0.1")] == [1, 2]


@pytest.mark.parametrize(
    ("joint", "word"),
    [("clearance = 1e-3", "clearance"), ("corners = []", "corners")],
)
def test_what_a_wheel_does_not_have_is_refused(joint, word):
    with pytest.raises(ModelError, match=word):
        disc(joint=joint)


LIFTING = """
format = 1
ground.points = {{ O = [0, 0], M = ["0.01*sin(t/(1 s))", 0] }}
bodies.disc = {{ points = {{ C = [0, 0] }}, mass = 2, inertia = 0.01 }}
initial.disc = {{ x = 0, y = 0.1 }}
joints.wheel = {{ connect = ["ground.O", "disc.C"], contact = {{ model = "impact" }}, {more} }}
"""


def test_a_wheel_that_may_lift_off_has_the_line_of_one_that_does_not():
    joint = rt.loads(LIFTING.format(more='type = "wheel", radius = 0.1')).model.joints["wheel"]
    assert (joint.kind, joint.fields["axis"], joint.fields["roller"]) == ("surface", 0.0, 0.1)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ('type = "wheel"', "wheel: needs radius: radius of the wheel"),
        ('type = "wheel", radius = -1', "wheel.radius: -1 must be positive"),
        ('type = "wheel", radius = 0.1, length = 1', "wheel.length: a wheel joint has no pin in a bush"),
        ('type = "wheel", radius = 0.1, friction = 0.2', "friction of a wheel belongs to its contact"),
        ('type = "surface", axis = 0, roller = 0.1, friction = 0.2', "friction of a surface belongs to its contact"),
    ],
)
def test_a_wheel_that_may_lift_off_is_refused_by_its_own_keys(more, words):
    with pytest.raises(ModelError, match=words) as error:
        rt.loads(LIFTING.format(more=more))
    assert len(error.value.problems) == 1


@pytest.mark.parametrize(
    ("connect", "corners", "words"),
    [
        ('["disc.C", "ground.M"]', '["O"]', r"corners: 'ground.M' moves over t, .* leave corners out"),
        ('["disc.C", "ground.O"]', '["O", "M"]', r"corners\[1\]: 'ground.M' moves over t, away from the other corners"),
        ('["ground.O", "disc.C"]', '["disc.C"]', "write 'C': corners are points of this body"),
    ],
)
def test_corners_that_no_one_body_has_are_refused(connect, corners, words):
    text = LIFTING.format(more=f'type = "surface", axis = 0, corners = {corners}')
    with pytest.raises(ModelError, match=words):
        rt.loads(text.replace('["ground.O", "disc.C"], contact', f"{connect}, contact"))
