"""Loads, drivers and signals that lose their value in a run are named, with the instant."""

import pytest

import rattle as rt


def spinning(**fields):
    m = rt.Mechanism("disc")
    m.ground(O=[0, 0]).body("disc", mass=1, inertia=1, points={"O": [0, 0]}).revolute("O", "ground.O", "disc.O")
    return m


def moment(**options):
    return spinning().load("M", "torque", body="disc", torque="sqrt(0.1 - t)").simulate(0.3, **options)


@pytest.mark.parametrize("options", [{"method": "dop853"}, {"method": "rk4", "step": 1e-3}])
def test_load_that_loses_its_value_is_named_with_the_instant(options):
    r = moment(**options)
    assert not r.success
    assert "loads.M" in r.message
    assert "no finite value at t = 0.1" in r.message
    assert "square root" in r.message
    assert r.t[-1] == pytest.approx(0.1, abs=2e-3)


def test_driver_that_loses_its_value_is_named_with_the_instant():
    r = spinning().driver("motor", "O", angle="log(0.2 - t)").simulate(0.3)
    assert not r.success
    assert "drivers.motor.angle" in r.message
    assert "no finite value at t = 0.2" in r.message
    assert r.t[-1] < 0.2


def test_signal_that_loses_its_value_is_named():
    m = spinning().signal("s", "1/(0.1 - t) if t < 0.1 else sqrt(0.1 - t)")
    r = m.load("M", "torque", body="disc", torque="s*1e-3").simulate(0.3)
    assert not r.success
    assert "signals.s" in r.message


@pytest.mark.parametrize(
    "text", ["1/(0.1 - t)", "1/(0.1 - t)**2", "1/(0.1 - t) if t < 0.1 else 0", "1/(0.1 - disc.angle)"]
)
def test_expression_that_grows_beyond_all_bounds_is_named(text):
    # behind its pole it has finite values again, and no step ends right on it
    m = spinning().signal("s", text).initial("disc", omega=1.0)
    r = m.load("M", "torque", body="disc", torque="s*1e-3").simulate(0.3)
    assert not r.success
    assert r.trust.t_end == pytest.approx(0.1, rel=2e-3)  # the load makes the disc faster by a thousandth
    assert "signals.s has no finite value at t = " in r.message


def test_start_without_a_value_is_named():
    with pytest.raises(rt.AssemblyError, match="the function of driver 'motor' has no finite value at t = 0 s"):
        _ = spinning().driver("motor", "O", angle="log(t - 1)").start


@pytest.mark.parametrize("angle", ["log(t)", "1/t", "t**-1"])
@pytest.mark.parametrize("analysis", ["kinematics", "inverse_dynamics", "equilibrium", "modes"])
def test_every_analysis_names_a_driver_without_a_value_at_its_start(analysis, angle):
    m = rt.Mechanism("rod").ground(O=[0, 0]).body("rod", mass=1, inertia=1, points={"A": [0, 0]})
    m.revolute("O", "ground.O", "rod.A").driver("motor", "O", angle=angle)
    times = ([0.0, 0.1],) if analysis in ("kinematics", "inverse_dynamics") else ()
    with pytest.raises(rt.AssemblyError, match="the function of driver 'motor' has no finite value at t = 0 s"):
        getattr(m, analysis)(*times)


def test_strict_run_raises_with_the_result():
    with pytest.raises(rt.SolverError, match="no finite value") as caught:
        moment(strict=True)
    assert len(caught.value.result.t) > 10
