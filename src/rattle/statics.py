"""Search for the positions of rest of a mechanism: starts, partners of clearance pins, their order.

Every clearance pin is a massless link; each position of rest has partners with the pin on the other side of its bush
(n and -n).  They are started from the ideal mechanism's position of rest, pins displaced along its reactions.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from rattle import catalog
from rattle.assembly import assemble, ideal_model
from rattle.closing import merit_at
from rattle.equations import drive
from rattle.errors import AssemblyError
from rattle.model import Contact
from rattle.resting import Equilibria, Equilibrium, Rest
from rattle.singular import scaled_rows
from rattle.system import Compiled, compile_system, has_contacts, is_link

MOST_PINS = 6  # up to so many clearance pins all combinations of sides are tried
RANDOM_STARTS = 48
MANY = 12  # bodies from which on only the assembled position is a start
MOST_STRIDES = 160  # along a freedom that does not close
MOST_STARTS = 1000  # after which the search stops, and says so
FEW, FEW_BODIES = 3, 4  # freedoms and bodies up to which every start goes downhill too
MOST_TRIALS = 12_000  # positions looked at, of all starts together
TRIALS_EACH = 250  # and from one start: Newton that arrives does so in far fewer


def equilibria(ready: Compiled, t: float = 0.0, branches: str = "near") -> Equilibria:
    """All positions of rest found; see `Mechanism.equilibrium`."""
    if branches not in ("near", "all"):
        raise ValueError(f"branches must be 'near' or 'all', got {branches!r}")
    catalog.start()
    ready = without_guide_play(ready)
    rigid = rigid_model(ready)
    ideal_ready = compile_system(ideal_model(ready.model)) if rigid is not None else ready
    start = position_at(ideal_ready, t)
    rest, search = Rest(ideal_ready, t), Search()
    found = search.settled(rest, _starts(rest, start, branches == "all"))
    if rigid is None:
        return Equilibria(_sorted(found, start), search.starts, search.stopped)
    play = Rest(rigid, t)
    partners = search.settled(play, (start for one in found for start in _sides(rest, play, one)), True)
    if not partners:
        partners = search.settled(play, _starts(play, position_at(rigid, t), True))
    reference = start + _first_offset(rest, rigid, start)
    if any(has_contacts(joint) and _compliant(joint.contact) for joint in ready.model.joints.values()):
        partners = _pressed(ready, t, play, partners)
    return Equilibria(_sorted(partners, reference), search.starts, search.stopped)


def _compliant(contact: Contact | None) -> bool:
    return contact is not None and contact.normal is not None


def without_guide_play(ready: Compiled) -> Compiled:
    """The mechanism with every guide closed."""
    joints = dict(ready.model.joints)
    for name, one in joints.items():
        if one.kind != "revolute" and has_contacts(one):
            joints[name] = replace(one, contact=Contact("ideal"))
    changed = any(joints[name] is not one for name, one in ready.model.joints.items())
    return compile_system(replace(ready.model, joints=joints)) if changed else ready


def rigid_model(ready: Compiled) -> Compiled | None:
    """The mechanism with every open pin held by a massless link; None when no joint has play."""
    joints = dict(ready.model.joints)
    for name, one in joints.items():
        if one.kind == "revolute" and (has_contacts(one) or is_link(one)):
            joints[name] = replace(one, contact=Contact("massless-link"))
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
    return np.array(led.node[sweep.Q_NEW])


def _starts(rest: Rest, start: np.ndarray, everywhere: bool) -> Iterator[np.ndarray]:
    """The assembled position, others along its freedoms, and with `everywhere` other ways to put it together."""
    yield start
    if rest.ready.body_count > MANY:
        return
    _, null = rest.look(start)
    count = null.shape[1]
    if count == 1:
        yield from _around(rest, start, null[:, 0])
    else:
        for direction in [sign * null[:, k] for k in range(min(count, 4)) for sign in (1.0, -1.0)]:
            q = start.copy()
            for _ in range(12):
                if not rest.walk(q, direction, 0.25 * rest.ready.size)[0]:
                    break
                yield q.copy()
    random = np.random.default_rng(0)
    if everywhere or count:
        model = rest.ready.model
        held = {
            driver.point.body if driver.point else model.joints[driver.joint].b.body
            for driver in model.drivers.values()
        }
        free = [k for k, name in enumerate(rest.ready.bodies) if name not in held]
        for _ in range(RANDOM_STARTS if everywhere else RANDOM_STARTS // 4):
            q = start.copy()
            q[[3 * k + 2 for k in free]] = random.uniform(-math.pi, math.pi, len(free))
            q[0::3] += random.normal(size=len(q) // 3) * 0.3 * rest.ready.size
            q[1::3] += random.normal(size=len(q) // 3) * 0.3 * rest.ready.size
            yield q


def _around(rest: Rest, start: np.ndarray, direction: np.ndarray) -> Iterator[np.ndarray]:
    """One freedom: walk along it, all around where it closes; the places where the force along it changes its sign."""
    stride = rest.ready.size / 8
    path, force = [start], [float(rest.look(start)[0][0])]
    for sign in (1.0, -1.0):
        q, ahead, closed = start.copy(), sign * direction, False
        for n in range(MOST_STRIDES):
            went, along, _ = rest.walk(q, ahead, stride)
            if not went:
                break
            path.insert(len(path) if sign > 0 else 0, q.copy())
            force.insert(len(force) if sign > 0 else 0, sign * along)
            closed = n > 2 and _apart(rest.ready, q, start[None])[0] < stride
            if closed:
                break
        if closed:
            break
    nothing = 1e-9 * max(rest.force_scale(), max(map(abs, force)))
    size = [abs(one) if abs(one) > nothing else math.inf for one in force]  # where nothing acts it may be anywhere
    for k in range(1, len(path)):
        if size[k - 1] < math.inf and size[k] < math.inf and force[k - 1] * force[k] < 0.0:
            yield path[k - 1]
            yield path[k]
    for k in range(1, len(path) - 1):  # without a change of sign: two positions of rest may lie close together
        if size[k] < min(size[k - 1], size[k + 1]) and force[k - 1] * force[k + 1] > 0.0:
            yield path[k]


@dataclass
class Search:
    """How much has been tried; in each part of the search the starts and the positions looked at are limited."""

    starts: int = 0
    stopped: bool = False

    def settled(self, rest: Rest, starts: Iterable[np.ndarray], partners: bool = False) -> list[Equilibrium]:
        """Distinct positions of rest, by plain Newton and downhill, with many freedoms from every other start.

        partners: the starts are close to what is sought; downhill only where Newton fails.
        """
        found: list[Equilibrium] = []
        known = np.zeros((0, 3 * rest.ready.body_count))
        near = 1e-3 * _tiny(rest.ready)
        begun, before = self.starts, rest.trials
        many = 3 * rest.ready.body_count - rest.ready.row_count > FEW and rest.ready.body_count > FEW_BODIES
        for n, start in enumerate(starts):
            plain = False
            for downhill in (False, True):
                if downhill and (plain if partners else n % 2 and many):  # most ways downhill lead to a few places
                    continue
                if self.starts - begun >= MOST_STARTS or rest.trials - before >= MOST_TRIALS:
                    self.stopped = True
                    return found
                self.starts += 1
                settled = rest.settle(start, downhill, known, near, TRIALS_EACH)
                plain = plain or rest.arrived
                if settled is None or _same(rest.ready, settled[0], known):
                    continue
                known = np.vstack([known, settled[0]])
                one = rest.finish(*settled)
                if any(_one_family(rest, one, other) for other in found):
                    continue
                found.append(one)
                if not one.freedoms:
                    break
        return found


def _one_family(rest: Rest, one: Equilibrium, other: Equilibrium) -> bool:
    """True where a free motion leads from one position of rest to the other: it costs no energy."""
    if not one.neutral or (one.neutral, one.falling, one.pulled) != (other.neutral, other.falling, other.pulled):
        return False
    apart = abs(one["energy.potential"] - other["energy.potential"])
    return apart <= 1e-9 * rest.force_scale() * rest.ready.size


def _apart(ready: Compiled, one: np.ndarray, others: np.ndarray) -> np.ndarray:
    """(k,) largest distance [m] of a position from others (k, 3 nb), angles as on a circle of the mechanism's size."""
    apart = one - others
    apart[:, 2::3] = (apart[:, 2::3] + math.pi) % (2 * math.pi) - math.pi
    apart[:, 2::3] *= ready.size
    return np.asarray(np.abs(apart).max(axis=1))


def _tiny(ready: Compiled) -> float:
    """The smallest length that tells positions apart [m]."""
    return min([ready.size] + [joint.clearance for joint in ready.model.joints.values() if joint.clearance > 0])


def _same(ready: Compiled, one: np.ndarray, others: np.ndarray) -> bool:
    """True where a position is one of the others (k, 3 nb)."""
    if not len(others):
        return False
    return bool(_apart(ready, one, others).min() < 1e-5 * _tiny(ready) + 1e-10 * ready.size)


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
        wanted = {name: s * c * n for name, s, c, n in zip(play.links, sign, clearances, directions, strict=True)}
        starts.append(opened(ideal, one.q, wanted))
    return starts


def opened(ideal: Rest, q: np.ndarray, wanted: Mapping[str, np.ndarray]) -> np.ndarray:
    """The ideal mechanism's position with its pins displaced in their bushes, by least change."""
    ready = ideal.ready
    target = np.zeros(ready.row_count)
    for name, offset in wanted.items():
        first = int(ready.arrays["joint"][ready.joints.index(name), 4])
        target[first : first + 2] = offset
    q = q.copy()
    ideal.displace(q, target)
    return q


def _first_offset(ideal: Rest, rigid: Compiled, start: np.ndarray) -> np.ndarray:
    """What the pins' offsets at the start, as far as given, change in the ideal position."""
    given = rigid.model.initial.offsets
    wanted = {
        name: np.array(at)
        for name, at in given.items()
        if name in rigid.model.joints and is_link(rigid.model.joints[name])
    }
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
                if not found or not _same(ready, settled[0], np.array([other.q for other in found])):
                    found.append(rest.finish(*settled))
                break
    return found


def _sorted(found: list[Equilibrium], start: np.ndarray) -> list[Equilibrium]:
    """Admissible and stable ones first, then by their distance from the initial guess."""

    def key(one: Equilibrium) -> tuple[bool, bool, float]:
        apart = one.q - start
        apart[2::3] = (apart[2::3] + math.pi) % (2 * math.pi) - math.pi
        fine = one.admissible and not one.falling
        return not (fine and one.stable), not fine, float(np.linalg.norm(apart))

    return sorted(found, key=key)


def rest_of(ready: Compiled, one: Equilibrium) -> Rest:
    """The mechanism as it stands in one of its positions of rest: with rigid or with compliant pins."""
    ready = without_guide_play(ready)
    rigid = rigid_model(ready)
    if rigid is not None and rigid.row_count == len(one.multiplier):
        return Rest(rigid, one.t)
    return Rest(ready, one.t)
