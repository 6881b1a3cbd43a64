"""Plans: which values of the parameters the samples have, made piece by piece."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from rattle.value_types import Json

KEPT_WHOLE = 1000  # values of an axis that a description lists; of more it has a checksum


class Points(Protocol):
    """Points of a design, see `sampling`."""

    @property
    def design(self) -> str:
        """Its name."""

    @property
    def seed(self) -> int:
        """What its points were drawn with."""

    @property
    def grows(self) -> bool:
        """Whether the first points stay as they are when there are more of them."""

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

    @property
    def description(self) -> dict[str, Json]:
        """All that the values follow from, as plain data."""

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

    @property
    def grows(self) -> bool:
        """Whether the first samples stay as they are when n is larger."""

    @property
    def description(self) -> dict[str, Json]:
        """All that the values follow from but n, as plain data, by which a plan is known again."""

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

    @property
    def grows(self) -> bool:
        """Whether the first samples stay as they are when n is larger."""
        return self.points.grows

    @property
    def description(self) -> dict[str, Json]:
        """Design, seed and fields."""
        return {
            "kind": "ensemble", "design": self.points.design, "seed": self.points.seed, **self.fields.description
        }  # fmt: skip

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
        return tuple(len(axis) for axis in self.axes.values())

    @property
    def count(self) -> int:
        """n."""
        return math.prod(self.shape)

    @property
    def grows(self) -> bool:
        """False: a larger grid has its combinations elsewhere."""
        return False

    @property
    def description(self) -> dict[str, Json]:
        """The values of all parameters."""
        return {"kind": "sweep", "axes": {name: _kept(axis) for name, axis in self.axes.items()}}

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

    @property
    def grows(self) -> bool:
        """False: it is not known which further samples there will be."""
        return False

    @property
    def description(self) -> dict[str, Json]:
        """The values of all parameters."""
        return {"kind": "given samples", "axes": {n: _kept(row) for n, row in zip(self.names, self.table, strict=True)}}

    def values(self, first: int, last: int) -> np.ndarray:
        """(k, last - first) values [SI]."""
        return np.asarray(self.table[:, first:last])


def _kept(values: np.ndarray) -> list[float] | str:
    """Values (n,) as plain data: those themselves if there are few."""
    if len(values) <= KEPT_WHOLE:
        return [float(value) for value in values]
    return f"{len(values)} values, sha256 {hashlib.sha256(np.ascontiguousarray(values, '<f8').tobytes()).hexdigest()}"
