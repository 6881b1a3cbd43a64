"""The film of a round journal bearing by finite volumes: what the table of the law `finite` is made of.

With e the eccentricity over the clearance, n its direction, phi the angle from n, H = 1 - e cos phi, zeta the distance
from mid-length over half the length, m the direction of the velocity v and L/D the length over the diameter,

    (H^3 P_phi)_phi + (D/L)^2 (H^3 P_zeta)_zeta = -m.u(phi)         P = 0 at zeta = 1,  P_zeta = 0 at zeta = 0

gives the pressure p = 12 mu (R/c)^2 (|v|/c) P.  A film that cavitates solves the complementarity problem: P >= 0, the
left side plus m.u <= 0, and one of both is zero everywhere (Reynolds' condition at the edge of the film follows).

Volumes are those of phi = 2 atan(kappa tan(psi/2)), kappa^4 = (1-e)/(1+e), equally wide in psi: they crowd where the
film is thin and leave some where it is wide.  The discrete problem is the minimum of a quadratic form over P >= 0, as
the continuous one is, so its force, too, is the slope of a potential.  Two grids and Richardson's extrapolation give
the fourth order.

Source: Christopherson (1941), Proc. IMechE 146, 126-135 (the condition P >= 0); Hintermueller, Ito, Kunisch (2002),
SIAM J. Optim. 13, 865-888 (active sets).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FINE = (192, 16)  # volumes around, and along half of the length
MOST_SWEEPS = 200


class FilmState(NamedTuple):
    """Integrals of the pressure, in the units of the short film.

    normal, tangential: I_n, I_t [-]: the force on the pin is -(mu R L^3/c^3) |v| (I_n n + I_t t).
    peak: largest pressure over mu L^2 |v|/c^3.  leakage: what flows out of both ends over 2 R L |v|.
    """

    normal: float
    tangential: float
    peak: float
    leakage: float


class Grid:
    """Finite volumes of one eccentricity and length: their angles, and the coefficients of the balances of flow."""

    def __init__(self, eccentricity: float, ratio: float, around: int, along: int) -> None:
        """ratio: L/D.  around: even number of volumes.  Lines are numbered from the thinnest film on."""
        e = eccentricity
        self.ratio, self.along = ratio, along
        kappa = ((1.0 - e) / (1.0 + e)) ** 0.25
        half = np.pi * (np.arange(2 * around + 1) / (2 * around) - 1.0 / (2 * around))  # psi/2: faces and centres
        angles = 2.0 * np.arctan2(kappa * np.sin(half), np.cos(half))
        self.faces, self.angle = angles[::2], angles[1::2]  # (around + 1,), (around,) [rad]
        cube = (1.0 - e * np.cos(angles)) ** 3
        step = np.diff(np.append(self.angle, self.angle[0] + 2.0 * np.pi))
        self.through = cube[2::2] / step  # (around,) through the face after each line
        self.width = np.diff(self.faces)
        mean = (cube[:-2:2] + 4.0 * cube[1::2] + cube[2::2]) / 6.0
        place = np.sin(0.5 * np.pi * np.arange(2 * along + 1) / (2 * along))  # zeta: centres and faces
        self.weight = np.diff(np.append(0.0, place[1::2]))  # (along,)
        self.end = 1.0 - float(place[-2])  # what is left before the end of the bearing
        self.gap = np.diff(place[::2])  # (along,) from each centre to the next one
        self.lengthwise = (mean * self.width / ratio**2)[:, None] / self.gap  # (around, along) through the face after

    def source(self, alpha: float) -> Array:
        """Integral (around,) of m.u over the volumes, m at the angle alpha [rad] from n."""
        return np.asarray(np.diff(np.sin(self.faces - alpha)))

    def diagonal(self) -> Array:
        """(around, along) of the matrix of the balances."""
        across = (self.through + np.roll(self.through, 1))[:, None] * self.weight
        across += self.lengthwise
        across[:, 1:] += self.lengthwise[:, :-1]
        return np.asarray(across)

    def outflow(self, pressure: Array) -> Array:
        """Left side of the balances: what leaves each volume (around, along), for any pressure of that shape."""
        out = self.diagonal() * pressure
        out -= self.weight * (self.through[:, None] * np.roll(pressure, -1, axis=0))
        out -= self.weight * np.roll(self.through[:, None] * pressure, 1, axis=0)
        out[:, 1:] -= self.lengthwise[:, :-1] * pressure[:, :-1]
        out[:, :-1] -= self.lengthwise[:, :-1] * pressure[:, 1:]
        return out

    def state(self, pressure: Array, alpha: float) -> FilmState:
        """The integrals of a pressure (around, along)."""
        along = pressure @ self.weight
        unit = 3.0 / self.ratio**2
        normal = unit * float(along @ self.source(0.0))
        tangential = unit * float(along @ self.source(0.5 * np.pi))
        positive = np.maximum(pressure, 0.0)
        flow = float((self.lengthwise[:, -1] * positive[:, -1]).sum()) + self._before_the_end(positive, alpha)
        return FilmState(normal, tangential, unit * self._peak(pressure[:, 0]), 0.5 * flow)

    def _before_the_end(self, positive: Array, alpha: float) -> float:
        """What the volumes at the end of the bearing, where the pressure is zero, add to the flow: their source."""
        source = self.source(alpha)
        return self.end * float(source[positive[:, -1] > 0.0].sum())

    def _peak(self, middle: Array) -> float:
        """Largest pressure at mid-length, by a parabola through the highest value and its neighbours."""
        k = int(np.argmax(middle))
        y0, y1, y2 = middle[k - 1], middle[k], middle[(k + 1) % len(middle)]
        h0 = (self.angle[k] - self.angle[k - 1]) % (2.0 * np.pi)
        h1 = (self.angle[(k + 1) % len(middle)] - self.angle[k]) % (2.0 * np.pi)
        slope0, slope1 = (y1 - y0) / h0, (y2 - y1) / h1
        curve = (slope1 - slope0) / (h0 + h1)
        slope = (slope0 * h1 + slope1 * h0) / (h0 + h1)
        return float(y1 - (0.25 * slope**2 / curve if curve < 0.0 else 0.0))


def solve_film(
    eccentricity: float, alpha: float, ratio: float, full: bool = False, fine: tuple[int, int] = FINE
) -> FilmState:
    """The film at an eccentricity [of the clearance] for a velocity at the angle alpha [rad] from n; ratio: L/D.

    full: no cavitation.  Richardson's extrapolation over the grid `fine` and one of half its numbers.
    Raises ArithmeticError if the set of volumes with pressure does not settle.
    """
    coarse, grid = (Grid(eccentricity, ratio, fine[0] // part, fine[1] // part) for part in (2, 1))
    if full:
        return extrapolated(*(mesh.state(full_pressure(mesh, alpha), alpha) for mesh in (coarse, grid)))
    first = cavitated_pressure(coarse, alpha)
    second = cavitated_pressure(grid, alpha, refined(first > 0.0))
    return extrapolated(coarse.state(first, alpha), grid.state(second, alpha))


def refined(positive: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Volumes with pressure on a grid of twice the numbers: where the edge of the film is sought from."""
    around, along = positive.shape
    lines = np.empty((2 * around, along), bool)
    lines[::2], lines[1::2] = positive, positive | np.roll(positive, -1, axis=0)
    finer: NDArray[np.bool_] = np.repeat(lines, 2, axis=1)
    return finer


def extrapolated(coarse: FilmState, fine: FilmState) -> FilmState:
    """Richardson's extrapolation of second-order results on grids of which one has twice the numbers of the other."""
    return FilmState(*((4.0 * y - x) / 3.0 for x, y in zip(coarse, fine, strict=True)))


def cavitated_pressure(grid: Grid, alpha: float, guess: NDArray[np.bool_] | None = None) -> Array:
    """Pressure (around, along) of the complementarity problem; guess: volumes with pressure (around, along)."""
    source = grid.source(alpha)[:, None] * grid.weight
    positive = np.broadcast_to(source > 0.0, source.shape).copy() if guess is None else guess.copy()
    for _ in range(MOST_SWEEPS):
        pressure = _pressure_on(grid, source, positive)
        pushed = np.where(positive, pressure > 0.0, grid.outflow(pressure) < source)
        if np.array_equal(pushed, positive):
            return pressure
        positive = pushed
    raise ArithmeticError(f"the edge of the film did not settle in {MOST_SWEEPS} sweeps")


def _pressure_on(grid: Grid, source: Array, positive: NDArray[np.bool_]) -> Array:
    """Pressure (around, along) that solves the balances of the chosen volumes and is zero in all others."""
    lines = np.asarray(positive.any(axis=1))
    if lines.all():
        raise ArithmeticError("the film closes around the pin: no line without pressure is left")
    start = int(np.argmin(lines))  # a line without pressure: the circle is cut there
    order = np.roll(np.arange(len(lines)), -start)
    last = len(lines) - int(np.argmax(lines[order][::-1]))
    order = order[1:last]
    pressure = np.zeros(source.shape)
    pressure[order] = _solved(grid, order, source[order], positive[order])
    return pressure


def _solved(grid: Grid, order: NDArray[np.int64], source: Array, positive: NDArray[np.bool_]) -> Array:
    """Solve the balances on neighbouring lines (banded, symmetric, positive definite)."""
    from scipy.linalg import solveh_banded

    lines, m = positive.shape
    band = np.zeros((m + 1, lines, m))
    band[0] = np.where(positive, grid.diagonal()[order], 1.0)
    band[1, :, :-1] = np.where(positive[:, :-1] & positive[:, 1:], -grid.lengthwise[order, :-1], 0.0)
    both = positive[:-1] & positive[1:]
    band[m, :-1] += np.where(both, -grid.through[order[:-1]][:, None] * grid.weight, 0.0)
    flat = band.reshape(m + 1, lines * m)
    solved = solveh_banded(
        flat, np.where(positive, source, 0.0).ravel(), lower=True, overwrite_ab=True, check_finite=False
    )
    return np.asarray(solved).reshape(lines, m)


def full_pressure(grid: Grid, alpha: float) -> Array:
    """Pressure (around, along) without cavitation: even in phi for the part of v along n, odd for that across it."""
    even, odd = full_parts(grid)
    return math.cos(alpha) * even + math.sin(alpha) * odd


def full_parts(grid: Grid) -> tuple[Array, Array]:
    """Pressures (around, along) without cavitation for v along n and across it."""
    around = len(grid.angle)
    rows = np.arange(around // 2 + 1)  # half a circle, both ends included
    half = _half(grid, rows)
    even = _solved(half, rows, half.source(0.0)[:, None] * grid.weight, np.ones((len(rows), grid.along), bool))
    odd = np.zeros_like(even)
    inner = rows[1:-1]
    source = grid.source(0.5 * np.pi)[inner][:, None] * grid.weight
    odd[1:-1] = _solved(grid, inner, source, np.ones((len(inner), grid.along), bool))
    mirror = np.abs(np.arange(around) - around * (np.arange(around) > around // 2))
    sign = np.where(np.arange(around) > around // 2, -1.0, 1.0)
    return even[mirror], sign[:, None] * odd[mirror]


def _half(grid: Grid, rows: NDArray[np.int64]) -> Grid:
    """The volumes of half a circle: of the two on its ends only the half that lies in it."""
    half = object.__new__(Grid)
    half.ratio, half.along, half.weight, half.end, half.gap = grid.ratio, grid.along, grid.weight, grid.end, grid.gap
    half.through = grid.through[rows].copy()
    half.through[-1] = 0.0
    part = np.ones(len(rows))
    part[0] = part[-1] = 0.5
    half.lengthwise, half.angle = grid.lengthwise[rows] * part[:, None], grid.angle[rows]
    half.faces = np.append(grid.faces[rows], grid.angle[rows[-1]])
    half.faces[0] = grid.angle[0]
    half.width = np.diff(half.faces)
    return half
