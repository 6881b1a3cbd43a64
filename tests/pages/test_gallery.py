"""The gallery of the documentation: what its cards say and show, and how they are searched."""

import re
from pathlib import Path

import pytest

import rattle as rt
from browsing import becomes
from making.gallery import SUBJECTS, in_short, subjects
from rattle.plots.thumbnail import thumbnail

DOCS = Path(__file__).parents[2] / "docs"

pytestmark = [pytest.mark.nojit, pytest.mark.plain]


@pytest.mark.parametrize("name", sorted(rt.examples()))
def test_every_card_has_a_sentence_and_a_subject(name):
    assert re.fullmatch(r"[A-Z0-9].{10,180}[.?]", in_short(name))
    assert subjects(name)


def test_every_subject_finds_some_examples_but_not_most():
    for subject in SUBJECTS:
        with_it = [name for name in rt.examples() if subject in subjects(name)]
        assert 3 <= len(with_it) <= len(rt.examples()) / 2, subject


def test_subjects_are_those_of_the_model():
    assert {"play", "impact"} <= set(subjects("bouncing_pin"))
    assert {"oil", "play"} <= set(subjects("journal_falls"))
    assert subjects("chain") == ["ideal joints"]
    assert "gears, cams, slots" in subjects("geneva")


def test_a_pin_alone_is_drawn_large_in_its_bush():
    """Of a mechanism nothing but the pin would be a dot."""
    pin = thumbnail(rt.example("bouncing_pin").simulate(0.01))
    bars = thumbnail(rt.example("double_pendulum").simulate(0.01))
    path = "stroke: #56b4e9"  # of the pin
    assert path in pin
    assert path not in bars
    assert pin.startswith("<svg")


CARDS = {
    "journal_falls": ("oil", "Journal"),
    "bouncing_pin": ("impact", "Pin in its bush"),
    "fourbar_oil": ("oil;impact", "Both"),
}
SHOWN = """(names) =>
  [...document.querySelectorAll("a.example:not([hidden]) code")].map((one) => one.textContent).join() === names"""


def grid():
    """A page with three cards, as the gallery has them."""
    cards = "".join(
        f'<a class="example" href="#" data-subjects="{about}"><b>{title}</b><code>{name}</code></a>'
        for name, (about, title) in CARDS.items()
    )
    script = (DOCS / "_static" / "gallery.js").read_text(encoding="utf-8")
    cards = f'<div class="examples" data-subjects="oil;impact">{cards}</div>'
    return f'<!doctype html><meta charset="utf-8">{cards}<script>{script}</script>'


def test_words_and_subjects_narrow_the_cards(open_page, tmp_path):
    path = tmp_path / "gallery.html"
    path.write_text(grid(), encoding="utf-8")
    page = open_page(path.as_uri())
    search = page.get_by_label("Search the examples")
    becomes(page, SHOWN, "journal_falls,bouncing_pin,fourbar_oil")
    search.fill("PIN bush")
    becomes(page, SHOWN, "bouncing_pin")
    search.fill("oil")
    becomes(page, SHOWN, "journal_falls,fourbar_oil")
    page.get_by_role("button", name="impact").press("Enter")
    becomes(page, SHOWN, "fourbar_oil")
    assert page.get_by_role("status").text_content() == "1 of 3"
    search.fill("")
    page.get_by_role("button", name="impact").press("Enter")
    becomes(page, SHOWN, "journal_falls,bouncing_pin,fourbar_oil")
