"""Fits, rolling bearings and oils in a model file: by ISO 286, tables of makers, ASTM D341; parameters of them."""

import math

import numpy as np
import pytest

import rattle as rt
from rattle.errors import ModelError

pytestmark = pytest.mark.nojit
MATERIALS = """
[materials.iron]
E = "210 GPa"
expansion = 11.5e-6
[materials.bronze]
E = "110 GPa"
nu = 0.34
expansion = 18e-6
[materials.plain]
E = "70 GPa"
"""
FIT = '{ fit = "H7/g6", diameter = "8 mm" }'
SHUT = '{ fit = "H7/h6", diameter = "300 mm", bush_material = "iron", pin_material = "bronze", temperature = "T" }'
WARM = 'bush_material = "bronze", pin_material = "iron", temperature = "80 degC"'


def loose(clearance, contact='"massless-link"', more=""):
    return f"""
format = 1
parameters.T = "60 degC"
parameters.d = "8 mm"
ground.points.O = [0, 0]
bodies.pin = {{ points = {{ P = [0, 0] }}, mass = 1, inertia = 1e-3 }}
joints.O = {{ type = "revolute", connect = ["ground.O", "pin.P"], {clearance}, contact = {contact}{more} }}
drivers.hold = {{ body = "pin", coordinate = "angle", angle = "0*t" }}
loads.pull = {{ type = "force", at = "pin.P", force = [100, 0] }}
{MATERIALS}"""


def joint(text):
    return rt.loads(text).model.joints["O"]


def oiled(oil, c="5e-5"):
    contact = f'{{ model = "lubricated", film = "short", {oil}, length = 0.01, bush_radius = 0.01 }}'
    return loose(f"clearance = {c}", contact)


def refused(text, words):
    with pytest.raises(ModelError, match=words):
        rt.loads(text)


# ---------------------------------------------------------------- fits
def test_a_fit_is_its_mean_play_and_two_diameters():
    m = rt.loads(loose(f"clearance = {FIT}"))
    assert m.model.joints["O"].clearance == pytest.approx(8.5e-6, abs=1e-15)
    bore, pin = (m.model.parameters[f"O.{name}"] for name in ("bore", "pin"))
    assert [bore.value, bore.tol] == pytest.approx([7.5e-6, 7.5e-6], abs=1e-15)  # H7: 0 to 15 um
    assert [pin.value, pin.tol] == pytest.approx([-9.5e-6, 4.5e-6], abs=1e-15)  # g6: -14 to -5 um


def test_diameters_are_set_and_written_as_parameters():
    m = rt.loads(loose(f"clearance = {FIT}")).set({"O.bore": "12 um"})
    assert m.model.joints["O"].clearance == pytest.approx((12e-6 + 9.5e-6) / 2, abs=1e-15)
    again = rt.loads(m.to_toml())
    assert again.model.joints["O"].clearance == m.model.joints["O"].clearance
    assert again.model.parameters["O.bore"].tol == pytest.approx(7.5e-6, abs=1e-15)


def test_the_range_of_a_size_follows_the_parameter():
    m = rt.loads(loose('clearance = { fit = "H7/g6", diameter = "d" }'))
    assert m.set(d="8 mm").model.joints["O"].clearance == pytest.approx(8.5e-6, abs=1e-15)
    assert m.set(d="20 mm").model.joints["O"].clearance == pytest.approx(12e-6, abs=1e-15)
    assert m.parameters_where({"d": 0.02})["O.bore"] == pytest.approx(10.5e-6, abs=1e-15)


def test_made_parts_have_the_spread_of_two_diameters():
    """The sum of two uniform distributions, of 15 and 9 um: sd hypot(15, 9)/sqrt(48) um, not that of one of 6 um."""
    table = rt.loads(loose(f"clearance = {FIT}")).ensemble(512, ["max(hypot(O.ex, O.ey))"], t_end=1e-6).table
    play = 1e6 * np.asarray(table["max(hypot(O.ex, O.ey))"])
    assert play.std() == pytest.approx(math.hypot(15, 9) / math.sqrt(48), rel=0.03)
    assert (play < 6.0).mean() == pytest.approx(7**2 / (2 * 15 * 9), abs=0.02)  # a corner of the rectangle of both
    assert play.min() >= 2.5
    assert play.max() <= 14.5


def test_a_tolerance_may_be_changed_in_a_study():
    m = rt.loads(loose(f"clearance = {FIT}"))
    table = m.ensemble(64, ["max(O.ex)"], t_end=1e-6, vary={"O.pin": "1 um"}).table
    assert np.ptp(np.asarray(table["O.pin"])) <= 2.0e-6


def test_the_contact_takes_the_radius_of_the_fit():
    materials = 'bush_material = "bronze", pin_material = "iron"'
    contact = f'{{ model = "hertz", geometry = "johnson", {materials}, length = 0.01, restitution = 0.5 }}'
    assert joint(loose(f"clearance = {FIT}", contact)).contact.bush_radius == pytest.approx(4e-3)


@pytest.mark.parametrize("contact", ['"ideal"', '"massless-link"', '{ model = "impact", restitution = 0.5 }'])
def test_the_radius_of_a_joint_is_that_of_its_fit_whatever_its_contact(contact):
    assert joint(loose(f"clearance = {FIT}", contact)).radius == pytest.approx(4e-3)


def test_a_guide_has_a_fit_of_its_widths_and_no_bush():
    guide = 'type = "prismatic", axis = 0, block = { length = "20 mm", height = "8 mm" }'
    text = loose(f"clearance = {FIT}", '{ model = "impact", restitution = 0.5 }')
    block = joint(text.replace('type = "revolute"', guide).replace('drivers.hold = { body = "pin"', "# {"))
    assert block.clearance == pytest.approx(8.5e-6)
    assert math.isnan(block.radius)


@pytest.mark.parametrize(("written", "right"), [("4 mm", True), ("4.03 mm", True), ("8 mm", False), ("3.9 mm", False)])
def test_the_radius_of_a_contact_is_that_of_the_fit(written, right):
    text = loose(f"clearance = {FIT}", f'{{ model = "impact", restitution = 0.5, bush_radius = "{written}" }}')
    if right:
        assert joint(text).radius == pytest.approx(4e-3, rel=0.01)
    else:
        refused(text, "bush_radius: half of the diameter of the fit is 4 mm, not")


# ---------------------------------------------------------------- heat
def test_play_follows_heat_by_the_difference_of_expansions():
    warm = joint(loose(f"clearance = {FIT[:-1]}, {WARM} }}")).clearance
    assert warm == pytest.approx(8.5e-6 + 4e-3 * (18e-6 - 11.5e-6) * 60.0, abs=1e-15)
    swapped = WARM.replace("bronze", "x").replace("iron", "bronze").replace("x", "iron")
    cool = joint(loose(f"clearance = {FIT[:-1]}, {swapped} }}")).clearance
    assert warm + cool == pytest.approx(17e-6, abs=1e-15)


def test_a_stated_play_follows_heat_by_the_radius_of_its_bush():
    contact = '{ model = "impact", restitution = 0.5, bush_radius = "10 mm" }'
    warm = joint(loose(f"clearance = {{ radial = 3e-5, {WARM} }}", contact)).clearance
    assert warm == pytest.approx(3e-5 + 0.01 * 6.5e-6 * 60.0, abs=1e-15)


@pytest.mark.parametrize(
    ("clearance", "words"),
    [
        ('{ fit = "H7/p6", diameter = "8 mm" }', "interference"),
        ('{ fit = "H7/g6" }', "needs diameter"),
        ('{ fit = "H7/g6", diameter = "8 kg" }', "is a mass"),
        ('{ fit = "H7/g6", diameter = "8 mm", diametre = 1 }', "did you mean 'diameter'"),
        ('{ fit = "H7/g6", diameter = "8 mm", radial = 1e-5 }', "a fit or a radial play, not both"),
        ("{ }", "needs fit"),
        ('{ fit = "H7/g6", diameter = "8 mm", dist = "even" }', "unknown distribution"),
        (f"{FIT[:-1]}, bush_material = 'bronze' }}", "needs pin_material too"),
        (f"{FIT[:-1]}, temperature = '80 degC' }}", "needs bush_material and pin_material"),
        (f"{FIT[:-1]}, {WARM.replace('bronze', 'bronz')} }}", "did you mean 'bronze'"),
        (f"{FIT[:-1]}, {WARM.replace('bronze', 'plain')} }}", "expansion of 'plain' is not known"),
        (f"{FIT[:-1]}, {WARM.replace('80 degC', '80 mm')} }}", "is a length"),
        (f"{FIT[:-1]}, {WARM.replace('80 degC', '80 K')} }}", "a number is kelvin"),
        (f"{FIT[:-1]}, {WARM.replace('80 degC', '-300 degC')} }}", "below|cold|zero"),
        (f"{FIT[:-1]}, {WARM.replace('80 degC', '-150 degC')} }}", "kelvin"),
        ("{ radial = 3e-5, " + WARM + " }", "needs the radius of the bush"),
        (SHUT, "no play left at 120 degC"),
    ],
)  # fmt: skip
def test_what_is_no_play_is_refused(clearance, words):
    refused(loose(f"clearance = {clearance}").replace("60 degC", "120 degC"), words)


# ---------------------------------------------------------------- rolling bearings
def test_a_rolling_bearing_is_half_its_radial_movement():
    m = rt.loads(loose('bearing = "6208 C3"'))
    assert m.model.joints["O"].clearance == pytest.approx(12e-6, abs=1e-15)  # 15 to 33 um
    assert m.model.parameters["O.play"].tol == pytest.approx(4.5e-6, abs=1e-15)
    assert joint(loose('bearing = { bore = "40 mm", group = "C3" }')).clearance == pytest.approx(12e-6, abs=1e-15)


@pytest.mark.parametrize(
    ("play", "name", "words"),
    [
        (f"clearance = {FIT}", "O.bor", "did you mean 'O.bore'"),
        (f"clearance = {FIT}", "O.play", "its play is O.bore and O.pin"),
        ('bearing = "6208 C3"', "O.bore", "its play is O.play"),
    ],
)
def test_what_the_play_of_a_joint_is_called_is_said(play, name, words):
    with pytest.raises(ModelError, match=words):
        rt.loads(loose(play)).set({name: "1 um"})


def test_the_path_of_a_diameter_may_be_whole():
    m = rt.loads(loose(f"clearance = {FIT}"))
    assert m.set({"parameters.O.bore": "12 um"}).parameters["O.bore"] == m.set({"O.bore": "12 um"}).parameters["O.bore"]


@pytest.mark.parametrize(
    ("play", "name", "value", "words"),
    [
        (f"clearance = {FIT}", "O.bore", "12e-6 N", "'12e-6 N' is a force; expected a length in m"),
        (f"clearance = {FIT}", "O.pin", "3 rad", "expected a length in m"),
        ('bearing = "6208 C3"', "O.play", "20 degC", "'20 degC' is a temperature; expected a length in m"),
    ],
)
def test_what_is_no_length_is_no_diameter_and_no_play(play, name, value, words):
    with pytest.raises(ModelError, match=words):
        rt.loads(loose(play)).set({name: value})


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('bearing = "6208 C9"', "C9"),
        ('bearing = "6224"', "100 mm"),
        ('bearing = "6208", clearance = 1e-5', "leave one of them out"),
        ('bearing = { bore = "40 mm", grup = "C3" }', "did you mean 'group'"),
        ("bearing = 6208", "bearing"),
    ],
)
def test_what_is_no_rolling_bearing_is_refused(text, words):
    refused(loose(text), words)


# ---------------------------------------------------------------- oils
def test_an_oil_is_its_viscosity_and_density():
    film = joint(oiled('oil = "ISO VG 46", temperature = "60 degC"')).contact.film
    oil = rt.oil("ISO VG 46")
    assert film.law.values["viscosity"] == pytest.approx(oil.viscosity("60 degC"), rel=1e-12)
    assert film.law.values["viscosity"] == pytest.approx(17.41221e-3, rel=1e-6)
    assert film.density == pytest.approx(oil.density("60 degC"), rel=1e-12)


def test_the_temperature_of_an_oil_may_be_a_parameter():
    m = rt.loads(oiled('oil = "ISO VG 46", temperature = "T"'))
    for warm in ("20 degC", "100 degC"):
        film = m.set(T=warm).model.joints["O"].contact.film
        assert film.law.values["viscosity"] == pytest.approx(rt.oil("ISO VG 46").viscosity(warm), rel=1e-12)


@pytest.mark.parametrize(
    ("oil", "words"),
    [
        ('oil = "ISO VG 47", temperature = "60 degC"', "did you mean ISO VG 46"),
        ('oil = "ISO VG 46"', "needs temperature"),
        ('oil = "ISO VG 46", temperature = "60 degC", viscosity = 0.05', "leave one of them out"),
        ('oil = "ISO VG 46", temperature = "60 degC", density = 870', "leave one of them out"),
        ('viscosity = 0.05, temperature = "60 degC"', "name it"),
        ('oil = { vg = 46, vy = 95 }, temperature = "60 degC"', "unknown key 'vy'"),
        ('oil = "ISO VG 46", temperature = 60', "kelvin"),
        ('oil = "ISO VG 46", temperature = "250 degC"', "outside"),
    ],
)
def test_what_is_no_oil_is_refused(oil, words):
    refused(oiled(oil), words)


# ---------------------------------------------------------------- what is said
def test_check_names_every_figure_with_its_source():
    told = str(rt.loads(loose(f"clearance = {FIT}")).check())
    assert "H7/g6 of 8 mm: radial play 2.5 to 14.5 um (ISO 286)" in told
    told = str(rt.loads(oiled('oil = "ISO VG 46", temperature = "60 degC"')).check())
    assert "ISO VG 46 at 60 degC: 17.41 mPa*s" in told
    assert "assumed: viscosity index 95" in told
    assert "6208 C3: radial play 7.5 to 16.5 um" in str(rt.loads(loose('bearing = "6208 C3"')).check())


@pytest.mark.parametrize(
    ("clearance", "words"),
    [
        ('"H7/g6 8 mm"', 'a fit is written as { fit = "H7/g6", diameter = "8 mm" }'),
        ('"H7/g6"', "a fit is written as"),
        ('{ radial = "10 um", dist = "normal" }', "both diameters of a fit"),
    ],
)
def test_other_ways_to_write_a_play_are_led_to_the_right_one(clearance, words):
    refused(loose(f"clearance = {clearance}"), words)


def test_a_diameter_of_a_fit_that_is_gone_is_told():
    m = rt.loads(loose(f"clearance = {FIT}")).set({"O.bore": "12 um"})
    with pytest.raises(ModelError, match="of a fit or a bearing that joint 'O' has not"):
        m.set({"joints.O.clearance": "0.1 mm"})


def test_diameters_may_be_made_together():
    groups = '\n[tolerances]\ngroups = [["O.bore", "O.pin"]]\n'
    table = rt.loads(loose(f"clearance = {FIT}") + groups).ensemble(32, ["max(O.ex)"], t_end=1e-6).table
    assert abs(np.corrcoef(table["O.bore"], table["O.pin"])[0, 1]) > 0.999


def test_a_guide_is_as_wide_as_its_block_is_high():
    guide = f"""
format = 1
ground.points.O = [0, 0]
bodies.b = {{ points = {{ P = [0, 0] }}, mass = 1, inertia = 1e-3 }}
[joints.G]
type = "prismatic"
connect = ["ground.O", "b.P"]
block = {{ length = "40 mm", height = "20 mm" }}
clearance = {{ radial = "30 um", {WARM} }}
contact = {{ model = "impact", restitution = 0.5 }}
{MATERIALS}"""
    assert rt.loads(guide).model.joints["G"].clearance == pytest.approx(30e-6 + 0.01 * 6.5e-6 * 60)


# ---------------------------------------------------------------- what names stand for
def test_materials_of_plays_and_contacts_are_looked_up_with_their_source():
    contact = """{ model = "hunt-crossley", bush_material = "bronze", pin_material = "steel", geometry = "johnson",
        length = 0.01, restitution = 0.5, friction = 0 }""".replace("\n", "")
    m = rt.loads(
        loose(f"clearance = {{ fit = 'H7/f7', diameter = '60 mm', {WARM.replace('iron', 'steel')} }}", contact)
    )
    named = "\n".join(m.check().named)
    assert "O.clearance.bush_material, O.contact.bush_material, bronze: E 110 GPa" in named
    assert "O.clearance.pin_material, O.contact.pin_material, steel: E 207 GPa" in named
    assert "expansion 11.5e-6/K" in named
