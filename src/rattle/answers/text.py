"""Blocks as text for a terminal."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from rattle.answers.blocks import Block
from rattle.results.display import in_columns

DIGITS = 5
_NUMBER = re.compile(r"[-+]?[\d.]+(e[-+]?\d+)?( |$)")


def text_of(block: Block) -> str:
    """A block as lines of text; "" for a drawing without a caption."""
    return RENDERERS[block["kind"]](block)


def columns(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table with columns as wide as they must be; those that hold numbers alone stand on the right."""
    right = [k for k in range(len(head)) if rows and all(_NUMBER.match(row[k]) for row in rows if row[k])]
    return "\n".join(in_columns([head, *rows], right))


def _words(block: Block) -> str:
    return str(block["text"])


def _table(block: Block) -> str:
    return "\n".join(filter(None, (block["caption"], columns(block["head"], block["rows"]))))


def _curves(block: Block) -> str:
    """The range of every curve, and where its ends are."""
    rows = []
    for line in block["lines"]:
        x, y = np.asarray(line["x"]), np.asarray(line["y"])
        if not line["name"] or not np.isfinite(y).any():
            continue
        ends = [(y[k], x[k]) for k in (np.nanargmin(y), np.nanargmax(y))]
        rows.append([line["name"], *(f"{number:.{DIGITS}g}" for end in ends for number in end)])
    head = ("", "least", f"at {block['x']}", "greatest", f"at {block['x']}")
    return f"{block['title']}, {block['y']}\n{columns(head, rows)}" if rows else ""


def _bars(block: Block) -> str:
    if not block["told"]:
        return ""
    rows = [(label, f"{value:.{DIGITS}g}") for label, value in zip(block["labels"], block["values"], strict=True)]
    return f"{block['title']}\n{columns(('', block['y']), rows)}"


def _drawing(block: Block) -> str:
    return str(block["caption"])


RENDERERS = {"words": _words, "table": _table, "curves": _curves, "bars": _bars, "svg": _drawing}
