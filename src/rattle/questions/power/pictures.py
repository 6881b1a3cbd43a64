"""Pictures of power: where the energy of a cycle goes, and the powers of every body over time."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.plots.bulk import short
from rattle.plots.curves import BLACK, BLUE, CURVES, GREY, MORE, ORANGE, axis_label, figure_of, new_axes, tidy, title_of
from rattle.plots.scene import BODIES
from rattle.questions.power.flows import HALF, UNSEEN, Link, Node, Sheet, graph_of, lay_out
from rattle.results.handy_units import handy_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.questions.power.compute import Power

Array = NDArray[np.float64]
INSTANTS = 401  # of curves
SHADES = {"source": BLUE, "sink": ORANGE, "kept": GREY}
BACK = "#D5D5D5"  # what comes back within the cycle
TO_AND_FRO = "\N{RIGHTWARDS ARROW OVER LEFTWARDS ARROW}"  # before an energy that goes back and forth
LINE = 13.0  # height that a name on a band takes [points]
TWO = 1.8  # height of two lines of it over one


class Spacing(NamedTuple):
    """Distances [inches] from body to body at most and at least, of a body and the room below it, and the width."""

    across: float
    closest: float
    line: float
    width: float  # above which bodies stand closer


OWN = Spacing(1.8, 1.8, 1.1, 7.5)


def plot_cycle(p: Power, spacing: Spacing = OWN) -> Figure:
    """Where energy goes from t0 to t1: sources on the left, bodies, then losses, loads and what is stored.

    The width of a coloured band is the net energy [J], that of the grey one beside it what goes back and forth; both
    stand there as numbers.
    """
    nodes, links = graph_of(p)
    if not links:
        (ax,) = new_axes(7.5, 3.0)
        ax.text(0.5, 0.5, "no energy is exchanged in this time", ha="center", va="center", color=GREY)
        return _finished(ax, p)
    sheet = lay_out(nodes, links)
    high = float(np.clip(spacing.line * (sheet.lines + 1.1), 3.3 * spacing.line, 10.0))
    across = float(np.clip(spacing.width / (sheet.columns + 1.0), spacing.closest, spacing.across))
    (ax,) = new_axes(max(spacing.width, across * (sheet.columns + 1.0)), high)
    point = (sheet.high - sheet.low) / (72.0 * (high - 0.6))  # height on the sheet, about
    for link, ends in zip(sheet.links, sheet.ends, strict=True):
        _band(ax, link, ends, sheet)
    for k, node in enumerate(sheet.nodes):
        if node.side != "way":
            _node(ax, node, k, sheet, point)
    told: list[tuple[float, float, float]] = []
    for link, ends in zip(sheet.links, sheet.ends, strict=True):
        if link.name:
            told.append(_tell(ax, link, ends, sheet.scale, point, told))
    ax.set(xlim=(-0.75, sheet.columns - 1 + 0.95), ylim=(sheet.low - 0.04, sheet.high + 0.04))
    return _finished(ax, p)


def _finished(ax: Axes, p: Power) -> Figure:
    ax.set_axis_off()
    title_of(ax, p.result)
    caption = (
        f"energy from t = {p.t0:.4g} to {p.t1:.4g} s; grey and {TO_AND_FRO}: goes back and forth, colour: what is left"
    )
    ax.text(0.0, -0.02, caption, transform=ax.transAxes, fontsize=8, color=GREY, va="top")
    return figure_of(ax)


def _ribbon(x0: float, x1: float, y0: float, y1: float, width: float) -> Array:
    """Outline (n, 2) of a band of constant height from (x0, y0) to (x1, y1), the middles of its ends."""
    s = np.linspace(0.0, 1.0, 40)
    x, y = x0 + (x1 - x0) * s, y0 + (y1 - y0) * s * s * (3.0 - 2.0 * s)
    return np.column_stack([np.append(x, x[::-1]), np.append(y + 0.5 * width, (y - 0.5 * width)[::-1])])


def _band(ax: Axes, link: Link, ends: Array, sheet: Sheet) -> None:
    """Draw a link: its net energy in the colour of what it comes from, and beside it what comes back."""
    from matplotlib.patches import Polygon

    (x0, y0), (x1, y1) = ends
    whole = sheet.scale * (link.net + link.back)
    for part, at, colour in ((link.net, 0.5, link.colour), (link.back, -0.5, BACK)):
        width = sheet.scale * part
        shift = at * (whole - width)
        outline = _ribbon(x0, x1, y0 + shift, y1 + shift, width)
        ax.add_patch(Polygon(outline, facecolor=colour, alpha=0.55 if colour != BACK else 0.9, linewidth=0, zorder=1))
    if sheet.nodes[link.end].side != "way" and sheet.scale * link.net > 0.03:  # its direction
        x, y = (
            x0 + 0.2 * (x1 - x0),
            y0 + 0.104 * (y1 - y0) + 0.5 * (whole - sheet.scale * link.net),
        )  # as _ribbon at 0.2
        marker = ">" if x1 > x0 else "<"
        ax.plot([x], [y], marker, color="white", markersize=4, zorder=2)


def _node(ax: Axes, node: Node, k: int, sheet: Sheet, point: float) -> None:
    """Draw a node with its name; sources and sinks with their energies."""
    from matplotlib.patches import Rectangle

    x, y, height = sheet.x[k], sheet.y[k], max(sheet.heights[k], 0.004)
    colour = BODIES[node.body % len(BODIES)] if node.body >= 0 else SHADES[node.side]
    ax.add_patch(Rectangle((x - HALF, y - 0.5 * height), 2 * HALF, height, color=colour, zorder=3))
    if node.body >= 0:
        ax.annotate(
            node.name, (x, y + 0.5 * height), (0, 2), textcoords="offset points", ha="center", va="bottom",
            fontsize=9.5, color=BLACK, zorder=4, parse_math=False,
        )  # fmt: skip
        return
    left = node.side == "source"
    words = [node.name, *_told(node.net, node.back)]
    text = ("\n" if height > len(words) * LINE * point else "  ").join(words)
    ax.annotate(
        text, (x + (-0.06 if left else 0.06), y), ha="right" if left else "left", va="center", fontsize=9, color=BLACK,
        parse_math=False,
    )  # fmt: skip


def _tell(
    ax: Axes, link: Link, ends: Array, scale: float, point: float, told: list[tuple[float, float, float]]
) -> tuple[float, float, float]:
    """The name of a joint with its energies, on its band or below a thin one, where no other one stands.

    point: height of a point on the sheet; told: places and heights of others.  Returns its own.
    """
    from matplotlib.patheffects import withStroke

    x, middle = ends.mean(axis=0)
    half = 0.5 * scale * (link.net + link.back)
    first, *more = _told(link.net, link.back)
    line = LINE * point
    two = bool(more) and half > line
    high = TWO * line if two else line
    aside = np.array([0.0, -1.0, 1.0]) * high
    places = middle + aside if 2.0 * half > line else middle - half - 0.6 * line + aside
    free = [
        y for y in places if all(abs(x - at) > 0.9 or abs(y - other) >= (high + its) / 2 for at, other, its in told)
    ]
    y = float((free or places)[0])
    ax.text(
        x, y, ("\n" if two else "  ").join([f"{link.name}  {first}", *more]), ha="center", va="center", fontsize=8,
        color=BLACK, zorder=5, path_effects=[withStroke(linewidth=2, foreground="white", alpha=0.6)], parse_math=False,
    )  # fmt: skip
    return float(x), y, high


def _told(net: float, back: float) -> list[str]:
    """A net energy and what goes back and forth, without what is too thin to see beside the other."""
    words = [_energy(net)] if net > UNSEEN * back else []
    return [*words, f"{TO_AND_FRO} {_energy(back)}"] if back > UNSEEN * net else words


def _energy(value: float) -> str:
    factor, unit = handy_unit("J", value)
    return f"{short(factor * value)} {unit}"


def plot_powers(p: Power) -> Figure:
    """Power of every port over time, one panel for each body; positive into the body."""
    t = np.linspace(p.t0, p.t1, INSTANTS)
    powers = p.powers(t)
    table = p.names
    bodies = list(dict.fromkeys(table["body"]))
    axes = new_axes(8.0, 1.0 + 2.1 * max(len(bodies), 1), rows=max(len(bodies), 1))
    largest = float(np.abs(powers).max(initial=0.0))
    factor, unit = handy_unit("W", largest)
    colours = (*CURVES, *MORE)
    for ax, body in zip(axes, bodies, strict=False):
        mine = [k for k, owner in enumerate(table["body"]) if owner == body]
        shown = [k for k in mine if np.abs(powers[:, k]).max() > 1e-9 * largest]
        for n, k in enumerate(shown):
            ax.plot(t, factor * powers[:, k], color=colours[n % len(colours)], label=table["element"][k])
        ax.plot(t, factor * powers[:, mine].sum(axis=1), color=GREY, linestyle=":", label="kinetic energy", zorder=1)
        ax.axhline(0.0, color=BLACK, linewidth=0.6, zorder=0)
        ax.set_ylabel(axis_label(body, unit))
        ax.margins(x=0.0)
        tidy(ax).legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), fontsize=8, frameon=False)
    title_of(axes[0], p.result)
    axes[-1].set_xlabel("time [s]")
    return figure_of(axes[0])
