"""Belts that would slip: strands whose tensions differ by more than friction on the pulleys holds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from rattle.analyses.travel import distance_of
from rattle.equations.system import System

TINY = 1e-300  # tension [N] that may be divided by
CARRIES = 1e-3  # share of the largest tension below which a belt carries nothing, and nothing slips


def grip_notes(system: System, t: np.ndarray, q: np.ndarray, data: np.ndarray, names: Sequence[str]) -> tuple[str, ...]:
    """Notes on belts that no friction would hold.

    t: (n,) [s].  q: (n, nb, 3) [m, m, rad] positions of all bodies.  data (n, k): curves [SI] with their names.
    """
    notes = []
    for name, joint in system.model.joints.items():
        grip = joint.leaf.grip(joint.fields, distance_of(system, q, joint)) if len(t) else None
        if grip is None or joint.one_sided is None:
            continue
        columns = [f"{name}.{key}" for key in joint.one_sided.records]
        if not set(columns) <= set(names):
            continue
        tight, slack = (np.maximum(data[:, names.index(column)], 0.0) for column in columns)
        carries = tight > CARRIES * np.abs(tight).max(initial=0.0)
        over = np.flatnonzero(carries & (tight > slack * grip.ratio))
        if len(over):
            notes.append(f"joint '{name}' {_words(t, tight, slack, grip, over)}")
    return tuple(notes)


def _words(t: np.ndarray, tight: np.ndarray, slack: np.ndarray, grip: Any, over: np.ndarray) -> str:
    """Where and by how much a belt would slip; over: the instants at which it would."""
    with np.errstate(divide="ignore"):
        ratio = np.where(slack > 0.0, tight / np.maximum(slack, TINY), np.inf)[over]
    k = over[int(np.argmax(ratio))]
    worst = float(ratio.max())
    many = f"{worst:.3g}" if math.isfinite(worst) else "without limit: the slack strand hangs"
    return (
        f"would slip, first at t = {float(t[over[0]]):.4g} s: there and later its strands bear up to"
        f" {float(tight[k]):.4g} N and {float(slack[k]):.4g} N, a ratio {many} (t = {float(t[k]):.4g} s), and friction"
        f" holds {float(grip.ratio[k]):.3g} (Eytelwein, mu = {grip.mu:g}{grip.source}, wrap"
        f" {math.degrees(float(grip.wrap[k])):.4g} deg). The model does not let it slip: more pretension, or"
        " toothed = true for a chain"
    )
