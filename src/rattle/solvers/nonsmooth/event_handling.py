"""What an event does in event-driven motion: impact, new modes of contacts, of friction of joints, and memory."""

from __future__ import annotations

from rattle.equations.complementarity import FORWARD, OFF, STICK
from rattle.equations.motion import OK, solve_motion
from rattle.equations.state import take_states
from rattle.equations.unilateral import NOT_FOUND
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.solvers.contacts.clutches import gets_ahead
from rattle.solvers.contacts.contact_events import pass_on, remember_end, turn, turn_clutches
from rattle.solvers.contacts.pawls import drop_pawl
from rattle.solvers.dry_friction_modes import KEEP, decide, modes_changed, stay_at_rest
from rattle.solvers.nonsmooth.contact_modes import CREEPS, DROP, HIT, MEETS, NOTHING, TURN, update_modes
from rattle.solvers.nonsmooth.contact_projection import note_open, project_on_contacts
from rattle.solvers.nonsmooth.idle_contacts import note_pressed
from rattle.solvers.nonsmooth.impacts import collide

MOST_TURNS = 20  # between modes of contacts and of friction of joints


@compiled
def remember(m):
    """Store gaps [m or rad], their rates and forces for the start of the next step."""
    remember_end(m)
    pass_on(m)


@compiled
def count_shift(m):
    """Error of a located event [m or rad], from gaps before and after the projection; it counts as drift."""
    memory, kinematics = m.contact_memory, m.contact_kinematics
    for n in range(memory.shape[0]):
        note_open(m, n, abs(kinematics[n, at.GAP] - memory[n, at.GAP_1]))


@compiled
def new_modes(m, t, y, who, what):
    """New modes at (t, y) after an event, see `update_modes`; y is projected onto its constraints. Returns a status."""
    nq = m.change.shape[0]
    status = update_modes(m, t, y, who, what)
    if status == CREEPS:
        project_on_contacts(m, t, y, -1)
        take_states(m, y)
        solve_motion(m, t, y[:nq], y[nq : 2 * nq])
        status = update_modes(m, t, y, who, what)
    if status == OK:
        project_on_contacts(m, t, y, -1)
    return NOT_FOUND if status == CREEPS else status


@native("i", "h", "f", "v", "i", "i")
def handle_event(m, t, y, who, what):
    """Event at (t [s], y): impact if contacts hit, then new modes; y is projected onto its constraints.

    Returns a status.  `contact_kinematics` holds the gaps at (t, y).
    what: HIT, LET_GO, BREAK_AWAY or TURN of contact `who`, MEETS if it is compliant; or NOTHING: a run starts, `who`
    hits (-1: none does).
    """
    memory, kinematics = m.contact_memory, m.contact_kinematics
    for n in range(memory.shape[0]):
        memory[n, at.GAP_1] = kinematics[n, at.GAP]
    if m.dry.shape[0] > 0:
        stay_at_rest(m, t, y)
    if what == DROP:
        drop_pawl(m, who, 1.0)
        project_on_contacts(m, t, y, -1)
        return OK
    if what == MEETS:
        project_on_contacts(m, t, y, -1)
        turn(m, who, t, y)
        who, what = -1, NOTHING
    if what == HIT or (what == NOTHING and who >= 0):
        project_on_contacts(m, t, y, who)
        count_shift(m)
        status = collide(m, t, y, who)
        if status != OK:
            return status
        turn_clutches(m, t, y)
        who = who if what == HIT else -1  # it is at its wall, even if another contact holds it off by rounding
        what = HIT
    else:
        nq, mode = m.change.shape[0], m.mode
        old = mode[who] if what == TURN else OFF
        if what == TURN:  # at the reversal there is no slip; the accelerations decide its sign
            mode[who] = STICK if m.contact[who, at.LEVEL] == 0 else FORWARD
        project_on_contacts(m, t, y, -1)
        if what == TURN:
            mode[who] = old
        if what == TURN and m.contact[who, at.LEVEL] == 1 and gets_ahead(m, who):
            # closed contacts and drivers hold the rate of the clutch at less than zero, by the error of the step
            status = collide(m, t, y, who)
            turn_clutches(m, t, y)
            status = new_modes(m, t, y, -1, HIT) if status == OK else status
            return agree_with_friction(m, t, y) if status == OK and m.dry.shape[0] > 0 else status
        take_states(m, y)
        solve_motion(m, t, y[:nq], y[nq : 2 * nq])
    status = new_modes(m, t, y, who, what)
    return agree_with_friction(m, t, y) if status == OK and m.dry.shape[0] > 0 else status


@compiled
def agree_with_friction(m, t, y):
    """New modes of the friction of joints after those of contacts, by turns until neither changes. Returns a status."""
    for _ in range(MOST_TURNS):
        if not decide(m, t, y, KEEP, 1):
            return NOT_FOUND
        if not modes_changed(m):
            note_pressed(m)
            return OK
        status = new_modes(m, t, y, -1, NOTHING)
        if status != OK:
            return status
    return NOT_FOUND
