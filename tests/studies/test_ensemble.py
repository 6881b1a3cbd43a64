"""Ensembles: samples against closed forms, what they depend on, what follows from them, and what cannot be run."""

import math

import numpy as np
import pytest

import rattle as rt
from rattle.errors import ModelError
from rattle.questions.ensemble import statistics
from rattle.studies.runs.task import task_of
from springs import SPRING

T = math.pi / 10
OF = "final(block.x)"
SPRING = SPRING.replace("min = 1, max = 40", "min = 5, max = 20")


def spring():
    return rt.loads(SPRING)


@pytest.mark.nojit
@pytest.mark.parametrize("design", ["sobol", "halton", "lhs", "random"])
def test_samples_and_their_mean_have_the_closed_forms_values(design):
    e = spring().ensemble(1024, [OF], t_end=T, seed=1, design=design)
    k, x0 = e["k"], e["x0"]
    assert 14.0 <= k.min() < 14.02
    assert 15.98 < k.max() <= 16.0
    np.testing.assert_allclose(e[OF], x0 * np.cos(np.sqrt(k) * T), rtol=0.0, atol=1e-9)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    mean = 0.5 * np.sum(weights / 2 * np.cos(np.sqrt(15 + nodes) * T))
    found = e.summary().loc[OF]
    assert found["mean"] == pytest.approx(mean, abs=5e-4 if design == "random" else 3e-5)
    assert found["mean_low"] <= mean <= found["mean_high"]
    assert found["nominal"] == pytest.approx(0.5 * math.cos(math.sqrt(15) * T), abs=1e-9)
    assert (found["n_ok"], found["n_failed"], found["n_not_finite"]) == (1024, 0, 0)


@pytest.mark.nojit
def test_a_sample_depends_on_the_seed_and_its_number_alone():
    few, more = (spring().ensemble(n, [OF], t_end=T, seed=5, threads=n // 50) for n in (50, 100))
    np.testing.assert_array_equal(more[OF][:50], few[OF])
    assert not np.array_equal(spring().ensemble(50, [OF], t_end=T, seed=6)[OF], few[OF])
    one = more.sample(17)
    assert one.parameters == {"k": more["k"][17], "x0": more["x0"][17]}
    assert one.simulate(T, t_eval=[0, T], rtol=1e-10)["block.x"][-1] == pytest.approx(more[OF][17], abs=1e-9)
    for wrong in (100, -1, 1.5, True):
        with pytest.raises(IndexError, match="from 0 to 99"):
            more.sample(wrong)


@pytest.mark.nojit
def test_the_share_within_limits():
    e = spring().ensemble(2048, [OF], t_end=T, seed=1)
    k, x = np.meshgrid(np.linspace(14, 16, 801), np.linspace(0.49, 0.51, 801))
    fine = x * np.cos(np.sqrt(k) * T)
    below, above, between = e.yield_below(OF, 0.17), e.yield_above(OF, "0.17 m"), e.yield_between(OF, 0.165, 0.175)
    assert below.value == pytest.approx((fine < 0.17).mean(), abs=3e-3)
    assert below.low < (fine < 0.17).mean() < below.high
    assert above.value == pytest.approx(1.0 - below.value)
    assert between.value == pytest.approx(((fine > 0.165) & (fine < 0.175)).mean(), abs=3e-3)
    with pytest.raises(ValueError, match="is a force; expected a length"):
        e.yield_below(OF, "3 N")


@pytest.mark.nojit
def test_samples_that_cannot_be_closed_are_rows_that_say_so():
    text = rt.example("fourbar").to_toml()
    wide = rt.loads(text).ideal().set({"parameters.l2": {"value": 0.6, "tol": 0.55}})
    e = wide.ensemble(100, ["at(rocker.angle, 0)"], ["l2"], analysis="kinematics", t_end=1e-3, seed=2)
    l2, p = e["l2"], wide.parameters
    apart = p["l1"] + (l2 + p["l3"]) * math.cos(p["alpha"]) + 2 * p["r3"] - p["l1"]  # from pin 2 to pin 4 at t = 0
    possible = (np.abs(l2 - p["l3"]) < apart) & (apart < l2 + p["l3"])
    np.testing.assert_array_equal(e.status == "ok", possible)
    assert 5 < (~possible).sum() < 95
    assert all(len(text) > 10 for text in e.table["message"][~possible])
    assert f"of 100 samples {(~possible).sum()} could not be run" in str(e)
    share = e.yield_below("at(rocker.angle, 0)", 10.0)
    assert share.value == pytest.approx(possible.mean())
    assert share.high == 1.0


@pytest.mark.nojit
def test_what_is_never_reached_is_no_failure():
    e = spring().ensemble(64, [f"first(block.x < {0.5 * math.cos(0.3 * math.sqrt(15))})"], t_end=0.3, seed=1)
    never = np.isnan(e[e.outputs[0]])
    assert 0 < never.sum() < 64
    assert (e.status == "ok").all()
    assert f"is reached in all but {never.sum()} samples" in str(e)
    assert e.yield_below(e.outputs[0], 0.3).value == pytest.approx((~never).mean())
    # never within the run is later than its end: all that are early enough are, whatever comes later
    early = e[e.outputs[0]] < 0.299
    assert e.yield_above(e.outputs[0], 0.299) == statistics.share(int((~early).sum()), 64)
    later = e.yield_below(e.outputs[0], 0.5)  # of those it is not known
    assert later == statistics.share(int((~never).sum()), int((~never).sum()), int(never.sum()))


@pytest.mark.nojit
def test_what_is_computed_from_an_instant_that_never_comes_is_not_known():
    e = spring().ensemble(64, [f"-first(block.x < {0.5 * math.cos(0.3 * math.sqrt(15))})"], t_end=0.3, seed=1)
    never = int(np.isnan(e[e.outputs[0]]).sum())
    assert e.yield_below(e.outputs[0], 0.0) == statistics.share(64 - never, 64 - never, never)


@pytest.mark.nojit
def test_one_sample_has_a_mean_without_bounds():
    lines = str(spring().ensemble(1, [OF], t_end=T)).splitlines()
    assert lines[0].startswith("1 sample of")
    assert "nan" not in lines[2]
    assert " -  " in lines[2]  # no standard deviation


@pytest.mark.nojit
def test_values_that_are_not_finite_are_counted_apart():
    e = spring().ensemble(16, [OF, "1/(max(block.x) - max(block.x))"], t_end=T)
    assert set(e.status) == {"not finite"}
    assert np.isfinite(e[OF]).all()
    assert e.summary()["n_not_finite"].tolist() == [0, 16]
    assert "no finite value: 1/(max" in e.message(3)


def test_mechanisms_with_contacts():
    loose = rt.example("slider_crank_play")
    of = ["max(B.normal)", "count(B.contacts)"]
    e, again = (loose.ensemble(8, of, {"speed": "100 rpm"}, t_end=2e-3, seed=3, threads=n) for n in (1, 2))
    np.testing.assert_array_equal(e[of[0]], again[of[0]])
    assert (e[of[0]] > 1e4).all()
    assert (e[of[1]] >= 1).all()
    assert "8 run side by side" in str(e)
    assert "without deviations" in str(e)  # of a single run: contacts, and how finely they were followed
    for n in (0, 7):  # whatever the instants of its outputs
        alone = e.sample(n).simulate(2e-3, rtol=1e-8)
        assert e[of[0]][n] == pytest.approx(alone.peak("B.normal")[0], rel=1e-5)
        assert e[of[1]][n] == alone.contacts["B"].contacts


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("output", "instants"),
    [
        ("max(abs(motor.torque)) / rms(A.force)", 2),
        ("final(rocker.angle)", 2),
        ("at(rocker.angle, 5e-6)", 3),
        ("max(motor.torque)", 2001),  # the steps watch its magnitude
        ("max(A.force) - min(A.force)", 2001),
        ("max(2*A.force)", 2001),
    ],
)
def test_a_run_is_looked_at_between_its_ends_only_where_the_steps_do_not_tell_all(output, instants):
    m = rt.example("crank_rocker_play").ideal()
    task = task_of(m, list(m.parameters)[:1], [output], t_end=1e-5)
    assert len(task.look(m)[1].t) == instants


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"n": 0}, "n must be from 1"),
        ({"n": 2.5}, "n must be an integer"),
        ({"outputs": OF}, "expected a list"),
        ({"outputs": ["final(block.z)"]}, "no curve or parameter 'block.z'"),
        ({"outputs": ["biggest(block.x)"]}, "biggest"),
        ({"outputs": ["2*k"]}, "follows from parameters alone"),
        ({"vary": ["x1"]}, "no parameter 'x1'"),
        ({"vary": {"k": 9}}, "beyond max = 20"),
        ({"design": "grid"}, "unknown design 'grid'"),
        ({"analysis": "dynamics"}, "unknown analysis 'dynamics'"),
        ({"seed": -1}, "seed"),
        ({"threads": 0}, "threads must be from 1"),
        ({"method": "euler"}, "unknown method 'euler'"),
    ],
)
def test_bad_questions_are_refused_before_anything_runs(options, message):
    given = {"n": 4, "outputs": [OF], "t_end": T} | options
    with pytest.raises((ModelError, ValueError, KeyError, TypeError), match=message):
        spring().ensemble(given.pop("n"), given.pop("outputs"), given.pop("vary", None), **given)


@pytest.mark.nojit
def test_a_limit_on_one_side_holds_too():
    m = rt.loads(SPRING.replace("min = 5, max = 20", "min = 5"))
    with pytest.raises(ModelError, match=r"k\.value: 4 is below min = 5"):
        m.set(k=4)
    assert list(m.sweep({"k": [4, 6]}, [OF], t_end=T).status) == ["failed", "ok"]


@pytest.mark.nojit
def test_a_parameter_called_as_a_column_of_the_table_has_one_of_its_own(tmp_path):
    m = rt.loads(SPRING.replace("\nk = ", "\nstatus = ").replace('"k"', '"status"').replace("min = 5, ", "min = 1, "))
    e = m.sweep({"status": [4, 6]}, [OF], t_end=T)
    assert list(e.table["parameter status"]) == [4, 6]
    assert list(e.table["status"]) == ["ok", "ok"]
    e.to_csv(tmp_path / "e.csv")
    assert (tmp_path / "e.csv").read_text().startswith("sample,parameter status [N/m],")


@pytest.mark.nojit
def test_a_table_of_samples_is_a_file(tmp_path):
    e = spring().ensemble(8, [OF], t_end=T)
    e.to_csv(tmp_path / "e.csv")
    head, *rows = (tmp_path / "e.csv").read_text().splitlines()
    assert head == "sample,k [N/m],x0 [m],final(block.x) [m],status,message"
    assert [float(one) for one in rows[5].split(",")[:4]] == [5.0, e["k"][5], e["x0"][5], e[OF][5]]
    assert e.record()["outputs"][OF]["mean"] == pytest.approx(e[OF].mean())
    with pytest.raises(ValueError, match=r"\.csv"):
        e.to_csv(tmp_path / "e.xlsx")


@pytest.mark.nojit
def test_that_no_bush_has_to_pull_is_no_remark_about_an_ensemble():
    m = rt.example("crank_rocker_play")
    assert m.simulate(2e-3).trust.pulled == {"A": 0.0, "B": 0.0}
    assert m.ensemble(2, ["max(A.normal)"], {"c": "0.01 mm"}, t_end=2e-3).notes == ()
