"""Derivatives of motions in which joints stick and slip: closed forms, and runs beside theirs."""

import math

import numpy as np
import pytest

import rattle as rt
from rattle.errors import TraceError
from rubbing import block, slider_crank
from runs_beside import FINE, differences

G = 9.81
PIN = '{ model = "coulomb", mu = "mu", mu_static = "1.4*mu", pin_radius = "r" }'


HOLDS = '{ model = "coulomb", mu = "mu", mu_static = "1.5*mu" }'


def slopes(found, output):
    """Derivatives of an output by all parameters (n, k)."""
    names = [name for name in found.names if name.startswith(f"d({output})/")]
    return np.array([found[name] for name in names]).T


def assert_as_beside(m, outputs, t, rel=1e-6, share=1e-5):
    """Derivatives of a motion that comes to its end are the differences of runs at values beside; returns them."""
    names = list(m.parameters)
    found = m.sensitivity(outputs, names, t_eval=t)
    assert found.success, found.message
    for output in outputs:
        columns = []
        for name in names:
            h = share * abs(m.parameters[name])
            low, high = (
                m.set({name: m.parameters[name] + way}).simulate(t_eval=t, rtol=1e-12, atol=1e-15) for way in (-h, h)
            )
            columns.append((high[output] - low[output]) / (2.0 * h))
        want = np.array(columns).T
        assert np.abs(want).max() > 0.0
        assert slopes(found, output) == pytest.approx(want, rel=rel, abs=rel * np.abs(want).max()), output
    return found


# ---------------------------------------------------------------- closed forms
def test_where_a_block_comes_to_rest():
    found = rt.loads(block(HOLDS)).sensitivity(
        ["block.x", "block.vx", "rail.friction"], ["mu", "v"], t_eval=[0.0, 0.2, 2.0]
    )
    mu, v = 0.2, 1.0
    assert slopes(found, "block.x") == pytest.approx(
        np.array([[0.0, 0.0], [-G * 0.02, 0.2], [-(v**2) / (2.0 * mu**2 * G), v / (mu * G)]]), rel=1e-9, abs=1e-12
    )
    assert slopes(found, "block.vx") == pytest.approx(np.array([[0.0, 1.0], [-G * 0.2, 1.0], [0.0, 0.0]]), abs=1e-9)
    assert slopes(found, "rail.friction") == pytest.approx(
        np.array([[-2.0 * G, 0.0], [-2.0 * G, 0.0], [0.0, 0.0]]), abs=1e-9
    )


def test_a_block_that_breaks_away_begins_later_and_with_a_jump():
    """Pushed by F t from rest: it slips from t0 = mu_static m g/F on, against mu m g."""
    mu, force, t = 0.2, 10.0, 1.5
    m = rt.loads(block(HOLDS, "F*t")).set(v=0.0)
    found = m.sensitivity(["block.vx", "block.x"], ["mu", "F"], t_eval=[0.3, t])
    begins = 1.5 * mu * 2.0 * G / force
    later, drive = t - begins, 0.5 * mu * G
    by_mu, by_force = 1.5 * 2.0 * G / force, -begins / force  # of the instant
    speed = [0.5 * G * later - drive * by_mu - 0.5 * force * later * by_mu,
             0.25 * later**2 - (drive + 0.5 * force * later) * by_force]  # fmt: skip
    assert slopes(found, "block.vx")[0] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert slopes(found, "block.vx")[1] == pytest.approx(speed, rel=1e-8)
    way = drive * later + 0.25 * force * later**2
    place = [0.25 * G * later**2 - way * by_mu, later**3 / 12.0 - way * by_force]
    assert slopes(found, "block.x")[1] == pytest.approx(place, rel=1e-8)


def test_how_far_a_pendulum_swings_before_its_friction_holds_it():
    m = rt.loads("""
format = 1
gravity = [0, -9.81]
parameters = { T = 0.15 }
ground.points.O = [0, 0]
bodies.one = { bar = ["A", "B"], length = 0.3, mass = 1 }
joints.O = { type = "revolute", connect = ["ground.O", "one.A"], friction = { torque = "T" } }
initial.one = { angle = 0.4, omega = 0 }
""")
    found = m.sensitivity(["one.angle"], ["T"], t_eval=[6.0])
    torque, weight, angle, sense, slope = 0.15, G * 0.15, 0.4, -1.0, 0.0
    turns = 0
    while abs(weight * math.cos(angle)) > torque:
        low, high = angle + 1e-3 * sense, -math.pi - angle

        def left(there, angle=angle, sense=sense):
            return weight * (math.sin(angle) - math.sin(there)) - torque * sense * (there - angle)

        for _ in range(80):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if left(low) * left(middle) > 0.0 else (low, middle)
        there = 0.5 * (low + high)
        by_there = -weight * math.cos(there) - torque * sense
        by_angle = weight * math.cos(angle) + torque * sense
        slope = (sense * (there - angle) - by_angle * slope) / by_there
        angle, sense, turns = there, -sense, turns + 1
    assert turns > 5
    assert found["one.angle"][-1] == pytest.approx(angle, abs=1e-8)
    assert found["d(one.angle)/d(T)"][-1] == pytest.approx(slope, rel=1e-6)


# ---------------------------------------------------------------- as runs beside
MOTIONS = {
    "pushed to and fro": (block(HOLDS, "F*sin(6*t)"), ["block.x", "block.vx", "energy.dissipated"], 2.0),
    "whose load breaks it loose for a short while": (
        block(HOLDS, "F*sin(9.3*t) - 24.4*block.x"), ["block.x", "block.vx"], 2.0,
    ),
    "on a belt": (block(HOLDS, "-40*block.x - 0.2*block.vx"), ["block.x", "block.vx"], 3.0),
    "a crank that comes to rest": (
        slider_crank(PIN),
        ["crank.angle", "crank.omega", "guide.friction", "energy.dissipated"], 0.6,
    ),
    "a crank that is driven": (
        slider_crank(PIN, "0.7 + 0.8*sin(omega*t)"), ["motor.torque", "guide.friction", "O.force"], 0.3,
    ),
    "beside a contact": (
        slider_crank(PIN, pin=(
            'clearance = 5e-4, contact = { model = "lankarani-nikravesh", stiffness = 2e8, exponent = 1.5,'
            " restitution = 0.5, bush_radius = 0.01 }"
        ), begins='crank = { angle = 0.7, omega = "omega" }\nB = { offset = [0, 0] }'),
        ["crank.angle", "guide.friction"], 0.02,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", MOTIONS)
def test_derivatives_are_those_of_runs_beside(name):
    text, outputs, t_end = MOTIONS[name]
    found = assert_as_beside(rt.loads(text), outputs, np.linspace(0.0, t_end, 8), rel=2e-5)
    assert found.stats["switchings"] > 0


@pytest.mark.parametrize("law", ["lugre", "dahl", "threlfall"])
def test_friction_of_joints_by_laws(law):
    m = rt.loads(f"""
format = 1
gravity = [0, -9.81]
parameters = {{ mu = 0.2, w = 3.0 }}
ground.points.O = [0, 0]
bodies.arm = {{ points = {{ A = [-0.2, 0] }}, mass = 1, inertia = 0.02 }}
[joints.O]
type = "revolute"
connect = ["ground.O", "arm.A"]
friction = {{ model = "{law}", mu = "mu", pin_radius = 0.02 }}
[initial]
arm = {{ angle = 0, omega = "w" }}
""")
    assert_as_beside(m, ["arm.angle", "arm.omega"], [0.3, 0.8], rel=2e-4, share=1e-4)


def test_a_wheel_that_a_belt_breaks_loose_at_once():
    """By the damping of the belt: Tf lessens what speeds it up from the first instant on."""
    m = rt.loads("""
format = 1
gravity = [0, 0]
parameters = { w = 5.0, Tf = 0.1 }
ground.points = { O = [0, 0], Q = [0.5, 0] }
bodies.motor = { points = { C = [0, 0] }, mass = 2, inertia = 0.03 }
bodies.wheel = { points = { C = [0, 0] }, mass = 2, inertia = 0.01 }
joints.O = { type = "revolute", connect = ["ground.O", "motor.C"] }
joints.Q = { type = "revolute", connect = ["ground.Q", "wheel.C"], friction = { torque = "Tf" } }
[joints.belt]
type = "belt"
connect = ["motor.C", "wheel.C"]
radii = [0.05, 0.1]
stiffness = 2000
damping = 10
pretension = 100
toothed = true
[initial]
motor = { angle = 0, omega = "w" }
wheel = { angle = 0, omega = 0 }
""")
    assert m.set(w=0.0).sensitivity(["wheel.omega"], ["w", "Tf"], t_eval=[0.01]).success  # the belt rests
    found = assert_as_beside(m, ["wheel.omega"], [0.0, 1e-6, 0.01])
    assert slopes(found, "wheel.omega")[1] == pytest.approx([1e-5, -1e-4], rel=1e-3)
    assert slopes(m.sensitivity(["Q.friction"], ["Tf"], t_eval=[0.0, 0.01]), "Q.friction")[:, 0] == pytest.approx(-1.0)


def test_a_load_that_grows_with_the_square_of_a_speed_from_rest():
    """Its sign turns with a rate that begins with the square of time, or rests at zero on a stop."""
    m = rt.loads(block(HOLDS, "-F*t - 0.5*block.vx*abs(block.vx)")).set({"initial.block.vx": 0.0})
    assert_as_beside(m, ["block.x", "block.vx"], [0.5, 1.5])
    rests = rt.loads(between_stops("F - 0.5*block.vx*abs(block.vx)", restitution=0.3))
    found = rests.sensitivity(["block.x", "rail.stop"], ["F", "mu"], t_eval=[0.05, 1.5])
    assert found.success, found.message
    assert slopes(found, "block.x")[-1] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert slopes(found, "rail.stop")[-1, 0] == pytest.approx(-1.0, rel=1e-6)


@pytest.mark.parametrize(
    "load", ["F*t - block.vx*abs(block.vx)", "-F*t - block.vx*abs(block.vx)", "F*t - abs(block.vx)"]
)
def test_a_load_that_begins_at_zero_with_a_kink_in_the_speed(load):
    threlfall = '{ model = "threlfall", mu = "mu", vr = 0.1 }'
    m = rt.loads(block(threlfall, load)).set({"initial.block.vx": 0.0})
    assert_as_beside(m, ["block.x"], [0.2, 0.4])
    if not load.startswith("-"):  # it presses on its stop
        stop = 'stop = { min = -0.3, max = 0.25, contact = { model = "impact", restitution = 0 } }'
        rests = rt.loads(block(threlfall, load, stop, x=0.25)).set({"initial.block.vx": 0.0})
        found = rests.sensitivity(["block.x", "rail.stop"], ["F"], t_eval=[0.0, 0.4])
        assert found.success, found.message
        assert slopes(found, "block.x")[-1, 0] == pytest.approx(0.0, abs=1e-12)
        assert slopes(found, "rail.stop")[-1, 0] == pytest.approx(-0.4, rel=1e-9)


def test_what_rests_on_its_stop_with_several_kinks_at_zero():
    threlfall = '{ model = "threlfall", mu = "mu" }'
    stop = 'stop = { min = -0.3, max = 0.25, contact = { model = "impact", restitution = 0 } }'
    m = rt.loads(block(threlfall, "2*F*sin(5*t)/10 - 2.6*block.vx*abs(block.vx)", stop)).set(v=-1.8)
    found = m.sensitivity(["block.x"], ["F"], t_eval=[0.1, 1.5])
    assert found.success, found.message
    assert found.stats["steps"] < 5000


def test_numbers_of_the_whole_run():
    m = rt.loads(block(HOLDS, "F*sin(6*t)"))
    outputs = ["max(block.x)", "mean(block.vx)", "rms(block.vx)", "first(block.vx < 0.1)", "max(abs(rail.friction))"]
    found = m.sensitivity(outputs, ["mu", "v"], t_eval=[2.0])
    for output in outputs:
        want = []
        for name in ("mu", "v"):
            values = m.parameters[name] + np.array([-1e-5, 1e-5])
            low, high = m.many({name: values}, [output], t_end=2.0, rtol=1e-12, atol=1e-15)[output]
            want.append((high - low) / 2e-5)
        assert slopes(found, output)[-1] == pytest.approx(want, rel=1e-6, abs=1e-7), output


def test_tolerances_follow_them():
    m = rt.loads(block(HOLDS, "F*sin(6*t)").replace("mu = 0.2", "mu = { value = 0.2, tol = 0.01 }"))
    found = m.tolerance("final(block.x)", t_end=2.0, n=16)
    assert found.how == "exact derivatives"
    alone = m.sensitivity(["block.x"], ["mu"], t_eval=[2.0])["d(block.x)/d(mu)"][-1]
    assert found.slopes["mu"] == pytest.approx(alone, rel=1e-8)


# ---------------------------------------------------------------- beside rigid contacts
def between_stops(push="0", restitution=0.5, x=0):
    contact = f'{{ model = "impact", restitution = {restitution} }}'
    return block(HOLDS, push, f"stop = {{ min = -0.1, max = 0.12, contact = {contact} }}", x)


def test_a_block_that_rebounds_from_a_stop_comes_to_rest():
    """From a stop at d it comes back by (e v1)^2/(2 mu g), with v1^2 = v^2 - 2 mu g d."""
    mu, v, e, d = 0.2, 1.0, 0.5, 0.12
    found = rt.loads(between_stops()).sensitivity(["block.x", "time(rail.contacts, 1)"], ["mu", "v"], t_eval=[0.0, 2.0])
    by_mu = e**2 * v**2 / (2.0 * mu**2 * G)  # of d - e^2 (v^2/(2 mu g) - d)
    assert slopes(found, "block.x")[-1] == pytest.approx([by_mu, -(e**2) * v / (mu * G)], rel=1e-7)
    after = math.sqrt(v**2 - 2.0 * mu * G * d)
    comes = (v - after) / (mu * G)
    by_mu = -comes / mu + d / (mu * after)
    assert slopes(found, "time(rail.contacts, 1)")[-1] == pytest.approx([by_mu, (1.0 - v / after) / (mu * G)], rel=1e-8)


def test_a_block_pressed_against_a_stop_leaves_it_where_its_friction_gives_way():
    """Pulled back as 10 (1 - t) N falls below zero, it moves from -mu_static m g on."""
    m = rt.loads(between_stops("10*(1 - t)", restitution=0, x=0.12)).set(v=0.0)
    found = m.sensitivity(["block.x", "rail.stop"], ["mu"], t_eval=[0.0, 0.2, 1.2, 2.0])
    begins, more = 1.0 + 1.5 * 0.2 * 2.0 * G / 10.0, 0.5 * 0.2 * G
    later, by_begin = 2.0 - begins, 1.5 * 2.0 * G / 10.0
    by_mu = -0.5 * G * later**2 / 2.0 + (more * later + 2.5 * later**2) * by_begin
    assert slopes(found, "block.x")[:, 0] == pytest.approx([0.0, 0.0, 0.0, by_mu], rel=1e-7, abs=1e-10)
    presses = 10.0 - 0.2 * 2.0 * G  # friction bears what it does in motion
    assert found["rail.stop"] == pytest.approx([-presses, 2.0 - presses, 0.0, 0.0], abs=1e-9)
    assert slopes(found, "rail.stop")[:, 0] == pytest.approx([2.0 * G, 2.0 * G, 0.0, 0.0], abs=1e-6)


BUSHES = {
    "smooth": "restitution = 0.5",
    "rough": 'restitution = 0.4, friction = { model = "coulomb", mu = 0.2 }',
    "that stays": 'restitution = 0, friction = { model = "coulomb", mu = 0.3 }',
}


@pytest.mark.parametrize("bush", BUSHES)
@pytest.mark.parametrize(
    "friction", [PIN, '{ model = "ambrosio", mu = "mu", v0 = 0.001, v1 = 0.01, pin_radius = "r" }']
)
def test_loose_pins_beside_joints_that_rub(bush, friction):
    pin = f'clearance = 5e-4, contact = {{ model = "impact", bush_radius = 0.01, {BUSHES[bush]} }}'
    begins = 'crank = { angle = 0.7, omega = "omega" }\nB = { offset = [0, 0] }'
    m = rt.loads(slider_crank(friction, pin=pin, begins=begins))
    found = assert_as_beside(m, ["crank.angle", "rod.angle", "slider.x"], np.linspace(0.0, 0.03, 4), rel=5e-6)
    assert found.stats["switchings"] > 1


def test_what_impacts_beside_joints_that_rub_have_no_derivatives_is_said():
    more = 'stop = { min = -0.1, max = 0.2, contact = { model = "impact", restitution_law = "poisson" } }'
    with pytest.raises(TraceError, match=r"impacts \(joint rail\) beside dry friction of joints have derivatives with"):
        rt.loads(block(HOLDS, more=more)).sensitivity(["block.x"], ["mu"], t_eval=[0.1])


def test_what_a_stop_has_pressed_against_its_friction_sticks_first_once_that_lets_go():
    """It has come to the stop bouncing, with friction either way; then it leaves it at mu_static m g."""
    stop = 'stop = { min = -0.1, max = 0.2, contact = { model = "impact", restitution = 0.4 } }'
    m = rt.loads(block(HOLDS, "F*sin(5*t)", stop)).set(v=1.0)
    s = m.sensitivity(["block.x"], ["F", "mu"], [0.0, 0.75, 1.0], **FINE)
    assert s.success, s.message
    for name in ("F", "mu"):
        want = differences(m, name, ["block.x"], [0.0, 0.75, 1.0])["block.x"]
        assert s[f"d(block.x)/d({name})"] == pytest.approx(want, rel=1e-6, abs=1e-8), name
