"""The tabs whose content is computed: those of questions, and the report."""

from __future__ import annotations

from rattle.question import Tab, tabs
from rattle.value_types import Json

REPORT = Tab("report", "Report", 80)
ALL = tuple(sorted([*(tab for _, tab in tabs()), REPORT], key=lambda tab: (tab.place, tab.name)))
TABS = tuple(tab.name for tab in ALL)  # the names of their jobs


def forms() -> list[dict[str, Json]]:
    """What the page has to know of the tabs: names, titles, and the fields of their forms."""
    return [tab._asdict() | {"fields": [field._asdict() for field in tab.fields]} for tab in ALL]
