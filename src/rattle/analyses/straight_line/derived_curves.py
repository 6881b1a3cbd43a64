"""Curves of a recorded model by the names of a result: its columns, points of bodies, magnitudes of joint forces."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from rattle.description.model import Model
from rattle.equations.system import System
from rattle.language.recorded import symbol_of
from rattle.trace.graph import Graph


def derived_curve(graph: Graph, recorded: System, curves: Mapping[str, Any], name: str) -> tuple[Any, str] | None:
    """Symbol and SI unit of `<body>.<point>.x`, `.y` or `<joint>.force`, from result columns; None for other names.

    recorded: the system with its recorded numbers.  The same as `results.result` derives.
    """
    owner, _, rest = name.partition(".")
    point, _, axis = rest.partition(".")
    if axis in ("x", "y") and owner in recorded.model.bodies and f"{owner}.angle" in curves:
        points = recorded.model.bodies[owner].points
        if point not in points:
            return None
        x, y = (symbol_of(one) for one in points[point])
        cos, sin = (graph.apply(op, curves[f"{owner}.angle"]) for op in ("cos", "sin"))
        turned = cos * x - sin * y if axis == "x" else sin * x + cos * y
        return curves[f"{owner}.{axis}"] + turned, "m"
    if rest == "force" and owner in recorded.model.joints and f"{owner}.fx" in curves:
        return graph.apply("hypot", curves[f"{owner}.fx"], curves[f"{owner}.fy"]), "N"
    return None


def derived_names(model: Model, curves: Collection[str]) -> list[str]:
    """All names that `derived_curve` knows; curves: names of the result columns."""
    bodies = model.bodies.items()
    points = [f"{name}.{point}.{axis}" for name, body in bodies for point in body.points for axis in "xy"]
    return [*points, *(f"{name}.force" for name in model.joints if f"{name}.fx" in curves)]
