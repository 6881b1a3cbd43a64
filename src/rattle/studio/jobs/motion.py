"""Motion for the viewer, how far it can be trusted, and one mechanism of an ensemble."""

from __future__ import annotations

from typing import Any

import numpy as np

from rattle.errors import InputError
from rattle.pages.scene import scene_of
from rattle.results.display import quantity
from rattle.results.result import Result
from rattle.studio.jobs.live import shape_of
from rattle.studio.shelf import Shelf, Source

MOVES = 1e-6  # range of a position beyond which a body moves [m, rad]


def motion(shelf: Shelf, source: Source) -> dict[str, Any]:
    """The motion for the viewer."""
    r = shelf.motion(source)
    return {
        **_said(r),
        "scene": scene_of([("", r)]),
        "base": shape_of(source["text"]),
        "output": usual_output(r),
        "force": usual_force(r),
    }


def usual_output(r: Result) -> str:
    """The curve that is asked about unless the user says which: the position of the last body that moves."""
    for body in reversed(r.geometry["bodies"]):
        if body in r.geometry["driven"] and len(r.geometry["bodies"]) > 1:
            continue
        for key in ("angle", "x", "y"):
            name = f"{body}.{key}"
            if name in r and len(r.t) and float(np.ptp(r[name])) > MOVES:
                return name
    return next((name for name in r.names if name.endswith(".angle")), r.names[0])


def usual_force(r: Result) -> str:
    """The largest force of a joint, as an output."""
    forces = [name for name in r.names if name.endswith(".force")]
    largest = max(forces, key=lambda name: float(np.nanmax(r[name], initial=0.0)), default="")
    return f"max({largest})" if largest else f"max({usual_output(r)})"


def trust(shelf: Shelf, source: Source) -> dict[str, Any]:
    """How far the motion can be trusted, with the time until which a tighter run agrees."""
    return _said(shelf.motion(source, horizon=True))


def _said(r: Result) -> dict[str, Any]:
    excepted = [line for line in r.trust.doubts() if line.startswith("not to be trusted")]
    lines = [*excepted, *str(r.trust).splitlines()]
    return {"success": r.success, "message": r.message, "trust": lines, "limited": r.trust.excepts}


def sample(shelf: Shelf, source: Source, number: int) -> dict[str, Any]:
    """The motion of one mechanism of the last ensemble."""
    shelf.mechanism(source)
    e = shelf.studies.get("ensemble")
    if e is None:
        raise InputError("the model has changed since: compute the ensemble again")
    r = e.sample(int(number)).simulate(e.task.t_end, progress=True).whole()
    words = e.told(int(number))
    value = quantity(float(e[e.outputs[0]][int(number)]), e.unit(e.outputs[0]))
    return {
        "scene": scene_of([("", r)]),
        "words": f"Mechanism {number} of the ensemble: {e.outputs[0]} = {value}",
        "more": words,
    }
