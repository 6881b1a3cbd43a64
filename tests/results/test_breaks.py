"""Curves jump at impacts and bend at kinks of drivers: numbers of rates and sections are those of closed forms."""

import itertools
import math

import numpy as np
import pytest

import rattle as rt
from rattle.results.evaluation import evaluate
from rattle.results.reductions import Known, read
from rattle.results.sampled_curve import SampledCurve

G = 9.81
T = 2.0 * math.sqrt(2.0 / G)  # from one impact of a ball that falls from 1 m to the next [s]
FASTEST = math.sqrt(2.0 * G)


def ball(restitution: float = 1.0, height: str = "1 m") -> rt.Mechanism:
    """A ball that falls on a floor."""
    return rt.loads(f"""
format = 1
gravity = [0, -{G}]
[parameters]
h = "{height}"
[ground.points]
O = [0, 0]
[bodies.b]
points = {{ P = [0, 0] }}
mass = 1
inertia = 1
[joints.rail]
type = "prismatic"
connect = ["ground.O", "b.P"]
axis = "90 deg"
stop = {{ min = 0, contact = {{ model = "impact", restitution = {restitution} }} }}
[initial]
b = {{ y = "h", vy = 0 }}
""")


def saw(rise: float = 0.03) -> rt.Mechanism:
    """A slide that goes up by 0.3 m in `rise` [s] and down until 0.1 s, again and again."""
    return rt.loads(f"""
format = 1
[tables]
saw = {{ x = [0, {rise}, 0.1], y = [0, 0.3, 0], kind = "linear", period = 0.1 }}
[ground.points]
O = [0, 0]
[bodies.b]
points = {{ P = [0, 0] }}
mass = 2
inertia = 1
[joints.rail]
type = "prismatic"
connect = ["ground.O", "b.P"]
[drivers.d]
joint = "rail"
position = "saw(t)"
""")


def of(result: rt.Result, text: str) -> float:
    return evaluate(read(text, Known.of(result)), result)


BOUNCING = {  # of an elastic ball after 30.3 periods
    "integral(b.vy) - final(b.y)": -1.0,
    "max(b.vy)": FASTEST,
    "min(b.vy)": -FASTEST,
    "range(b.vy)": 2.0 * FASTEST,
    "first(b.vy > 0)": T / 2.0,
    "first(b.vy < -4)": 4.0 / G,
    "min(b.y)": 0.0,
    "max(b.y)": 1.0,
}


@pytest.mark.parametrize("outputs", [150, 1001])
@pytest.mark.parametrize("text", BOUNCING)
def test_numbers_of_a_bouncing_ball(text, outputs):
    end = 30.3 * T
    r = ball().simulate(end, t_eval=np.linspace(0.0, end, outputs))
    assert of(r, text) == pytest.approx(BOUNCING[text], abs=1e-9)


def test_means_of_a_bouncing_ball_are_those_of_its_parabolas():
    end = 30.0 * T
    r = ball().simulate(end, t_eval=np.linspace(0.0, end, 301))
    assert of(r, "rms(b.vy)") == pytest.approx(FASTEST / math.sqrt(3.0), rel=1e-9)
    assert of(r, "mean(b.y)") == pytest.approx(2.0 / 3.0, rel=1e-9)
    assert of(r, "mean(b.vy)") == pytest.approx(0.0, abs=1e-9)
    assert of(r, "share(b.vy > 0)") == pytest.approx(0.5, abs=1e-9)
    assert of(r, "quantile(b.vy, 0.25)") == pytest.approx(-FASTEST / 2.0, rel=1e-9)
    assert r.rms("b.y") == pytest.approx(math.sqrt(8.0 / 15.0), rel=1e-3)  # from outputs, by trapezia


def test_the_peak_of_a_rate_is_that_beside_an_impact():
    r = ball(0.8).simulate(3.0, t_eval=np.linspace(0.0, 3.0, 61))
    value, when = r.peak("b.vy")
    assert value == pytest.approx(FASTEST, rel=1e-9)
    assert when == pytest.approx(T / 2.0, rel=1e-9)
    assert of(r, "max(b.vy)") == pytest.approx(0.8 * FASTEST, rel=1e-9)
    assert of(r, "integral(abs(b.vy))") > 1.0


def test_numbers_do_not_depend_on_the_outputs():
    texts = ("rms(b.vy)", "integral(b.vy**2)", "max(b.vy)", "share(b.vy > 1)")
    coarse, fine = (
        [of(ball(0.7).simulate(2.0, t_eval=np.linspace(0.0, 2.0, count)), text) for text in texts]
        for count in (200, 3001)
    )
    np.testing.assert_allclose(coarse, fine, rtol=1e-9)


def test_many_samples_have_the_numbers_of_their_own_impacts():
    heights = np.array([0.4, 0.9, 1.7])
    found = ball(0.6).many({"h": heights}, ["integral(b.vy)", "final(b.y)", "max(b.vy)"], t_end=1.3)
    np.testing.assert_allclose(found["integral(b.vy)"], found["final(b.y)"] - heights, atol=1e-9)
    np.testing.assert_allclose(found["max(b.vy)"], 0.6 * np.sqrt(2.0 * G * heights), rtol=1e-9)


def test_a_design_is_found_whose_rate_after_the_impact_is_wanted():
    o = ball(0.9).optimise("(max(b.vy) - 3 m/s)**2", {"h": (0.2, 2)}, t_end=1.6, starts=1)
    assert o.success, o.report
    assert o.values["h"] == pytest.approx(9.0 / (2.0 * G * 0.81), rel=1e-6)


@pytest.mark.parametrize("rise", [0.03, 0.0456])
@pytest.mark.parametrize("analysis", ["kinematics", "inverse_dynamics", "simulate"])
def test_numbers_of_a_driver_by_a_table_with_kinks(rise, analysis):
    up, down = 0.3 / rise, -0.3 / (0.1 - rise)
    m = saw(rise)
    r = m.simulate(1.0) if analysis == "simulate" else getattr(m, analysis)(np.linspace(0.0, 1.0, 331))
    numbers = {
        "integral(b.vx)": 0.0,
        "max(b.vx)": up,
        "min(b.vx)": down,
        "rms(b.vx)": math.sqrt(10.0 * (up**2 * rise + down**2 * (0.1 - rise))),
        "first(b.vx < 0)": rise,
        "share(b.vx > 0)": 10.0 * rise,
        "mean(b.x)": 0.15,
    }
    for text, right in numbers.items():
        assert of(r, text) == pytest.approx(right, abs=1e-8 * abs(up)), text
    assert r.rms("b.vx") == pytest.approx(numbers["rms(b.vx)"], rel=1e-8)


def test_a_force_that_switches_in_time_has_no_share_of_both_sides():
    m = rt.Mechanism("pushed").ground(O=[0, 0])
    m = m.body("b", mass=1, inertia=1, points={"P": [0, 0]}).prismatic("rail", "ground.O", "b.P")
    m = m.load("push", "force", at="b.P", force=["3 if t < 0.5137 else 0", 0])
    r = m.simulate(1.0, t_eval=np.linspace(0.0, 1.0, 11))
    assert of(r, "integral(b.ax)") == pytest.approx(3.0 * 0.5137, rel=1e-9)
    assert of(r, "final(b.vx)") == pytest.approx(3.0 * 0.5137, rel=1e-9)
    assert of(r, "rms(b.ax)") == pytest.approx(3.0 * math.sqrt(0.5137), rel=1e-9)


# ---------------------------------------------------------------- sections
@pytest.mark.parametrize("level", [0.01, 0.5, 0.93])
def test_a_section_between_impacts_has_the_speed_of_its_height(level):
    section = ball().poincare("b.vy", "b.y", crossing="b.y", level=level, period=T, skip=2, points=12)
    speed = math.sqrt(2.0 * G * (1.0 - level))
    times = T / 2.0 + (FASTEST - speed) / G + T * np.arange(2, 14)
    np.testing.assert_allclose(section.t, times, rtol=1e-9)
    np.testing.assert_allclose(section["b.vy"], speed, rtol=1e-9)
    np.testing.assert_allclose(section["b.y"], level, rtol=1e-9)


def test_a_section_at_the_jump_of_a_rate_has_the_values_just_after_the_impact():
    section = ball().poincare("b.vy", "b.y", crossing="b.vy", level=0.3, period=T, skip=1, points=8)
    np.testing.assert_allclose(section.t, T / 2.0 + T * np.arange(1, 9), rtol=1e-9)
    np.testing.assert_allclose(section["b.vy"], FASTEST, rtol=1e-9)
    np.testing.assert_allclose(section["b.y"], 0.0, atol=1e-9)


# ---------------------------------------------------------------- the curve itself
@pytest.mark.nojit
def test_random_piecewise_parabolas_are_read_without_error():
    rng = np.random.default_rng(5)
    for _ in range(20):
        edges = np.concatenate([[0.0], np.sort(rng.uniform(0.1, 9.9, 6)), [10.0]])
        t, y, integral, squares = [], [], 0.0, 0.0
        for a, b in itertools.pairwise(edges):
            part = np.polynomial.Polynomial(rng.normal(size=3))
            inside = np.sort(rng.uniform(a, b, rng.integers(1, 9)))
            t += [a, *inside, b]
            y += part(np.array([a, *inside, b])).tolist()
            integral += part.integ()(b) - part.integ()(a)
            squares += (part**2).integ()(b) - (part**2).integ()(a)
        curve = SampledCurve(t, y)
        size = max(1.0, squares)
        assert curve.integral() == pytest.approx(integral, abs=1e-9 * size)
        # where a parabola turns between samples whose neighbours say nothing of it, the curve is straight
        assert curve.mean_square() * 10.0 == pytest.approx(squares, rel=0.2)
        assert curve.greatest() >= max(y)


@pytest.mark.nojit
def test_a_break_is_the_value_just_after_it():
    curve = SampledCurve([0, 1, 1, 2], [0, 1, 5, 6])
    assert curve.at(1.0) == 5.0
    assert curve.at(0.5) == 0.5
    assert curve.integral() == 6.0
    interval, instants = curve.rises(3.0)
    assert interval.tolist() == [1]
    assert instants.tolist() == [1.0]
    start, end = curve.spans_above(0.25)
    assert (end - start).sum() == 1.75


@pytest.mark.parametrize("suffix", ["npz", "nc"])
def test_numbers_of_a_file_are_those_of_the_run(tmp_path, suffix):
    run = ball().simulate(30.3 * T)
    run.save(tmp_path / f"r.{suffix}")
    read_back = rt.load_result(tmp_path / f"r.{suffix}")
    np.testing.assert_array_equal(read_back.breaks.t, run.breaks.t)
    np.testing.assert_array_equal(read_back.breaks.data, run.breaks.data)
    for text in BOUNCING:
        assert of(read_back, text) == of(run, text)
