"""Energies of a cycle: integrals of powers over the steps of a run, and the work of its impulses."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.errors import SolverError
from rattle.mechanism import Mechanism
from rattle.questions.power.ports import Flow, Ports
from rattle.questions.power.steps import GAUSS, Settings, Steps, points_of, steps_between

Array = NDArray[np.float64]
_legendre = np.polynomial.legendre
ORDER = GAUSS
_POINTS, _WEIGHTS = _legendre.leggauss(ORDER)
_SAMPLES = np.cos(np.pi * np.arange(33) / 32)[::-1]  # of a step, denser towards its ends
_FIT = np.linalg.inv(_legendre.legvander(_POINTS, ORDER - 1))  # coefficients from values at the points of Gauss
_SERIES = np.array([_legendre.legint(row, lbnd=-1.0) for row in np.eye(ORDER)])  # integrals of the polynomials
UNKNOWN = 1e-6  # share of the window in which powers may be unknown, in steps that shrink to nothing
NEWTON = 4  # iterations, from a zero that is good to some thousandths of a step


class Cycle(NamedTuple):
    """Energies [J] between two instants, and extremes [W]."""

    t0: float  # [s]
    t1: float
    into: Array  # (ports,) energy into bodies
    out: Array  # energy out of bodies
    peak: Array  # power of the largest magnitude, with its sign [W]
    supplied: Array  # (elements,) energy from outside
    lost: Array
    stored: Array
    residual: float  # largest imbalance of the powers of a body [W]


def cycle(m: Mechanism, ports: Ports, settings: Settings, t0: float, t1: float) -> Cycle:
    """Energies of all ports and elements between two instants [s] of a run."""
    into, out, peak = np.zeros((3, len(ports.list)))
    sums = np.zeros((3, len(ports.elements)))
    residual = 0.0
    for steps in steps_between(m, settings, t0, t1):
        steps, flow = _known(ports, steps, settings.points, t1 - t0)
        half = 0.5 * (steps.end - steps.start)
        values = flow.ports.reshape(len(half), len(settings.points), -1)
        positive, net, extreme = parts(values, half)
        into += positive
        out += positive - net
        peak = np.where(np.abs(extreme) > np.abs(peak), extreme, peak)
        weight = half[:, None] * settings.weights
        each = np.array([flow.supplied, flow.lost, flow.stored]).reshape(3, len(half), len(settings.points), -1)
        integrals = np.einsum("sg,ksge->kse", weight, each)
        _book_ends(steps, integrals)
        sums += integrals.sum(axis=1)
        _book_impulses(ports, steps, into, out, sums)
        residual = max(residual, float(flow.unbalanced.max(initial=0.0)))
    supplied, lost, stored = sums
    return Cycle(t0, t1, into, out, peak, supplied, lost, stored, residual)


def _known(ports: Ports, steps: Steps, points: Array, span: float) -> tuple[Steps, Flow]:
    """The steps at whose points all powers are known, and these; points: from -1 to 1, span: of the window [s].

    Steps shrink to rounding before a run ends where no force is a solution.  Raises SolverError if more is unknown.
    """
    flow = ports.flow(points_of(steps, points), steps.rows.reshape(-1, steps.rows.shape[-1]))
    finite = np.isfinite(flow.unbalanced) & np.isfinite(flow.lost + flow.stored + flow.supplied).all(axis=1)
    usable = finite.reshape(len(steps.start), -1).all(axis=1)
    if usable.all():
        return steps, flow
    if not (steps.end - steps.start)[~usable].sum() <= UNKNOWN * span:
        raise SolverError(f"forces have no value at t = {steps.start[~usable][0]:.6g} s: give times before it", None)
    moved, closed = steps.moved[usable], steps.closed[usable]
    left = Steps(steps.start[usable], steps.end[usable], steps.rows[usable], steps.impulses, moved, closed)
    return left, ports.flow(points_of(left, points), left.rows.reshape(-1, left.rows.shape[-1]))


def parts(values: Array, half: Array) -> tuple[Array, Array, Array]:
    """Integral of the positive part, integral, and value of the largest magnitude of powers over steps, (ports,).

    values: (steps, points, ports) [W] at the points of Gauss, or means of the steps; half: (steps,) half lengths [s].
    """
    if values.shape[1] == 1:
        each = 2.0 * half[:, None] * values[:, 0]
        return np.maximum(each, 0.0).sum(axis=0), each.sum(axis=0), _extreme(values[:, 0])
    net = np.einsum("s,g,sgp->sp", half, _WEIGHTS, values)
    series = np.einsum("cg,sgp->spc", _FIT, values)
    seen = series @ _legendre.legvander(_SAMPLES, ORDER - 1).T  # (steps, ports, samples)
    positive = np.maximum(net, 0.0)
    mixed = (seen.max(axis=2) > 0.0) & (seen.min(axis=2) < 0.0)
    positive[mixed] = _positive(series[mixed], seen[mixed]) * np.broadcast_to(half[:, None], net.shape)[mixed]
    return positive.sum(axis=0), net.sum(axis=0), _extreme(seen.transpose(0, 2, 1).reshape(-1, values.shape[2]))


def _extreme(values: Array) -> Array:
    """The value of the largest magnitude in every column of values (n, k)."""
    return np.asarray(values[np.abs(values).argmax(axis=0), np.arange(values.shape[1])])


def _positive(series: Array, seen: Array) -> Array:
    """Integral over (-1, 1) of the positive part of polynomials (n, order), of which samples (n, k) are seen."""
    antiderivative = series @ _SERIES  # (n, order + 1)
    at_samples = antiderivative @ _legendre.legvander(_SAMPLES, ORDER).T
    low, high = seen[:, :-1], seen[:, 1:]
    pieces = np.diff(at_samples, axis=1)
    total = np.where((low >= 0.0) & (high >= 0.0), pieces, 0.0).sum(axis=1)
    which, place = np.nonzero(low * high < 0.0)
    before, after = low[which, place], high[which, place]
    left, right = _SAMPLES[place], _SAMPLES[place + 1]
    zero = left + (right - left) * before / (before - after)
    slope = np.array([_legendre.legder(row) for row in np.eye(ORDER)])
    for _ in range(NEWTON):
        value = (series[which] * _legendre.legvander(zero, ORDER - 1)).sum(axis=1)
        rate = (series[which] @ slope * _legendre.legvander(zero, ORDER - 2)).sum(axis=1)
        zero = np.clip(zero - value / np.where(rate == 0.0, np.inf, rate), left, right)
    middle = (antiderivative[which] * _legendre.legvander(zero, ORDER)).sum(axis=1)
    piece = np.where(before > 0.0, middle - at_samples[which, place], at_samples[which, place + 1] - middle)
    np.add.at(total, which, piece)
    return np.asarray(total)


def _book_ends(steps: Steps, integrals: Array) -> None:
    """Where contacts ended in a step, take from their accounts what they have lost: also what they had stored.

    integrals: (3, steps, elements) energy supplied, lost and stored [J].
    """
    k, n = np.nonzero(steps.closed)
    dropped = steps.moved[k, n] - integrals[1][k, n]
    integrals[1][k, n] += dropped
    integrals[2][k, n] -= dropped


def _book_impulses(ports: Ports, steps: Steps, into: Array, out: Array, sums: Array) -> None:
    """Add the work of impulses: joints lose what they take from their bodies, drivers supply it."""
    gained, taken = ports.impulses(steps.impulses)
    into += gained
    out += taken
    work = np.zeros(len(ports.elements))
    np.add.at(work, ports.of_element, gained - taken)
    sums[0] += np.where(ports.driven, work, 0.0)
    sums[1] -= np.where(ports.driven, 0.0, work)
