"""Names in Python, from docstrings: what `import rattle` offers, and what its analyses return.

Docstrings are plain text; this module turns them into reStructuredText, and the comments after the fields of a
dataclass or named tuple into a list.
"""

from __future__ import annotations

import ast
import inspect
import re
from functools import cache
from pathlib import Path
from typing import Any

import rattle as rt
from making.text import field, markdown, restructured
from making.tree import Source, definition, source_of, sources, trailing_comments

HOLDERS = ("Mechanism", "Result", "Film")  # what they return is documented too
NAMED = {"fit": "rattle.catalogue.fits.Fit", "oil": "rattle.catalogue.oils.Oil"}  # functions, and what they return
MADE_BY_USERS = ("Mechanism", "Film")  # the classes whose signature matters to a reader


def pages(folder: Path) -> dict[str, str]:
    """All public names, then the classes of what analyses return."""
    public = {name: getattr(rt, name) for name in rt.__all__}
    functions = [name for name, one in public.items() if inspect.isfunction(one)]
    laws = [name for name in functions if name.endswith("_law")]
    errors = [name for name, one in public.items() if isinstance(one, type) and issubclass(one, Exception)]
    classes = [name for name in public if name not in {*functions, *errors, *HOLDERS}]
    elsewhere = {*laws, "load_result", *NAMED}
    parts = ["## Mechanisms", *(_function(name) for name in functions if name not in elsewhere)]
    parts += [_class("rattle.Mechanism"), "## Results", _function("load_result"), _class("rattle.Result")]
    parts += [_class(f"rattle.{name}") for name in classes]
    parts += ["## Oil films", _class("rattle.Film"), "## Named data"]
    for name, answer in NAMED.items():
        parts += [_function(name), _class(answer)]
    parts += [
        "## What analyses return",
        *(_class(f"{source.name}.{name}") for name, source in returned(public).items()),
    ]
    parts += ["## Functions behind the methods", *behind()]
    parts += ["## Laws of your own", *(_function(name) for name in laws)]
    parts += ["## Exceptions", *(_class(f"rattle.{name}") for name in errors)]
    return {"interface": "\n\n".join(parts) + "\n"}


def _function(name: str) -> str:
    return f"```{{eval-rst}}\n.. autofunction:: rattle.{name}\n```"


def _class(path: str) -> str:
    return f"```{{eval-rst}}\n.. autoclass:: {path}\n   :members:\n   :inherited-members: Exception, tuple, list\n```"


def returned(public: dict[str, Any]) -> dict[str, Source]:
    """Classes of the package that methods of the holders take or return, with the module of each."""
    found: dict[str, Source] = {}
    for holder in HOLDERS:
        home = source_of(holder)
        ours = _imported(home)
        for node in ast.walk(definition(home, holder)):
            if not isinstance(node, ast.FunctionDef) or node.name.startswith("_") or _cached(node):
                continue
            hints = [node.returns, *(one.annotation for one in (*node.args.args, *node.args.kwonlyargs))]
            for name in (one.id for hint in hints if hint for one in ast.walk(hint) if isinstance(one, ast.Name)):
                if name in ours and name not in public and isinstance(_class_in(ours[name], name), ast.ClassDef):
                    found.setdefault(name, ours[name])
    return found


def behind() -> list[str]:
    """Functions and modules that docstrings of the holders refer to."""
    found: dict[str, str] = {}
    for holder in HOLDERS:
        text = source_of(holder).path.read_text(encoding="utf-8")
        for name in re.findall(r"see `(rattle\.[\w.]+)`", text):
            home, _, function = name.rpartition(".")
            if name in sources():
                found[name] = f"**{name}**\n\n{markdown(sources()[name].text)}"
            elif home in sources() and function in sources()[home].names:
                found[name] = f"```{{eval-rst}}\n.. autofunction:: {name}\n```"
            else:
                raise LookupError(f"{holder} refers to {name}, which does not exist")
    return list(found.values())


def _imported(source: Source) -> dict[str, Source]:
    """Names that a module imports from others of the package."""
    lines = [node for node in ast.walk(source.tree) if isinstance(node, ast.ImportFrom) and node.module in sources()]
    return {name.asname or name.name: sources()[str(one.module)] for one in lines for name in one.names}


def _cached(node: ast.FunctionDef) -> bool:
    """True for a cached property, which the package itself uses and a reader does not need."""
    return any(isinstance(one, ast.Name) and one.id == "cached_property" for one in node.decorator_list)


def _class_in(source: Source, name: str) -> ast.AST | None:
    return definition(source, name) if name in source.names else None


# ---------------------------------------------------------------- called by Sphinx while it reads docstrings
def read_docstring(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Plain text to reStructuredText."""
    target = thing.fget if isinstance(thing, property) else thing
    parameters = _parameters(target)
    made = restructured("\n".join(lines), parameters)
    if what in ("class", "exception") and isinstance(thing, type):
        made += ["", *field("Fields", (f"- **{key}**: {said}" for key, said in fields(thing).items()))]
    lines[:] = made


def _parameters(thing: Any) -> list[str]:
    try:
        return [name for name in inspect.signature(thing).parameters if name != "self"]
    except (TypeError, ValueError):
        return []


@cache
def fields(cls: type) -> dict[str, str]:
    """Annotated fields of a class and the comments after them."""
    source = sources().get(cls.__module__)
    node = _class_in(source, cls.__name__) if source else None
    if source is None or not isinstance(node, ast.ClassDef):
        return {}
    found = {}
    for one in node.body:
        if isinstance(one, ast.AnnAssign) and isinstance(one.target, ast.Name) and not one.target.id.startswith("_"):
            comments = trailing_comments(source, one.lineno, one.end_lineno or one.lineno)
            meaning = " ".join(restructured(" ".join(comments.values()))).strip()
            found[one.target.id] = f"``{ast.unparse(one.annotation)}`` {meaning}".strip()
    return found


def shorten_signature(app: Any, what: str, name: str, thing: Any, options: Any, given: str, back: str) -> Any:
    """Show classes that only the package instantiates without the signature of their constructor."""
    if given is not None and what in ("class", "exception") and thing.__name__ not in MADE_BY_USERS:
        return "", None
    return None


def skip_member(app: Any, what: str, name: str, thing: Any, skip: bool, options: Any) -> bool | None:
    """Leave out fields, which are in the list of the class already."""
    owner = getattr(thing, "__objclass__", None)
    if isinstance(owner, type) and name in fields(owner):
        return True
    return True if type(thing).__name__ in ("_tuplegetter", "member_descriptor") else None
