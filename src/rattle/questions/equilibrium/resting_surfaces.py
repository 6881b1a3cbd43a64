"""Equilibria of bodies that rest on surfaces which nothing can penetrate.

They are looked for with surfaces that give way a little.  Those contacts that carry are then held by joints, a point on
a line or two points at a distance, and the position is that of the held mechanism: exact, with N from its reactions.
A contact whose joint would have to pull is let go, one that is inside its surface is held too.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from rattle.analyses.load_forces import gravity_over, load_forces
from rattle.description.model import Choice, Contact, Joint, Point
from rattle.equations.closure import open_by
from rattle.equations.compliant import locate_contacts
from rattle.equations.contact_table import contact_groups, contact_labels
from rattle.equations.motion import place
from rattle.equations.placement import point_at, pose
from rattle.equations.system import System, compile_system
from rattle.interfaces.contacts import OneSidedKind
from rattle.jit import layout as at
from rattle.questions.equilibrium.balance import StaticProblem
from rattle.questions.equilibrium.position import Equilibrium

SOFT = 1e-3  # share of the mechanism's size by which surfaces give way to its whole weight while they are looked for
CARRIES = 1e-6  # share of the largest N above which a contact carries
INSIDE = 1e-9  # share of the mechanism's size that is inside
HELD_BY = "touch "  # name of the joint that stands for a contact, before the names of the surface and its number
MOST_NEAR = 6  # contacts that are held at first near a start
MOST_CHANGES = 12  # times that contacts are let go or held

Touching = Mapping[str, tuple[int, ...]]  # contacts of a surface that carry, counted within it


def rigid_surfaces(system: System) -> list[str]:
    """Names of the surfaces that nothing can penetrate."""
    joints = system.model.joints.items()
    return [name for name, joint in joints if joint.leaf.touches and joint.contact is not None and joint.contact.rigid]


def soft_surfaces(system: System, names: Iterable[str], t: float, q: np.ndarray) -> System:
    """The mechanism with rigid surfaces that give way, those with these names.

    t [s], q (3 nb,) [m, m, rad]: where its loads say how stiff they have to be.
    """
    weight = float(np.abs(system.arrays["mass"][1:, :1] * gravity_over(system, np.array([t]))[0]).sum())
    forces = load_forces(system, t, q, np.zeros_like(q)).values()
    push = sum(float(np.hypot(*force[1:, :2].T).max(initial=0.0)) for force in forces)
    static = Choice("power", {"stiffness": (weight + push or 1.0) / (SOFT * system.size), "exponent": 1.0})
    elastic, joints = Choice("tension", {"damping": 0.0}), dict(system.model.joints)
    for name in names:
        joints[name] = replace(joints[name], contact=Contact("compliant", normal=elastic, static=static))
    return compile_system(replace(system.model, joints=joints))


def held_system(soft: System, q: np.ndarray, touching: Touching, sticks: bool = False) -> System:
    """The mechanism in which joints hold what touches at q (3 nb,) [m, m, rad], and other surfaces are left out.

    sticks: contacts with friction stick or roll.
    """
    joints = {name: joint for name, joint in soft.model.joints.items() if name not in touching}
    for name, corners in touching.items():
        joint = soft.model.joints[name]
        rough = sticks and joint.contact is not None and joint.contact.mu > 0.0
        for number in corners:
            leaf, corner = _contact(joint, number)
            a, b = (pose(soft, q, end.body) for end in (joint.a, joint.b))
            for part, held in enumerate(leaf.held(joint.fields, joint.a.at, joint.corners, corner, a, b, rough)):
                on_a, on_b = Point(joint.a.body, "", held.on_a), Point(joint.b.body, "", held.on_b)
                first, second = (on_b, on_a) if held.turned else (on_a, on_b)
                key = f"{HELD_BY}{name} {number}" + (f" {part}" if part else "")
                joints[key] = _counted(soft, q, Joint(key, held.kind, first, second, held.fields))
    return compile_system(replace(soft.model, joints=joints))


def _counted(soft: System, q: np.ndarray, joint: Joint) -> Joint:
    """A joint whose rows that count from the start are zero at q (3 nb,)."""
    if not joint.from_start:
        return joint
    joint = replace(joint, constants=(0.0,) * joint.from_start)
    alone = compile_system(replace(soft.model, joints={joint.name: joint}, drivers={}, loads={}))
    workspace = alone.workspace()
    open_by(workspace, 0.0, q, np.zeros_like(q))
    return replace(joint, constants=tuple(float(value) for value in workspace.rows[-joint.from_start :, at.RES]))


def _contact(joint: Joint, number: int) -> tuple[type[OneSidedKind], int]:
    """Kind of a contact of a surface, and which of that kind it is."""
    for group in contact_groups(joint):
        if number < len(group.corners):
            assert issubclass(group.kind.leaf, OneSidedKind), "surfaces are one-sided"
            return group.kind.leaf, group.corners[number]
        number -= len(group.corners)
    raise AssertionError("a surface has no such contact")


class Surfaces:
    """The contacts of the rigid surfaces of a mechanism, that give way in `soft`."""

    def __init__(self, soft: System, names: list[str], t: float) -> None:
        self.soft, self.names, self.t = soft, names, t
        self.workspace = soft.workspace()
        owners = [name for name, _ in contact_labels(soft.model)]
        self.numbers = {name: [n for n, owner in enumerate(owners) if owner == name] for name in names}

    def near(self, q: np.ndarray) -> Iterator[Equilibrium]:
        """Equilibria near a position (3 nb,) in which the contacts that are nearest there carry, a few or all."""
        rows, rest = self._rows(q), StaticProblem(self.soft, self.t).finish(q, 0)
        contacts = [(name, k, n) for name, numbers in self.numbers.items() for k, n in enumerate(numbers)]
        contacts.sort(key=lambda contact: float(rows[contact[2], at.GAP]))
        for count in range(1, min(len(contacts), MOST_NEAR) + 1):
            nearest = contacts[:count]
            touching = {name: tuple(k for owner, k, _ in nearest if owner == name) for name in self.numbers}
            settled = self.settled(rest, touching)
            if settled is not None:
                yield settled

    def settled(self, rest: Equilibrium, touching: Touching | None = None) -> Equilibrium | None:
        """The equilibrium of rigid surfaces near one of surfaces that give way; None if there is none.

        touching: contacts that may carry, by default those that do.
        """
        q, touching = rest.q, self._carrying(rest.q) if touching is None else touching
        for _ in range(MOST_CHANGES):
            problem = StaticProblem(held_system(self.soft, q, touching), self.t)
            start = rest.q.copy()
            problem.close(start)
            solution = problem.find(start)
            if solution is None:
                return None
            exact = problem.finish(*solution)
            normals, rows = self._normals(exact, problem.system, touching), self._rows(exact.q)
            worst = min(normals, key=lambda contact: normals[contact], default=None)
            size = max(map(abs, normals.values()), default=0.0)
            if worst is not None and normals[worst] <= CARRIES * size:
                name, number = worst
                touching = {**touching, name: tuple(n for n in touching[name] if n != number)}
                continue
            if inside := self._inside(exact.q, touching):
                name, number = inside
                touching = {**touching, name: (*touching[name], number)}
                continue
            apart = max((abs(float(rows[self.numbers[name][k], at.GAP])) for name, k in normals), default=0.0)
            return self._shown(rest, exact, touching, normals) if apart <= INSIDE * self.soft.size else None
        return None

    def _rows(self, q: np.ndarray) -> np.ndarray:
        place(self.workspace, q, np.zeros_like(q))
        locate_contacts(self.workspace)
        rows: np.ndarray = self.workspace.contact_kinematics
        return rows

    def _carrying(self, q: np.ndarray) -> dict[str, tuple[int, ...]]:
        """Contacts that are inside their surfaces at q (3 nb,)."""
        rows = self._rows(q)
        deepest = max((-rows[n, at.GAP] for numbers in self.numbers.values() for n in numbers), default=0.0)
        least = CARRIES * max(deepest, 0.0)
        return {
            name: tuple(k for k, n in enumerate(numbers) if -rows[n, at.GAP] > least)
            for name, numbers in self.numbers.items()
        }

    def _inside(self, q: np.ndarray, touching: Touching) -> tuple[str, int] | None:
        """The contact that is deepest inside its surface without being held; None if none is."""
        rows, worst, which = self._rows(q), INSIDE * self.soft.size, None
        for name, numbers in self.numbers.items():
            for k, n in enumerate(numbers):
                if k not in touching[name] and -rows[n, at.GAP] > worst:
                    worst, which = -rows[n, at.GAP], (name, k)
        return which

    def _normals(self, exact: Equilibrium, holding: System, touching: Touching) -> dict[tuple[str, int], float]:
        """N [N] of every contact that `holding` holds."""
        rows, normals = self._rows(exact.q), {}
        for name, corners in touching.items():
            for k in corners:
                row, key = rows[self.numbers[name][k]], f"{HELD_BY}{name} {k}"
                on_b = 1.0 if holding.model.joints[key].a.body == self.soft.model.joints[name].a.body else -1.0
                normals[name, k] = -on_b * (exact[f"{key}.fx"] * row[at.NX] + exact[f"{key}.fy"] * row[at.NY])
        return normals

    def _shown(
        self, rest: Equilibrium, exact: Equilibrium, touching: Touching, normals: Mapping[tuple[str, int], float]
    ) -> Equilibrium:
        """The exact equilibrium with the columns of the mechanism with surfaces."""
        column, row, rows = rest.table.column, rest.row.copy(), self._rows(exact.q)
        for key, k in column.items():
            if key in exact.table.column:
                row[k] = exact[key]
        labels = contact_labels(self.soft.model)
        for name, numbers in self.numbers.items():
            fx = fy = moment = total = 0.0
            joint = self.soft.model.joints[name]
            arm = point_at(self.soft, exact.q, joint.b) - pose(self.soft, exact.q, joint.b.body)[:2]
            for k, n in enumerate(numbers):
                normal, touch = normals.get((name, k), 0.0), rows[n]
                x, y = -normal * touch[at.NX], -normal * touch[at.NY]
                fx, fy, total = fx + x, fy + y, total + normal
                moment += (touch[at.PBX] - arm[0]) * y - (touch[at.PBY] - arm[1]) * x
                if labels[n][1]:
                    row[column[f"{name}.{labels[n][1]}.normal"]] = normal
            gap = min(rows[n, at.GAP] for n in numbers)
            values = {"fx": fx, "fy": fy, "moment": moment, "normal": total, "gap": max(gap, 0.0)}
            values |= {"tangential": 0.0, "penetration": 0.0}
            for key, value in values.items():
                row[column[f"{name}.{key}"]] = value
        return replace(exact, row=row, table=rest.table, touching={name: touching[name] for name in self.names})
