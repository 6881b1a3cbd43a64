"""Impending motion of one degree of freedom against dry friction: which load overcomes it, and where it jams.

All joints with friction are about to slip in the senses of the one motion, their friction x is at its limit, and the
load does the work that it takes:

    x_n = theta mu_n N_n(lambda),   lambda = lambda_0 + Z x,   p = p_0 + r . x,   theta = 1          [N]

lambda_0: reactions without friction; Z: per unit of x, the load that overcomes it included; r: speeds of slip when the
load moves at 1.  x is followed from theta = 0, without friction, on.  (h, x) / (h + w . x) in place of x stays finite
where x -> infinity, h = 0: there, or where the path turns back, no load moves the mechanism, it jams.

Source: Meriam, Kraige, Engineering Mechanics: Statics, chapter 6 (impending motion); the path: this package.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

ROUNDS = 40  # Newton steps after which there is no solution
CLOSE = 1e-14  # share of x that ends them
FIRST = 0.125  # first step of theta
LEAST = 1e-13  # step of theta at which the path has turned back
MOST = 100.0  # theta up to which jamming is looked for
YIELDS = 1e-9  # [of the largest share] negative share above which less friction would hold more: below is rounding
NOTHING = 1e-12  # share of the forces below which a normal force is rounding


class Rubbing(NamedTuple):
    """The joints with friction, in the sense of one motion; n of them."""

    mu: np.ndarray  # (n,) coefficient at rest [-]
    reach: np.ndarray  # (n,) 1 / half length of the block [1/m]; nan of a pin
    still: np.ndarray  # (n, 2) the two multipliers of each without friction [N, N m]
    response: np.ndarray  # (n, 2, n) the same per unit of x [-, m]
    slip: np.ndarray  # (n,) r, not negative [-]
    rounding: float  # normal force below which there is none [N]


class Limit(NamedTuple):
    """Where motion is impending."""

    x: np.ndarray  # (n,) friction of every joint [N]; inf where it jams
    jams_at: float  # theta from which it jams; inf if it does not up to MOST


def normal_forces(rubbing: Rubbing, multiplier: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """N (n,) [N] of every joint by its multipliers (n, 2), and its slopes (n, 2)."""
    first, second = multiplier.T
    size = np.hypot(first, second)
    unit = np.divide(multiplier, size[:, None], out=np.zeros_like(multiplier), where=size[:, None] > 0.0)
    pin, tilts = np.isnan(rubbing.reach), rubbing.reach * np.abs(second) > np.abs(first)
    N = np.where(pin, size, np.where(tilts, rubbing.reach * np.abs(second), np.abs(first)))
    slope = np.stack(
        [np.where(tilts, 0.0, np.sign(first)), np.where(tilts, rubbing.reach * np.sign(second), 0.0)], axis=1
    )
    return N, np.where(pin[:, None], unit, slope)


def limit(rubbing: Rubbing, far: bool = True) -> Limit:
    """The friction of every joint where motion in this sense is impending, under the loads there are.

    far: also find where it would jam with more friction; if not, `jams_at` is inf unless it jams.
    """
    N, _ = normal_forces(rubbing, rubbing.still)
    if not (rubbing.mu * N > rubbing.mu * rubbing.rounding).any():  # nothing presses but the load that is sought
        alone = jams_at(rubbing)
        return Limit(np.full(len(rubbing.mu), math.inf if alone <= 1.0 else 0.0), alone)
    x, turned = _follow(rubbing, 1.0)
    if turned <= 1.0:
        return Limit(np.full(len(rubbing.mu), math.inf), turned)
    return Limit(x, jams_at(rubbing) if far else math.inf)


def jams_at(rubbing: Rubbing) -> float:
    """theta from which a load of any size jams that acts alone: x = theta mu N(Z x) has a solution; inf up to MOST.

    Found with reactions in place of lambda_0 that friction itself would make, so that x grows beyond all bounds there.
    """
    n = len(rubbing.mu)
    alike = rubbing.response @ np.full(n, 1.0 / n)
    N, _ = normal_forces(rubbing, alike)
    if not (rubbing.mu * N > NOTHING * np.abs(rubbing.response).max(initial=0.0)).any():
        return math.inf
    return _follow(rubbing._replace(still=alike), MOST)[1]


def yields_more(rubbing: Rubbing, x: np.ndarray) -> np.ndarray:
    """(n,) True for joints whose friction, if it were less than its limit, would let the others hold a larger load."""
    _, slopes = normal_forces(rubbing, rubbing.still + rubbing.response @ x)
    jacobian = np.eye(len(x)) - rubbing.mu[:, None] * np.einsum("ij,ijk->ik", slopes, rubbing.response)
    share = np.linalg.solve(jacobian.T, rubbing.slip)
    return np.asarray(share < -YIELDS * np.abs(share).max(initial=0.0))


def _follow(rubbing: Rubbing, until: float) -> tuple[np.ndarray, float]:
    """x (n,) at theta = `until`, or theta where it jams before (else inf)."""
    N, _ = normal_forces(rubbing, rubbing.still)
    weight = 1.0 / (rubbing.mu * N).sum()
    theta, step, y = 0.0, FIRST, np.zeros(len(rubbing.mu))
    while theta < until:
        ahead = min(theta + step, until)
        shares = _solve(rubbing, ahead, weight, y)
        if shares is None:
            step *= 0.5
            if step < LEAST * max(1.0, theta):
                return y, theta
            continue
        if weight * shares.sum() >= 1.0:
            return shares, _where_unbounded(rubbing, weight, theta, ahead, y)
        y, theta, step = shares, ahead, 1.5 * step
    return y / (1.0 - weight * y.sum()), math.inf


def _where_unbounded(rubbing: Rubbing, weight: float, low: float, high: float, y: np.ndarray) -> float:
    """theta between two others at which h = 0; y: at the lower one."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        shares = _solve(rubbing, middle, weight, y) if low < middle < high else None
        if shares is None:
            break
        if weight * shares.sum() >= 1.0:
            high = middle
        else:
            low, y = middle, shares
    return high


def _solve(rubbing: Rubbing, theta: float, weight: float, start: np.ndarray) -> np.ndarray | None:
    """y (n,), the share of x in (h, x) with h = 1 - weight sum(y), by Newton's method; None if it is not near `start`.

    The determinant is positive as long as the path goes on.
    """
    y, response, last = start.copy(), rubbing.response - weight * rubbing.still[:, :, None], math.inf
    for _ in range(ROUNDS):
        N, slopes = normal_forces(rubbing, rubbing.still + response @ y)
        jacobian = np.eye(len(y)) - theta * rubbing.mu[:, None] * np.einsum("ij,ijk->ik", slopes, response)
        sign = np.linalg.slogdet(jacobian)[0]
        if not sign > 0.0:
            return None
        change = np.linalg.solve(jacobian, theta * rubbing.mu * N - y)
        y += change
        if not np.isfinite(y).all():
            return None
        moved, size = np.abs(change).sum(), np.abs(y).sum()
        if moved <= CLOSE * size or last <= moved <= NOTHING * size:  # as near as rounding allows
            return y if weight * np.abs(y - start).sum() < 0.5 and (y >= -NOTHING / weight).all() else None
        last = moved
    return None
