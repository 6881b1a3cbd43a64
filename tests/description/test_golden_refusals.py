"""The answers to wrong models, the schema and `rattle kinds` stay word for word; see `golden_refusals`."""

import pytest

import golden_refusals
from rattle import registry

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

ENOUGH = 400  # refusals
FAMILIES = ("joint", "load", "normal", "film", "friction", "stiffness")

UNNAMED = {"power"}  # the law of a contact that says its stiffness


@pytest.fixture(scope="module")
def refusals():
    return golden_refusals.refusals()


def test_refusals_are_word_for_word(refusals):
    assert refusals.split("\n\n") == golden_refusals.REFUSALS.read_text(encoding="utf-8").split("\n\n")


def test_many_models_are_refused(refusals):
    assert refusals.count("\n# ") > ENOUGH


@pytest.mark.parametrize("family", FAMILIES)
def test_wrong_models_of_every_kind_are_refused(refusals, family):
    titles = "\n".join(line for line in refusals.split("\n") if line.startswith("# "))
    assert {kind for kind in registry.kinds(family) if kind not in titles} <= UNNAMED


def test_hand_written_mistakes_are_refused(refusals):
    assert [title for title in golden_refusals.HAND if f"# {title} (" not in refusals] == []


def test_the_schema_is_word_for_word():
    assert golden_refusals.condensed().split("\n") == golden_refusals.SCHEMA.read_text(encoding="utf-8").split("\n")


def test_what_kinds_prints_is_word_for_word():
    assert golden_refusals.kinds_told().split("\n") == golden_refusals.KINDS.read_text(encoding="utf-8").split("\n")
