"""The temperatures at which joints lose what flows off: a fixed point, found from the temperature of the air upwards.

Losses fall steeply where oil warms, so that plain substitution swings.  Every loss is therefore followed along its
slope, by a secant through the last two runs:

    (G - diag s) (T - T_air) = P - s (T_0 - T_air)

One joint that depends on temperature is bracketed besides, and where it loses less the warmer it is, the logarithm of
its loss is followed, which is nearly straight.  Of several ones falling losses alone are followed, no
steeper than oil and play make them, and steps that turn back are halved.  Where more than one state is steady, as with
play that closes, it is the coldest one that machines reach when they warm up.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from rattle.catalogue.oils import COLDEST, HOTTEST
from rattle.errors import InputError, ModelError, SolverError
from rattle.jit.choices import TINY
from rattle.language.units import FREEZING
from rattle.mechanism import Mechanism
from rattle.questions.heat.properties import Dependent, dependents, falls, warmed, within_reach
from rattle.questions.heat.ways import Network

Array = NDArray[np.float64]
MOST = 40  # runs
NEAR, SHARE = 0.01, 1e-4  # last step, in K or as a share of the rise: far below what anybody knows of a conductance
QUIET = 1e-9  # share of all losses below which one is rounding
STEEPEST = 2.0  # times the slope of oil and play alone, that of a joint among several: beyond it others changed
FLATTEST = 0.1  # slope of the balance over that of constant losses below which no secant is followed: it leads too far
REACH = 20.0  # [K] of a step that no secant leads: dry friction begins, or play closes, and may stop again
TURNED = 0.5  # share of the last step by which a step turns back that is halved


class Steady(NamedTuple):
    """Temperatures of all joints [K], what they lose then [W], and after how many runs."""

    temperatures: Array  # (n,)
    losses: Array  # (n,)
    mechanism: Mechanism
    runs: int
    dependents: tuple[Dependent, ...]
    duration: float  # of a run [s]


class _Balance(NamedTuple):
    """What one run says at temperatures (n,) [K]."""

    at: Array
    losses: Array  # (n,) [W]


def steady(m: Mechanism, ways: Network, t_end: float | None) -> Steady:
    """The steady temperatures.  Raises InputError for heat that cannot leave, SolverError."""
    joints = dependents(m)
    now = np.full(len(ways.joints), ways.ambient)
    for joint in joints:
        if joint.has_oil:
            now[joint.number] = min(max(ways.ambient, COLDEST), HOTTEST)
    search = _Search(m, ways, joints)
    for runs in range(1, MOST + 1):
        balance = _Balance(now, _losses(search.at(now), ways, t_end))
        aim, slope = search.next(balance)
        step = aim - now
        if not joints or np.abs(step).max() <= max(NEAR, SHARE * float((aim - ways.ambient).max())):
            losses = balance.losses + slope * step
            duration = m.model.settings.t_end if t_end is None else t_end
            return Steady(aim, losses, search.at(aim), runs, joints, duration)
        now = within_reach(m, joints, now, aim, balance.losses)
    named = ", ".join(f"{joint.joint} {now[joint.number] - FREEZING:.2f} degC" for joint in joints)
    raise SolverError(
        f"no steady temperatures after {MOST} runs; the last ones were {named}, steps of {np.abs(step).max():.2g} K;"
        " losses that change from run to run need a longer t_end",
        None,
    )


class _Search:
    """Where the next run is made."""

    def __init__(self, m: Mechanism, ways: Network, joints: tuple[Dependent, ...]) -> None:
        self.m, self.ways, self.joints = m, ways, joints
        self.alone = joints[0].number if len(joints) == 1 else None
        self.last: _Balance | None = None
        self.last_step = np.zeros(len(ways.joints))
        self.damping = 1.0
        self.low, self.high = -math.inf, math.inf  # of the one joint, between which it is steady [K]

    def at(self, temperatures: Array) -> Mechanism:
        try:
            return warmed(self.m, self.joints, temperatures)
        except ModelError as error:
            path = error.problems[0].path
            if path[:1] + path[2:3] != ("joints", "clearance"):
                raise
            warm = temperatures[self.ways.joints.index(str(path[1]))] - FREEZING
            raise SolverError(f"{path[1]} seizes: no play left at {warm:.1f} degC", None) from None

    def next(self, balance: _Balance) -> tuple[Array, Array]:
        """Temperatures (n,) [K] that follow from a run, and the slopes (n,) [W/K] along which losses were followed."""
        slope = self._slopes(balance)
        if self.alone is not None:
            aim = self._bracketed(balance, slope, self.alone)
        else:
            aim = self.ways.temperatures(balance.losses, slope, balance.at)
            aim = self._damped(balance.at, aim)
        self.last, self.last_step = balance, aim - balance.at
        return aim, slope

    def _slopes(self, balance: _Balance) -> Array:
        """(n,) [W/K]: by the last two runs, at first and as a limit by oil and play."""
        slope = np.zeros(len(self.ways.joints))
        if not self.joints:
            return slope
        if self.last is None or self.alone is None:
            slope = np.minimum(balance.losses * self._falls(balance.at), 0.0)
        if self.last is None:
            return slope
        for joint in self.joints:
            k = joint.number
            way = balance.at[k] - self.last.at[k]
            if abs(way) < TINY:
                continue
            secant = (balance.losses[k] - self.last.losses[k]) / way
            slope[k] = secant if self.alone is not None else min(max(secant, STEEPEST * slope[k]), 0.0)
        return slope

    def _falls(self, at: Array) -> Array:
        """(n,) [1/K], see `falls`: from 1 K more, or less where that is out of reach."""
        here = self.at(at)
        for way in (1.0, -1.0):
            try:
                return way * falls(here, warmed(self.m, self.joints, at + way), self.joints, len(at))
            except ModelError:
                continue
        return np.zeros(len(at))

    def _bracketed(self, balance: _Balance, slope: Array, k: int) -> Array:
        """The next temperatures where one joint depends on its own."""
        plain = self.ways.temperatures(balance.losses, np.zeros(len(slope)), balance.at)
        now, ahead = float(balance.at[k]), float(plain[k] - balance.at[k])
        if ahead > 0.0:
            self.low = now
        else:
            self.high = now
        unit = np.zeros(len(slope))
        unit[k] = 1.0
        resistance = float(self.ways.temperatures(unit, np.zeros(len(slope)), balance.at)[k]) - self.ways.ambient
        steepness = 1.0 - slope[k] * resistance  # of what is lacking, ahead/T
        if slope[k] < 0.0 and balance.losses[k] > 0.0:
            aim = now + self._along_oil(balance, slope, k, ahead, resistance)
        elif steepness >= FLATTEST:
            aim = now + ahead / steepness
        else:
            slope[k] = 0.0
            aim = now + REACH if ahead > 0.0 else -math.inf
        if not self.low <= aim <= self.high:
            slope[k] = 0.0
            aim = 0.5 * (self.low + self.high) if math.isfinite(self.low) else plain[k]
        losses = balance.losses + slope * (aim - balance.at)
        temperatures: Array = self.ways.temperatures(losses, np.zeros(len(slope)), balance.at)
        temperatures[k] = aim
        return temperatures

    def _along_oil(self, balance: _Balance, slope: Array, k: int, ahead: float, resistance: float) -> float:
        """The step [K] to where losses that fall as exp(-b T) flow off: nearly so do oils, whose b becomes less.

        slope: of joint k it becomes that of the chord.
        """
        loss = float(balance.losses[k])
        rate = -float(slope[k]) / loss
        if self.last is not None and self.last.losses[k] > 0.0:
            rate = math.log(self.last.losses[k] / loss) / float(balance.at[k] - self.last.at[k])

        def lacking(step: float) -> float:
            return ahead + resistance * loss * math.expm1(-rate * step) - step

        step = float(brentq(lacking, min(0.0, ahead), max(0.0, ahead))) if ahead else 0.0
        slope[k] = loss * math.expm1(-rate * step) / step if step else slope[k]
        return step

    def _damped(self, now: Array, aim: Array) -> Array:
        step = aim - now
        turned = -float(step @ self.last_step)
        if turned > TURNED * float(self.last_step @ self.last_step):
            self.damping = max(0.5 * self.damping, FLATTEST)
        damped: Array = now + self.damping * step
        return damped


def _losses(m: Mechanism, ways: Network, t_end: float | None) -> Array:
    """(n,) mean of what every joint loses [W]: over the last turn of the driver, or the whole run."""
    run = m.simulate(t_end)
    if run.interrupted:
        raise KeyboardInterrupt
    if not run.success:
        raise SolverError(f"its losses are not known: {run.message}", run)
    power = run.power()
    lost = {name: entry[0] / (power.t1 - power.t0) for name, _, _, *entry in power.balance()}
    losses = np.array([max(lost[name], 0.0) for name in ways.joints])
    losses[losses <= QUIET * losses.sum()] = 0.0
    if stuck := [name for name, loss, cooled in zip(ways.joints, losses, ways.cooled, strict=True)
                 if loss > 0.0 and not cooled]:  # fmt: skip
        k = ways.joints.index(stuck[0])
        raise InputError(
            f"{', '.join(stuck)}: no way leads to the air for what is lost there, {losses[k]:.4g} W; give cooling or"
            " conduction"
        )
    return losses
