"""How ensembles, sweeps and tolerances ask it of each sample."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np

from rattle.results.result import Result
from rattle.studies.runs.analyses import Analysis, Stepping, complete, names_from

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism


def _at_rest(m: Mechanism, times: np.ndarray, names: Collection[str], how: Stepping) -> Result:
    return complete(m.equilibrium(times))


ANALYSIS = Analysis(_at_rest, names_from(_at_rest), 200, at_rest=True)
