"""The scoreboard: processor time at equal error against Exudyn and MuJoCo, for models that they can solve, too.

Every program is measured at several settings; its time at an error is read between them in logarithms, on the line of
its best settings.  Of each only the solver call is timed (of rattle the whole `simulate` call); a setting is the best
of some repetitions.  The results may be kept in a file, which a page of the documentation shows.
"""

from __future__ import annotations

from pathlib import Path

from measure import Row
from scoreboard import cases, curves, store


def rows(repeats: int, kept: Path | None = None) -> list[Row]:
    """One row per case and program, at the smallest error that both reach; all of it into the file `kept`."""
    here = cases.peers()
    if not here:
        return [Row("equal error", 0.0, 'Exudyn and MuJoCo are missing: pip install ".[bench]"')]
    measured = []
    found: list[Row] = []
    for case in cases.all_cases():
        points = curves.points_of(case, ("rattle", *here))
        measured.append((case, points))
        found += _rows(case, points, list(here))
    if kept is not None:
        store.write(kept, measured)
    return found


def _rows(case: curves.Case, points: list[curves.Point], programs: list[str]) -> list[Row]:
    """Time at the smallest error of the list that a program reaches, and ours."""
    found = []
    for program in programs:
        for row in reversed(store.equal(points)):
            if program in row and "rattle" in row:
                words = f"{program}, error {row['error']:.0e} {case.unit}"
                found.append(Row(case.title, row["rattle"], words, row[program]))
                break
    return found
