"""Names of expressions that follow from the state of the bodies: points, coordinates of joints and loads.

    <body>.<point>.x .y .vx .vy        a point in the ground frame and its velocity
    <joint>.angle .rate                where `coordinate` of the joint's kind is "angle": B relative to A
    <joint>.position .rate             where it is "position": of B's point along the line of A; "distance": of a rope
    <load>.length .rate .force .power  of a load with a `record`, see `interfaces.loads.LoadRecord`; `.slack` of a cord
    <load>.fx                          and other `quantities` of its kind

Each stands for an expression over the state, but `<load>.force`, `<load>.slack` and quantities, which a run evaluates
and records as signals.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cache

from rattle import registry
from rattle.description.dependence import describe_cycle, in_order
from rattle.description.model import NUMBERS, Body, Joint, Load, Point, Vector
from rattle.description.read_values import Values
from rattle.description.reading import Table
from rattle.interfaces.loads import LoadRecord
from rattle.language.expression import Apply, Name, Node, Number, names, parse, replaced, walk
from rattle.language.units import dimension_of

POINT = {
    "x": ("m", "B.x + px*cos(B.angle) - py*sin(B.angle)"),
    "y": ("m", "B.y + px*sin(B.angle) + py*cos(B.angle)"),
    "vx": ("m/s", "B.vx - B.omega*(px*sin(B.angle) + py*cos(B.angle))"),
    "vy": ("m/s", "B.vy + B.omega*(px*cos(B.angle) - py*sin(B.angle))"),
}
ACROSS = "hypot(b.x - a.x, b.y - a.y)"
COINCIDENT = 1e-150  # m: ends nearer than this have no direction, and a rate of 0, the mean of before and after
SPREADING = ("rate", "m/s", f"((b.x - a.x)*(b.vx - a.vx) + (b.y - a.y)*(b.vy - a.vy))/hypot({ACROSS}, {COINCIDENT})")
COORDINATES = {  # key and unit of a coordinate and of its rate, and what they are between points a and b of A and B
    "angle": (("angle", "rad", "B.angle - A.angle"), ("rate", "rad/s", "B.omega - A.omega")),
    "length": (("length", "m", ACROSS), SPREADING),
    "distance": (("position", "m", ACROSS), SPREADING),
    "position": (
        ("position", "m", "(b.x - a.x)*cos(A.angle + axis) + (b.y - a.y)*sin(A.angle + axis)"),
        (
            "rate",
            "m/s",
            "(b.vx - a.vx)*cos(A.angle + axis) + (b.vy - a.vy)*sin(A.angle + axis)"
            " + A.omega*((b.y - a.y)*cos(A.angle + axis) - (b.x - a.x)*sin(A.angle + axis))",
        ),
    ),
}
STATE = ("x", "y", "angle", "vx", "vy", "omega")
NOTHING, WHOLE = Number(0.0, 0), Number(1.0, 0)  # rates and angle of the ground, and the cosine of that


# ---------------------------------------------------------------- before anything is read: names and their units
def declare(values: Values, document: Table) -> None:
    """Enter the names that a document with these bodies, joints and loads has, with their dimensions."""
    units = _units_of_points(document)
    for name, entry in _entries(document, "joints"):
        kind = registry.kinds("joint").get(str(entry.get("type")))
        if kind is None:
            continue
        coordinate = kind.leaf.coordinate or (kind.leaf.stops if "stop" in entry else "")
        if coordinate:
            units |= {f"{name}.{key}": unit for key, unit, _ in COORDINATES[coordinate]}
    for name, entry in _entries(document, "loads"):
        units |= {f"{name}.{key}": unit for key, unit in _units_of_load(entry).items()}
    for name, unit in units.items():
        values.live.setdefault(name)
        values.numbers.add(name)
        values.dimensions[name] = dimension_of(unit)


def _units_of_load(entry: Table) -> dict[str, str]:
    """Units of what is known of a load, by key."""
    kind = registry.kinds("load").get(str(entry.get("type")))
    if kind is None:
        return {}
    record, units = kind.leaf.record, {key: quantity.unit for key, quantity in kind.leaf.quantities.items()}
    if record is not None:
        units |= {"length": "rad", "rate": "rad/s"} if record.coordinate == "angle" else {}
        units |= {key: unit for key, unit, _ in COORDINATES[record.coordinate]}
        units |= {"force": record.unit, "power": "W"}
        units |= {"torque": record.unit} if record.coordinate == "angle" else {}
        units |= {"slack": ""} if record.one_sided is not None and entry.get(record.one_sided.flag) is True else {}
    return units


def _units_of_points(document: Table) -> dict[str, str]:
    """Units of what stands for the points of bodies and of the ground, by name."""
    units: dict[str, str] = {}
    for body, entry in _entries(document, "bodies"):
        ends, points = entry.get("bar", ()), entry.get("points", {})
        listed = (*(ends if isinstance(ends, list | tuple) else ()), *(points if isinstance(points, Mapping) else ()))
        for point in listed:
            units |= {f"{body}.{point}.{key}": unit for key, (unit, _) in POINT.items()}
    ground = document.get("ground", {})
    fixed = ground.get("points", {}) if isinstance(ground, Mapping) else {}
    for point in fixed if isinstance(fixed, Mapping) else ():
        units |= {f"ground.{point}.{key}": unit for key, (unit, _) in POINT.items()}
    return units


def _entries(document: Table, table: str) -> list[tuple[str, Table]]:
    entries = document.get(table, {})
    listed = entries.items() if isinstance(entries, Mapping) else ()
    return [(name, entry) for name, entry in listed if isinstance(entry, Mapping)]


def record_of(kind: str) -> LoadRecord | None:
    """What a kind of load records; None if it has none or is not known."""
    registered = registry.kinds("load").get(kind)
    return registered.leaf.record if registered is not None else None


def named_in_results(kind: str) -> bool:
    """True if results and expressions know a load of this kind by its name."""
    registered = registry.kinds("load").get(kind)
    return registered is not None and (registered.leaf.record is not None or bool(registered.leaf.quantities))


# ---------------------------------------------------------------- what the names stand for
def definitions(
    ground: Mapping[str, Vector], bodies: Mapping[str, Body], joints: Mapping[str, Joint], loads: Mapping[str, Load],
    used: Iterable[str],
) -> dict[str, Node]:  # fmt: skip
    """What these names stand for, as expressions over the state and over `<load>.force`; other names are left out."""
    nodes: dict[str, Node] = {}
    for name in used:
        owner, _, key = name.partition(".")
        point, _, axis = key.partition(".")
        if axis in POINT and owner in bodies and point in bodies[owner].points:
            nodes[name] = _point(Point(owner, point, bodies[owner].points[point]), axis)
        elif owner == "ground" and point in ground:
            nodes[name] = _point(Point("ground", point, ground[point]), axis)
        elif owner in joints and joints[owner].coordinate:
            joint = joints[owner]
            line = 0.0 if joint.line is None else joint.line
            nodes |= _between(owner, joint.coordinate, joint.a, joint.b, line, key)
        elif owner in loads and (record := record_of(loads[owner].kind)) is not None:
            nodes |= _of_load(owner, loads[owner], record, key)
    return nodes


def _of_load(owner: str, load: Load, record: LoadRecord, key: str) -> dict[str, Node]:
    """One name of a load."""
    if key == "power":
        rate = _between(owner, record.coordinate, load.a, load.b, 0.0, "rate")[f"{owner}.rate"]
        sign = Number(record.power, 0)
        return {f"{owner}.power": replaced(_tree("s*f*r"), {"s": sign, "f": Name(f"{owner}.force", 0), "r": rate})}
    if key == "torque":
        return {f"{owner}.torque": Name(f"{owner}.force", 0)}
    first = record.coordinate if key == "length" else key
    nodes = _between(owner, record.coordinate, load.a, load.b, 0.0, first)
    return {f"{owner}.{key}": node for node in nodes.values()}


def forces(loads: Mapping[str, Load]) -> tuple[dict[str, Node], dict[str, str]]:
    """What a run records of loads: `<load>.force`, `<load>.slack`, quantities of kinds; expressions and their units."""
    nodes: dict[str, Node] = {}
    units: dict[str, str] = {}
    for name, load in loads.items():
        leaf = registry.kinds("load")[load.kind].leaf
        if leaf.record is None and not leaf.quantities:
            continue
        parts = {**_state_between(load.a, load.b, 0.0), **_fields_of(load)}
        for key, quantity in leaf.quantities.items():
            nodes[f"{name}.{key}"], units[f"{name}.{key}"] = _filled(quantity.formula, parts), quantity.unit
        if leaf.record is not None:
            where = _between(name, leaf.record.coordinate, load.a, load.b, 0.0, "")
            parts |= {key.partition(".")[2]: node for key, node in where.items()}
            for key, (text, unit) in _texts(load, leaf.record).items():
                nodes[f"{name}.{key}"], units[f"{name}.{key}"] = _filled(text, parts), unit
    return nodes, units


def _texts(load: Load, record: LoadRecord) -> dict[str, tuple[str, str]]:
    """What is recorded of a load with a record, over its fields and its coordinate, and in which units."""
    if load.slack is None or record.one_sided is None:
        return {"force": (record.force, record.unit)}
    force = f"({record.force})*(1 - {record.one_sided.flag}) + 0"  # not -0
    return {"slack": (record.one_sided.slack, ""), "force": (force, record.unit)}


def _fields_of(load: Load) -> dict[str, Node]:
    """Values of the fields of a load by name; those of three numbers by `<field>.x .y .angle`."""
    shapes = {key: field.shape for key, field in registry.kinds("load")[load.kind].fields.items()}
    parts: dict[str, Node] = {}
    for key, values in load.fields.items():
        names = [f"{key}.{part}" for part in ("x", "y", "angle")] if shapes[key] == "triple" else [key]
        if shapes[key] == "triple" or shapes[key] not in NUMBERS:
            pairs = zip(names, values, strict=True)
            parts |= {part: value if isinstance(value, Node) else Number(value, 0) for part, value in pairs}
    return parts


def ordered(
    values: Values, signals: Mapping[str, Node], forces: Mapping[str, Node], meanings: Mapping[str, Node]
) -> dict[str, Node]:
    """Signals and forces of loads so that each follows those it uses; a problem names those that form a loop.

    meanings: what the other names stand for.
    """
    every = {**signals, **forces}
    order, cycles = in_order({name: replaced(node, meanings) for name, node in every.items()})
    for cycle in cycles:
        name = cycle[0]
        path = ("signals", name) if name in signals else ("loads", name.partition(".")[0])
        values.wrong(path, describe_cycle(cycle))
    return {name: every[name] for name in order}


@cache
def _tree(text: str) -> Node:
    return parse(text)


def _filled(text: str, parts: Mapping[str, Node]) -> Node:
    """A formula with its names replaced, without what the rest of the ground leaves of it."""
    stack: list[Node] = []
    for part in walk(_tree(text)):
        if isinstance(part, Apply):
            operands = stack[-len(part.operands) :]
            del stack[-len(operands) :]
            stack.append(_at_rest(part.name, operands) or replace(part, operands=tuple(operands)))
        else:
            stack.append(parts.get(part.name, part) if isinstance(part, Name) else part)
    return stack[0]


def _at_rest(name: str, operands: list[Node]) -> Node | None:
    """What an operation comes to where an operand is NOTHING or WHOLE; None if it has to be done."""
    first, last = operands[0], operands[-1]
    if name == "*" and (first is NOTHING or last is NOTHING):
        return NOTHING
    if name == "*" and (first is WHOLE or last is WHOLE):
        return last if first is WHOLE else first
    if name in ("+", "-") and last is NOTHING:
        return first
    if name == "+" and first is NOTHING:
        return last
    return {"sin": NOTHING, "cos": WHOLE}.get(name) if first is NOTHING else None


def _point(point: Point, axis: str) -> Node:
    """A coordinate of a point, or of its velocity."""
    x, y = point.at
    if point.body == "ground":
        return Number({"x": x, "y": y}[axis], 0) if axis in ("x", "y") else NOTHING
    state = {f"B.{key}": Name(f"{point.body}.{key}", 0) for key in STATE}
    return replaced(_tree(POINT[axis][1]), {**state, "px": Number(x, 0), "py": Number(y, 0)})


def _between(owner: str, coordinate: str, a: Point, b: Point, axis: float, key: str) -> dict[str, Node]:
    """The coordinate between two points and its rate, by name; only that of `key` if it is not empty."""
    parts = _state_between(a, b, axis)
    wanted = [entry for entry in COORDINATES[coordinate] if key in ("", entry[0])]
    return {f"{owner}.{name}": _filled(text, parts) for name, _, text in wanted}


def _state_between(a: Point, b: Point, axis: float) -> dict[str, Node]:
    """What formulas between two points are over: the state of A and B, the points, the direction of a line."""
    parts: dict[str, Node] = {"axis": Number(axis, 0)}
    for letter, point in (("A", a), ("B", b)):
        ground = point.body == "ground"
        parts |= {f"{letter}.{name}": NOTHING if ground else Name(f"{point.body}.{name}", 0) for name in STATE}
        parts |= {f"{letter.lower()}.{name}": _point(point, name) for name in POINT}
    return parts


def used_names(*trees: Iterable[object]) -> set[str]:
    """Names in the expressions among some values."""
    return {name for group in trees for value in group if not isinstance(value, float | int) for name in _names(value)}


def _names(value: object) -> set[str]:
    return names(value) if isinstance(value, Node) else set()
