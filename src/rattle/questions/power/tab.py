"""Where energy goes, in the studio."""

from __future__ import annotations

import numpy as np

from rattle.answers.blocks import Content, content, drawing, table
from rattle.questions.power.pictures import plot_cycle
from rattle.results.display import quantity
from rattle.studio.shelf import Shelf, Source

ROUNDING = 1e-12  # share of the largest below which a number is only rounding


def zeroed(value: float, floor: float) -> float:
    """The value, or 0 if its magnitude is below `floor` (same unit)."""
    return 0.0 if abs(value) <= floor else float(value)


def tab(shelf: Shelf, source: Source) -> Content:
    """Energy of a turn as a picture of flows, and a table of every port."""
    r = shelf.motion(source)
    p = r.power()
    one, names = p.cycle, p.names
    net = one.into - one.out
    nothing = ROUNDING * float(max((one.into + one.out).max(initial=0.0), 1e-300))
    weak = ROUNDING * float(np.abs(one.peak).max(initial=0.0))

    def energy(value: float) -> str:
        return quantity(zeroed(value, nothing), "J")

    rows = [
        (
            names["element"][k],
            names["kind"][k],
            names["body"][k],
            energy(one.into[k]),
            energy(one.out[k]),
            energy(net[k]),
            energy(min(one.into[k], one.out[k])),
            quantity(zeroed(one.peak[k], weak), "W"),
            quantity(zeroed(net[k], nothing) / (one.t1 - one.t0), "W"),
        )
        for k in np.argsort(-(one.into + one.out))
    ]
    head = (
        "element", "kind", "body", "into the body", "out of it", "net", "back and forth", "largest power", "mean power",
    )  # fmt: skip
    return content(
        f"from t = {p.t0:.4g} s to {p.t1:.4g} s; powers of each body balance to {p.residual:.1g} W",
        drawing(plot_cycle(p)),
        table(head, rows, "Every element at every body, those that pass most first"),
    )
