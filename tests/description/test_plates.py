"""Plates from polygons: mass, mass centre and inertia are those of the figure, in every way of giving it."""
# ruff: noqa: E501  a case is a line

import functools
import itertools
import json
import math
import tomllib

import numpy as np
import pytest

import rattle as rt
from rattle.description.polygon import figure_of
from rattle.description.reader import read
from rattle.trace.graph import Graph, both
from rattle.trace.recording import Recorder

pytestmark = pytest.mark.nojit

TEXT = """\
format = 1
gravity = [0, -9.81]

[parameters]
w = "300 mm"    # of the plate
rho = "7.85 g/cm^3"

[ground.points]
O = [0, 0]

[bodies.plate]  # a bell crank with two holes
polygon = [[0, 0], ["w", 0], ["w", "80 mm"], ["80 mm", "80 mm"], ["80 mm", "w"], [0, "w"]]
holes = [
    [["20 mm", "20 mm"], ["60 mm", "20 mm"], ["60 mm", "60 mm"], ["20 mm", "60 mm"]],
    [["200 mm", "30 mm"], ["230 mm", "30 mm"], ["215 mm", "60 mm"]],
]
thickness = "10 mm"
density = "rho"
points = { O = ["40 mm", "w - 20 mm"] }

[joints.O]
type = "revolute"
connect = ["ground.O", "plate.O"]

[initial]
plate = { angle = 0.3 }
"""
SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]
HOLE = [[0.2, 0.2], [0.4, 0.2], [0.4, 0.4]]


def plate(polygon, **more):
    return rt.Mechanism().ground(O=[0, 0]).plate("p", polygon, **more).model.bodies["p"]


def turned(corners, angle, shift):
    cos, sin = math.cos(angle), math.sin(angle)
    return [(cos * x - sin * y + shift[0], sin * x + cos * y + shift[1]) for x, y in corners]


def regular(n, radius):
    angle = 2 * math.pi * np.arange(n) / n
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


# ---------------------------------------------------------------- closed forms
@pytest.mark.parametrize("shift", [(0, 0), (0.3, -2), (1e5, -1e5)])
@pytest.mark.parametrize("sense", [1, -1])
def test_rectangle_and_triangle_have_the_inertia_of_the_tables(shift, sense):
    a, b, m = 0.3, 0.2, 2.0
    exact = {"rel": 1e-14 * (1e3 + abs(shift[0]) / a) ** 1}  # corners far away have lost digits before they are read
    rectangle = [(0, 0), (a, 0), (a, b), (0, b)]
    found = figure_of(turned(rectangle, 0.4, shift)[::sense])
    assert found.area == pytest.approx(a * b, **exact)
    assert m / found.area * found.second == pytest.approx(m * (a**2 + b**2) / 12, **exact)
    (centre,) = turned([(a / 2, b / 2)], 0.4, shift)
    assert found.centre == pytest.approx(centre, rel=1e-12)
    triangle = figure_of(turned([(0, 0), (a, 0), (0, b)], -1.2, shift)[::sense])
    assert triangle.area == pytest.approx(a * b / 2, **exact)
    assert m / triangle.area * triangle.second == pytest.approx(m * (a**2 + b**2) / 18, **exact)
    (centre,) = turned([(a / 3, b / 3)], -1.2, shift)
    assert triangle.centre == pytest.approx(centre, rel=1e-12)


def test_ring_of_many_corners_tends_to_the_round_one_as_its_chords_do():
    out, inner = 0.2, 0.12
    for n in (6, 48, 480):
        p = plate(regular(n, out), holes=[regular(n, inner)], thickness=0.01, density=7850)
        area = {r: n / 2 * r**2 * math.sin(2 * math.pi / n) for r in (out, inner)}
        mass = {r: 78.5 * one for r, one in area.items()}
        j = {r: one * r**2 / 6 * (2 + math.cos(2 * math.pi / n)) for r, one in mass.items()}  # regular n-gon
        assert p.mass == pytest.approx(mass[out] - mass[inner], rel=1e-13)
        assert p.inertia == pytest.approx(j[out] - j[inner], rel=1e-13)
    assert p.mass == pytest.approx(78.5 * math.pi * (out**2 - inner**2), rel=2 * math.pi**2 / (3 * n**2) * 1.01)
    assert p.inertia == pytest.approx(78.5 * math.pi / 2 * (out**4 - inner**4), rel=4 * math.pi**2 / (3 * n**2) * 1.01)


def test_a_hole_off_the_centre_moves_the_centre_away_from_it():
    square, hole, m = [(0, 0), (1, 0), (1, 1), (0, 1)], [(0.5, 0.5), (0.75, 0.5), (0.75, 0.75), (0.5, 0.75)], 1 / 16
    p = plate(square, holes=[hole], thickness=1, density=1, points={"O": [0, 0]})
    x = (0.5 - m * 0.625) / (1 - m)
    assert p.mass == pytest.approx(1 - m, rel=1e-15)
    assert p.points["O"] == pytest.approx((-x, -x), rel=1e-14)
    about = 1 / 6 + 2 * (0.5 - x) ** 2 - m * (2 * 0.25**2 / 12 + 2 * (0.625 - x) ** 2)
    assert p.inertia == pytest.approx(about, rel=1e-14)


# ---------------------------------------------------------------- against strips
def by_strips(rings):
    """Integrals of 1, x, y, x^2 + y^2 over a figure: strips between heights of corners, each exactly by Gauss."""
    edges = [(a, b) for ring in rings for a, b in zip(ring, [*ring[1:], ring[0]], strict=True)]
    heights = sorted({y for ring in rings for _, y in ring})
    nodes, weights = np.polynomial.legendre.leggauss(3)
    total = np.zeros(4)
    for low, high in itertools.pairwise(heights):
        for node, weight in zip(nodes, weights, strict=True):
            y = (low + high + node * (high - low)) / 2
            cuts = sorted(
                a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) for a, b in edges if (a[1] > y) != (b[1] > y)
            )
            for left, right in zip(cuts[::2], cuts[1::2], strict=True):
                wide, square = right - left, (right**2 - left**2) / 2
                cube = (right**3 - left**3) / 3
                total += weight * (high - low) / 2 * np.array([wide, square, wide * y, cube + wide * y**2])
    return total


@pytest.mark.parametrize("seed", range(20))
def test_figures_of_any_shape_are_what_strips_give(seed):
    random = np.random.default_rng(seed)
    n = int(random.integers(3, 14))
    angle = np.sort(random.uniform(0, 2 * np.pi, n)) + np.linspace(0, 1e-3, n)
    radius = random.uniform(0.5, 2, n) if np.diff([*angle, angle[0] + 2 * np.pi]).max() < 3 else np.ones(n)
    outline = [(3 + r * math.cos(a), -1 + r * math.sin(a)) for r, a in zip(radius, angle, strict=True)]
    rings = [outline]
    if n > 8 and figure_of(outline).area > 2:
        rings += [turned(regular(4, 0.1), 0.3, (3.0, -1.0))[::-1]]
    area, x, y, about_origin = by_strips(rings)
    found = figure_of(rings[0], rings[1:])
    assert found.area == pytest.approx(area, rel=1e-12)
    assert found.centre == pytest.approx((x / area, y / area), rel=1e-12)
    expected = about_origin - (x**2 + y**2) / area
    assert found.second == pytest.approx(expected, rel=1e-10, abs=1e-12 * about_origin)


# ---------------------------------------------------------------- every way of giving it
def in_code():
    m = rt.Mechanism(gravity=[0, -9.81]).parameter("w", "300 mm").parameter("rho", "7.85 g/cm^3").ground(O=[0, 0])
    given = tomllib.loads(TEXT)["bodies"]["plate"]
    more = {key: given[key] for key in ("thickness", "density", "points", "holes")}
    return m.plate("plate", given["polygon"], **more).revolute("O", "ground.O", "plate.O").initial("plate", angle=0.3)


def test_file_code_json_and_saved_copy_are_one_body(tmp_path):
    m = rt.loads(TEXT)
    body = m.model.bodies["plate"]
    assert body.mass == pytest.approx(78.5 * (0.3 * 0.08 + 0.08 * 0.22 - 0.04**2 - 0.03 * 0.03 / 2), rel=1e-13)
    m.save(tmp_path / "plate.json")
    for other in (in_code(), rt.loads(in_code().to_toml()), rt.load(tmp_path / "plate.json"), rt.loads(m.to_toml())):
        assert other.model.bodies["plate"] == body
    assert m.to_toml() == TEXT


def test_a_parameter_moves_corners_mass_and_points():
    wide = rt.loads(TEXT).set(w="350 mm")
    assert "# of the plate" in wide.to_toml()
    body = wide.model.bodies["plate"]
    rings = [np.array(ring) for ring in body.outline]
    assert rings[0].max(axis=0) - rings[0].min(axis=0) == pytest.approx((0.35, 0.35), rel=1e-14)
    area, x, y, about = by_strips([[tuple(map(float, p)) for p in ring] for ring in rings])
    assert body.mass == pytest.approx(78.5 * area, rel=1e-13)
    assert (x, y) == pytest.approx((0, 0), abs=1e-16)  # the outline counts from the mass centre
    assert body.inertia == pytest.approx(78.5 * about, rel=1e-12)
    corner = wide.set({"bodies.plate.polygon.1.0": "0.4 m", "bodies.plate.polygon.2.0": "0.4 m"}).model.bodies["plate"]
    assert corner.mass == pytest.approx(body.mass + 78.5 * 0.05 * 0.08, rel=1e-13)


def test_mass_instead_of_density_gives_the_same_shape_of_inertia():
    light = plate(SQUARE, mass="3 kg")
    assert (light.mass, light.inertia) == pytest.approx((3, 3 / 6), rel=1e-15)


def test_a_plate_swings_as_a_body_with_its_numbers():
    m = rt.loads(TEXT)
    body = m.model.bodies["plate"]
    twin = rt.Mechanism(gravity=[0, -9.81]).ground(O=[0, 0]).revolute("O", "ground.O", "plate.O")
    twin.body("plate", mass=body.mass, inertia=body.inertia, points=body.points).initial("plate", angle=0.3)
    (x, y), j, g = body.points["O"], body.inertia, 9.81
    arm = math.hypot(x, y)
    hanging = math.pi / 2 - math.atan2(y, x)  # the pin above the mass centre
    stiff = m.set({"initial.plate.angle": hanging})
    omega = math.sqrt(body.mass * g * arm / (j + body.mass * arm**2))  # of small swings of a compound pendulum
    assert 2 * math.pi * stiff.modes().frequency == pytest.approx([omega], rel=1e-9)
    assert m.start.q == pytest.approx(twin.start.q, abs=1e-14)


def test_a_record_of_the_corners_gives_every_other_plate_and_knows_where_edges_cross():
    graph = Graph()
    recorder = Recorder(graph)
    w = graph.input()
    chosen = {"w": functools.partial(recorder.number, symbol=w)}
    body = read(tomllib.loads(TEXT), chosen=chosen).bodies["plate"]
    sound = both(graph, recorder.assumed.values())

    def at(value, *symbols):
        return graph.evaluate(list(symbols), np.array([[value]]))[:, 0]

    for value in (0.27, 0.3, 0.45):
        other = rt.loads(TEXT).set(w=value).model.bodies["plate"]
        numbers = [body.mass.symbol, body.inertia.symbol, *(one.symbol for one in body.points["O"])]
        assert at(value, *numbers) == pytest.approx([other.mass, other.inertia, *other.points["O"]], rel=1e-12)
        assert at(value, sound)
    assert not at(0.22, sound)  # an edge passes through a hole
    assert not at(0.05, sound)  # the outline crosses itself


def test_the_report_says_what_follows_from_the_polygon():
    m = rt.Mechanism().ground(O=[0, 0]).plate("leaf", [[1, 1], [1.4, 1], [1.4, 1.06], [1, 1.06]], mass="2 kg")
    said = str(m.revolute("O", "ground.O", "leaf.O").set({"bodies.leaf.points.O": [1, 1]}).check())
    inertia = 2 * (0.4**2 + 0.06**2) / 12
    assert f"plate: leaf 2 kg, {inertia:.4g} kg*m^2 about its mass centre, which is [200 mm, 30 mm] from its" in said


# ---------------------------------------------------------------- what can be wrong
@pytest.mark.parametrize(
    ("given", "path", "words"),
    [
        ({"polygon": SQUARE[:2], "mass": 1}, "polygon", "2 corners; a polygon has three or more"),
        ({"polygon": [], "mass": 1}, "polygon", "0 corners"),
        ({"polygon": "L", "mass": 1}, "polygon", "expected corners in order around"),
        ({"polygon": [[0, 0], [1, 0], [1, 2, 3]], "mass": 1}, "polygon[2]", "expected [x, y] in m, got [1, 2, 3]"),
        ({"polygon": [[0, 0], ["1 kg", 0], [1, 2]], "mass": 1}, "polygon[1][0]", "is a mass; expected a length in m"),
        ({"polygon": [SQUARE[k] for k in (0, 2, 1, 3)], "mass": 1}, "polygon", "from corner 1 to 2 meets the edge from corner 3 to 4"),
        ({"polygon": [[0, 0], [2, 0], [1, 0], [1, 1]], "mass": 1}, "polygon", "from corner 1 to 2 meets the edge from corner 2 to 3"),
        ({"polygon": [[0, 0], [2, 0], [2, 1], [1, 0], [0, 1]], "mass": 1}, "polygon", "expected the corners in order around, without crossing"),
        ({"polygon": [*SQUARE, SQUARE[0]], "mass": 1}, "polygon", "corner 1 is at the place of corner 5; give every corner once"),
        ({"polygon": [[0, 0], [1, 1], [3, 3], [2, 2]], "mass": 1}, "polygon", "its area is zero: all corners are on one line"),
        ({"polygon": [[k, k * k] for k in range(1001)], "mass": 1}, "polygon", "at most 1000 corners"),
        ({"polygon": SQUARE}, "", "needs thickness in m and density in kg/m^3, or a mass in kg"),
        ({"polygon": SQUARE, "thickness": 1}, "", "needs a density in kg/m^3"),
        ({"polygon": SQUARE, "density": 1}, "", "needs a thickness in m"),
        ({"polygon": SQUARE, "thickness": -1, "density": 1}, "thickness", "-1 must be positive"),
        ({"polygon": SQUARE, "thickness": 1, "density": "1 kg/m^2"}, "density", "expected a density in kg/m^3"),
        ({"polygon": SQUARE, "thickness": 1, "density": 1, "mass": 1}, "mass", "thickness and density, or a mass in kg, not both"),
        ({"polygon": SQUARE, "mass": 1, "inertia": 2}, "inertia", "the polygon says the inertia; leave this out"),
        ({"polygon": SQUARE, "mass": 1, "center": [0, 0]}, "center", "the polygon says the mass centre; leave this out"),
        ({"polygon": SQUARE, "mass": 1, "center": [0, 0], "inertia": -1}, "inertia", "-1 must not be negative"),
        ({"polygon": SQUARE, "mass": 1, "center": [0, 0], "inertia": 0}, "", "its inertia = 0 kg*m^2 is out of range"),
        ({"polygon": SQUARE, "mass": 1, "hole": []}, "hole", "unknown key; did you mean 'holes'?"),
        ({"polygon": SQUARE, "thickness": 1e-40, "density": 1e-40}, "", "its mass = 1e-80 kg is out of range"),
        ({"polygon": SQUARE, "mass": 1, "holes": [[[0.2, 0.2], [1.4, 0.2], [0.4, 0.4]]]}, "holes[0]", "is not inside of the polygon"),
        ({"polygon": SQUARE, "mass": 1, "holes": [[[2.2, 0.2], [2.4, 0.2], [2.4, 0.4]]]}, "holes[0]", "is not inside of the polygon"),
        ({"polygon": SQUARE, "mass": 1, "holes": [HOLE, [[0.1, 0.1], [0.9, 0.1], [0.9, 0.9]]]}, "holes[1]", "overlaps another hole"),
        ({"polygon": SQUARE, "mass": 1, "holes": [HOLE[:2]]}, "holes[0]", "2 corners"),
        ({"polygon": SQUARE, "mass": 1, "holes": 3}, "holes", "expected a list of holes"),
    ],
)  # fmt: skip
def test_a_plate_that_cannot_be_says_what_is_wrong(given, path, words):
    text = rt.Mechanism().ground(O=[0, 0]).bar("b", "A", "B", length=1, mass=1).to_toml()
    body = "\n".join(f"{key} = {json.dumps(value)}" for key, value in given.items())
    with pytest.raises(rt.ModelError) as caught:
        rt.loads(f"{text}\n[bodies.p]\n{body}\n")
    (problem,) = caught.value.problems
    assert problem.key == ".".join(filter(None, ("bodies.p", path)))
    assert words in problem.message
    assert problem.line
    assert problem.caret


def test_mass_centre_and_inertia_of_a_plate_may_be_its_own():
    """Its shape stays that of the polygon, about the mass centre given: a plate with something heavy on it."""
    text = rt.Mechanism().ground(O=[0, 0]).bar("b", "A", "B", length=1, mass=1).to_toml()
    body = 'polygon = [[0, 0], [2, 0], [2, 1], [0, 1]]\nmass = 3\ncenter = [0.5, "25 cm"]\ninertia = 7\npoints = { P = [1, 1] }'
    plate = rt.loads(f"{text}\n[bodies.p]\n{body}\n").model.bodies["p"]
    assert (plate.mass, plate.inertia, plate.points) == (3, 7, {"P": (0.5, 0.75)})
    assert plate.outline == (((-0.5, -0.25), (1.5, -0.25), (1.5, 0.75), (-0.5, 0.75)),)


def test_corners_on_straight_edges_and_deep_notches_are_no_fault():
    comb = [
        (0, 0),
        (5, 0),
        *[(x, y) for k in range(5, 0, -1) for x, y in ((k, 2), (k - 0.5, 2), (k - 0.5, 1), (k - 1, 1))],
    ]
    assert figure_of(comb).area == pytest.approx(5 + 5 * 0.5)
    assert plate(comb, thickness=1, density=1).mass == pytest.approx(7.5)
    assert plate([(0, 0), (0.5, 0), (1, 0), (1, 1), (0, 1)], mass=1).inertia == pytest.approx(1 / 6)


# ---------------------------------------------------------------- pictures
def test_the_picture_shows_the_outline_and_leaves_the_holes_open():
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    m = rt.loads(TEXT).set({"initial.plate.angle": 0})
    figure = m.plot()
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    seen = np.asarray(canvas.buffer_rgba())[::-1]
    inside = {(0.1, 0.01): True, (0.04, 0.04): False, (0.215, 0.04): False, (0.2, 0.2): False, (0.07, 0.29): True}
    for (px, py), yes in inside.items():  # in the frame of the polygon, whose point (0.04, 0.28) is in the origin
        column, row = figure.axes[0].transData.transform((px - 0.04, py - 0.28)).astype(int)
        assert (seen[row, column, :3].min() < 240) == yes
