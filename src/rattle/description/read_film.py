"""Reading a lubricated contact: the oil film in a clearance, and the dry contact beside it."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace

from rattle import registry
from rattle.description.model import Choice, Contact, OilFilm
from rattle.description.read_fields import FieldReader
from rattle.description.read_oil import read_oil
from rattle.description.read_values import quoted
from rattle.description.reading import Path, Table
from rattle.description.tables import BUSH_RADIUS, FILM, OIL
from rattle.errors import suggest
from rattle.interfaces.contacts import ContactKind
from rattle.interfaces.fields import LawValues
from rattle.interfaces.laws import FilmLaw
from rattle.language.recorded import as_number

KEYS = (*OIL.fields, "bush_radius")  # of its table, besides fields of the model and of the film
STEEL = {"model": "hertz", "geometry": "johnson", "bush_material": "steel", "friction": 0.1}  # if `dry` is left out
ReadDry = Callable[[Table, Path], Contact | None]
Unused = Callable[[Collection[str]], tuple[str, ...]]


def film_keys() -> dict[str, registry.Field | None]:
    """Every key that a lubricated contact may have, with its field; None where it is none, or differs among films."""
    fields: dict[str, registry.Field | None] = dict.fromkeys(KEYS)
    oiled = [kind for kind in registry.kinds("contact").values() if kind.leaf.oiled]
    for kind in (*oiled, *registry.kinds("film").values()):
        fields |= {key: field for key, field in kind.fields.items() if key not in fields}
    return fields


def read_lubricated(
    reader: FieldReader, table: Table, kind: registry.Kind[ContactKind], clearance: float, path: Path, dry: ReadDry,
    unused: Unused,
) -> Contact | None:  # fmt: skip
    """A contact with oil; None after a problem.

    clearance [m]; dry: reads the table of a compliant contact in this joint; unused: checks the keys of other models
    and returns those that there are, given the keys that are used.
    """
    values, before = reader.values, len(reader.values.problems)
    oil, table = read_oil(reader, table, path)
    law = registry.kinds("film").get(reader.field(FILM, "film", table, {}, path))
    if law is None:
        return None
    left = unused(["model", *KEYS, *law.fields, *kind.fields])
    numbers = reader.fields(law, table, path)
    chosen = {
        key: _word(own, numbers[key]) if own.shape == "choice" else numbers[key] for key, own in law.fields.items()
    }
    rough = _roughness(reader, table, path)
    read: dict[str, float] = {"roughness": rough, "clearance": clearance}
    for key, field in kind.fields.items():
        read[key] = reader.field(field, key, table, read, path)
    if len(values.problems) > before:
        return None
    if not _fits(reader, law, chosen, read, table, path):
        return None
    contact, assumed = _dry(reader, table, chosen, path, dry)
    if contact is None:
        return None
    film = OilFilm(
        Choice(law.name, chosen), read["boundary_film"], rough or read["boundary_film"] / 3.0, read["density"],
        read["specific_heat"], assumed, oil,
    )  # fmt: skip
    left += tuple(f"dry.{key}" for key in contact.unused if not assumed)
    return replace(contact, model=kind.name, film=film, unused=left)


def _word(field: registry.Field, number: float) -> str:
    """The choice with this number; "" after a problem."""
    return "" if math.isnan(number) else field.choices[int(number)]


def _fits(
    reader: FieldReader, law: registry.Kind[FilmLaw], chosen: LawValues, read: Mapping[str, float],
    table: Table, path: Path,
) -> bool:  # fmt: skip
    """True if clearance, boundary film and film belong together; problems are reported otherwise."""
    values, clearance, least = reader.values, read["clearance"], read["boundary_film"]
    before = len(values.problems)
    if not clearance > 0.0:
        values.wrong(path, 'oil needs a clearance of the joint above 0; give one, or use contact = "ideal"')
        return False
    for fault in law.leaf.faults(chosen, clearance):
        values.wrong(path, fault)
    if not least < 0.5 * clearance:
        said_here = f"the boundary film of {least:.3g} m must be thinner than half the clearance of {clearance:.3g} m"
        key = next((key for key in ("boundary_film", "roughness") if key in table), "boundary_film")
        why = "" if key == "boundary_film" else " (3 times the roughness of both surfaces)"
        values.wrong((*path, key), said_here + why, at_key=True)
    return len(values.problems) == before


def _roughness(reader: FieldReader, table: Table, path: Path) -> float:
    """Roughness of both surfaces together [m]: root of the sum of squares of one number each, or of one for both."""
    if "roughness" not in table:
        return 0.0
    rough = reader.part(OIL.fields["roughness"], "roughness", table, path)
    total = math.hypot(*(rough if isinstance(rough, list) else [rough]))
    if total == 0.0:
        reader.values.wrong((*path, "roughness"), "must be positive; leave it out if it is not known")
    return total


def _dry(reader: FieldReader, table: Table, chosen: LawValues, path: Path, read: ReadDry) -> tuple[Contact | None, str]:
    """The dry contact, and in words what was assumed; None after a problem."""
    radius = as_number(chosen["bush_radius"])
    bush = {"bush_radius": radius}
    if "dry" not in table:
        return read({**STEEL, **bush, "length": chosen["length"]}, path), "steel on steel, friction 0.1"
    here, dry = (*path, "dry"), reader.part(OIL.fields["dry"], "dry", table, path)
    if dry is None:
        return None, ""
    laws = registry.kinds("normal")
    if not isinstance(dry.get("model"), str) or dry["model"] not in laws:
        words = f"dry needs the model of a compliant contact: {', '.join(laws)}"
        got = f", got {quoted(dry['model'])}{suggest(str(dry['model']), laws)}" if "model" in dry else ""
        reader.values.wrong(here, words + got)
        return None, ""
    if "bush_radius" in dry:
        again = reader.field(BUSH_RADIUS, "bush_radius", dry, {}, here)
        if abs(again - radius) > 1e-9 * radius:
            differs = f"is {again:g} m here and {radius:g} m for the film: leave it out here"
            reader.values.wrong((*here, "bush_radius"), differs, at_key=True)
            return None, ""
    return read({**dry, **bush}, here), ""
