"""Sweeps over grids: values, shape, and combinations that cannot be run."""

import numpy as np
import pytest

import rattle as rt
from springs import SPRING


@pytest.mark.nojit
def test_a_grid_has_one_axis_per_parameter_and_the_closed_forms_values():
    k, x0, t = [14.0, 15.0, 16.0], [0.49, 0.51], 0.3
    found = rt.loads(SPRING).sweep({"k": k, "x0": x0}, ["final(block.x)"], t_end=t)
    want = np.cos(np.sqrt(k) * t)[:, None] * np.array(x0)
    np.testing.assert_allclose(found.grid("final(block.x)"), want, rtol=0.0, atol=1e-7)
    assert list(found.table.columns) == ["k", "x0", "final(block.x)", "status", "message"]
    assert found.sample(3).parameters == {"k": 15.0, "x0": 0.51}
    assert "k = 16 N/m, x0 = 0.49 m" in str(found)


@pytest.mark.nojit
def test_units_and_combinations_that_the_model_refuses():
    found = rt.loads(SPRING).sweep({"x0": ["490 mm", "0.51 m"], "k": [0.5, 15]}, ["final(block.x)"], t_end=0.3)
    np.testing.assert_array_equal(found["x0"], [0.49, 0.49, 0.51, 0.51])
    assert list(found.status) == ["failed", "ok", "failed", "ok"]
    assert "not between min = 1" in found.message(0)
    assert "2 x parameters.k.value" in str(found)


def test_other_analyses_than_motion():
    fourbar = rt.example("fourbar").ideal()
    of = ["max(rocker.angle)", "at(rocker.angle, 0.05)"]
    found = fourbar.sweep({"l2": [0.58, 0.62]}, of, analysis="kinematics", t_end=0.1)
    for n, l2 in enumerate((0.58, 0.62)):
        times = np.linspace(0.0, 0.1, 2001)
        angle = fourbar.set(l2=l2).kinematics(times)["rocker.angle"]
        assert found[of[0]][n] == pytest.approx(angle.max(), abs=1e-12)
        assert found[of[1]][n] == pytest.approx(angle[1000], abs=1e-12)
    loose = rt.example("path_generator")
    band = "at(coupler.P.y.high - coupler.P.y.low, 0.25)"
    found = loose.sweep({"c": [5e-5, 1e-4]}, [band], analysis="accuracy", t_end=0.5)
    for n, c in enumerate((5e-5, 1e-4)):
        one = loose.set(c=c).accuracy("coupler.P.y", [0.0, 0.25])
        assert found[band][n] == pytest.approx(one.high[1] - one.low[1], rel=1e-6)
    arm = rt.example("balanced_arm")
    found = arm.sweep({"arm_mass": [0.3, 0.5]}, ["final(mode1.frequency)"], analysis="modes")
    want = [arm.set(arm_mass=mass).modes().frequency[0] for mass in (0.3, 0.5)]
    np.testing.assert_allclose(found["final(mode1.frequency)"], want, rtol=1e-9)
    found = arm.sweep({"arm_mass": [0.3, 0.5]}, ["final(arm.angle)"], analysis="equilibrium")
    want = [arm.set(arm_mass=mass).equilibrium(0.0)[0]["arm.angle"] for mass in (0.3, 0.5)]
    np.testing.assert_allclose(found["final(arm.angle)"], want, rtol=0.0, atol=1e-9)


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({}, "expected parameters with their values"),
        ({"kk": [1]}, "no parameter 'kk'"),
        ({"k": []}, "'k' has no value"),
        ({"k": "15"}, "needs a list of values"),
        ({"k": ["15 mm"]}, "15 mm is a length; expected a stiffness"),
        ({"k": ["much"]}, "'much' is not a value"),
        ({"k": [float("nan")]}, "must be a finite number"),
    ],
)
def test_bad_grids_are_refused(values, message):
    with pytest.raises((ValueError, KeyError), match=message):
        rt.loads(SPRING).sweep(values, ["final(block.x)"], t_end=0.1)
