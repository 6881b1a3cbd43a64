"""What depends on the past, for analyses that do not follow the motion in time: left out, or the question is refused.

An ideal clutch at rest may pass any torque in its sense, and a wound-up one keeps what it was wound up by; states of
the model's own ([states]) are sums of all that was before.  Neither follows from a position.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from rattle.description.model import Joint, Model
from rattle.equations.system import System
from rattle.errors import ModelError, Problem
from rattle.language.expression import Node, names
from rattle.results.columns import overrun, rates_of

ROUNDING = 1e-9  # share of the largest rate below which a driving body is not ahead


def _clutches(system: System) -> Iterator[tuple[str, Joint, bool]]:
    """Name and joint of every clutch, and whether its torque follows from the state of the bodies alone."""
    for name, joint in system.model.joints.items():
        own = joint.leaf.own_contact(joint.fields)
        if own is not None:
            yield name, joint, not own.rigid and own.states == 0


def require_known_torques(system: System, what: str, also_smooth: bool = False) -> None:
    """Raise ModelError with the clutches whose torque an analysis, in words, cannot know.

    also_smooth: also those whose torque follows from the rates, because it has a kink at rest.
    """
    clutches = [name for name, _, smooth in _clutches(system) if also_smooth or not smooth]
    if clutches:
        listed = ", ".join(f"'{name}'" for name in clutches)
        words = (
            f"{what} does not determine the torque of {listed}: a clutch that holds passes whatever torque the motion"
            " has led to, one that is overrun none; use simulate, or put a torsion-spring load in the place of each"
        )
        raise ModelError([Problem(("joints", clutches[0]), words)])


def run_backwards(system: System, t: np.ndarray, raw: np.ndarray) -> list[str]:
    """Notes on clutches that a prescribed motion turns against their sense; t: (n,) [s], raw: its output rows."""
    notes = []
    for name, joint, smooth in _clutches(system):
        a, b = rates_of(system, joint, raw)
        rate, size = overrun(joint, a, b), float(max(np.abs(a).max(initial=0.0), np.abs(b).max(initial=0.0)))
        wrong = rate < -ROUNDING * size
        if not smooth and wrong.any():
            k = int(np.argmax(wrong))
            notes.append(
                f"clutch '{name}' does not allow this motion: at {int(wrong.sum())} of {len(t)} instants, first at t ="
                f" {t[k]:.6g} s, '{joint.a.body}' would get ahead of '{joint.b.body}', by up to {-rate.min():.4g} rad/s"
            )
    return notes


def acting_states(model: Model) -> list[str]:
    """Names of the states on which a load depends, directly or through signals and other states."""
    seen: set[str] = set()
    values = [value for load in model.loads.values() for value in load.values]
    nodes: list[Node] = [value for value in values if not isinstance(value, float | int)]
    while nodes:
        for name in names(nodes.pop()) - seen:
            seen.add(name)
            if name in model.signals:
                nodes.append(model.signals[name])
            elif name in model.states:
                nodes.append(model.states[name].rate)
    return [name for name in model.states if name in seen]


def require_no_states(model: Model, what: str) -> None:
    """Raise ModelError if the model has states: an analysis of single positions does not know their history."""
    if model.remembers:
        first = next(name for name, state in model.states.items() if not state.travel)
        text = f"a state depends on all that was before, and {what} takes every position by itself; use simulate:"
        raise ModelError([Problem(("states", first), f"{text} what is driven moves there in the same way")])


def require_loads_without_states(model: Model, what: str) -> None:
    """Raise ModelError if a load depends on a state, whose value at rest is not known."""
    if acting := acting_states(model):
        text = f"a load depends on it, and {what} does not look for states at rest; simulate until the motion has died"
        more = " down, or put in its place a parameter with the value at rest"
        raise ModelError([Problem(("states", acting[0]), text + more)])
