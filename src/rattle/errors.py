"""What can go wrong, as exceptions that say what, where and what to do."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice
from typing import Any

MOST = 50  # problems reported at once; nobody reads more, and a broken file of megabytes stays cheap
LONGEST = 80  # characters of a name that a message quotes
CANDIDATES = 1000  # names that a misspelt one is compared with


def shown(text: str) -> str:
    """A text for a terminal: what would steer it (escape sequences, directions of writing) is written out."""
    return "".join(c if c.isprintable() or c in "\n\t" else c.encode("unicode_escape").decode() for c in text)


def suggest(word: str, known: Iterable[str]) -> str:
    """ "; did you mean 'x'?" when something known is close to `word`, else what there is (if little)."""
    import difflib

    options = list(islice(known, CANDIDATES))
    close = difflib.get_close_matches(word[:LONGEST], [one for one in options if len(one) <= 2 * LONGEST], 3, 0.6)
    if close:
        return "; did you mean " + " or ".join(f"'{_short(one)}'" for one in close) + "?"
    return "; known: " + ", ".join(map(_short, options)) if 0 < len(options) <= 12 else ""


def _short(name: str) -> str:
    return shown(name if len(name) <= LONGEST else name[: LONGEST - 3] + "...").replace("\n", "\\n")


class Problem:
    """One thing wrong in a model: where (path, line) and what.

    at_key: it is the key that is wrong, not its value.  column: the spot in a text value, from 0.
    """

    __slots__ = ("at_key", "caret", "column", "line", "message", "path")

    def __init__(
        self, path: tuple[str | int, ...], message: str, at_key: bool = False, column: int | None = None
    ) -> None:
        self.path = path
        self.message = shown(message)
        self.at_key = at_key
        self.column = column
        self.line: int | None = None
        self.caret = ""

    @property
    def key(self) -> str:
        """The path as the user would write it, "joints.O3.clearance"."""
        text = ""
        for part in self.path:
            text += f"[{part}]" if isinstance(part, int) else ("." if text else "") + _short(str(part))
        return text

    def __str__(self) -> str:
        return f"{self.key}: {self.message}" if self.path else self.message


class ModelError(ValueError):
    """The model cannot be used; `.problems` holds every reason found (the first 50 of very many)."""

    def __init__(self, problems: list[Problem], file: str = "") -> None:
        self.problems = problems
        self.file = file
        lines = []
        for one in problems:
            where = f"{file or 'model'}:{one.line}: " if one.line else (f"{file}: " if file else "")
            lines.append(where + str(one) + (f"\n{one.caret}" if one.caret else ""))
        if len(problems) >= MOST:
            lines.append(f"these are the first {MOST} problems; there may be more")
        super().__init__("\n".join(lines))

    def __reduce__(self) -> tuple[Any, ...]:  # the arguments are not the text, which is what copies are made of
        return type(self), (self.problems, self.file)


class MissingPackage(ImportError):
    """Something that was asked for needs a package that is not installed; the message says which."""


class MissingProgram(RuntimeError):
    """Something that was asked for needs a program that is not installed; the message says which."""


class AssemblyError(RuntimeError):
    """The mechanism cannot be put together, or cannot take the position asked for."""


class SolverError(RuntimeError):
    """A run could not go on (only with `strict=True`); `.result` holds what was computed before."""

    def __init__(self, message: str, result: Any) -> None:
        super().__init__(message)
        self.result = result

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.result)
