"""Drawings as DXF are mechanisms: layers are bodies, circles about one centre are pins, radii are play."""

import json
import math

import numpy as np
import pytest

import rattle as rt
from dxf_files import arc, box, circle, dxf, imported, insert, line, mechanism, old_outline, outline
from rattle.exchange.dxf.read import read_dxf
from rattle.exchange.imported import Assumptions

pytestmark = pytest.mark.nojit
SHEET = 0.01 * 7850.0  # kg/m^2 of a plate


def crank(layer="crank", r=4.0):
    return [box(layer, -8, -8, 68, 8), circle(layer, 0, 0, r), circle(layer, 60, 0, r)]


# ---------------------------------------------------------------- mass
def test_a_plate_has_the_mass_and_inertia_of_its_area():
    body = mechanism(box("arm", 10, 20, 110, 40), circle("ground", 20, 30, 3), circle("arm", 20, 30, 3)).model.bodies[
        "arm"
    ]
    mass = 0.1 * 0.02 * SHEET
    assert body.mass == pytest.approx(mass, rel=1e-14)
    assert body.inertia == pytest.approx(mass * (0.1**2 + 0.02**2) / 12, rel=1e-13)
    assert body.points["A"] == pytest.approx((-0.04, 0.0), abs=1e-16)


def test_arcs_count_exactly_whatever_the_picture_shows():
    """A bar with round ends and a hole, as bulges and as loose lines and arcs: closed forms to 1e-12."""
    l, s, r = 0.1, 0.01, 0.006
    area = 2 * s * l + math.pi * s * s - math.pi * r * r
    inertia = 2 * s * l * (l * l + 4 * s * s) / 12 + math.pi / 2 * s**4 + math.pi * s * s * l * l / 4 + 4 / 3 * l * s**3
    inertia -= math.pi * r**4 / 2
    drawings = [
        [outline("rod", [(-50, -10), (50, -10, 1.0), (50, 10), (-50, 10, 1.0)])],
        [old_outline("rod", [(-50, -10), (50, -10, 1.0), (50, 10), (-50, 10, 1.0)])],
        [
            line("rod", -50, 10, 50, 10),
            arc("rod", 50, 0, 10, 270, 90),
            line("rod", -50, -10, 50, -10),
            arc("rod", -50, 0, 10, 90, 270),
        ],
    ]
    for drawing in drawings:
        body = mechanism(*drawing, circle("rod", 0, 0, 6)).model.bodies["rod"]
        assert body.mass == pytest.approx(area * SHEET, rel=1e-12)
        assert body.inertia == pytest.approx(inertia * SHEET, rel=1e-12)
        assert body.points["H1"] == pytest.approx((0, 0), abs=1e-12)
        assert len(body.outline) == 2  # the hole is shown


def test_holes_are_no_material_and_islands_in_them_are():
    body = mechanism(box("p", 0, 0, 60, 40), box("p", 10, 10, 50, 30), box("p", 20, 15, 30, 25)).model.bodies["p"]
    assert body.mass == pytest.approx((60 * 40 - 40 * 20 + 100) * 1e-6 * SHEET, rel=1e-13)


def test_a_plate_with_very_many_holes_has_its_mass_and_is_shown_without_them():
    holes = [circle("p", 5 * k + 5, 5 * n + 5, 2) for k in range(40) for n in range(20)]
    read = imported(box("p", 0, 0, 210, 110), *holes)
    body = read.document["bodies"]["p"]
    assert body["mass"] == pytest.approx((210 * 110 - 800 * math.pi * 4) * 1e-6 * SHEET, rel=1e-12)
    assert body["polygon"]
    assert "holes" not in body
    assert any("without its holes" in word for word in read.assumed)


def test_thickness_and_density_are_those_that_are_stated():
    stated = mechanism(*crank(), assumptions=Assumptions(thickness=0.003, density=2700.0)).model.bodies["crank"]
    steel = mechanism(*crank()).model.bodies["crank"]
    assert stated.mass / steel.mass == pytest.approx(0.3 * 2700 / 7850, rel=1e-14)
    words = imported(*crank(), assumptions=Assumptions(thickness=0.003, density=2700.0)).assumed
    assert not any("thick" in word or "steel" in word for word in words)
    assert any("10 mm thick" in word and "7850" in word for word in imported(*crank()).assumed)


def test_a_wheel_is_a_circle_and_a_link_of_circles_is_the_band_around_them():
    disc = mechanism(circle("wheel", 0, 0, 50), circle("wheel", 0, 0, 4), circle("ground", 0, 0, 4.2))
    assert disc.model.bodies["wheel"].mass == pytest.approx(math.pi * 0.05**2 * SHEET, rel=1e-13)
    assert [joint.clearance for joint in disc.model.joints.values()] == pytest.approx([2e-4], rel=1e-14)
    read = imported(circle("link", 0, 0, 10), circle("link", 100, 0, 10))
    assert read.document["bodies"]["link"]["mass"] == pytest.approx((0.1 * 0.02 + math.pi * 1e-4) * SHEET, rel=1e-13)
    assert any("link" in word and "band" in word for word in read.assumed)


# ---------------------------------------------------------------- pins
def test_the_larger_circle_is_the_bush_and_the_difference_the_play():
    read = imported(
        *crank(), circle("rod", 60, 0, 4.25), box("rod", 50, -10, 160, 10), circle("ground", 0, 0, 4)
    ).document
    assert read["joints"] == {
        "A": {"type": "revolute", "connect": ["ground.A", "crank.A"]},
        "B": {"type": "revolute", "connect": ["rod.B", "crank.B"], "clearance": 0.00025,
              "contact": {"model": "impact", "bush_radius": 0.00425}},
    }  # fmt: skip
    assert read["ground"]["points"]["A"] == [0, 0]
    assert read["bodies"]["crank"]["points"]["B"] == [0.06, 0]


def test_three_layers_about_one_centre_are_two_pins():
    """One pin goes through two bushes; a sleeve is a pin outside and a bush inside."""
    arms = [box(name, -10, -10, 90, 10) for name in "abc"]
    through = imported(*arms, circle("a", 0, 0, 5.2), circle("b", 0, 0, 5), circle("c", 0, 0, 5.1)).document["joints"]
    seen = {(joint["connect"][0][0], joint["connect"][1][0], joint["clearance"]) for joint in through.values()}
    assert seen == {("a", "b", 2e-4), ("c", "b", 1e-4)}
    sleeve = [circle("a", 0, 0, 8.3), circle("b", 0, 0, 8), circle("b", 0, 0, 5.1), circle("c", 0, 0, 5)]
    for order in (sleeve, sleeve[::-1]):
        joints = imported(*arms, *order).document["joints"].values()
        seen = {(joint["connect"][0][0], joint["connect"][1][0], joint["clearance"]) for joint in joints}
        assert seen == {("a", "b", 3e-4), ("b", "c", 1e-4)}
    equal = imported(*arms, *(circle(name, 0, 0, 5) for name in "abc")).document["joints"].values()
    assert len(equal) == 2
    assert not any("clearance" in joint for joint in equal)


def test_centres_that_are_not_quite_one_are_no_pin_and_are_named():
    apart = imported(*crank(), circle("ground", 0, 0.01, 4))
    assert "joints" not in apart.document
    assert any("crank" in word and "ground" in word and "0.01" in word for word in apart.left_out)
    assert "joints" in imported(*crank(), circle("ground", 0, 5e-5, 4)).document
    resting = imported(*crank(), circle("ground", 0, 0.5, 4.5))  # the pin rests in its bush
    assert any("crank" in word and "ground" in word and "0.5" in word for word in resting.left_out)


def test_circles_that_cannot_be_a_bush_and_its_pin_have_no_play():
    """A disc of 50 mm on a pin of 5 mm has no play of 45 mm."""
    read = imported(circle("disc", 0, 0, 50), circle("ground", 0, 0, 5))
    (joint,) = read.document["joints"].values()
    assert "clearance" not in joint
    assert any("disc" in word and "no play" in word for word in read.assumed)
    hole = imported(box("plate", -60, -60, 60, 60), circle("plate", 0, 0, 50), circle("ground", 0, 0, 5))
    assert [joint["clearance"] for joint in hole.document["joints"].values()] == [0.045]


def test_circles_of_arcs_and_of_polylines_are_circles():
    two = outline("crank", [(-4, 0, 1.0), (4, 0, 1.0)])
    arcs = [arc("rod", 60, 0, 4.5, 0, 120), arc("rod", 60, 0, 4.5, 240, 360), arc("rod", 60, 0, 4.5, 120, 240)]
    entities = [box("crank", -8, -8, 68, 8), two, circle("crank", 60, 0, 4), circle("ground", 0, 0, 4)]
    read = imported(*entities, *arcs, box("rod", 50, -9, 150, 9)).document["joints"]
    plays = {joint["connect"][0].split(".")[0]: joint.get("clearance", 0.0) for joint in read.values()}
    assert plays == pytest.approx({"ground": 0.0, "rod": 5e-4}, rel=1e-9)


def test_the_mechanism_stands_as_drawn():
    """A four-bar in the crossed position, which no rule would prefer."""
    spots = [(0.0, 0.0), (30.0, 40.0), (20.0, -35.0), (100.0, 0.0)]
    names = ["ground", "a", "b", "c", "ground"]
    entities = [circle(name, *spots[k], 2.0) for k in range(4) for name in names[k : k + 2]]
    m = mechanism(*entities)
    start = m.kinematics([0.0]) if m.model.drivers else m.simulate(1e-6)
    for name, point, (x, y) in (("a", "B", spots[1]), ("c", "C", spots[2]), ("b", "B", spots[1])):
        labels = [n for n in start.names if n.startswith(f"{name}.") and n.endswith(".x") and n.count(".") == 2]
        places = [(start[n][0] * 1e3, start[n[:-1] + "y"][0] * 1e3) for n in labels]
        assert any(math.dist(place, (x, y)) < 1e-6 for place in places), (name, point, places)


# ---------------------------------------------------------------- units and names
@pytest.mark.parametrize(("code", "metres"), [(1, 0.0254), (4, 1e-3), (5, 1e-2), (6, 1.0), (2, 0.3048), (13, 1e-6)])
def test_lengths_have_the_unit_of_the_drawing(code, metres):
    read = imported(*crank(), header=[("9", "$INSUNITS"), ("70", code)])
    assert read.document["bodies"]["crank"]["points"]["H2"] == [float(f"{60 * metres:.15g}"), 0]
    assert not any("INSUNITS" in word for word in read.assumed)


@pytest.mark.parametrize(
    "header",
    [[], [("9", "$INSUNITS"), ("70", 0)], [("9", "$ACADVER"), ("1", "AC1009")], [("9", "$INSUNITS"), ("70", 99)]],
)
def test_a_drawing_without_a_unit_is_in_mm_and_says_so(header):
    read = imported(*crank(), header=header)
    assert read.document["bodies"]["crank"]["points"]["H2"] == [0.06, 0]
    assert any("mm" in word and "INSUNITS" in word for word in read.assumed)
    scaled = imported(*crank(), header=header, assumptions=Assumptions(scale=0.5))
    assert scaled.document["bodies"]["crank"]["points"]["H2"] == [30, 0]


def test_layers_have_names_of_a_model():
    entities = [part for name in ("in", "3 arm", "Stange \\U+00E4", "ground", "arm", "ARM") for part in crank(name)]
    document = imported(*entities).document
    assert set(document["bodies"]) == {"in_", "body_3_arm", "Stange_a", "arm", "ARM"}
    assert document["ground"]["points"]
    rt.loads(json.dumps(document))
    assert "ground" not in imported(*crank("GROUND"), *crank("x")).document["bodies"]


# ---------------------------------------------------------------- blocks and mirrors
def test_blocks_are_placed_turned_scaled_and_mirrored():
    """A block of a half disc and a hole; the same by hand."""
    half = [outline("0", [(-10, 0), (10, 0, 1.0)]), circle("0", 0, 4, 2)]
    placed = insert("arm", "half", 100, 50, ("41", -2), ("42", 2), ("43", 2), ("50", 30))
    body = mechanism(placed, blocks=[("half", (10, 0), half)]).model.bodies["arm"]
    area = math.pi / 2 * 20**2 - math.pi * 16
    assert body.mass == pytest.approx(area * 1e-6 * SHEET, rel=1e-12)
    read = imported(placed, blocks=[("half", (10, 0), half)]).document["bodies"]["arm"]["points"]["H1"]
    c, s = math.cos(math.pi / 6), math.sin(math.pi / 6)
    x, y = -2 * (0 - 10), 2 * 4
    assert read == pytest.approx([(100 + c * x - s * y) / 1e3, (50 + s * x + c * y) / 1e3], rel=1e-13)


def test_blocks_in_blocks_and_rows_of_them():
    """Rows and columns run along the turned axes; layers of a block stay, layer 0 is that of the insert."""
    pin = [circle("0", 0, 0, 3)]
    pair = [insert("0", "pin", 0, 0), insert("other", "PIN", 50, 0)]
    grid = insert("plate", "pair", 10, 10, ("50", 90), ("70", 1), ("71", 2), ("45", 20))
    read = imported(
        box("plate", -50, -50, 90, 90),
        box("other", -50, -50, 90, 90),
        grid,
        blocks=[("pin", (0, 0), pin), ("pair", (0, 0), pair)],
    )
    points = {name: body["points"] for name, body in read.document["bodies"].items()}
    assert sorted(points["plate"].values()) == [pytest.approx([-0.01, 0.01]), pytest.approx([0.01, 0.01])]
    assert sorted(points["other"].values()) == [pytest.approx([-0.01, 0.06]), pytest.approx([0.01, 0.06])]


def test_mirrored_blocks_in_mirrored_blocks_are_where_their_matrices_say():
    """Three levels, every sense of each: the place of a hole, and an arc that has to bulge to its own side."""
    rng = np.random.default_rng(2)
    inner = [outline("0", [(-3, 0), (5, 0, 0.6), (1, 4)]), circle("0", 1, 1.5, 0.5)]
    for _ in range(30):
        whole, blocks = np.eye(3), []
        for level in range(3):
            scale, turn, (x, y) = rng.uniform(0.5, 2), rng.uniform(0, 360), rng.uniform(-9, 9, 2)
            senses, base = rng.choice([-1, 1], 2), rng.uniform(-2, 2, 2)
            c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
            linear = np.array([[c, -s], [s, c]]) @ np.diag(scale * senses)
            own = np.eye(3)
            own[:2, :2], own[:2, 2] = linear, (x, y) - linear @ base
            whole = whole @ own
            sizes = [("41", scale * senses[0]), ("42", scale * senses[1]), ("50", turn)]
            blocks.append((f"b{level}", base, insert("arm" if level == 0 else "0", f"b{level}", x, y, *sizes)))
        entities = [part for _, _, part in blocks]
        nested = [(name, base, [entities[k + 1]] if k < 2 else inner) for k, (name, base, _) in enumerate(blocks)]
        arm = imported(entities[0], blocks=nested).document["bodies"]["arm"]
        plain = imported(
            *[[(code, "arm" if value == "0" and code == "8" else value) for code, value in part] for part in inner]
        )
        straight = plain.document["bodies"]["arm"]
        assert arm["points"]["H1"] == pytest.approx((whole @ (1, 1.5, 1))[:2] / 1e3, abs=1e-13)
        centre = whole @ (*(1e3 * np.array(straight["center"])), 1)
        assert arm["center"] == pytest.approx(centre[:2] / 1e3, abs=1e-13)
        assert arm["mass"] == pytest.approx(straight["mass"] * abs(np.linalg.det(whole)), rel=1e-12)


def test_what_is_seen_from_below_is_mirrored():
    """The extrusion (0, 0, -1) turns x over; lines are in world coordinates all the same."""
    below = ("230", -1)
    read = imported(
        outline("arm", [(0, 0), (20, 0, 0.5), (20, 10)], 1, below), circle("arm", 15, 3, 1, below)
    ).document["bodies"]["arm"]  # fmt: skip
    assert read["points"]["H1"] == [-0.015, 0.003]
    plain = imported(outline("arm", [(0, 0), (-20, 0, -0.5), (-20, 10)]), circle("arm", -15, 3, 1)).document["bodies"][
        "arm"
    ]
    assert read["mass"] == pytest.approx(plain["mass"], rel=1e-14)
    assert read["center"] == pytest.approx(plain["center"], rel=1e-14)
    closed = [line("d", -5, 0, 5, 0), arc("d", 0, 0, 5, 180, 360, below)]
    assert imported(*closed).document["bodies"]["d"]["mass"] == pytest.approx(math.pi / 2 * 25e-6 * SHEET, rel=1e-13)


# ---------------------------------------------------------------- left out, refused
def test_a_body_that_is_a_circle_alone_and_outlines_of_the_ground_are_told():
    read = imported(circle("pin", 0, 0, 4), circle("ground", 0, 0, 4.5), box("ground", -9, -9, 9, 9))
    assert read.document["bodies"]["pin"]["mass"] == pytest.approx(math.pi * 16e-6 * SHEET, rel=1e-13)
    assert any("pin" in word and "disc" in word for word in read.assumed)
    assert any("ground" in word for word in read.left_out)


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_end_as_in_all_programs_and_letters_of_old_code_pages_end_none(end):
    words = [("0", "TEXT"), ("8", "crank"), ("1", "more \x85 \x0c \u2028")]
    text = dxf([*crank(), words]).replace("\n", end)
    assert list(read_dxf(f"\ufeff{text}\n\n", "x", Assumptions()).document["bodies"]) == ["crank"]


def test_what_is_not_taken_is_named_with_its_layer():
    odd = [[("0", kind), ("8", "crank")] for kind in ("SPLINE", "TEXT", "HATCH", "DIMENSION", "3DFACE")]
    unequal = insert("rod", "b", 0, 0, ("41", 1), ("42", 2))
    read = imported(*crank(), *odd, [("0", "TEXT"), ("8", "crank")], line("crank", 0, 0, 60, 0), unequal,
                    circle("crank", 9, 0, 1, ("210", 1), ("230", 0)), blocks=[("b", (0, 0), crank("0"))])  # fmt: skip
    words = " | ".join(read.left_out)
    for word in (
        "SPLINE on layer crank",
        "2 TEXT on layer crank",
        "HATCH",
        "DIMENSION",
        "3DFACE",
        "INSERT of b",
        "LINE on layer crank",
        "CIRCLE across",
    ):
        assert word in words
    assert list(read.document["bodies"]) == ["crank"]


GOOD = dxf(crank())


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "DXF"),
        ("hello\nworld\n", "line 1|not a DXF"),
        ("AutoCAD Binary DXF\r\n\x1a\0\0", "binary"),
        (GOOD[: len(GOOD) // 2], "line|whole"),
        (GOOD.replace("0\nEOF\n", ""), "EOF"),
        (GOOD.replace("0\nENDSEC\n0\nEOF", "0\nEOF"), "does not end"),
        (dxf([circle("a", 0, 0, "nan")]), "line .*nan|expected a number"),
        (dxf([circle("a", 0, 0, "1e999")]), "expected a number"),
        (dxf([circle("a", 0, 1e13, 1)]), "origin"),
        (dxf([[("0", "CIRCLE"), ("8", "a"), ("10", 1), ("20", 1)]]), "CIRCLE.*40"),
        (dxf([line("0", 0, 0, 1, 1)]), "no layer is a body"),
        (dxf(crank("ground")), "no layer is a body"),
        (dxf([]), "ENTITIES"),
        (dxf([insert("a", "none", 0, 0)]), "'none'"),
        (dxf([insert("a", "b", 0, 0)], blocks=[("b", (0, 0), [insert("a", "B", 1, 0)])]), "is in itself"),
        (dxf([outline("a", [(0, 0), (10, 10), (10, 0), (0, 7)])]), "layer a.*meets"),
        (dxf([box("a", 0, 0, 10, 10), box("a", 5, 5, 15, 15)]), "layer a.*crosses"),
    ],
)  # fmt: skip
def test_what_is_no_drawing_of_a_mechanism_is_refused_with_its_place(text, words):
    with pytest.raises(rt.InputError, match=f"(?s){words}"):
        read_dxf(text, "sketch.dxf", Assumptions())
