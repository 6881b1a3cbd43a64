"""Whether a step may be accepted: joints closed, energy accounted for.

    openness  max over rows of |Phi|, metres relative to the mechanism's size, radians relative to 1
    unrest    |T + V - work + dissipated - (the same at the start)|                   energy error [J]
    turnover  max(T, |work|, max V - min V) so far, at least a floor for the error that tolerances allow    [J]

A step with openness or unrest / turnover beyond their limits is rejected; so is one after which the projection had to
close a large gap, as after a driver that jumped (docs/theory.md, section 9, limits of drift and energy error).
"""

from __future__ import annotations

from rattle.equations.state import DISSIPATED, LOSS, STORED, WORK, account_at, energies_at
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native

UNSOUND = 20  # end of a run whose next step is not acceptable
TOO_FAR = 1e-2  # largest openness after a step that the projection may correct
ROUNDING = 1e-14  # rounding error of the sum of energies, as a share of the energies
STEPS_OF_POSITION, STEPS_OF_RATE = 1e2, 1e5  # to which errors of steps add up in a long run, as factors
LARGEST_SHARE = 0.1  # of the moments of all forces, over the size: more is never rounding


@compiled
def openness(m):
    """The largest residual of the present rows, relative to the mechanism's size [m] or to 1 [rad]."""
    rows, measure, worst = m.rows, m.measure, 0.0
    for r in range(measure.shape[0]):
        share = abs(rows[r, at.RES] * measure[r])
        if not share <= worst:
            worst = share
    return worst


@compiled
def note_drift(m):
    """Record the drift of the present rows: the largest length [m] and angle [rad] so far, while it is acceptable.

    Returns the row with the largest residual, or -1 if all are zero or it is not acceptable.
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
    audit[at.OPENNESS], audit[at.OPEN_ROW] = worst, which
    if not worst <= audit[at.OPEN_LIMIT]:
        return -1
    further = length > audit[at.OPEN_LENGTH] or angle > audit[at.OPEN_ANGLE]
    audit[at.OPEN_LENGTH], audit[at.OPEN_ANGLE] = max(audit[at.OPEN_LENGTH], length), max(audit[at.OPEN_ANGLE], angle)
    return which if further else -1


@native("i", "h", "v")
def stands(m, y):
    """True if the state y, with rates in `body` and potential in `power`, is acceptable; see `keep_energies`."""
    audit, body, mass, power = m.audit, m.body, m.mass, m.power
    energies = energies_at(m)
    kinetic, potential, lost = 0.0, power[at.POTENTIAL_ENERGY], y[energies + DISSIPATED]
    for i in range(1, body.shape[0]):
        for k in range(3):
            kinetic += 0.5 * mass[i, k] * body[i, at.VX + k] ** 2
    for n in range(m.contact_kinematics.shape[0]):
        lost += y[account_at(m, n) + LOSS]
        potential += y[account_at(m, n) + STORED]
    done = y[energies + WORK]
    total = kinetic + potential - done + lost
    if audit[at.STARTED] == 0.0:
        audit[at.STARTED], audit[at.TOTAL_0], audit[at.WORK_0] = 1.0, total, done
        (
            audit[at.MOST_KINETIC],
            audit[at.MOST_WORK],
            audit[at.LEAST_POTENTIAL],
            audit[at.MOST_POTENTIAL],
            audit[at.MOST_UNREST],
        ) = kinetic, 0.0, potential, potential, 0.0
    work = abs(done - audit[at.WORK_0])
    low, high = min(audit[at.LEAST_POTENTIAL], potential), max(audit[at.MOST_POTENTIAL], potential)
    turnover = max(audit[at.MOST_KINETIC], kinetic, audit[at.MOST_WORK], work, high - low) + audit[at.FLOOR]
    unrest = max(0.0, abs(total - audit[at.TOTAL_0]) - ROUNDING * max(abs(low), abs(high)))
    share = unrest / turnover if turnover > 0.0 else unrest
    audit[at.UNREST] = share
    audit[at.KINETIC_NOW], audit[at.WORK_NOW] = kinetic, work
    audit[at.POTENTIAL_NOW], audit[at.UNREST_NOW] = potential, unrest
    return (
        share <= audit[at.UNREST_LIMIT]
        and audit[at.OPENNESS] <= audit[at.OPEN_LIMIT]
        and audit[at.CORRECTION] <= TOO_FAR
    )


@compiled
def keep_energies(m):
    """Record the energies of the state that was checked last: it is one of the run.

    The end of a step that an event cuts short is not: beyond a wall it may have any energy.
    """
    audit = m.audit
    audit[at.MOST_KINETIC] = max(audit[at.MOST_KINETIC], audit[at.KINETIC_NOW])
    audit[at.MOST_WORK] = max(audit[at.MOST_WORK], audit[at.WORK_NOW])
    audit[at.LEAST_POTENTIAL] = min(audit[at.LEAST_POTENTIAL], audit[at.POTENTIAL_NOW])
    audit[at.MOST_POTENTIAL] = max(audit[at.MOST_POTENTIAL], audit[at.POTENTIAL_NOW])
    audit[at.MOST_UNREST] = max(audit[at.MOST_UNREST], audit[at.UNREST_NOW])


def energy_at_rest(mass: float, atol: float) -> float:
    """Energy [J] of a mechanism of this mass [kg] whose rates are the errors of steps alone; atol: of rates [m/s]."""
    return mass * (STEPS_OF_RATE * atol) ** 2


@native("void", "h", "f", "f", "f", "f")
def set_floor(m, extent, limit, rtol, atol):
    """Set the floor of turnover [J]: that of a mechanism at rest under the forces at the start, within the tolerances.

    extent: size of the mechanism [m].  limit: largest share for drift [-].  Positions are known to rtol [-] of the
    size, rates to atol [m/s, rad/s]; errors of steps add up, hence a hundred (a hundred thousand) times that.
    """
    force, mass, moment, resting = m.force, m.mass, 0.0, 0.0
    slow = STEPS_OF_RATE * atol
    for i in range(1, force.shape[0]):
        moment += abs(force[i, 2]) + extent * (abs(force[i, 0]) + abs(force[i, 1]))
        resting += 0.5 * (mass[i, 0] + mass[i, 1]) * slow**2 + 0.5 * mass[i, 2] * (slow / extent) ** 2
    m.audit[at.FLOOR] = min(STEPS_OF_POSITION * rtol / limit, LARGEST_SHARE) * moment + resting
