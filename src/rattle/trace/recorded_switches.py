"""Expressions that switch, and pawls, in a recorded model: their sides are inputs of the graph, pieces are smooth.

A switch takes the branch of its side, 1 or -1, whatever its switching function is; a side lasts until that function
comes to zero.  See `language.bytecode`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from rattle.equations.system import System
from rattle.errors import TraceError
from rattle.jit import layout as at
from rattle.language import arithmetic, jets
from rattle.language import bytecode as code
from rattle.language.recorded import Flag, Operand
from rattle.solvers.contacts.pawls import SEATED
from rattle.solvers.driver_jumps import KICK, LEAP
from rattle.trace.derivative import gradient, tangent
from rattle.trace.graph import Graph, Symbol, apply, select, summed
from rattle.trace.recorded_language import Copies
from rattle.trace.recorded_table import recorded_knots, recorded_segment

MOST = 12  # switches
SAME = 1e-9  # share by which branches that meet at a switch may differ
ROUNDED, LEAST = 4e-15, 1e-13  # of a position, rate, state or time that is rounding: a share of it, and in SI units


class Driven(NamedTuple):
    """What a driver prescribes: value (0 where only its speed is), speed and acceleration; or gravity, as a value."""

    value: Operand
    speed: Operand = 0.0
    bend: Operand = 0.0


class Switch(NamedTuple):
    """One at an instant."""

    value: Operand  # its switching function
    rate: Operand  # dvalue/dt
    slight: Operand  # of the value, what may be rounding
    side: Operand
    jolts: Flag  # the function of a driver, or its speed, jumps with it, or gravity
    jumps: Flag  # the branches of its two sides differ


class RecordedSwitches:
    """Those of a system, on symbols of one graph."""

    def __init__(self, graph: Graph, system: System) -> None:
        """Raises TraceError for too many."""
        self.graph = graph
        self._places = {switch.row: n for n, switch in enumerate(system.switches)}
        self.driving = [n for n, switch in enumerate(system.switches) if switch.driving]
        self.pawls = np.flatnonzero(system.arrays["contact"][:, at.TOOTHED] == 1).tolist()  # contacts, after these
        if len(self) > MOST:
            raise TraceError(f"more than {MOST} expressions switch")
        self.sides: list[Operand] = []
        self._values: dict[int, Operand] = {}  # switching functions, as last evaluated
        self._jumps: dict[int, Flag] = {}  # whether branches differ, likewise

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
        copies.replace(jets.run_jet.python, self._run_jet)

    def at(self, rates: Sequence[Operand], drive: Callable[[], list[Driven]]) -> list[Switch]:
        """All of them, of the programs that have run last; rates: of t and the states, in the order of inputs.

        drive: runs the programs of drivers, and of gravity.
        """
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
        jumps = [self._jumps.get(n, False) for n in range(len(self))]
        jolts = self._jolts(inputs[0], drive)
        return [Switch(*each) for each in zip(values, changes, slight, self.sides, jolts, jumps, strict=True)]

    def _jolts(self, t: Operand, drive: Callable[[], list[Driven]]) -> list[Flag]:
        """Of every switch, whether what drives has two values, or speeds, on its sides."""
        flags: list[Flag] = [False] * len(self)
        if not self.driving:
            return flags
        here = drive()
        for n in self.driving:
            given = self.sides[n]
            self.sides[n] = -given
            for one, other in zip(here, drive(), strict=True):
                leap = abs(other.value - one.value) > LEAP * (1.0 + abs(one.value))
                late = KICK * abs(t) * abs(other.bend - one.bend) + ROUNDED * abs(t)
                kick = abs(other.speed - one.speed) > KICK * (abs(one.speed) + abs(other.speed)) + late
                flags[n] = flags[n] | leap | kick
            self.sides[n] = given
        drive()
        return flags

    def _on(self, row: int, value: Operand, plus: Operand, minus: Operand) -> Operand:
        """The branch of the side of the switch in a row, whose switching function has this value."""
        n = self._places[row]
        self._values[n], self._jumps[n] = value, _differ(plus, minus)
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

    def _in_table(self, n: int, z: Operand, even: Operand, odd: Operand) -> Operand:
        """The same of a table whose knots are passed at whole z.  Before a side is given there is no segment before the
        first one, of which the shares would be."""
        whole = z - _held(1, z)
        return select(apply("equal", self.sides[n], 0.0), whole * (1.0 - whole), self._inside(n, even, odd))

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
        ((plus, *_), even), ((minus, *_), odd) = (recorded_segment(const, k, _held(side, z), x) for side in (1, -1))
        return self._on(row, self._in_table(self._places[row], z, even, odd), plus, minus)

    def _run_choice(self, program: Sequence[Sequence[int]], row: int, stack: Sequence[Operand], top: int) -> Operand:
        op, (a, b, yes, no) = program[row][0], stack[top : top + 4]
        if row not in self._places:
            return select(self._copies.of(code.holds.python)(op, a, b), yes, no)
        below, above = (yes, no) if op <= code.AT_MOST else (no, yes)
        chosen, other = self._on(row, a - b, above, below), self._on(row, a - b, below, above)
        without = apply("equal", a, b) & apply("not", abs(chosen) < math.inf)  # a branch that has no value there
        return select(without, other, chosen)

    # ---------------------------------------------------------------- with time derivatives
    def _run_jet(
        self, program: Sequence[Sequence[int]], row: int, const: Sequence[Operand], stack: Any, top: int
    ) -> int:  # fmt: skip
        """As `jets.run_jet`.  Before a side is given, as where a start is sought, it is that of the present value."""
        op, k = program[row][0], program[row][1]
        operate = self._copies.of(jets.operate_jet.python)
        if row not in self._places:
            end: int = operate(op, 0, const, k, stack, top)
            return end
        n, first = self._places[row], top - 3 * (code.operands_of(op) - 1)
        if op >= code.LESS:
            below, above = list(stack[first + 6 : first + 9]), list(stack[first + 9 : first + 12])
            ways = [above, below] if op <= code.AT_MOST else [below, above]
        else:
            ways = [self._on_side(side, op, const, k, stack, first, top) for side in (1, -1)]
        natural, rate = self._switching_jet(n, op, const, k, *(list(stack[first : top + 3]) + [0.0] * 3)[:6])
        given = self.sides[n]
        differ = [_differ(plus, minus) for plus, minus in zip(*ways, strict=True)]
        self._jumps[n] = differ[0] | differ[1] | differ[2]
        heads = select(apply("equal", natural, 0.0), rate, natural)
        side = select(apply("equal", given, 0.0), heads, given)
        chosen = [select(side > 0.0, plus, minus) for plus, minus in zip(*ways, strict=True)]
        if op >= code.LESS:  # a branch that has no value, or rate, there
            size = summed(abs(x) for x in chosen)
            without = apply("equal", natural, 0.0) & apply("not", size < math.inf)
            other = [select(side > 0.0, minus, plus) for plus, minus in zip(*ways, strict=True)]
            chosen = [select(without, b, a) for a, b in zip(chosen, other, strict=True)]
        for place, x in enumerate(chosen):
            stack[first + place] = x
        return first

    def _on_side(
        self, side: int, op: int, const: Sequence[Operand], k: int, stack: Any, first: int, top: int
    ) -> list[Operand]:  # fmt: skip
        """Value and time derivatives of an operation on one of its sides."""
        if op in (code.CURVE, code.BENT):
            x, dx, ddx = stack[first : first + 3]
            (f, f1, f2), _ = recorded_segment(const, k, _held(side, recorded_knots(const, k, x)), x)
            return [f, f1 * dx, f2 * dx * dx + f1 * ddx]
        trial = list(stack)
        self._copies.of(jets.operate_jet.python)(op, side, const, k, trial, top)
        return trial[first : first + 3]

    def _switching_jet(
        self, n: int, op: int, const: Sequence[Operand], k: int, x: Operand, dx: Operand, _: Operand, y: Operand,
        dy: Operand, __: Operand,
    ) -> tuple[Operand, Operand]:  # fmt: skip
        """Keep the switching function of a switch; returns it as it is whatever the side, and its rate."""
        if op in (code.CURVE, code.BENT):
            z, rate = recorded_knots(const, k, x), dx
            even, odd = (recorded_segment(const, k, _held(side, z), x)[1] for side in (1, -1))
            self._values[n] = self._in_table(n, z, even, odd)
        elif op in (code.FLOOR, code.MOD):
            z, rate = (x, dx) if op == code.FLOOR else (x / y, dx / y - x * dy / (y * y))
            self._values[n] = self._inside(n, z - _held(1, z), z - _held(-1, z))
        else:
            value = x - y if op >= code.LESS else self._copies.of(code.switching.python)(op, x, y)
            self._values[n] = value
            return value, dx - dy
        whole = z - _held(1, z)
        return whole * (1.0 - whole), rate * (1.0 - 2.0 * whole)


def _differ(a: Operand, b: Operand) -> Flag:
    return abs(a - b) > SAME * (abs(a) + abs(b))


def _held(side: int, x: Operand) -> Operand:
    """Stands for `arithmetic.held`: the even integer, or the odd one, whose span from half before it on has x."""
    if side > 0:
        return 2.0 * apply("floor", 0.5 * (x + 0.5))
    return 2.0 * apply("floor", 0.5 * (x - 0.5)) + 1.0
