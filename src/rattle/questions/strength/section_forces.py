"""Normal force, shear force and moment along a straight bar that moves, exactly.

x from end A to end B, y to the left of it, both in the bar; F, C: force and couple of an element at (x_i, y_i);
rho_l(x): mass per length, straight between its points;  a(x) = a_C + alpha x r - w^2 r  along the bar.

    N' = -rho_l (g_x - a_x),   V' = rho_l (g_y - a_y),   M' = V,    jumps  -F_x,  F_y,  y_i F_x - C
    E I v'' = M,  v(A) = v(B) = 0;      e' = N/(E A),  e(A) = 0

N: tension positive.  V: what the part before x exerts along y on the part after it.  M positive: tension on the side of
-y.  Between loads a is linear in x, so all are polynomials, which are evaluated, not summed up on a grid.
Behind B all three must be zero, by the equations of motion of the body: that checks the list of loads.

Source: Timoshenko, Strength of Materials I (1955), chapters 3 and 5, with the forces of inertia of d'Alembert.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rattle.description.model import Beam
from rattle.errors import SolverError
from rattle.questions.strength.known_motion import KnownMotion
from rattle.questions.strength.wrenches import Wrench, wrenches_on

Array = NDArray[np.float64]
EVEN = 101  # stations at even distances: a parabola's top is met within 1e-4 of its height
AT_END = 1e-9  # share of the length within which a load acts at an end, or a station is that of a load
CLOSES = 1e-8  # share of the largest force, and of that times the length, that may be left behind B


class PointLoad(NamedTuple):
    """What acts at one point of the bar, in its directions."""

    x: Array  # (n, 1) along the bar, within its length [m]
    along: Array  # (n, 1) F_x [N]
    across: Array  # (n, 1) F_y [N]
    turn: Array  # (n, 1) jump of the moment, y F_x - C, with the lever of a force beyond an end [N m]
    fixed: bool  # x does not change


class LineMass:
    """Integrals from A of rho_l and rho_l (x - x_C), up to four times."""

    def __init__(self, beam: Beam) -> None:
        from scipy.interpolate import PPoly

        x, density = (np.array(column, float) for column in zip(*beam.line, strict=True))
        slope = np.diff(density) / np.diff(x)
        arm = x[:-1] - beam.centre
        plain = PPoly(np.array([slope, density[:-1]]), x)
        first = PPoly(np.array([slope, density[:-1] + slope * arm, density[:-1] * arm]), x)
        self._plain = [plain.antiderivative(n) for n in range(1, 5)]
        self._first = [first.antiderivative(n) for n in range(1, 5)]

    def integrals(self, times: int, x: Array) -> tuple[Array, Array]:
        """Both, integrated so often, at x [m], of its shape."""
        return self._plain[times - 1](x), self._first[times - 1](x)


class LoadedBar:
    """A bar with all that acts on it at n instants."""

    def __init__(self, motion: KnownMotion, body: str, beam: Beam) -> None:
        self.beam = beam
        self.line = LineMass(beam)
        (_, _, angle), (_, _, rate), (ax, ay, turning) = motion.bodies()[:, motion.system.bodies.index(body)].transpose(
            1, 2, 0
        )
        self._cos, self._sin = np.cos(angle), np.sin(angle)
        self.fall_x, self.fall_y = self._turned(motion.gravity() - np.column_stack([ax, ay]))  # g - a_C
        self.square, self.turning = (rate * rate)[:, None], turning[:, None]  # w^2, alpha
        self.wrenches = wrenches_on(motion, body)
        ends = [self._end_mass(mass, x) for mass, x in zip(beam.at_ends, (0.0, beam.length), strict=True) if mass]
        self.loads = [*map(self._point_load, self.wrenches), *ends]

    def _turned(self, vectors: Array) -> tuple[Array, Array]:
        """Components (n, 1) along and across the bar of vectors (n, 2)."""
        x, y = vectors.T
        return (self._cos * x + self._sin * y)[:, None], (self._cos * y - self._sin * x)[:, None]

    def _point_load(self, wrench: Wrench) -> PointLoad:
        along, across = self._turned(wrench.force)
        x, y = self._turned(wrench.spot)
        if wrench.fixed is not None:  # without the rounding of the turn there and back
            x, y = np.full_like(x, wrench.fixed[0]), np.full_like(y, wrench.fixed[1])
        place = x + self.beam.centre
        inside = self._snapped(place)
        turn = y * along - wrench.couple[:, None] + across * (inside - place)
        return PointLoad(inside, along, across, turn, wrench.fixed is not None)

    def _snapped(self, x: Array) -> Array:
        """Places of loads on the bar: those beyond an end, or right beside it, at that end."""
        length = self.beam.length
        x = np.clip(x, 0.0, length)
        x = np.where(x < AT_END * length, 0.0, x)
        return np.where(x > (1.0 - AT_END) * length, length, x)

    def _end_mass(self, mass: float, x: float) -> PointLoad:
        """A mass at an end: its weight and inertia."""
        arm = x - self.beam.centre
        along = mass * (self.fall_x + self.square * arm)
        across = mass * (self.fall_y - self.turning * arm)
        return PointLoad(np.full_like(along, x), along, across, np.zeros_like(along), True)

    # ---------------------------------------------------------------- where
    @cached_property
    def stations(self) -> tuple[Array, NDArray[np.bool_]]:
        """Places (nx,) [m]: even ones, the ends, and every load that stays, twice; True right behind a load.

        The first lies right behind what acts at A, the last right before what acts at B.
        """
        length = self.beam.length
        loaded = np.unique([load.x[0, 0] for load in self.loads if load.fixed])
        inner = loaded[(loaded > 0.0) & (loaded < length)]
        even = np.linspace(0.0, length, EVEN)
        beside = np.abs(even[:, None] - inner).min(axis=1, initial=np.inf) < AT_END * length
        even = even[~beside]
        x = np.concatenate([even, inner, inner])
        after = np.concatenate([even < length, np.zeros(len(inner), bool), np.ones(len(inner), bool)])
        order = np.lexsort([after, x])
        return x[order], after[order]

    @property
    def moving(self) -> tuple[Array, NDArray[np.bool_]]:
        """The same (n, 2 k) of loads whose place changes, right before and right behind each."""
        moving = [load.x for load in self.loads if not load.fixed]
        if not moving:
            return np.zeros((len(self.square), 0)), np.zeros(0, bool)
        return np.concatenate([*moving, *moving], axis=1), np.repeat([False, True], len(moving))

    # ---------------------------------------------------------------- what acts there
    def forces(self, x: Array, after: ArrayLike) -> tuple[Array, Array, Array]:
        """N, V [N] and M [N m] (n, nx) at places (nx,) or (n, nx); after: right behind a load there, or before it."""
        plain, first = self.line.integrals(1, x)
        plain_sum, first_sum = self.line.integrals(2, x)
        normal = -(plain * self.fall_x + first * self.square)
        shear = plain * self.fall_y - first * self.turning
        moment = plain_sum * self.fall_y - first_sum * self.turning
        for load in self.loads:
            acts = np.where(after, load.x <= x, load.x < x)
            normal -= acts * load.along
            shear += acts * load.across
            moment += acts * (load.across * (x - load.x) + load.turn)
        return normal, shear, moment

    def stretch(self, x: Array) -> Array:
        """The integral of N from A (n, nx) [N m] at places (nx,)."""
        plain, first = self.line.integrals(2, x)
        total: Array = -(plain * self.fall_x + first * self.square)
        for load in self.loads:
            total -= load.along * np.maximum(x - load.x, 0.0)
        return total

    def sag(self, x: Array) -> Array:
        """The double integral of M (n, nx) [N m^3] at places (nx,) that vanishes at both ends."""

        def twice(x: Array) -> Array:
            plain, first = self.line.integrals(4, x)
            total: Array = plain * self.fall_y - first * self.turning
            for load in self.loads:
                beyond = np.maximum(x - load.x, 0.0)
                total += load.across * beyond**3 / 6.0 + load.turn * beyond**2 / 2.0
            return total

        length = self.beam.length
        return twice(x) - twice(np.array([length])) * (x / length)

    def require_closed(self, defined: NDArray[np.bool_], largest: Sequence[Array]) -> None:
        """Raise SolverError unless nothing is left behind B at the instants that are defined.

        largest: forces along the bar, which tell what is small.
        """
        behind = [part[defined, 0] for part in self.forces(np.array([self.beam.length]), True)]
        forces = [np.abs(part[defined]).max(initial=0.0) for part in largest[:2]]
        forces += [np.abs(part[defined]).max(initial=0.0) for load in self.loads for part in (load.along, load.across)]
        couples = [np.abs(load.turn[defined]).max(initial=0.0) for load in self.loads]
        force = max(forces)
        moment = max(force * self.beam.length, *couples, np.abs(largest[2][defined]).max(initial=0.0))
        left = [np.abs(part).max(initial=0.0) for part in behind]
        if max(left[:2]) > CLOSES * force or left[2] > CLOSES * moment:
            raise SolverError(
                f"forces along the bar do not close at its end '{self.beam.ends[1]}': {left[0]:.3g} N, {left[1]:.3g} N"
                f" and {left[2]:.3g} N*m are left; a load is missing",
                None,
            )
