"""Internal play of rolling bearings, by their number or by bore and group: before mounting, at rest, unloaded.

The tables hold the whole radial movement of one ring in the other; the radial play of a joint is half of it.  An
interference of the seats and heat make it smaller, which is not computed.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from rattle.catalogue.tables import Row, in_metres, in_mm, rows
from rattle.errors import InputError, WrongType, shown, suggest
from rattle.language.quantities import in_si

GROUPS = ("C2", "CN", "C3", "C4", "C5")  # of play, from little to much
NORMAL = "CN"  # the group of a bearing whose number names none
BALL, ROLLER = "ball", "roller"
KINDS = {BALL: "deep_groove_ball", ROLLER: "cylindrical_roller"}  # tables by the kind of bearing
WORDS = {BALL: "deep-groove ball bearing", ROLLER: "cylindrical roller bearing"}
ROLLER_SOURCE = "maker's table of radial internal clearance, read in one place"
KEYS = ("number", "bore", "group", "kind", "capacity")
EXPONENTS = {BALL: 3.0, ROLLER: 10.0 / 3.0}  # of the basic rating life, ISO 281
MILLION = 1e6  # turns of a bearing whose load is its capacity, of which 90 % survive
USUAL = ("608", "6000", "6001", "6002", "6003", "6004", "6005", "6200", "6201", "6202", "6203", "6204", "6205", "6206",
         "6208", "6208 C3", "6304", "6305", "6306")  # fmt: skip
FIRST_BORES = {"00": 10.0, "01": 12.0, "02": 15.0, "03": 17.0}  # [mm] by the last digits; from 04 on 5 mm times them
STEP = 5.0  # [mm]
LONGEST = 40  # characters of a text that is quoted
EXAMPLE = 'expected the number of a deep-groove ball bearing, such as \'6208 C3\', or { bore = "40 mm", group = "C3" }'
SERIES = "618 619 160 60 62 63 64"  # of deep-groove ball bearings
_LONG = re.compile(rf"(?:{SERIES.replace(' ', '|')})([0-9]{{2}})")  # series, and the code of the bore
_SHORT = re.compile(r"6[023]([0-9])")  # series, and the bore in mm
_SUFFIX = re.compile(r"(?!C)(?:[0-9]?[A-Z]{1,4}[0-9]?)")  # seals, cages, precision: nothing that changes the play
_GLUED = re.compile(r"([0-9]+)([A-Z].*)")  # 6208ZZ, 6208C3


@dataclass(frozen=True, slots=True)
class BearingPlay:
    """The radial play of a rolling bearing before mounting."""

    radial: float  # mean radial play [m]
    tol: float  # by how much bearings may differ from it [m]
    bore: float  # of the inner ring, its diameter [m]
    group: str  # of play: "C2" to "C5", CN the normal one
    least: float  # the whole radial movement as tables have it [m]
    largest: float  # of bearings with much play [m]
    title: str  # what bearing it is
    source: str  # where the figures are from
    capacity: float = math.nan  # basic dynamic radial load rating C, of its catalogue [N]
    exponent: float = EXPONENTS[BALL]  # of the basic rating life

    @property
    def words(self) -> str:
        """The bearing in one line: "6208 C3: radial play 7.5 to 16.5 um, before mounting"."""
        least, largest = (f"{movement * 1e6 / 2.0:.6g}" for movement in (self.least, self.largest))
        return f"{self.title}: radial play {least} to {largest} um, before mounting"

    def turns(self, load: float) -> float:
        """Turns that 90 % of such bearings survive under an equivalent load [N]: 1e6 (C/P)^p, nan without capacity.

        Source: ISO 281, basic rating life.
        """
        if load == 0.0:
            return math.nan if math.isnan(self.capacity) else math.inf
        return float(MILLION * (self.capacity / load) ** self.exponent)


def bearing(written: str | Mapping[str, Any]) -> BearingPlay:
    """The radial play of a rolling bearing: `bearing("6208 C3").radial` is 12e-6.

    written: the number of a deep-groove ball bearing with its group of play (CN if none is named; seals and cages do
    not matter), or a table of `number`, or of `bore` (text with a unit, or a number in m), `group` and `kind` ("ball",
    or "roller" for a cylindrical roller bearing), each with `capacity`, the basic dynamic load rating of its catalogue,
    if lives are asked for.  Lengths of the answer are in m.

    Raises InputError for other numbers, unknown groups and keys, and bores without a table.
    """
    if isinstance(written, Mapping):
        return _by_table(written)
    return _by_number(written)


def _by_number(written: object) -> BearingPlay:
    """The play of a deep-groove ball bearing by its number."""
    if not isinstance(written, str):
        raise WrongType(f"bearing: {EXAMPLE}; got {written!r:.40}")
    number, *others = _parts(written)
    label = f"bearing '{shown(written.strip()[:LONGEST])}'"
    group = ""
    for part in others:
        if _SUFFIX.fullmatch(part):
            continue
        if group or not part.startswith("C"):
            what = "a second group of play" if group and part in GROUPS else "nothing that is known behind a number"
            raise InputError(f'{label}: {part} is {what}; for others write {{ bore = "40 mm", group = "C3" }}')
        group = part
    _require_group(group or NORMAL, label)
    return _play(BALL, _bore_of(number, label), group or NORMAL, " ".join([number, *([group] if group else [])]), label)


def _parts(written: str) -> list[str]:
    """The number and what stands behind it, in capitals."""
    parts = [part for part in re.split(r"[\s/,;-]+", written.upper()) if part]
    if parts and (glued := _GLUED.fullmatch(parts[0])):
        parts[:1] = glued.groups()
    if not parts:
        raise InputError(f"bearing: the text is empty; {EXAMPLE}")
    return parts


def _bore_of(number: str, label: str) -> float:
    """The bore [mm] that a number says.  Raises InputError for numbers of other bearings."""
    if match := _LONG.fullmatch(number):
        return FIRST_BORES.get(match[1], STEP * int(match[1]))
    if (match := _SHORT.fullmatch(number)) and match[1] != "0":
        return float(match[1])
    raise InputError(
        f"{label}: '{shown(number[:LONGEST])}' is no number of a deep-groove ball bearing (series {SERIES});"
        ' for others write { bore = "40 mm", group = "C3", kind = "ball" or "roller" }'
    )


def _by_table(written: Mapping[str, Any]) -> BearingPlay:
    """The play of a bearing by its number or its bore, with its capacity."""
    for key in written:
        if key not in KEYS:
            raise InputError(f"bearing: unknown key '{shown(str(key)[:LONGEST])}'{suggest(str(key), KEYS)}")
    both = [key for key in ("bore", "group", "kind") if key in written]
    if "number" in written and both:
        raise InputError(f"bearing: the number says the {both[0]}; leave one of them out")
    play = _by_number(written["number"]) if "number" in written else _by_bore(written)
    if "capacity" not in written:
        return play
    capacity = written["capacity"]
    if isinstance(capacity, bool) or not isinstance(capacity, str | int | float):
        raise WrongType(f"bearing: capacity is a force, as in '29 kN'; got {capacity!r:.40}")
    force = in_si(capacity, "bearing: capacity", "N", "'29 kN'")
    if not (math.isfinite(force) and force > 0.0):
        raise InputError(f"bearing: the capacity must be positive; got {capacity!r:.40}")
    return replace(play, capacity=force, exponent=EXPONENTS[str(written.get("kind", BALL))])


def _by_bore(written: Mapping[str, Any]) -> BearingPlay:
    """The play of a bearing by its bore, group and kind."""
    if "bore" not in written:
        raise InputError(f"bearing: the bore is missing; {EXAMPLE}")
    bore, kind, group = written["bore"], written.get("kind", BALL), written.get("group", NORMAL)
    if kind not in (BALL, ROLLER):
        raise InputError(f"bearing: unknown kind {kind!r:.40}; expected '{BALL}' or '{ROLLER}'")
    if isinstance(bore, bool) or not isinstance(bore, str | int | float):
        raise WrongType(f"bearing: bore is a length, as in '40 mm'; got {bore!r:.40}")
    _require_group(group, "bearing")
    size = in_mm(in_si(bore, "bearing: bore", "m", "'40 mm'"))
    if not (math.isfinite(size) and size > 0.0):
        raise InputError(f"bearing: the bore must be positive; got {bore!r:.40}")
    title = f"{WORDS[kind]} of {size:.9g} mm bore, {group}"
    return _play(kind, size, group, title, f"bearing of {size:.9g} mm bore")


def _require_group(group: object, label: str) -> None:
    """Raise InputError for an unknown group of play."""
    if group not in GROUPS:
        raise InputError(f"{label}: unknown group of play {group!r:.40}; expected one of {', '.join(GROUPS)}")


def _play(kind: str, bore: float, group: str, title: str, label: str) -> BearingPlay:
    """The figures of a table.  Raises InputError where it has none for this bore [mm]."""
    row = _row(kind, bore, label)
    least, largest = float(row[f"{group}_min"]), float(row[f"{group}_max"])
    return BearingPlay(
        in_metres((least + largest) / 4.0), in_metres((largest - least) / 4.0), bore / 1e3, group,
        in_metres(least), in_metres(largest), title, row.get("source", ROLLER_SOURCE),
    )  # fmt: skip


def _row(kind: str, bore: float, label: str) -> Row:
    """The row of a table whose range has this bore [mm], over the first figure up to and including the other."""
    table = rows(KINDS[kind])
    for row in table:
        if float(row["over_mm"]) < bore <= float(row["to_mm"]):
            return row
    low, high = float(table[0]["over_mm"]), float(table[-1]["to_mm"])
    if bore > high:
        raise InputError(f"{label}: no checked table above {high:g} mm for a {WORDS[kind]}; give `clearance`")
    raise InputError(f"{label}: no table for a {WORDS[kind]} of {bore:.9g} mm bore: it starts above {low:g} mm")
