"""The recorded contacts of a model and its joints that rub, with derivatives by parameters: gaps, forces, impacts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rattle.analyses.straight_line.linearised import Linearised
from rattle.analyses.straight_line.recorded_model import ContactFunctions
from rattle.questions.sensitivity.functions import Functions
from rattle.questions.sensitivity.rubbing import Rubbed, Rubbing
from rattle.trace.lane_program import Compile


@dataclass
class Watched:
    """Gaps of all contacts, their rates and forces (n,), with derivatives by parameters (n, k) and along the motion.

    After them, joints that rub: what is left of their modes as gap, how that changes as rate.
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


class Touching:
    """The recorded contacts of a model, and its joints that rub after them, with their derivatives, and their present
    state."""

    def __init__(self, functions: Functions, contacts: ContactFunctions, compile_function: Compile) -> None:
        self.functions, self.are, self.count = functions, contacts.are, contacts.count
        self.contacts = len(self.are)
        graph, rubs = functions.model.graph, contacts.rubbing
        self.rubbing = None if rubs is None else Rubbing(functions, rubs, compile_function)
        joints = [] if self.are.rubbing is None else [self.are.rubbing.joints[n] for n in self.are.rubbing.rubs]
        self.joints = (*self.are.joints, *joints)
        self.rigid, self.by_force = (
            np.append(x, np.zeros(len(joints), dtype=bool)) for x in (self.are.rigid, self.are.by_force)
        )
        self._watch = Linearised(graph, [*contacts.gap, *contacts.rate, *contacts.normal], compile_function)
        self._impacts = {
            n: [Linearised(graph, [*way.state, way.possible], compile_function) for way in ways]
            for n, ways in contacts.impacts.items()
        }
        self.shut = np.zeros(self.count, dtype=bool)
        self.released = np.zeros(self.count, dtype=bool)  # without force, but not apart yet
        self.begin()

    def begin(self) -> None:
        """Let all contacts be open, as at the start of a motion."""
        self.shut[:] = self.released[:] = False
        if self.rubbing is not None:
            self.rubbing.modes[:] = 0.0
        self._let_rest()

    def set(self, n: int, shut: bool, speed: float = 0.0, by_speed: np.ndarray | None = None) -> None:
        """Let contact n be shut or open from now on."""
        self.shut[n] = shut
        self._tell(n, shut, speed, by_speed)
        self._let_rest()

    def rub(self, modes: np.ndarray) -> None:
        """Let joints that rub have these modes from now on."""
        assert self.rubbing is not None, "some rub"
        self.rubbing.modes = modes
        for place, mode in enumerate(modes.tolist()):
            self._tell(self.contacts + place, True, mode)

    def _tell(self, n: int, shut: bool, speed: float, by_speed: np.ndarray | None = None) -> None:
        """Set the constants of contact n."""
        parameters, count = self.functions.parameters, self.count
        constants, rates = parameters.constants.copy(), parameters.constant_rates.copy()
        constants[len(constants) - 2 * count + n] = float(shut)
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
        gap, speed, normal = values.reshape(3, -1)
        by_gap, by_rate, by_normal = slopes.reshape(3, len(gap), at[1].shape[1])
        seen = Watched(
            gap, speed, normal, by_gap[:, :-1], by_rate[:, :-1], by_normal[:, :-1], by_rate[:, -1], by_normal[:, -1]
        )
        return seen if self.rubbing is None else _with_rubbed(seen, self.rubbing.seen(t, z, rate))

    def impact(
        self, n: int, t: float, z: np.ndarray, rate: np.ndarray, rebounds: bool = True
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """z (ny, 1 + k) after an impact of contact n, and how y after it changes along the motion before (ny,).

        None if none of its ways is possible, or several that differ.  rebounds: False for the last one of a contact
        that stays shut.
        """
        x, along = self.functions.directions(t, z, rate)
        ways, possible = self._impacts[n], []
        if self.are.lasts[n]:
            ways = ways[:1] if rebounds else ways[1:]
        for way in ways:
            values, slopes = way(x, along)
            if values[-1] == 1.0:
                possible.append((np.column_stack([values[:-1], slopes[:-1, :-1]]), slopes[:-1, -1]))
        return possible[0] if len(possible) == 1 else None


def _with_rubbed(seen: Watched, rubbed: Rubbed) -> Watched:
    """Contacts, and joints that rub after them."""
    none, nones = (np.full(x.shape, np.nan) for x in (rubbed.left, rubbed.by_left))
    return Watched(
        np.concatenate([seen.gap, rubbed.left]), np.concatenate([seen.rate, rubbed.left_in_time]),
        np.concatenate([seen.normal, none]), np.concatenate([seen.by_gap, rubbed.by_left]),
        np.concatenate([seen.by_rate, nones]), np.concatenate([seen.by_normal, nones]),
        np.concatenate([seen.rate_in_time, none]), np.concatenate([seen.normal_in_time, none]), rubbed,
    )  # fmt: skip
