"""Positions per second of driven sweeps, and the time to a first single position in a fresh process."""

from __future__ import annotations

import subprocess
import sys
import time
from functools import partial

import numpy as np

import rattle as rt
from measure import Row, Sampler, interleave

POSITIONS = 100_000
FIRST = (
    "import time; start = time.perf_counter(); import rattle as rt; m = rt.example('fourbar').ideal();"
    " m.inverse_dynamics(0.1); print(time.perf_counter() - start)"
)


def seconds_per_position(mechanism: rt.Mechanism, forces: bool) -> float:
    """Wall time of one position [s] in a sweep of a second (1.6 turns of the crank)."""
    times = np.linspace(0.0, 1.0, POSITIONS)
    start = time.perf_counter()
    if forces:
        mechanism.inverse_dynamics(times)
    else:
        mechanism.kinematics(times)
    return (time.perf_counter() - start) / POSITIONS


def seconds_to_first() -> float:
    """Import, model, assembly and one position with forces, without machine code [s]."""
    seen = subprocess.run([sys.executable, "-c", FIRST], check=True, capture_output=True, text=True)
    return float(seen.stdout)


def kinematics_rows(repeats: int) -> list[Row]:
    """The paper's four-bar without play."""
    mechanism = rt.example("fourbar").ideal()
    samplers: dict[str, Sampler] = {
        "kinematics": partial(seconds_per_position, mechanism, False),
        "inverse": partial(seconds_per_position, mechanism, True),
        "first": seconds_to_first,
    }
    median = interleave(samplers, repeats)
    return [
        Row("four-bar: one position of a sweep", median["kinematics"], aim="3.3 us"),
        Row("four-bar: one position with all forces", median["inverse"]),
        Row("four-bar: first position in a new process", median["first"], aim="3 s"),
    ]
