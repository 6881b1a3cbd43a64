"""How much a bar or the neck of a plate bears in a motion: forces, stresses, safety, life.

Source: docs/theory.md, section 12.
"""

from __future__ import annotations

import math
import os
from abc import ABC, abstractmethod
from collections.abc import Iterable
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from rattle.description.model import Body
from rattle.language.materials import Material
from rattle.questions.strength.fatigue import Endurance, damage
from rattle.questions.strength.known_motion import KnownMotion
from rattle.questions.strength.wrenches import taken_together
from rattle.results.archive import package
from rattle.results.display import quantity, table
from rattle.results.table_file import write_frame
from rattle.wrong_arguments import answers_in_words

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

    from rattle.plots.stress_colours import Drawn

Array = NDArray[np.float64]
FOR_LIFE = {"ultimate": "ultimate", "endurance": "endurance", "exponent": "exponent"}  # keys and fields of a material
BUCKLING = "least buckling factor"
UNKNOWN = Material(math.nan, math.nan)


@answers_in_words
class Strength(ABC):
    """What a bar, at nx places from its end A to its end B, or the neck of a plate (nx = 1) bears at n instants; in SI.

    x (nx,), t (n,); normal, shear [N], moment [N m], stress [Pa], deflection, elongation [m] (n, nx); buckling (n,).
    """

    curves: ClassVar[tuple[str, ...]] = ("normal", "shear", "moment", "stress")
    x: Array
    normal: Array
    shear: Array
    moment: Array

    def __init__(self, motion: KnownMotion, body: str, name: str) -> None:
        """name: of what bears."""
        self.result, self.body, self.name, self.t = motion.result, body, name, motion.t
        self._motion = motion

    def __repr__(self) -> str:
        size = quantity(self.peak, "Pa", usual="MPa")
        return f"<rattle.Strength: '{self.name}', {len(self.t)} instants, largest stress {size}>"

    def _repr_html_(self) -> str:
        return table(("", ""), self.told(), f"Strength of {self.name}", self.remarks, hint="s.plot(), s.draw()")

    @property
    def _own(self) -> Body:
        return self._motion.system.model.bodies[self.body]

    @property
    def material(self) -> Material:
        """The material; one of which nothing is known if the model does not say it."""
        return self._own.material or UNKNOWN

    # ---------------------------------------------------------------- stress
    @property
    @abstractmethod
    def fibres(self) -> tuple[Array, Array]:
        """Stresses (n, nx) [Pa] of the outermost fibres on the side of +y and on that of -y."""

    @cached_property
    def stress(self) -> Array:
        """The stress (n, nx) [Pa] of the fibre with the larger magnitude, with its sign."""
        return larger(*self.fibres)

    @property
    @abstractmethod
    def extreme(self) -> tuple[float, float, float]:
        """Largest magnitude of the stress [Pa], when [s] and where [m]; nan if no value is known."""

    @property
    def peak(self) -> float:
        """The largest magnitude of the stress at all instants and places [Pa]."""
        return self.extreme[0]

    @property
    def peak_at(self) -> tuple[float, float]:
        """When [s] and where [m] it is: along a bar from A, along a neck from its first edge."""
        return self.extreme[1:]

    @property
    def safety(self) -> float:
        """Yield strength over the largest stress; nan if the material does not say it, inf without stress."""
        return self.material.yield_strength / self.peak if self.peak != 0.0 else math.inf * self.material.yield_strength

    # ---------------------------------------------------------------- what only bars have
    @property
    def deflection(self) -> Array:
        """How far a bar bends (n, nx) [m] to the side of +y, from the chord between its ends; nan of a neck."""
        return np.full_like(self.normal, math.nan)

    @property
    def elongation(self) -> Array:
        """How much longer a bar becomes between A and x (n, nx) [m]; nan of a neck."""
        return np.full_like(self.normal, math.nan)

    @property
    def buckling(self) -> Array:
        """By what factor the compression (n,) of a bar may grow until it buckles, inf where there is none; nan of a

        neck.
        """
        return np.full(len(self.t), math.nan)

    # ---------------------------------------------------------------- fatigue
    @property
    def endured(self) -> Endurance:
        """What the material endures; nan for what is not known."""
        material = self.material
        return Endurance(material.ultimate, material.endurance, material.endurance_cycles, material.exponent)

    @cached_property
    def life(self) -> float:
        """Runs of this record until it fails (Miner), the record repeating; the worst fibre of all places.

        Goodman, Haibach and Miner over rainflow cycles.  inf: every cycle is endured; 0: the first one breaks it; nan:
        the material does not say what it endures.
        """
        if any(math.isnan(number) for number in self.endured):
            return math.nan
        worst = 0.0
        for fibre in self.fibres:
            histories = np.ascontiguousarray(fibre[self._motion.defined].T)
            worst = max([worst, *(damage(history, self.endured) for history in histories if len(history))])
        return 1.0 / worst if worst > 0.0 else math.inf

    # ---------------------------------------------------------------- what is to be said
    @property
    def remarks(self) -> tuple[str, ...]:
        """What limits these numbers, and why some are not known."""
        return tuple(filter(None, (*self._of_theory(), *self._of_numbers(), *self._of_motion())))

    @abstractmethod
    def _of_theory(self) -> Iterable[str]:
        """Remarks where what is computed is not what bears."""

    def _of_numbers(self) -> Iterable[str]:
        """Remarks on the material."""
        if self.safety < 1.0:
            yield "YIELDS: its stress is above the yield strength; the numbers are those of a body that stays elastic"
        material = self.material
        if material is UNKNOWN:
            yield "no safety and no life: the model does not say its material"
            return
        named = f"material '{material.name}'" if material.name else "the material"
        if math.isnan(material.yield_strength):
            yield f"no safety: {named} does not say its yield"
        if missing := [key for key, name in FOR_LIFE.items() if math.isnan(getattr(material, name))]:
            yield f"no life: {named} does not say its {', '.join(missing)}"
        if self.life == 0.0:
            yield "the first cycle breaks it: its stress reaches the ultimate strength"

    def _of_motion(self) -> Iterable[str]:
        """Remarks on how the motion was followed."""
        r, model = self.result, self._motion.system.model
        if lost := int((~self._motion.defined).sum()):
            yield f"no value at {lost} of {len(self.t)} instants, where reactions are not determined"
        mine = {name for name, joint in model.joints.items() if self.body in (joint.a.body, joint.b.body)}
        if shared := sorted(mine & set(r.trust.nonunique)):
            yield f"reactions not unique (redundant constraints) at {', '.join(shared)}: the forces are one possibility"
        if rigid := dict.fromkeys(event.joint for event in r.events if event.kind == "impact"):
            yield f"impacts of rigid contacts in {', '.join(rigid)} are impulses: the stress by them is not computed"
        if r.trust.unread:
            yield f"forces of rigid contacts in {', '.join(r.trust.unread)} tower without meaning: read no peak of them"
        if several := taken_together(self._motion, self.body):
            yield f"contacts of {', '.join(several)} at several points are taken as one force at the joint's point"

    def told(self) -> list[tuple[str, str]]:
        """What it says in a few rows: a name and a number with its unit."""
        when, where = self.peak_at
        runs = (
            "not known" if math.isnan(self.life) else "for ever" if math.isinf(self.life) else f"{self.life:.4g} runs"
        )
        largest = [float(np.nanmax(np.abs(part), initial=0.0)) for part in (self.normal, self.shear, self.moment)]
        return [
            (
                "largest stress",
                f"{in_mega(self.peak)} at t = {quantity(when, 's')}, {self._at} = {quantity(where, 'm')}",
            ),
            ("safety against yield", in_digits(self.safety)),
            ("life", runs),
            ("largest normal force", quantity(largest[0], "N")),
            ("largest shear force", quantity(largest[1], "N")),
            ("largest moment", quantity(largest[2], "N*m")),
        ]

    _at: ClassVar[str] = "x"

    def numbers(self) -> dict[str, float]:
        """The same as numbers in SI."""
        return {
            "peak": self.peak, "peak_t": self.peak_at[0], "peak_x": self.peak_at[1], "safety": self.safety,
            "life": self.life,
        }  # fmt: skip

    # ---------------------------------------------------------------- tables and pictures
    @cached_property
    def table(self) -> DataFrame:
        """pandas.DataFrame of all places: x [m], and the least and the greatest normal, shear [N], moment [N m], stress

        [Pa], of bars deflection and elongation [m] over time.  Raises MissingPackage.
        """
        columns: dict[str, Array] = {"x": self.x}
        for name in self.curves:
            values = getattr(self, name)
            columns |= {f"{name}_min": np.nanmin(values, axis=0), f"{name}_max": np.nanmax(values, axis=0)}
        frame: DataFrame = package("pandas", "a table of strength").DataFrame(columns)
        return frame

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """Write `table` as CSV, in SI units.  Raises InputError for a suffix of another format, OSError."""
        return write_frame(self.table, path)

    @abstractmethod
    def plot(self) -> Figure:
        """Forces and stress: of a bar along it, at the instant of the largest stress, and the range over all instants

        as a band; of a neck over time.
        """

    def draw(self, t: float | None = None) -> Figure:
        """The mechanism with the bar or neck coloured by its stress, and the moment drawn along a bar.

        t: instant [s], the nearest one is drawn; default: that of the largest stress.
        """
        from rattle.questions.strength.pictures import draw_stressed

        return draw_stressed((self,), self.peak_at[0] if t is None else t)

    @property
    @abstractmethod
    def drawn(self) -> Drawn:
        """What pictures show of it."""


def larger(first: Array, second: Array) -> Array:
    """The one of the larger magnitude, element by element."""
    return np.where(np.abs(first) >= np.abs(second), first, second)


def in_mega(stress: float) -> str:
    """A stress in MPa, unless the user asks for another unit."""
    return quantity(stress, "Pa", usual="MPa")


def in_digits(value: float) -> str:
    """A plain number of four digits."""
    return "not known" if math.isnan(value) else f"{value:.4g}"
