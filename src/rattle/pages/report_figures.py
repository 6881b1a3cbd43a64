"""Pictures of a report: which curves say most about a mechanism, drawn for a page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import MaxNLocator

from rattle.pages.report_html import enumerated, figure, gallery, handy
from rattle.pages.report_study import TURNS, Study, motion_of
from rattle.plots import curves as style
from rattle.plots.diagram import Sheet, plot_model
from rattle.plots.figure import Page
from rattle.plots.orbit import clearance_joints
from rattle.results.contact_summary import force_rounding
from rattle.results.handy_units import QUANTITY, handy_unit, units_of_result
from rattle.results.within_steps import cut, largest, shown_curve

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.results.result import Result

SHEET = Sheet(6.0, 2.5, 1.2)  # of the drawing
HALF = 3.55  # width of most pictures: two stand side by side [inches]
HIGH = 0.98  # of a panel for one curve
HIGHER = 1.5  # of a panel for several curves
AXIS = 0.35  # of the time axis
TALLEST, FLATTEST = 2.4, 1.1  # of a path
AIR = 1.12  # of the axes of a path over its length
APART = 0.45  # of two ticks of a path
SLIM = 0.25  # least length of a side of these axes, as a share of the other
ABOVE = 48  # characters that stand above a panel side by side
STEPS = (1, 2, 2.5, 5, 10)  # from tick to tick
MOST = 6  # panels, orbits or curves of one kind
FEW = 3  # panels of one picture of forces
PLAY, IDEAL = "as modelled", "without play"
RATES = {"angle": ("omega", "alpha"), "x": ("vx", "ax"), "y": ("vy", "ay")}


def panels(s: Study, names: Sequence[str]) -> Figure:
    """Curves over time, each in a panel of its own with its unit; dashed, the same without play."""
    run = s.run
    assert run is not None, "a report draws curves of a run"
    axes = style.new_axes(HALF, HIGH * len(names) + AXIS, rows=len(names))
    for ax, name in zip(axes, names, strict=True):
        _panel(ax, run, s.ideal, name)
        over_time(ax, run)
    return with_time(axes)


def _panel(ax: Axes, run: Result, ideal: Result | None, name: str) -> None:
    values = [shown_curve(run, name), *([ideal[name]] if ideal is not None and name in ideal else [])]
    factor, unit = handy_unit(run.unit(name), largest(run, name), units_of_result(run.provenance))
    ax.plot(run.t, factor * values[0], color=style.BLUE, linewidth=0.9, label=PLAY)
    values.append(style.mark_largest(ax, run, name, style.BLUE, factor))
    if ideal is not None and name in ideal:
        ax.plot(
            ideal.t, factor * values[1], color=style.BLACK, linewidth=1.1, linestyle=(0, (4, 2)), label=IDEAL
        )  # fmt: skip
    told = cut(run, name)
    title = style.axis_label(name, unit) + (f", {told}" if told else "")
    ax.set_title(title, loc="left", fontsize=8, pad=3, parse_math=False)
    if style.robust_limits(ax, [factor * curve for curve in values], side="right"):
        reach = ax.texts[-1]
        if len(ax.get_title(loc="left")) + len(reach.get_text()) > ABOVE:
            reach.set_text(reach.get_text().replace("spikes cut off: they reach", "spikes to"))


def together(run: Result, names: Sequence[str], robust: bool = False) -> Figure:
    """Curves over time in one panel for each unit, their names above it; robust: rare spikes are cut off."""
    units: dict[str, list[str]] = {}
    for name in names:
        units.setdefault(run.unit(name), []).append(name)
    axes = style.new_axes(HALF, HIGHER * len(units) + AXIS, rows=len(units))
    for ax, (unit, curves) in zip(axes, units.items(), strict=True):
        size = max(largest(run, name) for name in curves)
        factor, shown = handy_unit(unit, size, units_of_result(run.provenance))
        tops = []
        for colour, name in zip(style.CURVES, curves, strict=False):
            told = cut(run, name)
            label = f"{name} ({told})" if told else name
            ax.plot(run.t, factor * shown_curve(run, name), color=colour, linewidth=0.9, label=label)
            tops += [factor * shown_curve(run, name), factor * style.mark_largest(ax, run, name, colour, factor)]
        ax.set_ylabel(style.axis_label(QUANTITY.get(unit, ""), shown) or "no unit", fontsize=8)
        spikes = robust and style.robust_limits(ax, tops, side="right")
        names_above(ax, LINE_OF_NOTE if spikes else 0.0)
        over_time(ax, run)
    return with_time(axes)


LINE_OF_NOTE = 0.1  # height of a note above a panel, as a share of it


def names_above(ax: Axes, higher: float = 0.0) -> None:
    """The names of the curves in lines above their panel."""
    handles, names = ax.get_legend_handles_labels()
    across = int(np.clip(52 // (max(map(len, names)) + 4), 1, 4))
    legend = ax.legend(
        handles, names, loc="lower left", bbox_to_anchor=(0.0, 1.0 + higher), ncols=across, fontsize=7.5,
        frameon=False, borderaxespad=0.2, handlelength=1.2, columnspacing=1.0,
    )  # fmt: skip
    for text in legend.get_texts():
        text.set_parse_math(False)


def over_time(ax: Axes, run: Result) -> None:
    """The look of a panel over time."""
    style.shade_after_horizon(ax, run)
    ax.margins(x=0.0)
    ax.tick_params(labelsize=7.5)
    ax.yaxis.set_major_locator(MaxNLocator(4, steps=STEPS, min_n_ticks=3))
    ax.xaxis.set_major_locator(MaxNLocator(5, steps=STEPS))
    ax.ticklabel_format(axis="y", style="plain", useOffset=False)


def with_time(axes: Sequence[Axes]) -> Figure:
    axes[-1].set_xlabel("time [s]", fontsize=8)
    return style.figure_of(axes[0])


# ---------------------------------------------------------------- which curves
def motion_figures(s: Study) -> list[str]:
    """The output with its speed and acceleration, all bodies, points of interest, signals."""
    run, model = s.run, s.m.model
    if run is None or len(run.t) < 2:
        return []
    body, _, key = s.output.rpartition(".")
    names = [s.output, *(f"{body}.{rate}" for rate in RATES[key])]
    words = {"angle": "angle", "x": "position of the mass centre along x", "y": "position of the mass centre along y"}
    figures = [figure(panels(s, names), f"Motion of {body}: {words[key]}, speed and acceleration{_marks(s)}.")]
    others = [motion_of(run, other) for other in model.moving_bodies if other != body and other not in s.driven]
    others = [name for name in others if np.ptp(run[name]) > (TURNS if name.endswith(".angle") else 0.0)]
    figures += _in_one(run, others, "Motion of the other bodies")
    if tracks := _points(s):
        path = f"Path{'s' if len(tracks) > 1 else ''} of {enumerated(tracks)} in the plane."
        figures.append(figure(_path(run, tracks), path))
    signals = [name for name in model.recorded if name in run and np.ptp(run[name]) > 0.0]
    figures += _in_one(run, signals, "Signals and states of the model", robust=True)
    return figures


def _in_one(run: Result, names: Sequence[str], words: str, robust: bool = False) -> list[str]:
    """The first of these curves in one figure; none without curves."""
    some = f" (the first {MOST} of {len(names)})" if len(names) > MOST else ""
    return [figure(together(run, names[:MOST], robust), f"{words}{some}{_shaded(run)}.")] if names else []


def _points(s: Study) -> list[str]:
    """Named points that no joint and no load has: somebody wants to know where they go."""
    model, run = s.m.model, s.run
    assert run is not None, "asked for after a run"
    ends = [end for joint in model.joints.values() for end in (joint.a, joint.b)]
    ends += [end for load in model.loads.values() for end in (load.a, load.b)]
    taken = {(end.body, end.name) for end in ends}
    every = [(body, point) for body, shape in model.bodies.items() if not shape.outline for point in shape.points]
    free = [f"{body}.{point}" for body, point in every if (body, point) not in taken]
    return [name for name in free if f"{name}.x" in run and np.ptp(run[f"{name}.x"]) + np.ptp(run[f"{name}.y"]) > 0][:3]


def _path(run: Result, tracks: Sequence[str]) -> Figure:
    """Paths of points, in a picture no higher than they need."""
    ax = run.plot_path(*tracks, ax=style.new_axes(HALF, TALLEST)[0])
    picture = style.figure_of(ax)
    ways = [np.concatenate([np.asarray(line.get_data()[k], float) for line in ax.lines]) for k in range(2)]
    least, most = (np.array([end(way) for way in ways]) for end in (np.nanmin, np.nanmax))
    room = 0.5 * AIR * np.maximum(most - least, SLIM * (most - least).max())
    (left, bottom), (right, top) = 0.5 * (least + most) - room, 0.5 * (least + most) + room
    ax.set(xlim=(left, right), ylim=(bottom, top))
    ax.set_aspect("equal", adjustable="box")
    plain_ticks(ax)
    handles, words = ax.get_legend_handles_labels()
    legend = ax.get_legend()
    assert legend is not None, "a path has one"
    legend.remove()
    lines = -(-len(tracks) // 2) if len(tracks) > 1 else 0
    if lines:
        picture.legend(handles, words, loc="outside lower center", ncols=2, frameon=False, fontsize=7.5)
    wide, below = 0.8 * HALF, 0.45  # of axes as wide as the picture, and of the labels below them
    high = float(np.clip(wide * room[1] / room[0] + below, FLATTEST, TALLEST))
    picture.set_figheight(high + 0.17 * lines)
    wide = min(wide, (high - below) * room[0] / room[1])
    ax.xaxis.set_major_locator(MaxNLocator(int(np.clip(wide / APART, 2, 6)), steps=STEPS, min_n_ticks=2))
    if wide < 2.5 * APART:
        ax.tick_params(axis="x", rotation=90)
    return picture


def plain_ticks(ax: Axes) -> None:
    """Without title and notes, which the report has around it, and with labels for a small picture."""
    ax.set_title("", loc="left")
    for text in list(ax.texts):
        if text.get_label() == style.NOTE:
            text.remove()
    ax.tick_params(labelsize=7.5)
    ax.xaxis.label.set_fontsize(8)
    ax.yaxis.label.set_fontsize(8)


def _marks(s: Study) -> str:
    assert s.run is not None, "asked for after a run"
    return ("; dashed: without play" if s.ideal is not None else "") + _shaded(s.run)


def _shaded(run: Result) -> str:
    return "; shaded: after the horizon" if _late(run) else ""


def _late(run: Result) -> bool:
    return run.trust.horizon is not None and run.trust.horizon < run.trust.t_end


def key(s: Study) -> str:
    """What dashed lines and shaded times mean in the curves, in a sentence; "" without any."""
    run = s.run
    if run is None:
        return ""
    said_of = ["dashed lines are the same mechanism without play"] if s.ideal is not None else []
    if _late(run):
        assert run.trust.horizon is not None, "late"
        said_of.append(
            f"the shaded time lies after the horizon, t = {handy(run.trust.horizon, 's', 3)}, where the motion is one"
            " of many possible ones, good for statistics only"
        )
    return f"In the curves {'; '.join(said_of)}." if said_of else ""


def driver_figures(s: Study) -> list[str]:
    """Effort and power of every driver; of a mechanism without one, its energies."""
    run = s.run
    if run is None or len(run.t) < 2:
        return []
    figures = []
    for name, driver in list(s.m.model.motors.items())[:MOST]:
        effort = driver.leaf.effort[0]
        curves = [curve for curve in (f"{name}.{effort}", f"{name}.power") if curve in run]
        if curves:
            on = driver.on.replace("'", "")
            kept = f"Effort of {name}, which moves {on}, and its power"
            figures.append(figure(panels(s, curves), f"{kept}{_marks(s)}."))
    if not s.m.model.drivers:
        names = [f"energy.{key}" for key in ("kinetic", "potential", "work", "dissipated")]
        names = [name for name in names if name in run and np.ptp(run[name]) > 0.0]
        if names:
            figures.append(figure(together(run, names), f"Energies of the mechanism{_shaded(run)}."))
    return figures


def force_figures(s: Study) -> list[str]:
    """Forces of the joints that bear most, one panel each, a few in a picture."""
    run = s.run
    if run is None or len(run.t) < 2:
        return []
    joints, rounding = [name for name in run.geometry["joints"] if f"{name}.fx" in run], force_rounding(run)
    by_peak = sorted(joints, key=lambda name: -run.peak(f"{name}.force")[0])[:MOST]
    shown = [name for name in joints if name in by_peak and run.peak(f"{name}.force")[0] > rounding]
    pictures = -(-len(shown) // FEW)
    size = -(-len(shown) // max(pictures, 1))
    figures = []
    for few in (shown[k * size : (k + 1) * size] for k in range(pictures)):
        words = f"Magnitude of the force{'s' if len(few) > 1 else ''} in {enumerated(few)}"
        figures.append(figure(panels(s, [f"{name}.force" for name in few]), f"{words}{_marks(s)}."))
    return figures


def orbit_figures(s: Study) -> str:
    """Path of every pin in its clearance."""
    run = s.run
    if run is None or len(run.t) < 2:
        return ""
    names = list(clearance_joints(run))
    shown = names[:MOST]
    some = f" (the first {MOST} of {len(names)} joints)" if len(names) > MOST else ""
    words = "Path of the pin of {} in its bush" + some
    return gallery([figure(_orbit(run, name), f"{words.format(name)}{_shaded_path(run)}.") for name in shown])


def _shaded_path(run: Result) -> str:
    return f"; after t = {handy(run.trust.horizon or 0.0, 's', 3)} statistics only" if _late(run) else ""


def _orbit(run: Result, joint: str) -> Figure:
    ax = run.plot_orbit(joint, ax=style.new_axes(HALF, 2.4)[0])
    plain_ticks(ax)
    unit = ax.get_ylabel().partition(" ")[2]
    ax.set_xlabel(f"x {unit}")
    legend = ax.get_legend()
    assert legend is not None, "an orbit has one"
    handles, names = ax.get_legend_handles_labels()
    ax.legend(
        handles, names, loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2, frameon=False, fontsize=7.5
    )  # fmt: skip
    picture = style.figure_of(ax)
    for bar in picture.axes[1:]:
        bar.tick_params(labelsize=7.5)
        bar.set_ylabel(
            bar.get_ylabel().replace("magnitude of the ", "").replace("\n", ", ").replace(", largest on top", ""),
            fontsize=8,
        )
    return picture


def path_figure(s: Study) -> str:
    """Effort of the drivers when the mechanism is moved slowly, and its mechanical advantage."""
    path = s.path
    if path is None or not len(path.t):
        return ""
    names = [f"{name}.{driver.leaf.effort[0]}" for name, driver in s.m.model.motors.items()]
    names += [f"{name}.advantage" for name in s.m.model.loads]
    names = [name for name in names if name in path and np.isfinite(path[name]).any()]
    if not names:
        return ""
    picture = together(path, names[:MOST], robust=True)
    words = "Effort of the drivers, position by position, if the mechanism is moved slowly"
    some = "; advantage: force or moment held at a load for each unit of effort" if len(s.m.model.drivers) == 1 else ""
    return figure(picture, f"{words}{some}.")


def drawing(s: Study) -> str:
    """The mechanism as put together, or as guessed with what does not close."""
    if not s.m.model.moving_bodies:
        return ""
    picture = plot_model(s.m, sheet=SHEET)
    assert isinstance(picture, Page), "without axes given it is a new figure"
    picture.axes[0].tick_params(labelsize=8)
    return figure(picture, "The mechanism at the start, to scale: circled crosses are mass centres.")
