"""A result as the sheets of a workbook: curves, one sheet for each joint, peaks, events, parameters, trust."""

from __future__ import annotations

import json
import logging
import math
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rattle.errors import InputError
from rattle.exchange.workbook import MOST_COLUMNS, MOST_ROWS, Cell, Sheet, workbook
from rattle.language.units import QuantityError, parse_quantity, unit_of_quantity
from rattle.results import archive
from rattle.results.chosen_units import column_unit, si_unit
from rattle.results.result import Result
from rattle.results.trust import HOW
from rattle.results.within_steps import summit
from rattle.value_types import Tree

SUFFIX = ".xlsx"
CURVES, PEAKS, EVENTS, PARAMETERS, TRUST = "curves", "peaks", "events", "parameters", "trust"
MOST_CELLS = 20_000_000  # of all sheets of curves: about 1 GB of text before compression, a minute to write
EVENT_HEAD = (
    "t [s]", "joint", "kind", "normal_speed [m/s or rad/s]", "duration [s]", "peak_force [N or N*m]",
    "impulse [N*s or N*m*s]", "energy_lost [J]", "contact",
)  # fmt: skip
_log = logging.getLogger("rattle")


def require_workbook(path: str | os.PathLike[str]) -> None:
    """Raise InputError for a file name that is not that of a workbook."""
    archive.require_ending(path, "workbook", SUFFIX)


def write_workbook(
    result: Result, path: str | os.PathLike[str], *, fallback: str | os.PathLike[str] | None = None,
    units: str | Iterable[str] | None = None, names: Sequence[str] | None = None,
) -> Path:  # fmt: skip
    """`Result.to_excel`."""
    require_workbook(path)
    return archive.write_content(workbook(sheets_of(result, units, names)), path, fallback)


def sheets_of(
    result: Result, units: str | Iterable[str] | None = None, names: Sequence[str] | None = None
) -> list[Sheet]:
    """The sheets of a result; units, names: as of `Result.to_csv`.  Raises InputError for one that is too long."""
    words = [*units] if units is not None and not isinstance(units, str) else units
    chosen = result.names if names is None else tuple(dict.fromkeys(names))
    for name in chosen:
        result.unit(name)
    if len(result.t) * len(chosen) > MOST_CELLS or len(result.t) + 1 > MOST_ROWS:
        raise InputError(
            f"{len(result.t)} instants of {len(chosen)} curves; a sheet holds {MOST_ROWS - 1} instants, and a workbook"
            f" of rattle {MOST_CELLS / 1e6:.0f} million numbers. Name fewer curves, or write .csv or .mat"
        )
    joints: dict[str, list[str]] = {}
    others: list[str] = []
    for name in chosen:
        owner, dot, _ = name.partition(".")
        (joints.setdefault(owner, []) if dot and owner in result.geometry["joints"] else others).append(name)
    sheets = [*_of_curves(result, CURVES, others, words)]
    peaks, events = _peaks(result, chosen, words), _events(result)
    ends = [*([peaks] if peaks.length else []), events]
    ends += [_parameters(result, words), _trust(result)]
    reserved = {sheet.name for sheet in (*ends, *sheets)} | {PEAKS, EVENTS}
    for joint, own in joints.items():
        sheets += _of_curves(result, f"{joint} (joint)" if joint.casefold() in reserved else joint, own, words)
    return [*sheets, *ends]


def _of_curves(result: Result, title: str, names: Sequence[str], units: str | Sequence[str] | None) -> Iterator[Sheet]:
    """Curves over time; more than a sheet has columns go on in further sheets, each with its times."""
    across = MOST_COLUMNS - 1
    parts = [names[k : k + across] for k in range(0, len(names), across)] or [[]]
    if len(parts) > 1:
        _log.info(f"{title}: {len(names)} curves, which a sheet does not hold: they go on in {len(parts) - 1} more")
    for n, part in enumerate(parts, 1):
        titles, table = result.titled_columns(part, units)
        yield Sheet(title if n == 1 else f"{title} {n}", titles, map(np.ndarray.tolist, table), len(table))


def _peaks(result: Result, names: Sequence[str], units: str | Sequence[str] | None) -> Sheet:
    """The largest magnitudes within the steps, which may lie between two instants of the curves."""
    time = column_unit("s", units)
    rows: list[list[Cell]] = []
    for name in result.peaks:
        top = summit(result, name) if name in names else None  # none where it says nothing of a real joint
        if top is not None:
            unit = column_unit(result.unit(name), units)
            rows.append([name, unit.factor * top.y, unit.unit, time.factor * top.t, unit.factor * result.rms(name)])
    return Sheet(PEAKS, ("curve", "largest value", "unit", f"t [{time.unit}]", "rms"), rows, len(rows))


def _events(result: Result) -> Sheet:
    return Sheet(EVENTS, EVENT_HEAD, [list(event) for event in result.events], len(result.events))


class WrittenParameter(NamedTuple):
    """A parameter of the model of a result."""

    name: str
    value: float | str  # [SI]
    unit: str  # SI; "" where it has none, or is not known
    written: str  # as in the model file
    description: str


def parameters_of(result: Result) -> list[WrittenParameter]:
    """The parameters with which a result was computed."""
    document = result.provenance.get("document")
    tables = json.loads(str(document)) if document else {}
    entries = tables.get("parameters")
    listed = []
    for name, value in (result.provenance.get("parameters") or {}).items():
        entry = entries.get(name) if isinstance(entries, dict) else None
        form: Tree = entry if isinstance(entry, dict) else {"value": entry}
        written = form.get("value")
        words = str(form.get("description") or form.get("label") or "")
        text = "" if written is None else str(written)
        listed.append(WrittenParameter(name, value, _unit_of(text), text, words))
    return listed


def _unit_of(text: str) -> str:
    """SI unit of a quantity in a model file, "" where it has none."""
    try:
        quantity = parse_quantity(text)
    except QuantityError:
        return ""
    return "" if quantity is None or quantity[1] is None else si_unit(unit_of_quantity(text)[1], quantity[1])


def _parameters(result: Result, units: str | Sequence[str] | None) -> Sheet:
    rows: list[list[Cell]] = []
    for parameter in parameters_of(result):
        unit = column_unit(parameter.unit, units)
        value = parameter.value
        scaled = unit.factor * value if isinstance(value, float | int) and not isinstance(value, bool) else value
        rows.append([parameter.name, scaled, unit.unit, parameter.written, parameter.description])
    return Sheet(PARAMETERS, ("parameter", "value", "unit", "in the model file", "description"), rows, len(rows))


def _trust(result: Result) -> Sheet:
    """How far the result can be trusted in words and numbers, and what was run."""
    trust = result.trust
    lines = [line.replace(HOW, "") for line in (trust.word, *trust.why)]
    rows: list[list[Cell]] = [["why" if n else "trust", line, ""] for n, line in enumerate(lines)]
    if not result.success:
        rows.append(["stopped", result.message, ""])
    rows += [
        ["end of the run", trust.t_end, "s"],
        ["horizon", math.nan if trust.horizon is None else trust.horizon, "s"],
        ["constraint error", trust.drift, "m"],
        ["energy error", trust.energy_balance, "J"],
    ]
    for key, value in result.provenance.items():
        if key not in ("parameters", "document") and value is not None:
            rows.append([key, value if isinstance(value, float | int | str) else json.dumps(value, default=str), ""])
    return Sheet(TRUST, ("what", "value", "unit"), rows, len(rows))
