"""The recorded contacts of a model and its joints that rub, with derivatives by parameters: gaps, forces, impacts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from rattle.analyses.straight_line.linearised import Columns, Linearised
from rattle.analyses.straight_line.recorded_model import ContactFunctions, HeldFunctions
from rattle.equations.state import state_layout
from rattle.jit import layout as at
from rattle.questions.sensitivity.functions import Functions
from rattle.questions.sensitivity.rubbing import Rubbed, Rubbing
from rattle.trace.graph import select
from rattle.trace.lane_program import Compile


@dataclass
class Watched:
    """Gaps of all contacts, their rates and forces (n,), with derivatives by parameters (n, k) and along the motion.

    After them, joints that rub, and rigid contacts with friction once more: what is left of their modes as gap, how
    that changes as rate.
    """

    gap: np.ndarray
    rate: np.ndarray
    normal: np.ndarray
    by_gap: np.ndarray
    by_rate: np.ndarray
    by_normal: np.ndarray
    rate_in_time: np.ndarray  # (n,)
    normal_in_time: np.ndarray
    rubbed: Rubbed | None = None
    slack: np.ndarray | None = None  # (n,) forces of contacts that may be rounding
    slips: np.ndarray | None = None  # of rigid contacts with friction, 0 where it may be rounding


class Blow(NamedTuple):
    """What rigid contacts do at an instant."""

    z: np.ndarray  # (ny, 1 + k) after it
    along: np.ndarray  # (ny,) how y after it changes along the motion before
    shut: dict[int, bool]  # by contact: it lasts
    slide: dict[int, float]  # and slips in this sense; 0: it sticks
    impulse: dict[int, float]  # [N s or N m s]
    sound: float  # 1: there is one solution, 0: none or several; below: too many take part, see `recorded_rigid.Struck`
    agreed: float  # of joints that rub, see there
    rubs: np.ndarray  # (n,) their modes to be tried next in an impact
    free: np.ndarray  # (n,) those that may have any


class Leaving(NamedTuple):
    """A rigid contact without a force."""

    rise: float  # rate of its gap [m/s or rad/s], 0 where it may be rounding
    bend: float  # and of that
    slip: float  # [m/s], likewise

    def low(self, height: float) -> bool:
        """Whether it does not, or rises less than this."""
        return self.rise <= 0.0 or (self.bend < 0.0 and self.rise**2 <= -2.0 * self.bend * height)


def _none(x: np.ndarray, n: int) -> np.ndarray:
    return np.full((n, *x.shape[1:]), np.nan)


class Touching:
    """The recorded contacts of a model, and its joints that rub after them, with their derivatives, and their present
    state."""

    def __init__(self, functions: Functions, contacts: ContactFunctions, compile_function: Compile) -> None:
        self.functions, self.are, self.count = functions, contacts.are, contacts.count
        self.contacts = len(self.are)
        graph, rubs = functions.model.graph, contacts.rubbing
        self.rubbing = None if rubs is None else Rubbing(functions, rubs, compile_function)
        joints = [] if self.are.rubbing is None else [self.are.rubbing.joints[n] for n in self.are.rubbing.rubs]
        self.rough = np.flatnonzero(self.are.rigid & ~self.are.lasts)  # rigid contacts with friction
        self.slides = self.contacts + len(joints)  # the first row of those
        self.rows = self.slides + len(self.rough)
        self.joints = (*self.are.joints, *joints, *(self.are.joints[n] for n in self.rough))
        more = np.zeros(self.rows - self.contacts, dtype=bool)
        self.rigid, self.by_force = np.append(self.are.rigid, more), np.append(self.are.by_force, more)
        self.level = np.append(self.are.table[:, at.LEVEL] == 1, more)  # clutches, which have a rate in place of a gap
        gaps, rates = list(contacts.gap), list(contacts.rate)
        for n in np.flatnonzero(self.level).tolist():
            assert contacts.held is not None, "clutches end where their torque does"
            gaps[n], rates[n] = rates[n], contacts.held.bend[contacts.held.numbers.index(n)]
        watched = [*gaps, *rates, *contacts.normal]
        if contacts.held is not None and self.rigid.any():
            self._hold(contacts.held, compile_function)
            watched += [contacts.reserve[n] for n in self.rough.tolist()]
        self._watch = Linearised(graph, watched, compile_function)
        self._strain = Linearised(graph, contacts.strain, compile_function)
        self.shut = np.zeros(self.rows, dtype=bool)
        self.slide = np.zeros(self.contacts)  # senses in which rigid contacts slip
        self.released = np.zeros(self.rows, dtype=bool)  # without force, but not apart yet
        self.begin()

    def states(self, n: int) -> slice:
        """Places in y of the states of the friction of contact n, which begin with it."""
        table = self.are.table
        first = state_layout(self.functions.model.system).states.start + table[n, at.FIRST_STATE]
        return slice(first, first + table[n, at.STATES])

    def knows_speed(self, n: int) -> bool:
        """Whether the force of contact n depends on the speed at which it began."""
        graph = self.functions.model.graph
        return graph.place(self.are.speed[n]) in graph.live(self.functions.model.derivative[:-1])

    def _hold(self, held: HeldFunctions, compile_function: Compile) -> None:
        """Functions of rigid contacts."""
        self._places = [n for n in held.numbers if n < self.contacts and self.are.rigid[n]]
        struck, graph = held.struck, self.functions.model.graph
        told = [*struck.shut.values(), *struck.slide.values(), *struck.impulse.values(), struck.sound, struck.agreed]
        told += [*struck.rubs, *(select(flag, 1.0, 0.0) for flag in struck.free)]
        self._strike = Linearised(graph, [*struck.state, *told], compile_function)
        rows = [held.numbers.index(n) for n in self._places]
        columns = (held.calm, held.bend, held.faint, held.slip, held.tangent)
        self._ends = Columns(graph, [column[row] for column in columns for row in rows], compile_function)

    def begin(self) -> None:
        """Let all contacts be open, as at the start of a motion."""
        self.shut[:] = self.released[:] = False
        self.slide[:] = 0.0
        if self.rubbing is not None:
            self.rubbing.modes[:] = 0.0
        self._let_rest()

    def set(self, n: int, shut: bool, speed: float = 0.0, by_speed: np.ndarray | None = None) -> None:
        """Let contact n be shut or open; speed: at which it closed [m/s], of a rigid one the sense of its slip."""
        self.shut[n] = shut
        if self.rigid[n]:
            self.slide[n] = speed
        self._tell(n, float(shut), speed, by_speed)
        self._let_rest()

    @property
    def modes(self) -> np.ndarray:
        """What contacts and joints are at present."""
        return np.concatenate([self.shut, self.slide, [] if self.rubbing is None else self.rubbing.modes])

    def rub(self, modes: np.ndarray) -> None:
        """Let joints that rub have these modes from now on."""
        assert self.rubbing is not None, "some rub"
        self.rubbing.modes = modes
        for place, mode in enumerate(modes.tolist()):
            self._tell(self.contacts + place, 1.0, mode)

    def _tell(self, n: int, shut: float, speed: float, by_speed: np.ndarray | None = None) -> None:
        """Set the constants of contact n."""
        parameters, count = self.functions.parameters, self.count
        constants, rates = parameters.constants.copy(), parameters.constant_rates.copy()
        constants[len(constants) - 2 * count + n] = shut
        constants[len(constants) - count + n] = speed
        rates[len(rates) - count + n] = 0.0 if by_speed is None else by_speed
        self.functions.parameters = parameters._replace(constants=constants, constant_rates=rates)

    def _let_rest(self) -> None:
        """Laws of open contacts do not switch."""
        some = np.append(~self.shut[: self.contacts], True)
        self.functions.resting = np.asarray(self.functions.of_contact[some].any(axis=0))

    def watched(self, t: float, z: np.ndarray, rate: np.ndarray) -> Watched:
        """Gaps, rates and forces at t [s] and z; rate: dy/dt (ny,)."""
        at = self.functions.directions(t, z, rate)
        values, slopes = self._watch(*at)
        whole = 3 * self.contacts
        gap, speed, normal = values[:whole].reshape(3, -1)
        by_gap, by_rate, by_normal = slopes[:whole].reshape(3, len(gap), at[1].shape[1])
        seen = Watched(
            gap, speed, normal, by_gap[:, :-1], by_rate[:, :-1], by_normal[:, :-1], by_rate[:, -1], by_normal[:, -1]
        )
        if self.rubbing is not None:
            rubbed = self.rubbing.seen(t, z, rate)
            seen = _followed(seen, rubbed.left, rubbed.by_left, rubbed.left_in_time)
            seen.rubbed = rubbed
        if len(self.rough):
            left, by_left = np.where(self.shut[self.rough], values[whole:], 1.0), slopes[whole:]
            by_left = np.where(self.shut[self.rough, None], by_left, 0.0)
            seen = _followed(seen, left, by_left[:, :-1], by_left[:, -1])
        if self.are.rigid.any():
            _, _, faint, slip, _ = self._at_ends(t, z)
            seen.slack, seen.slips = np.zeros(self.rows), np.zeros(self.rows)
            seen.slack[self._places], seen.slips[self._places] = faint, slip
        return seen

    def strains(self, t: float, z: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """Energies [J] of contacts at their depths (n, 1 + k), with their derivatives by parameters."""
        values, slopes = self._strain(*self.functions.directions(t, z, rate))
        return np.column_stack([values, slopes[:, :-1]])

    def _at_ends(self, t: float, z: np.ndarray) -> np.ndarray:
        """(5, n) of rigid contacts: rise, bend, force that may be rounding, slip, tangential force."""
        return self._ends(self.functions.inputs(t, z[:, 0])[:, None]).reshape(5, -1)

    def leaving(self, t: float, z: np.ndarray) -> dict[int, Leaving]:
        """How rigid contacts leave, which have no forces."""
        rise, bend, _, slip, _ = self._at_ends(t, z).tolist()
        return {n: Leaving(*row) for n, *row in zip(self._places, rise, bend, slip, strict=True)}

    def broken(self, t: float, z: np.ndarray) -> dict[int, float]:
        """The senses in which rigid contacts that stick begin to slip."""
        *_, tangent = self._at_ends(t, z).tolist()
        return {n: 1.0 if force > 0.0 else -1.0 for n, force in zip(self._places, tangent, strict=True)}

    def struck(self, codes: Mapping[int, float], t: float, z: np.ndarray, rate: np.ndarray) -> Blow:
        """What rigid contacts do that hit or decide, codes by contact; rate: dy/dt (ny,) before."""
        before = self.functions.parameters
        for n, code in codes.items():
            self._tell(n, code, float(self.slide[n]))
        values, slopes = self._strike(*self.functions.directions(t, z, rate))
        self.functions.parameters = before
        ny, count = len(z), len(self._places)
        shut, slide, impulse = (
            dict(zip(self._places, row, strict=True)) for row in values[ny : ny + 3 * count].reshape(3, count).tolist()
        )
        sound, agreed, *joints = values[ny + 3 * count :].tolist()
        rubs, free = np.array(joints).reshape(2, -1)
        after = np.column_stack([values[:ny], slopes[:ny, :-1]])
        lasts = {n: x > 0.5 for n, x in shut.items()}
        return Blow(after, slopes[:ny, -1], lasts, slide, impulse, sound, agreed, rubs, free > 0.5)


def _followed(seen: Watched, left: np.ndarray, by_left: np.ndarray, left_in_time: np.ndarray) -> Watched:
    """Contacts, and after them what is left of modes."""
    n = len(left)
    return replace(
        seen, gap=np.concatenate([seen.gap, left]), rate=np.concatenate([seen.rate, left_in_time]),
        normal=np.concatenate([seen.normal, _none(seen.normal, n)]), by_gap=np.concatenate([seen.by_gap, by_left]),
        by_rate=np.concatenate([seen.by_rate, _none(seen.by_rate, n)]),
        by_normal=np.concatenate([seen.by_normal, _none(seen.by_normal, n)]),
        rate_in_time=np.concatenate([seen.rate_in_time, _none(seen.rate_in_time, n)]),
        normal_in_time=np.concatenate([seen.normal_in_time, _none(seen.normal_in_time, n)]),
    )  # fmt: skip
