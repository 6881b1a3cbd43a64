"""What a motion that is given has to say about rigid surfaces, which do not act there: bodies may go through them."""

from __future__ import annotations

import numpy as np

from rattle.analyses.travel import BEYOND, followed
from rattle.equations.closure import open_by
from rattle.equations.compliant import locate_contacts
from rattle.equations.system import System
from rattle.jit import layout as at


def past_surfaces(system: System, t: np.ndarray, q: np.ndarray, v: np.ndarray) -> tuple[str, ...]:
    """Notes on rigid surfaces that bodies go into, by the order of joints.

    t: (n,) [s].  q, v: (n, nb, 3) positions [m, m, rad] of all bodies and their rates.  Between instants a gap is the
    cubic with its rates; what bears on one side only is looked at where it is over a segment.
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
        depth, since = _one_way(t, rows[:, k], slight) if lever[n][at.ONE_WAY] else _deepest(t, rows[:, k], slight)
        name = joints[n].name
        if depth > slight:
            deeper, before = worst.get(name, (depth, since))
            worst[name] = max(depth, deeper), min(since, before)
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


def _deepest(t: np.ndarray, rows: np.ndarray, slight: float) -> tuple[float, float]:
    """The greatest depth [m] of a contact, and the instant [s] from which on it is deeper than `slight`."""
    fine, gaps = followed(t, rows[:, at.GAP], rows[:, at.DGAP])
    deep = np.flatnonzero(-gaps > slight)
    if not len(deep):
        return 0.0, 0.0
    first = int(deep[0])
    since = float(fine[first])
    if first > 0 and gaps[first - 1] > 0.0:
        since -= float((fine[first] - fine[first - 1]) * gaps[first] / (gaps[first] - gaps[first - 1]))
    return float(np.nanmax(-gaps)), since


def _one_way(t: np.ndarray, rows: np.ndarray, slight: float) -> tuple[float, float]:
    """The same of a corner over a segment: it goes in from above, and is in as long as it is over it."""
    above, over = rows[:, at.ABOVE], rows[:, at.BEYOND] <= 0.0
    depth, since, inside = 0.0, 0.0, False
    for k in range(1, len(t)):
        enters = over[k - 1] and above[k - 1] >= -slight
        inside = bool(over[k] and above[k] < -slight and (inside or enters))
        if inside:
            since = float(t[k]) if depth == 0.0 else since
            depth = max(depth, -float(above[k]))
    return depth, since
