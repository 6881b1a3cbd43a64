"""A drawing as plain data for a page: a scene of one instant, and what can be caught, chosen and typed into."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from rattle.pages.scene import scene_of
from rattle.results.build import build_result
from rattle.results.trust import Trust
from rattle.sketch.drawn import Drawn, Pin
from rattle.sketch.fields import fields_of
from rattle.sketch.freedoms import freedoms
from rattle.sketch.numbers import number_of
from rattle.sketch.plays import play_text


def picture_of(sketch: Drawn) -> dict[str, Any]:
    """What a page needs to show a drawing and to let it be changed."""
    driven = {driver.joint: name for name, driver in sketch.model.drivers.items() if driver.joint}
    return {
        "scene": _scene(sketch) if sketch.bodies else None,
        "places": {name: list(sketch.places[name]) for name in sketch.bodies},
        "points": {name: list(spot) for name, spot in sketch.points.items()},
        "bars": {name: [f"{name}.{end}" for end in entry["bar"]]
                 for name, entry in sketch.document.get("bodies", {}).items() if "bar" in entry},
        "joints": [_joint(sketch, pin, driven.get(pin.name, "")) for pin in sketch.pins],
        "loads": {name: [f"{end.body}.{end.name}" for end in (load.a, load.b)]
                  for name, load in ({} if sketch.stand_in else sketch.model.loads).items()},
        "fields": {chosen: [field._asdict() for field in fields_of(sketch, chosen)] for chosen in _things(sketch)},
        "status": freedoms(sketch),
        "picture": underlay_of(sketch.document),
    }  # fmt: skip


def underlay_of(document: Mapping[str, Any]) -> dict[str, Any] | None:
    """The picture below a drawing, its numbers in SI units; None if there is none."""
    entry = document.get("picture")
    if entry is None:
        return None
    x, y = (number_of(part) or 0.0 for part in entry.get("origin", (0.0, 0.0)))
    scale, angle = number_of(entry["scale"]) or 1.0, number_of(entry.get("angle", 0.0)) or 0.0
    return {"file": entry["file"], "scale": scale, "origin": [x, y], "angle": angle}


def _joint(sketch: Drawn, pin: Pin, driver: str) -> dict[str, Any]:
    entry = sketch.document["joints"][pin.name]
    apart = pin.apart if pin in sketch.open_joints else 0.0
    return {
        **pin._asdict(),
        "together": sketch.together(pin),
        "type": pin.kind,
        "driver": driver,
        "play": str(play_text(entry)),
        "apart": apart,
    }


def _things(sketch: Drawn) -> list[str]:
    """Everything that can be chosen."""
    named = {"joint": "joints", "driver": "drivers", "load": "loads"}
    return [
        *(f"body {name}" for name in sketch.bodies),
        *(f"point {name}" for name in sketch.points),
        *(f"{kind} {name}" for kind, table in named.items() for name in sketch.document.get(table, {})),
    ]


def _scene(sketch: Drawn) -> dict[str, Any]:
    """The drawing as a scene of one instant."""
    names = [f"{body}.{key}" for body in sketch.places for key in ("x", "y", "angle")]
    units = {name: "rad" if name.endswith("angle") else "m" for name in names}
    data = np.array([value for place in sketch.places.values() for value in place])[None]
    result = build_result(sketch.model, "drawing", t=[0.0], data=data, names=names, units=units, trust=Trust(drift=0.0))
    scene = scene_of([("", result)])
    scene["runs"][0]["trust"] = {}
    return scene
