"""The orbit of a pin by the mobility method: the forces of the mechanism without play, and what the film does of them.

1. Inverse dynamics of the mechanism with all clearances closed gives the force of the joint and the rates of both
   bodies (`course`).
2. The film has no inertia, so this force says how the pin moves (`rattle.solvers.mobility`): a differential equation of
   first order.

Left out are the inertia of the pin's motion in the clearance and what it changes in the forces.
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from rattle.analyses import arguments
from rattle.analyses.assembly.assembly import Assembled, assemble, ideal_system
from rattle.analyses.dynamics.oil_notes import oil_notes
from rattle.analyses.dynamics.simulate import output_times
from rattle.description.model import Joint
from rattle.equations.placement import point_at
from rattle.equations.system import System
from rattle.errors import ModelError, Problem, SolverError, suggest
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.questions.kinematics.compute import analyse, require_driven
from rattle.questions.orbit.course import Course, course
from rattle.results.build import build_result
from rattle.results.film_columns import PinMotion, film_values
from rattle.results.result import Result, UnknownName
from rattle.solvers import mobility
from rattle.solvers.stepper import RTOL

log = logging.getLogger("rattle")

Array = np.ndarray
COARSER = 10.0  # tolerance of the force over that of the path
PIECE = 20_000  # steps between two checks for Ctrl-C
MOST_STEPS = 5_000_000
FIRST = 1e-3  # share of the clearance that the first step goes
FEWEST = 36  # outputs in a turn with which it is compared with the one before
CLOSED = 1e-2  # change of the path from turn to turn, in clearances, below which it is closed
UNSURE = 1e-3  # [-] share of the time, with a force that changes too fast to follow, from which it is told
ROUNDING = 1e-6  # [turns] by which two turns of the driver may fall short
LEFT_OUT = "the path of the pin follows the forces of the mechanism without play; its own inertia is left out"
MEMORY = "dry friction by a law with a memory is left out of an orbit"


class Orbit(NamedTuple):
    """The path of a pin at the outputs, and what it took."""

    rows: Array  # (n, 7), see the columns in `rattle.solvers.mobility`
    end: float  # where it was followed to [s]
    steps: int


def orbit(
    system: System, start: Assembled, name: str, t_eval: Sequence[float] | np.ndarray | None, *,
    t_end: float | None = None, rtol: float | None = None, strict: bool = False,
) -> Result:  # fmt: skip
    """The orbit of the pin of a joint with oil; see `Mechanism.orbit`."""
    began = time.perf_counter()
    joint = _lubricated(system, name)
    _, times = output_times(system.model.settings, t_end, t_eval)
    tolerance = arguments.relative_tolerance(RTOL if rtol is None else rtol)
    functions.start()
    ideal = ideal_system(system.model)
    ideal_start = assemble(ideal)
    require_driven(ideal, ideal_start, "an orbit under the forces of the ideal mechanism")
    base = analyse(ideal, ideal_start, times, forces=True)
    reached = len(base.t)
    if not reached:
        raise SolverError(base.message, base)
    carried = _course(ideal, ideal_start, joint, base, COARSER * tolerance)
    e = point_at(system, start.q, joint.b) - point_at(system, start.q, joint.a)
    path = _followed(system, name, carried, base.t, e, tolerance)
    notes = [LEFT_OUT, *([MEMORY] if _remembers(joint) else []), *_unsure(name, carried), *_open(joint, base, path)]
    message = base.message
    if len(path.rows) < reached:
        message = f"the pin of '{name}' cannot be followed beyond t = {path.end:.6g} s: {_why(name, base, path.end)}"
    result = _result(system, joint, base, carried, path, notes, message, time.perf_counter() - began)
    if not result.success:
        log.error(result.message)
        if strict:
            raise SolverError(result.message, result)
    return result


def _lubricated(system: System, name: str) -> Joint:
    """The joint.  Raises UnknownName, or ModelError if it has no oil."""
    joints = system.model.joints
    if name not in joints:
        oiled = [
            other.name for other in joints.values() if other.contact is not None and other.contact.film is not None
        ]
        raise UnknownName(f"the model has no joint {name!r}{suggest(name, oiled or joints)}")
    joint = joints[name]
    if joint.contact is None or joint.contact.film is None or not joint.is_loose:
        needs = 'a clearance, and contact = { model = "lubricated", viscosity, length, bush_radius }'
        raise ModelError([Problem(("joints", name, "contact"), f"an orbit needs oil in the joint: {needs}")])
    return joint


def _remembers(joint: Joint) -> bool:
    """True if its dry friction has states of its own."""
    from rattle import registry

    law = joint.contact.friction if joint.contact is not None else None
    return law is not None and registry.kinds("friction")[law.kind].leaf.states > 0


def _course(ideal: System, start: Assembled, joint: Joint, base: Result, tolerance: float) -> Course:
    """Force of the joint and rates of both bodies over time, from 0 to where the mechanism gets to."""

    def carried(times: Array) -> Array:
        result = analyse(ideal, start, times, forces=True)
        if len(result.t) < len(times):
            raise SolverError(result.message, result)
        rates = [_rate(result, end) for end in (joint.a.body, joint.b.body)]
        return np.stack([result[f"{joint.name}.fx"], result[f"{joint.name}.fy"], *rates], axis=1)

    fastest = max(float(np.abs(base[f"{body}.omega"]).max()) for body in ideal.bodies)
    return course(carried, float(base.t[-1]), fastest, tolerance)


def _rate(result: Result, body: str) -> Array:
    return np.zeros(len(result.t)) if body == "ground" else result[f"{body}.omega"]


def _followed(system: System, name: str, carried: Course, times: Array, e: Array, tolerance: float) -> Orbit:
    """The path of the pin from e (2,) [m] at t = 0 to the times (n,) [s]."""
    workspace, number = system.workspace(), system.joints.index(name)
    contact = system.arrays["contact"]
    mine = int(np.flatnonzero((contact[:, at.OWNER] == number) & (contact[:, at.FILM_LAW] >= 0))[0])
    clearance = system.model.joints[name].clearance
    rows, scratch, clock = np.zeros((len(times), 7)), np.zeros((mobility.STAGES, 2)), np.zeros(5)
    clock[mobility.X], clock[mobility.Y] = e
    first = np.zeros((1, 7))
    clock[mobility.STRIDE] = 1.0
    arguments_ = (carried.nodes, carried.cubics)
    mobility.follow(workspace, mine, *arguments_, np.zeros(1), tolerance, 1.0, clock, scratch, first)
    speed = math.hypot(first[0, mobility.RATE_X], first[0, mobility.RATE_Y])
    end = float(times[-1])
    clock[mobility.STRIDE] = min(FIRST * clearance / speed if speed > 0.0 else math.inf, end or 1.0)
    done = 0
    while done < len(times) and clock[mobility.STRIDE] > 0.0 and clock[mobility.TAKEN] < MOST_STEPS:
        done += mobility.follow(
            workspace, mine, *arguments_, times[done:], tolerance, float(PIECE), clock, scratch, rows[done:]
        )
    return Orbit(rows[:done], float(clock[mobility.NOW]), int(clock[mobility.TAKEN]))


def _unsure(name: str, carried: Course) -> list[str]:
    if carried.unsure < UNSURE:
        return []
    return [f"{name}: its force changes faster than it was followed at {100 * carried.unsure:.2g} % of the time"]


def _open(joint: Joint, base: Result, path: Orbit) -> list[str]:
    """A note if the path of the last turn of the driver is not that of the turn before."""
    driven = [name for name in base.geometry["driven"] if f"{name}.angle" in base]
    if not driven or len(path.rows) < len(base.t):
        return []
    turns = np.abs(base[f"{driven[0]}.angle"] - base[f"{driven[0]}.angle"][0]) / (2.0 * math.pi)
    if turns[-1] < 2.0 - ROUNDING or not (np.diff(turns) > 0.0).all() or (turns > turns[-1] - 1.0).sum() < FEWEST:
        return []
    now = turns[turns > turns[-1] - 1.0]
    place = path.rows[turns > turns[-1] - 1.0, :2].T
    before = np.array([np.interp(now - 1.0, turns, values) for values in path.rows[:, :2].T])
    change = float(np.hypot(*(place - before)).max()) / joint.clearance
    if change < CLOSED:
        return []
    return [
        f"{joint.name}: the last turn differs from the one before by {change:.2g} of the clearance; take more turns"
    ]


def _why(name: str, base: Result, t: float) -> str:
    force = np.hypot(base[f"{name}.fx"], base[f"{name}.fy"])
    if not np.isfinite(force).all():
        return f"its force has no finite value at t = {base.t[np.argmin(np.isfinite(force))]:.6g} s"
    return "its dry contact is too stiff for the film beside it; use simulate, or a thicker boundary_film"


def _result(
    system: System, joint: Joint, base: Result, carried: Course, path: Orbit, notes: Sequence[str], message: str,
    wall: float,
) -> Result:  # fmt: skip
    """The result of the mechanism without play, with the columns of the film in place of those of the closed joint."""
    n, name = len(path.rows), joint.name
    own = _columns(joint, base, path.rows)
    names, data, units = [], [], {}
    for column in base.stored:
        if column.partition(".")[0] != name:
            names.append(column)
            data.append(base[column][:n])
            units[column] = base.unit(column)
        elif own:
            for key, (unit, values) in own.items():
                names.append(f"{name}.{key}")
                data.append(values)
                units[names[-1]] = unit
            own = {}
    table = np.stack(data, axis=1)
    remarks = (*base.trust.notes, *notes, *oil_notes(system, table, names))
    trust = replace(base.trust, notes=remarks, t_end=path.end, horizon=path.end, stopped=bool(message))
    stats = {"positions": n, "nodes": len(carried.nodes), "steps": path.steps, "wall_time": wall}
    return build_result(
        system.model, "orbit", t=base.t[:n], data=table, names=names, units=units, trust=trust, stats=stats,
        settings={"joint": name}, events=base.events, message=message,
    )  # fmt: skip


def _columns(joint: Joint, base: Result, rows: Array) -> dict[str, tuple[str, Array]]:
    """Units and values (n,) [SI] of the columns of the joint."""
    assert joint.contact is not None, "called for a joint with oil"
    n, name = len(rows), joint.name
    x, y, vx, vy, normal, tangential, moment = rows.T
    force = base[f"{name}.fx"][:n], base[f"{name}.fy"][:n]
    turning = _rate(base, joint.a.body)[:n], _rate(base, joint.b.body)[:n]
    size = np.hypot(x, y)
    on_b = joint.contact.bush_radius - 0.5 * (joint.clearance - size) - size  # see the clearance `pin`
    pin = PinMotion((x, y), (vx, vy), turning, force, moment - tangential * on_b, normal, tangential)
    assert joint.contact.film is not None, "called for a joint with oil"
    plain = {
        "fx": ("N", force[0]),
        "fy": ("N", force[1]),
        "moment": ("N*m", pin.moment),
        "ex": ("m", x),
        "ey": ("m", y),
        "normal": ("N", normal),
        "tangential": ("N", tangential),
        "penetration": ("m", size - joint.clearance + joint.contact.film.boundary),
    }
    return plain | film_values(joint, pin)
