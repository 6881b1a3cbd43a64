"""Roots and shapes of the small motions about an equilibrium.

M ddz + C dz + K z = 0,    z = x exp(s t):    (M s^2 + C s + K) x = 0

In the basis X of the undamped motions, K X = M X mu (real: two columns span what a complex pair spans), and with
C' = X^-1 M^-1 C X:
    a motion that C' does not couple to others      s^2 + c' s + mu = 0
    those that it couples, with u = D z, D = sqrt|mu|      s [u; v] = [[0, D], [-mu D^-1, -C']] [u; v]
Columns of u with mu = 0 are left out: each is a root s = 0.

Source: Tisseur and Meerbergen, The quadratic eigenvalue problem, SIAM Review 43 (2001) 235-286, section 3.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rattle.jit.choices import TINY

EVEN = 1e-6  # share by which a stiffness may be unsymmetric because of differences: roots change by its square
NEUTRAL = 1e-10  # share of the largest mu that counts as none
APART = 10.0  # errors of C' up to which an entry of it couples nothing
DEFECTIVE = 1e6  # condition of X above which undamped motions (nearly) coincide and are no basis
DRIFTS = 1e-6  # rate of a motion with root 0 and u, v of length 1 above which it is a drift, by v
EXACT = 1e-13  # share by which rounding changes matrices that are exact derivatives
DIFFERENCES = 1e-8  # the same of matrices by differences


class SmallMotions(NamedTuple):
    """One row per motion, by the product of its two roots; f degrees of freedom."""

    roots: np.ndarray  # (f, 2) s [1/s], complex: a conjugate pair, or two real ones, the larger first
    shapes: np.ndarray  # (f, 2, f) complex coordinates z that belong to them, of any length


def small_motions(stiffness: np.ndarray, damping: np.ndarray, mass: np.ndarray, error: float = EXACT) -> SmallMotions:
    """Free motions of M ddz + C dz + K z = 0, all matrices (f, f); mass symmetric and positive definite.

    error: share [-] by which stiffness and damping are uncertain; a root that only this could let grow does not grow.
    Raises LinAlgError if the mass is not positive definite.
    """
    lower = np.linalg.inv(np.linalg.cholesky(mass))
    basis, mu, paired = _undamped(lower @ stiffness @ lower.T)
    c = np.linalg.solve(basis, lower @ damping @ lower.T @ basis)
    roots: list[tuple[complex, complex]] = []
    shapes: list[np.ndarray] = []
    noise = error * (np.abs(c).max() + np.sqrt(np.linalg.norm(mu, axis=0)))  # of C' [1/s]
    for group in _groups(paired | (np.abs(c) > APART * np.minimum.outer(noise, noise))):
        if len(group) == 1:
            k = int(group[0])
            pairs = [_alone(c[k, k], mu[k, k], noise[k])]
            vectors = np.ones((1, 2, 1), complex)
        else:
            pairs, vectors = _together(c[np.ix_(group, group)], mu[np.ix_(group, group)], error)
        roots += pairs
        wide = np.zeros((len(group), 2, len(mass)), complex)
        wide[:, :, group] = vectors
        shapes += list(wide)
    order = sorted(range(len(roots)), key=lambda k: _rank(*roots[k]))
    return SmallMotions(np.array(roots)[order], np.array(shapes)[order] @ (lower.T @ basis).T)


def _rank(first: complex, other: complex) -> tuple[float, float]:
    """By the product of the roots, mu of an undamped motion; of equal ones that which grows comes first."""
    return float(f"{(first * other).real:.9e}"), -first.real


def _undamped(h: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Basis X (f, f), X^-1 h X = mu (f, f) [1/s^2], ascending real parts, and which pairs of columns belong together.

    mu is diagonal but for a block of two per complex pair.  Where X would be singular it is 1, and all belong together.
    """
    f = len(h)
    none = np.zeros((f, f), dtype=bool)
    if np.abs(h - h.T).max() <= EVEN * np.abs(h).max():
        values, vectors = np.linalg.eigh(0.5 * (h + h.T))
        values[np.abs(values) < NEUTRAL * np.abs(values).max()] = 0.0
        return vectors, np.diag(values), none
    roots, columns = np.linalg.eig(h)
    order = np.argsort(roots.real, kind="stable")  # conjugates stay side by side
    roots, columns = roots[order], columns[:, order]
    roots[np.abs(roots) < NEUTRAL * np.abs(roots).max()] = 0.0
    basis, mu, paired = np.real(columns).copy(), np.diag(np.real(roots)), none
    for k in np.flatnonzero(np.imag(roots) > 0.0):
        pair = [k, k + 1] if k + 1 < f and roots[k + 1] == np.conj(roots[k]) else [k, k - 1]
        basis[:, pair] = np.stack([columns[:, k].real, columns[:, k].imag], axis=1)
        mu[np.ix_(pair, pair)] = [[roots[k].real, roots[k].imag], [-roots[k].imag, roots[k].real]]
        paired[np.ix_(pair, pair)] = True
    if not np.linalg.cond(basis) < DEFECTIVE:
        return np.eye(f), h, np.ones((f, f), dtype=bool)
    return basis, mu, paired


def _groups(coupled: np.ndarray) -> list[np.ndarray]:
    """Groups of motions that hang together, from coupled (f, f): their numbers, every one in one group."""
    reach = coupled | coupled.T | np.eye(len(coupled), dtype=bool)
    for _ in range(len(coupled).bit_length()):
        reach = reach @ reach
    return [np.flatnonzero(row) for k, row in enumerate(reach) if not row[:k].any()]


def _alone(c: float, mu: float, noise: float) -> tuple[complex, complex]:
    """Roots [1/s] of s^2 + c s + mu = 0 without cancellation; growth up to noise [1/s] is none."""
    half = 0.0 if -noise <= 0.5 * c < (noise if mu == 0.0 else 0.0) else 0.5 * c
    reach = half * half - mu
    if reach < 0.0:
        root = complex(-half, math.sqrt(-reach))
        return root, root.conjugate()
    far = -(half + math.copysign(math.sqrt(reach), half))
    near = mu / far if far != 0.0 else 0.0
    return complex(max(far, near) + 0.0), complex(min(far, near) + 0.0)


def _together(c: np.ndarray, mu: np.ndarray, error: float) -> tuple[list[tuple[complex, complex]], np.ndarray]:
    """Pairs of roots of a group, and their coordinates (n, 2, n), from all its equations at once."""
    n = len(c)
    size = np.sqrt(np.linalg.norm(mu, axis=0))
    held = np.flatnonzero(size > 0.0)
    d, m = size[held], len(held)
    state = np.zeros((m + n, m + n))
    state[np.arange(m), m + held] = d
    state[m:, :m], state[m:, m:] = -mu[:, held] / d, -c
    values, vectors = np.linalg.eig(state)
    values = _settled(values, vectors, error * float(np.linalg.norm(state, 2)))
    shapes = np.divide(vectors[m:], values, out=vectors[m:].astype(complex), where=values != 0.0)
    drifts = (values == 0.0) & (np.linalg.norm(vectors[m:], axis=0) > DRIFTS)
    shapes[np.ix_(held, ~drifts)] = (vectors[:m] / d[:, None])[:, ~drifts]
    neutral = np.eye(n)[:, size == 0.0]
    swings = np.flatnonzero(values.imag > 0.0)
    real = np.flatnonzero(values.imag == 0.0)
    rest = np.concatenate([values[real].real, np.zeros(n - m)])
    ways = np.concatenate([shapes[:, real].real, neutral], axis=1)
    pairs = _pairs(rest, ways, c)
    roots = [(complex(values[k]), complex(values[k].conjugate())) for k in swings]
    roots += [(complex(rest[i]), complex(rest[j])) for i, j in pairs]
    turning = [np.stack([shapes[:, k], shapes[:, k].conj()]) for k in swings]
    return roots, np.array([*turning, *(ways[:, [i, j]].T for i, j in pairs)])


def _settled(values: np.ndarray, vectors: np.ndarray, noise: float) -> np.ndarray:
    """Roots (n,) [1/s] without what rounding made: growth, and real roots beside zero.

    noise: change of the matrix [1/s]; a root changes by it times the root's condition, two that nearly coincide by no
    more than the square root.
    """
    try:
        left = np.linalg.inv(vectors)
        condition = np.linalg.norm(left, axis=1) * np.linalg.norm(vectors, axis=0)
    except np.linalg.LinAlgError:
        condition = np.full(len(values), math.inf)
    largest = float(np.abs(values).max())
    unsure = np.minimum(noise * condition, math.sqrt(noise * largest) if largest > 0.0 else 0.0)
    values = values.astype(complex)
    values[np.abs(values) <= unsure] = 0.0
    quiet = (values.real > 0.0) & (values.real <= unsure)
    values[quiet] = 1j * values[quiet].imag
    return values


def _pairs(values: np.ndarray, shapes: np.ndarray, c: np.ndarray) -> list[tuple[int, int]]:
    """Real roots (2 p,) two by two, the larger first: two of opposite type whose shapes x (n, 2 p) are most similar.

    The type is the sign of x^T (2 s + C') x: of the two roots of an oscillator the slow one has +, the fast one -, and
    only roots of opposite type meet and become a vibration when there is less damping.
    """
    if not len(values):
        return []
    unit = shapes / np.maximum(np.linalg.norm(shapes, axis=0), TINY)
    kind = np.sign(2.0 * values + np.einsum("ik,ij,jk->k", unit, c, unit))
    alike = np.abs(unit.T @ unit) + (np.multiply.outer(kind, kind) < 0.0)
    np.fill_diagonal(alike, -1.0)
    pairs = []
    while alike.max() >= 0.0:
        i, j = np.unravel_index(int(alike.argmax()), alike.shape)
        pairs.append((int(i), int(j)) if values[i] >= values[j] else (int(j), int(i)))
        alike[[i, j]] = alike[:, [i, j]] = -1.0
    return pairs
