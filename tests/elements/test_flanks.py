"""Involute teeth with backlash: two flanks that push, at any distance of the centres; what is refused."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import rattle as rt

pytestmark = pytest.mark.nojit

FINE = {"rtol": 1e-11, "atol": 1e-13}
ALPHA = math.radians(20.0)
DEAD = 'contact = { model = "impact", restitution = 0 }'


def inv(angle):
    return math.tan(angle) - angle


def wheel(name, at, inertia=1e-3):
    return f"""
[bodies.{name}]
points = {{ C = [0, 0] }}
mass = 1
inertia = {inertia}
[joints.{name}_pin]
type = "revolute"
connect = ["ground.{at}", "{name}.C"]
"""


def pair(distance, mesh, more="", law="0", radii="[0.02, 0.04]", initial=""):
    return f"""
format = 1
gravity = [0, 0]
[ground.points]
O = [0, 0]
Q = [{distance!r}, 0]
{wheel("one", "O")}{wheel("two", "Q")}
[joints.mesh]
type = "gear"
connect = ["one.C", "two.C"]
radii = {radii}
{mesh}
[drivers.motor]
joint = "one_pin"
angle = "{law}"
{more}
[initial]
{initial}
"""


def flanked(backlash=0.0, contact=DEAD):
    return f'pressure_angle = "20 deg"\nbacklash = {backlash!r}\n{contact}\n'


def push(torque):
    return f'[loads.push]\ntype = "torque"\nbody = "two"\ntorque = "{torque}"\n'


def pushed_both_ways(distance, mesh, radii):
    """Angles to which wheel two turns until a flank holds it, and the last result."""
    found = []
    for torque in (1, -1):
        r = rt.loads(pair(distance, mesh, push(torque), radii=radii)).simulate(0.02, t_eval=[0, 0.02], **FINE)
        found.append(r["two.angle"][1])
    return found, r


@pytest.mark.parametrize("ring", [False, True])
def test_backlash_and_direction_of_the_force_change_with_the_distance_as_involutes_do(ring):
    radii, base = ("[0.04, 0.02]", 0.02 * math.cos(ALPHA)) if ring else ("[0.02, 0.04]", 0.06 * math.cos(ALPHA))
    distance = 0.01995 if ring else 0.06005
    angles, r = pushed_both_ways(distance, flanked() + ("internal = true" if ring else ""), radii)
    working = math.acos(base / distance)
    play = 2 * base * (inv(working) - inv(ALPHA)) * (-1 if ring else 1)  # in a ring centres that come nearer free it
    arm = (0.02 if ring else 0.04) * math.cos(ALPHA)
    assert arm * (angles[0] - angles[1]) == pytest.approx(play, abs=1e-10)
    force = np.array([r["two_pin.fx"][1], r["two_pin.fy"][1]])
    assert math.hypot(*force) == pytest.approx(1 / arm, rel=1e-9)
    assert abs(force[0] / force[1]) == pytest.approx(math.tan(working), rel=1e-9)
    # teeth push the wheels apart, a wheel to the middle of its ring: the pin holds it against that
    assert force[0] * (-1 if ring else 1) < 0


def test_ratio_does_not_depend_on_the_distance_of_the_centres():
    """Wheel one drives against a load; wheel two follows by the ratio of the radii while the centre of two moves."""
    apart = pair(0.0602, flanked(1e-5), push(-1), law="3*t + 20*t**2")
    r = rt.loads(apart).simulate(0.5, t_eval=[0, 0.2, 0.5], **FINE)
    assert r["two.angle"][2] - r["two.angle"][1] == pytest.approx(
        -0.5 * (r["one.angle"][2] - r["one.angle"][1]), abs=1e-10
    )
    moment = r["two_pin.force"][2] * 0.04 * math.cos(ALPHA)
    assert moment == pytest.approx(abs(1.0 - 1e-3 * 20.0), rel=1e-8)  # load and inertia


@pytest.mark.machine
def test_free_wheel_hits_both_flanks_as_the_symmetric_closed_form_says():
    """Driver A sin(w t) along the line, total play b, restitution e: A cos p = -K (2 A sin p + b)."""
    ratio, e, size, w = 3.0, 0.5, 1e-3, 100.0
    play, share = ratio * size, (1 - e) / (math.pi * (1 + e))

    def fault(p):
        return size * math.cos(p) + share * (2 * size * math.sin(p) + play)

    p = brentq(fault, math.pi / 2, math.pi, xtol=1e-15)
    speed = (2 * size * math.sin(p) + play) * w / math.pi
    # the phase at which the driver passes the middle of the free wheel's flight, from one flank to the other

    def middle(f):
        return -(size * math.sin(p) + play / 2) + speed * (f - p - math.pi) / w - size * math.sin(f)

    f = brentq(middle, p + math.pi, p + 2 * math.pi, xtol=1e-15)
    arm_one, arm_two = 0.02 * math.cos(ALPHA), 0.04 * math.cos(ALPHA)
    law = f"{size / arm_one!r}*(sin({w}*t + {f!r}) - {math.sin(f)!r})"
    mesh = flanked(play, f'contact = {{ model = "impact", restitution = {e} }}')
    model = pair(0.06, mesh, law=law, initial=f"two = {{ omega = {-speed / arm_two!r} }}")
    turns = 2
    r = rt.loads(model).simulate(turns * 2 * math.pi / w, rtol=1e-10, atol=1e-12)
    hits = [one for one in r.events if one.kind == "impact"]
    assert len(hits) == 2 * turns
    assert [one.normal_speed for one in hits] == pytest.approx([2 * speed / (1 + e)] * len(hits), abs=1e-8)


def test_elastic_teeth_swing_on_their_stiffness():
    """A wheel held by teeth without backlash swings at sqrt(k r^2/J): one flank or the other, both as stiff."""
    soft = 'contact = { model = "hertz", stiffness = 1e6, exponent = 1 }'
    arm = 0.04 * math.cos(ALPHA)
    w = math.sqrt(1e6 * arm**2 / 1e-3)
    model = pair(0.06, flanked(0.0, soft), initial="two = { omega = 1 }")
    t = np.linspace(0.0, 0.004, 5)
    r = rt.loads(model).simulate(0.004, t_eval=t, rtol=1e-10, atol=1e-12)
    assert r["two.angle"] == pytest.approx(np.sin(w * t) / w, abs=1e-9)
    assert abs(r["energy.balance"]).max() < 1e-9


@pytest.mark.parametrize(
    ("mesh", "says"),
    [
        ('pressure_angle = "20 deg"', "pressure_angle: needs a contact"),
        ('backlash = "0.1 mm"', "backlash: needs a contact"),
        (DEAD, "contact: needs pressure_angle"),
        ('pressure_angle = "70 deg"\n' + DEAD, "70 deg is outside of 0 to 45 deg"),
        (flanked(0.02), "backlash: 0.02 m is more than between teeth"),
        (flanked(-1e-3), "backlash"),
        (flanked() + "clearance = 1e-3", "gear joint cannot have clearance"),
        ('pressure_angle = "20 deg"\ncontact = { model = "impact", friction = 0.1 }', "has no friction"),
    ],
)
def test_what_teeth_cannot_have_is_refused(mesh, says):
    with pytest.raises(rt.ModelError, match=says):
        rt.loads(pair(0.06, mesh))


@pytest.mark.parametrize(
    ("distance", "says"), [(0.0599, "inside the teeth of its partner"), (0.07, "need a distance of the centres")]
)
def test_centres_too_near_or_too_far_for_the_teeth_are_refused(distance, says):
    with pytest.raises(rt.AssemblyError, match=says):
        rt.loads(pair(distance, flanked(1e-5))).simulate(0.1)
