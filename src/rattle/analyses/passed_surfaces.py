"""What a motion that is given has to say about rigid surfaces, which do not act there: bodies may go through them."""

from __future__ import annotations

import numpy as np

from rattle.analyses.travel import BEYOND, farthest, followed
from rattle.equations.closure import open_by
from rattle.equations.compliant import locate_contacts
from rattle.equations.system import System
from rattle.jit import layout as at


def past_surfaces(system: System, t: np.ndarray, q: np.ndarray, v: np.ndarray) -> tuple[str, ...]:
    """Notes on rigid surfaces that bodies go into, by the order of joints.

    t: (n,) [s].  q, v: (n, nb, 3) positions [m, m, rad] of all bodies and their rates.  Between instants a gap is the
    cubic with its rates; a corner is looked at where it is over its segment, at the instants that are given.
    """
    contact, lever = system.arrays["contact"], system.arrays["lever"]
    joints = [system.model.joints[system.joints[entry[at.OWNER]]] for entry in contact]
    rigid = [n for n, joint in enumerate(joints) if joint.leaf.touches and contact[n][at.IMPACT] == 1]
    if not rigid or not len(t):
        return ()
    rows = _gaps(system, t, q, v, rigid)
    worst: dict[str, tuple[float, float]] = {}  # of a joint: the greatest depth [m], and when it first goes in [s]
    for k, n in enumerate(rigid):
        slight = BEYOND * (float(lever[n][at.GAP_SCALE]) + system.size)
        if lever[n][at.ONE_WAY] and rows[:, k, at.ABOVE].any():  # a corner over a segment, no end at an edge
            depth, since = _one_way(t, rows[:, k], slight)
        else:
            fine, gaps = followed(t, rows[:, k, at.GAP], rows[:, k, at.DGAP])
            depth, since = farthest(fine, -gaps, slight)
        name = joints[n].name
        if depth > slight:
            deepest, first = worst.get(name, (depth, since))
            worst[name] = max(depth, deepest), min(since, first)
    return tuple(
        f"joint '{name}': its bodies go into each other, by up to {depth:.3g} m, first at t = {since:.4g} s: rigid"
        " surfaces act in runs in time and in equilibria only"
        for name, (depth, since) in worst.items()
    )


def _gaps(system: System, t: np.ndarray, q: np.ndarray, v: np.ndarray, contacts: list[int]) -> np.ndarray:
    """Geometry (n, contacts, columns) of these contacts at all instants."""
    workspace = system.workspace()
    rows = np.empty((len(t), len(contacts), workspace.contact_kinematics.shape[1]))
    for k, instant in enumerate(t):
        open_by(workspace, float(instant), q[k].ravel().copy(), v[k].ravel().copy())
        locate_contacts(workspace)
        rows[k] = workspace.contact_kinematics[contacts]
    return rows


def _one_way(t: np.ndarray, rows: np.ndarray, slight: float) -> tuple[float, float]:
    """The greatest depth [m] of a corner below its segment, and since when [s]: in from above, out beyond its ends."""
    above, over = rows[:, at.ABOVE], rows[:, at.BEYOND] <= 0.0
    depth, since, inside = 0.0, 0.0, False
    for k in range(1, len(t)):
        enters = over[k - 1] and above[k - 1] >= -slight
        inside = bool(over[k] and above[k] < -slight and (inside or enters))
        if inside:
            since = float(t[k]) if depth == 0.0 else since
            depth = max(depth, -float(above[k]))
    return depth, since
