"""The mobility method: inverse of the film, squeeze in closed form, static places, other programs, names, bad input."""

import math

import numpy as np
import pytest

import rattle as rt
from oil_films import LAWS, film, states
from rattle.errors import AssemblyError, ModelError
from rattle.results.result import UnknownName
from rattle.solvers import mobility

C, W, LOAD = 5e-5, 150.0, 100.0
DRY = '{ model = "hertz", stiffness = 5e8, exponent = 1, friction = { model = "coulomb-smooth", mu = 0.1, v1 = 1e-6 } }'


def oil(law="short", **more):
    """The bearing of `oil_films`."""
    rest = "".join(f", {key} = {value}" for key, value in more.items())
    sizes = "viscosity = 0.05, length = 0.01, bush_radius = 0.01"
    return f'{{ model = "lubricated", film = "{law}", {sizes}{rest} }}'


def pin(contact, load=(LOAD, 0.0), speed=0.0, bush=0.0, e=(0.0, 0.0), more=""):
    """A pin that a motor turns, under a load, in a bush that another one turns."""
    return rt.loads(f"""
format = 1
ground.points = {{ O = [0, 0] }}
bodies.bush = {{ points = {{ P = [0, 0] }}, mass = 1, inertia = 1e-3 }}
bodies.pin = {{ points = {{ P = [0, 0] }}, mass = 1, inertia = 1e-3 }}
joints.fixed = {{ type = "revolute", connect = ["ground.O", "bush.P"] }}
joints.O = {{ type = "revolute", connect = ["bush.P", "pin.P"], clearance = {C}, contact = {contact} }}
drivers.turn = {{ body = "bush", coordinate = "angle", angle = "{bush}*t" }}
drivers.spin = {{ body = "pin", coordinate = "angle", angle = "{speed}*t" }}
loads.push = {{ type = "force", at = "pin.P", force = [{str(load)[1:-1]}] }}
initial = {{ O = {{ offset = {list(e)} }} }}
{more}
""")


@pytest.mark.nojit
@pytest.mark.parametrize(("law", "cavitation"), LAWS)
def test_a_film_that_moves_as_the_mobility_says_exerts_that_force(law, cavitation):
    """The inverse of the film at random states, from next to the centre to 0.98 c, loads in all directions."""
    more = {} if law == "pinkus-sternlicht" else {"cavitation": f'"{cavitation}"'}
    workspace, one = pin(oil(law, **more)).system.workspace(), film(law, cavitation, ratio=0.5)
    for ex, ey, fx, fy, _, _ in states(one, 40, seed=3):
        ux, uy = mobility.seen_velocity_for.python(workspace, 0, ex, ey, 1e4 * fx, 1e4 * fy)
        assert one.force(ex, ey, ux, uy)[:2] == pytest.approx(
            (1e4 * fx, 1e4 * fy), abs=2e-11 * 1e4 * math.hypot(fx, fy)
        )
    assert mobility.seen_velocity_for.python(workspace, 0, 1e-5, 0.0, 0.0, 0.0) == (0.0, 0.0)


@pytest.mark.nojit
def test_mobilities_of_a_short_film_are_those_of_another_program():
    """In load c^2/(mu R L^3) c: load along e and across it at 0.5 c, against it at 0.9 c."""
    workspace, unit = pin(oil()).system.workspace(), C**3 / (0.05 * 0.01 * 0.01**3)
    for e, force, want in [
        (0.5, (1, 0), (0.10970047, 0)), (0.5, (0, 1), (-0.41080264, 0.65445166)), (0.9, (-1, 0), (-3.28679259, 0)),
    ]:  # fmt: skip
        found = mobility.seen_velocity_for.python(workspace, 0, e * C, 0.0, -float(force[0]), -float(force[1]))
        assert np.array(found) / unit == pytest.approx(want, abs=1e-8)


def squeezed(e):
    """A(e), the antiderivative of the squeeze force of a short film over mu R L^3/c^2."""
    return 1 / (1 - e**2) + e * (math.pi - np.arccos(e)) / (1 - e**2) ** 1.5


def test_a_load_presses_the_pin_through_the_film_in_the_time_of_the_closed_form():
    """A(e) - A(0) = W t c^2/(mu R L^3) under Reynolds' condition, pi e/(1 - e^2)^1.5 for a full film."""
    e = np.array([0.1, 0.3, 0.5, 0.7, 0.8, 0.9])
    k = 0.05 * 0.01**4 / C**2
    for cavitation, path in (
        ("reynolds", lambda e: squeezed(e) - 1),
        ("full", lambda e: math.pi * e / (1 - e**2) ** 1.5),
    ):
        o = pin(oil(cavitation=f'"{cavitation}"')).orbit("O", np.r_[0, path(e) * k / LOAD])
        assert o["O.eccentricity"][1:] == pytest.approx(e, rel=1e-8)
        assert o["O.film_fx"] == pytest.approx(np.full(7, -LOAD), rel=1e-9)
        assert (o["O.friction_power"] > 0.0).all()
    o = pin(oil(), load=(f"{LOAD} if t < 1e-2 else {2 * LOAD}", 0.0)).orbit("O", [0, 0.01, 0.02])
    assert squeezed(o["O.eccentricity"]) - 1 == pytest.approx(np.array([0, 0.01, 0.03]) * LOAD / k, rel=1e-6)


@pytest.mark.parametrize("law", ["short", "finite", "pinkus-sternlicht"])
def test_a_steady_load_settles_where_the_calculator_of_bearings_says(law):
    """Whether the pin turns or the bush: only the mean of both rates counts."""
    p = film(law).static(LOAD, W)
    for speeds in ({"speed": W}, {"bush": W}):
        o = pin(oil(law), **speeds).orbit("O", [0, 0.5, 1.0], rtol=1e-9)
        x, y = o["O.ex"][-1], o["O.ey"][-1]
        assert math.hypot(x, y) / C == pytest.approx(p.eccentricity, abs=1e-9)
        assert math.atan2(y, x) == pytest.approx(p.attitude, abs=1e-8)
    assert o["O.film_pressure"][-1] == pytest.approx(p.pressure, rel=1e-7)
    o = pin(oil(law), speed=W).orbit("O", [0, 1.0])
    assert -o["O.friction_torque"][-1] == pytest.approx(p.friction * LOAD * 0.01, rel=1e-7)
    assert o["O.friction_power"][-1] == pytest.approx(p.loss, rel=1e-7)


def test_the_orbit_is_the_same_seen_from_a_turning_frame():
    """Bush, pin and load turn 37 rad/s faster: so does the orbit."""
    t, extra = np.linspace(0, 0.05, 21), 37.0
    turning = (f"{LOAD}*cos({extra}*t)", f"{LOAD}*sin({extra}*t)")
    still = pin(oil("finite"), speed=W).orbit("O", t, rtol=1e-10)
    moved = pin(oil("finite"), load=turning, speed=W + extra, bush=extra).orbit("O", t, rtol=1e-10)
    places = [one["O.ex"] + 1j * one["O.ey"] for one in (still, moved)]
    assert places[1] * np.exp(-1j * extra * t) == pytest.approx(places[0], abs=1e-8 * C)  # the load is known to 1e-9
    assert moved["O.friction_power"] == pytest.approx(still["O.friction_power"], rel=1e-7)


def test_in_mixed_lubrication_the_dry_contact_takes_its_share():
    """Eccentricity, attitude and share of the dry contact at two speeds, found with another program."""
    for speed, e, degrees, share in [(1.0, 0.99501291, -2.02852, 0.750645), (3.0, 0.98513937, 5.28587, 0.256968)]:
        o = pin(oil(boundary_film=1e-6, dry=DRY), load=(500.0, 0.0), speed=speed, e=(0.9 * C, 0.1 * C)).orbit(
            "O", [0, 9]
        )
        assert o["O.eccentricity"][-1] == pytest.approx(e, abs=1e-8)
        assert math.degrees(math.atan2(o["O.ey"][-1], o["O.ex"][-1])) == pytest.approx(degrees, abs=1e-4)
        assert o["O.normal"][-1] / 500 == pytest.approx(share, abs=2e-6)
        assert o["O.regime"].tolist() == [0.0, 1.0]


CRANK = """
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


def crank(length=0.02, law="short"):
    sizes = f"viscosity = 0.4, length = {length}, bush_radius = 0.01"
    return rt.loads(CRANK.replace("CONTACT", f'{{ model = "lubricated", film = "{law}", {sizes} }}'))


def test_the_orbit_of_a_slider_crank_is_that_of_another_program_and_near_the_motion():
    t = np.linspace(0, 0.036, 1081)
    for length, most in ((0.02, 0.78047), (0.01, 0.94202)):
        o = crank(length).orbit("B", t)
        assert o["B.eccentricity"][720:].max() == pytest.approx(most, abs=6e-6)
        assert o["B.eccentricity"][721:] == pytest.approx(o["B.eccentricity"][361:721], abs=3e-4)  # settled
    m = crank(law="finite")
    o, r = m.orbit("B", t), m.simulate(0.036, t_eval=t, rtol=1e-7)
    assert o["B.eccentricity"][720:].max() == pytest.approx(r["B.eccentricity"][720:].max(), abs=5e-4)
    assert set(o.names) >= {name for name in r.names if not name.startswith("energy.")}
    assert {o.unit(name) == r.unit(name) for name in o.names if name in r} == {True}
    one = o.films["B"]
    assert one.least_film == pytest.approx(2e-4 * (1 - o["B.eccentricity"].max()), rel=1e-3)
    assert one.mixed == 0.0
    assert "differs from the one before" not in str(o.trust)
    assert "differs from the one before" in str(m.orbit("B", t[:721]).trust)
    ideal = m.ideal().inverse_dynamics(t)
    for name in ("B.fx", "B.fy", "motor.torque", "slider.x", "A.force"):
        assert o[name] == pytest.approx(ideal[name], rel=1e-12, abs=1e-12)


def test_an_orbit_is_saved_and_says_what_it_leaves_out(tmp_path):
    o = crank().orbit("B", t_end="5 ms")
    assert len(o.t) == 1001
    assert "its own inertia is left out" in str(o.trust)
    o.save(tmp_path / "o.npz")
    again = rt.load_result(tmp_path / "o.npz")
    assert (again["B.film_pressure"] == o["B.film_pressure"]).all()
    assert again.provenance["analysis"] == "orbit"


def test_what_has_no_orbit_is_refused_with_what_is_needed():
    m = crank()
    with pytest.raises(UnknownName, match="no joint 'C'"):
        m.orbit("C", [0, 1])
    with pytest.raises(ModelError, match=r"joints\.A\.contact: an orbit needs oil in the joint"):
        m.orbit("A", [0, 1])
    with pytest.raises(ModelError, match="1 degree of freedom is left"):
        rt.loads(CRANK.replace("drivers.motor", "#").replace("CONTACT", oil())).orbit("B", [0, 1])
    with pytest.raises(ValueError, match="t_eval must be increasing"):
        m.orbit("B", [1, 0])
    for e in (1.0, 1.2):
        with pytest.raises(AssemblyError, match=r"joint 'O' starts .* an offset of 'O' in \[initial\]"):
            pin(oil(), e=(e * C, 0.0)).orbit("O", [0, 1])


def test_a_mechanism_that_gets_stuck_ends_its_orbit_there():
    short = CRANK.replace("CONTACT", oil()).replace("length = 0.12", "length = 0.04")
    short = short.replace("rod = { angle = 0 }, slider = { angle = 0 }, ", "")
    o = rt.loads(short).orbit("B", np.linspace(0, 0.012, 101))
    assert not o.success
    assert "dead centre" in o.message
    assert 0 < len(o.t) < 101
    assert np.isfinite(o["B.eccentricity"]).all()


def test_chart_of_the_film_has_the_points_of_the_orbit():
    from rattle.questions.film.pictures import load_points

    m = rt.example("slider_crank_oil")
    o = m.orbit("B", np.linspace(0.0, 0.012, 121))
    points = load_points(o, "B")
    assert len(points.sommerfeld) > 100
    assert points.eccentricity == pytest.approx(o["B.eccentricity"][-len(points.eccentricity) :])
    figure = m.film("B").plot(result=o, joint="B")
    drawn = [line for line in figure.axes[0].lines if len(line.get_xdata()) == len(points.sommerfeld)]
    assert drawn
