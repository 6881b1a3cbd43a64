"""Switches of expressions that depend on the state: each smooth piece of a run stays on one branch of every switch.

A step is taken with the branches of its start.  If a switching function has changed sign in it, the dense output is
searched for the first zero crossing, the step is repeated up to there, and there the switch changes its branch: no
step crosses a kink.  If a stage has no finite value on the old branch (a square root beyond zero), the switch is
released for one step, whose error control then passes the kink as well as it can.  Dry friction that begins to stick or
slip (`dry_friction_modes`) ends a step in the same way.
"""

from __future__ import annotations

from rattle.equations.motion import derivative, place
from rattle.equations.state import take_states
from rattle.jit import layout as at
from rattle.jit.functions import compiled, native
from rattle.language.bytecode import BENT, CROSSED, LESS, SIDE, evaluate, switching, wave
from rattle.language.table_reading import knot_coordinate
from rattle.solvers.contacts.gap_search import NONE
from rattle.solvers.dense_output import HALVINGS, INSTANT, interpolate
from rattle.solvers.dry_friction_modes import any_over, decide, first_change_of_modes, stay_at_rest
from rattle.solvers.step_size import STANDSTILL, STANDSTILL_OF_RUN

ACCEPT, REPEAT, SLIDES = 0, 1, 22  # the step is accepted; it is repeated; a switch changes its branch without end
PARTS = 16  # pieces of a step that are searched
RESTLESS, MOST_PATIENT = 20, 8  # switchings of joints after which their modes are kept for a little, and how often
CALM = 1e-2  # share of a step without that, after which it counts anew
ENDLESS = 200  # switchings without progress in time after which a run stops
CLOSE = 1e-7  # share of a step that does not count as progress
AHEAD = 1e-15  # share of the time by which modes are decided later: where loads begin all forces are zero just at it
AT_END = 1e-13  # share of the run by which a step may end after a switch and be accepted as one that ends at it


@compiled
def argument(m, n, t):
    """Switching function n (in its own unit) at the state in `body`; signals must be up to date."""
    switch, stack = m.switch, m.stack
    evaluate(m.code, m.const, switch[n, at.FIRST_CODE], switch[n, at.END_CODE], t, m.body, m.signals, stack)
    other = float(stack[1]) if switch[n, at.OPERANDS] == 2 else 0.0
    own = switch[n, at.OWN_CODE]
    op = m.code[own, 0]
    if op == BENT:
        return wave(knot_coordinate(m.const, m.code[own, 1], float(stack[0])))
    return stack[0] - other if op >= LESS else switching(op, float(stack[0]), other)


@compiled
def see(m, t, y):
    """Copy the state y at t [s] with its signals into the workspace."""
    nq, signal, signals = m.change.shape[0], m.signal, m.signals
    take_states(m, y)
    place(m, y[:nq], y[nq : 2 * nq])
    for n in range(signal.shape[0]):
        signals[signal[n, at.TARGET]] = evaluate(
            m.code, m.const, signal[n, at.FIRST_CODE], signal[n, at.END_CODE], t, m.body, signals, m.stack
        )


@compiled
def take_sides(m, t):
    """Switches without a branch take that of their switching function at the state in `body`."""
    switch, code = m.switch, m.code
    for n in range(switch.shape[0]):
        row = switch[n, at.OWN_CODE]
        if code[row, SIDE] == 0:
            s = argument(m, n, t)
            code[row, SIDE] = 1 if s > 0.0 else (-1 if s < 0.0 else 0)


@compiled
def choose_sides(m, t, ahead):
    """Branches at the start of a run; if a switching function is zero, the one that it enters within `ahead` [s]."""
    y, f, stage, nq = m.state, m.rate, m.stage, m.change.shape[0]
    switch, code, landing = m.switch, m.code, m.landing
    landing[at.LANDS], landing[at.AGAIN], landing[at.PATIENCE] = 0.0, 0.0, 0.0
    landing[at.PATIENT_UNTIL] = t
    for n in range(switch.shape[0]):
        code[switch[n, at.OWN_CODE], SIDE] = 0
    derivative(m, t, y, f)
    m.tally[at.EVALUATIONS] += 1
    see(m, t, y)
    take_sides(m, t)
    for k in range(y.shape[0]):
        stage[k] = y[k] + ahead * f[k]
    for k in range(nq):
        stage[k] = y[k] + 0.5 * ahead * (y[nq + k] + stage[nq + k])
    see(m, t + ahead, stage)
    take_sides(m, t + ahead)
    for n in range(switch.shape[0]):
        code[switch[n, at.OWN_CODE], CROSSED] = 0


@native("i", "h")
def crossed(m):
    """True if a switching function has had the other sign since the last call."""
    switch, code, any_crossed = m.switch, m.code, False
    for n in range(switch.shape[0]):
        row = switch[n, at.OWN_CODE]
        any_crossed = any_crossed or (code[row, CROSSED] == 1 and code[row, SIDE] != 0)
        code[row, CROSSED] = 0
    if m.dry.shape[0] > 0:
        any_crossed = any_over(m) or any_crossed
    return any_crossed


@native("i", "h")
def release(m):
    """Release the switches whose switching functions have had the other sign; True if there are any."""
    switch, code, any_released = m.switch, m.code, False
    for n in range(switch.shape[0]):
        row = switch[n, at.OWN_CODE]
        if code[row, CROSSED] == 1 and code[row, SIDE] != 0:
            code[row, SIDE] = 0
            any_released = True
        code[row, CROSSED] = 0
    return any_released


@compiled
def argument_at(m, t, h, share, n):
    """Switching function n at a share of the step from t [s] of length h [s]."""
    stage = m.stage
    interpolate(m, share, stage)
    see(m, t + share * h, stage)
    return argument(m, n, t + share * h)


@compiled
def zero_between(m, t, h, n, side, low, high):
    """Share of the step at which switching function n leaves its side: it has done so by the share `high`."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if middle <= low or middle >= high or (high - low) * h <= INSTANT * abs(t):
            break
        if argument_at(m, t, h, middle, n) * side < 0.0:
            high = middle
        else:
            low = middle
    return high


@compiled
def first_zero(m, t, h, n, side, until):
    """Share of the step, before `until`, at which switching function n first leaves its side; NONE if it does not.

    It is seen at even shares, and where the stages may have seen it.
    """
    left, seen = 0.0, NONE
    for part in range(1, PARTS + 1):
        right = part / PARTS
        if left >= until:
            return NONE
        if argument_at(m, t, h, right, n) * side < 0.0:
            seen = right
            break
        left = right
    for s in range(m.stage_times.shape[0]):
        share = m.stage_times[s]
        if 0.0 < share < min(seen, 1.0) and argument_at(m, t, h, share, n) * side < 0.0:
            seen = share
    if seen == NONE:
        return NONE
    return zero_between(m, t, h, n, side, min(left, int(seen * PARTS) / PARTS), seen)


@compiled
def first_switch(m, t, h):
    """Share of the step at which the first switching function changes its sign (NONE if none does), and its index.

    Needs the dense output.
    """
    switch, code = m.switch, m.code
    best, who = NONE, -1
    for n in range(switch.shape[0]):
        side = code[switch[n, at.OWN_CODE], SIDE]
        zero = first_zero(m, t, h, n, side, best) if side != 0 else NONE
        if zero < best:
            best, who = zero, n
    return best, who


@native("if", "h", "f", "f", "f", "f")
def land(m, t, h, t_end, go_on):
    """Whether the step from t [s] of length h [s] is accepted, see ACCEPT; needs the dense output.

    Returns that and the length to try next [s].  go_on: the step that would follow [s].
    """
    landing = m.landing
    share, who = first_switch(m, t, h)
    if m.dry.shape[0] > 0:
        sooner, joint = first_change_of_modes(m, t, h, min(share, 1.0), max(0.0, (landing[at.PATIENT_UNTIL] - t) / h))
        if joint >= 0 and sooner < share:
            share, who = sooner, m.switch.shape[0] + joint
    crossed(m)
    if who < 0:
        return ACCEPT, h
    landing[at.GO_ON] = go_on
    if share * h <= STANDSTILL * abs(t) + STANDSTILL_OF_RUN * t_end:  # at once, without a step
        y, f = m.state, m.rate
        turn(m, t, y, who, h)
        derivative(m, t, y, f)
        m.tally[at.EVALUATIONS] += 1
        return (SLIDES if landing[at.AGAIN] > ENDLESS else REPEAT), h
    landing[at.LANDS], landing[at.LANDS_IN] = 1.0 + who, share * h
    if (1.0 - share) * h <= AT_END * t_end:
        return ACCEPT, h
    return REPEAT, share * h


@compiled
def turn(m, t, y, who, h):
    """Switch `who` changes its branch at (t, y), and with it all whose sign has changed; h: usual step [s].

    Again at the same time it changes alone: switching functions that are equal are 0 together, and there rounding has
    a sign that would undo what the first of them has done.
    """
    switch, code, landing = m.switch, m.code, m.landing
    again = t - landing[at.LAST_TURN] <= CLOSE * h
    see(m, t, y)
    for n in range(switch.shape[0]):
        row = switch[n, at.OWN_CODE]
        if n == who or (not again and argument(m, n, t) * code[row, SIDE] < 0.0):
            code[row, SIDE] = -code[row, SIDE]
            landing[at.TURNS] += 1.0
    take_sides(m, t)
    for n in range(switch.shape[0]):
        code[switch[n, at.OWN_CODE], CROSSED] = 0
    if m.dry.shape[0] > 0:
        landing[at.TURNS] += 1.0
        stay_at_rest(m, t, y)
        mine = who >= switch.shape[0]
        decide(m, t * (1.0 + AHEAD) if mine else t, y, who - switch.shape[0] if mine else -1, 1)
    landing[at.AGAIN] = landing[at.AGAIN] + 1.0 if again else 0.0
    landing[at.LAST_TURN] = t
    if landing[at.AGAIN] >= RESTLESS and who >= switch.shape[0]:
        be_patient(m, t, h)


@compiled
def be_patient(m, t, h):
    """Let joints keep their modes for a little: where loads begin all forces may be rounding, which turns them to and
    fro.  A few times, each longer than the one before; h: usual step [s]."""
    landing = m.landing
    if t - landing[at.PATIENT_UNTIL] > CALM * h:
        landing[at.PATIENCE] = 0.0
    if landing[at.PATIENCE] < MOST_PATIENT:
        landing[at.PATIENCE] += 1.0
        landing[at.PATIENT_UNTIL] = t + CLOSE * h * 4.0 ** landing[at.PATIENCE]
        landing[at.AGAIN] = 0.0


@native("i", "h", "f", "v")
def follow_jump(m, t, y):
    """Switches take the side to which their switching functions have jumped at (t [s], y), as rates do in an impact.

    True if any has.
    """
    switch, code, jumped = m.switch, m.code, False
    see(m, t, y)
    for n in range(switch.shape[0]):
        row = switch[n, at.OWN_CODE]
        code[row, CROSSED] = 0
        if argument(m, n, t) * code[row, SIDE] < 0.0:
            code[row, SIDE] = -code[row, SIDE]
            m.landing[at.TURNS] += 1.0
            jumped = True
    return jumped


@native("i", "h", "f", "v", "v", "f")
def arrive(m, t, y, f, h):
    """Change the branch of the switch at which the step has ended; True if there was one, new derivative in f."""
    landing = m.landing
    if landing[at.LANDS] == 0.0:
        see(m, t, y)
        take_sides(m, t)
        return False
    turn(m, t, y, int(landing[at.LANDS]) - 1, h)
    landing[at.LANDS] = 0.0
    derivative(m, t, y, f)
    m.tally[at.EVALUATIONS] += 1
    return True
