"""Proofs that a stopped run could not go on: by linear programmes and by enumeration, from rows in plain NumPy.

One-sided rows w of stops and ideal clutches, beside joints that ask Phi v = nu and Phi a = gamma:

    min s >= 0   such that   w v >= -s                and   min s >= 0   such that   w a >= g'' - s for rows at rest

over all rates and accelerations that the joints allow.  s > 0 in one of them: no motion satisfies all rows, whatever
forces act.  Friction: in every combination of modes of the joints at rest, the forces that agree with the reactions
they cause themselves are sought from many starts.
"""

from __future__ import annotations

import itertools

import numpy as np
from scipy.optimize import linprog, root

import rattle as rt
from rattle.analyses.dynamics.methods import choose_stepper, new_run
from rattle.analyses.dynamics.run import How
from rattle.equations.complementarity import contact_row
from rattle.equations.compliant import locate_contacts
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.solvers.dry_friction_modes import solve_at
from rattle.solvers.nonsmooth.contact_projection import motion_without

TOUCHES = 1e-7  # gap of a stop that counts as closed [rad]: an event leaves 1e-12
RESTS = 1e-5  # rate of a row that counts as none [rad/s]: events err by the tolerance of the run
VIOLATED = 1e-6  # least s that proves [rad/s, rad/s^2]: the programme itself errs by 1e-9
STARTS = 20  # of the search for forces that agree with their reactions; the pairs of roots of two pins need a few
AGREES = 1e-7  # share by which forces and accelerations may miss: the search errs by 1e-10
DEPENDENT = 1e-9  # singular value, of the largest one, that counts as zero
MOST = 1e5  # times those that the joints ask for: an event at a dead centre, off by 1e-8, leaves only larger motions


def stopped(text: str, duration: float, rtol: float = 1e-8):
    """The run of a model file after its last step, its message in `message`."""
    functions.start()
    mechanism = rt.loads(text)
    system = mechanism.system
    stepper, step = choose_stepper(system, None, None, duration)
    how = How(stepper, rtol, 1e-2 * rtol, step)
    run = new_run(system, mechanism.start, np.array([0, duration]), duration, how)
    run.go()
    return run


def joint_rows(w) -> np.ndarray:
    rows = np.zeros((w.rows.shape[0], w.change.shape[0]))
    for r, side in itertools.product(range(len(rows)), range(2)):
        body = w.row_body[r, side]
        if body > 0:
            rows[r, 3 * body - 3 : 3 * body] += w.rows[r, at.AX + 3 * side : at.AX + 3 * side + 3]
    return rows


def least_violation(joints: np.ndarray, right: np.ndarray, rows: np.ndarray, least: np.ndarray) -> float:
    """Least s with rows x >= least - s for all x, within bounds, with joints x = right."""
    _, sizes, directions = np.linalg.svd(joints)
    rank = int((sizes > DEPENDENT * sizes[0]).sum())
    fixed, free = np.linalg.lstsq(joints, right, rcond=1e-11)[0], directions[rank:].T
    ways = rows @ free
    ways[np.abs(ways) < DEPENDENT] = 0.0
    count = ways.shape[1]
    most = MOST * (1.0 + np.abs(fixed).max() + np.abs(least).max())
    bounds = [(-most, most)] * count + [(0, None)]
    left = np.c_[-ways, -np.ones(len(rows))]
    found = linprog(np.r_[np.zeros(count), 1.0], A_ub=left, b_ub=rows @ fixed - least, bounds=bounds)
    return float(found.x[-1]) if found.status == 0 else 0.0


def one_sided(w) -> tuple[np.ndarray, np.ndarray]:
    """Rows of closed stops and of ideal clutches without a largest torque, and the accelerations they ask for."""
    rows, asked = [], []
    for n in range(len(w.contact)):
        clutch = w.contact[n, at.LEVEL] == 1
        gives_way = clutch and np.isfinite(w.values[w.contact[n, at.NORMAL_P] + at.MOST_TORQUE])
        is_open = not clutch and w.contact_kinematics[n, at.GAP] >= TOUCHES
        if w.contact[n, at.IMPACT] != 1 or gives_way or is_open:
            continue
        line, row = np.zeros((1, 6)), np.zeros(w.change.shape[0])
        contact_row(w, n, 0, line, 0)
        for side in range(2):
            body = w.contact[n, at.A_BODY + side]
            if body > 0:
                row[3 * body - 3 : 3 * body] -= line[0, 3 * side : 3 * side + 3]
        rows.append(row)
        asked.append(-w.contact_kinematics[n, at.GAMMA_N])
    return np.array(rows), np.array(asked)


def one_sided_rows_contradict(run) -> bool:
    """True if no rates or no accelerations satisfy all one-sided rows, before or after the last event."""
    w = run.workspace
    for y in (w.state.copy(), w.state_new.copy()):
        motion_without(w, run.clock[at.T], y)
        locate_contacts(w)
        rows, asked = one_sided(w)
        if len(rows) == 0:
            continue
        joints, v = joint_rows(w), y[w.change.shape[0] : 2 * w.change.shape[0]]
        if np.abs(joints @ v - w.rows[:, at.NU]).max(initial=0.0) > VIOLATED:
            continue  # not a state of the mechanism
        still = np.abs(rows @ v) < RESTS
        if least_violation(joints, w.rows[:, at.NU].copy(), rows, 0.0 * asked) > VIOLATED:
            return True
        if still.any() and least_violation(joints, w.rows[:, at.GAMMA].copy(), rows[still], asked[still]) > VIOLATED:
            return True
    return False


def no_friction_agrees(run) -> bool:
    """True if no modes of the joints that rub have forces that agree with the reactions they cause."""
    w, t = run.workspace, run.clock[at.T]
    y = w.state.copy()
    nq = w.change.shape[0]
    solve_at(w, t, y)
    joints, count = joint_rows(w), len(w.dry)
    rows = np.zeros((count, nq))
    for n in range(count):
        for body, c in ((w.dry[n, at.DRY_A], at.AX), (w.dry[n, at.DRY_B], at.BX)):
            if body > 0:
                rows[n, 3 * body - 3 : 3 * body] += w.dry_rows[n, c : c + 3]
    rates = rows @ y[nq : 2 * nq]
    choices = [(0, 1, -1) if abs(rate) < RESTS else (int(np.sign(rate)),) for rate in rates]
    return not any(agrees(w, joints, rows, rates, np.array(modes)) for modes in itertools.product(*choices))


def agrees(w, joints: np.ndarray, rows: np.ndarray, rates: np.ndarray, modes: np.ndarray) -> bool:
    """True if forces are found with which these modes of the joints that rub are possible."""
    nq, count, sticks = joints.shape[1], len(modes), modes == 0
    held = np.vstack([joints, rows[sticks]])
    matrix = np.block([[np.diag(1 / w.weight[1:].ravel()), held.T], [held, np.zeros((len(held), len(held)))]])
    inverse = np.linalg.pinv(matrix, rcond=1e-12)
    asked = np.r_[w.rows[:, at.GAMMA], w.dry_rows[sticks, at.GAMMA]]
    applied = w.force[1:].ravel()

    def motion(tau):
        return inverse @ np.r_[applied + rows[~sticks].T @ tau, asked]

    def grips(x, static):
        return np.array([grip(w, n, x[nq : nq + len(joints)], static) for n in range(count)])

    def wrong(tau):
        return tau + modes[~sticks] * grips(motion(tau), False)[~sticks]

    rng = np.random.default_rng(1)
    size = 1.0 + np.abs(applied).max()
    for start in range(STARTS):
        found = root(wrong, start * size * rng.normal(0.0, 1.0, (~sticks).sum())) if (~sticks).any() else None
        tau = found.x if found is not None else np.zeros(0)
        if found is not None and np.abs(wrong(tau)).max() > AGREES * size:
            continue
        x = motion(tau)
        holding = np.abs(x[nq + len(joints) :]) <= grips(x, True)[sticks] * (1 + AGREES) + AGREES
        follows = np.abs(held @ x[:nq] - asked) <= AGREES * (1.0 + np.abs(x[:nq]).max())
        ahead = (rows @ x[:nq] - w.dry_rows[:, at.GAMMA]) * modes >= -AGREES * (1.0 + np.abs(x[:nq]).max())
        if follows.all() and holding.all() and (ahead | (np.abs(rates) >= RESTS)).all():
            return True
    return False


def grip(w, n: int, reactions: np.ndarray, static: bool) -> float:
    """Largest force or torque of friction n with these reactions."""
    p, row = w.dry[n, at.DRY_P], w.dry[n, at.DRY_ROW]
    a, b = reactions[row], reactions[row + 1]
    pin = w.dry[n, at.DRY_FORM] == at.DRY_PIN
    pressing = np.hypot(a, b) if pin else max(abs(a), w.values[p + at.DRY_REACH] * abs(b))
    return w.values[p + (at.DRY_MU_STATIC if static else at.DRY_MU)] * w.values[p + at.DRY_ARM] * pressing
