"""A disc with a sector cut out against the hollow arcs of a wheel: what holds the wheel of a Geneva drive at rest.

Corners are round (radius r): the edges of the disc are circles about E = (R - r) (cos kappa, +-sin kappa), from the
middle of the sector that is cut out, 2 kappa wide; the horns of the wheel are circles about H, where an arc (radius
R + c, centre K) ends: |H - K| = R + c + r, at +-beta from the direction from K to the axis of the wheel.

    horn and disc       g = |H - f| - 2 r,  f the point nearest to H of the sector with the edges E, of radius R - r:
                        on its arc, where g = |H| - R - r, on one of its straight sides, or E
    edge and arc        g = ||E - K| - R - c| - r,  if E is in front of the arc: within +-beta; an arc is a thin wall
                        as in `clearances.pin_in_slot`

Contact 0 is the least of the gaps of all horns at -beta, with the edge at +kappa, which uncovers them; contact 1 that
of the horns at +beta with the edge at -kappa.  Where an edge passes a horn, horn and corner, then corner and arc have
the same gap and normal, so that the contact goes on.  That the arc bears in its middle, which it does only where the
axes have play of their own, is left to its ends: they bear c (1/cos(beta) - 1) later.

See `elements.disc_contact` for the rows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from rattle.elements.disc_contact import write_disc
from rattle.elements.geneva import half_angle
from rattle.interfaces.contacts import Corners, OneSidedKind
from rattle.interfaces.fields import Fields
from rattle.jit import layout as at
from rattle.jit.functions import compiled, kernel
from rattle.jit.geometry import COINCIDENT, ends
from rattle.language.local_function import LocalFunction
from rattle.language.recorded import cos, hypot, sin
from rattle.registry import kind

FAR = 1e30  # gap [m] of a contact before the first candidate


class Lock(NamedTuple):
    """What the kernel takes after the points."""

    cut_cos: float  # direction of the middle of the sector that is cut out, in A
    cut_sin: float
    edge_x: float  # of the centre of an edge, from the middle of that sector [m]
    edge_y: float
    rounding: float  # r [m]
    arcs: float  # how many
    step_cos: float  # from one arc to the next
    step_sin: float
    centre_x: float  # of the first arc, in B about its point [m]
    centre_y: float
    hollow: float  # R + c [m]
    span_cos: float  # cosine and sine of beta
    span_sin: float
    play: float  # c [m]


CUT_COS, CUT_SIN, EDGE_X, EDGE_Y, ROUNDING, ARCS, STEP_COS, STEP_SIN = range(at.POINTS, at.POINTS + 8)
CENTRE_X, CENTRE_Y, HOLLOW, SPAN_COS, SPAN_SIN, PLAY = range(at.POINTS + 8, at.POINTS + 14)


@compiled
def to_sector(x, y, ex, ey):
    """Offset (x, y) [m] and distance from the nearest point of the sector with the edges (ex, +-ey) to a point (x, y).

    Both from its centre, in the frame of the middle of what is cut out.  Also returns `bent` of a wall there.
    """
    side = 1.0 if y >= 0.0 else -1.0
    y = side * y
    radius = math.sqrt(ex * ex + ey * ey)
    far, along = math.sqrt(x * x + y * y), (ex * x + ey * y) / radius
    inside = (ex * y - ey * x) / radius  # from the straight side into the material
    if inside >= 0.0:
        return x, side * y, far, far - radius, -1.0 / max(far, COINCIDENT)
    if along <= radius:
        return -inside * ey / radius, side * inside * ex / radius, -inside, -inside, 0.0
    fx, fy = x - ex, y - ey
    away = math.sqrt(fx * fx + fy * fy)
    return fx, side * fy, away, away, -1.0 / max(away, COINCIDENT)


@kernel("clearance")
def locked_arcs(body, a, b, p, k, corner, row, kinematics):
    """Write gap [m], its rate [m/s], normal, arms [m], slip [m/s] and gamma [m/s^2] of one side into its row."""
    sax, say, sbx, sby, dx, dy, _, _ = ends(body, a, b, p, k)
    cos_a, sin_a, cos_b, sin_b = body[a, at.COS], body[a, at.SIN], body[b, at.COS], body[b, at.SIN]
    sense = -1.0 if corner == 0 else 1.0
    r, hollow = p[k + ROUNDING], p[k + HOLLOW]
    cut_x = cos_a * p[k + CUT_COS] - sin_a * p[k + CUT_SIN]
    cut_y = sin_a * p[k + CUT_COS] + cos_a * p[k + CUT_SIN]
    # the edge, from the axis of the disc
    ex, ey = p[k + EDGE_X], -sense * p[k + EDGE_Y]
    edge_x, edge_y = cut_x * ex - cut_y * ey, cut_y * ex + cut_x * ey
    # the centre of an arc, from the axis of the wheel
    kx = cos_b * p[k + CENTRE_X] - sin_b * p[k + CENTRE_Y]
    ky = sin_b * p[k + CENTRE_X] + cos_b * p[k + CENTRE_Y]
    distance = math.sqrt(kx * kx + ky * ky)
    gap, bent, nx, ny, on_b = FAR, 0.0, 1.0, 0.0, True
    ox, oy = 0.0, 0.0  # the centre of the round corner that touches, from the axis of the disc
    for _ in range(int(p[k + ARCS])):
        # the horn
        far = (hollow + r) / distance
        hx, hy = -far * kx, -far * ky
        c, s = p[k + SPAN_COS], sense * p[k + SPAN_SIN]
        hx, hy = dx + kx + c * hx - s * hy, dy + ky + s * hx + c * hy
        fx, fy, away, over, curved = to_sector(cut_x * hx + cut_y * hy, cut_x * hy - cut_y * hx, ex, p[k + EDGE_Y])
        if over - 2.0 * r < gap and away > COINCIDENT:
            gap, bent, on_b, ox, oy = over - 2.0 * r, curved, True, hx, hy
            nx, ny = -(cut_x * fx - cut_y * fy) / away, -(cut_y * fx + cut_x * fy) / away
        # the edge, from the centre of the arc
        qx, qy = edge_x - dx - kx, edge_y - dy - ky
        off = math.sqrt(qx * qx + qy * qy)
        wall = 1.0 if off <= hollow else -1.0
        if -(qx * kx + qy * ky) >= p[k + SPAN_COS] * off * distance and wall * (hollow - off) - r < gap:
            gap, on_b, ox, oy = wall * (hollow - off) - r, False, edge_x, edge_y
            bent = wall / max(off, COINCIDENT)
            nx, ny = -bent * qx, -bent * qy
        kx, ky = p[k + STEP_COS] * kx - p[k + STEP_SIN] * ky, p[k + STEP_SIN] * kx + p[k + STEP_COS] * ky
    write_disc(
        body, a, b, on_b, sax + ox, say + oy, sbx + ox - dx, sby + oy - dy, nx, ny, gap, r, bent, row, kinematics
    )


@kind("one-sided", "locked-arcs", locked_arcs)
class LockedArcs(OneSidedKind):
    """The hollow arcs of a wheel on a disc with a sector cut out: two contacts, one for each sense of the wheel.

    Source: Bickford, Mechanisms for Intermittent Motion (1972), chapter 9 (the locking surfaces of Geneva drives);
    Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapter 2.
    """

    joint = "locking-disc"
    contacts = 2
    wall = "a locking disc"
    walls_turn = True
    slides = True

    @staticmethod
    def parameters(fields: Fields, constants: Sequence[float], corners: Corners) -> Sequence[float | LocalFunction]:
        """Edges of the disc, arcs of the wheel."""
        r, kappa, beta = fields["rounding"], 0.5 * fields["opening"], half_angle(fields)
        step, inner = 2.0 * math.pi / fields["arcs"], fields["radius"] - fields["rounding"]
        return Lock(
            cos(fields["axis"]),
            sin(fields["axis"]),
            inner * cos(kappa),
            inner * sin(kappa),
            r,
            fields["arcs"],
            cos(step),
            sin(step),
            fields["axle_distance"] * cos(fields["first"]),
            fields["axle_distance"] * sin(fields["first"]),
            fields["radius"] + fields["play"],
            cos(beta),
            sin(beta),
            fields["play"],
        )

    @staticmethod
    def levers(p: Sequence[float]) -> tuple[float, float]:
        """Arms [m] of the edges, and of the centres of the arcs, which are farther away than the horns."""
        disc, arc = hypot(p[EDGE_X], p[EDGE_Y]), hypot(p[CENTRE_X], p[CENTRE_Y])
        return hypot(p[0], p[1]) + disc, hypot(p[2], p[3]) + arc

    @staticmethod
    def scale(p: Sequence[float], size: float) -> float:
        """The play [m]."""
        return p[PLAY]

    @staticmethod
    def bends(fields: Fields, constants: Sequence[float]) -> tuple[float, float, float]:
        """1/(2 r) [1/m]: how fast the direction from an edge to a horn turns."""
        return 0.0, 0.0, 0.5 / fields["rounding"]
