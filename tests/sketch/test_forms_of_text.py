"""A text that is written otherwise means the same after every act, and keeps its comments and line ends."""

import json
import re
import tomllib

import pytest
from sheet import Sheet

HEADED = """# my four-bar
format = 1

[parameters]
l2 = "180 mm"

[ground.points]
O1 = [-0.12, -0.04]
O4 = [0.08, -0.04]

[bodies.crank]
bar = ["A", "B"]
length = "60 mm"
mass = 0.1

[bodies.coupler]
bar = ["A", "B"]
length = "l2"
mass = 0.2
points = { C = [0.02, 0.03] }

[bodies.rocker]
bar = ["A", "B"]
length = 0.15
mass = 0.2

[joints.J1]
type = "revolute"
connect = ["ground.O1", "crank.A"]

[joints.J3]
type = "revolute"
connect = ["coupler.B", "rocker.A"]
clearance = "0.2 mm"
contact = { model = "impact", restitution = 0.5, bush_radius = "5 mm" }

[joints.J2]
type = "revolute"
connect = ["crank.B", "coupler.A"]

[joints.J4]
type = "revolute"
connect = ["rocker.B", "ground.O4"]

[drivers.motor]
joint = "J1"
angle = "90 deg + 60 rpm*t"

[loads.push]
type = "force"
at = "coupler.C"
force = [1, 2]

[signals]
rate = "rocker.omega*2"

[initial]
coupler = { angle = "20 deg" }
rocker = { angle = "-70 deg" }
"""
QUOTED = """# my four-bar
"format" = 1
["parameters"]
"l2" = '''180 mm'''   # c1
[ground."points"] # c2
  "O1" = [
     -0.12, # c3
     -0.04,
  ] # c4
  O4 = [ 0.08 , -0.04 ]
[ "bodies" . 'crank' ] # c5
  bar = ["A",
   "B"] # c6
  length = '60 mm'
  mass = 1e-1
# above coupler
[bodies."coupler"] # [bodies.x]
"bar" = ["A", "B"]
length = "l2"
mass = 0.2
[bodies.coupler.points]
C = [0.02, 0.03]
[bodies.rocker]
bar = ["A", "B"]
length = 0.15
mass = 0.2


[joints.J1]
type = "revolute"
connect = [
  "ground.O1",
  "crank.A",
]
[joints.J3]
type = "revolute"
connect = ["coupler.B", "rocker.A"]
clearance = "0.2 mm"
[joints.J3.contact]
model = "impact"
restitution = 0.5
bush_radius = "5 mm"
# about J2
[joints.J2]
type = "revolute"
connect = ["crank.B", "coupler.A"]
[joints.J4]
type = "revolute"
connect = ["rocker.B", "ground.O4"]

[initial]
coupler = { angle = "20 deg" } # c7
[initial.rocker]
angle = "-70 deg"
[loads.push]
type = "force"
at = "coupler.C"
force = [1, 2]
[signals]
rate = "rocker.omega*2"
[drivers.motor]
joint = "J1"
angle = "90 deg + 60 rpm*t"   # and no line end behind it"""


def dotted(value, path=()):
    """A table as dotted keys, a line each."""
    for key, part in value.items():
        if isinstance(part, dict) and len(path) < 2:
            yield from dotted(part, (*path, key))
        else:
            yield f"{'.'.join((*path, key))} = {inline(part)}"


def inline(value):
    """A value in one line of TOML."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {inline(part)}" for key, part in value.items()) + " }"
    return "[" + ", ".join(map(inline, value)) + "]" if isinstance(value, list) else json.dumps(value)


TABLE = tomllib.loads(HEADED)
FORMS = {
    "quoted keys, tables in tables, long arrays": QUOTED,
    "line ends of Windows": HEADED.replace("\n", "\r\n"),
    "quoted, line ends of Windows": QUOTED.replace("\n", "\r\n"),
    "dotted keys": "# my four-bar\n" + "\n".join(dotted(TABLE)) + "\n",
    "tables of one line": "# my four-bar\n" + "\n".join(f"{key} = {inline(part)}" for key, part in TABLE.items()),
    "JSON": json.dumps(TABLE),
}
ACTS = {
    "drag a pin": {"act": "drop", "point": "crank.B", "to": {"at": [-0.1, 0.03]}},
    "drag the ground": {"act": "drop", "point": "ground.O4", "to": {"at": [0.09, -0.05]}},
    "length": {"act": "type", "chosen": "body coupler", "field": "Length", "text": "0.19"},
    "no play": {"act": "type", "chosen": "joint J3", "field": "Play", "text": ""},
    "play": {"act": "type", "chosen": "joint J2", "field": "Play", "text": "0.1 mm"},
    "contact": {"act": "type", "chosen": "joint J3", "field": "Contact", "text": "massless-link"},
    "rename a body": {"act": "type", "chosen": "body rocker", "field": "Name", "text": "swing"},
    "rename a joint": {"act": "type", "chosen": "joint J3", "field": "Name", "text": "upper"},
    "rename a driver": {"act": "type", "chosen": "driver motor", "field": "Name", "text": "engine"},
    "delete a body": {"act": "delete", "chosen": "body coupler"},
    "delete a motor": {"act": "delete", "chosen": "driver motor"},
    "ground": {"act": "ground", "at": {"at": [0.2, 0.1]}},
    "bar": {"act": "bar", "from": {"at": [0, 0], "line": "crank"}, "to": {"at": [0.2, 0.1]}},
    "spring": {"act": "spring", "from": {"at": [0, 0], "point": "coupler.C"}, "to": {"at": [0.1, 0.2]}},
    "keep": {"act": "keep", "signals": {"far": "crank.x*2"}},
}


def full(table):
    """A document without tables that hold nothing."""
    return {key: part for key, part in table.items() if part != {}}


@pytest.mark.parametrize("act", ACTS)
def test_a_text_that_is_written_otherwise_means_the_same_after_every_act(act):
    sheet = Sheet(HEADED)
    sheet.do(ACTS[act]["act"], **ACTS[act])
    for form, text in FORMS.items():
        other = Sheet(text)
        other.do(ACTS[act]["act"], **ACTS[act])
        assert full(other.table) == full(sheet.table), form
        after = other.sketch.text
        ends = {"\r\n"} if "\r\n" in text else {"\n"}
        assert set(re.findall(r"\r?\n|\r", after)) <= ends, form
        kept = re.findall(r"# my four-bar" if "delete" in act else r"# (?:my four-bar|about J2|c[1-6])", text)
        assert all(comment in after for comment in kept), form


def test_a_corner_of_a_plate_goes_where_it_is_dragged_in_json_too():
    sheet = Sheet("format = 1\n")
    sheet.do("plate", corners=[{"at": [0, 0]}, {"at": [0.3, 0]}, {"at": [0, 0.3]}])
    plain = Sheet(json.dumps(sheet.table))
    for drawing in (sheet, plain):
        drawing.do("drop", point="plate1.C", to={"at": [0.1, 0.4]})
        assert drawing.table["bodies"]["plate1"]["polygon"] == [[0, 0], [0.3, 0], [0.1, 0.4]]
        assert drawing.place("plate1.C") == pytest.approx((0.1, 0.4), abs=1e-12)
    assert plain.table == sheet.table
