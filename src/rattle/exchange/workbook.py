"""Excel workbooks (`.xlsx`, ECMA-376) of plain tables, by the standard library alone.

A workbook is a zip of XML parts.  Numbers are written so that reading gives the same number; texts stand in their
cells.
A cell has no number for nan and infinity: nan leaves it empty, infinity is the text "inf".  The same tables give the
same bytes.
"""

from __future__ import annotations

import io
import math
import re
import zipfile
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple
from xml.sax.saxutils import escape, quoteattr

from rattle.errors import InputError

Cell = float | str | bool | None
MOST_ROWS, MOST_COLUMNS = 1_048_576, 16_384  # of a sheet
LONGEST_NAME, LONGEST_TEXT = 31, 32_767  # characters of the name of a sheet, and of a cell
FORBIDDEN = re.compile(r"[\[\]:*?/\\\x00-\x1f]")  # in the name of a sheet
RESERVED = "history"  # a name that Excel keeps for itself
# what XML cannot hold, and what readers would take for the way in which that is written
UNWRITABLE = re.compile(r"[\x00-\x08\x0b-\x1f\ud800-\udfff\ufffe\uffff]|_(?=x[0-9A-Fa-f]{4}_)")
CUT = " ... (cut: a cell holds no more)"
LONG_AGO = (1980, 1, 1, 0, 0, 0)  # date of the parts: the earliest of a zip
WIDEST = 60  # characters that a column is made wide for
MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
OFFICE = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
PACKAGE = "http://schemas.openxmlformats.org/package/2006"
KIND = "application/vnd.openxmlformats-officedocument.spreadsheetml"
HEAD = '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n'
BOLD = (  # of the first row: style 1
    f'<styleSheet xmlns="{MAIN}"><fonts count="2"><font><sz val="11"/><name val="Calibri"/></font>'
    '<font><b/><sz val="11"/><name val="Calibri"/></font></fonts>'
    '<fills count="2"><fill><patternFill patternType="none"/></fill><fill><patternFill patternType="gray125"/></fill>'
    '</fills><borders count="1"><border><left/><right/><top/><bottom/><diagonal/></border></borders>'
    '<cellStyleXfs count="1"><xf numFmtId="0" fontId="0" fillId="0" borderId="0"/></cellStyleXfs>'
    '<cellXfs count="2"><xf numFmtId="0" fontId="0" fillId="0" borderId="0" xfId="0"/>'
    '<xf numFmtId="0" fontId="1" fillId="0" borderId="0" xfId="0" applyFont="1"/></cellXfs>'
    '<cellStyles count="1"><cellStyle name="Normal" xfId="0" builtinId="0"/></cellStyles></styleSheet>'
)


class Sheet(NamedTuple):
    """A table: its name, the texts of its first row, and the rows below, each as long as the first."""

    name: str
    head: Sequence[str]
    rows: Iterable[Sequence[Cell]]
    length: int  # how many rows these are


def workbook(sheets: Sequence[Sheet]) -> bytes:
    """The bytes of a workbook; sheets get names that a workbook can have.

    Raises InputError for a sheet with more rows or columns than a sheet holds.
    """
    for sheet in sheets:
        if sheet.length + 1 > MOST_ROWS:
            raise InputError(
                f"{sheet.name}: {sheet.length} rows; a sheet of a workbook holds {MOST_ROWS - 1} below its head. Write"
                " .csv or .mat, or fewer instants"
            )
        if len(sheet.head) > MOST_COLUMNS:
            raise InputError(f"{sheet.name}: {len(sheet.head)} columns; a sheet of a workbook holds {MOST_COLUMNS}")
    names = sheet_names([sheet.name for sheet in sheets])
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as file:
        for path, text in _frame(names):
            _write(file, path, [HEAD, text])
        for n, sheet in enumerate(sheets, 1):
            _write(file, f"xl/worksheets/sheet{n}.xml", _sheet(sheet, first=n == 1))
    return out.getvalue()


def sheet_names(wanted: Sequence[str]) -> list[str]:
    """Names that sheets can have: without forbidden signs, short enough, and no two alike."""
    taken: set[str] = set()
    names = []
    for text in wanted:
        plain = UNWRITABLE.sub("_", FORBIDDEN.sub("_", text)).strip("' ") or "sheet"
        plain = f"{plain}_" if plain.casefold() == RESERVED else plain
        name, n = _shortened(plain, ""), 1
        while name.casefold() in taken:
            n += 1
            name = _shortened(plain, f" ({n})")
        taken.add(name.casefold())
        names.append(name)
    return names


def _shortened(name: str, end: str) -> str:
    """A name with an ending; its length counts as that of UTF-16."""
    while len((name + end).encode("utf-16-le")) > 2 * LONGEST_NAME:
        name = name[:-1]
    return name.rstrip("' ") + end if not end else name + end


def _write(file: zipfile.ZipFile, path: str, texts: Iterable[str]) -> None:
    """One part of the workbook."""
    part = zipfile.ZipInfo(path, LONG_AGO)
    part.compress_type, part.external_attr = zipfile.ZIP_DEFLATED, 0o600 << 16
    part.create_system = 3  # so that all systems write the same
    with file.open(part, "w", force_zip64=True) as out:
        for text in texts:
            out.write(text.encode("utf-8"))


def _frame(names: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Path and text of the parts that say which sheets there are."""
    numbers = range(1, len(names) + 1)
    kinds = "".join(
        f'<Override PartName="/xl/worksheets/sheet{n}.xml" ContentType="{KIND}.worksheet+xml"/>' for n in numbers
    )
    yield (
        "[Content_Types].xml",
        (
            f'<Types xmlns="{PACKAGE}/content-types">'
            '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
            '<Default Extension="xml" ContentType="application/xml"/>'
            f'<Override PartName="/xl/workbook.xml" ContentType="{KIND}.sheet.main+xml"/>{kinds}'
            f'<Override PartName="/xl/styles.xml" ContentType="{KIND}.styles+xml"/></Types>'
        ),
    )
    yield (
        "_rels/.rels",
        (
            f'<Relationships xmlns="{PACKAGE}/relationships">'
            f'<Relationship Id="rId1" Type="{OFFICE}/officeDocument" Target="xl/workbook.xml"/></Relationships>'
        ),
    )
    listed = "".join(
        f'<sheet name={quoteattr(name)} sheetId="{n}" r:id="rId{n}"/>' for n, name in zip(numbers, names, strict=True)
    )
    yield "xl/workbook.xml", f'<workbook xmlns="{MAIN}" xmlns:r="{OFFICE}"><sheets>{listed}</sheets></workbook>'
    parts = "".join(
        f'<Relationship Id="rId{n}" Type="{OFFICE}/worksheet" Target="worksheets/sheet{n}.xml"/>' for n in numbers
    )
    yield (
        "xl/_rels/workbook.xml.rels",
        (
            f'<Relationships xmlns="{PACKAGE}/relationships">{parts}'
            f'<Relationship Id="rId{len(names) + 1}" Type="{OFFICE}/styles" Target="styles.xml"/></Relationships>'
        ),
    )
    yield "xl/styles.xml", BOLD


# ---------------------------------------------------------------- one sheet
def _sheet(sheet: Sheet, first: bool) -> Iterator[str]:
    """The text of a sheet, row by row; its head stays in sight."""
    columns = [column_letters(n) for n in range(len(sheet.head))]
    widths = "".join(
        f'<col min="{n}" max="{n}" width="{min(WIDEST, max(12, len(title) + 2))}" customWidth="1"/>'
        for n, title in enumerate(sheet.head, 1)
    )
    chosen = ' tabSelected="1"' if first else ""
    yield (
        f'{HEAD}<worksheet xmlns="{MAIN}"><sheetViews><sheetView{chosen} workbookViewId="0">'
        '<pane ySplit="1" topLeftCell="A2" activePane="bottomLeft" state="frozen"/></sheetView></sheetViews>'
        f"{f'<cols>{widths}</cols>' if widths else ''}<sheetData>"
    )
    yield _row(1, columns, sheet.head, ' s="1"')
    for n, row in enumerate(sheet.rows, 2):
        yield _row(n, columns, row)
    yield "</sheetData></worksheet>"


def _row(number: int, columns: Sequence[str], cells: Sequence[Cell], style: str = "") -> str:
    written = (_cell(f"{column}{number}", cell, style) for column, cell in zip(columns, cells, strict=True))
    return f'<row r="{number}">{"".join(written)}</row>'


def _cell(place: str, value: Cell, style: str = "") -> str:
    if isinstance(value, bool):
        return f'<c r="{place}"{style} t="b"><v>{int(value)}</v></c>'
    if isinstance(value, float | int):
        if math.isfinite(value):
            return f'<c r="{place}"{style}><v>{float(value)!r}</v></c>'
        value = None if math.isnan(value) else "inf" if value > 0 else "-inf"
    if value is None or value == "":
        return f'<c r="{place}"{style}/>'
    text = escape(written_text(value))
    return f'<c r="{place}"{style} t="inlineStr"><is><t xml:space="preserve">{text}</t></is></c>'


def written_text(text: str) -> str:
    """A text as a cell holds it: signs that XML cannot hold as `_x0007_`, and no more than fits."""
    if len(text.encode("utf-16-le", "surrogatepass")) > 2 * LONGEST_TEXT:
        text = text[: (LONGEST_TEXT - len(CUT)) // 2] + CUT
    return UNWRITABLE.sub(lambda sign: f"_x{ord(sign[0]):04X}_", text)


def column_letters(number: int) -> str:
    """The letters of a column, counted from 0: A ... Z, AA ..."""
    letters = ""
    number += 1
    while number:
        number, rest = divmod(number - 1, 26)
        letters = chr(65 + rest) + letters
    return letters
