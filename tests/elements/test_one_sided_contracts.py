"""What every kind of one-sided joint promises; a new kind is tested here without an edit.

Gaps and gammas are derivatives along any path, the normal row is that of a force on both bodies, and the constants of
the kind bound how fast a gap can bend.
"""

import math

import numpy as np
import pytest

from moving_bodies import FIRST, A, B, H, Path, body_at, field_values, rng_for, turned
from rattle import registry
from rattle.jit import layout as at
from rattle.language.local_function import packed

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

KINDS = list(registry.kinds("one-sided"))
OF_PARTS = {"locked-arcs", "by-outline"}  # walls of several parts, the nearest of which counts
KINK = 1e-2  # change of the slope of a gap [m/s] that is no curvature
PLACES = 6  # paths: on different parts of walls that have several


def possible_fields(joint, leaf, rng):
    """Values of the fields of a kind of joint that go together and with a kind of contacts."""
    while True:
        values = iter(field_values(joint, rng))
        fields = {
            key: tuple(sorted((next(values), next(values)), reverse=True)) if one.shape == "pair" else next(values)
            for key, one in joint.fields.items()
            if one.shape != "labels"
        }
        written = {key: value for key, value in fields.items() if value and (key != "axis" or not fields.get("radius"))}
        fits = joint.name != "surface" or not any(joint.leaf.faults(written, fields))
        if fits and leaf.suits(fields) and not joint.leaf.fault(fields):
            return fields


def outline(rng):
    """A polygon about its mass centre with one concave corner."""
    turns = np.sort(rng.uniform(0, 0.8, 5)) + 2 * math.pi / 5 * np.arange(5)
    far = rng.uniform(0.6, 1.0, 5) * [1, 1, 0.3, 1, 1]
    return {
        str(n): (r * math.cos(turn), r * math.sin(turn)) for n, (r, turn) in enumerate(zip(far, turns, strict=True))
    }


class Pushed:
    """Two bodies on a path with a one-sided joint between them, which touches at the time 0.3 s."""

    def __init__(self, name, place):
        rng = rng_for(name, str(place))
        self.kind, self.path = registry.kinds("one-sided")[name], Path(rng)
        self.leaf = self.kind.leaf
        joint = registry.kinds("joint")[self.leaf.joint]
        self.points = rng.uniform(-1, 1, 4)
        self.fields, self.corners = possible_fields(joint, self.leaf, rng), outline(rng)
        self.count = self.leaf.count(self.fields, self.corners)
        self.shift, d = np.zeros((3, 3)), (1.0, 0.0)
        if (fit := joint.leaf.fit(self.fields)) is not None:  # centres that move about the distance that suits them
            self.path.a[:, :2] *= 0.05
            q, way = self.path.q(0.3), rng.uniform(-3, 3)
            apart = q[B, :2] + turned(q[B, 2], self.points[2:]) - q[A, :2] - turned(q[A, 2], self.points[:2])
            d = 1.02 * fit.distance * np.array([math.cos(way), math.sin(way)])
            self.shift[B, :2] = d - apart
        self.constants = joint.leaf.start_constants((rng.uniform(0.1, 1.0),), d) if joint.leaf.from_start else ()
        self.p = np.array(packed([*self.points, *self.leaf.parameters(self.fields, self.constants, self.corners)]))

    def at(self, t, move=0.0):
        q = self.path.q(t) + self.shift + move
        found = np.zeros((self.count, at.width("contact_kinematics")))
        for corner in range(self.count):
            self.kind.kernel(body_at(q, self.path.v(t)), A, B, self.p, 0, corner, corner, found)
        return found

    def touch(self, corner):
        """Move B along the normal until one gap is closed at the time 0.3 s."""
        for _ in range(3 if self.leaf.one_way(self.fields) else 0):  # over the segment
            here = self.at(0.3)[corner]
            self.shift[B, :2] += (self.path.q(0.3) + self.shift)[A, :2] - (self.path.q(0.3) + self.shift)[B, :2]
            self.shift[B, :2] += turned(self.path.q(0.3)[A, 2], self.points[:2]) - here[[at.PBX, at.PBY]]
        for _ in range(60):
            one = self.at(0.3)[corner]
            w = row(one)[3:]
            way, old = w * [1, 1, 0], turned((self.path.q(0.3) + self.shift)[B, 2], self.points[2:])
            if self.constants:  # teeth meet by turning about their centre, surfaces by moving
                way = np.array([old[1], -old[0], 1.0])
            step = one[at.GAP] * way / (w @ way)
            if not self.constants:
                step *= 0.7  # the nearest of several parts may change on the way
            self.shift[B, 2] += step[2]
            new = turned((self.path.q(0.3) + self.shift)[B, 2], self.points[2:])
            self.shift[B, :2] += old - new if step[2] else step[:2]
        smooth = abs(sum(self.at(0.3 + dt)[corner, at.GAP] for dt in (-H, H))) < KINK * H
        if self.kind.name in OF_PARTS and not (smooth and abs(self.at(0.3)[corner, at.GAP]) < 1e-12):
            pytest.skip("two parts of a wall are equally near on this path")
        assert abs(self.at(0.3)[corner, at.GAP]) < 1e-12


def row(one):
    """The normal row w (6,) of a contact, for the rates of A and of B."""
    n, a, b = one[[at.NX, at.NY]], one[[at.PAX, at.PAY]], one[[at.PBX, at.PBY]]
    on_a, on_b = a[0] * n[1] - a[1] * n[0], b[0] * n[1] - b[1] * n[0]
    return np.array([*-n, -on_a - one[at.TURN], *n, on_b + one[at.TURN]])


@pytest.fixture(
    params=[(name, place) for name in KINDS for place in range(PLACES)], ids=lambda one: f"{one[0]}-{one[1]}"
)
def pushed(request):
    return Pushed(*request.param)


def test_normal_row_is_minus_the_derivative_of_the_gap(pushed):
    here = pushed.at(0.3)
    for corner, one in enumerate(here):
        slopes = []
        for body in (A, B):
            for q in range(3):
                move = np.zeros((3, 3))
                move[body, q] = H
                slopes.append((pushed.at(0.3, move) - pushed.at(0.3, -move))[corner, at.GAP] / (2 * H))
        np.testing.assert_allclose(row(one), -np.array(slopes), rtol=1e-6, atol=1e-6)  # small wheels: H^2 g'''


def test_where_they_touch_the_gap_is_a_distance_and_gamma_completes_its_second_derivative(pushed):
    v, dv = pushed.path.v(0.3), pushed.path.dv(0.3)
    for corner in range(pushed.count):
        pushed.touch(corner)
        before, one, after = (pushed.at(0.3 + dt)[corner] for dt in (-H, 0.0, H))
        assert math.hypot(one[at.NX], one[at.NY]) == pytest.approx(1.0, abs=1e-12)
        assert -one[at.DGAP] == pytest.approx(row(one) @ np.concatenate([v[A], v[B]]), abs=1e-12)
        slope = (after - before) / (2 * H)
        assert one[at.DGAP] == pytest.approx(slope[at.GAP], abs=10 * FIRST)
        second = row(one) @ np.concatenate([dv[A], dv[B]]) - one[at.GAMMA_N]
        assert -second == pytest.approx(slope[at.DGAP], rel=1e-6, abs=1e-6)


def test_a_one_sided_joint_that_slides_has_the_slip_of_the_material_points_that_meet(pushed):
    v, dv = pushed.path.v(0.3), pushed.path.dv(0.3)
    for corner in range(pushed.count) if pushed.leaf.slides else ():
        before, one, after = (pushed.at(0.3 + dt)[corner] for dt in (-H, 0.0, H))
        n, a, b = one[[at.NX, at.NY]], one[[at.PAX, at.PAY]], one[[at.PBX, at.PBY]]
        t = np.array([-n[1], n[0]])
        q = pushed.path.q(0.3) + pushed.shift
        np.testing.assert_allclose(q[A, :2] + a, q[B, :2] + b, atol=1e-14)  # one place
        w = np.array([*-t, -(a[0] * t[1] - a[1] * t[0]), *t, b[0] * t[1] - b[1] * t[0]])
        assert one[at.SLIP] == pytest.approx(w @ np.concatenate([v[A], v[B]]), abs=1e-12)
        second = w @ np.concatenate([dv[A], dv[B]]) - one[at.GAMMA_T]
        assert second == pytest.approx((after - before)[at.SLIP] / (2 * H), rel=1e-6, abs=1e-5)


def test_a_one_sided_joint_exerts_as_much_on_one_body_as_on_the_other(pushed):
    """Force and moment about one point are opposite: a shift and a turn of both bodies do no work."""
    q = pushed.path.q(0.3) + pushed.shift
    for one in pushed.at(0.3):
        w = row(one)
        np.testing.assert_allclose(w[:2], -w[3:5], atol=1e-15)
        turn = np.array([-q[A, 1], q[A, 0], 1.0, -q[B, 1], q[B, 0], 1.0])
        assert w @ turn == pytest.approx(0.0, abs=1e-13)


def test_constants_bound_how_fast_a_gap_bends(pushed):
    """The bound with which events are searched (`solvers.contacts.gap_search`), where they touch."""
    leaf = pushed.leaf
    slope, curve, bow = leaf.bends(pushed.fields, pushed.constants)
    for corner in range(pushed.count):
        pushed.touch(corner)
        q, v, dv = pushed.path.q(0.3) + pushed.shift, pushed.path.v(0.3), pushed.path.dv(0.3)
        arm_a, arm_b = leaf.levers(pushed.p)
        wa, wb, alpha_a, alpha_b = abs(v[A, 2]), abs(v[B, 2]), abs(dv[A, 2]), abs(dv[B, 2])
        bend = math.hypot(*(dv[B] - dv[A])[:2]) + arm_b * (wb**2 + alpha_b) + arm_a * (wa**2 + alpha_a)
        away = math.hypot(*(q[B] - q[A])[:2]) + arm_a + arm_b
        speed = math.hypot(*(v[B] - v[A])[:2]) + arm_a * wa + arm_b * wb
        if leaf.walls_turn:
            w, alpha = (wa, alpha_a) if leaf.turning == at.A_BODY else (wb, alpha_b)
            bend += (w**2 + alpha) * away + 2 * w * speed
            speed += w * away
        bend += bow * speed**2 + slope * (alpha_a + alpha_b) + curve * (wa + wb) ** 2
        if leaf.rounded:
            bend += pushed.at(0.3)[corner, at.ACROSS] ** 2 / leaf.scale(pushed.p, math.inf)
        before, here, after = (pushed.at(0.3 + dt)[corner, at.GAP] for dt in (-1e-4, 0.0, 1e-4))
        assert abs(after - 2 * here + before) / 1e-8 <= bend + 1e-5
