"""Display of objects: numbers in handy units, columns of text, and for notebooks HTML tables and pictures."""

from __future__ import annotations

import base64
import html
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path

from rattle.description.model import Model, Parameter
from rattle.results.chosen_units import ANGLES, Shown, chosen, shown_in
from rattle.results.handy_units import IN_TABLES, rung

ROUNDING = 1e-12  # an angle below it is zero [rad]
_KIND_OF_FILE = {".gif": "image/gif", ".png": "image/png", ".svg": "image/svg+xml", ".mp4": "video/mp4"}
LARGEST = 20_000_000  # size of an animation that is embedded in a notebook [bytes]
_NUMBER = re.compile(r"[-+±\N{MINUS SIGN}]?\+?-?\d[\d.e+-]*( ?(%|°)| [^ ]{1,9})?( dry)?$|[-\u2013]$")
_UNIT = re.compile(r"(?<=\d )[a-zA-Z]+(?:[*/^]\(?[a-zA-Z0-9]+\)?)+(?![\w*(])")  # after a number
_ALONE = re.compile(r"[a-zA-Z]{1,3}(?:[*/^]\(?[a-zA-Z0-9]{1,3}\)?){1,3}")
_MICRO = re.compile(r"(?<=\d )u(?=[ms]\b)")
_RIGHT = ' class="number"'
_PRINTED = str.maketrans("*", "·")
# the colours of the text are those of the notebook, light or dark; a white ground only behind pictures
_STYLE = {
    "": "font:13px/1.45 system-ui,sans-serif;max-width:60em;margin:.3em 0",
    "header": "font-weight:600;font-size:1.05em;margin-bottom:.4em",
    "table": "border-collapse:collapse;margin:.2em 0 .6em;font:inherit;font-variant-numeric:tabular-nums",
    ":is(th,td)": "padding:.2em .9em .2em 0;text-align:left;border:0;background:none;vertical-align:top",
    "thead th": "opacity:.65;border-bottom:1px solid color-mix(in srgb,currentColor 40%,transparent)",
    "tbody tr+tr td": "border-top:1px solid color-mix(in srgb,currentColor 12%,transparent)",
    "td:first-child": "font-weight:600",
    ".number:not(:first-child)": "text-align:right;white-space:nowrap",
    "p": "margin:.2em 0;opacity:.85",
    "pre": "white-space:pre-wrap;margin:.2em 0;font-size:12px;background:none",
    "ul": "list-style:none;padding:0;margin:.2em 0",
    "li": "margin:.25em 0;padding-left:1.5em;text-indent:-1.5em",
    "li::before": "display:inline-block;width:1.5em;text-indent:0;font-weight:700",
    ".good::before": "content:'\\2713';color:#009E73",
    ".bad::before": "content:'!';color:#D55E00",
    ".note::before": "content:'\\2022';opacity:.6",
    "svg.picture": "display:block;background:#fff;border-radius:6px;max-width:min(100%,44em);height:auto;margin:.3em 0",
    "footer": "margin-top:.4em;opacity:.7",
}  # colours of texts are those of the notebook, light or dark; a white ground only behind pictures
STYLE = f"<style>{''.join(f'.rattle-card {part}{{{rule}}}' for part, rule in _STYLE.items())}</style>"
NO_LENGTH = 1e-15  # a length below it is zero [m]


def scale(unit: str, size: float) -> Shown:
    """Factor from the SI unit, and the unit in which tables show a quantity of this size [SI].

    As the user asks for; otherwise angles and their rates are in degrees, lengths below 0.2 m in mm, all else as it is.
    """
    return chosen(unit) or rung(IN_TABLES, unit, size)


def readable(value: float, unit: str) -> tuple[float, str]:
    """A value [SI] and its unit for display: angles in degrees (0 if only rounding is left), others unchanged."""
    if unit == "rad" and abs(value) < ROUNDING:
        value = 0.0
    factor, shown = scale(unit, 0.0)
    return factor * value, shown


def quantity(value: float, unit: str, digits: int = 4, usual: Shown | str = "") -> str:
    """A value [SI] as text with its unit, angles in degrees and short lengths in mm.

    usual: the unit, or its name, unless the user asks for another one.
    """
    if unit == "m" and abs(value) < NO_LENGTH:
        value = 0.0
    if unit == "rad" and abs(value) < ROUNDING:
        value = 0.0
    if isinstance(usual, str):
        usual = shown_in(usual) if usual else scale(unit, abs(value))
    factor, shown = chosen(unit) or usual
    return f"{factor * value:.{digits}g} {shown}".rstrip()


def zeroed(value: float, floor: float) -> float:
    """The value, or 0 if its magnitude is below `floor` (same unit) and so only rounding."""
    return 0.0 if abs(value) <= floor else value


def in_written_unit(parameter: Parameter, written: tuple[float, str], digits: int = 6) -> str:
    """The value of a parameter as text, in the unit in which the model file writes it: its size [SI] and name."""
    size, unit = written
    if (asked := chosen(parameter.unit or ("rad" if unit in ANGLES else ""))) and unit:
        return f"{asked.factor * parameter.value:.{digits}g} {asked.unit}"
    return f"{parameter.value / size:.{digits}g} {unit}" if unit else quantity(parameter.value, parameter.unit, digits)


def in_columns(rows: Sequence[Sequence[str]], right: Collection[int] = ()) -> list[str]:
    """Rows as lines with columns as wide as they must be; right: numbers of those that stand on the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(f"{text:{'>' if k in right else '<'}{widths[k]}}" for k, text in enumerate(row)).rstrip()
            for row in rows]  # fmt: skip


def table(
    head: Sequence[str], rows: Iterable[Sequence[str]], caption: str = "", below: Iterable[str] = (), hint: str = ""
) -> str:
    """A card with one table; names and texts are escaped.  hint: what to type next."""
    return card(caption, grid(head, rows), *(f"<p>{html.escape(printed(line))}</p>" for line in below), hint=hint)


def grid(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table without a frame around it; cells with numbers stand on the right."""
    every = [[str(cell) for cell in row] for row in rows]
    numbers = [all(_NUMBER.match(row[k]) for row in every if k < len(row) and row[k]) for k in range(len(head))]
    top = "".join(
        f'<th scope="col"{_RIGHT if right else ""}>{html.escape(printed(name))}</th>'
        for name, right in zip(head, numbers, strict=True)
    )
    body = "".join(f"<tr>{''.join(map(_cell, row))}</tr>" for row in every)
    return f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


def _cell(text: str) -> str:
    if _ALONE.fullmatch(text):
        return f"<td>{html.escape(printed(f'1 {text}')[2:])}</td>"
    return f"<td{_RIGHT if _NUMBER.match(text) else ''}>{html.escape(printed(text))}</td>"


def printed(text: str) -> str:
    """A text in which units after numbers are as they are printed: N·m, m/s², µm, ±."""
    text = _UNIT.sub(lambda unit: unit[0].translate(_PRINTED).replace("^2", "²").replace("^3", "³"), text)
    return _MICRO.sub("µ", text).replace("+-", "±")


def card(title: str, *parts: str, hint: str = "") -> str:
    """What a notebook shows of an object: a title, parts in HTML, and what to type next; light or dark as the notebook.

    title and hint are escaped, the parts are not.
    """
    top = f"<header>{html.escape(printed(title))}</header>" if title else ""
    end = f"<footer>next: <code>{html.escape(hint)}</code></footer>" if hint else ""
    return f'<div class="rattle-card">{STYLE}{top}{"".join(parts)}{end}</div>'


def marks(sentences: Iterable[tuple[str, str]]) -> str:
    """Sentences with a mark before each: "good", "bad" or "note"; no colour alone says which."""
    items = [f'<li class="{kind}">{html.escape(printed(_sentence(text)))}</li>' for kind, text in sentences]
    return f"<ul>{''.join(items)}</ul>" if items else ""


def _sentence(text: str) -> str:
    """With a capital letter, unless it begins with a name."""
    word = text.partition(" ")[0]
    return text[:1].upper() + text[1:] if word.isalpha() and word.islower() and len(word) > 1 else text


def joint_rows_of(model: Model) -> list[tuple[str, str, str, str, str]]:
    """Joints of a model: name, type, bodies, clearance and contact as texts."""
    return [
        (name, joint.kind, f"{joint.a.body} - {joint.b.body}", quantity(joint.clearance, "m") if joint.contact else "",
         joint.contact.title if joint.contact else "")
        for name, joint in model.joints.items()
    ]  # fmt: skip


def model_tables(model: Model, written: Mapping[str, tuple[float, str]]) -> str:
    """Joints and parameters of a model as tables of a notebook; written: units of parameters, see `in_written_unit`."""
    named = [(name, in_written_unit(parameter, written[name])) for name, parameter in model.parameters.items()]
    parts = grid(("joint", "type", "between", "clearance", "contact"), joint_rows_of(model))
    return parts + grid(("parameter", "value"), named) if named else parts


def lines(text: str, title: str = "", hint: str = "") -> str:
    """A report of several lines as a card, as it is printed."""
    return card(title, f"<pre>{html.escape(text)}</pre>", hint=hint)


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
