"""The search for closed positions: what `equations.start_search` reads, and why nothing closes, in words."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from rattle.analyses.assembly.loop_map import loop_map
from rattle.analyses.assembly.start_values import given_values
from rattle.analyses.assembly.unclosed import why_open, without_value
from rattle.equations.closure import place_only
from rattle.equations.dense import LARGE
from rattle.equations.motion import constraints, drive
from rattle.equations.start_search import guess_first, least_open
from rattle.equations.system import System
from rattle.jit.workspace import TYPES, Workspace


def search_arrays(
    system: System, wanted: np.ndarray, offsets: Mapping[str, tuple[float, float]]
) -> dict[str, np.ndarray]:
    """Arrays of a workspace in which closed positions can be looked for.

    wanted: (3 nb,) positions [m, m, rad], nan if not given; offsets of joints [m].
    """
    form, near = loop_map(system), system.model.initial.near
    nowhere = (math.nan, math.nan, math.nan)
    rooms = {name: np.zeros(shape, TYPES[name][0]) for name, shape in form.rooms.items()}
    return {
        **form.arrays, **rooms,
        "start_lines": np.array(joint_lines(system), dtype=float).reshape(-1, 3),
        "start_offsets": np.array(joint_offsets(system, offsets), dtype=float).reshape(-1, 2),
        "start_given": wanted, "start_size": np.array([system.size]),
        "start_near": np.array([near.get(name, nowhere) for name in system.bodies], dtype=float).ravel(),
    }  # fmt: skip


def joint_lines(system: System) -> list[tuple[float, float, float]]:
    """By joint: the direction of its line on A [rad], the distance of its points [m], the angle that it keeps [rad]."""
    return [(joint.line or 0.0, joint.distance, joint.kept_angle or 0.0) for joint in system.model.joints.values()]


def joint_offsets(system: System, offsets: Mapping[str, tuple[float, float]]) -> list[tuple[float, float]]:
    """By joint: its offset [m]."""
    return [offsets.get(name, (0.0, 0.0)) for name in system.model.joints]


def first_guess(system: System, t: float = 0.0) -> np.ndarray:
    """Positions (3 nb,) [m, m, rad] at time t [s] with which the search for closed ones begins."""
    q = np.zeros(3 * system.body_count)
    arrays = search_arrays(system, given_values(system, 0), system.model.initial.offsets)
    guess_first(system.assembly_workspace(None, **arrays), t, q)
    return q


def why_open_from(system: System, workspace: Workspace, t: float, q: np.ndarray) -> str:
    """Why the joints cannot be closed from q, in words; q is moved in place to where the residual is least."""
    drive(workspace, t)
    if system.row_count <= LARGE and not without_value(system, workspace, t):
        least_open(workspace, t, q)
    place_only(workspace, q)
    constraints(workspace)
    return why_open(system, workspace, t)
