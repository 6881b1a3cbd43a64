"""What every load, and gravity, exerts on the bodies at one instant."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rattle.equations.motion import fall, loads, place
from rattle.equations.system import System
from rattle.jit import layout as at


def load_forces(system: System, t: float, q: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
    """Force [N] and moment about the mass centre [N*m], (nb + 1, 3) with the ground first, of every load by name.

    t [s]; q, v: (3 nb,) positions and rates.
    """
    forces = {}
    for n, name in enumerate(system.model.loads):
        arrays = {**system.arrays, "gravity": np.zeros(2), "contact": system.arrays["contact"][:0]}
        arrays["load"], arrays["falling"] = system.arrays["load"][n : n + 1], system.arrays["falling"][:0]
        workspace = replace(system, arrays=arrays).workspace()
        place(workspace, q, v)
        loads(workspace, t)
        forces[name] = workspace.force.copy()
    return forces


def gravity_over(system: System, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gravity (n, 2) [m/s^2] at the times t (n,) [s], and its rates."""
    if system.model.falling is None:
        return np.tile(system.arrays["gravity"], (len(t), 1)), np.zeros((len(t), 2))
    workspace, slots = system.workspace(), system.arrays["falling"][:, at.TARGET]
    gravity, change = np.zeros((2, len(t), 2))
    for k, instant in enumerate(t):
        fall(workspace, float(instant))
        gravity[k], change[k] = workspace.values[slots], workspace.values[slots + 1]
    return gravity, change
