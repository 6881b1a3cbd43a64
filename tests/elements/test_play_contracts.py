"""What every kind of play promises; a new kind is tested here without an edit.

Gaps, slips and gammas are derivatives along any path, contact points belong to both bodies, the arms bound how fast a
gap can bend, and the play that accuracy reckons with is the one that the contacts leave.
"""

import math

import numpy as np
import pytest

from moving_bodies import FIRST, A, B, H, Path, body_at, field_values, rng_for, turned
from rattle import registry
from rattle.jit import layout as at

pytestmark = pytest.mark.nojit

PLAYS = list(registry.kinds("clearance"))
PLACES = range(8)  # paths on which each kind is looked at: curved and straight parts of its walls
CLEARANCE = 0.05


class Played:
    """A joint with play between two bodies: its kind, its kind of play, and their parameters."""

    def __init__(self, name, place):
        rng = rng_for(name, str(place))
        self.kind = registry.kinds("clearance")[name]
        self.leaf = self.kind.leaf
        self.joint = registry.kinds("joint")[self.leaf.joint]
        self.points = list(rng.uniform(-1, 1, 4))
        self.fields = dict(zip(self.joint.fields, field_values(self.joint, rng), strict=True))
        self.dimensions = {
            table: tuple(sorted(rng.uniform(0.5, 2.0, len(wanted)))[::-1])
            for table, wanted in self.leaf.dimensions.items()
        }
        sizes = [size for table in self.dimensions.values() for size in table]
        self.p = np.array([*self.points, CLEARANCE, 0.5, *self.fields.values(), *sizes])
        self.path = Path(rng)

    def touched(self, q, v):
        """Contact kinematics (contacts, 18) of the two bodies."""
        found = np.zeros((self.leaf.contacts + 1, 18))
        for n in range(self.leaf.contacts):
            self.kind.kernel(body_at(q, v), A, B, self.p, 0, n, n + 1, found)
        assert not found[0].any(), "a kernel writes its own row only"
        return found[1:]

    def at(self, t):
        return self.touched(self.path.q(t), self.path.v(t))

    def closed(self, e):
        """Positions (3, 3) in which the joint without play is closed, its points near each other, B displaced by e."""
        x, y, changes = self.leaf.displaced(self.fields, np.array(e))
        points = [self.points[0] + x, self.points[1] + y, *self.points[2:]]
        p = np.array(points + [self.fields[key] + changes.get(key, 0.0) for key in self.fields])
        q, none = self.path.q(0.3), np.zeros((3, 3))
        q[B] = q[A] + 0.1
        q[B, :2] += turned(q[A, 2], points[:2]) - turned(q[B, 2], points[2:])
        for _ in range(30):
            rows = np.zeros((len(self.joint.leaf.rows), at.width("rows")))
            self.joint.kernel(body_at(q, none), A, B, p, 0, 0, rows)
            q[B] -= np.linalg.lstsq(rows[:, at.BX :], rows[:, at.RES], rcond=None)[0]
        assert np.abs(rows[:, at.RES]).max() < 1e-13
        return q


@pytest.fixture(params=[(name, place) for name in PLAYS for place in PLACES], ids=lambda one: f"{one[0]}-{one[1]}")
def played(request):
    return Played(*request.param)


def directions(row):
    """Normal and tangent of one contact, and the arms of its point on A and B."""
    n = row[[at.NX, at.NY]]
    return n, np.array([-n[1], n[0]]), row[[at.PAX, at.PAY]], row[[at.PBX, at.PBY]]


def of_point(rates, arm):
    """Velocity (or the part of the acceleration without centripetal terms) of a point of a body."""
    return rates[:2] + rates[2] * np.array([-arm[1], arm[0]])


@pytest.mark.usefixtures("mode")
def test_gap_rate_is_the_derivative_of_the_gap(played):
    slope = (played.at(0.3 + H)[:, at.GAP] - played.at(0.3 - H)[:, at.GAP]) / (2 * H)
    np.testing.assert_allclose(played.at(0.3)[:, at.DGAP], slope, atol=10 * FIRST)


@pytest.mark.usefixtures("mode")
def test_rates_are_those_of_the_material_points_that_meet(played):
    q, v = played.path.q(0.3), played.path.v(0.3)
    for row in played.touched(q, v):
        n, t, arm_a, arm_b = directions(row)
        assert n @ n == pytest.approx(1.0, abs=1e-14)
        np.testing.assert_allclose(q[A, :2] + arm_a, q[B, :2] + arm_b, atol=1e-14)  # one place
        u = of_point(v[B], arm_b) - of_point(v[A], arm_a)
        assert -row[at.DGAP] == pytest.approx(n @ u, abs=1e-13)
        assert row[at.SLIP] == pytest.approx(t @ u, abs=1e-13)


@pytest.mark.usefixtures("mode")
def test_normal_is_the_way_on_which_the_gap_closes(played):
    q, v = played.path.q(0.3), np.zeros((3, 3))
    before = played.touched(q, v)
    for k, row in enumerate(before):
        moved = q.copy()
        moved[B, :2] += 1e-6 * directions(row)[0]
        assert played.touched(moved, v)[k, at.GAP] == pytest.approx(row[at.GAP] - 1e-6, abs=1e-11)  # 1e-6^2 / distance


@pytest.mark.usefixtures("mode")
def test_gammas_complete_the_second_derivatives(played):
    before, now, after = (played.at(0.3 + dt) for dt in (-H, 0.0, H))
    dv = played.path.dv(0.3)
    for k, row in enumerate(now):
        n, t, arm_a, arm_b = directions(row)
        pull = of_point(dv[B], arm_b) - of_point(dv[A], arm_a)
        slope = (after[k] - before[k]) / (2 * H)
        assert n @ pull - row[at.GAMMA_N] == pytest.approx(-slope[at.DGAP], rel=1e-6, abs=1e-6)
        assert t @ pull - row[at.GAMMA_T] == pytest.approx(slope[at.SLIP], rel=1e-6, abs=1e-6)


def test_arms_bound_how_fast_a_gap_bends(played):
    """The bound with which events are searched, here from the rates at one instant."""
    arm_a, arm_b = played.leaf.levers(played.p)
    q, v, dv = played.path.q(0.3), played.path.v(0.3), played.path.dv(0.3)
    before, now, after = (played.at(0.3 + dt) for dt in (-1e-4, 0.0, 1e-4))
    wa, wb = abs(v[A, 2]), abs(v[B, 2])
    bend = math.hypot(*(dv[B] - dv[A])[:2]) + arm_b * (wb**2 + abs(dv[B, 2])) + arm_a * (wa**2 + abs(dv[A, 2]))
    if played.leaf.walls_turn:
        away = math.hypot(*(q[B] - q[A])[:2]) + arm_a + arm_b
        speed = math.hypot(*(v[B] - v[A])[:2]) + arm_a * wa + arm_b * wb
        bend += (wa**2 + abs(dv[A, 2])) * away + 2 * wa * speed
    for k, row in enumerate(now):
        round_ = row[at.ACROSS] ** 2 / abs(CLEARANCE - row[at.GAP]) if played.leaf.rounded else 0.0
        second = (after[k, at.GAP] - 2 * row[at.GAP] + before[k, at.GAP]) / 1e-8
        assert abs(second) <= bend + round_ + 1e-5
    assert played.leaf.rounded or not now[:, at.ACROSS].any(), "only round a curve is there a speed round it"


def test_closed_joint_has_the_clearance_all_around(played):
    assert played.touched(played.closed((0.0, 0.0)), np.zeros((3, 3)))[:, at.GAP].min() == pytest.approx(
        CLEARANCE, abs=1e-12
    )


@pytest.mark.parametrize("angle", [0.1, 1.5, 2.0, 3.5, 5.0])
def test_tips_of_the_free_play_lie_on_the_wall_and_nothing_lies_beyond(played, angle):
    free = played.leaf.free_play(CLEARANCE, played.fields, played.dimensions)
    y = np.array([math.cos(angle), math.sin(angle)])
    assert not free.unbounded

    def least(e):
        return played.touched(played.closed(e), np.zeros((3, 3)))[:, at.GAP].min()

    for second in (False, True) if free.two_tips else (None,):
        tip = free.tip(y, second)
        assert least(tip) == pytest.approx(0.0, abs=1e-12)
        assert least(0.9 * tip) > 0.0
        assert least(1.1 * tip) < 0.0
    value, e = free.first_order(y)
    assert value == pytest.approx(y @ e, abs=1e-15)
    if (side := free.side(free.tip(y, None), y)) is not None:
        length, place = side
        assert [least(place(s * length)) for s in (0.0, 0.3, 0.7, 1.0)] == pytest.approx([0.0] * 4, abs=1e-12)
