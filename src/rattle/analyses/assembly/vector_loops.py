"""All ways in which the loops of a mechanism close, in closed form where two unknowns are left in a loop.

Around a loop, in complex numbers,

    sum_k exp(i theta_k) (d_k + sum_j s_j u_j) = 0

theta_k is the angle of bodies that turn together, d_k what they span in the loop, s_j how far a block or a pin has slid
along u_j on them; a rod spans its length at an angle of its own.  Known parts add up to c.  What two unknowns can be:

    two angles                       a triangle with the sides |d_1|, |d_2|, |c|
    an angle, a slide s              |c + s u| = |d|, or |d + s u| = |c| where the slide turns with the angle
    two slides                       linear

so that there are at most two solutions.  Where every loop has more unknowns, a given value counts as exact, every one
in its turn; all of them are wishes otherwise: those closings come first that change them least.
"""

from __future__ import annotations

import cmath
import heapq
import itertools
import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from rattle.analyses.assembly.first_guess import driver_functions, ways_outward
from rattle.analyses.assembly.start_values import given_values
from rattle.description.model import Joint, Model, driven_ends
from rattle.equations.system import System
from rattle.jit.workspace import Workspace

MOST_JOINTS = 60  # up to which all short loops are looked for, not only independent ones
MOST_CLOSINGS = 64  # of all choices of given values that count as exact; LEAST of each
LEAST_CLOSINGS = 4
MOST_TURNS = 16  # choices of given values
MOST_NODES = 3000  # parts of loops that are solved for one of them: a value at the end of ten four-bars decides late
TINY = 1e-12  # share of the mechanism's size that spans nothing
GROUND = "ground"
ROD = "rod "  # before the name of a rod, which turns by itself

Neighbours = dict[str, list[tuple[Joint, str]]]


class Slide(NamedTuple):
    """A part of a loop along which a block or a pin slides."""

    name: str  # of the joint, or of a coordinate of a body
    turns: str  # group whose angle it has
    unit: complex  # its direction at the group's angle 0


class Loop(NamedTuple):
    """A closed chain of vectors."""

    spans: dict[str, complex]  # by group of bodies that turn together, at its angle 0 [m]
    slides: tuple[Slide, ...]


class Found(NamedTuple):
    """What is known of a closing."""

    angles: dict[str, float]  # of groups [rad]
    slides: dict[str, float]  # [m]


class Node(NamedTuple):
    """A closing in the making; of two of them the one that changes given values less goes first."""

    change: float  # of given angles [rad^2], and of lengths that do not reach, in sizes of the mechanism squared
    open: int  # loops that are left: of nodes alike the deepest goes first
    away: float  # angles from where they are looked for [rad^2]
    number: int
    found: Found
    loops: tuple[Loop, ...]
    wishes: tuple[str | Loop, ...]  # groups and loops through given coordinates that do not count yet


class VectorLoops:
    """The closings of a mechanism without play; functions: value of every driver's function [rad or m]."""

    def __init__(self, system: System, functions: Mapping[str, float]) -> None:
        self.system, self.model = system, system.model
        self.complete = True  # False once a value that nobody gave was needed: there may be other closings
        self._groups = _groups(self.model, functions)
        group, ahead = self._groups[GROUND]
        self._known = Found({group: -ahead}, _driven_slides(self.model, functions))
        self._given: dict[str, float] = {}  # angles of groups [rad]
        self._near = self._angles_near_by()
        places: dict[str, dict[str, float]] = {}
        for body, values in self.model.initial.bodies.items():
            group, ahead = self._groups[body]
            if "angle" in values and group not in self._known.angles:
                self._given.setdefault(group, values["angle"] - ahead)
            places[body] = {key: values[key] for key in ("x", "y") if key in values}
        near = _neighbours(self.model)
        self._near |= self._given
        self._loops = [self._around(steps) for steps in _cycles(self.model, near)]
        for driver in self.model.drivers.values():
            if driver.point is not None and driver.kind in ("body-x", "body-y"):
                at = {driver.kind[-1]: functions[driver.name]}
                self._loops += self._through(near, driver.point.body, complex(*driver.point.at), at)
        self._wishes: list[str | Loop] = [*self._given]
        for body, at in places.items():
            self._wishes += self._through(near, body, 0.0j, at) if at else []

    def __iter__(self) -> Iterator[np.ndarray]:
        """Positions (3 nb,) [m, m, rad] of closings: those first that change given values least."""
        if not self._loops and not self._wishes:
            return
        seen: list[np.ndarray] = []
        turns = min(max(1, len(self._wishes)), MOST_TURNS)
        for turn in range(turns):
            wishes = (*self._wishes[turn:], *self._wishes[:turn])
            for found in itertools.islice(self._closings(wishes), max(LEAST_CLOSINGS, MOST_CLOSINGS // turns)):
                q = self._placed(found)
                if all(np.abs(q - other).max() > 1e-9 * self.system.size for other in seen):
                    seen.append(q)
                    yield q

    def _angles_near_by(self) -> dict[str, float]:
        """Angles [rad] of groups in a start near by."""
        angles: dict[str, float] = {}
        for body, (_, _, angle) in self.model.initial.near.items():
            if body in self._groups:
                group, ahead = self._groups[body]
                angles.setdefault(group, angle - ahead)
        return angles

    # ---------------------------------------------------------------- loops
    def _around(self, steps: list[tuple[Joint, str, str]]) -> Loop:
        """The loop of (joint, from body, to body) that ends where it begins."""
        return self._chain(steps, 0.0j, 0.0j, {}, ())

    def _through(self, near: Neighbours, body: str, at: complex, place: Mapping[str, float]) -> list[Loop]:
        """The loop from the ground to a point of a body of which x, y or both [m] are known; [] if nothing leads there.

        What is not known of the two is a slide.
        """
        steps = _trees(near, GROUND).get(body)
        if steps is None:
            return []
        group, ahead = self._groups[GROUND]
        back = cmath.exp(1j * ahead)
        spans = {group: -complex(place.get("x", 0.0), place.get("y", 0.0)) * back}
        missing = {"x": -1.0 + 0.0j, "y": -1.0j}
        slides = tuple(Slide(f"{body}.{key}", group, unit * back) for key, unit in missing.items() if key not in place)
        return [self._chain(steps, 0.0j, at, spans, slides)]

    def _chain(
        self, steps: list[tuple[Joint, str, str]], first: complex, last: complex, spans: dict[str, complex],
        slides: tuple[Slide, ...],
    ) -> Loop:  # fmt: skip
        """The sum over (joint, from body, to body), from a point of the first body to one of the last; added to."""

        def span(body: str, local: complex) -> None:
            group, ahead = self._groups[body]
            spans[group] = spans.get(group, 0.0j) + cmath.exp(1j * ahead) * local

        here = first
        for joint, body, _ in steps:
            own, far, sign = (joint.a, joint.b, 1.0) if joint.a.body == body else (joint.b, joint.a, -1.0)
            span(body, complex(*own.at) - here)
            if joint.line is not None:
                group, ahead = self._groups[joint.a.body]
                slides = (*slides, Slide(joint.name, group, sign * cmath.exp(1j * (ahead + joint.line))))
                spans.setdefault(group, 0.0j)
            elif joint.distance > 0.0:
                rod = ROD + joint.name
                spans[rod] = spans.get(rod, 0.0j) + sign * joint.distance
            here = complex(*far.at)
        span(steps[-1][2], last - here)
        return Loop(spans, slides)

    # ---------------------------------------------------------------- closings
    def _closings(self, wishes: tuple[str | Loop, ...]) -> Iterator[Found]:
        """Angles and slides with which all loops close; wishes: given values in the order in which they count."""
        number = itertools.count()
        heap = [Node(0.0, len(self._loops), 0.0, next(number), self._known, tuple(self._loops), wishes)]
        for _ in range(MOST_NODES):
            if not heap:
                return
            node = heapq.heappop(heap)
            open_ = {n: len(self._unknown(one, node.found)) for n, one in enumerate(node.loops)}
            node = node._replace(loops=tuple(one for n, one in enumerate(node.loops) if open_[n]))
            left = [count for count in open_.values() if count]
            loop = node.loops[left.index(min(left))] if left else None
            if loop is not None and min(left) <= 2:
                others = tuple(one for one in node.loops if one is not loop)
                for solution, short in self._solved(loop, node.found):
                    change, away = self._judged(solution)
                    found = Found({**node.found.angles, **solution.angles}, {**node.found.slides, **solution.slides})
                    heapq.heappush(
                        heap,
                        Node(
                            round(node.change + change + short, 14),
                            len(others), node.away + away, next(number), found, others,
                            node.wishes,
                        ),
                    )  # fmt: skip
            elif loop is not None or node.wishes:
                heapq.heappush(heap, self._with_a_wish(node, loop)._replace(number=next(number)))
            else:
                yield node.found

    def _with_a_wish(self, node: Node, loop: Loop | None) -> Node:
        """With the next of the given values that says something, or else with an angle or a slide of 0 in the loop."""
        for n, wish in enumerate(node.wishes):
            rest = (*node.wishes[:n], *node.wishes[n + 1 :])
            if isinstance(wish, Loop):
                if len(self._unknown(wish, node.found)) <= 2:
                    return node._replace(loops=(*node.loops, wish), wishes=rest)
            elif wish not in node.found.angles:
                angles = {**node.found.angles, wish: self._given[wish]}
                return node._replace(found=node.found._replace(angles=angles), wishes=rest)
        if loop is None:
            return node._replace(wishes=())
        self.complete = False
        unknown = self._unknown(loop, node.found)[0]
        if isinstance(unknown, Slide):
            return node._replace(found=node.found._replace(slides={**node.found.slides, unknown.name: 0.0}))
        angles = {**node.found.angles, unknown: self._near.get(unknown, 0.0)}
        return node._replace(found=node.found._replace(angles=angles))

    def _judged(self, solution: Found) -> tuple[float, float]:
        """How far angles are from the given ones, and from where they are looked for [rad^2]."""
        change = away = 0.0
        for group, angle in solution.angles.items():
            miss = math.remainder(angle - self._near.get(group, 0.0), math.tau) ** 2
            away += miss
            change += miss if group in self._given else 0.0
        return change, away

    def _unknown(self, loop: Loop, found: Found) -> list[str | Slide]:
        """Groups and slides that the loop may determine."""
        slides = [one for one in loop.slides if one.name not in found.slides]
        sliding = {one.turns for one in slides}
        groups = [
            group
            for group in loop.spans
            if group not in found.angles
            and (group in sliding or abs(self._span(loop, group, found)) > TINY * self.system.size)
        ]
        return [*groups, *slides]

    def _span(self, loop: Loop, group: str, found: Found) -> complex:
        """What a group spans at its angle 0, with slides that are known [m]."""
        return loop.spans[group] + sum(
            found.slides[one.name] * one.unit for one in loop.slides if one.turns == group and one.name in found.slides
        )

    def _solved(self, loop: Loop, found: Found) -> list[tuple[Found, float]]:
        """Values of at most two unknowns with which the loop closes, and by how much lengths are too short.

        The latter in sizes of the mechanism, squared.
        """
        unknown = self._unknown(loop, found)
        groups = [one for one in unknown if isinstance(one, str)]
        slides = [one for one in unknown if isinstance(one, Slide)]
        c = sum(
            (cmath.exp(1j * angle) * self._span(loop, group, found) for group, angle in found.angles.items()
             if group in loop.spans), 0.0j,
        )  # fmt: skip
        d = [self._span(loop, group, found) for group in groups]
        if len(groups) == 2:
            pairs, short = _triangle(d[0], d[1], c)
            made = [Found(dict(zip(groups, pair, strict=True)), {}) for pair in pairs]
        elif len(groups) == 1 and not slides:
            made, short = [Found({groups[0]: cmath.phase(-c / d[0])}, {})], 0.0
        elif len(groups) == 1 and slides[0].turns == groups[0]:
            ways, short = _onto_circle(d[0], slides[0].unit, abs(c))
            made = [
                Found({groups[0]: cmath.phase(-c / arm) if arm else 0.0}, {slides[0].name: s})
                for s in ways
                for arm in (d[0] + s * slides[0].unit,)
            ]
        elif len(groups) == 1:
            u = slides[0].unit * cmath.exp(1j * found.angles[slides[0].turns])
            ways, short = _onto_circle(c, u, abs(d[0]))
            made = [Found({groups[0]: cmath.phase(-(c + s * u) / d[0])}, {slides[0].name: s}) for s in ways]
        else:
            units = [one.unit * cmath.exp(1j * found.angles[one.turns]) for one in slides]
            matrix = np.array([[u.real for u in units], [u.imag for u in units]]).reshape(2, len(units))
            ways = np.linalg.lstsq(matrix, np.array([-c.real, -c.imag]), rcond=1e-12)[0].tolist()
            made, short = [Found({}, {one.name: s for one, s in zip(slides, ways, strict=True)})], 0.0
        return [(one, (short / self.system.size) ** 2) for one in made]

    # ---------------------------------------------------------------- positions
    def _placed(self, found: Found) -> np.ndarray:
        """Positions (3 nb,) [m, m, rad] of a closing, with the turns of given angles."""
        angles: dict[str, float] = {}
        for body, (group, ahead) in self._groups.items():
            near = self._near.get(group, 0.0)
            angle = found.angles.get(group, near)
            if group not in self._known.angles:
                angle += math.tau * round((near - angle) / math.tau)
            angles[body] = angle + ahead
        at: dict[str, complex] = {GROUND: 0.0j}
        for body, parent, joint in ways_outward(self.system, islands=True):
            if parent not in at:
                values = self.model.initial.bodies.get(parent, {})
                at[parent] = complex(values.get("x", 0.0), values.get("y", 0.0))
            sign = 1.0 if body == joint.b.body else -1.0
            own, other = (joint.b, joint.a) if body == joint.b.body else (joint.a, joint.b)
            gap = 0.0j
            if joint.line is not None:
                gap = found.slides.get(joint.name, 0.0) * cmath.exp(1j * (angles[joint.a.body] + joint.line))
            elif joint.distance > 0.0:
                gap = cmath.rect(joint.distance, found.angles.get(ROD + joint.name, -0.5 * math.pi))
            arm = cmath.exp(1j * angles[parent]) * complex(*other.at) - cmath.exp(1j * angles[body]) * complex(*own.at)
            at[body] = at[parent] + arm + sign * gap
        q = np.zeros(3 * self.system.body_count)
        for n, name in enumerate(self.system.bodies):
            values = self.model.initial.bodies.get(name, {})
            place = at.get(name, complex(values.get("x", 0.0), values.get("y", 0.0)))
            q[3 * n : 3 * n + 3] = place.real, place.imag, angles[name]
        return q


# ---------------------------------------------------------------- two unknowns
def _triangle(a: complex, b: complex, c: complex) -> tuple[list[tuple[float, float]], float]:
    """Angles of a and b [rad] with exp(i alpha) a + exp(i beta) b + c = 0, and by how much the sides are too short."""
    long, wide, across = abs(a), abs(b), abs(c)
    if across == 0.0 or long == 0.0 or wide == 0.0:
        return [], 0.0
    short = max(across - long - wide, long - across - wide, wide - across - long, 0.0)
    cosine = (long**2 + across**2 - wide**2) / (2.0 * long * across)
    bend = math.acos(min(1.0, max(-1.0, cosine)))
    pairs = []
    for turn in (bend, -bend) if bend not in (0.0, math.pi) else (bend,):
        first = cmath.rect(long, cmath.phase(-c) + turn)
        pairs.append((cmath.phase(first / a), cmath.phase((-c - first) / b) if first != -c else 0.0))
    return pairs, short


def _onto_circle(start: complex, u: complex, radius: float) -> tuple[list[float], float]:
    """Ways s [m] along the unit u with |start + s u| = radius [m], and by how much the radius is too short."""
    along, beside = -(start.real * u.real + start.imag * u.imag), abs(start.real * u.imag - start.imag * u.real)
    half = math.sqrt(max(0.0, (radius - beside) * (radius + beside)))
    return [along + half, along - half] if half else [along], max(0.0, beside - radius)


# ---------------------------------------------------------------- what turns together, what is driven, what is a loop
def groups_at(system: System, t: float, workspace: Workspace | None = None) -> dict[str, tuple[str, float]]:
    """Of every body, and of the ground, the group that turns with it at t [s], and how far it is ahead of it [rad].

    workspace: one in which the functions of drivers have been evaluated at t.
    """
    return _groups(system.model, driver_functions(system, t, workspace))


def given_in_one_turn(system: System, t: float, workspace: Workspace | None = None) -> np.ndarray:
    """(3 nb,) given positions [m, m, rad], nan if not given; angles of bodies that turn together are in one turn.

    It is that of the first of them, or that in which a driver holds them at t [s].  workspace: see `groups_at`.
    """
    given, groups = given_values(system, 0), groups_at(system, t, workspace)
    first, ahead = groups[GROUND]
    turns = {first: -ahead}
    for n, body in enumerate(system.bodies):
        angle = float(given[3 * n + 2])
        if math.isnan(angle):
            continue
        group, ahead = groups[body]
        kept = turns.setdefault(group, angle - ahead) + ahead
        given[3 * n + 2] += math.tau * round((kept - angle) / math.tau)
    return given


def _groups(model: Model, functions: Mapping[str, float]) -> dict[str, tuple[str, float]]:
    """Of every body, and of the ground, the group that turns with it, and how far it is ahead of its group [rad]."""
    tied = [(one.a.body, one.b.body, one.kept_angle) for one in model.joints.values() if one.kept_angle is not None]
    for name, driver in model.drivers.items():
        if driver.sets_angle:
            a, b, _ = driven_ends(model, driver)
            tied.append((a.body, b.body, functions[name]))
    near: dict[str, list[tuple[str, float]]] = {}
    for one, other, angle in tied:
        near.setdefault(one, []).append((other, angle))
        near.setdefault(other, []).append((one, -angle))
    groups: dict[str, tuple[str, float]] = {}
    for first in (GROUND, *model.bodies):
        if first in groups:
            continue
        groups[first], open_ = (first, 0.0), [first]
        while open_:
            body = open_.pop()
            for other, angle in near.get(body, ()):
                if other not in groups:
                    groups[other] = (first, groups[body][1] + angle)
                    open_.append(other)
    return groups


def _driven_slides(model: Model, functions: Mapping[str, float]) -> dict[str, float]:
    """Slides that drivers determine [m]."""
    return {
        driver.joint: functions[name]
        for name, driver in model.drivers.items()
        if driver.joint and not driver.sets_angle and model.joints[driver.joint].line is not None
    }


def _neighbours(model: Model) -> Neighbours:
    """Joints that say where points are, by body, with the body on the other side."""
    near: Neighbours = {}
    for joint in model.joints.values():
        if _ties(joint):
            near.setdefault(joint.a.body, []).append((joint, joint.b.body))
            near.setdefault(joint.b.body, []).append((joint, joint.a.body))
    return near


def _ties(joint: Joint) -> bool:
    """True if the joint says where the point of B is, apart from a slide along a line or about a point."""
    return joint.leaf.places and not joint.leaf.bodies and not joint.passing


def _trees(near: Neighbours, root: str) -> dict[str, list[tuple[Joint, str, str]]]:
    """The shortest ways (joint, from body, to body) from a body to all others."""
    ways: dict[str, list[tuple[Joint, str, str]]] = {root: []}
    queue = [root]
    for body in queue:
        for joint, other in near.get(body, ()):
            if other not in ways:
                ways[other] = [*ways[body], (joint, body, other)]
                queue.append(other)
    return ways


def _cycles(model: Model, near: Neighbours) -> list[list[tuple[Joint, str, str]]]:
    """Loops: for every body and every joint the way out to it and back, if nothing is passed twice; short ones first.

    The shortest independent loops are among them (Horton 1987).
    """
    roots = [GROUND, *model.bodies] if len(model.joints) <= MOST_JOINTS else [GROUND]
    every: dict[frozenset[str], list[tuple[Joint, str, str]]] = {}
    for root in roots:
        ways = _trees(near, root)
        for joint in model.joints.values():
            if (
                joint.a.body not in ways
                or joint.b.body not in ways
                or not (joint.leaf.places and not joint.leaf.bodies)
            ):
                continue
            out, home = ways[joint.a.body], ways[joint.b.body]
            passed = [one.name for one, _, _ in (*out, *home)]
            stations = [body for _, _, body in (*out, *home)]
            if joint.name in passed or len(set(stations)) < len(stations):
                continue
            back = [(one, end, begin) for one, begin, end in reversed(home)]
            every.setdefault(frozenset((*passed, joint.name)), [*out, (joint, joint.a.body, joint.b.body), *back])
    return sorted(every.values(), key=len)
