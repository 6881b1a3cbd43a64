"""How ensembles, sweeps and tolerances ask it of each sample."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np

from rattle.results.result import Result
from rattle.studies.runs.analyses import Analysis, Stepping, table_of

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.accuracy.compute import Accuracy

BANDS = ("nominal", "low", "high", "worst", "rss")  # of an output with play, see `Accuracy`


def _bands(m: Mechanism, times: np.ndarray, names: Collection[str], how: Stepping) -> Result:
    """Bands of all outputs whose names are asked for."""
    of = sorted({name.rpartition(".")[0] for name in names})
    curves: dict[str, np.ndarray] = {}
    units: dict[str, str] = {}
    for output in of:
        extremes = any(f"{output}.{key}" in names for key in ("low", "high"))
        accuracy: Accuracy = m.accuracy(output, times, extremes=extremes, loaded=False)
        curves |= {f"{output}.{key}": getattr(accuracy, key) for key in BANDS}
        units |= {f"{output}.{key}": accuracy.unit for key in BANDS}
    data = np.array(list(curves.values())).T if curves else np.zeros((len(times), 0))
    return table_of(m, "accuracy", times, data, units)


def _names_of_bands(m: Mechanism) -> dict[str, str]:
    result = m.ideal().inverse_dynamics(np.zeros(1))
    return {f"{name}.{key}": result.unit(name) for name in result.names for key in BANDS}


ANALYSIS = Analysis(_bands, _names_of_bands, 200)
