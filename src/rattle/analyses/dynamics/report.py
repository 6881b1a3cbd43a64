"""The result of a run: its curves, how far they can be trusted, what happened, and what it took."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from rattle.analyses.assembly.rank import left_null, nonunique_reactions, unsure_friction
from rattle.analyses.dynamics.events import contact_counts, contact_events, contact_notes
from rattle.analyses.dynamics.horizon import Reach
from rattle.analyses.dynamics.oil_notes import oil_notes
from rattle.analyses.dynamics.peak_values import peak_values
from rattle.analyses.dynamics.run import Run, pulls, start_state
from rattle.analyses.dynamics.singular_passages import Passage, passage_notes, passages
from rattle.analyses.dynamics.soundness import energy_share, fast_links, loose, remarks
from rattle.analyses.grip import grip_notes
from rattle.analyses.timetable import jolt_events, jolt_notes
from rattle.analyses.travel import out_of_place, places
from rattle.equations.contact_table import contact_labels
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace
from rattle.results.build import build_result
from rattle.results.columns import columns, reaction_columns, width
from rattle.results.contact_summary import unread
from rattle.results.event import Breaks, Event
from rattle.results.result import Result
from rattle.results.trust import Trust
from rattle.solvers.nonsmooth.impacts import LOW
from rattle.solvers.output_row import record
from rattle.value_types import Json

SENTENCES = {  # of notes, also in pages
    "many_breaks": "so many events that the values on both sides of each are not kept: integrals, means and extremes of"
    " rates are taken from the outputs alone; simulate a shorter time for them",
    "lost_rank": "the run passed a singular position, in which the constraints are not independent",
    "series": "{count} closed: bounces that rise less than {low:g} of the play (without play: of the range or size), or"
    " less than rounding, are counted as contact",
    "one_series": "an infinite series of bounces was",
    "more_series": "{count} infinite series of bounces were",
    "held_friction": "{joints}: friction in a joint that the others keep from moving is not unique; 0 is listed"
    " meanwhile",
    "left_ends": "{joints}: a corner has left the end of its segment; what is between the corners does not bear there,"
    " the edges of a plate do with outline = true",
}


def report(run: Run, reach: Reach | None) -> Result:
    """The result of a run that has ended; reach: the times [s] up to which a tighter run agrees."""
    system = run.system
    n = int(run.tally[at.OUTPUTS])
    data, names, units = columns(system, run.raw[:n])
    curve = {name: data[:, names.index(f"energy.{name}")] for name in ("kinetic", "balance")}
    reached = float(run.clock[at.T])
    passed = passages(run)
    nonunique, singular = _nonunique(run)
    singular = passage_notes(passed, run.start.t, reached) or singular
    contacts = contact_events(system, run.contacts, run.workspace, reached)
    notes = (
        *run.start.notes,
        *singular,
        *run.notes,
        *contact_notes(system, contacts, float(curve["kinetic"].max(initial=0.0))),
        *oil_notes(system, data, names),
        *jolt_notes(run.jolts, run.table),
        *((SENTENCES["many_breaks"],) if run.room < 0 else ()),
        *run.about_peaks(any(event.kind == "impact" for event in contacts)),
        *(() if run.message else remarks(system, run.workspace, run.stepper.leaf)),
        *loose(run.stepper.leaf, run.rtol),
        *fast_links(system, data, names),
        *out_of_place(system, run.t_eval[:n], places(system, run.raw[:n])),
        *grip_notes(system, run.t_eval[:n], places(system, run.raw[:n]), data, names),
        *_series_notes(run),
        *_unsure_friction(run),
        *_left_ends(run),
        *run.remarks(),
    )
    balance = float(np.abs(curve["balance"]).max()) if n else math.nan
    leave_out(system, passed, run.t_eval[:n], data, units)
    counted = reached - run.start.t - sum(passage.until - passage.since for passage in passed)
    result = build_result(
        system.model, "simulate", t=run.t_eval[:n], data=data, names=names, units=units,
        trust=_trust(run, reach, contacts, balance, nonunique, notes, passed), stats=_stats(run), message=run.message,
        settings={"method": run.stepper.name, "rtol": run.rtol, "atol": run.atol, "step": run.step,
                  "t_end": run.t_end},
        events=sorted((*contacts, *jolt_events(run.jolts)), key=lambda event: event.t),
        peaks=peak_values(system, run.workspace, counted),
        breaks=_breaks(run, passed),
    )  # fmt: skip
    result.trust = replace(result.trust, unread=unread(result))
    return result


def _breaks(run: Run, passed: tuple[Passage, ...]) -> Breaks | None:
    """Values on both sides of all events; None if there are none or too many."""
    if not run.breaks:
        return None
    times, rows = (np.concatenate(parts) for parts in zip(*run.breaks, strict=True))
    data, _, units = columns(run.system, rows)
    leave_out(run.system, passed, times, data, units)
    return Breaks(times, data)


def leave_out(
    system: System, passed: tuple[Passage, ...], t: np.ndarray, data: np.ndarray, units: Mapping[str, str]
) -> None:
    """Forces, moments and powers of joints and drivers become nan where they have no part in peaks.

    t (n,) [s], data (n, k) [SI], units: of its columns, by name.
    """
    hidden = np.zeros(len(t), bool)
    for passage in passed:
        hidden |= (t >= passage.since) & (t <= passage.until)
    if hidden.any():
        data[hidden[:, None] & reaction_columns(system, units)] = math.nan


def _nonunique(run: Run) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Joints whose reactions are not unique at the start; otherwise a note if constraints become dependent later."""
    system = run.system
    if not run.tally[at.LOST_ROWS]:
        return (), ()
    record(run.workspace, run.start.t, start_state(system, run.start), np.zeros(width(system)))
    nonunique, note = nonunique_at_start(system, run.workspace)
    return nonunique, note if nonunique else (SENTENCES["lost_rank"],)


def nonunique_at_start(system: System, workspace: Workspace) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Joints whose reactions are not unique in the recorded position, and a note where the motion depends on them."""
    nonunique = nonunique_reactions(system, workspace)
    return nonunique, _friction_note(unsure_friction(system, left_null(system, workspace))) if nonunique else ()


def _friction_note(joints: tuple[str, ...]) -> tuple[str, ...]:
    """That the motion depends on reactions that are not unique, by the friction of joints."""
    if not joints:
        return ()
    words = f"{', '.join(joints)}: friction by a reaction that is not unique, so neither is the motion"
    return (f"{words}; replace a joint by one that holds less",)


def _unsure_friction(run: Run) -> tuple[str, ...]:
    """Note on friction of joints that were held at rest by others, so that the motion does not tell what it holds."""
    unsure = run.workspace.dry_memory[:, at.DRY_UNSURE] == 1.0
    names = ", ".join(name for name, held in zip(run.system.dry_joints, unsure, strict=True) if held)
    if not names:
        return ()
    return (SENTENCES["held_friction"].format(joints=names),)


def cornered_surfaces(system: System) -> list[str]:
    """Names of surfaces on which named corners of a body bear, and not its edges."""
    joints = system.model.joints.items()
    return [name for name, joint in joints if joint.leaf.touches and not joint.fields["outline"]]


def _left_ends(run: Run) -> tuple[str, ...]:
    """Note on corners that have passed the end of their segment while others of the body bear."""
    left = run.workspace.contact_memory[:, at.LEFT_END] == 1.0
    owners, cornered = zip(contact_labels(run.system.model), left, strict=True), cornered_surfaces(run.system)
    names = dict.fromkeys(name for (name, label), passed in owners if passed and label and name in cornered)
    return (SENTENCES["left_ends"].format(joints=", ".join(names)),) if names else ()


def _series_notes(run: Run) -> tuple[str, ...]:
    """Note on infinite series of bounces."""
    series = int(run.tally[at.SERIES])
    if not series:
        return ()
    count = SENTENCES["one_series" if series == 1 else "more_series"].format(count=series)
    return (SENTENCES["series"].format(count=count, low=LOW),)


def _trust(
    run: Run, reach: Reach | None, contacts: tuple[Event, ...], balance: float, nonunique: tuple[str, ...],
    notes: tuple[str, ...], passed: tuple[Passage, ...],
) -> Trust:  # fmt: skip
    """How far the result can be trusted; balance: largest unexplained change of energy [J]."""
    system, clock, tally, seen = run.system, run.clock, run.tally, run.workspace.audit
    pulled, first, intervals = pulls(run, float(clock[at.T]))
    joint, lock = run.locked() or ("", math.inf)
    ends = reach is not None and lock < min(reach.time, float(clock[at.T]))
    return Trust(
        drift=float(seen[at.OPEN_LENGTH]),
        drift_angle=float(seen[at.OPEN_ANGLE]),
        energy_share=energy_share(seen),
        drift_joint=system.rows[tally[at.DRIFT_ROW]].owner if system.rows else "",
        energy_balance=balance,
        t_end=float(clock[at.T]),
        horizon=min(reach.time, lock) if reach else None,
        horizon_motion=min(reach.motion, lock) if reach else None,
        horizon_curve=reach.first if reach else "",
        locked=joint if ends else "",
        stopped=bool(run.message),
        pulled=pulled,
        first_pull=first,
        intervals=intervals,
        nonunique=nonunique,
        singular=tuple(passage.t for passage in passed),
        gaps=tuple((passage.since, passage.until) for passage in passed),
        notes=notes,
        **contact_counts(system, contacts, float(clock[at.FEWEST])),
    )


def _stats(run: Run) -> dict[str, Json]:
    """What the run took."""
    clock, tally = run.clock, run.tally
    return {
        "steps": int(tally[at.STEPS]),
        "rejected": int(tally[at.REJECTED]),
        "evaluations": int(tally[at.EVALUATIONS]),
        "smallest_step": float(clock[at.H_MIN]) if tally[at.STEPS] else 0.0,
        "wall_time": run.wall,
        "contacts": int(tally[at.CONTACTS]),
        "switchings": run.piece + int(run.workspace.landing[at.TURNS]),
        "singular_positions_leapt": int(tally[at.LEAPS]),
    }
