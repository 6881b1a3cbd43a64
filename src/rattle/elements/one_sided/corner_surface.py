"""What the surfaces have in common that corners or a disc of B touch, each of which is one contact."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from rattle.elements.one_sided.holding import Vector, pinned, seen_from
from rattle.interfaces.contacts import Corners, Held, OneSidedKind, Pose
from rattle.interfaces.fields import Fields
from rattle.jit import layout as at
from rattle.jit.functions import compiled
from rattle.jit.geometry import turn_x, turn_y
from rattle.language.local_function import LocalFunction
from rattle.language.recorded import hypot, largest

REACH, ROLLER = range(at.POINTS, at.POINTS + 2)  # of the farthest corner [m], radius of a disc of B, 0 of corners [m]
SHAPE = at.POINTS + 2  # what is the surface's own; then x and y of every corner [m], from the mass centre of B


def reach_of(corners: Corners) -> float:
    """Largest distance of a corner from the mass centre of B [m]."""
    return largest(*(hypot(x, y) for x, y in corners.values()))


def flat(corners: Corners) -> list[float]:
    """x and y of all corners [m]."""
    return [number for corner in corners.values() for number in corner]


@compiled
def between(body, a, b, p, k, corner):
    """Arms of the point p[k: k + 2] of A and of the corner p[corner: corner + 2] of B, and d [m], x and y each."""
    sax, say = turn_x(body, a, p[k], p[k + 1]), turn_y(body, a, p[k], p[k + 1])
    sbx, sby = turn_x(body, b, p[corner], p[corner + 1]), turn_y(body, b, p[corner], p[corner + 1])
    return sax, say, sbx, sby, body[b, at.X] + sbx - body[a, at.X] - sax, body[b, at.Y] + sby - body[a, at.Y] - say


@compiled
def between_centres(body, a, b, p, k):
    """From the point p[k: k + 2] of A to the mass centre of B [m], x and y."""
    x = body[b, at.X] - body[a, at.X] - turn_x(body, a, p[k], p[k + 1])
    return x, body[b, at.Y] - body[a, at.Y] - turn_y(body, a, p[k], p[k + 1])


class CornerSurface(OneSidedKind, ABC):
    """Interface of the surfaces of A that corners of B touch, or its disc, which counts as a corner at its centre."""

    joint = "surface"
    wall = "a surface"
    bounded = True
    slides = True

    @staticmethod
    @abstractmethod
    def shape(fields: Fields) -> tuple[float | LocalFunction, ...]:
        """What the kernel takes of the surface."""

    @staticmethod
    @abstractmethod
    def guided(fields: Fields, on_a: Vector, on_b: Vector, place: Vector, rolls: bool) -> tuple[Held, ...]:
        """The joints by which a corner that slides is held on it, or a disc, which may roll; place: its, from on_a."""

    @classmethod
    def count(cls, fields: Fields, corners: Corners) -> int:
        """One of every corner."""
        return len(corners)

    @classmethod
    def labels(cls, fields: Fields, corners: Corners) -> tuple[str, ...]:
        """Names of the corners, if there are several."""
        return tuple(corners) if len(corners) > 1 else ()

    @classmethod
    def parameters(
        cls, fields: Fields, constants: Sequence[float], corners: Corners
    ) -> Sequence[float | LocalFunction]:
        """Reach, radius of the disc, what is the surface's own, corners."""
        return (reach_of(corners), fields["roller"], *cls.shape(fields), *flat(corners))

    @staticmethod
    def levers(p: Sequence[float]) -> tuple[float, float]:
        """Arms [m] of A's point and of the farthest corner."""
        return hypot(p[0], p[1]), p[REACH]

    @classmethod
    def held(
        cls, fields: Fields, on_a: Vector, corners: Corners, corner: int, a: Pose, b: Pose, sticks: bool
    ) -> tuple[Held, ...]:
        """A corner that sticks by a pin, otherwise as it is guided."""
        on_b = list(corners.values())[corner]
        if sticks and not fields["roller"] > 0.0:
            return (pinned(a, b, on_b),)
        x, y = seen_from(a, b, on_b)
        return cls.guided(fields, on_a, on_b, (x - on_a[0], y - on_a[1]), sticks)
