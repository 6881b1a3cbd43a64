"""Exceptions that say what is wrong, where, and what to do about it."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice
from typing import Any

MOST = 50  # problems reported together, at most; more would not be read, and cost time with a broken file of megabytes
LONGEST = 80  # characters of a name that a message quotes
CANDIDATES = 1000  # names that a misspelt one is compared with
LISTED = 16  # known names, at most, that a message lists: all kinds of joints
ALIKE = 0.6  # share of letters in common from which on a name is a suggestion


def shown(text: str) -> str:
    """The text made safe for a terminal: control characters (escape sequences, text direction) are spelled out."""
    return "".join(c if c.isprintable() or c in "\n\t" else c.encode("unicode_escape").decode() for c in text)


def suggest(word: str, names: Iterable[str]) -> str:
    """ "; did you mean 'x'?" when a known name is close to `word`, otherwise all known names if at most LISTED."""
    import difflib

    options = list(islice(names, CANDIDATES))
    close = difflib.get_close_matches(word[:LONGEST], [name for name in options if len(name) <= 2 * LONGEST], 3, ALIKE)
    if close:
        return "; did you mean " + " or ".join(f"'{_short(name)}'" for name in close) + "?"
    return "; known: " + ", ".join(map(_short, options)) if 0 < len(options) <= LISTED else ""


def _short(name: str) -> str:
    return shown(name if len(name) <= LONGEST else name[: LONGEST - 3] + "...").replace("\n", "\\n")


class Problem:
    """One fault in a model: where it is (path, line) and what is wrong.

    at_key: the key is wrong, not its value.  column: the character of a text value at fault, counted from 0.
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
        """The path in dotted form, as in "joints.O3.clearance"."""
        text = ""
        for part in self.path:
            text += f"[{part}]" if isinstance(part, int) else ("." if text else "") + _short(str(part))
        return text

    def __str__(self) -> str:
        return f"{self.key}: {self.message}" if self.path else self.message


class InputError(ValueError):
    """What was asked for, or the model, cannot be used; the message says where, what is wrong and what is wanted."""


class WrongType(InputError, TypeError):
    """A value of another kind than is wanted, such as a list in place of a name."""


class ModelError(InputError):
    """The model cannot be used; `.problems` lists every fault found (at most the first 50)."""

    def __init__(self, problems: list[Problem], file: str = "") -> None:
        self.problems = problems
        self.file = file
        lines = []
        for problem in problems:
            where = f"{file or 'model'}:{problem.line}: " if problem.line else (f"{file}: " if file else "")
            lines.append(where + str(problem) + (f"\n{problem.caret}" if problem.caret else ""))
        if len(problems) >= MOST:
            lines.append(f"these are the first {MOST} problems; there may be more")
        super().__init__("\n".join(lines))

    def __reduce__(self) -> tuple[Any, ...]:  # pickle would pass the message text, which is not what __init__ takes
        return type(self), (self.problems, self.file)


class MissingPackage(ImportError):
    """A requested feature needs a Python package that is not installed; the message names it."""


class MissingProgram(RuntimeError):
    """A requested feature needs a program that is not installed; the message names it."""


class WorkerError(RuntimeError):
    """Processes that run samples could not do it; the message says why, and what is kept."""


class AssemblyError(InputError, RuntimeError):
    """The mechanism cannot be assembled, or cannot take the position asked for."""


class TraceError(RuntimeError):
    """A calculation cannot be written as straight-line code; the message says what stands in the way."""


class SolverError(RuntimeError):
    """A run stopped early: raised with `strict=True`, and where nothing can be shown of it.

    `.result` holds what was computed until then.
    """

    def __init__(self, message: str, result: Any) -> None:
        super().__init__(message)
        self.result = result

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (str(self), self.result)


# what tells the user what is wrong; any other exception is a fault of rattle and keeps its traceback
ANSWERS = (InputError, SolverError, TraceError, WorkerError, MissingPackage, MissingProgram, OSError)
