"""Modes of contacts that are tried: the first that fits, and the equations of each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rattle.language.recorded import Flag, Operand
from rattle.trace.graph import Symbol, apply, select, summed

RAISED = 1e-8  # share by which diagonals of G are raised
SLIGHT = 1e-12  # share by which a bound may be missed: rounding
ALIKE = 1e-9  # share by which two solutions may differ that count as one


class Try(NamedTuple):
    """What slots do in some modes."""

    modes: Sequence[int]
    forces: list[list[Operand]]  # N and T of each
    gains: list[Operand]  # change of rates, or accelerations, by them
    fits: Flag


def first(tries: Sequence[Try]) -> tuple[list[list[Operand]], Flag, list[Operand]]:
    """N and T of each slot by the first try that fits; a flag: one motion does, whatever forces it has; its modes."""
    forces: list[list[Operand]] = [[0.0] * len(f) for f in tries[0].forces]
    modes: list[Operand] = [0.0] * len(forces)
    gains: list[Operand] = [0.0] * len(tries[0].gains)
    some: Flag = False
    double: Flag = False
    for this in tries:
        off = summed(abs(x - y) for x, y in zip(this.gains, gains, strict=True))
        size = summed(abs(x) + abs(y) for x, y in zip(this.gains, gains, strict=True))
        double = double | (this.fits & some & (off > ALIKE * size))
        takes = this.fits & apply("not", some)
        forces = [
            [select(takes, a, b) for a, b in zip(x, y, strict=True)] for x, y in zip(this.forces, forces, strict=True)
        ]
        gains = [select(takes, a, b) for a, b in zip(this.gains, gains, strict=True)]
        modes = [select(takes, float(mode), x) for mode, x in zip(this.modes, modes, strict=True)]
        some = some | this.fits
    return forces, some & apply("not", double), modes


def power(impulse: np.ndarray, rates: np.ndarray) -> Operand:
    """Of forces (bodies, 3) at the rates of the bodies; the ground has none."""
    total: Operand = 0.0
    for place in np.ndindex(impulse.shape):
        if place[0] > 0:
            total = total + impulse[place] * rates[place]
    return total


def add(target: np.ndarray, response: np.ndarray, force: Operand) -> None:
    """Add to a target what a force does to it, with its response to a unit force."""
    for place in np.ndindex(target.shape):
        if isinstance(response[place], Symbol) or response[place] != 0.0:
            target[place] = target[place] + response[place] * force


def solved(rows: list[list[Operand]]) -> list[Operand]:
    """x of A x = b from rows (A, b), by elimination as they stand: no pivot is looked for.

    Diagonals are raised by a share of RAISED, and what that has changed is taken back once: so equations that follow
    from others, as of two corners that stick at one wall, share what they bear.
    """
    if len(rows) == 1:
        return [rows[0][1] / rows[0][0]]
    a = [[x * (1.0 + RAISED) if r == c else x for c, x in enumerate(row[:-1])] for r, row in enumerate(rows)]
    factors = _eliminated(a)
    x = _substituted(a, factors, [row[-1] for row in rows])
    left = [row[-1] - summed(p * q for p, q in zip(row, x, strict=False)) for row in rows]
    return [p + q for p, q in zip(x, _substituted(a, factors, left), strict=True)]


def _eliminated(a: list[list[Operand]]) -> dict[tuple[int, int], Operand]:
    """Bring a (n, n) into upper triangular form; the factor by which each row was taken from each below it."""
    factors: dict[tuple[int, int], Operand] = {}
    for c in range(len(a)):
        for r in range(c + 1, len(a)):
            if not _is_zero(a[r][c]):
                factors[r, c] = a[r][c] / a[c][c]
                for j in range(c + 1, len(a)):
                    a[r][j] = a[r][j] - factors[r, c] * a[c][j]
    return factors


def _substituted(
    a: list[list[Operand]], factors: dict[tuple[int, int], Operand], right: Sequence[Operand]
) -> list[Operand]:
    """x by a and the factors of `_eliminated`, and the right sides."""
    b, x = list(right), list[Operand]([0.0] * len(a))
    for (r, c), factor in factors.items():
        b[r] = b[r] - factor * b[c]
    for r in reversed(range(len(a))):
        x[r] = (b[r] - summed(a[r][j] * x[j] for j in range(r + 1, len(a)))) / a[r][r]
    return x


def _is_zero(x: Operand) -> bool:
    return not isinstance(x, Symbol) and x == 0.0
