"""Motion in time: a run from a consistent start, with everything a result says about itself."""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from rattle.analyses import arguments
from rattle.analyses.assembly.assembly import Assembled
from rattle.analyses.assembly.rank import nonunique_reactions
from rattle.analyses.dynamics import nonsmooth_run
from rattle.analyses.dynamics.events import (
    contact_counts,
    contact_events,
    contact_notes,
    method_notes,
    require_workable,
)
from rattle.analyses.dynamics.horizon import Reach, agreement, tighter
from rattle.analyses.dynamics.peak_values import peak_values
from rattle.analyses.dynamics.run import Run, pulls, start_state
from rattle.analyses.dynamics.soundness import (
    fast_links,
    loose,
    remarks,
)
from rattle.analyses.law_check import law_faults
from rattle.analyses.timetable import jolt_events, jolt_notes
from rattle.equations.system import System
from rattle.errors import SolverError
from rattle.jit import functions
from rattle.results.columns import columns, geometry, width
from rattle.results.result import Result
from rattle.results.trust import Trust
from rattle.solvers import step_audit, step_state
from rattle.solvers.nonsmooth.impacts import LOW
from rattle.solvers.output_row import record
from rattle.solvers.state_switches import TURNS
from rattle.version import __version__

log = logging.getLogger("rattle")

METHODS = ("dop853", "rk4", "event", "moreau")
RTOL = 1e-8
POINTS = 1000  # output intervals when nothing is said


def simulate(
    system: System, start: Assembled, *, t_end: float | None = None,
    t_eval: Sequence[float] | np.ndarray | None = None, method: str | None = None, rtol: float | None = None,
    atol: float | None = None, step: float | None = None, progress: bool = False, strict: bool = False,
    horizon: bool = False, most_steps: int | None = None,
) -> Result:  # fmt: skip
    """Integrate the equations of motion; see `Mechanism.simulate`."""
    functions.start()
    settings = system.model.settings
    end, times = output_times(settings, t_end, t_eval)
    wanted, method = method, settings.method if method is None else method
    if method not in METHODS:
        raise ValueError(f"unknown method '{method}'; wanted {' or '.join(METHODS)}")
    rtol = arguments.relative_tolerance(_first_given(rtol, settings.rtol, RTOL))
    atol = arguments.positive("atol", _first_given(atol, settings.atol, 1e-2 * rtol))
    step = settings.step if step is None else step
    if step is not None:
        arguments.positive("step", step)
    arguments.require_room(len(times), width(system))
    if method == "rk4" and any(
        one.contact and one.contact.model == "compliant" for one in system.model.joints.values()
    ):
        raise ValueError("rk4 takes fixed steps, which contacts do not allow; use method dop853")
    require_workable(system)
    for fault in law_faults(system.model):
        log.warning(fault)
    wanted = wanted or (method if method != METHODS[0] else None)
    one_run, method, step = kind_of_run(system, method, step, end)
    run = one_run(system, start, times, end, method, rtol, atol, step)
    if most_steps is not None and most_steps < 1:
        raise ValueError(f"most_steps must be at least 1, got {most_steps}")
    run.most_steps = most_steps
    run.notes = method_notes(wanted, method)
    run.go(progress)
    reach, second = None, None
    if horizon and run.tally[step_state.OUTPUTS] > 1 and not run.interrupted:
        finer = None if step is None else step / 10 ** (1 / {"dop853": 8, "rk4": 4}.get(method, 1))
        fine = tighter(rtol, RTOL)
        second = one_run(system, start, times, end, method, fine, atol * fine / rtol, finer)
        second.most_steps = None if most_steps is None else 10 * most_steps
        second.go(progress, "once more, tighter")
        reach = None if second.interrupted else agreement(run, second)
    result = _result(run, reach)
    if run.interrupted:
        result.stats["interrupted"] = True
    elif second is not None and second.interrupted:
        result.stats["horizon_interrupted"] = True
    if not result.success:
        log.error(result.message)
        if strict:
            raise SolverError(result.message, result)
    return result


def kind_of_run(system: System, method: str, step: float | None, span: float) -> tuple[type[Run], str, float | None]:
    """What runs this model: set-valued contacts have methods of their own, which other models do not need."""
    if nonsmooth_run.has_impacts(system):
        return nonsmooth_run.ImpactRun, *nonsmooth_run.choose_method(system, method, step, span)
    if method not in ("dop853", "rk4"):
        method = "dop853"
    return Run, method, min(1e-4, span / POINTS) if method == "rk4" and step is None else step


def output_times(
    settings: Any, t_end: float | None, t_eval: Sequence[float] | np.ndarray | None
) -> tuple[float, np.ndarray]:
    """End of a run and its output instants, from what was asked and what the model says."""
    if t_eval is not None:
        times = arguments.instants(t_eval)
        if (
            times.ndim != 1
            or len(times) == 0
            or not np.isfinite(times).all()
            or (np.diff(times) <= 0).any()
            or times[0] < 0
        ):
            raise ValueError("t_eval must be increasing finite times in s, from 0 on")
        end = float(times[-1]) if t_end is None else arguments.positive("t_end", t_end)
        if times[-1] > end * (1 + 1e-12):
            raise ValueError(f"t_eval goes to {times[-1]:g} s, beyond t_end = {end:g} s")
        return max(end, float(times[-1])), times
    end = arguments.positive("t_end", settings.t_end if t_end is None else t_end)
    interval = settings.output or end / POINTS
    count = max(1, round(end / interval))
    if count > arguments.MOST_POINTS:
        raise ValueError(f"{count} outputs are too many; choose a larger output interval")
    return end, np.linspace(0.0, end, count + 1)


def _first_given(*values: float | None) -> float:
    return next(one for one in values if one is not None)


def _result(run: Run, reach: Reach | None) -> Result:
    system, clock, tally, seen = run.system, run.clock, run.tally, run.workspace.audit
    n = int(tally[step_state.OUTPUTS])
    data, names, units = columns(system, run.raw[:n])
    t = run.t_eval[:n]
    reached = float(clock[step_state.T])
    pulled, first, intervals = pulls(run, reached)
    balance = data[:, names.index("energy.balance")]
    nonunique: tuple[str, ...] = ()
    notes = run.start.notes
    if tally[step_state.LOST]:
        record(run.workspace, run.start.t, start_state(system, run.start), np.zeros(width(system)))
        nonunique = nonunique_reactions(system, run.workspace)
        if not nonunique:
            notes += ("the run passed through a position where the joints lose independence (a singular position)",)
    events = contact_events(system, run.contacts, run.workspace, reached)
    notes += (
        *run.notes,
        *contact_notes(system, events, float(data[:, names.index("energy.kinetic")].max(initial=0.0))),
    )
    events = tuple(sorted((*events, *jolt_events(run.jolts)), key=lambda event: event.t))
    notes += jolt_notes(run.jolts, run.table)
    if run.method == "moreau":
        impact = "; in the step of an impact a force is its impulse over the step"
        impacts = any(event.kind == "impact" for event in events)
        notes += (f"Moreau-Jean: peaks are the largest of its steps{impact if impacts else ''}",)
    if not run.message:
        notes += remarks(system, run.workspace, run.method)
    notes += loose(run.method, run.rtol) + fast_links(system, data, names)
    if series := int(tally[step_state.SERIES]):
        one = "an infinite series of bounces was" if series == 1 else f"{series} infinite series of bounces were"
        notes += (f"{one} closed: bounces that rise less than {LOW:g} clearances are counted as contact",)
    notes += run.remarks()
    owner = system.rows[tally[step_state.DRIFT_ROW]].owner if system.rows else ""
    trust = Trust(
        drift=float(seen[step_audit.LENGTH]),
        drift_angle=float(seen[step_audit.ANGLE]),
        energy_share=float(seen[step_audit.SHARE]),
        drift_joint=owner,
        energy_balance=float(np.abs(balance).max()) if n else math.nan,
        t_end=reached,
        horizon=reach.time if reach else None,
        horizon_motion=reach.motion if reach else None,
        horizon_curve=reach.first if reach else "",
        stopped=bool(run.message),
        pulled=pulled,
        first_pull=first,
        intervals=intervals,
        nonunique=nonunique,
        notes=notes,
        **contact_counts(system, events, float(clock[step_state.FEWEST])),
    )
    stats = {
        "steps": int(tally[step_state.STEPS]),
        "rejected": int(tally[step_state.REJECTED]),
        "evaluations": int(tally[step_state.EVALUATIONS]),
        "smallest_step": float(clock[step_state.H_MIN]) if tally[step_state.STEPS] else 0.0,
        "wall_time": run.wall,
        "contacts": int(tally[step_state.CONTACTS]),
        "switchings": run.piece + int(run.workspace.landing[TURNS]),
        "singular_positions_leapt": int(tally[step_state.LEAPS]),
    }
    provenance = {
        "model": system.model.name,
        "program": f"rattle {__version__}",
        "analysis": "simulate",
        "method": run.method,
        "rtol": run.rtol,
        "atol": run.atol,
        "step": run.step,
        "parameters": {name: one.value for name, one in system.model.parameters.items()},
    }
    return Result(
        t=t,
        data=data,
        names=names,
        units=units,
        geometry=geometry(system.model),
        trust=trust,
        stats=stats,
        provenance=provenance,
        success=not run.message,
        message=run.message,
        events=events,
        peaks=peak_values(system, run.workspace, reached - run.start.t),
    )
