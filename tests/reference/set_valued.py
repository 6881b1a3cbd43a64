"""Coulomb friction of pins and one-way clutches at one instant: every combination of modes is tried.

A pin that turns has the torque mu R |F| against its turning, F being its own force; one at rest sticks with any
torque up to mu_s R |F|, or begins to turn one way or the other.  A clutch whose driving body would get ahead carries a
torque between 0 and its largest, slips at the largest, and is free where the driven body is ahead.  What joints hold
anyhow has no mode: its torque is not unique and changes no acceleration.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from reference.mechanism import GROUND, Mechanism, solve

STILL = 1e-9  # relative speed [rad/s] below which a pin or clutch is at rest
SLACK = 1e-7  # share of the sizes by which a condition of a mode may be missed
FIXED = 1e-6  # share of a row that joints leave, below which they hold it
MOST_ROUNDS = 400  # of the forces that friction follows


@dataclass(frozen=True)
class Pin:
    rows: tuple[int, int]  # of its joint in the mechanism
    a: int
    b: int
    mu: float
    mu_static: float
    radius: float


@dataclass(frozen=True)
class Clutch:
    a: int
    b: int
    largest: float  # [N m]; inf for an ideal one


@dataclass(frozen=True)
class Answer:
    acceleration: np.ndarray
    modes: tuple[int, ...]  # -1, 0, 1: turns backwards, sticks or is locked, turns on; 2: free, or held by joints


def _turning(size: int, a: int, b: int) -> np.ndarray:
    """The row of the angle of B to A, of a clutch that of A to B with the opposite sign."""
    row = np.zeros(size)
    if b != GROUND:
        row[3 * b + 2] = 1.0
    if a != GROUND:
        row[3 * a + 2] -= 1.0
    return row


def answers(mechanism: Mechanism, q, v, t, pins: list[Pin], clutches: list[Clutch]) -> list[Answer]:
    """All combinations of modes that fulfil their conditions, with the accelerations that follow."""
    mass, size = mechanism.mass(), len(q)
    _, jacobian, _, gamma = mechanism.constraints(q, v, t)
    load = mechanism.load(q, v, t)
    turning = [_turning(size, one.a, one.b) for one in (*pins, *clutches)]
    held = [_is_held(mass, jacobian, row) for row in turning]
    speeds = [row @ v for row in turning]
    choices = []
    for k, one in enumerate((*pins, *clutches)):
        if held[k]:
            choices.append((2,))
        elif isinstance(one, Pin):
            choices.append((-1, 0, 1) if abs(speeds[k]) < STILL else (int(np.sign(speeds[k])),))
        elif abs(speeds[k]) < STILL:
            choices.append((0, 2) if np.isinf(one.largest) else (-1, 0, 2))
        else:
            choices.append((2,) if speeds[k] > 0.0 else (-1,))
    problem = _Problem(mass, jacobian, gamma, load, turning, pins, clutches, speeds)
    found = [problem.tried(modes) for modes in product(*choices)]
    return [one for one in found if one is not None]


def _is_held(mass, jacobian, row) -> bool:
    """True if the joints leave nothing of a row: it cannot move."""
    root = 1.0 / np.sqrt(mass)
    scaled = row * root
    if not len(jacobian):
        return False
    _, s, vt = np.linalg.svd(jacobian * root)
    free = vt[int((s > 1e-9 * s[0]).sum()) :]
    return bool(np.linalg.norm(free @ scaled) <= FIXED * np.linalg.norm(scaled))


@dataclass(frozen=True)
class _Problem:
    mass: np.ndarray
    jacobian: np.ndarray
    gamma: np.ndarray
    load: np.ndarray
    turning: list[np.ndarray]
    pins: list[Pin]
    clutches: list[Clutch]
    speeds: list[float]

    def tried(self, modes: tuple[int, ...]) -> Answer | None:
        """The accelerations of these modes, if they fulfil their conditions."""
        locked = [k for k, mode in enumerate(modes) if mode == 0]
        jacobian = np.vstack([self.jacobian, *(self.turning[k][None] for k in locked)])
        gamma = np.concatenate([self.gamma, np.zeros(len(locked))])
        torque = np.zeros(len(self.pins))
        for _ in range(MOST_ROUNDS):
            load = self.load.copy()
            for k in range(len(self.pins)):
                load -= torque[k] * self.turning[k]
            for k, clutch in enumerate(self.clutches, len(self.pins)):
                load += (clutch.largest if modes[k] == -1 else 0.0) * self.turning[k]
            acceleration, multiplier, _ = solve(self.mass, jacobian, gamma, load)
            pressed = [float(np.hypot(*multiplier[list(pin.rows)])) for pin in self.pins]
            new = np.array(
                [
                    mode * pin.mu * pin.radius * force if mode in (-1, 1) else 0.0
                    for mode, pin, force in zip(modes, self.pins, pressed, strict=False)
                ]
            )
            done = np.abs(new - torque).max(initial=0.0) <= 1e-13 * (1.0 + np.abs(new).max(initial=0.0))
            torque = new
            if done:
                break
        else:
            return None
        scale = 1.0 + np.abs(acceleration).max()
        for k, mode in enumerate(modes):
            rate = self.turning[k] @ acceleration
            carried = -multiplier[len(self.gamma) + locked.index(k)] if mode == 0 else 0.0
            if k < len(self.pins):
                pin = self.pins[k]
                limit = pin.mu_static * pin.radius * pressed[k]
                if mode == 0 and abs(carried) > limit * (1 + SLACK) + SLACK:
                    return None
                if mode in (-1, 1) and abs(self.speeds[k]) < STILL and mode * rate < -SLACK * scale:
                    return None
            elif abs(self.speeds[k]) < STILL:
                clutch = self.clutches[k - len(self.pins)]
                if mode == 0 and not -SLACK <= carried <= clutch.largest * (1 + SLACK) + SLACK:
                    return None
                if (mode == 2 and rate < -SLACK * scale) or (mode == -1 and rate > SLACK * scale):
                    return None
        return Answer(acceleration, modes)
