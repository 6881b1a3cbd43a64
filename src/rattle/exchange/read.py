"""Mechanisms from files of other programs; which it is says the content, and where that says nothing, the ending."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

from rattle.description import file as model_file
from rattle.errors import InputError, ModelError
from rattle.exchange.imported import Assumptions, Imported
from rattle.exchange.refusal import in_one_line, quoted, refused
from rattle.exchange.writing import text_of
from rattle.language.quantities import Quantity, in_si
from rattle.mechanism import Mechanism
from rattle.wrong_arguments import answer_in_words

UNITS = {  # of what a user states: unit, example
    "scale": ("m", "1 mm"),
    "steps_per_second": ("1/s", "25"),
    "thickness": ("m", "10 mm"),
    "density": ("kg/m^3", "7850 kg/m^3"),
}
BINARY = {  # how files begin that are no text, and what to do
    b"PK": "a packed file (zip), such as a FreeCAD document; export the assembly as .asmt, the drawing as .dxf",
    b"AutoCAD Binary DXF": "a binary drawing; save it as ASCII DXF",
    b"\x1f\x8b": "a packed file (gzip); unpack it, or save the drawing as plain SVG",
    b"AC10": "a DWG drawing; save it as ASCII DXF",
    b"\xff\xfe": "text in UTF-16; save it as UTF-8",
    b"\xfe\xff": "text in UTF-16; save it as UTF-8",
}
SEEN = 4000  # characters at the beginning that say which program wrote a file
_MODEL = re.compile(r"^[ \t]*(format\s*=|\[(bodies|joints|ground|parameters)\b)", re.MULTILINE)
_DRAWING = re.compile(r"\s*(999[ \t]*\r?\n[^\n]*\n\s*)*0[ \t]*\r?\n[ \t]*SECTION\b")
_OUTLINES = re.compile(r"\s*<(?:[^<]*<){0,40}?svg[\s>]")
_LINK = re.compile(r"\s*(pmks:|https?://)", re.IGNORECASE)


class Reader(NamedTuple):
    """The reader of a format."""

    what: str  # the files, in words
    endings: tuple[str, ...]
    begins: Callable[[str], bool]  # whether a text that begins so is one
    module: str
    function: str  # in it: (text, name of the file, Assumptions) -> Imported
    takes: tuple[str, ...]  # names of Assumptions that have a meaning


def _is_assembly(text: str) -> bool:
    from rattle.exchange.asmt.tree import is_assembly

    return is_assembly(text)


def _is_linkage(text: str) -> bool:
    """True of JSON that is no model of rattle: those have a format or bodies."""
    return model_file.is_json(text) and re.search(r'"(format|bodies)"\s*:', text) is None


READERS = (
    Reader("assemblies of Ondsel and FreeCAD", (".asmt",), _is_assembly, "asmt.read", "read_asmt", ("scale",)),
    Reader("links of PMKS+", (".pmks", ".url"), lambda text: bool(_LINK.match(text)), "pmks.read", "read_pmks", ()),
    Reader("drawings", (".dxf",), lambda text: bool(_DRAWING.match(text)), "dxf.read", "read_dxf",
           ("scale", "thickness", "density")),
    Reader("outlines", (".svg",), lambda text: bool(_OUTLINES.match(text)), "svg.read", "read_svg",
           ("scale", "thickness", "density")),
    Reader("mechanisms of pylinkage", (".json",), _is_linkage, "pylinkage.read", "read_pylinkage",
           ("scale", "steps_per_second")),
)  # fmt: skip


@answer_in_words
def read(
    path: str | os.PathLike[str],
    *,
    scale: Quantity | None = None,
    steps_per_second: Quantity | None = None,
    thickness: Quantity | None = None,
    density: Quantity | None = None,
) -> Mechanism:
    """A mechanism from a file of another program, or from a model file.

    Reads .asmt (Ondsel, FreeCAD), .dxf, .svg, links of PMKS+ in a text file, JSON of pylinkage, as the content says.
    What a format does not hold can be stated: scale, length of its unit [m]; steps_per_second of a format that
    counts steps [1/s]; thickness [m] and density [kg/m^3] of outlines.  `rattle import` prints what is assumed.
    Raises ModelError with file, place and name for what cannot be read or is not planar, InputError for bad values.
    """
    stated = assumptions(scale=scale, steps_per_second=steps_per_second, thickness=thickness, density=density)
    return mechanism(read_import(path, stated))


def assumptions(**values: Quantity | None) -> Assumptions:
    """What a user states, in SI units.  Raises InputError for what is no positive quantity."""
    numbers: dict[str, float] = {}
    for name, value in values.items():
        if value is None:
            continue
        unit, example = UNITS[name]
        number = in_si(value, name, unit, repr(example))
        if not 0.0 < number < math.inf:
            raise InputError(f"{name}: {value!r} is not positive; expected {unit}, as in {example!r}")
        numbers[name] = number
    return Assumptions(**numbers)


def read_import(path: str | os.PathLike[str], stated: Assumptions) -> Imported | Mechanism:
    """What a file of another program holds; of a model file, the mechanism.  Raises ModelError, InputError."""
    content, name = model_file.read_bytes(path)
    text = _text(content, name)
    reader = _reader(text, name)
    stated_words = [word for word, value in stated._asdict().items() if value is not None]
    strange = [word for word in stated_words if reader is None or word not in reader.takes]
    if strange:
        whose = "a model file" if reader is None else f"the file, one of the {reader.what},"
        raise InputError(f"{strange[0]}: {whose} leaves nothing of this open; leave it out")
    if reader is None:
        return Mechanism.from_text(text, name)
    function = getattr(import_module(f"rattle.exchange.{reader.module}"), reader.function)
    imported: Imported = function(text, name, stated)
    return imported


def mechanism(imported: Imported | Mechanism, name: str = "") -> Mechanism:
    """The mechanism.  Raises ModelError in one line if a model cannot be so."""
    if isinstance(imported, Mechanism):
        return imported
    try:
        return Mechanism.from_text(text_of(imported))
    except ModelError as error:
        for problem in error.problems:  # of a text that the user has not seen
            problem.line = None
        raise in_one_line(error, name or imported.source) from None


def _text(content: bytes, name: str) -> str:
    """The content as text: UTF-8, or what older programs write.  Raises ModelError."""
    for beginning, what in BINARY.items():
        if content.startswith(beginning):
            raise refused(name, f"this is {what}")
    if b"\0" in content:
        line = content[: content.index(b"\0")].count(b"\n") + 1
        raise refused(name, "this is no text, it has a byte 0; is it the right file?", line)
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _reader(text: str, name: str) -> Reader | None:
    """The reader of a file by its content, then by its ending; None for a model file.  Raises ModelError."""
    beginning = text[:SEEN]
    for reader in READERS:
        if reader.begins(text if reader.endings == (".json",) else beginning):
            return reader
    if _MODEL.search(text) or model_file.is_json(text):
        return None
    suffix = Path(name).suffix.lower()
    for reader in READERS:
        if suffix in reader.endings:
            return reader
    if suffix in model_file.SUFFIXES:
        return None
    if not text.strip():
        raise refused(name, "the file is empty")
    formats = ", ".join(f"{reader.what} ({reader.endings[0]})" for reader in READERS)
    first = text.strip().split("\n", 1)[0]
    raise refused(
        name, f"no reader for a file that begins with {quoted(first)}; known: {formats}, model files (.toml)", 1
    )


def words(imported: Imported) -> list[str]:
    """What was taken, assumed and left out, in lines for a user."""
    lines = [f"taken: {word}" for word in imported.taken]
    lines += [f"assumed: {word}" for word in imported.assumed]
    lines += [f"left out: {word}" for word in imported.left_out]
    return lines
