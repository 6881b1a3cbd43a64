"""Curves that follow from stored ones, for a page: the formulas of `rattle.results.derived` as numbers of a drawing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rattle.drawings.numbers import Number, Value, call, cos, sin
from rattle.drawings.sheet import Sheet
from rattle.results.derived import rules, unit_of_rule, value_of

OF_BODY = ("x", "y", "angle", "vx", "vy", "omega")


def derived_curves(geometry: Mapping[str, Any]) -> dict[str, Any]:
    """Nodes of a tape, and of each curve that may follow its unit and its place there."""
    sheet, numbers = Sheet(geometry), dict[str, Number]()
    stored = {f"{body}.{key}" for body in geometry["bodies"] for key in OF_BODY}
    stored |= {f"{joint}.fx" for joint in geometry["joints"]} | {f"{load}.force" for load in geometry["loads"]}
    derived = rules(_with_numbers(sheet), stored)

    def curve(name: str) -> Number:
        return numbers.get(name) or sheet.curve(name)

    for name, rule in derived.items():
        numbers[name] = value_of(rule, curve, cos, sin, _hypot)
    curves = {name: [unit_of_rule(name, rule), numbers[name].place] for name, rule in derived.items()}
    return {"numbers": sheet.tape.nodes, "curves": curves}


def _hypot(x: Value, y: Value) -> Number:
    return call("hypot", x, y)


def _with_numbers(sheet: Sheet) -> dict[str, Any]:
    """The geometry of a sheet with numbers of its tape for points and directions."""

    def pair(*place: str | int) -> tuple[Number, ...]:
        return tuple(sheet.tape.node("of", *place, k) for k in (0, 1))

    numbered: dict[str, Any] = {
        "bodies": {
            body: {"points": {name: pair("bodies", body, "points", name) for name in form["points"]}}
            for body, form in sheet.geometry["bodies"].items()
        }
    }
    for family in ("joints", "loads"):
        numbered[family] = {}
        for name, form in sheet.geometry[family].items():
            axis = {"axis": sheet.tape.node("of", family, name, "axis")} if "axis" in form else {}
            points = [pair(family, name, "points", end) for end in range(len(form["points"]))]
            numbered[family][name] = {**form, "points": points, **axis}
    return numbered
