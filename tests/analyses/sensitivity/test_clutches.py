"""Derivatives of motions with one-way clutches: closed forms, and runs beside theirs."""

import math
from pathlib import Path

import numpy as np
import pytest

import rattle as rt
from rattle.errors import TraceError
from runs_beside import FINE, differences

EXAMPLES = Path(rt.__file__).parent / "examples"


def flywheel(clutch="", start="w", more=""):
    """That is braked until a shaft of even speed drives it; more: of the stop of its bearing."""
    return f"""
format = 1
parameters = {{ w = 80.0, T = 3.0, speed = 50.0, c = 0.2, k = 400.0 }}
ground.points.O = [0, 0]
bodies.shaft = {{ points = {{ O = [0, 0] }}, mass = 1, inertia = 0.01 }}
bodies.wheel = {{ points = {{ O = [0, 0] }}, mass = 1, inertia = 0.04 }}
joints.S = {{ type = "revolute", connect = ["ground.O", "shaft.O"] }}
joints.W = {{ type = "revolute", connect = ["ground.O", "wheel.O"]{more} }}
joints.free = {{ type = "clutch", connect = ["shaft", "wheel"]{clutch} }}
drivers.motor = {{ joint = "S", angle = "speed*t" }}
loads.brake = {{ type = "torque", body = "wheel", torque = "-T" }}
initial.wheel = {{ angle = 0, omega = "{start}" }}
"""


def slopes(m, outputs, parameters, t):
    s = m.sensitivity(outputs, parameters, t, **FINE)
    assert s.success, s.message
    return {(of, to): s[f"d({of})/d({to})"] for of in outputs for to in parameters}


def test_a_flywheel_is_overtaken_and_driven():
    """It runs freely until (w - speed) J/T; from there on it goes with the shaft, which bears the brake."""
    m, parameters = rt.loads(flywheel()), ["w", "T", "speed"]
    of = ["wheel.angle", "wheel.omega", "free.torque", "time(free.contacts, 1)", "speed(free.contacts, 1)"]
    d = slopes(m, of, parameters, [0.0, 0.1, 1.0])
    w, torque, speed, inertia = 80.0, 3.0, 50.0, 0.04
    locks = (w - speed) * inertia / torque
    by = {"w": inertia / torque, "T": -locks / torque, "speed": -inertia / torque}
    for name in parameters:
        assert d[of[3], name][0] == pytest.approx(by[name], rel=1e-9), name
        assert d[of[1], name][-1] == pytest.approx(float(name == "speed"), abs=1e-9), name
        assert d[of[2], name][-1] == pytest.approx(float(name == "T"), abs=1e-8), name
        assert d[of[4], name][0] == 0.0
    ahead = (w - speed) * locks / 2.0  # angle by which it is ahead once it locks
    assert d[of[0], "w"][-1] == pytest.approx(2.0 * ahead / (w - speed), rel=1e-8)
    assert d[of[0], "T"][-1] == pytest.approx(-ahead / torque, rel=1e-8)
    assert d[of[0], "speed"][-1] == pytest.approx(1.0 - 2.0 * ahead / (w - speed), rel=1e-8)


def test_a_viscous_clutch_lags_behind():
    """J w' = -T + c (speed - w) from the lock on."""
    m = rt.loads(flywheel(', model = "viscous", damping = "c"'))
    d = slopes(m, ["wheel.omega"], ["T", "c", "speed"], [0.0, 0.7])

    def rate(torque=3.0, c=0.2, speed=50.0):
        locks = (80.0 - speed) * 0.04 / torque
        return speed - torque / c * (1.0 - math.exp(-c / 0.04 * (0.7 - locks)))

    for name, x in {"torque": 3.0, "c": 0.2, "speed": 50.0}.items():
        want = (rate(**{name: x + 1e-6 * x}) - rate(**{name: x - 1e-6 * x})) / (2e-6 * x)
        assert d["wheel.omega", {"torque": "T"}.get(name, name)][-1] == pytest.approx(want, rel=1e-7), name


def test_an_elastic_clutch_winds_up():
    """tau = k x: it swings about speed with sqrt(k/J), and lets go where it is unwound."""
    m = rt.loads(flywheel(', model = "compliant", stiffness = "k"'))
    of = ["wheel.omega", "peak(free.contacts, 1)", "time(free.contacts, 2)"]
    d = slopes(m, of, ["T", "k"], [0.0, 0.5])
    peak = 2.0 * 3.0  # the brake, applied at once
    assert d[of[1], "T"][0] == pytest.approx(2.0, rel=1e-6)
    assert d[of[1], "k"][0] == pytest.approx(0.0, abs=1e-6 * peak / 400.0)
    swing = math.sqrt(400.0 / 0.04)
    at = swing * (0.5 - 30.0 * 0.04 / 3.0)
    by_torque = -math.sin(at) / math.sqrt(400.0 * 0.04) - 3.0 / 0.04 * math.cos(at) * 30.0 * 0.04 / 9.0
    assert d[of[0], "T"][-1] == pytest.approx(by_torque, rel=1e-6)
    assert np.isnan(d[of[2], "T"]).all()  # it never is


def test_an_elastic_clutch_lets_go_for_less_than_a_step():
    """As its drive swings: torques that end and begin again within a step are found at every tolerance."""
    text = flywheel(', model = "compliant", stiffness = "k"').replace('"speed*t"', '"speed*t + 0.12*sin(100*t)"')
    m = rt.loads(text)
    for k in (300.0, 390.0, 400.0, 410.0, 500.0):
        events = [e.t for e in m.set(k=k).simulate(t_end=0.7, **FINE).events if e.kind == "lock"]
        assert len(events) > 3
        for rtol in (1e-7, 1e-11):
            s = m.set(k=k).sensitivity(["wheel.omega", f"time(free.contacts, {len(events)})"], ["T"], [0.7], rtol=rtol)
            assert s.success, s.message
            assert s[f"time(free.contacts, {len(events)})"][0] == pytest.approx(
                events[-1], abs=1e-4 if rtol > 1e-9 else 1e-7
            )


def test_torques_and_speeds_where_a_clutch_takes_up():
    """At once, by an impact of its wheel with a stop: a viscous one, and the largest torque of an ideal one."""
    stop = ', stop = { max = 1.5, min = -9, contact = { model = "impact", restitution = 0.5 } }'
    m = rt.loads(flywheel(', model = "compliant", stiffness = "k", damping = "c"', start="0", more=stop)).set(T=0.1)
    of = ["speed(free.contacts, 1)", "peak(free.contacts, 1)", "max(free.torque)"]
    for name in ("c", "k", "speed"):
        d = slopes(m, of, [name], [0.0, 0.25])
        x = m.parameters[name]
        low, high = (m.set({name: x * (1.0 + way)}).simulate(t_end=0.25, **FINE).events[0] for way in (-1e-4, 1e-4))
        for output, field in zip(of, ("normal_speed", "peak_force", "peak_force"), strict=True):
            want = (getattr(high, field) - getattr(low, field)) / (2e-4 * x)
            assert d[output, name][0] == pytest.approx(want, rel=1e-4, abs=1e-6), (output, name)
    ideal = slopes(rt.loads(flywheel()), ["peak(free.contacts, 1)"], ["T"], [0.0, 1.0])
    assert ideal["peak(free.contacts, 1)", "T"][0] == pytest.approx(1.0, rel=1e-8)


def test_a_stop_that_the_wheel_hits_while_it_is_driven():
    """The clutch bears no impulse that pulls: it lets the wheel rebound, and drives it again."""
    stop = ', stop = { max = 1.5, min = -9, contact = { model = "impact", restitution = 0.5 } }'
    m = rt.loads(flywheel(', model = "viscous", damping = "c"', start="0", more=stop)).set(T=0.1)
    t = np.linspace(0.0, 0.3, 6)
    for name in ("c", "T", "speed"):
        found = slopes(m, ["wheel.angle"], [name], t)["wheel.angle", name]
        want = differences(m, name, ["wheel.angle"], t, step=3e-4)["wheel.angle"]
        assert np.abs(want).max() > 0.01
        assert found == pytest.approx(want, abs=1e-5 * np.abs(want).max()), name


@pytest.mark.parametrize("name", ["torque_converter", "torque_converter_epicyclic"])
def test_torque_converters(name):
    m, t = rt.load(EXAMPLES / f"{name}.toml"), np.linspace(0.0, 0.12, 5)
    of = ["rotor.omega", "energy.work"]
    for parameter in ("load", "speed"):
        d, want = slopes(m, of, [parameter], t), differences(m, parameter, of, t)
        for output in of:
            assert d[output, parameter] == pytest.approx(want[output], abs=2e-6 * np.abs(want[output]).max()), output


def test_what_has_no_derivatives_is_said():
    with pytest.raises(TraceError, match=r"clutches with max_torque \(joint free\) have no derivatives"):
        rt.loads(flywheel(", max_torque = 2")).sensitivity(["wheel.omega"], ["T"], [0.1])
    found = rt.loads(flywheel(start="0.5*w")).sensitivity(["wheel.omega"], ["T"], [0.1])
    assert "the clutch free drives at the start already" in found.message
