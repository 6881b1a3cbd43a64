"""rattle: planar mechanisms whose joints have play.

import rattle as rt
m = rt.load("fourbar.toml")
r = m.simulate(0.5)
r.plot("O3.normal", "O4.normal")
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from rattle.version import __version__

if TYPE_CHECKING:
    from rattle.catalogue.fits import fit
    from rattle.catalogue.oils import oil
    from rattle.elements.custom.contact_law import friction_law, normal_law
    from rattle.elements.custom.load_law import load_law
    from rattle.errors import AssemblyError, InputError, ModelError, SolverError
    from rattle.exchange.read import read
    from rattle.loading import example, examples, load, loads
    from rattle.mechanism import Mechanism
    from rattle.questions.film.bearing import Film
    from rattle.questions.strength.fatigue import rainflow
    from rattle.results.event import Event
    from rattle.results.result import Result, load_result
    from rattle.results.trust import Trust

_HOME = {
    "Mechanism": "mechanism", "load": "loading", "loads": "loading", "example": "loading",
    "examples": "loading", "read": "exchange.read",
    "InputError": "errors", "ModelError": "errors", "AssemblyError": "errors", "SolverError": "errors",
    "Result": "results.result", "Event": "results.event", "Trust": "results.trust", "load_result": "results.result",
    "load_law": "elements.custom.load_law", "normal_law": "elements.custom.contact_law",
    "friction_law": "elements.custom.contact_law", "Film": "questions.film.bearing",
    "fit": "catalogue.fits", "oil": "catalogue.oils", "rainflow": "questions.strength.fatigue",
}  # fmt: skip

__all__ = [
    "AssemblyError",
    "Event",
    "Film",
    "InputError",
    "Mechanism",
    "ModelError",
    "Result",
    "SolverError",
    "Trust",
    "__version__",
    "example",
    "examples",
    "fit",
    "friction_law",
    "load",
    "load_law",
    "load_result",
    "loads",
    "normal_law",
    "oil",
    "rainflow",
    "read",
]


def __getattr__(name: str) -> Any:  # heavy modules are imported when first used
    if name in _HOME:
        home = import_module(f"rattle.{_HOME[name]}")
        import_module("rattle.question").questions()  # those of one's own too are methods
        return getattr(home, name)
    raise AttributeError(f"module 'rattle' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted(__all__)
