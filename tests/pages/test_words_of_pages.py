"""Words of pages in other languages: one table that has what is asked for, all of it in every language, and no more."""

import csv
import re
from importlib import resources

import pytest

from rattle import registry
from rattle.analyses.dynamics.events import KINDS
from rattle.drawings.arrows import OF_JOINTS, OF_LOADS, OF_TURNS
from rattle.errors import InputError
from rattle.pages.replay import SILENT
from rattle.pages.viewer_text import viewer_files
from rattle.pages.words import LANGUAGES, UNNAMED, table, words_in
from rattle.results.handy_units import QUANTITY

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

ASKED = re.compile(r'\bword\(\s*"((?:[^"\\]|\\.)*)"')
OF_FILMS = (
    "eccentricity",
    "sommerfeld",
    "lambda ratio",
    "regime",
    "leakage",
)  # what a panel is of where no unit says it
OF_RUNS = ("without play", "as in the model file")  # labels
# accessible names and hints that are written as they are, in an element or as arguments of `button` and `toggle`
WRITTEN = re.compile(
    r"""(?:"aria-label"|\btitle|\bplaceholder): ["`][^"`$]*[A-Za-z]{2}|\b(?:button|toggle)\("[^"]*", "[A-Za-z]"""
)


def asked_by_the_viewer():
    return {text for file in viewer_files().values() for text in ASKED.findall(file)}


def of_parts():
    """Kinds of joints and loads of the package, and what their events are called."""
    for family in ("joint", "load"):
        for name, kind in registry.kinds(family).items():
            if kind.leaf.__module__.startswith("rattle."):  # other tests may have added theirs
                yield name
                yield from getattr(kind.leaf, "events", {}).values()


def test_the_table_has_what_a_page_asks_for_and_no_more():
    """A kind of joint or load that it does not have is called as in the model file: a new one needs no row."""
    further = {SILENT, UNNAMED, OF_JOINTS, OF_LOADS, OF_TURNS, *KINDS, *QUANTITY.values(), *OF_FILMS, *OF_RUNS}
    needed = asked_by_the_viewer() | further
    assert needed - set(table()) == set()
    assert set(table()) - needed - set(of_parts()) == set()


def test_every_word_is_there_in_every_language_with_what_is_put_in():
    with (resources.files("rattle.pages") / "words.csv").open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    assert tuple(head) == LANGUAGES
    assert len({row[0] for row in rows}) == len(rows)
    for text, *others in rows:
        places = sorted(re.findall(r"\{\w+\}", text))
        for other in others:
            assert other == other.strip() != "", text
            assert sorted(re.findall(r"\{\w+\}", other)) == places, other
        assert re.search("[\u4e00-\u9fff]|^Home, End$|^{name} ", others[-1]), text  # names of keys are on the keys


def test_the_viewer_has_no_accessible_name_past_the_table():
    for name, text in viewer_files().items():
        assert WRITTEN.findall(text) == [], name


def test_a_language_that_is_not_there_is_refused():
    with pytest.raises(InputError, match="no language 'nl'; known: en, de, fr, es, zh"):
        words_in("nl")
    assert words_in("en") == {}
    assert words_in("fr")["Forces"] == "Forces"


def test_words_are_put_in_and_unknown_texts_stay_as_they_are(viewer_in_node):
    said = viewer_in_node(
        """
        import { speaking } from "./viewer.mjs";
        const word = speaking(data), english = speaking(undefined);
        console.log(JSON.stringify([word("{count} notes", { count: 3 }), word("constructor"), word("c = {0.1}"),
          english("{count} notes", { count: 0 })]));
        """,
        {"{count} notes": "{count} Hinweise"},
    )
    assert said == ["3 Hinweise", "constructor", "c = {0.1}", "0 notes"]
