"""Blocks: what an answer shows, as plain data that goes to a terminal, a notebook, a report, a page or a picture.

    words     text, tone
    table     head, rows, caption
    curves    title, x, y, lines (name, x, y and style of each), after
    bars      title, y, labels, values
    svg       svg, caption

A content is {"told": one line, "blocks": [...]}: what a tab of the studio shows, by `studio/page/sheet.js`.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from rattle.errors import InputError
from rattle.plots.curves import axis_label
from rattle.results.handy_units import QUANTITY, handy_unit, units_of_result
from rattle.results.result import Result
from rattle.results.within_steps import bursts, cut, largest, shown_curve, summit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Block = dict[str, Any]
Content = dict[str, Any]
MOST_LINES = 8  # of one figure; more could not be told apart


def content(told: str, *blocks: Block | None) -> Content:
    """The content of a tab; told: its state in one line."""
    return {"told": told, "blocks": [block for block in blocks if block is not None]}


def words(text: str, tone: str = "") -> Block | None:
    """Plain words; tone "care" for what has to be noticed; None for no words."""
    return {"kind": "words", "text": text, "tone": tone} if text else None


def table(head: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "") -> Block | None:
    """A table of texts; None without rows."""
    listed = [[str(cell) for cell in row] for row in rows]
    if wrong := next((row for row in listed if len(row) != len(head)), None):
        raise InputError(f"table {caption or ', '.join(head)}: the head has {len(head)} cells, a row has {len(wrong)}")
    return {"kind": "table", "head": list(head), "rows": listed, "caption": caption} if listed else None


def drawing(figure: Figure, caption: str = "") -> Block:
    """A figure as a drawing."""
    from matplotlib import rc_context

    from rattle.plots.figure import TEXT, with_own_names

    out = io.StringIO()
    with rc_context(TEXT):
        figure.savefig(out, format="svg", metadata={"Date": None}, transparent=True)
    text = out.getvalue()
    return {"kind": "svg", "svg": with_own_names(text[text.index("<svg") :]), "caption": caption}


def line(name: str, x: ArrayLike, y: ArrayLike, **style: Any) -> Block:
    """A curve (n,) over x (n,), in the units of its axes."""
    across, up = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    if across.shape != up.shape or across.ndim != 1:
        raise InputError(f"curve {name}: x has the shape {across.shape}, y {up.shape}; both need one dimension")
    return {"name": name, "x": across, "y": up, **style}


def curves(title: str, x: str, y: str, lines: Sequence[Block], **more: Any) -> Block | None:
    """Curves in one figure; x, y: labels of the axes with units; None without curves."""
    return {"kind": "curves", "title": title, "x": x, "y": y, "lines": list(lines), **more} if lines else None


def of_result(
    title: str, result: Result, names: Sequence[str], labels: Mapping[str, str] | None = None
) -> Block | None:
    """Curves of a result over time, those with the largest values first, in one handy unit; None without curves."""
    sized = [(largest(result, name), name) for name in names]
    if not sized or not len(result.t):
        return None
    kept = [name for _, name in sorted(sized, key=lambda pair: -pair[0])[:MOST_LINES]]
    kept.sort(key=list(names).index)
    unit = result.unit(kept[0])
    factor, shown = handy_unit(unit, max(size for size, _ in sized), units_of_result(result.provenance))
    lines = [_line_of(result, name, (labels or {}).get(name, name), factor) for name in kept]
    horizon = result.trust.horizon
    after = horizon if horizon is not None and horizon < result.t[-1] else None
    more = f"  ({len(names) - len(kept)} smaller ones are left out)" if len(names) > len(kept) else ""
    return curves(title + more, "time [s]", axis_label(QUANTITY.get(unit, "value"), shown), lines, after=after)


def _line_of(result: Result, name: str, label: str, factor: float) -> Block:
    """A curve of a result with what it reaches between two outputs: `top` (t, y), `short` contacts [(t, y)]."""
    top = summit(result, name)
    short = [(burst.t, factor * burst.y) for burst in bursts(result, name)]
    if told := cut(result, name):
        label = f"{label} ({told})"
    return line(label, result.t, factor * shown_curve(result, name), top=top and (top.t, factor * top.y), short=short)


def bars(title: str, y: str, labels: Sequence[str], values: Sequence[float], told: bool = True) -> Block | None:
    """Bars with names; None without any.  told: False where a table says their numbers already."""
    chart = {
        "kind": "bars",
        "title": title,
        "y": y,
        "labels": list(labels),
        "values": [float(value) for value in values],
        "told": told,
    }
    return chart if labels else None
