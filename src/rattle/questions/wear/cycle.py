"""One cycle of the motion with given profiles: what slides under which load, and the state at its end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.analyses.assembly.assembly import Assembled
from rattle.analyses.dynamics.methods import new_run
from rattle.analyses.dynamics.run import How, Run
from rattle.elements.worn_bins import BED
from rattle.equations.compliant import locate_contacts
from rattle.equations.motion import constraints, drive, place
from rattle.equations.system import System
from rattle.errors import SolverError
from rattle.jit import layout as at
from rattle.jit.choices import TINY
from rattle.questions.wear.pins import Depths, Pin, enter
from rattle.solvers.contacts.wear_march import bear_at, slide_under
from rattle.solvers.contacts.wear_sum import FILLED, FORCE_X, LOADS, SLIDING, STEPS_IN_ROW

Array = NDArray[np.float64]
FEWEST = 720  # steps in a cycle, at least: what turns passes every bin
CELL = math.radians(3.0)  # of directions of loads that are put together, and of angles of the pin
SIZE = 0.4  # of their sizes, relative
LARGEST = 600  # coordinates of a mechanism whose pins are moved outwards after a jump; larger ones find their places


class State(NamedTuple):
    """From where a cycle starts."""

    t: float  # [s]
    y: Array
    speeds: Array  # approach speeds of the contacts that last [m/s], 0 for the others


class Sliding(NamedTuple):
    """What a cycle has done."""

    work: Depths  # (2, bins) [J] for every pin that wears: int N |slip| dt in the bins of bush and pin
    loads: list[Array]  # (rows, 4) for every pin, see `solvers.contacts.wear_sum`
    shares: Array  # for every pin: work of the cycle over that under its loads at rest; damping, rows put together
    state: State  # at its end


def together(cycles: Sequence[Sliding]) -> Sliding:
    """The mean of some cycles, with the state at the end of the last; loads that are nearly equal are put together."""
    share = 1.0 / len(cycles)
    work = [share * sum(parts) for parts in zip(*(cycle.work for cycle in cycles), strict=True)]
    loads = [share * np.concatenate(parts) for parts in zip(*(cycle.loads for cycle in cycles), strict=True)]
    loads = [merged(rows) for rows in loads]
    return Sliding(work, loads, np.mean([cycle.shares for cycle in cycles], axis=0), cycles[-1].state)


def merged(rows: Array) -> Array:
    """Loads (rows, 4) whose force and angle fall into one cell, added up: their order does not matter.

    Cells are CELL [rad] wide in the direction of the force and the angle of the pin, and SIZE of the force's size.
    """
    slid = rows[rows[:, SLIDING] > 0.0]
    fx, fy, turned = slid[:, FORCE_X:].T / slid[:, SLIDING]
    size = np.hypot(fx, fy)
    size, slid, fx, fy, turned = (part[size > 0.0] for part in (size, slid, fx, fy, turned))
    if not len(slid):
        return np.asarray(slid)
    places = np.array([np.arctan2(fy, fx) / CELL, np.log(size / size.max()) / SIZE, turned / CELL])
    _, which = np.unique(np.round(places), axis=1, return_inverse=True)
    sums = np.zeros((which.max() + 1, 4))
    np.add.at(sums, which.ravel(), slid)
    return sums


def first_places(pin: Pin, loads: Array) -> Array:
    """Where the search for the places (rows, 2) [m] of a pin under its loads begins: on the way to the wall."""
    force = loads[:, FORCE_X : FORCE_X + 2]
    return np.asarray(0.5 * pin.clearance * force / np.maximum(np.hypot(*force.T), TINY)[:, None])


class Cycles:
    """Cycles of one mechanism, one after the other."""

    def __init__(self, system: System, pins: Sequence[Pin], start: Assembled, period: float, how: How) -> None:
        """period [s]; how: settings of the steps."""
        self.system, self.pins, self.period = system, pins, period
        self._start, self._how = start, how
        self.simulated = 0

    def run(self, depths: Depths, state: State | None) -> Sliding:
        """One cycle from a state; None: from the start.  Raises SolverError, KeyboardInterrupt."""
        run = self._new(depths, state)
        run.go()
        if run.interrupted:
            raise KeyboardInterrupt
        if run.message:
            raise SolverError(f"the motion could not be followed through a cycle: {run.message}", None)
        self.simulated += 1
        m, work, loads = run.workspace, [], []
        for pin in self.pins:
            count = m.wear_count[pin.contact]
            rows = int(count[FILLED]) + (count[STEPS_IN_ROW] > 0)
            work.append(m.wear_work[pin.contact, : 2 * pin.bins].reshape(2, pin.bins).copy())
            loads.append(m.wear_load[pin.contact * LOADS : pin.contact * LOADS + rows].copy())
        shut = m.contact_memory[:, at.CLOSED] == at.SHUT
        speeds = np.where(shut, m.contact_memory[:, at.SPEED], 0.0)
        shares = np.array([self._share(*parts) for parts in zip(self.pins, depths, work, loads, strict=True)])
        return Sliding(work, loads, shares, State(run.t_end, m.state.copy(), speeds))

    def _share(self, pin: Pin, depths: Array, work: Array, loads: Array) -> float:
        """Work [J] of a cycle over that which its loads do at rest."""
        at_rest, sums, places = np.zeros(2 * pin.bins), np.zeros(5), first_places(pin, loads)
        slide_under(pin.parameters(self.system.arrays["values"], depths), loads, places, at_rest, sums)
        return float(work.sum() / at_rest.sum()) if at_rest.any() else 1.0

    def _new(self, depths: Depths, state: State | None) -> Run:
        nq, start = 3 * self.system.body_count, self._start
        if state is not None:
            start = Assembled(state.t, state.y[:nq].copy(), state.y[nq : 2 * nq].copy(), 0.0, 0)
        run = new_run(self.system, start, np.zeros(0), start.t + self.period, self._how)
        if state is not None:
            run.workspace.state[:] = state.y
            run.workspace.wear_speed[:] = state.speeds
        enter(run.workspace.values, self.pins, depths)
        return run

    def moved(self, state: State, before: Depths, after: Depths) -> State:
        """The state at the end of a cycle, every pin moved to where the new profile bears it as the old one did.

        The least mass-weighted change of positions that the joints allow; rates stay.
        """
        y, nq = state.y.copy(), 3 * self.system.body_count
        if nq > LARGEST:
            return state
        m = self._new(before, state).workspace
        place(m, y[:nq], y[nq : 2 * nq])
        drive(m, state.t)
        constraints(m)
        locate_contacts(m)
        rows, wanted = [_whole(m.row_body[r], m.rows[r, at.AX : at.AX + 6], nq) for r in range(len(m.rows))], []
        wanted += [0.0] * len(rows)
        for pin, old, new in zip(self.pins, before, after, strict=True):
            shift = self._shift(m, pin, old, new)
            if shift is not None:
                rows += self._offset_rows(m, pin, nq)
                wanted += shift.tolist()
        if len(wanted) > len(m.rows):
            root = np.sqrt(np.maximum(self.system.arrays["weight"][1:].ravel(), 0.0))
            matrix = np.array(rows) * root
            y[:nq] += root * np.linalg.lstsq(matrix, np.array(wanted), rcond=1e-12)[0]
        return state._replace(y=y)

    def _shift(self, m: Any, pin: Pin, old: Array, new: Array) -> Array | None:
        """Displacement (2,) [m] of the pin that carries the same load on the new profile; None if it does not touch."""
        a, b = (m.body[m.contact[pin.contact, column]] for column in (at.A_BODY, at.B_BODY))
        if not m.contact_kinematics[pin.contact, at.GAP] < 0.0:
            return None
        arm_a, arm_b = _arms(m, pin)
        turn = np.array([[a[at.COS], a[at.SIN]], [-a[at.SIN], a[at.COS]]])  # to the frame of the bush
        here = turn @ (b[at.X : at.X + 2] + arm_b - a[at.X : at.X + 2] - arm_a)
        turned, sums, work = float(a[at.PHI] - b[at.PHI]), np.zeros(5), np.zeros(2 * pin.bins)
        p = pin.parameters(m.values, old)
        bear_at(p, float(here[0]), float(here[1]), turned, sums)
        load = np.array([[1.0, *(p[BED] * sums[:2]), turned]])
        if not np.hypot(*sums[:2]) > 0.0:
            return None
        there = here[None].copy()
        slide_under(pin.parameters(m.values, new), load, there, work, sums)
        return np.asarray(turn.T @ (there[0] - here))

    def _offset_rows(self, m: Any, pin: Pin, nq: int) -> list[Array]:
        """Derivatives (2, nq) of the offset of the pin by all coordinates."""
        both = m.contact[pin.contact, [at.A_BODY, at.B_BODY]]
        (sax, say), (sbx, sby) = _arms(m, pin)
        return [
            _whole(both, np.array([-1.0, 0.0, say, 1.0, 0.0, -sby]), nq),
            _whole(both, np.array([0.0, -1.0, -sax, 0.0, 1.0, sbx]), nq),
        ]


def _arms(m: Any, pin: Pin) -> list[Array]:
    """Arms (2,) [m] from the mass centres of A and B to the centres of bush and pin."""
    arms = []
    for k, column in enumerate((at.A_BODY, at.B_BODY)):
        body, (x, y) = m.body[m.contact[pin.contact, column]], m.values[pin.first + 2 * k : pin.first + 2 * k + 2]
        cos, sin = body[at.COS], body[at.SIN]
        arms.append(np.array([cos * x - sin * y, sin * x + cos * y]))
    return arms


def _whole(bodies: Array, six: Array, nq: int) -> Array:
    """A row over all coordinates, of its parts for two bodies."""
    row = np.zeros(nq)
    for k, body in enumerate(bodies):
        if body > 0:
            row[3 * body - 3 : 3 * body] += six[3 * k : 3 * k + 3]
    return row
