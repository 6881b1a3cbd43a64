"""Force and moment of a bearing over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle.plots.curves import BLACK, BLUE, ORANGE, axis_label, figure_of, new_axes, title_of
from rattle.results.handy_units import handy_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rattle.questions.bearing_moments.compute import BearingMoments


def plot_over_time(b: BearingMoments) -> Figure:
    """Components of force and moment in two panels, and their magnitude."""
    axes = new_axes(8.0, 5.4, rows=2)
    panels = (("force", "N", ("fx", "fy")), ("moment", "N*m", ("mx", "my")))
    for ax, (words, si, names) in zip(axes, panels, strict=True):
        parts = [getattr(b, name) for name in names]
        size = np.hypot(*parts)
        factor, unit = handy_unit(si, float(np.nanmax(size, initial=0.0)))
        for name, part, colour in zip(names, parts, (BLUE, ORANGE), strict=True):
            ax.plot(b.t, factor * part, color=colour, label=name)
        ax.plot(b.t, factor * size, color=BLACK, linewidth=0.8, linestyle=":", label="magnitude")
        ax.set_ylabel(axis_label(f"{words} of {b.joint}", unit))
        ax.margins(x=0.0)
        ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), fontsize=8, frameon=False)
    title_of(axes[0], b.result)
    axes[-1].set_xlabel("time [s]")
    return figure_of(axes[0])
