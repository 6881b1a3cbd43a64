"""Quantities: values against the definitions of the units, and what is no quantity."""

import contextlib
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rattle.language.units import (
    DIMENSIONLESS,
    DYNAMIC_VISCOSITY,
    FORCE,
    KINEMATIC_VISCOSITY,
    LENGTH,
    MASS,
    MOMENT,
    PRESSURE,
    RATE,
    TIME,
    Dimension,
    QuantityError,
    describe,
    dimension_of,
    parse_quantity,
    unit_name,
)

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
INERTIA = Dimension(2, 1, 0)


@pytest.mark.parametrize(
    ("text", "value", "dimension"),
    [
        ("5 mm", 0.005, LENGTH),
        ("5mm", 0.005, LENGTH),
        ("  -.5 cm ", -0.005, LENGTH),
        ("5 um", 5e-6, LENGTH),
        ("5 µm", 5e-6, LENGTH),
        ("5 \u03bcm", 5e-6, LENGTH),
        ("3 nm", 3e-9, LENGTH),
        ("1 in", 0.0254, LENGTH),
        ("2 ft", 0.6096, LENGTH),
        ("1e-3 t", 1.0, MASS),
        ("250 g", 0.25, MASS),
        ("1 lb", 0.45359237, MASS),
        ("2 min", 120.0, TIME),
        ("1 h", 3600.0, TIME),
        ("40 N*m", 40.0, MOMENT),
        ("40 N·m", 40.0, MOMENT),
        ("40 N m", 40.0, MOMENT),
        ("40 Nm", 40.0, MOMENT),
        ("40 Nmm", 0.04, MOMENT),
        ("2 kJ", 2000.0, MOMENT),
        ("207 GPa", 207e9, PRESSURE),
        ("1 N/mm^2", 1e6, PRESSURE),
        ("1 psi", 6894.757293168, PRESSURE),
        ("1 bar", 1e5, PRESSURE),
        ("50 mPa*s", 0.05, DYNAMIC_VISCOSITY),
        ("50 cP", 0.05, DYNAMIC_VISCOSITY),
        ("1 P", 0.1, DYNAMIC_VISCOSITY),
        ("0.1 Pa s", 0.1, DYNAMIC_VISCOSITY),
        ("1 g/(cm*s)", 0.1, DYNAMIC_VISCOSITY),
        ("46 cSt", 46e-6, KINEMATIC_VISCOSITY),
        ("1 St", 1e-4, KINEMATIC_VISCOSITY),
        ("46 mm^2/s", 46e-6, KINEMATIC_VISCOSITY),
        ("3 kg*m^2", 3.0, INERTIA),
        ("3 kg m**2", 3.0, INERTIA),
        ("3 kg*mm^2", 3e-6, INERTIA),
        ("180 deg", math.pi, DIMENSIONLESS),
        ("180°", math.pi, DIMENSIONLESS),
        ("0.5 rev", math.pi, DIMENSIONLESS),
        ("60 rpm", 2 * math.pi, RATE),
        ("10 rad/s", 10.0, RATE),
        ("1 rev/min", math.pi / 30, RATE),
        ("50 Hz", 50.0, RATE),  # 1/s, not 2 pi/s
        ("5 1/s", 5.0, RATE),
        ("5 s^-1", 5.0, RATE),
        ("5 s^(-1)", 5.0, RATE),
        ("36 km/h", 10.0, Dimension(1, 0, -1)),
        ("2 N*s/m", 2.0, Dimension(0, 1, -1)),
        ("2 N/(m/s)", 2.0, Dimension(0, 1, -1)),
        ("2 N/m*s", 2.0, Dimension(0, 1, -1)),
        ("1e10 N/m^1.5", 1e10, Dimension(-0.5, 1, -2)),
    ],
)
def test_quantity_has_its_value_in_si_and_its_dimension(text, value, dimension):
    found = parse_quantity(text)
    assert found is not None
    assert found[0] == pytest.approx(value, rel=1e-12)
    assert found[1] == dimension


def test_odd_units_stay_within_range():
    assert parse_quantity("5 (nm^7)^5")[0] == pytest.approx(5e-315, rel=1e-6)  # fewer digits so near to zero


@pytest.mark.parametrize("text", ["5", "-5", "+5", " .5 ", "5.", "1e-3", "1.5E+3"])
def test_number_without_unit_has_no_dimension(text):
    assert parse_quantity(text) == (float(text), None)


def test_decimal_prefixes_cost_no_rounding():
    assert [parse_quantity(f"{n} um")[0] for n in range(1, 200)] == [n / 1e6 for n in range(1, 200)]


@pytest.mark.parametrize(
    "text",
    ["", " ", "-", "l1", "2*l1", "5/s", "2 + 3", "5 mm + 2 mm", "pi/2", "2 if a < b else 3", "1.2.3", "m", "x" * 500,
     "2 mm * sin(t)", "5 mm/s*t", "40 N*length", "5 m*2", "3 N/(2 m)", "2 mm if x else 3 mm", "2 m**n"],
)  # fmt: skip
def test_other_texts_are_no_quantities(text):
    assert parse_quantity(text) is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("5 mn", "unknown unit 'mn'; did you mean 'mN' or 'MN'"),
        ("5 KG", "did you mean 'kg'"),
        ("5 kilo", "unknown unit 'kilo'"),
        ("2alpha", "if alpha is a parameter write 2*alpha"),
        ("5 m2", "did you mean 'm^2'"),
        ("5 N*", "ends too early"),
        ("5 (N*m", "')' is missing"),
        ("5 N)", "unexpected ')'"),
        ("5 m//s", "unexpected '/'"),
        ("5 m^x", "exponent must be a number"),
        ("5 m^999999999", "out of range"),
        ("5 ((km^9)^9)^9", "out of range"),
        ("5 (nm^12)^3", "out of range"),
        ("1e400", "not a finite number"),
        ("1e308 km", "not a finite number"),
        ("nan", "not a finite number"),
        ("-inf mm", "not a finite number"),
        ("Infinity", "not a finite number"),
    ],
)
def test_wrong_quantity_says_what_is_wrong(text, message):
    with pytest.raises(QuantityError) as caught:
        parse_quantity(text)
    assert message in str(caught.value)


@given(st.text(alphabet="0123456789.eE+-*/^()·° \x00mkgsNadr1µß²", max_size=120))
def test_any_text_is_a_quantity_an_expression_or_an_error(text):
    try:
        found = parse_quantity(text)
    except QuantityError:
        return
    assert found is None or math.isfinite(found[0])


@pytest.mark.parametrize("text", ["1" * 10**6, "5 " + "(" * 98, "5 " + "m*" * 10**6, "5" + " " * 10**6 + "m"])
def test_long_texts_are_refused_at_once(text):
    """In a time that grows with the length: were it the square, the test would not end."""
    with contextlib.suppress(QuantityError):
        assert parse_quantity(text) is None  # left to the reader of expressions, which refuses it for its length


_POWERS = st.integers(-8, 8).map(lambda n: n / 2)
_DIMENSIONS = st.builds(Dimension, _POWERS, _POWERS, _POWERS, _POWERS)


@given(_DIMENSIONS)
def test_unit_name_is_read_back_as_the_same_dimension(dimension):
    assert dimension_of(unit_name(dimension)) == dimension


@given(_DIMENSIONS, _DIMENSIONS)
def test_dimensions_multiply_like_quantities(a, b):
    assert a.times(b).over(b) == a
    assert a.times(a) == a.power(2)
    assert a.power(1 / 3).power(3) == a


def test_names_for_messages():
    assert [unit_name(x) for x in (MASS, MOMENT, FORCE, DIMENSIONLESS)] == ["kg", "N*m", "N", ""]
    assert unit_name(dimension_of("m/s^2")) == "m/s^2"
    assert describe(MASS) == "a mass"
    assert describe(LENGTH) == "a length"
    assert describe(INERTIA) == "a moment of inertia"
    assert describe(dimension_of("kg/s^3")) == "a quantity in kg/s^3"
    assert dimension_of("") == DIMENSIONLESS
    assert dimension_of("N*m/rad") == MOMENT
    with pytest.raises(QuantityError):
        dimension_of("metre")
