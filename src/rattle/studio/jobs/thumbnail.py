"""A small drawing of a shipped example."""

from __future__ import annotations

from rattle.loading import example as load_example
from rattle.studio.shelf import Shelf


def thumbnail(shelf: Shelf, example: str) -> str:
    """A shipped example as a small SVG drawing, as it is put together.  Raises ModelError, AssemblyError."""
    from rattle.plots import thumbnail as drawing
    from rattle.results.build import build_result
    from rattle.results.trust import Trust

    m = load_example(example)
    keys = [f"{body}.{key}" for body in m.system.bodies for key in ("x", "y", "angle")]
    units = {key: "rad" if key.endswith("angle") else "m" for key in keys}
    result = build_result(
        m.model, "assembly", t=[0.0], data=m.start.q[None], names=keys, units=units, trust=Trust(drift=0.0)
    )
    return drawing.thumbnail(result, salt=example)
