"""Straight-line code as text: one exact operation per statement; compilers that keep to IEEE 754 give the same bits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rattle.trace.graph import FLAGS, Graph


def statements(
    graph: Graph,
    outputs: Sequence[Any],
    forms: Mapping[str, str],
    number: Callable[[float], str],
    declare: Callable[[str, bool], str],
) -> list[str]:
    """Lines that read `in`, compute, and write `out`; flags come out as 1 or 0.

    forms: per operation a text with {0}, {1}, {2} for its operands; declare(name, flag): what stands before `= ...`.
    """
    rank = {place: n for n, place in enumerate(graph.inputs)}
    names: dict[int, str] = {}
    lines = []
    for place in graph.live(outputs):
        op = graph.ops[place]
        if op == "number":
            names[place] = number(graph.numbers[place])
            continue
        names[place] = f"x{place}"
        text = f"in[{rank[place]}]" if op == "input" else forms[op].format(*(names[k] for k in graph.operands[place]))
        lines.append(f"{declare(names[place], op in FLAGS)} = {text};")
    for n, x in enumerate(outputs):
        place = graph.place(x)
        value = names[place]
        lines.append(
            f"out[{n}] = {f'{value} ? {number(1.0)} : {number(0.0)}' if graph.ops[place] in FLAGS else value};"
        )
    return lines
