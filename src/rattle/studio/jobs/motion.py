"""Motion for the viewer, how far it can be trusted, and its forces."""

from __future__ import annotations

from typing import Any

import numpy as np

from rattle.answers.blocks import Content, content, of_result, table, words
from rattle.pages.scene import scene_of
from rattle.results.contact_summary import contact_lines, joint_rows
from rattle.results.result import Result
from rattle.studio.jobs.live import shape_of
from rattle.studio.shelf import Shelf, Source

MOVES = 1e-6  # range of a position beyond which a body moves [m, rad]

NO_FORCE = "No joint carries a force over time; impacts without duration, if any, are under Events in Motion."


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


def forces(shelf: Shelf, source: Source) -> Content:
    """Forces of joints and drivers, their largest values, and those of pins with play."""
    r = shelf.motion(source)
    every = [name for name in r.geometry["joints"] if f"{name}.force" in r]
    joints = [name for name in every if np.any(r[f"{name}.force"])]
    links = [f"{name}.normal" for name in joints if name in r.trust.pulled]
    dry = [f"{name}.normal" for name in joints if f"{name}.normal" in r and np.any(r[f"{name}.normal"])]
    dry = [name for name in dry if name not in links]  # pins that lift off, and those in oil that touch the bush
    efforts = [name for name in r.names if name.endswith((".effort", ".torque", ".thrust"))]
    by_unit: dict[str, list[str]] = {}
    for name in efforts:
        by_unit.setdefault(r.unit(name), []).append(name)
    head, rows = joint_rows(r)
    return content(
        f"{len(r.t)} instants to t = {r.t[-1]:.4g} s" if len(r.t) else "no instant",
        words("" if r.success else f"The run stopped early: {r.message}", "care"),
        words("" if joints or not every else NO_FORCE),
        of_result(
            "Forces of the joints", r, [f"{name}.force" for name in joints], {f"{name}.force": name for name in joints}
        ),
        of_result("Forces between pin and bush, held together: below zero the bush would have to pull", r, links),
        of_result("Forces between pin and bush where they touch: zero while the pin is free", r, dry),
        *(of_result("What drives it", r, names) for names in by_unit.values()),
        table(head, rows, "Largest values, found within the steps of the run"),
        *(words(line) for line in contact_lines(r)),
    )
