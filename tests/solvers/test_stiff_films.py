"""Oil films are stiff: radau runs them by itself, at its order, with forces as good within steps as at their ends."""

import math

import numpy as np
import pytest

import rattle as rt

C, W = 5e-5, 150.0  # clearance [m], speed [rad/s]
DRY = '{ model = "hertz", stiffness = 5e8, exponent = 1, friction = { model = "coulomb-smooth", mu = 0.1, v1 = 1e-6 } }'


def pin(more="", film="short", viscosity=0.05, mass=1.0, load=(300.0, 0.0), speed=W, v=(0.0, 0.0), simulate=""):
    """A pin that a motor turns in a bush of the ground, under a load; its film settles at rates of 1e4 to 1e6/s."""
    laws = f'film = "{film}", viscosity = {viscosity}, length = 0.01, bush_radius = 0.01{more}'
    return rt.loads(f"""
format = 1
ground.points = {{ O = [0, 0] }}
bodies.pin = {{ points = {{ P = [0, 0] }}, mass = {mass}, inertia = 1e-3 }}
[joints.O]
type = "revolute"
connect = ["ground.O", "pin.P"]
clearance = {C}
contact = {{ model = "lubricated", {laws} }}
[drivers]
spin = {{ body = "pin", coordinate = "angle", angle = "{speed}*t" }}
[loads]
push = {{ type = "force", at = "pin.P", force = ["{load[0]}", "{load[1]}"] }}
[initial]
pin = {{ angle = 0, vx = {v[0]}, vy = {v[1]} }}
[simulate]
{simulate}
""")


def swinging(**more):
    """The same under a load that turns: eccentricities up to 0.85, always in motion."""
    return pin(load=("300*cos(400*t)", "300*sin(400*t)"), **more)


def place(r):
    return np.array([r["O.ex"], r["O.ey"]]) / C


def test_a_run_with_oil_takes_radau_and_says_so():
    r = pin().simulate(1e-4)
    assert r.provenance["method"] == "radau"
    assert "radau was chosen, as oil films settle" in str(r.trust)
    for named in (pin().simulate(1e-4, method="dop853"), pin(simulate='method = "dop853"').simulate(1e-4)):
        assert named.provenance["method"] == "dop853"
        assert "radau" not in str(named.trust)
    dry = rt.example("slider_crank_play").simulate(1e-5)
    assert dry.provenance["method"] == "dop853"
    assert "chosen" not in str(dry.trust)


@pytest.mark.parametrize("film", ["short", "finite"])
def test_radau_has_its_order_with_a_film(film):
    """Equal steps, longer than the film takes to settle; the load grows from 0, so that nothing else is fast."""
    load = ("300*sin(1000*t)**2", "300*sin(700*t)**2")
    m, longest = pin(film=film, viscosity=0.01, load=load), 1e-4
    t = longest * np.arange(1, 31)
    known = place(m.simulate(t[-1], t_eval=t, method="dop853", rtol=1e-12, atol=1e-16))
    steps, errors = longest / np.array([1, 2, 3]), []
    for h in steps:
        r = m.simulate(t[-1], t_eval=t, step=h, rtol=1e-2, atol=1e-2)
        assert r.stats["steps"] == round(t[-1] / h)
        errors.append(math.sqrt(np.mean((place(r) - known) ** 2)))
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(5, abs=0.2)


@pytest.mark.parametrize("film", ["short", "finite"])
def test_errors_follow_the_tolerance_and_steps_do_not_follow_the_film(film):
    m, t = swinging(film=film), np.linspace(0, 0.03, 301)
    fine = m.simulate(t_eval=t, t_end=0.03, method="dop853", rtol=1e-12, atol=1e-16)
    tolerances, errors = 10.0 ** -np.arange(6, 12), []
    for rtol in tolerances:
        r = m.simulate(t_eval=t, t_end=0.03, rtol=rtol, atol=1e-4 * rtol)
        errors.append(float(np.abs(place(r) - place(fine)).max()))
    # tolerances of the estimate are rtol^(2/3), it has order 4 and the result order 5
    assert np.polyfit(np.log(tolerances), np.log(errors), 1)[0] == pytest.approx(5 / 6, abs=0.1)
    stiff = m.simulate(t_eval=t, t_end=0.03, method="dop853")
    assert 3 * m.simulate(t_eval=t, t_end=0.03).stats["evaluations"] < stiff.stats["evaluations"]


def test_forces_within_steps_are_as_good_as_at_their_ends():
    """The film turns an error of 1e-8 m/s into 1e-2 N: the dense output must follow it closer than its order does."""
    m, t = pin(viscosity=0.2, load=("3000*cos(400*t)", "1000*sin(800*t)")), np.linspace(0.01, 0.03, 400)
    fine = m.simulate(0.03, t_eval=t, method="dop853", rtol=1e-12, atol=1e-16)
    r = m.simulate(0.03, t_eval=t)
    assert r["O.fx"] == pytest.approx(fine["O.fx"], abs=3e-3)  # N, 1e-6 of the load; 1.4e-2 N without the correction
    assert r.peaks["O.force"].value == pytest.approx(fine.peaks["O.force"].value, rel=1e-6)


def test_contact_through_a_film_begins_and_ends_as_with_dop853():
    """A pin that is thrown against a thick boundary film under a load that changes its sign."""
    load = ("1500*cos(300*t)", "0")
    m = pin(f", boundary_film = {0.05 * C}, dry = {DRY}", mass=5.0, viscosity=0.002, load=load, v=(1.0, 0.2))
    times = {"t_end": 0.03, "t_eval": np.linspace(0, 0.03, 301), "rtol": 1e-9, "atol": 1e-13}
    one, other = m.simulate(**times), m.simulate(method="dop853", **times)
    assert [event.kind for event in one.events] == [event.kind for event in other.events]
    assert len(one.events) > 4
    assert [event.t for event in one.events] == pytest.approx([event.t for event in other.events], abs=1e-9)
    assert one["O.normal"] == pytest.approx(other["O.normal"], abs=1e-6 * other["O.normal"].max())
    assert one["O.regime"].max() > 0.0


def test_a_pin_at_rest_in_oil_takes_long_steps():
    """Its force has a kink there: damping is larger towards the wall than away from it."""
    m = pin(mass=0.2, load=(0.0, 0.0), speed=0.0, v=(2.5, 0.0))
    few, many = (m.simulate(end, t_eval=[end]) for end in (0.05, 0.5))
    assert abs(many["pin.vx"][-1]) < 1e-9  # m/s, some atol
    assert many.stats["steps"] < few.stats["steps"] + 20


THIN = """
format = 1
ground.points = { O = [0, 0] }
[bodies]
crank = { points = { O = [0, 0], A = [0.05, 0] }, center = [0, 0], mass = 0.3, inertia = 1e-4 }
rod = { bar = ["A", "B"], length = 0.12, mass = 2.558, inertia = 3.07e-3 }
slider = { points = { B = [0, 0] }, mass = 2.558, inertia = 1e-4 }
[joints]
O = { type = "revolute", connect = ["ground.O", "crank.O"] }
A = { type = "revolute", connect = ["crank.A", "rod.A"], clearance = 2.34e-6, contact = OIL }
B = { type = "revolute", connect = ["rod.B", "slider.B"], clearance = 2.34e-6, contact = OIL }
guide = { type = "prismatic", connect = ["ground.O", "slider.B"], axis = 0 }
[drivers]
motor = { joint = "O", angle = "12.95*t" }
"""


def test_pins_creep_through_films_of_micrometres_onto_their_bush():
    """Rates of 1e-8 m/s beside 1 m/s: neither the Jacobian nor the search for contacts may miss them."""
    oil = '{ model = "lubricated", viscosity = 1.167e-3, length = 6.05e-4, bush_radius = 3.31e-3 }'
    r = rt.loads(THIN.replace("OIL", oil)).simulate(0.37, t_eval=[0.37], most_steps=900)
    assert [one.kind for one in r.events] == ["contact"]
    assert 0.364 < r.events[0].t < 0.366
