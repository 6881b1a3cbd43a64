"""The guides are true: their model runs, their names are those of the code, references resolve."""

import re
from pathlib import Path

import pytest

import rattle as rt
from rattle.description.reader import STATE_UNITS
from rattle.language.syntax import FUNCTIONS

ROOT = Path(__file__).parent.parent
DOCS = {path.name: path.read_text(encoding="utf-8") for path in (ROOT / "docs").glob("*.md")}
pytestmark = pytest.mark.nojit


def test_the_model_of_the_guide_can_be_put_together():
    (text,) = re.findall(r"```toml\n(.*?)```", DOCS["model-file.md"], re.DOTALL)
    m = rt.loads(text)
    assert m.check().mobility >= 0
    assert m.start.residual < 1e-9


def test_the_guide_names_every_function_and_state():
    text = DOCS["model-file.md"]
    (listed,) = re.findall(r"`rattle kinds functions`: `([^`]*)`", text)
    assert set(listed.split()) == set(FUNCTIONS)
    assert all(f".{key}" in text for key in STATE_UNITS)


@pytest.mark.parametrize("name", sorted(DOCS))
def test_links_of_the_guides_lead_somewhere(name):
    for target in re.findall(r"\]\(([^)#:]+)\)", DOCS[name]):
        assert (ROOT / "docs" / target).exists(), f"{name}: {target}"


def test_the_guide_to_results_explains_every_kind_of_event_and_names_that_exist():
    from rattle.analyses.dynamics.events import KINDS

    text = DOCS["results.md"]
    assert all(f"`{kind}`" in text for kind in (*KINDS, "jolt"))
    (code,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    for name in re.findall(r"\br\.(\w+)", code):
        assert hasattr(rt.Result, name) or name in ("t", "trust"), name
