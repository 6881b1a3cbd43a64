"""The report of a model, as the page that `rattle report` writes."""

from __future__ import annotations

from rattle.pages.report import page_of
from rattle.pages.report_study import study
from rattle.studio.shelf import Shelf, Source
from rattle.value_types import Json


def report(shelf: Shelf, source: Source) -> dict[str, Json]:
    """The whole report as one HTML page."""
    gathered = study(shelf.mechanism(source), progress=True)
    if gathered.run is not None and gathered.run.interrupted:
        raise KeyboardInterrupt
    return {"told": "one page that prints well; the model, its checks, figures and numbers", "page": page_of(gathered)}
