"""Samples of a study over a length: reading, system and start of one sample.

The yardstick is a mechanism that stands for itself: read, and put together with the search of all closings.
Processor times.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np

import rattle as rt
from measure import Row, Sampler, interleave
from rattle.jit import functions

COUNT = 100  # mechanisms per timing
TOLERANCE = 1e-3  # share of the length by which they differ
STUDIES = {"slider_crank": "rod_length", "fourbar": "l2", "crank_rocker_play": "link", "jansen_leg": "m"}
AIM = "0.4 ms"


def mechanisms(of: Callable[[float], rt.Mechanism], lengths: Iterator[float]) -> Sampler:
    """Time of one mechanism up to its start [s]."""

    def sample() -> float:
        values = [next(lengths) for _ in range(COUNT)]
        began = time.process_time()
        for x in values:
            _ = of(x).start
        return (time.process_time() - began) / COUNT

    return sample


def drawn(length: float) -> Iterator[float]:
    """Lengths [m], none of which comes twice."""
    random = np.random.default_rng(0)
    while True:
        yield float(length * (1.0 + TOLERANCE * random.uniform(-1.0, 1.0)))


def rows(repeats: int) -> list[Row]:
    """One line for each study."""
    functions.start()
    found = []
    for name, parameter in STUDIES.items():
        m = rt.example(name)

        def beside(x: float, m: rt.Mechanism = m, parameter: str = parameter) -> rt.Mechanism:
            return m.neighbour({parameter: x}, told=False)

        def alone(x: float, m: rt.Mechanism = m, parameter: str = parameter) -> rt.Mechanism:
            return m.set({parameter: x})

        times = interleave(
            {"beside": mechanisms(beside, drawn(m.parameters[parameter])),
             "alone": mechanisms(alone, drawn(m.parameters[parameter]))}, repeats,
        )  # fmt: skip
        found.append(Row(f"start of a sample, {name}", times["beside"], "by itself", times["alone"], AIM))
    return found
