"""Kinks and jumps in time: switching instants of expressions, steps that end on them, and drivers that jump."""

from __future__ import annotations

import math
from random import Random

import numpy as np
import pytest
from scipy.optimize import brentq

import rattle as rt
from rattle.analyses.timetable import timetable
from rattle.language.bytecode import SIDE, evaluate
from rattle.language.tables import curve, tables_of
from timed_switches import switches


def rotor(inertia=0.5, **fields):
    """A body that turns about a fixed point, its mass centre on the axis."""
    m = rt.Mechanism("rotor")
    m.ground(O=[0, 0])
    m.body("rotor", points={"O": [0, 0]}, mass=1.0, inertia=inertia)
    m.revolute("axis", "ground.O", "rotor.O")
    if fields:
        m.load("M", type="torque", body="rotor", **fields)
    return m


def pendulum(torque, **signals):
    """A hanging bar of 1 m and 1 kg that starts level, with a torque."""
    m = rt.Mechanism("pendulum", gravity=[0, -9.81])
    m.ground(O=[0, 0])
    m.bar("rod", "A", "B", length=1.0, mass=1.0)
    m.revolute("O", "ground.O", "rod.A")
    for name, text in signals.items():
        m.signal(name, text)
    m.load("M", type="torque", body="rod", torque=torque)
    return m


def oscillator(force, x=0.1):
    """A mass of 1 kg on a line with a force of its position and of time."""
    m = rt.Mechanism("oscillator")
    m.ground(O=[0, 0])
    m.body("block", points={"C": [0, 0]}, mass=1.0, inertia=1.0)
    m.prismatic("line", "ground.O", "block.C")
    m.load("F", type="force", at="block.C", force=[force, 0])
    m.initial("block", x=x)
    return m


def wavy(t):
    return math.sin(t) / (t + 1) - math.tanh(t) * math.atan(t) / 9


# ---------------------------------------------------------------- the instants
@pytest.mark.nojit
@pytest.mark.parametrize(
    ("text", "end", "wanted"),
    [
        ("max(0, 10*(t - 0.5))", 1.0, [0.5]),
        ("10*(t - 0.5) if t > 0.5 else 0", 1.0, [0.5]),
        ("sign(sin(50*t))", 10.0, np.arange(1, 160) * math.pi / 50),
        ("abs(t*t - 2)", 3.0, [math.sqrt(2)]),
        ("step((t - 0.3)**3)", 1.0, [0.3]),
        ("sign(tan(5*t))", 1.0, [math.pi / 10, math.pi / 5, 3 * math.pi / 10]),  # zeros and poles
        ("step(exp(-t)*sin(20*t))", 10.0, np.arange(1, 64) * math.pi / 20),
        ("sign(2**t - 3)", 4.0, [math.log2(3)]),
        ("step(hypot(t - 1, 0.2) - 0.5)", 4.0, [1 - math.sqrt(0.21), 1 + math.sqrt(0.21)]),
        ("min(sqrt(t), 0.7)", 1.0, [0.49]),
        ("abs(log(t + 0.1))", 4.0, [0.9]),
        ("floor(t*t)", 2.0, np.sqrt([1.0, 2.0, 3.0])),
        ("floor(1 - 3*t)", 1.0, [1 / 3, 2 / 3]),  # from 1 at t = 0 it falls at once, at t = 1 it ends
        ("mod(t, 0.25)", 1.0, [0.25, 0.5, 0.75]),
        (
            "floor(2.5*sin(t))",
            3.0,
            np.sort([math.asin(0.4), math.asin(0.8), math.pi - math.asin(0.4), math.pi - math.asin(0.8)]),
        ),
        ("mod(t, 0.001)", 0.3, np.arange(1, 300) / 1000),
        ("step(acos(0.1*t) - 1)", 9.0, [10 * math.cos(1)]),
        ("sign(1/t - 3)", 4.0, [1 / 3]),
        ("sign(sin(t)/(t + 1) - tanh(t)*atan(t)/9)", 3.0, [brentq(wavy, 1.0, 3.0, xtol=1e-15)]),
    ],
)
def test_all_changes_of_sign_are_found(text, end, wanted):
    ((switch,), _, _) = switches(text, end)
    assert switch.timed
    assert switch.resolved
    # the roots to a few roundings of the run's length
    np.testing.assert_allclose(switch.instants, wanted, rtol=0, atol=1e-13 * end)
    assert (switch.sides[1:] != switch.sides[:-1]).all()


@pytest.mark.nojit
def test_touching_zero_is_no_switching():
    for text in ("step((t - 0.3)*(t - 0.3))", "step(t*t - t + 0.25)", "abs(sin(50*t)**2)", "step(t)", "sign(-t)"):
        ((switch,), _, _) = switches(text, 1.0)
        assert switch.resolved
        assert len(switch.instants) == 0


@pytest.mark.nojit
def test_what_stays_at_zero_is_no_switching():
    """Two ramps that are one: parameters may make them so."""
    for text in ("max(2*t, 2*t)", "abs(3*(t - 1) - 3*(t - 1))", "step(0*t)"):
        ((switch,), _, _) = switches(text, 1.0)
        assert switch.resolved
        assert len(switch.instants) == 0


def test_switches_inside_switches_and_signals():
    (inner, outer), _, _ = switches("abs(max(0, t - 0.3) - 0.2)", 1.0)
    assert inner.instants == [0.3]
    assert outer.instants == [0.5]
    (first, second), _, _ = switches("max(0, u) + abs(u*b.x)", 10.0, u="sin(t*t)")
    np.testing.assert_allclose(first.instants, np.sqrt(math.pi * np.arange(1, 32)), rtol=1e-14)
    assert not second.timed


@pytest.mark.nojit
def test_every_joined_condition_switches_by_itself():
    (one, two, three), _, _ = switches("sin(t) if t > 0.3 and not t >= 0.7 or 2*t > 1.8 else 0", 1.0)
    assert (one.instants, two.instants, three.instants) == ([0.3], [0.7], [0.9])
    pulse = switches("sign(mod(t, 0.3) - 0.25)", 0.7)[0][-1]  # mod jumps back beyond the zero
    np.testing.assert_allclose(pulse.instants, [0.25, 0.3, 0.55, 0.6], atol=1e-13)
    kink = switches("abs((1 if t > 0.3 and t < 0.7 else -1)*(t - 0.5))", 1.0)[0][-1]  # beyond the jumps it has one zero
    np.testing.assert_allclose(kink.instants, [0.3, 0.5, 0.7], atol=1e-13)


def test_thousands_of_instants_are_followed():
    instants = timetable(rotor(torque="mod(t, 0.001)").system, 0.0, 20.0).instants
    np.testing.assert_allclose(instants, np.arange(1, 20_001) / 1000, rtol=0, atol=1e-13 * 20)


def test_too_many_instants_are_given_up_within_a_budget():
    for text in ("step(sin(1e7*t))", "step(sin(t)**2 + cos(t)**2 - 1)"):  # a rounding that never settles
        ((switch,), _, _) = switches(text, 1.0)
        assert not switch.resolved


TABLES = tables_of(
    {
        "lin": curve([0.0, 0.7, 1.1, 2.5, 9.0], [0.0, 1.0, -0.5, 0.2, 1.5], "linear"),
        "per": curve([0.0, 0.3, 0.8, 1.3], [0.2, 1.0, -0.8, 0.2], "monotone", 1.3),
        "spl": curve([0.0, 0.5, 1.2, 2.0], [0.1, 0.5, -0.7, 0.1], "spline", 2.0),
    }
)
FORMS = [
    "({0} + {1})", "({0} - {1})", "({0}*{1})", "{0}/(1.3 + {1}**2)", "abs({0} - {n})", "min({0}, {1})",
    "max({0}, {1} - {n})", "mod({0}, {n})", "floor(2*{0} + {n})", "step({0} - {n})", "sign({0} - {n})",
    "sin({n}*{0})", "cos(3*{0})", "exp(-{0}**2)", "({0} - {n})**3", "(2 + {0}**2)**{n}", "tanh({0})",
    "({0} if {1} > {n} else {2})", "({0} if {1} <= {n} and not t > 0.9 or t < 0.2 else {2})", "lin(0.1 + 0.7*t)",
    "per({0})", "spl({0})", "sqrt({n} + {0}**2)", "atan2({0}, 2 + {1}**2)", "hypot({0}, {n})",
]  # fmt: skip


def expression(random, depth):
    """A random expression of time."""
    if depth == 0:
        return random.choice(["t", "u", f"{random.uniform(0.3, 3.0):.3f}*t"])
    parts = [expression(random, depth - 1) for _ in range(3)]
    return random.choice(FORMS).format(*parts, n=f"{random.uniform(0.2, 1.9):.3f}")


def bisected(sign_at, low, high):
    """Where a sign changes between two times [s]."""
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if sign_at(middle) == sign_at(low) else (low, middle)
    return high


@pytest.mark.parametrize("seed", range(48))
def test_instants_are_those_of_dense_samples_and_bisection(seed):
    random = np.random.default_rng(seed)
    end, made = 2.3, expression(Random(seed), 1 + seed % 3)
    found, m, (first, last) = switches(f"sign({made} - {random.uniform(-0.4, 0.4):.4f})", end, TABLES, u="sin(4*t)")
    m.code[:, SIDE] = 0
    body, signal, stack = np.zeros((2, 8)), np.zeros(1), np.zeros(40)

    def sign_at(t):
        signal[0] = math.sin(4.0 * t)
        return evaluate(m.code, m.const, first, last, t, body, signal, stack)

    times = np.linspace(1e-9, end, 4000)
    signs = np.array([sign_at(t) for t in times])
    places = np.flatnonzero(signs[1:] != signs[:-1])
    slow = [bisected(sign_at, times[k], times[k + 1]) for k in places]
    assert found[-1].resolved
    far = [t for t in slow if np.abs(found[-1].instants - t).min(initial=np.inf) > 1e-9]  # a flat zero is wide
    assert not far, made
    beside = 1e-6  # where nothing else switches in between, the sign differs on both sides
    alone = [
        t for t in found[-1].instants if (np.abs(found[-1].instants - t) < 2 * beside).sum() == 1 and t < end - beside
    ]
    assert all(sign_at(t - beside) != sign_at(t + beside) for t in alone), made


def test_the_result_says_which_expression_switches_too_often():
    result = rotor(torque="1e-30*step(sin(1e7*t))").simulate(1.0)
    assert "loads.M (value 1) switches too often to follow" in str(result.trust)


# ---------------------------------------------------------------- loads
def test_a_load_that_switches_on_is_exact():
    result = rotor(torque="3*step(t - 0.31)").simulate(1.0)
    late = np.maximum(0.0, result.t - 0.31)
    # the motion is of second degree on both sides: steps that end on the switch leave rounding alone
    np.testing.assert_allclose(result["rotor.angle"], 3.0 * late**2, atol=1e-14)
    np.testing.assert_allclose(result["rotor.omega"], 6.0 * late, atol=1e-14)
    assert result.stats["switchings"] == 1
    assert result.stats["rejected"] == 0


@pytest.mark.parametrize(
    "torque",
    ["3*floor(2*t + 0.38)", "3*(2*t + 0.38 - mod(2*t + 0.38, 1))", "3 if t > 0.31 and t < 0.81 or t >= 0.91 else 0"],
)
def test_a_torque_in_steps_is_exact(torque):
    result = rotor(torque=torque).simulate(0.8)
    late = np.maximum(0.0, result.t - 0.31)
    np.testing.assert_allclose(result["rotor.angle"], 3.0 * late**2, atol=1e-14)
    assert result.stats["rejected"] == 0


def test_a_run_may_have_its_start_alone():
    """No instant is looked for: values are those of the definition."""
    for torque, alpha in (("1 + step(t - 0.5)", 2.0), ("step(t)", 2.0), ("floor(t + 0.3) + sign(t)", 0.0)):
        assert rotor(torque=torque).simulate(t_eval=[0.0])["rotor.alpha"] == alpha


def test_a_table_may_end_with_the_run():
    """The instant at which it ends is found but for rounding, before or after the end of the run."""
    for x in ([0, 0.3, 0.6, 1.0], [0, 0.2, 0.7], [0, 0.1, 0.3]):
        m = rotor(torque="f(t)").set({"tables.f": {"x": x, "y": [2.0] * len(x)}})
        result = m.simulate(x[-1])
        assert result.success, result.message
        assert result["rotor.omega"][-1] == pytest.approx(2.0 * x[-1] / 0.5, rel=1e-12)


def test_a_pulse_shorter_than_any_step_is_not_missed():
    result = rotor(torque="1e6*(step(t - 0.5) - step(t - 0.500001))").simulate(1.0)
    assert result["rotor.omega"][-1] == pytest.approx(1e6 * 1e-6 / 0.5, rel=1e-9)  # 1e-16/1e-6 of the pulse is rounding


def test_a_square_wave_gives_a_triangle():
    result = rotor(torque="sign(sin(50*t))", inertia=1.0).simulate(10.0)
    half = math.pi / 50
    phase = np.mod(result.t, 2 * half)
    np.testing.assert_allclose(result["rotor.omega"], np.minimum(phase, 2 * half - phase), atol=1e-12)
    assert result.stats["switchings"] == 159


def test_energy_balances_through_switches():
    m = pendulum(
        "3*step(t - 0.31) + 1.0*s",
        s="0.3*abs(rod.omega + 1) - 2*max(0, rod.x) + (1 if t < 0.7 else 0.2*rod.angle)",
    )
    result = m.simulate(2.0, rtol=1e-12)
    assert result.stats["switchings"] > 3
    assert result.trust.energy_balance < 1e-9  # of 5 J; the work is integrated with the same steps


@pytest.mark.parametrize(
    "torque",
    [
        "3*step(t - 0.31)", "3*max(0, t - 0.77)", "4*max(0, rod.x - 0.1)", "-0.7*sign(rod.omega)",
        "2*floor(4.3*rod.x)", "2*mod(rod.angle, 0.7)", "2 if rod.x > 0.1 and not rod.omega > 0 else 0",
    ],
)  # fmt: skip
def test_rk4_keeps_its_order_through_kinks(torque):
    m = pendulum(torque)
    exact = m.simulate(t_eval=[1.5], rtol=1e-13)["rod.angle"][0]
    steps = np.array([0.02, 0.01, 0.005, 0.0025])
    error = [abs(m.simulate(t_eval=[1.5], method="rk4", step=h)["rod.angle"][0] - exact) for h in steps]
    assert np.polyfit(np.log(steps), np.log(error), 1)[0] == pytest.approx(4.0, abs=0.5)


def test_dop853_is_not_slowed_by_kinks():
    """Without located kinks every one costs dozens of rejected steps, and its error stays at the tolerance."""
    m = pendulum("0.7*sign(sin(9*t)) + 2*max(0, rod.x)")
    tight, loose = m.simulate(2.0, rtol=1e-13), m.simulate(2.0, rtol=1e-9)
    assert loose.stats["rejected"] < 2 * loose.stats["switchings"]
    np.testing.assert_allclose(loose["rod.angle"], tight["rod.angle"], atol=1e-8)


def test_a_spring_of_two_stiffnesses_has_the_period_of_both_halves():
    m = oscillator("-100*block.x if block.x < 0 else -25*block.x")
    period = math.pi / 10 + math.pi / 5
    result = m.simulate(t_eval=[0.0, 5 * period], rtol=1e-12)
    assert result["block.x"][1] == pytest.approx(0.1, abs=1e-11)
    assert result["block.vx"][1] == pytest.approx(0.0, abs=1e-9)
    assert result.stats["switchings"] == 10


def test_a_root_behind_a_condition_is_passed():
    for method in ("dop853", "rk4"):
        result = oscillator("-3*sqrt(block.x) - 1 if block.x > 0 else 1", x=0.01).simulate(0.4, method=method)
        assert result.success
        assert result["block.x"].min() < -1e-3


def test_a_switch_that_drives_back_from_both_sides_is_named():
    result = pendulum("-2*sign(rod.omega)").simulate(5.0)
    assert not result.success
    assert "loads.M (value 1) switches to and fro without end" in result.message
    assert result.t[-1] > 1.0


def test_massless_links_and_compliant_contacts_keep_their_balance_through_a_switch():
    wanted = {"massless-link": 1e-9, "exact": 1e-6}
    for contact, most in wanted.items():
        m = rt.example("fourbar").with_contact(contact) if contact == "massless-link" else compliant_pendulum()
        m = m.set({"loads.M.torque": "40*step(t - 0.0123)"}) if contact == "massless-link" else m
        result = m.simulate(0.03, rtol=1e-11)
        assert result.success
        assert result.stats["switchings"] >= 1
        assert result.trust.energy_balance < most


def compliant_pendulum():
    m = pendulum("3*step(t - 0.0123)")
    return m.set({
        "joints.O.clearance": "0.1 mm",
        "joints.O.contact": {"model": "hunt-crossley", "stiffness": 1e9, "exponent": 1.5, "restitution": 0.8},
    })  # fmt: skip


# ---------------------------------------------------------------- what stands at the instant
def test_outputs_at_the_instant_are_those_of_its_right_side():
    m = rotor(torque="s").signal("s", "step(t - 0.1) - step(0.2 - t)")
    result = m.simulate(t_eval=[0.05, 0.1, 0.15, 0.2, 0.25])
    np.testing.assert_array_equal(result["s"], [-1.0, 0.0, 0.0, 1.0, 1.0])
    np.testing.assert_allclose(result["rotor.alpha"], [-2.0, 0.0, 0.0, 2.0, 2.0], atol=1e-15)


def test_a_speed_that_starts_at_zero_is_that_after_zero():
    for function in ("max(0, 10*t)", "10*abs(t)", "10*t if t > 0 else 0"):
        m = rotor().driver("motor", "axis", angle=function)
        result = m.simulate(0.1)
        assert result.events == ()
        np.testing.assert_allclose(result["rotor.omega"], 10.0, rtol=1e-14)
        np.testing.assert_allclose(m.kinematics([0.0, 0.1])["rotor.omega"], 10.0, rtol=1e-14)


# ---------------------------------------------------------------- jolts
def slider_crank_inertia(m, angle):
    """Inertia of a slider-crank about its crank: 2 T / w^2, by differences of the closed form of its positions."""
    p = m.parameters
    a, b = p["crank_length"], p["rod_length"]

    def positions(phi):
        tilt = -math.asin(a * math.sin(phi) / b)
        pin = np.array([a * math.cos(phi), a * math.sin(phi)])
        rod = pin + 0.5 * b * np.array([math.cos(tilt), math.sin(tilt)])
        return np.array([phi, *rod, tilt, a * math.cos(phi) + b * math.cos(tilt)])

    h = 1e-4
    offsets, weights = (-2, -1, 1, 2), (1 / 12, -8 / 12, 8 / 12, -1 / 12)
    rates = sum(w * positions(angle + k * h) for k, w in zip(offsets, weights, strict=True)) / h
    return float(np.array([1e-4, 0.21, 0.21, 2.5e-4, 0.14]) @ rates**2)


@pytest.mark.parametrize("method", ["dop853", "rk4"])
@pytest.mark.parametrize(
    ("function", "at", "angle", "before", "after"),
    [
        ("0.7 + max(0, 10*(t - 0.5))", 0.5, 0.7, 0.0, 10.0),
        ("0.7 + (10*(t - 0.5) if t > 0.5 else 0)", 0.5, 0.7, 0.0, 10.0),
        ("abs(3*(t - 0.25)) + 1", 0.25, 1.0, -3.0, 3.0),
        ("2*min(3*t, t + 0.5)", 0.25, 1.5, 6.0, 2.0),
    ],
)
def test_a_jolt_takes_the_impulse_and_energy_of_the_closed_form(function, at, angle, before, after, method):
    m = rt.example("slider_crank").set({"drivers.motor.angle": function})
    result = m.simulate(1.0, method=method)
    (event,) = result.events
    inertia = slider_crank_inertia(m, angle)
    assert (event.t, event.joint, event.kind) == (at, "motor", "jolt")
    assert event.normal_speed == pytest.approx(after - before, rel=1e-12)
    assert event.impulse == pytest.approx(inertia * (after - before), rel=1e-8)  # the differences have 1e-9
    assert -event.energy_lost == pytest.approx(0.5 * inertia * (after**2 - before**2), rel=1e-8, abs=1e-12)
    assert result.trust.energy_balance < 1e-9
    assert result.trust.drift < 1e-12
    assert f"jumps in speed by {after - before:.4g} rad/s at t = {at:g} s" in str(result.trust)
    k = int(np.searchsorted(result.t, at))
    assert result["crank.omega"][k] == pytest.approx(after, rel=1e-12)
    assert result["crank.omega"][k - 1] == pytest.approx(before, rel=1e-12, abs=1e-12)


def two_links(**drivers):
    m = rt.Mechanism("arm")
    m.ground(O=[0, 0])
    m.bar("upper", "O", "E", length=0.5, mass=2.0)
    m.bar("lower", "E", "H", length=0.4, mass=1.0)
    m.revolute("O", "ground.O", "upper.O")
    m.revolute("E", "upper.E", "lower.E")
    for name, angle in drivers.items():
        m.driver(name.lower() + "_motor", name, angle=angle)
    return m


def arm_mass(upper, lower):
    """Mass matrix of the two links in their own angles."""
    c = 0.5 * 0.2 * 1.0 * math.cos(lower - upper)
    return np.array([[2.0 * 0.5**2 / 3 + 1.0 * 0.5**2, c], [c, 1.0 * 0.4**2 / 3]])


def test_a_free_link_is_kicked_by_a_jolt_as_the_impulse_problem_says():
    m = two_links(O="0.3 + 4*max(0, t - 0.2)").initial("lower", angle=1.1, omega=0.0)
    result = m.simulate(0.4, t_eval=[0.1, 0.2, 0.4], rtol=1e-11)
    # without loads the arm rests before; then M (w+ - w-) has no part along the free link
    mass = arm_mass(0.3, 1.1)
    free = -mass[1, 0] / mass[1, 1] * 4.0
    assert result["lower.omega"][1] == pytest.approx(free, rel=1e-12)
    (event,) = result.events
    assert event.impulse == pytest.approx(mass[0] @ [4.0, free], rel=1e-12)
    assert -event.energy_lost == pytest.approx(0.5 * event.impulse * 4.0, rel=1e-12)
    assert result.trust.energy_balance < 1e-9


def test_two_drivers_that_jump_together_are_one_problem():
    m = two_links(O="0.3 + 4*max(0, t - 0.2)", E="0.8 - 3*max(0, 2*t - 0.4)")
    result = m.simulate(0.4, t_eval=[0.1, 0.2, 0.4])
    mass, rates = arm_mass(0.3, 1.1), np.array([4.0, 4.0 - 6.0])
    momentum = mass @ rates  # about O by the upper link's own angle: E's motor reacts on it
    found = {event.joint: event for event in result.events}
    assert found["e_motor"].impulse == pytest.approx(momentum[1], rel=1e-12)
    assert found["o_motor"].impulse == pytest.approx(momentum[0] + momentum[1], rel=1e-12)
    put_in = -sum(event.energy_lost for event in result.events)
    assert put_in == pytest.approx(0.5 * rates @ mass @ rates, rel=1e-12)
    assert result.trust.energy_balance < 1e-9


def test_many_jolts_are_counted_together():
    m = rotor().driver("motor", "axis", angle="0.1*abs(sin(20*t))")
    result = m.simulate(1.0, rtol=1e-12)
    assert [event.kind for event in result.events] == ["jolt"] * 6
    assert "driver 'motor' jumps in speed 6 times, work of 0 J in total" in str(result.trust)
    assert result.trust.energy_balance < 1e-9


# ---------------------------------------------------------------- jumps in position
@pytest.mark.parametrize(
    ("function", "said"),
    [
        ("speed*t + 0.1*step(t - 0.01)", "driver 'motor' jumps by 0.1 rad at t = 0.01 s"),
        ("10*t*(1 if t < 0.5 else 0.5)", "driver 'motor' jumps by -2.5 rad at t = 0.5 s"),
        ("sign(t - 0.005)/2", "driver 'motor' jumps by 1 rad at t = 0.005 s"),
        ("0.1*step(sin(20*t)) + t", r"driver 'motor' jumps by -0.1 rad at t = 0.157079633 s \(and 5 more times\)"),
    ],
)
def test_a_driver_that_jumps_in_position_is_refused_with_its_instant(function, said):
    m = rt.example("slider_crank").set({"drivers.motor.angle": function, "simulate.t_end": 1.0})
    for ask in (m.simulate, m.check, lambda: m.kinematics([0.0, 1.0]), lambda: m.inverse_dynamics([0.0, 1.0])):
        with pytest.raises(rt.ModelError, match=said):
            ask()


def test_a_driver_that_jumps_at_the_start_is_refused():
    for function in ("sign(t)", "t - step(-t)"):
        with pytest.raises(rt.ModelError, match=r"jumps by 1 rad at t = 0 s"):
            rotor().driver("motor", "axis", angle=function).simulate(0.1)


def test_a_branch_without_a_value_at_its_edge_is_not_taken_there():
    m = rotor(torque="sin(t)/t if t > 0 else 1", inertia=1.0).driver("motor", "axis", angle="t*t if t < 1 else 2*t - 1")
    assert m.simulate(1.5).success
    result = rotor(torque="sin(t - 1)/(t - 1) if t > 1 else 1", inertia=1.0).simulate(t_eval=[0.5, 1.0, 1.5])
    np.testing.assert_allclose(result["rotor.alpha"], [1.0, 1.0, math.sin(0.5) / 0.5], rtol=1e-14)


def test_a_jump_that_is_not_reached_does_no_harm():
    m = rt.example("slider_crank").set({"drivers.motor.angle": "10*t + step(t - 0.5)", "simulate.t_end": 0.4})
    assert m.simulate().success
    assert m.kinematics([0.0, 0.4]).success
    assert m.check().mobility == 0
    with pytest.raises(rt.ModelError, match=r"jumps by 1 rad at t = 0\.5 s"):
        m.simulate(0.5)


def test_kinematics_says_where_there_is_no_acceleration():
    m = rt.example("slider_crank").set({"drivers.motor.angle": "max(0, 10*(t - 0.5))"})
    result = m.kinematics([0.0, 0.25, 0.5, 0.75])
    np.testing.assert_allclose(result["crank.omega"], [0.0, 0.0, 10.0, 10.0], atol=1e-14)
    assert "driver motor jumps in speed by 10 rad/s at t = 0.5 s" in str(result.trust)
    assert "no acceleration" in str(result.trust)
    assert "jumps in speed" not in str(m.kinematics([0.0, 0.25]).trust)
    assert "motor jumps in speed by 10 rad/s at t = 0.5 s" in str(m.set({"simulate.t_end": 1.0}).check())


def test_a_jump_in_acceleration_is_exact():
    m = rotor().driver("motor", "axis", angle="5*max(0, t - 0.5)**2")
    result = m.simulate(t_eval=[0.4, 0.5, 0.6])
    np.testing.assert_allclose(result["motor.torque"], [0.0, 5.0, 5.0], atol=1e-12)
    assert result.events == ()
    assert result.trust.energy_balance < 1e-12
