"""JSON Schema of the model file, made from the registry, for editors that complete and check the text as it is typed.

It has every key, kind and unit.  References to other parts (points, names, dimensions of expressions)
are checked by the reader only; the keyword `x-names` says to which parts a text refers.

Source: JSON Schema, draft 2020-12.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace

from rattle import registry
from rattle.description import schema_pieces as of
from rattle.description.read_contact import ALONG, contact_models, stop_models
from rattle.description.read_friction import friction_models, stated_size
from rattle.description.read_parts import moved_joints
from rattle.description.read_wear import kind_wears
from rattle.description.schema_pieces import Schema
from rattle.description.tables import (
    CONTACT,
    ENDS,
    JOINT_FRICTION,
    MODEL,
    OIL,
    WHOLE_BODIES,
    Either,
    Form,
    Named,
    OfKinds,
    Part,
)
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
        return of.named(part(entry.entry), entry.meaning, entry.names)
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
        return [joint_entry(kind, entry.common) for kind in registry.kinds("joint").values()]
    if entry.family == "driver":
        return [_driver(kind, entry.common) for kind in registry.kinds("driver").values()]
    return [_kind(kind, entry.key) for kind in registry.kinds(entry.family).values()]


def joint_entry(kind: Kind[JointKind], keys: Form) -> Schema:
    """What may be written as a joint of a kind; keys: those that all joints have in common."""
    common = {
        key: OF_JOINT[entry.shape](kind) if isinstance(entry, Field) and entry.shape in OF_JOINT else part(entry)
        for key, entry in keys.fields.items()
        if _may_have(kind, key)
    }
    # behind the tables of its play
    after: dict[str, Schema] = {key: common.pop(key) for key in ("stop", "friction") if key in common}
    play = registry.play_of(kind.name)
    sizes: Mapping[str, Mapping[str, Field]] = play.leaf.dimensions if play else {}
    dimensions = {
        key: of.table({name: of.field(size) for name, size in each.items()}, each) for key, each in sizes.items()
    }
    properties: dict[str, Schema] = {"type": of.choice(kind), **common, **dimensions, **after, **of.fields(kind)}
    return of.table(properties, ("type", "connect", *of.needed(kind)), kind.summary)


def _may_have(joint: Kind[JointKind], key: str) -> bool:
    """True if a kind of joint may have one of the keys that joints have in common."""
    able = {
        "bearing": kind_wears(joint),
        "clearance": not joint.leaf.bodies and not joint.leaf.touches, "contact": not joint.leaf.bodies,
        "wear": kind_wears(joint), "length": kind_wears(joint),
        "stop": registry.stop_of(joint.name) is not None, "friction": joint.leaf.rubs,
    }  # fmt: skip
    return able.get(key, True)


def _of(form: Form) -> dict[str, Schema]:
    return {key: part(entry) for key, entry in form.fields.items()}


def _ends(joint: Kind[JointKind]) -> Schema:
    """The two ends of a joint."""
    return of.field(WHOLE_BODIES if joint.leaf.bodies else ENDS)


def _contact_of(joint: Kind[JointKind]) -> Schema:
    """The contact of a joint: of its clearance, or of a joint that is one-sided with it."""
    name = joint.leaf.lifting[0] if joint.leaf.lifting is not None else joint.name
    sided = registry.one_sided_of(name)
    if sided is None:
        return _contact()
    without = () if sided.leaf.slides else ALONG
    return _contact(contact_models(name), without, "contact model: the joint is then one-sided")


def _stop(joint: Kind[JointKind]) -> Schema:
    """The ends of the coordinate of a joint."""
    kind = registry.stop_of(joint.name)
    assert kind is not None, "asked of joints with a coordinate"
    contact = _contact(stop_models(), ALONG, "contact model of the stop")
    return of.table({**of.fields(kind), "contact": contact}, (), kind.summary)


def _own_friction(joint: Kind[JointKind]) -> Schema:
    """Friction of a joint without play."""
    more: Mapping[str, Field] = joint.leaf.rubs_with
    needed = [key for key, field in more.items() if field.default is REQUIRED]
    tables = []
    for name, fields in friction_models().items():
        keys = {key: of.field(field) for key, field in {**fields, **more}.items()}
        tables.append(of.table({"model": {"const": name}, **keys}, ("model", *needed)))
    if (size := stated_size(joint)) is not None:
        tables.append(of.table({size[0]: of.field(size[1])}, size[:1]))
    number = [] if needed else [of.number("", "coefficient of friction", "not negative")]
    return {"anyOf": [*number, *tables], "description": JOINT_FRICTION.meaning}


OF_NAMES = ("viscosity", "bush_radius")  # what a named oil and a fit say


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
        needed = ["model", *_needed_by_all(registry.kinds("film").values())]
        needed = [key for key in needed if key not in OF_NAMES]
        tables.append(of.table({"model": of.choice(kind), **every, **of.fields(kind)}, dict.fromkeys(needed)))
        tables[-1] |= {"if": {"not": {"required": ["oil"]}}, "then": {"required": ["viscosity"]}}
    for law in (*(dry for dry in plain.values() if not dry.leaf.oiled), *laws.values()):
        own_fields = {key: field for key, field in of.fields(law).items() if key != "friction" and key not in without}
        keys, needed = {"model": of.choice(law), **every, **own_fields}, of.needed(law)
        if law.name in plain and plain[law.name].leaf.contacts:
            del keys["damping"]
        tables.append(of.table(keys, ("model", *(key for key in needed if key != "restitution"))))
        if "restitution" in needed:  # or damping in its place
            tables[-1] |= {"if": {"not": {"required": ["damping"]}}, "then": {"required": ["restitution"]}}
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


def _driver(kind: Kind[DriverKind], keys: Form) -> Schema:
    """A driver, with the way of those to say where it acts that names what this kind drives."""
    way = next(way for way in keys.ways if kind.leaf.drives in way)
    where = {key: OF_DRIVER[key](kind) if key in OF_DRIVER else part(entry) for key, entry in way.items()}
    return of.table({**where, **_of(keys), **of.fields(kind)}, (*where, *of.needed(kind)), kind.summary)


def _kind(kind: Kind[object], key: str) -> Schema:
    """A table with the fields of a kind, which is named under `key`."""
    meaning = kind.summary if key == "type" else ""  # laws tell theirs with their name
    return of.table({key: of.choice(kind), **of.fields(kind)}, (key, *of.needed(kind)), meaning)


OF_JOINT: Mapping[str, Callable[[Kind[JointKind]], Schema]] = {  # what follows from the kind, by shape
    "ends": _ends, "contact": _contact_of, "stop": _stop, "own friction": _own_friction,
}  # fmt: skip
OF_DRIVER: Mapping[str, Callable[[Kind[DriverKind]], Schema]] = {
    "joint": lambda kind: {
        "type": "string", "description": f"a {' or '.join(moved_joints(kind.name))} joint", of.NAMES: "joints",
    },
    "coordinate": lambda kind: {"const": kind.name.removeprefix("body-")},
}  # fmt: skip
