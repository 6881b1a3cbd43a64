"""Singular positions that a run has passed: when, of which joints, and what its table leaves out."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from rattle.analyses.assembly.rank import joints_losing_rank
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace
from rattle.results.columns import width
from rattle.solvers.output_row import record
from rattle.solvers.singular_passage import SINGULAR, leave

NAMED = 3  # instants that are written out; of more only the number
SENTENCES = {  # of notes, also in pages
    "passes": "the run passes a singular position at t = {t:.4g} s{lose}; forces there are not determined, or grow"
    " without bound, the table leaves out {span}",
    "passes_many": "the run passes {count} singular positions, at t = {times} s{more}{lose}; forces there are not"
    " determined, or grow without bound, the table leaves out up to {half:.2g} ms on both sides",
    "throughout": "forces are left out: constraints are next to a singular position all the time, or masses of bodies"
    " differ by too many orders of magnitude (a link without weight takes mass = 0)",
    "lose": ": constraints of {joints} lose rank",
}


class Running(Protocol):
    """The attributes of a run that are used here."""

    system: System
    workspace: Workspace
    clock: np.ndarray


class Passage(NamedTuple):
    """One singular position that was passed."""

    t: float  # [s]
    joints: tuple[str, ...]  # joints and drivers whose constraints lose rank there
    since: float  # from here on forces have no part in peaks and mean squares [s]
    until: float  # until here [s]


def passages(run: Running) -> tuple[Passage, ...]:
    """All that were passed, as far as they were kept; peaks and sums of the run are settled before."""
    workspace = run.workspace
    if not len(workspace.passage):
        return ()
    leave(workspace, float(run.clock[at.T]))
    passed = []
    count = int(workspace.passage[at.PASSED])
    for row, state in zip(workspace.passages[:count].tolist(), workspace.passage_states[:count].copy(), strict=True):
        t, _, since, until = row
        record(workspace, t, state, np.zeros(width(run.system)))
        passed.append(Passage(t, joints_losing_rank(run.system, workspace, 10.0 * SINGULAR), since, until))
    return tuple(passed)


def passage_notes(passed: tuple[Passage, ...], start: float, end: float) -> tuple[str, ...]:
    """What is said of them, of a run from start to end [s]."""
    if not passed:
        return ()
    if any(passage.since <= start and passage.until >= end for passage in passed):
        return (SENTENCES["throughout"],)
    joints = ", ".join(passed[0].joints[:6])
    lose = SENTENCES["lose"].format(joints=joints) if joints else ""
    part = max(passed, key=lambda passage: passage.until - passage.since)
    if len(passed) == 1:
        return (SENTENCES["passes"].format(t=part.t, lose=lose, span=_span(part.since, part.until)),)
    when = ", ".join(f"{passage.t:.4g}" for passage in passed[:NAMED])
    more = f" and {len(passed) - NAMED} more times" if len(passed) > NAMED else ""
    half = 0.5e3 * (part.until - part.since)
    return (SENTENCES["passes_many"].format(count=len(passed), times=when, more=more, lose=lose, half=half),)


def _span(since: float, until: float) -> str:
    """An interval [s] with as many digits as tell its ends apart."""
    digits = 4
    while digits < 12 and f"{since:.{digits}g}" == f"{until:.{digits}g}":
        digits += 1
    return f"{since:.{digits}g} to {until:.{digits}g} s"
