"""A reader of workbooks of its own, by the names and numbers that ECMA-376 gives; nothing of rattle's writer."""

from __future__ import annotations

import io
import re
import xml.etree.ElementTree as ET
import zipfile

MAIN = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"
OFFICE = "{http://schemas.openxmlformats.org/officeDocument/2006/relationships}"
PACKAGE = "{http://schemas.openxmlformats.org/package/2006/relationships}"


def read_workbook(content: bytes) -> dict[str, list[list[object]]]:
    """Rows of cells by the names of sheets: numbers, texts, None for empty cells."""
    with zipfile.ZipFile(io.BytesIO(content)) as file:
        assert file.testzip() is None
        parts = {part.get("Id"): part for part in ET.fromstring(file.read("xl/_rels/workbook.xml.rels"))}
        sheets = ET.fromstring(file.read("xl/workbook.xml")).iter(f"{MAIN}sheet")
        return {
            str(sheet.get("name")): _rows(file.read(f"xl/{parts[sheet.get(f'{OFFICE}id')].get('Target')}"))
            for sheet in sheets
        }


def _rows(text: bytes) -> list[list[object]]:
    rows = []
    for number, row in enumerate(ET.fromstring(text).iter(f"{MAIN}row"), 1):
        assert int(str(row.get("r"))) == number
        cells: list[object] = []
        for n, cell in enumerate(row):
            assert cell.get("r") == f"{letters(n)}{number}"
            cells.append(_value(cell))
        rows.append(cells)
    return rows


def _value(cell: ET.Element) -> object:
    value, text = cell.find(f"{MAIN}v"), cell.find(f"{MAIN}is/{MAIN}t")
    if text is not None:
        return re.sub("_x([0-9A-F]{4})_", lambda sign: chr(int(sign[1], 16)), text.text or "")
    return float(str(value.text)) if value is not None else None


def letters(number: int) -> str:
    """Letters of a column as a spreadsheet counts them: the 26 of one letter come before the 676 of two."""
    for length, before in ((1, 0), (2, 26), (3, 26 + 676)):
        place = number - before
        if place < 26**length:
            return "".join(chr(65 + place // 26**k % 26) for k in reversed(range(length)))
    raise ValueError(number)
