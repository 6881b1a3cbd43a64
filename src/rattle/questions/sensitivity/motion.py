"""A motion together with its derivatives by parameters, by the variational equations.

    Y = dy/dp,   dY/dt = f_y Y + f_p                           between switches
    Y+ = Y- + (f- - f+) tau_p,   tau_p = -(g_y Y- + g_p)/(g_t + g_y f-)     where the switching function g is zero

f is the recorded right-hand side, its derivatives are exact; y and Y are integrated by the same steps, whose errors
are controlled for both.  After every step y is brought onto the constraints, and Y by the derivative of that.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), sections I.14 and II.6.
"""

from __future__ import annotations

import math
import time
from typing import NamedTuple

import numpy as np

from rattle.analyses.dynamics import run as runs
from rattle.analyses.straight_line.lane_model import weight
from rattle.equations.state import state_layout
from rattle.questions.sensitivity.functions import Functions, Rates
from rattle.questions.sensitivity.step import POWER, Step, Tolerance, try_step
from rattle.solvers.step_audit import energy_at_rest
from rattle.solvers.step_size import SAFETY, longer, shorter

ENERGY = 1e-3  # share of the largest energy that may be unaccounted for, as for adaptive steppers
OF_POTENTIAL = 1e-9  # share of the potential energy, and of that of lifting a mechanism by its size, that counts as
# turned over: one at rest turns nothing over
ROUNDING = 1e-14  # share of the potential energy that its sum is rounded by: no error of the motion
FIRST = 1e-2  # first step: of the run, and of the time in which the start would move by the size of the mechanism
RESTART = 1e-6  # first step after a switch, as a share of the run: longer ones follow if that was too careful
TOO_SHORT = 1e-13  # share of the run below which steps do not get shorter
ALIKE = 1e-9  # share of the right-hand side by which both sides of a switch may differ and yet be the same
BESIDE = 4.0  # the other side of a switch is looked for so many shortest steps further, then twice as many ...
DOUBLINGS = 20
CRAWLS, MOST_CRAWLS = 1e-11, 2000  # share of the run that a step makes no way by, and such tries in a row
MOST_PASSES = 10  # switches in a row that make no way, before it is looked whether the motion rests there
DRIFTS = 8.0  # by so much more than in half the way to it the right-hand side changes beyond a jump
INSIDE, ROWS = 8, 1000  # parts of a step at whose ends curves are kept, at least, and parts of the run
NEAR = 3  # a step is halved where a switch lies inside: it is met within two such steps
SAME = 1e-6  # share by which the instants of two switches may depend differently on a parameter and yet be one


class Moment(NamedTuple):
    """Curves at an instant between outputs."""

    t: float  # [s]
    values: np.ndarray  # (nc,)
    slopes: np.ndarray  # (nc, k) derivatives of the values at that instant
    rates: np.ndarray  # (nc,) and in time
    shift: np.ndarray | None = None  # (k,) derivatives of the instant, if it is one of an event


class Motion:
    """The motion from the state z (ny, 1 + k) at t = 0; `go` takes it to the end, or `message` says why not."""

    def __init__(self, functions: Functions, z: np.ndarray, t_eval: np.ndarray, rtol: float, atol: float) -> None:
        system = functions.model.system
        self.functions, self.t_eval, self.t_end = functions, t_eval, float(t_eval[-1])
        self.tolerance = _tolerance(functions, rtol, atol, self.t_end)
        self.t, self.z = 0.0, z
        self.message = ""
        self.interrupted = False
        self.values: list[np.ndarray] = []  # curves at the outputs
        self.derivatives: list[np.ndarray] = []
        self.moments: list[Moment] | None = None  # both sides of events, and instants of steps, where a list is given
        self.history: list[tuple[float, np.ndarray]] = []  # times [s], sizes (k,) of the derivatives of positions
        self.drift, self.drift_angle = 0.0, 0.0  # what the projection of an output corrects [m], [rad]
        self.balance, self.share = 0.0, 0.0  # largest energy error [J], and as a share of the largest energy
        self.steps = self.rejected = self.switched = 0
        self.wall = 0.0
        self._lifting, mass = weight(system)  # [J], [kg]
        self._resting = energy_at_rest(mass, atol)  # [J]
        self._longest = math.inf  # step that shows all that happens [s]
        self._beyond: Rates | None = None  # on another side of a switch, in the last step that failed there
        self._passes, self._passed_at = 0, -math.inf  # switches one after the other that make no way
        self._crawls = 0  # steps one after the other that make no way
        self._near = 0  # steps that must not become longer, because a switch was found ahead
        self._turnover = np.array([0.0, math.inf, -math.inf, 0.0])  # kinetic, least and most potential, work [J]
        self._names = ", ".join(sorted({switch.name for switch in system.switches})) or "an expression"

    def go(self) -> None:
        """Take steps to the end."""
        began = time.perf_counter()
        try:
            self._begin()
            while not self.message and self.t < self.t_end:
                if runs.stop.is_set():
                    raise KeyboardInterrupt
                self._advance()
        except KeyboardInterrupt:
            self.interrupted = True
            self.message = f"stopped by the user at t = {self.t:.6g} s; the result holds what was computed before"
        self.wall = time.perf_counter() - began

    # ---------------------------------------------------------------- steps
    def _begin(self) -> None:
        self.functions.start_energy(self.z)
        self._rates = self.functions.rates(self.t, self.z)
        if not (self._rates.sound and np.isfinite(self._rates.values).all()):
            self.message = f"at the start: {UNSOUND}"
            return
        some = self.tolerance.controlled
        speed = np.abs(self._rates.values[some, 0] / self.tolerance.weight).max(initial=0.0)
        self.h = min(FIRST / speed if speed > 0.0 else math.inf, FIRST * self.t_end or 1.0)
        self._keep_outputs([self.z] if self.t_eval[0] == 0.0 else [])
        self._note(self.z)

    def _advance(self) -> None:
        """One step, or one attempt."""
        ahead = self.t_end - self.t
        h = min(self.h, self._longest)
        last = 1.000001 * h >= ahead
        h = ahead if last else h
        step, trouble, last_rates = try_step(self.functions, self.t, h, self.z, self._rates)
        if trouble:
            self._beyond = last_rates if trouble == "sides" else self._beyond
            self._shorten(trouble, h, 0.5)
            return
        error = self.tolerance.error(step.z, step.z_new, h, step.slopes)
        if not error <= 1.0:
            self._shorten("error", h, shorter(1.0, error, POWER, SAFETY))
            return
        t_new = self.t_end if last else self.t + h
        projected, rates, trouble = self._end_of(step, t_new)
        if trouble:
            self._beyond = rates if trouble == "sides" else self._beyond
            self._shorten(trouble, h, 0.5)
            return
        self._crawls = self._crawls + 1 if h <= CRAWLS * self.t_end else 0
        if self._crawls > MOST_CRAWLS:
            self.message = f"stopped at t = {self.t:.6g} s: {NO_WAY}"
        elif self._accept(step, t_new, projected, rates):
            still = self.functions.still.copy()
            if still.any():
                self.functions.let_rest(self.t, self.z, still)
                self._rates = self.functions.rates(self.t, self.z)
            self.h = h if self._near else longer(h, error, POWER, SAFETY)
            self._near = max(0, self._near - 1)

    def _end_of(self, step: Step, t_new: float) -> tuple[np.ndarray, Rates, str]:
        """The state at the end of a step, its rates, and why it cannot be accepted, as of `try_step`."""
        projected, sound = self.functions.projected(t_new, step.z_new)
        rates = self.functions.rates(t_new, projected) if sound else self._rates
        if not (sound and rates.sound and np.isfinite(rates.values).all()):
            return projected, rates, "sound"
        return projected, rates, "sides" if (rates.sides != self._rates.sides).any() else ""

    def _accept(self, step: Step, t_new: float, z: np.ndarray, rates: Rates) -> bool:
        """Take a step; True if the next one may be chosen by its error."""
        k = len(self.values)
        inside = self.t_eval[k : np.searchsorted(self.t_eval, t_new, side="right")]
        if len(inside) and inside[-1] == t_new:
            states = [*step.states(self.functions, inside[:-1]), z]
        else:
            states = step.states(self.functions, inside)
        self.steps += 1
        self._keep_outputs(states)
        self._keep_inside(step, t_new, z)
        self.t, self.z, self._rates = t_new, z, rates
        self._note(z)
        return True

    def _shorten(self, trouble: str, h: float, factor: float) -> None:
        self.rejected += 1
        self.h = h * factor
        self._near = NEAR if trouble == "sides" else self._near
        if self.h > TOO_SHORT * self.t_end:
            return
        if self._near:
            self._cross()
        else:
            why = UNSOUND if trouble == "sound" else NO_WAY
            self.message = f"stopped at t = {self.t:.6g} s: {why}"

    # ---------------------------------------------------------------- switches
    def _cross(self) -> None:
        """Pass the switch that the motion has come to: by so much that rounding does not turn it back."""
        before, t, z = self._rates, self.t, self.z
        self._passes = self._passes + 1 if self.t - self._passed_at <= CRAWLS * self.t_end else 0
        self._passed_at = self.t
        if self._passes > MOST_PASSES and self._is_at_rest():
            return
        if self._passes > MOST_CRAWLS:
            self.message = f"stopped at t = {self.t:.6g} s: {self._names} switches back and forth there"
            return
        words, ahead = "touches its switch there and turns back", BESIDE * TOO_SHORT * self.t_end
        drift = 0.0  # of the right-hand side on this side of the switch
        for _ in range(DOUBLINGS):
            slope = before.values
            after = self.functions.rates(t + ahead, z + ahead * slope)
            if (after.sides == before.sides).all():  # what begins at rest moves by its acceleration
                drift = float(np.abs(after.values[:, 0] - before.values[:, 0]).max())
                slope = 0.5 * (before.values + after.values)
                after = self.functions.rates(t + ahead, z + ahead * slope)
            if (after.sides != before.sides).any():
                words = "switches back and forth there"
                if self._pass(after, ahead, slope, drift) or self.message:
                    return
            ahead *= 2.0
        if self._is_at_rest(drift):
            return
        self.message = f"stopped at t = {t:.6g} s: {self._names} {words}"

    def _is_at_rest(self, drift: float = 0.0) -> bool:
        """Whether expressions only seem to switch where the motion is, as what rests on a kink turns by rounding: they
        are left aside then.  drift: by how much the right-hand side changes soon."""
        before, beyond = self._rates, self._beyond
        if beyond is None:
            return False
        off, size = (np.abs(x[:, 0]).max() for x in (beyond.values - before.values, before.values))
        flips = (beyond.sides != before.sides) | self.functions.still
        if off > max(ALIKE * size, drift) or not self.functions.let_rest(self.t, self.z, flips):
            return False
        self._rates, self.h, self._near = self.functions.rates(self.t, self.z), RESTART * self.t_end, 0
        return True

    def _pass(self, after: Rates, ahead: float, slope: np.ndarray, drift: float) -> bool:
        """Go on beyond a switch, where the right-hand side is another; False, without a message, if that is on its
        other side still, or again; slope: of the way there; drift: of the right-hand side before it."""
        before, t, z = self._rates, self.t, self.z
        shift = np.zeros(z.shape[1] - 1)  # a kink moves on nothing
        jump = before.values[:, 0] - after.values[:, 0]
        scale = max(np.abs(before.values[:, 0]).max(), np.abs(after.values[:, 0]).max())
        jumps, trouble = bool(np.abs(jump).max() > max(ALIKE * scale, DRIFTS * drift)), ""
        if jumps or self._bears():
            moved = self._shift(before, after)
            if moved is None and jumps:
                return False
            if moved is None:
                trouble, self.message = self.message, ""
            else:
                shift = moved
        beyond = z + ahead * slope
        beyond[:, 1:] += jump[:, None] * shift
        beyond, sound = self.functions.projected(t + ahead, beyond)
        rates = self.functions.rates(t + ahead, beyond)
        if not sound or (rates.sides != after.sides).any():
            return False
        self._keep_moment(shift)
        self.functions.still[:] = False
        self.z, self._rates = beyond, self.functions.rates(t + ahead, beyond)
        self.t, self.h, self._near = t + ahead, RESTART * self.t_end, 0
        self.switched += 1
        if self._follow_switch(shift) and not self.message:
            self.message = trouble
        if not self.message:
            self._keep_moment(shift, t)
        return True

    def _bears(self) -> bool:
        """Whether what rests may go on otherwise where forces jump."""
        return False

    def _follow_switch(self, shift: np.ndarray) -> bool:
        """Whether something goes on otherwise where an expression has switched; shift: (k,) derivatives of that
        instant."""
        return False

    def _shift(self, before: Rates, after: Rates) -> np.ndarray | None:
        """(k,) derivatives of the instant of the switch [s] by the parameters; None, with a message, if it has none."""
        flips = before.sides != after.sides
        margins = []
        for rates in (before, after):
            by_parameter, in_time = self.functions.margins(self.t, self.z, rates.values[:, 0])
            margins.append((by_parameter[flips], in_time[flips]))
        (by_parameter, speed), (_, speed_after) = margins
        moves = (speed != 0.0) | (speed_after != 0.0)  # others jump with these, as conditions of several comparisons
        if moves.any():
            by_parameter, speed, speed_after = by_parameter[moves], speed[moves], speed_after[moves]
        if not speed.any() and not by_parameter.any():  # it begins at rest there, whatever the parameters are
            return np.zeros(by_parameter.shape[1])
        if not (speed * speed_after > 0.0).all():
            self.message = (
                f"stopped at t = {self.t:.6g} s: the motion stays on the switch of {self._names} (as in sticking);"
                " use a smooth function, such as tanh for the sign"
            )
            return None
        shifts = -by_parameter / speed[:, None]
        if (np.abs(shifts - shifts[0]) > SAME * np.abs(shifts).max()).any():
            self.message = f"stopped at t = {self.t:.6g} s: two expressions ({self._names}) switch at the same instant"
            return None
        return np.asarray(shifts[0])

    # ---------------------------------------------------------------- outputs and checks
    def _keep_moment(self, shift: np.ndarray, t: float | None = None) -> None:
        """Keep the curves here; shift: (k,) how the instant changes with the parameters; t: that it counts as [s]."""
        if self.moments is not None:
            values, along, _ = self.functions.curves_in_time(self.t, self.z, self._rates.values[:, 0])
            t = self.t if t is None else t
            self.moments.append(Moment(t, values, along[:, :-1], along[:, -1], shift))

    def _keep_inside(self, step: Step, t_new: float, z: np.ndarray) -> None:
        """Keep the curves inside of a step and at its end: between outputs there may be contacts or oscillations."""
        if self.moments is not None:
            h = t_new - self.t
            parts = max(INSIDE, math.ceil(h * ROWS / self.t_end))
            inside = self.t + h * np.arange(1, parts) / parts
            self._keep_between(np.append(inside, t_new), [*step.states(self.functions, inside), z])

    def _keep_between(self, times: np.ndarray, states: list[np.ndarray]) -> None:
        """Keep the curves at instants (n,) [s]."""
        if self.moments is not None:
            values, along = self.functions.outputs_in_time(times, np.array(states))
            self.moments += [
                Moment(t, x, dx[:, :-1], dx[:, -1]) for t, x, dx in zip(times.tolist(), values, along, strict=True)
            ]

    def _keep_outputs(self, states: list[np.ndarray]) -> None:
        if not states:
            return
        t = self.t_eval[len(self.values) : len(self.values) + len(states)]
        values, slopes, sound, moved = self.functions.outputs(t, np.array(states))
        sound = sound & np.isfinite(values).all(axis=1) & np.isfinite(slopes).all(axis=(1, 2))
        count = len(t) if sound.all() else int(np.argmin(sound))
        if count < len(t):
            self.message = f"stopped at t = {t[count]:.6g} s: {UNSOUND}"
        self.drift = max(self.drift, float(moved[:count, :, :2].max(initial=0.0)))
        self.drift_angle = max(self.drift_angle, float(moved[:count, :, 2].max(initial=0.0)))
        self.values += list(values[:count])
        self.derivatives += list(slopes[:count])

    def _note(self, z: np.ndarray) -> None:
        """Energy and size of the derivatives after a step."""
        kinetic, potential, work, _, balance = self.functions.energies(self.t, z)
        most, low, high, done = self._turnover
        most, done = max(most, kinetic), max(done, abs(work))
        low, high = min(low, potential), max(high, potential)
        self._turnover[:] = most, low, high, done
        turnover = max(most, done, high - low) + OF_POTENTIAL * (abs(potential) + self._lifting)
        unrest = max(0.0, abs(balance) - ROUNDING * max(abs(low), abs(high)) - self._resting)
        share = unrest / turnover if turnover > 0.0 else 0.0
        self.balance, self.share = max(self.balance, abs(float(balance))), max(self.share, float(share))
        if not share <= ENERGY:
            self.message = (
                f"stopped at t = {self.t:.6g} s: the energy error is {share:.2g} of the largest energy; a smaller"
                " rtol reduces it unless a load works against its own potential"
            )
        nq = 3 * self.functions.model.system.body_count
        size = np.abs(z[:nq, 1:]) / self.tolerance.weight[:nq, None]
        self.history.append((self.t, size.max(axis=0, initial=0.0)))


NO_WAY = "steps became too short: the motion or its derivatives diverge"
UNSOUND = "the mechanism comes next to a singular position, or a load or expression has no finite value or derivative"


def _tolerance(functions: Functions, rtol: float, atol: float, t_end: float) -> Tolerance:
    system = functions.model.system
    layout = state_layout(system)
    controlled = np.r_[layout.motion, layout.states]
    weight = np.tile([system.extent, system.extent, 1.0], 2 * system.body_count)
    weight = np.concatenate([weight, np.ones(len(controlled) - len(weight))])
    sizes = np.abs(functions.parameters.values)
    return Tolerance(rtol, atol, weight, controlled, np.where(sizes > 0.0, sizes, 1.0))
