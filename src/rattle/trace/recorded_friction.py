"""Friction of joints without play in a recorded model: its forces in given modes, and whether these can last.

Equations: `rattle.equations.dry_friction`.  In which sense a joint with set-valued friction slips (1 or -1), that it
sticks (0), or that it rests at its limit, of mu_static, as others hold it that stick (2 or -2), is an input of the
graph.  The forces of all joints follow from so many steps of Newton's method; that these have converged, and that
friction does not lock, is a guard.

Beside rigid contacts tau is linearised in their forces f at an estimate of both, tau = C + D f, as in
`solvers.nonsmooth.rubbing_contacts`; so are the impulses of friction in an impact, as in `rubbing_impacts`.
"""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np

from rattle.equations import dry_friction as dry
from rattle.equations.dependent_rows import fixed_value
from rattle.equations.system import System
from rattle.errors import TraceError
from rattle.jit import layout as at
from rattle.jit.choices import assume
from rattle.language.recorded import Flag, Operand
from rattle.solvers.dry_friction_modes import OVER, TAKEN, driven_ahead, sudden
from rattle.trace.graph import Graph, Symbol, apply, select, summed
from rattle.trace.known_signs import positive
from rattle.trace.recorded_language import Copies
from rattle.trace.recorded_modes import add

FIRM = 2.0  # size of a mode: it rests at its limit
ROUNDS = 6  # of Newton's method
CONVERGED = 1e-10  # share of all forces by which its last step may change them
MOST = 8  # joints with friction
MOST_BESIDE = 4  # of them beside rigid contacts
BEYOND = 1e-10  # share by which a condition of an impact may be violated by rounding
LASTING, HIT, KEPT = range(3)  # what forces of contacts are: such that last, of an impact, what takes rates away
FIXED = 1e-11  # share of the mobility without joints that is left where these fix a coordinate
FAINT = 1e-12  # share of its terms by which a force may be rounding
NO_RATE, NO_FORCE = 1e-12, 1e-9  # of an acceleration, by those of bodies and by that which friction causes


class Joint(NamedTuple):
    """A joint with set-valued friction at one instant; `reserve` is above zero while its mode lasts."""

    reserve: Operand  # limit less |tau| [N or N m], or its rate in the sense in which it slips [m/s or rad/s]
    slack: Operand  # of that, what may be rounding
    rate: Operand  # [m/s or rad/s], 0 where it may be rounding
    force: Operand  # tau [N or N m]
    ahead: Operand  # acceleration against that of sticking, 0 where it may be rounding or friction takes care of it
    stuck: Operand  # 1 if it can move only as long as others do that stick


class Pull(NamedTuple):
    """What a unit force of a contact does to all joints."""

    rates: list[Operand]  # change of their rates, or accelerations
    borne: list[tuple[Operand, Operand]]  # of what they bear


class Free(NamedTuple):
    """Joints without friction: accelerations against those of sticking, or rates; what they bear."""

    rates: list[Operand]
    bears: list[tuple[Operand, Operand]]


class Shares(NamedTuple):
    """Friction of all joints, linear in the forces of contacts."""

    alone: list[Operand]
    by: list[list[Operand]]  # of each joint, per unit of each force
    definite: Flag  # it does not lock


class RecordedFriction:
    """That of the joints of a system, nd of them, on symbols of one graph."""

    def __init__(self, graph: Graph, system: System, modes: bool, slopes: bool) -> None:
        """modes: set-valued friction may be recorded, with modes as inputs; slopes: it is differentiated.

        Raises TraceError for friction that cannot be recorded so.
        """
        self.graph, self.slopes, self.table = graph, slopes, system.arrays["dry"]
        self.joints = system.dry_joints
        self.rubs = np.flatnonzero(self.table[:, at.DRY_LAW] < 0).tolist()  # those with set-valued friction
        self.takes_part = bool((self.table[self.rubs, at.DRY_STATED] == 0).any())  # in impacts: what is finite does not
        self.modes: dict[int, Operand] = {}
        self.off: list[Operand] = [0.0] * len(self.table)  # by which rates differ from those that contacts allow
        self._require_able(system, modes)

    def _require_able(self, system: System, modes: bool) -> None:
        joints, contact = ", ".join(system.rough_joints), system.arrays["contact"]
        if self.rubs and not modes:
            raise TraceError(f"dry friction sticks and slips, which straight-line code cannot follow (joints {joints})")
        if len(self.table) > MOST:
            raise TraceError(f"more than {MOST} joints with friction ({joints}) cannot be straight-line code")
        for joint, entry in zip(self.joints, self.table, strict=True):
            states = bool(entry[at.DRY_STATES]) and not modes
            what = "with states" if states else "of discs" if entry[at.DRY_FORM] == at.DRY_ROLLER else ""
            if what:
                raise TraceError(f"friction {what} (joint {joint}) cannot be straight-line code")
        if (contact[:, at.IMPACT] == 1).any() and len(self.table) > MOST_BESIDE:
            raise TraceError(
                f"more than {MOST_BESIDE} joints with friction ({joints}) beside rigid contacts cannot be"
                " straight-line code"
            )
        if len(system.arrays["massless"]):
            raise TraceError(f"friction beside bodies without mass cannot be straight-line code (joints {joints})")

    def begin(self, copies: Copies) -> None:
        """Let friction be recorded; before any kernel is."""
        self._copies = copies
        self._resistance = copies.of(dry.resistance.python)
        copies.replace(dry.resistance.python, self._resist)
        copies.replace(dry.hold.python, self._hold)
        copies.replace(dry.add_dry_friction.python, self._add)
        copies.replace(dry.end_dry_friction.python, self._end)

    def _resist(self, m: SimpleNamespace, n: int, normal: Operand) -> Operand:
        """Stands for `dry_friction.resistance`: laws want normal forces above zero."""
        force: Operand = self._resistance(m, n, positive(normal))
        return force

    def _hold(self, m: SimpleNamespace, n: int, free: Operand) -> None:
        """Stands for `dry_friction.hold`."""
        held: Flag = self._copies.of(dry.mobility.python)(m, n, n) <= FIXED * free
        told = m.dry_memory[n, at.DRY_HELD] = select(hidden(held), 1.0, 0.0)
        for flag in (told > 0.5, told < 0.5):  # at a dead centre, as a motion passes it
            hidden(flag)
        for c, x in enumerate(m.dry_response[n]):  # next to a dead centre it is small, but its slopes are not
            m.dry_response[n, c] = x if self.slopes else select(held, 0.0, x)

    def _add(self, m: SimpleNamespace) -> None:
        """Stands for `dry_friction.add_dry_friction`: beside rigid contacts these add it, with their own forces."""
        self._copies.of(dry.prepare_rows.python)(m)
        if len(m.closed_contacts_table) > 0:
            return
        free, tau = self.free(m), list[Operand]([0.0] * len(self.table))
        converged: Flag = True
        first, before = len(self.graph), tau
        for _ in range(ROUNDS):
            before, (tau, converged) = tau, self.improved(self.shares(m, free, [], tau, [], LASTING), [], tau)
        self.leave_out(range(first, len(self.graph)), tau, before)
        self._copies.of(assume.python)(converged)
        self.spread(m, tau)

    def leave_out(self, rounds: range, forces: Sequence[Operand], before: Sequence[Operand]) -> None:
        """Note what only rounds before the last one have done: on which side of a switch an estimate is does not show.

        forces: of the last round; before: of the one before it.
        """
        told = {self.graph.place(x) for x in before if isinstance(x, Symbol)}
        ahead = [self.graph.place(x) for x in forces if isinstance(x, Symbol)]
        while ahead:
            place = ahead.pop()
            if place not in told:
                told.add(place)
                ahead += self.graph.operands[place]
        self.graph.estimates |= set(rounds) - told

    def free(self, m: SimpleNamespace) -> Free:
        """Of joints at the accelerations and multipliers in m, without friction."""
        along, bearing = (self._copies.of(f.python) for f in (dry.along, dry.bearing))
        numbers = range(len(self.table))
        return Free(
            [along(m, n, m.acceleration, 0) - m.dry_rows[n, at.GAMMA] for n in numbers],
            [bearing(m, n, m.multiplier, at.DRY_ADDED) for n in numbers],
        )

    def before(self, m: SimpleNamespace) -> Free:
        """Of joints before an impact."""
        numbers = range(len(self.table))
        return Free([m.dry_memory[n, at.DRY_RATE] for n in numbers], [(0.0, 0.0) for _ in numbers])

    def pull(self, m: SimpleNamespace, away: np.ndarray, reaction: np.ndarray) -> Pull:
        """What a unit force of a contact does that changes rates (nb + 1, 3) and multipliers so."""
        along, rates, borne = self._copies.of(dry.along.python), [], []
        for n, entry in enumerate(self.table):
            rates.append(along(m, n, away, 0))
            second = 0.0 if entry[at.DRY_FORM] == at.DRY_ROD else reaction[entry[at.DRY_SECOND]]
            borne.append((reaction[entry[at.DRY_ROW]], second))
        return Pull(rates, borne)

    def shares(
        self, m: SimpleNamespace, free: Free, pulls: Sequence[Pull], tau: Sequence[Operand], forces: Sequence[Operand],
        what: int,
    ) -> Shares:  # fmt: skip
        """Friction of all joints, linearised at an estimate of it and of the forces of contacts.

        what: LASTING, HIT, KEPT, the last two with impulses for forces.
        """
        numbers = range(len(self.table))
        rows = []
        for n in numbers:
            row = self._slipping(m, n, free, pulls, tau, forces, what)
            if n in self.modes:
                sticks = self._sticks(m, n)
                row = [select(sticks, a, b) for a, b in zip(self._stuck(m, n, free, pulls, what), row, strict=True)]
            rows.append(row)
        results, definite = _eliminated(rows, [self._doubt(m, n) for n in numbers])
        return Shares(results[0], [[result[n] for result in results[1:]] for n in numbers], definite)

    @staticmethod
    def improved(shares: Shares, forces: Sequence[Operand], tau: Sequence[Operand]) -> tuple[list[Operand], Flag]:
        """tau by its shares and the forces of contacts; whether it stays the same, and friction does not lock."""
        terms = [
            [alone, *(by * f for by, f in zip(each, forces, strict=True))]
            for alone, each in zip(shares.alone, shares.by, strict=True)
        ]
        new = [x[0] + summed(x[1:]) for x in terms]
        change = summed(abs(x - y) for x, y in zip(new, tau, strict=True))
        rounded = FAINT * summed(abs(x) for each in terms if len(each) > 1 for x in each)
        return new, (change <= CONVERGED * summed(abs(x) for x in new) + rounded) & shares.definite

    def _slipping(
        self, m: SimpleNamespace, n: int, free: Free, pulls: Sequence[Pull], tau: Sequence[Operand],
        forces: Sequence[Operand], what: int,
    ) -> list[Operand]:  # fmt: skip
        """Row of the equations of tau of a joint that slips: its factors, its value without forces, per unit of each.

        In an impact what has a stated size, or a law, has no impulse; what takes rates away that are next to nothing
        leaves those that slip alone.
        """
        own = [1.0 if n == o else 0.0 for o in range(len(self.table))]
        if what == KEPT or (what == HIT and (n not in self.modes or self.table[n, at.DRY_STATED])):
            return [*own, 0.0, *(0.0 for _ in pulls)]
        borne = self._copies.of(dry.borne.python)
        parts = [(borne(m, n, o), x) for o, x in enumerate(tau)]
        parts += [(pull.borne[n], f) for pull, f in zip(pulls, forces, strict=True)]
        more = [summed(by[k] * x for by, x in parts) for k in range(2)]
        first, second = (bears + x for bears, x in zip(free.bears[n], more, strict=True))
        size, slope, slope2 = self._resisting(m, n, first, second)
        sense = self._sense(n)
        by = [sense * (slope * a + slope2 * b) for (a, b), _ in parts]
        row = [x - y for x, y in zip(own, by, strict=False)]
        return [*row, sense * (size - slope * more[0] - slope2 * more[1]), *by[len(own) :]]

    def _resisting(self, m: SimpleNamespace, n: int, first: Operand, second: Operand) -> tuple[Operand, ...]:
        """As `dry_friction.resisting`, with mu_static of a joint that rests at its limit."""
        if n not in self.modes:
            slopes: tuple[Operand, ...] = self._copies.of(dry.resisting.python)(m, n, first, second)
            return slopes
        p = self.table[n, at.DRY_P]
        mu = select(abs(self.modes[n]) > FIRM - 0.5, m.values[p + at.DRY_MU_STATIC], m.values[p + at.DRY_MU])
        return tuple(
            mu * m.values[p + at.DRY_ARM] * x for x in self._copies.of(dry.pressing.python)(m, n, first, second)
        )

    def _stuck(self, m: SimpleNamespace, n: int, free: Free, pulls: Sequence[Pull], what: int) -> list[Operand]:
        """Row of the equations of a joint that sticks: what others move it by, what it moves by without friction and
        per unit of each force, by its own mobility; of one that others hold tau = 0."""
        mobility = self._copies.of(dry.mobility.python)
        held = m.dry_memory[n, at.DRY_HELD] > 0.5
        own = select(held, 1.0, mobility(m, n, n))
        row = [1.0 if n == o else select(held, 0.0, mobility(m, n, o) / own) for o in range(len(self.table))]
        if what == HIT and self.table[n, at.DRY_STATED]:
            return [*(1.0 if n == o else 0.0 for o in range(len(self.table))), 0.0, *(0.0 for _ in pulls)]
        moves = [free.rates[n], *(pull.rates[n] for pull in pulls)]
        return [*row, *(select(held, 0.0, -x / own) for x in moves)]

    def _doubt(self, m: SimpleNamespace, n: int) -> Operand:
        """How much less exactly than rounding the row of a joint that sticks is known, see `dry_friction.eliminate`."""
        if n not in self.modes:
            return 1.0
        free: Operand = 0.0
        for body, first in ((self.table[n, at.DRY_A], at.AX), (self.table[n, at.DRY_B], at.BX)):
            free = free + summed(m.weight[body, k] * m.dry_rows[n, first + k] ** 2 for k in range(3))
        sticks = self._sticks(m, n) & (m.dry_memory[n, at.DRY_HELD] < 0.5)
        doubt = dry.LOST * free / select(sticks, self._copies.of(dry.mobility.python)(m, n, n), 1.0)
        return select(sticks & hidden(doubt > 1.0), doubt, 1.0)

    def _sticks(self, m: SimpleNamespace, n: int) -> Flag:
        return (abs(self.modes[n]) < 0.5) & self._rough(m, n)

    def _rough(self, m: SimpleNamespace, n: int) -> Flag:
        """Whether it can bear any friction at all."""
        rough: Flag = m.values[self.table[n, at.DRY_P] + at.DRY_MU_STATIC] > 0.0
        return rough

    def _sense(self, n: int) -> Operand:
        """As `dry_friction.sense_of`."""
        if n not in self.modes:
            return -1.0
        return select(self.modes[n] > 0.5, -1.0, select(self.modes[n] < -0.5, 1.0, 0.0))

    def _end(self, m: SimpleNamespace) -> None:
        """Stands for `dry_friction.end_dry_friction`."""
        for n in range(len(self.table)):
            lost = m.dry_memory[n, at.DRY_FORCE] * m.dry_memory[n, at.DRY_RATE]
            m.power[at.LOSS_RATE] = m.power[at.LOSS_RATE] - lost
            if self.table[n, at.DRY_STATES]:  # their rates are those of the forces that came out
                bears = self._copies.of(dry.bearing.python)(m, n, m.multiplier, at.DRY_FORCE)
                self._resist(m, n, self._copies.of(dry.pressing.python)(m, n, *bears)[0])

    @staticmethod
    def spread(m: SimpleNamespace, forces: Sequence[Operand]) -> None:
        """Note the forces of joints, and add what they do to accelerations and multipliers."""
        for n, tau in enumerate(forces):
            m.dry_memory[n, at.DRY_FORCE] = m.dry_memory[n, at.DRY_ADDED] = tau
            add(m.acceleration[1:], away(m, n)[1:], tau)
            add(m.multiplier, m.dry_reaction[n], tau)

    # ---------------------------------------------------------------- impacts
    def gains(self, m: SimpleNamespace, n: int, tau: Sequence[Operand]) -> Operand:
        """Change of the rate of joint n by the friction of all."""
        mobility = self._copies.of(dry.mobility.python)
        return summed(mobility(m, n, o) * x for o, x in enumerate(tau))

    def after_impact(
        self, m: SimpleNamespace, pulls: Sequence[Pull], tau: Sequence[Operand], forces: Sequence[Operand]
    ) -> tuple[list[Operand], Flag]:
        """Modes to try next of joints with set-valued friction, and a flag: those at hand agree with the impulses.

        As `rubbing_impacts.change_rubbing`: the one changes that violates Coulomb's law most.
        """
        beyond, turned = dict[int, Operand](), dict[int, Operand]()
        worst: Operand = 0.0
        for n in self.rubs:
            beyond[n], turned[n] = self._violation(m, n, pulls, tau, forces)
            worst = select(beyond[n] > worst, beyond[n], worst)
        changes = {n: (x > BEYOND) & (x >= worst) for n, x in beyond.items()}
        return [select(changes[n], turned[n], self.modes[n]) for n in self.rubs], worst <= BEYOND

    def _violation(
        self, m: SimpleNamespace, n: int, pulls: Sequence[Pull], tau: Sequence[Operand], forces: Sequence[Operand]
    ) -> tuple[Operand, Operand]:
        """How far an impact violates the mode of joint n, as a share, and the mode that takes its place."""
        if self.table[n, at.DRY_STATED]:
            return 0.0, self.modes[n]
        borne, mobility, p = self._copies.of(dry.borne.python), self._copies.of(dry.mobility.python), at.DRY_P
        parts = [(borne(m, n, o), x) for o, x in enumerate(tau)]
        parts += [(pull.borne[n], f) for pull, f in zip(pulls, forces, strict=True)]
        pressing = self._copies.of(dry.pressing.python)
        bears, _, _ = pressing(m, n, *(summed(by[k] * x for by, x in parts) for k in range(2)))
        first = self.table[n, p]
        most, size = m.values[first + at.DRY_MU] * m.values[first + at.DRY_ARM] * bears, abs(tau[n])
        stuck = select(size > 0.0, (size - most) / select(size > 0.0, size + most, 1.0), 0.0)
        mode, rate = self.modes[n], m.dry_memory[n, at.DRY_RATE]
        terms = [rate, *(mobility(m, n, o) * x for o, x in enumerate(tau))]
        terms += [pull.rates[n] * f for pull, f in zip(pulls, forces, strict=True)]
        after, scale = summed(terms), summed(abs(x) for x in terms)
        back = select(scale > 0.0, -mode * after / select(scale > 0.0, scale, 1.0), 0.0)
        backwards = mode * rate > self._copies.of(dry.rounding.python)(m, n)  # it may bounce back before it sticks
        sticks = abs(mode) < 0.5
        turned = select(sticks, select(tau[n] > 0.0, -1.0, 1.0), select(backwards, -mode, 0.0))
        return select(self.is_open(m, n), select(sticks, stuck, back), 0.0), turned

    def is_open(self, m: SimpleNamespace, n: int) -> Flag:
        """Whether joint n may stick or slip either way, as `rubbing_impacts.is_open`."""
        free: Flag = m.dry_memory[n, at.DRY_HELD] < 0.5
        return free & self._rough(m, n)

    def mean_rate(self, m: SimpleNamespace, n: int, moved: np.ndarray) -> Operand:
        """Rate of joint n, in the mean of before and after an impact that changes rates (nb + 1, 3) so."""
        gained: Operand = self._copies.of(dry.along.python)(m, n, moved, 0)
        rate: Operand = m.dry_memory[n, at.DRY_RATE] + 0.5 * gained
        return rate

    # ---------------------------------------------------------------- modes
    def at(self, m: SimpleNamespace) -> list[Joint]:
        """Joints with set-valued friction, at a state for which the equations of motion stand in m."""
        return [self._joint(m, n, held) for n, held in zip(self.rubs, self._held_by_others(m), strict=True)]

    def _joint(self, m: SimpleNamespace, n: int, by_others: Operand) -> Joint:
        memory, calls = m.dry_memory, self._copies.of
        held, tau, rate = memory[n, at.DRY_HELD] > 0.5, memory[n, at.DRY_FORCE], memory[n, at.DRY_RATE]
        slight, limit = calls(dry.rounding.python)(m, n), calls(dry.limit.python)(m, n)
        # what drivers hold goes as they do: where they rest its own rate is rounding
        rate = select(held & self._sticks(m, n), calls(fixed_value.python)(m, m.dry_reaction, n, at.NU), rate)
        rate = rate + self.off[n]
        rate = select(abs(rate) <= slight, 0.0, rate)
        kept = select(held, select(apply("equal", rate, 0.0), 1.0, -1.0), limit - abs(tau))
        ahead = calls(sudden.python)(m, n)
        terms = abs(m.dry_rows[n, at.GAMMA])
        a, b = self.table[n, at.DRY_A], self.table[n, at.DRY_B]
        for k in range(3):
            terms = terms + abs(m.dry_rows[n, at.AX + k] * m.acceleration[a, k])
            terms = terms + abs(m.dry_rows[n, at.BX + k] * m.acceleration[b, k])
        caused = summed(
            abs(calls(dry.mobility.python)(m, n, o) * memory[o, at.DRY_FORCE]) for o in range(len(self.table))
        )
        rounded = (abs(ahead) <= NO_RATE * terms + NO_FORCE * caused) | self._sticks(m, n)
        ahead = select(held, calls(driven_ahead.python)(m, n), select(rounded, 0.0, ahead))
        return Joint(
            select(self._rough(m, n), select(self._sticks(m, n), kept, -self._sense(n) * rate), 1.0),
            select(self._sticks(m, n), FAINT * (limit + abs(tau)), slight), rate, tau, ahead,
            by_others,
        )  # fmt: skip

    def left(self, m: SimpleNamespace) -> list[Operand]:
        """What is above zero while modes last, as `Joint.reserve`, but with all its digits."""
        left = []
        for n in self.rubs:
            tau, rate = (m.dry_memory[n, column] for column in (at.DRY_FORCE, at.DRY_RATE))
            sticks = self._sticks(m, n) & (m.dry_memory[n, at.DRY_HELD] < 0.5)
            kept = self._copies.of(dry.limit.python)(m, n) - abs(tau)
            left.append(select(self._rough(m, n), select(sticks, kept, -self._sense(n) * rate), 1.0))
        return left

    def rest(self, m: SimpleNamespace, state: np.ndarray) -> None:
        """Take from the rates in a state what is left to joints that stick; see `dry_friction_modes.bring_to_rest`."""
        nq = m.change.shape[0]
        (taken,) = self._taken(m, [[m.dry_memory[n, at.DRY_RATE] for n in range(len(self.table))]])
        for k in range(nq):
            state[nq + k] = state[nq + k] - summed(x * m.dry_response[n, 3 + k] for n, x in enumerate(taken))

    def _taken(self, m: SimpleNamespace, rates: Sequence[Sequence[Operand]]) -> list[list[Operand]]:
        """Impulses of joints that stick which take rates (nd,) from their coordinates, one after the other."""
        numbers, mobility = range(len(self.table)), self._copies.of(dry.mobility.python)
        rows: list[list[Operand]] = []
        for n in numbers:
            row: list[Operand] = [*(1.0 if n == o else 0.0 for o in numbers), *(0.0 for _ in rates)]
            if n in self.modes:
                sticks = self._sticks(m, n) & (m.dry_memory[n, at.DRY_HELD] < 0.5)
                own = select(sticks, mobility(m, n, n), 1.0)
                stuck = [*(mobility(m, n, o) / own for o in numbers), *(each[n] / own for each in rates)]
                row = [select(sticks, a, b) for a, b in zip(stuck, row, strict=True)]
            rows.append(row)
        return _eliminated(rows, [self._doubt(m, n) for n in numbers])[0]

    def _held_by_others(self, m: SimpleNamespace) -> list[Operand]:
        """As `dry_friction_modes.held_by_others` of joints with set-valued friction: 1, or 0, also if drivers do."""
        numbers, mobility = range(len(self.table)), self._copies.of(dry.mobility.python)
        held = []
        for n, by in zip(
            self.rubs, self._taken(m, [[mobility(m, o, n) for o in numbers] for n in self.rubs]), strict=True
        ):
            left = mobility(m, n, n) - summed(mobility(m, n, o) * x for o, x in zip(numbers, by, strict=True))
            driven = m.dry_memory[n, at.DRY_HELD] > 0.5
            held.append(select((left <= TAKEN * mobility(m, n, n)) & apply("not", driven), 1.0, 0.0))
        return held


def away(m: SimpleNamespace, n: int) -> np.ndarray:
    """Change of rates, or accelerations, (nb + 1, 3) per unit friction of joint n."""
    response: np.ndarray = m.dry_response[n].reshape(-1, 3)
    return response


def hidden(flag: Flag) -> Flag:
    """A flag on both sides of which results are the same but for rounding: it is no switch of a motion."""
    if isinstance(flag, Symbol):
        flag.graph.estimates.add(flag.place)
    return flag


def sign(x: Operand) -> Operand:
    """1, 0 or -1."""
    return select(x > 0.0, 1.0, select(x < 0.0, -1.0, 0.0))


def ended(mode: Operand, joint: Joint) -> Operand:
    """The mode that a joint tries first once its own has ended: it sticks, or breaks away as its force held it."""
    breaks = select(apply("equal", joint.force, 0.0), sign(joint.ahead), -FIRM * sign(joint.force))
    return select(apply("equal", mode, 0.0), breaks, 0.0)


def settled(modes: Sequence[Operand], joints: Sequence[Joint]) -> list[Operand]:
    """The modes to which the forces at an instant lead joints that rub; the same ones if these can last.

    Where one has come to rest it sticks, first; where others move it on, it slips as they do.  Of those that cannot
    bear that the one that is farthest beyond rests at its limit, and slips if no others hold it that stick.
    """
    far = [
        select(apply("equal", mode, 0.0), beyond(joint.reserve, joint.force), 0.0)
        for mode, joint in zip(modes, joints, strict=True)
    ]
    worst: Operand = 0.0
    for x in far:
        worst = select(x > worst, x, worst)
    return [_settled(mode, joint, (x > 0.0) & (x >= worst)) for mode, joint, x in zip(modes, joints, far, strict=True)]


def _settled(mode: Operand, joint: Joint, over: Flag) -> Operand:
    """Of one joint; over: it is the one that is farthest beyond its limit."""
    ahead, rests = sign(joint.ahead), apply("equal", joint.rate, 0.0)
    stuck = select(apply("equal", ahead, 0.0), select(over, -FIRM * sign(joint.force), 0.0), ahead)
    slips = select((joint.stuck > 0.5) & rests, FIRM * sign(mode), sign(mode))
    back = (mode * joint.rate <= 0.0) & (mode * ahead < 0.0)  # it may have just passed its rest
    return select(apply("equal", mode, 0.0), stuck, select(back, 0.0, slips))


def beyond(limit_left: Operand, force: Operand) -> Operand:
    """How far |force| is above its limit, as in `dry_friction_modes.violation`; 0 if it is not."""
    most = limit_left + abs(force)
    violates = limit_left < -OVER * most
    return select(violates, -limit_left / select(violates, abs(force) + most, 1.0), 0.0)


def _eliminated(rows: list[list[Operand]], doubts: Sequence[Operand]) -> tuple[list[list[Operand]], Flag]:
    """x of rows (A, b, ...) whose diagonals are about one, one for each b, and whether all pivots are positive.

    A coordinate that depends on others that stick needs no friction of its own, as in `dry_friction.eliminate`.
    """
    count = len(rows)
    positive: Flag = True
    rounded: Operand = 1.0
    for k in range(count):
        doubt = select(hidden(doubts[k] > rounded), doubts[k], rounded)
        dependent = hidden(abs(rows[k][k]) <= dry.DEPENDENT * doubt)
        rounded = select(dependent, rounded, doubt)
        rows[k] = [select(dependent, 1.0 if o == k else 0.0, x) for o, x in enumerate(rows[k])]
        positive = positive & (rows[k][k] > 0.0)
        for n in range(k + 1, count):
            share = rows[n][k] / rows[k][k]
            rows[n] = [x if o <= k else x - share * y for o, (x, y) in enumerate(zip(rows[n], rows[k], strict=True))]
    results = []
    for right in range(count, len(rows[0])):
        result: list[Operand] = [0.0] * count
        for k in reversed(range(count)):
            value = rows[k][right] - summed(rows[k][o] * result[o] for o in range(k + 1, count))
            result[k] = value / rows[k][k]
        results.append(result)
    return results, positive
