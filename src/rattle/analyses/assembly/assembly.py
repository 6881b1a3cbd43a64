"""Assembly: positions and rates that satisfy every joint at a given time.

Given angles are kept while the joints determine x and y, from the ground outwards; then a damped Newton
iteration satisfies all constraints with the least mass-weighted change.  Rates likewise (docs/theory.md, section 3).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from rattle.analyses.assembly.branches import alone_within, as_near
from rattle.analyses.assembly.computable import not_finite, require_digits
from rattle.analyses.assembly.held_bodies import with_held_bodies
from rattle.analyses.assembly.loop_map import loop_map
from rattle.analyses.assembly.outside import least_gaps, outside
from rattle.analyses.assembly.pins import held_pins, holds_by_contacts, play_arrays, pressed, undetermined, with_play
from rattle.analyses.assembly.rank import loose_without_mass
from rattle.analyses.assembly.searching import first_guess, search_arrays, why_open_from
from rattle.analyses.assembly.start_constants import (
    constants_at,
    constants_of,
    require_fit,
    with_constants,
    without_counting,
)
from rattle.analyses.assembly.start_notes import start_notes
from rattle.analyses.assembly.start_values import (
    Places,
    change_of_given,
    given_values,
    keep_rates,
    left_at_zero,
    places,
)
from rattle.analyses.assembly.tied_bodies import given_in_one_turn
from rattle.analyses.assembly.unclosed import without_value
from rattle.analyses.assembly.without_play import along_reactions, ideal_model, ideal_start
from rattle.description.model import Contact, Model
from rattle.equations import start_columns as of
from rattle.equations.closure import close_rate, open_by, place_only
from rattle.equations.dense import LARGE
from rattle.equations.kept_values import MOVED, NOT_CLOSED, NOT_FINITE, keep_given
from rattle.equations.motion import constraints, drive
from rattle.equations.placement import pose
from rattle.equations.start import NOT_HELD, close_near, find_positions, place_rates, put_inside
from rattle.equations.start import outside as _outside
from rattle.equations.system import System, compile_system, is_link
from rattle.errors import AssemblyError
from rattle.jit import layout as at
from rattle.jit.functions import IN_PYTHON
from rattle.jit.workspace import Workspace

HOLD = 1e-6  # factor on the inverse mass of given rates, in mechanisms too large for `start_values`
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
    start = consistent_start(system, t, ideal)
    require_digits(system, start.q)
    _require_held(system, start)
    if t != 0.0 or not told:
        return start
    shut = without_play(system, t)[0] if has_play(system.model) else system
    remarks, notes = system.model.remarks, start_notes(system, shut, t, start.q, start.v)
    return replace(start, notes=(*remarks, *notes.brief), changes=(*remarks, *notes.all))


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
    return any(is_link(joint) or holds_by_contacts(joint) for joint in model.joints.values())


def held_at_start(system: System) -> list[str]:
    """Joints with play that the start closes, at given offsets of their pins or 0; not those of which reactions say."""
    play = _play(system, 0.0, None)
    return [name for name in play.held if name not in play.missing]


def near_places(system: System, start: Assembled) -> tuple[Places, Places]:
    """Where the bodies are at a start, for others that are looked for near it; the same without play."""
    near = places(system, start.q)
    if not has_play(system.model):
        return near, {}
    shut, ideal = without_play(system)
    return near, places(shut, ideal.q) if isinstance(ideal, Assembled) else {}


def _require_held(system: System, start: Assembled) -> None:
    """Raise AssemblyError if a body without mass can move while all others rest."""
    if not len(system.arrays["massless"]):
        return
    workspace = system.workspace()
    open_by(workspace, start.t, start.q, start.v)
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
    return _put_together(with_held_bodies(model, _put_together, lambda system: consistent_start(system, 0.0).q))


def _put_together(model: Model) -> System:
    counting = list(constants_of(model))
    if not counting:
        return compile_system(model)
    q = _start_without(model, counting)
    constants = constants_at(compile_system(with_constants(model, dict.fromkeys(counting, 0.0))), q)
    system = compile_system(with_constants(model, constants))
    require_fit(system, q)
    return system


def _start_without(model: Model, counting: list[str]) -> np.ndarray:
    """Positions (3 nb,) [m, m, rad] of the start, found without the rows that count from it.

    Pins of massless links that the user has not placed are where the reactions of the whole mechanism press them.
    """
    loose = without_counting(model)
    offsets = dict(model.initial.offsets)
    if missing := pressed(loose, with_play(loose)[0]):
        shut, ideal = ideal_start(model, 0.0, put_together, consistent_start)
        if isinstance(ideal, AssemblyError):
            raise ideal
        clearances = {name: loose.joints[name].clearance for name in missing}
        offsets |= along_reactions(shut, 0.0, ideal.q, ideal.v, clearances)
        loose = replace(loose, initial=replace(loose.initial, offsets=offsets))
    return consistent_start(compile_system(loose), 0.0).q


def ideal_system(model: Model) -> System:
    """The same mechanism with every clearance closed, put together.  Raises AssemblyError."""
    return put_together(ideal_model(model))


def consistent_start(
    system: System, t: float, ideal: Assembled | None = None, workspace: Workspace | None = None
) -> Assembled:
    """As `assemble`, without notes on what could not be kept.  workspace: an `assembly_workspace` to work in."""
    workspace = system.assembly_workspace() if workspace is None else workspace
    _require_values(system, workspace, t)
    play = _play(system, t, ideal)
    wanted, rates, ideal = given_in_one_turn(system, t, workspace), given_values(system, 1), play.ideal
    near = None
    if system.row_count <= LARGE and t == 0.0 and system.model.initial.near and ideal is None and not play.joints:
        near = _near_by(system, workspace, wanted)
    q, iterations = near or _searched(system, workspace, t, wanted, play)
    if t == 0.0:  # the instant for which offsets are given
        _refuse_offsets_along(system, q)
    v = np.where(np.isnan(rates), 0.0 if ideal is None else ideal.v, rates)
    place_rates(workspace, q, v, rates, loop_map(system).arrays["start_ways"])
    v = _closed_rates(system, workspace, t, q, v, rates)
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


def _partly_closed(model: Model, t: float, names: list[str], why: AssemblyError) -> tuple[System, Assembled]:
    """The mechanism without the play of some joints, put together.  Raises `why` if that cannot be either."""
    joints = dict(model.joints)
    for name in names:
        joints[name] = replace(joints[name], contact=Contact("ideal", {}), stop=None)
    closed = replace(model, joints=joints)
    if not any(holds_by_contacts(joint) or is_link(joint) for joint in joints.values()):
        raise why
    try:
        system = put_together(closed)
        return system, consistent_start(system, t)
    except AssemblyError:
        raise why from None


class _Play(NamedTuple):
    """What the mechanism without play says of the start of one with play."""

    joints: list[str]  # those with play
    held: list[str]  # those of them whose pins are held at their offsets
    missing: list[str]  # massless links whose offsets follow from reactions
    shut: System  # without play
    ideal: Assembled | None  # its start


def _play(system: System, t: float, ideal: Assembled | None) -> _Play:
    """What is known before the search.  ideal: the start without play, if the system has none."""
    model = system.model
    links, open_ = system.fact("play", lambda: with_play(model))
    if not (links or open_):
        return _Play([], [], [], system, ideal)
    shut, start = without_play(system, t)
    if isinstance(start, Assembled):
        ideal = start
    near = first_guess(system, t) if ideal is None else ideal.q
    held = undetermined(system, t, near, {name: model.joints[name] for name in open_})
    if isinstance(start, AssemblyError) and (links or held):  # it need not close if given values determine all
        shut, ideal = _partly_closed(model, t, [*links, *held], start)
    return _Play([*links, *open_], [*links, *held] if ideal is not None else [], pressed(model, links), shut, ideal)


def _searched(
    system: System, workspace: Workspace, t: float, wanted: np.ndarray, play: _Play
) -> tuple[np.ndarray, int]:
    """Closed positions (3 nb,), and the number of iterations; the workspace gets the arrays of the search."""
    model, ideal, held = system.model, play.ideal, play.held
    places = {} if ideal is None else {"start_q": ideal.q, "start_v": ideal.v}
    every = list(dict.fromkeys([*held, *(name for name in play.joints if holds_by_contacts(model.joints[name]))]))
    arrays = search_arrays(system, wanted, model.initial.offsets) | {
        **play_arrays(system, play.shut, held, every, play.missing, ideal is not None),
        "start_least": np.array([math.nextafter(*least) for least in least_gaps(system)]),
        "start_q": np.zeros(len(wanted)), "start_v": np.zeros(len(wanted)),
    }  # fmt: skip
    workspace.put(arrays)
    closed, shut = _closed(system, play, held, places, workspace) if held else (system, workspace)
    beside = shut if closed is play.shut and held else workspace
    if places and beside is workspace:
        beside = play.shut.assembly_workspace(workspace, **places)
    became = find_positions(workspace, beside, shut, t)
    if became == MOVED and len(every) and _outside(workspace, t) >= 0:
        workspace.start_form[of.EVERY] = every != held
        more = _closed(system, play, every, places, workspace)[1] if every != held else shut
        put_inside(workspace, beside, shut, more, t)
    q = workspace.start_q.copy()
    if became == NOT_HELD:
        raise AssemblyError(why_open_from(closed, shut, t, q))
    _refuse_open(system, workspace, t, q, became)
    return q, int(workspace.start_search[of.ITERATIONS])


def _refuse_open(system: System, workspace: Workspace, t: float, q: np.ndarray, became: int) -> None:
    """Raise AssemblyError, with the reason, if positions were not found; q: where the gap is least."""
    if became == NOT_CLOSED:
        if workspace.start_search[of.TRIED] > 0:
            _without_drivers(system, workspace, t)
        raise AssemblyError(why_open_from(system, workspace, t, q))
    if became != MOVED:
        raise not_finite()


def _closed(
    system: System, play: _Play, held: list[str], places: dict[str, np.ndarray], beside: Workspace
) -> tuple[System, Workspace]:
    """The mechanism with some joints closed, whose pins are held, and a workspace beside another one.

    places: the start without play.
    """
    joints = {
        name: replace(joint, contact=None) if name in held else joint for name, joint in system.model.joints.items()
    }
    model = replace(system.model, joints=joints)
    alike = len(held) == len(play.joints) and not constants_of(model)  # its own start sets those of `shut`
    closed = play.shut if alike else compile_system(model)
    workspace = closed.__dict__.pop("spare", None)
    if workspace is None or (workspace.handle is IN_PYTHON) != (beside.handle is IN_PYTHON):
        workspace = closed.assembly_workspace(beside)
    workspace.put({"start_pins": held_pins(system, closed, held), **places})
    return closed, workspace


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
def _near_by(system: System, workspace: Workspace, wanted: np.ndarray) -> tuple[np.ndarray, int] | None:
    """Closed positions (3 nb,) beside a start near by, and the number of iterations; None if they are far from it.

    Given values are kept as well as that start has them, and angles that assembly leaves at 0.
    """
    near = system.model.initial.near
    if any(name not in near for name in system.bodies):
        return None
    start = np.array([near[name] for name in system.bodies]).ravel()
    wanted = wanted.copy()
    wanted[left_at_zero(system, start, wanted)] = 0.0
    q = start.copy()
    became, iterations = close_near(workspace, 0.0, q, wanted, system.size, np.empty((2, len(q))))
    if became == NOT_FINITE:
        raise not_finite()
    if became != MOVED:
        return None
    change = change_of_given(system, q, wanted)
    kept = change <= as_near(change_of_given(system, start, wanted))
    if not kept and not math.sqrt(change) < alone_within(system, workspace, q):
        return None
    keep_given(workspace, 0.0, q, wanted, system.size)
    return q, iterations


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
        listed = ", ".join(f"'{name}'" for name in names[:-1]) + f" and '{names[-1]}'"
        raise AssemblyError(
            f"drivers {listed} drive the same degree of freedom; remove {'one' if len(names) == 2 else 'some'} of them"
        )


def _refuse_contradiction(system: System, workspace: Workspace, t: float, q: np.ndarray, v: np.ndarray) -> None:
    """Raise AssemblyError if the joints, or other drivers, contradict a driver."""
    from rattle.analyses.assembly.driver_conflicts import contradicted

    if system.row_count > LARGE:
        return
    contradiction = contradicted(system, workspace, t, q, v, system.model.settings.t_end)
    if contradiction:
        raise AssemblyError(contradiction)


# ---------------------------------------------------------------- rates
def _closed_rates(
    system: System, workspace: Workspace, t: float, q: np.ndarray, v: np.ndarray, wanted: np.ndarray
) -> np.ndarray:
    """Rates near v that satisfy the constraints, with the least change of the given ones."""
    if system.row_count <= LARGE:
        return keep_rates(system, workspace, t, q, v, wanted)
    fixed = ~np.isnan(wanted)
    if fixed.any():
        weight = system.arrays["weight"].copy()
        weight[1:].reshape(-1)[fixed] *= HOLD
        free = system.arrays["massless"][:0]
        held = replace(system, arrays={**system.arrays, "weight": weight, "massless": free}).workspace()
        for _ in range(4):
            v[fixed] = wanted[fixed]
            close_rate(held, t, q, v)
    close_rate(workspace, t, q, v)
    return v
