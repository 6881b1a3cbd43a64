"""JSON Schema of the model file, made from the registry, for editors that complete and check the text as it is typed.

It has every key, kind and unit.  References to other parts (points, names, dimensions of expressions)
are checked by the reader only; the keyword `x-names` says to which parts a text refers.

Source: JSON Schema, draft 2020-12.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

from rattle import registry
from rattle.description import schema_pieces as of
from rattle.description.read_contact import ALONG, contact_models, stop_models
from rattle.description.read_friction import friction_models
from rattle.description.read_parts import moved_joints
from rattle.description.read_wear import kind_wears
from rattle.description.schema_pieces import Schema
from rattle.description.tables import CONTACT, JOINT, MODEL, OIL, WEAR, Either, Form, Named, OfKinds, Part
from rattle.interfaces.joints import DriverKind, JointKind
from rattle.registry import REQUIRED, Field, Kind


def schema() -> Schema:
    """The schema of a model file as a JSON document (draft 2020-12)."""
    whole = part(MODEL)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "rattle model",
        "description": "A planar mechanism. Numbers are SI; texts are quantities ('5 mm') or expressions.",
        **whole,
        "required": [*whole["required"], "bodies"],
    }


# ---------------------------------------------------------------- tables
def part(entry: Part) -> Schema:
    """What may be written in a part of the model file."""
    if isinstance(entry, Field):
        words = {"adaptive": steppers(True), "equal": steppers(False)} if "{adaptive}" in entry.meaning else {}
        return of.field(replace(entry, meaning=entry.meaning.format(**words)) if words else entry)
    if isinstance(entry, Named):
        return of.named(part(entry.entry), entry.meaning)
    if isinstance(entry, OfKinds):
        return {"anyOf": _entries(entry)}
    if isinstance(entry, Either):
        forms = [*map(part, entry.forms)]
        if isinstance(entry.forms[-1], OfKinds):
            forms += forms.pop()["anyOf"]
        return {"anyOf": forms} | ({"description": entry.meaning} if entry.meaning else {})
    tables = [_form(entry, way) for way in entry.ways or ({},)]
    return {"anyOf": tables} if entry.ways else tables[0]


def _form(form: Form, way: Mapping[str, Part]) -> Schema:
    """A table with the keys of a form and of one of its ways."""
    keys = {**way, **form.fields} if form.ways_first else {**form.fields, **way}
    needed = [key for key, entry in keys.items() if isinstance(entry, Field) and entry.default is REQUIRED]
    return of.table({key: part(entry) for key, entry in keys.items()}, needed, form.meaning)


def steppers(adaptive: bool) -> str:
    """Names of the steppers that choose their steps, or of those whose steps are all equal: "rk4 and moreau"."""
    return " and ".join(name for name, kind in registry.kinds("stepper").items() if kind.leaf.adaptive == adaptive)


# ---------------------------------------------------------------- kinds
def _entries(entry: OfKinds) -> list[Schema]:
    """What may be written as an entry of each kind of a family."""
    if entry.family == "joint":
        return [_joint(kind) for kind in registry.kinds("joint").values()]
    if entry.family == "driver":
        return [_driver(kind) for kind in registry.kinds("driver").values()]
    return [_kind(kind, entry.key) for kind in registry.kinds(entry.family).values()]


def _joint(kind: Kind[JointKind]) -> Schema:
    end = of.point("bush or guide side first")
    ends = {"connect": of.connect(end), **_of(JOINT), "contact": _contact()}
    if kind.leaf.bodies:
        body = {"type": "string", "description": "a body", of.NAMES: "bodies"}
        ends = {"connect": of.connect(body, "bodies A and B, or ground")}
    elif kind_wears(kind):
        ends["wear"] = part(WEAR)
    play = registry.play_of(kind.name)
    dimensions: Mapping[str, Mapping[str, Field]] = play.leaf.dimensions if play else {}
    properties = {
        "type": of.choice(kind),
        **ends,
        **{key: of.table({name: of.field(size) for name, size in wanted.items()}, wanted)
           for key, wanted in dimensions.items()},
        **_stop(kind),
        **_own_friction(kind),
        **_one_sided(kind),
        **of.fields(kind),
    }  # fmt: skip
    return of.table(properties, ("type", "connect", *of.needed(kind)), kind.summary)


def _of(form: Form) -> dict[str, Schema]:
    return {key: part(entry) for key, entry in form.fields.items()}


def _one_sided(joint: Kind[JointKind]) -> dict[str, Schema]:
    """The contact of a joint that is one-sided with it."""
    sided = registry.one_sided_of(joint.name)
    if sided is None:
        return {}
    without = () if sided.leaf.slides else ALONG
    return {"contact": _contact(contact_models(joint.name), without, "contact model: the joint is then one-sided")}


def _stop(joint: Kind[JointKind]) -> dict[str, Schema]:
    """The ends of the coordinate of a joint, if it has one."""
    kind = registry.stop_of(joint.name)
    if kind is None:
        return {}
    contact = _contact(stop_models(), ALONG, "contact model of the stop")
    return {"stop": of.table({**of.fields(kind), "contact": contact}, (), kind.summary)}


def _own_friction(joint: Kind[JointKind]) -> dict[str, Schema]:
    """Friction of a joint without play, if it may have any."""
    if not joint.leaf.rubs:
        return {}
    more: Mapping[str, Field] = joint.leaf.rubs_with
    needed = [key for key, field in more.items() if field.default is REQUIRED]
    tables = []
    for name, fields in friction_models().items():
        keys = {key: of.field(field) for key, field in {**fields, **more}.items()}
        tables.append(of.table({"model": {"const": name}, **keys}, ("model", *needed)))
    number = [] if needed else [of.number("", "coefficient of friction", "not negative")]
    return {"friction": {"anyOf": [*number, *tables], "description": "friction without play, by its own reaction"}}


def _contact(
    models: Collection[str] | None = None,
    without: Collection[str] = (),
    meaning: str = "contact model of the clearance",
) -> Schema:
    """The contact model: its name, or a table with its fields, which may also hold fields of other models."""
    laws, statics = registry.kinds("normal"), registry.kinds("stiffness")
    plain = {name: kind for name, kind in registry.kinds("contact").items() if models is None or name in models}
    oiled = [kind for kind in plain.values() if kind.leaf.oiled]
    every = _keys_of_contacts((*statics.values(), *laws.values(), *plain.values()), bool(oiled))
    every = {key: value for key, value in every.items() if key not in without}
    tables = []
    for kind in oiled:
        needed = ["model", "bush_radius", *_needed_by_all(registry.kinds("film").values())]
        tables.append(of.table({"model": of.choice(kind), **every, **of.fields(kind)}, dict.fromkeys(needed)))
    for law in (*(dry for dry in plain.values() if not dry.leaf.oiled), *laws.values()):
        own_fields = {key: field for key, field in of.fields(law).items() if key != "friction" and key not in without}
        tables.append(of.table({"model": of.choice(law), **every, **own_fields}, ("model", *of.needed(law))))
    return {"anyOf": [{"enum": [*plain, *laws]}, *tables], "description": meaning}


def _keys_of_contacts(kinds: Collection[Kind[object]], oiled: bool) -> dict[str, Schema]:
    """Keys that the table of any of these models has."""
    own = _of(CONTACT)
    every: dict[str, Schema] = {"geometry": own["geometry"]}
    for kind in kinds:
        every |= of.fields(kind)
    return every | ({**_oil(), **every} if oiled else {}) | own


def _oil() -> dict[str, Schema]:
    """Keys of the oil in a clearance, besides those of its model."""
    keys: dict[str, Schema] = {}
    for kind in registry.kinds("film").values():
        keys |= of.fields(kind)
    return keys | _of(OIL)


def _needed_by_all(kinds: Collection[Kind[object]]) -> list[str]:
    every = [of.needed(kind) for kind in kinds]
    return [key for key in every[0] if all(key in needed for needed in every)]


def _driver(kind: Kind[DriverKind]) -> Schema:
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
    return of.table({**where, **of.fields(kind)}, (*where, *of.needed(kind)), kind.summary)


def _kind(kind: Kind[object], key: str) -> Schema:
    """A table with the fields of a kind, which is named under `key`."""
    meaning = kind.summary if key == "type" else ""  # laws tell theirs with their name
    return of.table({key: of.choice(kind), **of.fields(kind)}, (key, *of.needed(kind)), meaning)
