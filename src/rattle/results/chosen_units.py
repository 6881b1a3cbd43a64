"""Units that a user asks for, `--units mm,deg,N`: each sets the unit of its dimension, where numbers are written."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextvars import ContextVar
from typing import NamedTuple

from rattle.errors import InputError, WrongType
from rattle.language.units import Dimension, dimension_of, unit_name, unit_of_quantity, zero_of


class Shown(NamedTuple):
    """A unit: factor from the SI unit, and its name."""

    factor: float
    unit: str


def shown_in(unit: str) -> Shown:
    """A unit by its name, such as "kN*m"."""
    return Shown(1.0 / unit_of_quantity(f"1 {unit}")[0], unit)


SI = "si"  # in place of units: everything in SI
ANGLES = ("rad", "mrad", "deg", "°", "rev", "turn")
ENERGIES = ("J", "mJ", "kJ", "MJ")  # of the same dimension as a moment


class Choice:
    """The units that a user asks for, by the SI units that they replace."""

    def __init__(self, units: Mapping[str, Shown], everything: bool = False) -> None:
        self.units = dict(units)
        self.everything = everything  # what has no unit here is in SI, too

    def unit_for(self, unit: str) -> Shown | None:
        """What replaces an SI unit; None where the user left it open.

        Lengths and angles are replaced within quotients and powers, too (mm/s, deg/s^2, deg/mm), other units within
        quotients of the unit that stands first (kN/mm); products such as N*m have to be asked for.
        """
        if unit in self.units:
            return self.units[unit]
        if self.everything:
            return Shown(1.0, unit)
        if "*" in unit or not unit:
            return None
        factor, replaced, changed = 1.0, [], False
        for n, part in enumerate(unit.split("/")):
            base, _, power = part.partition("^")
            other = self.units.get(base) if base != "s" else None
            if other is None:
                replaced.append(part)
                continue
            exponent = float(power or 1.0) * (-1.0 if n else 1.0)
            factor *= other.factor**exponent
            name = f"({other.unit})" if power and not other.unit.isalpha() else other.unit
            replaced.append(f"{name}^{power}" if power else name)
            changed = True
        return Shown(factor, "/".join(replaced)) if changed else None


def read_units(units: str | Iterable[str]) -> Choice:
    """A choice from "mm,deg,N" or its parts; "si": everything in SI.

    Raises InputError for an unknown unit, a plain number and two units of one kind.
    """
    parts = units.split(",") if isinstance(units, str) else list(units)
    if wrong := [part for part in parts if not isinstance(part, str)]:
        raise WrongType(f"units: expected names such as 'mm', got {wrong[0]!r:.60}")
    words = [word.strip() for word in parts]
    if [word.lower() for word in words] == [SI]:
        return Choice({}, everything=True)
    choice: dict[str, Shown] = {}
    for word in words:
        unit, shown = _read(word)
        if unit in choice:
            raise InputError(f"units: {choice[unit].unit} and {word} are units of the same kind; give one of them")
        choice[unit] = shown
    return Choice(choice)


def _read(word: str) -> tuple[str, Shown]:
    """The SI unit that a unit replaces, and how."""
    if word.lower() == SI:
        raise InputError("units: si stands alone, or units such as mm,deg,N without it")
    if not word:
        raise InputError("units: a name is missing; give units with commas between them, such as mm,deg,N")
    try:
        dimension = dimension_of(word)
    except InputError as error:
        raise InputError(f"units: {error}; give units with commas between them, such as mm,deg,N") from None
    if zero_of(word):
        raise InputError(f"units: {word} has a zero of its own; temperatures are written in K")
    unit = si_unit(word, dimension)
    if not unit:
        raise InputError(f"units: {word} is a plain number, not a unit; give units such as mm,deg,N")
    if unit_of_quantity(f"1 {word}")[1] != word:
        raise InputError(f"units: {word} is a quantity, not a unit; give units such as mm,deg,N")
    return unit, shown_in(word)


def si_unit(word: str, dimension: Dimension) -> str:
    """The SI unit that a unit of this dimension replaces; "" for plain numbers.

    Names tell angles, their rates and energies, whose dimensions are those of others.
    """
    if word in ENERGIES:
        return "J"
    if word == "rpm":
        return "rad/s"
    if word in ("Hz", "kHz"):
        return "Hz"
    first, _, rest = word.partition("/")
    if first not in ANGLES:
        return unit_name(dimension)
    return unit_name(dimension).replace("1/", "rad/", 1) if rest else "rad"


_CHOSEN: ContextVar[Choice | None] = ContextVar("units that a user asks for", default=None)


def choose(choice: Choice | None) -> Choice | None:
    """Set what is written from here on; returns what was set before."""
    before = _CHOSEN.get()
    _CHOSEN.set(choice)
    return before


def chosen(unit: str) -> Shown | None:
    """What replaces an SI unit where numbers are written for people; None where nobody asked for a unit."""
    choice = _CHOSEN.get()
    return choice.unit_for(unit) if choice is not None else None


def any_chosen() -> bool:
    """True where the user asks for units."""
    return _CHOSEN.get() is not None


def column_unit(unit: str, units: str | Iterable[str] | None = None) -> Shown:
    """What replaces an SI unit in a column of a file: SI unless asked otherwise, here or by `--units`."""
    choice = _CHOSEN.get() if units is None else read_units(units)
    return (choice.unit_for(unit) if choice is not None else None) or Shown(1.0, unit)
