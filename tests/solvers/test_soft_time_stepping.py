"""Moreau-Jean with compliant contacts and oil films beside impacts: first order, stable with any step."""

import math

import numpy as np
import pytest
from test_mixed_contacts import COLUMN, TIGHT

import rattle as rt
from rattle.errors import ModelError

VISCOSITY, RADIUS, LENGTH, C = 0.05, 0.01, 0.01, 5e-5
UNIT = VISCOSITY * RADIUS * LENGTH**3 / C**2  # of forces over speeds times the clearance [N s]
FAR = """
bodies.far = { points = { P = [0, 0] }, mass = 1, inertia = 1e-3 }
joints.apart = { type = "revolute", connect = ["ground.far", "far.P"], clearance = 1e-3, contact = "impact" }
"""


def oiled(mass, more="", e=(0.0, 0.0), v=(0.0, 0.0)):
    """A pin in oil, beside a rigid contact that has nothing to do with it."""
    sizes = f"viscosity = {VISCOSITY}, length = {LENGTH}, bush_radius = {RADIUS}"
    contact = f'{{ model = "lubricated", film = "short", {sizes} }}'
    return rt.loads(f"""
format = 1
ground.points = {{ O = [0, 0], far = [1, 0] }}
bodies.pin = {{ points = {{ P = [0, 0] }}, mass = {mass}, inertia = 1e-3 }}
joints.O = {{ type = "revolute", connect = ["ground.O", "pin.P"], clearance = {C}, contact = {contact} }}
{FAR}{more}
[initial]
pin = {{ x = {e[0]!r}, y = {e[1]!r}, angle = 0, vx = {v[0]!r}, vy = {v[1]!r} }}
far = {{ x = 1, y = 0, angle = 0, vx = 0.1, vy = 0, omega = 0 }}
""")


@pytest.mark.parametrize(("beta", "end"), [(1, 0.3582446567902), (10, 0.78791963969275), (100, 0.95086394240895)])
def test_oil_stops_a_pin_where_its_momentum_says_to_first_order(beta, end):
    """m v + mu R L^3/c^2 A(e) is constant: a free pin from the middle stops where A = 1 + beta."""
    v = beta * UNIT
    m, pace = oiled(1.0, v=(v, 0.0)), C / v
    error = []
    for parts in (64, 256):
        h = pace / parts
        r = m.simulate(40 * parts * h, t_eval=[0.0, 40 * parts * h], method="moreau", step=h)
        error.append(r["O.eccentricity"][-1] - end)
        assert r.trust.energy_balance < 1e-12 * 0.5 * v**2
    assert error[0] / error[1] == pytest.approx(4.0, abs=0.15)
    assert abs(error[1]) < 2e-3


def test_a_step_in_which_the_pin_would_leave_its_bush_only_loses_energy():
    v = 10 * UNIT
    h = C / v  # it would move from the middle to the wall
    r = oiled(1.0, v=(v, 0.0)).simulate(60 * h, t_eval=h * np.arange(61), method="moreau", step=h)
    kinetic = r["energy.kinetic"] + r["energy.potential"]
    assert r.success
    assert np.diff(kinetic).max() <= 1e-12 * kinetic[0]
    assert r["O.eccentricity"].max() < 1.05  # the dry contact bears what such a step has let through


@pytest.mark.parametrize(("critical", "growth"), [(5.0, -0.02208798539), (8.0, 0.01353683098)])
def test_a_light_rotor_whirls_from_its_threshold_on(critical, growth):
    """About the static position at e = 0.5 c, for m c w^2/W = 5 and 8: rates per radian of the shaft, linear theory."""
    w, turn = 150.0, math.radians(53.6802005999)
    load = 0.750381081812 * UNIT * w
    mass = critical * load / (C * w**2)
    e = 0.5 * C * np.array([math.cos(turn), math.sin(turn)])
    more = f"""
drivers.spin = {{ body = "pin", coordinate = "angle", angle = "{w}*t" }}
loads.push = {{ type = "force", at = "pin.P", force = [{load}, 0] }}
"""
    m = oiled(mass, more, e=(float(e[0] + 1e-3 * C), float(e[1])))
    h = 2 * math.pi / 2000 / w
    period = 2 * math.pi / (0.5 * w)
    r = m.simulate(8 * period, t_eval=np.linspace(0.0, 8 * period, 1601), method="moreau", step=h)
    away = np.hypot(r["O.ex"] - e[0], r["O.ey"] - e[1])
    inner = away[1:-1]
    tops = 1 + np.flatnonzero((inner > away[:-2]) & (inner >= away[2:]) & (r.t[1:-1] > period))  # of its ellipse
    seen = np.polyfit(w * r.t[tops], np.log(away[tops]), 1)[0]
    assert seen == pytest.approx(growth, abs=0.06 * abs(growth))  # its place is half a step old: whirl^2 h/2 at most


def test_a_column_of_pins_converges_to_its_events():
    times = np.linspace(0.0, 0.03, 31)
    m = rt.loads(COLUMN)
    exact = m.simulate(times[-1], t_eval=times, **TIGHT)
    error = []
    for h in (2e-5, 5e-6):
        r = m.simulate(times[-1], t_eval=times, method="moreau", step=h)
        error.append([abs(r[f"{body}.y"] - exact[f"{body}.y"]).max() for body in ("outer", "middle", "inner")])
    assert np.array(error[0]) / error[1] == pytest.approx([4.0] * 3, abs=0.3)
    assert max(error[1]) < 3e-5
    soft = [one for one in r.events if one.joint == "soft" and one.kind == "contact"]
    want = [one for one in exact.events if one.joint == "soft" and one.kind == "contact"]
    table, reference = (np.array([(one.t, *one[3:8]) for one in events])[:3] for events in (soft, want))
    assert table == pytest.approx(reference, rel=3e-2)
    before = m.simulate(0.02, t_eval=np.linspace(0.0, 0.02, 1001), method="moreau", step=2e-5)  # no impact yet
    assert before.trust.energy_balance < 1e-12


def fourbar():
    """A crank-rocker with a rigid, an elastic and an oiled pin."""
    sizes = 'clearance = "0.2 mm"\n'
    rubs = 'friction = { model = "coulomb-smooth", mu = 0.1, v1 = "1 mm/s" }, bush_radius = "10 mm"'
    pins = [
        f'{sizes}contact = {{ model = "impact", restitution = 0.3, friction = 0.1, bush_radius = "10 mm" }}',
        f'{sizes}contact = {{ model = "exact", restitution = 0.5, stiffness = 1e9, exponent = 1.5, {rubs} }}',
        'clearance = "50 um"\ncontact = { model = "lubricated", viscosity = "500 mPa*s", length = "20 mm", '
        'bush_radius = "10 mm", film = "short" }',
    ]
    bars = [("crank", "O1", "O2", 0.15), ("coupler", "O2", "O3", 0.45), ("rocker", "O3", "O4", 0.35)]
    bodies = "".join(f'[bodies.{n}]\nbar = ["{a}", "{b}"]\nlength = {x}\nmass = 1\n' for n, a, b, x in bars)
    ends = [("O2", "crank.O2", "coupler.O2"), ("O3", "coupler.O3", "rocker.O3"), ("O4", "ground.O4", "rocker.O4")]
    joints = "".join(
        f'[joints.{n}]\ntype = "revolute"\nconnect = ["{a}", "{b}"]\n{pin}\n'
        for (n, a, b), pin in zip(ends, pins, strict=True)
    )
    return rt.loads(f"""
format = 1
gravity = [0, -9.81]
[ground.points]
O1 = [0, 0]
O4 = [0.5, 0]
{bodies}{joints}
[joints.O1]
type = "revolute"
connect = ["ground.O1", "crank.O1"]
[drivers.motor]
joint = "O1"
angle = "20*t"
[initial]
coupler = {{ angle = "49.995 deg" }}
rocker = {{ angle = "-80.01 deg" }}
""")


def test_a_fourbar_with_a_pin_of_each_kind_converges_to_its_events():
    m, times = fourbar(), np.linspace(0.0, 0.02, 41)
    exact = m.simulate(0.02, t_eval=times, rtol=1e-9)
    assert exact.trust.impacts > 5
    assert exact.contacts["O3"].contacts > 0
    curves, error = ("rocker.angle", "O2.ex", "O3.ex", "O4.ex", "O4.ey"), []
    for h in (2e-5, 5e-6):
        r = m.simulate(0.02, t_eval=times, method="moreau", step=h)
        error.append([abs(r[name] - exact[name]).max() for name in curves])
    assert np.array(error[0]) / error[1] == pytest.approx([4.0] * len(curves), abs=0.7)
    assert r["energy.dissipated"][-1] == pytest.approx(exact["energy.dissipated"][-1], rel=2e-3)
    assert r.trust.energy_balance < 5e-5


@pytest.mark.parametrize(
    ("more", "place", "said"),
    [
        (
            'joints.way = { type = "clutch", connect = ["pin", "far"], model = "viscous", damping = 1 }',
            "joints.way.model",
            "no viscous or compliant clutches",
        ),
        (
            'bodies.slow = { points = { P = [0, 0] }, mass = 1, inertia = 1 }\njoints.soft = { type = "revolute", '
            'connect = ["ground.O", "slow.P"], clearance = 1e-3, contact = { model = "exact", restitution = 0.5, '
            'stiffness = 1e8, bush_radius = 0.01, friction = { model = "dahl", mu = 0.1, sigma = 1e5 } } }',
            "joints.soft.contact.friction",
            "no friction with states (dahl)",
        ),
    ],
)
def test_what_time_stepping_does_not_take_is_named(more, place, said):
    with pytest.raises(ModelError) as caught:
        oiled(1.0, more).simulate(1e-3, method="moreau")
    assert place in str(caught.value)
    assert said in str(caught.value)
    assert "use method event" in str(caught.value)
