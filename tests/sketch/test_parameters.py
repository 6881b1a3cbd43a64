"""Numbers that are parameters: one that several bars share, coordinates of the ground, functions of time."""

import math

import pytest
from sheet import Sheet

import rattle as rt
from rattle.errors import InputError

PARALLELOGRAM = """format = 1
[parameters]
l = 0.05
g = { value = "10 cm", min = 0.01 }

[ground.points]
O1 = [0, 0]
O4 = ["g", 0]

[bodies]
crank = { bar = ["A", "B"], length = "l", mass = 0.1 }
coupler = { bar = ["A", "B"], length = 0.1, mass = 0.1 }
rocker = { bar = ["A", "B"], length = "l", mass = 0.1 }

[joints]
J1 = { type = "revolute", connect = ["ground.O1", "crank.A"] }
J2 = { type = "revolute", connect = ["crank.B", "coupler.A"] }
J3 = { type = "revolute", connect = ["coupler.B", "rocker.B"] }
J4 = { type = "revolute", connect = ["ground.O4", "rocker.A"] }

[drivers]
motor = { joint = "J1", angle = "60 deg + 60 rpm*t" }

[initial]
coupler = { angle = 0 }
rocker = { angle = "60 deg" }
"""
TRIANGLE = """format = 1
[parameters]
l = 0.1

[ground.points]
O1 = [0, 0]
O2 = [0.1, "0.01*sin(t)"]

[bodies]
a = { bar = ["A", "B"], length = "l", mass = 0.1 }
b = { bar = ["A", "B"], length = "l", mass = 0.1 }

[joints]
J1 = { type = "revolute", connect = ["ground.O1", "a.A"] }
J2 = { type = "revolute", connect = ["a.B", "b.A"] }
J3 = { type = "revolute", connect = ["ground.O2", "b.B"] }
"""


def test_a_length_that_two_bars_share_closes_where_both_have_it():
    """A parallelogram closes with any length; with one longer bar alone up to 0.1 + 0.1 + 0.05 m at most."""
    sheet = Sheet(PARALLELOGRAM)
    sheet.type("body crank", "Length", "300 mm")
    assert sheet.table["parameters"]["l"] == "300 mm"
    tip = 0.3 * math.cos(math.pi / 3), 0.3 * math.sin(math.pi / 3)
    assert sheet.place("crank.B") == pytest.approx(tip, abs=1e-9)
    assert sheet.place("rocker.B") == pytest.approx((tip[0] + 0.1, tip[1]), abs=1e-9)


def test_bars_over_a_base_close_from_half_of_it_on():
    sheet = Sheet(TRIANGLE)
    with pytest.raises(InputError, match=r"length 40 mm: the loop of a closes from 0.05 m on"):
        sheet.type("body a", "Length", "40 mm")


def test_a_pin_between_bars_that_share_a_length_goes_where_both_have_one():
    sheet = Sheet(TRIANGLE)
    before = sheet.sketch.text
    with pytest.raises(InputError, match=r"b.length is l, which would have to be two lengths: type a number"):
        sheet.do("drop", point="a.B", to={"at": [0.02, 0.1]})
    assert sheet.sketch.text == before
    sheet.do("drop", point="a.B", to={"at": [0.05, 0.12]})
    assert sheet.table["parameters"]["l"] == pytest.approx(0.13, abs=1e-15)  # 5, 12, 13
    assert sheet.place("a.B") == pytest.approx((0.05, 0.12), abs=1e-12)
    assert sheet.place("b.B") == pytest.approx((0.1, 0), abs=1e-12)


def test_a_typed_coordinate_goes_into_its_parameter_or_into_the_place_of_an_expression():
    sheet = Sheet(PARALLELOGRAM.replace('length = "l", mass = 0.1 }\n\n', "length = 0.05, mass = 0.1 }\n\n"))
    sheet.type("point ground.O4", "X", "12 cm")
    assert sheet.table["parameters"]["g"] == {"value": "12 cm", "min": 0.01}
    assert sheet.table["ground"]["points"]["O4"] == ["g", 0]
    assert sheet.place("rocker.A") == pytest.approx((0.12, 0), abs=1e-12)
    sheet = Sheet(PARALLELOGRAM.replace('["g", 0]', '["2*l", 0]'))
    sheet.type("point ground.O4", "X", "120 mm")
    assert sheet.table["ground"]["points"]["O4"] == ["120 mm", 0]


def test_a_point_with_one_parameter_for_both_coordinates_is_not_dragged_off_its_line():
    sheet = Sheet(PARALLELOGRAM.replace('["g", 0]', '["g", "g"]').replace("10 cm", "6 cm"))
    with pytest.raises(InputError, match=r"ground.O4.y is g, which would have to be two lengths"):
        sheet.do("drop", point="ground.O4", to={"at": [0.09, 0.02]})


def test_a_point_of_the_ground_that_moves_goes_along_what_is_a_number():
    sheet = Sheet(TRIANGLE.replace('"l"', "0.1"))
    sheet.do("drop", point="ground.O2", to={"at": [0.12, 0.0]})
    assert sheet.table["ground"]["points"]["O2"] == [0.12, "0.01*sin(t)"]
    with pytest.raises(InputError, match=r"ground.O2.y is 0.01\*sin\(t\): type a number to replace it"):
        sheet.do("drop", point="ground.O2", to={"at": [0.12, 0.01]})


def test_a_driver_whose_function_has_the_parameter_starts_where_the_bar_was_put():
    """The angles of both motors are functions of the lengths of arms and forearms."""
    sheet = Sheet(rt.example("five_bar").to_toml())
    other = sheet.place("right_arm.elbow")
    origin, end = sheet.place("right_arm.E"), (-0.2053, 0.1636)
    sheet.do("drop", point="left_arm.elbow", to={"at": list(end)})
    assert sheet.place("left_arm.elbow") == pytest.approx(end, abs=1e-9)
    arm = math.dist(end, (-0.1, 0.0))  # of both sides now: the other one keeps its angle
    share = arm / math.dist(origin, other)
    there = [a + share * (b - a) for a, b in zip(origin, other, strict=True)]
    assert sheet.place("right_arm.elbow") == pytest.approx(there, abs=1e-9)


PLATE = """format = 1
[parameters]
b = 0.2
h = 0.3
[bodies.plate]
polygon = [[0, 0], ["b", 0], ["b", "h"], [0, "h"]]
holes = [[["b/2 - 0.01", 0.05], ["b/2 + 0.01", 0.05], ["b/2", 0.07]]]
thickness = "5 mm"
density = 1000
points = { A = [0, 0], C = ["b", "h"], Q = ["b", 0.1] }
[initial]
plate = { x = 0.5, y = 0.4, angle = "30 deg" }
"""


@pytest.mark.parametrize(("point", "to"), [("C", (0.5, 0.7)), ("Q", (0.65, 0.45))])
def test_a_plate_whose_corners_are_parameters_stands_at_its_corner_of_numbers(point, to):
    """The mass centre moves in the plate, which stands where it was: A is [0, 0] of the text, C is [b, h]."""
    sheet = Sheet(PLATE)
    (x, y), angle = sheet.place("plate.A"), math.pi / 6
    sheet.do("drop", point=f"plate.{point}", to={"at": list(to)})
    assert sheet.place("plate.A") == pytest.approx((x, y), abs=1e-12)
    b = (to[0] - x) * math.cos(angle) + (to[1] - y) * math.sin(angle)
    h = -(to[0] - x) * math.sin(angle) + (to[1] - y) * math.cos(angle) if point == "C" else 0.3
    assert sheet.table["parameters"] == {"b": pytest.approx(b, abs=1e-12), "h": pytest.approx(h, abs=1e-12)}
    corner = x + b * math.cos(angle) - h * math.sin(angle), y + b * math.sin(angle) + h * math.cos(angle)
    assert sheet.place("plate.C") == pytest.approx(corner, abs=1e-12)
