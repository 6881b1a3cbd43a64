"""A mechanism of another program as the text of a model file: a comment of its source, tables as in the examples."""

from __future__ import annotations

from collections.abc import Mapping

from rattle.description.changes import NAMED, literal
from rattle.exchange.imported import Imported

NARROW = 100  # characters of a line from which on a table of points is written with a line for each


def text_of(imported: Imported) -> str:
    """TOML text; every number has all its digits.  What was assumed and left out stands in the comment on top."""
    document = imported.document
    blocks = ["\n".join(_comment(imported)), "\n".join(_heads(document))]
    for table, entries in document.items():
        if not isinstance(entries, Mapping):
            continue
        if table in NAMED:
            blocks += ["\n".join(_table(f"{table}.{name}", entry)) for name, entry in entries.items()]
        elif table == "ground":
            blocks.append("\n".join(_table("ground.points", entries["points"])))
        else:
            blocks.append("\n".join(_table(table, entries)))
    return "\n\n".join(blocks) + "\n"


def _comment(imported: Imported) -> list[str]:
    words = [imported.source]
    words += [f"assumed: {word}" for word in imported.assumed]
    words += [f"left out: {word}" for word in imported.left_out]
    return ["# " + "".join(c if c.isprintable() else " " for c in " ".join(word.split())) for word in words]


def _heads(document: Mapping[str, object]) -> list[str]:
    """The values that belong to no table."""
    return [f"{key} = {literal(value)}" for key, value in document.items() if not isinstance(value, Mapping)]


def _table(heading: str, entries: Mapping[str, object]) -> list[str]:
    lines = [f"[{heading}]"]
    for key, value in entries.items():
        line = f"{key} = {literal(value)}"
        if len(line) > NARROW and key == "points" and isinstance(value, Mapping):
            lines += [f"{key}.{name} = {literal(at)}" for name, at in value.items()]
        else:
            lines.append(line)
    return lines
