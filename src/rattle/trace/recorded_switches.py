"""Expressions that switch, and pawls, in a recorded model: their sides are inputs of the graph, pieces are smooth.

A switch takes the branch of its side, 1 or -1, whatever its switching function is; a side lasts until that function
comes to zero.  See `language.bytecode`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rattle.equations.system import System
from rattle.errors import TraceError
from rattle.jit import layout as at
from rattle.language import arithmetic
from rattle.language import bytecode as code
from rattle.language.recorded import Operand
from rattle.solvers.contacts.pawls import SEATED
from rattle.trace.derivative import gradient, tangent
from rattle.trace.graph import Graph, Symbol, apply, select, summed
from rattle.trace.recorded_language import Copies
from rattle.trace.recorded_table import recorded_knots, recorded_segment

MOST = 12  # switches
ROUNDED, LEAST = 4e-15, 1e-13  # of a position, rate, state or time that is rounding: a share of it, and in SI units


class Switch(NamedTuple):
    """One at an instant."""

    value: Operand  # its switching function
    rate: Operand  # dvalue/dt
    slight: Operand  # of the value, what may be rounding
    side: Operand


class RecordedSwitches:
    """Those of a system, on symbols of one graph."""

    def __init__(self, graph: Graph, system: System) -> None:
        """Raises TraceError for too many."""
        self.graph = graph
        self._places = {switch.row: n for n, switch in enumerate(system.switches)}
        self.pawls = np.flatnonzero(system.arrays["contact"][:, at.TOOTHED] == 1).tolist()  # contacts, after these
        if len(self) > MOST:
            raise TraceError(f"more than {MOST} expressions switch")
        self.sides: list[Symbol] = []
        self._values: dict[int, Operand] = {}  # switching functions, as last evaluated

    def __len__(self) -> int:
        return len(self._places) + len(self.pawls)

    def from_tooth(self, contact: int, turned: Operand) -> Operand:
        """How far the pawl of a contact is from the tooth before it, both in pitches; it drops behind the next one."""
        n = len(self._places) + self.pawls.index(contact)
        side, even, odd = self.sides[n], turned - _held(1, turned), turned - _held(-1, turned)
        value = select(side > 0.0, 1.0 - even, odd - 1.0)
        past = turned + SEATED  # at the start the side is asked for
        asked = self._inside(n, past - _held(1, past), past - _held(-1, past))
        self._values[n] = select(apply("equal", side, 0.0), asked, value)
        return select(side > 0.0, even, odd)

    def begin(self, copies: Copies) -> None:
        """Let programs be recorded; before any is."""
        self._copies = copies
        copies.replace(arithmetic.held.python, _held)
        copies.replace(code.run_one.python, self._run_one)
        copies.replace(code.run_two.python, self._run_two)
        copies.replace(code.run_table.python, self._run_table)
        copies.replace(code.run_choice.python, self._run_choice)

    def at(self, rates: Sequence[Operand]) -> list[Switch]:
        """All of them, of the programs that have run last; rates: of t and the states, in the order of inputs."""
        inputs = [Symbol(self.graph, place) for place in self.graph.inputs[: len(rates)]]
        values = [self._values[n] for n in range(len(self))]
        flow = {x.place: rate for x, rate in zip(inputs, rates, strict=True)}
        changes = tangent(self.graph, values, flow)
        slight = [
            summed(
                abs(slope) * ((LEAST if k > 0 else 0.0) + ROUNDED * abs(x))
                for k, (slope, x) in enumerate(zip(gradient(self.graph, value, inputs), inputs, strict=True))
                if isinstance(slope, Symbol) or slope != 0.0
            )
            for value in values
        ]
        return [Switch(*each) for each in zip(values, changes, slight, self.sides, strict=True)]

    def _on(self, row: int, value: Operand, plus: Operand, minus: Operand) -> Operand:
        """The branch of the side of the switch in a row, whose switching function has this value."""
        n = self._places[row]
        self._values[n] = value
        return select(self.sides[n] > 0.0, plus, minus)

    def _branches(self, row: int, op: int, x: Operand, y: Operand) -> Operand:
        switching, branch = (self._copies.of(f.python) for f in (code.switching, code.branch))
        plus, minus = branch(op, 1, x, y), branch(op, -1, x, y)
        if op in (code.FLOOR, code.MOD):
            z = x if op == code.FLOOR else x / y
            return self._on(row, self._inside(self._places[row], z - _held(1, z), z - _held(-1, z)), plus, minus)
        return self._on(row, switching(op, x, y), plus, minus)

    def _inside(self, n: int, even: Operand, odd: Operand) -> Operand:
        """A switching function of what switches at every whole number, from the shares of the spans, even and odd, that
        are nearest: of the sign of `arithmetic.wave`, but smooth beyond the ends of a span too."""
        return select(self.sides[n] > 0.0, even * (1.0 - even), -odd * (1.0 - odd))

    def _run_one(self, program: Sequence[Sequence[int]], row: int, x: Operand) -> Operand:
        op = program[row][0]
        if row in self._places:
            return self._branches(row, op, x, 0.0)
        result: Operand = self._copies.of(code.unary.python)(op, x)
        return result

    def _run_two(self, program: Sequence[Sequence[int]], row: int, x: Operand, y: Operand) -> Operand:
        op = program[row][0]
        if row in self._places:
            return self._branches(row, op, x, y)
        result: Operand = self._copies.of(code.binary.python)(op, x, y)
        return result

    def _run_table(self, program: Sequence[Sequence[int]], row: int, const: Sequence[Operand], x: Operand) -> Operand:
        k = program[row][1]
        if row not in self._places:
            plain: Operand = self._copies.of(code.read_table.python)(const, k, 0, x, 0.0, 0.0)[0]
            return plain
        z = recorded_knots(const, k, x)
        (plus, even), (minus, odd) = (recorded_segment(const, k, _held(side, z), x) for side in (1, -1))
        return self._on(row, self._inside(self._places[row], even, odd), plus, minus)

    def _run_choice(self, program: Sequence[Sequence[int]], row: int, stack: Sequence[Operand], top: int) -> Operand:
        op, (a, b, yes, no) = program[row][0], stack[top : top + 4]
        if row not in self._places:
            return select(self._copies.of(code.holds.python)(op, a, b), yes, no)
        below, above = (yes, no) if op <= code.AT_MOST else (no, yes)
        chosen, other = self._on(row, a - b, above, below), self._on(row, a - b, below, above)
        without = apply("equal", a, b) & apply("not", abs(chosen) < math.inf)  # a branch that has no value there
        return select(without, other, chosen)


def _held(side: int, x: Operand) -> Operand:
    """Stands for `arithmetic.held`: the even integer, or the odd one, whose span from half before it on has x."""
    if side > 0:
        return 2.0 * apply("floor", 0.5 * (x + 0.5))
    return 2.0 * apply("floor", 0.5 * (x - 0.5)) + 1.0
