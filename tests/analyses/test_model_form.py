"""Models of one form are the models that reading gives, with the same bits."""

import numpy as np
import pytest

import rattle as rt
from rattle.analyses.model_form import ModelForm, _alike_systems, alike
from rattle.equations.system import compile_system
from rattle.errors import ModelError, TraceError

EXAMPLES = (
    "fourbar",
    "fourbar_oil",
    "slider_crank",
    "crank_rocker_play",
    "squeezer",
    "geneva",
    "three_plays",
    "cam_lift_off",
)


def _form(m: rt.Mechanism, names: list[str]) -> ModelForm:
    made = m.set({name: m.parameters[name] for name in names})
    return ModelForm(made._document, made.model, names)


@pytest.mark.parametrize("example", EXAMPLES)
def test_form_of_every_parameter_gives_what_reading_gives(example: str) -> None:
    m, random = rt.example(example), np.random.default_rng(0)
    held = 0
    for name, value in m.parameters.items():
        try:
            form = _form(m, [name])
        except TraceError:
            continue
        for share in random.uniform(-0.2, 0.2, 2):
            x = value + share * (value or 1.0)
            made = form.at([x])
            try:
                wanted = m.set({name: x}).model
            except ModelError:
                assert made is None, f"{name} = {x} is refused"
                continue
            if made is None:
                continue
            held += 1
            assert alike(made.model, wanted), f"{name} = {x}"
            assert made.system is None or _alike_systems(made.system, compile_system(wanted)), f"{name} = {x}"
    assert held > len(m.parameters)


def test_all_parameters_at_once_have_a_form() -> None:
    m = rt.example("fourbar")
    names = list(m.parameters)
    form = _form(m, names)
    values = [1.01 * x for x in m.parameters.values()]
    made = form.at(values)
    assert made is not None
    assert alike(made.model, m.set(dict(zip(names, values, strict=True))).model)


def test_beyond_a_limit_the_model_is_read_and_refused_in_the_same_words() -> None:
    m = rt.example("fourbar")
    for _ in range(5):
        m.neighbour({"l2": 0.61})
    with pytest.raises(ModelError) as by_form:
        m.neighbour({"l2": 0.9})
    with pytest.raises(ModelError) as by_reading:
        m.set({"l2": 0.9})
    assert str(by_form.value) == str(by_reading.value)


def test_neighbours_of_a_form_start_as_those_that_were_read() -> None:
    m = rt.example("crank_rocker_play")
    value = m.parameters["link"]
    read = [m.neighbour({"link": value * x}) for x in (1.001, 1.002)]
    formed = [m.neighbour({"link": value * x}) for x in (1.003, 1.001, 1.002)][1:]
    assert m._beside_its_start._forms[("link",)][0] is not None
    for one, other in zip(read, formed, strict=True):
        assert np.array_equal(one.start.q, other.start.q)
        assert np.array_equal(one.start.v, other.start.v)
        assert one.start.changes == other.start.changes
        assert one.to_toml() == other.to_toml()


def test_forms_are_forgotten_when_the_mechanism_is_changed() -> None:
    m = rt.Mechanism("pendulum", gravity=[0, -9.81])
    m.parameter("l", 1.0).ground(O=[0, 0]).bar("rod", "A", "B", length="l", mass=1).revolute("O", "ground.O", "rod.A")
    for _ in range(4):
        assert m.neighbour({"l": 2.0}).model.bodies["rod"].inertia == pytest.approx(4.0 / 12.0)
    m.parameter("half", "l/2").ground(P=["half", 0])
    assert m.neighbour({"l": 2.0}).model.ground["P"] == (1.0, 0.0)


@pytest.mark.parametrize("name", ["fourbar", "crank_rocker_play", "slider_crank", "fourbar_onesided"])
def test_without_notes_a_start_is_the_same(name: str) -> None:
    m = rt.example(name)
    parameter = next(key for key, one in m.model.parameters.items() if one.unit == "m")
    for x in (1.001, 1.002, 1.003, 1.004):
        moved = {parameter: m.parameters[parameter] * x}
        told, untold = m.neighbour(moved).start, m.neighbour(moved, told=False).start
        assert np.array_equal(told.q, untold.q)
        assert np.array_equal(told.v, untold.v)
        assert untold.notes == ()


def test_samples_of_a_study_have_the_same_bits_read_or_of_a_form() -> None:
    values = [0.6, 0.601, 0.599, 0.602]
    m = rt.example("fourbar").with_contact("impact")
    forwards = m.many({"l2": values}, ["final(rocker.angle)"], 1e-3, threads=1)
    m = rt.example("fourbar").with_contact("impact")
    backwards = m.many({"l2": values[::-1]}, ["final(rocker.angle)"], 1e-3, threads=1)
    assert np.array_equal(forwards["final(rocker.angle)"], backwards["final(rocker.angle)"][::-1])
    assert not forwards.messages


@pytest.mark.parametrize("name", ["jansen_leg", "squeezer", "fourbar", "crank_rocker_play", "path_generator"])
def test_neighbours_start_where_a_search_of_all_closings_does(name: str) -> None:
    m, random = rt.example(name), np.random.default_rng(1)
    for key, one in m.model.parameters.items():
        if one.unit != "m":
            continue
        for share in random.uniform(-0.01, 0.01, 1):
            moved = {key: one.value * (1.0 + share)}
            try:
                alone = m.set(moved).start
            except ModelError:
                continue
            beside = m.neighbour(moved).start
            assert beside.q == pytest.approx(alone.q, rel=0.0, abs=1e-12), f"{moved}"
            assert beside.v == pytest.approx(alone.v, rel=0.0, abs=1e-11 * max(1.0, np.abs(alone.v).max())), f"{moved}"
