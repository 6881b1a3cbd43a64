"""The motion of a result once more, with the forces of every element on every body.

A result holds its model.  A run in time is repeated by the same steps; inverse dynamics goes through the same
positions, with the same motors.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.analyses.load_forces import gravity_over
from rattle.equations.system import System
from rattle.errors import InputError
from rattle.jit import layout as at
from rattle.loading import loads
from rattle.questions.kinematics.compute import rows_with_ports
from rattle.questions.power.steps import rows_at, settings_of
from rattle.results.columns import width
from rattle.results.result import Result

Array = NDArray[np.float64]
NEEDED = {"simulate": ("document", "t_end", "method", "rtol", "atol"), "inverse dynamics": ("document",)}


class MotorEffort(NamedTuple):
    """A motor that does the work of a driver, and what it exerts."""

    joint: str
    values: Array  # (n,) [N m or N]

    def force(self, motion: KnownMotion) -> Array:
        """(n, 2) the force on B [N]: along the line of A; none of a motor that turns."""
        joint = motion.system.model.joints[self.joint]
        if joint.line is None:
            return np.zeros((len(self.values), 2))
        axis = joint.line + motion.angle(joint.a.body)
        force: Array = self.values[:, None] * np.column_stack([np.cos(axis), np.sin(axis)])
        return force

    def couple(self, motion: KnownMotion) -> Array:
        """(n,) the moment on B [N m]; none of a motor that pushes."""
        return self.values if motion.system.model.joints[self.joint].line is None else np.zeros(len(self.values))


class KnownMotion(NamedTuple):
    """A motion with all forces."""

    result: Result
    system: System
    t: Array  # (n,) [s]
    rows: Array  # (n, columns) output rows with ports [SI]
    motors: tuple[MotorEffort, ...]
    defined: NDArray[np.bool_]  # (n,) False where reactions are not determined

    def bodies(self) -> Array:
        """(n, bodies, 3, 3) positions, rates and accelerations [m, rad, s]."""
        count = self.system.body_count
        return self.rows[:, : at.PER_BODY * count].reshape(-1, count, 3, 3)

    def gravity(self) -> Array:
        """(n, 2) [m/s^2]."""
        return gravity_over(self.system, self.t)[0]

    def angle(self, body: str) -> Array:
        """(n,) angle of a body [rad]."""
        if body == "ground":
            return np.zeros(len(self.t))
        return self.bodies()[:, self.system.bodies.index(body), 0, 2]

    def place(self, body: str, spot: tuple[float, float]) -> Array:
        """(n, 2) where a point of a body or of the ground is [m]; spot: in the frame of the body."""
        if body == "ground":
            return np.tile(np.array(spot, float), (len(self.t), 1))
        x, y, angle = self.bodies()[:, self.system.bodies.index(body), 0].T
        cos, sin = np.cos(angle), np.sin(angle)
        return np.column_stack([x + cos * spot[0] - sin * spot[1], y + sin * spot[0] + cos * spot[1]])


def known_motion(r: Result, what: str) -> KnownMotion:
    """The motion of a result with the forces of all elements; what: is asked, as errors say it.

    Raises InputError for a result of another analysis, without instants, or that does not hold its model.
    """
    analysis = r.provenance.get("analysis")
    if analysis not in NEEDED:
        raise InputError(
            f"{what} follows from forces: ask a result of m.simulate(...) or m.inverse_dynamics(...), not of {analysis}"
        )
    if any(r.provenance.get(key) is None for key in NEEDED[analysis]):
        raise InputError(
            f"this result does not hold its model, from which {what} follows; run it again with this version"
        )
    if not len(r.t):
        raise InputError(f"{what}: the result has no instant")
    m = loads(str(r.provenance["document"]))
    motors: tuple[MotorEffort, ...] = ()
    if analysis == "simulate":
        system = m.system
        rows = rows_at(m, settings_of(r.provenance), np.asarray(r.t))
    else:
        system, rows, joints = rows_with_ports(
            m.system, m._start_or_none(), np.asarray(r.t), r.provenance.get("effort_at")
        )
        last = width(system, True)
        motors = tuple(MotorEffort(joint, rows[:, last + 2 * n]) for n, joint in enumerate(joints))
    return KnownMotion(r, system, np.asarray(r.t), rows, motors, ~r.left_out & np.isfinite(rows).all(axis=1))
