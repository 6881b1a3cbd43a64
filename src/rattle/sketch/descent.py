"""The lowest position of an aim near the present one, with joints closed and gaps open; see `pull`."""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

import numpy as np

from rattle.analyses.assembly.rank import RANK, free_motions
from rattle.sketch.movable import Movable
from rattle.sketch.nearest_step import nearest_step, pressures

BY_MASS = 1e-3  # weight of the change of all bodies against the distance of the point
STEPS = 24  # of Newton's method in one move
HALVINGS = 14
FARTHEST = 0.3  # sizes of the mechanism by which a body moves, and rad by which it turns, in one step
STRAY = 0.5  # share of a step that closing the joints may change: more may be another branch
SMALL = 1e-10  # sizes of the mechanism: a step that is none
LAST = 1e-6  # sizes: behind such a step the next one is none, as Newton's method squares the error
DIFFERENCE = 1e-7  # sizes of the mechanism, for curvatures by differences
ROUNDING = 1e-14  # squares of the size below which an aim has not changed
TOUCHES = 1e-10  # gap, in sizes or rad, of a contact that presses
SLIGHT = 1e-9  # share of the slope of the aim below which nothing presses
CUTS = 3  # rounds in which contacts that a step would enter are taken into it
MOST_NEAR = 80  # contacts that a step minds
ON_RIDGE = 1e-4  # sizes of the mechanism by which a ridge is near: the side from which it came decides
OFF_RIDGE = 1e-3  # first step off a ridge, in sizes
APART = 1e-3  # sizes by which an earlier position is another one
BESIDE = 0.05  # sizes up to which the way back is straight
MOST_KEPT = 100  # positions of the way back


class Aim(Protocol):
    """What is to be as low as possible: a function of the place of the point."""

    weight: float  # of the change of all bodies

    def value(self, place: np.ndarray) -> float:
        """Its value."""

    def slope(self, place: np.ndarray) -> np.ndarray:
        """Its slopes (2,)."""


class Hand:
    """Half the square of the distance from the mouse [m^2]."""

    weight = BY_MASS

    def __init__(self, at: np.ndarray) -> None:
        self.at = at

    def value(self, place: np.ndarray) -> float:
        """|r - h|^2 / 2."""
        return 0.5 * float((place - self.at) @ (place - self.at))

    def slope(self, place: np.ndarray) -> np.ndarray:
        """Its slopes r - h."""
        away: np.ndarray = place - self.at
        return away


class Force:
    """Potential of a constant force (2,) [N] of size 1."""

    weight = BY_MASS

    def __init__(self, force: np.ndarray) -> None:
        self.force = force

    def value(self, place: np.ndarray) -> float:
        """Its potential -F . r."""
        return -float(self.force @ place)

    def slope(self, place: np.ndarray) -> np.ndarray:
        """Its slopes -F."""
        return -self.force


class Local(NamedTuple):
    """The mechanism near a position, in u."""

    free: np.ndarray  # (3 nb, f) motions that joints leave, of length 1
    slope: np.ndarray  # (3 nb,) of the aim with the change by masses
    jacobian: np.ndarray  # (2, 3 nb) of the point
    near: np.ndarray  # contacts that a step minds
    gaps: np.ndarray  # (k,) theirs
    sides: np.ndarray  # (k, 3 nb) their slopes
    factors: np.ndarray  # (k,) their pressure
    reaction: np.ndarray  # (nr,) of the rows of joints


class End(NamedTuple):
    """Where and why a descent ended."""

    freedom: int  # motions that the joints leave
    reach: float  # largest share of the point in such a motion of all bodies
    most: float  # the largest such share since the point was taken
    pressing: tuple[int, ...]  # contacts that press
    settled: bool  # nothing is lower near


class Descent:
    """Goes down an aim from position to position, and remembers from where it came."""

    def __init__(self, movable: Movable, body: int, point: tuple[float, float]) -> None:
        self.movable, self.point, self._k = movable, point, 3 * body
        self.end = End(0, 0.0, 0.0, (), True)
        self._most = 0.0
        self._trail: list[np.ndarray] = []  # u of earlier positions, apart from each other
        self._free: np.ndarray | None = None  # motions at the last position that was not singular

    def place(self, q: np.ndarray) -> np.ndarray:
        """Where the point is at q (3 nb,) [m]."""
        x, y, angle = q[self._k : self._k + 3].tolist()
        c, s, (a, b) = math.cos(angle), math.sin(angle), self.point
        return np.array([x + c * a - s * b, y + s * a + c * b])

    def lowest(self, q: np.ndarray, aim: Aim) -> np.ndarray:
        """Positions (3 nb,) from q on at which the aim, with the change from q by masses, is lowest."""
        first, escaped, settled = q, False, False
        self._note(q)
        for _ in range(STEPS):
            local = self._local(q, first, aim)
            if q is first:
                self._most = max(self._most, self._reach(local))
            curve = self._curvature(q, first, aim, local)
            if not np.isfinite(curve).all():  # at the end of a table or of the domain of a function
                break
            off = None if escaped else self._off_ridge(q, local, curve)
            escaped |= off is not None
            step = self._step(q, local, curve, aim.weight) if off is None else off
            if step is None or float(np.abs(step).max(initial=0.0)) <= SMALL * self.movable.size:
                settled = True
                break
            q_new = self._walked(q, step, first, aim)
            if q_new is None and off is None:
                break
            q = q if q_new is None else q_new
            self._note(q)
            if off is None and float(np.abs(step).max()) <= LAST * self.movable.size and self._presses_as(local):
                settled = True
                break
        self._ended(local, settled)
        return q

    # ------------------------------------------------------------ where it is
    def _local(self, q: np.ndarray, first: np.ndarray, aim: Aim) -> Local:
        movable, scale = self.movable, self.movable.scale
        movable.locate(q)
        rows = movable.rows
        length = np.linalg.norm(rows, axis=1)
        length[length == 0.0] = 1.0
        left, values, right = np.linalg.svd(rows / length[:, None])
        rank = int((values > RANK * values[0]).sum()) if len(values) else 0
        free = self._same_motions(right[rank:].T)
        jacobian = np.zeros((2, len(q)))
        arm, k = self.place(q) - q[self._k : self._k + 2], self._k
        jacobian[:, k : k + 3] = np.array([[1.0, 0.0, -arm[1]], [0.0, 1.0, arm[0]]]) / scale[k : k + 3]
        slope = jacobian.T @ aim.slope(self.place(q)) + aim.weight * scale * (q - first)
        gaps = movable.gaps
        near = np.flatnonzero(gaps < 2.0 * FARTHEST)
        near = near[np.argsort(gaps[near], kind="stable")[:MOST_NEAR]]
        sides, factors = movable.sides(near), np.zeros(len(near))
        touching = gaps[near] <= TOUCHES
        if touching.any():
            factors[touching] = pressures((sides[touching] @ free).T, free.T @ slope)
        reaction = left[:, :rank] @ ((right[:rank] @ (slope - sides.T @ factors)) / values[:rank]) / length
        return Local(free, slope, jacobian, near, gaps[near], sides, factors, reaction)

    def _same_motions(self, free: np.ndarray) -> np.ndarray:
        """The motions that the joints leave; where a position is singular, those nearest to the last ones."""
        last = self._free
        if last is None or free.shape[1] <= last.shape[1]:
            self._free = free
            return free
        ways = np.linalg.svd(free.T @ last)[0]
        kept: np.ndarray = free @ ways[:, : last.shape[1]]
        return kept

    def _curvature(self, q: np.ndarray, first: np.ndarray, aim: Aim, local: Local) -> np.ndarray:
        """(f, f) second derivatives of the aim along the free motions, with those of joints and pressed contacts."""
        movable, scale, step = self.movable, self.movable.scale, DIFFERENCE * self.movable.size
        pressed = local.factors > 0.0
        which, factors = local.near[pressed], local.factors[pressed]

        def slope(place: np.ndarray) -> np.ndarray:
            movable.locate(place)
            total: np.ndarray = aim.weight * scale * (place - first) - movable.push(local.reaction, which, factors)
            point, k = self.place(place), self._k
            arm, pull = point - place[k : k + 2], aim.slope(point)
            total[k : k + 3] += np.array([*pull, pull[1] * arm[0] - pull[0] * arm[1]]) / scale[k : k + 3]
            return total

        here, changes = slope(q), np.empty((len(q), local.free.shape[1]))
        for n, way in enumerate(local.free.T):
            changes[:, n] = (slope(q + step * way / scale) - here) / step
        curve = local.free.T @ changes
        even: np.ndarray = 0.5 * (curve + curve.T)
        return even

    # ------------------------------------------------------------ a step
    def _step(self, q: np.ndarray, local: Local, curve: np.ndarray, least: float) -> np.ndarray | None:
        """The change of u (3 nb,) to the lowest place of the parabola that the gaps allow; None if there is none.

        Where the parabola bends downwards it is turned over, so that it leads away from a ridge.
        """
        free, movable = local.free, self.movable
        if not free.shape[1]:
            return None
        values, ways = np.linalg.eigh(curve)
        root = ways / np.sqrt(np.maximum(np.abs(values), least))
        c = free.T @ local.slope
        sides, bound = local.sides @ free, -np.maximum(local.gaps, 0.0)
        pressed, open_by = local.near[local.factors > 0.0], np.full(len(movable.acts), 2.0 * FARTHEST)
        open_by[local.near] = np.maximum(local.gaps, 0.0)
        taken: np.ndarray | None = None
        for _ in range(CUTS + 1):
            y = nearest_step(root, c, sides, bound)
            if y is None:
                break
            taken = self._limited(free @ y)
            if not len(movable.acts):
                break
            movable.locate(q + taken / movable.scale)
            gaps = movable.gaps
            gaps[pressed] = np.inf  # the parabola knows how these bend
            entered = np.flatnonzero(gaps < -TOUCHES)
            if not len(entered):
                break
            more = movable.sides(entered)
            sides = np.vstack([sides, more @ free])
            bound = np.concatenate([bound, np.minimum(more @ taken - gaps[entered], -open_by[entered])])
        return taken

    def _limited(self, change: np.ndarray) -> np.ndarray:
        """A change of u (3 nb,) no farther than a step may be."""
        by_q = np.abs(change / self.movable.scale)
        by_q[0::3] /= self.movable.size
        by_q[1::3] /= self.movable.size
        return change * min(1.0, FARTHEST / max(float(by_q.max(initial=0.0)), 1e-300))

    def _off_ridge(self, q: np.ndarray, local: Local, curve: np.ndarray) -> np.ndarray | None:
        """A step off a ridge of the aim that is near: to the side from which it came, else down; None off a ridge."""
        size, pressed = self.movable.size, local.factors > 0.0
        along = np.eye(len(curve))
        if pressed.any():
            along = free_motions(local.sides[pressed] @ local.free).T
        if not along.shape[1]:
            return None
        values, ways = np.linalg.eigh(along.T @ curve @ along)
        slope = local.slope - local.sides.T @ local.factors
        if values[0] >= 0.0 or float(np.linalg.norm(local.free.T @ slope)) > -values[0] * ON_RIDGE * size:
            return None
        back = local.free @ along @ ways[:, 0]
        down = -float(back @ slope)
        before = self._from_where(q)
        sense = down if before is None else float(back @ before)
        step = self._limited(math.copysign(OFF_RIDGE * size, sense) * back)
        return None if (local.sides @ step < -np.maximum(local.gaps, TOUCHES)).any() else step

    def _presses_as(self, local: Local) -> bool:
        """True if all that touches where it was located last pressed before its last step already."""
        touching = np.flatnonzero(self.movable.gaps <= TOUCHES)
        return set(touching.tolist()) == set(local.near[local.factors > 0.0].tolist())

    def _note(self, q: np.ndarray) -> None:
        """Add a position to the trail, if it is apart from the last one."""
        u = self.movable.scale * q
        if not self._trail or float(np.linalg.norm(u - self._trail[-1])) > APART * self.movable.size:
            self._trail = [*self._trail[1 - MOST_KEPT :], u]

    def _from_where(self, q: np.ndarray) -> np.ndarray | None:
        """The way back (3 nb,) along the trail, as far as it is straight; None without one."""
        u, way = self.movable.scale * q, None
        for earlier in reversed(self._trail):
            if float(np.linalg.norm(earlier - u)) > BESIDE * self.movable.size:
                break
            way = earlier - u
        return way

    def _walked(self, q: np.ndarray, step: np.ndarray, first: np.ndarray, aim: Aim) -> np.ndarray | None:
        """Closed positions at the end of a step or a part of it, where the aim is lower; None if there are none."""
        movable, share = self.movable, 1.0
        here, rounding = self._height(q, first, aim), ROUNDING * movable.size**2
        for _ in range(HALVINGS):
            ahead = q + share * step / movable.scale
            closed = movable.closed(ahead)
            if closed is not None and self._height(closed, first, aim) <= here + rounding:
                stray = float(np.linalg.norm((closed - ahead) * movable.scale))
                if stray <= STRAY * share * float(np.linalg.norm(step)) + SMALL * movable.size:
                    return closed
            share *= 0.5
        return None

    def _height(self, q: np.ndarray, first: np.ndarray, aim: Aim) -> float:
        change = self.movable.scale * (q - first)
        return aim.value(self.place(q)) + 0.5 * aim.weight * float(change @ change)

    def _ended(self, local: Local, settled: bool) -> None:
        pressing = local.near[local.factors > SLIGHT * max(float(np.linalg.norm(local.slope)), 1e-300)]
        freedom, reach = local.free.shape[1], self._reach(local)
        self.end = End(freedom, reach, self._most, tuple(int(n) for n in pressing), settled)

    def _reach(self, local: Local) -> float:
        """Largest share of the point in a motion of all bodies that the joints leave, angles as arcs at the size."""
        if not local.free.shape[1]:
            return 0.0
        arcs = self.movable.scale.copy()
        arcs[2::3] /= self.movable.size
        ways = np.linalg.qr(local.free / arcs[:, None])[0]
        return _largest((local.jacobian * arcs) @ ways)


def _largest(lines: np.ndarray) -> float:
    """The largest singular value of lines (2, n)."""
    return math.sqrt(max(float(np.linalg.eigvalsh(lines @ lines.T)[1]), 0.0))
