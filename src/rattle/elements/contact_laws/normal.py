"""Normal force laws: static force of a contact with damping.

    F = F_static(delta) (1 + a ddelta/v0)      F clipped at zero: a contact never pulls     [N]

delta > 0 penetration [m], ddelta its rate [m/s], v0 > 0 the approach speed at the start of this contact [m/s],
F_static from the family "stiffness" [N].  The hysteretic laws share one kernel and differ only in the factor
a(e), where e is the given restitution.  A free impact *returns* the restitution x, the root of
ln((1+a)/(1-xa)) = a(1+x) (see `restitution`), whatever F_static and the mass; the law `exact` makes x = e.

In every law a v0 below `least_speed` is replaced by it, so that F stays finite when a contact starts from rest.
Impacts slower than that return more than faster ones.  `least_speed` also limits how stiff the equations become:
under a lasting force N the damping is N a/least_speed [N*s/m].

The kernel is  f(F_static, delta, ddelta, v0, p, k) -> F,  0 for delta <= 0;  p[k:] comes from `pack`.
"""

from __future__ import annotations

import difflib
import math
from abc import abstractmethod

from rattle.elements.contact_laws.restitution import LEAST_RESTITUTION, checked, factor_returning, restitution_returned
from rattle.errors import InputError
from rattle.interfaces.fields import LawValues
from rattle.interfaces.laws import NormalLaw
from rattle.jit.functions import kernel
from rattle.language.recorded import as_number, sqrt
from rattle.registry import Field, kind, kinds

NEEDS_LOSS = "needs restitution, 0 to 1, or a damping in its place"
NOTICED = 0.02  # difference between the given and the returned restitution that the user is told of


@kernel("normal")
def hysteretic(static, delta, ddelta, v0, p, k):
    """Normal force [N] of all laws with a factor a: p[k:] = a [-], least_speed [m/s]."""
    a, least_speed = p[k], p[k + 1]
    if delta <= 0.0:
        return 0.0
    return max(0.0, static * (1.0 + a * ddelta / max(v0, least_speed)))


@kernel("normal")
def viscous(static, delta, ddelta, v0, p, k):
    """Normal force [N] of `KelvinVoigt`: p[k] = 2 zeta sqrt(m) [kg^0.5]."""
    if delta <= 0.0 or static <= 0.0:
        return 0.0
    return max(0.0, static + p[k] * math.sqrt(static / delta) * ddelta)


def damping_factor(law: str, restitution: float) -> float:
    """Factor a [-] of F = F_static (1 + a ddelta/v0) for a law and a given restitution [-].

    For kelvin-voigt it is the damping ratio zeta [-].
    Raises InputError for an unknown law and for a restitution outside [0, 1].
    """
    return float(_damped(law).factor(checked(restitution)))


def returned(law: str, restitution: float) -> float:
    """Restitution [-] that a free impact returns under a law with a given restitution [-].

    Raises InputError for an unknown law and for a restitution outside [0, 1].
    """
    return float(_damped(law).returned(checked(restitution)))


def _damped(law: str) -> type[Damped]:
    laws = {name: kind.leaf for name, kind in kinds("normal").items() if issubclass(kind.leaf, Damped)}
    if law not in laws:
        near = difflib.get_close_matches(law, laws, 1)
        raise InputError(f"unknown normal law '{law}'" + (f"; did you mean '{near[0]}'?" if near else ""))
    return laws[law]


class Damped(NormalLaw):
    """A law with a given restitution: its damping factor, and the restitution that an impact really returns."""

    restitution = Field("", "desired restitution, 0 to 1", least="not negative", missing=NEEDS_LOSS)

    @staticmethod
    @abstractmethod
    def factor(e: float) -> float:
        """Damping factor a [-] for the given restitution e [-] within [0, 1]."""

    @classmethod
    def returned(cls, e: float) -> float:
        """Restitution x [-] that a free impact returns for the given restitution e [-]."""
        return restitution_returned(cls.factor(e))

    @classmethod
    def notes(cls, values: LawValues) -> list[str]:
        """Remark for the user if the law returns a restitution that differs from the given one noticeably."""
        e = checked(as_number(values["restitution"]))
        x = cls.returned(e)
        if abs(x - e) <= NOTICED:
            return []
        return [f"this law returns a restitution of {x:.3f} instead of {e:g}; the law 'exact' returns the given value"]


class Hysteretic(Damped):
    """A law whose damping grows with the static force, F = F_static (1 + a ddelta/v0)."""

    vanishes = True
    least_speed = Field("m/s", "slower approaches are damped as at this speed", default=1e-3, least="positive")

    @classmethod
    def pack(cls, values: LawValues) -> tuple[float, ...]:
        """Parameters of the kernel, p[k:] = a [-], least_speed [m/s]; `values` by field name [SI]."""
        return cls.factor(checked(as_number(values["restitution"]))), as_number(values["least_speed"])


def _at_least(e: float) -> float:
    """A restitution below 0.001 replaced by 0.001: laws with 1/e are infinite at e = 0."""
    return max(e, LEAST_RESTITUTION)


@kind("normal", "exact", hysteretic)
class Exact(Hysteretic):
    """Returns exactly the given restitution: a solves ln((1+a)/(1-ea)) = a(1+e).

    Range: every e; below 0.001 it is taken as 0.001, where a = 1000 (a is infinite at 0).
    Source: this package, from the energy balance of the impact; the same a as gonthier-exact.
    """

    @staticmethod
    def factor(e: float) -> float:
        return factor_returning(e)


@kind("normal", "hertz", hysteretic)
class Hertz(Hysteretic):
    """Elastic, without loss: a = 0, F = F_static.

    Range: impacts without yielding or waves.
    Source: Hertz (1882), J. reine angew. Math. 92, 156-171.
    """

    restitution = Field("", "always 1: no energy is lost", default=1.0, least="not negative")

    @staticmethod
    def factor(e: float) -> float:
        return 0.0


@kind("normal", "hunt-crossley", hysteretic)
class HuntCrossley(Hysteretic):
    """a = 3(1-e)/2.

    Range: derived to first order in 1-e, for e near 1.
    Source: Hunt, Crossley (1975), J. Appl. Mech. 42, 440-445.
    """

    @staticmethod
    def factor(e: float) -> float:
        return 1.5 * (1.0 - e)


@kind("normal", "herbert-mcwhannell", hysteretic)
class HerbertMcWhannell(Hysteretic):
    """a = 6(1-e)/((2e-1)^2 + 3).

    Range: e near 1; returns 0.02 more than given at 0.7, 0.22 more at 0.3.
    Source: Herbert, McWhannell (1977), J. Eng. Ind. 99, 795-798.
    """

    @staticmethod
    def factor(e: float) -> float:
        return 6.0 * (1.0 - e) / ((2.0 * e - 1.0) ** 2 + 3.0)


@kind("normal", "lee-wang", hysteretic)
class LeeWang(Hysteretic):
    """a = 3(1-e)/4.

    Range: half the damping of hunt-crossley; even near e = 1 it loses only half of the energy it should.
    Source: Lee, Wang (1983), J. Mech. Transm. Autom. Des. 105, 534-543.
    """

    @staticmethod
    def factor(e: float) -> float:
        return 0.75 * (1.0 - e)


@kind("normal", "lankarani-nikravesh", hysteretic)
class LankaraniNikravesh(Hysteretic):
    """a = 3(1-e^2)/4.

    Range: e near 1 (above about 0.8).
    Source: Lankarani, Nikravesh (1990), J. Mech. Des. 112, 369-376.
    """

    @staticmethod
    def factor(e: float) -> float:
        return 0.75 * (1.0 - e * e)


@kind("normal", "gonthier", hysteretic)
class Gonthier(Hysteretic):
    """a = d/e with the usual approximation d = 1-e^2.

    Range: every e; returns e within 0.035.  An e below 0.001 is taken as 0.001.
    Source: Gonthier, McPhee, Lange, Piedboeuf (2004), Multibody Syst. Dyn. 11, 209-233.
    """

    @staticmethod
    def factor(e: float) -> float:
        return (1.0 - e * e) / _at_least(e)


@kind("normal", "gonthier-exact", hysteretic)
class GonthierExact(Hysteretic):
    """a = d/e, d from (1+d/e)/(1-d) = exp(d(1+1/e)): the equation of `exact` with d = e a.

    Range: every e; below 0.001 it is taken as 0.001.
    Source: Gonthier, McPhee, Lange, Piedboeuf (2004), Multibody Syst. Dyn. 11, 209-233.
    """

    @staticmethod
    def factor(e: float) -> float:
        return factor_returning(e)


@kind("normal", "zhiying-qishao", hysteretic)
class ZhiyingQishao(Hysteretic):
    """a = 3/4 (1-e^2) exp(2(1-e)).

    Range: e above about 0.25; at e = 0 it still returns 0.179.
    Source: Zhiying, Qishao (2006), J. Dyn. Control 4, 294-298.
    """

    @staticmethod
    def factor(e: float) -> float:
        return 0.75 * (1.0 - e * e) * math.exp(2.0 * (1.0 - e))


@kind("normal", "flores", hysteretic)
class Flores(Hysteretic):
    """a = 8(1-e)/(5e).

    Range: every e; returns e within 0.05.  An e below 0.001 is taken as 0.001.
    Source: Flores, Machado, Silva, Martins (2011), Multibody Syst. Dyn. 25, 357-375.
    """

    @staticmethod
    def factor(e: float) -> float:
        return 8.0 * (1.0 - e) / (5.0 * _at_least(e))


@kind("normal", "hu-guo", hysteretic)
class HuGuo(Hysteretic):
    """a = 3(1-e)/(2e).

    Range: every e; returns e within 0.035.  An e below 0.001 is taken as 0.001.
    Source: Hu, Guo (2015), Multibody Syst. Dyn. 35, 131-151.
    """

    @staticmethod
    def factor(e: float) -> float:
        return 1.5 * (1.0 - e) / _at_least(e)


@kind("normal", "anagnostopoulos", viscous)
@kind("normal", "kelvin-voigt", viscous)
class KelvinVoigt(Damped):
    """Spring and damper in parallel, F = k delta + c ddelta, c = 2 zeta sqrt(k m).

    zeta = -ln e / sqrt(pi^2 + ln^2 e);  m is the effective mass of the two bodies along the normal.
    For a nonlinear static force k is the secant stiffness F_static/delta (as in Jankowski, 2005).

    Range: a linear static force (exponent 1).  zeta is such that the full half period of oscillation returns e; because
    a contact never pulls, it ends earlier and returns exp(-2 zeta acos(zeta)/sqrt(1-zeta^2)): 0.902 for 0.9, 0.397 for
    0.3.  The force does not start from zero.
    Source: Anagnostopoulos (1988), Earthquake Eng. Struct. Dyn. 16, 443-456; Jankowski (2005), 34, 595-611.
    """

    effective_mass = Field("kg", "along the normal; 0: computed from the bodies", default=0.0, least="not negative")

    @staticmethod
    def factor(e: float) -> float:
        """Damping ratio zeta [-]."""
        if e == 0.0:
            return 1.0
        return -math.log(e) / math.hypot(math.pi, math.log(e))

    @classmethod
    def returned(cls, e: float) -> float:
        """Restitution x [-] that a free impact returns for e [-]: linear static force, without the pull at its end."""
        zeta = cls.factor(e)
        return math.exp(-2.0 * zeta * (math.acos(zeta) / math.sqrt(1.0 - zeta * zeta) if zeta < 1.0 else 1.0))

    @classmethod
    def pack(cls, values: LawValues) -> tuple[float, ...]:
        """Parameter of the kernel, p[k] = 2 zeta sqrt(m) [kg^0.5].  Raises InputError without effective mass [kg]."""
        mass = as_number(values["effective_mass"])
        if not mass > 0.0:
            raise InputError("kelvin-voigt needs the effective mass of the two bodies, in kg")
        return (2.0 * cls.factor(checked(as_number(values["restitution"]))) * sqrt(mass),)
