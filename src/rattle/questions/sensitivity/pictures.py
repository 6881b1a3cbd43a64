"""What usual changes of parameters do to curves, over time, and to numbers of a whole run."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rattle.plots.curves import (
    CURVES,
    MORE,
    axis_label,
    figure_of,
    new_figure,
    shade_after_horizon,
    tidy,
)
from rattle.questions.sensitivity.effects import Effect, effects
from rattle.results.handy_units import handy_unit

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.results.result import Result

COLOURS = (*CURVES, *MORE)
CURVE, BAR = 2.4, 0.32  # heights of a panel over time, and of a bar [inches]


def plot_effects(result: Result) -> Figure:
    """A panel for each output: its change by a usual change of each parameter, over time [s]; of a number bars.

    The changes are the parameters' tolerances, or 1 % of them; effects are derivative times change, so that
    parameters of all units are compared in the unit of the output.  Those with the largest effect come first.
    Raises ValueError for a result without sensitivities.
    """
    entries = effects(result)
    groups = [[e for e in entries if e.output == output] for output in dict.fromkeys(e.output for e in entries)]
    parameters = list(dict.fromkeys(effect.parameter for effect in entries))
    axes = _panels(groups)
    for ax, mine in zip(axes, groups, strict=True):
        mine.sort(key=lambda effect: -effect.size)
        colours = [_colour(parameters.index(effect.parameter)) for effect in mine]
        if mine[0].of_whole_run:
            _draw_bars(ax, mine, colours)
        else:
            _draw_curves(ax, result, mine, colours)
    if title := str(result.provenance.get("model", "")):
        axes[0].set_title(title, loc="left", fontsize=10, parse_math=False)
    figure = figure_of(axes[0])
    figure.align_ylabels([ax for ax, mine in zip(axes, groups, strict=True) if not mine[0].of_whole_run])
    return figure


def _colour(n: int) -> tuple[str, str]:
    """Line style and colour of a parameter in every panel."""
    return "-" if n < len(COLOURS) else "--", COLOURS[n % len(COLOURS)]


def _panels(groups: Sequence[Sequence[Effect]]) -> list[Axes]:
    """An axis for each output; those over time share theirs."""
    heights = [0.9 + BAR * len(mine) if mine[0].of_whole_run else CURVE for mine in groups]
    figure = new_figure(8.5, 1.2 + sum(heights))
    grid = figure.add_gridspec(len(groups), 1, height_ratios=heights)
    axes: list[Axes] = []
    over_time: list[Axes] = []
    for row, mine in enumerate(groups):
        shared = over_time[0] if over_time and not mine[0].of_whole_run else None
        axes.append(tidy(figure.add_subplot(grid[row], sharex=shared)))
        if not mine[0].of_whole_run:
            over_time.append(axes[-1])
    for ax in over_time[:-1]:
        ax.tick_params(labelbottom=False)
    if over_time:
        over_time[-1].set_xlabel("time [s]")
    return axes


def _draw_bars(ax: Axes, mine: Sequence[Effect], colours: Sequence[tuple[str, str]]) -> None:
    factor, unit = handy_unit(mine[0].unit, mine[0].size)
    changes = [factor * float(effect.derivative[effect.largest]) * effect.change for effect in mine]
    ax.barh(range(len(mine)), changes, color=[colour for _, colour in colours], height=0.6)
    ax.set_yticks(range(len(mine)), [_words(effect) for effect in mine], fontsize=8, parse_math=False)
    ax.invert_yaxis()
    ax.grid(False, axis="y")
    ax.axvline(0.0, color="black", linewidth=0.6)
    ax.set_xlabel(axis_label(f"change of {mine[0].output}", unit), parse_math=False)


def _draw_curves(ax: Axes, result: Result, mine: Sequence[Effect], colours: Sequence[tuple[str, str]]) -> None:
    factor, unit = handy_unit(mine[0].unit, mine[0].size)
    marker = "o" if len(result.t) < 3 else ""
    lines = []
    for effect, (dashes, colour) in zip(mine, colours, strict=True):
        curve = factor * effect.derivative * effect.change
        lines += ax.plot(result.t, curve, linestyle=dashes, color=colour, linewidth=0.9, marker=marker)
    ax.set_ylabel(axis_label(f"change of {mine[0].output}", unit), parse_math=False)
    ax.margins(x=0.0 if len(result.t) > 2 else 0.05)
    shade_after_horizon(ax, result)
    legend = ax.legend(
        lines, [str(n) for n in range(len(lines))], loc="upper left", bbox_to_anchor=(1.01, 1.0),
        borderaxespad=0.0, frameon=False, fontsize=8,
    )  # fmt: skip
    for text, effect in zip(legend.get_texts(), mine, strict=True):
        text.set(text=_words(effect), parse_math=False)


def _words(effect: Effect) -> str:
    return f"{effect.parameter} by {effect.words}".replace("*", "·")
