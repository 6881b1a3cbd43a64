"""How ensembles, sweeps and tolerances ask it of each sample."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np

from rattle.results.result import Result
from rattle.studies.runs.analyses import Analysis, Stepping, names_from, table_of

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism
    from rattle.questions.modes.compute import Modes

MODE = {"frequency": "Hz", "damping": "", "growth": "1/s"}  # of a mode, see `Modes`


def _vibrations(m: Mechanism, times: np.ndarray, names: Collection[str], how: Stepping) -> Result:
    return modes_table(m, times, [m.modes(t) for t in times.tolist()], names)


def modes_table(m: Mechanism, times: np.ndarray, modes: Sequence[Modes], names: Collection[str] = ()) -> Result:
    """Frequencies, damping and growth of modes at instants (n,) [s] as curves; names: that have to be among them."""
    rows: list[dict[str, float]] = []
    units: dict[str, str] = {}
    for answer in modes:
        values = {"frequency": answer.frequency, "damping": answer.damping, "growth": answer.growth}
        rows.append({f"mode{n + 1}.{key}": float(values[key][n]) for n in range(len(answer)) for key in MODE})
        units |= {f"mode{n + 1}.{key}": unit for n in range(len(answer)) for key, unit in MODE.items()}
    units |= {name: "" for name in names if name not in units}  # a mode that this sample has not
    data = np.array([[row.get(name, np.nan) for name in units] for row in rows])
    return table_of(m, "modes", times, data, units)


ANALYSIS = Analysis(_vibrations, names_from(_vibrations), 200, at_rest=True)
