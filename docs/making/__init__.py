"""Pages made from the code: kinds, commands, names in Python, validation, scoreboard, live pages, gallery, map.

Each module returns Markdown texts by file name; pages in docs/ include them.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

MAKERS = (
    "kinds",
    "commands",
    "questions",
    "interface",
    "validation",
    "foreign",
    "scoreboard",
    "live",
    "gallery",
    "pictures",
    "potential",
    "surfaces",
    "developers",
    "citing",
)


def write_pages(folder: Path, makers: tuple[str, ...] = MAKERS) -> None:
    """Write all pages into a folder; unchanged files are not touched, so that builds are quick."""
    folder.mkdir(exist_ok=True)
    for maker in makers:
        for name, text in import_module(f"making.{maker}").pages(folder).items():
            path = folder / f"{name}.md"
            if not path.exists() or path.read_text(encoding="utf-8") != text:
                path.write_text(text, encoding="utf-8")
