"""Scenes: results as one JSON document that the viewer shows; docs/scene.md describes every key."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from rattle import registry
from rattle.errors import InputError
from rattle.plots.scene import BODIES
from rattle.results.result import Result
from rattle.results.trust import HOW, Trust
from rattle.version import __version__

FORMAT = "rattle-scene 1"
OF_GHOST = (".x", ".y", ".angle")
MOST_ROWS = 2501  # of a run in a page


def scene_of(
    results: Sequence[tuple[str, Result]], *, ideal: Result | None = None, title: str = "",
    show: Mapping[str, Any] | None = None, notes: Iterable[str] = (),
) -> dict[str, Any]:  # fmt: skip
    """The scene of one or several results of a mechanism, each with a label; ready for JSON.

    ideal: a result of the same mechanism without play, the ghost.  show: what the viewer shows at first.
    Raises InputError without a result, or for one without motion of bodies.
    """
    if not results:
        raise InputError("a scene needs at least one result")
    for _, one in results:
        require_motion(one)
    first = results[0][1]
    said = list(notes)
    thinned = [(len(rows(one)), len(one.t)) for _, one in results if len(rows(one)) < len(one.t)]
    if thinned:
        shown, every = thinned[0]
        said.append(f"shown are {shown} of the {every} instants of the result, evenly chosen; events keep their times")
    scene: dict[str, Any] = plain({
        **frame_of(first.geometry),
        "title": title or str(first.provenance.get("model") or "") or "Mechanism",
        "geometry": first.geometry,
        "runs": [run_of(one, label, first.geometry) for label, one in results],
        "ideal": None if ideal is None else run_of(ideal, "without play", first.geometry, OF_GHOST),
        "knobs": [],
        "live": None,
        "show": dict(show or {}),
        "notes": said,
    })  # fmt: skip
    return scene


def frame_of(geometry: Mapping[str, Any]) -> dict[str, Any]:
    """Those keys of a scene that follow from the geometry of a model alone: format, program, kinds, colours."""
    return {
        "format": FORMAT,
        "program": f"rattle {__version__}",
        "kinds": kinds_of(geometry),
        "colours": {body: BODIES[k % len(BODIES)] for k, body in enumerate(geometry["bodies"])},
    }


def kinds_of(geometry: Mapping[str, Any]) -> dict[str, dict[str, str]]:
    """How joints and loads are drawn, by name, and what the play of a joint looks like: a circle, or walls."""
    drawn: dict[str, dict[str, str]] = {"joints": {}, "loads": {}, "play": {}}
    for family in ("joint", "load"):
        known = registry.kinds(family)
        for name, form in geometry[f"{family}s"].items():
            how = getattr(known[form["type"]].leaf, "drawn_as", "") if form["type"] in known else ""
            if how:
                drawn[f"{family}s"][name] = how
    for name, form in geometry["joints"].items():
        if play := registry.play_of(form["type"]):
            drawn["play"][name] = "circle" if play.leaf.orbit else "walls"
    return drawn


def require_motion(result: Result) -> None:
    """Raise InputError if a result has no motion of bodies that could be shown."""
    if not result.geometry["bodies"]:
        raise InputError("this result holds curves only, no motion of bodies that could be shown")
    if not len(result.t):
        raise InputError("the result has no instant to show")


def rows(result: Result) -> np.ndarray:
    """Those rows of a result that a page holds: evenly spaced, with the first and the last."""
    n = len(result.t)
    every = max(1, math.ceil((n - 1) / (MOST_ROWS - 1)))
    picked = np.arange(0, n, every)
    return picked if picked[-1] == n - 1 else np.append(picked, n - 1)


def run_of(result: Result, label: str, geometry: Mapping[str, Any], keys: Sequence[str] = ()) -> dict[str, Any]:
    """One run of a scene; its geometry is left out where it is that of the scene.

    keys: of the curves that are kept, such as `.x`; all curves without any.
    """
    picked = rows(result)
    names = [name for name in result.stored if not keys or name.endswith(tuple(keys))]
    data = np.column_stack([result[name][picked] for name in names])
    with np.errstate(over="ignore"):
        columns = np.ascontiguousarray(data.T).astype("<f4")
    run = {
        "label": label,
        "parameters": dict(result.provenance.get("parameters") or {}),
        "names": names,
        "units": [result.unit(name) for name in names],
        "n": len(picked),
        "t": packed(result.t[picked].astype("<f8")),
        "data": packed(columns),
        "events": [list(event) for event in result.events],
        "trust": trust_of(result.trust),
        "success": result.success,
        "message": result.message,
    }
    return run if result.geometry == geometry else run | {"geometry": result.geometry}


def trust_of(trust: Trust) -> dict[str, Any]:
    """What a page says about how far a run can be trusted: numbers (SI) and the lines of `str(trust)`."""
    return {
        "drift": trust.drift,
        "energy": trust.energy_balance,
        "energy_share": trust.energy_share,
        "pulled": dict(trust.pulled),
        "horizon": trust.horizon,
        "text": str(trust).replace(HOW, "").splitlines(),
    }


def packed(values: np.ndarray) -> str:
    """The bytes of an array as base64."""
    return base64.b64encode(values.tobytes()).decode("ascii")


def plain(value: Any) -> Any:
    """A value with only what JSON knows: numbers that are not finite become null."""
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value


def scene_json(scene: Mapping[str, Any]) -> str:
    """A scene as JSON that may stand inside of a script element of a page."""
    text = json.dumps(plain(scene), ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
