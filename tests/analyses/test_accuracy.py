"""Bands of an output under play: against sampling of the circles, closed forms, virtual work; their pictures."""

import json
import math
import tomllib

import numpy as np
import pytest
from scipy.optimize import minimize

import rattle as rt
from linkages import paper, slider_crank

nojit = pytest.mark.nojit
TIMES = [0.0, 0.11, 0.4]


def sample(m: rt.Mechanism, output: str, t: float, shifts: np.ndarray) -> np.ndarray:
    """Output of the mechanism without play with bush points moved: O3 on the coupler, O4 on the rocker."""
    values = []
    for (x3, y3), (x4, y4) in shifts:
        document = tomllib.loads(m.ideal().to_toml())
        bar = {"mass": 2, "inertia": 0.06}
        document["bodies"]["coupler"] = {"points": {"O2": [-0.3, 0.0], "O3": [0.3 + x3, y3]}, **bar}
        document["bodies"]["rocker"] = {"points": {"O3": [-0.3, 0.0], "O4": [0.3 + x4, y4]}, **bar}
        values.append(rt.loads(json.dumps(document)).inverse_dynamics(t)[output][0])
    return np.array(values)


@pytest.mark.parametrize(
    "output", ["rocker.angle", pytest.param("rocker.omega", marks=pytest.mark.long), "motor.torque"]
)
def test_every_sampled_position_lies_inside_and_the_extremes_are_reached(output):
    m = rt.loads(paper())
    found = m.accuracy(output, [0.11], loaded=False)
    random = np.random.default_rng(1)
    angles = random.uniform(0, 2 * np.pi, (48, 2))
    radii = 0.005 * np.sqrt(random.uniform(0, 1, (48, 2)))
    radii[16:] = 0.005  # most on the circles, where the extremes are
    shifts = np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=2)
    values = sample(m, output, 0.11, shifts)
    slack = 1e-9 * (1 + abs(found.nominal[0]))
    assert (values <= found.high[0] + slack).all()
    assert (values >= found.low[0] - slack).all()
    # from the best sample an optimiser that knows nothing of slopes climbs to the extreme
    for sign, best, extreme in ((1, np.argmax(values), found.high[0]), (-1, np.argmin(values), found.low[0])):

        def height(x, sign=sign):
            shift = 0.005 * np.array([[[math.cos(x[0]), math.sin(x[0])], [math.cos(x[1]), math.sin(x[1])]]])
            return -sign * sample(m, output, 0.11, shift)[0]

        climbed = minimize(height, angles[best], method="Nelder-Mead", options={"maxfev": 60})
        assert abs(-sign * climbed.fun - extreme) < 0.01 * (found.high[0] - found.low[0])


@nojit
def test_the_bound_of_first_order_becomes_exact_as_the_play_vanishes():
    errors = []
    for r in (4e-3, 2e-3, 1e-3):
        found = rt.loads(paper(r=r)).accuracy("rocker.angle", TIMES, loaded=False)
        errors.append(np.abs((found.high - found.low) / 2 - found.worst).max() / r)
        assert (found.low < found.nominal).all()
        assert (found.nominal < found.high).all()
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.05)  # half widths differ by third order
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.05)


@nojit
def test_slope_of_a_slider_crank_is_its_closed_form():
    m = rt.loads(
        slider_crank().replace(
            'connect = ["slider.B", "rod.B"]', 'connect = ["slider.B", "rod.B"]\nclearance = "0.2 mm"'
        )
    )
    found = m.accuracy("slider.x", np.linspace(0, 0.8, 9), loaded=False)
    beta = np.arcsin(0.1 / 0.3 * np.sin(7 * found.t))
    # a pin displaced by e along the rod moves the slider by e/cos(beta): the slider only goes along x
    np.testing.assert_allclose(found.worst, 2e-4 / np.cos(beta), rtol=1e-9)
    np.testing.assert_allclose(found.nominal, 0.1 * np.cos(7 * found.t) + 0.3 * np.cos(beta), atol=1e-12)
    assert found.unit == "m"


@nojit
def test_one_solve_and_differences_give_the_same_slopes():
    text = paper().replace(
        "[loads.M]", '[signals]\ntip = "rocker.angle + 0"\nspin = "rocker.angle + 0*rocker.omega"\n[loads.M]'
    )
    m = rt.loads(text)
    one, two, three = (
        m.accuracy(name, TIMES, extremes=False, loaded=False) for name in ("rocker.angle", "tip", "spin")
    )
    np.testing.assert_allclose(one.contributions, two.contributions, rtol=1e-8)
    np.testing.assert_allclose(one.contributions, three.contributions, rtol=1e-6)


@nojit
def test_under_load_the_deviation_is_that_of_the_equilibrium_and_of_the_rule_of_virtual_work():
    m = rt.loads(paper(-40.0))
    found = m.accuracy("rocker.angle", TIMES)
    for k, t in enumerate(TIMES):
        apart = m.equilibrium(t)[0]["rocker.angle"] - m.ideal().equilibrium(t)[0]["rocker.angle"]
        assert found.loaded[k] == pytest.approx(apart, abs=1e-10)
        forces = m.ideal().equilibrium(t)[0]
        rule = 0.005 * (forces["O3.force"] + forces["O4.force"]) / 40
        assert found.rule[k] == pytest.approx(rule, rel=1e-9)
        assert abs(found.pressed[k]) == pytest.approx(rule, rel=1e-9)  # the only load, conjugate to the output
        assert abs(apart) == pytest.approx(rule, rel=0.01)


@nojit
def test_what_a_designer_reads():
    m = rt.example("path_generator")
    found = m.accuracy("coupler.P.y", np.linspace(0, 1, 13))
    text = str(found)
    assert found.tighten == "Q"
    assert sum(found.share.values()) == pytest.approx(1)
    assert "tighten Q first" in text
    assert "worst case" in text
    assert "root sum square" in text
    tighter = m.set(c_q="0.075 mm").accuracy("coupler.P.y", found.t, extremes=False)
    k = int(np.argmax(found.worst))
    assert tighter.worst[k] == pytest.approx(
        found.worst[k] - 0.5 * found.contributions[k, found.joints.index("Q")], rel=1e-9
    )
    assert (found.rss <= found.worst + 1e-15).all()
    figure = found.plot()
    assert [ax.get_ylabel() for ax in figure.axes] == ["length [m]", "deviation [mm]", ""]
    assert "[mm]" in figure.axes[2].get_xlabel()
    assert figure.axes[1].get_xlabel() == "time [s]"


@nojit
def test_a_loose_guide_shifts_and_turns_its_block():
    guide = """connect = ["ground.O", "slider.B"]
clearance = "0.1 mm"
block = { length = "40 mm", height = "20 mm" }
contact = "ideal"
"""
    m = rt.loads(slider_crank().replace('connect = ["ground.O", "slider.B"]', guide))
    turn = m.accuracy("slider.angle", [0.1], loaded=False)
    assert turn.worst[0] == pytest.approx(1e-4 / 0.02, rel=1e-9)
    shift = m.accuracy("slider.y", [0.1], loaded=False)
    assert shift.worst[0] == pytest.approx(1e-4, rel=1e-9)


@nojit
def test_play_says_what_it_needs():
    with pytest.raises(rt.ModelError, match="no joint has a clearance"):
        rt.loads(slider_crank()).accuracy("slider.x", [0.0])
    with pytest.raises(KeyError, match=r"coupler\.O3\.x"):
        rt.loads(paper()).accuracy("coupler.O3.z", [0.0])
    free = paper().replace('[drivers.motor]\njoint = "O1"\nangle = "10*t"', "")
    with pytest.raises(rt.ModelError, match="1 degree of freedom is left"):
        rt.loads(free).accuracy("rocker.angle", [0.0])
