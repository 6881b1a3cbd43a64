"""Chaos tools against what is known of their own: exponents by the variational equations, period doubling, threads."""

import math

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.integrate import solve_ivp

import rattle as rt
from rattle.analyses.driver_period import driver_period
from rattle.cli.main import main

DUFFING = """
format = 1
[parameters]
F = "{F} N"
k = "1 N/m^3"
d = "0.1 N*s/m"
w = "1 rad/s"
[ground.points]
O = [0, 0]
[bodies.mass]
points = {{ P = [0, 0] }}
mass = 1
inertia = 1
[joints.rail]
type = "prismatic"
connect = ["ground.O", "mass.P"]
axis = 0
[loads.all]
type = "force"
at = "mass.P"
force = ["F*cos(w*t) - k*mass.x**3 - d*mass.vx", 0]
[initial]
mass = {{ x = 3, vx = 4, angle = 0 }}
[simulate]
t_end = "1000 s"
"""


def duffing(F):
    """Ueda's form of Duffing's equation, x'' + 0.1 x' + x^3 = F cos t, of our own loads."""
    return rt.loads(DUFFING.format(F=F))


def exponent_by_variation(F, t_end, skip):
    """The same exponent from the linearised equations along the motion: written down apart from the package."""

    def rate(t, y):
        x, v, dx, dv = y
        return [v, F * math.cos(t) - x**3 - 0.1 * v, dv, -3 * x * x * dx - 0.1 * dv]

    y, total = np.array([3.0, 4.0, 1.0, 0.0]), 0.0
    for k in range(int(t_end)):
        y = solve_ivp(rate, (k, k + 1), y, "DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
        size = math.hypot(y[2], y[3])
        y[2:] /= size
        total += math.log(size) if k >= skip else 0.0
    return total / (t_end - skip)


def test_exponent_of_a_chaotic_oscillator_is_that_of_its_linearised_equations():
    found = duffing(12.0).lyapunov(1000.0)
    assert found.chaotic
    assert found.exponent == pytest.approx(exponent_by_variation(12.0, 600, 100), abs=found.uncertainty + 0.02)
    assert 0.08 < found.exponent < 0.16  # about 0.11 to 0.12 in the literature on Ueda's attractor
    assert found.uncertainty < 0.04
    assert "tenfold every" in str(found)


def test_exponent_of_a_periodic_oscillator_is_negative():
    # F = 1: one period, a damped oscillation about it: errors shrink like exp(-0.05 t)
    found = duffing(1.0).lyapunov(400.0)
    assert found.exponent == pytest.approx(-0.05, abs=0.005)
    assert not found.chaotic
    assert found.horizon() == math.inf


@pytest.mark.parametrize("t_end", [43.0, 47.0, 57.0])
def test_exponent_does_not_depend_on_where_in_a_swing_the_run_ends(t_end):
    # x'' + 0.1 x' + 25 x = 0: errors shrink like exp(-0.05 t), and swing meanwhile, by a factor of up to 5 in the norm
    # of a run with stretches of 1 s, seen at every 1.6th half swing: by ln(5)/(0.8 t_end) = 0.04 in the mean growth
    m = rt.loads(DUFFING.format(F=0.0).replace("k*mass.x**3", "25*mass.x").replace('k = "1 N/m^3"\n', ""))
    found = m.lyapunov(t_end, stretch=1.0)
    # by least squares less by about the number of half swings that are seen, 10 to 14
    assert found.exponent == pytest.approx(-0.05, abs=0.005)


def test_exponent_of_an_integrable_pendulum_is_nothing_and_of_a_double_one_positive():
    m = rt.Mechanism("pendulum", gravity=[0, -9.81])
    m.ground(O=[0, 0])
    m.bar("rod", "A", "B", length=1, mass=1)
    m.revolute("O", "ground.O", "rod.A")
    m.initial("rod", angle=0.3)
    one = m.lyapunov(400.0)
    assert abs(one.exponent) < one.uncertainty + 0.02
    assert not one.chaotic
    assert "no exponential growth" in str(one)
    two = rt.example("double_pendulum").lyapunov(60.0)
    assert two.chaotic
    assert two.exponent > 0.5


def test_exponent_is_the_reason_behind_the_horizon():
    # play held by massless links: an error of 1e-12 or so per step is 1 % after ln(1e10)/exponent
    m = rt.example("fourbar")
    found = m.lyapunov(2.0)
    assert found.chaotic
    assert found.how == "exact variational equations"
    horizon = m.simulate(0.6, horizon=True).trust.horizon
    grown = math.log(1e-2 / 1e-9)  # 1e-9 to 1 %, at a rate that is known within its uncertainty
    assert grown / (found.exponent + found.uncertainty) < horizon < grown / (found.exponent - found.uncertainty)


def test_exponent_with_contacts_carries_their_memory():
    found = rt.example("slider_crank_play").lyapunov(0.1)
    assert found.chaotic
    assert "by two neighbouring runs, because contacts begin and end" in str(found)
    again = rt.example("slider_crank_play").lyapunov(0.1)
    assert again.exponent == found.exponent


def impact_pair(amplitude, restitution):
    """A mass that slides between the two walls of a driven box, 1 cm to either side."""
    return rt.loads(f"""
format = 1
gravity = [0, 0]
[ground.points]
O = [0, 0]
[bodies.box]
points = {{ P = [0, 0] }}
mass = 1
inertia = 1
[bodies.mass]
points = {{ P = [0, 0] }}
mass = 0.1
inertia = 1e-3
[joints.guide]
type = "prismatic"
connect = ["ground.O", "box.P"]
axis = 0
[joints.track]
type = "prismatic"
connect = ["ground.O", "mass.P"]
axis = 0
[joints.walls]
type = "revolute"
connect = ["box.P", "mass.P"]
clearance = 0.01
contact = {{ model = "impact", restitution = {restitution} }}
[drivers.shake]
joint = "guide"
position = "{amplitude} * sin(10 * pi * t)"
[initial.mass]
x = 0.001
y = 0
vx = 0.3
""")


def test_exponent_of_a_periodic_impact_pair_is_that_of_its_restitution():
    # two impacts per period of 0.2 s; each shrinks areas by e^2, and the multipliers are a conjugate pair
    found = impact_pair(0.004, 0.8).lyapunov(30.0)
    assert found.exponent == pytest.approx(10.0 * math.log(0.8), abs=0.01)
    assert not found.chaotic


def test_exponent_of_a_chaotic_impact_pair_is_that_of_straight_flights_and_reflections():
    found = impact_pair(0.02, 0.8).lyapunov(60.0, stretch=0.05)
    other, impacts = exponent_by_reflection(0.02, 0.8, 100.0, 0.05)
    assert impacts > 1000
    assert found.chaotic
    assert found.exponent == pytest.approx(other, abs=1.5 * found.uncertainty)
    assert other == pytest.approx(6.6, abs=1.0)


def exponent_by_reflection(amplitude, e, t_end, stretch):
    """The same by two flights next to each other, impacts found by bisection."""
    omega, c = 10.0 * math.pi, 0.01

    def first_hit(x, v, t, end):
        def open_by(s, side):
            return c - side * (x + v * (s - t) - amplitude * math.sin(omega * s))

        a = t + 1e-12
        while a < end:
            b = min(a + 1e-3, end)
            for side in (1, -1):
                if open_by(b, side) < 0.0:
                    low, high = a, b
                    for _ in range(60):
                        middle = 0.5 * (low + high)
                        low, high = (low, middle) if open_by(middle, side) < 0.0 else (middle, high)
                    return low
            a = b
        return None

    def fly(x, v, t, end):
        count = 0
        while (hit := first_hit(x, v, t, end)) is not None:
            x, t = x + v * (hit - t), hit
            v -= (1.0 + e) * (v - amplitude * omega * math.cos(omega * t))
            count += 1
        return np.array([x + v * (end - t), v]), count

    weight = np.array([1.0 / c, stretch / c])
    y, apart, logs, impacts = np.array([0.001, 0.3]), np.array([1e-10, 0.0]), [], 0
    for k in range(round(t_end / stretch)):
        before = np.linalg.norm(weight * apart)
        (one, hits), (two, others) = (fly(*state, k * stretch, (k + 1) * stretch) for state in (y, y + apart))
        now = np.linalg.norm(weight * (two - one))
        if hits == others:
            logs.append(math.log(now / before))
            apart = (two - one) * 1e-8 / now
        y, impacts = one, impacts + hits
    kept = logs[len(logs) // 5 :]
    return sum(kept) / len(kept) / stretch, impacts


@pytest.mark.parametrize("name", ["cam_lift_off", "ratchet", "scotch_yoke", "geneva", "door_closer"])
def test_neighbouring_motions_that_become_one_have_no_growth(name):
    """A contact or a stop holds what a driver does not, so that nothing is left of another start."""
    found = rt.example(name).lyapunov()
    assert found.exponent == -math.inf
    assert not found.chaotic
    assert found.horizon() == math.inf
    assert found.vanished < rt.example(name).model.settings.t_end
    assert f"neighbouring motions have become the same one by t = {found.vanished:.3g} s" in str(found)
    assert f"vanish by t = {found.vanished:.3g} s" in repr(found)


def test_a_state_at_rest_at_the_start_counts_in_the_range_that_it_reaches_soon():
    # the bristles of the pin's friction bend by 1e-15 of their range in the first stretches
    found = rt.example("door_hinge").lyapunov()
    assert math.isfinite(found.exponent)
    assert not found.chaotic


def test_growth_in_proportion_to_time_is_not_called_chaos():
    found = rt.example("bouncing_pin").lyapunov(2.0)  # slides round for ever, the second pin a little faster or slower
    assert not found.chaotic
    assert "a longer run shows" in str(found)


def test_exponent_with_lasting_set_valued_contacts():
    found = rt.example("three_plays").lyapunov(1.0)
    assert math.isfinite(found.exponent)
    assert found.exponent == rt.example("three_plays").lyapunov(1.0).exponent


def test_stroboscope_sees_one_point_of_a_periodic_motion_and_two_after_doubling():
    period = 2 * math.pi
    single = duffing(1.0).poincare("mass.x", "mass.vx", period=period, skip=100, points=20)
    assert np.ptp(single["mass.x"]) < 1e-4
    assert single["mass.x"][0] == pytest.approx(_strobe(1.0), abs=1e-4)
    chaotic = duffing(12.0).poincare("mass.x", "mass.vx", period=period, skip=50, points=100)
    assert np.ptp(chaotic["mass.x"]) > 1.0
    figure = chaotic.plot("mass.x", "mass.vx")
    assert figure.axes[0].get_xlabel() == "mass.x [m]"


def _strobe(F):
    end = 110 * 2 * math.pi

    def rate(t, y):
        return [y[1], F * math.cos(t) - y[0] ** 3 - 0.1 * y[1]]

    return solve_ivp(rate, (0, end), [3, 4], "DOP853", rtol=1e-10, atol=1e-12).y[0, -1]


def test_crossings_are_those_of_the_curve():
    m = rt.Mechanism("pendulum", gravity=[0, -9.81])
    m.ground(O=[0, 0])
    m.bar("rod", "A", "B", length=1, mass=1)
    m.revolute("O", "ground.O", "rod.A")
    m.initial("rod", angle=-math.pi / 2 - 0.01, omega=0)
    found = m.settings(t_end=20).poincare("rod.angle", "rod.omega", crossing="rod.omega", skip=0, points=5)
    # at its turning points on one side: omega rises through 0; small swings have the period 2 pi sqrt(2 l/(3 g))
    period = 2 * math.pi * math.sqrt(2 / (3 * 9.81)) * (1 + 0.01**2 / 16)
    assert np.diff(found.t) == pytest.approx(np.full(len(found.t) - 1, period), rel=1e-6)
    assert found["rod.angle"] == pytest.approx(np.full(len(found.t), -math.pi / 2 - 0.01), abs=1e-6)


def test_bifurcation_does_not_depend_on_threads_and_shows_period_doubling():
    values = np.linspace(5.5, 12.0, 6)
    runs = [
        duffing(1.0).bifurcation("F", values, "mass.x", period=2 * math.pi, skip=60, points=64, threads=n)
        for n in (1, 4)
    ]
    assert np.array_equal(runs[0].points, runs[1].points)
    assert runs[0].points.shape == (6, 64)
    assert np.ptp(runs[0].points[-1]) > 1.0  # chaos at F = 12
    assert runs[0].plot().axes[0].get_xlabel() == "F [N]"


STOPPED = """
format = 1
parameters = { w = 4.0, k = 2000.0 }
ground.points = { O = [0, 0], Q = [-1, 0] }
bodies.b = { points = { C = [0, 0] }, mass = 1, inertia = 1 }
[joints.rail]
type = "prismatic"
connect = ["ground.O", "b.C"]
axis = 0
angle = 0
stop = { max = 0.01, contact = CONTACT }
[loads]
spring = { type = "spring", connect = ["ground.Q", "b.C"], stiffness = 10, damping = 0.5, free_length = 1 }
push = { type = "force", at = "b.C", force = ["cos(w*t)", 0] }
"""
LAWS = {
    "compliant": '{ model = "hunt-crossley", stiffness = "k", exponent = 1, restitution = 0.6 }',
    "rigid": '{ model = "impact", restitution = 0.6 }',
}


@pytest.mark.parametrize("law", LAWS)
def test_a_bifurcation_with_contacts_runs_side_by_side(law):
    """At these speeds the motion is regular: each point is that of a run alone."""
    m, w = rt.loads(STOPPED.replace("CONTACT", LAWS[law])), np.array([3.4, 4.0])
    found = m.bifurcation("w", w, "b.vx", period="2*pi/w", skip=60, points=4)
    assert found.how == "2 run side by side"
    for speed, points in zip(w, found.points, strict=True):
        alone = m.set(w=speed).poincare("b.vx", period="2*pi/w", skip=60, points=4)
        assert alone["b.vx"] == pytest.approx(points, abs=1e-6)


def test_a_bifurcation_says_what_ran_one_by_one():
    m = rt.loads(STOPPED.replace("CONTACT", LAWS["rigid"]))
    found = m.bifurcation("w", [3.4], "b.x", period="2*pi/w", skip=0, points=2)
    assert found.how == "1 one by one: the start is a point"
    with pytest.raises(ValueError, match="the only point would be the start"):
        m.bifurcation("w", [3.4], "b.x", period="2*pi/w", skip=0, points=1)
    with pytest.raises(ValueError, match="threads"):
        m.bifurcation("w", [3.4], "b.x", period="2*pi/w", skip=1, points=1, threads=0)
    with pytest.raises(ValueError, match=r"the result has no .2\*b\.x"):
        m.bifurcation("w", [3.4], "2*b.x", period="2*pi/w", skip=1, points=1)
    path = m.bifurcation("loads.spring.damping", [0.4, 0.5], "b.x", period=1.5, skip=2, points=2)
    assert path.how.startswith("2 one by one: no parameter 'loads.spring.damping'")
    assert np.isfinite(path.points).all()


def test_driver_period_is_one_turn():
    assert driver_period(rt.example("slider_crank").system) == pytest.approx(0.012)
    assert driver_period(rt.example("double_pendulum").system) is None
    with pytest.raises(ValueError, match="give the period"):
        rt.example("double_pendulum").poincare("upper.x")


def test_poincare_on_the_command_line(tmp_path):
    out = tmp_path / "p.png"
    words = ["poincare", "slider_crank_play", "--skip", "2", "--points", "5", "-o", str(out)]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 0, done.output
    assert "5 points, every 0.012 s" in done.output
    more = ["--parameter", "c", "--from", "2e-4", "--to", "3e-4", "--values", "2", "--of", "B.ex"]
    done = CliRunner().invoke(main, ["-q", *words, *more])
    assert done.exit_code == 0, done.output
    assert out.stat().st_size > 5_000
    assert CliRunner().invoke(main, [*words, "--parameter", "c"]).exit_code == 2


def swinging(w: float) -> rt.Mechanism:
    """A damped oscillator that a load shakes with w [rad/s]."""
    m = rt.Mechanism("swinging").ground(O=[0, 0]).parameter("w", f"{w} rad/s").parameter("bare", w)
    m = m.body("b", mass=1, inertia=1, points={"P": [0, 0]}).prismatic("rail", "ground.O", "b.P")
    return m.load("all", "force", at="b.P", force=["1*cos(w*t) - 4*b.x - 1*b.vx", 0])


def test_stroboscope_follows_the_frequency_of_a_load():
    # x = Re(exp(i w t)/(4 - w^2 + i w)), seen at w t = 2 pi k
    values = np.array([0.7, 1.3, 2.9])
    m = swinging(1.0)
    found = m.bifurcation("w", values, "b.x", period="2*pi/w", skip=30, points=3)
    expected = (1.0 / (4.0 - values**2 + 1j * values)).real
    np.testing.assert_allclose(found.points, expected[:, None] * [1, 1, 1], atol=1e-6)
    assert "2*pi/w" in found.rule
    assert found.how == "3 run side by side"
    section = m.set(w=2.9).poincare("b.x", "b.vx", period="2*pi/w", skip=30, points=3)
    np.testing.assert_allclose(section["b.x"], found.points[2], atol=1e-9)
    assert "at every value" in m.bifurcation("w", values, "b.x", period="2*pi/bare", skip=1, points=1).rule


@pytest.mark.parametrize(
    ("period", "words"), [("2*pi/v", "no parameter 'v'"), ("w", "expected"), ("-1/w", "positive"), ("a b", "time")]
)
def test_periods_that_are_none_are_refused(period, words):
    with pytest.raises(ValueError, match=words):
        swinging(1.0).poincare("b.x", "b.vx", period=period, skip=1, points=1)
