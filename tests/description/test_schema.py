"""The JSON Schema says what the reader says, as far as a schema can."""

import copy
import subprocess
import sys
import tomllib
from pathlib import Path

import jsonschema
import pytest

import rattle
from rattle import registry
from rattle.description.schema import schema

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

EXAMPLES = sorted((Path(rattle.__file__).parent / "examples").glob("*.toml"))
FOURBAR = tomllib.loads((Path(__file__).parents[1] / "data" / "full.toml").read_text())


@pytest.fixture(scope="module")
def validator():
    return jsonschema.Draft202012Validator(schema())  # that it is one is seen where the command prints it


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_every_shipped_example_is_accepted(validator, path):
    validator.validate(tomllib.loads(path.read_text()))


@pytest.mark.parametrize("word", ["ideal", "massless-link", "impact", "exact", "kelvin-voigt"])
def test_one_word_may_change_the_contact_model(validator, word):
    document = tomllib.loads((EXAMPLES[0].parent / "slider_crank_play.toml").read_text())
    document["joints"]["B"]["contact"] |= {"model": word, "friction": {"model": "lugre", "mu": 0.1}}
    validator.validate(document)


def test_the_full_model_is_accepted(validator):
    validator.validate(FOURBAR)


@pytest.mark.parametrize(
    ("path", "old", "new"),
    [
        ((), "gravity", "gravitiy"),
        (("bodies", "crank"), "mass", "mas"),
        (("bodies", "rocker"), "inertia", "inertai"),
        (("joints", "O3"), "clearance", "clearence"),
        (("joints", "O4", "contact"), "model", "modell"),
        (("drivers", "motor"), "angle", "angel"),
        (("loads", "M"), "torque", "torqe"),
        (("initial", "coupler"), "omega", "omga"),
        (("initial", "O3"), "offset", "ofset"),
        (("simulate",), "rtol", "rtoll"),
        (("parameters", "r3"), "tol", "toll"),
        (("ground",), "points", "point"),
    ],
)
def test_a_misspelt_key_is_refused_as_the_reader_does(validator, path, old, new):
    document = copy.deepcopy(FOURBAR)
    table = document
    for key in path:
        table = table[key]
    table[new] = table.pop(old)
    assert not validator.is_valid(document)
    from rattle.description.reader import read
    from rattle.errors import ModelError

    with pytest.raises(ModelError):
        read(document)


@pytest.mark.parametrize(
    "dist", ["uniform", "normal", "triangular", {"values": ["1 mm", 2]}, {"values": [1, 2], "weights": [1, 0]}]
)
def test_every_distribution_is_accepted(validator, dist):
    document = copy.deepcopy(FOURBAR)
    document["parameters"]["r3"]["dist"] = dist
    validator.validate(document)


def test_names_of_materials_and_of_diameters_are_accepted(validator):
    steel = {"forged steel": {"E": "207 GPa"}}
    validator.validate({**FOURBAR, "materials": steel, "parameters": {**FOURBAR["parameters"], "O.bore": "12 um"}})


def test_groups_of_tolerances_are_accepted(validator):
    validator.validate({**FOURBAR, "tolerances": {"groups": [["r3", "r4"]]}})


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("format",), 2),
        (("tolerances",), {"group": [["r3", "r4"]]}),
        (("tolerances",), {"groups": ["r3", "r4"]}),
        (("tolerances",), {"groups": [["r3"]]}),
        (("parameters", "r3", "dist"), "gauss"),
        (("parameters", "r3", "dist"), {"values": []}),
        (("parameters", "r3", "dist"), {"weights": [1]}),
        (("parameters", "r3", "dist"), {"values": [1], "weigths": [1]}),
        (("bodies", "crank", "mass"), -1),
        (("bodies", "crank", "mass"), [1]),
        (("joints", "O3", "clearance"), -0.001),
        (("joints", "O3", "connect"), ["coupler.O3"]),
        (("joints", "O3", "type"), "hinge"),
        (("loads", "M", "body"), 3),
        (("simulate", "method"), "euler"),
        (("gravity",), [0, 0, -9.81]),
    ],
)
def test_a_wrong_value_is_refused(validator, path, value):
    document = copy.deepcopy(FOURBAR)
    table = document
    for key in path[:-1]:
        table = table[key]
    table[path[-1]] = value
    assert not validator.is_valid(document)


def test_a_plate_has_its_mass_in_one_of_two_ways(validator):
    def is_valid(**given):
        corners = [[0, 0], ["l1", 0], [0, "5 mm"]]
        return validator.is_valid({**FOURBAR, "bodies": {**FOURBAR["bodies"], "plate": {"polygon": corners, **given}}})

    assert is_valid(mass=1, points={"A": [0, 0]})
    assert is_valid(thickness="5 mm", density="7850 kg/m^3", holes=[[[0, 0], [1, 0], [0, 1]]])
    assert not is_valid(thickness="5 mm", density=1, mass=1)
    assert not is_valid(thickness="5 mm")
    assert is_valid(mass=1, inertia=1, center=[0, 0])  # of a part whose polygon is the picture alone
    assert not is_valid(thickness="5 mm", density=1, inertia="nosuch kg", center=3)
    assert not is_valid(mass=1, polygon=[[0, 0], [1, 0]])


@pytest.mark.parametrize("family", ["joint", "load"])
def test_every_field_of_the_registry_is_there_with_unit_and_meaning(family):
    entries = {
        one["properties"]["type"]["const"]: one
        for one in schema()["properties"][f"{family}s"]["additionalProperties"]["anyOf"]
    }
    for kind in registry.kinds(family).values():
        assert entries[kind.name]["description"] == kind.summary
        for key, field in kind.fields.items():
            described = entries[kind.name]["properties"][key]
            assert field.shape == "connect" or field.meaning in described["description"]
            assert field.unit in described["description"]


def test_methods_stand_in_one_order_whichever_was_imported_first():
    program = (
        "import rattle.solvers.steppers.radau; from rattle.description.schema import steppers; print(steppers(True))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=120)
    assert done.stdout == "dop853 and event and radau\n"
