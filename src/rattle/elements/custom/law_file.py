"""Laws in a Python file that the user names, such as the one of `rattle run --laws my_laws.py`.

Such a file is a program: it runs with all the rights of the user.  It is named on the command line only; no model file
can name one.
"""

from __future__ import annotations

import importlib.util
import os
import sys
import traceback
from contextlib import suppress
from pathlib import Path

from rattle import registry
from rattle.errors import InputError
from rattle.user_paths import expanded

FAMILIES = {"load": "load", "normal": "normal force law", "friction": "friction law"}  # that have laws, in words


def run_law_file(path: str | os.PathLike[str]) -> list[str]:
    """Run a Python file and return what it has defined, in words: "load 'drag'", "friction law 'plateau'".

    Modules beside the file can be imported in it.  Raises InputError, with the line, if it cannot be read, raises an
    exception or defines no law.
    """
    file = expanded(path)
    if not file.is_file():
        raise InputError(f"no file {str(path)!r} with laws; expected a Python file that defines some with @rt.load_law")
    before = {family: dict(registry.kinds(family)) for family in FAMILIES}
    spec = importlib.util.spec_from_file_location(file.stem, file.resolve())
    if spec is None or spec.loader is None:
        raise InputError(f"{path} is not a Python file; laws are functions in a file such as my_laws.py")
    module = importlib.util.module_from_spec(spec)
    folder = str(file.resolve().parent)
    sys.path.insert(0, folder)
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        raise InputError(f"{path}{_line(error, file)}: {type(error).__name__}: {error}") from error
    finally:
        with suppress(ValueError):  # the file may have changed it
            sys.path.remove(folder)
    names = [
        f"{words} '{name}'"
        for family, words in FAMILIES.items()
        for name, kind in registry.kinds(family).items()
        if before[family].get(name) is not kind
    ]
    if not names:
        raise InputError(f"{path} defines no law; write @rt.load_law(...) or the like above a function")
    return names


def _line(error: BaseException, file: Path) -> str:
    """Where in a file an exception comes from: ", line 3"; "" if that is not known."""
    if isinstance(error, SyntaxError):
        return f", line {error.lineno}"
    lines = [
        frame.lineno for frame in traceback.extract_tb(error.__traceback__) if Path(frame.filename) == file.resolve()
    ]
    return f", line {lines[-1]}" if lines else ""
