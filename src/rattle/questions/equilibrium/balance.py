"""Equilibrium of one mechanism: Q(q) - Phi_q^T lambda = 0, Phi(q, t) = 0.

Newton's method on the degrees of freedom that the joints leave, with the constraints satisfied at every iterate:

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
from rattle.analyses.history import require_known_torques, require_loads_without_states
from rattle.analyses.undefined import undefined
from rattle.description.model import Joint
from rattle.elements.custom import load_law
from rattle.equations.closure import close_position, open_by
from rattle.equations.dense import dense_rows
from rattle.equations.motion import drive
from rattle.equations.placement import point_at
from rattle.equations.rest_force import force_at
from rattle.equations.system import System, is_link
from rattle.jit import layout as at
from rattle.questions.equilibrium.position import Equilibrium, Table
from rattle.results.build import provenance
from rattle.results.columns import columns, geometry, width
from rattle.solvers.output_row import write
from rattle.solvers.positions import equilibrium_newton, reduced_forces

MOST_TURN = 0.4  # of a body in one step [rad]
MOST_TRIALS = 600  # positions tried from one start before it is given up
STILL = 1e-9  # speed over size and largest rate, below which a body does not move
DIFFERENCE = 1e-4  # [of the mechanism's size] step of differences: cancellation and curvature are alike small
ON_LINK = 3e-3  # [of the length of a link or rod] the same where a short one turns: its curvature is large
OF_DEPTH = 0.03  # [of a penetration] the same at a position: test_modes_of_what_has_sunk_in_by_little
IN_PENETRATION = 1e-5  # [of the clearance] the same where contacts sink in, which is by little
CLOSED = 1e-13  # [of the mechanism's size] gap to which joints are closed: just above rounding
CLOSING = 60  # iterations of that, at most
EVEN = 1e-9  # [of the largest entry] asymmetry of a stiffness that is rounding: loads are conservative then
NEUTRAL = (1e-8, 1e-13)  # [of typical force over size, of the largest eigenvalue] stiffness that rounding makes of none
CHUNK = 10_000_000  # operations, roughly, between two checks for Ctrl-C


class Room(NamedTuple):
    """Work arrays of `solvers.positions.equilibrium_newton`; n coordinates, nr rows, k massless links."""

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
        """Arrays for a mechanism of that size."""
        return cls(
            np.zeros((2 * links, 2)), np.zeros((rows, n)), np.zeros(rows), np.zeros(rows, np.int64),
            np.zeros((2, rows)), np.zeros((n, n)), np.zeros((7, n)), np.zeros((2 * n, n)), np.zeros(10),
            np.zeros(n, np.int64), np.zeros((2, n)),
        )  # fmt: skip


class Found(NamedTuple):
    """An equilibrium as it was found; the fields of `Equilibrium` and some numbers for the search."""

    q: np.ndarray  # (3 nb,) [m, m, rad]
    multiplier: np.ndarray  # (nr,) [N, N*m]
    eigenvalue: float  # smallest of the reduced Hessian [N/m]
    residual: float  # largest unbalanced force [N]
    gap: float  # largest constraint residual [m or rad]
    iterations: int
    nonunique: tuple[str, ...]
    dof: int
    neutral: int
    falling: int
    potential: float  # energy [J]
    force: float  # typical size of the acting forces [N]
    raw: np.ndarray  # (width,) output row [SI]
    turning: np.ndarray  # (nb + 1,) rates that films see [rad/s]


def has_pin(joint: Joint) -> bool:
    """True of a joint whose pin has play: it sinks in, floats, or is on a massless link."""
    return bool(joint.leaf.massless) and (joint.is_loose or is_link(joint))


def _oiled(system: System) -> list[tuple[str, int, int, int]]:
    """Joints with oil: name, contact, numbers of both bodies."""
    oiled = []
    for n, entry in enumerate(system.arrays["contact"]):
        if entry[at.FILM_LAW] >= 0:
            oiled.append((system.joints[entry[at.OWNER]], n, int(entry[at.A_BODY]), int(entry[at.B_BODY])))
    return oiled


class StaticProblem:
    """The equilibrium problem of one mechanism at one position of its drivers, t in s."""

    def __init__(self, system: System, t: float) -> None:
        """Raises ModelError for clutches, and for loads that depend on states of the model's own."""
        require_loads_without_states(system.model, "equilibrium")
        require_known_torques(system, "equilibrium")
        self.system, self.workspace = system, system.workspace()
        if len(self.workspace.contact_memory):
            self.workspace.contact_memory[:, at.CLOSED] = at.AUTO
            self.workspace.contact_memory[:, at.SPEED] = 1.0
        self.scale = np.ones(3 * system.body_count)
        self.scale[2::3] = 1.0 / system.size
        joints = system.model.joints.values()
        arms = [joint.clearance for joint in joints if is_link(joint)] + [
            joint.distance for joint in joints if joint.distance > 0.0
        ]
        length = min([DIFFERENCE * system.size] + [ON_LINK * joint for joint in arms])
        if len(self.workspace.contact_memory):  # penetrations are small
            length = min(
                [length]
                + [IN_PENETRATION * joint.clearance for joint in joints if joint.clearance > 0.0 and joint.is_loose]
            )
        self.length, self.step = length, length * self.scale
        self.out = np.zeros(3 * system.body_count)
        self.links = [name for name, joint in system.model.joints.items() if is_link(joint)]
        entries = system.arrays["joint"][np.array([system.joints.index(name) for name in self.links], np.int64)]
        self.pins = np.ascontiguousarray(entries[:, 1:4])
        self.room = Room.of(3 * system.body_count, system.row_count, len(self.links))
        self.oiled = _oiled(system)
        self.moving: list[str] = []  # bodies that the drivers move at the rates that films see
        self.trials = 0  # positions evaluated
        self.arrived = False  # True: the last start led to an equilibrium, known or new
        self.redundant = False  # True: the rows evaluated last are dependent
        self.undefined = ""  # what had no finite value where a start was given up, or at a position found
        self.table: Table | None = None
        self.at(t)

    def at(self, t: float) -> None:
        """Set the drivers to time t [s]."""
        self.t = t
        drive(self.workspace, t)

    def close(self, q: np.ndarray) -> float:
        """Close the joints, q (3 nb,) [m, m, rad] in place; returns the largest residual [m or rad]."""
        gap, _ = close_position(self.workspace, self.t, q, np.empty_like(q), CLOSED * self.system.size, CLOSING)
        return float(gap)

    def reduce(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Reduced force g (dof,) [N] and the scaled null space Z (3 nb, dof) at q (3 nb,).

        The workspace then holds the least-squares multipliers.
        """
        r, rows_all = self.room, self.system.row_count
        dof = reduced_forces.reduce(
            self.workspace, self.t, q, self.scale, r.wide, r.norm, r.order, r.pivot, r.null, r.line
        )
        self.redundant = dof > len(q) - rows_all
        if not self.redundant:
            return r.line[reduced_forces.G, :dof].copy(), r.null[:dof].T.copy()
        self.workspace.multiplier[:] = 0.0  # of all that balance the loads, the smallest
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
        """Reduced Hessian H (dof, dof) [N/m] at q (3 nb,) with Z = null; call `reduce` first, for the multipliers."""
        room, dof, length = self.room, null.shape[1], self._within_contacts(q)
        room.null[:dof] = null.T
        reduced_forces.reduced_stiffness(self.workspace, self.t, q, length, dof, 4, room.null, room.line, room.small)
        force_at(self.workspace, self.t, q, self.out)
        return room.small[:dof, :dof].T.copy()

    def _within_contacts(self, q: np.ndarray) -> float:
        """Step of differences [m] at q (3 nb,) that opens no compliant contact in which something has sunk in."""
        force_at(self.workspace, self.t, q, self.out)
        length = self.length
        for entry, lever, touch in zip(
            self.system.arrays["contact"], self.system.arrays["lever"], self.workspace.contact_kinematics, strict=True
        ):
            if entry[at.IMPACT] == 0 and entry[at.LEVEL] == 0 and touch[at.GAP] < 0.0:
                arm = self.system.size if lever[at.ANGULAR] > 0.0 else 1.0
                length = min(length, OF_DEPTH * arm * -float(touch[at.GAP]))
        return length

    def offsets(self, q: np.ndarray) -> np.ndarray:
        """(k, 2) pin centre minus bush centre of every massless link [m], at q (3 nb,)."""
        offsets = []
        for name in self.links:
            joint = self.system.model.joints[name]
            offsets.append(point_at(self.system, q, joint.b) - point_at(self.system, q, joint.a))
        return np.array(offsets).reshape(-1, 2)

    def turn(self, q: np.ndarray) -> np.ndarray:
        """Let films see the rates (nb + 1,) [rad/s] of the ground and of all bodies that the drivers give at q (3 nb,).

        They are those with which every pin keeps its place in its bush; where the drivers do not determine them, the
        smallest.
        """
        workspace, system = self.workspace, self.system
        if not self.oiled:
            return workspace.turning
        open_by(workspace, self.t, q, np.zeros_like(q))
        rows, rates = dense_rows(system, workspace), workspace.rows[:, at.NU].copy()
        still = np.vstack([self.pin_rows(q, name) for name, joint in system.model.joints.items() if has_pin(joint)])
        whole = np.vstack([rows, still]) * self.scale
        motion = np.linalg.lstsq(whole, np.concatenate([rates, np.zeros(len(still))]), rcond=RANK)[0] * self.scale
        workspace.turning[1:] = motion[2::3]
        speed = np.hypot(motion[::3], motion[1::3])
        moves = speed > STILL * system.size * np.abs(motion[2::3]).max()
        self.moving = [name for name, moves_on in zip(system.bodies, moves, strict=True) if moves_on]
        return workspace.turning.copy()

    def pin_rows(self, q: np.ndarray, name: str) -> np.ndarray:
        """Jacobian (2, 3 nb) of the offset of a pin [m] at q (3 nb,)."""
        rows, joint = np.zeros((2, len(q))), self.system.model.joints[name]
        for sign, end in ((-1.0, joint.a), (1.0, joint.b)):
            if end.body != "ground":
                first = 3 * self.system.bodies.index(end.body)
                place = slice(first, first + 3)
                px, py = point_at(self.system, q, end) - q[place][:2]
                rows[:, place] = (sign, 0.0, -sign * py), (0.0, sign, sign * px)
        return rows

    def find(
        self,
        start: np.ndarray,
        downhill: bool = False,
        seen: np.ndarray | None = None,
        near: float = 0.0,
        most: int = MOST_TRIALS,
        turn: float = MOST_TURN,
    ) -> tuple[np.ndarray, int] | None:
        """Position (3 nb,) [m, m, rad] of an equilibrium near a start (3 nb,), and the iterations; or None.

        downhill: find a stable one.  seen (k, 3 nb): equilibria found already; the result is also None if the search
        comes within `near` [m] of one of them.  most: positions to try before the start is given up; `trials` counts
        them.  turn: largest rotation of a body in one step [rad]; a large one may leave the nearest valley.
        """
        self.turn(start)
        solution = self._find(start, downhill, seen, near, most, turn)
        if solution is None or not self.oiled:
            return solution
        self.turn(
            solution[0]
        )  # the rates there differ a little, which a film much stiffer than its load needs may not see
        return self._find(solution[0], downhill, seen, near, most, turn) or solution

    def _find(
        self, start: np.ndarray, downhill: bool, seen: np.ndarray | None, near: float, most: int, turn: float
    ) -> tuple[np.ndarray, int] | None:
        """`find` with the rates that films see now."""
        q, room = start.copy(), self.room
        room.state[:] = 0.0
        room.state[equilibrium_newton.MOST_TURN] = turn
        seen = np.zeros((0, len(q))) if seen is None else seen
        rounds = max(1, min(equilibrium_newton.ROUNDS, CHUNK // (len(q) ** 3 + 1)))
        status = equilibrium_newton.GOING
        while status == equilibrium_newton.GOING:  # in pieces, so that Ctrl-C works
            status = equilibrium_newton.find(
                self.workspace, self.t, q, self.scale, self.system.size, self.length, downhill, rounds, seen,
                len(seen), near, self.pins, *room, float(most),
            )  # fmt: skip
        self.trials += int(room.state[equilibrium_newton.TRIALS]) + 1
        self.arrived = status in (equilibrium_newton.FOUND, equilibrium_newton.KNOWN)
        if room.state[equilibrium_newton.PHASE] and not room.state[equilibrium_newton.G_SIZE] < math.inf:
            self._say_undefined()
        return (q, int(room.state[equilibrium_newton.ITERATION])) if status == equilibrium_newton.FOUND else None

    def _say_undefined(self) -> None:
        """Store what has no finite value at the present position; Ctrl-C in a law is raised again."""
        load_law.complaint(-math.inf)
        self.undefined = self.undefined or undefined(self.system, self.workspace, self.t)

    def walk(self, q: np.ndarray, direction: np.ndarray, stride: float) -> tuple[bool, float, float]:
        """Step of length `stride` [m] along the free motion, q (3 nb,) and direction (3 nb,) in place.

        Returns whether it succeeded, the force along the motion [N] and the largest reduced force [N].
        """
        r = self.room
        self.trials += 1
        gap, along, most = equilibrium_newton.walk(
            self.workspace, self.t, q, self.scale, self.system.size, stride, direction, r.wide, r.norm, r.order,
            r.pivot, r.null, r.line,
        )  # fmt: skip
        return gap < math.inf, float(along), float(most)

    def displace(self, q: np.ndarray, target: np.ndarray) -> None:
        """Bring the residuals of all rows to `target` (nr,) [m or rad] by the least change of q (3 nb,), in place."""
        r = self.room
        equilibrium_newton.displace(self.workspace, q, target, self.scale, 6, r.wide, r.norm, r.order, r.pivot, r.line)

    def force_scale(self) -> float:
        """Typical size of the acting forces [N]."""
        return float(reduced_forces.force_size(self.workspace, self.system.size))

    def assess(self, q: np.ndarray, iterations: int) -> Found:
        """Stability, residuals and output row of the equilibrium q (3 nb,) [m, m, rad], left in the workspace."""
        workspace, system = self.workspace, self.system
        turning = self.turn(q)
        g, null = self.reduce(q)
        eigenvalue, neutral, falling = math.inf, 0, 0
        if len(g):
            h = self.hessian(q, null)
            largest = float(np.abs(h).max())
            even = float(np.abs(h - h.T).max()) <= EVEN * largest  # conservative loads
            roots = np.linalg.eigvalsh(0.5 * (h + h.T)) if even else np.linalg.eigvals(h)
            values = roots.real
            # only what is within rounding counts as zero: a soft direction beside a stiff contact is not neutral
            tiny = max(NEUTRAL[0] * self.force_scale() / system.size, NEUTRAL[1] * float(np.abs(values).max()))
            neutral, falling = int((np.abs(roots) < tiny).sum()), int((values <= -tiny).sum())
            eigenvalue = float(values.min()) if abs(values.min()) >= tiny else 0.0
        force_at(workspace, self.t, q, self.out)
        gap = float(np.abs(workspace.rows[:, at.RES]).max(initial=0.0))
        residual = float(np.abs(self.out * self.scale).max(initial=0.0))
        if not residual < math.inf:
            self._say_undefined()
        workspace.acceleration[:] = 0.0
        workspace.rows[:, at.NU] = 0.0  # at rest
        raw = np.zeros(width(system))
        write(workspace, 0.0, 0.0, raw)
        return Found(
            q.copy(), workspace.multiplier.copy(), eigenvalue, residual, gap, iterations,
            nonunique_reactions(system, workspace) if self.redundant else (),
            len(g), neutral, falling, float(workspace.power[at.POTENTIAL_ENERGY]), self.force_scale(), raw,
            turning,
        )  # fmt: skip

    def describe(self, solutions: Sequence[Found]) -> list[Equilibrium]:
        """Equilibria with all their quantities."""
        if not solutions:
            return []
        turning = np.array([solution.turning for solution in solutions]) if self.oiled else None
        data, names, units = columns(self.system, np.array([solution.raw for solution in solutions]), turning)
        keep = [k for k, name in enumerate(names) if name not in ("energy.work", "energy.dissipated", "energy.balance")]
        if self.table is None:
            self.table = self._table([names[k] for k in keep], units)
        data = np.ascontiguousarray(data[:, keep])
        return [
            Equilibrium(
                self.t, solution.q, solution.multiplier, solution.eigenvalue, solution.residual, solution.gap,
                solution.iterations, solution.nonunique, solution.dof, solution.neutral, solution.falling, row,
                self.table,
            )
            for solution, row in zip(solutions, data, strict=True)
        ]  # fmt: skip

    def _table(self, names: Sequence[str], units: Mapping[str, str]) -> Table:
        column = {name: k for k, name in enumerate(names)}
        drawn = geometry(self.system.model)
        pins = [name for name, joint in drawn["joints"].items() if joint["contact"] not in ("", "ideal")]
        pins += [
            name
            for name, joint in self.system.model.joints.items()
            if joint.contact is not None and joint.contact.pushes
        ]
        return Table(
            column,
            {name: units[name] for name in names},
            tuple((name, column[f"{name}.normal"]) for name in pins if f"{name}.normal" in column),
            drawn,
            provenance(self.system.model, "equilibrium"),
        )

    def finish(self, q: np.ndarray, iterations: int) -> Equilibrium:
        """The equilibrium at q (3 nb,) [m, m, rad] with all its quantities."""
        return self.describe([self.assess(q, iterations)])[0]
