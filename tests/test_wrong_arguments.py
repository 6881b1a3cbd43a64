"""Public methods say what they want, whatever they are given: no error from inside reaches who calls them."""

import inspect
import random
from contextlib import suppress

import numpy as np
import pytest

import rattle as rt
from rattle.errors import ANSWERS
from rattle.questions.ensemble.compute import Ensemble
from rattle.questions.film.bearing import Film
from rattle.questions.many.compute import Many
from rattle.questions.modes.compute import Modes
from rattle.questions.power.compute import Power
from rattle.questions.sweep.compute import Sweep
from rattle.wrong_arguments import fits

pytestmark = pytest.mark.nojit
SEED = 20261123
EACH = 3  # calls of every method
LONG = {"poincare", "view"}  # runs whose length no wrong argument shortens; a widget
MODEL = """format = 1
gravity = [0, -9.81]
[parameters]
l = { value = "1 m", min = "0.5 m", max = "2 m", tol = "1 mm" }
[ground.points]
O = [0, 0]
[bodies.rod]
bar = ["A", "B"]
length = "l"
mass = 1
[joints.O]
type = "revolute"
connect = ["ground.O", "rod.A"]
[simulate]
t_end = "2 ms"
output = "1 ms"
"""
VALUES = (
    None, 5, -1, 1.5, float("nan"), 10**400, "", "x", "5 mm", [], [1], ["x"], [None], {}, {"x": 1}, {"l": 5}, {1: 2},
    (), (1, 2), object(), True, b"x", np.array([1.0, 2.0]), np.array(["a"]), print, {"l": None}, [[1, 2], [3]], 1 + 2j,
    type,
)  # fmt: skip


@pytest.fixture(scope="module")
def objects():
    m = rt.loads(MODEL)
    return {"Mechanism": m, "Result": m.simulate()}


def public(cls):
    return [name for name, one in inspect.getmembers_static(cls, inspect.isfunction) if not name.startswith("_")]


METHODS = [(cls.__name__, name) for cls in (rt.Mechanism, rt.Result) for name in public(cls) if name not in LONG]


def drawn(method, draw):
    """Arguments of which every one may be of a wrong type."""
    args, options = [], {}
    for one in inspect.signature(method).parameters.values():
        if one.kind is one.VAR_POSITIONAL:
            args.append(draw.choice(VALUES))
        elif one.kind is one.VAR_KEYWORD:
            options["l"] = draw.choice(VALUES)
        elif one.kind is one.KEYWORD_ONLY:
            if one.default is one.empty or draw.random() < 0.2:
                options[one.name] = draw.choice(VALUES)
        elif one.default is one.empty or draw.random() < 0.5:
            options[one.name] = draw.choice(VALUES)
    return args if not options.keys() & inspect.signature(method).parameters.keys() else [], options


@pytest.mark.parametrize(("owner", "name"), METHODS, ids=lambda one: one)
def test_wrong_arguments_are_answered_in_words(owner, name, objects, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for number in range(EACH):
        draw = random.Random(f"{SEED} {owner} {name} {number}")
        target = objects[owner].set() if owner == "Mechanism" else objects[owner]
        method = getattr(target, name)
        args, options = drawn(method, draw)
        with suppress(*ANSWERS):  # any other error fails
            method(*args, **options)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda m, r: m.body("b", mass=1, inertia=1, points=5), "points: expected a dict"),
        (lambda m, r: m.page("p.html", over=[1]), "over"),
        (lambda m, r: m.parameters_with(5, "here"), "changes: expected a dict"),
        (lambda m, r: m.parameters_where(5), "values: expected a dict"),
        (lambda m, r: m.parameters_with({"x": {"tol": 1}}, "here"), "no such parameter"),
        (lambda m, r: m.written_unit("x"), "no such parameter"),
        (lambda m, r: m.bifurcation("l", 10**400, "rod.angle"), "values: expected a list"),
        (lambda m, r: m.revolute(["O"], "ground.O", "rod.A"), "name: expected a text"),
        (lambda m, r: m.orbit(5), "joint: expected a text"),
        (lambda m, r: r.plot(None), "expected a text"),
        (lambda m, r: r.save(5), "path: expected a text"),
        (lambda m, r: m.bifurcation("l", [10**400], "rod.angle"), "values: expected a list, each a number"),
        (lambda m, r: rt.Mechanism().set(), "at least one body"),
        (lambda m, r: rt.Mechanism().ideal(), "at least one body"),
        (lambda m, r: rt.load_result(None), "path: expected a text"),
        (lambda m, r: rt.example([1]), "name: expected a text"),
        (lambda m, r: rt.load_law([1]), "name: expected a text"),
        (lambda m, r: rt.normal_law([1]), "name: expected a text"),
        (lambda m, r: rt.friction_law([1]), "name: expected a text"),
    ],
)
def test_what_is_wanted_is_named(call, words, objects):
    with pytest.raises(rt.InputError) as caught:
        call(objects["Mechanism"].set(), objects["Result"])
    assert words in str(caught.value)


def test_what_no_result_can_hold_is_not_in_it(objects):
    assert [1] not in objects["Result"]
    assert "rod.angle" in objects["Result"]


@pytest.mark.parametrize("owner", [Film, Many, Ensemble, Sweep, Modes, Power, rt.Trust])
def test_public_methods_of_answers_blame_wrong_arguments_too(owner):
    assert all(hasattr(getattr(owner, name), "__wrapped__") for name in public(owner))


def test_a_mode_that_is_no_number_is_named(objects):
    with pytest.raises(rt.InputError, match="mode: expected a whole number"):
        objects["Mechanism"].modes().behaviour("x")


def test_a_fault_of_our_own_is_not_put_down_to_sound_arguments(objects, monkeypatch):
    def slip(*_):
        return [][0]

    monkeypatch.setattr("rattle.plots.diagram.plot_model", slip)
    with pytest.raises(IndexError) as caught:
        objects["Mechanism"].plot()
    assert not isinstance(caught.value, rt.InputError)


@pytest.mark.parametrize(
    ("value", "wanted", "right"),
    [
        (1, float, True),
        (np.float32(1), float, True),
        (np.int64(1), int, True),
        (True, float, False),
        ("1", float, False),
        ("x", str | None, True),
        (None, str | None, True),
        (1, str | None, False),
        ([1, 2.0], list[float], True),
        ([1, "x"], list[float], False),
        (np.ones(3), list[float], True),
        (np.float64(1), list[float], False),
        ({"a": 1}, dict[str, float], True),
        ({"a": "x"}, dict[str, float], False),
        (10**400, float, False),
        (10**400, int, True),
        ((1, 2), tuple[float, float], True),
        ((1, 2, 3), tuple[float, float], False),
    ],
)
def test_which_values_are_surely_of_another_type(value, wanted, right):
    assert fits(value, wanted) is right
