"""Ports of a mechanism: every element with every body on which it acts, and the powers in rows of a run.

    P_eb = Q_eb . v_b      power that element e gives to body b [W], v_b = (x', y', phi')
    sum over e: P_eb = m (v_x a_x + v_y a_y) + J omega alpha      sum over b: P_eb = supplied - stored - lost

Elements are joints and drivers, loads, and gravity, which stores what it takes.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.analyses.load_forces import gravity_over
from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.results.columns import width

Array = NDArray[np.float64]
GRAVITY = "gravity"


class Element(NamedTuple):
    """What exchanges power with bodies; bodies: numbers of A and B, 0 for the ground."""

    name: str
    kind: str
    bodies: tuple[int, int]


class Port(NamedTuple):
    """An element and a body on which it acts; column: where its generalised force begins, -1 for gravity."""

    element: int  # number of the element
    body: int  # number of the body, from 1 on
    side: int  # 0 for body A, 1 for body B
    column: int


class Flow(NamedTuple):
    """Powers [W] at instants (n): positive into the body, of the element from outside, lost, and stored."""

    ports: Array  # (n, ports)
    supplied: Array  # (n, elements)
    lost: Array
    stored: Array
    unbalanced: Array  # (n,) largest difference between the powers of a body and the rate of its kinetic energy


class Ports:
    """All ports of a system, and how their powers follow from rows of a run with ports."""

    def __init__(self, system: System) -> None:
        self.system = system
        self.bodies = system.bodies
        self.elements = _elements(system)
        first, acting = width(system), len(system.joints) + len(system.model.loads)
        self.list: list[Port] = []
        for n, element in enumerate(self.elements[:acting]):
            for side, body in enumerate(element.bodies):
                if body and not (side == 0 and element.bodies[0] == element.bodies[1]):
                    self.list.append(Port(n, body, side, first + at.PER_PORT * n + (at.PORT_A, at.PORT_B)[side]))
        for body in range(1, len(self.bodies) + 1) if len(self.elements) > acting else ():
            self.list.append(Port(acting, body, 1, -1))
        self._first, self._acting = first, acting

    @cached_property
    def of_element(self) -> NDArray[np.int64]:
        """(ports,) number of the element of every port."""
        return np.array([port.element for port in self.list], np.int64)

    @cached_property
    def driven(self) -> NDArray[np.bool_]:
        """(elements,) True for drivers."""
        return np.array([element.name in self.system.model.drivers for element in self.elements], bool)

    def flow(self, t: Array, rows: Array) -> Flow:
        """Powers at the times t (n,) [s], from rows (n, width with ports) of a run [SI]."""
        nb = len(self.bodies)
        motion = rows[:, : at.PER_BODY * nb].reshape(-1, nb, 3, 3)
        rate, acceleration = motion[:, :, 1], motion[:, :, 2]
        mass = self.system.arrays["mass"][1:]
        gravity, change = gravity_over(self.system, t)
        fall = np.pad(gravity, ((0, 0), (0, 1)))
        powers = np.zeros((len(rows), len(self.list)))
        for k, port in enumerate(self.list):
            force = rows[:, port.column : port.column + 3] if port.column >= 0 else mass[port.body - 1, 0] * fall
            powers[:, k] = (force * rate[:, port.body - 1]).sum(axis=1)
        left = -(mass * rate * acceleration).sum(axis=2)
        for k, port in enumerate(self.list):
            left[:, port.body - 1] += powers[:, k]
        own = rows[:, self._first :].reshape(len(rows), self._acting, at.PER_PORT)
        kinds = [np.zeros((len(rows), len(self.elements))) for _ in range(3)]
        for values, column in zip(kinds, (at.SUPPLIED, at.WASTED, at.KEPT), strict=True):
            values[:, : self._acting] = own[:, :, column]
        if len(self.elements) > self._acting:
            kinds[0][:, self._acting] = -((motion[:, :, 0, :2] @ change[:, :, None])[:, :, 0] @ mass[:, 0])
            kinds[2][:, self._acting] = kinds[0][:, self._acting] - powers[:, self.of_element == self._acting].sum(
                axis=1
            )
        supplied, lost, stored = kinds
        return Flow(powers, supplied, lost, stored, np.abs(left).max(axis=1, initial=0.0))

    def impulses(self, work: Array) -> tuple[Array, Array]:
        """Energies (ports,) [J] into bodies and out of them by impulses, from a change of `port_work` (joints, 6)."""
        into, out = np.zeros(len(self.list)), np.zeros(len(self.list))
        for k, port in enumerate(self.list):
            if port.column >= 0 and port.element < len(work):
                column = (at.A_IN, at.B_IN)[port.side]
                into[k], out[k] = work[port.element, column], work[port.element, column + 1]
        return into, out


def _elements(system: System) -> tuple[Element, ...]:
    """Joints, drivers, loads, and gravity if there is any."""
    model, joint, load = system.model, system.arrays["joint"], system.arrays["load"]
    elements = []
    for n, name in enumerate(system.joints):
        kind = model.drivers[name].kind if name in model.drivers else model.joints[name].kind
        elements.append(Element(name, kind, (int(joint[n, at.END_A]), int(joint[n, at.END_B]))))
    for n, (name, source) in enumerate(model.loads.items()):
        elements.append(Element(name, source.kind, (int(load[n, at.END_A]), int(load[n, at.END_B]))))
    if model.falls:
        elements.append(Element(GRAVITY, GRAVITY, (0, 0)))
    return tuple(elements)
