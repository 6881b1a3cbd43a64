"""Whether a step may stand: joints closed, energy accounted for.

    openness  max over rows of |Phi|, metres in lengths of the mechanism, radians as they are
    unrest    |T + V - work + dissipated - (the same at the start)|
    turnover  max(T, |work|, max V - min V) so far, and a floor: what tolerances alone may leave

A step with openness or unrest / turnover beyond their limits does not stand; nor does one that the joints had to be
pulled together after, as behind a driver that jumped (docs/theory.md, section 9, honest ends).
"""

from __future__ import annotations

from rattle.equations.state import DISSIPATED, LOSS, STORED, account_at, energies_at
from rattle.equations.state import WORK as WORK_DONE
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native

# entries of `audit`: limits and floor, set by the host; then the start, what was seen so far, and the present step;
# SUNK: the largest depth of a set-valued contact in its wall so far, in clearances (Moreau-Jean only)
(
    OPEN_LIMIT, UNREST_LIMIT, FLOOR, STARTED, TOTAL_0, WORK_0, KINETIC, WORK, LOW, HIGH, SHARE, ANGLE, LENGTH, OPEN,
    OPEN_ROW, UNREST, CORRECTION, SUNK,
) = range(18)  # fmt: skip
UNSOUND = 20  # ending of a run whose next step does not stand
TOO_FAR = 1e-2  # openness that one step may leave to be corrected
ROUNDING = 1e-14  # share of the energies themselves that their sum may be off by


@compiled
def openness(m):
    """The largest residual of the rows at hand, each by its own measure."""
    rows, measure, worst = m.rows, m.measure, 0.0
    for r in range(measure.shape[0]):
        share = abs(rows[r, at.RES] * measure[r])
        if not share <= worst:
            worst = share
    return worst


@compiled
def note_drift(m):
    """How far the joints are open at the rows at hand; the largest length and angle so far are kept while they stand.

    Returns the row that is open most, or -1 when none is or it does not stand.
    """
    rows, measure, audit = m.rows, m.measure, m.audit
    worst, which, length, angle = 0.0, 0, 0.0, 0.0
    for r in range(rows.shape[0]):
        value = abs(rows[r, at.RES])
        share = value * abs(measure[r])
        if not share <= worst:
            worst, which = share, r
        if measure[r] < 0.0:
            angle = max(angle, value)
        else:
            length = max(length, value)
    audit[OPEN], audit[OPEN_ROW] = worst, which
    if not worst <= audit[OPEN_LIMIT]:
        return -1
    further = length > audit[LENGTH] or angle > audit[ANGLE]
    audit[LENGTH], audit[ANGLE] = max(audit[LENGTH], length), max(audit[ANGLE], angle)
    return which if further else -1


@native("i", "h", "v")
def stands(m, y):
    """True when the state y, whose rates are in `body` and potential in `power`, may stand; then it is remembered."""
    audit, body, mass, power = m.audit, m.body, m.mass, m.power
    energies = energies_at(m)
    kinetic, potential, lost = 0.0, power[0], y[energies + DISSIPATED]
    for i in range(1, body.shape[0]):
        for k in range(3):
            kinetic += 0.5 * mass[i, k] * body[i, at.VX + k] ** 2
    for n in range(m.contact_kinematics.shape[0]):
        lost += y[account_at(m, n) + LOSS]
        potential += y[account_at(m, n) + STORED]
    done = y[energies + WORK_DONE]
    total = kinetic + potential - done + lost
    if audit[STARTED] == 0.0:
        audit[STARTED], audit[TOTAL_0], audit[WORK_0] = 1.0, total, done
        audit[KINETIC], audit[WORK], audit[LOW], audit[HIGH], audit[SHARE] = kinetic, 0.0, potential, potential, 0.0
    work = abs(done - audit[WORK_0])
    low, high = min(audit[LOW], potential), max(audit[HIGH], potential)
    turnover = max(audit[KINETIC], kinetic, audit[WORK], work, high - low) + audit[FLOOR]
    unrest = max(0.0, abs(total - audit[TOTAL_0]) - ROUNDING * max(abs(low), abs(high)))
    share = unrest / turnover if turnover > 0.0 else unrest
    audit[UNREST] = share
    sound = share <= audit[UNREST_LIMIT] and audit[OPEN] <= audit[OPEN_LIMIT] and audit[CORRECTION] <= TOO_FAR
    if not sound:
        return False
    audit[KINETIC], audit[WORK] = max(audit[KINETIC], kinetic), max(audit[WORK], work)
    audit[LOW], audit[HIGH], audit[SHARE] = low, high, max(audit[SHARE], share)
    return True
