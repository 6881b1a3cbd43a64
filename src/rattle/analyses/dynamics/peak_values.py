"""Peaks and mean squares of a run: the arrays that watch them within steps, and the values found."""

from __future__ import annotations

import math

import numpy as np

from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace
from rattle.results.columns import quantities
from rattle.results.event import Peak
from rattle.solvers.contacts.penetration import DEEP
from rattle.solvers.peaks import samples
from rattle.solvers.tableau import Tableau


def peak_arrays(system: System, tableau: Tableau | None, watch: bool) -> dict[str, np.ndarray]:
    """Workspace arrays with which a run watches its forces for peaks, see `solvers.peaks`; lengths in m.

    tableau: of the stepper of the run, None for one that is not explicit; watch: False if it need not.
    """
    watched = quantities(system) if watch else []
    table = np.zeros((len(watched), samples.width(tableau)))
    table[:, samples.BEST] = -math.inf
    for row, (arm, nothing) in zip(table, measures_of_peaks(system) if watch else (), strict=True):
        row[samples.ARM], row[samples.NOTHING] = arm, nothing
    return {
        "quantity": np.array([quantity[1:] for quantity in watched], np.int64).reshape(-1, 2),
        "peaks": table,
        "peak_row": np.zeros(at.PER_JOINT * len(system.joints)),
    }


def measures_of_peaks(system: System) -> list[tuple[float, float]]:
    """Arm [m] of every watched quantity that is a moment, and what counts as nothing of it [SI]; otherwise 0."""
    measures = []
    for name, *_ in quantities(system):
        joint, _, of = name.rpartition(".")
        contact = system.model.joints[joint].contact if joint in system.model.joints else None
        arm = nothing = 0.0
        if of == "moment" or (of == "stop" and system.model.joints[joint].stops_angle):
            arm = system.size
        elif of == "penetration" and contact is not None and contact.rigid:
            nothing = DEEP * (system.model.joints[joint].clearance or system.size)  # at a rigid wall it is only drift
        measures.append((arm, nothing))
    return measures


def peak_names(system: System) -> set[str]:
    """Names of what `peak_values` finds."""
    contacts = {
        f"{name}.normal"
        for name, joint in system.model.joints.items()
        if joint.contact is not None and not (joint.one_sided and joint.one_sided.records)
    }
    return {name for name, *_ in quantities(system)} | contacts


def peak_values(system: System, workspace: Workspace, span: float) -> dict[str, Peak]:
    """Largest absolute value [SI], its time [s] and RMS [SI] of every watched quantity in a run.

    span: time that counts in it [s].
    """
    peaks = {}
    for (name, *_), row in zip(quantities(system), workspace.peaks, strict=True):
        best, when, squares = (float(row[k]) for k in (samples.BEST, samples.WHEN, samples.SQUARES))
        best = best if best > -math.inf else math.nan  # no instant counts, as at the start in a singular position
        rms = math.sqrt(max(squares, 0.0) / span) if span > 0.0 else abs(best)
        peaks[name] = Peak(best, when, rms)
    for name, joint in system.model.joints.items():
        if joint.contact is not None and not (
            joint.one_sided and joint.one_sided.records
        ):  # without contacts N is as large as the force
            peaks.setdefault(f"{name}.normal", peaks[f"{name}.force"])
    return peaks
