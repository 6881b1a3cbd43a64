"""What a film carries over time: force of the joint and rates of both bodies, as smooth curves to a tolerance."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from rattle.solvers.mobility import QUANTITIES

Array = np.ndarray
Carried = Callable[[Array], Array]  # increasing times (n,) [s] -> (n, 4) F_x, F_y [N], w_A, w_B [rad/s]

FEWEST = 65  # nodes
TURN = 0.05  # of a body between two nodes at first [rad]
MOST = 400_000  # nodes
ROUNDS = 12  # in which cells are divided where the curves are off
ASIDE = (0.382, 0.7)  # places in a cell at which it is looked at, and divided: no share of a period


class Course(NamedTuple):
    """Four curves as cubics between nodes, see `rattle.solvers.mobility.carried_at`."""

    nodes: Array  # (k + 1,) [s]
    cubics: Array  # (k, 16)
    unsure: float  # share of the time in which they are off by more than the tolerance: forces jump there


def course(carried: Carried, end: float, fastest: float, tolerance: float) -> Course:
    """The curves from 0 to `end` [s]; fastest: rate of a body [rad/s]; tolerance: share of the largest values.

    Source: cubic splines through nodes that are added where a value between them is off.
    """
    from scipy.interpolate import CubicSpline

    if end == 0.0:
        still = np.zeros((1, 4 * QUANTITIES))
        still[0, -QUANTITIES:] = carried(np.zeros(1))[0]
        return Course(np.array([0.0, 1.0]), still, 0.0)
    count = min(max(FEWEST, math.ceil(end * fastest / TURN)), MOST)
    nodes = np.linspace(0.0, end, count)
    values = carried(nodes)
    for attempt in range(ROUNDS + 1):
        curve = CubicSpline(nodes, values)
        cells = np.diff(nodes)
        looked = nodes[:-1] + ASIDE[0] * cells
        between = carried(looked)
        size = np.maximum(np.abs(values).max(axis=0), np.abs(between).max(axis=0))
        size[:2], size[2:] = size[:2].max(), max(float(size[2:].max()), 1.0 / end)
        off = (np.abs(curve(looked) - between) > tolerance * size).any(axis=1)
        if not off.any() or attempt == ROUNDS or len(nodes) > MOST:
            break
        more = nodes[:-1][off] + ASIDE[1] * cells[off]
        nodes = np.concatenate([nodes, looked[off], more])
        values = np.concatenate([values, between[off], carried(more)])
        order = np.argsort(nodes)
        nodes, values = nodes[order], values[order]
    cubics = np.ascontiguousarray(curve.c.transpose(1, 0, 2)).reshape(len(cells), -1)
    return Course(nodes, cubics, float(cells[off].sum()) / end)
