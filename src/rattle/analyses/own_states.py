"""States of the model's own ([states]) where an analysis cannot follow them."""

from __future__ import annotations

from rattle.description.model import Model
from rattle.errors import ModelError, Problem
from rattle.language.expression import Node, names


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
    if model.states:
        first = next(iter(model.states))
        text = f"a state depends on all that was before, and {what} takes every position by itself; use simulate:"
        raise ModelError([Problem(("states", first), f"{text} what is driven moves there in the same way")])


def require_loads_without_states(model: Model, what: str) -> None:
    """Raise ModelError if a load depends on a state, whose value at rest is not known."""
    if acting := acting_states(model):
        text = f"a load depends on it, and {what} does not look for states at rest; simulate until the motion has died"
        more = " down, or put in its place a parameter with the value at rest"
        raise ModelError([Problem(("states", acting[0]), text + more)])
