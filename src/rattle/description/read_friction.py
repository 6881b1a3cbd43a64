"""Reading the `friction` of a joint without play: a number or a table -> `JointFriction`.

A table with the force or torque itself stands for what brakes a joint whatever it bears: a brake, a preload, a seal.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rattle import registry
from rattle.description.model import Choice, Contact, JointFriction
from rattle.description.read_fields import FieldReader
from rattle.description.read_values import quoted
from rattle.description.reading import Path, Table
from rattle.errors import suggest
from rattle.interfaces.fields import Fields
from rattle.interfaces.joints import JointKind
from rattle.registry import Field

SMOOTH = 1e-3  # slip [m/s] at which rolling resistance is regularised beside a contact without friction
SET_VALUED = "coulomb"  # the model that a number means
COULOMB = {
    "mu": Field("", "coefficient of friction", least="not negative"),
    "mu_static": Field("", "coefficient at rest; default: mu", lambda read: read["mu"], least="not negative"),
}
# size of friction that is stated, by the unit of the effort along the coordinate of a joint
STATED = {
    "N": ("force", Field("N", "size of the friction, whatever the joint bears", least="not negative")),
    "N*m": ("torque", Field("N*m", "size of the friction, whatever the joint bears", least="not negative")),
}
SIZES = tuple(key for key, _ in STATED.values())


def friction_models() -> dict[str, Mapping[str, Field]]:
    """Every name that the model of `friction` may have in a joint without play, with its fields."""
    return {SET_VALUED: COULOMB, **{name: law.fields for name, law in registry.kinds("friction").items()}}


def joint_friction(
    reader: FieldReader,
    written: object,
    joint: registry.Kind[JointKind],
    of_joint: Fields | None,
    block: Sequence[float],
    loose: bool,
    path: Path,
) -> JointFriction | None:
    """Friction of one joint, by its own reaction or of a stated size; None after a problem.

    of_joint: its fields, None after a problem with them; block: length of its block [m], then others, if given;
    loose: it has clearance.
    """
    values = reader.values
    if fault := _without_friction(joint, loose):
        values.wrong(path, fault, at_key=True)
        return None
    before = len(values.problems)
    table: Table = written if isinstance(written, Mapping) else {"model": SET_VALUED, "mu": written}
    if any(key in table for key in SIZES):
        return _stated(reader, table, joint, path)
    models, model = friction_models(), str(table.get("model", SET_VALUED))
    if model not in models:
        values.wrong((*path, "model"), f"unknown friction {quoted(table['model'])}{suggest(model, models)}")
        return None
    sizes, fields = joint.leaf.rubs_with, models[model]
    values.keys(table, ["model", *fields, *sizes], path)
    own = {key: reader.field(field, key, table, {}, path) for key, field in sizes.items()}
    read = _numbers_of(reader, fields, table, path if isinstance(written, Mapping) else path[:-1], path)
    if len(values.problems) > before or of_joint is None:
        return None
    try:
        arm = joint.leaf.friction_arm(of_joint, own)
    except ValueError as error:
        values.wrong(path, str(error))
        return None
    reach = 2.0 / block[0] if block and block[0] > 0.0 else 0.0
    if model == SET_VALUED:
        if read["mu_static"] < read["mu"]:
            values.wrong((*path, "mu_static"), f"{read['mu_static']:g} must not be less than mu = {read['mu']:g}")
        return JointFriction(arm, reach, read["mu"], read["mu_static"])
    return JointFriction(arm, reach, law=_law(reader, model, read, path))


def _numbers_of(
    reader: FieldReader, fields: Mapping[str, Field], table: Table, whole: Path, path: Path
) -> dict[str, float]:
    """Values of all fields of a model; whole: of the table, where one is missing."""
    read: dict[str, float] = {}
    for key, field in fields.items():
        read[key] = reader.field(field, key, table, read, path if key in table else whole)
    return read


def stated_size(joint: registry.Kind[JointKind]) -> tuple[str, Field] | None:
    """Key and field of the size of friction along the coordinate of a kind of joint; None if it has no coordinate."""
    return None if joint.leaf.motor is None or not joint.leaf.rubs else STATED[joint.leaf.motor.unit]


def _stated(reader: FieldReader, table: Table, joint: registry.Kind[JointKind], path: Path) -> JointFriction | None:
    """Friction of a size that does not depend on the reaction; None after a problem."""
    values, size = reader.values, stated_size(joint)
    if size is None:
        able = [name for name, kind in registry.kinds("joint").items() if stated_size(kind)]
        key = next(key for key in SIZES if key in table)
        values.wrong((*path, key), f"a {joint.name} has no coordinate to brake; expected {' or '.join(able)}", True)
        return None
    key, field = size
    before = len(values.problems)
    for other in table:
        if other in SIZES and other != key:
            along = "turns" if key == "torque" else "slides"
            unit = f"a {joint.name} joint {along}: write {key} = a number in {field.unit}"
            values.wrong((*path, other), unit, at_key=True)
        elif other != key and (other in ("model", *joint.leaf.rubs_with) or _of_a_model(other)):
            why = f"friction by {other} follows the reaction, a stated {key} does not: write one or the other"
            values.wrong((*path, other), why, at_key=True)
    if len(values.problems) > before:
        return None
    values.keys(table, [key], path)
    stated = reader.field(field, key, table, {}, path)
    return None if len(values.problems) > before else JointFriction(1.0, mu=stated, mu_static=stated, stated=True)


def _of_a_model(key: str) -> bool:
    """True if a model of friction has a field of that name."""
    return any(key in fields for fields in friction_models().values())


def _law(reader: FieldReader, model: str, read: Fields, path: Path) -> Choice:
    """A friction law with its numbers, which must go together."""
    try:
        registry.kinds("friction")[model].leaf.pack(read)
    except ValueError as error:
        reader.values.wrong(path, str(error))
    return Choice(model, read)


def _without_friction(joint: registry.Kind[JointKind], loose: bool) -> str:
    """Why a joint has no friction of its own, in words; "" if it may have."""
    if not joint.leaf.rubs:
        where = " or ".join(name for name, kind in registry.kinds("joint").items() if kind.leaf.rubs)
        return f"a {joint.name} joint has no friction of its own; expected {where}"
    choice = "a joint with clearance has friction in its contact; write friction there, or leave the clearance out"
    return f"one or the other: {choice}" if loose else ""


def rolling_friction(contact: Contact, radius: float) -> JointFriction:
    """The resistance of a disc of this radius [m] that rolls, as dry friction against its turning.

    Beside a compliant contact it is regularised at the slip v1 of the friction there, at the rim of the disc.
    """
    arm = contact.rolling
    if contact.rigid:
        return JointFriction(arm, 0.0, 1.0, 1.0)
    smooth = contact.friction.number("v1", SMOOTH) if contact.friction is not None else SMOOTH
    return JointFriction(arm, law=Choice("coulomb-smooth", {"mu": 1.0, "v1": smooth * arm / radius}))
