"""The guide about named data prints what it shows, and its table of bearings is that of the program."""

import contextlib
import io
import re

import pytest

from rattle.catalogue.bearings import bearing
from test_pages import BLOCK, DOCS, shows

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
PAGE = DOCS["named-data.md"]
BLOCKS = BLOCK.findall(PAGE)


def test_the_guide_prints_what_it_shows():
    code = "\n".join(text for language, text in BLOCKS if language == "python")
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(compile(code, "named-data.md", "exec"), {})
    lines = [line for language, text in BLOCKS if language == "text" for line in text.splitlines()]
    assert len(lines) >= 11
    for line in lines:
        assert shows(said.getvalue(), line, 1e-3), f"{line}\n{said.getvalue()}"


def test_the_table_of_bearings_is_that_of_the_program():
    rows = re.findall(r"^\| (6\d+(?: C\d)?) \| (\S+) to (\S+) \| (\S+) ± (\S+) \|$", PAGE, re.MULTILINE)
    assert len(rows) == 4
    for number, *figures in rows:
        play = bearing(number)
        assert [float(one) for one in figures] == pytest.approx(
            [size * 1e6 for size in (play.least, play.largest, play.radial, play.tol)]
        )
