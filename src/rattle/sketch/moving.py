"""Points that are dragged: bars and plates follow with their own dimensions, everything else stands."""

from __future__ import annotations

import math
from typing import Any

from rattle.errors import InputError
from rattle.sketch.drawn import Drawn, Pin, Spot
from rattle.sketch.revision import Drawing, Revision

HERE = 1e-9  # share of the size within which a corner is at a point
KEPT = 1e-6  # share of the size within which a point is where it was put
GUIDES = ("prismatic", "slot")  # joints that leave a point one way


def move(revision: Revision, point: str, to: Spot) -> Drawing | None:
    """Put a point, with all that pins join to it, to another place [m]; None if it is there.

    One in a guide of the ground goes along that.  Raises InputError where a number that would have to change is an
    expression.
    """
    if math.dist(revision.sketch.points[point], to) <= 0.0:
        return None
    guide, there = _in_guide(revision.sketch, point, to)
    if is_at(revision.sketch, point, there) and guide:
        return revision.finish(f"{point} stays: {guide} lets it go along its line alone", f"point {point}")
    words = f"{point} moved" if math.dist(to, there) <= KEPT * revision.sketch.size else f"{point} moved along {guide}"
    carry(revision, point, there)
    made = revision.finish(words, f"point {point}")
    if is_at(made.sketch, point, there):
        return made
    return made._replace(words=f"joints hold {point} elsewhere than there; {made.words}")


def is_at(sketch: Drawn, point: str, spot: Spot) -> bool:
    """True if a point is drawn at a spot [m]."""
    return math.dist(sketch.points[point], spot) <= KEPT * sketch.size


def _in_guide(sketch: Drawn, point: str, to: Spot) -> tuple[str, Spot]:
    """The guide of the ground that holds a point, and the place in it nearest to a spot; "" and the spot without."""
    group = sketch.joined(point)
    for pin in sketch.pins:
        moving = [end for end in pin.ends if end in group and not end.startswith("ground.")]
        fixed = [end for end in pin.ends if end not in group and end.startswith("ground.")]
        a = sketch.model.joints[pin.name].a.body
        turns = "bar" in sketch.document["bodies"].get(a, {})  # the line of the guide does, with the bar
        if pin.kind in GUIDES and moving and fixed and not turns:
            return pin.name, _nearest(sketch, pin, to)
    return "", to


def _nearest(sketch: Drawn, pin: Pin, spot: Spot) -> Spot:
    """The place in a guide of the ground that is nearest to a spot."""
    form = sketch.model.joints[pin.name]
    angle = (form.line or 0.0) + (0.0 if form.a.body == "ground" else sketch.places[form.a.body][2])
    x, y = sketch.points[next(end for end in pin.ends if end.startswith("ground."))]
    along = (spot[0] - x) * math.cos(angle) + (spot[1] - y) * math.sin(angle)
    return x + along * math.cos(angle), y + along * math.sin(angle)


def carry(revision: Revision, point: str, to: Spot, typed: str = "") -> None:
    """Change what has to change so that a point, and what is pinned to it, is at another place [m].

    typed: a point of the ground whose own coordinates are written already.
    """
    for name in revision.sketch.joined(point):
        body, _, own = name.partition(".")
        if body == "ground":
            for k, value in enumerate(to):
                if name != typed and abs(revision.sketch.points[name][k] - value) > 0.0:
                    revision.set_length(("ground", "points", own, str(k)), value, f"{name}.{'xy'[k]}")
        elif list(revision.sketch.model.bodies[body].points) == [own]:
            x, y, angle = revision.places[body]
            was = revision.sketch.points[name]
            revision.places[body] = x + to[0] - was[0], y + to[1] - was[1], angle
            revision.moved.append(body)
        elif own in revision.document["bodies"][body].get("bar", ()):
            _stretch(revision, body, own, to)
        else:
            _shift(revision, body, own, to)


def _stretch(revision: Revision, body: str, end: str, to: Spot) -> None:
    """Put one end of a bar to another place; its other end and its further points stand."""
    entry, sketch = revision.document["bodies"][body], revision.sketch
    other = next(name for name in entry["bar"] if name != end)
    stands = _now(revision, body, other)
    first, last = (to, stands) if entry["bar"][0] == end else (stands, to)
    span = math.dist(first, last)
    if span <= HERE * sketch.size:
        raise InputError(f"{body} would have no length: let go elsewhere")
    extra = {name: sketch.points[f"{body}.{name}"] for name in entry.get("points", {})}
    angle = math.atan2(last[1] - first[1], last[0] - first[0])
    if abs(span - math.dist(*(_now(revision, body, name) for name in entry["bar"]))) > 1e-15 * span:
        revision.set_length(("bodies", body, "length"), span, f"{body}.length")
    revision.places[body] = (first[0] + last[0]) / 2, (first[1] + last[1]) / 2, angle
    revision.moved.append(body)
    for name, spot in extra.items():
        for k, value in enumerate(revision.in_new_frame(body, spot)):
            revision.set_length(("bodies", body, "points", name, str(k)), value, f"{body}.{name}.{'xy'[k]}")


def _now(revision: Revision, body: str, end: str) -> Spot:
    """Where an end of a bar is after the changes so far."""
    if body not in revision.moved:  # its length may be a parameter that has changed: it has not been drawn anew
        return revision.sketch.points[f"{body}.{end}"]
    entry = revision.document["bodies"][body]
    span = revision.number(entry["length"])
    return revision.in_new_plane(body, (-span / 2 if entry["bar"][0] == end else span / 2, 0.0))


def _shift(revision: Revision, body: str, own: str, to: Spot) -> None:
    """Put a point of a body to another place in it, with the corner of a plate that is there."""
    entry, old = revision.document["bodies"][body], revision.sketch.points[f"{body}.{own}"]
    for k, value in enumerate(revision.as_written(body, revision.sketch.in_frame(body, to))):
        revision.set_length(("bodies", body, "points", own, str(k)), value, f"{body}.{own}.{'xy'[k]}")
    revision.moved.append(body)
    if "polygon" in entry:
        _shift_corner(revision, body, old, to, entry)


def _shift_corner(revision: Revision, body: str, old: Spot, to: Spot, entry: dict[str, Any]) -> None:
    sketch = revision.sketch
    was, new = (revision.as_written(body, sketch.in_frame(body, spot)) for spot in (old, to))
    ring = [(revision.number(x), revision.number(y)) for x, y in entry["polygon"]]
    corner = next((k for k, spot in enumerate(ring) if math.dist(spot, was) <= HERE * sketch.size), None)
    if corner is None:
        return
    for k, value in enumerate(new):
        revision.set_length(("bodies", body, "polygon", str(corner), str(k)), value, f"corner {corner + 1} of {body}")


def drop(revision: Revision, point: str, target: str) -> Drawing | None:
    """Put a point onto another one and pin them together; None if they are together already.

    Raises InputError for two points of one body.
    """
    if target in revision.sketch.joined(point):
        return None
    if any(pin.kind in GUIDES and {point, target} == set(pin.ends) for pin in revision.sketch.pins):
        return move(revision, point, revision.sketch.points[target])  # joined by their guide
    body = point.partition(".")[0]
    if body == target.partition(".")[0]:
        raise InputError(f"{point} and {target} both belong to {body}: they cannot be joined")
    carry(revision, point, revision.sketch.points[target])
    ends = (point, target) if body == "ground" else (target, point)
    joint = revision.pin(*ends)
    return revision.finish(f"{joint} joins {target} and {point}", f"joint {joint}", "Play")


def drop_on_line(revision: Revision, point: str, body: str, at: Spot) -> Drawing:
    """Put a point onto the line of a bar and pin it there.  Raises InputError for a point that is joined to it."""
    if body in {name.partition(".")[0] for name in revision.sketch.joined(point)}:
        raise InputError(f"{point} belongs to {body}, or is pinned to it: it cannot be joined to it again")
    carry(revision, point, at)
    own = revision.body_point(body, at)
    ends = (point, own) if point.startswith("ground.") else (own, point)
    joint = revision.pin(*ends)
    return revision.finish(f"{joint} joins {point} to {body}", f"joint {joint}", "Play")
