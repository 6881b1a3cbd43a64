"""Files of measured numbers: what is read, and what is refused with its line."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from bounded import bounded
from rattle.errors import InputError
from rattle.exchange.recording import MOST_LINES, MOST_ROWS, Recording, read_recording, recording_of

pytestmark = pytest.mark.nojit
T, FORCE = [0.0, 0.01, 0.025], [0.5, -1.25, 3e3]


def read(text: str) -> Recording:
    return recording_of(text, "m.csv")


def force(recording: Recording) -> list[float]:
    return recording.values(recording.column("force")).tolist()


WAYS = {
    "commas": "t [s],force [kN]\n0,0.5\n0.01,-1.25\n0.025,3e3\n",
    "semicolons with decimal commas": "t [s];force [kN]\n0;0,5\n0,01;-1,25\n0,025;3e3\n",
    "tabs with decimal commas": "t [s]\tforce [kN]\n0\t0,5\n0,01\t-1,25\n0,025\t3e3\n",
    "semicolons with points": "t [s]; force [kN]\n0; .5\n0.01;-1.25\n0.025;3.0E+3\n",
    "mark of byte order, Windows, comments, blanks": "\ufeff# bench 3\r\n\r\nt [s];force [kN]\r\n0;0,5\r\n# break\r\n"
    "0,01;-1,25\r\n;\r\n0,025;3e3",
    "lines of old Macs": "t [s],force [kN]\r0,0.5\r0.01,-1.25\r0.025,3e3\r",
    "time in another unit and column": "note,force [kN],Time [ms]\na,0.5,0\nb,-1.25,10\n,3e3,25\n",
    "first column of another name": "Zeit [ms],force [kN]\n0,0.5\n10,-1.25\n25,3e3\n",
    "time without a unit": "time,force [kN]\n0,0.5\n0.01,-1.25\n0.025,3e3\n",
    "quoted cells": '"t [s]","force [kN]","a, b"\n"0","0.5","x,y"\n0.01,-1.25,\n0.025,3e3,\n',
    "head in a comment, as NumPy writes it": "# run 5\n# t [s],force [kN]\n0,0.5\n0.01,-1.25\n0.025,3e3\n",
    "line of Excel": "sep=;\r\nt [s];force [kN]\r\n0;0,5\r\n0,01;-1,25\r\n0,025;3e3\r\n",
}  # fmt: skip


@pytest.mark.parametrize("way", WAYS)
def test_the_same_numbers_are_read_however_they_are_written(way: str) -> None:
    recording = read(WAYS[way])
    assert recording.t.tolist() == pytest.approx(T, rel=1e-15)
    assert force(recording) == FORCE
    assert recording.column("force").scale("") == (1000.0, pytest.approx((1, 1, -2, 0)))


def test_powers_in_units_may_be_printed_signs() -> None:
    recording = read("t [s];a [mm/s²]\n0;1\n")
    assert recording.column("a").scale("")[0] == pytest.approx(1e-3, rel=1e-15)


def test_what_numpy_and_rattle_write_is_read(tmp_path: Path) -> None:
    numbers = np.array([T, FORCE]).T
    np.savetxt(tmp_path / "n.csv", numbers, delimiter=",", header="t [s],force [kN]")
    assert read_recording(tmp_path / "n.csv").t.tolist() == T
    assert force(read_recording(tmp_path / "n.csv")) == FORCE


REFUSED = {
    "": "'m.csv' is empty",
    "# only\n\n": "'m.csv' is empty",
    "t [s];x [m]\n": "holds no numbers",
    "0;1\n1;2\n": "line 1: numbers without a head; expected names and units in the first line",
    "# a comment\n0;1\n": "line 2: numbers without a head",
    "t [s]\n0\n": "line 1: one column",
    "t [s] x [mm]\n0 1\n": "line 1: one column; .* parted by semicolons, tabs or commas",
    "t [s];x\n0;1\n1\n": "line 3: expected 2 columns as in the head, found 1; the line is not complete",
    "t [s],x [m]\n0,5,1,5\n": "line 2: expected 2 columns .* found 4; with decimal commas .* semicolons",
    "t [s];x\n0;nan\n": "line 2: 'nan' in the column 'x' is not a finite number",
    "t [s];x\n0;1\n1;-inf\n": "line 3: '-inf' in the column 'x' is not a finite number",
    "t [s];x\n0;1\n1;\n": "line 3: the column 'x' has no number here",
    "t [s];x\n0;1\n1;1e999\n": "line 3: '1e999' is too large a number",
    "t [s];x\n0;1.234,5\n": "line 2: .* is not a finite number; thousands are not parted",
    "t [s];x\n0;1_000\n": "line 2: '1_000' in the column 'x' is not a finite number",
    "t [s];x\n0,5;1.5\n": "line 2: 1.5 and 0,5 in one file: decimals are parted by points or by commas",
    "t [s];x\n0;1,5\n1;2.5\n": "line 3: 2.5 and 1,5 in one file",
    "t [s];x\n0;1\n2;1\n1;2\n": "line 4: 1 follows on 2: times must not decrease",
    "angle [deg];x\n0;1\n": "line 1: 'angle .deg.' is a plain number or angle, not a time; .* stands first",
    "t [mm];x\n0;1\n": "line 1: 't .mm.' is a length, not a time",
    "t [sec];x\n0;1\n": "line 1: 't .sec.': unknown unit 'sec'",
    "t [s];x [fluid]\n0;1\n": "line 1: 'x .fluid.': unknown unit 'fluid'",
    "t [s];x (kN)\n0;1\n": r"write the unit in square brackets, 'x \[kN\]'",
    "t [s];x / kN\n0;1\n": r"write the unit in square brackets, 'x \[kN\]'",
    "t [s];x [m] [s]\n0;1\n": "line 1: expected a head such as",
    "t [s];x;x\n0;1;2\n": "line 1: 2 columns are called 'x'",
}  # fmt: skip


def use(text: str) -> None:
    """Read a file, and all numbers of its first column besides time."""
    recording = read(text)
    title = recording.column(recording.columns[0].text)
    title.scale(recording.place)
    recording.values(title)


@pytest.mark.parametrize("text", REFUSED)
def test_what_does_not_fit_is_refused_with_its_line(text: str) -> None:
    with pytest.raises(InputError, match=REFUSED[text]):
        use(text)


def test_columns_that_nobody_asks_for_may_hold_anything() -> None:
    recording = read("t [s];x [mm];note;y [fluid]\n0;1;nan;\n1;2;a b;?\n")
    assert recording.values(recording.column("x [mm]")).tolist() == [1.0, 2.0]


def test_files_that_are_none_of_text_or_not_there_are_refused(tmp_path: Path) -> None:
    (tmp_path / "latin.csv").write_bytes("t [s];a [°]\n0;1\n".encode("latin-1"))
    with pytest.raises(InputError, match=r"'latin\.csv' is not UTF-8 text; save it as CSV in UTF-8"):
        read_recording(tmp_path / "latin.csv")
    with pytest.raises(InputError, match="there is no file"):
        read_recording(tmp_path / "none.csv")
    with pytest.raises(InputError, match="is a folder"):
        read_recording(tmp_path)
    (tmp_path / "zip.csv").write_bytes(b"PK\x03\x04" + bytes(range(256)))
    with pytest.raises(InputError):
        read_recording(tmp_path / "zip.csv")


HOSTILE = {
    "more than 8 MB": "x" * 8_000_001,
    f"more than {MOST_LINES} lines": "\x1c" * (MOST_LINES + 1),
    f"line {MOST_ROWS + 2}: more than {MOST_ROWS} rows": "t;x\n" + "1;2\n" * (MOST_ROWS + 1),
    "is not a finite number": "t;x\n0;" + "1" * 131_000 + "x\n",
    "a head such as": "t;" + "a/b " * 30_000 + "\n0;1\n",
    "found 2000001": "t;x\n" + "1;" * 2_000_000 + "1\n",
    "at most 1000 are read": ";" * 100_000 + "t\n0;1\n",
    "field larger": 't;"x\n' + "1;2\n" * 100_000,
}


@pytest.mark.parametrize("words", HOSTILE)
def test_hostile_files_are_refused_soon(words: str) -> None:
    with bounded(), pytest.raises(InputError, match=words):  # without the limits: minutes, or no end at all
        use(HOSTILE[words])


def test_no_prefix_of_a_file_is_read_as_other_numbers() -> None:
    """A file that was cut off is refused, or ends with a whole line before the cut."""
    text = WAYS["semicolons with decimal commas"]
    for end in range(len(text)):
        try:
            recording = read(text[:end])
            values = force(recording)
        except InputError:
            continue
        shared = len(values) - 1  # the last number may have lost digits: nothing in the text tells
        assert values[:shared] == FORCE[:shared]
        assert all(math.isfinite(value) for value in values)
