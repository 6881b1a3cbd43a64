"""What all studies over many samples have in common: the samples, their numbers, and why some have none."""

from __future__ import annotations

import csv
import os
from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from rattle.atomic_file import atomic
from rattle.errors import InputError, suggest
from rattle.exchange.result_workbook import require_workbook
from rattle.exchange.workbook import Cell, Sheet, workbook
from rattle.questions.ensemble.pieces import OK, STATUS, WAITING, column_name
from rattle.questions.ensemble.plans import Plan
from rattle.questions.ensemble.store import Store
from rattle.results.archive import package, write_content
from rattle.results.chosen_units import column_unit
from rattle.results.result import UnknownName
from rattle.results.table_file import require_table
from rattle.studies.runs.columns import in_one_unit
from rattle.studies.runs.reasons import counted
from rattle.studies.runs.task import Task
from rattle.value_types import Json

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism


WITHOUT = {"failed": "could not be run", "not finite": "have an output without a finite value"}
MOST_REASONS = 6


class UnknownSample(InputError, IndexError):
    """There is no sample of this number."""


@dataclass(frozen=True, eq=False, repr=False)
class Samples(ABC):
    """n samples of one mechanism with their outputs: `found["max(O3.force)"]`, `found["r3"]` are (n,) arrays [SI]."""

    task: Task = field(repr=False)
    plan: Plan = field(repr=False)
    store: Store = field(repr=False)
    how: str  # how the samples were run, and why so
    interrupted: bool  # the user stopped it before all samples were run

    @property
    def outputs(self) -> tuple[str, ...]:
        """The outputs as they were asked for."""
        return tuple(self.task.texts)

    @property
    def parameters(self) -> tuple[str, ...]:
        """The parameters that differ."""
        return self.plan.names

    def __len__(self) -> int:
        return self.plan.count

    def __getitem__(self, name: str) -> np.ndarray:
        names = [*self.parameters, *self.outputs]
        if name not in names:
            raise UnknownName(f"no parameter or output '{name}'{suggest(str(name), names)}")
        return self.store.column(name)

    def histories(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Instants (m,) [s] and the curves (n, m) [SI] of all samples that were kept, nan where a sample has none."""
        self._require_history(name)
        return self.task.history_times, self.store.curves(name)

    def history(self, number: int, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Instants (m,) [s] and the curve (m,) [SI] of one sample that was kept."""
        self._require_history(name)
        return self.task.history_times, self.store.curve(name, self._number(number))

    def _require_history(self, name: str) -> None:
        if name not in self.task.histories:
            hint = suggest(str(name), self.task.histories)
            raise UnknownName(f"no history '{name}'{hint or '; ask for it with histories=[...]'}")

    def unit(self, name: str) -> str:
        """SI unit of a parameter, output or history, "" if it has none or it is not known."""
        if name in self.task.histories:
            return self.task.history_units[self.task.histories.index(name)]
        if name in self.outputs:
            return next(output.unit for output in self.task.outputs if output.text == name)
        return self.task.mechanism.model.parameters[name].unit

    @cached_property
    def status(self) -> np.ndarray:
        """(n,) texts: ok, failed, not finite, not run."""
        numbers = self.store.status()
        texts = np.full(len(numbers), STATUS[OK], dtype="U10")
        for number, text in STATUS.items():
            texts[numbers == number] = text
        return texts

    @property
    def messages(self) -> dict[int, str]:
        """Why samples have no numbers, by number of the sample."""
        return self.store.messages()

    def message(self, sample: int) -> str:
        """Why a sample has no numbers; "" if it has."""
        return self.messages.get(int(sample), "")

    def sample(self, number: int) -> Mechanism:
        """The mechanism of a sample.  Raises UnknownSample for a number that is not among them, ModelError."""
        n = self._number(number)
        return self.task.mechanism_at(self.plan.values(n, n + 1)[:, 0])

    def _number(self, number: int) -> int:
        """The number of a sample.  Raises UnknownSample."""
        if isinstance(number, bool) or not isinstance(number, int | np.integer) or not 0 <= number < len(self):
            raise UnknownSample(f"sample {number!r}: samples are numbered from 0 to {len(self) - 1}")
        return int(number)

    def told(self, number: int) -> str:
        """The parameters of a sample as text: "r3 = 5 mm, l2 = 0.6 m"."""
        values = zip(self.parameters, self.plan.values(number, number + 1)[:, 0], strict=True)
        return ", ".join(f"{name} = " + " ".join(in_one_unit([x], self.unit(name))).rstrip() for name, x in values)

    @cached_property
    def table(self) -> Any:
        """A pandas DataFrame, one row per sample that was run: parameters and outputs [SI], status, message."""
        pandas = package("pandas", "a table of samples")
        run = self.store.status() != WAITING
        numbers = np.flatnonzero(run)
        columns: dict[str, Any] = {column_name(name): self[name][run] for name in (*self.parameters, *self.outputs)}
        messages = self.messages
        columns["status"] = self.status[run]
        columns["message"] = [messages.get(int(n), "") for n in numbers]
        return pandas.DataFrame(columns, index=pandas.Index(numbers, name="sample"))

    def to_csv(self, path: str | os.PathLike[str]) -> None:
        """Write a row per sample that was run: number, parameters, outputs, status, message, numbers in full precision.

        In SI units, unless `--units` asks for others.
        Raises ValueError for a suffix of another format, OSError; the file is written completely or not at all.
        """
        require_table(path)
        with atomic(path) as file, file.open("w", newline="", encoding="utf-8") as out:
            writer = csv.writer(out, lineterminator="\n")
            writer.writerow(self._titles())
            writer.writerows(self._rows())

    def to_excel(self, path: str | os.PathLike[str]) -> None:
        """Write the table of `to_csv` as a workbook (`.xlsx`) of one sheet.  Raises as `to_csv`."""
        require_workbook(path)
        rows = [*self._rows()]
        write_content(workbook([Sheet("samples", self._titles(), rows, len(rows))]), path)

    def _titles(self) -> list[str]:
        names = [*self.parameters, *self.outputs]
        units = [column_unit(self.unit(name)).unit for name in names]
        titles = [
            f"{column_name(name)} [{unit}]" if unit else column_name(name)
            for name, unit in zip(names, units, strict=True)
        ]
        return ["sample", *titles, "status", "message"]

    def _rows(self) -> Iterator[list[Cell]]:
        names = [*self.parameters, *self.outputs]
        columns = [column_unit(self.unit(name)).factor * np.asarray(self[name]) for name in names]
        status, messages = self.status, self.messages
        for n in np.flatnonzero(self.store.status() != WAITING).tolist():
            yield [n, *(column[n] for column in columns), str(status[n]), messages.get(n, "")]

    def record(self) -> dict[str, Json]:
        """What was found as plain data, in SI units."""
        return {
            "samples": len(self), "parameters": list(self.parameters), "counts": self.counts(), "failures": self.why(),
            "how": self.how, "interrupted": self.interrupted,
            "outputs": {output: {"unit": self.unit(output), **self.numbers(output)} for output in self.outputs},
        }  # fmt: skip

    @abstractmethod
    def numbers(self, output: str) -> dict[str, Any]:
        """What is known of an output as plain data [SI]."""

    def counts(self) -> dict[str, int]:
        """Number of samples by status."""
        numbers = self.store.status()
        return {text: int((numbers == number).sum()) for number, text in STATUS.items()}

    def why(self) -> dict[str, int]:
        """Why samples have no numbers, alike reasons counted together, the most frequent first."""
        return counted(self.messages.values())

    def remarks(self) -> list[str]:
        """What must be said of the samples: how they ran, how many have no numbers, and why."""
        counts = self.counts()
        lines = [self.how] if self.how else []
        if counts["not run"]:
            again = "; the same call goes on" if self.store.place else ""
            lines.append(f"stopped after {len(self) - counts['not run']} of {len(self)} samples{again}")
        if counts["failed"] or counts["not finite"]:
            parts = [f"{counts[status]} {what}" for status, what in WITHOUT.items() if counts[status]]
            lines.append(f"of {len(self)} samples {' and '.join(parts)}:")
            lines += [f"  {count} x {reason}" for reason, count in list(self.why().items())[:MOST_REASONS]]
            more = len(self.why()) - MOST_REASONS
            lines += [f"  and {more} other reasons (message(i))"] if more > 0 else []
        return lines
