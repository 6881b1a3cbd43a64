"""The page of one session: a Panel component around the desk, and the sheets of its tabs."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any

import panel as pn
import param
from bokeh.core.validation import silence
from bokeh.core.validation.warnings import EMPTY_LAYOUT
from panel.custom import Child, JSComponent

from rattle.pages.viewer_text import joined, viewer_text
from rattle.studio.desk import Desk, Message
from rattle.studio.sheets import sheet
from rattle.studio.tabs import TABS, forms

silence(EMPTY_LAYOUT, True)  # a tab is empty until it is opened

HERE = Path(__file__).parent / "page"
HEAD = """{% block postamble %}
    <meta name="viewport" content="width=device-width, initial-scale=1">
{% endblock %}
"""  # into the page of Panel: without it a phone lays the page out for 980 px and shrinks it
aside = ThreadPoolExecutor(8, "studio")  # reads texts and files for all sessions: no page waits for another


@cache
def page_text() -> str:
    """The scripts of the page as one ES module."""
    files = {one.name: one.read_text(encoding="utf-8") for one in HERE.glob("*.js")}
    return joined(files, "main.js")


class Studio(JSComponent):
    """The whole page; what tabs show is inside of it as children.

    style: its style sheet.  viewer: the viewer as the text of an ES module.  tabs: what the page knows of each tab.
    """

    style = param.String()
    viewer = param.String()
    tabs = param.List()

    vars().update({tab: Child() for tab in TABS})

    _esm = page_text()

    def __init__(self, make_desk: Callable[..., Desk], **params: Any) -> None:
        sheets = {tab: pn.Column(sizing_mode="stretch_width", margin=0) for tab in TABS}
        super().__init__(
            style=(HERE / "studio.css").read_text(encoding="utf-8"), viewer=viewer_text(), tabs=forms(),
            sizing_mode="stretch_both", margin=0, **sheets, **params,
        )  # fmt: skip
        self._document = pn.state.curdoc
        self._document.template = HEAD
        self._sheets = sheets
        self._content: dict[str, Message] = {}
        self._dark = self._narrow = False
        self.desk = make_desk(send=self._tell, later=self._later, post=self._post)
        pn.state.on_session_destroyed(lambda context: self.desk.end())

    # ------------------------------------------------------------ from the page
    def _handle_msg(self, data: Any) -> None:
        """A message of the page; Panel calls this."""
        if isinstance(data, dict) and data.get("do") == "look":
            self._dark, self._narrow = bool(data.get("dark")), bool(data.get("narrow"))
            for tab, content in self._content.items():
                self._show(tab, content)
            return
        self.desk.hear(data)

    # ------------------------------------------------------------ to the page
    def _tell(self, message: Message) -> None:
        if message.get("kind") == "tab" and message.get("state") == "done" and message["tab"] in TABS:
            tab, content = message["tab"], message["value"]
            if "blocks" in content:  # of what is no report
                self._content[tab] = content
                self._show(tab, content)
            message = {**message, "value": {key: one for key, one in content.items() if key != "blocks"}}
        elif message.get("kind") == "text" and message.get("fresh"):
            self._content.clear()
            for column in self._sheets.values():
                column.objects = []
        self._send_msg(message)

    def _show(self, tab: str, content: Message) -> None:
        self._sheets[tab].objects = sheet(
            content, self._dark, lambda picked: self.desk.hear({"do": "pick", **picked}), self._narrow
        )

    # ------------------------------------------------------------ threads
    def _post(self, call: Callable[[], None]) -> None:
        """Have a function called in the thread of the page; callable from any thread."""
        if not self.desk.bench.ended:
            self._document.add_next_tick_callback(call)

    def _later(self, function: Callable[[], Any], then: Callable[[Any], None]) -> None:
        """Have a function called aside, and then the other with what it returned."""
        aside.submit(function).add_done_callback(lambda done: self._post(lambda: then(done.result())))
