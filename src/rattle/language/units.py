"""Units: "5 mm" is the number 0.005 with the dimension of a length.

A quantity is `<number> <unit>`.  A unit is a product of the names below with `*`, `·` or a space, `/`,
powers with `^` or `**`, and parentheses: "N*m", "kg*m^2", "1/s", "N/(m/s)".  It is read from left to
right, so that "N/m*s" is (N/m)*s.  Angles have no dimension (1 deg = pi/180, 1 rev = 2 pi), and a Hz is
1/s: write "rpm" or "rev/s" for a speed of rotation.  "60 degC" is the temperature 333.15 K; within a product or
quotient a degC is a kelvin, as in "460 J/(kg*degC)".

Source: BIPM, The International System of Units, 9th ed. (2019); NIST SP 811 for inch, foot, pound, psi.
"""

from __future__ import annotations

import functools
import math
import re
from typing import NamedTuple

from rattle.errors import InputError, suggest

MAX_LENGTH = 100  # characters of a quantity; a longer text is not read as one
MAX_POWER = 12.0
CELSIUS = "degC"  # the one unit whose zero is not that of the SI unit, where it stands alone
FREEZING = 273.15  # 0 degC [K], by the definition of the degree Celsius
ZERO_DIGITS = 9  # of a temperature [K] behind the point: beyond is rounding of binary numbers


class QuantityError(InputError):
    """A text that looks like a quantity, but whose unit is unknown or whose number is not finite."""


class Dimension(NamedTuple):
    """Exponents [-] of metre, kilogram, second and kelvin.  Angles are plain numbers: all are 0."""

    m: float = 0.0
    kg: float = 0.0
    s: float = 0.0
    kelvin: float = 0.0

    def times(self, other: Dimension) -> Dimension:
        """Dimension of a product."""
        return Dimension(*(_simple(x + y) for x, y in zip(self, other, strict=True)))

    def over(self, other: Dimension) -> Dimension:
        """Dimension of a quotient."""
        return Dimension(*(_simple(x - y) for x, y in zip(self, other, strict=True)))

    def power(self, exponent: float) -> Dimension:
        """Dimension of a power; the exponent is a plain number, 1/2 for a square root."""
        return Dimension(*(_simple(x * exponent) for x in self))


def _simple(exponent: float) -> float:
    """The exponent rounded to the nearby fraction n/5040, so that the cube of a cube root is exact."""
    if abs(exponent) > 1e6:
        return exponent
    parts = round(exponent * 5040)  # 5040 is a multiple of 1 to 10
    return parts / 5040 if abs(parts - exponent * 5040) < 1e-6 else exponent


DIMENSIONLESS = Dimension()
LENGTH = Dimension(m=1)
MASS = Dimension(kg=1)
TIME = Dimension(s=1)
FORCE = Dimension(1, 1, -2)
MOMENT = Dimension(2, 1, -2)
PRESSURE = Dimension(-1, 1, -2)
POWER = Dimension(2, 1, -3)
DYNAMIC_VISCOSITY = Dimension(-1, 1, -1)
KINEMATIC_VISCOSITY = Dimension(2, 0, -1)
RATE = Dimension(s=-1)
TEMPERATURE = Dimension(kelvin=1)

UNITS: dict[str, tuple[float, Dimension]] = {
    "m": (1.0, LENGTH),
    "mm": (1e-3, LENGTH),
    "cm": (1e-2, LENGTH),
    "km": (1e3, LENGTH),
    "um": (1e-6, LENGTH),
    "µm": (1e-6, LENGTH),
    "nm": (1e-9, LENGTH),
    "in": (0.0254, LENGTH),
    "ft": (0.3048, LENGTH),
    "kg": (1.0, MASS),
    "g": (1e-3, MASS),
    "mg": (1e-6, MASS),
    "t": (1e3, MASS),
    "lb": (0.45359237, MASS),
    "s": (1.0, TIME),
    "ms": (1e-3, TIME),
    "us": (1e-6, TIME),
    "µs": (1e-6, TIME),
    "min": (60.0, TIME),
    "h": (3600.0, TIME),
    "N": (1.0, FORCE),
    "mN": (1e-3, FORCE),
    "kN": (1e3, FORCE),
    "MN": (1e6, FORCE),
    "lbf": (4.4482216152605, FORCE),
    "Nm": (1.0, MOMENT),
    "Nmm": (1e-3, MOMENT),
    "kNm": (1e3, MOMENT),
    "Pa": (1.0, PRESSURE),
    "mPa": (1e-3, PRESSURE),
    "kPa": (1e3, PRESSURE),
    "MPa": (1e6, PRESSURE),
    "GPa": (1e9, PRESSURE),
    "bar": (1e5, PRESSURE),
    "psi": (4.4482216152605 / 0.0254**2, PRESSURE),
    "J": (1.0, MOMENT),
    "mJ": (1e-3, MOMENT),
    "kJ": (1e3, MOMENT),
    "MJ": (1e6, MOMENT),
    "W": (1.0, POWER),
    "mW": (1e-3, POWER),
    "kW": (1e3, POWER),
    "MW": (1e6, POWER),
    "P": (0.1, DYNAMIC_VISCOSITY),
    "cP": (1e-3, DYNAMIC_VISCOSITY),
    "St": (1e-4, KINEMATIC_VISCOSITY),
    "cSt": (1e-6, KINEMATIC_VISCOSITY),
    "K": (1.0, TEMPERATURE),
    CELSIUS: (1.0, TEMPERATURE),
    "rad": (1.0, DIMENSIONLESS),
    "mrad": (1e-3, DIMENSIONLESS),
    "deg": (math.pi / 180.0, DIMENSIONLESS),
    "°": (math.pi / 180.0, DIMENSIONLESS),
    "rev": (2.0 * math.pi, DIMENSIONLESS),
    "turn": (2.0 * math.pi, DIMENSIONLESS),
    "rpm": (2.0 * math.pi / 60.0, RATE),
    "Hz": (1.0, RATE),
    "kHz": (1e3, RATE),
}

# dimensions of mechanics: SI unit, words for messages
_NAMES: dict[Dimension, tuple[str, str]] = {
    DIMENSIONLESS: ("", "a plain number or angle"),
    LENGTH: ("m", "a length"),
    MASS: ("kg", "a mass"),
    TIME: ("s", "a time"),
    FORCE: ("N", "a force"),
    MOMENT: ("N*m", "a moment or energy"),
    PRESSURE: ("Pa", "a pressure"),
    POWER: ("W", "a power"),
    RATE: ("1/s", "an angular velocity or frequency"),
    Dimension(s=-2): ("1/s^2", "an angular acceleration"),
    Dimension(1, 0, -1): ("m/s", "a velocity"),
    Dimension(1, 0, -2): ("m/s^2", "an acceleration"),
    Dimension(m=2): ("m^2", "an area"),
    Dimension(m=3): ("m^3", "a volume"),
    Dimension(2, 1, 0): ("kg*m^2", "a moment of inertia"),
    Dimension(-3, 1, 0): ("kg/m^3", "a density"),
    Dimension(1, 1, -1): ("N*s", "an impulse"),
    DYNAMIC_VISCOSITY: ("Pa*s", "a dynamic viscosity"),
    KINEMATIC_VISCOSITY: ("m^2/s", "a kinematic viscosity"),
    TEMPERATURE: ("K", "a temperature"),
    Dimension(2, 0, -2, -1): ("J/(kg*K)", "a specific heat"),
    Dimension(2, 1, -3, -1): ("W/K", "a thermal conductance"),
    Dimension(1, 1, -3, -1): ("W/(m*K)", "a thermal conductivity"),
    Dimension(kelvin=-1): ("1/K", "a thermal expansion"),
    Dimension(-1, 1, 0): ("kg/m", "a mass per length"),
    Dimension(3, 0, -1): ("m^3/s", "a volume flow"),
    Dimension(0, 1, -2): ("N/m", "a stiffness"),
    Dimension(-0.5, 1, -2): ("N/m^1.5", "a contact stiffness"),
    Dimension(0, 1, -1): ("N*s/m", "a damping"),
    Dimension(2, 1, -1): ("N*m*s", "a torsional damping"),
}

_NUMBER = r"[+-]?+(?:[0-9]++(?:\.[0-9]*+)?+|\.[0-9]++)(?:[eE][+-]?[0-9]++)?+"
# no possessive repeats of groups in the unit: Python 3.11.0 to 3.11.4 match them wrongly; each character can be matched
# in one way only, so there is no slow backtracking
_UNIT = r"(?:[^\W\d_]|°|\(|1\s*+/)(?:\w|[°*·/()\s.]|\^\s*+\(?+[+-]?+|(?<=\*\*)\s*+\(?+[+-])*"
_QUANTITY = re.compile(rf"\s*+({_NUMBER}|[+-]?+(?i:nan|inf|infinity)\b)\s*+({_UNIT})?")
_TOKEN = re.compile(r"\s*+(\*\*|[*·/^()]|[+-]?[0-9]++(?:\.[0-9]++)?+|°|[^\W\d]\w*+|\S)")


@functools.lru_cache(maxsize=1024)
def parse_quantity(text: str) -> tuple[float, Dimension | None] | None:
    """Value in SI units and dimension of a text such as "5 mm"; None if it is not a quantity but an expression.

    A number without a unit ("5") has the dimension None and is taken in SI units, like a number written without quotes.
    A number of degC alone is a temperature: "60 degC" is 333.15 K.
    Raises QuantityError for an unknown unit, for a number that is not finite and for a temperature below 0 K.
    """
    match = _QUANTITY.fullmatch(text) if len(text) <= MAX_LENGTH else None
    if match is None:
        return None
    number, unit = float(match[1]), match[2]
    if unit is None:
        value, dimension = number, None
    elif is_longer(unit):
        return None
    else:
        try:
            scale, dimension = _read_unit(unit.strip())
        except QuantityError as error:
            word = re.match(r"\w+", unit)
            plain = str(error).startswith("unknown unit") and "did you mean" not in str(error)
            product = f"if {word[0]} is a parameter write {match[1]}*{word[0]}" if word else ""
            hint = f"; `rattle kinds units` lists them; {product}" if plain and word else ""
            raise QuantityError(f"{error}{hint}") from None
        value = from_zero(scaled(number, scale), zero_of(unit))
        if value < 0.0 and zero_of(unit):
            raise QuantityError(f"'{text.strip()}' is below the absolute zero of -{FREEZING:g} degC")
    if not math.isfinite(value):
        raise QuantityError(f"'{text.strip()}' is not a finite number")
    return value, dimension


def zero_of(unit: str) -> float:
    """Where the zero of a unit lies, in SI units: 273.15 K for "degC" alone, else 0."""
    return FREEZING if unit.strip() == CELSIUS else 0.0


def from_zero(value: float, zero: float) -> float:
    """A value counted from the zero of its unit, from 0 [SI]: rounded, so that -30 degC are 243.15 K."""
    return round(value + zero, ZERO_DIGITS) if zero and math.isfinite(value) else value


def as_difference(text: str) -> str:
    """A quantity as a difference: "5 degC" becomes "5 K", other texts stay as they are."""
    match = _QUANTITY.fullmatch(text) if len(text) <= MAX_LENGTH else None
    return f"{match[1]} K" if match is not None and zero_of(match[2] or "") else text


def scaled(number: float, scale: float) -> float:
    """A number of units of this size: 5 um as 5 / 1000000, which is rounded less than 5 * 1e-6."""
    parts = round(1.0 / scale) if 1e-15 < scale < 1.0 else 0
    return number / parts if abs(parts * scale - 1.0) < 1e-14 else number * scale


def is_longer(unit: str) -> bool:
    """True if a text begins with a unit and goes on as an expression: "mm * sin(t)"."""
    unit_there = unit_at(unit, 0)
    return unit_there is not None and _LONGER.match(unit, unit_there.end) is not None


class FoundUnit(NamedTuple):
    """A unit in a text: where it ends, size and zero in SI units, dimension, and its names beyond the first."""

    end: int
    scale: float
    dimension: Dimension
    others: frozenset[str]
    zero: float


_WORD = re.compile(r"(?:[^\W\d]\w*+|°)(?!\s*+\(|\.[^\W\d])")
_POWER = re.compile(r"\s*+(?:\^|\*\*)\s*+(?:\(\s*+[+-]?[0-9]++(?:\.[0-9]++)?+\s*+\)|[+-]?[0-9]++(?:\.[0-9]++)?+)")
_LONGER = re.compile(r"\s*+(?:(?:\*\*|[*/])\s*+[\w.(°]|(?:if|else|and|or)\b)")


def _skip(text: str, at: int) -> int:
    """Place of the first character from `at` on that is no space."""
    while at < len(text) and text[at].isspace():
        at += 1
    return at


def unit_at(text: str, start: int) -> FoundUnit | None:
    """The longest unit that begins at `start` of an expression, after a number; None if there is none.

    It goes on with `*`, `/`, `·` or a space as long as names of units follow, powers of them, or parentheses around
    them.  A name before a parenthesis is a function, and `t` after the first name is the time.
    """
    words: list[str] = []
    end = _factor_end(text, _skip(text, start), words, 0)
    if end is None:
        return None
    begin = _skip(text, start)
    while True:
        more: list[str] = []
        after = _further(text, end, more, 0)
        if after is None or len(text[begin:after]) > MAX_LENGTH:
            break
        words += more
        end = after
    try:
        scale, dimension = _read_unit(text[begin:end])
    except QuantityError:
        return None
    return FoundUnit(end, scale, dimension, frozenset(words[1:]), zero_of(text[begin:end]))


def _further(text: str, end: int, words: list[str], depth: int) -> int | None:
    """End of one more factor of a unit after `end`, with its operator; None if there is none."""
    after = _skip(text, end)
    if after < len(text) and text[after] in "*·/" and not text.startswith("**", after):
        after = _skip(text, after + 1)
    elif after == end:
        return None
    following = _factor_end(text, after, words, depth)
    return None if following is None or "t" in words else following


def _factor_end(text: str, start: int, words: list[str], depth: int) -> int | None:
    """End of the factor of a unit that begins at `start`: a name or a parenthesis, with a power; its names in words."""
    end: int | None = None
    if text.startswith("(", start) and depth < 5:
        inside: list[str] = []
        end = _factor_end(text, _skip(text, start + 1), inside, depth + 1)
        while end is not None and not text.startswith(")", _skip(text, end)):
            end = _further(text, end, inside, depth + 1)
        if end is None or "t" in inside:
            return None
        words += inside
        end = _skip(text, end) + 1
    elif (word := _WORD.match(text, start)) and word[0].replace("\u03bc", "µ") in UNITS:
        words.append(word[0])
        end = word.end()
    if end is not None and (power := _POWER.match(text, end)):
        end = power.end()
    return end


def unit_of_quantity(text: str) -> tuple[float, str]:
    """Size in SI units and name of the unit of a text such as "5 mm"; 1 and "" if it has none or is no quantity.

    A temperature in degC counts in K, because a size alone does not tell where its zero lies.
    """
    match = _QUANTITY.fullmatch(text) if len(text) <= MAX_LENGTH else None
    unit = (match[2] or "").strip() if match else ""
    if zero_of(unit):
        unit = unit_name(TEMPERATURE)
    return (_read_unit(unit)[0], unit) if unit else (1.0, "")


def dimension_of(unit: str) -> Dimension:
    """Dimension of a unit, e.g. "N*s/m"; "" is a plain number.  Raises QuantityError for an unknown unit."""
    return _read_unit(unit.strip())[1]


def unit_name(dimension: Dimension) -> str:
    """The SI unit of a dimension as it is written: "kg", "N*m", "m/s^2"; "" for plain numbers and angles."""
    if dimension in _NAMES:
        return _NAMES[dimension][0]
    parts = list(zip(("kg", "m", "s", "K"), (dimension.kg, dimension.m, dimension.s, dimension.kelvin), strict=True))
    above = [name if x == 1 else f"{name}^{x:g}" for name, x in parts if x > 0]
    below = [name if x == -1 else f"{name}^{-x:g}" for name, x in parts if x < 0]
    under = f"({'*'.join(below)})" if len(below) > 1 else "".join(below)
    return "*".join(above or ["1"]) + (f"/{under}" if below else "")


def describe(dimension: Dimension) -> str:
    """A dimension in words, for messages: "a mass", "a length", "a quantity in kg/s^3"."""
    return _NAMES[dimension][1] if dimension in _NAMES else f"a quantity in {unit_name(dimension)}"


@functools.lru_cache(maxsize=256)
def _read_unit(text: str) -> tuple[float, Dimension]:
    """Scale to SI and dimension of a unit."""
    if not text:
        return 1.0, DIMENSIONLESS
    if len(text) > MAX_LENGTH:
        raise QuantityError(f"'{text[:20]}...' is too long for a unit")
    reader = _UnitReader(text)
    scale, dimension = reader.product()
    if reader.token:
        raise QuantityError(f"'{text}' is not a unit: unexpected '{reader.token}'")
    if not 0.0 < scale < math.inf:
        raise QuantityError(f"the unit '{text}' is out of range")
    return scale, dimension


class _UnitReader:
    """Recursive-descent parser of one unit; `token` is the next token, "" at the end."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.tokens = iter(_TOKEN.findall(text))
        self.token: str = next(self.tokens, "")

    def take(self) -> str:
        taken, self.token = self.token, next(self.tokens, "")
        return taken

    def product(self) -> tuple[float, Dimension]:
        scale, dimension = self.factor()
        while self.token and self.token != ")":
            operator = self.take() if self.token in "*·/" else "*"
            right, extra = self.factor()
            scale = scale / right if operator == "/" else scale * right
            dimension = dimension.over(extra) if operator == "/" else dimension.times(extra)
            if not 0.0 < scale < math.inf:
                raise QuantityError(f"the unit '{self.text}' is out of range")
        return scale, dimension

    def factor(self) -> tuple[float, Dimension]:
        scale, dimension = self.atom()
        if self.token in ("^", "**"):
            self.take()
            exponent = self.exponent()
            try:
                scale, dimension = scale**exponent, dimension.power(exponent)
            except OverflowError:
                scale = math.inf
            if not 0.0 < scale < math.inf:
                raise QuantityError(f"the unit '{self.text}' is out of range")
        return scale, dimension

    def exponent(self) -> float:
        opened = self.token == "("
        if opened:
            self.take()
        word = self.take()
        if not re.fullmatch(r"[+-]?[0-9]+(\.[0-9]+)?", word) or (opened and self.take() != ")"):
            raise QuantityError(f"'{self.text}' is not a unit: an exponent must be a number")
        if abs(float(word)) > MAX_POWER:
            raise QuantityError(f"'{self.text}' is not a unit: the exponent {word[:20]} is out of range")
        return float(word)

    def atom(self) -> tuple[float, Dimension]:
        word = self.take()
        if word == "(":
            inner = self.product()
            if self.take() != ")":
                raise QuantityError(f"'{self.text}' is not a unit: a ')' is missing")
            return inner
        if word == "1":
            return 1.0, DIMENSIONLESS
        name = word.replace("\u03bc", "µ")  # Greek mu and the micro sign look alike
        if name in UNITS:
            return UNITS[name]
        if not word or not (word[0].isalpha() or word[0] == "_"):
            place = f"unexpected '{word}'" if word else "it ends too early"
            raise QuantityError(f"'{self.text}' is not a unit: {place}")
        power = re.fullmatch(r"([^\W\d_]+)([2-9])", name)
        if power and power[1] in UNITS:
            raise QuantityError(f"unknown unit '{word}'; did you mean '{power[1]}^{power[2]}'?")
        same = [unit for unit in UNITS if unit.casefold() == name.casefold()]
        near = f"; did you mean {' or '.join(repr(unit) for unit in same)}?" if same else suggest(name, UNITS)
        raise QuantityError(f"unknown unit '{word}'{near}")
