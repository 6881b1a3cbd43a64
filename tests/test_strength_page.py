"""The guide about strength prints what it shows."""

import contextlib
import io

from test_pages import BLOCK, DOCS, shows

BLOCKS = BLOCK.findall(DOCS["strength.md"])


def test_the_guide_about_strength_prints_what_it_shows(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code = "\n".join(text for language, text in BLOCKS if language == "python")
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(compile(code, "strength.md", "exec"), {})
    lines = [line for language, text in BLOCKS if language == "text" for line in text.splitlines()]
    assert len(lines) == 10
    for line in lines:
        assert shows(said.getvalue(), line, 1e-3), f"{line}\n{said.getvalue()}"
    assert (tmp_path / "strength.png").stat().st_size > 10_000
