"""Motion of planar bodies in maximal coordinates: M a + Phi_q^T lambda = Q, Phi_q a = gamma, by dense linear algebra.

Coordinates are x, y [m] of the mass centre and the angle [rad] of each body, one after the other.  A joint is a list of
scalar functions Phi(q, t); those of a pin are x and y of B's point less A's, so that -lambda is the force on B.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import solve_ivp

from reference.jets import Jet, cos, sin, sqrt

RANK = 1e-9  # share of the largest singular value below which one counts as zero
GROUND = -1


@dataclass(frozen=True)
class Body:
    mass: float
    inertia: float


Row = Callable[[Sequence[Jet], Jet], Jet]  # Phi(q, t)


def point(q, body: int, place):
    """A point given in the body's frame, in the ground frame."""
    if body == GROUND:
        return place[0], place[1]
    x, y, phi = q[3 * body : 3 * body + 3]
    c, s = cos(phi), sin(phi)
    return x + c * place[0] - s * place[1], y + s * place[0] + c * place[1]


def angle(q, body: int):
    return 0.0 if body == GROUND else q[3 * body + 2]


def revolute(a, place_a, b, place_b) -> list[Row]:
    def row(k):
        return lambda q, t: point(q, b, place_b)[k] - point(q, a, place_a)[k]

    return [row(0), row(1)]


def _across(a, place_a, b, place_b, axis) -> Row:
    def row(q, t):
        (xa, ya), (xb, yb) = point(q, a, place_a), point(q, b, place_b)
        way = angle(q, a) + axis
        return cos(way) * (yb - ya) - sin(way) * (xb - xa)

    return row


def slot(a, place_a, b, place_b, axis) -> list[Row]:
    return [_across(a, place_a, b, place_b, axis)]


def prismatic(a, place_a, b, place_b, axis, turned) -> list[Row]:
    return [_across(a, place_a, b, place_b, axis), lambda q, t: angle(q, b) - angle(q, a) - turned]


def rod(a, place_a, b, place_b, length) -> list[Row]:
    def row(q, t):
        (xa, ya), (xb, yb) = point(q, a, place_a), point(q, b, place_b)
        return sqrt((xb - xa) * (xb - xa) + (yb - ya) * (yb - ya)) - length

    return [row]


def driver(a, b, start, speed) -> list[Row]:
    return [lambda q, t: angle(q, b) - angle(q, a) - start - speed * t]


@dataclass
class Mechanism:
    bodies: list[Body]
    rows: list[Row] = field(default_factory=list)
    forces: list[Callable] = field(default_factory=list)  # Q(q, v, t), (3 nb,)

    def mass(self) -> np.ndarray:
        return np.array([m for body in self.bodies for m in (body.mass, body.mass, body.inertia)])

    def constraints(self, q, v, t):
        """Phi (n,), Phi_q (n, 3 nb), Phi_t (n,), and gamma (n,) of Phi_q a = gamma."""
        n, size = len(self.rows), len(q)
        along = [Jet(x, u) for x, u in zip(q, v, strict=True)]
        moving = [row(along, Jet(t, 1.0)) for row in self.rows]
        jacobian = np.zeros((n, size))
        for k in range(size):
            turned = [Jet(x, 1.0 if j == k else 0.0) for j, x in enumerate(q)]
            jacobian[:, k] = [_first(row(turned, Jet(t))) for row in self.rows]
        still = [row([Jet(x) for x in q], Jet(t, 1.0)) for row in self.rows]
        phi = np.array([jet_value(x) for x in still])
        return phi, jacobian, np.array([_first(x) for x in still]), -np.array([x.second for x in moving])

    def load(self, q, v, t) -> np.ndarray:
        return np.sum([force(q, v, t) for force in self.forces], axis=0) if self.forces else np.zeros(len(q))

    def accelerations(self, q, v, t, rank=None):
        """Accelerations (3 nb,), multipliers (n,) of least norm, and which of them are unique (n,)."""
        _, jacobian, _, gamma = self.constraints(q, v, t)
        return solve(self.mass(), jacobian, gamma, self.load(q, v, t), rank)

    def run(self, q, v, t_end, rtol=1e-11):
        """State (6 nb,) at the end, from t = 0; redundant rows stay so, whatever drift makes of them."""
        size = len(q)
        rank = rank_of(self.mass(), self.constraints(q, v, 0.0)[1])

        def rate(t, y):
            return np.concatenate([y[size:], self.accelerations(y[:size], y[size:], t, rank)[0]])

        done = solve_ivp(rate, (0.0, t_end), np.concatenate([q, v]), method="DOP853", rtol=rtol, atol=1e-13)
        assert done.success
        return done.y[:, -1]


def _first(x) -> float:
    return x.first if isinstance(x, Jet) else 0.0


def jet_value(x) -> float:
    return x.value if isinstance(x, Jet) else float(x)


def rank_of(mass, jacobian) -> int:
    """How many independent rows a Jacobian has."""
    s = np.linalg.svd(jacobian / np.sqrt(mass), compute_uv=False) if len(jacobian) else np.zeros(0)
    return int((s > RANK * s[0]).sum()) if len(s) else 0


def solve(mass, jacobian, gamma, load, rank=None):
    """Accelerations, multipliers of least norm and which are unique, for any rank of the Jacobian."""
    if not len(jacobian):
        return load / mass, np.zeros(0), np.zeros(0, bool)
    root = 1.0 / np.sqrt(mass)
    scaled = jacobian * root  # of accelerations times the roots of the masses
    u, s, vt = np.linalg.svd(scaled)
    rank = int((s > RANK * s[0]).sum()) if rank is None else rank
    own, free = vt[:rank], vt[rank:]
    fixed = own.T @ ((u[:, :rank].T @ gamma) / s[:rank])
    pulled = root * load
    acceleration = fixed + free.T @ (free @ pulled)
    multiplier = u[:, :rank] @ ((own @ (pulled - acceleration)) / s[:rank])
    null = u[:, rank:]  # combinations of rows that do nothing
    unique = np.abs(null).max(axis=1, initial=0.0) < 1e-7
    return root * acceleration, multiplier, unique
