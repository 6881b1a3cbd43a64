"""Switches of expressions: abs, sign, step, floor, mod, min, max, comparisons, tables with kinks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from rattle.language import bytecode as p
from rattle.language.bytecode import SIGNAL, STATE, SWITCHES


@dataclass(frozen=True)
class Switch:
    """One switch in a program, in `row`, with its switching function, see `bytecode.switching`."""

    row: int
    first: int  # rows of the operands: first..last-1
    last: int
    count: int  # operands of the switching function, 1 or 2
    name: str  # path of the expression in the model
    timed: bool  # True: depends on time only
    driving: bool = False  # a driver depends on it


@dataclass(frozen=True)
class Signals:
    """Programs of all signals in order of evaluation; `rows` gives first row, last row + 1 and index of each.

    states: number of states of the model, whose indices come before those of signals and which have no program.

    code: (n, 4), const: (nc,) [SI], as in `language.expression.Program`.
    """

    code: np.ndarray
    const: np.ndarray
    rows: Sequence[tuple[int, int, int]]
    names: Sequence[str] = ()
    states: int = 0

    def used(self, spans: Iterable[tuple[int, int]]) -> set[int]:
        """Indices of the signals used by rows first..last-1 of any of the spans, directly or through other signals."""
        where = {k: (a, b) for a, b, k in self.rows}
        used: set[int] = set()
        ahead = list(spans)
        while ahead:
            a, b = ahead.pop()
            part = self.code[a:b]
            for k in part[part[:, 0] == SIGNAL, 1].tolist():
                if k not in used and k >= self.states:
                    used.add(k)
                    ahead.append(where[k])
        return used

    def of_state(self) -> set[int]:
        """Indices of the signals that depend on the state."""
        live = set(range(self.states))
        for a, b, k in self.rows:  # in order: what a signal uses comes before it
            part = self.code[a:b]
            if (part[:, 0] == STATE).any() or live & set(part[part[:, 0] == SIGNAL, 1].tolist()):
                live.add(k)
        return live


def find_switches(signals: Signals, used: Sequence[tuple[int, int, str, bool]]) -> list[Switch]:
    """Switches of the programs `used` (first row, last row + 1, path, used by a driver), nested switches first.

    Signals that are only recorded are left out: the motion does not depend on them.
    """
    wanted = signals.used((a, b) for a, b, _, _ in used)
    driving = signals.used((a, b) for a, b, _, drives in used if drives)
    named = zip(signals.rows, signals.names, strict=True)
    spans = [(a, b, name, k in driving) for (a, b, k), name in named if k in wanted]
    of_state = signals.of_state()
    return [switch for span in (*spans, *used) for switch in _switches_of(signals.code, of_state, *span)]


def _switches_of(
    code: np.ndarray, of_state: set[int], first: int, last: int, name: str, driving: bool
) -> Iterator[Switch]:
    """Switches of one program in order of evaluation."""
    stack: list[tuple[int, bool]] = []  # operands on the stack: first row, depends on the state
    for row in range(first, last):
        op, k = int(code[row, 0]), int(code[row, 1])
        if op <= SIGNAL:
            stack.append((row, op == STATE or (op == SIGNAL and k in of_state)))
            continue
        count = p.operands_of(op)
        operands = stack[-count:]
        del stack[-count:]
        stack.append((operands[0][0], any(live for _, live in operands)))
        if op in SWITCHES:
            end = operands[2][0] if count == 4 else row
            timed = not any(live for _, live in operands[:2])
            yield Switch(row, operands[0][0], end, min(count, 2), name, timed, driving)
