"""Numbers and curves that others wrote, and how the same is measured here.

One file in `foreign/data/<source>/` for each case: a model in our words, numbers as their authors printed them, how far
ours may be off and why.  `foreign/sources.toml` says where they come from.  One list for two readers: the tests hold
every curve to its tolerance, the documentation shows what was measured.  The numbers are
as printed, or follow from a formula that the case names; none comes from this program.  Where theirs are wrong, ours
are held to what is `right`: a closed form, a slow integration of equations written anew, a limit of their own program,
or those of their numbers that are right.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import rattle as rt
from rattle.results.result import Result

Array = NDArray[np.float64]
FOLDER = Path(__file__).with_name("foreign")
EVENT, PEAK, FREQUENCY = "event:", "peak:", "frequency"  # names of what is no curve over time
AT_REST = ("equilibrium", "modes")
CLOSE = {"rtol": 1e-10, "atol": 1e-12}  # of runs that ask for nothing else: our own error is then below theirs


@dataclass(frozen=True)
class Source:
    """Who wrote the numbers: a program, a test set, a paper."""

    key: str
    name: str
    address: str
    commit: str  # or edition
    licence: str
    what: str  # which of its files hold numbers, and how they were computed
    kept: str  # what of it stands here


@dataclass(frozen=True)
class Curve:
    """One curve, or one number, of a case: `times` that of ours plus `plus` is theirs."""

    name: str  # of a result; "peak:NAME", "event:KIND" or "event:KIND:JOINT" (instants), "frequency" [Hz]
    theirs: str  # what they call it
    t: Array  # (n,) instants [s], or 1 to n
    values: Array  # (n,)
    tolerance: float  # in their unit
    why: str  # the reason for the tolerance
    unit: str = ""
    times: float = 1.0
    plus: float = 0.0
    wrong: str = ""  # why their numbers are not right: they are then off by more than the tolerance
    right: tuple[tuple[float, float, float], ...] = ()  # then: instants [s], what is right, how far ours may be off
    right_by: str = ""  # where that comes from

    @property
    def over_time(self) -> bool:
        """True of a curve that a result has; peaks, instants of events and frequencies are lists of numbers."""
        return not self.name.startswith((EVENT, PEAK, FREQUENCY))


class Compared(NamedTuple):
    """A curve and the same measured here."""

    curve: Curve
    measured: Array  # (n,) in their unit

    @property
    def difference(self) -> Array:
        """Ours minus theirs."""
        return self.measured - self.curve.values

    @property
    def largest(self) -> float:
        """Largest difference."""
        return float(np.abs(self.difference).max())

    @property
    def agrees(self) -> bool:
        """True where the largest difference is within the tolerance."""
        return self.largest <= self.curve.tolerance

    @property
    def as_claimed(self) -> bool:
        """True if they agree, or if they do not where the file says that the numbers are wrong, and ours are right."""
        if not self.curve.wrong:
            return self.agrees
        at = [np.flatnonzero(self.curve.t == t) for t, _, _ in self.curve.right]
        right = all(
            n.size and abs(self.measured[n[0]] - value) <= off
            for n, (_, value, off) in zip(at, self.curve.right, strict=True)
        )
        return right and bool(at) and not self.agrees


@dataclass(frozen=True)
class Case:
    """One mechanism with the numbers of one source."""

    key: str
    title: str
    source: Source
    file: str  # where the numbers stand in the source
    says: str  # what the source says of them
    model: str  # as a model file, written here
    curves: tuple[Curve, ...]
    analysis: str = "simulate"  # simulate | kinematics | inverse_dynamics | equilibrium | modes
    note: str = ""  # what had to be written in another way, what is wrong with the numbers
    options: Mapping[str, float | str] | None = None

    def __str__(self) -> str:
        return f"{self.source.key}/{self.key}"

    @cached_property
    def mechanism(self) -> rt.Mechanism:
        """The model."""
        return rt.loads(self.model)

    def run(self, more: Array | None = None) -> Result:
        """The result at all instants of its curves, and at more of them."""
        instants = [curve.t for curve in self.curves if curve.over_time]
        if not instants:
            instants = [np.array([0.0 if self.analysis in AT_REST else self.t_end])]
        t = np.unique(np.concatenate([*instants, *([] if more is None else [more])]))
        if self.analysis == "simulate":
            return self.mechanism.simulate(t_eval=t, strict=True, **(CLOSE | dict(self.options or {})))
        if self.analysis in AT_REST:
            return self.mechanism.equilibrium(t)
        return getattr(self.mechanism, self.analysis)(t, strict=True)

    @property
    def t_end(self) -> float:
        """The end of a run of which only events or peaks are asked."""
        return self.mechanism.model.settings.t_end

    @cached_property
    def compared(self) -> tuple[Compared, ...]:
        """All curves with what is measured here."""
        if self.analysis == "modes":
            frequencies = np.sort(np.asarray(self.mechanism.modes().frequency))
            return tuple(self._scaled(curve, frequencies[: len(curve.values)]) for curve in self.curves)
        result = self.run()
        return tuple(self._scaled(curve, measure(result, curve)) for curve in self.curves)

    @staticmethod
    def _scaled(curve: Curve, values: Array) -> Compared:
        return Compared(curve, curve.times * values + curve.plus)


def measure(result: Result, curve: Curve) -> Array:
    """What a curve asks of a result, in SI units."""
    if curve.name.startswith(EVENT):
        _, kind, *joint = curve.name.split(":")
        at = sorted(event.t for event in result.events if event.kind == kind and (not joint or event.joint in joint))
        return np.array(at[: len(curve.values)])
    if curve.name.startswith(PEAK):
        return np.array([result.peak(curve.name.removeprefix(PEAK))[0]])
    return np.asarray(result[curve.name])[np.searchsorted(result.t, curve.t)]


# ---------------------------------------------------------------- reading
def sources() -> dict[str, Source]:
    """All sources by their keys."""
    tables = tomllib.loads((FOLDER / "sources.toml").read_text(encoding="utf-8"))
    return {key: Source(key, **table) for key, table in tables.items()}


def read_case(path: Path, source: Source) -> Case:
    """One case.  Raises KeyError, TypeError or ValueError for a file that is not as the classes above say."""
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    shared = table.pop("t", None)
    curves = tuple(_read_curve(entry, shared) for entry in table.pop("curves"))
    return Case(path.stem, source=source, curves=curves, **table)


def _read_curve(entry: dict, shared: list[float] | None) -> Curve:
    values = np.array(entry.pop("values"), dtype=float)
    name = entry["name"]
    listed = name.startswith((EVENT, PEAK, FREQUENCY))
    t = np.array(entry.pop("t", np.arange(1, len(values) + 1) if listed else shared), dtype=float)
    if t.shape != values.shape or not len(t):
        raise ValueError(f"{name}: {t.size} instants, {values.size} values")
    unknown = set(entry) - {field.name for field in fields(Curve)}
    if unknown:
        raise ValueError(f"{name}: unknown keys {sorted(unknown)}")
    return Curve(t=t, values=values, **entry)


def read_cases() -> tuple[Case, ...]:
    """All cases, source by source in the order of the list of sources."""
    return tuple(
        read_case(path, source)
        for key, source in sources().items()
        for path in sorted((FOLDER / "data" / key).glob("*.toml"))
    )


CASES = read_cases()
