"""Oil whirl: which film feeds a vibration that grows.

The stiffness K = -dF/de of a film under a pin that turns is not symmetric.  In a motion d exp(s t) of the pin in its
bush the force -K d gives the power -Re((s d)* . K d)/2; the symmetric part of K only stores energy, and what the other
part K' = (K - K^T)/2 gives is all that a film can feed.  The motion z grows at the power Re(s) |s|^2 z* M z/2: it is
whirl if the films give that much, so that without them it would not grow.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from rattle.equations.placement import point_at
from rattle.equations.rest_force import FACTORS, SHIFTS
from rattle.questions.equilibrium.balance import StaticProblem
from rattle.solvers.mobility import film_at

STEP = 1e-4  # of differences, over the length on which the force of a film changes


class Whirl(NamedTuple):
    """A film that makes a mode grow."""

    joint: str
    ratio: float  # circular frequency of the mode over the sum of the rates of bush and pin [-]


class Floating(NamedTuple):
    """A pin in oil at rest."""

    joint: str
    number: int  # of its contact
    place: np.ndarray  # (2,) e [m]
    rates: np.ndarray  # (2,) of bush and pin [rad/s]
    rows: np.ndarray  # (2, 3 nb) of the Jacobian of e


def floating(problem: StaticProblem, q: np.ndarray) -> list[Floating]:
    """All pins in oil at q (3 nb,), with the rates that their films see now."""
    pins = []
    for name, number, a, b in problem.oiled:
        joint = problem.system.model.joints[name]
        rows = problem.pin_rows(q, name)
        e = point_at(problem.system, q, joint.b) - point_at(problem.system, q, joint.a)
        pins.append(Floating(name, number, e, problem.workspace.turning[[a, b]].copy(), rows))
    return pins


def seen_speeds(problem: StaticProblem, q: np.ndarray) -> list[float]:
    """Velocities [m/s] that films see whose pins turn, at q (3 nb,); of a pin in the centre, that at a tenth of c."""
    speeds = []
    for pin in floating(problem, q):
        clearance = problem.system.model.joints[pin.joint].clearance
        speed = 0.5 * abs(float(pin.rates.sum())) * max(float(np.hypot(*pin.place)), 0.1 * clearance)
        speeds += [speed] if speed > 0.0 else []
    return speeds


def whirls(problem: StaticProblem, q: np.ndarray, roots: np.ndarray, vectors: np.ndarray) -> tuple[Whirl | None, ...]:
    """The film that makes each mode grow, None where none does; roots (f, 2) [1/s], vectors (f, 2, 3 nb)."""
    pins = floating(problem, q)
    if not pins:
        return ()
    mass = problem.system.arrays["mass"][1:].ravel()
    crossed = [_crossed(problem, pin) for pin in pins]
    return tuple(_whirl(pins, crossed, complex(s[0]), z[0], mass) for s, z in zip(roots, vectors, strict=True))


def _whirl(
    pins: list[Floating], crossed: list[np.ndarray], s: complex, z: np.ndarray, mass: np.ndarray
) -> Whirl | None:
    """The film that gives most power to a mode, if films give it as much as it needs to grow."""
    if not (s.real > 0.0 and s.imag != 0.0):
        return None
    powers = []
    for pin, k in zip(pins, crossed, strict=True):
        d = pin.rows @ z
        powers.append(-0.5 * float(np.real(np.conj(s * d) @ (k @ d))))
    needed = 0.5 * s.real * abs(s) ** 2 * float(np.real(np.conj(z) @ (mass * z)))
    if sum(powers) < needed:
        return None
    pin = pins[int(np.argmax(powers))]
    turning = abs(float(pin.rates.sum()))
    return Whirl(pin.joint, abs(s.imag) / turning if turning > 0.0 else math.nan)


def _crossed(problem: StaticProblem, pin: Floating) -> np.ndarray:
    """K' (2, 2) [N/m], the part of -dF/de that is not symmetric, by differences of fourth order."""
    workspace, c = problem.workspace, problem.system.model.joints[pin.joint].clearance
    size = float(np.hypot(*pin.place))
    step = STEP * min(max(size, 0.1 * c), max(c - size, 1e-3 * c))
    slopes = np.zeros((2, 2))
    for k in range(2):
        for shift, factor in zip(SHIFTS, FACTORS, strict=True):
            x, y = pin.place + shift * step * np.eye(2)[k]
            film_at(workspace, pin.number, float(x), float(y), 0.0, 0.0, float(pin.rates[0]), float(pin.rates[1]))
            slopes[:, k] += factor / (12.0 * step) * workspace.film_force[:2]
    return 0.5 * (slopes - slopes.T)
