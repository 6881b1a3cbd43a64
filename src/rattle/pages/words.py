"""Pages in other languages: the words of the viewer in `words.csv`, a row for each text and a column for each language.

The viewer asks for a text by its English one (`viewer/words.js`); a page holds the words of its own language alone.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

from rattle.errors import InputError, suggest
from rattle.value_types import Tree

ENGLISH = "en"
LANGUAGES = (ENGLISH, "de", "fr", "es", "zh")
UNNAMED = "Mechanism"  # the title of a page without one


@functools.cache
def table() -> Mapping[str, Mapping[str, str]]:
    """The words of all languages: by the English text those of each."""
    import csv  # the command line reads the languages, and must be quick
    from importlib import resources

    text = (resources.files("rattle.pages") / "words.csv").read_text(encoding="utf-8")
    return {row[ENGLISH]: row for row in csv.DictReader(text.splitlines())}


def words_in(language: str) -> dict[str, str]:
    """The words of a language by their English ones; none of English, which needs none.

    Raises InputError for a language that the table does not have.
    """
    if language not in LANGUAGES:
        raise InputError(f"pages have no language '{language}'{suggest(language, LANGUAGES)}")
    return {} if language == ENGLISH else {text: words[language] for text, words in table().items()}


def in_language(scene: Tree, language: str) -> dict[str, Any]:
    """A scene whose viewer speaks this language.  Raises InputError for one that it does not know."""
    words = words_in(language)
    if not words:
        return dict(scene)
    title = words[UNNAMED] if scene["title"] == UNNAMED else scene["title"]
    return {**scene, "title": title, "language": language, "words": words}
