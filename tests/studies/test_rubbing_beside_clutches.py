"""Joints that rub beside one-way clutches, side by side: closed forms, and single runs of the same samples."""

import numpy as np
import pytest
from scipy.optimize import brentq

import rattle as rt
from lane_runs import FINE, assert_alike, side_by_side
from rubbing import two_shafts

IDEAL = '["one", "two"], model = "ideal"'
STATED = '{ torque = "f" }', '{ torque = "g" }'
HOLDS = '{ model = "coulomb", mu = "mu", mu_static = "1.5*mu", pin_radius = "40 mm" }'
SOFTER = '{ model = "coulomb", mu = "mu", pin_radius = "40 mm" }'
STOP = ', stop = { min = -0.3, max = 0.4, contact = { model = "impact", restitution = 0.4 } }'
LOST = "final(energy.dissipated)"


def test_what_drives_another_by_a_clutch_breaks_away_with_it():
    """At f + g of a torque that grows as 2 t; then both gain (t - t0)^2/(J1 + J2), and the clutch bears g and half."""
    f, g = np.array([0.6, 0.2, 0.9]), np.array([0.6, 0.7, 0.1])
    outputs = ["final(one.omega)", "final(two.angle)", "final(way.torque)", "first(two.omega > 1e-9)", LOST]
    _, (rate, angle, torque, begins, lost) = side_by_side(
        rt.loads(two_shafts(IDEAL, "2*t")), {"f": f, "g": g}, outputs, 1.0, **FINE
    )
    start = (f + g) / 2.0
    assert rate == pytest.approx((1.0 - start) ** 2 / 0.08, rel=1e-9)
    assert angle == pytest.approx((1.0 - start) ** 3 / 0.24, rel=1e-9)
    assert torque == pytest.approx(g + (1.0 - start), rel=1e-9)
    assert begins == pytest.approx(start, abs=1e-5)
    assert lost == pytest.approx((f + g) * angle, rel=1e-9)


def test_a_clutch_that_slips_drives_no_more_than_its_largest_torque():
    """M = 0.5 N m on the second one, whose friction takes 0.2 of it."""
    m = rt.loads(two_shafts(f"{IDEAL}, max_torque = 0.5", "2")).set(g=0.2)
    _, (one, two, torque) = side_by_side(
        m, {"f": np.array([0.0, 0.3])}, ["final(one.omega)", "final(two.omega)", "min(way.torque)"], 0.7, **FINE
    )
    assert one == pytest.approx((1.5 - np.array([0.0, 0.3])) / 0.04 * 0.7, rel=1e-10)
    assert two == pytest.approx([0.3 / 0.04 * 0.7] * 2, rel=1e-10)
    assert torque == pytest.approx([0.5, 0.5])


def test_an_oil_clutch_sets_what_sticks_going():
    """Once c w of the first one is g; until then w = M/c (1 - exp(-c t/J)) alone."""
    m = rt.loads(two_shafts('["one", "two"], model = "viscous", damping = 0.5', "1.5"))
    g = np.array([0.3, 0.6])
    _, begins = side_by_side(m, {"g": g, "f": np.zeros(2)}, ["first(two.omega > 1e-9)"], 0.2, **FINE)
    want = [brentq(lambda t, g=x: 1.5 * (1.0 - np.exp(-0.5 * t / 0.04)) - g, 0.0, 1.0) for x in g]
    assert begins[0] == pytest.approx(want, abs=1e-5)


PUSH, PULL = "T*sin(7*t)", "0.8*T*sin(5*t + 2)"
CLUTCHES = {
    "ideal": (IDEAL, ""),
    "the other way round": ('["two", "one"], model = "ideal"', ""),
    "beside a stop": (IDEAL, STOP),
    "limited": (f"{IDEAL}, max_torque = 0.7", ""),
    "limited, beside a stop": (f"{IDEAL}, max_torque = 0.7", STOP),
    "of oil": ('["one", "two"], model = "viscous", damping = 0.3', ""),
    "of oil, beside a stop": ('["two", "one"], model = "viscous", damping = 0.3', STOP),
    "elastic": ('["one", "two"], model = "compliant", stiffness = 100, damping = 0.5', ""),
}


@pytest.mark.parametrize("pins", [STATED, (HOLDS, SOFTER)], ids=["stated", "coulomb"])
@pytest.mark.parametrize("name", CLUTCHES)
def test_shafts_behind_a_clutch_are_what_they_are_alone(name, pins):
    clutch, stop = CLUTCHES[name]
    text = two_shafts(clutch, PUSH, PULL, stop, pins).replace("w = 0.0", "w = 0.0, T = 2.0")
    samples = {"T": np.array([1.2, 2.5, 4.0]), "w": np.array([0.0, 1.0, -2.0])}
    outputs = ["final(one.angle)", "final(two.angle)", "final(two.omega)", "mean(way.torque)", LOST]
    assert_alike(rt.loads(text), samples, outputs, 1.0, rel=1e-6, abs=1e-8)


def test_a_crank_that_a_clutch_drives_against_its_pins_and_its_guide():
    m = rt.loads("""
format = 1
gravity = [0, -9.81]
parameters = { mu = 0.2, T = 5.0 }
ground.points = { O = [0, 0], S = [1, 0] }
bodies.wheel = { points = { O = [0, 0] }, mass = 1, inertia = 0.02 }
bodies.crank = { points = { O = [0, 0], A = [0.1, 0] }, mass = 1, inertia = 0.01 }
bodies.rod = { bar = ["A", "B"], length = 0.25, mass = 0.5, inertia = 3e-3 }
bodies.slider = { points = { B = [0, 0] }, mass = 1, inertia = 1e-3 }
joints.S = { type = "revolute", connect = ["ground.S", "wheel.O"] }
joints.way = { type = "clutch", connect = ["wheel", "crank"], model = "ideal" }
joints.B = { type = "revolute", connect = ["rod.B", "slider.B"] }
loads.push = { type = "torque", body = "wheel", torque = "T*sin(6*t)" }
loads.brake = { type = "torque", body = "crank", torque = "-0.3*T" }
initial = { wheel = { angle = 0, omega = 3 }, crank = { angle = 1 }, rod = { angle = -0.2, omega = 0 } }
[joints.O]
type = "revolute"
connect = ["ground.O", "crank.O"]
friction = { model = "coulomb", mu = "mu", pin_radius = "10 mm" }
[joints.A]
type = "revolute"
connect = ["crank.A", "rod.A"]
friction = { model = "coulomb", mu = "mu", mu_static = "1.5*mu", pin_radius = "10 mm" }
[joints.G]
type = "prismatic"
connect = ["ground.O", "slider.B"]
axis = 0
friction = { model = "coulomb", mu = "mu" }
""")
    samples = {"mu": np.array([0.1, 0.3]), "T": np.array([3.0, 6.0])}
    assert_alike(m, samples, ["final(crank.angle)", "final(wheel.omega)", LOST], 0.6, rel=1e-6, abs=1e-8)


@pytest.mark.parametrize("clutch", [IDEAL, '["one", "two"], model = "viscous", damping = 0.5'])
def test_a_pin_without_friction_turns_from_rest(clutch):
    """f = 0 of the model itself: nothing holds the first shaft."""
    m = rt.loads(two_shafts(clutch, "1")).set(f=0.0)
    samples = {"g": np.array([0.2, 0.3])}
    _, (rate,) = side_by_side(m, samples, ["final(two.omega)"], 1.0, **FINE)
    if clutch == IDEAL:
        assert rate == pytest.approx((1.0 - samples["g"]) / 0.08, rel=1e-10)
    _, (given,) = side_by_side(
        rt.loads(two_shafts(clutch, "1")), {"f": np.zeros(2), **samples}, ["final(two.omega)"], 1.0, **FINE
    )
    assert rate == pytest.approx(given, rel=1e-9)


def test_ratchets_run_one_by_one():
    m = rt.loads(two_shafts('["one", "two"], model = "ratchet", teeth = 24', PUSH.replace("T", "2")))
    found = m.many({"f": [0.1]}, t_end=0.1, outputs=["final(two.angle)"])
    assert "a ratchet (joint way) beside joints that rub does not run side by side" in found.stats["how"]


def test_counts_of_its_contacts_come_from_single_runs():
    m = rt.loads(two_shafts(IDEAL, "2*t"))
    found = m.many({"f": [0.3]}, t_end=1.0, outputs=["count(way.contacts)"])
    assert "which contacts of the clutch way begin beside joints that rub" in found.stats["how"]
    assert found["count(way.contacts)"][0] == 1.0


def test_a_sample_has_the_same_bits_in_any_company():
    m = rt.loads(two_shafts(f"{IDEAL}, max_torque = 0.7", "4*sin(7*t)", "1.5*sin(5*t)", STOP))
    f = np.linspace(0.1, 0.9, 9)
    outputs = ["final(one.angle)", "final(two.omega)", LOST]

    def run(which, threads):
        found = m.many({"f": f[which]}, t_end=1.0, outputs=outputs, threads=threads)
        assert not len(found.generic)
        return np.array([found[output] for output in outputs])

    everything = run(np.arange(9), 1)
    turned = np.arange(9)[::-1]
    np.testing.assert_array_equal(run(turned, 2)[:, ::-1], everything)
    np.testing.assert_array_equal(run(np.array([4]), 1)[:, 0], everything[:, 4])
