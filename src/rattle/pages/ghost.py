"""The ghost of a motion: the same mechanism without play, at the same instants."""

from __future__ import annotations

from rattle.errors import AssemblyError, ModelError
from rattle.loading import loads
from rattle.pages.scene import MOST_ROWS
from rattle.pages.thinning import shared_rows
from rattle.results.result import Result

IN_TIME = ("simulate", "orbit")  # analyses whose instants are times of the drivers


def ghost_of(result: Result) -> Result | None:
    """Motion without play of the mechanism of a result, from the model that it holds.

    None where there is no play, or where drivers do not determine the motion without it: then it would be a motion of
    its own, which parts from this one, and no reference.
    """
    joints = result.geometry["joints"].values()
    loose = [joint for joint in joints if joint["clearance"] > 0.0 and joint["contact"] != "ideal"]
    if not loose or result.provenance.get("analysis") not in IN_TIME or "document" not in result.provenance:
        return None
    try:
        ideal = loads(str(result.provenance["document"])).ideal()
        ghost = ideal.kinematics(result.t[shared_rows(result, MOST_ROWS)])
    except (AssemblyError, ModelError):
        return None
    return ghost if ghost.success else None
