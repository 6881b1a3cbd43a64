"""Timetable of a run: the instants, known in advance, at which expressions switch, and the jumps of drivers there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rattle.equations.motion import drive
from rattle.equations.system import System
from rattle.errors import ModelError, Problem
from rattle.jit import layout as at
from rattle.language.bytecode import SIDE
from rattle.language.switching import SAME, locate_all, merged, side_at
from rattle.results.event import Event

BEYOND = 1e-6  # share of a run by which the search extends beyond its end, so that a switch at the very end counts
FEW = 3  # jolts of a driver that are listed one by one, at most
LEAP = 1e-9  # change of a driver's function that counts as a jump, as a share of 1 rad or of the mechanism's size
KICK = 1e-9  # change of its speed that counts as a jump, as a share of its largest speed
UNITS = {"rad": ("rad", "rad/s", "N*m*s"), "m": ("m", "m/s", "N*s")}
SENTENCES = {  # of notes, also in pages
    "jolt": "driver '{driver}' jumps in speed by {size:.4g} {rate} at t = {t:.9g} s: an impulse of {impulse:.4g}"
    " {unit}, work of {work:.4g} J",
    "jolts": "driver '{driver}' jumps in speed {count} times, work of {work:.4g} J in total",
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
    """Instants at which expressions of time switch, and the sides of these switches between the instants."""

    instants: np.ndarray  # (n,) [s]
    rows: np.ndarray  # (k,) rows of the switches in the programs
    sides: np.ndarray  # (n + 1, k) -1, 0 or 1
    driving: np.ndarray  # (n,) True: a driver may jump at this instant
    jumps: tuple[Jump, ...]
    unresolved: tuple[str, ...]  # expressions with too many instants to follow

    def arrays(self, system: System) -> dict[str, np.ndarray]:
        """Workspace arrays with which a run follows it, see `solvers.run_loop`."""
        jumps = np.zeros((len(self.jumps), at.width("driver_jump")))
        jumps[:, at.JUMP_AT] = [jump.t for jump in self.jumps]
        jumps[:, at.JUMP_ROW] = [system.first_row(jump.driver) for jump in self.jumps]
        return {
            "instants": self.instants,
            "timed": self.rows,
            "timed_sides": self.sides,
            "driver_jump": jumps,
            "jolt_rows": np.zeros((3 if self.jumps else 0, system.row_count)),
        }

    def take(self, code: np.ndarray, piece: int) -> None:
        """Write the sides of a piece into the programs `code` (rows, 4) of a run."""
        code[self.rows, SIDE] = self.sides[piece]


ALWAYS = Timetable(np.zeros(0), np.zeros(0, np.int64), np.zeros((1, 0), np.int64), np.zeros(0, bool), (), ())


def timetable(system: System, start: float, end: float) -> Timetable:
    """Timetable of a run between two times [s].  Raises ModelError if a driver jumps in position."""
    span = end - start
    switches = [replace(one) for one in system.switches if one.timed] if span > 0.0 else []
    beyond = end + BEYOND * span
    if not switches:
        return ALWAYS
    locate_all(system.signals, switches, start, beyond)
    every = merged(switches, span)
    instants = every[every <= end + SAME * span]
    instants = np.where(instants >= end - SAME * span, end, instants)  # no step is left between it and the end
    edges = np.concatenate([[start], instants, [*every, beyond][len(instants) : len(instants) + 1]])
    middle = 0.5 * (edges[:-1] + edges[1:])
    sides = np.array([side_at(one, middle) for one in switches], np.int64).reshape(len(switches), len(middle)).T
    of_drivers = merged([one for one in switches if one.driving], span)
    driving = np.array([bool((np.abs(of_drivers - t) <= 2.0 * SAME * span).any()) for t in instants], bool)
    unresolved = tuple(dict.fromkeys(one.name for one in switches if not one.resolved))
    rows = np.array([one.row for one in switches], np.int64)
    table = Timetable(instants, rows, np.ascontiguousarray(sides), driving, (), unresolved)
    if any(one.driving for one in switches):
        return replace(table, jumps=_jumps(system, table, start))
    return table


def _jumps(system: System, table: Timetable, start: float) -> tuple[Jump, ...]:
    """Jumps in speed of all drivers.  Raises ModelError if a driver jumps in position, also at the start."""
    workspace = system.workspace()
    names = list(system.model.drivers)
    slots = np.array([system.driver_slot(name) for name in names])
    units = [system.rows[system.first_row(name)].unit for name in names]
    pieces = np.flatnonzero(table.driving).tolist()
    times = [start, *table.instants[pieces].tolist()]
    found = np.zeros((len(times), 2, 2, len(names)))  # instant, before and after, value and speed, driver
    for k, (t, piece) in enumerate(zip(times, [-1, *pieces], strict=True)):
        for side in range(2):
            if piece + side >= 0:  # before the start there is no piece: values of the definition are used
                table.take(workspace.code, piece + side)
            drive(workspace, t)
            for rate in range(2):
                found[k, side, rate] = workspace.values[slots + rate]
    problems, jumps = [], []
    for d, (name, unit) in enumerate(zip(names, units, strict=True)):
        leap = found[:, 1, 0, d] - found[:, 0, 0, d]
        scale = (1.0 if unit == "rad" else system.size) + np.abs(found[:, :, 0, d]).max(axis=1)
        broken = np.flatnonzero(np.abs(leap) > LEAP * scale)
        if len(broken):
            t, size = times[int(broken[0])], float(leap[broken[0]])
            more = f" (and {len(broken) - 1} more times)" if len(broken) > 1 else ""
            said = (
                f"driver '{name}' jumps by {size:.6g} {unit} at t = {t:.9g} s{more}: no body can follow;"
                " write a ramp, or a step in speed such as 10*max(0, t - 0.5)"
            )
            problems.append(Problem(("drivers", name), said))
        kick = found[:, 1, 1, d] - found[:, 0, 1, d]
        most = float(np.abs(found[:, :, 1, d]).max(initial=0.0))
        for k in np.flatnonzero(np.abs(kick) > KICK * most).tolist():
            if k > 0:  # the rates at the start are given by the start values
                jumps.append(Jump(times[k], name, float(kick[k]), unit))
    if problems:
        raise ModelError(problems)
    return tuple(sorted(jumps, key=lambda jump: jump.t))


def jolt_events(jolts: Sequence[Jolt]) -> list[Event]:
    """Jolts as events: `joint` is the driver, `normal_speed` its jump [rad/s, m/s], `energy_lost` minus work [J]."""
    return [
        Event(one.jump.t, one.jump.driver, "jolt", one.jump.size, impulse=one.impulse, energy_lost=-one.work)
        for one in jolts
    ]


def jolt_notes(jolts: Sequence[Jolt], table: Timetable) -> tuple[str, ...]:
    """Notes of a run on its jolts, and on expressions with too many switching instants."""
    said = []
    for name in dict.fromkeys(one.jump.driver for one in jolts):
        own = [one for one in jolts if one.jump.driver == name]
        for one in own if len(own) <= FEW else own[:1]:
            _, rate, impulse = UNITS[one.jump.unit]
            said.append(
                SENTENCES["jolt"].format(
                    driver=name, size=one.jump.size, rate=rate, t=one.jump.t, impulse=one.impulse, unit=impulse,
                    work=one.work,
                )
            )  # fmt: skip
        if len(own) > FEW:
            total = sum(one.work for one in own)
            said.append(SENTENCES["jolts"].format(driver=name, count=len(own), work=total))
    return (*said, *unresolved_notes(table))


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
