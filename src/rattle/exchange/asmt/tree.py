"""The text of an .asmt file as a tree: what stands under a word is one level deeper, by tabs or blanks.

    Part
            Mass
                    0.2

The results of a run that may stand behind the assembly are not read.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rattle.exchange.refusal import number_of, quoted, refused

HEADS = ("freeCAD: 3D CAD with Motion Simulation", "OndselSolver")  # how the first line begins
RESULTS = "TimeSeries"  # from here on
LONGEST_ROW = 400  # characters of a line of numbers
MOST_LINES = 300_000  # an assembly of 200 parts has about 20,000


class Entry(NamedTuple):
    """A line and what stands under it."""

    text: str
    line: int  # in the file, from 1 on
    inner: list[Entry]


def is_assembly(text: str) -> bool:
    """True of a text that begins as one of these files does."""
    return text.lstrip("\ufeff \t\r\n").startswith(HEADS)


class Tree:
    """The entries of a file; every question raises ModelError with file and line where there is no answer."""

    def __init__(self, text: str, file: str) -> None:
        self.file = file
        self.top = _entries(text, file)

    def refused(self, entry: Entry, message: str) -> Exception:
        """The error to raise about an entry."""
        return refused(self.file, message, entry.line)

    def has(self, entry: Entry, word: str) -> bool:
        """True if the word stands under the entry."""
        return any(part.text == word for part in entry.inner)

    def part(self, entry: Entry, word: str, of: str = "") -> Entry:
        """What stands under the entry at this word; of: what it belongs to, for the message."""
        for part in entry.inner:
            if part.text == word:
                return part
        raise self.refused(entry, f"{of or entry.text}: there is no {word}; is the file complete?")

    def all(self, entry: Entry, word: str) -> Iterator[Entry]:
        """All entries of this word directly under the entry."""
        return (part for part in entry.inner if part.text == word)

    def text(self, entry: Entry, word: str, of: str = "") -> str:
        """The line under a word."""
        part = self.part(entry, word, of)
        if not part.inner:
            raise self.refused(part, f"{of or entry.text}: {word} has no value; is the file complete?")
        return part.inner[0].text

    def name(self, entry: Entry) -> str:
        """The name of an entry, which may be empty."""
        inner = self.part(entry, "Name").inner
        return inner[0].text if inner else ""

    def numbers(self, entry: Entry, word: str, many: int, of: str = "") -> tuple[float, ...]:
        """Numbers in the line under a word."""
        part = self.part(entry, word, of)
        return self.row(part, part.inner[0] if part.inner else part, many, f"{of or entry.text}: {word}")

    def row(self, part: Entry, row: Entry, many: int, what: str) -> tuple[float, ...]:
        """Numbers in a line that stands under `part`."""
        words = row.text[:LONGEST_ROW].split() if row is not part else []
        if len(words) != many:
            fault = f"{what}: expected {many} numbers, got {len(words)}; is the file complete?"
            raise self.refused(row, fault)
        numbers = []
        for word in words:
            number = number_of(word)
            if number is None:
                raise self.refused(row, f"{what}: {quoted(word)} is not a number within reach")
            numbers.append(number)
        return tuple(numbers)


def _entries(text: str, file: str) -> Entry:
    """The whole file under its second line, the word Assembly."""
    end = text.find(f"\n{RESULTS}")
    lines = (text if end < 0 else text[:end]).lstrip("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
    if lines.count("\n") > MOST_LINES:
        raise refused(file, f"the assembly has more than {MOST_LINES} lines; is it the right file?")
    top, head = Entry("", 0, []), False
    open_entries: list[tuple[int, Entry]] = [(-1, top)]
    for number, line in enumerate(lines.split("\n"), 1):
        word = line.strip()
        if not word:
            continue
        if not head:
            if not word.startswith(HEADS):
                raise refused(file, f"not an assembly of Ondsel or FreeCAD: it begins with {quoted(word)}", number)
            head = True
            continue
        depth = len(line) - len(line.lstrip())
        while open_entries[-1][0] >= depth:
            open_entries.pop()
        entry = Entry(word, number, [])
        open_entries[-1][1].inner.append(entry)
        open_entries.append((depth, entry))
    for entry in top.inner:
        if entry.text == "Assembly":
            return entry
    raise refused(file, "there is no Assembly in the file; is it complete?", 1)
