"""What a bar or neck bears in a run, and how much of its life a run takes."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rattle.questions.durability.cases import Case
from rattle.questions.strength.answer import Strength
from rattle.questions.strength.compute import strengths


class Link(NamedTuple):
    """What one of them bears in one run; nan where it is not known."""

    load: float  # largest normal force [N]
    fatigue: float  # share of its life per time [1/s]
    safety: float
    notes: tuple[str, ...]


def links(case: Case) -> dict[str, Link]:
    """What every bar with section and material, and every neck, bears in the run of a case."""
    return {name: _link(case, strength) for name, strength in strengths(case.run).items()}


def _link(case: Case, strength: Strength) -> Link:
    life, safety = float(strength.life), float(strength.safety)
    used = math.inf if life == 0.0 else 1.0 / (life * case.duration)
    return Link(float(np.nanmax(np.abs(strength.normal))), used, safety, strength.remarks)
