"""Circles about one centre: bushes and their pins."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from rattle.exchange.outlines.edges import Circle

LOOSE = 0.5  # of the radius of a disc: a circle that differs by more is no pin in the disc as a bush
BESIDE, MOST_NOTES = 20, 20  # circles to the right of one that are looked at; notes of that kind
NEAR = 1e-3  # of the drawing: circles of two layers that are as near as this, but have two centres, are named


class Ring(NamedTuple):
    """A circle of a layer."""

    layer: str
    circle: Circle


class Pin(NamedTuple):
    """A revolute joint: the larger circle is the bush, and that of side A."""

    bush: Ring
    pin: Ring
    place: int  # number of the centre
    in_disc: bool = False  # True: the larger circle is the outline of its body

    @property
    def fits(self) -> bool:
        """False if the larger circle is a disc, and not a bush that has this pin."""
        return not self.in_disc or self.bush.circle.radius - self.pin.circle.radius <= LOOSE * self.bush.circle.radius


class Centres(NamedTuple):
    """Circles by their centres."""

    pins: list[Pin]
    at: list[tuple[float, float]]  # centres that layers share
    alone: list[Ring]  # circles about centres of one layer
    notes: list[str]


def pins_of(
    circles: Mapping[str, Sequence[Circle]], rims: Mapping[str, Circle | None], tolerance: float, size: float
) -> Centres:
    """Joints of circles of two or more layers about one centre.

    rims: circles that are the outlines of their layers; they count where their layer has no other about that centre.
    """
    rings = [Ring(layer, circle) for layer, its in circles.items() for circle in its]
    pins: list[Pin] = []
    at: list[tuple[float, float]] = []
    alone: list[Ring] = []
    shared: list[Ring] = []
    for group in _by_centre(rings, tolerance):
        counted = _without_rims(group, rims)
        if len({ring.layer for ring in counted}) < 2:
            alone += [ring for ring in counted if ring.circle != rims.get(ring.layer)]
            continue
        joined = _joined(counted, len(at))
        pins += [pin._replace(in_disc=pin.bush.circle == rims.get(pin.bush.layer)) for pin in joined]
        at.append(counted[0].circle[:2])
        shared += counted
    return Centres(pins, at, alone, _near_misses([*alone, *shared], NEAR * size, tolerance))


def _by_centre(rings: Iterable[Ring], tolerance: float) -> list[list[Ring]]:
    """Circles about the same centre, in the order of the file."""
    reach = tolerance or 1e-300
    cells: dict[tuple[int, int], list[list[Ring]]] = {}
    groups: list[list[Ring]] = []
    for ring in rings:
        x, y, _ = ring.circle
        column, row = math.floor(x / reach), math.floor(y / reach)
        near = (group for i in (0, -1, 1) for k in (0, -1, 1) for group in cells.get((column + i, row + k), ()))
        group = next((group for group in near if math.dist(group[0].circle[:2], (x, y)) <= reach), None)
        if group is None:
            group = []
            groups.append(group)
            cells.setdefault((column, row), []).append(group)
        group.append(ring)
    return groups


def _without_rims(group: Sequence[Ring], rims: Mapping[str, Circle | None]) -> list[Ring]:
    inner = {ring.layer for ring in group if ring.circle != rims.get(ring.layer)}
    return [ring for ring in group if ring.circle != rims.get(ring.layer) or ring.layer not in inner]


def _joined(group: Sequence[Ring], place: int) -> list[Pin]:
    """k layers about one centre have k - 1 joints.

    One pin, the smallest circle, goes through all bushes.  A layer with several circles is a sleeve: what is around it
    turns on its largest, what is inside of it in its smallest.
    """
    joints: list[Pin] = []
    linked = {ring.layer: ring.layer for ring in group}

    def root(layer: str) -> str:
        while linked[layer] != layer:
            layer = linked[layer]
        return layer

    for nested in _nested(sorted(group, key=lambda ring: ring.circle.radius)):
        pin = nested[0]
        for bush in nested[1:]:
            a, b = root(bush.layer), root(pin.layer)
            if a != b:
                linked[a] = b
                joints.append(Pin(bush, pin, place))
    order = {ring.layer: k for k, ring in reversed(list(enumerate(group)))}
    return sorted((_in_order(joint, order) for joint in joints), key=lambda joint: order[joint.bush.layer])


def _in_order(joint: Pin, order: Mapping[str, int]) -> Pin:
    """Of equal circles that of the layer which comes first in the file is the bush, and the ground in any case."""
    (a, b), equal = joint[:2], joint.bush.circle.radius == joint.pin.circle.radius
    first = min((a, b), key=lambda ring: (ring.layer.lower() != "ground", order[ring.layer]))
    return joint if not equal or first is a else joint._replace(bush=b, pin=a)


def _nested(rings: Sequence[Ring]) -> list[list[Ring]]:
    """Circles by size in groups that have one pin: parted where a layer has several, which is a sleeve."""
    radii: dict[str, list[float]] = {}
    for ring in rings:
        radii.setdefault(ring.layer, []).append(ring.circle.radius)
    for layer, own in radii.items():
        if len(own) < 2 or len(radii) < 2:
            continue
        inner, outer = min(own), max(own)
        middle = 0.5 * (inner + outer)
        rest = [ring for ring in rings if ring.layer != layer]
        low = [ring for ring in rest if ring.circle.radius < middle]
        high = [ring for ring in rest if ring.circle.radius >= middle]
        small = next(ring for ring in rings if ring.layer == layer and ring.circle.radius == inner)
        large = next(ring for ring in rings if ring.layer == layer and ring.circle.radius == outer)
        by_size = [
            sorted([*part, sleeve], key=lambda ring: ring.circle.radius)
            for part, sleeve in ((low, small), (high, large))
        ]
        return [group for part in by_size for group in _nested(part)]
    return [list(rings)]


def _near_misses(rings: Sequence[Ring], near: float, tolerance: float) -> list[str]:
    """Circles of two layers that all but have one centre, or would be a pin that is not in the middle of its bush."""
    notes: list[str] = []
    ordered = sorted(rings, key=lambda ring: ring.circle.x)
    for k, ring in enumerate(ordered):
        for other in ordered[k + 1 : k + BESIDE]:
            small, large = sorted((ring.circle.radius, other.circle.radius))
            reach = max(near, large - small) if small > LOOSE * large else near
            apart = math.dist(ring.circle[:2], other.circle[:2])
            if other.layer != ring.layer and tolerance < apart <= reach and len(notes) < MOST_NOTES:
                x, y, _ = ring.circle
                notes.append(
                    f"circles on layers {ring.layer} and {other.layer} near ({x:g}, {y:g}), {apart:.3g} apart: not one"
                    " centre, no joint"
                )
    return notes
