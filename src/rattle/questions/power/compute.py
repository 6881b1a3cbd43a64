"""Power of a run: who gives how much to which body, at an instant and over a cycle, and where it is lost.

Source: Karnopp, Margolis, Rosenberg, System Dynamics (2012), chapters 2 and 9; docs/power.md.
"""

from __future__ import annotations

import math
import os
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rattle.analyses.driver_period import last_turn
from rattle.errors import InputError
from rattle.loading import loads
from rattle.mechanism import Mechanism
from rattle.questions.power.cycle import Cycle, cycle
from rattle.questions.power.in_units import with_units
from rattle.questions.power.ports import Ports
from rattle.questions.power.steps import rows_at, settings_of
from rattle.results.archive import package
from rattle.results.contact_summary import TOWERS
from rattle.results.display import quantity, table
from rattle.results.result import Result
from rattle.results.table_file import write_frame
from rattle.wrong_arguments import answers_in_words

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

Array = NDArray[np.float64]
NOISE = 1e-9  # share of the largest energy into a body below which one is rounding
PAST = 1e-9  # [of the end] by which a time may lie beyond the end of the run: rounding of what a user adds up
NEEDED = ("document", "t_end", "method", "rtol", "atol")  # in the provenance: the run is gone through again
RUN_AGAIN = "run it again with this version"


def power(r: Result, t0: float | None = None, t1: float | None = None) -> Power:
    """Powers of a run between t0 and t1 [s]; see `Result.power`."""
    if r.provenance.get("analysis") != "simulate":
        raise InputError("power is that of a motion in time, m.simulate(...); this result is of another analysis")
    if any(r.provenance.get(key) is None for key in NEEDED):
        raise InputError(f"this result does not hold its model, from which powers follow; {RUN_AGAIN}")
    m = loads(str(r.provenance["document"]))
    first, last = _window(r, m, t0, t1)
    return Power(r, m, first, last)


def _window(r: Result, m: Mechanism, t0: float | None, t1: float | None) -> tuple[float, float]:
    """The window [s]: what is given, else the last turn of the driver, or the whole run if there is none in it."""
    end = min(float(r.provenance["t_end"]), r.trust.t_end)
    last = end if t1 is None else float(t1)
    first = last_turn(m.system, last) if t0 is None else float(t0)
    if not 0.0 <= first < last <= end * (1.0 + PAST):
        raise InputError(f"power from {first:g} to {last:g} s: give times in order between 0 and the end, {end:g} s")
    return first, min(last, end)


@answers_in_words
class Power:
    """Powers between elements and bodies in one run, and their energies from t0 to t1 [s].

    Elements are joints, drivers, loads and gravity.  Power is positive into the body.
    """

    def __init__(self, result: Result, mechanism: Mechanism, t0: float, t1: float) -> None:
        self.result, self.t0, self.t1 = result, t0, t1
        self._mechanism = mechanism
        self._ports = Ports(mechanism.system)
        self._settings = settings_of(result.provenance)

    def __repr__(self) -> str:
        return f"<rattle.Power: {len(self._ports.list)} ports, {self.t0:g} to {self.t1:g} s>"

    def _repr_html_(self) -> str:
        largest = float(self.cycle.into.max(initial=0.0))
        rows = [
            (name, kind, *(quantity(size, "J") if abs(size) > NOISE * largest else "" for size in sizes))
            for name, kind, *sizes in self.balance()
        ]
        head = ("element", "kind", "supplied", "lost", "stored", "back and forth")
        title = f"Energies from {self.t0:g} to {self.t1:g} s"
        accuracy = f"powers of every body balanced to {self.residual:.1g} W"
        return table(head, [row for row in rows if any(row[2:])], title, [accuracy], hint="p.plot(), p.table")

    @cached_property
    def cycle(self) -> Cycle:
        """Energies [J] as arrays."""
        return cycle(self._mechanism, self._ports, self._settings, self.t0, self.t1)

    @property
    def residual(self) -> float:
        """Largest difference between the powers of a body and the rate of its kinetic energy [W]."""
        return self.cycle.residual

    @cached_property
    def table(self) -> DataFrame:
        """pandas.DataFrame of all ports: element, kind, body, E_in and E_out (into the body and out of it), net,
        recirculated (the smaller of both) [J]; peak (of the largest magnitude) and mean [W].  Raises MissingPackage.
        A peak is nan where forces of rigid contacts tower, see `remark`.
        """
        turn = self.cycle
        columns = {
            **self.names,
            "E_in": turn.into,
            "E_out": turn.out,
            "net": turn.into - turn.out,
            "peak": np.where(self._towers, math.nan, turn.peak),
            "mean": (turn.into - turn.out) / (turn.t1 - turn.t0),
            "recirculated": np.minimum(turn.into, turn.out),
        }
        return _frame(columns)

    @property
    def _towers(self) -> NDArray[np.bool_]:
        """(ports,) True where a peak says nothing of a real contact: far above the usual power, as forces are."""
        turn = self.cycle
        usual = (turn.into + turn.out) / (turn.t1 - turn.t0)
        return (np.abs(turn.peak) > TOWERS * usual) & bool(self.result.trust.unread)

    @property
    def remark(self) -> str:
        """What is to be said of peaks that are left out, "" if none are."""
        if not self._towers.any():
            return ""
        joints = ", ".join(self.result.trust.unread)
        return f"peaks are left out where powers tower with the forces of rigid contacts ({joints})"

    @cached_property
    def elements(self) -> DataFrame:
        """pandas.DataFrame of all elements: element, kind, supplied from outside, lost, stored, recirculated [J].

        Raises MissingPackage.
        """
        turn, every = self.cycle, self._ports.elements
        columns = {
            "element": [element.name for element in every],
            "kind": [element.kind for element in every],
            "supplied": turn.supplied,
            "lost": turn.lost,
            "stored": turn.stored,
            "recirculated": self.recirculated,
        }
        return _frame(columns)

    def at(self, t: float) -> DataFrame:
        """pandas.DataFrame of all ports at an instant t [s]: element, kind, body, power [W].

        Between steps the run is repeated up to there.  Raises InputError for a time outside of the run.
        """
        powers = self.powers(np.array([float(t)]))
        columns = {**self.names, "power": powers[0]}
        return _frame(columns)

    def powers(self, t: Array) -> Array:
        """Powers (n, ports) [W] at increasing instants (n,) [s], in the order of `table`."""
        end = min(float(self._settings.t_end), self.result.trust.t_end)
        if not 0.0 <= t[0] <= t[-1] <= end * (1.0 + PAST):
            raise InputError(f"expected a time within the run, from 0 to {end:g} s, got {t[0]:g} s")
        t = np.minimum(t, end)
        return self._ports.flow(t, rows_at(self._mechanism, self._settings, t)).ports

    def to_csv(self, path: str | os.PathLike[str]) -> Path:
        """Write `table` as CSV, in SI units; if `--units` asks for others, the header names them.

        Raises InputError for a suffix of another format, OSError.
        """
        return write_frame(with_units(self.table), path)

    def plot(self) -> Figure:
        """Sankey picture of the cycle: sources on the left, bodies in between, losses and loads on the right."""
        from rattle.questions.power.pictures import plot_cycle

        return plot_cycle(self)

    def plot_curves(self) -> Figure:
        """Power of every port over time from t0 to t1, one panel for each body."""
        from rattle.questions.power.pictures import plot_powers

        return plot_powers(self)

    @property
    def names(self) -> dict[str, list[str]]:
        """Names of element, kind and body of all ports, in the order of `table`."""
        ports = self._ports
        elements = [ports.elements[port.element] for port in ports.list]
        return {
            "element": [element.name for element in elements],
            "kind": [element.kind for element in elements],
            "body": [ports.bodies[port.body - 1] for port in ports.list],
        }

    @property
    def recirculated(self) -> Array:
        """(elements,) energy that goes into a body and comes back from it between t0 and t1 [J].

        Of an element between two bodies that move it is the smaller of both: that goes through it.
        """
        ports = self._ports
        back = np.minimum(self.cycle.into, self.cycle.out)
        total = np.bincount(ports.of_element, back, minlength=len(ports.elements))
        least = np.full(len(ports.elements), np.inf)
        np.minimum.at(least, ports.of_element, back)
        return np.where([all(element.bodies) for element in ports.elements], least, total)

    def balance(self) -> list[tuple[str, str, float, float, float, float]]:
        """Name and kind of every element, and what it supplied, lost, stored, and gave and took back [J]."""
        sums = np.column_stack([self.cycle.supplied, self.cycle.lost, self.cycle.stored, self.recirculated]).tolist()
        return [(element.name, element.kind, *sizes) for element, sizes in zip(self._ports.elements, sums, strict=True)]

    @property
    def driven(self) -> dict[str, str]:
        """Names of the drivers, with that of the joint where each of them drives."""
        return {name: driver.joint or "" for name, driver in self._mechanism.model.drivers.items()}

    @property
    def between(self) -> set[str]:
        """Names of the elements between two bodies that move."""
        return {element.name for element in self._ports.elements if all(element.bodies)}


def _frame(columns: dict[str, Any]) -> DataFrame:
    """A pandas.DataFrame of these columns.  Raises MissingPackage."""
    frame: DataFrame = package("pandas", "a table of powers").DataFrame(columns)
    return frame
