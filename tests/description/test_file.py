"""Model files: what is written is what is read; comments survive; changes hit exactly what they name."""

import json
import tomllib
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import rattle as rt
from rattle.language.syntax import Apply, Name, Number

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

TEXT = (Path(__file__).parents[1] / "data" / "full.toml").read_text()
EXAMPLES = sorted((Path(rt.__file__).parent / "examples").glob("*.toml"))


def plain(value):
    """A model as nested plain data, so that two models can be compared."""
    if isinstance(value, Number):
        return value.value
    if isinstance(value, Name):
        return value.name
    if isinstance(value, Apply):
        return (value.name, *(plain(one) for one in value.operands))
    if is_dataclass(value):
        return {one.name: plain(getattr(value, one.name)) for one in fields(value)}
    if isinstance(value, dict):
        return {key: plain(one) for key, one in value.items()}
    return [plain(one) for one in value] if isinstance(value, list | tuple) else value


def same(one, other):
    return plain(one.model) == plain(other.model)


# ---------------------------------------------------------------- there and back
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example_survives_being_written_and_read(path):
    m = rt.load(path)
    assert same(rt.loads(m.to_toml()), m)
    if not any("file" in one for one in tomllib.loads(path.read_text()).get("tables", {}).values()):
        assert m.to_toml() == path.read_text()  # otherwise with the numbers of the file


def test_model_text_is_written_as_it_was_read():
    assert rt.loads(TEXT).to_toml() == TEXT


def test_json_is_the_same_model():
    m = rt.loads(json.dumps(tomllib.loads(TEXT)))
    assert same(m, rt.loads(TEXT))
    assert same(rt.loads(m.to_toml()), m)  # and is written as TOML


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_a_name_ending_in_json_is_written_as_json(path, tmp_path):
    m = rt.load(path)
    m.save(tmp_path / "m.JSON")
    assert json.loads((tmp_path / "m.JSON").read_text()) == tomllib.loads(m.to_toml())
    assert same(rt.load(tmp_path / "m.JSON"), m)


@pytest.mark.parametrize("name", ["m.csv", "m.nc", "m"])
def test_a_model_is_not_written_under_the_name_of_something_else(name, tmp_path):
    with pytest.raises(ValueError, match=r"a model is saved as TOML or JSON; give a name ending in \.toml or \.json"):
        rt.loads(TEXT).save(tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_byte_order_mark_and_windows_line_ends_are_no_matter(tmp_path):
    file = tmp_path / "windows.toml"
    file.write_bytes(b"\xef\xbb\xbf" + TEXT.replace("\n", "\r\n").encode())
    assert same(rt.load(file), rt.loads(TEXT))


def test_saved_file_is_the_model(tmp_path):
    m = rt.loads(TEXT).set(r3="2 mm")
    m.save(tmp_path / "m.toml")
    assert same(rt.load(tmp_path / "m.toml"), m)


def in_code():
    m = rt.Mechanism("built in code", gravity=[0, "-9.81 m/s^2"])
    m.parameter("l", "0.2 m").parameter("c", "1 mm", min="0.1 mm", max=0.01, tol="10 um", dist="normal")
    m.parameter("d", "1 mm", dist={"values": ["1 mm", "2 mm"], "weights": [1, 3]})
    m.group("l", "c").group("d", "e").parameter("e", 3)
    m.signal("reach", "rod.x + l").ground(A=[0, 0], D=["3*l", 0])
    m.bar("crank", "A", "B", length="l", mass=1)
    m.bar("rod", "B", "C", length="3*l", mass="500 g", inertia=0.01, points={"P": ["l", 0.1]})
    m.body("slider", mass=2, inertia=0.1, points={"C": (0, 0)}, center=(0.01, 0))
    m.revolute("A", "ground.A", "crank.A").revolute("B", "crank.B", "rod.B", clearance="c", contact="massless-link")
    m.revolute("C", "rod.C", "slider.C").prismatic("guide", "ground.A", "slider.C", axis="0 deg")
    m.driver("motor", "A", angle="10*t").driver("push", body="slider", coordinate="angle", angle=0)
    m.load("spring", "spring", connect=["ground.D", "slider.C"], stiffness="1 N/mm", free_length="l")
    m.load("gust", "force", at="rod.P", force=["sin(t)", 0], frame="body")
    m.load("brake", "torque", body="crank", torque="-0.1*crank.omega")
    return m.initial("rod", angle=-0.1).initial("B", offset=["c", 0]).settings(t_end="1 s", method="rk4", step=1e-4)


def test_model_built_in_code_survives_being_written_and_read():
    m = in_code()
    again = rt.loads(m.to_toml())
    assert same(again, m)
    assert again.to_toml() == m.to_toml()


def test_written_model_is_made_for_reading():
    text = in_code().to_toml()
    assert "[bodies.crank]\n" in text
    assert "points = { P = " in text  # innermost tables in one line
    assert "dist = { values = " in text


# ---------------------------------------------------------------- changes
def test_comments_survive_a_change():
    text = rt.loads(TEXT).set({"r3": "2 mm", "joints.O4.contact": "ideal", "bodies.crank.mass": 0.7}).to_toml()
    kept = [line for line in TEXT.split("\n") if "#" in line]
    assert kept
    assert all(line in text.split("\n") for line in kept)
    differ = [(a, b) for a, b in zip(TEXT.split("\n"), text.split("\n"), strict=True) if a != b]
    assert [b for _, b in differ] == [
        'r3 = { value = "2 mm", min = "0.5 mm", max = "10 mm", tol = "0.5 mm" }',
        "mass = 0.7",
        'contact = "ideal"',
    ]


def test_a_changed_mechanism_leaves_the_first_one_as_it_was():
    first = rt.Mechanism.from_text(TEXT)
    before = first.to_toml(), plain(first.model)
    second = first.set({"bodies.crank.mass": 3.0})
    second.parameter("another", 1.0)
    for body in second._document["bodies"].values():
        body["points"] = {}
    assert (first.to_toml(), plain(rt.Mechanism.from_text(first.to_toml()).model)) == before
    assert first._document != second._document
    assert all(body["points"] for body in first._document["bodies"].values() if "points" in body)


def test_groups_can_be_set_where_there_were_none():
    m = rt.loads(TEXT).set({"tolerances.groups": [["r3", "r4"]]})
    assert m.model.groups == (("r3", "r4"),)
    assert same(rt.loads(m.to_toml()), m)


def test_change_makes_a_new_model_and_leaves_the_old_one():
    m = rt.loads(TEXT)
    changed = m.set(r3="2 mm", r4=0.003)
    assert changed.parameters["r3"] == 0.002
    assert changed.model.joints["O4"].clearance == 0.003
    assert m.parameters["r3"] == 0.005
    assert m.to_toml() == TEXT


@pytest.mark.parametrize(
    ("path", "value", "seen"),
    [
        ("l1", "30 cm", lambda m: m.parameters["l1"] == 0.3 and m.parameters["twice"] == 0.6),
        ("r3", np.float64(0.004), lambda m: m.model.joints["O3"].clearance == 0.004),
        ("r3", np.float32(0.5) / 100, lambda m: m.model.joints["O3"].clearance == pytest.approx(0.005)),
        ("bodies.crank.mass", "700 g", lambda m: m.model.bodies["crank"].mass == 0.7),
        ("joints.O3.contact", "ideal", lambda m: m.model.joints["O3"].contact.model == "ideal"),
        ("joints.O3.contact.model", "ideal", lambda m: m.model.joints["O3"].contact.model == "ideal"),
        ("joints.O4.contact.model", "ideal", lambda m: m.model.joints["O4"].contact.model == "ideal"),
        ("ground.points.O4", (1.4, 0), lambda m: m.model.ground["O4"] == (1.4, 0)),
        ("ground.points.O4", np.array([1.4, 0]), lambda m: m.model.ground["O4"] == (1.4, 0)),
        ("ground.points.O4.0", 1.4, lambda m: m.model.ground["O4"] == (1.4, 0)),
        ("gravity", [0, -9.81], lambda m: m.model.gravity == (0, -9.81)),
        ("simulate.t_end", "3 s", lambda m: m.model.settings.t_end == 3),
        ("initial.crank.angle", "10 deg", lambda m: m.model.initial.bodies["crank"]["angle"] == np.pi / 18),
        ("drivers.motor.angle", "2*omega*t", lambda m: plain(m.model.drivers["motor"].value)[0] == "*"),
        ("name", "other", lambda m: m.name == "other"),
    ],
)
def test_paths_lead_to_what_they_name_in_model_and_text(path, value, seen):
    changed = rt.loads(TEXT).set({path: value})
    assert seen(changed)
    assert same(rt.loads(changed.to_toml()), changed)


def test_settings_may_be_given_where_there_were_none():
    text = TEXT[: TEXT.index("[initial]")]
    changed = rt.loads(text).set({"simulate.t_end": "3 s", "initial.rocker.omega": 1})
    assert changed.model.settings.t_end == 3
    assert same(rt.loads(changed.to_toml()), changed)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"r33": 1}, ["no parameter 'r33'", "'r3'"]),
        ({"joints.O33.clearance": 1}, ["no 'joints.O33'", "'O3'"]),
        ({"joint.O3.clearance": 1}, ["no 'joint'", "'joints'"]),
        ({"joints.O3.clearence": "1 mm"}, ["joints.O3.clearence: unknown key", "'clearance'"]),
        ({"joints.O1.contact": "ideal"}, ["joints.O1.contact", "needs a clearance"]),
        ({"joints.O3.contact.modle": "ideal"}, ["joints.O3.contact.modle", "'model'"]),
        ({"bodies.crank.mass.value": 1}, ["no 'bodies.crank.mass'", "not a table"]),
        ({"ground.points.O4.2": 1}, ["index from 0 to 1"]),
        ({"r3": "2 kg"}, ["parameters.r3", "length"]),
        ({"r3": -0.002}, ["parameters.r3"]),
        ({"bodies.crank.mass": float("nan")}, ["not a finite number"]),
        ({"bodies.crank.mass": None}, ["bodies.crank", "needs a mass"]),
    ],
)
def test_change_that_cannot_be_says_why(change, words):
    with pytest.raises(rt.ModelError) as caught:
        rt.loads(TEXT).set(change)
    for word in words:
        assert word in str(caught.value)


def test_ideal_closes_every_clearance():
    ideal = rt.loads(TEXT).ideal()
    assert {one.contact.model for one in ideal.model.joints.values() if one.contact} == {"ideal"}
    assert same(rt.loads(ideal.to_toml()), ideal)


def test_name_given_twice_in_code_is_refused():
    with pytest.raises(rt.ModelError, match="the name 'A' is taken"):
        in_code().revolute("A", "ground.A", "rod.B")


def test_unknown_example_has_a_suggestion():
    with pytest.raises(ValueError, match="did you mean 'fourbar'"):
        rt.example("fourbat")


# ---------------------------------------------------------------- text of every kind
@given(st.text(st.characters(exclude_categories=["Cs"]), max_size=30), st.floats(0.001, 1e6))
def test_any_title_and_number_survive(title, mass):
    m = rt.Mechanism(title).ground(O=[0, 0]).bar("a", "A", "B", length=1, mass=mass)
    again = rt.loads(m.to_toml())
    # titles go to terminals and pictures: what cannot be printed is spelled out, once and for all
    assert again.name == (title if title.isprintable() else m.name)
    assert again.name.isprintable()
    assert again.model.bodies["a"].mass == mass
    renamed = again.set({"name": again.name + "!", "bodies.a.mass": mass / 2})
    assert rt.loads(renamed.to_toml()).name == again.name + "!"


# ---------------------------------------------------------------- one word changes the contact model
WORDS = ["ideal", "massless-link", "impact", "exact", "hertz", "flores", "lankarani-nikravesh", "kelvin-voigt"]


def with_word(word, extra=""):
    text = rt.example("slider_crank_play").to_toml()
    return text.replace('model = "lankarani-nikravesh"', f'model = "{word}"{extra}')


@pytest.mark.parametrize("word", WORDS)
def test_one_word_in_the_file_changes_the_contact_model(word):
    contact = rt.loads(with_word(word)).model.joints["B"].contact
    assert contact.title == word
    known = {"restitution", "bush_radius", "bush_material", "pin_material", "geometry"}
    used = {
        "ideal": set(),
        "massless-link": set(),
        "impact": {"restitution", "bush_radius"},
    }.get(word, known)
    assert set(contact.unused) == known - used


@pytest.mark.parametrize(
    ("extra", "path", "words"),
    [
        ("\nstifness = 3", "stifness", "did you mean 'stiffness'"),
        ("\nfriction = { model = 'lugres' }", "friction.model", "did you mean 'lugre'"),
        ("\nstiffness = '3 kg'", "stiffness", "expected a contact stiffness in N/m^1.5"),
        ("\ntangential_restitution = 1.5", "tangential_restitution", "outside [0, 1]"),
        ("\nfriction = { model = 'ambrosio', mu = 0.1, v0 = 1, v1 = 0.1 }", "", "needs v0 < v1"),
    ],
)
def test_values_of_other_contact_models_are_checked_all_the_same(extra, path, words):
    with pytest.raises(rt.ModelError) as caught:
        rt.loads(with_word("massless-link", extra))
    (problem,) = caught.value.problems
    assert problem.key == f"joints.B.contact.{path}".rstrip(".")
    assert words in problem.message


def test_set_valued_friction_takes_the_coefficient_of_any_law():
    text = with_word("impact", "\nfriction = { model = 'lugre', mu = 0.1, sigma0 = '2e4 1/m' }")
    contact = rt.loads(text).model.joints["B"].contact
    assert contact.fields["friction"] == 0.1
    assert "friction.sigma0" in contact.unused


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('bush_radius = "10 mm"', 'bush_radius = "0.1 mm"', "larger than the clearance"),
        ('bush_material = { E = "207 GPa", nu = 0.3 }', 'bush_material = "bronz"', "did you mean 'bronze'"),
    ],
)
def test_geometry_and_materials_without_use_are_checked_too(old, new, words):
    text = with_word("massless-link")
    assert old in text
    with pytest.raises(rt.ModelError, match=words):
        rt.loads(text.replace(old, new))


def test_friction_law_without_a_coefficient_is_named_as_unused():
    text = with_word("impact", "\nfriction = { model = 'viscous', viscosity = '5 N*s/m' }")
    contact = rt.loads(text).model.joints["B"].contact
    assert contact.fields["friction"] == 0.0
    assert "friction" in contact.unused
