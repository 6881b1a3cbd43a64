"""Pieces of the JSON Schema of the model file: numbers with units, points, fields, and the forms of tables."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any

from rattle import registry
from rattle.description.tables import MATERIAL, Part
from rattle.registry import REQUIRED, Field, Kind

Schema = dict[str, Any]
NAME = r"^[A-Za-z_][A-Za-z0-9_]*$"
POINT = r"^[^.\s]+\.[^.\s]+$"
NAMES = "x-names"  # keyword of our own: of which parts of the model a text is a name: points, bodies or joints


def table(properties: Mapping[str, Schema], needed: Iterable[str] = (), meaning: str = "") -> Schema:
    made: Schema = {"type": "object", "properties": dict(properties), "additionalProperties": False}
    if list(needed):
        made["required"] = list(needed)
    return made | ({"description": meaning} if meaning else {})


def named(entry: Schema, meaning: str) -> Schema:
    """A table whose keys are names chosen by the user."""
    return {
        "type": "object",
        "propertyNames": {"pattern": NAME},
        "additionalProperties": entry,
        "description": meaning,
    }


def number(unit: str, meaning: str, least: str = "") -> Schema:
    made: Schema = {"type": ["number", "string"], "description": f"{meaning} [{unit}]" if unit else meaning}
    if least:
        made["exclusiveMinimum" if least == "positive" else "minimum"] = 0
    return made


def vector(unit: str, meaning: str) -> Schema:
    return {**array({"type": ["number", "string"]}, 2, 2), "description": f"{meaning} [x, y] [{unit}]"}


def points(meaning: str) -> Schema:
    return {"type": "object", "additionalProperties": vector("m", "position"), "description": meaning}


def point(meaning: str) -> Schema:
    return {"type": "string", "pattern": POINT, "description": f'{meaning}: "body.point"', NAMES: "points"}


def connect(end: Schema, meaning: str = 'ends A and B, "body.point" each') -> Schema:
    return {**array(end, 2, 2), "description": meaning}


def array(entry: Schema, fewest: int = 0, most: int = 0) -> Schema:
    made: Schema = {"type": "array", "items": entry}
    return made | ({"minItems": fewest} if fewest else {}) | ({"maxItems": most} if most else {})


def _material(one: Field) -> Schema:
    return {"anyOf": [{"type": "string"}, fields_of(MATERIAL.fields)]}


def _steppers(one: Field) -> Schema:
    kinds = registry.kinds("stepper")
    summaries = "; ".join(f"{name}: {kind.summary.removesuffix('.')}" for name, kind in kinds.items())
    return {"enum": list(kinds), "description": summaries}


def _group(one: Field) -> Schema:
    return array({**array({"type": "string", "pattern": NAME}, 2), "uniqueItems": True})


RING = array(vector("m", "corner"), 3)
PLAIN: Schema = {"type": ["number", "string"]}  # a number or a text
SHAPES: Mapping[str, Callable[[Field], Schema]] = {  # of all shapes but numbers
    "body": lambda one: {"type": "string", "pattern": NAME, "description": one.meaning, NAMES: "bodies"},
    "choice": lambda one: {"enum": [*one.choices, *([False, True] if one.flags else [])]},
    "connect": lambda one: connect({"type": "string", NAMES: "points"}),
    "constant": lambda one: {"const": one.choices[0]},
    "each": lambda one: array(PLAIN, 2, 2),
    "file": lambda one: {"type": "string"},
    "flag": lambda one: {"type": "boolean"},
    "film": lambda one: {"enum": list(registry.kinds("film")), "default": one.default},
    "geometry": lambda one: {"enum": [name for name in registry.kinds("stiffness") if name != "power"]},
    "groups": _group,
    "joint": lambda one: {"type": "string", "pattern": NAME, "description": one.meaning, NAMES: "joints"},
    "material": _material,
    "names": lambda one: array({"type": "string"}, 2, 2),
    "numbers": lambda one: array(PLAIN, one.fewest),
    "pair": lambda one: vector(one.unit, one.meaning),
    "point": lambda one: point(one.meaning),
    "points": lambda one: points(one.meaning),
    "ring": lambda one: RING,
    "rings": lambda one: array(RING),
    "stepper": _steppers,
    "table": lambda one: {"type": "object"},
    "text": lambda one: (
        {"type": "string", "description": one.meaning} | ({"maxLength": one.longest} if one.longest else {})
    ),
    "texts": lambda one: array({"type": "string"}, 2, 2),
    "title": lambda one: {"type": "string"},
    "version": lambda one: {"const": 1},
}


def field(declared: Field) -> Schema:
    """A field of a kind or of a table."""
    meaning, default = declared.meaning, declared.default
    if declared.live and not meaning.endswith("of t"):
        meaning += f"; may use {declared.may_use}"
    if declared.function_of:
        meaning += f"; an expression in {declared.function_of} [{declared.of_unit}], which may use tables"
    told = replace(declared, meaning=meaning)
    made = dict(SHAPES[told.shape](told)) if told.shape in SHAPES else number(told.unit, meaning, told.least)
    if meaning:
        made.setdefault("description", meaning)
    chosen = default is REQUIRED or default is None or callable(default)
    if not chosen and not (isinstance(default, float) and not math.isfinite(default)):
        made["default"] = default
    return made


def fields_of(keys: Mapping[str, Part], meaning: str = "") -> Schema:
    """A table with these fields."""
    declared = {key: one for key, one in keys.items() if isinstance(one, Field)}
    needed = [key for key, one in declared.items() if one.default is REQUIRED]
    return table({key: field(one) for key, one in declared.items()}, needed, meaning)


def fields(kind: Kind) -> dict[str, Schema]:
    return {key: field(one) for key, one in kind.fields.items()}


def needed(kind: Kind) -> list[str]:
    return [key for key, one in kind.fields.items() if one.default is REQUIRED]


def choice(kind: Kind) -> Schema:
    return {"const": kind.name, "description": kind.summary}
