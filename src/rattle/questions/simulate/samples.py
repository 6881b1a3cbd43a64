"""How ensembles, sweeps and tolerances ask it of each sample."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np

from rattle.analyses.straight_line.derived_curves import derived_units
from rattle.errors import SolverError
from rattle.results.columns import columns, width
from rattle.results.result import Result
from rattle.studies.runs.analyses import Analysis, Stepping, given_up, steps_at_most

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism


def _simulated(m: Mechanism, times: np.ndarray, names: Collection[str], how: Stepping) -> Result:
    most = steps_at_most(m, how)
    try:
        return m.simulate(
            float(times[-1]), t_eval=times, method=how.method, rtol=how.rtol, atol=how.atol, step=how.step, strict=True,
            most_steps=most,
        )  # fmt: skip
    except SolverError as error:
        if error.result.interrupted:  # the user stops all samples
            raise KeyboardInterrupt from None
        if most is not None and error.result.stats["steps"] >= most:
            raise SolverError(given_up(most), error.result) from None
        raise


def _names_of_motion(m: Mechanism) -> dict[str, str]:
    _, names, units = columns(m.system, np.zeros((1, width(m.system))))
    derived = derived_units(m.model, names)
    return {name: units[name] for name in names} | derived


ANALYSIS = Analysis(_simulated, _names_of_motion, 2000)
