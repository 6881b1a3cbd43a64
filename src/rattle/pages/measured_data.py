"""Measured curves in a scene: the page draws them beside its motion, and says what they differ by."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from rattle.exchange.measured import Measured, measured_curves, sources_of
from rattle.pages.scene import packed
from rattle.results.derived import rules, unit_of_rule
from rattle.value_types import Tree


class PackedCurve(NamedTuple):
    """A measured curve as a scene holds it."""

    curve: str
    label: str
    t: str  # base64 of 64-bit floats [s]
    y: str  # in SI units


def packed_curve(measured: Measured) -> PackedCurve:
    """A measured curve for a scene."""
    label = measured.file if measured.column == measured.curve else measured.label  # in any language
    return PackedCurve(measured.curve, label, packed(measured.t.astype("<f8")), packed(measured.values.astype("<f8")))


def units_of(scene: Tree) -> dict[str, str]:
    """The SI units of all curves that the motions of a scene have."""
    columns = scene["runs"][0] if scene["runs"] else scene["live"]
    stored = dict(zip(columns["names"], columns["units"], strict=True))
    further = rules(scene["geometry"], set(stored))
    return stored | {name: unit_of_rule(name, rule) for name, rule in further.items()}


def measured_in(scene: Tree, wanted: str | Path | Iterable[str | Path], shown: Sequence[str] = ()) -> list[Measured]:
    """The measured curves that texts ask for, beside those of a scene.

    shown: the curves that are shown at first.  Raises InputError with file and line.
    """
    units = units_of(scene)
    return [curve for source in sources_of(wanted) for curve in measured_curves(source, units, shown)]
