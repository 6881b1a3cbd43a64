"""A document (nested tables from TOML or JSON) -> `Model`; all problems are reported together."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import fields
from itertools import filterfalse

from rattle.description.changes import NAMED
from rattle.description.coordinates import declare, definitions, forces, named_in_results, ordered, used_names
from rattle.description.massless import require_mass_at_contacts
from rattle.description.model import Driver, Initial, Model, Settings, State, Value, Vector, is_ground
from rattle.description.moving_points import drivers_of_point, moving_point
from rattle.description.read_duty import read_duty
from rattle.description.read_fields import FieldReader
from rattle.description.read_heat import read_heat
from rattle.description.read_materials import read_materials
from rattle.description.read_parameters import read_groups, read_parameters, read_signals
from rattle.description.read_parts import Parts
from rattle.description.read_states import declare_states, read_states
from rattle.description.read_tables import read_tables
from rattle.description.read_values import Chosen, TooManyProblems, Values, quoted
from rattle.description.reading import Path, Table, section
from rattle.description.tables import GROUND, MODEL, OFFSET, PICTURE, SIMULATE, START, STATE_UNITS
from rattle.errors import ModelError, suggest
from rattle.language.expression import ExpressionError, Node, Number, names, replaced, value
from rattle.language.units import dimension_of
from rattle.registry import REQUIRED

DEEPEST = 10  # nested tables and lists
SCALARS = (str, float, int, bool)


def read(document: Table, file: str = "", chosen: Mapping[str, Chosen] | None = None) -> Model:
    """Check a document and turn it into a `Model`.

    chosen: what stands for the values of some parameters, such as numbers that record what is computed with them.
    Raises ModelError with all problems, in the order of the document's tables.
    """
    values = Values(chosen)
    model = None
    try:
        if _is_plain(document, values):
            with values.at(()):
                model = _read(document, values)
    except TooManyProblems:
        pass
    if values.problems or model is None:
        raise ModelError(values.problems, file) from values.fault
    return model


def _is_plain(document: Table, values: Values) -> bool:
    """True if every key is a text and the nesting is not too deep."""
    waiting: list[tuple[Path, object]] = [((), document)]
    while waiting:
        path, written = waiting.pop()
        if len(path) > DEEPEST:
            values.wrong(path[:1], f"nested more than {DEEPEST} deep")
            return False
        if isinstance(written, Mapping):
            for key in written:
                if not isinstance(key, str):
                    values.wrong(path, f"the key {quoted(key)} is not a text")
                    return False
            waiting += [((*path, key), value) for key, value in written.items() if _holds(value)]
        elif isinstance(written, list | tuple):
            waiting += [((*path, k), value) for k, value in enumerate(written) if _holds(value)]
    return True


def _holds(written: object) -> bool:
    """True if something may be inside; the usual numbers and texts are told apart first, which is far quicker."""
    return type(written) not in SCALARS and isinstance(written, Mapping | list | tuple)


def _read(document: Table, values: Values) -> Model:
    """The whole model; it is valid only if no problem was found."""
    title = _header(document, values)
    tables = {key: _named(values, document, key) for key in NAMED}
    recording = {name: load for name, load in tables["loads"].items() if named_in_results(str(load.get("type")))}
    others = {key: document.get(key, {}) for key in ("signals", "states")}
    _one_namespace(values, {**tables, "loads": recording, **others})
    read_tables(values, document, early=True)
    parameters = read_parameters(values, document)
    read_tables(values, document, early=False)
    _tables_are_no_names(values, parameters, document)
    groups = read_groups(values, document)
    materials = read_materials(values, document)
    _enter_motion(values, tables["bodies"])
    declare(values, document)
    starts = declare_states(values, document)
    signals, units = read_signals(values, document)
    states = read_states(values, document, starts)
    parts = Parts(values)
    falls = parts.part(MODEL.fields["gravity"], "gravity", document, ()) or (0.0, 0.0)
    ground = values.table(document.get("ground", {}), ("ground",))
    points: Mapping[str, tuple[Value, Value]] = parts.form(GROUND, ground, ("ground",))["points"] or {}
    moving = _moving_names(values, signals, states)
    parts.ground = _ground(values, points, signals, moving)
    moving_points = {name: at for name, at in points.items() if any(isinstance(x, Node) for x in at)}
    _read_parts(parts, tables, moving_points)
    initial, settings = _initial(values, document, parts), _settings(parts, document)
    _picture(parts, document)
    duty = read_duty(values, document, parameters)
    heat = read_heat(parts, document, dict.fromkeys([*parts.joints, *sorted(parts.broken_joints)]))
    require_mass_at_contacts(values, parts.bodies, parts.joints)
    rates = [state.rate for state in states.values()]
    pulls, of_pulls = forces(parts.loads)
    of_loads = [value for load in parts.loads.values() for value in load.values]
    stand_for = definitions(
        {name: at for name, at in parts.ground.items() if name not in moving_points},
        parts.bodies, parts.joints, parts.loads,
        used_names(signals.values(), pulls.values(), rates, of_loads),
    )  # fmt: skip
    signals = ordered(values, signals, pulls, stand_for)
    for driver in parts.drivers.values():
        if not driver.moves_ground:
            path = ("drivers", driver.name, driver.key)
            _follow_time(values, "a driver", driver.value, path, moving, driver.leaf.rate_of)
    for k, component in enumerate(falls):
        _follow_time(values, "gravity", component, ("gravity", k), moving)
    gravity, falling = _gravity(values, falls, signals)
    states |= _travels(parts.drivers)
    return Model(
        title, gravity, parameters, signals, units | of_pulls, parts.ground, parts.bodies, parts.joints, parts.drivers,
        parts.loads, initial, settings, values.constants, tuple(values.remarks), groups, states, values.tables,
        stand_for, materials, values.named_materials, duty, heat, falling,
    )  # fmt: skip


def _enter_motion(values: Values, bodies: Iterable[str]) -> None:
    """Enter the names of the coordinates and velocities of bodies, with their dimensions."""
    for name in bodies:
        for key, unit in STATE_UNITS.items():
            values.live[f"{name}.{key}"] = None
            values.dimensions[f"{name}.{key}"] = dimension_of(unit)
            values.numbers.add(f"{name}.{key}")


def _read_parts(
    parts: Parts, tables: Mapping[str, Mapping[str, Table]], moving_points: Mapping[str, tuple[Value, Value]]
) -> None:
    """Read bodies, then joints, drivers and loads, which refer to them, and to points of the ground that move."""
    values = parts.values
    add = {"bodies": parts.add_body, "joints": parts.add_joint, "drivers": parts.add_driver, "loads": parts.add_load}
    for key, read_part in add.items():
        for name, table in tables[key].items():
            with values.at((key, name)):
                read_part(name, table)
            if key == "joints" and name not in parts.joints:
                parts.broken_joints.add(name)
        if key == "bodies" and not parts.bodies and not values.problems:
            values.wrong(("bodies",), "a mechanism needs at least one body")
        if key == "bodies":
            parts.bodies |= {body.name: body for body in map(moving_point, moving_points)}
    for name, at in moving_points.items():
        parts.drivers |= drivers_of_point(name, at)


def _header(document: Table, values: Values) -> str:
    """Check the keys and the format of the document; return its name."""
    values.keys(document, MODEL.fields, ())
    reader, table = FieldReader(values), {"format": REQUIRED, "name": "", **document}
    _, title = (reader.part(MODEL.fields[key], key, table, ()) for key in ("format", "name"))
    return str(title)


def _named(values: Values, document: Table, key: str) -> dict[str, Table]:
    """The table `key`, whose entries are tables with names chosen by the user."""
    entries = {}
    for name, entry in values.table(document.get(key, {}), (key,)).items():
        if isinstance(entry, Mapping):
            values.name(name, (key, name))
            entries[name] = entry
        else:
            values.wrong((key, name), f"expected a table, got {quoted(entry)}")
    return entries


def _one_namespace(values: Values, tables: Table) -> None:
    """Bodies, joints, drivers, signals, states and the loads that results know by name share one namespace."""
    seen: dict[str, str] = {}
    for table in ("bodies", "joints", "drivers", "signals", "states", "loads"):
        for name in section(tables, table):
            if name in seen:
                message = f"the name '{name}' is already used in [{seen[name]}]; choose another"
                values.wrong((table, name), message, at_key=True)
            seen.setdefault(name, table)


def _tables_are_no_names(values: Values, parameters: Iterable[str], document: Table) -> None:
    """Refuse a table that has the name of a parameter or signal."""
    others = {key: values.table(document.get(key, {}), (key,)) for key in ("signals", "states")}
    for name in values.curves:
        for other in (key for key, names_ in {"parameters": parameters, **others}.items() if name in names_):
            message = f"the name '{name}' is already used in [{other}]; choose another"
            values.wrong(("tables", name), message, at_key=True)


def _initial(values: Values, document: Table, parts: Parts) -> Initial:
    """The table [initial]: bodies and clearance joints."""
    bodies: dict[str, dict[str, float]] = {}
    offsets: dict[str, Vector] = {}
    play = [name for name, joint in parts.joints.items() if joint.contact is not None]
    for name, written in values.table(document.get("initial", {}), ("initial",)).items():
        path: Path = ("initial", name)
        entry = values.table(written, path)
        if name in parts.bodies and not is_ground(name):
            read = parts.form(START, entry, path)
            bodies[name] = {key: number for key, number in read.items() if number is not None}
        elif name in parts.joints or name in parts.broken_joints:
            values.keys(entry, OFFSET.fields, path)
            if name not in play and name not in parts.broken_joints:
                values.wrong(path, f"joint '{name}' has no clearance, so no offset", at_key=True)
            elif name in parts.joints and parts.joints[name].from_start:
                message = f"joint '{name}' has its play along the circumference, no pin with an offset; give angles"
                values.wrong(path, f"{message} of its bodies", at_key=True)
            elif name in parts.joints and parts.joints[name].one_sided is not None:
                message = f"joint '{name}' only pushes and has no pin with an offset; give places of its bodies"
                values.wrong(path, message, at_key=True)
            elif "offset" in entry:
                offsets[name] = parts.read(OFFSET, entry, path)["offset"]
        else:
            near = suggest(name, [*filterfalse(is_ground, parts.bodies), *play])
            values.wrong(path, f"no body or clearance joint {quoted(name)}{near}", at_key=True)
    return Initial(bodies, offsets)


def _settings(parts: Parts, document: Table) -> Settings:
    """The table [simulate]."""
    table = parts.values.table(document.get("simulate", {}), ("simulate",))
    read = parts.form(SIMULATE, table, ("simulate",))
    settings = (field.name for field in fields(Settings))
    return Settings(**{key: read[key] for key in settings if read[key] is not None})


def _picture(parts: Parts, document: Table) -> None:
    """The table [picture], of which only the studio makes use."""
    if "picture" in document:
        parts.form(PICTURE, parts.values.table(document["picture"], ("picture",)), ("picture",))


def _moving_names(values: Values, signals: Mapping[str, Node], states: Collection[str]) -> dict[str, str]:
    """Names of what changes with the motion or with a state, and why, in words."""
    moving = {name: "depends on the motion" for name in values.live if "." in name}
    moving |= dict.fromkeys(states, "is a state")
    for name, node in signals.items():  # in order of evaluation
        if names(node) & moving.keys():
            moving[name] = "depends on the motion"
    return moving


def _follow_time(
    values: Values, what: str, function: Value, path: Path, moving: Mapping[str, str], integrated: str = ""
) -> None:
    """Refuse a function that depends on the motion or a state: its exact time derivatives would not be known.

    integrated: what is the integral of the function, in words; "" if nothing.
    """
    if isinstance(function, float):
        return
    remedy = "; use [states] and a load for a speed that is controlled" if integrated else ""
    for word in sorted(names(function) & moving.keys()):
        values.wrong(path, f"{what} must depend on time only, but '{word}' {moving[word]}{remedy}")


def _travels(drivers: Mapping[str, Driver]) -> dict[str, State]:
    """How far drivers have come whose speed is given, as states."""
    travels = {}
    for driver in drivers.values():
        if driver.travel:
            rate = Number(driver.value, 0) if isinstance(driver.value, float) else driver.value
            travels[driver.travel] = State(driver.travel, rate, 0.0, driver.leaf.rows[0], travel=True)
    return travels


def _gravity(
    values: Values, components: tuple[Value, Value], signals: Mapping[str, Node]
) -> tuple[Vector, tuple[Node, Node] | None]:
    """Gravity at t = 0 [m/s^2], and as a function of t alone; None if it does not change."""
    x, y = (_of_time(component, signals) for component in components)
    at_start = _at_start(values, x, ("gravity", 0)), _at_start(values, y, ("gravity", 1))
    if isinstance(x, float) and isinstance(y, float):
        return at_start, None
    first, second = (Number(node, 0) if isinstance(node, float) else node for node in (x, y))
    return at_start, (first, second)


def _ground(
    values: Values, points: Mapping[str, tuple[Value, Value]], signals: Mapping[str, Node], moving: Mapping[str, str]
) -> dict[str, Vector]:
    """Places of the points of the ground at t = 0 [m]."""
    places = {}
    for name, coordinates in points.items():
        at = []
        for k, coordinate in enumerate(coordinates):
            path = ("ground", "points", name, k)
            _follow_time(values, "a point of the ground", coordinate, path, moving)
            at.append(_at_start(values, _of_time(coordinate, signals), path))
        places[name] = at[0], at[1]
    return places


def _of_time(function: Value, signals: Mapping[str, Node]) -> Value:
    """A function of time without the names of signals."""
    if isinstance(function, float):
        return function
    written: dict[str, Node] = {}
    for name, node in signals.items():  # in order of evaluation
        written[name] = replaced(node, written)
    return replaced(function, written)


def _at_start(values: Values, function: Value, path: Path) -> float:
    """Value of a function of time at t = 0 [SI]; nan after a problem."""
    if isinstance(function, float) or values.problems:
        return function if isinstance(function, float) else math.nan
    try:
        return value(function, {**values.constants, "t": 0.0}, values.tables)
    except ExpressionError as error:
        values.in_expression(error, path)
        return math.nan
