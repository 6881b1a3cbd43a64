"""What becomes of a step, as one graph: accepted or not, the rows of the reductions, the next stop, or the end.

So a batch takes many steps without Python: everything that it must know stands in its rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import NamedTuple

from rattle.language.recorded import Flag, Operand
from rattle.solvers.step_size import LEAST
from rattle.trace.graph import apply, both, select
from rattle.trace.lane_contacts import Meets, one
from rattle.trace.lane_methods import PLAN, PLANNED, Recorded, flag, inputs, least
from rattle.trace.lane_turns import Instant, Lane, Meeting
from rattle.trace.reductions import Ledger, Step

VERDICT = ("ahead", "accepted")  # see `judge`
FLAGS = ("curves sound", "curves finite", "kept", "sound", "finite")  # see `curve_checks`, `checks`
CONTROL = ("running", "status", "number", "steps", "tries", *PLAN)  # of a lane; number: of the next stop
RUNNING, STATUS, NUMBER, STEPS, TRIES = range(5)
SHORTENED = 1e-9  # share of a run: a shorter try whose stages fail beside a contact fails by itself
SHORT = 2000.0  # steps of a run where long ones would miss something
GOING_ON = -1.0  # status of a lane that is running


class Status(IntEnum):
    """How the run of a sample ended; `words` says it."""

    DONE = 0
    START = 1
    ASSUMPTION = 2
    NOT_FINITE = 3
    ENERGY = 4
    TOO_MANY_STEPS = 5
    STEP_TOO_SMALL = 6
    CONTACTS = 7
    PRESSED = 8
    JOLT = 9
    RESTS = 10
    AT_STOP = 11
    CROWDED = 12
    TOO_CROWDED = 13

    @property
    def words(self) -> str:
        """As part of a message."""
        return WORDS[self]


WORDS = {
    Status.DONE: "done",
    Status.START: "has no start (values out of range, loops that do not close), or another form (as without friction)",
    Status.ASSUMPTION: "comes next to a singular position, coincident points or the end of a segment, which"
    " straight-line code cannot pass",
    Status.NOT_FINITE: "has no finite value: a load or curve outside its domain, or a diverging motion",
    Status.ENERGY: "has an energy error above the limit",
    Status.TOO_MANY_STEPS: "takes too many steps",
    Status.STEP_TOO_SMALL: "needs steps that are too short",
    Status.CONTACTS: "comes to contacts, stick or slip that do not settle, or not in one way",
    Status.CROWDED: "comes to three contacts at once, which with friction in joints or after Poisson only single runs"
    " follow",
    Status.TOO_CROWDED: "comes to more contacts at once than straight-line code follows",
    Status.PRESSED: "is pressed into a wall at its start",
    Status.JOLT: "comes to a jump of a driver or its speed, or of gravity, which only single runs follow",
    Status.AT_STOP: "has an expression that jumps just where it ends or is read off: single runs tell what is after it",
    Status.RESTS: "rests where an expression jumps (as floor(t) > 0 does), which only single runs follow",
}


class Stops(NamedTuple):
    """Instants [s] at which steps end, the last one is the end; equal steps before each, numbers and lengths [s]; how
    long a step is at most where long ones would miss something [s]."""

    instants: Sequence[float]
    counts: Sequence[float]
    lengths: Sequence[float]
    short: float


def report_rows(ledger: Ledger, meets: Meets | None = None) -> list[int]:
    """Numbers of rows that `settle` reads: PLANNED, VERDICT, FLAGS; extremes of watched curves in the stages; `Met`,
    `Ends`, `Struck` of contacts; crossings; curves after the start, at it; `Touch`; rows; CONTROL."""
    wide = ledger.curves + 1
    first = len(PLANNED) + len(VERDICT) + len(FLAGS)
    return [
        first,
        2 * len(ledger.watched),
        0 if meets is None else meets.met_rows,
        0 if meets is None else meets.end_rows,
        0 if meets is None else meets.struck_rows,
        2 * len(ledger.conditions),
        ledger.parts * wide,
        wide,
        0 if meets is None else meets.touch_rows,
        ledger.rows,
        len(CONTROL),
    ]


def settle(ledger: Ledger, stops: Stops, adaptive: bool, most_steps: int, meets: Meets | None = None) -> Recorded:
    """Rows as in `report_rows`: flags that the step is good, that it asks for samples; curves at the start, `Touch`,
    rows, CONTROL of the next one."""
    parts = report_rows(ledger, meets)
    graph, row = inputs(sum(parts))
    proposed, shown, met, ends, struck, crossed, after, curves, touch, held, control = (
        row[sum(parts[:n]) : sum(parts[: n + 1])] for n in range(len(parts))
    )
    h, t_new, last, short, _, ahead, *flags = proposed
    running, status, number, steps, tries, t, *_ = control
    running, accepted, short, last = (flag(graph, x) for x in (running, flags[0], short, last))
    fits, still = accepted, flag(graph, control[-2])
    curves_sound, curves_finite, kept, sound, finite = (flag(graph, x) for x in flags[1:])
    shortened = still | (h <= SHORTENED * stops.instants[-1])
    planned = control[len(CONTROL) - len(PLAN) + 1]
    meeting = None if meets is None else Meeting(meets, touch, ends, met, struck, Instant(t_new, still, planned))
    if meeting is not None:
        fits = fits & kept  # stages of a try that goes far beyond a contact say nothing
        accepted = (fits & apply("not", meeting.met.cut > 0.0)) | (still & kept)
    samples = _samples(ledger, curves, after, still, meets)
    crossings = {curve: (crossed[2 * n], crossed[2 * n + 1]) for n, curve in enumerate(ledger.conditions)}
    seen = dict(zip(ledger.watched, zip(shown, shown[len(ledger.watched) :], strict=False), strict=True))
    at_start = still & (t_new <= 0.0) if meets is not None else False
    touches = None if meeting is None else meeting.touches(at_start)
    rows, asks = ledger.advance(Step(h, t, t_new, number, last, samples, crossings, seen, touches), held, at_start)
    accounted = flag(graph, rows[ledger.sound_row]) if ledger.sound_row is not None else True
    reached = _last(
        (tries >= float(most_steps), Status.TOO_MANY_STEPS), (accepted & apply("not", accounted), Status.ENERGY),
        (accepted & apply("not", sound & curves_sound), Status.ASSUMPTION),
        (accepted & apply("not", finite & curves_finite), Status.NOT_FINITE),
        (apply("not", kept) & (True if meeting is None else shortened), Status.ASSUMPTION),
        (short, Status.STEP_TOO_SMALL),
    )  # fmt: skip
    good = both(graph, [running, accepted, reached < 0.0])
    turned = None
    if meeting is not None:
        ahead = select(kept, ahead, least(ahead, LEAST * h))
        lane = Lane(running, good, fits, still, control[-1], ahead, planned, kept)
        turned = meeting.turn(proposed, lane)
        reached = select(turned.lost, float(Status.CONTACTS), reached)
        reached = select(turned.crowded > 0.5, float(Status.CROWDED), reached)
        reached = select(turned.crowded > 1.5, float(Status.TOO_CROWDED), reached)
        reached = select(turned.rests, float(Status.RESTS), reached)
        reached = select(turned.switched & last, float(Status.AT_STOP), reached)
        reached = select(turned.jolted, float(Status.JOLT), reached)
        reached = select(turned.unkept, float(Status.ASSUMPTION), reached)
        ahead = meeting.ahead(turned, stops.short)
    landed = good & last
    number = number + one(landed)
    through = landed & (number >= float(len(stops.instants))) & (reached < 0.0)
    reached = select(through, float(Status.DONE), reached)
    going = one(running & (reached < 0.0))
    plan = _plan(stops, adaptive, landed, number, control[len(CONTROL) - len(PLAN) :])
    plan[0], plan[4] = select(good, t_new, t), plan[4] + one(good & apply("not", landed))
    if adaptive:
        plan[1] = select(running, ahead, plan[1])
    taken = good
    if turned is not None:
        plan[-2], plan[-1], taken = turned.still, turned.landing, good & apply("not", still)
    controlled = [going, select(running, reached, status), number, steps + one(taken), tries + one(running), *plan]
    counts = good if turned is None else good & (turned.decided | apply("not", still))  # no mode that is only tried
    last_curves = _kept(good, after[-len(curves) :], curves)
    counting = ledger.counting  # contacts begin whatever follows
    rows = [select(good if k in counting else counts, a, b) for k, (a, b) in enumerate(zip(rows, held, strict=True))]
    return graph, [good, taken & asks, *last_curves, *(turned.touch if turned else ()), *rows, *controlled]


def _samples(
    ledger: Ledger, curves: Sequence[Operand], after: Sequence[Operand], still: Flag, meets: Meets | None
) -> list[list[Operand]]:
    """Curves in the step, from its start on; where no time passes, what holds from then on counts alone."""
    wide = ledger.curves + 1
    samples = [[curves[n], *after[n::wide]] for n in range(ledger.curves)]
    if meets is None:
        return samples
    return [[select(still, row[-1], x) for x in row] for row in samples]


def _kept(good: Flag, new: Sequence[Operand], old: Sequence[Operand]) -> list[Operand]:
    """New rows where they count."""
    return [select(good, a, b) for a, b in zip(new, old, strict=True)]


def _last(*fails: tuple[Flag, Status]) -> Operand:
    """The status of the last of these that holds; else the lane is going on."""
    reached: Operand = GOING_ON
    for holds, why in fails:
        reached = select(holds, float(why), reached)
    return reached


def _plan(stops: Stops, adaptive: bool, landed: Flag, number: Operand, plan: Sequence[Operand]) -> list[Operand]:
    """PLAN after landing at a stop: the next one is ahead."""
    t, ahead, stop, base, done, count, still, landing = plan
    done = select(landed, 0.0, done)
    for n in range(1, len(stops.instants)):
        here = landed & apply("equal", number, float(n))
        stop, base = select(here, stops.instants[n], stop), select(here, stops.instants[n - 1], base)
        if not adaptive:
            ahead, count = select(here, stops.lengths[n], ahead), select(here, stops.counts[n], count)
    return [t, ahead, stop, base, done, count, still, landing]
