"""The lines of `check` that tell which way a mechanism is put together."""

import pytest

import rattle as rt

pytestmark = pytest.mark.nojit

THREE_BARS_ON_ONE_PIN = """
format = 1
[ground.points]
O = [0, 0]
C = [0.5, 0]
[bodies.crank]
bar = ["O", "A"]
length = 0.2
mass = 1
[bodies.link]
bar = ["A", "B"]
length = 0.5
mass = 1
[bodies.other]
bar = ["B", "D"]
length = 0.3
mass = 1
[bodies.rocker]
bar = ["B", "C"]
length = 0.4
mass = 1
[joints.O]
type = "revolute"
connect = ["ground.O", "crank.O"]
[joints.A]
type = "revolute"
connect = ["crank.A", "link.A"]
[joints.B]
type = "revolute"
connect = ["link.B", "other.B"]
[joints.B2]
type = "revolute"
connect = ["other.B", "rocker.B"]
[joints.C]
type = "revolute"
connect = ["rocker.C", "ground.C"]
[drivers.motor]
joint = "O"
angle = 1
[initial]
link = { angle = 0.4 }
other = { angle = 1 }
rocker = { angle = -1 }
"""


def test_two_pins_in_one_place_have_no_side():
    report = str(rt.loads(THREE_BARS_ON_ONE_PIN).check())
    assert "lies on the line" not in report
