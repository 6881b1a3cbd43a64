"""A sweep over the positions of a driven mechanism: its state, and its start."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rattle import registry
from rattle.analyses.assembly.assembly import Assembled
from rattle.description.model import before_function
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace
from rattle.results.columns import motion_width, width
from rattle.solvers.positions import position_sweep as swept

SPOTS = 256
PIECE = 40_000  # rows times positions that are computed between two checks for Ctrl-C


@dataclass
class Sweep:
    """The state of one sweep over the positions [SI], and the singular positions that it has met."""

    system: System
    workspace: Workspace
    node: np.ndarray  # (9, 3 nb), see solvers.positions.position_sweep, as clock, tally and line
    clock: np.ndarray
    tally: np.ndarray
    spots: np.ndarray  # (SPOTS, 2) intervals of time [s] with a singular position
    probe: np.ndarray  # (k, 5) motors whose effort is computed in place of that of a driver
    line: np.ndarray
    ports: bool = False  # rows with forces go on with the ports of all elements, see `solvers.ports`

    def go(self, times: np.ndarray, forces: bool) -> np.ndarray:
        """Output rows (k, width) [SI] at the first k of the times [s], as far as they can be reached."""
        count = (width(self.system, self.ports) + 2 * len(self.probe)) if forces else motion_width(self.system)
        raw = np.zeros((len(times), count))
        done, onward = 0, 0.0
        size = max(2, PIECE // max(1, self.system.row_count))
        while done < len(times):  # in pieces, so that Ctrl-C works
            part = slice(done, done + size)
            self.tally[swept.COUNT] = 0
            swept.sweep(
                self.workspace, times[part], raw[part], self.node, self.clock, self.tally, self.spots,
                self.system.size, forces, self.probe, self.line, onward,
            )  # fmt: skip
            done += int(self.tally[swept.COUNT])
            if self.tally[swept.COUNT] < len(times[part]):
                break
            if done < len(times):
                onward = 1.0 if times[done] >= times[done - 1] else -1.0
        self.tally[swept.COUNT] = done
        return raw[:done]

    def fork(self) -> Sweep:
        """A copy that goes on from the same place and leaves this sweep unchanged."""
        return replace(
            self, node=self.node.copy(), clock=self.clock.copy(), tally=np.zeros(4, np.int64), spots=np.zeros((0, 2))
        )


def unjoined(system: System) -> list[str]:
    """Bodies that no joint and no driver touches: a given motion leaves them where they are."""
    touched = set(system.arrays["row_body"].ravel().tolist())
    touched |= set(system.arrays["contact"][:, [at.A_BODY, at.B_BODY]].ravel().tolist())
    return [name for n, name in enumerate(system.bodies, start=1) if n not in touched]


def begin(
    system: System, start: Assembled, motors: Sequence[tuple[int, str]] = (), shift: np.ndarray | None = None
) -> Sweep:
    """A sweep that begins at an assembled start.

    motors: (constraint row of a driver, joint whose motor does its work).  shift: (n,) parameters [SI] to be used
    instead of the system's.  Raises ModelError if degrees of freedom are left.
    """
    radius = np.array(
        [max([math.hypot(*at) for at in body.points.values()] + [0.0]) for body in system.model.bodies.values()]
    )
    weight = np.ones_like(system.arrays["weight"])
    weight[0] = 0.0
    weight[1:, 2] = 1.0 / np.where(radius > 0.0, radius, system.size) ** 2
    weight[[1 + system.bodies.index(name) for name in unjoined(system)]] = 0.0
    values = list(system.arrays["values"] if shift is None else shift)
    probe = []
    for row, name in motors:
        joint = system.model.joints[name]
        number = {"ground": 0, **{body: n + 1 for n, body in enumerate(system.bodies)}}
        driver = registry.kinds("driver")[joint.motor.driver]
        tag = len(registry.kinds("joint")) + driver.tag
        probe.append((tag, number[joint.a.body], number[joint.b.body], len(values), row))
        values += [*joint.a.at, *joint.b.at, *before_function(joint, driver), 0.0, 0.0, 0.0]
    arrays = {
        **system.arrays,
        "weight": weight,
        "massless": system.arrays["massless"][:0],
        "values": np.array(values, dtype=float),
    }
    workspace = replace(system, arrays=arrays).workspace(also=[row[0] for row in probe])
    node = np.zeros((9, 3 * system.body_count))
    sweep = Sweep(
        system, workspace, node, np.array([start.t, math.inf, 0.0, 1.0, 1.0, start.t]), np.zeros(4, np.int64),
        np.zeros((SPOTS, 2)), np.array(probe, np.int64).reshape(-1, 5), np.zeros((1, 9)),
    )  # fmt: skip
    node[swept.Q_NEW], node[swept.V_NEW] = start.q, start.v
    for _ in range(2):  # the second pass uses the rates found by the first
        _, root, _, _ = swept.closed_at(workspace, start.t, node, system.size)
    node[: swept.Q_NEW] = node[swept.Q_NEW : swept.Q_OLD]
    sweep.clock[swept.ROOT] = sweep.clock[swept.ROOT_BEFORE] = root
    return sweep
