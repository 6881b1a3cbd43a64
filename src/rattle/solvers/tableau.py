"""Explicit Runge-Kutta methods as data: one kernel, `explicit`, and the lanes of `rattle.trace` run them all.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), sections II.1, II.4 and II.6.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
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

    Raises InputError for coefficients that contradict each other, or the order (its conditions up to the fourth, and
    those of quadrature).  Source of these: the same book, table II.2.1.
    """

    order: int  # power of the step with which the error decreases
    times: Numbers  # c: of the s stages; if there are further ones, 1 for the end of the step, then theirs
    rows: Rows  # a: of the same, each as far as it is not zero
    weights: Numbers  # (s,) b
    errors: Rows = ()  # weights of an error estimate; a second one damps it, see `explicit`
    dense: Rows = ()  # at most four rows
    stable: int = 0  # fastest rate times step beyond which it is not stable, if its last stage shows it; 0: ignored

    def __post_init__(self) -> None:
        self._require_shapes()
        a, c, ends = self.a, self.c, self.ends
        if np.triu(a).any() or np.abs(a.sum(axis=1) - c).max() > EXACT:
            raise InputError("rows of a tableau take slopes of stages before them, and sum up to the time of theirs")
        if self.dense_stages and c[self.stages] != 1.0:
            raise InputError("before further stages a tableau lists the end of the step: time 1, and its row")
        for sum_, value in self._conditions():
            if abs(sum_ - value) > EXACT:
                raise InputError(
                    f"these coefficients are not of order {self.order}: a sum is {sum_:.6g}, not {value:.6g}"
                )
        if len(ends) > 1 and np.abs(ends[1:].sum(axis=1)).max() > EXACT * np.abs(ends).max():
            raise InputError("weights of an error estimate sum up to zero")
        if not ends[1:].any(axis=1).all():
            raise InputError("an error estimate of a tableau has weights that are not zero")

    def _require_shapes(self) -> None:
        """Raise InputError for coefficients that are no numbers, or of which there are too few or too many."""
        few, every = len(self.weights), len(self.times)
        if isinstance(self.order, bool) or not isinstance(self.order, int) or self.order < 1:
            raise InputError(f"the order of a tableau is a whole number from 1 on, not {self.order!r}")
        if not (1 <= few <= every == len(self.rows)) or max(map(len, self.rows)) > every:
            raise InputError("a tableau has a time and a row for every stage, and a weight for those of the step")
        if len(self.errors) > 2 or {*map(len, self.errors)} - {few}:
            raise InputError(
                "a tableau has at most two error estimates, each with a weight for every stage of the step"
            )
        if len(self.dense) > 4 or {*map(len, self.dense)} - {every}:
            raise InputError("a tableau has at most four rows of dense output, each with a weight for every slope")
        lists = (self.times, self.weights, *self.rows, *self.errors, *self.dense)
        if not all(map(math.isfinite, itertools.chain(*lists))) or self.stable < 0:
            raise InputError("coefficients of a tableau are finite numbers, and its bound of stability is not negative")

    def _conditions(self) -> Iterator[tuple[float, float]]:
        """Sums of the coefficients and what they are: quadrature up to the order, all conditions up to the fourth."""
        few = self.stages
        b, c, a = self.ends[0], self.c[:few], self.a[:few, :few]
        yield from ((float(b @ c**k), 1.0 / (k + 1)) for k in range(self.order))
        if self.order > 2:
            yield float(b @ a @ c), 1.0 / 6.0
        if self.order > 3:
            yield float((b * c) @ a @ c), 1.0 / 8.0
            yield float(b @ a @ c**2), 1.0 / 12.0
            yield float(b @ a @ a @ c), 1.0 / 24.0

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
        return np.array([self.weights, *self.errors], dtype=float)

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
