"""Changes of a document, plain or as tomlkit keeps it: where a name leads, and putting another value there."""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Mapping, Sequence
from typing import Any

from rattle import registry
from rattle.description.read_play import hidden_names
from rattle.description.reading import Table, section
from rattle.description.tables import MODEL
from rattle.errors import ModelError, Problem, suggest

NAMED = ("bodies", "joints", "drivers", "loads")
TABLES = tuple(MODEL.fields)
ENTRIES = ("parameters", "signals", "states", "tables", *NAMED)  # tables with names that the user has chosen
SINGLE = ("format", "name", "gravity")  # values, not tables
MADE_WHOLE = ("tolerances", "tables", "initial", "simulate")  # tables whose entries a change makes if they are missing
VECTORS = ("gravity", "center")  # [0, 0] unless given
IN_ONE_LINE = ("points", "contact", "stop", "dist")  # and the tables of a joint's kind of play
PLAIN = {str, float, int, bool, type(None)}
_BARE = re.compile(r"[A-Za-z0-9_-]+")
Path = tuple[str, ...]
Change = tuple[Path, object]  # path and new value, None to remove it


def copied(value: object) -> Any:
    """A copy of a document, or of a part of it: as by `copy.deepcopy`, which takes six times as long."""
    if type(value) in PLAIN:
        return value
    if type(value) is dict:
        return {key: copied(part) for key, part in value.items()}
    return [copied(part) for part in value] if type(value) is list else copy.deepcopy(value)


def plain(value: object) -> Any:
    """A value in the types of TOML: 5.0 for a NumPy scalar, a list for an array or tuple."""
    if isinstance(value, Mapping):
        return {key: plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [plain(part) for part in value]
    to_python = getattr(value, "tolist", None)
    return to_python() if callable(to_python) else value


def through_points(name: str, value: object) -> tuple[object, dict[str, dict[str, object]]]:
    """A value of a load in which instants and values at them, `(t, values)`, have become a table of this name.

    Returns the value, and the tables by name; two values, `[(t, fx), fy]`, may each be given so.
    """
    if not isinstance(value, tuple | list) or len(value) != 2:
        return value, {}
    t, y = (plain(entry) for entry in value)
    if isinstance(t, list) and isinstance(y, list) and not any(isinstance(x, list) for x in (*t, *y)):
        return f"{name}(t)", {name: {"x": t, "y": y, "kind": "linear"}}
    pair, tables = list[object](), dict[str, dict[str, object]]()
    for key, half in zip("xy", value, strict=True):
        part, more = through_points(f"{name}_{key}", half)
        pair.append(part)
        tables |= more
    return pair, tables


# ---------------------------------------------------------------- where a name leads
def path_of(name: str, document: Table, remove: bool) -> Path:
    """The path of a parameter's value or of an entry; remove: of what goes, where the name of an entry is enough.

    Raises ModelError for a name that leads nowhere.
    """
    table = section(document, "parameters")
    first, dot, _ = name.partition(".")
    hidden = hidden_names(document)
    of_play = name.removeprefix("parameters.")  # whose name has a dot of its own
    if of_play not in table and of_play in hidden:
        return ("parameters", of_play)
    if name in table:
        whole = remove or not isinstance(table[name], Mapping)
        return ("parameters", name) if whole else ("parameters", name, "value")
    if first in TABLES and (dot or first in document or first in SINGLE):
        return tuple(name.split("."))
    where = [key for key in ENTRIES if first in section(document, key)]
    if remove and not dot and len(where) == 1:
        return where[0], name
    sizes = [size for size in hidden if size.startswith(f"{first}.")]
    raise ModelError([_astray(name, table, where, remove, sizes)])


def _astray(name: str, parameters: Table, where: Sequence[str], remove: bool, sizes: Sequence[str]) -> Problem:
    """The problem of a name that leads nowhere; where: tables that have an entry with its first part; sizes: of its

    fit or bearing.
    """
    first, dot, _ = name.partition(".")
    if where:
        paths = " or ".join(f"'{key}.{name}'" for key in where)
        advice = f"; or name what is to change in it: {where[0]}.{name}.KEY" if not (dot or remove) else ""
        near = suggest(name, sizes)
        advice += near if "did you mean" in near else f"; its play is {' and '.join(sizes)}" if sizes else ""
        return Problem((name,), f"expected the whole path, {paths}{advice}")
    if dot:
        return Problem((name,), f"there is no '{first}' in the model{suggest(first, TABLES)}")
    near = suggest(name, [*parameters, *TABLES])
    near = near if "did you mean" in near else suggest(name, parameters)
    return Problem((), f"no parameter '{name}', and not a path like joints.O3.clearance{near}")


# ---------------------------------------------------------------- putting a value there
def put(document: Any, path: Sequence[str], value: object) -> None:
    """Replace one value in nested tables (plain or tomlkit), in place; None removes it.

    Tables inside of an entry, such as the stop of a joint, are made if they are missing.  Raises ModelError if the path
    does not exist.
    """
    table = document
    for n in range(len(path) - 1):
        table = _inside(table, path, n, value is not None)
    last = path[-1]
    if isinstance(table, list):
        at = _index(table, path, len(path) - 1)
        if value is None:
            del table[at]
        else:
            table[at] = plain(value)
    elif value is not None:
        _enter(table, last, value, short=len(path) > 2 or (len(path) == 2 and path[0] not in NAMED))
    elif last in table:
        del table[last]
    else:
        raise ModelError([Problem(tuple(path), f"there is no '{'.'.join(path)}' in the model{suggest(last, table)}")])


def _inside(table: Any, path: Sequence[str], n: int, make: bool) -> Any:
    """What the first n + 1 parts of a path lead to, `table` being what n lead to; make: it may be missing."""
    if isinstance(table, list):
        inner = table[_index(table, path, n)]
        if isinstance(inner, Mapping | list):
            return inner
        here = ".".join(path[: n + 1])
        raise ModelError([Problem(tuple(path), f"there is no '{'.'.join(path)}' in the model; {here} is not a table")])
    key = path[n]
    if make:
        _widen(table, path, n)
    if not isinstance(table.get(key), Mapping | list):
        there = suggest(key, table) if key not in table else "; it is not a table"
        raise ModelError([Problem(tuple(path), f"there is no '{'.'.join(path[: n + 1])}' in the model{there}")])
    return table[key]


def _widen(table: Any, path: Sequence[str], n: int) -> None:
    """Make a table where a path goes on: of nothing, or of a value that stands for a table."""
    key, present = path[n], table.get(path[n])
    if present is None:
        if key in VECTORS and path[n + 1].isdigit():
            table[key] = [0, 0]
        elif n == 0 and key not in SINGLE:
            _section(table, key)
        elif n > 1 or (n == 1 and path[0] in MADE_WHOLE):  # an entry that is missing is misspelt
            _enter(table, key, {}, short=True)
    elif isinstance(present, Mapping | list):
        return
    elif key == "contact" and isinstance(present, str):
        _enter(table, key, {"model": _bare(present)}, short=True)
    elif key == "friction":
        _enter(table, key, {"model": "coulomb", "mu": _bare(present)}, short=True)
    elif n == 1 and path[0] == "parameters":
        _enter(table, key, {"value": _bare(present)}, short=True)


def _bare(value: object) -> Any:
    """A value without the comment that tomlkit keeps with it."""
    unwrap = getattr(value, "unwrap", None)
    return unwrap() if callable(unwrap) else value


def _index(table: list[object], path: Sequence[str], n: int) -> int:
    if not path[n].isdigit() or int(path[n]) >= len(table):
        fault = f"expected an index from 0 to {len(table) - 1}, got '{path[n]}'"
        raise ModelError([Problem(tuple(path), fault)])
    return int(path[n])


# ---------------------------------------------------------------- plain or tomlkit
def _enter(table: Any, key: str, value: object, short: bool) -> None:
    """table[key] = value; in tomlkit, tables are written in one line if `short`, and in tables of one line."""
    if type(table) is dict:
        table[key] = plain(value)
        return
    from tomlkit.items import InlineTable

    if isinstance(table, InlineTable):
        _enter_in_line(table, key, value)
    else:
        table[key] = item(value, short)


def _enter_in_line(table: Any, key: str, value: object) -> None:
    """An entry of a table of one line, with the blanks about it that such a table has."""
    import tomlkit
    from tomlkit.items import Whitespace

    entry, body, last = tomlkit.item(item(value, short=True)), table.value.body, None
    if key in table:
        table[key] = entry
        return
    while body and isinstance(body[-1][1], Whitespace):
        last = body.pop()
    entry.trivia.indent = " "
    table[key] = entry
    if last is not None or len(table) == 1:
        body.append(last or (None, Whitespace(" ")))


def _section(table: Any, key: str) -> None:
    """An empty table of a document."""
    if type(table) is dict:
        table[key] = {}
    else:
        import tomlkit

        table[key] = tomlkit.table(is_super_table=key in NAMED)  # their entries have headings of their own


def item(value: object, short: bool = False) -> Any:
    """Plain data as tomlkit items; if `short`, tables are written in one line."""
    import tomlkit

    if not isinstance(value, Mapping):
        return plain(value)
    if short:
        return tomlkit.value(literal(plain(value)))
    table = tomlkit.table()
    for key, part in value.items():
        table[key] = item(part, key in _in_one_line())
    return table


def literal(value: object) -> str:
    """A plain value as it is written in one line of TOML."""
    if isinstance(value, Mapping):
        inside = ", ".join(f"{bare_key(str(key))} = {literal(part)}" for key, part in value.items())
        return f"{{ {inside} }}" if inside else "{}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(literal, value))}]"
    if isinstance(value, bool):
        return "true" if value else "false"
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f") if isinstance(value, str) else repr(value)


def bare_key(name: str) -> str:
    """A key as it is written, in quotes where it needs them."""
    return name if _BARE.fullmatch(name) else json.dumps(name, ensure_ascii=False)


def _in_one_line() -> set[str]:
    return {*IN_ONE_LINE, *(table for play in registry.kinds("clearance").values() for table in play.leaf.dimensions)}
