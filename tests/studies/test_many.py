"""Many samples of one mechanism: side by side, one by one, and what cannot be run."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import rattle as rt
from rattle.analyses.straight_line import starts
from rattle.errors import ModelError, SolverError
from rattle.results.evaluation import evaluate
from rattle.results.reductions import Known, read
from rattle.studies.runs import analyses
from rattle.studies.runs.reasons import alike

DATA = Path(__file__).parent.parent / "data"
SPRING = """
format = 1
[parameters]
k = { value = 15, min = 1, max = 40 }
x0 = "0.5 m"
m = "1 kg"
[ground.points]
O = [0, 0]
[bodies.block]
points = { P = [0, 0] }
mass = "m"
inertia = 1
[joints.guide]
type = "prismatic"
connect = ["ground.O", "block.P"]
[loads.s]
type = "spring"
connect = ["ground.O", "block.P"]
stiffness = "k"
free_length = 0
[initial]
block = { x = "x0", vx = 0 }
"""


@pytest.mark.nojit
def test_the_papers_four_bars_against_another_formulation():
    l, _, r3, r4, moment, *want = np.loadtxt(DATA / "many_fourbar.csv", delimiter=",", comments="#").T
    outputs = ["at(rocker.angle, 0.02)", "at(rocker.angle, 0.03)", "at(O4.normal, 0.02)", "at(O4.normal, 0.03)"]
    m = rt.example("fourbar").set({"gravity": [0, 0]})
    found = m.many({"l2": l, "l3": l, "r3": r3, "r4": r4, "M": moment}, outputs, 0.03, rtol=1e-11)
    assert not len(found.failed)
    assert not len(found.generic)
    for output, values in zip(outputs, want, strict=True):
        tolerance = 1e-8 if "angle" in output else 2e-2
        np.testing.assert_allclose(found[output], values, rtol=0.0, atol=tolerance)
    assert [found.unit(one) for one in outputs] == ["rad", "rad", "N", "N"]
    order = np.random.default_rng(0).permutation(len(l))[:-3]
    again = m.many(
        {"r4": r4[order], "l2": l[order], "l3": l[order], "r3": r3[order], "M": moment[order]}, outputs[::-1], 0.03,
        rtol=1e-11, threads=2,
    )  # fmt: skip
    for output in outputs:
        np.testing.assert_array_equal(again[output], found[output][order])


@pytest.mark.nojit
def test_reductions_of_a_vibration_have_their_closed_forms():
    k, x0 = np.array([4.0, 9.0, 16.0, 25.0]), np.array([0.5, 0.4, 0.3, 0.2])
    w, t_end = np.sqrt(k), 1.2
    outputs = {
        "final(block.x)": x0 * np.cos(w * t_end),
        "at(block.vx, 0.3)": -x0 * w * np.sin(0.3 * w),
        "max(abs(block.vx))": x0 * w,
        "range(block.x)": x0 * (1.0 - np.cos(np.minimum(w * t_end, np.pi))),
        "integral(block.x**2)": x0**2 * (t_end / 2 + np.sin(2 * w * t_end) / (4 * w)),
        "first(block.x < 0)": np.pi / (2 * w),
        "2*max(energy.potential)/(k*x0**2) - 1": np.zeros(4),
    }
    found = rt.loads(SPRING).many({"k": k, "x0": x0}, list(outputs), t_end, rtol=1e-10)
    assert not len(found.generic)
    for output, want in outputs.items():
        np.testing.assert_allclose(found[output], want, rtol=0.0, atol=2e-9, err_msg=output)
    assert "4 run side by side" in str(found)


@pytest.mark.nojit
def test_curves_with_kinks_and_conditions_that_hold_shortly_keep_their_digits():
    """Steps of a vibration are as long as half a radian; what happens inside of one is not missed."""
    k, x0, t_end = np.array([4.0, 9.0, 16.0]), 0.5, 7.3
    w = np.sqrt(k)
    quarters = np.floor(w * t_end / (np.pi / 2)).astype(int)
    rest = np.sin(w * t_end - quarters * np.pi / 2)
    shortly = np.arccos(0.4999 / x0) / w  # from the start of a period
    periods = np.floor(w * t_end / (2 * np.pi))
    outputs = {
        "integral(abs(block.vx))": x0 * (quarters + np.where(quarters % 2, rest, 1 - np.sqrt(1 - rest**2))),
        "first(abs(block.x) < 0.01)": np.arccos(0.01 / x0) / w,
        "first(block.x < -0.4999)": np.pi / w - shortly,
        "share(block.x > 0.4999)": (1 + 2 * periods) * shortly / t_end,
        "min(abs(block.x))": np.zeros(3),
        "max(abs(block.x))": np.full(3, x0),
    }
    found = rt.loads(SPRING).many({"k": k}, list(outputs), t_end)
    assert not len(found.generic)
    for output, want in outputs.items():
        np.testing.assert_allclose(found[output], want, rtol=0.0, atol=1e-4, err_msg=output)
    jumping = rt.loads(SPRING).many({"k": k}, ["max(block.x if t > 1 else -1)"], 1.5, rtol=1e-10)
    assert "jumps" in jumping.stats["how"]
    late = x0 * np.cos(w * np.array([1.0, 1.5, 1.5]))  # the first falls until t = pi/2
    np.testing.assert_allclose(jumping["max(block.x if t > 1 else -1)"], late, rtol=0.0, atol=2e-3)


@pytest.mark.nojit
def test_forces_that_change_faster_than_a_driven_motion_keep_their_digits():
    """The driver fixes the motion, of which long steps are exact; the load in between is felt by the driver alone."""
    text = SPRING.replace("stiffness", "# stiffness").replace("free_length", "# free_length")
    text = text.replace(
        'type = "spring"\nconnect = ["ground.O", "block.P"]', 'type = "force"\nat = "block.P"\nforce = [F, 0]'
    )
    text = text.replace("[F, 0]", '["k*tanh((block.x - x0)/0.01)", 0]')
    text = text.replace("vx = 0", "vx = 1") + '[drivers.d]\njoint = "guide"\nposition = "t"\n'
    m = rt.loads(text)
    outputs = ["mean(d.force)", "rms(d.force)", "max(d.force)"]
    found = m.many({"k": [2.0, 3.0]}, outputs, 1.0)
    assert not len(found.generic)
    np.testing.assert_allclose(found["rms(d.force)"], np.array([2.0, 3.0]) * np.sqrt(0.98), rtol=1e-5)
    np.testing.assert_allclose(found["max(d.force)"], [2.0, 3.0], rtol=1e-9)
    np.testing.assert_allclose(found["mean(d.force)"], 0.0, atol=1e-6)


@pytest.mark.nojit
@pytest.mark.parametrize("load", ["k*exp(-((t - 0.7)/0.01)**2)", "pulse", "k*tanh(rider.x/1e-3)"])
def test_a_load_that_a_driver_takes_keeps_its_digits_beside_a_free_motion(load):
    more = f"""
[signals]
pulse = "k*exp(-((t - 0.7)/0.01)**2)"
[bodies.rider]
points = {{ P = [0, 0] }}
mass = "1 kg"
inertia = 1
[joints.rail]
type = "prismatic"
connect = ["ground.O", "rider.P"]
[drivers.d]
joint = "rail"
position = "t - 0.7"
[loads.push]
type = "force"
at = "rider.P"
force = ["{load}", 0]
"""
    k = np.array([4.0, 9.0])
    found = rt.loads(SPRING + more).many({"k": k}, ["rms(d.force)", "min(d.force)"], 2.0)
    assert not len(found.generic)
    square = 0.01 * np.sqrt(np.pi / 2) if "tanh" not in load else 2.0 - 2e-3
    np.testing.assert_allclose(found["rms(d.force)"], k * np.sqrt(square / 2.0), rtol=1e-4)
    np.testing.assert_allclose(found["min(d.force)"], -k, rtol=1e-4)


@pytest.mark.nojit
@pytest.mark.parametrize("example", ["squeezer", "fourbar"])
def test_steps_that_follow_the_motion_are_not_shortened(example):
    """The squeezer starts at a dead centre, where most of its bodies cannot move; the four-bar has a driver."""
    m = rt.example(example)
    name = next(iter(m.parameters))
    found = m.many(
        {name: [m.parameters[name]]}, ["max(abs(O.fx))" if example == "squeezer" else "max(O3.normal)"], 0.01
    )
    assert found.stats["steps"] < 200


@pytest.mark.nojit
def test_a_choice_by_parameters_is_that_of_the_sample():
    """The recorded model has one side of the choice; samples on the other side can be assembled, but not run by it."""
    m = rt.loads(SPRING.replace('stiffness = "k"', 'stiffness = "k*(1 if k > 10 else 4)"'))
    k = np.array([4.0, 9.0, 16.0])
    found = m.many({"k": k}, ["final(block.x)"], 0.4, rtol=1e-10)
    assert list(found.generic) == [0, 1]
    assert not len(found.failed)
    w = np.sqrt(np.where(k > 10.0, k, 4.0 * k))
    np.testing.assert_allclose(found["final(block.x)"], 0.5 * np.cos(0.4 * w), rtol=0.0, atol=1e-8)


@pytest.mark.nojit
def test_samples_that_cannot_be_run_say_why_and_leave_the_others_alone():
    m = rt.loads(SPRING)
    alone = m.many({"k": [10.0, 20.0]}, ["final(block.x)"], 0.5)
    found = m.many({"k": [10.0, np.nan, -1.0, 20.0, 50.0]}, ["final(block.x)"], 0.5)
    assert list(found.failed) == [1, 2, 4]
    assert "nan is not a finite number" in found.message(1)
    assert "is not between min" in found.message(2)
    assert "is not between min" in found.message(4)
    assert found.message(0) == ""
    np.testing.assert_array_equal(found["final(block.x)"][[0, 3]], alone["final(block.x)"])
    assert np.isnan(found["final(block.x)"][[1, 2, 4]]).all()


@pytest.mark.nojit
def test_an_instant_outside_of_the_run_costs_its_sample_alone():
    m, output = rt.loads(SPRING), "at(block.x, k/50)"
    found = m.set(k=30).many({"k": [10.0, 20.0]}, [output], 0.33)
    assert found[output][0] == pytest.approx(0.5 * np.cos(0.2 * np.sqrt(10)), abs=1e-7)
    assert found.message(1) == "at(block.x, k/50): the instant 0.4 s is not between 0 and t_end = 0.33 s"
    with pytest.raises(ValueError, match=r"at\(block.x, 1/2\): the instant 0.5 s is not between"):
        m.many({"k": [10.0]}, ["at(block.x, 1/2)"], 0.33)


@pytest.mark.nojit
@pytest.mark.parametrize("key", ["t_end", "step"])
def test_a_setting_that_would_differ_from_sample_to_sample_must_be_given(key):
    text = SPRING.replace("[parameters]", '[parameters]\nT = "0.2 s"\nT2 = "2*T"') + f'[simulate]\n{key} = "T2"\n'
    m = rt.loads(text)
    with pytest.raises(ValueError, match=f"{key} follows from T2 and would differ from sample to sample; give {key}"):
        m.many({"T": [0.2, 0.3]}, ["final(block.x)"], rtol=1e-10)
    found = m.many({"T": [0.2, 0.3]}, ["final(block.x)"], **{key: 0.4}, rtol=1e-10)
    end = 0.4 if key == "t_end" else m.model.settings.t_end
    np.testing.assert_allclose(found["final(block.x)"], 0.5 * np.cos(end * np.sqrt(15.0)), rtol=0.0, atol=1e-8)
    assert m.many({"k": [4.0]}, ["final(t)"], rtol=1e-10)["final(t)"] == [end]


@pytest.mark.nojit
def test_what_needs_whole_curves_or_the_ideal_mechanism_is_run_one_by_one():
    m, k = rt.loads(SPRING), np.array([4.0, 9.0])
    found = m.many({"k": k}, ["quantile(block.x, 0.5)", "final(block.x)"], 0.4)
    assert list(found.generic) == [0, 1]
    assert "quantile(...) needs a whole curve" in found.stats["how"]
    np.testing.assert_allclose(found["final(block.x)"], 0.5 * np.cos(0.4 * np.sqrt(k)), atol=1e-7)
    middle = 0.5 * np.cos(0.2 * np.sqrt(k))  # the curve falls all the time
    np.testing.assert_allclose(found["quantile(block.x, 0.5)"], middle, atol=1e-6)


@pytest.mark.nojit
def test_parameters_that_follow_from_varied_ones_differ_too():
    """In a curve, beside reductions, and as the instant that they make different from sample to sample."""
    m = rt.loads(SPRING.replace('m = "1 kg"', 'm = "1 kg"\nw2 = "k/m"\ntwice = "2*w2"\nlate = "0.01*twice"'))
    k = np.array([4.0, 9.0, 16.0])
    amount, w = 0.5, np.sqrt(k)
    outputs = {
        "final(block.x)*twice": 2.0 * k * amount * np.cos(0.4 * w),
        "max(block.x*w2)/k + m": np.full(3, amount + 1.0),
        "late - max(block.x)": 0.02 * k - amount,
    }
    found = m.many({"k": k}, list(outputs), 0.4, rtol=1e-10)
    assert not len(found.generic)
    for output, want in outputs.items():
        np.testing.assert_allclose(found[output], want, rtol=0.0, atol=1e-8, err_msg=output)
    late = m.many({"k": k}, ["at(block.x, late)"], 0.4, rtol=1e-10)
    assert list(late.generic) == [0, 1, 2]
    assert "the instant in 'at(block.x, late)' differs from sample to sample" in late.stats["how"]
    np.testing.assert_allclose(late["at(block.x, late)"], amount * np.cos(w * 0.02 * k), atol=1e-8)
    for n, one in enumerate(k):
        run = m.set(k=one).simulate(0.4, t_eval=[0.0, 0.4], rtol=1e-10)
        assert found["final(block.x)*twice"][n] == pytest.approx(run["block.x"][-1] * 2.0 * one, abs=1e-8)


@pytest.mark.nojit
def test_an_instant_may_follow_from_parameters_that_differ():
    m = rt.loads(SPRING.replace('m = "1 kg"', 'm = "1 kg"\nlate = "0.1*k"'))
    found = m.many({"k": [2.0, 9.0]}, ["at(block.x, late)", "final(block.x)"], 0.4, rtol=1e-10)
    assert list(found.failed) == [1]
    assert "the instant 0.9 s is not between 0 and t_end = 0.4 s" in found.message(1)
    assert found["at(block.x, late)"][0] == pytest.approx(0.5 * np.cos(0.2 * np.sqrt(2.0)), abs=1e-8)
    with pytest.raises(ValueError, match=r"1\.5 s is not between"):  # of all samples
        m.many({"x0": [0.2, 0.3]}, ["at(block.x, late)"], 0.4)


@pytest.mark.nojit
@pytest.mark.parametrize(("example", "name", "compiled"), [("crank_rocker_play", "dx", True), ("fourbar", "l2", False)])
def test_starts_that_are_found_one_by_one_use_machine_code_and_recorded_ones_need_none(
    example, name, compiled, monkeypatch
):
    asked: list[bool] = []
    monkeypatch.setattr(starts, "functions", SimpleNamespace(start=lambda: asked.append(True)))
    m = rt.example(example)
    m.many({name: m.parameters[name] * np.array([0.999, 1.001])}, ["final(energy.kinetic)"], 1e-3)
    assert bool(asked) == compiled


def test_an_output_without_a_value_leaves_the_others_alone():
    """Never is an answer; a division by zero is none."""
    outputs = ["first(block.x < 0.4)", "final(block.x)", "1/at(block.vx, 0)"]
    for more in ([], ["quantile(block.x, 0.5)"]):  # side by side and one by one
        found = rt.loads(SPRING).many({"k": [1.0, 9.0]}, [*outputs[:2], *more], 0.4, rtol=1e-10)
        assert len(found.generic) == 2 * len(more)
        assert not len(found.failed)
        np.testing.assert_allclose(found[outputs[0]], [np.nan, np.arccos(0.8) / 3.0], atol=1e-7)
        np.testing.assert_allclose(found[outputs[1]], 0.5 * np.cos([0.4, 1.2]), atol=1e-8)
    found = rt.loads(SPRING).many({"k": [1.0, 9.0]}, outputs, 0.4, rtol=1e-10)
    assert found.message(0) == "no finite value: 1/at(block.vx, 0)"
    assert np.isnan(found[outputs[2]]).all()
    np.testing.assert_allclose(found[outputs[1]], 0.5 * np.cos([0.4, 1.2]), atol=1e-8)


@pytest.mark.nojit
def test_why_a_sample_failed_stands_in_its_message_and_not_in_the_log(caplog):
    load = '[loads.late]\ntype = "force"\nat = "block.P"\nforce = ["k*sqrt(0.2 - t)", 0]\n'
    found = rt.loads(SPRING + load).many({"k": [4.0, 9.0]}, ["final(block.x)"], 0.4)
    assert list(found.failed) == [0, 1]
    assert "no finite value" in found.message(1)
    assert not caplog.records


def test_a_sample_all_of_whose_forces_are_left_out_is_a_row_with_its_message():
    """The coupler weighs nothing beside the others: its constraints look singular all the time."""
    m = rt.example("fourbar").ideal()
    m = m.set({f"bodies.{name}.mass": mass for name, mass in zip(m.model.bodies, (1.0, 1e-9, 1.0), strict=True)})
    for output in (
        "max(O3.fx)",
        "at(O3.fx, 0.005)",
        "first(O3.fx > 1)",
        "share(O3.fx > 1)",
        "mean(5 if O3.fx > 1 else 7)",
    ):
        found = m.many({"l2": [0.6]}, [output, "final(rocker.angle)"], 0.01)
        assert found.message(0) == f"{output}: O3.fx is left out all the time"
        assert np.isnan(found[output]).all()
        assert np.isfinite(found["final(rocker.angle)"]).all()


@pytest.mark.nojit
@pytest.mark.parametrize("output", ["quantile(block.x, 0.5)", "max(ideal.block.x)"])
def test_ctrl_c_stops_all_samples(output, monkeypatch):
    m = rt.loads(SPRING)
    runs = []

    def stopped(self, *given, **options):
        runs.append(self)
        result = type("Result", (), {"interrupted": True})()
        raise SolverError("stopped by the user", result)

    monkeypatch.setattr(rt.Mechanism, "simulate", stopped)
    name = next(iter(m.parameters))
    with pytest.raises(KeyboardInterrupt):
        m.many({name: [m.parameters[name]] * 3}, [output], 0.01)
    assert len(runs) == 1


@pytest.mark.nojit
def test_masked_samples_are_left_out():
    m = rt.loads(SPRING)
    found = m.many({"k": np.ma.masked_greater([4, 9, 50], 40)}, ["final(block.x)"], 0.4, rtol=1e-10)
    assert list(found.failed) == [2]
    assert "nan is not a finite number" in found.message(2)
    np.testing.assert_allclose(found["final(block.x)"][:2], 0.5 * np.cos(0.4 * np.array([2.0, 3.0])), atol=1e-8)


def test_events_that_only_single_runs_tell_are_asked_of_these():
    m = rt.example("bouncing_pin")
    found = m.many({"c": [1e-4, 2e-4]}, ["count(O.impacts)", "count(O.releases)"], 0.02)
    assert list(found.generic) == [0, 1]
    assert "'count(O.releases)' asks for events that only single runs tell" in found.stats["how"]
    together = m.many({"c": [1e-4, 2e-4]}, ["count(O.impacts)"], 0.02)
    assert not len(together.generic)
    np.testing.assert_array_equal(together["count(O.impacts)"], found["count(O.impacts)"])
    for n, c in enumerate((1e-4, 2e-4)):
        events = m.set(c=c).simulate(0.02, rtol=1e-8).events
        assert found["count(O.impacts)"][n] == sum(one.kind == "impact" for one in events)


@pytest.mark.nojit
def test_a_load_that_switches():
    m = rt.loads(SPRING.replace('stiffness = "k"', 'stiffness = "k*(1 if t < 0.2 else 2)"'))
    found = m.many({"k": [9.0]}, ["final(block.x)"], 0.4, rtol=1e-10)
    assert not len(found.generic)
    x, v, w = 0.5 * np.cos(0.6), -1.5 * np.sin(0.6), 3.0 * np.sqrt(2.0)
    assert found["final(block.x)"][0] == pytest.approx(x * np.cos(0.2 * w) + v / w * np.sin(0.2 * w), abs=1e-8)


@pytest.mark.nojit
def test_equal_steps():
    k = np.array([4.0, 9.0])
    found = rt.loads(SPRING).many({"k": k}, ["final(block.x)"], 0.4, method="rk4", step=1e-3)
    assert not len(found.generic)
    np.testing.assert_allclose(found["final(block.x)"], 0.5 * np.cos(0.4 * np.sqrt(k)), atol=1e-11)
    run = rt.loads(SPRING).set(k=4.0).simulate(0.4, t_eval=[0.0, 0.4], method="rk4", step=1e-3)
    assert found["final(block.x)"][0] == pytest.approx(run["block.x"][-1], abs=1e-14)


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("samples", "outputs", "options", "error", "message"),
    [
        ({"kk": [1.0]}, ["final(block.x)"], {}, KeyError, "no parameter 'kk'; did you mean 'k'"),
        ({}, ["final(block.x)"], {}, ValueError, "at least one parameter"),
        ({"k": [1.0, 2.0], "x0": [0.1]}, ["final(block.x)"], {}, ValueError, "arrays of one length"),
        ({"k": [[1.0]]}, ["final(block.x)"], {}, ValueError, "arrays of one length"),
        ({"k": []}, ["final(block.x)"], {}, ValueError, "at least 1"),
        ({"k": [1.0]}, "final(block.x)", {}, ValueError, "expected a list"),
        ({"k": [1.0]}, [], {}, ValueError, "expected a list"),
        ({"k": [1.0]}, [5], {}, ValueError, "expected a list"),
        ({"k": [1.0]}, ["2*k"], {}, ValueError, "follows from parameters alone"),
        ({"k": [1.0]}, ["final(blok.x)"], {}, ModelError, "did you mean 'block.x'"),
        ({"k": [1.0]}, ["block.x"], {}, ModelError, "one number"),
        ({"k": [1.0]}, ["at(block.x, 3)"], {}, ValueError, "not between 0 and t_end = 2 s"),
        ({"k": [1.0]}, ["final(block.x)"], {"method": "euler"}, ValueError, "unknown method 'euler'"),
        ({"k": [1.0]}, ["final(block.x)"], {"rtol": -1.0}, ValueError, "rtol"),
        ({"k": [1.0]}, ["final(block.x)"], {"threads": 0}, ValueError, "threads"),
    ],
)
def test_bad_input_is_refused_before_anything_runs(samples, outputs, options, error, message):
    with pytest.raises(error, match=message):
        rt.loads(SPRING).many(samples, outputs, 2.0, **options)


@pytest.mark.nojit
def test_points_and_joint_forces_are_known_as_in_a_result():
    m = rt.example("double_pendulum")
    outputs = ["final(lower.tip.x)", "at(O.force, 0.05)"]
    found = m.many({"start": [0.3, 0.6]}, outputs, 0.1, rtol=1e-10)
    assert not len(found.generic)
    for n, start in enumerate((0.3, 0.6)):
        run = m.set(start=start).simulate(0.1, t_eval=[0.0, 0.05, 0.1], rtol=1e-11)
        assert found[outputs[0]][n] == pytest.approx(run["lower.tip.x"][-1], abs=1e-9)
        assert found[outputs[1]][n] == pytest.approx(run["O.force"][1], rel=1e-8)


def test_mechanisms_with_contacts_give_the_same_bits_on_threads():
    m, c = rt.example("slider_crank_play"), np.linspace(4e-4, 5e-4, 6)
    one, two = (m.many({"c": c}, ["max(B.normal)", "count(B.contacts)"], 2e-3, threads=n) for n in (1, 2))
    assert not len(one.generic)
    np.testing.assert_array_equal(one.values, two.values)
    alone = m.set(c=float(c[4])).simulate(2e-3, t_eval=np.linspace(0.0, 2e-3, 2001), rtol=1e-8, atol=1e-9)
    assert one["max(B.normal)"][4] == pytest.approx(alone.peaks["B.normal"].value, rel=1e-6)


@pytest.mark.nojit
def test_samples_are_arrays_of_numbers_by_parameter():
    m = rt.loads(SPRING)
    for wrong in (3, ["k"], None):
        with pytest.raises(ValueError, match="at least one parameter"):
            m.many(wrong, ["final(block.x)"], 0.1)
    with pytest.raises(ValueError, match="'k': expected numbers in SI units"):
        m.many({"k": ["3 kg"]}, ["final(block.x)"], 0.1)


@pytest.mark.parametrize(
    ("name", "parameter", "outputs", "analysis", "t_end"),
    [
        (
            "path_generator",
            "r",
            ["at(coupler.P.y, 0.35)", "max(coupler.P.y)", "at(rocker.alpha, 0.3)"],
            "kinematics",
            1.0,
        ),
        ("quick_return", "r", ["max(abs(motor.torque))", "rms(motor.torque)"], "inverse-dynamics", None),
        ("scotch_yoke", "r", ["final(motor.torque)"], "inverse-dynamics", None),
    ],
)
def test_driven_mechanisms_side_by_side_have_the_positions_and_forces_of_their_own_analyses(
    name, parameter, outputs, analysis, t_end
):
    m = rt.example(name).ideal()
    values = m.parameters[parameter] * np.linspace(0.99, 1.01, 5)
    found = m.sweep({parameter: values}, outputs, analysis=analysis, t_end=t_end)
    assert "5 run side by side" in found.how
    end = found.task.t_end
    for n, value in enumerate(values):
        run = getattr(m.set({parameter: value}), analysis.replace("-", "_"))
        times = np.linspace(0.0, end, 2001)
        r = run(np.union1d(times, [0.35, 0.3]) if t_end else times)
        for output in outputs:
            want = evaluate(read(output, Known.of(r)), r)
            assert found[output][n] == pytest.approx(want, rel=1e-8, abs=1e-12)  # rms of 2001 instants: 2e-9


def test_driven_samples_that_reach_a_dead_centre_are_told_by_their_own_analysis():
    m = rt.example("fourbar").ideal()
    l2 = np.array([0.6, 0.52, 0.7, 0.79])
    found = m.sweep({"l2": l2}, ["max(rocker.angle)"], analysis="kinematics", t_end=0.7)
    for n, value in enumerate(l2):
        r = m.set(l2=value).kinematics(np.linspace(0.0, 0.7, 2001))
        assert (found.status[n] == "ok") == r.success
        if r.success:
            assert found["max(rocker.angle)"][n] == pytest.approx(r["rocker.angle"].max(), abs=1e-6)
        else:
            assert found.message(n) == r.message


@pytest.mark.parametrize("output", ["final(rocker.angle)", "quantile(rocker.angle, 0.5)"])
def test_a_sample_that_takes_too_many_steps_is_given_up_side_by_side_and_one_by_one(monkeypatch, output):
    monkeypatch.setattr(analyses, "MOST_STEPS", 120)  # ten turns of the crank take more, three fewer
    m = rt.example("fourbar").ideal()
    omega = [5.0, 30.0, 2.0]
    found = m.many({"omega": omega}, [output], t_end=2.0)
    assert found.failed.tolist() == [1]
    assert found.message(1).startswith("takes more than 120 steps")
    assert alike(found.message(1)).endswith("to see why")  # a summary of samples has room for all of it
    assert 1 not in found.generic or len(found.generic) == 3  # what was given up is not tried again
    assert np.isfinite(found[output][[0, 2]]).all()


def test_why_samples_failed_stands_in_their_messages_and_is_not_said_of_each(caplog):
    l2 = np.linspace(0.5, 0.55, 6)
    driven = rt.example("fourbar").ideal().set(l1="0.25 m", alpha="50 deg")
    found = driven.sweep({"l2": l2}, ["max(rocker.angle)"], analysis="kinematics", t_end=0.7)
    assert [found.message(n).partition(" = ")[0] for n in range(6)] == ["no position beyond t"] * 6
    assert not caplog.records


@pytest.mark.parametrize("analysis", ["kinematics", "simulate"])
def test_whole_curves_of_long_runs_have_enough_instants_in_every_turn(analysis):
    m = rt.example("fourbar").ideal()
    turn = 2.0 * np.pi / m.parameters["omega"]
    outputs = ["quantile(rocker.omega, 1)", "sd(rocker.omega)"]  # a quantile: they run one by one
    found = m.sweep({"omega": [m.parameters["omega"]]}, outputs, analysis=analysis, t_end=500.0 * turn)
    once = m.kinematics(np.linspace(0.0, turn, 2000, endpoint=False))["rocker.omega"]
    assert found[outputs[0]][0] == pytest.approx(once.max(), rel=1e-5)  # with 4 instants in a turn: 20 % off
    assert found[outputs[1]][0] == pytest.approx(once.std(), rel=1e-4)  # squares of cubics: 2e-5
