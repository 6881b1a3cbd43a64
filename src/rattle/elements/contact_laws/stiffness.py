"""Static (elastic) force of a contact, F(delta), given directly or computed from materials and geometry.

    power          F = K delta^n
    sphere         the same, K = 4/3 E* sqrt(R_A R_B/dR), n = 1.5
    pereira        the same, K and n fitted
    liu            F = (pi/2) E* L delta sqrt(delta/(2 (dR + delta)))
    johnson, radzimovsky, esdu-78035, dubowsky-freudenstein: line contact, given as delta(F)
                   delta = c F ln(D/F),  c = 1/(pi E* L);  the four differ only in D

E* = 1/(s_A + s_B), s = (1 - nu^2)/E: contact modulus [Pa]; R_A bush radius, R_B pin radius, dR = R_A - R_B
the clearance [m]; L length [m].  delta(F) of the last four has a maximum at F = D/e, far outside the range of the
formula; F(delta) is therefore continued along its tangent, of slope 1/c, from F = D/e^2 on, where the Hertz
half-width is already far larger than the pin radius.  So every F(delta) increases for all delta > 0.
Inversion: with w = ln(D/F), w - ln w = -ln(delta/(c D)), solved by Newton's method.

The kernel is  f(delta, p, k) -> F,  0 for delta <= 0;  p[k:] comes from `pack`.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence

from rattle.errors import InputError
from rattle.interfaces.fields import LawValues
from rattle.interfaces.laws import StiffnessLaw
from rattle.jit.choices import TINY, select
from rattle.jit.functions import KernelFunction, kernel
from rattle.language.materials import Given, contact_modulus
from rattle.language.recorded import as_number, sqrt
from rattle.registry import Field, kind

TURN = 2.0 * math.exp(-2.0)  # delta/(c D) at w = 2, where the tangent begins
FORCE_AT_TURN = math.exp(-2.0)  # F/D there
NEWTON = 4  # steps of Newton's method: rounding is left
LEAST_PENETRATION = 1e-9  # [m] from which on a penetration is looked for, by doubling
CLOSE_FIT = 0.1  # clearance over the pin radius above which contacts are not conforming: our limit
FITTED = 0.005, 10.0  # clearances to which the formula of Pereira and others was fitted [mm]
BUSH_RADIUS = Field("m", "radius of the bush; the pin radius is smaller by the clearance", least="positive")
LENGTH = Field("m", "length of the contact along the pin", least="positive")
BENDS_AT = 0.34954  # clearance at which it passes from one branch to the other [mm]


@kernel("stiffness")
def power(delta, p, k):
    """Force [N] of `Power`, `Sphere` and `Pereira`: p[k:] = K [N/m^n], n [-]."""
    if delta <= 0.0:
        return 0.0
    n = p[k + 1]
    return p[k] * (delta * math.sqrt(delta) if n == 1.5 else delta**n)


@kernel("stiffness")
def logarithmic(delta, p, k):
    """Force [N] of a `LineContact`: p[k:] = c [m/N], D [N]."""
    if delta <= 0.0:
        return 0.0
    c, d = p[k], p[k + 1]
    x = delta / (c * d)
    s = -math.log(max(min(x, TURN), TINY))
    w = s + math.log(s) * (1.0 + 1.0 / s)
    for _ in range(NEWTON):
        w -= (w - math.log(w) - s) * w / (w - 1.0)
    return select(x >= TURN, d * FORCE_AT_TURN + (delta - c * d * TURN) / c, delta / (c * w))


@kernel("stiffness")
def conforming(delta, p, k):
    """Force [N] of `Liu`: p[k:] = (pi/2) E* L [N/m], dR [m]."""
    if delta <= 0.0:
        return 0.0
    return p[k] * delta * math.sqrt(0.5 * delta / (p[k + 1] + delta))


def penetration(law: KernelFunction, p: Sequence[float], force: float, k: int = 0) -> float:
    """Penetration [m] at which the static force of a kernel with parameters p[k:] is `force` [N]."""
    if force <= 0.0:
        return 0.0
    high = LEAST_PENETRATION
    while law.python(high, p, k) < force:
        high *= 2.0
    low = 0.0
    while low < (middle := 0.5 * (low + high)) < high:
        if law.python(middle, p, k) < force:
            low = middle
        else:
            high = middle
    return high


def sphere_stiffness(
    bush_radius: float,
    pin_radius: float,
    material_a: Given,
    material_b: Given,
) -> tuple[float, float]:
    """Stiffness K [N/m^1.5] and exponent [-] of a sphere in a spherical socket, F = K delta^1.5; radii in m.

    K = 4/(3 (s_A + s_B)) sqrt(R_A R_B/(R_A - R_B)), s = (1 - nu^2)/E.  Raises InputError unless 0 < R_B < R_A.

    Source: Johnson, Contact Mechanics (1985), eq. 4.23; Goldsmith, Impact (1960).
    """
    if not 0.0 < pin_radius < bush_radius:
        raise InputError(f"a pin of radius {pin_radius:g} m has no clearance in a bush of radius {bush_radius:g} m")
    curvature = sqrt(bush_radius * pin_radius / (bush_radius - pin_radius))
    return 4.0 / 3.0 * contact_modulus(material_a, material_b) * curvature, 1.5


def _radii(values: LawValues) -> tuple[float, float, float]:
    """R_A, R_B, dR [m].  Raises InputError unless 0 < dR < R_A."""
    bush, play = as_number(values["bush_radius"]), as_number(values["clearance"])
    if not 0.0 < play < bush:
        raise InputError(f"stiffness from geometry needs 0 < clearance < bush_radius, not {play:g} m and {bush:g} m")
    return bush, bush - play, play


def _modulus(values: LawValues) -> float:
    return contact_modulus(_given(values, "bush_material"), _given(values, "pin_material"))


def _given(values: LawValues, key: str) -> Given:
    """The material of a field, by name or by its constants."""
    written = values[key]
    assert not isinstance(written, float), f"{key} is no number"
    return written


class PinInBush(StiffnessLaw):
    """A law computed from radii and materials."""

    bush_radius = BUSH_RADIUS
    bush_material = Field("", "a name, or { E, nu }", shape="material")
    pin_material = Field(
        "", "a name, or { E, nu }; default: that of the bush", lambda read: read["bush_material"], shape="material"
    )


class Cylinder(PinInBush):
    """A law for a pin in contact along its length."""

    length = LENGTH


class LineContact(Cylinder):
    """Pin and bush as long cylinders, delta = c F ln(D/F): p[k:] = c [m/N], D [N]."""

    @staticmethod
    @abstractmethod
    def scale(modulus: float, length: float, bush: float, pin: float, play: float) -> float:
        """The force D [N], from the contact modulus [Pa], the length of contact, both radii and the clearance [m]."""

    @classmethod
    def pack(cls, values: LawValues) -> tuple[float, ...]:
        modulus, length = _modulus(values), as_number(values["length"])
        return 1.0 / (math.pi * modulus * length), cls.scale(modulus, length, *_radii(values))

    @classmethod
    def limit(cls, values: LawValues) -> float:
        """Force [N] at which the Hertz half-width sqrt(4 F R_A R_B/(pi E* L dR)) is R_B/2, at most D/e^2."""
        bush, pin, play = _radii(values)
        narrow = math.pi * _modulus(values) * as_number(values["length"]) * play * pin / (16.0 * bush)
        return min(narrow, cls.pack(values)[1] * FORCE_AT_TURN)


@kind("stiffness", "power", power)
class Power(StiffnessLaw):
    """F = K delta^n with given K and n.

    Source: definition.
    """

    stiffness = Field("", "K [N/m^n]", least="positive")
    exponent = Field("", "exponent n", default=1.5, least="positive")

    @classmethod
    def pack(cls, values: LawValues) -> tuple[float, ...]:
        return as_number(values["stiffness"]), as_number(values["exponent"])


@kind("stiffness", "sphere", power)
class Sphere(PinInBush):
    """Sphere in a spherical socket, F = K delta^1.5, K = 4/3 E* sqrt(R_A R_B/dR).

    Range: contact radius (3 F R_A R_B/(4 E* dR))^(1/3) below half the pin radius (our limit; the theory: small).
    Source: Johnson, Contact Mechanics (1985), eq. 4.23; Lankarani, Nikravesh (1990), J. Mech. Des. 112, 369-376.
    """

    @classmethod
    def pack(cls, values: LawValues) -> tuple[float, ...]:
        bush, pin, _ = _radii(values)
        return sphere_stiffness(bush, pin, _given(values, "bush_material"), _given(values, "pin_material"))

    @classmethod
    def limit(cls, values: LawValues) -> float:
        """Force [N] at which the contact radius is half the pin radius."""
        bush, pin, play = _radii(values)
        return _modulus(values) * pin**2 * play / (6.0 * bush)


@kind("stiffness", "johnson", logarithmic)
class Johnson(LineContact):
    """delta = F/(pi E* L) [ln(4 pi E* L dR/F) - 1].

    Range: Hertz half-width below half the pin radius (our limit; the theory: small), L much larger than it.
    Source: Johnson, Contact Mechanics (1985), section 5.6; Pereira et al. (2011), Nonlinear Dyn. 63, 681-697.
    """

    @staticmethod
    def scale(modulus: float, length: float, bush: float, pin: float, play: float) -> float:
        return 4.0 * math.pi * modulus * length * play * math.exp(-1.0)


@kind("stiffness", "radzimovsky", logarithmic)
class Radzimovsky(LineContact):
    """delta = F/(pi E* L) [2/3 + ln(4 R_A/b) + ln(4 R_B/b)], b = 1.6 sqrt(F R_A R_B/(L E* dR)).

    Range: b below half the pin radius (our limit; the theory: small), L much larger than b.
    Source: Radzimovsky (1953), Univ. of Illinois Eng. Exp. Station Bull. 408; Pereira et al. (2011), Nonlinear Dyn. 63.
    """

    @staticmethod
    def scale(modulus: float, length: float, bush: float, pin: float, play: float) -> float:
        return 6.25 * modulus * length * play * math.exp(2.0 / 3.0)  # 16 R_A R_B/b^2 = 6.25 E* L dR/F


@kind("stiffness", "esdu-78035", logarithmic)
class Esdu78035(LineContact):
    """delta = F/(pi E* L) [ln(4 pi E* L dR/F) + 1].

    Range: Hertz half-width below half the pin radius (our limit; the theory: small), L much larger than it.
    Source: ESDU 78035, Contact phenomena I (1978), as in Pereira et al. (2011), Nonlinear Dyn. 63, 681-697.
    """

    @staticmethod
    def scale(modulus: float, length: float, bush: float, pin: float, play: float) -> float:
        return 4.0 * math.pi * modulus * length * play * math.exp(1.0)


@kind("stiffness", "dubowsky-freudenstein", logarithmic)
class DubowskyFreudenstein(LineContact):
    """delta = F/(pi E* L) [ln(pi E* L^3 dR/(F R_A R_B)) + 1].

    The exponent of L is 3: with any other the argument of the logarithm would not be dimensionless.
    Range: Hertz half-width below half the pin radius (our limit; the theory: small), L of the order of the radii.
    Source: Dubowsky, Freudenstein (1971), J. Eng. Ind. 93, 305-316; Pereira et al. (2011), Nonlinear Dyn. 63.
    """

    @staticmethod
    def scale(modulus: float, length: float, bush: float, pin: float, play: float) -> float:
        return math.pi * modulus * length**3 * play * math.exp(1.0) / (bush * pin)


@kind("stiffness", "liu", conforming)
class Liu(Cylinder):
    """F = (pi/2) E* L delta sqrt(delta/(2 (dR + delta))).

    Range: conforming contacts, clearance small compared with the radii (our limit: a tenth of the pin radius).
    Source: Liu, Zhang, Yang (2007), Mech. Mach. Theory 42, 183-197.
    """

    @classmethod
    def pack(cls, values: LawValues) -> tuple[float, ...]:
        return 0.5 * math.pi * _modulus(values) * as_number(values["length"]), _radii(values)[2]

    @classmethod
    def notes(cls, values: LawValues, force: float = 0.0) -> list[str]:
        """Remark for the user on a clearance that is not small compared with the pin radius."""
        _, pin, play = _radii(values)
        if play <= CLOSE_FIT * pin:
            return []
        return [f"the clearance is {play / pin:.0%} of the pin radius; this formula is made for at most 10 %"]


@kind("stiffness", "pereira", power)
class Pereira(Cylinder):
    """F = (0.965 dR + 0.0965) L E*/dR delta^n, n = Y dR^(-0.005), in mm, N and MPa, fitted to johnson.

    Y = 1.51 [ln(1000 dR)]^(-0.151) for 0.005 <= dR < 0.34954 mm, 0.0151 dR + 1.151 for 0.34954 <= dR <= 10 mm.
    Outside this range Y keeps its value at the nearer end.

    Range: 0.005 mm <= clearance <= 10 mm.
    Source: Pereira, Ramalho, Ambrosio (2011), Nonlinear Dyn. 63, 681-697.
    """

    @classmethod
    def pack(cls, values: LawValues) -> tuple[float, ...]:
        play = 1e3 * _radii(values)[2]
        inside = min(max(play, FITTED[0]), FITTED[1])
        if inside < BENDS_AT:
            y = 1.51 * math.log(1000.0 * inside) ** -0.151
        else:
            y = 0.0151 * inside + 1.151
        n = y * play**-0.005
        width = 1e3 * as_number(values["length"]) * 1e-6 * _modulus(values)  # L E* in N/mm
        return (0.965 * play + 0.0965) * width / play * 1e3**n, n

    @classmethod
    def notes(cls, values: LawValues, force: float = 0.0) -> list[str]:
        """Remark for the user on a clearance outside the range of the fit."""
        play = 1e3 * _radii(values)[2]
        if FITTED[0] <= play <= FITTED[1]:
            return []
        return [f"a clearance of {play:g} mm is outside 0.005 ... 10 mm, the range to which this formula was fitted"]
