"""Blocks in guides of the ground: where they are dropped, and what follows them."""

import json
import math
import tomllib

import pytest
from sheet import Sheet

import rattle as rt
from rattle.errors import InputError, ModelError

GUIDED = """format = 1
[ground.points]
S = [0.1, 0.2]
[bodies.b]
points = { P = [0, 0]MORE }
mass = 1
inertia = 0.01
[joints.G]
type = "prismatic"
connect = ["ground.S", "b.P"]
axis = "30 deg"
[initial]
b = { x = 0.2 }
"""
ALONG = math.cos(math.pi / 6), math.sin(math.pi / 6)


def on_guide(far, across=0.0):
    """A place at a distance along the guide, and across it."""
    return 0.1 + far * ALONG[0] - across * ALONG[1], 0.2 + far * ALONG[1] + across * ALONG[0]


@pytest.mark.parametrize("more", ["", ", Q = [0.05, 0.02]"])
def test_a_block_beside_its_guide_point_is_dropped_on_its_guide(more):
    sheet = Sheet(GUIDED.replace("MORE", more))
    others = {name: spot for name, spot in sheet.sketch.points.items() if name != "b.P"}
    sheet.do("drop", point="b.P", to=sheet.at(*on_guide(0.25)))
    assert sheet.place("b.P") == pytest.approx(on_guide(0.25), abs=1e-12)
    assert sheet.words == "b.P moved"
    sheet.do("drop", point="b.P", to=sheet.at(*on_guide(0.15, 0.04)))
    assert sheet.place("b.P") == pytest.approx(on_guide(0.15), abs=1e-12)
    assert sheet.words == "b.P moved along G"
    text = sheet.sketch.text
    sheet.do("drop", point="b.P", to=sheet.at(*on_guide(0.15, 0.04)))
    assert sheet.words == "b.P stays: G lets it go along its line alone"
    assert sheet.sketch.text == text
    assert {name: sheet.place(name) for name in others} == {
        name: pytest.approx(spot, abs=1e-12) for name, spot in others.items()
    }
    with pytest.raises(InputError, match=r"b.P.y cannot be 0.5 m: joints hold it elsewhere"):
        sheet.type("point b.P", "Y", "0.5 m")


def test_a_block_dropped_on_its_guide_point_is_not_pinned_to_that():
    sheet = Sheet(GUIDED.replace("MORE", ""))
    sheet.do("drop", point="b.P", to=sheet.at(0.1, 0.2))
    assert sheet.place("b.P") == pytest.approx((0.1, 0.2), abs=1e-12)
    assert list(sheet.table["joints"]) == ["G"]


def test_a_rod_follows_the_block_that_is_dropped_beside_its_guide():
    sheet = Sheet()
    sheet.ground((0.0, 0.0))
    sheet.bars((0.0, 0.0), (0.0, 0.06), (0.18, 0.0))
    sheet.do("slider", at=sheet.at(0.18, 0.0), along=0.0)
    sheet.do("motor", at=sheet.at(0.0, 0.0))
    sheet.type("body bar1", "Angle", "60")
    crank = sheet.place("bar1.B")
    sheet.do("drop", point="block1.P", to=sheet.at(0.22, 0.03))
    assert sheet.place("block1.P") == pytest.approx((0.22, 0.0), abs=1e-12)
    assert sheet.place("bar2.B") == pytest.approx((0.22, 0.0), abs=1e-12)
    assert sheet.place("bar1.B") == pytest.approx(crank, abs=1e-12)
    assert sheet.words.startswith("block1.P moved along ")


def test_a_drop_that_joints_do_not_keep_is_told():
    """A block between two guides: where their lines cross it stays."""
    text = GUIDED.replace("MORE", "").replace("S = [0.1, 0.2]", "S = [0.1, 0.2]\nT = [0.2, 0.1]")
    second = '[joints.H]\ntype = "slot"\nconnect = ["ground.T", "b.P"]\naxis = "90 deg"\n[initial]'
    sheet = Sheet(text.replace("[initial]", second))
    stood = sheet.place("b.P")
    sheet.do("drop", point="b.P", to=sheet.at(*on_guide(0.3)))
    assert sheet.place("b.P") == pytest.approx(stood, abs=1e-9)
    assert sheet.words.startswith("joints hold b.P elsewhere than there")


@pytest.mark.parametrize("is_json", [False, True])
def test_a_block_that_gets_play_gets_a_size_with_it_which_is_told(is_json):
    text = GUIDED.replace("MORE", "")
    sheet = Sheet(json.dumps(tomllib.loads(text)) if is_json else text)
    sheet.type("joint G", "Play", "0.2 mm")
    joint = sheet.table["joints"]["G"]
    assert joint["clearance"] == "0.2 mm"
    assert joint["block"] == {"length": 0.012, "height": 0.007}  # 0.12 and 0.07 of the 0.1 m of the drawing
    assert sheet.words.endswith("its block is given a size of 0.012 m by 0.007 m: change it under Text")
    assert rt.loads(sheet.sketch.text).simulate(1e-3).success
    before = sheet.sketch.text
    sheet.type("joint G", "Play", "")
    assert sheet.sketch.trouble == ""
    sheet.type("joint G", "Play", "0.2 mm")
    assert "size" not in sheet.words
    assert sheet.table == (json.loads(before) if is_json else tomllib.loads(before))
    with pytest.raises(ModelError, match="clearance"):
        sheet.type("joint G", "Play", "-0.3 mm")
