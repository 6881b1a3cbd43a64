"""Derivatives through contacts: closed forms, differences of runs, and what is told."""

import math

import numpy as np
import pytest

import rattle as rt
from balls import G, ball
from blocks import undamped
from rattle.errors import InputError, ModelError, TraceError
from rattle.questions.sensitivity.effects import effects
from runs_beside import FINE, differences

ROUNDING = 1e-7  # share by which derivatives of a run may be off
ELASTIC = '{ model = "hertz", stiffness = "k", exponent = 1 }'


def disc(spin=40.0, mu=0.3, law="newton"):
    contact = (
        f'{{ model = "impact", restitution = "e", friction = "mu", bush_radius = "10 mm", restitution_law = "{law}" }}'
    )
    return f"""
format = 1
parameters = {{ c = 1e-3, e = 0.8, mu = {mu}, spin = {spin}, v = 1.0 }}
ground.points.O = [0, 0]
bodies.pin = {{ points = {{ P = [0, 0] }}, mass = 1, inertia = 1e-4 }}
joints.O = {{ type = "revolute", connect = ["ground.O", "pin.P"], clearance = "c", contact = {contact} }}
initial.pin = {{ x = 0, y = 0, angle = 0, vx = "v", vy = 0, omega = "spin" }}
"""


def slider_crank(contact):
    """With play in the pin of the slider."""
    return f"""
format = 1
parameters = {{ c = 5e-4, e = 0.8, mu = 0.1, l = 0.12, omega = 500.0, F = 20.0 }}
ground.points.O = [0, 0]
bodies.crank = {{ points = {{ O = [0, 0], A = [0.05, 0] }}, mass = 0.3, inertia = 1e-4 }}
bodies.rod = {{ bar = ["A", "B"], length = "l", mass = 0.21, inertia = 2.5e-4 }}
bodies.slider = {{ points = {{ B = [0, 0] }}, mass = 0.14, inertia = 1e-4 }}
joints.O = {{ type = "revolute", connect = ["ground.O", "crank.O"] }}
joints.A = {{ type = "revolute", connect = ["crank.A", "rod.A"] }}
joints.B = {{ type = "revolute", connect = ["slider.B", "rod.B"], clearance = "c", contact = {contact} }}
joints.guide = {{ type = "prismatic", connect = ["ground.O", "slider.B"], axis = 0 }}
drivers.motor = {{ joint = "O", angle = "omega*t" }}
loads.push = {{ type = "force", at = "slider.B", force = ["F", 0] }}
initial.rod = {{ angle = 0 }}
initial.slider = {{ x = "0.05 + l" }}
initial.B = {{ offset = [0, 0] }}
"""


def slopes(m, outputs, parameters, t):
    s = m.sensitivity(outputs, parameters, t, **FINE)
    assert s.success, s.message
    return {(of, to): s[f"d({of})/d({to})"] for of in outputs for to in parameters}


# ---------------------------------------------------------------- closed forms
def test_a_ball_that_bounces_has_the_slopes_of_its_closed_form():
    e, t1 = 0.8, math.sqrt(2 / G)
    of = ["ball.y", "ball.vy", "time(rail.contacts, 4)", "speed(rail.contacts, 4)"]
    d = slopes(rt.loads(ball()), of, ["h", "e"], [0.0, 0.3, 0.7])
    late = slopes(rt.loads(ball()), of[2:], ["h", "e"], [0.0, 2.5])
    assert d["ball.y", "h"][1] == pytest.approx(1.0, abs=1e-9)
    assert d["ball.y", "e"][2] == pytest.approx(G * t1 * (0.7 - t1), rel=ROUNDING)
    assert d["ball.vy", "h"][2] == pytest.approx((1 + e) / t1, rel=ROUNDING)
    assert np.isnan(d[of[2], "h"]).all()  # it does not come in this time
    assert late[of[2], "h"][0] == pytest.approx((1 + 2 * (e + e**2 + e**3)) / (G * t1), rel=ROUNDING)
    assert late[of[2], "e"][-1] == pytest.approx(2 * t1 * (1 + 2 * e + 3 * e**2), rel=ROUNDING)
    assert late[of[3], "e"][0] == pytest.approx(3 * G * t1 * e**2, rel=ROUNDING)


def test_a_ball_that_rests_no_longer_knows_from_where_it_fell_and_bears_its_weight():
    lifted = 'loads.lift = { type = "force", at = "ball.C", force = [0, "lift"] }'
    d = slopes(rt.loads(ball(e=0.5, more=lifted)), ["ball.y", "ball.vy", "rail.stop"], ["h", "lift"], [0.0, 3.0])
    assert [d["ball.y", "h"][-1], d["ball.vy", "h"][-1], d["rail.stop", "h"][-1]] == pytest.approx([0, 0, 0], abs=1e-8)
    assert abs(d["rail.stop", "lift"][-1]) == pytest.approx(1.0, rel=1e-6)


def test_a_rested_ball_that_is_lifted_leaves_when_its_force_ends():
    """From rest at t > 2 s on: up by a force that grows, F = G at t = 4 s; y = p (t - 4)^3/6."""
    pull = 'loads.lift = { type = "force", at = "ball.C", force = [0, "(9.81 + lift)*t/4"] }'
    d = slopes(rt.loads(ball(h=0.01, e=0.3, more=pull)), ["ball.y"], ["lift"], [0.0, 3.5, 5.0])
    # y'' = (9.81 + q) t/4 - 9.81, leaves at t0 = 4 9.81/(9.81 + q); dy/dq = (t - t0)^2 (t + 2 t0)/24 + 0
    assert d["ball.y", "lift"][1] == pytest.approx(0.0, abs=1e-9)
    assert d["ball.y", "lift"][2] == pytest.approx((5.0 - 4.0) ** 2 * (5.0 + 8.0) / 24, rel=1e-5)


def test_an_elastic_stop_gives_times_and_forces_of_a_spring():
    m = rt.loads(ball(ELASTIC))
    k, v = 1e5, math.sqrt(2 * G)
    w = math.sqrt(k)
    of = ["time(rail.contacts, 2)", "peak(rail.contacts, 1)"]
    d = slopes(m, of, ["h", "k"], [0.0, 1.6])
    lasts = 2 / w * (math.pi - math.atan(v * w / G))
    by_w = -lasts / w - 2 / w * (v / G) / (1 + (v * w / G) ** 2)
    by_v = -2 / G / (1 + (v * w / G) ** 2) + 2 / G
    assert d[of[0], "h"][0] == pytest.approx(1 / v + by_v * G / v, rel=1e-6)
    assert d[of[0], "k"][0] * k == pytest.approx(by_w * w / 2, rel=1e-5)
    peak = math.sqrt(G * G + k * v * v)
    assert d[of[1], "h"][0] == pytest.approx(k * G / peak, rel=1e-6)
    assert d[of[1], "k"][0] == pytest.approx(v * v / 2 / peak, rel=1e-6)


def bounced(spin, mu, c=1e-3, e=0.8, v=1.0):
    """Spin after the first contact of the disc, and the instant of the second."""
    arm = 0.01 - c
    along = math.copysign(min(mu * (1 + e) * v, abs(spin * arm) / (1 + arm**2 / 1e-4)), -spin)
    return spin + along * arm / 1e-4, c / v + 2 * c * e * v / ((e * v) ** 2 + along**2)


@pytest.mark.parametrize(("spin", "mu"), [(40.0, 0.3), (300.0, 0.1), (-300.0, 0.1)])
def test_a_disc_that_sticks_or_slips_at_an_impact(spin, mu):
    of = ["pin.omega", "time(O.contacts, 2)"]
    d = slopes(rt.loads(disc(spin, mu)), of, ["spin", "mu", "c", "e"], [0.0, 0.0015, 0.0034])
    now = {"spin": spin, "mu": mu, "c": 1e-3, "e": 0.8}
    for name, x in now.items():
        ways = [bounced(**now | {name: x * (1 + s)}) for s in (1e-5, -1e-5)]
        want = [(a - b) / (2e-5 * x) for a, b in zip(*ways, strict=True)]
        assert d[of[0], name][1] == pytest.approx(want[0], rel=1e-5, abs=1e-6), name
        assert d[of[1], name][0] == pytest.approx(want[1], rel=1e-5, abs=1e-12), name


# ---------------------------------------------------------------- differences of runs
PRESSED = 'stiffness = 6.6e9, exponent = 1.5, restitution = "e", bush_radius = 0.01'
RUBS = 'friction = { model = "coulomb-smooth", mu = "mu", v1 = "0.1 m/s" }'
BRISTLES = 'friction = {{ model = "{}", mu = "mu" }}'
LAWS = {  # contact, end [s]
    "lankarani": (f'{{ model = "lankarani-nikravesh", {PRESSED} }}', 1.3e-3),
    "smooth friction": (f'{{ model = "hunt-crossley", {PRESSED}, {RUBS} }}', 1.3e-3),
    "bristles": (f'{{ model = "hunt-crossley", {PRESSED}, {BRISTLES.format("dahl")} }}', 1.3e-3),
    "damped bristles": (f'{{ model = "hunt-crossley", {PRESSED}, {BRISTLES.format("lugre")} }}', 1.3e-3),
    "linear, damped": ('{ model = "hertz", stiffness = 2e7, exponent = 1, damping = 60, bush_radius = 0.01 }', 1.3e-3),
    "rigid": ('{ model = "impact", restitution = 0.5, bush_radius = 0.01 }', 6e-4),
    "rigid, rubs": ('{ model = "impact", restitution = 0.5, friction = "mu", bush_radius = 0.01 }', 5.5e-4),
}


@pytest.mark.parametrize("law", LAWS)
def test_slopes_are_those_of_runs_beside_it(law):
    contact, t_end = LAWS[law]
    text = slider_crank(contact)
    m, t = rt.loads(text), np.linspace(0.0, t_end, 7)
    curves, contacts = ["rod.angle", "slider.x"], ["time(B.contacts, 2)", "speed(B.contacts, 2)"]
    names = ["c", "l", "F", *(["mu"] if '"mu"' in text else []), *(["e"] if '"e"' in text else [])]
    d = slopes(m, [*curves, *contacts], names, t)
    for name in names:
        least = 3e-4 if "bristles" in law else 1e-5  # runs whose friction begins with a root err by more
        step = (1e-2 if name == "F" else least) * m.parameters[name]  # a force of this size moves little
        near = [m.set(**{name: m.parameters[name] + s}).simulate(t[-1], t_eval=t, **FINE) for s in (step, -step)]
        for of in curves:
            wanted = (near[0][of] - near[1][of]) / (2 * step)
            assert d[of, name] == pytest.approx(wanted, abs=3e-4 * np.abs(wanted).max() + 1e-9), (of, name)
        begun = [[e for e in r.events if e.kind in ("contact", "impact")][1] for r in near]
        by_time, by_speed = ((getattr(begun[0], k) - getattr(begun[1], k)) / (2 * step) for k in ("t", "normal_speed"))
        assert d[contacts[0], name][0] == pytest.approx(by_time, rel=1e-3, abs=1e-9), name
        assert d[contacts[1], name][0] == pytest.approx(by_speed, rel=1e-3, abs=1e-4), name


ENERGIES = ["energy.dissipated", "energy.potential", "energy.work", "energy.kinetic"]


@pytest.mark.parametrize(
    ("text", "name", "t"),
    [
        (ball('{ model = "hertz", stiffness = "k", exponent = 1, damping = 60 }'), "h", [0.0, 0.3, 0.47, 0.8]),
        (slider_crank(LAWS["linear, damped"][0]), "c", [0.0, 2e-4, 6e-4, 9e-4]),
        (slider_crank(LAWS["rigid, rubs"][0]), "c", [0.0, 2e-4, 3.5e-4, 5e-4]),
        (slider_crank(LAWS["rigid"][0]), "l", [0.0, 2e-4, 3.5e-4, 5e-4]),
    ],
)
def test_energies_go_where_those_of_a_run_go(text, name, t):
    """Of a damped contact what is stored when its force ends is lost; drivers do work in impacts."""
    m = rt.loads(text)
    s, r = m.sensitivity(ENERGIES, [name], t, **FINE), m.simulate(t[-1], t_eval=t, **FINE)
    assert s.success, s.message
    wanted = differences(m, name, ENERGIES, t)
    size = max(np.abs(x).max() for x in wanted.values())
    for of in ENERGIES:
        assert s[of] == pytest.approx(r[of], abs=1e-6 * max(1.0, np.abs(r[of]).max())), of
        assert s[f"d({of})/d({name})"] == pytest.approx(wanted[of], abs=3e-4 * size), of


def test_gears_that_knock_have_the_slopes_of_runs_beside_theirs():
    """What counts from the start, as how far the gears have turned, changes with the radii."""
    m, t = rt.example("gear_rattle"), [0.0, 0.03, 0.06]
    for name in ("R_1", "b"):
        d = slopes(m, ["idle.angle", "idle.omega"], [name], t)
        for curve, wanted in differences(m, name, ["idle.angle", "idle.omega"], t, 1e-6).items():
            assert d[curve, name] == pytest.approx(wanted, rel=1e-5, abs=1e-6)


@pytest.mark.parametrize("contact", [
    '{ model = "lankarani-nikravesh", stiffness = 1e5, exponent = 1.5, restitution = 0.5 }',
    '{ model = "impact", restitution = 0.5 }',
])  # fmt: skip
def test_a_rope_that_becomes_taut_has_the_slopes_of_runs_beside_it(contact):
    m = rt.loads(f"""
format = 1
gravity = [0, -9.81]
parameters = {{ L = 1.0, v = 2.0 }}
ground.points.O = [0, 0]
bodies.b = {{ points = {{ C = [0, 0], P = [0.1, 0.05] }}, mass = 1, inertia = 0.02 }}
joints.rope = {{ type = "rod", connect = ["ground.O", "b.P"], stop = {{ max = "L", contact = {contact} }} }}
initial = {{ b = {{ x = 0.3, y = -0.5, angle = 0.1, vx = "v", vy = 0.5, omega = 1 }} }}
""")
    t = [0.0, 0.3, 0.6]
    found = slopes(m, ["b.x", "b.angle"], ["L", "v"], t)
    for (of, to), slope in found.items():
        assert slope == pytest.approx(differences(m, to, [of], t)[of], rel=1e-4, abs=1e-6), (of, to)


def test_a_force_that_is_largest_at_once_moves_with_the_begin():
    m = rt.loads(ball('{ model = "hertz", stiffness = "k", exponent = 1, damping = 1500 }'))
    d = slopes(m, ["peak(rail.contacts, 1)"], ["h", "k"], [0.0, 0.5])
    v = math.sqrt(2 * G)
    assert d["peak(rail.contacts, 1)", "h"][0] == pytest.approx(1500 * G / v, rel=1e-4)
    assert d["peak(rail.contacts, 1)", "k"][0] == pytest.approx(0.0, abs=1e-5)


def test_between_two_stops_no_contact_is_lost():
    text = ball().replace("min = 0,", "min = 0, max = 1.2,").replace("vy = 0", "vy = 3")
    d = slopes(rt.loads(text), ["ball.y"], ["e"], [0.0, 0.3, 0.5])
    wanted = differences(rt.loads(text), "e", ["ball.y"], [0.0, 0.3, 0.5])
    assert d["ball.y", "e"] == pytest.approx(wanted["ball.y"], rel=1e-5, abs=1e-9)


def test_what_does_not_bounce_stays():
    d = slopes(rt.loads(ball(e=0.0)), ["ball.y", "time(rail.contacts, 1)"], ["h"], [0.0, 0.4, 1.0])
    assert d["ball.y", "h"] == pytest.approx([1.0, 1.0, 0.0], abs=1e-9)
    assert d["time(rail.contacts, 1)", "h"][0] == pytest.approx(1 / math.sqrt(2 * G))


# ---------------------------------------------------------------- what is told
@pytest.mark.parametrize("law", ["exact", "gonthier-exact", "kelvin-voigt", "anagnostopoulos", "herbert-mcwhannell"])
def test_a_law_whose_restitution_cannot_be_followed_says_so(law):
    """Also where the contact is open at the start, so that its force does not show."""
    m = rt.loads(ball(f'{{ model = "{law}", stiffness = "k", exponent = 1.5, restitution = "e" }}'))
    assert m.sensitivity(["ball.y"], ["k"], [0.0, 0.5]).success
    with pytest.raises(TraceError, match="a law of contact cannot be followed where 'e' is changed"):
        m.sensitivity(["ball.y"], ["e"], [0.0, 0.5])


def test_a_start_that_is_not_that_of_a_run_is_refused():
    text = slider_crank(LAWS["rigid"][0]).replace("offset = [0, 0]", "offset = [0, 1.25e-4]")
    with pytest.raises(TraceError, match=r"give rod\.omega .*, slider\.vx"):
        rt.loads(text).sensitivity(["rod.omega"], ["l"], [0.0, 2e-5])


def test_a_contact_that_is_pressed_again_before_it_opens_ends_the_answer():
    push = 'loads.push = { type = "force", at = "ball.C", force = [0, "-300*(1 + tanh((t - 0.10958)*5e3))"] }'
    contact = '{ model = "hertz", stiffness = "k", exponent = 1, damping = 400 }'
    s = rt.loads(ball(contact, h=0.05, more=push)).sensitivity(["ball.vy"], ["h"], [0.0, 0.1, 0.11], **FINE)
    assert not s.success
    assert "is pressed again before its gap opens" in s.message


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-11])
def test_what_comes_after_such_a_contact_is_left_out_at_every_tolerance(rtol):
    """A block that starts in its damped floor: its force ends, and begins again 7 ms later without any speed."""
    text = ball('{ model = "hertz", stiffness = 1e4, exponent = 1, damping = 50 }', h=-0.005)
    m = rt.loads(text).set({"bodies.ball.mass": 2.0, "initial.ball.vy": -0.1})
    run = m.simulate(0.2, **FINE)
    ends = run.events[0].t + run.events[0].duration
    s = m.sensitivity(["ball.y"], ["h"], [0.0, 0.5 * ends, ends + 0.004, 0.2], rtol=rtol)
    assert "is pressed again before its gap opens" in s.message
    assert len(s["ball.y"]) == 2


def test_a_contact_that_does_not_come_is_told():
    s = rt.loads(ball()).sensitivity(["time(rail.contacts, 9)"], ["h"], [0.0, 1.0])
    assert "time(rail.contacts, 9) does not come until t = 1 s" in s.trust.notes


def test_a_contact_that_grazes_is_told_and_has_no_slope():
    spring = 'loads.s = { type = "spring", connect = ["ground.S", "ball.C"], stiffness = 100, free_length = 2.5 }'
    m = rt.loads(ball(h=1.0, g=0.0, more=spring))
    s = m.set(h=1 + 1e-8).sensitivity(["ball.y"], ["h"], [0.0, 0.5], **FINE)
    assert any("contact 1 of rail grazes" in note for note in s.trust.notes)
    assert np.isnan(s["d(ball.y)/d(h)"][-1])
    s = m.set(h=1.2).sensitivity(["ball.y"], ["h"], [0.0, 0.5], **FINE)
    assert not s.trust.notes
    assert np.isfinite(s["d(ball.y)/d(h)"]).all()


@pytest.mark.parametrize(
    ("outputs", "words"),
    [
        (["count(rail.contacts)"], "has no derivative: it jumps"),
        (["2*count(rail.contacts)"], "has no derivative: it jumps"),
        (["max(rail.impulse)"], "no derivatives of impulses"),
        (["at(ball.y, 2)"], "2 s is not between 0 and 1 s"),
        (["peak(rail.contacts, 1)"], "they have impulses"),
        (["time(rial.contacts, 1)"], "did you mean 'rail.contacts'"),
    ],
)
def test_what_has_no_derivative_is_refused(outputs, words):
    with pytest.raises((InputError, ModelError), match=words):
        rt.loads(ball()).sensitivity(outputs, ["h"], [0.0, 1.0])


def test_contacts_are_of_runs_in_time():
    with pytest.raises(InputError, match="not in equilibrium"):
        rt.loads(ball()).sensitivity(["time(rail.contacts, 1)"], ["h"], [0.0], "equilibrium")


def test_what_derivatives_cannot_follow_says_so_and_why():
    with pytest.raises(TraceError, match="contacts with oil"):
        rt.example("slider_crank_oil").sensitivity(["slider.x"], ["c"], [0.0, 1e-3])
    with pytest.raises(TraceError, match="the shape of the contacts in lock branches"):
        rt.example("geneva").sensitivity(["wheel.angle"], ["r"], [0.0, 1e-3])
    s = rt.loads(ball(h=0.0)).sensitivity(["ball.y"], ["h"], [0.0, 0.1])
    assert "bodies touch in rail at the start already" in s.message


def test_beyond_the_horizon_of_a_chaotic_motion_there_is_no_derivative():
    t = np.linspace(0.0, 0.024, 49)
    outputs = ["slider.x", "time(B.contacts, 2)", "max(B.force)"]
    s = rt.example("slider_crank_play").sensitivity(outputs, ["c"], t, rtol=1e-9)
    assert s.success
    known = t < s.trust.horizon
    assert 0.01 < s.trust.horizon < t[-1]
    assert np.isfinite(s["d(slider.x)/d(c)"][known]).all()
    assert np.isnan(s["d(slider.x)/d(c)"][~known]).all()
    assert np.isfinite(s["slider.x"]).all()
    assert np.isfinite(s["d(time(B.contacts, 2))/d(c)"]).all()
    assert any("beyond the horizon" in note for note in s.trust.notes)
    assert np.isnan(s["d(max(B.force))/d(c)"]).all()
    assert any("no derivative of max(B.force)" in note for note in s.trust.notes)


SLOTS = {"without ends": "", "with round ends": ", length = 0.05", "with open ends": ', length = 0.05, open = "both"'}


@pytest.mark.parametrize("ends", SLOTS)
@pytest.mark.parametrize("contact", ["impact", "hunt-crossley"])
def test_a_pin_in_a_slot_has_the_slopes_of_runs_beside_it(ends, contact):
    """It flies from wall to wall, along it, and where there are ends into them or out of the slot."""
    law = "stiffness = 1e8, exponent = 1.5, " if contact == "hunt-crossley" else "friction = 0.1, "
    m = rt.loads(f"""
format = 1
gravity = [0, -9.81]
parameters = {{ c = 1e-3, v = 0.3, e = 0.5, k = 5 }}
ground.points.O = [0, 0]
bodies.puck = {{ points = {{ P = [0, 0] }}, mass = 0.3, inertia = 1e-4 }}
[joints.S]
type = "slot"
connect = ["ground.O", "puck.P"]
axis = 0.1
clearance = "c"
contact = {{ model = "{contact}", {law}restitution = "e", bush_radius = 0.01 }}{SLOTS[ends].replace(", ", chr(10))}
[loads.spring]
type = "spring"
connect = ["ground.O", "puck.P"]
stiffness = "k"
free_length = 0.0
[initial.puck]
x = 0.01
y = 0.001
vx = "v"
vy = 0.0
angle = 0
omega = 3
""")
    t, of = np.linspace(0.0, 0.06, 5), ["puck.x", "puck.y"]
    for name in m.parameters:
        d, want = slopes(m, of, [name], t), differences(m, name, of, t, step=1e-4)
        for curve in of:
            assert d[curve, name] == pytest.approx(want[curve], abs=2e-4 * np.abs(want[curve]).max()), (curve, name)


def test_a_belt_with_its_pretension_is_shut_from_the_start_on():
    m, t = rt.example("belt_drive"), np.linspace(0.0, 0.1, 4)
    of = ["motor.omega", "wheel.omega", "energy.potential"]
    for name in ("T_0", "k", "J_1"):
        d, want = slopes(m, of, [name], t), differences(m, name, of, t, step=1e-4)
        for output in of:
            assert d[output, name] == pytest.approx(want[output], abs=1e-4 * np.abs(want[output]).max()), (output, name)


def test_what_is_not_defined_is_called_so():
    s = rt.loads(ball()).sensitivity(["ball.y", "time(rail.contacts, 9)"], ["h"], [0.0, 1.0])
    one, other = effects(s)
    assert one.effect.endswith(" mm")
    assert (other.effect, other.slope) == ("not defined", "not defined")


def test_contacts_begin_at_their_instants_whatever_the_model_steps_by():
    """The example takes equal steps, at whose ends its contacts begin."""
    m, of = rt.example("three_plays"), ["time(B.contacts, 1)", "speed(B.contacts, 1)"]
    assert m.model.settings.method == "moreau"
    s = m.sensitivity(of, ["l1"], [0.0, 0.0115], **FINE)
    assert s.success
    step = 1e-6 * m.parameters["l1"]
    near = [m.set(l1=m.parameters["l1"] + d).simulate(0.0118, method="event", **FINE) for d in (step, -step)]
    hits = [next(event for event in r.events if event.kind == "impact") for r in near]
    for kind, key in (("time", "t"), ("speed", "normal_speed")):
        wanted = (getattr(hits[0], key) - getattr(hits[1], key)) / (2 * step)
        assert s[f"d({kind}(B.contacts, 1))/d(l1)"][0] == pytest.approx(wanted, rel=1e-5)


def test_a_contact_whose_force_ends_just_where_its_gap_does_begins_again():
    """A spring without damping on both sides: each push of a stop ends at its place."""
    m = rt.loads(undamped())
    found = slopes(m, ["block.x"], ["M"], [0.0, 1.2])
    h = 1e-6
    off = np.diff(m.many({"M": [2.0 - h, 2.0 + h]}, ["final(block.x)"], t_end=1.2, **FINE)["final(block.x)"])
    assert found["block.x", "M"][-1] == pytest.approx(off[0] / (2 * h), rel=1e-6)
