"""What sensitivities mean for a design: the effect of a usual change of each parameter."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from rattle.equations.system import System
from rattle.errors import InputError
from rattle.results.chosen_units import chosen
from rattle.results.display import quantity
from rattle.results.handy_units import DEGREES, SMALL
from rattle.results.result import Result

UNDEFINED = "not defined"
SHARE = 0.01  # usual change of a parameter without a tolerance, as a share of its value; of 1 if that is 0


def usual_change(system: System, name: str) -> dict[str, Any]:
    """A change of a parameter that matters, its tolerance or else 1 % of it: size [SI], unit, words."""
    parameter = system.model.parameters[name]
    size = parameter.tol or SHARE * (abs(parameter.value) or 1.0)
    why = "tolerance" if parameter.tol else "1 %" if parameter.value else "0.01"
    return {"size": size, "unit": parameter.unit, "words": f"{quantity(size, parameter.unit, 3)} ({why})"}


class Effect(NamedTuple):
    """A derivative along a result, and what the usual change of its parameter does."""

    output: str
    parameter: str
    derivative: np.ndarray  # (n,) [SI]
    change: float  # of the parameter [SI]
    words: str  # the change, as it is printed
    unit: str  # SI unit of the output
    by: str  # SI unit of the parameter

    @property
    def of_whole_run(self) -> bool:
        """True of a number, the same at every instant."""
        return "(" in self.output

    @property
    def largest(self) -> int:
        """Instant of the largest magnitude, of those at which it is defined."""
        size = np.abs(self.derivative)
        return int(np.nanargmax(size)) if np.isfinite(size).any() else 0

    @property
    def slope(self) -> str:
        """The largest derivative as text, angles in degrees, by mm where the parameter's change is short."""
        value, unit, by = float(self.derivative[self.largest]), self.unit, self.by
        if math.isnan(value):
            return UNDEFINED
        asked, asked_by = chosen(unit), chosen(by)
        if asked or asked_by:
            (factor, unit), (factor_by, by) = asked or (1.0, unit), asked_by or (1.0, by)
            return f"{value * factor / factor_by:.4g} {quotient(unit, by)}".rstrip()
        if unit in ("rad", "rad/s", "rad/s^2"):
            value, unit = DEGREES * value, unit.replace("rad", "deg")
        if by == "m" and self.change < SMALL:
            value, unit, by = (value, "mm", "mm") if unit == "m" else (1e-3 * value, unit, "mm")
        return f"{value:.4g} {quotient(unit, by)}".rstrip()

    @property
    def effect(self) -> str:
        """The largest change of the output, as text."""
        value = float(self.derivative[self.largest])
        return UNDEFINED if math.isnan(value) else quantity(value * self.change, self.unit, 3)

    @property
    def size(self) -> float:
        """The largest magnitude of the change of the output [SI]; 0 where the result has no instant."""
        return float(np.nanmax(np.abs(self.derivative), initial=0.0)) * self.change


def effects(result: Result) -> list[Effect]:
    """All derivatives of a result of `sensitivity`.  Raises InputError for another result."""
    ran = result.provenance
    if ran.get("analysis") != "sensitivity" or not {"of", "changes"} <= ran.keys():
        raise InputError("this result holds no sensitivities")
    return [
        Effect(
            output, parameter, result[derivative_name(output, parameter)], change["size"], change["words"],
            result.unit(output), change["unit"],
        )
        for output in ran["of"] for parameter, change in ran["changes"].items()
    ]  # fmt: skip


def derivative_name(output: str, parameter: str) -> str:
    """Name of a derivative: d(rocker.angle)/d(l2)."""
    return f"d({output})/d({parameter})"


def quotient(unit: str, by: str) -> str:
    """Unit of a derivative, as "rad/m", "N/(N*m)", or "rad*s" for one by a rate in 1/s."""
    if not by:
        return unit
    if by.startswith("1/"):
        return f"{unit}*{by[2:]}" if unit else by[2:]
    return f"{unit or '1'}/{f'({by})' if any(c in by for c in '*/') else by}"
