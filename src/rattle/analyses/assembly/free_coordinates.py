"""Degrees of freedom by name: joint coordinates that may be chosen freely and determine all others."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from rattle import registry
from rattle.analyses.assembly.rank import RANK, scaled_rows
from rattle.description.model import Joint, is_ground
from rattle.equations.closure import open_by
from rattle.equations.dense import LARGE
from rattle.equations.placement import point_at, pose, turned
from rattle.equations.system import System, is_link

Array = np.ndarray
Coordinate = Callable[[Array], float]  # of positions (3 nb,); angles times the size of the mechanism [m]
STEP = 1e-5  # of differences, as a share of the mechanism's size
STILL = 1e-9  # change of a coordinate [-] that is rounding of differences
BARELY = 1e-6  # share of a change that must be left where no coordinate is clear
CLEAR = 0.1  # share of a coordinate's change that those chosen before must leave; the others come after them


def free_coordinates(system: System, t: float, q: Array) -> tuple[str, ...]:
    """As many coordinates as joints and drivers leave degrees of freedom at positions q (3 nb,) and time t [s].

    "O.angle" and "guide.position" are coordinates of joints, "B.ex" is play, "box.x" a coordinate of a body.
    Joints on the ground come first.  () also for mechanisms too large for dense linear algebra.
    """
    if system.row_count > LARGE or not system.body_count:
        return ()
    workspace = system.workspace()
    open_by(workspace, t, q, np.zeros_like(q))
    motions = np.eye(len(q))
    if system.row_count:
        _, values, v = np.linalg.svd(scaled_rows(system, workspace))
        motions = v[int((values > RANK * values[0]).sum()) :]
    names, changes = [], []
    for name, value in coordinates(system):
        names.append(name)
        changes.append(_change(system, value, q, motions))
    return tuple(names[k] for k in _independent(np.array(changes).reshape(len(names), -1)))


def _change(system: System, value: Coordinate, q: Array, motions: Array) -> Array:
    """(f,) change of a coordinate [-] with every one of the motions (f, 3 nb)."""
    scale = np.tile([1.0, 1.0, 1.0 / system.size], system.body_count)
    step = STEP * system.size
    return np.array([(value(q + step * n * scale) - value(q - step * n * scale)) / (2.0 * step) for n in motions])


def _independent(changes: Array) -> list[int]:
    """Rows of (n, f) changes that together determine all motions, the first that do."""
    chosen: list[int] = []
    basis: list[Array] = []
    for share in (CLEAR, BARELY):
        for k, change in enumerate(changes):
            size = float(np.linalg.norm(change))
            if k in chosen or len(basis) == changes.shape[1] or size < STILL:
                continue
            left = change - sum((direction @ change) * direction for direction in basis)
            if float(np.linalg.norm(left)) > share * size:
                basis.append(left / np.linalg.norm(left))
                chosen.append(k)
    return sorted(chosen)


def coordinates(system: System) -> Iterator[tuple[str, Coordinate]]:
    """Coordinates by name: of joints, those on the ground first, then of play, then of bodies."""
    joints = sorted(
        system.model.joints.values(), key=lambda joint: not (is_ground(joint.a.body) or is_ground(joint.b.body))
    )
    for joint in joints:
        motor = joint.leaf.motor
        if motor is not None:
            angle = registry.kinds("driver")[motor.driver].leaf.sets_angle
            yield f"{joint.name}.{motor.driver}", (_turning if angle else _sliding)(system, joint)
    for joint in joints:
        if (joint.is_loose or is_link(joint)) and not joint.leaf.touches:
            for k, key in enumerate(("ex", "ey")):
                yield f"{joint.name}.{key}", _offset(system, joint, k)
    for n, body in enumerate(system.bodies):
        for k, key in enumerate(("x", "y", "angle")):
            yield f"{body}.{key}", _of_body(system, 3 * n + k, key == "angle")


def _turning(system: System, joint: Joint) -> Coordinate:
    return lambda q: system.size * (pose(system, q, joint.b.body)[2] - pose(system, q, joint.a.body)[2])


def _sliding(system: System, joint: Joint) -> Coordinate:
    def position(q: Array) -> float:
        u = turned(pose(system, q, joint.a.body)[2] + (joint.line or 0.0), (1.0, 0.0))
        return float(u @ (point_at(system, q, joint.b) - point_at(system, q, joint.a)))

    return position


def _offset(system: System, joint: Joint, k: int) -> Coordinate:
    return lambda q: float((point_at(system, q, joint.b) - point_at(system, q, joint.a))[k])


def _of_body(system: System, place: int, angle: bool) -> Coordinate:
    return lambda q: float(q[place]) * (system.size if angle else 1.0)
