"""Where in a TOML text a value was written, for error messages that show the line.

A scanner of its own, because `tomllib` keeps no positions and a parser that does (tomlkit) takes seconds
where this takes milliseconds.  One pass, no recursion; it trusts that the text is valid TOML and simply
stops where it is not.
"""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass

WIDTH = 120  # longest piece of a source line that is shown

_SPACE = re.compile(r"[ \t]*+")
_GAP = re.compile(r"(?:[ \t\r\n]++|#[^\n]*+)*+")
_KEY = re.compile(r""""[^"\\\n]*+(?:\\.[^"\\\n]*+)*+"|'[^'\n]*+'|[^\s.=\[\]{}"'#,]++""")
_SCALAR = re.compile(
    r'"""[^"\\]*+(?:(?:\\.|"(?!""))[^"\\]*+)*+"{3,5}+'
    r"|'''[^']*+(?:'(?!'')[^']*+)*+'{3,5}+"
    r'|"[^"\\\n]*+(?:\\.[^"\\\n]*+)*+"'
    r"|'[^'\n]*+'"
    r"|[^,\]}#\r\n]++",
    re.DOTALL,
)


def locate(text: str, path: tuple[str | int, ...], key: bool = False) -> tuple[int, int] | None:
    """Line and column (both from 1) of the value at a key path in a valid TOML text.

    path: keys, and indices of arrays, e.g. ("initial", "O3", "offset", 0).  A table is where its header
    names it.  With `key` the place of the key instead of its value (array elements have none).  If there
    is no such value: the nearest parent that exists; None if there is none, or for an empty path.
    """
    scanner = _Scanner(text, path)
    scanner.run()
    if not scanner.depth:
        return None
    at = scanner.key_at if key else scanner.value_at
    return text.count("\n", 0, at) + 1, at - text.rfind("\n", 0, at)


def caret(text: str, line: int, column: int, width: int = 1) -> str:
    """The source line and, below, a caret under each of `width` characters from `column` (from 1).

    Of a very long line only the part around the column is shown; "" if there is no such line.
    """
    start = 0
    for _ in range(line - 1):
        start = text.find("\n", start) + 1
        if start == 0:
            return ""
    end = text.find("\n", start)
    source = text[start : len(text) if end < 0 else end].rstrip("\r")
    column = min(max(column, 1), len(source) + 1)
    begin = column - WIDTH // 2 if column > WIDTH - 20 else 0
    shown = source[begin : begin + WIDTH]
    left, right = "..." * (begin > 0), "..." * (begin + WIDTH < len(source))
    shown = "".join(c if c.isprintable() or c == "\t" else "?" for c in shown)
    indent = "".join("\t" if c == "\t" else " " for c in left + shown[: column - 1 - begin])
    width = max(1, min(width, len(shown) - (column - 1 - begin)))
    return f"{left}{shown}{right}\n{indent}{'^' * width}"


@dataclass(slots=True)
class _Frame:
    """An array or inline table that is open: how much of the path leads to it, and the running index."""

    array: bool
    depth: int
    index: int = 0


class _Scanner:
    """Follows one path through the text.

    `depth` counts the leading elements of the path that a place agrees with, -1 if it lies elsewhere.
    The best place so far is kept: the deepest; of these, one that is spelled out rather than passed
    through ("[a.b]" defines a.b, but passes through a); of these, the first.
    """

    def __init__(self, text: str, path: tuple[str | int, ...]) -> None:
        self.text = text
        self.path = path
        self.depth = 0
        self.exact = False
        self.key_at = self.value_at = 0
        self.tables: dict[int, int] = {}  # depth of an array of tables on the path: its last index

    def run(self) -> None:
        text, here = self.text, 0
        at: int | None = 1 if text.startswith("\ufeff") else 0
        while at is not None:
            at = self.skip(_GAP, at)
            if at >= len(text) or (self.exact and self.depth == len(self.path)):
                return
            if text[at] == "[":
                many = text.startswith("[[", at)
                keys, at = self.keys(at + 1 + many)
                if not keys:
                    return
                here = self.header(keys, many)
                at += 1 + many
            else:
                at = self.entry(at, here)

    # -------------------------------------------------- what agrees with the path
    def note(self, depth: int, key_at: int, value_at: int, exact: bool) -> None:
        if (depth, exact) > (self.depth, self.exact):
            self.depth, self.exact, self.key_at, self.value_at = depth, exact, key_at, value_at

    def wants(self, depth: int, part: str | int) -> bool:
        return 0 <= depth < len(self.path) and self.path[depth] == part and type(self.path[depth]) is type(part)

    def header(self, keys: list[tuple[str, int]], many: bool) -> int:
        """Depth of the table that a [header] or [[header]] opens."""
        depth = 0
        for n, (key, at) in enumerate(keys):
            last = n == len(keys) - 1
            if not self.wants(depth, key):
                return -1
            depth += 1
            self.note(depth, at, at, last and not many)
            if last and many:
                self.tables[depth] = self.tables.get(depth, -1) + 1
            if depth in self.tables:
                if not self.wants(depth, self.tables[depth]):
                    return -1
                depth += 1
                self.note(depth, at, at, last)
        return depth

    def follow(self, keys: list[tuple[str, int]], depth: int, value_at: int) -> int:
        """Depth of the value behind a (dotted) key in a table of the given depth."""
        for n, (key, at) in enumerate(keys):
            if not self.wants(depth, key):
                return -1
            depth += 1
            last = n == len(keys) - 1
            self.note(depth, at, value_at if last else at, last)
        return depth

    # -------------------------------------------------- what stands in the text
    def skip(self, pattern: re.Pattern[str], at: int) -> int:
        found = pattern.match(self.text, at)
        return found.end() if found else at

    def keys(self, at: int) -> tuple[list[tuple[str, int]], int]:
        """A dotted key: its parts with their places, and where it ends."""
        found: list[tuple[str, int]] = []
        while True:
            at = self.skip(_SPACE, at)
            match = _KEY.match(self.text, at)
            if match is None:
                return [], at
            found.append((_plain(match[0]), at))
            at = self.skip(_SPACE, match.end())
            if not self.text.startswith(".", at):
                return found, at
            at += 1

    def entry(self, at: int, depth: int) -> int | None:
        """One `key = value` in a table of the given depth; the place behind it, None if it is no entry."""
        keys, at = self.keys(at)
        if not keys or not self.text.startswith("=", at):
            return None
        at = self.skip(_SPACE, at + 1)
        return self.value(at, self.follow(keys, depth, at))

    def value(self, at: int, depth: int) -> int | None:
        """A value with all that it contains; the place behind it, None if it never ends."""
        text = self.text
        frames: list[_Frame] = []
        while True:
            if text.startswith(("[", "{"), at):
                frames.append(_Frame(text[at] == "[", depth))
                at += 1
            else:
                at = self.skip(_SCALAR, at)
            # on to the next value inside what is open, or out
            while frames:
                at = self.skip(_GAP, at)
                frame = frames[-1]
                if at >= len(text):
                    return None
                if text[at] == ",":
                    frame.index += 1
                    at += 1
                elif text[at] in "]}":
                    frames.pop()
                    at += 1
                elif frame.array:
                    inside = self.wants(frame.depth, frame.index)
                    depth = frame.depth + 1 if inside else -1
                    self.note(depth, at, at, True)
                    break
                else:
                    keys, at = self.keys(at)
                    if not keys or not text.startswith("=", at):
                        return None
                    at = self.skip(_GAP, at + 1)
                    depth = self.follow(keys, frame.depth, at)
                    break
            else:
                return at


def _plain(word: str) -> str:
    """A key without its quotes and escapes."""
    if word[0] == "'":
        return word[1:-1]
    if word[0] != '"':
        return word
    if "\\" not in word:
        return word[1:-1]
    try:
        return str(tomllib.loads(f"key = {word}")["key"])
    except tomllib.TOMLDecodeError:
        return word[1:-1]
