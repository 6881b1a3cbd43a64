"""What of the search for closings belongs to the form of a mechanism: the tables that `equations.closings` reads.

Which bodies turn together, which joints lead where, which loops there are and through what they lead, which given
values may count as exact.  Numbers are read from the arrays of the system.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from rattle.analyses.assembly.outward import leaves_place, ways_outward
from rattle.analyses.assembly.tied_bodies import Tie, passed_ways, tied_ways
from rattle.description.model import GROUND, Joint, Model, frame_of
from rattle.equations import start_columns as of
from rattle.equations.closings import MOST_NODES
from rattle.equations.dense import LARGE
from rattle.equations.start_search import MOST_CLOSINGS
from rattle.equations.system import System
from rattle.jit import layout as at

MOST_JOINTS = 60  # up to which all short loops are looked for, not only independent ones
LONG = 3000  # rows above which no closings are looked for: lists of ways through long chains take the square of it
STARTS = 48  # guesses that are tried for angles that are not given
TURNS = (60.0, -60.0, 120.0, -120.0, 180.0, 30.0, -30.0)  # [deg]
WIDTH = 6  # of `start_map`

Neighbours = dict[str, list[tuple[Joint, str]]]
Steps = Sequence[tuple[Joint, str, str]]  # joint, from body, to body


class LoopMap(NamedTuple):
    """Arrays of the form of a start, and shapes of those that a search fills."""

    arrays: Mapping[str, np.ndarray]
    rooms: Mapping[str, tuple[int, ...]]


def loop_map(system: System) -> LoopMap:
    """The tables of a system, made once for all of its form."""
    return system.fact("loop map", lambda: _Writer(system).written())


class _Writer:
    """Writes the parts of `start_map`; bodies, joints and unknowns by their numbers."""

    def __init__(self, system: System) -> None:
        self.system, self.model = system, system.model
        self.number = {name: n for n, name in enumerate((GROUND, *system.bodies))}
        self.joint = {name: n for n, name in enumerate(self.model.joints)}
        joints = self.model.joints.values()
        rods = [joint.name for joint in joints if joint.line is None and joint.distance > 0.0]
        slides = [joint.name for joint in joints if joint.line is not None]
        self.unknown = {name: n for n, name in enumerate((*rods, *slides), len(self.number))}  # of joints
        self.angles, self.count = len(self.number) + len(rods), len(self.number) + len(rods) + len(slides)
        self.tied = tied_ways(self.model)
        self.group = {tie.to: tie.group for tie in self.tied}
        self.rows: list[list[list[int]]] = [[] for _ in range(of.PARTS)]  # of every part

    def written(self) -> LoopMap:
        """The tables and rooms."""
        rows, looped = self.rows, self.system.row_count <= LONG
        passed, free = passed_ways(self.model)
        rows[of.GROUPS] = [[self.number[self.group[name]]] for name in self.number]
        rows[of.TIED] = [self._tie(tie) for tie in self.tied if tie.origin]
        rows[of.PASSED] = [self._tie(tie) for tie in passed]
        rows[of.FREE] = [[self.number[name]] for name in free]
        rows[of.CAMS] = list(self._cams())
        rows[of.KNOWN] = list(self._driven_slides())
        if looped:
            self._find_loops()
        turns = _turns(len(free) if self.system.row_count <= LARGE else 0)
        form = np.zeros(9, np.int64)
        form[[of.SMALL, of.LOOPED, of.ANGLES]] = self.system.row_count <= LARGE, looped, self.angles
        arrays = {
            **self._map(), "start_ways": self._ways(), "start_moving": self._moving(), "start_turns": turns,
            "start_form": form,
        }  # fmt: skip
        return LoopMap(arrays, self._rooms())

    def _map(self) -> dict[str, np.ndarray]:
        """All parts, one after the other: rows that are named in others are counted from the first of all."""
        first = np.cumsum([0, *map(len, self.rows)])
        parts = [np.array(rows, np.int64) for rows in self.rows]
        table = np.zeros((first[-1], WIDTH), np.int64)
        for rows, start in zip(parts, first, strict=False):
            if len(rows):
                table[start : start + len(rows), : rows.shape[1]] = rows
        loops, terms = table[first[of.LOOPS] : first[of.VECTORS]], table[first[of.TERMS] : first[of.TERMS + 1]]
        wishes = table[first[of.WISHES] : first[of.WISHES + 1], of.WISH]
        loops += first[[of.VECTORS, of.VECTORS, of.SLIDES, of.SLIDES, 0, 0]]
        wishes[wishes >= 0] += first[of.LOOPS]
        slides = terms[:, of.INTO] < 0
        terms[slides, of.INTO] = len(self.rows[of.VECTORS]) - 1 - terms[slides, of.INTO]
        return {"start_map": table, "start_parts": first}

    def _rooms(self) -> dict[str, tuple[int, ...]]:
        """Shapes of what a search fills: of every two unknowns that are solved for there are two solutions."""
        rows, nq = self.rows, 3 * self.system.body_count
        vectors, slides, wishes = (len(rows[part]) for part in (of.VECTORS, of.SLIDES, of.WISHES))
        unknowns = len({row[of.GROUP] for row in rows[of.VECTORS]} | {row[of.SLIDE] for row in rows[of.SLIDES]})
        depth = unknowns + wishes + 2
        nodes = min(2 * MOST_NODES + 1, depth * 2 ** min(unknowns // 2, 12) + 1) + 2  # with room for two more
        return {
            "start_bodies": (4, len(self.number)), "start_spans": (vectors + slides, 2),
            "start_unknown": (self.count,), "start_wishes": (3, depth), "start_nodes": (nodes, 5),
            "start_steps": (nodes, 5), "start_heap": (nodes,), "start_search": (11,),
            "start_found": (of.FIRST_SEEN + (MOST_CLOSINGS if vectors else 0), nq),
            "start_judged": (of.OF_LATER + of.LOOKED,), "start_scratch": (3, nq),
        }  # fmt: skip

    # ---------------------------------------------------------------- bodies
    def _tie(self, tie: Tie) -> list[int]:
        """A row of TIED or PASSED."""
        slot = self.system.driver_slot(tie.driver) if tie.driver else -1
        joint = self.joint[tie.joint] if tie.joint else 0
        return [self.number[tie.to], self.number[tie.origin], joint, slot, tie.sign]

    def _moving(self) -> np.ndarray:
        """`start_moving`."""
        points = [name for name in self.number if name != frame_of(name)]
        slots = {name: [self.system.driver_slot(f"{name}.{key}") for key in "xy"] for name in points}
        return np.array([[self.number[name], *slots[name]] for name in points], np.int64).reshape(-1, 3)

    def _ways(self) -> np.ndarray:
        """`start_ways`."""
        inland = {body for body, _, _ in ways_outward(self.system)}
        first, rows = self.system.arrays["joint"][:, at.FIRST_P].tolist(), []
        for body, parent, joint in ways_outward(self.system, islands=True):
            ends, n = (joint.a.body, joint.b.body), self.joint[joint.name]
            freedom = (
                of.FIXED if not leaves_place(joint) else of.ALONG_LINE if joint.line is not None else of.ABOUT_POINT
            )
            rows.append(
                [
                    *(self.number[name] for name in (body, parent, *ends)), first[n], n, freedom,
                    self.unknown.get(joint.name, -1), int(body not in inland),
                ]
            )  # fmt: skip
        return np.array(rows, np.int64).reshape(-1, 9)

    def _cams(self) -> Iterator[list[int]]:
        """Bodies that slide, and cams that they follow, if these are placed before."""
        joints, placed = self.model.joints.values(), {GROUND}
        for n, (body, parent, via) in enumerate(ways_outward(self.system, islands=True)):
            placed.add(parent)
            for joint in joints if via.line is not None else ():
                own = 2 if joint.b.body == body and joint.a.body != body else 0
                other = joint.a.body if own else joint.b.body
                if joint.places or joint.distance <= 0.0 or other not in placed:
                    continue
                if body in (joint.a.body, joint.b.body):
                    p = self.system.first_value(joint.name)
                    yield [n, self.number[other], p + own, p + 2 - own, self.joint[joint.name]]
            placed.add(body)

    def _driven_slides(self) -> Iterator[list[int]]:
        """Slides that drivers determine, and where their values are."""
        for name, driver in self.model.drivers.items():
            if driver.joint and not driver.sets_angle and self.model.joints[driver.joint].line is not None:
                yield [self.unknown[driver.joint], self.system.driver_slot(name)]

    # ---------------------------------------------------------------- loops
    def _find_loops(self) -> None:
        """Enter all loops, and given values that may count as exact: angles, then loops through given places."""
        near, wishes = _neighbours(self.model), self.rows[of.WISHES]
        ways: Mapping[str, Steps] = _trees(near, GROUND)
        for steps in _cycles(self.model, near):
            self._chain(of.LOOPS, steps, -1, {})
        for name, driver in self.model.drivers.items():
            if driver.point is not None and driver.kind in ("body-x", "body-y") and not driver.moves_ground:
                place = {"xy".index(driver.kind[-1]): (of.DRIVEN, self.system.driver_slot(name))}
                if driver.point.body in ways:
                    self._chain(of.LOOPS, ways[driver.point.body], self.system.first_value(name) + 2, place)
        exact, initial = {self.group[GROUND]}, self.model.initial.bodies
        for body, values in initial.items():
            if "angle" in values and self.group[body] not in exact:
                exact.add(self.group[body])
                wishes.append([-1, self.number[body]])
        for body, values in initial.items():
            first = 3 * (self.number[body] - 1)
            place = {axis: (of.GIVEN, first + axis) for axis, key in enumerate("xy") if key in values}
            if place and body in ways:
                wishes.append([len(self.rows[of.LOOPS]) + len(self.rows[of.WISH_LOOPS]), 0])
                self._chain(of.WISH_LOOPS, ways[body], -1, place)

    def _chain(self, part: int, steps: Steps, last: int, place: Mapping[int, tuple[int, int]]) -> None:
        """Enter the loop of vectors over joints, from the origin of the first body to a point of the last.

        last: of the point in `values`, -1: the mass centre.  place: of the loops through a point whose x, y or both [m]
        are known, kind of term and value of each coordinate; what is not known of the two is a slide.
        """
        rows = self.rows
        vectors, slides, terms = rows[of.VECTORS], rows[of.SLIDES], rows[of.TERMS]
        begun = len(vectors), len(slides)

        def into(number: int) -> int:
            """Row of a group or rod in this loop."""
            if [number] not in vectors[begun[0] :]:
                vectors.append([number])
            return begun[0] + vectors[begun[0] :].index([number])

        def slide(number: int, turns: int) -> int:
            """Row of a slide, counted backwards from -1."""
            into(turns)
            slides.append([number, turns])
            return -len(slides)

        def point(body: str, plus: int, minus: int) -> None:
            terms.append([into(self.number[self.group[body]]), of.POINT, self.number[body], plus, minus, 1])

        for axis in (0, 1) if place else ():
            if axis in place:
                kind, value = place[axis]
                terms.append([into(0), kind, 0, value, axis, 1])
            else:
                terms.append([slide(self.count, 0), of.AXIS, 0, axis, 0, 1])
                self.count += 1

        def between(begin: str, here: int, end: str, own: int) -> None:
            """From a point of one body to one of another, which is the same or, as it, the ground."""
            if begin == end:
                point(end, own, here)
                return
            point(begin, -1, here)
            point(end, own, -1)
            for body, sense in ((begin, 1), (end, -1)):
                for axis, key in enumerate("xy") if body != frame_of(body) else ():
                    terms.append([into(0), of.DRIVEN, 0, self.system.driver_slot(f"{body}.{key}"), axis, sense])

        here, arrived = -1, steps[0][1]
        for joint, body, _ in steps:
            p, number = self.system.first_value(joint.name), self.joint[joint.name]
            forth = frame_of(joint.a.body) == body
            own, far, sign = (p, p + 2, 1) if forth else (p + 2, p, -1)
            near, beyond = (joint.a, joint.b) if forth else (joint.b, joint.a)
            between(arrived, here, near.body, own)
            arrived = beyond.body
            if joint.line is not None:
                row = slide(self.unknown[joint.name], self.number[self.group[joint.a.body]])
                terms.append([row, of.LINE, self.number[joint.a.body], number, 0, sign])
            elif joint.distance > 0.0:
                terms.append([into(self.unknown[joint.name]), of.ROD, 0, number, 0, sign])
            here = far
        between(arrived, here, steps[-1][2], last)
        rows[part].append([begun[0], len(vectors), begun[1], len(slides)])


def _turns(free: int) -> np.ndarray:
    """(n, free) angles [rad] that are tried for bodies whose angle is not given."""
    if not free:
        return np.zeros((0, 0))
    turns = [math.radians(x) for x in TURNS]
    if len(turns) ** free > STARTS:
        random = np.random.default_rng(0)
        return np.array([random.uniform(-math.pi, math.pi, free) for _ in range(STARTS)])
    return np.array(list(itertools.product(turns, repeat=free)))


def _neighbours(model: Model) -> Neighbours:
    """Joints that say where points are, by body, with the body on the other side."""
    near: Neighbours = {}
    for joint in model.joints.values():
        if _ties(joint):
            a, b = frame_of(joint.a.body), frame_of(joint.b.body)
            near.setdefault(a, []).append((joint, b))
            near.setdefault(b, []).append((joint, a))
    return near


def _ties(joint: Joint) -> bool:
    """True if the joint says where the point of B is, apart from a slide along a line or about a point."""
    return joint.places and not joint.leaf.bodies and not joint.passing


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
    roots = [GROUND, *model.moving_bodies] if len(model.joints) <= MOST_JOINTS else [GROUND]
    every: dict[frozenset[str], list[tuple[Joint, str, str]]] = {}
    for root in roots:
        ways = _trees(near, root)
        for joint in model.joints.values():
            a, b = frame_of(joint.a.body), frame_of(joint.b.body)
            if a not in ways or b not in ways or not (joint.places and not joint.leaf.bodies):
                continue
            out, home = ways[a], ways[b]
            passed = [step.name for step, _, _ in (*out, *home)]
            stations = [body for _, _, body in (*out, *home)]
            if joint.name in passed or len(set(stations)) < len(stations):
                continue
            back = [(step, end, begin) for step, begin, end in reversed(home)]
            every.setdefault(frozenset((*passed, joint.name)), [*out, (joint, a, b), *back])
    return sorted(every.values(), key=len)
