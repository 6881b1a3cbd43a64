"""Clearance-induced error of an output (kinematic accuracy).

Every pin with clearance may be anywhere in its circle |e_i| <= r_i, every block anywhere between its walls.
With all other joints closed the output o is a function of these displacements:

    Phi_i(q) = e_i,   o(q):     do/de = y,   Phi_q^T y = do/dq     (one linear solve per output)
    |o - o_ideal| <= sum_i r_i |y_i|  to first order: the worst case;  sqrt(sum_i (r_i |y_i|)^2): root sum square

The exact extremes lie on the circles, and for a block on the curved boundary of its displacements, see `extremes`.
Loads press the pins to one side, e_i = r_i n_i; with one load conjugate to the output: sum r_i |R_i| / |load|.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from rattle.analyses.assembly.assembly import assemble, ideal_system
from rattle.analyses.history import require_no_states
from rattle.analyses.travel import out_of_place
from rattle.description.model import Joint
from rattle.equations.system import System
from rattle.errors import InputError, ModelError, Problem
from rattle.jit import functions
from rattle.questions.accuracy.displaced_pins import Displaced
from rattle.questions.accuracy.extremes import extreme
from rattle.questions.equilibrium.balance import StaticProblem
from rattle.questions.equilibrium.closed_play import rigid_model, without_guide_play
from rattle.questions.equilibrium.position import Equilibrium
from rattle.questions.equilibrium.starts import opened
from rattle.questions.kinematics.compute import instants, require_driven
from rattle.questions.kinematics.singular_positions import why_stuck
from rattle.questions.kinematics.sweep import Sweep, begin
from rattle.results.chosen_units import chosen, shown_in
from rattle.results.display import quantity, scale, table
from rattle.solvers.positions import position_sweep as swept

if TYPE_CHECKING:
    from matplotlib.figure import Figure

UNLOADED = 1e-9  # share of the largest reaction up to which a reaction is rounding alone
LEAST_FORCE = 1e-9  # [N] largest reaction, at least, of which UNLOADED is taken: no pin may carry a load
RATES = ("vx", "vy", "omega", "ax", "ay", "alpha", "power")  # quantities that are zero or undefined at rest


@dataclass(frozen=True, repr=False)
class Accuracy:
    """How far an output may deviate at n instants, k joints with clearance; the output's SI unit is `unit`."""

    of: str  # the name of the output
    unit: str
    t: np.ndarray  # (n,) [s]
    nominal: np.ndarray  # (n,) the output without clearance
    joints: tuple[str, ...]
    contributions: np.ndarray  # (n, k) largest deviation caused by each joint, to first order
    low: np.ndarray = field(repr=False)  # (n,) exact minimum of the output over all positions of the pins, or nan
    high: np.ndarray = field(repr=False)  # (n,) exact maximum, or nan
    loaded: np.ndarray = field(repr=False)  # (n,) deviation in equilibrium under the loads, or nan
    pressed: np.ndarray = field(repr=False)  # (n,) the same to first order: all pins displaced along their reactions
    rule: np.ndarray = field(repr=False)  # (n,) sum r_i |R_i| / |load| if one load is conjugate to the output, or nan
    clearances: dict[str, float]  # [m]
    stats: dict[str, Any] = field(repr=False, default_factory=dict)
    notes: tuple[str, ...] = ()  # what the numbers do not cover

    @property
    def worst(self) -> np.ndarray:
        """(n,) half width of the band in the worst case, to first order, in the output's SI unit."""
        return np.asarray(self.contributions.sum(axis=1))

    @property
    def rss(self) -> np.ndarray:
        """(n,) root sum square of the contributions in the SI unit: likely if many joints vary independently."""
        return np.asarray(np.sqrt((self.contributions**2).sum(axis=1)))

    @property
    def largest(self) -> float:
        """Largest deviation to either side [SI]: of the exact extremes, to first order where there are none."""
        exact = np.fmax(np.abs(self.low - self.nominal), np.abs(self.high - self.nominal))
        return float(np.max(np.where(np.isnan(exact), self.worst, exact)))

    @property
    def share(self) -> dict[str, float]:
        """Share [-] of each joint in the worst case, at the instant where the band is widest."""
        k = int(np.argmax(self.worst))
        total = float(self.worst[k]) or 1.0
        return {name: float(self.contributions[k, n]) / total for n, name in enumerate(self.joints)}

    @property
    def tighten(self) -> str:
        """The joint to tighten first: the one with the largest share where the band is widest."""
        return max(self.share, key=lambda name: self.share[name])

    def __str__(self) -> str:
        k = int(np.argmax(self.worst))
        usual = shown_in("mm") if self.unit == "m" else scale(self.unit, 0.0)
        factor, unit = chosen(self.unit) or usual

        def shown(value: float) -> str:
            return f"+-{factor * value:.4g} {unit}".rstrip()

        end, when = quantity(self.t[-1], "s"), quantity(self.t[k], "s")
        lines = [
            f"{self.of} with every pin anywhere in its clearance, {len(self.t)} positions to t = {end}:",
            f"worst case      {shown(self.worst[k])} at t = {when}, {shown(self.worst.mean())} on average",
            f"root sum square {shown(self.rss[k])} there",
        ]
        if not np.isnan(self.low).all():
            down, up = np.nanmin(self.low - self.nominal), np.nanmax(self.high - self.nominal)
            lines.append(f"exact extremes  {factor * down:+.4g} and {factor * up:+.4g} {unit}")
        if not np.isnan(self.loaded).all():
            n = int(np.nanargmax(np.abs(self.loaded)))
            rule = "" if math.isnan(self.rule[n]) else f" (rule sum r|R|/|load|: {factor * self.rule[n]:.4g} {unit})"
            at = f"in equilibrium at t = {quantity(self.t[n], 's')}"
            lines.append(f"under the loads {factor * self.loaded[n]:+.4g} {unit} at most, {at}{rule}")
        wide = max(len(name) for name in self.joints)
        for name, share in sorted(self.share.items(), key=lambda item: -item[1]):
            mine = shown(self.contributions[k, self.joints.index(name)])
            play = quantity(self.clearances[name], "m", usual="mm")
            lines.append(f"  {name:{wide}s}  {play:>11s}  {mine}  {100 * share:3.0f} %")
        first = self.tighten
        equal = [name for name in self.joints if self.share[name] > 0.99 * self.share[first] and name != first]
        also = f" (or {' or '.join(equal)}: equal share)" if equal else ""
        half = self.worst[k] - 0.5 * self.contributions[k, self.joints.index(first)]
        lines.append(f"tighten {first} first{also}: half its clearance makes the worst case {shown(half)}")
        return "\n".join([*lines, *self.notes])

    def __repr__(self) -> str:
        half = quantity(float(self.worst.max()), self.unit)
        return f"<rattle.Accuracy: {self.of} +-{half} at worst, tighten {self.tighten} first>"

    def _repr_html_(self) -> str:
        k = int(np.argmax(self.worst))
        rows = [
            (
                name,
                quantity(self.clearances[name], "m", usual="mm"),
                f"+-{quantity(self.contributions[k, self.joints.index(name)], self.unit)}",
                f"{100 * share:.0f} %",
            )
            for name, share in sorted(self.share.items(), key=lambda item: -item[1])
        ]
        report = str(self).splitlines()
        facts = [line for line in report[1:] if not line.startswith("  ")]
        return table(("joint", "clearance", "contribution", "share"), rows, report[0], facts, hint="a.plot()")

    def plot(self) -> Figure:
        """Output with its band, and a bar of contributions; see `rattle.questions.accuracy.pictures.plot_accuracy`."""
        from rattle.questions.accuracy.pictures import plot_accuracy

        return plot_accuracy(self)


def accuracy(
    system: System, of: str, t_eval: float | Sequence[float] | np.ndarray, *, extremes: bool, loaded: bool
) -> Accuracy:
    """Band of an output at the times t_eval [s]; see `Mechanism.accuracy`."""
    began = time.perf_counter()
    times = instants(t_eval)
    require_no_states(system.model, "accuracy")
    functions.start()
    ideal = ideal_system(system.model)
    joints = _with_play(system)
    start = assemble(ideal)
    require_driven(ideal, start, "accuracy")
    shown = Displaced(ideal, start, joints, of)
    lead = begin(ideal, start)
    n, k = len(times), len(joints)
    nominal = np.full(n, math.nan)
    part, low, high = np.full((n, k), math.nan), np.full(n, math.nan), np.full(n, math.nan)
    nodes = []
    none = np.zeros((k, 2))
    slopes = np.zeros((n, k, 2))
    for i, t in enumerate(times):
        if not len(lead.go(np.array([t]), False)):
            raise InputError(f"accuracy: {why_stuck(lead)}")
        node = _node(lead)
        nodes.append(node)
        nominal[i] = shown.value(t, node, none)
        slopes[i] = shown.gradient(t, node, none)
        part[i] = [free.first_order(y)[0] for free, y in zip(shown.free, slopes[i], strict=True)]
        if extremes:
            low[i], high[i] = (extreme(shown, t, node, sign, slopes[i]) for sign in (-1.0, 1.0))
    nothing = np.full(n, math.nan)
    at_rest = _loaded(system, ideal, shown, times, nodes, slopes) if loaded else [nothing] * 3
    record = Accuracy(
        of=of, unit=shown.unit, t=times, nominal=nominal, joints=tuple(joint.name for joint in joints),
        contributions=part, low=low, high=high, loaded=at_rest[0], pressed=at_rest[1], rule=at_rest[2],
        clearances={joint.name: joint.clearance for joint in joints}, stats={"wall_time": time.perf_counter() - began},
        notes=(
            *(_unbounded(joint, free) for joint, free in zip(joints, shown.free, strict=True) if free.unbounded),
            *out_of_place(ideal, times, np.array([node[swept.Q] for node in nodes]).reshape(n, -1, 3)),
        ),
    )  # fmt: skip
    return record


def _with_play(system: System) -> list[Joint]:
    """The joints that can deviate.  Raises ModelError if there are none."""
    joints = [joint for joint in system.model.joints.values() if joint.clearance > 0.0 and joint.contact is not None]
    if not joints:
        words = 'no joint has a clearance, so nothing can deviate; give one, such as clearance = "0.1 mm"'
        raise ModelError([Problem(("joints",), words)])
    return joints


def _unbounded(joint: Joint, free: Any) -> str:
    """Note on a joint whose displacements are not bounded."""
    return (
        f"the {joint.play.borne} of '{joint.name}' {free.unbounded}, so there are no exact"
        " extremes, and the first-order numbers hold for small rotations only"
    )


def _node(lead: Sweep) -> np.ndarray:
    """A copy of position, rates and accelerations that the leading sweep has just written, as a node."""
    node = np.zeros_like(lead.node)
    node[: swept.Q_NEW] = lead.node[swept.Q_NEW : swept.Q_OLD]
    return node


def _loaded(
    system: System,
    ideal: System,
    shown: Displaced,
    times: np.ndarray,
    nodes: list[np.ndarray],
    slopes: np.ndarray,
) -> list[np.ndarray]:
    """Deviation in equilibrium, the same to first order, and the virtual-work rule; each (n,), nan if not known."""

    n = len(times)
    curves = [np.full(n, math.nan) for _ in range(3)]
    model = system.model
    rigid = rigid_model(without_guide_play(system))
    pins = [joint for joint in shown.joints if joint.leaf.massless]
    if rigid is None or not (model.loads or model.falls) or shown.output.rpartition(".")[2] in RATES:
        return curves
    problem, hard = StaticProblem(ideal, times[0]), StaticProblem(rigid, times[0])
    conjugate = _conjugate(shown)
    for i, t in enumerate(times):
        problem.at(t)
        ideal_rest = problem.finish(nodes[i][swept.Q].copy(), 0)
        size, e = _pressed(ideal_rest, pins)
        if e is None:
            continue
        curves[1][i] = sum(
            _in_frame(shown, nodes[i], pin, e[pin.name]) @ slopes[i][shown.joints.index(pin)] for pin in pins
        )
        hard.at(t)
        curves[0][i] = _moved(hard, opened(problem, nodes[i][swept.Q], e), shown.output, ideal_rest)
        if conjugate:
            load = abs(_moment(problem, conjugate))
            curves[2][i] = sum(pin.clearance * size[pin.name] for pin in pins) / load if load > 0 else math.nan
    return curves


def _pressed(at_rest: Equilibrium, pins: Sequence[Joint]) -> tuple[dict[str, float], dict[str, np.ndarray] | None]:
    """Reactions of the pins [N] and their displacements e (2,) [m] by name; None: one without load may be anywhere."""
    force = {pin.name: np.array([at_rest[f"{pin.name}.fx"], at_rest[f"{pin.name}.fy"]]) for pin in pins}
    size = {name: float(np.hypot(*f)) for name, f in force.items()}
    if min(size.values()) <= UNLOADED * max([*size.values(), LEAST_FORCE]):
        return size, None
    return size, {pin.name: -pin.clearance / size[pin.name] * force[pin.name] for pin in pins}


def _moved(hard: StaticProblem, start: np.ndarray, output: str, ideal_rest: Equilibrium) -> float:
    """How far an output moves [SI] from rest without play to the rest that is near the start; nan if there is none."""
    solution = hard.find(start)
    at_rest = hard.finish(*solution) if solution is not None else None
    if at_rest is None or output not in at_rest.names or not at_rest.admissible:
        return math.nan
    return float(at_rest[output] - ideal_rest[output])


def _in_frame(shown: Displaced, node: np.ndarray, joint: Joint, e: np.ndarray) -> np.ndarray:
    """The components of a vector e (2,) in the frame of the joint's A, from those in the ground frame."""
    if joint.a.body == "ground":
        return e
    angle = node[swept.Q, 3 * shown.system.bodies.index(joint.a.body) + 2]
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * e[0] + s * e[1], -s * e[0] + c * e[1]])


def _conjugate(shown: Displaced) -> str:
    """The only load, if its virtual work is load times change of the output; "" otherwise."""
    model = shown.system.model
    if model.falls or len(model.loads) != 1:
        return ""
    ((name, load),) = model.loads.items()
    return name if load.kind == "torque" and shown.output == f"{load.b.body}.angle" else ""


def _moment(problem: StaticProblem, name: str) -> float:
    at = int(problem.system.arrays["load"][list(problem.system.model.loads).index(name), 3])
    return float(problem.workspace.values[at])
