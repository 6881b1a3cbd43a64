"""What clicks of the measuring tool mean: distances, angles, and what a point or a body does over a turn."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from rattle.errors import ANSWERS
from rattle.mechanism import Mechanism
from rattle.results.display import quantity
from rattle.sketch import measure, over_a_turn
from rattle.sketch.drawn import Drawn
from rattle.sketch.measure import Measure
from rattle.sketch.revision import Caught
from rattle.sketch.spots import Place

PER_TORQUE = "1/m"  # unit of a force over a torque


class Reading(NamedTuple):
    """One measure, or why there is none."""

    words: str
    signals: Mapping[str, str] = {}  # entries of [signals] that record it, by name
    curves: Sequence[np.ndarray] = ()  # (n, 2) lines of the plane [m]
    refused: bool = False


def readings(sketch: Drawn, spots: Sequence[Caught]) -> list[Reading]:
    """What clicks measure: of one, what a point or body does over a turn; of two a distance, of three an angle."""
    m = sketch.mechanism
    places = [_place(sketch, spot) for spot in spots]
    q = np.array([sketch.places[name] for name in m.system.bodies if name in sketch.places]).ravel()
    if len(spots) == 1:
        return list(_over_a_turn(sketch, spots[0], places[0], q))
    if len(spots) == 2:
        return [_told(partial(measure.distance, m, places[0], places[1], q=q))]
    first, corner, last = places
    return [_told(partial(measure.angle, m, first, corner, last, q=q))]


def _place(sketch: Drawn, spot: Caught) -> Place:
    if spot.point:
        return spot.point
    return (spot.line, sketch.in_frame(spot.line, spot.at)) if spot.line else ("ground", spot.at)


def _told(read: Callable[[], Measure]) -> Reading:
    """A measure, or why there is none."""
    try:
        read_off = read()
    except ANSWERS as error:
        return Reading(str(error), refused=True)
    number, unit = read_off.value, read_off.unit
    value = quantity(number, unit) if unit != PER_TORQUE else f"{number:.4g} N for each N m"
    return Reading(f"{read_off.label}: {value}", {read_off.name: read_off.expression})


def _advantage(m: Mechanism, motor: str, place: Place, q: np.ndarray) -> Measure:
    advantage = measure.mechanical_advantage(m, motor, place, q=q)
    return advantage._replace(label=f"mechanical advantage of {motor} at {place}")


def _over_a_turn(sketch: Drawn, spot: Caught, place: Place, q: np.ndarray) -> Iterator[Reading]:
    m = sketch.mechanism
    if spot.line and not spot.point:
        yield _centrodes(sketch, spot.line)
        return
    if not spot.point:
        return
    pins = [
        pin.name for pin in sketch.pins if pin.kind == "revolute" and set(pin.ends) & set(sketch.joined(spot.point))
    ]
    motors = list(m.model.drivers)[:1]
    others = [
        *(partial(measure.transmission_angle, m, pin, q=q) for pin in pins),
        *(partial(_advantage, m, motor, place, q) for motor in motors),
    ]
    yield _path(sketch, place)
    yield from (reading for reading in map(_told, others) if not reading.refused)


def _path(sketch: Drawn, place: Place) -> Reading:
    try:
        path = over_a_turn.path(sketch.mechanism, place)
    except ANSWERS as error:
        return Reading(str(error), refused=True)
    more = f" ({path.words})" if path.words else ""
    return Reading(f"{path.label}{more}", path.signals, [np.column_stack([path.x, path.y])])


def _centrodes(sketch: Drawn, body: str) -> Reading:
    """Both centrodes, the moving one where the body stands."""
    try:
        polodes = over_a_turn.centrodes(sketch.mechanism, body)
    except ANSWERS as error:
        return Reading(str(error), refused=True)
    moving = np.array([sketch.in_plane(body, (x, y)) for x, y in polodes.moving])
    more = f" ({polodes.words})" if polodes.words else ""
    return Reading(f"{polodes.label}{more}", polodes.signals, [polodes.fixed, moving])


def message_of(measures: Sequence[Reading]) -> dict[str, Any]:
    """Readings as plain data for a page."""
    rows = [{"words": reading.words, "signals": dict(reading.signals),
             "curves": [np.where(np.isfinite(curve), curve, np.nan).tolist() for curve in reading.curves]}
            for reading in measures]  # fmt: skip
    return {"kind": "readings", "rows": rows}
