"""Equilibria of mechanisms with stops: every stop is left alone, or its joint rests on one of its ends.

A joint that rests is held there by a driver, whose effort is the force or moment of the stop, positive on B; a rope is
then a rod of that length.  It is an equilibrium of the stop if it presses and no other joint is beyond its stop.  A
compliant stop is then let sink in.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import brentq

from rattle import registry
from rattle.description.model import Contact, Driver, Joint, Model
from rattle.equations.compliant import locate_contacts
from rattle.equations.contact_table import contact_groups
from rattle.equations.motion import place
from rattle.equations.placement import point_at, pose
from rattle.equations.system import System, compile_system
from rattle.jit import layout as at
from rattle.jit.families import call_stiffness
from rattle.questions.equilibrium.balance import StaticProblem
from rattle.questions.equilibrium.position import Equilibrium, Table
from rattle.results.build import provenance
from rattle.results.columns import geometry

MOST = 27  # combinations of ends that are tried: all of three joints with two ends each
AT_STOP = "stop of "  # name of the driver that holds a joint, before the name of the joint
FIRST_DEPTH = 1e-12  # [m or rad] to which a compliant stop is let sink in first, then doubled until it carries
SLIGHT = 1e-9  # share of the forces below which a joint does not rest on its stop; of its scale by which it is beyond

Ends = Mapping[str, int]  # joints that rest on a stop: 1 on its least value, -1 on its largest


def combinations(model: Model) -> Iterator[dict[str, int]]:
    """Joints that rest on a stop, and at which end: none at first, then one after the other, then several."""
    driven = {driver.joint for driver in model.drivers.values()}
    ends = {
        name: [k for k, end in ((1, joint.stop.minimum), (-1, joint.stop.maximum)) if math.isfinite(end)]
        for name, joint in model.joints.items()
        if joint.stop is not None and name not in driven
    }
    for count in range(len(ends) + 1):
        for names in itertools.combinations(ends, count):
            for sides in itertools.product(*(ends[name] for name in names)):
                yield dict(zip(names, sides, strict=True))


def resting_system(system: System, resting: Ends, depth: Mapping[str, float] | None = None) -> System:
    """The mechanism in which joints that rest on stops are held there, and all other stops are left out.

    depth: how far beyond its end [m or rad] a joint is held; without it a joint with a compliant stop is not held, but
    keeps that stop.
    """
    drivers, joints = dict(system.model.drivers), {}
    for name, joint in system.model.joints.items():
        joints[name] = replace(joint, stop=None)
        if name not in resting or joint.stop is None:
            continue
        if depth is None and not joint.stop.contact.rigid:
            joints[name] = joint
            continue
        end = joint.stop.minimum if resting[name] > 0 else joint.stop.maximum
        value = end - resting[name] * (depth or {}).get(name, 0.0)
        if joint.held_by_stops:
            joints[name] = replace(joint, fields=joint.leaf.held_at(value), stop=None)
            continue
        drivers[AT_STOP + name] = Driver(AT_STOP + name, joint.motor.driver, name, value)
    return compile_system(replace(system.model, drivers=drivers, joints=joints))


class Stopped:
    """A mechanism with stops, to which equilibria that were found with held joints belong."""

    def __init__(self, system: System, t: float) -> None:
        self.system, self.t = system, t
        self.workspace = system.workspace()
        self.passed: dict[str, None] = {}  # joints that were beyond their stops in positions without them

    def taken(self, equilibria: Iterable[Equilibrium], resting: Ends) -> list[Equilibrium]:
        """The equilibria in which no joint is beyond its stop, with the forces of stops; compliant ones sink in."""
        taken = []
        for rest in equilibria:
            efforts = {name: self._effort(rest, name) for name in resting}
            forces = [abs(rest[name]) for name in rest.table.column if name.endswith((".fx", ".fy", ".moment"))]
            weight = max([*forces, *map(abs, efforts.values()), rest.residual])
            if any(abs(force) <= SLIGHT * weight for force in efforts.values()):
                continue  # it needs no stop, and is found without it
            soft = [name for name in resting if not self._contact(name).rigid]
            if soft and all(resting[name] * efforts[name] > 0.0 for name in soft):
                sunk = self._sunk(rest, resting, efforts)
                taken += [sunk] if sunk is not None else []
            elif not soft and not self.beyond(rest.q, resting):
                taken.append(self._shown(rest, resting, efforts))
        return taken

    def beyond(self, q: np.ndarray, resting: Ends) -> bool:
        """True if a joint that does not rest is beyond its stop at q (3 nb,) [m, m, rad]."""
        contact, lever, beyond = self.system.arrays["contact"], self.system.arrays["lever"], False
        place(self.workspace, q, np.zeros_like(q))
        locate_contacts(self.workspace)
        for entry, row, kinematics in zip(contact, lever, self.workspace.contact_kinematics, strict=True):
            name = self.system.joints[entry[at.OWNER]]
            stops = entry[at.FORCE_COLUMN] == at.STOP and name not in resting
            if stops and kinematics[at.GAP] < -SLIGHT * row[at.GAP_SIZE]:
                self.passed[name] = None
                beyond = True
        return beyond

    def _contact(self, name: str) -> Contact:
        stop = self.system.model.joints[name].stop
        assert stop is not None, "only joints with a stop rest on one"
        return stop.contact

    def _effort(self, rest: Equilibrium, name: str) -> float:
        """Force [N] or moment [N m] with which a joint is held at its stop, on B."""
        joint = self.system.model.joints[name]
        if joint.held_by_stops:
            ux, uy = self._along(rest, joint)
            return float(ux * rest[f"{name}.fx"] + uy * rest[f"{name}.fy"])
        motor = joint.motor
        effort = registry.kinds("driver")[motor.driver].leaf.effort[0]
        return float(rest.row[rest.table.column[f"{AT_STOP}{name}.{effort}"]])

    def _along(self, rest: Equilibrium, joint: Joint) -> np.ndarray:
        """Direction (2,) from the point of A to that of B; nan where they are at one place."""
        d = point_at(self.system, rest.q, joint.b) - point_at(self.system, rest.q, joint.a)
        return np.asarray(d / np.hypot(*d))

    def _sunk(self, rest: Equilibrium, resting: Ends, efforts: Mapping[str, float]) -> Equilibrium | None:
        """The equilibrium near one with rigid stops in which compliant ones give way; None if none was found."""
        depth = {name: self._depth(name, abs(efforts[name])) for name in resting if not self._contact(name).rigid}
        start = rest.q.copy()
        StaticProblem(resting_system(self.system, resting, {**dict.fromkeys(resting, 0.0), **depth}), self.t).close(
            start
        )
        problem = StaticProblem(resting_system(self.system, resting), self.t)
        solution = problem.find(start)
        if solution is None or self.beyond(solution[0], resting):
            return None
        settled = problem.finish(*solution)
        return self._shown(
            settled, resting, {name: self._effort(settled, name) for name in resting if name not in depth}
        )

    def _depth(self, name: str, force: float) -> float:
        """Depth [m or rad] at which the static force of a compliant stop is `force` [N or N m]."""
        group = next(
            candidate for candidate in contact_groups(self.system.model.joints[name]) if "stop" in candidate.path
        )
        static = group.contact.static
        assert static is not None, "called for compliant stops"
        kind = registry.kinds("stiffness")[static.kind]
        p = np.array([*kind.leaf.pack(static.values), 0.0])

        def missing(depth: float) -> float:
            return float(call_stiffness(kind.kernel, (depth, p, 0))) - force

        high = FIRST_DEPTH
        while missing(high) < 0.0:
            high *= 2.0
        return float(brentq(missing, 0.0, high))

    def _drawn(self, rest: Equilibrium) -> dict[str, Any]:
        """What is drawn of the mechanism: joints as in the equilibrium, with their stops."""
        drawn, joints = geometry(self.system.model), {}
        for name, form in rest.table.geometry["joints"].items():
            own = drawn["joints"][name]
            shown = own if self.system.model.joints[name].held_by_stops else form
            joints[name] = shown | {key: own[key] for key in ("stop",) if key in own}
        drawn["joints"] = joints
        return drawn

    def _shown(self, rest: Equilibrium, resting: Ends, efforts: Mapping[str, float]) -> Equilibrium:
        """The equilibrium with the columns of the mechanism with stops; efforts: of the joints held [N or N m]."""
        values = {name: float(rest.row[k]) for name, k in rest.table.column.items() if not name.startswith(AT_STOP)}
        units = {name: rest.table.units[name] for name in values}
        joints = self.system.model.joints
        for name in (name for name, joint in joints.items() if joint.stop is not None):
            force, joint = efforts.get(name, 0.0), joints[name]
            if name not in efforts and f"{name}.stop" in values:
                continue
            if joint.stops_angle:
                values[f"{name}.moment"] = values.get(f"{name}.moment", 0.0) + force
                units[f"{name}.moment"] = "N*m"
            elif not joint.held_by_stops:  # a rod in place of a rope has told its force
                axis = pose(self.system, rest.q, joint.a.body)[2] + (joint.line or 0.0)
                values[f"{name}.fx"] += force * math.cos(axis)
                values[f"{name}.fy"] += force * math.sin(axis)
            values[f"{name}.stop"] = force
            units[f"{name}.stop"] = "N*m" if joint.stops_angle else "N"
        column = {name: k for k, name in enumerate(values)}
        pins = tuple((name, column[f"{name}.normal"]) for name, _ in rest.table.pins)
        drawn = self._drawn(rest)
        table = Table(column, units, pins, drawn, provenance(self.system.model, "equilibrium"))
        return replace(rest, row=np.array(list(values.values())), table=table, resting=dict(resting))
