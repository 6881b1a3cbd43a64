"""One step of a motion with its derivatives: Dormand-Prince 8(5, 3), with dense output.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), sections II.4, II.6, II.10.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rattle.questions.sensitivity.functions import Functions, Rates
from rattle.solvers.dop853_tableau import E3, E5, TABLEAU, A, B, C, D
from rattle.solvers.step_size import DAMPING

STAGES, POWER = TABLEAU.stages, TABLEAU.order
FLOOR = 1e-2  # share of the largest component of a column that its tolerances start from
NATURAL = 1e-4  # share of size over parameter below which a derivative need not be known to rtol
DIGITS = 1e-14  # the same for the rounding of the right-hand side


def weighted(weights: np.ndarray, terms: np.ndarray) -> np.ndarray:
    """The sum of terms (n, ...) with weights (n,)."""
    return np.asarray((weights @ terms.reshape(len(terms), -1)).reshape(terms.shape[1:]))


@dataclass
class Tolerance:
    """The error that a step may make: rtol and atol for the motion, rtol for every column of derivatives."""

    rtol: float
    atol: float  # [m, rad, m/s, rad/s]
    weight: np.ndarray  # (n,) size of every component that is controlled [SI]
    controlled: np.ndarray  # (n,) places of these components
    parameters: np.ndarray  # (k,) size of every parameter [SI]

    def scale(self, z: np.ndarray, z_new: np.ndarray) -> np.ndarray:
        """(n, 1 + k) tolerances for a step from z to z_new, both (n, 1 + k)."""
        size = np.maximum(np.abs(z), np.abs(z_new))
        largest = (size[:, 1:] / self.weight[:, None]).max(axis=0, initial=0.0)
        least = FLOOR * largest + max(NATURAL, DIGITS / self.rtol) / self.parameters
        scale: np.ndarray = np.empty_like(size)
        scale[:, 0] = self.atol + self.rtol * size[:, 0]
        scale[:, 1:] = self.rtol * (size[:, 1:] + self.weight[:, None] * least)
        return scale

    def error(self, z: np.ndarray, z_new: np.ndarray, h: float, slopes: np.ndarray) -> float:
        """Error of a step as a share of the tolerance: that of the worst column."""
        some = self.controlled
        scale = self.scale(z[some], z_new[some])
        third, fifth = (weighted(e[:STAGES], slopes)[some] / scale for e in (E3, E5))
        small, large = (fifth**2).sum(axis=0), (third**2).sum(axis=0)
        total = np.sqrt((small + DAMPING * large) * len(some))
        shares = np.divide(abs(h) * small, total, out=np.zeros_like(total), where=total != 0.0)
        return float(shares.max())


@dataclass
class Step:
    """A step from z at t to z_new at t + h, not yet projected."""

    t: float  # [s]
    h: float  # [s]
    z: np.ndarray  # (ny, 1 + k)
    z_new: np.ndarray
    slopes: np.ndarray  # (STAGES, ny, 1 + k)

    def states(self, functions: Functions, times: np.ndarray) -> list[np.ndarray]:
        """z at times [s] within the step."""
        if not len(times):
            return []
        t, h, z = self.t, self.h, self.z
        k = np.concatenate([self.slopes, np.zeros((4, *z.shape))])
        k[STAGES] = functions.rates(t + h, self.z_new).values
        for s in range(STAGES + 1, 16):
            k[s] = functions.rates(t + C[s] * h, z + h * weighted(A[s, :s], k[:s])).values
        jump = self.z_new - z
        rows = [jump, h * k[0] - jump, 2.0 * jump - h * (k[STAGES] + k[0]), *(h * weighted(d, k) for d in D)]
        states = []
        for theta in (times - t) / h:
            value = np.zeros_like(z)
            for n in reversed(range(len(rows))):
                value = (value + rows[n]) * (theta if n % 2 == 0 else 1.0 - theta)
            states.append(z + value)
        return states


def try_step(functions: Functions, t: float, h: float, z: np.ndarray, first: Rates) -> tuple[Step, str, Rates]:
    """A step of length h [s], why it cannot be accepted: "", "sides" (a switch), or "sound", and the last rates that it
    has looked at."""
    slopes = np.empty((STAGES, *z.shape))
    slopes[0] = first.values
    rates = first
    for s in range(1, STAGES):
        rates = functions.rates(t + C[s] * h, z + h * weighted(A[s, :s], slopes[:s]))
        slopes[s] = rates.values
        if not (rates.sound and np.isfinite(rates.values).all()):
            return Step(t, h, z, z, slopes), "sound", rates
        if (rates.sides != first.sides).any():
            return Step(t, h, z, z, slopes), "sides", rates
    return Step(t, h, z, z + h * weighted(B, slopes), slopes), "", rates
