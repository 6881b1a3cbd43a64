"""Reference to the model file besides the kinds of the registry: tables, names, functions, units, materials.

Descriptions come from the JSON Schema, numbers from the tables that the reader uses.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rattle import registry
from rattle.description.coordinates import POINT
from rattle.description.schema import joint_entry, part, schema
from rattle.description.schema_pieces import Schema
from rattle.description.tables import BODY_TO_DRIVE, DRIVER, JOINT, JOINT_TO_DRIVE, MODEL, STATE_UNITS
from rattle.language.composed import COMPOSED
from rattle.language.materials import MATERIALS
from rattle.language.operations import FUNCTIONS, record_of
from rattle.language.units import DIMENSIONLESS, UNITS, Dimension, describe


class Topic(NamedTuple):
    """A topic to look up: its name, one sentence, and what may be written, line by line."""

    name: str
    summary: str
    lines: tuple[str, ...]


def topics() -> dict[str, Topic]:
    """All topics by name."""
    tables: Schema = schema()["properties"]
    every = [_table(name, tables[name]) for name in TABLES]
    every += [_wear(tables["joints"]), _names(), _functions(), _units(), _materials(tables["materials"])]
    return {topic.name: topic for topic in every}


TABLES = tuple(key for key in MODEL.fields if key not in ("format", "name", "materials", "joints", "drivers", "loads"))


def common(family: str, kind: str) -> list[str]:
    """The keys that every entry of a family may have besides the fields of its kind, with their units."""
    if family == "joint":
        entry: Schema = joint_entry(registry.kinds("joint")[kind], JOINT)["properties"]
        without = {*OWN_LINES, *registry.kinds("joint")[kind].fields}
        return [_line(key, entry[key]) for key in JOINT.fields if key in entry and key not in without] + (
            _dimensions(kind) + _stop(kind)
        )
    if family == "driver":
        words = f"joint (name): {JOINT_TO_DRIVE.meaning}"
        if registry.kinds("driver")[kind].leaf.drives == "body":
            where = f'coordinate = "{kind.removeprefix("body-")}"'
            words = f'body (name, or "body.point"): {BODY_TO_DRIVE.meaning}, with {where}'
        return [words, *(_line(key, part(entry)) for key, entry in DRIVER.fields.items())]
    return []


OWN_LINES = ("stop", "friction")  # keys of joints: told below, and with the laws of friction


def _dimensions(joint: str) -> list[str]:
    """Tables of lengths that a joint with play has, a line each."""
    play = registry.play_of(joint)
    if play is None:
        return []
    return [
        f"{table} {{ {', '.join(f'{key} [{field.unit}]' for key, field in wanted.items())} }}:"
        f" the {table} of a {play.leaf.bearer} with clearance"
        for table, wanted in play.leaf.dimensions.items()
    ]


def _stop(joint: str) -> list[str]:
    """The ends of the coordinate of a joint, as a line; none if it has no coordinate."""
    kind = registry.stop_of(joint)
    if kind is None:
        return []
    ends = ", ".join(f"{key} [{field.unit}]" for key, field in kind.fields.items())
    return [f"stop {{ {ends}, contact }}: one-sided ends of its coordinate ({kind.name})"]


def _table(name: str, table: Schema) -> Topic:
    """A table of the model file."""
    entry = table.get("additionalProperties") or table
    lines = [_line(key, value) for key, value in _keys(entry)] or [_line(name, entry)]
    return Topic(name, table.get("description", f"the table [{name}]"), tuple(dict.fromkeys(lines)))


def _keys(entry: Schema) -> Iterator[tuple[str, Schema]]:
    """The keys of a table, in all ways to write it."""
    yield from entry.get("properties", {}).items()
    for variant in entry.get("anyOf", ()):
        yield from _keys(variant)


def _wear(joints: Schema) -> Topic:
    """The table `wear` of a joint."""
    variants = (variant["properties"] for variant in joints["additionalProperties"]["anyOf"])
    entry = next(properties["wear"] for properties in variants if "wear" in properties)
    lines = [_line(key, value) for key, value in entry["properties"].items()]
    return Topic("wear", f"wear = {{ ... }} of a joint: {entry['description']}", tuple(lines))


def _line(key: str, piece: Schema) -> str:
    words = [str(word).lower() if isinstance(word, bool) else word for word in piece.get("enum", ())]
    choices = f" ({' | '.join(words)})" if words else ""
    return f"{key}: {piece.get('description', 'a number or a text')}{choices}"


def _names() -> Topic:
    lines = [f"<body>.{key} [{unit}]" for key, unit in STATE_UNITS.items()]
    lines += [f"<body>.<point>.{key} [{unit}]" for key, (unit, _) in POINT.items()]
    lines += ["<joint>.angle [rad] .rate [rad/s] of a revolute joint: B relative to A, not wrapped"]
    lines += ["<joint>.position [m] .rate [m/s] of a prismatic joint or slot: B's point along the line from A's"]
    lines += [
        "<load>.length [m] .rate [m/s] .force [N] .power [W] of a spring or actuator: force pulls (spring), pushes"
    ]
    lines += [
        "<load>.angle [rad] .rate [rad/s] .torque [N*m] .power [W] of a torsion spring or motor; also .length .force"
    ]
    lines += ["<load>.slack of a spring with tension_only: 1 where it is slack, 0 elsewhere"]
    lines += ["<load>.fx .fy [N] .torque [N*m] of a bushing: on its second body at its point, in the ground frame"]
    lines += [
        "t [s]: the time",
        "pi",
        "<table>(x): every table, with one argument",
        "every parameter; every signal and state defined in the file",
    ]
    where = (
        "in loads, signals and rates of states all of these; in drivers t, parameters, and signals over them;"
        " elsewhere parameters only"
    )
    return Topic("names", f"names in expressions: {where}", tuple(lines))


def _functions() -> Topic:
    lines = []
    for name, count in FUNCTIONS.items():
        record = record_of(name)
        arguments = record.arguments or ("x" if count == 1 else "x, y" if count > 0 else "x, y, ...")
        meaning = f"the same as {record.name}" if name != record.name else record.meaning
        lines.append(f"{name}({arguments}){f': {meaning}' * bool(meaning)}")
    lines += [f"{name}({', '.join(record.variables)}): {record.meaning}" for name, record in COMPOSED.items()]
    lines += ["a if x < y else b: also with <= > >=, and with conditions joined by and, or, not", "+ - * / ** ( )"]
    return Topic("functions", "functions and operators of expressions; angles in rad", tuple(lines))


def _units() -> Topic:
    by_dimension: dict[Dimension, list[str]] = {}
    for unit, (_, dimension) in UNITS.items():
        by_dimension.setdefault(dimension, []).append(unit)
    lines = [
        f"{describe(dimension) if dimension != DIMENSIONLESS else 'an angle'}: {' '.join(units)}"
        for dimension, units in by_dimension.items()
    ]
    meaning = (
        'units of quantities; products and powers of them too: "N*s/m", "kg*m^2"; 60 degC is 333.15 K, in products and'
        " quotients a degC is a kelvin"
    )
    return Topic("units", meaning, tuple(lines))


def _materials(table: Schema) -> Topic:
    lines = [f"{name}: E = {m.E / 1e9:g} GPa, nu = {m.nu:g} ({m.source})" for name, m in MATERIALS.items()]
    lines += [f"{key} of your own: {line}" for key, line in _own_keys(table)]
    meaning = "materials of bushes, pins and bars by name; of your own under [materials.NAME], or { E = ..., nu = ... }"
    return Topic("materials", meaning, tuple(lines))


def _own_keys(table: Schema) -> Iterator[tuple[str, str]]:
    """The keys of a material that a model defines, with their meanings."""
    for key, piece in _keys(table["additionalProperties"]):
        yield key, str(piece.get("description", ""))
