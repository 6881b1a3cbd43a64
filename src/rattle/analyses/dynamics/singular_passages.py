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
    found = []
    count = int(workspace.passage[at.PASSED])
    for row, state in zip(workspace.passages[:count].tolist(), workspace.passage_states[:count].copy(), strict=True):
        t, _, since, until = row
        record(workspace, t, state, np.zeros(width(run.system)))
        found.append(Passage(t, joints_losing_rank(run.system, workspace, 10.0 * SINGULAR), since, until))
    return tuple(found)


def passage_notes(found: tuple[Passage, ...]) -> tuple[str, ...]:
    """What is said of them."""
    if not found:
        return ()
    joints = ", ".join(found[0].joints[:6])
    lose = f": constraints of {joints} lose rank" if joints else ""
    part = max(found, key=lambda one: one.until - one.since)
    what = "forces there are not determined, or grow without bound"
    if len(found) == 1:
        left = f"the table leaves out {_span(part.since, part.until)}"
        return (f"the run passes a singular position at t = {part.t:.4g} s{lose}; {what}, {left}",)
    when = ", ".join(f"{one.t:.4g}" for one in found[:NAMED])
    more = f" and {len(found) - NAMED} more times" if len(found) > NAMED else ""
    left = f"the table leaves out up to {0.5e3 * (part.until - part.since):.2g} ms on both sides"
    return (f"the run passes {len(found)} singular positions, at t = {when} s{more}{lose}; {what}, {left}",)


def _span(since: float, until: float) -> str:
    """An interval [s] with as many digits as tell its ends apart."""
    digits = 4
    while digits < 12 and f"{since:.{digits}g}" == f"{until:.{digits}g}":
        digits += 1
    return f"{since:.{digits}g} to {until:.{digits}g} s"
