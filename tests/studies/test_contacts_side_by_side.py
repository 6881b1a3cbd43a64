"""Contacts side by side: closed forms, single runs of the same samples, the same bits in any company."""

import math
import re

import numpy as np
import pytest

import rattle as rt
from balls import RIGID as RIGID_STOP
from balls import G, ball
from blocks import against_a_wall, block, undamped
from lane_runs import FINE, alone, assert_alike, side_by_side
from rattle.analyses.straight_line.starts import Starts

PRESSED = 'stiffness = 2e9, exponent = 1.5, restitution = "e", bush_radius = 0.01'
RUBS = 'friction = { model = "ambrosio", mu = "mu", v0 = 0.01, v1 = 0.1 }'
RUBS_SMOOTHLY = 'friction = { model = "threlfall", mu = "mu", vr = 0.1 }'
RIGID = '{ model = "impact", restitution = "e", friction = "mu", bush_radius = 0.01 }'


def slider_crank(contact, more=""):
    return f"""
format = 1
parameters = {{ c = 5e-4, e = 0.5, mu = 0.1, omega = 523.6, l = 0.12 }}
ground.points.O = [0, 0]
[bodies.crank]
points = {{ O = [0, 0], A = [0.05, 0] }}
mass = 0.3
inertia = 1e-4
[bodies.rod]
bar = ["A", "B"]
length = "l"
mass = 0.21
inertia = 2.5e-4
[bodies.slider]
points = {{ B = [0, 0] }}
mass = 0.14
inertia = 1e-4
[joints]
O = {{ type = "revolute", connect = ["ground.O", "crank.O"] }}
A = {{ type = "revolute", connect = ["crank.A", "rod.A"] }}
B = {{ type = "revolute", connect = ["slider.B", "rod.B"], clearance = "c", contact = {contact} }}
guide = {{ type = "prismatic", connect = ["ground.O", "slider.B"], axis = 0 }}
[drivers.motor]
joint = "O"
angle = "omega*t"
{more}
[initial]
rod = {{ angle = 0 }}
slider = {{ x = "0.05 + l" }}
B = {{ offset = [0, 0] }}
"""


def test_a_ball_bounces_to_rest_with_all_its_bounces():
    """t_k = t_1 (1 + 2 sum e^j); rest at t_1 (1 + e)/(1 - e), all energy is lost."""
    e, h = np.array([0.8, 0.6, 0.3, 0.0]), np.array([1.0, 0.5, 2.0, 1.0])
    outputs = [
        "time(rail.contacts, 3)",
        "speed(rail.contacts, 3)",
        "final(ball.y)",
        "final(energy.dissipated)",
        "final(rail.stop)",
        "count(rail.contacts)",
    ]
    found, (t, v, y, lost, force, count) = side_by_side(rt.loads(ball()), {"e": e, "h": h}, outputs, 9.0, **FINE)
    first = np.sqrt(2 * h / G)
    bounces = e > 0
    assert t[bounces] == pytest.approx((first * (1 + 2 * e + 2 * e**2))[bounces], abs=1e-11)
    assert v[bounces] == pytest.approx((G * first * e**2)[bounces], rel=1e-10)
    assert math.isnan(t[3])
    assert y == pytest.approx(0, abs=1e-12)
    assert lost == pytest.approx(G * h, rel=1e-10)
    assert force == pytest.approx(G, rel=1e-12)
    assert count[3] == 1
    assert count[0] > 50
    assert found.stats["turns"] == count.sum()
    assert found.stats["tries"] > found.stats["landings"] > 0


def test_a_ball_on_a_linear_stop_has_its_period_and_largest_force():
    k = np.array([1e4, 1e5, 1e6])
    m = rt.loads(ball('{ model = "hertz", stiffness = "k", exponent = 1 }'))
    outputs = [
        "time(rail.contacts, 3)",
        "peak(rail.contacts, 2)",
        "max(rail.stop)",
        "share(ball.y < 0)",
        "integral(rail.stop)",
    ]
    _, (t, peak, most, share, impulse) = side_by_side(m, {"k": k}, outputs, 2.5, **FINE)
    v, w = math.sqrt(2 * G), np.sqrt(k)
    lasts = 2 / w * (math.pi - np.arctan(v * w / G))
    assert t == pytest.approx(v / G + 2 * (lasts + 2 * v / G), abs=1e-10)
    want = G + np.sqrt(G * G + k * v * v)
    assert peak == pytest.approx(want, rel=1e-7)
    assert most == pytest.approx(want, rel=1e-6)
    whole = np.floor((2.5 - v / G) / (lasts + 2 * v / G)) + 1  # contacts that have ended
    assert share == pytest.approx(whole * lasts / 2.5, rel=1e-8)
    assert impulse == pytest.approx(whole * (2 * v + G * lasts), rel=1e-7)


def test_a_block_slides_to_rest_and_sticks():
    mu, v = np.array([0.3, 0.1, 0.5]), np.array([1.0, 0.5, 2.0])
    outputs = [
        "final(block.x)",
        "final(block.vx)",
        "final(energy.dissipated)",
        "at(block.x, 0.1)",
        "final(floor.normal)",
    ]
    _, (x, rest, lost, early, force) = side_by_side(rt.loads(block()), {"mu": mu, "v": v}, outputs, 1.0, **FINE)
    assert x == pytest.approx(v**2 / (2 * mu * G), rel=1e-9)
    assert rest == pytest.approx(0, abs=1e-12)
    assert lost == pytest.approx(v**2, rel=1e-9)  # of 2 kg
    assert early == pytest.approx(0.1 * v - 0.005 * mu * G, rel=1e-9)
    assert force == pytest.approx(2 * G, rel=1e-9)


def test_a_block_slides_into_a_rough_wall_and_stays():
    mu, v = np.array([0.3, 0.1, 0.5]), np.array([2.0, 1.0, 3.0])
    outputs = ["final(block.x)", "final(block.angle)", "final(energy.dissipated)", "time(wall.contacts, 1)"]
    _, (x, angle, lost, hits) = side_by_side(rt.loads(against_a_wall()), {"mu": mu, "v": v}, outputs, 1.0, **FINE)
    assert x == pytest.approx(0.3, rel=1e-11)
    assert angle == pytest.approx(0, abs=1e-11)
    assert lost == pytest.approx(v**2, rel=1e-9)
    assert hits == pytest.approx((v - np.sqrt(v**2 - 0.6 * mu * G)) / (mu * G), rel=1e-10)


def test_three_contacts_with_friction_after_poisson_run_alone():
    found = rt.loads(against_a_wall("poisson")).many({"v": [2.0]}, t_end=0.3, outputs=["final(block.x)"])
    assert "three contacts at once" in found.stats["how"]
    assert found["final(block.x)"] == pytest.approx(0.3, rel=1e-9)


def test_pin_and_guide_that_both_rub():
    play = 'guide = { type = "prismatic", connect = ["ground.O", "slider.B"], axis = 0, clearance = 4e-4,'
    play += " block = { length = 0.04, height = 0.03 },"
    play += ' contact = { model = "impact", restitution = 0.3, friction = "mu" } }'
    text = slider_crank(RIGID, "[initial]\nrod = { angle = 0 }").split("[initial]")[0]
    text = re.sub("guide = .*", play, text).replace("523.6", "62.8")
    outputs = ["final(slider.x)", "time(B.contacts, 4)", "time(guide.contacts, 4)"]
    assert_alike(rt.loads(text), {"mu": np.array([0.05, 0.15, 0.4])}, outputs, 0.03, rel=1e-8, **FINE)


def test_a_block_that_is_pushed_begins_to_slide_at_its_limit():
    """F = 10 t N against mu m g: it slides from t_0 = mu m g/10 on."""
    push = '[loads.push]\ntype = "force"\nat = "block.C"\nforce = ["10*t + F", 0]\n'
    mu = np.array([0.2, 0.3, 0.4])
    m = rt.loads(block(more=push, vx=0))
    outputs = ["final(block.vx)", "first(block.vx > 1e-9)"]
    _, (v, begins) = side_by_side(m, {"mu": mu}, outputs, 1.0, **FINE)
    start = mu * 2 * G / 10
    assert v == pytest.approx(5 / 2 * (1 - start) ** 2, rel=1e-8)
    assert begins == pytest.approx(start, abs=1e-4)


def test_a_rotor_between_stops_and_contacts_that_do_not_come():
    text = """
format = 1
parameters = { e = 0.5, w = 2.0 }
ground.points.O = [0, 0]
bodies.rotor = { points = { C = [0, 0] }, mass = 1, inertia = 0.02 }
initial.rotor = { angle = 0.4, omega = "w" }
[joints.pivot]
type = "revolute"
connect = ["ground.O", "rotor.C"]
stop = { min = "0 rad", max = "1 rad", contact = { model = "impact", restitution = "e" } }
"""
    e, w = np.array([0.5, 0.8, 1.0, 0.5]), np.array([2.0, -3.0, 5.0, 0.1])
    outputs = [f"{what}(pivot.contacts, {k})" for what in ("time", "speed") for k in (1, 2, 3)]
    found, values = side_by_side(rt.loads(text), {"e": e, "w": w}, outputs, 2.5, **FINE)
    first = np.where(w > 0, 0.6, 0.4) / np.abs(w)
    want = np.array([first, first + 1 / (np.abs(w) * e), first + 1 / (np.abs(w) * e) + 1 / (np.abs(w) * e**2)])
    assert values[:3] == pytest.approx(np.where(want < 2.5, want, np.nan), abs=1e-10, nan_ok=True)
    assert not found.messages
    assert np.isnan(values[:, 3]).all()


# ---------------------------------------------------------------- as runs alone
LAWS = {
    "lankarani": (f'{{ model = "lankarani-nikravesh", {PRESSED} }}', 1.3e-3),
    "kelvin-voigt": (f'{{ model = "kelvin-voigt", {PRESSED} }}', 1e-3),
    "rubs": (f'{{ model = "hunt-crossley", {PRESSED}, {RUBS} }}', 1.2e-3),
    "rubs by an exponential": (f'{{ model = "hunt-crossley", {PRESSED}, {RUBS_SMOOTHLY} }}', 1.2e-3),
    "ends by its force": (
        '{ model = "hertz", stiffness = 2e7, exponent = 1, damping = 60, bush_radius = 0.01 }',
        1.3e-3,
    ),
    "rigid": ('{ model = "impact", restitution = "e", bush_radius = 0.01 }', 1.2e-3),
    "rigid, rubs": (RIGID, 1.2e-3),
}


@pytest.mark.parametrize("law", LAWS)
def test_samples_are_what_they_are_alone(law):
    contact, t_end = LAWS[law]
    rigid = "impact" in contact
    outputs = [
        "time(B.contacts, 1)", "time(B.contacts, 2)", "speed(B.contacts, 2)", "count(B.contacts)", "final(slider.x)",
        "at(rod.angle, 0.0007)", "final(energy.dissipated)", *([] if rigid else ["peak(B.contacts, 1)"]),
    ]  # fmt: skip
    samples = {"c": np.array([4.7e-4, 5e-4, 5.3e-4]), "l": np.array([0.12, 0.121, 0.119])}
    if '"e"' in contact and law != "kelvin-voigt":  # whose law does not follow from it in operations that are recorded
        samples["e"] = np.array([0.5, 0.4, 0.6])
    assert_alike(rt.loads(slider_crank(contact)), samples, outputs, t_end, rel=3e-6, abs=1e-9)


LOST = "final(energy.dissipated)"


@pytest.mark.parametrize(
    ("example", "name", "t_end", "outputs"),
    [
        ("fourbar_onesided", "M", 0.3, ["count(O3.contacts)", "max(O3.normal)", "final(rocker.angle)", LOST]),
        ("guide_play", "mu", 0.05, ["count(guide.contacts)", "time(guide.contacts, 5)", "final(crank.angle)", LOST]),
        ("scotch_yoke", "omega", 0.1, ["count(slot.contacts)", "time(slot.contacts, 2)", "max(slot.normal)", LOST]),
        ("rimless_wheel", "a", 0.5, ["count(road.contacts)", "final(wheel.angle)", "max(road.normal)", LOST]),
        ("drawer", "width", 0.2, ["count(guide.contacts)", "final(drawer.x)", "max(guide.normal)"]),
        ("gear_rattle", "alpha", 0.02, ["count(mesh.contacts)", "time(mesh.contacts, 2)", "final(idle.angle)"]),
    ],
)
def test_examples_are_what_they_are_alone(example, name, t_end, outputs):
    m = rt.load(rt.examples()[example])
    value = m.parameters[name]
    assert_alike(m, {name: value * np.array([0.995, 1.0])}, outputs, t_end, rel=2e-6, abs=1e-9, rtol=1e-10)


def test_a_pin_with_friction_slides_sticks_and_comes_back():
    """Slips that begin and end within one step are among these."""
    m = rt.loads(slider_crank(RIGID))
    samples = {"c": 5e-4 * np.array([0.935, 1.083, 1.087, 1.1])}
    assert_alike(m, samples, ["count(B.contacts)", "final(slider.x)", LOST], 0.021, rel=1e-5, abs=1e-9, rtol=1e-10)


def test_a_slip_that_begins_and_ends_at_zero_in_one_step_ends_there():
    contact = '{ model = "impact", restitution = 0.9, friction = "mu", bush_radius = "10 mm" }'
    text = (
        rt.examples()["slider_crank_play"].read_text(encoding="utf-8").replace("[parameters]", "[parameters]\nmu = 0.1")
    )
    begin, end = text.index("[joints.B.contact]"), text.index("[joints.guide]")
    m = rt.loads(text[:begin].replace('clearance = "c"', f'clearance = "c"\ncontact = {contact}') + text[end:])
    samples = {"c": 0.5e-3 * np.linspace(0.95, 1.05, 1024)[[338, 724]]}
    assert_alike(m, samples, ["final(slider.x)", LOST], 0.0085, rel=1e-5, rtol=1e-8)


ROW = """
format = 1
parameters = { e = 1.0, gap = 0.0 }
ground.points.O = [0, 0]
bodies.a = { points = { C = [0, 0] }, mass = 1, inertia = 1 }
bodies.b = { points = { C = [0, 0] }, mass = 1, inertia = 1 }
bodies.c = { points = { C = [0, 0] }, mass = 1, inertia = 1 }
joints.ra = { type = "prismatic", connect = ["ground.O", "a.C"], axis = 0, angle = 0 }
joints.rb = { type = "prismatic", connect = ["ground.O", "b.C"], axis = 0, angle = 0 }
joints.rc = { type = "prismatic", connect = ["ground.O", "c.C"], axis = 0, angle = 0 }
joints.ab = { type = "surface", connect = ["b.C", "a.C"], axis = "90 deg", contact = { model = "impact", restitution = "e" } }
joints.bc = { type = "surface", connect = ["c.C", "b.C"], axis = "90 deg", contact = { model = "impact", restitution = "e" } }
initial.a = { x = -0.3, vx = 1 }
initial.b = { x = 0, vx = 0 }
initial.c = { x = "gap", vx = 0 }
"""  # noqa: E501


def test_what_touches_without_a_force_takes_part_in_impacts():
    """Newton's law for all that touch: b+ - a+ = e, c+ = b+, and their momentum."""
    e = np.array([1.0, 0.5, 0.0])
    outputs = ["final(a.vx)", "final(b.vx)", "final(c.vx)", "count(ab.contacts)"]
    _, (a, b, c, count) = side_by_side(rt.loads(ROW), {"e": e}, outputs, 0.5, **FINE)
    assert b - a == pytest.approx(e, abs=1e-12)
    assert c == pytest.approx(b, abs=1e-12)
    assert a + b + c == pytest.approx(1.0, abs=1e-12)
    assert list(count) == [1, 1, 1]


def test_a_stack_comes_to_rest():
    second = """
[bodies.top]
points = { C = [0, 0] }
mass = 2
inertia = 1
[joints.guide]
type = "prismatic"
connect = ["ground.O", "top.C"]
axis = "90 deg"
angle = 0
[joints.pair]
type = "surface"
connect = ["ball.C", "top.C"]
axis = 0
contact = { model = "impact", restitution = "e" }
[initial]
top = { y = "2.5*h", vy = 0 }
ball = { y = "h", vy = 0 }
"""
    text = ball(h=0.1).replace('initial.ball = { y = "h", vy = 0 }\n', "") + second
    e = np.array([0.0, 0.3, 0.5])
    outputs = ["final(ball.y)", "final(top.y)", LOST, "final(rail.stop)", "final(pair.normal)"]
    _, (y, top, lost, below, between) = side_by_side(rt.loads(text), {"e": e}, outputs, 1.0, **FINE)
    assert np.abs([y, top]).max() < 1e-12
    assert lost == pytest.approx(G * (0.1 + 2 * 0.25), rel=1e-9)
    assert below == pytest.approx(3 * G, rel=1e-9)
    assert between == pytest.approx(2 * G, rel=1e-9)


def test_two_feet_that_stand_still_at_once_share_what_one_would_bear():
    """A ladder slides till its cord is tight, and stops: how its feet share the friction is not determined, and one of
    them bears all that it can without slipping."""
    m = rt.example("step_ladder")
    lengths = m.parameters["l"] * (1.0 + 0.01 * np.linspace(-1.0, 1.0, 12))
    samples = {"l": lengths[[0, 1, 2, 3, 8]]}
    assert_alike(m, samples, ["final(right.angle)", "final(left.x)", "max(cord.force)"], 0.3, rel=1e-7)


def test_a_block_comes_to_rest_in_a_corner():
    """It slides to a wall, tips in the corner about a point that floor and wall hold, and rests at both."""
    m = rt.loads("""
format = 1
gravity = [0, -9.81]
parameters = { mu = 0.2, T = 1.0 }
ground.points = { O = [0, 0], W = [0.8, 0] }
[bodies.b]
points = { L = [-0.2, -0.1], R = [0.2, -0.1], C = [0.028, 0.0148] }
mass = 2
inertia = 0.03
[joints.left]
type = "surface"
connect = ["ground.O", "b.L"]
axis = 0
contact = { model = "impact", restitution = 0.3, friction = "mu" }
[joints.right]
type = "surface"
connect = ["ground.O", "b.R"]
axis = 0
contact = { model = "impact", restitution = 0, friction = "mu" }
[joints.wall]
type = "surface"
connect = ["ground.W", "b.R"]
axis = "90 deg"
contact = { model = "impact", restitution = 0, friction = "mu" }
[loads.push]
type = "force"
at = "b.C"
force = ["3*T*sin(3*t + 2)", 0]
[initial.b]
x = 0
y = 0.13
angle = 0
vx = 2
""")
    samples = {"mu": np.array([0.548, 0.468, 0.0597, 0.089]), "T": np.array([1.18, 1.69, 1.86, 1.69])}
    assert_alike(m, samples, ["final(b.x)", "max(b.angle)", "final(b.vx)", LOST], 0.8, rel=1e-7, abs=1e-9, rtol=1e-10)


def test_a_flank_that_has_just_let_go_does_not_knock_by_rounding():
    """Its gap opens with the third power of time."""
    m = rt.example("gear_rattle").set(drag=0.1593)
    outputs = ["count(mesh.contacts)", "time(mesh.contacts, 2)", "speed(mesh.contacts, 2)"]
    assert_alike(m, {"e": [0.0], "A": [2.8667e-4]}, outputs, 0.15, rel=1e-5, rtol=1e-9)


def with_law(text, law):
    return rt.loads(re.sub("(restitution = [^,} ]+)", rf'\1, restitution_law = "{law}"', text))


ROD = """
format = 1
gravity = [0, -9.81]
parameters = { mu = 0.5, e = 0.6, u = 0.0, w = 0.0, tilt = 0.5 }
ground.points.O = [0, 0]
bodies.rod = { points = { C = [0, 0], P = [0, -0.5] }, mass = 1, inertia = 0.08 }
[joints.floor]
type = "surface"
connect = ["ground.O", "rod.C"]
axis = 0
corners = ["P"]
contact = { model = "impact", restitution = "e", friction = "mu" }
[initial]
rod = { x = 0, y = 0.5, angle = "tilt", vx = "u", vy = -1, omega = "w" }
"""


@pytest.mark.parametrize("law", ["newton", "poisson", "energetic"])
def test_a_rod_is_struck_as_it_is_alone(law):
    """It slides on, sticks, or slides back, in compression or after it."""
    sets = np.array([(u, w, tilt, mu) for u in (-1, 0.0, 0.4, 3.0) for w in (-5.0, 1.0) for tilt in (-0.7, 0.1, 0.6)
                     for mu in (0.05, 0.2, 0.5)])  # fmt: skip
    samples = dict(zip(("u", "w", "tilt", "mu"), sets.T, strict=True))
    outputs = ["final(rod.vx)", "final(rod.vy)", "final(rod.omega)", "count(floor.contacts)", LOST]
    assert_alike(with_law(ROD, law), samples, outputs, 0.2, rel=1e-8, abs=1e-9, **FINE)


def test_poissons_law_of_several_contacts():
    m = with_law(ROW, "poisson")
    assert_alike(m, {"e": np.array([1.0, 0.5, 0.0])}, ["final(a.vx)", "final(b.vx)", "final(c.vx)"], 0.5, **FINE)
    falls = block().replace("y = 0.1", "y = 0.15").replace("restitution = 0", "restitution = 0.5")
    samples = {"v": np.array([0.0, 0.3, 2.0])}
    m = with_law(falls.replace("omega = 0", "omega = 0.4"), "poisson")
    assert_alike(m, samples, ["final(block.x)", LOST], 0.6, rel=1e-9, abs=1e-9)


STIFF = ROW.replace('restitution = "e"', 'restitution = "e", stiffness = 1')


@pytest.mark.parametrize("law", ["energetic", "lzb"])
def test_impacts_by_energy_one_after_the_other(law):
    """v- of the first ball is shared (1 - e) : (1 + e) by each pair, and what is slower is not caught up with."""
    m, e = with_law(STIFF, law).set(gap=0.3), np.array([1.0, 0.9, 0.5])
    _, (a, b, c) = side_by_side(m, {"e": e}, ["final(a.vx)", "final(b.vx)", "final(c.vx)"], 1.5, **FINE)
    np.testing.assert_allclose(a, (1.0 - e) / 2.0, atol=1e-15)
    np.testing.assert_allclose(b, (1.0 + e) * (1.0 - e) / 4.0, atol=1e-15)
    np.testing.assert_allclose(c, (1.0 + e) ** 2 / 4.0, atol=1e-15)
    for k, x in enumerate(e):
        r = m.set(e=x).simulate(1.5, **FINE)
        np.testing.assert_allclose([r[f"{ball}.vx"][-1] for ball in "abc"], [a[k], b[k], c[k]], atol=1e-15)


@pytest.mark.parametrize(("law", "other"), [("lzb", "newton"), ("poisson", "newton"), ("newton", "energetic")])
def test_joints_with_several_laws_are_refused_as_alone(law, other):
    text = STIFF.replace('restitution = "e"', f'restitution_law = "{law}", restitution = "e"', 1)
    text = text.replace(
        '{ model = "impact", restitution = "e"', f'{{ model = "impact", restitution_law = "{other}", restitution = "e"'
    )
    found = rt.loads(text).many({"e": [0.5]}, t_end=0.5, outputs=["final(c.vx)"])
    assert "needs one law for all joints" in found.message(0)


@pytest.mark.parametrize("law", ["energetic", "lzb"])
def test_impacts_by_energy_of_several_contacts_run_alone(law):
    m = with_law(STIFF, law)
    found = m.many({"e": [0.5]}, t_end=0.5, outputs=["final(c.vx)"], **FINE)
    assert "more contacts at once" in found.stats["how"]
    assert not found.messages
    assert found["final(c.vx)"][0] == m.set(e=0.5).simulate(0.5, **FINE)["c.vx"][-1]


def shafts(clutch, stop="", load="T*cos(2*t)"):
    return rt.loads(f"""
format = 1
parameters = {{ T = 1.0, w = 0.2 }}
ground.points.O = [0, 0]
bodies.one = {{ points = {{ C = [0, 0] }}, mass = 1, inertia = 1 }}
bodies.two = {{ points = {{ C = [0, 0] }}, mass = 1, inertia = 2 }}
joints.p = {{ type = "revolute", connect = ["ground.O", "one.C"]{stop} }}
joints.q = {{ type = "revolute", connect = ["ground.O", "two.C"] }}
joints.way = {{ type = "clutch", connect = ["one", "two"], {clutch} }}
loads.push = {{ type = "torque", body = "one", torque = "{load}" }}
initial = {{ one = {{ angle = 0, omega = 0 }}, two = {{ angle = 0, omega = "w" }} }}
""")


CLUTCHES = [
    'model = "ideal"', 'model = "viscous", damping = 5', 'model = "viscous", damping = 5, sense = -1',
    'model = "compliant", stiffness = 300', 'model = "compliant", stiffness = 300, damping = 0.5',
    'model = "ratchet", teeth = 24', 'model = "ratchet", teeth = 24, sense = -1',
]  # fmt: skip


@pytest.mark.parametrize("clutch", CLUTCHES)
def test_a_one_way_clutch_takes_and_lets_go(clutch):
    outputs = ["final(two.omega)", "final(one.angle)", "max(way.torque)", "count(way.contacts)", LOST]
    assert_alike(shafts(clutch), {"T": np.array([1.0, 2.0, 4.0])}, outputs, 3.0, abs=1e-8)
    assert_alike(shafts(clutch, load="T*cos(6*t)"), {"w": np.array([-1.0, 0.0, 0.5])}, outputs, 2.0, abs=1e-8)


@pytest.mark.parametrize("clutch", CLUTCHES[3:5])
def test_an_elastic_clutch_that_is_outrun_at_the_start(clutch):
    m = shafts(clutch).set({"initial.one.omega": 1.5})
    assert_alike(m, {"T": np.array([1.0, 2.0])}, ["final(two.omega)", "count(way.contacts)", LOST], 1.0, abs=1e-8)


@pytest.mark.parametrize("clutch", CLUTCHES)
def test_a_clutch_whose_rates_jump(clutch):
    """One shaft hits stops, which may let the clutch take, or let go."""
    m = shafts(clutch, ', stop = { min = -0.1, max = 0.1, contact = { model = "impact", restitution = 0.6 } }')
    outputs = ["final(two.omega)", "final(one.angle)", "max(way.torque)", "min(way.torque)", "count(p.contacts)"]
    assert_alike(m, {"T": np.array([-2.0, 2.0, 4.0])}, outputs, 1.5, rel=1e-5, abs=1e-7)


def test_clutches_that_let_go_of_fast_shafts_do_not_take_again_by_rounding():
    """What is left of equal speeds of 50 rad/s, behind rods, is 3e-13 rad/s; it grows with the second power of time."""
    m = rt.example("torque_converter")
    r = m.parameters["r"] * (1.0 + 1e-4 * np.linspace(-1.0, 1.0, 8))[[0, 4, 5]]
    assert_alike(m, {"r": r}, ["final(rotor.angle)", "max(one.torque)"], 0.1, rel=1e-6, rtol=1e-8)


SLIPS = 'model = "ideal", max_torque = 0.8'


def test_a_clutch_that_slips_at_its_largest_torque_until_both_shafts_are_equally_fast():
    """One shaft turns with 3 rad/s, the other takes M/J until the sum of momenta is shared; T = 0."""
    m = shafts(SLIPS, load="T*cos(0)").set({"initial.one.omega": 3.0})
    w = np.array([0.2, -1.0, 1.5])
    samples, outputs = (
        {"T": np.zeros(3), "w": w},
        ["final(two.omega)", "final(one.angle)", LOST, "first(way.torque < 0.79)"],
    )
    _, (rate, angle, lost, ends) = side_by_side(m, samples, outputs, 4.0, **FINE)
    together = (3.0 + 2.0 * w) / 3.0
    slip = (3.0 - together) / 0.8
    assert rate == pytest.approx(together, rel=1e-10)
    assert ends == pytest.approx(slip, rel=1e-6)
    assert lost == pytest.approx(0.5 * (2.0 / 3.0) * (3.0 - w) ** 2, rel=1e-9)
    assert angle == pytest.approx(3.0 * slip - 0.4 * slip**2 + together * (4.0 - slip), rel=1e-9)


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize(
    "stop", ["", ', stop = { min = -0.1, max = 0.1, contact = { model = "impact", restitution = 0.6 } }']
)
def test_clutches_with_a_largest_torque_hold_slip_and_let_go_as_alone(sense, stop):
    m = shafts(f"{SLIPS}, sense = {sense}", stop, "T*cos(6*t)")
    outputs = ["final(two.omega)", "final(one.angle)", "max(way.torque)", "share(way.torque > 0.79)", LOST]
    t_end = 0.7 if stop else 2.0
    assert_alike(m, {"T": np.array([-6.0, 2.0, 5.0])}, outputs, t_end, rel=1e-6, abs=1e-8)


def test_counts_of_clutches_that_single_runs_alone_tell():
    found = shafts(SLIPS).many({"T": [1.0]}, t_end=1.0, outputs=["count(way.contacts)"])
    assert "which contacts of the clutch way begin, as it slips at max_torque" in found.stats["how"]
    found = shafts('model = "ideal"').many({"T": [1.0]}, t_end=1.0, outputs=["count(way.impacts)"])
    assert "only single runs tell impacts of the clutch way" in found.stats["how"]
    stop = ', stop = { min = -0.1, max = 0.1, contact = { model = "impact", restitution = 0.6 } }'
    found = shafts('model = "ideal"', stop).many({"T": [1.0]}, t_end=1.0, outputs=["count(way.contacts)"])
    assert "only single runs tell which contacts of the clutch way begin together with others" in found.stats["how"]


def test_a_start_in_touch_counts_from_what_holds_there():
    """Its accelerations are not those of a free fall."""
    m = rt.loads(block())
    assert_alike(m, {"v": np.array([0.0, 0.3])}, ["max(abs(block.ay))", "max(floor.normal)", "min(floor.normal)"], 0.01)


@pytest.mark.parametrize(
    "law", ["restitution = 0.8", "exponent = 1", "exponent = 1.5", "exponent = 1.5, damping = 50"],
)  # fmt: skip
@pytest.mark.parametrize("h", [-1e-4, -2e-2])
def test_what_starts_inside_its_wall_is_pressed_out(law, h):
    """Its spring holds energy from the start on: E = int F; h above the rest for a linear one, m w^2 h."""
    model = "lankarani-nikravesh" if "restitution" in law else "hertz"
    m = rt.loads(ball(f'{{ model = "{model}", stiffness = "k", {law} }}', h=h))
    outputs = ["final(ball.y)", "count(rail.contacts)", "final(energy.potential)", "final(energy.dissipated)"]
    assert_alike(m, {"k": np.array([0.9e5, 1e5])}, outputs, 0.1, rel=1e-7, abs=1e-9)
    if law == "exponent = 1" and h == -2e-2:  # it leaves the wall with what is left of its spring
        _, (height,) = side_by_side(m, {"k": np.array([1e5])}, ["max(ball.y)"], 1.0)
        assert height == pytest.approx(0.5e5 * h * h / G + h, rel=1e-9)


def test_what_pushes_again_before_its_gap_opens_holds_what_its_spring_does():
    """It comes to rest on its spring: V = -(m g)^2/(2 k), and h is lost."""
    m = rt.loads(ball('{ model = "hertz", stiffness = "k", exponent = 1, damping = 632 }', h=0.05))
    outputs = ["final(energy.potential)", "final(energy.dissipated)", "count(rail.contacts)"]
    _, (potential, lost, count) = side_by_side(m, {"h": np.array([0.05, 0.1])}, outputs, 1.0, **FINE)
    assert potential == pytest.approx(-(G**2) / 2e5, rel=1e-6)
    assert lost == pytest.approx(G * np.array([0.05, 0.1]) + G**2 / 2e5, rel=1e-8)
    assert list(count) == [2, 2]
    run = m.simulate(t_end=1.0, t_eval=np.linspace(0.0, 1.0, 2001), **FINE)
    assert run["energy.potential"][-1] == pytest.approx(-(G**2) / 2e5, rel=1e-6)
    assert np.diff(run["energy.dissipated"]).min() > -1e-9


@pytest.mark.parametrize("law", ["lugre", "dahl"])
def test_bristles_bend_in_every_contact_anew(law):
    sigma = "sigma0" if law == "lugre" else "sigma"
    bristles = f'friction = {{ model = "{law}", mu = "mu", {sigma} = 1e4 }}'
    m = rt.loads(slider_crank(f'{{ model = "lankarani-nikravesh", {PRESSED}, {bristles} }}'))
    outputs = ["count(B.contacts)", "time(B.contacts, 3)", "final(rod.omega)", LOST]
    assert_alike(m, {"c": 5e-4 * np.array([0.95, 1.05])}, outputs, 0.004, rel=1e-7, rtol=1e-9, atol=1e-12)


def test_a_pin_that_starts_at_its_wall_but_for_rounding_is_in_contact():
    m = rt.example("slider_crank_worn")
    samples = {"c": 30e-6 * np.linspace(0.99, 1.01, 16)}  # by rounding half of the offsets [c, 0] are beyond the wall
    outputs = ["count(B.contacts)", "final(slider.vx)", "final(energy.balance)", "time(B.contacts, 1)"]
    _, values = side_by_side(m, samples, outputs, 0.002, rtol=1e-10)
    some = slice(None, None, 5)
    single = alone(m, {"c": samples["c"][some]}, outputs[:2], 0.002, rtol=1e-10)
    assert values[:2, some] == pytest.approx(single, rel=1e-8)
    assert (values[0] == 1.0).all()
    assert np.abs(values[2:]).max() < 1e-8


@pytest.mark.parametrize(
    ("name", "varied", "outputs", "t_end"),
    [
        ("gear_rattle", {"R_1": 0.03}, ["final(idle.angle)", "time(mesh.contacts, 3)"], 0.05),
        ("cam_lift_off", {"h": 0.008, "R": 0.015}, ["final(follower.y)", "at(follower.vy, 0.002)"], 0.006),
        ("scotch_yoke", {"r": 0.05, "c": 5e-5}, ["final(yoke.x)", "time(slot.contacts, 2)"], 0.03),
    ],
)
def test_starts_with_teeth_faces_and_slots_closed_follow_from_parameters(name, varied, outputs, t_end, monkeypatch):
    """None is put together by itself."""
    monkeypatch.setattr(Starts, "assemble", None)
    m = rt.example(name)
    samples = {key: value * np.linspace(0.99, 1.01, 5) for key, value in varied.items()}
    _, values = side_by_side(m, samples, outputs, t_end, rtol=1e-10)
    monkeypatch.undo()
    assert values == pytest.approx(alone(m, samples, outputs, t_end, rtol=1e-10), rel=1e-7)


SHAKEN = """
format = 1
gravity = [0, -10]
parameters = { F = 15.0, w = 20.0, later = 2.0 }
ground.points.O = [0, 0]
bodies.ball = { points = { C = [0, 0] }, mass = 1, inertia = 1 }
joints.rail = { type = "prismatic", connect = ["ground.O", "ball.C"], axis = "90 deg", angle = 0, stop = STOP }
loads.push = { type = "force", at = "ball.C", force = [0, "LOAD"] }
initial.ball = { y = 0, vy = 0 }
""".replace("STOP", '{ min = 0, contact = { model = "impact", restitution = 0 } }')


@pytest.mark.parametrize("load", ["F*cos(w*t)", "4*F*exp(-((t - later)/0.02)**2)"])
@pytest.mark.parametrize("rtol", [1e-6, 1e-11])
def test_what_rests_is_lifted_by_every_load_that_exceeds_its_weight(load, rtol):
    """At rest nothing in the state limits a step."""
    samples = {"F": np.array([11.0, 15.0, 19.0]), "w": np.array([5.0, 20.0, 57.0])}
    outputs = ["count(rail.contacts)", "final(energy.dissipated)"]
    assert_alike(rt.loads(SHAKEN.replace("LOAD", load)), samples, outputs, 3.0, rel=1e-5, rtol=rtol)


def test_a_clutch_is_struck_shut_at_the_start():
    """The first one evens out its bodies, which makes the second one take as well."""
    bodies = "".join(
        f"""
bodies.{name} = {{ points.C = [0, 0], mass = 1, inertia = 1 }}
joints.on_{name} = {{ type = "revolute", connect = ["ground.O", "{name}.C"] }}
initial.{name} = {{ angle = 0, omega = "{name}_speed" }}"""
        for name in ("one", "two", "three")
    )
    m = rt.loads(f"""
format = 1
parameters = {{ one_speed = 0.0, two_speed = -1.0, three_speed = -0.9 }}
ground.points.O = [0, 0]{bodies}
joints.first = {{ type = "clutch", connect = ["one", "two"], model = "ideal" }}
joints.second = {{ type = "clutch", connect = ["two", "three"], model = "ideal" }}
""")
    speeds = np.array([[0.0, -1.0, -0.9], [0.0, 0.1, -1.0], [0.0, -1.0, 0.2]]).T
    outputs = ["final(one.omega)", "final(two.omega)", "final(three.omega)"]
    names = ("one_speed", "two_speed", "three_speed")
    _, values = side_by_side(m, dict(zip(names, speeds, strict=True)), outputs, 0.1)
    expected = np.array([[-1.9 / 3] * 3, [-0.3] * 3, [-0.5, -0.5, 0.2]]).T
    assert values == pytest.approx(expected, abs=1e-12)


def test_a_force_that_is_largest_at_the_touch_is_the_peak():
    m = rt.loads(ball('{ model = "hertz", stiffness = "k", exponent = 1, damping = 1000 }', h=0.05))
    _, values = side_by_side(m, {"k": [1e4, 1e5]}, ["peak(rail.contacts, 1)"], 0.12)
    assert values == pytest.approx(1000 * math.sqrt(2 * G * 0.05), rel=1e-7)


@pytest.mark.parametrize("law", ["kelvin-voigt", "anagnostopoulos"])
def test_a_force_whose_slope_is_infinite_at_the_touch_has_its_peak(law):
    """A damper by the secant stiffness of a force that is not linear: F' grows as depth^(-3/4)."""
    m = rt.loads(ball(f'{{ model = "{law}", stiffness = "k", exponent = 1.5, restitution = 0.5 }}', h=0.05))
    samples = {"k": 1e5 * np.linspace(0.5, 2.0, 40)}
    _, (peak, most) = side_by_side(m, samples, ["peak(rail.contacts, 1)", "max(abs(rail.stop))"], 0.12)
    assert peak == pytest.approx(most, rel=1e-4)


TURNED = """
format = 1
gravity = [0, -10]
parameters = { w = 20.0, r = 0.02 }
ground.points = { O = [0, 0], Q = [0, 0.3] }
bodies.ball = { points.C = [0, 0], mass = 1, inertia = 1 }
bodies.rotor = { points = { C = [0, 0], E = ["r", 0] }, mass = 1, inertia = 1e6 }
joints.rail = { type = "prismatic", connect = ["ground.O", "ball.C"], axis = "90 deg", angle = 0, stop = STOP }
joints.bearing = { type = "revolute", connect = ["ground.Q", "rotor.C"] }
loads.spring = { type = "spring", connect = ["ball.C", "rotor.E"], stiffness = 1000, free_length = 0.3 }
initial.ball = { y = 0, vy = 0 }
MOTION
""".replace("STOP", '{ min = 0, contact = { model = "impact", restitution = 0 } }')


@pytest.mark.parametrize(
    "motion", ['drivers.motor = { joint = "bearing", angle = "w*t" }', "initial.rotor = { angle = 0, omega = 'w' }"]
)
def test_what_rests_is_lifted_by_what_turns(motion):
    """Once a turn, however evenly it turns: a spring of 1000 N/m to a pin on a rotor pulls by 1000 r sin(w t)."""
    m = rt.loads(TURNED.replace("MOTION", motion))
    samples = {"w": np.array([57.0, 20.0]), "r": np.array([0.0101, 0.0102])}
    for rtol in (1e-6, 1e-11):
        _, (lifts,) = side_by_side(m, samples, ["count(rail.contacts)"], 5.0, rtol=rtol)
        assert list(lifts) == [46, 16]  # (w t + 3 pi/2)/(2 pi), whole turns


def test_a_short_motion_of_a_driver_is_not_stepped_over():
    """Shorter than a step: it lifts what rests below its spring, v' = A k g(t)/m - 10 by quadrature."""
    driven = TURNED.replace('"revolute"', '"prismatic"').replace('["ground.Q", "rotor.C"]', '["ground.O", "rotor.C"]')
    driven = driven.replace("rotor.E", "rotor.C").replace("joints.bearing = {", 'joints.bearing = { axis = "90 deg",')
    driven = driven.replace("joints.bearing = {", "joints.bearing = { angle = 0,")
    m = rt.loads(
        driven.replace("MOTION", 'drivers.motor = { joint = "bearing", position = "0.3 + r*exp(-((t - 1.5)*w)**2)" }')
    )
    samples = {"r": np.array([0.02, 0.005]), "w": np.array([100.0, 100.0])}
    _, (count, lost) = side_by_side(m, samples, ["count(rail.contacts)", "final(energy.dissipated)"], 3.0, rtol=1e-9)
    assert list(count) == [1, 0]
    assert lost == pytest.approx([0.017163, 0.0], rel=1e-4)


@pytest.mark.parametrize(
    "law", ['model = "hertz", damping = 20', 'model = "hertz"', 'model = "flores", restitution = 0.5']
)
def test_what_leaves_its_wall_at_the_start_is_no_contact(law):
    m = rt.loads(thrown(f'{{ stiffness = "k", exponent = 1.5, {law} }}'))
    up = np.array([1.0, 0.5])
    _, (count, first) = side_by_side(
        m, {"lift": up}, ["count(rail.contacts)", "time(rail.contacts, 1)"], 0.205, rtol=1e-10
    )
    assert first == pytest.approx(2 * up / G, rel=1e-8)
    assert count[0] == 1


def thrown(contact):
    return ball(contact, h=0.0, e=0.5).replace("vy = 0", 'vy = "lift"')


def test_slow_impacts_count_however_little_they_rise():
    """A hop of 1e-5 m/s comes back after 2 v/g."""
    speeds = np.array([1e-3, 1e-5])
    outputs = ["time(rail.contacts, 1)", "speed(rail.contacts, 1)"]
    _, (first, speed) = side_by_side(rt.loads(thrown(RIGID_STOP)), {"lift": speeds}, outputs, 0.01, **FINE)
    assert first == pytest.approx(2 * speeds / G, rel=1e-3)
    assert speed == pytest.approx(speeds, rel=1e-3)


@pytest.mark.parametrize("usual", [0.5, 3.0])
def test_the_range_of_a_stop_is_free(usual):
    m = rt.loads(SHAKEN.replace("LOAD", "20").replace("min = 0", 'min = 0, max = "later"'))
    samples = {"later": np.array([0.3, 0.9, 1.1, 2.5, 1000.0])}
    _, (place,) = side_by_side(m.set(later=usual), samples, ["final(ball.y)"], 1.0)
    assert place == pytest.approx([0.3, 0.9, 1.1, 2.5, 5.0], rel=1e-9)


@pytest.mark.parametrize("contact", [f'{{ model = "lankarani-nikravesh", {PRESSED} }}', RIGID])
def test_samples_of_another_form_do_not_stop_the_others(contact):
    """Without play there is no contact."""
    found = rt.loads(slider_crank(contact)).many({"c": [5e-4, 0.0, -1e-4]}, ["final(slider.x)"], 0.001)
    assert np.isfinite(found["final(slider.x)"][:2]).all()
    assert found.failed.tolist() == [2]


@pytest.mark.parametrize("contact", [f'{{ model = "lankarani-nikravesh", {PRESSED} }}', RIGID])
def test_a_sample_has_the_same_bits_in_any_company(contact):
    m, random = rt.loads(slider_crank(contact)), np.random.default_rng(1)
    c = random.uniform(2e-4, 9e-4, 40)
    outputs = ["final(slider.x)", "max(abs(slider.vx))", "time(B.contacts, 2)", "count(B.contacts)"]

    def run(which, threads):
        return side_by_side(m, {"c": c[which]}, outputs, 2e-3, rtol=1e-9, threads=threads)[1]

    every, mixed = np.arange(40), random.permutation(40)
    whole = run(every, 2)
    for which, threads in ((every, 1), (mixed, 2), (every[11:12], 1), (every[20:33], 2)):
        assert np.array_equal(whole[:, which], run(which, threads), equal_nan=True)


# ---------------------------------------------------------------- what is not followed
def test_what_runs_one_by_one_is_said():
    jammed = rt.loads(ball('{ model = "impact", restitution = "e" }'))
    found = jammed.many({"e": [0.5]}, t_end=1.0, outputs=["max(rail.impulse)"])
    assert "events that only single runs tell" in found.stats["how"]
    equal = jammed.many({"e": [0.5]}, t_end=1.0, outputs=["final(ball.y)"], method="rk4", step=1e-3)
    assert "steps of equal length do not end at contacts (joint rail)" in equal.stats["how"]
    assert not equal.messages


# ---------------------------------------------------------------- ropes, belts, discs
LAWS_OF_WALLS = [
    '{ model = "hertz", stiffness = 1e6, exponent = 1.5, damping = 5 }',
    '{ model = "impact", restitution = 0.5 }',
    '{ model = "impact", restitution = 0.5, friction = 0.2 }',
]


@pytest.mark.parametrize("contact", LAWS_OF_WALLS[:2])
def test_a_rope_and_a_least_distance(contact):
    m = rt.loads(f"""
format = 1
gravity = [0, -9.81]
parameters.v = 2.0
ground.points.O = [0, 0]
bodies.b = {{ points = {{ C = [0, 0], P = [0.1, 0.05] }}, mass = 1, inertia = 0.02 }}
joints.rope = {{ type = "rod", connect = ["ground.O", "b.P"], stop = {{ min = 0.4, max = 1, contact = {contact} }} }}
initial = {{ b = {{ x = 0.3, y = -0.5, angle = 0.1, vx = "v", vy = 0.5, omega = 1 }} }}
""")
    outputs = ["final(b.x)", "final(b.y)", "count(rope.contacts)", "time(rope.contacts, 3)", LOST]
    assert_alike(m, {"v": np.array([1.0, 2.0, 3.0])}, outputs, 1.2, rel=1e-6, abs=1e-8)


@pytest.mark.parametrize("contact", LAWS_OF_WALLS)
@pytest.mark.parametrize(("shape", "x", "y"), [("radius = 0.2", 0.02, 0.3), ("axis = 0, length = 0.4", 0.1, 0.1)])
def test_a_disc_falls_on_a_disc_and_on_a_segment_beyond_its_end(contact, shape, x, y):
    m = rt.loads(f"""
format = 1
gravity = [0, -9.81]
parameters.v = 0.3
ground.points.O = [0, 0]
bodies.b = {{ points = {{ C = [0, 0] }}, mass = 1, inertia = 0.001 }}
joints.on = {{ type = "surface", connect = ["ground.O", "b.C"], {shape}, roller = 0.05, contact = {contact} }}
initial = {{ b = {{ x = {x}, y = {y}, angle = 0, vx = "v", vy = 0, omega = 1 }} }}
""")
    outputs = ["final(b.x)", "final(b.y)", "count(on.contacts)", "time(on.contacts, 2)", LOST]
    assert_alike(m, {"v": np.array([0.1, 0.3, 0.5])}, outputs, 0.6, rel=1e-6, abs=1e-8)


def test_the_strands_of_a_belt_pull_and_hang():
    m = rt.example("belt_drive")
    outputs = ["final(wheel.omega)", "max(belt.tight)", "count(belt.contacts)", "time(belt.contacts, 3)"]
    for name in ("M", "R_1", "T_0"):
        assert_alike(m, {name: m.parameters[name] * np.array([0.99, 1.0])}, outputs, 0.3, rel=1e-6, rtol=1e-9)


PLANK = """
format = 1
gravity = ["9.81*sin(tilt)", "-9.81*cos(tilt)"]
parameters = {{ tilt = 0.25, mu = 0.2 }}
ground.points = {{ F = [0, 0] }}
bodies.b = {{ points = {{ C = [0, -0.05], P = [-0.1, -0.05], Q = [0.1, -0.05] }}, mass = 1, inertia = 0.005 }}
initial.b = {{ x = {x}, y = {y}, angle = {angle}, vx = 0, vy = 0, omega = 0 }}
[joints.floor]
type = "surface"
connect = ["ground.F", "b.C"]
axis = "0 deg"
length = 2
corners = ["P", "Q"]
contact = {{ {law} }}
"""
RIGID_PLANK = 'model = "impact", restitution = 0.3, friction = "mu"'
ELASTIC_PLANK = 'model = "lankarani-nikravesh", stiffness = 1e8, restitution = 0.5, friction = "mu"'


@pytest.mark.parametrize("law", [RIGID_PLANK, ELASTIC_PLANK])
@pytest.mark.parametrize(("y", "angle"), [(0.05, 0), (0.07, 0.02)])
def test_a_block_slides_and_falls_on_a_segment(law, y, angle):
    """Within its ends it is a line."""
    m = rt.loads(PLANK.format(x=-0.3, y=y, angle=angle, law=law))
    assert_alike(m, {"mu": np.array([0.1, 0.2])}, ["final(b.x)", "final(b.vx)", "final(b.y)"], 0.4, rel=1e-6, abs=1e-9)


@pytest.mark.parametrize(
    ("x", "y", "angle", "outputs", "why"),
    [
        (0.8, 0.05, 0, ["final(b.x)"], "the end of a segment"),  # it slides off
        (1.05, 0.0501, 0, ["final(b.x)"], "the end of a segment"),  # the right corner falls beside it
        (-0.3, 0.07, 0.3, ["final(b.x)"], "a corner starts below its segment"),
        (-0.3, 0.05, 0, ["min(floor.gap)"], "the gap of a segment"),
    ],
)
@pytest.mark.parametrize("law", [RIGID_PLANK, ELASTIC_PLANK])
def test_ends_of_segments_are_left_to_single_runs(law, x, y, angle, outputs, why):
    m = rt.loads(PLANK.format(x=x, y=y, angle=angle, law=law))
    a = m.many({"mu": [0.1, 0.15]}, outputs, t_end=1.0, **FINE)
    assert list(a.generic) == [0, 1]
    assert why in str(a)
    assert a[outputs[0]] == pytest.approx(alone(m, {"mu": [0.1, 0.15]}, outputs, 1.0, **FINE)[0], rel=1e-12)


def test_a_contact_whose_force_ends_just_where_its_gap_does_is_not_counted_twice():
    random = np.random.default_rng(0)
    samples = {"M": random.uniform(1.0, 4.0, 40), "v": random.uniform(0.2, 2.0, 40)}
    outputs = ["count(rail.contacts)", "time(rail.contacts, 2)", "min(block.x)"]
    assert_alike(rt.loads(undamped()), samples, outputs, 1.2, rel=1e-6, abs=1e-8, **FINE)


@pytest.mark.parametrize("law", ["kelvin-voigt", "hertz"])
def test_a_contact_never_pulls_at_its_ends(law):
    """A damper that pushes from the first depth on has no force just beyond it; others have rounding."""
    damped = ", restitution = 0.5, effective_mass = 1" if law == "kelvin-voigt" else ""
    spring = f'{{ model = "{law}", stiffness = 1e5, exponent = 1{damped} }}'
    m = rt.loads(f"""
format = 1
gravity = [0, 0]
parameters.v = 0.5
ground.points.O = [0, 0]
bodies.ball = {{ points = {{ C = [0, 0] }}, mass = 1, inertia = 1 }}
initial.ball = {{ x = 0, vx = "v" }}
[joints.rail]
type = "prismatic"
connect = ["ground.O", "ball.C"]
stop = {{ max = 0.01, contact = {spring} }}
""")
    speeds = np.linspace(0.4, 0.6, 9)
    found = m.many({"v": speeds}, ["max(rail.stop)", "final(ball.vx)"], 0.1)
    assert (found["max(rail.stop)"] <= 0.5).all()
    for v, after in zip(speeds, found["final(ball.vx)"], strict=True):
        r = m.set(v=v).simulate(0.1, t_eval=[0.0, 0.1])
        (one,) = (event for event in r.events if event.kind == "contact")
        assert m.set(v=v).simulate(0.1, t_eval=[one.t + one.duration])["rail.stop"][0] <= 0.0
        assert after == pytest.approx(r["ball.vx"][-1], rel=1e-6)
