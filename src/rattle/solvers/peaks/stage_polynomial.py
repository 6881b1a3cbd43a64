"""Polynomial through separate stages of a step: forces between them, and their zeros.

Of the stages that show forces it takes those with which it follows them best, as its Lebesgue constant says; what it is
beside the others shows its error.
"""

from __future__ import annotations

import itertools

import numpy as np

from rattle.jit.functions import compiled

NODES = 6


def best_nodes(shares: np.ndarray, count: int) -> list[int]:
    """Which `count` of the ascending shares, both ends among them, a polynomial takes with the least Lebesgue constant.

    Source: Trefethen, Approximation Theory and Approximation Practice (2013), chapter 15.
    """
    x, last = np.linspace(shares[0], shares[-1], 1001), len(shares) - 1

    def lebesgue(nodes: tuple[int, ...]) -> float:
        places = shares[list(nodes)]
        apart = places[:, None] - places + np.eye(count)
        bases = [np.prod((x[:, None] - np.delete(places, k)) / np.delete(apart[k], k), axis=1) for k in range(count)]
        return float(np.abs(bases).sum(axis=0).max())

    chosen = min(((0, *inner, last) for inner in itertools.combinations(range(1, last), count - 2)), key=lebesgue)
    return list(chosen)


def shape_arrays(order: np.ndarray, shares: np.ndarray) -> dict[str, np.ndarray]:
    """Arrays of a workspace for that polynomial; order: samples of the stages in order of time, with their shares."""
    nodes = best_nodes(shares, NODES)
    places = shares[nodes]
    beside = [n for n in range(len(shares)) if n not in nodes]
    return {
        "shape_nodes": order[nodes],
        "shape_places": places,
        "shape_factors": 1.0 / np.array([np.prod(np.delete(x - places, k)) for k, x in enumerate(places)]),
        "shape_forms": np.ascontiguousarray(np.linalg.inv(np.vander(places, increasing=True)).T),
        "beside_nodes": order[beside],
        "beside_places": shares[beside],
        "beside_products": np.array([abs(np.prod(x - places)) for x in shares[beside]]),
    }


@compiled
def through_stages(m, values, first, x):
    """The polynomial through the stages at the share x, in the unit of `values`; values[first + i] is at sample i."""
    nodes, places, factors = m.shape_nodes, m.shape_places, m.shape_factors
    above, below = 0.0, 0.0
    for k in range(nodes.shape[0]):
        value = values[first + nodes[k]]
        if x == places[k]:
            return value
        weight = factors[k] / (x - places[k])
        above += weight * value
        below += weight
    return above / below


@compiled
def told(m, looks, c, x):
    """Column c of the samples at the stages of a step, interpolated at the share x by the polynomial through them."""
    nodes, factors = m.shape_nodes, m.shape_factors
    above, below = 0.0, 0.0
    for k in range(nodes.shape[0]):
        if x == looks[nodes[k], 0]:
            return looks[nodes[k], c]
        weight = factors[k] / (x - looks[nodes[k], 0])
        above += weight * looks[nodes[k], c]
        below += weight
    return above / below


@compiled
def zero_told(m, looks, c, low, high, near, shift, tilt):
    """Zero of that polynomial plus shift + tilt (x - near) between two shares; some place between them if none."""
    at_low, at_high = shift + tilt * (low - near), shift + tilt * (high - near)
    if told(m, looks, c, low) + at_low > 0.0 and told(m, looks, c, high) + at_high < 0.0:
        for _ in range(50):
            middle = 0.5 * (low + high)
            if told(m, looks, c, middle) + shift + tilt * (middle - near) > 0.0:
                low = middle
            else:
                high = middle
    return 0.5 * (low + high)
