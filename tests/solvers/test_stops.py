"""Stops: ends of the coordinate of a joint, as contacts besides its rows."""

import math
import re

import numpy as np
import pytest
from scipy.special import beta, ellipkinc

import rattle as rt
from rattle.errors import AssemblyError, ModelError

FINE = {"rtol": 1e-11, "atol": 1e-13}


def rod(stop, g=9.81, start="angle = 0, omega = 0", more=""):
    """Uniform rod, 1 m, 1 kg, on a hinge with a stop; angle 0 is level."""
    return rt.loads(f"""
format = 1
gravity = [0, {-g}]
[ground.points]
O = [0, 0]
[bodies.rod]
bar = ["O", "E"]
length = 1
mass = 1
[joints.hinge]
type = "revolute"
connect = ["ground.O", "rod.O"]
stop = {stop}
{more}
[initial]
rod = {{ {start} }}
""")


def block(stop, start="x = 0.5, vx = 1", g=0.0, kind="prismatic"):
    """A block of 2 kg on a level line."""
    return rt.loads(f"""
format = 1
gravity = [{g}, 0]
[ground.points]
O = [0, 0]
[bodies.block]
points = {{ C = [0, 0] }}
mass = 2
inertia = 1
[joints.guide]
type = "{kind}"
connect = ["ground.O", "block.C"]
stop = {stop}
[initial]
block = {{ {start} }}
""")


def of_kind(r, kind):
    return [one for one in r.events if one.kind == kind]


def impact(e, ends):
    return f'{{ {ends}, contact = {{ model = "impact", restitution = {e} }} }}'


# ---------------------------------------------------------------- closed forms
def test_rod_bounces_off_its_stop_as_the_elliptic_integrals_say():
    """With 1 - cos a = e^2n of the swing a after n impacts, and the half period 2 sqrt(2 L/(3 g)) K(a) of a rod."""
    e, g = 0.5, 9.81
    r = rod(impact(e, 'min = "-90 deg", max = "180 deg"')).simulate(3.5, t_eval=[0, 3.5], **FINE)
    swings = [math.acos(1.0 - e ** (2 * n)) for n in range(4)]
    quarter = [math.sqrt(2 / (3 * g)) * ellipkinc(math.pi / 2, math.sin(a / 2) ** 2) for a in swings]
    times = np.cumsum([quarter[0], *(2 * one for one in quarter[1:])])
    hits = of_kind(r, "impact")
    assert [one.t for one in hits] == pytest.approx(times, abs=2e-12)
    assert [one.normal_speed for one in hits] == pytest.approx(math.sqrt(3 * g) * e ** np.arange(4), rel=1e-10)
    # the moment is about the pin, the impulse J w (1 + e) of it in N m s
    assert [one.impulse for one in hits] == pytest.approx([(1 + e) * one.normal_speed / 3 for one in hits], rel=1e-10)
    assert sum(one.energy_lost for one in hits) == pytest.approx(g / 2 * (1 - e**8), rel=1e-10)
    assert r.trust.energy_balance < 1e-10
    assert r.unit("hinge.stop") == "N*m"


def test_block_between_two_stops_slows_down_by_e_at_each():
    r = block(impact(0.5, "min = 0, max = 1")).simulate(10.0, t_eval=[0, 10], **FINE)
    assert [one.t for one in of_kind(r, "impact")] == pytest.approx([0.5, 2.5, 6.5], abs=1e-12)
    assert r["block.vx"][-1] == pytest.approx(-0.125, abs=1e-12)


@pytest.mark.parametrize("kind", ["prismatic", "slot"])
def test_block_goes_into_an_elastic_stop_and_back_as_a_spring_says(kind):
    law = 'contact = { model = "hertz", stiffness = "20 kN/m", exponent = 1 }'
    r = block(f"{{ min = -1, max = 1, {law} }}", kind=kind).simulate(0.6, t_eval=[0, 0.505, 0.6], **FINE)
    assert r["block.x"][1:] == pytest.approx([1 + 0.01 * math.sin(0.5), 1 - (0.1 - 0.01 * math.pi)], abs=1e-12)
    (one,) = of_kind(r, "contact")
    assert (one.peak_force, one.duration) == pytest.approx((200.0, 0.01 * math.pi), rel=1e-9)
    assert r["guide.stop"][1] == pytest.approx(-200 * math.sin(0.5), rel=1e-10)  # pushes B back
    assert r["guide.fx"][1] == pytest.approx(r["guide.stop"][1], rel=1e-14)


def test_rod_turns_an_elastic_stop_in_newton_metres_per_radian():
    """Without gravity: w = sqrt(k/J), J = 1/3; and a hinge counts its turns."""
    k, w0, least = 3e4, 2.0, -4.5 * math.pi
    law = f'contact = {{ model = "hertz", stiffness = "{k} N*m/rad", exponent = 1 }}'
    stop = f"{{ min = {least}, {law} }}"
    w, hit = math.sqrt(3 * k), 4.5 * math.pi / w0
    t = [0, hit - 1e-3, hit + 0.25 * math.pi / w, hit + math.pi / w + 0.5]
    r = rod(stop, g=0.0, start=f"angle = 0, omega = {-w0}").simulate(t[-1], t_eval=t, **FINE)
    want = [-w0 * t[1], least - w0 / w * math.sin(0.25 * math.pi), least + w0 * 0.5]
    assert r["rod.angle"][1:] == pytest.approx(want, abs=1e-10)
    assert r["hinge.stop"][2] == pytest.approx(k * w0 / w * math.sin(0.25 * math.pi), rel=1e-8)  # turns B on
    assert r["hinge.moment"][2] == pytest.approx(r["hinge.stop"][2], rel=1e-12)
    assert r.peak("hinge.stop")[0] == pytest.approx(k * w0 / w, rel=1e-8)


def test_damped_stop_returns_the_speed_of_its_law():
    law = 'contact = { model = "exact", restitution = 0.6, stiffness = 1e5, exponent = 1.5 }'
    r = rod(f"{{ min = 0, max = 1, {law} }}", g=0.0, start="angle = 0.5, omega = 3").simulate(0.5, **FINE)
    assert r["rod.omega"][-1] == pytest.approx(-1.8, rel=1e-6)
    (one,) = of_kind(r, "contact")
    assert one.energy_lost == pytest.approx(0.5 / 3 * (9 - 1.8**2), rel=1e-6)


def test_a_linear_stop_with_damping_reckons_with_the_inertia_about_the_hinge():
    """Kelvin-Voigt, w'' + 2 zeta w0 w' + w0^2 w = 0 with J = 1/3: it leaves where its force vanishes."""
    law = 'contact = { model = "kelvin-voigt", restitution = 0.5, stiffness = 1e4, exponent = 1 }'
    r = rod(f"{{ min = 0, {law} }}", g=0.0, start="angle = 0.5, omega = -2").simulate(0.5, t_eval=[0, 0.5], **FINE)
    zeta = -math.log(0.5) / math.hypot(math.pi, math.log(0.5))
    left = math.exp(-2 * zeta * math.acos(zeta) / math.sqrt(1 - zeta**2))
    assert r["rod.omega"][-1] == pytest.approx(2 * left, rel=1e-8)


def test_a_driver_that_pushes_through_a_stop_is_named():
    """A driver goes on to the stop, and there the run ends with the reason; a compliant stop gives way."""
    drive = '[drivers.motor]\njoint = "hinge"\nangle = "-2*t"\n'
    r = rod(impact(0.5, 'min = "-90 deg"'), more=drive).simulate(1.0)
    assert not r.success
    assert "drivers push 'hinge' on at t = 0.785398163 s where a stop or wall is" in r.message
    soft = '{ min = "-90 deg", contact = { model = "hertz", stiffness = 100, exponent = 1 } }'
    r = rod(soft, g=0.0, more=drive).simulate(1.0, t_eval=[0, 1.0], **FINE)
    assert r["motor.torque"][-1] == pytest.approx(-100 * (2 - math.pi / 2), rel=1e-9)


def test_a_count_of_impacts_at_a_stop_is_an_output():
    m = rt.loads(rod(impact(0.5, 'min = "-90 deg"')).to_toml() + "[parameters]\nw = 0\n").set(
        {"initial.rod.omega": "w"}
    )
    found = m.many({"w": np.array([0.0, -1.0])}, t_end=1.4, outputs=["count(hinge.impacts)"])
    assert found["count(hinge.impacts)"] == pytest.approx([2, 2])
    assert not len(found.generic)


def test_many_bounces_end_and_the_rod_rests_on_its_stop():
    """Pushed by a constant moment M against the stop, without gravity: the series of bounces ends at a known time."""
    moment, e, w0 = 2.0, 0.4, 3.0
    push = f'[loads.push]\ntype = "torque"\nbody = "rod"\ntorque = {-moment}\n'
    m = rod(impact(e, "min = 0"), g=0.0, start=f"angle = 0, omega = {w0}", more=push)
    r = m.simulate(3.0, t_eval=[0, 2.9, 3.0], **FINE)
    alpha = 3 * moment
    (lasting,) = of_kind(r, "contact")
    assert lasting.t == pytest.approx(2 * w0 / alpha / (1 - e), abs=1e-6)  # all flights together
    assert r["rod.angle"][1:] == pytest.approx([0, 0], abs=1e-14)
    assert r["hinge.stop"][1:] == pytest.approx([moment, moment], rel=1e-12)
    assert sum(one.energy_lost for one in of_kind(r, "impact")) == pytest.approx(w0**2 / 6, rel=1e-9)


# ---------------------------------------------------------------- a chain against a stop
CHAIN = """
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.upper]
bar = ["O", "P"]
length = 0.7
mass = 1.3
[bodies.lower]
bar = ["P", "E"]
length = 0.4
mass = 0.6
[joints.hip]
type = "revolute"
connect = ["ground.O", "upper.O"]
[joints.knee]
type = "revolute"
connect = ["upper.P", "lower.P"]
stop = { min = "-100 deg", max = "5 deg", contact = { model = "impact", restitution = 0.3 } }
[initial]
upper = { angle = "-70 deg", omega = 1 }
lower = { angle = "-110 deg", omega = 2 }
"""


def test_impulse_in_a_chain_is_that_of_momentum_with_constraints():
    """A knee in free flight of its leg, bent to its stop: M dv = Phi_q^T L + w P, w dv = -(1 + e) w v, in NumPy."""
    m = rt.loads(CHAIN)
    r = m.simulate(1.0, **FINE)
    one = of_kind(r, "impact")[0]
    assert one.joint == "knee"
    state = m.simulate(one.t + 1e-9, t_eval=[one.t - 1e-9, one.t + 1e-9], **FINE)

    def values(keys, k):
        return np.array([state[f"{body}.{key}"][k] for body in ("upper", "lower") for key in keys])

    q, rates = values(("x", "y", "angle"), 0), ("vx", "vy", "omega")
    v, after = values(rates, 0), values(rates, 1)
    mass = np.diag([1.3, 1.3, 1.3 * 0.49 / 12, 0.6, 0.6, 0.6 * 0.16 / 12])

    def arm(angle, length):
        return length * np.cos(angle), length * np.sin(angle)

    (cx, cy), (dx, dy) = arm(q[2], 0.35), arm(q[5], 0.2)
    rows = np.array([[1, 0, cy, 0, 0, 0], [0, 1, -cx, 0, 0, 0], [1, 0, -cy, -1, 0, -dy], [0, 1, cx, 0, -1, dx]])
    w = np.array([0, 0, -1.0, 0, 0, 1.0])  # rate of the knee
    size = np.zeros((11, 11))
    size[:6, :6] = mass
    size[:6, 6:10], size[6:10, :6] = rows.T, rows
    size[:6, 10], size[10, :6] = w, w
    solution = np.linalg.solve(size, [*np.zeros(10), -1.3 * (w @ v)])
    np.testing.assert_allclose(np.subtract(after, v), solution[:6], atol=1e-6)  # 2 ns of motion lie between
    assert one.impulse == pytest.approx(abs(solution[10]), rel=1e-6)
    assert one.normal_speed == pytest.approx(abs(w @ v), rel=1e-6)


def test_moreau_jean_converges_to_the_events():
    m = rt.loads(CHAIN)
    exact = m.simulate(0.6, t_eval=[0, 0.6], **FINE)
    assert len(of_kind(exact, "impact")) >= 1
    errors = []
    for step in (4e-4, 1e-4, 2.5e-5):
        r = m.simulate(0.6, t_eval=[0, 0.6], method="moreau", step=step)
        errors.append(abs(r["lower.angle"][-1] - exact["lower.angle"][-1]))
    assert errors[1] < 0.45 * errors[0]
    assert errors[2] < 0.45 * errors[1]
    assert errors[2] < 1e-3


def test_stop_and_play_act_together():
    """A hinge with play, whose pin touches its bush, and its stop: momentum and moment are those of rigid bodies."""
    contact = '{ model = "impact", restitution = 0.2 }'
    play = f'clearance = "0.5 mm"\ncontact = {contact}'
    r = rod(impact(0.5, 'min = "-90 deg"'), more=play).simulate(1.0, **FINE)
    ideal = rod(impact(0.5, 'min = "-90 deg"')).simulate(1.0, **FINE)
    hits = [one for one in of_kind(r, "impact") if abs(one.t - of_kind(ideal, "impact")[0].t) < 0.01]
    assert len({one.t for one in hits}) >= 1
    assert r.trust.energy_balance < 1e-8
    assert r["rod.angle"].min() > -math.pi / 2 - 1e-9


# ---------------------------------------------------------------- bad input
@pytest.mark.parametrize(
    ("stop", "said"),
    [
        ("{ min = 1, max = 0 }", "min = 1 rad must be less than max = 0 rad"),
        ('{ contact = "impact" }', "needs an end"),
        ('{ min = 0, contact = "massless-link" }', "'massless-link' does not work on a stop"),
        ('{ min = 0, contact = { model = "impact", friction = 0.1 } }', "a stop has no friction"),
        (
            '{ min = 0, contact = { model = "hertz", stiffness = "1 N/m", exponent = 1 } }',
            "is a stiffness; expected a moment or energy in N.m/rad",
        ),
        ('{ min = "1 mm" }', "is a length; expected a plain number or angle in rad"),
        ("{ least = 0 }", "unknown key"),
    ],
)
def test_what_a_stop_cannot_be_is_said(stop, said):
    with pytest.raises(ModelError, match=said):
        rod(stop)


def test_a_joint_without_a_coordinate_has_no_stop():
    with pytest.raises(ModelError, match=r"a fixed joint has no coordinate .*expected .*prismatic.* or "):
        block("{ min = 0 }", kind="fixed")


@pytest.mark.parametrize(
    ("start", "said"),
    [
        ("angle = 0.2", r"'hinge' starts at 11.4592 deg, beyond max = 5.72958 deg of its stop"),
        (f"angle = {-2 * math.pi + 0.05}", "angles are continuous: start 1 turn away"),
    ],
)
def test_a_start_beyond_a_stop_is_refused(start, said):
    with pytest.raises(AssemblyError, match=re.escape(said) if "'" in said else said):
        rod(impact(0.5, "min = 0, max = 0.1"), start=start).simulate(0.1)


def test_elastic_stop_of_a_joint_with_an_impact_pin_holds_a_rod_without_sinking_pin():
    """The rod comes to rest on its stop, which turns it with m g l/2 = k angle; the pin bears the weight alone."""
    law = '{ min = 0, contact = { model = "kelvin-voigt", stiffness = 1e3, exponent = 1, restitution = 0.05 } }'
    more = 'clearance = "1 mm"\ncontact = { model = "impact", restitution = 0, friction = 0.3, bush_radius = "10 mm" }'
    r = rod(law, start="angle = 1e-2", more=more).simulate(3.0, t_eval=[0.0, 3.0], rtol=1e-9)
    assert r.success
    assert {(one.joint, one.kind) for one in r.events} >= {("hinge", "impact"), ("hinge", "contact")}
    assert [r["hinge.fx"][-1], r["hinge.fy"][-1]] == pytest.approx([0.0, 9.81], abs=1e-6)
    assert abs(r["hinge.stop"][-1]) == pytest.approx(9.81 * 0.5, abs=0.3 * 9.81 * 0.01)  # the pin may hold by friction
    assert -r["rod.angle"][-1] == pytest.approx(abs(r["hinge.stop"][-1]) / 1e3, rel=1e-6)
    assert abs(r["energy.balance"]).max() < 1e-7


@pytest.mark.parametrize(("n", "off"), [(1.0, 3e-9), (1.5, 2e-7)])
def test_a_block_knocks_to_and_fro_between_springs_at_the_instants_of_the_closed_form(n, off):
    K, m, before, way, rtol = 2e5, 2.0, 0.12, 0.27, 1e-9
    spring = f'{{ model = "hertz", stiffness = {K}, exponent = {n}, damping = 0 }}'
    text = block(f"{{ min = -0.15, max = {before}, contact = {spring} }}", "x = 0, vx = 1").to_toml()
    there_and_back = 2.0 / (n + 1.0) * beta(1.0 / (n + 1.0), 0.5)
    for v in np.linspace(0.3, 2.0, 40):
        r = rt.loads(text.replace("vx = 1", f"vx = {v}")).simulate(1.0, rtol=rtol, atol=1e-3 * rtol)
        deep = (0.5 * (n + 1.0) * m * v**2 / K) ** (1.0 / (n + 1.0))
        started = np.array([one.t for one in of_kind(r, "contact")])
        own = before / v + np.arange(len(started)) * (way / v + there_and_back * deep / v)
        np.testing.assert_allclose(started, own, rtol=0, atol=off)
