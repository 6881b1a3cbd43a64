"""Functions of graphs as machine code: gathered first, compiled at once, called with arrays of samples in columns."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

import numpy as np

from rattle.language.recorded import Operand
from rattle.trace import llvm, llvm_chain
from rattle.trace.graph import Graph
from rattle.trace.lane_chain import Aside, Calls, Function


class MachineFunctions:
    """Functions (rows in (n_in, n), rows out (n_out, n)) of graphs of exact operations, for n a multiple of 8.

    Arrays are float64 and do not overlap, and each row is without gaps.  Functions may be called after `compile`, from
    several threads.
    """

    def __init__(self, width: int | None = None) -> None:
        self.width = llvm.width() if width is None else width
        self._functions: dict[str, tuple[Graph, Sequence[Operand]]] = {}
        self._code: llvm.MachineCode | None = None
        self._calls: dict[str, Callable[..., None]] = {}
        self._names: dict[Function, str] = {}

    def add(self, graph: Graph, outputs: Sequence[Operand]) -> Function:
        """A function that will be compiled with the others.

        It takes one register of samples at a time.  With two a function alone is 15 % faster, but the functions of a
        step then no longer fit into the cache of instructions together, and a step is slower.
        """
        name = f"f{len(self._functions)}"
        self._functions[name] = graph, outputs

        def call(rows_in: np.ndarray, rows_out: np.ndarray) -> None:
            self._calls[name](*_places(rows_in, rows_out))

        self._names[call] = name
        return call

    def compile(self) -> None:
        """Make the machine code of all functions."""
        names = list(self._names.values())
        origin = repr([self.width, *(described(*function) for function in self._functions.values())])
        self._code = llvm.compile(self._text, ["chain", *names], origin)
        self._calls = {name: self._code.function(name) for name in names}
        self._calls["chain"] = self._code.function("chain", *llvm_chain.KINDS)

    def _text(self) -> str:
        texts = [
            llvm.functions_text(graph, {name: all_}, self.width) for name, (graph, all_) in self._functions.items()
        ]
        return "\n".join([llvm_chain.CHAIN, *texts])

    def chain(self, calls: Calls, memory: np.ndarray, running: int, times: int) -> Callable[[], None]:
        """One call of many functions in turn, on every tile of a memory, so many times; see `Chain`."""
        asides = [call for call in calls if isinstance(call, Aside)]
        assert len(asides) <= 1
        aside = self._aside(asides[0], memory) if asides else []
        table = self._table(calls, memory, aside[0].ctypes.data if aside else 0)
        size, lanes = memory[0].size, memory.shape[2]
        rest = size, len(memory), times, running * lanes, lanes, aside[0].ctypes.data if aside else None

        def call(*_: object, kept: object = aside) -> None:
            self._calls["chain"](table.ctypes.data, table.size, memory.ctypes.data, *rest)

        return call

    def _table(self, calls: Calls, memory: np.ndarray, aside: int) -> np.ndarray:
        """Calls as `llvm_chain` reads them; aside: address of the aside among them."""
        assert self._code is not None
        addresses, start = self._code.addresses, memory.ctypes.data
        rows = [
            (0, aside, 0, 0, 0, 0) if isinstance(call, Aside)
            else (addresses[self._names[call[0]]], *_offsets(start, *_places(*call[1:])))
            for call in calls
        ]  # fmt: skip
        return np.array(rows, np.int64)

    def _aside(self, aside: Aside, memory: np.ndarray) -> list[np.ndarray]:
        """An aside as `llvm_chain` reads it, and the calls that it points to."""
        lanes, table = memory.shape[2], self._table(aside.calls, memory, 0)

        def at(rows: np.ndarray) -> int:
            assert rows.strides[-1] == 8
            assert rows.ndim == 1 or rows.strides[0] == 8 * lanes
            return rows.ctypes.data - memory.ctypes.data

        head = [lanes, at(aside.asks), at(aside.lane), at(aside.taken), table.ctypes.data, table.size]
        copies = [(at(source), at(target), len(source)) for source, target in aside.copies]
        larger = [(at(value), at(held)) for value, held in aside.larger]
        numbers = [*head, len(copies), len(larger), *itertools.chain(*copies, *larger)]
        return [np.array(numbers, np.int64), table]


def described(graph: Graph, outputs: Sequence[Operand]) -> tuple[object, ...]:
    """All that the text of a function depends on but its name."""
    live = graph.live(outputs)
    ops, operands, numbers = graph.ops, graph.operands, graph.numbers
    values = [numbers[place] for place in live if place in numbers]
    work = [ops[place] for place in live], [operands[place] for place in live], values
    return live, work, graph.inputs, [graph.place(x) for x in outputs]


def _offsets(start: int, rows_in: int, a: int, rows_out: int, b: int, n: int) -> tuple[int, int, int, int, int]:
    """Arguments of a function with distances from the start of the memory [bytes] for addresses."""
    return rows_in - start, a, rows_out - start, b, n


def _places(rows_in: np.ndarray, rows_out: np.ndarray) -> tuple[int, int, int, int, int]:
    """Arguments of a function, see `llvm.functions_text`."""
    assert rows_in.strides[1] == rows_out.strides[1] == 8
    a, b = rows_in.strides[0] // 8, rows_out.strides[0] // 8
    return rows_in.ctypes.data, a, rows_out.ctypes.data, b, rows_in.shape[1]
