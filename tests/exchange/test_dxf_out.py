"""Mechanisms drawn as DXF: what a reader of the drawing finds is what the model says."""

import json
import math

import pytest
from click.testing import CliRunner

import rattle as rt
from rattle.cli.main import main
from rattle.equations.placement import point_at, pose
from rattle.exchange.dxf.read import read_dxf
from rattle.exchange.dxf.write import dxf_of
from rattle.exchange.imported import Assumptions
from rattle.loading import examples


def pairs_of(text):
    lines = text.splitlines()
    return list(zip(map(int, lines[::2]), lines[1::2], strict=True))


def entities_of(text):
    """Kind, layer and all values by code of what is drawn."""
    pairs = pairs_of(text)
    start = next(k for k, pair in enumerate(pairs) if pair == (2, "ENTITIES"))
    found = []
    for code, value in pairs[start + 1 :]:
        if code == 0 and value == "ENDSEC":
            return found
        if code == 0:
            found.append((value, {}))
        else:
            found[-1][1].setdefault(code, []).append(value)
    raise AssertionError("the section does not end")


def loose(joint):
    return joint.clearance > 0 and joint.contact is not None and joint.contact.title != "ideal"


@pytest.mark.parametrize("name", sorted(examples()))
def test_a_drawing_gives_bodies_pins_plays_and_places_back(name):
    """Every shipped example.  Places to 1e-9 of the mechanism: a drawing in mm has all digits."""
    m = rt.example(name)
    text, notes = dxf_of(m)
    read = rt.loads(json.dumps(read_dxf(text, name, Assumptions()).document))
    bodies = {body for body in m.model.bodies if not body.startswith("ground.")}
    assert set(read.model.bodies) == bodies
    pins = [joint for joint in m.model.joints.values() if joint.kind == "revolute"]
    q, q2 = m.start.q, read.start.q

    def seen(mechanism, places, joints):
        rows = [
            (*map(float, point_at(mechanism.system, places, joint.a)), joint.clearance if loose(joint) else 0.0)
            for joint in joints
        ]
        return sorted((round(x / size, 8), round(y / size, 8), play) for x, y, play in rows)

    size = m.system.extent
    before, after = seen(m, q, pins), seen(read, q2, read.model.joints.values())
    assert [row[:2] for row in after] == [pytest.approx(row[:2], abs=2e-8) for row in before]
    if not any("several pins" in note for note in notes):
        assert [row[2] for row in after] == pytest.approx([row[2] for row in before], rel=1e-11)
        wanted = {
            (frozenset((joint.a.body.split(".")[0], joint.b.body)), joint.a.body.split(".")[0])
            for joint in pins
            if loose(joint)
        }
        sides = {
            (frozenset((joint.a.body, joint.b.body)), joint.a.body)
            for joint in read.model.joints.values()
            if loose(joint)
        }
        assert sides == wanted
    for body in bodies:
        assert pose(read.system, q2, body)[2] == pytest.approx(0.0, abs=1e-9)


NAMED = """\
format = 1
[ground.points]
O = [0.1, 0.2]
[bodies.arm]
polygon = [[0, 0], ["30 mm", 0], ["30 mm", "10 mm"], [0, "10 mm"]]
holes = [[["20 mm", "3 mm"], ["25 mm", "3 mm"], ["25 mm", "6 mm"]]]
mass = 1
points = { P = ["5 mm", "5 mm"], Q = ["28 mm", "5 mm"] }
[bodies.tip]
bar = ["A", "B"]
length = 0.05
mass = 1
[joints.O]
type = "revolute"
connect = ["ground.O", "arm.P"]
[joints.Q]
type = "revolute"
connect = ["arm.Q", "tip.A"]
clearance = "0.123 mm"
contact = { model = "impact", bush_radius = "1.7 mm" }
[initial]
arm = { angle = "90 deg" }
tip = { angle = 0 }
"""


APART = """connect = ["ground.O", "arm.P"]
[joints.far]
type = "revolute"
connect = ["ground.O", "tip.B"]
"""


def test_lengths_are_in_mm_and_play_is_two_circles_about_the_bush():
    text, _ = dxf_of(rt.loads(NAMED))
    pairs = pairs_of(text)
    assert pairs[pairs.index((9, "$ACADVER")) + 1] == (1, "AC1015")
    assert pairs[pairs.index((9, "$INSUNITS")) + 1] == (70, "4")
    drawn = entities_of(text)
    circles = {
        own[8][0]: (own[10][0], own[20][0], own[40][0])
        for kind, own in drawn
        if kind == "CIRCLE" and float(own[20][0]) > 210
    }
    # the arm is turned by 90 deg: Q is 23 mm above O
    assert {layer: float(radius) for layer, (_, _, radius) in circles.items()} == {"arm": 1.7, "tip": 1.577}
    assert circles["tip"][2] == "1.577"
    for x, y, _ in circles.values():
        assert (float(x), float(y)) == pytest.approx((100, 223), abs=1e-12)
    outlines = [own for kind, own in drawn if kind == "LWPOLYLINE" and own[8] == ["arm"]]
    assert [own[70] for own in outlines] == [["1"], ["1"]]
    corners = list(zip(map(float, outlines[0][10]), map(float, outlines[0][20]), strict=True))
    want = [(105, 195), (105, 225), (95, 225), (95, 195)]
    assert corners == [pytest.approx(corner, abs=1e-10) for corner in want]


def test_the_outline_of_a_plate_has_its_mass_again():
    text, _ = dxf_of(rt.loads(NAMED))
    arm = read_dxf(text, "x", Assumptions(thickness=1.0, density=1.0)).document["bodies"]["arm"]
    assert arm["mass"] == pytest.approx(300e-6 - 7.5e-6, rel=1e-12)


def test_handles_are_unique_and_the_next_one_is_free():
    pairs = pairs_of(dxf_of(rt.example("planetary"))[0])
    seed = pairs.index((9, "$HANDSEED"))
    handles = [int(value, 16) for k, (code, value) in enumerate(pairs) if code in (5, 105) and k != seed + 1]
    assert len(set(handles)) == len(handles)
    assert max(handles) < int(pairs[seed + 1][1], 16)
    owners = {int(value, 16) for code, value in pairs if code in (330, 350)}
    assert owners - {0} <= set(handles)


def test_other_programs_find_no_fault(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    for name in examples():
        path = tmp_path / f"{name}.dxf"
        path.write_text(dxf_of(rt.example(name))[0], encoding="ascii")
        audit = ezdxf.readfile(path).audit()
        assert not audit.errors
        assert not audit.fixes


def test_the_command_writes_a_drawing_and_says_what_is_not_in_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(main, ["draw", "slider_crank_play", "-o", "s.dxf"])
    assert done.exit_code == 0, done.output
    assert "s.dxf" in done.output
    assert "guide" in done.output
    layers = {own[8][0] for _, own in entities_of((tmp_path / "s.dxf").read_text(encoding="ascii"))}
    assert {"crank", "rod", "slider", "ground"} <= layers
    assert CliRunner().invoke(main, ["draw", "slider_crank_play", "-o", "missing/s.dxf"]).exit_code == 2
    wrong = CliRunner().invoke(main, ["draw", "slider_crank_play", "-o", "s.dwg"])
    assert wrong.exit_code == 2
    assert ".dxf" in wrong.output


def test_a_mechanism_that_does_not_close_is_not_drawn_and_no_file_is_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "far.toml").write_text(NAMED.replace('connect = ["ground.O", "arm.P"]', APART))
    done = CliRunner().invoke(main, ["draw", "far.toml", "-o", "far.dxf"])
    assert done.exit_code == 2
    assert "outside its clearance" in done.output
    assert not (tmp_path / "far.dxf").exists()


def test_names_that_differ_in_case_alone_and_a_body_like_the_ground_have_layers_of_their_own():
    text = NAMED.replace("bodies.arm", "bodies.Ground").replace('"arm.', '"Ground.').replace("arm =", "Ground =")
    text = text.replace("bodies.tip", "bodies.GROUND").replace('"tip.', '"GROUND.').replace("tip =", "GROUND =")
    layers = {own[8][0] for _, own in entities_of(dxf_of(rt.loads(text))[0])}
    assert len({layer.lower() for layer in layers}) == 3
    assert "ground" in layers


def test_a_cam_is_as_near_to_its_curve_as_is_said():
    """An eccentric disc about a point beside its centre: a circle, known exactly."""
    text, notes = dxf_of(rt.loads(CAM))
    (note,) = [note for note in notes if note.startswith("lift")]
    tolerance = float(note.split("within ")[1].split(" m")[0])
    (own,) = [own for kind, own in entities_of(text) if kind == "LWPOLYLINE" and own[8] == ["disc"]]
    corners = [(float(x) / 1e3, float(y) / 1e3) for x, y in zip(own[10], own[20], strict=True)]
    middles = [((x + u) / 2, (y + v) / 2) for (x, y), (u, v) in zip(corners, [*corners[1:], corners[0]], strict=True)]
    worst = max(abs(math.dist(p, (0.01, 0.0)) - 0.03) for p in [*corners, *middles])
    assert 0.5 * worst < tolerance < 2 * worst


CAM = """\
format = 1
[ground.points]
O = [0, 0]
G = [0, 0.1]
[bodies.disc]
points = { C = [0, 0] }
mass = 1
inertia = 1e-3
[bodies.arm]
points = { P = [0, 0] }
mass = 1
inertia = 1e-3
[joints.O]
type = "revolute"
connect = ["ground.O", "disc.C"]
[joints.guide]
type = "prismatic"
connect = ["ground.G", "arm.P"]
axis = "90 deg"
[joints.lift]
type = "cam"
connect = ["disc.C", "arm.P"]
radius = "0.01*cos(a) + sqrt(0.03**2 - (0.01*sin(a))**2)"
[initial]
disc = { angle = 0 }
"""
