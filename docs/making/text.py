"""Docstrings as Markdown and as reStructuredText: paragraphs, and indented parts unchanged."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable
from functools import cache
from pathlib import Path

THEORY = Path(__file__).parents[1] / "theory.md"
_CITED = re.compile(r"docs/theory\.md, section (\d+(?:\.\d)?)")
_CODE = re.compile(r"(`[^`\n]+`)")


def blocks(text: str) -> list[tuple[bool, list[str]]]:
    """(preformatted, lines): paragraphs, and indented parts that follow an empty line or the start."""
    found: list[tuple[bool, list[str]]] = []
    after_gap = True
    for line in inspect.cleandoc(text).splitlines():
        if not line.strip():
            after_gap = True
            continue
        plain = line.startswith("    ")
        if found and plain and found[-1][0]:
            found[-1][1].extend([""] * after_gap + [line])
        elif after_gap or not found or found[-1][0]:
            found.append((plain and after_gap, [line]))
        else:
            found[-1][1].append(line)
        after_gap = False
    return found


def markdown(text: str) -> str:
    """A docstring as Markdown."""
    parts = []
    for plain, lines in blocks(text):
        parts.append(fence("\n".join(line[4:] for line in lines)) if plain else paragraph(" ".join(lines)))
    return "\n\n".join(parts)


def paragraph(text: str) -> str:
    """Text of a docstring on one line, escaped for Markdown; sections of the theory become links."""
    pieces = _CODE.split(" ".join(text.split()))
    safe = [one if one.startswith("`") and len(one) > 1 else re.sub(r"([\\*_<>\[\]|])", r"\\\1", one) for one in pieces]
    return _CITED.sub(lambda m: f"[theory, section {m[1]}](theory.md#{sections()[m[1]]})", "".join(safe))


@cache
def sections() -> dict[str, str]:
    """Sections of the theory by number, with the name under which a heading is linked to."""
    found = re.findall(r"^##+ ((\d+(?:\.\d)?)\.? .*)$", THEORY.read_text(encoding="utf-8"), re.MULTILINE)
    return {number: anchor(title) for title, number in found}


def anchor(title: str) -> str:
    """The name under which a heading is linked to."""
    return re.sub(r"[^\w -]", "", title.lower()).strip().replace(" ", "-")


def code(text: str) -> str:
    """Text as inline code."""
    return f"`{text}`".replace("|", "\\|") if text else ""


def fence(text: str, language: str = "text") -> str:
    """Lines as a code block."""
    return f"```{language}\n{text.rstrip()}\n```"


def shell(lines: Iterable[str]) -> str:
    """Commands with their explanations as comments, ready to be copied."""
    parts = [[*re.split(r"\s{2,}", line.strip(), maxsplit=1), ""][:2] for line in lines if line.strip()]
    return fence("\n".join(f"{one}  # {said}" if said else one for one, said in parts), "sh")


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table; cells are Markdown already."""
    head = list(head)
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def restructured(text: str, parameters: Iterable[str] = ()) -> list[str]:
    """A docstring as reStructuredText; "name: meaning." of a parameter becomes an entry of a list."""
    lines: list[str] = []
    entries: list[str] = []
    known = "|".join(map(re.escape, parameters)) or "(?!)"
    start = re.compile(rf"(?:^|(?<=\.)\s+)((?:(?:{known}), )*(?:{known})): ")
    for plain, words in blocks(text):
        if plain:
            lines += ["::", "", *words, ""]
            continue
        before, *named = start.split(" ".join(" ".join(words).split()))
        rest = ""
        if named:
            named[-1], rest = _without_closing_words(named[-1])
        entries += [f"- **{names}**: {_inline(said)}" for names, said in zip(named[::2], named[1::2], strict=True)]
        lines += [part for one in (before, rest) if one for part in (_inline(one), "")]
    return [*lines, *field("Parameters", entries)]


def field(title: str, entries: Iterable[str]) -> list[str]:
    """A titled list below a docstring; empty if there are no entries."""
    inside = [f"   {one}" for one in entries]
    return [f":{title}:", *inside, ""] if inside else []


def _without_closing_words(text: str) -> tuple[str, str]:
    """The text about a parameter, and the sentences after it that are about the whole function."""
    cut = re.search(r"\s(?=(?:Raises|Returns|Source:|Every time) )", text)
    return (text[: cut.start()], text[cut.end() :]) if cut else (text, "")


def _inline(text: str) -> str:
    pieces = _CODE.split(text)
    safe = [f"`{one}`" if one[:1] == "`" and len(one) > 1 else re.sub(r"([\\*_|`])", r"\\\1", one) for one in pieces]
    return _CITED.sub(lambda m: f"`theory, section {m[1]} <theory.html#section-{m[1]}>`__", "".join(safe))
