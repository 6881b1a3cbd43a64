"""Check of a mechanism before anything runs: mobility, redundant joints, loops, branches, range of the drivers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from rattle.analyses.assembly.assembly import Assembled, ideal_system
from rattle.analyses.assembly.free_coordinates import free_coordinates
from rattle.analyses.assembly.loops import describe_loop, loops
from rattle.analyses.assembly.rank import nonunique_reactions, rank
from rattle.analyses.law_check import law_faults
from rattle.analyses.timetable import jump_lines, timetable
from rattle.analyses.travel import out_of_place, stop_lines, with_ends, with_stops
from rattle.description.model import Joint, Model, is_ground
from rattle.description.named_figures import named_figures
from rattle.equations.closure import close_position, close_rate, open_by
from rattle.equations.compliant import locate_contacts
from rattle.equations.contact_table import contact_labels
from rattle.equations.dense import LARGE
from rattle.equations.placement import point_at
from rattle.equations.system import System, is_link
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace
from rattle.results.display import in_written_unit, quantity, table

TURN = 72  # positions of a driver tried around a full turn, for bodies that turn no faster
MOST_PIECES = 100  # times as many for those that do
TOUCHING = 1e-9  # share of the mechanism's size within which two bodies touch
MOST_SHOWN = 8  # free coordinates, loops and branches in the report
COINCIDENT = 1e-9  # [of the mechanism's size] pins nearer than this are one: no line has a side there
STRAIGHT = 1e-9  # [-] sine of an angle below which three pins lie on one line: far above rounding
CLOSED = 1e-10  # [of the mechanism's size] gap to which joints are closed before a driver is moved
REACHED = 1e-9  # [of the mechanism's size] gap up to which a position of a driver counts as reached
CLOSER = 1e-3  # [-] share of that gap to which joints are closed there, so that what is left decides nothing
ITERATIONS = 30  # of closing joints at most; where they are not enough the position is out of reach


@dataclass(frozen=True, repr=False)
class Check:
    """A short report on a mechanism; `str()` prints it."""

    name: str
    bodies: int
    joints: int
    mobility: int  # degrees of freedom left with all joints and drivers in place
    redundant: int  # constraint rows that repeat others
    redundant_joints: tuple[str, ...]  # joints whose reactions are not unique
    loops: tuple[str, ...]
    branches: tuple[str, ...]  # the branch in which each pair of links was assembled
    clearances: tuple[str, ...]
    one_sided: tuple[str, ...]  # cams, gears, belts that act one way only
    surfaces: tuple[str, ...]  # what may touch outside of joints, and how far it is apart
    stops: tuple[str, ...]  # ends of coordinates of joints
    ends: tuple[str, ...]  # of joints along a line, where there is something to say of them
    reach: tuple[str, ...]  # how far each driver can go
    freedoms: tuple[str, ...]  # coordinates that may be chosen freely and determine all others
    laws: tuple[str, ...]  # contact laws of the user that pull or create energy
    start: tuple[str, ...]  # values given for the start that could not be kept, and why
    residual: float  # largest constraint residual after assembly [m or rad]
    plates: tuple[str, ...] = ()  # what follows from their polygons
    massless: tuple[str, ...] = ()  # bodies without mass or inertia
    moving_ground: tuple[str, ...] = ()  # points of the ground that are functions of time
    named: tuple[str, ...] = ()  # figures of fits, bearings, oils and materials by name, with their sources
    parameters: tuple[str, ...] = ()  # those with a label or a description: what the model file says of them

    def __repr__(self) -> str:
        return f"<rattle.Check: {self.bodies} bodies, {self.joints} joints, mobility {self.mobility}>"

    def _repr_html_(self) -> str:
        first, *rest = str(self).splitlines()
        rows = [line.partition(": ")[::2] for line in rest if ": " in line]
        return table(("what", "found"), rows, first, hint="m.plot(), m.simulate()")

    def __str__(self) -> str:
        lines = [f"{self.name or 'mechanism'}: {self._counts()}", "assembled: all joints close", *self._redundancy()]
        if self.freedoms:
            more = f" and {len(self.freedoms) - MOST_SHOWN} more" if len(self.freedoms) > MOST_SHOWN else ""
            lines.append(f"free: {', '.join(self.freedoms[:MOST_SHOWN])}{more}")
        lines += [*_listed("parameter", self.parameters), *_listed("plate", self.plates)]
        lines += _listed("by name", self.named)
        lines += [f"without mass or inertia: {', '.join(self.massless)}"] if self.massless else []
        lines += [f"moves over time: {', '.join(self.moving_ground)}"] if self.moving_ground else []
        lines += _listed("loop", self.loops[:MOST_SHOWN])
        if len(self.loops) > MOST_SHOWN:
            lines.append(f"... and {len(self.loops) - MOST_SHOWN} more loops")
        rest = {
            "branch": self.branches[:MOST_SHOWN], "play": self.clearances, "one-sided": self.one_sided,
            "surface": self.surfaces,
            "stop": self.stops, "ends": self.ends, "driver": self.reach, "law": self.laws, "start": self.start,
        }  # fmt: skip
        return "\n".join([*lines, *(line for what, texts in rest.items() for line in _listed(what, texts))])

    def _counts(self) -> str:
        bodies = f"{self.bodies} {'body' if self.bodies == 1 else 'bodies'}"
        joints = f"{self.joints} joint{'' if self.joints == 1 else 's'}"
        dof = f"{self.mobility} degree{'s' if self.mobility > 1 else ''} of freedom left"
        return f"{bodies}, {joints}, mobility {self.mobility} ({'moves as driven' if self.mobility == 0 else dof})"

    def _redundancy(self) -> list[str]:
        if not self.redundant:
            return []
        rows = "1 redundant constraint" if self.redundant == 1 else f"{self.redundant} redundant constraints"
        return [f"{rows}: reactions of {', '.join(self.redundant_joints)} are not unique"]


def _listed(what: str, texts: Iterable[str]) -> list[str]:
    return [f"{what}: {text}" for text in texts]


def check(system: System, start: Assembled, written: Mapping[str, tuple[float, str]]) -> Check:
    """Check a mechanism at its assembled start; written: units of parameters, see `in_written_unit`."""
    model = system.model
    jumps = timetable(system, start.t, model.settings.t_end).jumps
    workspace = system.workspace()
    open_by(workspace, start.t, start.q, start.v)
    if system.row_count > LARGE:
        from rattle.equations.schur import factorise

        factorise(workspace)
    independent = rank(system, workspace)
    redundant = system.row_count - independent
    reach = _reach(system, start)
    if reach:
        left_out = {"ends": with_ends(model), "stops": with_stops(model)}
        reach += [f"the {what} of {names} are left out of the range" for what, names in left_out.items() if names]
    return Check(
        name=model.name,
        bodies=len(model.moving_bodies),
        joints=len(model.joints),
        mobility=3 * system.body_count - independent,
        redundant=redundant,
        redundant_joints=nonunique_reactions(system, workspace) if redundant else (),
        loops=tuple(describe_loop(model, joint, path) for joint, path in loops(model)),
        branches=tuple(_branches(system, start)),
        clearances=tuple(_clearances(model)),
        one_sided=tuple(_one_sided(model)),
        surfaces=tuple(_surfaces(system, workspace)),
        freedoms=free_coordinates(system, start.t, start.q),
        stops=tuple(stop_lines(model)),
        ends=tuple(
            f"{name}, {words}" for name, joint in model.joints.items() if (words := joint.leaf.ends(joint.fields))
        ),
        reach=(*reach, *jump_lines(jumps)),
        laws=tuple(law_faults(model)),
        start=(*start.changes, *out_of_place(system, np.array([start.t]), start.q.reshape(1, -1, 3))),
        residual=start.residual,
        plates=tuple(_plates(model)),
        named=tuple(named_figures(model)),
        parameters=tuple(_parameters(model, written)),
        massless=tuple(
            name for name in model.moving_bodies if 0.0 in (model.bodies[name].mass, model.bodies[name].inertia)
        ),
        moving_ground=tuple(name for name in model.bodies if is_ground(name)),
    )


def _one_sided(model: Model) -> list[str]:
    return [
        f"{name}, {joint.contact.model}"
        for name, joint in model.joints.items()
        if joint.contact is not None and joint.one_sided is not None and not joint.leaf.touches
    ]


def _surfaces(system: System, workspace: Workspace) -> Iterator[str]:
    """What may touch, on what, by which contact model, and how far it is apart in the workspace [m]."""
    locate_contacts(workspace)
    labels = contact_labels(system.model)
    for name, joint in system.model.joints.items():
        if joint.contact is None or not joint.leaf.touches:
            continue
        gaps = [float(workspace.contact_kinematics[n, at.GAP]) for n, (owner, _) in enumerate(labels) if owner == name]
        near = f"{quantity(min(gaps), 'm', 4)} apart" if min(gaps) > TOUCHING * system.size else "touching"
        a, b = (f"'{body}'" if body != "ground" else "the ground" for body in (joint.a.body, joint.b.body))
        what = f"{_touching(joint)} of {b} on {joint.leaf.bears(joint.fields)} of {a}"
        yield f"{name}, {what}, {joint.contact.title}; {near}"


def _touching(joint: Joint) -> str:
    """What of B may touch a surface, in words."""
    if joint.fields["roller"] > 0.0:
        return "the disc"
    if joint.fields["outline"]:
        return "the outline"
    return f"corner{'s' * (len(joint.corners) > 1)} {', '.join(joint.corners)}"


def _parameters(model: Model, written: Mapping[str, tuple[float, str]]) -> list[str]:
    """Value, label and description of parameters that have one of the two."""
    return [
        f"{parameter.title} {in_written_unit(parameter, written[name])}"
        + (f": {parameter.description}" if parameter.description else "")
        for name, parameter in model.parameters.items()
        if parameter.label or parameter.description
    ]


def _plates(model: Model) -> list[str]:
    """Mass, inertia and mass centre of every plate."""
    return [
        f"{name} {body.mass:.4g} kg, {body.inertia:.4g} kg*m^2 about its mass centre, which is"
        f" [{quantity(-body.outline[0][0][0], 'm')}, {quantity(-body.outline[0][0][1], 'm')}] from its first corner"
        for name, body in model.bodies.items()
        if body.outline
    ]


def _clearances(model: Model) -> list[str]:
    return [
        f"{name} {quantity(joint.clearance, 'm')}, {joint.contact.model}"
        for name, joint in model.joints.items()
        if joint.contact is not None and joint.one_sided is None
    ]


def _branches(system: System, start: Assembled) -> list[str]:
    """For every pair of links between three pins: the side of the middle pin on the line through the outer pins."""
    model = system.model
    if system.row_count > LARGE:
        return []
    at = {name: point_at(system, start.q, joint.a) for name, joint in model.joints.items()}
    driven = {driver.joint for driver in model.drivers.values()}
    sides = []
    for joint, path in loops(model):
        ring = [*path, joint.name]
        for k in range(len(ring)):
            outer, middle, last = ring[k - 1], ring[k], ring[(k + 1) % len(ring)]
            pins = all(model.joints[name].is_hinge for name in (outer, middle, last))
            if (
                not pins
                or len({outer, middle, last}) < 3
                or middle in driven
                or any(is_ground(end.body) for end in (model.joints[middle].a, model.joints[middle].b))
            ):
                continue
            first, second = at[middle] - at[outer], at[last] - at[outer]
            side = first[1] * second[0] - first[0] * second[1]
            if min(np.hypot(*first), np.hypot(*second), np.hypot(*(second - first))) < COINCIDENT * system.size:
                continue  # two pins coincide: there is no side
            scale = float(np.hypot(*first) * np.hypot(*second))
            where = "on" if abs(side) < STRAIGHT * scale else "left of" if side > 0 else "right of"
            sides.append(f"{middle} lies {where} the line {outer} -> {last}")
    return list(dict.fromkeys(sides))


def _reach(system: System, start: Assembled) -> list[str]:
    """How far each driver can be moved from its start, with the others fixed and all clearances closed."""
    model = system.model
    if not model.motors or system.row_count > LARGE:
        return []
    links = any(is_link(joint) or joint.stop for joint in model.joints.values())
    ideal = ideal_system(model) if links else system
    frozen, slots, at_start = _hold_drivers(ideal, start.t)
    lines = []
    q = start.q.copy()
    scratch = np.empty_like(q)
    close_position(frozen, 0.0, q, scratch, CLOSED * system.size, ITERATIONS)
    for name, slot in slots.items():
        turning = system.rows[system.first_row(name)].unit == "rad"
        step = 2 * math.pi / TURN if turning else system.size / 36
        pieces = min(MOST_PIECES, math.ceil(step * _turning(frozen, q, slot) / 0.5) or 1)
        step /= pieces
        up = _far(frozen, q, scratch, slot, at_start[name], step, REACHED * system.size, pieces * TURN)
        if turning and up is None:
            lines.append(f"{name} can turn fully")
            continue
        down = _far(frozen, q, scratch, slot, at_start[name], -step, REACHED * system.size, pieces * TURN)
        lines.append(_range(name, at_start[name], down, up, turning))
    return lines


def _range(name: str, now: float, down: float | None, up: float | None, turning: bool) -> str:
    """Between which values [rad or m] a driver can move; None: as far as was tried."""
    unit = ("rad", "deg") if turning else ("m", "m")
    at, low, high = (
        quantity(value, unit[0], 5, unit[1]) if value is not None else "beyond the range tried"
        for value in (now, down, up)
    )
    if up is None and down is None:
        return f"{name} can move as far as was tried, to both sides (now {at})"
    return f"{name} can move from {low} to {high} (now {at})"


def _hold_drivers(system: System, t: float) -> tuple[Workspace, dict[str, int], dict[str, float]]:
    """Workspace with constant driver functions, the places of their values, and the values at t [s] [rad or m]."""
    from dataclasses import replace

    from rattle.equations.motion import drive

    running = system.workspace()
    drive(running, t)
    slots = {name: system.driver_slot(name) for name in system.model.motors}
    values = running.values.copy()
    for slot in slots.values():
        values[slot + 1 : slot + 3] = 0.0
    none = {name: system.arrays[name][:0] for name in ("jet", "jet_signal")}
    frozen = replace(system, arrays={**system.arrays, **none, "values": values}).workspace()
    return frozen, slots, {name: float(values[slot]) for name, slot in slots.items()}


def _turning(workspace: Workspace, q: np.ndarray, slot: int) -> float:
    """How fast the fastest body turns with a driver [rad per rad or m], the others at rest: a gear may turn faster."""
    v = np.zeros_like(q)
    workspace.values[slot + 1] = 1.0
    close_rate(workspace, 0.0, q, v)
    workspace.values[slot + 1] = 0.0
    fastest = float(np.abs(v[2::3]).max(initial=0.0))
    return fastest if math.isfinite(fastest) else 0.0


def _far(
    workspace: Workspace, start: np.ndarray, scratch: np.ndarray, slot: int, value: float, step: float,
    tolerance: float, most: int,
) -> float | None:  # fmt: skip
    """Last value [rad or m] of a driver that can be reached in `most` steps from `value`; None if nothing stops it."""
    q, good = start.copy(), start.copy()
    reached = value
    for _ in range(most):
        workspace.values[slot] = reached + step
        gap, _ = close_position(workspace, 0.0, q, scratch, CLOSER * tolerance, ITERATIONS)
        if not gap <= tolerance or np.abs(q - good)[2::3].max() > 1.5:
            break
        reached += step
        good[:] = q
    else:
        workspace.values[slot] = value
        return None
    low, high = 0.0, 1.0
    for _ in range(12):
        middle = 0.5 * (low + high)
        q[:] = good
        workspace.values[slot] = reached + middle * step
        gap, _ = close_position(workspace, 0.0, q, scratch, CLOSER * tolerance, ITERATIONS)
        low, high = (middle, high) if gap <= tolerance and np.abs(q - good)[2::3].max() <= 1.5 else (low, middle)
    workspace.values[slot] = value
    return reached + low * step
