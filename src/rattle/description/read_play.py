"""The play of a joint: a length, or by the name of a fit or of a rolling bearing, which becomes a length here, once.

A fit has two parameters that no user writes, `<joint>.bore` and `<joint>.pin`: how far both diameters lie off their
nominal size.  A rolling bearing has one, `<joint>.play`.  They are varied as all others are, and may be set.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from rattle.catalogue.bearings import BearingPlay, bearing
from rattle.catalogue.fits import Fit, fit
from rattle.description.read_fields import FieldReader
from rattle.description.read_materials import material_named
from rattle.description.read_values import Values, quoted
from rattle.description.reading import Path, Table, section
from rattle.description.tables import CLEARANCE, DISTRIBUTIONS, PLAY
from rattle.errors import InputError, suggest
from rattle.language.materials import Material
from rattle.language.recorded import bare
from rattle.language.units import FREEZING

ROOM = 293.15  # temperature at which drawings hold [K], ISO 1
COLDEST = 150.0  # [K]; colder is a slip: a number of degC that was written without its unit
_FITTED = re.compile(r"\s*([A-Za-z]{1,2}\d{1,2}/[A-Za-z]{1,2}\d{1,2})\s*(\S.*)?")  # "H7/g6", "H7/g6 8 mm"
MATERIALS = ("bush_material", "pin_material")
FITTED, ROLLING = ("bore", "pin"), ("play",)  # hidden parameters


class NamedPlay(NamedTuple):
    """A play that was written by a name."""

    title: Fit | BearingPlay
    diameter: float  # nominal size of a fit, bore of a bearing [m]


class Hidden(NamedTuple):
    """A parameter that follows from a name."""

    value: float  # [m]
    tol: float  # [m]
    dist: str
    description: str


class Play(NamedTuple):
    """The clearance of a joint [m], None if it says none, nan after a problem."""

    clearance: float | None
    radius: float = math.nan  # of the bush, by a fit [m]
    title: Fit | BearingPlay | None = None


# ---------------------------------------------------------------- parameters that nobody writes
def hidden_names(document: Table) -> dict[str, None]:
    """Names of the parameters that follow from names of fits and bearings, in the order of the joints."""
    names: dict[str, None] = {}
    for joint, table in section(document, "joints").items():
        if isinstance(table, Mapping):
            keys = FITTED if "fit" in section(table, "clearance") else ROLLING if "bearing" in table else ()
            names |= dict.fromkeys(f"{joint}.{key}" for key in keys)
    return names


def hidden_parameters(values: Values, document: Table) -> Iterator[tuple[str, Hidden]]:
    """The parameters of all fits and bearings of a document, whose other parameters are known by now."""
    for joint, table in section(document, "joints").items():
        if not isinstance(table, Mapping):
            continue
        path: Path = ("joints", joint)
        clearance = section(table, "clearance")
        with values.at(path):
            if "fit" in clearance:
                yield from _of_fit(values, joint, clearance, (*path, "clearance"))
            elif "bearing" in table:
                yield from _of_bearing(values, joint, table["bearing"], (*path, "bearing"))


def _of_fit(values: Values, joint: str, table: Table, path: Path) -> Iterator[tuple[str, Hidden]]:
    dist = table.get("dist", "")
    if dist and dist not in DISTRIBUTIONS:
        hint = suggest(str(dist), DISTRIBUTIONS)
        values.wrong((*path, "dist"), f"unknown distribution {quoted(dist)}{hint}")
        dist = ""
    fitted = _fit(values, table, path)
    values.plays[joint] = None if fitted is None else NamedPlay(fitted[0], fitted[1])
    if fitted is None:
        values.broken.update(f"{joint}.{key}" for key in FITTED)
        return
    (middle, half), (pin_middle, pin_half) = fitted[0].bore, fitted[0].pin
    of = f"off {1e3 * fitted[0].diameter:.6g} mm, {fitted[0].text}"
    yield f"{joint}.bore", Hidden(middle, half, str(dist), f"diameter of the bush {of}")
    yield f"{joint}.pin", Hidden(pin_middle, pin_half, str(dist), f"diameter of the pin {of}")


def _fit(values: Values, table: Mapping[str, Any], path: Path) -> tuple[Fit, float] | None:
    """A fit and its diameter [m], which may be a number that is recorded; None after a problem."""
    if "diameter" not in table:
        values.wrong(path, 'needs diameter: the nominal size of the fit, such as "8 mm"')
        return None
    diameter = values.value(table["diameter"], "m", (*path, "diameter"), "positive")
    if math.isnan(bare(diameter)):
        return None
    try:
        return fit(table["fit"], float(diameter)), diameter
    except InputError as error:
        values.wrong((*path, "fit"), str(error))
        return None


def _of_bearing(values: Values, joint: str, written: Any, path: Path) -> Iterator[tuple[str, Hidden]]:
    values.plays[joint] = None
    try:
        rolling = bearing(written)
    except InputError as error:
        values.broken.add(f"{joint}.play")
        values.wrong(path, str(error).removeprefix("bearing: "))
        return
    values.plays[joint] = NamedPlay(rolling, rolling.bore)
    yield f"{joint}.play", Hidden(rolling.radial, rolling.tol, "", f"radial play of {rolling.title}, before mounting")


# ---------------------------------------------------------------- of one joint
def read_play(reader: FieldReader, joint: str, table: Table, kind: str, may: bool, path: Path) -> Play:
    """The clearance of a joint; may: whether its kind may be a rolling bearing."""
    values = reader.values
    if "bearing" in table:
        return _rolling(values, joint, table, kind, may, path)
    written, here = table.get("clearance"), (*path, "clearance")
    if isinstance(written, str) and (fitted := _FITTED.fullmatch(written)):
        size = fitted[2] or "8 mm"
        values.wrong(here, f'a fit is written as {{ fit = "{fitted[1]}", diameter = "{size}" }}')
        return Play(math.nan)
    if not isinstance(written, Mapping):
        return Play(reader.field(CLEARANCE, "clearance", table, {}, path))
    before = len(values.problems)
    read = reader.form(PLAY, written, here)
    _require_one_way(values, written, here)
    cold = _when_cold(values, joint, written, read)
    if len(values.problems) > before or cold is None:
        return Play(math.nan)
    assert cold.clearance is not None
    clearance = cold.clearance + _by_heat(reader, written, read, _radius(cold.radius, reader, table, path), here)
    if not clearance >= 0.0 or (not clearance > 0.0 and "temperature" in written):
        values.wrong(here, _closed(read, bare(clearance)))
        return cold._replace(clearance=math.nan)
    return cold._replace(clearance=clearance)


def _require_one_way(values: Values, written: Table, path: Path) -> None:
    """Refuse a play that is stated in no way, or in two."""
    if not any(key in written for key in ("fit", "radial")):
        values.wrong(path, 'needs fit = "H7/g6" with its diameter, or radial = "10 um"')
    if "dist" in written and "fit" not in written:
        why = "is that of both diameters of a fit; give a stated play a parameter with tol and dist"
        values.wrong((*path, "dist"), why, at_key=True)
    if "fit" in written and "radial" in written:
        values.wrong((*path, "radial"), "give a fit or a radial play, not both", at_key=True)


def _when_cold(values: Values, joint: str, written: Table, read: Mapping[str, float | None]) -> Play | None:
    """The play at 20 degC; None after a problem."""
    if "fit" not in written:
        return None if read["radial"] is None else Play(read["radial"])
    named = values.plays.get(joint)
    if named is None:
        return None
    clearance = (values.constants[f"{joint}.bore"] - values.constants[f"{joint}.pin"]) / 2
    return Play(clearance, named.diameter / 2, named.title)


def _closed(read: Mapping[str, float | None], clearance: float) -> str:
    warm = read["temperature"]
    at = "" if warm is None else f" at {bare(warm) - FREEZING:.4g} degC"
    return f"the pin has no play left{at}: its radial play would be {1e6 * clearance:.4g} um"


def _radius(radius: float, reader: FieldReader, table: Table, path: Path) -> float:
    """Radius of the bush [m], of a guide half of its width: by the fit, the contact, the block; nan if none says it."""
    if not math.isnan(bare(radius)):
        return radius
    contact, block = section(table, "contact"), section(table, "block")
    if "bush_radius" in contact:
        return reader.values.value(contact["bush_radius"], "m", (*path, "contact", "bush_radius"), "positive")
    if "height" in block:
        return reader.values.value(block["height"], "m", (*path, "block", "height"), "positive") / 2
    return radius


def _by_heat(reader: FieldReader, table: Table, read: Mapping[str, float | None], radius: float, path: Path) -> float:
    """By how much a bush and a pin that are warm have more play than at 20 degC [m]; 0 after a problem."""
    values, warm = reader.values, read["temperature"]
    pair = _materials(values, table, path)
    if warm is None:
        return 0.0
    if warm < COLDEST:
        values.wrong((*path, "temperature"), f'{bare(warm):g} K is too cold: a number is kelvin; write "80 degC"')
        return 0.0
    if not any(key in table for key in MATERIALS):
        values.wrong(path, "temperature needs bush_material and pin_material: play changes by their expansion")
    if math.isnan(bare(radius)):
        values.wrong(
            path,
            "temperature needs the radius of the bush: contact.bush_radius in m, a fit, or of a guide block.height",
        )
        return 0.0
    unknown = [material.name for material in pair if math.isnan(bare(material.expansion))]
    for name in dict.fromkeys(unknown):
        values.wrong(path, f"the thermal expansion of '{name}' is not known; give it under [materials.NAME]")
    if unknown or len(pair) < len(MATERIALS):
        return 0.0
    bush, pin = pair
    return radius * (bush.expansion - pin.expansion) * (warm - ROOM)


def _materials(values: Values, table: Table, path: Path) -> list[Material]:
    """Materials of bush and pin, both or none; fewer after a problem."""
    both = [key for key in MATERIALS if key in table]
    if len(both) == 1:
        other = ({*MATERIALS} - set(both)).pop()
        values.wrong(path, f"needs {other} too: play changes by the difference of both")
    named = (material_named(values, table[key], (*path, key)) for key in both)
    return [material for material in named if material is not None]


def _rolling(values: Values, joint: str, table: Table, kind: str, may: bool, path: Path) -> Play:
    """The play of a rolling bearing."""
    if "clearance" in table:
        values.wrong((*path, "bearing"), "a rolling bearing says the clearance; leave one of them out", at_key=True)
        return Play(math.nan)
    if not may:
        values.wrong((*path, "bearing"), f"a {kind} joint is no rolling bearing; leave it out", at_key=True)
        return Play(None)
    named = values.plays.get(joint)
    clearance = values.constants.get(f"{joint}.play", math.nan)
    if named is None:
        return Play(math.nan)
    if not clearance >= 0.0:
        values.wrong((*path, "bearing"), f"{joint}.play = {bare(clearance):g} m must not be negative")
        return Play(math.nan)
    return Play(clearance, math.nan, named.title)
