"""Loads along the line between two points that coincide at rest: their force has no direction."""

from __future__ import annotations

import numpy as np

from rattle import registry
from rattle.equations.motion import drive, loads, place
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.jit.geometry import COINCIDENT, ends


def without_direction(system: System, t: float, q: np.ndarray, v: np.ndarray) -> list[str]:
    """Notes on such loads that would exert a force elsewhere; q, v: (3 nb,) positions and rates at t [s]."""
    model = system.model
    kinds = registry.kinds("load")
    along = [
        (n, name)
        for n, (name, load) in enumerate(model.loads.items())
        if (record := kinds[load.kind].leaf.record) is not None and record.coordinate == "length"
    ]
    if not along:
        return []
    workspace = system.workspace()
    place(workspace, q, v)
    drive(workspace, t)
    loads(workspace, t)
    names = []
    for n, name in along:
        entry = system.arrays["load"][n]
        a, b, p = (int(entry[column]) for column in (at.END_A, at.END_B, at.FIRST_P))
        *_, dx, dy, ddx, ddy = ends.python(workspace.body, a, b, workspace.values, p)
        force = float(workspace.signals[list(model.recorded).index(f"{name}.force")])
        if max(abs(dx), abs(dy), abs(ddx), abs(ddy)) < COINCIDENT and force != 0.0:
            names.append(f"'{name}'")
    if not names:
        return []
    of, their = ("loads", "their forces have") if len(names) > 1 else ("load", "its force has")
    return [
        f"the ends of {of} {', '.join(names)} coincide at the start: {their} no direction, and nothing is exerted until"
        " they part; give places apart in [initial]"
    ]
