"""Straight-line code as text: one exact operation per statement; compilers that keep to IEEE 754 give the same bits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from rattle.language.recorded import Operand
from rattle.trace.graph import FLAGS, Graph


def statements(
    graph: Graph,
    outputs: Sequence[Operand],
    forms: Mapping[str, str],
    number: Callable[[float], str],
    declare: Callable[[str, bool], str],
    source: str = "in",
) -> list[str]:
    """Lines that read the array `source`, compute, and write `out`; flags come out as 1 or 0.

    forms: per operation a text with {0}, {1}, {2} for its operands; declare(name, flag): what stands before `= ...`.
    """
    return pieces(graph, outputs, forms, number, declare, source, len(graph) + 1)[0]


def pieces(
    graph: Graph, outputs: Sequence[Operand], forms: Mapping[str, str], number: Callable[[float], str],
    declare: Callable[[str, bool], str], source: str, size: int,
) -> list[list[str]]:  # fmt: skip
    """The lines of `statements` in pieces of at most `size` operations, to be done one after the other.

    What later pieces read of earlier ones stands in an array `held` (flags as 1 or 0), of at most len(graph) numbers.
    """
    live = graph.live(outputs)
    names = {place: number(graph.numbers[place]) if place in graph.numbers else f"x{place}" for place in live}
    computed = [place for place in live if graph.ops[place] not in ("number", "input")]
    parts = [computed[n : n + size] for n in range(0, len(computed), size)] or [[]]
    piece = {place: n for n, part in enumerate(parts) for place in part}
    passed = (k for place in computed for k in graph.operands[place] if piece.get(k, piece[place]) < piece[place])
    slots = {place: slot for slot, place in enumerate(dict.fromkeys(passed))}
    rank = {place: n for n, place in enumerate(graph.inputs)}
    write = _Writer(graph, forms, number, declare, source, names, rank, slots)
    wanted = [graph.place(x) for x in outputs]
    return [
        write.piece(part, [(k, place) for k, place in enumerate(wanted) if piece.get(place, len(parts) - 1) == n])
        for n, part in enumerate(parts)
    ]


class _Writer(NamedTuple):
    """What writes lines of operations."""

    graph: Graph
    forms: Mapping[str, str]
    number: Callable[[float], str]
    declare: Callable[[str, bool], str]
    source: str
    names: Mapping[int, str]
    rank: Mapping[int, int]  # of inputs
    slots: Mapping[int, int]  # of `held`

    def piece(self, part: Sequence[int], outputs: Sequence[tuple[int, int]]) -> list[str]:
        """The lines of some operations, and of those outputs (number and place) that are written after them."""
        read = {k for place in part for k in self.graph.operands[place]} | {place for _, place in outputs}
        before = sorted(read - set(part) - self.graph.numbers.keys())
        stores = [(f"held[{self.slots[place]}]", place) for place in part if place in self.slots]
        stores += [(f"out[{k}]", place) for k, place in outputs]
        return [*map(self.read, before), *map(self.computed, part), *(self.stored(*store) for store in stores)]

    def read(self, place: int) -> str:
        """The line that reads an input, or what an earlier piece has held."""
        flag = self.graph.ops[place] in FLAGS
        text = f"{self.source}[{self.rank[place]}]" if place in self.rank else f"held[{self.slots[place]}]"
        return f"{self.declare(self.names[place], flag)} = {text}{f' != {self.number(0.0)}' if flag else ''};"

    def computed(self, place: int) -> str:
        """The line of an operation."""
        op = self.graph.ops[place]
        text = self.forms[op].format(*(self.names[k] for k in self.graph.operands[place]))
        return f"{self.declare(self.names[place], op in FLAGS)} = {text};"

    def stored(self, target: str, place: int) -> str:
        """The line that writes a value."""
        value = self.names[place]
        flagged = f"{value} ? {self.number(1.0)} : {self.number(0.0)}"
        return f"{target} = {flagged if self.graph.ops[place] in FLAGS else value};"
