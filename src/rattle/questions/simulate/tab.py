"""Forces of a motion in the studio."""

from __future__ import annotations

import numpy as np

from rattle.answers.blocks import Content, content, of_result, table, words
from rattle.results.contact_summary import contact_lines, joint_rows
from rattle.results.result import Result
from rattle.studio.shelf import Shelf, Source

NO_FORCE = "No joint carries a force over time; impacts without duration, if any, are under Events in Motion."


def tab(shelf: Shelf, source: Source) -> Content:
    """Forces of joints and drivers, their largest values, and those of pins with play."""
    r = shelf.motion(source)
    every = [name for name in r.geometry["joints"] if f"{name}.force" in r]
    joints = [name for name in every if np.any(r[f"{name}.force"])]
    links, dry = _pins(r, joints)
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
        *(of_result("What drives it", r, names) for names in _efforts(r)),
        table(head, rows, "Largest values, found within the steps of the run"),
        *(words(line) for line in contact_lines(r)),
    )


def _pins(r: Result, joints: list[str]) -> tuple[list[str], list[str]]:
    """Normal forces of pins that are held together, and of those that lift off or, in oil, touch the bush."""
    links = [f"{name}.normal" for name in joints if name in r.trust.pulled]
    others = [f"{name}.normal" for name in joints if name not in r.trust.pulled]
    return links, [name for name in others if name in r and np.any(r[name])]


def _efforts(r: Result) -> list[list[str]]:
    """Efforts of drivers, those of one unit together."""
    by_unit: dict[str, list[str]] = {}
    for name in r.names:
        if name.endswith((".effort", ".torque", ".thrust")):
            by_unit.setdefault(r.unit(name), []).append(name)
    return list(by_unit.values())
