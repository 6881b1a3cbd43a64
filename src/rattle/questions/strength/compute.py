"""How much a bar bears in a motion: forces and stresses along it, deflection, buckling, safety and life.

Source: docs/theory.md, section 12.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rattle.description.model import Beam, Body, Model, Section
from rattle.errors import InputError, suggest
from rattle.language.materials import Material
from rattle.language.recorded import bare
from rattle.questions.strength.fatigue import Endurance, damage
from rattle.questions.strength.known_motion import KnownMotion, known_motion
from rattle.questions.strength.section_forces import LoadedBar
from rattle.questions.strength.wrenches import taken_together
from rattle.results.archive import package
from rattle.results.display import quantity, table
from rattle.results.result import Result
from rattle.results.table_file import write_frame
from rattle.wrong_arguments import answers_in_words

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

Array = NDArray[np.float64]
NO_PRESS = 1e-9  # share of the largest force below which a compression is rounding
SLENDER = 5.0  # length over height of a bar below which shear deforms it by more than a tenth of its bending
FEW_PERIODS = 2.0  # of the first bending vibration: a contact that is shorter makes the bar ring
FOR_LIFE = {"ultimate": "ultimate", "endurance": "endurance", "exponent": "exponent"}  # keys and fields of a material
NOT_COMPUTED = "buckling is that in the plane between pinned ends; out of the plane and with other ends: not computed"


def strength(r: Result, body: str) -> Strength:
    """How much a bar bears in the motion of a result; see `Result.strength`."""
    return next(iter(strengths(r, (body,)).values()))


def strengths(r: Result, bodies: Iterable[str] | None = None) -> dict[str, Strength]:
    """The same of several bars, by default of all that have a section and a material."""
    motion = known_motion(r, "strength")
    model = motion.system.model
    names = bars_of(model) if bodies is None else tuple(bodies)
    for name in names:
        require_bar(model, name)
    return {name: Strength(motion, name) for name in names}


def bars_of(model: Model) -> tuple[str, ...]:
    """Names of the bars of a model whose strength can be asked for."""
    beams = ((name, body.beam) for name, body in model.bodies.items())
    return tuple(name for name, beam in beams if beam is not None and beam.section and beam.material)


def require_bar(model: Model, name: str) -> None:
    """Raise InputError unless a body is a bar with section and material."""
    able = bars_of(model)
    if name not in model.bodies:
        raise InputError(f"strength: no body '{name}'{suggest(name, able or model.bodies)}")
    beam = model.bodies[name].beam
    if beam is None:
        raise InputError(f'strength: body \'{name}\' is no bar; it needs bar = ["A", "B"], length, section, material')
    missing = [key for key, part in (("section", beam.section), ("material", beam.material)) if part is None]
    if missing:
        raise InputError(f"strength: the bar '{name}' needs {' and '.join(missing)} in the model")


@answers_in_words
class Strength:
    """What a bar bears at n instants, at nx places from its end A to its end B; all in SI.

    x (nx,), t (n,); normal, shear [N], moment [N m], stress [Pa], deflection, elongation [m] (n, nx); buckling (n,).
    """

    def __init__(self, motion: KnownMotion, body: str) -> None:
        self.result, self.body, self.t = motion.result, body, motion.t
        self._motion = motion
        self._bar = bar = LoadedBar(motion, body, self.beam)
        self.x, after = bar.stations
        forces = bar.forces(self.x, after)
        bar.require_closed(motion.defined, forces)
        at_moving, after_moving = bar.moving
        self._moving_x, self._at_moving = at_moving, bar.forces(at_moving, after_moving)
        for part in (*forces, *self._at_moving):
            part[~motion.defined] = math.nan
        self.normal, self.shear, self.moment = forces

    def __repr__(self) -> str:
        size = quantity(self.peak, "Pa", usual="MPa")
        return f"<rattle.Strength: '{self.body}', {len(self.t)} instants, largest stress {size}>"

    def _repr_html_(self) -> str:
        return table(("", ""), self.told(), f"Strength of {self.body}", self.remarks, hint="s.plot(), s.draw()")

    # ---------------------------------------------------------------- the bar
    @property
    def beam(self) -> Beam:
        """The bar as the model has it."""
        beam = self._own.beam
        assert beam is not None
        return beam

    @property
    def _own(self) -> Body:
        return self._motion.system.model.bodies[self.body]

    @property
    def places(self) -> Array:
        """Where x lies on the axis of the bar, from its mass centre (nx,) [m]."""
        return self.x - self.beam.centre

    @property
    def section(self) -> Section:
        """Area [m^2], second moment of area [m^4] and modulus [m^3] of the section."""
        assert self.beam.section is not None
        return self.beam.section

    @property
    def material(self) -> Material:
        """The material of the bar."""
        assert self.beam.material is not None
        return self.beam.material

    @property
    def frequency(self) -> float:
        """First bending frequency between pins [Hz]: pi/2 (E I/(m L^3))^.5, the mass spread evenly."""
        mass, length = bare(self._own.mass), self.beam.length
        return (
            math.pi / 2.0 * math.sqrt(self.material.E * self.section.inertia / (mass * length**3)) if mass else math.inf
        )

    # ---------------------------------------------------------------- stress
    def _fibres(self, normal: Array, moment: Array) -> tuple[Array, Array]:
        """Stresses [Pa] on the sides of +y and -y."""
        pull, bend = normal / self.section.area, moment / self.section.modulus
        return pull - bend, pull + bend

    @cached_property
    def fibres(self) -> tuple[Array, Array]:
        """Stresses (n, nx) [Pa] on the side of +y and on that of -y: N/A -+ M/W."""
        return self._fibres(self.normal, self.moment)

    @cached_property
    def stress(self) -> Array:
        """The stress (n, nx) [Pa] of the fibre with the larger magnitude, with its sign."""
        return _larger(*self.fibres)

    @cached_property
    def _peak(self) -> tuple[float, float, float]:
        """Largest magnitude of the stress [Pa], when [s] and where [m]: at stations and at loads that move."""
        normal, _, moment = self._at_moving
        stress = np.abs(np.concatenate([self.stress, _larger(*self._fibres(normal, moment))], axis=1))
        if not np.isfinite(stress).any():
            return math.nan, math.nan, math.nan
        row, column = np.unravel_index(int(np.nanargmax(stress)), stress.shape)
        count = len(self.x)
        place = self.x[column] if column < count else self._moving_x[row, column - count]
        return float(stress[row, column]), float(self.t[row]), float(place)

    @property
    def peak(self) -> float:
        """The largest magnitude of the stress at all instants and places [Pa]."""
        return self._peak[0]

    @property
    def peak_at(self) -> tuple[float, float]:
        """When [s] and where [m] it is."""
        return self._peak[1:]

    @property
    def safety(self) -> float:
        """Yield strength over the largest stress; nan if the material does not say it, inf without stress."""
        return self.material.yield_strength / self.peak if self.peak != 0.0 else math.inf * self.material.yield_strength

    # ---------------------------------------------------------------- deformation
    @cached_property
    def deflection(self) -> Array:
        """How far the bar bends (n, nx) [m] to the side of +y, from the chord between its ends."""
        return self._defined(self._bar.sag(self.x) / (self.material.E * self.section.inertia))

    @cached_property
    def elongation(self) -> Array:
        """How much longer the bar becomes between A and x (n, nx) [m]."""
        return self._defined(self._bar.stretch(self.x) / (self.material.E * self.section.area))

    def _defined(self, values: Array) -> Array:
        values[~self._motion.defined] = math.nan
        return values

    # ---------------------------------------------------------------- buckling
    @property
    def euler_load(self) -> float:
        """The compression [N] at which the bar buckles in the plane between pins: pi^2 E I/L^2."""
        return math.pi**2 * self.material.E * self.section.inertia / self.beam.length**2

    @cached_property
    def buckling(self) -> Array:
        """By what factor the compression (n,) may grow until the bar buckles; inf where there is none."""
        every = np.concatenate([self.normal, self._at_moving[0]], axis=1)
        press = -every.min(axis=1)
        largest = max(np.nanmax(np.abs(part), initial=0.0) for part in (self.normal, self.shear))
        pressed = press > NO_PRESS * largest
        factor = np.where(pressed, self.euler_load / np.where(pressed, press, 1.0), math.inf)
        return np.where(np.isnan(press), math.nan, factor)

    # ---------------------------------------------------------------- fatigue
    @property
    def endured(self) -> Endurance:
        """What the material endures; nan for what is not known."""
        material = self.material
        return Endurance(material.ultimate, material.endurance, material.endurance_cycles, material.exponent)

    @cached_property
    def life(self) -> float:
        """Runs of this record until the bar fails (Miner), the record repeating; the worst fibre of all places.

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

    def _of_theory(self) -> Iterable[str]:
        """Remarks where a slender bar that stays straight and elastic is not what bears."""
        slender = self.beam.length / self.section.height
        if slender < SLENDER:
            yield (
                f"as long as {slender:.2g} times its height: too stocky for the theory of bars, which leaves out shear"
                f" deformation and how forces enter (made for {SLENDER:g} times and more)"
            )
        if (factor := float(np.nanmin(self.buckling, initial=math.inf))) < 1.0:
            yield (
                f"BUCKLES: it is pressed by {1.0 / factor:.3g} times the load of Euler; the numbers are those of a bar"
                " that stays straight"
            )
        if self.safety < 1.0:
            yield "YIELDS: its stress is above the yield strength; the numbers are those of a bar that stays elastic"

    def _of_numbers(self) -> Iterable[str]:
        """Remarks on material, section and mass."""
        material = self.material
        named = f"material '{material.name}'" if material.name else "the material"
        if math.isnan(material.yield_strength):
            yield f"no safety: {named} does not say its yield"
        if missing := [key for key, name in FOR_LIFE.items() if math.isnan(getattr(material, name))]:
            yield f"no life: {named} does not say its {', '.join(missing)}"
        if self.life == 0.0:
            yield "the first cycle breaks it: its stress reaches the ultimate strength"
        if not self.beam.physical:
            yield (
                "the mass distribution is not physical: mass, centre and inertia need negative masses at the ends;"
                " give mass_per_length"
            )
        limit = self.euler_load / self.section.area
        if np.isfinite(self.buckling).any():
            if limit > material.yield_strength and not float(np.nanmin(self.buckling, initial=math.inf)) < 1.0:
                yield (
                    f"too short for Euler's formula, whose stress of {in_mega(limit)} is above yield: the bar yields"
                    " before it buckles"
                )
            yield NOT_COMPUTED

    def _of_motion(self) -> Iterable[str]:
        """Remarks on how the motion was followed."""
        r, model = self.result, self._motion.system.model
        if lost := int((~self._motion.defined).sum()):
            yield f"no value at {lost} of {len(self.t)} instants, where reactions are not determined"
        mine = {name for name, joint in model.joints.items() if self.body in (joint.a.body, joint.b.body)}
        if shared := sorted(mine & set(r.trust.nonunique)):
            yield f"reactions not unique (redundant constraints) at {', '.join(shared)}: the forces are one possibility"
        period = 1.0 / self.frequency
        short = dict.fromkeys(event.joint for event in r.events if 0.0 < event.duration < FEW_PERIODS * period)
        if short:
            yield (
                f"contacts in {', '.join(short)} are shorter than {FEW_PERIODS:g} periods of the first bending"
                f" vibration ({quantity(period, 's')}): the bar rings, which is not computed"
            )
        if rigid := dict.fromkeys(event.joint for event in r.events if event.kind == "impact"):
            yield f"impacts of rigid contacts in {', '.join(rigid)} are impulses: the stress by them is not computed"
        if r.trust.unread:
            yield f"forces of rigid contacts in {', '.join(r.trust.unread)} tower without meaning: read no peak of them"
        if several := taken_together(self._motion, self.body):
            yield f"contacts of {', '.join(several)} at several points are taken as one force at the joint's point"

    def told(self) -> list[tuple[str, str]]:
        """What it says in a few rows: a name and a number with its unit."""
        when, where = self.peak_at
        least = float(np.nanmin(self.buckling, initial=math.inf))
        runs = (
            "not known" if math.isnan(self.life) else "for ever" if math.isinf(self.life) else f"{self.life:.4g} runs"
        )
        largest = [float(np.nanmax(np.abs(part), initial=0.0)) for part in (self.normal, self.shear, self.moment)]
        return [
            ("largest stress", f"{in_mega(self.peak)} at t = {quantity(when, 's')}, x = {quantity(where, 'm')}"),
            ("safety against yield", _number(self.safety)),
            ("life", runs),
            ("least buckling factor", "no compression" if math.isinf(least) else _number(least)),
            ("largest normal force", quantity(largest[0], "N")),
            ("largest shear force", quantity(largest[1], "N")),
            ("largest moment", quantity(largest[2], "N*m")),
            ("largest deflection", quantity(float(np.nanmax(np.abs(self.deflection), initial=0.0)), "m")),
            ("largest elongation", quantity(float(np.nanmax(np.abs(self.elongation), initial=0.0)), "m")),
            ("first bending frequency", quantity(self.frequency, "Hz")),
        ]

    def numbers(self) -> dict[str, float]:
        """The same as numbers in SI."""
        return {
            "peak": self.peak, "peak_t": self.peak_at[0], "peak_x": self.peak_at[1], "safety": self.safety,
            "life": self.life, "buckling": float(np.nanmin(self.buckling, initial=math.inf)),
            "frequency": self.frequency,
        }  # fmt: skip

    # ---------------------------------------------------------------- tables and pictures
    @cached_property
    def table(self) -> DataFrame:
        """pandas.DataFrame of all places: x [m], and the least and the greatest normal, shear [N], moment [N m], stress

        [Pa], deflection and elongation [m] over time.  Raises MissingPackage.
        """
        columns: dict[str, Array] = {"x": self.x}
        for name in ("normal", "shear", "moment", "stress", "deflection", "elongation"):
            values = getattr(self, name)
            columns |= {f"{name}_min": np.nanmin(values, axis=0), f"{name}_max": np.nanmax(values, axis=0)}
        frame: DataFrame = package("pandas", "a table of a bar").DataFrame(columns)
        return frame

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """Write `table` as CSV, in SI units.  Raises InputError for a suffix of another format, OSError."""
        return write_frame(self.table, path)

    def plot(self) -> Figure:
        """Normal and shear force, moment and stress along the bar: at the instant of the largest stress, and the range

        over all instants as a band.
        """
        from rattle.questions.strength.pictures import plot_along

        return plot_along(self)

    def draw(self, t: float | None = None) -> Figure:
        """The mechanism with the bar coloured by its stress and the moment drawn along it.

        t: instant [s], the nearest one is drawn; default: that of the largest stress.
        """
        from rattle.questions.strength.pictures import draw_bars

        return draw_bars((self,), self.peak_at[0] if t is None else t)


def _larger(first: Array, second: Array) -> Array:
    """The one of the larger magnitude, element by element."""
    return np.where(np.abs(first) >= np.abs(second), first, second)


def in_mega(stress: float) -> str:
    """A stress in MPa, unless the user asks for another unit."""
    return quantity(stress, "Pa", usual="MPa")


def _number(value: float) -> str:
    return "not known" if math.isnan(value) else f"{value:.4g}"
