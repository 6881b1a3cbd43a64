"""How the start of a run follows from chosen parameters: equations that hold there, solved by Newton's method.

Assembly keeps what is given where it can.  Where joints, kept coordinates and joints with play that start closed
together determine all positions, these are the solution of Phi = 0, q_k = given_k, e = offset near the positions that
were assembled, whatever the way there; likewise the rates.  Kept coordinates enter as drivers of bodies, joints that
are closed, at the offsets of their pins, as those without play, so that the package's own kernels solve for them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from rattle.analyses.assembly.assembly import Assembled, has_play, held_at_start, without_play
from rattle.analyses.assembly.loop_map import loop_map
from rattle.analyses.assembly.outward import outward
from rattle.analyses.assembly.pins import holds_by_contacts
from rattle.analyses.assembly.start_constants import constants_of, counting_rows, with_constants, without_counting
from rattle.analyses.assembly.start_values import KEYS, given_values, left_at_zero
from rattle.analyses.assembly.without_play import ideal_model
from rattle.description.model import Driver, Joint, Model, Point
from rattle.equations.closure import close_rate
from rattle.equations.dense import dense_rows
from rattle.equations.motion import constraints, drive, place
from rattle.equations.placement import point_at
from rattle.equations.start import place_rates
from rattle.equations.system import System, compile_system, is_link
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace
from rattle.language.recorded import Flag, Operand, symbol_of
from rattle.trace.recording import Recorder, Recording

KEPT = 1e-9  # share of its size by which a given value may be missed and yet count as kept
ROUNDING = 1e-14  # share of the largest rate or its size below which a value is said to be 0
DIGITS = 1e-4  # [rad, sizes of the mechanism] by which given values that have few digits are missed, not more
RANK = 1e-8  # share of its length that a row adds to others, at least, where it is independent of them
START_OF = "start of "  # before the name of a coordinate that a driver keeps
Shift = Callable[[SimpleNamespace | Workspace], None]


class Gap(NamedTuple):
    """What must close at the start."""

    words: str  # before the number
    open: Operand  # at y [m or rad]
    unit: str


@dataclass(frozen=True)
class RecordedStart:
    """Functions of the start, on the inputs of a recorded model; its y holds the positions to start from."""

    correction: list[Operand]  # (3 nb,) positions after a step of Newton's method, what is left open [m or rad], a flag
    rates: list[Operand]  # (3 nb,) rates at closed positions, by how much given ones are missed [m/s or rad/s], a flag
    gaps: list[Gap]  # what is open at y
    constants: list[
        Operand
    ]  # (nc,) those that the start sets, at closed positions [m or rad]; then a flag if there are any
    ideal: RecordedIdeal | None = None  # whose rates are those of the state with which `rates` are computed


@dataclass(frozen=True)
class RecordedIdeal:
    """The start of the mechanism without play, with whose rates one with play begins, on inputs of the same kind."""

    places: np.ndarray  # (3 nb,) near which it is [m, m, rad]
    correction: list[Operand]  # as of `RecordedStart`
    rates: list[Operand]


class Kept(NamedTuple):
    """What of the given values determines the start."""

    pins: list[str]  # joints with play that are closed, at the offset of their pin
    needed: list[int]  # coordinates whose given values complete the constraint rows
    also: list[int]  # coordinates whose given values hold as well


def record_start(
    system: System, start: Assembled, recorded: System, recorder: Recorder, y: np.ndarray, strict: bool
) -> RecordedStart | None:
    """Record how the start follows from the parameters; None where given values and joints do not determine it.

    system: the model at the parameters' values; recorded: the same with recorded numbers; y: (ny,) symbols.  strict:
    where given values contradict each other at other parameters only assembly knows.
    """
    kept = _kept(_placing(system), start, _closed(system, start), 0)
    if kept is None or (strict and _contradicted(system, start)):
        return None
    slack = KEPT * _scale(system, start.q) * _sizes(system)
    for k, missed in _rounded(system, start, kept).items() if strict else ():
        kept.also.append(k)
        slack[k] += 2.0 * missed
    of_rates = _record_rates(system, start, recorded, recorder, y, slack, strict)
    if of_rates is None:
        return None
    q, (rates, ideal) = y[: 3 * system.body_count], of_rates
    correction, sound_correction, gaps = _positions(recorded, recorder, kept, q, slack)
    return RecordedStart(
        [*correction, sound_correction], rates, gaps, _constants(recorded, recorder, q), ideal
    )  # fmt: skip


def _record_rates(
    system: System, start: Assembled, recorded: System, recorder: Recorder, y: np.ndarray, slack: np.ndarray,
    strict: bool,
) -> tuple[list[Operand], RecordedIdeal | None] | None:  # fmt: skip
    """Rates with their flag, and the start without play if they begin from its own; None if neither is known."""
    nq, kept = 3 * system.body_count, _kept_rates(system, start)
    q = y[:nq]
    if kept is not None:
        rates, sound = _rates(recorded, recorder, kept, q)
        return [*rates, sound], None
    shut = _ideal(system, start) if strict else None
    if shut is None:
        return None
    rates, sound = _rates_near(system, recorded, recorder, q, y[nq : 2 * nq])
    return [*rates, sound], _record_ideal(shut, recorded, recorder, q, slack)


class _Shut(NamedTuple):
    """The mechanism without play, and what determines its start."""

    start: Assembled
    kept: Kept


def _ideal(system: System, start: Assembled) -> _Shut | None:
    """The mechanism without play where its rates, and nothing else, give those of the start; None elsewhere."""
    if not np.isnan(given_values(system, 1)).all() or system.watched or constants_of(system.model):
        return None
    if not has_play(system.model):
        return None
    shut, ideal = without_play(system)
    if not isinstance(ideal, Assembled) or constants_of(shut.model):
        return None
    kept, v, workspace = _kept(shut, ideal, [], 0), ideal.v.copy(), system.workspace()
    place_rates(workspace, start.q, v, np.full(len(v), np.nan), loop_map(system).arrays["start_ways"])
    close_rate(workspace, start.t, start.q, v)
    scale = max(1.0, float(np.abs(start.v).max(initial=0.0)))
    return _Shut(ideal, kept) if kept is not None and np.abs(v - start.v).max() <= KEPT * scale else None


def _record_ideal(
    shut: _Shut, recorded: System, recorder: Recorder, q: np.ndarray, slack: np.ndarray
) -> RecordedIdeal:  # fmt: skip
    ideal = compile_system(ideal_model(recorded.model))
    correction, sound_correction, _ = _positions(ideal, recorder, shut.kept, q, slack)
    rates, sound_rates = _rates(ideal, recorder, Kept([], [], []), q)
    return RecordedIdeal(shut.start.q, [*correction, sound_correction], [*rates, sound_rates])


def _rates_near(
    system: System, recorded: System, recorder: Recorder, q: np.ndarray, v: np.ndarray
) -> tuple[list[Operand], Flag]:  # fmt: skip
    """Rates near those of the mechanism without play, v, as `assembly.consistent_start` finds them; none is given."""
    held, free = Recording(recorded, recorder), np.full(len(v), np.nan)
    ways = loop_map(system).arrays["start_ways"]

    def close() -> list[Operand]:
        closing, rates = held.closing(0.0), v.copy()
        recorder.recorded(place_rates.python)(closing.workspace, q, rates, free, ways)
        for _ in range(2):
            closing.begin(q, rates)
            closing.close_rates(rates)
        return [*rates, 0.0]

    return held.guarded(close)


def _placing(system: System) -> System:
    """The system without the rows that count from the start: what determines positions there."""
    return compile_system(without_counting(system.model)) if constants_of(system.model) else system


def _constants(recorded: System, recorder: Recorder, q: np.ndarray) -> list[Operand]:
    """The residuals at q of rows that count from the start, their constants being 0; a flag if there are such rows."""
    counting = constants_of(recorded.model)
    if not counting:
        return []
    model = with_constants(recorded.model, dict.fromkeys(counting, 0.0))
    rigid = {name: replace(x, contact=None) if x.from_start else x for name, x in model.joints.items()}
    zero = compile_system(replace(model, joints=rigid))  # with the rows that contacts stand for
    where = recorder.recorded(point_at)

    def constants() -> list[Operand]:
        closing = Recording(zero, recorder).closing(0.0)
        closing.place(q, np.zeros(len(q), dtype=object))
        values: list[Operand] = []
        for name, rows in counting_rows(zero).items():
            left = tuple(closing.workspace.rows[n, at.RES] for n in rows)
            if name in rigid:
                (ax, ay), (bx, by) = where(zero, q, rigid[name].a), where(zero, q, rigid[name].b)
                left = recorder.recorded(rigid[name].leaf.start_constants)(left, (bx - ax, by - ay))
            values += left
        return values

    numbers, sound = Recording(zero, recorder).guarded(constants)
    return [*numbers, sound]


def driven_bodies(system: System, start: Assembled) -> set[str]:
    """Bodies whose positions drivers fix at the start, so that no load changes their motion.

    At a dead centre bodies may be among them that drivers do not hold for long; none without drivers.
    """
    if not system.model.drivers:
        return set()
    basis, size = _basis(system, start, []), 3 * system.body_count
    return {
        body
        for n, body in enumerate(system.bodies)
        if not any(_add(list(basis), _unit(size, k)) for k in range(3 * n, 3 * n + 3))
    }


# ---------------------------------------------------------------- what is kept
def _is_pin(joint: Joint) -> bool:
    """True of a massless link, and of a pin with play in a bush: both are hinges at the offset of their pin."""
    return is_link(joint) or (joint.kind == "revolute" and joint.is_loose)


def _closed(system: System, start: Assembled) -> list[str]:
    """Joints with play that assembly closes, and that are closed at the start, at given offsets of their pins or 0."""
    placing = _placing(system).model.joints
    names = [name for name in held_at_start(system) if name in placing]
    left = _left_open(system, start, names)
    return [name for name in names if left[name][0] <= KEPT * system.size]


def _kept_rates(system: System, start: Assembled) -> Kept | None:
    """What is kept of the given rates: with pins that start with the speed of their bushes, else with other joints too
    that have play and start with rates as without it."""
    closed = _closed_rates(system, start)
    kept = _kept(system, start, [name for name in closed if _is_pin(system.model.joints[name])], 1)
    return _kept(system, start, closed, 1) if kept is None else kept


def _closed_rates(system: System, start: Assembled) -> list[str]:
    """Joints with play that start with rates as without it; of massless links those that place a body.

    Constraint rows say so where the bush is not moved to the pin: a bush that turns would carry it around.
    """
    scale = max(1.0, float(np.abs(start.v).max(initial=0.0)))
    links = [joint.name for _, _, joint in outward(system.model) if is_link(joint)]
    joints = system.model.joints.items()
    names = links + [
        name for name, joint in joints if not is_link(joint) and (_is_pin(joint) or holds_by_contacts(joint))
    ]
    left = _left_open(system, start, names)
    return [name for name in names if left[name][1] <= KEPT * scale]


def _left_open(system: System, start: Assembled, names: Sequence[str]) -> dict[str, tuple[float, float]]:
    """By how much joints with play would be open at the start without it [m or rad], and their rates [m/s or rad/s]."""
    closed = _held(system.model, names, [])
    moved, unmoved = _placed(closed, start, names), _placed(closed, start, [])
    rates = dense_rows(closed, unmoved) @ start.v
    left = dict.fromkeys(names, (0.0, 0.0))
    for n, row in enumerate(closed.rows):
        if row.owner in left and not row.driver:
            beyond = abs(float(moved.rows[n, at.RES])), abs(float(rates[n]))
            left[row.owner] = max(left[row.owner][0], beyond[0]), max(left[row.owner][1], beyond[1])
    return left


def _kept(system: System, start: Assembled, pins: list[str], turn: int) -> Kept | None:
    """What is kept of the given positions (turn 0) or rates (turn 1); None if it does not determine all of them.

    Rates of which none is given are the least that the constraints allow: no coordinate is needed for them.  Beside
    play they are those of the mechanism without it.
    """
    wanted, now = given_values(system, turn), (start.q, start.v)[turn]
    driven = bool(system.model.drivers) and has_play(system.model)
    if turn == 1 and np.isnan(wanted).all() and not system.watched and not pins and not driven:
        return Kept([], [], [])
    basis = _basis(_held(system.model, pins, []), start, pins if turn == 0 else [])
    joints = list(basis) if turn == 0 else _basis(system, start, [])  # pins go before given places and angles
    kept = Kept(pins, [], [])
    for k in np.flatnonzero(_agrees(system, now, wanted)):
        unit = _unit(len(wanted), int(k))
        if _add(basis, unit):
            kept.needed.append(int(k))
        elif _add(list(joints), unit):
            kept.also.append(int(k))
    if turn == 0:
        kept.needed.extend(k for k in left_at_zero(system, now, wanted) if _add(basis, _unit(len(wanted), k)))
    return kept if len(basis) == len(wanted) else None


def _contradicted(system: System, start: Assembled) -> bool:
    """True if given positions are missed by more than their digits, or given rates are."""
    missed = np.abs(start.q - given_values(system, 0)) > DIGITS * _sizes(system)
    rates = given_values(system, 1)
    return bool(missed.any() or (~np.isnan(rates) & ~_agrees(system, start.v, rates)).any())


def _rounded(system: System, start: Assembled, kept: Kept) -> dict[int, float]:
    """By how much given coordinates are missed at the start that others determine, as digits in the file are few.

    At other parameters they are missed by more: assembly decides there which of the given ones it changes.
    """
    wanted = given_values(system, 0)
    joints, missed = _basis(system, start, []), np.abs(start.q - wanted)
    left = np.flatnonzero(~np.isnan(wanted)).tolist()
    return {
        k: float(missed[k])
        for k in left
        if k not in (*kept.needed, *kept.also) and _add(list(joints), _unit(len(wanted), k))
    }


def _agrees(system: System, now: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """(3 nb,) True where a coordinate or rate has its given value; not where none is given."""
    return np.asarray(np.abs(now - wanted) <= KEPT * _scale(system, now) * _sizes(system))


def _scale(system: System, now: np.ndarray) -> float:
    """The largest coordinate or rate, in sizes of the mechanism or rad (per second), at least 1."""
    return max(1.0, float(np.abs(now / _sizes(system)).max(initial=0.0)))


def _sizes(system: System) -> np.ndarray:
    """(3 nb,) what coordinates are compared with [m, m, rad]."""
    return np.tile([system.size, system.size, 1.0], system.body_count)


def _unit(n: int, k: int) -> np.ndarray:
    unit = np.zeros(n)
    unit[k] = 1.0
    return unit


def _basis(system: System, start: Assembled, pins: Sequence[str]) -> list[np.ndarray]:
    """Independent directions that the constraints hold, of joints that are hinges at the offsets of these pins."""
    basis: list[np.ndarray] = []
    for row in _rows(system, start, pins) * np.tile([system.size, system.size, 1.0], system.body_count):
        _add(basis, row)
    return basis


def _rows(system: System, start: Assembled, pins: Sequence[str] = ()) -> np.ndarray:
    """(nr, 3 nb) constraint rows at the start, of joints that are hinges at the offsets of these pins."""
    return dense_rows(system, _placed(system, start, pins))


def _placed(system: System, start: Assembled, pins: Sequence[str]) -> Workspace:
    """A workspace with the constraints at the start, of joints that are closed at the offsets of these pins."""
    workspace = system.plain_workspace()
    drive.python(workspace, start.t)
    place.python(workspace, start.q, start.v)
    _at_offsets(system, pins)(workspace)
    constraints.python(workspace)
    return workspace


def _add(basis: list[np.ndarray], row: np.ndarray) -> bool:
    """Add a row to an orthonormal basis if it is independent of it."""
    length = float(np.linalg.norm(row))
    for _ in range(2):
        for direction in basis:
            row = row - (direction @ row) * direction
    rest = float(np.linalg.norm(row))
    if not rest > RANK * length:
        return False
    basis.append(row / rest)
    return True


def lacking(system: System, start: Assembled) -> str:
    """What [initial] must give so that the start follows from it, in words; "" if it does."""
    placed = _closed(system, start)
    links = [name for name, joint in system.model.joints.items() if _is_pin(joint)]
    without = [name for name in links if name not in placed]
    advice = [f"give the offset of {', '.join(without)}"] if without else []
    advice += _lacking_values(system, start, links, 0)
    placed_all = _kept(_placing(system), start, placed, 0) is not None
    if not advice or (placed_all and _kept_rates(system, start) is None):  # rates follow once the positions do
        advice = _lacking_values(system, start, _closed_rates(system, start), 1)
    return "; ".join(advice)


def _lacking_values(system: System, start: Assembled, pins: list[str], turn: int) -> list[str]:
    """What to give of the positions (turn 0) or rates (turn 1), in words; pins: links that are held at the start."""
    wanted, now = given_values(system, turn), (start.q, start.v)[turn]
    now = np.where(np.abs(now) <= ROUNDING * _scale(system, now) * _sizes(system), 0.0, now)
    names = [f"{body}.{key}" for body in system.bodies for key in KEYS[turn]]
    agrees, advice = _agrees(system, now, wanted), []
    moved = [k for k in np.flatnonzero(~np.isnan(wanted)) if not agrees[k]]
    if moved:
        values = ", ".join(f"{names[k]} = {now[k]:.12g} (not {wanted[k]:.6g})" for k in moved)
        advice.append(f"give what the joints allow: {values}")
    if free := _undetermined(_placing(system) if turn == 0 else system, start, pins, turn):
        advice.append(f"give {', '.join(f'{names[k]} (it is {now[k]:.12g})' for k in free)}")
    return advice


def _undetermined(system: System, start: Assembled, pins: list[str], turn: int) -> list[int]:
    """Coordinates, angles first, that neither joints nor given positions (turn 0) or rates (turn 1) determine."""
    if _kept(system, start, pins, turn) is not None:
        return []
    wanted = given_values(system, turn)
    size, basis = len(wanted), _basis(_held(system.model, pins, []), start, pins if turn == 0 else [])
    for k in np.flatnonzero(~np.isnan(wanted)):
        _add(basis, _unit(size, int(k)))
    order = (*range(2, size, 3), *range(0, size, 3), *range(1, size, 3))  # angles first
    return [k for k in order if _add(basis, _unit(size, k))]


# ---------------------------------------------------------------- the mechanism with what is kept
def _held(model: Model, pins: Sequence[str], coordinates: Sequence[int]) -> System:
    """The model with some pins as hinges and some coordinates driven; those drivers come last, in this order."""
    bodies, drivers = list(model.bodies), dict(model.drivers)
    for k in coordinates:
        body, key = bodies[k // 3], KEYS[0][k % 3]
        name = f"{START_OF}{body}.{key}"
        value = model.initial.bodies.get(body, {}).get(key, 0.0)  # where only the rate is given, only the rate counts
        drivers[name] = Driver(name, f"body-{key}", "", value, Point(body, "", (0.0, 0.0)))
    joints = {name: replace(joint, contact=None) if name in pins else joint for name, joint in model.joints.items()}
    return compile_system(replace(model, joints=joints, drivers=drivers))


def _at_offsets(system: System, pins: Sequence[str]) -> Shift:
    """What moves the bush of a closed joint, and of its drivers, by the offset of its pin [m] in ground axes."""
    model = system.model

    def move(workspace: SimpleNamespace | Workspace) -> None:
        body, values = workspace.body, workspace.values
        for name in pins:
            a, (ax, ay) = system.arrays["joint"][system.joints.index(name), at.END_A], model.joints[name].a.at
            ex, ey = (symbol_of(x) for x in model.initial.offsets.get(name, (0.0, 0.0)))
            cos, sin = body[a, at.COS], body[a, at.SIN]
            moved = symbol_of(ax) + cos * ex + sin * ey, symbol_of(ay) - sin * ex + cos * ey
            for owner in (name, *(key for key, driver in model.drivers.items() if driver.joint == name)):
                k = system.first_value(owner)
                values[k], values[k + 1] = moved

    return move


# ---------------------------------------------------------------- recording
def _positions(
    recorded: System, recorder: Recorder, kept: Kept, q: np.ndarray, slack: np.ndarray
) -> tuple[list[Operand], Flag, list[Gap]]:
    """The correction of positions, its flag, and what is open; slack: (3 nb,) as `_missed` takes it."""
    held = Recording(_held(without_counting(recorded.model), kept.pins, kept.needed), recorder)
    open_at_q: list[Gap] = []

    def correct() -> list[Operand]:
        closing = held.closing(0.0, _at_offsets(held.system, kept.pins))
        corrected, still = q.copy(), np.zeros(len(q), dtype=object)
        closing.begin(corrected, still)
        open_at_q.extend(_open_rows(held.system, closing.workspace.rows, recorder))
        open_at_q.extend(_missed(recorded, recorder, kept, q, slack))
        closing.correct(corrected, still)
        left = [closing.gap(), *(gap.open for gap in _missed(recorded, recorder, kept, corrected, slack))]
        return [*corrected, recorder.largest(left)]

    correction, sound = held.guarded(correct)
    return correction, sound, open_at_q


def _missed(recorded: System, recorder: Recorder, kept: Kept, q: np.ndarray, slack: np.ndarray) -> list[Gap]:
    """What has no row of its own: given coordinates that the joints determine, and clearances that pins stand off.

    slack: (3 nb,) up to which the values of the model file count as kept [m or rad], since they are rounded there;
    only what is beyond it is missed.
    """
    bodies, gaps = list(recorded.model.bodies), []
    for k in kept.also:
        name = f"{bodies[k // 3]}.{KEYS[0][k % 3]} of [initial] is missed by"
        missed = recorder.largest([abs(q[k] - symbol_of(_given(recorded, k, 0))) - slack[k]])
        gaps.append(Gap(name, missed, ("m", "m", "rad")[k % 3]))
    for name in kept.pins:
        joint, offset = recorded.model.joints[name], recorded.model.initial.offsets.get(name)
        if offset is None or not _is_pin(joint):
            continue
        length = recorder.graph.apply("hypot", *map(symbol_of, offset))
        beyond, words = length - symbol_of(joint.clearance), "is beyond"
        if is_link(joint):
            beyond, words = abs(beyond), "is not"
        missed = recorder.largest([beyond - 2.0 * slack[::3].min()])
        gaps.append(Gap(f"the length of the offset of joint '{name}' {words} its clearance, by", missed, "m"))
    return gaps


def _open_rows(system: System, rows: np.ndarray, recorder: Recorder) -> list[Gap]:
    """The largest residual of every joint, driver and kept coordinate; of rows in m and in rad apart."""
    residuals: dict[tuple[str, str], list[Operand]] = {}
    for row, values in zip(system.rows, rows, strict=True):
        kept = row.owner.removeprefix(START_OF)
        name = f"{'driver' if row.driver else 'joint'} '{row.owner}' stays open by"
        if kept != row.owner:
            name = f"{kept} of [initial] is missed by"
        residuals.setdefault((name, row.unit), []).append(abs(values[at.RES]))
    return [Gap(name, recorder.largest(every), unit) for (name, unit), every in residuals.items()]


def _rates(recorded: System, recorder: Recorder, kept: Kept, q: np.ndarray) -> tuple[list[Operand], Flag]:
    """Rates from zero: two corrections, the second against rounding."""
    system = _held(recorded.model, kept.pins, kept.needed)
    values = system.arrays["values"].astype(object)
    for k, driver in zip(kept.needed, list(system.model.drivers)[len(recorded.model.drivers) :], strict=True):
        values[system.driver_slot(driver) + 1] = _given(recorded, k, 1)
    held = Recording(replace(system, arrays={**system.arrays, "values": values}), recorder)

    def close() -> list[Operand]:
        closing, v = held.closing(0.0), np.zeros(len(q), dtype=object)
        for _ in range(2):
            closing.begin(q, v)
            closing.close_rates(v)
        gaps = [abs(v[k] - symbol_of(_given(recorded, k, 1))) for k in kept.also]
        return [*v, recorder.largest(gaps)]

    return held.guarded(close)


def _given(recorded: System, k: int, turn: int) -> Operand:
    """The given value of a coordinate [SI]."""
    bodies = list(recorded.model.bodies)
    return recorded.model.initial.bodies[bodies[k // 3]][KEYS[turn][k % 3]]
