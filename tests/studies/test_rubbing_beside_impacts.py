"""Joints that rub beside rigid contacts, side by side: closed forms, and single runs of the same samples."""

import numpy as np
import pytest

import rattle as rt
from lane_runs import FINE, alone, assert_alike, side_by_side
from rubbing import block

G = 9.81
COULOMB = '{ model = "coulomb", mu = "mu" }'
HOLDS = '{ model = "coulomb", mu = "mu", mu_static = "1.6*mu" }'
STATED = '{ force = "50*mu" }'
SMOOTH = '{ model = "ambrosio", mu = "mu", v0 = 0.001, v1 = 0.01 }'
PIN = '{ model = "coulomb", mu = "mu", pin_radius = "10 mm" }'
LOST = "final(energy.dissipated)"


def between_stops(friction, push="0", restitution=0.5, x=0):
    """A block on a rail."""
    contact = f'{{ model = "impact", restitution = {restitution} }}'
    return block(friction, push, f"stop = {{ min = -0.1, max = 0.2, contact = {contact} }}", x)


def slider_crank(motion, bush, *, guide=COULOMB, pins="", law="newton"):
    """With play at the slider; pins: friction of the others."""
    rubs = f"friction = {pins}" if pins else ""
    return f"""
format = 1
parameters = {{ mu = 0.1, c = "0.4 mm" }}
ground.points.O = [0, 0]
bodies.crank = {{ points = {{ O = [0, 0], A = [0.05, 0] }}, mass = 0.3, inertia = 1e-4 }}
bodies.rod = {{ bar = ["A", "B"], length = 0.12, mass = 0.21, inertia = 2.5e-4 }}
bodies.slider = {{ points = {{ B = [0, 0] }}, mass = 0.14, inertia = 1e-4 }}
drivers.motor = {{ joint = "O", angle = "{motion}" }}
[joints.O]
type = "revolute"
connect = ["ground.O", "crank.O"]
{rubs}
[joints.A]
type = "revolute"
connect = ["crank.A", "rod.A"]
{rubs}
[joints.B]
type = "revolute"
connect = ["slider.B", "rod.B"]
clearance = "c"
contact = {{ model = "impact", restitution_law = "{law}", {bush} }}
[joints.guide]
type = "prismatic"
connect = ["ground.O", "slider.B"]
axis = 0
friction = {guide}
[initial]
rod = {{ angle = 0 }}
slider = {{ x = 0.17 }}
B = {{ offset = [0, 0] }}
"""


SMOOTH_BUSH = "restitution = 0.5"
ROUGH_BUSH = 'restitution = 0.4, bush_radius = "10 mm", friction = { model = "coulomb", mu = 0.2 }'
DEAD_BUSH = 'restitution = 0, bush_radius = "10 mm", friction = { model = "coulomb", mu = 0.3 }'


# ---------------------------------------------------------------- closed forms
@pytest.mark.parametrize("friction", [COULOMB, '{ force = "2*9.81*mu" }'])
def test_a_block_that_rubs_rebounds_from_a_stop_and_comes_to_rest(friction):
    mu, v = np.array([0.3, 0.2, 0.25, 0.3]), np.array([2.0, 1.5, 1.8, 0.5])
    outputs = ["final(block.x)", LOST, "final(block.vx)", "count(rail.contacts)", "speed(rail.contacts, 1)"]
    _, (x, lost, rate, hits, speed) = side_by_side(
        rt.loads(between_stops(friction)), {"mu": mu, "v": v}, outputs, 3.0, **FINE
    )
    left = v**2 - 0.4 * mu * G  # square of the speed at the stop
    reaches = left > 0.0
    back = 0.2 - 0.25 * left / (2.0 * mu * G)
    assert (back[reaches] > -0.1).all()
    assert x == pytest.approx(np.where(reaches, back, v**2 / (2.0 * mu * G)), abs=1e-11)
    assert np.array_equal(hits, reaches)
    assert speed[reaches] == pytest.approx(np.sqrt(left[reaches]), rel=1e-11)
    assert not rate.any()
    assert lost == pytest.approx(v**2, rel=1e-10)


def test_a_block_pressed_against_a_stop_leaves_it_where_its_friction_gives_way():
    """Pulled back as 10 (1 - t) N falls below zero, it moves from -mu_static m g on."""
    mu = np.array([0.2, 0.35])
    text = between_stops(HOLDS, push="10*(1 - t)", restitution=0, x=0.2)
    samples = {"mu": mu, "v": np.zeros(2)}
    outputs = ["final(block.x)", "first(block.vx < -1e-9)", "final(block.vx)"]
    _, (x, t, v) = side_by_side(rt.loads(text), samples, outputs, 2.0, **FINE)
    begins = 1.0 + 1.6 * mu * 2.0 * G / 10.0
    more = 0.6 * mu * G  # what is left of the pull at once, per mass
    later = np.maximum(2.0 - begins, 0.0)
    assert x == pytest.approx(0.2 - more * later**2 / 2.0 - 5.0 * later**3 / 6.0, abs=1e-10)
    assert v == pytest.approx(-more * later - 2.5 * later**2, abs=1e-9)
    moves = later > 0.0
    assert t[moves] == pytest.approx(begins[moves], abs=1e-6)
    assert np.isnan(t[~moves]).all()


# ---------------------------------------------------------------- as runs alone
PUSH = "60*sin(7*t)"
BLOCKS = {
    "pushed": (HOLDS, PUSH, 0.0),
    "that bounces": (HOLDS, "30*sin(20*t)", 0.5),
    "of stated friction": (STATED, PUSH, 0.5),
    "of smooth friction": (SMOOTH, PUSH, 0.0),
    "whose load switches": (HOLDS, "40 if mod(t, 0.3) < 0.15 else -20", 0.3),
}


@pytest.mark.parametrize("name", BLOCKS)
def test_blocks_between_stops_are_what_they_are_alone(name):
    friction, push, restitution = BLOCKS[name]
    samples = {"mu": np.array([0.2, 0.3]), "v": np.array([1.2, 2.9])}
    outputs = ["final(block.x)", LOST, "count(rail.contacts)", "time(rail.contacts, 1)", "time(rail.contacts, 3)"]
    assert_alike(rt.loads(between_stops(friction, push, restitution)), samples, outputs, 1.0, rel=1e-6, abs=1e-9)


FAST, SLOW, SWINGS = "523*t", "30*t", "0.5*sin(60*t)"
CRANKS = {
    "a guide": (FAST, SMOOTH_BUSH, {}, 0.004),
    "a guide that holds, and a bush": (SLOW, DEAD_BUSH, {"guide": HOLDS}, 0.1),
    "three joints and a bush": (SLOW, ROUGH_BUSH, {"pins": PIN}, 0.15),
    "three joints, to and fro": (SWINGS, ROUGH_BUSH, {"pins": PIN, "guide": HOLDS}, 0.08),
    "a smooth law and two phases": (SLOW, ROUGH_BUSH, {"guide": SMOOTH, "law": "poisson"}, 0.1),
}


@pytest.mark.parametrize("name", CRANKS)
def test_slider_cranks_with_play_are_what_they_are_alone(name):
    motion, bush, more, t_end = CRANKS[name]
    samples = {"mu": np.array([0.1, 0.25]), "c": np.array([3.8e-4, 4.9e-4])}
    outputs = [LOST, "final(slider.x)", "count(B.contacts)", "time(B.contacts, 1)", "time(B.contacts, 3)"]
    assert_alike(rt.loads(slider_crank(motion, bush, **more)), samples, outputs, t_end, rel=1e-6, abs=1e-9)


# ---------------------------------------------------------------- the same bits, and what is not followed
def test_a_sample_has_the_same_bits_in_any_company():
    m, random = rt.loads(slider_crank(SWINGS, ROUGH_BUSH, pins=PIN, guide=HOLDS)), np.random.default_rng(2)
    samples = {"mu": random.uniform(0.05, 0.2, 20), "c": random.uniform(3e-4, 5e-4, 20)}
    outputs = ["final(slider.x)", "count(B.contacts)", LOST]

    def run(which, threads):
        chosen = {name: values[which] for name, values in samples.items()}
        return side_by_side(m, chosen, outputs, 0.04, rtol=1e-9, threads=threads)[1]

    every, mixed = np.arange(20), random.permutation(20)
    whole = run(every, 2)
    for which, threads in ((every, 1), (mixed, 2), (every[11:12], 1), (every[10:19], 2)):
        assert np.array_equal(whole[:, which], run(which, threads))


def test_two_phases_beside_dry_friction_of_joints_run_one_by_one():
    m = rt.loads(slider_crank(FAST, SMOOTH_BUSH, law="poisson"))
    found = m.many({"mu": [0.1]}, t_end=0.001, outputs=["final(slider.x)"])
    assert 'beside dry friction of joints run side by side with restitution_law = "newton" only' in found.stats["how"]


def two_bars(one, two, height, pins, stop, floor, push, angle=0.0):
    """That hang from each other over a floor; the second one turns against a stop.  one, two: masses and inertias;
    pins: friction of both."""
    return f"""
format = 1
gravity = [0, -9.81]
parameters = {{ mu = 0.2, w = 0.0 }}
ground.points = {{ O = [0, 0], F = [0, {height}] }}
bodies.one = {{ points = {{ O = [0, 0], A = [0.2, 0] }}, center = [0.1, 0], mass = {one[0]}, inertia = {one[1]} }}
bodies.two = {{ points = {{ A = [0, 0], E = [0.2, 0] }}, center = [0.1, 0], mass = {two[0]}, inertia = {two[1]} }}
loads.push = {{ type = "torque", body = "one", torque = "{push}" }}
initial = {{ one = {{ angle = {angle}, omega = "w" }}, two = {{ angle = 0, omega = 0 }} }}
[joints.p]
type = "revolute"
connect = ["ground.O", "one.O"]
{pins[0]}
[joints.q]
type = "revolute"
connect = ["one.A", "two.A"]
{pins[1]}
stop = {{ {stop} }}
[joints.floor]
type = "surface"
connect = ["ground.F", "two.E"]
axis = 0
contact = {{ model = "impact", {floor} }}
"""


def test_a_bar_that_leans_on_a_rough_floor_has_no_impulses_of_a_stick_that_contradict_each_other():
    """Stretched out, both bars are one with a single freedom: what sticks there keeps two rates by one impulse."""
    text = two_bars(
        (1, 0.0005), (1, 0.005), -0.3, ("", 'friction = { torque = "0.5*mu" }'),
        'min = -0.5, max = 1.5, contact = { model = "impact", restitution = 0 }',
        'restitution = 0.8, friction = { model = "coulomb", mu = 1 }', "1",
    )  # fmt: skip
    m, samples = rt.loads(text), {"mu": [0.4385, 0.5], "w": [0.0, 0.0]}
    outputs = ["final(one.angle)", "final(two.angle)", LOST]
    found = m.many(samples, t_end=0.3, outputs=outputs, **FINE)
    single = alone(m, samples, outputs, 0.3, **FINE)
    assert np.array([found[output] for output in outputs]) == pytest.approx(single, rel=1e-7)
    assert (found[LOST] > 0.0).all()


def test_a_stop_at_which_a_joint_sticks_takes_part_in_impacts():
    """Its friction holds it there, so that the stop bears nothing until the floor is hit."""
    rubs = 'friction = {{ model = "coulomb", mu = "mu", mu_static = "{}*mu", pin_radius = "{} mm" }}'
    text = two_bars(
        (1, 0.005), (0.05, 0.0005), -0.25, (rubs.format(1.5, 2), rubs.format(1.3, 20)),
        'min = -1.5, max = 0.5, contact = { model = "impact", restitution = 1 }', "restitution = 0",
        "0.3*t*sin(30*t)", angle=-0.5,
    )  # fmt: skip
    samples = {"mu": np.array([0.4293, 0.45]), "w": np.array([-0.352, -0.352])}
    assert_alike(rt.loads(text), samples, ["final(one.angle)", "final(two.angle)", LOST], 0.3, rel=1e-6, abs=1e-9)
