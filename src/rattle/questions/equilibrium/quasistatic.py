"""Quasi-static motion: a sequence of equilibria while the drivers move on.

Each instant has its equilibrium (see `equilibria`), the efforts of the drivers, and the force that a unit of
effort holds at each load (mechanical advantage), from the linearised balance

    [K  Phi_q^T; Phi_q  0] [dq; dlambda] = [dQ; 0]
"""

from __future__ import annotations

import logging
import math
import time
from dataclasses import dataclass

import numpy as np

from rattle.analyses.assembly.assembly import ideal_system
from rattle.analyses.travel import past_stops, without_stops
from rattle.equations.dense import dense_rows
from rattle.equations.placement import turned
from rattle.equations.rest_force import stiffness
from rattle.equations.system import System, compile_system
from rattle.jit import functions
from rattle.jit.choices import TINY
from rattle.questions.equilibrium.balance import StaticProblem
from rattle.questions.equilibrium.closed_play import rigid_model, without_guide_play, without_oil
from rattle.questions.equilibrium.compute import equilibria
from rattle.questions.equilibrium.loaded_pins import Loaded
from rattle.questions.equilibrium.position import Equilibrium
from rattle.questions.equilibrium.starts import opened
from rattle.questions.kinematics.compute import instants
from rattle.results.build import build_result
from rattle.results.event import Event
from rattle.results.result import Result
from rattle.results.trust import Trust

log = logging.getLogger("rattle")

SMALLEST = 1e-7  # share of an interval below which no step is tried
FARTHEST = 0.3  # [of the mechanism's size] step of a body beyond which a position belongs to another branch
TURNED = 0.7  # [-] cosine of the angle by which a pin may move around its bush in a step: half a right angle
AHEAD = 1e-3  # [of the interval] beyond a fold at which the equilibrium downhill of it is sought
INSTANT = 1e-9  # [s] interval that is not divided for that
CHANGE = (1e-10, 1e-3)  # [of the time, but at least of so many s] how near the time of a change of sides is found
RANK = 1e-13  # [-] singular values below this share of the largest are those of redundant constraints
TOGGLE = 1e-12  # [of the largest reaction] effort below which none is needed: a toggle
MOST_SNAPS = 5  # snap-throughs in one interval, at most
MOST_STEPS = 300  # steps in one interval, at most
MOST_TRIALS = 20_000  # positions evaluated in one interval, at most


@dataclass
class Path:
    """The path of equilibria so far: the last equilibrium and the one before it."""

    problem: StaticProblem
    ideal: StaticProblem | None  # of the mechanism without clearance
    last: Equilibrium
    before: Equilibrium | None = None
    loaded: Loaded | None = None  # pins in oil, whose places follow from their reactions without play
    held: StaticProblem | None = None  # of the mechanism without play in joints with oil

    def step(self, t: float) -> Equilibrium | None:
        """The equilibrium at t [s] that follows smoothly from the last one, or None."""
        last, before = self.last, self.before
        guesses = [last.q]
        if before is not None and last.t != before.t:
            guesses.insert(0, last.q + (last.q - before.q) * (t - last.t) / (last.t - before.t))
        self.problem.at(t)
        for guess in guesses:
            for start in self._floated(t, guess):
                solution = self.problem.find(start)
                if solution is not None and self._near(solution[0]):
                    return self.problem.finish(*solution)
        return None

    def _floated(self, t: float, guess: np.ndarray) -> list[np.ndarray]:
        """Guesses (3 nb,) with pins in oil where they carry at t [s]; none if there is no balance without play."""
        if self.loaded is None or self.held is None:
            return [guess]
        self.loaded.at(t)
        self.held.at(t)
        solution = self.held.find(guess)
        return self.loaded.starts(self.held, self.held.finish(*solution)) if solution is not None else []

    def _near(self, q: np.ndarray) -> bool:
        """True if a position (3 nb,) is so close to the last one that it belongs to the same branch."""
        if np.abs((q - self.last.q) / self.problem.scale).max() > FARTHEST * self.problem.system.size:
            return False
        last, other = self.problem.offsets(self.last.q), self.problem.offsets(q)
        cosine = (last * other).sum(axis=1) / (np.linalg.norm(last, axis=1) * np.linalg.norm(other, axis=1) + TINY)
        return bool((cosine > TURNED).all())

    def go(self, rest: Equilibrium) -> None:
        """Append an equilibrium that was found."""
        self.before, self.last = self.last, rest


def quasistatic(system: System, t_eval: np.ndarray, effort: float = 1.0) -> Result:
    """Equilibria at the times t_eval (n,) [s]; see `Mechanism.equilibrium`."""
    began = time.perf_counter()
    times = instants(t_eval)
    functions.start()
    original, system = system, without_guide_play(compile_system(without_stops(system.model)))
    first = equilibria(system, float(times[0]), effort=effort)
    rigid = rigid_model(system, floating=True)
    ideal = StaticProblem(ideal_system(system.model), float(times[0])) if rigid is not None else None
    path = Path(StaticProblem(rigid or system, float(times[0])), ideal, first.first_at(float(times[0])))
    if path.problem.oiled:
        path.loaded = Loaded(path.problem, StaticProblem(ideal_system(system.model), float(times[0])))
        path.held = StaticProblem(without_oil(rigid or system), float(times[0]))
    if rigid is not None and path.last.result.geometry["joints"] != {}:
        path.last = _on_links(path, first[0])
    kept = [path.last]
    events: list[Event] = []
    message = ""
    for t in times[1:]:
        message = _lead(path, float(t), events)
        if message:
            break
        kept.append(path.last)
    if message:
        log.warning(message)
    t, q = np.array([rest.t for rest in kept]), np.array([rest.q for rest in kept])
    v = np.gradient(q, t, axis=0) if len(t) > 1 else np.zeros_like(q)
    beyond = past_stops(original, t, q.reshape(len(t), -1, 3), v.reshape(len(t), -1, 3))
    notes = (*(note for note in (first.note,) if note), *beyond)
    return _result(path.problem, kept, events, message, notes, time.perf_counter() - began)


def _on_links(path: Path, start: Equilibrium) -> Equilibrium:
    """The start with its pins on rigid walls; compliant pins are followed as if they were rigid."""
    solution = path.problem.find(start.q)
    return path.problem.finish(*solution) if solution is not None else start


def _lead(path: Path, t: float, events: list[Event]) -> str:
    """Continue the path to time t [s] in as many steps as needed; returns "" or why it failed, in words."""
    snaps, steps, before = 0, 0, path.problem.trials
    while path.last.t < t:
        steps += 1
        if steps > MOST_STEPS or path.problem.trials - before > MOST_TRIALS:
            return (
                f"search stopped at t = {path.last.t:.8g} s after {steps - 1} steps towards t = {t:.8g} s: the"
                " equilibrium changes too fast there; ask for more instants, or for the motion with simulate"
            )
        whole = t - path.last.t
        share, reached = 1.0, None
        while reached is None and share > SMALLEST:
            reached = path.step(path.last.t + share * whole if share < 1.0 else t)
            share *= 0.5
        if reached is None:
            snaps += 1
            reached = _snap(path, t) if snaps <= MOST_SNAPS else None
            if reached is None:
                why = f": {path.problem.undefined}" if path.problem.undefined else ""
                return f"no equilibrium beyond t = {path.last.t:.8g} s near the last one{why}"
            events.append(Event(path.last.t, "", "snap"))
            path.last, path.before = reached, None
            continue
        pulled = [name for name in reached.pulled if name not in path.last.pulled]
        if pulled and path.ideal is not None:
            _change_sides(path, reached, pulled, events)
        else:
            path.go(reached)
    return ""


def _snap(path: Path, t: float) -> Equilibrium | None:
    """Snap-through: the stable equilibrium downhill of the last one, which has ceased to exist; or None."""
    ahead = min(t, path.last.t + AHEAD * (t - path.last.t)) if t - path.last.t > INSTANT else t
    path.problem.at(ahead)
    solution = path.problem.find(path.last.q, downhill=True)
    return path.problem.finish(*solution) if solution is not None else None


def _change_sides(path: Path, reached: Equilibrium, pulled: list[str], events: list[Event]) -> None:
    """Locate where N of some pins passed zero on the way to `reached`, and move these pins to the other side."""
    for name in pulled:
        low, high, n_low, n_high = path.last.t, reached.t, path.last[f"{name}.normal"], reached[f"{name}.normal"]
        t = high
        for _ in range(60):
            t = low + (high - low) * (n_low / (n_low - n_high)) if n_low > 0.0 else low
            t = min(max(t, low + 0.01 * (high - low)), high - 0.01 * (high - low))
            if high - low < CHANGE[0] * max(abs(high), CHANGE[1]):
                break
            middle = path.step(t)
            if middle is None:
                break
            n = middle[f"{name}.normal"]
            low, high, n_low, n_high = (t, high, n, n_high) if n > 0.0 else (low, t, n_low, n)
        events.append(Event(t, name, "side"))
    events.sort(key=lambda event: event.t)
    assert path.ideal is not None
    path.ideal.at(reached.t)
    offsets = dict(zip(path.problem.links, path.problem.offsets(reached.q), strict=True))
    turned = {name: -e if name in reached.pulled else e for name, e in offsets.items()}
    path.problem.at(reached.t)
    solution = path.problem.find(opened(path.ideal, reached.q, turned))
    other = path.problem.finish(*solution) if solution is not None else None
    path.go(reached)
    if other is not None and len(other.pulled) < len(reached.pulled):
        path.last, path.before = other, None


# ---------------------------------------------------------------- mechanical advantage
def advantage(problem: StaticProblem, rest: Equilibrium) -> dict[tuple[str, str], float]:
    """(load, driver) -> force or moment held at the load per unit of the driver's effort, signed [-, m or 1/m].

    Only for loads of constant direction (force, torque); inf if no effort is needed (a toggle).
    """
    system, workspace = problem.system, problem.workspace
    drivers = [name for name in system.joints if name in system.model.drivers]
    acting = [name for name, load in system.model.loads.items() if load.kind in ("force", "torque")]
    if not drivers or not acting:
        return {}
    n, nr = 3 * system.body_count, system.row_count
    problem.reduce(rest.q)
    tangent = np.zeros((n, n))
    stiffness(workspace, problem.t, rest.q, problem.step, problem.out, tangent)
    rows = dense_rows(system, workspace)
    whole = np.block([[tangent, rows.T], [rows, np.zeros((nr, nr))]])
    scale = np.concatenate([problem.scale, np.ones(nr)])
    ratios = {}
    for name in acting:
        right = np.zeros(n + nr)
        right[:n] = _direction(problem, rest, name)
        answer = np.linalg.lstsq(whole * scale[:, None] * scale, right * scale, rcond=RANK)[0] * scale
        for driver in drivers:
            row = system.first_row(driver)
            effort = -float(answer[n + row])  # effort for one unit of the load
            ratios[name, driver] = -1.0 / effort if abs(effort) > TOGGLE * np.abs(answer[n:]).max() else math.inf
    return ratios


def _direction(problem: StaticProblem, rest: Equilibrium, name: str) -> np.ndarray:
    """(3 nb,) generalised force [N, N, N*m] of a load of 1 N or 1 N*m in its present direction."""
    system, workspace = problem.system, problem.workspace
    load = system.model.loads[name]
    unit = np.zeros(3 * system.body_count)
    if load.b.body == "ground":
        return unit
    k = 3 * system.bodies.index(load.b.body)
    if load.kind == "torque":
        unit[k + 2] = 1.0
        return unit
    at = int(system.arrays["load"][list(system.model.loads).index(name), 3])
    px, py, fx, fy, turning = workspace.values[at : at + 5]
    angle = float(rest.q[k + 2])
    if turning == 1.0:
        fx, fy = turned(angle, (fx, fy))
    size = math.hypot(fx, fy)
    if size > 0.0:
        fx, fy = fx / size, fy / size
        arm_x, arm_y = turned(angle, (px, py))
        unit[k : k + 3] = fx, fy, arm_x * fy - arm_y * fx
    return unit


ADVANTAGE_UNITS = {("torque", "N*m"): "", ("force", "N"): "", ("force", "N*m"): "1/m", ("torque", "N"): "m"}


def _result(
    problem: StaticProblem,
    kept: list[Equilibrium],
    events: list[Event],
    message: str,
    notes: tuple[str, ...],
    wall: float,
) -> Result:
    system, first = problem.system, kept[0].result
    names, units = list(first.stored), {name: first.unit(name) for name in first.stored}
    table = [[rest[name] for name in names] for rest in kept]
    extra = {"equilibrium.stiffness": "N/m", "equilibrium.stable": "", "equilibrium.admissible": ""}
    for line, rest in zip(table, kept, strict=True):
        line += [rest.eigenvalue, float(rest.stable), float(rest.admissible)]
        problem.at(rest.t)
        for (load, driver), value in advantage(problem, rest).items():
            effort = system.model.drivers[driver].leaf.effort[1]
            name = f"{load}.advantage" if len(system.model.drivers) == 1 else f"{load}.advantage_{driver}"
            extra[name] = ADVANTAGE_UNITS[system.model.loads[load].kind, effort]
            line.append(value)
    pulled = {name: float(np.mean([name in rest.pulled for rest in kept])) for name in kept[0].normals}
    first_pull = {name: next((rest.t for rest in kept if name in rest.pulled), None) for name in pulled}
    trust = Trust(
        drift=max(rest.gap for rest in kept), t_end=kept[-1].t, horizon=kept[-1].t, pulled=pulled,
        first_pull=first_pull, nonunique=kept[0].nonunique, notes=notes,
    )  # fmt: skip
    return build_result(
        system.model, "quasi-static path", t=[rest.t for rest in kept], data=np.array(table, dtype=float),
        names=[*names, *extra], units=units | extra, trust=trust, events=events, message=message,
        stats={"positions": len(kept), "residual": max(rest.residual for rest in kept), "wall_time": wall},
    )  # fmt: skip
