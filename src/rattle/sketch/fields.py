"""What is chosen in a drawing has fields: what they show, and what typing a value into one does."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

from rattle.description.changes import Path
from rattle.description.read_contact import contact_models
from rattle.description.switch_contact import contact_of, recontact
from rattle.errors import InputError
from rattle.sketch.closing import closed_near, closing_range
from rattle.sketch.drawn import PINS, Drawn, Spot
from rattle.sketch.expressions import rate_of, two_digits, with_rate
from rattle.sketch.moving import carry, is_at
from rattle.sketch.numbers import degrees, length, plain, typed_number
from rattle.sketch.plays import HINT, OFFERS, play_text, typed_play
from rattle.sketch.removing import TABLES, rename
from rattle.sketch.revision import Drawing, Revision, parameter_path

CONTACTS = ("impact", "massless-link", "hertz")  # offered first beside a play

BLOCK = (0.12, 0.07)  # length and height of a new block with play, as shares of the size of the drawing

SHOWN = 1e-7  # by which an angle that is shown may be off [rad]
STRAIGHT = 1e-12  # relative angle of welded bodies that is none [rad]


class Field(NamedTuple):
    """A field of the panel: its accessible name, what stands in it, and what it is good for."""

    name: str
    text: str
    hint: str = ""
    choices: tuple[str, ...] = ()
    offers: tuple[str, ...] = ()  # what might be typed


def fields_of(sketch: Drawn, chosen: str) -> list[Field]:
    """The fields of something in a drawing, such as "body bar1" or "point ground.O1"."""
    kind, _, name = chosen.partition(" ")
    there = sketch.points if kind == "point" else sketch.document.get(TABLES.get(kind, ""), {})
    reader: Callable[[Drawn, str], Iterator[Field]] | None = READERS.get(kind)
    return list(reader(sketch, name)) if reader is not None and name in there else []


def _written(value: object) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, list):
        return ", ".join(map(_written, value))
    return plain(float(value)) if isinstance(value, int | float) else ""


def _with_unit(value: object, unit: str) -> str:
    """A value as it is typed: with its unit, which a bare number in the text has not."""
    return f"{_written(value)} {unit}" if isinstance(value, int | float) else _written(value)


def _of_body(sketch: Drawn, name: str) -> Iterator[Field]:
    entry = sketch.document["bodies"][name]
    yield Field("Name", name)
    if "bar" in entry:
        yield Field("Length", _with_unit(entry["length"], "m"), "such as 180 mm, or an expression over parameters")
    yield Field("Angle", degrees(sketch.places[name][2], SHOWN), "at the start; a number alone is in degrees")
    if "mass" in entry:
        yield Field("Mass", _with_unit(entry["mass"], "kg"), "such as 0.3 kg")


def _of_point(sketch: Drawn, name: str) -> Iterator[Field]:
    body, _, own = name.partition(".")
    spot = sketch.points[name]
    written = sketch.document.get("ground", {}).get("points", {}).get(own) if body == "ground" else None
    for k, label in enumerate("XY"):
        value = written[k] if isinstance(written, list) else length(spot[k], sketch.size)
        yield Field(label, _with_unit(value, "m"), "in the plane")


def _of_joint(sketch: Drawn, name: str) -> Iterator[Field]:
    entry = sketch.document["joints"][name]
    yield Field("Name", name)
    loose = "clearance" in entry or "bearing" in entry
    if entry["type"] in PINS and not loose:
        yield Field("Kind", entry["type"], "revolute turns, fixed is welded", PINS)
    if entry["type"] not in ("revolute", "prismatic", "slot"):
        return
    yield Field("Play", _with_unit(play_text(entry), "m"), HINT, offers=OFFERS if entry["type"] == "revolute" else ())
    if loose:
        model = _model({"contact": "massless-link", **entry})
        yield Field("Contact", model, "what happens when pin and bush meet", tuple(contact_models(entry["type"])))


def _of_driver(sketch: Drawn, name: str) -> Iterator[Field]:
    entry = sketch.document["drivers"][name]
    yield Field("Name", name)
    speed, function = entry.get("speed"), entry.get("angle", entry.get("position"))
    rate = rate_of(function)
    if speed is not None:
        yield Field("Speed", _written(speed), "such as 60 rpm")
    elif rate is not None:
        yield Field("Speed", rate.text, "such as 60 rpm; negative turns clockwise")
    else:
        yield Field("Function", _written(function), "of the time t")


LOADS = {"spring": ("stiffness", "free_length", "damping"), "force": ("force",), "torque": ("torque",)}
LABELS = {"stiffness": ("Stiffness", "N/m"), "free_length": ("Free length", "m"), "damping": ("Damping", "N*s/m"),
          "force": ("Force", "N"), "torque": ("Torque", "N*m")}  # fmt: skip


def _of_load(sketch: Drawn, name: str) -> Iterator[Field]:
    entry = sketch.document["loads"][name]
    yield Field("Name", name)
    for key in LOADS.get(entry["type"], ()):
        label, unit = LABELS[key]
        value = entry.get(key, "")
        yield Field(label, _written(value) if isinstance(value, list) else _with_unit(value, unit), f"in {unit}")


READERS = {"body": _of_body, "point": _of_point, "joint": _of_joint, "driver": _of_driver, "load": _of_load}


# ---------------------------------------------------------------- typing
def typed(revision: Revision, chosen: str, field: str, text: str) -> Drawing | None:
    """Write what was typed into a field; None if it says what is there already.

    Raises ModelError or InputError where it cannot be.
    """
    text, (kind, _, name) = text.strip(), chosen.partition(" ")
    now = next((other.text for other in fields_of(revision.sketch, chosen) if other.name == field), None)
    if now is None:
        raise InputError(f"{chosen} has no field {field}")
    if text == now:
        return None
    if field == "Name":
        return rename(revision, kind, name, text)
    if field != "Play" and not text:
        raise InputError(f"{name}.{field.lower()} is empty: type a value")
    return WRITERS[kind](revision, name, field, text)


def value_of(text: str) -> float | str:
    """A plain number as a number, all else as it is typed."""
    return float(text) if re.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", text) else text


def _number(revision: Revision, text: str, unit: str) -> float:
    """What was typed [SI].  Raises InputError for a quantity of another kind, or a number that is not finite."""
    typed = typed_number(text, unit)
    value = revision.number(text) if typed is None else typed
    if not math.isfinite(value):
        raise InputError(f"'{text}' is not a finite number")
    return value


def _into_body(revision: Revision, name: str, field: str, text: str) -> Drawing:
    chosen = f"body {name}"
    if field == "Mass":
        revision.enter(("bodies", name, "mass"), value_of(text))
        return revision.finish(f"{name}.mass = {text}", chosen)
    if field == "Angle":
        return _turn(revision, name, text)
    _enter_length(revision, name, text)
    words = f"{name}.length = {text}"
    ends = _joined_ends(revision.sketch, name)
    if len(ends) == 2:
        return _close(revision, name, text, words)
    if name in revision.places:
        _along(revision, name, ends)
    return revision.finish(words, chosen)


def _enter_length(revision: Revision, name: str, text: str) -> None:
    """Write a length as typed, into the parameter that it is or into its place."""
    _enter_typed(revision, ("bodies", name, "length"), revision.document["bodies"][name]["length"], text)
    revision.read()  # which says what is wrong with it


def _enter_typed(revision: Revision, path: Path, old: object, text: str) -> None:
    """Write a value as typed, into the parameter that stands at a path or else at the path."""
    parameters = revision.document.get("parameters", {})
    if isinstance(old, str) and old.strip() in parameters and text not in parameters:
        path = parameter_path(parameters, old.strip())
        revision.words.append(f"parameter {old.strip()} is {text} now{revision.uses(old.strip())}")
    revision.enter(path, value_of(text))


def _joined_ends(sketch: Drawn, name: str) -> list[str]:
    """Ends of a bar at which something is pinned."""
    used = {end for pin in sketch.pins for end in pin.ends}
    return [end for end in sketch.document["bodies"][name]["bar"] if f"{name}.{end}" in used]


def _along(revision: Revision, name: str, ends: list[str]) -> None:
    """A bar with a free end: what is pinned stands, the other end moves along the bar."""
    first = revision.sketch.document["bodies"][name]["bar"][0]
    stands = ends[0] if ends else first
    x, y = revision.sketch.points[f"{name}.{stands}"]
    half = revision.number(revision.document["bodies"][name]["length"]) / 2 * (1 if stands == first else -1)
    angle = revision.places[name][2]
    revision.places[name] = x + half * math.cos(angle), y + half * math.sin(angle), angle
    revision.moved.append(name)


def _close(revision: Revision, name: str, text: str, words: str) -> Drawing:
    """Both ends are pinned: the loop is closed anew, or refused with the range in which it closes."""
    own = revision.document["bodies"][name]["length"]
    low, high = closing_range(revision.sketch, name, revision.number(own), revision.file)
    if low <= revision.number(own) <= high:
        drawing = revision.finish(words, f"body {name}", near=True)
        if not drawing.sketch.open_joints and not (drawing.sketch.trouble and not revision.sketch.trouble):
            return drawing
    ends = f"between {_short(low)} and {_short(high)}" if low > 0.0 else f"up to {_short(high)}"
    ends = f"from {_short(low)} on" if math.isinf(high) else ends
    closes = f"closes {ends}" if high > 0.0 else "does not close"
    raise InputError(f"length {text}: the loop of {name} {closes}")


def _short(value: float) -> str:
    return f"{value:.3g} m"


def _turn(revision: Revision, name: str, text: str) -> Drawing:
    """Turn a body to an angle: the mechanism follows, and its motor starts there."""
    text = f"{text} deg" if isinstance(value_of(text), float) else text  # as the field shows it
    wanted = _number(revision, text, "rad")
    turned = turned_to(revision.sketch, name, wanted, revision.file)
    if turned is None:
        raise InputError(f"{name} cannot be at {text}: the mechanism does not reach it, or joints hold it")
    revision.places |= turned
    revision.moved += [name, *(body for body in revision.document.get("initial", {}) if body in revision.places)]
    return revision.finish(f"{name} starts at {text}", f"body {name}")


def turned_to(sketch: Drawn, name: str, angle: float, file: str) -> Mapping[str, Any] | None:
    """Places at which a body has this angle, near where they are; None where it cannot be."""
    document = {key: value for key, value in sketch.document.items() if key not in ("drivers", "initial")}
    x, y, _ = sketch.places[name]
    start: dict[str, Any] = {name: {"angle": angle}}
    for body in sketch.bodies:
        if body not in sketch.grounded:
            start[body] = {"x": sketch.places[body][0], "y": sketch.places[body][1], "angle": sketch.places[body][2]}
    start[name] = {**start[name], "angle": angle}
    near = {**sketch.places, name: (x, y, angle)}
    places = closed_near({**document, "initial": start}, near, file)
    if places is None or abs(math.remainder(places[name][2] - angle, math.tau)) > 1e-9:
        return None
    return places


def _into_point(revision: Revision, name: str, field: str, text: str) -> Drawing:
    k, (body, _, own) = "XY".index(field), name.partition(".")
    spot = list(revision.sketch.points[name])
    spot[k] = _number(revision, text, "m")
    target: Spot = spot[0], spot[1]
    if body == "ground":
        written = revision.document["ground"]["points"][own]
        _enter_typed(revision, ("ground", "points", own, str(k)), written[k], text)
    carry(revision, name, target, typed=name)
    drawing = revision.finish(f"{name}.{'xy'[k]} = {text}", f"point {name}")
    if not is_at(drawing.sketch, name, target):
        raise InputError(f"{name}.{'xy'[k]} cannot be {text}: joints hold it elsewhere")
    return drawing


def _into_joint(revision: Revision, name: str, field: str, text: str) -> Drawing:
    entry = revision.document["joints"][name]
    if field == "Kind":
        return _another_kind(revision, name, text)
    if field == "Contact":
        revision.enter(("joints", name, "contact"), recontact(contact_of(revision.document, name), text))
        return revision.finish(f"{name}: contact {text}", f"joint {name}")
    named = typed_play(text) if entry["type"] == "revolute" else None
    if named is not None:
        _without_play(revision, name, entry, ("clearance", "bearing"))
        revision.enter(("joints", name, named.key), named.value)
        words = named.named.words
        if "contact" not in entry:
            revision.enter(("joints", name, "contact"), CONTACTS[0])
        return revision.finish(f"{name}: {words}, contact {_model(entry)}", f"joint {name}")
    if text and _number(revision, text, "m") != 0.0:
        _without_play(revision, name, entry, ("bearing",))
        revision.enter(("joints", name, "clearance"), value_of(text))
        if "contact" not in entry:
            revision.enter(("joints", name, "contact"), CONTACTS[0])
        if entry["type"] == "prismatic" and "block" not in entry:
            _give_block(revision, name, _number(revision, text, "m"))
        return revision.finish(f"{name}: play {text}, contact {_model(entry)}", f"joint {name}")
    _without_play(revision, name, entry, ("clearance", "bearing", "contact"))
    if name in revision.document.get("initial", {}):
        revision.enter(("initial", name), None)
    return revision.finish(f"{name} has no play", f"joint {name}")


def _without_play(revision: Revision, name: str, entry: Mapping[str, Any], keys: tuple[str, ...]) -> None:
    """Take keys out of a joint, where they are."""
    for key in keys:
        if key in entry:
            revision.enter(("joints", name, key), None)


def _give_block(revision: Revision, name: str, play: float) -> None:
    """Give a block with play [m] the size without which its corners would be nowhere, about as large as it is drawn."""
    far, across = BLOCK
    size = max(revision.sketch.size, abs(play) / across)
    block = {"length": two_digits(far * size), "height": two_digits(across * size)}
    revision.enter(("joints", name, "block"), block)
    revision.words.append(
        f"its block is given a size of {plain(block['length'])} m by {plain(block['height'])} m: change it under Text"
    )


def _another_kind(revision: Revision, name: str, text: str) -> Drawing:
    """A pin becomes a weld as the bodies stand, or turns again."""
    if text not in PINS:
        raise InputError(f"'{text}' is no kind of pin: expected {' or '.join(PINS)}")
    revision.enter(("joints", name, "type"), text)
    if text == "fixed":
        form = revision.sketch.model.joints[name]
        angle = revision.turn(form.a.body, form.b.body, revision.places)
        if abs(math.remainder(angle, math.tau)) > STRAIGHT:
            revision.enter(("joints", name, "angle"), degrees(angle))
    elif "angle" in revision.document["joints"][name]:
        revision.enter(("joints", name, "angle"), None)
    return revision.finish(f"{name} is {text}", f"joint {name}")


def _model(entry: Mapping[str, Any]) -> str:
    contact = entry.get("contact", "")
    return str(contact if isinstance(contact, str) else contact.get("model", ""))


def _into_driver(revision: Revision, name: str, field: str, text: str) -> Drawing:
    entry = revision.document["drivers"][name]
    key = next(key for key in ("speed", "angle", "position") if key in entry)
    direct = field == "Function" or key == "speed"
    revision.enter(("drivers", name, key), value_of(text) if direct else with_rate(entry[key], text))
    return revision.finish(f"{name}: {text}", f"driver {name}")


def _into_load(revision: Revision, name: str, field: str, text: str) -> Drawing:
    key = next(key for key, (label, _) in LABELS.items() if label == field)
    parts = [value_of(part.strip()) for part in text.split(",")] if key == "force" else value_of(text)
    revision.enter(("loads", name, key), parts)
    return revision.finish(f"{name}.{key} = {text}", f"load {name}")


WRITERS: dict[str, Callable[[Revision, str, str, str], Drawing]] = {
    "body": _into_body, "point": _into_point, "joint": _into_joint, "driver": _into_driver, "load": _into_load,
}  # fmt: skip
