"""The table "Which analysis do I need?", from what questions declare of themselves."""

from __future__ import annotations

from pathlib import Path

from making.text import code, table
from making.tree import module_with

HEAD = ("You want to know", "Analysis", "Command", "Python")


def pages(folder: Path) -> dict[str, str]:
    """The table."""
    return {"questions": table(HEAD, rows()) + "\n"}


def rows() -> list[tuple[str, str, str, str]]:
    """A row for everything that somebody may want to know."""
    return [
        (wants, called, code(command), code(python))
        for asked in module_with("question", "asked_of").questions().values()
        for (wants, called), (command, python) in zip(asked.wants, asked.examples, strict=True)
    ]
