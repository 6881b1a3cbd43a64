"""The Schur complement S = Phi_q M^-1 Phi_q^T: its pattern, a fill-reducing order, sparse L D L^T.

S couples two rows only if they share a moving body.  The pattern is ordered and factored symbolically
once, in Python; the values are then filled in and factored in compiled loops that follow the pattern.

Storage: `s` holds the diagonal first (nr, in elimination order), then the columns of L below it.
"""

from __future__ import annotations

import functools
import heapq
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rattle.jit import layout as at
from rattle.jit.choices import assume
from rattle.jit.functions import compiled, native

PIVOT = 1e-13  # a pivot below this share of its diagonal belongs to a redundant row
WEAK = 1e-3  # below this share the solution is refined: the condition number of S is the square of that of Phi_q


class Pattern(NamedTuple):
    """The sparsity pattern that the compiled loops follow."""

    place: np.ndarray  # (nr,) position of each row in the elimination order
    first: np.ndarray  # (nr + 1,) first entry of each column of L in `below`
    below: np.ndarray  # (nl,) position of the row of each entry of L
    target: np.ndarray  # (nu,) entry of `s` that each update of the elimination changes
    pairs: np.ndarray  # (np, 6) entry of `s`, row, its first column, other row, its first column, body


def analyse(row_bodies: Sequence[tuple[int, int]], blocks: Sequence[range]) -> Pattern:
    """Order the rows for little fill-in and lay out the factor.

    row_bodies: bodies (A, B) of every row, 0 = ground.  blocks: the rows of each joint, which stay together.
    Mechanisms that differ in numbers only share one pattern, so that its arrays are read-only.
    """
    return _analysed(tuple(row_bodies), tuple(blocks))


Touching = dict[int, list[tuple[int, int]]]  # rows that touch a body, and their first column for it


def _fill_in(place: np.ndarray, touching: Touching) -> list[list[int]]:
    """Rows below every pivot in order, fill-in included; place: of every row in the elimination order."""
    below: list[set[int]] = [set() for _ in place]
    for members in touching.values():
        places = sorted({int(place[row]) for row, _ in members})
        for n, column in enumerate(places):
            below[column].update(places[n + 1 :])
    for rows in below:  # the rows below a pivot are inherited by the column of the first of them
        if rows:
            below[min(rows)] |= rows - {min(rows)}
    return [sorted(rows) for rows in below]


def _pairs(place: np.ndarray, touching: Touching, entry: list[dict[int, int]]) -> Sequence[tuple[int, ...]]:
    """Pairs of rows that share a body, as `Pattern.pairs` has them; entry: of `s`, by column and row."""
    pairs = []
    for body, members in touching.items():
        for n, (row, column) in enumerate(members):
            for other, other_column in members[: n + 1]:
                low, high = sorted((int(place[row]), int(place[other])))
                pairs.append((low if low == high else entry[low][high], row, column, other, other_column, body))
    return pairs


@functools.lru_cache(maxsize=64)
def _analysed(row_bodies: tuple[tuple[int, int], ...], blocks: tuple[range, ...]) -> Pattern:
    order = [row for block in _minimum_degree(row_bodies, blocks) for row in blocks[block]]
    nr = len(order)
    place = np.empty(nr, np.int64)
    place[order] = np.arange(nr)
    touching: Touching = {}
    for row, bodies in enumerate(row_bodies):
        for body, column in zip(bodies, (at.AX, at.BX), strict=True):
            if body:
                touching.setdefault(body, []).append((row, column))
    below = _fill_in(place, touching)
    first = np.zeros(nr + 1, np.int64)
    first[1:] = np.cumsum([len(rows) for rows in below])
    entry = [{row: nr + int(first[k]) + n for n, row in enumerate(rows)} for k, rows in enumerate(below)]
    target: list[int] = []
    for rows in below:
        for n, row in enumerate(rows):
            target += [row, *(entry[row][other] for other in rows[n + 1 :])]
    flat, pairs = [row for rows in below for row in rows], _pairs(place, touching, entry)
    lists = (np.array(flat, np.int64), np.array(target, np.int64), np.array(pairs, np.int64).reshape(-1, 6))
    pattern = Pattern(place, first, *lists)
    for array in pattern:
        array.flags.writeable = False
    return pattern


def _minimum_degree(row_bodies: Sequence[tuple[int, int]], blocks: Sequence[range]) -> list[int]:
    """Blocks in minimum-degree order: the one with fewest neighbours is eliminated, which connects its neighbours."""
    of_body: dict[int, list[int]] = {}
    for n, block in enumerate(blocks):
        for body in row_bodies[block[0]] if block else ():
            if body:
                of_body.setdefault(body, []).append(n)
    near: list[set[int]] = [set() for _ in blocks]
    for group in of_body.values():
        for n in group:
            near[n].update(group)
    for n, group_near in enumerate(near):
        group_near.discard(n)
    queue = [(len(group_near), n) for n, group_near in enumerate(near)]
    heapq.heapify(queue)
    done = [False] * len(blocks)
    order = []
    while queue:
        degree, n = heapq.heappop(queue)
        if done[n] or degree != len(near[n]):
            continue
        done[n] = True
        order.append(n)
        for neighbour in near[n]:
            near[neighbour] |= near[n]
            near[neighbour] -= {neighbour, n}
            heapq.heappush(queue, (len(near[neighbour]), neighbour))
    return order


@native("i", "h")
def factorise(m):
    """Fill S from the rows and factor it in place; returns the number of redundant rows.

    inverse[k] becomes 1 / pivot, or 0 for a redundant row: its multiplier is then zero.
    power[at.PIVOT_SHARE] becomes the smallest ratio of a pivot to its diagonal, if it is smaller than before;
    pivots_of_row has the ratios of all rows, and their ranges.
    """
    first, target, pairs = m.first, m.target, m.pairs
    weight, rows = m.weight, m.rows
    s, inverse, redundant, shares = m.schur, m.inverse, m.redundant, m.pivots_of_row
    nr = inverse.shape[0]
    for n in range(s.shape[0]):
        s[n] = 0.0
    for n in range(pairs.shape[0]):
        r, c = pairs[n, at.PAIR_ROW], pairs[n, at.PAIR_COLUMN]
        o, d = pairs[n, at.OTHER_ROW], pairs[n, at.OTHER_COLUMN]
        i = pairs[n, at.PAIR_BODY]
        s[pairs[n, at.PAIR_ENTRY]] += (
            rows[r, c] * weight[i, 0] * rows[o, d]
            + rows[r, c + 1] * weight[i, 1] * rows[o, d + 1]
            + rows[r, c + 2] * weight[i, 2] * rows[o, d + 2]
        )
    for k in range(nr):
        inverse[k] = s[k]  # the diagonal before elimination, for the pivot test
    lost = 0
    weakest = m.power[at.PIVOT_SHARE]
    u = 0
    for k in range(nr):
        pivot = s[k]
        if assume(pivot > PIVOT * inverse[k]):
            share = pivot / inverse[k]
            weakest = min(weakest, share)
            inverse[k] = 1.0 / pivot
            redundant[k] = 0
        else:
            share = 0.0
            inverse[k] = 0.0
            redundant[k] = 1
            lost += 1
        shares[k, at.SHARE_NOW] = share
        shares[k, at.SHARE_LEAST] = min(shares[k, at.SHARE_LEAST], share)
        shares[k, at.SHARE_MOST] = max(shares[k, at.SHARE_MOST], share)
        for a in range(nr + first[k], nr + first[k + 1]):
            x = s[a] * inverse[k]
            for b in range(a, nr + first[k + 1]):
                s[target[u]] -= x * s[b]
                u += 1
        for a in range(nr + first[k], nr + first[k + 1]):
            s[a] *= inverse[k]
    m.power[at.PIVOT_SHARE] = weakest
    return lost


@compiled
def solve(m):
    """Solve L D L^T x = x in place (x in elimination order)."""
    first, below = m.first, m.below
    s, inverse, x = m.schur, m.inverse, m.solution
    nr = inverse.shape[0]
    for k in range(nr):
        for a in range(first[k], first[k + 1]):
            x[below[a]] -= s[nr + a] * x[k]
    for k in range(nr - 1, -1, -1):
        value = x[k] * inverse[k]
        for a in range(first[k], first[k + 1]):
            value -= s[nr + a] * x[below[a]]
        x[k] = value
