"""The elements of an SVG file, without what XML can do beyond: no entities, nothing from elsewhere.

A DOCTYPE is let pass only where it is the plain one of SVG, which older programs write; it is not looked up.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NoReturn
from xml.parsers import expat

from rattle.exchange.refusal import refused

DEEPEST = 200  # elements in elements
MOST_ELEMENTS = 200_000
PLAIN = "-//W3C//DTD SVG"  # how the public name of the plain DOCTYPE begins
INKSCAPE = "http://www.inkscape.org/namespaces/inkscape"
SVG = ("http://www.w3.org/2000/svg", "")
Attributes = Mapping[str, str]


class Elements:
    """Goes through a file once: `begin` is called for elements of SVG and tells whether to go into them, then `end`."""

    def __init__(self, name: str, begin: Callable[[str, Attributes, int], bool], end: Callable[[], None]) -> None:
        """name: of the file; begin: of a kind, its attributes and its line."""
        self.name, self.begin, self.end = name, begin, end
        self.depth = self.count = 0
        self.passed = 0  # depth of an element that is passed over; 0: none
        self.parser: Any = expat.ParserCreate(encoding="utf-8", namespace_separator=" ")
        self.parser.StartDoctypeDeclHandler = self._doctype
        self.parser.EntityDeclHandler = lambda *_: self._refuse("it declares an entity; save it as plain SVG")
        self.parser.StartElementHandler, self.parser.EndElementHandler = self._start, self._finish

    def read(self, text: str) -> None:
        """Raises ModelError on what is no well-formed SVG."""
        try:
            self.parser.Parse(text.encode("utf-8", "replace"), True)
        except expat.ExpatError as error:
            raise refused(self.name, f"not a whole SVG: {expat.ErrorString(error.code)}", error.lineno) from None

    def _refuse(self, why: str) -> NoReturn:
        raise refused(self.name, why, self.parser.CurrentLineNumber)

    def _doctype(self, root: str, system: str | None, public: str | None, internal: int) -> None:
        if internal or root != "svg" or not (public or "").startswith(PLAIN):
            self._refuse("it has a DOCTYPE of its own; save it as plain SVG")

    def _start(self, kind: str, attributes: Attributes) -> None:
        self.depth += 1
        self.count += 1
        if self.depth > DEEPEST or self.count > MOST_ELEMENTS:
            self._refuse(f"more than {DEEPEST} elements in each other, or {MOST_ELEMENTS} in all")
        if self.passed:
            return
        space, _, own = kind.rpartition(" ")
        if space not in SVG or not self.begin(own, attributes, self.parser.CurrentLineNumber):
            self.passed = self.depth

    def _finish(self, kind: str) -> None:
        if not self.passed:
            self.end()
        elif self.passed == self.depth:
            self.passed = 0
        self.depth -= 1


def label_of(attributes: Attributes) -> tuple[str, bool]:
    """The name of a group and whether it is a layer of Inkscape."""
    layer = attributes.get(f"{INKSCAPE} groupmode") == "layer"
    return attributes.get(f"{INKSCAPE} label") or attributes.get("id", ""), layer


def is_hidden(attributes: Attributes) -> bool:
    """True if an element is not shown."""
    style = attributes.get("style", "").replace(" ", "")
    return attributes.get("display") == "none" or "display:none" in style
