"""Many samples of one mechanism: numbers of interest for every set of parameters, a plain array for each.

Smooth mechanisms run side by side as straight-line machine code (`rattle.trace.lanes`).  Samples for which that cannot
vouch, and mechanisms that it cannot follow, are run one by one by the generic kernels; both are counted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from rattle.analyses import arguments
from rattle.analyses.straight_line.recorded_model import require_parameters
from rattle.errors import InputError, suggest
from rattle.results.display import table
from rattle.results.result import UnknownName
from rattle.studies.runs.progress import Bar
from rattle.studies.runs.runner import Batch, Runner, cores
from rattle.studies.runs.task import Task, task_of
from rattle.wrong_arguments import answers_in_words

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism


@answers_in_words
@dataclass(frozen=True, eq=False)
class Many:
    """Outputs of many samples: `found["max(O3.force)"]` is an array (n,) [SI], nan where it has no finite value."""

    outputs: tuple[str, ...]
    units: dict[str, str]  # SI unit of every output
    samples: dict[str, np.ndarray]  # parameter: (n,) values [SI]
    values: np.ndarray  # (outputs, n)
    messages: dict[int, str]  # of the samples that failed: no run, or an output without a finite value
    generic: np.ndarray  # numbers of the samples that the generic kernels ran
    stats: dict[str, Any]  # "how" they ran, in words; "reasons" why not side by side; of those that did "steps",
    # "evaluations" of the right-hand side, "tries" of steps, and of contacts "doubts", "landings" and "turns"

    def __getitem__(self, output: str) -> np.ndarray:
        if output not in self.outputs:
            raise UnknownName(f"no output '{output}'{suggest(output, self.outputs)}")
        row: np.ndarray = self.values[self.outputs.index(output)]
        return row

    def __len__(self) -> int:
        return int(self.values.shape[1])

    @property
    def failed(self) -> np.ndarray:
        """Numbers of the samples without a run, or with outputs that have no finite value, increasing."""
        return np.array(sorted(self.messages), dtype=np.int64)

    def message(self, sample: int) -> str:
        """Why a sample failed; "" if it did not."""
        return self.messages.get(int(sample), "")

    def unit(self, output: str) -> str:
        """SI unit of an output, "" if it has none."""
        return self.units[output]

    def _repr_html_(self) -> str:
        rows = [
            (output, self.units[output], *_sizes(row)) for output, row in zip(self.outputs, self.values, strict=True)
        ]
        title = f"{len(self)} samples of {', '.join(self.samples)}"
        failed = [f"{len(self.messages)} failed: found.message(i) says why"] if self.messages else []
        below = [self.stats["how"], *failed]
        return table(("output", "unit", "least", "mean", "greatest"), rows, title, below, hint="found[output]")

    def __str__(self) -> str:
        lines = [f"{len(self)} samples of {', '.join(self.samples)}; {len(self.messages)} failed", self.stats["how"]]
        for output, row in zip(self.outputs, self.values, strict=True):
            lines.append(f"{output} [{self.units[output] or '-'}]: {_span(row)}")
        return "\n".join(lines)


def _sizes(row: np.ndarray) -> tuple[str, ...]:
    finite = row[np.isfinite(row)]
    return tuple(f"{x:.6g}" for x in (finite.min(), finite.mean(), finite.max())) if len(finite) else ("-", "-", "-")


def _span(row: np.ndarray) -> str:
    finite = row[np.isfinite(row)]
    return f"{finite.min():.6g} to {finite.max():.6g}, mean {finite.mean():.6g}" if len(finite) else "no values"


def many(
    m: Mechanism, samples: Mapping[str, Any], outputs: Sequence[str], *, t_end: float | None = None,
    rtol: float | None = None, atol: float | None = None, method: str | None = None, step: float | None = None,
    threads: int | None = None, progress: bool = False,
) -> Many:  # fmt: skip
    """Outputs of every sample; see `Mechanism.many`."""
    checked = _samples(m, samples)
    task = task_of(m, checked, outputs, t_end=t_end, method=method, rtol=rtol, atol=atol, step=step)
    threads = cores() if threads is None else arguments.whole("threads", threads, 1)
    runner, values = Runner(task), np.array(list(checked.values()))
    bar = Bar(values.shape[1], "many") if progress else None
    try:
        batch = runner.run(values, min(threads, values.shape[1]), bar)
    finally:
        if bar is not None:
            bar.close()
    return _result(task, checked, runner.why, batch)


def _samples(m: Mechanism, samples: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Checked samples: arrays (n,) by parameter."""
    if not isinstance(samples, Mapping) or not samples:
        raise InputError('samples: expected at least one parameter with its values, such as {"r3": [4e-3, 5e-3]}')
    require_parameters(m.system, list(samples))
    checked: dict[str, np.ndarray] = {}
    for name, values in samples.items():
        try:
            checked[name] = np.ma.asarray(values, dtype=float).filled(np.nan)
        except (TypeError, ValueError):
            raise InputError(f"samples: '{name}': expected numbers in SI units, got {values!r:.60}") from None
    shapes = {name: values.shape for name, values in checked.items()}
    if any(len(shape) != 1 or not shape[0] for shape in shapes.values()) or len(set(shapes.values())) > 1:
        lengths = ", ".join(f"{name}: {shape}" for name, shape in shapes.items())
        raise InputError(f"samples: expected arrays of one length n, at least 1, for every parameter; got {lengths}")
    return checked


def _result(task: Task, samples: dict[str, np.ndarray], why: str, batch: Batch) -> Many:
    """All that was found."""
    values = batch.values
    generic = np.array(batch.generic, dtype=np.int64)
    side = values.shape[1] - len(generic)
    parts = [f"{side} run side by side" if side else "", f"{len(generic)} one by one" if len(generic) else ""]
    counted = {
        f"{count} {'samples' if count > 1 else 'sample'}: {words}": count for words, count in batch.reasons.items()
    }
    because = "; ".join(reason for reason in dict.fromkeys([why, *counted]) if reason) if len(generic) else ""
    stats: dict[str, Any] = {
        "steps": batch.steps, **batch.tallies._asdict(), "reasons": counted,
        "how": ", ".join(part for part in parts if part) + (f": {because}" if because else ""),
    }  # fmt: skip
    units = {output.text: output.unit for output in task.outputs}
    return Many(tuple(task.texts), units, samples, values, batch.messages, generic, stats)
