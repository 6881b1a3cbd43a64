"""How ensembles, sweeps and tolerances ask it of each sample."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np

from rattle.results.result import Result
from rattle.studies.runs.analyses import Analysis, Stepping, names_from

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism


def _positions(m: Mechanism, times: np.ndarray, names: Collection[str], how: Stepping) -> Result:
    return m.kinematics(times, strict=True)


ANALYSIS = Analysis(_positions, names_from(_positions), 2000)
