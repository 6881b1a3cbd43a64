"""The guide about rattling runs, and what it shows of ten thousand samples is what sixteen of them say."""

import contextlib
import io
import math
import re

import pytest

from test_pages import BLOCK, DOCS

BLOCKS = BLOCK.findall(DOCS["rattling.md"])


def test_the_guide_shows_what_its_study_finds():
    (code,) = [text for language, text in BLOCKS if language == "python"]
    (shown,) = [text for language, text in BLOCKS if language == "text"]
    known, said = {}, io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(compile(code, "rattling.md", "exec"), known)
    found = known["found"]
    assert "16 run side by side" in said.getvalue()
    rows = re.findall(r"(\S+\([\w.]+\))\s+[NJ]?\s+([\d.]+)\s+([\d.]+) \+- \S+\s+([\d.]+)", shown)
    assert [output for output, *_ in rows] == known["of"]
    for output, nominal, mean, sd in rows:
        numbers = found.statistics(output)
        assert found.nominal[found.outputs.index(output)] == pytest.approx(float(nominal), rel=1e-3)
        assert abs(numbers.mean.value - float(mean)) < 4 * float(sd) / math.sqrt(len(found))
    assert found.yield_below(known["of"][0], "1 kN")[0] == 1.0
