"""Mechanisms drawn on the sheet of the studio in a real browser: the text that is written, and back again byte by byte."""

import json
import math
import struct
import zlib

import numpy as np
import pytest
from drawing import EMPTY, Hand, apart, at
from studio_models import start_studio

import rattle as rt
from browsing import becomes, keep_picture, shows

PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
EXACT = 1e-8  # of lengths and angles that follow from the closure of loops [m, rad]
FOURBAR = """# every comment stays
format = 1

[ground.points]
O1 = [-0.12, -0.04]   # motor side
O4 = [0.08, -0.04]

[bodies.crank]
bar = ["O", "A"]
length = "l1"   # the short one
mass = 0.1

[bodies.coupler]
bar = ["A", "B"]
length = 0.17888543819998318
mass = 0.3

[bodies.rocker]
bar = ["B", "C"]
length = "2.4*l1 + 0.00160219778561037"
mass = 0.2

[joints.P1]
type = "revolute"
connect = ["ground.O1", "crank.O"]
[joints.P2]
type = "revolute"
connect = ["crank.A", "coupler.A"]
[joints.P3]   # worn
type = "revolute"
connect = ["coupler.B", "rocker.B"]
[joints.P4]
type = "revolute"
connect = ["rocker.C", "ground.O4"]

[drivers.motor]
joint = "P1"
angle = "90 deg + 60 rpm*t"

[initial]
coupler = { angle = "26.565 deg" }
rocker = { angle = "-74.055 deg" }

[parameters]
l1 = { value = 0.06, min = 0.05, max = 0.07 }
"""
O1, A, B, O4 = at(-6, -2), at(-6, 1), at(2, 5), at(4, -2)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """A studio for drawings."""
    pytest.importorskip("uvicorn")
    folder = tmp_path_factory.mktemp("drawn")
    (folder / "m.toml").write_text(EMPTY)
    served = start_studio(folder, "m.toml", "--no-browser")
    yield served
    served.process.terminate()
    assert served.process.wait(10) == 0


@pytest.fixture
def sheet(open_page, drawn):
    """A function that opens a sheet with a model text on it, and gives the hand that draws there."""

    def opened(text=EMPTY, **options):
        (drawn.folder / "m.toml").write_text(text)
        page = open_page("about:blank", **options)
        page.add_init_script("localStorage.setItem('rattle-studio-hints', 'seen')")
        page.goto(drawn.new_address())
        becomes(page, "window.rattle && window.rattle.edit && window.rattle.edit.text !== ''")
        hand = Hand(page, touch=options.get("has_touch", False))
        assert hand.text == text
        return hand

    return opened


# ---------------------------------------------------------------- six mechanisms
def fourbar(hand):
    for spot in (O1, O4):
        hand.act("Ground", spot)
    for first, last in ((O1, A), (A, B), (B, O4)):
        hand.bar(first, last)
    assert "1 freedom without a motor" in hand.status
    hand.act("Motor", O1)
    hand.take("Select")
    hand.click(B)
    hand.type("Play", "0.2 mm")
    return B, at(2, 4)


def check_fourbar(text):
    m = rt.loads(text)
    ends = [list(body.points.values()) for body in m.model.bodies.values()]
    lengths = sorted(apart(*points) for points in ends)
    assert lengths == pytest.approx(sorted([apart(O1, A), apart(A, B), apart(B, O4)]), abs=EXACT)
    assert [joint.clearance for joint in m.model.joints.values() if joint.clearance] == [0.0002]


def slider_crank(hand):
    hand.act("Ground", at(-6, 0))
    hand.bar(at(-6, 0), at(-6, 3))
    hand.bar(at(-6, 3), at(3, 0))
    hand.act("Slider", at(3, 0))
    hand.act("Motor", at(-6, 0))
    return at(-6, 3), at(-6, 2)


def check_slider_crank(text):
    t, turned = motion(text, "bar1.angle")
    r = rt.loads(text).kinematics(t)
    crank, rod = apart(at(0, 0), at(0, 3)), apart(at(-6, 3), at(3, 0))
    along = crank * np.cos(turned) + np.sqrt(rod**2 - (crank * np.sin(turned)) ** 2)
    assert r["block1.x"] == pytest.approx(-0.12 + along, abs=EXACT)


def scotch_yoke(hand):
    hand.act("Ground", at(0, 0))
    hand.bar(at(0, 0), at(3, 0))
    hand.bar(at(3, -6), at(3, 6))
    hand.act("Slider", at(3, -6))
    hand.take("Select")
    hand.click(at(3, -6))
    hand.choose("Kind", "fixed")
    before = hand.text
    hand.take("Slot")
    hand.drag(at(3, -4), at(3, 4))
    hand.says("click the point that slides in it")
    hand.click(at(3, 0))
    hand.becomes_text(before)
    hand.acts += 1
    hand.act("Motor", at(0, 0))
    return at(0, 0), at(1, 0)


def check_scotch_yoke(text):
    t, turned = motion(text, "bar1.angle")
    r = rt.loads(text).kinematics(t)
    assert r["bar2.x"] == pytest.approx(3 * 0.02 * np.cos(turned), abs=EXACT)
    assert r["bar2.angle"] == pytest.approx(math.pi / 2, abs=EXACT)


def wiper(hand):
    for spot in (at(-10, 0), at(0, 0), at(12, 0)):
        hand.act("Ground", spot)
    for first, last in ((at(-10, 0), at(-10, 2)), (at(-10, 2), at(0, 4)), (at(0, 4), at(0, 0)), (at(0, 4), at(12, 4)), (at(12, 4), at(12, 0))):
        hand.bar(first, last)
    hand.act("Motor", at(-10, 0))
    return at(12, 4), at(12, 3)


def check_wiper(text):
    t, _ = motion(text, "bar1.angle")
    r = rt.loads(text).kinematics(t)
    assert np.ptp(r["bar3.angle"]) > 0.1
    assert r["bar5.angle"] == pytest.approx(r["bar3.angle"], abs=EXACT)  # the blades stay parallel


def planetary(hand):
    hand.act("Ground", at(0, 0))
    hand.bar(at(0, 0), at(8, 0))
    hand.act("Gear", at(0, 0), at(8, 0))
    hand.act("Motor", at(0, 0))
    hand.act("Motor", at(0, 0))
    hand.type("Speed", "0 rpm")
    return at(8, 0), at(7, 0)


def check_planetary(text):
    r = rt.loads(text).kinematics(np.linspace(0.0, 0.3, 7))
    speeds = sorted(float(r[f"{name}.omega"][3]) for name in rt.loads(text).model.bodies)
    arm = speeds[1]
    assert speeds == pytest.approx([0.0, arm, 2 * arm], abs=1e-6)  # equal wheels: the planet turns twice as fast
    assert abs(arm) == pytest.approx(2 * math.pi, abs=1e-6)


def scissor_lift(hand):
    hand.act("Ground", at(-6, 0))
    hand.bar(at(-6, 0), at(6, 6))
    hand.bar(at(-6, 6), at(6, 0))
    hand.act("Pin", at(0, 3))
    hand.act("Slider", at(6, 0))
    hand.bar(at(-6, 6), at(10, 6))
    before = hand.text
    hand.take("Slot")
    hand.drag(at(0, 6), at(8, 6))
    hand.click(at(6, 6))
    hand.becomes_text(before)
    hand.acts += 1
    hand.act("Motor", at(-6, 0))
    return at(10, 6), at(9, 6)


def check_scissor_lift(text):
    t, turned = motion(text, "bar1.angle", end=0.02)
    r = rt.loads(text).kinematics(t)
    assert r["bar3.angle"] == pytest.approx(np.zeros(len(t)), abs=EXACT)  # the platform stays level
    assert r["bar3.y"] == pytest.approx(apart(at(-6, 0), at(6, 6)) * np.sin(turned), abs=EXACT)


def motion(text, name, end=0.3):
    t = np.linspace(0.0, end, 7)
    return t, rt.loads(text).kinematics(t)[name]


SIX = {
    "four-bar": (fourbar, check_fourbar), "slider-crank": (slider_crank, check_slider_crank),
    "scotch yoke": (scotch_yoke, check_scotch_yoke), "wiper": (wiper, check_wiper),
    "planetary": (planetary, check_planetary), "scissor lift": (scissor_lift, check_scissor_lift),
}  # fmt: skip


@pytest.mark.parametrize("name", SIX)
def test_a_mechanism_is_drawn_dragged_saved_and_undone_to_the_last_byte(sheet, drawn, name):
    draw, check = SIX[name]
    hand = sheet(viewport={"width": 1280, "height": 800})
    point, to = draw(hand)
    assert hand.status.endswith("moves")
    finished = hand.text
    check(finished)
    assert "# a sheet of Monday" in finished
    assert "# keep me" in finished
    keep_picture(hand.page, f"drawn_{name.replace(' ', '_').replace('-', '_')}")
    hand.act("Select", point, to, drag=True)
    hand.page.keyboard.press("Control+s")
    hand.page.get_by_role("button", name="Overwrite").click()
    shows(hand.page.locator(".file-name b"), "detached")  # nothing is unsaved
    assert (drawn.folder / "m.toml").read_text() == hand.text
    hand.undo()
    assert hand.text == finished
    hand.acts -= 1
    assert hand.undo_all() == EMPTY
