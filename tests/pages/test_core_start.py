"""Starts that a page finds for other parameters are those of Python."""

import shutil
from importlib import resources

import pytest

import rattle as rt
from core_starts import found_in_node, starts_apart

pytestmark = pytest.mark.skipif(shutil.which("node") is None, reason="no node")

QUICK = (
    "fourbar", "crank_rocker_play", "slider_crank_play", "guide_play", "gear_rattle", "belt_drive", "fourbar_onesided",
    "door_hinge", "path_generator", "balanced_arm", "woodpecker",
)  # fmt: skip
UNLIKE = {  # by parameter, what a page does otherwise than Python, in words of `starts_apart`
    "bouncing_pin": {"mu": "another form"},  # no friction in the model: no law of friction in its arrays
    "ellipse": {"tilt": "6.3", "start": "6.3"},  # a page goes on in the same turn, `set` takes the one next to zero
    "jansen_leg": {"d": "stays open", "c": "stays open"},  # Python searches from elsewhere
    "rotor_whirl": {"L": "another form"},  # the table of the film has another size
}
EXAMPLES = sorted(
    one.name[:-5] for one in (resources.files("rattle") / "examples").iterdir() if one.name.endswith(".toml")
)
NOT_RECORDED = ("cam_lift_off",)  # the form of its cam is checked with numbers


@pytest.mark.parametrize("name", QUICK)
def test_starts_follow_parameters(name, tmp_path):
    """Within 1e-10 sizes of the mechanism, and the model's own to the bit: Newton's method goes to rounding."""
    assert starts_apart(tmp_path, name) == {}


@pytest.mark.long
@pytest.mark.parametrize("name", [one for one in EXAMPLES if one not in (*QUICK, *NOT_RECORDED)])
def test_starts_of_every_example_follow(name, tmp_path):
    unlike = starts_apart(tmp_path, name)
    known = UNLIKE.get(name, {})
    assert {key: said for key, said in unlike.items() if known.get(key[0], "nothing") not in said} == {}


def test_a_mechanism_that_cannot_be_closed_is_told_and_the_next_one_found(tmp_path):
    m = rt.example("fourbar")
    names = list(m.model.parameters)
    own = [one.value for one in m.model.parameters.values()]
    long = [10.0 * x if name == "l2" else x for name, x in zip(names, own, strict=True)]
    near = [1.01 * x if name == "l2" else x for name, x in zip(names, own, strict=True)]
    first, open_, own_again, other, *rest = found_in_node(tmp_path, m, [near, long, own, near, long])
    assert "cannot be assembled" in open_["error"]
    assert open_["q"] is None
    assert (own_again["q"], own_again["error"]) == (m.start.q.tolist(), None)
    assert other == first
    assert rest == [open_]


def test_a_parameter_that_does_not_reach_the_start_leaves_every_bit(tmp_path):
    m = rt.example("fourbar_onesided")
    for changed in ("mu", "e"):
        if changed not in m.model.parameters:
            continue
        other = [0.9 * one.value if name == changed else one.value for name, one in m.model.parameters.items()]
        (start,) = found_in_node(tmp_path, m, [other])
        assert (start["q"], start["v"]) == (m.start.q.tolist(), m.start.v.tolist())


def test_given_rates_follow_parameters(tmp_path):
    m = rt.Mechanism("thrown pin", gravity=[0, -9.81])
    m.parameter("v0", "2 m/s")
    m.ground(O=[0, 0])
    m.body("pin", mass=1, inertia=0.1, points={"P": [0, 0]})
    m.revolute("O", "ground.O", "pin.P", clearance="10 mm", contact="impact", e=0.5)
    m.initial("pin", x=0.001, y=0, angle=0, vx="v0", vy=0, omega=0)
    own, other = found_in_node(tmp_path, m, [[2.0], [3.0]])
    assert own["v"] == m.start.v.tolist()
    assert other["v"] == m.set(v0=3.0).start.v.tolist()
