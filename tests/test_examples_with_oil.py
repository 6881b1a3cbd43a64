"""Shipped examples with oil in their joints: each against a number of its own."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import rattle as rt

G = 9.81


def test_oil_gives_the_slider_crank_the_moment_and_the_force_of_the_ideal_one():
    m = rt.example("slider_crank_oil")
    r, ideal = m.simulate(), m.ideal().simulate()
    assert r.peak("motor.torque")[0] == pytest.approx(ideal.peak("motor.torque")[0], rel=0.005)
    settled = r.t > 0.012
    assert r["B.force"][settled].max() == pytest.approx(ideal["B.force"].max(), rel=0.005)
    assert (r["B.regime"] == 0).all()
    assert not r.events
    e = r["B.eccentricity"]  # 600 outputs a turn
    np.testing.assert_allclose(e[1200:1800], e[600:1200], atol=2e-4)  # one period: the third turn is the second again


def squeezed(e):
    """What momentum becomes when a short film is squeezed to the eccentricity e: the integral of its resistance."""
    return 1 / (1 - e**2) + e * (np.pi - np.arccos(e)) / (1 - e**2) ** 1.5


def test_momentum_of_a_thrown_journal_goes_into_its_film():
    r = rt.example("journal_falls").simulate(rtol=1e-10)
    k = 50e-3 * 20e-3 * 10e-3**3 / 0.1e-3**2
    kept = 2.0 * -r["shaft.vy"] + k * squeezed(-r["O.ey"] / 0.1e-3) - 2.0 * G * r.t
    np.testing.assert_allclose(kept, 2.0 * 0.5 + k, rtol=1e-7)
    assert (r["O.normal"] == 0).all()
    assert r["shaft.vy"][-1] > -1e-3


def test_stribeck_curve_falls_from_dry_friction_to_that_of_the_bearing():
    r = rt.example("stribeck").simulate()
    speed, friction = r["shaft.omega"], -r["O.friction_torque"] / (500 * 10e-3)
    alone = speed[r["O.regime"] == 0]
    assert alone[0] == pytest.approx(speed[np.argmin(friction)], rel=0.02)
    film = rt.Film(viscosity="50 mPa*s", length="10 mm", radius="10 mm", clearance="50 um")
    for w in (50.0, 100.0, 250.0):
        assert np.interp(w, speed, friction) == pytest.approx(film.static(500, w).friction, rel=5e-3)  # speeding up
    creeping = friction[(speed > 0.05) & (speed < 0.2)]
    assert creeping == pytest.approx(0.1 / math.sqrt(1 + 0.1**2), rel=0.02)  # load and friction are at right angles
    edge = 1 - 1 / 50  # the film gets as thin as the boundary film where it carries alone
    assert film.static(500, alone[0]).eccentricity == pytest.approx(edge, abs=1e-3)


def test_a_rotor_begins_to_whirl_at_its_threshold_at_half_its_speed():
    r = rt.example("rotor_whirl").simulate()
    film = rt.Film(viscosity="20 mPa*s", length="20 mm", radius="20 mm", clearance="0.1 mm")
    speed = r["rotor.omega"]
    threshold = brentq(lambda w: film.critical_mass(10 * G, w) - 10, 700, 1000)
    known = np.linspace(700, 1100, 21)
    still = [(p.eccentricity * 1e-4, p.attitude) for p in (film.static(10 * G, w) for w in known)]
    e, attitude = (np.interp(speed, known, column) for column in zip(*still, strict=True))
    off = np.hypot(r["O.ex"] - e * np.sin(attitude), r["O.ey"] + e * np.cos(attitude))
    size = [off[(speed >= w) & (speed < w + 20)].max() for w in range(720, 920, 20)]
    assert 740 + 20 * np.argmin(size[1:]) == pytest.approx(threshold, abs=21)  # decays below, grows above
    assert size[-1] > 5 * min(size)
    late = speed > 1050
    circled = np.ptp(np.unwrap(np.arctan2(r["O.ey"][late], r["O.ex"][late])))
    assert circled / np.ptp(r["rotor.angle"][late]) == pytest.approx(0.5, abs=0.01)
    assert r["O.eccentricity"][late].min() > 0.9
