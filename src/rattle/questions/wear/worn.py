"""Result of a study of wear: profiles, history, and what a user should know of them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.errors import suggest
from rattle.mechanism import Mechanism
from rattle.questions.wear.cycle import Sliding, State
from rattle.questions.wear.pins import Depths, Pin, as_documents
from rattle.results.archive import package
from rattle.results.chosen_units import chosen
from rattle.results.display import quantity, table
from rattle.results.result import UnknownName

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


Array = NDArray[np.float64]
SIDES = ("bush", "pin")
SCATTER = 0.5  # of a measured coefficient of wear, up and down


@dataclass
class Reached:
    """How far a study has come; it is kept after every jump."""

    depths: Depths
    cycle: float = 0.0
    state: State | None = None  # from which the next cycle starts
    recent: list[Sliding] = field(default_factory=list)  # the last cycles, whose mean counts
    next: float = 0.0  # cycles of the next jump; 0: not known
    simulated: int = 0  # cycles
    outcome: str = ""  # why it has ended; "" if it has not
    rows: list[list[float]] = field(default_factory=list)  # of the history: cycle, jump, error, smoothing; sums, depths
    per_cycle: Depths = field(default_factory=list)  # [m] in the last cycle
    interrupted: bool = False

    @classmethod
    def start(cls, depths: Depths) -> Reached:
        """Before the first cycle."""
        reached = cls(depths)
        reached.rows.append([0.0, 0.0, 0.0, 0.0, *_sizes(depths)])
        return reached

    @property
    def settled(self) -> State:
        """The state from which the next cycle starts."""
        assert self.state is not None, "asked for after the first cycle"
        return self.state

    def enter(self, depths: Depths, jump: float, error: float, smoothed: float) -> None:
        """Add a jump."""
        self.depths, self.cycle = depths, self.cycle + jump
        self.rows.append([self.cycle, jump, error, smoothed, *_sizes(depths)])


def _sizes(depths: Depths) -> list[float]:
    return [number for h in depths for side in range(2) for number in (float(h[side].sum()), float(h[side].max()))]


class Side(NamedTuple):
    """The worn surface of a bush or a pin."""

    angle: Array  # (bins,) middles of the bins, in the frame of its body [rad]
    depth: Array  # (bins,) [m]
    volume: float  # lost [m^3]
    deepest: float  # [m]
    per_cycle: Array  # (bins,) depth lost in the last cycle that was simulated [m]


class Profile(NamedTuple):
    """Both worn surfaces of a joint."""

    bush: Side
    pin: Side


class Worn:
    """What `Mechanism.wear` has found."""

    def __init__(self, mechanism: Mechanism, pins: tuple[Pin, ...], reached: Reached, notes: tuple[str, ...]) -> None:
        self._mechanism, self._pins, self._reached = mechanism, pins, reached
        self.cycles = reached.cycle
        self.outcome = reached.outcome
        self.interrupted = reached.interrupted
        self.simulated = reached.simulated
        self._foundations = {pin.joint: pin.bed for pin in pins}
        self._notes = notes

    # ---------------------------------------------------------------- what has worn
    @property
    def joints(self) -> tuple[str, ...]:
        """Joints that wear."""
        return tuple(pin.joint for pin in self._pins)

    def profile(self, joint: str) -> Profile:
        """Both worn surfaces of a joint.  Raises UnknownName."""
        n, pin = self._place(joint)
        depths = self._reached.depths[n]
        lost = self._reached.per_cycle[n] if self._reached.per_cycle else np.zeros_like(depths)
        angle = np.array((np.arange(pin.bins) + 0.5) * (2.0 * math.pi / pin.bins), dtype=np.float64)
        sides = (
            Side(angle.copy(), h.copy(), float(h.sum()) * pin.area, float(h.max()), loss.copy())
            for h, loss in zip(depths, lost, strict=True)
        )
        return Profile(*sides)

    def radius(self, joint: str) -> float:
        """Radius of the bush of a joint [m].  Raises UnknownName."""
        return self._place(joint)[1].radius

    def _place(self, joint: str) -> tuple[int, Pin]:
        if joint not in self.joints:
            raise UnknownName(f"no joint {joint!r} wears{suggest(str(joint), self.joints)}")
        n = self.joints.index(joint)
        return n, self._pins[n]

    @property
    def history(self) -> DataFrame:
        """pandas.DataFrame, one row per jump: cycle, jump, error, and of every side volume [m^3] and depth [m].

        Raises MissingPackage.
        """
        return package("pandas", "a table of wear").DataFrame(self.columns)

    @property
    def columns(self) -> dict[str, Array]:
        """The columns of `history` as arrays."""
        rows = np.array(self._reached.rows)
        columns = {"cycle": rows[:, 0], "jump": rows[:, 1], "error": rows[:, 2]}
        for n, pin in enumerate(self._pins):
            for side, name in enumerate(SIDES):
                at = 4 + 4 * n + 2 * side
                columns[f"{pin.joint}.{name}.volume"] = rows[:, at] * pin.area
                columns[f"{pin.joint}.{name}.depth"] = rows[:, at + 1]
        return columns

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism with its worn surfaces, for every other analysis."""
        changes: dict[str, Any] = {}
        for joint, depths in as_documents(self._pins, self._reached.depths).items():
            wear = self._mechanism._document["joints"][joint]["wear"]
            left = {key: value for key, value in wear.items() if key not in ("profile", "depths")}
            if "layer" not in left:
                left["foundation"] = self._foundations[joint]
            changes[f"joints.{joint}.wear"] = {**left, "depths": depths}
        return self._mechanism.set(changes)

    # ---------------------------------------------------------------- in words
    def deepest_after(self, joint: str, side: str, cycles: float) -> float:
        """Largest depth [m] of a side after so many cycles; beyond the last one at the rate of the last jump."""
        cycle, depth = self.columns["cycle"], self.columns[f"{joint}.{side}.depth"]
        if cycles <= cycle[-1] or len(cycle) < 2:
            return float(np.interp(cycles, cycle, depth))
        rate = (depth[-1] - depth[-2]) / (cycle[-1] - cycle[-2])
        return float(depth[-1] + rate * (cycles - cycle[-1]))

    def band(self, joint: str, side: str) -> tuple[float, float]:
        """Largest depth [m] of a side for coefficients half as large and half as large again as those given.

        Where both surfaces scale alike, k enters only with the number of cycles.
        """
        low, high = (self.deepest_after(joint, side, (1.0 + s * SCATTER) * self.cycles) for s in (-1.0, 1.0))
        return low, high

    @property
    def limiting(self) -> tuple[str, str]:
        """Joint and side that will first be worn through, or, without walls, whose depth is the largest clearance."""

        def life(surface: tuple[Pin, str]) -> float:
            pin, side = surface
            depth = self.columns[f"{pin.joint}.{side}.depth"]
            limit = pin.wall if math.isfinite(pin.wall) else pin.clearance
            return -float(depth[-1]) / limit

        pin, side = min(((pin, side) for pin in self._pins for side in SIDES), key=life)
        return pin.joint, side

    @property
    def trust(self) -> tuple[str, ...]:
        """What to know before these numbers are used."""
        rows = np.array(self._reached.rows)[1:]
        notes = []
        for pin in self._pins:
            for side in SIDES:
                low, high = self.band(pin.joint, side)
                if high > 0.0:
                    notes.append(
                        f"{pin.joint}, {side}: coefficients of wear scatter by half even in one laboratory; over"
                        f" k -50 % ... +50 % its largest depth is {_length(low)} ... {_length(high)}"
                    )
        if len(rows):
            notes.append(
                f"{len(rows)} jump{'s' * (len(rows) != 1)} of {rows[:, 1].min():.4g} to {rows[:, 1].max():.4g} cycles,"
                f" {self.simulated} cycles simulated; largest error of a jump {100 * rows[:, 2].max():.2g} %"
                " of the depth"
            )
            if rows[:, 3].max() > 0.0:
                notes.append(f"smoothing changed depths by up to {_length(float(rows[:, 3].max()))} in a jump")
        return (*notes, *self._notes)

    def __str__(self) -> str:
        outcome = self.outcome or (
            "stopped by the user; the same call goes on in its folder" if self.interrupted else ""
        )
        lines = [f"wear after {self.cycles:.6g} cycles ({outcome})"]
        for pin in self._pins:
            for side, surface in zip(SIDES, self.profile(pin.joint), strict=True):
                if surface.deepest > 0.0:
                    where = _angle(float(surface.angle[surface.depth.argmax()]))
                    lines.append(
                        f"  {pin.joint:12s} {side:5s} {_volume(surface.volume):>15s}   deepest"
                        f" {_length(surface.deepest)} ({surface.deepest / pin.clearance:.3g} clearances) at {where}"
                    )
        joint, side = self.limiting
        lines.append(f"life is limited by the {side} of {joint}")
        return "\n".join([*lines, *(f"- {note}" for note in self.trust)])

    def _repr_html_(self) -> str:
        rows = []
        for pin in self._pins:
            for side, surface in zip(SIDES, self.profile(pin.joint), strict=True):
                where = _angle(float(surface.angle[surface.depth.argmax()]))
                deep = (_length(surface.deepest), f"{surface.deepest / pin.clearance:.3g}", where)
                volume = _volume(surface.volume)
                rows.append((pin.joint, side, volume, *(deep if surface.deepest > 0.0 else ("-", "-", "-"))))
        head = ("joint", "side", "volume worn", "deepest", "in clearances", "at")
        title, *rest = str(self).splitlines()
        return table(head, rows, title, [line for line in rest if not line.startswith("  ")], "w.plot()")

    def __repr__(self) -> str:
        return f"<rattle.Worn: {', '.join(self.joints)} after {self.cycles:.6g} cycles>"

    def plot(self, joint: str | None = None) -> Figure:
        """Polar map of a joint's profiles, their depth exaggerated; volume and depth against cycles.

        joint: default the one that limits life.  Raises UnknownName.
        """
        from rattle.questions.wear.pictures import plot_worn

        return plot_worn(self, joint if joint is not None else self.limiting[0])


def _length(metres: float) -> str:
    return quantity(metres, "m", usual="um" if metres < 1e-3 else "mm")


def _volume(cubic_metres: float) -> str:
    return quantity(cubic_metres, "m^3", usual="mm^3")


def _angle(radians: float) -> str:
    return f"{math.degrees(radians):.1f} deg" if chosen("rad") is None else quantity(radians, "rad")
