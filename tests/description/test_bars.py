"""Bars of a section and material: mass, centre and inertia by elementary mechanics; what contradicts itself refused."""

import math

import pytest

import rattle as rt
from rattle.errors import ModelError

pytestmark = pytest.mark.nojit
IRON = '[materials.iron]\nE = "210 GPa"\ndensity = 7850\n'
SQUARE = 'section = { shape = "rectangle", width = "10 mm", height = "20 mm" }'


def text(body, material=IRON):
    return f"""
format = 1
ground.points.O = [0, 0]
[bodies.rod]
bar = ["A", "B"]
length = 0.3
{body}
[joints.A]
type = "revolute"
connect = ["ground.O", "rod.A"]
{material}"""


def rod(body):
    return rt.loads(text(body)).model.bodies["rod"]


def test_section_and_material_say_the_mass():
    body = rod(f'{SQUARE}\nmaterial = "iron"')
    assert body.mass == pytest.approx(2e-4 * 7850 * 0.3)
    assert body.inertia == pytest.approx(body.mass * 0.3**2 / 12)
    assert rod(f'{SQUARE}\nmaterial = "steel"').mass == pytest.approx(body.mass)


@pytest.mark.parametrize(
    ("section", "area", "inertia", "modulus"),
    [
        ('{ shape = "rectangle", width = "10 mm", height = "20 mm" }', 2e-4, 0.01 * 0.02**3 / 12, 0.01 * 0.02**2 / 6),
        ('{ shape = "round", diameter = "12 mm" }', math.pi * 36e-6, math.pi * 0.012**4 / 64, math.pi * 0.012**3 / 32),
        ('{ shape = "tube", diameter = "12 mm", wall = "2 mm" }', math.pi * 20e-6, math.pi * (0.012**4 - 0.008**4) / 64,
         math.pi * (0.012**4 - 0.008**4) / 32 / 0.012),
        ("{ area = 3e-4, inertia = 2e-9, modulus = 4e-7 }", 3e-4, 2e-9, 4e-7),
    ],
)  # fmt: skip
def test_sections_are_those_of_the_handbook(section, area, inertia, modulus):
    found = rod(f"mass = 1\nsection = {section}").beam.section
    assert [found.area, found.inertia, found.modulus] == pytest.approx([area, inertia, modulus])


def test_a_tapering_bar_has_the_centre_and_inertia_of_its_line():
    """2 to 1 kg/m over L: m = 1.5 L, centre 4 L/9, inertia about the end L^3 (2/3 - 1/4)."""
    body = rod("mass_per_length = [[0, 2.0], [0.3, 1.0]]")
    assert body.mass == pytest.approx(1.5 * 0.3)
    assert -body.points["A"][0] == pytest.approx(4 * 0.3 / 9)
    assert body.inertia == pytest.approx(0.3**3 * (2 / 3 - 1 / 4) - body.mass * (4 * 0.3 / 9) ** 2)


def test_a_given_inertia_is_a_uniform_bar_with_masses_at_its_ends():
    beam = rod("mass = 1.2\ninertia = 0.015").beam
    (_, line), _ = beam.line
    ends = sum(beam.at_ends)
    assert line * 0.3 + ends == pytest.approx(1.2)
    assert line * 0.3**3 / 12 + ends * 0.15**2 == pytest.approx(0.015)
    assert beam.physical
    assert not rod("mass = 1.2\ninertia = 0.005").beam.physical


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("", "needs a mass in kg$|needs a mass in kg\n"),
        (SQUARE, "a section and a material whose density is known"),
        (f'{SQUARE}\nmaterial = "glass"', "whose density is known"),
        (f'{SQUARE}\nmaterial = "iorn"', "did you mean 'iron'"),
        ('mass = 1\nsection = { shape = "tube", diameter = "12 mm", wall = "7 mm" }', "half of the diameter"),
        ('mass = 1\nsection = { shape = "triangle" }', "unknown section"),
        ("mass = 1\nsection = { area = 1e-4 }", "needs inertia"),
        ("mass = 1\nmass_per_length = [[0, 1], [0.3, 1]]", "leave this out"),
        ("mass_per_length = [[0, 1], [0.2, 1]]", "from 0 to the length"),
        ("mass_per_length = [[0, 1], [0.2, 1], [0.2, 2], [0.3, 1]]", "x must increase"),
        ("mass_per_length = [[0, 0], [0.3, 0]]", "0 everywhere"),
        ("mass_per_length = [[0, 1]]", "expected pairs"),
    ],
)
def test_what_says_no_bar_is_refused(body, words):
    with pytest.raises(ModelError, match=words):
        rt.loads(text(body))


@pytest.mark.parametrize(
    ("material", "words"),
    [
        ("[materials.iron]\nE = 1e11\nnu = 0.7\n", "Poisson"),
        ("[materials.iron]\nE = 1e11\nyield = 5e8\nultimate = 4e8\n", "above the ultimate strength"),
        ("[materials.iron]\ndensity = 1\n", "needs E"),
        ("[materials.iron]\nE = 1e11\nhardness = 1\n", "unknown key"),
    ],
)
def test_what_is_no_material_is_refused_once(material, words):
    with pytest.raises(ModelError, match=words) as caught:
        rt.loads(text('mass = 1\nmaterial = "iron"', material))
    assert len(caught.value.problems) == 1


def test_strength_is_never_known_by_the_name_of_a_family():
    known = rt.loads(text('mass = 1\nmaterial = "steel"')).model.bodies["rod"].beam.material
    assert known.density == 7850.0
    assert math.isnan(known.yield_strength)
    assert math.isnan(known.ultimate)
    assert math.isnan(known.endurance)


# ---------------------------------------------------------------- duty, wear that is allowed
DUTY = text("mass = 1") + "parameters.load = 400\n"


def test_duty_cases_hold_their_shares_and_changes():
    cases = (
        'duty.cases = [{ share = 7, set = { load = 400 } }, { share = 3, set = { load = "1 kN" }, name = "hard" }]\n'
    )
    first, second = rt.loads(cases + DUTY.replace("parameters.load", "\n[parameters]\nload")).model.duty
    assert (first.share, second.share, second.name) == (7.0, 3.0, "hard")
    assert second.changes == {"load": "1 kN"}


@pytest.mark.parametrize(
    ("cases", "words"),
    [
        ("[]", "an empty list"),
        ("[{ share = -1 }]", "must be positive"),
        ("[{ share = 1, set = { lod = 1 } }]", "did you mean 'load'"),
        ("[1]", "expected a case"),
        ("[{ shore = 1 }]", "did you mean 'share'"),
    ],
)
def test_what_is_no_duty_is_refused(cases, words):
    with pytest.raises(ModelError, match=words):
        rt.loads(f"duty.cases = {cases}\n" + DUTY.replace("parameters.load", "\n[parameters]\nload"))


def test_a_tight_pin_may_wear_by_its_length_and_radius():
    more = "friction = { model = 'coulomb', mu = 0.1, pin_radius = 0.01 }\nlength = 0.015\n"
    more += "wear = { bush = 1e-15, pin = 2e-15, limit = '0.1 mm' }\n"
    joint = rt.loads(text("mass = 1", more)).model.joints["A"]
    assert joint.wears.rate == pytest.approx(3e-15)
    assert (joint.wears.limit, joint.radius, joint.length) == (pytest.approx(1e-4), 0.01, 0.015)
    assert joint.wear is None  # no profile: nothing to march
    with pytest.raises(ModelError, match="radius of the pin"):
        rt.loads(text("mass = 1", "length = 0.015\nwear = { bush = 1e-15 }\n"))
    with pytest.raises(ModelError, match="needs a clearance of the joint, or for its life"):
        rt.loads(text("mass = 1", "wear = { bush = 1e-15 }\n"))
