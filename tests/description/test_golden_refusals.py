"""The answers to wrong models, the schema and `rattle kinds` stay word for word; see `golden_refusals`."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import golden_refusals
from rattle import registry

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

TESTS = Path(__file__).parents[1]
ENOUGH = 400  # refusals
FAMILIES = ("joint", "load", "normal", "film", "friction", "stiffness")

UNNAMED = {"power"}  # the law of a contact that says its stiffness


@pytest.fixture(scope="module")
def refusals():
    return "\n".join(told("refusals"))


def test_refusals_are_word_for_word(refusals):
    assert refusals.split("\n\n") == golden_refusals.REFUSALS.read_text(encoding="utf-8").split("\n\n")


def test_many_models_are_refused(refusals):
    assert refusals.count("\n# ") > ENOUGH


@pytest.mark.parametrize("family", FAMILIES)
def test_wrong_models_of_every_kind_are_refused(refusals, family):
    titles = "\n".join(line for line in refusals.split("\n") if line.startswith("# "))
    shipped = [
        name
        for name, kind in registry.kinds(family).items()
        if "rattle.elements" in str(kind.leaf) and "custom" not in str(kind.leaf)
    ]
    assert {name for name in shipped if name not in titles} <= UNNAMED


def test_hand_written_mistakes_are_refused(refusals):
    assert [title for title in golden_refusals.HAND if f"# {title} (" not in refusals] == []


def told(name: str) -> list[str]:
    """What a function of `golden_refusals` returns in a process that knows no laws of other tests."""
    program = f"import golden_refusals, sys; sys.stdout.write(golden_refusals.{name}())"
    path = os.pathsep.join([str(TESTS), *filter(None, [os.environ.get("PYTHONPATH")])])
    env = os.environ | {"PYTHONPATH": path, "PYTHONIOENCODING": "utf-8"}
    done = subprocess.run([sys.executable, "-c", program], env=env, capture_output=True, check=True)
    return done.stdout.decode("utf-8").split("\n")


def test_the_schema_is_word_for_word():
    assert told("condensed") == golden_refusals.SCHEMA.read_text(encoding="utf-8").split("\n")


def test_what_kinds_prints_is_word_for_word():
    assert told("kinds_told") == golden_refusals.KINDS.read_text(encoding="utf-8").split("\n")
