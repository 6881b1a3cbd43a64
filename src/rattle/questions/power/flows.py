"""Graph of the energy of a cycle, and places for its nodes and links on a sheet.

Nodes are bodies, what gives energy (left) and what takes it (right).  A link from body to body is a joint, or another
element between two bodies; what it does not pass on is lost or stored, or comes from outside.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.jit.choices import TINY
from rattle.plots.curves import BLUE
from rattle.plots.scene import BODIES

if TYPE_CHECKING:
    from rattle.questions.power.compute import Power

Array = NDArray[np.float64]
LEAST = 2e-3  # share of the largest link below which one is left out
NOISE = 1e-6  # share of the largest energy below which a net one counts as zero
# share of what goes back and forth below which a net energy is too thin to see and counts as zero: a motor that has
# given as much as it has taken stands on the left  (test_an_ideal_cycle_tells_what_goes_back_and_forth)
UNSEEN = 1e-3
HALF = 0.04  # width of a node, as a share of the distance of columns
GAP = 0.11  # between nodes of a column, as a share of the height of the sheet


class Node(NamedTuple):
    """A body (number, else -1), or what gives (source) or takes (sink, kept) energy: net, and back and forth [J]."""

    name: str
    body: int
    side: str
    net: float
    back: float


class Link(NamedTuple):
    """Energy [J] from one node to another: what stays there, and what goes back and forth; name: of a joint."""

    start: int
    end: int
    net: float
    back: float
    colour: str
    name: str = ""


class Sheet(NamedTuple):
    """Places of nodes and of the ends of links; the sheet is about 1 high, columns are 1 apart.

    A link across several columns is cut into pieces, with nodes (side "way") that keep room for it in between.
    """

    nodes: list[Node]
    links: list[Link]
    x: Array
    y: Array
    heights: Array
    ends: list[Array]  # of every link (2, 2)
    scale: float  # height per energy [1/J]
    columns: int
    lines: int  # nodes in the fullest column
    low: float
    high: float


class _Graph:
    """Nodes and links that are found one after the other; what is outside has one node on each side of the sheet."""

    def __init__(self, bodies: Sequence[str]) -> None:
        self.nodes = [Node(name, k, "body", 0.0, 0.0) for k, name in enumerate(bodies)]
        self.links: list[Link] = []

    def _outside(self, name: str, side: str, net: float, back: float) -> int:
        places = [k for k, node in enumerate(self.nodes) if (node.name, node.side) == (name, side)]
        if not places:
            self.nodes.append(Node(name, -1, side, net, back))
            return len(self.nodes) - 1
        node = self.nodes[places[0]]
        self.nodes[places[0]] = node._replace(net=node.net + net, back=node.back + back)
        return places[0]

    def from_outside(self, body: int, name: str, net: float, back: float) -> None:
        """Energy from an element to a body."""
        self.links.append(Link(self._outside(name, "source", abs(net), back), body, abs(net), back, BLUE))

    def to_outside(self, body: int, name: str, net: float, back: float, side: str = "sink") -> None:
        """Energy from a body to an element, or kept by the body."""
        node = self._outside(name, side, abs(net), back)
        self.links.append(Link(body, node, abs(net), back, BODIES[body % len(BODIES)]))

    def between(self, a: int, b: int, name: str, net: float, back: float) -> None:
        """Energy from body to body."""
        self.links.append(Link(a, b, net, back, BODIES[a % len(BODIES)], name))


def graph_of(p: Power) -> tuple[list[Node], list[Link]]:
    """Nodes and links of the net energies of a cycle; links that are too thin to see are left out."""
    cycle, names = p.cycle, p.names
    bodies = list(dict.fromkeys(names["body"]))
    graph = _Graph(bodies)
    ports: dict[str, list[tuple[int, float, float]]] = {}
    gains = np.zeros(len(bodies))
    for k, (element, body) in enumerate(zip(names["element"], names["body"], strict=True)):
        net, back = float(cycle.into[k] - cycle.out[k]), float(min(cycle.into[k], cycle.out[k]))
        gains[bodies.index(body)] += net
        ports.setdefault(element, []).append((bodies.index(body), net if abs(net) > UNSEEN * back else 0.0, back))
    nothing = NOISE * float(max((cycle.into + cycle.out).max(initial=0.0), TINY))
    for element, ends in ports.items():
        if len(ends) == 2 and element in p.between:
            _through(graph, element, *ends)
            continue
        for at, net, back in ends:
            gives = net > nothing or (net > -nothing and element in p.driven)
            (graph.from_outside if gives else graph.to_outside)(at, element, net, back)
    for at, (name, gained) in enumerate(zip(bodies, gains.tolist(), strict=True)):
        if gained >= 0.0:
            graph.to_outside(at, f"{name}, kinetic", gained, 0.0, "kept")
        else:
            graph.from_outside(at, f"{name}, kinetic", gained, 0.0)
    return _thick(graph)


def _thick(graph: _Graph) -> tuple[list[Node], list[Link]]:
    """The links that are thick enough to see, and the nodes that they join."""
    largest = max((link.net + link.back for link in graph.links), default=0.0)
    links = [link for link in graph.links if link.net + link.back > LEAST * largest]
    used = sorted({n for link in links for n in (link.start, link.end)})
    places = {n: k for k, n in enumerate(used)}
    links = [link._replace(start=places[link.start], end=places[link.end]) for link in links]
    return [graph.nodes[n] for n in used], links


def _through(graph: _Graph, name: str, a: tuple[int, float, float], b: tuple[int, float, float]) -> None:
    """An element between two bodies: what one gives the other gets; the rest is lost, or comes from outside."""
    giver, taker = (a, b) if a[1] <= b[1] else (b, a)
    passed = max(min(-giver[1], taker[1]), 0.0)
    graph.between(giver[0], taker[0], name, passed, min(a[2], b[2]))
    for body, net, _ in (giver, taker):
        (graph.to_outside if net < 0.0 else graph.from_outside)(body, name, abs(net) - passed, 0.0)


# ---------------------------------------------------------------- places
def lay_out(nodes: Sequence[Node], links: Sequence[Link]) -> Sheet:
    """Places on the sheet: bodies in columns by their distance from what gives energy."""
    column = _columns(nodes, links)
    nodes, links, column = _cut(nodes, [_onward(link, column) for link in links], column)
    last = int(column.max(initial=0))
    size = np.array([link.net + link.back for link in links])
    through = np.zeros((2, len(nodes)))
    for link, amount in zip(links, size, strict=True):
        through[0, link.start] += amount
        through[1, link.end] += amount
    tallest = max((through.max(axis=0)[column == c].sum() for c in range(last + 1)), default=0.0)
    scale = 1.0 / tallest if tallest > 0.0 else 1.0
    heights = scale * through.max(axis=0)
    y = np.zeros(len(nodes))
    order = {c: [k for k in range(len(nodes)) if column[k] == c] for c in range(last + 1)}
    for sweep in range(4):
        for c in range(last + 1) if sweep % 2 == 0 else range(last, -1, -1):
            if sweep:
                order[c].sort(key=lambda k: -_height_of_others(k, links, size, y))
            total = heights[order[c]].sum() + GAP * max(len(order[c]) - 1, 0)
            top = 0.5 * total
            for k in order[c]:
                y[k] = top - 0.5 * heights[k]
                top -= heights[k] + GAP
    x = column.astype(float)
    ends = _ends(nodes, links, scale * size, x, y)
    low, high = float((y - 0.5 * heights).min(initial=0.0)), float((y + 0.5 * heights).max(initial=0.0))
    lines = max((len(stack) for stack in order.values()), default=1)
    return Sheet(nodes, links, x, y, heights, ends, scale, last + 1, lines, low, high)


def _onward(link: Link, column: NDArray[np.int64]) -> Link:
    """A link that only goes back and forth leads from left to right, as those that lead somewhere."""
    turned = link.net == 0.0 and column[link.start] > column[link.end]
    return link._replace(start=link.end, end=link.start) if turned else link


def _cut(
    nodes: Sequence[Node], links: Sequence[Link], column: NDArray[np.int64]
) -> tuple[list[Node], list[Link], NDArray[np.int64]]:
    """Nodes, links and columns with links cut into pieces from one column to the next; one piece keeps the name."""
    every, pieces, columns = list(nodes), list[Link](), column.tolist()
    for link in links:
        a, b = columns[link.start], columns[link.end]
        between = list(range(a + 1, b)) if a < b else list(range(a - 1, b, -1))
        chain = [link.start, *range(len(every), len(every) + len(between)), link.end]
        every += [Node(link.name, -1, "way", 0.0, 0.0)] * len(between)
        columns += between
        for k, (start, end) in enumerate(itertools.pairwise(chain)):
            pieces.append(link._replace(start=start, end=end, name=link.name if k == len(between) // 2 else ""))
    return every, pieces, np.array(columns, np.int64)


def _columns(nodes: Sequence[Node], links: Sequence[Link]) -> NDArray[np.int64]:
    """Column of every node: sources 0, bodies behind those that feed them, what takes energy behind all bodies."""
    ways = _ways(nodes, links)
    column = np.array([0 if node.side == "source" else 1 for node in nodes], np.int64)
    for _ in nodes:
        for a, b in ways:
            column[b] = max(column[b], column[a] + 1)
    behind = int(column.max(initial=0)) + 1
    return np.where([node.side in ("sink", "kept") for node in nodes], behind, column)


def _ways(nodes: Sequence[Node], links: Sequence[Link]) -> set[tuple[int, int]]:
    """Pairs of bodies in the direction of their energy, the largest first, without circles.

    What only goes back and forth leads away from what gives most.
    """
    order = _distances(nodes, links)
    ways: set[tuple[int, int]] = set()
    inner = [link for link in links if nodes[link.start].body >= 0 and nodes[link.end].body >= 0]
    for link in sorted(inner, key=lambda flow: (flow.net < 0.05 * flow.back, -flow.net - flow.back)):
        a, b = link.start, link.end
        if link.net < 0.05 * link.back and order[a] > order[b]:
            a, b = b, a
        if not _leads(ways, b, a):
            ways.add((a, b))
    return ways


def _distances(nodes: Sequence[Node], links: Sequence[Link]) -> list[int]:
    """Number of links from the body that gets most from outside, to every body."""
    fed = [0.0] * len(nodes)
    for link in links:
        if nodes[link.start].side == "source":
            fed[link.end] += link.net + link.back
    far = [len(nodes)] * len(nodes)
    waiting = [int(np.argmax(fed))]
    far[waiting[0]] = 0
    while waiting:
        here = waiting.pop(0)
        for link in links:
            for end, other in ((link.start, link.end), (link.end, link.start)):
                if end == here and nodes[other].body >= 0 and far[other] == len(nodes):
                    far[other] = far[here] + 1
                    waiting.append(other)
    return far


def _leads(ways: set[tuple[int, int]], a: int, b: int) -> bool:
    """True if there is a way from a to b."""
    seen, waiting = {a}, [a]
    while waiting:
        here = waiting.pop()
        if here == b:
            return True
        following = {end for start, end in ways if start == here} - seen
        seen |= following
        waiting += following
    return False


def _height_of_others(k: int, links: Sequence[Link], size: Array, y: Array) -> float:
    """Mean height of what a node is linked with."""
    total, weight = 0.0, TINY
    for link, amount in zip(links, size, strict=True):
        if k in (link.start, link.end):
            total += amount * y[link.end if k == link.start else link.start]
            weight += amount
    return float(total / weight)


def _ends(nodes: Sequence[Node], links: Sequence[Link], width: Array, x: Array, y: Array) -> list[Array]:
    """Middles (2, 2) of both ends of every link; those of a node lie one below the other."""
    ends = [np.zeros((2, 2)) for _ in links]
    for k, node in enumerate(nodes):
        half = 0.0 if node.side == "way" else HALF
        for side in range(2):
            mine = [n for n, link in enumerate(links) if (link.start, link.end)[side] == k]
            other = [(links[n].end, links[n].start)[side] for n in mine]
            top = y[k] + 0.5 * width[mine].sum()
            for _, n in sorted(zip(other, mine, strict=True), key=lambda pair: -y[pair[0]]):
                ends[n][side] = x[k] + (half if side == 0 else -half), top - 0.5 * width[n]
                top -= width[n]
    return ends
