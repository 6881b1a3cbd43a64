"""What goes when something is deleted, and what is called otherwise when it is given another name."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from rattle.description.changes import Path
from rattle.errors import InputError, ModelError
from rattle.sketch.model_text import texts_of
from rattle.sketch.revision import Drawing, Revision

FILES = ("file", "profile")  # names of files: what they say is no name of the model
TABLES = {"body": "bodies", "joint": "joints", "driver": "drivers", "load": "loads", "signal": "signals"}


def delete(revision: Revision, kind: str, name: str) -> Drawing:
    """Delete a body, joint, driver, load or point of the ground, with what cannot be without it.

    Raises InputError where something else still uses it.
    """
    body, _, own = name.partition(".")
    if kind == "point" and own in revision.document.get("bodies", {}).get(body, {}).get("bar", ()):
        raise InputError(f"{name} is an end of the bar {body}, which cannot be without it: delete {body}")
    gone = dict.fromkeys([_path(kind, name)])
    ahead = list(gone)
    while ahead:
        for path in _needs(revision.document, ahead.pop()):
            if path not in gone:
                gone[path] = None
                ahead.append(path)
    for path in gone:
        if path[0] != "initial" or path[1] in revision.document.get("initial", {}):
            revision.enter(path, None)
    for body in [path[1] for path in gone if path[0] == "bodies" and len(path) == 2]:
        revision.places.pop(body, None)
    taken = [_named(path) for path in gone if path[0] != "initial"]
    try:
        more = f", with {', '.join(taken[1:])}" if len(taken) > 1 else ""
        return revision.finish(f"deleted {taken[0]}{more}")
    except ModelError as error:
        raise InputError(f"{name} cannot be deleted, something still uses it: {error.problems[0].message}") from None


def _path(kind: str, name: str) -> Path:
    if kind == "point":
        body, _, own = name.partition(".")
        return ("ground", "points", own) if body == "ground" else ("bodies", body, "points", own)
    return TABLES[kind], name


def _named(path: Path) -> str:
    """The name of an entry: "J1", "ground.O", "arm.P"."""
    return f"ground.{path[2]}" if path[0] == "ground" else f"{path[1]}.{path[3]}" if len(path) == 4 else path[1]


def _needs(document: Mapping[str, Any], path: Path) -> Iterator[Path]:
    """Entries that cannot be without this one."""
    name = _named(path)
    if path[0] in ("bodies", "ground"):
        for table in ("joints", "loads"):
            for entry, value in document.get(table, {}).items():
                if any(_is_at(end, name) for end in _ends(value)):
                    yield table, entry
    for entry, value in document.get("drivers", {}).items():
        if (path[0] == "joints" and value.get("joint") == name) or (path[0] == "bodies" and value.get("body") == name):
            yield "drivers", entry
    if name in document.get("initial", {}):
        yield "initial", name
    for entry, value in document.get("signals", {}).items():
        if isinstance(value, str) and re.search(rf"(?<![\w.]){re.escape(name)}(?![\w])", value):
            yield "signals", entry


def _ends(entry: Mapping[str, Any]) -> list[str]:
    return [str(end) for end in (*entry.get("connect", ()), *filter(None, (entry.get("at"), entry.get("body"))))]


def _is_at(end: str, name: str) -> bool:
    return end == name or end.startswith(f"{name}.")


def rename(revision: Revision, kind: str, old: str, new: str) -> Drawing:
    """Give a body, joint, driver or load another name, wherever the text names it.  Raises InputError."""
    new = new.strip()
    if not re.fullmatch(r"[A-Za-z_]\w*", new, re.ASCII):
        raise InputError(f"'{new}' is not a name: expected letters, digits and _, a letter first")
    table = TABLES[kind]
    taken = next((key for key in TABLES.values() if new in revision.document.get(key, {})), "")
    if taken:
        raise InputError(f"the name '{new}' is already used in [{taken}]; choose another")
    for path, value in texts_of(revision.document):
        whole = path[-1] in ("joint", "body", "at") or path[-2:-1] == ("connect",)
        new_text = new if whole and value == old else re.sub(rf"(?<![\w.]){re.escape(old)}(?=\.[A-Za-z_])", new, value)
        if new_text != value and path[0] not in ("name", "picture") and path[-1] not in FILES:
            revision.enter(path, new_text)
    revision.renaming = table, old, new
    if old in revision.places:
        revision.places[new] = revision.places.pop(old)
    return revision.finish(f"{old} is called {new} now", f"{kind} {new}")
