"""Messages on expressions and laws without a finite value."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rattle.elements.custom import contact_law, load_law
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace
from rattle.language.table_limits import left_table


def undefined(system: System, workspace: Workspace, t: float, contacts: bool = True) -> str:
    """The expression or law that has no finite value at time t [s], in words; "" if all have.

    The workspace must have been evaluated at t.  Laws written in Python are run again as plain Python to find what
    they raise.  contacts: check contact laws too.
    """
    for first, values in evaluated(system, workspace):
        if not np.isfinite(values).all():
            name = system.live_names[system.program_starts.index(first)]
            if left := left_a_table(system, workspace, first, t):
                return f"{name} has no value at t = {t:.6g} s: {left}"
            seen = values[~np.isfinite(values)][0]
            return (
                f"{name} has no finite value at t = {t:.6g} s ({seen:g}); check its domain"
                " (square root, logarithm, division by zero)"
            )
    for (name, load), row in zip(system.model.loads.items(), system.arrays["load"], strict=True):
        why = load_law.failure(load.kind, t, workspace.body, row, workspace.values)
        if why:
            return f"loads.{name}: {why}"
    for n, row in enumerate(system.arrays["contact"] if contacts else ()):
        kinematics, memory = workspace.contact_kinematics[n], workspace.contact_memory[n]
        why = contact_law.failure(row, kinematics, memory, workspace.element_state, workspace.values)
        if why:
            return f"joint '{system.joints[row[at.OWNER]]}': {why} at t = {t:.6g} s"
    return ""


def left_a_table(system: System, workspace: Workspace, first: int, t: float) -> str:
    """Which table is left at time t [s] by the expression whose program begins at row `first`, in words; "" if none."""
    if not system.model.tables.curves:
        return ""
    place = system.program_starts.index(first)
    last = [*system.program_starts, len(system.arrays["code"])][place + 1]
    signals = workspace.signals.copy()
    for _, _, k in system.arrays["jet_signal"]:
        signals[k] = workspace.jets[k, 0]
    code, const = workspace.code, system.arrays["const"]
    return left_table(code, const, first, last, t, workspace.body, signals, system.model.tables)


def driver_left_a_table(system: System, workspace: Workspace, driver: str, t: float) -> str:
    """Which table the function of a driver leaves at time t [s], in words; "" if none."""
    slot = system.driver_slot(driver)
    for first, _, place, _ in system.arrays["jet"]:
        if place == slot and (left := left_a_table(system, workspace, int(first), t)):
            return f"driver '{driver}' has no value at t = {t:.6g} s: {left}"
    return ""


def evaluated(system: System, workspace: Workspace) -> Iterator[tuple[int, np.ndarray]]:
    """First row in `code`, and present values [SI], of every expression."""
    where = {"jet_signal": ("jets", 0), "jet": ("values", 3), "signal": ("signals", 1), "live": ("values", 1)}
    where |= {"state_rate": ("element_rate", 1), "falling": ("values", 3)}
    for table, (array, count) in where.items():
        for first, _, place, *_ in system.arrays[table]:
            values = getattr(workspace, array)
            present = values[place] if count == 0 else values[place : place + count]
            yield int(first), np.atleast_1d(present)
