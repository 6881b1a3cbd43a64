"""Runs go on where physics does: reversals of slip, rocking, jams; every end of a run is named for what it is."""

import math

import numpy as np
import pytest

import rattle as rt
from rattle.analyses.dynamics.event_driven_run import EventDrivenRun
from rattle.equations import unilateral
from rattle.jit import layout as at
from rattle.solvers.nonsmooth import event_driven

SLIDER_CRANK = """
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.crank]
bar = ["O", "A"]
length = 0.1
mass = 0.2
[bodies.rod]
bar = ["A", "B"]
length = {rod}
mass = {rod_mass}
[bodies.slider]
points = {{ B = [0, 0] }}
mass = 0.5
inertia = 1e-3
[joints.O]
type = "revolute"
connect = ["ground.O", "crank.O"]
[joints.A]
type = "revolute"
connect = ["crank.A", "rod.A"]
[joints.B]
type = "revolute"
connect = ["slider.B", "rod.B"]
clearance = {clearance}
contact = {{ model = "impact", restitution = {e}, friction = {mu}, bush_radius = 0.01 }}
[joints.guide]
type = "prismatic"
connect = ["ground.O", "slider.B"]
"""
DRIVEN = """
[drivers.motor]
joint = "O"
angle = "0.7 + 20.0*t"
[initial]
crank = { x = 0.038242109364224425, y = 0.03221088436188455, angle = 0.7, vx = -0.644217687237691, vy = 0.7648421872844885, omega = 20.0 }
rod = { x = 0.22298493179369402, y = 0.03221088436188455, angle = -0.21642482235800842, vx = -1.456600038894043, vy = 0.7648421872844885, omega = -5.220740372395733 }
slider = { x = 0.3694856448589392, y = 0.0, angle = 0.0, vx = -1.6247647033127042, vy = 0.0, omega = 0.0 }
"""  # noqa: E501
TURNED = """
[loads.M]
type = "torque"
body = "crank"
torque = 5
[initial]
crank = { angle = 0, omega = 10 }
rod = { angle = 0 }
"""
# the rod is 100 mm and longer than what it is pinned to, or shorter: then the crank cannot turn over
LONG = SLIDER_CRANK.format(rod=0.3, rod_mass=0.4, clearance=1e-4, e=0.5, mu=0.1) + DRIVEN
SHORT = SLIDER_CRANK.format(rod=0.08, rod_mass=0.2, clearance=1e-3, e=0.3, mu=0.05) + TURNED

# half length and half height of a block that rocks on its corners [m]
A, B = 0.06, 0.1


def rocking(e=0.0, mu=5.0, tilt=0.27, clearance=1.0) -> rt.Mechanism:
    """A block of 0.12 x 0.2 m starts at rest on one of its lower corners, tilted [rad]."""
    y = -(B + clearance) + A * math.sin(tilt) + B * math.cos(tilt)
    return rt.loads(f"""
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.block]
mass = 1
inertia = {(A * A + B * B) / 3}
points = {{ P = [0, 0] }}
[joints.floor]
type = "prismatic"
connect = ["ground.O", "block.P"]
axis = 0
angle = 0
clearance = {clearance}
block = {{ length = {2 * A}, height = {2 * B} }}
contact = {{ model = "impact", restitution = {e}, friction = {mu} }}
[initial]
block = {{ x = 0, y = {y!r}, angle = {tilt}, vx = 0, vy = 0, omega = 0 }}
""")


def rocking_times(tilt: float) -> np.ndarray:
    """Times [s] of all impacts of the plastic rocking block, from quadrature and Housner's 1 - 3/2 sin^2."""
    alpha = math.atan2(A, B)
    p2 = 9.81 * math.hypot(A, B) / (4 / 3 * (A * A + B * B))
    keeps = 1 - 1.5 * math.sin(alpha) ** 2
    s, weight = np.polynomial.legendre.leggauss(60)
    s, weight = 0.5 * (s + 1), 0.5 * weight

    def quarter(amplitude):  # theta = amplitude (1 - s^2) takes the singular end away
        fall = 2 * np.sin(0.5 * amplitude * s**2) * np.sin(alpha - amplitude + 0.5 * amplitude * s**2)
        return float((weight * 2 * amplitude * s / np.sqrt(2 * p2 * fall)).sum())

    times, amplitude, start = [], tilt, 0.0
    while amplitude > 1e-30:
        t = quarter(amplitude)
        times.append(start + t)
        w2 = keeps**2 * 4 * p2 * math.sin(0.5 * amplitude) * math.sin(alpha - 0.5 * amplitude)
        # cos(alpha - a) - cos(alpha) = w^2/(2 p^2) = 2 sin(a/2) sin(alpha - a/2)
        low, high = 0.0, amplitude
        for _ in range(80):
            middle = 0.5 * (low + high)
            less = 4 * p2 * math.sin(0.5 * middle) * math.sin(alpha - 0.5 * middle) < w2
            low, high = (middle, high) if less else (low, middle)
        amplitude = 0.5 * (low + high)
        start = times[-1] + quarter(amplitude)
    return np.array(times)


# ---------------------------------------------------------------- slip that turns around
@pytest.mark.parametrize("rtol", [1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-12])
@pytest.mark.parametrize(
    ("text", "end", "times"),
    [
        (LONG, 0.01, (0.009478056, 0.009504183, 0.009975911)),  # independent code
        (SHORT, 0.2768, (0.276275206, 0.276283873, 0.276575968)),
    ],
)
def test_slip_reverses_sticks_and_slips_again_at_any_tolerance(text, end, times, rtol):
    r = rt.loads(text).simulate(end, rtol=rtol)
    assert r.success, r.message
    found = [one for one in r.events if one.kind in ("slip", "stick")][-3:]
    assert [one.kind for one in found] == ["slip", "stick", "slip"]
    # the reference has 9 decimals; the error of the run is about its tolerance
    assert [one.t for one in found] == pytest.approx(times, abs=1e-9 + rtol)


def test_slip_after_a_reversal_has_the_sense_that_the_accelerations_give_it():
    r = rt.loads(SHORT).simulate(t_eval=[0.27627, 0.27628, 0.27629])
    share = r["B.tangential"] / r["B.normal"]
    assert share[0] == pytest.approx(0.05, rel=1e-9)
    assert share[1] == pytest.approx(-0.05, rel=1e-9)
    assert abs(share[2]) < 0.05


def test_no_slider_crank_stops_with_contacts_that_change_without_end():
    rng = np.random.default_rng(6)
    turned = 0
    for _ in range(16):
        speed, angle, rod = rng.uniform(10, 60) * rng.choice([-1, 1]), rng.uniform(0, 6.28), rng.uniform(0.22, 0.4)
        slant = -math.asin(0.1 * math.sin(angle) / rod)
        text = SLIDER_CRANK.format(
            rod=rod,
            rod_mass=rng.uniform(0.1, 0.5),
            clearance=10 ** rng.uniform(-4, -3),
            e=rng.choice([0.0, 0.3, 0.5, 0.8]),
            mu=rng.choice([0.02, 0.05, 0.1, 0.2, 0.3]),
        )
        text += f"""
[drivers.motor]
joint = "O"
angle = "{angle} + {speed}*t"
[initial]
crank = {{ angle = {angle}, omega = {speed} }}
rod = {{ angle = {slant} }}
"""
        r = rt.loads(text).simulate(4 * math.pi / abs(speed), rtol=10.0 ** -int(rng.integers(6, 10)))
        assert r.success, r.message
        turned += sum(one.kind in ("slip", "stick") for one in r.events)
    assert turned > 100


# ---------------------------------------------------------------- rocking
def test_rocking_block_comes_to_rest_at_the_end_of_its_infinite_sequence():
    tilt = 0.27
    times = rocking_times(tilt)
    r = rocking(tilt=tilt).simulate(1.2, rtol=1e-11, atol=1e-14)
    assert r.success, r.message
    hits = np.array(sorted({one.t for one in r.events if one.kind == "impact"}))
    assert hits[:15] == pytest.approx(times[:15], abs=1e-9)
    gaps = np.diff(hits)
    assert gaps[-5:] / gaps[-6:-1] == pytest.approx(1 - 1.5 * A * A / (A * A + B * B), rel=1e-3)
    # what is left when the rise falls below 1e-11 m lasts some 1e-5 s, its ratio known to 1e-5
    assert max(one.t for one in r.events if one.kind == "contact") == pytest.approx(times[-1], abs=2e-9)
    late = r.t > times[-1] + 1e-3
    assert np.abs(r["block.omega"][late]).max() < 1e-12
    assert np.abs(r["block.angle"][late]).max() < 1e-9
    assert r["energy.balance"] == pytest.approx(0.0, abs=1e-9)
    assert "infinite series" in " ".join(r.trust.notes)


@pytest.mark.parametrize(("e", "mu"), [(0.3, 5.0), (0.7, 5.0), (0.5, 0.4)])
def test_rocking_that_bounces_comes_to_rest_too(e, mu):
    r = rocking(e, mu).simulate(2.0)
    assert r.success, r.message
    assert abs(r["block.omega"][-1]) < 1e-12
    assert abs(r["block.angle"][-1]) < 1e-8
    assert r["floor.normal"][-1] == pytest.approx(9.81, rel=1e-9)
    hits = [one for one in r.events if one.kind == "impact"]
    closed = [one for one in r.events if one.kind == "contact"]
    assert max(one.t for one in closed) > max(one.t for one in hits)
    assert len(hits) < 1000


def test_end_of_a_sequence_does_not_depend_on_the_tolerance():
    ends = []
    for rtol in (1e-9, 1e-10, 1e-11):
        events = rocking(0.2).simulate(1.0, rtol=rtol).events
        ends.append(max(one.t for one in events if one.kind == "contact"))
    assert np.ptp(ends) < 2e-7  # of a fall from the edge of tipping over, which lets errors grow


def test_crowded_events_are_named_as_such(monkeypatch):
    def crowded(self, t, chunk):
        self.workspace.stuck[at.EVENT_WHO] = 0.0
        self.workspace.stuck[at.EVENTS_IN_A_ROW] = event_driven.MOST_IN_A_ROW + 1.0
        return unilateral.CHATTER

    monkeypatch.setattr(EventDrivenRun, "advance", crowded)
    r = rocking().simulate(1.0)
    assert not r.success
    assert "200001 events in a row" in r.message
    assert "1e-06 s" in r.message
    assert "'floor'" in r.message


# ---------------------------------------------------------------- jams
def painleve_rod(angle: float, mu: float, jam: str, slip: float) -> rt.Mechanism:
    """A slender rod of 2 m and 1 kg slides with its lower end on the floor at the given speed [m/s], tilted [deg]."""
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    return rt.loads(f"""
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.rod]
points = {{ P = [{c}, {-s}] }}
mass = 1
inertia = {1 / 3}
[joints.tip]
type = "prismatic"
connect = ["ground.O", "rod.P"]
axis = 0
angle = 0
clearance = 2
block = {{ length = 1e-4, height = 1e-4 }}
contact = {{ model = "impact", friction = {mu}, jam = "{jam}" }}
[initial]
rod = {{ x = 0, y = {s - 2}, angle = 0, vx = {slip}, vy = 0, omega = 0 }}
""")


def test_painleve_rod_locks_where_its_closed_form_says_and_only_there_is_painleve_named():
    for angle in (40, 55, 65, 80):
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        for slip in (-1.0, 1.0):
            # the end is ahead of the mass centre: friction turns it into the floor when it slides forward
            locks = 1 + 3 * c * (c - 1.6 * s * slip) < 0
            r = painleve_rod(angle, 1.6, "stop", slip).simulate(1e-3)
            assert r.success != locks
            assert ("Painleve" in r.message) == locks


def test_jam_is_passed_by_an_impact_that_ends_slip_and_takes_energy():
    angle, mu, slip = 55, 1.6, 1.0
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    r = painleve_rod(angle, mu, "impact", slip).simulate(1e-3)
    assert r.success, r.message
    assert "without collision" in " ".join(r.trust.notes)
    hits = [one for one in r.events if one.kind == "impact" and one.t == 0.0]
    assert all(one.normal_speed < 1e-12 for one in hits)
    # G of the end of the rod, whose arm is (c, -s), and what it costs to stop the slip with the end on the floor
    normal, tangential, both = 1 + 3 * c * c, 1 + 3 * s * s, 3 * c * s
    lost = 0.5 * slip**2 / (tangential - both**2 / normal)
    assert sum(one.energy_lost for one in hits) == pytest.approx(lost, rel=1e-3)  # two corners 0.1 mm apart
    total = r["energy.kinetic"] + r["energy.potential"]
    assert np.diff(total).max() < 1e-9
    assert r.trust.energy_balance < 1e-9
    end = r["rod.vx"] + r["rod.omega"] * (s * np.cos(r["rod.angle"]) - c * np.sin(r["rod.angle"]))
    assert abs(end[1]) < 0.05  # it has stopped, and may slip anew from rest


def test_lock_on_the_way_is_passed_too():
    text = """
format = 1
gravity = [0, -10]
[ground.points]
O = [0, 0]
[bodies.rod]
points = { P = [0.6, -0.8] }
mass = 1
inertia = 0.01
[joints.tip]
type = "prismatic"
connect = ["ground.O", "rod.P"]
axis = 0
angle = 0
clearance = 1
block = { length = 1e-4, height = 1e-4 }
contact = { model = "impact", restitution = 0, friction = 3, jam = "impact" }
[initial]
rod = { x = 0, y = -0.1999, angle = 0, vx = -3, vy = 0, omega = 0 }
"""
    r = rt.loads(text).simulate(0.5)
    assert r.success, r.message
    note = next(one for one in r.trust.notes if "without collision" in one)
    assert "t = 0.474" in note
    assert "'tip'" in note
    total = r["energy.kinetic"] + r["energy.potential"]
    assert np.diff(total).max() < 1e-6
    stopped = rt.loads(text.replace('jam = "impact"', 'jam = "stop"')).simulate(0.5)
    assert 'or jam = "impact"' in stopped.message


# ---------------------------------------------------------------- dead ends
def test_moreau_jean_ends_where_its_driver_pushes_against_a_dead_end():
    # the crank is longer than the rod: the driver cannot turn it beyond asin(0.08/0.1) and some play, t = 0.0927 s
    crank = (
        SHORT.split("[loads.M]")[0]
        + """
[drivers.motor]
joint = "O"
angle = "10*t"
[initial]
crank = { angle = 0, omega = 10 }
rod = { angle = 0 }
"""
    )
    r = rt.loads(crank).simulate(0.3, method="moreau")
    assert not r.success
    assert "dead end" in r.message
    assert 0.0927 < r.t[-1] < 0.096
    assert r["energy.kinetic"].max() < 1e4
