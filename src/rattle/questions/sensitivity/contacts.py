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

import math
from collections.abc import Sequence

import numpy as np

from rattle.equations.state import STORED, state_layout
from rattle.jit import layout as at
from rattle.questions.sensitivity.events import NOT_OPEN, Events, Met
from rattle.questions.sensitivity.functions import Functions, Rates
from rattle.questions.sensitivity.motion import BESIDE, RESTART, SAME, TOO_SHORT
from rattle.questions.sensitivity.step import Step
from rattle.questions.sensitivity.touching import Touching, Watched

ALMOST = 0.1  # share of the gap at both ends of a step by which its least value may be in doubt
TRIES = 60  # of a landing by interpolation, before steps are halved
PEAK_ROUNDS = 40  # of the search for a largest force, by halves
MOST_TURNS = 60  # of contacts and joints at one instant
UNMOVED = 1e-10  # share of the run by which a change of a parameter, as large as it is, moves an instant by rounding
ROUNDED = 2e-15  # share of the size of the mechanism by which a gap may be rounding, or of 1 rad


def _may_vanish(values: Sequence[float], falls: float, rises: float) -> bool:
    """Whether a curve that is not negative may be within a step, by its values at both ends and midway, and its slopes
    per step at the ends."""
    a, middle, b = values
    theta = np.linspace(0.0, 1.0, 65)
    cubic = a + theta * (falls + theta * ((3 * (b - a) - 2 * falls - rises) + theta * (2 * (a - b) + falls + rises)))
    least = min(a, b)
    return bool(least >= 0.0 and cubic.min() - 4.0 * abs(middle - cubic[32]) < min(0.0, ALMOST * least))


class ContactMotion(Events):
    """`Motion` of a mechanism whose contacts begin and end; `met` is the list of them, in order of time."""

    def __init__(
        self, functions: Functions, touching: Touching, z: np.ndarray, t_eval: np.ndarray, rtol: float, atol: float
    ) -> None:
        super().__init__(functions, touching, z, t_eval, rtol, atol)
        self._tries, self._turns, self._turned_at = 0, 0, -math.inf
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
            either = seen.rate[n] == 0.0 and np.abs(seen.by_rate[n]).max(initial=0.0) > NOT_OPEN
            if either and touching.knows_speed(n):
                continue  # it may approach, or may not
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
        if self.moments is not None:
            self.moments = [moment for moment in self.moments if moment.t <= t]
        self.t = t

    # ---------------------------------------------------------------- contacts
    def _meet(self, hit: np.ndarray) -> None:
        """What begins or ends at the present instant."""
        touching, n = self.touching, int(hit[0])
        rubs = hit[(hit >= touching.contacts) & (hit < touching.slides)]
        others = np.setdiff1d(hit, rubs)
        rigid = bool(((others >= touching.slides) | touching.rigid[others]).all())
        trouble = self._trouble(hit, others, rigid)
        if trouble:
            names = ", ".join(dict.fromkeys(touching.joints[n] for n in hit))
            self.message = f"stopped at t = {self.t:.6g} s: {trouble} ({names})"
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

    def _trouble(self, hit: np.ndarray, others: np.ndarray, rigid: bool) -> str:
        """Why rows that turn at the present instant cannot be followed; "" if they can.  others: those of contacts, and
        whether all of them are rigid."""
        self._turns = self._turns + 1 if self.t - self._turned_at <= TOO_SHORT * self.t_end else 1
        self._turned_at = self.t
        if self._turns > MOST_TURNS:
            return "contacts begin and end there without end"
        if len(hit) == 1 or (rigid and self._are_one(hit, others)):
            return ""
        if len(others):
            return "several contacts begin or end there at once"
        return "several joints begin to slip or to stick at once"

    def _are_one(self, hit: np.ndarray, others: np.ndarray) -> bool:
        """Whether all rows turn at one instant whatever the parameters, and rigid contacts, which are those that are
        no joints that rub, all begin or all change."""
        begins = self.touching.rigid[others] & ~self.touching.shut[others]
        shift = self._shift_of(int(hit[0]))
        alike = all(self._is_alike(shift, self._shift_of(row)) for row in hit.tolist())
        return alike and bool(begins.all() or not begins.any())

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
