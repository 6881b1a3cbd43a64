"""What would help most: the life with one size larger, computed anew."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rattle.errors import InputError, SolverError
from rattle.language.recorded import bare
from rattle.mechanism import Mechanism
from rattle.questions.durability.rows import WORN, rows_of

STEP = 1.2  # of sizes as they are made: 10, 12, 15, 18, 22, 26 mm
DIGITS = 2  # of a larger size in mm
OF_SECTION = {"rectangle": "height", "round": "diameter", "tube": "diameter"}  # what counts for bending in the plane


def advice(m: Mechanism, name: str, what: str, hours: float) -> str:
    """A size of the part that fails first, larger by STEP, and how long it lasts then; "" where there is none."""
    if what != WORN and name in m.model.joints:  # a rolling bearing, whose capacity its catalogue says
        return ""
    place = _bearing(m, name) if what == WORN else _section(m, name)
    if place is None:
        return ""
    path, called, size = place
    more = _rounded_up(size * STEP)
    try:
        row = next(row for row in rows_of(m.set({path: more})).rows if row.name == name)
    except (InputError, SolverError):  # larger than what it has to fit into, or another motion
        return ""
    life = row.wear_life if what == WORN else row.fatigue_life
    lasts = "for ever" if math.isinf(life) else f"{life / hours:.3g} times as long, {life:.4g} h"
    return f"{called} of {1e3 * more:g} instead of {1e3 * size:.4g} mm: {name} lasts {lasts}"


def _bearing(m: Mechanism, name: str) -> tuple[str, str, float] | None:
    """The length of a bearing: its path in the model, what it is called, and how large it is [m]."""
    written = m._document["joints"][name]
    places = {"length": written, "contact.length": _table(written.get("contact"))}
    for path, table in places.items():
        if "length" in table:
            return f"joints.{name}.{path}", "a bearing", bare(m.model.joints[name].length)
    return None


def _section(m: Mechanism, name: str) -> tuple[str, str, float] | None:
    """The size of a section that counts for bending in the plane, as `_bearing`."""
    if neck := name.partition(".")[2]:
        name = name.removesuffix(f".{neck}")
        sheet = m.model.bodies[name].sheet
        return (f"bodies.{name}.thickness", "a thickness", bare(sheet.thickness)) if sheet is not None else None
    section = _table(m._document["bodies"][name].get("section"))
    key = OF_SECTION.get(str(section.get("shape")))
    beam = m.model.bodies[name].beam
    if key is None or beam is None or beam.section is None or math.isnan(beam.section.height):
        return None
    return f"bodies.{name}.section.{key}", f"a {key}", bare(beam.section.height)


def _table(written: object) -> Mapping[str, Any]:
    return written if isinstance(written, Mapping) else {}


def _rounded_up(size: float) -> float:
    """A size [m] with DIGITS digits in mm, not smaller."""
    decade = 10.0 ** (math.floor(math.log10(1e3 * size)) + 1 - DIGITS)
    return math.ceil(1e3 * size / decade - 1e-9) * decade / 1e3
