"""The table [tables]: functions of one number given by points, written out or in a file beside the model file."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path as FilePath
from pathlib import PurePosixPath, PureWindowsPath

from rattle.description.read_fields import FieldReader
from rattle.description.read_values import LARGEST, Values, quoted
from rattle.description.reading import Path, Table
from rattle.description.tables import CURVES, TABLE
from rattle.errors import InputError, ModelError, Problem
from rattle.language.expression import argument_of
from rattle.language.recorded import bare
from rattle.language.syntax import CALLABLE, call_name
from rattle.language.tables import Curve, curve
from rattle.language.units import Dimension, QuantityError, describe, dimension_of, parse_quantity, zero_of

MOST_POINTS = 100_000
LARGEST_FILE = 8_000_000  # bytes
CLOSE = 1e-9  # share of the period, or of the range of y, that counts as equal
HEADER = re.compile(r"\s*(?P<name>[^\[\]]*?)\s*(?:\[(?P<unit>[^\[\]]*)\])?\s*")
PLAIN_FILE = 'a file beside the model file, such as "lift.csv"'


# ---------------------------------------------------------------- tables of a model
def read_tables(values: Values, document: Table, early: bool) -> None:
    """Read the tables whose numbers are known before the parameters are (early), or the others.

    They are entered in `values`, with the dimensions of their argument and of their value.
    """
    tables = values.table(document.get("tables", {}), ("tables",))
    for name, written in tables.items():
        if not isinstance(written, Mapping):
            if early:
                values.wrong(("tables", name), f"expected a table {{ x = [...], y = [...] }}, got {quoted(written)}")
                values.broken_tables.add(name)
        elif early == _is_plain(written):
            before = len(values.problems)
            read = _read(values, name, written)
            if read is None or len(values.problems) > before:
                values.broken_tables.add(name)
            else:
                values.enter_table(name, read[0])
                values.dimensions[argument_of(call_name(name))], values.dimensions[call_name(name)] = read[1:]
        elif early:
            values.later_tables.add(name)
    if not early:
        values.later_tables.clear()


def _is_plain(entry: Table) -> bool:
    """True if no number of a table is an expression."""
    numbers = [entry.get("period"), *(number for key in ("x", "y") for number in _listed(entry.get(key)))]
    try:
        return all(parse_quantity(number) is not None for number in numbers if isinstance(number, str))
    except QuantityError:
        return True


def _listed(written: object) -> Sequence[object]:
    return written if isinstance(written, list | tuple) else ()


def _read(values: Values, name: str, written: Table) -> tuple[Curve, Dimension | None, Dimension | None] | None:
    """A table with the dimensions of x and y; None after a problem."""
    path: Path = ("tables", name)
    if name in CALLABLE:
        values.wrong(path, f"'{name}' is a function; choose another name", at_key=True)
    else:
        values.name(name, path)
    read = FieldReader(values).form(TABLE, written, path)
    missing = [key for key in ("x", "y") if key not in written]
    if missing and "file" not in written:
        values.wrong(path, f"needs {' and '.join(missing)}: lists of numbers, or file: {PLAIN_FILE}")
    units, kind = read.get("units", ("", "")), read["kind"]
    if missing or units is None or math.isnan(kind):
        return None
    kind, before = CURVES[int(kind)], len(values.problems)
    if read["x"] is None or read["y"] is None:
        return None
    x, of_x = _numbers(values, read["x"], units[0], (*path, "x"))
    y, of_y = _numbers(values, read["y"], units[1], (*path, "y"))
    if len(values.problems) > before:
        return None
    period = _period(values, written, units[0], of_x, path)
    if not _shape_is_sound(values, x, y, kind, period, path):
        return None
    through = _through(values, x, y, kind, period, path)
    return (through, of_x, of_y) if through is not None else None


def _numbers(values: Values, written: Sequence[object], unit: str, path: Path) -> tuple[list[float], Dimension | None]:
    """Numbers of a list [SI] and their common dimension; unit: of those that have none, "" for SI."""
    if len(written) > MOST_POINTS:
        values.wrong(path, f"{len(written)} numbers; a table has at most {MOST_POINTS} points")
        return [], None
    try:
        scale, common = _scale(unit)
    except QuantityError as error:
        values.wrong((*path[:2], "units"), str(error))
        return [], None
    numbers = []
    for n, entry in enumerate(written):
        number, dimension = values.any_number(entry, (*path, n))
        if dimension is None and (scale != 1.0 or zero_of(unit)):
            number = number * scale + zero_of(unit)
        elif dimension is not None and common not in (None, dimension):
            values.wrong(
                (*path, n), f"{quoted(entry)} is {describe(dimension)}, others are {describe(common or dimension)}"
            )
        common = dimension if common is None else common
        numbers.append(number)
    return numbers, common


def _scale(unit: str) -> tuple[float, Dimension | None]:
    """Size in SI units and dimension of a unit; 1 and None for "".  Raises QuantityError."""
    if not unit.strip():
        return 1.0, None
    quantity = parse_quantity(f"1 {unit}")
    if quantity is None:
        raise QuantityError(f"{quoted(unit)} is not a unit")
    return quantity[0] - zero_of(unit), dimension_of(unit)


def _period(values: Values, written: Table, unit: str, of_x: Dimension | None, path: Path) -> float:
    """The period [SI], 0 if there is none, nan after a problem."""
    if "period" not in written:
        return 0.0
    here = (*path, "period")
    number, dimension = values.any_number(written["period"], here)
    if dimension is None:
        number = number * _scale(unit)[0] if unit.strip() else number
    elif of_x is not None and dimension != of_x:
        values.wrong(here, f"{quoted(written['period'])} is {describe(dimension)}; x is {describe(of_x)}")
    if not math.isfinite(bare(number)):
        return math.nan
    if not number > 0.0:
        values.wrong(here, f"{quoted(written['period'])} must be positive")
        return math.nan
    return number


def _shape_is_sound(values: Values, x: list[float], y: list[float], kind: str, period: float, path: Path) -> bool:
    """True if the points make a table of this kind."""
    if len(x) != len(y):
        values.wrong(path, f"x has {len(x)} numbers and y has {len(y)}; expected as many")
        return False
    for n in range(1, len(x)):
        if not x[n] > x[n - 1]:
            values.wrong(
                (*path, "x", n),
                f"{float(x[n]):g} does not follow on {float(x[n - 1]):g}: x must increase (in SI units)",
            )
            return False
    if math.isnan(bare(period)):
        return False
    if len(x) < 2:
        values.wrong((*path, "x"), f"{len(x)} point{'s' * (len(x) != 1)}; a table needs two or more")
        return False
    span = x[-1] - x[0]
    if period and span > period * (1.0 + CLOSE):
        values.wrong(
            (*path, "period"), f"x goes over {float(span):g}, more than the period {float(period):g} (in SI units)"
        )
        return False
    closed = bool(period) and span >= period * (1.0 - CLOSE)
    if closed and y[-1] != y[0] and abs(y[-1] - y[0]) > CLOSE * (max(y) - min(y)):
        values.wrong(
            (*path, "y"),
            f"y ends with {float(y[-1]):g} one period after {float(y[0]):g} (in SI units); expected the same",
        )
        return False
    if period and kind == "spline" and len(x) + (not closed) < 4:
        values.wrong((*path, "x"), "a spline with a period needs three or more different points")
        return False
    return True


def _through(values: Values, x: list[float], y: list[float], kind: str, period: float, path: Path) -> Curve | None:
    """The curve through sound points; where there is a period it ends one period after its start."""
    if period:
        if x[-1] - x[0] < period * (1.0 - CLOSE):
            x, y = [*x, x[0] + period], [*y, y[0]]
        else:
            x, y = [*x[:-1], x[0] + period], [*y[:-1], y[0]]
    through = curve(x, y, kind, period)
    if not all(abs(bare(number)) <= LARGEST for segment in through.coefficients for number in segment):
        values.wrong(path, "its numbers are too large, or its points too close, for finite slopes")
        return None
    return through


# ---------------------------------------------------------------- files
def with_files(
    document: Table, folder: FilePath | None, file: str = "", read: Table | None = None
) -> dict[str, object]:
    """A document in which the tables that name a file hold its numbers too, under x, y and units.

    folder: that of the model file, None for a model that was not read from a file.  read: tables read before, which
    stay as they are.  Raises ModelError with all problems.
    """
    tables = document.get("tables")
    whole = dict(document)
    if not isinstance(tables, Mapping):
        return whole
    problems: list[Problem] = []
    filled: dict[str, object] = {}
    for name, table in tables.items():
        filled[name] = table
        if isinstance(table, Mapping) and "file" in table and table != (read or {}).get(name):
            if both := [key for key in ("x", "y", "units") if key in table]:
                problems.append(Problem(("tables", name, both[0]), "give a file or x and y, not both", True))
                continue
            try:
                filled[name] = {**table, **_of_file(table["file"], folder)}
            except ValueError as error:
                problems.append(Problem(("tables", name, "file"), str(error)))
    if problems:
        raise ModelError(problems, file)
    whole["tables"] = filled
    return whole


def _of_file(written: object, folder: FilePath | None) -> dict[str, object]:
    """x, y and units of a file.  Raises InputError that says what is wrong with the file."""
    if not isinstance(written, str) or not written.strip():
        raise InputError(f"expected {PLAIN_FILE}, got {quoted(written)}")
    if folder is None:
        raise InputError(f"{quoted(written)}: a model that was not read from a file has no folder; write out x and y")
    return read_points(inside(folder, written), written)


def inside(folder: FilePath, name: str) -> FilePath:
    """The place of a file in a folder.  Raises InputError if it would be outside, or is no file."""
    parts = PureWindowsPath(name)
    if PurePosixPath(name).is_absolute() or parts.drive or parts.root or ".." in parts.parts:
        raise InputError(f"{quoted(name)} leads out of the folder of the model; expected {PLAIN_FILE}")
    try:
        home = folder.resolve()
        place = (home / name).resolve()
        if not place.is_relative_to(home):
            raise InputError(f"{quoted(name)} is a link out of the folder of the model; expected {PLAIN_FILE}")
        if not place.is_file():
            raise InputError(f"there is no file {quoted(name)} in the folder of the model")
    except (OSError, RuntimeError) as error:
        raise InputError(f"cannot find {quoted(name)}: {error}") from None
    return place


def text_of(place: FilePath, name: str) -> str:
    """Text of a file; name: as messages call it.  Raises InputError for one that is too large or cannot be read."""
    try:
        if place.stat().st_size > LARGEST_FILE:
            raise InputError(f"{quoted(name)} has more than {LARGEST_FILE / 1e6:.0f} MB")
        return place.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"cannot read {quoted(name)}: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise InputError(f"{quoted(name)} is not UTF-8 text") from None


def rows_of(text: str, name: str, delimiter: str = ",") -> Iterator[list[str]]:
    """The cells of every line; name: as messages call the file.  Raises InputError for what is no table of cells."""
    try:
        yield from csv.reader(text.splitlines(), delimiter=delimiter, skipinitialspace=True)
    except csv.Error as error:
        raise InputError(f"{quoted(name)} is not a table of numbers: {error}") from None


def read_points(place: FilePath, name: str) -> dict[str, object]:
    """x, y and their units from a file of two columns; name: as messages call it.

    Its first line may be a header such as `angle [deg], lift [mm]`.  Raises InputError with the line.
    """
    units, points = ["", ""], list[tuple[float, float]]()
    for n, (line, cells) in enumerate(_pairs(text_of(place, name), name)):
        if n == 0 and not any(_is_number(cell) for cell in cells):
            units = [_unit(cell, f"{name}, line {line}") for cell in cells]
        else:
            points.append((_cell(cells[0], name, line), _cell(cells[1], name, line)))
    if not points:
        raise InputError(f"{quoted(name)} holds no numbers")
    return {"x": [x for x, _ in points], "y": [y for _, y in points], "units": units}


def parted_by(text: str) -> str:
    """The sign that parts the cells of a text: the first of semicolon, tab and comma in its first line that counts."""
    first = next((line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")), "")
    return next((sign for sign in (";", "\t", ",") if sign in first), ",")


def _pairs(text: str, name: str) -> Iterator[tuple[int, list[str]]]:
    """The number of each line that holds something, and its two cells."""
    for line, row in enumerate(rows_of(text, name, parted_by(text)), start=1):
        cells = [cell.strip() for cell in row]
        if not any(cells) or cells[0].startswith("#"):
            continue
        if len(cells) != 2:
            raise InputError(f"{name}, line {line}: expected two columns, found {len(cells)}")
        yield line, cells


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _cell(cell: str, name: str, line: int) -> float:
    if not _is_number(cell) or not math.isfinite(float(cell)):
        raise InputError(f"{name}, line {line}: {quoted(cell)} is not a finite number; a decimal point is written '.'")
    return float(cell)


def _unit(cell: str, where: str) -> str:
    """The unit in the header of a column, "" if it has none."""
    title = HEADER.fullmatch(cell)
    if title is None:
        raise InputError(f"{where}: expected a header such as 'lift [mm]', found {quoted(cell)}")
    unit = (title["unit"] or "").strip()
    try:
        _scale(unit)
    except QuantityError as error:
        raise InputError(f"{where}: {error}") from None
    return unit
