"""Pins that float in oil at rest: static positions in closed form and of another program, vibrations, oil whirl."""

import json
import math

import numpy as np
import pytest
from click.testing import CliRunner

import rattle as rt
from oil_films import film
from rattle.cli.main import main

C, W = 5e-5, 150.0
UNIT = 0.05 * W * 0.01**4 / C**2  # mu w R L^3/c^2 [N]
DRY = '{ model = "hertz", stiffness = 5e8, exponent = 1, friction = { model = "coulomb-smooth", mu = 0.1, v1 = 1e-6 } }'


def oil(law="short", viscosity=0.05, length=0.01, **more):
    rest = "".join(f", {key} = {value}" for key, value in more.items())
    sizes = f"viscosity = {viscosity}, length = {length}, bush_radius = 0.01"
    return f'{{ model = "lubricated", film = "{law}", {sizes}{rest} }}'


def rotor(load, speed=W, mass=1.0, contact=None, angle=None, bush="ground.O", more=""):
    """A pin turned by a driver in a bush, under a load along x."""
    return rt.loads(f"""
format = 1
ground.points = {{ O = [0, 0] }}
bodies.pin = {{ points = {{ P = [0, 0] }}, mass = {mass}, inertia = 1e-3 }}
joints.O = {{ type = "revolute", connect = ["{bush}", "pin.P"], clearance = {C}, contact = {contact or oil()} }}
drivers.spin = {{ body = "pin", coordinate = "angle", angle = "{angle or f"{speed}*t"}" }}
loads.push = {{ type = "force", at = "pin.P", force = ["{load}", 0] }}
{more}
""")


def static_short(e):
    """Load over mu w R L^3/c^2 and attitude [rad] of a short film at an eccentricity."""
    root = math.sqrt(math.pi**2 * (1 - e**2) + 16 * e**2)
    return e * root / (4 * (1 - e**2) ** 2), math.atan2(math.pi * math.sqrt(1 - e**2), 4 * e)


def test_a_journal_floats_where_the_closed_form_has_it():
    for e in (0.05, 0.3, 0.6, 0.9, 0.95):
        load, attitude = static_short(e)
        found = rotor(load * UNIT).equilibrium()
        assert len(found) == 1
        one = found[0]
        assert one["O.eccentricity"] == pytest.approx(e, abs=1e-11)
        assert math.atan2(one["O.ey"], one["O.ex"]) == pytest.approx(attitude, abs=1e-11)
        assert one.stable
        assert (one["O.regime"], one["O.normal"]) == (0.0, 0.0)


@pytest.mark.parametrize("law", ["short", "finite", "pinkus-sternlicht"])
def test_what_a_floating_pin_shows_is_what_the_calculator_of_bearings_says(law):
    """Also if the bush turns in place of the pin, or the pin turns backwards, or the speed rises."""
    p = film(law).static(100.0, W)
    ring = "bodies.ring = { points = { P = [0, 0] }, mass = 1, inertia = 1e-3 }\n"
    ring += 'joints.R = { type = "revolute", connect = ["ground.O", "ring.P"] }\n'
    turns = f'drivers.turn = {{ body = "ring", coordinate = "angle", angle = "{W}*t" }}\n'
    for m, sense, t in [
        (rotor(100.0, contact=oil(law)), 1, 0.0),
        (rotor(100.0, -W, contact=oil(law)), -1, 0.0),
        (rotor(100.0, 0.0, contact=oil(law), bush="ring.P", more=ring + turns), 1, 0.0),
        (rotor(100.0, angle=f"10*{W}*t**2", contact=oil(law)), 1, 0.05),
    ]:
        one = m.equilibrium(t)[0]
        assert one["O.eccentricity"] == pytest.approx(p.eccentricity, abs=1e-10)
        assert math.atan2(one["O.ey"], one["O.ex"]) == pytest.approx(sense * p.attitude, abs=1e-9)
        assert one["O.film_pressure"] == pytest.approx(p.pressure, rel=1e-8)
        assert one["O.leakage"] == pytest.approx(p.leakage, rel=1e-8, nan_ok=True)
        assert one["O.sommerfeld"] == pytest.approx(p.sommerfeld, rel=1e-8)
        assert one["O.friction_power"] == pytest.approx(p.loss, rel=1e-8)
    one = rotor(100.0, contact=oil(law)).equilibrium()[0]
    assert one["spin.torque"] == pytest.approx(p.friction * 100.0 * 0.01, rel=1e-8)
    assert f"floats on {1e6 * p.film_thickness:.4g} um of oil" in str(one)


def test_film_and_dry_contact_share_the_load_as_on_the_curve_of_stribeck():
    """Speed -> eccentricity, attitude [deg], share of the dry contact, friction; found with another program."""
    mixed = oil(boundary_film=1e-6, dry=DRY)
    for speed, e, degrees, share, friction in [
        (0.1, 0.99941351, -5.34101, 0.970676, 0.0970838),
        (1.0, 0.99501291, -2.02852, 0.750645, 0.0752264),
        (3.0, 0.98513937, 5.28587, 0.256968, 0.0261765),
        (10.0, 0.96857033, 11.40351, 0, 0.000984),
        (1000.0, 0.70479037, 38.32822, 0, 0.0188064),
    ]:
        one = rotor(500.0, speed, contact=mixed).equilibrium()[0]
        assert one["O.eccentricity"] == pytest.approx(e, abs=1e-8)
        assert math.degrees(math.atan2(one["O.ey"], one["O.ex"])) == pytest.approx(degrees, abs=1e-5)
        assert one["O.normal"] / 500 == pytest.approx(share, abs=1e-6)
        # the dry friction acts on the radius of the pin, which is smaller than that of the bush by the clearance
        assert one["spin.torque"] / 5 == pytest.approx(friction - 0.1 * share * C / 0.01, abs=2e-6)
    one = rotor(500.0, 0.0, contact=mixed).equilibrium()[0]  # nothing turns: the dry contact carries all
    assert (one["O.ex"], one["O.normal"]) == pytest.approx((C - 1e-6 + 500 / 5e8, 500.0), rel=1e-9)
    assert "presses with 500 N" in str(one)
    assert rotor(0.0).equilibrium()[0]["O.eccentricity"] == 0.0


@pytest.mark.parametrize(("mass", "root"), [(5, -0.02208798539 + 0.5665807232j), (8, 0.01353683098 + 0.4733729960j)])
def test_modes_of_a_journal_are_those_of_another_program(mass, root):
    """In units of the speed, at half the clearance; beyond the threshold the mode is named as whirl."""
    load = static_short(0.5)[0] * UNIT
    found = rotor(load, mass=mass * load / (C * W**2)).modes()
    assert found.roots[0, 0] / W == pytest.approx(root, abs=2e-9)
    if root.real > 0.0:
        assert found.whirl[0].joint == "O"
        assert found.whirl[0].ratio == pytest.approx(root.imag, abs=2e-9)
        assert found.whirl[1] is None
        assert "oil whirl of O" in str(found)
        assert "0.473373 of the turning speed" in str(found)
        assert "unstable by oil whirl" in found.about
    else:
        assert found.whirl == (None, None)
        assert "whirl" not in str(found) + found.about


def test_an_equilibrium_of_a_floating_pin_claims_no_more_than_statics():
    """It may whirl; if all modes die away it is stable, and where surfaces are indented no film has a thickness."""
    load = static_short(0.5)[0] * UNIT
    whirls, rests = (rotor(load, mass=mass * load / (C * W**2)) for mass in (8, 5))
    for m in (whirls, rests):
        assert str(m.equilibrium()[0]).startswith("stable statically (whether oil makes it whirl, its modes say), ")
    assert whirls.modes().about.startswith("stable statically, unstable by oil whirl")
    assert rests.modes().about.startswith("stable, ")
    indented = rotor(500.0, speed=0.1, contact=oil("finite")).equilibrium()[0]
    assert indented["O.film_thickness"] < 0.0 < indented["O.normal"] < 499.0
    assert "um of oil" not in str(indented)
    assert "O is carried by oil between asperities (e/c 1." in str(indented)


def test_a_film_that_pulls_too_leaves_no_direction_free():
    """Stiffness of a full film is only that across: its eigenvalues are imaginary, and every mass whirls."""
    m = rotor(50.0, contact=oil(cavitation='"full"'))
    one, found = m.equilibrium()[0], m.modes()
    assert (one.eigenvalue, one.neutral, one.stable) == (0.0, 0, False)
    assert str(one).startswith("held only across its displacements, stiffness 0 N/m, O floats on ")
    assert found.about.startswith("unstable by oil whirl, ")
    assert found.whirl[0].joint == "O"


def test_the_threshold_of_whirl_is_where_theory_has_it():
    """The least mass that whirls, and the eccentricity from which none does."""
    for e, critical in [(0.1, 7.514608561), (0.45, 6.410664672), (0.7, 13.16109701)]:
        load = static_short(e)[0] * UNIT
        grows = [
            rotor(load, mass=critical * share * load / (C * W**2)).modes().growth.max() for share in (0.999, 1.001)
        ]
        assert grows[0] == 0.0 < grows[1]
    for e, whirl in [(0.75602, True), (0.75604, False)]:  # 0.756030386 for a mass without bound
        load = static_short(e)[0] * UNIT
        assert bool(rotor(load, mass=1e5 * load / (C * W**2)).modes().growth.max() > 0.0) is whirl
    assert rotor(0.0).modes().whirl[0].ratio == pytest.approx(0.5, abs=1e-3)  # without a load every mass whirls


def test_a_growing_vibration_that_no_film_feeds_is_no_whirl():
    """A force that pushes the pin on: its film only damps."""
    load = static_short(0.5)[0] * UNIT
    m = rotor(f"{load} + 3e5*pin.vx", mass=1.0)
    assert m.modes().growth.max() > 0.0
    assert set(m.modes().whirl) == {None}


OILED = oil("finite", 0.4, 0.02)
CRANK = f"""
format = 1
ground.points = {{ O = [0, 0] }}
bodies.crank = {{ points = {{ O = [0, 0], A = [0.05, 0] }}, center = [0, 0], mass = 0.3, inertia = 1e-4 }}
bodies.rod = {{ bar = ["A", "B"], length = 0.12, mass = 0.21, inertia = 2.5e-4 }}
bodies.slider = {{ points = {{ B = [0, 0] }}, mass = 0.14, inertia = 1e-4 }}
joints.O = {{ type = "revolute", connect = ["ground.O", "crank.O"] }}
joints.A = {{ type = "revolute", connect = ["crank.A", "rod.A"], clearance = 1e-4, contact = "massless-link" }}
joints.B = {{ type = "revolute", connect = ["rod.B", "slider.B"], clearance = 2e-4, contact = {OILED} }}
joints.guide = {{ type = "prismatic", connect = ["ground.O", "slider.B"], axis = 0 }}
drivers.motor = {{ joint = "O", angle = "5000 rpm*t" }}
loads.push = {{ type = "force", at = "slider.B", force = [-2000, 0] }}
initial = {{ rod = {{ angle = 0 }}, slider = {{ angle = 0 }}, B = {{ offset = [0, 0] }} }}
"""


def test_in_a_linkage_the_film_carries_at_the_speeds_of_the_present_position():
    """The pin is where the bearing alone carries its reaction; other pins with play stay on their links."""
    m, t = rt.loads(CRANK), np.linspace(0, 2e-3, 9)
    bearing = rt.Film(viscosity=0.4, length=0.02, radius=0.01, clearance=2e-4)
    rates = m.ideal().kinematics(t)["rod.omega"]
    r = m.equilibrium(t)
    assert r.success
    for k in (0, 4, 8):
        p = bearing.static(float(np.hypot(r["B.fx"], r["B.fy"])[k]), float(rates[k]))
        assert r["B.eccentricity"][k] == pytest.approx(p.eccentricity, abs=2e-5)  # rates differ by c/l
    assert np.hypot(r["A.ex"], r["A.ey"]) == pytest.approx(np.full(9, 1e-4), rel=1e-6)
    found = m.equilibrium(float(t[4]))
    assert found[0]["B.ex"] == pytest.approx(r["B.ex"][4], abs=1e-12)
    assert "inertia of 'rod', 'slider' is left out" in found.note
    assert all(one.residual < 1e-6 * 2000 for one in found)
    assert rotor(100.0).equilibrium().note == ""  # nothing is left out where the mass centre stays in its place


def test_where_only_the_film_loads_a_mechanism_its_drag_presses_the_other_pin():
    """The coupler turns against its oil: the moment of the film is held by the reaction of the dry pin."""
    one = rt.example("fourbar_oil").equilibrium()[0]
    angle, force = one["coupler.angle"], -np.array([one["O3.fx"], one["O3.fy"]])
    held = 0.26 * (math.cos(angle) * force[1] - math.sin(angle) * force[0])
    assert held == pytest.approx(one["O2.friction_torque"], rel=1e-3)  # O3 and O2 are off their bushes by c/l
    assert one["O3.normal"] > 0.1
    assert one.stable


def test_the_commands_say_where_a_pin_floats_and_name_its_whirl(tmp_path):
    load = static_short(0.5)[0] * UNIT
    file = tmp_path / "rotor.toml"
    rotor(load, mass=8 * load / (C * W**2)).save(file)
    done = CliRunner().invoke(main, ["-q", "equilibrium", str(file)])
    assert done.exit_code == 0, done.output
    assert "O floats on 25 um of oil (e/c 0.5000)" in done.output
    done = CliRunner().invoke(main, ["-q", "modes", str(file)])
    assert "oil whirl of O at 11.3056 Hz" in done.output
    record = json.loads(CliRunner().invoke(main, ["-q", "modes", str(file), "--json"]).stdout)
    assert record["modes"][0]["whirl"]["joint"] == "O"
    assert record["modes"][1]["whirl"] is None
