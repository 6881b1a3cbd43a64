"""A run as bytes: the arrays of its workspace before its first step, and a description of them as JSON.

`pages/viewer/core.js` lays them out in the memory of an engine and takes the steps that `analyses.dynamics.run` would
take.  Kernels of tables are given by name: an engine says what stands for each.  A description belongs to one layout
of workspaces; an engine of another one refuses it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from rattle.analyses.dynamics.events import event_owners
from rattle.analyses.dynamics.methods import choose_stepper, new_run
from rattle.analyses.dynamics.run import How, Run
from rattle.analyses.dynamics.simulate import output_times
from rattle.equations.contact_table import CONTACT_TABLES
from rattle.equations.system import System
from rattle.errors import InputError
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.jit.wasm.engine import layout
from rattle.jit.workspace import ARRAYS, Workspace
from rattle.mechanism import Mechanism
from rattle.solvers.stepper import ATOL, RTOL

TABLE = "_table"  # ending of arrays that hold kernels


class RunImage(NamedTuple):
    """A run that has not begun."""

    description: dict[str, Any]
    content: bytes


def planned_run(m: Mechanism, t_end: float | None = None, method: str | None = None, step: float | None = None) -> Run:
    """The run that `simulate` would make, from the start of the mechanism to t_end [s].  step: the longest one [s]."""
    system, settings = m.system, m.system.model.settings
    end, times = output_times(settings, t_end, None)
    rtol = settings.rtol or RTOL
    stepper, step = choose_stepper(system, method or settings.method, step or settings.step, end)
    return new_run(system, m.start, times, end, How(stepper, rtol, settings.atol or ATOL * rtol, step))


def run_image(run: Run) -> RunImage:
    """A run before its first step as bytes.  Raises InputError for laws in Python, which no page can call."""
    content, owners = Content(), event_owners(run.system)
    return RunImage(
        {
            **workspace_image(run.system, run.workspace, content),
            "times": _times(run.t_eval, content),
            "width": run.raw.shape[1],
            "more": {"shaken": ["f2", -1, 2, run.raw.shape[1]]},  # rows of a state and of one beside it
            "loop": run.stepper.leaf.loop,
            "start": run.start.t,
            "end": run.t_end,
            "rtol": run.rtol,
            "atol": run.atol,
            "step": run.step,
            "extent": run.system.extent,
            "owners": [name for name, _ in owners],
            "labels": [label for _, label in owners],
        },
        bytes(content.written),
    )


def _times(times: np.ndarray, content: Content) -> list[Any]:
    """How many times, and where they stand; -1 and the last for equal steps from 0 on, which take no bytes."""
    count, last = len(times), float(times[-1])
    if np.array_equal(times, np.linspace(0.0, last, count)):
        return [count, -1, last]
    return [count, content.add(times)]


def workspace_image(system: System, workspace: Workspace, content: Content) -> dict[str, Any]:
    """What a description says of the arrays of a workspace, which are added to the content.

    Raises InputError for laws in Python, which no page can call.
    """
    arrays, tables = [], {}
    named, used = functions.names_in_tables(), _used(system)
    for name in ARRAYS:
        array = getattr(workspace, name)
        if name.endswith(TABLE):
            entries = array if isinstance(array, tuple) else array.tolist()
            called = used.get(name, range(len(entries)))
            tables[name] = [_kernel(entry, named) if n in called else None for n, entry in enumerate(entries)]
            arrays.append([len(array), -1])
        else:
            arrays.append([*array.shape, content.add(array)])
    return {"layout": layout(), "arrays": arrays, "tables": tables}


class Content:
    """Bytes to which arrays are added, each at a multiple of eight."""

    def __init__(self) -> None:
        self.written = bytearray()

    def add(self, array: np.ndarray) -> int:
        """Where an array stands; -1 for one that begins with zeros alone, which takes no bytes."""
        if not array.view(np.int64).any():
            return -1
        self.written += np.ascontiguousarray(array).tobytes()
        return len(self.written) - array.nbytes


def _used(system: System) -> dict[str, set[int]]:
    """The kernels that the model calls, by table: others stand in it only where they run as plain Python."""
    joint, load, contact, dry = (system.arrays[name] for name in ("joint", "load", "contact", "dry"))
    kernels = {name: set(contact[:, column].tolist()) for name, (_, column) in CONTACT_TABLES.items()}
    kernels["friction_table"] |= set(dry[:, at.DRY_LAW].tolist())
    joints = {*joint[:, at.KERNEL].tolist(), *dry[:, at.DRY_KERNEL].tolist()}
    return {**kernels, "joint_table": joints, "load_table": set(load[:, at.KERNEL].tolist())}


def _kernel(entry: int | Callable[..., Any], names: dict[Any, str]) -> str | None:
    """The name of a kernel in a table; None if there is none."""
    if entry == 0:
        return None
    if entry not in names:
        raise InputError("a law in Python cannot be computed in a page or program")
    return names[entry]
