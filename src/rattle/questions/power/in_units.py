"""Tables of energies and powers in the units that the user asks for."""

from __future__ import annotations

from typing import Any

from rattle.results.chosen_units import any_chosen, column_unit

ENERGIES = ("E_in", "E_out", "net", "recirculated", "supplied", "lost", "stored")
POWERS = ("peak", "mean", "power")


def in_units(frame: Any) -> tuple[Any, tuple[str, str]]:
    """A table in the units that the user asks for, else in J and W; the units of energy and power."""
    energy, power = column_unit("J"), column_unit("W")
    factors = dict.fromkeys(ENERGIES, energy.factor) | dict.fromkeys(POWERS, power.factor)
    changed = {name: frame[name] * factors[name] for name in frame.columns if name in factors}
    return frame.assign(**changed), (energy.unit, power.unit)


def with_units(frame: Any) -> Any:
    """The same for a file: where the user asks for units, they stand in the names of the columns."""
    if not any_chosen():
        return frame
    changed, (energy, power) = in_units(frame)
    units = dict.fromkeys(ENERGIES, energy) | dict.fromkeys(POWERS, power)
    return changed.rename(columns={name: f"{name} [{unit}]" for name, unit in units.items()})
