"""The mechanism that a hand moves: its motors and loads let go, every play an inequality.

Positions q satisfy Phi(q) = 0 and g(q) >= 0: the rows of joints and the gaps of contacts, which are those of play,
stops, surfaces, flanks and pawls; all come from the kernels of the joints.  A massless link is let go, so that its pin
moves anywhere in its bush.  Changes are measured by masses, u_i = sqrt(m_i / sum m) q_i [m], as in the assembly.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from rattle.analyses.assembly.rank import RANK
from rattle.description.model import DEFAULT_STOP, Contact, Driver, Joint, Model, Stop
from rattle.equations.closure import close_position, open_by
from rattle.equations.compliant import locate_contacts
from rattle.equations.dense import dense_rows
from rattle.equations.system import System, compile_system, is_link
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.registry import kinds
from rattle.solvers.contacts.pawls import seat_pawls

CLOSED = 1e-12  # sizes of the mechanism, or rad, to which joints and pressed contacts are closed
ITERATIONS = 25  # of Newton's method
NATIVE = 1e-13  # sizes of the mechanism to which its compiled form goes where nothing presses
MOST_TURN = 0.5  # rotation of a body in one step [rad]


def let_go(system: System, q: np.ndarray, motors: bool) -> Model:
    """The model as a hand finds it at q (3 nb,).  motors: they hold what they drive where it is."""
    model = system.model
    drivers: dict[str, Driver] = {}
    for name, driver in model.drivers.items():
        if driver.moves_ground or motors:
            drivers[name] = replace(driver, kind=driver.leaf.rate_of or driver.kind, value=0.0, constants=())
    joints = {name: _let_go(joint) for name, joint in model.joints.items()}
    free = replace(model, drivers=drivers, joints=joints, loads={}, signals={}, signal_units={}, states={})
    if not drivers:
        return free
    loose = compile_system(free)
    workspace = loose.workspace()
    open_by(workspace, 0.0, q, np.zeros_like(q))
    values = {row.owner: float(workspace.rows[n, at.RES]) for n, row in enumerate(loose.rows) if row.driver}
    return replace(free, drivers={name: replace(driver, value=values[name]) for name, driver in drivers.items()})


def _let_go(joint: Joint) -> Joint:
    """A joint as a hand finds it: no rod in its bush, no belt that stretches, a slot that ends."""
    rigid = Contact(DEFAULT_STOP, dict.fromkeys(kinds("contact")[DEFAULT_STOP].fields, 0.0))
    if is_link(joint):
        return replace(joint, contact=rigid)
    if joint.is_loose:
        stretches = joint.one_sided is not None and joint.one_sided.stiff_in_kinematics
        return replace(joint, contact=None) if stretches else joint
    travel = joint.leaf.travel(joint.fields)
    if travel < math.inf and not joint.passing:
        low, high = (joint.stop.minimum, joint.stop.maximum) if joint.stop is not None else (-math.inf, math.inf)
        return replace(joint, stop=Stop(max(low, -travel), min(high, travel), rigid))
    return joint


class Movable:
    """Rows, gaps and their slopes at positions q (3 nb,) [m, m, rad]; the closing of joints by least change."""

    def __init__(self, system: System, q: np.ndarray, motors: bool = False) -> None:
        functions.start()
        self._stopped = {name for name, joint in system.model.joints.items() if joint.stop is not None}
        self.system = compile_system(let_go(system, q, motors))
        self.workspace, self.size = self.system.workspace(), self.system.size
        weight = self.system.arrays["weight"][1:].ravel()
        mass = 1.0 / weight
        self.scale: np.ndarray = np.sqrt(mass / (mass[::3].sum() or 1.0))  # (3 nb,) of u = scale q
        contact = self.system.arrays["contact"]
        self._still = np.zeros(len(self.scale))
        self._a, self._b = contact[:, at.A_BODY], contact[:, at.B_BODY]
        self.acts = contact[:, at.LEVEL] == 0  # (nc,) contacts with a gap
        angular = self.system.arrays["lever"][:, at.ANGULAR] > 0.0
        self.unit: np.ndarray = np.where(angular, 1.0, self.size)  # (nc,) of gaps

    def own_stop(self, joint: str) -> bool:
        """True if the model gives a joint a stop, False of the end of a slot."""
        return joint in self._stopped

    def locate(self, q: np.ndarray) -> None:
        """Rows and contacts at q into the workspace."""
        open_by(self.workspace, 0.0, q, self._still)
        if len(self.acts):
            locate_contacts(self.workspace)

    @property
    def residual(self) -> np.ndarray:
        """(nr,) Phi [m, rad] where it was located last."""
        values: np.ndarray = self.workspace.rows[:, at.RES]
        return values.copy()

    @property
    def rows(self) -> np.ndarray:
        """(nr, 3 nb) slopes of Phi by u there."""
        rows: np.ndarray = dense_rows(self.system, self.workspace) / self.scale
        return rows

    @property
    def gaps(self) -> np.ndarray:
        """(nc,) gaps there, in sizes of the mechanism or rad; infinite where a contact has none."""
        return np.where(self.acts, self.workspace.contact_kinematics[:, at.GAP] / self.unit, np.inf)

    def sides(self, which: np.ndarray) -> np.ndarray:
        """(k, 3 nb) slopes of the gaps of some contacts by u there."""
        full, line = np.zeros((len(which), self.system.body_count + 1, 3)), np.arange(len(which))
        on_a, on_b = self._ends(which)
        full[line, self._a[which]] += on_a
        full[line, self._b[which]] += on_b
        by_u: np.ndarray = full.reshape(len(which), 3 * full.shape[1])[:, 3:] / self.scale
        return by_u

    def _ends(self, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(k, 3) slopes of the gaps of some contacts by x, y, angle of their body A and of B."""
        touch = self.workspace.contact_kinematics[which]
        nx, ny, turn = touch[:, at.NX], touch[:, at.NY], touch[:, at.TURN]
        ends = np.empty((2, len(which), 3))
        ends[:, :, 0], ends[:, :, 1] = nx, ny
        ends[0, :, 2] = turn - nx * touch[:, at.PAY] + ny * touch[:, at.PAX]
        ends[1, :, 2] = turn - nx * touch[:, at.PBY] + ny * touch[:, at.PBX]
        ends /= self.unit[which, None]
        return ends[0], -ends[1]

    def push(self, reaction: np.ndarray, which: np.ndarray, factors: np.ndarray) -> np.ndarray:
        """(3 nb,) slopes by u of Phi times a reaction (nr,) and of the gaps of some contacts times factors (k,)."""
        total, rows = np.zeros((self.system.body_count + 1, 3)), self.workspace.rows
        if len(reaction):
            bodies = self.system.arrays["row_body"]
            np.add.at(total, bodies[:, at.ROW_A], reaction[:, None] * rows[:, at.AX : at.AP + 1])
            np.add.at(total, bodies[:, at.ROW_B], reaction[:, None] * rows[:, at.BX : at.BP + 1])
        if len(which):
            on_a, on_b = self._ends(which)
            np.add.at(total, self._a[which], factors[:, None] * on_a)
            np.add.at(total, self._b[which], factors[:, None] * on_b)
        by_q: np.ndarray = total[1:].ravel() / self.scale
        return by_q

    def closed(self, q: np.ndarray) -> np.ndarray | None:
        """Positions near q that satisfy all, with the least change; None if there are none near."""
        q = q.copy()
        if self.system.row_count:
            close_position(self.workspace, 0.0, q, np.empty_like(q), NATIVE * self.size, ITERATIONS)
        pressed, before = np.zeros(len(self.acts), bool), np.inf
        for _ in range(ITERATIONS):
            self.locate(q)
            gaps = self.gaps
            pressed |= gaps < -CLOSED
            which = np.flatnonzero(pressed)
            value = np.concatenate([self.residual / self.size, gaps[which]])
            largest = float(np.abs(value).max(initial=0.0))
            if largest <= CLOSED:
                return q
            if not largest < 2.0 * before:
                return None
            before = largest
            lines = np.vstack([self.rows / self.size, self.sides(which)])
            length = np.linalg.norm(lines, axis=1)
            length[length == 0.0] = 1.0
            change = np.linalg.lstsq(lines / length[:, None], -value / length, rcond=RANK)[0] / self.scale
            q += change * min(1.0, MOST_TURN / max(float(np.abs(change[2::3]).max()), 1e-300))
        return None

    def seat(self, q: np.ndarray) -> None:
        """Let pawls at q drop behind the teeth that they have passed."""
        if (self.system.arrays["contact"][:, at.TOOTHED] == 1).any():
            self.locate(q)
            seat_pawls(self.workspace, 0)
