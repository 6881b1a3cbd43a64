"""What `--over` says: parameters, or paths of numbers of a model, with their values."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rattle.cli.options import value

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

MOST_VALUES = 2**20  # of one parameter of a sweep


def axes_of(m: Mechanism, ranges: tuple[str, ...]) -> tuple[Mechanism, dict[str, list[float | str]]]:
    """Parameters of --over and their values, and the mechanism in which a path of --over is a parameter."""
    axes: dict[str, list[float | str]] = {}
    for text in ranges:
        name, values = axis_values(text)
        if "." in name:
            m, name = _as_parameter(m, name, values)
        if name in axes:
            raise click.UsageError(f"--over: '{name}' is given twice")
        axes[name] = values
    return m, axes


def _as_parameter(m: Mechanism, path: str, values: list[float | str]) -> tuple[Mechanism, str]:
    """The mechanism with a parameter in place of the number at a path, and its name.  Raises ModelError."""
    import json
    import logging

    name = "_".join(path.split(".")[1:])
    while name in m.parameters:
        name += "_"
    before = json.loads(m.to_json())
    for key in path.split("."):
        before = before.get(key) if isinstance(before, dict) else None
    number = isinstance(before, int | float | str) and not isinstance(before, bool)
    m = m.set({f"parameters.{name}": before if number else values[0], path: name})
    logging.getLogger("rattle").info(f"{path} is the parameter {name} here")
    return m, name


def axis_values(text: str) -> tuple[str, list[float | str]]:
    """A parameter and its values from NAME=FIRST:LAST:COUNT or NAME=VALUE,VALUE."""
    name, _, rest = text.partition("=")
    parts = [part.strip() for part in rest.split(":")]
    if not name.strip() or not rest.strip() or len(parts) not in (1, 3):
        raise click.UsageError(f"--over needs NAME=FIRST:LAST:COUNT, as in r3=0.001:0.005:21, got '{text}'")
    if len(parts) == 1:
        return name.strip(), [value(part) for part in rest.split(",")]
    return name.strip(), _evenly(text, parts)


def _evenly(text: str, parts: list[str]) -> list[float | str]:
    """So many values from the first to the last; text: as it was written.  Raises click.UsageError."""
    from rattle.language.units import QuantityError, parse_quantity, unit_name

    try:
        first, last = (parse_quantity(part) or (float(part), None) for part in parts[:2])
    except (QuantityError, ValueError) as error:
        raise click.UsageError(f"--over {text}: {error}") from None
    if not parts[2].isdecimal() or not 1 <= (count := int(parts[2])) <= MOST_VALUES:
        words = f"the number of values must be a whole number from 1 to {MOST_VALUES}, got '{parts[2]}'"
        raise click.UsageError(f"--over {text}: {words}")
    if first[1] != last[1] and all(end[0] or end[1] is not None for end in (first, last)):  # 0 has every unit
        raise click.UsageError(f"--over {text}: both ends need the same kind of unit, as in r3=1 mm:5 mm:21")
    import numpy as np

    dimension = last[1] if first[1] is None else first[1]
    unit = "" if dimension is None else unit_name(dimension) or "rad"  # kept: it may not be that of the parameter
    values = np.linspace(first[0], last[0], count).tolist()
    return [f"{x!r} {unit}" if unit else x for x in values]
