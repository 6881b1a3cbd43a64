"""Runs with set-valued contacts: event-driven or Moreau-Jean, from a consistent start to a result."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from rattle import registry
from rattle.analyses.dynamics.failure import explain
from rattle.analyses.dynamics.peak_values import peak_arrays
from rattle.analyses.dynamics.run import Run, start_state
from rattle.analyses.dynamics.soundness import audit_arrays, set_floor, why_unsound
from rattle.equations import complementarity, contact_network, lemke, unilateral
from rattle.equations.complementarity import BACKWARD, FORWARD
from rattle.equations.motion import NOT_FINITE, OK, PAUSED, STEP_TOO_SMALL
from rattle.equations.system import System
from rattle.errors import ModelError, Problem
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace
from rattle.solvers import step_state
from rattle.solvers.gap_search import ESCAPED
from rattle.solvers.nonsmooth import (
    event_driven,
    event_search,
    impact_path,
    impact_phases,
    jams,
    moreau_jean,
    uniqueness,
)
from rattle.solvers.peaks import glances
from rattle.solvers.step_audit import UNSOUND

NEARLY_LOCKED = 1e-2  # share of G_nn that friction leaves of it where a run that cannot go on is called locked
TOGETHER = 1e-6  # the same of the smallest singular value of all contacts together
DEAD = 1e-8  # the same as a share of the largest one, where contacts that stick hold each other or the joints
STEPS = 20_000  # of Moreau-Jean over a run, when nothing is said


def has_impacts(system: System) -> bool:
    """True when the model has set-valued contacts."""
    return bool((system.arrays["contact"][:, at.IMPACT] == 1).any())


def choose_method(system: System, method: str, step: float | None, span: float) -> tuple[str, float | None]:
    """Method and step for a model with set-valued contacts over a time [s].

    Methods that know no impact become "event".  Raises ModelError when impact and compliant contacts are mixed.
    """
    if not (system.arrays["contact"][:, at.IMPACT] == 1).all():
        laws = {
            system.joints[row[at.OWNER]]: "impact" if row[at.IMPACT] else "compliant"
            for row in system.arrays["contact"]
        }
        listed = ", ".join(f"{name}: {law}" for name, law in laws.items())
        said = f"impact and compliant contacts do not go together ({listed}); give all joints one kind"
        first = next(name for name, law in laws.items() if law == "compliant")
        raise ModelError([Problem(("joints", first, "contact"), said)])
    require_one_law(system, method)
    settings = system.model.settings
    if method != "moreau" and settings.method == "moreau" and step == settings.step:
        step = None  # it was meant for the other method
    if method == "moreau":
        return method, step or min(1e-4, span / STEPS)
    return "event", step


def require_one_law(system: System, method: str) -> None:
    """Raise ModelError when joints differ in their restitution law, or Moreau-Jean is to follow another than Newton's.

    An impact at several joints is one problem: it has one law.
    """
    choices = registry.kinds("contact")["impact"].fields["restitution_law"].choices
    laws = {
        system.joints[row[at.OWNER]]: choices[int(system.arrays["values"][row[at.NORMAL_P] + at.RESTITUTION_LAW])]
        for row in system.arrays["contact"]
    }
    first = next(iter(laws))
    for name, law in laws.items():
        if law != laws[first]:
            listed = ", ".join(f"{one}: {which}" for one, which in laws.items())
            said = f"impacts at several joints are one problem and want one law for all joints (now {listed})"
            raise ModelError([Problem(("joints", name, "contact", "restitution_law"), said)])
    if method == "moreau" and laws[first] != choices[0]:
        said = f'"{laws[first]}" works with method "event" only; Moreau-Jean has Newton\'s restitution'
        raise ModelError([Problem(("joints", first, "contact", "restitution_law"), said)])


def contact_arrays(system: System, lasting: bool) -> dict[str, Any]:
    """What set-valued contacts need besides the arrays of one instant; lasting: their forces are part of the motion."""
    nc, nr, nb = len(system.arrays["contact"]), system.row_count, system.body_count
    contact, solvers = system.arrays["contact"], (contact_network.KERNEL, lemke.KERNEL, uniqueness.KERNELS[0])
    laws = (impact_phases.expand_kernel, impact_path.path_kernel, uniqueness.KERNELS[1])
    return {
        **(contact_network.arrays(system.arrays["row_body"], contact) if nc > complementarity.FEW else {}),
        **{name: np.zeros(nc, np.int64) for name in ("mode", "active", "candidate", "slide")},
        "pivots": np.zeros(2 * nc, np.int64),
        "contact_jacobian": np.zeros((2 * nc, 6)),
        "velocity_response": np.zeros((2 * nc, 3 * nb)),
        "multiplier_response": np.zeros((2 * nc, nr)),
        "delassus": np.zeros((2 * nc, 2 * nc)),
        "side": np.zeros((4, 2 * nc)),
        "system": np.zeros((2 * nc, 2 * nc + 1)),
        "recent": np.full((nc, 2), -math.inf),
        "velocity_change": np.zeros((nb + 1, 3)),
        "multiplier_change": np.zeros(nr),
        "path": np.zeros((6, 2 * nc)),
        "bounce": np.zeros((7, 2 * nc)),
        "looks": np.zeros((event_search.LOOKS_KEPT, glances.KINDS * nc + 2)),
        "held": np.array([1.0, system.size, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
        "problem_table": functions.entries((*complementarity.KERNELS, *solvers, *laws)),
        **({"hold_table": functions.entries([unilateral.hold]), "glances": glances.table(nc)} if lasting else {}),
    }


class Leg(NamedTuple):
    """Equal steps of Moreau-Jean up to an instant, as if the run had taken such steps from its start on."""

    start: float  # [s]
    end: float  # [s]
    h: float  # [s]
    steps: int  # of the run at the end


class ImpactRun(Run):
    """A run of a model whose contacts are set-valued."""

    may_pass = False  # jams are passed by an impact without collision

    def prepare(self) -> Workspace:
        """Workspace of the run."""
        self.jams: list[tuple[float, str]] = []  # times [s] at which friction locked and what was closed there
        arrays = step_state.step_loop_arrays(start_state(self.system, self.start), len(self.system.watched))
        arrays |= step_state.stepper_arrays(self.method)
        arrays |= audit_arrays(self.system, self.method)
        contacts = contact_arrays(self.system, self.method == "event")
        return self.system.workspace(**arrays, **contacts, **peak_arrays(self.system))

    def begin(self, t: float) -> int:
        """Closed contacts find their modes and those that hit take their impact; see `Run.begin`."""
        self.take_sides(t)
        if self.method == "moreau":
            self.leg = Leg(t, t, 0.0, 0)
            moreau_jean.start(self.workspace, t)
            set_floor(self.system, self.workspace, self.rtol, self.atol)
            return PAUSED
        values, contact = self.workspace.values, self.system.arrays["contact"]
        self.may_pass = bool((values[contact[:, at.NORMAL_P] + at.JAM] > 0.0).any())
        self.stuck = np.array([-math.inf, 0.0, -1.0, 0.0])
        self.clock[step_state.T] = t
        status = int(event_driven.start(self.workspace, t))
        if status == unilateral.NO_SOLUTION and self.may_pass:
            status = OK if self.pass_jam(status, late=False) == PAUSED else status
        return super().begin(t) if status == OK else int(status)

    def take_sides(self, t: float) -> None:
        """Moreau-Jean lets the value of a switching function decide where it depends on the state."""
        if self.method == "event":
            super().take_sides(t)
            return
        self.piece = self.table.piece_at(t)
        self.table.take(self.workspace.code, self.piece)

    def take_steps(self, t: float, chunk: int, outputs: int) -> int:
        """Some steps towards the time t [s]; see `Run.take_steps`."""
        handle = self.workspace
        if self.method == "moreau":
            if t != self.leg.end:
                now, done = self.leg.end, int(self.tally[step_state.STEPS])
                count = max(1, math.ceil((t - now) / (self.step or self.t_end) * (1 - 1e-12)))
                h = (t - now) / count
                self.leg = Leg(now - done * h, t, h, done + count)
            out = self.t_eval[: len(self.t_eval) if t >= self.t_end else outputs]
            return int(moreau_jean.advance(handle, self.leg.start, self.leg.h, self.leg.steps, out, self.raw, chunk))
        h_max, out = self.step or math.inf, self.t_eval[:outputs]
        status = int(event_driven.advance(handle, t, self.rtol, self.atol, h_max, out, self.raw, chunk, self.stuck))
        if status in (unilateral.NO_SOLUTION, unilateral.LOCKED, STEP_TOO_SMALL) and self.may_pass:
            return self.pass_jam(status, late=status == unilateral.NO_SOLUTION)
        return status

    def pass_jam(self, status: int, late: bool) -> int:
        """Go on by an impact without collision where friction locks; PAUSED, or a trouble.

        late: the state is that of an event whose new modes were not found.
        """
        t, handle = float(self.clock[step_state.T]), self.workspace
        if self.jams and t - self.jams[-1][0] <= 1e-9 * self.t_end:  # once more at the same place: it does not help
            return status
        names = ", ".join(self._closed())
        if jams.pass_jam(handle, t, int(late)) != OK:
            return status
        self.jams.append((t, names))
        self.clock[step_state.H] = max(float(self.clock[step_state.H]), 1e-6 * (self.t_end - t))
        return self.go_on(t, True)

    def remarks(self) -> tuple[str, ...]:
        """What happened on the way that a result has to say."""
        said: tuple[str, ...] = ()
        if shared := int(self.workspace.held[complementarity.SHARED]):
            joint = self.system.joints[self.system.arrays["contact"][shared - 1, at.OWNER]]
            said = (
                f"how contacts that depend on each other share a force at joint '{joint}' is not unique: what is"
                " listed is one way of several, with the same motion",
            )
        if not self.jams:
            return said
        first = f"the first at t = {self.jams[0][0]:.9g} s at {self.jams[0][1]}"
        number = f"{len(self.jams)} impacts" if len(self.jams) > 1 else "1 impact"
        return (*said, f"friction locked contacts (Painleve), passed by {number} without collision, {first}")

    def go_on(self, t: float, jolted: bool) -> int:
        """Closed contacts find their modes anew; see `Run.go_on`."""
        if self.method == "moreau":
            return PAUSED
        status = int(event_driven.go_on(self.workspace, t, 1 if jolted else 0))
        return super().go_on(t, jolted) if status == OK else status

    def record_now(self, t: float) -> None:
        """Outputs at an instant are those of the step after it with Moreau-Jean; see `Run.record_now`."""
        if self.method == "event":
            super().record_now(t)

    def trouble(self, status: int) -> str:
        """Why the run cannot go on; contact problems are named."""
        if status == UNSOUND:
            return why_unsound(self)
        t = float(self.clock[step_state.T])
        names = ", ".join(self._closed()) or "the contacts"
        passed = "" if self.may_pass or self.method == "moreau" else ', and so does jam = "impact" in the contact'
        if status == unilateral.NO_SOLUTION and self.workspace.held[complementarity.OUTCOME] == complementarity.JAMMED:
            return (
                f"no solution of the contact problem at {names} was found at t = {t:.9g} s: on every path that was"
                " followed the force that presses contacts together makes them approach, as where friction jams a"
                " joint, though their modes are too many to try all; less friction, or a compliant contact, goes"
                f" on{passed}"
            )
        if status == unilateral.NO_SOLUTION:
            return (
                f"the contact problem at {names} has no solution at t = {t:.9g} s, whatever its contacts do (Painleve:"
                f" friction would have to jam the joint); less friction, or a compliant contact, goes on{passed}"
            )
        if status == unilateral.NOT_FOUND:
            return (
                f"no solution of the contact problem at {names} was found at t = {t:.9g} s, which does not mean"
                " that there is none: contacts or joints may depend on each other there; method moreau or a compliant"
                " contact may go on"
            )
        if status == unilateral.NOT_UNIQUE:
            return (
                f"the contact problem at {names} has several solutions at t = {t:.9g} s (Painleve: rigid bodies with"
                " this friction do not say which); less friction, a compliant contact or method moreau goes on"
            )
        if status == unilateral.LOCKED or (status == STEP_TOO_SMALL and self._locks(t)):
            return (
                f"friction locks {names} at t = {t:.9g} s: the normal force grows beyond all bounds (Painleve); less"
                f" friction, or a compliant contact, goes on{passed}"
            )
        if status == STEP_TOO_SMALL and (wedged := ", ".join(self._wedged(t))):
            return (
                f"friction holds {wedged} at t = {t:.9g} s while drivers or inertia push on: a dead end, where"
                " the force stays within friction however large it is, so that nothing slips and no rigid body passes;"
                " less friction, or a compliant contact, goes on"
            )
        if status == unilateral.CHATTER:
            joint = self.system.joints[self.system.arrays["contact"][int(self.stuck[2]), at.OWNER]]
            if self.stuck[3] > event_driven.MOST_IN_A_ROW:
                return (
                    f"{self.stuck[3]:.0f} events in a row, each within {event_driven.CROWDED * self.t_end:.2g} s of"
                    f" the one before, up to t = {t:.9g} s, last at joint '{joint}': contacts change faster than a run"
                    " can follow; a smaller restitution, a compliant contact or method moreau goes on"
                )
            return f"contacts change without end at t = {t:.9g} s, last at joint '{joint}'; method moreau goes on"
        if status == NOT_FINITE and self.method == "moreau":
            return f"the motion ran away at t = {t:.6g} s with the step of {self.step:.3g} s; try a smaller step"
        what = explain(self.system, self.workspace, self.t_end, status, self.method, self.rtol)
        if status == ESCAPED and self.method == "moreau":
            what += "; or the drivers push against a dead end, a position that rigid bodies cannot pass"
        return what

    def _locks(self, t: float) -> bool:
        """True when sliding contacts are about to lock by friction, alone or together: the proof of Painleve's name."""
        mode, contact = self.workspace.mode, self.system.arrays["contact"]
        rough = self.workspace.values[contact[:, at.NORMAL_P] + at.MU] > 0.0
        slides = (((mode == FORWARD) | (mode == BACKWARD)) & rough).any()
        if not slides:
            return False
        return float(jams.lock_share(self.workspace, t)) < NEARLY_LOCKED or self._firmness() < TOGETHER

    def _firmness(self) -> float:
        """Smallest singular value of a_n (a_t where they stick) of the closed contacts by their forces, as a share of
        that without friction of sliding; their modes and G are at hand."""
        least = [np.linalg.svd(self._driven(rough)[0], compute_uv=False)[-1] for rough in (True, False)]
        return float(least[0] / least[1]) if least[1] > 0.0 else 1.0

    def _driven(self, rough: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """G with friction of sliding, or without, on the lines of closed contacts; these contacts, and the lines."""
        mode, contact, g = self.workspace.mode, self.system.arrays["contact"], self.workspace.delassus
        closed = self.workspace.active[: int(((mode != complementarity.OFF) & (contact[:, at.IMPACT] == 1)).sum())]
        normal = 2 * np.arange(len(closed))
        lines = np.sort(np.concatenate([normal, normal[mode[closed] == complementarity.STICK] + 1]))
        drag = (mode[closed] == FORWARD) * 1.0 - (mode[closed] == BACKWARD)
        drag *= self.workspace.values[contact[closed, at.NORMAL_P] + at.MU] * (1.0 if rough else 0.0)
        matrix = g[:, : 2 * len(closed)].copy()
        matrix[:, normal] += drag * matrix[:, normal + 1]
        return matrix[np.ix_(lines, lines)], closed, lines

    def _wedged(self, t: float) -> list[str]:
        """Joints whose contacts friction holds where bodies are pushed on: forces in a ratio that changes no motion,
        which press and stay within friction, and along which b calls for ever more.  None where that is not so."""
        jams.lock_share(self.workspace, t)
        matrix, closed, lines = self._driven(True)
        if not (self.workspace.mode[closed] == complementarity.STICK).any() or not np.isfinite(matrix).all():
            return []
        b, force = self.workspace.side[complementarity.B, lines], np.zeros(2 * len(closed))
        rates, sizes, forces = np.linalg.svd(matrix)
        called = -float(rates[:, -1] @ b)
        force[lines] = math.copysign(1.0, called) * forces[-1]
        pressed, held = force[0::2], np.abs(force[1::2])
        friction = self.workspace.values[self.system.arrays["contact"][closed, at.NORMAL_P] + at.MU]
        if sizes[-1] > DEAD * sizes[0] or abs(called) < DEAD * np.abs(b).max():
            return []
        if (pressed < -1e-3 * pressed.max()).any() or (held > friction * pressed + 1e-3 * pressed.max()).any():
            return []
        owner = self.system.arrays["contact"][closed[pressed > 1e-3 * pressed.max()], at.OWNER]
        return [f"'{name}'" for name in dict.fromkeys(self.system.joints[n] for n in owner)]

    def _closed(self) -> list[str]:
        owner, mode = self.system.arrays["contact"][:, at.OWNER], self.workspace.mode
        touching = (mode != complementarity.OFF) | (self.workspace.contact_kinematics[:, 0] < 1e-6 * self.system.size)
        return [f"'{name}'" for name in dict.fromkeys(self.system.joints[n] for n in owner[touching])]
