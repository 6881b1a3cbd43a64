"""What of the given values determines the start of a run, at the parameters of the model and at others.

Given values that joints leave free complete the equations of the start.  Others are redundant: at other parameters they
contradict those, and assembly keeps all of them as far as joints allow, by the least change weighted with mass.  Where
joints alone determine the start, given values only choose one of its branches.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from rattle.analyses.assembly.assembly import Assembled, has_play, held_at_start, without_play
from rattle.analyses.assembly.branches import alone_within, as_near
from rattle.analyses.assembly.outward import outward
from rattle.analyses.assembly.pins import holds_by_contacts, pressed, with_play
from rattle.analyses.assembly.start_constants import constants_of, without_counting
from rattle.analyses.assembly.start_values import KEYS, change_of_given, given_values, left_at_zero
from rattle.analyses.assembly.tied_bodies import given_in_one_turn
from rattle.analyses.assembly.without_play import along_reactions
from rattle.analyses.straight_line.start_rows import (
    add_to,
    basis_beside,
    basis_of,
    held_system,
    placed_at,
    sizes,
    unit_vector,
)
from rattle.description.model import Joint
from rattle.equations.dense import LARGE, dense_rows
from rattle.equations.placement import point_at
from rattle.equations.system import System, compile_system, is_link
from rattle.jit import layout as at

KEPT = 1e-9  # share of its size by which a given value may be missed and yet count as kept
ROUNDING = 1e-14  # share of the largest rate or its size below which a value is said to be 0


class Branch(NamedTuple):
    """How far given positions may be from a start that does not need them, only chooses the branch by them."""

    within: float  # [rad, sizes of the mechanism]
    turns: np.ndarray  # (3 nb,) by what they count as other ones, in the turn of others [rad]; nan if not given


class Kept(NamedTuple):
    """What of the given values determines the start."""

    pins: list[str]  # joints with play that are closed, at the offset of their pin
    needed: list[int]  # coordinates whose given values complete the constraint rows
    also: list[int]  # coordinates whose given values hold as well
    balanced: tuple[int, ...] = ()  # coordinates that keep their given values as far as joints and others allow
    branch: Branch | None = None


def driven_bodies(system: System, start: Assembled) -> set[str]:
    """Bodies whose positions drivers fix at the start, so that no load changes their motion.

    At a dead centre bodies may be among them that drivers do not hold for long; none without drivers.
    """
    if not system.model.drivers:
        return set()
    basis, size = basis_of(system, start, []), 3 * system.body_count
    return {
        body
        for n, body in enumerate(system.bodies)
        if not any(add_to(list(basis), unit_vector(size, k)) for k in range(3 * n, 3 * n + 3))
    }


def placing_system(system: System) -> System:
    """The system without the rows that count from the start: what determines positions there."""
    return compile_system(without_counting(system.model)) if constants_of(system.model) else system


def is_pin(joint: Joint) -> bool:
    """True of a massless link, and of a pin with play in a bush: both are hinges at the offset of their pin."""
    return is_link(joint) or (joint.kind == "revolute" and joint.is_loose)


def closed_joints(system: System, start: Assembled) -> list[str]:
    """Joints with play that assembly closes, and that are closed at the start, at given offsets of their pins or 0."""
    placing = placing_system(system).model.joints
    names = [name for name in held_at_start(system) if name in placing]
    left = _left_open(system, start, names)
    return [name for name in names if left[name][0] <= KEPT * system.size]


def kept_rates(system: System, start: Assembled, pins: Sequence[str] | None = None) -> Kept | None:
    """What is kept of the given rates: with pins that start with the speed of their bushes, else with other joints too
    that have play and start with rates as without it.

    pins: those joints with play that are held at the start; None: of others it counts too that they happen to.  What
    counts from the start does so wherever it is.
    """
    joints = system.model.joints
    closed = [name for name in _closed_rates(system, start) if pins is None or name in pins or joints[name].from_start]
    kept = kept_values(system, start, [name for name in closed if is_pin(system.model.joints[name])], 1)
    return kept_values(system, start, closed, 1) if kept is None else kept


def _closed_rates(system: System, start: Assembled) -> list[str]:
    """Joints with play that start with rates as without it; of massless links those that place a body.

    Constraint rows say so where the bush is not moved to the pin: a bush that turns would carry it around.
    """
    scale = max(1.0, float(np.abs(start.v).max(initial=0.0)))
    links = [joint.name for _, _, joint in outward(system.model) if is_link(joint)]
    joints = system.model.joints.items()
    names = links + [
        name for name, joint in joints if not is_link(joint) and (is_pin(joint) or holds_by_contacts(joint))
    ]
    left = _left_open(system, start, names)
    return [name for name in names if left[name][1] <= KEPT * scale]


def _left_open(system: System, start: Assembled, names: Sequence[str]) -> dict[str, tuple[float, float]]:
    """By how much joints with play would be open at the start without it [m or rad], and their rates [m/s or rad/s]."""
    closed = held_system(system.model, names, [])
    moved, unmoved = placed_at(closed, start, names), placed_at(closed, start, [])
    rates = dense_rows(closed, unmoved) @ start.v
    left = dict.fromkeys(names, (0.0, 0.0))
    for n, row in enumerate(closed.rows):
        if row.owner in left and not row.driver:
            beyond = abs(float(moved.rows[n, at.RES])), abs(float(rates[n]))
            left[row.owner] = max(left[row.owner][0], beyond[0]), max(left[row.owner][1], beyond[1])
    return left


def kept_values(system: System, start: Assembled, pins: list[str], turn: int) -> Kept | None:
    """What is kept of the given positions (turn 0) or rates (turn 1); None if it does not determine all of them.

    Rates of which none is given are the least that the constraints allow: no coordinate is needed for them.  Beside
    play they are those of the mechanism without it.
    """
    if turn == 1 and not pins and _rates_are_least(system):
        return Kept([], [], [])
    held, kept = held_system(system.model, pins, []), Kept(pins, [], [])
    if turn == 0:  # pins go before given places and angles
        basis, joints = basis_of(held, start, pins), basis_beside(held, start, pins)
    else:
        basis, joints = basis_of(held, start, []), basis_beside(system, start, [])
    wanted, now = given_values(system, turn), (start.q, start.v)[turn]
    for k in np.flatnonzero(_agrees(system, now, wanted)).tolist():
        if add_to(basis, unit_vector(len(wanted), k)):
            kept.needed.append(k)
        elif add_to(list(joints), unit_vector(len(wanted), k)):
            kept.also.append(k)
    if turn == 0:
        kept.needed.extend(k for k in left_at_zero(system, now, wanted) if add_to(basis, unit_vector(len(wanted), k)))
    return kept if len(basis) == len(wanted) else None


def _rates_are_least(system: System) -> bool:
    """True if no rates are given, and none are those of the mechanism without play."""
    driven = bool(system.model.drivers) and has_play(system.model)
    return not where_given(system, 1) and not system.watched and not driven


def where_given(system: System, turn: int) -> list[int]:
    """Coordinates of which positions (turn 0) or rates (turn 1) are given."""
    return [int(k) for k in np.flatnonzero(~np.isnan(given_values(system, turn)))]


def pressed_offsets(system: System, start: Assembled) -> dict[str, tuple[float, float]]:
    """Offsets [m] of pins that reactions press at the start; none where given places move one of them elsewhere."""
    joints = system.model.joints
    names = pressed(system.model, with_play(system.model)[0])
    shut, ideal = without_play(system)
    places = given_values(system, 0).reshape(-1, 3)[:, :2]
    jumps = bool(shut.rough_joints or shut.switches)  # friction and switches would change the reactions
    if not names or jumps or not isinstance(ideal, Assembled) or not np.isnan(places).all():
        return {}
    offsets = along_reactions(shut, start.t, ideal.q, ideal.v, {name: joints[name].clearance for name in names})
    where = {
        name: point_at(system, start.q, joints[name].b) - point_at(system, start.q, joints[name].a) for name in names
    }
    stands = all(np.abs(where[name] - offsets[name]).max() <= KEPT * system.size for name in names)
    return offsets if stands else {}


def as_alone(system: System, start: Assembled, pins: list[str], kept: Kept | None) -> Kept | None:
    """What is kept so that starts at other parameters are those of assembly; None where that is not known.

    kept: what is kept of the given positions here.  Those that are redundant contradict each other at other parameters.
    Where joints alone determine the start they only choose one of several branches.
    """
    if kept is not None and kept.needed and not _redundant(system, kept, 0):
        return kept
    if has_play(system.model) and (kept is None or any(name not in system.model.initial.offsets for name in pins)):
        return kept if kept is not None and _holds_all(system, start, kept) else None  # pins may go from the middle
    if kept is None or kept.needed:
        kept = _balanced(system, start, pins, 0)
    return None if kept is None else kept._replace(also=[], branch=_branch(system, start))


def _holds_all(system: System, start: Assembled, kept: Kept) -> bool:
    """True if every given position that joints do not determine is kept exactly."""
    joints = basis_beside(system, start, [])
    others = set(where_given(system, 0)) - {*kept.needed, *kept.also}
    return not any(add_to(list(joints), unit_vector(len(start.q), k)) for k in others)


def rates_as_alone(system: System, start: Assembled, kept: Kept | None) -> Kept | None:
    """The same of rates, of which there is one branch."""
    rates = given_values(system, 1)
    contradict = bool((~np.isnan(rates) & ~_agrees(system, start.v, rates)).any())
    if has_play(system.model):
        return None if contradict else kept
    if kept is None or _redundant(system, kept, 1):
        return _balanced(system, start, [], 1)
    return kept


def _balanced(system: System, start: Assembled, pins: list[str], turn: int) -> Kept | None:
    """All given positions (turn 0) or rates (turn 1), where they determine the start: each is kept as far as others
    allow."""
    size, balanced = len(start.q), where_given(system, turn)
    balanced += left_at_zero(system, start.q, given_values(system, 0)) if turn == 0 else []
    basis = basis_of(held_system(system.model, pins, []), start, pins)
    for k in balanced:
        add_to(basis, unit_vector(size, k))
    whole = len(basis) == size and not len(system.arrays["massless"])
    return Kept(pins, [], [], balanced=tuple(balanced)) if whole else None


def _branch(system: System, start: Assembled) -> Branch:
    """How far given positions may be from the start.

    As in assembly, which looks for the branch without play, from which one with play is half as far.
    """
    shut, ideal = without_play(system) if has_play(system.model) else (system, start)
    wanted = given_in_one_turn(system, start.t)
    within = math.sqrt(as_near(0.0))
    if isinstance(ideal, Assembled) and shut.row_count <= LARGE:
        changed = as_near(change_of_given(shut, ideal.q, wanted))
        within = max(within, math.sqrt(changed), 0.5 * alone_within(shut, shut.workspace(), ideal.q))
    return Branch(within if shut is system else 0.5 * within, wanted - given_values(system, 0))


def _redundant(system: System, kept: Kept, turn: int) -> bool:
    """True if given positions (turn 0) or rates (turn 1) may contradict those that are needed, at other parameters.

    Also where joints hold them here: as of a parallelogram, whose coupler turns where its sides differ.
    """
    return bool(set(where_given(system, turn)) - set(kept.needed))


def _agrees(system: System, now: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """(3 nb,) True where a coordinate or rate has its given value; not where none is given."""
    return np.asarray(np.abs(now - wanted) <= KEPT * scale_of(system, now) * sizes(system))


def scale_of(system: System, now: np.ndarray) -> float:
    """The largest coordinate or rate, in sizes of the mechanism or rad (per second), at least 1."""
    return max(1.0, float(np.abs(now / sizes(system)).max(initial=0.0)))


def lacking(system: System, start: Assembled) -> str:
    """What [initial] must give so that the start follows from it, in words; "" if it does."""
    placed = closed_joints(system, start)
    links = [name for name, joint in system.model.joints.items() if is_pin(joint)]
    without = [name for name in links if name not in placed]
    advice = [f"give the offset of {', '.join(without)}"] if without else []
    advice += _lacking_values(system, start, links, 0)
    placed_all = kept_values(placing_system(system), start, placed, 0) is not None
    if not advice or (placed_all and kept_rates(system, start) is None):  # rates follow once the positions do
        advice = _lacking_values(system, start, _closed_rates(system, start), 1)
    return "; ".join(advice)


def _lacking_values(system: System, start: Assembled, pins: list[str], turn: int) -> list[str]:
    """What to give of the positions (turn 0) or rates (turn 1), in words; pins: links that are held at the start."""
    wanted, now = given_values(system, turn), (start.q, start.v)[turn]
    now = np.where(np.abs(now) <= ROUNDING * scale_of(system, now) * sizes(system), 0.0, now)
    names = [f"{body}.{key}" for body in system.bodies for key in KEYS[turn]]
    agrees, advice = _agrees(system, now, wanted), []
    moved = [k for k in np.flatnonzero(~np.isnan(wanted)) if not agrees[k]]
    if moved:
        values = ", ".join(f"{names[k]} = {now[k]:.12g} (not {wanted[k]:.6g})" for k in moved)
        advice.append(f"give what the joints allow: {values}")
    if free := _undetermined(placing_system(system) if turn == 0 else system, start, pins, turn):
        advice.append(f"give {', '.join(f'{names[k]} (it is {now[k]:.12g})' for k in free)}")
    return advice


def _undetermined(system: System, start: Assembled, pins: list[str], turn: int) -> list[int]:
    """Coordinates, angles first, that neither joints nor given positions (turn 0) or rates (turn 1) determine."""
    if kept_values(system, start, pins, turn) is not None:
        return []
    wanted = given_values(system, turn)
    size, basis = len(wanted), basis_of(held_system(system.model, pins, []), start, pins if turn == 0 else [])
    for k in np.flatnonzero(~np.isnan(wanted)):
        add_to(basis, unit_vector(size, int(k)))
    order = (*range(2, size, 3), *range(0, size, 3), *range(1, size, 3))  # angles first
    return [k for k in order if add_to(basis, unit_vector(size, k))]
