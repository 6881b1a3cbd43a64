"""How far a result can be trusted: what was checked, in numbers and in words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field

import numpy as np
from numpy.typing import NDArray

from rattle.results.display import card, marks
from rattle.value_types import Json, Tree
from rattle.wrong_arguments import answers_in_words

Array = NDArray[np.float64]
LOOSE = 1e-6  # drift over the size of the mechanism, and share of the energy, above which a solution is loose
POOR = 1e-3  # share of the energy that nothing accounts for, above which a run is not trusted at all
FEW = 6  # steps in the shortest contact below which its forces are coarse
HOW = " (horizon=True does)"  # what computes the horizon, for those who write Python; pages leave it out
SENTENCES = {  # of `word`, of locks and of contacts: pages say the same of the runs that they compute
    "before_a_pull": "trusted up to t = {t:.3g} s: {links}",
    "from_a_pull_on": "not to be trusted: {links}",
    "unknown": "how far it can be trusted was not computed",
    "unaccounted": "not to be trusted: {percent:.2g} % of the energy is unaccounted for",
    "before_a_lock": "trusted up to t = {t:.4g} s, {lock}",
    "before_the_end": "trusted up to where the run ended, t = {t:.4g} s",
    "whole": "trusted over the whole run",
    "motion": "positions and rates trusted {reach}, all other curves up to t = {t:.3g} s, statistics after it",
    "over_all": "over the whole run",
    "up_to": "up to t = {t:.3g} s",
    "horizon": "trusted up to t = {t:.3g} s, after it statistics only",
    "but_not": "{verdict}, but not {excepted}",
    "in_no_case": "{verdict}; in no case {excepted}",
    "unread": "the largest forces of {joints}",
    "singular": "the forces at singular positions (t = {times} s)",
    "lock": "where friction nearly locks {joint}",
    "reach_of_lock": "the curves can be trusted up to t = {t:.4g} s, {lock}",
    "no_contact": "no contact in the whole run",
    "shortest": "{counts}, the shortest contact took {steps}",
    "coarse": ": too few for its peak, tighten rtol",
    "nonunique": "reactions not unique (redundant constraints) at {joints}",
}
WORTH_SAYING = 1e-6  # share of the largest energy above which an energy error is told as a share too


@answers_in_words
@dataclass(frozen=True, eq=False, repr=False)
class Trust:
    """How far a result can be trusted, units as stated at each field; `str()` says it in a few lines."""

    drift: float  # largest distance between points that belong together [m]
    drift_joint: str = ""  # joint where the drift is largest
    energy_balance: float = math.nan  # largest unexplained change of energy [J]; NaN where there is no audit
    t_end: float = 0.0  # last instant of the run [s]
    horizon: float | None = None  # time up to which a tighter run agrees [s]; None: not computed
    pulled: Mapping[str, float] = field(default_factory=dict)  # massless-link joint -> share of time with N < 0
    first_pull: Mapping[str, float | None] = field(default_factory=dict)  # ... -> first such time [s]
    intervals: Mapping[str, Array] = field(default_factory=dict)  # ... -> (k, 2) times with N < 0 [s]
    contacts: int | None = None  # contacts that started; None: no joint can make and lose contact
    impacts: int = 0  # impacts without duration
    fewest_steps: float | None = None  # steps in the shortest contact
    nonunique: tuple[str, ...] = ()  # joints whose reactions are not unique
    notes: tuple[str, ...] = ()
    elastic: Mapping[str, tuple[float, float]] = field(default_factory=dict)  # rigid joint -> peaks of elastic ones [N]
    bushes: Mapping[str, str] = field(default_factory=dict)  # ... -> which bushes, in words
    unread: tuple[
        str, ...
    ] = ()  # joints whose largest force says nothing of a real one, see `contact_summary.readable`
    singular: tuple[float, ...] = ()  # instants at which singular positions were passed [s]
    gaps: tuple[tuple[float, float], ...] = ()  # from when to when forces are left out beside them [s]
    drift_angle: float = 0.0  # largest angle between bodies that belong together [rad]
    stopped: bool = False  # the run ended before its end time
    horizon_motion: float | None = None  # time up to which positions and rates agree [s]
    horizon_curve: str = ""  # the curve that deviates first
    locked: str = ""  # joint that friction nearly locks at `horizon`, which ends there for that reason
    energy_share: float | None = None  # the same change as a share of the largest of kinetic energy, work and potential

    def __repr__(self) -> str:
        return f"<rattle.Trust: {self._accuracy()}; {self._reach()}>"

    def _repr_html_(self) -> str:
        marked = [("good", sentence) for sentence in self.holds()] + [("bad", sentence) for sentence in self.doubts()]
        return card("How far to trust it", marks([*marked, *(("note", sentence) for sentence in self.notes)]))

    def __str__(self) -> str:
        remarks = self.remarks()
        first = f"{self._accuracy()}; {self._reach()}"
        return f"{first}\n{remarks}" if remarks else f"{self._accuracy()}\n{self._reach()}"

    @property
    def word(self) -> str:
        """The answer in one line: trusted, or not, and how far; `why` has the reasons."""
        verdict = self._verdict()
        if not self._excepted() or verdict.startswith(("trusted", "positions")):
            return self._with_exceptions(verdict)
        return _say("in_no_case", verdict=verdict, excepted=self._excepted())

    @property
    def why(self) -> tuple[str, ...]:
        """The reasons of `word`, in sentences: what agrees, how well the equations were solved, and all remarks."""
        reasons = (self._pulling(), *self._remarks())
        return (self._reach(), self._accuracy(), *(reason for reason in reasons if reason and reason not in self.word))

    @property
    def excepts(self) -> bool:
        """True if something is not to be trusted within the time that `word` tells, or trust ends at a lock."""
        return bool(self._excepted() or self.locked)

    def trusted_until(self) -> float | None:
        """Last instant up to which curves can be trusted [s]: of the horizon, and before any link pulls.

        None: the horizon was not computed.
        """
        if self.horizon is None:
            return None
        first = [t for j, t in self.first_pull.items() if t is not None and self.pulled.get(j, 0.0) > 0.0]
        return min([self.horizon, *first])

    def _verdict(self) -> str:
        pulling = {j: self.first_pull.get(j) or 0.0 for j, share in self.pulled.items() if share > 0.0}
        until = self.trusted_until()
        if pulling and (until is None or min(pulling.values()) <= until):
            first = min(pulling.values())
            return _say("before_a_pull" if first else "from_a_pull_on", t=first, links=self._links())
        if until is None:
            return _say("unknown") + HOW
        if self.poor:
            return _say("unaccounted", percent=100 * (self.energy_share or 0.0))
        if self.locked:
            return _say("before_a_lock", t=until, lock=self._lock())
        if self.stopped and (until >= self.t_end or not self.horizon_curve):
            return _say("before_the_end", t=self.t_end)
        return self._verdict_of_horizon(until)

    def _verdict_of_horizon(self, until: float) -> str:
        """How far curves, and beyond them the motion as a whole, are to be trusted; until: [s]."""
        motion = self.horizon_motion
        if until >= self.t_end:
            return _say("whole")
        if motion is None or not motion > 2.0 * until:
            return _say("horizon", t=until)
        return _say("motion", reach=_say("over_all") if motion >= self.t_end else _say("up_to", t=motion), t=until)

    @property
    def poor(self) -> bool:
        """True if nothing accounts for so much of the energy that the run is not trusted at all."""
        return (self.energy_share or 0.0) > POOR

    def _with_exceptions(self, verdict: str) -> str:
        """A verdict with what is not trusted within its time."""
        return _say("but_not", verdict=verdict, excepted=self._excepted()) if self._excepted() else verdict

    def _excepted(self) -> str:
        """What is not trusted within that time, in words."""
        exceptions = [_say("unread", joints=", ".join(self.unread))] if self.unread else []
        if self.singular:
            times = ", ".join(f"{t:.4g}" for t in self.singular[:3]) + (", ..." if len(self.singular) > 3 else "")
            exceptions.append(_say("singular", times=times))
        return " and ".join(exceptions)

    def holds(self, size: float = 1.0) -> tuple[str, ...]:
        """What was checked and is well, in sentences; size: of the mechanism [m], which a drift is compared with."""
        sentences = [] if self._loosely_solved(size) else [f"the equations were solved well: {self._accuracy()}"]
        if not self._excepted() and self._reaches_the_end() and not self.stopped:
            sentences.append(self._reach())
        if self.pulled and not any(self.pulled.values()):
            sentences.append(self._links())
        if self._touching() and not self.coarse():
            sentences.append(self._touching())
        return tuple(sentences)

    def doubts(self, size: float = 1.0) -> tuple[str, ...]:
        """What cannot be vouched for, in sentences; empty if there is nothing.  size: as in `holds`.

        The notes of the run, which may be harmless, are in `notes`.
        """
        sentences = [f"the run ended early, at t = {self.t_end:.4g} s"] if self.stopped else []
        if self._loosely_solved(size):
            sentences.append(
                f"the equations were solved loosely, a smaller tolerance or step helps: {self._accuracy()}"
            )
        if self.stopped or not self._reaches_the_end():
            sentences.append(self._reach())
        if any(self.pulled.values()):
            sentences.append(self._links())
        sentences += self.coarse()
        if self._excepted():
            sentences.append(f"not to be trusted: {self._excepted()}")
        if self.nonunique:
            sentences.append(
                f"the reactions of {', '.join(self.nonunique)} are not unique, as constraints are redundant"
            )
        return tuple(sentences)

    def _loosely_solved(self, size: float) -> bool:
        off = max(self.drift / size, self.drift_angle, self.energy_share or 0.0)
        return not off <= LOOSE

    def _reaches_the_end(self) -> bool:
        return self.horizon is not None and self.horizon >= self.t_end

    def remarks(self) -> str:
        """Links that would have to pull, contacts, and all else that must be said, in one line; "" if nothing."""
        return "; ".join(sentence for sentence in (self._pulling(), *self._remarks()) if sentence)

    def _accuracy(self) -> str:
        where = f" (worst at {self.drift_joint})" if self.drift_joint and self.drift > 0 else ""
        energy = "" if math.isnan(self.energy_balance) else f", energy error {_short(abs(self.energy_balance))} J"
        off = self.energy_share or 0.0
        share = f" ({_short(off)} of the largest energy)" if off > WORTH_SAYING else ""
        angle = f" and {_short(self.drift_angle)} rad" if self.drift_angle > self.drift else ""
        return f"constraint error {_short(self.drift)} m{angle}{where}{energy}{share}"

    def _reach(self) -> str:
        if self.horizon is None:
            return f"how long the curves can be trusted was not computed{HOW}"
        if self.t_end == self.horizon == 0.0 and not self.stopped:  # one position: no time in which errors could grow
            return "the curves can be trusted at t = 0 s"
        whole = f"up to where the run ended, t = {self.t_end:.4g} s"
        if not self.stopped:
            whole = f"over the whole run, to t = {self.t_end:.4g} s"
        agree = self.horizon >= self.t_end or (self.stopped and not self.horizon_curve and not self.locked)
        if agree and self.horizon > 0.0:
            return f"the curves can be trusted {whole}"
        if self.locked:
            return _say("reach_of_lock", t=self.horizon, lock=self._lock())
        motion = self.horizon_motion
        if motion is not None and motion > 2.0 * self.horizon:
            until = whole if motion >= self.t_end else f"up to t = {motion:.3g} s (horizon)"
            first = f" ({self.horizon_curve} deviates first)" if self.horizon_curve else ""
            return f"positions and rates can be trusted {until}, all other curves up to t = {self.horizon:.3g} s{first}"
        return f"the curves can be trusted up to t = {self.horizon:.3g} s (horizon), after it statistics only"

    def _lock(self) -> str:
        return _say("lock", joint=self.locked)

    def coarse(self) -> tuple[str, ...]:
        """The remark for a shortest contact with too few steps; empty if there were enough."""
        if self.fewest_steps is None or self.fewest_steps >= FEW:
            return ()
        return (f"the shortest contact took {_steps(self.fewest_steps)}{_say('coarse')}",)

    def _touching(self) -> str:
        """Contacts and impacts, in words; empty if no joint can make and lose contact."""
        if self.contacts is None:
            return ""
        counts = [
            f"{n} {what}{'s' if n != 1 else ''}"
            for n, what in ((self.contacts, "contact"), (self.impacts, "impact"))
            if n
        ]
        if not counts:
            return _say("no_contact")
        if self.fewest_steps is None:
            return " and ".join(counts)
        coarse = _say("coarse") if self.fewest_steps < FEW else ""
        return _say("shortest", counts=" and ".join(counts), steps=_steps(self.fewest_steps)) + coarse

    def _pulling(self) -> str:
        return "; ".join(sentence for sentence in (self._links(), self._touching()) if sentence)

    def _links(self) -> str:
        pulling = sorted((j for j, share in self.pulled.items() if share > 0), key=lambda j: -self.pulled[j])
        if not self.pulled:
            return ""
        if not pulling:
            return f"{' and '.join(self.pulled)} would never have to pull: the pin stays on its bush all the time"
        clauses = [
            f"{j} {'would have to pull ' if n == 0 else ''}{self._how_much(j)}" for n, j in enumerate(pulling[:3])
        ]
        more = [f"{len(pulling) - 3} more pins"] if len(pulling) > 3 else []
        pin = "the pin" if len(pulling) == 1 else "these pins"
        return f"{', and '.join(clauses + more)}: {pin} would lift off; this model does not hold there"

    def _how_much(self, joint: str) -> str:
        share, first = 100 * self.pulled[joint], self.first_pull.get(joint)
        part = f"for {share:.0f} % of the run" if share >= 1 else "for less than 1 % of the run"
        return part if first is None else f"{part}, first at t = {first:.4g}{' s' if first else ''}"

    def _remarks(self) -> list[str]:
        joints = ", ".join(self.nonunique)
        return ([_say("nonunique", joints=joints)] if joints else []) + list(self.notes)

    def to_dict(self) -> dict[str, Json]:
        """All fields as numbers (SI), texts and lists, ready for JSON."""
        return asdict(self) | {"intervals": {j: np.asarray(v).tolist() for j, v in self.intervals.items()}}

    @classmethod
    def from_dict(cls, record: Tree) -> Trust:
        """The inverse of `to_dict`; units as of the fields."""
        intervals = {j: np.asarray(v, float).reshape(-1, 2) for j, v in record["intervals"].items()}
        texts = {key: tuple(record[key]) for key in ("nonunique", "notes", "singular", "unread") if key in record}
        gaps = tuple((float(since), float(until)) for since, until in record.get("gaps", ()))
        return cls(**{**record, **texts, "intervals": intervals, "gaps": gaps})


def _say(sentence: str, **values: float | str) -> str:
    return SENTENCES[sentence].format(**values)


def _steps(count: float) -> str:
    return f"{count:.0f} step{'s' if round(count) != 1 else ''}"


def _short(value: float) -> str:
    return f"{value:.1g}".replace("e-0", "e-")
