"""Viscosity of mineral oils over temperature, by grade and viscosity index or by two points.

    log10 log10(nu + 0.7) = A - B log10 T      nu in mm^2/s, T in K      (ASTM D341)

A grade of ISO 3448 says nu at 40 degC; the viscosity index (ASTM D2270) then says nu at 100 degC.  The density falls
evenly with temperature.  All of it holds at the pressure of the air.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rattle.catalogue.tables import rows
from rattle.errors import InputError, WrongType, shown, suggest
from rattle.language.quantities import in_si
from rattle.language.units import FREEZING

COLDEST, HOTTEST = 243.15, 473.15  # -30 and 200 degC [K]: what a model may have, beyond them oils set or burn
LAW_ENDS = 503.15  # 230 degC [K], up to which the law may be asked: what looks for a temperature looks beyond it too
AT_40, AT_100 = 313.15, 373.15  # where oils are measured [K]
AT_15 = 288.15  # where their density is [K]
MM2 = 1e6  # mm^2/s in a m^2/s
SHIFT = 0.7  # of ASTM D341 [mm^2/s]; below UNCORRECTED the standard has more terms
UNCORRECTED = 2.0  # viscosity [mm^2/s] from which on this form of D341 holds, and from which on D2270 has constants
THINNEST = 1.0 - SHIFT  # viscosity [mm^2/s] at which the law ends: the logarithm of the logarithm
THICKEST = 1e5  # viscosity [mm^2/s] above which a number is one in another unit: 30 times the thickest grade
TYPICAL_VI = 95.0  # of mineral oils without additives [-]
LARGEST_VI = 400.0  # of the best synthetic oils, rounded up [-]
TYPICAL_DENSITY = 880.0  # of mineral oils at 15 degC [kg/m^3]
DENSITIES = (500.0, 2500.0)  # what a liquid lubricant may have at 15 degC [kg/m^3]: others are in another unit
EXPANSION = 0.00065  # share of the density at 15 degC lost per kelvin [1/K], typical of mineral oils
HALVINGS = 200  # of the bracket of a viscosity: more than the digits of a number
LONGEST = 40  # characters of a text that is quoted
BY_GRADE, BY_POINTS = ("vg", "vi"), ("nu40", "nu100")
KEYS = (*BY_GRADE, *BY_POINTS, "density")
EXAMPLE = 'expected "ISO VG 46", { vg = 46, vi = 95 } or { nu40 = "46 mm^2/s", nu100 = "6.8 mm^2/s" }'
_NAME = re.compile(r"(?:ISO)?[\s-]*VG[\s-]*([0-9]+)", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class Oil:
    """An oil: its viscosity and density over temperature, which is a text with a unit or a number in K."""

    title: str  # what oil it is
    vi: float  # viscosity index [-]; nan below 2 mm^2/s at 100 degC, where there is none
    nu40: float  # kinematic viscosity at 40 degC [m^2/s]
    nu100: float  # kinematic viscosity at 100 degC [m^2/s]
    density15: float  # density at 15 degC [kg/m^3]
    assumed: tuple[str, ...]  # what is typical rather than of this oil, in words

    def kinematic(self, T: str | float) -> float:
        """Kinematic viscosity [m^2/s] at a temperature.  Raises InputError outside -30 ... 230 degC."""
        a, b = self.law
        return float(10.0**10.0 ** (a - b * math.log10(temperature(T))) - SHIFT) / MM2

    @property
    def law(self) -> tuple[float, float]:
        """A and B of ASTM D341: log10 log10(nu + 0.7) = A - B log10 T, nu in mm^2/s, T in K."""
        high, low = _law(self.nu40 * MM2), _law(self.nu100 * MM2)
        b = (high - low) / math.log10(AT_100 / AT_40)
        return high + b * math.log10(AT_40), b

    def density(self, T: str | float) -> float:
        """Density [kg/m^3] at a temperature.  Raises InputError outside -30 ... 230 degC."""
        return self.density15 * (1.0 - EXPANSION * (temperature(T) - AT_15))

    def viscosity(self, T: str | float) -> float:
        """Dynamic viscosity [Pa s] at a temperature.  Raises InputError outside -30 ... 230 degC."""
        return self.kinematic(T) * self.density(T)


def grades() -> list[str]:
    """Names of all oils by grade: "ISO VG 46"."""
    return [f"ISO VG {float(row['grade']):g}" for row in rows("iso3448_grades")]


def oil(written: str | Mapping[str, Any]) -> Oil:
    """An oil by its name or its figures: `oil("ISO VG 46").viscosity("60 degC")` is 0.0174 Pa s.

    written: "ISO VG 46"; or a table of `vg` with `vi` (95 if it is not there), or of `nu40` and `nu100`, kinematic
    viscosities at 40 and 100 degC (texts with a unit, or numbers in m^2/s); each with `density` at 15 degC
    (880 kg/m^3 if it is not there).

    Raises InputError for unknown names, grades and keys, for figures that do not belong together and wrong units.
    """
    if isinstance(written, str):
        return _by_grade({"vg": _named(written)})
    if not isinstance(written, Mapping):
        raise WrongType(f"oil: {EXAMPLE}; got {written!r:.40}")
    for key in written:
        if key not in KEYS:
            raise InputError(f"oil: unknown key '{shown(str(key)[:LONGEST])}'{suggest(str(key), KEYS)}")
    grade, points = ([key for key in keys if key in written] for keys in (BY_GRADE, BY_POINTS))
    if grade and points:
        raise InputError(f"oil: {grade[0]} and {points[0]} are two ways to say one thing; {EXAMPLE}")
    if "vg" in grade:
        return _by_grade(written)
    if grade:
        raise InputError(f"oil: vi needs a grade vg beside it; {EXAMPLE}")
    if len(points) == 1:
        raise InputError(f"oil: {points[0]} alone is one point of two; the law needs nu40 and nu100")
    if not points:
        raise InputError(f"oil: a viscosity is missing; {EXAMPLE}")
    return _by_points(written)


def temperature(T: str | float, what: str = "temperature") -> float:
    """A temperature [K] within the range of oils, from a text with a unit or a number in K.

    Raises InputError outside -30 ... 230 degC and for other quantities; what: its name in messages.
    """
    if isinstance(T, bool):
        raise WrongType(f"{what}: expected a temperature, as in '60 degC'; got {T!r}")
    kelvin = in_si(T, what, "K", "'60 degC'")
    if COLDEST <= kelvin <= LAW_ENDS:
        return kelvin
    label = f"'{T}'" if isinstance(T, str) else f"{T!r:.40}"
    asked = ""
    if _is_bare(T) and COLDEST <= kelvin + FREEZING <= LAW_ENDS:
        asked = f"; a number is kelvin; write '{kelvin:.9g} degC'"
    ends = f"{COLDEST - FREEZING:g} ... {LAW_ENDS - FREEZING:g} degC"
    raise InputError(f"{what} {label} is {kelvin - FREEZING:.6g} degC, outside {ends} for which oils are known{asked}")


def _is_bare(T: str | float) -> bool:
    """True for a number without a unit."""
    return not isinstance(T, str) or not re.search(r"[A-Za-z°]", re.sub(r"[eE][-+]?[0-9]", "", T))


# ---------------------------------------------------------------- by grade
def _named(text: str) -> int:
    """The grade in a name such as "ISO VG 46".  Raises InputError."""
    match = _NAME.fullmatch(text.strip())
    if match is None:
        label = f"oil '{shown(text.strip()[:LONGEST])}'"
        if text.strip().upper().startswith("SAE"):
            raise InputError(
                f"{label}: a grade of SAE is a range of viscosities; give nu40 and nu100 of the data sheet"
            )
        raise InputError(f"{label} is not known; {EXAMPLE}")
    return int(match[1][:9])


def _by_grade(written: Mapping[str, Any]) -> Oil:
    """An oil of a grade and viscosity index."""
    grade, title = _grade(written["vg"])
    index = TYPICAL_VI
    assumed = [] if "vi" in written else [f"viscosity index {TYPICAL_VI:g}, typical of mineral oils"]
    if "vi" in written:
        index = _plain_number(written["vi"], "vi")
        if not 0.0 <= index <= LARGEST_VI:
            raise InputError(
                f"oil: vi = {index:g} is outside 0 ... {LARGEST_VI:g}, the viscosity indices that oils have"
            )
        title += f", VI {index:g}"
    density, hot = _density(written, assumed), _hot(grade, index)
    return Oil(title, index, grade / MM2, hot / MM2, density, (*assumed, *_uncorrected(hot)))


def _grade(written: object) -> tuple[float, str]:
    """A grade of ISO 3448 [mm^2/s], and its name.  Raises InputError for others, with the nearest one."""
    number = float(_named(written)) if isinstance(written, str) and not written.strip().isdecimal() else None
    number = _plain_number(written, "vg") if number is None else number
    grades = [float(row["grade"]) for row in rows("iso3448_grades")]
    if number not in grades:
        near = min(grades, key=lambda grade: abs(math.log(grade / number)) if number > 0.0 else grade)
        listed = " ".join(f"{grade:g}" for grade in grades)
        raise InputError(
            f"oil: ISO VG {number:g} is no grade of ISO 3448; did you mean ISO VG {near:g}? (grades: {listed})"
        )
    return number, f"ISO VG {number:g}"


def _hot(nu40: float, index: float) -> float:
    """Viscosity at 100 degC [mm^2/s] of an oil with this one at 40 degC and this viscosity index, by bisection."""
    if viscosity_index(nu40, UNCORRECTED) > index:
        raise InputError(
            f"oil: ISO VG {nu40:g} of viscosity index {index:g} is thinner than {UNCORRECTED:g} mm^2/s at 100 degC,"
            " where ASTM D2270 has no index; give nu40 and nu100"
        )
    low, high = UNCORRECTED, nu40
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if viscosity_index(nu40, middle) < index else (low, middle)
    return 0.5 * (low + high)


def viscosity_index(nu40: float, nu100: float) -> float:
    """Viscosity index [-] by ASTM D2270 of kinematic viscosities at 40 and 100 degC [mm^2/s].

    nan below 2 mm^2/s at 100 degC, where the standard has no constants.
    """
    if nu100 < UNCORRECTED:
        return math.nan
    row = [row for row in rows("d2270_constants") if float(row["least"]) <= nu100][-1]
    a, b, c, d, e, f = (float(row[key]) for key in "abcdef")
    of_0 = (a * nu100 + b) * nu100 + c  # L: viscosity at 40 degC of an oil of index 0 with this nu100
    of_100 = (d * nu100 + e) * nu100 + f  # H: of an oil of index 100
    if nu40 >= of_100:
        return (of_0 - nu40) / (of_0 - of_100) * 100.0
    power = math.log10(of_100 / nu40) / math.log10(nu100)
    return 100.0 + float(10.0**power - 1.0) / 0.00715


# ---------------------------------------------------------------- by points
def _by_points(written: Mapping[str, Any]) -> Oil:
    """An oil of two viscosities."""
    nu40, nu100 = (_viscosity(written, key) for key in BY_POINTS)
    if nu100 >= nu40:
        raise InputError(
            f"oil: nu100 = {nu100:g} mm^2/s is not less than nu40 = {nu40:g} mm^2/s: oils are thinner when hot;"
            " are they swapped?"
        )
    assumed: list[str] = []
    density = _density(written, assumed)
    title = f"oil of {nu40:.6g} mm^2/s at 40 degC, {nu100:.6g} at 100 degC"
    return Oil(title, viscosity_index(nu40, nu100), nu40 / MM2, nu100 / MM2, density, (*assumed, *_uncorrected(nu100)))


def _viscosity(written: Mapping[str, Any], key: str) -> float:
    """A kinematic viscosity of the table [mm^2/s].  Raises InputError."""
    number = _quantity(written[key], f"oil: {key}", "m^2/s", "'46 mm^2/s'") * MM2
    if not THINNEST < number <= THICKEST:
        bare = "; a number is in m^2/s: write '46 mm^2/s'" if not isinstance(written[key], str) else ""
        raise InputError(
            f"oil: {key} = {number:g} mm^2/s is outside {THINNEST:g} ... {THICKEST:g} mm^2/s, as oils have it{bare}"
        )
    return number


def _density(written: Mapping[str, Any], assumed: list[str]) -> float:
    """The density at 15 degC [kg/m^3]; what is typical is noted in `assumed`."""
    if "density" not in written:
        assumed.append(f"density {TYPICAL_DENSITY:g} kg/m^3 at 15 degC, typical of mineral oils")
        return TYPICAL_DENSITY
    density = _quantity(written["density"], "oil: density", "kg/m^3", "'870 kg/m^3'")
    if not DENSITIES[0] <= density <= DENSITIES[1]:
        raise InputError(
            f"oil: density {density:g} kg/m^3 is outside {DENSITIES[0]:g} ... {DENSITIES[1]:g} kg/m^3, those of liquids"
        )
    return density


def _uncorrected(nu100: float) -> tuple[str, ...]:
    """What is said of an oil so thin that the law has more terms."""
    if nu100 >= UNCORRECTED:
        return ()
    return (f"ASTM D341 without its corrections below {UNCORRECTED:g} mm^2/s",)


def _quantity(value: object, what: str, unit: str, example: str) -> float:
    """A number [SI] or text with a unit.  Raises InputError for what is no finite one."""
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise WrongType(f"{what}: expected a quantity in {unit}, as in {example}; got {value!r:.40}")
    number = in_si(value, what, unit, example)
    if not math.isfinite(number):
        raise InputError(f"{what}: {number} is not a finite number")
    return number


def _plain_number(value: object, key: str) -> float:
    """A plain number, which may be written as a text."""
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise WrongType(f"oil: {key} is a plain number, as in {{ vg = 46, vi = 95 }}; got {value!r:.40}")
    return _quantity(value, f"oil: {key}", "", "{ vg = 46, vi = 95 }")


def _law(nu: float) -> float:
    """log log of ASTM D341 [-] of a kinematic viscosity [mm^2/s]."""
    return math.log10(math.log10(nu + SHIFT))
