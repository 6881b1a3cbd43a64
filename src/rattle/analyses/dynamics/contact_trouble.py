"""Why set-valued contacts stop a run, in words: problems without a solution, friction that locks or wedges."""

from __future__ import annotations

import math

import numpy as np

from rattle.equations import complementarity, unilateral
from rattle.equations.complementarity import BACKWARD, FORWARD
from rattle.equations.motion import STEP_TOO_SMALL
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace
from rattle.solvers.nonsmooth import jams
from rattle.solvers.stepper import TIME_STEPPING, stepper_of

NEARLY_LOCKED = 1e-2  # share of G_nn that friction leaves of it where a run that cannot go on is called locked
TOGETHER = 1e-6  # the same of the smallest singular value of all contacts together
DEAD = 1e-8  # the same as a share of the largest one, where contacts that stick hold each other or the joints


def contact_trouble(system: System, workspace: Workspace, t: float, status: int, passed: str) -> str:
    """Why contacts stop a run at t [s]; empty where it is not the contacts.

    passed: what else goes on where friction locks, as the end of a sentence.
    """
    names = ", ".join(closed_joints(system, workspace)) or "the contacts"
    other = f"method {stepper_of(TIME_STEPPING)}"
    if status == unilateral.NO_SOLUTION and workspace.held[complementarity.OUTCOME] == complementarity.JAMMED:
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
            f" that there is none: contacts or joints may depend on each other there; {other} or a compliant"
            " contact may go on"
        )
    if status == unilateral.NOT_UNIQUE:
        return (
            f"the contact problem at {names} has several solutions at t = {t:.9g} s (Painleve: rigid bodies with"
            f" this friction do not say which); less friction, a compliant contact or {other} goes on"
        )
    if status == unilateral.LOCKED or (status == STEP_TOO_SMALL and friction_locks(system, workspace, t)):
        return (
            f"friction locks {names} at t = {t:.9g} s: the normal force grows beyond all bounds (Painleve); less"
            f" friction, or a compliant contact, goes on{passed}"
        )
    if status == STEP_TOO_SMALL and (wedged := ", ".join(wedged_joints(system, workspace, t))):
        return (
            f"friction holds {wedged} at t = {t:.9g} s while drivers or inertia push on: a dead end, where"
            " the force stays within friction however large it is, so that nothing slips and no rigid body passes;"
            " less friction, or a compliant contact, goes on"
        )
    return ""


def closed_joints(system: System, workspace: Workspace) -> list[str]:
    """Names of the joints whose contacts are closed, in quotes."""
    owner, mode = system.arrays["contact"][:, at.OWNER], workspace.mode
    touching = (mode != complementarity.OFF) | (workspace.contact_kinematics[:, 0] < 1e-6 * system.size)
    return [f"'{name}'" for name in dict.fromkeys(system.joints[n] for n in owner[touching])]


def friction_locks(system: System, workspace: Workspace, t: float) -> bool:
    """True when sliding contacts are about to lock by friction, alone or together: the proof of Painleve's name."""
    mode, contact = workspace.mode, system.arrays["contact"]
    rough = workspace.values[contact[:, at.NORMAL_P] + at.MU] > 0.0
    slides = (((mode == FORWARD) | (mode == BACKWARD)) & rough).any()
    if not slides:
        return False
    return float(jams.lock_share(workspace, t)) < NEARLY_LOCKED or firmness(system, workspace) < TOGETHER


def firmness(system: System, workspace: Workspace) -> float:
    """Smallest singular value of a_n (a_t where they stick) of the closed contacts by their forces, as a share of
    that without friction of sliding; their modes and G are at hand."""
    least = [np.linalg.svd(driven(system, workspace, rough)[0], compute_uv=False)[-1] for rough in (True, False)]
    return float(least[0] / least[1]) if least[1] > 0.0 else 1.0


def driven(system: System, workspace: Workspace, rough: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """G with friction of sliding, or without, on the lines of closed contacts; these contacts, and the lines."""
    mode, contact, g = workspace.mode, system.arrays["contact"], workspace.delassus
    closed = workspace.active[: int(((mode != complementarity.OFF) & (contact[:, at.IMPACT] == 1)).sum())]
    normal = 2 * np.arange(len(closed))
    lines = np.sort(np.concatenate([normal, normal[mode[closed] == complementarity.STICK] + 1]))
    drag = (mode[closed] == FORWARD) * 1.0 - (mode[closed] == BACKWARD)
    drag *= workspace.values[contact[closed, at.NORMAL_P] + at.MU] * (1.0 if rough else 0.0)
    matrix = g[:, : 2 * len(closed)].copy()
    matrix[:, normal] += drag * matrix[:, normal + 1]
    return matrix[np.ix_(lines, lines)], closed, lines


def wedged_joints(system: System, workspace: Workspace, t: float) -> list[str]:
    """Joints whose contacts friction holds where bodies are pushed on: forces in a ratio that changes no motion,
    which press and stay within friction, and along which b calls for ever more.  None where that is not so."""
    jams.lock_share(workspace, t)
    matrix, closed, lines = driven(system, workspace, True)
    if not (workspace.mode[closed] == complementarity.STICK).any() or not np.isfinite(matrix).all():
        return []
    b, force = workspace.side[complementarity.B, lines], np.zeros(2 * len(closed))
    rates, sizes, forces = np.linalg.svd(matrix)
    called = -float(rates[:, -1] @ b)
    force[lines] = math.copysign(1.0, called) * forces[-1]
    pressed, held = force[0::2], np.abs(force[1::2])
    friction = workspace.values[system.arrays["contact"][closed, at.NORMAL_P] + at.MU]
    if sizes[-1] > DEAD * sizes[0] or abs(called) < DEAD * np.abs(b).max():
        return []
    if (pressed < -1e-3 * pressed.max()).any() or (held > friction * pressed + 1e-3 * pressed.max()).any():
        return []
    owner = system.arrays["contact"][closed[pressed > 1e-3 * pressed.max()], at.OWNER]
    return [f"'{name}'" for name in dict.fromkeys(system.joints[n] for n in owner)]


def shared_forces(system: System, workspace: Workspace) -> tuple[str, ...]:
    """That contacts which depend on each other could share a force in other ways, where a run has met that."""
    shared = int(workspace.held[complementarity.SHARED])
    if not shared:
        return ()
    joint = system.joints[system.arrays["contact"][shared - 1, at.OWNER]]
    return (
        f"how contacts that depend on each other share a force at joint '{joint}' is not unique: what is"
        " listed is one way of several, with the same motion",
    )
