"""Timetable of a run: the instants, known in advance, at which expressions switch, and the jumps of drivers there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rattle.equations.system import System
from rattle.errors import ModelError, Problem
from rattle.jit import functions
from rattle.jit import layout as at
from rattle.language.instants import search_arrays
from rattle.results.event import Event
from rattle.solvers.driver_jumps import find_timetable

ROOM = 4096  # rows of `switchings` for a start
MORE = 16  # times the room that was needed at least, as a search that has no room begins again
FEW = 3  # jolts of a driver that are listed one by one, at most
UNITS = {"rad": ("rad", "rad/s", "N*m*s"), "m": ("m", "m/s", "N*s")}
SENTENCES = {  # of notes, also in pages
    "jolt": "driver '{driver}' jumps in speed by {size:.4g} {rate} at t = {t:.9g} s: an impulse of {impulse:.4g}"
    " {unit}, work of {work:.4g} J",
    "jolts": "driver '{driver}' jumps in speed {count} times, work of {work:.4g} J in total",
    "leap": "driver '{driver}' jumps by {size:.6g} {unit} at t = {t:.9g} s{more}: no body can follow; write a ramp,"
    " or a step in speed such as 10*max(0, t - 0.5)",
    "unresolved": "{name} switches too often to follow: steps do not end at its switching instants",
}


@dataclass(frozen=True)
class Jump:
    """A jump in the speed of a driver."""

    t: float  # [s]
    driver: str
    size: float  # speed after minus speed before [rad/s or m/s]
    unit: str  # of the driver's function: "rad" or "m"


@dataclass(frozen=True)
class Jolt:
    """The impulse and the work of a jump in speed."""

    jump: Jump
    impulse: float  # of the driver on its body B [N*m*s or N*s]
    work: float  # done by the driver [J]


@dataclass(frozen=True)
class Timetable:
    """Instants at which expressions of time switch, and jumps of drivers there."""

    instants: np.ndarray  # (n,) [s]
    jumps: tuple[Jump, ...]
    unresolved: tuple[str, ...]  # expressions with too many instants to follow
    arrays: Mapping[str, np.ndarray]  # of a workspace, with which a run follows it, see `language.instants`


ALWAYS = Timetable(np.zeros(0), (), (), {})


def timetable(system: System, start: float, end: float) -> Timetable:
    """Timetable of a run between two times [s].  Raises ModelError if a driver jumps in position."""
    timed = system.arrays["timed"]
    if not end > start:  # nothing switches: values of the definition
        return replace(ALWAYS, arrays={"timed": timed[:0]})
    if not len(timed):
        return ALWAYS
    functions.start()  # as plain Python thousands of instants take seconds, and giving up minutes
    room = ROOM
    while (needed := find_timetable(workspace := system.workspace(**_arrays(system, room)), start, end)) > 0:
        room = MORE * needed
    _require_no_leap(system, workspace.driver_leap)
    timed, edges = workspace.timed, workspace.edges
    names = [switch.name for switch in system.switches if switch.timed]
    lost = tuple(dict.fromkeys(names[n] for n in np.flatnonzero(timed[:, at.RESOLVED] == 0)))
    used = int(timed[-1, at.END_FOUND])
    rows = workspace.driver_jump[: used * len(workspace.driver_leap)]
    arrays = _arrays(system, used) | {
        "timed": timed.copy(), "switchings": workspace.switchings[:used].copy(), "edges": edges[: used + 2].copy(),
        "driver_jump": rows.copy(),
    }  # fmt: skip
    return Timetable(edges[1:][edges[1:] <= end], tuple(_jumps(system, rows)), lost, arrays)


def _arrays(system: System, room: int) -> dict[str, np.ndarray]:
    """Arrays of a workspace in which a timetable is found, with so many rows for `switchings`."""
    drivers = list(system.model.drivers) if system.arrays["timed"][:, at.DRIVES].any() else []
    leap = np.zeros((len(drivers), at.width("driver_leap")))
    for row, name in zip(leap, drivers, strict=True):
        turns = system.rows[system.first_row(name)].unit == "rad"
        row[at.LEAP_SLOT], row[at.LEAP_ROW] = system.driver_slot(name), system.first_row(name)
        row[at.LEAP_SCALE] = 1.0 if turns else system.size
    return {
        **search_arrays(max(1, len(system.model.recorded)), system.depth, room),
        "driver_leap": leap,
        "driver_jump": np.zeros((room * len(drivers), at.width("driver_jump"))),
        "jolt_rows": np.zeros((3 if drivers else 0, system.row_count)),
    }


def _require_no_leap(system: System, leap: np.ndarray) -> None:
    """Raise ModelError if drivers jump in position; leap: of a workspace."""
    problems = []
    for name, row in zip(system.model.drivers, leap.tolist(), strict=False):
        if row[at.LEAP_COUNT]:
            unit, more = system.rows[system.first_row(name)].unit, int(row[at.LEAP_COUNT]) - 1
            words = SENTENCES["leap"].format(
                driver=name, size=row[at.LEAP_SIZE], unit=unit, t=row[at.LEAP_AT],
                more=f" (and {more} more times)" if more else "",
            )  # fmt: skip
            problems.append(Problem(system.model.drivers[name].path, words))
    if problems:
        raise ModelError(problems)


def _jumps(system: System, rows: np.ndarray) -> Iterator[Jump]:
    """The rows of `driver_jump` in words."""
    names = list(system.model.drivers)
    for row in rows[rows[:, at.JUMP_AT] < np.inf].tolist() if len(rows) else ():
        unit = system.rows[int(row[at.JUMP_ROW])].unit
        yield Jump(row[at.JUMP_AT], names[int(row[at.JUMP_DRIVER])], row[at.JUMP_SIZE], unit)


def jolt_events(jolts: Sequence[Jolt]) -> list[Event]:
    """Jolts as events: `joint` is the driver, `normal_speed` its jump [rad/s, m/s], `energy_lost` minus work [J]."""
    return [
        Event(jolt.jump.t, jolt.jump.driver, "jolt", jolt.jump.size, impulse=jolt.impulse, energy_lost=-jolt.work)
        for jolt in jolts
    ]


def jolt_notes(jolts: Sequence[Jolt], table: Timetable) -> tuple[str, ...]:
    """Notes of a run on its jolts, and on expressions with too many switching instants."""
    notes = []
    for name in dict.fromkeys(jolt.jump.driver for jolt in jolts):
        own = [jolt for jolt in jolts if jolt.jump.driver == name]
        for jolt in own if len(own) <= FEW else own[:1]:
            _, rate, impulse = UNITS[jolt.jump.unit]
            notes.append(
                SENTENCES["jolt"].format(
                    driver=name, size=jolt.jump.size, rate=rate, t=jolt.jump.t, impulse=jolt.impulse, unit=impulse,
                    work=jolt.work,
                )
            )  # fmt: skip
        if len(own) > FEW:
            total = sum(jolt.work for jolt in own)
            notes.append(SENTENCES["jolts"].format(driver=name, count=len(own), work=total))
    return (*notes, *unresolved_notes(table))


def unresolved_notes(table: Timetable) -> tuple[str, ...]:
    """Notes on expressions with too many switching instants."""
    return tuple(SENTENCES["unresolved"].format(name=name) for name in table.unresolved)


def jump_lines(jumps: Sequence[Jump]) -> list[str]:
    """One line per driver that jumps in speed: when and by how much."""
    lines = []
    for name in dict.fromkeys(jump.driver for jump in jumps):
        own = [jump for jump in jumps if jump.driver == name]
        first = own[0]
        more = f", and {len(own) - 1} more times" if len(own) > 1 else ""
        lines.append(
            f"{name} jumps in speed by {first.size:.4g} {UNITS[first.unit][1]} at t = {first.t:.9g} s{more}: an impulse"
        )
    return lines


def jump_notes(jumps: Sequence[Jump], forces: bool) -> list[str]:
    """Notes of kinematics on jumps in speed: at these instants there is no acceleration, and no finite force."""
    lost = "no acceleration and no finite force" if forces else "no acceleration"
    return [
        f"driver {line}; there is {lost} at such an instant: the values listed are those just after it"
        for line in jump_lines(jumps)
    ]
