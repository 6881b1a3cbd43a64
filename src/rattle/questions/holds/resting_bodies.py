"""What one load may be so that bodies that rest on surfaces stay at rest: they neither slip nor tip.

    Q + p B + W_N^T N + W_T^T T + W_M^T M - Phi_q^T lambda = 0,     N >= 0,  |T| <= mu N,  |M| <= rho N

p: value of the load sought; M: resistance to rolling of a disc

Friction in the plane is linear, so that the least and the largest p are solutions of two linear programs.  By the
theory of limit analysis they hold the bodies with whatever friction of contacts and reactions is possible.

Source: Lynch, Park, Modern Robotics (2017), section 12.2 (friction cones, contact wrenches in the plane).
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from scipy.optimize import linprog

from rattle.analyses.history import require_known_torques, require_loads_without_states
from rattle.description.model import Model
from rattle.equations.compliant import locate_contacts
from rattle.equations.contact_table import contact_labels
from rattle.equations.dense import dense_rows
from rattle.equations.motion import place
from rattle.equations.system import System, is_link
from rattle.errors import InputError, ModelError, Problem
from rattle.jit import layout as at
from rattle.questions.holds.holding_range import HoldingRange
from rattle.questions.holds.one_motion import Sought, evaluated

TOUCHING = 1e-7  # share of the mechanism's size within which bodies touch
AT_LIMIT = 1e-7  # share of the largest force within which a contact slips, or carries nothing


def rests_on_surfaces(model: Model) -> bool:
    """True if what friction holds is a matter of surfaces."""
    return any(joint.leaf.touches for joint in model.joints.values())


def require_rigid(system: System) -> None:
    """Raise ModelError for what has no reactions at rest, or other friction."""
    require_loads_without_states(system.model, "equilibrium with friction")
    require_known_torques(system, "equilibrium with friction")
    for name, joint in system.model.joints.items():
        words = ""
        if joint.leaf.touches and joint.contact is not None and not joint.contact.rigid:
            words = 'what friction holds is known of rigid surfaces; give it contact = "impact"'
        elif not joint.leaf.touches and (joint.is_loose or is_link(joint)):
            words = "what friction holds beside surfaces is known of joints without play; close it with ideal()"
        elif not joint.leaf.touches and joint.friction and joint.friction.law is None:
            words = "what surfaces hold is known beside joints without friction of their own; leave it out"
        if words:
            raise ModelError([Problem(("joints", name), words)])


class Contacts:
    """The contacts that touch at a position: their rows and coefficients."""

    def __init__(self, system: System, q: np.ndarray) -> None:
        workspace = system.workspace()
        place(workspace, q, np.zeros_like(q))
        locate_contacts(workspace)
        self.names: list[str] = []
        normals, tangents, couples, coefficients, arms = [], [], [], [], []
        for n, (name, label) in enumerate(contact_labels(system.model)):
            joint, row = system.model.joints[name], workspace.contact_kinematics[n]
            if not joint.leaf.touches or joint.contact is None or row[at.GAP] > TOUCHING * system.size:
                continue
            self.names.append(f"{name} at {label}" if label else name)
            normals.append(_pushed(system, n, row, -row[at.NX], -row[at.NY]))
            tangents.append(_pushed(system, n, row, -row[at.NY], row[at.NX]))
            couples.append(_turned(system, n))
            coefficients.append(joint.contact.mu)
            arms.append(joint.contact.rolling)
        width = 3 * system.body_count
        self.normals = np.array(normals).reshape(-1, width)
        self.tangents = np.array(tangents).reshape(-1, width)
        self.couples = np.array(couples).reshape(-1, width)
        self.mu, self.rolling = np.array(coefficients), np.array(arms)


def _pushed(system: System, n: int, row: np.ndarray, x: float, y: float) -> np.ndarray:
    """Generalised force (3 nb,) of a unit force (x, y) of contact n on B, and its opposite on A."""
    force = np.zeros((system.body_count + 1, 3))
    entry = system.arrays["contact"][n]
    for body, sign, px, py in ((at.A_BODY, -1.0, at.PAX, at.PAY), (at.B_BODY, 1.0, at.PBX, at.PBY)):
        force[entry[body]] += sign * np.array([x, y, row[px] * y - row[py] * x])
    return force[1:].ravel()


def _turned(system: System, n: int) -> np.ndarray:
    """Generalised force (3 nb,) of a unit couple of contact n on B, and its opposite on A."""
    force, entry = np.zeros((system.body_count + 1, 3)), system.arrays["contact"][n]
    force[entry[at.B_BODY], 2] += 1.0
    force[entry[at.A_BODY], 2] -= 1.0
    return force[1:].ravel()


def surfaces_range(system: System, sought: Sought, t: float, q: np.ndarray, notes: tuple[str, ...]) -> HoldingRange:
    """The interval of values of a load for which all bodies stay at rest at q (3 nb,) [m, m, rad], t [s].

    Raises InputError if no value does.
    """
    workspace, contacts = evaluated(system, t, q), Contacts(system, q)
    rows = dense_rows(system, workspace)
    kept = np.arange(system.row_count) != sought.row
    force = workspace.force[1:].ravel() - (0.0 if sought.row >= 0 else sought.value * sought.direction)
    scale = np.ones(3 * system.body_count)
    scale[2::3] = 1.0 / system.size
    own = [contacts.normals, contacts.tangents, contacts.couples]
    columns = np.vstack([sought.direction, *own, rows[kept]]) * scale
    ends = [_end(columns, force * scale, contacts, sense) for sense in (1.0, -1.0)]
    if ends[0] is None or ends[1] is None:
        held = ", ".join(contacts.names) or "nothing"
        raise InputError(f"no value of {sought.name} holds it at rest there: what touches ({held}) is not enough")
    (low, how_low), (high, how_high) = ends[0], ends[1]
    smooth = _end(columns, force * scale, contacts, 1.0, rough=False)
    free = smooth[0] if smooth is not None else math.nan
    told = [f"just {word} that it {how}" for word, how in (("below", how_low), ("above", how_high)) if how]
    return HoldingRange(
        sought.name, sought.unit, sought.value, low, high, free, (math.inf, math.inf), t, q, (*told, *notes)
    )


def _end(
    columns: np.ndarray, force: np.ndarray, contacts: Contacts, sense: float, rough: bool = True
) -> tuple[float, str] | None:
    """The least (sense 1) or largest (-1) value of the load, and what happens beyond it; None if none is possible."""
    count, total = len(contacts.names), len(columns)
    cost, limits = np.zeros(total), np.zeros((4 * count, total))
    cost[0] = sense
    mu = contacts.mu if rough else 0.0 * contacts.mu
    for block, most in enumerate((mu, contacts.rolling if rough else 0.0 * mu), 1):  # friction, rolling resistance
        for k, sign in itertools.product(range(count), (1, -1)):
            row = 4 * k + 2 * block - 1 - (sign > 0)
            limits[row, 1 + block * count + k], limits[row, 1 + k] = sign, -most[k]
    free = (None, None)
    bounds = [free, *[(0.0, None)] * count, *[free] * (total - 1 - count)]
    size = float(np.abs(force).max(initial=0.0)) or 1.0
    answer = linprog(
        cost, limits if count else None, np.zeros(4 * count) if count else None, columns.T, -force / size, bounds
    )
    if answer.status == 3:  # no bound
        return -sense * math.inf, ""
    if answer.status != 0:
        return None
    normal, along = answer.x[1 : 1 + count], answer.x[1 + count : 1 + 2 * count]
    return size * float(answer.x[0]), _beyond(contacts, normal, along, mu)


def _beyond(contacts: Contacts, normal: np.ndarray, along: np.ndarray, mu: np.ndarray) -> str:
    """What is about to happen: which contacts slip, and which carry nothing."""
    least = AT_LIMIT * float(normal.max(initial=0.0))
    if not least > 0.0:
        return ""
    lifting = [name for name, force in zip(contacts.names, normal, strict=True) if force <= least]
    slipping = [
        name
        for name, force, friction, limit in zip(contacts.names, normal, along, mu, strict=True)
        if force > least and limit * force - abs(friction) <= AT_LIMIT * max(limit * force, least)
    ]
    words = []
    if len(slipping) + len(lifting) == len(contacts.names) and slipping:
        words.append(f"slips on {', '.join(slipping)}")
    elif lifting:
        words.append(f"tips: {', '.join(lifting)} lift{'s' * (len(lifting) == 1)} off")
    return " and ".join(words)
