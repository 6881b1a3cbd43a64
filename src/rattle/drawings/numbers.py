"""Numbers of a drawing as functions of what changes: dimensions of the model, the motion as a whole, the bodies now.

A `Number` is an entry of a tape: a list of nodes of which each names earlier ones by their place, ready for JSON.

    0.5                     a constant
    ["+", 3, 0]             an operation on two other nodes, see OPERATIONS
    ["of", "joints", "A", "points", 0, 1]     a number of the geometry, by its place there
    ["size"]                of the mechanism [m]; ["pixel"], and ["side"], the shorter one: of the picture [m]
    ["x", "crank", 3, 4]    where a point of a body's frame is now, and so "y"; ["angle", "crank"] its angle
    ["curve", "A.locked"]   a curve now, 0 where there is none; ["pin", "A.ex"]: of the place of a pin, along its arc
    ["least", 7]            over all instants, and so "most"; ["first", 7]: at the first
    ["usual", 3, 7, 8]      size that this share (3) of what these are at all instants does not exceed; if 0 the largest

`viewer/values.js` evaluates the same tapes in pages.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Node = float | list[Any]

OPERATIONS: Mapping[str, Callable[..., Any]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.divide,
    "<": lambda a, b: np.where(np.less(a, b), 1.0, 0.0),
    "min": np.minimum,
    "max": np.maximum,
    "abs": np.abs,
    "sin": np.sin,
    "cos": np.cos,
    "acos": lambda a: np.arccos(np.clip(a, -1.0, 1.0)),
    "atan2": np.arctan2,
    "hypot": np.hypot,
    "ceil": np.ceil,
    "round": np.round,
    "nice": lambda a: nice_step(a),
    "if": lambda a, b, c: np.where(np.greater(a, 0.0), b, c),
}
PIXELS = 420.0  # across a mechanism: a usual size of a picture, in which marks and bars have these widths
NICE = 1.0, 2.0, 5.0, 10.0
OVER_TIME: Mapping[str, Callable[[Any], Any]] = {"least": np.nanmin, "most": np.nanmax, "first": lambda a: a.flat[0]}


class Tape:
    """Nodes in the order of their making; equal ones are one."""

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self._places: dict[str, int] = {}

    def place(self, node: Node) -> int:
        """Where a node stands, entered if it is new."""
        key = repr(node)
        if key not in self._places:
            self._places[key] = len(self.nodes)
            self.nodes.append(node)
        return self._places[key]

    def node(self, operation: str, *entries: str | int | float | Number) -> Number:
        """A number that follows from others; texts, and whole numbers beside them, stay as they are."""
        places = [entry if isinstance(entry, str) or operation == "of" else self.of(entry) for entry in entries]
        return Number(self, self.place([operation, *places]))

    def of(self, value: Value) -> int:
        """The place of a number or a constant."""
        return value.place if isinstance(value, Number) else self.place(float(value))


class Number:
    """A number of a drawing that follows from what changes."""

    __slots__ = ("place", "tape")

    def __init__(self, tape: Tape, place: int) -> None:
        self.tape, self.place = tape, place

    def __add__(self, other: Value) -> Number:
        return self.tape.node("+", self, other)

    def __radd__(self, other: Value) -> Number:
        return self.tape.node("+", other, self)

    def __sub__(self, other: Value) -> Number:
        return self.tape.node("-", self, other)

    def __rsub__(self, other: Value) -> Number:
        return self.tape.node("-", other, self)

    def __mul__(self, other: Value) -> Number:
        return self.tape.node("*", self, other)

    def __rmul__(self, other: Value) -> Number:
        return self.tape.node("*", other, self)

    def __truediv__(self, other: Value) -> Number:
        return self.tape.node("/", self, other)

    def __rtruediv__(self, other: Value) -> Number:
        return self.tape.node("/", other, self)

    def __neg__(self) -> Number:
        return self.tape.node("-", 0.0, self)

    def __abs__(self) -> Number:
        return self.tape.node("abs", self)

    def __lt__(self, other: Value) -> Number:
        """1 where it is less, 0 elsewhere."""
        return self.tape.node("<", self, other)

    def __gt__(self, other: Value) -> Number:
        """1 where it is more, 0 elsewhere."""
        return self.tape.node("<", other, self)


Value = Number | float


def call(operation: str, *values: Value) -> Number:
    """An operation on values of which one at least is a `Number`."""
    tape = next(value.tape for value in values if isinstance(value, Number))
    return tape.node(operation, *values)


def sin(angle: Value) -> Value:
    """Sine."""
    return call("sin", angle) if isinstance(angle, Number) else math.sin(angle)


def cos(angle: Value) -> Value:
    """Cosine."""
    return call("cos", angle) if isinstance(angle, Number) else math.cos(angle)


def least_of(first: Number, *more: Value) -> Number:
    """The least of several values."""
    for value in more:
        first = call("min", first, value)
    return first


def most_of(first: Number, *more: Value) -> Number:
    """The largest of several values."""
    for value in more:
        first = call("max", first, value)
    return first


# ---------------------------------------------------------------- their values
def nice_step(least: Any) -> float:
    """1, 2 or 5 times a power of ten, no less than this; 1 where that is not positive."""
    size = float(least)
    if not 0.0 < size < math.inf:
        return 1.0
    power = 10.0 ** math.floor(math.log10(size) + 1e-12)
    return power * next(step for step in NICE if step * power >= size * (1.0 - 1e-9))


def usual_size(share: float, values: Iterable[Any]) -> float:
    """The size that this share of all finite values does not exceed; the largest where that is 0."""
    sizes = np.sort(np.abs(np.concatenate([np.zeros(0), *(np.ravel(each) for each in values)])))
    sizes = sizes[np.isfinite(sizes)]
    if not len(sizes):
        return 0.0
    return float(sizes[min(len(sizes) - 1, int(share * len(sizes)))] or sizes[-1])


class Moving(Protocol):
    """Where the bodies of a drawing are, at all of its frames."""

    def at(self, body: str, x: Any, y: Any) -> tuple[Any, Any]: ...

    def angle(self, body: str) -> Any: ...

    def curve(self, name: str) -> Any: ...

    def trail(self, joint: str, share: float) -> Any: ...


class Values:
    """Values of the nodes of a tape: floats, or (frames,) arrays of those that move."""

    def __init__(self, nodes: list[Node], geometry: Mapping[str, Any], moving: Moving, size: float,
                 across: float = PIXELS) -> None:  # fmt: skip
        """size: of the mechanism [m], which is so many pixels across."""
        self.nodes, self.geometry, self.moving, self.size, self.across = nodes, geometry, moving, size, across
        self._known: dict[int, Any] = {}

    def __getitem__(self, place: int) -> Any:
        if place not in self._known:
            self._known[place] = self._value(self.nodes[place])
        return self._known[place]

    def _value(self, node: Node) -> Any:
        if not isinstance(node, list):
            return node
        name, *rest = node
        if name in OPERATIONS:
            with np.errstate(divide="ignore", invalid="ignore"):
                return OPERATIONS[name](*(self[place] for place in rest))
        if name in OVER_TIME:
            return float(OVER_TIME[name](np.asarray(self[rest[0]])))
        if name == "of":
            return number_at(self.geometry, rest)
        if name == "usual":
            return usual_size(self[rest[0]], (self[place] for place in rest[1:]))
        if name in ("size", "side"):
            return self.size
        if name == "pixel":
            return self.size / self.across
        if name == "angle":
            return self.moving.angle(rest[0])
        if name in ("curve", "pin"):
            return self.moving.curve(rest[0])
        body, x, y = rest
        return self.moving.at(body, self[x], self[y])["xy".index(name)]


def number_at(geometry: Mapping[str, Any], place: list[Any]) -> Any:
    """What stands at a place of the geometry."""
    value: Any = geometry
    for key in place:
        value = value[key]
    return value
