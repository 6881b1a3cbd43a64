"""The mechanism without play, at whose start the assembly of one with play begins.

Of mechanisms that differ only in what their clearances and contacts are, as samples and designs often do, it is the
same: the last few that were found are kept.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple, TypeVar

import numpy as np

from rattle.description.model import Contact, Model, with_fields
from rattle.equations.start import press_pins
from rattle.equations.system import System, compile_system
from rattle.errors import AssemblyError
from rattle.language.syntax import Node, names

Start = TypeVar("Start")
KEPT = 4  # mechanisms


class IdealStart(NamedTuple):
    """A start of a mechanism without play."""

    model: Model  # see `_of_importance`
    t: float  # [s]
    system: System
    start: Any  # what `ideal_start` was told to find


_kept: tuple[IdealStart, ...] = ()  # replaced, never changed: threads may look at it at any time


def ideal_model(model: Model) -> Model:
    """The same mechanism with every clearance closed, and without stops and what bodies come to and leave."""
    closed = Contact("ideal", {})
    joints = {
        name: with_fields(joint, contact=closed if joint.contact else None, stop=None)
        if joint.contact or joint.stop
        else joint
        for name, joint in model.joints.items()
        if not joint.passing
    }
    if not model.initial.near:
        return with_fields(model, joints=joints)
    return with_fields(model, joints=joints, initial=with_fields(model.initial, near=model.initial.near_shut))


def ideal_start(
    model: Model, t: float, make: Callable[[Model], System], find: Callable[[System, float], Start]
) -> tuple[System, Start | AssemblyError]:
    """The mechanism without play that `make` makes, and its start at t [s] that `find` finds, or why there is none."""
    global _kept
    key = _of_importance(model)
    for kept in _kept:
        if kept.t == t and kept.model == key:
            return kept.system, kept.start
    ideal = ideal_model(model)
    try:
        system = make(ideal)
    except AssemblyError as error:
        return compile_system(ideal), error
    try:
        start = find(system, t)
    except AssemblyError as error:
        return system, error
    _kept = (IdealStart(key, t, system, start), *_kept[: KEPT - 1])
    return system, start


def _of_importance(model: Model) -> Model:
    """What the start without play depends on; constants are those that expressions use."""
    joints = {
        name: replace(joint, contact=None, clearance=0.0, dimensions={}, stop=None, constants=())
        if joint.contact or joint.stop or joint.constants
        else joint
        for name, joint in model.joints.items()
        if not joint.passing
    }
    drivers = {
        name: replace(driver, constants=()) if driver.constants else driver for name, driver in model.drivers.items()
    }
    values = [driver.value for driver in model.drivers.values()]
    values += model.falling or ()
    values += [value for load in model.loads.values() for value in load.values]
    values += [state.rate for state in model.states.values()]
    used = {name for node in (*values, *model.signals.values()) if isinstance(node, Node) for name in names(node)}
    constants = {name: value for name, value in model.constants.items() if name in used}
    return replace(model, joints=joints, drivers=drivers, constants=constants, parameters={}, remarks=(), groups=())


def along_reactions(
    system: System, t: float, q: np.ndarray, v: np.ndarray, clearances: Mapping[str, float]
) -> dict[str, tuple[float, float]]:
    """Pin offsets [m] at which pins press on their bushes in the directions of the reactions without play.

    system: without play; t: [s]; q, v: (3 nb,) its start [m, m, rad and their rates].
    clearances: of the joints that are asked for [m].
    """
    rows = np.array([system.first_row(name) for name in clearances], np.int64)
    pins = np.zeros((len(rows), 3))
    pins[:, 0] = list(clearances.values())
    press_pins(system.workspace(), t, q, v, rows, pins)
    return {name: (x, y) for name, (_, x, y) in zip(clearances, pins.tolist(), strict=True)}
