"""Where energy goes, in the studio."""

from __future__ import annotations

import numpy as np

from rattle.answers.blocks import Content, content, drawing, table
from rattle.jit.choices import TINY
from rattle.questions.power.pictures import plot_cycle
from rattle.results.display import quantity, zeroed
from rattle.studio.shelf import Shelf, Source

ROUNDING = 1e-12  # share of the largest below which a number is only rounding


def tab(shelf: Shelf, source: Source) -> Content:
    """Energy of a turn as a picture of flows, and a table of every port."""
    r = shelf.motion(source)
    p = r.power()
    cycle, names = p.cycle, p.names
    net = cycle.into - cycle.out
    nothing = ROUNDING * float(max((cycle.into + cycle.out).max(initial=0.0), TINY))
    weak = ROUNDING * float(np.abs(cycle.peak).max(initial=0.0))

    def energy(value: float) -> str:
        return quantity(zeroed(value, nothing), "J")

    rows = [
        (
            names["element"][k],
            names["kind"][k],
            names["body"][k],
            energy(cycle.into[k]),
            energy(cycle.out[k]),
            energy(net[k]),
            energy(min(cycle.into[k], cycle.out[k])),
            quantity(zeroed(cycle.peak[k], weak), "W"),
            quantity(zeroed(net[k], nothing) / (cycle.t1 - cycle.t0), "W"),
        )
        for k in np.argsort(-(cycle.into + cycle.out))
    ]
    head = (
        "element", "kind", "body", "into the body", "out of it", "net", "back and forth", "largest power", "mean power",
    )  # fmt: skip
    return content(
        f"from t = {p.t0:.4g} s to {p.t1:.4g} s; powers of each body balance to {p.residual:.1g} W",
        drawing(plot_cycle(p)),
        table(head, rows, "Every element at every body, those that pass most first"),
    )
