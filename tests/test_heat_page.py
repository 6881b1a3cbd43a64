"""The guide about heat and life prints what it shows."""

import contextlib
import io

import pytest

from test_pages import BLOCK, DOCS, shows

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
BLOCKS = BLOCK.findall(DOCS["heat-and-life.md"])


def test_the_guide_prints_what_it_shows():
    code = "\n".join(text for language, text in BLOCKS if language == "python")
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(compile(code, "heat-and-life.md", "exec"), {})
    lines = [line for language, text in BLOCKS if language == "text" for line in text.splitlines()]
    assert len(lines) == 9
    for line in lines:
        assert shows(said.getvalue(), line, 1e-3), f"{line}\n{said.getvalue()}"
