"""What every kind of stop promises; a new kind is tested here without an edit.

Gaps and gammas are derivatives along any path, the normal row is that of the force and moment on both bodies, and the
arms bound how fast a gap can bend.
"""

import math

import numpy as np
import pytest

from moving_bodies import FIRST, A, B, H, Path, body_at, rng_for
from rattle import registry
from rattle.jit import layout as at

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

STOPS = list(registry.kinds("stop"))
ENDS = (0.4, 1.7)


class Stopped:
    """Two bodies on a path, with a stop between them."""

    def __init__(self, name, place):
        rng = rng_for(name, str(place))
        self.kind, self.path = registry.kinds("stop")[name], Path(rng)
        self.p = np.array([*rng.uniform(-1, 1, 4), *ENDS, rng.uniform(0.0, 6.0)])

    def at(self, t, move=None):
        q = self.path.q(t)
        if move is not None:
            q = q + move
        found = np.zeros((2, at.width("contact_kinematics")))
        for corner in range(2):
            self.kind.kernel(body_at(q, self.path.v(t)), A, B, self.p, 0, corner, corner, found)
        return found


def row(one):
    """The normal row w (6,) of a contact, for the rates of A and of B."""
    n, a, b = one[[at.NX, at.NY]], one[[at.PAX, at.PAY]], one[[at.PBX, at.PBY]]
    on_a, on_b = a[0] * n[1] - a[1] * n[0], b[0] * n[1] - b[1] * n[0]
    return np.array([*-n, -on_a - one[at.TURN], *n, on_b + one[at.TURN]])


@pytest.fixture(params=[(name, place) for name in STOPS for place in range(4)], ids=lambda one: f"{one[0]}-{one[1]}")
def stopped(request):
    return Stopped(*request.param)


def test_the_two_gaps_share_the_range(stopped):
    assert stopped.at(0.3)[:, at.GAP].sum() == pytest.approx(ENDS[1] - ENDS[0], abs=1e-14)


def test_normal_row_is_minus_the_derivative_of_the_gap(stopped):
    here = stopped.at(0.3)
    for corner in range(2):
        slopes = []
        for body in (A, B):
            for q in range(3):
                move = np.zeros((3, 3))
                move[body, q] = H
                slopes.append((stopped.at(0.3, move) - stopped.at(0.3, -move))[corner, at.GAP] / (2 * H))
        np.testing.assert_allclose(row(here[corner]), -np.array(slopes), atol=FIRST)


def test_rate_and_gamma_are_derivatives_along_a_path(stopped):
    before, here, after = (stopped.at(0.3 + dt) for dt in (-H, 0.0, H))
    v, dv = stopped.path.v(0.3), stopped.path.dv(0.3)
    for corner, one in enumerate(here):
        assert -one[at.DGAP] == pytest.approx(row(one) @ np.concatenate([v[A], v[B]]), abs=1e-13)
        slope = (after - before)[corner] / (2 * H)
        assert one[at.DGAP] == pytest.approx(slope[at.GAP], abs=10 * FIRST)
        second = row(one) @ np.concatenate([dv[A], dv[B]]) - one[at.GAMMA_N]
        assert -second == pytest.approx(slope[at.DGAP], rel=1e-6, abs=1e-6)


def test_a_stop_at_rest_exerts_as_much_on_one_body_as_on_the_other(stopped):
    """Force and moment about one point are opposite: a rigid motion of both bodies changes no gap."""
    q = stopped.path.q(0.3)
    for one in stopped.at(0.3):
        w = row(one)
        np.testing.assert_allclose(w[:2], -w[3:5], atol=1e-15)
        turn = np.array([-q[A, 1], q[A, 0], 1.0, -q[B, 1], q[B, 0], 1.0])  # both turn about the origin
        assert w @ turn == pytest.approx(0.0, abs=1e-14)


def test_arms_bound_how_fast_a_gap_bends(stopped):
    """The bound with which events are searched (`solvers.contacts.gap_search`), here from the rates at one instant."""
    leaf = stopped.kind.leaf
    q, v, dv = (one(0.3) for one in (stopped.path.q, stopped.path.v, stopped.path.dv))
    arm_a, arm_b = leaf.levers(stopped.p)
    wa, wb = abs(v[A, 2]), abs(v[B, 2])
    bend = math.hypot(*(dv[B] - dv[A])[:2]) + arm_b * (wb**2 + abs(dv[B, 2])) + arm_a * (wa**2 + abs(dv[A, 2]))
    if leaf.walls_turn:
        away = math.hypot(*(q[B] - q[A])[:2]) + arm_a + arm_b
        speed = math.hypot(*(v[B] - v[A])[:2]) + arm_a * wa + arm_b * wb
        bend += (wa**2 + abs(dv[A, 2])) * away + 2 * wa * speed
    if leaf.angular:
        bend = abs(dv[B, 2] - dv[A, 2])
    before, here, after = (stopped.at(0.3 + dt)[:, at.GAP] for dt in (-1e-4, 0.0, 1e-4))
    assert (abs(after - 2 * here + before) / 1e-8 <= bend + 1e-5).all()
