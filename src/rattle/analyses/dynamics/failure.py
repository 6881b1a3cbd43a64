"""Failure report of a run, in words: what happened, when, where, and what to try."""

from __future__ import annotations

import numpy as np

from rattle.analyses.assembly.rank import describe_rank_loss, loose_without_mass
from rattle.analyses.undefined import evaluated, undefined
from rattle.elements.custom import load_law
from rattle.equations.complementarity import OFF
from rattle.equations.motion import NOT_FINITE
from rattle.equations.system import System
from rattle.interfaces.steppers import StepperKind
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace
from rattle.registry import Kind
from rattle.results.columns import width
from rattle.solvers.contacts.penetration import DEEP, ESCAPED
from rattle.solvers.output_row import record
from rattle.solvers.state_switches import SLIDES, argument, see
from rattle.solvers.stepper import FREE, usual_stepper

NEAR = 10.0  # lengths of the failed step within which contact laws are evaluated
GLANCE, SHARE = 1e-6, 1e-3  # how far to look back, as a share of the run, and a share of that
GROWN = 20.0  # factor by which a value grows towards a pole when the time to it shrinks by SHARE
BEYOND = 1e100  # of a position or rate in SI units, where no mechanism gets
NEARLY = 1e-2  # share of the largest singular value with which massless bodies count as held no more
LEAST_STEP = 1e-12  # length of a failed step [s] with which shorter ones are looked beyond
PAST_END = 1.0 + 1e-12  # ends of the run within which an instant or an output time lies in it, rounding allowed
TINY = 1e-12  # a contact that needs shorter steps is too stiff [s]
SENTENCES = {  # also in pages
    "locks": "friction locks the mechanism at t = {t:.6g} s: no force in joint {joints} agrees with the reaction that"
    " it causes itself; try less friction, a smaller pin or a longer block",
    "grown": "cannot go on at t = {t:.6g} s: the motion grows beyond numbers ({curve} is {value:.3g} {unit}): it is"
    " unstable, or a load feeds it without end; end the run earlier, or add what limits it",
    "stiff": "cannot go on at t = {t:.6g} s: the contact of joint '{joint}' is so stiff that it needs steps below"
    ' {least:g} s. Lower its stiffness, or use contact = {{ model = "impact" }}',
    "missed": "a contact was missed: at t = {t:.9g} s joint '{joint}' is {depth:.3g} {unit} inside its wall ({size}),"
    " though not in contact; try a smaller rtol, or a shorter step",
    "clearance": "clearance {scale:g} m",
    "its_stop": "its stop",
    "to_and_fro": "cannot go on at t = {t:.6g} s: friction in {joints} sticks and slips to and fro without end; give it"
    " a regularised model such as coulomb-smooth",
}
STATE = (("x", "m"), ("y", "m"), ("angle", "rad"), ("vx", "m/s"), ("vy", "m/s"), ("omega", "rad/s"))


def explain(
    system: System, workspace: Workspace, t_end: float, status: int, stepper: Kind[StepperKind], rtol: float
) -> str:
    """One or two sentences on why a run by this stepper and with rtol [-] stopped at workspace.clock[T] [s].

    t_end: end of the run [s].
    """
    t = float(workspace.clock[at.T])
    if status == ESCAPED:
        return _escaped(system, workspace)
    grown = _grown(system, workspace) if stepper.leaf.adaptive else ""  # a step that is too long makes motions grow too
    what = load_law.complaint(t) or grown or not_finite(system, workspace, t_end)
    if what:
        return what
    if status == SLIDES:
        return _sliding(system, workspace)
    locked = workspace.dry_memory[:, at.DRY_LOCKS] == 1.0
    if locked.any():
        names = ", ".join(f"'{name}'" for name, locks in zip(system.dry_joints, locked, strict=True) if locks)
        return SENTENCES["locks"].format(t=t, joints=names)
    record(workspace, t, workspace.state, np.zeros(width(system)))
    what = _position(system, workspace, t) or _stiff(system, workspace)
    if what:
        return what
    if status == NOT_FINITE:
        return _too_large(system, workspace, stepper)
    return _pole(system, workspace, t_end) or _too_short(system, workspace, rtol)


def _position(system: System, workspace: Workspace, t: float) -> str:
    """In words, what cannot go on in the recorded position: massless bodies that nothing holds, lost rank; or ""."""
    if loose := loose_without_mass(system, workspace, NEARLY):
        names = ", ".join(f"'{name}'" for name, _ in loose)
        return (
            f"cannot go on at t = {t:.6g} s: in this position {names} can move without moving any mass, so that nothing"
            " limits accelerations there; give a mass to what has none"
        )
    rank = describe_rank_loss(system, workspace)
    return f"cannot go on at t = {t:.6g} s: {rank}" if rank else ""


def _stiff(system: System, workspace: Workspace) -> str:
    """In words, which compliant contact that is closed needs steps that are too short; "" if none."""
    compliant = system.arrays["contact"][:, at.IMPACT] == 0
    shut = np.flatnonzero((workspace.contact_memory[:, at.CLOSED] == at.SHUT) & compliant)
    if not len(shut) or not workspace.clock[at.H] < TINY:
        return ""
    joint = system.joints[system.arrays["contact"][shut[0], at.OWNER]]
    return SENTENCES["stiff"].format(t=workspace.clock[at.T], joint=joint, least=TINY)


def _too_large(system: System, workspace: Workspace, stepper: Kind[StepperKind]) -> str:
    """In words: the motion left the numbers, by a step that is too long or by forces, rates or accelerations."""
    t, h = float(workspace.clock[at.T]), float(workspace.clock[at.H])
    if not stepper.leaf.adaptive:
        other = usual_stepper(FREE)
        return f"the motion diverged at t = {t:.6g} s with the step of {h:.3g} s; try a smaller step or method {other}"
    size = np.abs(workspace.acceleration[1:]).max(axis=1)
    body = system.bodies[int(np.argmax(np.where(np.isfinite(size), size, np.inf)))]
    return (
        f"cannot go on at t = {t:.6g} s: forces, rates or accelerations are too large for numbers (worst at body"
        f" '{body}', {size.max():.3g} in SI units); look for a load, mass or rate that is far too large or small"
    )


def _too_short(system: System, workspace: Workspace, rtol: float) -> str:
    """In words: steps have become too short, which nothing else explains."""
    nq, clock = 3 * system.body_count, workspace.clock
    fastest = system.bodies[int(np.argmax(np.abs(workspace.rate[nq : 2 * nq]))) // 3]
    return (
        f"cannot go on at t = {clock[at.T]:.6g} s: the step fell below {clock[at.H]:.1g} s (worst at body '{fastest}');"
        f" {'look' if rtol >= 1e-6 else 'try a larger rtol, and look'} for a position that cannot be passed"
    )


def _grown(system: System, workspace: Workspace) -> str:
    """In words, which body is where no number can follow; "" if none."""
    size = np.abs(workspace.state[: 6 * system.body_count])
    if not size.max(initial=0.0) > BEYOND:
        return ""
    worst = int(np.argmax(size))
    key, unit = STATE[worst % 3 + 3 * (worst >= 3 * system.body_count)]
    curve = f"{system.bodies[worst // 3 % system.body_count]}.{key}"
    return SENTENCES["grown"].format(t=workspace.clock[at.T], curve=curve, value=workspace.state[worst], unit=unit)


def _escaped(system: System, workspace: Workspace) -> str:
    """In words, which contact is inside its wall, and by how much, from the gaps in the workspace."""
    contact = system.arrays["contact"]
    lever = system.arrays["lever"]
    scale = lever[:, at.GAP_SCALE]
    rigid = contact[:, at.IMPACT] == 1
    off = np.resize(workspace.mode == OFF, len(contact)) if rigid.any() else rigid
    shares = -workspace.contact_kinematics[:, at.GAP] / scale
    depth = np.where(np.where(rigid, off, workspace.contact_memory[:, at.CLOSED] == at.OPEN), shares, -np.inf)
    if not (depth > 0.1 * DEEP).any():  # Moreau-Jean: contacts have no modes between steps
        depth = shares
    n = int(np.argmax(depth))
    joint = system.joints[contact[n, at.OWNER]]
    unit = "rad" if lever[n, at.ANGULAR] > 0.0 else "m"
    size = SENTENCES["its_stop"]
    if contact[n, at.FORCE_COLUMN] == at.JOINT_NORMAL:
        size = SENTENCES["clearance"].format(scale=scale[n])
    t, deep = workspace.clock[at.TROUBLE], depth[n] * scale[n]
    return SENTENCES["missed"].format(t=t, joint=joint, depth=deep, unit=unit, size=size)


def _sliding(system: System, workspace: Workspace) -> str:
    """In words, which switch changes its side again and again."""
    t = float(workspace.landing[at.LAST_TURN])
    see(workspace, t, workspace.state)
    if not len(workspace.switch):
        return SENTENCES["to_and_fro"].format(t=t, joints=", ".join(system.rough_joints))
    sizes = [abs(float(argument(workspace, n, t))) for n in range(len(workspace.switch))]
    row = int(workspace.switch[int(np.argmin(sizes)), at.OWN_CODE])
    name = next(switch.name for switch in system.switches if switch.row == row)
    return (
        f"cannot go on at t = {t:.6g} s: {name} switches to and fro without end, each of its branches drives the motion"
        " back to the other. Make the change gradual, as tanh(x/width) for sign(x); for dry friction use `friction` of"
        " a joint or its contact"
    )


def not_finite(system: System, workspace: Workspace, t_end: float) -> str:
    """In words, which expression or law has no finite value near the last state, and when; "" if none.

    t_end: end of the run [s].
    """
    clock, y, f = workspace.clock, workspace.state, workspace.rate
    start = float(clock[at.T])
    reach = max(float(clock[at.TROUBLE]) - start, LEAST_STEP)
    for share in (0.0, 0.25, 0.5, 1.0, 2.0, 10.0, 1e3, 1e6):
        t = start + share * reach
        if t > t_end * PAST_END and share:
            break
        state = y + (t - start) * np.where(np.isfinite(f), f, 0.0)
        record(workspace, t, state, np.zeros(width(system)))
        why = undefined(system, workspace, t, contacts=share <= NEAR)
        if why:
            return why
    return ""


def _pole(system: System, workspace: Workspace, t_end: float) -> str:
    """In words, which expression grows without bound towards the last state; "" if none.

    Steps that shrink towards a pole never reach it, and beyond it values are finite again.  A pole is recognised by a
    value that grows by a constant factor each time the remaining time shrinks by a constant factor.
    """
    t, nq = float(workspace.clock[at.T]), 3 * system.body_count
    back = np.zeros_like(workspace.state)
    back[:nq] = workspace.state[nq : 2 * nq]
    sizes: list[dict[int, float]] = []
    for share in (GLANCE, GLANCE * SHARE, 0.0):
        now = t - share * t_end
        record(workspace, now, workspace.state - (t - now) * back, np.zeros(width(system)))
        sizes.append({first: float(np.abs(values).max()) for first, values in evaluated(system, workspace)})
    for first, least in sizes[0].items():
        middle, last = sizes[1][first], sizes[2][first]
        if 0.0 < GROWN * least < middle and GROWN * middle < last:
            name = system.live_names[system.program_starts.index(first)]
            return (
                f"{name} has no finite value at t = {t:.6g} s, towards which it grows without bound"
                f" (to {last:.3g} so far); check its domain (division by zero, logarithm)"
            )
    return ""
