"""Steady temperatures of joints from what they lose.

    G (T - T_air) = P(T)      G [W/K] conductances to the air and between joints, P [W] mean losses by friction

Source: docs/heat-and-life.md.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from rattle.analyses.driver_period import part_of_turn
from rattle.answers.answer import Answer, Number
from rattle.answers.blocks import bars, table, words
from rattle.language.quantities import Quantity
from rattle.language.units import FREEZING
from rattle.mechanism import Mechanism
from rattle.questions.heat.steady import Steady, steady
from rattle.questions.heat.ways import Conduction, Cooling, Network, network
from rattle.results.archive import package
from rattle.results.display import quantity

if TYPE_CHECKING:
    from pandas import DataFrame

HEAD = ("joint", "temperature", "above the air", "lost there", "to the air")


@dataclass(frozen=True, repr=False, kw_only=True)
class Heat(Answer):
    """How warm joints become: `h.temperature["pin"]` [K], `h.loss["pin"]` [W].

    to_air: what flows off to the air there [W].  iterations: runs.  mechanism: with oil and play at the temperatures.
    """

    ambient: float  # [K]
    temperature: Mapping[str, float]
    loss: Mapping[str, float]
    to_air: Mapping[str, float]
    iterations: int
    mechanism: Mechanism
    remarks: tuple[str, ...]

    def __repr__(self) -> str:
        return f"<rattle.Heat: {self.told}>"

    @cached_property
    def table(self) -> DataFrame:
        """pandas.DataFrame of all joints: joint, temperature [degC], loss and to_air [W].  Raises MissingPackage."""
        columns: dict[str, Any] = {
            "joint": list(self.temperature),
            "temperature": [kelvin - FREEZING for kelvin in self.temperature.values()],
            "loss": list(self.loss.values()),
            "to_air": list(self.to_air.values()),
        }
        frame: DataFrame = package("pandas", "a table of temperatures").DataFrame(columns)
        return frame


def heat(m: Mechanism, ambient: Quantity | None, cooling: Cooling, conduction: Conduction, t_end: float | None) -> Heat:
    """Steady temperatures of all joints; see `Mechanism.heat`."""
    ways = network(m, ambient, cooling, conduction)
    return _answer(ways, steady(m.set(), ways, t_end))  # a copy's runs hold their model, those of a sample do not


def _answer(ways: Network, state: Steady) -> Heat:
    temperature = dict(zip(ways.joints, state.temperatures.tolist(), strict=True))
    loss = dict(zip(ways.joints, state.losses.tolist(), strict=True))
    to_air = dict(zip(ways.joints, _to_air(ways, state), strict=True))
    shown = [name for k, name in enumerate(ways.joints) if ways.cooled[k]]
    rows = [
        (
            name, celsius(temperature[name]), f"{temperature[name] - ways.ambient:.4g} K", quantity(loss[name], "W"),
            quantity(to_air[name], "W"),
        )
        for name in shown
    ]  # fmt: skip
    remarks = _remarks(state)
    hottest = max(temperature, key=lambda name: temperature[name])
    numbers = {f"{name}.temperature": Number(temperature[name], "K") for name in ways.joints}
    numbers |= {f"{name}.loss": Number(loss[name], "W") for name in ways.joints}
    told = f"{hottest} becomes warmest, {celsius(temperature[hottest])}"
    told += f"; {quantity(sum(loss.values()), 'W')} flow to the air of {celsius(ways.ambient)}"
    if not any(loss.values()):
        told = f"no joint loses anything: all are as warm as the air, {celsius(ways.ambient)}"
    answer = Answer.of(
        told,
        table(HEAD, rows, "Steady temperatures"),
        bars("Temperatures", "temperature [degC]", shown, [temperature[n] - FREEZING for n in shown], told=False),
        bars("What is lost there", "mean loss [W]", shown, [loss[name] for name in shown], told=False),
        words("\n".join(remarks)),
        numbers={"hottest": Number(temperature[hottest], "K"), **numbers},
    )
    return Heat(
        answer.told, answer.blocks, answer.numbers, ambient=ways.ambient, temperature=temperature, loss=loss,
        to_air=to_air, iterations=state.runs, mechanism=state.mechanism, remarks=remarks,
    )  # fmt: skip


def celsius(kelvin: float) -> str:
    """A temperature [K] as people read it."""
    return f"{kelvin - FREEZING:.1f} degC"


def _to_air(ways: Network, state: Steady) -> list[float]:
    """What flows off to the air at every joint [W]: the sum of a row of G is its conductance to the air."""
    flows: list[float] = (ways.conductance.sum(axis=1) * (state.temperatures - ways.ambient)).tolist()
    return flows


def _remarks(state: Steady) -> tuple[str, ...]:
    """What a user should know of these temperatures."""
    short = tuple(filter(None, (part_of_turn(state.mechanism.system, state.duration),)))
    if not state.dependents:
        return (*short, "no oil and no play depends on temperature: what joints lose is that of one run")
    named = ", ".join(f"{joint.parts} of {joint.joint}" for joint in state.dependents)
    count = f"{state.runs} run{'s' if state.runs > 1 else ''}"
    return (*short, f"as they are at these temperatures, found by {count}: {named}")
