"""What the tools draw: ground points, bars, plates, pins, sliders, slots, gears, motors, springs, forces."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from itertools import islice

import numpy as np

from rattle.description.polygon import fault, figure_of, is_inside
from rattle.errors import InputError
from rattle.sketch.drawn import Drawn, Place, Spot
from rattle.sketch.expressions import turned, two_digits
from rattle.sketch.freedoms import freedoms_left
from rattle.sketch.numbers import degrees, length, plain, shortest
from rattle.sketch.revision import Caught, Drawing, Revision, point_names

PER_METRE = 1.0  # mass of a new bar [kg/m]
BLOCK = {"mass": 0.1, "inertia": 1e-5}  # of a new slider [kg, kg m^2]
PLATE = {"thickness": "5 mm", "density": "7850 kg/m^3"}  # of a new plate: steel
STIFFNESS = 100  # of a new spring [N/m]
SPEED = "60 rpm"  # of a new motor
STROKE = 0.1  # share of the size of the drawing by which a new motor moves a slider
ROUND = 1e-6  # of a force, by which what is written may miss the arrow [N]
HERE = 1e-9  # share of the size within which a point is at a spot
PARALLEL = 1e-3  # sine of an angle below which two bars do not cross clearly
NOTHING = 0.25  # of a snap: what is shorter is nothing
DRIVEN = {"revolute": "angle", "prismatic": "position", "slot": "position"}


def ground(revision: Revision, at: Caught) -> Drawing:
    """A point of the ground; on a point of a body, a pin between the two besides."""
    if at.point.startswith("ground."):
        return revision.finish(chosen=f"point {at.point}")
    point = revision.ground_point(revision.spot(at))
    body = revision.end(at)
    joint = revision.pin(point, body) if body else ""
    return revision.finish(f"{point}, pinned to {body}" if body else point, f"point {point}", "Play" if joint else "")


def bar(revision: Revision, first: Caught, last: Caught, snap: float) -> Drawing | None:
    """A bar between two spots, pinned where it caught a point; None if it is too short to be one."""
    p, q = revision.spot(first), revision.spot(last)
    if math.dist(p, q) < NOTHING * snap or (first.point and first.point == last.point):
        return None
    name = revision.free_name("bar")
    many = len(revision.sketch.bodies)
    mass = two_digits(PER_METRE * math.dist(p, q))
    revision.enter(("bodies", name), {"bar": ["A", "B"], "length": length(math.dist(p, q)), "mass": mass})
    revision.places[name] = (p[0] + q[0]) / 2, (p[1] + q[1]) / 2, math.atan2(q[1] - p[1], q[0] - p[0])
    revision.moved.append(name)
    joined = [_pinned(revision, first, f"{name}.A"), _pinned(revision, last, f"{name}.B")]
    weighs = "" if many else f", mass {plain(mass)} kg (1 kg per metre, change it at the bar)"
    return revision.finish(f"{name}{_joins(joined)}{weighs}", f"body {name}", "Length")


def _pinned(revision: Revision, caught: Caught, end: str) -> str:
    """Pin an end of a new body to what it caught; what that is."""
    point = revision.end(caught)
    if point:
        revision.pin(point, end)
    return point


def _joins(points: Sequence[str]) -> str:
    """What a new body joins, in words; points: "" for an end that joins nothing."""
    joined = [point for point in points if point]
    return f", joins {_and(joined)}" if joined else ""


def _and(names: Sequence[str]) -> str:
    return " and ".join(names)


def plate(revision: Revision, corners: Sequence[Caught]) -> Drawing | None:
    """A plate between corners, pinned where one caught a point; None with fewer than three."""
    corners = _apart(revision, corners)
    if len(corners) < 3:
        return None
    (x0, y0), size = revision.spot(corners[0]), revision.sketch.size
    ring = [(length(x - x0, size), length(y - y0, size)) for x, y in map(revision.spot, corners)]
    if wrong := fault(ring):
        raise InputError(f"this is no plate: {wrong}")
    name, signs = revision.free_name("plate"), list(islice(point_names(), len(ring)))
    own = [list(corner) for corner in ring]
    revision.enter(("bodies", name), {"polygon": own, **PLATE, "points": dict(zip(signs, own, strict=True))})
    x, y = figure_of(ring).centre
    revision.places[name] = x0 + x, y0 + y, 0.0
    revision.moved.append(name)
    joined = [_pinned(revision, at, f"{name}.{sign}") for at, sign in zip(corners, signs, strict=True)]
    return revision.finish(f"{name}, 5 mm of steel{_joins(joined)}", f"body {name}", "Name")


def _apart(revision: Revision, corners: Sequence[Caught]) -> list[Caught]:
    """Corners without those that are where the one before is, the first being behind the last."""
    spots = [revision.spot(corner) for corner in corners]
    return [corner for k, corner in enumerate(corners) if k == 0 or spots[k] not in (spots[k - 1], spots[0])]


def pin(revision: Revision, at: Caught, within: float) -> Drawing:
    """A pin where two bodies cross, or between a body and the ground; one that is there is chosen.

    within: how near a body has to be [m].
    """
    sketch, spot = revision.sketch, revision.spot(at)
    there = [joint for joint in sketch.pins if joint.kind == "revolute" and math.dist(joint.at, spot) <= within]
    if there:
        return revision.finish(chosen=f"joint {there[0].name}", field="Play")
    bodies = [body for body in sketch.bodies if _reaches(sketch, body, spot, within)][:2]
    if not bodies:
        raise InputError("there is no body here: click where two bodies cross, or on a body to pin it to the ground")
    near = [point for body in bodies if (point := _point_near(sketch, body, spot, within))]
    spot = sketch.points[near[0]] if near else _crossing(sketch, bodies, spot, within)
    here = HERE * sketch.size
    ends = [_point_near(sketch, body, spot, here) or revision.body_point(body, spot) for body in bodies]
    if len(ends) == 1:
        ends.insert(0, revision.ground_point(spot))
    name = revision.pin(*ends)
    return revision.finish(f"{name} joins {_and(ends)}", f"joint {name}", "Play")


def _crossing(sketch: Drawn, bodies: Sequence[str], spot: Spot, within: float) -> Spot:
    """Where the lines of two bars cross near a spot; the spot itself where they do not."""
    bars = [sketch.document["bodies"][body].get("bar") for body in bodies]
    if len(bars) < 2 or not all(bars):
        return spot
    (p, q), (u, v) = ([sketch.points[f"{body}.{end}"] for end in bar] for body, bar in zip(bodies, bars, strict=True))
    first, second = (q[0] - p[0], q[1] - p[1]), (v[0] - u[0], v[1] - u[1])
    turn = first[0] * second[1] - first[1] * second[0]
    if abs(turn) <= PARALLEL * math.hypot(*first) * math.hypot(*second):
        return spot
    share = ((u[0] - p[0]) * second[1] - (u[1] - p[1]) * second[0]) / turn
    crossing = p[0] + share * first[0], p[1] + share * first[1]
    return crossing if math.dist(crossing, spot) <= within else spot


def _reaches(sketch: Drawn, body: str, spot: Spot, within: float) -> bool:
    """True if a body is at a spot: a bar or the points of a body near it, or a plate over it."""
    form = sketch.model.bodies[body]
    if form.outline:
        return is_inside(np.array(form.outline[0]), np.array(sketch.in_frame(body, spot)))
    ends = [sketch.points[f"{body}.{name}"] for name in form.points]
    pairs = itertools.pairwise(ends)
    return any(_distance(spot, p, q) <= within for p, q in pairs) or any(math.dist(spot, p) <= within for p in ends)


def _distance(spot: Spot, p: Spot, q: Spot) -> float:
    """Distance of a spot from a line between two points [m]."""
    across, along = (q[0] - p[0], q[1] - p[1]), (spot[0] - p[0], spot[1] - p[1])
    share = (across[0] * along[0] + across[1] * along[1]) / ((across[0] ** 2 + across[1] ** 2) or 1.0)
    share = min(1.0, max(0.0, share))
    return math.dist(spot, (p[0] + share * across[0], p[1] + share * across[1]))


def _point_near(sketch: Drawn, body: str, spot: Spot, within: float) -> str:
    """The point of a body that is nearest to a spot, "" if none is within reach."""
    points = [f"{body}.{name}" for name in sketch.model.bodies[body].points]
    nearest = min(points, key=lambda point: math.dist(sketch.points[point], spot), default="")
    return nearest if nearest and math.dist(sketch.points[nearest], spot) <= within else ""


def slider(revision: Revision, at: Caught, along: float) -> Drawing:
    """A block that slides in the ground at the end of a body; along: direction of its line [rad]."""
    spot = revision.spot(at)
    guide = revision.ground_point(spot, "S")
    block = revision.free_name("block")
    revision.enter(("bodies", block), {"points": {"P": [0, 0]}, **BLOCK})
    revision.places[block] = (*spot, along)
    revision.moved.append(block)
    slides: dict[str, object] = {"type": "prismatic", "connect": [guide, f"{block}.P"]}
    if along:
        slides["axis"] = degrees(along)
    name = revision.joint(slides)
    end = revision.end(at)
    joined = f", joins {end}" if end and revision.pin(f"{block}.P", end) else ""
    return revision.finish(f"{block} slides along {name}{joined}", f"joint {name}", "Play")


def slot(revision: Revision, first: Caught, last: Caught, held: Caught) -> Drawing:
    """A slot from one spot to another, of a bar if both are on one and of the ground otherwise, for a point."""
    p, q = revision.spot(first), revision.spot(last)
    if math.dist(p, q) <= 0.0:
        raise InputError("a slot needs a length: drag along it")
    if not held.point and not held.line:
        raise InputError("a slot holds a point: click one after dragging along the slot")
    middle = (p[0] + q[0]) / 2, (p[1] + q[1]) / 2
    body = _body_of(first) if _body_of(first) == _body_of(last) else "ground"
    along = math.atan2(q[1] - p[1], q[0] - p[0])
    holder = revision.body_point(body, middle) if body != "ground" else revision.ground_point(middle, "S")
    axis = turned(along - (revision.sketch.places[body][2] if body != "ground" else 0.0))
    entry: dict[str, object] = {"type": "slot", "connect": [holder, revision.end(held)]}
    if abs(axis) > 1e-12:
        entry["axis"] = degrees(axis)
    name = revision.joint({**entry, "length": length(math.dist(p, q))})
    return revision.finish(f"{name}: {held.point or held.line} slides in {body}", f"joint {name}", "Play", near=True)


def _body_of(caught: Caught) -> str:
    return caught.line or caught.point.partition(".")[0] or "ground"


def gear(revision: Revision, first: Caught, last: Caught) -> Drawing:
    """Two wheels about two points of the ground; bodies that turn there carry them, otherwise wheels are made."""
    p, q = revision.spot(first), revision.spot(last)
    if math.dist(p, q) <= 0.0:
        raise InputError("a pair of gears needs two centres: click two ground points")
    radius = length(math.dist(p, q) / 2)
    here = [_bodies_at(revision.sketch, caught) for caught in (first, last)]
    carriers = here[0].keys() & here[1].keys()
    ends = [_turning(revision, caught, radius, [bodies[name] for name in bodies if name not in carriers])
            for caught, bodies in zip((first, last), here, strict=True)]  # fmt: skip
    name = revision.joint({"type": "gear", "connect": ends, "radii": [radius, radius]})
    return revision.finish(f"{name}: {_and(ends)} roll on each other", f"joint {name}", "Name")


def _bodies_at(sketch: Drawn, caught: Caught) -> dict[str, str]:
    """The bodies that turn about a place, each with its point there."""
    here = sketch.joined(caught.point) if caught.point else []
    return {point.partition(".")[0]: point for point in here if not point.startswith("ground.")}


def _turning(revision: Revision, caught: Caught, radius: float, bodies: Sequence[str]) -> str:
    """The point about which a wheel turns: that of a body which does, or of a new one.

    A body at both centres carries the wheels, as the arm of a planetary gear does, and is none itself.
    """
    if bodies:
        return bodies[0]
    spot = revision.spot(caught)
    centre = revision.end(caught) or revision.ground_point(spot)
    wheel = revision.free_name("wheel")
    mass = two_digits(math.pi * radius**2 * 0.01 * 7850)
    inertia = two_digits(mass * radius**2 / 2)
    revision.enter(("bodies", wheel), {"points": {"C": [0, 0]}, "mass": mass, "inertia": inertia})
    revision.places[wheel] = (*spot, 0.0)
    revision.moved.append(wheel)
    revision.pin(centre, f"{wheel}.C")
    return f"{wheel}.C"


def motor(revision: Revision, at: Caught, within: float) -> Drawing:
    """A motor of the joint at a spot, which begins where it is drawn."""
    sketch, spot = revision.sketch, revision.spot(at)
    here = [joint for joint in sketch.pins if joint.kind in DRIVEN and math.dist(joint.at, spot) <= within]
    here.sort(key=lambda joint: not any(end.startswith("ground.") for end in joint.ends))
    if not here:
        raise InputError("there is no pin or slider here: click one to drive it")
    driven = {driver.joint: name for name, driver in sketch.model.drivers.items()}
    free = [joint for joint in here if joint.name not in driven]
    if len(free) < len(here) and not (free and freedoms_left(sketch)):
        name = next(driven[joint.name] for joint in here if joint.name in driven)
        return revision.finish(chosen=f"driver {name}", field="Speed")
    joint = free[0]
    key, name = DRIVEN[joint.kind], revision.free_name("motor", "")
    start = revision.coordinate(joint.name, revision.places)
    if key == "angle":
        function = f"{degrees(start)} + {SPEED}*t"
    else:
        stroke = two_digits(STROKE * sketch.size)
        function = f"{plain(length(start, sketch.size))} m + {plain(stroke)} m*sin({SPEED}*t)"
    revision.enter(("drivers", name), {"joint": joint.name, key: function})
    return revision.finish(f"{name} drives {joint.name}, {SPEED}", f"driver {name}", "Speed")


def spring(revision: Revision, first: Caught, last: Caught, snap: float) -> Drawing | None:
    """A spring between two spots, without force as it is drawn; None if they are one."""
    p, q = revision.spot(first), revision.spot(last)
    if math.dist(p, q) < NOTHING * snap:
        return None
    ends = [revision.end(caught) or revision.ground_point(caught.at) for caught in (first, last)]
    if all(end.startswith("ground.") for end in ends):
        raise InputError("a spring between two points of the ground does nothing: drag from or to a point of a body")
    name = revision.free_name("spring")
    entry = {"type": "spring", "connect": ends, "stiffness": STIFFNESS, "free_length": length(math.dist(p, q))}
    revision.enter(("loads", name), entry)
    return revision.finish(f"{name} between {_and(ends)}, {STIFFNESS} N/m", f"load {name}", "Stiffness")


def force(revision: Revision, at: Caught, to: Spot, snap: float) -> Drawing | None:
    """A force at a point of a body, 1 N for every snap of its arrow; None for an arrow without length."""
    spot = revision.spot(at)
    if math.dist(spot, to) < NOTHING * snap:
        return None
    point = revision.end(at)
    if not point or point.startswith("ground."):
        raise InputError("a force acts on a body: drag from a point of one")
    name = revision.free_name("force")
    parts = [shortest((b - a) / snap, ROUND) for a, b in zip(spot, to, strict=True)]
    revision.enter(("loads", name), {"type": "force", "at": point, "force": parts})
    size = plain(two_digits(math.hypot(*parts)))
    return revision.finish(f"{name} at {point}, {size} N", f"load {name}", "Force")


def start_here(revision: Revision, places: dict[str, Place]) -> Drawing:
    """Let the mechanism start where it was turned to by hand."""
    revision.places |= places
    revision.moved += [name for name in revision.document.get("initial", {}) if name in places]
    return revision.finish("starts here")
