"""Search for the equilibria of a mechanism: the starts that are tried, their order, and when the search ends.

A mechanism with one degree of freedom is moved along all of its motion.  With more, descents of the potential come
first, from random positions and from the lowest one found; then Newton's method from starts of several kinds: found
positions with bodies turned over, positions along the free motion, random positions.  The kind whose equilibria cost
least is continued.  The search ends when many starts in a row bring nothing new, or when its work is used up; work is
counted in positions evaluated, so that the result is reproducible.

Every pin with clearance is a massless link; each equilibrium has partners with the pin on the other side of its bush
(n and -n).  They are started from the ideal mechanism's equilibrium with pins displaced along its reactions.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from rattle.analyses.assembly.assembly import consistent_start, ideal_system
from rattle.analyses.assembly.rank import RANK, scaled_rows
from rattle.analyses.travel import left_out, with_friction, with_stops
from rattle.description.model import Contact
from rattle.elements.custom import load_law
from rattle.equations.closure import merit_at
from rattle.equations.motion import drive
from rattle.equations.system import System, is_link
from rattle.errors import AssemblyError, InputError
from rattle.jit import functions
from rattle.questions.equilibrium.balance import MOST_TURN, Found, StaticProblem
from rattle.questions.equilibrium.closed_play import rigid_model, with_rigid_pins, without_guide_play, without_oil
from rattle.questions.equilibrium.loaded_pins import pressed
from rattle.questions.equilibrium.position import Equilibria, Equilibrium
from rattle.questions.equilibrium.resting import MOST, Stopped, combinations, resting_system
from rattle.questions.equilibrium.resting_surfaces import Surfaces, held_system, rigid_surfaces, soft_surfaces
from rattle.questions.equilibrium.starts import Turning, along, around, opened, same, sides, tiny
from rattle.questions.kinematics.singular_positions import why_stuck
from rattle.questions.kinematics.sweep import begin
from rattle.solvers.positions import position_sweep

RANDOM_STARTS = 48  # of a mechanism without a degree of freedom, for its other branches
FEW_STARTS = 12  # of a mechanism with one degree of freedom
WORK = 36_000.0  # of all starts together, in the units of `price`
DOWNHILL = 0.5  # share of it that is used for descents
PRESSED = 0.3  # additional share, to let compliant pins sink in
QUIET = 20  # starts in a row without a new equilibrium after which the search ends, plus as many per degree of freedom
QUIET_DOWNHILL = (4, 2)  # the same for descents
TRIALS_EACH = 250  # positions evaluated from one start of a descent, at most
TRIALS_NEWTON = 40  # and of Newton's method, which converges in far fewer if it does
NEAR = 1e-3  # [of the smallest length] distance from a known equilibrium at which a search towards it is given up
ALIKE = 1e-9  # [of the forces, or of forces times size] difference of energies and residuals that is only rounding
AS_CLOSED = 1e-12  # [of the mechanism's size] by which a gap may grow where a whole turn of a body is taken away
WIDE = 1.0  # rotation of a body in one step of a descent, at most [rad]: any valley will do


def price(problem: StaticProblem, trials: int, assessed: bool) -> float:
    """Estimated cost of a start for a mechanism of this size, roughly in microseconds of one core [1e-6 s]."""
    n = 3.0 * problem.system.body_count
    look = 3.0 + 0.05 * n * n + 0.0003 * n * n * n
    weighing = 150.0 + 2.0 * look + (1000.0 if problem.redundant else 0.0)
    return 60.0 + look * trials + (weighing if assessed else 0.0)


def equilibria(system: System, t: float = 0.0, branches: str = "near", effort: float = 1.0) -> Equilibria:
    """All equilibria found with the drivers at t [s]; see `Mechanism.equilibrium`."""
    if branches not in ("near", "all"):
        raise InputError(f"branches must be 'near' or 'all', got {branches!r}")
    functions.start()
    load_law.forget()
    if not with_stops(system.model):
        return _equilibria(system, t, branches, effort)
    stopped, answer, parts = Stopped(without_guide_play(system), t), [], []
    ways = list(itertools.islice(combinations(system.model), MOST + 1))
    for resting in ways[:MOST]:
        try:
            part = _equilibria(resting_system(system, resting, {}), t, branches, effort)
        except AssemblyError:  # both ends cannot be reached together
            if not resting:
                raise
            continue
        parts.append(part)
        answer += stopped.taken(part, resting)
    start = position_at(resting_system(system, {}), t)
    cut = len(ways) > MOST or any(part.stopped for part in parts)
    undefined = next((part.undefined for part in parts if part.undefined), "")
    if stopped.passed and not answer and not undefined:
        undefined = f"the positions of balance without stops are beyond those of {', '.join(stopped.passed)}"
    first, starts = parts[0], sum(part.starts for part in parts)
    extent = f"every combination of stops: {first.extent}" if first.extent else ""
    ends = first.left_out, first.rubbing, first.moving
    return Equilibria(_sorted(answer, start), starts, cut, extent, effort, undefined, *ends)


def _equilibria(system: System, t: float, branches: str, effort: float) -> Equilibria:
    """`equilibria` of a mechanism without stops."""
    ends = left_out(system.model), with_friction(system.model)
    system = without_guide_play(system)
    names = rigid_surfaces(system)
    if not names:
        return _searched(system, t, branches, effort, ends)
    start = position_at(system, t)
    soft = soft_surfaces(system, names, t, start)
    answer, surfaces = _searched(soft, t, branches, effort, ends), Surfaces(soft, names, t)
    settled: list[Equilibrium] = []
    for rest in itertools.chain(map(surfaces.settled, answer), surfaces.near(start)):
        if rest is not None and not same(
            system, rest.q, np.array([equilibrium.q for equilibrium in settled]).reshape(-1, len(start))
        ):
            settled.append(rest)
    answer[:] = _sorted(settled, start)
    return answer


def _searched(system: System, t: float, branches: str, effort: float, ends: tuple[str, str]) -> Equilibria:
    """`equilibria` of a mechanism whose surfaces give way; ends: what is left out, see `Equilibria`."""
    dry = without_oil(system)  # a film holds its pin in one place: the search closes the joint
    floats, rigid = dry is not system, rigid_model(dry)
    shut = ideal_system(system.model) if rigid is not None or floats else system
    start = position_at(shut, t)
    problem = StaticProblem(shut, t)
    search = Search(problem, effort if rigid is None else 0.5 * effort)
    search.explore(start, branches == "all")
    answer = problem.describe(search.found)
    if rigid is None:
        answer = search.pressed(system, answer) if floats else answer
        extent = f"without play {search.extent}" if floats and search.extent else search.extent
        return Equilibria(
            _sorted(answer, start), search.starts, search.stopped, extent, effort, problem.undefined, *ends,
            search.moving,
        )  # fmt: skip
    play = StaticProblem(rigid, t)
    partners = Search(play, 0.5 * effort)
    partners.partners(sides(problem, play, sorted(answer, key=_height)))
    if not partners.found:
        partners.explore(position_at(rigid, t), True)
    reference = start + _first_offset(problem, rigid, start)
    pressing = play.describe(partners.found)
    if any(joint.is_loose and _compliant(joint.contact) for joint in system.model.joints.values()):
        pressing = partners.pressed(with_rigid_pins(system), pressing)
    stopped = search.stopped or partners.stopped
    extent = f"without play {search.extent}; every pin was put on either side of its bush" if search.extent else ""
    starts, undefined = search.starts + partners.starts, problem.undefined or play.undefined
    return Equilibria(_sorted(pressing, reference), starts, stopped, extent, effort, undefined, *ends, partners.moving)


def _height(rest: Equilibrium) -> tuple[bool, float]:
    """Sorting key: stable positions first, then by potential energy [J]."""
    return not rest.stable, rest["energy.potential"]


def _compliant(contact: Contact | None) -> bool:
    return contact is not None and contact.normal is not None


def position_at(system: System, t: float) -> np.ndarray:
    """The assembled position (3 nb,) [m, m, rad] at time t [s]; a driven mechanism is moved there from t = 0.

    Raises AssemblyError if it cannot be assembled, or cannot reach t.
    """
    try:
        start = consistent_start(system, 0.0)
    except AssemblyError:
        if t == 0.0:
            raise
        return consistent_start(system, t).q
    if t == 0.0:
        return start.q
    workspace = system.workspace()
    drive(workspace, 0.0)
    merit_at(workspace, start.q)
    driven = (
        system.row_count and np.linalg.matrix_rank(scaled_rows(system, workspace), tol=RANK) == 3 * system.body_count
    )
    if not driven:
        return consistent_start(system, t).q
    led = begin(system, start)
    if not len(led.go(np.array([t]), False)):
        raise AssemblyError(f"the position at t = {t:g} s cannot be reached: {why_stuck(led)}")
    return np.array(led.node[position_sweep.Q_NEW])


class Search:
    """The equilibria of one mechanism found so far, and the work spent on them."""

    def __init__(self, problem: StaticProblem, effort: float) -> None:
        self.problem, self.effort = problem, effort
        self.found: list[Found] = []
        self.starts = 0
        self.stopped = False  # True: the work was used up before the search was complete
        self.extent = ""  # how far the search went, in words
        self.moving = ""  # bodies that drivers move while films see it, in words
        self.arrived = False  # True: the last start led to an equilibrium, known or new
        self._work, self._left = 0.0, WORK * effort
        self._known = np.zeros((16, 3 * problem.system.body_count))
        self._count = 0
        self._near = NEAR * tiny(problem.system)
        self._trials = problem.trials
        self._turning: Turning | None = None
        self._start = np.zeros(3 * problem.system.body_count)
        self._quiet = 0  # starts since the last one with a new equilibrium
        first = [problem.system.first_row(name) for name in problem.links]
        self._links = np.array(first, np.int64)

    def spent(self) -> bool:
        """True if the work is used up; the first start is always tried."""
        return self._beyond(self._left)

    def _beyond(self, most: float) -> bool:
        return self.starts > 0 and self._work >= most

    def try_start(self, start: np.ndarray, downhill: bool) -> bool:
        """Try one start (3 nb,) [m, m, rad]; True if it led to a new equilibrium."""
        problem = self.problem
        self.starts += 1
        most, turn = (TRIALS_EACH, WIDE) if downhill else (TRIALS_NEWTON, MOST_TURN)
        solution = problem.find(start, downhill, self._known[: self._count], self._near, most, turn)
        self.arrived = problem.arrived
        assessed = solution is not None and not same(problem.system, solution[0], self._known[: self._count])
        new = False
        if solution is not None and assessed:
            self._remember(solution[0])
            candidate = self._assessed(*solution)
            new = not any(_one_family(candidate, other, self._links, problem.system.size) for other in self.found)
            if new:
                self.found.append(candidate)
        self._work += price(problem, problem.trials - self._trials, assessed)
        self._trials = problem.trials
        return new

    def _assessed(self, q: np.ndarray, iterations: int) -> Found:
        """Assess a position, after removing whole turns of bodies if they make no difference."""
        if self._turning is not None:
            same = self._turning.unwound(q, self._start)
            if (same != q).any():
                wound, other = self.problem.assess(q, iterations), self.problem.assess(same, iterations)
                slight = ALIKE * wound.force
                alike = abs(wound.potential - other.potential) <= slight * self.problem.system.size
                closed = other.gap <= wound.gap + AS_CLOSED * self.problem.system.size
                return other if alike and closed and other.residual <= wound.residual + slight else wound
        return self.problem.assess(q, iterations)

    def _remember(self, q: np.ndarray) -> None:
        if self._count == len(self._known):
            self._known = np.vstack([self._known, np.zeros_like(self._known)])
        self._known[self._count] = q
        self._count += 1

    # ------------------------------------------------------------ without known equilibria
    def explore(self, start: np.ndarray, everywhere: bool) -> None:
        """Try all kinds of starts around `start` (3 nb,) [m, m, rad]; everywhere: search other branches too."""
        turning, random = Turning(self.problem.system), np.random.default_rng(0)
        self._turning, self._start = turning, start
        _, null = self.problem.reduce(start)
        dof = null.shape[1]
        if dof > 1:
            self._many(start, turning, random, dof)
            return
        starts = [start, *(around(self.problem, start, null[:, 0]) if dof else ())]
        anywhere = (turning.anywhere(start, random) for _ in itertools.count())
        count = 0
        if everywhere or dof:
            count = int((RANDOM_STARTS if everywhere else FEW_STARTS) * max(1.0, self.effort))
        for position in itertools.chain(starts, itertools.islice(anywhere, count)):
            for downhill in (False, True)[: dof + 1]:
                if self.spent():
                    self.stopped = True
                    return
                self.try_start(position, downhill)
        if dof:  # other branches, as long as new ones are found
            self._until_quiet({"random": anywhere}, 2 * QUIET, self._left)
        self.extent = (
            "its one degree of freedom was searched from end to end"
            if dof
            else "joints and drivers leave no degree of freedom"
        )

    def _many(self, start: np.ndarray, turning: Turning, random: np.random.Generator, dof: int) -> None:
        """Descents, then Newton's method from the kind of starts whose equilibria cost least."""
        downhill = {"downhill": self._downhill(start, turning, random)}
        least, each = QUIET_DOWNHILL
        surely = self._until_quiet(downhill, least + each * dof, DOWNHILL * self._left)
        kinds = {
            "turned": self._turned(turning, random),
            "along": along(self.problem, start),
            "random": itertools.chain([start], (turning.anywhere(start, random) for _ in itertools.count())),
        }
        enough = self._until_quiet(kinds, QUIET * (1 + dof), self._left)
        if enough and not surely:
            enough = self._until_quiet(downhill, least + each * dof, self._left)
        self.stopped = not enough
        self.extent = f"the last {self._quiet} of {self.starts} starts brought nothing new"

    def _until_quiet(self, kinds: Mapping[str, Iterator[np.ndarray]], enough: int, most: float) -> bool:
        """Try starts of these kinds until `enough` in a row bring nothing new; False if the work is used up before."""
        going, spent, brought = dict(kinds), dict.fromkeys(kinds, 0.0), dict.fromkeys(kinds, 1)
        self._quiet = 0
        while going and self._quiet < enough * max(1.0, self.effort):
            if self._beyond(most):
                return False
            kind = min(going, key=lambda name: spent[name] / brought[name])
            start = next(going[kind], None)
            if start is None:
                del going[kind]
                continue
            before = self._work
            new = self.try_start(start, kind == "downhill")
            spent[kind] += self._work - before
            brought[kind] += new
            self._quiet = 0 if new else self._quiet + 1
        return True

    def _downhill(self, start: np.ndarray, turning: Turning, random: np.random.Generator) -> Iterator[np.ndarray]:
        """The start, then by turns a random position and one near the lowest equilibrium found."""
        yield start
        while True:
            yield turning.anywhere(start, random)
            lowest = min(self.found, key=lambda solution: (solution.falling, solution.potential), default=None)
            yield turning.nearby(start if lowest is None else lowest.q, random)

    def _turned(self, turning: Turning, random: np.random.Generator) -> Iterator[np.ndarray]:
        """Found positions mirrored, then with each group of bodies turned over, then with several groups."""
        k, groups = 0, turning.groups
        while groups:
            if k < len(self.found):
                yield turning.mirrored(self.found[k].q, self._start)
                for group in groups:
                    yield turning.turned(self.found[k].q, [group], self._start)
                k += 1
            elif self.found:
                q = self.found[int(random.integers(len(self.found)))].q
                chosen = [group for group in groups if random.random() < 0.5]
                yield turning.turned(q, chosen, self._start)
            else:
                return

    # ------------------------------------------------------------ pins on either side of their bushes
    def partners(self, starts: Iterable[np.ndarray]) -> None:
        """Try starts (3 nb,) [m, m, rad] close to equilibria: by Newton's method, and by a descent if it fails."""
        for start in starts:
            if self.spent():
                self.stopped = True
                return
            self.try_start(start, False)
            if not self.arrived and not self.spent():
                self.try_start(start, True)

    def pressed(self, system: System, held: list[Equilibrium]) -> list[Equilibrium]:
        """Equilibria with pins that sink in or float, from those that hold every pin and press where they have to."""
        most = self._left + PRESSED * WORK * self.effort - self._work
        admissible = sorted((rest for rest in held if rest.admissible), key=_height)
        outcome = pressed(self.problem, system, admissible, most, price)
        self._work += outcome.work
        self.stopped = self.stopped or outcome.stopped
        self.moving = ", ".join(map(repr, outcome.moving))
        return outcome.found


def _one_family(first: Found, other: Found, links: np.ndarray, size: float) -> bool:
    """True if a free motion, without change of energy, leads from one equilibrium to the other.

    links: (k,) rows of the massless links; the signs of their multipliers tell the sides of the pins.
    size: size of the mechanism [m].
    """
    if not first.neutral or (first.neutral, first.falling) != (other.neutral, other.falling):
        return False
    if abs(first.potential - other.potential) > ALIKE * first.force * size:
        return False
    pulls, others = first.multiplier[links], other.multiplier[links]
    return bool((pulls * others >= -((ALIKE * first.force) ** 2)).all())


def _first_offset(ideal: StaticProblem, rigid: System, start: np.ndarray) -> np.ndarray:
    """(3 nb,) change [m, m, rad] of the ideal position by the given offsets of pins at the start."""
    offsets = rigid.model.initial.offsets
    wanted = {
        name: np.array(at)
        for name, at in offsets.items()
        if name in rigid.model.joints and is_link(rigid.model.joints[name])
    }
    return opened(ideal, start, wanted) - start if wanted else np.zeros_like(start)


def _sorted(members: list[Equilibrium], start: np.ndarray) -> list[Equilibrium]:
    """Admissible and stable ones first, then by their distance from the initial guess."""

    def key(rest: Equilibrium) -> tuple[bool, bool, float]:
        apart = rest.q - start
        apart[2::3] = (apart[2::3] + math.pi) % (2 * math.pi) - math.pi
        fine = rest.admissible and not rest.falling
        return not (fine and rest.stable), not fine, float(np.linalg.norm(apart))

    return sorted(members, key=key)


def static_problem(system: System, rest: Equilibrium, sticks: bool = False) -> StaticProblem:
    """The equilibrium problem to which an equilibrium belongs, with rigid or with compliant pins, held at its stops.

    sticks: bodies stick to or roll on surfaces with friction.
    """
    system = without_guide_play(system)
    if rest.touching:
        system = held_system(system, rest.q, rest.touching, sticks)
    if with_stops(system.model):
        system = resting_system(system, rest.resting)
    rigid = rigid_model(system)
    if rigid is not None and rigid.row_count == len(rest.multiplier):
        return StaticProblem(rigid, rest.t)
    return StaticProblem(with_rigid_pins(system), rest.t)
