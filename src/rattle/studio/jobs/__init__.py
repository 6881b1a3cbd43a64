"""The jobs that a session can have done, by name; each takes the shelf and plain data, and returns plain data."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rattle.studio.jobs import ensemble, live, motion, oil, power, report, sensitivity, statics, thumbnail

JOBS: dict[str, Callable[..., Any]] = {
    "motion": motion.motion,
    "trust": motion.trust,
    "live": live.live,
    "forces": motion.forces,
    "equilibrium": statics.equilibrium,
    "accuracy": statics.accuracy,
    "sensitivity": sensitivity.sensitivity,
    "ensemble": ensemble.ensemble,
    "sample": ensemble.sample,
    "power": power.power,
    "wear": oil.wear,
    "report": report.report,
    "thumbnail": thumbnail.thumbnail,
}
