"""Wear over many cycles: a cycle is simulated, its wear is carried over a jump of many cycles, and so on.

    V = k N s      Archard: volume V [m^3] lost under a force N [N] over a sliding distance s [m]

A jump is made once as a whole and once in two halves, with a cycle simulated in between; their difference is its error,
and both together are of second order.
Pins swing in their bushes, so that cycles differ: loads are the mean of those of the last few cycles.
Source: docs/wear.md; Archard, J. Appl. Phys. 24 (1953) 981-988.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rattle.analyses import arguments
from rattle.analyses.assembly.assembly import assemble
from rattle.analyses.driver_period import driver_period
from rattle.analyses.dynamics.events import require_workable
from rattle.analyses.dynamics.methods import choose_stepper
from rattle.analyses.dynamics.run import How
from rattle.errors import InputError, ModelError, Problem
from rattle.jit import functions
from rattle.jit.choices import TINY
from rattle.mechanism import Mechanism
from rattle.progress_bar import progress_bar
from rattle.questions.wear.cycle import FEWEST, Cycles, Sliding, State, together
from rattle.questions.wear.folder import Folder
from rattle.questions.wear.jumps import marched, per_cycle, sigma, straight
from rattle.questions.wear.pins import Depths, Pin, depths_of, pins_of, wearing_system
from rattle.questions.wear.worn import Reached, Worn
from rattle.solvers.stepper import ATOL, SMOOTH

Array = NDArray[np.float64]
ALL, ROUNDING = "all cycles", 1e-12
ERROR = 0.01  # of a jump: difference of two halves and a whole, share of the largest depth
MEAN = 4  # cycles whose mean is carried on: no two are alike where pins swing in their bushes
EARLY = 0.05  # depths below this share of those at the end need not be as exact
FIRST = 0.1  # depth of the first jump over the clearance
RTOL = 1e-6  # of the motion, unless the model says it
STOPS = ("depth", "volume")


class Question(NamedTuple):
    """What is asked of a study."""

    cycles: float
    jump: float  # nan: chosen
    period: float  # [s]
    depth: float  # [m] at which it ends
    volume: float  # [m^3]
    rtol: float
    atol: float


def wear(
    m: Mechanism, cycles: float | None = None, jump: float | str | None = None, cycle: float | None = None,
    stop: Mapping[str, float] | None = None, out: str | os.PathLike[str] | None = None, *, rtol: float | None = None,
    progress: bool | Callable[[float, float], None] = False,
) -> Worn:  # fmt: skip
    """Wear of all joints that have `wear`; see `Mechanism.wear`."""
    functions.start()
    system = wearing_system(m.model)
    require_workable(system)
    pins = pins_of(system)
    asked = _question(m, cycles, jump, cycle, stop, rtol)
    folder = Folder(out, m, asked._asdict(), pins) if out is not None else None
    stepper, _ = choose_stepper(system, system.model.settings.method, None, asked.period)
    if stepper.leaf.loop != SMOOTH:
        words = "wear is summed where all contacts are compliant; give impact contacts of other joints a force law"
        raise ModelError([Problem(("joints",), words)])
    how = How(stepper, asked.rtol, asked.atol, asked.period / FEWEST, wear=True)
    study = _Study(Cycles(system, pins, assemble(system), asked.period, how), asked, folder)
    study.go(_told(progress, asked.cycles))
    worn = Worn(m, tuple(pins), study.reached, tuple(study.notes()))
    if folder is not None:
        folder.finish(worn.mechanism, worn.columns)
    return worn


def _question(
    m: Mechanism, cycles: float | None, jump: float | str | None, cycle: float | None,
    stop: Mapping[str, float] | None, rtol: float | None,
) -> Question:  # fmt: skip
    """The arguments, or what the first joint that wears says.  Raises InputError."""
    written = [joint.wear for joint in m.model.joints.values() if joint.wear is not None]
    count = arguments.positive("cycles", written[0].cycles if cycles is None else cycles)
    size = _size(jump, _first(entry.jump for entry in written))
    if cycle is None:
        cycle = _first(entry.cycle for entry in written)
    period = driver_period(m.system) if cycle is None else cycle
    if period is None:
        raise InputError("no driver turns at constant rate; give the duration of a cycle in s")
    ends = _ends(stop or {})
    settings = m.model.settings
    tolerance = arguments.relative_tolerance(rtol or settings.rtol or RTOL)
    return Question(
        count, size, arguments.positive("cycle", period), ends.get("depth", math.inf),
        ends.get("volume", math.inf), tolerance, settings.atol or ATOL * tolerance,
    )  # fmt: skip


def _size(jump: float | str | None, written: float | None) -> float:
    """The cycles of a jump, nan if they are sought; written: those that a joint asks for.  Raises InputError."""
    if isinstance(jump, str) and jump != "auto":
        raise InputError(f'jump must be a number of cycles or "auto", got {jump!r}')
    chosen = written if jump is None else jump
    size = math.nan if chosen in (None, "auto") else arguments.positive("jump", chosen)
    if size < 1.0:
        raise InputError(f"jump must be at least one cycle, got {size:g}")
    return size


def _first(written: Iterable[float]) -> float | None:
    """The first of the numbers that the joints have; nan: a joint has none."""
    return next((number for number in written if not math.isnan(number)), None)


def _ends(stop: Mapping[str, float]) -> dict[str, float]:
    """Depth [m] and volume [m^3] at which the study ends.  Raises InputError."""
    if unknown := [key for key in stop if key not in STOPS]:
        raise InputError(f"stop knows {' and '.join(STOPS)}, not {unknown[0]!r}")
    return {key: arguments.positive(f"stop: {key}", value) for key, value in stop.items()}


class _Study:
    """One study on its way."""

    def __init__(self, cycles: Cycles, asked: Question, folder: Folder | None) -> None:
        self.cycles, self.asked, self.folder = cycles, asked, folder
        self.pins, self.values = cycles.pins, cycles.system.arrays["values"]
        kept = folder.read() if folder is not None else None
        self.reached = kept or Reached.start(depths_of(cycles.system, self.pins))
        if self.reached.cycle >= asked.cycles * (1.0 - ROUNDING):
            self.reached.outcome = self.reached.outcome or ALL
        elif self.reached.outcome == ALL:  # it is asked for more
            self.reached.outcome = ""
        self.cycles.simulated = self.reached.simulated
        self._last_profile = self.reached.depths  # of the last cycle that was simulated
        self.cut = 0.0  # jump to which a given one was cut [cycles]
        self.stiffest = 0.0  # sigma of the jumps

    def go(self, tell: Callable[[float], None]) -> None:
        """Cycles and jumps to the end, or until Ctrl-C."""
        now = self.reached
        try:
            if now.state is None:
                self._settle()
            while not now.outcome:
                self._jump()
                if self.folder is not None:
                    self.folder.write(now)
                tell(now.cycle)
        except KeyboardInterrupt:
            now.interrupted = True

    def _settle(self) -> None:
        """Cycles with the first profile: one that leaves the start behind, others that fill the memory."""
        now = self.reached
        now.state = self.cycles.run(now.depths, None).state
        while self._mean and len(now.recent) < MEAN - 1:
            seen = self.cycles.run(now.depths, now.settled)
            now.recent, now.state = [*now.recent, seen], seen.state

    @property
    def _mean(self) -> bool:
        """True if wear is carried on by the mean of the last cycles, which need not be alike."""
        return self.asked.jump != self.asked.jump and self.asked.cycles > 4 * MEAN

    def _run(self, depths: Depths, state: State, recent: list[Sliding]) -> tuple[Sliding, list[Sliding]]:
        """A cycle, or the mean with the last ones before it; and the last ones now."""
        seen = self.cycles.run(depths, state)
        if not self._mean:
            return seen, []
        return together([*recent, seen]), [*recent[1:], seen]

    def _jump(self) -> None:
        """One jump, with the cycles that it needs."""
        now, left = self.reached, self.asked.cycles - self.reached.cycle
        first, recent = self._run(now.depths, now.settled, now.recent)
        now.per_cycle = per_cycle(self.pins, first)
        size = self._size(first, left)
        while True:
            last, after, error, now.recent = self._tried(now.depths, first, size, recent)
            if self.asked.jump == self.asked.jump or size <= 1.0 or error <= ERROR:
                break
            size = max(1.0, size * min(0.5, max(0.1, 0.8 * math.sqrt(ERROR / error))))
        before = now.depths
        share, outcome = self._limit(before, after)
        if share < 1.0:
            after = [h + share * (g - h) for h, g in zip(before, after, strict=True)]
            last = first
        smoothed = [_smooth(pin, h) for pin, h in zip(self.pins, after, strict=True)]
        after = [h for h, _ in smoothed]
        self.stiffest = max(self.stiffest, size * sigma(self.pins, first))
        now.state = self.cycles.moved(last.state, self._last_profile, after)
        now.enter(after, share * size, error, max(change for _, change in smoothed))
        now.next = size * (4.0 if error <= 0.0 else min(4.0, max(0.2, 0.8 * math.sqrt(ERROR / error))))
        now.simulated = self.cycles.simulated
        now.outcome = outcome or (ALL if now.cycle >= self.asked.cycles * (1.0 - ROUNDING) else "")

    def _size(self, first: Sliding, left: float) -> float:
        """Cycles of the next jump."""
        if self.asked.jump == self.asked.jump:
            size, fastest = self.asked.jump, sigma(self.pins, first)
            if size * fastest > 2.0:
                size = self.cut = max(1.0, 1.0 / fastest)
            return min(size, left)
        size = self.reached.next
        if not size > 0.0:
            fastest = max(
                float(lost.max()) / pin.clearance for pin, lost in zip(self.pins, self.reached.per_cycle, strict=True)
            )
            size = FIRST / fastest if fastest > 0.0 else left
        size = min(max(size, 1.0), left)
        return left if left - size < 0.1 * size else size

    def _tried(
        self, h: Depths, first: Sliding, size: float, recent: list[Sliding]
    ) -> tuple[Sliding, Depths, float, list[Sliding]]:
        """A jump: the last cycle of it, the depths after it, its error, and the last cycles now."""
        self._last_profile = h
        if size <= 1.0:
            return first, straight(h, self.pins, first, size), 0.0, recent
        whole, half = self._carried(h, first, size), self._carried(h, first, 0.5 * size)
        middle, recent = self._run(half, self.cycles.moved(first.state, h, half), recent)
        self._last_profile = half
        both = self._carried(half, middle, 0.5 * size)
        error = max(float(np.abs(x - z).max()) for x, z in zip(whole, both, strict=True))
        largest = max(max(float(depths.max()) for depths in both), EARLY * self._expected())
        if self.asked.jump == self.asked.jump:  # of second order; where cycles differ by chance their mean is better
            both = [np.maximum(2.0 * z - x, y) for x, z, y in zip(whole, both, h, strict=True)]
        return middle, both, error / largest if largest > 0.0 else 0.0, recent

    def _expected(self) -> float:
        """Largest depth [m] at the end if wear went on as in the last cycle."""
        now, left = self.reached, self.asked.cycles - self.reached.cycle
        deepest = 0.0
        for pin, h, dh in zip(self.pins, now.depths, now.per_cycle, strict=True):
            deepest = max(deepest, min(float((h + left * dh).max()), pin.wall, self.asked.depth))
        return deepest

    def _carried(self, h: Depths, sliding: Sliding, size: float) -> Depths:
        """Depths after so many cycles like one."""
        if self.asked.jump == self.asked.jump:
            return straight(h, self.pins, sliding, size)
        return marched(self.values, h, self.pins, sliding, size)

    def _limit(self, before: Depths, after: Depths) -> tuple[float, str]:
        """Share of a jump after which the study ends, and why; 1 and "" if it goes on."""
        best, why = 1.0, ""
        for pin, h, g in zip(self.pins, before, after, strict=True):
            ends = ((pin.wall, f"{pin.joint} is worn through"), (self.asked.depth, f"{pin.joint} reached the depth"))
            for limit, reason in ends:
                for side in range(2):
                    share = _share(h[side], g[side], limit)
                    if share < best or (share <= best and not why and float(g[side].max()) >= limit):
                        best, why = min(best, share), reason
            share = _crossing(float(h.sum()) * pin.area, float(g.sum()) * pin.area, self.asked.volume)
            if share < best:
                best, why = share, f"{pin.joint} reached the volume"
        return best, why

    def notes(self) -> list[str]:
        """What a user should know of this study."""
        joints = self.cycles.system.model.joints
        worn = [(pin.joint, joints[pin.joint].wear) for pin in self.pins]
        remarks = [f"{name}: {wear.assumed}" for name, wear in worn if wear is not None and wear.assumed]
        if self.cut:
            remarks.append(
                f"jump = {self.asked.jump:g} is beyond the limit of stability, k K_w s J < 2: jumps were cut to"
                f' {self.cut:.4g} cycles (k K_w s J = 1); jump = "auto" knows no such limit'
            )
        elif self.asked.jump != self.asked.jump and self.stiffest > 1.0:
            remarks.append(
                f"jumps went up to {self.stiffest:.3g} times k K_w s J = 1: profiles were integrated under the loads of"
                " a cycle, where the pins lie follows from equilibrium"
            )
        return remarks


def _share(h: Array, g: Array, limit: float) -> float:
    """Share of a jump from depths h to g at which the deepest bin reaches the limit; inf if none does."""
    deep = g >= limit
    if not math.isfinite(limit) or not deep.any():
        return math.inf
    return float(max(0.0, ((limit - h[deep]) / np.maximum(g[deep] - h[deep], TINY)).min()))


def _crossing(before: float, after: float, limit: float) -> float:
    """Share of a jump at which a volume reaches the limit, 0 if it has before; inf if it does not."""
    if before >= limit:
        return 0.0
    return (limit - before) / (after - before) if limit <= after else math.inf


def _smooth(pin: Pin, h: Array) -> tuple[Array, float]:
    """Smoothed depths, their sum kept, and the largest change [m]."""
    if pin.smooth == 0.0:
        return h, 0.0
    change = pin.smooth * (np.roll(h, 1, axis=1) - 2.0 * h + np.roll(h, -1, axis=1))
    return h + change, float(np.abs(change).max())


def _told(progress: bool | Callable[[float, float], None], cycles: float) -> Callable[[float], None]:
    """What is called with the cycles done."""
    if callable(progress):
        return lambda done: progress(done, cycles)
    if not progress:
        return lambda done: None
    form = "{l_bar}{bar}| {n:.4g}/{total:.4g} cycles [{elapsed}<{remaining}]"
    bar = progress_bar(cycles, "wear", bar_format=form, delay=1.0)

    def tell(done: float) -> None:
        bar.update(done - bar.n)
        if done >= cycles:
            bar.close()

    return tell
