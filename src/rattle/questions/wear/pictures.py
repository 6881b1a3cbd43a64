"""Worn surfaces: a polar map of pin and bush with their depths exaggerated; volume and depth over the cycles."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rattle.plots.curves import BLUE, GREY, RED, axis_label, new_figure, tidy
from rattle.results.chosen_units import chosen
from rattle.results.handy_units import handy_unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.questions.wear.worn import Profile, Worn

Array = NDArray[np.float64]
SHARE = 0.28  # of the radius of the picture, for the largest depth
BAND = {"bush": 1.0, "pin": 0.62}  # radii of the round surfaces in the picture
ROUNDING = 1e-9  # [-] by which a round number may exceed what it is rounded down from
STEPS = (1.0, 2.0, 5.0)


def plot_worn(worn: Worn, joint: str) -> Figure:
    """The map of one joint beside the history of all."""
    figure = new_figure(10.4, 5.2)
    grid = figure.add_gridspec(2, 2, width_ratios=(1.15, 1.0))
    _map(figure.add_subplot(grid[:, 0]), worn.profile(joint), joint, worn.radius(joint))
    top, below = tidy(figure.add_subplot(grid[0, 1])), tidy(figure.add_subplot(grid[1, 1]))
    _history(top, worn, "volume", "m^3")
    _history(below, worn, "depth", "m")
    top.tick_params(labelbottom=False)
    below.set_xlabel("cycles")
    top.set_title(f"after {worn.cycles:.6g} cycles", loc="left", fontsize=11)
    return figure


def factor_of(deepest: float) -> float:
    """How many times deeper depths are drawn, for a picture whose unit is the radius of the bush: 1, 2 or 5 times 10^n.

    deepest: [radii].
    """
    if not deepest > 0.0:
        return 1.0
    wished = SHARE / deepest
    decade = 10.0 ** math.floor(math.log10(wished))
    return max((step * decade for step in STEPS if step * decade <= wished), default=decade)


def _map(ax: Axes, profile: Profile, joint: str, radius_of_bush: float) -> None:
    """Both surfaces around their centres, each in the frame of its body; radius of the bush [m]."""
    deepest = max(profile.bush.deepest, profile.pin.deepest)
    size, unit = handy_unit("m", deepest)
    factor = factor_of(deepest / radius_of_bush)
    scale = factor / radius_of_bush
    for name, side, colour in (("bush", profile.bush, BLUE), ("pin", profile.pin, RED)):
        radius, angle = BAND[name], np.append(side.angle, side.angle[0] + 2.0 * math.pi)
        depth = np.append(side.depth, side.depth[0]) * scale
        out = radius + (depth if name == "bush" else -depth)
        ax.plot(radius * np.cos(angle), radius * np.sin(angle), color=GREY, linewidth=0.8)
        ax.fill(
            np.append(out * np.cos(angle), (radius * np.cos(angle))[::-1]),
            np.append(out * np.sin(angle), (radius * np.sin(angle))[::-1]),
            color=colour, alpha=0.35, linewidth=0.0,
        )  # fmt: skip
        ax.plot(out * np.cos(angle), out * np.sin(angle), color=colour, linewidth=1.4)
        if side.deepest > 0.0:
            at = side.angle[side.depth.argmax()]
            far = radius + scale * side.deepest + 0.05 if name == "bush" else 0.92 * radius
            outwards = (math.cos(at) > 0.0) == (name == "bush")
            text = f"{name}: {side.deepest * size:.3g} {unit}"
            ax.annotate(
                text, (radius * math.cos(at), radius * math.sin(at)), (far * math.cos(at), far * math.sin(at)),
                ha="left" if outwards else "right", va="center", fontsize=9, color=colour,
            )  # fmt: skip
    for degrees in range(0, 360, 30):
        at, edge = math.radians(degrees), 0.86
        ax.text(
            edge * math.cos(at), edge * math.sin(at), f"{degrees}°", ha="center", va="center", fontsize=8, color=GREY
        )
    limit = 1.0 + SHARE + 0.24
    ax.set(xlim=(-limit, limit), ylim=(-limit - 0.2, limit), aspect="equal")
    ax.set_axis_off()
    ax.set_title(f"{joint}: worn surfaces, each in the frame of its body", loc="left", fontsize=11)
    if deepest > 0.0:
        length = _round(deepest)
        bar = length * scale
        ax.plot([-limit, -limit + bar], [-limit, -limit], color="black", linewidth=2.0, solid_capstyle="butt")
        ax.text(-limit + bar + 0.05, -limit, f"depth {length * size:.3g} {unit}", va="center", fontsize=8)
        caption = f"depths drawn {factor:g} times deeper than radii; the pin drawn smaller"
        ax.text(-limit, -limit - 0.1, caption, va="top", fontsize=8, color=GREY)


def _round(size: float) -> float:
    """1, 2 or 5 times a power of ten, at most `size`."""
    decade = 10.0 ** math.floor(math.log10(size))
    return max(step * decade for step in STEPS if step * decade <= size * (1.0 + ROUNDING))


def _history(ax: Axes, worn: Worn, what: str, unit: str) -> None:
    """Volume or depth of every side over the cycles."""
    columns = worn.columns
    names = [name for name in columns if name.endswith(f".{what}") and columns[name][-1] > 0.0]
    largest = max((float(columns[name][-1]) for name in names), default=0.0)
    factor, shown = (chosen(unit) or (1e9, "mm^3")) if unit == "m^3" else handy_unit(unit, largest or 1e-6)
    for name in names:
        colour = BLUE if ".bush." in name else RED
        several = len({column.split(".")[0] for column in names}) > 1
        ax.plot(
            columns["cycle"], factor * columns[name], marker=".", markersize=4, linewidth=1.3,
            color=None if several else colour, label=name.removesuffix(f".{what}").replace(".", ", "),
        )  # fmt: skip
    ax.set_ylabel(axis_label(what, shown))
    ax.set_ylim(bottom=0.0)
    ax.set_xlim(left=0.0)
    if names:
        ax.legend(frameon=False, fontsize=9)
