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


def normal_forces(one: Rubbing, multiplier: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """N (n,) [N] of every joint by its multipliers (n, 2), and its slopes (n, 2)."""
    first, second = multiplier.T
    size = np.hypot(first, second)
    unit = np.divide(multiplier, size[:, None], out=np.zeros_like(multiplier), where=size[:, None] > 0.0)
    pin, tilts = np.isnan(one.reach), one.reach * np.abs(second) > np.abs(first)
    N = np.where(pin, size, np.where(tilts, one.reach * np.abs(second), np.abs(first)))
    slope = np.stack([np.where(tilts, 0.0, np.sign(first)), np.where(tilts, one.reach * np.sign(second), 0.0)], axis=1)
    return N, np.where(pin[:, None], unit, slope)


def limit(one: Rubbing, far: bool = True) -> Limit:
    """The friction of every joint where motion in this sense is impending, under the loads there are.

    far: also find where it would jam with more friction; if not, `jams_at` is inf unless it jams.
    """
    N, _ = normal_forces(one, one.still)
    if not (one.mu * N > one.mu * one.rounding).any():  # nothing presses but the load that is sought
        alone = jams_at(one)
        return Limit(np.full(len(one.mu), math.inf if alone <= 1.0 else 0.0), alone)
    x, turned = _follow(one, 1.0)
    if turned <= 1.0:
        return Limit(np.full(len(one.mu), math.inf), turned)
    return Limit(x, jams_at(one) if far else math.inf)


def jams_at(one: Rubbing) -> float:
    """theta from which a load of any size jams that acts alone: x = theta mu N(Z x) has a solution; inf up to MOST.

    Found with reactions in place of lambda_0 that friction itself would make, so that x grows beyond all bounds there.
    """
    n = len(one.mu)
    alike = one.response @ np.full(n, 1.0 / n)
    N, _ = normal_forces(one, alike)
    if not (one.mu * N > NOTHING * np.abs(one.response).max(initial=0.0)).any():
        return math.inf
    return _follow(one._replace(still=alike), MOST)[1]


def yields_more(one: Rubbing, x: np.ndarray) -> np.ndarray:
    """(n,) True for joints whose friction, if it were less than its limit, would let the others hold a larger load."""
    _, slopes = normal_forces(one, one.still + one.response @ x)
    jacobian = np.eye(len(x)) - one.mu[:, None] * np.einsum("ij,ijk->ik", slopes, one.response)
    share = np.linalg.solve(jacobian.T, one.slip)
    return np.asarray(share < -1e-9 * np.abs(share).max(initial=0.0))


def _follow(one: Rubbing, until: float) -> tuple[np.ndarray, float]:
    """x (n,) at theta = `until`, or theta where it jams before (else inf)."""
    N, _ = normal_forces(one, one.still)
    weight = 1.0 / (one.mu * N).sum()
    theta, step, y = 0.0, FIRST, np.zeros(len(one.mu))
    while theta < until:
        ahead = min(theta + step, until)
        found = _solve(one, ahead, weight, y)
        if found is None:
            step *= 0.5
            if step < LEAST * max(1.0, theta):
                return y, theta
            continue
        if weight * found.sum() >= 1.0:
            return found, _where_unbounded(one, weight, theta, ahead, y)
        y, theta, step = found, ahead, 1.5 * step
    return y / (1.0 - weight * y.sum()), math.inf


def _where_unbounded(one: Rubbing, weight: float, low: float, high: float, y: np.ndarray) -> float:
    """theta between two others at which h = 0; y: at the lower one."""
    for _ in range(60):
        middle = 0.5 * (low + high)
        found = _solve(one, middle, weight, y) if low < middle < high else None
        if found is None:
            break
        if weight * found.sum() >= 1.0:
            high = middle
        else:
            low, y = middle, found
    return high


def _solve(one: Rubbing, theta: float, weight: float, start: np.ndarray) -> np.ndarray | None:
    """y (n,), the share of x in (h, x) with h = 1 - weight sum(y), by Newton's method; None if it is not near `start`.

    The determinant is positive as long as the path goes on.
    """
    y, response, last = start.copy(), one.response - weight * one.still[:, :, None], math.inf
    for _ in range(ROUNDS):
        N, slopes = normal_forces(one, one.still + response @ y)
        jacobian = np.eye(len(y)) - theta * one.mu[:, None] * np.einsum("ij,ijk->ik", slopes, response)
        sign = np.linalg.slogdet(jacobian)[0]
        if not sign > 0.0:
            return None
        change = np.linalg.solve(jacobian, theta * one.mu * N - y)
        y += change
        if not np.isfinite(y).all():
            return None
        moved, size = np.abs(change).sum(), np.abs(y).sum()
        if moved <= CLOSE * size or last <= moved <= NOTHING * size:  # as near as rounding allows
            return y if weight * np.abs(y - start).sum() < 0.5 and (y >= -NOTHING / weight).all() else None
        last = moved
    return None
