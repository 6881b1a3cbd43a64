"""Friction of cams and flat followers without play: slip rows are derivatives; closed forms of bead and follower."""

import math

import numpy as np
import pytest

import rattle as rt
from moving_bodies import FIRST, A, B, H, Path, body_at, field_values, rng_for
from rattle import registry
from rattle.jit import layout as at
from rattle.language.local_function import packed

pytestmark = pytest.mark.nojit


def touching(kind, rng):
    """Path of two bodies on which a joint of this kind stays closed, and its parameters."""
    joint = next(one for one in registry.kinds("joint").values() if kind.name in one.leaf.tangents)
    fields = dict(zip(joint.fields, field_values(joint, rng), strict=True))
    fields |= {"roller": 0.0} if "roller" in fields else {}
    points, slips = list(rng.uniform(-1, 1, 4)), [0.0] if joint.leaf.placing else []
    return joint, np.array(packed([*points, *fields.values(), *slips])), Path(rng)


@pytest.mark.parametrize("place", range(4))
@pytest.mark.parametrize("name", [name for name, kind in registry.kinds("tangent").items() if kind.leaf.unit == "N"])
def test_slip_goes_along_the_surface_and_gamma_completes_its_rate(name, place):
    """B is moved along the normal so that the joint stays closed; the rates are those of this path."""
    kind = registry.kinds("tangent")[name]
    joint, p, path = touching(kind, rng_for(name, str(place)))

    def closed(t):
        q = path.q(t)
        for _ in range(40):
            rows = np.zeros((1, at.width("rows")))
            joint.kernel(body_at(q, np.zeros((3, 3))), A, B, p, 0, 0, rows)
            w = rows[0, at.BX : at.BX + 2]
            q[B, :2] -= w * rows[0, at.RES] / (w @ w)
        return q

    def rates(t):
        return (closed(t + H) - closed(t - H)) / (2 * H)

    def slip(t):
        rows = np.zeros((1, at.width("rows")))
        q, v = closed(t), rates(t)
        kind.kernel(body_at(q, v), A, B, p, 0, 0, rows)
        return rows[0, at.AX :] @ np.concatenate([v[A], v[B]]), rows[0], q

    u, row, q = slip(0.3)
    normal = np.zeros((1, at.width("rows")))
    joint.kernel(body_at(q, rates(0.3)), A, B, p, 0, 0, normal)
    across, along = normal[0, at.BX : at.BX + 2], row[at.BX : at.BX + 2]
    assert along @ along == pytest.approx(1.0, abs=1e-12)
    assert across @ along == pytest.approx(0.0, abs=1e-9)
    assert math.hypot(*across) == pytest.approx(row[at.NU], rel=1e-9)
    step = 1e-3
    dv = (rates(0.3 + step) - rates(0.3 - step)) / (2 * step)
    change = (slip(0.3 + step)[0] - slip(0.3 - step)[0]) / (2 * step)
    wanted = row[at.AX :] @ np.concatenate([dv[A], dv[B]]) - row[at.GAMMA]
    assert change == pytest.approx(wanted, rel=1e-4, abs=1e-4)  # step^2 / 6 times third derivatives
    assert abs(u) > FIRST


def test_a_bead_on_a_rough_ring_loses_its_speed_with_the_angle():
    """N = m v^2/R, so v = v0/(1 + mu v0 t/R) and every radian takes the share mu; the ring stays where it is."""
    mu, ring, v0 = 0.3, 0.5, 2.0
    r = rt.loads(f"""
format = 1
[ground.points]
O = [0, 0]
[bodies.bead]
points = {{ P = [0, 0] }}
mass = 2
inertia = 1e-3
[joints.ring]
type = "cam"
connect = ["ground.O", "bead.P"]
radius = {ring}
friction = {mu}
[initial]
bead = {{ x = {ring}, y = 0, vx = 0, vy = {v0} }}
""").simulate(2.0)
    v = v0 / (1 + mu * v0 * r.t / ring)
    assert np.hypot(r["bead.vx"], r["bead.vy"]) == pytest.approx(v, rel=1e-7)
    assert np.unwrap(np.arctan2(r["bead.y"], r["bead.x"])) == pytest.approx(np.log(v0 / v) / mu, abs=1e-7)
    assert r["energy.dissipated"] == pytest.approx(v0**2 - v**2, abs=1e-6)


ECCENTRIC = """
format = 1
gravity = [0, -10]
[ground.points]
O = [0, 0]
[bodies.cam]
points = { C = [0, 0] }
mass = 1
inertia = 1e-3
[bodies.follower]
points = { F = [0, 0] }
mass = 2
inertia = 1
[joints.axle]
type = "revolute"
connect = ["ground.O", "cam.C"]
[joints.guide]
type = "prismatic"
connect = ["ground.O", "follower.F"]
axis = "90 deg"
angle = 0
[joints.face]
type = "flat-follower"
connect = ["cam.C", "follower.F"]
axis = "90 deg"
support = "0.05 + 0.02*cos(x)"
friction = MU
"""


@pytest.mark.parametrize("mu", [0.3, pytest.param(0.1, marks=pytest.mark.machine)])
def test_a_rough_flat_follower_needs_the_moment_of_its_lift_and_of_its_slip(mu):
    """The face slips at w y, y its height, so that M = N (dy/da + mu y), N = m (g + y'')."""
    w, t = 5.0, np.linspace(0.0, 1.2, 61)
    text = ECCENTRIC.replace("MU", str(mu)) + f'[drivers.motor]\njoint = "axle"\nangle = "{w}*t"\n'
    a = w * t
    y, lift, second = 0.05 + 0.02 * np.sin(a), 0.02 * np.cos(a), -0.02 * np.sin(a)
    wanted = 2 * (10 + second * w * w) * (lift + mu * y)
    for r in (rt.loads(text).inverse_dynamics(t), rt.loads(text).simulate(1.2, t_eval=t)):
        assert r["follower.y"] == pytest.approx(y, abs=1e-9)
        assert r["motor.torque"][1:] == pytest.approx(wanted[1:], abs=1e-6)
        assert abs(r["face.friction"][1:]) == pytest.approx(mu * 2 * (10 + second * w * w)[1:], abs=1e-6)


@pytest.mark.parametrize("mu", [0.1, 0.3])
def test_friction_on_a_cam_holds_its_follower_between_two_moments(mu):
    """At a = 0 the lift is 0.02 m per radian at the height of 0.05 m: M = m g (0.02 +- mu 0.05)."""
    text = ECCENTRIC.replace("MU", str(mu)) + '[loads.turn]\ntype = "torque"\nbody = "cam"\ntorque = 1\n'
    text += "[initial]\ncam = { angle = 0 }\n"
    found = rt.loads(text).holds("turn")
    ends = sorted(20 * (0.02 + sense * mu * 0.05) for sense in (-1.0, 1.0))
    assert (found.low, found.high) == pytest.approx(tuple(ends), rel=1e-9)


def test_a_roller_and_a_follower_that_lifts_off_have_no_friction_and_say_why():
    with pytest.raises(rt.ModelError, match="may lift off, and has no friction"):
        _ = rt.loads(ECCENTRIC.replace("MU", '0.1\ncontact = "impact"')).model
    rolling = ECCENTRIC.replace('"flat-follower"', '"cam"').replace('axis = "90 deg"\nsupport', "roller = 0.01\nradius")
    with pytest.raises(rt.ModelError, match="a roller rolls, and friction is in its pin"):
        _ = rt.loads(rolling.replace("MU", "0.1").replace("cos(x)", "cos(a)")).model
