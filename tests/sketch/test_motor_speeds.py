"""The speed of a motor as it is shown and typed: its sign counts, and the motor begins where it did."""

import math

import pytest
from sheet import Sheet

import rattle as rt
from rattle.sketch.expressions import shifted
from rattle.sketch.fields import fields_of

ROTOR = """format = 1
[parameters]
w = "10 rad/s"
[ground.points]
O = [0, 0]
[bodies.a]
bar = ["A", "B"]
length = 0.1
mass = 1
[joints.J]
type = "revolute"
connect = ["ground.O", "a.A"]
[drivers.m]
joint = "J"
angle = "FUNCTION"
"""
WAYS = [  # function, the speed that is shown, where it begins [rad]
    ("90 deg + 60 rpm*t", "60 rpm", math.pi / 2), ("90 deg - 60 rpm*t", "-60 rpm", math.pi / 2),
    ("90 deg-60 rpm*t", "-60 rpm", math.pi / 2), ("1 - w*t", "-w", 1.0), ("1 - 2 - w*t", "-w", -1.0), ("w*t", "w", 0.0),
    ("-60 rpm*t", "-60 rpm", 0.0), ("1 + (2*w)*t", "(2*w)", 1.0), ("1e-1 + 1e-1*t", "1e-1", 0.1),
    ("1+3 rad/s*t", "3 rad/s", 1.0),
]  # fmt: skip


@pytest.mark.parametrize(("function", "shown", "begin"), WAYS)
@pytest.mark.parametrize(("typed", "omega"), [("30 rpm", math.pi), ("-30 rpm", -math.pi), ("2*w", 20.0), ("-w", -10.0)])
def test_a_typed_speed_is_the_speed_and_the_start_stays(function, shown, begin, typed, omega):
    sheet = Sheet(ROTOR.replace("FUNCTION", function))
    assert {field.name: field.text for field in fields_of(sheet.sketch, "driver m")}["Speed"] == shown
    sheet.type("driver m", "Speed", typed)
    r = rt.loads(sheet.sketch.text).kinematics([0.0])
    assert (r["a.angle"][0], r["a.omega"][0]) == pytest.approx((begin, omega), abs=1e-12)


@pytest.mark.parametrize("function", ["t*w + 1 - w*t", "10 deg + sin(t)*t", "0 if w < 0 else 1 + w*t", "0.5*(1 + w*t)"])
def test_a_function_that_is_no_start_and_rate_is_shown_as_a_whole(function):
    fields = fields_of(Sheet(ROTOR.replace("FUNCTION", function)).sketch, "driver m")
    assert {field.name: field.text for field in fields}["Function"] == function


@pytest.mark.parametrize(
    "function",
    ["90 deg - 60 rpm*t", "- 5 deg + w*t", "1.5e+0 - w*t", "0.25*pi + w*t", "w*t + 90 deg", "2*3 + w*t", "10 deg/2 - 3",
     "sin(w*t)", "1/2 + w*t", "0.5 + w*t if t < 1 else 10.5", "max(1, 2) + w*t", "-w*t"],
)  # fmt: skip
def test_a_function_that_begins_elsewhere_differs_by_that_at_all_times(function):
    before = rt.loads(ROTOR.replace("FUNCTION", function)).kinematics([0.0, 0.5, 1.5])["a.angle"]
    moved = shifted(function, float(before[0]), 0.3, turns=True)
    after = rt.loads(ROTOR.replace("FUNCTION", str(moved))).kinematics([0.0, 0.5, 1.5])["a.angle"]
    for now, then in zip(after, before, strict=True):
        assert math.remainder(now - then - 0.3, math.tau) == pytest.approx(0.0, abs=1e-9)


def test_a_point_of_a_driven_block_goes_along_its_line_and_the_block_stands():
    """A guide along 30 deg through S: the motor begins where the point of the block is now."""
    sheet = Sheet(
        "format = 1\n[ground.points]\nS = [0.1, 0.2]\n"
        "[bodies.b]\npoints = { P = [0, 0], Q = [0.05, 0.02] }\nmass = 1\ninertia = 0.01\n"
        '[joints.G]\ntype = "prismatic"\nconnect = ["ground.S", "b.P"]\naxis = "30 deg"\n'
        '[drivers.m]\njoint = "G"\nposition = "20 mm + 5 mm/s*t"\n'
    )
    along, other = (math.cos(math.pi / 6), math.sin(math.pi / 6)), sheet.place("b.Q")
    to = [0.1 + 0.05 * along[0], 0.2 + 0.05 * along[1]]
    sheet.do("drop", point="b.P", to={"at": to})
    assert sheet.place("b.P") == pytest.approx(to, abs=1e-12)
    assert sheet.place("b.Q") == pytest.approx(other, abs=1e-12)
    assert sheet.table["drivers"]["m"]["position"] == "50 mm + 5 mm/s*t"
    assert sheet.table["bodies"]["b"]["points"]["P"] == [pytest.approx(0.03, abs=1e-13), 0]
