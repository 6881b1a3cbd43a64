"""Pictures of a report: which curves say most about a mechanism, drawn for a page."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle import registry
from rattle.pages.report_html import enumerated, figure, said, side_by_side
from rattle.pages.report_study import TURNS, Study, motion_of
from rattle.plots import curves as style
from rattle.plots.figure import Page
from rattle.plots.orbit import clearance_joints
from rattle.results.handy_units import handy_unit, units_of_result
from rattle.results.within_steps import largest

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.results.result import Result

WIDE, HIGH = 7.6, 1.75  # of a panel [inches]
MOST = 6  # panels, orbits or curves of one kind
PLAY, IDEAL = "as modelled", "without play"
RATES = {"angle": ("omega", "alpha"), "x": ("vx", "ax"), "y": ("vy", "ay")}


def panels(s: Study, names: list[str], *, labels: dict[str, str] | None = None) -> Figure:
    """Curves over time, each in a panel of its own with its unit; dashed, the same without play."""
    run = s.run
    assert run is not None, "a report draws curves of a run"
    axes = style.new_axes(WIDE, HIGH * len(names) + 0.45, rows=len(names))
    for ax, name in zip(axes, names, strict=True):
        _panel(ax, run, s.ideal, name)
        ax.set_title((labels or {}).get(name, name), loc="left", fontsize=9, pad=3, parse_math=False)
        style.shade_after_horizon(ax, run)
        ax.margins(x=0.0)
    made = style.figure_of(axes[0])
    if s.ideal is not None:
        handles, words = axes[0].get_legend_handles_labels()
        made.legend(handles, words, loc="outside upper right", frameon=False, fontsize=8, ncols=2)
    axes[-1].set_xlabel("time [s]")
    return made


def _panel(ax: Axes, run: Result, ideal: Result | None, name: str) -> None:
    values = [run[name], *([ideal[name]] if ideal is not None and name in ideal else [])]
    factor, unit = handy_unit(run.unit(name), largest(run, name), units_of_result(run.provenance))
    ax.plot(run.t, factor * values[0], color=style.BLUE, linewidth=0.9, label=PLAY)
    values.append(style.mark_largest(ax, run, name, style.BLUE, factor))
    if ideal is not None and name in ideal:
        ax.plot(
            ideal.t, factor * values[1], color=style.BLACK, linewidth=1.1, linestyle=(0, (4, 2)), label=IDEAL
        )  # fmt: skip
    ax.set_ylabel(style.axis_label(style.QUANTITY.get(run.unit(name), ""), unit) or "no unit", fontsize=8.5)
    ax.tick_params(labelsize=8)
    style.robust_limits(ax, [factor * one for one in values], side="right")


# ---------------------------------------------------------------- which curves
def motion_figures(s: Study) -> list[str]:
    """The output with its speed and acceleration, all bodies, points of interest, signals."""
    run, model = s.run, s.m.model
    if run is None or len(run.t) < 2:
        return []
    body, _, key = s.output.rpartition(".")
    names = [s.output, *(f"{body}.{rate}" for rate in RATES[key])]
    words = {"angle": "angle", "x": "position of the mass centre along x", "y": "position of the mass centre along y"}
    dashed = f"{_dashed(s)}{_shaded(run)}"
    found = [figure(panels(s, names), f"Motion of {body}: {words[key]}, speed and acceleration{dashed}.")]
    others = [motion_of(run, one) for one in model.bodies if one != body and one not in s.driven]
    others = [name for name in others if np.ptp(run[name]) > (TURNS if name.endswith(".angle") else 0.0)]
    if others:
        some = f" (the first {MOST} of {len(others)})" if len(others) > MOST else ""
        found.append(figure(untitled(run.plot(*others[:MOST])), f"Motion of the other bodies{some}."))
    if tracks := _points(s):
        path = f"Path{'s' if len(tracks) > 1 else ''} of {enumerated(tracks)} in the plane."
        found.append(figure(untitled(run.plot_path(*tracks)), path))
    signals = [name for name in model.recorded if name in run and np.ptp(run[name]) > 0.0]
    if signals:
        some = f" (the first {MOST} of {len(signals)})" if len(signals) > MOST else ""
        picture = untitled(run.plot(*signals[:MOST], robust=True))
        found.append(figure(picture, f"Signals and states of the model{some}."))
    return found


def _points(s: Study) -> list[str]:
    """Named points that no joint and no load has: somebody wants to know where they go."""
    model, run = s.m.model, s.run
    assert run is not None, "asked for after a run"
    ends = [end for one in model.joints.values() for end in (one.a, one.b)]
    ends += [end for load in model.loads.values() for end in (load.a, load.b)]
    taken = {(end.body, end.name) for end in ends}
    every = [(body, point) for body, one in model.bodies.items() if not one.outline for point in one.points]
    free = [f"{body}.{point}" for body, point in every if (body, point) not in taken]
    return [name for name in free if f"{name}.x" in run and np.ptp(run[f"{name}.x"]) + np.ptp(run[f"{name}.y"]) > 0][:3]


def untitled(picture: Figure) -> Figure:
    """Without the name of the model, which is the title of the report."""
    picture.axes[0].set_title("", loc="left")
    return picture


def _dashed(s: Study) -> str:
    return "; dashed: the same mechanism without play" if s.ideal is not None else ""


def _shaded(run: Result) -> str:
    horizon = run.trust.horizon
    if horizon is None or horizon >= run.trust.t_end:
        return ""
    return f"; shaded: after t = {said(horizon, 's', 3)} it is one of many possible motions, good for statistics only"


def driver_figures(s: Study) -> list[str]:
    """Effort and power of every driver; of a mechanism without one, its energies."""
    run = s.run
    if run is None or len(run.t) < 2:
        return []
    found = []
    for name, driver in list(s.m.model.drivers.items())[:MOST]:
        effort = registry.kinds("driver")[driver.kind].leaf.effort[0]
        curves = [one for one in (f"{name}.{effort}", f"{name}.power") if one in run]
        if curves:
            on = driver.on.replace("'", "")
            kept = f"Effort of {name}, which moves {on}, and its power"
            found.append(figure(panels(s, curves), f"{kept}{_dashed(s)}{_shaded(run)}."))
    if not s.m.model.drivers:
        names = [f"energy.{key}" for key in ("kinetic", "potential", "work", "dissipated")]
        names = [name for name in names if name in run and np.ptp(run[name]) > 0.0]
        if names:
            found.append(figure(untitled(run.plot(*names)), "Energies of the mechanism."))
    return found


def force_figures(s: Study) -> list[str]:
    """Forces of the joints that bear most, one panel each."""
    run = s.run
    if run is None or len(run.t) < 2:
        return []
    joints = [name for name in run.geometry["joints"] if f"{name}.fx" in run]
    by_peak = sorted(joints, key=lambda name: -run.peak(f"{name}.force")[0])[:MOST]
    shown = [f"{name}.force" for name in joints if name in by_peak and run.peak(f"{name}.force")[0] > 0.0]
    if not shown:
        return []
    some = f" of the {MOST} joints that bear most" if len(joints) > MOST else ""
    return [figure(panels(s, shown), f"Magnitude of the joint forces{some}{_dashed(s)}{_shaded(run)}.")]


def orbit_figures(s: Study) -> str:
    """Path of every pin in its clearance."""
    run = s.run
    if run is None or len(run.t) < 2:
        return ""
    names = list(clearance_joints(run))[:4]
    return side_by_side([figure(run.plot_orbit(name), f"Path of the pin of {name} in its bush.") for name in names])


def path_figure(s: Study) -> str:
    """Effort of the drivers when the mechanism is moved slowly, and its mechanical advantage."""
    path = s.path
    if path is None or not len(path.t):
        return ""
    names = [f"{name}.{_effort(one.kind)}" for name, one in s.m.model.drivers.items()]
    names += [f"{name}.advantage" for name in s.m.model.loads]
    names = [name for name in names if name in path and np.isfinite(path[name]).any()]
    if not names:
        return ""
    picture = untitled(path.plot(*names[:MOST], robust=True))
    words = "Effort of the drivers, position by position, if the mechanism is moved slowly"
    some = "; advantage: force or moment held at a load for each unit of effort" if len(s.m.model.drivers) == 1 else ""
    return figure(picture, f"{words}{some}.")


def _effort(kind: str) -> str:
    return str(registry.kinds("driver")[kind].leaf.effort[0])


def drawing(s: Study) -> str:
    """The mechanism as put together, or as guessed with what does not close."""
    if not s.m.model.bodies:
        return ""
    picture = s.m.plot()
    assert isinstance(picture, Page), "without axes given it is a new figure"
    return figure(picture, "The mechanism at the start, to scale: circled crosses are mass centres.")
