"""Events of a run, and the largest magnitude of a quantity over the whole run."""

from __future__ import annotations

import base64
from typing import NamedTuple

import numpy as np

from rattle.errors import InputError


class Event(NamedTuple):
    """One change of a contact, or a jump of a driver; fields that do not apply to its kind are zero.

    jolt: `joint` is the driver, `normal_speed` the jump of its speed (after minus before) [rad/s or m/s], `impulse`
    acts on its body B [N m s or N s], `energy_lost` is minus the energy that the driver supplies [J].
    """

    t: float  # [s]
    joint: str
    kind: str  # contact | release | impact | stick | slip | jolt; of a clutch lock | free | slip
    normal_speed: float = 0.0  # approach speed [m/s]; of a stop of an angle [rad/s]
    duration: float = 0.0  # [s]
    peak_force: float = 0.0  # [N]; of a stop of an angle a moment [N m]
    impulse: float = 0.0  # [N s]; of a stop of an angle [N m s]
    energy_lost: float = 0.0  # [J]
    contact: str = ""  # which of the contacts of a joint: the corner, if it has several


class Peak(NamedTuple):
    """The largest magnitude of one quantity over a whole run, found within its steps."""

    value: float  # in the unit of the quantity
    t: float  # [s]
    rms: float  # root mean square over the run, in the same unit


class Breaks(NamedTuple):
    """Values of the stored curves just before and just after every instant at which they jump or bend, in turn.

    An instant that stands alone lies in a compliant contact, which may be shorter than the time between two outputs.
    """

    t: np.ndarray  # (k,) [s], in order, that of an event twice
    data: np.ndarray  # (k, columns) SI

    @property
    def text(self) -> str:
        """All numbers as text, for the record of a file."""
        return base64.b64encode(np.column_stack([self.t, self.data]).astype("<f8").tobytes()).decode("ascii")

    @classmethod
    def from_text(cls, text: str, columns: int) -> Breaks:
        """Those of a file with so many curves.  Raises ValueError (binascii.Error too) for another text."""
        rows = np.frombuffer(base64.b64decode(text, validate=True), "<f8").astype(np.float64).reshape(-1, 1 + columns)
        t = rows[:, 0]
        if not (np.diff(t) >= 0.0).all():
            raise InputError("instants of breaks must increase")
        return cls(t, rows[:, 1:])
