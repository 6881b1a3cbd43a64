"""Recorded columns: those that `solvers.output_row` fills, with names and units, and those derived from them.

`<joint>.ex .ey` of a joint with clearance mean the same in every contact model: the offset of the pin centre from the
bush centre, and of a block the component across its guide.  Its travel along the guide is motion (`<body>.x .y`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from rattle import registry
from rattle.description.coordinates import record_of
from rattle.description.model import NUMBERS, Joint, Load, Model, Value
from rattle.equations.contact_table import contact_labels
from rattle.equations.system import System, joint_rows
from rattle.interfaces.joints import JointKind
from rattle.jit import layout as at
from rattle.results.film_columns import film_columns
from rattle.value_types import Tree


def width(system: System, ports: bool = False) -> int:
    """Number of columns of a raw output row, declared in `jit.layout`; ports: with those of all elements."""
    elements = len(system.joints) + len(system.model.loads) if ports else 0
    joints = at.PER_JOINT * len(system.joints) + own_columns(system)
    return motion_width(system) + joints + at.ENERGIES + at.PER_PORT * elements


def own_columns(system: System) -> int:
    """Number of contacts that have a column of their own, behind those of the joints."""
    return int((system.arrays["contact"][:, at.OWN_COLUMN] >= 0).sum())


def motion_width(system: System) -> int:
    """Number of columns of a raw row without forces: bodies, states of the model and signals."""
    return at.PER_BODY * system.body_count + len(system.model.recorded)


def motion_columns(system: System) -> tuple[list[str], dict[str, str]]:
    """Names and SI units of the columns of a raw row without forces."""
    units = {f"{body}.{key}": unit for body in system.bodies for key, unit in at.OUTPUT_BODY.items()}
    units |= system.model.recorded
    return list(units), units


def states_of(system: System) -> slice:
    """Columns of a raw row that hold the states of the model."""
    first = at.PER_BODY * system.body_count + at.PER_JOINT * len(system.joints) + own_columns(system)
    return slice(first, first + len(system.model.states))


def motion(system: System, row: np.ndarray) -> np.ndarray:
    """(3, 3 nb) positions, rates and accelerations [SI] of a raw output row."""
    bodies = row[: at.PER_BODY * system.body_count].reshape(system.body_count, 3, 3)
    return np.ascontiguousarray(bodies.transpose(1, 0, 2)).reshape(3, -1)


def quantities(system: System) -> list[tuple[str, int, int]]:
    """Quantities whose peaks are found within the steps: name, how it is formed, first column after those of bodies.

    The largest magnitude of the force of every joint, its moment, normal and tangential force, of effort and power of
    the drivers, the larger tension of a belt, the largest penetration of contacts, the largest offset of a pin in oil
    [SI].  For a joint without play,
    or a massless link, N has the magnitude of the force; `<joint>.pressing` is the largest N of a
    link, whose N may also be negative.
    """
    watched: list[tuple[str, int, int]] = []
    for n, name in enumerate(system.joints):
        c = at.PER_JOINT * n
        if name in system.model.drivers:
            effort = system.model.drivers[name].leaf.effort[0]
            watched += [(f"{name}.{effort}", at.OF_SIZE, c + at.EFFORT), (f"{name}.power", at.OF_SIZE, c + at.POWER)]
            continue
        watched += [(f"{name}.{key}", how, c + column) for key, how, column in _watched(system.model.joints[name])]
    return watched


def _watched(joint: Joint) -> list[tuple[str, int, int]]:
    """Those of a joint: what each is called, how it is formed, its column among those of the joint."""
    if joint.leaf.bodies:
        return [("torque", at.OF_SIZE, at.EFFORT)]
    watched = [("force", at.OF_VECTOR, at.FX)]
    if passes_moment(joint):
        watched.append(("moment", at.OF_SIZE, at.MOMENT))
    if joint.leaf.presses and joint.contact is None:
        watched += [(key, at.OF_SIZE, column) for key, column in PRESSES.items()]
    watched += [(key, at.OF_SIZE, column) for key, column in frictions(joint)]
    if joint.stop is not None:
        watched.append(("stop", at.OF_SIZE, at.STOP))
    return [*watched, *_watched_of_contact(joint)]


def _watched_of_contact(joint: Joint) -> list[tuple[str, int, int]]:
    """The same of its contact, if it has one."""
    kind, sided, contact = joint_rows(joint)[0], joint.one_sided, joint.contact
    if sided is not None and sided.records:
        return [(sided.records[0], at.OF_LARGER, at.JOINT_NORMAL)] if joint.is_loose else []
    if contact is None:
        return []
    if kind is not None:
        return [("pressing", at.OF_NEGATIVE, at.EFFORT)] if kind.name != joint.kind else []
    watched = [("normal", at.OF_VALUE, at.JOINT_NORMAL), ("tangential", at.OF_SIZE, at.JOINT_TANGENT)]
    watched.append(("penetration", at.OF_VALUE, at.PENETRATION))
    return [*watched, ("offset", at.OF_VECTOR, at.EX)] if contact.film is not None else watched


PRESSES = {"normal": at.JOINT_NORMAL, "tangential": at.JOINT_TANGENT}  # forces on B of a joint that presses


def frictions(joint: Joint) -> tuple[tuple[str, int], ...]:
    """What the friction of a joint without play is called, and where it stands: one, or those of the pins of a rod."""
    if joint.friction is None:
        return ()
    if joint.leaf.touches:
        return (("rolling", at.EFFORT),)
    if len(joint.leaf.tangents) < 2:
        return (("friction", at.JOINT_TANGENT),)
    return (("friction_a", at.JOINT_TANGENT), ("friction_b", at.JOINT_NORMAL))


def passes_moment(joint: Joint) -> bool:
    """True if the joint may transmit a moment: by rows, contacts in their place, friction, or a stop of its angle."""
    kind = joint_rows(joint)[0]
    by_contacts = kind is None and not joint.held_by_stops
    return by_contacts or (kind is not None and kind.leaf.moment) or joint.friction is not None or joint.stops_angle


def columns(
    system: System, raw: np.ndarray, turning: np.ndarray | None = None
) -> tuple[np.ndarray, list[str], dict[str, str]]:
    """Raw rows (n, width) -> named columns (n, k) in SI units, their names and units; turning: see `film_columns`."""
    model, taking = system.model, _Taking()
    c = 0
    for body in system.bodies:
        for k, (key, unit) in enumerate(at.OUTPUT_BODY.items()):
            taking.add(f"{body}.{key}", unit, c + k)
        c += at.PER_BODY
    for name in system.joints:
        if name in model.drivers:
            effort_name, unit = model.drivers[name].leaf.effort
            taking.add(f"{name}.{effort_name}", unit, c + at.EFFORT)
            taking.add(f"{name}.power", "W", c + at.POWER)
        elif model.joints[name].leaf.bodies:
            taking.add(f"{name}.torque", "N*m", c + at.EFFORT)
            joint = model.joints[name]
            taking.add(f"{name}.slip", "rad/s", c + at.EX, overrun(joint, *rates_of(system, joint, raw)))
            taking.add(f"{name}.locked", "", c + at.JOINT_TANGENT)
        else:
            _take_joint(taking, system, model.joints[name], raw, c, turning)
        c += at.PER_JOINT
    for owner, label in contact_labels(model):
        if label:
            taking.add(f"{owner}.{label}.normal", "N", c)
            c += 1
    for name, unit in model.recorded.items():
        taking.add(name, unit, c)
        c += 1
    for k, (key, unit) in enumerate(at.OUTPUT_ENERGY.items()):
        taking.add(f"energy.{key}", unit, c + k)
    kinetic, potential, work, dissipated = raw[:, c : c + at.ENERGIES].T
    total = kinetic + potential - work + dissipated
    taking.add("energy.balance", "J", c, total - total[:1])
    data = raw.take(taking.columns, axis=1)
    for place, values in taking.derived.items():
        data[:, place] = values
    return data, list(taking.units), taking.units


class _Taking:
    """Columns of raw rows that a result takes, in its order, and what stands in place of some."""

    def __init__(self) -> None:
        self.units: dict[str, str] = {}  # by name
        self.columns: list[int] = []
        self.derived: dict[int, np.ndarray] = {}  # by place

    def add(self, name: str, unit: str, column: int, values: np.ndarray | None = None) -> None:
        """The next column, or `values` in its place."""
        if values is not None:
            self.derived[len(self.columns)] = values
        self.units[name] = unit
        self.columns.append(column)


def _take_joint(
    taking: _Taking, system: System, joint: Joint, raw: np.ndarray, c: int, turning: np.ndarray | None
) -> None:
    """Columns of a joint, its raw ones from c on: forces, friction, stop, contact, film."""
    name = joint.name
    taking.add(f"{name}.fx", "N", c + at.FX)
    taking.add(f"{name}.fy", "N", c + at.FY)
    if passes_moment(joint):
        taking.add(f"{name}.moment", "N*m", c + at.MOMENT)
    if joint.leaf.presses and joint.contact is None:
        for key, column in PRESSES.items():
            taking.add(f"{name}.{key}", "N", c + column)
    for key, column in frictions(joint):
        taking.add(f"{name}.{key}", joint.friction_unit, c + column)
    if joint.stop is not None:
        taking.add(f"{name}.stop", "N*m" if joint.stops_angle else "N", c + at.STOP)
    _take_contact(taking, system, joint, raw, c, turning)


def _take_contact(
    taking: _Taking, system: System, joint: Joint, raw: np.ndarray, c: int, turning: np.ndarray | None
) -> None:
    """Columns of the contact of a joint, if it has one, and of the oil in it."""
    name = joint.name
    if joint.one_sided is not None and joint.one_sided.records:
        for key, force in zip(joint.one_sided.records, _two_forces(joint, raw, c), strict=True):
            taking.add(f"{name}.{key}", "N", c + at.JOINT_NORMAL, force)
    elif joint.contact is not None:
        of_contact = _of_contact(system, joint, joint_rows(joint)[0], raw, c)
        for key, column in (OF_SURFACE if joint.leaf.touches else OF_CONTACT).items():
            taking.add(f"{name}.{key}", at.OUTPUT_JOINT.get(key, "m"), c + column, of_contact.get(key))
        if joint.contact.film is not None:
            for key, (unit, values) in film_columns(system, joint, raw, c, turning).items():
                taking.add(f"{name}.{key}", unit, c + at.EX, values)


REACTIONS = ("N", "N*m", "W")  # units of what follows from reactions


def reaction_columns(system: System, units: Mapping[str, str]) -> np.ndarray:
    """(k,) True for those of the columns, with these names and units, that follow from reactions.

    The forces of compliant contacts and films follow from positions and rates.
    """
    drivers, joints = system.model.drivers, system.model.joints
    held = {name for name in system.joints if name in drivers or joint_rows(joints[name])[0] is not None}
    return np.array([name.rpartition(".")[0] in held and unit in REACTIONS for name, unit in units.items()])


def _two_forces(joint: Joint, raw: np.ndarray, c: int) -> tuple[np.ndarray, np.ndarray]:
    """The larger and the smaller force (n,) [N] of two strands; of a belt that cannot stretch, about its pretension."""
    first, second = raw[:, c + at.JOINT_NORMAL], raw[:, c + at.JOINT_TANGENT]
    if not joint.is_loose:
        half, pretension = 0.5 * raw[:, c + at.EFFORT], float(joint.fields["pretension"])
        first, second = pretension + half, pretension - half
    return np.maximum(first, second), np.minimum(first, second)


def rates_of(system: System, joint: Joint, raw: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rates (n,) [rad/s] of bodies A and B of a joint."""

    def rate(body: str) -> np.ndarray:
        column = raw[:, 0 if body == "ground" else at.PER_BODY * system.bodies.index(body) + at.RATE + 2]
        return np.zeros_like(column) if body == "ground" else column

    return rate(joint.a.body), rate(joint.b.body)


def overrun(joint: Joint, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Rate (n,) [rad/s] at which body B of a clutch overruns body A in its sense; a, b: of both bodies [rad/s]."""
    rate: np.ndarray = float(joint.fields["sense"]) * (b - a)
    return rate


OF_CONTACT = {"ex": at.EX, "ey": at.EY, "normal": at.JOINT_NORMAL, "tangential": at.JOINT_TANGENT}
OF_CONTACT["penetration"] = at.PENETRATION
OF_SURFACE = {"gap": at.PENETRATION, **{key: OF_CONTACT[key] for key in ("normal", "tangential", "penetration")}}


def _of_contact(
    system: System, joint: Joint, kind: registry.Kind[JointKind] | None, raw: np.ndarray, c: int
) -> dict[str, np.ndarray]:
    """Columns (n,) [SI] of a joint with clearance that its raw columns from c on do not hold as a result shows them."""
    derived: dict[str, np.ndarray] = {}
    if joint.leaf.touches:
        depth = raw[:, c + at.PENETRATION]
        return {"gap": -depth, "penetration": np.maximum(depth, 0.0), "tangential": -raw[:, c + at.JOINT_TANGENT]}
    ex, ey = raw[:, c + at.EX], raw[:, c + at.EY]
    if kind is not None:  # otherwise only contacts act on it
        fx, fy = raw[:, c + at.FX], raw[:, c + at.FY]
        distance = np.hypot(ex, ey)
        link = kind.name != joint.kind
        derived["tangential"] = derived["penetration"] = np.zeros_like(fx)
        if link:
            with np.errstate(invalid="ignore", divide="ignore"):
                derived["normal"] = np.where(distance > 0.0, -(fx * ex + fy * ey) / distance, 0.0)
            derived["penetration"] = distance - float(joint.clearance)
        else:
            derived["normal"] = np.hypot(fx, fy)
            if joint.one_sided is not None and joint.one_sided.contacts == 1:  # its row is the slope of the gap
                derived["normal"] = np.copysign(derived["normal"], raw[:, c + at.EFFORT])
    if joint.line is not None:
        derived["ex"], derived["ey"] = _play(system, joint, raw, ex, ey)
    return derived


def _play(
    system: System, joint: Joint, raw: np.ndarray, ex: np.ndarray, ey: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The play in an offset (n,) [m] from a line: its component across, and along it only what the ends leave."""
    turned = 0.0 if joint.a.body == "ground" else raw[:, at.PER_BODY * system.bodies.index(joint.a.body) + at.PLACE + 2]
    axis = turned + (0.0 if joint.line is None else joint.line)
    along = ex * np.cos(axis) + ey * np.sin(axis)
    along = along - joint.play.play_along(joint.fields, along)
    return ex - along * np.cos(axis), ey - along * np.sin(axis)


def _form_of_joint(joint: Joint) -> dict[str, Any]:
    """What a drawing needs of a joint."""
    form: dict[str, Any] = {
        "type": joint.kind,
        "bodies": [joint.a.body, joint.b.body],
        "points": [list(joint.a.at), list(joint.b.at)],
        "clearance": joint.clearance,
        "contact": joint.contact.title if joint.contact else "",
        "rigid": joint.contact is not None and joint.contact.rigid,
    }
    if joint.leaf.bodies:
        form["sense"] = joint.fields["sense"]
    if joint.coordinate:
        form["coordinate"] = joint.coordinate
    if joint.line is not None:
        form["axis"] = joint.line
        if -math.inf < (travel := joint.leaf.travel(joint.fields)) < math.inf:
            form["travel"] = travel
    form["fields"] = numbers(joint.fields)
    for key, outline_of in (("outline", joint.leaf.bearing_outline), ("borne_outline", joint.leaf.borne_outline)):
        outline = outline_of(joint.fields)
        if outline is not None:
            form[key] = [[x, y] for x, y in outline]
    if joint.stop is not None:  # an end that there is not is None
        ends = (joint.stop.minimum, joint.stop.maximum)
        form["stop"] = [end if -math.inf < end < math.inf else None for end in ends]
        form["rigid_stop"] = joint.stop.contact.rigid
    form |= {table: list(sizes) for table, sizes in joint.dimensions.items()}
    return form | _form_of_contact(joint)


def _form_of_contact(joint: Joint) -> dict[str, Any]:
    """Oil, bush, corners and friction of the contact of a joint, as far as it has them."""
    form: dict[str, Any] = {}
    if joint.leaf.touches:
        form["corners"] = {label: list(corner) for label, corner in joint.corners.items()}
        form["mu"] = joint.contact.mu if joint.contact is not None else 0.0
    if joint.contact and (film := joint.contact.film) is not None:
        form["oil"] = {key: getattr(film, key) for key in ("boundary", "density", "specific_heat")}
    if joint.contact and joint.contact.bush_radius:
        form["bush_radius"] = joint.contact.bush_radius
    return form


def _form_of_load(load: Load) -> dict[str, Any]:
    """What a drawing needs of a load."""
    record, quantities = record_of(load.kind), registry.kinds("load")[load.kind].leaf.quantities
    return {
        "type": load.kind,
        "bodies": [load.a.body, load.b.body],
        "points": [list(load.a.at), list(load.b.at)],
        "fields": numbers(load_fields(load)),
        **({"coordinate": record.coordinate, "power": record.power} if record else {}),
        **({"quantities": [*quantities]} if quantities else {}),
    }


def geometry(model: Model) -> dict[str, Any]:
    """What a drawing of the mechanism needs: points [m] in the frame of their body, relative to its mass centre."""
    return {
        "bodies": {
            name: {
                "points": {key: list(spot) for key, spot in body.points.items()},
                **({"outline": [list(map(list, ring)) for ring in body.outline]} if body.outline else {}),
            }
            for name, body in model.bodies.items()
        },
        "ground": {"points": {key: list(spot) for key, spot in model.ground.items()}},
        "joints": {name: _form_of_joint(joint) for name, joint in model.joints.items()},
        "loads": {name: _form_of_load(load) for name, load in model.loads.items()},
        "driven": [driver.joint for driver in model.drivers.values() if driver.joint],
        "drivers": {name: driver.joint for name, driver in model.drivers.items() if driver.joint},
    }


def numbers(fields: Tree) -> dict[str, Any]:
    """Those values of fields [SI] that are finite numbers, or pairs of such."""

    def known(value: Any) -> bool:
        return isinstance(value, float | int) and -math.inf < value < math.inf

    lists = {key: list(value) if isinstance(value, tuple) else value for key, value in fields.items()}
    return {
        key: value for key, value in lists.items() if all(map(known, value if isinstance(value, list) else [value]))
    }


def load_fields(load: Load) -> dict[str, Value | str]:
    """Values of a load [SI] by the name of their field; those of fields with several values are left out."""
    kind = registry.kinds("load")[load.kind]
    return {key: values[0] for key, values in load.fields.items() if kind.fields[key].shape not in NUMBERS}
