"""Where groups of rows stand in a tile of lanes, one after the other."""

from __future__ import annotations

from typing import Protocol

from rattle.trace.lane_contacts import Meets
from rattle.trace.lane_control import FLAGS, VERDICT, report_rows
from rattle.trace.lane_methods import PLANNED, Method
from rattle.trace.reductions import Ledger

ASIDE = "aside: "  # names of rows of steps that are set aside


class Shape(Protocol):
    """What `lane_program.Model` says of its size."""

    @property
    def ny(self) -> int: ...
    @property
    def nc(self) -> int: ...
    @property
    def curves(self) -> int: ...
    @property
    def project(self) -> object | None: ...
    @property
    def meets(self) -> Meets | None: ...


class Rows:
    """Groups of rows by name; `count` of them in all."""

    def __init__(self) -> None:
        self.places: dict[str, slice] = {}
        self.count = 0

    def add(self, name: str, count: int) -> None:
        """A group after those that are there."""
        self.places[name] = slice(self.count, self.count + count)
        self.count += count

    def span(self, first: str, last: str) -> slice:
        """From a group to another one."""
        return slice(self.places[first].start, self.places[last].stop)


def laid_out(model: Shape, method: Method, ledger: Ledger) -> Rows:
    """Rows that functions read or write stand next to each other, so that none is gathered."""
    wide, rows, meets = 1 + model.ny, Rows(), model.meets
    report = report_rows(ledger, meets)
    _, seen, met, ends, struck, crossings, later, curves, touch, held, control = report
    block, slopes = wide + 1 + len(ledger.watched), method.slopes if ledger.sampled else method.stages + 1
    inside = (5 + len(method.upper) + ledger.samples - 1) * wide
    for name, count in (
        ("state", wide + model.nc),
        ("y new", wide), ("errors", len(method.errors) * wide),
        # the report
        ("planned", len(PLANNED)), ("verdict", len(VERDICT)), ("curve flags", 2), ("flags", len(FLAGS) - 2),
        ("seen", seen), ("met", met), ("ends", ends), ("struck", struck),
        ("crossings", crossings), ("later", later), ("curves", curves), ("touch", touch), ("rows", held),
        ("control", control),
        ("good", 1), ("asks", 1), ("next", curves + touch + held + control),
        # end, step, y, slopes: blocks of t, y, a flag and watched curves; seen flat, a block is one row of components
        ("blocks", (3 + slopes) * block),
        ("merged", 2 * wide), ("arrived", 2 * wide + curves + ends if model.project is None else 0),
        # share of the step, y, dense output, states between parts
        ("inside", inside if ledger.sampled else 0), ("midway", 0 if meets is None else meets.midway_rows),
        ("after", model.ny + struck if struck else 0),
    ):  # fmt: skip
        rows.add(name, count)
    if ledger.watched:
        for name, count in (
            ("state", wide + model.nc), ("curves", curves), ("later", ledger.samples * (model.curves + 1)),
            ("blocks", (3 + method.slopes) * block), ("inside", inside),
            ("larger", len(ledger.screened) + 1), ("lane", 1), ("taken", 1),
        ):  # fmt: skip
            rows.add(ASIDE + name, count)
    return rows
