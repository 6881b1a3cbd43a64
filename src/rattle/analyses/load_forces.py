"""What every load exerts on the bodies at one instant."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rattle.equations.motion import loads, place
from rattle.equations.system import System


def load_forces(system: System, t: float, q: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
    """Force [N] and moment about the mass centre [N*m], (nb + 1, 3) with the ground first, of every load by name.

    t [s]; q, v: (3 nb,) positions and rates.
    """
    forces = {}
    for n, name in enumerate(system.model.loads):
        arrays = {**system.arrays, "gravity": np.zeros(2), "contact": system.arrays["contact"][:0]}
        arrays["load"] = system.arrays["load"][n : n + 1]
        workspace = replace(system, arrays=arrays).workspace()
        place(workspace, q, v)
        loads(workspace, t)
        forces[name] = workspace.force.copy()
    return forces
