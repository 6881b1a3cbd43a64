"""Belts that would slip: strands whose tensions differ by more than friction on the pulleys holds."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from rattle.analyses.travel import distance_of
from rattle.equations.system import System
from rattle.jit.choices import TINY

SENTENCES = {  # also in pages
    "slips": "joint '{joint}' would slip, first at t = {first:.4g} s: there and later its strands bear up to"
    " {tight:.4g} N and {slack:.4g} N, a ratio {ratio} (t = {t:.4g} s), and friction holds {holds:.3g} (Eytelwein, mu ="
    " {mu:g}{source}, wrap {wrap:.4g} deg). The model does not let it slip: more pretension, or toothed = true for a"
    " chain",
    "hangs": "without limit: the slack strand hangs",
}
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
            notes.append(_words(name, t, tight, slack, grip, over))
    return tuple(notes)


def _words(joint: str, t: np.ndarray, tight: np.ndarray, slack: np.ndarray, grip: Any, over: np.ndarray) -> str:
    """Where and by how much a belt would slip; over: the instants at which it would."""
    with np.errstate(divide="ignore"):
        ratio = np.where(slack > 0.0, tight / np.maximum(slack, TINY), np.inf)[over]
    k = over[int(np.argmax(ratio))]
    worst = float(ratio.max())
    many = f"{worst:.3g}" if math.isfinite(worst) else SENTENCES["hangs"]
    return SENTENCES["slips"].format(
        joint=joint, first=float(t[over[0]]), tight=float(tight[k]), slack=float(slack[k]), ratio=many, t=float(t[k]),
        holds=float(grip.ratio[k]), mu=grip.mu, source=grip.source, wrap=math.degrees(float(grip.wrap[k])),
    )  # fmt: skip
