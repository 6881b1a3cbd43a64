"""Plans: which values of the parameters the samples have, made piece by piece."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np


class Points(Protocol):
    """Points of a design, see `sampling`."""

    @property
    def count(self) -> int:
        """Number of points."""

    def points(self, first: int, last: int) -> np.ndarray:
        """(last - first, d) points in [0, 1)."""


class Fields(Protocol):
    """Fields of parameters, see `fields`."""

    @property
    def names(self) -> tuple[str, ...]:
        """(k,) names of the parameters."""

    def values(self, points: np.ndarray) -> np.ndarray:
        """(k, c) values [SI] at points (c, d)."""


class Plan(Protocol):
    """Values of the parameters of n samples; those of sample i do not depend on how the samples are cut into pieces."""

    @property
    def names(self) -> tuple[str, ...]:
        """(k,) parameters that differ."""

    @property
    def count(self) -> int:
        """n."""

    def values(self, first: int, last: int) -> np.ndarray:
        """(k, last - first) values [SI] of the samples from `first` to before `last`."""


@dataclass(frozen=True)
class Drawn:
    """Samples drawn from the fields of parameters."""

    fields: Fields
    points: Points

    @property
    def names(self) -> tuple[str, ...]:
        """(k,) parameters that differ."""
        return self.fields.names

    @property
    def count(self) -> int:
        """n."""
        return self.points.count

    def values(self, first: int, last: int) -> np.ndarray:
        """(k, last - first) values [SI]."""
        return self.fields.values(self.points.points(first, last))


@dataclass(frozen=True)
class Grid:
    """All combinations of the values of parameters, the last one changing fastest."""

    axes: Mapping[str, np.ndarray]  # parameter: (n_k,) values [SI]

    @property
    def names(self) -> tuple[str, ...]:
        """(k,) parameters that differ."""
        return tuple(self.axes)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of every parameter."""
        return tuple(len(one) for one in self.axes.values())

    @property
    def count(self) -> int:
        """n."""
        return math.prod(self.shape)

    def values(self, first: int, last: int) -> np.ndarray:
        """(k, last - first) values [SI]."""
        places = np.unravel_index(np.arange(first, last), self.shape)
        return np.array([axis[place] for axis, place in zip(self.axes.values(), places, strict=True)])


@dataclass(frozen=True, eq=False)
class Given:
    """Samples whose values are given."""

    names: tuple[str, ...]  # (k,) parameters that differ
    table: np.ndarray  # (k, n) their values [SI]

    @property
    def count(self) -> int:
        """n."""
        return int(self.table.shape[1])

    def values(self, first: int, last: int) -> np.ndarray:
        """(k, last - first) values [SI]."""
        return np.asarray(self.table[:, first:last])
