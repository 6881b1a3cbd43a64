"""What of a joint depends on its temperature: the viscosity of its oil, and its play."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.catalogue.oils import COLDEST, HOTTEST
from rattle.errors import ModelError, SolverError
from rattle.language.units import FREEZING
from rattle.mechanism import Mechanism

Array = NDArray[np.float64]
LEAST_WAY = 0.5  # [K] before the temperature at which its play closes a joint has seized: friction towers from there
HALVINGS = 30  # of the way to that temperature: 1e-7 K after 100 K
OF_MATERIALS = ("bush_material", "pin_material")


class Dependent(NamedTuple):
    """A joint with oil or play that depends on temperature."""

    joint: str
    number: int  # among all joints
    keys: tuple[str, ...]  # of the model file, for its temperatures
    has_oil: bool
    grows: bool  # its play depends on temperature

    @property
    def parts(self) -> str:
        """What depends on its temperature, in words."""
        return " and ".join(word for word, counts in (("oil", self.has_oil), ("play", self.grows)) if counts)


def dependents(m: Mechanism) -> tuple[Dependent, ...]:
    """The joints whose oil or play depends on temperature."""
    joints = []
    for number, (name, table) in enumerate(m._document.get("joints", {}).items()):
        contact, clearance = table.get("contact"), table.get("clearance")
        has_oil = isinstance(contact, Mapping) and "oil" in contact
        grows = isinstance(clearance, Mapping) and all(key in clearance for key in OF_MATERIALS)
        parts = [part for part, counts in (("contact", has_oil), ("clearance", grows)) if counts]
        if parts:
            keys = tuple(f"joints.{name}.{part}.temperature" for part in parts)
            joints.append(Dependent(name, number, keys, has_oil, grows))
    return tuple(joints)


def warmed(m: Mechanism, joints: tuple[Dependent, ...], temperatures: Array) -> Mechanism:
    """The mechanism with its joints at their temperatures (n,) [K].  Raises ModelError where play has closed."""
    if not joints:
        return m
    return m.set({key: float(temperatures[joint.number]) for joint in joints for key in joint.keys})


def falls(m: Mechanism, warmer: Mechanism, joints: tuple[Dependent, ...], count: int) -> Array:
    """(count,) change of the losses per loss and kelvin [1/K] by oil and play alone; m, warmer: 1 K apart.

    Of a film that turns: P is proportional to mu/c.  A loaded one loses less of it, so that steps are short of the aim.
    """
    change = np.zeros(count)
    for joint in joints:
        change[joint.number] = _drag(warmer, joint.joint) / _drag(m, joint.joint) - 1.0
    return change


def _drag(m: Mechanism, name: str) -> float:
    """The loss of a film over its speed, up to a factor that does not change: viscosity over play."""
    joint = m.model.joints[name]
    film = joint.contact.film if joint.contact is not None else None
    return float(film.law.number("viscosity")) / float(joint.clearance) if film is not None else 1.0


def within_reach(m: Mechanism, joints: tuple[Dependent, ...], now: Array, aim: Array, losses: Array) -> Array:
    """Temperatures (n,) [K] on the way from `now` to `aim` at which oils are known and joints have play.

    Raises SolverError where there are none farther than now.
    """
    reached = aim.copy()
    for joint in joints:
        k = joint.number
        if joint.has_oil:
            reached[k] = _known_oil(joint.joint, float(now[k]), float(aim[k]), float(losses[k]))
        limit = _closing(m, joint, float(now[k]), float(reached[k]))
        if limit is not None and abs(limit - now[k]) < LEAST_WAY:
            raise SolverError(
                f"{joint.joint} seizes: no play left at {limit - FREEZING:.1f} degC; at {now[k] - FREEZING:.1f} degC it"
                f" still loses {losses[k]:.4g} W, more than flows off",
                None,
            )
        if limit is not None:
            reached[k] = 0.5 * (now[k] + limit)
    return reached


def _known_oil(joint: str, now: float, aim: float, loss: float) -> float:
    limit = min(max(aim, COLDEST), HOTTEST)
    if limit == now != aim:
        would, beyond = ("boil away", "hotter than 200") if aim > HOTTEST else ("set", "colder than -30")
        raise SolverError(
            f"the oil of {joint} would {would}: it becomes {beyond} degC, where oils are not known, with {loss:.4g} W"
            f" lost at {now - FREEZING:.1f} degC",
            None,
        )
    return limit


def _closing(m: Mechanism, joint: Dependent, now: float, aim: float) -> float | None:
    """The temperature [K] between now and aim at which a joint has no play left; None if it keeps some."""

    def opens(temperature: float) -> bool:
        try:
            m.set(dict.fromkeys(joint.keys, temperature))
        except ModelError:
            return False
        return True

    if opens(aim) or math.isclose(now, aim):
        return None
    for _ in range(HALVINGS):
        middle = 0.5 * (now + aim)
        now, aim = (middle, aim) if opens(middle) else (now, middle)
    return now
