"""Pieces of the JSON Schema of the model file: numbers with units, points, fields, and the forms of tables."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import Any

from rattle import registry
from rattle.catalogue import bearings, oils
from rattle.description.read_fields import geometries
from rattle.description.tables import (
    CONDUCTION,
    DISTRIBUTIONS,
    DUTY_CASE,
    MATERIAL,
    OF_PARAMETERS,
    SECTION_NUMBERS,
    SECTION_SHAPES,
    Part,
)
from rattle.language.materials import MATERIALS
from rattle.registry import REQUIRED, Field, Kind

Schema = dict[str, Any]
NAME = r"^[A-Za-z_][A-Za-z0-9_]*$"
POINT = r"^[^.\s]+\.[^.\s]+$"
NAMES = "x-names"  # keyword of our own: of which parts of the model a text is a name: points, bodies or joints


def table(properties: Mapping[str, Schema], needed: Iterable[str] = (), meaning: str = "") -> Schema:
    schema: Schema = {"type": "object", "properties": dict(properties), "additionalProperties": False}
    if list(needed):
        schema["required"] = list(needed)
    return schema | ({"description": meaning} if meaning else {})


def named(entry: Schema, meaning: str, names: str = NAME) -> Schema:
    """A table whose keys are names chosen by the user, of this pattern."""
    return {
        "type": "object",
        "propertyNames": {"pattern": names},
        "additionalProperties": entry,
        "description": meaning,
    }


def number(unit: str, meaning: str, least: str = "") -> Schema:
    schema: Schema = {"type": ["number", "string"], "description": f"{meaning} [{unit}]" if unit else meaning}
    if least:
        schema["exclusiveMinimum" if least == "positive" else "minimum"] = 0
    return schema


def vector(unit: str, meaning: str) -> Schema:
    return {**array({"type": ["number", "string"]}, 2, 2), "description": f"{meaning} [x, y] [{unit}]"}


def triple(units: tuple[str, str, str], meaning: str, least: str) -> Schema:
    part: Schema = {"type": ["number", "string"], **({"minimum": 0} if least == "not negative" else {})}
    return {**array(part, 3, 3), "description": f"{meaning} [x, y, angle] [{', '.join(units)}]"}


def points(meaning: str) -> Schema:
    return {"type": "object", "additionalProperties": vector("m", "position"), "description": meaning}


def point(meaning: str) -> Schema:
    return {"type": "string", "pattern": POINT, "description": f'{meaning}: "body.point"', NAMES: "points"}


def connect(end: Schema, meaning: str = 'ends A and B, "body.point" each') -> Schema:
    return {**array(end, 2, 2), "description": meaning}


def array(entry: Schema, fewest: int = 0, most: int = 0) -> Schema:
    schema: Schema = {"type": "array", "items": entry}
    return schema | ({"minItems": fewest} if fewest else {}) | ({"maxItems": most} if most else {})


def _material(field: Field) -> Schema:
    return {"anyOf": [_material_by_name(), fields_of(MATERIAL.fields)]}


def _material_by_name() -> Schema:
    return {"type": "string", NAMES: "materials", "examples": list(MATERIALS)}


def _by_name(usual: Iterable[str], field: Field) -> Schema:
    """A name, some of which are told, or a table."""
    return {"anyOf": [{"type": "string", "examples": list(usual)}, {"type": "object"}], "description": field.meaning}


def _section(field: Field) -> Schema:
    shapes = (
        table({"shape": {"const": shape}, **fields_of(sizes)["properties"]}, ("shape", *sizes))
        for shape, sizes in SECTION_SHAPES.items()
    )
    return {"anyOf": [*shapes, fields_of(SECTION_NUMBERS)], "description": field.meaning}


def _steppers(field: Field) -> Schema:
    kinds = registry.kinds("stepper")
    summaries = "; ".join(f"{name}: {kind.summary.removesuffix('.')}" for name, kind in kinds.items())
    return {"enum": list(kinds), "description": summaries}


def _group(field: Field) -> Schema:
    return array({**array({"type": "string", "pattern": OF_PARAMETERS}, 2), "uniqueItems": True})


RING = array(vector("m", "corner"), 3)
PLAIN: Schema = {"type": ["number", "string"]}  # a number or a text
SHAPES: Mapping[str, Callable[[Field], Schema]] = {  # of all shapes but numbers
    "bearing": lambda field: _by_name(bearings.USUAL, field),
    "body": lambda field: {"type": "string", "pattern": NAME, "description": field.meaning, NAMES: "bodies"},
    "cases": lambda field: array(fields_of(DUTY_CASE.fields, DUTY_CASE.meaning), 1),
    "choice": lambda field: {"enum": [*field.choices, *([False, True] if field.flags else [])]},
    "connect": lambda field: connect({"type": "string", NAMES: "points"}),
    "bodies": lambda field: connect({"type": "string", "description": "a body", NAMES: "bodies"}, field.meaning),
    "constant": lambda field: {"const": field.choices[0]},
    "ends": lambda field: connect(point(field.meaning)),
    "cuts": lambda field: named(array(vector("m", "end of the cut"), 2, 2), field.meaning),
    "distribution": lambda field: {"enum": list(DISTRIBUTIONS), "description": field.meaning},
    "each": lambda field: array(PLAIN, 2, 2),
    "file": lambda field: {"type": "string"},
    "flag": lambda field: {"type": "boolean"},
    "film": lambda field: {"enum": list(registry.kinds("film")), "default": field.default},
    "geometry": lambda field: {"enum": geometries()},
    "groups": _group,
    "joint": lambda field: {"type": "string", "pattern": NAME, "description": field.meaning, NAMES: "joints"},
    "labels": lambda field: array({"type": "string"}, field.fewest),
    "line": lambda field: array(array(PLAIN, 2, 2), 2),
    "material": _material,
    "material of a body": lambda field: {**_material_by_name(), "description": field.meaning},
    "names": lambda field: array({"type": "string"}, 2, 2),
    "numbers": lambda field: array(PLAIN, field.fewest),
    "oil": lambda field: _by_name(oils.grades(), field),
    "pair": lambda field: vector(field.unit, field.meaning),
    "place": lambda field: {"type": "string", "description": 'a body, or a point of it: "body.point"', NAMES: "points"},
    "point": lambda field: point(field.meaning),
    "points": lambda field: points(field.meaning),
    "ring": lambda field: RING,
    "section": _section,
    "ways": lambda field: array(fields_of(CONDUCTION.fields, CONDUCTION.meaning)),
    "rings": lambda field: array(RING),
    "stepper": _steppers,
    "table": lambda field: {"type": "object"},
    "text": lambda field: (
        {"type": "string", "description": field.meaning}
        | ({"maxLength": field.longest} if field.longest else {})
        | ({"examples": list(field.choices)} if field.choices else {})
    ),
    "texts": lambda field: array({"type": "string"}, 2, 2),
    "title": lambda field: {"type": "string"},
    "triple": lambda field: triple((field.unit, field.unit, field.turning), field.meaning, field.least),
    "version": lambda field: {"const": 1},
}


def field(declared: Field) -> Schema:
    """A field of a kind or of a table."""
    meaning, default = declared.meaning, declared.default
    if declared.live and not meaning.endswith("of t"):
        meaning += f"; may use {declared.may_use}"
    if declared.function_of:
        meaning += f"; an expression in {declared.function_of} [{declared.of_unit}], which may use tables"
    told = replace(declared, meaning=meaning)
    schema = dict(SHAPES[told.shape](told)) if told.shape in SHAPES else number(told.unit, meaning, told.least)
    if meaning:
        schema.setdefault("description", meaning)
    chosen = default is REQUIRED or default is None or callable(default)
    if not chosen and not (isinstance(default, float) and not math.isfinite(default)):
        schema["default"] = default
    return schema


def fields_of(keys: Mapping[str, Part], meaning: str = "") -> Schema:
    """A table with these fields."""
    declared = {key: entry for key, entry in keys.items() if isinstance(entry, Field)}
    needed = [key for key, entry in declared.items() if entry.default is REQUIRED]
    return table({key: field(entry) for key, entry in declared.items()}, needed, meaning)


def fields(kind: Kind[object]) -> dict[str, Schema]:
    return {key: field(declared) for key, declared in kind.fields.items()}


def needed(kind: Kind[object]) -> list[str]:
    return [key for key, declared in kind.fields.items() if declared.default is REQUIRED]


def choice(kind: Kind[object]) -> Schema:
    return {"const": kind.name, "description": kind.summary}
