"""The page of `rattle compare`: one mechanism under every model of its play."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from rattle import registry
from rattle.description.model import is_ground
from rattle.interfaces.contacts import ClearanceKind
from rattle.plots.curves import (
    BLACK,
    BLUE,
    BORE,
    GREEN,
    GREY,
    ORANGE,
    RED,
    SHADE,
    axis_label,
    new_figure,
    note,
    tidy,
)
from rattle.plots.orbit import mark_impacts, mark_pulling, pin_path  # fmt: skip
from rattle.questions.compare.compute import COMPLIANT, HEAD, IDEAL, IMPACT, LINK, OILED, Comparison, newton
from rattle.results.contact_summary import pressing_spans
from rattle.results.handy_units import QUANTITY, handy_unit
from rattle.results.within_steps import CUT, bursts, cut, largest, shown_curve
from rattle.value_types import Tree

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from rattle.results.result import Result

COLOURS = {IDEAL: BLACK, LINK: BLUE, IMPACT: ORANGE, COMPLIANT: GREEN, OILED: RED}
SAYS = {
    LINK: "Massless link: the pin cannot leave the bush wall",
    IMPACT: "One-sided impact: the {borne} flies, hits, stays or leaves",
    COMPLIANT: "Compliant: {borne} and {bearer} are elastic, with damping",
    OILED: "Lubricated: oil between {borne} and {bearer}, force of film and dry contact",
}
BELOW = {LINK: "red: N < 0", IMPACT: "dots: impacts, by impulse", COMPLIANT: "rings: contacts", OILED: "in oil"}
TOP = "▼ largest N"
WIDTH = 13.0  # of the page [inches]


def page(comparison: Comparison) -> Figure:
    """Motion, its deviation from the ideal one, joint force and orbit per model, energy lost, and a table.

    Units stand on the axes: N, J, mm or deg as the size asks, time in s or ms.
    """
    loose = [
        model
        for model in (LINK, IMPACT, COMPLIANT, OILED)
        if model in comparison.results and _has_orbit(comparison, model)
    ]
    remarks = _said(comparison)
    panels = [*[1.9, 1.5] * len(comparison.curves), *[2.15] * len(loose), 1.5]
    heights = [*panels, 0.42 + 0.26 * len(comparison.results), *([0.1 + 0.17 * len(remarks)] if remarks else [])]
    figure = new_figure(WIDTH, sum(heights) + 1.4)
    grid = figure.add_gridspec(len(heights), 2, width_ratios=[2.9, 1.0], height_ratios=heights)
    left = [tidy(figure.add_subplot(grid[0, 0]))]
    left += [tidy(figure.add_subplot(grid[k, 0], sharex=left[0])) for k in range(1, len(panels))]
    scale, unit = _time_unit(comparison)
    for k, curve in enumerate(comparison.curves):
        _motion(left[2 * k], left[2 * k + 1], comparison, curve, scale)
    _sketch(figure.add_subplot(grid[0:2, 1]), comparison)
    floor = _force_floor(comparison)
    for k, model in enumerate(loose, 2 * len(comparison.curves)):
        _force(left[k], comparison, model, floor, scale)
        _orbit(figure.add_subplot(grid[k, 1]), comparison, model)
    _energy(left[-1], comparison, scale)
    _legend(figure.add_subplot(grid[len(panels) - 1, 1]), comparison)
    for ax in left[:-1]:
        ax.tick_params(labelbottom=False)
    left[-1].set_xlabel(axis_label("time", unit))
    left[0].set_xlim(0.0, scale * max(r.trust.t_end for r in comparison.results.values()))
    _table(figure.add_subplot(grid[len(panels), :]), comparison)
    if remarks:
        _remarks(figure.add_subplot(grid[-1, :]), remarks)
    figure.align_ylabels(left)
    title = f"{comparison.name}: what its play does, by model"
    figure.suptitle(title, x=0.012, ha="left", fontsize=15, fontweight="bold", parse_math=False)
    return figure


def _has_orbit(comparison: Comparison, model: str) -> bool:
    return f"{comparison.joint}.ex" in comparison.results[model] and len(comparison.results[model].t) > 1


def _time_unit(comparison: Comparison) -> tuple[float, str]:
    return handy_unit("s", max(r.trust.t_end for r in comparison.results.values()))


# ---------------------------------------------------------------- panels
def _motion(top: Axes, below: Axes, comparison: Comparison, curve: str, scale: float) -> None:
    """A curve under every model, and how far each is from the ideal one."""
    reference = comparison.reference
    ideal = comparison.results[reference]
    unit = ideal.unit(curve)
    turn, shown = (math.degrees(1.0), "deg") if unit == "rad" else (1.0, unit)
    for model, r in comparison.results.items():
        first = model == reference
        style: dict[str, Any] = {"color": COLOURS[model], "linewidth": 2.2 if first else 1.0}
        style["alpha"] = 0.35 if first else 0.9
        top.plot(scale * r.t, turn * r[curve], **style)
    top.set_ylabel(axis_label(QUANTITY.get(unit, ""), shown))
    _title(top, f"Motion: {curve}")
    small = {"m": (1e3, "mm")}.get(shown, (1.0, shown))
    worst = 0.0
    for model, r in comparison.results.items():
        if model == reference:
            continue
        n = min(len(r.t), len(ideal.t))
        off = small[0] * turn * (r[curve][:n] - ideal[curve][:n])
        worst = max(worst, float(np.abs(off).max(initial=0.0)))
        below.plot(scale * r.t[:n], off, color=COLOURS[model], linewidth=1.0, alpha=0.9)
        _mark_horizon(below, r, COLOURS[model], scale)
    below.axhline(0.0, color=GREY, linewidth=0.8)
    below.set_ylabel(axis_label("deviation", small[1]))
    what = "the mechanism without play" if reference == IDEAL else f"the run with {reference}"
    _title(below, f"Deviation of {curve} from {what}")
    note(below, f"up to {worst:.3g} {small[1]}; dotted: the model's horizon, after it statistics only")


def _mark_horizon(ax: Axes, r: Result, colour: str, scale: float) -> None:
    if r.trust.horizon is not None and r.trust.horizon < r.trust.t_end:
        ax.axvline(scale * r.trust.horizon, color=colour, linewidth=1.1, linestyle=":")


def _force_floor(comparison: Comparison) -> float:
    """Force [N] at which the scale turns from linear to logarithmic: the size of the ideal reaction, rounded."""
    typical = float(np.nanmedian(comparison.results[comparison.reference][f"{comparison.joint}.force"])) or 1.0
    return float(10.0 ** math.floor(math.log10(typical)))


def _force(ax: Axes, comparison: Comparison, model: str, floor: float, scale: float) -> None:
    """Normal force on a scale that shows both the reaction without play and the peaks, with a strip of events."""
    r, joint, ideal = comparison.results[model], comparison.joint, comparison.results.get(IDEAL)
    name = f"{joint}.force" if model == OILED else f"{joint}.normal"
    normal = shown_curve(r, name)
    ax.set_yscale("symlog", linthresh=floor, linscale=0.7)
    ax.axhline(0.0, color=GREY, linewidth=0.8)
    if ideal is not None:
        ax.plot(scale * ideal.t, ideal[f"{joint}.force"], color=BLACK, linewidth=2.0, alpha=0.3)
    ax.plot(scale * r.t, normal, color=COLOURS[model], linewidth=0.9)
    if short := bursts(r, f"{joint}.normal"):  # longer contacts are seen in the curve itself
        at = [scale * burst.t for burst in short]
        ax.vlines(at, 0.0, [burst.y for burst in short], color=COLOURS[model], linewidth=0.7)
    if model == OILED:
        highest, when = r.peak(f"{joint}.force")
    else:
        highest, when = r.peaks.get(f"{joint}.pressing", r.peaks.get(f"{joint}.normal", (0.0, 0.0)))[:2]
    if highest > 0.0 and not cut(r, name):
        ax.plot([scale * when], [highest], "v", color=COLOURS[model], markersize=5, zorder=5)
    _force_axis(ax, comparison, model, floor)
    if model == LINK:
        for a, b in r.trust.intervals.get(joint, ()):
            ax.axvspan(scale * a, scale * b, color=RED, alpha=0.16, linewidth=0)
        share = 100 * r.trust.pulled.get(joint, 0.0)
        pulls = f"red: N < 0 for {share:.2g} % of the time, the bush would have to pull" if share else "N stays above 0"
        note(ax, f"{pulls}; {TOP}")
    else:
        _events(ax, r, joint, scale, CUT if cut(r, name) else TOP)
    if r.trust.horizon is not None and r.trust.horizon < r.trust.t_end:
        ax.axvspan(scale * r.trust.horizon, scale * r.trust.t_end, color=SHADE, linewidth=0, zorder=0)
    play = _play(r, joint)
    _title(ax, SAYS[model].format(borne=play.borne, bearer=play.bearer))


def _force_axis(ax: Axes, comparison: Comparison, model: str, floor: float) -> None:
    """Ticks of the forces [N] of all models: powers of ten from `floor` on."""
    joint = comparison.joint
    least, top = _force_range(comparison)
    ax.set_ylim(min(1.6 * least, -floor) if model == LINK else -1.3 * floor, 2.0 * top)
    low, high = ax.get_ylim()
    powers = [floor * 10.0**k for k in range(8)]
    ticks = [-p for p in powers if -p >= low and model == LINK][::-1] + [0.0] + [p for p in powers if p <= high]
    ax.set_yticks(ticks, [_force_label(tick) for tick in ticks])
    ax.minorticks_off()
    ax.set_ylabel(
        f"{'force' if model == OILED else 'N'} at {joint} [N]\nlogarithmic beyond {_force_label(floor)}", fontsize=9
    )


def _force_range(comparison: Comparison) -> tuple[float, float]:
    """Least (not above zero) and largest force [N] of the joint under all models."""
    joint = comparison.joint
    loose = [run for run in comparison.results.values() if f"{joint}.normal" in run]
    top = max(largest(run, f"{joint}.normal") for run in loose)
    top = max([top, *(c.peak for run in loose if (c := run.contacts.get(joint)) and c.readable)])
    least = min([0.0, *(float(np.nanmin(shown_curve(run, f"{joint}.normal"))) for run in loose)])
    return least, top


def _play(r: Result, joint: str) -> type[ClearanceKind]:
    """What the kind of play of a joint says about itself."""
    kind = registry.play_of(r.geometry["joints"][joint]["type"])
    assert kind is not None, "only joints with play are compared"
    return kind.leaf


def _force_label(force: float) -> str:
    """1000 -> "1 k", the usual short form."""
    size = abs(force)
    text = f"{size / 1e6:g} M" if size >= 1e6 else f"{size / 1e3:g} k" if size >= 1e3 else f"{size:g}"
    return text if force >= 0.0 else f"\N{MINUS SIGN}{text}"


def _events(ax: Axes, r: Result, joint: str, scale: float, top: str) -> None:
    """Along the bottom of the panel: bars while the pin presses, ticks at impacts; top: what is said of the largest."""
    mine = [event for event in r.events if event.joint == joint]
    place: dict[str, Any] = {"transform": ax.get_xaxis_transform(), "clip_on": True}
    for a, b in pressing_spans(mine):
        ax.fill_between([scale * a, scale * b], 0.02, 0.09, color=GREY, alpha=0.55, linewidth=0, **place)
    hits = [event for event in mine if event.kind == "impact"]
    contacts = sum(event.kind == "contact" for event in mine)
    parts = ["grey: in contact"] if contacts else []
    if hits:
        ax.vlines([scale * event.t for event in hits], 0.02, 0.16, color=RED, linewidth=0.7, **place)
        many = "s" if len(hits) > 1 else ""
        parts.append(f"red: {len(hits)} impact{many}, up to {max(e.impulse for e in hits):.2g} N·s")
    elif mine:
        summary = r.contacts[joint]
        peak = f", peak {newton(summary.peak)}" if summary.readable else ""
        parts.append(f"{contacts} contacts{peak}")
    note(ax, "; ".join([*parts, top]))


def _orbit(ax: Axes, comparison: Comparison, model: str) -> None:
    """Path of the pin in its clearance circle (or of the block across its guide)."""
    from matplotlib.patches import Circle

    r, joint = comparison.results[model], comparison.joint
    form = r.geometry["joints"][joint]
    scale, unit = handy_unit("m", form["clearance"])
    c = scale * form["clearance"]
    x, y, normal = pin_path(r, joint)
    tidy(ax).grid(False)
    ax.spines[["left", "bottom"]].set_visible(False)
    play = _play(r, joint)
    guide = not play.orbit
    if not guide:
        ax.add_patch(Circle((0, 0), c, facecolor=BORE, edgecolor=GREY, linewidth=1.0, zorder=0))
    dense = max(0.15, min(0.9, 3000 / max(len(x), 1)))
    ax.plot(scale * x, scale * y, color=COLOURS[model], linewidth=0.7 if model != LINK else 2.2, alpha=dense, zorder=2)
    pulls = normal < 0.0
    if model == LINK and pulls.any():
        mark_pulling(ax, np.arctan2(y[pulls], x[pulls]), c)
    mark_impacts(ax, r, joint, scale, largest=90.0)
    ax.plot([0], [0], "+", color=GREY, markersize=7)
    reach = float(np.hypot(x, y).max()) * scale
    limit = 1.18 * max(c, reach)
    ax.set(xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal", yticks=[-c, 0, c])
    if c > 0.25 * limit:  # otherwise the labels of the circle would overlap
        ax.set_xticks([-c, 0, c], [f"\N{MINUS SIGN}{c:.3g}", "0", f"{c:.3g} {unit}"], fontsize=8)
    else:
        ax.set_xticks([-reach, 0, reach], [f"\N{MINUS SIGN}{reach:.3g}", "0", f"{reach:.3g} {unit}"], fontsize=8)
    ax.set_yticklabels([])
    ax.tick_params(length=0)
    below = BELOW[model]
    if guide:
        _walls(ax, form, c, limit)
    what = f"{play.borne} in its {play.bearer}"
    deep = f"; sinks in by {reach - c:.3g} {unit}" if reach > 1.05 * c else ""
    ax.set_title(f"{joint}: {what}\n{below}{deep}", fontsize=8.0, color=GREY, pad=3, parse_math=False)


def _walls(ax: Axes, form: Tree, c: float, limit: float) -> None:
    """The two walls of a guide that is fixed to the ground, with the free width between them."""
    if not is_ground(form["bodies"][0]):
        return
    cos, sin = math.cos(form["axis"]), math.sin(form["axis"])
    ends = [(2.0 * i * limit, j * c) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    x, y = [cos * s - sin * n for s, n in ends], [sin * s + cos * n for s, n in ends]
    ax.fill(x, y, facecolor=BORE, edgecolor=GREY, linewidth=1.0, zorder=0)


def _energy(ax: Axes, comparison: Comparison, scale: float) -> None:
    """Energy lost in the contacts and elsewhere."""
    top = 0.0
    for model, r in comparison.results.items():
        lost = r["energy.dissipated"]
        top = max(top, float(lost.max(initial=0.0)))
        first = model == IDEAL
        style: dict[str, Any] = {"linewidth": 2.2, "alpha": 0.35} if first else {"linewidth": 1.2}
        ax.plot(scale * r.t, lost, color=COLOURS[model], **style)
    ax.set_ylabel(axis_label("energy lost", "J"))
    _title(ax, "Energy lost in all joints and dampers (impacts, contact damping, friction, oil)")
    audit = max(r.trust.energy_balance for r in comparison.results.values())
    note(ax, f"largest energy error of all runs {audit:.1g} J")


def _legend(ax: Axes, comparison: Comparison) -> None:
    """What the colours mean, and what was assumed."""
    from textwrap import fill

    ax.axis("off")
    for k, model in enumerate(COLOURS):
        y = 0.95 - 0.15 * k
        why = comparison.skipped.get(model, "")
        if model in comparison.results:
            ax.plot(
                [0.0, 0.1],
                [y, y],
                color=COLOURS[model],
                linewidth=3,
                alpha=0.5 if model == IDEAL else 1.0,
                transform=ax.transAxes,
            )
        name = "no play" if model == IDEAL else model
        text = f"{name}: left out, see below" if why else name
        ax.text(
            0.13,
            y,
            text,
            va="center",
            fontsize=8.5 if why else 9.5,
            color=GREY if why else BLACK,
            transform=ax.transAxes,
        )
    if comparison.assumed:
        caption = "\n".join(fill(assumption, 46) for assumption in comparison.assumed)
        ax.text(0.0, 0.2, caption, va="top", fontsize=7.5, color=GREY, transform=ax.transAxes)


def _sketch(ax: Axes, comparison: Comparison) -> None:
    """The mechanism at the start."""
    from rattle.plots.sketch import draw_at

    shown = next(model for model in (LINK, IMPACT, comparison.reference) if model in comparison.results)
    draw_at(ax, comparison.results[shown], 0)
    ax.set_title("at the start [m]", fontsize=8.5, color=GREY, pad=3)


def _table(ax: Axes, comparison: Comparison) -> None:
    """The numbers of the joint, one row for each model."""
    ax.axis("off")
    rows = comparison.rows()
    at = [0.0, 0.16, 0.28, 0.40, 0.50, 0.59, 0.75, 0.88]
    step = 1.0 / (len(rows) + 1)
    for k, head in enumerate(HEAD):
        text = f"joint {comparison.joint}" if k == 0 else head
        ax.text(at[k], 1.0 - 0.5 * step, text, fontsize=9.5, fontweight="bold", va="center", transform=ax.transAxes)
    for n, row in enumerate(rows):
        y = 1.0 - (n + 1.5) * step
        for k, cell in enumerate(row):
            colour = COLOURS[row[0]] if k == 0 else BLACK
            weight = "bold" if k == 0 else "normal"
            ax.text(
                at[k],
                y,
                cell.replace("N*s", "N·s"),
                fontsize=9.5,
                color=colour,
                fontweight=weight,
                va="center",
                transform=ax.transAxes,
            )
    ax.plot([0, 1], [1.0 - step] * 2, color=GREY, linewidth=0.8, transform=ax.transAxes)


def _said(comparison: Comparison) -> list[tuple[str, str]]:
    """Lines of remarks: model (where a remark begins), text."""
    from textwrap import wrap

    remarks = [(model, f"left out: {why}") for model, why in comparison.skipped.items()]
    remarks += [(model, note) for model, notes in comparison.notes.items() for note in notes]
    lines = []
    for model, text in remarks:
        first, *rest = wrap(text, 150)
        lines += [(model, first), *(("", line) for line in rest)]
    return lines


def _remarks(ax: Axes, lines: list[tuple[str, str]]) -> None:
    """What the runs say about themselves, and why a model is left out."""
    ax.axis("off")
    for n, (model, text) in enumerate(lines):
        y = 1.0 - (n + 0.5) / len(lines)
        if model:
            ax.text(0.0, y, model, fontsize=8.5, color=COLOURS[model], va="center", transform=ax.transAxes)
        ax.text(0.12, y, text, fontsize=8.5, color=BLACK, va="center", parse_math=False, transform=ax.transAxes)


def _title(ax: Axes, text: str) -> None:
    ax.set_title(text, loc="left", fontsize=10.5, pad=4)
