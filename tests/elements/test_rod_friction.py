"""Friction in the pins of rods: as a body without mass, and as a light one, between two pins; friction circles."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rattle as rt

LENGTH, CRANK, MU, PIN = 0.3, 0.1, 0.2, 0.015
FRAME = """
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.crank]
points = { O = [0, 0], P = [0.1, 0] }
mass = 1
inertia = 0.01
[bodies.slider]
points = { C = [0, 0] }
mass = 2
inertia = 0.01
[joints.pin]
type = "revolute"
connect = ["ground.O", "crank.O"]
[joints.guide]
type = "prismatic"
connect = ["ground.O", "slider.C"]
angle = 0
STOP
[loads.turn]
type = "torque"
body = "crank"
torque = TORQUE
[loads.push]
type = "force"
at = "slider.C"
force = [PUSH, 0]
LINK
[initial]
crank = { angle = "60 deg", omega = OMEGA }
slider = { x = "0.05 + sqrt(0.09 - 0.0075)" }
"""
ROD = '[joints.rod]\ntype = "rod"\nconnect = ["crank.P", "slider.C"]\nlength = 0.3\nfriction = FRICTION'
BODY = """
[bodies.link]
bar = ["A", "B"]
length = 0.3
mass = MASS
[joints.one]
type = "revolute"
connect = ["crank.P", "link.A"]
friction = FRICTION
[joints.two]
type = "revolute"
connect = ["link.B", "slider.C"]
friction = FRICTION
"""
COULOMB = f"{{ mu = {MU}, mu_static = 0.25, pin_radius = {PIN} }}"
EVEN = f"{{ mu = {MU}, pin_radius = {PIN} }}"
SMOOTH = f'{{ model = "coulomb-smooth", mu = {MU}, v1 = "1 mm/s", pin_radius = {PIN} }}'


def linkage(link: str, torque="3", push="0", omega=1.0, friction=COULOMB, stop="") -> rt.Mechanism:
    text = FRAME.replace("LINK", link)
    for key, value in (
        ("TORQUE", torque), ("PUSH", push), ("OMEGA", omega), ("FRICTION", friction), ("STOP", stop), ("MASS", 0),
    ):  # fmt: skip
        text = text.replace(
            key, str(value) if isinstance(value, float | int) else f'"{value}"' if key in ("TORQUE", "PUSH") else value
        )
    return rt.loads(text)


CASES = {
    "turns": {"friction": EVEN},
    "stays and goes": {"torque": "2*cos(8*t)", "push": "3*sin(5*t)", "omega": 0},
    "smooth": {"friction": SMOOTH},
    "strikes": {"torque": "1", "stop": 'stop = { min = "210 mm", contact = { model = "impact", restitution = 0.4 } }'},
    "rests on a stop": {
        "torque": "1",
        "stop": 'stop = { min = "210 mm", contact = { model = "impact", restitution = 0 } }',
    },
}


@pytest.mark.parametrize("case", CASES)
def test_a_rod_with_friction_is_a_body_without_mass_between_two_pins(case):
    fine = {"rtol": 1e-10, "t_eval": np.linspace(0.0, 0.6, 61)}
    rod, body = (linkage(one, **CASES[case]).simulate(0.6, **fine) for one in (ROD, BODY))
    assert rod.success
    assert body.success
    assert rod["slider.x"] == pytest.approx(body["slider.x"], abs=1e-6)
    assert rod["crank.omega"] == pytest.approx(body["crank.omega"], abs=1e-4)
    if "stop" in CASES[case]:  # where all rest, friction and reactions are not unique
        return
    for mine, other in (
        ("rod.friction_a", "one.friction"),
        ("rod.friction_b", "two.friction"),
        ("rod.fx", "two.fx"),
        ("rod.fy", "two.fy"),
    ):
        size = abs(body[other]).max()
        assert rod[mine] == pytest.approx(body[other], abs=1e-5 * size)
    assert rod["energy.dissipated"] == pytest.approx(body["energy.dissipated"], abs=1e-5)
    assert rod["energy.balance"] == pytest.approx(np.zeros(61), abs=1e-6)


def test_a_light_body_tends_to_the_rod_with_its_mass():
    fine = {"rtol": 1e-10, "t_eval": [0.0, 0.3]}
    rod = linkage(ROD).simulate(0.3, **fine)["crank.angle"][-1]
    off = [
        abs(linkage(BODY.replace("MASS", str(m))).simulate(0.3, **fine)["crank.angle"][-1] - rod) for m in (1e-3, 1e-4)
    ]
    assert off[0] < 2e-3
    assert off[1] == pytest.approx(0.1 * off[0], rel=0.02)


@pytest.mark.nojit
def test_a_rod_holds_between_the_tangents_of_its_friction_circles():
    """Circles of radius mu R about both pins: the force runs along their inner common tangents."""
    push, mu = 50.0, 0.25
    held = linkage(ROD, push=-push, torque=1.0).holds("turn")
    angle = math.asin(-CRANK * math.sin(math.pi / 3) / LENGTH)
    tilt = math.asin(2 * mu * PIN / LENGTH)
    p, c = np.array([0.5, math.sqrt(0.75)]) * CRANK, np.array([0.5 * CRANK + LENGTH * math.cos(angle), 0.0])
    moments = []
    for sign in (1.0, -1.0):
        way = np.array([math.cos(angle + sign * tilt), math.sin(angle + sign * tilt)])
        middle = 0.5 * (p + c)  # inner tangents of equal circles cross in the middle
        force = push / way[0] * way  # of the rod on the slider, which its guide keeps level
        moments.append(float(middle[0] * force[1] - middle[1] * force[0]))
    assert (held.low, held.high) == pytest.approx(tuple(sorted(moments)), rel=1e-9)


@pytest.mark.parametrize("stopped", [False, True])
@pytest.mark.parametrize("seed", [0, 2, 7, 41, 53])
def test_random_linkages_with_rods_move_as_with_bodies_without_mass(seed, stopped):
    """Where a stop catches the crank it comes to rest with both pins rough, and leaves again."""
    rng = np.random.default_rng(seed)
    length, mu, pin, amplitude = rng.uniform([0.2, 0.05, 0.002, -3.0], [0.4, 0.5, 0.03, 3.0])
    first, second, way = rng.uniform(-3.0, 3.0, 3).tolist()
    x, y = 0.15 * np.array([math.cos(first), math.sin(first)]) + length * np.array([math.cos(way), math.sin(way)])
    axle = [float(x - 0.15 * math.cos(second)), float(y - 0.15 * math.sin(second))]
    friction = f"{{ mu = {mu}, mu_static = {1.2 * mu}, pin_radius = {pin} }}"
    contact = 'contact = { model = "impact", restitution = 0.4 }'
    ends = f"stop = {{ min = {first - 0.3}, max = {first + 0.3}, {contact} }}" if stopped else ""
    text = f"""
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
G = {axle}
[bodies.crank]
points = {{ O = [0, 0], P = [0.15, 0] }}
center = [0.1, 0]
mass = 1
inertia = 0.01
[bodies.slider]
points = {{ O = [0, 0], C = [0.15, 0] }}
center = [0.05, 0.03]
mass = 2
inertia = 0.01
[joints.left]
type = "revolute"
connect = ["ground.O", "crank.O"]
{ends}
[joints.right]
type = "revolute"
connect = ["ground.G", "slider.O"]
[loads.turn]
type = "torque"
body = "crank"
torque = "{amplitude}*cos({rng.uniform(1.0, 10.0)}*t)"
LINK
[initial]
crank = {{ angle = {first}, omega = {rng.uniform(-5.0, 5.0)} }}
slider = {{ angle = {second} }}
"""
    mine, other = (
        rt.loads(
            text.replace("LINK", link).replace("length = 0.3", f"length = {length}")
            .replace("FRICTION", friction).replace("MASS", "0")
            + (f"link = {{ angle = {way} }}\n" if link == BODY else "")
        ).simulate(0.5, rtol=1e-9, t_eval=np.linspace(0.0, 0.5, 26))
        for link in (ROD, BODY)
    )  # fmt: skip
    assert mine.success
    assert other.success
    assert mine["crank.angle"] == pytest.approx(other["crank.angle"], abs=1e-5)
    assert mine["energy.dissipated"] == pytest.approx(other["energy.dissipated"], abs=1e-5)
