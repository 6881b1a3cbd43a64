"""Names that are changed: what has another name stands as before, and names of others and of files stay."""

import math
import re

import pytest
from sheet import Sheet

import rattle as rt
from rattle.errors import InputError
from rattle.sketch.acts import act
from rattle.sketch.drawn import drawn

TWINS = """format = 1
[signals]
gap = "a.x + a2.x - ba.x"
[ground.points]
a = [0, 0]
O = [0.2, 0]
[bodies.a]
bar = ["a", "B"]
length = 0.05
mass = 0.1
[bodies.a2]
bar = ["A", "B"]
length = 0.18
mass = 0.1
[bodies.ba]
bar = ["A", "B"]
length = 0.12
mass = 0.1
[joints.J1]
type = "revolute"
connect = ["ground.a", "a.a"]
[joints.J12]
type = "revolute"
connect = ["a.B", "a2.A"]
[joints.J3]
type = "revolute"
connect = ["a2.B", "ba.A"]
[joints.J4]
type = "revolute"
connect = ["ba.B", "ground.O"]
[drivers.motor]
joint = "J1"
angle = "30 deg + 60 rpm*t"
"""


def test_a_name_that_begins_or_ends_another_changes_alone():
    sheet = Sheet(TWINS)
    sheet.type("body a", "Name", "crank")
    table = sheet.table
    assert table["signals"] == {"gap": "crank.x + a2.x - ba.x"}
    assert list(table["bodies"]) == ["crank", "a2", "ba"]
    assert list(table["ground"]["points"]) == ["a", "O"]
    assert table["bodies"]["crank"]["bar"] == ["a", "B"]
    assert table["joints"]["J1"]["connect"] == ["ground.a", "crank.a"]
    assert table["drivers"] == {"motor": {"joint": "J1", "angle": "30 deg + 60 rpm*t"}}
    sheet.type("joint J1", "Name", "J2")
    assert list(sheet.table["joints"]) == ["J2", "J12", "J3", "J4"]
    assert sheet.table["drivers"]["motor"]["joint"] == "J2"


@pytest.mark.parametrize("name", ["ellipse", "quick_return", "planetary", "fourbar", "drawer"])
def test_what_is_called_otherwise_stands_where_it_was_and_its_old_name_gives_the_old_text(name):
    sketch = drawn(rt.example(name).to_toml())
    for kind, table in (("body", "bodies"), ("joint", "joints"), ("driver", "drivers")):
        for old in sketch.document.get(table, {}):
            other = act(sketch, {"act": "type", "chosen": f"{kind} {old}", "field": "Name", "text": "qq9"}).sketch
            assert other.text.replace("qq9", old) == sketch.text
            there = {re.sub(r"^qq9\.", f"{old}.", point): spot for point, spot in other.points.items()}
            assert all(math.dist(there[point], spot) <= 1e-12 * sketch.size for point, spot in sketch.points.items())


def test_a_file_whose_name_begins_as_a_body_keeps_it(tmp_path):
    (tmp_path / "a.csv").write_text("t,x\n0,0\n1,1\n")
    text = TWINS + '[tables.lift]\nfile = "a.csv"\n'
    sketch = drawn(text, str(tmp_path / "m.toml"))
    told = {"act": "type", "chosen": "body a", "field": "Name", "text": "crank"}
    assert act(sketch, told, str(tmp_path / "m.toml")).sketch.document["tables"]["lift"] == {"file": "a.csv"}


def test_words_of_names_that_cannot_be_and_of_ends_that_cannot_go():
    sheet = Sheet(TWINS)
    with pytest.raises(InputError, match="'bär' is not a name: expected letters, digits and _"):
        sheet.type("body a", "Name", "bär")
    with pytest.raises(InputError, match=r"a2.A is an end of the bar a2, which cannot be without it: delete a2"):
        sheet.do("delete", chosen="point a2.A")
    sheet.do("delete", chosen="point ground.O")
    assert sheet.words == "deleted ground.O, with J4"
