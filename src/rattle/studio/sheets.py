"""What a tab shows, from plain data: words, tables, drawings, and curves that can be zoomed and read off."""

from __future__ import annotations

import html
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import panel as pn
from bokeh.models import BoxAnnotation, ColumnDataSource, FactorRange, HoverTool, Label, Span, TapTool
from bokeh.plotting import figure as new_plot

from rattle.plots.curves import CURVES, MORE

Content = dict[str, Any]
Pick = Callable[[dict[str, Any]], None]
HEIGHT = 290  # of a figure [px]
LEGEND_LINE = 24  # height of one name above the curves [px]
LEGEND_WIDTH, LEGEND_LETTERS = 36, 5  # letters in its line on a phone, and those that the sign of a curve takes
FEW_BARS = 8  # fewer leave room beside them, so that they do not become broad


class Look(NamedTuple):
    """Colours of a sheet."""

    ink: str
    soft: str
    grid: str
    paper: str
    black: str  # the darkest colour of curves, which has to be seen
    dark: bool
    narrow: bool = False  # the page is that of a phone held upright


LIGHT = Look("#1d2329", "#5b6670", "#e6e9ec", "#ffffff", "#333333", dark=False)
DARK = Look("#e8ebee", "#9aa5b0", "#2e353c", "#1b1f24", "#e8ebee", dark=True)
LIGHTER = {
    "#0072B2": "#56B4E9",
    "#56B4E9": "#9ad4f5",
    "#333333": "#e8ebee",
    "#D55E00": "#f08a4b",
    "#882255": "#d17aa5",
    "#332288": "#9a8fe0",
    "#009E73": "#3fc99a",
}  # of curves on a dark ground
STYLE = (Path(__file__).parent / "page" / "sheet.css").read_text(encoding="utf-8")


def sheet(content: Content, dark: bool, pick: Pick, narrow: bool = False) -> list[Any]:
    """Panel objects that show the content of a tab; pick: called with what the user has clicked."""
    look = (DARK if dark else LIGHT)._replace(narrow=narrow)
    return [VIEWS[block["kind"]](block, look, pick) for block in content["blocks"]]


# ---------------------------------------------------------------- text
def _html(text: str, look: Look) -> pn.pane.HTML:
    dark = look.dark
    style = STYLE.replace("INK", look.ink).replace("SOFT", look.soft).replace("GRID", look.grid)
    style = style.replace("PAPER", look.paper).replace("CARE", "#f0a245" if dark else "#b35900")
    style = style.replace("FILTER", "filter: invert(0.88) hue-rotate(180deg);" if dark else "")
    return pn.pane.HTML(text, stylesheets=[style], margin=(4, 0), sizing_mode="stretch_width")


def _words(block: Content, look: Look, pick: Pick) -> Any:
    return _html(f'<div class="words {html.escape(block["tone"])}">{html.escape(block["text"])}</div>', look)


def _table(block: Content, look: Look, pick: Pick) -> Any:
    head = "".join(f"<th>{html.escape(one)}</th>" for one in block["head"])
    rows = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in block["rows"])
    caption = f"<caption>{html.escape(block['caption'])}</caption>" if block["caption"] else ""
    return _html(
        f'<div class="scroll"><table>{caption}<thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>', look
    )


def _drawing(block: Content, look: Look, pick: Pick) -> Any:
    caption = f"<h3>{html.escape(block['caption'])}</h3>" if block["caption"] else ""
    return _html(f'{caption}<div class="drawing">{block["svg"]}</div>', look)


# ---------------------------------------------------------------- figures
def _plot(block: Content, x: str, y: str, look: Look, **more: Any) -> Any:
    """An empty figure in the look of the page."""
    tools = "xpan,xwheel_zoom,box_zoom,reset,save"
    found = new_plot(
        title=block["title"],
        height=HEIGHT,
        sizing_mode="stretch_width",
        tools=tools,
        active_drag="box_zoom",
        x_axis_label=x,
        y_axis_label=y,
        output_backend="canvas",
        toolbar_location="above",
        **more,
    )
    found.toolbar.logo = None
    found.toolbar.autohide = True
    found.background_fill_color = found.border_fill_color = look.paper
    found.outline_line_color = None
    found.title.text_color, found.title.text_font_size, found.title.text_font = (
        look.ink,
        "12px" if look.narrow else "14px",
        "system-ui",
    )
    for axis in found.axis:
        axis.axis_label_text_color = axis.major_label_text_color = look.soft
        axis.axis_line_color = axis.major_tick_line_color = axis.minor_tick_line_color = look.grid
        axis.axis_label_text_font_style, axis.axis_label_text_font = "normal", "system-ui"
        axis.axis_label_text_font_size, axis.major_label_text_font_size = "12px", "12px"
        axis.major_label_text_font = "system-ui"
    found.grid.grid_line_color = look.grid
    return found


def _pane(plot: Any) -> Any:
    return pn.pane.Bokeh(plot, sizing_mode="stretch_width", margin=(6, 0), theme=None)


def colour_of(k: int, look: Look) -> str:
    """Colour of the k-th curve."""
    every = (*CURVES, *MORE)
    found = every[k % len(every)]
    return LIGHTER.get(found, found) if look.dark else found


def _curves(block: Content, look: Look, pick: Pick) -> Any:
    plot = _plot(block, block["x"], block["y"], look)
    colours: list[str] = []
    for one in block["lines"]:
        like = one.get("like")
        colours.append(colours[like] if like is not None else colour_of(len(set(colours)), look))
        dash = "dashed" if one.get("dash") else "solid"
        named = {"legend_label": one["name"]} if one["name"] else {}
        drawn = plot.line(
            "x",
            "y",
            source=ColumnDataSource({"x": one["x"], "y": one["y"]}),
            color=colours[-1],
            line_width=1.4,
            line_dash=dash,
            **named,
        )
        plot.add_tools(
            HoverTool(
                renderers=[drawn],
                mode="mouse",
                line_policy="nearest",
                visible=False,
                tooltips=[(one["name"] or block["title"], "@y{0.0000a}"), (block["x"], "@x{0.0000}")],
            )
        )
        _between_outputs(plot, one, colours[-1])
    if (after := block.get("after")) is not None:
        plot.add_layout(
            BoxAnnotation(left=after, fill_color=look.soft, fill_alpha=0.13, line_color=None, level="underlay")
        )
        plot.title.text += "  (grey: after the horizon, statistics only)"
    if plot.legend:
        legend = plot.legend[0]
        if look.narrow:  # above, as the sheet ends soon below the curves
            legend.ncols = max(1, LEGEND_WIDTH // (LEGEND_LETTERS + max(len(line["name"]) for line in block["lines"])))
            plot.height += LEGEND_LINE * math.ceil(len(legend.items) / legend.ncols)
            legend.location = "top_left"
            legend.orientation = "horizontal"
        plot.add_layout(legend, "above" if look.narrow else "right")
        legend.click_policy = "hide"
        legend.background_fill_alpha = 0.0
        legend.border_line_color = None
        legend.label_text_color, legend.label_text_font_size = look.ink, "12px"
        legend.label_text_font = "system-ui"
    return _pane(plot)


def _between_outputs(plot: Any, line: Content, colour: str) -> None:
    """A triangle at the largest value of a curve within the steps of its run, and contacts between two outputs."""
    if short := line.get("short"):
        x, y = zip(*short, strict=True)
        plot.segment(x0=x, y0=[0.0] * len(x), x1=x, y1=y, color=colour, line_width=1.0)
    if top := line.get("top"):
        shape = "inverted_triangle" if top[1] > 0.0 else "triangle"
        mark = plot.scatter(x=[top[0]], y=[top[1]], marker=shape, size=9, color=colour, name=f"largest {line['name']}")
        tips = [(f"largest {line['name']}, within the steps", "@y{0.0000a}"), ("at", "@x{0.0000}")]
        plot.add_tools(HoverTool(renderers=[mark], visible=False, tooltips=tips))


def _bars(block: Content, look: Look, pick: Pick) -> Any:
    labels = list(dict.fromkeys(block["labels"]))
    room = max(0.0, 0.5 * (FEW_BARS - len(labels)))
    plot = _plot(
        block, "", block["y"], look, x_range=FactorRange(*labels, range_padding=room, range_padding_units="absolute")
    )
    plot.vbar(x=labels, top=block["values"][: len(labels)], width=0.62, color=colour_of(0, look))
    plot.y_range.start = 0
    plot.xgrid.grid_line_color = None
    if sum(map(len, labels)) > 80:
        plot.xaxis.major_label_orientation = 0.5
    return _pane(plot)


def _histogram(block: Content, look: Look, pick: Pick) -> Any:
    plot = _plot(block, block["x"], "number of mechanisms", look)
    edges = block["edges"]
    source = ColumnDataSource(
        {
            "left": edges[:-1],
            "right": edges[1:],
            "count": block["counts"],
            "sample": block["samples"],
        }
    )
    drawn = plot.quad(
        left="left",
        right="right",
        bottom=0,
        top="count",
        source=source,
        color=colour_of(0, look),
        alpha=0.75,
        line_color=look.paper,
        hover_alpha=1.0,
        nonselection_alpha=0.45,
        selection_alpha=1.0,
    )
    plot.add_tools(
        TapTool(renderers=[drawn]),
        HoverTool(
            renderers=[drawn],
            visible=False,
            tooltips=[
                ("", "@count mechanisms"),
                ("from", "@left{0.0000a}"),
                ("to", "@right{0.0000a}"),
                ("click", "replays number @sample"),
            ],
        ),
    )

    def clicked(attribute: str, old: list[int], new: list[int]) -> None:
        if new and block["samples"][new[0]] >= 0:
            pick({"number": int(block["samples"][new[0]])})

    source.selected.on_change("indices", clicked)
    top = float(max(block["counts"]))
    plot.y_range.start, plot.y_range.end = 0, 1.3 * top
    for k, mark in enumerate(block["marks"]):
        nominal = mark["label"] == "nominal"
        colour = colour_of(1, look) if nominal else look.ink
        plot.add_layout(
            Span(location=mark["x"], dimension="height", line_color=colour, line_dash="solid" if nominal else "dashed")
        )
        plot.add_layout(
            Label(
                x=mark["x"],
                y=(1.2 if nominal else 1.02 + 0.09 * (k % 2)) * top,
                text=f" {mark['label']}",
                text_color=colour,
                text_font_size="12px",
            )
        )
    return _pane(plot)


VIEWS: dict[str, Callable[[Content, Look, Pick], Any]] = {
    "words": _words,
    "table": _table,
    "svg": _drawing,
    "curves": _curves,
    "bars": _bars,
    "histogram": _histogram,
}
