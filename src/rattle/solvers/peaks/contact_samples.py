"""Samples of the forces and slips of closed contacts in a step: may one of them become negative between two samples?

The samples are few; if a force or slip f may have been negative between two of them, a further sample is taken.
With f[...] the divided differences of neighbouring samples, d apart,

    f >= line through both ends - B (x - x_l) (x_r - x),   B = SAFE max(f[x_k, x_l, x_r], f[x_l, x_r, x_m]) + WARY
                                                               |the difference of these two|

holds if f'' changes by no more than a few times what the samples show, so that it says where f may be negative; with
closer samples B tends to f''/2.  If the two differ by as much as f itself, the samples are too far apart to decide.

The first samples of a step are its stages, at which all forces are known anyway.  If forces depend only on the state,
which the step resolves, and none comes near its limit there, the step needs no further samples.  Stages are nearly on
the motion: their deviation is estimated from the last stage, which is at the end of the step.

Source: the remainder of linear interpolation; de Boor, A Practical Guide to Splines (2001), chapter 1.
"""

from __future__ import annotations

import math

import numpy as np

from rattle.equations.complementarity import FORWARD, OFF, STICK, friction_of
from rattle.equations.one_way import pressing
from rattle.jit import layout as at
from rattle.jit.functions import compiled
from rattle.solvers.contacts.clutches import most_torque, rate_left, torque_noise, watched

KINDS = 4  # indicators, not negative: N, mu N - T, mu N + T, slip in its direction; 1 where one does not apply
SAFE, WARY = 1.5, 2.0
RESOLVED = 0.3  # change of f[...] d^2 between samples, as a share of f, above which samples do not decide
NOISE = 1e-10  # rounding and drift of a force, as a share of the largest; of a slip
YOUNG = 0.02  # a quantity that starts from zero may be negative by this share of its next value
BESIDE = 10.0  # times the deviation of the last stage from the end of the step: more than that of most other stages
SLIGHT = 1e-3  # deviation of stages from the motion, as a share of the change over the step
LEAST_ERROR = 1e-6  # of a step [tolerances]: one with a smaller error may be too long to resolve anything
UNSEEN = 1e-13  # share of the rates [m/s or rad/s] that is rounding of a slip
ROUNDING = 2e-12  # of a force, as a share of the largest: more than the contact problem counts as none
UNSEEN_AT_REST = 1e-3  # rate [rad/s] that this is a share of at least


def table(contacts: int, shares: np.ndarray) -> np.ndarray:
    """Array for the samples at the stages of a step, (n, 4 contacts + 2); shares: (n,) where they are, the last two at
    its end: that of its last stage is the last one."""
    looks = np.zeros((len(shares), KINDS * contacts + 2))
    looks[:, at.LOOK_SHARE] = shares
    return looks


@compiled
def last_look(m):
    """Number of the sample at the end of the step; that of the last stage follows."""
    return m.glances.shape[0] - 2


@compiled
def write_friction(m, n, line):
    """Write the indicators of friction of closed contact n, whose normal force is written."""
    kinematics, first, friction = m.contact_kinematics, 1 + KINDS * n, friction_of(m, n)
    if friction > 0.0 and m.mode[n] == STICK:
        line[first + 1] = friction * line[first] - kinematics[n, at.TANGENT]
        line[first + 2] = friction * line[first] + kinematics[n, at.TANGENT]
    elif friction > 0.0 and m.contact_memory[n, at.NO_SLIP] == 0.0:
        line[first + 3] = kinematics[n, at.SLIP] if m.mode[n] == FORWARD else -kinematics[n, at.SLIP]


@compiled
def write_look(m, line):
    """Write all indicators [N, m/s] at the present state to a row of samples, with the largest force [N]."""
    contact, mass, acceleration = m.contact, m.mass, m.acceleration
    largest = 0.0
    for n in range(contact.shape[0]):
        for k in range(KINDS):
            line[1 + KINDS * n + k] = 1.0
        if contact[n, at.IMPACT] == 0 or contact[n, at.LEVEL] == 1 or m.mode[n] == OFF:
            if watched(m, n):
                write_clutch(m, n, line)
            continue
        line[1 + KINDS * n] = pressing(m, n)
        largest = max(largest, abs(m.contact_kinematics[n, at.NORMAL]))
        write_friction(m, n, line)
    for i in range(1, mass.shape[0]):
        largest = max(largest, mass[i, 0] * max(abs(acceleration[i, 0]), abs(acceleration[i, 1])))
    line[1 + KINDS * contact.shape[0]] = largest
    for n in range(contact.shape[0]):  # if friction is rounding, so is its direction
        if watched(m, n) and contact[n, at.LEVEL] == 0 and abs(line[1 + KINDS * n]) <= NOISE * largest:
            line[1 + KINDS * n + 3] = 1.0


@compiled
def write_clutch(m, n, line):
    """The indicators of contact n at velocity level: its torque, what is left of the largest, or its rate."""
    first, torque = 1 + KINDS * n, m.contact_kinematics[n, at.NORMAL]
    if m.mode[n] == OFF:
        line[first + 3] = rate_left(m, n)
        return
    line[first] = torque
    if most_torque(m, n) < math.inf:
        line[first + 1] = most_torque(m, n) - torque


@compiled
def second_difference(looks, k, c):
    """Divided difference of three samples of column c, the middle one in row k."""
    before, after = (
        looks[k, at.LOOK_SHARE] - looks[k - 1, at.LOOK_SHARE],
        looks[k + 1, at.LOOK_SHARE] - looks[k, at.LOOK_SHARE],
    )
    return ((looks[k + 1, c] - looks[k, c]) / after - (looks[k, c] - looks[k - 1, c]) / before) / (before + after)


@compiled
def may_dip(looks, i, count, c, slack):
    """True if column c may be below -slack between samples i and i + 1, but is not negative at either of them."""
    nearest = min(max(i, 1), count - 2)
    next_one = min(max(i + 1, 1 if i > 0 else 2), count - 2)
    wide, left, right = looks[i + 1, at.LOOK_SHARE] - looks[i, at.LOOK_SHARE], max(looks[i, c], 0.0), looks[i + 1, c]
    if right < 0.0:
        return False
    bend, other = second_difference(looks, nearest, c), second_difference(looks, next_one, c)
    largest = max(max(abs(looks[nearest - 1, c]), abs(looks[nearest, c])), max(abs(right), abs(looks[next_one + 1, c])))
    unlike = abs(bend - other) * wide * wide
    if unlike > RESOLVED * largest and unlike > slack:
        return True
    young = looks[i, at.LOOK_SHARE] == 0.0 and left <= YOUNG * right
    bend = (1.0 if young else SAFE) * max(bend, other) * wide * wide + WARY * unlike
    if not abs(right - left) < bend:
        return False
    slack = max(slack, 0.0) + YOUNG * right if young else slack
    share = 0.5 - 0.5 * (right - left) / bend
    return left + (right - left) * share - bend * share * (1.0 - share) < -slack


@compiled
def unseen(m, n, kind, force):
    """How far below zero this indicator of contact n may be by rounding alone: a force, slip [m/s], rate or torque.

    force: the largest of all [N].  A contact that others hold, without a force, has one of rounding, of any sign.
    """
    if m.contact[n, at.LEVEL] == 0:
        return UNSEEN * m.held[at.SIZE] if kind == 3 else ROUNDING * force
    if kind < 3:
        return torque_noise(m)
    a, b = m.contact[n, at.A_BODY], m.contact[n, at.B_BODY]
    return UNSEEN * (abs(m.body[a, at.W]) + abs(m.body[b, at.W]) + UNSEEN_AT_REST)


@compiled
def slack_of(m, n, kind, left, right, force):
    """How far below zero rounding may take an indicator between two values; force: the largest of all [N]."""
    return (NOISE * force if kind < 3 else NOISE * (max(left, 0.0) + right)) + unseen(m, n, kind, force)


@compiled
def matters(m, n, kind):
    """True if an indicator of this kind applies to contact n, which is closed or at velocity level."""
    if m.contact[n, at.LEVEL] == 1:
        return kind == (3 if m.mode[n] == OFF else 0) or (
            kind == 1 and m.mode[n] != OFF and most_torque(m, n) < math.inf
        )
    if kind == 0:
        return True
    return friction_of(m, n) > 0.0 and (kind < 3) == (m.mode[n] == STICK)


@compiled
def doubts(m, error):
    """Stages between which a closed contact first opens, breaks away or reverses its slip; (end, end): none does.

    end: `last_look`.  (0, end) if the stages do not decide; the second one is `end` if they do not show the event.
    error: of the step [tolerances].
    """
    contact, looks = m.contact, m.glances
    first, last = last_look(m), last_look(m)
    force = looks[last, 1 + KINDS * contact.shape[0]]
    if not error > LEAST_ERROR or m.live.shape[0] > 0 or m.jet.shape[0] > 0:
        return 0, last
    for n in range(contact.shape[0]):
        if not watched(m, n):
            continue
        for kind in range(KINDS):
            if matters(m, n, kind):
                begin, finish = doubt(looks, 1 + KINDS * n + kind, first, last, unseen(m, n, kind, force))
                first, last = min(first, begin), min(last, finish)
    return first, last


@compiled
def margin_of(looks, c):
    """Smallest and largest value of column c at the stages, and a bound for their deviation from the motion."""
    low, high, end = looks[0, c], looks[0, c], looks.shape[0] - 2
    for i in range(1, end + 1):
        low, high = min(low, looks[i, c]), max(high, looks[i, c])
    return low, high, BESIDE * abs(looks[end + 1, c] - looks[end, c]) + SLIGHT * (high - low)


@compiled
def doubt(looks, c, first, last, lift):
    """`doubts` for column c, if it is before `first` and `last`; lift: how far below zero it may be."""
    end = looks.shape[0] - 2
    low, high, margin = margin_of(looks, c)
    if low + lift - (high - low) > margin:
        return end, end
    margin -= lift
    for i in range(first):
        if looks[i + 1, c] < (margin if i + 1 < end else -lift) or may_dip(looks, i, end + 1, c, -margin):
            first = i
            break
    for i in range(1, last):
        if looks[i, c] < -margin - 2.0 * lift:
            last = i
            break
    return first, last


@compiled
def keep_forces(m):
    """Store the largest forces [N] of the closed contacts at the stages of a step."""
    contact, mode, looks, memory = m.contact, m.mode, m.glances, m.contact_memory
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 1:
            for i in range(1, last_look(m) + 1):
                memory[n, at.PEAK] = max(memory[n, at.PEAK], looks[i, 1 + KINDS * n]) if mode[n] != OFF else 0.0


@compiled
def pass_look_on(m):
    """Make the sample at the end of a step that at the start of the next."""
    looks = m.glances
    for c in range(1, looks.shape[1]):
        looks[0, c] = looks[last_look(m), c]
