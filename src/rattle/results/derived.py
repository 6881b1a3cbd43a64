"""Curves that follow from stored ones: points of bodies, forces of joints, coordinates of joints and loads.

Arithmetic alone, so that it serves arrays of results and symbols of straight-line code.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import Any, NamedTuple

from rattle.description.coordinates import COINCIDENT
from rattle.value_types import Tree

POINT = {"x": "m", "y": "m", "vx": "m/s", "vy": "m/s"}  # of a point, with units
KEYS = {"angle": ("angle", "rate"), "position": ("position", "rate"), "length": ("length", "rate")}
UNITS = {"angle": "rad", "position": "m", "length": "m"}


class Rule(NamedTuple):
    """How a curve follows from others.

    what: "force" of a joint, a key of POINT, a coordinate or "<coordinate> rate", "power" or "same".
    owner: of the curves that it takes.  bodies, points [m]: A and B, or one body.  number: direction of the line in A
    [rad], or the sign of the power.
    """

    what: str
    owner: str
    bodies: tuple[str, ...] = ()
    points: tuple[tuple[Any, Any], ...] = ()
    number: Any = 0.0


def rules(geometry: Tree, stored: Collection[str]) -> dict[str, Rule]:
    """Names derived from stored columns."""
    derived: dict[str, Rule] = {}
    for body, form in geometry.get("bodies", {}).items():
        for point, (x, y) in form["points"].items():
            keys = [key for key in POINT if f"{body}.{key}" in stored]
            derived |= {f"{body}.{point}.{key}": Rule(key, body, (body,), ((x, y),)) for key in keys}
    for joint, form in geometry.get("joints", {}).items():
        if f"{joint}.fx" in stored:
            derived[f"{joint}.force"] = Rule("force", joint)
        if form.get("coordinate"):
            derived |= _between(joint, form["coordinate"], form, form.get("axis", 0.0), stored)
    for load, form in geometry.get("loads", {}).items():
        if form.get("coordinate"):
            derived |= _of_load(load, form, stored)
    return {name: rule for name, rule in derived.items() if name not in stored}


def _of_load(load: str, form: Tree, stored: Collection[str]) -> dict[str, Rule]:
    """Names of a load between two points or bodies."""
    derived, turns = _between(load, form["coordinate"], form, 0.0, stored), form["coordinate"] == "angle"
    if turns and f"{load}.angle" in derived:
        derived[f"{load}.length"] = derived[f"{load}.angle"]
    if f"{load}.force" in stored and f"{load}.rate" in derived:
        derived[f"{load}.power"] = Rule("power", load, number=form["power"])
        if turns:
            derived[f"{load}.torque"] = Rule("same", f"{load}.force")
    return derived


def _between(owner: str, coordinate: str, form: Tree, axis: Any, stored: Collection[str]) -> dict[str, Rule]:
    bodies = tuple(form["bodies"])
    points = tuple((point[0], point[1]) for point in form["points"])
    moving = [body for body in bodies if body != "ground"]
    derived = {}
    if all(f"{body}.x" in stored for body in moving):
        derived[f"{owner}.{coordinate}"] = Rule(coordinate, owner, bodies, points, axis)
    if all(f"{body}.vx" in stored for body in moving):
        derived[f"{owner}.rate"] = Rule(f"{coordinate} rate", owner, bodies, points, axis)
    return derived


def unit_of_rule(name: str, rule: Rule) -> str:
    """SI unit of a derived curve."""
    what = rule.what
    if what in POINT:
        return POINT[what]
    if what.endswith(" rate"):
        return f"{UNITS[what.removesuffix(' rate')]}/s"
    return {"force": "N", "power": "W", "same": "N*m", **UNITS}[what]


def value_of(rule: Rule, curve: Callable[[str], Any], cos: Any, sin: Any, hypot: Any) -> Any:
    """The curve of a rule from others; cos, sin, hypot: functions of curves."""
    what = rule.what
    if what == "force":
        return hypot(curve(f"{rule.owner}.fx"), curve(f"{rule.owner}.fy"))
    if what == "same":
        return curve(rule.owner)
    if what == "power":
        return rule.number * curve(f"{rule.owner}.force") * curve(f"{rule.owner}.rate")
    if what in POINT:
        return _point(rule.bodies[0], rule.points[0], curve, cos, sin, what.startswith("v"))[what.removeprefix("v")]
    rate = what.endswith(" rate")
    a, b = rule.bodies
    if what.startswith("angle"):
        key = "omega" if rate else "angle"
        return _of_body(b, key, curve) - _of_body(a, key, curve)
    at_a, at_b = (_point(body, at, curve, cos, sin, False) for body, at in zip(rule.bodies, rule.points, strict=True))
    dx, dy = at_b["x"] - at_a["x"], at_b["y"] - at_a["y"]
    if what == "length":
        return hypot(dx, dy)
    along = _of_body(a, "angle", curve) + rule.number
    ux, uy = cos(along), sin(along)
    if what == "position":
        return dx * ux + dy * uy
    va, vb = (_point(body, at, curve, cos, sin, True) for body, at in zip(rule.bodies, rule.points, strict=True))
    vx, vy = vb["x"] - va["x"], vb["y"] - va["y"]
    if what == "length rate":
        return (dx * vx + dy * vy) / hypot(hypot(dx, dy), COINCIDENT)
    return vx * ux + vy * uy + _of_body(a, "omega", curve) * (dy * ux - dx * uy)


def _of_body(body: str, key: str, curve: Callable[[str], Any]) -> Any:
    return 0.0 if body == "ground" else curve(f"{body}.{key}")


def _point(
    body: str, at: tuple[Any, Any], curve: Callable[[str], Any], cos: Any, sin: Any, rate: bool
) -> dict[str, Any]:
    """Coordinates of a point [m], or of its velocity [m/s]."""
    x, y = at
    if body == "ground":
        return {"x": 0.0, "y": 0.0} if rate else {"x": x, "y": y}
    c, s = cos(curve(f"{body}.angle")), sin(curve(f"{body}.angle"))
    right, up = c * x - s * y, s * x + c * y
    if not rate:
        return {"x": curve(f"{body}.x") + right, "y": curve(f"{body}.y") + up}
    w = curve(f"{body}.omega")
    return {"x": curve(f"{body}.vx") - w * up, "y": curve(f"{body}.vy") + w * right}
