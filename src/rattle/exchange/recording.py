"""A table of measured numbers in a text file: columns over time, with names and units in its head.

    # test bench, run 12
    t [s];theta [deg];force [kN]
    0,00;12,5;0,31
    0,01;12,8;0,35

Columns are parted by semicolons, tabs or commas; a decimal comma may stand where commas part nothing.  Lines that begin
with `#` are comments.  Time is the column called `t` or `time`, else the first.  Nothing is guessed beyond that: what
does not fit is refused with its line.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.description.read_tables import HEADER, LARGEST_FILE, parted_by, rows_of, text_of
from rattle.description.read_values import quoted
from rattle.errors import InputError, suggest
from rattle.language.units import DIMENSIONLESS, TIME, Dimension, QuantityError, describe, parse_quantity, zero_of
from rattle.user_paths import expanded

Array = NDArray[np.float64]
MOST_LINES, MOST_ROWS = 500_000, 200_000
MOST_COLUMNS = 1000
LONGEST_TITLE = 200  # characters of the head of a column
MOST_NAMED = 12  # columns that a message names
TIMES = ("t", "time")
PLAIN = ("", "-", "1")  # units of what has none
NUMBER = re.compile(r"[+-]?+(?:[0-9]++(?:[.,][0-9]*+)?+|[.,][0-9]++)(?:[eE][+-]?[0-9]++)?+")
# a unit that stands in another way than in square brackets, such as "force (kN)" or "force / kN"
OTHERWISE = re.compile(r"\s*(?P<name>.*?\S)\s*(?:\(\s*(?P<round>[^()]+?)\s*\)|/\s*(?P<over>\S+))\s*")
EXAMPLE = "'t [s];force [kN]'"
PARTED = {";": "semicolons", "\t": "tabs", ",": "commas"}


class Title(NamedTuple):
    """The head of a column."""

    name: str
    unit: str | None  # as it is written; None without brackets
    text: str
    place: int  # of the column, counted from 0

    @property
    def without_brackets(self) -> str:
        """The name in front of a unit that stands in round brackets or behind a stroke."""
        match = OTHERWISE.fullmatch(self.text) if self.unit is None else None
        return match["name"] if match else ""

    def scale(self, place: str) -> tuple[float, Dimension | None]:
        """Size of the unit in SI and its dimension, None without a unit.  Raises InputError."""
        if self.unit is None:
            self._require_brackets(place)
            return 1.0, None
        if self.unit in PLAIN:
            return 1.0, DIMENSIONLESS
        try:
            quantity = parse_quantity(f"1 {self.unit}")
        except QuantityError as error:
            raise InputError(f"{place}: {quoted(self.text)}: {error}") from None
        if quantity is None:
            raise InputError(f"{place}: {quoted(self.text)}: {quoted(self.unit)} is not a unit")
        return quantity[0] - zero_of(self.unit), quantity[1]

    def _require_brackets(self, place: str) -> None:
        """Raise InputError for a unit without brackets: it would be taken for a part of the name."""
        match = OTHERWISE.fullmatch(self.text)
        unit = (match["round"] or match["over"]) if match else None
        try:
            is_unit = unit is not None and parse_quantity(f"1 {unit}") is not None
        except QuantityError:
            is_unit = False
        if match and is_unit:
            raise InputError(
                f"{place}: {quoted(self.text)}: write the unit in square brackets, '{match['name']} [{unit}]'"
            )


class Recording(NamedTuple):
    """A file that was read: its times, and the texts of its other columns."""

    file: str  # as messages call it
    line: int  # of the head
    titles: tuple[Title, ...]  # of all columns
    time: int  # which of them is time
    t: Array  # (n,) [s], not decreasing
    rows: Sequence[Sequence[str]]  # cells
    lines: Sequence[int]  # of these rows
    delimiter: str
    decimal: Mapping[str, str] = {}  # the sign that parts decimals of its times, with a time that has it

    @property
    def columns(self) -> tuple[Title, ...]:
        """The titles of all columns but that of time."""
        return tuple(title for k, title in enumerate(self.titles) if k != self.time)

    @property
    def listed(self) -> str:
        """These titles, for messages."""
        texts = [shown.text for shown in self.columns]
        return ", ".join(texts[:MOST_NAMED]) + (
            f" and {len(texts) - MOST_NAMED} more" if len(texts) > MOST_NAMED else ""
        )

    @property
    def place(self) -> str:
        """Where the head is, for messages."""
        return f"{self.file}, line {self.line}"

    def at(self, row: int) -> str:
        """Where a row is, for messages."""
        return f"{self.file}, line {self.lines[row]}"

    def column(self, name: str) -> Title:
        """The title of a column, by its name or by all of its head.  Raises InputError if there is none, or several."""
        matching = [title for title in self.columns if name in (title.name, title.text)]
        matching = matching or [title for title in self.columns if title.without_brackets == name]  # refused later
        if len(matching) == 1:
            return matching[0]
        if matching:
            raise InputError(
                f"{self.place}: {len(matching)} columns are called {quoted(name)}; give them names of their own"
            )
        hint = suggest(name, [title.name for title in self.columns])
        raise InputError(f"{self.place}: no column {quoted(name)}{hint or f'; there are {self.listed}'}")

    def begins_with_a_number(self, title: Title) -> bool:
        """False for a column of words."""
        return NUMBER.fullmatch(self.rows[0][title.place]) is not None

    def values(self, title: Title) -> Array:
        """(n,) numbers of a column in the unit of its head.  Raises InputError with the line of what is none."""
        return _numbers(self, title.place, dict(self.decimal))


def read_recording(path: str | Path) -> Recording:
    """Read a file.  Raises InputError that says what is wrong with it, and where."""
    place = expanded(path)
    if not place.is_file():
        raise InputError(
            f"there is no file {quoted(str(path))}" if not place.is_dir() else f"{quoted(str(path))} is a folder"
        )
    try:
        text = text_of(place, place.name)
    except InputError as error:
        raise InputError(f"{error}; save it as CSV in UTF-8" if "UTF-8" in str(error) else str(error)) from None
    return recording_of(text, place.name)


def recording_of(text: str, file: str) -> Recording:
    """The recording in a text; file: as messages call it.  Raises as `read_recording`."""
    if len(text) > LARGEST_FILE:
        raise InputError(f"{quoted(file)} has more than {LARGEST_FILE / 1e6:.0f} MB")
    text = text.removeprefix("\ufeff")
    if len(text.splitlines()) > MOST_LINES:
        raise InputError(f"{quoted(file)} has more than {MOST_LINES} lines; thin it out")
    delimiter, skipped = _delimiter(text)
    head = Head(0, [])
    comment = Head(0, [])  # the last one above the numbers: it may be the head
    rows, lines = list[list[str]](), list[int]()
    for number, cells in _filled(text, file, delimiter, skipped):
        if cells[0].startswith("#"):
            comment = Head(number, [cells[0].lstrip("# "), *cells[1:]])
        elif not head.cells:
            head = _head(Head(number, cells), comment, file)
            if head.line != number:
                rows.append(cells)
                lines.append(number)
        elif len(cells) != len(head.cells):
            raise InputError(f"{file}, line {number}: {_miscounted(len(cells), len(head.cells), delimiter)}")
        elif len(rows) == MOST_ROWS:
            raise InputError(f"{file}, line {number}: more than {MOST_ROWS} rows; thin the file out")
        else:
            rows.append(cells)
            lines.append(number)
    if not rows:
        raise InputError(f"{quoted(file)} holds no numbers" if head.cells else f"{quoted(file)} is empty")
    titles = tuple(_title(cell, k, f"{file}, line {head.line}") for k, cell in enumerate(head.cells))
    return _with_times(Recording(file, head.line, titles, 0, np.zeros(0), rows, lines, delimiter))


class Head(NamedTuple):
    """A line of cells."""

    line: int
    cells: list[str]


def _filled(text: str, file: str, delimiter: str, skipped: int) -> Iterator[tuple[int, list[str]]]:
    """The number of each line that holds something, and its cells."""
    for number, row in enumerate(rows_of(text, file, delimiter), 1):
        cells = [cell.strip() for cell in row]
        if number > skipped and any(cells):
            yield number, cells


def _delimiter(text: str) -> tuple[str, int]:
    """What parts the columns, and how many lines at the top say no more than that."""
    start = text[:LARGEST_FILE].lstrip()
    first = start.splitlines()[0] if start else ""
    if re.fullmatch(r"sep=[;,\t]", first.strip(" \r\n").lower()):  # as Excel writes and reads it
        return first.strip(" \r\n")[-1], 1 + text[: len(text) - len(start)].count("\n")
    return parted_by(text), 0


def _head(first: Head, comment: Head, file: str) -> Head:
    """The head: the first line, or the comment above it, as NumPy writes it.  Raises InputError where there is none."""
    place = f"{file}, line {first.line}"
    if len(first.cells) > MOST_COLUMNS:
        raise InputError(f"{place}: {len(first.cells)} columns; at most {MOST_COLUMNS} are read")
    if not any(map(NUMBER.fullmatch, first.cells)):
        if len(first.cells) > 1:
            return first
        raise InputError(
            f"{place}: one column; expected time and what was measured, parted by semicolons, tabs or commas, such as"
            f" {EXAMPLE}"
        )
    if len(comment.cells) == len(first.cells) > 1 and not any(map(NUMBER.fullmatch, comment.cells)):
        return comment
    raise InputError(f"{place}: numbers without a head; expected names and units in the first line, such as {EXAMPLE}")


def _miscounted(count: int, wanted: int, delimiter: str) -> str:
    comma = "; with decimal commas columns are parted by semicolons" if delimiter == "," and count > wanted else ""
    ended = "; the line is not complete" if count < wanted else ""
    return f"expected {wanted} columns as in the head, found {count}{comma}{ended}"


def _title(cell: str, column: int, place: str) -> Title:
    match = HEADER.fullmatch(cell) if len(cell) <= LONGEST_TITLE else None
    if match is None:
        raise InputError(f"{place}: expected a head such as 'force [kN]', found {quoted(cell)}")
    unit = match["unit"]
    typed = None if unit is None else unit.strip().replace("²", "^2").replace("³", "^3")
    return Title(match["name"], typed, cell, column)


def _with_times(read: Recording) -> Recording:
    """The same with its times."""
    called = [k for k, title in enumerate(read.titles) if title.name.casefold() in TIMES]
    time = read.titles[called[0] if called else 0]
    scale, dimension = time.scale(read.place)
    if dimension not in (None, TIME):
        what = f"{quoted(time.text)} is {describe(dimension or TIME)}, not a time"
        raise InputError(
            f"{read.place}: {what}" + ("" if called else "; the column of time stands first, or is called t")
        )
    timed = read._replace(time=called[0] if called else 0)
    marks: dict[str, str] = {}
    t = scale * _numbers(timed, timed.time, marks)
    back = np.flatnonzero(~(np.diff(t) >= 0.0))
    if len(back):
        k = int(back[0])
        earlier, later = (read.rows[n][timed.time] for n in (k, k + 1))
        raise InputError(
            f"{read.file}, line {read.lines[k + 1]}: {later} follows on {earlier}: times must not decrease"
        )
    return timed._replace(t=t, decimal=marks)


def _numbers(read: Recording, place: int, marks: dict[str, str]) -> Array:
    """(n,) numbers of a column.  Raises InputError with the line of what is no finite number.

    marks: signs that part decimals, each with a number that has it; those of this column are put in.
    """
    column = np.empty(len(read.rows))
    for k, row in enumerate(read.rows):
        cell = row[place]
        if NUMBER.fullmatch(cell) is None or (read.delimiter == "," and "," in cell):
            raise InputError(f"{read.at(k)}: {_no_number(cell, read, place)}")
        sign = "," if "," in cell else "." if "." in cell else ""
        if sign and sign not in marks:
            marks[sign] = cell
            if len(marks) > 1:
                raise InputError(
                    f"{read.at(k)}: {marks['.']} and {marks[',']} in one file: decimals are parted by"
                    " points or by commas, not by both"
                )
        column[k] = float(cell.replace(",", "."))
    if not np.isfinite(column).all():
        k = int(np.flatnonzero(~np.isfinite(column))[0])
        raise InputError(f"{read.at(k)}: {quoted(read.rows[k][place])} is too large a number")
    return column


def _no_number(cell: str, read: Recording, place: int) -> str:
    """Why a cell is no number, in words."""
    title = quoted(read.titles[place].text)
    if not cell:
        return f"the column {title} has no number here"
    hint = "; thousands are not parted" if NUMBER.fullmatch(re.sub("[., ']", "", cell)) else ""
    return f"{quoted(cell)} in the column {title} is not a finite number{hint}"
