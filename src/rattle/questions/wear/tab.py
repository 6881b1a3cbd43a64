"""Oil films and wear of the pins of a model, in the studio."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rattle.answers.blocks import Block, Content, content, curves, drawing, line, of_result, table, words
from rattle.errors import InputError
from rattle.plots.curves import axis_label
from rattle.results.film_summary import film_rows
from rattle.results.handy_units import handy_unit
from rattle.studio.shelf import Shelf, Source

if TYPE_CHECKING:
    from rattle.questions.wear.worn import Worn

HOW_WEAR = (
    'No joint wears: give one wear = { bush = "1e-6 mm^3/(N*m)", pin = 0 } in Text, see the example slider_crank_worn.'
)
HOW_OIL = 'No joint has oil: choose the contact model "lubricated" on the left, see the example slider_crank_oil.'


def tab(shelf: Shelf, source: Source, cycles: str = "1e5") -> Content:
    """Films of joints with oil, and wear of joints that wear over so many cycles."""
    m = shelf.mechanism(source)
    oiled = [name for name, joint in m.model.joints.items() if joint.contact and joint.contact.film is not None]
    worn = [name for name, joint in m.model.joints.items() if joint.wear is not None]
    blocks = [*(_oil(shelf, source) if oiled else [words(HOW_OIL)])]
    told = f"oil in {', '.join(oiled)}" if oiled else "no oil"
    if not worn:
        return content(f"{told}, no wear", *blocks, words(HOW_WEAR))
    try:
        count = float(cycles)
    except ValueError:
        raise InputError(f"cycles: {cycles!r} is not a number; give one such as 1e5") from None
    answer = m.wear(count, progress=True)
    if answer.interrupted:
        raise KeyboardInterrupt
    return content(
        f"{told}; {answer.cycles:.4g} cycles of wear, {answer.simulated} of them simulated", *blocks, _depths(answer),
        *(drawing(answer.plot(name), f"Wear of {name}") for name in answer.joints), words(str(answer)),
    )  # fmt: skip


def _depths(answer: Worn) -> Block | None:
    """How deep bushes and pins are worn, over the cycles."""
    history = answer.columns
    depths = {f"{name}, {side}": history[f"{name}.{side}.depth"] for name in answer.joints for side in ("bush", "pin")}
    factor, unit = handy_unit("m", max(float(depth.max()) for depth in depths.values()))
    lines = [line(name, history["cycle"], factor * depth) for name, depth in depths.items() if np.any(depth > 0)]
    return curves("Deepest wear", "cycles", axis_label("depth", unit), lines)


def _oil(shelf: Shelf, source: Source) -> list[Block | None]:
    r = shelf.motion(source)
    films = [name for name in r.names if name.endswith(".film_thickness")]
    head, rows = film_rows(r)
    return [
        of_result("Least film thickness", r, films), table(head, rows, "Films over the run"),
        *(drawing(r.plot_orbit(name.removesuffix(".film_thickness"))) for name in films[:2]),
    ]  # fmt: skip
