"""Recorded functions of a page as one tape of exact operations, which `viewer/tape.js` computes.

Functions that share operations share them on the tape, wherever they were recorded: an operation stands there once.
A slot is a place on the tape: first the inputs, then the numbers, then the operations, each after its operands.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from rattle.analyses.straight_line.recorded_arrays import RecordedArrays
from rattle.errors import InputError
from rattle.language.recorded import Operand
from rattle.pages.packed import packed
from rattle.trace.graph import EXACT, Graph

OPCODES = {op: code for code, op in enumerate(EXACT)}
PARAMETER = "p"  # the kind of input that seldom changes: what follows from such inputs alone is kept between calls
FAR = 64  # slots from which on an operand is written by its own slot: a few are read by operations all along the tape
Key = tuple[str, str | int]  # kind of an input, and which: ("p", "length"), ("row", 3)


class _Function(NamedTuple):
    inputs: list[int]  # places in the graph of the tape
    early: int  # how many of the inputs, from the first, are parameters
    outputs: list[int]


class Tape:
    """Functions of exact operations that are written together."""

    def __init__(self) -> None:
        self._graph, self._inputs, self._functions = Graph(), dict[Key, int](), list[_Function]()

    def add(self, graph: Graph, outputs: Sequence[Operand], inputs: Sequence[Key]) -> int:
        """Number on the tape of a function of exact operations.

        inputs: what the inputs of its graph are, in order; inputs of two functions with one key are the same ones.
        """
        if len(inputs) != len(graph.inputs):
            raise InputError(f"{len(graph.inputs)} inputs, but {len(inputs)} keys for them")
        tape = self._graph
        for key in inputs:
            if key not in self._inputs:
                self._inputs[key] = tape.input().place
        slots = dict(zip(graph.inputs, (self._inputs[key] for key in inputs), strict=True))
        for place in graph.live(outputs):
            op = graph.ops[place]
            if op == "number":
                slots[place] = tape.number(graph.numbers[place])
            elif op != "input":
                slots[place] = tape.join(op, tuple([slots[k] for k in graph.operands[place]]))
        early = next((k for k, (kind, _) in enumerate(inputs) if kind != PARAMETER), len(inputs))
        used = [self._inputs[key] for key in inputs]
        self._functions.append(_Function(used, early, [slots[graph.place(x)] for x in outputs]))
        return len(self._functions) - 1

    @property
    def operations(self) -> int:
        """How many operations stand on the tape."""
        return len(self._graph) - len(self._graph.inputs) - len(self._graph.numbers)

    def written(self) -> dict[str, Any]:
        """What `openTape` of tape.js reads, for JSON.

        counts: of inputs, numbers, operations; functions: of each the number of inputs, of those that are parameters,
        and of outputs.  content: opcodes, operands column by column, slots of the functions, numbers.
        """
        tape = self._graph
        operations, numbers, pairs = _order(tape)
        slots = {place: slot for slot, place in enumerate([*tape.inputs, *numbers, *operations])}
        slot_pairs = [(slots[k], slots[operand]) for k, operand in pairs]
        sides = [[slots[k] for k in side] for f in self._functions for side in (f.inputs, f.outputs)]
        content = bytes(OPCODES[tape.ops[place]] for place in operations)
        content += _varints(_references(slot_pairs, len(tape.inputs), len(numbers)))
        content += _varints(step for side in sides for step in _steps(side))
        content += _planes(np.array([tape.numbers[place] for place in numbers]))
        return {
            "counts": [len(tape.inputs), len(numbers), len(operations)],
            "functions": [[len(f.inputs), f.early, len(f.outputs)] for f in self._functions],
            "content": packed(content),
        }


def add_arrays(tape: Tape, recorded: RecordedArrays) -> int:
    """Number on a tape of the function whose outputs are whether the form holds, then entries of arrays and facts."""
    parameters = [(PARAMETER, name) for name in recorded.names]
    constants = [("constant", k) for k in range(len(recorded.graph.inputs) - len(parameters))]
    return tape.add(recorded.graph, [recorded.holds, *recorded.outputs], [*parameters, *constants])


def _order(tape: Graph) -> tuple[list[int], list[int], list[tuple[int, int]]]:
    """Operations and numbers as they are written, and each operation with its operands: all first ones, all second."""
    operations = [place for place in range(len(tape)) if tape.ops[place] not in ("input", "number")]
    pairs = [(k, tape.operands[k][n]) for n in range(3) for k in operations if len(tape.operands[k]) > n]
    used = (operand for _, operand in pairs)
    numbers = list(dict.fromkeys(k for k in (*used, *tape.numbers) if k in tape.numbers))
    return operations, numbers, pairs


def _references(pairs: Iterable[tuple[int, int]], inputs: int, numbers: int) -> Iterator[int]:
    """Operands, of (slot of an operation, slot of its operand), as few numbers that are often equal.

    1: the next number that was not used before; even ones: so many slots / 2 back; other odd ones: a slot, 2 slot + 3.
    """
    new = inputs
    for slot, operand in pairs:
        if operand == new < inputs + numbers:
            new += 1
            yield 1
        elif operand < inputs + numbers or slot - operand >= FAR:
            yield 2 * operand + 3
        else:
            yield 2 * (slot - operand)


def _steps(slots: Iterable[int]) -> Iterator[int]:
    """Steps from each slot to the next: even ones forwards, odd ones backwards."""
    before = 0
    for slot in slots:
        step = slot - before
        yield 2 * step if step >= 0 else -2 * step - 1
        before = slot


def _varints(values: Iterable[int]) -> bytes:
    """Whole numbers in groups of 7 bits, lowest first; the highest bit of a byte says that another one follows."""
    written = bytearray()
    for value in values:
        while value > 0x7F:
            written.append(value & 0x7F | 0x80)
            value >>= 7
        written.append(value)
    return bytes(written)


def _planes(numbers: np.ndarray) -> bytes:
    """The first bytes of all numbers, then the second ones: signs and exponents are like their neighbours."""
    return np.ascontiguousarray(numbers.astype("<f8").view(np.uint8).reshape(-1, 8).T).tobytes()
