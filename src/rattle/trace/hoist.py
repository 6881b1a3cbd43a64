"""What a calculation does with some of its inputs alone, taken out of it: done once per sample, not at every step."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple

from rattle.language.recorded import Operand
from rattle.trace.graph import FLAGS, Graph, Symbol


class Hoisted(NamedTuple):
    """A calculation in two parts, both of exact operations."""

    early: Graph  # all inputs of the whole, of which it uses the early ones
    prepared: list[Symbol]  # its results
    late: Graph  # the other inputs of the whole in order, then one input for each result of the first part
    outputs: list[Symbol]


def hoist(graph: Graph, outputs: Sequence[Operand], early: Collection[int]) -> Hoisted:
    """Split a calculation of exact operations.

    early: places of the inputs that are known first.  The operations and their order stay, so bits do too.
    """
    live = graph.live(outputs)
    late, passed = _parted(graph, outputs, live, early)
    first, second = Graph(), Graph()
    before = {place: first.input().place for place in graph.inputs}  # places in the first part, and in the second
    after = {place: second.input().place for place in graph.inputs if place not in early}
    for place in passed:
        symbol = second.input()
        after[place] = (symbol != 0.0).place if graph.ops[place] in FLAGS else symbol.place
    for place in live:
        op = graph.ops[place]
        if op == "number":
            before[place], after[place] = first.number(graph.numbers[place]), second.number(graph.numbers[place])
        elif op != "input":  # it is simplified already
            target, places = (second, after) if place in late else (first, before)
            places[place] = target.join(op, tuple([places[k] for k in graph.operands[place]]))
    results = [Symbol(second, after[graph.place(x)]) for x in outputs]
    return Hoisted(first, [Symbol(first, before[place]) for place in passed], second, results)


def _parted(
    graph: Graph, outputs: Sequence[Operand], live: Sequence[int], early: Collection[int]
) -> tuple[set[int], list[int]]:
    """Places that depend on late inputs, and those of early results that the late part uses."""
    late = {place for place in graph.inputs if place not in early}
    for place in live:
        if any(k in late for k in graph.operands[place]):
            late.add(place)
    used = {k for place in live if place in late for k in graph.operands[place]} | {graph.place(x) for x in outputs}
    return late, [place for place in live if place in used and place not in late and graph.ops[place] != "number"]
