"""A key that is added to the list of a table is read, built, offered, in the schema and told by `rattle kinds`."""

import pytest

import rattle as rt
from rattle.description import read_fields, schema_pieces, tables
from rattle.description.file import dump, parse
from rattle.description.reference import common, topics
from rattle.description.schema import OF_DRIVER, OF_JOINT, schema
from rattle.registry import Field

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

KEY = "glow"
GLOW = Field("m", "how far it shines", None, least="positive")
TEXT = """
format = 1
[parameters.r]
value = "5 mm"
[tables.f]
x = [0, 1]
y = [0, 1]
[states.i]
rate = 1
[ground.points]
O = [0, 0]
[bodies.a]
bar = ["O", "P"]
length = "0.1 m"
mass = 1
[bodies.b]
mass = 1
inertia = 1
points = { O = [0, 0] }
[bodies.c]
polygon = [[0, 0], [1, 0], [0, 1]]
mass = 1
[joints.hinge]
type = "revolute"
connect = ["ground.O", "a.O"]
[drivers.motor]
joint = "hinge"
angle = "t"
[joints.loose]
type = "revolute"
connect = ["a.P", "b.O"]
clearance = "0.1 mm"
[joints.loose.contact]
model = "exact"
geometry = "johnson"
bush_material = "steel"
length = "20 mm"
bush_radius = "10 mm"
restitution = 0.5
[joints.loose.wear]
bush = 1e-15
[initial.a]
omega = 1
[initial.loose]
offset = [0, 0]
[simulate]
t_end = 1
"""
PLACES = {  # of the lists: a table that is written so, and the topic that tells its keys, "" if kinds of joints do
    "BAR": ("bodies.a", "bodies"),
    "BODY": ("bodies.b", "bodies"),
    "PLATE": ("bodies.c", "bodies"),
    "GROUND": ("ground", "ground"),
    "PARAMETER": ("parameters.r", "parameters"),
    "TABLE": ("tables.f", "tables"),
    "STATE": ("states.i", "states"),
    "JOINT": ("joints.loose", ""),
    "DRIVER": ("drivers.motor", ""),
    "WEAR": ("joints.loose.wear", "wear"),
    "START": ("initial.a", "initial"),
    "OFFSET": ("initial.loose", "initial"),
    "SIMULATE": ("simulate", "simulate"),
}
BUILT = {
    "BAR": lambda m, glow: m.bar("d", "A", "B", length=1, mass=1, **glow),
    "BODY": lambda m, glow: m.body("d", mass=1, inertia=1, points={"A": [0, 0]}, **glow),
    "PLATE": lambda m, glow: m.plate("d", [[0, 0], [1, 0], [0, 1]], mass=1, **glow),
    "JOINT": lambda m, glow: m.revolute("d", "ground.O", "b.O", **glow),
    "DRIVER": lambda m, glow: m.driver("d", body="b", coordinate="x", position="t", **glow),
    "PARAMETER": lambda m, glow: m.parameter("d", 1, **glow),
    "TABLE": lambda m, glow: m.table("d", [0, 1], [0, 1], **glow),
    "STATE": lambda m, glow: m.state("d", 1, **glow),
    "START": lambda m, glow: m.initial("a", **glow),
    "SIMULATE": lambda m, glow: m.settings(**glow),
}


@pytest.fixture
def glowing(request, monkeypatch):
    """The name of a list that has one more key."""
    monkeypatch.setitem(getattr(tables, request.param).fields, KEY, GLOW)
    return request.param


def glow(place, value):
    """The text in which the table of a place has the key."""
    document = parse(TEXT)
    table = document
    for key in place.split("."):
        table = table[key]
    table[KEY] = value
    return dump(document, None, [])


def refused(text):
    with pytest.raises(rt.ModelError) as caught:
        rt.loads(text)
    return [str(problem) for problem in caught.value.problems]


def declared_fields(part):
    """All fields of a part of the model file."""
    if isinstance(part, Field):
        yield part
    elif isinstance(part, tables.Form):
        for entry in part.keys.values():
            yield from declared_fields(entry)
    elif isinstance(part, tables.Either):
        for entry in part.forms:
            yield from declared_fields(entry)
    elif isinstance(part, tables.Named):
        yield from declared_fields(part.entry)


def test_every_shape_is_read_and_in_the_schema():
    read = {*read_fields.SHAPES, *read_fields.OWN, "number"}
    parts = [part for part in vars(tables).values() if isinstance(part, tables.Form)]
    shapes = {field.shape for part in parts for field in declared_fields(part)}
    assert shapes <= read
    of_kinds = {*OF_JOINT, *OF_DRIVER}
    assert shapes <= {*schema_pieces.SHAPES, *of_kinds, "number", "quantity", "expression"}


@pytest.mark.parametrize("glowing", PLACES, indirect=True)
def test_the_reader_takes_it_and_refuses_wrong_values(glowing):
    place = PLACES[glowing][0]
    rt.loads(glow(place, "2 mm"))
    assert refused(glow(place, "2 kg")) == [f"{place}.{KEY}: '2 kg' is a mass; expected a length in m"]
    assert refused(glow(place, -1)) == [f"{place}.{KEY}: -1 must be positive"]


@pytest.mark.parametrize("name", PLACES)
def test_without_the_list_it_is_unknown(name):
    place = PLACES[name][0]
    (problem,) = refused(glow(place, "2 mm"))
    assert problem.startswith(f"{place}.{KEY}: unknown key")


@pytest.mark.parametrize("glowing", PLACES, indirect=True)
def test_the_schema_and_what_kinds_tells_have_it(glowing):
    jsonschema = pytest.importorskip("jsonschema")
    place, topic = PLACES[glowing]
    validator = jsonschema.Draft202012Validator(schema())
    assert validator.is_valid(parse(glow(place, "2 mm")))
    assert not validator.is_valid(parse(glow(place, -1)))
    of_kinds = [*common("joint", "revolute"), *common("driver", "angle")]
    assert f"{KEY}: how far it shines [m]" in (topics()[topic].lines if topic else of_kinds)


@pytest.mark.parametrize("glowing", BUILT, indirect=True)
def test_a_mechanism_built_in_code_takes_it(glowing):
    m = BUILT[glowing](rt.loads(TEXT), {KEY: "2 mm"})
    assert KEY in m.to_toml()
    with pytest.raises(rt.ModelError, match=f"{KEY}: -1 must be positive"):
        _ = BUILT[glowing](rt.loads(TEXT), {KEY: -1}).model


@pytest.mark.parametrize("glowing", PLACES, indirect=True)
def test_the_editor_of_the_studio_offers_it(glowing):
    completion = pytest.importorskip("rattle.studio.completion")
    completion.entries.cache_clear()
    try:
        parts = completion.entries()["parts"]
    finally:
        completion.entries.cache_clear()
    offered = [part["keys"][KEY] for part in parts if KEY in part.get("keys", {})]
    assert offered
    assert {parts[number]["about"] for number in offered} == {"how far it shines [m]"}
