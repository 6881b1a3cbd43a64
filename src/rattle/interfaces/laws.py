"""What other rooms need to know of the laws of contacts and films: the interface of these kinds."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from rattle.interfaces.fields import Field, LawValues, fields_of
from rattle.language.recorded import as_number

THINNEST = 0.02  # clearance over radius above which the film is not thin
WORDS = ("whole", "wetted")  # part of the circumference on which a film drags
Array = NDArray[np.float64]


class NormalLaw(ABC):
    """Interface of the laws of the normal force: of contacts, and of strands."""

    ends_by_force: ClassVar[bool] = False  # True: its kernel is not clipped, and the contact ends where F = 0
    vanishes: ClassVar[bool] = False  # True: F = 0 at depth 0 whatever the rate, so that it can go on beyond, mirrored

    @classmethod
    @abstractmethod
    def pack(cls, values: LawValues) -> tuple[float, ...]:
        """Parameters of the kernel, p[k:] [SI]; `values` by field name [SI]."""

    @classmethod
    def notes(cls, values: LawValues) -> list[str]:
        """Remarks for the user on the range of validity."""
        return []


class StiffnessLaw(ABC):
    """Interface of the static force laws: the parameters of its kernel, and the force up to which it is valid."""

    too_large = (  # said of a larger force
        "{force:.3g} N is above {limit:.3g} N, where the half-width of the contact is half the pin radius: this formula"
        " assumes a narrow contact; 'liu' is made for conforming contacts"
    )

    @classmethod
    @abstractmethod
    def pack(cls, values: LawValues) -> tuple[float, ...]:
        """Parameters of the kernel, p[k:] [SI]; `values` by field name [SI], with the joint's `clearance` [m]."""

    @classmethod
    def limit(cls, values: LawValues) -> float:
        """Normal force [N] up to which the formula is valid."""
        return math.inf

    @classmethod
    def notes(cls, values: LawValues, force: float = 0.0) -> list[str]:
        """Remarks for the user on the range of validity, for the largest normal force [N]."""
        limit = cls.limit(values)
        if force <= limit:
            return []
        return [cls.too_large.format(force=force, limit=limit)]


class FrictionLaw:
    """Interface of the friction laws."""

    states: ClassVar[int] = 0  # number of states z, which are integrated with the motion

    @classmethod
    def pack(cls, values: LawValues) -> tuple[float, ...]:
        """Parameters of the kernel, p[k:]: the fields [SI] in their order."""
        return tuple(as_number(values[name]) for name in fields_of(cls))

    @classmethod
    def notes(cls, values: LawValues) -> list[str]:
        """Remarks for the user on the range of validity."""
        return []


class TangentKind:
    """Interface of the rows along which friction of a joint without play acts."""

    unit: ClassVar[str]  # of the friction: N or N*m


class FilmLaw(ABC):
    """Interface of the laws of oil films."""

    viscosity = Field("Pa*s", "dynamic viscosity of the oil, at the temperature of the film", least="positive")
    length = Field("m", "of the bush, along its axis", least="positive")
    bush_radius = Field("m", "of the bore", least="positive")
    shear = Field(
        "", "the film drags on the whole circumference, or only where it has pressure", "whole", "choice", choices=WORDS
    )

    @classmethod
    def pack(cls, values: LawValues, clearance: float, least: float, start: int = 0) -> tuple[float, ...]:
        """Parameters of the kernel: mu R L^3/c^3 [N s/m], c [m], mu R^3 L/c [N m s], the least film over c [-], ...

        values by field name [SI]; clearance c [m]; least: thinnest film whose coefficients are used [m]; start: first
        coefficient in a table of several films.
        """
        mu, length, radius = (as_number(values[key]) for key in ("viscosity", "length", "bush_radius"))
        full, wetted = values.get("cavitation") == "full", values["shear"] == "wetted"
        force, shear = mu * radius * length * (length / clearance) ** 2 / clearance, mu * radius**3 * length / clearance
        return force, clearance, shear, least / clearance, float(full), float(wetted), float(start)

    @classmethod
    def table(cls, values: LawValues) -> Array:
        """Coefficients that the kernel reads besides its parameters; of most laws there are none."""
        return np.zeros(0)

    @classmethod
    def faults(cls, values: LawValues, clearance: float) -> list[str]:
        """What makes the law useless for these values [SI] and this clearance [m], in words."""
        ratio = clearance / as_number(values["bush_radius"])
        if ratio <= THINNEST:
            return []
        fault = f"the clearance is {ratio:.3g} of the radius; the theory of thin films needs at most {THINNEST:g}"
        return [fault]

    @classmethod
    def notes(cls, values: LawValues) -> list[str]:
        """Remarks for the user on the range of validity."""
        return []

    @classmethod
    @abstractmethod
    def peak(cls, values: LawValues, e: Array, alpha: Array) -> Array:
        """Largest pressure over mu L^2 |v|/c^3 at eccentricities e [of the clearance], v at alpha [rad] from them.

        All arrays are (n,).
        """

    @classmethod
    def leakage(cls, values: LawValues, e: Array, alpha: Array) -> Array:
        """What flows out of both ends over 2 R L |v|; nan if the law says nothing about it.  All arrays are (n,)."""
        return np.full(len(e), math.nan)
