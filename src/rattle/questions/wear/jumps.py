"""How profiles change over many cycles, from what one cycle has shown.

A cycle gives the sliding work in every bin and the loads under which pins slide.  Over a jump of J cycles the loads
stay; where the pins lie in their bushes, and with it the pressure, follows from equilibrium on the profile as it wears.
sigma_J = k K_w s J, the sliding distance s of a cycle, says how stiff that is: h + J dh is monotone for sigma_J <= 1
and stable below 2.  Beyond, profiles are integrated over the jump by a stabilised method.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from rattle.questions.wear.chebyshev import integrate
from rattle.questions.wear.cycle import Sliding, first_places
from rattle.questions.wear.pins import Depths, Pin
from rattle.solvers.contacts.wear_march import slide_under
from rattle.solvers.contacts.wear_sum import SLIDING

Array = NDArray[np.float64]
STEP_ERROR = 1e-3  # of an integration over a jump, share of the largest depth
SMALL = 0.1  # sigma_J up to which one step is as good


def per_cycle(pins: Sequence[Pin], sliding: Sliding) -> Depths:
    """Depth (2, bins) [m] that every pin and bush loses in a cycle."""
    return [pin.factors * work for pin, work in zip(pins, sliding.work, strict=True)]


def stiffness(pin: Pin, loads: Array) -> float:
    """Bound on sigma of one cycle [-]: no point slides further than the contact does."""
    return sum(pin.rates) * pin.bed * float(loads[:, SLIDING].sum())


def sigma(pins: Sequence[Pin], sliding: Sliding) -> float:
    """The largest sigma of one cycle [-]: of the bin that is in contact over the longest sliding distance."""
    return max(stiffness(pin, loads) for pin, loads in zip(pins, sliding.loads, strict=True))


def straight(depths: Depths, pins: Sequence[Pin], sliding: Sliding, cycles: float) -> Depths:
    """Depths after so many cycles in which every bin loses what it has lost in this one."""
    return [h + cycles * dh for h, dh in zip(depths, per_cycle(pins, sliding), strict=True)]


def marched(values: Array, depths: Depths, pins: Sequence[Pin], sliding: Sliding, cycles: float) -> Depths:
    """Depths after so many cycles under the loads of this one; values: parameters of the system."""
    after = []
    for pin, h, work, loads, share in zip(
        pins, depths, sliding.work, sliding.loads, sliding.shares, strict=True
    ):  # fmt: skip
        if cycles * stiffness(pin, loads) <= SMALL or not work.any():
            after.append(h + cycles * pin.factors * work)
            continue
        after.append(_marched(pin, values, h, loads, float(share), cycles))
    return after


def _marched(pin: Pin, values: Array, h: Array, loads: Array, share: float, cycles: float) -> Array:
    places, factors = first_places(pin, loads), share * pin.factors
    work, sums = np.zeros(2 * pin.bins), np.zeros(5)

    def slid(depths: Array) -> Array:
        slide_under(pin.parameters(values, np.maximum(depths.reshape(2, -1), 0.0)), loads, places, work, sums)
        return work.reshape(2, -1)

    def rate(depths: Array) -> Array:
        return np.asarray((factors * slid(depths)).ravel())

    fastest = share * stiffness(pin, loads)
    ended = integrate(rate, h.ravel(), cycles, lambda _: fastest, STEP_ERROR).reshape(2, -1)
    return np.maximum(ended, h)
