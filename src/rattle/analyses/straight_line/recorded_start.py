"""How the start of a run follows from chosen parameters: equations that hold there, solved by Newton's method.

Assembly keeps what is given where it can.  Where joints, kept coordinates and joints with play that start closed
together determine all positions, these are the solution of Phi = 0, q_k = given_k, e = offset near the positions that
were assembled, whatever the way there; likewise the rates.  Kept coordinates enter as drivers of bodies, joints that
are closed, at the offsets of their pins, as those without play, so that the package's own kernels solve for them.

Given positions that contradict each other are kept as far as Phi = 0 allows: min |W^-1/2 (q - given)|, found by

    q <- given + x,   x = -W Phi_q^T (Phi_q W Phi_q^T)^-1 (Phi + Phi_q (given - q)),   given_k = q_k where none is

with coordinates that are not given FIRST times as easy to move: at the end these do not move, so that it has no FIRST.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from rattle.analyses.assembly.assembly import Assembled, has_play, without_play
from rattle.analyses.assembly.loop_map import loop_map
from rattle.analyses.assembly.outside import least_gaps
from rattle.analyses.assembly.start_constants import constants_of, counting_rows, with_constants, without_counting
from rattle.analyses.assembly.start_values import KEYS, given_values
from rattle.analyses.assembly.without_play import ideal_model
from rattle.analyses.straight_line.start_kept import (
    KEPT,
    Branch,
    Kept,
    as_alone,
    closed_joints,
    is_pin,
    kept_rates,
    kept_values,
    placing_system,
    pressed_offsets,
    rates_as_alone,
    scale_of,
)
from rattle.analyses.straight_line.start_rows import START_OF, at_offsets, held_system, sizes, with_offsets
from rattle.equations.closure import close_rate
from rattle.equations.placement import point_at
from rattle.equations.start import place_rates, press_pins
from rattle.equations.system import System, compile_system, is_link
from rattle.jit import layout as at
from rattle.language.recorded import Flag, Operand, symbol_of
from rattle.trace.graph import select
from rattle.trace.lane_methods import total
from rattle.trace.recording import Recorder, Recording

BALANCES = 4  # corrections of rates that balance each other: each leaves 1/FIRST of the error
SLOW, ROUNDED = 0.1, 1e-12  # share of the correction before, and of the largest rate, that the last one may be
UNSETTLED = 1e300  # [m/s, rad/s] said of others
FIRST = 1e6  # by how much more easily coordinates move that are not given than those that are, in one step


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
    ideal: RecordedIdeal | None = None  # the start without play, where this one depends on it


@dataclass(frozen=True)
class RecordedIdeal:
    """The start of the mechanism without play, on inputs of the same kind.

    Of one with play `correction` takes its positions, and `rates` its rates, in place of rates.
    """

    places: np.ndarray  # (3 nb,) near which it is [m, m, rad]
    correction: list[Operand]  # as of `RecordedStart`
    rates: list[Operand]


def record_start(
    system: System, start: Assembled, recorded: System, recorder: Recorder, y: np.ndarray, gaps: Sequence[Operand],
    strict: bool,
) -> RecordedStart | None:  # fmt: skip
    """Record how the start follows from the parameters; None where given values and joints do not determine it.

    system: the model at the parameters' values; recorded: the same with recorded numbers; y: (ny,) symbols; gaps: of
    contacts at y, which start no deeper in their walls than assembly lets them, if strict.  strict:
    the start is that of assembly at other parameters too, wherever it is said to hold.
    """
    way = _way_as_alone(system, start) if strict else _way_as_given(system, start)
    if way is None:
        return None
    nq = 3 * system.body_count
    q, ideal_q = y[:nq], y[nq : 2 * nq]
    slack = KEPT * scale_of(system, start.q) * sizes(system)
    presses = None if way.shut is None else _Presses(way.pressed, recorded, recorder, ideal_q, way.shut.rates)
    deep = _deep(recorded, gaps) if strict else []
    correction, sound, opens = _positions(recorded, recorder, way.kept, q, slack, presses, deep)
    if way.rates is None:
        rates, sound_rates = _rates_near(system, recorded, recorder, q, ideal_q)
    else:
        rates, sound_rates = _rates(recorded, recorder, way.rates, q)
    ideal = None if way.shut is None else _record_ideal(way.shut, recorded, recorder, q, slack)
    return RecordedStart(
        [*correction, sound], [*rates, sound_rates], opens, _constants(recorded, recorder, q), ideal
    )  # fmt: skip


class _Way(NamedTuple):
    """How the start follows."""

    kept: Kept
    rates: Kept | None  # None: those beside the rates without play
    pressed: list[str]  # pins that stand where reactions without play press them
    shut: _Shut | None  # the start without play, where this one needs it


def _way_as_given(system: System, start: Assembled) -> _Way | None:
    """By what is kept of the given values; None where it does not determine the start."""
    kept = kept_values(placing_system(system), start, closed_joints(system, start), 0)
    rates = kept_rates(system, start)
    return None if kept is None or rates is None else _Way(kept, rates, [], None)


def _way_as_alone(system: System, start: Assembled) -> _Way | None:
    """As assembly finds it at other parameters; None where that is not known."""
    shut = _without_play(system)
    offsets = {} if shut is None else pressed_offsets(system, start)
    if offsets:
        system = with_offsets(system, offsets)
    placing, pins = placing_system(system), closed_joints(system, start)
    kept = as_alone(placing, start, pins, kept_values(placing, start, pins, 0))
    rates = rates_as_alone(system, start, kept_rates(system, start, pins))
    beside = rates is None and shut is not None and _begins_beside(system, start, shut.start)
    if kept is None or (rates is None and not beside):
        return None
    return _Way(kept, rates, list(offsets), shut if offsets or beside else None)


class _Shut(NamedTuple):
    """The mechanism without play, and what determines its start."""

    start: Assembled
    kept: Kept
    rates: Kept


def _without_play(system: System) -> _Shut | None:
    """The start without play of a mechanism with play; None where it is not known at other parameters."""
    if not has_play(system.model):
        return None
    shut, ideal = without_play(system)
    if not isinstance(ideal, Assembled) or constants_of(shut.model):
        return None
    kept = as_alone(shut, ideal, [], kept_values(shut, ideal, [], 0))
    rates = rates_as_alone(shut, ideal, kept_rates(shut, ideal))
    return None if kept is None or rates is None else _Shut(ideal, kept, rates)


def _begins_beside(system: System, start: Assembled, ideal: Assembled) -> bool:
    """True if the rates of the mechanism without play, and nothing else, give those of the start."""
    if not np.isnan(given_values(system, 1)).all() or constants_of(system.model):
        return False
    v, workspace = ideal.v.copy(), system.workspace()
    place_rates(workspace, start.q, v, np.full(len(v), np.nan), loop_map(system).arrays["start_ways"])
    close_rate(workspace, start.t, start.q, v)
    scale = max(1.0, float(np.abs(start.v).max(initial=0.0)))
    return bool(np.abs(v - start.v).max() <= KEPT * scale)


def _record_ideal(
    shut: _Shut, recorded: System, recorder: Recorder, q: np.ndarray, slack: np.ndarray
) -> RecordedIdeal:  # fmt: skip
    ideal = compile_system(ideal_model(recorded.model))
    correction, sound_correction, _ = _positions(ideal, recorder, shut.kept, q, slack)
    rates, sound_rates = _rates(ideal, recorder, shut.rates, q)
    return RecordedIdeal(shut.start.q, [*correction, sound_correction], [*rates, sound_rates])


@dataclass(frozen=True)
class _Presses:
    """Pins that reactions without play press on their bushes."""

    names: list[str]
    recorded: System  # with play
    recorder: Recorder
    q: np.ndarray  # (3 nb,) positions without play
    rates: Kept

    def offsets(self) -> dict[str, tuple[Operand, Operand]]:
        """Where they are in their bushes [m], by name."""
        if not self.names:
            return {}
        ideal = compile_system(ideal_model(self.recorded.model))
        recorder = Recorder(self.recorder.graph, self.recorder.beside, self.recorder.crowded)  # of no contacts
        rates, _ = _closed_rates(ideal, recorder, self.rates, self.q)
        pins = np.zeros((len(self.names), 3), dtype=object)
        pins[:, 0] = [symbol_of(self.recorded.model.joints[name].clearance) for name in self.names]
        first = np.array([ideal.first_row(name) for name in self.names])
        Recording(ideal, recorder).run(press_pins, 0.0, self.q, rates, first, pins)
        self.recorder.guards += recorder.guards
        return {name: (x, y) for name, (_, x, y) in zip(self.names, pins.tolist(), strict=True)}


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


def _positions(
    recorded: System, recorder: Recorder, kept: Kept, q: np.ndarray, slack: np.ndarray,
    presses: _Presses | None = None, deep: Sequence[Operand] = (),
) -> tuple[list[Operand], Flag, list[Gap]]:  # fmt: skip
    """The correction of positions, its flag, and what is open; slack: (3 nb,) as `_missed` takes it; deep: what must
    not be positive at q [m or rad]."""
    system = held_system(without_counting(recorded.model), kept.pins, kept.needed)
    held = Recording(_weighted(system, kept), recorder)
    open_at_q: list[Gap] = []

    def correct() -> list[Operand]:
        closing = held.closing(0.0, at_offsets(held.system, kept.pins, presses.offsets() if presses else {}))
        corrected, still = q.copy(), np.zeros(len(q), dtype=object)
        closing.begin(corrected, still)
        open_at_q.extend(_open_rows(held.system, closing.workspace.rows, recorder))
        open_at_q.extend(_missed(recorded, recorder, kept, q, slack))
        if kept.balanced:
            closing.approach(corrected, _way_back(recorded, kept, q))
        else:
            closing.correct(corrected, still)
        left = [closing.gap(), *deep, *(gap.open for gap in _missed(recorded, recorder, kept, corrected, slack))]
        return [*corrected, recorder.largest(left)]

    correction, sound = held.guarded(correct)
    return correction, sound, open_at_q


def _missed(recorded: System, recorder: Recorder, kept: Kept, q: np.ndarray, slack: np.ndarray) -> list[Gap]:
    """What has no row of its own: given coordinates that the joints determine, and clearances that pins stand off.

    slack: (3 nb,) up to which the values of the model file count as kept [m or rad], since they are rounded there;
    only what is beyond it is missed.
    """
    bodies, gaps = list(recorded.model.bodies), []
    if kept.branch is not None:
        gaps.append(Gap("given positions of [initial] are missed by", _strayed(recorded, recorder, kept.branch, q), ""))
    for k in kept.also:
        name = f"{bodies[k // 3]}.{KEYS[0][k % 3]} of [initial] is missed by"
        missed = recorder.largest([abs(q[k] - symbol_of(_given(recorded, k, 0))) - slack[k]])
        gaps.append(Gap(name, missed, ("m", "m", "rad")[k % 3]))
    for name in kept.pins:
        joint, offset = recorded.model.joints[name], recorded.model.initial.offsets.get(name)
        if offset is None or not is_pin(joint):
            continue
        length = recorder.graph.apply("hypot", *map(symbol_of, offset))
        beyond, words = length - symbol_of(joint.clearance), "is beyond"
        if is_link(joint):
            beyond, words = abs(beyond), "is not"
        missed = recorder.largest([beyond - 2.0 * slack[::3].min()])
        gaps.append(Gap(f"the length of the offset of joint '{name}' {words} its clearance, by", missed, "m"))
    return gaps


def _way_back(recorded: System, kept: Kept, q: np.ndarray) -> np.ndarray:
    """(3 nb,) from positions q to those that are given; 0 where none is."""
    way = np.zeros(len(q), dtype=object)
    for k in kept.balanced:
        turn = kept.branch.turns[k] if kept.branch is not None else 0.0
        way[k] = symbol_of(_given(recorded, k, 0)) + float(np.nan_to_num(turn)) - q[k]
    return way


def _strayed(recorded: System, recorder: Recorder, branch: Branch, q: np.ndarray) -> Operand:
    """By how much positions (3 nb,) are farther from the given ones than their branch allows."""
    places = np.flatnonzero(~np.isnan(branch.turns)).tolist()
    changes = [q[k] - symbol_of(_given(recorded, k, 0)) - float(branch.turns[k]) for k in places]
    lengths = [1.0 if k % 3 == 2 else 1.0 / float(recorded.size) for k in places]
    squares = [(change * length) * (change * length) for change, length in zip(changes, lengths, strict=True)]
    return recorder.largest([recorder.graph.apply("sqrt", total(squares)) - branch.within])


def _deep(recorded: System, gaps: Sequence[Operand]) -> list[Operand]:
    """By how much contacts are deeper in their walls than they may start [m or rad]; gaps: of all of them, or none."""
    leasts = [least for least, _ in least_gaps(recorded)]
    return [symbol_of(least) - gap for least, gap in zip(leasts, gaps, strict=False) if least > -math.inf]


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
    """Rates, by how much given ones are missed, and their flag."""

    def close() -> list[Operand]:
        v, left = _closed_rates(recorded, recorder, kept, q)
        gaps = [abs(v[k] - symbol_of(_given(recorded, k, 1))) for k in kept.also]
        return [*v, recorder.largest([*gaps, *left])]

    return Recording(recorded, recorder).guarded(close)


def _closed_rates(
    recorded: System, recorder: Recorder, kept: Kept, q: np.ndarray
) -> tuple[np.ndarray, list[Operand]]:  # fmt: skip
    """(3 nb,) rates from zero, or from those given, and by how much they have not settled if these balance each other.

    Two corrections or more, the last against rounding.  Where those that are not given hardly move a row, as at a dead
    centre, every correction leaves much of the error: that of the last two tells.
    """
    system = held_system(recorded.model, kept.pins, kept.needed)
    values = system.arrays["values"].astype(object)
    for k, driver in zip(kept.needed, list(system.model.drivers)[len(recorded.model.drivers) :], strict=True):
        values[system.driver_slot(driver) + 1] = _given(recorded, k, 1)
    held = Recording(_weighted(replace(system, arrays={**system.arrays, "values": values}), kept), recorder)
    closing, v = held.closing(0.0), np.zeros(len(q), dtype=object)
    moved: list[Operand] = []
    for _ in range(BALANCES if kept.balanced else 2):
        before = v.copy()
        for k in kept.balanced:
            v[k] = symbol_of(_given(recorded, k, 1))
        closing.begin(q, v)
        closing.close_rates(v)
        moved.append(recorder.largest([abs(x) for x in v - before]))
    if not kept.balanced:
        return v, []
    slow = moved[-1] - SLOW * moved[-2] - ROUNDED * recorder.largest([abs(x) for x in v])
    return v, [moved[-1], select(slow > 0.0, UNSETTLED, 0.0)]


def _weighted(system: System, kept: Kept) -> System:
    """The system whose coordinates that are not given move more easily, where some balance each other."""
    if not kept.balanced:
        return system
    weight = system.arrays["weight"].astype(object)
    others = np.setdiff1d(np.arange(3 * system.body_count), kept.balanced)
    weight[1:].reshape(-1)[others] *= FIRST
    return replace(system, arrays={**system.arrays, "weight": weight})


def _given(recorded: System, k: int, turn: int) -> Operand:
    """The given value of a coordinate [SI]."""
    bodies = list(recorded.model.bodies)
    return recorded.model.initial.bodies.get(bodies[k // 3], {}).get(KEYS[turn][k % 3], 0.0)
