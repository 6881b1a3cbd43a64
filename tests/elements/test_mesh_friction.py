"""Friction of teeth: how far they slide, against the loss factor of the standards; steady rotation; self-locking."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rattle as rt
from rattle.elements.joints import mesh

MODULE, ALPHA = 2e-3, math.radians(20.0)
OWN = {"module": MODULE, "pressure_angle": ALPHA}


def tip_ratio(teeth: int) -> float:
    """Contact ratio from the pitch point to the tips of a wheel with that many teeth of full height."""
    tan = math.tan(ALPHA)
    return (math.sqrt((teeth / 2 + 1) ** 2 / (teeth / 2 * math.cos(ALPHA)) ** 2 - 1) - tan) * teeth / (2 * math.pi)


def arm_of(joint: str, radii: tuple[float, float], own: dict[str, float] = OWN) -> float:
    size = (own["module"], own["pressure_angle"])
    first = {"gear": mesh.wheel, "ring": mesh.ring}
    a = first[joint](radii[0], *size) if joint in first else mesh.straight(*size)
    return mesh.arm(a, mesh.wheel(radii[1], *size), own)


@pytest.mark.nojit
@pytest.mark.parametrize(("z1", "z2"), [(20, 40), (25, 25), (30, 100)])
def test_wheels_lose_what_the_standard_says(z1, z2):
    """1 - eta = mu pi (1/z1 + 1/z2) (1 - eps + eps1^2 + eps2^2), of the power of the mesh."""
    r1, r2, e1, e2 = z1 * MODULE / 2, z2 * MODULE / 2, tip_ratio(z1), tip_ratio(z2)
    assert 1.0 < e1 + e2 < 2.0
    loss = arm_of("gear", (r1, r2)) * (1 / r1 + 1 / r2)
    assert loss == pytest.approx(math.pi * (1 / z1 + 1 / z2) * (1 - e1 - e2 + e1**2 + e2**2), rel=1e-12)


@pytest.mark.parametrize(
    ("joint", "first", "second"), [("gear", 17, 17), ("ring", 40, 30), ("ring", 200, 20), ("rack", 0, 25)]
)
def test_the_arm_is_the_mean_distance_of_all_pairs_in_contact(joint, first, second):
    """By counting pairs at many positions between two pitches; tips are cut where they leave the line of action."""
    r1, r2, sin, cos = first * MODULE / 2, second * MODULE / 2, math.sin(ALPHA), math.cos(ALPHA)
    s = np.linspace(
        -10 * MODULE, 10 * MODULE, 400001
    )  # along the line of action; the wheel on B is at (0, -r2) about it
    on_b = np.hypot(s * cos, r2 + s * sin) <= r2 + MODULE
    if joint == "rack":
        on_a = s * sin >= -MODULE
    else:
        side = -1.0 if joint == "ring" else 1.0
        far = np.hypot(s * cos, r1 - side * s * sin)
        on_a = far >= r1 - MODULE if joint == "ring" else far <= r1 + MODULE
    reached = s[on_a & on_b & (s >= -r2 * sin) & ((s <= r1 * sin) | (joint != "gear"))]
    pitch = math.pi * MODULE * cos
    sums, count = np.zeros(20001), np.zeros(20001)
    phases = (np.arange(20001) + 0.5) / 20001 * pitch
    for k in range(-5, 5):
        place = phases + k * pitch
        touches = (place > reached[0]) & (place < reached[-1])
        sums += np.where(touches, abs(place), 0.0)
        count += touches
    assert arm_of(joint, (r1, r2)) == pytest.approx((sums / count).mean() / cos, rel=2e-4)


def train(joint: str, radii: tuple[float, float], mu: float, brake: float, more: str = "") -> str:
    """A driven wheel or ring, or a rack that slides, and a wheel with a brake or a motor [N m]."""
    ra, rb = radii
    distance = -rb if joint == "rack" else ra - rb if joint == "ring" else ra + rb
    teeth = f"friction = {{ mu = {mu}, module = {MODULE} }}"
    where = f"[0, {distance}]" if joint == "rack" else f"[{distance}, 0]"
    kind = f'type = "rack"\nradius = {rb}' if joint == "rack" else f'type = "gear"\nradii = [{ra}, {rb}]'
    own = '"prismatic"\nangle = 0' if joint == "rack" else '"revolute"'
    return f"""
format = 1
[ground.points]
A = [0, 0]
B = {where}
[bodies.first]
points = {{ C = [0, 0] }}
mass = 1
inertia = 1e-3
[bodies.second]
points = {{ C = [0, 0] }}
mass = 1
inertia = 1e-3
[joints.input]
type = {own}
connect = ["ground.A", "first.C"]
[joints.output]
type = "revolute"
connect = ["ground.B", "second.C"]
[joints.teeth]
{kind}
{"internal = true" if joint == "ring" else ""}
connect = ["first.C", "second.C"]
{teeth}
[loads.brake]
type = "torque"
body = "second"
torque = {brake}
{more}
"""


@pytest.mark.parametrize("drives", [True, False])
@pytest.mark.parametrize(("joint", "radii"), [("gear", (0.02, 0.05)), ("ring", (0.08, 0.02)), ("rack", (1.0, 0.025))])
def test_steady_rotation_has_the_efficiency_of_the_closed_form(joint, radii, drives):
    """The wheel on B turns with the tooth force F r less mu e F where it is driven, and more where it drives."""
    mu, w = 0.08, 30.0
    ra, rb = radii
    motion = f'[drivers.motor]\njoint = "input"\n{"position" if joint == "rack" else "angle"} = "{w}*t"\n'
    turns = {"gear": -w * ra / rb, "ring": w * ra / rb, "rack": -w / rb}[joint]
    brake = (-1.0 if drives else 1.0) * math.copysign(5.0, turns)
    r = rt.loads(train(joint, radii, mu, brake, motion)).simulate(0.2, rtol=1e-10)
    e = mu * arm_of(joint, radii)
    relative = abs(turns - (0.0 if joint == "rack" else w))
    # powers: rb F |turns| from the pitch circles; friction takes e F of the relative rotation, on either wheel
    own = 1.0 if (turns - (0.0 if joint == "rack" else w)) * turns > 0.0 else -1.0  # friction brakes B, or drives it
    force = 5.0 / (rb + (-1.0 if drives else 1.0) * own * e)
    assert r["energy.balance"] == pytest.approx(np.zeros(len(r.t)), abs=1e-9)
    assert abs(r["teeth.friction"]) == pytest.approx(e * force, rel=1e-9)
    assert r["energy.dissipated"][-1] == pytest.approx(e * force * relative * 0.2, rel=1e-9)
    supplied = r["motor.power"][-1]
    assert supplied == pytest.approx((1 if drives else -1) * 5.0 * abs(turns) + e * force * relative, rel=1e-9)
    efficiency = 5.0 * abs(turns) / supplied if drives else -supplied / (5.0 * abs(turns))
    assert 0.97 < efficiency < 1.0


FIXED, PLANET, SECOND, OUT = 0.04, 0.02, 0.0202, 0.0398  # one planet, two wheels: 66 turns of the carrier for one


def reducer(mu: float, brake: float, arm: float) -> str:
    teeth = f"friction = {{ mu = {mu}, module = 1e-3 }}"
    return f"""
format = 1
[ground.points]
O = [0, 0]
[bodies.carrier]
points = {{ C = [0, 0], P = [{FIXED + PLANET}, 0] }}
mass = 0.1
inertia = 1e-5
[bodies.planet]
points = {{ C = [0, 0] }}
mass = 0.1
inertia = 1e-5
[bodies.out]
points = {{ C = [0, 0] }}
mass = 1
inertia = 1e-3
[joints.axle]
type = "revolute"
connect = ["ground.O", "carrier.C"]
[joints.pin]
type = "revolute"
connect = ["carrier.P", "planet.C"]
[joints.bearing]
type = "revolute"
connect = ["ground.O", "out.C"]
[joints.fixed]
type = "gear"
connect = ["ground.O", "planet.C"]
radii = [{FIXED}, {PLANET}]
{teeth}
[joints.moved]
type = "gear"
connect = ["planet.C", "out.C"]
radii = [{SECOND}, {OUT}]
{teeth}
[loads.load]
type = "torque"
body = "out"
torque = {brake}
[loads.hand]
type = "torque"
body = "carrier"
torque = {arm}
"""


def moments_of_hand(mu: float, load: float) -> tuple[float, float]:
    """The moments on the carrier that just turn it back and on, by the balance of output wheel, planet and carrier."""
    size = {"module": 1e-3, "pressure_angle": ALPHA}
    e1 = mu * arm_of("gear", (FIXED, PLANET), size)
    e2 = mu * arm_of("gear", (SECOND, OUT), size)
    found = []
    for sense in (-1.0, 1.0):  # of the carrier, with the planet at 3 and the output at -1/66 of its rate
        f2 = -load / (OUT + sense * math.copysign(e2, -load))
        f1 = -SECOND * f2 / PLANET
        for _ in range(50):
            tau1, tau2 = -sense * e1 * abs(f1), sense * e2 * abs(f2)
            f1 = -(SECOND * f2 + tau1 - tau2) / PLANET
        found.append((FIXED + PLANET) * (f1 + f2))
    return min(found), max(found)


@pytest.mark.parametrize("mu", [0.02, 0.1])
def test_a_reducer_of_nearly_equal_wheels_locks_itself_from_a_friction_on(mu):
    """With mu = 0.02 the load drives the carrier, with 0.1 no load can: its teeth hold any."""
    m = rt.loads(reducer(mu, 5.0, 0.0))
    held = rt.loads(reducer(mu, 5.0, 1.0)).holds("hand")  # a load that is 0 has no direction
    low, high = moments_of_hand(mu, 5.0)
    assert (held.low, held.high) == pytest.approx((low, high), rel=1e-9)
    assert held.self_locking == (low < 0.0 < high) == (mu == 0.1)
    run = m.simulate(0.05)
    assert run.success
    assert (abs(run["out.angle"]).max() < 1e-12) == (mu == 0.1)
    if mu == 0.02:
        assert run["energy.balance"] == pytest.approx(np.zeros(len(run.t)), abs=1e-7 * run["energy.kinetic"].max())
    onward = rt.loads(reducer(mu, 5.0, 1.01 * high)).simulate(0.05)
    assert onward["carrier.omega"][-1] > 0.0


@pytest.mark.nojit
def test_teeth_without_a_size_or_with_an_impossible_one_are_refused_in_words():
    plain = train("gear", (0.02, 0.05), 0.1, 1.0)
    teeth = f"friction = {{ mu = 0.1, module = {MODULE} }}"
    for friction, words in (
        ("friction = 0.1", "needs module: pitch diameter over number of teeth"),
        ('friction = { mu = 0.1, module = "20 mm" }', "is too large for these pitch radii"),
        ('friction = { mu = 0.1, module = "2 mm", pressure_angle = "50 deg" }', "more than teeth have, 45 deg"),
    ):
        with pytest.raises(rt.ModelError, match=words):
            _ = rt.loads(plain.replace(teeth, friction)).model
