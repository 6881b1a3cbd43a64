"""Small changes of a model text that leave everything else as it is written: comments, order, spelling of values.

Values are changed where they stand.  New entries go behind the last of their table, apart from it as the file has
them; what is removed takes its own lines along, comments above the next entry stay.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rattle.description import file as model_file
from rattle.description.changes import NAMED, TABLES, Change, Path, bare_key, copied, literal, put
from rattle.description.toml_locations import locate_all
from rattle.errors import InputError

WHOLE = 1e15  # numbers below that have no fraction are written without a point
BY_LINES = ("parameters", "signals", "initial")  # tables whose entries are a line each


class Section(NamedTuple):
    """The lines of a table with a heading, counted from 0; `end` is the line behind its last one."""

    path: Path
    start: int
    end: int


def revised(text: str, changes: Sequence[Change]) -> str:
    """The text with these values changed, entered or removed (None); paths as of `Mechanism.set`.

    Raises ModelError for a text that cannot be read, or a path that leads nowhere.
    """
    document, changes = model_file.parse(text), [(path, tidy(value)) for path, value in changes]
    if not changes:
        return text
    if model_file.is_json(text):
        renewed = copied(document)
        for path, value in changes:
            _put_plain(renewed, path, value)
        return model_file.dump_json(renewed, text)
    before, text = text, text.replace("\r\n", "\n")
    headed = {part.path for part in sections(text)}
    inside = [change for change in changes if not _of_lines(document, change)]
    for path, _ in inside:
        if path in headed:  # a table in a table: its lines go, what stands behind them stays
            text = _without(text, path)
    inside = [(path, value) for path, value in inside if value is not None or path not in headed]
    if inside:
        text = model_file.dump(document, text, inside)
    for path, value in changes:
        if _of_lines(document, (path, value)):
            text = _without(text, path) if value is None else _with_entry(text, path, value)
    return model_file.with_line_ends_of(before, text)


def renamed(text: str, table: str, old: str, new: str) -> str:
    """The text in which an entry of a table has another name, there and in [initial]; what refers to it stays."""
    document = model_file.parse(text)
    if model_file.is_json(text):
        for key in {table, "initial"} & document.keys():
            document[key] = {new if name == old else name: value for name, value in document[key].items()}
        return model_file.dump_json(document, text)
    for path in ((table, old), ("initial", old)):
        while not _is_new(model_file.parse(text), path):  # tables inside of it and dotted keys say the name again
            place = locate_all(text, [(path, True)])[0]
            assert place is not None
            lines, (line, column) = text.split("\n"), place
            after = lines[line - 1][column - 1 :]
            if old not in after:
                raise InputError(f"the text writes {old} with escapes: give it another name there")
            lines[line - 1] = lines[line - 1][: column - 1] + after.replace(old, new, 1)
            text = "\n".join(lines)
    return text


def _put_plain(document: dict[str, Any], path: Path, value: object) -> None:
    if value is None:
        _forget(document, path)
        return
    table: Any = document
    for key in path[:-1] if _is_new(document, path) else ():
        if not isinstance(table, dict):  # from here on there are lists, such as a polygon
            break
        table = table.setdefault(key, {})
    put(document, path, value)


def _forget(document: dict[str, Any], path: Path) -> None:
    table: Any = document
    for key in path[:-1]:
        table = table.get(key, {})
    table.pop(path[-1], None)


def _is_new(document: Mapping[str, Any], path: Path) -> bool:
    """True for an entry of a table with names of the user's, or of the ground, that is not there."""
    entries: Any = document
    for key in path[:-1]:
        entries = entries.get(key, {}) if isinstance(entries, Mapping) else {}
    return path[-1] not in entries


def _of_lines(document: Mapping[str, Any], change: Change) -> bool:
    """True for a change that is made in the lines of the text: a whole entry that comes or goes."""
    path, value = change
    entry = (len(path) == 2 and path[0] in (*NAMED, *BY_LINES)) or (len(path) == 3 and path[:2] == ("ground", "points"))
    return (entry and (value is None or _is_new(document, path))) or path == ("picture",)


# ---------------------------------------------------------------- where things stand
def sections(text: str) -> list[Section]:
    """All tables with a heading of a TOML text, in the order of their lines."""
    document, lines = model_file.parse(text), text.split("\n")
    paths = list(_tables(document))
    found = locate_all(text, [(path, True) for path in paths])
    heads: dict[int, Path] = {}
    for path, place in zip(paths, found, strict=True):
        if place is not None and len(path) > len(heads.get(place[0] - 1, ())):  # a heading mentions the tables above it
            heads[place[0] - 1] = path
    starts = sorted(line for line, path in heads.items() if lines[line].lstrip().startswith("["))
    own = {line: heads[line] for line in starts}
    after = [*starts, len(lines)][1:]
    return [Section(own[line], line, _end(lines, line, behind)) for line, behind in zip(starts, after, strict=False)]


def _tables(value: Any, path: Path = ()) -> Any:
    for key, part in value.items():
        if isinstance(part, Mapping):
            yield (*path, key)
            yield from _tables(part, (*path, key))


def _end(lines: Sequence[str], start: int, after: int) -> int:
    """The line behind the last one of a section: comments right above the next heading belong to that."""
    end = after
    while after < len(lines) and end > start + 1 and lines[end - 1].lstrip().startswith("#"):
        end -= 1
    while end > start + 1 and not lines[end - 1].strip():
        end -= 1
    return end


# ---------------------------------------------------------------- entries that come and go
def _with_entry(text: str, path: Path, value: object) -> str:
    """The text with a new entry: a line of its table, or a table with a heading."""
    if path[0] in BY_LINES or path[0] == "ground":
        home, every = path[:-1], sections(text)
        table = next((part for part in every if part.path == home), None)
        if table is not None:
            return _spliced(text.split("\n"), table.end, _written(path, value)[1:], apart=False)
        document = model_file.parse(text)
        if not _is_new(document, home):  # a table in one line, or with dotted keys
            return model_file.dump(document, text, [(path, value)])
        return _with_block(text, every, home, _written(path, value))
    place = locate_all(text, [(path[:1], False)])[0]
    if place is not None and text.split("\n")[place[0] - 1].startswith("{", place[1] - 1):  # a table in one line
        return model_file.dump(model_file.parse(text), text, [(path, value)])
    return _with_block(text, sections(text), path[:1], _written(path, value))


def _with_block(text: str, every: Sequence[Section], home: Path, block: Sequence[str]) -> str:
    """The text with a table behind the last of its kind, or where the file would have it."""
    lines = text.split("\n")
    same = [part for part in every if part.path[: len(home)] == home]
    before = same or [part for part in every if _order(part.path) <= _order(home)]
    if before:
        apart = len(same) < 2 or not lines[_first_of_last(same) - 1].strip()
        return _spliced(lines, before[-1].end, block, apart)
    head = min((part.start for part in every), default=len(lines))
    while head > 0 and (not lines[head - 1].strip() or (every and lines[head - 1].lstrip().startswith("#"))):
        head -= 1
    return _spliced(lines, head, block, apart=head > 0)


def _first_of_last(same: Sequence[Section]) -> int:
    """The line with which the last entry of these sections begins: tables inside of it come after."""
    last = same[-1].path[:2]
    return next(part.start for part in same if part.path[:2] == last)


def _order(path: Path) -> int:
    return TABLES.index(path[0]) if path[0] in TABLES else len(TABLES)


def _spliced(lines: Sequence[str], at: int, block: Sequence[str], apart: bool) -> str:
    """The lines with a block in front of line `at`; apart: with an empty line before it."""
    more = [*([""] if apart else []), *block]
    after = list(lines[at:]) or [""]
    return "\n".join([*lines[:at], *more, *after])


def _written(path: Path, value: object) -> list[str]:
    """The lines of an entry with its heading."""
    if path == ("picture",):
        assert isinstance(value, Mapping)
        return ["[picture]", *(f"{key} = {literal(part)}" for key, part in value.items())]
    *home, name = path
    if path[0] in BY_LINES or path[0] == "ground":
        return [f"[{'.'.join(home)}]", f"{bare_key(name)} = {literal(value)}"]
    assert isinstance(value, Mapping)
    return [f"[{path[0]}.{bare_key(name)}]", *(f"{bare_key(key)} = {literal(part)}" for key, part in value.items())]


def tidy(value: object) -> object:
    """A value with whole numbers as such: 2 for 2.0."""
    if isinstance(value, Mapping):
        return {key: tidy(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [tidy(part) for part in value]
    return int(value) if isinstance(value, float) and value.is_integer() and abs(value) < WHOLE else value


def _without(text: str, path: Path) -> str:
    """The text without an entry: its lines, or the value where it stands in a table of one line."""
    document = model_file.parse(text)
    if path[0] not in document or _is_new(document, path):
        return text
    lines = text.split("\n")
    own = [part for part in sections(text) if part.path[: len(path)] == path]
    if not any(part.path == path for part in own):
        return _without_value(text, document, path)
    for part in reversed(own):
        start = part.start
        while start > 0 and part.end < len(lines) and not lines[start - 1].strip() and not lines[part.end].strip():
            start -= 1
        del lines[start : part.end]
    return "\n".join(lines)


def _without_value(text: str, document: dict[str, Any], path: Path) -> str:
    """The text without a value; a table that has nothing left goes too."""
    parent: Any = document
    for key in path[:-1]:
        parent = parent[key]
    if len(parent) == 1 and len(path) > 1 and path[0] == "initial":
        return _without(text, path[:-1])
    return model_file.dump(document, text, [(path, None)])


def texts_of(value: Any, path: Path = ()) -> Iterator[tuple[Path, str]]:
    """All texts of a document with their paths."""
    items = value.items() if isinstance(value, Mapping) else enumerate(value) if isinstance(value, list) else ()
    for key, part in items:
        if isinstance(part, str):
            yield (*path, str(key)), part
        else:
            yield from texts_of(part, (*path, str(key)))
