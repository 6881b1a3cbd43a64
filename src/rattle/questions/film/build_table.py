"""Compute the table of films of finite length that is shipped: python -m rattle.questions.film.build_table [processes]

Solves some 7000 films by finite volumes, which takes a few minutes.  The file is written into the sources.
"""

from __future__ import annotations

import math
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from rattle.elements.film_table import FILE, NODES, RATIOS, Array, directions, eccentricities
from rattle.elements.short_film import short_integrals, short_peak
from rattle.questions.film.reynolds import FilmState, Grid, extrapolated, full_parts, solve_film

GRID = (512, 20)
NAMES = ("potential", "peak", "leakage", "full_peak", "full_leakage")


def main(processes: int) -> Path:
    """Compute the table in so many processes and write it; returns the place of the file."""
    tasks = [(float(ratio), float(e)) for ratio in RATIOS for e in eccentricities()]
    with ProcessPoolExecutor(processes) as pool:
        lines = list(pool.map(line, *zip(*tasks, strict=True)))
    shape = (len(RATIOS), NODES)
    table = {name: np.array([row[name] for row in lines]).reshape(*shape, NODES) for name in NAMES}
    table["full"] = np.moveaxis(np.array([row["full"] for row in lines]).reshape(*shape, 2), 1, 2)
    exact = ("potential", "full")
    kept: dict[str, Any] = {key: values if key in exact else values.astype(np.float32) for key, values in table.items()}
    np.savez_compressed(FILE, **kept)
    return FILE


def line(ratio: float, e: float) -> dict[str, Array]:
    """All nodes of one L/D and eccentricity e."""
    angles = directions(e) if e > 0.0 else np.full(NODES, 0.5 * math.pi)  # at the centre all are the same
    cavitated = [solve_film(e, float(alpha), ratio, fine=GRID) for alpha in angles]
    full, (along, across) = full_films(ratio, e, angles)
    s = math.sqrt((1.0 - e) * (1.0 + e))
    peaks = np.array([short_peak.python(e, float(alpha)) for alpha in angles])
    values = {"potential": potentials(cavitated, e, angles)}
    for kind, states in (("", cavitated), ("full_", full)):
        values[f"{kind}peak"] = np.log([state.peak for state in states] / peaks)
        values[f"{kind}leakage"] = np.log([state.leakage for state in states])
    short = math.pi * (1.0 + 2.0 * e * e) / s**5, math.pi / s**3
    values["full"] = np.log([along.normal / short[0], across.tangential / short[1]])
    return values


def potentials(states: list[FilmState], e: float, angles: Array) -> Array:
    """Lambda of films at the angles alpha [rad]."""
    return np.array([potential(state, e, float(alpha)) for state, alpha in zip(states, angles, strict=True)])


def potential(state: FilmState, e: float, alpha: float) -> float:
    """Lambda: logarithm of the ratio of a film's resistance along v to that of the short film."""
    s = math.sqrt((1.0 - e) * (1.0 + e))
    short = short_integrals.python(e * math.cos(alpha), -e * math.sin(alpha), s)[1]
    return math.log((state.normal * math.cos(alpha) + state.tangential * math.sin(alpha)) / short)


def full_films(ratio: float, e: float, angles: Array) -> tuple[list[FilmState], tuple[FilmState, FilmState]]:
    """Films without cavitation at the angles alpha [rad]; then for v along e and across it."""
    grids = [Grid(e, ratio, GRID[0] // part, GRID[1] // part) for part in (2, 1)]
    parts = [full_parts(grid) for grid in grids]

    def at(alpha: float) -> FilmState:
        states = (
            grid.state(math.cos(alpha) * even + math.sin(alpha) * odd, alpha)
            for grid, (even, odd) in zip(grids, parts, strict=True)
        )
        return extrapolated(*states)

    return [at(float(alpha)) for alpha in angles], (at(0.0), at(0.5 * math.pi))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1)
