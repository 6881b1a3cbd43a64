"""One mechanism brought to rest: Q(q) - Phi_q^T lambda = 0, Phi(q, t) = 0.

Newton on the degrees of freedom that the joints leave, with positions kept closed:

    Z = null space of Phi_q,   g = Z^T Q,   H = Z^T K Z,   K = -d(Q - Phi_q^T lambda)/dq,   q += Z H^-1 g

Coordinates are scaled (angles as arc lengths at the size of the mechanism), so that g is in N and H in N/m.
H > 0 is stability against small displacements (docs/theory.md, section 7).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from rattle.analyses.assembly.rank import RANK, nonunique_reactions
from rattle.analyses.statics.equilibrium import Equilibrium, Table
from rattle.analyses.undefined import undefined
from rattle.elements.custom import load_law
from rattle.equations.closure import close_position
from rattle.equations.dense import dense_rows
from rattle.equations.motion import drive
from rattle.equations.rest_force import force_at
from rattle.equations.system import System, has_contacts, is_link
from rattle.jit import layout as at
from rattle.results.build import provenance
from rattle.results.columns import columns, geometry, width
from rattle.solvers.output_row import write
from rattle.solvers.positions import equilibrium_newton

MOST_TURN = 0.4  # of a body in one step [rad]
MOST_TRIALS = 600  # positions tried from one start before it is given up
CHUNK = 10_000_000  # operations, roughly, between two looks at whether the user wants to stop


class Room(NamedTuple):
    """Arrays that `settling` works in; n coordinates, nr rows, k massless links."""

    arm: np.ndarray  # (2 k, 2)
    wide: np.ndarray  # (nr, n)
    norm: np.ndarray  # (nr,)
    order: np.ndarray  # (nr,)
    pivot: np.ndarray  # (2, nr)
    null: np.ndarray  # (n, n)
    line: np.ndarray  # (7, n)
    small: np.ndarray  # (2 n, n)
    state: np.ndarray  # (10,)
    order_h: np.ndarray  # (n,)
    pivot_h: np.ndarray  # (2, n)

    @classmethod
    def of(cls, n: int, rows: int, links: int) -> Room:
        """Room for a mechanism of that size."""
        return cls(
            np.zeros((2 * links, 2)), np.zeros((rows, n)), np.zeros(rows), np.zeros(rows, np.int64),
            np.zeros((2, rows)), np.zeros((n, n)), np.zeros((7, n)), np.zeros((2 * n, n)), np.zeros(10),
            np.zeros(n, np.int64), np.zeros((2, n)),
        )  # fmt: skip


class Found(NamedTuple):
    """An equilibrium as it was found."""

    q: np.ndarray  # (3 nb,)
    multiplier: np.ndarray  # (nr,)
    eigenvalue: float  # [N/m]
    residual: float  # [N]
    gap: float  # [m or rad]
    iterations: int
    nonunique: tuple[str, ...]
    dof: int
    neutral: int
    falling: int
    potential: float  # energy [J]
    force: float  # typical of what acts [N]
    raw: np.ndarray  # output row


class StaticProblem:
    """One mechanism to be brought to rest at one position of its drivers."""

    def __init__(self, system: System, t: float) -> None:
        self.system, self.workspace = system, system.workspace()
        if len(self.workspace.contact_memory):
            self.workspace.contact_memory[:, at.CLOSED] = at.AUTO
            self.workspace.contact_memory[:, at.SPEED] = 1.0
        self.scale = np.ones(3 * system.body_count)
        self.scale[2::3] = 1.0 / system.size
        joints = system.model.joints.values()
        arms = [one.clearance for one in joints if is_link(one)] + [
            one.distance for one in joints if one.distance > 0.0
        ]
        length = min([1e-4 * system.size] + [3e-3 * one for one in arms])
        if len(self.workspace.contact_memory):  # penetrations are small
            length = min([length] + [1e-5 * one.clearance for one in joints if has_contacts(one)])
        self.length, self.step = length, length * self.scale
        self.out = np.zeros(3 * system.body_count)
        self.links = [name for name, one in system.model.joints.items() if is_link(one)]
        entries = system.arrays["joint"][np.array([system.joints.index(name) for name in self.links], np.int64)]
        self.pins = np.ascontiguousarray(entries[:, 1:4])
        self.room = Room.of(3 * system.body_count, system.row_count, len(self.links))
        self.trials = 0  # positions looked at
        self.arrived = False  # whether the last start led to an equilibrium, known or new
        self.redundant = False  # whether the rows looked at last depend on each other
        self.undefined = ""  # what had no finite value where a start was given up, or at a position found
        self.table: Table | None = None
        self.at(t)

    def at(self, t: float) -> None:
        """Set the drivers to time t."""
        self.t = t
        drive(self.workspace, t)

    def close(self, q: np.ndarray) -> float:
        """Put the joints together in place; returns the largest residual."""
        gap, _ = close_position(self.workspace, self.t, q, np.empty_like(q), 1e-13 * self.system.size, 60)
        return float(gap)

    def reduce(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Reduced force g [N] and the scaled null space Z at q; leaves the least-squares multipliers."""
        r, rows_all = self.room, self.system.row_count
        dof = equilibrium_newton.reduce(
            self.workspace, self.t, q, self.scale, r.wide, r.norm, r.order, r.pivot, r.null, r.line
        )
        self.redundant = dof > len(q) - rows_all
        if not self.redundant:
            return r.line[equilibrium_newton.G, :dof].copy(), r.null[:dof].T.copy()
        self.workspace.multiplier[:] = 0.0  # of all that hold the balance, those of least size
        force_at(self.workspace, self.t, q, self.out)
        applied = self.out * self.scale
        rows = dense_rows(self.system, self.workspace) * self.scale
        norm = np.linalg.norm(rows, axis=1)
        _, values, right = np.linalg.svd(rows / norm[:, None])
        count = int((values > RANK * values[0]).sum())
        self.workspace.multiplier[:] = np.linalg.lstsq((rows / norm[:, None]).T, applied, rcond=RANK)[0] / norm
        null = right[count:].T
        return null.T @ applied, self.scale[:, None] * null

    def hessian(self, q: np.ndarray, null: np.ndarray) -> np.ndarray:
        """Reduced Hessian H [N/m]; the multipliers of `reduce` are in the workspace."""
        room, dof = self.room, null.shape[1]
        room.null[:dof] = null.T
        equilibrium_newton.reduced_stiffness(
            self.workspace, self.t, q, self.length, dof, 4, room.null, room.line, room.small
        )
        force_at(self.workspace, self.t, q, self.out)
        return room.small[:dof, :dof].T.copy()

    def offsets(self, q: np.ndarray) -> np.ndarray:
        """(k, 2) pin centre minus bush centre of every link, at q."""
        found = []
        for name in self.links:
            joint = self.system.model.joints[name]
            ends = []
            for point in (joint.a, joint.b):
                if point.body == "ground":
                    ends.append(np.array(point.at))
                    continue
                x, y, phi = q[3 * self.system.bodies.index(point.body) :][:3]
                c, s = math.cos(phi), math.sin(phi)
                ends.append(np.array([x + c * point.at[0] - s * point.at[1], y + s * point.at[0] + c * point.at[1]]))
            found.append(ends[1] - ends[0])
        return np.array(found).reshape(-1, 2)

    def find(
        self,
        start: np.ndarray,
        downhill: bool = False,
        known: np.ndarray | None = None,
        near: float = 0.0,
        most: int = MOST_TRIALS,
        turn: float = MOST_TURN,
    ) -> tuple[np.ndarray, int] | None:
        """An equilibrium near a start, or None; downhill: a stable one.

        known (k, 3 nb): equilibria that need not be found once more; None too where the way leads to within
        `near` of one of them.  most: positions to try before the start is given up; `trials` counts them.
        turn: how far a body may turn in one step [rad]; a wide one is quick but may leap out of the nearest valley.
        """
        q, room = start.copy(), self.room
        room.state[:] = 0.0
        room.state[equilibrium_newton.MOST_TURN] = turn
        known = np.zeros((0, len(q))) if known is None else known
        rounds = max(1, min(equilibrium_newton.ROUNDS, CHUNK // (len(q) ** 3 + 1)))
        status = equilibrium_newton.GOING
        while status == equilibrium_newton.GOING:  # in pieces, so that the user can stop it
            status = equilibrium_newton.find(
                self.workspace, self.t, q, self.scale, self.system.size, self.length, downhill, rounds, known,
                len(known), near, self.pins, *room, float(most),
            )  # fmt: skip
        self.trials += int(room.state[equilibrium_newton.TRIALS]) + 1
        self.arrived = status in (equilibrium_newton.FOUND, equilibrium_newton.KNOWN)
        if room.state[equilibrium_newton.PHASE] and not room.state[equilibrium_newton.G_SIZE] < math.inf:
            self._say_undefined()
        return (q, int(room.state[equilibrium_newton.ITERATION])) if status == equilibrium_newton.FOUND else None

    def _say_undefined(self) -> None:
        """Keep what has no finite value at the position at hand; Ctrl-C in a law is raised again."""
        load_law.complaint(-math.inf)
        self.undefined = self.undefined or undefined(self.system, self.workspace, self.t)

    def walk(self, q: np.ndarray, direction: np.ndarray, stride: float) -> tuple[bool, float, float]:
        """A step along the free motion, in place: whether it could be taken, force along the way, largest force [N]."""
        r = self.room
        self.trials += 1
        gap, along, most = equilibrium_newton.walk(
            self.workspace, self.t, q, self.scale, self.system.size, stride, direction, r.wide, r.norm, r.order,
            r.pivot, r.null, r.line,
        )  # fmt: skip
        return gap < math.inf, float(along), float(most)

    def displace(self, q: np.ndarray, target: np.ndarray) -> None:
        """Bring the residuals of all rows to `target` (nr,) by the least change of q, in place."""
        r = self.room
        equilibrium_newton.displace(self.workspace, q, target, self.scale, 6, r.wide, r.norm, r.order, r.pivot, r.line)

    def force_scale(self) -> float:
        """A force typical of what acts [N]."""
        return float(equilibrium_newton.force_size(self.workspace, self.system.size))

    def assess(self, q: np.ndarray, iterations: int) -> Found:
        """What is to be known about an equilibrium; the workspace holds it afterwards."""
        workspace, system = self.workspace, self.system
        g, null = self.reduce(q)
        eigenvalue, neutral, falling = math.inf, 0, 0
        if len(g):
            h = self.hessian(q, null)
            largest = float(np.abs(h).max())
            even = float(np.abs(h - h.T).max()) <= 1e-9 * largest  # loads that keep energy
            values = np.linalg.eigvalsh(0.5 * (h + h.T)) if even else np.linalg.eigvals(h).real
            # a soft direction beside a stiff contact is no free one: what counts as nothing is what rounding leaves
            tiny = max(1e-8 * self.force_scale() / system.size, 1e-13 * float(np.abs(values).max()))
            neutral, falling = int((np.abs(values) < tiny).sum()), int((values <= -tiny).sum())
            eigenvalue = float(values.min()) if abs(values.min()) >= tiny else 0.0
        force_at(workspace, self.t, q, self.out)
        gap = float(np.abs(workspace.rows[:, 0]).max(initial=0.0))
        residual = float(np.abs(self.out * self.scale).max(initial=0.0))
        if not residual < math.inf:
            self._say_undefined()
        workspace.acceleration[:] = 0.0
        workspace.rows[:, 1] = 0.0  # at rest
        raw = np.zeros(width(system))
        write(workspace, 0.0, 0.0, raw)
        return Found(
            q.copy(), workspace.multiplier.copy(), eigenvalue, residual, gap, iterations,
            nonunique_reactions(system, workspace) if self.redundant else (),
            len(g), neutral, falling, float(workspace.power[0]), self.force_scale(), raw,
        )  # fmt: skip

    def describe(self, found: Sequence[Found]) -> list[Equilibrium]:
        """Equilibria with all their quantities."""
        if not found:
            return []
        data, names, units = columns(self.system, np.array([one.raw for one in found]))
        keep = [k for k, name in enumerate(names) if name not in ("energy.work", "energy.dissipated", "energy.balance")]
        if self.table is None:
            self.table = self._table([names[k] for k in keep], units)
        data = np.ascontiguousarray(data[:, keep])
        return [
            Equilibrium(
                self.t, one.q, one.multiplier, one.eigenvalue, one.residual, one.gap, one.iterations, one.nonunique,
                one.dof, one.neutral, one.falling, row, self.table,
            )
            for one, row in zip(found, data, strict=True)
        ]  # fmt: skip

    def _table(self, names: Sequence[str], units: Mapping[str, str]) -> Table:
        column = {name: k for k, name in enumerate(names)}
        drawn = geometry(self.system.model)
        pins = [name for name, joint in drawn["joints"].items() if joint["contact"] not in ("", "ideal")]
        return Table(
            column,
            {name: units[name] for name in names},
            tuple((name, column[f"{name}.normal"]) for name in pins if f"{name}.normal" in column),
            drawn,
            provenance(self.system.model, "equilibrium"),
        )

    def finish(self, q: np.ndarray, iterations: int) -> Equilibrium:
        """Everything about an equilibrium."""
        return self.describe([self.assess(q, iterations)])[0]
