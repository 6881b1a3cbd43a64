"""Vectors and frames in space, in plain numbers: an assembly has few of them, and every digit of the file counts."""

from __future__ import annotations

import math
from typing import NamedTuple

Vector = tuple[float, float, float]
Matrix = tuple[Vector, Vector, Vector]  # rows
ORTHOGONAL = 1e-5  # by which a rotation may miss being one: files are written with 6 digits or more


def dot(a: Vector, b: Vector) -> float:
    """a . b"""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """a x b"""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def plus(a: Vector, b: Vector) -> Vector:
    """a + b"""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def times(factor: float, a: Vector) -> Vector:
    """factor a"""
    return factor * a[0], factor * a[1], factor * a[2]


def length(a: Vector) -> float:
    """|a|"""
    return math.hypot(*a)


def column(matrix: Matrix, k: int) -> Vector:
    """The axis k of a frame whose rotation this is."""
    return matrix[0][k], matrix[1][k], matrix[2][k]


def turned(matrix: Matrix, a: Vector) -> Vector:
    """R a"""
    return dot(matrix[0], a), dot(matrix[1], a), dot(matrix[2], a)


def turned_back(matrix: Matrix, a: Vector) -> Vector:
    """R^T a"""
    return dot(column(matrix, 0), a), dot(column(matrix, 1), a), dot(column(matrix, 2), a)


def is_rotation(matrix: Matrix) -> bool:
    """True of an orthogonal matrix that is no mirror."""
    x, y, z = matrix
    products = (dot(x, x) - 1.0, dot(y, y) - 1.0, dot(z, z) - 1.0, dot(x, y), dot(y, z), dot(z, x))
    return max(map(abs, products)) < ORTHOGONAL and dot(cross(x, y), z) > 0.0


def across(n: Vector, a: Vector) -> Vector:
    """The unit vector of the part of `a` that is normal to the unit vector n."""
    rest = plus(a, times(-dot(n, a), n))
    return times(1.0 / length(rest), rest)


class Frame(NamedTuple):
    """A frame in another: its origin [m] and the axes as columns."""

    origin: Vector
    axes: Matrix

    def point(self, inner: Vector) -> Vector:
        """A point of this frame, in the outer one."""
        return plus(self.origin, turned(self.axes, inner))

    def holding(self, inner: Frame) -> Frame:
        """A frame that stands in this one, in the outer one."""
        x, y, z = (turned(self.axes, column(inner.axes, k)) for k in range(3))
        return Frame(self.point(inner.origin), ((x[0], y[0], z[0]), (x[1], y[1], z[1]), (x[2], y[2], z[2])))
