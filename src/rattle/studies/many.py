"""Many samples of one mechanism: numbers of interest for every set of parameters, a plain array for each.

Smooth mechanisms run side by side as straight-line machine code (`rattle.trace.lanes`).  Samples for which that cannot
vouch, and mechanisms that it cannot follow, are run one by one by the generic kernels; both are counted.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from rattle.analyses import arguments
from rattle.analyses.straight_line.derived_curves import derived_names
from rattle.analyses.straight_line.lane_model import Asked, lane_model, needs_short_steps, why_not_lanes
from rattle.analyses.straight_line.machine_code import MachineFunctions
from rattle.analyses.straight_line.recorded_model import RecordedModel, require_parameters
from rattle.analyses.straight_line.starts import Starts
from rattle.errors import AssemblyError, ModelError, Problem, SolverError, TraceError, suggest
from rattle.language import arrays
from rattle.language.syntax import names
from rattle.registry import kinds
from rattle.results.columns import columns, width
from rattle.results.evaluation import evaluate
from rattle.results.reductions import Known, Output, argument, needed_instants, read
from rattle.results.result import UnknownName
from rattle.solvers.stepper import ATOL, FREE, LONGEST, usual_stepper
from rattle.trace import lane_methods, lanes
from rattle.trace.copying import bind
from rattle.trace.elementary import lower
from rattle.trace.lane_control import Status
from rattle.trace.lane_program import Program

if TYPE_CHECKING:
    from rattle.mechanism import Mechanism

log = logging.getLogger("rattle")

RTOL = 1e-8
MOST_OPERATIONS = 20_000  # of right-hand side, projection and curves; beyond, machine code is slow to make
METHODS = {"dop853": lane_methods.DOP853, "rk4": lane_methods.RK4}
POINTS = 2000  # output intervals of a generic run, whose curves are reduced afterwards; short steps side by side


@dataclass(frozen=True, eq=False)
class Many:
    """Outputs of many samples: `found["max(O3.force)"]` is an array (n,) [SI], nan where it has no finite value."""

    outputs: tuple[str, ...]
    units: dict[str, str]  # SI unit of every output
    samples: dict[str, np.ndarray]  # parameter: (n,) values [SI]
    values: np.ndarray  # (outputs, n)
    messages: dict[int, str]  # of the samples that failed: no run, or an output without a finite value
    generic: np.ndarray  # numbers of the samples that the generic kernels ran
    stats: dict[str, Any]

    def __getitem__(self, output: str) -> np.ndarray:
        if output not in self.outputs:
            raise UnknownName(f"no output '{output}'{suggest(output, self.outputs)}")
        found: np.ndarray = self.values[self.outputs.index(output)]
        return found

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

    def __str__(self) -> str:
        said = [f"{len(self)} samples of {', '.join(self.samples)}; {len(self.messages)} failed", self.stats["how"]]
        for output, row in zip(self.outputs, self.values, strict=True):
            said.append(f"{output} [{self.units[output] or '-'}]: {_span(row)}")
        return "\n".join(said)


def _span(row: np.ndarray) -> str:
    known = row[np.isfinite(row)]
    return f"{known.min():.6g} to {known.max():.6g}, mean {known.mean():.6g}" if len(known) else "no values"


@dataclass(frozen=True)
class _Task:
    """What is asked of every sample."""

    mechanism: Mechanism
    samples: dict[str, np.ndarray]
    outputs: list[Output]
    t_end: float
    method: str
    rtol: float
    atol: float
    step: float | None
    threads: int

    @property
    def count(self) -> int:
        return len(next(iter(self.samples.values())))

    def at(self, n: int) -> dict[str, float]:
        """Parameters of a sample [SI]."""
        return {name: float(values[n]) for name, values in self.samples.items()}


def many(
    m: Mechanism, samples: Mapping[str, Any], outputs: Sequence[str], *, t_end: float | None = None,
    rtol: float | None = None, atol: float | None = None, method: str | None = None, step: float | None = None,
    threads: int | None = None, progress: bool = False,
) -> Many:  # fmt: skip
    """Outputs of every sample; see `Mechanism.many`."""
    settings = m.model.settings
    given = _samples(m, samples)
    texts = [] if isinstance(outputs, str) else list(outputs)
    if not texts or not all(isinstance(one, str) for one in texts):
        raise ValueError('outputs: expected a list such as ["max(abs(O3.normal))"]')
    end = arguments.positive("t_end", settings.t_end if t_end is None else t_end)
    asked = settings.method if method is None else method
    if asked not in kinds("stepper"):
        raise ValueError(f"unknown method '{asked}'; expected {' or '.join(kinds('stepper'))}")
    rtol = arguments.relative_tolerance(RTOL if rtol is None else rtol)
    atol = arguments.positive("atol", ATOL * rtol if atol is None else atol)
    step_given, step = step, settings.step if step is None else arguments.positive("step", step)
    known = _known(m)
    read_outputs = [read(text, known) for text in texts]
    if not any(output.reductions for output in read_outputs):
        raise ValueError(f"outputs: {texts[0]!r} follows from parameters alone; ask for a number of a run")
    varied = m.following(given)
    for key, one in (("t_end", t_end), ("step", step_given)):
        if one is None and (differ := sorted(m.names_in_setting(key) & varied)):
            raise ValueError(
                f"{key} follows from {', '.join(differ)} and would differ from sample to sample; give {key}"
            )
    fixed = {name: value for name, value in m.parameters.items() if name not in varied}
    if late := next((said for output in read_outputs if (said := _outside(output, fixed, end))), ""):
        raise ValueError(late)
    threads = min(8, os.cpu_count() or 1) if threads is None else arguments.whole("threads", threads, 1)
    threads = min(threads, len(next(iter(given.values()))))
    task = _Task(m, given, read_outputs, end, asked, rtol, atol, step, threads)
    found = _Found(task)
    why = _side_by_side(task, found, progress)
    _one_by_one(task, found, progress)
    return found.result(why)


def _samples(m: Mechanism, samples: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Checked samples: arrays (n,) by parameter."""
    require_parameters(m.system, list(samples))
    if not samples:
        raise ValueError("samples: expected at least one parameter with its values")
    found: dict[str, np.ndarray] = {
        name: np.ma.asarray(values, dtype=float).filled(np.nan) for name, values in samples.items()
    }
    shapes = {name: values.shape for name, values in found.items()}
    if any(len(shape) != 1 or not shape[0] for shape in shapes.values()) or len(set(shapes.values())) > 1:
        said = ", ".join(f"{name}: {shape}" for name, shape in shapes.items())
        raise ValueError(f"samples: expected arrays of one length n, at least 1, for every parameter; got {said}")
    return found


def _outside(output: Output, parameters: Mapping[str, float], end: float) -> str:
    """What is said of an instant outside the run, "" if there is none; those of other parameters are not looked at."""
    for one in output.reductions:
        if one.kind == "at" and one.argument is not None and set(names(one.argument)) <= parameters.keys():
            instant = argument(one, parameters)
            if not 0.0 <= instant <= end:
                return f"{output.text}: the instant {instant:g} s is not between 0 and t_end = {end:g} s"
    return ""


def _known(m: Mechanism) -> Known:
    """Names that outputs may use."""
    _, names, units = columns(m.system, np.zeros((1, width(m.system))))
    parameters = {name: one.unit for name, one in m.model.parameters.items()}
    loose = [name for name, joint in m.model.joints.items() if joint.clearance > 0.0]
    derived = {name: "N" if name.endswith(".force") else "m" for name in derived_names(m.model, names)}
    return Known({name: units[name] for name in names} | derived, parameters, loose)


class _Found:
    """What is known of the samples so far."""

    def __init__(self, task: _Task) -> None:
        self.task = task
        self.values = np.full((len(task.outputs), task.count), np.nan)
        self.open = np.ones(task.count, dtype=bool)  # still to be run
        self.messages: dict[int, str] = {}
        self.generic: list[int] = []
        self.stats: dict[str, Any] = {"steps": 0, "evaluations": 0, "reasons": {}}

    def reduce(self, output: int, rows: Sequence[np.ndarray], dependent: Mapping[str, np.ndarray]) -> None:
        """Enter an output of all samples from the values of its reductions.

        dependent: values (n,) of parameters that follow from those that differ [SI].
        """
        task = self.task
        known: dict[str, Any] = {**task.mechanism.parameters, **dependent, **task.samples}
        known |= {f"#{k}": row for k, row in enumerate(rows)}
        made = arrays.evaluate(task.outputs[output].outer, known.__getitem__)
        self.values[output] = np.where(np.isfinite(rows).all(axis=0), made, np.nan)

    def result(self, why: str) -> Many:
        """All that was found."""
        task, generic = self.task, np.array(self.generic, dtype=np.int64)
        self.values[:, list(self.messages)] = np.nan
        self.values[~np.isfinite(self.values)] = np.nan
        counted = [not any(part.kind == "first" for part in one.reductions) for one in task.outputs]  # nan says: never
        lacks = np.isnan(self.values) & np.array(counted)[:, None]
        for n in np.flatnonzero(lacks.any(axis=0)):
            lacking = ", ".join(task.outputs[k].text for k in np.flatnonzero(lacks[:, n]))
            self.messages.setdefault(int(n), f"no finite value: {lacking}")
        side = task.count - len(generic)
        parts = [f"{side} run side by side" if side else "", f"{len(generic)} one by one" if len(generic) else ""]
        reasons = dict.fromkeys([why, *self.stats["reasons"]])
        because = "; ".join(one for one in reasons if one) if len(generic) else ""
        self.stats["how"] = ", ".join(part for part in parts if part) + (f": {because}" if because else "")
        texts = [one.text for one in task.outputs]
        units = {one.text: one.unit for one in task.outputs}
        return Many(tuple(texts), units, task.samples, self.values, self.messages, generic, self.stats)


# ---------------------------------------------------------------- side by side
def _side_by_side(task: _Task, found: _Found, progress: bool) -> str:
    """Run what lanes can run; returns why they cannot, "" if they can."""
    why = next((why for one in task.outputs if (why := why_not_lanes(one, task.samples))), "")
    method = "dop853" if task.method == usual_stepper(FREE) else task.method
    if why or method not in METHODS:
        return why or f"'{task.method}' has no straight-line code"
    if task.mechanism.system.switches:
        names = ", ".join(sorted({one.name for one in task.mechanism.system.switches}))
        return f"steps must end where expressions switch ({names})"
    try:
        model = task.mechanism.recorded(list(task.samples))
    except TraceError as error:
        return str(error)
    follow = {**task.samples, **model.dependent}
    if why := next((why for one in task.outputs if (why := why_not_lanes(one, follow))), ""):
        return why
    size = model.graph.count([*model.derivative, *model.projection])
    if size > MOST_OPERATIONS:
        return f"its {size} operations are more than the {MOST_OPERATIONS} up to which straight-line code pays"
    _run_lanes(task, found, model, method, progress)
    return ""


def _run_lanes(task: _Task, found: _Found, model: RecordedModel, method: str, progress: bool) -> None:
    functions = MachineFunctions()
    asked = Asked(model, task.outputs)
    longest = task.t_end / POINTS if needs_short_steps(task.outputs, model) else np.inf
    program = Program(
        lane_model(model, asked, functions.add, Starts(model, functions.add)), functions.add,
        METHODS[method], asked.reductions, task.t_end,
        tolerances=lane_methods.Tolerances(task.rtol, task.atol, min(task.step or np.inf, longest)),
        step=min(task.step or LONGEST, longest), chain=functions.chain, tiled=True,
    )  # fmt: skip
    functions.compile()
    bar = _Bar(task.count) if progress else None
    try:
        outcome = lanes.run(program, np.array(list(task.samples.values())), threads=task.threads, progress=bar)
    finally:
        if bar is not None:
            bar.close()
    dependent = _dependent(model, task)
    for n, rows in enumerate(asked.rows):
        found.reduce(n, [outcome.values[k] for k in rows], dependent)
    found.open = outcome.status != Status.DONE
    found.stats["steps"], found.stats["evaluations"] = int(outcome.steps.sum()), outcome.evaluations
    for status in np.unique(outcome.status[found.open]):
        count = int((outcome.status == status).sum())
        found.stats["reasons"][f"{count} {'samples' if count > 1 else 'sample'}: {Status(int(status)).words}"] = count


def _dependent(model: RecordedModel, task: _Task) -> dict[str, np.ndarray]:
    """Values (n,) of the parameters outside of reductions that follow from those that differ [SI]."""
    used = sorted({name for output in task.outputs for name in names(output.outer)} & model.dependent.keys())
    graph, symbols = lower(model.graph, [model.dependent[name] for name in used])
    first = 1 + model.state_size  # after t and y
    chosen = range(first, first + len(task.samples))
    others = {place: 0.0 for n, place in enumerate(graph.inputs) if n not in chosen}  # no parameter follows from them
    found = np.empty((0, task.count))
    if used:
        graph, symbols = bind(graph, symbols, others)
        found = graph.evaluate(symbols, list(task.samples.values()))
    return dict(zip(used, found, strict=True))


# ---------------------------------------------------------------- one by one
def _one_by_one(task: _Task, found: _Found, progress: bool) -> None:
    """Run the samples that are still open by the generic kernels."""
    waiting = np.flatnonzero(found.open)
    bar = _Bar(len(waiting)) if progress and len(waiting) else None
    said = _SaidOnce()
    log.addFilter(said)
    try:
        for done, n in enumerate(waiting):
            found.generic.append(int(n))
            try:
                found.values[:, n] = _run(task, task.at(int(n)))
            except (ModelError, AssemblyError, SolverError) as error:
                found.messages[int(n)] = str(error)
            if bar is not None:
                bar(done + 1, len(waiting))
    finally:
        log.removeFilter(said)
        if bar is not None:
            bar.close()


class _SaidOnce(logging.Filter):
    """Lets pass what is said of the model, once for all samples; why a sample failed is in its message."""

    def __init__(self) -> None:
        super().__init__()
        self._known: set[str] = set()

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether to let it pass."""
        text, known = record.getMessage(), self._known
        new = record.levelno < logging.ERROR and text not in known
        known.add(text)
        return new


def _run(task: _Task, parameters: dict[str, float]) -> list[float]:
    """The outputs of one sample."""
    bad = [name for name, value in parameters.items() if not np.isfinite(value)]
    if bad:
        said = f"{parameters[bad[0]]} is not a finite number"
        raise ModelError([Problem(("parameters", bad[0]), said)])
    one = task.mechanism.set(parameters)
    if late := next((said for output in task.outputs if (said := _outside(output, one.parameters, task.t_end))), ""):
        raise ModelError([Problem((), late)])
    instants = {t for output in task.outputs for t in needed_instants(output, one.parameters)}
    times = np.array(sorted({*np.linspace(0.0, task.t_end, POINTS + 1).tolist(), *instants}))

    def simulate(mechanism: Mechanism) -> Any:
        try:
            return mechanism.simulate(
                task.t_end, t_eval=times, method=task.method, rtol=task.rtol, atol=task.atol, step=task.step,
                strict=True,
            )  # fmt: skip
        except SolverError as error:
            if error.result.interrupted:  # the user stops all samples
                raise KeyboardInterrupt from None
            raise

    result = simulate(one)
    ideal = simulate(one.ideal()) if any(output.ideal_names for output in task.outputs) else None
    return [evaluate(output, result, one.parameters, ideal) for output in task.outputs]


class _Bar:
    """A progress bar over samples, called with those done and all."""

    def __init__(self, total: int) -> None:
        from tqdm import tqdm

        self._bar = tqdm(total=total, desc="many", unit="sample", delay=1.0)

    def __call__(self, done: int, total: int) -> None:
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        self._bar.close()
