"""The analyses of which samples may be asked: which names their results have, and how one is run.

| analysis | names inside of outputs |
|---|---|
| simulate, kinematics, inverse-dynamics, equilibrium | those of its result |
| accuracy | of a result of inverse-dynamics with .nominal .low .high .worst .rss: "max(rocker.angle.high)" |
| modes | mode1.frequency [Hz], mode1.damping, mode1.growth [1/s], mode2 ... |
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rattle.analyses.dynamics.methods import contacts_of
from rattle.analyses.straight_line.derived_curves import derived_units
from rattle.errors import InputError, SolverError, suggest
from rattle.registry import kinds
from rattle.results.build import build_result
from rattle.results.columns import columns, width
from rattle.results.result import Result
from rattle.results.trust import Trust
from rattle.solvers.stepper import FREE
from rattle.trace.lane_program import MOST_STEPS

if TYPE_CHECKING:
    from rattle.analyses.accuracy.clearance_error import Accuracy
    from rattle.analyses.statics.modes import Modes
    from rattle.mechanism import Mechanism

BANDS = ("nominal", "low", "high", "worst", "rss")  # of an output with play, see `Accuracy`
MODE = {"frequency": "Hz", "damping": "", "growth": "1/s"}  # of a mode, see `Modes`
WRITTEN_AS = {"play": "accuracy", "inverse_dynamics": "inverse-dynamics"}


class Stepping(NamedTuple):
    """How motions are integrated."""

    method: str | None
    rtol: float
    atol: float
    step: float | None  # [s]


Run = Callable[["Mechanism", np.ndarray, Collection[str], Stepping], Result]


class Analysis(NamedTuple):
    """An analysis of a mechanism at increasing instants [s]."""

    run: Run  # of a mechanism, at instants (n,) [s], for these names
    names: Callable[[Mechanism], dict[str, str]]  # of its results, with their SI units
    points: int  # intervals between instants where outputs need whole curves
    at_rest: bool = False  # its instants are t = 0 alone, unless an end is given


def analysis_named(name: str) -> str:
    """The analysis of this name.  Raises InputError."""
    found = WRITTEN_AS.get(str(name), str(name))
    if found not in ANALYSES:
        raise InputError(f"unknown analysis '{name}'{suggest(str(name), ANALYSES)}")
    return found


def _complete(result: Result) -> Result:
    """A result that came to its end.  Raises SolverError."""
    if not result.success:
        raise SolverError(result.message, result)
    return result


# ---------------------------------------------------------------- motion and positions
def steps_at_most(m: Mechanism, how: Stepping) -> int | None:
    """Steps after which a sample is given up, so that one does not hold up all others; None: no limit.

    Without contacts only a motion that is not credible needs so many steps that follow the tolerances.
    """
    follow = how.method is None or kinds("stepper")[how.method].leaf.adaptive
    return MOST_STEPS if follow and contacts_of(m.system) == FREE else None


def given_up(most: int) -> str:
    """What is said of a sample that takes too many steps."""
    return f"takes more than {most} steps: its motion is not credible; simulate it alone to see why"


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


def _positions(m: Mechanism, times: np.ndarray, names: Collection[str], how: Stepping) -> Result:
    return m.kinematics(times, strict=True)


def _with_forces(m: Mechanism, times: np.ndarray, names: Collection[str], how: Stepping) -> Result:
    return m.inverse_dynamics(times, strict=True)


def _at_rest(m: Mechanism, times: np.ndarray, names: Collection[str], how: Stepping) -> Result:
    return _complete(m.equilibrium(times))


def _names_from(run: Run) -> Callable[[Mechanism], dict[str, str]]:
    """Names from the result of a run at t = 0."""

    def names(m: Mechanism) -> dict[str, str]:
        result = run(m, np.zeros(1), (), Stepping("", 0.0, 0.0, None))
        return {name: result.unit(name) for name in result.names}

    return names


# ---------------------------------------------------------------- play
def _bands(m: Mechanism, times: np.ndarray, names: Collection[str], how: Stepping) -> Result:
    """Bands of all outputs whose names are asked for."""
    of = sorted({name.rpartition(".")[0] for name in names})
    curves: dict[str, np.ndarray] = {}
    units: dict[str, str] = {}
    for one in of:
        extremes = any(f"{one}.{key}" in names for key in ("low", "high"))
        found: Accuracy = m.accuracy(one, times, extremes=extremes, loaded=False)
        curves |= {f"{one}.{key}": getattr(found, key) for key in BANDS}
        units |= {f"{one}.{key}": found.unit for key in BANDS}
    data = np.array(list(curves.values())).T if curves else np.zeros((len(times), 0))
    return _table(m, "accuracy", times, data, units)


def _names_of_bands(m: Mechanism) -> dict[str, str]:
    result = m.ideal().inverse_dynamics(np.zeros(1))
    return {f"{name}.{key}": result.unit(name) for name in result.names for key in BANDS}


# ---------------------------------------------------------------- modes
def _vibrations(m: Mechanism, times: np.ndarray, names: Collection[str], how: Stepping) -> Result:
    return modes_table(m, times, [m.modes(t) for t in times.tolist()], names)


def modes_table(m: Mechanism, times: np.ndarray, modes: Sequence[Modes], names: Collection[str] = ()) -> Result:
    """Frequencies, damping and growth of modes at instants (n,) [s] as curves; names: that have to be among them."""
    rows: list[dict[str, float]] = []
    units: dict[str, str] = {}
    for found in modes:
        values = {"frequency": found.frequency, "damping": found.damping, "growth": found.growth}
        rows.append({f"mode{n + 1}.{key}": float(values[key][n]) for n in range(len(found)) for key in MODE})
        units |= {f"mode{n + 1}.{key}": unit for n in range(len(found)) for key, unit in MODE.items()}
    units |= {name: "" for name in names if name not in units}  # a mode that this sample has not
    data = np.array([[row.get(name, np.nan) for name in units] for row in rows])
    return _table(m, "modes", times, data, units)


def _table(m: Mechanism, analysis: str, times: np.ndarray, data: np.ndarray, units: dict[str, str]) -> Result:
    """Numbers (n, k) of an analysis at instants (n,) [s] as a result."""
    trust = Trust(drift=0.0, t_end=float(times[-1]))
    return build_result(m.model, analysis, t=times, data=data, names=units, units=units, trust=trust, drawn=False)


ANALYSES = {
    "simulate": Analysis(_simulated, _names_of_motion, 2000),
    "kinematics": Analysis(_positions, _names_from(_positions), 2000),
    "inverse-dynamics": Analysis(_with_forces, _names_from(_with_forces), 2000),
    "equilibrium": Analysis(_at_rest, _names_from(_at_rest), 200, at_rest=True),
    "accuracy": Analysis(_bands, _names_of_bands, 200),
    "modes": Analysis(_vibrations, _names_from(_vibrations), 200, at_rest=True),
}
