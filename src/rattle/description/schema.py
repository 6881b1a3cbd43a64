"""JSON Schema of the model file, made from the registry, for editors that complete and check the text as it is typed.

It has every key, kind and unit.  References to other parts (points, names, dimensions of expressions)
are checked by the reader only; the keyword `x-names` says to which parts a text refers.

Source: JSON Schema, draft 2020-12.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

from rattle import registry
from rattle.description import schema_pieces as of
from rattle.description.read_contact import ALONG, contact_models, stop_models
from rattle.description.read_friction import friction_models
from rattle.description.read_parameters import DISTRIBUTIONS, LONGEST_LABEL, TABLE
from rattle.description.read_parts import moved_joints
from rattle.description.read_tables import KINDS
from rattle.description.read_wear import COEFFICIENT, FIELDS, LAYER, SIDES, kind_wears
from rattle.description.reader import SETTING_UNITS, STATE_UNITS
from rattle.description.schema_pieces import NAME, Schema
from rattle.description.wear_profile import DEPTHS
from rattle.registry import REQUIRED, Field, Kind


def schema() -> Schema:
    """The schema of a model file as a JSON document (draft 2020-12)."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "rattle model",
        "description": "A planar mechanism. Numbers are SI; texts are quantities ('5 mm') or expressions.",
        **of.table(
            {
                "format": {"const": 1, "description": "version of the format"},
                "name": {"type": "string", "description": "title"},
                "gravity": of.vector("m/s^2", "acceleration of gravity"),
                "parameters": of.named(_parameter(), "values that expressions use"),
                "tolerances": _tolerances(),
                "tables": of.named(_table(), "functions of one number that expressions use: lift(x)"),
                "signals": of.named(of.number("", "expression over parameters, t and state"), "recorded quantities"),
                "states": of.named(_state(), "first-order states of the model's own, usable like signals"),
                "ground": of.table({"points": of.points("points of the ground")}),
                "bodies": of.named({"anyOf": [_bar(), _plate(), _body()]}, "rigid bodies"),
                "joints": of.named({"anyOf": [_joint(kind) for kind in registry.kinds("joint").values()]}, "joints"),
                "drivers": of.named({"anyOf": _drivers()}, "degrees of freedom that follow a function of time"),
                "loads": of.named({"anyOf": [_load(kind) for kind in registry.kinds("load").values()]}, "loads"),
                "initial": of.named({"anyOf": [_start(), _offset()]}, "start of bodies and of clearance joints"),
                "simulate": _settings(),
            },
            needed=("format", "bodies"),
        ),
    }


# ---------------------------------------------------------------- tables
def _parameter() -> Schema:
    number = of.number("", "value")
    meanings = {"min": "least", "max": "most", "tol": "tolerance: half the width of its field"}
    limits = {key: of.number("", meaning) for key, meaning in meanings.items()}
    plain = {"type": "array", "items": {"type": ["number", "string"]}, "minItems": 1}
    table = of.table(dict.fromkeys(TABLE, plain), TABLE[:1], "single values, with weights unless all are as likely")
    said = f"distribution: {' | '.join(DISTRIBUTIONS)} on value +- tol, or {{ values = [...], weights = [...] }}"
    dist = {"anyOf": [{"enum": list(DISTRIBUTIONS)}, table], "description": said}
    words = {"label": "what sliders and reports call it", "description": "what a reader should know of it"}
    texts: dict[str, Schema] = {key: {"type": "string", "description": text} for key, text in words.items()}
    texts["label"] = {**texts["label"], "maxLength": LONGEST_LABEL}
    return {"anyOf": [number, of.table({"value": number, **limits, "dist": dist, **texts}, ("value",))]}


def _state() -> Schema:
    rate = of.number("", "expression over parameters, t, the motion, signals and states, per second")
    return of.table({"rate": rate, "start": of.number("", "value at the start, default 0")}, ("rate",))


def _table() -> Schema:
    """A table: its points, or a file that holds them."""
    numbers = {"type": "array", "items": {"type": ["number", "string"]}, "minItems": 2}
    units = {"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2}
    said = "straight lines, cubics without overshoot, or cubics with continuous second derivative"
    shape = {
        "kind": {"enum": list(KINDS), "description": said, "default": KINDS[0]},
        "period": of.number("", "of x, after which y repeats", "positive"),
    }
    points = {
        "x": {**numbers, "description": "arguments, increasing"},
        "y": {**numbers, "description": "values"},
        "units": {**units, "description": "units of x and y where numbers have none"},
    }
    file = {"type": "string", "description": "file beside the model file: two columns, the header may hold units"}
    return {"anyOf": [of.table({**points, **shape}, ("x", "y")), of.table({"file": file, **shape}, ("file",))]}


def _tolerances() -> Schema:
    group = {"type": "array", "items": {"type": "string", "pattern": NAME}, "minItems": 2, "uniqueItems": True}
    said = 'parameters that are made together, [["l2", "l3"]]: one draw moves all of a group'
    groups = {"groups": {"type": "array", "items": group, "description": said}}
    return of.table(groups, meaning="how the fields of parameters hang together")


def _bar() -> Schema:
    ends = {
        "type": "array",
        "items": {"type": "string"},
        "minItems": 2,
        "maxItems": 2,
        "description": "names of the ends",
    }
    return of.table(
        {
            "bar": ends,
            "length": of.number("m", "length", "positive"),
            "points": of.points("more points, from the mass centre, x axis along the bar"),
            "mass": of.number("kg", "mass", "not negative"),
            "inertia": of.number("kg*m^2", "about the mass centre; default m l^2/12", "not negative"),
        },
        ("bar", "length", "mass"),
        "a uniform bar",
    )


def _plate() -> Schema:
    """A plate: with thickness and density, or with its mass."""
    ring = {"type": "array", "items": of.vector("m", "corner"), "minItems": 3}
    given: dict[str, Schema] = {
        "polygon": {**ring, "description": "corners in order around, in any frame of the body"},
        "holes": {"type": "array", "items": ring, "description": "corners of each hole, in the same frame"},
        "points": of.points("points in the same frame"),
    }
    of_material = {
        "thickness": of.number("m", "thickness", "positive"),
        "density": of.number("kg/m^3", "density", "positive"),
    }
    said = "a plate: its polygon says mass centre and inertia"
    weights: list[dict[str, Schema]] = [of_material, {"mass": of.number("kg", "mass", "positive")}]
    return {"anyOf": [of.table({**given, **one}, ("polygon", *one), said) for one in weights]}


def _body() -> Schema:
    return of.table(
        {
            "points": of.points("points in any frame of the body"),
            "center": of.vector("m", "mass centre in the same frame"),
            "mass": of.number("kg", "mass", "not negative"),
            "inertia": of.number("kg*m^2", "about the mass centre", "not negative"),
        },
        ("mass", "inertia"),
        "a rigid body",
    )


def _joint(kind: Kind) -> Schema:
    if kind.leaf.bodies:
        ends = {
            "connect": of.connect(
                {"type": "string", "description": "a body", of.NAMES: "bodies"}, "bodies A and B, or ground"
            )
        }
    else:
        ends = {
            "connect": of.connect(of.point("bush or guide side first")),
            "clearance": of.number("m", "radial clearance", "not negative"),
            "contact": _contact(),
            **(_wear() if kind_wears(kind) else {}),
        }
    properties = {
        "type": of.choice(kind),
        **ends,
        **_dimensions(kind),
        **_stop(kind),
        **_own_friction(kind),
        **_one_sided(kind),
        **of.fields(kind),
    }
    return of.table(properties, ("type", "connect", *of.needed(kind)), kind.summary)


def _wear() -> dict[str, Schema]:
    """How pin and bush of a joint wear."""
    hard = _table_of(COEFFICIENT, "Archard's coefficient over the hardness")
    given: dict[str, Schema] = {}
    for side in SIDES:
        said = f"k of the {side}, volume lost per force and distance [m^2/N], or {{ coefficient, hardness }}"
        given[side] = {"anyOf": [of.number("m^2/N", "k", "not negative"), hard], "description": said}
    given |= {key: of.field(one) for key, one in FIELDS.items()}
    given["jump"] = {"anyOf": [{"const": "auto"}, of.number("", "cycles", "positive")], "description": "size of jumps"}
    given["layer"] = _table_of(LAYER, "thin layer { E, nu, thickness } from which the foundation follows")
    given["profile"] = {"type": "string", "description": "file beside the model file with the depths that are worn"}
    numbers = {"type": "array", "items": {"type": ["number", "string"]}}
    given[DEPTHS] = of.table(dict.fromkeys(SIDES, numbers), meaning="the same, written out: a number for each bin [m]")
    return {"wear": of.table(given, meaning="how pin and bush wear, for the study of wear")}


def _table_of(fields: Mapping[str, Field], meaning: str) -> Schema:
    needed = [key for key, one in fields.items() if one.default is REQUIRED]
    return of.table({key: of.field(one) for key, one in fields.items()}, needed, meaning)


def _dimensions(joint: Kind) -> dict[str, Schema]:
    """Tables of lengths that a joint with play has."""
    play = registry.play_of(joint.name)
    tables: Mapping[str, Mapping[str, Field]] = play.leaf.dimensions if play else {}
    return {
        table: of.table({key: of.field(one) for key, one in wanted.items()}, wanted) for table, wanted in tables.items()
    }


def _one_sided(joint: Kind) -> dict[str, Schema]:
    """The contact of a joint that is one-sided with it."""
    sided = registry.one_sided_of(joint.name)
    if sided is None:
        return {}
    without = () if sided.leaf.slides else ALONG
    return {"contact": _contact(contact_models(joint.name), without, "contact model: the joint is then one-sided")}


def _stop(joint: Kind) -> dict[str, Schema]:
    """The ends of the coordinate of a joint, if it has one."""
    kind = registry.stop_of(joint.name)
    if kind is None:
        return {}
    contact = _contact(stop_models(), ALONG, "contact model of the stop")
    return {"stop": of.table({**of.fields(kind), "contact": contact}, (), kind.summary)}


def _own_friction(joint: Kind) -> dict[str, Schema]:
    """Friction of a joint without play, if it may have any."""
    if not joint.leaf.rubs:
        return {}
    more = {key: of.field(one) for key, one in joint.leaf.rubs_with.items()}
    needed = [key for key, one in joint.leaf.rubs_with.items() if one.default is REQUIRED]
    tables = [
        of.table(
            {"model": {"const": name}, **{key: of.field(one) for key, one in fields.items()}, **more},
            ("model", *needed),
        )
        for name, fields in friction_models().items()
    ]
    number = [] if needed else [of.number("", "coefficient of friction", "not negative")]
    return {"friction": {"anyOf": [*number, *tables], "description": "friction without play, by its own reaction"}}


def _contact(
    models: Collection[str] | None = None,
    without: Collection[str] = (),
    meaning: str = "contact model of the clearance",
) -> Schema:
    """The contact model: its name, or a table with its fields, which may also hold fields of other models."""
    known, laws, statics = registry.kinds("contact"), registry.kinds("normal"), registry.kinds("stiffness")
    plain = {name: one for name, one in known.items() if models is None or name in models}
    radius = {
        "bush_radius": of.number("m", "radius of the bush; the pin radius is smaller by the clearance", "positive")
    }
    friction = {"friction": _friction()}
    own = [key for key in statics if key != "power"]
    every: dict[str, Schema] = {"geometry": {"enum": own, "description": "formula for the stiffness from materials"}}
    for kind in (*statics.values(), *laws.values(), *plain.values()):
        every |= of.fields(kind)
    oiled = [one for one in plain.values() if one.leaf.oiled]
    every |= {**_oil(), **every} if oiled else {}
    every |= {**radius, **friction}
    every = {key: value for key, value in every.items() if key not in without}
    tables = []
    for kind in oiled:
        needed = ["model", "bush_radius", *_needed_by_all(registry.kinds("film").values())]
        tables.append(of.table({"model": of.choice(kind), **every, **of.fields(kind)}, dict.fromkeys(needed)))
    for kind in (*(one for one in plain.values() if not one.leaf.oiled), *laws.values()):
        own_fields = {key: one for key, one in of.fields(kind).items() if key != "friction" and key not in without}
        tables.append(of.table({"model": of.choice(kind), **every, **own_fields}, ("model", *of.needed(kind))))
    return {"anyOf": [{"enum": [*plain, *laws]}, *tables], "description": meaning}


def _oil() -> dict[str, Schema]:
    """Keys of the oil in a clearance, besides those of its model."""
    films = registry.kinds("film")
    found: dict[str, Schema] = {}
    for kind in films.values():
        found |= of.fields(kind)
    each = {"type": ["number", "string"]}
    both = {"type": "array", "items": each, "minItems": 2, "maxItems": 2}
    return found | {
        "film": {"enum": list(films), "default": "finite", "description": "law of the oil film"},
        "dry": {"type": "object", "description": "the dry contact beside the film: the table of a compliant contact"},
        "roughness": {"anyOf": [of.number("m", "of both surfaces"), both], "description": "root mean square [m]"},
    }


def _needed_by_all(kinds: Collection[Kind]) -> list[str]:
    every = [of.needed(kind) for kind in kinds]
    return [key for key in every[0] if all(key in one for one in every)]


def _friction() -> Schema:
    laws = registry.kinds("friction").values()
    tables = [of.table({"model": of.choice(kind), **of.fields(kind)}, ("model", *of.needed(kind))) for kind in laws]
    return {"anyOf": [of.number("", "coefficient of friction", "not negative"), *tables]}


def _drivers() -> list[Schema]:
    made = []
    for kind in registry.kinds("driver").values():
        where: dict[str, Schema] = {
            "joint": {
                "type": "string",
                "description": f"a {' or '.join(moved_joints(kind.name))} joint",
                of.NAMES: "joints",
            }
        }
        if kind.leaf.drives == "body":
            where = {
                "body": {"type": "string", "description": 'a body, or a point of it: "body.point"', of.NAMES: "points"},
                "coordinate": {"const": kind.name.removeprefix("body-")},
            }
        made.append(of.table({**where, **of.fields(kind)}, (*where, *of.needed(kind)), kind.summary))
    return made


def _load(kind: Kind) -> Schema:
    return of.table({"type": of.choice(kind), **of.fields(kind)}, ("type", *of.needed(kind)), kind.summary)


def _start() -> Schema:
    return of.table(
        {key: of.number(unit, "at the start") for key, unit in STATE_UNITS.items()}, meaning="start of a body"
    )


def _offset() -> Schema:
    return of.table({"offset": of.vector("m", "pin centre minus bush centre")}, meaning="start of a clearance joint")


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
    numbers = {key: of.number(unit, meanings[key], "positive") for key, unit in SETTING_UNITS.items()}
    methods = "; ".join(f"{name}: {one.summary.removesuffix('.')}" for name, one in registry.kinds("stepper").items())
    return of.table({**numbers, "method": {"enum": list(registry.kinds("stepper")), "description": methods}})
