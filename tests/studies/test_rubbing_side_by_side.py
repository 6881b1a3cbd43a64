"""Joints that rub, side by side: closed forms, single runs of the same samples, the same bits in any company."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import rattle as rt
from lane_runs import FINE, assert_alike, side_by_side
from rubbing import slider_crank as with_friction

G = 9.81
COULOMB = '{ model = "coulomb", mu = "mu", pin_radius = "r" }'
HOLDS = '{ model = "coulomb", mu = "mu", mu_static = "1.4*mu", pin_radius = "r" }'
SMOOTH = '{ model = "ambrosio", mu = "mu", v0 = 0.001, v1 = 0.01, pin_radius = "r" }'
LOST = "final(energy.dissipated)"


def block(more=""):
    """On a rail."""
    return f"""
format = 1
gravity = [0, -9.81]
parameters = {{ mu = 0.2, v = 1.0, F = 0.0 }}
ground.points.O = [0, 0]
{more}
bodies.block = {{ points = {{ C = [0, 0] }}, mass = 2, inertia = 1 }}
[joints.rail]
type = "prismatic"
connect = ["ground.O", "block.C"]
axis = 0
friction = {{ model = "coulomb", mu = "mu", mu_static = "1.5*mu" }}
[initial.block]
x = 0
vx = "v"
"""


def slider_crank(friction, motion="", pin=""):
    """With friction in its pins and its guide; free without a motion."""
    begins = "" if motion else 'crank = { angle = 0.7, omega = "omega" }'
    return with_friction(friction, motion, pin, f"rod = {{ angle = -0.1 }}\n{begins}")


def pendulum(friction, second=""):
    return f"""
format = 1
gravity = [0, -9.81]
parameters = {{ mu = 0.1, r = 0.02, T = 0.05, w = 0.0 }}
ground.points.O = [0, 0]
bodies.one = {{ bar = ["A", "B"], length = 0.3, mass = 1 }}
joints.O = {{ type = "revolute", connect = ["ground.O", "one.A"], friction = {friction} }}
initial.one = {{ angle = 0.4, omega = "w" }}
{second}
"""


SECOND = """
bodies.two = {{ bar = ["A", "B"], length = 0.2, mass = 0.7 }}
joints.P = {{ type = "revolute", connect = ["one.B", "two.A"], friction = {} }}
initial.two = {{ angle = 0.2, omega = 0 }}
"""


# ---------------------------------------------------------------- closed forms
def test_a_block_comes_to_rest_and_stays():
    mu, v = np.array([0.2, 0.1, 0.3]), np.array([1.0, -2.0, 0.5])
    outputs = ["final(block.x)", "final(block.vx)", LOST, "max(abs(rail.friction))", "final(rail.friction)"]
    _, (x, rate, lost, most, rest) = side_by_side(rt.loads(block()), {"mu": mu, "v": v}, outputs, 3.0, **FINE)
    assert x == pytest.approx(v * np.abs(v) / (2.0 * mu * G), abs=1e-13)
    assert lost == pytest.approx(v**2, rel=1e-12)
    assert most == pytest.approx(2.0 * mu * G, rel=1e-12)
    assert not rate.any()
    assert rest == pytest.approx(0.0, abs=1e-12)


def test_a_block_that_is_pushed_slips_at_its_limit_of_rest():
    """The force grows as 30 t: it slips from t = 1.5 mu m g / 30 on, against mu m g."""
    push = 'loads.push = { type = "force", at = "block.C", force = ["30*t", 0] }'
    mu = np.array([0.1, 0.2, 0.4])
    m = rt.loads(block(push))
    outputs = ["final(block.vx)", "final(block.x)", "max(abs(rail.friction))"]
    _, (v, x, most) = side_by_side(m, {"mu": mu, "v": [0.0, 0.0, 0.0]}, outputs, 1.0, **FINE)
    begins = 1.5 * mu * 2.0 * G / 30.0
    drive = (30.0 * begins - mu * 2.0 * G) / 2.0  # what is left of it at once [m/s^2]
    later = 1.0 - begins
    moves = later > 0.0
    assert v == pytest.approx(np.where(moves, drive * later + 7.5 * later**2, 0.0), rel=1e-10, abs=1e-15)
    assert x == pytest.approx(np.where(moves, drive * later**2 / 2.0 + 2.5 * later**3, 0.0), rel=1e-10, abs=1e-15)
    assert most == pytest.approx(np.minimum(30.0, 1.5 * mu * 2.0 * G), rel=1e-10)


def test_a_pendulum_swings_until_its_friction_holds_it():
    """Each turn follows from the energy and the torque; it rests where the weight turns it with less than that."""
    torque = np.array([0.1, 0.15, 0.2, 0.5])
    found, (rest, lost) = side_by_side(
        rt.loads(pendulum('{ torque = "T" }')), {"T": torque}, ["final(one.angle)", LOST], 12.0, rtol=1e-10
    )
    assert found.stats["turns"] > 12
    weight, places, works = G * 0.15, [], []
    for t in torque:
        angle, sense, work = 0.4, -1.0, 0.0
        while abs(weight * math.cos(angle)) > t:

            def left(there, angle=angle, sense=sense, t=t):
                return weight * (math.sin(angle) - math.sin(there)) - t * sense * (there - angle)

            there = brentq(left, angle + 1e-3 * sense, -math.pi - angle)
            work, angle, sense = work + t * abs(there - angle), there, -sense
        places.append(angle)
        works.append(work)
    assert rest == pytest.approx(places, abs=1e-7)
    assert lost == pytest.approx(works, rel=1e-7)


def test_a_driver_feels_the_friction_of_what_it_moves():
    """Of a pin under its own reaction: the torque of a disc that swings as sin(w t) turns round with its rate."""
    text = """
format = 1
gravity = [0, -9.81]
parameters = { mu = 0.1, w = 5.0 }
ground.points.O = [0, 0]
bodies.disc = { points = { C = [0, 0] }, mass = 2, inertia = 0.01 }
joints.O = { type = "revolute", connect = ["ground.O", "disc.C"], friction = {
    model = "coulomb", mu = "mu", pin_radius = 0.01 } }
drivers.motor = { joint = "O", angle = "sin(w*t)" }
"""
    mu, w = np.array([0.1, 0.3, 0.0]), np.array([5.0, 8.0, 6.0])
    outputs = [LOST, "max(motor.torque)", "mean(abs(O.friction))", "at(O.friction, 0.01)"]
    _, (lost, most, usual, early) = side_by_side(rt.loads(text.replace("friction = {\n", "friction = {")), {
        "mu": mu, "w": w}, outputs, 2.0, **FINE)  # fmt: skip
    size = mu * 0.01 * 2.0 * G
    way = np.array([quad(lambda t, w=w: abs(w * math.cos(w * t)), 0.0, 2.0, limit=200)[0] for w in w])
    assert lost == pytest.approx(size * way, rel=1e-7)
    assert usual == pytest.approx(size, rel=1e-9)
    assert early == pytest.approx(-size, rel=1e-9)
    t = np.linspace(0.0, 2.0, 400001)[:, None]
    torque = -0.01 * w**2 * np.sin(w * t) + size * np.sign(np.cos(w * t))
    assert most == pytest.approx(torque.max(axis=0), rel=1e-6)


# ---------------------------------------------------------------- as runs alone
MECHANISMS = {
    "free slider-crank": (slider_crank(COULOMB), ["final(crank.angle)", LOST, "max(A.force)"], 0.6),
    "that holds at rest": (slider_crank(HOLDS), ["final(crank.angle)", LOST, "max(A.force)"], 0.6),
    "driven": (slider_crank(COULOMB, "0.7 + omega*t"), ["final(motor.torque)", "at(guide.friction, 0.2)"], 0.3),
    "driven to and fro": (
        slider_crank(HOLDS, "0.7 + 0.8*sin(omega*t)"), ["max(motor.torque)", "rms(guide.friction)"], 0.3,
    ),
    "with play": (
        slider_crank(COULOMB, pin='clearance = 5e-4, contact = { model = "lankarani-nikravesh", stiffness = 2e8, '
        'exponent = 1.5, restitution = 0.5, bush_radius = 0.01 }'),
        ["count(B.contacts)", "speed(B.contacts, 3)", "final(crank.angle)"], 0.05,
    ),
    "smooth friction": (pendulum(SMOOTH, SECOND.format(SMOOTH)), ["final(two.angle)", LOST, "max(P.force)"], 1.0),
    "two pendulums": (pendulum(HOLDS, SECOND.format(COULOMB)), ["final(two.angle)", LOST, "max(P.force)"], 1.0),
    "of stated size": (
        pendulum('{ torque = "T" }', SECOND.format(HOLDS)), ["final(two.angle)", LOST, "max(O.friction)"], 1.0,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", MECHANISMS)
def test_samples_are_what_they_are_alone(name):
    text, outputs, t_end = MECHANISMS[name]
    m = rt.loads(text)
    samples = {"mu": np.array([0.08, 0.25, 0.15]), "r": np.array([0.01, 0.012, 0.004])}
    if "omega" in m.parameters:
        samples["omega"] = np.array([18.0, 9.0, 25.0])
    assert_alike(m, samples, outputs, t_end, rel=2e-6, abs=1e-9)


@pytest.mark.parametrize(
    ("example", "name", "outputs"),
    [
        ("stick_slip", "mu", ["final(block.x)", "final(energy.dissipated)", "max(abs(dry.friction))"]),
        ("wiper", "blade", ["max(motor.torque)", "at(crank.omega, 0.3)"]),
    ],
)
def test_examples_are_what_they_are_alone(example, name, outputs):
    m = rt.load(rt.examples()[example])
    t_end = min(4.0, m.model.settings.t_end)
    assert_alike(m, {name: m.parameters[name] * np.array([0.9, 1.0])}, outputs, t_end, rel=1e-6, rtol=1e-10)


ROD = """
format = 1
gravity = [0, -9.81]
parameters = { mu = 0.15, w = 2.0 }
ground.points = { O = [0, 0], Q = [0.5, 0] }
bodies.a = { bar = ["A", "B"], length = 0.3, mass = 0.4 }
bodies.b = { bar = ["A", "B"], length = 0.4, mass = 0.5 }
joints.O = { type = "revolute", connect = ["ground.O", "a.A"] }
joints.Q = { type = "revolute", connect = ["ground.Q", "b.A"] }
joints.rod = { type = "rod", connect = ["a.B", "b.B"], length = 0.35, friction = FRICTION }
initial = { a = { angle = 1.2, omega = "w" }, b = { angle = 1.5 } }
"""
BEAD = """
format = 1
gravity = [0, -9.81]
parameters = { mu = 0.15, w = 2.0 }
ground.points.O = [0, 0]
bodies.arm = { points = { A = [0, 0] }, mass = 1, inertia = 0.05 }
bodies.bead = { points = { P = [0, 0] }, mass = 0.2, inertia = 1e-4 }
joints.O = { type = "revolute", connect = ["ground.O", "arm.A"] }
joints.s = { type = "slot", connect = ["arm.A", "bead.P"], axis = 0, friction = { model = "coulomb", mu = "mu" } }
initial = { arm = { angle = 0.3, omega = "w" }, bead = { x = 0.15, angle = 0, omega = 0 } }
"""


@pytest.mark.parametrize(
    ("text", "body"),
    [(ROD.replace("FRICTION", '{ model = "coulomb", mu = "mu", pin_radius = 0.012 }'), "a.angle"), (BEAD, "bead.x")],
)
def test_rods_and_slots_rub_side_by_side(text, body):
    samples = {"mu": np.array([0.1, 0.3]), "w": np.array([2.0, -3.0])}
    assert_alike(rt.loads(text), samples, [f"final({body})", LOST], 0.8, rel=1e-6, abs=1e-9)


# ---------------------------------------------------------------- what rests
PARALLELOGRAM = """
format = 1
gravity = [0, 0]
parameters = { ms = 1.3 }
ground.points = { O = [0, 0], P = [1, 0] }
bodies.a = { points = { A = [0, 0], B = [0, 0.5] }, mass = 1, inertia = 0.1 }
bodies.b = { points = { A = [0, 0], B = [0, 0.5] }, mass = 1, inertia = 0.1 }
bodies.c = { points = { A = [0, 0], B = [1, 0] }, center = [0.5, 0], mass = 1, inertia = 0.1 }
joints.O = { type = "revolute", connect = ["ground.O", "a.A"], friction = RUBS }
joints.P = { type = "revolute", connect = ["ground.P", "b.A"], friction = RUBS }
joints.Q = { type = "revolute", connect = ["a.B", "c.A"] }
joints.R = { type = "revolute", connect = ["b.B", "c.B"] }
loads.one = { type = "force", at = "a.A", force = [0, -10] }
loads.two = { type = "force", at = "b.A", force = [0, -10] }
loads.turn = { type = "torque", body = "a", torque = "t" }
initial = { a = { angle = 0 }, b = { angle = 0 } }
""".replace("RUBS", '{ model = "coulomb", mu = 0.5, mu_static = "0.5*ms", pin_radius = 0.05 }')


@pytest.mark.parametrize("ms", [1.0, 1.1, 1.3, 2.0])
def test_joints_that_hold_each_other_break_away_where_the_sum_of_their_limits_is_passed(ms):
    """Together, and not the first one that is at its limit, which would rub by mu while the other still holds."""
    m = rt.loads(PARALLELOGRAM).set(ms=ms)
    limit = m.holds("turn", t=1.0).high
    events = m.simulate(1.2, rtol=1e-9).events
    assert [event.kind for event in events] == ["slip", "slip"]
    assert [event.t for event in events] == pytest.approx([limit] * 2, rel=1e-9)
    _, (t,) = side_by_side(rt.loads(PARALLELOGRAM), {"ms": [ms]}, ["first(a.omega > 1e-9)"], 1.2, rtol=1e-9)
    assert t == pytest.approx([limit], abs=2e-3 if ms == 1.0 else 1e-6)


@pytest.mark.parametrize("motion", ["0.8", "0.8 + w*t", "0.8 + w*sin(t)", "0.8 + w*t**2"])
def test_a_driver_at_rest_feels_no_friction_of_rounding(motion):
    text = slider_crank(COULOMB, motion).replace("omega = 20.0", "w = 0.0, m = 0.14").replace("0.14, i", '"m", i')
    samples = {"m": np.array([0.14, 0.14000001, 0.4])}
    assert_alike(rt.loads(text), samples, ["final(motor.torque)", "final(guide.friction)", "max(O.force)"], 0.5)


@pytest.mark.parametrize("mu", [0.0, 1e-9, 1e-5])
def test_hardly_any_friction_is_no_trouble(mu):
    samples = {"mu": np.array([mu]), "omega": np.array([10.0])}
    assert_alike(rt.loads(slider_crank(COULOMB)), samples, ["final(crank.angle)", LOST], 1.0, rel=1e-6, abs=1e-9)


# ---------------------------------------------------------------- the same bits, and what is not followed
def test_a_sample_has_the_same_bits_in_any_company():
    m, random = rt.loads(slider_crank(HOLDS)), np.random.default_rng(2)
    samples = {"mu": random.uniform(0.05, 0.3, 30), "omega": random.uniform(5.0, 20.0, 30)}
    outputs = ["final(slider.x)", "max(A.force)", LOST]

    def run(which, threads):
        chosen = {name: values[which] for name, values in samples.items()}
        return side_by_side(m, chosen, outputs, 0.4, rtol=1e-9, threads=threads)[1]

    every, mixed = np.arange(30), random.permutation(30)
    whole = run(every, 2)
    for which, threads in ((every, 1), (mixed, 2), (every[11:12], 1), (every[20:29], 2)):
        assert np.array_equal(whole[:, which], run(which, threads))


@pytest.mark.parametrize("omega", [0.0, 3.0])
@pytest.mark.parametrize("law", ['"lugre", sigma0 = 1e4', '"dahl", sigma = 1e4', '"threlfall", vr = 0.01'])
def test_laws_of_friction_of_joints_without_play(law, omega):
    friction = f'friction = {{ model = {law}, mu = "mu", pin_radius = 0.02 }}'
    m = rt.loads(f"""
format = 1
gravity = [0, -9.81]
parameters.mu = 0.3
ground.points.O = [0, 0]
bodies.b = {{ points = {{ O = [-0.25, 0], E = [0.25, 0] }}, mass = 1, inertia = 0.02 }}
bodies.c = {{ points = {{ E = [-0.2, 0] }}, mass = 0.5, inertia = 0.01 }}
joints.O = {{ type = "revolute", connect = ["ground.O", "b.O"], {friction} }}
joints.E = {{ type = "revolute", connect = ["b.E", "c.E"], {friction} }}
initial = {{ b = {{ angle = 0, omega = {omega} }}, c = {{ angle = -1, omega = 0 }} }}
""")
    outputs = ["final(b.angle)", "final(c.omega)", "final(energy.dissipated)"]
    assert_alike(m, {"mu": np.array([0.1, 0.5])}, outputs, 0.5, rel=1e-7, rtol=1e-10)
