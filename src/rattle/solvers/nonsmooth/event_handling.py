"""What an event does in event-driven motion: impact, new modes of contacts, of friction of joints, and memory."""

from __future__ import annotations

import math

from rattle.equations.complementarity import FORWARD, OFF, STICK
from rattle.equations.compliant import locate_contacts
from rattle.equations.dry_friction import rounding
from rattle.equations.motion import OK, solve_motion
from rattle.equations.one_way import hold, off_end, passes
from rattle.equations.state import take_states
from rattle.equations.unilateral import NOT_FOUND, NOT_UNIQUE
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.solvers.contacts.clutches import gets_ahead
from rattle.solvers.contacts.contact_events import let_others_under, pass_on, remember_end, turn, turn_clutches
from rattle.solvers.contacts.pawls import drop_pawl
from rattle.solvers.dry_friction_modes import KEEP, decide, decided, modes_changed, solve_at, stay_at_rest, tell
from rattle.solvers.nonsmooth.contact_modes import (
    CREEPS,
    DROP,
    HIT,
    LET_GO,
    MEETS,
    NOTHING,
    TURN,
    release,
    update_modes,
)
from rattle.solvers.nonsmooth.contact_projection import noise, note_open, project_on_contacts
from rattle.solvers.nonsmooth.idle_contacts import note_pressed
from rattle.solvers.nonsmooth.impacts import collide

MOST_TURNS = 20  # between modes of contacts and of friction of joints
MOST_TRIED = 6  # joints at rest up to which all their modes are tried: 729 contact problems


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


@compiled
def hit(m, t, y, who):
    """Impact of contact `who` at (t [s], y). Returns a status."""
    project_on_contacts(m, t, y, who)
    count_shift(m)
    status = collide(m, t, y, who)
    if status != OK:
        return status
    turn_clutches(m, t, y)
    if m.dry.shape[0] > 0:
        slip_as_they_move(m, t, y)
    return OK


@compiled
def project_on_reversal(m, t, y, who):
    """Project y at the reversal of contact `who`: there is no slip, the accelerations decide its sign."""
    mode = m.mode
    old = mode[who]
    mode[who] = STICK if m.contact[who, at.LEVEL] == 0 else FORWARD
    project_on_contacts(m, t, y, -1)
    mode[who] = old


@compiled
def gets_past_end(m, t, y, who, what):
    """True if contact `who` passes an end: beside it, which is no impact, or off it, where it is let go of."""
    if what == HIT:
        return passes(m, who, noise(m, who))
    if what != LET_GO or not off_end(m, who):
        return False
    release(m, t, y, who)
    m.mode[who], m.contact_memory[who, at.LEFT_END] = OFF, 1.0
    hold(m, who, False)
    locate_contacts(m)
    return True


@native("i", "h", "f", "v", "i", "i")
def handle_event(m, t, y, who, what):
    """Event at (t [s], y): impact if contacts hit, then new modes; y is projected onto its constraints.

    Returns a status.  `contact_kinematics` holds the gaps at (t, y).
    what: HIT, LET_GO, BREAK_AWAY or TURN of contact `who`, MEETS if it is compliant; or NOTHING: a run starts, `who`
    hits (-1: none does).
    """
    nq = m.change.shape[0]
    if gets_past_end(m, t, y, who, what):
        who, what = -1, NOTHING
    let_others_under(m, who)
    for n in range(m.contact_memory.shape[0]):
        m.contact_memory[n, at.GAP_1] = m.contact_kinematics[n, at.GAP]
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
        status = hit(m, t, y, who)
        if status != OK:
            return status
        # it is at its wall, even if another contact holds it off by rounding
        return modes_with_friction(m, t, y, who if what == HIT else -1, HIT)
    if what != TURN:
        project_on_contacts(m, t, y, -1)
    else:
        project_on_reversal(m, t, y, who)
        if m.contact[who, at.LEVEL] == 1 and gets_ahead(m, who):
            # closed contacts and drivers hold the rate of the clutch at less than zero, by the error of the step
            status = collide(m, t, y, who)
            turn_clutches(m, t, y)
            return modes_with_friction(m, t, y, -1, HIT) if status == OK else status
    take_states(m, y)
    solve_motion(m, t, y[:nq], y[nq : 2 * nq])
    return modes_with_friction(m, t, y, who, what)


@compiled
def slip_as_they_move(m, t, y):
    """Joints that an impact has set going slip, before the contacts are decided: sticking would jam them."""
    memory = m.dry_memory
    solve_at(m, t, y)
    for n in range(memory.shape[0]):
        rate, before = memory[n, at.DRY_RATE], memory[n, at.DRY_MODE]
        free = m.dry[n, at.DRY_LAW] < 0 and memory[n, at.DRY_HELD] == 0.0
        if free and abs(rate) > rounding(m, n):
            memory[n, at.DRY_MODE], memory[n, at.DRY_BEFORE] = math.copysign(1.0, rate), before
            memory[n, at.DRY_FIRM] = 0.0
            tell(m, t, n)


@compiled
def modes_with_friction(m, t, y, who, what):
    """`new_modes` of contacts and of the joints with friction that go with them. Returns a status."""
    status = new_modes(m, t, y, who, what)
    if m.dry.shape[0] == 0:
        return status
    if status == OK:
        status, who, what = agree_with_friction(m, t, y), -1, NOTHING
    if status != OK and status != NOT_UNIQUE and try_joints(m, t, y, who, what):
        return agree_with_friction(m, t, y)
    return status


@compiled
def take_joint_modes(m, code):
    """Combination number `code` of the modes of the joints that are being tried."""
    memory = m.dry_memory
    for n in range(memory.shape[0]):
        if memory[n, at.DRY_REST] == 1.0:
            digit = code % 3
            code //= 3
            memory[n, at.DRY_MODE], memory[n, at.DRY_FIRM] = -1.0 if digit == 2 else float(digit), 0.0


@compiled
def try_joints(m, t, y, who, what):
    """Try all modes of joints at rest with `new_modes`; False if none go with modes of contacts, then they stay.

    A contact that presses may set a joint going: as long as that sticks, the contact has no mode.  One that has come
    to stick in this event may have got back, with the rate of the contact, what the error of the event is.
    """
    memory, tried, combinations, chosen = m.dry_memory, 0, 1, False
    solve_at(m, t, y)
    for n in range(memory.shape[0]):
        memory[n, at.DRY_BEFORE] = memory[n, at.DRY_MODE]
        sticks = m.dry[n, at.DRY_LAW] < 0 and memory[n, at.DRY_MODE] == at.DRY_STICKS
        rests = memory[n, at.DRY_HELD] == 0.0 and (sticks or decided(m, t, n))
        memory[n, at.DRY_REST] = 1.0 if rests else 0.0
        tried += 1 if rests else 0
        combinations *= 3 if rests else 1
    if 0 < tried <= MOST_TRIED:
        for code in range(combinations):
            take_joint_modes(m, code)
            chosen = new_modes(m, t, y, who, what) == OK
            if chosen:
                break
    for n in range(memory.shape[0]):
        if not chosen:
            memory[n, at.DRY_MODE] = memory[n, at.DRY_BEFORE]
        elif memory[n, at.DRY_REST] == 1.0 and memory[n, at.DRY_MODE] != at.DRY_STICKS:
            memory[n, at.DRY_SINCE] = t
        memory[n, at.DRY_REST] = 0.0
        tell(m, t, n)
    return chosen


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
