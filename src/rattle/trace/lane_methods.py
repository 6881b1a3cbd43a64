"""Time integration methods as graphs: stages, errors, step lengths and dense output of samples side by side.

Graphs of state components take one component in a column, so that they are the same for every model.  Time is the first
component, with slope 1.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), sections II.1, II.4, II.6, II.10.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Sequence
from types import SimpleNamespace
from typing import NamedTuple

from rattle.language.recorded import Flag, Operand
from rattle.solvers import step_size
from rattle.solvers.tableau import Tableau
from rattle.trace.elementary import lower
from rattle.trace.graph import Graph, apply, both, select
from rattle.trace.recording import Recorder

SHORTEST, SHORTEST_OF_RUN = 1e-15, 1e-16  # steps that a float can hardly tell from none: shares of t, of the run
WHOLE = 1e-9  # share of a step by which a span may be longer than so many of them: rounding of both

Recorded = tuple[Graph, list[Operand]]  # a graph of exact operations, and its outputs


class Method:
    """A tableau as lanes use it; stage `stages` is the right-hand side at the end of the step."""

    def __init__(self, tableau: Tableau, safety: float = step_size.SAFETY_OF_LANES) -> None:
        """safety: share of the step that would just fulfil the tolerance, to be tried next."""
        self.safety = safety
        self.tableau, self.stages, self.adaptive = tableau, tableau.stages, tableau.adaptive
        self.slopes = max(len(tableau.c), tableau.stages + 1)  # of all stages, those for the dense output included
        self.rows: list[list[float]] = tableau.a.tolist()
        self.weights: list[float] = tableau.ends[0].tolist()
        self.errors: list[list[float]] = tableau.ends[1:].tolist()
        self.upper = [list(row) for row in tableau.dense]  # rows of the dense output above the cubic
        # equal parts of a step, at whose ends curves are sampled: those of `reductions.COTES`
        self.samples = 6 if tableau.order > 4 else 2
        inner = [s for s in range(1, self.stages) if 0.0 < tableau.c[s] < 1.0] or [self.stages - 1]
        # stages, spread over the step, that show how large a curve may become in it
        near = (min(reversed(inner), key=lambda s: abs(tableau.c[s] - share)) for share in SPREAD)
        self.seen = sorted(set(near))

    @property
    def dense_slopes(self) -> list[int]:
        """Stages up to `stages` whose slopes the dense output takes."""
        rows = [*self.rows[self.stages + 1 :], *self.upper]
        used = {s for row in rows for s, weight in enumerate(row[: self.stages]) if weight != 0.0}
        return sorted(used | {0, self.stages})


SPREAD = (0.125, 0.375, 0.625, 0.875)


class Tolerances(NamedTuple):
    """What an adaptive method asks for, see `rattle.solvers.stepper`."""

    rtol: float
    atol: float
    h_max: float = math.inf  # [s]


def weighted(weights: Sequence[float], terms: Sequence[Operand]) -> Operand:
    """The sum of terms with weights, from left to right; zero weights take no operation."""
    total: Operand = 0.0
    for weight, term in zip(weights, terms, strict=False):
        if weight != 0.0:
            total = total + weight * term
    return total


def total(terms: Sequence[Operand]) -> Operand:
    """The sum of terms from left to right."""
    return weighted([1.0] * len(terms), terms)


def root(x: Operand) -> Operand:
    """Square root."""
    return apply("sqrt", x)


def least(a: Operand, b: Operand) -> Operand:
    """The smaller one."""
    return select(b < a, b, a)


def largest(a: Operand, b: Operand) -> Operand:
    """The larger one."""
    return select(b > a, b, a)


def extremes(terms: Sequence[Operand]) -> tuple[Operand, Operand]:
    """The least and the largest one."""
    return functools.reduce(least, terms), functools.reduce(largest, terms)


def inputs(count: int) -> tuple[Graph, list[Operand]]:
    """A new graph with inputs."""
    graph = Graph()
    return graph, [graph.input() for _ in range(count)]


# ---------------------------------------------------------------- components of the state
def stage(method: Method, s: int) -> Recorded:
    """h, y, slopes 0 to s - 1: the state of stage s."""
    graph, (h, y, *k) = inputs(2 + s)
    return graph, [y + h * weighted(method.rows[s], k)]


def end(method: Method, tolerances: Tolerances) -> Recorded:
    """h, y, slopes of the stages: the state at the end; squares of its errors as shares of the tolerance."""
    graph, (h, y, *k) = inputs(2 + method.stages)
    y_new = y + h * weighted(method.weights, k)
    if not method.adaptive:
        return graph, [y_new]
    scale = tolerances.atol + tolerances.rtol * largest(abs(y), abs(y_new))
    return graph, [y_new, *((weighted(e, k) / scale) ** 2 for e in method.errors)]


def dense(method: Method, parts: int) -> Recorded:
    """y at the end, h, y, all slopes: y, rows of the dense output, states between equal parts of the step."""
    graph, (y_new, h, y, *k) = inputs(3 + method.slopes)
    jump = y_new - y
    rows = [jump, h * k[0] - jump, 2.0 * jump - h * (k[method.stages] + k[0])]
    rows += [h * weighted(d, k) for d in method.upper]
    return graph, [y, *rows, *(_inside(n / parts, y, rows) for n in range(1, parts))]


def inside(method: Method) -> Recorded:
    """Share theta of the step, y, rows of the dense output: the state at theta."""
    graph, (theta, y, *rows) = inputs(5 + len(method.upper))
    return graph, [_inside(theta, y, rows)]


def _inside(theta: Operand, y: Operand, rows: Sequence[Operand]) -> Operand:
    rest = 1.0 - theta
    value: Operand = 0.0
    for n in reversed(range(len(rows))):  # factors theta and 1 - theta in turn
        value = (rows[n] + value) * (theta if n % 2 == 0 else rest)
    return y + value


# ---------------------------------------------------------------- rows as they are
def spread(count: int) -> Recorded:
    """One row, as many times."""
    graph, (row,) = inputs(1)
    return graph, [row] * count


def copied(count: int) -> Recorded:
    """Rows as they are."""
    graph, rows = inputs(count)
    return graph, rows


# ---------------------------------------------------------------- steps
def size(graph: Graph) -> SimpleNamespace:
    """The functions of `rattle.solvers.step_size` for symbols of a graph."""
    recorder = Recorder(graph)
    names = ("error_share", "shorter", "longer", "trial_step", "first_length")
    return SimpleNamespace(**{name: recorder.recorded(getattr(step_size, name).python) for name in names})


# t, length of the next step, next instant to stop at, and for equal steps: their start, number so far, number in all;
# of contacts, see `lane_contacts`: a trip that takes no time, number of tries that were to end at one
PLAN = ("t", "ahead", "stop", "base", "done", "count", "still", "landing")
PLANNED = ("h", "t_new", "last", "short", "ahead")
NEARLY = 1.000001  # a step that would end as near to a stop ends there


def plan(method: Method, t_end: float, contacts: bool = False) -> Recorded:
    """PLAN: the step (PLANNED): length, end, flags: it ends at the stop; it is too short to be taken; `ahead`.

    contacts: whether lanes land at contacts.
    """
    graph, (t, ahead, stop, base, done, count, still, landing) = inputs(len(PLAN))
    if not method.adaptive:
        last = done + 1.0 >= count
        return graph, [ahead, select(last, stop, base + (done + 1.0) * ahead), last, 0.0, ahead]
    last = t + (select(landing > 0.0, 1.0, NEARLY) if contacts else NEARLY) * ahead >= stop
    h = select(last, stop - t, ahead)
    short = (h <= SHORTEST * abs(t)) | (h <= SHORTEST_OF_RUN * t_end) | apply("not", t + h > t)
    if not contacts:
        return graph, [h, select(last, stop, t + h), last, short, ahead]
    moves = apply("not", still > 0.0)  # a contact may end a step just before a stop
    last, short = last & moves, short & moves & apply("not", last)
    h = select(moves, h, 0.0)
    return graph, [h, select(last, stop, t + h), last, short, ahead]


def judge(method: Method, tolerances: Tolerances, ny: int, controlled: Sequence[int], motion: int) -> Recorded:
    """Squares of the errors of t and y, PLANNED: the length of the next step, and a flag: this one is accepted.

    controlled: components of y whose errors count; motion: the number over which they are averaged.
    """
    squares = len(method.errors) * (1 + ny)
    graph, row = inputs(squares + len(PLANNED))
    h, _, last, _, ahead = row[squares:]
    if not method.adaptive:
        return graph, [ahead, 1.0]
    errors = [total([row[k * (1 + ny) + 1 + n] for n in controlled]) for k in range(len(method.errors))]
    error = size(graph).error_share(h, *errors, *[0.0] * (2 - len(errors)), float(motion))
    power, safety = method.tableau.order, method.safety
    shorter = size(graph).shorter(h, error, power, safety)
    longer = size(graph).longer(h, error, power, safety)
    longer = least(largest(longer, select(graph.apply("equal", last, 0.0), 0.0, ahead)), tolerances.h_max)
    accepted = error <= 1.0
    return lower(graph, [select(accepted, longer, shorter), accepted])


def finite_flag(graph: Graph, terms: Sequence[Operand]) -> Flag:
    """A flag: none of the terms is inf or nan."""
    return both(graph, [graph.apply("equal", x - x, 0.0) for x in terms])


def flag(graph: Graph, x: Operand) -> Flag:
    """A number as a flag: it is not 0."""
    return graph.apply("not", graph.apply("equal", x, 0.0))


def checks(method: Method, ny: int, later: Sequence[int], watched: int) -> Recorded:
    """Blocks of t, ny rows, a flag and watched curves (end, step, y, slopes): flags that stages, all of it, are sound;
    it is finite; the least values of the watched curves in the stages that see them, then the largest.

    later: stages for the dense output alone that were computed.
    """
    size = ny + 2 + watched
    count = 4 + method.stages + len(later)
    graph, row = inputs(count * size)
    block = [row[k * size + 1 : (k + 1) * size] for k in range(count)]
    kept = both(graph, [flag(graph, block[3 + s][ny]) for s in range(1, method.stages)])
    arrived = [block[0][ny], *(block[3 + s][ny] for s in (method.stages, *later))]
    sound = both(graph, [flag(graph, sample) for sample in arrived])
    finite = finite_flag(graph, [*block[0][:ny], *block[3 + method.stages][:ny]])
    seen = [extremes([block[3 + s][ny + 1 + n] for s in method.seen]) for n in range(watched)]
    return graph, [kept, sound, finite, *(low for low, _ in seen), *(high for _, high in seen)]


def curve_checks(parts: int, curves: int) -> Recorded:
    """Curves and flag at the ends of all parts of a step: flags that all are sound, and finite."""
    graph, row = inputs(parts * (curves + 1))
    return graph, [both(graph, [flag(graph, x) for x in row[curves :: curves + 1]]), finite_flag(graph, row)]


def merged(method: Method) -> Recorded:
    """End, flag that it is good, y, slopes to the last stage: y and first slope with which to go on."""
    graph, (end, good, y, *k) = inputs(4 + method.stages)
    taken = flag(graph, good)
    return graph, [select(taken, end, y), select(taken, k[method.stages], k[0])]


def first_try(tolerances: Tolerances, ny: int, motion: int, t_end: float) -> Recorded:
    """y, slopes: a short first step, the squared norm of the slopes, and the state after the step."""
    graph, row = inputs(2 * ny)
    y, f = row[:ny], row[ny:]
    scales = [tolerances.atol + tolerances.rtol * abs(value) for value in y[:motion]]
    still, slope = (total([(x / s) ** 2 for x, s in zip(vector, scales, strict=False)]) for vector in (y, f))
    h = size(graph).trial_step(still, slope, min(tolerances.h_max, t_end))
    return graph, [h, slope, *(value + h * rate for value, rate in zip(y, f, strict=True))]


def first_step(method: Method, tolerances: Tolerances, ny: int, motion: int, t_end: float) -> Recorded:
    """y, slopes, flag, slopes after the short step, flag, that step, squared norm of the slopes: the first step."""
    graph, row = inputs(3 * ny + 4)
    y, f, later, h, slope = row[:ny], row[ny : 2 * ny], row[2 * ny + 1 : 3 * ny + 1], *row[3 * ny + 2 :]
    bend = total([
        ((later[n] - f[n]) / (tolerances.atol + tolerances.rtol * abs(y[n]))) ** 2 for n in range(motion)
    ])  # fmt: skip
    longest = min(tolerances.h_max, t_end)
    return lower(graph, [size(graph).first_length(h, slope, bend, motion, method.tableau.order, longest)])


def segments(stops: Sequence[float], step: float) -> tuple[list[int], list[float]]:
    """Numbers and lengths [s] of the equal steps that end at each stop in turn, none longer than `step`."""
    spans = [b - a for a, b in itertools.pairwise((0.0, *stops))]
    counts = [max(1, math.ceil(span / step - WHOLE)) for span in spans]
    return counts, [span / count for span, count in zip(spans, counts, strict=True)]
