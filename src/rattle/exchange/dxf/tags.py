"""The text of a DXF file as tags: pairs of lines, a group code and a value.

Source: AutoCAD 2018 DXF reference, Autodesk (2017), "Group codes in DXF files".
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

from rattle.exchange.refusal import number_of, quoted, refused

MOST = 8_000_000  # characters of a file
MOST_TAGS = 150_000
BINARY = "AutoCAD Binary DXF"
COMMENT = 999  # the group code of one
LONGEST_CODE = 6  # characters of a group code, with its blanks: "  1071" at most
ESCAPE = re.compile(r"\\[Uu]\+([0-9A-Fa-f]{4})")  # a letter that the code page of the file does not have


class Tag(NamedTuple):
    """A group code and its value."""

    code: int
    value: str
    line: int  # of the value


class Entity:
    """What begins with a group code 0: its kind and all tags up to the next one."""

    __slots__ = ("_first", "kind", "line", "name", "tags")

    def __init__(self, kind: str, line: int, name: str) -> None:
        self.kind, self.line, self.name = kind, line, name
        self.tags: list[Tag] = []
        self._first: dict[int, Tag] = {}

    @property
    def first(self) -> dict[int, Tag]:
        """The first tag of every code; asked for when all are there."""
        if not self._first:
            self._first = {tag.code: tag for tag in reversed(self.tags)}
        return self._first

    def text(self, code: int, default: str = "") -> str:
        """The first value of a code."""
        return unescaped(self.first[code].value) if code in self.first else default

    def number(self, code: int, default: float | None = None) -> float:
        """The first value of a code as a number; without a default it must be there.  Raises ModelError."""
        if code in self.first:
            return self.as_number(self.first[code])
        if default is None:
            raise refused(self.name, f"a {self.kind} without a value of group code {code}", self.line)
        return default

    def whole(self, code: int, default: int = 0) -> int:
        """The first value of a code as a whole number."""
        return int(self.number(code, default))

    def as_number(self, tag: Tag) -> float:
        """The value of a tag as a number.  Raises ModelError."""
        number = number_of(tag.value)
        if number is None:
            raise refused(self.name, f"{self.kind}: expected a number, got {quoted(tag.value)}", tag.line)
        return number


def unescaped(text: str) -> str:
    """The text with letters in place of their numbers."""
    return ESCAPE.sub(lambda match: chr(int(match[1], 16)), text) if "\\" in text else text


def tags_of(text: str, name: str) -> Iterator[Tag]:
    """All tags but comments.  Raises ModelError on text that is no DXF."""
    if text.startswith(BINARY):
        raise refused(name, "a binary DXF; save it as ASCII DXF")
    if len(text) > MOST:
        raise refused(name, f"more than {MOST // 1_000_000} million characters; save the parts of the mechanism only")
    # not splitlines: a text may hold letters of an old code page that end lines elsewhere
    lines = text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n").split("\n")
    while lines and not lines[-1].strip():
        lines.pop()
    if len(lines) > 2 * MOST_TAGS:
        raise refused(name, f"more than {2 * MOST_TAGS} lines; save the parts of the mechanism only")
    codes: dict[str, int] = {}
    for k in range(0, len(lines) - 1, 2):
        written = lines[k]
        if written not in codes:
            codes[written] = _code(written, name, k + 1)
        if codes[written] != COMMENT:
            yield Tag(codes[written], lines[k + 1].strip(), k + 2)


def _code(written: str, name: str, line: int) -> int:
    """A group code.  Raises ModelError."""
    code = written.strip()
    if len(code) > LONGEST_CODE or not (code.removeprefix("-").isdecimal() and code.isascii()):
        raise refused(name, f"not a DXF: expected a group code, got {quoted(code)}", line)
    return int(code)


def entities_of(text: str, name: str) -> Iterator[Entity]:
    """What begins with code 0, in order; tags before the first are of one without a kind.  Raises ModelError."""
    entity, last = Entity("", 1, name), Tag(0, "", 1)
    for last in tags_of(text, name):
        if last.code == 0:
            yield entity
            entity = Entity(last.value.upper(), last.line, name)
        else:
            entity.tags.append(last)
    yield entity
    if entity.kind != "EOF":
        raise refused(name, "not a whole DXF: it ends without 0 EOF", last.line)
