"""Pieces of a report in HTML: sections, tables, figures, paragraphs; all texts are escaped here."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape

from matplotlib.figure import Figure

from rattle.errors import WrongType
from rattle.plots.figure import Page
from rattle.results.display import grid, printed, quantity
from rattle.results.handy_units import handy_unit

SHORT, LINE = 16, 80  # lines up to which a table is printed in one piece, a quarter of a page; characters of a line
NARROW, GUTTER = 58, 2  # characters of a row of a table that takes half a page, and between two columns


@dataclass(frozen=True)
class Section:
    """A part of a report: its heading, and what stands below it; without a body it is left out, for a reason."""

    title: str
    body: str = ""  # HTML
    reason: str = ""  # why it is left out, in words

    @property
    def anchor(self) -> str:
        """Its name in links."""
        return re.sub(r"[^a-z]+", "-", self.title.lower()).strip("-")


def handy(value: float, unit: str, digits: int = 4) -> str:
    """A value [SI] as text in a handy unit, as it is printed."""
    text = printed(quantity(value, unit, digits, handy_unit(unit, abs(value))))
    return text.replace("-", "\N{MINUS SIGN}", 1) if text.startswith("-") else text


def paragraph(text: str, kind: str = "") -> str:
    """A paragraph; kind: a class of the style sheet."""
    mark = f' class="{kind}"' if kind else ""
    return f"<p{mark}>{escape(printed(text))}</p>"


def listed(items: Iterable[str], kind: str = "") -> str:
    """A list with a point for each text; "" without any."""
    points = "".join(f"<li>{escape(printed(item))}</li>" for item in items)
    return f'<ul class="{kind}">{points}</ul>' if points else ""


def sentence(text: str) -> str:
    """With a full stop."""
    text = text.strip()
    return text if not text or text[-1] in ".!?:" else f"{text}."


def table(head: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "") -> str:
    """A table that may be wider than the page on a phone; columns without any entry are left out; "" without rows.

    A short one is printed in one piece, of a long one the head comes again on every page.
    """
    every = [list(row) for row in rows]
    if not every:
        return ""
    keep = [k for k in range(len(head)) if any(row[k] for row in every)]
    names, kept = [head[k] for k in keep], [[row[k] for k in keep] for row in every]
    inner = grid(names, kept)
    if caption:
        inner = inner.replace("<table>", f"<table><caption>{escape(printed(caption))}</caption>", 1)
    return f'<div class="{_shape(names, kept)}">{inner}</div>'


def _shape(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Classes of a table: whether it is printed in one piece, and whether two fit side by side."""
    widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
    narrow = sum(widths) + GUTTER * len(widths) <= NARROW
    lines = sum(-(-sum(map(len, row)) // LINE) for row in rows)
    return f"wide{' short' if lines <= SHORT else ''}{' narrow' if narrow else ''}"


def figure(picture: Figure, caption: str) -> str:
    """A picture with its caption; figures are numbered where the page is put together."""
    if not isinstance(picture, Page):
        raise WrongType("a picture of a page is one of our own figures")
    natural = f'style="--natural: {picture.get_figwidth():.4g}in"'
    return f"<figure {natural}>{picture.to_page(caption)}<figcaption>{escape(printed(caption))}</figcaption></figure>"


def gallery(figures: Sequence[str]) -> str:
    """Figures in two columns, one below the other in each; in one where there is no room for two."""
    return f'<div class="gallery">{"".join(figures)}</div>' if any(figures) else ""


def placed(tables: Sequence[str]) -> str:
    """Wide tables one below the other, narrow ones together in two columns, in their order."""
    present = filter(None, tables)
    groups = itertools.groupby(
        present, lambda text: text.startswith(('<div class="wide narrow', '<div class="wide short n'))
    )
    return "".join(gallery(list(of)) if narrow else "".join(of) for narrow, of in groups)


def abreast(parts: Sequence[str]) -> str:
    """Tables and lists side by side where there is room."""
    return f'<div class="abreast">{"".join(parts)}</div>' if any(parts) else ""


def count(n: int, single: str, many: str = "") -> str:
    """ "1 joint", "2 joints", "no joint"."""
    return f"{n or 'no'} {single if n < 2 else many or single + 's'}"


def enumerated(words: Sequence[str]) -> str:
    """ "a, b and c"."""
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
