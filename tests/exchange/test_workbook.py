"""Workbooks: names of sheets, texts, numbers and limits."""

from __future__ import annotations

import math

import pytest

from rattle.errors import InputError
from rattle.exchange.workbook import Sheet, column_letters, sheet_names, workbook
from workbooks import letters, read_workbook

pytestmark = pytest.mark.nojit


def one_sheet(*rows: list[object], head: tuple[str, ...] = ("a", "b")) -> list[list[object]]:
    return read_workbook(workbook([Sheet("s", head, rows, len(rows))]))["s"]  # type: ignore[arg-type]


def test_numbers_come_back_bit_by_bit() -> None:
    numbers = [0.1, 1 / 3, -5e-324, 1.7976931348623157e308, 123456789012345678.0, -0.0]
    rows = one_sheet(*([number, 2 * k] for k, number in enumerate(numbers)))[1:]
    assert [float(str(row[0])).hex() for row in rows] == [number.hex() for number in numbers]


def test_a_cell_without_a_number_is_empty_and_infinity_is_a_word() -> None:
    assert one_sheet([math.nan, math.inf], [None, -math.inf])[1:] == [[None, "inf"], [None, "-inf"]]


def test_texts_with_signs_of_xml_and_controls_come_back() -> None:
    texts = ["a < b & \"c\" > 'd'", "line\nbreak", "\x00\x07 bell", "_x0041_ is no A", "  spaces  ", "µ 😀"]
    assert [row[0] for row in one_sheet(*([text, None] for text in texts))[1:]] == texts


def test_a_text_that_no_cell_holds_is_cut_with_a_word() -> None:
    (text, _) = one_sheet(["x" * 40_000, None])[1]
    assert len(str(text)) <= 32_767
    assert str(text).endswith("(cut: a cell holds no more)")


@pytest.mark.parametrize("number", [0, 25, 26, 51, 52, 701, 702, 16_383])
def test_columns_are_lettered_as_spreadsheets_do(number: int) -> None:
    assert column_letters(number) == letters(number)
    assert column_letters(16_383) == "XFD"  # the last column of a sheet


def test_names_of_sheets_can_stand_in_a_workbook() -> None:
    wanted = ["a[b]:c*d?e/f\\g", "A_b__c_d_e_f_g", "x" * 40, "X" * 50, "", "'quoted'", "History", "😀" * 20, "tab\t"]
    names = sheet_names(wanted)
    assert len({name.casefold() for name in names}) == len(names)
    for name in names:
        assert 0 < len(name.encode("utf-16-le")) // 2 <= 31
        assert not set(name) & set("[]:*?/\\\t")
        assert not name.startswith("'")
        assert not name.endswith("'")
        assert name.casefold() != "history"


def test_a_sheet_with_too_many_rows_or_columns_is_refused() -> None:
    with pytest.raises(InputError, match=r"1048576 rows; a sheet .* 1048575 below its head"):
        workbook([Sheet("s", ("a",), (), 1_048_576)])
    with pytest.raises(InputError, match="16385 columns; a sheet of a workbook holds 16384"):
        workbook([Sheet("s", ["a"] * 16_385, (), 0)])
