"""The guides are true: their model runs, their names are those of the code, references resolve."""

import ast
import json
import re
import tomllib
from pathlib import Path

import pytest

import rattle as rt
from rattle.description.reader import STATE_UNITS
from rattle.language.syntax import FUNCTIONS
from rattle.questions.ensemble.fields import fields_of

ROOT = Path(__file__).parent.parent
DOCS = {path.name: path.read_text(encoding="utf-8") for path in (ROOT / "docs").glob("*.md")}
pytestmark = pytest.mark.nojit


def guide_to_models():
    """The model, the plate and the tolerances that the guide shows."""
    blocks = re.findall(r"```toml\n(.*?)```", DOCS["model-file.md"], re.DOTALL)
    signs = ("format = 1", "holes", "[tolerances]")
    model, plate, tolerances = (next(block for block in blocks if sign in block) for sign in signs)
    return model, plate, tolerances


def test_the_model_of_the_guide_can_be_put_together():
    m = rt.loads(guide_to_models()[0])
    assert m.check().mobility >= 0
    assert m.start.residual < 1e-9


def test_the_plate_of_the_guide_is_an_angle_with_a_hole():
    m = rt.loads(f"format = 1\nparameters.w = 0.3\nground.points = {{}}\n{guide_to_models()[1]}")
    area = 0.3**2 - 0.22**2 - 0.04 * 0.04 / 2
    assert m.model.bodies["crank"].mass == pytest.approx(78.5 * area, rel=1e-12)


def test_the_tolerances_of_the_guide_can_be_drawn():
    model, _, tolerances = guide_to_models()
    document, more = tomllib.loads(model), tomllib.loads(tolerances)
    merged = {**document, **more, "parameters": {**document["parameters"], **more["parameters"]}}
    fields = fields_of(rt.loads(json.dumps(merged)), list(more["parameters"]))
    assert fields.names == ("l2", "l3", "c", "pin")
    assert [one.dist for one in fields.fields] == ["uniform", "normal", "triangular", "table"]
    assert fields.draw == (0, 0, 1, 2)


def test_the_guide_names_every_function_and_state():
    text = DOCS["model-file.md"]
    (listed,) = re.findall(r"`rattle kinds functions`: `([^`]*)`", text)
    assert set(listed.split()) == set(FUNCTIONS)
    assert all(f".{key}" in text for key in STATE_UNITS)


@pytest.mark.parametrize("name", sorted(DOCS))
def test_links_of_the_guides_lead_somewhere(name):
    for target in re.findall(r"\]\(([^)#:]+)\)", DOCS[name]):
        made = target.startswith("generated/")  # by the build of the pages, which refuses pictures that are not there
        assert made or (ROOT / "docs" / target).exists(), f"{name}: {target}"


def test_the_guide_to_results_explains_every_kind_of_event_and_names_that_exist():
    from rattle.analyses.dynamics.events import KINDS

    text = DOCS["results.md"]
    assert all(f"`{kind}`" in text for kind in (*KINDS, "jolt"))
    (code,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    for name in re.findall(r"\br\.(\w+)", code):
        assert hasattr(rt.Result, name) or name in ("t", "trust"), name


def asked_of_sources():
    """All names that the programs of the documentation look up in the sources, those of one call together."""
    calls = [
        node
        for file in sorted((ROOT / "docs" / "making").glob("*.py"))
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    ]
    asking = [call.args for call in calls if call.func.id in ("source_of", "module_with")]
    return [[name.value for name in names] for names in asking if all(isinstance(n, ast.Constant) for n in names)]


@pytest.mark.parametrize("names", asked_of_sources())
def test_what_the_documentation_takes_from_the_sources_is_there(names, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "docs")
    from making.tree import source_of

    assert source_of(*names).names >= set(names)
