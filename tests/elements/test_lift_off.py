"""Followers that only a cam pushes: where they lift off and land, by every kind of contact, and what is refused."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import rattle as rt

pytestmark = pytest.mark.nojit

G, W, R, E = 9.81, 20.0, 0.05, 0.03  # an eccentric of radius R turns about a point E from its centre, e w^2 > g
FINE = {"rtol": 1e-10, "atol": 1e-12}
FLAT = 'type = "flat-follower"\naxis = "90 deg"\nsupport = "0.05 + 0.03*cos(x)"'
ROUND = 'type = "cam"\nradius = "0.03*cos(a) + sqrt(0.0025 - (0.03*sin(a))**2)"'
ROLLER = 'type = "cam"\nroller = "15 mm"\nradius = "0.03*cos(a) + sqrt(0.035**2 - (0.03*sin(a))**2)"'
RIGID = 'contact = { model = "impact", restitution = 0 }'


def lift(shape, cam):
    """Height of the follower [m] over the cam angle [rad]: in closed form, for an eccentric."""
    if shape == FLAT:
        return R + E * np.sin(cam)
    return E * np.sin(cam) + np.sqrt(R**2 - (E * np.cos(cam)) ** 2)


def slopes(shape, cam, h=1e-3):
    """First and second derivative of the lift [m] by the cam angle."""
    up, here, down = lift(shape, cam + h), lift(shape, cam), lift(shape, cam - h)
    more, less = lift(shape, cam + 2 * h), lift(shape, cam - 2 * h)
    first = (8 * (up - down) - more + less) / (12 * h)
    return first, (16 * (up + down) - more - less - 30 * here) / (12 * h * h)


def flight(shape):
    """Times of lift-off and of landing [s], and speed of approach there [m/s]: the weight alone, from the angle 0."""
    off = brentq(lambda x: slopes(shape, x)[1] * W * W + G, 0.0, 1.4, xtol=1e-14)
    y, v = lift(shape, off), slopes(shape, off)[0] * W

    def gap(x):
        t = (x - off) / W
        return y + v * t - 0.5 * G * t * t - lift(shape, x)

    on = brentq(gap, off + 1.0, off + 5.0, xtol=1e-14)
    return off / W, on / W, slopes(shape, on)[0] * W - (v - G * (on - off) / W)


def text(shape, contact=RIGID, start="0", follower="follower = { vx = 0, vy = 0 }", more=""):
    return f"""
format = 1
gravity = [0, {-G}]
[ground.points]
O = [0, 0]
[bodies.disc]
points = {{ C = [0, 0] }}
mass = 1
inertia = 1
[bodies.follower]
points = {{ C = [0, 0] }}
mass = 2
inertia = 1
[joints.pin]
type = "revolute"
connect = ["ground.O", "disc.C"]
[joints.guide]
type = "prismatic"
connect = ["ground.O", "follower.C"]
axis = "90 deg"
angle = 0
[joints.cam]
connect = ["disc.C", "follower.C"]
{shape}
{contact}
{more}
[drivers.motor]
joint = "pin"
angle = "{start} + {W}*t"
[initial]
follower = {{ y = {float(lift(shape, 0.0))!r} }}
"""


@pytest.mark.parametrize("shape", [FLAT, ROUND, ROLLER], ids=["flat", "round", "roller"])
def test_follower_lifts_off_and_lands_where_the_closed_form_says(shape):
    off, on, speed = flight(shape)
    r = rt.loads(text(shape)).simulate(on + 0.02, t_eval=[0, off / 2, on + 0.02], **FINE)
    release = next(e.t for e in r.events if e.kind == "release")
    hit = next(e for e in r.events if e.kind == "impact")
    assert release == pytest.approx(off, abs=1e-7)  # the force vanishes with a slope: its tolerance over that
    assert hit.t == pytest.approx(on, abs=1e-9)
    assert hit.normal_speed / speed == pytest.approx(incline(shape, on), abs=1e-6)
    second = slopes(shape, W * off / 2)[1]
    assert r["follower.y"][1] == pytest.approx(lift(shape, W * off / 2), abs=1e-10)
    assert r["cam.fy"][1] == pytest.approx(2 * (G + W * W * second), abs=1e-6)
    assert abs(r["energy.balance"]).max() < 1e-8  # of about 1 J, by the tolerances


def test_a_start_in_contact_with_a_speed_of_rounding_is_no_impact():
    m = rt.example("cam_lift_off")  # begins on the base circle, where the speed of the face is 0 but for rounding
    r = m.simulate(1e-3)
    assert [event.kind for event in r.events] == ["contact"]
    assert r["face.normal"][0] > 0.0
    pin = rt.example("bouncing_pin").set({"initial.pin": {"x": "c", "y": 0, "vx": 1e-9}})  # slow, but on its way
    assert pin.simulate(1e-6).events[0].kind == "impact"


def incline(shape, t):
    """Cosine of the angle of the normal to the way of the follower at the time t [s]."""
    if shape == FLAT:
        return 1.0
    return math.sqrt(R**2 - (E * math.cos(W * t)) ** 2) / R


@pytest.mark.machine
@pytest.mark.parametrize("shape", [FLAT, ROUND], ids=["flat", "round"])
def test_stiff_contacts_and_time_stepping_approach_the_rigid_flight(shape):
    _, on, _ = flight(shape)
    t = [0, 0.8 * on]
    rigid = rt.loads(text(shape)).simulate(t[1], t_eval=t, **FINE)
    soft = 'contact = { model = "kelvin-voigt", stiffness = 1e7, exponent = 1, restitution = 0.1 }'
    r = rt.loads(text(shape, soft)).simulate(t[1], t_eval=t, rtol=1e-8, atol=1e-10)
    assert r["follower.y"][1] == pytest.approx(rigid["follower.y"][1], abs=2e-4)
    assert abs(r["energy.balance"]).max() < 1e-6
    stepped = rt.loads(text(shape)).simulate(t[1], t_eval=t, method="moreau", step=1e-4)
    assert stepped["follower.y"][1] == pytest.approx(rigid["follower.y"][1], abs=5e-4)  # first order in h


def test_a_heavy_or_slow_follower_stays_on_its_cam():
    """Just below the speed at which e w^2 = g there is no lift-off."""
    slow = text(FLAT).replace(f"{W}*t", f"{0.999 * math.sqrt(G / E)}*t")
    r = rt.loads(slow).simulate(0.5, t_eval=[0, 0.5], **FINE)
    assert [e.kind for e in r.events] == ["contact"]
    both = rt.loads(slow).ideal().simulate(0.5, t_eval=[0, 0.5], **FINE)
    assert r["follower.y"] == pytest.approx(both["follower.y"], abs=1e-10)


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ("clearance = 1e-3", "cannot have clearance"),
        ('contact = { model = "impact", friction = 0.1 }', "has no friction"),
        ('contact = { model = "impact", bush_radius = 0.1 }', "has no bush"),
        ('contact = "massless-link"', "does not work on a cam joint"),
    ],
)
def test_what_a_one_sided_cam_cannot_have_is_refused(more, says):
    with pytest.raises(rt.ModelError, match=says):
        rt.loads(text(ROUND, "", more=more))


def test_follower_inside_of_its_cam_is_refused():
    inside = text(FLAT).replace(
        "follower = { y = 0.05 }", "follower = { x = 0, y = 0.04, angle = 0 }\ndisc = { angle = 0 }"
    )
    with pytest.raises(rt.AssemblyError, match=r"starts 0\.01 m inside a cam"):
        rt.loads(inside).simulate(0.1)


@pytest.mark.parametrize(("shape", "incline"), [(FLAT, 1.0), (ROUND, 0.8)], ids=["flat", "round"])
def test_equilibrium_says_whether_the_cam_would_have_to_pull(shape, incline):
    """A lift of 30 N is more than the weight of 19.62 N: nothing holds the follower down."""
    for lifted in (0.0, 30.0):
        load = f'[loads.lift]\ntype = "force"\nat = "follower.C"\nforce = [0, {lifted}]\n'
        (found,) = rt.loads(text(shape) + load).equilibrium()
        assert found["cam.normal"] == pytest.approx((2 * G - lifted) / incline, rel=1e-9)
        assert found.admissible == (lifted == 0.0)


def test_kinematics_needs_the_follower_held_on_both_sides():
    with pytest.raises(rt.ModelError, match=r"on one side only in cam: close it with ideal\(\)"):
        rt.loads(text(FLAT)).kinematics([0.0])
    assert rt.loads(text(FLAT)).ideal().kinematics([0.1])["follower.y"] == pytest.approx(lift(FLAT, 0.1 * W), abs=1e-12)
