"""What is checked before a motion, in a report."""

from __future__ import annotations

from rattle.pages.report_html import Section, paragraph, table
from rattle.pages.report_study import Study
from rattle.questions.check.compute import Check


def section(s: Study) -> Section:
    """Mobility, loops, play and ranges of drivers."""
    check = s.answer("check", Check)
    if check is None:
        return s.left_out("Checks before the run", "check")
    words = {"free": "free coordinates", "loop": "closed loop", "play": "radial play", "driver": "range of the driver"}
    rows: dict[str, list[str]] = {}
    for line in str(check).splitlines()[1:]:
        what, colon, rest = line.partition(": ")
        if what != "parameter":  # these have a table of their own
            rows.setdefault(words.get(what, what) if colon else "assembly", []).append(rest if colon else line)
    left = "it moves as it is driven" if check.mobility == 0 else "free to move under the loads"
    lead = f"Degrees of freedom beside the drivers: {check.mobility} ({left})."
    return Section(
        "Checks before the run",
        paragraph(lead) + table(("what", "found"), [(what, "; ".join(texts)) for what, texts in rows.items()]),
    )


SECTIONS = ((10, section),)
