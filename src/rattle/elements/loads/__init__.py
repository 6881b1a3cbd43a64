"""Loads: one kind per file, each a force or moment on one body or between two bodies."""

from __future__ import annotations

from typing import NamedTuple


class LoadRecord(NamedTuple):
    """What results and expressions know of a load between two points or bodies, besides its coordinate and the rate.

    coordinate: "length" between the points, or "angle" of B relative to A.  force: its force or moment as an expression
    over its fields, the coordinate and `rate`.  power: 1 if it does positive work where the coordinate grows with a
    positive force, -1 where it does so with a negative one.
    """

    coordinate: str
    unit: str  # of the force: N or N*m
    force: str
    power: float
