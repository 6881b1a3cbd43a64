"""Model files: TOML (or JSON) text <-> document; problems are shown with their line and a caret."""

from __future__ import annotations

import json
import os
import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rattle.atomic_file import atomic, is_special
from rattle.description.changes import Change, item, plain, put
from rattle.description.reading import Table
from rattle.errors import InputError, ModelError, Problem, WrongType

SUFFIXES = (".toml", ".json")
LARGEST = 8_000_000  # bytes; a chain of 10,000 links has about 2 MB
MOST_ENTRIES = 200_000  # a chain of 10,000 links has about 80,000
DEEPEST_KEY = 12  # parts of a dotted key, at most; no table of a model is nested so deep
_LONG_TEXT = re.compile(  # no possessive repeats of groups with lookahead: Python 3.11.0 to 3.11.4 match them wrongly
    r'"""[^"\\]*+(?:(?:\\.|"(?!""))[^"\\]*+)*"""' r"|'''[^']*+(?:'(?!'')[^']*+)*'''", re.DOTALL
)
_TEXT = re.compile(r'"(?:[^"\\]|\\.)*+"|\'[^\']*+\'')
_DOT = re.compile(r"[\w-][ \t]*+\.(?=[ \t]*+[\w-])")
_NO_KEY = re.compile(r"[^\w.\- \t]+")


def read_bytes(path: str | os.PathLike[str]) -> tuple[bytes, str]:
    """Content and name of a file that holds a mechanism.

    Raises ModelError if the file is missing or too large, and TypeError if `path` is not a path.
    """
    if not isinstance(path, str | os.PathLike):
        raise WrongType(f"expected the name of a model file, got {path!r:.60}")
    name = str(path)
    try:
        with Path(path).open("rb") as file:
            content = file.read(LARGEST + 1)  # a device or pipe may never end
            size = max(os.fstat(file.fileno()).st_size, len(content))
    except OSError as error:
        problem = Problem((), f"cannot read the file: {error.strerror or error}")
        raise ModelError([problem], name) from None
    except ValueError as error:
        raise ModelError([Problem((), f"not a file name: {error}")], name) from None
    if len(content) > LARGEST:
        raise ModelError([Problem((), _too_large("file", size))], name)
    return content, name


def read_file(path: str | os.PathLike[str]) -> tuple[str, str]:
    """Text and name of a model file.

    Raises ModelError if the file is missing, too large or not UTF-8, and TypeError if `path` is not a path.
    """
    content, name = read_bytes(path)
    try:
        return content.decode("utf-8"), name
    except UnicodeDecodeError as error:
        if content.startswith((b"\x89HDF", b"PK")):
            problem = Problem((), "this is a result, not a model file; `rattle plot` and `rattle animate` show it")
            raise ModelError([problem], name) from None
        problem = Problem((), f"not UTF-8 text (byte {error.start}); save the file as UTF-8")
        problem.line = content[: error.start].count(b"\n") + 1
        raise ModelError([problem], name) from None


def _too_large(what: str, size: int) -> str:
    return f"the {what} has {size / 1e6:.0f} MB; a model has at most {LARGEST / 1e6:.0f} MB. Is it the right {what}?"


def parse(text: str, file: str = "") -> dict[str, Any]:
    """Model text -> document: JSON if the text starts with a brace, TOML otherwise.

    Raises ModelError with line and caret if the text is neither, and TypeError if it is not a str.
    """
    if not isinstance(text, str):
        raise WrongType(f"expected the text of a model, got {text!r:.60}")
    if len(text) > LARGEST:
        raise ModelError([Problem((), _too_large("text", len(text)))], file)
    try:
        _require_moderate(text, file)
        if is_json(text):
            return dict(json.loads(text.lstrip("\ufeff"), object_pairs_hook=_without_repetition))
        _require_shallow(text, file)
        return tomllib.loads(text.removeprefix("\ufeff"))
    except json.JSONDecodeError as error:
        problem = _at(text, error.lineno, error.colno, f"not valid JSON: {error.msg}")
    except tomllib.TOMLDecodeError as error:
        problem = _not_toml(text, str(error))
    except RecursionError:
        problem = Problem((), "nested too deeply")
    except ModelError as error:
        (problem,) = error.problems
    except ValueError as error:  # a number of thousands of digits
        problem = Problem((), f"cannot read the text: {str(error).split(';')[0]}")
    raise ModelError([problem], file)


def _require_moderate(text: str, file: str) -> None:
    """Refuse texts with so many entries that their tables would fill the memory."""
    entries = text.count(":") if is_json(text) else text.count("=")
    if not is_json(text) and "\n[" in text:
        entries += sum(line.count(".") + 1 for line in text.split("\n") if line.startswith("["))
    if entries > MOST_ENTRIES:
        fault = f"the text has {entries} entries; a model has at most {MOST_ENTRIES}. Is it the right text?"
        raise ModelError([Problem((), fault)], file)


def _require_shallow(text: str, file: str) -> None:
    """Refuse dotted keys with very many parts: the time of `tomllib` grows with the square of their number."""
    if all(line.count(".") < DEEPEST_KEY for line in text.split("\n")):
        return
    for n, line in enumerate(_LONG_TEXT.sub(lambda match: "\n" * match[0].count("\n"), text).split("\n")):
        if line.count(".") >= DEEPEST_KEY:
            bare = _TEXT.sub("q", line).partition("#")[0]
            if any(len(_DOT.findall(part)) >= DEEPEST_KEY for part in _NO_KEY.split(bare)):
                raise ModelError([_at(text, n + 1, 1, f"a key of more than {DEEPEST_KEY} parts")], file)


def is_json(text: str) -> bool:
    """True for text that starts with a brace, which TOML never does."""
    return text.lstrip("\ufeff \t\r\n").startswith("{")


def _without_repetition(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table: dict[str, Any] = {}
    for key, value in pairs:
        if key in table:
            raise ModelError([Problem((key,), f"the name '{key}' is used twice")])
        table[key] = value
    return table


def _not_toml(text: str, message: str) -> Problem:
    """The error message of `tomllib`, in words for someone who writes mechanisms."""
    match = re.search(r"line (\d+), column (\d+)", message)
    lines = text.split("\n")
    line, column = (int(match[1]), int(match[2])) if match else (len(lines), len(lines[-1]) + 1)
    what = message.split(" (at ")[0]
    if what.startswith(("Cannot overwrite", "Cannot declare", "Cannot mutate", "Duplicate inline table key")):
        source = lines[min(line, len(lines)) - 1]
        column = len(source) - len(source.lstrip()) + 1
        return _at(text, line, column, f"a name is used twice: '{source.strip()[:60]}' is already defined")
    if what.startswith(("Invalid value", "Expected newline")):
        what += '; write a quantity or expression in quotes: "5 mm"'
    return _at(text, line, column, f"not valid TOML: {what}")


def _at(text: str, line: int, column: int, message: str) -> Problem:
    from rattle.description.toml_locations import caret

    problem = Problem((), message)
    problem.line = line
    problem.caret = caret(text, line, column)
    return problem


def point_out(error: ModelError, text: str) -> ModelError:
    """The same error with line and caret added to each problem, in the order of the file."""
    from rattle.description.toml_locations import caret_under, locate_all

    if is_json(text):
        return error
    places = locate_all(text, [(problem.path, problem.at_key) for problem in error.problems])
    lines = text.split("\n")
    for problem, place in zip(error.problems, places, strict=True):
        if place is None:
            continue
        line, column = place
        problem.line = line
        if problem.column is not None:
            column += _inside(lines[line - 1], column, problem.column)
        width = len(str(problem.path[-1])) if problem.at_key else 1
        problem.caret = caret_under(lines[line - 1], column, width)
    return ModelError(sorted(error.problems, key=lambda problem: problem.line or 0), error.file)


def _inside(source: str, column: int, spot: int) -> int:
    """Offset of character `spot` of a quoted one-line text from the start of that text, in source characters."""
    quote = source[column - 1 : column]
    inner = source[column : column + spot]
    plain = quote in ('"', "'") and source[column : column + 2] != 2 * quote and "\\" not in inner
    return spot + 1 if plain else 0


# ---------------------------------------------------------------- writing
def dump(document: Table, text: str | None, changes: Sequence[Change]) -> str:
    """TOML text of a model: the original text with the changes made and comments kept, or written from the document."""
    import tomlkit

    if text is None or is_json(text):
        written = tomlkit.document()
        for key, value in document.items():
            written[key] = item(value)
        return tomlkit.dumps(written)
    kept = tomlkit.parse(text)
    for path, value in changes:
        put(kept, path, value)
    return with_line_ends_of(text, tomlkit.dumps(kept))


def with_line_ends_of(text: str, renewed: str) -> str:
    """A renewed text with the line ends of the text before, where those are CR LF throughout."""
    ends = text.count("\r\n")
    return re.sub(r"\r?\n", "\r\n", renewed) if ends and ends == text.count("\n") else renewed


def dump_json(document: Table, text: str = "") -> str:
    """JSON text of a model, indented as this text is."""
    step = re.search(r"[{[]\r?\n([ \t]+)", text)
    return json.dumps(plain(document), indent=step[1] if step else 2, ensure_ascii=False) + "\n"


def wants_json(path: str | os.PathLike[str]) -> bool:
    """True for a name ending in .json, False for .toml and what is no plain file.  Raises InputError for any other."""
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES and not is_special(path) and not Path(path).is_dir():
        raise InputError(f"{os.fspath(path)}: a model is saved as TOML or JSON; give a name ending in .toml or .json")
    return suffix == ".json"


def save(path: str | os.PathLike[str], text: str) -> None:
    """Write a model file, completely or not at all.  Raises an OSError that names the file."""
    with atomic(path) as file:
        file.write_text(text, encoding="utf-8")
