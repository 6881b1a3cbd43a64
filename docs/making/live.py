"""A live page of every shipped example."""

from __future__ import annotations

from html import escape
from pathlib import Path

import rattle as rt

FOLDER = Path("beside") / "live"  # copied as it is: live/NAME.html
FRONT = "front"  # the page on the front: `rattle page slider_crank_play`


def pages(folder: Path) -> dict[str, str]:
    """Writes the pages into `folder`/beside/live; nothing is included by other pages."""
    (folder / FOLDER).mkdir(parents=True, exist_ok=True)
    rt.example("slider_crank_play").page(folder / FOLDER / f"{FRONT}.html")
    for name in rt.examples():
        rt.example(name).page(folder / FOLDER / f"{name}.html")
    return {}


def opened(name: str, up: str = "") -> str:
    """The page of an example in a frame that is loaded when it is opened, as HTML in Markdown; up: way to the root."""
    frame = f'<iframe src="{up}live/{name}.html" title="{escape(name)} in motion" loading="lazy"></iframe>'
    alone = f'<a href="{up}live/{name}.html">in a window of its own</a>'
    return f'```{{raw}} html\n<details class="live"><summary>See it move</summary>{frame}<p>{alone}</p></details>\n```'
