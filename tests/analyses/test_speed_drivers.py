"""Drivers whose speed is given: the coordinate goes on from where the mechanism was put together by its integral."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

import rattle as rt

WHEEL = """
format = 1
gravity = [0, 0]
ground.points = { O = [0, 0] }
bodies.w = { points = { O = [0, 0] }, mass = 1, inertia = 0.5 }
joints.O = { type = "revolute", connect = ["ground.O", "w.O"] }
drivers.m = { joint = "O", SPEED }
initial.w = { angle = 0.3 }
"""
FOURBAR = """
format = 1
gravity = [0, -9.81]
ground.points = { O = [0, 0], A = [0.4, 0] }
parameters = { w = { value = 5.0, tol = 0.1 }, k = 0.1 }
bodies.crank = { bar = ["O", "B"], length = 0.1, mass = 1 }
bodies.rod = { bar = ["B", "C"], length = 0.35, mass = 1 }
bodies.rocker = { bar = ["C", "A"], length = 0.25, mass = 1 }
joints.O = { type = "revolute", connect = ["ground.O", "crank.O"] }
joints.B = { type = "revolute", connect = ["crank.B", "rod.B"] }
joints.C = { type = "revolute", connect = ["rod.C", "rocker.C"] }
joints.A = { type = "revolute", connect = ["ground.A", "rocker.A"] }
drivers.m = { joint = "O", MOTION }
initial.crank = { angle = 0.7 }
"""
BY_SPEED = 'speed = "w*(1 + k*sin(7*t))"'
BY_ANGLE = 'angle = "0.7 + w*(t + k*(1 - cos(7*t))/7)"'
SPEEDS = {  # speeds and their values; with a closed form of the integral none is needed: quadrature is independent
    "3*exp(-2*t)*cos(9*t)": lambda t: 3 * math.exp(-2 * t) * math.cos(9 * t),
    "10*min(t/0.5, 1)": lambda t: 10 * min(t / 0.5, 1),
    "abs(sin(8*t))": lambda t: abs(math.sin(8 * t)),
    "1 if t < 0.3 else 4": lambda t: 1.0 if t < 0.3 else 4.0,
    "pulse(t) + s": lambda t: float(np.interp(t, [0, 0.2, 0.5, 1], [0, 3, 1, 2])) + 0.1 * t,
}


def wheel(speed):
    text = WHEEL.replace("SPEED", f'speed = "{speed}"')
    return rt.loads(text + 'signals.s = "0.1*t"\ntables.pulse = { x = [0, 0.2, 0.5, 1], y = [0, 3, 1, 2] }\n')


@pytest.mark.parametrize("speed", SPEEDS)
def test_angle_is_the_integral_of_the_speed_from_the_start(speed):
    times = [0.0, 0.25, 0.6, 1.0]
    breaks = [0.2, 0.3, 0.5, *(k * math.pi / 8 for k in range(1, 3))]
    sums = [quad(SPEEDS[speed], 0, t, points=[x for x in breaks if x < t] or None, epsabs=1e-13)[0] for t in times]
    m = wheel(speed)
    run = m.simulate(1.0, t_eval=times, rtol=1e-11, atol=1e-13)
    np.testing.assert_allclose(run["w.angle"], 0.3 + np.array(sums), atol=1e-10)
    np.testing.assert_allclose(run["m.travel"], sums, atol=1e-10)
    np.testing.assert_allclose(m.kinematics(times)["w.angle"], 0.3 + np.array(sums), atol=1e-10)
    later = m.kinematics(times[2:])  # positions are found there without those before
    np.testing.assert_allclose(later["w.angle"], 0.3 + np.array(sums[2:]), atol=1e-10)


@pytest.mark.parametrize("method", ["dop853", "radau", "event", "rk4", "moreau"])
def test_a_mechanism_moves_as_with_the_integral_as_its_angle(method):
    how = {"step": 1e-4} if method in ("rk4", "moreau") else {"rtol": 1e-10}
    times = [0.0, 0.4, 1.0]
    runs = [
        rt.loads(FOURBAR.replace("MOTION", motion)).simulate(1.0, t_eval=times, method=method, **how)
        for motion in (BY_SPEED, BY_ANGLE)
    ]
    for name, slack in (("rocker.angle", 1e-9), ("rocker.omega", 1e-8), ("A.fx", 1e-7), ("m.torque", 1e-7)):
        np.testing.assert_allclose(runs[0][name], runs[1][name], atol=slack)
    assert np.abs(runs[0]["energy.balance"]).max() < 1e-7


def test_inverse_dynamics_and_derivatives_are_those_of_the_integral():
    by_speed, by_angle = (rt.loads(FOURBAR.replace("MOTION", motion)) for motion in (BY_SPEED, BY_ANGLE))
    times = [0.0, 0.5, 1.3]
    forces = [m.inverse_dynamics(times) for m in (by_speed, by_angle)]
    for name in ("rocker.angle", "rocker.alpha", "m.torque", "C.fx"):
        np.testing.assert_allclose(forces[0][name], forces[1][name], atol=1e-10)
    slopes = [m.sensitivity(["rocker.angle"], ["w", "k"], times) for m in (by_speed, by_angle)]
    for name in ("d(rocker.angle)/d(w)", "d(rocker.angle)/d(k)"):
        np.testing.assert_allclose(slopes[0][name], slopes[1][name], atol=1e-6)  # of the default tolerance


def test_samples_side_by_side_have_their_own_integrals():
    m = rt.loads(FOURBAR.replace("MOTION", BY_SPEED))
    w = [4.0, 5.0, 6.5]
    many = m.many({"w": w}, ["final(rocker.angle)"], 1.0, rtol=1e-10)
    alone = [m.set({"w": x}).simulate(1.0, t_eval=[0, 1.0], rtol=1e-10)["rocker.angle"][-1] for x in w]
    np.testing.assert_allclose(many["final(rocker.angle)"], alone, atol=1e-9)


def test_a_jump_in_speed_is_a_jolt_with_the_work_of_its_mean_speed():
    run = wheel("1 if t < 0.3 else 4").simulate(1.0, t_eval=[0, 1.0])
    (jolt,) = [event for event in run.events if event.kind == "jolt"]
    assert jolt.t == pytest.approx(0.3, abs=1e-12)
    assert jolt.impulse == pytest.approx(0.5 * 3.0, rel=1e-12)  # J (4 - 1)
    assert -jolt.energy_lost == pytest.approx(0.5 * 0.5 * (16 - 1), rel=1e-12)  # the change of J w^2/2
    assert np.abs(run["energy.balance"]).max() < 1e-12


def test_a_spring_against_a_driven_slider_takes_the_power_of_the_drive():
    text = """
format = 1
gravity = [0, 0]
ground.points = { O = [0, 0] }
bodies.s = { points = { P = [0, 0] }, mass = 2, inertia = 1 }
joints.O = { type = "prismatic", connect = ["ground.O", "s.P"], axis = "0 deg" }
drivers.m = { joint = "O", speed = "0.5*sin(4*t)" }
loads.k = { type = "spring", connect = ["ground.O", "s.P"], stiffness = 100, free_length = 0.1 }
initial.s = { x = 0.2 }
"""
    m = rt.loads(text)
    t = np.linspace(0, 1.5, 7)
    run = m.simulate(1.5, t_eval=t, rtol=1e-10, atol=1e-12)
    x = 0.2 + 0.125 * (1 - np.cos(4 * t))
    np.testing.assert_allclose(run["s.x"], x, atol=1e-9)
    np.testing.assert_allclose(run["m.force"], 2 * 2.0 * np.cos(4 * t) + 100 * (x - 0.1), atol=1e-7)
    np.testing.assert_allclose(run["m.power"], run["m.force"] * 0.5 * np.sin(4 * t), atol=1e-9)
    work = solve_ivp(
        lambda t, _: (4 * np.cos(4 * t) + 100 * (0.1 + 0.125 * (1 - np.cos(4 * t)))) * 0.5 * np.sin(4 * t),
        (0, 1.5), [0.0], rtol=1e-11, atol=1e-13,
    ).y[0, -1]  # fmt: skip
    assert run["energy.work"][-1] == pytest.approx(work, abs=1e-8)
    assert run.power().residual < 1e-8


@pytest.mark.parametrize(
    ("written", "words"),
    [
        ('speed = "w.omega"', "use [states]"),
        ('speed = "z"', "is a state; use [states]"),
        ('speed = "1 rad/s", angle = "t"', "give angle or speed, not both"),
        ('speed = "5 m"', "expected an angular velocity"),
        ('speed = "nosuch"', "unknown name 'nosuch'"),
    ],
)
def test_what_is_no_speed_over_time_is_refused(written, words):
    with pytest.raises(rt.ModelError) as caught:
        rt.loads(WHEEL.replace("SPEED", written) + 'states.z = { rate = "1" }\n')
    assert words in str(caught.value)
    assert "drivers.m" in str(caught.value)


def test_two_drivers_of_one_coordinate_are_refused():
    text = WHEEL.replace("SPEED", "speed = 1") + 'drivers.n = { joint = "O", angle = "t" }\n'
    with pytest.raises(rt.ModelError, match="already driven by 'm'"):
        rt.loads(text)
