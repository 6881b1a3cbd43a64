"""Impacts of a recorded model after Poisson, and energetic ones: as `impact_phases` and `impact_path` have them.

Poisson: all modes of the expansion are tried.  Energetic: of one contact, along its path, which has three pieces at
most: its slip ends once, and so does its compression.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

from rattle.language.recorded import Flag, Operand
from rattle.trace.graph import Graph, apply, both, select, summed
from rattle.trace.recorded_modes import SLIGHT, Try, first, solved

STICKS, FORWARD, BACKWARD = range(3)
PULLS = {STICKS: 0.0, FORWARD: -1.0, BACKWARD: 1.0}  # T / (mu N)
PIECES = 3


class Party(NamedTuple):
    """A contact that takes part in an impact."""

    taken: Flag  # there is one
    loose: Sequence[Flag]  # joints and drivers do not fix its gap, its slip
    mu: Operand
    restitution: Operand


def expanded(
    graph: Graph, g: list[list[Operand]], parties: Sequence[Party], pressed: list[list[Operand]], rates: list[Operand]
) -> tuple[list[list[Operand]], Flag]:
    """N and T of both phases from those of compression, and the rates before the impact; a flag: there is one way."""
    count, w = len(parties), len(pressed[0])
    flat = [x for pair in pressed for x in pair]
    terms = [[a * f for a, f in zip(row, flat, strict=True)] for row in g]
    before = [x + summed(row) for x, row in zip(rates, terms, strict=True)]
    slight = [SLIGHT * (abs(x) + summed(abs(y) for y in row)) for x, row in zip(rates, terms, strict=True)]
    least = [party.restitution * f[0] for party, f in zip(parties, pressed, strict=True)]
    ways = [FORWARD] if w == 1 else [STICKS, FORWARD, BACKWARD]
    tries = []
    for modes in itertools.product(itertools.product((False, True), ways), repeat=count):
        f = _expansion(g, before, parties, least, modes, w)
        every = [x for pair in f for x in pair]
        after = [x + summed(a * y for a, y in zip(row, every, strict=True)) for x, row in zip(before, g, strict=True)]
        gains = [x - y for x, y in zip(after, rates, strict=True)]  # of both phases: others are not known as well
        flags = [
            both(graph, _conditions(mode, party, f[k], least[k], after[w * k : w * k + w], slight[w * k]))
            for k, (mode, party) in enumerate(zip(modes, parties, strict=True))
        ]
        for k, (party, mode) in enumerate(zip(parties, modes, strict=True)):
            if mode == (False, FORWARD):  # the mode of a place without a contact
                flags[k] = flags[k] | apply("not", party.taken)
        tries.append(Try([0] * count, f, gains, both(graph, flags)))
    more, fits, _ = first(tries)
    return [[x + y for x, y in zip(old, new, strict=True)] for old, new in zip(pressed, more, strict=True)], fits


def _conditions(
    mode: tuple[bool, int], party: Party, force: Sequence[Operand], least: Operand, after: Sequence[Operand],
    slight: Operand,
) -> list[Flag]:  # fmt: skip
    """What has to hold of a contact in its mode; force: its N and T, least: of N, after: its rates, slight: of them."""
    (above, way), normal = mode, force[0]
    flags: list[Flag] = [party.taken]
    flags += [normal >= least, party.loose[0]] if above else [after[0] >= -slight]
    if way == STICKS:
        return [*flags, abs(force[1]) <= (1.0 + SLIGHT) * party.mu * normal, party.loose[1]]
    return flags if len(after) == 1 else [*flags, -PULLS[way] * after[1] >= 0.0]


def _expansion(
    g: list[list[Operand]], before: list[Operand], parties: Sequence[Party], least: list[Operand],
    modes: Sequence[tuple[bool, int]], w: int,
) -> list[list[Operand]]:  # fmt: skip
    """N and T of each in these modes; least: of N."""

    def per_normal(r: int, k: int) -> Operand:
        """What N of contact k, with the friction of its slip, does to rate r."""
        pull = PULLS[modes[k][1]]
        return g[r][w * k] if w == 1 or pull == 0.0 else g[r][w * k] + pull * parties[k].mu * g[r][w * k + 1]

    unknown = [
        (k, r)
        for k, (above, way) in enumerate(modes)
        for r in range(w)
        if (r == 0 and above) or (r == 1 and way == STICKS)
    ]
    rows = []
    for k, r in unknown:
        row = w * k + r
        known = summed(per_normal(row, j) * least[j] for j, (above, _) in enumerate(modes) if not above)
        rows.append([*(g[row][w * j + 1] if s else per_normal(row, j) for j, s in unknown), -(before[row] + known)])
    solution = dict(zip(unknown, solved(rows), strict=True)) if rows else {}
    result = []
    for k, (_, way) in enumerate(modes):
        normal = solution.get((k, 0), least[k])
        tangent = solution[k, 1] if way == STICKS else PULLS[way] * parties[k].mu * normal
        result.append([normal, tangent][:w])
    return result


def along_path(g: list[list[Operand]], party: Party, rate: Operand, slip: Operand) -> tuple[list[Operand], Flag]:
    """N and T of one energetic impact with friction, from the rates before it; a flag: it comes to its end."""
    mu, can = party.mu, party.loose[1] & (party.mu > 0.0)
    pressed: Operand = 0.0
    held: Operand = 0.0
    work: Operand = 0.0
    target: Operand = 0.0
    expands: Flag = False
    done: Flag = False
    for _ in range(PIECES):
        slides = apply("not", apply("equal", slip, 0.0))
        sense = select(slides, select(slip > 0.0, -1.0, 1.0), select(g[0][1] > 0.0, -1.0, 1.0))
        slides = slides | (abs(g[0][1]) > mu * g[1][1])
        grip = select(can, select(slides, sense * mu, -g[0][1] / g[1][1]), 0.0)
        slope = g[0][0] + grip * g[0][1]
        turn = select(can & slides, g[0][1] + grip * g[1][1], 0.0)
        to_rest = select(slip * turn < 0.0, -slip / turn, math.inf)
        rest = select(target > work, target - work, 0.0)
        lifted = (apply("sqrt", rate * rate + 2.0 * slope * rest) - rate) / slope
        whole = select(slope > 0.0, select(expands, lifted, -rate / slope), math.inf)
        ends = whole <= to_rest
        piece = select(done, 0.0, select(ends, whole, to_rest))
        work = work + piece * (rate + 0.5 * slope * piece)
        pressed, held, rate = pressed + piece, held + grip * piece, rate + slope * piece
        slip = select(ends, slip + turn * piece, 0.0)
        done = done | (ends & expands)
        turns = ends & apply("not", expands)
        rate, target = select(turns, 0.0, rate), select(turns, -party.restitution * party.restitution * work, target)
        work, expands = select(turns, 0.0, work), expands | turns
    return [pressed, held], done & (pressed < math.inf)
