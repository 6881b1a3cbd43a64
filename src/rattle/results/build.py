"""The one way to build a result: curves and findings, with the geometry and provenance of their model."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from numpy.typing import ArrayLike

from rattle.description.model import Model
from rattle.results.columns import geometry
from rattle.results.event import Breaks, Event, Peak
from rattle.results.result import Result
from rattle.results.trust import Trust
from rattle.value_types import Tree
from rattle.version import __version__

NOTHING_DRAWN: dict[str, Any] = {"bodies": {}, "ground": {"points": {}}, "joints": {}, "loads": {}, "driven": []}


def provenance(model: Model, analysis: str, **settings: Any) -> dict[str, Any]:
    """Provenance of a result: model and its parameters [SI], program, analysis and its settings."""
    return {
        "model": model.name,
        "program": f"rattle {__version__}",
        "analysis": analysis,
        **settings,
        "parameters": {name: parameter.value for name, parameter in model.parameters.items()},
    }


def build_result(
    model: Model, analysis: str, *, t: ArrayLike, data: ArrayLike, names: Iterable[str], units: Mapping[str, str],
    trust: Trust, stats: Tree | None = None, settings: Tree | None = None,
    events: Iterable[Event] = (), message: str = "", peaks: Mapping[str, Peak] | None = None,
    drawn: bool = True, breaks: Breaks | None = None,
) -> Result:  # fmt: skip
    """A result of a model; t (n,) [s], data (n, k) in SI units, the rest as in `Result`.

    message: why the analysis stopped early, "" if it did not.  drawn: False if the curves hold no motion from which
    the mechanism could be drawn, nor its points.
    """
    return Result(
        t=t, data=data, names=names, units=units, geometry=geometry(model) if drawn else NOTHING_DRAWN, trust=trust,
        stats=stats or {}, provenance=provenance(model, analysis, **(settings or {})), events=events,
        success=not message, message=message, peaks=peaks, breaks=breaks,
    )  # fmt: skip
