"""Constraint rows at the start of a mechanism, some of whose joints with play and given coordinates are held."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from rattle.analyses.assembly.assembly import Assembled
from rattle.analyses.assembly.rank import free_motions
from rattle.analyses.assembly.start_values import KEYS
from rattle.description.model import Driver, Model, Point
from rattle.equations.dense import dense_rows
from rattle.equations.motion import constraints, drive, place
from rattle.equations.system import System, compile_system
from rattle.jit import layout as at
from rattle.jit.workspace import Workspace
from rattle.language.recorded import Operand, symbol_of
from rattle.trace.graph import Symbol

ASIDE = 1e-3  # [rad, sizes of the mechanism] by which bodies are moved to positions that are not special
RANK = 1e-8  # share of its length that a row adds to others, at least, where it is independent of them
START_OF = "start of "  # before the name of a coordinate that a driver keeps
Shift = Callable[[SimpleNamespace | Workspace], None]


def held_system(model: Model, pins: Sequence[str], coordinates: Sequence[int]) -> System:
    """The model with some pins as hinges and some coordinates driven; those drivers come last, in this order."""
    bodies, drivers = list(model.bodies), dict(model.drivers)
    for k in coordinates:
        body, key = bodies[k // 3], KEYS[0][k % 3]
        name = f"{START_OF}{body}.{key}"
        value = model.initial.bodies.get(body, {}).get(key, 0.0)  # where only the rate is given, only the rate counts
        drivers[name] = Driver(name, f"body-{key}", "", value, Point(body, "", (0.0, 0.0)))
    joints = {name: replace(joint, contact=None) if name in pins else joint for name, joint in model.joints.items()}
    return compile_system(replace(model, joints=joints, drivers=drivers))


def with_offsets(system: System, offsets: Mapping[str, tuple[float, float]]) -> System:
    """The system with offsets of more pins [m]."""
    initial = replace(system.model.initial, offsets={**system.model.initial.offsets, **offsets})
    return compile_system(replace(system.model, initial=initial))


def at_offsets(
    system: System, pins: Sequence[str], pressed: Mapping[str, tuple[Operand, Operand]] | None = None
) -> Shift:
    """What moves the bush of a closed joint, and of its drivers, by the offset of its pin [m] in ground axes.

    pressed: offsets that are not given.
    """
    model = system.model
    offsets = {**model.initial.offsets, **(pressed or {})}

    def move(workspace: SimpleNamespace | Workspace) -> None:
        body, values = workspace.body, workspace.values
        for name in pins:
            a, (ax, ay) = system.arrays["joint"][system.joints.index(name), at.END_A], model.joints[name].a.at
            ex, ey = (x if isinstance(x, Symbol) else symbol_of(x) for x in offsets.get(name, (0.0, 0.0)))
            cos, sin = body[a, at.COS], body[a, at.SIN]
            moved = symbol_of(ax) + cos * ex + sin * ey, symbol_of(ay) - sin * ex + cos * ey
            for owner in (name, *(key for key, driver in model.drivers.items() if driver.joint == name)):
                k = system.first_value(owner)
                values[k], values[k + 1] = moved

    return move


def placed_at(system: System, start: Assembled, pins: Sequence[str]) -> Workspace:
    """A workspace with the constraints at the start, of joints that are closed at the offsets of these pins."""
    workspace = system.plain_workspace()
    drive.python(workspace, start.t)
    place.python(workspace, start.q, start.v)
    at_offsets(system, pins)(workspace)
    constraints.python(workspace)
    return workspace


def rows_at(system: System, start: Assembled, pins: Sequence[str] = ()) -> np.ndarray:
    """(nr, 3 nb) constraint rows at the start, of joints that are hinges at the offsets of these pins."""
    return dense_rows(system, placed_at(system, start, pins))


def basis_of(system: System, start: Assembled, pins: Sequence[str]) -> list[np.ndarray]:
    """Independent directions that the constraints hold, of joints that are hinges at the offsets of these pins."""
    basis: list[np.ndarray] = []
    for row in rows_at(system, start, pins) * np.tile([system.size, system.size, 1.0], system.body_count):
        add_to(basis, row)
    return basis


def basis_beside(system: System, start: Assembled, pins: Sequence[str]) -> list[np.ndarray]:
    """`_basis` a little beside the start: what joints hold there may be special, as at a dead centre."""
    free = free_motions(np.array(basis_of(system, start, pins)).reshape(-1, len(start.q)))
    moved = np.random.default_rng(1).normal(size=len(free)) @ free
    return basis_of(system, replace(start, q=start.q + ASIDE * sizes(system) * moved), pins)


def unit_vector(n: int, k: int) -> np.ndarray:
    unit = np.zeros(n)
    unit[k] = 1.0
    return unit


def add_to(basis: list[np.ndarray], row: np.ndarray) -> bool:
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


def sizes(system: System) -> np.ndarray:
    """(3 nb,) what coordinates are compared with [m, m, rad]."""
    return np.tile([system.size, system.size, 1.0], system.body_count)
