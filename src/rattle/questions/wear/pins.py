"""The pins that wear in a mechanism, their depths, and where these stand among the numbers of a run."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.analyses.assembly.assembly import put_together
from rattle.description.model import Model, Wear
from rattle.elements.worn_bins import DEPTHS, LEAST, PIN_WORN
from rattle.equations.system import System
from rattle.errors import ModelError, Problem
from rattle.jit import layout as at

Array = NDArray[np.float64]
Depths = list[Array]  # (2, bins) [m] for every pin that wears: of the bush, of the pin


class Pin(NamedTuple):
    """One joint that wears."""

    joint: str
    contact: int  # its contact in the arrays of the system
    first: int  # first of its parameters in `values`
    bins: int
    rates: tuple[float, float]  # k of bush and pin [m^2/N]
    area: float  # of one bin [m^2]
    bed: float  # K_w [Pa/m]
    radius: float  # of the bush [m]
    clearance: float  # [m]
    wall: float  # [m]
    smooth: float

    @property
    def factors(self) -> Array:
        """Depth per sliding work [m/J] of bush and pin, (2, 1)."""
        return np.array(self.rates)[:, None] / self.area

    def parameters(self, values: Array, depths: Array) -> Array:
        """Parameters of the kernel of the contact, in which the depths are those given (2, bins) [m]."""
        packed = np.array(values[self.first : self.first + DEPTHS + 2 * self.bins])
        packed[DEPTHS:] = depths.ravel()
        packed[LEAST], packed[PIN_WORN] = depths[0].min() + depths[1].min(), float(depths[1].any())
        return packed


def wearing_system(model: Model) -> System:
    """The system of a model in which all joints that wear have profiles.

    Raises ModelError if none wears, or if the contact of one has no force law.
    """
    joints, problems = dict(model.joints), list[Problem]()
    for name, joint in model.joints.items():
        wear = joint.wear
        if wear is None or (wear.bush == 0.0 and wear.pin == 0.0):
            continue
        here = ("joints", name, "contact")
        if joint.contact is None or joint.contact.normal is None:
            words = joint.contact.title if joint.contact is not None else "none"
            problems.append(
                Problem(here, f"'{words}' has no pressure from which wear follows; give a compliant contact")
            )
        elif joint.contact.film is not None:
            words = "wear is that of dry contacts: the oil film of a worn bush is not known; give the dry contact alone"
            problems.append(Problem(here, words))
        else:
            flat = (0.0,) * wear.bins
            joints[name] = replace(joint, wear=replace(wear, profile=wear.profile or (flat, flat)))
    if problems:
        raise ModelError(problems)
    if not any(_wears(joint.worn) for joint in joints.values()):
        words = 'no joint wears: give one with clearance wear = { bush = "1e-6 mm^3/(N*m)" }'
        raise ModelError([Problem(("joints",), words)])
    return put_together(replace(model, joints=joints))


def _wears(wear: Wear | None) -> bool:
    return wear is not None and (wear.bush > 0.0 or wear.pin > 0.0)


def pins_of(system: System) -> list[Pin]:
    """All joints that wear."""
    pins = []
    for c, entry in enumerate(system.arrays["contact"]):
        joint = system.model.joints[system.joints[entry[at.OWNER]]]
        wear = joint.worn
        if entry[at.WORN] != 1 or wear is None or not _wears(wear):
            continue
        area = wear.radius * wear.length * 2.0 * math.pi / wear.bins
        rates, place = (wear.bush, wear.pin), int(entry[at.SHAPE_P])
        sizes = (area, wear.foundation, wear.radius, joint.clearance, wear.wall, wear.smooth)
        pins.append(Pin(joint.name, c, place, wear.bins, rates, *sizes))
    return pins


def depths_of(system: System, pins: Sequence[Pin]) -> Depths:
    """Depths in the model."""
    worn = [system.model.joints[pin.joint].worn for pin in pins]
    return [np.array(wear.profile, dtype=float) for wear in worn if wear is not None]


def enter(values: Array, pins: Sequence[Pin], depths: Depths) -> None:
    """Write depths into the parameters of a run."""
    for pin, both in zip(pins, depths, strict=True):
        values[pin.first : pin.first + DEPTHS + 2 * pin.bins] = pin.parameters(values, both)


def as_documents(pins: Sequence[Pin], depths: Depths) -> Mapping[str, dict[str, list[float]]]:
    """Depths [m] by joint, as they stand in a model file."""
    return {
        pin.joint: {"bush": both[0].tolist(), "pin": both[1].tolist()} for pin, both in zip(pins, depths, strict=True)
    }
