"""What may be sought as the largest value: the tolerance of a parameter, or the clearance of a joint.

Tolerance: the limits of the output lie about its value without deviations.  Clearance: about its value without play,
in the mechanism whose other parameters have their nominal values and which is made for this clearance: what is written
with the clearance, such as the place of a bearing, follows it.
"""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, final

import numpy as np

from rattle.description.model import Parameter
from rattle.errors import InputError
from rattle.language.syntax import Name
from rattle.questions.ensemble.compute import nominal_run
from rattle.questions.ensemble.contributors import half_width
from rattle.questions.ensemble.fields import TABLE, Field, Fields, fields_of
from rattle.questions.tolerance.required_accuracy import Limits, Within, limits_about
from rattle.questions.tolerance.trials import Trials
from rattle.results.reductions import Output
from rattle.studies.runs.columns import in_one_unit
from rattle.studies.runs.task import Task, task_of

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

FIRST = 1e-3  # first tolerance that is tried, as a share of the nominal value
LEAST = 1e-6  # least value that is tried, as a share of the first
GREATEST = 1e6  # greatest one where nothing bounds it, likewise
ALONG = ("at", "final", "max", "min", "mean", "quantile")  # reductions that rise with their curve
DRIVEN = ("kinematics", "inverse-dynamics")


@dataclass(frozen=True, eq=False)
class Asked:
    """What was asked of `tolerance_for`."""

    mechanism: Mechanism
    of: str
    within: Within
    parameter: Parameter
    vary: Mapping[str, Any]  # the parameters that vary, with entries as in the file
    analysis: str
    t_end: float | None  # [s]


class Sought(ABC):
    """Values x of something that is to be as large as possible."""

    what = ""  # "tolerance of r3"
    remedy = ""  # what to do if no value is small enough
    bound = ""  # what `most` is
    from_nothing = False  # x = 0 can be looked at

    def __init__(self, of: str, parameter: Parameter, fields: Fields | None, trials: Trials) -> None:
        self.of, self.parameter, self.fields, self.trials = of, parameter, fields, trials
        self.start = self.least = self.most = 0.0  # first, least and greatest x [SI]
        self.notes: list[str] = []

    @property
    def draws(self) -> int:
        """Number of independent draws."""
        return 0 if self.fields is None else self.fields.draws

    @abstractmethod
    def values(self, x: float, u: np.ndarray) -> np.ndarray:
        """(k, n) values [SI] of the parameters that differ, at points u (n, d)."""

    @abstractmethod
    def limits(self, x: float) -> Limits:
        """The limits of the output.  Raises ModelError, AssemblyError, SolverError."""

    @abstractmethod
    def shown(self, x: float) -> str:
        """A value as text: "+-0.1 mm"."""


def _text(value: float, unit: str) -> str:
    return " ".join(in_one_unit([value], unit)).rstrip()


def _varied(fields: tuple[Field, ...]) -> str:
    return ", ".join(
        f"{field.name} +-{_text(half_width(field), field.unit)}{'' if field.dist == 'uniform' else f' {field.dist}'}"
        for field in fields
    )


# ---------------------------------------------------------------- a tolerance
@final
class _Tolerance(Sought):
    from_nothing = True

    def __init__(self, asked: Asked, fields: Fields, trials: Trials, nominal: float) -> None:
        super().__init__(asked.of, asked.parameter, fields, trials)
        self._fields = fields
        self._place = fields.names.index(asked.parameter.name)
        self._limits = limits_about(asked.within, nominal, trials.task.outputs[0].unit)
        own = self._fields.fields[self._place]
        self.what = f"tolerance of {own.name}"
        self.start = own.tol
        self.most, self.bound = _room(asked.parameter, own.tol)
        self.least = LEAST * self.start
        others = tuple(field for field in fields.fields if field is not own)
        self.remedy = "the other tolerances alone are too wide" if others else "widen the limits"
        if not self._limits.low < nominal < self._limits.high:
            value = _text(nominal, trials.task.outputs[0].unit)
            self.remedy = f"the output without deviations, {value}, is not between the limits: move the nominal values"
        together = [name for name, draw in zip(fields.names, fields.draw, strict=True)
                    if draw == fields.draw[self._place] and name != own.name]  # fmt: skip
        self.notes = [
            f"{own.name} is distributed {own.dist}ly"
            if own.dist != "triangular"
            else f"{own.name} has a triangular field",
            f"the others keep their fields: {_varied(others)}" if others else "nothing else varies",
            *([f"made together with {', '.join(together)}: one draw moves them"] if together else []),
            "deviations are from the output without deviations",
        ]

    def values(self, x: float, u: np.ndarray) -> np.ndarray:
        """(k, n) values [SI]."""
        field, limits = self._fields.fields[self._place], self.parameter
        low = max(field.nominal - x, -math.inf if limits.minimum is None else limits.minimum)
        high = min(field.nominal + x, math.inf if limits.maximum is None else limits.maximum)
        every = list(self._fields.fields)
        every[self._place] = replace(field, tol=x, low=low, high=high)
        return replace(self._fields, fields=tuple(every)).values(u)

    def limits(self, x: float) -> Limits:
        """Those about the output without deviations."""
        return self._limits

    def shown(self, x: float) -> str:
        """A tolerance as text."""
        return f"+-{_text(x, self.parameter.unit)}"


def _room(parameter: Parameter, start: float) -> tuple[float, str]:
    """The greatest tolerance [SI], and what it is."""
    ends = [abs(limit - parameter.value) for limit in (parameter.minimum, parameter.maximum) if limit is not None]
    if ends:
        return min(ends), "the limit that the model sets (min, max)"
    if parameter.value:
        return abs(parameter.value), "the whole nominal value"
    return GREATEST * start, "far more than the first that was tried"


def tolerance_of(asked: Asked, threads: int | None, progress: bool) -> Sought:
    """The tolerance of a parameter, others keeping theirs.  Raises what `fields_of` raises, ValueError."""
    m, parameter = asked.mechanism, asked.parameter
    vary = dict(asked.vary)
    if parameter.name not in vary:
        first = FIRST * abs(parameter.value) or FIRST
        first = min(first, _room(parameter, first)[0])
        if first == 0.0:
            raise InputError(
                f"parameter: '{parameter.name}' is at a limit of the model, {parameter.value:g}: it has no room to vary"
            )
        vary[parameter.name] = {"tol": first}
    fields = fields_of(m, vary)
    if fields.fields[fields.names.index(parameter.name)].dist == TABLE:
        raise InputError(f"parameter: '{parameter.name}' is distributed by a table of values, which has no tolerance")
    task = task_of(m, fields.names, [asked.of], analysis=asked.analysis, t_end=asked.t_end)
    (nominal,), remarks = nominal_run(task)
    if not math.isfinite(nominal):
        raise InputError(
            f"of: {asked.of!r} has no value without deviations" + "".join(f"; {remark}" for remark in remarks)
        )
    return _Tolerance(asked, fields, Trials(task, threads, progress), nominal)


# ---------------------------------------------------------------- a clearance
@final
class _Clearance(Sought):
    def __init__(self, asked: Asked, joints: list[str], fields: Fields | None, trials: Trials, reference: Task) -> None:
        super().__init__(asked.of, asked.parameter, fields, trials)
        self._within, self._reference = asked.within, reference
        self._known: dict[float, Limits] = {}
        parameter = asked.parameter
        self.what = f"clearance {parameter.name} of {', '.join(joints)}"
        self.start = parameter.value if parameter.value > 0.0 else FIRST * (parameter.maximum or 1.0)
        self.least = max(LEAST * self.start, parameter.minimum or 0.0)
        self.most = GREATEST * self.start if parameter.maximum is None else parameter.maximum
        self.bound = (
            "far more than the present one" if parameter.maximum is None else "the limit that the model sets (max)"
        )
        self.remedy = "other joints with play" + (", and the tolerances," if fields else "") + " alone may take more"
        follow = sorted(asked.mechanism.following([parameter.name]) - {parameter.name})
        self.notes = [
            "deviations are from the mechanism without play, all else nominal, made for this clearance",
            "the pins may be anywhere in their clearances: the whole band counts"
            if asked.analysis in DRIVEN
            else f"the pins are where {asked.analysis} brings them",
            f"these vary: {_varied(fields.fields)}" if fields else "nothing else varies",
            *([f"parameters that are written with it follow: {', '.join(follow)}"] if follow else []),
        ]

    def values(self, x: float, u: np.ndarray) -> np.ndarray:
        """(k, n) values [SI], the clearance last."""
        sought = np.full((1, len(u)), x)
        return sought if self.fields is None else np.concatenate([self.fields.values(u), sought])

    def limits(self, x: float) -> Limits:
        """Those about the output without play."""
        if x not in self._known:
            ideal = self._reference.mechanism.neighbour({self.parameter.name: x}).ideal()
            (value,), _ = self._reference.look(ideal)
            self._known[x] = limits_about(self._within, value, self._reference.outputs[0].unit)
        return self._known[x]

    def shown(self, x: float) -> str:
        """A clearance as text."""
        return _text(x, self.parameter.unit)


def scale_of(asked: Asked, joints: list[str], threads: int | None, progress: bool) -> Sought:
    """The clearance of joints.  Raises what `fields_of` and `task_of` raise, ValueError."""
    m, end = asked.mechanism, asked.t_end
    fields = fields_of(m, asked.vary) if asked.vary else None
    names = (*(fields.names if fields else ()), asked.parameter.name)
    reference = task_of(m.ideal(), (asked.parameter.name,), [asked.of], analysis=asked.analysis, t_end=end)
    reference = replace(reference, mechanism=m)
    if asked.analysis in DRIVEN:
        task = task_of(m, names, _band(reference.outputs[0], asked.analysis), analysis="accuracy", t_end=end)
    else:
        task = task_of(m, names, [asked.of], analysis=asked.analysis, t_end=end)
    sought = _Clearance(asked, joints, fields, Trials(task, threads, progress), reference)
    sought.limits(sought.start)  # says what is wrong with them
    return sought


def _band(output: Output, analysis: str) -> list[str]:
    """The least and the greatest value of an output over all positions of the pins.  Raises InputError."""
    reduction = output.reductions[0]
    if (
        isinstance(output.outer, Name)
        and isinstance(reduction.inner, Name)
        and reduction.kind in ALONG
        and output.names
    ):
        name = re.compile(rf"(?<![\w.]){re.escape(reduction.inner.name)}(?![\w.])")
        return [name.sub(f"{reduction.inner.name}.{end}", output.text, count=1) for end in ("low", "high")]
    raise InputError(
        f"of: with {analysis} the band over all positions of the pins is known of {', '.join(ALONG)} of one curve,"
        f" such as 'at(rocker.angle, 0.3)'; got {output.text!r:.60}"
    )
