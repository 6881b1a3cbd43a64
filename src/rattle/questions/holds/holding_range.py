"""The interval of values of one load that friction holds at rest, and what it means in words."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from rattle.results.display import lines
from rattle.value_types import Json

ROUNDING = 1e-9  # share of the largest value below which a value is zero
ALIKE = 1e-6  # [-] relative difference of factors on friction that are told as one
NEAR = 2.0  # factor on friction within which jamming is spoken of


@dataclass(frozen=True, repr=False)
class HoldingRange:
    """Values of one load for which friction in the joints holds the mechanism at rest, all other loads as they are.

    Beyond `high` it moves the way the load pushes when its value grows, below `low` the other way.
    """

    load: str  # name of the load, or "crank.torque" of a driver
    unit: str  # of its values; "" if they are multiples of the present load
    value: float  # the present one; nan of a driver
    low: float  # -inf if it jams
    high: float  # inf if it jams
    free: float  # the one that balances without friction
    jams_from: tuple[
        float, float
    ]  # multiples of all coefficients from which the load below, above jams; inf: beyond 100
    t: float  # [s]
    q: np.ndarray = field(repr=False)  # (3 nb,) x, y, angle of every body [m, m, rad]
    notes: tuple[str, ...] = ()  # what is left out

    @property
    def rests(self) -> bool:
        """True if the mechanism rests under the present value; of a driver: without its effort."""
        return self.low <= (0.0 if math.isnan(self.value) else self.value) <= self.high

    @property
    def self_locking(self) -> bool:
        """True if the other loads alone do not move the mechanism although they would without friction."""
        return self.low <= 0.0 <= self.high and abs(self.free) > ROUNDING * self._size

    @property
    def jams(self) -> bool:
        """True if the load jams in at least one sense: no value of it, however large, moves the mechanism that way."""
        return math.isinf(self.low) or math.isinf(self.high)

    @property
    def _size(self) -> float:
        return max((abs(value) for value in (self.low, self.high, self.free) if math.isfinite(value)), default=0.0)

    @property
    def _smooth(self) -> str:
        """The value that balances without friction, in words; "" if none does."""
        return "" if math.isnan(self.free) else f" ({self._said(self.free)} without friction)"

    def _said(self, value: float) -> str:
        value = 0.0 if abs(value) <= ROUNDING * self._size else value
        return f"{value:.6g} {self.unit}" if self.unit else f"{value:.6g} times"

    def __repr__(self) -> str:
        return f"<rattle.HoldingRange of {self.load}: {self.low:.6g} to {self.high:.6g} {self.unit or 'times'}>"

    def _repr_html_(self) -> str:
        return lines(str(self))

    def record(self) -> dict[str, Json]:
        """What JSON holds: values in `unit` (SI), no number where there is no bound, and what they mean."""
        numbers = {"low": self.low, "high": self.high, "free": self.free, "value": self.value}
        facts = {"rests": self.rests, "self_locking": self.self_locking, "jams": self.jams}
        return {
            "load": self.load, "unit": self.unit, **numbers, **facts, "jams_from": list(self.jams_from), "t": self.t,
            "notes": list(self.notes),
        }  # fmt: skip

    def __str__(self) -> str:
        if self.low == -math.inf and self.high == math.inf:
            sentences = [f"rests for every value of {self.load}{self._smooth}"]
        elif self.low == -math.inf:
            sentences = [f"rests for {self.load} up to {self._said(self.high)}{self._smooth}"]
        elif self.high == math.inf:
            sentences = [f"rests for {self.load} from {self._said(self.low)} on{self._smooth}"]
        else:
            ends = f"{self._said(self.low)} and {self._said(self.high)}"
            sentences = [f"rests for {self.load} between {ends}{self._smooth}"]
        if not math.isnan(self.value):
            side = (
                "" if self.rests else f": it moves, as the load is too {'large' if self.value > self.high else 'small'}"
            )
            now = f"now {self._said(self.value)}" if self.unit else "as it is"
            sentences.append(f"{now}{': it rests' if self.rests else side}")
        sentences += self._jamming()
        if self.self_locking:
            sentences.append(f"self-locking: it rests without {self.load}")
        elif abs(self.free) > ROUNDING * self._size:
            sentences.append(f"not self-locking: without {self.load} it moves")
        return "\n".join([*sentences, *(f"note: {note}" for note in self.notes)])

    def _jamming(self) -> list[str]:
        """Lines on the senses in which the load jams, or nearly does."""
        ways = {"": (self.high, self.jams_from[1]), " the other way": (self.low, self.jams_from[0])}
        up, down = ways.values()
        if math.isinf(up[0]) == math.isinf(down[0]) and math.isclose(up[1], down[1], rel_tol=ALIKE):
            ways = {", either way": up}
        sentences = []
        for way, (end, share) in ways.items():
            so = f"however large {self.load} is{way}"
            if math.isinf(end):
                since = f" (from {share:.4g} times this friction on)" if math.isfinite(share) else ""
                sentences.append(f"jams: {so}, it does not move{since}")
            elif share <= 1.0:
                sentences.append(
                    f"jams again farther out: {so}, it may not move (from {share:.4g} times this friction on)"
                )
            elif share <= NEAR:
                sentences.append(f"close to jamming: with {share:.4g} times the friction it would not move, {so}")
        return sentences
