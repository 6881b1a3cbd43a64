"""A page that shows one result, or several: a single file, no network, no server."""

from __future__ import annotations

import html
import math
import os
from collections.abc import Iterable, Mapping
from typing import Any

from rattle.atomic_file import atomic
from rattle.errors import InputError
from rattle.pages.ghost import ghost_of
from rattle.pages.packed import lettered
from rattle.pages.scene import require_motion, scene_json, scene_of
from rattle.pages.viewer_text import joined, viewer_files, viewer_text
from rattle.pages.wishes import AS_USUAL, Wishes
from rattle.pages.words import ENGLISH, words_in
from rattle.plots.orbit import require_point
from rattle.results.result import Result
from rattle.value_types import Tree

# nothing may be asked for from outside: a browser then refuses what a mistake would load; scripts that test the page
# may evaluate expressions in it
POLICY = "default-src 'unsafe-inline' 'unsafe-eval' data: blob:"
PAGE = """<!DOCTYPE html>
<html lang="{language}">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="generator" content="{program}">
<title>{title}</title>
<link rel="icon" href="data:,">
<style>html, body {{ margin: 0; height: 100%; }} #rattle {{ min-height: 100%; }}</style>
</head>
<body>
<div id="rattle"></div>
<script>window.rattle = undefined; // until it is there: a browser would give the element of that name</script>
<noscript>{silent}</noscript>
<script type="application/json" id="scene">{scene}</script>
<script type="module">
{viewer}
const scene = JSON.parse(document.getElementById("scene").textContent);
window.rattle = mount(document.getElementById("rattle"), scene, {host});
</script>
</body>
</html>
"""

SILENT = "This page shows a motion: it needs JavaScript, which is switched off here."
# the viewer of a page that computes, compressed: such a page needs a browser that can unpack anyway
UNPACKED = """@unpack@async function unpackedViewer(letters) {
  const text = await unpackedText(letters);
  return import(URL.createObjectURL(new Blob([text], { type: "text/javascript" })));
}
const { mount } = await unpackedViewer("@letters@").catch((error) => {
  document.getElementById("rattle").textContent = `This page cannot be shown: ${error.message}`;
  throw error;
});"""
UNPACK = "unpack.js"


def replay(
    result: Result, path: str | os.PathLike[str], *, trace: Iterable[str] = (), names: bool = False,
    speed: float | None = None, ideal: Result | None = None, wishes: Wishes = AS_USUAL,
) -> None:  # fmt: skip
    """Write the page of one result.

    trace: names of points ("coupler.P") whose paths are drawn at first.  names: bodies are labelled at first.
    speed: of the animation relative to the motion, at first.  ideal: the same mechanism without play, as a ghost.
    Raises InputError for a result without motion, UnknownName for an unknown point, OSError.
    """
    show: dict[str, Any] = {"traces": list(trace), "names": names, "speed": speed}
    for point in show["traces"]:
        require_point(result, point)
    scene = scene_of([("", result)], ideal=ideal, show=show)
    write_page(wishes.of(scene), path)


def animate(
    result: Result, path: str | os.PathLike[str], *, trace: Iterable[str], names: bool, speed: float | None,
    wishes: Wishes, film: Mapping[str, bool],
) -> None:  # fmt: skip
    """`Result.animate` for a page; film: settings that only .gif and .mp4 have, and whether they were given."""
    if asked := [key for key, is_given in film.items() if is_given]:
        raise InputError(f"{', '.join(asked)}: only .gif and .mp4 have this; a page plays all instants, leave it out")
    if speed is not None and not 0.0 < speed < math.inf:
        raise InputError(f"speed must be positive and finite, got {speed:g}")
    require_motion(result)
    replay(result, path, trace=trace, names=names, speed=speed, ideal=ghost_of(result), wishes=wishes)


def write_page(scene: Tree, path: str | os.PathLike[str]) -> None:
    """Write a scene with the viewer as one HTML file. Raises OSError."""
    text = page_text(scene)
    with atomic(path) as file:
        file.write_text(text, encoding="utf-8")


def page_text(scene: Tree) -> str:
    """A scene with the viewer as the text of one HTML file."""
    text, language = viewer_text(), scene.get("language", ENGLISH)
    viewer = _unpacked(text) if scene["live"] else text.replace("</script", "<\\/script")
    return PAGE.format(
        policy=html.escape(POLICY), program=html.escape(str(scene["program"])), title=html.escape(str(scene["title"])),
        scene=scene_json(scene), viewer=viewer, host="{ page: true }", language=language,
        silent=words_in(language).get(SILENT, SILENT),
    )  # fmt: skip


def _unpacked(viewer: str) -> str:
    """A script that unpacks the viewer."""
    unpack = joined(viewer_files(), UNPACK).replace("export ", "")
    return UNPACKED.replace("@unpack@", unpack).replace("@letters@", lettered(viewer))
