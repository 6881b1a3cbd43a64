"""On which branch a start near another one is, by how far given positions are from it."""

from __future__ import annotations

import numpy as np

from rattle.analyses.assembly.rank import RANK, scaled_rows
from rattle.analyses.assembly.tied_bodies import groups_at
from rattle.description.model import GROUND
from rattle.equations.closure import open_by
from rattle.equations.start_search import KEPT, WORTH
from rattle.equations.system import System
from rattle.jit.workspace import Workspace

ALONE = 10.0  # bending of closed positions, about 2, with room for what is not counted


def as_near(change: float) -> float:
    """Squared change of given positions up to which they lead to the branch of a start that changes them by this."""
    return max(KEPT, WORTH * change)


def alone_within(system: System, workspace: Workspace, q: np.ndarray) -> float:
    """Change of given positions [rad, sizes] up to which no closed positions but those near q (3 nb,) are as near.

    0 if nothing is known.  Where all angles are given or driven, and places follow from angles, those would be near q;
    and near q there is one sheet of closed positions only, as it bends by about 1 / sigma, the least singular value of
    the constraints that is not zero.
    """
    if not system.fact("angles known", lambda: _angles_known(system)):
        return 0.0
    open_by(workspace, 0.0, q, np.zeros_like(q))
    values = np.linalg.svd(scaled_rows(system, workspace), compute_uv=False)
    least = float(values[values > RANK * values[0]].min(initial=values[0]))
    return min(1.0, least) / ALONE


def _angles_known(system: System) -> bool:
    """True if the angle of every body is given, or tied by joints and drivers to one that is, or to the ground.

    And if the joints are linear in the places of the bodies.
    """
    if not all(joint.places and joint.distance == 0.0 for joint in system.model.joints.values()):
        return False
    groups = groups_at(system, 0.0)
    bodies = system.model.initial.bodies
    determined = {groups[GROUND][0], *(groups[name][0] for name, values in bodies.items() if "angle" in values)}
    return all(group in determined for group, _ in groups.values())
