"""What contacts and joints that rub do at one instant of a motion with its derivatives; see `contacts`.

Each change goes on from the state after it, with what the change of its instant does to the derivatives.  Forces may
jump with it: rigid contacts that last, and joints that rub, are decided anew, together, until all modes fit.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from rattle.analyses.straight_line.lane_model import pulsates
from rattle.equations.state import LOSS, STORED, state_layout
from rattle.questions.sensitivity.functions import Functions, Rates
from rattle.questions.sensitivity.motion import Motion
from rattle.questions.sensitivity.touching import Blow, Touching, Watched
from rattle.solvers.nonsmooth.impacts import LOW, NOTICED
from rattle.trace.lane_control import SHORT
from rattle.trace.lane_turns import STUCK
from rattle.trace.recorded_rigid import DECIDES, HITS, MOST_SLOTS, SLOTS

GRAZES = 1e-3  # share of the largest |g'| since the contact before, below which a contact only grazes
MOST_MODES = 30  # of joints that rub, one after the other at one instant
MOST_CHANGES = 12  # of them beside rigid contacts, before all are tried
CROWDED = "more rigid contacts take part at one instant than derivatives follow"
NOT_OPEN = 1e-12  # [m or rad] by which a contact may be shut at the start


@dataclass
class Met:
    """One contact, with its derivatives by the parameters (k,)."""

    joint: str
    time: float  # [s]
    by_time: np.ndarray
    speed: float  # [m/s or rad/s]
    by_speed: np.ndarray
    peak: float = math.nan  # [N or N m]; nan of a rigid one
    by_peak: np.ndarray = field(default_factory=lambda: np.zeros(0))


class Events(Motion):
    """`Motion` of a mechanism whose contacts begin and end, at one instant; `met` is the list of them."""

    def __init__(
        self, functions: Functions, touching: Touching, z: np.ndarray, t_eval: np.ndarray, rtol: float, atol: float
    ) -> None:
        super().__init__(functions, z, t_eval, rtol, atol)
        self.touching = touching
        self.met: list[Met] = []
        self.notes: list[str] = []
        self.grazed = math.inf  # instant from which on derivatives are not defined [s]
        self._fastest = np.zeros(touching.rows)  # largest |g'| since the contact before
        self._open: dict[int, Met] = {}  # contacts that last
        self._let: dict[int, float] = {}  # instants at which forces of compliant contacts ended [s]
        self._pulsates = pulsates(functions.model.system.model)

    def _look(self, t: float, z: np.ndarray, rates: Rates) -> Watched:
        return self.touching.watched(t, z, rates.values[:, 0])

    def _bears(self) -> bool:
        return self.touching.rubbing is not None or bool((self.touching.shut & self.touching.rigid).any())

    def _follow_switch(self, shift: np.ndarray) -> bool:
        before = self.touching.modes
        self._seen = self._look(self.t, self.z, self._rates)
        self._follow_forces(shift)
        self._limit_steps()
        return not np.array_equal(before, self.touching.modes)

    def _follow_forces(self, shift: np.ndarray) -> None:
        """Forces have jumped: rigid contacts that last, and joints that rub, may go on otherwise."""
        touching = self.touching
        those = np.flatnonzero(touching.shut & touching.rigid).tolist()
        self._settle(those, touching.slide.copy(), shift)

    def _limit_steps(self) -> None:
        """While a body rests steps grow, whatever loads do that change with time."""
        touching = self.touching
        rests = (touching.shut & touching.rigid).any()
        rests |= touching.rubbing is not None and (np.abs(touching.rubbing.modes) != 1.0).any()
        self._longest = self.t_end / SHORT if rests and self._pulsates else math.inf

    def _go_on(self, z: np.ndarray, along: np.ndarray, shift: np.ndarray) -> None:
        """Go on from z; along: how the state after changes with the instant of the change, before it is taken off."""
        z = z.copy()
        self.functions.still[:] = False
        rates = self.functions.rates(self.t, z)
        z[:, 1:] += (along - rates.values[:, 0])[:, None] * shift
        z, sound = self.functions.projected(self.t, z)
        self.z, self._rates = z, self.functions.rates(self.t, z)
        if not (sound and self._rates.sound):
            beside = "next to a singular position or to the end of a segment"
            self.message = f"stopped at t = {self.t:.6g} s: a contact begins or ends {beside}"
            return
        self._seen = self._look(self.t, self.z, self._rates)

    # ---------------------------------------------------------------- begins and ends
    def _note_start(self, n: int, shift: np.ndarray, speed: float, by_speed: np.ndarray, closes: bool = True) -> Met:
        """Note that contact n begins; closes: its gap does."""
        joint, closes = self.touching.joints[n], closes and not self.touching.level[n]
        if closes and speed < GRAZES * self._fastest[n] and self.grazed == math.inf:
            self.grazed = self.t
            self.notes.append(
                f"contact {self._number(joint)} of {joint} grazes at t = {self.t:.6g} s: derivatives from there on are"
                " not defined"
            )
        met = Met(joint, self.t, shift, speed, by_speed)
        if not self.touching.rigid[n] or self.touching.level[n]:
            met.peak, met.by_peak = 0.0, np.zeros_like(shift)
        self.met.append(met)
        self._fastest[n] = 0.0
        return met

    def _number(self, joint: str) -> int:
        return 1 + sum(met.joint == joint for met in self.met)

    def _start(self, n: int, shift: np.ndarray) -> None:
        """A compliant contact begins."""
        seen, before = self._seen, self._rates.values[:, 0]
        speed, by_speed = -float(seen.rate[n]), -seen.by_rate[n] - seen.rate_in_time[n] * shift
        if self.touching.level[n]:  # its rate may have jumped
            jumped = seen.gap[n] < -NOT_OPEN
            speed = -float(seen.gap[n]) if jumped else 0.0
            by_speed = -seen.by_gap[n] - seen.rate[n] * shift if jumped else np.zeros_like(shift)
        self._open[n] = self._note_start(n, shift, speed, by_speed)
        self.touching.set(n, True, speed, by_speed)
        self._go_on(self.z, before, shift)

    def _end(self, n: int, shift: np.ndarray) -> None:
        z, before = self.z.copy(), self._rates.values[:, 0].copy()
        account = state_layout(self.functions.model.system).account(n).start
        for array in (z, before):  # what is still stored is lost
            array[account + LOSS] += array[account + STORED]
            array[account + STORED] = 0.0
            array[self.touching.states(n)] = 0.0
        self.touching.set(n, False)
        self.touching.released[n] = self.touching.are.by_force[n]
        self._let[n] = self.t
        self._open.pop(n, None)
        self._fastest[n] = abs(self._seen.rate[n])
        self._go_on(z, before, shift)

    # ---------------------------------------------------------------- rigid contacts
    def _collide(self, hit: list[int], shift: np.ndarray) -> None:
        """An impact of rigid contacts, in which those that last take part."""
        touching, seen = self.touching, self._seen
        held = np.flatnonzero(touching.rigid & (touching.shut | touching.level)).tolist()  # rates of clutches jump
        drove = touching.shut & touching.level
        codes = dict.fromkeys(sorted({*hit, *held}), HITS)
        blow = self._struck(codes)
        if not self._is_sound(blow, hit, "the impact in {} has no solution, or several"):
            return
        hardest = max(blow.impulse.values())
        noticed = [n for n in codes if blow.impulse[n] > NOTICED * hardest]
        for n in codes:
            if n in noticed and not touching.level[n]:
                here = n in hit
                by_speed = -seen.by_rate[n] - seen.rate_in_time[n] * shift if here else np.zeros_like(shift)
                self._note_start(n, shift, -float(seen.rate[n]) if here else 0.0, by_speed, here)
            touching.set(n, False)
            self._fastest[n] = 0.0
        self._go_on(blow.z, blow.along, shift)
        if touching.rubbing is not None and not self.message:
            self._rub(self._moving(), shift)
        if self.message:
            return
        leaving = touching.leaving(self.t, self.z)
        stay = [n for n in codes if leaving[n].low(LOW * touching.are.scale[n])]
        if stay:
            self._press(stay, shift, STUCK * float(-seen.rate[hit].min()))
        if not self.message:
            self._note_locks(drove, shift, noticed)
            self._engage(shift)

    def _struck(self, codes: Mapping[int, float]) -> Blow:
        """What rigid contacts do that hit, joints that rub in modes that agree with it."""
        touching, before = self.touching, self._rates.values[:, 0]
        if touching.rubbing is None:
            return touching.struck(codes, self.t, self.z, before)
        touching.rub(self._moving())
        others, changes = self._combinations(), 0
        while True:
            blow = touching.struck(codes, self.t, self.z, before)
            if blow.agreed == 1.0 or blow.sound != 1.0:
                return blow
            changes += 1
            modes = blow.rubs if blow.agreed == 0.0 and changes < MOST_CHANGES else next(others, None)
            if modes is None:
                return blow._replace(sound=0.0)
            touching.rub(np.where(blow.free, modes, touching.rubbing.modes))

    def _press(self, those: list[int], shift: np.ndarray, slow: float) -> None:
        """Rigid contacts that were open press from here on, or let go; slow: slip [m/s] that is none."""
        for n, leaving in self.touching.leaving(self.t, self.z).items():
            if n in those:
                self.touching.slide[n] = math.copysign(1.0, leaving.slip) if abs(leaving.slip) > slow else 0.0
        self._settle(those, self.touching.slide.copy(), shift)

    def _note_locks(self, before: np.ndarray, shift: np.ndarray, struck: Sequence[int] = ()) -> None:
        """Note that clutches drive, or have been struck, that did not drive before (n,)."""
        touching = self.touching
        for n in np.flatnonzero(touching.level & touching.rigid & ~before).tolist():
            if touching.shut[n] or n in struck:
                met = self._note_start(n, shift, 0.0, np.zeros_like(shift))
                if touching.shut[n]:
                    self._open[n] = met

    def _engage(self, shift: np.ndarray) -> None:
        """Elastic and viscous clutches drive, or let go, whose rates have jumped, or are what they are at the start."""
        touching, seen = self.touching, self._seen
        soft = touching.level & ~touching.rigid
        behind = (seen.gap < -NOT_OPEN) | ((np.abs(seen.gap) <= NOT_OPEN) & (seen.rate < 0.0))
        for n in np.flatnonzero(soft & ~touching.shut & behind).tolist():
            self._start(n, shift)
        for n in np.flatnonzero(soft & touching.shut & (seen.gap > NOT_OPEN) & (seen.normal < 0.0)).tolist():
            self._end(n, shift)

    def _change(self, hit: list[int], shift: np.ndarray) -> None:
        """Rigid contacts let go, begin to slip or cease to; clutches may lock."""
        touching = self.touching
        broken, drove = touching.broken(self.t, self.z), touching.shut & touching.level
        locks = [row for row in hit if touching.level[row] and not touching.shut[row]]
        for row in hit:
            if row in locks:
                continue
            if row < touching.contacts:
                self._fastest[row] = abs(self._seen.rate[row])
                touching.set(row, False)
                touching.released[row] = True
            else:
                n = int(touching.rough[row - touching.slides])
                touching.set(n, True, 0.0 if touching.slide[n] != 0.0 else broken[n])
        self._hold_at_rest([row for row in hit if row < touching.contacts and row not in locks], shift)
        those = sorted([*np.flatnonzero(touching.shut & touching.rigid).tolist(), *locks])
        if those or touching.rubbing is not None:
            self._settle(those, touching.slide.copy(), shift)
        else:
            self._go_on(self.z, self._rates.values[:, 0], shift)
        self._note_locks(drove, shift)

    def _hold_at_rest(self, let_go: list[int], shift: np.ndarray) -> None:
        """Joints that contacts have held at rest stick first, as these let go."""
        if self.touching.rubbing is None or not let_go or self.message:
            return
        modes = np.where(self._moving() == 0.0, 0.0, self.touching.rubbing.modes)
        if not np.array_equal(modes, self.touching.rubbing.modes):
            self._go_on(self.z, self._rates.values[:, 0], shift)
            self._rub(modes, shift)

    def _decide(self, those: list[int], slide: np.ndarray, shift: np.ndarray) -> Blow:
        """Rigid contacts last from here on or let go, in the present modes of joints that rub."""
        touching = self.touching
        for n in those:
            touching.slide[n] = slide[n]
        blow = touching.struck(dict.fromkeys(those, DECIDES), self.t, self.z, self._rates.values[:, 0])
        words = "whether {} slips, sticks or lets go has no answer, or several"
        if self._is_sound(blow, those, words) and blow.agreed == 1.0:
            for n in those:
                touching.set(n, blow.shut[n], blow.slide[n])
            self._go_on(blow.z, blow.along, shift)
        return blow

    def _is_sound(self, blow: Blow, those: list[int], words: str) -> bool:
        """Whether what contacts do is known; a message if not, in words for their joints."""
        names = ", ".join(dict.fromkeys(self.touching.joints[n] for n in those))
        if blow.sound != 1.0:
            most = f"{SLOTS}" if blow.sound == -1.0 else f"{MOST_SLOTS}, of energetic and lzb restitution one"
            crowded = f"{names} and others: {CROWDED} ({most}); compare two runs with set()"
            why = crowded if blow.sound < 0.0 else words.format(names)
            self.message = f"stopped at t = {self.t:.6g} s: {why}"
        return blow.sound == 1.0

    # ---------------------------------------------------------------- joints that rub
    def _settle(self, those: list[int], slide: np.ndarray, shift: np.ndarray) -> None:
        """Rigid contacts last from here on, sticking or slipping, or let go, and joints that rub have modes in which
        they fit the forces at the present instant; slide: senses in which contacts slip."""
        others = self._combinations()
        for changes in itertools.count(1):
            blow = self._decide(those, slide, shift) if those else None
            if self.message or self.touching.rubbing is None or self._seen.rubbed is None:
                return
            modes = self._next_modes(self.touching.rubbing.settled(self._seen.rubbed), blow, changes, others)
            if modes is None:
                break
            if np.array_equal(modes, self.touching.rubbing.modes) and (blow is None or blow.agreed == 1.0):
                return
            self._rub(modes, shift)
            if self.message:
                return
        self.message = f"stopped at t = {self.t:.6g} s: joints that rub stick and slip to and fro there without end"

    def _next_modes(
        self, settled: np.ndarray, blow: Blow | None, changes: int, others: Iterator[np.ndarray]
    ) -> np.ndarray | None:
        """Modes (n,) of joints that rub to be tried next: those that forces lead to, `settled`, or beside contacts that
        find no answer in these, or after many changes, one combination after the other; None if there are no more."""
        if blow is None:
            return settled if changes <= MOST_MODES else None
        fits = blow.agreed == 1.0
        assert self.touching.rubbing is not None, "some rub"
        if fits and (changes < MOST_CHANGES or np.array_equal(settled, self.touching.rubbing.modes)):
            return settled
        moving, other = self._moving(), next(others, None)
        return None if other is None else np.where(moving != 0.0, moving, np.where(blow.free, other, settled))

    def _end_modes(self, hit: np.ndarray, shift: np.ndarray) -> None:
        """Joints that rub come to the ends of their modes."""
        seen, touching = self._seen, self.touching
        if len(hit) == 0:
            return
        assert touching.rubbing is not None, "some rub"
        assert seen.rubbed is not None
        modes = touching.rubbing.modes.copy()
        for n in (hit - touching.contacts).tolist():
            modes[n] = touching.rubbing.ended(n, seen.rubbed)
        self._rub(modes, shift)

    def _moving(self) -> np.ndarray:
        """(n,) the senses in which joints that rub slip at present; 0 of one that rests."""
        rubbed = self._seen.rubbed
        rates = [] if rubbed is None else [float(joint.rate) for joint in rubbed.joints]
        return np.asarray(np.sign(rates), dtype=float)

    def _combinations(self) -> Iterator[np.ndarray]:
        """All modes (n,) that joints that rub may have together, but those of one that rests at its limit."""
        return (np.array(modes) for modes in itertools.product((0.0, 1.0, -1.0), repeat=len(self._moving())))

    def _rub(self, modes: np.ndarray, shift: np.ndarray) -> None:
        """Joints have other modes from the present instant on; shift: how this changes with the parameters."""
        rubbing, before = self.touching.rubbing, self._rates.values[:, 0]
        assert rubbing is not None, "some rub"
        self.touching.rub(modes)
        self._go_on(*rubbing.rested(self.t, self.z, before), shift)
