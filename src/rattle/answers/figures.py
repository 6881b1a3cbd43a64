"""Blocks as a picture of Matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from rattle.answers.blocks import Block
from rattle.errors import InputError
from rattle.plots.curves import CURVES, legend_beside, new_figure, tidy

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, HEIGHT = 7.0, 3.2  # of one block [in]
FEW_BARS = 5  # places on an axis of bars at least


def figure_of(blocks: Sequence[Block]) -> Figure:
    """Curves and bars, one below the other.  Raises InputError without any."""
    drawn = [block for block in blocks if block["kind"] in DRAWN]
    if not drawn:
        raise InputError("this answer has no curves and no bars to draw; print it instead")
    figure = new_figure(WIDTH, HEIGHT * len(drawn))
    for ax, block in zip(np.ravel(figure.subplots(len(drawn), 1, squeeze=False)), drawn, strict=True):
        tidy(ax).set_title(block["title"], loc="left", fontsize=10)
        DRAWN[block["kind"]](ax, block)
    return figure


def _curves(ax: Axes, block: Block) -> None:
    colours: list[str] = []
    named = []
    for k, line in enumerate(block["lines"]):
        like = line.get("like")
        colours.append(colours[like] if like is not None else CURVES[k % len(CURVES)])
        style = "--" if line.get("dash") else "-"
        drawn = ax.plot(line["x"], line["y"], style, color=colours[k], label=line["name"], linewidth=1.4)
        named += drawn if line["name"] else []
    if block.get("after") is not None:
        ax.axvspan(block["after"], ax.get_xlim()[1], color="0.9", zorder=0)
    ax.set(xlabel=block["x"], ylabel=block["y"])
    if named:
        legend_beside(ax, named)


def _bars(ax: Axes, block: Block) -> None:
    places = range(len(block["labels"]))  # two bars may have the same name
    ax.bar(places, block["values"], color=CURVES[0], width=0.6, tick_label=block["labels"])
    ax.set_ylabel(block["y"])
    beside = 0.5 * max(0, FEW_BARS - len(places))  # few bars are no wider than those of many
    ax.set_xlim(-0.5 - beside, len(places) - 0.5 + beside)


DRAWN = {"curves": _curves, "bars": _bars}
