"""A run that went wrong says so: it ends at its last good instant, without success, and names the cause."""

import numpy as np
import pytest

import at_random
import rattle as rt
from linkages import paper, slider_crank
from rattle.analyses.dynamics import soundness
from rattle.analyses.dynamics.horizon import tighter
from rattle.analyses.dynamics.soundness import jump
from rattle.questions.lyapunov.compute import Lyapunov

TRIANGLE = """
format = 1
[ground.points]
A = [0, 0]
B = [1, 0]
[bodies]
a = { bar = ["A", "C"], length = 1, mass = 1 }
b = { bar = ["C", "B"], length = 1, mass = 1 }
[joints]
A = { type = "revolute", connect = ["ground.A", "a.A"] }
C = { type = "revolute", connect = ["a.C", "b.C"] }
B = { type = "revolute", connect = ["b.B", "ground.B"] }
[drivers.motor]
joint = "A"
angle = "pi/3 + MOTION"
[initial]
a = { angle = "60 deg" }
b = { angle = "-60 deg" }
[simulate]
t_end = 0.05
"""


def triangle(motion):
    """Two bars and the ground, which nothing can move, with a motor."""
    return rt.loads(TRIANGLE.replace("MOTION", motion))


def parallel_cranks(second):
    """A parallelogram with a motor at either crank; that of the second follows `second`."""
    m = rt.Mechanism("two motors", gravity=[0, -9.81]).ground(A=[0, 0], D=[1, 0])
    m.bar("crank", "A", "B", length=0.4, mass=1).bar("coupler", "B", "C", length=1, mass=2)
    m.bar("rocker", "D", "C", length=0.4, mass=1)
    m.revolute("A", "ground.A", "crank.A").revolute("B", "crank.B", "coupler.B")
    m.revolute("C", "coupler.C", "rocker.C").revolute("D", "ground.D", "rocker.D")
    m.initial("crank", angle=1.0).initial("coupler", angle=0.0).initial("rocker", angle=1.0)
    return m.driver("one", "A", angle="1 + sin(2*t)").driver("two", "D", angle=second)


# ---------------------------------------------------------------- drivers that the joints contradict
@pytest.mark.nojit
@pytest.mark.parametrize("motion", ["10*t", "10*t**2", "sin(t)**3", "max(0, t - 0.03)**2"])
def test_a_motor_on_a_rigid_triangle_is_refused_whenever_it_starts_to_turn(motion):
    for analysis in (
        lambda m: m.check(),
        lambda m: m.simulate(0.05),
        lambda m: m.kinematics([0.0, 0.01]),
        lambda m: m.inverse_dynamics([0.0, 0.01]),
    ):
        with pytest.raises(rt.AssemblyError, match="'motor' is contradicted by joints 'A', 'C', 'B'"):
            analysis(triangle(motion))


@pytest.mark.nojit
def test_a_motor_that_asks_for_a_position_the_joints_do_not_have_is_one_too_many():
    with pytest.raises(rt.AssemblyError, match=r"driver 'motor' .* no motion \(one driver too many\)"):
        triangle("0.2 + 0*t").check()


@pytest.mark.nojit
def test_a_motor_that_holds_a_rigid_triangle_still_is_no_contradiction():
    report = triangle("0*t").check()
    assert (report.mobility, report.redundant) == (0, 1)
    assert "motor" in report.redundant_joints


@pytest.mark.nojit
@pytest.mark.parametrize("second", ["1 + 2*t", "1 + 2*sin(t)", "1 + sin(2*t) + max(0, t - 0.7)**3"])
def test_two_motors_of_one_freedom_must_agree_at_every_later_instant(second):
    with pytest.raises(rt.AssemblyError, match="drivers 'one' and 'two' drive the same degree of freedom"):
        parallel_cranks(second).check()


def test_two_motors_that_always_agree_run_and_their_efforts_are_said_not_to_be_unique():
    run = parallel_cranks("1 + sin(2*t)").simulate(1.0)
    assert run.success
    assert {"one", "two"} <= set(run.trust.nonunique)
    np.testing.assert_allclose(run["rocker.angle"], 1 + np.sin(2 * run.t), atol=1e-12)


@pytest.mark.nojit
def test_a_driver_at_a_dead_centre_is_not_called_a_contradiction():
    m = rt.loads(slider_crank('joint = "guide"\nposition = "0.4 - 0.1*t"', crank="{ angle = 0 }"))
    with pytest.raises(rt.ModelError, match="dead centre"):
        m.kinematics([0.0, 0.01])


# ---------------------------------------------------------------- runs that end
@pytest.mark.nojit
@pytest.mark.parametrize(
    ("function", "said"),
    [
        ("max(0, 10*(t - 0.5))", "speed at t = 0.5 s, from 0 to 10 rad/s"),
        ("3*t + 0.25*step(t - 0.5)", "position at t = 0.5 s, from 1.5 to 1.75 rad"),
        ("5*max(0, t - 0.5)**2", ""),
        ("0.1*tanh(1e5*(t - 0.5))", ""),
    ],
)
def test_where_a_driver_jumps_is_found_and_smooth_ones_are_left_alone(function, said):
    found = jump(rt.loads(slider_crank(f'joint = "O"\nangle = "{function}"')).system, 0.45, 0.6)
    assert said in found
    assert bool(found) == bool(said)


def test_a_ratio_of_masses_that_leaves_no_digits_ends_the_run_and_is_named():
    m = rt.example("slider_crank").set({"bodies.slider.mass": "1e12 kg"})
    run = m.simulate(0.01, rtol=1e-5)
    assert not run.success
    assert "'slider' has 4.8e+12 times the mass of 'rod'" in run.message
    assert run.t[-1] < 0.01
    assert run.trust.drift < 1e-3 * m.system.extent
    assert run.trust.energy_share < 1e-3


def test_fixed_steps_that_are_too_long_end_a_run_and_shorter_ones_do_not():
    m = rt.loads(
        slider_crank('joint = "O"\nangle = "60*t"', extra="[loads.F]\ntype = 'torque'\nbody = 'rod'\ntorque = 3")
    )
    coarse, fine = m.simulate(0.2, method="rk4", step=0.02), m.simulate(0.2, method="rk4", step=5e-4)
    assert not coarse.success
    assert "far too long for this motion; choose a shorter step" in coarse.message
    assert fine.success
    assert fine.trust.energy_share < 1e-6


def test_energy_that_is_off_by_more_than_rounding_is_said_with_its_share():
    m = rt.example("double_pendulum")
    rough, fine = m.simulate(2.0, rtol=1e-4), m.simulate(2.0, rtol=1e-10)
    assert rough.success
    assert 1e-6 < rough.trust.energy_share < 1e-3
    assert "of the largest energy" in " ".join(rough.trust.notes)
    assert "of the largest energy" in str(rough.trust).splitlines()[0]
    assert fine.trust.energy_share < 1e-6
    assert "of the largest energy" not in str(fine.trust)


def test_mechanisms_without_energy_are_not_refused_for_rounding():
    """At rest under weight and a spring, at rest without any load, and started from rest by a torque that grows."""
    still = rt.Mechanism("still", gravity=[0, -9.81]).ground(O=[0, 0], P=[1, 0])
    still.bar("rod", "A", "B", length=1, mass=2).revolute("O", "ground.O", "rod.A")
    still.load("hold", "spring", connect=["ground.P", "rod.B"], stiffness=1e4, free_length=0.5)
    still.initial("rod", angle=still.equilibrium()[0]["rod.angle"])
    idle = rt.loads(slider_crank("joint = 'O'\nangle = 0.3"))
    started = rt.Mechanism("started").ground(O=[0, 0]).bar("rod", "A", "B", length=1, mass=2)
    started.revolute("O", "ground.O", "rod.A").load("M", "torque", body="rod", torque="40*t**3")
    for m in (still, idle, started):
        for method in ("dop853", "rk4"):
            run = m.simulate(0.5, method=method)
            assert run.success, run.message
            assert run.trust.energy_share < 1e-6


def test_place_of_the_origin_does_not_change_what_drift_is_measured_with():
    near = rt.loads(slider_crank())
    far = rt.loads(slider_crank().replace("O = [0, 0]\n[bodies.crank]", "O = [1000, 500]\n[bodies.crank]"))
    assert far.system.extent == pytest.approx(near.system.extent, rel=1e-12)


# ---------------------------------------------------------------- runs that get nowhere
def test_a_run_that_creeps_is_ended_and_says_how_long_it_would_take(monkeypatch):
    monkeypatch.setattr(soundness, "CREEPING", 2000)
    run = rt.loads(paper(r=1e-9)).simulate(1000.0)
    assert not run.success
    assert "most_steps lets it go on" in run.message
    assert "the smallest clearance is that of joint 'O3', 1e-09 m" in run.message
    assert run.stats["steps"] < 10_000


def test_a_run_that_creeps_names_the_pin_that_rolls_round_its_bush(monkeypatch):
    """Two rotors hang in loose pins without friction; the pin of the light play goes round a thousand times as fast."""
    monkeypatch.setattr(soundness, "CREEPING", 2000)
    m = rt.Mechanism("rotors").ground(A=[0, 0], B=[1, 0])
    for name, clearance in (("A", 1e-3), ("B", 1e-6)):
        m.body(f"rotor{name}", mass=1, inertia=1e-3, points={name: [0, 0]})
        m.revolute(name, f"ground.{name}", f"rotor{name}.{name}", clearance=clearance, contact={"model": "impact"})
        m.initial(f"rotor{name}", x=float(name == "B") + clearance, vy=1.0)
    run = m.simulate(1000.0, t_eval=[0.0, 1000.0])
    assert "Steps follow the pin of joint 'B', which moves 1e+06 clearances in a second" in run.message


def test_a_run_takes_the_steps_it_was_given():
    creeping = rt.loads(paper(r=1e-7)).simulate(1000.0, t_eval=[0.0, 1000.0], most_steps=3000)
    assert not creeping.success
    assert "the limit given by most_steps" in creeping.message
    assert rt.loads(paper()).simulate(0.01, most_steps=10_000).success


@pytest.mark.nojit
@pytest.mark.parametrize("method", ["dop853", "rk4", "event", "moreau"])
def test_a_run_takes_no_step_more_than_it_was_given(method):
    m = rt.example("double_pendulum" if method in ("dop853", "rk4") else "bouncing_pin")
    run = m.simulate(100.0, method=method, most_steps=50, t_eval=[0.0, 100.0])
    assert run.stats["steps"] == 50
    assert "after 50 steps, the limit given by most_steps" in run.message


@pytest.mark.nojit
def test_tolerances_below_the_digits_of_numbers_are_refused():
    with pytest.raises(ValueError, match="rtol = 1e-20 is below the digits"):
        rt.example("double_pendulum").simulate(0.1, rtol=1e-20)


def test_loads_too_large_for_numbers_are_named_and_no_other_method_is_advised():
    m = rt.example("double_pendulum").load("M", "torque", body="upper", torque="1e300*cos(t)")
    run = m.simulate(0.1)
    assert not run.success
    assert "too large for numbers" in run.message
    assert "dop853" not in run.message


# ---------------------------------------------------------------- massless links
def test_a_massless_link_driven_through_a_change_point_says_how_fast_it_turns():
    m = rt.Mechanism("parallelogram", gravity=[0, -9.81]).ground(A=[0, 0], D=[0.3, 0])
    m.bar("crank", "A", "B", length=0.1, mass=0.3).bar("coupler", "B", "C", length=0.3, mass=0.5)
    m.bar("rocker", "D", "C", length=0.1, mass=0.3)
    m.revolute("A", "ground.A", "crank.A").revolute("B", "crank.B", "coupler.B")
    m.revolute("C", "coupler.C", "rocker.C", clearance=2e-4, contact="massless-link")
    m.revolute("D", "ground.D", "rocker.D").driver("motor", "A", angle="0.5 + 10*t")
    m.initial("crank", angle=0.5).initial("coupler", angle=0.0).initial("rocker", angle=0.5)
    before, behind = m.simulate(0.2), m.simulate(0.36)  # change point at (pi - 0.5)/10 s
    assert "massless link" not in " ".join(before.trust.notes)
    assert "the massless link of 'C' turns at up to" in " ".join(behind.trust.notes)
    assert "times as fast as its driver" in " ".join(behind.trust.notes)


# ---------------------------------------------------------------- horizon
def test_a_curve_that_only_shows_rounding_sets_no_horizon():
    """The energy of a pendulum does not change: what is seen of that is tolerance, in both runs differently."""
    m = rt.Mechanism("pendulum", gravity=[0, -9.81]).ground(O=[0, 0]).bar("rod", "A", "B", length=1, mass=2)
    m.revolute("O", "ground.O", "rod.A").initial("rod", angle=0.3, omega=1.0)
    m.signal("energy_left", "(rod.vx**2 + rod.vy**2 + rod.omega**2/12)/2 + 9.81*rod.y")
    run = m.simulate(4.0, horizon=True)
    assert 0.0 < np.ptp(run["energy_left"]) < 1e-6
    assert run.trust.horizon == 4.0
    assert "over the whole run" in str(run.trust)


@pytest.mark.parametrize("rtol", [1e-4, 1e-8])
def test_up_to_the_horizon_positions_are_those_of_a_far_tighter_run(rtol):
    m = rt.example("slider_crank_play")
    run, reference = m.simulate(horizon=True, rtol=rtol), m.simulate(rtol=1e-12)
    trusted = run.t <= run.trust.horizon
    assert ("is loose" in " ".join(run.trust.notes)) == (rtol > 1e-6)
    for name in ("slider.x", "rod.angle", "slider.vx"):
        apart = np.abs(run[name] - reference[name])[trusted]
        assert apart.max() < 0.02 * np.ptp(reference[name])  # 1 % between two runs, and as much for the tighter one


@pytest.mark.nojit
def test_two_loose_runs_are_never_compared_with_each_other():
    assert tighter(1e-4, 1e-8) == 1e-8
    assert tighter(1e-8, 1e-8) == pytest.approx(1e-9)
    assert tighter(1e-11, 1e-8) == pytest.approx(1e-12)


UNSTABLE = """
format = 1
[ground.points]
O = [0, 0]
[bodies.mass]
points = { P = [0, 0] }
mass = 1
inertia = 1
[joints.rail]
type = "prismatic"
connect = ["ground.O", "mass.P"]
[loads.push]
type = "force"
at = "mass.P"
force = ["4*mass.x", 0]
[initial]
mass = { x = 3, vx = 4 }
"""


def test_a_motion_that_grows_beyond_numbers_is_said_to_grow():
    run = rt.loads(UNSTABLE).simulate(400.0, t_eval=[0.0, 1.0])
    assert not run.success
    end = float(run.message.partition("t = ")[2].partition(" s:")[0])
    # 4 exp(2 t) is the largest number, 1.8e308, at 354.2 s; a step needs a few powers of ten more
    assert 340 < end < 354.3
    assert "the motion grows beyond numbers (mass.vx is " in run.message
    assert "end the run earlier" in run.message
    assert "position that cannot be passed" not in run.message
    with pytest.raises(ValueError, match=r"grown to 6e\+06 times .* lost in rounding there, so there is no exponent"):
        rt.loads(UNSTABLE).lyapunov(400.0)


# ---------------------------------------------------------------- Lyapunov exponent
def test_no_exponent_is_given_where_nothing_can_grow():
    with pytest.raises(ValueError, match="the drivers fix every position"):
        rt.example("slider_crank").lyapunov(0.01)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"t_end": 0.0}, "t_end must be positive"),
        ({"t_end": float("nan")}, "t_end"),
        ({"stretch": float("inf")}, "stretch"),
        ({"stretch": 0.0}, "stretch must be positive"),
        ({"t_end": 1.0, "stretch": 0.9}, "too long for 1 s"),
    ],
)
def test_times_of_an_exponent_are_checked_before_it_is_measured(given, said):
    with pytest.raises(ValueError, match=said):
        rt.example("double_pendulum").lyapunov(**{"t_end": 1.0} | given)


def test_an_exponent_with_a_large_uncertainty_says_so():
    made = Lyapunov(2.0, 1.0, 100.0, np.zeros(10), 0.1)
    assert "rough: uncertain by 50 %" in str(made)
    assert "not determined" in str(made._replace(uncertainty=3.0))
    assert "rough" not in str(made._replace(uncertainty=0.2))


# ---------------------------------------------------------------- mechanisms at random
def test_no_random_mechanism_runs_to_success_with_open_joints_or_energy_from_nowhere():
    """Drivers that nothing can follow are refused by name; whatever runs to its end is closed, with all its energy."""
    refused, ended, ran = [], [], 0
    for seed in range(120):
        m = at_random.mechanism(seed)
        try:
            run = m.simulate(0.1, t_eval=np.linspace(0.0, 0.1, 51))
        except rt.AssemblyError as error:
            refused.append(str(error))
            continue
        assert at_random.open_by(m, run) < 1e-9  # also where the run ended early: what is kept is good
        turned = run["energy.kinetic"].max() + np.abs(run["energy.work"]).max() + np.ptp(run["energy.potential"])
        assert run.trust.energy_balance < 2e-3 * turned + 1e-9
        if run.success:
            ran += 1
        else:
            ended.append(run.message)
    assert ran > 80
    assert all("is contradicted by joints" in one or "drive the same degree of freedom" in one for one in refused)
    assert len(refused) > 3
    assert all("ended at t" in one or "cannot go on at t" in one for one in ended)


def test_rods_that_repeat_each_other_beside_a_driver_that_runs_out_of_reach_are_no_contradiction():
    """Out of reach is for the run to find: three parallel rods elsewhere have nothing to do with the motor."""
    m = rt.loads(slider_crank('joint = "guide"\nposition = "0.35 + 2*t"', crank="{ angle = 0.8 }"))
    m._document["ground"]["points"] |= {"G": [5, 0], "H": [5, 1], "K": [5, 2]}
    m.body("plate", mass=1, inertia=1, points={"G": [0, 0], "H": [0, 1], "K": [0, 2]}).initial(
        "plate", x=6, y=0, angle=0
    )
    for name in "GHK":
        m.rod(f"rod{name}", f"ground.{name}", f"plate.{name}", length=1.0)
    assert m.check().redundant == 1
    run = m.simulate(0.1)
    assert not run.success
    assert "dead centre" in run.message
    assert run.t[-1] < 0.025  # 0.4 m are crank and rod in one line
