"""Rigid contacts of a recorded model: their forces while they are shut, their impulses, and how they go on after.

A few of them, see SLOTS, take part at one instant: those that are shut or hit.  With f = (N, T) of each of these, N
away from its wall and T along the slip of B, rates and accelerations of their gaps and slips are

    a = G f + b,        G = W M^-1 W^T with all joints and drivers kept

An impact (Newton) and the modes that last are the solutions of

    0 <= N,  0 <= a_n,  N a_n = 0;      a_t = 0 and |T| <= mu N, or T = -mu N sign(a_t)

with a = g'+ + e g'- and u+ + e_t u- in an impact, and g'', u' where rates are zero.  All modes are tried, each is a
formula; none or two that fit are said by a flag.

Joints that rub add their own forces, tau = C + D f in given modes, see `recorded_friction`: G and b contain them,
linearised anew until they stay the same.

Source: Pfeiffer, Glocker, Multibody Dynamics with Unilateral Contacts (1996), chapters 5 to 8.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from rattle.equations import compliant, motion
from rattle.equations.dry_friction import DEPENDENT, REST
from rattle.equations.state import DISSIPATED, IMPULSE, LOSS, WORK, account_at, energies_at
from rattle.jit import layout as at
from rattle.jit.choices import assume
from rattle.language.recorded import Flag, Operand, symbol_of
from rattle.solvers.contacts.clutches import most_torque
from rattle.solvers.contacts.gap_search import rate_rounding
from rattle.solvers.nonsmooth.impact_phases import ENERGETIC, LZB, NEWTON, POISSON
from rattle.trace.graph import Graph, Symbol, apply, both, select, select_flag, summed
from rattle.trace.recorded_friction import (
    HIT,
    KEPT,
    LASTING,
    ROUNDS,
    Free,
    Pull,
    RecordedFriction,
    Shares,
    away,
    hidden,
)
from rattle.trace.recorded_language import Copies
from rattle.trace.recorded_modes import SLIGHT, Try, add, first, power, solved
from rattle.trace.recorded_restitution import Party, along_path, expanded

SLOTS, MOST_SLOTS = 2, 3  # contacts that take part at one instant, with friction; most without, or if it is crowded
# what a contact is: its state as an input of the graph; HITS: what is shut beside a contact that hits, too
OPEN, SHUT, HITS, DECIDES = 0.0, 1.0, 2.0, 3.0
OFF, STICKS, FORWARD, BACKWARD, LIMIT = range(5)  # modes; LIMIT: of a clutch that slips at its largest torque
ROUNDED = 1e-13  # share of the terms of a rate or an acceleration that is rounding
SOLVED = 1e-6  # share of b by which equations may be missed
FIXED = 1e-11  # share of G without joints that G is where these fix a gap or a slip


class Struck(NamedTuple):
    """What becomes of a state with rigid contacts at an instant at which no time passes."""

    state: list[Operand]  # (ny,) after impulses, on the walls that are touched
    shut: dict[int, Operand]  # by contact: 1 if it is shut from then on, 0
    slide: dict[int, Operand]  # and the sense of its slip, 0: none
    impulse: dict[int, Operand]  # [N s or N m s]
    sound: Operand  # 1: there is one solution; 0; -1, -2: more contacts take part than SLOTS, than MOST_SLOTS
    rubs: list[Operand]  # modes of joints that rub to be tried next in an impact
    free: list[Flag]  # they may have any
    agreed: Operand  # 1; 0: the joints disagree with the impulses; -1: there are none in their modes, or no forces


class _Slot(NamedTuple):
    """The contact that takes part in one place."""

    chosen: dict[int, Flag]  # by contact: it is this one
    taken: Flag  # there is one
    push: list[np.ndarray]  # generalised impulses (nb + 1, 3) of units of N and of T
    away: list[np.ndarray]  # change of rates by them
    reaction: list[np.ndarray]  # multipliers
    loose: list[Flag]  # joints and drivers do not fix its gap, its slip

    def of(self, values: dict[int, Operand]) -> Operand:
        """The value of the contact that is here."""
        result: Operand = 0.0
        for n, flag in self.chosen.items():
            result = select(flag, values[n], result)
        return result


class _Without(NamedTuple):
    """Accelerations without forces of contacts and friction of joints."""

    normal: dict[int, Operand]  # g'' by contact [m/s^2 or rad/s^2]
    tangent: dict[int, Operand]  # and of its slip
    joints: Free | None


class _Problem(NamedTuple):
    """Equations of the forces of slots, by rows and columns N, T of each in turn."""

    g: list[list[Operand]]
    right: list[tuple[Operand, Operand]]  # -b
    size: list[Operand]  # of b by row, without friction of joints
    loose: list[Flag]  # by row: joints that stick leave something of it


class _Solution(NamedTuple):
    """What satisfies them in some modes."""

    forces: list[list[Operand]]  # N and T of each slot
    rubbing: list[Operand]  # forces of joints that rub
    converged: Flag
    problem: _Problem  # with the friction of joints in it


def _flat(forces: Iterable[Sequence[Operand]]) -> list[Operand]:
    """N and T of each slot in turn."""
    return [x for pair in forces for x in pair]


def _value(n: int, slots: Sequence[_Slot], values: Iterable[Operand]) -> Operand:
    """That of contact n, among the values of the slots; 0 if it does not take part."""
    return summed(select(slot.chosen[n], x, 0.0) for slot, x in zip(slots, values, strict=True))


class RigidContacts:
    """Those of a system on symbols of one graph."""

    def __init__(
        self, graph: Graph, copies: Copies, table: np.ndarray, numbers: Sequence[int], shut: Sequence[Operand],
        slide: Sequence[Operand], is_shut: Sequence[Flag], rough: bool, crowded: bool,
        rubbing: RecordedFriction | None, slips: Mapping[int, Flag],
    ) -> None:  # fmt: skip
        """numbers: which contacts of the table; shut, slide, is_shut: of all; rough: some may have friction; crowded:
        MOST_SLOTS of these may take part at one instant; rubbing: friction of joints; slips: clutches that have a
        largest torque, and a flag: they slip at it."""
        self.graph, self._copies, self.table, self.numbers = graph, copies, table, list(numbers)
        self.state, self.slide, self.rough, self.rubbing = shut, slide, rough, rubbing
        self.shut = {n: is_shut[n] for n in self.numbers}
        self.slips = slips
        self.takes_part = rubbing is not None and rubbing.takes_part  # joints have impulses
        self.width = 2 if rough else 1
        self.clutches_hold = rubbing is not None and any(
            table[n, at.LEVEL] for n in self.numbers
        )  # clutches beside joints
        self._most = min(MOST_SLOTS if crowded or not rough else SLOTS, len(self.numbers))

    # ---------------------------------------------------------------- responses
    def _slots(self, m: SimpleNamespace, flags: dict[int, Flag]) -> tuple[list[_Slot], Operand]:
        """The contacts that take part, and how many there are."""
        units = {n: [self._unit(m, n, 1.0, 0.0), self._unit(m, n, 0.0, -1.0)][: self.width] for n in self.numbers}
        slots, alone = [], len(self.numbers) == 1
        for k in range(self._most):
            seen: Operand = 0.0
            chosen: dict[int, Flag] = {}
            for n in self.numbers:
                chosen[n] = flags[n] if alone else flags[n] & apply("equal", seen, float(k))
                seen = seen + select(flags[n], 1.0, 0.0)
            taken: Flag = False
            for flag in chosen.values():
                taken = taken | flag
            push = [self._chosen(chosen, [units[n][r] for n in self.numbers]) for r in range(self.width)]
            responses = [self._respond(m, impulse) for impulse in push]
            loose = [
                hidden(power(p, r[0]) > FIXED * power(p, p * m.weight)) for p, r in zip(push, responses, strict=True)
            ]
            slots.append(_Slot(chosen, taken, push, [x[0] for x in responses], [x[1] for x in responses], loose))
        total: Operand = 0.0
        for n in self.numbers:
            total = total + select(flags[n], 1.0, 0.0)
        return slots, total

    def _chosen(self, chosen: dict[int, Flag], arrays: list[np.ndarray]) -> np.ndarray:
        if len(arrays) == 1:
            return arrays[0]
        result = np.zeros(arrays[0].shape, dtype=object)
        for place in np.ndindex(result.shape):
            value: Operand = 0.0
            for flag, array in zip(chosen.values(), arrays, strict=True):
                entry: Any = array[place]
                if isinstance(entry, Symbol) or entry != 0.0:
                    value = select(flag, entry, value)
            result[place] = value
        return result

    def _unit(self, m: SimpleNamespace, n: int, normal: float, tangent: float) -> np.ndarray:
        impulse = np.zeros(m.force.shape, dtype=object)
        a, b = m.contact[n, at.A_BODY], m.contact[n, at.B_BODY]
        self._copies.of(compliant.add_contact_force.python)(impulse, m.contact_kinematics, a, b, n, normal, tangent)
        impulse[0] = 0.0
        return impulse

    def _respond(self, m: SimpleNamespace, impulse: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        held = m.force.copy(), m.rows[:, at.GAMMA].copy(), m.acceleration.copy(), m.multiplier.copy()
        m.force[:], m.rows[:, at.GAMMA] = impulse, 0.0
        self._copies.of(motion.accelerate.python)(m)
        answer = m.acceleration.copy(), m.multiplier.copy()
        m.force[:], m.rows[:, at.GAMMA], m.acceleration[:], m.multiplier[:] = held
        return answer

    def _matrix(self, slots: list[_Slot]) -> list[list[Operand]]:
        """G: rows and columns N, T of each slot in turn."""
        pushes = [push for slot in slots for push in slot.push]
        aways = [away for slot in slots for away in slot.away]
        return [[power(push, away) for away in aways] for push in pushes]

    def faint(self, m: SimpleNamespace, n: int) -> tuple[Operand, Operand]:
        """g'' of contact n that may be rounding [m/s^2 or rad/s^2], by its terms, and the force with which it goes."""
        push, free = self._unit(m, n, 1.0, 0.0), 0.0
        terms = abs(m.contact_kinematics[n, at.GAMMA_N])
        for place in np.ndindex(push.shape):
            if place[0] > 0:
                # what presses on a body at rest others take up, but for rounding of all of it
                forces = m.force[place[0], :2] if place[1] < 2 else m.force[place[0], 2:]
                pressed = m.weight[place] * summed(abs(x) for x in forces)
                terms = terms + abs(push[place] * m.acceleration[place]) + abs(push[place]) * pressed
                free = free + push[place] * push[place] * m.weight[place]
        for j in range(len(m.dry_memory)):  # friction of joints may balance what presses
            terms = terms + abs(power(push, away(m, j)) * m.dry_memory[j, at.DRY_FORCE])
        return ROUNDED * terms, ROUNDED * terms / free

    def bends(self, m: SimpleNamespace) -> tuple[dict[int, Operand], dict[int, Operand]]:
        """g'' and the rate of slip of each contact by the present accelerations."""
        kinematics, normal, tangent = m.contact_kinematics, {}, {}
        for n in self.numbers:
            normal[n] = kinematics[n, at.GAMMA_N] + power(self._unit(m, n, 1.0, 0.0), m.acceleration)
            if self.rough:
                tangent[n] = power(self._unit(m, n, 0.0, -1.0), m.acceleration) - kinematics[n, at.GAMMA_T]
        return normal, tangent

    # ---------------------------------------------------------------- forces that last
    def hold(self, m: SimpleNamespace) -> None:
        """Add the forces of contacts that are shut, and of joints that rub, to the accelerations, with N, T and what
        they lose."""
        slots, _ = self._slots(m, self.shut)
        free = m.without_contacts = self._without(m)
        solution = self._in_modes(m, slots, self._right(slots, free.normal, free.tangent), free.joints, LASTING)
        forces = solution.forces
        if self.rubbing is not None:
            self._copies.of(assume.python)(solution.converged)
            self.rubbing.spread(m, solution.rubbing)
            self.rubbing.off = self._off(m, slots)
        for target, what in ((m.acceleration, "away"), (m.multiplier, "reaction")):
            before = target.copy()
            self._add(target, slots, forces, what)
            for place in np.ndindex(target.shape):
                if target[place] is not before[place]:
                    target[place] = select(slots[0].taken, target[place], before[place])
        kinematics = m.contact_kinematics
        for n in self.numbers:
            kinematics[n, at.NORMAL] = _value(n, slots, (f[0] for f in forces))
            if self.rough:
                held = _value(n, slots, (f[1] for f in forces))
                kinematics[n, at.TANGENT] = -held
                sticks = apply("equal", self.slide[n], 0.0)
                slips = select(sticks, 0.0, -held * kinematics[n, at.SLIP])
                kinematics[n, at.LOSS] = select(self.shut[n], slips, 0.0)
        for n, slips in self.slips.items():
            most = self._copies.of(most_torque.python)(m, n)
            kinematics[n, at.NORMAL] = select(slips, most, kinematics[n, at.NORMAL])
            kinematics[n, at.LOSS] = select(slips, -most * kinematics[n, at.DGAP], 0.0)

    def _off(self, m: SimpleNamespace, slots: list[_Slot]) -> list[Operand]:
        """What would be added to the rates of joints that rub if contacts that are shut had none: these hold only
        accelerations, and a joint that is pressed against one would turn back by the errors of steps."""
        kinematics = m.contact_kinematics
        rate, slip = ({n: kinematics[n, column] for n in self.numbers} for column in (at.DGAP, at.SLIP))
        for n in self.slips:  # that of one with a largest torque jumps in impacts
            rate[n] = select(self._hits(), 0.0, rate[n])
        kept = self._in_modes(m, slots, self._right(slots, rate, slip), None, KEPT).forces
        pulls, flat = self._pulls(m, slots), _flat(kept)
        joints = range(len(m.dry_memory))
        return [summed(pull.rates[n] * f for pull, f in zip(pulls, flat, strict=True)) for n in joints]

    def _without(self, m: SimpleNamespace) -> _Without:
        """Accelerations of gaps and slips, and of joints that rub, at those in m."""
        return _Without(*self.bends(m), None if self.rubbing is None else self.rubbing.free(m))

    def _right(
        self, slots: list[_Slot], normal: dict[int, Operand], tangent: dict[int, Operand]
    ) -> list[tuple[Operand, Operand]]:
        """-b of each slot, by contact the numbers that are to become zero."""
        return [(-slot.of(normal), -slot.of(tangent) if self.rough else 0.0) for slot in slots]

    def _solved(
        self, m: SimpleNamespace, slots: list[_Slot], right: list[tuple[Operand, Operand]], joints: Free | None,
        what: int, forces: Callable[[_Problem], list[list[Operand]]],
    ) -> _Solution:  # fmt: skip
        """Forces by a formula for given modes, beside joints that rub; right: -b without them."""
        g, w = self._matrix(slots), self.width
        if self.rubbing is None or joints is None:
            problem = _Problem(g, right, [abs(b) for pair in right for b in pair[: self.width]], [True] * len(g))
            return _Solution(forces(problem), [], True, problem)
        pulls = self._pulls(m, slots)
        tau: list[Operand] = [0.0] * len(joints.rates)
        f: list[list[Operand]] = [[0.0] * w for _ in slots]
        converged: Flag = True
        start, before = len(self.graph), list[Operand]()
        for _ in range(1 if what == KEPT else ROUNDS):  # it is linear
            before = [*tau, *_flat(f)]
            shares = self.rubbing.shares(m, joints, pulls, tau, _flat(f), what)
            problem = self._with_shares(g, right, pulls, shares)
            f = forces(problem)
            tau, converged = self.rubbing.improved(shares, _flat(f), tau)
        self.rubbing.leave_out(range(start, len(self.graph)), [*tau, *_flat(f)], before)
        return _Solution(f, tau, converged, problem)

    def _with_shares(
        self, g: list[list[Operand]], right: list[tuple[Operand, Operand]], pulls: list[Pull], shares: Shares
    ) -> _Problem:
        """The equations with the friction of joints, linear in the forces, in them."""
        w = self.width
        rows = [
            [x + summed(c * by[s] for c, by in zip(pull.rates, shares.by, strict=True)) for s, x in enumerate(row)]
            for pull, row in zip(pulls, g, strict=True)
        ]
        alone = [summed(c * x for c, x in zip(pull.rates, shares.alone, strict=True)) for pull in pulls]
        left = [(a - alone[w * k], b - alone[w * k + 1] if self.rough else 0.0) for k, (a, b) in enumerate(right)]
        loose = [row[r] > DEPENDENT * g[r][r] for r, row in enumerate(rows)]
        return _Problem(rows, left, [abs(b) for pair in right for b in pair[: self.width]], loose)

    def _pulls(self, m: SimpleNamespace, slots: list[_Slot]) -> list[Pull]:
        """What unit forces N, T of each slot in turn do to joints that rub."""
        if self.rubbing is None:
            return []
        return [
            self.rubbing.pull(m, moved, reaction)
            for slot in slots
            for moved, reaction in zip(slot.away, slot.reaction, strict=True)
        ]

    def _in_modes(
        self, m: SimpleNamespace, slots: list[_Slot], right: list[tuple[Operand, Operand]], joints: Free | None,
        what: int,
    ) -> _Solution:  # fmt: skip
        """N and T of each slot that keep g'' or g', and slips of those that stick, at zero; right: -b without them.

        A bounce that is not followed is taken back so, with its friction.
        """
        return self._solved(m, slots, right, joints, what, functools.partial(self._kept_in_modes, m, slots))

    def _kept_in_modes(self, m: SimpleNamespace, slots: list[_Slot], problem: _Problem) -> list[list[Operand]]:
        """As `_in_modes`, of a problem."""
        g, w = problem.g, self.width
        rows: list[list[Operand]] = []
        for k, slot in enumerate(slots):
            presses = slot.taken & problem.loose[w * k]
            rows.append([
                *(select(presses, x, 1.0 if j == w * k else 0.0) for j, x in enumerate(g[w * k])),
                select(presses, problem.right[k][0], 0.0),
            ])  # fmt: skip
            if not self.rough:
                continue
            slide, mu = slot.of(dict(enumerate(self.slide))), slot.of(self._of(m, at.MU))
            sticks = slot.taken & apply("equal", slide, 0.0) & (mu > 0.0) & slot.loose[1] & problem.loose[w * k + 1]
            slips: list[Operand] = [0.0] * (w * len(slots))
            slips[w * k], slips[w * k + 1] = slide * mu, 1.0
            rows.append([
                *(select(sticks, x, y) for x, y in zip(g[w * k + 1], slips, strict=True)),
                select(sticks, problem.right[k][1], 0.0),
            ])  # fmt: skip
        f = solved(rows)
        return [f[w * k : w * k + w] for k in range(len(slots))]

    def _add(self, target: np.ndarray, slots: list[_Slot], f: Sequence[Sequence[Operand]], what: str) -> None:
        for slot, forces in zip(slots, f, strict=True):
            for response, force in zip(getattr(slot, what), forces, strict=True):
                add(target, response, force)

    def _of(self, m: SimpleNamespace, field: int) -> dict[int, Operand]:
        return {n: m.values[self.table[n, at.NORMAL_P] + field] for n in self.numbers}

    # ---------------------------------------------------------------- instants
    def struck(self, m: SimpleNamespace, y: np.ndarray) -> Struck:
        """What becomes of the state y (ny,), for which the equations of motion without closed contacts stand in m."""
        # what is finite has no impulse
        parts = {n: self.state[n] > (2.5 if n in self.slips else 0.5) for n in self.numbers}
        slots, count = self._slots(m, parts)
        hits, decides = self._hits(), self._decides()
        rate = {n: m.contact_kinematics[n, at.DGAP] for n in self.numbers}
        slip = {n: m.contact_kinematics[n, at.SLIP] for n in self.numbers}
        joints = None if self.rubbing is None else self.rubbing.before(m)
        struck, rubs, met = self._impulses(m, slots, rate, slip, joints)
        kept = self._in_modes(m, slots, self._right(slots, rate, slip), joints, KEPT)
        impulses = [
            [select(hits, a, b) for a, b in zip(x, y_, strict=True)] for x, y_ in zip(struck, kept.forces, strict=True)
        ]
        rubbing = [select(hits, a, b) for a, b in zip(rubs, kept.rubbing, strict=True)]
        state = self._after(m, y, slots, impulses, rubbing, rate, slip)
        turned, can, agreed = self._agrees(m, slots, struck, rubs)
        agreed = apply("not", hits) | (agreed & met)
        if self.rubbing is not None:
            state = [select(agreed, new, old) for new, old in zip(state, y, strict=True)]
        free: _Without = m.without_contacts
        _, _, lasts, modes = self._tried(m, slots, self._right(slots, free.normal, free.tangent), free.joints, LASTING)
        shut, slide = self._lasting(slots, modes, decides)
        impulse = {n: select(hits & agreed, _value(n, slots, (f[0] for f in struck)), 0.0) for n in self.numbers}
        solved = (met | apply("not", hits)) & (lasts | apply("not", decides))
        sound, told = select(solved, 1.0, 0.0), symbol_of(1.0)
        if self.rubbing is not None:  # joints may have other modes
            sound, told = 1.0, select(solved, select(agreed, 1.0, 0.0), -1.0)
        crowd = select(count <= float(MOST_SLOTS), -1.0, -2.0)
        sound = select(count <= float(self._most), sound, crowd)
        if self._law(m) in (ENERGETIC, LZB):  # one at a time
            sound = select(hits & (count > 1.0), -2.0, sound)
        return Struck(state, shut, slide, impulse, sound, turned, can, told)

    def _lasting(
        self, slots: list[_Slot], modes: list[Operand], decides: Flag
    ) -> tuple[dict[int, Operand], dict[int, Operand]]:
        """What contacts are from now on, and the senses of their slips, by the modes of slots if some decide."""
        shut, slide = dict[int, Operand](), dict[int, Operand]()
        for n in self.numbers:
            mode = _value(n, slots, modes)
            shut[n] = select(decides, select(mode > 0.5, SHUT, OPEN), self.state[n])
            way = select(mode < 1.5, 0.0, select(mode < 2.5, 1.0, -1.0))
            slide[n] = select(decides, select(mode > 0.5, way, 0.0), self.slide[n])
        return shut, slide

    def _hits(self) -> Flag:
        """Whether some contact does."""
        hits: Flag = False
        for n in self.numbers:
            hits = hits | ((self.state[n] > 1.5) & (self.state[n] < 2.5))
        return hits

    def _decides(self) -> Flag:
        """Whether some contact does."""
        decides: Flag = False
        for n in self.numbers:
            decides = decides | (self.state[n] > 2.5)
        return decides

    def _agrees(
        self, m: SimpleNamespace, slots: list[_Slot], struck: list[list[Operand]], rubs: list[Operand]
    ) -> tuple[list[Operand], list[Flag], Flag]:
        """Modes of joints that rub to be tried next in an impact, and whether they may have any; a flag: those at hand
        agree with it."""
        if self.rubbing is None:
            return [], [], True
        flat = _flat(struck)
        turned, agrees = self.rubbing.after_impact(m, self._pulls(m, slots), rubs, flat)
        return turned, [self.rubbing.is_open(m, n) for n in self.rubbing.rubs], agrees

    def _impulses(
        self, m: SimpleNamespace, slots: list[_Slot], rate: dict[int, Operand], slip: dict[int, Operand],
        joints: Free | None,
    ) -> tuple[list[list[Operand]], list[Operand], Flag]:  # fmt: skip
        """N and T [N s] of each slot in an impact by the restitution law, those of joints that rub; a flag: there is
        one way."""
        law = self._law(m)
        none: list[Operand] = [] if joints is None else [0.0] * len(joints.rates)
        if joints is not None and not self.takes_part:  # what is finite has no impulse
            joints = None
        if law == NEWTON or (len(self.numbers) == 1 and not self.rough):  # then all laws are one
            f, rubs, met, _ = self._tried(m, slots, [self._before(m, slot, rate, slip) for slot in slots], joints, HIT)
            return f, rubs or none, met
        f, met = self._in_phases(m, slots, rate, slip, law == POISSON)
        return f, none, met

    def _law(self, m: SimpleNamespace) -> float:
        """The restitution law of the contacts."""
        law: float = m.values[self.table[self.numbers[0], at.NORMAL_P] + at.RESTITUTION_LAW]
        return law

    def _in_phases(
        self, m: SimpleNamespace, slots: list[_Slot], rate: dict[int, Operand], slip: dict[int, Operand], poisson: bool
    ) -> tuple[list[list[Operand]], Flag]:
        """As `_impulses`, of an impact in which expansion follows compression, after Poisson or by energy."""
        e, mu = (self._of(m, field) for field in (at.RESTITUTION, at.MU))
        parties = [Party(slot.taken, slot.loose, slot.of(mu), slot.of(e)) for slot in slots]
        rates = [x for slot in slots for x in (slot.of(rate), slot.of(slip))[: self.width]]
        g = self._matrix(slots)
        if poisson:
            f, _, met, _ = self._tried(m, slots, [(-slot.of(rate), -slot.of(slip)) for slot in slots], None, HIT)
            f, expands = expanded(self.graph, g, parties, f, rates)
            return f, met & expands
        struck: list[Operand] = [-(1.0 + parties[0].restitution) * rates[0] / g[0][0]]
        met = True
        if self.rough:
            struck, met = along_path(g, parties[0], rates[0], rates[1])
        return [struck, *(list[Operand]([0.0] * self.width) for _ in slots[1:])], met

    def _before(
        self, m: SimpleNamespace, slot: _Slot, rate: dict[int, Operand], slip: dict[int, Operand]
    ) -> tuple[Operand, Operand]:
        """-b of an impact: (1 + e) g', (1 + e_t) u of what hits; rates alone of what is shut."""
        slight = {n: self._copies.of(rate_rounding.python)(m, n) for n in self.numbers}
        hits = slot.of({
            n: select((self.state[n] > 1.5) & (rate[n] < -slight[n]), 1.0, 0.0) for n in self.numbers
        })  # fmt: skip
        # what rests at its wall hits it by rounding
        rate = {n: select(abs(rate[n]) <= REST + slight[n], 0.0, rate[n]) for n in self.numbers}
        e, e_t = (slot.of(self._of(m, k)) for k in (at.RESTITUTION, at.TANGENTIAL_RESTITUTION))
        normal = -(1.0 + hits * e) * slot.of(rate)
        return normal, (-(1.0 + hits * e_t) * slot.of(slip) if self.rough else 0.0)

    def _tried(
        self, m: SimpleNamespace, slots: list[_Slot], right: list[tuple[Operand, Operand]], joints: Free | None,
        what: int,
    ) -> tuple[list[list[Operand]], list[Operand], Flag, list[Operand]]:  # fmt: skip
        """As `first` of all combinations of modes, with forces of joints that rub; right: -b.

        what: of forces that are LASTING contacts whose sense of slip is given keep it.
        """
        g, lasting = self._matrix(slots), what == LASTING
        pulls = [] if joints is None else self._pulls(m, slots)
        mus = [slot.of(self._of(m, at.MU)) if self.rough else 0.0 for slot in slots]
        slides = [slot.of(dict(enumerate(self.slide))) if self.rough else 0.0 for slot in slots]
        most = {n: self._copies.of(most_torque.python)(m, n) for n in self.slips}
        mosts = [slot.of({n: most.get(n, 0.0) for n in self.numbers}) for slot in slots]
        tries = []
        for combination in self._combinations(len(slots), lasting):
            formula = functools.partial(self._forces, mus, mosts, combination)
            f, rubs, converged, problem = self._solved(m, slots, right, joints, what, formula)
            f = self._idle_clutches(slots, combination, problem, f) if lasting else f
            flags = [converged, *self._conditions(problem, slots, mus, slides, combination, f, lasting)]
            flags += self._within_limits(mosts, combination, f)
            flat = _flat(f)
            gains = [summed(x * y for x, y in zip(row, flat, strict=True)) for row in g]
            for r, pull in enumerate(pulls):
                gains[r] = gains[r] + summed(c * x for c, x in zip(pull.rates, rubs, strict=True))
            tries.append(Try((*combination, OFF), [*f, rubs], gains, both(self.graph, flags)))
        forces, unique, modes = first(tries)
        return forces[:-1], forces[-1], unique, modes[:-1]

    def _combinations(self, count: int, lasting: bool) -> list[tuple[int, ...]]:
        """The modes of so many slots in the order in which they are tried."""
        options = [OFF, FORWARD] if not self.rough else [OFF, STICKS, FORWARD, BACKWARD]
        if lasting:  # what rests without a force stays shut: it takes part in impacts
            options = [*options[1:], OFF, *([LIMIT] if self.slips else [])]
        combinations: list[tuple[int, ...]] = list(itertools.product(options, repeat=count))
        if self.rough and count > SLOTS:  # what three hold by friction is not known: first those of few
            combinations.sort(key=lambda modes: len(modes) - modes.count(OFF))
        return combinations

    def _forces(
        self, mus: list[Operand], mosts: list[Operand], combination: Sequence[int], problem: _Problem
    ) -> list[list[Operand]]:
        """N and T of each slot in these modes."""
        g, w = problem.g, self.width
        unknown = [(k, r) for k, mode in enumerate(combination) for r in range(w)
                   if (mode not in (OFF, LIMIT) and r == 0) or (mode == STICKS and r == 1)]  # fmt: skip
        right = self._left_by_limits(mosts, combination, problem)
        rows = []
        for k, r in unknown:
            row = [self._per_unit(g[w * k + r], j, s, combination[j], mus[j]) for j, s in unknown]
            loose = problem.loose[w * k + r]  # what joints hold bears nothing, and stays shut
            own = [1.0 if place == (k, r) else 0.0 for place in unknown]
            rows.append(
                [*(select(loose, x, y) for x, y in zip(row, own, strict=True)), select(loose, right[w * k + r], 0.0)]
            )
        solution = dict(zip(unknown, solved(rows) if rows else [], strict=True))
        f = []
        for k, mode in enumerate(combination):
            normal = mosts[k] if mode == LIMIT else solution.get((k, 0), 0.0)
            tangent = solution[k, 1] if mode == STICKS else self._pull(mode, mus[k]) * normal
            f.append([normal, tangent][:w])
        return f

    def _idle_clutches(
        self, slots: list[_Slot], combination: Sequence[int], problem: _Problem, f: list[list[Operand]]
    ) -> list[list[Operand]]:
        """Forces in these modes, where the torque of a clutch that holds is rounding without it: it stays shut, as what
        is about to press it would have to begin by a rate below zero."""
        if not self.clutches_hold:
            return f
        level: dict[int, Operand] = {n: float(self.table[n, at.LEVEL]) for n in self.numbers}
        result = []
        for k, (slot, mode, forces) in enumerate(zip(slots, combination, f, strict=True)):
            own = problem.g[self.width * k][self.width * k]
            idle = (slot.of(level) > 0.5) & (abs(own * forces[0]) <= SLIGHT * problem.size[self.width * k])
            result.append(
                [select(idle, 0.0, forces[0]), *forces[1:]] if mode in (STICKS, FORWARD, BACKWARD) else forces
            )
        return result

    def _left_by_limits(self, mosts: list[Operand], combination: Sequence[int], problem: _Problem) -> list[Operand]:
        """-b by row, less what clutches do that slip at their largest torque."""
        limits = [(self.width * j, most) for j, most in enumerate(mosts) if combination[j] == LIMIT]
        right = [b for pair in problem.right for b in pair[: self.width]]
        return [b - summed(row[j] * most for j, most in limits) for row, b in zip(problem.g, right, strict=True)]

    def _per_unit(self, row: list[Operand], j: int, s: int, mode: int, mu: Operand) -> Operand:
        """What a unit of N (s = 0) or T of slot j does, N with the friction of its slip."""
        own = row[self.width * j + s]
        slips = s == 0 and self.rough and mode in (FORWARD, BACKWARD)
        return own + self._pull(mode, mu) * row[self.width * j + 1] if slips else own

    @staticmethod
    def _pull(mode: int, mu: Operand) -> Operand:
        """T / N where a contact slips."""
        return -mu if mode == FORWARD else mu if mode == BACKWARD else 0.0

    def _conditions(
        self, problem: _Problem, slots: list[_Slot], mus: list[Operand], slides: list[Operand],
        combination: Sequence[int], f: list[list[Operand]], lasting: bool,
    ) -> list[Flag]:  # fmt: skip
        flat, w = _flat(f), self.width
        right = [x for pair in problem.right for x in pair[:w]]
        after = [
            summed(x * y for x, y in zip(row, flat, strict=True)) - b for row, b in zip(problem.g, right, strict=True)
        ]
        own = [apply("sqrt", abs(row[n])) for n, row in enumerate(problem.g)]
        most = ROUNDED * summed(x * abs(y) for x, y in zip(own, flat, strict=True))  # times `own`: what rounding leaves
        close = SOLVED * summed(
            abs(b) for b in right
        )  # equations of a bar that leans on a wall may contradict each other
        flags: list[Flag] = []
        for k, mode in enumerate(combination):
            if mode == OFF:
                slight = SLIGHT * problem.size[w * k] + own[w * k] * most
                flags.append((after[w * k] >= -slight) | apply("not", slots[k].taken))
                continue
            if mode == LIMIT:
                flags += [slots[k].taken, after[w * k] <= SLIGHT * problem.size[w * k] + own[w * k] * most]
                continue
            met = abs(after[w * k]) <= close
            if self.clutches_hold:  # its torque may be left out, see `_idle_clutches`
                met = met | (apply("equal", f[k][0], 0.0) & (abs(after[w * k]) <= SLIGHT * problem.size[w * k]))
            flags += [slots[k].taken, slots[k].loose[0], f[k][0] >= 0.0, met]
            if not self.rough:
                continue
            slide = slides[k] if lasting else 0.0
            if mode == STICKS:
                flags += [abs(f[k][1]) <= (1.0 + SLIGHT) * mus[k] * f[k][0], slots[k].loose[1]]
                flags += [abs(after[w * k + 1]) <= close, apply("equal", slide, 0.0)]
            else:
                slight = SLIGHT * problem.size[w * k + 1] + own[w * k + 1] * most
                flags.append(self._slips_away(mode, after[w * k + 1], slide, slight))
        return flags

    def _within_limits(self, mosts: list[Operand], combination: Sequence[int], f: list[list[Operand]]) -> list[Flag]:
        """Clutches with a largest torque hold by no more than it, or slip at it; others do not slip."""
        flags: list[Flag] = []
        for most, mode, (normal, *_) in zip(mosts, combination, f, strict=True):
            if not self.slips or mode == OFF:
                continue
            limited = most > 0.0
            flags.append(limited if mode == LIMIT else apply("not", limited) | (normal <= (1.0 + SLIGHT) * most))
        return flags

    @staticmethod
    def _slips_away(mode: int, after: Operand, slide: Operand, slight: Operand) -> Flag:
        """Whether a slot slips in the sense of its mode, or is given to; after: its slip, or how that changes, which
        others may hold at zero but for what is slight."""
        sense = 1.0 if mode == FORWARD else -1.0
        slipped = apply("not", apply("equal", slide, 0.0))
        return select_flag(slipped, sense * slide > 0.0, sense * after >= -slight)

    def _after(
        self, m: SimpleNamespace, y: np.ndarray, slots: list[_Slot], impulses: list[list[Operand]],
        rubbing: list[Operand], rate: dict[int, Operand], slip: dict[int, Operand],
    ) -> list[Operand]:  # fmt: skip
        """y after impulses, those of joints that rub too, with the walls that are touched at their places; what else
        its energy gains is work of drivers."""
        nq = m.change.shape[0]
        moved = np.zeros(m.acceleration.shape, dtype=object)
        self._add(moved, slots, impulses, "away")
        for n, impulse in enumerate(rubbing):
            add(moved, away(m, n), impulse)
        gap = {n: 0.0 if self.table[n, at.LEVEL] else m.contact_kinematics[n, at.GAP] for n in self.numbers}
        ways = self._put_back(slots, [slot.of(gap) for slot in slots])
        placed = np.zeros(m.acceleration.shape, dtype=object)
        self._add(placed, slots, ways, "away")
        state, gained = list(y), 0.0
        for i in range(1, m.mass.shape[0]):
            for k in range(3):
                place, new = nq + 3 * i - 3 + k, y[nq + 3 * i - 3 + k] + moved[i, k]
                state[3 * i - 3 + k] = y[3 * i - 3 + k] + placed[i, k]
                state[place] = new
                gained = gained + 0.5 * m.mass[i, k] * (moved[i, k] * (new + y[place]))
        total = self._account(m, state, slots, impulses, rubbing, rate, slip)
        for n, impulse in enumerate(rubbing):
            assert self.rubbing is not None, "it has these impulses"
            lost, place = impulse * self.rubbing.mean_rate(m, n, moved), self._copies.of(energies_at.python)(m)
            state[place + DISSIPATED] = state[place + DISSIPATED] - lost
            total = total + lost
        driven = self._copies.of(energies_at.python)(m) + WORK
        state[driven] = state[driven] + gained - total
        return state

    def _account(
        self, m: SimpleNamespace, state: list[Operand], slots: list[_Slot], impulses: list[list[Operand]],
        rubbing: list[Operand], rate: dict[int, Operand], slip: dict[int, Operand],
    ) -> Operand:  # fmt: skip
        """Add impulses and losses to the accounts of contacts in a state; the work of all impulses [J]."""
        g, flat = self._matrix(slots), _flat(impulses)
        after = [summed(x * f for x, f in zip(row, flat, strict=True)) for row in g]
        for r, pull in enumerate(self._pulls(m, slots)):
            after[r] = after[r] + summed(c * x for c, x in zip(pull.rates, rubbing, strict=True))
        works = []
        for k, slot in enumerate(slots):
            pairs = [(slot.of(rate), impulses[k][0], after[self.width * k])]
            if self.rough:
                pairs.append((slot.of(slip), impulses[k][1], after[self.width * k + 1]))
            works.append(summed(f * (v + 0.5 * dv) for v, f, dv in pairs))
        for n in self.numbers:
            account = self._copies.of(account_at.python)(m, n)
            state[account + LOSS] = state[account + LOSS] - _value(n, slots, works)
            state[account + IMPULSE] = state[account + IMPULSE] + _value(n, slots, (f[0] for f in impulses))
        return summed(works)

    def _put_back(self, slots: list[_Slot], gaps: list[Operand]) -> list[list[Operand]]:
        """What moves the contacts that take part onto their walls."""
        g, w = self._matrix(slots), self.width
        rows = []
        for k, slot in enumerate(slots):
            row = [select(slot.taken & other.taken, g[w * k][w * j], float(j == k)) for j, other in enumerate(slots)]
            rows.append([*row, select(slot.taken, -gaps[k], 0.0)])
        return [[x, *[0.0] * (w - 1)] for x in solved(rows)]
