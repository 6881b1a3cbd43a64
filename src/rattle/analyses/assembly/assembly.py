"""Assembly: positions and rates that satisfy every joint at a given time.

Given angles are kept while the joints determine x and y, from the ground outwards; then a damped Newton
iteration satisfies all constraints with the least mass-weighted change.  Rates likewise (docs/theory.md, section 3).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from rattle.analyses.assembly.computable import not_finite, require_digits
from rattle.analyses.assembly.first_guess import first_guess, ways_of_kernels
from rattle.analyses.assembly.guesses import Guesses, least_open, why_open_from
from rattle.analyses.assembly.outside import outside
from rattle.analyses.assembly.rank import RANK, free_motions, loose_without_mass, scaled_rows
from rattle.analyses.assembly.start_constants import (
    constants_at,
    constants_of,
    require_fit,
    with_constants,
    without_counting,
)
from rattle.analyses.assembly.start_notes import start_notes
from rattle.analyses.assembly.start_values import (
    change_of_given,
    given_values,
    keep_places,
    keep_positions,
    keep_rates,
    places,
)
from rattle.analyses.assembly.unclosed import without_value
from rattle.analyses.assembly.vector_loops import GROUND, given_in_one_turn, groups_at
from rattle.analyses.assembly.without_play import along_reactions, ideal_model, ideal_start
from rattle.description.model import Contact, Joint, Model
from rattle.equations.closure import close_position, close_rate, open_by, place_only
from rattle.equations.dense import LARGE
from rattle.equations.kept_values import MOVED, NOT_CLOSED, NOT_FINITE, hold_pins
from rattle.equations.motion import constraints, drive
from rattle.equations.placement import point_at, pose, turned
from rattle.equations.start_near import FAR, close_near, place_rates
from rattle.equations.system import System, compile_system, is_link
from rattle.errors import AssemblyError
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace

HOLD = 1e-6  # factor on the inverse mass of given rates, in mechanisms too large for `start_values`
KEPT = (
    1e-9  # change of a given value that counts as none [rad, mechanism sizes]: rounding of what was computed elsewhere
)
ALIKE = 1e-9  # share by which squared changes of given values differ that are equal but for rounding
WORTH = 25.0  # times the least squared change: a closing beyond it is not looked at more closely
ALONE = 10.0  # bending of closed positions, about 2, with room for what is not counted
HARD = 8  # guesses from which it is tried hard to close, until one does
LOOKED = 6  # closings that are looked at more closely, at most
NUDGE = 1e-5  # of differences, as a share of the mechanism's size
DETERMINED = 1e-6  # share of a nudge by which a pin may move in its bush that joints and given values place
SLANT = 0.01  # part of an offset along a guide or slot, in clearances, that is put down to its angle, known roughly


@dataclass(frozen=True)
class Assembled:
    """A consistent start: positions and rates that satisfy all constraints."""

    t: float  # [s]
    q: np.ndarray  # (3 nb,) x, y, angle of every body [m, m, rad]
    v: np.ndarray  # (3 nb,) their rates [m/s, m/s, rad/s]
    residual: float  # largest constraint residual [m or rad]
    iterations: int
    notes: tuple[str, ...] = ()  # on values of [initial] that could not be kept, where that matters; in every result
    changes: tuple[str, ...] = ()  # on all of them


def assemble(system: System, t: float = 0.0, ideal: Assembled | None = None, told: bool = True) -> Assembled:
    """Positions and rates at time t [s], from the model's [initial] table.

    ideal: the assembled ideal mechanism at t, if it is known already.  told: whether notes are made.
    Raises AssemblyError if the joints cannot be closed; the message names the loop and the gap.
    """
    made = consistent_start(system, t, ideal)
    require_digits(system, made.q)
    _require_held(system, made)
    if t != 0.0 or not told:
        return made
    shut = without_play(system, t)[0] if has_play(system.model) else system
    remarks, said = system.model.remarks, start_notes(system, shut, t, made.q, made.v)
    return replace(made, notes=(*remarks, *said.brief), changes=(*remarks, *said.all))


def without_play(system: System, t: float = 0.0) -> tuple[System, Assembled | AssemblyError]:
    """The mechanism without play and its start at t [s], or why there is none."""
    shut = system.__dict__.get("shut") if t == 0.0 else None
    if shut is None:
        return ideal_start(system.model, t, put_together, consistent_start)
    if "begun" not in shut.__dict__:
        workspace = shut.assembly_workspace()
        try:
            shut.__dict__["begun"] = consistent_start(shut, t, workspace=workspace)
            shut.__dict__["spare"] = workspace  # the first who takes it need not make one
        except AssemblyError as error:
            shut.__dict__["begun"] = error
    return shut, shut.__dict__["begun"]


def has_play(model: Model) -> bool:
    """True if the assembly of a model begins at the start of the mechanism without play."""
    return any(is_link(one) or _has_play(one) for one in model.joints.values())


def near_places(system: System, start: Assembled) -> tuple[dict[str, Any], dict[str, Any]]:
    """Where the bodies are at a start, for others that are looked for near it; the same without play."""
    near = places(system, start.q)
    if not has_play(system.model):
        return near, {}
    shut, found = without_play(system)
    return near, places(shut, found.q) if isinstance(found, Assembled) else {}


def _require_held(system: System, made: Assembled) -> None:
    """Raise AssemblyError if a body without mass can move while all others rest."""
    if not len(system.arrays["massless"]):
        return
    workspace = system.workspace()
    open_by(workspace, made.t, made.q, made.v)
    if loose := loose_without_mass(system, workspace):
        name, turns = loose[0]
        what, which = ("inertia", "its angle") if turns else ("mass", "its motion")
        raise AssemblyError(
            f"body '{name}' has no {what}, and joints and drivers do not determine {which}: give it"
            f" {'an' if turns else 'a'} {what}, or a joint that holds it"
        )


def put_together(model: Model) -> System:
    """The system of a model, with the constants that its start sets.

    Raises AssemblyError if the mechanism cannot be put together, or points are not at the distance that a joint needs.
    """
    counting = [name for name, joint in model.joints.items() if joint.leaf.from_start]
    if not counting:
        return compile_system(model)
    q = _start_without(model, counting)
    found = constants_at(compile_system(with_constants(model, dict.fromkeys(counting, 0.0))), q)
    system = compile_system(with_constants(model, found))
    require_fit(system, q)
    return system


def _start_without(model: Model, counting: list[str]) -> np.ndarray:
    """Positions (3 nb,) [m, m, rad] of the start, found without the rows that count from it.

    Pins of massless links that the user has not placed are where the reactions of the whole mechanism press them.
    """
    loose = without_counting(model)
    offsets = dict(model.initial.offsets)
    missing = [
        name
        for name, one in loose.joints.items()
        if is_link(one) and math.hypot(*offsets.get(name, (0.0, 0.0))) < 1e-9 * one.clearance
    ]
    if missing:
        shut, ideal = ideal_start(model, 0.0, put_together, consistent_start)
        if isinstance(ideal, AssemblyError):
            raise ideal
        pressed = {name: loose.joints[name].clearance for name in missing}
        offsets |= along_reactions(shut, 0.0, ideal.q, ideal.v, pressed)
        loose = replace(loose, initial=replace(loose.initial, offsets=offsets))
    return consistent_start(compile_system(loose), 0.0).q


def ideal_system(model: Model) -> System:
    """The same mechanism with every clearance closed, put together.  Raises AssemblyError."""
    return put_together(ideal_model(model))


def consistent_start(
    system: System, t: float, ideal: Assembled | None = None, workspace: Workspace | None = None
) -> Assembled:
    """As `assemble`, without notes on what could not be kept.  workspace: an `assembly_workspace` to work in."""
    model = system.model
    workspace = system.assembly_workspace() if workspace is None else workspace
    _require_values(system, workspace, t)
    links, open_ = (
        {name: model.joints[name] for name in names} for names in system.fact("play", lambda: with_play(model))
    )
    offsets = {name: model.initial.offsets.get(name, (0.0, 0.0)) for name in (*links, *open_)}
    shut, held = system, list[str]()
    missing: list[str] = []
    if offsets:
        shut, found = without_play(system, t)
        if isinstance(found, Assembled):
            ideal = found
        held = undetermined(system, t, first_guess(system, t) if ideal is None else ideal.q, open_)
        if isinstance(found, AssemblyError) and (links or held):  # it need not close if given values determine all
            shut, ideal = _partly_closed(model, t, [*links, *held], found)
        missing = [name for name in links if math.hypot(*offsets[name]) < 1e-9 * links[name].clearance]
        if missing and ideal is not None:
            pressed = {name: links[name].clearance for name in missing}
            offsets.update(along_reactions(shut, t, ideal.q, ideal.v, pressed))
        if ideal is not None:
            held = [*links, *held]  # closing would move the pins away from their offsets, given or along the reactions
    q, iterations = _closed(system, workspace, t, offsets, held, missing, ideal, shut)
    pins = any(one.one_sided is None for one in (*links.values(), *open_.values()))
    if ideal is not None and pins and _beyond(system, workspace, t, q):
        q = _inside(system, workspace, t, offsets, held, missing, ideal, shut, q)
    if t == 0.0:  # the instant for which offsets are given
        _refuse_offsets_along(system, q)
    given = given_values(system, 1)
    if ideal is None:
        v = _free_rates(system, workspace, t, q, given)
    else:
        v = np.where(np.isnan(given), ideal.v, given)
        place_rates(workspace, q, v, given, ways_of_kernels(system))
        v = _closed_rates(system, workspace, t, q, v, given)
    _refuse_contradiction(system, workspace, t, q, v)
    residual = float(open_by(workspace, t, q, v))
    if beyond := outside(system, workspace):
        raise AssemblyError(beyond)
    return Assembled(t, q, v, residual, iterations)


def _require_values(system: System, workspace: Workspace, t: float) -> None:
    """Raise AssemblyError if a driver has no finite value at t [s]: no body can be placed at it."""
    drive(workspace, t)
    if why := without_value(system, workspace, t):
        raise AssemblyError(why)


def _has_play(joint: Joint) -> bool:
    """True if its contacts hold the mechanism together."""
    return joint.is_loose and not joint.passing


def with_play(model: Model) -> tuple[list[str], list[str]]:
    """Joints that are massless links, and those whose contacts hold the mechanism together."""
    joints = model.joints.items()
    return [name for name, one in joints if is_link(one)], [name for name, one in joints if _has_play(one)]


def _partly_closed(model: Model, t: float, names: list[str], why: AssemblyError) -> tuple[System, Assembled]:
    """The mechanism without the play of some joints, put together.  Raises `why` if that cannot be either."""
    joints = dict(model.joints)
    for name in names:
        joints[name] = replace(joints[name], contact=Contact("ideal", {}), stop=None)
    closed = replace(model, joints=joints)
    if not any(_has_play(one) or is_link(one) for one in joints.values()):
        raise why
    try:
        system = put_together(closed)
        return system, consistent_start(system, t)
    except AssemblyError:
        raise why from None


def _closed(
    system: System, workspace: Workspace, t: float, offsets: dict[str, Any], held: list[str], missing: list[str],
    ideal: Assembled | None, shut: System,
) -> tuple[np.ndarray, int]:  # fmt: skip
    """Positions (3 nb,) that satisfy every joint, with the pins of the `held` joints at their offsets if possible.

    Also returns the number of iterations.
    """
    q, given = None, given_in_one_turn(system, t, workspace)
    if held and ideal is not None:
        try:
            joints = {
                name: replace(one, contact=None) if name in held else one for name, one in system.model.joints.items()
            }
            closed = replace(system.model, joints=joints)
            alike = len(held) == len(offsets) and not constants_of(closed)  # its own start sets those of `shut`
            closed_system = shut if alike else compile_system(closed)
            there = {name: offsets[name] for name in held}
            q, iterations = _hold_offsets(closed_system, closed, t, there, ideal, given)
            gap = close_position(workspace, t, q, np.empty_like(q), 1e-12 * system.size, 60)[0]
            if not gap <= 1e-9 * system.size or (missing and np.abs(q - ideal.q)[2::3].max() > FAR):
                raise AssemblyError(why_open_from(system, workspace, t, q))
        except AssemblyError:
            if not any(is_link(system.model.joints[name]) for name in held):
                raise
            q, missing = None, []  # pins placed by reactions that are not unique may not fit
    if q is None:
        q, iterations = _positions(system, workspace, t, offsets, ideal, given)
    if missing and system.row_count <= LARGE:
        placed = keep_places(system, workspace, t, q, given)
        q = q if _beyond(system, workspace, t, placed) else placed
    if system.row_count > LARGE or missing or any(name in system.model.initial.offsets for name in held):
        return q, iterations
    kept = keep_positions(system, workspace, t, q, given)
    return (q if _beyond(system, workspace, t, kept) else kept), iterations


def _beyond(system: System, workspace: Workspace, t: float, q: np.ndarray) -> str:
    """In words, which pin is outside its bush at positions q (3 nb,); "" if none is."""
    open_by(workspace, t, q, np.zeros_like(q))
    return outside(system, workspace)


def _inside(
    system: System, workspace: Workspace, t: float, offsets: dict[str, Any], held: list[str], missing: list[str],
    ideal: Assembled, shut: System, otherwise: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Positions (3 nb,) with all pins inside their bushes; `otherwise` if there are none.

    Where given values are too rough for the play, pins start where the mechanism without play has them, and massless
    links stand in other directions than the reactions have.
    """
    every = list(dict.fromkeys([*held, *(name for name, one in system.model.joints.items() if _has_play(one))]))
    for turn in range(4 if missing else 1):
        for names in (held, every) if turn else (every,):
            aside = {name: tuple(turned(0.5 * math.pi * turn, offsets[name]).tolist()) for name in missing}
            try:
                q, _ = _closed(system, workspace, t, {**offsets, **aside}, names, missing, ideal, shut)
            except AssemblyError:
                continue
            if not _beyond(system, workspace, t, q):
                return q
    return otherwise


def undetermined(system: System, t: float, q: np.ndarray, joints: dict[str, Joint]) -> list[str]:
    """Joints, of those with contacts, whose pins have an offset or are not where other joints and given values say.

    Surfaces that only push touch, unless an angle is given for their bodies too.
    q: (3 nb,) positions [m, m, rad] near the start, which is at t [s].
    """
    model = system.model
    without = [name for name in joints if name not in model.initial.offsets]
    if not without or system.row_count > LARGE:
        return list(joints)
    workspace = system.workspace()
    open_by(workspace, t, q, np.zeros_like(q))
    known = np.eye(len(q))[~np.isnan(given_values(system, 0))]
    motions = free_motions(np.vstack([scaled_rows(system, workspace), known]))
    scale = np.tile([1.0, 1.0, 1.0 / system.size], system.body_count)

    def moves(joint: Joint) -> bool:
        """True if its pin can move in the bush while nothing that is known changes."""
        for motion in motions * (NUDGE * system.size * scale):
            ahead, back = (
                point_at(system, q + way * motion, joint.b) - point_at(system, q + way * motion, joint.a)
                for way in (1.0, -1.0)
            )
            if np.abs(ahead - back).max() > DETERMINED * NUDGE * system.size:
                return True
        return False

    driven = {driver.joint for driver in model.drivers.values()}
    turning = {one.b.body for one in model.joints.values() if one.name in driven} | {"ground"}

    def touches(joint: Joint) -> bool:
        bodies = {joint.a.body, joint.b.body} - turning
        return joint.one_sided is not None and any("angle" not in model.initial.bodies.get(one, {}) for one in bodies)

    return [name for name, joint in joints.items() if name not in without or touches(joint) or moves(joint)]


def _hold_offsets(
    system: System, model: Model, t: float, offsets: dict[str, Any], ideal: Assembled, given: np.ndarray
) -> tuple[np.ndarray, int]:
    """Positions (3 nb,) with the pins of some joints at given offsets [m], and the number of iterations.

    system, model: with these joints closed; here their bushes are shifted.  given: (3 nb,), nan if not given.
    """
    q, workspace = ideal.q.copy(), system.__dict__.pop("spare", None) or system.assembly_workspace()
    number = {name: n for n, name in enumerate(("ground", *system.bodies))}
    pins, places = [], []
    for n, (name, offset) in enumerate(offsets.items()):
        point = model.joints[name].a
        places.append((*point.at, *offset))
        for one in (name, *(key for key, driver in model.drivers.items() if driver.joint == name)):
            pins.append((number[point.body], system.first_value(one), n))  # both begin with the point on A
    found, iterations = hold_pins(
        workspace, t, q, given, system.size, np.array(pins, np.int64).reshape(-1, 3),
        np.array(places, dtype=float).reshape(-1, 4), int(system.row_count <= LARGE), np.empty((2, len(q))),
    )  # fmt: skip
    if found == NOT_FINITE:
        raise not_finite()
    if found == NOT_CLOSED:
        raise AssemblyError(why_open_from(replace(system, model=model), workspace, t, q))
    return q, iterations


def _refuse_offsets_along(system: System, q: np.ndarray) -> None:
    """Raise AssemblyError if the offset given for a guide or slot has a part along it, where nothing is play."""
    for name, offset in system.model.initial.offsets.items():
        joint = system.model.joints[name]
        if joint.line is None or not joint.is_loose:
            continue
        axis = pose(system, q, joint.a.body)[2] + joint.line
        along = offset[0] * math.cos(axis) + offset[1] * math.sin(axis)
        if abs(along) > SLANT * joint.clearance:
            raise AssemblyError(
                f"the offset of '{name}' in [initial] has a part of {along:.3g} m along the {joint.play.bearer}, which"
                f" points to {math.degrees(axis):.4g} deg: only the part across it is play; place the"
                f" {joint.play.borne} along it by x or y of its body"
            )


# ---------------------------------------------------------------- positions
def _positions(
    system: System, workspace: Workspace, t: float, offsets: dict[str, Any], ideal: Assembled | None, given: np.ndarray
) -> tuple[np.ndarray, int]:
    """Closed positions (3 nb,) that change given values least among all that are found, and the number of iterations.

    Where several do, the first of them.
    """
    small, tolerance = system.row_count <= LARGE, 1e-12 * system.size
    if small and not offsets and t == 0.0 and system.model.initial.near:
        q, iterations = _near_by(system, workspace, given)
        if q is not None:
            return q, iterations
    closings: list[tuple[float, np.ndarray]] = []  # the squared change of given values, positions
    least_gap, total, search = None, 0, Guesses(system, workspace, t, offsets, None if ideal is None else ideal.q)
    for number, q in enumerate(search):
        start = q.copy()
        gap, iterations = close_position(workspace, t, q, np.empty_like(q), tolerance, 60)
        if not gap <= 1e-9 * system.size and small and not closings and number < HARD:
            q[:] = start
            least_open(system, workspace, t, q)
            gap, more = close_position(workspace, t, q, np.empty_like(q), tolerance, 60)
            iterations += more
        total += iterations
        if gap <= 1e-9 * system.size:
            if ideal is not None or (not small and change_of_given(system, q, given) <= KEPT**2):
                return q, total
            if not closings and small:
                q = keep_positions(system, workspace, t, q, given)
            closings.append((change_of_given(system, q, given), q))
            if closings[0][0] <= KEPT**2 and (search.settled or closings[-1][0] > KEPT**2):
                break  # closings that change given values come after those that do not
            if closings[-1][0] <= KEPT**2 < closings[0][0]:
                closings = closings[-1:]
        elif least_gap is None or gap < least_gap[0]:
            least_gap = (gap, q)
    if closings:
        if not small:
            return min(closings, key=lambda closing: closing[0])[1], total
        if search.discrete and (kept := [q for change, q in closings if change <= KEPT**2]):
            return min(kept, key=search.away), total
        return _nearest(system, workspace, t, given, closings), total
    assert least_gap is not None
    _without_drivers(system, workspace, t)
    raise AssemblyError(why_open_from(system, workspace, t, least_gap[1]))


def _near_by(system: System, workspace: Workspace, given: np.ndarray) -> tuple[np.ndarray | None, int]:
    """Closed positions (3 nb,) beside a start near by, and the number of iterations; None if they are far from it.

    Given values are kept as well as that start has them.
    """
    near = system.model.initial.near
    if any(name not in near for name in system.bodies):
        return None, 0
    start = np.array([near[name] for name in system.bodies]).ravel()
    q = start.copy()
    became, iterations = close_near(workspace, 0.0, q, given, system.size, np.empty((2, len(q))))
    if became == NOT_FINITE:
        raise not_finite()
    if became != MOVED:
        return None, iterations
    change = change_of_given(system, q, given)
    kept = change <= max(KEPT**2, WORTH * change_of_given(system, start, given))
    return (q if kept or _nearest_alone(system, workspace, q, change) else None), iterations


def _nearest_alone(system: System, workspace: Workspace, q: np.ndarray, change: float) -> bool:
    """True if no other closed positions can change given values less than q (3 nb,) does, squared: `change`.

    Where all angles are given or driven, and places follow from angles, those would be near q; and near q there is one
    sheet of closed positions only, as it bends by about 1 / sigma, the least singular value of the constraints that is
    not zero.
    """
    if not ALONE * math.sqrt(change) < 1.0 or not system.fact("angles known", lambda: _angles_known(system)):
        return False
    open_by(workspace, 0.0, q, np.zeros_like(q))
    values = np.linalg.svd(scaled_rows(system, workspace), compute_uv=False)
    least = values[values > RANK * values[0]].min(initial=values[0])
    return bool(least > ALONE * math.sqrt(change))


def _angles_known(system: System) -> bool:
    """True if the angle of every body is given, or tied by joints and drivers to one that is, or to the ground.

    And if the joints are linear in the places of the bodies.
    """
    if not all(one.leaf.places and one.distance == 0.0 for one in system.model.joints.values()):
        return False
    groups = groups_at(system, 0.0)
    bodies = system.model.initial.bodies
    known = {groups[GROUND][0], *(groups[name][0] for name, values in bodies.items() if "angle" in values)}
    return all(group in known for group, _ in groups.values())


def _nearest(
    system: System, workspace: Workspace, t: float, given: np.ndarray, closings: list[tuple[float, np.ndarray]]
) -> np.ndarray:
    """Positions (3 nb,) that change given values least; those that do not are moved to change them less, first.

    closings: the squared change of given values, and positions; the first of them cannot be moved so.
    """
    best = closings[0]
    later = sorted(range(1, len(closings)), key=lambda n: closings[n][0])
    for n in later[:LOOKED]:
        if closings[n][0] > WORTH * best[0]:
            break
        q = keep_positions(system, workspace, t, closings[n][1], given)
        change = min(closings[n][0], change_of_given(system, q, given))  # moved by mass, it may count more than before
        if change < (1.0 - ALIKE) * best[0]:
            best = (change, q)
    return best[1]


def _without_drivers(system: System, workspace: Workspace, t: float) -> None:
    """Raise AssemblyError if the joints close without drivers, and the drivers conflict or have nothing to move."""
    from rattle.analyses.assembly.rank import drivers_without_dof

    if not system.model.drivers or system.row_count > LARGE:
        return
    try:
        q = consistent_start(compile_system(replace(system.model, drivers={})), t).q
    except AssemblyError:
        return
    place_only(workspace, q)
    drive(workspace, t)
    constraints(workspace)
    _refuse_two_drivers(system, workspace)
    for name, row in drivers_without_dof(system, workspace):
        off = abs(float(workspace.rows[row, at.RES]))
        raise AssemblyError(
            f"driver '{name}' asks for a position {off:.4g} {system.rows[row].unit} away from the one that the joints"
            " enforce: they leave its degree of freedom no motion (one driver too many); remove it, or free a joint"
        )


def _refuse_two_drivers(system: System, workspace: Workspace) -> None:
    """Raise AssemblyError if drivers move the same degree of freedom at the state in the workspace."""
    from rattle.analyses.assembly.rank import drivers_on_one_dof

    names = drivers_on_one_dof(system, workspace)
    if len(names) > 1:
        listed = ", ".join(f"'{one}'" for one in names[:-1]) + f" and '{names[-1]}'"
        raise AssemblyError(
            f"drivers {listed} drive the same degree of freedom; remove {'one' if len(names) == 2 else 'some'} of them"
        )


def _refuse_contradiction(system: System, workspace: Workspace, t: float, q: np.ndarray, v: np.ndarray) -> None:
    """Raise AssemblyError if the joints, or other drivers, contradict a driver."""
    from rattle.analyses.assembly.driver_conflicts import contradicted

    if system.row_count > LARGE:
        return
    found = contradicted(system, workspace, t, q, v, system.model.settings.t_end)
    if found:
        raise AssemblyError(found)


# ---------------------------------------------------------------- rates
def _free_rates(system: System, workspace: Workspace, t: float, q: np.ndarray, given: np.ndarray) -> np.ndarray:
    """Rates of an ideal mechanism: given ones are kept if the joints allow, the others follow."""
    v = np.where(np.isnan(given), 0.0, given)
    place_rates(workspace, q, v, given, ways_of_kernels(system))
    return _closed_rates(system, workspace, t, q, v, given)


def _closed_rates(
    system: System, workspace: Workspace, t: float, q: np.ndarray, v: np.ndarray, given: np.ndarray
) -> np.ndarray:
    """Rates near v that satisfy the constraints, with the least change of the given ones."""
    if system.row_count <= LARGE:
        return keep_rates(system, workspace, t, q, v, given)
    known = ~np.isnan(given)
    if known.any():
        weight = system.arrays["weight"].copy()
        weight[1:].reshape(-1)[known] *= HOLD
        free = system.arrays["massless"][:0]
        held = replace(system, arrays={**system.arrays, "weight": weight, "massless": free}).workspace()
        for _ in range(4):
            v[known] = given[known]
            close_rate(held, t, q, v)
    close_rate(workspace, t, q, v)
    return v
