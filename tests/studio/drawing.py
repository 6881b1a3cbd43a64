"""A hand on the sheet of the studio, in metres of the ground plane: mouse and finger, waiting for what they do."""

from __future__ import annotations

import itertools
import math
import tomllib
from typing import Any

import rattle as rt
from browsing import becomes, frames

EMPTY = "# a sheet of Monday\nformat = 1\ngravity = [0, -9.81]   # keep me\n"
STEP = 0.02  # between places that tests draw at: at least 12 pixels on every screen [m]


class Hand:
    """The hand of one page that draws."""

    def __init__(self, page: Any, touch: bool = False) -> None:
        self.page, self.touch = page, page.context.new_cdp_session(page) if touch else None
        self.acts = 0
        if page.locator(".edit-button").get_attribute("aria-pressed") != "true":
            page.get_by_role("button", name="Edit", exact=True).click()
        self.rests()
        frames(page)

    # ------------------------------------------------------------ what the page shows
    @property
    def text(self) -> str:
        return str(self.page.evaluate("window.rattle.edit.text"))

    @property
    def table(self) -> dict[str, Any]:
        return tomllib.loads(self.text)

    @property
    def status(self) -> str:
        return str(self.page.locator(".edit-foot .freedoms").text_content())

    @property
    def word(self) -> str:
        return str(self.page.locator(".edit-foot .word").text_content())

    def screen(self, spot: tuple[float, float]) -> tuple[float, float]:
        x, y = self.page.evaluate("(spot) => window.rattle.edit.toScreen(spot)", list(spot))
        return x, y

    def position(self, point: str) -> tuple[float, float]:
        x, y = self.page.evaluate("(point) => window.rattle.edit.position(point)", point)
        return x, y

    def becomes_text(self, before: str) -> str:
        """Wait for another text, and for the drawing of it; that text."""
        becomes(self.page, "(before) => window.rattle.edit.text !== before", before)
        self.rests()
        return self.text

    def rests(self) -> None:
        """Wait until the drawing is that of the text."""
        becomes(self.page, "document.querySelector('.board .above').getAttribute('aria-busy') === 'false'")

    def says(self, words: str) -> None:
        becomes(self.page, "(words) => document.querySelector('.edit-foot').innerText.includes(words)", words)

    # ------------------------------------------------------------ acts
    def take(self, tool: str) -> None:
        self.page.get_by_role("button", name=tool, exact=True).click()

    def click(self, spot: tuple[float, float]) -> None:
        self.drag(spot)

    def drag(self, *spots: tuple[float, float]) -> None:
        """Press at the first place, let go at the last; with one place a click, or a tap."""
        if self.touch and len(spots) == 1:
            self.page.touchscreen.tap(*self.screen(spots[0]))
        elif self.touch:
            self._finger(*map(self.screen, spots))
        else:
            self.page.mouse.move(*self.screen(spots[0]))
            self.page.mouse.down()
            for spot in spots[1:]:
                self.page.mouse.move(*self.screen(spot), steps=4)
            self.page.mouse.up()

    def _finger(self, *places: tuple[float, float]) -> None:
        self.fingers("touchStart", places[0])
        for (x, y), (u, v) in itertools.pairwise(places):
            for share in (0.3, 0.6, 0.8, 1.0):
                self.fingers("touchMove", (x + share * (u - x), y + share * (v - y)))
        self.fingers("touchEnd")

    def fingers(self, kind: str, *places: tuple[float, float]) -> None:
        points = [{"x": x, "y": y, "id": k} for k, (x, y) in enumerate(places)]
        assert self.touch is not None
        self.touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

    def act(self, tool: str, *clicks: tuple[float, float], drag: bool = False) -> str:
        """One act of a tool: clicks, or one drag; the new text."""
        before = self.text
        self.take(tool)
        if drag:
            self.drag(*clicks)
        else:
            for spot in clicks:
                self.click(spot)
        self.acts += 1
        return self.becomes_text(before)

    def bar(self, first: tuple[float, float], last: tuple[float, float]) -> str:
        return self.act("Bar", first, last, drag=True)

    def field(self, name: str) -> Any:
        return self.page.locator(".edit-panel").get_by_label(name, exact=True)

    def type(self, name: str, value: str) -> str:
        before = self.text
        self.field(name).fill(value)
        self.field(name).press("Enter")
        self.acts += 1
        return self.becomes_text(before)

    def choose(self, name: str, value: str) -> str:
        before = self.text
        self.field(name).select_option(value)
        self.acts += 1
        return self.becomes_text(before)

    def undo(self) -> str:
        before = self.text
        self.page.keyboard.press("Control+z")
        return self.becomes_text(before)

    def undo_all(self) -> str:
        """Undo every act of this hand; the text then."""
        for _ in range(self.acts):
            self.undo()
        self.acts = 0
        return self.text


def run(text: str, end: float = 0.2) -> rt.Result:
    result = rt.loads(text).simulate(end)
    assert result.success, result.message
    return result


def at(x: float, y: float) -> tuple[float, float]:
    """A place in steps."""
    return x * STEP, y * STEP


def apart(p: tuple[float, float], q: tuple[float, float]) -> float:
    return math.dist(p, q)
