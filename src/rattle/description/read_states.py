"""The table [states]: first-order states of the model's own, { rate = EXPRESSION, start = VALUE }."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress

from rattle.description.model import State
from rattle.description.read_fields import FieldReader
from rattle.description.read_parameters import read_quantity
from rattle.description.read_values import Values, quoted
from rattle.description.reading import Path, Table, section
from rattle.description.tables import RATE, STATE
from rattle.language.expression import ExpressionError, Node, Number, parse
from rattle.language.units import TIME, Dimension, QuantityError, describe, parse_quantity, unit_name


def declare_states(values: Values, document: Table) -> dict[str, float]:
    """Enter the names of all states, with their dimensions, and return their values at the start [SI].

    The dimension is that of `start`, if it says one, else that of the rate times a time; it is unknown if neither says
    one, or if the rate does not fit.
    """
    table = values.table(document.get("states", {}), ("states",))
    starts: dict[str, float] = {}
    for name, entry in table.items():
        path: Path = ("states", name)
        values.name(name, path)
        if name in values.constants:
            values.wrong(path, f"'{name}' is already a parameter; choose another name", at_key=True)
        values.live[name] = None
        if not isinstance(entry, Mapping):
            values.wrong(path, f'expected {{ rate = "expression", start = 0 }}, got {quoted(entry)}')
            continue
        start = FieldReader(values).form(STATE, entry, path)["start"]
        starts[name], values.dimensions[name] = start or (0.0, None)
    rates = {name: _tree(section(table, name).get("rate")) for name in starts}
    signals = document.get("signals", {})
    trees = {name: _tree(written) for name, written in signals.items()} if isinstance(signals, Mapping) else {}
    _infer(values, {name: node for name, node in rates.items() if node is not None}, trees)
    return starts


def _tree(written: object) -> Node | None:
    """The tree of an expression that may have faults; None if there is none."""
    with suppress(ExpressionError, QuantityError):
        if isinstance(written, str) and parse_quantity(written) is None:
            return parse(written)
    return None


def _infer(values: Values, rates: Mapping[str, Node], signals: Mapping[str, Node | None]) -> None:
    """Find the dimensions of states that do not say theirs, through signals as far as needed."""
    declared = values.dimensions
    free = {name: node for name, node in signals.items() if node is not None and name not in declared}
    guessed = _guessed(values, rates, free)
    values.dimensions = {**declared, **guessed}
    for name, node in rates.items():
        if name in guessed and not _fits(values, node, guessed[name]):
            del guessed[name]
    values.dimensions = {**declared, **{name: guessed[name] for name in rates if name in guessed}}
    values.numbers.update(name for name in guessed if name in rates and not values.has_units(rates[name]))


def _guessed(values: Values, rates: Mapping[str, Node], signals: Mapping[str, Node]) -> dict[str, Dimension]:
    """Dimensions of states and signals as they follow from each other, wherever they do."""
    declared, guessed = values.dimensions, dict[str, Dimension]()
    for _ in range(len(rates) + len(signals)):
        before = len(guessed)
        values.dimensions = {**declared, **guessed}
        for name, node in (*rates.items(), *signals.items()):
            if values.dimensions.get(name) is None:
                with suppress(ExpressionError):
                    seen = values.dimension(node)
                    if seen is not None:
                        guessed[name] = seen.times(TIME) if name in rates else seen
        if len(guessed) == before:
            break
    return guessed


def _fits(values: Values, node: Node, of_state: Dimension) -> bool:
    """True if a rate has the dimension of its state per time, or none that can be told."""
    try:
        seen = values.dimension(node)
    except ExpressionError:
        return False
    return seen is None or seen.times(TIME) == of_state


def read_states(values: Values, document: Table, starts: Mapping[str, float]) -> dict[str, State]:
    """Read the rates of all states, which may use every live name."""
    states = {}
    for name, start in starts.items():
        path: Path = ("states", name, "rate")
        entry = section(section(document, "states"), name)
        if "rate" not in entry:
            values.wrong(path[:2], RATE.missing)
            continue
        node, seen = _rate(values, entry["rate"], path)
        if node is None:
            continue
        of_state = values.dimensions.get(name)
        if of_state is not None and seen is not None and seen.times(TIME) != of_state:
            fitting = describe(of_state.over(TIME))
            values.wrong(
                path,
                f"{quoted(entry['rate'])} is {describe(seen)}; expected {fitting}: the state is {describe(of_state)}",
            )
        states[name] = State(name, node, start, unit_name(of_state) if of_state is not None else "")
    return states


def _rate(values: Values, written: object, path: Path) -> tuple[Node | None, Dimension | None]:
    """The tree of a rate and its dimension, None if unknown; no tree after a problem."""
    quantity = read_quantity(values, written, path)
    if isinstance(quantity, tuple):
        return Number(quantity[0], 0), quantity[1]
    if quantity is None:
        return None, None
    text = str(written)
    if not values.names_known(quantity, text, path, None, live=True) or not values.dimension_fits(
        quantity, text, path, None
    ):
        return None, None
    if not values.is_finite(quantity, path):
        return None, None
    return quantity, values.dimension(quantity) if values.has_units(quantity) else None
