"""Numbers that are parameters: one that several bars share, coordinates of the ground, functions of time."""

import math

import pytest
from sheet import Sheet

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
