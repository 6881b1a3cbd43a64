"""Wear: the shipped slider-crank to a million turns with 360 bins in bush and pin, and one cycle of it."""

from __future__ import annotations

from functools import partial

import rattle as rt
from measure import Row, interleave, timed

MOST = 3  # repetitions


def study(cycles: float, jump: float | str) -> None:
    """Wear over so many turns."""
    rt.example("slider_crank_worn").wear(cycles, jump)


def rows(repeats: int) -> list[Row]:
    """Times of studies of wear."""
    samplers = {"million": timed(partial(study, 1e6, "auto")), "turns": timed(partial(study, 5.0, 1))}
    median = interleave(samplers, min(repeats, MOST))
    return [
        Row("wear of the slider-crank, 1e6 turns", median["million"], aim="20 s"),
        Row("6 turns of it, each simulated", median["turns"]),
    ]
