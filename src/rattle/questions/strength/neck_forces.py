"""Normal force, shear force and moment in a cut through a plate that moves.

y along the cut from its first end, x to its right, both in the plate; P: the centroid of the cut.  Each of both parts
moves with the plate: with forces F and couples C of elements on it, its mass m, mass centre c and inertia J about c,

    S = -sum F - m (g - a_c),      M_P = -sum ((r - P) x F + C) - (c - P) x m (g - a_c) + J alpha

are force and moment of the other part on it.  Both parts give the same, which checks the list of loads.

    N = S_x, V = -S_y, M = M_P  of the right part on the left one;   sigma(y) = N/A - M (y - y_P)/I

Source: Timoshenko, Strength of Materials I (1955), chapters 1, 4 and 5, with the forces of inertia of d'Alembert.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.description.cuts import Cut
from rattle.description.model import Body
from rattle.description.polygon import Figure, figure_of
from rattle.errors import SolverError
from rattle.language.recorded import bare
from rattle.questions.strength.known_motion import KnownMotion
from rattle.questions.strength.wrenches import Wrench, wrenches_on

Array = NDArray[np.float64]
CLOSES = 1e-8  # share of the largest force, and of that times the size of the plate, by which both parts may differ
EVEN = 1e-9  # share by which mass centre and inertia may miss those of the polygon


class CutSection(NamedTuple):
    """The material in a cut: rectangles beside each other."""

    area: float  # [m^2]
    inertia: float  # second moment about its centroid [m^4]
    centre: float  # of its centroid, along the cut [m]
    pieces: tuple[tuple[float, float], ...]  # from where to where [m]

    @property
    def edges(self) -> tuple[float, float]:
        """Where its outermost fibres are, along the cut [m]."""
        return self.pieces[0][0], self.pieces[-1][1]


def section_of(cut: Cut, thickness: float) -> CutSection:
    """The section of a plate of this thickness [m] in a cut."""
    start, end = np.array(cut.pieces).T
    width = end - start
    centre = float((width * (start + end)).sum() / (2.0 * width.sum()))
    second = ((end - centre) ** 3 - (start - centre) ** 3).sum() / 3.0
    return CutSection(float(thickness * width.sum()), float(thickness * second), centre, tuple(cut.pieces))


class NeckForces(NamedTuple):
    """What a cut bears at n instants."""

    normal: Array  # (n,) tension positive [N]
    shear: Array  # (n,) [N]
    moment: Array  # (n,) positive: tension towards the first end [N m]
    doubt: tuple[float, float] | None  # by how much force [N] and moment [N m] may be off, if the mass lies otherwise


class _Sum(NamedTuple):
    """What acts on one part: (n, 2) [N], and (n,) about the centroid of the cut [N m]."""

    force: Array
    moment: Array


def forces_in(motion: KnownMotion, name: str, body: Body, cut: Cut, centroid: Array) -> NeckForces:
    """Forces in a cut, and its moment about the centroid (2,) [m].

    Raises SolverError if what both parts say differs, unless the plate's own mass, centre and inertia are given.
    """
    loads = _loads(motion, body.name)
    whole = figure_of(*_rings(body))
    density = bare(body.mass) / whole.area
    left, right = (_on_part(motion, body.name, loads, cut, side, density, centroid) for side in (True, False))
    force = 0.5 * (right.force - left.force)
    moment = 0.5 * (right.moment - left.moment)
    off = [
        np.abs(part)[motion.defined].max(initial=0.0) for part in (right.force + left.force, right.moment + left.moment)
    ]
    size = float(np.ptp(np.array(_rings(body)[0]), axis=0).max())
    doubt = None
    if not _is_even(body, whole, density, size):
        doubt = 0.5 * float(off[0]), 0.5 * float(off[1])
    else:
        _require_closed(motion, name, loads, (left, right), off, size)
    x = np.array([cut.along[1], -cut.along[0]])
    return NeckForces(force @ x, -force @ cut.along, moment, doubt)


def _rings(body: Body) -> tuple[list[tuple[float, float]], list[list[tuple[float, float]]]]:
    outline, *holes = ([(bare(x), bare(y)) for x, y in ring] for ring in body.outline)
    return outline, holes


def _is_even(body: Body, whole: Figure, density: float, size: float) -> bool:
    """True if the mass of a plate lies as its polygon says."""
    off = abs(density * whole.second - bare(body.inertia))
    return max(map(abs, whole.centre)) <= EVEN * size and off <= EVEN * bare(body.inertia)


class _Load(NamedTuple):
    """A force and a couple at a point, in the frame of the plate."""

    spot: Array  # (n, 2), or (1, 2) if it stays [m]
    force: Array  # (n, 2) [N]
    couple: Array  # (n,) [N m]


def _loads(motion: KnownMotion, body: str) -> list[_Load]:
    angle = motion.angle(body)
    cos, sin = np.cos(angle), np.sin(angle)

    def turned(vectors: Array) -> Array:
        x, y = vectors.T
        return np.column_stack([cos * x + sin * y, cos * y - sin * x])

    def load(wrench: Wrench) -> _Load:
        spot = turned(wrench.spot) if wrench.fixed is None else np.array([wrench.fixed], float)
        return _Load(spot, turned(wrench.force), wrench.couple)

    return [load(wrench) for wrench in wrenches_on(motion, body)]


def _on_part(
    motion: KnownMotion, body: str, loads: list[_Load], cut: Cut, is_left: bool, density: float, centroid: Array
) -> _Sum:
    """What elements, weight and inertia exert on one part; density: mass per area [kg/m^2]."""
    figure = cut.left if is_left else cut.right
    mass, centre = density * figure.area, np.array(figure.centre)
    (_, _, angle), (_, _, rate), (ax, ay, turning) = motion.bodies()[:, motion.system.bodies.index(body)].transpose(
        1, 2, 0
    )
    fall = motion.gravity() - np.column_stack([ax, ay])
    cos, sin = np.cos(angle), np.sin(angle)
    fall = np.column_stack([cos * fall[:, 0] + sin * fall[:, 1], cos * fall[:, 1] - sin * fall[:, 0]])
    across = np.array([-centre[1], centre[0]])
    force = mass * (fall + np.outer(rate * rate, centre) - np.outer(turning, across))
    moment = _cross(centre - centroid, force) - density * figure.second * turning
    for load in loads:
        acts = cut.is_left(load.spot, load.force) == is_left
        force = force + acts[:, None] * load.force
        moment = moment + acts * (_cross(load.spot - centroid, load.force) + load.couple)
    return _Sum(force, moment)


def _cross(arm: Array, force: Array) -> Array:
    return np.asarray(arm[..., 0] * force[:, 1] - arm[..., 1] * force[:, 0])


def _require_closed(
    motion: KnownMotion, name: str, loads: list[_Load], parts: tuple[_Sum, _Sum], off: list[float], size: float
) -> None:
    """Raise SolverError unless both parts exert the same on each other."""
    forces = [*(load.force for load in loads), *(part.force for part in parts)]
    couples = [*(load.couple for load in loads), *(part.moment for part in parts)]
    force, couple = (
        max((np.abs(value[motion.defined]).max(initial=0.0) for value in values), default=0.0)
        for values in (forces, couples)
    )
    if off[0] > CLOSES * force or off[1] > CLOSES * max(force * size, couple):
        raise SolverError(
            f"both parts of the plate at its neck '{name}' do not balance: {off[0]:.3g} N and {off[1]:.3g} N*m are"
            " left; a load is missing",
            None,
        )
