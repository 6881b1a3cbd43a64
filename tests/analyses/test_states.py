"""States of the model's own: closed forms, SciPy, every stepper, impacts and switches, and what is refused."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import rattle as rt
from rattle.errors import ModelError, TraceError
from rattle.results.result import load_result

nojit = [pytest.mark.nojit, pytest.mark.plain]
FINE = {"rtol": 1e-11, "atol": 1e-13}
DC_MOTOR = """
format = 1
[parameters]
R = 1.0
L = 0.5e-3
k = 0.05
V = { value = 12.0, min = 1, max = 48 }
[states]
i = { rate = "(V - R*i - k*speed)/L", start = 0 }
[signals]
speed = "rotor.omega"
[ground.points]
O = [0, 0]
[bodies.rotor]
points = { C = [0, 0] }
mass = 1
inertia = 1e-4
[joints.pin]
type = "revolute"
connect = ["ground.O", "rotor.C"]
[loads.M]
type = "motor"
connect = ["ground", "rotor"]
torque = "k*i"
[loads.drag]
type = "torque"
body = "rotor"
torque = "-0.1"
[initial]
rotor = { angle = 0, omega = 0 }
"""


def dc_motor(t, V=12.0):
    """Current [A] and speed [rad/s] of the motor at times t [s]: exponential of the matrix of its linear equations."""
    A = np.array([[-1.0 / 0.5e-3, -0.05 / 0.5e-3, V / 0.5e-3], [0.05 / 1e-4, 0.0, -0.1 / 1e-4], [0.0, 0.0, 0.0]])
    return np.array([(expm(A * one) @ [0.0, 0.0, 1.0])[:2] for one in t]).T


def rotor(inertia=1.0, **more):
    m = rt.Mechanism(**more).ground(O=[0, 0]).body("rotor", mass=1, inertia=inertia, points={"C": [0, 0]})
    return m.revolute("pin", "ground.O", "rotor.C").initial("rotor", angle=0, omega=0)


def refused(m):
    with pytest.raises(ModelError) as error:
        _ = m.model
    return str(error.value)


# ---------------------------------------------------------------- against other ways
@pytest.mark.parametrize("method", [pytest.param("dop853", marks=nojit), pytest.param("event", marks=nojit)])
def test_current_and_speed_of_a_dc_motor_are_those_of_the_matrix_exponential(method):
    t = np.array([0.0, 0.001, 0.005, 0.01, 0.05])
    r = rt.loads(DC_MOTOR).simulate(0.05, t_eval=t, method=method, **FINE)
    np.testing.assert_allclose([r["i"], r["rotor.omega"]], dc_motor(t), rtol=1e-9)


@pytest.mark.nojit
def test_rk4_takes_states_along_with_its_order():
    t = np.array([0.0, 0.004])
    runs = [rt.loads(DC_MOTOR).simulate(0.004, t_eval=t, method="rk4", step=h) for h in (1e-4, 5e-5)]
    errors = [abs(r["i"][-1] - dc_motor(t)[0, -1]) for r in runs]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.3)


@pytest.mark.nojit
def test_controlled_pendulum_with_a_filter_is_that_of_scipy():
    """A pendulum is turned by a PID law on a filtered angle: five equations, written down once more for SciPy."""
    m = rt.Mechanism(gravity=[0, -9.81]).ground(O=[0, 0]).bar("arm", "O", "E", length=0.6, mass=2)
    m.revolute("pin", "ground.O", "arm.O").initial("arm", angle=-1.5, omega=0)
    m.state("seen", "(arm.angle - seen)/0.02", start="-1.5 rad").state("held", "wrong", start=0.1)
    m.signal("wrong", "0.3*sin(2*t) - seen").load(
        "hand", "torque", body="arm", torque="40*wrong + 15*held - 3*arm.omega"
    )
    t = np.linspace(0, 2, 9)
    r = m.simulate(2.0, t_eval=t, **FINE)

    def rate(t, y):
        angle, omega, seen, held = y
        wrong = 0.3 * np.sin(2 * t) - seen
        moment = 40 * wrong + 15 * held - 3 * omega - 2 * 9.81 * 0.3 * np.cos(angle)
        return omega, moment / (2 * 0.6**2 / 3), (angle - seen) / 0.02, wrong

    y = solve_ivp(rate, (0, 2), [-1.5, 0, -1.5, 0.1], "DOP853", t, rtol=1e-12, atol=1e-13).y
    np.testing.assert_allclose([r[k] for k in ("arm.angle", "arm.omega", "seen", "held")], y, atol=1e-9)
    assert r.unit("held") == r.unit("wrong") + "s"  # an angle, which is a plain number, times a time


@pytest.mark.nojit
def test_state_of_the_power_is_the_work_and_one_of_a_speed_is_the_path():
    """Two integrals that every run forms in another way, over a motion with impacts in a bush."""
    m = rt.example("bouncing_pin").load("push", "force", at="pin.P", force=["3*sin(200*t)", 0])
    m = m.state("work", "3*sin(200*t)*pin.vx").state("path", "pin.vy")
    r = m.simulate("8 ms", rtol=1e-10)
    assert sum(one.kind == "impact" for one in r.events) > 3
    np.testing.assert_allclose(r["work"], r["energy.work"], atol=1e-11)
    np.testing.assert_allclose(r["path"], r["pin.y"] - r["pin.y"][0], atol=1e-11)


def test_moreau_jean_takes_states_along_in_second_order_between_impacts():
    """No impact in 0.4 ms: z' = w - z beside a pin in a bush, w its constant speed."""
    m = rt.example("bouncing_pin").state("z", "1000*(pin.vx - z)")
    t, vx = np.array([0.0, 0.4e-3]), np.cos(np.radians(40))
    exact = vx * (1 - np.exp(-0.4))
    errors = [abs(m.simulate(0.4e-3, t_eval=t, method="moreau", step=h)["z"][-1] - exact) for h in (2e-5, 1e-5)]
    assert errors[0] < 1e-4 * vx
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.3)


# ---------------------------------------------------------------- switches
@pytest.mark.nojit
def test_steps_end_where_the_rate_of_a_state_switches():
    """z' = max(0, w - 1) with w = t: z = (t - 1)^2/2 after 1 s, in spite of the kink to rounding."""
    m = rotor().load("push", "torque", body="rotor", torque=1).state("z", "max(0, rotor.omega - 1)")
    r = m.simulate(3.0, t_eval=[0.5, 1.0, 1.7, 3.0])
    np.testing.assert_allclose(r["z"], np.maximum(r.t - 1, 0) ** 2 / 2, atol=1e-12)


@pytest.mark.nojit
def test_switch_that_depends_on_a_state_alone_is_located():
    """A clock z' = 1 as a state sets off a torque at z = 0.3 s: w = 2 (t - 0.3)."""
    m = rotor().state("z", 1, start="0 s").load("push", "torque", body="rotor", torque="2 if z > 0.3 else 0")
    r = m.simulate(1.0, t_eval=[0.2, 0.3, 0.45, 1.0])
    np.testing.assert_allclose(r["rotor.omega"], 2 * np.maximum(r.t - 0.3, 0), atol=1e-12)
    np.testing.assert_allclose(r["z"], r.t, atol=1e-14)


# ---------------------------------------------------------------- results and studies
@pytest.mark.nojit
def test_states_are_saved_with_their_units_and_start_from_expressions(tmp_path):
    m = rotor().parameter("w0", "3 rad/s").state("turn", "w0*t", start="w0*0.5").state("v", "0.5 m/s^2", start="2 m/s")
    r = m.simulate(1.0, t_eval=[0.0, 1.0])
    r.save(tmp_path / "r.nc")
    r = load_result(tmp_path / "r.nc")
    np.testing.assert_allclose([r["turn"], r["v"]], [[1.5, 3.0], [2.0, 2.5]], atol=1e-12)
    assert (r.unit("v"), list(r.names).index("v") - list(r.names).index("turn")) == ("m/s", 1)


def test_samples_side_by_side_follow_states_as_single_runs_do():
    m = rt.loads(DC_MOTOR)
    made = m.many({"V": [6.0, 24.0]}, outputs=["final(i)"], t_end=0.01)
    assert "side by side" in str(made)
    np.testing.assert_allclose(made["final(i)"], [dc_motor([0.01], V)[0, 0] for V in (6.0, 24.0)], rtol=1e-6)


def test_sensitivity_of_a_state_is_exact():
    """The equations are linear in V: the derivative by V is the motion at 1 V without drag."""
    s = rt.loads(DC_MOTOR).sensitivity(["i"], ["V"], [0.0, 0.01])
    want = dc_motor([0.01], 13.0)[0, 0] - dc_motor([0.01], 12.0)[0, 0]
    assert s["d(i)/d(V)"][-1] == pytest.approx(want, rel=1e-8)
    with pytest.raises(TraceError, match="start of the state 'i' depends on a parameter"):
        rt.loads(DC_MOTOR.replace("start = 0", 'start = "0.1*V"')).sensitivity(["i"], ["V"], [0.0, 0.01])


@pytest.mark.nojit
def test_analyses_of_single_positions_refuse_states_with_what_to_do():
    m = rt.loads(DC_MOTOR)
    with pytest.raises(ModelError, match=r"states.i: a load depends on it, and equilibrium .* simulate until"):
        m.equilibrium()
    with pytest.raises(ModelError, match=r"states.i: a state depends on all that was before, .* use simulate"):
        rotor().driver("d", "pin", angle="t").state("i", 1).kinematics([0, 1])


@pytest.mark.nojit
def test_equilibrium_does_not_mind_states_that_only_record():
    m = rt.Mechanism(gravity=[0, -9.81]).ground(O=[0, 0]).bar("arm", "O", "E", length=1, mass=1).state("clock", 1)
    (low, *_) = m.revolute("pin", "ground.O", "arm.O").equilibrium()
    assert low["arm.angle"] == pytest.approx(-np.pi / 2)


# ---------------------------------------------------------------- bad input
@pytest.mark.parametrize(
    ("name", "state", "said"),
    [
        ("i", {"start": 0}, "states.i: needs rate"),
        ("i", {"rate": "1", "begin": 0}, "states.i.begin: unknown key"),
        ("i", "2*t", "states.i: expected { rate = \"expression\", start = 0 }, got '2*t'"),
        ("i", {"rate": "foo"}, "states.i.rate: unknown name 'foo' in 'foo'"),
        ("i", {"rate": "1", "start": "t"}, "states.i.start: 't' changes during the run; only parameters are allowed"),
        ("i", {"rate": "1", "start": "inf"}, "states.i.start"),
        ("i", {"rate": "5 N", "start": "2 m"}, "states.i.rate: '5 N' is"),
        ("rotor", {"rate": "1"}, "the name 'rotor' is already used in [bodies]"),
        ("size", {"rate": "1"}, "states.size: 'size' is already a parameter"),
        ("t", {"rate": "1"}, "'t' is a reserved word"),
        ("i", {"rate": "log(0) + i"}, "states.i.rate"),
    ],
)
@pytest.mark.nojit
def test_states_that_make_no_sense_are_refused(name, state, said):
    m = rotor().parameter("size", 1)
    m._document["states"] = {name: state}
    assert said in refused(m)


@pytest.mark.nojit
def test_a_driver_cannot_follow_a_state():
    m = rotor().state("i", 1).driver("d", "pin", angle="i")
    assert "a driver must depend on time only, but 'i' is a state" in refused(m)
    m = rotor().state("i", 1).signal("twice", "2*i").driver("d", "pin", angle="twice")
    assert "a driver must depend on time only, but 'twice' depends on the motion" in refused(m)


@pytest.mark.nojit
def test_a_rate_without_a_finite_value_ends_the_run_and_is_named():
    r = rotor().state("z", "1/(0.5 - t)").simulate(1.0)
    assert not r.success
    assert "states.z.rate" in r.message
