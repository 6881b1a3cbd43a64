"""Play of pin and bush by a fit of ISO 286, such as H7/g6 of 8 mm.

Holes A to H and JS, shafts a to h and js, grades IT01 to IT18, sizes up to 500 mm.  Other letters make interference, or
need corrections that depend on the grade, and are refused.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

from rattle.catalogue.tables import in_metres, in_mm, rows
from rattle.errors import InputError, WrongType, shown
from rattle.language.quantities import in_si

SOURCE = "ISO 286"
LARGEST = 500.0  # size [mm] up to which the standard's first tables go
SMALLEST_AB = 1.0  # size [mm] up to which the standard has no deviations a and b
SYMMETRIC = "js"  # deviations of half a tolerance to both sides
BEYOND = ("j", "k", "m", "n", "p", "r", "s", "t", "u", "v", "x", "y", "z", "za", "zb", "zc")  # letters not used here
DIGITS = 15  # of a deviation [m] behind the point: tables have 1e-7 m, beyond is rounding of binary numbers
LONGEST = 40  # characters of a text that is quoted
EXPECTED = "expected hole and shaft, such as 'H7/g6'"
USUAL = (  # fits that drawings use most, from little play to much
    "H6/h5", "H7/h6", "H6/g5", "H7/g6", "G7/h6", "H7/f7", "H8/f7", "F8/h6", "H8/e8", "E9/h9", "H8/d9", "H9/d9",
    "D10/h9", "H11/c11",
)  # fmt: skip
_HALF = re.compile(r"([A-Za-z]+)([0-9]+)")


@dataclass(frozen=True, slots=True)
class Fit:
    """A fit of ISO 286 at one diameter."""

    text: str  # such as "H7/g6"
    diameter: float  # nominal size [m]
    hole: tuple[float, float]  # deviations EI and ES from it [m]
    shaft: tuple[float, float]  # deviations ei and es [m]
    least: float  # play as the difference of the diameters [m]
    largest: float  # the same where the bore is largest and the pin smallest [m]
    radial: float  # mean radial play, a quarter of the sum of these [m]
    tol: float  # by how much the radial play of parts may differ from it [m]

    @property
    def bore(self) -> tuple[float, float]:
        """Deviation of the bore from the nominal size: its middle and half of its tolerance [m]."""
        return _middle(self.hole)

    @property
    def pin(self) -> tuple[float, float]:
        """Deviation of the pin from the nominal size: its middle and half of its tolerance [m]."""
        return _middle(self.shaft)

    @property
    def words(self) -> str:
        """The fit in one line: "H7/g6 of 8 mm: radial play 2.5 to 14.5 um"."""
        least, largest = (f"{play * 1e6 / 2.0:.6g}" for play in (self.least, self.largest))
        return f"{self.text} of {in_mm(self.diameter):.9g} mm: radial play {least} to {largest} um"

    @property
    def source(self) -> str:
        """Where the figures are from."""
        return SOURCE


def fit(text: str, diameter: str | float) -> Fit:
    """The play of a fit of ISO 286: `fit("H7/g6", "8 mm").radial` is 8.5e-6.

    text: hole and shaft with their grades; blanks do not matter.  diameter: nominal size, a text with a unit or a
    number in m, up to 500 mm.  Lengths of the answer are in m.

    Raises InputError for a text that is no fit, for letters beyond h (js apart), for sizes that the tables do not have,
    and for a fit that leaves no play at some sizes within its tolerances.
    """
    (hole_letter, hole_grade), (shaft_letter, shaft_grade) = _halves(text)
    name = f"{hole_letter.upper()}{hole_grade}/{shaft_letter}{shaft_grade}"
    size = _size(diameter, name)
    wide_hole, wide_shaft = _tolerance(hole_grade, size, name), _tolerance(shaft_grade, size, name)
    lower = _from_nominal(hole_letter, wide_hole, size, name, hole=True)
    upper = -_from_nominal(shaft_letter, wide_shaft, size, name, hole=False)
    hole, shaft = (lower, lower + wide_hole), (upper - wide_shaft, upper)  # [um]
    least, largest = hole[0] - shaft[1] + 0.0, hole[1] - shaft[0]  # not -0
    if least < 0.0:
        if largest <= 0.0:
            raise InputError(f"{name} of {size:g} mm is an interference of up to {-least:g} um: the pin has no play")
        raise InputError(
            f"{name} of {size:g} mm leaves no play at every part of the field: from {-least:g} um interference to"
            f" {largest:g} um play; holes A to H with shafts a to h always leave some"
        )
    return Fit(
        name, size / 1e3, _metres(hole), _metres(shaft), in_metres(least), in_metres(largest),
        in_metres((least + largest) / 4.0), in_metres((largest - least) / 4.0),
    )  # fmt: skip


def _middle(limits: tuple[float, float]) -> tuple[float, float]:
    """Middle and half width of two limits."""
    middle, half = (limits[0] + limits[1]) / 2.0, (limits[1] - limits[0]) / 2.0
    return round(middle, DIGITS), round(half, DIGITS)


def _metres(limits: tuple[float, float]) -> tuple[float, float]:
    return in_metres(limits[0] + 0.0), in_metres(limits[1] + 0.0)  # not -0


def _size(diameter: str | float, name: str) -> float:
    """The nominal size [mm].  Raises InputError outside 0 ... 500 mm."""
    if isinstance(diameter, bool) or not isinstance(diameter, str | int | float):
        raise WrongType(f"{name}: diameter is a length, as in '8 mm'; got {diameter!r:.40}")
    size = in_mm(in_si(diameter, f"{name}: diameter", "m", "'8 mm'"))
    if not math.isfinite(size):
        raise InputError(f"{name}: diameter {diameter} is not a finite length")
    if not 0.0 < size <= LARGEST:
        metres = "; a number is in metres: write '8 mm'" if not re.search(r"[a-z]", str(diameter)) else ""
        raise InputError(
            f"{name}: diameter {size:.9g} mm is outside 0 ... {LARGEST:g} mm, the sizes of the tables{metres}"
        )
    return size


# ---------------------------------------------------------------- the text
def _halves(text: str) -> tuple[tuple[str, str], tuple[str, str]]:
    """Letters, small, and grades of hole and shaft.  Raises InputError for what is no fit."""
    if not isinstance(text, str):
        raise WrongType(f"a fit is a text such as 'H7/g6'; got {text!r:.40}")
    tight = "".join(text.split())
    label = f"'{shown(tight[:LONGEST])}'"
    if not tight:
        raise InputError(f"the text of a fit is empty: {EXPECTED}")
    parts = tight.split("/")
    if len(parts) != 2:
        what = "has no shaft" if len(parts) == 1 else f"has {len(parts)} parts"
        raise InputError(f"{label} is not a fit: it {what}; {EXPECTED}")
    matches = [_HALF.fullmatch(part) for part in parts]
    for which, part, match in zip(("hole", "shaft"), parts, matches, strict=True):
        if match is None:
            raise InputError(
                f"{label} is not a fit: its {which} '{shown(part[:LONGEST])}' is no letter with a grade; {EXPECTED}"
            )
    (hole, hole_grade), (shaft, shaft_grade) = ((match[1], match[2]) for match in matches if match is not None)
    if not (hole.isupper() and shaft.islower()):
        parts = [hole.upper() + hole_grade, shaft.lower() + shaft_grade]
        if hole.islower() and shaft.isupper():
            parts = [shaft + shaft_grade, hole + hole_grade]
        raise InputError(
            f"{label}: the hole in capitals stands first, the shaft in small letters; did you mean '{'/'.join(parts)}'?"
        )
    _require_letter(hole, label, hole=True)
    _require_letter(shaft, label, hole=False)
    return (hole.lower(), hole_grade), (shaft, shaft_grade)


def _require_letter(letter: str, label: str, hole: bool) -> None:
    """Raise InputError for a letter without a table."""
    small = letter.lower()
    if small in _deviations() or small == SYMMETRIC:
        return
    which, last, symmetric = ("hole", "H", "JS") if hole else ("shaft", "h", "js")
    used = f"{'A' if hole else 'a'} to {last} and {symmetric} are known"
    if small in BEYOND:
        raise InputError(
            f"{label}: {which} {letter} lies beyond {last}: interference, or no play at every part of the field; {used}"
        )
    raise InputError(f"{label}: ISO 286 has no {which} with the letter '{letter[:LONGEST]}'; {used}")


# ---------------------------------------------------------------- the tables
def _deviations() -> Mapping[str, Mapping[str, str]]:
    """Rows of upper deviations [um] by the letter of the shaft."""
    return {row["letter"]: row for row in rows("iso286_deviations")}


def _in_range(row: Mapping[str, str], size: float) -> str:
    """The figure of the range of sizes that has this one; "" where the standard has none."""
    for title, figure in row.items():
        low, _, high = title.partition("-")
        if high and float(low) < size <= float(high):
            return figure
    return ""


def _tolerance(grade: str, size: float, name: str) -> float:
    """The standard tolerance of a grade [um].  Raises InputError for an unknown one."""
    grades = {row["grade"].removeprefix("IT"): row for row in rows("iso286_grades")}
    if grade not in grades:
        raise InputError(f"{name}: there is no grade {grade[:LONGEST]}; known: IT01, IT0, IT1 to IT18")
    return float(_in_range(grades[grade], size))


def _from_nominal(letter: str, tolerance: float, size: float, name: str, hole: bool) -> float:
    """How far the field of a letter lies off the nominal size, towards play [um]: EI of a hole, -es of a shaft."""
    if letter == SYMMETRIC:
        return -tolerance / 2.0
    written = letter.upper() if hole else letter
    if letter in ("a", "b") and size <= SMALLEST_AB:
        raise InputError(
            f"{name}: ISO 286 does not use {written} up to {SMALLEST_AB:g} mm; the diameter is {size:g} mm"
        )
    figure = _in_range(_deviations()[letter], size)
    if not figure:
        raise InputError(f"{name}: {written} exists up to 10 mm in ISO 286; the diameter is {size:g} mm")
    return -float(figure)
