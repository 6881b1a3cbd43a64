"""A model as a scene whose motion the page computes by itself while a knob is turned."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection
from typing import Any

from rattle.description.file import parse
from rattle.errors import TraceError
from rattle.language.units import parse_quantity
from rattle.pages.page import live_scene
from rattle.pages.scene import run_of
from rattle.studio.shelf import Shelf, Source


def shape_of(text: str, turnable: Collection[str] | None = None) -> str:
    """A digest of all that a model is but the values of its parameters, or of those that are turnable."""
    document = parse(text)
    parameters = dict(document.get("parameters", {}))
    for name, entry in parameters.items():
        value = entry.get("value") if isinstance(entry, dict) else entry
        follows = isinstance(value, str) and parse_quantity(value) is None
        if not follows and (turnable is None or name in turnable):
            parameters[name] = {**entry, "value": 0} if isinstance(entry, dict) else 0
    whole = json.dumps({**document, "parameters": parameters}, default=str)
    return hashlib.sha256(whole.encode()).hexdigest()


def live(shelf: Shelf, source: Source, known: str = "") -> dict[str, Any]:
    """The scene of a model that a page can compute; known: the shape of the one that the page has.

    Without a scene if the page has it already, or if the model cannot be computed in a page: `why` then says so.
    """
    m = shelf.mechanism(source)
    shape = shape_of(source["text"])
    names = shelf.turnable.get(shape)
    if names is not None and shape_of(source["text"], names) == known:
        return {"shape": known}
    try:
        scene = live_scene(m)
    except TraceError as error:
        shelf.turnable[shape] = set()
        return {"shape": "", "why": str(error)}
    names = {knob["name"] for knob in scene["knobs"]}
    shelf.turnable[shape] = names
    r = shelf.motion(source)
    scene["runs"] = [run_of(r, "", scene["geometry"])]
    return {"shape": shape_of(source["text"], names), "base": shape, "scene": scene}
