"""An equilibrium with its quantities, and the list of those that were found.

All positions of one search are rows of one table; a `Result` of a single position is made only on demand.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from html import escape
from typing import NamedTuple

import numpy as np

from rattle.analyses.arguments import MOST_EFFORT
from rattle.description.model import is_ground
from rattle.errors import InputError
from rattle.jit.choices import TINY
from rattle.results.display import card, quantity, table
from rattle.results.film_columns import DRY
from rattle.results.result import Result
from rattle.results.trust import Trust
from rattle.value_types import Tree

PULLS = 1e-9  # [of the largest normal force] negative force above which a bush has to pull: below is rounding
MORE = 10.0  # factor on the effort that is advised after a search was cut short


class Table(NamedTuple):
    """Names, units and geometry that the equilibria of one mechanism share."""

    column: Mapping[str, int]  # column of every name
    units: Mapping[str, str]
    pins: tuple[tuple[str, int], ...]  # joints with clearance, and the columns of their normal forces
    geometry: Tree
    provenance: Tree

    @property
    def bodies(self) -> list[str]:
        """Names of all bodies but points of the ground."""
        return [name for name in self.geometry["bodies"] if not is_ground(name)]


@dataclass(repr=False)
class Equilibrium:
    """One equilibrium.  `E["coupler.angle"]` gives the value of any result name [SI]."""

    t: float  # time of the drivers' functions [s]
    q: np.ndarray = field(repr=False)  # (3 nb,) x, y, angle of every body [m, m, rad]
    multiplier: np.ndarray = field(repr=False)  # (nr,) of the constraint rows [N, N*m]
    eigenvalue: float  # smallest of the reduced Hessian [N/m]; inf if no degree of freedom is left
    residual: float  # largest unbalanced force [N]
    gap: float  # largest constraint residual [m or rad]
    iterations: int
    nonunique: tuple[str, ...]  # joints whose reactions are not unique
    dof: int  # degrees of freedom that the joints and drivers leave
    neutral: int  # number of neutral directions (eigenvalue 0)
    falling: int  # number of unstable directions (negative eigenvalues)
    row: np.ndarray = field(repr=False)  # (columns of the table,) [SI]
    table: Table = field(repr=False)
    resting: Mapping[str, int] = field(
        default_factory=dict
    )  # joints on a stop: 1 at its least value, -1 at its largest
    touching: Mapping[str, tuple[int, ...]] = field(default_factory=dict)  # contacts of rigid surfaces that carry

    def __getitem__(self, name: str) -> float:
        """Any quantity by its result name, in SI units.  Raises UnknownName."""
        k = self.table.column.get(name) if isinstance(name, str) else None
        return float(self.row[k] if k is not None else self.result[name][0])

    @cached_property
    def result(self) -> Result:
        """The equilibrium as a result of one instant, which can be plotted and saved."""
        return Result(
            t=[self.t], data=self.row[None], names=self.table.column, units=self.table.units,
            geometry=self.table.geometry, stats={"iterations": self.iterations},
            trust=Trust(drift=self.gap, t_end=self.t, horizon=self.t, nonunique=self.nonunique),
            provenance=self.table.provenance,
        )  # fmt: skip

    @property
    def names(self) -> tuple[str, ...]:
        """All names that `E[...]` accepts."""
        return self.result.names

    def unit(self, name: str) -> str:
        """SI unit of a quantity, "" for a plain number.  Raises UnknownName."""
        return self.result.unit(name)

    @cached_property
    def normals(self) -> dict[str, float]:
        """Normal force [N] of every pin with clearance, negative if the bush would have to pull."""
        return {name: float(self.row[k]) for name, k in self.table.pins}

    @property
    def pulled(self) -> tuple[str, ...]:
        """Pins at which the bush would have to pull, and joints whose stop would have to."""
        scale = max([abs(n) for n in self.normals.values()] + [TINY])
        stops = [name for name, side in self.resting.items() if side * self[f"{name}.stop"] < 0.0]
        return (*(name for name, n in self.normals.items() if n < -PULLS * scale), *stops)

    @property
    def admissible(self) -> bool:
        """True if no bush and no stop would have to pull (all N >= 0)."""
        return not self.pulled

    @property
    def stable(self) -> bool:
        """True if the mechanism returns after every small displacement (all eigenvalues positive).

        A pin that floats in oil may whirl about such a position all the same: `modes` tells.
        """
        return self.eigenvalue > 0.0

    @property
    def reactions_unique(self) -> bool:
        """False if constraints are redundant; `nonunique` names the joints."""
        return not self.nonunique

    def __repr__(self) -> str:
        bodies = self.table.bodies
        angles = ", ".join(f"{name}.angle {quantity(self[f'{name}.angle'], 'rad')}" for name in bodies[:4])
        more = ", ..." if len(bodies) > 4 else ""
        kind = f"{'stable' if self.stable else 'not stable'}, {'' if self.admissible else 'not '}admissible"
        return f"<rattle.Equilibrium at t = {self.t:g} s: {kind}; {angles}{more}>"

    def _repr_html_(self) -> str:
        rows = []
        for body in self.table.bodies:
            x, y, angle = (
                quantity(self[f"{body}.{key}"], unit, 6) for key, unit in (("x", "m"), ("y", "m"), ("angle", "rad"))
            )
            rows.append((body, x, y, angle))
        forces = [
            f"{name}: {quantity(self[name], self.unit(name))}"
            for name in self.names
            if name.endswith((".normal", ".torque", ".thrust", ".force"))
        ]
        return table(("body", "x", "y", "angle"), rows, str(self), forces)

    @property
    def floats(self) -> bool:
        """True if a pin floats on oil, whose speeds may make it whirl where it is stable at rest: `modes` says that."""
        return any(self._floats(name) for name in self.normals)

    def __str__(self) -> str:
        stable = "stable statically (whether oil makes it whirl, its modes say)" if self.floats else "stable"
        free = "neutral" if self.neutral else "held only across its displacements"
        return self.described(stable if self.stable else free if self.eigenvalue == 0.0 else "unstable")

    def described(self, kind: str) -> str:
        """The equilibrium in words, its kind first: "stable" or what else is known of it."""
        joints = self.table.geometry["joints"]
        ropes = [name for name in self.pulled if name in joints and self._is_longest(name)]
        others = [name for name in self.pulled if name not in ropes]
        sides = f", {', '.join(others)} would have to pull" if others else ""
        sides += f", {', '.join(ropes)} would have to push" if ropes else ""
        pins = "".join(f", {self._pin(name, abs(n))}" for name, n in self.normals.items() if name not in self.pulled)
        for name in self.resting:
            force = quantity(abs(self[f"{name}.stop"]), self.unit(f"{name}.stop"))
            pins += f", {name} rests on its stop with {force}" if name not in self.pulled else ""
        if self.neutral:
            kind += f" (free to move in {self.neutral} degree{'s' if self.neutral > 1 else ''} of freedom)"
        hold = f", stiffness {self.eigenvalue:.3g} N/m" if math.isfinite(self.eigenvalue) else ""
        return f"{kind}{hold}{sides}{pins}"

    def _is_longest(self, name: str) -> bool:
        """True of a rope at its largest distance, which pulls."""
        return self.table.geometry["joints"][name].get("coordinate") == "distance" and self.resting.get(name) == -1

    def _floats(self, name: str) -> bool:
        """True if a film carries at least a part of the force in a joint."""
        return f"{name}.film_thickness" in self.table.column and bool(self[f"{name}.regime"] != DRY)

    def _pin(self, name: str, normal: float) -> str:
        """How a pin is held, in words: pressed with `normal` [N], or by a film of oil."""
        if not self._floats(name):
            return f"{name} presses with {quantity(normal, 'N')}"
        dry = f" and presses with {quantity(normal, 'N')}" if normal > 0.0 else ""
        if self[f"{name}.film_thickness"] <= 0.0:
            return f"{name} is carried by oil between asperities (e/c {self[f'{name}.eccentricity']:.4f}){dry}"
        floats = f"{name} floats on {quantity(self[f'{name}.film_thickness'], 'm', usual='um')} of oil"
        return f"{floats} (e/c {self[f'{name}.eccentricity']:.4f}){dry}"


class Equilibria(list[Equilibrium]):
    """The equilibria that were found, in order, and how far the search went; shows itself as a table."""

    def __init__(
        self, members: Iterable[Equilibrium], starts: int, stopped: bool, extent: str = "", effort: float = 1.0,
        undefined: str = "", left_out: str = "", rubbing: str = "", moving: str = "",
    ) -> None:  # fmt: skip
        super().__init__(members)
        self.moving = moving  # bodies that drivers move while films see their speeds, in quotes; "" if there are none
        self.left_out = left_out  # what of the model an equilibrium does not contain; "" if it contains all
        self.rubbing = rubbing  # joints whose friction holds other positions too, in quotes; "" if there are none
        self.starts = starts  # number of starts of the search
        self.stopped = stopped  # True: the work was used up before the search was complete
        self.undefined = undefined  # what had no finite value during the search, and why; "" if all had
        self._extent, self._effort = extent, effort

    @property
    def note(self) -> str:
        """Note on the completeness of the list and on what it leaves out; "" if there is nothing to say.

        If no equilibrium or no forces were found because a load or an expression has no finite value: which, and why.
        """
        lacking = self.undefined if not self or any(math.isnan(member.residual) for member in self) else ""
        if self.left_out:
            hint = (
                "check that the pin stays inside" if self
                else "where a pin rests at an end or on a wall there may be one; a run with damping comes to rest there"
            )  # fmt: skip
            lacking += f"{'; ' if lacking else ''}{self.left_out}: {hint}"
        if self.rubbing:
            where = "beside these positions" if self else "where it is"
            lacking += (
                f"{'; ' if lacking else ''}friction in {self.rubbing} is left out: with it the mechanism may also rest"
                f" {where} (dead_band), and under other loads (holds, --holds LOAD)"
            )
        if self.moving:
            lacking += (
                f"{'; ' if lacking else ''}films see the speeds of the drivers, the inertia of {self.moving} is left"
                " out: orbit and simulate have it"
            )
        if not self.stopped:
            return lacking
        larger = min(max(1.0, MORE * self._effort), MOST_EFFORT)
        more = f" (effort {larger:g} searches longer)" if larger > self._effort else ""
        cut = f"search stopped after {self.starts} starts; there may be more equilibria{more}"
        return f"{lacking}; {cut}" if lacking else cut

    @property
    def extent(self) -> str:
        """How far the search went, in words."""
        words = self.note or self._extent
        return f"{words}; elsewhere {self.undefined}" if self.undefined and self.undefined not in words else words

    def first_at(self, t: float) -> Equilibrium:
        """The first equilibrium.  Raises InputError, with the reason if known, if there is none at t [s]."""
        if self:
            return self[0]
        raise InputError(f"no equilibrium was found at t = {t:g} s{f': {self.note}' if self.note else ''}")

    def __repr__(self) -> str:
        listed = "[" + ",\n ".join(repr(member) for member in self) + "]"
        return f"{listed}\n{self.note}" if self.note else listed

    def _repr_html_(self) -> str:
        rows = []
        for n, member in enumerate(self):
            angles = ", ".join(f"{name} {quantity(member[f'{name}.angle'], 'rad')}" for name in member.table.bodies)
            rows.append(
                (str(n), "yes" if member.stable else "no", "yes" if member.admissible else "no", angles, str(member))
            )
        if not rows:
            return card("no equilibrium was found", f"<p>{escape(self.note)}</p>" if self.note else "")
        title = f"{len(self)} equilibri{'a' if len(self) > 1 else 'um'}"
        head, below = ("", "stable", "admissible", "angles", ""), [self.note] if self.note else []
        return table(head, rows, title, below, hint="E[0], m.modes()")
