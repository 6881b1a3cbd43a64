"""What a model is as a program, whatever the language: recorded functions, and how a run of them starts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from rattle.language.recorded import Operand
from rattle.trace.graph import Graph

ROWS = 1000  # about so many rows are printed or returned of a run
PIECES = 64  # a change of parameters is taken in so many steps, at most, to find the start that belongs to them


class Input(NamedTuple):
    """A parameter of the model that the program takes, in SI units."""

    name: str
    value: float  # in the model
    unit: str
    low: float | None = None  # limits that the model file gives
    high: float | None = None


class Begin(NamedTuple):
    """How the start follows from the parameters; y of the graph holds the positions to start from.

    Newton's method takes at most `rounds` steps, the last of which may be `small` [rad, sizes of the mechanism].  Then
    what is left open may be `closed` [m or rad], the way `far` [rad, sizes], the miss of given rates `missed` [share].
    """

    readable: Operand  # flag of the parameters alone: the model has the parts and forms of this program
    correction: Sequence[Operand]  # (nq + 2,) positions after a step, what is left open [m or rad], a flag
    rates: Sequence[
        Operand
    ]  # (nq + 2,) rates at closed positions, by how much given ones are missed [m/s or rad/s], a flag
    gaps: Sequence[tuple[str, Operand, str]]  # what must close: words before a number, this number at y, its unit
    sizes: Sequence[float]  # (nq,) what changes of positions are measured by [m or rad]
    closed: float
    missed: float
    far: float
    rounds: int
    small: float


class Program(NamedTuple):
    """Functions of t [s], y [SI], the parameters p [SI] and the energy at the start E_0 [J], of exact operations."""

    graph: Graph  # its inputs, in this order
    derivative: Sequence[Operand]  # (ny + 1,) dy/dt [SI/s], then a flag: this was computed on sound assumptions
    projection: Sequence[Operand]  # (ny + 1,) y on the constraints [SI], then such a flag
    outputs: Sequence[Operand]  # (no + 1,) the result columns [SI], the energies last, then such a flag
    names: Sequence[str]  # of the result columns
    units: Sequence[str]
    parameters: Sequence[Input]
    start: Sequence[float]  # (ny,) y at t = 0 for the parameters of the model
    begin: Begin | None = None  # None: there are no parameters
    switching: Sequence[str] = ()  # expressions with abs, sign, min, max or if
    constants: Mapping[str, str] = {}  # parameters of the model file that the program does not take, and why
    bound: Sequence[str] = ()  # parameters that have no start where they are changed alone

    @property
    def functions(self) -> dict[str, Sequence[Operand]]:
        """The recorded functions by name: those of a run and those of its start."""
        functions: dict[str, Sequence[Operand]] = {
            "derivative": self.derivative, "project": self.projection, "outputs": self.outputs,
        }  # fmt: skip
        if self.begin is None:
            return functions
        return functions | {
            "readable": [self.begin.readable], "correct": self.begin.correction, "closeRates": self.begin.rates,
            "gaps": [gap for _, gap, _ in self.begin.gaps],
        }  # fmt: skip
