"""How much a bar bears in a motion: forces and stresses along it, deflection, buckling.

Source: docs/theory.md, section 12.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from rattle.description.model import Beam, Section
from rattle.language.recorded import bare
from rattle.questions.strength.answer import BUCKLING, Array, Strength, in_digits, in_mega, larger
from rattle.questions.strength.known_motion import KnownMotion
from rattle.questions.strength.section_forces import LoadedBar
from rattle.results.display import quantity
from rattle.wrong_arguments import answers_in_words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rattle.plots.stress_colours import Drawn

NO_PRESS = 1e-9  # share of the largest force below which a compression is rounding
SLENDER = 5.0  # length over height of a bar below which shear deforms it by more than a tenth of its bending
FEW_PERIODS = 2.0  # of the first bending vibration: a contact that is shorter makes the bar ring
NOT_COMPUTED = "buckling is that in the plane between pinned ends; out of the plane and with other ends: not computed"


@answers_in_words
class Bar(Strength):
    """What a bar bears; see `Strength`."""

    curves = ("normal", "shear", "moment", "stress", "deflection", "elongation")

    def __init__(self, motion: KnownMotion, body: str) -> None:
        super().__init__(motion, body, body)
        self._bar = bar = LoadedBar(motion, body, self.beam)
        self.x, after = bar.stations
        forces = bar.forces(self.x, after)
        bar.require_closed(motion.defined, forces)
        at_moving, after_moving = bar.moving
        self._moving_x, self._at_moving = at_moving, bar.forces(at_moving, after_moving)
        for part in (*forces, *self._at_moving):
            part[~motion.defined] = math.nan
        self.normal, self.shear, self.moment = forces

    # ---------------------------------------------------------------- the bar

    @property
    def beam(self) -> Beam:
        """The bar as the model has it."""
        beam = self._own.beam
        assert beam is not None
        return beam

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
    def extreme(self) -> tuple[float, float, float]:
        """Largest magnitude of the stress [Pa], when [s] and where [m]: at stations and at loads that move."""
        normal, _, moment = self._at_moving
        stress = np.abs(np.concatenate([self.stress, larger(*self._fibres(normal, moment))], axis=1))
        if not np.isfinite(stress).any():
            return math.nan, math.nan, math.nan
        row, column = np.unravel_index(int(np.nanargmax(stress)), stress.shape)
        count = len(self.x)
        place = self.x[column] if column < count else self._moving_x[row, column - count]
        return float(stress[row, column]), float(self.t[row]), float(place)

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

    # ---------------------------------------------------------------- what is to be said
    def _of_theory(self) -> Iterable[str]:
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
        if not self.beam.physical:
            yield (
                "the mass distribution is not physical: mass, centre and inertia need negative masses at the ends;"
                " give mass_per_length"
            )

    def _of_numbers(self) -> Iterable[str]:
        yield from super()._of_numbers()
        if not np.isfinite(self.buckling).any():
            return
        limit = self.euler_load / self.section.area
        if limit > self.material.yield_strength and not float(np.nanmin(self.buckling, initial=math.inf)) < 1.0:
            yield (
                f"too short for Euler's formula, whose stress of {in_mega(limit)} is above yield: the bar yields"
                " before it buckles"
            )
        yield NOT_COMPUTED

    def _of_motion(self) -> Iterable[str]:
        yield from super()._of_motion()
        period = 1.0 / self.frequency
        events = self.result.events
        short = dict.fromkeys(event.joint for event in events if 0.0 < event.duration < FEW_PERIODS * period)
        if short:
            yield (
                f"contacts in {', '.join(short)} are shorter than {FEW_PERIODS:g} periods of the first bending"
                f" vibration ({quantity(period, 's')}): the bar rings, which is not computed"
            )

    def told(self) -> list[tuple[str, str]]:
        """What it says in a few rows: a name and a number with its unit."""
        least = float(np.nanmin(self.buckling, initial=math.inf))
        rows = super().told()
        rows.insert(3, (BUCKLING, "no compression" if math.isinf(least) else in_digits(least)))
        return [
            *rows,
            ("largest deflection", quantity(float(np.nanmax(np.abs(self.deflection), initial=0.0)), "m")),
            ("largest elongation", quantity(float(np.nanmax(np.abs(self.elongation), initial=0.0)), "m")),
            ("first bending frequency", quantity(self.frequency, "Hz")),
        ]

    def numbers(self) -> dict[str, float]:
        """The same as numbers in SI."""
        least = float(np.nanmin(self.buckling, initial=math.inf))
        return {**super().numbers(), "buckling": least, "frequency": self.frequency}

    # ---------------------------------------------------------------- pictures
    def plot(self) -> Figure:
        """Normal and shear force, moment and stress along the bar: at the instant of the largest stress, and the range

        over all instants as a band.
        """
        from rattle.questions.strength.pictures import plot_along

        return plot_along(self)

    @property
    def drawn(self) -> Drawn:
        """Its axis."""
        from rattle.plots.stress_colours import Drawn

        places = np.column_stack([self.places, np.zeros_like(self.places)])
        return Drawn(self.body, places, self.stress, self.moment)
