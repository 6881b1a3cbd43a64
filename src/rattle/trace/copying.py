"""Calculations made anew: of other operations, or with numbers or other symbols for inputs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from rattle.language.recorded import Operand
from rattle.trace.graph import Graph, Symbol


def copied(source: Graph, outputs: Sequence[Operand], change: Callable[..., Operand]) -> tuple[Graph, list[Operand]]:
    """The operations that the outputs need, made anew in another graph with the same inputs, and the outputs there.

    change(graph, op, *operands) makes one operation there.  The other graph is kept: every operation is made once,
    whatever is asked for next, so `change` must be the same one for a source.
    """
    if source._lowered is None:
        source._lowered = Graph(), {}
    graph, places = source._lowered
    for place in source.inputs[len(graph.inputs) :]:
        places[place] = graph.input()
    for place in source.live(outputs):
        if place not in places:
            op, operands = source.ops[place], source.operands[place]
            places[place] = (
                source.numbers[place] if op == "number" else change(graph, op, *[places[k] for k in operands])
            )
    return graph, [places[source.place(x)] for x in outputs]


def bind(graph: Graph, outputs: Sequence[Operand], values: Mapping[int, float]) -> tuple[Graph, list[Operand]]:
    """The calculation with numbers for some of its inputs, by place; the others stay, in order."""
    bound = Graph()
    places: dict[int, Operand] = {place: values[place] if place in values else bound.input() for place in graph.inputs}
    for place in graph.live(outputs):
        op = graph.ops[place]
        if op == "number":
            places[place] = graph.numbers[place]
        elif op != "input":
            places[place] = bound.apply(op, *(places[k] for k in graph.operands[place]))
    return bound, [places[graph.place(x)] for x in outputs]


def replaced(graph: Graph, outputs: Sequence[Operand], new: Mapping[int, Operand]) -> list[Operand]:
    """The outputs with other symbols or numbers for some inputs, by place, in the same graph."""
    places: dict[int, Operand] = {place: Symbol(graph, place) for place in graph.inputs} | dict(new)
    for place in graph.live(outputs):
        op = graph.ops[place]
        if op == "number":
            places[place] = graph.numbers[place]
        elif op != "input":
            places[place] = graph.apply(op, *(places[k] for k in graph.operands[place]))
    return [places[graph.place(x)] for x in outputs]
