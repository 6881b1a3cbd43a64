"""The smallest step by a quadratic measure that some inequalities allow: a least-distance problem.

    min y . H y / 2 + c . y      with   B y >= b,   H > 0

is, with H^-1 = R R^T and y = R (z - R^T c), the least |z| with B R z >= b + B R R^T c, and that is a problem of least
squares with factors that are not negative (Lawson, Hanson, Solving Least Squares Problems (1974), chapter 23).
"""

from __future__ import annotations

import numpy as np

IMPOSSIBLE = 1e-11  # share of the residual that is left where nothing satisfies all inequalities


def nearest_step(root: np.ndarray, c: np.ndarray, sides: np.ndarray, least: np.ndarray) -> np.ndarray | None:
    """y (n,) for R (n, n), c (n,), B (k, n) and b (k,); None if no y satisfies the inequalities."""
    offset, lines = root.T @ c, sides @ root
    bound, length = least + lines @ offset, np.linalg.norm(lines, axis=1)
    counts = length > 0.0
    if (least[~counts] > 0.0).any():
        return None
    lines, bound = lines[counts] / length[counts, None], bound[counts] / length[counts]
    z, size = np.zeros(len(c)), float(np.linalg.norm(offset)) or 1.0
    if (bound > 0.0).any():
        bound = bound / size  # where y = 0 is allowed |z| <= 1 then, and all numbers are of this order
        factors = pressures(np.vstack([lines.T, bound]), np.array([*z, 1.0]))
        left = 1.0 - float(bound @ factors)
        if left <= IMPOSSIBLE:
            return None
        z = size * (lines.T @ factors) / left
    y: np.ndarray = root @ (z - offset)
    return y


def pressures(lines: np.ndarray, side: np.ndarray) -> np.ndarray:
    """(k,) factors that are not negative, with which the columns of lines (n, k) come nearest to side (n,).

    Zeros where they are not found: a step that minds no gap is then halved.
    """
    from scipy.optimize import nnls

    try:
        factors: np.ndarray = nnls(lines, side, maxiter=50 * lines.shape[1] + 100)[0]
    except RuntimeError:
        return np.zeros(lines.shape[1])
    return factors
