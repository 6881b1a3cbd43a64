"""Outlines from SVG: plates with mass and inertia, drawings whose layers are bodies, nothing from elsewhere."""

import json
import math

import numpy as np
import pytest

import rattle as rt
from bounded import bounded
from rattle.errors import ModelError
from rattle.exchange.imported import Assumptions
from rattle.exchange.svg.lengths import Matrix, transform_of
from rattle.exchange.svg.paths import PathReader
from rattle.exchange.svg.read import read_svg

pytestmark = pytest.mark.nojit
SHEET = 0.01 * 7850.0
SPACES = 'xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
MM = 'width="200mm" height="100mm" viewBox="0 0 200 100"'


def svg(inside, size=MM):
    return f'<?xml version="1.0"?>\n<svg {SPACES} {size}>{inside}</svg>'


def imported(inside, size=MM, **stated):
    return read_svg(svg(inside, size), "folder/part.svg", Assumptions(**stated))


def plate(inside, size=MM):
    document = imported(inside, size).document
    rt.loads(json.dumps(document))  # a model that is sound
    (body,) = document["bodies"].values()
    return body


def area(inside, size=MM):
    return plate(inside, size)["mass"] / SHEET * 1e6


# ---------------------------------------------------------------- shapes
def test_a_plate_has_the_mass_and_inertia_of_its_path():
    body = plate('<path d="M 10 20 h 100 v 30 H 10 Z"/><circle cx="30" cy="35" r="5"/>')
    hole, whole = math.pi * 25e-6, 3000e-6
    mass = (whole - hole) * SHEET
    x = (whole * 0.06 - hole * 0.03) / (whole - hole)
    inertia = whole * (0.1**2 + 0.03**2) / 12 + whole * (x - 0.06) ** 2 - hole * (0.005**2 / 2 + (x - 0.03) ** 2)
    assert body["mass"] == pytest.approx(mass, rel=1e-13)
    assert body["center"] == pytest.approx([x, -0.035], rel=1e-12)  # y is upwards in a mechanism
    assert body["inertia"] == pytest.approx(inertia * SHEET, rel=1e-12)
    assert body["points"] == {"H1": [0.03, -0.035]}


@pytest.mark.parametrize(
    ("inside", "wanted", "tolerance"),
    [
        ('<rect x="1" y="2" width="30" height="20"/>', 600, 1e-13),
        ('<rect width="30" height="20" rx="4"/>', 600 - (4 - math.pi) * 16, 1e-13),
        ('<rect width="30" height="20" rx="40" ry="4"/>', 600 - (4 - math.pi) * 15 * 4, 2e-5),
        ('<circle cx="5" cy="5" r="7"/>', math.pi * 49, 1e-13),
        ('<ellipse cx="5" cy="5" rx="7" ry="3"/>', math.pi * 21, 2e-5),
        ('<polygon points="0,0 10,0 10,5"/>', 25, 1e-13),
        ('<polyline points="0 0 10 0 10 5 0 0"/>', 25, 1e-13),
        ('<line x1="0" y1="0" x2="9" y2="0"/><path d="M9 0 0 4"/><line x1="0" y1="4" x2="0" y2="0"/>', 18, 1e-13),
        ('<path d="M0,0 A5,5 0 0 1 10,0 A5 5 0 01 0 0z"/>', math.pi * 25, 1e-13),
        ('<path d="M0 0a1 1 0 0010 0z"/>', math.pi * 12.5, 1e-13),
        ('<path d="M-6,0 A10 10 0 1 1 6 0 z"/>', 100 * (math.pi - math.asin(0.6)) + 48, 1e-13),
        ('<path d="M0 0 C 0 8 12 8 12 0 z"/>', 72 * 0.8, 1e-5),
        ('<path d="M0 0 Q 6 12 12 0 z"/>', 2 / 3 * 12 * 6, 1e-4),
        ('<path d="M0 0 q3 6 6 0 t6 0 6 0 v-20 h-18z"/>', 360 + 12, 1e-4),
        ('<path d="M0 0 c 0 4 6 4 6 0 s 6 -4 6 0 v-20 H0z"/>', 240, 1e-4),
        ('<path d="M0 0h9v9h-9zm2 2h3v3h-3z"/>', 72, 1e-13),
        ('<path d="M.5.5-1.5.5 -1.5-1.5e0.5-1.5Z"/>', 4, 1e-13),
        ('<g transform="scale(2)translate(3)"><rect width="3" height="2" transform="skewX(20)"/></g>', 24, 1e-13),
        ('<g transform="matrix(3 0 0 -2 5 5)"><circle r="2"/></g>', math.pi * 24, 2e-5),
        ('<g transform="rotate(33, 2 4) scale(-3 3)"><circle r="2"/></g>', math.pi * 36, 1e-12),
    ],
)  # fmt: skip
def test_shapes_have_their_area(inside, wanted, tolerance):
    assert area(inside) == pytest.approx(wanted, rel=tolerance)


@pytest.mark.parametrize("radii", ["0 10", "1e-308 10", "1e-200 1e-200", "10 1e-15"])
def test_an_arc_with_a_radius_of_nothing_is_a_line(radii):
    read = imported(f'<path d="M0 0h20v100a{radii} 0 0 1-20 0z"/>')
    assert read.document["bodies"]["part"]["mass"] == pytest.approx(2000e-6 * SHEET, rel=1e-9)


def test_arcs_go_where_their_flags_say():
    """All four arcs between two points, on an ellipse that is turned; their points fulfil its equation."""
    turn, rx, ry = 0.5, 5.0, 3.0
    seen = set()
    for large in (0, 1):
        for positive in (0, 1):
            reader = PathReader(Matrix(), 1e-6)
            (line,) = reader.read(f"M1,2 A{rx} {ry} {math.degrees(turn)} {large} {positive} 4,4")
            points = np.array([corner[:2] for corner in line.corners])
            c, s = math.cos(turn), math.sin(turn)
            u = (points @ np.array([[c, -s], [s, c]])) / (rx, ry)
            middle = 0.5 * (u[0] + u[-1])
            half = 0.5 * (u[-1] - u[0])
            rise = math.sqrt(1 - half @ half) / math.hypot(*half)
            centres = [middle + k * rise * np.array([-half[1], half[0]]) for k in (1, -1)]
            fits = [np.abs(np.hypot(*(u - centre).T) - 1).max() for centre in centres]
            assert min(fits) < 1e-9
            own = u - centres[int(np.argmin(fits))]
            steps = np.unwrap(np.arctan2(own[:, 1], own[:, 0]))
            assert (abs(steps[-1] - steps[0]) > math.pi) == bool(large)
            assert (steps[-1] > steps[0]) == bool(positive)
            seen.add((round(float(points[len(points) // 2][0]), 6), round(float(points[len(points) // 2][1]), 6)))
    assert len(seen) == 4


def test_chords_are_as_near_to_a_curve_as_is_said():
    tolerance = 1e-2
    p = np.array([(0, 0), (40, 90), (-30, 60), (70, 5)], float)
    reader = PathReader(Matrix(), tolerance)
    (line,) = reader.read("M0 0C40 90-30 60 70 5")
    u = np.linspace(0, 1, 20001)[:, None]
    curve = (1 - u) ** 3 * p[0] + 3 * u * (1 - u) ** 2 * p[1] + 3 * u * u * (1 - u) * p[2] + u**3 * p[3]
    corners = np.array([corner[:2] for corner in line.corners])
    a, chord = corners[:-1], np.diff(corners, axis=0)
    to = curve[::37, None] - a[None]
    along = np.clip((to * chord).sum(axis=2) / (chord**2).sum(axis=1), 0, 1)
    far = np.hypot(*np.moveaxis(to - along[..., None] * chord, 2, 0)).min(axis=1).max()
    assert 0.05 * tolerance < far < tolerance


def test_transforms_act_in_their_order():
    whole = transform_of("translate(3,4) rotate(90) scale(2, 3) skewY(45)")
    assert whole is not None
    assert whole.of(1, 2) == pytest.approx((3 - 3 * (2 + 1), 4 + 2 * 1))
    about = transform_of("rotate(90 10 20)")
    assert about is not None
    assert about.of(11, 20) == pytest.approx((10, 21))
    assert transform_of("turn(3)") is None
    assert transform_of("scale(a)") is None


# ---------------------------------------------------------------- sizes and bodies
@pytest.mark.parametrize(
    ("size", "metres", "told"),
    [
        ('width="20cm" height="10cm" viewBox="0 0 400 200"', 5e-4, False),
        ('width="4in" viewBox="10 20 4 2"', 0.0254, False),
        ('width="200" height="100" viewBox="0 0 100 50"', 2 * 0.0254 / 96, True),
        ('viewBox="0 0 100 50"', 0.0254 / 96, True),
        ("", 0.0254 / 96, True),
        ('width="100%" height="100%"', 0.0254 / 96, True),
        ('width="200mm" height="50mm" viewBox="0 0 100 100"', 5e-4, False),
        ('width="200mm" height="50mm" viewBox="0 0 100 100" preserveAspectRatio="xMinYMin slice"', 2e-3, False),
        ('width="200mm" height="200mm" viewBox="0 0 100 100" preserveAspectRatio="none"', 2e-3, False),
    ],
)
def test_lengths_have_the_scale_of_the_page(size, metres, told):
    read = imported('<rect width="10" height="10"/>', size)
    assert read.document["bodies"]["part"]["mass"] == pytest.approx(100 * metres**2 * SHEET, rel=1e-12)
    assert any("96" in word for word in read.assumed) == told
    stated = imported('<rect width="10" height="10"/>', size, scale=0.5)
    assert stated.document["bodies"]["part"]["mass"] == pytest.approx(25 * SHEET, rel=1e-12)


def test_a_drawing_that_is_stretched_unequally_is_refused():
    size = 'width="200mm" height="100mm" viewBox="0 0 200 200" preserveAspectRatio="none"'
    with pytest.raises(ModelError, match="stretch the drawing unequally"):
        imported('<rect width="10" height="10"/>', size)


def test_layers_of_inkscape_or_outermost_groups_are_bodies():
    layer = 'inkscape:groupmode="layer"'
    pin = '<circle cx="10" cy="10" r="{}"/>'
    text = (
        f'<g {layer} inkscape:label="Ground">{pin.format(4.2)}</g>'
        f'<g {layer} id="layer7" inkscape:label="the arm">'
        f'<g id="g1"><rect width="50" height="20"/></g>{pin.format(4)}</g>'
        '<g id="plain"><g id="inner"><rect x="100" width="9" height="9"/></g></g>'
        '<g display="none"><rect width="5" height="5"/></g>'
    )
    document = imported(text).document
    assert set(document["bodies"]) == {"the_arm", "plain"}
    (joint,) = document["joints"].values()
    assert joint["connect"] == ["ground.A", "the_arm.A"]
    assert joint["clearance"] == pytest.approx(2e-4, rel=1e-12)


def test_what_is_not_taken_is_named():
    odd = '<text>words</text><use href="#a"/><image href="http://x/y"/><defs><path d="junk"/></defs>'
    read = imported(f'<rect width="5" height="5"/>{odd}')
    assert {word.split(" on ")[0] for word in read.left_out} == {"element text", "element use", "element image"}


# ---------------------------------------------------------------- refused
BOMB = '<!DOCTYPE svg [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]><svg xmlns="http://www.w3.org/2000/svg">&b;</svg>'


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (BOMB, "DOCTYPE"),
        ('<!DOCTYPE svg SYSTEM "http://127.0.0.1:1/x.dtd"><svg/>', "DOCTYPE"),
        ('<!DOCTYPE html><svg xmlns="http://www.w3.org/2000/svg"/>', "DOCTYPE"),
        (svg('<rect width="5" height="5"/>')[:-9], "not a whole SVG"),
        (svg('<path d="M0 0 L"/>'), "part.svg:2: .*path: L needs 2 numbers, got 0"),
        (svg('<path d="M0 0 L1 nan z"/>'), "path: L needs 2 numbers, got 1"),
        (svg('<path d="L1 1"/>'), "begins with M"),
        (svg('<path d="M0 0 5"/>'), "needs 2"),
        (svg('<path d="M1e999 0 5 5z"/>'), "out of range"),
        (svg('<rect width="1e99" height="5"/>'), "no length"),
        (svg('<rect width="5" height="5" transform="spin(3)"/>'), "transform"),
        (svg('<polygon points="1 2 3"/>'), "pairs"),
        (svg(""), "no layer is a body"),
        ("<html/>", "not an SVG"),
        ("", "not a whole SVG"),
        ("<svg " * 1000, "not a whole SVG"),
        (svg("<g>" * 300 + "</g>" * 300), "200"),
        (svg(f'<path d="M0 0{"t1 1" * 200_000}"/>'), "more than"),
        (svg(f'<path d="M0 0{" 1 1" * 200_000}z"/>'), "more than"),
        (svg('<circle r="1"/>' * 5000), "circles"),
    ],
)  # fmt: skip
def test_what_is_no_plain_drawing_is_refused_with_its_place(text, words):
    with bounded(), pytest.raises(rt.InputError, match=f"(?s){words}"):
        read_svg(text, "part.svg", Assumptions())


def test_the_plain_doctype_of_old_programs_is_let_pass_and_never_looked_up():
    doctype = '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://127.0.0.1:1/svg11.dtd">'
    text = svg('<rect width="10" height="10"/>').replace("<svg", f"{doctype}<svg", 1)
    assert read_svg(text, "part.svg", Assumptions()).document["bodies"]["part"]["mass"] == pytest.approx(1e-4 * SHEET)


def test_rt_read_knows_an_svg_by_its_content(tmp_path):
    path = tmp_path / "drawing.txt"
    path.write_text(svg('<rect width="10" height="10"/>'))
    assert rt.read(path, thickness="2 mm").model.bodies["drawing"].mass == pytest.approx(1e-4 * SHEET / 5)
    packed = tmp_path / "x.svgz"
    packed.write_bytes(b"\x1f\x8b\x08\0\0")
    with pytest.raises(rt.InputError, match="gzip"):
        rt.read(packed)
