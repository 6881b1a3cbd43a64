"""What usual changes of parameters do to curves, over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle.analyses.sensitivity.effects import effects
from rattle.plots.curves import CURVES, MORE, axis_label, handy_unit, new_axes, shade_after_horizon

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rattle.results.result import Result

COLOURS = (*CURVES, *MORE)


def plot_effects(result: Result) -> Figure:
    """A panel for each output: its change by a usual change of each parameter, over time [s].

    The changes are the parameters' tolerances, or 1 % of them; effects are derivative times change, so that
    parameters of all units are compared in the unit of the output.  Those with the largest effect come first.
    Raises ValueError for a result without sensitivities.
    """
    found = effects(result)
    outputs = list(dict.fromkeys(one.output for one in found))
    axes = new_axes(8.5, 1.2 + 2.4 * len(outputs), rows=len(outputs))
    for ax, output in zip(axes, outputs, strict=True):
        mine = [one for one in found if one.output == output]
        mine.sort(key=lambda one: -float(np.abs(one.derivative).max(initial=0.0)) * one.change)
        largest = max(float(np.abs(one.derivative).max(initial=0.0)) * one.change for one in mine)
        factor, unit = handy_unit(result.unit(output), largest)
        style = {"marker": "o", "markersize": 4.0} if len(result.t) < 3 else {}
        for n, one in enumerate(mine):
            label = f"{one.parameter} by {one.words}"
            colour, dashes = COLOURS[n % len(COLOURS)], "-" if n < len(COLOURS) else "--"
            ax.plot(result.t, factor * one.derivative * one.change, dashes, color=colour, lw=0.9, label=label, **style)
        ax.set_ylabel(axis_label(f"change of {output}", unit), parse_math=False)
        ax.margins(x=0.0 if len(result.t) > 2 else 0.05)
        shade_after_horizon(ax, result)
        ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), borderaxespad=0.0, frameon=False, fontsize=8)
    if title := str(result.provenance.get("model", "")):
        axes[0].set_title(title, loc="left", fontsize=10, parse_math=False)
    axes[-1].set_xlabel("time [s]")
    return axes[0].get_figure(root=True)  # type: ignore[return-value]
