"""Model files: TOML (or JSON) text <-> document, with line and caret for every problem."""

from __future__ import annotations

import copy
import json
import os
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rattle.errors import ModelError, Problem
from rattle.files import atomic

LARGEST = 8_000_000  # bytes; a chain of 10,000 links has about 2 MB
Change = tuple[tuple[str, ...], Any]  # path and new value


def read_file(path: str | os.PathLike[str]) -> tuple[str, str]:
    """Text and name of a model file.

    Raises ModelError for a file that is missing, too large or not UTF-8.
    """
    file = Path(path)
    try:
        size = file.stat().st_size
        if file.is_dir():
            raise IsADirectoryError(21, "is a folder, not a file")
        if size > LARGEST:
            problem = f"the file has {size / 1e6:.0f} MB; a model file has at most {LARGEST / 1e6:.0f} MB. Is it the right file?"
            raise ModelError([Problem((), problem)], str(path))
        return file.read_bytes().decode("utf-8"), str(path)
    except UnicodeDecodeError as error:
        line = file.read_bytes()[: error.start].count(b"\n") + 1
        one = Problem((), f"not UTF-8 text (byte {error.start}); save the file as UTF-8")
        one.line = line
        raise ModelError([one], str(path)) from None
    except OSError as error:
        raise ModelError([Problem((), f"cannot read the file: {error.strerror or error}")], str(path)) from None


def parse(text: str, file: str = "") -> dict[str, Any]:
    """Model text -> document. JSON when it starts with a brace, TOML otherwise.

    Raises ModelError with line and caret when the text is neither.
    """
    if len(text) > LARGEST:
        raise ModelError([Problem((), f"the text has {len(text) / 1e6:.0f} MB; at most {LARGEST / 1e6:.0f} MB")], file)
    try:
        if text.lstrip("\ufeff \t\r\n").startswith("{"):
            return dict(json.loads(text.lstrip("\ufeff")))
        return tomllib.loads(text.removeprefix("\ufeff"))
    except json.JSONDecodeError as error:
        problem = _at(text, error.lineno, error.colno, f"not valid JSON: {error.msg}")
    except tomllib.TOMLDecodeError as error:
        line, column = _toml_position(text, str(error))
        problem = _at(text, line, column, f"not valid TOML: {str(error).split(' (at ')[0]}")
    except RecursionError:
        problem = Problem((), "nested too deeply")
    raise ModelError([problem], file)


def _toml_position(text: str, message: str) -> tuple[int, int]:
    import re

    found = re.search(r"line (\d+), column (\d+)", message)
    lines = text.splitlines() or [""]
    return (int(found[1]), int(found[2])) if found else (len(lines), len(lines[-1]) + 1)


def _at(text: str, line: int, column: int, message: str) -> Problem:
    from rattle.positions import caret

    problem = Problem((), message)
    problem.line = line
    problem.caret = caret(text, line, column)
    return problem


def point_out(error: ModelError, text: str) -> ModelError:
    """The same error with the line and a caret for each problem, in the order of the file."""
    from rattle.positions import caret, locate

    if text.lstrip().startswith("{"):
        return error
    for problem in error.problems:
        found = locate(text, problem.path) if problem.path else None
        if found is not None:
            problem.line = found[0]
            problem.caret = caret(text, *found)
    return ModelError(sorted(error.problems, key=lambda one: one.line or 0), error.file)


def with_change(document: Mapping[str, Any], path: Sequence[str], value: Any) -> dict[str, Any]:
    """A copy of a document with one value replaced. Raises KeyError with the part of the path that is missing."""
    changed = copy.deepcopy(dict(document))
    put(changed, path, value)
    return changed


def put(table: Any, path: Sequence[str], value: Any) -> None:
    """Replace one value in nested tables (plain or tomlkit), in place."""
    for n, key in enumerate(path[:-1]):
        if key == "contact" and isinstance(table.get(key), str):
            table[key] = {"model": str(table[key])}
        if key not in table or not isinstance(table[key], Mapping):
            raise KeyError(".".join(path[: n + 1]))
        table = table[key]
    table[path[-1]] = value


def dump(document: Mapping[str, Any], text: str | None, changes: Sequence[Change]) -> str:
    """TOML text of a model: the text it came from with the changes put in, comments kept; or made from the document."""
    import tomlkit

    if text is None or text.lstrip().startswith("{"):
        plain = tomlkit.document()
        for key, value in document.items():
            plain[key] = _table(value)
        return tomlkit.dumps(plain)
    kept = tomlkit.parse(text)
    for path, value in changes:
        put(kept, path, value)
    return tomlkit.dumps(kept)


def _table(value: Any) -> Any:
    """Plain data as tomlkit items; the innermost tables in one line."""
    import tomlkit

    if not isinstance(value, Mapping):
        return list(value) if isinstance(value, tuple) else value
    inner = not any(isinstance(one, Mapping) for one in value.values())
    made = tomlkit.table()
    for key, one in value.items():
        if isinstance(one, Mapping) and not any(isinstance(x, Mapping) for x in one.values()) and not inner and key in ("points", "contact", "block"):
            short = tomlkit.inline_table()
            short.update({k: list(v) if isinstance(v, tuple) else v for k, v in one.items()})
            made[key] = short
        else:
            made[key] = _table(one)
    return made


def save(path: str | os.PathLike[str], text: str) -> None:
    """Write a model file, whole or not at all."""
    with atomic(path) as file:
        file.write_text(text, encoding="utf-8")
