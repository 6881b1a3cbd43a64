"""Lives of joints and links on an axis of hours, with their bands."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from rattle.errors import InputError
from rattle.plots.curves import BLACK, BLUE, ORANGE, legend_beside, new_figure, tidy
from rattle.questions.durability.bands import bands
from rattle.questions.durability.rows import TIRED, WORN

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.container import BarContainer
    from matplotlib.figure import Figure

    from rattle.questions.durability.compute import Durability

COLOURS = {WORN: BLUE, TIRED: ORANGE}
WIDTH, FRAME, BAR = 7.6, 1.1, 0.42  # [in] of the picture, around its bars, of each bar
LEFT = 2.0  # space beside the bands on either side, times their end
NEEDED = "hours needed"


def has_lives(d: Durability) -> bool:
    """True if something fails some time, so that there is a picture."""
    return any(0.0 < hours < math.inf for row in d.rows for _, hours, _ in row.lives)


def plot_lives(d: Durability) -> Figure:
    """A bar per life, the first failure above, and a line over its band from 10 to 90 %.  Raises InputError."""
    lives = [(row.name, what, bands(hours, factors)) for row in d.rows for what, hours, factors in row.lives
             if 0.0 < hours < math.inf]  # fmt: skip
    if not lives:
        raise InputError("nothing fails some time, so there is no picture of lives; print the answer instead")
    lives.sort(key=lambda life: life[2].middle)
    figure = new_figure(WIDTH, FRAME + BAR * len(lives))
    ax = tidy(figure.subplots())
    least = 10.0 ** math.floor(math.log10(min(band.early for _, _, band in lives) / LEFT))
    most = 10.0 ** math.ceil(math.log10(max(band.late for _, _, band in lives)))
    names: dict[str, Artist | BarContainer] = {}
    for place, (_, what, band) in enumerate(lives):
        drawn = ax.barh(place, band.middle - least, left=least, height=0.6, color=COLOURS[what], label=what)
        names.setdefault(what, drawn)
        scatter = ax.plot([band.early, band.late], [place, place], "|-", color=BLACK, linewidth=1.2, label="10 to 90 %")
        names.setdefault("band", scatter[0])
    if d.hours is not None:
        names["hours"] = ax.axvline(d.hours, color=BLACK, linestyle="--", linewidth=1.2, label=NEEDED)
    ax.set_xscale("log")
    ax.set_xlim(least, max(most, LEFT * (d.hours or 0.0)))
    ax.set_yticks(range(len(lives)), [name for name, _, _ in lives])
    ax.set_xlabel("life [h]")
    ax.invert_yaxis()
    legend_beside(ax, list(names.values()))
    return figure
