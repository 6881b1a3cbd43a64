"""A journal under a steady load: where it settles, its stiffness and damping there, and when it begins to whirl.

The pin turns at w in a bush at rest, so the film sees v = -(w/2) z x e, and the force of the film is -W.  At an
eccentricity the attitude (the angle from the load to e in the sense of w) and the load follow from one evaluation; the
load grows with the eccentricity, which is the root of one equation.

With m x'' + C x' + K x = 0 and whirl at the threshold exp(i n t):  m n^2 = k with
k = (K_xx C_yy + K_yy C_xx - K_xy C_yx - K_yx C_xy)/(C_xx + C_yy),  n^2 = det(K - k 1)/det C;  a lighter mass is stable,
and if n^2 is not positive every mass is (Lund (1987), J. Tribol. 109, 37-41).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from rattle.errors import InputError

Array = NDArray[np.float64]
STEP = 1e-3  # of differences, over the length on which the force changes


class Bearing(Protocol):
    """What is needed of a film: its sizes [m], and its force; see `rattle.Film`."""

    viscosity: float
    length: float
    radius: float
    clearance: float

    def force(
        self, ex: float, ey: float, vx: float, vy: float, omega_bush: float = 0.0, omega_pin: float = 0.0
    ) -> tuple[float, float, float, float, float]:
        """fx, fy [N], both moments [N*m], loss [W]."""
        ...

    def peak_pressure(self, ex: float, ey: float, vx: float, vy: float, omega_mean: float = 0.0) -> float:
        """Largest pressure [Pa]."""
        ...

    def leakage(self, ex: float, ey: float, vx: float, vy: float, omega_mean: float = 0.0) -> float:
        """Flow out of both ends [m^3/s]."""
        ...


@dataclass(frozen=True)
class JournalPosition:
    """Where a pin carries a steady load in its film."""

    load: float  # [N]
    speed: float  # [rad/s] of the pin; the bush is at rest
    eccentricity: float  # distance of the centres over the clearance [-]
    attitude: float  # angle from the load to the line of centres, in the sense of the speed [rad]
    film_thickness: float  # least one [m]
    pressure: float  # largest [Pa]
    friction: float  # moment on the pin over load times radius of the bush [-]
    leakage: float  # flow out of both ends [m^3/s]; nan if the model does not say it
    sommerfeld: float  # mu N (2 R L/W) (R/c)^2 [-], N in revolutions per second
    loss: float  # [W]
    stiffness: Array  # (2, 2) [N/m]: -dF/de; x along the load, y turned from it by 90 degrees in the sense of the speed
    damping: Array  # (2, 2) [N*s/m]: -dF/de'


def located(film: Bearing, load: float, speed: float, least: float) -> float:
    """Eccentricity [of the clearance] at which the film carries a load [N] at a speed [rad/s].

    least: thinnest film over the clearance.  Raises InputError for a load that needs a thinner one.
    """
    from scipy.optimize import brentq

    c = film.clearance

    def excess(place: float) -> float:
        fx, fy = film.force(_eccentricity(place) * c, 0.0, 0.0, 0.0, 0.0, speed)[:2]
        return math.log(math.hypot(fx, fy) / load)

    low, high = -30.0, -math.log(least)  # of ln(e/(1 - e))
    if excess(high) < 0.0:
        most = load * math.exp(excess(high))
        raise InputError(
            f"a load of {load:g} N at {abs(speed):g} rad/s needs a film thinner than {least * c:.3g} m;"
            f" there it carries {most:.3g} N"
        )
    while excess(low) > 0.0:
        low *= 2.0
    return _eccentricity(float(brentq(excess, low, high, xtol=1e-13, rtol=1e-14)))


def _eccentricity(place: float) -> float:
    return 1.0 / (1.0 + math.exp(-place))


def position_at(film: Bearing, e: float, load: float, speed: float) -> JournalPosition:
    """What holds at an eccentricity e [of the clearance], where the film carries the load [N] at the speed [rad/s]."""
    c, turning = film.clearance, abs(speed)
    fx, fy, _, torque, loss = film.force(e * c, 0.0, 0.0, 0.0, 0.0, turning)
    attitude = math.atan2(fy, -fx)
    stiffness, damping = stiffness_and_damping(film, e, attitude, turning)
    half = 0.5 * turning
    return JournalPosition(
        load=load,
        speed=speed,
        eccentricity=e,
        attitude=attitude,
        film_thickness=c * (1.0 - e),
        pressure=film.peak_pressure(e * c, 0.0, 0.0, 0.0, half),
        friction=abs(torque) / (load * film.radius),
        leakage=film.leakage(e * c, 0.0, 0.0, 0.0, half),
        sommerfeld=sommerfeld(film, load, turning),
        loss=loss,
        stiffness=stiffness,
        damping=damping,
    )


def sommerfeld(film: Bearing, load: float, speed: float) -> float:
    """S = mu N (2 R L/W) (R/c)^2 [-] of a load [N] and a speed [rad/s]; N in revolutions per second."""
    turns = speed / (2.0 * math.pi)
    return film.viscosity * turns * 2.0 * film.radius * film.length / load * (film.radius / film.clearance) ** 2


def stiffness_and_damping(film: Bearing, e: float, attitude: float, speed: float) -> tuple[Array, Array]:
    """-dF/de [N/m] and -dF/de' [N*s/m], (2, 2), at an eccentricity [of the clearance] and attitude [rad]; speed > 0."""
    c = film.clearance
    x, y = e * c * math.cos(attitude), e * c * math.sin(attitude)
    aside = STEP * c * min(e, 1.0 - e)
    faster = STEP * 0.5 * speed * c * e * math.sqrt((1.0 - e) * (1.0 + e))
    return (
        _slopes(lambda dx, dy: film.force(x + dx, y + dy, 0.0, 0.0, 0.0, speed)[:2], aside),
        _slopes(lambda vx, vy: film.force(x, y, vx, vy, 0.0, speed)[:2], faster),
    )


def _slopes(force: Callable[[float, float], tuple[float, ...]], step: float) -> Array:
    """Minus the derivatives (2, 2) of a force by central differences of fourth order."""
    slopes = np.empty((2, 2))
    for k in range(2):
        shift = step * np.eye(2)[k]
        f = [np.array(force(*(n * shift).tolist())) for n in (-2.0, -1.0, 1.0, 2.0)]
        slopes[:, k] = -(f[0] - 8.0 * f[1] + 8.0 * f[2] - f[3]) / (12.0 * step)
    return slopes


def threshold(stiffness: Array, damping: Array) -> tuple[float, float]:
    """Mass [kg] from which a journal whirls, and the rate of whirl there [rad/s]; inf and nan if none does.

    stiffness, damping: (2, 2) [N/m], [N*s/m].
    """
    K, C = stiffness, damping
    mixed = K[0, 0] * C[1, 1] + K[1, 1] * C[0, 0] - K[0, 1] * C[1, 0] - K[1, 0] * C[0, 1]
    k = float(mixed / (C[0, 0] + C[1, 1]))
    square = float(np.linalg.det(K - k * np.eye(2)) / np.linalg.det(C))
    if not square > 0.0:
        return math.inf, math.nan
    return max(k, 0.0) / square, math.sqrt(square)
