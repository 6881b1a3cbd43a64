"""Calculations made anew: of other operations, or with numbers or other symbols for inputs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rattle.trace.graph import Graph, Symbol


def copied(source: Graph, outputs: Sequence[Any], change: Callable[..., Any]) -> tuple[Graph, list[Any]]:
    """The operations that the outputs need, made anew in another graph with the same inputs, and the outputs there.

    change(graph, op, *operands) makes one operation there.  The other graph is kept: every operation is made once,
    whatever is asked for next, so `change` must be the same one for a source.
    """
    if source._lowered is None:
        source._lowered = Graph(), {}
    graph, made = source._lowered
    for place in source.inputs[len(graph.inputs) :]:
        made[place] = graph.input()
    for place in source.live(outputs):
        if place not in made:
            op, operands = source.ops[place], source.operands[place]
            made[place] = source.numbers[place] if op == "number" else change(graph, op, *[made[k] for k in operands])
    return graph, [made[source.place(x)] for x in outputs]


def bind(graph: Graph, outputs: Sequence[Any], known: Mapping[int, float]) -> tuple[Graph, list[Any]]:
    """The calculation with numbers for some of its inputs, by place; the others stay, in order."""
    bound = Graph()
    made: dict[int, Any] = {place: known[place] if place in known else bound.input() for place in graph.inputs}
    for place in graph.live(outputs):
        op = graph.ops[place]
        if op == "number":
            made[place] = graph.numbers[place]
        elif op != "input":
            made[place] = bound.apply(op, *(made[k] for k in graph.operands[place]))
    return bound, [made[graph.place(x)] for x in outputs]


def replaced(graph: Graph, outputs: Sequence[Any], new: Mapping[int, Any]) -> list[Any]:
    """The outputs with other symbols or numbers for some inputs, by place, in the same graph."""
    made: dict[int, Any] = {place: Symbol(graph, place) for place in graph.inputs} | dict(new)
    for place in graph.live(outputs):
        op = graph.ops[place]
        if op == "number":
            made[place] = graph.numbers[place]
        elif op != "input":
            made[place] = graph.apply(op, *(made[k] for k in graph.operands[place]))
    return [made[graph.place(x)] for x in outputs]
