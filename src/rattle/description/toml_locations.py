"""Positions of values in a TOML text, for error messages that show the line.

It has its own scanner because `tomllib` keeps no positions and a parser that does (tomlkit) takes seconds
instead of milliseconds.  One pass, no recursion; the text is assumed to be valid TOML, and the scan
stops at the first place where it is not.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass

WIDTH = 120  # characters of a source line that are shown, at most

_SPACE = re.compile(r"[ \t]*+")
_GAP = re.compile(r"(?:[ \t\r\n]++|#[^\n]*+)*+")
_KEY = re.compile(r""""[^"\\\n]*+(?:\\.[^"\\\n]*+)*+"|'[^'\n]*+'|[^\s.=\[\]{}"'#,]++""")
_SCALAR = re.compile(  # no possessive repeats of groups with lookahead: Python 3.11.0 to 3.11.4 match them wrongly
    r'"""[^"\\]*+(?:(?:\\.|"(?!""))[^"\\]*+)*"{3,5}+'
    r"|'''[^']*+(?:'(?!'')[^']*+)*'{3,5}+"
    r'|"[^"\\\n]*+(?:\\.[^"\\\n]*+)*+"'
    r"|'[^'\n]*+'"
    r"|[^,\]}#\r\n]++",
    re.DOTALL,
)


def locate(text: str, path: tuple[str | int, ...], key: bool = False) -> tuple[int, int] | None:
    """Line and column (both from 1) of the value at a key path in a valid TOML text.

    path: keys, and indices of arrays, e.g. ("initial", "O3", "offset", 0).  The position of a table is that of its
    header.  key: return the position of the key instead of its value (array elements have no key).
    If there is no such value: the nearest parent that exists; None if there is none, or for an empty path.
    """
    return locate_all(text, [(path, key)])[0]


def locate_all(text: str, wanted: Sequence[tuple[tuple[str | int, ...], bool]]) -> list[tuple[int, int] | None]:
    """`locate` for many pairs (path, key), in one pass through the text."""
    top = _Place()
    for path, _ in wanted:
        place = top
        for part in path:
            place = place.parts.setdefault(part, _Place())
        place.wanted = bool(path)
    _Scanner(text, top).run()
    places: list[tuple[int, int] | None] = []
    for path, key in wanted:
        best, place = None, top
        for part in path:
            place = place.parts[part]
            best = place if place.seen else best
        if best is None:
            places.append(None)
            continue
        at = best.key_at if key else best.value_at
        places.append((text.count("\n", 0, at) + 1, at - text.rfind("\n", 0, at)))
    return places


def caret(text: str, line: int, column: int, width: int = 1) -> str:
    """The source line and, below it, a caret under each of `width` characters from `column` (counted from 1).

    Of a very long line only the part around the column is shown; "" if there is no such line.
    """
    start = 0
    for _ in range(line - 1):
        start = text.find("\n", start) + 1
        if start == 0:
            return ""
    end = text.find("\n", start)
    return caret_under(text[start : len(text) if end < 0 else end], column, width)


def caret_under(source: str, column: int, width: int = 1) -> str:
    """`caret` for one line of source."""
    source = source.rstrip("\r")
    column = min(max(column, 1), len(source) + 1)
    begin = column - WIDTH // 2 if column > WIDTH - 20 else 0
    shown = source[begin : begin + WIDTH]
    left, right = "..." * (begin > 0), "..." * (begin + WIDTH < len(source))
    shown = "".join(c if c.isprintable() or c == "\t" else "?" for c in shown)
    indent = "".join("\t" if c == "\t" else " " for c in left + shown[: column - 1 - begin])
    width = max(1, min(width, len(shown) - (column - 1 - begin)))
    return f"{left}{shown}{right}\n{indent}{'^' * width}"


class _Place:
    """One node of the tree of paths to be located, with its position in the text.

    The best position is kept: a definition rather than a mention ("[a.b]" defines a.b and mentions a), and of several
    definitions the first.
    """

    __slots__ = ("exact", "key_at", "last", "parts", "seen", "value_at", "wanted")

    def __init__(self) -> None:
        self.parts: dict[str | int, _Place] = {}
        self.wanted = self.seen = self.exact = False
        self.key_at = self.value_at = 0
        self.last: int | None = None  # of an array of tables: its last index


@dataclass(slots=True)
class _Frame:
    """An open array or inline table: its place, if one of the paths passes through it, and the current index."""

    array: bool
    place: _Place | None
    index: int = 0


def _count(top: _Place) -> int:
    """Number of places below `top` that are ends of paths."""
    count, ahead = 0, [top]
    while ahead:
        place = ahead.pop()
        count += place.wanted
        ahead += place.parts.values()
    return count


class _Scanner:
    """Follows all paths through the text; a place is None where none of them passes."""

    def __init__(self, text: str, top: _Place) -> None:
        self.text = text
        self.top = top
        self.missing = _count(top)  # ends of paths whose definition was not found yet

    def run(self) -> None:
        text = self.text
        here: _Place | None = self.top
        at: int | None = 1 if text.startswith("\ufeff") else 0
        while at is not None:
            at = self.skip(_GAP, at)
            if at >= len(text) or not self.missing:
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

    # -------------------------------------------------- follow the paths
    def note(self, place: _Place, key_at: int, value_at: int, exact: bool) -> None:
        if not place.seen or (exact and not place.exact):
            place.seen, place.exact, place.key_at, place.value_at = True, exact, key_at, value_at
            self.missing -= place.wanted and exact

    def header(self, keys: list[tuple[str, int]], many: bool) -> _Place | None:
        """Place of the table that a [header] or [[header]] opens."""
        place: _Place | None = self.top
        for n, (key, at) in enumerate(keys):
            last = n == len(keys) - 1
            place = place.parts.get(key) if place is not None else None
            if place is None:
                return None
            self.note(place, at, at, last and not many)
            if last and many:
                place.last = 0 if place.last is None else place.last + 1
            if place.last is not None:
                place = place.parts.get(place.last)
                if place is None:
                    return None
                self.note(place, at, at, last)
        return place

    def follow(self, keys: list[tuple[str, int]], place: _Place | None, value_at: int) -> _Place | None:
        """Place of the value of a (dotted) key in a table."""
        for n, (key, at) in enumerate(keys):
            place = place.parts.get(key) if place is not None else None
            if place is None:
                return None
            last = n == len(keys) - 1
            self.note(place, at, value_at if last else at, last)
        return place

    # -------------------------------------------------- read the text
    def skip(self, pattern: re.Pattern[str], at: int) -> int:
        match = pattern.match(self.text, at)
        return match.end() if match else at

    def keys(self, at: int) -> tuple[list[tuple[str, int]], int]:
        """A dotted key: its parts with their positions, and where it ends."""
        parts: list[tuple[str, int]] = []
        while True:
            at = self.skip(_SPACE, at)
            match = _KEY.match(self.text, at)
            if match is None:
                return [], at
            parts.append((_plain(match[0]), at))
            at = self.skip(_SPACE, match.end())
            if not self.text.startswith(".", at):
                return parts, at
            at += 1

    def entry(self, at: int, here: _Place | None) -> int | None:
        """Read one `key = value` in a table; the position after it, None if it is not an entry."""
        keys, at = self.keys(at)
        if not keys or not self.text.startswith("=", at):
            return None
        at = self.skip(_SPACE, at + 1)
        return self.value(at, self.follow(keys, here, at))

    def value(self, at: int, place: _Place | None) -> int | None:
        """Read a value with all that it contains; the position after it, None if it does not end."""
        text = self.text
        frames: list[_Frame] = []
        while True:
            if text.startswith(("[", "{"), at):
                frames.append(_Frame(text[at] == "[", place))
                at += 1
            else:
                at = self.skip(_SCALAR, at)
            # go to the next value in the open array or table, or close it
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
                    place = frame.place.parts.get(frame.index) if frame.place is not None else None
                    if place is not None:
                        self.note(place, at, at, True)
                    break
                else:
                    keys, at = self.keys(at)
                    if not keys or not text.startswith("=", at):
                        return None
                    at = self.skip(_GAP, at + 1)
                    place = self.follow(keys, frame.place, at)
                    break
            else:
                return at


def _plain(word: str) -> str:
    """A key without quotes and escapes."""
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
