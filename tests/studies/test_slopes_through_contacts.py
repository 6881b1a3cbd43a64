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
    both = m.set(**{"parameters.off": 0.7, "loads.pull.force": ["F if t > on and t < off else 0", 0]})
    s = both.sensitivity(["block.vx", "mean(block.vx)"], ["on", "off"], [0.0, 1.0])
    assert [s[f"d(block.vx)/d({name})"][-1] for name in ("on", "off")] == pytest.approx([-1.5, 1.5], rel=1e-8)
    assert [s[f"d(mean(block.vx))/d({name})"][0] for name in ("on", "off")] == pytest.approx([-0.9, 0.45], rel=1e-7)
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
    for of in ("count(rail.impacts)*max(ball.vy)", "count(rail.impacts)", "max(rail.impulse)"):
        t = rt.loads(ball(RIGID)).tolerance(of, {"e": 0.01}, t_end=END, n=16)
        assert "differences of whole runs" in t.how


def test_slopes_that_do_not_hold_within_the_tolerances_are_told():
    m = rt.example("slider_crank_play")
    t = m.tolerance("final(slider.vx)", {"c": "1 um", "speed": "1 rpm"}, t_end=0.012, n=16)
    assert "which hold for smaller changes than these tolerances" in t.how
    assert np.isfinite(list(t.slopes.values())).all()


def test_slopes_of_a_contact_much_shorter_than_the_time_between_outputs():
    """It presses a spring for 2.6e-4 of the run: closed forms of half a swing."""
    m = rt.loads(ball('{ model = "hertz", stiffness = "k", exponent = 1 }')).set(k=1e8)
    end = 1.2

    def numbers(h, k):
        v, w, sag = math.sqrt(2.0 * G * h), math.sqrt(k), G / k
        t = np.linspace(0.0, 2.0 * (math.pi - math.atan2(v, w * sag)) / w, 20001)
        force = k * (sag - sag * np.cos(w * t) + v / w * np.sin(w * t))
        return np.array([k * (math.hypot(v / w, sag) + sag), np.trapezoid(force, t), np.trapezoid(force**2, t)])

    names = ["max(rail.stop)", "integral(rail.stop)", "integral(rail.stop**2)"]
    s = m.sensitivity(names, ["h", "k"], [0.0, end])
    for parameter, h, k in (("h", 1e-5, 0.0), ("k", 0.0, 1e3)):
        want = (numbers(1.0 + h, 1e8 + k) - numbers(1.0 - h, 1e8 - k)) / (2.0 * (h + k))
        found = [s[f"d({name})/d({parameter})"][0] for name in names]
        assert found == pytest.approx(want, rel=1e-4, abs=1e-15)


def test_slopes_of_many_oscillations():
    """x = a cos(w t) over a hundred periods: rms of the speed is a w/sqrt(2)."""
    m = rt.loads(
        """
format = 1
parameters = { a = 0.1, k = 394784.17604357433 }
ground.points = { O = [0, 0] }
bodies.b = { points = { C = [0, 0] }, mass = 1, inertia = 1 }
joints.rail = { type = "prismatic", connect = ["ground.O", "b.C"], angle = 0 }
loads.spring = { type = "force", at = "b.C", force = ["-k*b.x", 0] }
initial.b = { x = "a", vx = 0 }
"""
    )
    s = m.sensitivity(["rms(b.vx)", "max(b.vx)"], ["a", "k"], [0.0, 1.0])
    w = math.sqrt(m.parameters["k"])
    assert s["rms(b.vx)"][0] == pytest.approx(0.1 * w / math.sqrt(2.0), rel=1e-5)
    assert s["d(rms(b.vx))/d(a)"][0] == pytest.approx(w / math.sqrt(2.0), rel=1e-5)
    assert s["d(max(b.vx))/d(a)"][0] == pytest.approx(w, rel=1e-5)
    assert s["d(max(b.vx))/d(k)"][0] == pytest.approx(0.05 / w, rel=1e-3)


def test_instants_that_are_read_off_next_to_an_impact():
    """The instant moves with its parameter, but not past the impact; at the end of the run it moves back only."""
    m = rt.loads(ball(RIGID).replace("lift = 0", "lift = 0, T = 0.5"))
    t1 = math.sqrt(2.0 / G)
    s = m.set(T=t1 * (1.0 + 1e-6)).sensitivity(["at(ball.vy, T)"], ["T"], [0.0, 0.6])
    assert s["d(at(ball.vy, T))/d(T)"][0] == pytest.approx(-G, rel=1e-6)
    s = m.set(T=0.6).sensitivity(["at(ball.vy, T)"], ["T"], [0.0, 0.6])
    assert s["d(at(ball.vy, T))/d(T)"][0] == pytest.approx(-G, rel=1e-6)
    s = m.set(T=t1).sensitivity(["at(ball.vy, T)", "max(ball.vy)"], ["h"], [0.0, 0.6])
    assert np.isnan(s["d(at(ball.vy, T))/d(h)"][0])
    assert s["d(max(ball.vy))/d(h)"][0] == pytest.approx(0.4 * G * t1, rel=1e-8)
    assert any("no derivative of at(ball.vy, T)" in note for note in s.trust.notes)
    s = m.sensitivity(["final(ball.vy)"], ["h"], [0.0, t1 * (1.0 + 1e-9)])
    assert np.isnan(s["d(final(ball.vy))/d(h)"][0])
    assert any("which is read off" in note for note in s.trust.notes)
