"""Equilibrium of a mechanism at rest: Q(q) - Phi_q^T lambda = 0, Phi(q, t) = 0.

Newton on the freedoms that the joints leave, with positions kept closed:

    Z = null space of Phi_q,   g = Z^T Q,   H = Z^T K Z,   K = -d(Q - Phi_q^T lambda)/dq,   q += Z H^-1 g

Coordinates are scaled (angles as arc lengths at the size of the mechanism), so that g is in N and H in N/m.
H > 0 is stability against small displacements (THEORY section 7).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from rattle.assembly import assemble, dense_rows, ideal_model
from rattle.closing import close_position, merit_at
from rattle.equations import drive
from rattle.errors import AssemblyError
from rattle.memory import Memory
from rattle.model import Contact
from rattle.plane import AUTO, CLOSED, SPEED
from rattle.recording import columns, geometry, width
from rattle.result import Result, Trust
from rattle.singular import RANK, nonunique_reactions, scaled_rows
from rattle.steppers.rest import force_at, stiffness
from rattle.steppers.writing import write
from rattle.system import Compiled, compile_system, has_contacts, is_link

MOST_PINS = 6  # up to so many clearance pins all combinations of sides are tried
ROUNDS = 60
RANDOM_STARTS = 24


@dataclass
class Equilibrium:
    """One position of rest. `E["coupler.angle"]` gives any result name [SI]."""

    t: float  # [s], of the drivers' functions
    q: np.ndarray = field(repr=False)  # (3 nb,)
    multiplier: np.ndarray = field(repr=False)  # (nr,)
    eigenvalue: float  # smallest of the reduced Hessian [N/m]; inf where no freedom is left
    residual: float  # largest force out of balance [N]
    gap: float  # largest constraint residual [m or rad]
    iterations: int
    nonunique: tuple[str, ...]  # joints whose reactions are not unique
    freedoms: int  # that the joints and drivers leave
    result: Result = field(repr=False)

    def __getitem__(self, name: str) -> float:
        """Any quantity by its result name, in SI units. Raises UnknownName."""
        return float(self.result[name][0])

    @property
    def names(self) -> tuple[str, ...]:
        """All names that `E[...]` answers to."""
        return self.result.names

    def unit(self, name: str) -> str:
        """SI unit of a quantity."""
        return self.result.unit(name)

    @cached_property
    def normals(self) -> dict[str, float]:
        """Normal force of every clearance pin [N], negative where the bush would have to pull."""
        found = {name: self[f"{name}.normal"] for name in self.result.geometry["joints"] if f"{name}.normal" in self.result}
        joints = self.result.geometry["joints"]
        return {name: value for name, value in found.items() if joints[name]["contact"] not in ("", "ideal")}

    @property
    def pulled(self) -> tuple[str, ...]:
        """Pins at which the bush would have to pull."""
        scale = max([abs(n) for n in self.normals.values()] + [1e-300])
        return tuple(name for name, n in self.normals.items() if n < -1e-9 * scale)

    @property
    def admissible(self) -> bool:
        """True when no bush would have to pull (all N >= 0)."""
        return not self.pulled

    @property
    def stable(self) -> bool:
        """True when every small displacement is driven back (all eigenvalues positive)."""
        return self.eigenvalue > 0.0

    @property
    def reactions_unique(self) -> bool:
        """False where constraints are redundant; `nonunique` names the joints."""
        return not self.nonunique

    def __str__(self) -> str:
        kind = "stable" if self.stable else "unstable"
        sides = f", {', '.join(self.pulled)} would have to pull" if self.pulled else ""
        pins = "".join(f", {name} presses with {n:.4g} N" for name, n in self.normals.items() if n >= 0)
        hold = f", stiffness {self.eigenvalue:.3g} N/m" if math.isfinite(self.eigenvalue) else ""
        return f"{kind}{hold}{sides}{pins}; balanced to {self.residual:.1g} N, closed to {self.gap:.1g} m"


class Rest:
    """One mechanism to be brought to rest at one position of its drivers."""

    def __init__(self, ready: Compiled, t: float) -> None:
        self.ready, self.memory = ready, ready.memory()
        if len(self.memory["grip"]):
            self.memory["grip"][:, CLOSED] = AUTO
            self.memory["grip"][:, SPEED] = 1.0
        self.scale = np.ones(3 * ready.body_count)
        self.scale[2::3] = 1.0 / ready.size
        joints = ready.model.joints.values()
        arms = [one.clearance for one in joints if is_link(one)] + [one.fields["length"] for one in joints if "length" in one.fields]
        length = min([1e-4 * ready.size] + [3e-3 * one for one in arms])
        if len(self.memory["grip"]):  # penetrations are small
            length = min([length] + [1e-5 * one.clearance for one in joints if has_contacts(one)])
        self.step = length * self.scale
        self.out = np.zeros(3 * ready.body_count)
        self.links = [name for name, one in ready.model.joints.items() if is_link(one)]
        self.at(t)

    def at(self, t: float) -> None:
        """Set the drivers to time t."""
        self.t = t
        drive(self.memory.handle, t)

    def close(self, q: np.ndarray) -> float:
        """Put the joints together in place; returns the largest residual."""
        gap, _ = close_position(self.memory.handle, self.t, q, np.empty_like(q), 1e-13 * self.ready.size, 60)
        return float(gap)

    def look(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Reduced force g [N] and the scaled null space Z at q; leaves the least-squares multipliers."""
        self.memory["multiplier"][:] = 0.0
        force_at(self.memory.handle, self.t, q, self.out)
        applied = self.out * self.scale
        if not self.ready.row_count:
            return applied, np.diag(self.scale)
        rows = dense_rows(self.ready, self.memory) * self.scale
        norm = np.linalg.norm(rows, axis=1)
        _, values, right = np.linalg.svd(rows / norm[:, None])
        count = int((values > RANK * values[0]).sum())
        self.memory["multiplier"][:] = np.linalg.lstsq((rows / norm[:, None]).T, applied, rcond=RANK)[0] / norm
        null = right[count:].T
        return null.T @ applied, self.scale[:, None] * null

    def hessian(self, q: np.ndarray, null: np.ndarray) -> np.ndarray:
        """Reduced Hessian H [N/m]; the multipliers of `look` are in the memory."""
        tangent = np.zeros((len(q), len(q)))
        stiffness(self.memory.handle, self.t, q, self.step, self.out, tangent)
        return np.asarray(null.T @ tangent @ null)

    def offsets(self, q: np.ndarray) -> np.ndarray:
        """(k, 2) pin centre minus bush centre of every link, at q."""
        found = []
        for name in self.links:
            joint = self.ready.model.joints[name]
            ends = []
            for point in (joint.a, joint.b):
                if point.body == "ground":
                    ends.append(np.array(point.at))
                    continue
                x, y, phi = q[3 * self.ready.bodies.index(point.body) :][:3]
                c, s = math.cos(phi), math.sin(phi)
                ends.append(np.array([x + c * point.at[0] - s * point.at[1], y + s * point.at[0] + c * point.at[1]]))
            found.append(ends[1] - ends[0])
        return np.array(found).reshape(-1, 2)

    def _too_far(self, before: np.ndarray, after: np.ndarray) -> bool:
        """A pin that turned by more than 0.8 rad may have changed sides."""
        if not len(before):
            return False
        cosine = (before * after).sum(axis=1) / (np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1) + 1e-300)
        return bool((cosine < 0.7).any())

    def settle(self, start: np.ndarray, downhill: bool = False) -> tuple[np.ndarray, int] | None:
        """A position of rest near a start, or None; downhill: a stable one."""
        q = start.copy()
        if not self.close(q) < 1e-9 * self.ready.size:
            return None
        g, null = self.look(q)
        size = self.force_scale()
        small = 0
        for iteration in range(ROUNDS):
            if not len(g) or not np.isfinite(g).all():
                return (q, iteration) if not len(g) else None
            h = self.hessian(q, null)
            if downhill:
                values, vectors = np.linalg.eigh(0.5 * (h + h.T))
                dz = vectors @ ((vectors.T @ g) / np.maximum(np.abs(values), 1e-9 * np.abs(values).max() + 1e-300))
            else:
                dz = np.linalg.lstsq(h, g, rcond=1e-13)[0]
            far = float(np.abs(null @ dz / self.scale).max())
            dz *= min(1.0, 0.3 * self.ready.size / max(far, 1e-300))
            if far < 1e-13 * self.ready.size or (np.abs(g).max() <= 1e-12 * size and far < 1e-10 * self.ready.size):
                return q, iteration
            taken = self._advance(q, g, null, dz, downhill)
            if taken is None:
                done = np.abs(g).max() <= 1e-8 * size
                return (q, iteration) if done else None
            before = float(np.abs(g).max())
            q, g, null = taken
            small = small + 1 if np.abs(g).max() <= 1e-11 * size and np.abs(g).max() > 0.1 * before else 0
            if small == 2:
                return q, iteration + 1
        return (q, ROUNDS) if np.abs(g).max() <= 1e-8 * size else None

    def force_scale(self) -> float:
        """A force typical of what acts [N]."""
        rows = np.abs(self.memory["rows"][:, 3:]).max(axis=1, initial=0.0)
        acting = np.abs(self.memory["multiplier"] * rows).max(initial=0.0)
        return float(max(acting, np.abs(self.memory["force"][:, :2]).max(), np.abs(self.memory["force"][:, 2]).max() / self.ready.size, 1e-12))

    def _advance(
        self, q: np.ndarray, g: np.ndarray, null: np.ndarray, dz: np.ndarray, downhill: bool
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """One step, halved until it is safe and helps."""
        offsets = self.offsets(q)
        share = 1.0
        for _ in range(30):
            trial = q + share * (null @ dz)
            if self.close(trial) < 1e-9 * self.ready.size and not self._too_far(offsets, self.offsets(trial)):
                g_new, null_new = self.look(trial)
                if len(g_new) == len(g) and np.isfinite(g_new).all():
                    if downhill:  # not beyond the point where the force along the way turns round
                        along = float(self.out_along(null @ dz))
                        better = along > -0.5 * float(g @ dz) or np.linalg.norm(g_new) < np.linalg.norm(g)
                    else:
                        better = float(np.linalg.norm(g_new)) < float(np.linalg.norm(g)) * (1 - 1e-4 * share)
                    if better:
                        return trial, g_new, null_new
            share *= 0.5
        return None

    def out_along(self, direction: np.ndarray) -> float:
        """Work of the applied forces per step in a direction, at the position looked at last."""
        return float(self.out @ direction) if not self.ready.row_count else float(self.memory["force"][1:].ravel() @ direction)

    def finish(self, q: np.ndarray, iterations: int) -> Equilibrium:
        """Everything about a position of rest."""
        from rattle import __version__

        memory, ready = self.memory, self.ready
        g, null = self.look(q)
        eigenvalue = math.inf
        if len(g):
            h = self.hessian(q, null)
            values = np.linalg.eigvals(h).real
            eigenvalue = float(values.min())
            if abs(eigenvalue) < 1e-8 * max(float(np.abs(values).max()), self.force_scale() / ready.size):
                eigenvalue = 0.0  # neutral
        force_at(memory.handle, self.t, q, self.out)
        gap = float(np.abs(memory["rows"][:, 0]).max(initial=0.0))
        residual = float(np.abs(self.out * self.scale).max(initial=0.0))
        memory["acceleration"][:] = 0.0
        memory["rows"][:, 1] = 0.0  # at rest
        raw = np.zeros((1, width(ready)))
        write(memory.handle, 0.0, 0.0, raw[0])
        data, names, units = columns(ready, raw)
        keep = [k for k, name in enumerate(names) if name not in ("energy.work", "energy.dissipated", "energy.balance")]
        names = [names[k] for k in keep]
        nonunique = nonunique_reactions(ready, memory)
        result = Result(
            t=[self.t], data=np.ascontiguousarray(data[:, keep]), names=names, units={name: units[name] for name in names},
            geometry=geometry(ready.model), stats={"iterations": iterations},
            trust=Trust(drift=gap, t_end=self.t, horizon=self.t, nonunique=nonunique),
            provenance={"model": ready.model.name, "program": f"rattle {__version__}", "analysis": "equilibrium"},
        )  # fmt: skip
        return Equilibrium(
            self.t, q.copy(), memory["multiplier"].copy(), eigenvalue, residual, gap, iterations, nonunique, len(g), result
        )


# ---------------------------------------------------------------- search
def equilibria(ready: Compiled, t: float = 0.0, branches: str = "near") -> list[Equilibrium]:
    """All positions of rest found; see `Mechanism.equilibrium`."""
    if branches not in ("near", "all"):
        raise ValueError(f"branches must be 'near' or 'all', got {branches!r}")
    rigid = _rigid(ready)
    ideal_ready = compile_system(ideal_model(ready.model)) if rigid is not None else ready
    start = position_at(ideal_ready, t)
    rest = Rest(ideal_ready, t)
    found = _settled(rest, _starts(rest, start, branches == "all"))
    if rigid is None:
        return _sorted(found, start)
    play = Rest(rigid, t)
    partners: list[Equilibrium] = []
    for one in found:
        partners += _settled(play, _sides(rest, play, one))
    if not partners:
        partners = _settled(play, _starts(play, position_at(rigid, t), True))
    reference = start + _first_offset(rest, rigid, start)
    if any(has_contacts(joint) and _compliant(joint.contact) for joint in ready.model.joints.values()):
        partners = _pressed(ready, t, play, partners)
    return _sorted(partners, reference)


def _compliant(contact: Contact | None) -> bool:
    return contact is not None and contact.normal is not None


def _rigid(ready: Compiled) -> Compiled | None:
    """The mechanism with every open pin held by a massless link; None when no joint has play."""
    joints = dict(ready.model.joints)
    for name, one in joints.items():
        if one.kind == "revolute" and (has_contacts(one) or is_link(one)):
            joints[name] = replace(one, contact=Contact("massless-link"))
        elif has_contacts(one):  # a guide: closed
            joints[name] = replace(one, contact=Contact("ideal"))
    model = replace(ready.model, joints=joints)
    return compile_system(model) if any(is_link(one) for one in joints.values()) else None


def position_at(ready: Compiled, t: float) -> np.ndarray:
    """The assembled position at time t; a driven mechanism is led there from t = 0 on its branch."""
    from rattle import kinematics
    from rattle.steppers import sweep

    try:
        start = assemble(ready)
    except AssemblyError:
        if t == 0.0:
            raise
        return assemble(ready, t).q
    if t == 0.0:
        return start.q
    memory = ready.memory()
    drive(memory.handle, 0.0)
    merit_at(memory.handle, start.q)
    driven = ready.row_count and np.linalg.matrix_rank(scaled_rows(ready, memory), tol=1e-9) == 3 * ready.body_count
    if not driven:
        return assemble(ready, t).q
    led = kinematics.begin(ready, start)
    if not len(led.go(np.array([t]), False)):
        raise AssemblyError(f"the position at t = {t:g} s cannot be reached: {kinematics.why_stuck(led)}")
    return led.node[sweep.Q_NEW].copy()


def _starts(rest: Rest, start: np.ndarray, everywhere: bool) -> Iterator[np.ndarray]:
    """The assembled position, others along its freedoms, and with `everywhere` other ways to put it together."""
    yield start
    _, null = rest.look(start)
    count = null.shape[1]
    directions = [sign * null[:, k] for k in range(min(count, 4)) for sign in (1.0, -1.0)]
    for direction in directions:
        q = start.copy()
        for _ in range(12):  # along one freedom, in steps of a quarter of the size
            _, now = rest.look(q)
            q = q + now @ (now.T @ (direction / rest.scale**2)) * 0.25 * rest.ready.size
            if not rest.close(q) < 1e-9 * rest.ready.size:
                break
            yield q.copy()
    random = np.random.default_rng(0)
    if everywhere or count > 4:
        model = rest.ready.model
        held = {driver.point.body if driver.point else model.joints[driver.joint].b.body for driver in model.drivers.values()}
        free = [k for k, name in enumerate(rest.ready.bodies) if name not in held]
        for _ in range(RANDOM_STARTS * (2 if everywhere else 1)):
            q = start.copy()
            q[[3 * k + 2 for k in free]] = random.uniform(-math.pi, math.pi, len(free))
            q[0::3] += random.normal(size=len(q) // 3) * 0.3 * rest.ready.size
            q[1::3] += random.normal(size=len(q) // 3) * 0.3 * rest.ready.size
            yield q


def _settled(rest: Rest, starts: Iterator[np.ndarray] | Sequence[np.ndarray]) -> list[Equilibrium]:
    """Distinct positions of rest, by plain Newton and downhill from every start."""
    found: list[Equilibrium] = []
    for start in starts:
        for downhill in (False, True):
            settled = rest.settle(start, downhill)
            if settled is None or any(_same(rest.ready, settled[0], other.q) for other in found):
                continue
            found.append(rest.finish(*settled))
            if not found[-1].freedoms:
                break
    return found


def _same(ready: Compiled, one: np.ndarray, other: np.ndarray) -> bool:
    tiny = min([ready.size] + [joint.clearance for joint in ready.model.joints.values() if joint.clearance > 0])
    apart = one - other
    apart[2::3] = (apart[2::3] + math.pi) % (2 * math.pi) - math.pi
    apart[2::3] *= ready.size
    return bool(np.abs(apart).max() < 1e-5 * tiny + 1e-10 * ready.size)


def _sides(ideal: Rest, play: Rest, one: Equilibrium) -> list[np.ndarray]:
    """Starts with every pin on either side of its bush along the ideal reaction."""
    directions = []
    for name in play.links:
        force = np.array([one[f"{name}.fx"], one[f"{name}.fy"]])
        size = float(np.hypot(*force))
        tiny = 1e-12 * max(1.0, np.abs(one.multiplier).max(initial=0.0))
        directions.append(-force / size if size > tiny else np.array([1.0, 0.0]))
    count = len(directions)
    signs: list[tuple[int, ...]] = list(itertools.product((1, -1), repeat=min(count, MOST_PINS)))
    if count > MOST_PINS:
        signs = [tuple(s) for s in np.vstack([np.ones(count), -np.ones(count), 1 - 2 * np.eye(count)]).astype(int)]
    clearances = [play.ready.model.joints[name].clearance for name in play.links]
    starts = []
    for sign in signs:
        wanted = {
            name: s * c * n for name, s, c, n in zip(play.links, sign, clearances, directions, strict=True)
        }
        starts.append(opened(ideal, one.q, wanted))
    return starts


def opened(ideal: Rest, q: np.ndarray, wanted: Mapping[str, np.ndarray]) -> np.ndarray:
    """The ideal mechanism's position with its pins displaced in their bushes, by least change."""
    ready, memory = ideal.ready, ideal.memory
    target = np.zeros(ready.row_count)
    for name, offset in wanted.items():
        first = int(ready.arrays["joint"][ready.joints.index(name), 4])
        target[first : first + 2] = offset
    q = q.copy()
    for _ in range(6):
        merit_at(memory.handle, q)
        rows = dense_rows(ready, memory) * ideal.scale
        change = np.linalg.lstsq(rows, target - memory["rows"][:, 0], rcond=1e-9)[0] * ideal.scale
        q += change
        if np.abs(change).max() < 1e-13:
            break
    return q


def _first_offset(ideal: Rest, rigid: Compiled, start: np.ndarray) -> np.ndarray:
    """What the pins' offsets at the start, as far as given, change in the ideal position."""
    given = rigid.model.initial.offsets
    wanted = {name: np.array(at) for name, at in given.items() if name in rigid.model.joints and is_link(rigid.model.joints[name])}
    return opened(ideal, start, wanted) - start if wanted else np.zeros_like(start)


def _pressed(ready: Compiled, t: float, play: Rest, rigid: list[Equilibrium]) -> list[Equilibrium]:
    """Compliant pins: from the rigid positions that press everywhere, let every pin sink in."""
    rest = Rest(ready, t)
    ideal = Rest(compile_system(ideal_model(ready.model)), t)
    found: list[Equilibrium] = []
    for one in rigid:
        if not one.admissible:
            continue
        offsets = dict(zip(play.links, play.offsets(one.q), strict=True))
        for depth in (1e-4, 1e-3, 1e-2, 1e-5, 1e-1):  # of the clearance
            start = opened(ideal, one.q, {name: e * (1 + depth) for name, e in offsets.items()})
            settled = rest.settle(start)
            if settled is not None:
                if not any(_same(ready, settled[0], other.q) for other in found):
                    found.append(rest.finish(*settled))
                break
    return found


def _sorted(found: list[Equilibrium], start: np.ndarray) -> list[Equilibrium]:
    """Admissible and stable ones first, then by their distance from the initial guess."""

    def key(one: Equilibrium) -> tuple[bool, float]:
        apart = one.q - start
        apart[2::3] = (apart[2::3] + math.pi) % (2 * math.pi) - math.pi
        return not (one.admissible and one.stable), float(np.linalg.norm(apart))

    return sorted(found, key=key)


def rest_of(ready: Compiled, one: Equilibrium) -> Rest:
    """The mechanism as it stands in one of its positions of rest: with rigid or with compliant pins."""
    rigid = _rigid(ready)
    if rigid is not None and rigid.row_count == len(one.multiplier):
        return Rest(rigid, one.t)
    return Rest(ready, one.t)
