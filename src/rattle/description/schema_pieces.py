"""Pieces of the JSON Schema of the model file: numbers with units, points, fields of kinds, tables."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

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
    one = {"type": ["number", "string"]}
    return {"type": "array", "items": one, "minItems": 2, "maxItems": 2, "description": f"{meaning} [x, y] [{unit}]"}


def points(meaning: str) -> Schema:
    return {"type": "object", "additionalProperties": vector("m", "position"), "description": meaning}


def point(meaning: str) -> Schema:
    return {"type": "string", "pattern": POINT, "description": f'{meaning}: "body.point"', NAMES: "points"}


def connect(end: Schema, meaning: str = 'ends A and B, "body.point" each') -> Schema:
    return {
        "type": "array",
        "items": end,
        "minItems": 2,
        "maxItems": 2,
        "description": meaning,
    }


def field(one: Field) -> Schema:
    """A field of a kind, as its class declares it."""
    meaning = one.meaning + (f"; may use {one.may_use}" if one.live and not one.meaning.endswith("of t") else "")
    if one.function_of:
        meaning += f"; an expression in {one.function_of} [{one.of_unit}], which may use tables"
    if one.shape == "choice":
        made: Schema = {"enum": [*one.choices, *([False, True] if one.flags else [])], "description": meaning}
    elif one.shape == "flag":
        made = {"type": "boolean", "description": meaning}
    elif one.shape == "pair":
        made = vector(one.unit, meaning)
    elif one.shape == "point":
        made = point(meaning)
    elif one.shape in ("body", "joint"):
        of_kind = "bodies" if one.shape == "body" else "joints"
        made = {"type": "string", "pattern": NAME, "description": meaning, NAMES: of_kind}
    elif one.shape == "connect":
        made = connect({"type": "string", NAMES: "points"})
    elif one.shape == "material":
        of_own = table({"E": number("Pa", "modulus"), "nu": number("", "Poisson's ratio")}, ("E",))
        made = {"anyOf": [{"type": "string"}, of_own], "description": meaning}
    else:
        made = number(one.unit, meaning, one.least)
    chosen = one.default is REQUIRED or callable(one.default)
    if not chosen and not (isinstance(one.default, float) and not math.isfinite(one.default)):
        made["default"] = one.default
    return made


def fields(kind: Kind) -> dict[str, Schema]:
    return {key: field(one) for key, one in kind.fields.items()}


def needed(kind: Kind) -> list[str]:
    return [key for key, one in kind.fields.items() if one.default is REQUIRED]


def choice(kind: Kind) -> Schema:
    return {"const": kind.name, "description": kind.summary}
