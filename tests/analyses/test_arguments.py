"""What is asked for wrongly is refused at once, in words that name the argument and say what would be right."""
# ruff: noqa: E501  a case is a line

import math

import numpy as np
import pytest

import rattle as rt

pytestmark = pytest.mark.nojit
HUGE = 10**400


def pendulum():
    return rt.example("double_pendulum")


REFUSED = {
    "no points": (lambda: pendulum().poincare("upper.angle", period=1.0, points=0), ValueError, "points must be from 1"),
    "points below zero": (lambda: pendulum().poincare("upper.angle", period=1.0, points=-5), ValueError, "points must be"),
    "skip below zero": (lambda: pendulum().poincare("upper.angle", period=1.0, skip=-1), ValueError, "skip must be from 0"),
    "half a point": (lambda: pendulum().poincare("upper.angle", period=1.0, points=2.5), TypeError, "points must be an integer"),
    "no values": (lambda: pendulum().bifurcation("upper_length", [], "upper.angle"), ValueError, "at least one"),
    "a run of no time": (lambda: pendulum().lyapunov(0), ValueError, "t_end must be positive and finite"),
    "stretch without end": (lambda: pendulum().lyapunov(1.0, stretch=math.inf), ValueError, "stretch must be positive"),
    "stretch beyond the run": (lambda: pendulum().lyapunov(1.0, stretch=2.0), ValueError, "too long for"),
    "rtol zero": (lambda: pendulum().simulate(0.1, rtol=0), ValueError, "rtol must be positive and finite, got 0"),
    "rtol beyond rounding": (lambda: pendulum().simulate(0.1, rtol=1e-20), ValueError, "below the digits that numbers have"),
    "rtol of one": (lambda: pendulum().simulate(0.1, rtol=1.0), ValueError, "leaves no correct digit"),
    "rtol a text": (lambda: pendulum().simulate(0.1, rtol="fine"), TypeError, "rtol must be a number, got 'fine'"),
    "rtol huge": (lambda: pendulum().simulate(0.1, rtol=HUGE), ValueError, "rtol must be positive and finite"),
    "rtol of a section": (lambda: pendulum().poincare("upper.angle", period=1.0, rtol=1e-30), ValueError, "digits"),
    "rtol of an exponent": (lambda: pendulum().lyapunov(1.0, rtol=0), ValueError, "rtol must be positive"),
    "atol zero": (lambda: pendulum().simulate(0.1, atol=0), ValueError, "atol must be positive and finite, got 0"),
    "step zero": (lambda: pendulum().simulate(0.1, step=0), ValueError, "step must be positive and finite, got 0"),
    "method nothing": (lambda: pendulum().simulate(0.1, method=""), ValueError, "unknown method ''"),
    "t_end huge": (lambda: pendulum().simulate(HUGE), ValueError, "too large"),
    "t_end nan": (lambda: pendulum().simulate(math.nan), ValueError, "t_end must be positive and finite"),
    "times of texts": (lambda: pendulum().simulate(t_eval=["a", "b"]), ValueError, "t_eval"),
    "times a table": (lambda: pendulum().simulate(t_eval={"a": 1}), TypeError, "t_eval"),
    "too many outputs": (lambda: pendulum().set({"simulate.output": 1e-9}).simulate(1.0), ValueError, "too many"),
    "outputs beyond memory": (lambda: pendulum().set({"simulate.output": "0.2 us"}).simulate(1.5), ValueError, "GB"),
    "rest at no time": (lambda: pendulum().equilibrium(math.nan), ValueError, "t must be a finite number"),
    "modes at no time": (lambda: pendulum().modes(math.inf), ValueError, "t must be a finite number"),
    "no such joint": (lambda: rt.example("fourbar").contact_of("O33"), rt.ModelError, "did you mean 'O3'"),
    "no play there": (lambda: rt.example("fourbar").contact_of("O1"), rt.ModelError, "has no clearance"),
    "no such law": (lambda: rt.example("fourbar").compare(law="exakt"), ValueError, "no compliant law 'exakt'; did you mean"),
    "no file name": (lambda: rt.load(5), TypeError, "expected the name of a model file, got 5"),
    "no text": (lambda: rt.loads(5), TypeError, "expected the text of a model, got 5"),
    "no example": (lambda: rt.example(5), ValueError, "no example '5'"),
    "no name to set": (lambda: pendulum().set({5: 1}), TypeError, "expected the name of a parameter"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_refused_in_words(case):
    ask, kind, said = REFUSED[case]
    with pytest.raises(kind) as caught:
        ask()
    assert said in str(caught.value)


def test_numbers_of_numpy_are_numbers():
    r = pendulum().simulate(np.float64(1e-3), rtol=np.float64(1e-6), atol=np.float32(1e-8), step=np.int64(1))
    assert r.success


def test_no_frame_in_a_second_is_no_film(tmp_path):
    from circling import circling

    with pytest.raises(ValueError, match="positive number of frames per second, got 0"):
        circling(5).animate(tmp_path / "a.gif", fps=0)


# ---------------------------------------------------------------- models whose values are of the wrong kind
CONTACT = """format = 1
[ground.points]
O = [0, 0]
[bodies.a]
mass = 1
inertia = 1
points = { O = [0, 0] }
[joints.O]
type = "revolute"
connect = ["ground.O", "a.O"]
clearance = "1 mm"
"""


@pytest.mark.parametrize("given", ["1", "true", "1979-05-27", "nan", "[]", "{}"])
@pytest.mark.parametrize("key", ["bush_material", "pin_material"])
def test_a_material_that_is_none_is_named_with_its_place(key, given):
    other = {"bush_material": "pin_material", "pin_material": "bush_material"}[key]
    text = f'contact = {{ model = "exact", restitution = 0.5, bush_radius = "1 cm", {key} = {given}, {other} = "steel" }}\n'
    with pytest.raises(rt.ModelError) as caught:
        rt.loads(CONTACT + text)
    assert all(one.line == 12 for one in caught.value.problems)
    assert any(one.key.startswith(f"joints.O.contact.{key}") for one in caught.value.problems)


@pytest.mark.parametrize("given", ["{}", "[]", "1", "true"])
def test_a_friction_model_that_is_none_is_named_with_its_place(given):
    text = f'contact = {{ model = "exact", restitution = 0.5, stiffness = 1e9, friction = {{ model = {given} }} }}\n'
    with pytest.raises(rt.ModelError) as caught:
        rt.loads(CONTACT + text)
    assert any(one.key == "joints.O.contact.friction.model" and one.line == 12 for one in caught.value.problems)


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ('[signals]\nq = "1/0"\n', "signals.q"),
        ('[signals]\nq = "a.x*sqrt(-1)"\n', "signals.q"),
        ('[loads.M]\ntype = "torque"\nbody = "a"\ntorque = "t*(1/0)"\n', "loads.M.torque"),
    ],
)
def test_a_part_that_never_has_a_value_is_named_before_anything_runs(text, place):
    with pytest.raises(rt.ModelError, match="not a finite number") as caught:
        rt.loads(CONTACT.replace('clearance = "1 mm"\n', "") + text)
    (problem,) = caught.value.problems
    assert problem.key == place
    assert "^" in problem.caret


def test_a_title_is_text_for_terminals_and_pictures():
    m = rt.loads('name = "a\\u001b[2J\\u202eb\\nc"\n' + CONTACT)
    assert m.name == "a\\x1b[2J\\u202eb c"
    assert m.name.isprintable()
