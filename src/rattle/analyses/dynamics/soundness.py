"""Whether a run can be trusted: the measures of its drift and its energy error, and why it ended where it did.

Drift in metres is measured in extents of the mechanism, drift in radians in rad, and the unexplained energy in
shares of the largest of kinetic energy, work and range of the potential (docs/theory.md, section 9).  A run ends before
the step that would exceed `LIMIT`; errors above `SAID` are reported.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import numpy as np

from rattle.analyses.assembly.assembly import Assembled
from rattle.analyses.assembly.driver_conflicts import contradicted
from rattle.analyses.assembly.rank import describe_rank_loss, unlike_masses
from rattle.analyses.dynamics.failure import not_finite
from rattle.description.model import Point
from rattle.elements.custom import load_law
from rattle.equations.motion import drive
from rattle.equations.system import System
from rattle.interfaces.steppers import StepperKind
from rattle.jit import layout as at
from rattle.jit.choices import TINY
from rattle.jit.workspace import Workspace
from rattle.registry import Kind
from rattle.results.columns import width
from rattle.solvers import step_audit
from rattle.solvers.output_row import record

LIMIT = 1e-3  # largest share of its measure for drift; that for the energy error is given by the stepper
SAID = 1e-6  # share above which an error is reported
SUNK = 0.01  # penetration of a contact that is not located, as a share of its clearance, above which it is reported
NEARLY = 2e-2  # share of the largest singular value below which a run that ended was about to lose rank
LOOSE = 1e-6  # rtol above which short contacts may be missed
SWIFT = 1000.0  # speed of a massless link, in speeds of the driver, that is not credible; a few hundred are usual
CREEPING = 200_000  # steps in which a run must advance by more than
STALLED, HARDLY = 20_000, 1e-6  # the same where it has nearly stopped
LEAST_GONE = 1e-4  # this share of its time, unless the user limits the number of steps
FOLLOWED = 1e-3  # clearances in a step from which on the motion of a pin in its bush is what keeps steps short
FAR = 1e6  # distance from the origin, in sizes, at which too few digits are left for the motion
NEAR = 1e-9  # share of an instant that a search for a jump reaches beyond it, at least
NEIGHBOURS = 4e-16  # share of an instant by which the next number follows it, two units in the last place
JUMPS = 1e-6  # change between neighbours that is a jump [rad, mechanism sizes; of speeds, share of the larger one]
SLOW = 1e-3  # speed [rad/s, mechanism sizes/s] with which slower ones are compared
SENTENCES = {  # of notes, also in pages
    "opened": "joints opened by {share:.2g} of the mechanism's size (or rad): {shorter} reduces this",
    "sunk": "contacts sank up to {percent:.2g} % of the clearance, or of the range between stops, into their walls:"
    " {method} detects contact only once per step, a shorter step detects it sooner",
    "energy_of_method": "energy error {share:.2g} of the largest energy: {method}, in proportion to its step",
    "energy": "energy error {share:.2g} of the largest energy: {shorter} reduces it",
    "opens": "'{joint}' would open by {share:.2g} {measure}",
    "unrest": "the energy error would be {percent:.2g} % of the largest energy",
    "ended": "ended at t = {t:.6g} s, before {what}: {cause}",
    "too_long": "the steps are too long for this motion at rtol = {rtol:g}; choose a smaller rtol or limit the step",
    "step_too_long": "the step of {step:.3g} s is far too long for this motion; choose a shorter step",
    "loose": "rtol = {rtol:g} is loose: short contacts may be missed and the horizon may be overestimated",
    "swift": "the massless link of '{joint}' turns at up to {rate:.2g} rad/s, {times:.2g} times as fast as {what}: this"
    " is not credible; it happens after a change point or with a tiny clearance. Use an impact or compliant contact"
    " there instead",
}
SHORTER = ("a shorter step", "a smaller rtol")  # what reduces errors of equal steps, of adaptive ones
OF_OPENING = ("of the mechanism's size", "rad")
FASTEST_BODY, ITS_DRIVER = "the fastest body at the start", "its driver"


class Running(Protocol):
    """The attributes of a run that are used here."""

    system: System
    workspace: Workspace
    start: Assembled
    clock: np.ndarray
    tally: np.ndarray
    t_end: float
    stepper: Kind[StepperKind]
    rtol: float
    most_steps: int | None

    def suspect(self, status: int) -> str:
        """What else may have stopped the run, in words."""


# ---------------------------------------------------------------- measures
def audit_arrays(system: System, energy_limit: float) -> dict[str, np.ndarray]:
    """Workspace arrays with which a run checks its steps, see `solvers.step_audit`; measures in 1/m, or -1 for rad.

    energy_limit: largest share [-] for the energy error, given by the stepper.
    """
    seen = np.zeros(at.width("audit"))
    seen[at.OPEN_LIMIT], seen[at.UNREST_LIMIT] = LIMIT, energy_limit
    return {"measure": np.array(measures_of_rows(system)), "audit": seen}


def measures_of_rows(system: System) -> list[float]:
    """What an opening of every constraint row is multiplied by [1/m], or -1 for rows in rad."""
    return [-1.0 if row.unit == "rad" else 1.0 / system.extent for row in system.rows]


def energy_share(seen: np.ndarray) -> float:
    """Largest energy error of a run as a share of the energy that it has exchanged, with what the tolerances allow.

    seen: `audit` at its end.
    """
    exchanged = seen[[at.MOST_KINETIC, at.MOST_WORK]].max()
    exchanged = max(exchanged, seen[at.MOST_POTENTIAL] - seen[at.LEAST_POTENTIAL]) + LIMIT * seen[at.FLOOR]
    return float(seen[at.MOST_UNREST] / exchanged) if exchanged > 0.0 else 0.0


# ---------------------------------------------------------------- notes
def remarks(system: System, workspace: Workspace, stepper: type[StepperKind]) -> tuple[str, ...]:
    """Notes on a run whose drift or energy error is more than rounding."""
    seen = workspace.audit
    notes = []
    opened = max(float(seen[at.OPEN_LENGTH]) / system.extent, float(seen[at.OPEN_ANGLE]))
    shorter = SHORTER[bool(stepper.adaptive)]
    if opened > SAID:
        notes.append(SENTENCES["opened"].format(share=opened, shorter=shorter))
    if seen[at.SUNK] > SUNK:
        notes.append(SENTENCES["sunk"].format(percent=100 * seen[at.SUNK], method=stepper.title))
    share = energy_share(seen)
    if share > SAID:
        of = "energy_of_method" if stepper.title else "energy"
        notes.append(SENTENCES[of].format(share=share, method=stepper.title, shorter=shorter))
    return tuple(notes)


def loose(stepper: type[StepperKind], rtol: float) -> tuple[str, ...]:
    """Note on a relative tolerance [-] with which short contacts may be missed."""
    if not stepper.adaptive or rtol <= LOOSE:
        return ()
    return (SENTENCES["loose"].format(rtol=rtol),)


def fast_links(system: System, data: np.ndarray, names: Sequence[str]) -> tuple[str, ...]:
    """Notes on massless links that turn incredibly fast for their mechanism; data: (n, len(names)) outputs [SI]."""
    if not len(data) or not system.watched:
        return ()
    curve = dict(zip(names, data.T, strict=True))
    usual = max(float(np.abs(curve[f"{body}.omega"][0])) for body in system.bodies)
    what = FASTEST_BODY
    drivers = _driver_rates(system)
    if drivers and max(drivers) > 0.0:
        usual, what = max(drivers), ITS_DRIVER
    notes = []
    for name in system.watched:
        joint = system.model.joints[name]
        ax, ay = _point_rate(curve, joint.a)
        bx, by = _point_rate(curve, joint.b)
        turning = np.abs(curve[f"{name}.ex"] * (by - ay) - curve[f"{name}.ey"] * (bx - ax)) / joint.clearance**2
        fastest = float(turning.max())
        if fastest > SWIFT * usual > 0.0:
            times = fastest / usual
            notes.append(SENTENCES["swift"].format(joint=name, rate=fastest, times=times, what=what))
    return tuple(notes)


def _driver_rates(system: System) -> list[float]:
    """Rates of all drivers at the start [rad/s]; speeds along a line are divided by the mechanism's size."""
    workspace = system.workspace()
    drive(workspace, 0.0)
    rates = []
    for name in system.model.drivers:
        rate = abs(float(workspace.values[system.driver_slot(name) + 1]))
        turns = system.rows[system.first_row(name)].unit == "rad"
        rates.append(rate if turns else rate / system.extent)
    return rates


def _point_rate(curve: Mapping[str, np.ndarray], point: Point) -> tuple[np.ndarray, np.ndarray]:
    """Velocity (n,), (n,) [m/s] of a point over time."""
    if point.body == "ground":
        return np.zeros(1), np.zeros(1)
    angle, omega = curve[f"{point.body}.angle"], curve[f"{point.body}.omega"]
    x = np.cos(angle) * point.at[0] - np.sin(angle) * point.at[1]
    y = np.sin(angle) * point.at[0] + np.cos(angle) * point.at[1]
    return curve[f"{point.body}.vx"] - omega * y, curve[f"{point.body}.vy"] + omega * x


def too_slow(run: Running, mark: tuple[int, float]) -> tuple[str, tuple[int, float]]:
    """Why a run without progress is ended ("" if it has progress), and the steps and time [s] from which to count next.

    mark: the steps and time [s] from which to count now.
    """
    steps, t = int(run.tally[at.STEPS]), float(run.clock[at.T])
    if run.most_steps is not None:
        done = f"ended at t = {t:.6g} s after {steps} steps, the limit given by most_steps"
        return (done if steps >= run.most_steps else ""), mark
    gone, ahead = t - mark[1], run.t_end - run.start.t
    stalled = steps - mark[0] >= STALLED and gone <= HARDLY * ahead
    if steps - mark[0] < CREEPING and not stalled:
        return ("", mark) if steps - mark[0] < STALLED or gone <= LEAST_GONE * ahead else ("", (steps, t))
    if gone > LEAST_GONE * ahead:
        return "", (steps, t)
    more = (run.t_end - t) / max(gone, TINY) * (steps - mark[0])
    return (
        f"ended at t = {t:.6g} s: the last {steps - mark[0]} steps covered {gone:.2g} s, the rest would take {more:.1g}"
        f" more. {_haste(run, gone / (steps - mark[0]))}; most_steps lets it go on"
    ), mark


def _haste(run: Running, step: float) -> str:
    """What keeps the steps [s] of a run short, in words, and what to change: a pin that goes round its bush, if any."""
    state, size = run.workspace.state, 3 * run.system.body_count
    curve = {
        f"{body}.{column}": state[n : n + 1]
        for first, columns in ((0, ("x", "y", "angle")), (size, ("vx", "vy", "omega")))
        for k, body in enumerate(run.system.bodies)
        for n, column in enumerate(columns, first + 3 * k)
    }
    play = [joint for joint in run.system.model.joints.values() if joint.kind == "revolute" and joint.clearance > 0.0]
    if not play:
        return "Look for lengths, masses or stiffnesses out of proportion"
    rates = []  # clearances per second
    for joint in play:
        (ax, ay), (bx, by) = _point_rate(curve, joint.a), _point_rate(curve, joint.b)
        rates.append(float(np.hypot(bx - ax, by - ay).max()) / joint.clearance)
    if max(rates) * step > FOLLOWED:
        busy = play[int(np.argmax(rates))]
        return (
            f"Steps follow the pin of joint '{busy.name}', which moves {max(rates):.2g} clearances in a second: give"
            " that joint a larger clearance or none, or end the run earlier"
        )
    least = min(play, key=lambda joint: joint.clearance)
    return (
        "Look for lengths, masses or stiffnesses out of proportion: the smallest clearance is that of joint"
        f" '{least.name}', {least.clearance:.2g} m"
    )


def why_unsound(run: Running) -> str:
    """Why a run ended at the last instant that can be trusted, in words.

    That steps are too long is said only where nothing else is known or suspected.
    """
    system, seen = run.system, run.workspace.audit
    t, ahead = float(run.clock[at.T]), float(run.clock[at.TROUBLE])
    what = []
    opened = max(float(seen[at.OPENNESS]), float(seen[at.CORRECTION]))
    limit = LIMIT if seen[at.OPENNESS] > LIMIT else step_audit.TOO_FAR
    if not opened <= limit and system.rows:
        row = system.rows[int(seen[at.OPEN_ROW])]
        measure = OF_OPENING[row.unit == "rad"]
        what.append(SENTENCES["opens"].format(joint=row.owner, share=opened, measure=measure))
    if not seen[at.UNREST] <= seen[at.UNREST_LIMIT]:
        what.append(SENTENCES["unrest"].format(percent=100 * seen[at.UNREST]))
    cause = _cause(run, t, ahead) or run.suspect(step_audit.UNSOUND)
    too_long = SENTENCES["too_long"].format(rtol=run.rtol)
    return SENTENCES["ended"].format(t=t, what=" and ".join(what), cause=cause or too_long)


def _cause(run: Running, t: float, ahead: float) -> str:
    """What has stopped a run at t [s], in a step to `ahead` [s], in words; "" if that is not known."""
    system, workspace = run.system, run.workspace
    nq = 3 * system.body_count
    q, v = workspace.state[:nq].copy(), workspace.state[nq : 2 * nq].copy()
    cause = load_law.complaint(t) or not_finite(system, workspace, run.t_end)
    cause = cause or jump(system, t, ahead) or contradicted(system, system.workspace(), t, q, v, run.t_end - t)
    if cause:
        return cause
    cause = unlike_masses(system)
    if cause:
        return cause
    away = float(np.abs(q.reshape(-1, 3)[:, :2]).max(initial=0.0))
    if away > FAR * system.extent:
        return (
            f"the mechanism of {system.extent:.2g} m is {away:.2g} m away from the origin, too far for the digits of a"
            " number; put the origin near it"
        )
    if not run.stepper.leaf.adaptive:
        return SENTENCES["step_too_long"].format(step=ahead - t)
    record(workspace, t, workspace.state, np.zeros(width(system)))
    return describe_rank_loss(system, workspace, NEARLY)


def jump(system: System, start: float, end: float) -> str:
    """In words, which driver jumps between two instants [s], in position or in speed, and when; "" if none."""
    workspace = system.workspace()

    def value(t: float, slot: int) -> float:
        drive(workspace, t)
        return float(workspace.values[slot])

    reach = max(end - start, NEAR * max(abs(start), abs(end)))
    for name in system.model.drivers:
        slot = system.driver_slot(name)
        unit = system.rows[system.first_row(name)].unit
        scale = 1.0 if unit == "rad" else system.extent
        for k, (what, per) in enumerate((("position", ""), ("speed", "/s"))):
            low, high = start - reach, end + reach
            before, after = value(low, slot + k), value(high, slot + k)
            while high - low > NEIGHBOURS * max(abs(low), abs(high)) + TINY:
                middle = 0.5 * (low + high)
                if not low < middle < high:
                    break
                at = value(middle, slot + k)
                if abs(at - before) >= abs(after - at):
                    high, after = middle, at
                else:
                    low, before = middle, at
            least = JUMPS * (scale if k == 0 else max(abs(before), abs(after), SLOW * scale))
            if abs(after - before) > least:
                text = f"driver '{name}' jumps in {what} at t = {high:.9g} s"
                return f"{text}, from {before:.6g} to {after:.6g} {unit}{per}; smooth its function there"
    return ""
