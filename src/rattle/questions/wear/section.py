"""What a model says about wear, in a report."""

from __future__ import annotations

import math

from rattle.pages.report_html import Section, handy, paragraph, table
from rattle.pages.report_study import Study


def section(s: Study) -> Section:
    """What the model says about wear; the depths over many cycles are a study of their own."""
    rows = []
    for name, joint in s.m.model.joints.items():
        wear = joint.wear
        if wear is None:
            continue
        deepest = [handy(max(side), "m") for side in wear.profile] if wear.profile is not None else ["new", "new"]
        cycle = handy(wear.cycle, "s") if math.isfinite(wear.cycle) else "one turn of the driver"
        rows.append(
            (
                name, f"{1e9 * wear.bush:.3g} mm³/(N·m)", f"{1e9 * wear.pin:.3g} mm³/(N·m)", *deepest,
                handy(wear.wall, "m") if math.isfinite(wear.wall) else "", f"{wear.cycles:g} of {cycle}",
            )
        )  # fmt: skip
    if not rows:
        return Section("Wear", "", "no joint wears")
    head = (
        "joint",
        "wear of bush",
        "wear of pin",
        "bush worn by",
        "pin worn by",
        "worn through at",
        "cycles of a study",
    )
    lead = "This report is of the mechanism as it is now. The wear of many cycles is a study of its own (rattle wear)."
    return Section("Wear", paragraph(lead) + table(head, rows))


SECTIONS = ((60, section),)
