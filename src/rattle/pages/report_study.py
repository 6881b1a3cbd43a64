"""What a report is about: a mechanism with the analyses that apply to it, and the reasons why others do not."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from rattle.errors import AssemblyError, MissingPackage, ModelError, SolverError
from rattle.studies.poincare import driver_period

if TYPE_CHECKING:
    from rattle.analyses.accuracy.clearance_error import Accuracy
    from rattle.analyses.check import Check
    from rattle.analyses.statics.equilibrium import Equilibria
    from rattle.analyses.statics.modes import Modes
    from rattle.mechanism import Mechanism
    from rattle.results.result import Result
    from rattle.studies.power.power import Power

POSITIONS = 61  # of studies that go through positions of the driver
TURNS = 0.02  # [rad] a body turns if its angle changes by more
FAILURES = (ModelError, AssemblyError, SolverError, MissingPackage, ValueError, ArithmeticError)
Found = TypeVar("Found")
_log = logging.getLogger("rattle")


@dataclass
class Study:
    """A mechanism and what was found out about it; None: it does not apply, or could not be done."""

    m: Mechanism
    trouble: list[str] = field(default_factory=list)  # what went wrong, in words: it stands at the top in red
    reasons: dict[str, str] = field(default_factory=dict)  # why a study is not in the report
    check: Check | None = None
    run: Result | None = None
    ideal: Result | None = None  # the same motion without play
    rest: Equilibria | None = None
    modes: Modes | None = None
    path: Result | None = None  # the quasi-static motion of a mechanism that is fully driven
    accuracy: Accuracy | None = None
    power: Power | None = None

    @property
    def loose(self) -> list[str]:
        """Joints with clearance that is not closed."""
        joints = self.m.model.joints.items()
        return [name for name, one in joints if one.clearance > 0.0 and one.contact and not one.contact.closed]

    @property
    def output(self) -> str:
        """The curve that shows best what the mechanism does: of the last body that moves and is not itself driven."""
        run = self.run
        if run is None:
            return ""
        every = list(self.m.model.bodies)
        bodies = [body for body in every[::-1] if body not in self.driven] or every
        moving = (motion_of(run, body) for body in bodies)
        return next((name for name in moving if np.ptp(run[name]) > 0.0), f"{bodies[0]}.angle" if bodies else "")

    @property
    def driven(self) -> set[str]:
        """Bodies whose motion against the ground a driver prescribes."""
        model, found = self.m.model, set[str]()
        for one in model.drivers.values():
            joint = model.joints.get(one.joint)
            ends = {joint.a.body, joint.b.body} if joint else {one.point.body if one.point else "", "ground"}
            found |= ends - {"ground"} if "ground" in ends else set()
        return found


def motion_of(run: Result, body: str) -> str:
    """The coordinate by which a body moves: its angle if it turns, else the larger of its translations."""
    if np.ptp(run[f"{body}.angle"]) > TURNS:
        return f"{body}.angle"
    return max((f"{body}.x", f"{body}.y"), key=lambda name: float(np.ptp(run[name])))


def study(m: Mechanism, t_end: float | None = None, progress: bool = False) -> Study:
    """Run the analyses that apply to a mechanism.

    t_end: end of the motion [s].  Raises ModelError for a model that cannot be read, ValueError for such an end; what
    goes wrong later is in `trouble`.
    """
    _ = m.model
    found = Study(m)
    found.check = _tried(found, "check", "checking the mechanism", m.check, fatal=True)
    if found.check is None:
        return found
    found.run = _tried(
        found, "motion", "computing the motion, twice: the second run tells how far the first can be trusted",
        lambda: m.simulate(t_end, horizon=True, progress=progress).whole(), fatal=True,
    )  # fmt: skip
    if found.run is None:
        return found
    if not found.run.success:
        found.trouble.append(f"The motion ends early, at t = {found.run.trust.t_end:.4g} s: {found.run.message}")
    _without_play(found)
    _at_rest(found)
    _over_a_cycle(found)
    _how_accurate(found)
    return found


def _tried(found: Study, what: str, words: str, action: Callable[[], Found], fatal: bool = False) -> Found | None:
    """What an analysis returns, or None and its reason."""
    _log.info(f"report: {words}")
    try:
        return action()
    except FAILURES as error:
        if fatal and isinstance(error, ValueError) and not isinstance(error, ModelError | AssemblyError):
            raise
        found.reasons[what] = in_words(error)
        if fatal:
            found.trouble.append(found.reasons[what])
        return None


def in_words(error: Exception) -> str:
    """What an error says, of a model without the file and the lines where it is: the report has no use for them."""
    if not isinstance(error, ModelError):
        return str(error)
    places: dict[str, list[str]] = {}
    for problem in error.problems:
        places.setdefault(problem.message, []).append(problem.key)
    return "; ".join(f"{', '.join(filter(None, keys))}: {text}".lstrip(": ") for text, keys in places.items())


def _without_play(found: Study) -> None:
    run = found.run
    if not found.loose or run is None or not run.success:
        return
    ideal = _tried(
        found, "without play", "computing the motion without play, for comparison",
        lambda: found.m.ideal().simulate(run.trust.t_end, t_eval=run.t).whole(),
    )  # fmt: skip
    found.ideal = ideal if ideal is not None and ideal.success else None


def _at_rest(found: Study) -> None:
    m = found.m
    if not m.model.drivers:
        found.rest = _tried(found, "equilibrium", "searching for equilibria", m.equilibrium)
        if found.rest:
            first = found.rest[0]
            found.modes = _tried(found, "modes", "computing natural frequencies", lambda: m.modes(equilibrium=first))
        elif found.rest is not None:
            found.reasons["equilibrium"] = found.rest.note or "no position was found in which all forces balance"
        return
    found.reasons["equilibrium"] = "drivers hold the mechanism"
    run = found.run
    fully = found.check is not None and found.check.mobility == 0
    if run is not None and fully and m.model.loads and not m.model.states and not found.loose:
        times = np.linspace(0.0, run.trust.t_end, POSITIONS)
        found.path = _tried(found, "quasi-static", "computing the quasi-static motion", lambda: m.equilibrium(times))


def _over_a_cycle(found: Study) -> None:
    run = found.run
    if run is None or not run.success:
        return

    def flows() -> Power | None:
        power = run.power()
        one = power.cycle  # found here, where it may fail
        return power if float(np.abs(one.into).max(initial=0.0)) > 0.0 else None

    found.power = _tried(found, "power", "following the energy", flows)
    if found.power is None:
        found.reasons.setdefault("power", "no energy is exchanged")


def _how_accurate(found: Study) -> None:
    if not found.loose or found.run is None:
        found.reasons["accuracy"] = "no joint has play"
        return
    if not found.m.model.drivers:
        found.reasons["accuracy"] = "nothing drives the mechanism, so it has no position that play could falsify"
        return
    end = min(driver_period(found.m.system) or np.inf, found.run.trust.t_end)
    found.accuracy = _tried(
        found, "accuracy", "computing how far play lets the output deviate",
        lambda: found.m.accuracy(found.output, np.linspace(0.0, end, POSITIONS)),
    )  # fmt: skip
