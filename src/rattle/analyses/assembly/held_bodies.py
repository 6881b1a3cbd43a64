"""Where bodies stand that loads alone hold to the ground, as a frame on springs, and whose places are not given.

Joints and drivers leave such a body free in x, y and angle, and what hangs on it goes with it.  It stands where its
bushing to the ground exerts nothing, or else at x = y = angle = 0, as far as given values leave that open; only its
angle counts where x or y is given for a body that hangs together with it.  The mechanism is closed around it, if that
keeps given values as well as without.  These places count as given then.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import numpy as np

from rattle import registry
from rattle.analyses.assembly.rank import rank_of, scaled_rows
from rattle.analyses.assembly.searching import first_guess
from rattle.analyses.assembly.start_values import KEYS, change_of_given, given_values
from rattle.description.model import Load, Model, is_ground, on_ground, with_fields
from rattle.equations.closure import open_by
from rattle.equations.dense import LARGE
from rattle.equations.start_search import KEPT
from rattle.equations.system import System
from rattle.errors import AssemblyError
from rattle.language.recorded import as_number, bare

Place = Mapping[str, float]  # x, y [m] and angle [rad]
Make = Callable[[Model], System]  # puts a model together
Find = Callable[[System], np.ndarray]  # positions (3 nb,) at the start
ORIGIN: Place = dict.fromkeys(KEYS[0], 0.0)  # where nothing says otherwise


def resting_places(model: Model) -> dict[str, Place]:
    """Places of all bodies that loads between points hold to the ground and whose place is not given as a whole."""
    places: dict[str, Place] = {}
    for load in model.loads.values():
        bodies = [end.body for end in (load.a, load.b) if not is_ground(end.body)]
        if len(bodies) != 1 or load.law is not None or not _holds_points(load):
            continue
        (body,) = bodies
        if ORIGIN.keys() <= model.initial.bodies.get(body, {}).keys():
            continue
        place = _without_force(model, load, model.initial.bodies.get(body, {}))
        if place is not None and places.get(body) in (None, ORIGIN):
            places[body] = place
        places.setdefault(body, ORIGIN)
    return places


def _holds_points(load: Load) -> bool:
    """True if it acts between two points, not on angles alone."""
    leaf = registry.kinds("load")[load.kind].leaf
    return leaf.rests or (leaf.record is not None and leaf.record.coordinate == "length")


def _without_force(model: Model, load: Load, start: Place) -> Place | None:
    """Where the body of a load to the ground is without force, at its given angle; None if the load does not tell."""
    if not registry.kinds("load")[load.kind].leaf.rests:
        return None
    x, y, angle = (bare(as_number(number)) for number in load.fields["offset"])
    if is_ground(load.a.body):
        hold_x, hold_y = on_ground(model.ground, load.a)
        own, at, turned = load.b.at, (hold_x + x, hold_y + y), angle
    else:  # the offset turns with the body
        own, at, turned = (load.a.at[0] + x, load.a.at[1] + y), on_ground(model.ground, load.b), -angle
    turned = bare(start.get("angle", turned))
    c, s = math.cos(turned), math.sin(turned)
    own_x, own_y, at_x, at_y = (bare(number) for number in (*own, *at))
    return {"x": at_x - (c * own_x - s * own_y), "y": at_y - (s * own_x + c * own_y), "angle": turned}


def with_held_bodies(model: Model, make: Make, find: Find) -> Model:
    """The model with the places of such bodies as given ones.  Raises AssemblyError."""
    if model.initial.near or model.initial.held or not (resting := resting_places(model)):
        return model
    jointed = {end.body for joint in model.joints.values() for end in (joint.a, joint.b)}
    driven = {driver.point.body for driver in model.drivers.values() if driver.point is not None}
    alone = {body: place for body, place in resting.items() if body not in jointed | driven}
    model = _with_places(model, alone)
    if len(alone) == len(resting):
        return model
    system = make(model)
    if not held_by_loads(system, first_guess(system)):  # most have joints to the ground: no search for that
        return model
    try:
        q = find(system)
        placed = _with_places(model, _left_open(system, q))
        held = make(placed)
        there = find(held)
    except AssemblyError:
        return model
    own, every = given_values(system, 0), given_values(held, 0)
    moved = change_of_given(system, there, own) > max(KEPT, change_of_given(system, q, own))
    return model if moved or change_of_given(held, there, np.where(np.isnan(own), every, np.nan)) > KEPT else placed


def _with_places(model: Model, places: Mapping[str, Place]) -> Model:
    """The model with these places as if they were given."""
    return with_fields(model, initial=model.initial.with_places(places)) if places else model


def held_by_loads(system: System, q: np.ndarray) -> dict[str, Place]:
    """Those of `resting_places` whose bodies joints and drivers leave free in x, y and angle, at q (3 nb,)."""
    places = resting_places(system.model)
    if not places or system.row_count > LARGE:
        return {}
    rows, unit = _rows(system, q), np.eye(len(q))
    rank, free = rank_of(rows), {}
    for body, place in places.items():
        n = 3 * system.bodies.index(body)
        if rank_of(np.vstack([rows, unit[n : n + 3]])) == rank + 3:
            free[body] = place
    return free


def _left_open(system: System, q: np.ndarray) -> dict[str, Place]:
    """What of the places of bodies that loads hold is left open by given values and the ones before, angles first."""
    unit = np.eye(len(q))
    rows = np.vstack([_rows(system, q), unit[~np.isnan(given_values(system, 0))]])
    left_open: dict[str, Place] = {}
    for body, place in held_by_loads(system, q).items():
        n, free = 3 * system.bodies.index(body), {}
        for key in ("angle",) if placed_nearby(system.model, body) else ("angle", "x", "y"):
            more = np.vstack([rows, unit[n + KEYS[0].index(key)]])
            if rank_of(more) > rank_of(rows):
                rows, free[key] = more, place[key]
        if free:
            left_open[body] = free
    return left_open


def placed_nearby(model: Model, body: str) -> bool:
    """True if x or y is given for a body to which joints lead from this one, on ways without the ground."""
    reached, open_ = {body}, [body]
    while open_:
        here = open_.pop()
        for joint in model.joints.values():
            ends = (joint.a.body, joint.b.body)
            for other in ends if here in ends else ():
                if other not in reached and not is_ground(other):
                    reached.add(other)
                    open_.append(other)
    return any({"x", "y"} & model.initial.given(other) for other in reached)


def _rows(system: System, q: np.ndarray) -> np.ndarray:
    workspace = system.workspace()
    open_by(workspace, 0.0, q, np.zeros_like(q))
    return scaled_rows(system, workspace)
