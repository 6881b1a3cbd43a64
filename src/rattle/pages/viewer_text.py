"""The viewer as one ES module: its files joined, without the imports between them.

Every file of `rattle/pages/viewer` is a module of its own for those who read it; a page needs one text.  Names at the
top of all files therefore have to differ, which is checked here.
"""

from __future__ import annotations

import functools
import json
import re
from collections.abc import Mapping
from importlib import resources

from rattle.errors import InputError
from rattle.language.units import UNITS, zero_of
from rattle.pages.compact import compact
from rattle.plots.curves import CURVES, MORE
from rattle.plots.scene import COLOURS
from rattle.results.handy_units import HANDY, LEAST, MOST, QUANTITY

ENTRY = "mount.js"
STYLE = "style.js"  # made here: the style sheet as a text
PALETTE = "palette.js"  # made here: the colours of `rattle.plots`
HANDY_UNITS = "handy_units.js"  # made here: the table of `rattle.results.handy_units`
IMPORT = re.compile(r'^import \{([^}]*)\} from "\./([\w-]+\.js)";\n', re.MULTILINE)
TOP = re.compile(r"^(?:export )?(?:async )?(?:function\*?|class|const|let) +([A-Za-z_$][\w$]*)", re.MULTILINE)
SECOND = re.compile(r",\s*([A-Za-z_$][\w$]*) *=(?!>)")
EXPORTED = re.compile(r"^export .*$", re.MULTILINE)


@functools.cache
def viewer_text() -> str:
    """The whole viewer as the text of one ES module, with its style sheet in it."""
    return joined(viewer_files(), ENTRY)


def viewer_files() -> dict[str, str]:
    """Texts of all modules of the viewer by the name of their file."""
    folder = resources.files("rattle.pages") / "viewer"
    files = {file.name: file.read_text(encoding="utf-8") for file in folder.iterdir() if file.name.endswith(".js")}
    files[STYLE] = f"export const viewerStyle = {json.dumps(style_text(), ensure_ascii=False)};\n"
    units = {name: (size, *dimension) for name, (size, dimension) in UNITS.items() if not zero_of(name)}
    handy = {"units": HANDY, "least": LEAST, "most": MOST, "quantities": QUANTITY, "known": units}
    palette = {"named": COLOURS, "curves": [*CURVES, *MORE]}
    named = "// Colours of drawings and curves: rattle/plots/scene.py and curves.py.\n"
    files[PALETTE] = f"{named}export const PALETTE = {json.dumps(palette)};\n"
    title = "// Units that are known, and those in which quantities are handy: rattle/results/handy_units.py.\n"
    files[HANDY_UNITS] = f"{title}export const HANDY = {json.dumps(handy, ensure_ascii=False)};\n"
    return files


def style_text() -> str:
    """The style sheet of the viewer, without comments and indentation."""
    text = (resources.files("rattle.pages") / "viewer" / "viewer.css").read_text(encoding="utf-8")
    return "\n".join(
        line.strip() for line in re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL).splitlines() if line.strip()
    )


def joined(files: Mapping[str, str], entry: str) -> str:
    """One module of an entry and all that it imports, each before those that need it.

    Raises InputError for an import of an unknown file or name, and for a name that two files declare.
    """
    order: list[str] = []
    _follow(files, entry, order, [])
    owner: dict[str, str] = {}
    for name in order:
        for declared in declarations(files[name]):
            if declared in owner:
                raise InputError(f"{declared} is declared in {owner[declared]} and in {name}: give one another name")
            owner[declared] = name
    return "".join(_bare(files[name]) for name in order)


def declarations(text: str) -> list[str]:
    """Names that a file declares at its top: functions, classes and constants, also several on one line."""
    names = []
    for match in TOP.finditer(text):
        names.append(match[1])
        if re.match(r"(?:export )?(?:const|let)", match[0]):
            names += SECOND.findall(_outermost(text[match.end() :].partition("\n")[0]))
    return names


def _outermost(text: str) -> str:
    """What of a text stands in no bracket."""
    depth, kept = 0, []
    for letter in text:
        depth -= letter in ")]}"
        kept.append(letter if depth == 0 else " ")
        depth += letter in "([{"
    return "".join(kept)


def _follow(files: Mapping[str, str], name: str, order: list[str], above: list[str]) -> None:
    """Enter a file into `order` after all that it imports."""
    if name in order:
        return
    if name in above:
        raise InputError(f"{' -> '.join([*above, name])}: files import each other in a circle")
    for names, other in IMPORT.findall(files[name]):
        if other not in files:
            raise InputError(f"{name} imports {other}, which is not there")
        exported = {symbol for line in EXPORTED.findall(files[other]) for symbol in declarations(line)}
        for symbol in filter(None, (part.strip() for part in names.split(","))):
            if symbol not in exported:
                raise InputError(f"{name} imports {symbol} from {other}, which does not export it")
        _follow(files, other, order, [*above, name])
    if re.search(r"^import\b", IMPORT.sub("", files[name]), re.MULTILINE):
        raise InputError(f'{name}: imports are written `import {{ name }} from "./file.js";`')
    order.append(name)


def _bare(text: str) -> str:
    """A file without its imports, and without what only people need."""
    return compact(IMPORT.sub("", text))
