"""What happens in a run at one instant, and the largest size of a quantity over all of it."""

from __future__ import annotations

from typing import NamedTuple


class Event(NamedTuple):
    """One change of a contact, or a jump of a driver; what does not apply to its kind is zero.

    jolt: `joint` is the driver, `normal_speed` its speed after less that before [rad/s or m/s], `impulse` acts on its
    body B [N m s or N s], `energy_lost` is minus what the driver puts in.
    """

    t: float  # [s]
    joint: str
    kind: str  # contact | release | impact | stick | slip | jolt
    normal_speed: float = 0.0  # approach speed [m/s]
    duration: float = 0.0  # [s]
    peak_force: float = 0.0  # [N]
    impulse: float = 0.0  # [N s]
    energy_lost: float = 0.0  # [J]


class Peak(NamedTuple):
    """The largest size of one quantity over a whole run, from within its steps."""

    value: float  # in the unit of the quantity
    t: float  # [s]
    rms: float  # root mean square over the run
