"""Fields: what the user writes for a kind, or in a table of the model file; and reading their values by shape."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rattle.language.local_function import LocalFunction

REQUIRED: Any = object()
LawValues = Mapping[str, float | str | Mapping[str, float]]  # values of a law's fields [SI]; materials are no numbers
Fields = Mapping[str, float]  # values of a joint's fields [SI]; for those of other shapes see `pair` and `function`


def absent(fields: Fields) -> float:
    """Default of a number that there need not be; unlike a plain 0 it is told to nobody."""
    return 0.0


@dataclass(frozen=True)
class LocalName:
    """A name that the expression of one field may use besides those of the whole model.

    unit: its SI unit.  formula: an expression whose names begin with `A.` or `B.`, the bodies of the two ends; those of
    the ground are zero.
    """

    name: str
    unit: str
    meaning: str
    formula: str


@dataclass(frozen=True)
class Field:
    """One key that the user writes for a kind, or in a table of the model file.

    unit: SI unit of the number, "" for a plain number or angle.  meaning: a few words for help and documentation.
    turning: unit of the last of three numbers, an angle or of an angle, where the shape is "triple".
    shape: number | pair | triple | point ("body.point") | body | joint | connect | choice | flag (true, false) |
    material; in tables also those of `rattle.description.read_fields.SHAPES`.
    live: the value may be an expression in t, state and signals, evaluated at every instant.
    least: "positive" or "not negative" if the number is limited.
    default: a number in SI units, or a function of the fields read so far; REQUIRED if the key must be given, None if
    nothing stands for it.  missing: what is told where a key that must be given is not, if not its meaning.
    like: what is expected, in words, where the shape does not say it.  fewest: entries of a list; longest: characters.
    choices: the words allowed for shape "choice"; flags: those that false and true stand for, if these are allowed.
    local: names that only its expression may use, if it is live.
    turns: of shape "connect": the two bodies must be able to turn against each other.
    function_of: name of a variable [`of_unit`]: the value is an expression of it and of parameters, which the kernel
    evaluates with its derivatives, see `rattle.language.local_function`.
    """

    unit: str
    meaning: str
    default: Any = REQUIRED
    shape: str = "number"
    least: str = ""
    live: bool = False
    choices: tuple[str, ...] = ()
    flags: tuple[str, str] | tuple[()] = ()
    local: tuple[LocalName, ...] = ()
    turns: bool = False
    function_of: str = ""
    of_unit: str = "rad"
    turning: str = ""
    missing: str = ""
    like: str = ""
    fewest: int = 0
    longest: int = 0

    @property
    def may_use(self) -> str:
        """What an expression of it may use besides parameters, in words; "" if it is not live."""
        own = "".join(f"{variable.name} ({variable.meaning} [{variable.unit}]), " for variable in self.local)
        return f"{own}t, state and signals" if self.live else ""


def fields_of(leaf: type) -> dict[str, Field]:
    """The fields of a leaf, inherited ones first; a field declared again keeps its position."""
    declared: dict[str, Any] = {}
    for ancestor in reversed(leaf.__mro__):
        declared.update(vars(ancestor))
    return {key: value for key, value in declared.items() if isinstance(value, Field)}


# ---------------------------------------------------------------- values of fields that are no single numbers
def pair(fields: Fields, key: str) -> tuple[float, float]:
    """The value of a field of shape "pair" [SI]."""
    value: Any = fields[key]  # the reader has seen to its shape
    first, second = value
    return first, second


def function(fields: Fields, key: str) -> LocalFunction:
    """The value of a field that is a function of one variable."""
    value: Any = fields[key]
    of_one: LocalFunction = value
    return of_one
