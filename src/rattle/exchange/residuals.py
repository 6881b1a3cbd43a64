"""What a measured curve differs from that of a run: measured minus computed, at the measured times within the run.

Between its outputs the curve of a run is that of `sampled_curve`: smooth, but for events, at which it may jump.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rattle.errors import InputError
from rattle.exchange.measured import Measured, measured_curves
from rattle.results.result import Result
from rattle.results.sampled_curve import SampledCurve

Array = NDArray[np.float64]
Source = str | Path  # a measured curve, as `measured` reads it
EDGE = 1e-9  # share of the run by which a measured time may lie outside of it by rounding


@dataclass(frozen=True, eq=False)
class Residual:
    """A measured curve within a run, and how far it is from the curve that was computed; SI units."""

    measured: Measured
    unit: str
    t: Array  # (m,) the measured times within the run [s]
    values: Array  # (m,) measured
    residual: Array  # (m,) measured minus computed

    @property
    def curve(self) -> str:
        """The name of the curve of the run."""
        return self.measured.curve

    @property
    def count(self) -> int:
        """How many values were measured, those outside of the run too."""
        return len(self.measured.t)

    @property
    def _within(self) -> np.ndarray:
        """Values of the residual where the run has one."""
        return self.residual[np.isfinite(self.residual)]

    @property
    def rms(self) -> float:
        """Root mean square of the residual over the measured values within the run; nan without any."""
        within = self._within
        return float(np.sqrt(np.mean(within * within))) if len(within) else math.nan

    @property
    def largest(self) -> float:
        """Largest magnitude of the residual; nan without any."""
        return float(np.abs(self._within).max(initial=0.0)) if len(self._within) else math.nan

    def told(self, factor: float = 1.0, unit: str | None = None) -> list[str]:
        """How far it is, in words; factor: from SI to `unit`, default: in SI."""
        part = [] if len(self.t) == self.count else [f"{len(self.t)} of {self.count} values within the run"]
        return [f"rms of the difference {factor * self.rms:.3g} {self.unit if unit is None else unit}".rstrip(), *part]

    def __repr__(self) -> str:
        return f"<rattle.Residual: {self.measured.label} beside {self.curve}, rms {self.rms:.3g} {self.unit}>"


def residuals(
    result: Result, wanted: Source | Iterable[Source | Residual], shown: Sequence[str] = ()
) -> tuple[Residual, ...]:
    """`Result.residuals`; what is a residual already stays."""
    units = {name: result.unit(name) for name in result.names}
    for name in shown:
        result.unit(name)
    listed: list[Residual] = []
    for source in [wanted] if isinstance(wanted, str | Path) else wanted:
        if isinstance(source, Residual):
            listed.append(source)
        else:
            listed += [residual_of(result, curve) for curve in measured_curves(source, units, shown)]
    return tuple(listed)


def residual_of(result: Result, measured: Measured) -> Residual:
    """The residual of one measured curve.  Raises InputError if none of its times is within the run."""
    whole = result.with_breaks
    start, end = (float(whole.t[0]), float(whole.t[-1])) if len(whole.t) else (0.0, -1.0)
    slack = EDGE * max(end - start, 0.0)
    within = (measured.t >= start - slack) & (measured.t <= end + slack)
    if not within.any():
        times = f"{measured.t[0]:g} to {measured.t[-1]:g} s"
        raise InputError(
            f"{measured.file}: none of the times of {measured.column}, {times}, is within the run, {start:g} to {end:g}"
            " s; an offset such as @0.2s moves them"
        )
    t, values = np.clip(measured.t[within], start, end), measured.values[within]
    computed = SampledCurve(whole.t, whole[measured.curve]).through(t)
    return Residual(measured, result.unit(measured.curve), t, values, values - computed)
