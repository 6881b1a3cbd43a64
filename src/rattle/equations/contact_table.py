"""The contacts of a mechanism as flat arrays: which joints have them, their geometry and laws with parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from rattle import registry
from rattle.description.model import Choice, Contact, Joint, Model, is_ground
from rattle.interfaces.contacts import ContactGeometry, OwnContact
from rattle.jit import layout as at
from rattle.language.local_function import packed
from rattle.language.recorded import bare, hypot

GEOMETRIES = (
    "clearance",
    "one-sided",
    "stop",
    "clutch",
    "worn",
)  # families of kernels that give the geometry of a contact, in one table
# tables of kernels that contacts call: the families in them, and the column of `contact` that names an entry
CONTACT_TABLES = {
    "clearance_table": (GEOMETRIES, at.SHAPE),
    "stiffness_table": (("stiffness",), at.STATIC),
    "normal_table": (("normal", "tension"), at.NORMAL_LAW),
    "friction_table": (("friction",), at.FRICTION),
    "film_table": (("film",), at.FILM_LAW),
}

NO_FILM = (-1, -1)
FEWEST = 3  # contacts of one kind of a surface from which on a bound for all of them saves time


class ContactGroup(NamedTuple):
    """Contacts of one joint with the same geometry: those in place of its rows, or those of its stop."""

    kind: registry.Kind[ContactGeometry]
    contact: Contact
    parameters: tuple[float, ...]  # of the kernel [SI]
    corners: tuple[int, ...]  # contacts of the kind that there are
    path: tuple[str, ...]  # of its contact model in the model file
    bends: tuple[float, float, float] = (0.0, 0.0, 0.0)  # see `ContactGeometry.bends`
    labels: tuple[str, ...] = ()  # of its contacts, if results show N of each


def contact_groups(joint: Joint) -> list[ContactGroup]:
    """All contacts of a joint, which act in place of its rows (clearance, one-sided) or besides them (stop)."""
    groups = []
    points = (*joint.a.at, *joint.b.at)
    play = registry.play_of(joint.kind)
    if joint.contact is not None and play is not None and joint.is_loose:
        sizes = [size for table in joint.dimensions.values() for size in table]
        gap = _gap(joint.clearance, joint.contact)
        p, bends = tuple(packed([*points, *gap, *joint.numbers, *sizes])), play.leaf.bends(joint.fields, gap)
        corners, contact = tuple(range(play.leaf.contacts)), joint.contact
        if (wear := joint.worn) is not None:
            play = registry.kinds("worn")[play.name]
            p, contact = (*p, *play.leaf.parameters(wear)), replace(contact, static=wear.bed(p[at.CLEARANCE]))
        groups.append(ContactGroup(play, contact, p, corners, ("joints", joint.name, "contact"), bends))
    for sided in registry.sides_of(joint.kind, joint.fields):
        if joint.contact is None or not joint.is_loose:
            continue
        p = tuple(packed([*points, *sided.leaf.parameters(joint.fields, joint.constants, joint.corners)]))
        bends = sided.leaf.bends(joint.fields, joint.constants)
        path, count = ("joints", joint.name, "contact"), sided.leaf.count(joint.fields, joint.corners)
        labels = sided.leaf.labels(joint.fields, joint.corners)
        groups.append(ContactGroup(sided, joint.contact, p, tuple(range(count)), path, bends, labels))
    kind = registry.stop_of(joint.kind)
    if joint.stop is not None and kind is not None:
        ends = (joint.stop.minimum, joint.stop.maximum)
        p = (*points, *ends, 0.0 if joint.line is None else joint.line)
        corners = tuple(k for k, end in enumerate(ends) if math.isfinite(bare(end)))
        groups.append(ContactGroup(kind, joint.stop.contact, p, corners, ("joints", joint.name, "stop", "contact")))
    return groups


def contact_labels(model: Model) -> list[tuple[str, str]]:
    """Joint and label of every contact, in the order of the table; no label where a joint has one only."""
    labels: list[tuple[str, str]] = []
    for joint in model.joints.values():
        for group in contact_groups(joint):
            labels += [(joint.name, group.labels[corner] if group.labels else "") for corner in group.corners]
        if joint.leaf.own_contact(joint.fields) is not None:
            labels.append((joint.name, ""))
    return labels


def contact_table(
    model: Model, number: Mapping[str, int], values: list[float], length: float
) -> tuple[list[tuple[int, ...]], list[tuple[float, ...]], list[float]]:
    """One entry per contact point, see `layout`: geometry and laws with their parameters; its entry in `lever`.

    Then the tables that oil films read.  Parameters are appended to `values`; length: of the mechanism [m].
    """
    table: list[tuple[int, ...]] = []
    coefficients: list[float] = []
    levers: list[tuple[float, ...]] = []
    states = own_columns = 0
    for n, joint in enumerate(model.joints.values()):
        a, b = number[joint.a.body], number[joint.b.body]
        for kind, contact, parameters, corners, _, bends, labels in contact_groups(joint):
            leaf, place, size = kind.leaf, len(values), 1.0 if kind.leaf.angular else length
            values += parameters
            laws: tuple[int, ...]
            if contact.normal is None:
                laws = (-1, -1, -1, len(values), -1, -1)
                values += contact.fields.values()
            else:
                laws = (
                    *_law("stiffness", contact.static, values),
                    *_law("normal", _with_mass(contact.normal, model, joint, leaf.angular), values),
                    *_law("friction", contact.friction, values),
                )
            film = _film(contact, joint.clearance, values, coefficients)
            own = registry.kinds("friction")[contact.friction.kind].leaf.states if contact.friction else 0
            arms, turning = leaf.levers(parameters), float(_turning(leaf))
            for corner in corners:
                owned = (
                    n,
                    int(contact.rigid),
                    states,
                    own,
                    leaf.column_of(corner),
                    leaf.sense(corner),
                    0,
                    0,
                    *film,
                    leaf.worn,
                    own_columns if labels else -1,
                    len(corners) if leaf.bounded and len(corners) >= FEWEST and corner == corners[0] else 0,
                    int(contact.ends_by_force),
                    int(contact.vanishes and not leaf.worn),
                )
                own_columns += 1 if labels else 0
                table.append((_tag(kind), a, b, place, corner, *laws, *owned))
                states += own
                lever = (*arms, turning, leaf.curved(corner), float(leaf.angular), float(leaf.one_way(joint.fields)))
                levers.append((*lever, leaf.scale_at(corner, parameters, size), size, *bends))
        alone = joint.leaf.own_contact(joint.fields)
        if alone is not None:
            entry, its_lever = _own_contact(alone, joint, values)
            owned = (
                n,
                int(alone.rigid),
                states,
                alone.states,
                at.EFFORT,
                alone.sense,
                int(alone.level),
                int(alone.toothed),
                *NO_FILM,
                0,
                -1,
                0,
                0,
                0,
            )
            table.append((entry[0], a, b, *entry[1:], *owned))
            states += alone.states
            levers.append(its_lever)
    _share_law(table, values)
    return table, levers, coefficients


def _gap(clearance: float, contact: Contact) -> tuple[float, float]:
    """Clearance and radius of the bush [m] of the dry contact: with oil it begins at the boundary film.

    The point of contact stays midway between pin and bush.
    """
    if contact.film is None:
        return clearance, contact.bush_radius
    return clearance - contact.film.boundary, contact.bush_radius - 0.5 * contact.film.boundary


def _film(contact: Contact, clearance: float, values: list[float], coefficients: list[float]) -> tuple[int, int]:
    """Kernel of the oil film of a contact and place of its parameters, which are appended, as is the table it reads."""
    if contact.film is None:
        return NO_FILM
    law = contact.film.law
    kind, place = registry.kinds("film")[law.kind], len(values)
    values += kind.leaf.pack(law.values, clearance, contact.film.boundary, len(coefficients))
    coefficients += kind.leaf.table(law.values).tolist()
    return kind.tag, place


def _turning(leaf: type[ContactGeometry]) -> int:
    """WALLS_TURN of a kind of geometry: 0, 1 for walls that turn with A, 2 with B."""
    return 0 if not leaf.walls_turn else 1 if leaf.turning == at.A_BODY else 2


def _tag(kind: registry.Kind[ContactGeometry]) -> int:
    """Index of a kind of geometry in the table of all of them."""
    return kind.tag + sum(len(registry.kinds(family)) for family in GEOMETRIES[: GEOMETRIES.index(kind.family)])


def _own_contact(own: OwnContact, joint: Joint, values: list[float]) -> tuple[tuple[int, ...], tuple[float, ...]]:
    """Kernel and places of the parameters of the contact that a joint consists of; its entry in `lever`."""
    kind, place = registry.kinds("clutch")[own.kind], len(values)
    parameters = (*joint.a.at, *joint.b.at, *own.geometry)
    values += parameters
    law = len(values)
    values += [0.0] * at.MOST_TORQUE  # no restitution, no friction
    values += own.law
    leaf = kind.leaf
    flags = (_turning(leaf), leaf.rounded, leaf.angular, leaf.one_way(joint.fields))
    lever = (*leaf.levers(parameters), *map(float, flags))
    return (_tag(kind), place, 0, -1, -1, -1, law, -1, -1), (
        *lever,
        kind.leaf.scale(parameters, 1.0),
        1.0,
        0.0,
        0.0,
        0.0,
    )


def _share_law(table: Sequence[tuple[int, ...]], values: list[float]) -> None:
    """Give contacts that joints consist of, which have no restitution, the restitution law of the others."""
    rigid = [entry for entry in table if entry[at.IMPACT] == 1]
    law = max((values[entry[at.NORMAL_P] + at.RESTITUTION_LAW] for entry in rigid), default=0.0)
    for entry in rigid:
        values[entry[at.NORMAL_P] + at.RESTITUTION_LAW] = law


def _law(family: str, choice: Choice | None, values: list[float]) -> tuple[int, int]:
    if choice is None:
        return -1, -1
    kind = registry.law(family, choice.kind)
    place = len(values)
    values += kind.leaf.pack(choice.values)
    return kind.tag + (len(registry.kinds("normal")) if kind.family == "tension" else 0), place


def effective_mass(model: Model, joint: Joint, angular: bool) -> float:
    """Mass [kg] that a contact of a joint moves, as if both bodies were free.

    If its gap is an angle: inertia [kg m^2], as if each body turned about the point of the joint.
    """
    light = 0.0
    for end in (joint.a, joint.b):
        if not is_ground(end.body):
            body, arm = model.bodies[end.body], hypot(*end.at)
            light += 1.0 / (body.inertia + body.mass * (arm * arm) if angular else body.mass)
    return 1.0 / light


def _with_mass(choice: Choice, model: Model, joint: Joint, angular: bool) -> Choice:
    """Fill in the effective mass [kg or kg m^2] if a law needs one."""
    if choice.number("effective_mass", 1.0) > 0.0:
        return choice
    return Choice(choice.kind, {**choice.values, "effective_mass": effective_mass(model, joint, angular)})
