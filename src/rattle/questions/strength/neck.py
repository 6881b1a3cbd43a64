"""How much the neck of a plate bears: forces in a cut from edge to edge, and stresses there."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from rattle.description.cuts import Cut
from rattle.questions.strength.answer import Array, Strength
from rattle.questions.strength.known_motion import KnownMotion
from rattle.questions.strength.neck_forces import CutSection, forces_in, section_of
from rattle.results.display import quantity
from rattle.wrong_arguments import answers_in_words

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from rattle.plots.stress_colours import Drawn

DRAWN = 61  # points of a piece in a picture
NOMINAL = "nominal stress over the cut; what corners, holes and where loads enter add there is not computed"


@answers_in_words
class Neck(Strength):
    """What a neck of a plate bears; see `Strength`.  y along the cut from its first edge, x to its right."""

    _at = "y"

    def __init__(self, motion: KnownMotion, body: str, neck: str) -> None:
        super().__init__(motion, body, f"{body}.{neck}")
        sheet = self._own.sheet
        assert sheet is not None
        self.neck = neck
        self.cut = Cut(self._own.outline, sheet.necks[neck])
        self.section: CutSection = section_of(self.cut, sheet.thickness)
        self.x = np.array([self.section.centre - self.section.edges[0]])
        centroid = self.cut.first + self.section.centre * self.cut.along
        forces = forces_in(motion, neck, self._own, self.cut, centroid)
        self._doubt = forces.doubt
        self.normal, self.shear, self.moment = (
            np.where(motion.defined, part, math.nan)[:, None] for part in (forces.normal, forces.shear, forces.moment)
        )

    def at(self, y: float) -> Array:
        """Stress (n,) [Pa] so far along the cut from its first edge of material [m]."""
        bend = self.moment[:, 0] * (y - self.x[0]) / self.section.inertia
        return np.asarray(self.normal[:, 0] / self.section.area - bend)

    @cached_property
    def fibres(self) -> tuple[Array, Array]:
        """Stresses (n, 1) [Pa] at the second end of the cut and at the first."""
        first, second = self.section.edges
        return self.at(second - first)[:, None], self.at(0.0)[:, None]

    @cached_property
    def extreme(self) -> tuple[float, float, float]:
        """Largest magnitude of the stress [Pa], when [s], and where along the cut from its first edge [m]."""
        stress = np.abs(np.concatenate(self.fibres, axis=1))
        if not np.isfinite(stress).any():
            return math.nan, math.nan, math.nan
        row, side = np.unravel_index(int(np.nanargmax(stress)), stress.shape)
        first, second = self.section.edges
        return float(stress[row, side]), float(self.t[row]), float((second - first, 0.0)[side])

    def _of_theory(self) -> Iterable[str]:
        yield NOMINAL
        if self._doubt is not None:
            force, moment = self._doubt
            yield (
                "mass, center and inertia of the plate are given, and where its mass lies is not: weight and inertia of"
                " both sides are taken as those of the polygon, by which forces in the neck differ by"
                f" {quantity(2 * force, 'N')} and {quantity(2 * moment, 'N*m')} between its sides"
            )

    def told(self) -> list[tuple[str, str]]:
        """What it says in a few rows: a name and a number with its unit."""
        width = self.section.edges[1] - self.section.edges[0]
        area = f"{1e6 * self.section.area:.4g} mm^2, {quantity(width, 'm')} wide"
        return [*super().told(), ("section", area)]

    def plot(self) -> Figure:
        """Normal and shear force, moment, and stress at both ends of the cut, over time."""
        from rattle.questions.strength.pictures import plot_over_time

        return plot_over_time(self)

    @property
    def drawn(self) -> Drawn:
        """Points along each piece of the cut, with a gap between two."""
        from rattle.plots.stress_colours import Drawn

        places = [np.linspace(*piece, DRAWN) for piece in self.section.pieces]
        along = np.concatenate([np.append(piece, math.nan) for piece in places])[:-1]
        stress = np.column_stack([self.at(y - self.section.edges[0]) for y in along])
        return Drawn(self.body, self.cut.first + along[:, None] * self.cut.along, stress, None)
