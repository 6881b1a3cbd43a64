"""Pictures of joints and loads, one form per file: a kind names its form as `drawn_as`, and is drawn so everywhere.

A new form is a file with one function,

    @drawing("wheel")
    def wheel(sheet, part): ...

It writes primitives on the sheet (see `rattle.drawings.sheet`), in frames of bodies, with numbers that follow from the
dimensions of the part and from the motion.  Matplotlib, the canvas of pages and SVG play them.
"""

from __future__ import annotations

import functools
import importlib
import pkgutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import filterfalse
from typing import Any, NamedTuple

from rattle import registry
from rattle.description.model import is_ground
from rattle.drawings.arrows import draw_forces
from rattle.drawings.magnified import draw_magnified
from rattle.drawings.sheet import Part, Sheet

Draw = Callable[[Sheet, Part], None]


class Drawing(NamedTuple):
    """How a form is drawn."""

    draw: Draw
    name_at: float  # place of its name: 0 at the point on A, 1 at that on B


_known: dict[str, Drawing] = {}


def drawing(name: str, *, name_at: float = 0.5) -> Callable[[Draw], Draw]:
    """Decorator: the function draws joints or loads whose kind says drawn_as = name; arguments as in `Drawing`."""

    def enter(draw: Draw) -> Draw:
        _known[name] = Drawing(draw, name_at)
        return draw

    return enter


@functools.cache
def drawings() -> Mapping[str, Drawing]:
    """All forms by name."""
    for module in pkgutil.iter_modules(__path__):
        importlib.import_module(f"{__name__}.{module.name}")
    return _known


def form_of(family: str, kind: str) -> str:
    """The form as which a kind of joint or load is drawn; "" if it is not, or not known."""
    kinds = registry.kinds(family)
    return str(getattr(kinds[kind].leaf, "drawn_as", "")) if kind in kinds else ""


def drawing_of(family: str, kind: str) -> Drawing | None:
    """How a kind of joint or load is drawn; None if it is not, or not known."""
    return drawings().get(form_of(family, kind))


def parts(sheet: Sheet) -> Iterator[tuple[Part, Drawing]]:
    """All joints and loads that are drawn."""
    for family in ("joint", "load"):
        for name, form in sheet.geometry[f"{family}s"].items():
            how = drawing_of(family, form["type"])
            if how is not None:
                yield Part(sheet, name, family, form, name in sheet.geometry["driven"]), how


def display_list(geometry: Mapping[str, Any]) -> dict[str, Any]:
    """All primitives of a mechanism as plain data, from the geometry of a result; those over it by layers."""
    sheet = Sheet(geometry)
    for part, how in parts(sheet):
        sheet.hold(part.bodies[0], part.point(0))
        sheet.hold(part.bodies[1], part.point(1))
        how.draw(sheet, part)
    sheet.bodies()
    _add_layers(sheet)
    return sheet.written()


def _add_layers(sheet: Sheet) -> None:
    """Arrows of forces, names, and what is magnified."""
    geometry = sheet.geometry
    every = [
        Part(sheet, name, family, form, name in geometry["driven"])
        for family in ("joint", "load")
        for name, form in geometry[f"{family}s"].items()
    ]
    drivers = geometry.get("drivers", {})
    layers = sheet.layers
    layers["arrows"] = sheet.apart(lambda: layers.update(scales=draw_forces(sheet, every, drivers)))
    loose = [(part, play) for part in every if part.family == "joint" and (play := play_of(part.form))]
    layers["pins"] = sheet.apart(lambda: _name_pins(part for part, play in loose if play == "circle"))
    layers["names"] = sheet.apart(lambda: _name_bodies(sheet))
    layers["magnified"] = draw_magnified(sheet, loose)


def play_of(form: Mapping[str, Any]) -> str:
    """What the play of a joint looks like: `circle`, `walls`, or `slot` for a pin between walls; "" without play."""
    play = registry.play_of(form["type"])
    if play is None or form.get("contact", "") in ("", "ideal"):
        return ""
    return "circle" if play.leaf.orbit else "slot" if form_of("joint", form["type"]) == "slot" else "walls"


def _name_pins(pins: Iterable[Part]) -> None:
    for part in pins:
        part.sheet.text(part.bodies[0], part.point(0), part.name, bold=True, when=part.number("clearance"))


def _name_bodies(sheet: Sheet) -> None:
    for body in filterfalse(is_ground, sheet.geometry["bodies"]):
        sheet.text(body, (0.0, 0.0), body, line=f"body {body}")
