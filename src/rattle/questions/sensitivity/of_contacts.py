"""What is asked of single contacts, and whether a motion with derivatives goes through those of a run without."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from rattle.analyses.dynamics.simulate import simulate
from rattle.analyses.straight_line.recorded_model import RecordedModel
from rattle.equations.system import System
from rattle.errors import InputError, TraceError
from rattle.language.syntax import Name
from rattle.questions.sensitivity.contacts import ContactMotion
from rattle.questions.sensitivity.events import Met
from rattle.results.columns import geometry
from rattle.results.event import Event
from rattle.results.reductions import OF_CONTACT, Known, Reduction, meetings, read
from rattle.results.result import Result

SAME = 1e-6  # share by which start and instants may differ from those of a run without derivatives
NOTICED = 1e-3  # share of the fastest contact below which contacts are not compared
PARTING = 1e-3  # share of a run by which the same contact of two runs of a chaotic motion may differ


def contacts_in(system: System, outputs: Sequence[str], analysis: str) -> dict[str, Reduction]:
    """Outputs that are the time, the speed or the largest force of one contact.  Raises InputError, ModelError."""
    of_contacts: dict[str, Reduction] = {}
    for text in outputs:
        word = text.partition("(")[0].strip()
        if word == "count":
            raise InputError(f"{text!r}: a number of contacts has no derivative: it jumps")
        if word not in OF_CONTACT or "(" not in text:
            continue
        if analysis != "simulate":
            raise InputError(f"{text!r}: contacts begin in a run in time (simulate), not in {analysis}")
        if text.rstrip().endswith(")") and text.count("(") == 1:
            of_contacts[text] = read(text, Known({}, {}, meetings(geometry(system.model)))).reductions[0]
    return of_contacts


# ---------------------------------------------------------------- the same motion
def require_same_start(model: RecordedModel, y: np.ndarray) -> None:
    """Raise TraceError unless positions and rates are those with which a run starts."""
    nq, want = 3 * model.system.body_count, model.start_state
    for part in (slice(0, nq), slice(nq, 2 * nq)):
        scale = max(1.0, float(np.abs(want[part]).max(initial=0.0)))
        if (np.abs(y[part] - want[part]) > SAME * scale).any():
            raise TraceError(
                "no sensitivities: how the start changes with the parameters is not determined by [initial]; give the"
                " rates of the bodies, or let pins with play start in the middle"
            )


def require_same_contacts(model: RecordedModel, run: ContactMotion, reach: float, rtol: float, atol: float) -> None:
    """Raise TraceError unless the contacts of a run without derivatives begin at the same instants.

    reach: instant up to which errors of the run are small [s].
    """
    end = float(run.t)
    # contacts at their instants, also where the model says a method of equal steps
    method = "event" if run.touching.are.rigid.any() else "dop853"
    alone = simulate(model.system, model.start, t_end=end, t_eval=[0.0, end], method=method, rtol=rtol, atol=atol)
    if not (alone.success or run.message):
        raise TraceError(f"no sensitivities: a run without derivatives does not come to its end: {alone.message}")
    if run.touching.rubbing is not None and reach >= end:
        _require_same_end(model, run, alone)
    begins = _begins(run, alone)
    noticed = NOTICED * max((event.normal_speed for event in begins), default=0.0)
    last = min(reach, (1.0 - SAME) * end, run.grazed)
    for n, event in enumerate(begins):
        if event.t > last:
            return
        if event.kind == "impact" and event.normal_speed < noticed:
            continue
        apart = _apart(event, run.met[n]) if n < len(run.met) else math.inf
        if SAME * end < apart < PARTING * end:  # runs that were the same part: from here on errors are large
            return
        if apart > SAME * end:
            raise TraceError(
                f"no sensitivities: contact {n + 1}, in {event.joint} at t = {event.t:.6g} s, is missed; a smaller rtol"
                " may help"
            )


def _require_same_end(model: RecordedModel, run: ContactMotion, alone: Result) -> None:
    """Raise TraceError unless a run without derivatives, in which joints stick and slip, ends at the same place."""
    names = [f"{body}.{part}" for body in model.system.bodies for part in ("x", "y", "angle")]
    want, got = np.array([alone[name][-1] for name in names]), run.z[: len(names), 0]
    if (np.abs(got - want) > SAME * max(1.0, float(np.abs(want).max(initial=0.0)))).any():
        raise TraceError(
            "no sensitivities: joints stick and slip otherwise than in a run without derivatives; compare two runs with"
            " set()"
        )


def _begins(run: ContactMotion, alone: Result) -> list[Event]:
    """Begins of contacts in a run without derivatives; a rigid one that stays shut has begun by an impact."""
    are = run.touching.are
    rigid = {joint for joint, is_rigid in zip(are.joints, are.rigid, strict=True) if is_rigid}
    locks = {(e.joint, e.t) for e in alone.events if e.kind == "lock"}
    return [
        e
        for e in alone.events
        if (e.kind == "impact" and (e.joint, e.t) not in locks)
        or e.kind == "lock"
        or (e.kind == "contact" and e.joint not in rigid)
    ]


def _apart(event: Event, met: Met) -> float:
    """Between both instants [s]; inf where they are of two joints."""
    return abs(met.time - event.t) if met.joint == event.joint else math.inf


# ---------------------------------------------------------------- the answer
def with_contacts(
    outputs: Sequence[str], of_contacts: Mapping[str, Reduction], run: ContactMotion, reach: float,
    curves: Mapping[str, tuple[np.ndarray, np.ndarray]],
) -> tuple[np.ndarray, np.ndarray, list[str]]:  # fmt: skip
    """Values (n, nc) and derivatives (n, nc, k) of all outputs in their order, and notes on what has none.

    curves: values (n,) and derivatives (n, k) of the other outputs; those of contacts are the same at every instant.
    There are no derivatives from a grazing contact on, nor beyond the horizon `reach` [s].
    """
    n, k = len(run.values), run.z.shape[1] - 1
    last = min(run.grazed, reach if reach < run.t else math.inf)
    values, slopes = np.full((n, len(outputs)), np.nan), np.full((n, len(outputs), k), np.nan)
    notes = list(run.notes)
    for column, name in enumerate(outputs):
        if name in curves:
            values[:, column], slopes[:, column] = curves[name]
            slopes[run.t_eval[:n] >= last, column] = np.nan
            continue
        reduction = of_contacts[name]
        joint = reduction.inner.name.rpartition(".")[0] if isinstance(reduction.inner, Name) else ""
        of_joint = [met for met in run.met if met.joint == joint]
        if len(of_joint) < reduction.number:
            ends = "is not known: derivatives end at" if run.message else "does not come until"
            notes.append(f"{name} {ends} t = {run.t:.6g} s")
            continue
        met = of_joint[reduction.number - 1]
        values[:, column] = getattr(met, reduction.kind)
        slopes[:, column] = getattr(met, f"by_{reduction.kind}") if met.time < last else np.nan
    if reach < run.t:
        notes.append(
            f"beyond the horizon, t = {reach:.3g} s, derivatives of a chaotic motion say nothing and are left out;"
            " an ensemble has the means of numbers there, and m.ensemble(...).slopes(...) how they change"
        )
    return values, slopes, notes
