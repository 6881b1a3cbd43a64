"""What usual changes of parameters do to curves, over time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rattle.plots.curves import CURVES, MORE, axis_label, figure_of, new_axes, shade_after_horizon
from rattle.questions.sensitivity.effects import effects
from rattle.results.handy_units import handy_unit

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
    entries = effects(result)
    outputs = list(dict.fromkeys(effect.output for effect in entries))
    parameters = list(dict.fromkeys(effect.parameter for effect in entries))
    axes = new_axes(8.5, 1.2 + 2.4 * len(outputs), rows=len(outputs))
    for ax, output in zip(axes, outputs, strict=True):
        mine = [effect for effect in entries if effect.output == output]
        mine.sort(key=lambda effect: -effect.size)
        largest = max(effect.size for effect in mine)
        factor, unit = handy_unit(result.unit(output), largest)
        marker = "o" if len(result.t) < 3 else ""
        lines = []
        for effect in mine:
            n = parameters.index(effect.parameter)  # its colour in every panel
            dashes, colour = "-" if n < len(COLOURS) else "--", COLOURS[n % len(COLOURS)]
            curve = factor * effect.derivative * effect.change
            lines += ax.plot(result.t, curve, linestyle=dashes, color=colour, linewidth=0.9, marker=marker)
        ax.set_ylabel(axis_label(f"change of {output}", unit), parse_math=False)
        ax.margins(x=0.0 if len(result.t) > 2 else 0.05)
        shade_after_horizon(ax, result)
        legend = ax.legend(
            lines, [str(n) for n in range(len(lines))], loc="upper left", bbox_to_anchor=(1.01, 1.0),
            borderaxespad=0.0, frameon=False, fontsize=8,
        )  # fmt: skip
        for text, effect in zip(legend.get_texts(), mine, strict=True):
            text.set(text=f"{effect.parameter} by {effect.words}".replace("*", "·"), parse_math=False)
    if title := str(result.provenance.get("model", "")):
        axes[0].set_title(title, loc="left", fontsize=10, parse_math=False)
    axes[-1].set_xlabel("time [s]")
    figure = figure_of(axes[0])
    figure.align_ylabels()
    return figure
