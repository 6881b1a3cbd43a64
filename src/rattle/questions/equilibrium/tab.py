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
    equilibria = m.equilibrium(seconds(t, "drivers held at"), branches=branches)
    rows = [_row(k, rest) for k, rest in enumerate(equilibria, 1)]
    head = ("", "kind", *(f"angle of {name}" for name in _free(m)), "pins that would have to be pulled")
    told = (
        f"{len(equilibria)} equilibri{'um' if len(equilibria) == 1 else 'a'} found, {equilibria.extent}"
        if equilibria
        else equilibria.extent
    )
    return content(
        told,
        table(head, [_cells(m, row, rest) for row, rest in zip(rows, equilibria, strict=True)]),
        _drawn(equilibria[:DRAWN]),
        *_vibrations(m, t, bool(equilibria)),
    )


def _row(k: int, rest: Equilibrium) -> tuple[str, str]:
    kind = "stable" if rest.stable else "unstable" if rest.falling else "neutral"
    return str(k), kind if rest.admissible else f"{kind}, not possible"


def _free(m: Mechanism) -> list[str]:
    return m.model.moving_bodies[:5]


def _cells(m: Mechanism, row: tuple[str, str], rest: Equilibrium) -> tuple[str, ...]:
    return (*row, *(quantity(rest[f"{name}.angle"], "rad") for name in _free(m)), ", ".join(rest.pulled) or "none")


def _drawn(equilibria: list[Equilibrium]) -> Block | None:
    """The equilibria side by side."""
    if not equilibria:
        return None
    columns = min(3, len(equilibria))
    lines = math.ceil(len(equilibria) / columns)
    figure = new_figure(3.6 * columns, 3.0 * lines)
    for k, (ax, rest) in enumerate(
        zip(np.ravel(figure.subplots(lines, columns, squeeze=False)), equilibria, strict=False), 1
    ):
        scene = Scene(rest.result, np.array([0]), 1.0)
        low, high = extent(scene)
        size = float(max(high - low)) or 1.0
        scene = scene._replace(size=size)
        low, high = low - ROOM * size, high + ROOM * size
        ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        tidy(ax).grid(False)
        length_axes(ax, float(max(high - low)))
        draw_mechanism(ax, scene, names=False)
        ax.set_title(f"{k}: {_row(k, rest)[1]}", loc="left", fontsize=10)
    for ax in figure.axes[len(equilibria) :]:
        ax.set_visible(False)
    return drawing(figure)


def _vibrations(m: Mechanism, t: str, rests: bool) -> list[Block | None]:
    """Natural frequencies about the first equilibrium, or why there are none."""
    if not rests:
        return []
    try:
        modes = m.modes(seconds(t, "drivers held at"))
    except (ModelError, AssemblyError, ValueError) as error:
        return [words(f"Small vibrations about it: {error}")]
    rows = [(str(k + 1), modes.behaviour(k, 4)) for k in range(min(8, len(modes)))]
    return [table(("mode", "small vibrations about the first"), rows), words(modes.note)]
