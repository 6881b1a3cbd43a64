"""Polynomial through the stages of a step: forces between them, and their zeros."""

from __future__ import annotations

import numpy as np

from rattle.jit.functions import compiled
from rattle.solvers.peaks.samples import DOP853, SHARES

NODES = np.array([0, 1, 3, 5, 6, 7])  # samples of dop853; the others lie next to these
PLACES = SHARES[DOP853, NODES]
FORMS = np.ascontiguousarray(np.linalg.inv(np.vander(PLACES, increasing=True)).T)  # of 1, x, .. for 1 at one node
BARYCENTRIC = 1.0 / np.array([np.prod(np.delete(x - PLACES, k)) for k, x in enumerate(PLACES)])


@compiled
def through_stages(values, first, x):
    """The polynomial through the stages at the share x, in the unit of `values`; values[first + i] is at sample i."""
    above, below = 0.0, 0.0
    for k in range(NODES.shape[0]):
        value = values[first + NODES[k]]
        if x == PLACES[k]:
            return value
        weight = BARYCENTRIC[k] / (x - PLACES[k])
        above += weight * value
        below += weight
    return above / below


@compiled
def told(looks, c, x):
    """Column c of the samples at the stages of a step, interpolated at the share x by the polynomial through them."""
    above, below = 0.0, 0.0
    for k in range(NODES.shape[0]):
        if x == looks[NODES[k], 0]:
            return looks[NODES[k], c]
        weight = BARYCENTRIC[k] / (x - looks[NODES[k], 0])
        above += weight * looks[NODES[k], c]
        below += weight
    return above / below


@compiled
def zero_told(looks, c, low, high, near, shift, tilt):
    """Zero of that polynomial plus shift + tilt (x - near) between two shares; some place between them if none."""
    at_low, at_high = shift + tilt * (low - near), shift + tilt * (high - near)
    if told(looks, c, low) + at_low > 0.0 and told(looks, c, high) + at_high < 0.0:
        for _ in range(50):
            middle = 0.5 * (low + high)
            if told(looks, c, middle) + shift + tilt * (middle - near) > 0.0:
                low = middle
            else:
                high = middle
    return 0.5 * (low + high)
