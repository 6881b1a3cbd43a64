"""Points, coordinates of joints and records of loads: the same in expressions, results and traces, and right."""

from __future__ import annotations

import numpy as np
import pytest

import rattle as rt

MODEL = """format = 1
gravity = [0, -9.81]
[parameters]
k = 300
[signals]
tip = "arm.P.x + 2*arm.P.vy"
corner = "ground.Q.x"
bent = "hinge.angle - 0.1*hinge.rate"
slid = "rail.position + 0.5*rail.rate"
pinned = "slot.position*slot.rate"
pull = "rope.length + rope.rate + rope.force + rope.power"
twist = "coil.angle + coil.rate + coil.torque"
[ground.points]
O = [0, 0]
Q = [0.4, -0.3]
[bodies.arm]
points = { O = [0, 0], P = [0.5, 0.1], R = [0.2, 0] }
center = [0.25, 0.02]
mass = 2
inertia = 0.1
[bodies.block]
points = { A = [0, 0], B = [0.1, 0.2] }
mass = 1
inertia = 0.05
[bodies.pin]
points = { C = [0, 0.05] }
mass = 0.5
inertia = 0.01
[joints.hinge]
type = "revolute"
connect = ["ground.O", "arm.O"]
[joints.rail]
type = "prismatic"
connect = ["arm.R", "block.A"]
axis = "30 deg"
[joints.slot]
type = "slot"
connect = ["block.B", "pin.C"]
axis = "-40 deg"
[loads.rope]
type = "spring"
connect = ["ground.Q", "pin.C"]
stiffness = "k + 20*rope.rate"
free_length = "0.1 + 0.01*t"
damping = "2 + 1*hinge.rate"
[loads.coil]
type = "torsion-spring"
connect = ["ground", "arm"]
stiffness = "8 + 1*coil.angle"
free_angle = 0.3
damping = 0.4
[loads.ram]
type = "actuator"
connect = ["arm.P", "block.B"]
force = "5 - 3*ram.rate + 1*ram.length"
[loads.drive]
type = "motor"
connect = ["arm", "pin"]
torque = "0.2 - 0.01*speed"
[initial]
arm = { angle = -0.08686061416, omega = 0 }
block = { x = 0.213102221423, vx = 0 }
pin = { x = 0.290211428264, angle = 0.0238575720883, vx = 0, omega = 0 }
"""


def slope(t, y):
    return np.gradient(y, t, edge_order=2)


@pytest.fixture(scope="module")
def run():
    return rt.loads(MODEL).simulate(0.4, t_eval=np.linspace(0.0, 0.4, 4001), rtol=1e-11, atol=1e-12)


def test_rates_are_the_slopes_of_coordinates(run):
    pairs = {f"{load}.length": f"{load}.rate" for load in ("rope", "ram")}
    pairs |= {"hinge.angle": "hinge.rate", "rail.position": "rail.rate", "slot.position": "slot.rate"}
    pairs |= {"coil.angle": "coil.rate", "drive.angle": "drive.rate", "arm.P.x": "arm.P.vx", "arm.P.y": "arm.P.vy"}
    for name, rate in pairs.items():
        size = np.abs(run[rate]).max()
        assert size > 1e-3
        # differences over 1e-4 s: 1e-8 of the third derivative
        np.testing.assert_allclose(run[rate][5:-5], slope(run.t, run[name])[5:-5], atol=1e-4 * size, err_msg=name)


def test_expressions_have_the_values_of_results(run):
    for name, expected in (
        ("tip", run["arm.P.x"] + 2 * run["arm.P.vy"]),
        ("corner", np.full(len(run.t), 0.4)),
        ("bent", run["hinge.angle"] - 0.1 * run["hinge.rate"]),
        ("slid", run["rail.position"] + 0.5 * run["rail.rate"]),
        ("pinned", run["slot.position"] * run["slot.rate"]),
        ("pull", run["rope.length"] + run["rope.rate"] + run["rope.force"] + run["rope.power"]),
        ("twist", run["coil.length"] + run["coil.rate"] + run["coil.force"]),
    ):
        np.testing.assert_allclose(run[name], expected, rtol=1e-12, atol=1e-12, err_msg=name)


def test_forces_are_those_of_their_laws(run):
    rate, t = run["rope.rate"], run.t
    law = (300 + 20 * rate) * (run["rope.length"] - 0.1 - 0.01 * t) + (2 + run["hinge.rate"]) * rate
    np.testing.assert_allclose(run["rope.force"], law, rtol=1e-11, atol=1e-11)
    law = (8 + run["coil.angle"]) * (run["coil.angle"] - 0.3) + 0.4 * run["coil.rate"]
    np.testing.assert_allclose(run["coil.torque"], law, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(run["ram.force"], 5 - 3 * run["ram.rate"] + run["ram.length"], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(run["drive.force"], 0.2 - 0.01 * run["drive.rate"], rtol=1e-12, atol=1e-14)
    assert [run.unit(f"rope.{key}") for key in ("length", "rate", "force", "power")] == ["m", "m/s", "N", "W"]
    assert [run.unit(f"coil.{key}") for key in ("angle", "rate", "torque", "power")] == ["rad", "rad/s", "N*m", "W"]


def test_the_powers_of_all_loads_are_the_change_of_energy(run):
    """What loads give to the bodies is what these gain, moving and against gravity."""
    weight = 9.81 * (2 * run["arm.y"] + run["block.y"] + 0.5 * run["pin.y"])
    given = sum(run[f"{load}.power"] for load in ("rope", "coil", "ram", "drive"))
    steps = 0.5 * (given[1:] + given[:-1]) * np.diff(run.t)
    gained = run["energy.kinetic"] + weight
    # the trapezoidal rule over 1e-4 s
    np.testing.assert_allclose(gained - gained[0], np.append(0.0, np.cumsum(steps)), atol=1e-6 * np.abs(gained).max())


def test_traces_have_the_same_curves(run):
    m = rt.loads(MODEL)
    names = ["rope.force", "rope.power", "rail.position", "slot.rate", "coil.torque", "arm.P.vx", "pull"]
    s = m.sensitivity(names, ["k"], [0.0, 0.2, 0.4])
    for name in names:
        np.testing.assert_allclose(s[name], run[name][[0, 2000, 4000]], rtol=1e-6, atol=1e-7, err_msg=name)
    h = 0.01
    up, down = (m.set(k=300 + d).simulate(0.4, t_eval=[0.0, 0.2, 0.4], rtol=1e-11)["rope.force"] for d in (h, -h))
    np.testing.assert_allclose(s["d(rope.force)/d(k)"], (up - down) / (2 * h), atol=1e-5)


def test_a_joint_with_clearance_has_its_coordinate():
    m = rt.loads(
        MODEL.replace('connect = ["ground.O", "arm.O"]', 'connect = ["ground.O", "arm.O"]\nclearance = "1 mm"')
    )
    r = m.simulate(0.02, t_eval=[0.0, 0.01, 0.02])
    np.testing.assert_allclose(r["hinge.angle"], r["arm.angle"], rtol=1e-14)
    np.testing.assert_allclose(r["hinge.rate"], r["arm.omega"], rtol=1e-14)


def test_a_given_motion_and_a_rest_have_them_too():
    drivers = (
        '[drivers.motor]\njoint = "hinge"\nangle = "t"\n'
        '[drivers.push]\njoint = "rail"\nposition = "0.1*t"\n'
        '[drivers.spin]\nbody = "pin"\ncoordinate = "angle"\nangle = "0.2*t"\n'
        '[drivers.along]\njoint = "slot"\nposition = "0.3*t**2"\n'
    )
    text = MODEL + drivers
    r = rt.loads(text).kinematics([0.0, 0.3, 0.5])
    np.testing.assert_allclose(r["rail.position"], 0.1 * r.t, atol=1e-12)
    np.testing.assert_allclose(r["slot.rate"], 0.6 * r.t, atol=1e-12)
    rate = r["rope.rate"]
    law = (300 + 20 * rate) * (r["rope.length"] - 0.1 - 0.01 * r.t) + (2 + r["hinge.rate"]) * rate
    np.testing.assert_allclose(r["rope.force"], law, rtol=1e-12)
    m = (
        rt.Mechanism("weight", gravity=[0, -9.81])
        .ground(O=[0, 0])
        .body("weight", points={"C": [0, 0]}, mass=2, inertia=1)
    )
    m.prismatic("rail", "ground.O", "weight.C", axis="-90 deg", angle=0)
    m.load("rope", "spring", connect=["ground.O", "weight.C"], stiffness=100)
    m.initial("weight", y=-0.1)
    rest = m.equilibrium()[0]
    assert rest["rope.force"] == pytest.approx(2 * 9.81, rel=1e-9)
    assert rest["rope.length"] == pytest.approx(2 * 9.81 / 100, rel=1e-9)
    assert rest["rail.position"] == pytest.approx(2 * 9.81 / 100, rel=1e-9)


def test_a_body_that_nothing_holds_stays_in_a_given_motion():
    m = rt.Mechanism().ground(O=[0, 0])
    for name in ("wheel", "free"):
        m.body(name, points={"C": [0, 0]}, mass=1, inertia=1)
    m.revolute("pin", "ground.O", "wheel.C").driver("motor", "pin", angle="3*t + 0.2*sin(5*t)").initial("free", x=0.2)
    r = m.kinematics([0.0, 0.5, 1.0])
    np.testing.assert_allclose(r["wheel.angle"], 3 * r.t + 0.2 * np.sin(5 * r.t), atol=1e-12)
    np.testing.assert_array_equal(r["free.x"], 0.2)
    assert any("holds 'free'" in note for note in r.trust.notes)
    with pytest.raises(rt.ModelError, match="can still move: free"):
        m.inverse_dynamics([0.0, 0.5])


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("k + 20*rope.rate", "100 + 5*rope.force", "defined by itself: rope.force -> rope.force"),
        ("k + 20*rope.rate", "pull", "defined by itself: "),
        ("5 - 3*ram.rate + 1*ram.length", "5 + 2*coil.force", ""),
        ("8 + 1*coil.angle", "8 + 2*ram.force", ""),
        ("arm.P.x + 2*arm.P.vy", "arm.S.x", "unknown name 'arm.S.x'"),
        ("arm.P.x + 2*arm.P.vy", "hinge.position", "unknown name 'hinge.position'"),
        ("arm.P.x + 2*arm.P.vy", "rope.torque", "unknown name 'rope.torque'"),
        ("[loads.coil]", "[loads.hinge]", "the name 'hinge' is already used in [joints]"),
        ("k = 300", 'k = "rope.length"', "only parameters are allowed here"),
    ],
)
def test_what_these_names_cannot_do(old, new, message):
    text = MODEL.replace(old, new)
    if not message:
        _ = rt.loads(text).model
        return
    with pytest.raises(rt.ModelError) as caught:
        rt.loads(text)
    assert message in str(caught.value)


@pytest.mark.nojit
def test_two_loads_that_follow_each_other_are_a_loop():
    text = MODEL.replace("8 + 1*coil.angle", "8 + 2*ram.force").replace(
        "5 - 3*ram.rate + 1*ram.length", "5 + 2*coil.force"
    )
    with pytest.raises(rt.ModelError, match=r"defined by itself: (ram|coil)\.force -> (coil|ram)\.force -> "):
        rt.loads(text)


@pytest.mark.nojit
def test_a_driver_follows_none_of_them():
    text = MODEL + '[drivers.motor]\njoint = "hinge"\nangle = "0.1*t + 2*rail.position"\n'
    with pytest.raises(rt.ModelError, match=r"must depend on time only, but 'rail\.position' depends on the motion"):
        rt.loads(text)
