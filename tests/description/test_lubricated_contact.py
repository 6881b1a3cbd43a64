"""Reading a lubricated contact: what must be given, what does not fit, and one word to and from other models."""

import tomllib

import jsonschema
import pytest

import rattle as rt
from rattle.description.schema import schema

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
OIL = {"viscosity": '"50 mPa*s"', "length": '"10 mm"', "bush_radius": '"10 mm"'}
DRY = '{ model = "hertz", stiffness = "1e9 N/m^1.5", friction = 0.05 }'


def text(clearance="50 um", joint="revolute", model="lubricated", offset=20, **contact):
    keys = "".join(f", {key} = {value}" for key, value in contact.items())
    return f"""
format = 1
ground.points = {{ O = [0, 0] }}
bodies.pin = {{ points = {{ P = [0, 0] }}, mass = 1.0, inertia = 1e-3 }}
[joints.O]
type = "{joint}"
connect = ["ground.O", "pin.P"]
clearance = "{clearance}"
contact = {{ model = "{model}"{keys} }}
[initial]
O = {{ offset = ["{offset} um", 0] }}
"""


def contact_of(**contact):
    return rt.loads(text(**OIL | contact)).model.joints["O"].contact


def test_what_is_not_given_follows_from_the_rest():
    plain, rough = contact_of(), contact_of(roughness='["0.3 um", "0.4 um"]')
    assert (plain.film.law.kind, plain.film.law.values["cavitation"]) == ("finite", "reynolds")
    assert plain.film.boundary == pytest.approx(50e-9)
    assert plain.film.roughness == pytest.approx(50e-9 / 3)
    assert (rough.film.roughness, rough.film.boundary) == pytest.approx((0.5e-6, 1.5e-6))
    assert contact_of(roughness='"0.4 um"').film.boundary == pytest.approx(1.2e-6)
    assert contact_of(roughness='"0.4 um"', boundary_film='"2 um"').film.boundary == pytest.approx(2e-6)
    assert (plain.title, plain.normal.kind, plain.static.kind) == ("lubricated", "hertz", "johnson")
    assert plain.film.assumed
    given = contact_of(dry=DRY)
    assert (given.static.values["stiffness"], given.friction.values["mu"]) == (1e9, 0.05)
    assert (given.bush_radius, given.film.assumed) == (0.01, "")


@pytest.mark.parametrize(
    ("given", "where", "what"),
    [
        ({"viscosity": None}, "contact", "needs viscosity"),
        ({"viscosity": 0}, "contact.viscosity", "must be positive"),
        ({"viscosity": '"5 mm"'}, "contact.viscosity", "expected a dynamic viscosity in Pa"),
        ({"film": '"shrt"'}, "contact.film", "did you mean 'short'"),
        ({"cavitation": '"gumbel"'}, "contact.cavitation", "expected one of reynolds, full"),
        ({"viscositi": 1}, "contact.viscositi", "did you mean 'viscosity'"),
        ({"boundary_film": '"30 um"'}, "contact.boundary_film", "thinner than half the clearance"),
        ({"roughness": '["9 um", "9 um"]'}, "contact.roughness", "thinner than half the clearance"),
        ({"roughness": '["1 um"]'}, "contact.roughness", "a number in m, or [bush, pin]"),
        ({"roughness": 0}, "contact.roughness", "must be positive"),
        ({"length": '"50 mm"'}, "contact", "L/D is 2.5"),
        ({"clearance": "0.3 mm"}, "contact", "at most 0.02"),
        ({"clearance": "0 mm"}, "contact", "needs a clearance"),
        ({"dry": '"hertz"'}, "contact.dry", "table of a compliant contact"),
        ({"dry": '{ model = "impact" }'}, "contact.dry", "needs the model of a compliant contact"),
        ({"dry": '{ model = "hertz" }'}, "contact.dry", "needs a stiffness"),
        ({"dry": DRY.replace("}", ', bush_radius = "9 mm" }')}, "contact.dry.bush_radius", "leave it out here"),
        ({"joint": "prismatic"}, "contact.model", "does not work on a prismatic joint"),
    ],
)
def test_what_does_not_make_a_film_is_refused(given, where, what):
    given = {key: value for key, value in (OIL | given).items() if value is not None}
    with pytest.raises(rt.ModelError) as raised:
        rt.loads(text(**given))
    assert any(one.path[2:] == tuple(where.split(".")) and what in str(one) for one in raised.value.problems), (
        raised.value
    )


def test_a_pin_outside_its_bush_is_refused_and_one_in_the_boundary_film_is_not():
    for offset, fits in ((48, True), (51, False)):
        m = rt.loads(text(offset=offset, boundary_film='"5 um"', **OIL))
        if fits:
            assert m.simulate(1e-9)["O.normal"][0] > 0.0
        else:
            with pytest.raises(rt.AssemblyError, match=r"starts 1e-06 m outside its clearance of 5e-05 m"):
                m.simulate(1e-9)


def test_one_word_changes_between_oil_and_other_models():
    """Words of the other models stay, are checked, and are listed as not used."""
    m = rt.loads(text(friction=0.1, stiffness=1e8, **OIL))
    assert m.model.joints["O"].contact.unused == ("friction", "stiffness")
    dry = rt.loads(text(model="hertz", friction=0.1, stiffness=1e8, film='"short"', dry=DRY, **OIL))
    assert set(dry.model.joints["O"].contact.unused) == {"viscosity", "length", "film", "dry"}
    with pytest.raises(rt.ModelError, match="did you mean 'short'"):
        rt.loads(text(model="hertz", stiffness=1e8, film='"shor"', **OIL))
    oiled = dry.set({"joints.O.contact.model": "lubricated"})
    assert oiled.contact_of("O")["dry"]["stiffness"] == "1e9 N/m^1.5"
    assert oiled.with_contact("hertz").contact_of("O")["stiffness"] == "1e9 N/m^1.5"
    own = rt.loads(text(model="hertz", friction=0.1, stiffness=1e8, **OIL)).with_contact("lubricated")
    assert own.contact_of("O")["dry"] == {"model": "hertz", "friction": 0.1, "stiffness": 1e8}


def test_the_schema_knows_the_words():
    validator = jsonschema.Draft202012Validator(schema())
    validator.validate(tomllib.loads(text(dry=DRY, film='"short"', roughness='["1 um", 0]', shear='"wetted"', **OIL)))
    validator.validate(tomllib.loads(text(model="hertz", stiffness=1e8, **OIL)))
    for wrong in ({"film": '"shrt"'}, {"cavitation": '"none"'}, {"viscositi": 1}):
        with pytest.raises(jsonschema.ValidationError):
            validator.validate(tomllib.loads(text(**OIL | wrong)))
