"""Definitions in the order in which each follows those it uses, and those that use each other."""

from __future__ import annotations

from collections.abc import Mapping

from rattle.errors import MOST
from rattle.language.expression import Node, names

LONGEST_CYCLE = 10  # names that a message shows, at most


def in_order(nodes: Mapping[str, Node]) -> tuple[list[str], list[list[str]]]:
    """Names ordered so that each follows those it uses, and the first cycles found; names in cycles are left out."""
    uses = {name: sorted(names(node) & nodes.keys()) for name, node in nodes.items()}
    order: list[str] = []
    cycles: list[list[str]] = []
    depth: dict[str, int] = {}  # of names on the trail, -1 if finished
    for root in nodes:
        if root in depth:
            continue
        depth[root] = 0
        trail, ahead, back = [root], [iter(uses[root])], [1]  # back: depth of the outermost name that it leads back to
        while trail:
            for used in ahead[-1]:
                if used not in depth:
                    depth[used] = len(trail)
                    trail.append(used)
                    ahead.append(iter(uses[used]))
                    back.append(len(trail))
                    break
                if depth[used] >= 0:
                    back[-1] = min(back[-1], depth[used])
                    if len(cycles) < MOST:
                        cycles.append(trail[depth[used] : depth[used] + LONGEST_CYCLE + 1])
            else:
                name = trail.pop()
                ahead.pop()
                outermost = back.pop()
                if outermost > len(trail):
                    order.append(name)
                elif trail:
                    back[-1] = min(back[-1], outermost)
                depth[name] = -1
    return order, cycles


def describe_cycle(cycle: list[str]) -> str:
    """A cycle in words."""
    shown = cycle if len(cycle) <= LONGEST_CYCLE else [*cycle[: LONGEST_CYCLE - 1], "..."]
    return "defined by itself: " + " -> ".join([*shown, cycle[0]]) + "; one of them must not depend on the others"
