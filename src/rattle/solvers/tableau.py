"""Explicit Runge-Kutta methods as data: one kernel, `explicit`, and the lanes of `rattle.trace` run them all.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), sections II.1, II.4 and II.6.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from rattle.errors import InputError

Numbers = Sequence[float] | np.ndarray
Rows = Sequence[Numbers] | np.ndarray
EXACT = 1e-11  # by which sums of coefficients may differ from what they have to be: their rounding
WIDEST = 3  # gaps between stages that are known by their middles


@dataclass(frozen=True, eq=False)
class Tableau:
    """Coefficients of a method with s stages k_i = f(t + c_i h, y + h sum a_ij k_j): y + h sum b_i k_i at the end.

    Dense output: the cubic through both ends, and above it `dense`, rows of weights of all slopes, for the factors
    theta^2 (1 - theta)^2, theta^3 (1 - theta)^2 ...; it may take further stages.  Those follow the slope at the end of
    the step, which is computed in any case, in `times` and `rows`.

    Raises InputError for coefficients that contradict each other, or the order.
    """

    order: int  # power of the step with which the error decreases
    times: Numbers  # c: of the s stages; if there are further ones, 1 for the end of the step, then theirs
    rows: Rows  # a: of the same, each as far as it is not zero
    weights: Numbers  # (s,) b
    errors: Rows = ()  # weights of an error estimate; a second one damps it, see `explicit`
    dense: Rows = ()  # at most four rows
    stable: int = 0  # fastest rate times step beyond which it is not stable, if its last stage shows it; 0: ignored

    def __post_init__(self) -> None:
        few = len(self.weights)
        if not (few <= len(self.times) == len(self.rows) and len(self.errors) <= 2 and len(self.dense) <= 4):
            raise InputError("a tableau needs a time and a row for every stage, at most two errors, four dense rows")
        a, c, ends = self.a, self.c, self.ends
        if np.triu(a).any() or np.abs(a.sum(axis=1) - c).max() > EXACT:
            raise InputError("rows of a tableau take slopes of stages before them, and sum up to the time of theirs")
        moments = [abs(ends[0] @ c[:few] ** k - 1.0 / (k + 1)) for k in range(self.order)]
        if max(moments) > EXACT:
            raise InputError(f"these weights do not integrate polynomials below degree {self.order}: not of that order")
        if len(ends) > 1 and np.abs(ends[1:].sum(axis=1)).max() > EXACT * np.abs(ends).max():
            raise InputError("weights of an error estimate sum up to zero")

    @property
    def stages(self) -> int:
        """Number of stages of a step; the first one is the end of the step before."""
        return len(self.weights)

    @property
    def dense_stages(self) -> int:
        """Number of further stages for the dense output alone."""
        return max(0, len(self.times) - self.stages - 1)

    @property
    def adaptive(self) -> bool:
        """It estimates its error."""
        return len(self.errors) > 0

    @property
    def watched_stable(self) -> int:
        """`stable`, if the last stage shows it: another state than that at the end of the step, at the same instant."""
        return self.stable if self.c[self.stages - 1] == 1.0 else 0

    @cached_property
    def c(self) -> np.ndarray:
        """(all stages,) their times, as shares of the step."""
        return np.array(self.times, dtype=float)

    @cached_property
    def a(self) -> np.ndarray:
        """(all stages, all stages) weights of the slopes before each."""
        full = np.zeros((len(self.rows), len(self.rows)))
        for n, row in enumerate(self.rows):
            full[n, : len(row)] = row
        return full

    @cached_property
    def ends(self) -> np.ndarray:
        """(1 + errors, stages) weights of the state at the end and of the error estimates."""
        return np.array([self.weights, *(row[: self.stages] for row in self.errors)], dtype=float)

    @cached_property
    def gaps(self) -> np.ndarray:
        """Middles of the widest gaps between the stages: shares of a step at which no stage is near."""
        nodes = np.unique(self.c[: self.stages])
        wide = np.sort(np.argsort(np.diff(nodes))[-WIDEST:])
        return np.asarray(0.5 * (nodes[wide] + nodes[wide + 1]))

    @cached_property
    def arrays(self) -> dict[str, np.ndarray]:
        """Arrays of a workspace for the kernel."""
        return {
            "stage_times": self.c, "stage_weights": self.a, "end_weights": self.ends,
            "dense_weights": np.array(self.dense, dtype=float).reshape(len(self.dense), len(self.c)),
            "stage_gaps": self.gaps if self.adaptive else np.zeros(0),
        }  # fmt: skip
