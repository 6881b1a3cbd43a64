"""A small drawing of a shipped example."""

from __future__ import annotations

import io

import numpy as np

from rattle.loading import example as load_example
from rattle.studio.shelf import Shelf

ROOM = 0.06  # around a drawing, as a share of its size
WIDTH, HEIGHT = 3.2, 2.0  # [inch]


def thumbnail(shelf: Shelf, example: str) -> str:
    """A shipped example as a small SVG drawing, as it is put together.  Raises ModelError, AssemblyError."""
    from matplotlib import rc_context

    from rattle.plots.curves import new_figure
    from rattle.plots.figure import TEXT
    from rattle.plots.scene import Scene
    from rattle.plots.sketch import draw_mechanism, extent
    from rattle.results.build import build_result
    from rattle.results.trust import Trust

    m = load_example(example)
    keys = [f"{body}.{key}" for body in m.system.bodies for key in ("x", "y", "angle")]
    units = {key: "rad" if key.endswith("angle") else "m" for key in keys}
    result = build_result(
        m.model, "assembly", t=[0.0], data=m.start.q[None], names=keys, units=units, trust=Trust(drift=0.0)
    )
    scene = Scene(result, np.array([0]), 1.0)
    low, high = extent(scene)
    size = float(max(high - low)) or 1.0
    scene = scene._replace(size=size)
    low, high = low - ROOM * size, high + ROOM * size
    out = io.StringIO()
    with rc_context({**TEXT, "svg.hashsalt": example}):
        figure = new_figure(WIDTH, HEIGHT)
        figure.set_layout_engine("none")
        ax = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        middle, half = 0.5 * (low + high), 0.5 * float(max((high - low) / (WIDTH, HEIGHT)))
        low, high = middle - half * np.array((WIDTH, HEIGHT)), middle + half * np.array((WIDTH, HEIGHT))
        ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        ax.axis("off")
        draw_mechanism(ax, scene, names=False)
        figure.savefig(out, format="svg", metadata={"Date": None}, transparent=True)
    text = out.getvalue()
    return text[text.index("<svg") :]
