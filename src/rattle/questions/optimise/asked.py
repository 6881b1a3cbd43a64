"""What is to be minimised, what may vary within which bounds, and what must hold: read and checked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from rattle.analyses import arguments
from rattle.analyses.dynamics.simulate import output_times
from rattle.analyses.straight_line.recorded_model import require_parameters
from rattle.description.model import within_limits
from rattle.errors import InputError, ModelError, Problem, WrongType, suggest
from rattle.language.syntax import Number, names
from rattle.language.units import QuantityError, describe, dimension_of, parse_quantity
from rattle.results.reductions import (
    HARDEST,
    READ_OFF,
    Constraint,
    Known,
    Output,
    argument,
    needed_instants,
    read,
    read_constraint,
)  # fmt: skip
from rattle.results.result import Result
from rattle.solvers.stepper import ATOL

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

ROUNDING = 1e-14  # share of a range next to a bound that is the rounding of a search on the bound itself
ANALYSES = ("simulate", "kinematics", "inverse-dynamics")
RTOL = 1e-10  # of a motion, at most: errors of the values are then far below the changes that a search looks at
FEWEST = 400  # intervals between the instants of a run
BESIDE = 3  # instants on either side of one that moves, on which a curve between them depends
SAME = 1e-9  # share of the run within which two instants are one
Bound = float | str


@dataclass(frozen=True, eq=False)
class Question:
    """A design problem; parameters that vary have places 0 ... k - 1."""

    mechanism: Mechanism  # the present design
    names: tuple[str, ...]  # (k,) parameters that vary
    low: np.ndarray  # (k,) bounds [SI]
    high: np.ndarray
    t_end: float  # [s]
    analysis: str  # one of ANALYSES
    objective: Output
    constraints: tuple[Constraint, ...] = ()
    finer: int = 1  # times as many instants as asked for, where the values of outputs need them

    @property
    def outputs(self) -> list[Output]:
        """The objective, then the margin of every constraint."""
        return [self.objective, *(constraint.margin for constraint in self.constraints)]

    @property
    def curves(self) -> list[str]:
        """Names of the curves that are needed."""
        return sorted({name for output in self.outputs for name in output.names})

    @property
    def ideal_curves(self) -> list[str]:
        """Names of the curves of the mechanism without play that are needed."""
        return sorted({name for output in self.outputs for name in output.ideal_names})

    def values(self, x: np.ndarray) -> dict[str, float]:
        """Values [SI] of the parameters at x (k,), the places between their bounds from 0 to 1."""
        inside = np.clip(x, 0.0, 1.0)
        from_low, from_high = (np.where(shares < ROUNDING, 0.0, shares) for shares in (inside, 1.0 - inside))
        values = np.where(inside < 0.5, self.low + from_low * self.width, self.high - from_high * self.width)
        return dict(zip(self.names, values.tolist(), strict=True))

    def places(self, values: Mapping[str, float]) -> np.ndarray:
        """(k,) places from 0 to 1 of values [SI]."""
        present = np.array([values[name] for name in self.names])
        return np.asarray(np.clip((present - self.low) / self.width, 0.0, 1.0))

    @property
    def follows_contacts(self) -> bool:
        """Whether derivatives of the curves and of contacts make those of the outputs: not of numbers of events, of
        impulses, nor beside a mechanism without play, whose curves jump elsewhere."""
        touches = self.analysis == "simulate" and self.mechanism.system.turns
        return touches and not self.counts_events and not self.ideal_curves

    @property
    def counts_events(self) -> bool:
        """Whether an output is a number of events, or an impulse."""
        return any(r.kind in ("count", HARDEST) for output in self.outputs for r in output.reductions)

    @property
    def is_between(self) -> bool:
        """Whether outputs depend on curves between the instants of a run, and may be taken of others."""
        kinds = {reduction.kind for output in self.outputs for reduction in output.reductions}
        return self.analysis == "simulate" and not kinds <= {*READ_OFF} and not self.ideal_curves

    @property
    def width(self) -> np.ndarray:
        """(k,) distances of the bounds [SI]."""
        return np.asarray(self.high - self.low)

    def times(self, m: Mechanism, finer: int = 1) -> np.ndarray:
        """Instants [s] of a run of a design: those that are read off, and the output interval of the model between.

        finer: into how many parts an interval is divided.
        """
        read_off = self.read_off(m)
        count = len(output_times(m.model.settings, self.t_end, None)[1]) - 1
        grid = np.linspace(0.0, self.t_end, self.finer * finer * max(count, FEWEST) + 1)
        apart = np.abs(grid - _nearest(grid, read_off)) > SAME * self.t_end
        return np.asarray(np.union1d(grid[apart], read_off))

    def needed_times(self, m: Mechanism) -> np.ndarray:
        """The instants [s] among them on which the outputs depend."""
        every = [reduction for output in self.outputs for reduction in output.reductions]
        if not all(reduction.kind in READ_OFF for reduction in every):
            return self.times(m)
        # whose arguments may move with the parameters
        moving = [reduction for reduction in every if reduction.argument is not None and names(reduction.argument)]
        if not moving:
            return self.read_off(m)
        times = self.times(m)
        places = np.searchsorted(times, [argument(reduction, m.parameters) for reduction in moving])
        beside = (places[:, None] + np.arange(-BESIDE, BESIDE + 1)).clip(0, len(times) - 1)
        return np.asarray(np.union1d(self.read_off(m), times[beside]))

    def read_off(self, m: Mechanism) -> np.ndarray:
        """The instants [s] that are read off: start, end, and all `at`, of which one may stand for the end."""
        instants = {t for output in self.outputs for t in needed_instants(output, m.parameters)}
        outside = [t for t in instants if not 0.0 <= t <= self.t_end * (1.0 + SAME)]
        if outside:
            words = f"the instant {outside[0]:g} s is not between 0 and t_end = {self.t_end:g} s"
            raise ModelError([Problem((), words)])
        times = np.array(sorted(instants))
        ends = np.array([0.0, self.t_end])
        return np.asarray(np.union1d(ends[np.abs(ends - _nearest(ends, times)) > SAME * self.t_end], times))

    @cached_property
    def _others(self) -> frozenset[str]:
        """Parameters beside those that vary on which an output depends: they may follow these."""
        every = [reduction for output in self.outputs for reduction in output.reductions]
        nodes = [*(output.outer for output in self.outputs), *(reduction.inner for reduction in every)]
        nodes += [reduction.argument for reduction in every if reduction.argument is not None]
        used = {name for node in nodes for name in names(node)}
        return frozenset(used & set(self.mechanism.model.parameters) - set(self.names))

    def moved(self, m: Mechanism, name: str, change: float) -> dict[str, float]:
        """Values [SI] that outputs may use of the parameters of a design, where one that varies has changed."""
        values = {**m.parameters, name: m.parameters[name] + change}
        return m.parameters_where({name: values[name]}) if self._others else values

    def run(self, m: Mechanism, rtol: float = RTOL, finer: int = 1) -> Result:
        """The run of a design, which may stop early.  Raises what the analysis raises."""
        times = self.times(m, finer)
        if self.analysis == "kinematics":
            result = m.kinematics(times)
        elif self.analysis == "inverse-dynamics":
            result = m.inverse_dynamics(times)
        else:
            rtol = min(rtol, m.model.settings.rtol or rtol)
            result = m.simulate(float(times[-1]), t_eval=times, rtol=rtol, atol=ATOL * rtol)
        if result.interrupted:
            raise KeyboardInterrupt
        return result


def question(
    m: Mechanism, minimise: str, vary: Mapping[str, Sequence[Bound]], subject_to: Sequence[str], t_end: float | None,
    analysis: str,
) -> tuple[Question, Result]:  # fmt: skip
    """The design problem, and the run of the present design.

    Raises InputError, UnknownName and ModelError with what is wrong in the question, AssemblyError.
    """
    if analysis not in ANALYSES:
        raise InputError(f"unknown analysis '{analysis}'{suggest(str(analysis), ANALYSES)}")
    for what, text in (("minimise", minimise), *(("subject_to", text) for text in _listed(subject_to))):
        if not isinstance(text, str):
            raise WrongType(f"{what}: expected a text such as 'max(O3.force)', got {text!r:.60}")
    varied, low, high = _bounds(m, vary)
    if t_end is None and (differ := sorted(m.names_in_setting("t_end") & m.following(vary))):
        raise InputError(f"t_end follows from {', '.join(differ)} and would differ from design to design; give t_end")
    end = arguments.positive("t_end", m.model.settings.t_end if t_end is None else t_end)
    units = {name: parameter.unit for name, parameter in m.model.parameters.items()}
    asked = Question(m, varied, low, high, end, analysis, _NOTHING)
    scope = Known.of(asked.run(m), units)
    constraints = tuple(_read(read_constraint, text, scope, analysis) for text in _listed(subject_to))
    asked = replace(asked, objective=_read(read, minimise, scope, analysis), constraints=constraints)
    return asked, asked.run(m)


_NOTHING = Output("", (), Number(0.0, 0), None, "", frozenset(), frozenset())  # until the objective is read


def _nearest(times: np.ndarray, others: np.ndarray) -> np.ndarray:
    """(n,) the nearest of other times (m,), increasing, for times (n,); inf where there are none."""
    if not len(others):
        return np.full(len(times), np.inf)
    after = np.searchsorted(others, times).clip(0, len(others) - 1)
    before = (after - 1).clip(0)
    nearer = np.abs(others[before] - times) < np.abs(others[after] - times)
    return np.asarray(np.where(nearer, others[before], others[after]))


def _listed(subject_to: Sequence[str]) -> Sequence[str]:
    return (subject_to,) if isinstance(subject_to, str) else tuple(subject_to or ())


def _read(reader: Any, text: str, scope: Known, analysis: str) -> Any:
    """An output or constraint, with a remark where kinematics has no forces."""
    try:
        return reader(text, scope)
    except ModelError as error:
        if analysis == "kinematics" and "no curve" in str(error):
            error.args = (f"{error}\n(kinematics has positions and rates only; 'inverse-dynamics' has forces too)",)
        raise


def _bounds(m: Mechanism, vary: Mapping[str, Sequence[Bound]]) -> tuple[tuple[str, ...], np.ndarray, np.ndarray]:
    """Names (k,) and bounds (k,) [SI].  Raises InputError, TypeError, UnknownName."""
    if not isinstance(vary, Mapping) or not vary:
        raise InputError('vary: expected parameters with their bounds such as {"l2": (0.5, 0.8)}')
    bad = [name for name in vary if not isinstance(name, str)]
    if bad:
        raise WrongType(f"vary: expected names of parameters, got {bad[0]!r:.60}")
    require_parameters(m.system, list(vary))
    pairs = []
    for name, bounds in vary.items():
        if isinstance(bounds, str) or not isinstance(bounds, Sequence | np.ndarray) or len(bounds) != 2:
            raise InputError(f"vary: '{name}' needs a lower and an upper bound such as (0.5, 0.8), got {bounds!r:.60}")
        low, high = (_bound(m, name, bound) for bound in bounds)
        _require_order(m, name, low, high)
        pairs.append((low, high))
    return tuple(vary), *np.array(pairs).T


def _bound(m: Mechanism, name: str, bound: Bound) -> float:
    """A bound [SI] from a number or a quantity of the parameter's dimension."""
    if not isinstance(bound, str):
        return arguments.number(f"vary: a bound of '{name}'", bound)
    try:
        quantity = parse_quantity(bound)
    except QuantityError as error:
        raise InputError(f"vary: '{name}': {error}") from None
    if quantity is None:
        raise InputError(f"vary: '{name}': {bound!r:.60} is not a value; expected a number in SI or such as '0.2 mm'")
    wanted = dimension_of(m.model.parameters[name].unit)
    if quantity[1] is not None and quantity[1] != wanted:
        raise InputError(f"vary: '{bound}' is {describe(quantity[1])}; '{name}' is {describe(wanted)}")
    return quantity[0]


def _require_order(m: Mechanism, name: str, low: float, high: float) -> None:
    """Raise InputError unless low < high, the present value is between, and the model allows both bounds."""
    parameter = m.model.parameters[name]
    unit = f" {parameter.unit}".rstrip()
    if not low < high:
        hint = "; the lower bound comes first" if low > high else "; bounds that are equal leave nothing to choose"
        raise InputError(f"vary: the bounds of '{name}' are {low:g} and {high:g}{unit}{hint}")
    if not low <= parameter.value <= high:
        raise InputError(
            f"vary: the present value {parameter.value:g}{unit} of '{name}' is outside its bounds {low:g} to"
            f" {high:g}{unit}; widen them or start from another design with set({name}=...)"
        )
    if not all(within_limits(bound, parameter.minimum, parameter.maximum) for bound in (low, high)):
        limits = " to ".join("-" if limit is None else f"{limit:g}" for limit in (parameter.minimum, parameter.maximum))
        raise InputError(f"vary: the model allows '{name}' from {limits}{unit}; the bounds go beyond")
