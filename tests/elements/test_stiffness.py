"""Static contact forces: published values, inverse, growth, limits; materials."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rattle import registry
from rattle.elements.contact_laws.stiffness import penetration, sphere_stiffness
from rattle.language.materials import MATERIALS, contact_modulus, material

pytestmark = pytest.mark.nojit
LAWS = registry.kinds("stiffness")
STEEL = {"E": 207e9, "nu": 0.3}
PIN = {"bush_radius": 0.01, "clearance": 5e-4, "length": 0.015, "bush_material": STEEL, "pin_material": STEEL}
PIN |= {"elements": 9.0, "element_stiffness": 8e9, "exponent": 1.5}  # of a rolling bearing
PIN["foundation"] = 1e14  # [Pa/m]
POWER = {"stiffness": 6e10, "exponent": 1.5}
E_STAR = 207e9 / (2 * (1 - 0.3**2))


def force(name, delta, values=PIN):
    found = LAWS[name]
    return found.kernel.python(delta, np.array(found.leaf.pack(values)), 0)


def depth(name, load, values=PIN):
    found = LAWS[name]
    return penetration(found.kernel, np.array(found.leaf.pack(values)), load)


# independent reference (eight digits), steel pin 9.5 mm in a bush of 10 mm, 15 mm long, 1000 N
@pytest.mark.parametrize(
    ("name", "want"),
    [("sphere", 6.1167916e-6), ("johnson", 1.5448284e-6), ("esdu-78035", 1.9179840e-6), ("liu", 5.2010540e-6)],
)
def test_penetration_at_1000_newton(name, want):
    assert depth(name, 1000.0) == pytest.approx(want, rel=4e-8)
    assert force(name, want) == pytest.approx(1000.0, rel=8e-8)


def test_stiffness_of_the_sphere():
    K, n = sphere_stiffness(0.01, 0.0095, STEEL, "steel")
    assert pytest.approx(6.6101983979e10, rel=1e-10) == K  # independent reference
    assert n == 1.5


@pytest.mark.parametrize("load", [1e-6, 1.0, 1e3, 3e4])
def test_line_contacts_satisfy_their_formula_as_printed(load):
    q, play, R = load / (math.pi * E_STAR * 0.015), 5e-4, 0.01 * 0.0095 / 5e-4  # L = 15 mm
    b = 1.6 * math.sqrt(load * R / (0.015 * E_STAR))
    thetas = 2 * (1 - 0.3**2) / (math.pi * 207e9)
    ratio = 0.015**3 * play / (load * 0.01 * 0.0095 * thetas)
    printed = {
        "johnson": q * (math.log(4 * math.pi * E_STAR * 0.015 * play / load) - 1),
        "radzimovsky": q * (2 / 3 + math.log(4 * 0.01 / b) + math.log(4 * 0.0095 / b)),
        "esdu-78035": load * thetas / 0.015 * (math.log(4 * 0.015 * play / (load * thetas)) + 1),
        "dubowsky-freudenstein": load * thetas / 0.015 * (math.log(ratio) + 1),
    }
    for name, delta in printed.items():
        assert force(name, delta) == pytest.approx(load, rel=1e-11)  # rounding of the logarithms


def test_pereira_is_continuous_between_its_branches_and_close_to_johnson():
    below = {**PIN, "clearance": 0.349539e-3}
    above = {**PIN, "clearance": 0.349541e-3}
    assert force("pereira", 1e-6, below) == pytest.approx(force("pereira", 1e-6, above), rel=2e-5)
    for clearance in (1e-4, 5e-4, 2e-3):
        values = {**PIN, "clearance": clearance}
        ratio = [depth("pereira", load, values) / depth("johnson", load, values) for load in (100.0, 1e3, 1e4)]
        # a power law fitted to a logarithm: near it in the middle of its range, and off by an eighth at most, where
        # a factor or exponent mistaken (E*, L, mm) would be off by far more
        assert ratio[1] == pytest.approx(1.0, abs=0.06)
        assert ratio == pytest.approx([1.0, 1.0, 1.0], abs=0.13)


def test_pereira_in_millimetres_by_hand():
    # dR = 0.5 mm: n = (0.0151*0.5 + 1.151)*0.5^-0.005; F = (0.965*0.5 + 0.0965)*15 mm*E* [MPa]/0.5 * (1e-3 mm)^n
    n = (0.0151 * 0.5 + 1.151) * 0.5**-0.005
    assert force("pereira", 1e-6) == pytest.approx(0.579 * 15 * E_STAR * 1e-6 / 0.5 * 1e-3**n, rel=1e-12)


@given(st.sampled_from(sorted(LAWS)), st.floats(1e-18, 0.1), st.floats(1.0000001, 10.0))
def test_force_grows_with_penetration_however_deep(name, delta, ratio):
    values = POWER if name == "power" else PIN
    less, more = force(name, delta, values), force(name, delta * ratio, values)
    assert 0.0 < less < more < math.inf


@given(st.sampled_from(sorted(LAWS)), st.floats(1e-6, 1e6))
def test_penetration_is_the_inverse_of_the_force(name, load):
    values = POWER if name == "power" else PIN
    assert force(name, depth(name, load, values), values) == pytest.approx(load, rel=1e-12)


@pytest.mark.parametrize("name", ["johnson", "radzimovsky", "esdu-78035", "dubowsky-freudenstein"])
def test_line_contacts_go_on_smoothly_where_their_formula_turns_round(name):
    c, scale = LAWS[name].leaf.pack(PIN)
    turn = 2 * math.exp(-2) * c * scale
    h = 1e-6 * turn
    assert force(name, turn) == pytest.approx(scale * math.exp(-2), rel=1e-12)
    before = (force(name, turn) - force(name, turn - h)) / h
    after = (force(name, turn + h) - force(name, turn)) / h
    assert before == pytest.approx(after, rel=1e-5)  # h times the curvature


@pytest.mark.parametrize("name", sorted(LAWS))
def test_there_is_no_force_without_penetration(name):
    values = POWER if name == "power" else PIN
    assert force(name, 0.0, values) == force(name, -1e-6, values) == 0.0
    assert 0.0 <= force(name, 5e-324, values) < 1e-200


@pytest.mark.parametrize("name", ["sphere", "johnson", "radzimovsky", "esdu-78035", "dubowsky-freudenstein"])
def test_a_contact_too_wide_for_its_formula_is_told(name):
    leaf = LAWS[name].leaf
    assert leaf.notes(PIN, 1000.0) == []
    (note,) = leaf.notes(PIN, 1.01 * leaf.limit(PIN))
    assert "assumes a narrow contact" in note


def test_sphere_limit_is_a_contact_half_as_wide_as_the_pin():
    load = LAWS["sphere"].leaf.limit(PIN)
    radius = (3 * load * 0.01 * 0.0095 / 5e-4 / (4 * E_STAR)) ** (1 / 3)
    assert radius == pytest.approx(0.0095 / 2, rel=1e-12)


def test_clearance_outside_a_fit_is_told():
    assert LAWS["pereira"].leaf.notes(PIN) == []
    assert "0.005" in LAWS["pereira"].leaf.notes({**PIN, "clearance": 1e-6})[0]
    assert math.isfinite(force("pereira", 1e-6, {**PIN, "clearance": 1e-7}))
    assert LAWS["liu"].leaf.notes(PIN) == []
    assert "25%" in LAWS["liu"].leaf.notes({**PIN, "clearance": 0.002})[0]


def test_play_is_needed_for_stiffness_from_geometry():
    for clearance in (0.0, 0.01, -1e-3):
        with pytest.raises(ValueError, match="clearance"):
            LAWS["sphere"].leaf.pack({**PIN, "clearance": clearance})
    with pytest.raises(ValueError, match="no clearance"):
        sphere_stiffness(0.01, 0.01, STEEL, STEEL)


def test_materials_are_found_by_name_or_given():
    assert material("steel")[:2] == (207e9, 0.3)
    assert material("POM") == material("acetal")
    assert material("Stainless-Steel") == MATERIALS["stainless steel"]
    assert material(STEEL).E == 207e9
    assert material(material(STEEL)) == material(STEEL)
    assert contact_modulus("steel", STEEL) == pytest.approx(E_STAR, rel=1e-15)
    for found in MATERIALS.values():
        assert found.E > 0
        assert 0 < found.nu <= 0.5
        assert found.source


@pytest.mark.parametrize(
    ("given_material", "message"),
    [
        ("stel", "did you mean 'steel'"),
        ("xyzzy", "known: steel"),
        ({"E": 2e11}, "E, nu"),
        ({"E": 2e11, "nu": 0.3, "rho": 7800}, "rho"),
        ({"E": -1.0, "nu": 0.3}, "must be positive"),
        ({"E": math.nan, "nu": 0.3}, "must be positive"),
        ({"E": 2e11, "nu": 0.6}, "Poisson"),
    ],
)
def test_bad_materials_are_refused(given_material, message):
    with pytest.raises(ValueError, match=message):
        material(given_material)
