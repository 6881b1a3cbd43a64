"""Blocks as HTML, for notebooks and reports."""

from __future__ import annotations

from html import escape

from rattle.answers.blocks import Block, drawing
from rattle.results.display import grid, printed


def html_of(block: Block) -> str:
    """A block as HTML that needs nothing else; all texts are escaped."""
    kind = block["kind"]
    if kind == "words":
        return f"<p>{escape(printed(block['text']))}</p>"
    if kind == "table":
        caption = f"<table><caption>{escape(printed(block['caption']))}</caption>" if block["caption"] else "<table>"
        return grid(block["head"], block["rows"]).replace("<table>", caption, 1)
    if kind != "svg":
        from rattle.answers.figures import figure_of

        block = drawing(figure_of((block,)), block["title"])
    caption = f"<figcaption>{escape(printed(block['caption']))}</figcaption>" if block["caption"] else ""
    return f"<figure>{block['svg']}{caption}</figure>"
