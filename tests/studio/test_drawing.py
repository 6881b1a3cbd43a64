"""Mechanisms drawn on the sheet of the studio in a real browser: the text that is written, and the way back."""

import json
import math
import struct
import zlib

import numpy as np
import pytest
from drawing import EMPTY, Hand, apart, at
from studio_models import start_studio

import rattle as rt
from browsing import becomes, frames, keep_picture, shows

SMALL = """() => [...document.querySelectorAll("button, input, select")].map((el) => el.getBoundingClientRect())
  .filter(({ width, height }) => width && Math.min(width, height) < 24).length"""  # how many targets
# a machine that is busy may take longer over a tap than a finger that rests does: let that take two seconds
PATIENT = "const soon = setTimeout; window.setTimeout = (call, wait) => soon(call, wait === 550 ? 2000 : wait)"
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

    def opened(text=EMPTY, script="", **options):
        (drawn.folder / "m.toml").write_text(text)
        page = open_page("about:blank", **options)
        page.add_init_script("localStorage.setItem('rattle-studio-hints', 'seen')")
        page.add_init_script(script)
        if options.get("has_touch"):
            page.add_init_script(PATIENT)
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
    for first, last in (
        (at(-10, 0), at(-10, 2)),
        (at(-10, 2), at(0, 4)),
        (at(0, 4), at(0, 0)),
        (at(0, 4), at(12, 4)),
        (at(12, 4), at(12, 0)),
    ):
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

MORE = ("four-bar", "slider-crank", "wiper")  # the others have every tool; keys and a finger draw two of these


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.long if name in MORE else ()) for name in SIX])
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


# ---------------------------------------------------------------- a slow connection
# what the studio says is kept back while `held` is a list
SLOW = """const Fast = window.WebSocket; window.WebSocket = class extends Fast {
  addEventListener(name, call) {
    const kept = (event) => (window.held ? window.held.push(() => call(event)) : call(event));
    super.addEventListener(name, name === "message" ? kept : call);
  }
};
window.letThrough = () => { const held = window.held; window.held = null; for (const call of held) call(); };"""
SAID = "(count) => window.held.length >= count"


def hold(hand):
    hand.page.evaluate("window.held = []")


def let_through(hand, said=3):
    """Let through what the studio has said, when that is so much: text, name and drawing of an act."""
    becomes(hand.page, SAID, said)
    hand.page.evaluate("window.letThrough()")
    hand.rests()


def test_acts_before_the_answer_to_the_one_before_catch_what_that_has_drawn(sheet):
    hand = sheet(script=SLOW)
    hold(hand)
    hand.take("Bar")
    hand.drag(at(0, 0), at(4, 0))
    hand.drag(at(4, 0), at(4, 4))
    hand.drag(at(4, 4), at(0, 0))
    let_through(hand)
    ends = [joint["connect"] for joint in hand.table["joints"].values()]
    assert ends == [["bar1.B", "bar2.A"], ["bar2.B", "bar3.A"], ["bar1.A", "bar3.B"]]
    hand.acts = 3
    assert hand.undo_all() == EMPTY


def test_undo_takes_back_the_act_that_is_under_way_and_not_the_one_before(sheet):
    hand = sheet(script=SLOW)
    before = hand.act("Ground", at(-6, 0))
    hold(hand)
    hand.click(at(0, 0))
    hand.click(at(4, 0))  # waits
    hand.page.keyboard.press("Control+z")
    hand.page.keyboard.press("Control+z")
    let_through(hand)
    assert hand.text == before
    assert hand.page.evaluate("[window.rattle.edit.position('ground.O2')]") == [None]
    hold(hand)
    hand.page.keyboard.press("Control+Shift+z")
    let_through(hand, 1)
    assert list(hand.table["ground"]["points"]) == ["O1", "O2"]
    assert hand.position("ground.O2") == at(0, 0)
    assert hand.undo() == before
    assert hand.undo() == EMPTY


def test_undo_of_an_act_that_is_refused_leaves_the_one_before(sheet):
    hand = sheet(script=SLOW)
    before = hand.act("Ground", at(-6, 0))
    hand.take("Pin")
    hold(hand)
    hand.click(at(4, 0))
    hand.page.keyboard.press("Control+z")
    let_through(hand, 1)
    hand.says("there is no body here")
    assert hand.text == before
    assert hand.undo() == EMPTY


# ---------------------------------------------------------------- fingers, keys
# what is chosen when a finger has rested for three seconds, or before
RESTS = """() => new Promise((done) => {
  const end = performance.now() + 3000, { edit } = window.rattle;
  const look = () => (edit.selected || performance.now() > end ? done(edit.selected) : setTimeout(look, 20));
  look();
})"""


def test_a_finger_draws_on_a_phone_rests_to_choose_and_two_of_them_zoom(sheet):
    hand = sheet(**PHONE)
    slider_crank(hand)
    check_slider_crank(hand.text)
    finished = hand.text
    assert hand.page.evaluate(SMALL) == 0
    panel, board = (hand.page.locator(name).bounding_box() for name in (".edit-panel", ".board"))
    assert panel["y"] >= board["y"] + board["height"] - 1  # the fields lie on nothing that is drawn
    hand.take("Bar")
    hand.fingers("touchStart", hand.screen(at(-6, 3)))
    assert hand.page.evaluate(RESTS) == "joint J2"  # a finger that rests, whatever the tool
    hand.fingers("touchEnd")
    wide = apart(hand.screen(at(0, 0)), hand.screen(at(1, 0)))
    hand.fingers("touchStart", (100, 350))
    hand.fingers("touchStart", (100, 350), (200, 350))
    hand.fingers("touchMove", (50, 350), (250, 350))
    hand.fingers("touchEnd")
    assert apart(hand.screen(at(0, 0)), hand.screen(at(1, 0))) == pytest.approx(2 * wide, rel=0.02)
    assert hand.text == finished
    keep_picture(hand.page, "drawn_on_a_phone")


def test_a_fourbar_is_drawn_with_keys_alone(sheet):
    hand = sheet(viewport={"width": 1280, "height": 800})
    snap = hand.page.evaluate("window.rattle.edit.snap")
    assert snap == 0.01
    press = hand.page.keyboard.press
    arrows = {(1, 0): "ArrowRight", (-1, 0): "ArrowLeft", (0, 1): "ArrowUp", (0, -1): "ArrowDown"}

    def go(dx, dy):
        for axis, steps in enumerate((dx, dy)):
            sign = int(math.copysign(1, steps))
            key = arrows[(sign, 0) if axis == 0 else (0, sign)]
            for many, name in ((abs(steps) // 10, f"Shift+{key}"), (abs(steps) % 10, key)):
                for _ in range(many):
                    press(name)

    def enter():
        before = hand.text
        press("Enter")
        hand.acts += 1
        return hand.becomes_text(before)

    press("o")
    press("Enter")  # the cross hair appears in the middle
    go(-6, -2)
    hand.says("-60 mm, -20 mm")
    enter()
    go(10, 0)
    enter()
    press("b")
    go(-10, 0)
    for dx, dy in ((0, 3), (8, 4), (2, -7)):
        press("Enter")
        go(dx, dy)
        enter()
    press("m")
    go(-10, 0)
    enter()
    press("v")
    told = []
    while len(told) < 12 and not any("bar2 and bar3" in word for word in told):
        press("Tab")
        told.append(hand.word)
    assert told[0] == "joint J1, ground and bar1"
    assert told[-1] == "joint J3, bar2 and bar3"
    before = hand.text
    hand.page.keyboard.type("0.2 mm")  # digits go into its play
    press("Enter")
    hand.acts += 1
    hand.becomes_text(before)
    assert hand.table["joints"]["J3"]["clearance"] == "0.2 mm"
    lengths = sorted(entry["length"] for entry in hand.table["bodies"].values())
    assert lengths == pytest.approx(sorted([3 * snap, math.sqrt(80) * snap, math.sqrt(53) * snap]), abs=EXACT)
    assert hand.undo_all() == EMPTY


# ---------------------------------------------------------------- changing
def test_values_that_cannot_be_are_refused_with_a_word_and_the_text_stays(sheet):
    hand = sheet(FOURBAR)
    (left, _), (right, _) = hand.screen(O1), hand.screen(O4)
    assert right - left > 0.4 * hand.page.locator(".board").bounding_box()["width"]  # a model is shown as a whole
    hand.take("Select")
    hand.click(at(-2, 3))
    for value, words in (("abc", "abc"), ("-5 mm", "length"), ("3 kg", "length"), ("5 m", "closes between")):
        length = hand.field("Length")
        length.fill(value)
        length.press("Enter")
        shows(hand.page.locator(".edit-panel [role=alert]", has_text=words))
        assert length.get_attribute("aria-invalid") == "true"
        assert hand.text == FOURBAR
    length.press("Escape")
    assert length.input_value() == "0.17888543819998318 m"
    hand.drag(B, at(3, 5))  # the rocker's length is an expression
    hand.says("rocker.length is 2.4*l1 + 0.00160219778561037: type a number to replace it")
    hand.drag(A, B)
    hand.says("let go elsewhere")
    assert hand.text == FOURBAR


def test_a_double_click_on_the_label_opens_its_field_and_alt_puts_a_point_beside_the_grid(sheet):
    hand = sheet(FOURBAR)
    hand.take("Select")
    hand.click(at(-2, 3))
    becomes(hand.page, "window.rattle.edit.selected === 'body coupler'")
    frames(hand.page)
    x, y = hand.screen(at(-2, 3))
    hand.page.mouse.dblclick(x + 60, y - 18)
    becomes(hand.page, "document.activeElement.getAttribute('aria-label') === 'Length'")
    hand.page.keyboard.press("Escape")
    hand.page.keyboard.down("Alt")
    hand.act("Ground", (0.0, -0.0633))
    hand.page.keyboard.up("Alt")
    _, y = hand.table["ground"]["points"]["O2"]
    assert abs(y + 0.0633) < 0.001
    assert abs(y / 0.001 - round(y / 0.001)) > 1e-6
    assert hand.undo_all() == FOURBAR


def test_tools_rest_while_the_text_has_an_error_and_undo_goes_through_text_knobs_and_drawing(sheet):
    hand = sheet(FOURBAR)
    hand.act("Ground", at(0, -3))
    before = hand.text
    hand.page.locator("#knob-l1").press("ArrowRight")
    hand.becomes_text(before)
    hand.page.get_by_role("tab", name="Text").click()
    area, good = hand.page.locator("textarea.area"), hand.text
    area.fill(good.replace("mass = 0.3", "mass = = 0.3"))
    hand.page.get_by_role("tab", name="Motion").click()
    line = good[: good.index("mass = 0.3")].count("\n") + 1
    hand.says(f"line {line}")
    assert hand.page.get_by_role("button", name="Bar", exact=True).is_disabled()
    assert hand.undo() == good
    assert hand.page.get_by_role("button", name="Bar", exact=True).is_enabled()
    assert hand.undo() == before
    assert hand.undo() == FOURBAR


# the places of points at the very instant at which the button is pressed: answers to the hand may still come
STARTS = """(names) => {
  const ends = Object.fromEntries(names.map((name) => [name, window.rattle.edit.position(name)]));
  [...document.querySelectorAll(".edit-panel button")].find((button) => button.textContent === "Start here").click();
  return ends;
}"""


def test_a_body_is_turned_by_hand_and_the_motion_starts_there(sheet):
    hand = sheet(FOURBAR)
    hand.take("Select")
    hand.drag(at(-6, -0.4), at(-5, -0.7))
    shows(hand.page.get_by_role("button", name="Start here"))
    becomes(hand.page, "window.rattle.edit.position('crank.A')[0] > -0.11")
    assert hand.text == FOURBAR
    ends = hand.page.evaluate(STARTS, ["crank.O", "crank.A", "coupler.A"])
    assert apart(ends["crank.A"], A) > 0.01
    assert apart(ends["crank.A"], ends["coupler.A"]) < 1e-6
    text = hand.becomes_text(FOURBAR)
    turned = math.atan2(ends["crank.A"][1] - ends["crank.O"][1], ends["crank.A"][0] - ends["crank.O"][0])
    assert motion(text, "crank.angle")[1][0] == pytest.approx(turned, abs=1e-6)
    assert "# the short one" in text
    assert "# worn" in text
    assert hand.undo() == FOURBAR


def test_a_measure_is_told_and_kept_as_a_signal(sheet):
    hand = sheet(FOURBAR)
    hand.take("Measure")
    hand.click(O1)
    hand.click(O4)
    shows(hand.page.locator(".readings", has_text="0.2 m"))
    hand.click(A)  # the third place makes an angle of it
    shows(hand.page.locator(".readings", has_text="16.7 deg"))
    before = hand.text
    hand.page.get_by_role("button", name="Keep").first.click()
    hand.acts += 1
    hand.becomes_text(before)
    (signal,) = hand.table["signals"]
    angle = rt.loads(hand.text).simulate(1e-3)[signal][0]
    assert abs(angle) == pytest.approx(math.atan2(0.06, 0.2), abs=EXACT)  # at O4, between the other two
    assert hand.undo_all() == FOURBAR


def test_a_photograph_lies_below_scaled_by_two_points(sheet):
    hand = sheet()
    before = hand.text
    with hand.page.expect_file_chooser() as chooser:
        hand.take("Picture")
    chooser.value.set_files([{"name": "photo.png", "mimeType": "image/png", "buffer": grey_png(200, 100)}])
    hand.becomes_text(before)
    hand.acts += 1
    becomes(hand.page, "window.rattle.edit.picture !== null")
    scale = hand.page.evaluate("window.rattle.edit.picture.scale")
    hand.click(at(-3, 1))
    hand.says("click a second point")
    hand.click(at(3, 1))
    becomes(hand.page, "document.activeElement.getAttribute('aria-label') === 'Distance'")
    hand.type("Distance", "0.3 m")
    assert hand.page.evaluate("window.rattle.edit.picture.scale") == pytest.approx(scale * 0.3 / 0.12, rel=0.02)
    assert "bodies" not in hand.table
    assert hand.undo_all() == EMPTY


def test_a_model_in_json_is_drawn_on_and_stays_json(sheet):
    text = json.dumps({"format": 1, "ground": {"points": {"O": [0, 0]}}}, indent=2) + "\n"
    hand = sheet(text)
    hand.bar(at(0, 0), at(4, 3))
    body = json.loads(hand.text)["bodies"]["bar1"]
    assert body["length"] == pytest.approx(0.1, abs=EXACT)
    assert hand.undo_all() == text


def grey_png(width, height):
    def part(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = part(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))
    rows = zlib.compress(b"".join(b"\0" + bytes([150] * width) for _ in range(height)))
    return b"\x89PNG\r\n\x1a\n" + head + part(b"IDAT", rows) + part(b"IEND", b"")
