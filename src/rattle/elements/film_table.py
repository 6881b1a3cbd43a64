"""The film of finite length as a table: its force over that of the short film, and how it is read.

Under Reynolds' condition the force is the slope of one scalar, the dissipation potential, F = -dPhi/dv.  With alpha the
angle from the eccentricity to the velocity and C = mu R L^3/c^3,

    Phi = C |v|^2 g/2        F.m = -C |v| g        F.k = -C |v| g_alpha/2        g = I1 exp(Lambda)

so that one number per state is enough: Lambda = ln(g/I1), the logarithm of the ratio to the short film.  Coordinates:

    sigma = -ln(1 - e)                              0 to ln 1000, as sigma/(1 + sigma/4)
    tau   = l(Q)/l(Q at alpha = 0), l(Q) = ln(Q/(pi - Q)), Q = atan2(s, -e cos alpha)         -1 to 1
    ln(L/D)                                         ln 1/16 to ln 2, a factor of sqrt(2) from node to node

tau follows the edge of the film, which grows sharp as s, and is cos alpha at the centre.  Cubic splines through the
nodes, with two continuous derivatives, make the force continuously differentiable; g > 0 makes the film resist
whatever the error of the table.  Beyond the last sigma the slope is kept.  Bearings shorter than L/D = 1/16 are taken
from 1/16: 1/g - 1/I1 grows with (L/D)^2.

Without cavitation two functions of sigma take the place of Lambda: the ratios for v along e and across it.
"""

from __future__ import annotations

import functools
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rattle.errors import InputError, TraceError
from rattle.jit.choices import TINY
from rattle.jit.functions import compiled
from rattle.language.recorded import Recorded, bare, log

Array = NDArray[np.float64]
NODES = 25  # of sigma and of tau
STRIDE = NODES + 2  # coefficients of a spline on so many nodes
LAST_SIGMA = math.log(1000.0)
BEND = 0.25  # nodes are equidistant in sigma/(1 + BEND sigma): three times closer at the centre than on average
SIGMA_SCALE = (NODES - 1) * (1.0 + BEND * LAST_SIGMA) / LAST_SIGMA
LAST_SLOPE = SIGMA_SCALE / (1.0 + BEND * LAST_SIGMA) ** 2  # nodes per sigma at the last of them
PLACES = np.arange(NODES) / SIGMA_SCALE
SIGMA = PLACES / (1.0 - BEND * PLACES)
TAU = np.linspace(-1.0, 1.0, NODES)
RATIOS = 2.0 ** (np.arange(-8, 3) / 2.0)  # L/D
LONGEST = 2.0
CENTRE = 1e-6  # below this eccentricity tau is cos alpha to 1e-12
FILE = Path(__file__).with_suffix(".npz")


@compiled
def edge_place(a, b, e, s, q):
    """tau [-] of a state and d tau/d alpha, from e [of the clearance], its parts a, b along and across v, s and Q."""
    if e < CENTRE:
        e = max(e, TINY)
        return a / e, b / e
    most = math.atan2(s, -e)
    whole = math.log(most / (math.pi - most))
    other = math.pi - q  # never less than s: what cancels is 1e-13 of it in the thinnest film
    return math.log(q / other) / whole, math.pi * s * b / (q * other * (s * s + a * a) * whole)


@compiled
def spline_weights(t):
    """The four cubic B-splines on an interval, t from 0 to 1 in it."""
    u = 1.0 - t
    return u * u * u / 6.0, 2.0 / 3.0 - t * t * (1.0 - 0.5 * t), 2.0 / 3.0 - u * u * (1.0 - 0.5 * u), t * t * t / 6.0


@compiled
def spline_slopes(t):
    """Derivatives of the four cubic B-splines on an interval."""
    u = 1.0 - t
    return -0.5 * u * u, t * (1.5 * t - 2.0), -u * (1.5 * u - 2.0), 0.5 * t * t


@compiled
def sigma_weights(gap):
    """First coefficient and four weights for sigma = -ln(gap), gap = 1 - e; a straight line beyond the last node."""
    sigma = -math.log(gap)
    if sigma < LAST_SIGMA:
        x = SIGMA_SCALE * sigma / (1.0 + BEND * sigma)
        k = max(min(int(x), NODES - 2), 0)
        w0, w1, w2, w3 = spline_weights(x - k)
        return k, w0, w1, w2, w3
    w0, w1, w2, w3 = spline_weights(1.0)
    d0, d1, d2, d3 = spline_slopes(1.0)
    t = LAST_SLOPE * (sigma - LAST_SIGMA)
    return NODES - 2, w0 + t * d0, w1 + t * d1, w2 + t * d2, w3 + t * d3


@compiled
def read_line(table, first, gap):
    """A function of sigma from its STRIDE coefficients table[first:]."""
    k, w0, w1, w2, w3 = sigma_weights(gap)
    k += first
    return w0 * table[k] + w1 * table[k + 1] + w2 * table[k + 2] + w3 * table[k + 3]


@compiled
def read_sheet(table, first, gap, tau):
    """A function of sigma and tau, and its slope over tau, from its STRIDE x STRIDE coefficients table[first:]."""
    k, w0, w1, w2, w3 = sigma_weights(gap)
    y = (max(-1.0, min(1.0, tau)) + 1.0) * (0.5 * (NODES - 1))  # this order is a number whatever tau is
    i = max(min(int(y), NODES - 2), 0)
    t = y - i
    v0, v1, v2, v3 = spline_weights(t)
    d0, d1, d2, d3 = spline_slopes(t)
    at = first + k * STRIDE + i
    value, slope = 0.0, 0.0
    for w in (w0, w1, w2, w3):
        c0, c1, c2, c3 = table[at], table[at + 1], table[at + 2], table[at + 3]
        value += w * (v0 * c0 + v1 * c1 + v2 * c2 + v3 * c3)
        slope += w * (d0 * c0 + d1 * c1 + d2 * c2 + d3 * c3)
        at += STRIDE
    return value, slope * (0.5 * (NODES - 1))


@compiled
def read_ratios(e, alpha, table, ratios):
    """exp of the sheet at every e [of the clearance] and alpha [rad], arrays (n,); the last one is filled."""
    for k in range(e.shape[0]):
        s = math.sqrt((1.0 - e[k]) * (1.0 + e[k]))
        a = e[k] * math.cos(alpha[k])
        tau, _ = edge_place(a, -e[k] * math.sin(alpha[k]), e[k], s, math.atan2(s, -a))
        value, _ = read_sheet(table, 0, 1.0 - e[k], tau)
        ratios[k] = math.exp(value)


# ---------------------------------------------------------------- from nodes to coefficients
def eccentricities() -> Array:
    """The nodes of the eccentricity, (NODES,) [of the clearance]."""
    return np.asarray(-np.expm1(-SIGMA))


def directions(e: float) -> Array:
    """The angles alpha (NODES,) [rad] of the nodes of tau at an eccentricity, from pi down to 0."""
    if e < CENTRE:
        return np.arccos(TAU)
    s = math.sqrt((1.0 - e) * (1.0 + e))
    places = TAU * math.log(math.atan2(s, -e) / math.atan2(s, e))
    a = s * np.tan(0.5 * np.pi * np.tanh(0.5 * places))  # Q - pi/2 is pi/2 tanh(l/2)
    angles = np.arccos(np.clip(a / e, -1.0, 1.0))
    angles[0], angles[-1] = math.pi, 0.0
    return angles


@functools.cache
def nodes() -> dict[str, Array]:
    """The shipped values at the nodes; first axis L/D, then sigma, then tau.

    potential: Lambda under Reynolds' condition.  full: ratios (of L/D, 2, sigma) for v along e and across it, as
    logarithms.  peak, full_peak: logarithms of the ratio of the largest pressure to that of the short film.
    leakage, full_leakage: of the flow out of both ends.
    """
    with np.load(FILE) as archive:
        return {name: np.asarray(archive[name], dtype=float) for name in archive.files}


@functools.lru_cache(maxsize=64)
def coefficients(name: str, ratio: float) -> Array:
    """Coefficients of the splines of `nodes()[name]` at one L/D, flat; read-only.

    Raises InputError for an L/D beyond 2.
    """
    if not 0.0 < ratio <= LONGEST:
        raise InputError(f"the table of films ends at L/D = {LONGEST:g}, not {ratio:g}")
    splines = _over_states(name, _at_ratio(nodes()[name], ratio))
    splines.setflags(write=False)
    return splines


def recorded_coefficients(name: str, ratio: Recorded) -> list[Recorded]:
    """The same with a record, which holds between two nodes of L/D: sums of spline coefficients for single knots.

    Its operations are others, so elsewhere it is right but for rounding.  Raises TraceError below the nodes.
    """
    count = len(RATIOS)
    x: Any = (log(ratio) - math.log(RATIOS[0])) * (2.0 / math.log(2.0))
    k = min(int(bare(x)), count - 2)
    if not k <= x <= k + 1:
        raise TraceError(f"the table of films has no record below L/D = {RATIOS[0]:g}")
    knots = np.tensordot(_interpolation(count)[k : k + 4], nodes()[name], axes=1)
    weights = spline_weights.python(x - float(k))
    parts = [_over_states(name, knot_values).tolist() for knot_values in knots]
    values = coefficients(name, bare(ratio)).tolist()
    recorded = []
    for value, c0, c1, c2, c3 in zip(values, *parts, strict=True):
        total = weights[0] * c0 + weights[1] * c1 + weights[2] * c2 + weights[3] * c3
        recorded.append(total.made(value, total.symbol))
    return recorded


def _over_states(name: str, values: Array) -> Array:
    """Coefficients of the splines over the states, flat, from values at the nodes for one L/D."""
    splines = _to_coefficients(values, -1)
    return np.ascontiguousarray(_to_coefficients(splines, 0) if name != "full" else splines).ravel()


def _at_ratio(values: Array, ratio: float) -> Array:
    """Values at one L/D: a cubic spline over ln(L/D) through the nodes, and below them their limit."""
    if ratio < RATIOS[0]:
        return np.asarray(-np.log1p(np.expm1(-values[0]) * (ratio / RATIOS[0]) ** 2))
    count = len(RATIOS)
    x = 2.0 * math.log2(ratio / RATIOS[0])
    k = min(int(x), count - 2)
    weights = np.zeros(count + 2)
    weights[k : k + 4] = spline_weights.python(x - k)
    return np.asarray(np.tensordot(weights @ _interpolation(count), values, axes=1))


@functools.cache
def _interpolation(count: int) -> Array:
    """Matrix (count + 2, count) from values at equidistant nodes to coefficients of the cubic spline through them.

    Its third derivative, too, is continuous at the second node and the last but one.
    """
    rows = np.zeros((count + 2, count + 2))
    for n in range(count):
        rows[n, n : n + 3] = 1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0
    rows[count, :5] = rows[count + 1, -5:] = -1.0, 4.0, -6.0, 4.0, -1.0
    return np.asarray(np.linalg.inv(rows)[:, :count])


def _to_coefficients(values: Array, axis: int) -> Array:
    """Coefficients of splines along one axis."""
    moved = np.moveaxis(values, axis, 0)
    return np.moveaxis(np.tensordot(_interpolation(len(moved)), moved, axes=1), 0, axis)
