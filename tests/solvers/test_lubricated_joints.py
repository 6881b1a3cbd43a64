"""Oil films in joints of mechanisms: closed forms, static positions, balances, other frames, the dry limit."""

import math

import numpy as np
import pytest

import rattle as rt
from rattle.results.film_summary import film_table

C, W = 5e-5, 150.0  # clearance [m], speed [rad/s]
LOAD = 30 * 0.750381081812  # [N], which a short film carries at half the clearance
DRY = '{ model = "hertz", stiffness = 5e8, exponent = 1, friction = { model = "coulomb-smooth", mu = 0.1, v1 = 1e-6 } }'


def oil(viscosity=0.05, length=0.01, film="short", **more):
    rest = "".join(f", {key} = {value}" for key, value in more.items())
    sizes = f"viscosity = {viscosity}, length = {length}, bush_radius = 0.01"
    return f'{{ model = "lubricated", film = "{film}", {sizes}{rest} }}'


def pin(contact, c=C, mass=1.0, load=(0.0, 0.0), speed=0.0, e=(0.0, 0.0), v=(0.0, 0.0)):
    """A pin that a motor turns in a bush of the ground, under a steady load."""
    return rt.loads(f"""
format = 1
ground.points = {{ O = [0, 0] }}
bodies.pin = {{ points = {{ P = [0, 0] }}, mass = {mass}, inertia = 1e-3 }}
joints.O = {{ type = "revolute", connect = ["ground.O", "pin.P"], clearance = {c}, contact = {contact} }}
drivers.spin = {{ body = "pin", coordinate = "angle", angle = "{speed}*t" }}
loads.push = {{ type = "force", at = "pin.P", force = {list(load)} }}
initial = {{ pin = {{ angle = 0, vx = {v[0]}, vy = {v[1]} }}, O = {{ offset = {list(e)} }} }}
""")


def two_bodies(contact, spin=0.0, c=C):
    """Bush and pin on free bodies away from their mass centres, with all rates raised by `spin` [rad/s] about O."""
    e, wa, wb = (0.3 * c, 0.55 * c), 40.0, -25.0
    a, b = (0.03, 0.01), (-0.02, 0.04)  # bush and pin on their bodies
    xb = (a[0] + e[0] - b[0], a[1] + e[1] - b[1])
    va = (0.1 - spin * 0.0, -0.2)
    point = (va[0] - wa * a[1] + 0.003, va[1] + wa * a[0] - 0.002)  # velocity of the pin's centre
    vb = (point[0] + wb * b[1] - spin * xb[1], point[1] - wb * b[0] + spin * xb[0])
    return rt.loads(f"""
format = 1
bodies.A = {{ points = {{ P = {list(a)} }}, center = [0, 0], mass = 2.0, inertia = 3e-3 }}
bodies.B = {{ points = {{ P = {list(b)} }}, center = [0, 0], mass = 0.7, inertia = 1e-3 }}
joints.J = {{ type = "revolute", connect = ["A.P", "B.P"], clearance = {c}, contact = {contact} }}
[initial]
A = {{ x = 0, y = 0, angle = 0, vx = {va[0]}, vy = {va[1]}, omega = {wa + spin} }}
B = {{ x = {xb[0]!r}, y = {xb[1]!r}, angle = 0, vx = {vb[0]!r}, vy = {vb[1]!r}, omega = {wb + spin} }}
""")


def squeezed(e):
    """A(e), the antiderivative of the squeeze force of a short film over mu R L^3/c^2."""
    return 1 / (1 - e**2) + e * (math.pi - np.arccos(e)) / (1 - e**2) ** 1.5


def test_oil_stops_a_pin_before_it_touches():
    """m v + mu R L^3/c^2 A(e) - W t is constant on a diameter."""
    k, times = 0.05 * 0.01**4 / 1e-8, np.linspace(0, 0.01, 101)
    r = pin(oil(), 1e-4, 0.2, v=(2.5, 0.0)).simulate(0.01, t_eval=times, rtol=1e-11, atol=1e-13)
    assert r["O.eccentricity"][-1] == pytest.approx(0.78791963969, abs=1e-9)
    assert 0.2 * r["pin.vx"] + k * squeezed(r["O.ex"] / 1e-4) == pytest.approx(np.full(101, 0.5 + k), rel=1e-9)
    assert not r.events
    assert np.ptp(r["O.normal"]) == 0.0
    r = pin(oil(), 1e-4, 0.2, (50.0, 0.0)).simulate(0.02, t_eval=2 * times, rtol=1e-11, atol=1e-13)
    assert 0.2 * r["pin.vx"] + k * squeezed(r["O.ex"] / 1e-4) - 50 * r.t == pytest.approx(np.full(101, k), rel=1e-8)


@pytest.mark.parametrize("law", ["short", "finite"])
def test_a_journal_that_is_let_go_finds_its_static_place(law):
    """Every column agrees with the calculator of bearings."""
    one = rt.Film(viscosity=0.05, length=0.01, radius=0.01, clearance=C, model=law)
    p = one.static(LOAD, W)
    m = pin(oil(film=law, roughness='["0.1 um", "0.2 um"]'), mass=20.0, load=(LOAD, 0.0), speed=W)
    r = m.simulate(0.4, t_eval=[0, 0.4], rtol=1e-10, atol=1e-14)
    last = {key: r[f"O.{key}"][-1] for key in ("eccentricity", "film_thickness", "film_pressure", "leakage")}
    assert last["eccentricity"] == pytest.approx(p.eccentricity, rel=1e-8)
    assert last["film_thickness"] == pytest.approx(p.film_thickness, rel=1e-8)
    assert last["film_pressure"] == pytest.approx(p.pressure, rel=1e-6)
    assert last["leakage"] == pytest.approx(p.leakage, rel=1e-6)
    assert r["O.sommerfeld"][-1] == pytest.approx(p.sommerfeld, rel=1e-6)
    assert -r["O.friction_torque"][-1] == pytest.approx(p.friction * LOAD * 0.01, rel=1e-6)
    assert r["O.friction_power"][-1] == pytest.approx(p.loss, rel=1e-6)
    assert r["spin.power"][-1] == pytest.approx(p.loss, rel=1e-6)
    assert (r["O.film_fx"][-1], r["O.film_fy"][-1]) == pytest.approx((-LOAD, 0.0), abs=1e-5 * LOAD)
    assert r["O.lambda_ratio"][-1] == pytest.approx(p.film_thickness / math.hypot(1e-7, 2e-7), rel=1e-8)
    assert (r["O.regime"][-1], r["O.normal"][-1]) == (0.0, 0.0)
    assert math.atan2(r["O.ey"][-1], r["O.ex"][-1]) == pytest.approx(p.attitude, rel=1e-7)


@pytest.mark.parametrize(("mass", "growth"), [(5, -0.0221456), (8, 0.0134828)])
def test_whirl_grows_beyond_the_threshold_and_dies_below(mass, growth):
    """Growth per radian of shaft as a nonlinear run of another program has it; eigenvalues -0.02209 and 0.01354."""
    att = math.atan2(math.pi * math.sqrt(0.75), 2.0)
    x, y = 0.5 * C * math.cos(att), 0.5 * C * math.sin(att)
    t = np.r_[0, np.linspace(100, 140, 801), np.linspace(300, 340, 801)] / W
    m = pin(oil(), mass=mass * LOAD / (C * W**2), load=(LOAD, 0.0), speed=W, e=(x + 1e-4 * C, y))
    r = m.simulate(340 / W, t_eval=t, rtol=1e-10, atol=1e-15)
    away = np.hypot(r["O.ex"] - x, r["O.ey"] - y)
    assert math.log(away[802:].max() / away[1:802].max()) / 200 == pytest.approx(growth, abs=2e-5)


def test_friction_over_speed_is_a_stribeck_curve():
    """Speed -> eccentricity, attitude [deg], share of the dry contact, friction; found with another program."""
    mixed = oil(boundary_film=1e-6, dry=DRY)
    for w, e, angle, share, friction in [
        (0.1, 0.99941351, -5.34101, 0.970676, 0.0970838),
        (3, 0.98513937, 5.28587, 0.256968, 0.0261765),
        (10, 0.96857033, 11.40351, 0, 0.000984),
        (1000, 0.70479037, 38.32822, 0, 0.0188064),
    ]:
        a = math.radians(angle)
        m = pin(mixed, mass=1e4, load=(500.0, 0.0), speed=w, e=(C * e * math.cos(a), C * e * math.sin(a)))
        r = m.simulate(1e-9, t_eval=[0, 1e-9])
        found = [r[name][0] / 500 for name in ("O.fx", "O.fy", "O.normal")]
        assert found == pytest.approx([-1, 0, share], abs=2e-6)
        # the dry friction acts on the radius of the pin, which is smaller than that of the bush by the clearance
        assert r["spin.torque"][0] / 5 == pytest.approx(friction - 0.1 * share * C / 0.01, abs=2e-6)
        assert r["O.regime"][0] == (1.0 if share else 0.0)


def test_a_run_across_the_boundary_film_has_no_jump_and_loses_at_every_instant():
    thick, forces = oil(boundary_film=0.05 * C, dry=DRY), []
    for e in (0.95 - 1e-12, 0.95 + 1e-12):
        r = pin(thick, speed=20.0, e=(e * C, 0.0), v=(1e-4, 2e-4)).simulate(1e-9, t_eval=[0, 1e-9])
        forces.append((r["O.fx"][0], r["O.fy"][0]))
    assert math.dist(*forces) < 1e-9 * math.hypot(*forces[0])
    m = pin(thick, mass=20.0, load=(500.0, -200.0), speed=100.0, v=(1.0, 0.2))
    r = m.simulate(0.03, t_eval=np.linspace(0, 0.03, 1001), rtol=1e-9, atol=1e-12)
    lost = r["energy.dissipated"]
    assert np.diff(lost).min() > -1e-12 * lost[-1]
    assert abs(r["energy.balance"]).max() < 1e-7 * lost[-1]
    assert set(r["O.regime"]) == {0.0, 1.0}


@pytest.mark.parametrize("law", ["short", "finite", "pinkus-sternlicht"])
def test_a_film_between_two_free_bodies_keeps_momentum_and_books_its_loss(law):
    m = two_bodies(oil(film=law, dry=DRY))
    # dop853: the integral of the losses, which no tolerance controls, is of order 8 then
    r = m.simulate(2e-3, t_eval=np.linspace(0, 2e-3, 2001), method="dop853", rtol=1e-10, atol=1e-14)
    spin = 0.0
    for body, mass, inertia in (("A", 2.0, 3e-3), ("B", 0.7, 1e-3)):
        x, y, vx, vy, w = (r[f"{body}.{key}"] for key in ("x", "y", "vx", "vy", "omega"))
        spin = spin + mass * (x * vy - y * vx) + inertia * w
    for key in ("vx", "vy"):
        total = 2.0 * r[f"A.{key}"] + 0.7 * r[f"B.{key}"]
        assert np.ptp(total) < 1e-11
    assert np.ptp(spin) < 1e-11 * np.abs(spin).max()
    lost = r["energy.dissipated"][-1]
    assert np.trapezoid(r["J.friction_power"], r.t) == pytest.approx(lost, rel=1e-3)
    assert abs(r["energy.balance"]).max() < 1e-8 * lost
    assert r.power().residual < 1e-7 * r["J.friction_power"].max()


def test_forces_are_the_same_seen_from_a_turning_frame():
    for contact in (oil(dry=DRY), oil(film="finite", dry=DRY)):
        at_rest, turning = (two_bodies(contact, spin).simulate(1e-9, t_eval=[0, 1e-9]) for spin in (0.0, 370.0))
        for name in ("J.fx", "J.fy", "J.friction_torque", "J.friction_power", "J.film_pressure", "J.leakage"):
            assert turning[name][0] == pytest.approx(at_rest[name][0], rel=1e-7), name


def test_without_viscosity_the_dry_contact_is_left():
    """It begins at the boundary film, so the dry joint has that much less clearance."""
    least, run = (
        0.1 * C,
        {"t_end": 5e-3, "t_eval": np.linspace(0, 5e-3, 101), "rtol": 1e-10, "atol": 1e-14, "method": "dop853"},
    )
    state = {"load": (500.0, -200.0), "speed": 100.0, "v": (0.1, 0.02)}
    thin = pin(oil(1e-16, boundary_film=least, dry=DRY), **state).simulate(**run)
    dry = pin(DRY.replace("{", f"{{ bush_radius = {0.01 - 0.5 * least},", 1), C - least, **state).simulate(**run)
    assert dry["O.normal"].max() > 500.0
    for name in ("O.normal", "O.tangential", "O.ex", "O.ey", "spin.torque"):
        assert thin[name] == pytest.approx(dry[name], abs=1e-6 * np.abs(dry[name]).max()), name
    assert len(thin.events) == len(dry.events)
    assert thin["O.regime"].max() == 2.0


SLIDER_CRANK = """
format = 1
ground.points = { O = [0, 0] }
bodies.crank = { points = { O = [0, 0], A = [0.05, 0] }, center = [0, 0], mass = 0.3, inertia = 1e-4 }
bodies.rod = { bar = ["A", "B"], length = 0.12, mass = 0.21, inertia = 2.5e-4 }
bodies.slider = { points = { B = [0, 0] }, mass = 0.14, inertia = 1e-4 }
joints.O = { type = "revolute", connect = ["ground.O", "crank.O"] }
joints.A = { type = "revolute", connect = ["crank.A", "rod.A"] }
joints.B = { type = "revolute", connect = ["rod.B", "slider.B"], clearance = 2e-4, contact = CONTACT }
joints.guide = { type = "prismatic", connect = ["ground.O", "slider.B"], axis = 0 }
drivers.motor = { joint = "O", angle = "5000 rpm*t" }
initial = { rod = { angle = 0 }, slider = { angle = 0 }, B = { offset = [0, 0] } }
"""


def test_a_lubricated_slider_crank_runs_as_an_independent_program_has_it():
    """5000 rpm, L 20 mm, c 0.2 mm, 0.4 Pa s: e/c, force on the pin and torque, by Radau of SciPy (rtol 1e-11)."""
    m = rt.loads(SLIDER_CRANK.replace("CONTACT", oil(0.4, 0.02)))
    r = m.simulate(0.012, t_eval=np.linspace(0, 0.012, 361), rtol=1e-10, atol=1e-13)
    for degrees, ex, ey, fx, fy, torque in [
        (30, 0.581238453, -0.162915969, -2105.35855, 1000.67312, 135.2526947),
        (90, 0.138555086, -0.329518158, 884.263663, -112.247160, -76.8178709),
        (180, -0.668179507, 0.014122927, 1119.408641, -1.0526468, 0.0225881),
        (270, -0.753453806, -0.193553655, 881.758450, 126.217677, 77.1575615),
    ]:
        # m: 1e-7 of the clearance, as 25 m/s of the slider at rtol allow
        assert (r["B.ex"][degrees], r["B.ey"][degrees]) == pytest.approx((ex * 2e-4, ey * 2e-4), abs=2e-11)
        assert (r["B.fx"][degrees], r["B.fy"][degrees]) == pytest.approx((fx, fy), abs=1e-3)
        assert r["motor.torque"][degrees] == pytest.approx(torque, abs=1e-4)
    assert abs(r["energy.balance"]).max() < 1e-7 * r["energy.kinetic"].max()  # integrals of losses and work: order 5
    assert not r.events
    assert r.power().residual < 1e-9 * np.abs(r["motor.power"]).max()


def test_the_summary_of_a_run_says_how_thin_the_film_gets_and_what_it_costs():
    m = rt.loads(SLIDER_CRANK.replace("CONTACT", oil(0.4, 0.02)))
    fine, coarse = (m.simulate(0.012, t_eval=np.linspace(0, 0.012, n), rtol=1e-8) for n in (1201, 61))
    for r, rel in ((fine, 1e-3), (coarse, 0.1)):
        one = r.films["B"]
        assert one.least_film == pytest.approx(fine["B.film_thickness"].min(), rel=1e-4)  # from within the steps
        assert one.at_angle == pytest.approx(2 * math.pi * one.at_t / 0.012, rel=1e-6)
        assert one.peak_pressure == pytest.approx(fine["B.film_pressure"].max(), rel=rel)
        assert one.mean_power == pytest.approx(fine["energy.dissipated"][-1] / 0.012, rel=rel)
        assert one.heating == pytest.approx(one.mean_power / (870 * 2000 * one.leakage), rel=1e-12)
        assert one.mixed == 0.0
    assert f"{1e6 * fine.films['B'].least_film:.4g} um" in film_table(fine)
    assert film_table(rt.example("slider_crank_play").simulate(1e-6)) == ""


def test_a_least_film_before_the_first_output_is_at_no_known_angle():
    m = rt.loads(SLIDER_CRANK.replace("CONTACT", oil(0.4, 0.02)))
    one = m.simulate(0.006, t_eval=np.linspace(0.0055, 0.006, 3)).films["B"]
    assert one.at_t < 0.0055
    assert math.isnan(one.at_angle)


def test_the_summary_has_a_crank_at_rest_at_zero_degrees():
    """Its angle may be 0 less rounding, which is no turn of 360 degrees."""
    m = rt.loads(SLIDER_CRANK.replace("CONTACT", oil(0.4, 0.02))).set({"drivers.motor.angle": "-1e-6*t"})
    assert m.simulate(1e-6, t_eval=[0.0, 1e-6]).films["B"].at_angle == 0.0


def test_a_run_notes_what_the_film_leaves_out():
    for contact, speed, said in [
        (oil(0.05, 0.01), 100.0, "a short film is too strong"),
        (oil(1e-4, film="finite"), 3000.0, "not laminar"),
        (oil(2e-3, film="finite"), 2000.0, "inertia of the oil"),
        (oil(0.05, film="finite", boundary_film=0.4 * C), 10.0, "thinner than its boundary film"),
    ]:
        r = pin(contact, mass=20.0, speed=speed, e=(0.8 * C, 0.0)).simulate(1e-6, t_eval=[0, 1e-6])
        assert said in str(r.trust), said
        assert "no dry contact given" in str(r.trust)
