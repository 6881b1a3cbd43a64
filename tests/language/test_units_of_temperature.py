"""degC: a temperature where it stands alone, a kelvin in products; differences and sums."""

import pytest

import rattle as rt
from rattle.language.expression import ExpressionError, parse
from rattle.language.units import (
    TEMPERATURE,
    Dimension,
    QuantityError,
    as_difference,
    describe,
    dimension_of,
    parse_quantity,
    unit_of_quantity,
)
from rattle.results.chosen_units import read_units

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
FOURBAR = rt.example("fourbar")


def parameter(**entry):
    return FOURBAR.set({"parameters.T": entry}).model.parameters["T"]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("60 degC", 333.15), ("60degC", 333.15), (" -30 degC ", 243.15), ("200 degC", 473.15), ("-273.15 degC", 0.0),
        ("333.15 K", 333.15),
    ],
)  # fmt: skip
def test_a_number_of_degrees_celsius_is_a_temperature(text, value):
    assert parse_quantity(text) == (value, TEMPERATURE)


@pytest.mark.parametrize(
    ("text", "value", "words"),
    [
        ("460 J/(kg*degC)", 460.0, "a specific heat"), ("2 W/K", 2.0, "a thermal conductance"),
        ("2 W/degC", 2.0, "a thermal conductance"), ("11.5e-6 1/degC", 11.5e-6, "a thermal expansion"),
        ("46 mm^2/s", 46e-6, "a kinematic viscosity"), ("2 kg/m", 2.0, "a mass per length"),
        ("16 W/(m*K)", 16.0, "a thermal conductivity"), ("5 K", 5.0, "a temperature"),
    ],
)  # fmt: skip
def test_in_products_and_quotients_a_degree_is_a_kelvin(text, value, words):
    number, dimension = parse_quantity(text)
    assert number == pytest.approx(value)
    assert describe(dimension) == words


def test_nothing_is_colder_than_the_absolute_zero():
    with pytest.raises(QuantityError, match="absolute zero"):
        parse_quantity("-300 degC")


def test_differences_are_in_kelvin():
    assert as_difference("5 degC") == "5 K"
    assert as_difference("5 W/degC") == "5 W/degC"
    assert as_difference("2*x") == "2*x"
    assert unit_of_quantity("60 degC") == (1.0, "K")


def test_the_tolerance_of_a_parameter_is_a_difference_and_its_limits_are_temperatures():
    T = parameter(value="60 degC", tol="5 degC", min="20 degC", max="80 degC")
    assert (T.value, T.tol, T.minimum, T.maximum) == (333.15, 5.0, 293.15, 353.15)
    assert T.unit == "K"
    assert parameter(value="60 degC", tol="5 K").tol == 5.0
    assert parameter(value="2*150 K", tol="5 degC").tol == 5.0


@pytest.mark.parametrize("text", ["T + 5 degC", "5 degC + T", "T - 5 degC", "2*5 degC", "5 degC/T", "5 degC + 3 degC"])
def test_a_temperature_in_a_sum_or_product_is_refused(text):
    with pytest.raises(ExpressionError, match=r"write 5 K for a difference, 278\.15 K for the temperature"):
        parse(text)


def test_a_temperature_may_be_compared_and_chosen():
    m = FOURBAR.set({"parameters.T": "max(60 degC, -5 degC)", "parameters.U": "-5 degC if 1 < 2 else 3 degC"})
    assert m.model.parameters["T"].value == 333.15
    assert m.model.parameters["U"].value == 268.15
    assert FOURBAR.set({"parameters.T": "60 degC", "parameters.U": "T + 5 K"}).model.parameters["U"].value == 338.15


def test_numbers_of_a_table_may_be_in_degrees_celsius():
    table = {"x": [20, "60 degC"], "y": [1, 2], "kind": "linear", "units": ["degC", ""]}
    m = FOURBAR.set({"tables.stiff": table, "parameters.T": "40 degC", "parameters.k": "stiff(T)"})
    assert m.model.parameters["k"].value == pytest.approx(1.5)


def test_results_are_not_written_in_a_unit_with_a_zero_of_its_own():
    with pytest.raises(rt.InputError, match="temperatures are written in K"):
        read_units("mm,degC")


def test_degrees_celsius_have_the_dimension_of_a_temperature():
    assert dimension_of("degC") == TEMPERATURE == Dimension(kelvin=1)
