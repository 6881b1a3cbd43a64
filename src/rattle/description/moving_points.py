"""Points of the ground that move: each is a body without mass, of which three drivers set x, y and angle.

So position, rate and acceleration are exact wherever drivers are, and what moves the point does work as a driver does.
"""

from __future__ import annotations

from rattle.description.model import GROUND, Body, Driver, Point, Value


def moving_point(point: str) -> Body:
    """The body of a point of the ground that moves."""
    return Body(f"{GROUND}.{point}", 0.0, 0.0, {})


def drivers_of_point(point: str, at: tuple[Value, Value]) -> dict[str, Driver]:
    """The drivers of a point of the ground that moves, whose coordinates [m] are functions of time."""
    body = moving_point(point).name
    functions: dict[str, Value] = {"x": at[0], "y": at[1], "angle": 0.0}
    place = Point(body, "", (0.0, 0.0))
    return {f"{body}.{key}": Driver(f"{body}.{key}", f"body-{key}", "", f, place) for key, f in functions.items()}
