"""Equilibria and small vibrations about them in the studio."""

from __future__ import annotations

import math

import numpy as np

from rattle.answers.blocks import Block, Content, content, drawing, table, words
from rattle.errors import AssemblyError, ModelError
from rattle.language.times import seconds
from rattle.mechanism import Mechanism
from rattle.plots.curves import length_axes, new_figure, tidy
from rattle.plots.scene import Scene
from rattle.plots.sketch import draw_mechanism, extent
from rattle.questions.equilibrium.position import Equilibrium
from rattle.results.display import quantity
from rattle.studio.shelf import Shelf, Source

DRAWN = 6  # equilibria that are drawn, at most
ROOM = 0.15  # around a drawing, as a share of its size


def tab(shelf: Shelf, source: Source, t: str = "0", branches: str = "near") -> Content:
    """Equilibria with the drivers held, and natural frequencies about the first."""
    m = shelf.mechanism(source)
    found = m.equilibrium(seconds(t, "drivers held at"), branches=branches)
    rows = [_row(k, one) for k, one in enumerate(found, 1)]
    head = ("", "kind", *(f"angle of {name}" for name in _free(m)), "pins that would have to be pulled")
    told = f"{len(found)} equilibri{'um' if len(found) == 1 else 'a'} found, {found.extent}" if found else found.extent
    return content(
        told,
        table(head, [_cells(m, row, one) for row, one in zip(rows, found, strict=True)]),
        _drawn(found[:DRAWN]),
        *_vibrations(m, t, bool(found)),
    )


def _row(k: int, one: Equilibrium) -> tuple[str, str]:
    said = "stable" if one.stable else "unstable" if one.falling else "neutral"
    return str(k), said if one.admissible else f"{said}, not possible"


def _free(m: Mechanism) -> list[str]:
    return list(m.model.bodies)[:5]


def _cells(m: Mechanism, row: tuple[str, str], one: Equilibrium) -> tuple[str, ...]:
    return (*row, *(quantity(one[f"{name}.angle"], "rad") for name in _free(m)), ", ".join(one.pulled) or "none")


def _drawn(found: list[Equilibrium]) -> Block | None:
    """The equilibria side by side."""
    if not found:
        return None
    columns = min(3, len(found))
    lines = math.ceil(len(found) / columns)
    figure = new_figure(3.6 * columns, 3.0 * lines)
    for k, (ax, one) in enumerate(
        zip(np.ravel(figure.subplots(lines, columns, squeeze=False)), found, strict=False), 1
    ):
        scene = Scene(one.result, np.array([0]), 1.0)
        low, high = extent(scene)
        size = float(max(high - low)) or 1.0
        scene = scene._replace(size=size)
        low, high = low - ROOM * size, high + ROOM * size
        ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        tidy(ax).grid(False)
        length_axes(ax, float(max(high - low)))
        draw_mechanism(ax, scene, names=False)
        ax.set_title(f"{k}: {_row(k, one)[1]}", loc="left", fontsize=10)
    for ax in figure.axes[len(found) :]:
        ax.set_visible(False)
    return drawing(figure)


def _vibrations(m: Mechanism, t: str, rests: bool) -> list[Block | None]:
    """Natural frequencies about the first equilibrium, or why there are none."""
    if not rests:
        return []
    try:
        found = m.modes(seconds(t, "drivers held at"))
    except (ModelError, AssemblyError, ValueError) as error:
        return [words(f"Small vibrations about it: {error}")]
    rows = [(str(k + 1), found.behaviour(k, 4)) for k in range(min(8, len(found)))]
    return [table(("mode", "small vibrations about the first"), rows), words(found.note)]
