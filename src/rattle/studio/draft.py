"""The text of one session and its file: opened, changed, and saved only where nothing is lost."""

from __future__ import annotations

from pathlib import Path

from rattle.description import file as model_file
from rattle.errors import ModelError
from rattle.studio.folder import Folder, Refused, mark_of
from rattle.studio.shelf import Source

EMPTY = """format = 1
gravity = [0, -9.81]
"""


class Draft:
    """A model text, the name of its file in the folder ("" while it has none), and what that file holds."""

    def __init__(self, folder: Folder) -> None:
        self.folder = folder
        self.text, self.name, self.saved = "", "", ""
        self._written = ""  # digest of what this session itself has written last
        self._seen = ""  # digest of the file when it was read or written

    def begin(self, text: str, name: str) -> None:
        """Another text, of the file of this name or of none."""
        self.text = self.saved = text
        self.name = name
        self._seen = mark_of(text) if name else ""
        self._written = ""

    @property
    def changed(self) -> bool:
        """True if the text is not what the file holds."""
        return self.text != self.saved

    def source(self) -> Source:
        """The text with the place of its file, in whose folder its tables are."""
        return {"text": self.text, "file": str(self.folder.place(self.name)) if self.name else ""}

    def suggested(self, text: str) -> str:
        """A name for the file of a text."""
        try:
            title = str(model_file.parse(text).get("name", "")) or "mechanism"
        except ModelError:
            title = "mechanism"
        plain = "".join(c if c.isalnum() and c.isascii() else "-" for c in title.lower())
        short = "-".join(part for part in plain.split("-") if part)[:40].strip("-")
        return self.name or f"{short or 'mechanism'}{'.json' if model_file.is_json(text) else '.toml'}"

    def target(self, name: str, text: str) -> str:
        """The name of the file to write for a text, .toml unless it says otherwise.  Raises Refused."""
        name = name.strip() or self.name
        if Path(name).suffix == "":
            name += ".toml"
        is_json = model_file.is_json(text)
        if is_json != (Path(name).suffix.lower() == ".json"):
            raise Refused(f"the text is {'JSON' if is_json else 'TOML'}: give a name that ends so")
        self.folder.place(name)
        return name

    def would_lose(self, name: str, text: str) -> str:
        """What to ask before this file is written; "" if nothing is lost: it is new, or from here."""
        now = self.folder.mark(name)
        if not now or now in (self._written, mark_of(text)):
            return ""
        if name == self.name and now != self._seen:
            return f"{name} was changed by another program since it was opened here. Overwrite it with what is here?"
        return f"{name} exists. Overwrite it?"

    def write(self, name: str, text: str) -> None:
        """Write a text.  Raises Refused, OSError."""
        self.folder.write(name, text)
        self.name, self.saved = name, text
        self._written = self._seen = mark_of(text)
