"""The outline of a plate of B against a disc of A, or against the ends of a segment of A (radius 0).

The polygon, in order around with its inside to the left, is cut at its concave corners into chains; each has at most
one place that is nearest to a disc outside, and is one contact.  q: from the mass centre of B to the centre of the
disc, in B; v: corners

    nearest on an edge from v to w, m its normal outwards       g = m . (q - v) - R,    n = m,         bent = 0
    nearest at a corner v                                       g = |q - v| - R,        n = (q - v)/|q - v|,  -1/|q - v|

A chain that is seen through the plate is behind its back: there g = |distance| - R.  Where the nearest place passes
from an edge to a corner g and n are continuous, so that it is one contact.  Not so where R = 0: an end that slides
along an edge leaves it at its corner, as a corner of B does the end of a segment.  So a closed contact of an end has

    held        g = m . (q - v), also beyond the edge: it ends there, see `equations.one_way`

See `elements.disc_contact` for the rows, with the disc on A.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from rattle.elements.disc_contact import write_disc
from rattle.elements.one_sided.corner_surface import flat, reach_of
from rattle.elements.one_sided.holding import along_line, around_disc, pinned, seen_from
from rattle.interfaces.contacts import Corners, Held, OneSidedKind, Pose
from rattle.interfaces.fields import Fields
from rattle.jit import layout as at
from rattle.jit.functions import compiled, kernel
from rattle.jit.geometry import COINCIDENT, turn_x, turn_y
from rattle.language.local_function import LocalFunction
from rattle.language.recorded import cos, hypot, sin
from rattle.registry import kind

REACH_X, REACH_Y, RADIUS, REACH, CHAINS, SIDES = range(at.POINTS, at.POINTS + 6)
FIRST = at.POINTS + 6  # first corner and number of edges of every chain; then x and y of every corner [m], in B
SMALL = 1e-3  # share of a plate as near as which a corner turns the direction to an end of a segment that passes
FLUSH = 1e-10  # share of a plate as near as which an end is at a corner
FAR = 1e300


@compiled
def nearest(p, corners, count, first, edges, x, y, fx, fy, flush):
    """Of `edges` edges from corner `first` on, what is nearest to (x, y): distance, normal, bent, behind, and the edge.

    The normal points to (x, y) from a corner, outwards from an edge; behind: 1 if (x, y) is on the inner side; the edge
    is its number in the chain, -1 at a corner.  Where (x, y) is at a corner, but for the distance `flush` [m], it is on
    that of its edges which faces (fx, fy) most: rounding does not decide.
    """
    best, nx, ny, bent, behind, edge = FAR, 1.0, 0.0, 0.0, 0, -1
    for e in range(edges):
        i, j = corners + 2 * ((first + e) % count), corners + 2 * ((first + e + 1) % count)
        ex, ey = p[j] - p[i], p[j + 1] - p[i + 1]
        rx, ry = x - p[i], y - p[i + 1]
        length = math.sqrt(ex * ex + ey * ey)
        along, off = (ex * rx + ey * ry) / length, (ey * rx - ex * ry) / length
        if -flush <= along <= length + flush:
            faces = (ey * fx - ex * fy) / length > nx * fx + ny * fy
            if abs(off) < best - flush or (abs(off) <= best + flush and (faces or edge < 0)):
                best, nx, ny, bent, behind, edge = abs(off), ey / length, -ex / length, 0.0, 1 if off < 0.0 else 0, e
            continue
        if along > length:
            rx, ry = x - p[j], y - p[j + 1]
        far = math.sqrt(rx * rx + ry * ry)
        if far < best and far > COINCIDENT:
            best, nx, ny, bent, behind, edge = far, rx / far, ry / far, -1.0 / far, 0, -1
    return best, nx, ny, bent, behind, edge


@compiled
def beside_edge(p, corners, count, first, edges, edge, x, y):
    """Distance of (x, y) from the line of an edge, its normal outwards, and how far beyond that edge it is.

    At the end of a chain the next one begins, along which nothing slides off.
    """
    i, j = corners + 2 * ((first + edge) % count), corners + 2 * ((first + edge + 1) % count)
    ex, ey, rx, ry = p[j] - p[i], p[j + 1] - p[i + 1], x - p[i], y - p[i + 1]
    length = math.sqrt(ex * ex + ey * ey)
    along, whole = (ex * rx + ey * ry) / length, edges == count
    before = -along if whole or edge > 0 else -length
    after = along - length if whole or edge < edges - 1 else -length
    return (ey * rx - ex * ry) / length, ey / length, -ex / length, max(before, after)


@kernel("clearance")
def by_outline(body, a, b, p, k, corner, row, kinematics):
    """Write the row of a chain of the outline of B and a disc of A, the chains of one disc after those of the other."""
    chains, count = int(p[k + CHAINS]), int(p[k + SIDES])
    side = 1.0 if corner < chains else -1.0
    x, y = p[k] + side * p[k + REACH_X], p[k + 1] + side * p[k + REACH_Y]
    sax, say = turn_x(body, a, x, y), turn_y(body, a, x, y)
    sbx, sby = body[a, at.X] + sax - body[b, at.X], body[a, at.Y] + say - body[b, at.Y]
    cos_b, sin_b = body[b, at.COS], body[b, at.SIN]
    qx, qy = cos_b * sbx + sin_b * sby, cos_b * sby - sin_b * sbx
    place = k + FIRST + 2 * (corner % chains)
    corners = k + FIRST + 2 * chains
    first, edges, edge, beyond = int(p[place]), int(p[place + 1]), int(kinematics[row, at.EDGE]), 0.0
    flush = FLUSH * p[k + REACH] if p[k + RADIUS] == 0.0 else 0.0
    if p[k + RADIUS] == 0.0 and kinematics[row, at.PHASE] == at.HELD and edge >= 0:
        bent = 0.0
        far, nx, ny, beyond = beside_edge(p, corners, count, first, edges, edge, qx, qy)
    else:
        tx, ty = turn_x(body, a, p[k + REACH_Y], -p[k + REACH_X]), turn_y(body, a, p[k + REACH_Y], -p[k + REACH_X])
        fx, fy = cos_b * tx + sin_b * ty, cos_b * ty - sin_b * tx  # from the free side of a segment to its other side
        far, nx, ny, bent, behind, edge = nearest(p, corners, count, first, edges, qx, qy, fx, fy, flush)
        kinematics[row, at.EDGE] = edge
        if behind == 1:
            whole, _, _, _, inside, _ = nearest(p, corners, count, 0, count, qx, qy, fx, fy, flush)
            if inside == 1 and whole >= far:
                far = -far
            else:
                nx, ny = -nx, -ny
    kinematics[row, at.ABOVE], kinematics[row, at.BEYOND] = 0.0, beyond - flush
    nx, ny = turn_x(body, b, nx, ny), turn_y(body, b, nx, ny)
    gap = far - p[k + RADIUS]
    write_disc(body, a, b, False, sax, say, sbx, sby, nx, ny, gap, p[k + RADIUS], bent, row, kinematics)


def around(corners: Corners) -> Corners:
    """The corners with the inside to the left."""
    places = list(corners.values())
    after = [*places[1:], places[0]]
    area = sum(x * v - u * y for (x, y), (u, v) in zip(places, after, strict=True))
    return corners if area > 0.0 else dict(reversed(list(corners.items())))


def chains_of(corners: Corners) -> list[tuple[int, int]]:
    """First corner and number of edges of every chain between concave corners; of a convex plate all edges."""
    places = list(around(corners).values())
    count = len(places)
    concave = [n for n in range(count) if _turn(places[n - 1], places[n], places[(n + 1) % count]) < 0.0]
    if not concave:
        return [(0, count)]
    ends = [*concave[1:], concave[0] + count]
    return [(first, end - first) for first, end in zip(concave, ends, strict=True)]


def _nearest(start: tuple[float, float], end: tuple[float, float], place: tuple[float, float]) -> tuple[float, float]:
    """The point of an edge that is nearest to a place."""
    x, y = end[0] - start[0], end[1] - start[1]
    share = ((place[0] - start[0]) * x + (place[1] - start[1]) * y) / (x * x + y * y)
    share = min(max(share, 0.0), 1.0)
    return start[0] + share * x, start[1] + share * y


def _turn(before: tuple[float, float], here: tuple[float, float], after: tuple[float, float]) -> float:
    """Positive where a way turns to the left."""
    (x, y), (u, v), (s, t) = before, here, after
    return (u - x) * (t - v) - (v - y) * (s - u)


@kind("one-sided", "by-outline", by_outline)
class ByOutline(OneSidedKind):
    """Edges and corners of a plate of B on a disc of A, or on the ends of a segment of A; holes are left out.

    Source: Ericson, Real-Time Collision Detection (2005), section 5.1; Pfeiffer, Glocker, Multibody Dynamics with
    Unilateral Contacts (1996), chapter 2.
    """

    joint = "surface"
    wall = "a surface"
    walls_turn = True
    turning = at.B_BODY
    slides = True

    @classmethod
    def one_way(cls, fields: Fields) -> bool:
        """An edge on an end, not on a disc."""
        return not fields["radius"]

    @staticmethod
    def suits(fields: Fields) -> bool:
        """The outline of a plate against what does not bound a half plane."""
        disc = fields["radius"] > 0.0 and not fields["hollow"]
        return bool(fields["outline"]) and (disc or fields["length"] > 0.0)

    @classmethod
    def count(cls, fields: Fields, corners: Corners) -> int:
        """One of every chain, at each end."""
        return len(chains_of(corners)) * (1 if fields["radius"] > 0.0 else 2)

    @classmethod
    def labels(cls, fields: Fields, corners: Corners) -> tuple[str, ...]:
        """Of a disc by its chains, if there are several; of a segment by its ends too."""
        chains = range(1, len(chains_of(corners)) + 1)
        if fields["radius"] > 0.0:
            return tuple(f"edges{n}" for n in chains) if len(chains) > 1 else ()
        return tuple(f"{end}_end{n if len(chains) > 1 else ''}" for end in ("right", "left") for n in chains)

    @staticmethod
    def parameters(fields: Fields, constants: Sequence[float], corners: Corners) -> Sequence[float | LocalFunction]:
        """From the point of A to an end, radius of the disc, chains, corners."""
        half, chains, ring = 0.5 * fields["length"], chains_of(corners), around(corners)
        ends = (half * cos(fields["axis"]), half * sin(fields["axis"]))
        numbers = [float(number) for chain in chains for number in chain]
        sizes = (float(len(chains)), float(len(ring)))
        return (*ends, fields["radius"], reach_of(ring), *sizes, *numbers, *flat(ring))

    @staticmethod
    def levers(p: Sequence[float]) -> tuple[float, float]:
        """Arms [m] of the end or disc of A and of the farthest corner."""
        return hypot(p[0], p[1]) + hypot(p[REACH_X], p[REACH_Y]), p[REACH]

    @staticmethod
    def bends(fields: Fields, constants: Sequence[float]) -> tuple[float, float, float]:
        """1/R [1/m]: how fast the direction from a corner turns; of an end, that passes SMALL beside one."""
        return 0.0, 0.0, 1.0 / (fields["radius"] if fields["radius"] > 0.0 else SMALL * fields["length"])

    @staticmethod
    def held(
        fields: Fields, on_a: tuple[float, float], corners: Corners, corner: int, a: Pose, b: Pose, sticks: bool
    ) -> tuple[Held, ...]:
        """The centre of a disc beside an edge, or at a distance from a corner."""
        ring, chains, radius = list(around(corners).values()), chains_of(corners), fields["radius"]
        half = 0.5 * fields["length"] * (1.0 if corner < len(chains) else -1.0)
        centre = (on_a[0] + half * math.cos(fields["axis"]), on_a[1] + half * math.sin(fields["axis"]))
        x, y = seen_from(b, a, centre)
        first, edges = chains[corner % len(chains)]
        sides = [(ring[(first + n) % len(ring)], ring[(first + n + 1) % len(ring)]) for n in range(edges)]
        (u, v), (s, t) = min(sides, key=lambda side: math.dist(_nearest(side[0], side[1], (x, y)), (x, y)))
        axis, along = math.atan2(t - v, s - u), ((x - u) * (s - u) + (y - v) * (t - v)) / math.dist((u, v), (s, t))
        if 0.0 <= along <= math.dist((u, v), (s, t)):
            if sticks and not radius > 0.0:
                return (pinned(a, b, (x, y)),)
            return (along_line(axis + math.pi, radius, centre, (u, v), turned=True, rolls=sticks),)
        vertex = (s, t) if along > 0.0 else (u, v)
        return (pinned(a, b, vertex),) if sticks else around_disc(radius, 0.0, centre, vertex, False)
