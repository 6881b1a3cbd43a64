"""Why samples have no numbers, counted."""

from __future__ import annotations

import re
from collections.abc import Iterable

LONGEST = 100  # characters of a reason
NUMBER = re.compile(r"(?<!\w)-?\d[\d.]*(?:e[-+]?\d+)?")


def alike(message: str) -> str:
    """A message without its numbers, by which alike ones are counted."""
    return NUMBER.sub("...", message.partition("\n")[0])[:LONGEST]


def counted(messages: Iterable[str]) -> dict[str, int]:
    """How often there are alike messages, the most frequent first; numbers are kept that all of them have in common."""
    counts: dict[str, int] = {}
    shared: dict[str, list[str]] = {}  # numbers of alike messages, "..." where they differ
    texts: dict[str, str] = {}
    for message in messages:
        line = message.partition("\n")[0]
        kind, numbers = alike(line), NUMBER.findall(line)
        counts[kind] = counts.get(kind, 0) + 1
        texts.setdefault(kind, line)
        before = shared.setdefault(kind, numbers)
        if before != numbers:
            shared[kind] = [a if a == b else "..." for a, b in zip(before, numbers, strict=False)]
    by_text: dict[str, int] = {}
    for kind, count in sorted(counts.items(), key=lambda item: -item[1]):
        left = iter(shared[kind])
        parts = NUMBER.split(texts[kind])
        text = "".join(part + next(left, "...") for part in parts[:-1]) + parts[-1]
        text = text[:LONGEST]
        by_text[text] = by_text.get(text, 0) + count
    return by_text
