"""Contacts of a recorded model: whether each is shut, and how fast it closed, are inputs of the graph.

The force of a compliant contact is that of its laws where it is shut, none elsewhere.  A rigid one exerts none: what
an impact changes is recorded beside the motion, from the response of the mechanism to impulses along its normal and
its tangent, which the factor of the equations of motion gives.
"""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np

from rattle.equations import compliant
from rattle.equations.dry_friction import REST
from rattle.equations.state import LOSS, STORED, account_at, states_at
from rattle.equations.system import System
from rattle.errors import TraceError
from rattle.jit import families
from rattle.jit import layout as at
from rattle.jit.choices import assume
from rattle.language.recorded import Operand, Recorded, bare, symbol_of
from rattle.solvers.contacts.clutches import most_torque
from rattle.solvers.contacts.contact_events import GAUSS, WEIGHTS
from rattle.solvers.contacts.gap_search import rate_rounding
from rattle.solvers.nonsmooth.impact_phases import NEWTON, POISSON
from rattle.trace.graph import Graph, Symbol, apply, select, summed
from rattle.trace.known_signs import SHALLOW, Depth, positive
from rattle.trace.recorded_friction import RecordedFriction
from rattle.trace.recorded_language import Copies
from rattle.trace.recorded_rigid import SHUT, SLOTS, RigidContacts, Struck
from rattle.trace.recorded_switches import RecordedSwitches
from rattle.value_types import Plain

PRESSED = 1.5  # of an input `shut`: below it an elastic contact that has just pushed again, above it a released one
FIRST_DEPTH = 2.0**-20  # from which that is looked for where a contact turns back [m or rad]
ROUNDS, SHARE_OF_DOUBLINGS = 7, 0.5  # of the energy that the depth takes: its force grows about linearly
APART = 1e-3  # depth with which the laws of an open contact are computed, and left aside [m or rad]
UNABLE = (
    (at.FILM_LAW, "oil", lambda x: x >= 0), (at.WORN, "wear", bool),
)  # fmt: skip

CONTACTS = "contacts with {} ({{}}) cannot be straight-line code"


def _is(value: object, number: float) -> bool:
    """Whether a value is this number whatever the parameters."""
    return not isinstance(value, Recorded) and value == number


class RecordedContacts:
    """The contacts of a system, n of them, on symbols of one graph."""

    def __init__(
        self, graph: Graph, system: System, lanes: bool, friction: RecordedFriction | None,
        switches: RecordedSwitches | None, crowded: bool,
    ) -> None:  # fmt: skip
        """lanes: as these follow contacts, else as derivatives do;
        friction: that of joints without play, whose modes become inputs; switches: of expressions, whose sides do;
        crowded: more rigid contacts with friction at one instant, see `recorded_rigid`.

        Raises TraceError for a contact that cannot be recorded so.
        """
        self.graph, self.table, self.lanes = graph, system.arrays["contact"], lanes
        self.joints = tuple(system.joints[n] for n in self.table[:, at.OWNER])
        self.rigid = self.table[:, at.IMPACT] == 1
        values, places = system.arrays["values"], self.table[:, at.NORMAL_P]
        mu = [values[p + at.MU] if rigid else 1.0 for p, rigid in zip(places, self.rigid, strict=True)]
        smooth = [_is(x, 0.0) for x in mu]
        self.lasts = self.rigid & np.array(smooth, dtype=bool)  # rigid ones that may stay shut: those without friction
        levels = self.rigid & (self.table[:, at.LEVEL] == 1)
        self.limited = np.zeros_like(levels)
        for n in np.flatnonzero(levels).tolist():
            self.limited[n] = not _is(values[places[n] + at.MOST_TORQUE], math.inf)
        # they end where their force does, not their gap
        self.by_force = (self.table[:, at.BY_FORCE] == 1) | self.rigid | (self.table[:, at.LEVEL] == 1)
        self.scale = [bare(x) for x in system.arrays["lever"][:, at.GAP_SCALE]]  # sizes of gaps [m or rad]
        simple = friction is None and not any(_is(values[p + at.RESTITUTION_LAW], POISSON) for p in places[self.rigid])
        # whether rigid ones can be crowded: impacts in two phases, and joints that rub, make too much of each mode
        self.may_crowd = simple and self.rigid.sum() > SLOTS and bool((self.rigid & ~self.lasts).any())
        self.rubbing, self.switches, self._crowded = friction, switches, crowded
        for n in range(len(self.joints)):
            self._require_able(n, values)
        self._take_inputs()
        # a rigid one may be HITS, DECIDES too; one that slips at its largest torque exerts a force, and holds nothing
        self.is_shut = [(shut > 0.5) & (shut < 1.5) for shut in self.shut[: len(self.joints)]]
        self.slips = {n: self.is_shut[n] & (self.speed[n] < -0.5) for n in np.flatnonzero(self.limited).tolist()}
        for n in self.slips:
            self.is_shut[n] = self.is_shut[n] & (self.speed[n] > -0.5)
        self._rigid: RigidContacts | None = None

    def _take_inputs(self) -> None:
        """Inputs of each of two kinds: of contacts, then of joints that rub, then of switches."""
        rubs = [] if self.rubbing is None else self.rubbing.rubs
        first, last = len(self.joints), len(self.joints) + len(rubs)
        self.inputs = last + (0 if self.switches is None else len(self.switches))
        self.shut = [self.graph.input() for _ in range(self.inputs)]
        self.speed = [self.graph.input() for _ in range(self.inputs)]
        if self.rubbing is not None:
            self.rubbing.modes = dict(zip(rubs, self.speed[first:last], strict=True))
        if self.switches is not None:
            self.switches.sides = list(self.speed[last:])

    def _require_able(self, n: int, values: np.ndarray) -> None:
        """Raise TraceError for a contact that cannot be recorded."""
        entry, joint = self.table[n], self.joints[n]
        reasons = [(has(entry[k]), CONTACTS.format(words)) for k, words, has in UNABLE]
        reasons += self._unable_kinds(entry)
        if self.rigid[n]:
            reasons += self._unable_impacts(entry, values, bool(self.limited[n]))
        why = next((words for holds, words in reasons if holds), None)
        if why is not None:
            raise TraceError(why.format(f"joint {joint}"))

    def _unable_kinds(self, entry: np.ndarray) -> list[tuple[bool, str]]:
        """What may keep a contact from being recorded, and why, whether it is compliant or rigid; {} is its joint."""
        toothed, rubs = bool(entry[at.TOOTHED]), self.rubbing is not None and bool(self.rubbing.rubs)
        return [
            (toothed and not self.lanes, "a ratchet ({}) has no derivatives"),
            (toothed and rubs, "a ratchet ({}) beside joints that rub does not run side by side"),
        ]

    def _unable_impacts(self, entry: np.ndarray, values: np.ndarray, limited: bool) -> list[tuple[bool, str]]:
        """The same of a rigid one; limited: it is a clutch with a largest torque."""
        law, takes_part = (
            values[entry[at.NORMAL_P] + at.RESTITUTION_LAW],
            self.rubbing is not None and self.rubbing.takes_part,
        )
        do = "run side by side" if self.lanes else "have derivatives"
        beside = f"impacts ({{}}) beside dry friction of joints {do} with restitution_law"
        return [
            (takes_part and not _is(law, NEWTON), f'{beside} = "newton" only'),
            (limited and not self.lanes, "clutches with max_torque ({}) have no derivatives"),
        ]

    def __len__(self) -> int:
        return len(self.joints)

    def prepare(self, workspace: SimpleNamespace) -> None:
        """Set what kernels find in the memory of contacts."""
        workspace.closed_contacts_table = () if self._rigid is None else (self._hold,)
        for n in range(min(len(self), len(workspace.contact_memory))):
            clutch = self.table[n, at.LEVEL] or self.table[n, at.TOOTHED]  # which tell whether they are
            workspace.contact_memory[n, at.CLOSED] = select(self.is_shut[n], at.SHUT, at.OPEN) if clutch else at.SHUT
            workspace.contact_memory[n, at.SPEED] = self.speed[n]

    def begin(self, copies: Copies) -> None:
        """Let calls of contacts be recorded; before any kernel is."""
        copies.replace(families.call_stiffness, _positive_force)
        copies.replace(families.call_normal, _positive_force)
        copies.replace(compliant.size_of.python, lambda normal: positive(abs(normal)))
        self._copies = copies
        self._rigid = None
        if numbers := np.flatnonzero(self.rigid).tolist():
            self._rigid = RigidContacts(
                self.graph, copies, self.table, numbers, self.shut, self.speed, self.is_shut,
                not all(self.lasts[numbers]), self._crowded, self.rubbing, self.slips,
            )  # fmt: skip
        self._clutch = copies.of(compliant.add_clutch_torque.python)
        self._laws = self._said(copies.of(compliant.add_force_of_laws.python), "the law of force or friction")
        self._measure = self._said(copies.of(compliant.measure.python), "the shape")
        copies.replace(compliant.measure.python, self._located)
        copies.replace(compliant.add_contact_forces.python, self._add)

    def _located(self, m: SimpleNamespace, n: int, corner: int) -> None:
        """Stands for `compliant.measure`.

        The segment of a corner that bears on it goes on as a line: what touches is over it, elsewhere runs are left.
        """
        ends = bool(m.lever[n, at.ONE_WAY] > 0.0)
        if ends:
            m.contact_kinematics[n, at.PHASE] = at.HELD
        self._measure(m, n, corner)
        if ends:
            touches, beyond = self.shut[n] > 0.5, m.contact_kinematics[n, at.BEYOND] > 0.0
            self._copies.of(assume.python)(apply("not", touches & beyond))
        if self.table[n, at.TOOTHED]:
            self._seat(m, n)

    def _add(self, m: SimpleNamespace) -> None:
        """Stands for `compliant.add_contact_forces`."""
        for n in range(len(self)):
            for column in range(at.NORMAL, at.STORE + 1):
                m.contact_kinematics[n, column] = 0.0
            if not self.rigid[n]:
                self._add_compliant(m, n)
            elif n in self.slips:
                a, b, most = (
                    self.table[n, at.A_BODY],
                    self.table[n, at.B_BODY],
                    select(self.slips[n], self.most(m, n), 0.0),
                )
                self._copies.of(compliant.add_contact_force.python)(m.force, m.contact_kinematics, a, b, n, most, 0.0)

    def _add_compliant(self, m: SimpleNamespace, n: int) -> None:
        """Add the force of contact n where it is shut, with the rates of its states."""
        kinematics, shut, before = m.contact_kinematics, self.is_shut[n], m.force.copy()
        first = self.table[n, at.FIRST_STATE]
        states = range(first, first + self.table[n, at.STATES])
        for state in states:
            m.element_rate[state] = 0.0
        if self.table[n, at.LEVEL]:
            told, m.contact_memory[n, at.CLOSED] = m.contact_memory[n, at.CLOSED], at.SHUT
            self._clutch(m, n)
            m.contact_memory[n, at.CLOSED] = told
        else:
            measured = {column: kinematics[n, column] for column in (at.GAP, at.DGAP, at.SLIP)}
            goes_on = self.table[n, at.VANISHES] or self.table[n, at.BY_FORCE]
            for column, value in measured.items():  # of an open contact numbers with which laws do not switch
                ends = column == at.GAP and not goes_on
                inside = select(value < -SHALLOW, value, -SHALLOW) if ends else value
                kinematics[n, column] = select(shut, inside, -APART if column == at.GAP else 0.0)
            kinematics[n, at.GAP] = _depth(kinematics[n, at.GAP])
            self._laws(m, n)
            for column, value in measured.items():
                kinematics[n, column] = value
        for place in range(at.NORMAL, at.STORE + 1):
            kinematics[n, place] = select(shut, kinematics[n, place], 0.0)
        for state in states:
            m.element_rate[state] = select(shut, m.element_rate[state], 0.0)
        for row in np.ndindex(m.force.shape):
            if m.force[row] is not before[row]:
                m.force[row] = select(shut, m.force[row], before[row])

    def _seat(self, m: SimpleNamespace, n: int) -> None:
        """Put the pawl of contact n behind its tooth, which is a memory of the kernels."""
        assert self.switches is not None, "it is recorded for lanes"
        p = self.table[n, at.SHAPE_P]
        pitch, gap = m.values[p + at.PITCH], m.contact_kinematics[n, at.GAP]
        m.contact_kinematics[n, at.GAP] = pitch * self.switches.from_tooth(n, gap / pitch - m.values[p + at.TOOTH])

    def _said(self, kernel: Plain, what: str) -> Plain:
        """A kernel of a contact (m, n, ...) that says of which one it cannot be recorded."""

        def call(m: SimpleNamespace, n: int, *more: object) -> None:
            try:
                kernel(m, n, *more)
            except TraceError:
                raise TraceError(
                    f"{what} of the contacts in {self.joints[n]} branches, which straight-line code cannot follow"
                ) from None

        return call

    def _hold(self, m: SimpleNamespace) -> None:
        assert self._rigid is not None, "there are some"
        self._rigid.hold(m)

    def struck(self, m: SimpleNamespace, y: np.ndarray) -> Struck:
        """What becomes of the state y (ny,) at the end of a step: what contacts without force have stored is lost,
        rigid ones hit, or their modes are looked for."""
        if self._rigid is not None and m.massless.shape[0]:
            raise TraceError("impacts beside bodies without mass cannot be straight-line code")
        state = y.copy()
        for n in np.flatnonzero(~self.rigid).tolist():
            account = self._copies.of(account_at.python)(m, n)
            kept, lost = state[account + STORED], state[account + LOSS]
            held: Operand = 0.0
            if self.table[n, at.BY_FORCE]:  # until its gap opens; one that pushes again has what its spring holds then
                again = (self.shut[n] > SHUT) & (self.shut[n] < PRESSED)
                held = select(self.shut[n] > PRESSED, kept, select(again, self.strain(m, n), 0.0))
            keeps = apply("equal", self.shut[n], SHUT)
            state[account + LOSS] = select(keeps, lost, lost + (kept - held))
            state[account + STORED] = select(keeps, kept, held)
            first = self._copies.of(states_at.python)(m) + self.table[n, at.FIRST_STATE]
            for k in range(first, first + self.table[n, at.STATES]):
                state[k] = select(self.is_shut[n], state[k], 0.0)
        if self._rigid is not None:
            return self._rigid.struck(m, state)
        if self.rubbing is not None:
            self.rubbing.rest(m, state)
        rubs: list[Operand] = [] if self.rubbing is None else list(self.rubbing.modes.values())
        return Struck(list(state), {}, {}, {}, True, rubs, [False] * len(rubs), 1.0)

    def push(self, m: SimpleNamespace, n: int) -> Operand:
        """Force [N] of contact n that ends by it, also where it would pull; see `compliant.push`."""
        row = m.contact_kinematics[n]
        force: Operand = self._copies.of(compliant.push.python)(m, n, _depth(row[at.GAP]), row[at.DGAP])[1]
        return Symbol(force.graph, force.place) if isinstance(force, Symbol) else force

    def most(self, m: SimpleNamespace, n: int) -> Operand:
        """Largest torque of a clutch [N m]."""
        torque: Operand = self._copies.of(most_torque.python)(m, n)
        return torque

    def strain(self, m: SimpleNamespace, n: int) -> Operand:
        """Energy [J] of contact n at its depth, as `contact_events.strain_energy`; 0 of rigid ones and clutches."""
        if self.rigid[n] or self.table[n, at.LEVEL]:
            return 0.0
        gap = m.contact_kinematics[n, at.GAP]
        depth = select(gap < 0.0, -gap, APART)
        law, p = m.stiffness_table[self.table[n, at.STATIC]], self.table[n, at.STATIC_P]
        shares = (0.5 * (1.0 + GAUSS)).tolist()
        total = summed(
            w * s * _positive_force(law, (positive(depth * (s * s)), m.values, p))
            for s, w in zip(shares, WEIGHTS.tolist(), strict=True)
        )
        return select(gap < 0.0, depth * total, 0.0)

    def bends(self, m: SimpleNamespace) -> dict[int, Operand]:
        """g'' of rigid contacts [m/s^2 or rad/s^2] at the accelerations in m."""
        return {} if self._rigid is None else self._rigid.bends(m)[0]

    def parting(self, m: SimpleNamespace, n: int) -> Operand:
        """Rate of the rate of clutch n [rad/s^2] at the accelerations in m."""
        a, b = self.table[n, at.A_BODY], self.table[n, at.B_BODY]
        change: Operand = -m.contact_kinematics[n, at.TURN] * (m.acceleration[b, 2] - m.acceleration[a, 2])
        return change

    def faint(self, m: SimpleNamespace, n: int) -> tuple[Operand, Operand]:
        """g'' of a rigid contact, and its force, that may be rounding; see `RigidContacts`."""
        assert self._rigid is not None, "it is one"
        return self._rigid.faint(m, n)

    def calm(self, m: SimpleNamespace, n: int, rate: Operand) -> Operand:
        """A rate of contact n, 0 where it may be rounding."""
        return select(abs(rate) <= self.slow(m, n), 0.0, rate)

    def slow(self, m: SimpleNamespace, n: int) -> Operand:
        """A rate of contact n that may be rounding [m/s or rad/s]."""
        slow: Operand = REST + self._copies.of(rate_rounding.python)(m, n)
        return slow

    def faint_clutch(self, m: SimpleNamespace, n: int) -> Operand:
        """What may be rounding of a clutch without impacts: shut, its torque [N m]; open, its rate [rad/s]."""
        rate, p = self.slow(m, n), self.table[n, at.NORMAL_P]
        return select(self.is_shut[n], (m.values[p + at.OIL] + m.values[p + at.WIND_UP]) * rate, rate)

    def friction(self, m: SimpleNamespace, n: int) -> Operand:
        """mu of a rigid contact."""
        mu: Operand = m.values[self.table[n, at.NORMAL_P] + at.MU]
        return mu

    def lasting(self, m: SimpleNamespace) -> list[Operand]:
        """How long contacts that have just begun will last about [s], as `compliant.contact_duration`; 0: unknown."""
        return [0.0 if rigid else self._lasting(m, n) for n, rigid in enumerate(self.rigid)]

    def _lasting(self, m: SimpleNamespace, n: int) -> Operand:
        q = 2 if m.lever[n, at.ANGULAR] > 0.0 else 0
        masses = [m.mass[m.contact[n, end], q] for end in (at.A_BODY, at.B_BODY)]
        light: Operand = 0.0
        for mass in masses:  # 0 of the ground
            light = mass if _is_zero(light) else light if _is_zero(mass) else select(mass < light, mass, light)
        if self.table[n, at.LEVEL]:
            return 0.0
        law, p, speed = m.stiffness_table[m.contact[n, at.STATIC]], m.contact[n, at.STATIC_P], self.speed[n]
        depth: Operand = FIRST_DEPTH
        for _ in range(ROUNDS):
            force = _positive_force(law, (positive(depth), m.values, p))
            doublings = self.graph.apply("exponent", light * speed * speed / (force * depth))
            depth = depth * self.graph.apply("power_of_two", self.graph.apply("floor", SHARE_OF_DOUBLINGS * doublings))
        return select(speed > 0.0, 3.0 * depth / speed, 0.0)


def _is_zero(x: Operand) -> bool:
    return not isinstance(x, Symbol) and symbol_of(x) == 0.0


def _depth(gap: Symbol) -> Symbol:
    """A gap of a contact that is computed by its laws, on both sides of its end."""
    return Depth(gap.graph, gap.place)


def _positive_force(entry: Plain, arguments: tuple[object, ...]) -> Operand:
    """What stands for calls of laws whose force is positive where it counts."""
    return positive(entry(*arguments))
