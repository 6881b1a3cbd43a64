"""The state vector y of a run and its layout.

    y = [q, v, work, dissipated;  impulse, loss, stored of every contact;  states of elements;  states of the model]

q and v (3 nb each) are x, y [m], angle [rad] of every body in turn and their rates.  Energies and impulses are part of
y, so that they are integrated as accurately as the motion.  A kind with states of its own, such as a friction law with
bristles, declares how many it has (`states`); the row of the contact gives their place among those of all elements
(`at.FIRST_STATE`, `at.STATES`).  A kernel reads the values in `element_state` and writes their rates to `element_rate`.
States of the model ([states] of its file) come after those; their rates are expressions (`state_rate`), and expressions
find their values at the head of `signals`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from rattle.equations.system import System
from rattle.jit import layout as at
from rattle.jit.functions import compiled

ENERGIES = {"work": "J", "dissipated": "J"}  # work done on the mechanism; energy dissipated by loads
ACCOUNTS = {"impulse": "N*s", "loss": "J", "stored": "J"}  # of one contact: impulse of N, energy lost, energy stored
WORK, DISSIPATED = range(len(ENERGIES))
IMPULSE, LOSS, STORED = range(len(ACCOUNTS))
PER_CONTACT = len(ACCOUNTS)
FIRST_ACCOUNT = len(ENERGIES)


@compiled
def energies_at(m):
    """Index of the first energy in y."""
    return 2 * m.change.shape[0]


@compiled
def account_at(m, n):
    """Index of the first account of contact n in y."""
    return energies_at(m) + FIRST_ACCOUNT + PER_CONTACT * n


@compiled
def states_at(m):
    """Index of the first state of an element in y."""
    return account_at(m, m.contact.shape[0])


@compiled
def take_states(m, y):
    """Copy the states from y to `element_state`, where kernels read them, those of the model to `signals` too."""
    states, first, signals = m.element_state, states_at(m), m.signals
    own = m.state_rate.shape[0]
    of_elements = states.shape[0] - own
    for k in range(states.shape[0]):
        states[k] = y[first + k]
    for k in range(own):
        signals[k] = y[first + of_elements + k]
    if m.travelled.shape[0] > 0:
        m.travelled[0] = math.nan


@compiled
def take_travels(m, y):
    """Copy how far drivers have come whose speed is given from y to `signals`, where `drive` reads it."""
    if m.travelled.shape[0] == 0:
        return
    first = states_at(m) + m.element_state.shape[0] - m.state_rate.shape[0]
    for n in range(m.jet.shape[0]):
        state = m.jet[n, at.TRAVEL]
        if state >= 0:
            m.signals[state] = y[first + state]
    m.travelled[0] = math.nan


@compiled
def clear_states(m, n, y):
    """Set the states of contact n in y to zero."""
    first = states_at(m) + m.contact[n, at.FIRST_STATE]
    for k in range(m.contact[n, at.STATES]):
        y[first + k] = 0.0


@dataclass(frozen=True)
class StateLayout:
    """The layout of y: slices, names and units."""

    bodies: tuple[str, ...]
    contacts: tuple[str, ...]  # joint of every contact point
    state_owners: tuple[str, ...]  # joint of every state of an element
    angular: tuple[bool, ...]  # of every contact point: its gap is an angle, its N a moment
    own: tuple[tuple[str, str], ...] = ()  # name and unit of every state of the model

    @property
    def motion(self) -> slice:
        """Slice of q and v."""
        return slice(0, 6 * len(self.bodies))

    @property
    def states(self) -> slice:
        """Slice of the states of elements and of the model."""
        first = self.motion.stop + FIRST_ACCOUNT + PER_CONTACT * len(self.contacts)
        return slice(first, first + len(self.state_owners) + len(self.own))

    @property
    def own_states(self) -> slice:
        """Slice of the states of the model."""
        return slice(self.states.stop - len(self.own), self.states.stop)

    @property
    def size(self) -> int:
        """Length of y."""
        return int(self.states.stop)

    def account(self, n: int) -> slice:
        """Slice of impulse [N s], loss [J] and stored energy [J] of contact n."""
        first = self.motion.stop + FIRST_ACCOUNT + PER_CONTACT * n
        return slice(first, first + PER_CONTACT)

    def units(self) -> list[tuple[str, str]]:
        """Name and unit of every number in y, in order."""
        columns = list(at.OUTPUT_BODY.items())
        pairs = []
        for part in (columns[at.PLACE : at.RATE], columns[at.RATE : at.RATE_RATE]):
            pairs += [(f"{body}.{key}", unit) for body in self.bodies for key, unit in part]
        pairs += [(f"energy.{key}", unit) for key, unit in ENERGIES.items()]
        for joint, angular in zip(self.contacts, self.angular, strict=True):
            pairs += [(f"{joint}.{key}", unit) for key, unit in ACCOUNTS.items()]
            if angular:
                pairs[-PER_CONTACT + IMPULSE] = (f"{joint}.impulse", "N*m*s")
        return pairs + [(f"{joint}.state", "of its law") for joint in self.state_owners] + list(self.own)


def state_layout(system: System) -> StateLayout:
    """The layout of y for one mechanism."""
    contact = system.arrays["contact"]
    owners = [system.joints[n] for n in contact[:, at.OWNER]]
    held = [owners[n] for n in np.repeat(np.arange(len(contact)), contact[:, at.STATES])]
    for entry in system.arrays["dry"]:
        held += [system.joints[entry[at.DRY_JOINT]]] * int(entry[at.DRY_STATES])
    angular = tuple((system.arrays["lever"][:, at.ANGULAR] > 0.0).tolist())
    own = tuple((state.name, state.unit) for state in system.model.states.values())
    return StateLayout(system.bodies, tuple(owners), tuple(held), angular, own)
