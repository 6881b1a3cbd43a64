"""Modes of closed contacts beside joints that rub by their reactions: the forces of contacts change these reactions.

The problem for the modes is linear in the forces f of the contacts, friction that slips is not: |lambda(f)| of a guide
even changes its sign.  Linearised without contacts, friction may be far from what it is, and the modes wrong.  So the
problem is solved again, linearised at the forces that were found, until they stay the same (Newton's method):

    a(f) ~ a(f_k) + G_k (f - f_k),     G_k and a(f_k) with the friction of joints that belongs to f_k
"""

from __future__ import annotations

from rattle.equations.complementarity import F
from rattle.equations.dry_friction import complete_dry_friction
from rattle.equations.friction_beside_contacts import follow
from rattle.equations.unilateral import add_forces, lasting_rows
from rattle.jit import layout as at
from rattle.jit.functions import compiled
from rattle.solvers.dry_friction_modes import KEEP, violation

MOST_LINEARISED = 12  # times a problem is linearised anew; Newton's method needs three or four
SAME = 1e-10  # share of the largest force within which two rounds agree: well below what events resolve


@compiled
def expect_nothing(m):
    """Let the first problem be linearised at no forces."""
    for r in range(m.expected_force.shape[0]):
        m.expected_force[r] = 0.0


@compiled
def take_expected(m, count, share):
    """Add a share of the expected forces to the motion in the workspace, and to the friction of joints."""
    side, expected = m.side, m.expected_force
    for k in range(count):
        for d in range(2):
            side[F, 2 * k + d] = share * expected[2 * m.active[k] + d]
    add_forces(m, count, m.acceleration, m.multiplier)
    follow(m, count, side[F])


@compiled
def linearise_at_expected(m, count):
    """Rows of the active contacts at the expected forces; the motion becomes that without forces, as far as linear.

    False if friction locks there.
    """
    take_expected(m, count, 1.0)
    complete_dry_friction(m)
    if m.dry_memory[0, at.DRY_LOCKS] == 1.0:
        return False
    lasting_rows(m, count)
    take_expected(m, count, -1.0)
    return True


@compiled
def rubs(m):
    """True if friction of a joint depends on its reaction: it slips, or has a law."""
    for n in range(m.dry.shape[0]):
        if m.dry[n, at.DRY_LAW] >= 0 or m.dry_memory[n, at.DRY_MODE] != at.DRY_STICKS:
            return True
    return False


@compiled
def expect_solution(m, count):
    """Expect the forces of the present solution; True if they differ from those at which it was linearised."""
    side, expected, change, size = m.side, m.expected_force, 0.0, 0.0
    for r in range(expected.shape[0]):
        size = max(size, abs(expected[r]))
    for r in range(2 * count):
        size = max(size, abs(side[F, r]))
    for n in range(expected.shape[0] // 2):
        for d in range(2):
            force = 0.0
            for k in range(count):
                force = side[F, 2 * k + d] if m.active[k] == n else force
            change = max(change, abs(force - expected[2 * n + d]))
            expected[2 * n + d] = force
    return change > SAME * size


@compiled
def agrees_with_joints(m, count, added):
    """True if the joints whose modes are being tried may have them beside the present forces of the contacts.

    added: the motion in the workspace contains these forces.
    """
    tried = False
    for n in range(m.dry.shape[0]):
        tried = tried or m.dry_memory[n, at.DRY_REST] == 1.0
    if not tried:
        return True
    if not added:
        add_forces(m, count, m.acceleration, m.multiplier)
    follow(m, count, m.side[F])
    complete_dry_friction(m)
    agrees = m.dry_memory[0, at.DRY_LOCKS] == 0.0
    for n in range(m.dry.shape[0]):
        agrees = agrees and (m.dry_memory[n, at.DRY_REST] == 0.0 or violation(m, n, KEEP) == 0.0)
    return agrees
