"""Starts that a page finds for other parameters are those of Python."""

import shutil
from importlib import resources

import numpy as np
import pytest

import rattle as rt
from core_starts import found_here, found_in_node, starts_apart
from rattle.pages.start_data import start_data
from rattle.pages.tape import Tape

pytestmark = pytest.mark.skipif(shutil.which("node") is None, reason="no node")

QUICK = (
    "fourbar", "crank_rocker_play", "slider_crank_play", "guide_play", "gear_rattle", "belt_drive", "fourbar_onesided",
    "door_hinge", "path_generator", "balanced_arm", "woodpecker",
)  # fmt: skip
MORE = ("crank_rocker_play", "slider_crank_play", "path_generator")  # of these other joints are like
UNLIKE = {  # by parameter, what a page does otherwise than Python, in words of `starts_apart`
    "bouncing_pin": {"mu": "another form"},  # no friction in the model: no law of friction in its arrays
    "rotor_whirl": {"L": "another form"},  # the table of the film has another size
}
EXAMPLES = sorted(
    one.name[:-5] for one in (resources.files("rattle") / "examples").iterdir() if one.name.endswith(".toml")
)
NOT_RECORDED = ("cam_lift_off",)  # the form of its cam is checked with numbers


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.long if name in MORE else ()) for name in QUICK])
def test_starts_follow_parameters(name, tmp_path):
    """Within 1e-10 sizes of the mechanism, and the model's own to the bit: Newton's method goes to rounding."""
    assert starts_apart(tmp_path, name) == {}


@pytest.mark.long
def test_starts_of_every_other_example_follow(tmp_path):
    unlike = {}
    for name in EXAMPLES:
        if name in (*QUICK, *NOT_RECORDED):
            continue
        known = UNLIKE.get(name, {})
        apart = {key: said for key, said in starts_apart(tmp_path, name).items() if known.get(key[0], "no") not in said}
        if apart:
            unlike[name] = apart
    assert unlike == {}


@pytest.mark.parametrize("name", ["three_plays", "jansen_leg", "slider_crank_play"])
def test_starts_far_from_that_of_the_model_are_those_of_python(name, tmp_path):
    """On whatever branch Python finds them, also where given values contradict the joints."""
    assert starts_apart(tmp_path, name, far=True) == {}


def test_a_mechanism_that_cannot_be_closed_is_told_and_the_next_one_found(tmp_path):
    m = rt.Mechanism("four-bar", gravity=[0, -9.81])
    m.parameter("b", "0.35 m")
    m.ground(O=[0, 0], C=[0.4, 0])
    for name, length in (("crank", "0.1 m"), ("coupler", "b"), ("rocker", "0.3 m")):
        m.bar(name, "A", "B", length=length, mass=1)
    m.revolute("O", "ground.O", "crank.A")
    m.revolute("P", "crank.B", "coupler.A")
    m.revolute("Q", "coupler.B", "rocker.B")
    m.revolute("C", "ground.C", "rocker.A")
    m.initial("crank", angle="60 deg")
    near, open_, own, other, again = found_in_node(tmp_path, m, [[0.36], [1.0], [0.35], [0.36], [1.0]])
    assert "stays open by" in open_["error"]
    assert open_["q"] is None
    assert (own["q"], own["error"]) == (m.start.q.tolist(), None)
    assert other == near
    assert again == open_


def test_speeds_begin_where_the_page_puts_the_mechanism_together(tmp_path):
    m = rt.Mechanism("four-bar", gravity=[0, -9.81])
    m.parameter("a", "0.4 m").parameter("w", 3.0)
    m.ground(O=[0, 0], C=["a + 0.1*sin(w*t)", 0])
    for name, length in (("crank", "0.1 m"), ("coupler", "0.35 m"), ("rocker", "0.3 m")):
        m.bar(name, "A", "B", length=length, mass=1)
    m.revolute("O", "ground.O", "crank.A")
    m.revolute("P", "crank.B", "coupler.A")
    m.revolute("Q", "coupler.B", "rocker.B")
    m.revolute("C", "ground.C", "rocker.A")
    m.driver("motor", "C", speed="w*cos(t)")
    m.initial("crank", angle="60 deg")
    for (a, w), start in zip(
        [(0.4, 3.0), (0.42, 4.0)], found_in_node(tmp_path, m, [[0.4, 3.0], [0.42, 4.0]]), strict=True
    ):
        own = m.set(a=a, w=w).start
        assert start["error"] is None
        np.testing.assert_allclose(start["q"], own.q, atol=1e-12)
        np.testing.assert_allclose(start["v"], own.v, atol=1e-10)
        np.testing.assert_allclose(start["constants"], [own.q[8]], atol=1e-12)  # the angle of the rocker


def test_a_driver_without_a_value_is_told_and_the_next_start_found(tmp_path):
    """As on the desk, before a search in loops without values."""
    m = rt.Mechanism("slider-crank")
    m.parameter("p", 2)
    m.ground(O=[0, 0])
    m.bar("crank", "O", "A", length="50 mm", mass="0.3 kg")
    m.bar("rod", "A", "B", length="120 mm", mass="0.2 kg")
    m.body("slider", mass="0.1 kg", inertia="1e-4 kg*m^2", points={"B": [0, 0]})
    m.revolute("O", "ground.O", "crank.O")
    m.revolute("A", "crank.A", "rod.A")
    m.revolute("B", "slider.B", "rod.B")
    m.prismatic("guide", "ground.O", "slider.B", axis=0)
    m.driver("motor", "guide", position="0.1*sqrt(p - 1 + t)")
    without, own = found_in_node(tmp_path, m, [[0.5], [2.0]])
    assert "no value" in without["error"]
    assert (own["q"], own["error"]) == (m.start.q.tolist(), None)


def test_a_parameter_that_does_not_reach_the_start_leaves_every_bit(tmp_path):
    m = rt.example("bouncing_pin")
    names = start_data(m, Tape()).description["parameters"]
    other = [0.9 * m.model.parameters[name].value if name == "e" else m.model.parameters[name].value for name in names]
    (start,) = found_in_node(tmp_path, m, [other])
    assert (start["q"], start["v"]) == (m.start.q.tolist(), m.start.v.tolist())


def test_given_rates_follow_parameters(tmp_path):
    m = rt.Mechanism("thrown pin", gravity=[0, -9.81])
    m.parameter("v0", "2 m/s")
    m.ground(O=[0, 0])
    m.body("pin", mass=1, inertia=0.1, points={"P": [0, 0]})
    m.revolute("O", "ground.O", "pin.P", clearance="10 mm", contact={"model": "impact", "restitution": 0.5})
    m.initial("pin", x=0.001, y=0, angle=0, vx="v0", vy=0, omega=0)
    own, other = found_in_node(tmp_path, m, [[2.0], [3.0]])
    assert own["v"] == m.start.v.tolist()
    assert other["v"] == m.set(v0=3.0).start.v.tolist()


@pytest.mark.parametrize("name", ["slider_crank_play", "gear_rattle", "belt_drive", "path_generator"])
def test_kernels_in_plain_python_find_the_start_of_a_page(name, tmp_path):
    m = rt.example(name) if isinstance(name, str) else name
    p = [1.002 * m.model.parameters[x].value for x in start_data(m, Tape()).description["parameters"]]
    start, here = *found_in_node(tmp_path, m, [p]), found_here(m, p)
    assert here.start_q == pytest.approx(start["q"], rel=1e-12, abs=1e-13)
    assert here.start_v == pytest.approx(start["v"], rel=1e-10, abs=1e-11)
