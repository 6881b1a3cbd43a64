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


# ---------------------------------------------------------------- short contacts, switches of the state
def springy_ball() -> rt.Mechanism:
    """The same ball on an elastic stop: a contact lasts 1 ms and does not lose energy."""
    return ball().set({"joints.rail.stop.contact.model": "hertz", "joints.rail.stop.contact.stiffness": 1e8})


@pytest.mark.parametrize("outputs", [151, 1001])
def test_numbers_of_rates_hold_contacts_that_are_shorter_than_the_outputs(outputs):
    run = springy_ball().simulate(5.0, t_eval=np.linspace(0.0, 5.0, outputs))
    rise = run["b.y"][-1] - run["b.y"][0]
    largest = run.peak("rail.force")[0]  # found within the steps; on 1 kg, besides its weight
    assert of(run, "integral(b.vy)") == pytest.approx(rise, abs=1e-4)
    assert run.peak("b.ay")[0] == pytest.approx(largest - G, rel=2e-2)  # by rows at the ends of steps
    # with y'' = F/m - g and F ~ x^1.5 the square of the force has the integral over time that fine outputs give
    fine = springy_ball().simulate(5.0, t_eval=np.linspace(0.0, 5.0, 200_001))
    assert run.rms("b.ay") == pytest.approx(fine.rms("b.ay"), rel=1e-2)


@pytest.mark.parametrize("far", ["", 'stop = { min = -100, contact = { model = "impact", restitution = 0.5 } }'])
def test_a_switch_of_the_state_is_a_break(far):
    """x'' = 2 up to x = 0.3137, then -3: steps end there, and so do the smooth parts of curves; with any loop."""
    place, end = 0.3137, 1.0
    turn = (math.sqrt(1.0 + 4.0 * place) - 1.0) / 2.0
    m = rt.loads(f"""
format = 1
[ground.points]
O = [0, 0]
[bodies.b]
points = {{ P = [0, 0] }}
mass = 1
inertia = 1
[joints.g]
type = "prismatic"
connect = ["ground.O", "b.P"]
axis = 0
{far}
[loads.s]
type = "force"
at = "b.P"
force = ["2 if b.x < {place} else -3", 0]
[initial]
b = {{ x = 0, vx = 1 }}
""")
    run = m.simulate(end, t_eval=np.linspace(0.0, end, 21))
    assert of(run, "integral(b.ax)") == pytest.approx(2.0 * turn - 3.0 * (end - turn), abs=1e-9)
    assert of(run, "first(b.ax < 0)") == pytest.approx(turn, abs=1e-9)
    assert run.rms("b.ax") == pytest.approx(math.sqrt((4.0 * turn + 9.0 * (end - turn)) / end), rel=1e-9)


def test_a_section_inside_a_contact_is_on_its_curve():
    m = springy_ball().set({"simulate.t_end": "5 s"})
    section = m.poincare("b.y", "b.vy", crossing="b.vy", skip=0, points=5)
    assert section["b.vy"] == pytest.approx(0.0, abs=1e-6)  # m/s of 4.4: the lowest place, in the stop
    assert (section["b.y"] < -1e-3).all()
    assert section.t == pytest.approx(section.t[0] + np.arange(5) * (section.t[1] - section.t[0]), abs=1e-6)


def test_a_section_of_few_points_in_a_long_run_misses_no_turn():
    m = rt.loads("""
format = 1
[ground.points]
O = [0, 0]
[bodies.b]
points = { P = [0, 0] }
mass = 1
inertia = 1
[joints.g]
type = "prismatic"
connect = ["ground.O", "b.P"]
axis = 0
[loads.s]
type = "force"
at = "b.P"
force = ["-(2*pi*10.3)**2*b.x", 0]
[initial]
b = { x = 0.1, vx = 0 }
[simulate]
t_end = 100
""")
    section = m.poincare("b.vx", crossing="b.x", skip=0, points=5)
    assert section.t * 10.3 == pytest.approx(0.75 + np.arange(5), abs=1e-4)


def test_samples_with_more_impacts_than_instants_look_closer():
    table = ball().many({"h": [1.0]}, ["mean(b.y)", "share(b.y > 0.5)"], t_end=1000 * T)
    assert table["mean(b.y)"][0] == pytest.approx(2.0 / 3.0, rel=1e-6)
    assert table["share(b.y > 0.5)"][0] == pytest.approx(math.sqrt(0.5), rel=1e-6)
