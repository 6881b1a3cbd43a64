"""The folder that the studio may read and write: everything outside of it, by whatever name or link, is refused."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from pathlib import Path, PurePosixPath, PureWindowsPath

from rattle.description import file as model_file
from rattle.errors import InputError

MOST = 500  # model files that are listed
DEEPEST = 3  # folders below the start in which model files are looked for
SKIPPED = ("node_modules", "__pycache__")


class Refused(InputError):
    """A file that may not be read or written here; the message says why and what to do."""


class Folder:
    """Model files in one folder and those below it, by names relative to it with forward slashes."""

    def __init__(self, root: str | os.PathLike[str]) -> None:
        self.root = Path(root).resolve()

    def models(self) -> list[str]:
        """Names of the model files, at most 500; links out of the folder are left out."""
        found: list[str] = []
        for place in self._walk(self.root, 0):
            if len(found) >= MOST:
                break
            found.append(place.relative_to(self.root).as_posix())
        return found

    def _walk(self, folder: Path, depth: int) -> Iterator[Path]:
        try:
            entries = sorted(os.scandir(folder), key=lambda one: (one.is_dir(), one.name.lower()))
        except OSError:
            return
        for one in entries:
            place = Path(one.path)
            if one.name.startswith(".") or one.name in SKIPPED or not place.resolve().is_relative_to(self.root):
                continue
            if one.is_dir(follow_symlinks=False):
                if depth < DEEPEST:
                    yield from self._walk(place, depth + 1)
            elif place.suffix.lower() in model_file.SUFFIXES and one.is_file() and self._is_model(place):
                yield place

    @staticmethod
    def _is_model(place: Path) -> bool:
        """True if a file looks like a model: it has bodies or joints; other TOML and JSON files are many."""
        try:
            with place.open("rb") as file:
                start = file.read(100_000)
        except OSError:
            return False
        return b"joints" in start or b"bodies" in start

    def place(self, name: str) -> Path:
        """Where the file of this name is, links followed.  Raises Refused if that is outside, or no model file."""
        if not isinstance(name, str) or not name.strip() or len(name) > 400 or not name.isprintable():
            raise Refused("give a file name, such as fourbar.toml")
        parts = PureWindowsPath(name)
        if PurePosixPath(name).is_absolute() or parts.drive or parts.root or ".." in parts.parts:
            raise Refused(f"{name} leads out of the folder of the studio; give a name inside of it")
        if any(part.startswith(".") for part in parts.parts):
            raise Refused(f"{name} is a hidden file; give another name")
        if parts.suffix.lower() not in model_file.SUFFIXES:
            raise Refused(f"{name}: a model is a .toml or .json file; give a name that ends so")
        try:
            place = (self.root / PurePosixPath(*parts.parts)).resolve()
        except (OSError, RuntimeError) as error:
            raise Refused(f"{name}: {error}") from None
        if not place.is_relative_to(self.root):
            raise Refused(f"{name} is a link out of the folder of the studio")
        if place.exists() and not place.is_file():
            raise Refused(f"{name} is not a plain file")
        return place

    def read(self, name: str) -> str:
        """Text of a model file.  Raises Refused, ModelError if it cannot be read."""
        return model_file.read_file(self.place(name))[0]

    def write(self, name: str, text: str) -> None:
        """Write a model file, completely or not at all.  Raises Refused, OSError."""
        place = self.place(name)
        if not place.parent.is_dir():
            raise Refused(f"{name}: there is no such folder; create it first, or leave it out of the name")
        model_file.save(place, text)

    def mark(self, name: str) -> str:
        """What a file holds now, as a short digest; "" if there is none.  Raises Refused."""
        place = self.place(name)
        try:
            return hashlib.sha256(place.read_bytes()).hexdigest()
        except FileNotFoundError:
            return ""
        except OSError as error:
            raise Refused(f"{name}: cannot read the file: {error.strerror or error}") from None


def mark_of(text: str) -> str:
    """The digest that `Folder.mark` gives for a file with this text."""
    return hashlib.sha256(text.encode()).hexdigest()
