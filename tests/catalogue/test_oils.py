"""Oils: the law against figures computed by hand, grades and indices against examples of the standards, refusals."""

import itertools
import math

import pytest

import rattle as rt
from rattle.catalogue.oils import viscosity_index
from rattle.catalogue.tables import rows

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
TWO_POINTS = {"nu40": "46 mm^2/s", "nu100": "6.8 mm^2/s"}


@pytest.mark.parametrize(("celsius", "nu"), [(20, 133.83818), (40, 46.0), (60, 20.62274756), (100, 6.8)])
def test_two_points_give_the_law(celsius, nu):
    assert rt.oil(TWO_POINTS).kinematic(f"{celsius} degC") == pytest.approx(nu * 1e-6, rel=1e-7)


@pytest.mark.parametrize(
    ("grade", "index", "celsius", "nu"),
    [
        (46, 95, 40, 46.0), (46, 95, 60, 20.38280), (46, 95, 80, 10.89559), (46, 95, 100, 6.643921),
        (46, 140, 100, 7.82498), (100, 95, 60, 39.61891), (10, 95, 100, 2.63709), (220, 95, 20, 861.464),
    ],
)  # fmt: skip
def test_a_grade_and_an_index_give_the_second_point(grade, index, celsius, nu):
    oil = rt.oil({"vg": grade, "vi": index})
    assert oil.kinematic(f"{celsius} degC") == pytest.approx(nu * 1e-6, rel=2e-6)
    assert viscosity_index(oil.nu40 * 1e6, oil.nu100 * 1e6) == pytest.approx(index, abs=1e-6)


@pytest.mark.parametrize(("nu40", "nu100", "index"), [(73.30, 8.86, 92), (22.83, 5.05, 156)])
def test_the_index_is_that_of_the_examples_of_the_standard(nu40, nu100, index):
    assert round(rt.oil({"nu40": nu40 * 1e-6, "nu100": nu100 * 1e-6}).vi) == index


def test_the_constants_of_the_index_join():
    table = [{key: float(value) for key, value in row.items()} for row in rows("d2270_constants")]
    for before, after in itertools.pairwise(table):
        Y = after["least"]
        for a, b, c in ("abc", "def"):
            left, right = ((row[a] * Y + row[b]) * Y + row[c] for row in (before, after))
            assert left == pytest.approx(right, rel=2e-3)


def test_viscosity_is_density_times_kinematic_viscosity_and_a_number_is_kelvin():
    oil = rt.oil("ISO VG 46")
    assert oil.viscosity("60 degC") == pytest.approx(17.41221e-3, rel=1e-6)
    assert oil.viscosity("75 degC") == oil.kinematic("75 degC") * oil.density("75 degC")
    assert oil.viscosity(333.15) == oil.viscosity("60 degC") == oil.viscosity("333.15 K")
    assert oil.viscosity("-30 degC") > oil.viscosity("200 degC") > 0.0


def test_density_falls_from_that_at_15_degrees():
    oil = rt.oil({"vg": 46, "density": "870 kg/m^3"})
    assert oil.density("15 degC") == pytest.approx(870.0)
    assert oil.density("100 degC") == pytest.approx(870 * (1 - 0.00065 * 85))


def test_what_is_typical_is_said():
    assert [words.split(",")[0] for words in rt.oil("ISO VG 46").assumed] == [
        "viscosity index 95", "density 880 kg/m^3 at 15 degC",
    ]  # fmt: skip
    assert rt.oil({"vg": 46, "vi": 95, "density": 870}).assumed == ()
    assert rt.oil({**TWO_POINTS, "density": 870}).assumed == ()
    thin = rt.oil({"nu40": "3 mm^2/s", "nu100": "1.2 mm^2/s", "density": 850})
    assert math.isnan(thin.vi)
    assert "without its corrections" in thin.assumed[0]


@pytest.mark.parametrize("name", ["ISO VG 46", "iso vg 46", "VG46", "ISO-VG-46", {"vg": "46"}, {"vg": "ISO VG 46"}])
def test_a_grade_has_several_spellings(name):
    assert rt.oil(name) == rt.oil({"vg": 46})


def test_oils_of_every_grade_are_thinner_when_they_are_warmer():
    for row in rows("iso3448_grades"):
        for index in (0, 95, 200, 400):
            if float(row["grade"]) < 10:
                continue
            oil = rt.oil({"vg": float(row["grade"]), "vi": index})
            curve = [oil.kinematic(f"{celsius} degC") for celsius in range(-30, 201, 10)]
            assert curve == sorted(curve, reverse=True)


@pytest.mark.parametrize(
    ("written", "words"),
    [
        ("ISO VG 47", "did you mean ISO VG 46"),
        ({"vg": 90}, "did you mean ISO VG 100"),
        ({"vg": 0}, "no grade"),
        ({"vg": math.nan}, "not a finite number"),
        ({"vg": True}, "plain number"),
        ("VG", "not known"),
        ("SAE 30", "a range of viscosities"),
        ("ISO VG 5", "give nu40 and nu100"),
        ({"vg": 46, "nu40": "46 mm^2/s"}, "two ways"),
        ({"nu40": "6.8 mm^2/s", "nu100": "46 mm^2/s"}, "are they swapped"),
        ({"nu40": "46 mm^2/s", "nu100": "46 mm^2/s"}, "not less than"),
        ({"nu40": "46 mm^2/s"}, "one point of two"),
        ({"nu100": "6.8 mm^2/s"}, "one point of two"),
        ({"nu40": 46, "nu100": 6.8}, "a number is in m"),
        ({"nu40": "46 Pa*s", "nu100": "6.8 mm^2/s"}, "is a dynamic viscosity"),
        ({"nu40": "46 mm^2/s", "nu100": "0.2 mm^2/s"}, "outside"),
        ({"vg": 46, "vi": -1}, "outside 0 ... 400"),
        ({"vg": 46, "vi": 401}, "outside 0 ... 400"),
        ({"vi": 95}, "needs a grade"),
        ({}, "viscosity is missing"),
        ({"vg": 46, "dens": 870}, "did you mean 'density'"),
        ({"vg": 46, "density": "0.87 kg/m^3"}, "those of liquids"),
        ({"vg": 46, "density": "870 kg"}, "is a mass"),
        (46, "expected"),
        (None, "expected"),
    ],
)
def test_what_is_no_oil_is_refused_with_the_reason(written, words):
    with pytest.raises(rt.InputError, match=words):
        rt.oil(written)


@pytest.mark.parametrize(
    ("temperature", "words"),
    [
        (60, "a number is kelvin; write '60 degC'"),
        ("60", "a number is kelvin; write '60 degC'"),
        ("60 mm", "is a length"),
        ("-300 degC", "absolute zero"),
        ("900 degC", "outside -30 ... 230 degC"),
        ("-30.1 degC", "outside -30 ... 230 degC"),
        (math.nan, "outside"),
        (True, "expected a temperature"),
        (None, "temperature"),
    ],
)
def test_temperatures_outside_the_law_are_refused(temperature, words):
    oil = rt.oil("ISO VG 46")
    for value in (oil.kinematic, oil.density, oil.viscosity):
        with pytest.raises(rt.InputError, match=words):
            value(temperature)
