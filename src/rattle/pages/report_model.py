"""The model of a report in words and tables: bodies, joints, drivers, loads, parameters, and what was assumed."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from rattle import registry
from rattle.description.model import Contact, Joint, Model, Parameter, ValueTable
from rattle.language.units import parse_quantity
from rattle.pages.report_html import Section, count, enumerated, handy, listed, paragraph, placed, sentence, table
from rattle.pages.report_study import Study
from rattle.value_types import Tree

MOST = 12  # signals or states in a table
COMPLIANT = (
    "Where the surfaces overlap, a force pushes them apart: it stands for what both give way at the contact. It never"
    " pulls. Peak forces depend on its stiffness more than on anything else."
)
GENERAL = (
    "Everything happens in one plane: forces, tilting and misalignment across it are left out.",
    "Bodies are rigid: they do not bend, and do not ring after a blow.",
)


def model_section(s: Study) -> Section:
    """Bodies, joints, drivers, loads, parameters."""
    model, written = s.m.model, json.loads(s.m.to_json())
    tables = [_joints(model, written), _moved(model, written)]
    tables += [_written("load", written.get("loads", {}), "type"), _start(written)]
    tables += _parameters(model, written)
    tables += [_named("signal", written.get("signals", {})), _named("state", written.get("states", {}), "rate")]
    return Section("The model", paragraph(_in_words(model)) + _bodies(model) + placed(tables))


def _in_words(model: Model) -> str:
    counts = [count(len(model.moving_bodies), "body", "bodies"), count(len(model.joints), "joint")]
    counts += [count(len(model.motors), "driver"), count(len(model.loads), "load")]
    gx, gy = model.gravity
    if model.falling is not None:
        gx, gy = 0.0, 0.0
    pull = f"Gravity is {handy(math.hypot(gx, gy), 'm/s^2')}" if gx or gy else "There is no gravity"
    pull = "Gravity is a function of time" if model.falling is not None else pull
    if gx or gy:
        way = {(0, -1): ", downwards", (0, 1): ", upwards", (-1, 0): ", to the left", (1, 0): ", to the right"}
        straight = way.get(((gx > 0) - (gx < 0), (gy > 0) - (gy < 0)))
        pull += straight if straight and (not gx or not gy) else f" along ({gx:.4g}, {gy:.4g})"
    told = "Values are as the model file writes them; a number without a unit is in m, rad, kg, s, N."
    return f"The mechanism has {enumerated(counts)}. {pull}. {told}"


def _bodies(model: Model) -> str:
    rows = []
    for name in model.moving_bodies:
        body = model.bodies[name]
        form = "uniform bar" if body.bar else "plate" if body.outline else ""
        points = ", ".join(f"{point} ({handy(x, 'm')}, {handy(y, 'm')})" for point, (x, y) in body.points.items())
        rows.append((name, form, handy(body.mass, "kg"), handy(body.inertia, "kg*m^2"), points))
    head = ("body", "form", "mass", "moment of inertia", "points, from the mass centre in the frame of the body")
    return table(head, rows, "Bodies")


def _joints(model: Model, written: Tree) -> str:
    rows = []
    for name, joint in model.joints.items():
        ends = [f"{end.body}.{end.name}" if end.name else end.body for end in (joint.a, joint.b)]
        rows.append(
            (
                name, joint.kind.replace("-", " "), " and ".join(ends),
                handy(joint.clearance, "m") if joint.clearance > 0.0 else "",
                _contact_word(joint), _values(written["joints"].get(name, {}), skip=_TOLD), _stop(joint),
            )
        )  # fmt: skip
    head = ("joint", "type", "between", "radial play", "contact", "values", "ends")
    return table(head, rows, "Joints")


_TOLD = ("type", "connect", "clearance", "contact", "stop", "wear", "friction")


def _contact_word(joint: Joint) -> str:
    if joint.contact is None or (joint.clearance == 0.0 and joint.one_sided is None):
        return ""
    return joint.contact.title.replace("-", " ") + (", one-sided" if joint.one_sided is not None else "")


def _stop(joint: Joint) -> str:
    if joint.stop is None:
        return ""
    unit = "rad" if joint.stops_angle else "m"
    return " to ".join(
        handy(end, unit) if math.isfinite(end) else "no end" for end in (joint.stop.minimum, joint.stop.maximum)
    )


def _moved(model: Model, written: Tree) -> str:
    rows = []
    for name, driver in model.motors.items():
        entry = written["drivers"].get(name, {})
        motion = next((f"{key} = {entry[key]}" for key in ("angle", "position", "speed") if key in entry), "")
        rows.append((name, driver.on.replace("'", ""), f"{entry.get('coordinate', '')} ".lstrip() + motion))
    return table(("driver", "acts on", "motion over time t"), rows, "Drivers")


def _written(what: str, entries: Tree, kind: str) -> str:
    """Entries of the model file: name, type and all else as written."""
    rows = [(name, str(own.get(kind, "")).replace("-", " "), _values(own, (kind,))) for name, own in entries.items()]
    return table((what, "type", "values"), rows, f"{what.capitalize()}s")


def _named(what: str, entries: Tree, key: str = "value") -> str:
    rows = []
    for name, entry in entries.items():
        text, more = (entry.get(key, ""), _values(entry, skip=(key,))) if isinstance(entry, Mapping) else (entry, "")
        rows.append((name, _text(text), more))
    some = f" (the first {MOST} of {len(rows)}; all are in the model file below)" if len(rows) > MOST else ""
    return table((what, "is" if key == "value" else "changes by", "values"), rows[:MOST], f"{what.capitalize()}s{some}")


def _values(entry: Mapping[str, object], skip: tuple[str, ...] = ()) -> str:
    """All keys of a table of the model file with their values, as written."""
    return "; ".join(f"{key.replace('_', ' ')} {_text(value)}" for key, value in entry.items() if key not in skip)


def _text(value: Any) -> str:
    if isinstance(value, Mapping):
        return f"({_values(value)})"
    if isinstance(value, list):
        more = f", ... {len(value)} in all" if len(value) > 8 else ""
        return f"[{', '.join(map(_text, value[:8]))}{more}]"
    return str(value).lower() if isinstance(value, bool) else f"{value:.6g}" if isinstance(value, float) else str(value)


def _parameters(model: Model, written: Tree) -> list[str]:
    """A table of the parameters that are given, and one of those that follow from others."""
    free, derived = list[tuple[str, ...]](), list[tuple[str, ...]]()
    for name, p in model.parameters.items():
        told = written.get("parameters", {})
        entry = told.get(name, _of_the_name(p))
        entry = entry if isinstance(entry, Mapping) else {"value": entry}
        text = _text(entry.get("value", ""))
        plain = name not in told or parse_quantity(text) is not None
        dist = "" if not p.dist else " (table of values)" if isinstance(p.dist, ValueTable) else f" ({p.dist})"
        tol = f"±{_text(entry['tol'])}{dist}" if "tol" in entry else dist.strip()
        span = " to ".join(_text(entry[key]) for key in ("min", "max") if key in entry)
        value = text if plain and not isinstance(entry.get("value"), int | float) else handy(p.value, p.unit, 6)
        meaning = ". ".join(filter(None, (p.label, p.description)))
        row = (name, value, text, span, tol, meaning)
        (free if plain else derived).append((row[:2] + row[3:]) if plain else row)
    head = ("parameter", "value", "follows from", "range", "tolerance", "meaning")
    return [table(head[:2] + head[3:], free, "Parameters"), table(head, derived, "Parameters that follow from others")]


def _of_the_name(p: Parameter) -> dict[str, str]:
    """What would be written of a parameter that a fit or a bearing brings along."""
    return {"value": handy(p.value, p.unit, 6), **({"tol": handy(p.tol, p.unit, 6)} if p.tol else {})}


def _start(written: Tree) -> str:
    starts = {name: _values(start) for name, start in written.get("initial", {}).items() if isinstance(start, Mapping)}
    return table(("body or joint", "start values given"), starts.items(), "Start")


# ---------------------------------------------------------------- assumptions
def assumptions_section(s: Study) -> Section:
    """What the model takes as true, what the program has chosen, and what is not modelled."""
    model = s.m.model
    taken = [*GENERAL, *_of_bodies(model), *_of_drivers(model)]
    bare = [name for name, joint in model.joints.items() if joint.contact is None and joint.friction is None]
    plain = [name for name in bare if not model.joints[name].leaf.bodies]
    if plain:
        taken.append(f"Without play and without friction: {enumerated(plain)}.")
    if clutches := [name for name, joint in model.joints.items() if joint.leaf.bodies]:
        taken.append(f"One-way clutches drive in one sense and run free in the other: {enumerated(clutches)}.")
    rubbing = {name: joint.friction for name, joint in model.joints.items() if joint.friction is not None}
    if by_reaction := [name for name, friction in rubbing.items() if not friction.stated]:
        taken.append(f"With friction by their own reaction, without play: {enumerated(by_reaction)}.")
    if stated := [name for name, friction in rubbing.items() if friction.stated]:
        taken.append(f"With friction of a stated size, whatever they bear: {enumerated(stated)}.")
    parts = [listed(taken), contact_table(s)]
    chosen = [sentence(choice) for choice in (*model.remarks, *_chosen(model))]
    if chosen:
        parts += [
            paragraph("Chosen by the program, or worth a second look, because the model leaves it open:"),
            listed(chosen),
        ]
    parts.append(paragraph(_left_out(model)))
    return Section("Assumptions", "".join(parts))


def _of_bodies(model: Model) -> list[str]:
    taken = []
    if bars := [name for name, body in model.bodies.items() if body.bar]:
        taken.append(
            f"Uniform slender bars, from whose length and mass the moment of inertia follows: {enumerated(bars)}."
        )
    if light := [name for name in model.moving_bodies if 0.0 in (model.bodies[name].mass, model.bodies[name].inertia)]:
        taken.append(f"Without mass or moment of inertia: {enumerated(light)}.")
    return taken


def _of_drivers(model: Model) -> list[str]:
    names = list(model.motors)
    if not names:
        return ["No motion is prescribed: loads, gravity and the start decide what happens."]
    verb = "keeps its" if len(names) == 1 else "keep their"
    word = "driver" if len(names) == 1 else "drivers"
    return [f"The {word} {enumerated(names)} {verb} prescribed motion exactly, whatever effort that takes."]


def contact_table(s: Study) -> str:
    """Every contact with its laws and what they assume."""
    told: dict[tuple[str, str, str], list[str]] = {}
    for name, joint in s.m.model.joints.items():
        for place, contact in ((name, joint.contact), (f"{name}, stop", joint.stop.contact if joint.stop else None)):
            if contact is None or (place == name and joint.clearance == 0.0 and joint.one_sided is None):
                continue
            told.setdefault((assumed_by(contact), _laws(contact), _sources(contact)), []).append(place)
    rows = [(", ".join(places), *words) for words, places in told.items()]
    return table(("contact", "what its model assumes", "laws", "source"), rows, "Contacts")


def assumed_by(contact: Contact) -> str:
    """What the model of a contact takes as true, in plain words."""
    kind = registry.kinds("contact").get(contact.model)
    return str(kind.leaf.assumes) if kind is not None else COMPLIANT


def _kinds(contact: Contact) -> list[tuple[registry.Kind[object], Mapping[str, Any]]]:
    """The laws of a contact with their values."""
    laws = list[tuple[registry.Kind[object], Mapping[str, Any]]]()
    if contact.film is not None:
        laws.append((registry.kinds("film")[contact.film.law.kind], contact.film.law.values))
    if contact.normal is not None:
        laws.append((registry.normal_law(contact.normal.kind), contact.normal.values))
    for family, law in (("stiffness", contact.static), ("friction", contact.friction)):
        if law is not None:
            laws.append((registry.kinds(family)[law.kind], law.values))
    if not laws and contact.model in registry.kinds("contact"):
        laws.append((registry.kinds("contact")[contact.model], contact.fields))
    return laws


def _laws(contact: Contact) -> str:
    """The laws with their numbers, in words."""
    laws = []
    for law, values in _kinds(contact):
        numbers = [
            f"{key.replace('_', ' ')} {_number(values[key], field.unit)}"
            for key, field in law.fields.items()
            if key in values and field.shape not in ("choice", "flag") and values[key] != field.default
        ]
        word = "" if law.name == contact.model else law.name.replace("-", " ")
        laws.append(f"{word}: {', '.join(numbers)}".strip(": ") if numbers else word)
    return "; ".join(law for law in laws if law)


def _number(value: Any, unit: str) -> str:
    if isinstance(value, Mapping):
        return " ".join(f"{key} {handy(number, 'Pa' if key == 'E' else '')}" for key, number in value.items())
    return handy(value, unit) if isinstance(value, float | int) else str(value)


def _sources(contact: Contact) -> str:
    return "; ".join(dict.fromkeys(law.source.rstrip(".") for law, _ in _kinds(contact) if law.source))


def _chosen(model: Model) -> list[str]:
    choices = []
    for name, joint in model.joints.items():
        film = joint.contact.film if joint.contact is not None else None
        assumed = (film.assumed if film else "", joint.wear.assumed if joint.wear else "")
        choices += [f"{name}: {choice}" for choice in assumed if choice]
    return choices


def _left_out(model: Model) -> str:
    oiled = any(joint.contact is not None and joint.contact.film is not None for joint in model.joints.values())
    wearing = any(joint.wear is not None for joint in model.joints.values())
    wear = "wear while the mechanism runs (worn surfaces stay as they are)" if wearing else "wear"
    heat = "heating and expansion, also of the oil" if oiled else "heating and expansion"
    return (
        "Not part of this model: play and friction other than listed here, scatter of dimensions, bending and vibration"
        f" of the parts, their strength and fatigue, {heat}, {wear}, noise."
    )
