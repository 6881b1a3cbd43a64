"""What a bar bears in a run, and how much of its life a run takes."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rattle.questions.durability.cases import Case
from rattle.questions.strength.compute import Strength, strengths


class Link(NamedTuple):
    """What one bar bears in one run; nan where it is not known."""

    load: float  # largest force along it [N]
    fatigue: float  # share of its life per time [1/s]
    safety: float
    notes: tuple[str, ...]


def links(case: Case) -> dict[str, Link]:
    """What every bar with section and material bears in the run of a case."""
    return {name: _link(case, strength) for name, strength in strengths(case.run).items()}


def _link(case: Case, strength: Strength) -> Link:
    life, safety = float(strength.life), float(strength.safety)
    used = math.inf if life == 0.0 else 1.0 / (life * case.duration)
    return Link(float(np.nanmax(np.abs(strength.normal))), used, safety, strength.remarks)
