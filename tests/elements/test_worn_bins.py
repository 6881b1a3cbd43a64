"""A worn pin in its bush at one instant: closed form of a round pin, and what any profiles promise."""

import math

import numpy as np
import pytest

import rattle as rt
from rattle import registry
from rattle.equations.compliant import add_contact_forces, locate_contacts
from rattle.equations.motion import place
from rattle.equations.worn_contact import worn_energy
from rattle.jit import layout as at

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
C, R, L, K = 5e-5, 0.01, 0.02, 1e12
BED = R * L * K  # N/m
LAW = '{ model = "lankarani-nikravesh", restitution = 0.5, stiffness = 1e9, length = 0.02, bush_radius = 0.01'


def pair(depths="{}", bins=360, friction=""):
    """Two free bodies with a worn pin between them."""
    return rt.loads(f"""
format = 1
bodies.arm = {{ points = {{ O = [0.1, 0.02] }}, mass = 1, inertia = 1e-3 }}
bodies.pin = {{ points = {{ P = [0.03, -0.05] }}, mass = 1, inertia = 1e-3 }}
[joints.O]
type = "revolute"
connect = ["arm.O", "pin.P"]
clearance = {C}
contact = {LAW}{friction} }}
wear = {{ foundation = {K}, bins = {bins}, depths = {depths} }}
""")


def worn(n, seed=3):
    """Two smooth profiles of random shape, as they stand in a model."""
    rng = np.random.default_rng(seed)
    theta = (np.arange(n) + 0.5) * 2 * math.pi / n
    sides = []
    for _ in range(2):
        wave = sum(a * np.cos(k * theta + b) for k, (a, b) in enumerate(rng.uniform(-1, 1, (6, 2)) * [1, 3], 1))
        sides.append(0.3 * C * (wave - wave.min()) / np.ptp(wave))
    return f"{{ bush = {sides[0].tolist()}, pin = {sides[1].tolist()} }}"


class Instant:
    """The contact of a model where its pin is displaced from the centre of its bush by e [m]."""

    def __init__(self, model):
        self.m = model.system.workspace()
        self.points = [model.model.joints["O"].a.at, model.model.joints["O"].b.at]
        self.m.contact_memory[:, at.SPEED] = 0.2

    def q(self, e, turned=(0.0, 0.0)):
        """Coordinates with the pin at e [m], both bodies turned [rad]."""
        arms = [
            np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]]) @ p
            for a, p in zip(turned, self.points, strict=True)
        ]
        return np.array([0.0, 0.0, turned[0], *(arms[0] + e - arms[1]), turned[1]])

    def at(self, q, v=None):
        """Generalised forces (6,) of the contact, and its kinematics."""
        place(self.m, q, np.zeros(6) if v is None else v)
        locate_contacts(self.m)
        self.m.force[:] = 0.0
        add_contact_forces(self.m)
        return self.m.force[1:].ravel().copy(), self.m.contact_kinematics[0].copy()

    def energy(self, q):
        place(self.m, q, np.zeros(6))
        return worn_energy(self.m, 0)


def bearing(e):
    """Closed form of the force [N] of a round pin on the foundation, and of its stored energy [J]."""
    theta = math.acos(C / e)
    force = BED * C * (theta / math.cos(theta) - math.sin(theta))
    squares = 0.5 * e * e * (theta + 0.5 * math.sin(2 * theta)) - 2 * e * C * math.sin(theta) + C * C * theta
    return force, BED * squares  # 1/2 K_w int (e cos - c)^2 dA


@pytest.mark.parametrize("depth", [0.005, 0.05, 0.5, 3.0])
def test_a_round_pin_is_borne_as_in_closed_form(depth):
    here, e = Instant(pair()), C * (1 + depth)
    force, energy = bearing(e)
    # bins of 1 deg cut off the edges of the arc: (d/theta_0)^3, 3e-3 at 5.7 deg
    close = max(1e-7, 0.6 * (math.radians(1.0) / math.acos(C / e)) ** 3)
    for angle in (0.0, 0.4, 1.7, 3.0, 4.5):
        q = here.q(e * np.array([math.cos(angle), math.sin(angle)]), turned=(0.3, -0.8))
        found, touch = here.at(q)
        assert found[3:5] == pytest.approx([-force * math.cos(angle), -force * math.sin(angle)], abs=close * force)
        assert touch[at.NORMAL] == pytest.approx(force, rel=close)
        assert here.energy(q) == pytest.approx(energy, rel=2 * close)


def test_the_law_of_the_round_pin_is_the_closed_form():
    law = registry.kinds("stiffness")["foundation"]
    p = law.leaf.pack({"foundation": K, "length": L, "bush_radius": R, "clearance": C})
    for depth in (1e-7, 3e-4, 6e-4, 1e-2, 1.0):
        little = BED * C * 2 / 3 * (2 * depth) ** 1.5 * (1 - 0.65 * depth)  # the first terms of its series
        exact = bearing(C * (1 + depth))[0] if depth > 1e-3 else little
        assert law.kernel.python(C * depth, p, 0) == pytest.approx(exact, rel=1e-6)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_forces_and_moments_are_slopes_of_the_stored_energy(seed):
    here, rng = Instant(pair(worn(360, seed))), np.random.default_rng(seed)
    for _ in range(3):
        angle, step = rng.uniform(0, 6.28), 1e-9
        q = here.q(1.25 * C * np.array([math.cos(angle), math.sin(angle)]), turned=rng.uniform(-9, 9, 2))
        found, _ = here.at(q)
        for k in range(6):
            h = step if k % 3 < 2 else 1e-8
            ahead, behind = q.copy(), q.copy()
            ahead[k] += h
            behind[k] -= h
            slope = (here.energy(ahead) - here.energy(behind)) / (2 * h)
            # differences: second derivatives have corners where bins begin to touch
            assert found[k] == pytest.approx(
                -slope, rel=1e-4, abs=1e-4 * (1.0 if k % 3 < 2 else 1e-2) * abs(found[:2]).max()
            )


def test_the_contact_takes_no_momentum_and_books_its_power():
    for friction in ("", ", friction = 0.2"):
        here, rng = Instant(pair(worn(180), 180, friction)), np.random.default_rng(5)
        for _ in range(4):
            angle = rng.uniform(0, 6.28)
            q, v = (
                here.q(1.3 * C * np.array([math.cos(angle), math.sin(angle)]), rng.uniform(-3, 3, 2)),
                rng.normal(size=6),
            )
            v[[2, 5]] *= 30
            found, touch = here.at(q, v)
            (ax, ay, _, bx, by, _), (fx, fy, ma, gx, gy, mb) = q, found
            size = abs(found).max()
            assert [fx + gx, fy + gy] == pytest.approx([0, 0], abs=1e-12 * size)
            assert ma + mb + ax * fy - ay * fx + bx * gy - by * gx == pytest.approx(0, abs=1e-12 * size)
            taken = touch[at.STORE] + touch[at.LOSS]
            assert -found @ v == pytest.approx(taken, rel=1e-9)
            h = 1e-9
            rate = (here.energy(q + h * v) - here.energy(q - h * v)) / (2 * h)
            assert touch[at.STORE] == pytest.approx(rate, rel=1e-4)
            assert touch[at.LOSS] >= -1e-9 * abs(taken)


def test_turning_everything_turns_the_force():
    here, e = Instant(pair(worn(360))), 1.3 * C * np.array([0.6, -0.8])
    found, _ = here.at(here.q(e, (0.2, -0.5)))
    a = 1.234
    turn = np.array([[math.cos(a), -math.sin(a)], [math.sin(a), math.cos(a)]])
    turned, _ = here.at(here.q(turn @ e, (0.2 + a, -0.5 + a)))
    assert turned[:2] == pytest.approx(turn @ found[:2], rel=1e-9)
    assert turned[[2, 5]] == pytest.approx(found[[2, 5]], rel=1e-9)


@pytest.mark.parametrize("side", ["bush", "pin"])
def test_a_hollow_turns_with_its_body(side):
    deep, n = 0.2 * C, 360
    other = "pin" if side == "bush" else "bush"
    hollow = [deep if 60 <= i < 120 else 0.0 for i in range(n)]  # 60 to 120 deg
    here = Instant(pair(f"{{ {side} = {hollow}, {other} = {[0.0] * n} }}"))

    def touches(direction, angle):
        e = (C + 0.5 * deep) * np.array([math.cos(direction), math.sin(direction)])
        found = here.at(here.q(0.999 * e, (angle, 0.0) if side == "bush" else (0.0, angle)))[1]
        return found[at.NORMAL] > 0.0

    up = math.pi / 2
    assert not touches(up, 0.0)
    assert touches(-up, 0.0)
    for angle in (0.7, 2.9, -7.0):
        assert not touches(up + angle, angle)  # in its hollow
        assert touches(up, angle)


def test_the_force_is_smooth_where_bins_begin_to_touch():
    here = Instant(pair(bins=90))
    size = np.linspace(1.0 + 1e-4, 1.3, 4001) * C
    force = np.array([here.at(here.q(np.array([e, 0.0])))[1][at.NORMAL] for e in size[::8]])
    bend = np.diff(force, 2) / np.diff(size[::8])[0] ** 2
    slope = np.diff(force) / np.diff(size[::8])
    assert (bend > 0).all() or bend.min() > -1e-3 * bend.max()  # N ~ delta^1.5 at first: no kinks, no steps
    assert np.abs(np.diff(slope)).max() < 0.05 * slope.max()
