"""JSON Schema of the model file, made from the registry, for editors that complete and check the text as it is typed.

It has every key, kind and unit.  References to other parts (points, names, dimensions of expressions)
are checked by the reader only.

Source: JSON Schema, draft 2020-12.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from typing import Any

from rattle import registry
from rattle.description.read_contact import ALONG, contact_models, stop_models
from rattle.description.read_friction import arm_fields, friction_models
from rattle.description.read_parameters import DISTRIBUTIONS, TABLE
from rattle.description.read_parts import moved_joints
from rattle.description.read_tables import KINDS
from rattle.description.reader import SETTING_UNITS, STATE_UNITS
from rattle.registry import REQUIRED, Field, Kind

Schema = dict[str, Any]
NAME = r"^[A-Za-z_][A-Za-z0-9_]*$"
POINT = r"^[^.\s]+\.[^.\s]+$"


def schema() -> Schema:
    """The schema of a model file as a JSON document (draft 2020-12)."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "rattle model",
        "description": "A planar mechanism. Numbers are SI; texts are quantities ('5 mm') or expressions.",
        **_object(
            {
                "format": {"const": 1, "description": "version of the format"},
                "name": {"type": "string", "description": "title"},
                "gravity": _vector("m/s^2", "acceleration of gravity"),
                "parameters": _named(_parameter(), "values that expressions use"),
                "tolerances": _tolerances(),
                "tables": _named(_table(), "functions of one number that expressions use: lift(x)"),
                "signals": _named(_number("", "expression over parameters, t and state"), "recorded quantities"),
                "states": _named(_state(), "first-order states of the model's own, usable like signals"),
                "ground": _object({"points": _points("points of the ground")}),
                "bodies": _named({"anyOf": [_bar(), _plate(), _body()]}, "rigid bodies"),
                "joints": _named({"anyOf": [_joint(kind) for kind in registry.kinds("joint").values()]}, "joints"),
                "drivers": _named({"anyOf": _drivers()}, "degrees of freedom that follow a function of time"),
                "loads": _named({"anyOf": [_load(kind) for kind in registry.kinds("load").values()]}, "loads"),
                "initial": _named({"anyOf": [_start(), _offset()]}, "start of bodies and of clearance joints"),
                "simulate": _settings(),
            },
            needed=("format", "bodies"),
        ),
    }


# ---------------------------------------------------------------- pieces
def _object(properties: Mapping[str, Schema], needed: Iterable[str] = (), meaning: str = "") -> Schema:
    made: Schema = {"type": "object", "properties": dict(properties), "additionalProperties": False}
    if list(needed):
        made["required"] = list(needed)
    return made | ({"description": meaning} if meaning else {})


def _named(entry: Schema, meaning: str) -> Schema:
    """A table whose keys are names chosen by the user."""
    return {
        "type": "object",
        "propertyNames": {"pattern": NAME},
        "additionalProperties": entry,
        "description": meaning,
    }


def _number(unit: str, meaning: str, least: str = "") -> Schema:
    made: Schema = {"type": ["number", "string"], "description": f"{meaning} [{unit}]" if unit else meaning}
    if least:
        made["exclusiveMinimum" if least == "positive" else "minimum"] = 0
    return made


def _vector(unit: str, meaning: str) -> Schema:
    one = {"type": ["number", "string"]}
    return {"type": "array", "items": one, "minItems": 2, "maxItems": 2, "description": f"{meaning} [x, y] [{unit}]"}


def _points(meaning: str) -> Schema:
    return {"type": "object", "additionalProperties": _vector("m", "position"), "description": meaning}


def _point(meaning: str) -> Schema:
    return {"type": "string", "pattern": POINT, "description": f'{meaning}: "body.point"'}


def _connect(end: Schema, meaning: str = 'ends A and B, "body.point" each') -> Schema:
    return {
        "type": "array",
        "items": end,
        "minItems": 2,
        "maxItems": 2,
        "description": meaning,
    }


def _field(one: Field) -> Schema:
    """A field of a kind, as its class declares it."""
    meaning = one.meaning + (f"; may use {one.may_use}" if one.live and not one.meaning.endswith("of t") else "")
    if one.function_of:
        meaning += f"; an expression in {one.function_of} [{one.of_unit}], which may use tables"
    if one.shape == "choice":
        made: Schema = {"enum": list(one.choices), "description": meaning}
    elif one.shape == "flag":
        made = {"type": "boolean", "description": meaning}
    elif one.shape == "pair":
        made = _vector(one.unit, meaning)
    elif one.shape == "point":
        made = _point(meaning)
    elif one.shape in ("body", "joint"):
        made = {"type": "string", "pattern": NAME, "description": meaning}
    elif one.shape == "connect":
        made = _connect({"type": "string"})
    elif one.shape == "material":
        table = _object({"E": _number("Pa", "modulus"), "nu": _number("", "Poisson's ratio")}, ("E",))
        made = {"anyOf": [{"type": "string"}, table], "description": meaning}
    else:
        made = _number(one.unit, meaning, one.least)
    if one.default is not REQUIRED and not callable(one.default) and one.default != math.inf:
        made["default"] = one.default
    return made


def _fields(kind: Kind) -> dict[str, Schema]:
    return {key: _field(one) for key, one in kind.fields.items()}


def _needed(kind: Kind) -> list[str]:
    return [key for key, one in kind.fields.items() if one.default is REQUIRED]


def _choice(kind: Kind) -> Schema:
    return {"const": kind.name, "description": kind.summary}


# ---------------------------------------------------------------- tables
def _parameter() -> Schema:
    number = _number("", "value")
    meanings = {"min": "least", "max": "most", "tol": "tolerance: half the width of its field"}
    limits = {key: _number("", meaning) for key, meaning in meanings.items()}
    plain = {"type": "array", "items": {"type": ["number", "string"]}, "minItems": 1}
    table = _object(dict.fromkeys(TABLE, plain), TABLE[:1], "single values, with weights unless all are as likely")
    said = f"distribution: {' | '.join(DISTRIBUTIONS)} on value +- tol, or {{ values = [...], weights = [...] }}"
    dist = {"anyOf": [{"enum": list(DISTRIBUTIONS)}, table], "description": said}
    return {"anyOf": [number, _object({"value": number, **limits, "dist": dist}, ("value",))]}


def _state() -> Schema:
    rate = _number("", "expression over parameters, t, the motion, signals and states, per second")
    return _object({"rate": rate, "start": _number("", "value at the start, default 0")}, ("rate",))


def _table() -> Schema:
    """A table: its points, or a file that holds them."""
    numbers = {"type": "array", "items": {"type": ["number", "string"]}, "minItems": 2}
    units = {"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2}
    said = "straight lines, cubics without overshoot, or cubics with continuous second derivative"
    shape = {
        "kind": {"enum": list(KINDS), "description": said, "default": KINDS[0]},
        "period": _number("", "of x, after which y repeats", "positive"),
    }
    points = {
        "x": {**numbers, "description": "arguments, increasing"},
        "y": {**numbers, "description": "values"},
        "units": {**units, "description": "units of x and y where numbers have none"},
    }
    file = {"type": "string", "description": "file beside the model file: two columns, the header may hold units"}
    return {"anyOf": [_object({**points, **shape}, ("x", "y")), _object({"file": file, **shape}, ("file",))]}


def _tolerances() -> Schema:
    group = {"type": "array", "items": {"type": "string", "pattern": NAME}, "minItems": 2, "uniqueItems": True}
    said = 'parameters that are made together, [["l2", "l3"]]: one draw moves all of a group'
    groups = {"groups": {"type": "array", "items": group, "description": said}}
    return _object(groups, meaning="how the fields of parameters hang together")


def _bar() -> Schema:
    ends = {
        "type": "array",
        "items": {"type": "string"},
        "minItems": 2,
        "maxItems": 2,
        "description": "names of the ends",
    }
    return _object(
        {
            "bar": ends,
            "length": _number("m", "length", "positive"),
            "points": _points("more points, from the mass centre, x axis along the bar"),
            "mass": _number("kg", "mass", "not negative"),
            "inertia": _number("kg*m^2", "about the mass centre; default m l^2/12", "not negative"),
        },
        ("bar", "length", "mass"),
        "a uniform bar",
    )


def _plate() -> Schema:
    """A plate: with thickness and density, or with its mass."""
    ring = {"type": "array", "items": _vector("m", "corner"), "minItems": 3}
    given: dict[str, Schema] = {
        "polygon": {**ring, "description": "corners in order around, in any frame of the body"},
        "holes": {"type": "array", "items": ring, "description": "corners of each hole, in the same frame"},
        "points": _points("points in the same frame"),
    }
    of_material = {
        "thickness": _number("m", "thickness", "positive"),
        "density": _number("kg/m^3", "density", "positive"),
    }
    said = "a plate: its polygon says mass centre and inertia"
    weights: list[dict[str, Schema]] = [of_material, {"mass": _number("kg", "mass", "positive")}]
    return {"anyOf": [_object({**given, **one}, ("polygon", *one), said) for one in weights]}


def _body() -> Schema:
    return _object(
        {
            "points": _points("points in any frame of the body"),
            "center": _vector("m", "mass centre in the same frame"),
            "mass": _number("kg", "mass", "not negative"),
            "inertia": _number("kg*m^2", "about the mass centre", "not negative"),
        },
        ("mass", "inertia"),
        "a rigid body",
    )


def _joint(kind: Kind) -> Schema:
    if kind.leaf.bodies:
        ends = {"connect": _connect({"type": "string", "description": "a body"}, "bodies A and B, or ground")}
    else:
        ends = {
            "connect": _connect(_point("bush or guide side first")),
            "clearance": _number("m", "radial clearance", "not negative"),
            "contact": _contact(),
        }
    properties = {
        "type": _choice(kind),
        **ends,
        **_dimensions(kind),
        **_stop(kind),
        **_own_friction(kind),
        **_one_sided(kind),
        **_fields(kind),
    }
    return _object(properties, ("type", "connect", *_needed(kind)), kind.summary)


def _dimensions(joint: Kind) -> dict[str, Schema]:
    """Tables of lengths that a joint with play has."""
    play = registry.play_of(joint.name)
    tables: Mapping[str, Mapping[str, Field]] = play.leaf.dimensions if play else {}
    return {
        table: _object({key: _field(one) for key, one in wanted.items()}, wanted) for table, wanted in tables.items()
    }


def _one_sided(joint: Kind) -> dict[str, Schema]:
    """The contact of a joint that is one-sided with it."""
    if registry.one_sided_of(joint.name) is None:
        return {}
    return {"contact": _contact(contact_models(joint.name), ALONG, "contact model: the joint is then one-sided")}


def _stop(joint: Kind) -> dict[str, Schema]:
    """The ends of the coordinate of a joint, if it has one."""
    kind = registry.stop_of(joint.name)
    if kind is None:
        return {}
    contact = _contact(stop_models(), ALONG, "contact model of the stop")
    return {"stop": _object({**_fields(kind), "contact": contact}, (), kind.summary)}


def _own_friction(joint: Kind) -> dict[str, Schema]:
    """Friction of a joint without play, if it may have any."""
    if not joint.leaf.rubs:
        return {}
    more = {key: _field(one) for key, one in arm_fields(joint).items()}
    tables = [
        _object(
            {"model": {"const": name}, **{key: _field(one) for key, one in fields.items()}, **more}, ("model", *more)
        )
        for name, fields in friction_models().items()
    ]
    number = [] if more else [_number("", "coefficient of friction", "not negative")]
    return {"friction": {"anyOf": [*number, *tables], "description": "friction without play, by its own reaction"}}


def _contact(
    models: Collection[str] | None = None,
    without: Collection[str] = (),
    meaning: str = "contact model of the clearance",
) -> Schema:
    """The contact model: its name, or a table with its fields, which may also hold fields of other models."""
    known, laws, statics = registry.kinds("contact"), registry.kinds("normal"), registry.kinds("stiffness")
    plain = {name: one for name, one in known.items() if models is None or name in models}
    radius = {"bush_radius": _number("m", "radius of the bush; the pin radius is smaller by the clearance", "positive")}
    friction = {"friction": _friction()}
    own = [key for key in statics if key != "power"]
    every: dict[str, Schema] = {"geometry": {"enum": own, "description": "formula for the stiffness from materials"}}
    for kind in (*statics.values(), *laws.values(), *plain.values()):
        every |= _fields(kind)
    oiled = [one for one in plain.values() if one.leaf.oiled]
    every |= {**_oil(), **every} if oiled else {}
    every |= {**radius, **friction}
    every = {key: value for key, value in every.items() if key not in without}
    tables = []
    for kind in oiled:
        needed = ["model", "bush_radius", *_needed_by_all(registry.kinds("film").values())]
        tables.append(_object({"model": _choice(kind), **every, **_fields(kind)}, dict.fromkeys(needed)))
    for kind in (*(one for one in plain.values() if not one.leaf.oiled), *laws.values()):
        own_fields = {key: one for key, one in _fields(kind).items() if key != "friction" and key not in without}
        tables.append(_object({"model": _choice(kind), **every, **own_fields}, ("model", *_needed(kind))))
    return {"anyOf": [{"enum": [*plain, *laws]}, *tables], "description": meaning}


def _oil() -> dict[str, Schema]:
    """Keys of the oil in a clearance, besides those of its model."""
    films = registry.kinds("film")
    found: dict[str, Schema] = {}
    for kind in films.values():
        found |= _fields(kind)
    each = {"type": ["number", "string"]}
    both = {"type": "array", "items": each, "minItems": 2, "maxItems": 2}
    return found | {
        "film": {"enum": list(films), "default": "finite", "description": "law of the oil film"},
        "dry": {"type": "object", "description": "the dry contact beside the film: the table of a compliant contact"},
        "roughness": {"anyOf": [_number("m", "of both surfaces"), both], "description": "root mean square [m]"},
    }


def _needed_by_all(kinds: Collection[Kind]) -> list[str]:
    every = [_needed(kind) for kind in kinds]
    return [key for key in every[0] if all(key in one for one in every)]


def _friction() -> Schema:
    laws = registry.kinds("friction").values()
    tables = [_object({"model": _choice(kind), **_fields(kind)}, ("model", *_needed(kind))) for kind in laws]
    return {"anyOf": [_number("", "coefficient of friction", "not negative"), *tables]}


def _drivers() -> list[Schema]:
    made = []
    for kind in registry.kinds("driver").values():
        where: dict[str, Schema] = {
            "joint": {"type": "string", "description": f"a {' or '.join(moved_joints(kind.name))} joint"}
        }
        if kind.leaf.drives == "body":
            where = {
                "body": {"type": "string", "description": 'a body, or a point of it: "body.point"'},
                "coordinate": {"const": kind.name.removeprefix("body-")},
            }
        made.append(_object({**where, **_fields(kind)}, (*where, *_needed(kind)), kind.summary))
    return made


def _load(kind: Kind) -> Schema:
    return _object({"type": _choice(kind), **_fields(kind)}, ("type", *_needed(kind)), kind.summary)


def _start() -> Schema:
    return _object({key: _number(unit, "at the start") for key, unit in STATE_UNITS.items()}, meaning="start of a body")


def _offset() -> Schema:
    return _object({"offset": _vector("m", "pin centre minus bush centre")}, meaning="start of a clearance joint")


def steppers(adaptive: bool) -> str:
    """Names of the steppers that choose their steps, or of those whose steps are all equal: "rk4 and moreau"."""
    return " and ".join(name for name, one in registry.kinds("stepper").items() if one.leaf.adaptive == adaptive)


def _settings() -> Schema:
    meanings = {
        "t_end": "duration",
        "rtol": f"relative error allowed per step of {steppers(True)}",
        "atol": f"error per step that is always allowed to {steppers(True)}",
        "step": f"length of all steps of {steppers(False)}, of the longest one of {steppers(True)}",
        "output": "interval between outputs",
    }
    numbers = {key: _number(unit, meanings[key], "positive") for key, unit in SETTING_UNITS.items()}
    methods = "; ".join(f"{name}: {one.summary.removesuffix('.')}" for name, one in registry.kinds("stepper").items())
    return _object({**numbers, "method": {"enum": list(registry.kinds("stepper")), "description": methods}})
