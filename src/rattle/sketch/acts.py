"""Acts of drawing as plain data: what a hand did with which tool, and the drawing that it makes of another."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from rattle.errors import InputError, suggest
from rattle.sketch import fields, moving, removing, tools
from rattle.sketch.drawn import Drawn, Place, Spot
from rattle.sketch.numbers import length
from rattle.sketch.revision import Caught, Drawing, Revision

Message = Mapping[str, Any]


def act(sketch: Drawn, message: Message, file: str = "") -> Drawing | None:
    """Do an act, {"act": name, ...}; None if it changes nothing.  Raises ModelError, InputError."""
    name = str(message.get("act"))
    if name not in ACTS:
        raise InputError(f"there is no act '{name}'{suggest(name, ACTS)}")
    return ACTS[name](Revision(sketch, file), message)


def caught(sketch: Drawn, told: Any, snap: float = 0.0) -> Caught:
    """Where a hand let go, from {"at": [x, y], "point": ..., "line": ...}; on a line in half snaps from its first end.

    Raises InputError.
    """
    if not isinstance(told, Mapping):
        raise InputError("expected where the hand was, { at, point, line }")
    point, line = str(told.get("point") or ""), str(told.get("line") or "")
    if point and point not in sketch.points:
        raise InputError(f"there is no point '{point}' in the drawing{suggest(point, sketch.points)}")
    if line and line not in sketch.bodies:
        raise InputError(f"there is no body '{line}' in the drawing{suggest(line, sketch.bodies)}")
    spot = _spot(told.get("at"))
    return Caught(_on_line(sketch, line, spot, snap / 2) if line else spot, point, line)


def _on_line(sketch: Drawn, body: str, spot: Spot, step: float) -> Spot:
    """The place on the line of a bar that is nearest to a spot, in steps from its first end; else the spot itself."""
    ends = sketch.document["bodies"][body].get("bar")
    if not ends:
        return spot
    first, last = (sketch.model.bodies[body].points[end][0] for end in ends)
    along = sketch.in_frame(body, spot)[0]
    if step > 0.0:
        along = first + math.copysign(round(abs(along - first) / step) * step, last - first)
    return sketch.in_plane(body, (min(max(first, last), max(min(first, last), along)), 0.0))


def _spot(told: Any) -> Spot:
    if isinstance(told, list | tuple) and len(told) == 2 and all(isinstance(x, int | float) for x in told):
        return float(told[0]), float(told[1])
    raise InputError("expected a place [x, y] in m")


def place_of(told: Any) -> Place:
    """The place of a body from [x, y, angle].  Raises InputError."""
    if isinstance(told, list | tuple) and len(told) == 3 and all(isinstance(x, int | float) for x in told):
        return float(told[0]), float(told[1]), float(told[2])
    raise InputError("expected the place of a body, [x, y, angle] in m and rad")


def _number(message: Message, key: str) -> float:
    value = message.get(key, 0.0)
    return float(value) if isinstance(value, int | float) else 0.0


def _ends(revision: Revision, message: Message) -> tuple[Caught, Caught]:
    snap = _number(message, "snap")
    return caught(revision.sketch, message.get("from"), snap), caught(revision.sketch, message.get("to"), snap)


def _at(revision: Revision, message: Message) -> Caught:
    return caught(revision.sketch, message.get("at"), _number(message, "snap"))


def _dropped(revision: Revision, message: Message) -> Drawing | None:
    """A point was dragged to a spot, onto another point, or onto the line of a bar."""
    point, to = str(message.get("point")), caught(revision.sketch, message.get("to"), _number(message, "snap"))
    caught(revision.sketch, {"at": [0, 0], "point": point})
    if to.point:
        return moving.drop(revision, point, to.point)
    return moving.drop_on_line(revision, point, to.line, to.at) if to.line else moving.move(revision, point, to.at)


def _nudged(revision: Revision, message: Message) -> Drawing | None:
    """A chosen point moves by some steps of the grid."""
    point, by = str(message.get("point")), _spot(message.get("by"))
    caught(revision.sketch, {"at": [0, 0], "point": point})
    x, y = revision.sketch.points[point]
    to = length(x + by[0], revision.sketch.size), length(y + by[1], revision.sketch.size)
    return moving.move(revision, point, to)


def _kept(revision: Revision, message: Message) -> Drawing:
    """A measure becomes signals."""
    names, kept = [], revision.document.get("signals", {})
    there = [name for name, expression in kept.items() if expression in message["signals"].values()]
    if there:
        return revision.finish(f"signal {', '.join(there)} records it already")
    for wish, expression in message["signals"].items():
        names.append(revision.free_name(str(wish), ""))
        revision.enter(("signals", names[-1]), str(expression))
    return revision.finish(f"signal {', '.join(names)}: recorded in every result from now on")


def _started(revision: Revision, message: Message) -> Drawing:
    told = message.get("places")
    if not isinstance(told, Mapping):
        raise InputError("expected the places of bodies, { body: [x, y, angle] }")
    return tools.start_here(
        revision, {name: place_of(place) for name, place in told.items() if name in revision.places}
    )


def _deleted(revision: Revision, message: Message) -> Drawing:
    kind, _, name = str(message.get("chosen")).partition(" ")
    return removing.delete(revision, kind, name)


ACTS: dict[str, Callable[[Revision, Message], Drawing | None]] = {
    "ground": lambda revision, told: tools.ground(revision, _at(revision, told)),
    "bar": lambda revision, told: tools.bar(revision, *_ends(revision, told), _number(told, "snap")),
    "plate": lambda revision, told: tools.plate(revision, [caught(revision.sketch, at) for at in told["corners"]]),
    "pin": lambda revision, told: tools.pin(revision, _at(revision, told), _number(told, "within")),
    "slider": lambda revision, told: tools.slider(revision, _at(revision, told), _number(told, "along")),
    "slot": lambda revision, told: tools.slot(
        revision, *_ends(revision, told), caught(revision.sketch, told.get("held"), _number(told, "snap"))
    ),
    "gear": lambda revision, told: tools.gear(revision, *_ends(revision, told)),
    "motor": lambda revision, told: tools.motor(revision, _at(revision, told), _number(told, "within")),
    "spring": lambda revision, told: tools.spring(revision, *_ends(revision, told), _number(told, "snap")),
    "force": lambda revision, told: tools.force(
        revision, caught(revision.sketch, told.get("from")), _spot(told["to"]["at"]), _number(told, "snap")
    ),
    "drop": _dropped,
    "nudge": _nudged,
    "keep": _kept,
    "delete": _deleted,
    "type": lambda revision, told: fields.typed(
        revision, str(told.get("chosen")), str(told.get("field")), str(told.get("text"))
    ),
    "start": _started,
}
