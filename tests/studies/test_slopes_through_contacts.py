"""Tolerances and optima whose derivatives go through contacts: closed forms of a ball that bounces."""

import math

import numpy as np
import pytest

import rattle as rt
from balls import RIGID, G, ball
from rattle.results.evaluation import evaluate
from rattle.results.reductions import Known, read

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


END = 0.75


def speeds(e, h):
    """Curve (t, vy) of the ball to END, both sides of its first impact, finely."""
    t1 = math.sqrt(2.0 * h / G)
    before, after = np.linspace(0.0, t1, 2001), np.linspace(t1, END, 2001)
    return np.append(before, after), np.append(-G * before, e * G * t1 - G * (after - t1))


def mean_of(of):
    """Mean over time of a polynomial of low degree of vy."""
    return lambda t, v: np.trapezoid(of(v), t) / END


def mean(t, v):
    return np.trapezoid(v, t) / END


def rms(t, v):
    return math.sqrt(np.sum(np.diff(t) * (v[1:] ** 2 + v[1:] * v[:-1] + v[:-1] ** 2)) / 3.0 / END)


@pytest.mark.parametrize(
    ("of", "number"),
    [
        (
            "mean(ball.vy) + 2*rms(ball.vy) + 3*max(ball.vy) - 4*min(ball.vy) + 5*speed(rail.contacts, 1)",
            lambda t, v, h: mean(t, v) + 2.0 * rms(t, v) + 3.0 * v.max() - 9.0 * v.min(),
        ),
        (
            "h*share(ball.vy > 1)*(2*first(ball.vy > 0) + time(rail.contacts, 1))",
            lambda t, v, h: h * (v.max() - 1.0) / G / END * 3.0 * t[2000],
        ),
    ],
    ids=["speeds", "times"],
)
def test_numbers_of_whole_curves_have_slopes_through_an_impact(of, number):
    """Means, extremes, shares of time and contacts: the instant of the impact moves with the height."""
    t = rt.loads(ball(RIGID)).tolerance(of, {"e": 0.01, "h": "2 mm"}, t_end=END, n=16)
    assert t.how == "exact derivatives"
    for name, e, h in (("e", 1e-6, 0.0), ("h", 0.0, 1e-6)):
        beside = [number(*speeds(0.8 + s * e, 1.0 + s * h), 1.0 + s * h) for s in (1.0, -1.0)]
        assert t.slopes[name] == pytest.approx((beside[0] - beside[1]) / 2e-6, rel=1e-6, abs=1e-8)


def test_numbers_of_a_pin_that_presses_have_slopes():
    """Against those of sensitivity, and of runs beside it."""
    m = rt.example("slider_crank_play")
    end, c, vary = 1.1e-3, m.parameters["c"], {"c": "1 nm"}
    name = "peak(B.contacts, 2)"
    t = m.tolerance(name, vary, t_end=end, n=16)
    exact = m.sensitivity([name], ["c"], [0.0, end])
    assert t.slopes["c"] == pytest.approx(exact[f"d({name})/d(c)"][0], rel=1e-5)
    name = "max(B.force) + integral(B.force)/0.1 + 1e4*rms(slider.vx)"
    t = m.tolerance(name, vary, t_end=end, n=16)
    assert t.how.startswith("exact derivatives")
    sides = [_number(m.set(c=c * (1.0 + s * 1e-5)), name, end) for s in (1.0, -1.0)]
    assert t.slopes["c"] == pytest.approx((sides[0] - sides[1]) / (2e-5 * c), rel=1e-3)


def _number(m, of, end):
    r = m.simulate(end, t_eval=np.linspace(0.0, end, 4001), rtol=1e-12, atol=1e-14)
    return evaluate(read(of, Known.of(r)), r, m.parameters)


def test_numbers_have_slopes_where_a_load_switches_on():
    """A free block that a force pulls from the instant `on` on: its acceleration jumps there."""
    m = rt.loads(
        """
format = 1
parameters = { on = "0.4 s", F = "3 N" }
ground.points = { O = [0, 0] }
bodies.block = { points = { C = [0, 0] }, mass = "2 kg", inertia = 1 }
initial.block = { x = 0, vx = 0 }
joints.rail = { type = "prismatic", connect = ["ground.O", "block.C"], angle = 0 }
loads.pull = { type = "force", at = "block.C", force = ["F if t > on else 0", 0] }
"""
    )
    for of, by_on, by_force in (
        ("mean(block.ax)", -1.5, 0.3),
        ("integral(block.vx)", -0.9, 0.09),
        ("max(block.ax)", 0.0, 0.5),
    ):
        t = m.tolerance(of, {"on": "1 ms", "F": "1 mN"}, t_end=1.0, n=16)
        assert t.how == "exact derivatives"
        assert t.slopes["on"] == pytest.approx(by_on, rel=1e-6, abs=1e-9)
        assert t.slopes["F"] == pytest.approx(by_force, rel=1e-6)


def test_a_search_for_a_mean_goes_through_impacts():
    o = rt.loads(ball(RIGID)).optimise(
        "(rms(ball.vy) - 2.4)**2", {"e": (0.5, 0.95)}, subject_to="max(ball.vy) < 4", t_end=END
    )
    assert not o.differenced
    assert o.success
    assert rms(*speeds(o.values["e"], 1.0)) == pytest.approx(2.4, rel=1e-4)


def test_numbers_of_events_are_differenced():
    t = rt.loads(ball(RIGID)).tolerance("count(rail.impacts)*max(ball.vy)", {"e": 0.01}, t_end=END, n=16)
    assert "differences of whole runs" in t.how


def test_slopes_that_do_not_hold_within_the_tolerances_are_told():
    m = rt.example("slider_crank_play")
    t = m.tolerance("final(slider.vx)", {"c": "1 um", "speed": "1 rpm"}, t_end=0.012, n=16)
    assert "which hold for smaller changes than these tolerances" in t.how
    assert np.isfinite(list(t.slopes.values())).all()
