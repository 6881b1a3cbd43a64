"""Measured curves beside those of a run: which file, column, curve and offset in time, as one text.

    measured.csv                            every column that belongs to a curve
    measured.csv:theta                      one column
    measured.csv:theta=rocker.angle         and the curve that it belongs to
    measured.csv:theta=rocker.angle@0.2s    and what is added to its times

Without a curve a column belongs to the curve of its own name, or else to the only curve of its unit among those that
are shown.  A column without a unit is in the SI unit of its curve.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.description.read_values import quoted
from rattle.errors import InputError, WrongType, suggest
from rattle.exchange.recording import Recording, Title, read_recording
from rattle.language.times import seconds
from rattle.language.units import DIMENSIONLESS, Dimension, describe, dimension_of, zero_of
from rattle.results.chosen_units import si_unit
from rattle.user_paths import expanded

Array = NDArray[np.float64]
LONGEST = 30  # characters of a name in a picture
MOST_CURVES = 12  # columns of a file that are shown where nobody names one
_log = logging.getLogger("rattle")
HOW = "say which, such as {file}:{column}={curve}"


def shortened(name: str) -> str:
    """A name with its middle left out, if it is too long for a picture."""
    return name if len(name) <= LONGEST else f"{name[: LONGEST // 2]}...{name[-LONGEST // 3 :]}"


class Wanted(NamedTuple):
    """What a text asks for; an empty column, or curve: what belongs together by itself."""

    path: Path
    column: str = ""  # with its curve after `=`, until the head of the file is known
    offset: float = 0.0  # added to its times [s]


class Measured(NamedTuple):
    """A measured curve that belongs to a curve of a run."""

    curve: str
    column: str
    file: str
    t: Array  # (n,) on the time of the run [s]
    values: Array  # (n,) in the SI unit of the curve
    unitless: bool = False  # its file says no unit

    @property
    def label(self) -> str:
        """What pictures call it."""
        column = "measured" if self.column == self.curve else shortened(self.column)
        return f"{column} ({shortened(self.file)})"


def measured_curves(wanted: str | Path, units: Mapping[str, str], shown: Sequence[str] = ()) -> list[Measured]:
    """The measured curves that a text asks for, see above.

    units: the SI unit of each curve of a run.  shown: the curves that are shown.  Raises InputError for what does not
    fit, with file and line.
    """
    asked = read_wanted(wanted)
    recording = read_recording(asked.path)
    pairs = _pairs(recording, asked.column, units, shown)
    return [measured(recording, title, curve, units[curve], asked.offset) for title, curve in pairs]


# ---------------------------------------------------------------- what is asked for
def require_readable(wanted: str | Path | Iterable[str | Path]) -> None:
    """Refuse files of measured curves that cannot be read, before anything runs.  Raises InputError, OSError."""
    for source in sources_of(wanted):
        read_recording(read_wanted(source).path)


def sources_of(wanted: str | Path | Iterable[str | Path]) -> list[str | Path]:
    """One or several sources as a list."""
    return [wanted] if isinstance(wanted, str | Path) else list(wanted)


def read_wanted(text: str | Path) -> Wanted:
    """What a text asks for.  Raises InputError where there is no file, or for an offset that is no time."""
    if isinstance(text, Path):
        return Wanted(text)
    if not isinstance(text, str):
        raise WrongType(f"expected a measured curve such as 'measured.csv:theta', got {text!r}")
    end = _file_end(text)
    rest, at, offset = text[end:].rpartition("@")
    if not at:
        rest, offset = text[end:], ""
    elif not _is_time(offset):
        if offset.strip()[:1] in "+-.0123456789":
            seconds(offset, f"{text}: the offset in time")
        rest, offset = text[end:], ""
    column = rest.removeprefix(":").strip()
    if rest and not column:
        raise InputError(f"{quoted(text)}: a name of a column is missing after ':'")
    return Wanted(Path(text[:end]), column, seconds(offset, "the offset in time") if offset else 0.0)


def _file_end(text: str) -> int:
    """Where the name of the file ends in a text.  Raises InputError where there is no file."""
    if _is_file(text):
        return len(text)
    cuts = [k for k, sign in enumerate(text) if sign in ":@" and k > 1]  # C:\... is a path
    end = next((k for k in reversed(cuts) if _is_file(text[:k])), None)
    if end is None:
        raise InputError(f"there is no file {quoted(text[: cuts[0]] if cuts else text)}")
    return end


def without_folder(text: str) -> str:
    """The same text with the name of the file alone."""
    end = _file_end(text)
    return Path(text[:end]).name + text[end:]


def _is_file(text: str) -> bool:
    try:
        return expanded(text).is_file()
    except (OSError, ValueError):  # too long, or with signs that no name of a file has
        return False


def _is_time(text: str) -> bool:
    try:
        seconds(text, "")
    except ValueError:
        return False
    return True


# ---------------------------------------------------------------- which curve it is
def _pairs(
    recording: Recording, column: str, units: Mapping[str, str], shown: Sequence[str]
) -> list[tuple[Title, str]]:
    """Columns and the curves that they belong to: the column that is asked for, or all that belong to one."""
    if column:
        title, curve = _named(recording, column)
        if curve and curve not in units:
            raise InputError(f"{recording.file}: the run has no curve {quoted(curve)}{suggest(curve, units)}")
        return [(title, curve or curve_of(recording, title, units, shown))]
    pairs = belonging(recording, units, shown)
    if not pairs:
        how = _how(recording, recording.columns[0], units, shown)
        there = f"there are {recording.listed}"
        raise InputError(f"{recording.file}: no column belongs to a curve that is shown; {there}; {how}")
    if len(pairs) > MOST_CURVES:
        raise InputError(f"{recording.file}: {len(pairs)} columns are called as curves are; name those to be shown")
    beside = [title.text for title in recording.columns if title not in [column for column, _ in pairs]]
    if beside:
        more = " ..." if len(beside) > MOST_CURVES else ""
        _log.info(f"{recording.file}: not shown: {', '.join(beside[:MOST_CURVES])}{more}")
    return pairs


def _named(recording: Recording, text: str) -> tuple[Title, str]:
    """The column that a text names, and the curve behind `=`, "" without one."""
    column, equals, curve = text.rpartition("=")
    if not equals or any(text in (title.name, title.text) for title in recording.columns):
        return recording.column(text), ""
    if not curve.strip():
        raise InputError(f"{recording.file}: the name of a curve is missing in {quoted(text)}")
    return recording.column(column.strip()), curve.strip()


def belonging(recording: Recording, units: Mapping[str, str], shown: Sequence[str]) -> list[tuple[Title, str]]:
    """The columns that belong to a curve by themselves, with that curve.

    Those called as a curve is, if it is shown or nothing is; others if no second column could be meant.
    """
    named = [title for title in recording.columns if title.name in units]
    pairs = [(recording.column(title.name), title.name) for title in named if not shown or title.name in shown]
    others = [title for title in recording.columns if title not in named and recording.begins_with_a_number(title)]
    with_unit = [title for title in others if title.unit is not None]
    pairs += _by_unit(recording, with_unit, units, [name for name in shown if name not in _curves_of(pairs)])
    without = [title for title in others if title.unit is None]
    pairs += _by_unit(recording, without, units, [name for name in shown if name not in _curves_of(pairs)])
    return pairs


def _curves_of(pairs: Sequence[tuple[Title, str]]) -> set[str]:
    return {curve for _, curve in pairs}


def _by_unit(
    recording: Recording, titles: Sequence[Title], units: Mapping[str, str], shown: Sequence[str]
) -> list[tuple[Title, str]]:
    """The columns among these that belong to the only curve of their unit.  Raises InputError if two belong to one."""
    belong: dict[str, Title] = {}
    for title in titles:
        curve = _only_of_its_unit(recording, title, units, shown)
        if curve in belong:
            how = _how(recording, title, units, [curve])
            raise InputError(f"{recording.place}: {belong[curve].text} and {title.text} may both be {curve}; {how}")
        if curve:
            belong[curve] = title
    return [(title, curve) for curve, title in belong.items()]


def curve_of(recording: Recording, title: Title, units: Mapping[str, str], shown: Sequence[str]) -> str:
    """The curve that a column belongs to by itself.  Raises InputError where there is none."""
    curve = title.name if title.name in units else _only_of_its_unit(recording, title, units, shown)
    if not curve:
        raise InputError(
            f"{recording.place}: {quoted(title.text)} belongs to no curve; {_how(recording, title, units, shown)}"
        )
    return curve


def _only_of_its_unit(recording: Recording, title: Title, units: Mapping[str, str], shown: Sequence[str]) -> str:
    """The only curve of the unit of a column among those shown, "" if there is none or several."""
    try:
        _, dimension = title.scale(recording.place)
    except InputError:
        return ""
    suited = [name for name in shown if name in units and suits(title, dimension, units[name])]
    if dimension is not None and len(suited) > 1:  # a moment is no energy, though both are in N*m
        unit = si_unit(title.unit or "", dimension)
        suited = [name for name in suited if units[name] == unit]
    return suited[0] if len(suited) == 1 else ""


def suits(title: Title, dimension: Dimension | None, unit: str) -> bool:
    """True if a column of this dimension can be compared with a curve in this SI unit."""
    if dimension is None:
        return True
    return dimension == _dimension(unit) and not _leaves_turning_open(title, dimension, unit)


def _leaves_turning_open(title: Title, dimension: Dimension | None, unit: str) -> bool:
    """True for 1/min or Hz of what turns: turns and radians are both plain numbers."""
    turning = dimension is not None and unit.startswith("rad/")
    return turning and not si_unit(title.unit or "", dimension or DIMENSIONLESS).startswith("rad/")


def _dimension(unit: str) -> Dimension | None:
    try:
        return dimension_of(unit)
    except InputError:
        return None


def _how(recording: Recording, title: Title, units: Mapping[str, str], shown: Sequence[str]) -> str:
    curve = next(iter((*shown, *units)), "rocker.angle")
    return HOW.format(file=recording.file, column=title.name or title.text, curve=curve)


def measured(recording: Recording, title: Title, curve: str, unit: str, offset: float = 0.0) -> Measured:
    """A column as the measured curve of a curve in this SI unit.  Raises InputError for a unit of another kind."""
    scale, dimension = title.scale(recording.place)
    if dimension is not None and dimension != _dimension(unit):
        is_a = f"{quoted(title.text)} is {describe(dimension)}"
        raise InputError(f"{recording.place}: {is_a}; {curve} is in {unit or 'no unit'}")
    if _leaves_turning_open(title, dimension, unit):
        why = f"{quoted(title.text)} leaves open whether turns or radians are meant"
        raise InputError(f"{recording.place}: {why}; {curve} is in {unit}: write rpm, rev/s, deg/s or rad/s")
    values = scale * recording.values(title) + zero_of(title.unit or "")
    return Measured(curve, title.name or title.text, recording.file, recording.t + offset, values, dimension is None)
