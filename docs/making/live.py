"""A live page of every shipped example that can be computed in a browser, and a replay of every other one."""

from __future__ import annotations

from html import escape
from pathlib import Path

import rattle as rt
from making.runs import run
from making.tree import module_with

FOLDER = Path("beside") / "live"  # copied as it is: live/NAME.html
FRONT = "front"  # the page on the front: `rattle page crank_rocker_play`


def pages(folder: Path) -> dict[str, str]:
    """Writes the pages into `folder`/beside/live; nothing is included by other pages."""
    (folder / FOLDER).mkdir(parents=True, exist_ok=True)
    rt.example("crank_rocker_play").page(folder / FOLDER / f"{FRONT}.html")
    for name in rt.examples():
        path = folder / FOLDER / f"{name}.html"
        try:
            scene = module_with("live_scene").live_scene(rt.example(name))
        except module_with("TraceError").TraceError:
            run(name).result.animate(path)
        else:
            module_with("write_page").write_page(scene, path)
    return {}


def opened(name: str, up: str = "") -> str:
    """The page of an example in a frame that is loaded when it is opened, as HTML in Markdown; up: way to the root."""
    frame = f'<iframe src="{up}live/{name}.html" title="{escape(name)} in motion" loading="lazy"></iframe>'
    alone = f'<a href="{up}live/{name}.html">in a window of its own</a>'
    return f'```{{raw}} html\n<details class="live"><summary>See it move</summary>{frame}<p>{alone}</p></details>\n```'
