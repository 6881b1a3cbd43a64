"""Failure report of set-valued contacts, in words: problems without a solution, friction that locks or wedges."""

from __future__ import annotations

import math

import numpy as np

from rattle.equations import complementarity, unilateral
from rattle.equations.complementarity import BACKWARD, FORWARD, STICK
from rattle.equations.motion import STEP_TOO_SMALL
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace
from rattle.solvers.nonsmooth import jams
from rattle.solvers.stepper import TIME_STEPPING, stepper_of

NEARLY_LOCKED = 1e-2  # share of G_nn left by friction, below which a run that cannot go on is called locked
DEPENDENT = 1e-12  # share of the largest singular value below which one is rounding
TOGETHER = 1e-4  # the same for the smallest singular value of all contacts together: test_rough_pins
FIRM = 0.05  # share of the mobility of a free body below which joints and drivers hardly let a contact give way
DEAD = 1e-8  # share of the largest singular value below which sticking contacts lock each other or the joints
PRESSES = 1e-3  # share of the largest force of a wedge below which a contact takes no part in it
JAM = ', or jam = "impact" in the contact'  # what else to try where contacts do not pass jams
SENTENCES = {  # on why a run ends, also in pages
    "path_jammed": "no solution of the contact problem at {joints} was found at t = {t:.9g} s: on every path that was"
    " followed the force that presses contacts together makes them approach, as where friction jams a joint; their"
    " modes are too many to try all. Try less friction, or a compliant contact{passed}",
    "no_solution": "the contact problem at {joints} has no solution at t = {t:.9g} s in any mode of its contacts"
    " (Painleve: friction would have to jam the joint); try less friction, or a compliant contact{passed}",
    "not_found": "no solution of the contact problem at {joints} was found at t = {t:.9g} s, which does not mean that"
    " there is none: contacts or joints may depend on each other there; try {other} or a compliant contact",
    "several": "the contact problem at {joints} has several solutions at t = {t:.9g} s (Painleve: rigid bodies with"
    " this friction do not determine which); try less friction, a compliant contact or {other}",
    "locks": "friction locks {joints} at t = {t:.9g} s: the normal force grows without bound (Painleve); try less"
    " friction, or a compliant contact{passed}",
    "driven_on": "drivers push {joints} on at t = {t:.9g} s where {what} is and nothing can give way: {remedy}",
    "moved_on": "the mechanism moves {joints} on at t = {t:.9g} s where {what} is and nothing can give way{rubs}: a"
    " dead end that rigid bodies cannot pass; {remedy}",
    "rubs": ", and friction of {joints} does not let it slow down",
    "joints_lock": "friction of {rough} locks {joints} at t = {t:.9g} s: the forces of the joints grow without bound;"
    " try less friction, or a compliant contact",
    "depend": "{joints} depend on each other at t = {t:.9g} s in a way that rounding decides; try {other} or a"
    " compliant contact",
    "all_contacts": "the contacts",
    "clutch": "a clutch",
    "stop": "a stop or wall",
    "torque": "give the clutch a max_torque",
    "compliant": "give the stop or wall a compliant contact",
    "motion": "change the motion of the drivers",
    "jam": JAM,
}
SHARED_TORQUE = (
    "the torque of {joints} is not unique at times, as joints or other clutches and contacts keep its bodies from"
    " turning against each other: the values listed are one of them, with the same motion as all others"
)
SHARED_FORCE = (
    "contacts that depend on each other can share a force at joint {joints} in several ways: the values listed are one"
    " of them, with the same motion as all others"
)
FREE_FRICTION = (
    "friction of contacts that hold each other at joint {joints} can have many sizes within its limits, and the motion"
    " goes with it: one with small forces is shown; less friction, or a compliant contact, tells more"
)


def contact_trouble(system: System, workspace: Workspace, t: float, status: int, passed: str) -> str:
    """Why contacts stop a run at t [s], in words; "" if they are not the reason.

    passed: what else to try when friction locks, as the end of a sentence.
    """
    names = ", ".join(joints_of(system, touching(system, workspace))) or SENTENCES["all_contacts"]
    other = f"method {stepper_of(TIME_STEPPING)}"
    sliding = bool(rough(system, workspace)[touching(system, workspace)].any())
    if status in (unilateral.NO_SOLUTION, unilateral.LOCKED) and not sliding:
        return trouble_without_friction(system, workspace, t, status, names)
    if status == unilateral.NO_SOLUTION:
        jammed = workspace.held[at.OUTCOME] == complementarity.JAMMED
        return SENTENCES["path_jammed" if jammed else "no_solution"].format(joints=names, t=t, passed=passed)
    if status == unilateral.NOT_FOUND:
        return SENTENCES["not_found"].format(joints=names, t=t, other=other)
    if status == unilateral.NOT_UNIQUE:  # if the force grows without bound, rounding decides what ends the run
        return dead_end(system, workspace, t) or SENTENCES["several"].format(joints=names, t=t, other=other)
    if status == unilateral.LOCKED or (status == STEP_TOO_SMALL and friction_locks(system, workspace, t)):
        return SENTENCES["locks"].format(joints=names, t=t, passed=passed)
    return dead_end(system, workspace, t) if status == STEP_TOO_SMALL else ""


def trouble_without_friction(system: System, workspace: Workspace, t: float, status: int, names: str) -> str:
    """The same of contacts without friction, whose joints are `names`, that have no solution or lock."""
    if status == unilateral.LOCKED:
        return dependent_or_locked(system, t, names)
    if workspace.dry_memory[:, at.DRY_LOCKS].any():
        return ""  # friction of joints has no force, with which contacts could be decided
    return no_way(system, workspace, t, names)


def dead_end(system: System, workspace: Workspace, t: float) -> str:
    """In words: friction holds contacts at t [s] that are pushed on, as they are or if all that touch stick; or ""."""
    kept = workspace.mode.copy()
    wedged = wedged_joints(system, workspace, t)
    if not wedged:
        workspace.mode[touching(system, workspace) & rough(system, workspace)] = STICK
        wedged = wedged_joints(system, workspace, t)
        workspace.mode[:] = kept
    if not wedged:
        return ""
    return (
        f"friction holds {', '.join(wedged)} at t = {t:.9g} s while drivers or inertia push on: a dead end, where"
        " the force stays inside the friction cone however large it is, so that nothing slips and no rigid body"
        " passes; try less friction, or a compliant contact"
    )


def no_way(system: System, workspace: Workspace, t: float, names: str) -> str:
    """In words: contacts without friction, whose joints are `names`, leave no motion at t [s]."""
    level = system.arrays["contact"][touching(system, workspace), at.LEVEL]
    kinds = [SENTENCES["clutch"]] * bool((level == 1).any()) + [SENTENCES["stop"]] * bool((level == 0).any())
    remedy = [SENTENCES["torque"]] * bool((level == 1).any()) + [SENTENCES["compliant"]] * bool((level == 0).any())
    what = " or ".join(kinds) or SENTENCES["stop"]
    if system.model.drivers:
        remedy = [SENTENCES["motion"], *remedy]
        return SENTENCES["driven_on"].format(joints=names, t=t, what=what, remedy=", or ".join(remedy))
    rubs = SENTENCES["rubs"].format(joints=", ".join(system.rough_joints)) if system.rough_joints else ""
    return SENTENCES["moved_on"].format(joints=names, t=t, what=what, rubs=rubs, remedy=", or ".join(remedy))


def dependent_or_locked(system: System, t: float, names: str) -> str:
    """In words: the forces of contacts without friction, whose joints are `names`, have no sense at t [s]."""
    if system.rough_joints:
        return SENTENCES["joints_lock"].format(rough=", ".join(system.rough_joints), joints=names, t=t)
    return SENTENCES["depend"].format(joints=names, t=t, other=f"method {stepper_of(TIME_STEPPING)}")


def joints_of(system: System, chosen: np.ndarray) -> list[str]:
    """Names of the joints of chosen contacts, in quotes; chosen: their numbers, or (nc,) True for them."""
    owner = system.arrays["contact"][chosen, at.OWNER]
    return [f"'{name}'" for name in dict.fromkeys(system.joints[n] for n in owner)]


def touching(system: System, workspace: Workspace) -> np.ndarray:
    """(nc,) True for set-valued contacts that are closed, or about to."""
    return np.array([bool(jams.touches(workspace, n)) for n in range(len(system.arrays["contact"]))], bool)


def rough(system: System, workspace: Workspace) -> np.ndarray:
    """(nc,) True for set-valued contacts with friction."""
    rigid = _rigid(system)
    rubbing = rigid.copy()
    rubbing[rigid] = workspace.values[system.arrays["contact"][rigid, at.NORMAL_P] + at.MU] > 0.0
    return rubbing


def _rigid(system: System) -> np.ndarray:
    """(nc,) True for set-valued contacts; the others have forces that depend on the state."""
    return np.asarray(system.arrays["contact"][:, at.IMPACT] == 1)


def friction_locks(system: System, workspace: Workspace, t: float) -> bool:
    """True if sliding contacts are about to lock by friction at t [s], alone or together (Painleve's paradox)."""
    mode = workspace.mode
    slides = (((mode == FORWARD) | (mode == BACKWARD)) & rough(system, workspace)).any()
    if not slides:
        return False
    return float(jams.lock_share(workspace, t)) < NEARLY_LOCKED or firmness(system, workspace) < TOGETHER


def firmness(system: System, workspace: Workspace) -> float:
    """Least singular value of the matrix from forces to a_n (and a_t if sticking) of the closed contacts, as a share
    [-] of that without sliding friction; modes and G in the workspace must be up to date.

    Values that are rounding without friction are left out: they belong to contacts that depend on each other.
    """
    rubbing, smooth = (
        np.linalg.svd(driven(system, workspace, friction)[0], compute_uv=False) for friction in (True, False)
    )
    firm = smooth > DEPENDENT * smooth.max(initial=0.0)
    return float((rubbing[firm] / smooth[firm]).min()) if firm.any() else 1.0


def driven(system: System, workspace: Workspace, rough: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """G [1/kg] with (rough) or without sliding friction, on the lines of closed contacts; contacts and lines."""
    mode, contact, g = workspace.mode, system.arrays["contact"], workspace.delassus
    closed = workspace.active[: int(((mode != complementarity.OFF) & (contact[:, at.IMPACT] == 1)).sum())]
    normal = 2 * np.arange(len(closed))
    lines = np.sort(np.concatenate([normal, normal[mode[closed] == STICK] + 1]))
    drag = (mode[closed] == FORWARD) * 1.0 - (mode[closed] == BACKWARD)
    drag *= workspace.values[contact[closed, at.NORMAL_P] + at.MU] * (1.0 if rough else 0.0)
    matrix = g[:, : 2 * len(closed)].copy()
    matrix[:, normal] += drag * matrix[:, normal + 1]
    return matrix[np.ix_(lines, lines)], closed, lines


def wedged_joints(system: System, workspace: Workspace, t: float) -> list[str]:
    """Joints locked by friction at t [s] while bodies are pushed on; empty if there are none.

    Their forces have a ratio that does not change the motion, press, and stay inside the friction cone, while b demands
    ever more of them.
    """
    jams.lock_share(workspace, t)
    matrix, closed, lines = driven(system, workspace, True)
    if not (workspace.mode[closed] == STICK).any() or not np.isfinite(matrix).all():
        return []
    b, force = workspace.side[complementarity.B, lines], np.zeros(2 * len(closed))
    rates, sizes, forces = np.linalg.svd(matrix)
    called = -float(rates[:, -1] @ b)
    force[lines] = math.copysign(1.0, called) * forces[-1]
    pressed, held = force[0::2], np.abs(force[1::2])
    friction = workspace.values[system.arrays["contact"][closed, at.NORMAL_P] + at.MU]
    if sizes[-1] > DEAD * sizes[0] or abs(called) < DEAD * np.abs(b).max():
        return []
    if (pressed < -PRESSES * pressed.max()).any() or (held > friction * pressed + PRESSES * pressed.max()).any():
        return []
    return joints_of(system, closed[pressed > PRESSES * pressed.max()])


def firm_joints(system: System, workspace: Workspace, t: float) -> list[str]:
    """Joints, in quotes, with a closed contact that approaches at t [s] and that hardly any force can part.

    G_nn [1/kg] of a contact, with all joints and drivers, is compared with w_n M^-1 w_n^T of each of its bodies alone.
    """
    jams.lock_share(workspace, t)
    contact, weight = system.arrays["contact"], workspace.weight
    closed = (workspace.mode != complementarity.OFF) & (contact[:, at.IMPACT] == 1)
    names = []
    for k, n in enumerate(workspace.active[: int(closed.sum())]):
        lines = workspace.contact_jacobian[2 * k].reshape(2, 3)
        bodies = contact[n, [at.A_BODY, at.B_BODY]]
        alone = [float(line**2 @ weight[body]) for line, body in zip(lines, bodies, strict=True) if body > 0]
        if workspace.side[complementarity.B, 2 * k] < 0.0 and workspace.delassus[2 * k, 2 * k] < FIRM * min(alone):
            names.append(f"'{system.joints[contact[n, at.OWNER]]}'")
    return list(dict.fromkeys(names))


def against(system: System, names: str) -> str:
    """What else may have stopped a run: the joints (names, after a blank, or "") may be in a dead end."""
    if system.model.drivers:
        return f"the drivers push{names} against a dead end, a position that rigid bodies cannot pass"
    return f"bodies move{names} against a dead end, a position that rigid bodies cannot pass"


def shared_forces(system: System, workspace: Workspace) -> tuple[str, ...]:
    """Notes on contacts whose forces the motion does not determine, if a run has met such ones."""
    unsure = workspace.contact_memory[:, at.UNSURE]
    clutch = system.arrays["contact"][:, at.LEVEL] == 1
    pairs = (
        (SHARED_TORQUE, (unsure > 0.0) & clutch), (SHARED_FORCE, (unsure == 1.0) & ~clutch),
        (FREE_FRICTION, (unsure == 2.0) & ~clutch),
    )  # fmt: skip
    return tuple(
        sentence.format(joints=", ".join(joints_of(system, chosen))) for sentence, chosen in pairs if chosen.any()
    )
