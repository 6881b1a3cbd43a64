"""How a reader of another program's file refuses it: one line with the file, the place in it and what is wrong."""

from __future__ import annotations

import math

from rattle.errors import ModelError, Problem, shown

LONGEST = 60  # characters of the file's own text that a message quotes
LONGEST_MESSAGE = 300  # characters: names in it may be very long
LARGEST = 1e30  # of a number that a file may hold: beyond, products of a few leave the range of numbers


def refused(file: str, message: str, line: int | None = None, path: tuple[str | int, ...] = ()) -> ModelError:
    """The error to raise; path: of the place, in a file whose places have names."""
    words = " ".join(message[: 4 * LONGEST_MESSAGE].split())
    problem = Problem(path, words if len(words) <= LONGEST_MESSAGE else words[: LONGEST_MESSAGE - 3] + "...")
    problem.line = line
    return ModelError([problem], file)


def in_one_line(error: ModelError, file: str) -> ModelError:
    """The same error without the lines of a text that the user did not write: its first problem, how many there are."""
    first, more = error.problems[0], len(error.problems) - 1
    return refused(file, f"{first.message}{f' (and {more} more)' if more else ''}", first.line, first.path)


def quoted(text: str) -> str:
    """A part of the file for a message, cut to a readable length."""
    short = text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."
    return f"'{shown(' '.join(short.split()))}'"


def number_of(text: str) -> float | None:
    """A number as programs write it; None for what is none, is not finite, or is out of all range."""
    try:
        number = float(text) if "_" not in text else math.nan
    except ValueError:
        return None
    return number if abs(number) <= LARGEST else None
