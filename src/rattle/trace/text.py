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
    source: str = "in",
) -> list[str]:
    """Lines that read the array `source`, compute, and write `out`; flags come out as 1 or 0.

    forms: per operation a text with {0}, {1}, {2} for its operands; declare(name, flag): what stands before `= ...`.
    """
    return pieces(graph, outputs, forms, number, declare, source, len(graph) + 1)[0]


def pieces(
    graph: Graph, outputs: Sequence[Any], forms: Mapping[str, str], number: Callable[[float], str],
    declare: Callable[[str, bool], str], source: str, size: int,
) -> list[list[str]]:  # fmt: skip
    """The lines of `statements` in pieces of at most `size` operations, to be done one after the other.

    What later pieces read of earlier ones stands in an array `held` (flags as 1 or 0), of at most len(graph) numbers.
    """
    rank = {place: n for n, place in enumerate(graph.inputs)}
    live = graph.live(outputs)
    names = {place: number(graph.numbers[place]) if place in graph.numbers else f"x{place}" for place in live}
    made = [place for place in live if graph.ops[place] not in ("number", "input")]
    parts = [made[n : n + size] for n in range(0, len(made), size)] or [[]]
    piece = {place: n for n, part in enumerate(parts) for place in part}
    slots: dict[int, int] = {}  # of `held`
    for place in made:
        for k in graph.operands[place]:
            if k in piece and piece[k] < piece[place]:
                slots.setdefault(k, len(slots))
    texts = []
    for n, part in enumerate(parts):
        wanted = [graph.place(x) for x in outputs]
        ours = [k for k, place in enumerate(wanted) if piece.get(place, len(parts) - 1) == n]
        read = {k for place in part for k in graph.operands[place]} | {wanted[k] for k in ours}
        lines = []
        for place in sorted(read - set(part) - graph.numbers.keys()):
            flag = graph.ops[place] in FLAGS
            text = f"{source}[{rank[place]}]" if place in rank else f"held[{slots[place]}]"
            lines.append(f"{declare(names[place], flag)} = {text}{f' != {number(0.0)}' if flag else ''};")
        for place in part:
            op = graph.ops[place]
            text = forms[op].format(*(names[k] for k in graph.operands[place]))
            lines.append(f"{declare(names[place], op in FLAGS)} = {text};")
        stores = [(f"held[{slots[place]}]", place) for place in part if place in slots]
        for target, place in stores + [(f"out[{k}]", wanted[k]) for k in ours]:
            value = names[place]
            flagged = f"{value} ? {number(1.0)} : {number(0.0)}"
            lines.append(f"{target} = {flagged if graph.ops[place] in FLAGS else value};")
        texts.append(lines)
    return texts
