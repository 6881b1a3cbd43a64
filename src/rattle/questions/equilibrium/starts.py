"""Starts of the search for equilibria: along the free motion, with bodies turned, with pins on either side.

A body that is turned carries the bodies outwards of it along, so that only loops remain to be closed.
Positions q are (3 nb,) x, y, angle of every body [m, m, rad].
"""

from __future__ import annotations

import cmath
import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from rattle.analyses.assembly.outward import outward
from rattle.description.model import driven_ends, is_ground, on_ground
from rattle.equations.system import System
from rattle.questions.equilibrium.balance import StaticProblem
from rattle.questions.equilibrium.position import Equilibrium

MOST_STRIDES = 160  # steps along a degree of freedom whose motion does not close, at most
STRIDES = 12  # steps along one of several degrees of freedom, in either direction
DIRECTIONS = 4  # degrees of freedom along which starts are made, at most
NO_FORCE = 1e-9  # [-] share of the typical or largest force below which there is none: rounding may give it any sign
SINGLE = 1e-9  # [of the mechanism's size] supports that lie nearer to each other give no line
SAME = (1e-5, 1e-10)  # [of the smallest length, of the mechanism's size] distance of positions that are one: both are
# far above where the search ends and far below what tells two sides of a pin apart
UNLOADED = 1e-12  # [-] share of the largest reaction (at least of 1 N) below which a reaction has no direction
FAR = 0.3  # shift of sliding or free bodies, as a share of the mechanism's size


class Turning:
    """Bodies that can turn, in groups that can only turn together, and the tree by which they carry each other."""

    def __init__(self, system: System) -> None:
        model, self.system = system.model, system
        self.edges: list[tuple[int, int, complex, complex, float]] = []  # body, parent, points, axis of a guide or nan
        hung = set()
        for body, parent, joint in outward(model):
            mine, other = (joint.a, joint.b) if joint.a.body == body else (joint.b, joint.a)
            axis = joint.line if joint.line is not None else math.nan
            child, bearer = system.bodies.index(body), -1 if parent == "ground" else system.bodies.index(parent)
            self.edges.append((child, bearer, complex(*mine.at), complex(*other.at), axis))
            hung.add(child)
        self.loose = [k for k in range(system.body_count) if k not in hung]  # not connected by joints
        self.groups = _groups(system)
        self._level = _level(system)

    def placed(self, q: np.ndarray, turn: np.ndarray, slide: np.ndarray | None = None) -> np.ndarray:
        """A position q (3 nb,) with its bodies turned by `turn` (nb,) [rad] and shifted to stay connected.

        slide: (edges,) displacement along every guide [m].
        """
        at = q[0::3] + 1j * q[1::3]
        before, after = np.exp(1j * q[2::3]), np.exp(1j * (q[2::3] + turn))
        new = at.copy()
        for n, (body, parent, point, base, axis) in enumerate(self.edges):
            ends = at[body] + before[body] * point
            if parent < 0:
                placed, offset = base, ends - base
            else:
                placed = new[parent] + after[parent] * base
                offset = (ends - at[parent] - before[parent] * base) * cmath.exp(1j * turn[parent])
            if slide is not None and axis == axis:
                offset += slide[n] * cmath.exp(1j * axis) * (after[parent] if parent >= 0 else 1.0)
            new[body] = placed + offset - after[body] * point
        moved = q.copy()
        moved[0::3], moved[1::3], moved[2::3] = new.real, new.imag, q[2::3] + turn
        return moved

    def turned(self, q: np.ndarray, groups: Iterable[Sequence[int]], near: np.ndarray) -> np.ndarray:
        """A position q [m, m, rad] with some groups of bodies turned over, towards `near`; others keep their angles."""
        turn = np.zeros(self.system.body_count)
        for group in groups:
            k = 3 * group[0] + 2
            turn[group] = -math.pi if q[k] > near[k] else math.pi
        return self.placed(q, turn)

    def mirrored(self, q: np.ndarray, near: np.ndarray) -> np.ndarray:
        """A position q [m, m, rad] mirrored on the line through the two supports that are farthest apart.

        A hanging chain becomes an arch; a single body is inverted.
        """
        turn = np.zeros(self.system.body_count)
        for group in self.groups:
            k = 3 * group[0] + 2
            turn[group] = near[k] + math.remainder(2.0 * self._level - q[k] - near[k], 2 * math.pi) - q[k]
        return self.placed(q, turn)

    def unwound(self, q: np.ndarray, near: np.ndarray) -> np.ndarray:
        """The position q [m, m, rad] with whole turns of bodies removed, as far as they exceed those of `near`."""
        same = q.copy()
        for group in self.groups:
            k = 3 * group[0] + 2
            same[[3 * body + 2 for body in group]] -= 2 * math.pi * round((q[k] - near[k]) / (2 * math.pi))
        return same

    def anywhere(self, q: np.ndarray, random: np.random.Generator) -> np.ndarray:
        """A position [m, m, rad] with random angles of bodies that can turn; those that slide or are free are moved."""
        turn = np.zeros(self.system.body_count)
        for group in self.groups:
            turn[group] = random.uniform(-math.pi, math.pi)
        far = FAR * self.system.size
        moved = self.placed(q, turn, random.normal(size=len(self.edges)) * far)
        for k in self.loose:
            moved[3 * k : 3 * k + 2] += random.normal(size=2) * far
        return moved

    def nearby(self, q: np.ndarray, random: np.random.Generator) -> np.ndarray:
        """A position q [m, m, rad] with one or two groups of bodies at random angles."""
        turn = np.zeros(self.system.body_count)
        for n in random.permutation(len(self.groups))[: random.integers(1, 3)]:
            turn[self.groups[n]] = random.uniform(-math.pi, math.pi)
        return self.placed(q, turn)


def _level(system: System) -> float:
    """Angle [rad] of the line through the two supports that are farthest apart; with a single one, across gravity."""
    ground = system.model.ground
    ends = [end for joint in system.model.joints.values() for end in (joint.a, joint.b) if is_ground(end.body)]
    supports = [complex(*on_ground(ground, end)) for end in ends]
    line = max((b - a for a, b in itertools.combinations(supports, 2)), key=abs, default=0j)
    if abs(line) < SINGLE * system.size:
        line = 1j * complex(*system.arrays["gravity"])
    return cmath.phase(line) if line else 0.0


def _groups(system: System) -> list[list[int]]:
    """Groups of bodies whose angles are fixed to each other, without those whose angle is fixed to the ground."""
    model = system.model
    group = {name: name for name in ["ground", *system.bodies]}

    def leader(name: str) -> str:
        while group[name] != name:
            name = group[name]
        return name

    ties = [(joint.a.body, joint.b.body) for joint in model.joints.values() if joint.kept_angle is not None]
    for driver in model.drivers.values():
        if driver.sets_angle:
            a, b, _ = driven_ends(model, driver)
            ties.append((a.body, b.body))
    for first, other in ties:
        group[leader(other)] = leader(first)
    members: dict[str, list[int]] = {}
    for k, name in enumerate(system.bodies):
        if leader(name) != leader("ground"):
            members.setdefault(leader(name), []).append(k)
    return list(members.values())


# ---------------------------------------------------------------- along degrees of freedom
def along(problem: StaticProblem, start: np.ndarray) -> Iterator[np.ndarray]:
    """Positions (3 nb,) [m, m, rad] along some of the degrees of freedom at the start, in either direction."""
    _, null = problem.reduce(start)
    for direction in [sign * null[:, k] for k in range(min(null.shape[1], DIRECTIONS)) for sign in (1.0, -1.0)]:
        q = start.copy()
        for _ in range(STRIDES):
            if not problem.walk(q, direction, 0.25 * problem.system.size)[0]:
                break
            yield q.copy()


def around(problem: StaticProblem, start: np.ndarray, direction: np.ndarray) -> list[np.ndarray]:
    """Positions (3 nb,) [m, m, rad] along the one free motion next to which the force changes sign or is least.

    direction: (3 nb,).  The motion is followed all around if it closes, otherwise to both ends.
    """
    stride = problem.system.size / 8
    path, force = [start], [float(problem.reduce(start)[0][0])]
    for sign in (1.0, -1.0):
        q, ahead, closed = start.copy(), sign * direction, False
        for n in range(MOST_STRIDES):
            went, strength, _ = problem.walk(q, ahead, stride)
            if not went:
                break
            path.insert(len(path) if sign > 0 else 0, q.copy())
            force.insert(len(force) if sign > 0 else 0, sign * strength)
            closed = n > 2 and apart(problem.system, q, start[None])[0] < stride
            if closed:
                break
        if closed:
            break
    nothing = NO_FORCE * max(problem.force_scale(), max(map(abs, force)))
    return [path[k] for k in _turning_points(force, nothing)]


def _turning_points(force: Sequence[float], nothing: float) -> list[int]:
    """Places along a path next to which the force changes sign or is least; nothing: what is no force [N]."""
    size = [abs(value) if abs(value) > nothing else math.inf for value in force]  # without force it may be anywhere
    places = []
    for k in range(1, len(size)):
        if size[k - 1] < math.inf and size[k] < math.inf and force[k - 1] * force[k] < 0.0:
            places += [k - 1, k]
    for k in range(1, len(size) - 1):  # without a change of sign: two equilibria may lie close together
        if size[k] < min(size[k - 1], size[k + 1]) and force[k - 1] * force[k + 1] > 0.0:
            places.append(k)
    return places


def apart(system: System, position: np.ndarray, others: np.ndarray) -> np.ndarray:
    """(k,) largest distance [m] of a position from others (k, 3 nb); angles times the size of the mechanism."""
    distance = position - others
    distance[:, 2::3] = (distance[:, 2::3] + math.pi) % (2 * math.pi) - math.pi
    distance[:, 2::3] *= system.size
    return np.asarray(np.abs(distance).max(axis=1))


# ---------------------------------------------------------------- pins
def tiny(system: System) -> float:
    """The smallest length of the mechanism [m], against which positions are compared."""
    return min([system.size] + [joint.clearance for joint in system.model.joints.values() if joint.clearance > 0])


def same(system: System, position: np.ndarray, others: np.ndarray) -> bool:
    """True if a position (3 nb,) is one of the others (k, 3 nb)."""
    if not len(others):
        return False
    return bool(apart(system, position, others).min() < SAME[0] * tiny(system) + SAME[1] * system.size)


def opened(ideal: StaticProblem, q: np.ndarray, wanted: Mapping[str, np.ndarray]) -> np.ndarray:
    """The ideal mechanism's position q after the least change that displaces its pins by `wanted` (2,) [m]."""
    system = ideal.system
    target = np.zeros(system.row_count)
    for name, offset in wanted.items():
        first = system.first_row(name)
        target[first : first + 2] = offset
    q = q.copy()
    ideal.displace(q, target)
    return q


def sides(ideal: StaticProblem, play: StaticProblem, equilibria: Sequence[Equilibrium]) -> Iterator[np.ndarray]:
    """Starts [m, m, rad] with every pin on either side of its bush along the ideal reaction: first all pressing."""
    pressed = []
    for rest in equilibria:
        directions = np.zeros((len(play.links), 2))
        tiny = UNLOADED * max(1.0, np.abs(rest.multiplier).max(initial=0.0))
        for n, name in enumerate(play.links):
            force = np.array([rest[f"{name}.fx"], rest[f"{name}.fy"]])
            size = float(np.hypot(*force))
            direction = -force / size if size > tiny else np.array([1.0, 0.0])
            directions[n] = play.system.model.joints[name].clearance * direction
        pressed.append(directions)
    count = len(play.links)
    for pulling in range(count + 1):
        for rest, directions in zip(equilibria, pressed, strict=True):
            for chosen in itertools.combinations(range(count), pulling):
                signs = [-1.0 if n in chosen else 1.0 for n in range(count)]
                yield opened(ideal, rest.q, dict(zip(play.links, np.array(signs)[:, None] * directions, strict=True)))
