"""Slot with open ends: a pin goes in and out freely, strikes the corners of the mouth, and rolls off a wall."""

import math

import numpy as np
import pytest

import rattle as rt

nojit = pytest.mark.nojit
WIDTH, PLAY, LENGTH = 0.05, 0.01, 0.4  # half the width of the slot, clearance, length [m]
RADIUS = WIDTH - PLAY  # of the pin
RIGID = f"{{ model = 'impact', restitution = 0.5, bush_radius = {WIDTH} }}"
SOFT = f"{{ model = 'exact', restitution = 0.5, stiffness = 1e12, bush_radius = {WIDTH} }}"
STEPPED = {"method": "moreau", "step": 1e-5}
WAYS = [(RIGID, {}), (SOFT, {}), (RIGID, STEPPED)]


def pin(start, ends="true", contact=RIGID, gravity=0.0, extra="", play=f"clearance = {PLAY}", length=f"{LENGTH}"):
    """A pin of 2 kg and a slot of the ground along x about the origin; its mouth is at x = 0.2 m."""
    return rt.loads(f"""
format = 1
gravity = [0, {-gravity}]
[ground.points]
O = [0, 0]
[bodies.pin]
points = {{ P = [0, 0] }}
mass = 2
inertia = 1e-3
[joints.slot]
type = "slot"
connect = ["ground.O", "pin.P"]
{"length = " + length if length else ""}
{"open = " + ends if ends else ""}
{play}
{"contact = " + contact if contact else ""}
{extra}
[initial]
pin = {{ {start} }}
""")


@pytest.mark.parametrize(("contact", "how"), WAYS)
@pytest.mark.parametrize(("ends", "v"), [("true", 1.0), ("'end'", 1.0), ("'start'", -1.0), ("'both'", -1.0)])
def test_a_pin_leaves_an_open_end_without_touching_anything(contact, how, ends, v):
    r = pin(f"x = 0, y = 0.004, vx = {v}", ends, contact).simulate(1.0, **how)
    assert r.success
    assert not r.events
    assert r["pin.x"] == pytest.approx(v * r.t, abs=1e-10)  # sums of a hundred thousand steps


@pytest.mark.parametrize(("contact", "how"), WAYS)
def test_a_pin_comes_in_at_an_open_end_and_is_stopped_by_the_closed_one(contact, how):
    """From x = 0.5 to the other end at -0.2 - c, where it is thrown back with half its speed, and out again."""
    r = pin("x = 0.5, y = 0, vx = -2", "true", contact).simulate(1.2, **how)
    back = (0.7 + PLAY) / 2
    struck = [one.t for one in r.events if one.kind in ("impact", "contact")]
    assert struck == pytest.approx([back], abs=2e-5 if how else 1e-5)
    assert r["pin.x"][-1] == pytest.approx(-0.2 - PLAY + 1.0 * (1.2 - back), abs=1e-3)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("contact", "how"), WAYS)
def test_a_pin_that_misses_the_mouth_strikes_its_corner(contact, how, side):
    """A smooth disc of radius r against a point: reflected with e along the line from the corner to its centre."""
    y, v, e = 0.03, 2.0, 0.5
    r = pin(f"x = 0.5, y = {side * y}, vx = {-v}", "true", contact).simulate(0.16, **how)
    across = WIDTH - y
    along = math.sqrt(RADIUS**2 - across**2)
    n = np.array([along, -side * across]) / RADIUS
    after = np.array([-v, 0.0]) + (1 + e) * v * n[0] * n
    assert r.events[0].t == pytest.approx((0.3 - along) / v, abs=1e-5)
    assert (r["pin.vx"][-1], r["pin.vy"][-1]) == pytest.approx(tuple(after), abs=1e-2)  # an elastic wall gives way


@pytest.mark.parametrize("v", [0.1, 0.3, 0.8])
def test_a_pin_that_slides_out_rolls_off_the_corner_of_the_mouth(v):
    """Round the corner it is a pendulum that leaves at cos = 2/3 + v^2/(3 g r); if v^2 > g r it flies off at once."""
    g = 10.0
    r = pin(f"x = 0, y = {-PLAY}, vx = {v}", "true", RIGID, g).simulate(2.5 if v < 0.2 else 1.0, rtol=1e-10)
    (leaves,) = [one.t for one in r.events if one.kind == "release"]
    cos = min(2.0 / 3.0 + v * v / (3.0 * g * RADIUS), 1.0)
    k = int(np.searchsorted(r.t, leaves))
    assert k < len(r.t)
    x, y, fall = r["pin.x"][k], r["pin.y"][k], r.t[k] - leaves
    speed = math.sqrt(v * v + 2.0 * g * RADIUS * (1.0 - cos)) if cos < 1.0 else v
    sin = math.sqrt(1.0 - cos * cos)
    at = (0.2 + RADIUS * sin + speed * cos * fall, -WIDTH + RADIUS * cos - speed * sin * fall - 0.5 * g * fall**2)
    assert (x, y) == pytest.approx(at, abs=1e-7)
    energy = r["energy.kinetic"] + r["energy.potential"]
    assert np.ptp(energy) < 1e-7


def test_a_pin_beside_the_slot_does_not_touch_the_wall_from_inside():
    """The slot is a thin wall: outside of it a pin falls onto it from above and stays outside."""
    r = pin("x = 0, y = 0.2", "true", RIGID, 10.0).simulate(3.0)
    assert r.success
    assert r["pin.y"][-1] == pytest.approx(WIDTH + RADIUS, abs=1e-9)


def test_the_pin_of_a_slot_without_width_has_an_assumed_radius_that_is_said():
    m = pin("x = 0, y = 0, vx = 1", "true", "'impact'")
    assert m.model.joints["slot"].contact.bush_radius == pytest.approx(0.1 * LENGTH)
    r = m.simulate(1.0)
    assert any("bush_radius is not given" in note for note in r.trust.notes)
    assert r["pin.x"][-1] == pytest.approx(1.0, abs=1e-12)


@nojit
@pytest.mark.parametrize(
    ("words", "given"),
    [
        ("an open end needs the length", {"length": ""}),
        ("a slot with an open end needs clearance and a contact that acts, such as", {"play": "", "contact": ""}),
        ("a slot with an open end needs clearance and a contact", {"play": "clearance = 0"}),
        ("a slot with an open end needs clearance and a contact", {"contact": "'ideal'"}),
        ("expected one of none, start, end, both, got 'far'", {"ends": "'far'"}),
    ],
)
def test_an_open_end_that_cannot_be_is_refused_with_what_it_needs(words, given):
    with pytest.raises(rt.ModelError, match=words):
        _ = pin("x = 0, y = 0", **given).model


@nojit
def test_a_mechanism_with_a_mouth_has_no_ideal_one():
    with pytest.raises(rt.ModelError, match="a slot with an open end needs clearance and a contact that acts"):
        pin("x = 0, y = 0").ideal()


@nojit
def test_what_no_run_in_time_can_answer_is_refused_for_a_mechanism_with_a_mouth():
    m = pin("x = 0, y = 0", extra='[drivers.d]\nbody = "pin"\ncoordinate = "x"\nposition = "t"\n')
    with pytest.raises(rt.ModelError, match=r"which an equilibrium does not follow \('slot'\): use simulate"):
        m.equilibrium()
    with pytest.raises(rt.ModelError, match=r"What holds only where bodies touch .slot. is followed by a run in time"):
        m.kinematics([0.0, 0.1])


@nojit
def test_a_start_inside_the_material_of_the_slot_is_refused():
    with pytest.raises(rt.AssemblyError, match="joint 'slot' starts"):
        pin("x = 0, y = 0.03").simulate(0.1)


@nojit
def test_false_closes_an_end():
    assert pin("x = 0, y = 0", "false").model.joints["slot"].fields["open"] == 0.0
