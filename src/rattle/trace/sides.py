"""Expressions on chosen branches: recorded with an input for every switch that says on which side of it they stand.

A run that ends its steps at switches evaluates each step on the branches of its start, see `language.bytecode`.  An
input is 1 or -1 for a side, 0 where the value of the switching function decides.  Where floor, mod and tables switch,
values decide always.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rattle.equations.system import System
from rattle.language import bytecode as code
from rattle.language.switching import Switch
from rattle.solvers.state_switches import see
from rattle.trace.graph import Symbol, select
from rattle.trace.recording import Recorder

INF = float("inf")


def stand_on_sides(recorder: Recorder, sides: Mapping[int, Symbol]) -> None:
    """Record expressions from now on with these inputs, by the row of their switch in the programs."""
    unary, binary, chosen = (recorder.recorded(one.python) for one in (code.unary, code.binary, code.chosen))
    table = recorder.recorded(code.read_table.python)

    def evaluate(rows: Any, const: Any, first: int, last: int, t: Any, body: Any, signals: Any, stack: Any) -> Any:
        held: list[Any] = []
        for row in range(first, last):
            op, k = (int(x) for x in rows[row, :2])
            if op <= code.SIGNAL:
                held.append(_read(op, k, const, t, body, signals))
                continue
            count = code.operands_of(op)
            given = held[-count:]
            del held[-count:]
            if op in (code.CURVE, code.BENT):
                held.append(table(const, k, 0, given[0], 0.0, 0.0)[0])
            elif op == code.CHOOSE:
                held.append(chosen(*given))
            else:
                way = unary if count == 1 else binary
                plain = _choice(op, *given) if op >= code.LESS else way(op, *given)
                held.append(_on_side(sides.get(row), plain, _branches(op, given, plain)))
        for n, one in enumerate(held):
            stack[n] = one
        return held[0]

    recorder.replace(code.evaluate, evaluate)


def landed_on(system: System) -> list[Switch]:
    """The switches that have two sides, those of time included."""
    ops = system.arrays["code"][:, 0]
    return [one for one in system.switches if ops[one.row] not in (code.FLOOR, code.MOD, code.BENT)]


def switching_functions(recorder: Recorder, system: System, t: Any, y: Any) -> list[Any]:
    """The switching functions of `landed_on` at t [s] and the state y, each in its own unit."""
    workspace = recorder.workspace(system)
    recorder.recorded(see.python)(workspace, t, y)
    evaluate, found = recorder.recorded(code.evaluate.python), []
    for one in landed_on(system):
        stack = workspace.stack.astype(object)
        evaluate(workspace.code, workspace.const, one.first, one.last, t, workspace.body, workspace.signals, stack)
        found.append(stack[0] - (stack[1] if one.count == 2 else 0.0))
    return found


def _read(op: int, k: int, const: Any, t: Any, body: Any, signals: Any) -> Any:
    if op == code.STATE:
        return body[k >> 3, k & 7]
    return t if op == code.TIME else (const if op == code.CONST else signals)[k]


def _on_side(side: Symbol | None, plain: Any, ways: tuple[Any, Any] | None) -> Any:
    if side is None or ways is None:
        return plain
    above, below = ways
    return select(side > 0.0, above, select(side < 0.0, below, plain))


def _branches(op: int, given: list[Any], plain: Any) -> tuple[Any, Any] | None:
    """Values for s > 0 and for s < 0; None for what is no switch, or has more than two."""
    x, y = given[0], given[1] if len(given) > 1 else 0.0
    one_of_two: Mapping[int, Callable[[], tuple[Any, Any]]] = {
        code.ABS: lambda: (x, -x), code.SIGN: lambda: (1.0, -1.0), code.STEP: lambda: (1.0, 0.0),
        code.MIN: lambda: (y, x), code.MAX: lambda: (x, y),
    }  # fmt: skip
    if op in one_of_two:
        return one_of_two[op]()
    if code.BELOW <= op <= code.ABOVE_OR_AT:
        sure = select(x == y, 0.5, 1.0)
        return (-sure, sure) if op <= code.BELOW_OR_AT else (sure, -sure)
    if op >= code.LESS:
        yes, no = (_finite(x, y, one, plain) for one in given[2:])
        return (no, yes) if op <= code.AT_MOST else (yes, no)
    return None


def _finite(x: Any, y: Any, far: Any, plain: Any) -> Any:
    """A branch; where the two compared are equal, only if it has a finite value."""
    if not any(isinstance(one, Symbol) for one in (x, y, far)):
        return far if x != y or abs(far) < INF else plain
    finite = (abs(far) < INF) if isinstance(far, Symbol) else bool(abs(far) < INF)
    if finite is True:
        return far
    return select(x == y, select(finite, far, plain), far)


def _choice(op: int, x: Any, y: Any, yes: Any, no: Any) -> Any:
    holds = {
        code.LESS: lambda: x < y, code.AT_MOST: lambda: x <= y, code.MORE: lambda: x > y, code.AT_LEAST: lambda: x >= y,
    }[op]()  # fmt: skip
    return select(holds, yes, no)
