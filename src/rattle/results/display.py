"""Display of objects in a notebook: small HTML tables, numbers in handy units, files as pictures."""

from __future__ import annotations

import base64
import html
import math
from collections.abc import Iterable, Sequence
from pathlib import Path

from rattle.description.model import Model

DEGREES = 180.0 / math.pi
MILLIMETRES = 0.05  # a length below it is written in mm [m]
ROUNDING = 1e-12  # an angle below it is zero [rad]
_READ_AS = {"rad": "deg", "rad/s": "deg/s", "rad/s^2": "deg/s^2"}
_KIND_OF_FILE = {".gif": "image/gif", ".png": "image/png", ".svg": "image/svg+xml", ".mp4": "video/mp4"}
LARGEST = 20_000_000  # size of an animation that is embedded in a notebook [bytes]


def scale(unit: str, size: float) -> tuple[float, str]:
    """Factor from the SI unit, and the unit in which tables and pictures show a quantity of this size [SI].

    Angles and their rates are in degrees, lengths below 50 mm in mm, all else as it is.
    """
    if unit in _READ_AS:
        return DEGREES, _READ_AS[unit]
    return (1e3, "mm") if unit == "m" and 0.0 < size < MILLIMETRES else (1.0, unit)


def readable(value: float, unit: str) -> tuple[float, str]:
    """A value [SI] and its unit for display: angles in degrees (0 if only rounding is left), others unchanged."""
    if unit == "rad" and abs(value) < ROUNDING:
        value = 0.0
    factor, shown = scale(unit, 0.0)
    return factor * value, shown


def quantity(value: float, unit: str, digits: int = 4) -> str:
    """A value [SI] as text with its unit, angles in degrees and short lengths in mm."""
    if unit == "m" and abs(value) < 1e-15:
        value = 0.0
    if unit == "rad" and abs(value) < ROUNDING:
        value = 0.0
    factor, shown = scale(unit, abs(value))
    return f"{factor * value:.{digits}g} {shown}".rstrip()


def table(head: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "", below: Iterable[str] = ()) -> str:
    """An HTML table; names and texts are escaped."""
    cells = ["".join(f'<td style="text-align:left">{html.escape(str(cell))}</td>' for cell in row) for row in rows]
    top = "".join(f'<th style="text-align:left">{html.escape(name)}</th>' for name in head)
    parts = [f"<div><b>{html.escape(caption)}</b></div>"] if caption else []
    parts.append(
        f"<table><thead><tr>{top}</tr></thead><tbody>{''.join(f'<tr>{row}</tr>' for row in cells)}</tbody></table>"
    )
    parts += [f"<div>{html.escape(line)}</div>" for line in below]
    return "".join(parts)


def model_tables(model: Model, caption: str) -> str:
    """Joints and parameters of a model as tables of a notebook."""
    joints = [
        (name, one.kind, f"{one.a.body} - {one.b.body}", quantity(one.clearance, "m") if one.contact else "",
         one.contact.title if one.contact else "")
        for name, one in model.joints.items()
    ]  # fmt: skip
    named = [(name, quantity(one.value, one.unit, 6)) for name, one in model.parameters.items()]
    parts = [table(("joint", "type", "between", "clearance", "contact"), joints, caption)]
    return "".join([*parts, table(("parameter", "value"), named)] if named else parts)


def lines(text: str) -> str:
    """A report of several lines as HTML, as it is printed."""
    return f'<pre style="white-space:pre-wrap">{html.escape(text)}</pre>'


class Picture:
    """A picture or animation that was written to a file; a notebook shows it.

    path: the file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    def __repr__(self) -> str:
        return f"<rattle.Picture: {self.path}>"

    def _repr_html_(self) -> str:
        kind = _KIND_OF_FILE.get(self.path.suffix, "")
        if not kind or not self.path.is_file() or self.path.stat().st_size > LARGEST:
            return html.escape(f"written: {self.path}")
        data = f"data:{kind};base64,{base64.b64encode(self.path.read_bytes()).decode()}"
        if kind.startswith("video"):
            return f'<video controls loop src="{data}"></video>'
        return f'<img alt="{html.escape(str(self.path))}" src="{data}">'
