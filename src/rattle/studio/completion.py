"""What may stand where in a model text, for the editor of the page: the JSON Schema of the model file, made small.

The schema repeats its parts, those of contacts in every joint; here each different part is told once, by a number.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from rattle.description.schema import schema
from rattle.description.schema_pieces import NAMES, Schema
from rattle.value_types import Json

TOLD = {"description": "about", "const": "const", "enum": "enum", "default": "default", "required": "required"}
TOLD |= {NAMES: "names", "type": "type", "examples": "examples"}


@cache
def entries() -> dict[str, Any]:
    """The parts of the schema, and which of them is the whole: {"parts": [...], "whole": number}.

    A part: what the schema says of it under the names in `TOLD`, and numbers of other parts: those of its keys under
    "keys", that of keys with names of the user's under "any", of the entries of an array under "items", of alternatives
    under "either".
    """
    numbers: dict[str, int] = {}
    parts: list[dict[str, Any]] = []

    def number(part: Schema) -> int:
        small: dict[str, Json] = {ours: part[key] for key, ours in TOLD.items() if key in part}
        if "properties" in part:
            small["keys"] = {key: number(entry) for key, entry in part["properties"].items()}
        if isinstance(part.get("additionalProperties"), dict):
            small["any"] = number(part["additionalProperties"])
        if isinstance(part.get("items"), dict):
            small["items"] = number(part["items"])
            small["pair"] = NAMES in part["items"]  # two names, such as the ends of a joint
        if "anyOf" in part:
            small["either"] = [number(entry) for entry in part["anyOf"]]
        text = repr(small)
        if text not in numbers:
            numbers[text] = len(parts)
            parts.append(small)
        return numbers[text]

    whole = number(schema())
    return {"parts": parts, "whole": whole}
