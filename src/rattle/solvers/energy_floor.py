"""The energy below which an energy error of a run is rounding: that of a mechanism at rest, within the tolerances."""

from __future__ import annotations

from rattle.jit import layout as at
from rattle.jit.functions import native

STEPS_OF_POSITION, STEPS_OF_RATE = 1e2, 1e5  # to which errors of steps add up in a long run, as factors
LARGEST_SHARE = 0.1  # of the moments of all forces, over the size: more is never rounding


@native("void", "h", "f", "f", "f", "f")
def set_floor(m, extent, limit, rtol, atol):
    """Set the floor [J] from the applied forces at the start, see `analyses.dynamics.soundness`.

    extent: size of the mechanism [m].  limit: largest share for drift [-].  Positions are known to rtol [-] of the
    size, rates to atol [m/s, rad/s]; errors of steps add up, hence a hundred (a hundred thousand) times that.
    """
    force, mass, moment, resting = m.force, m.mass, 0.0, 0.0
    slow = STEPS_OF_RATE * atol
    for i in range(1, force.shape[0]):
        moment += abs(force[i, 2]) + extent * (abs(force[i, 0]) + abs(force[i, 1]))
        resting += 0.5 * (mass[i, 0] + mass[i, 1]) * slow**2 + 0.5 * mass[i, 2] * (slow / extent) ** 2
    m.audit[at.FLOOR] = min(STEPS_OF_POSITION * rtol / limit, LARGEST_SHARE) * moment + resting
