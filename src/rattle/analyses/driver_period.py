"""How long a turn of the driver takes."""

from __future__ import annotations

import math

from rattle.equations.motion import drive
from rattle.equations.system import System

STEADY = 1e-9  # [-] relative change of the rate of a driver that turns steadily: rounding of its function
LOOKS = (0.0, 0.0137, 0.171, 1.93)  # [s] where the rate is looked at: no multiples of each other, as periods are
EARLY = 1e-12  # [of the end] by which a turn that is as long as the run may begin before its start: rounding


def driver_period(system: System) -> float | None:
    """Time of one turn [s] of the first driver that turns a joint at constant rate; None if there is none."""
    workspace = system.workspace()
    for name in system.model.drivers:
        if system.rows[system.first_row(name)].unit != "rad":
            continue
        slot = system.driver_slot(name)
        rates = []
        for t in LOOKS:
            drive(workspace, t)
            rates.append(float(workspace.values[slot + 1]))
        if rates[0] and max(rates) - min(rates) <= STEADY * abs(rates[0]):
            return 2.0 * math.pi / abs(rates[0])
    return None


def last_turn(system: System, end: float) -> float:
    """When the last turn of the driver before `end` begins [s]; 0 if no driver turns steadily or that long."""
    period = driver_period(system)
    return max(end - period, 0.0) if period is not None and end - period >= -EARLY * end else 0.0


def part_of_turn(system: System, end: float) -> str:
    """In words that a run that ends at `end` [s] is shorter than a turn of the driver; "" if it is not."""
    period = driver_period(system)
    if period is None or end - period >= -EARLY * end:
        return ""
    return f"a run of {end:.4g} s is shorter than a turn of the driver, {period:.4g} s: means are those of a part of it"
