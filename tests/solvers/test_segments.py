"""Corners and segments: what falls on a segment is caught, what comes from its side or from below passes it."""

import math

import numpy as np
import pytest

import rattle as rt
from surfaces import body, surface, world

G = 9.81

TABLE = """
format = 1
gravity = [0, {gravity}]
ground.points = {{ T = [0, 0] }}
bodies.bar = {{ points = {{ P = [{half}, 0], C = [0, 0] }}, center = [0, 0], mass = 1, inertia = 0.02 }}
initial.bar = {{ x = {x}, y = {y}, angle = {angle}, vx = {vx}, vy = {vy}, omega = {omega} }}
[joints.table]
type = "surface"
connect = ["ground.T", "bar.P"]
axis = {axis}
length = {length}
contact = {contact}
"""
RIGID = '{ model = "impact", restitution = 0.5 }'
SOFT = '{ model = "kelvin-voigt", stiffness = 1e5, restitution = 0.5 }'


def table(contact=RIGID, **values):
    numbers = {"gravity": -G, "half": 0.2, "x": 0, "y": 0, "angle": 0, "vx": 0, "vy": 0, "omega": 0}
    return rt.loads(TABLE.format(**(numbers | {"axis": 0, "length": 1.0} | values), contact=contact))


@pytest.mark.parametrize("contact", [RIGID, SOFT])
def test_a_corner_that_comes_under_a_segment_from_its_side_flies_on(contact):
    """It flies under the table, up through it, and falls on it afterwards: a parabola until then."""
    r = table(contact, half=0.0, x=-1.0, y=-0.6, vx=1.0, vy=4.5).simulate(2.0, t_eval=np.linspace(0, 2, 201), rtol=1e-9)
    assert r.success, r.message
    hit = (4.5 + math.sqrt(4.5**2 - 2 * G * 0.6)) / G
    events = [event.t for event in r.events if event.kind in ("impact", "contact")]
    assert events[0] == pytest.approx(hit, abs=1e-8)
    before = r.t < hit
    assert r["bar.y"][before] == pytest.approx(-0.6 + 4.5 * r.t[before] - 0.5 * G * r.t[before] ** 2, abs=1e-8)
    assert -1.0 + hit > -0.5  # it comes from the side and is under the table as it turns up


@pytest.mark.parametrize("depth", [1e-6, 1e-3, 0.3])
def test_a_corner_that_passes_below_a_segment_touches_nothing(depth):
    r = table(half=0.0, gravity=0, x=-0.7, y=-depth, vx=2.0).simulate(1.0)
    assert r.success, r.message
    assert not r.events
    assert r["bar.x"][-1] == pytest.approx(1.3, abs=1e-9)


def rise(r, axis, half=0.2):
    """Height of the end of the bar over the line of the table, and its place along it [m]."""
    x, y = r["bar.x"] + half * np.cos(r["bar.angle"]), r["bar.y"] + half * np.sin(r["bar.angle"])
    return math.cos(axis) * y - math.sin(axis) * x, math.cos(axis) * x + math.sin(axis) * y


@pytest.mark.parametrize("case", range(25))
def test_a_turning_bar_never_falls_through_a_segment(case):
    """Seen by its heights at 4001 times: whoever is over the table and comes below it has come from its side."""
    rng = np.random.default_rng(case)
    axis = rng.uniform(-0.6, 0.6)
    start = {"x": rng.uniform(-0.3, 0.3), "y": rng.uniform(0.3, 0.6), "angle": rng.uniform(-3, 3)}
    rates = {"vx": rng.uniform(-1, 1), "vy": rng.uniform(-3, 0), "omega": rng.uniform(-30, 30)}
    if hits := case < 15:  # no tip is ever beside the table
        start["x"], rates["vx"] = 0.2 * start["x"], 0.05 * rates["vx"]
    r = table(axis=axis, length=0.6, **start, **rates).simulate(0.6, t_eval=np.linspace(0, 0.6, 4001), rtol=1e-9)
    assert r.success, r.message
    high, along = rise(r, axis)
    through = (high[:-1] > 1e-9) & (high[1:] < -1e-9) & (np.abs(along[:-1]) < 0.29) & (np.abs(along[1:]) < 0.29)
    assert not through.any()
    assert r.events or not hits


SQUARE = """
format = 1
gravity = [0, {gravity}]
ground.points = {{ T = [-0.5, 0] }}
bodies.box = {{ polygon = [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]], points = {{ C = [0, 0] }}, mass = 1 }}
initial.box = {{ x = {x}, y = {y}, angle = {angle}, vx = {vx}, vy = {vy}, omega = {omega} }}

[joints.table]
type = "surface"
connect = ["ground.T", "box.C"]
axis = 0
length = 1.0
outline = true
contact = {{ model = "impact", restitution = {restitution} }}
"""


def box(restitution=0.5, **values):
    numbers = {"gravity": -G, "x": 0, "y": 0, "angle": 0, "vx": 0, "vy": 0, "omega": 0}
    return rt.loads(SQUARE.format(**(numbers | values), restitution=restitution))


@pytest.mark.parametrize("case", range(12))
def test_a_box_that_slides_and_tips_over_an_end_loses_no_energy_but_by_impacts(case):
    """Without friction; edge and corner pass the end in contact, where the direction of the contact jumps."""
    rng = np.random.default_rng(case)
    start = {"x": rng.uniform(-0.3, -0.2), "y": 0.1 * math.sqrt(2) + 0.02, "angle": rng.uniform(-1, 1)}
    r = box(0.0, **start, vx=rng.uniform(0.3, 0.8), omega=rng.uniform(-3, 3)).simulate(1.5, rtol=1e-9)
    assert r.success, r.message
    energy = r["energy.kinetic"] + r["energy.potential"]
    assert np.diff(energy).max() < 1e-9
    assert np.abs(r["energy.balance"]).max() < 1e-8
    assert {"impact", "contact", "release"} <= {event.kind for event in r.events}
    assert r["box.y"][-1] < 0.1  # it has tipped over the end


def passage(rng):
    """Length, speed and slope of a straight way down past the right end of a segment; how far beyond it, in lengths."""
    return 10 ** rng.uniform(-2, 0.5), 10 ** rng.uniform(-1, 3), rng.uniform(0.2, 1.3), 10 ** rng.uniform(-7, -2)


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("case", range(30))
def test_no_corner_that_nicks_an_end_is_missed_and_none_that_passes_it_is_caught(case, side):
    length, speed, slope, beside = passage(np.random.default_rng(case))
    vx, vy, before = speed * math.cos(slope), -speed * math.sin(slope), 0.37
    start = {"x": length * (0.5 + side * beside) - vx * before, "y": -vy * before}
    r = table(half=0.0, gravity=0, length=length, vx=vx, vy=vy, **start).simulate(0.8)
    assert r.success, r.message
    hits = [event for event in r.events if event.kind == "impact"]
    assert len(hits) == (1 if side < 0 else 0)
    assert all(event.t == pytest.approx(before, rel=1e-9) for event in hits)


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("case", range(20))
def test_no_end_that_nicks_a_corner_of_a_plate_is_missed(case, side):
    """The lowest corner of a square on its corner flies level past the left end of a table, or just through it."""
    rng = np.random.default_rng(case)
    speed, beside = 10 ** rng.uniform(-1, 3), 10 ** rng.uniform(-7, -3)
    low, before = 0.1 * math.sqrt(2), 0.37
    start = {"x": -1.0 - speed * before, "y": low + side * beside, "angle": math.pi / 4}
    r = box(gravity=0, vx=speed, **start).simulate(before + 0.5 / speed)
    assert r.success, r.message
    hits = [event for event in r.events if event.kind == "impact"]
    assert bool(hits) == (side < 0)
    assert all(abs(event.t - before) * speed < 2 * beside + 1e-9 for event in hits[:1])


@pytest.mark.parametrize("contact", [RIGID, SOFT])
def test_steps_of_fixed_length_let_a_corner_up_through_a_segment_wherever_they_end(contact):
    """In which half of a step it crosses the segment does not matter."""
    for y in np.linspace(-0.11, -0.1, 21):
        r = table(contact, half=0.0, gravity=0, y=y, vy=1.0).simulate(0.2, method="moreau", step=1e-3)
        assert not r.events
        assert r["bar.vy"][-1] == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("contact", [RIGID, SOFT])
def test_corners_above_each_other_come_under_a_segment_at_one_instant_and_slide_on(contact):
    """A box falls flat beside a table and slides under it, with its upper corners in one line with its lower ones."""
    m = world(
        body(
            "box",
            {"A": (-0.2, -0.1), "B": (0.2, -0.1), "C": (0.2, 0.1), "D": (-0.2, 0.1)},
            2,
            0.03,
            (-1.5, 0.7, 0, 1, 0, 0),
        ),
        surface("floor", "ground.O", "box.A", '{ model = "impact" }', more=', corners = ["A", "B"]'),
        surface("table", "ground.T", "box.C", contact, more=', length = 1, corners = ["A", "B", "C", "D"]'),
        points="O = [0, 0], T = [0, 0.5]",
    )
    r = m.simulate(2.0)
    assert r.success, r.message
    assert (r["box.x"][-1], r["box.y"][-1], r["box.angle"][-1]) == pytest.approx((0.5, 0.1, 0.0), abs=1e-9)
    assert {event.joint for event in r.events} == {"floor"}


@pytest.mark.parametrize("contact", [RIGID, SOFT])
def test_a_box_that_flies_under_a_segment_with_two_corners_at_once_flies_on(contact):
    """Where nothing else is in contact."""
    corners = {"A": (-0.2, -0.1), "B": (0.2, -0.1), "C": (0.2, 0.1), "D": (-0.2, 0.1)}
    table = surface("table", "ground.O", "box.C", contact, more=', length = 1, corners = ["A", "B", "C", "D"]')
    box = body("box", corners, 2, 0.03, (-1.5, -0.4, 0, 1, 0, 0))
    r = world(box, table, gravity=0.0).simulate(2.0)
    assert r.success, r.message
    assert (r["box.x"][-1], r["box.y"][-1], r["box.angle"][-1]) == pytest.approx((0.5, -0.4, 0.0), abs=1e-9)
    assert not r.events


@pytest.mark.parametrize("seed", range(8))
def test_a_block_that_moves_into_a_segment_it_touches_goes_on_as_on_a_line(seed):
    """One corner hits at the start, the other is not forgotten."""
    rng = np.random.default_rng(seed)
    vy, omega, e, mu = -rng.uniform(0.1, 1.0), rng.uniform(-3.0, 3.0), rng.uniform(0.0, 0.8), rng.choice([0.0, 0.3])
    ends = []
    for length in ("length = 2", ""):
        r = rt.loads(f"""
format = 1
gravity = [0, -9.81]
ground.points = {{ F = [0, 0] }}
bodies.b = {{ points = {{ C = [0, -0.05], P = [-0.1, -0.05], Q = [0.1, -0.05] }}, mass = 1, inertia = 0.005 }}
initial.b = {{ x = 0, y = 0.05, angle = 0, vx = 0, vy = {vy}, omega = {omega} }}
[joints.floor]
type = "surface"
connect = ["ground.F", "b.C"]
axis = 0
{length}
corners = ["P", "Q"]
contact = {{ model = "impact", restitution = {e}, friction = {mu} }}
""").simulate(0.2, t_eval=[0.0, 0.2], rtol=1e-10)
        assert r.success, r.message
        assert r.trust.energy_balance < 1e-9
        ends.append([r[f"b.{key}"][-1] for key in ("x", "y", "angle", "vy")])
    assert ends[0] == pytest.approx(ends[1], abs=1e-7)
