"""Pieces of an ensemble: consecutive samples with what became of them, the unit of work and of storage."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from rattle.studies.runs.runner import Progress, Runner

WAITING, OK, FAILED, NOT_FINITE = -1, 0, 1, 2
STATUS = {OK: "ok", FAILED: "failed", NOT_FINITE: "not finite", WAITING: "not run"}
OWN = ("sample", "status", "generic", "message")  # columns of tables besides those of parameters and outputs


def column_name(name: str) -> str:
    """What the column of a parameter or output is called, in tables and files."""
    return f"parameter {name}" if name in OWN else name


@dataclass(eq=False)
class Piece:
    """Samples from `first` on, c of them."""

    first: int
    parameters: np.ndarray  # (k, c) [SI]
    values: np.ndarray  # (o, c) [SI], nan where there is none
    status: np.ndarray  # (c,) int8: OK, FAILED, NOT_FINITE
    messages: dict[int, str]  # why samples failed, by their number in the whole
    generic: np.ndarray  # (c,) bool: run one by one
    reasons: dict[str, int] = field(default_factory=dict)  # why those did not run side by side, and how many
    curves: np.ndarray = field(default_factory=lambda: np.empty((0, 0, 0)))  # (h, c, m) [SI], nan where there is none

    @property
    def last(self) -> int:
        """One after the number of the last sample."""
        return self.first + len(self.status)


def run_piece(
    runner: Runner, first: int, parameters: np.ndarray, threads: int = 1, progress: Progress | None = None
) -> Piece:
    """Run the samples from `first` on, with values (k, c) [SI].  Raises KeyboardInterrupt if the user stops it."""
    batch = runner.run(parameters, threads, progress)
    count = parameters.shape[1]
    status = np.full(count, OK, dtype=np.int8)
    status[list(batch.messages)] = FAILED
    status[batch.lacking] = NOT_FINITE
    messages = {first + n: message for n, message in batch.messages.items()}
    generic = np.zeros(count, dtype=bool)
    generic[batch.generic] = True
    reasons = {runner.why: count} if runner.why else batch.reasons
    return Piece(first, parameters, batch.values, status, messages, generic, reasons, batch.curves)
