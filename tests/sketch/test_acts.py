"""Acts of drawing: what each writes, and that the picture is what was drawn."""

import math
import random
from collections import Counter

import numpy as np
import pytest
from sheet import EMPTY, PINS, SNAP, Sheet, fourbar

import rattle as rt
from rattle.errors import InputError, ModelError
from rattle.sketch.acts import act
from rattle.sketch.drawn import drawn
from rattle.sketch.freedoms import freedoms
from rattle.sketch.picture import picture_of


def near(spots, wanted, within=1e-12):
    """True if spots are where they are wanted."""
    return np.allclose(np.array(spots), np.array(wanted), rtol=0, atol=within)


def ends(sheet):
    """Lengths of all bars as they are drawn."""
    return {name: math.dist(*(sheet.place(f"{name}.{end}") for end in entry["bar"]))
            for name, entry in sheet.table["bodies"].items() if "bar" in entry}  # fmt: skip


def test_a_four_bar_is_drawn_with_its_lengths_its_motor_and_its_comments():
    sheet = fourbar()
    table = sheet.table
    assert near([pin.at for pin in sheet.sketch.pins], PINS)
    assert list(ends(sheet).values()) == pytest.approx(
        [0.06, math.hypot(0.16, 0.08), math.hypot(0.04, 0.14)], abs=1e-13
    )
    assert table["drivers"] == {"motor": {"joint": "J1", "angle": "90 deg + 60 rpm*t"}}
    assert [body["mass"] for body in table["bodies"].values()] == [0.06, 0.18, 0.15]  # 1 kg/m, two digits
    assert sheet.sketch.text.startswith(EMPTY)
    r = rt.loads(sheet.sketch.text).kinematics([0.0, 0.25])
    assert r["bar1.angle"] == pytest.approx([math.pi / 2, math.pi], abs=1e-12)
    assert r["bar1.omega"] == pytest.approx(2 * math.pi)


def test_the_status_leads_a_newcomer():
    sheet = Sheet()
    lines = [freedoms(sheet.sketch)]
    sheet.ground(PINS[0], PINS[3])
    lines.append(freedoms(sheet.sketch))
    sheet.bars(*PINS)
    lines.append(freedoms(sheet.sketch))
    sheet.do("motor", at=sheet.at(*PINS[0]))
    lines.append(freedoms(sheet.sketch))
    sheet.bars(PINS[2], (0.0, -0.05))
    sheet.do("ground", at=sheet.at(0.0, -0.05))
    lines.append(freedoms(sheet.sketch))
    assert lines == [
        "Put two ground points, then draw bars between them.",
        "Draw bars between the ground points: drag from one point to the next.",
        "4 joints, no motors: 1 freedom without a motor",
        "4 joints, 1 motor: moves",
        "6 joints, 1 motor: cannot move: 1 constraint too many (J6)",
    ]


def test_play_is_written_as_typed_with_a_contact_and_taken_back():
    sheet = fourbar()
    before = sheet.sketch.text
    sheet.type("joint J3", "Play", "0.2 mm")
    assert sheet.table["joints"]["J3"] == {
        "type": "revolute", "connect": ["bar2.B", "bar3.A"], "clearance": "0.2 mm", "contact": "impact",
    }  # fmt: skip
    sheet.type("joint J3", "Contact", "massless-link")
    assert sheet.table["joints"]["J3"]["contact"] == "massless-link"
    sheet.type("joint J3", "Play", "")
    assert sheet.sketch.text == before


def test_a_dragged_pin_takes_both_bars_along_and_nothing_else():
    sheet = fourbar()
    before = sheet.table
    sheet.do("drop", point="bar2.B", to=sheet.at(0.06, 0.08))
    table = sheet.table
    assert sheet.place("bar2.B") == pytest.approx((0.06, 0.08), abs=1e-14)
    assert sheet.place("bar3.A") == pytest.approx((0.06, 0.08), abs=1e-14)
    assert near([sheet.place(end) for end in ("bar2.A", "bar3.B")], [PINS[1], PINS[3]])
    assert {**table, "bodies": 0, "initial": 0} == {**before, "bodies": 0, "initial": 0}
    assert table["bodies"]["bar1"] == before["bodies"]["bar1"]
    assert table["bodies"]["bar2"]["length"] == pytest.approx(math.hypot(0.18, 0.06), rel=1e-12)


def test_a_turned_crank_starts_where_it_was_put():
    sheet = fourbar()
    sheet.do("drop", point="bar1.B", to=sheet.at(-0.06, -0.04))
    assert sheet.table["drivers"]["motor"]["angle"] == "0 deg + 60 rpm*t"
    assert sheet.place("bar2.B") == pytest.approx(PINS[2], abs=1e-13)


def test_a_length_that_is_a_parameter_changes_the_parameter_and_an_expression_is_refused():
    text = fourbar().sketch.text.replace("length = 0.06\n", 'length = "l1"\n')
    sheet = Sheet(text.replace("[ground.points]", '[parameters]\nl1 = "60 mm"   # crank\n\n[ground.points]'))
    sheet.do("drop", point="bar1.B", to=sheet.at(-0.12, 0.04))
    assert 'l1 = "80 mm"   # crank' in sheet.sketch.text
    assert "l1 is 80 mm now" in sheet.words
    sheet = Sheet(sheet.sketch.text.replace('length = "l1"', 'length = "2*l1 - 80 mm"'))
    with pytest.raises(InputError, match=r"bar1.length is 2\*l1 - 80 mm: type a number to replace it"):
        sheet.do("drop", point="bar1.B", to=sheet.at(-0.12, 0.02))


def test_a_ground_point_keeps_the_unit_in_which_it_is_written():
    sheet = Sheet(fourbar().sketch.text.replace("O2 = [0.08, -0.04]", 'O2 = ["80 mm", -0.04]   # right'))
    sheet.do("nudge", point="ground.O2", by=[SNAP, 0.0])
    assert 'O2 = ["90 mm", -0.04]   # right' in sheet.sketch.text
    assert sheet.place("bar3.B") == pytest.approx((0.09, -0.04), abs=1e-14)


def test_a_typed_length_closes_the_loop_nearest_to_where_it_was():
    sheet = fourbar()
    sheet.type("body bar2", "Length", "180 mm")
    assert sheet.table["bodies"]["bar2"]["length"] == "180 mm"
    assert ends(sheet) == pytest.approx({"bar1": 0.06, "bar2": 0.18, "bar3": math.hypot(0.04, 0.14)}, abs=1e-12)
    assert math.dist(sheet.place("bar2.B"), PINS[2]) < 0.005


def test_a_length_that_cannot_close_is_refused_with_the_range_of_the_triangle():
    sheet = fourbar()
    reach, rocker = math.dist(PINS[1], PINS[3]), math.hypot(0.04, 0.14)
    with pytest.raises(InputError) as refused:
        sheet.type("body bar2", "Length", "5 m")
    words = str(refused.value).split()
    assert str(refused.value).startswith("length 5 m: the loop of bar2 closes between")
    low, high = float(words[-5]), float(words[-2])
    assert (low, high) == pytest.approx((abs(reach - rocker), reach + rocker), rel=6e-3)


@pytest.mark.parametrize("text", ["abc", "-5 mm", "3 kg", "0", ""])
def test_what_is_no_length_is_refused(text):
    sheet = fourbar()
    with pytest.raises((InputError, ModelError)):
        sheet.type("body bar2", "Length", text)


def test_a_free_bar_grows_along_itself_from_the_end_that_is_pinned():
    sheet = Sheet()
    sheet.bars((0.0, 0.0), (0.03, 0.04))
    sheet.type("body bar1", "Length", "0.1")
    assert near([sheet.place("bar1.A"), sheet.place("bar1.B")], [(0.0, 0.0), (0.06, 0.08)])
    sheet.do("ground", at=sheet.at(0.06, 0.08))
    assert set(sheet.table["initial"]["bar1"]) == {"angle"}  # its pin says where it is
    sheet.type("body bar1", "Length", "50 mm")
    assert sheet.place("bar1.A") == pytest.approx((0.03, 0.04), abs=1e-14)


def test_a_typed_angle_turns_the_mechanism_and_its_motor_starts_there():
    sheet = fourbar()
    sheet.type("body bar1", "Angle", "60 deg")
    assert sheet.table["drivers"]["motor"]["angle"] == "60 deg + 60 rpm*t"
    assert ends(sheet) == pytest.approx(ends(fourbar()), abs=1e-12)
    sheet.type("body bar3", "Angle", "-80 deg")
    assert sheet.sketch.places["bar3"][2] == pytest.approx(math.radians(-80), abs=1e-12)
    with pytest.raises(InputError, match="cannot be at"):
        sheet.type("body bar3", "Angle", "90 deg")


def test_a_name_changes_wherever_it_is_used():
    sheet = fourbar()
    sheet.do("keep", signals={"tip": "bar2.B.x - ground.O1.x"})
    sheet.do("force", **{"from": sheet.at(*PINS[2]), "to": {"at": [0.04, 0.13]}})
    before = sheet.sketch.points
    sheet.type("body bar2", "Name", "coupler")
    assert sheet.table["signals"]["tip"] == "coupler.B.x - ground.O1.x"
    assert sheet.table["loads"]["force1"]["at"] == "coupler.B"
    assert sheet.table["loads"]["force1"]["force"] == [0, 3]  # 1 N for each snap
    assert sorted(sheet.sketch.points.values()) == sorted(before.values())
    sheet.type("joint J1", "Name", "pivot")
    assert sheet.table["drivers"]["motor"]["joint"] == "pivot"
    with pytest.raises(InputError, match="already used"):
        sheet.type("body bar1", "Name", "pivot")


def test_deleting_takes_along_what_cannot_be_without():
    sheet = fourbar()
    sheet.do("spring", **{"from": sheet.at(*PINS[1]), "to": {"at": [0.0, -0.05]}})
    sheet.do("keep", signals={"tip": "bar1.B.y"})
    made = sheet.do("delete", chosen="body bar1")
    assert {key: sorted(sheet.table.get(key, {})) for key in ("bodies", "joints", "drivers", "loads", "signals")} == {
        "bodies": ["bar2", "bar3"], "joints": ["J3", "J4"], "drivers": [], "loads": [], "signals": [],
    }  # fmt: skip
    assert made.words == "deleted bar1, with J1, J2, spring1, tip, motor"
    assert near([sheet.place(end) for end in ("bar2.A", "bar2.B")], [PINS[1], PINS[2]])
    sheet.do("delete", chosen="point ground.O2")
    assert sorted(sheet.table["joints"]) == ["J3"]
    assert near([sheet.place(end) for end in ("bar2.A", "bar3.B")], [PINS[1], PINS[3]])


def test_an_end_is_joined_to_a_point_or_to_the_line_of_a_bar_once():
    sheet = fourbar()
    sheet.bars((0.0, -0.02), (0.02, 0.03))
    sheet.do("drop", point="bar4.B", to=sheet.at(*PINS[2]))
    assert sheet.table["joints"]["J5"]["connect"] == ["bar2.B", "bar4.B"]
    assert sheet.do("drop", point="bar4.B", to={"at": list(PINS[2]), "point": "bar3.A"}) is None
    with pytest.raises(InputError, match="both belong to bar4"):
        sheet.do("drop", point="bar4.A", to={"at": [0, 0], "point": "bar4.B"})
    sheet.do("drop", point="bar4.A", to=sheet.on("bar1", -0.12, -0.001))
    assert sheet.table["bodies"]["bar1"]["points"] == {"C": [0.01, 0]}  # in half snaps from the end
    assert sheet.place("bar4.A") == pytest.approx((-0.12, 0.0), abs=1e-14)


def test_bars_that_cross_are_pinned_where_they_do():
    sheet = Sheet()
    sheet.bars((-0.06, 0.0), (0.06, 0.06))
    sheet.bars((-0.06, 0.06), (0.06, -0.001))
    sheet.do("pin", at=sheet.on("bar1", 0.001, 0.0305))
    first, second = (sheet.place(f"bar{k}.C") for k in (1, 2))
    share = np.linalg.solve([[0.12, -0.12], [0.06, 0.061]], [0.0, 0.06])[0]
    assert first == pytest.approx((-0.06 + 0.12 * share, 0.06 * share), abs=1e-12)
    assert first == pytest.approx(second, abs=1e-12)


def test_a_scotch_yoke_follows_the_cosine_of_its_crank():
    sheet = Sheet()
    sheet.ground((0, 0))
    sheet.bars((0, 0), (0.03, 0))
    sheet.bars((0.03, -0.06), (0.03, 0.06))
    sheet.do("slider", at=sheet.at(0.03, -0.06), along=0.0)
    sheet.type("joint J3", "Kind", "fixed")
    sheet.do(
        "slot", **{"from": sheet.on("bar2", 0.03, -0.04), "to": sheet.on("bar2", 0.03, 0.04)}, held=sheet.at(0.03, 0)
    )
    sheet.do("motor", at=sheet.at(0, 0))
    assert freedoms(sheet.sketch) == "4 joints, 1 motor: moves"
    r = rt.loads(sheet.sketch.text).kinematics(np.linspace(0, 1, 21))
    assert r["bar2.x"] == pytest.approx(0.03 * np.cos(2 * math.pi * r.t), abs=1e-12)


def test_a_planet_rolls_on_its_sun():
    sheet = Sheet()
    sheet.ground((0, 0))
    sheet.bars((0, 0), (0.08, 0))
    sheet.do("gear", **{"from": sheet.at(0, 0), "to": sheet.at(0.08, 0)})
    sheet.do("motor", at=sheet.at(0, 0))
    assert freedoms(sheet.sketch) == "4 joints, 1 motor: 1 freedom without a motor"
    sheet.do("motor", at=sheet.at(0, 0))  # of the sun, which would turn freely
    sheet.type("driver motor2", "Speed", "0 rpm")
    r = rt.loads(sheet.sketch.text).kinematics([0, 0.2])
    assert r["wheel2.omega"] == pytest.approx(2 * r["bar1.omega"])  # Willis: 1 + 40/40
    assert sheet.do("motor", at=sheet.at(0, 0)).field == "Speed"


def test_a_plate_has_its_corners_where_they_were_clicked_and_moves_one():
    sheet = fourbar()
    corners = [sheet.at(*PINS[2]), sheet.at(0.1, 0.1), sheet.at(0.1, 0.14)]
    sheet.do("plate", corners=corners)
    assert near([sheet.place(f"plate1.{sign}") for sign in "ABC"], [PINS[2], (0.1, 0.1), (0.1, 0.14)])
    m = rt.loads(sheet.sketch.text)
    assert m.model.bodies["plate1"].mass == pytest.approx(0.5 * 0.06 * 0.04 * 0.005 * 7850)
    sheet.do("drop", point="plate1.C", to=sheet.at(0.08, 0.16))
    assert sheet.place("plate1.C") == pytest.approx((0.08, 0.16), abs=1e-12)
    assert sheet.place("plate1.B") == pytest.approx((0.1, 0.1), abs=1e-12)
    assert rt.loads(sheet.sketch.text).model.bodies["plate1"].mass == pytest.approx(0.5 * 0.06 * 0.06 * 0.005 * 7850)


def test_a_loop_that_does_not_close_is_drawn_and_shows_where_it_is_open():
    text = fourbar().sketch.text.replace("length = 0.06\n", "length = 0.6\n")
    sketch = drawn(text, before=fourbar().sketch.places)
    assert sketch.open_joints
    assert "does not close, open at" in freedoms(sketch)
    assert all(math.isfinite(value) for place in sketch.places.values() for value in place)
    assert any(joint["apart"] > 0.01 for joint in picture_of(sketch)["joints"])


def test_words_of_what_makes_no_sense():
    sheet = fourbar()
    for name, message, words in (
        ("motor", {"at": {"at": [0.3, 0.3]}}, "no pin or slider here"),
        ("force", {"from": sheet.at(*PINS[0]), "to": {"at": [1, 1]}}, "acts on a body"),
        ("spring", {"from": sheet.at(*PINS[0]), "to": sheet.at(*PINS[3])}, "does nothing"),
        ("plate", {"corners": [sheet.at(0, 0), sheet.at(0.1, 0), sheet.at(0.2, 0)]}, "no plate"),
        ("pin", {"at": {"at": [0.3, 0.3]}}, "no body here"),
        ("drop", {"point": "bar9.A", "to": sheet.at(0, 0)}, "no point 'bar9.A'"),
        ("paint", {}, "no act 'paint'"),
    ):
        before = sheet.sketch.text
        with pytest.raises(InputError, match=words):
            sheet.do(name, **message)
        assert sheet.sketch.text == before


SLIDING = {"slot", "prismatic", "gear"}  # joints that may say otherwise where a point goes


def test_random_acts_draw_what_was_meant():
    """Bodies that an act does not concern stand; a point is where it was put; comments stay; nothing crashes."""
    looked = Counter(name for seed in range(12) for name in looked_at(random.Random(seed), Sheet(EMPTY)))
    assert min(looked["stood"] // 12, looked["nudge"], looked["drop"]) > 3, looked  # enough of each was looked at


def looked_at(chance, sheet):
    """Do random acts and look at each; what was looked at."""
    for _ in range(26):
        before, message = sheet.sketch, some_act(chance, sheet.sketch)
        try:
            made = sheet.do(**message)
        except (InputError, ModelError):
            assert sheet.sketch is before
            continue
        sketch = sheet.sketch
        assert all(comment in sketch.text for comment in ("# by hand", "# down"))
        if made is None or before.trouble or sketch.trouble:
            continue
        assert not sketch.open_joints
        picture_of(sketch)
        size = max(sketch.size, before.size)
        if message["name"] not in ("drop", "nudge", "delete", "type", "slot"):
            stood = [(before.points[name], sketch.points[name]) for name in before.points.keys() & sketch.points.keys()]
            assert all(math.dist(*pair) < 1e-8 * size for pair in stood), message
            yield "stood"
        target = put_at(message, before)
        if target is not None and not SLIDING & {pin.kind for pin in before.pins}:
            assert math.dist(sketch.points[message["point"]], target) < 1e-8 * size, message
            yield message["name"]


def put_at(message, sketch):
    """Where an act puts a point; None for acts that do not, and for points on lines of bars, which are in steps."""
    if message["name"] == "nudge":
        x, y = sketch.points[message["point"]]
        return x + message["by"][0], y + message["by"][1]
    if message["name"] != "drop" or "line" in message["to"]:
        return None
    return sketch.points[message["to"]["point"]] if "point" in message["to"] else message["to"]["at"]


def some_act(chance, sketch):
    """A random act on what is there."""

    def spot():
        bars = [name for name, entry in sketch.document.get("bodies", {}).items() if "bar" in entry]
        if sketch.points and chance.random() < 0.5:
            name = chance.choice(list(sketch.points))
            return {"at": list(sketch.points[name]), "point": name}
        if bars and chance.random() < 0.3:
            body, share = chance.choice(bars), chance.random()
            p, q = (sketch.points[f"{body}.{end}"] for end in sketch.document["bodies"][body]["bar"])
            return {"at": [p[k] + share * (q[k] - p[k]) for k in (0, 1)], "line": body}
        return {"at": [chance.randint(-10, 10) * 2 * SNAP, chance.randint(-8, 8) * 2 * SNAP]}

    point = chance.choice(list(sketch.points) or ["ground.none"])
    chosen = chance.choice(["point ground.O1", *(f"body {name}" for name in sketch.bodies)])
    acts = [
        {"name": "ground", "at": spot()},
        *3 * [{"name": "bar", "from": spot(), "to": spot()}],
        {"name": "plate", "corners": [spot() for _ in range(4)]},
        {"name": "pin", "at": spot()},
        {"name": "slider", "at": spot(), "along": chance.choice([0.0, 0.5])},
        {"name": "slot", "from": spot(), "to": spot(), "held": spot()},
        {"name": "gear", "from": spot(), "to": spot()},
        {"name": "motor", "at": spot()},
        {"name": "spring", "from": spot(), "to": spot()},
        {"name": "force", "from": spot(), "to": {"at": [0.3, 0.2]}},
        *3 * [{"name": "drop", "point": point, "to": spot()}],
        *3 * [{"name": "nudge", "point": point, "by": [SNAP, -SNAP]}],
        {"name": "delete", "chosen": chosen},
        {"name": "type", "chosen": chosen, "field": chance.choice(["Length", "Angle", "X"]), "text": "0.1"},
    ]
    return chance.choice(acts)


def test_acts_are_plain_data_and_wrong_ones_are_answered():
    sketch = drawn(EMPTY)
    for message in ({"act": "bar", "from": 1, "to": 2}, {"act": "ground", "at": {"at": ["x", 1]}}, {"act": "ground"}):
        with pytest.raises(InputError):
            act(sketch, message)


def test_a_body_is_turned_in_a_model_whose_table_lies_beside_it(tmp_path):
    (tmp_path / "push.csv").write_text("t,f\n0,0\n1,1\n")
    file = str(tmp_path / "m.toml")
    text = fourbar().sketch.text + '[tables.push]\nfile = "push.csv"\n'
    made = act(drawn(text, file), {"act": "type", "chosen": "body bar1", "field": "Angle", "text": "93 deg"}, file)
    assert made.sketch.places["bar1"][2] == pytest.approx(math.radians(93), abs=1e-9)


def test_a_body_whose_joint_goes_with_its_point_stays_where_it_is():
    sheet = Sheet(
        "format = 1\n[ground.points]\nO = [0.3, 0.2]\n"
        "[bodies.b]\npoints = { P = [0, 0], Q = [0.05, 0.02] }\nmass = 1\ninertia = 0.01\n"
        '[joints.J]\ntype = "revolute"\nconnect = ["ground.O", "b.P"]\n'
    )
    stands = sheet.place("b.Q")
    sheet.do("delete", chosen="point b.P")
    assert sheet.place("b.Q") == pytest.approx(stands, abs=1e-12)
    assert sheet.words == "deleted b.P, with J"
