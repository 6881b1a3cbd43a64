"""Growth of differences by the variational equations: closed forms, equations set up by hand, two neighbouring runs."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rattle as rt
from rattle.errors import TraceError
from rattle.questions.lyapunov import variational_equations

G = 9.81


def upright(count: int, damping: float = 0.0) -> rt.Mechanism:
    """One or two uniform rods of 1 m and 1 kg, one on top of the other, damped in the ground [N m s]."""
    m = rt.Mechanism("upright", gravity=[0, -G])
    m.ground(O=[0, 0])
    for k, below in zip(range(count), ("ground.O", "rod0.B"), strict=False):
        m.bar(f"rod{k}", "A", "B", length=1, mass=1)
        m.revolute(f"O{k}", below, f"rod{k}.A")
        m.initial(f"rod{k}", angle=math.pi / 2)
    if damping:
        m.load("drag", "torque", body="rod0", torque=f"-{damping}*rod0.omega")
    return m


def oscillator(force: str, start: str = "x = 3, vx = 4") -> rt.Mechanism:
    """A mass of 1 kg on a rail."""
    return rt.loads(f"""
format = 1
[parameters]
w = "1 rad/s"
k = "1 N/m^3"
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
force = ["{force}", 0]
[initial]
mass = {{ {start}, angle = 0 }}
""")


def neighbours(monkeypatch: pytest.MonkeyPatch) -> None:
    """Exponents are measured by two runs from here on."""

    def refuse(*given: object) -> np.ndarray:
        raise TraceError("the test wants them")

    monkeypatch.setattr(variational_equations, "growths", refuse)


@pytest.mark.nojit
@pytest.mark.parametrize("damping", [0.0, 3.0])
def test_an_upright_rod_falls_at_the_root_of_its_equation(damping):
    # J s^2 + c s - m g l/2 = 0, J = 1/3 kg m^2.  What the first direction has of the other root dies away like
    # exp(-7.7 t) or faster, and the rounded start leaves the top by 6e-17 exp(3.8 t): between 4 and 4.8 s neither shows
    found = upright(1, damping).lyapunov(5.0)
    root = np.roots([1 / 3, damping, -G / 2]).max()
    np.testing.assert_allclose(found.growth[320:384] / found.stretch, root, rtol=1e-12)
    assert found.how == "exact variational equations"
    assert str(found).endswith("\nby exact variational equations")


@pytest.mark.nojit
def test_two_upright_rods_fall_at_the_larger_root_of_their_matrices():
    mass = np.array([[4 / 3, 1 / 2], [1 / 2, 1 / 3]])  # of small angles
    stiffness = G * np.diag([3 / 2, 1 / 2])
    slow, fast = np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real))
    found = upright(2).lyapunov(4.0)
    share = math.exp(-(fast - slow) * 3.0)  # of the slower root in the direction, after 3 s
    np.testing.assert_allclose(found.growth[300:340] / found.stretch, fast, rtol=3 * share)
    assert share < 1e-5
    assert upright(2).modes(equilibrium=max(upright(2).equilibrium(), key=lambda one: one["rod1.y"])).growth.max() == (
        pytest.approx(fast, rel=1e-12)
    )


@pytest.mark.nojit
def test_exponent_of_an_overdamped_oscillator_is_its_slow_root():
    found = oscillator("-25*mass.x - 26*mass.vx").lyapunov(40.0)  # (s + 1)(s + 25)
    assert found.exponent == pytest.approx(-1.0, rel=1e-13)
    assert abs(found.exponent + 1.0) < found.uncertainty < 1e-8  # rtol in every stretch


@pytest.mark.nojit
@pytest.mark.parametrize(("force", "truth"), [("4*mass.x", 2.0), ("-25*mass.x - 26*mass.vx", -1.0), ("-4*mass.x", 0.0)])
@pytest.mark.parametrize("t_end", [1e-6, 1e-3, 0.1, 1.0])
def test_a_run_too_short_for_an_exponent_does_not_exclude_the_true_one(force, truth, t_end):
    found = oscillator(force).lyapunov(t_end)  # a difference of rates makes one of positions, in proportion to time
    assert abs(found.exponent - truth) < found.uncertainty
    assert not found.chaotic
    assert "no exponential growth of errors beyond the uncertainty" in str(found)
    if t_end < 0.1:
        assert "a longer run shows whether the growth continues" in str(found)


@pytest.mark.nojit
def test_a_run_long_enough_for_an_exponent_keeps_its_narrow_uncertainty():
    found = oscillator("4*mass.x").lyapunov(10.0)
    assert abs(found.exponent - 2.0) < found.uncertainty < 0.01


@pytest.mark.nojit
def test_growth_is_that_of_the_linearised_equations_along_the_same_chaotic_motion():
    """Ueda's form of Duffing's equation, its variational equations written down apart from the package."""

    def rate(t, y):
        x, v, dx, dv = y
        return [v, 12 * math.cos(t) - x**3 - 0.1 * v, dv, -3 * x * x * dx - 0.1 * dv]

    m = oscillator("12*cos(w*t) - k*mass.x**3 - 0.1*mass.vx")
    found = m.lyapunov(60.0, stretch=0.5)
    weight = np.array([1.0, 0.5]) / m.system.size  # of a position and a rate in the size of a difference
    apart = np.random.default_rng(1).normal(size=6)[[0, 3]] / weight  # the rail leaves nothing of the others
    y = solve_ivp(rate, (0, 60), [3, 4, *apart], "DOP853", np.linspace(0, 60, 121), rtol=1e-12, atol=1e-12).y
    size = np.log(np.hypot(*(weight[:, None] * y[2:])))
    # the motions part by 1e-10 times what differences grow by: 100 or so
    np.testing.assert_allclose(found.growth, np.diff(size), atol=1e-6)
    assert found.growth.sum() > math.log(50.0)


@pytest.mark.parametrize(
    ("name", "span"), [("double_pendulum", 2.0), ("squeezer", 0.03), pytest.param("chain", 0.3, marks=pytest.mark.long)]
)
def test_growth_agrees_with_two_runs_within_their_distance(name, span, monkeypatch):
    m = rt.example(name)
    found = m.lyapunov(span)
    assert found.growth.tolist() == m.lyapunov(span).growth.tolist()
    neighbours(monkeypatch)
    other = m.lyapunov(span)
    assert other.how == "two neighbouring runs, because the test wants them"
    # a distance of 1e-7 bends by its square, and is rounded in 1e-10 of a run
    np.testing.assert_allclose(found.growth, other.growth, atol=2e-6)
    assert np.ptp(found.growth) > 1e-3


@pytest.mark.long
def test_exponent_of_the_fourbar_agrees_with_two_runs_within_both_uncertainties(monkeypatch):
    m = rt.example("fourbar")
    found = m.lyapunov(10.0)
    neighbours(monkeypatch)
    other = m.lyapunov(10.0)
    assert found.exponent == pytest.approx(other.exponent, abs=2.0 * math.hypot(found.uncertainty, other.uncertainty))
    assert found.uncertainty < 0.2 * found.exponent


def test_what_code_cannot_follow_is_measured_by_two_runs_and_said():
    found = oscillator("-25*mass.x - 0.1*abs(mass.vx)*mass.vx").lyapunov(10.0)
    assert found.how.startswith("two neighbouring runs, because steps must end where expressions switch (loads.all")
    assert found.how in str(found)
