"""Outlines of lines and arcs: area, mass centre and inertia, what closes, the band around circles."""

import math

import numpy as np
import pytest

from rattle.description.polygon import figure_of
from rattle.exchange.outlines.bands import band
from rattle.exchange.outlines.chains import chained
from rattle.exchange.outlines.edges import Circle, Corner, arc_bulge, around, as_circle, edge_points, flattened, moments
from rattle.exchange.outlines.plan import Stroke

pytestmark = pytest.mark.nojit


def fine(outline, chords=4000):
    """Points of an outline by rotating the start of each edge about the centre of its arc."""
    path = []
    for a, b in around(outline):
        if not a.bulge:
            path.append((a.x, a.y))
            continue
        start, end = complex(a.x, a.y), complex(b.x, b.y)
        sweep = 4 * math.atan(a.bulge)
        turn = np.exp(1j * sweep)
        centre = (end - turn * start) / (1 - turn)
        path += [(p.real, p.imag) for p in centre + (start - centre) * np.exp(1j * sweep * np.arange(chords) / chords)]
    return path


def closed_forms():
    r, h = 3.0, 1.2
    yield "disc", Circle(5.0, -2.0, r).outline, math.pi * r**2, (5.0, -2.0), math.pi / 2 * r**4
    half = (Corner(-r, 0.0), Corner(r, 0.0, 1.0))
    y = 4 * r / (3 * math.pi)
    yield "half disc", half, math.pi * r**2 / 2, (0.0, y), math.pi / 4 * r**4 - math.pi * r**2 / 2 * y**2
    a = 2 * math.acos(h / r)  # a segment at the distance h from the centre
    end = math.sqrt(r * r - h * h)
    area, first = r * r / 2 * (a - math.sin(a)), 2 * end**3 / 3
    ixx, iyy = (
        r**4 / 8 * (a - math.sin(a) * math.cos(a)),
        r**4 / 8 * (a - math.sin(a) - 2 / 3 * math.sin(a) * math.sin(a / 2) ** 2),
    )
    yield (
        "segment",
        (Corner(-end, h), Corner(end, h, arc_bulge(a))),
        area,
        (0.0, first / area),
        ixx + iyy - first**2 / area,
    )
    l, s = 7.0, 0.8  # a bar with round ends
    slot = (Corner(-l / 2, -s), Corner(l / 2, -s, 1.0), Corner(l / 2, s), Corner(-l / 2, s, 1.0))
    about = (
        2 * s * l * (l**2 + 4 * s * s) / 12
        + math.pi / 2 * s**4
        + math.pi * s * s * l * l / 4
        + 2 * l / 2 * 4 * s**3 / 3
    )
    yield "bar with round ends", slot, 2 * s * l + math.pi * s * s, (0.0, 0.0), about
    yield "square", tuple(Corner(x, y) for x, y in ((1, 1), (3, 1), (3, 3), (1, 3))), 4.0, (2.0, 2.0), 16.0 / 6


@pytest.mark.parametrize(
    ("outline", "area", "centre", "second"), [pytest.param(*case, id=name) for name, *case in closed_forms()]
)
@pytest.mark.parametrize("far", [0.0, 1e4])
def test_areas_and_moments_are_those_of_closed_forms(outline, area, centre, second, far):
    """A far origin costs its own digits only: 1e4 sizes away eps*1e4 of the size in the corners."""
    moved = tuple(corner._replace(x=corner.x + far) for corner in outline)
    figure = moments(moved)
    tol = 1e-14 + 4e-16 * far
    assert figure.area == pytest.approx(area, rel=10 * tol)
    assert figure.centre == pytest.approx((centre[0] + far, centre[1]), abs=10 * tol)
    assert figure.second == pytest.approx(second, rel=30 * tol)
    turned = moments(tuple(Corner(b.x, b.y, -a.bulge) for a, b in reversed(around(moved))))
    assert turned.area == pytest.approx(figure.area, rel=1e-14)


def test_arcs_of_all_sizes_are_integrated_to_rounding():
    """Against polygons of 4000 chords an arc, whose own error falls as the square of their number."""
    rng = np.random.default_rng(3)
    for _ in range(40):
        n = int(rng.integers(2, 7))
        turns = np.sort(rng.uniform(0, 2 * math.pi, n))
        bulges = rng.choice([0.0, 0.02, 0.3, 0.9, -0.1, 2.5, -0.4], n)
        bulges[0] = bulges[0] or 0.5
        outline = tuple(Corner(math.cos(t), math.sin(t), b) for t, b in zip(turns, bulges, strict=True))
        signed = [np.array(integrals(fine(outline, chords))) for chords in (2000, 4000)]
        want = (4 * signed[1] - signed[0]) / 3
        figure = moments(outline)
        area, x, y, second = want
        if abs(area) < 0.05:  # parts that cancel
            continue
        assert figure.area == pytest.approx(abs(area), rel=1e-9)
        assert figure.centre == pytest.approx((x / area, y / area), abs=1e-8)
        assert figure.second == pytest.approx(abs(second - (x * x + y * y) / area), rel=1e-7)


def test_an_arc_that_is_all_but_straight_has_its_area():
    """A circular segment of the height b L/2 has the area 2/3 of its box, to the order b^2."""
    for bulge in (1e-4, 1e-7, 1e-12):
        cap = moments((Corner(0, 0, bulge), Corner(2, 0)))
        assert cap.area == pytest.approx(2 / 3 * 2 * bulge, rel=1e-7 + 1e-16 / bulge)


def integrals(path):
    """Area, first moments and polar second moment about the origin of a polygon, with their sign, crossing or not."""
    x, y = np.array(path).T
    u, v = np.roll(x, -1), np.roll(y, -1)
    a = x * v - u * y
    return (
        a.sum() / 2,
        (a * (x + u)).sum() / 6,
        (a * (y + v)).sum() / 6,
        (a * (x * x + x * u + u * u + y * y + y * v + v * v)).sum() / 12,
    )


def test_points_of_an_edge_are_on_its_arc():
    for bulge in (1e-9, 0.1, -0.7, 1.0, 3.0):
        start, end = Corner(1.0, 2.0, bulge), Corner(4.0, 1.0)
        path = edge_points(start, end, 1e-4)
        want = fine((start, end._replace(bulge=0.0)), 720)
        line = np.array(want)
        for point in path:
            assert np.hypot(*(line - point).T).min() < 0.5 * math.dist(line[0], line[1]) + 1e-9
        middles = 0.5 * (np.array(path[1:]) + np.array(path[:-1]))
        assert max(np.hypot(*(line - middle).T).min() for middle in middles) < 1e-4 + 0.5 * math.dist(line[0], line[1])


def test_lines_and_arcs_close_in_any_order_and_direction():
    """A bar with round ends and a hexagon, shuffled; a line that hangs on, and one drawn twice, change nothing."""
    rng = np.random.default_rng(5)
    slot = (Corner(-3, -1), Corner(3, -1, 1.0), Corner(3, 1), Corner(-3, 1, 1.0))
    hexagon = tuple(Corner(10 + math.cos(k * math.pi / 3), math.sin(k * math.pi / 3)) for k in range(6))
    for _ in range(200):
        strokes = []
        for outline in (slot, hexagon):
            for a, b in around(outline):
                shift = rng.uniform(-4e-7, 4e-7, 4)
                a, b = Corner(a.x + shift[0], a.y + shift[1], a.bulge), Corner(b.x + shift[2], b.y + shift[3])
                strokes.append(
                    Stroke(a, b, "LINE")
                    if rng.random() < 0.5
                    else Stroke(Corner(b.x, b.y, -a.bulge), a._replace(bulge=0.0), "LINE")
                )
        strokes += [Stroke(Corner(3, 1), Corner(4, 4), "LINE"), Stroke(Corner(4, 4), Corner(5, 4), "LINE"), strokes[0]]
        chains = chained([strokes[k] for k in rng.permutation(len(strokes))], 1.2e-6)
        areas = sorted(moments(outline).area for outline in chains.outlines)
        assert areas == pytest.approx([1.5 * math.sqrt(3), 12 + math.pi], rel=1e-5)
        assert len(chains.loose) == 2
        assert not chains.branches


def test_lines_that_branch_are_no_outline():
    square = [Corner(0, 0), Corner(1, 0), Corner(1, 1), Corner(0, 1)]
    strokes = [Stroke(a, b, "LINE") for a, b in around(square)] + [Stroke(Corner(0, 0), Corner(1, 1), "LINE")]
    chains = chained(strokes, 1e-6)
    assert not chains.outlines
    assert chains.branches == [(0, 0)]


def test_circles_of_arcs_are_circles():
    for n in (2, 3, 5):
        outline = tuple(
            Corner(2 + math.cos(2 * math.pi * k / n), 1 - math.sin(2 * math.pi * k / n), -arc_bulge(2 * math.pi / n))
            for k in range(n)
        )
        assert as_circle(outline, 1e-9) == pytest.approx((2, 1, 1), abs=1e-12)
    assert as_circle((Corner(0, 0, 1.0), Corner(2, 0, 0.9)), 1e-9) is None
    assert as_circle((Corner(0, 0, 1.0), Corner(2, 0, -1.0)), 1e-9) is None


def hull(points):
    """Corners of the convex hull, by Andrew's chain."""
    points = sorted(map(tuple, points))

    def chain(path):
        kept = []
        for p in path:
            while len(kept) > 1 and (kept[-1][0] - kept[-2][0]) * (p[1] - kept[-2][1]) <= (
                kept[-1][1] - kept[-2][1]
            ) * (p[0] - kept[-2][0]):
                kept.pop()
            kept.append(p)
        return kept[:-1]

    return chain(points) + chain(points[::-1])


def test_a_band_is_the_convex_hull_of_its_circles():
    rng = np.random.default_rng(7)
    turns = np.linspace(0, 2 * math.pi, 2000, endpoint=False)
    for trial in range(60):
        n = int(rng.integers(1, 7))
        radii = rng.uniform(0.1, 0.6, n) if trial % 3 else np.full(n, 0.2)
        places = rng.integers(-2, 3, (n, 2)) if trial % 2 else rng.uniform(-2, 2, (n, 2))
        circles = [Circle(float(x), float(y), float(r)) for (x, y), r in zip(places, radii, strict=True)]
        points = np.vstack(
            [np.column_stack([c.x + c.radius * np.cos(turns), c.y + c.radius * np.sin(turns)]) for c in circles]
        )
        want, figure = figure_of(hull(points)), moments(band(circles))
        assert figure.area == pytest.approx(want.area, rel=2e-5)  # chords of 2000 points: 1.6e-6 of a disc
        assert figure.centre == pytest.approx(want.centre, abs=1e-5)
        ring = np.array(flattened(band(circles), 1e-4))
        assert ((np.roll(ring, -1, axis=0) - ring) ** 2).sum(axis=1).min() > 0
