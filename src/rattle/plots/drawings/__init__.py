"""Pictures of joints and loads, one form per file: a kind names its form as `drawn_as`, and is drawn so everywhere.

A new form is a file with one function,

    @drawing("wheel")
    def wheel(ax, scene, part): ...

It draws the part at all frames of the scene (see `rattle.plots.scene`), and returns functions that move what it drew to
frame k.  `part.form` is its entry in the geometry of a result: bodies, points, axis, fields and so on.
"""

from __future__ import annotations

import functools
import importlib
import pkgutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from rattle import registry
from rattle.plots.movie_file import Update
from rattle.plots.scene import Pair, Scene

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Form = Mapping[str, Any]


class Part(NamedTuple):
    """A joint or load that is drawn."""

    name: str
    family: str  # joint or load
    form: Form  # its entry in the geometry of the result
    driven: bool  # a driver moves it


Draw = Callable[["Axes", Scene, Part], list[Update]]
Reach = Callable[[Form], Iterable[tuple[str, Pair]]]  # bodies, and points of their frames [m]
Bodies = Callable[[Scene, Form], Iterable[str]]
Holds = Callable[[Scene, Form], Iterable[tuple[str, Pair]]]


class Drawing(NamedTuple):
    """How a form is drawn."""

    draw: Draw
    reach: Reach  # what must be inside the picture
    instead_of: Bodies  # bodies that it draws itself
    name_at: float  # place of its name: 0 at the point on A, 1 at that on B
    holds: Holds  # bodies, and points of their frames [m] up to which they are drawn: both ends of a slot


def ends(form: Form) -> list[tuple[str, Pair]]:
    """The two points of a joint or load."""
    return [(body, tuple(point)) for body, point in zip(form["bodies"], form["points"], strict=True)]


def none(scene: Scene, form: Form) -> tuple[str, ...]:
    """Draws no body itself."""
    return ()


def nothing(scene: Scene, form: Form) -> tuple[tuple[str, Pair], ...]:
    """No body is larger because of it."""
    return ()


_known: dict[str, Drawing] = {}


def drawing(
    name: str, *, reach: Reach = ends, instead_of: Bodies = none, name_at: float = 0.5, holds: Holds = nothing
) -> Callable[[Draw], Draw]:
    """Decorator: the function draws joints or loads whose kind says drawn_as = name; arguments as in `Drawing`."""

    def enter(draw: Draw) -> Draw:
        _known[name] = Drawing(draw, reach, instead_of, name_at, holds)
        return draw

    return enter


@functools.cache
def drawings() -> Mapping[str, Drawing]:
    """All forms by name."""
    for module in pkgutil.iter_modules(__path__):
        importlib.import_module(f"{__name__}.{module.name}")
    return _known


def drawing_of(family: str, kind: str) -> Drawing | None:
    """How a kind of joint or load is drawn; None if it is not, or not known."""
    known = registry.kinds(family)
    return drawings().get(getattr(known[kind].leaf, "drawn_as", "")) if kind in known else None


def parts(geometry: Mapping[str, Any]) -> Iterator[tuple[Part, Drawing]]:
    """All joints and loads that are drawn."""
    for family in ("joint", "load"):
        for name, form in geometry[f"{family}s"].items():
            found = drawing_of(family, form["type"])
            if found is not None:
                yield Part(name, family, form, name in geometry["driven"]), found
