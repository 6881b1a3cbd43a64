"""A motion with contacts together with its derivatives by parameters: what each begin, end and impact does to them.

    g(t, y, p) = 0 at t*,  y+ = r(t, y-, p):    t*_p = -(g_y Y- + g_p)/(g_t + g_y f-)
    Y+ = r_y Y- + r_p + (r_t + r_y f- - f+) t*_p                                          (saltation)

A compliant contact begins with r = y, and its speed v0 = -g' is a constant of its laws from there on, with
v0_p = -(g'_y Y- + g'_p) - (dg'/dt) t*_p;  it ends where its gap opens, or its force does.  Rigid contacts hit, and go
on sticking, slipping or apart, as `trace.recorded_rigid` has it for lanes: r is its formula in the modes that fit.
While one sticks g is what is left of its friction, mu N - |T|; while it slips, its slip.  The largest force of a
contact changes as the force at that instant does.

Source: Ivanov, Stability of periodic motions with impacts, in: Impacts in Mechanical Systems, Springer (2000);
Leine, Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems (2004), chapter 7.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from rattle.analyses.straight_line.lane_model import pulsates
from rattle.equations.state import LOSS, STORED, state_layout
from rattle.jit import layout as at
from rattle.questions.sensitivity.functions import Functions, Rates
from rattle.questions.sensitivity.motion import BESIDE, RESTART, SAME, TOO_SHORT, Motion
from rattle.questions.sensitivity.step import Step
from rattle.questions.sensitivity.touching import Blow, Touching, Watched
from rattle.solvers.nonsmooth.impacts import LOW, NOTICED
from rattle.trace.lane_control import SHORT
from rattle.trace.lane_turns import STUCK
from rattle.trace.recorded_rigid import DECIDES, HITS, MOST_SLOTS, SLOTS

GRAZES = 1e-3  # share of the largest |g'| since the contact before, below which a contact only grazes
ALMOST = 0.1  # share of the gap at both ends of a step by which its least value may be in doubt
TRIES = 60  # of a landing by interpolation, before steps are halved
PEAK_ROUNDS = 40  # of the search for a largest force, by halves
MOST_MODES = 30  # of joints that rub, one after the other at one instant
MOST_TURNS = 60  # of contacts and joints at one instant
MOST_CHANGES = 12  # of them beside rigid contacts, before all are tried
CROWDED = "more rigid contacts take part at one instant than derivatives follow"
UNMOVED = 1e-10  # share of the run by which a change of a parameter, as large as it is, moves an instant by rounding
ROUNDED = 2e-15  # share of the size of the mechanism by which a gap may be rounding, or of 1 rad
NOT_OPEN = 1e-12  # [m or rad] by which a contact may be shut at the start


def _may_vanish(values: Sequence[float], falls: float, rises: float) -> bool:
    """Whether a curve that is not negative may be within a step, by its values at both ends and midway, and its slopes
    per step at the ends."""
    a, middle, b = values
    theta = np.linspace(0.0, 1.0, 65)
    cubic = a + theta * (falls + theta * ((3 * (b - a) - 2 * falls - rises) + theta * (2 * (a - b) + falls + rises)))
    least = min(a, b)
    return bool(least >= 0.0 and cubic.min() - 4.0 * abs(middle - cubic[32]) < min(0.0, ALMOST * least))


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


class ContactMotion(Motion):
    """`Motion` of a mechanism whose contacts begin and end; `met` is the list of them, in order of time."""

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
        self._pulsates = pulsates(functions.model.system.model)
        self._tries, self._turns, self._turned_at = 0, 0, -math.inf
        self._let: dict[int, float] = {}  # instants at which forces of compliant contacts ended [s]
        size = functions.model.system.extent
        angular = touching.functions.model.system.arrays["lever"][:, at.ANGULAR] > 0.0
        self._slight = np.zeros(touching.rows)  # sizes of gaps that may be rounding [m or rad]
        self._slight[: touching.contacts] = ROUNDED * np.where(angular, 1.0, size)

    def _begin(self) -> None:
        self.functions.start_energy(self.z)
        self._rates = self.functions.rates(self.t, self.z)
        self._seen = self._look(self.t, self.z, self._rates)
        if self._rates.sound:
            self._begin_to_touch(np.zeros(self.z.shape[1] - 1))
        if not self.message:
            super()._begin()

    def _begin_to_touch(self, still: np.ndarray) -> None:
        """Find the modes of joints that rub at the start, and contacts that are shut; still: (k,) zeros."""
        if self._seen.rubbed is not None:
            self._rub(self._moving(), still)
        if not self.message:
            self._engage(still)
        if not self.message:
            self._press_at_start()
        if self._seen.rubbed is not None and not self.message:
            self._follow_forces(still)
            self._limit_steps()
        if not self.message:
            self._rest_at_start(still)
        self._keep_jumps(still)

    def _rest_at_start(self, still: np.ndarray) -> None:
        """Rigid contacts that touch at the start press from there on; a message if that is not known."""
        touching, seen = self.touching, self._seen
        are, count = touching.are, touching.contacts
        shut = np.flatnonzero(seen.gap[:count] <= np.where(are.rigid, NOT_OPEN, -NOT_OPEN))
        shut = shut[((seen.gap[shut] < -NOT_OPEN) | (seen.rate[shut] <= 0.0)) & ~touching.shut[shut]]
        if len(shut) and self._rests(shut):
            self._press(shut.tolist(), still, 0.0)
            self._note_locks(np.zeros(touching.rows, dtype=bool), still)
            self._limit_steps()
        elif len(shut):
            does = "the clutch {} drives" if touching.level[shut[0]] else "bodies touch in {}"
            self.message = (
                f"{does.format(are.joints[shut[0]])} at the start already, from which derivatives cannot follow; let"
                " them start apart"
            )

    def _press_at_start(self) -> None:
        """Compliant contacts that are shut at the start go on from their depth, with the energy that they hold."""
        touching, seen, z = self.touching, self._seen, self.z.copy()
        those = np.flatnonzero((seen.gap < -NOT_OPEN) & ~touching.rigid & ~touching.level & ~touching.shut)
        strains = touching.strains(self.t, z, self._rates.values[:, 0]) if len(those) else np.zeros((0, 0))
        for n in those[those < touching.contacts].tolist():
            approaches = seen.rate[n] < 0.0
            if not approaches and np.abs(seen.by_rate[n]).max(initial=0.0) > NOT_OPEN and seen.rate[n] == 0.0:
                continue  # it may, or may not
            speed = -float(seen.rate[n]) if approaches else 0.0
            by_speed = -seen.by_rate[n] if approaches else np.zeros_like(seen.by_rate[n])
            self._open[n] = self._note_start(n, np.zeros_like(by_speed), speed, by_speed, False)
            touching.set(n, True, speed, by_speed)
            z[state_layout(self.functions.model.system).account(n).start + STORED] = strains[n]
        if len(those):
            self.functions.start_energy(z)
            self._go_on(z, np.zeros(len(z)), np.zeros(z.shape[1] - 1))

    def _rests(self, shut: np.ndarray) -> bool:
        """Whether contacts that are shut at the start are rigid ones at rest, whatever the parameters."""
        if not self.touching.rigid[shut].all() or (self._seen.gap[shut] < -NOT_OPEN).any():
            return False
        leaving = self.touching.leaving(self.t, self.z)
        gaps = shut[~self.touching.level[shut]]
        moved = max(np.abs(self._seen.by_gap[shut]).max(initial=0.0), np.abs(self._seen.by_rate[gaps]).max(initial=0.0))
        return moved <= NOT_OPEN and all(leaving[n].rise == 0.0 for n in shut.tolist())

    def _look(self, t: float, z: np.ndarray, rates: Rates) -> Watched:
        return self.touching.watched(t, z, rates.values[:, 0])

    # ---------------------------------------------------------------- steps
    def _accept(self, step: Step, t_new: float, z: np.ndarray, rates: Rates) -> bool:
        before, after = self._seen, self._look(t_new, z, rates)
        hit = self._hit(before, after)
        late = max((self._overshoot(n, after) for n in hit), default=0.0)  # [s]
        landed = late <= BESIDE * TOO_SHORT * self.t_end
        if len(hit) and not landed:
            self._land(hit, before, after, t_new - self.t)
            return False
        if self._in_doubt(before, after, step, t_new, hit):
            self._shorten("contact", t_new - self.t, 0.5)
            return False
        self._note_peaks(before, after, step, t_new, z, rates)
        super()._accept(step, t_new, z, rates)
        self._seen, self._tries = after, 0
        self._fastest = np.maximum(self._fastest, np.abs(after.rate))
        self._let_go(after)
        if self.message:
            return False
        if len(hit):
            self._meet(self._with_others(hit))
        return not len(hit)

    def _with_others(self, hit: np.ndarray) -> np.ndarray:
        """Rigid contacts that hit at the present instant: those that come to their walls but for rounding, too."""
        touching, seen = self.touching, self._seen
        if not (touching.rigid[hit] & ~touching.shut[hit] & ~touching.level[hit]).all():
            return hit
        leaving = touching.leaving(self.t, self.z)
        others = touching.rigid & ~touching.shut & ~touching.released & (np.abs(seen.gap) <= NOT_OPEN) & ~touching.level
        close = [n for n in np.flatnonzero(others).tolist() if leaving[n].rise < 0.0]
        return np.union1d(hit, close).astype(int)

    def _hit(self, before: Watched, after: Watched) -> np.ndarray:
        """Contacts that begin or end within a step."""
        touching = self.touching
        by_force = touching.by_force
        deeper = (after.gap < before.gap) & (after.rate < 0.0)
        closes = (after.gap < 0.0) & ((before.gap > 0.0) | deeper)
        closes |= (after.gap == 0.0) & (before.gap > 0.0) & (after.rate < 0.0)
        if touching.rubbing is not None and before.rubbed is not None and after.rubbed is not None:
            rests = before.rubbed.rests & after.rubbed.rests & (touching.rubbing.modes != 0.0)
            closes[touching.contacts : touching.slides] &= ~rests  # others hold it: its rate is rounding
        slack: float | np.ndarray = 0.0
        if after.slips is not None and before.slips is not None and after.slack is not None:
            rough, slack = touching.rough, after.slack
            closes[touching.slides :] &= (
                (touching.slide[rough] == 0.0) | (before.slips != 0.0)[rough] | (after.slips != 0.0)[rough]
            )
        begins = ~touching.shut & ~touching.released & closes
        opens = (
            touching.shut
            & ~(touching.rigid | touching.level)
            & (after.gap > 0.0)
            & ((before.gap < 0.0) | (after.rate > 0.0))
        )
        falls = (after.normal_in_time < 0.0) | (before.normal >= -slack)
        pulls = touching.shut & by_force & (after.normal < -slack) & falls
        return np.flatnonzero(begins | opens | pulls)

    def _ends_by_force(self, n: int, after: Watched) -> bool:
        """Whether what contact n waits for is the end of its force, not that of its gap: that comes first if any."""
        touching = self.touching
        by_force_alone = touching.rigid[n] or touching.level[n]
        return bool(touching.shut[n] and touching.by_force[n] and (by_force_alone or after.gap[n] <= 0.0))

    def _overshoot(self, n: int, after: Watched) -> float:
        """By how much the end of a step is beyond the begin or the end of a contact [s]."""
        value, rate = after.gap[n], after.rate[n]
        if self._ends_by_force(n, after):
            value, rate = after.normal[n], after.normal_in_time[n]
        elif abs(value) <= self._slight[n]:
            return 0.0
        return float(abs(value / rate)) if rate != 0.0 else 0.0

    def _land(self, hit: np.ndarray, before: Watched, after: Watched, h: float) -> None:
        """Try a step that ends at the first of these contacts."""
        self._tries += 1
        share = min(self._share(n, before, after, h) for n in hit)
        share = 0.5 if self._tries > TRIES else min(max(share, 1e-3), 1.0 - 1e-12)
        if share * h <= TOO_SHORT * self.t_end:
            self._meet(hit)
            return
        self.rejected += 1
        self.h = share * h

    def _share(self, n: int, before: Watched, after: Watched, h: float) -> float:
        """Where in a step the gap, or the force, is zero: on the cubic through both ends."""
        if self._ends_by_force(n, after):
            ends = before.normal[n], before.normal_in_time[n], after.normal[n], after.normal_in_time[n]
        else:
            ends = before.gap[n], before.rate[n], after.gap[n], after.rate[n]
        a, da, b, db = ends[0], h * ends[1], ends[2], h * ends[3]
        roots = np.roots([2 * a + da - 2 * b + db, -3 * a - 2 * da + 3 * b - db, da, a])
        inside = [float(x.real) for x in roots if abs(x.imag) < 1e-9 and 1e-9 < x.real <= 1.0]
        return min(inside) if inside and a != 0.0 else (max(inside) if inside else 0.5)

    def _in_doubt(self, before: Watched, after: Watched, step: Step, t_new: float, landed: np.ndarray) -> bool:
        """Whether a gap that turns within a step may have closed in it, or one that closed may have opened.

        landed: contacts that do at its end.
        """
        touching = self.touching
        turns = ~touching.released & (before.rate * after.rate < 0.0)
        turns &= np.where(touching.shut, before.rate > 0.0, before.rate < 0.0)
        turns &= ~(touching.shut & touching.level)  # those end by their torque alone
        eases = touching.shut & touching.by_force & (before.normal_in_time < 0.0) & (after.normal_in_time > 0.0)
        turns[landed] = eases[landed] = False
        h = t_new - self.t
        if not (turns | eases).any() or h <= 16.0 * TOO_SHORT * self.t_end:
            return False
        (middle,) = step.states(self.functions, np.array([self.t + 0.5 * h]))
        rates = self.functions.rates(self.t + 0.5 * h, middle)
        between = self._look(self.t + 0.5 * h, middle, rates)
        for n in np.flatnonzero(turns):
            sign = -1.0 if touching.shut[n] else 1.0
            gaps = [sign * x.gap[n] for x in (before, between, after)]
            if _may_vanish(gaps, sign * h * before.rate[n], sign * h * after.rate[n]):
                return True
        return any(
            _may_vanish(
                [x.normal[n] for x in (before, between, after)],
                h * before.normal_in_time[n],
                h * after.normal_in_time[n],
            )
            for n in np.flatnonzero(eases)
        )

    def _let_go(self, after: Watched) -> None:
        """Contacts whose force has ended are open once their gap is."""
        self.touching.released &= ~((after.gap > 0.0) & (after.rate > 0.0))
        self.touching.released &= ~(self.touching.level & (after.gap > NOT_OPEN))
        again = np.flatnonzero(self.touching.released & ~self.touching.rigid & (after.rate < 0.0))
        if len(again):
            joint = self.touching.joints[again[0]]
            self._leave_out_since(self._let[again[0]])
            self.message = (
                f"stopped at t = {self.t:.6g} s: the contact in {joint}, whose force has ended, is pressed again before"
                " its gap opens, which derivatives do not follow"
            )

    def _leave_out_since(self, t: float) -> None:
        """What comes later than t [s] is not known."""
        count = int(np.searchsorted(self.t_eval[: len(self.values)], t, side="right"))
        del self.values[count:], self.derivatives[count:]
        self.t = t

    # ---------------------------------------------------------------- contacts
    def _meet(self, hit: np.ndarray) -> None:
        """What begins or ends at the present instant."""
        touching, n = self.touching, int(hit[0])
        self._turns = self._turns + 1 if self.t - self._turned_at <= TOO_SHORT * self.t_end else 1
        self._turned_at = self.t
        if self._turns > MOST_TURNS:
            names = ", ".join(dict.fromkeys(touching.joints[n] for n in hit))
            self.message = f"stopped at t = {self.t:.6g} s: contacts begin and end there without end ({names})"
            return
        rubs = hit[(hit >= touching.contacts) & (hit < touching.slides)]
        others = np.setdiff1d(hit, rubs)
        rigid = bool(((others >= touching.slides) | touching.rigid[others]).all())
        if len(hit) > 1 and not (rigid and self._are_one(hit, others)):
            names = ", ".join(dict.fromkeys(touching.joints[n] for n in hit))
            self.message = f"stopped at t = {self.t:.6g} s: several contacts begin or end there at once ({names})"
            if len(others) == 0:
                self.message = (
                    f"stopped at t = {self.t:.6g} s: several joints begin to slip or to stick at once ({names})"
                )
            return
        shift = self._shift_of(n)
        self._keep_moment(shift)
        self._keep_jumps(shift)
        if (touching.rigid[others] & ~touching.shut[others] & ~touching.level[others]).any():
            self._collide(others.tolist(), shift)
        elif rigid:
            self._end_modes(rubs, shift)
            if len(others) and not self.message:
                self._change(others.tolist(), shift)
        else:
            (self._end if touching.shut[n] else self._start)(n, shift)
        if not self.message and (touching.rubbing is not None or not rigid):
            self._follow_forces(shift)
        if not self.message:
            self._keep_jumps(shift)
            self._keep_moment(shift)
            self.h, self._near = RESTART * self.t_end, 0
            self.switched += 1
            self._limit_steps()

    def _are_one(self, hit: np.ndarray, others: np.ndarray) -> bool:
        """Whether all rows turn at one instant whatever the parameters, and rigid contacts, which are those that are
        no joints that rub, all begin or all change."""
        begins = self.touching.rigid[others] & ~self.touching.shut[others]
        shift = self._shift_of(int(hit[0]))
        alike = all(self._is_alike(shift, self._shift_of(row)) for row in hit.tolist())
        return alike and bool(begins.all() or not begins.any())

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

    def _shift_of(self, n: int) -> np.ndarray:
        """(k,) derivatives of the present instant, at which row n turns."""
        seen, by, rate = self._seen, self._seen.by_gap, self._seen.rate
        if self._ends_by_force(n, seen):
            by, rate = seen.by_normal, seen.normal_in_time
        return np.asarray(-by[n] / rate[n] if rate[n] != 0.0 else np.full(by.shape[1], math.nan))

    def _is_alike(self, shift: np.ndarray, other: np.ndarray) -> bool:
        """Whether two instants depend alike on the parameters."""
        sizes = self.tolerance.parameters
        off, most = (np.abs(x * sizes).max(initial=0.0) for x in (other - shift, shift))
        return bool(off <= SAME * most + UNMOVED * self.t_end)

    def _limit_steps(self) -> None:
        """While a body rests steps grow, whatever loads do that change with time."""
        touching = self.touching
        rests = (touching.shut & touching.rigid).any()
        rests |= touching.rubbing is not None and (np.abs(touching.rubbing.modes) != 1.0).any()
        self._longest = self.t_end / SHORT if rests and self._pulsates else math.inf

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

    def _settle(self, those: list[int], slide: np.ndarray, shift: np.ndarray) -> None:
        """Rigid contacts last from here on, sticking or slipping, or let go, and joints that rub have modes in which
        they fit the forces at the present instant; slide: senses in which contacts slip."""
        touching = self.touching
        others, changes = self._combinations(), 0
        while True:
            blow = self._decide(those, slide, shift) if those else None
            if self.message or touching.rubbing is None or self._seen.rubbed is None:
                return
            modes, known = touching.rubbing.settled(self._seen.rubbed), blow is None or blow.agreed == 1.0
            if known and np.array_equal(modes, touching.rubbing.modes):
                return
            changes += 1
            if blow is not None and (not known or changes >= MOST_CHANGES):
                moving, other = self._moving(), next(others, None)
                if other is None:
                    break
                modes = np.where(moving != 0.0, moving, np.where(blow.free, other, modes))
            if blow is None and changes >= MOST_MODES:
                break
            self._rub(modes, shift)
            if self.message:
                return
        self.message = f"stopped at t = {self.t:.6g} s: joints that rub stick and slip to and fro there without end"

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
        those = sorted([*np.flatnonzero(touching.shut & touching.rigid).tolist(), *locks])
        if those:
            self._settle(those, touching.slide.copy(), shift)
        else:
            self._go_on(self.z, self._rates.values[:, 0], shift)
        self._note_locks(drove, shift)

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

    # ---------------------------------------------------------------- joints that rub
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

    def _number(self, joint: str) -> int:
        return 1 + sum(met.joint == joint for met in self.met)

    # ---------------------------------------------------------------- largest forces
    def _note_peaks(
        self, before: Watched, after: Watched, step: Step, t_new: float, z: np.ndarray, rates: Rates
    ) -> None:
        """Keep the largest force of every contact that lasts."""
        for n, met in self._open.items():
            if before.normal_in_time[n] > 0.0 > after.normal_in_time[n]:
                self._keep(met, n, self._top(step, n, t_new))
            self._keep(met, n, after)

    def _keep_jumps(self, shift: np.ndarray) -> None:
        """Keep the largest force at an instant at which forces may jump; it moves with that."""
        seen, touching = self._seen, self.touching
        for n in [n for n in self._open if not touching.shut[n]]:
            del self._open[n]
        for n, met in self._open.items():
            if seen.normal[n] >= met.peak and seen.normal[n] > 0.0:
                met.peak = float(seen.normal[n])
                met.by_peak = seen.by_normal[n] + seen.normal_in_time[n] * shift

    @staticmethod
    def _keep(met: Met, n: int, seen: Watched) -> None:
        if seen.normal[n] > met.peak:
            met.peak, met.by_peak = float(seen.normal[n]), seen.by_normal[n]

    def _top(self, step: Step, n: int, t_new: float) -> Watched:
        """Where a force is largest within a step."""
        low, high = self.t, t_new
        for _ in range(PEAK_ROUNDS):
            t = 0.5 * (low + high)
            (z,) = step.states(self.functions, np.array([t]))
            seen = self._look(t, z, self.functions.rates(t, z))
            low, high = (t, high) if seen.normal_in_time[n] > 0.0 else (low, t)
            if high - low <= TOO_SHORT * self.t_end:
                break
        self._keep_between(np.array([t]), [z])
        return seen
