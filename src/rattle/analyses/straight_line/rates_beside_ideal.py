"""Rates at the start of a mechanism with massless links whose rates are not given: those without play, made to fit.

As the assembly does: angular velocities are those of the mechanism without play, joints place the bodies' velocities
from the ground outwards, and the least mass-weighted change closes what is left.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from rattle.analyses.assembly.first_guess import leaves_place, outward
from rattle.equations.system import System
from rattle.language.recorded import symbol_of
from rattle.trace.recording import Recorder, Recording


def rates_beside_ideal(recorded: System, recorder: Recorder, q: np.ndarray, ideal: np.ndarray) -> tuple[list[Any], Any]:
    """Rates (3 nb,) [m/s, rad/s] at closed positions q, then 0: nothing given is missed; and a flag.

    q: (3 nb,) symbols of positions.  ideal: (3 nb,) symbols of the rates of the mechanism without play.
    """
    recording = Recording(recorded, recorder)

    def close() -> list[Any]:
        closing, v = recording.closing(0.0), _placed(recorded, recorder, q, ideal)
        for _ in range(2):
            closing.begin(q, v)
            closing.close_rates(v)
        return [*v, 0.0]

    return recording.guarded(close)


def _placed(recorded: System, recorder: Recorder, q: np.ndarray, ideal: np.ndarray) -> np.ndarray:
    """Rates with the angular velocities of `ideal` and velocities by the joints, from the ground outwards."""
    v, apply = ideal.copy(), recorder.graph.apply

    def rate_of(point: Any) -> tuple[Any, Any]:
        if point.body == "ground":
            return 0.0, 0.0
        k = 3 * recorded.bodies.index(point.body)
        cos, sin = apply("cos", q[k + 2]), apply("sin", q[k + 2])
        x, y = (symbol_of(one) for one in point.at)
        return v[k] - v[k + 2] * (sin * x + cos * y), v[k + 1] + v[k + 2] * (cos * x - sin * y)

    for body, _, joint in outward(recorded.model):
        if leaves_place(joint):
            continue
        k = 3 * recorded.bodies.index(body)
        own, other = (joint.b, joint.a) if joint.b.body == body else (joint.a, joint.b)
        v[k] = v[k + 1] = 0.0
        (x, y), (own_x, own_y) = rate_of(other), rate_of(own)
        v[k], v[k + 1] = x - own_x, y - own_y
    return v
