"""The folder that the studio may read and write: everything outside of it, by whatever name or link, is refused."""

from __future__ import annotations

import base64
import hashlib
import os
from collections.abc import Iterator
from pathlib import Path, PurePosixPath, PureWindowsPath

from rattle.atomic_file import atomic
from rattle.description import file as model_file
from rattle.errors import InputError

MOST = 500  # model files that are listed
MOST_LOOKED = 2000  # files whose beginning is read to see whether they are models: a second at most
DEEPEST = 3  # folders below the start in which model files are looked for
LARGEST_PICTURE = 12_000_000  # bytes of a picture below a drawing
PICTURES = {".png": "image/png", ".jpg": "image/jpeg", ".jpeg": "image/jpeg", ".gif": "image/gif",
            ".webp": "image/webp", ".svg": "image/svg+xml"}  # fmt: skip
SKIPPED = ("node_modules", "__pycache__")


class Refused(InputError):
    """A file that may not be read or written here; the message says why and what to do."""


class Folder:
    """Model files in one folder and those below it, by names relative to it with forward slashes."""

    def __init__(self, root: str | os.PathLike[str]) -> None:
        self.root = Path(root).resolve()

    def models(self) -> tuple[list[str], bool]:
        """Names of the model files, and whether these are all; links out of the folder are left out.

        At most 500 are named, and at most 2000 files looked at: the folder may hold any number of other files.
        """
        names: list[str] = []
        for looked, place in enumerate(self._walk(self.root, 0)):
            if len(names) >= MOST or looked >= MOST_LOOKED:
                return names, False
            if self._is_model(place):
                names.append(place.relative_to(self.root).as_posix())
        return names, True

    def _walk(self, folder: Path, depth: int) -> Iterator[Path]:
        """Files that may be models by their names: those of TOML first in every folder, then those below it."""
        try:
            entries = sorted(os.scandir(folder), key=_order)
        except OSError:
            return
        for entry in entries:
            place, is_folder = Path(entry.path), entry.is_dir(follow_symlinks=False)
            if entry.name.startswith(".") or entry.name in SKIPPED:
                continue
            if not is_folder and place.suffix.lower() not in model_file.SUFFIXES:
                continue
            if not place.resolve().is_relative_to(self.root):
                continue
            if not is_folder and entry.is_file():
                yield place
            elif is_folder and depth < DEEPEST:
                yield from self._walk(place, depth + 1)

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
        parts = _inside(name)
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

    def keep_picture(self, name: str, content: bytes, model: str = "") -> str:
        """Write a picture beside a model of this name, under its own name or the next free one; that name.

        Raises Refused, OSError.
        """
        folder = self._of(model)
        stem, suffix = PurePosixPath(PureWindowsPath(name).name).stem, PureWindowsPath(name).suffix.lower()
        plain = "".join(c if c.isalnum() or c in "-_" else "-" for c in stem)[:60].strip("-") or "picture"
        if suffix not in PICTURES or len(content) > LARGEST_PICTURE:
            raise Refused(f"{name}: a picture is one of {', '.join(PICTURES)}, of up to {LARGEST_PICTURE // 10**6} MB")
        for n in range(1, 1000):
            place = folder / f"{plain}{f'-{n}' if n > 1 else ''}{suffix}"
            if not place.exists():
                with atomic(place) as file:
                    file.write_bytes(content)
                return place.name
            if place.is_file() and not place.is_symlink() and place.read_bytes() == content:
                return place.name
        raise Refused(f"{name}: there are a thousand pictures of this name; give it another one")

    def _of(self, model: str) -> Path:
        """The folder of a model; the root for one that has no file yet."""
        return self.place(model).parent if model else self.root

    def picture(self, name: str, model: str = "") -> str:
        """A picture beside a model as a data address.  Raises Refused."""
        place = (self._of(model) / PureWindowsPath(name).name).resolve()
        kind = PICTURES.get(place.suffix.lower())
        if kind is None or PureWindowsPath(name).name != name or not place.is_relative_to(self.root):
            raise Refused(f"{name}: a picture lies beside the model and is one of {', '.join(PICTURES)}")
        if not place.is_file() or place.stat().st_size > LARGEST_PICTURE:
            raise Refused(f"{name}: there is no such picture beside the model, or it is too large")
        return f"data:{kind};base64,{base64.b64encode(place.read_bytes()).decode()}"

    def mark(self, name: str) -> str:
        """What a file holds now, as a short digest; "" if there is none.  Raises Refused."""
        place = self.place(name)
        try:
            with place.open("rb") as file:
                return hashlib.file_digest(file, "sha256").hexdigest()
        except FileNotFoundError:
            return ""
        except OSError as error:
            raise Refused(f"{name}: cannot read the file: {error.strerror or error}") from None


def _inside(name: str) -> PureWindowsPath:
    """The parts of the name of a model file inside of a folder.  Raises Refused."""
    parts = PureWindowsPath(name)
    if PurePosixPath(name).is_absolute() or parts.drive or parts.root or ".." in parts.parts:
        raise Refused(f"{name} leads out of the folder of the studio; give a name inside of it")
    if any(part.startswith(".") for part in parts.parts):
        raise Refused(f"{name} is a hidden file; give another name")
    if parts.suffix.lower() not in model_file.SUFFIXES:
        raise Refused(f"{name}: a model is a .toml or .json file; give a name that ends so")
    return parts


def _order(entry: os.DirEntry[str]) -> tuple[bool, bool, str]:
    """TOML files, then others, then folders; of each by name."""
    return entry.is_dir(), not entry.name.lower().endswith(".toml"), entry.name.lower()


def mark_of(text: str) -> str:
    """The digest that `Folder.mark` gives for a file with this text."""
    return hashlib.sha256(text.encode()).hexdigest()
