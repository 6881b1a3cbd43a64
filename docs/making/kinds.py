"""Every kind of joint, driver, contact, law and load, as the catalogue has it, and what else a model file may hold.

Each has an example, made from its fields and read by the program: a build with an example that is refused fails.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import rattle as rt
from making.text import blocks, code, fence, paragraph, table
from making.tree import PACKAGE, module_with, sources

FAMILIES = {
    "joint": ("Joints", "`[joints.NAME]` with `type`: what holds two bodies together."),
    "driver": ("Drivers", "`[drivers.NAME]`: a degree of freedom that follows a function of time."),
    "clearance": (
        "Joints with clearance",
        "What a joint becomes with `clearance`: pin (journal) in bush (bushing, bearing), block in guide, pin in slot.",
    ),
    "stop": (
        "Stops",
        "`stop = { min, max, contact }` of a joint: one-sided ends of its coordinate, either of which may be left out.",
    ),
    "one-sided": (
        "One-sided joints",
        "What a cam, flat follower or gear becomes with `contact`: surfaces that only push; strands only pull.",
    ),
    "clutch": (
        "Contacts of clutches",
        "What the `model` of a `clutch` becomes; compliant and viscous ones overrun too.",
    ),
    "tangent": ("Slip of surfaces", "Along what the `friction` of a cam, a flat follower or teeth acts."),
    "contact": (
        "Contact models",
        "`contact = NAME` or `contact = { model = NAME, ... }` of a joint with clearance or of its `stop`.",
    ),
    "normal": ("Normal force laws", "Also a `model` of `contact`: elastic pin and bush."),
    "stiffness": ("Stiffness", "`geometry` in `contact`: static force from material and shape; `power` from numbers."),
    "worn": (
        "Worn surfaces",
        "What a pin in a bush becomes with the profiles of its `wear`: an elastic foundation between them.",
    ),
    "tension": ("Tension laws", "What the strands of a `belt` follow; it is not chosen."),
    "friction": ("Friction laws", "`friction = { model = NAME, ... }` in the `contact` of a normal force law."),
    "film": (
        "Oil films",
        "`film` in a lubricated `contact`; `model` of `rt.Film` and `rattle film`, with `bush_radius` as `radius`.",
    ),
    "load": ("Loads", "`[loads.NAME]` with `type`: forces and moments on bodies."),
    "stepper": ("Steppers", "`method` in `[simulate]`, or `--method`: how the motion is computed."),
}
FRAME = """format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.link]
bar = ["P", "Q"]
length = "200 mm"
mass = 0.5
"""
WITH_CONTACT = {"restitution": 0.5, "friction": '0.1, bush_radius = "10 mm"'}  # what a contact model may need
VALUES = {  # values of fields in examples, by unit
    "m": "20 mm", "rad": "30 deg", "N": "10 N", "N*m": "2 N*m", "N/m": "2 kN/m", "N*m/rad": "5 N*m/rad",
    "N*s/m": "20 N*s/m", "m/s": "1 mm/s", "Pa": "200 GPa", "": 0.5, "1/m": 1e4, "N/m^exponent": 1e9, "Pa/m": "7 GPa/mm",
}  # fmt: skip


SIZES = {  # of kinds whose lengths have to suit each other
    "rolling": {"elements": 9, "element_stiffness": 8e9},
    "locking-disc": {"radius": "30 mm", "arcs": 4, "axle_distance": "70.71 mm", "rim": "50 mm", "play": "0.1 mm"},
}
PLATE = """[bodies.plate]
polygon = [["0 mm", "0 mm"], ["60 mm", "0 mm"], ["60 mm", "20 mm"], ["0 mm", "20 mm"]]
mass = 0.2
points = { P = ["0 mm", "0 mm"] }
"""
ON_LINE = ['axis = "0 deg"']
SURFACES = {  # what tells one contact of a surface from another
    "on-line": ON_LINE, "on-segment": [*ON_LINE, 'length = "1 m"', 'roller = "20 mm"'],
    "over-segment": [*ON_LINE, 'length = "1 m"'], "on-disc": ['radius = "50 mm"', 'roller = "20 mm"'],
    "in-hollow": ['radius = "50 mm"', "hollow = true", 'roller = "20 mm"'],
    "by-outline": ['radius = "50 mm"', "outline = true"],
}  # fmt: skip
CONTACT = 'contact = { model = "impact", restitution = 0.5 }'


def pages(folder: Path) -> dict[str, str]:
    """One page for all kinds, one for the other tables and names of a model file."""
    catalog = module_with("kind", "kinds", "families")
    return {"kinds": _kinds(catalog), "tables": _tables()}


def _kinds(catalog: Any) -> str:
    parts = []
    for family in sorted(catalog.families(), key=lambda one: [*FAMILIES, one].index(one)):
        title, words = FAMILIES.get(family, (family.capitalize(), ""))
        parts += [f"## {title}", words]
        own = [one for one in catalog.kinds(family).values() if one.leaf.__module__.startswith("rattle.")]
        for kind in own:
            parts.append(_kind(catalog, kind))
        parts += [_derivation(module) for module in dict.fromkeys(one.leaf.__module__ for one in own)]
    return "\n\n".join(part for part in parts if part) + "\n"


def _kind(catalog: Any, kind: Any) -> str:
    path = Path(inspect.getfile(kind.leaf)).relative_to(PACKAGE)
    line = inspect.getsourcelines(kind.leaf)[1]
    words = "\n\n".join(
        fence("\n".join(lines)) if plain else paragraph(" ".join(lines))
        for plain, lines in blocks("\n".join(_without_source(kind.leaf.__doc__ or "")))
    )
    rows = [
        (code(key), unit_of(one), paragraph(one.meaning) + _live(one, kind.family), default_of(one, catalog.REQUIRED))
        for key, one in kind.fields.items()
    ]
    rows = _common(catalog, kind) + rows
    shown = example(catalog, kind)
    return "\n\n".join(
        part
        for part in (
            f"### {kind.name}",
            words,
            table(("field", "unit", "meaning", "default"), rows) if rows else "",
            fence(shown, "toml") if shown else "",
            f"*Source:* {paragraph(_source(kind.leaf.__doc__ or ''))} *Code:* `{path.as_posix()}`, line {line}.",
        )
        if part
    )


def _common(catalog: Any, kind: Any) -> list[tuple[str, ...]]:
    """Fields that every entry of the family may have; clearance only if some contact model fits the joint."""
    lines = (one.partition(": ") for one in module_with("common", "topics").common(kind.family, kind.name))
    stiff = kind.family == "joint" and catalog.play_of(kind.name) is None
    return [
        (code(key), "", paragraph(said), "")
        for key, _, said in lines
        if not (stiff and key in ("clearance", "contact"))
    ]


def _without_source(text: str) -> list[str]:
    lines = inspect.cleandoc(text).splitlines()
    first = next((n for n, line in enumerate(lines) if line.startswith("Source:")), len(lines))
    return [line + "\n" if line.startswith("Range:") else line for line in lines[:first]]


def _source(text: str) -> str:
    return " ".join(inspect.cleandoc(text).partition("Source:")[2].split())


def _derivation(module: str) -> str:
    source = sources()[module]
    return f":::{{dropdown}} Derivation: `{source.shown}`\n{fence(source.text)}\n:::"


def unit_of(field: Any) -> str:
    """Unit of a field, or what is written in its place."""
    if field.shape == "choice":
        return " ".join(code(one) for one in field.choices)
    if field.shape == "pair":
        return f"[{field.unit}, {field.unit}]" if field.unit else "two numbers"
    if field.shape == "triple":
        return f"[{field.unit}, {field.unit}, {field.turning}]"
    if field.shape == "flag":
        return f"{code('true')} {code('false')}"
    return field.unit or ("–" if field.shape == "number" else field.shape)


def default_of(field: Any, required: Any) -> str:
    """Default and limits."""
    limit = f"; {field.least}" if field.least else ""
    if field.default is required:
        return f"needed{limit}"
    if callable(field.default):
        return f"follows from other fields{limit}"
    if field.shape == "flag":
        return str(field.default).lower()
    if field.shape == "triple":
        return f"{', '.join(f'{number:g}' for number in field.default)}{limit}"
    number = isinstance(field.default, float)
    shown = (
        "no limit" if number and math.isinf(field.default) else f"{field.default:g}" if number else str(field.default)
    )
    return f"{shown}{limit}"


def _live(field: Any, family: str) -> str:
    return f"; may use {field.may_use}" if field.live and family != "driver" else ""


# ---------------------------------------------------------------- examples
def example(catalog: Any, kind: Any) -> str:
    """A few lines of a model file with this kind, read by the program."""
    families = {"joint": _whole_joint, "driver": _driver, "load": _load}
    own = {
        "clearance": _clearance,
        "stop": _stop,
        "one-sided": _one_sided,
        "clutch": _clutch,
        "tangent": _tangent,
        "stepper": _stepper,
        "worn": _worn,
    }
    made = {**families, **own, "tension": _belt}.get(kind.family)
    lines = made(catalog, kind) if made else _contact(catalog, kind)
    text = "\n".join(lines)
    rt.loads(FRAME + text)  # raises if the example is not valid
    return text


def _joint(catalog: Any, kind: Any, name: str = "hinge") -> list[str]:
    ends = '["ground", "link"]' if kind.leaf.bodies else '["ground.O", "link.P"]'
    also = ['length = "200 mm"'] if kind.name == "rod" else []  # that is left out of a rope
    return [f"[joints.{name}]", f'type = "{kind.name}"', f"connect = {ends}", *also, *_needed(catalog, kind)]


def _whole_joint(catalog: Any, kind: Any) -> list[str]:
    alone = not kind.leaf.rows and catalog.one_sided_of(kind.name) is not None  # nothing but contacts
    return [*_joint(catalog, kind), *(ON_LINE if kind.leaf.touches else []), *([CONTACT] if alone else [])]


def _tangent(catalog: Any, kind: Any) -> list[str]:
    rough = next(one for one in catalog.kinds("joint").values() if kind.name in one.leaf.tangents)
    if rough.leaf.touches:  # a contact bears it, not the joint
        disc = [*ON_LINE, 'roller = "20 mm"']
        return [*_joint(catalog, rough), *disc, 'contact = { model = "impact", restitution = 0.5, rolling = "0.1 mm" }']
    sizes = "".join(f', {key} = "2 mm"' for key, one in rough.leaf.rubs_with.items() if one.default is catalog.REQUIRED)
    return [*_joint(catalog, rough), f"friction = {{ mu = 0.1{sizes} }}" if sizes else "friction = 0.1"]


def _driver(catalog: Any, kind: Any) -> list[str]:
    driven = kind.name.removesuffix("-speed")  # a speed drives what a position drives
    moved = [one for one in catalog.kinds("joint").values() if one.leaf.motor and one.leaf.motor.driver == driven]
    if moved:
        joint = _joint(catalog, moved[0])
        return [*joint, "", "[drivers.motor]", 'joint = "hinge"', *_needed(catalog, kind, live=True)]
    coordinate = kind.name.removeprefix("body-")
    where = ["[drivers.motor]", 'body = "link"', f'coordinate = "{coordinate}"']
    return [*where, *_needed(catalog, kind, live=True)]


def _load(catalog: Any, kind: Any) -> list[str]:
    return [f"[loads.{kind.name.replace('-', '_')}]", f'type = "{kind.name}"', *_needed(catalog, kind)]


def _clearance(catalog: Any, kind: Any) -> list[str]:
    joint = _joint(catalog, catalog.kinds("joint")[kind.leaf.joint])
    tables = []
    for table_, wanted in kind.leaf.dimensions.items():
        sizes = ", ".join(f'{key} = "{40 // n} mm"' for n, key in enumerate(wanted, 1))
        tables.append(f"{table_} = {{ {sizes} }}")
    return [*joint, 'clearance = "0.2 mm"', *tables, 'contact = { model = "impact", restitution = 0.5 }']


def _stop(catalog: Any, kind: Any) -> list[str]:
    stopped = next(one for one in catalog.kinds("joint").values() if catalog.stop_of(one.name) is kind)
    ends = ", ".join(f"{key} = {_value(key, one, False)}" for key, one in list(kind.fields.items())[1:])
    joint = [line for line in _joint(catalog, stopped) if not line.startswith("length")]
    return [*joint, f'stop = {{ {ends}, contact = {{ model = "impact", restitution = 0.5 }} }}']


def _one_sided(catalog: Any, kind: Any) -> list[str]:
    joint = _joint(catalog, catalog.kinds("joint")[kind.leaf.joint])
    if kind.name in SURFACES:
        lines = [*joint, *SURFACES[kind.name], CONTACT]
        return [PLATE, *(line.replace("link.P", "plate.P") for line in lines)] if kind.name == "by-outline" else lines
    teeth = ['pressure_angle = "20 deg"', 'backlash = "0.1 mm"'] if kind.name == "flanks" else []
    return [*joint, *teeth, *([CONTACT] if kind.leaf.chosen else [])]


def _worn(catalog: Any, kind: Any) -> list[str]:
    contact = 'contact = { model = "hertz", stiffness = 1e9, length = "20 mm", bush_radius = "10 mm" }'
    depths = ", ".join(["0"] * 11 + ["1e-6"])
    wear = f'wear = {{ bush = "1e-6 mm^3/(N*m)", bins = 12, depths = {{ bush = [{depths}] }} }}'
    return [*_joint(catalog, catalog.kinds("joint")["revolute"]), 'clearance = "0.2 mm"', contact, wear]


def _belt(catalog: Any, kind: Any) -> list[str]:
    return [*_joint(catalog, catalog.kinds("joint")["belt"]), *(f'{key} = "10 N*s/m"' for key in kind.fields)]


def _clutch(catalog: Any, kind: Any) -> list[str]:
    joint = _joint(catalog, catalog.kinds("joint")["clutch"])
    return [*joint, 'model = "ratchet"', "teeth = 24"] if kind.name == "ratchet" else [*joint, 'model = "ideal"']


def _stepper(catalog: Any, kind: Any) -> list[str]:
    fixed = [] if kind.leaf.adaptive else ['step = "10 us"']
    return ["[simulate]", f'method = "{kind.name}"', *fixed]


def _contact(catalog: Any, kind: Any) -> list[str]:
    needed = ", ".join(_needed(catalog, kind))
    bush = 'bush_radius = "10 mm"'
    material = f'{bush}, bush_material = "bronze", pin_material = "steel"'
    if kind.family == "film" or getattr(kind.leaf, "oiled", False):
        film = kind.name if kind.family == "film" else "finite"
        said = f'{{ model = "lubricated", film = "{film}", viscosity = "50 mPa*s", length = "10 mm", {bush} }}'
    elif kind.family == "contact":
        table = "".join(f", {key} = {value}" for key, value in WITH_CONTACT.items() if key in kind.fields)
        said = f'{{ model = "{kind.name}"{table} }}' if table else f'"{kind.name}"'
    elif kind.family == "normal":
        stiff = "stiffness = 1e6, exponent = 1" if "hysteretic" not in kind.kernel.__name__ else "stiffness = 1e9"
        said = f'{{ model = "{kind.name}"{", " if needed else ""}{needed}, {stiff} }}'
    elif kind.family == "stiffness":
        own = [one for one in _needed(catalog, kind) if not one.split(" = ")[0].endswith(("_material", "_radius"))]
        sizes = material if "bush_material" in kind.fields else bush
        geometry = [] if kind.name == "power" else [f'geometry = "{kind.name}"']
        geometry += [sizes] if "bush_radius" in kind.fields else []
        said = f'{{ model = "exact", restitution = 0.5, {", ".join([*geometry, *own])} }}'
    else:
        friction = f'{{ model = "{kind.name}"{", " if needed else ""}{needed} }}'
        said = f'{{ model = "exact", restitution = 0.5, {material}, friction = {friction} }}'
    joint = catalog.kinds("joint")["revolute"]
    return [*_joint(catalog, joint), 'clearance = "0.1 mm"', f"contact = {said}"]


def _needed(catalog: Any, kind: Any, live: bool = False) -> list[str]:
    fields = ((key, one) for key, one in kind.fields.items() if one.default is catalog.REQUIRED)
    sizes = SIZES.get(kind.name, {})
    return [f"{key} = {_quoted(sizes[key]) if key in sizes else _value(key, one, live)}" for key, one in fields]


def _quoted(number: Any) -> str:
    return f'"{number}"' if isinstance(number, str) else f"{number:g}"


def _value(key: str, field: Any, live: bool) -> str:
    if live:
        return '"5*t"' if field.unit == "rad" else '"0.1*sin(5*t)"'
    ends: dict[str, str] = {
        "point": '"link.Q"',
        "body": '"link"',
        "connect": '["ground.O", "link.Q"]',
        "material": '"steel"',
    }
    if field.shape == "choice":
        return f'"{field.choices[0]}"'
    if field.shape in ends:
        return ends[field.shape]
    number = {"mu": 0.1, "stiffness": 1e9 if field.unit != "N/m" else "2 kN/m"}.get(key, VALUES.get(field.unit, 1.0))
    if key == "connect":
        return ends["connect"]
    shown = _quoted(number)
    if field.shape == "triple":
        return f"[{shown}, {shown}, {_quoted(VALUES.get(field.turning, 1.0))}]"
    return f"[{shown}, {shown if field.least else 0}]" if field.shape == "pair" else shown


# ---------------------------------------------------------------- tables, names, functions, units, materials
def _tables() -> str:
    parts: list[str] = []
    topics: Iterable[Any] = module_with("common", "topics").topics().values()
    for topic in topics:
        rows = [(code(key.strip()), paragraph(said)) for key, _, said in (line.partition(": ") for line in topic.lines)]
        parts += [f"## {topic.name}", paragraph(topic.summary[:1].upper() + topic.summary[1:]) + "."]
        parts.append(table(("what", "meaning"), rows) if any(said for _, said in rows) else _list(rows))
    return "\n\n".join(parts) + "\n"


def _list(rows: Iterable[tuple[str, str]]) -> str:
    return ", ".join(key for key, _ in rows) + "."
