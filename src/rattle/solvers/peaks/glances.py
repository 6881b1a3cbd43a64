"""What lasting contacts do at the places of a step where their forces are known: may one of them let go between two?

The places are few, and where a force or a slip f may have been below zero between two of them it is looked once more.
With f[...] the divided differences of neighbouring looks, d apart,

    f >= line through both ends - B (x - x_l) (x_r - x),   B = SAFE max(f[x_k, x_l, x_r], f[x_l, x_r, x_m]) + WARY
                                                               |the difference of these two|

holds where f'' changes by no more than a few times what the looks tell, so that it says where that may be; as f is
seen more closely B becomes f''/2.  Where the two differ by as much as f itself the looks are too far apart to tell
anything.

The first places of a step are its stages, of which all forces are known anyway.  Where forces depend on the state
alone, which the step resolves, and nothing comes near its limit there, the step needs no looks of its own.  Stages
are nearly on the motion: by how much they are beside it the last one tells, at whose place the step itself ends.

Source: the remainder of linear interpolation; de Boor, A Practical Guide to Splines (2001), chapter 1.
"""

from __future__ import annotations

import numpy as np

from rattle.equations.complementarity import FORWARD, OFF, STICK, friction_of
from rattle.equations.unilateral import SIZE
from rattle.jit import layout as at
from rattle.jit.functions import compiled
from rattle.solvers.dop853_tableau import C

KINDS = 4  # what must not become negative: N, mu N - T, mu N + T, slip in its sense; 1 where it does not matter
PLACES = np.array([0.0, C[6], C[7], C[5], C[9], C[8], C[10], 1.0, 1.0])  # as the samples of peaks lie; last stage
END, LAST_STAGE = 7, 8
SAFE, WARY = 1.5, 2.0
RESOLVED = 0.3  # change of f[...] d^2 from one look to the next, as a share of f, beyond which looks say nothing yet
NOISE = 1e-10  # rounding and drift of a force, as a share of the largest; of a slip
YOUNG = 0.02  # what starts from zero may be below it by this share of what it soon is
BESIDE = 10.0  # times what the last stage is beside the end of the step: more than most other stages are
SLIGHT = 1e-3  # share of a change over the step that stages may be beside it, too
LEAST_ERROR = 1e-6  # of a step [tolerances]: one with less may be too long to resolve anything


def table(contacts: int) -> np.ndarray:
    """Room for the looks at the stages of a step, (9, 4 contacts + 2)."""
    looks = np.zeros((len(PLACES), KINDS * contacts + 2))
    looks[:, 0] = PLACES
    return looks


@compiled
def write_look(m, line):
    """All that must not become negative at the state at hand into a line of looks, and the largest force."""
    contact, kinematics, mode = m.contact, m.contact_kinematics, m.mode
    largest = 0.0
    for n in range(contact.shape[0]):
        first = 1 + KINDS * n
        for k in range(KINDS):
            line[first + k] = 1.0
        if contact[n, at.IMPACT] == 0 or mode[n] == OFF:
            continue
        friction, normal = friction_of(m, n), kinematics[n, at.NORMAL]
        line[first] = normal
        largest = max(largest, abs(normal))
        if friction > 0.0 and mode[n] == STICK:
            line[first + 1] = friction * normal - kinematics[n, at.TANGENT]
            line[first + 2] = friction * normal + kinematics[n, at.TANGENT]
        elif friction > 0.0:
            line[first + 3] = kinematics[n, at.SLIP] if mode[n] == FORWARD else -kinematics[n, at.SLIP]
    mass, acceleration = m.mass, m.acceleration
    for i in range(1, mass.shape[0]):
        largest = max(largest, mass[i, 0] * max(abs(acceleration[i, 0]), abs(acceleration[i, 1])))
    line[1 + KINDS * contact.shape[0]] = largest
    for n in range(contact.shape[0]):  # where friction is rounding so is its sense
        if contact[n, at.IMPACT] == 1 and abs(line[1 + KINDS * n]) <= NOISE * largest:
            line[1 + KINDS * n + 3] = 1.0


@compiled
def second_difference(looks, k, c):
    """Divided difference of three looks, the middle one in line k, of column c."""
    before, after = looks[k, 0] - looks[k - 1, 0], looks[k + 1, 0] - looks[k, 0]
    return ((looks[k + 1, c] - looks[k, c]) / after - (looks[k, c] - looks[k - 1, c]) / before) / (before + after)


@compiled
def may_dip(looks, i, count, c, slack):
    """True when column c may be below -slack between looks i and i + 1, but is not below zero at either of them."""
    one = min(max(i, 1), count - 2)
    two = min(max(i + 1, 1 if i > 0 else 2), count - 2)
    wide, left, right = looks[i + 1, 0] - looks[i, 0], max(looks[i, c], 0.0), looks[i + 1, c]
    if right < 0.0:
        return False
    bend, other = second_difference(looks, one, c), second_difference(looks, two, c)
    largest = max(max(abs(looks[one - 1, c]), abs(looks[one, c])), max(abs(right), abs(looks[two + 1, c])))
    unlike = abs(bend - other) * wide * wide
    if unlike > RESOLVED * largest and unlike > slack:
        return True
    young = looks[i, 0] == 0.0 and left <= YOUNG * right
    bend = (1.0 if young else SAFE) * max(bend, other) * wide * wide + WARY * unlike
    if not abs(right - left) < bend:
        return False
    slack = max(slack, 0.0) + YOUNG * right if young else slack
    share = 0.5 - 0.5 * (right - left) / bend
    return left + (right - left) * share - bend * share * (1.0 - share) < -slack


@compiled
def unseen(m, kind):
    """By how much what must not become negative may be so by rounding alone: a slip [m/s]."""
    return 1e-13 * m.held[SIZE] if kind == 3 else 0.0


@compiled
def slack_of(m, kind, left, right, force):
    """By how much rounding may take something below zero between two values; force: the largest of all [N]."""
    return NOISE * force if kind < 3 else NOISE * (max(left, 0.0) + right) + unseen(m, kind)


@compiled
def matters(m, n, kind):
    """True where contact n, which is closed, may do what is meant by a kind of look."""
    if kind == 0:
        return True
    return friction_of(m, n) > 0.0 and (kind < 3) == (m.mode[n] == STICK)


@compiled
def doubts(m, error):
    """Stages between which a lasting contact lets go, breaks away or turns first, if one does; (END, END): none does.

    (0, END) where stages do not tell; the second one is END where they do not show it either.
    error: of the step [tolerances].
    """
    contact, mode, looks = m.contact, m.mode, m.glances
    first, last = END, END
    if not error > LEAST_ERROR or m.live.shape[0] > 0 or m.jet.shape[0] > 0:
        return 0, END
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 0 or mode[n] == OFF:
            continue
        for kind in range(KINDS):
            if matters(m, n, kind):
                one, two = doubt(looks, 1 + KINDS * n + kind, first, last, unseen(m, kind))
                first, last = min(first, one), min(last, two)
    return first, last


@compiled
def margin_of(looks, c):
    """Smallest and largest value of column c at the stages, and by how much these may be beside the motion."""
    low, high = looks[0, c], looks[0, c]
    for i in range(1, END + 1):
        low, high = min(low, looks[i, c]), max(high, looks[i, c])
    return low, high, BESIDE * abs(looks[LAST_STAGE, c] - looks[END, c]) + SLIGHT * (high - low)


@compiled
def doubt(looks, c, first, last, lift):
    """The same for column c, as far as it is before `first` and `last`; lift: by how much it may be below zero."""
    low, high, margin = margin_of(looks, c)
    if low + lift - (high - low) > margin:
        return END, END
    margin -= lift
    for i in range(first):
        if looks[i + 1, c] < (margin if i + 1 < END else -lift) or may_dip(looks, i, END + 1, c, -margin):
            first = i
            break
    for i in range(1, last):
        if looks[i, c] < -margin - 2.0 * lift:
            last = i
            break
    return first, last


@compiled
def keep_forces(m):
    """Remember the largest forces of the lasting contacts at the stages of a step."""
    contact, mode, looks, memory = m.contact, m.mode, m.glances, m.contact_memory
    for n in range(contact.shape[0]):
        if contact[n, at.IMPACT] == 1:
            for i in range(1, END + 1):
                memory[n, at.PEAK] = max(memory[n, at.PEAK], looks[i, 1 + KINDS * n]) if mode[n] != OFF else 0.0


@compiled
def pass_look_on(m):
    """The end of a step is the start of the next."""
    looks = m.glances
    for c in range(1, looks.shape[1]):
        looks[0, c] = looks[END, c]
