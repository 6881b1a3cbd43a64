"""What the play of the joints does to the accuracy of an output.

Every pin with clearance may sit anywhere in its circle |e_i| <= r_i, every guide anywhere between its walls.
With all other joints closed the output o is a function of these displacements:

    Phi_i(q) = e_i,   o(q):     do/de = y,   Phi_q^T y = do/dq     (one linear solve per output)
    |o - o_ideal| <= sum_i r_i |y_i|  to first order: the worst case;  sqrt(sum_i (r_i |y_i|)^2): root sum square

The exact extremes lie on the circles; e_i = +- r_i y_i / |y_i| is repeated with y at the displaced position.
Loads press the pins to one side: e_i = r_i n_i; with one load conjugate to the output this is sum r_i |R_i| / |load|.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from rattle import catalog
from rattle.assembly import Assembled, assemble, dense_rows, ideal_model
from rattle.closing import open_by
from rattle.equations import loads
from rattle.errors import ModelError, Problem
from rattle.kinematics import Sweep, begin, instants, require_driven, why_stuck
from rattle.model import Joint
from rattle.recording import columns, width
from rattle.result import Result, UnknownName
from rattle.steppers import sweep as swept
from rattle.system import Compiled, compile_system

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SMALL = 1e-4  # of a clearance: displacement for differences
ROUNDS = 12
PLAIN = 4000  # positions times unknowns below which machine code is not worth its start


@dataclass(frozen=True)
class Play:
    """How far an output may stray, at n instants; SI units."""

    output: str
    unit: str
    t: np.ndarray  # (n,) [s]
    nominal: np.ndarray  # (n,) the output without play
    joints: tuple[str, ...]
    contributions: np.ndarray  # (n, k) first-order worst deviation by each joint
    low: np.ndarray = field(repr=False)  # (n,) exact least value of the output over all positions of the pins, or nan
    high: np.ndarray = field(repr=False)  # (n,) exact greatest value, or nan
    loaded: np.ndarray = field(repr=False)  # (n,) deviation in equilibrium under the loads, or nan
    pressed: np.ndarray = field(repr=False)  # (n,) the same to first order: all pins displaced along their reactions
    rule: np.ndarray = field(repr=False)  # (n,) sum r_i |R_i| / |load| where one load is conjugate to the output, or nan
    clearances: dict[str, float]  # [m]
    stats: dict[str, Any] = field(repr=False, default_factory=dict)

    @property
    def worst(self) -> np.ndarray:
        """(n,) first-order worst-case half width of the band: all joints at their worst together."""
        return np.asarray(self.contributions.sum(axis=1))

    @property
    def rss(self) -> np.ndarray:
        """(n,) root sum square of the contributions: what is likely when many joints vary independently."""
        return np.asarray(np.sqrt((self.contributions**2).sum(axis=1)))

    @property
    def share(self) -> dict[str, float]:
        """Share of each joint in the worst-case band, where that is widest."""
        k = int(np.argmax(self.worst))
        total = float(self.worst[k]) or 1.0
        return {name: float(self.contributions[k, n]) / total for n, name in enumerate(self.joints)}

    @property
    def tighten(self) -> str:
        """The joint to tighten first: the one with the largest share where the band is widest."""
        return max(self.share, key=lambda name: self.share[name])

    def __str__(self) -> str:
        k = int(np.argmax(self.worst))
        factor, unit = (180 / math.pi, "deg") if self.unit == "rad" else (1e3, "mm") if self.unit == "m" else (1.0, self.unit)
        lines = [
            f"{self.output} over t = {self.t[0]:.4g} to {self.t[-1]:.4g} s ({len(self.t)} positions), every pin anywhere in its play:",
            f"worst case      +-{factor * self.worst[k]:.4g} {unit} at t = {self.t[k]:.4g} s (first order)",
            f"root sum square +-{factor * self.rss[k]:.4g} {unit} there; mean of the worst case over all positions +-{factor * self.worst.mean():.4g} {unit}",
        ]
        if not np.isnan(self.low).all():
            down, up = np.nanmin(self.low - self.nominal), np.nanmax(self.high - self.nominal)
            lines.append(f"exact extremes  {factor * down:+.4g} {unit} and {factor * up:+.4g} {unit} over all positions")
        if not np.isnan(self.loaded).all():
            n = int(np.nanargmax(np.abs(self.loaded)))
            lines.append(
                f"under the loads {factor * self.loaded[n]:+.4g} {unit} at most, at t = {self.t[n]:.4g} s (at rest there)"
                + (f"; rule sum r|R|/|load|: {factor * self.rule[n]:.4g} {unit}" if not math.isnan(self.rule[n]) else "")
            )
        wide = max(len(name) for name in self.joints)
        for name, share in sorted(self.share.items(), key=lambda item: -item[1]):
            mine = factor * self.contributions[k, self.joints.index(name)]
            lines.append(f"  {name:{wide}s}  {self.clearances[name] * 1e3:8.4g} mm  +-{mine:.4g} {unit}  {100 * share:3.0f} %")
        first = self.tighten
        half = self.worst[k] - 0.5 * self.contributions[k, self.joints.index(first)]
        lines.append(f"tighten {first} first: half its clearance makes the worst case +-{factor * half:.4g} {unit}")
        return "\n".join(lines)

    def plot(self) -> Figure:
        """Output with its band, and a bar of contributions; see `rattle.plot_statics.plot_play`."""
        from rattle.plot_statics import plot_play

        return plot_play(self)


class Displaced:
    """The mechanism without play, with its pins displaced in their bushes by given amounts."""

    def __init__(self, ready: Compiled, start: Assembled, joints: Sequence[Joint], output: str) -> None:
        self.ready, self.start, self.joints, self.output = ready, start, joints, output
        self.sweep = begin(ready, start)
        self.place = [int(ready.arrays["joint"][ready.joints.index(one.name), 3]) for one in joints]
        self.values = self.sweep.memory["values"]
        self.base = self.values.copy()
        self.names: list[str] = []

    def shift(self, e: np.ndarray) -> None:
        """Displace joint i by e[i] (in the frame of its A; guides: across [m] and turn [rad])."""
        for k, (joint, p) in enumerate(zip(self.joints, self.place, strict=True)):
            if joint.kind == "prismatic":
                axis = joint.fields["axis"]
                self.values[p] = self.base[p] - math.sin(axis) * e[k, 0]
                self.values[p + 1] = self.base[p + 1] + math.cos(axis) * e[k, 0]
                self.values[p + 5] = self.base[p + 5] + e[k, 1]
            else:
                self.values[p : p + 2] = self.base[p : p + 2] + e[k]

    def row(self, t: float, node: np.ndarray, e: np.ndarray) -> np.ndarray:
        """Everything at t with the pins displaced by e, from a node nearby (nan where it cannot be closed)."""
        self.shift(e)
        sweep = self.sweep
        sweep.node[:] = node
        sweep.node[swept.Q_NEW : swept.Q_OLD] = node[: swept.Q_NEW]
        moved, root, _, _ = swept.closed_at(sweep.memory.handle, t, sweep.node, self.ready.size)
        raw = np.full(width(self.ready), math.nan)
        if moved < math.inf:
            sweep.node[: swept.Q_NEW] = sweep.node[swept.Q_NEW : swept.Q_OLD]
            sweep.clock[:] = t, math.inf, 0.0, root, root, t
            got = sweep.go(np.array([t]), True)
            if len(got):
                raw = got[0]
        self.shift(np.zeros_like(e))
        return raw

    def value(self, t: float, node: np.ndarray, e: np.ndarray) -> float:
        """The output with the pins displaced by e."""
        return float(self.read(self.row(t, node, e)[None])[0])

    def read(self, raw: np.ndarray) -> np.ndarray:
        """The output of raw rows. Raises UnknownName."""
        data, names, units = columns(self.ready, raw)
        from rattle.recording import geometry
        from rattle.result import Trust

        result = Result(
            t=np.arange(len(raw)), data=data, names=names, units=units, geometry=geometry(self.ready.model),
            trust=Trust(drift=0.0), stats={}, provenance={},
        )  # fmt: skip
        self.names, self.unit = list(result.names), result.unit(self.output)
        return np.asarray(result[self.output])

    def gradient(self, t: float, node: np.ndarray, e: np.ndarray) -> np.ndarray:
        """(k, 2) d output / d e at displacement e: one solve for positions, differences for everything else."""
        q_slope = self._slope(t, node, e)
        if q_slope is None:
            return self._differences(t, node, e)
        memory = self.sweep.memory
        rows = dense_rows(self.ready, memory)
        y = np.linalg.lstsq(rows.T, q_slope, rcond=1e-12)[0]
        found = np.zeros((len(self.joints), 2))
        for k, joint in enumerate(self.joints):
            first = int(self.ready.arrays["joint"][self.ready.joints.index(joint.name), 4])
            found[k] = y[first : first + 2]
            if joint.kind != "prismatic":  # rows are in the ground frame, e in that of A
                angle = 0.0 if joint.a.body == "ground" else memory["body"][1 + self.ready.bodies.index(joint.a.body), 2]
                c, s = math.cos(angle), math.sin(angle)
                found[k] = c * found[k, 0] + s * found[k, 1], -s * found[k, 0] + c * found[k, 1]
        return found

    def _slope(self, t: float, node: np.ndarray, e: np.ndarray) -> np.ndarray | None:
        """(3 nb,) d output / dq for outputs that depend on positions alone, with the rows of this place in the memory."""
        owner, _, last = self.output.rpartition(".")
        body, _, point = owner.partition(".")
        bodies = self.ready.model.bodies
        signal = self.output in self.ready.model.signals
        if not signal and (body not in bodies or last not in ("x", "y", "angle") or (point and point not in bodies[body].points)):
            return None
        self.row(t, node, e)
        memory = self.sweep.memory
        q = self.sweep.node[swept.Q].copy()
        v = self.sweep.node[swept.V].copy()
        self.shift(e)
        open_by(memory.handle, t, q, v)
        slope = np.zeros(len(q))
        if not signal:
            k = 3 * self.ready.bodies.index(body)
            c, s = math.cos(q[k + 2]), math.sin(q[k + 2])
            x, y = bodies[body].points[point] if point else (0.0, 0.0)
            slope[k + ("x", "y", "angle").index(last)] = 1.0
            if point:
                slope[k + 2] = -(s * x + c * y) if last == "x" else c * x - s * y
        else:
            slope_v = self._signal_slopes(t, q, v, slope)
            if slope_v:
                self.shift(np.zeros_like(e))
                return None
        open_by(memory.handle, t, q, v)
        self.shift(np.zeros_like(e))
        return slope

    def _signal_slopes(self, t: float, q: np.ndarray, v: np.ndarray, slope: np.ndarray) -> bool:
        """Fill in d signal / dq by differences; True when the signal depends on rates as well."""
        memory, k = self.sweep.memory, list(self.ready.model.signals).index(self.output)

        def at(q: np.ndarray, v: np.ndarray) -> float:
            open_by(memory.handle, t, q, v)
            loads(memory.handle, t)
            return float(memory["signals"][k])

        base = at(q, v)
        for n in range(len(q)):
            step = 1e-5 * (self.ready.size if n % 3 < 2 else 1.0)
            up, down = q.copy(), q.copy()
            up[n] += step
            down[n] -= step
            slope[n] = (at(up, v) - at(down, v)) / (2 * step)
        return any(at(q, v + np.eye(len(v))[n]) != base for n in range(len(v)))

    def _differences(self, t: float, node: np.ndarray, e: np.ndarray) -> np.ndarray:
        found = np.zeros_like(e)
        for k, joint in enumerate(self.joints):
            for n in range(2):
                step = SMALL * joint.clearance / (half_length(joint) if n and joint.kind == "prismatic" else 1.0)
                change = np.zeros_like(e)
                change[k, n] = step
                found[k, n] = (self.value(t, node, e + change) - self.value(t, node, e - change)) / (2 * step)
        return found


def half_length(joint: Joint) -> float:
    """Half the length of a guide's block [m]: how far its corners are from its point."""
    return 0.5 * joint.block[0] if joint.block else math.inf


def widest(joint: Joint, y: np.ndarray) -> tuple[float, np.ndarray]:
    """Largest of y . e over what the play of one joint allows, and the e where it is reached."""
    if joint.kind != "prismatic":
        size = float(np.hypot(*y))
        return joint.clearance * size, (joint.clearance / size * y if size > 0.0 else np.zeros(2))
    turn = joint.clearance / half_length(joint)  # corners |e_0 +- a e_1| <= c: a rhombus, its tips are the extremes
    ends = (joint.clearance * abs(float(y[0])), turn * abs(float(y[1])))
    if ends[0] >= ends[1]:
        return ends[0], np.array([math.copysign(joint.clearance, y[0]), 0.0])
    return ends[1], np.array([0.0, math.copysign(turn, y[1])])


def play(ready: Compiled, output: str, t_eval: float | Sequence[float] | np.ndarray, *, extremes: bool, loaded: bool) -> Play:
    """Band of an output; see `Mechanism.play`."""
    began = time.perf_counter()
    times = instants(t_eval)
    ideal = compile_system(ideal_model(ready.model))
    joints = [one for one in ready.model.joints.values() if one.clearance > 0.0 and one.contact is not None]
    if not joints:
        raise ModelError([Problem(("joints",), "no joint has a clearance, so nothing can stray; give one, such as clearance = \"0.1 mm\"")])
    start = assemble(ideal)
    require_driven(ideal, start, "play")
    if len(times) * len(joints) * (3 if extremes else 1) * ideal.row_count > PLAIN:
        catalog.start()
    shown = Displaced(ideal, start, joints, output)
    lead = begin(ideal, start)
    n, k = len(times), len(joints)
    nominal = np.full(n, math.nan)
    part, low, high = np.full((n, k), math.nan), np.full(n, math.nan), np.full(n, math.nan)
    nodes = []
    none = np.zeros((k, 2))
    slopes = np.zeros((n, k, 2))
    for i, t in enumerate(times):
        if not len(lead.go(np.array([t]), False)):
            raise ValueError(f"play: {why_stuck(lead)}")
        node = _node(lead)
        nodes.append(node)
        nominal[i] = shown.value(t, node, none)
        slopes[i] = shown.gradient(t, node, none)
        part[i] = [widest(one, y)[0] for one, y in zip(joints, slopes[i], strict=True)]
        if extremes:
            low[i], high[i] = (_extreme(shown, t, node, sign, slopes[i]) for sign in (-1.0, 1.0))
    record = Play(
        output, shown.unit, times, nominal, tuple(one.name for one in joints), part, low, high,
        *(_loaded(ready, ideal, shown, times, nodes, nominal, slopes) if loaded else [np.full(n, math.nan)] * 3),
        {one.name: one.clearance for one in joints}, {"wall_time": time.perf_counter() - began},
    )  # fmt: skip
    catalog.mark_compiled()
    return record


def _node(lead: Sweep) -> np.ndarray:
    """Position, rates and accelerations the leading sweep has just written, as a node of their own."""
    node = np.zeros_like(lead.node)
    node[: swept.Q_NEW] = lead.node[swept.Q_NEW : swept.Q_OLD]
    return node


def _extreme(shown: Displaced, t: float, node: np.ndarray, sign: float, slope: np.ndarray) -> float:
    """Least or greatest output over all displacements: each pin goes where the slope at the last place says."""
    best = math.nan
    for _ in range(ROUNDS):
        e = np.array([widest(one, sign * y)[1] for one, y in zip(shown.joints, slope, strict=True)])
        value = shown.value(t, node, e)
        if math.isnan(value):
            return best
        if not math.isnan(best) and sign * (value - best) <= 1e-12 * (abs(best) + 1e-12):
            return best if sign * best >= sign * value else value
        best = value
        slope = shown.gradient(t, node, e)
        if not np.isfinite(slope).all():
            return best
    return best


def _loaded(
    ready: Compiled, ideal: Compiled, shown: Displaced, times: np.ndarray, nodes: list[np.ndarray], nominal: np.ndarray, slopes: np.ndarray
) -> list[np.ndarray]:
    """Deviation in equilibrium, its first order, and the virtual-work rule, at every instant."""
    from rattle.statics import Rest, _rigid, opened

    n = len(times)
    found = [np.full(n, math.nan) for _ in range(3)]
    model = ready.model
    rigid = _rigid(ready)
    pins = [one for one in shown.joints if one.kind == "revolute"]
    if rigid is None or not (model.loads or any(model.gravity)):
        return found
    rest, hard = Rest(ideal, times[0]), Rest(rigid, times[0])
    conjugate = _conjugate(shown)
    for i, t in enumerate(times):
        rest.at(t)
        one = rest.finish(nodes[i][swept.Q].copy(), 0)
        force = {pin.name: np.array([one[f"{pin.name}.fx"], one[f"{pin.name}.fy"]]) for pin in pins}
        size = {name: float(np.hypot(*f)) for name, f in force.items()}
        if min(size.values()) <= 1e-9 * max([*size.values(), 1e-9]):
            continue  # a pin that nothing presses may be anywhere
        e = {pin.name: -pin.clearance / size[pin.name] * force[pin.name] for pin in pins}
        found[1][i] = sum(_in_frame(shown, nodes[i], pin, e[pin.name]) @ slopes[i][shown.joints.index(pin)] for pin in pins)
        hard.at(t)
        settled = hard.settle(opened(rest, nodes[i][swept.Q], e))
        at_rest = hard.finish(*settled) if settled is not None else None
        if at_rest is not None and shown.output in at_rest.names and at_rest.admissible:
            found[0][i] = at_rest[shown.output] - one[shown.output]
        if conjugate:
            load = abs(_moment(rest, conjugate))
            found[2][i] = sum(pin.clearance * size[pin.name] for pin in pins) / load if load > 0 else math.nan
    return found


def _in_frame(shown: Displaced, node: np.ndarray, joint: Joint, e: np.ndarray) -> np.ndarray:
    """A ground vector in the frame of the joint's A."""
    if joint.a.body == "ground":
        return e
    angle = node[swept.Q, 3 * shown.ready.bodies.index(joint.a.body) + 2]
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * e[0] + s * e[1], -s * e[0] + c * e[1]])


def _conjugate(shown: Displaced) -> str:
    """The load whose virtual work is load times the change of the output, if it is the only thing that acts."""
    model = shown.ready.model
    if any(model.gravity) or len(model.loads) != 1:
        return ""
    ((name, load),) = model.loads.items()
    return name if load.kind == "torque" and shown.output == f"{load.b.body}.angle" else ""


def _moment(rest: Any, name: str) -> float:
    at = int(rest.ready.arrays["load"][list(rest.ready.model.loads).index(name), 3])
    return float(rest.memory["values"][at])


__all__ = ["Play", "UnknownName", "play"]
