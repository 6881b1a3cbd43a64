"""Tolerances and optima whose derivatives go through contacts: closed forms of a ball that bounces."""

import math

import numpy as np
import pytest

import rattle as rt
from balls import RIGID, G, ball

LINEAR = '{ model = "hertz", stiffness = "k", exponent = 1 }'


def height(e, h, t):
    """Of a ball after its first impact [m]."""
    t1 = math.sqrt(2.0 * h / G)
    return e * G * t1 * (t - t1) - 0.5 * G * (t - t1) ** 2


def test_a_tolerance_knows_the_slopes_of_a_ball_that_has_bounced():
    t = rt.loads(ball(RIGID)).tolerance("at(ball.y, 0.7)", {"e": 0.01, "h": "2 mm"}, t_end=0.75, n=16)
    t1, d = math.sqrt(2.0 / G), 1e-6
    by_h = (height(0.8, 1.0 + d, 0.7) - height(0.8, 1.0 - d, 0.7)) / (2.0 * d)
    assert t.how == "exact derivatives"
    assert t.slopes["e"] == pytest.approx(G * t1 * (0.7 - t1), rel=1e-8)
    assert t.slopes["h"] == pytest.approx(by_h, rel=1e-7)


def test_a_search_goes_through_an_impact():
    o = rt.loads(ball(RIGID)).optimise("(at(ball.y, 0.7) - 0.5)**2", {"e": (0.5, 0.95)}, t_end=0.75)
    assert not o.differenced
    assert o.success
    t1 = math.sqrt(2.0 / G)
    want = (0.5 + 0.5 * G * (0.7 - t1) ** 2) / (G * t1 * (0.7 - t1))
    assert o.values["e"] == pytest.approx(want, rel=1e-6)


def test_a_tolerance_knows_the_slopes_of_a_ball_that_has_pressed_a_spring():
    """It leaves with its own speed, one half swing later; the spring's weight on the motion is (m g/k)."""
    m = rt.loads(ball(LINEAR))
    t = m.tolerance("at(ball.y, 0.7)", {"k": 1e3, "h": "2 mm"}, t_end=0.75, n=16)
    assert t.how == "exact derivatives"

    def at(k, h):
        w, t1 = math.sqrt(k), math.sqrt(2.0 * h / G)
        v, sag = G * t1, G / k
        lasts = 2.0 * (math.pi - math.atan2(v, w * sag)) / w
        later = 0.7 - t1 - lasts
        return v * later - 0.5 * G * later**2

    for name, k, h in (("k", 10.0, 0.0), ("h", 0.0, 1e-5)):
        want = (at(1e5 + k, 1.0 + h) - at(1e5 - k, 1.0 - h)) / (2.0 * (k + h))
        assert t.slopes[name] == pytest.approx(want, rel=1e-6)


def test_numbers_between_instants_are_differenced():
    """A rate jumps in an impact: derivatives at each instant do not make that of its mean."""
    t = rt.loads(ball(RIGID)).tolerance("mean(ball.vy)", {"e": 0.01}, t_end=0.75, n=16)
    assert "differences of whole runs" in t.how
    t1 = math.sqrt(2.0 / G)
    assert t.slopes["e"] == pytest.approx(G * t1 * (0.75 - t1) / 0.75, rel=1e-6)


def test_slopes_that_do_not_hold_within_the_tolerances_are_told():
    m = rt.example("slider_crank_play")
    t = m.tolerance("final(slider.vx)", {"c": "1 um", "speed": "1 rpm"}, t_end=0.012, n=16)
    assert "which hold for smaller changes than these tolerances" in t.how
    assert np.isfinite(list(t.slopes.values())).all()
