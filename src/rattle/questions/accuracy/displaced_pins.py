"""The mechanism with closed joints whose pins are displaced in their bushes: value and slope of an output.

A displacement e_i of a pin shifts the bush point of A in A's frame, so that the ordinary constraints close the loops:

    Phi_i(q) = e_i,   Phi_q^T y = do/dq,   do/de_i = y_i     (one linear solve for every output of positions)
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from rattle import registry
from rattle.analyses.assembly.assembly import Assembled
from rattle.description.model import Joint
from rattle.equations.closure import open_by
from rattle.equations.dense import dense_rows
from rattle.equations.motion import loads
from rattle.equations.placement import turned
from rattle.equations.system import System
from rattle.interfaces.contacts import WornKind
from rattle.jit import layout as at
from rattle.jit.layout import POINTS
from rattle.questions.kinematics.sweep import begin
from rattle.results.build import build_result
from rattle.results.columns import columns, motion, width
from rattle.results.trust import Trust
from rattle.solvers.positions import position_sweep as swept

SMALL = 1e-4  # displacement for differences, as a share of a clearance
SIGNAL_STEP = 1e-5  # change of a coordinate for differences of a signal: share of the size of the mechanism, or [rad]
SINGULAR = (
    1e-12  # share of the largest singular value below which a direction of the joint rows is none: redundant rows
)


class Displaced:
    """The mechanism with closed joints, with its pins displaced in their bushes by given amounts.

    Displacements e are (k, 2) for k joints with clearance, [m] ([rad] for rotations), in the frames of their A.
    """

    def __init__(self, system: System, start: Assembled, joints: Sequence[Joint], output: str) -> None:
        self.system, self.start, self.joints, self.output = system, start, joints, output
        self.sweep = begin(system, start)
        self.place = [system.first_value(joint.name) for joint in joints]
        self.free = [free_play(joint) for joint in joints]
        self.values = self.sweep.workspace.values
        self.base = self.values.copy()
        self.names: list[str] = []

    def shift(self, e: np.ndarray) -> None:
        """Displace joint i by e[i] [m, rad], in the frame of its A; the kind of clearance defines both components."""
        for joint, p, change in zip(self.joints, self.place, e, strict=True):
            x, y, others = joint.play.displaced(joint.fields, change)
            self.values[p] = self.base[p] + x
            self.values[p + 1] = self.base[p + 1] + y
            for n, key in enumerate(joint.fields, p + POINTS):
                self.values[n] = self.base[n] + others.get(key, 0.0)

    def row(self, t: float, node: np.ndarray, e: np.ndarray) -> np.ndarray:
        """Output row (width,) [SI] at t [s] with the pins displaced by e, from a node nearby; nan if not closable."""
        self.shift(e)
        sweep = self.sweep
        sweep.node[:] = node
        sweep.node[swept.Q_NEW : swept.Q_OLD] = node[: swept.Q_NEW]
        moved, root, _, _ = swept.closed_at(sweep.workspace, t, sweep.node, self.system.size)
        raw = np.full(width(self.system), math.nan)
        if moved < math.inf:
            sweep.node[: swept.Q_NEW] = sweep.node[swept.Q_NEW : swept.Q_OLD]
            sweep.clock[:] = t, math.inf, 0.0, root, root, t
            got = sweep.go(np.array([t]), True)
            if len(got):
                raw = got[0]
        self.shift(np.zeros_like(e))
        return raw

    def value(self, t: float, node: np.ndarray, e: np.ndarray) -> float:
        """The output [SI] at t [s] with the pins displaced by e, nan if it cannot be closed.  Raises UnknownName."""
        raw = self.row(t, node, e)
        owner, _, last = self.output.rpartition(".")
        body, _, point = owner.partition(".")
        if not self.names or body not in self.system.bodies or last not in ("x", "y", "angle"):
            return float(self.read(raw[None])[0])
        k = 3 * self.system.bodies.index(body)  # a position, the usual case: without the table of all results
        place = motion(self.system, raw)[0, k : k + 3]
        if not point:
            return float(place[("x", "y", "angle").index(last)])
        x, y = self.system.model.bodies[body].points[point]
        c, s = math.cos(place[2]), math.sin(place[2])
        return float(place[0] + c * x - s * y if last == "x" else place[1] + s * x + c * y)

    def read(self, raw: np.ndarray) -> np.ndarray:
        """The output (n,) [SI] of output rows (n, width).  Raises UnknownName."""
        data, names, units = columns(self.system, raw)
        t = np.arange(len(raw))
        result = build_result(
            self.system.model, "accuracy", t=t, data=data, names=names, units=units, trust=Trust(drift=0.0)
        )
        self.names, self.unit = list(result.names), result.unit(self.output)
        return np.asarray(result[self.output])

    def gradient(self, t: float, node: np.ndarray, e: np.ndarray) -> np.ndarray:
        """(k, 2) d output / d e [SI] at t [s]: one linear solve for outputs of positions, differences for others."""
        q_slope = self._slope(t, node, e)
        if q_slope is None:
            return self._differences(t, node, e)
        workspace = self.sweep.workspace
        rows = dense_rows(self.system, workspace)
        y = np.linalg.lstsq(rows.T, q_slope, rcond=SINGULAR)[0]
        slopes = np.zeros((len(self.joints), 2))
        for k, joint in enumerate(self.joints):
            first, count = self.system.first_row(joint.name), len(joint.leaf.rows)
            slopes[k, :count] = y[first : first + count]
            if joint.leaf.rows_in_ground:  # and e is in the frame of A
                row = 0 if joint.a.body == "ground" else 1 + self.system.bodies.index(joint.a.body)
                slopes[k] = turned(-workspace.body[row, at.PHI], slopes[k])
        return slopes

    def _slope(self, t: float, node: np.ndarray, e: np.ndarray) -> np.ndarray | None:
        """(3 nb,) d output / dq [SI], with the rows at e in the workspace; None unless it depends on positions only."""
        owner, _, last = self.output.rpartition(".")
        body, _, point = owner.partition(".")
        bodies = self.system.model.bodies
        signal = self.output in self.system.model.recorded
        if not signal and (
            body not in bodies or last not in ("x", "y", "angle") or (point and point not in bodies[body].points)
        ):
            return None
        self.row(t, node, e)
        workspace = self.sweep.workspace
        q = self.sweep.node[swept.Q].copy()
        v = self.sweep.node[swept.V].copy()
        self.shift(e)
        open_by(workspace, t, q, v)
        slope = np.zeros(len(q))
        if not signal:
            k = 3 * self.system.bodies.index(body)
            c, s = math.cos(q[k + 2]), math.sin(q[k + 2])
            x, y = bodies[body].points[point] if point else (0.0, 0.0)
            slope[k + ("x", "y", "angle").index(last)] = 1.0
            if point:
                slope[k + 2] = -(s * x + c * y) if last == "x" else c * x - s * y
        else:
            slope_v = self._signal_slopes(t, q, v, slope)
            if slope_v:
                self.shift(np.zeros_like(e))
                return None
        open_by(workspace, t, q, v)
        self.shift(np.zeros_like(e))
        return slope

    def _signal_slopes(self, t: float, q: np.ndarray, v: np.ndarray, slope: np.ndarray) -> bool:
        """Write d signal / dq into `slope` (3 nb,) [SI], by differences; True if the signal depends on rates too."""
        workspace, k = self.sweep.workspace, list(self.system.model.recorded).index(self.output)

        def at(q: np.ndarray, v: np.ndarray) -> float:
            open_by(workspace, t, q, v)
            loads(workspace, t)
            return float(workspace.signals[k])

        base = at(q, v)
        for n in range(len(q)):
            step = SIGNAL_STEP * (self.system.size if n % 3 < 2 else 1.0)
            up, down = q.copy(), q.copy()
            up[n] += step
            down[n] -= step
            slope[n] = (at(up, v) - at(down, v)) / (2 * step)
        return any(at(q, v + np.eye(len(v))[n]) != base for n in range(len(v)))

    def _differences(self, t: float, node: np.ndarray, e: np.ndarray) -> np.ndarray:
        slopes = np.zeros_like(e)
        for k, free in enumerate(self.free):
            for n in range(2):
                step = SMALL * free.steps[n]
                change = np.zeros_like(e)
                change[k, n] = step
                slopes[k, n] = (self.value(t, node, e + change) - self.value(t, node, e - change)) / (2 * step)
        return slopes


def free_play(joint: Joint) -> Any:
    """The displacements that the clearance of a joint allows, a `FreePlay` [m, rad]."""
    if joint.worn is not None:
        return worn_surface(joint).worn_play(joint.worn, joint.clearance)
    return joint.play.free_play(joint.clearance, joint.fields, joint.dimensions)


def worn_surface(joint: Joint) -> type[WornKind]:
    """The class of the worn surfaces of a joint."""
    play = registry.play_of(joint.kind)
    assert play is not None, "only joints with play wear"
    return registry.kinds("worn")[play.name].leaf
