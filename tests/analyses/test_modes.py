"""Natural frequencies against closed forms and a matrix problem set up by hand."""

import math

import numpy as np
import pytest

import rattle as rt
from linkages import paper

nojit = pytest.mark.nojit


def rods(extra: str = "", clearance: str = "", angles: tuple[float, float] = (-1.5, -1.4), second: bool = True) -> str:
    """One or two uniform rods of 1 m and 1 kg hung on each other."""
    low = """
[bodies.low]
bar = ["T", "B"]
length = 1
mass = 1
[joints.P]
type = "revolute"
connect = ["rod.B", "low.T"]
"""
    return f"""
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.rod]
bar = ["T", "B"]
length = 1
mass = 1
[joints.O]
type = "revolute"
connect = ["ground.O", "rod.T"]
{clearance}
{low if second else ""}
{extra}
[initial]
rod = {{ angle = {angles[0]} }}
{f"low = {{ angle = {angles[1]} }}" if second else ""}
"""


@nojit
def test_a_rod_hanging_in_its_clearance_has_two_frequencies():
    found = rt.loads(rods(clearance="clearance = 0.005", second=False)).modes()
    np.testing.assert_allclose(found.omega, [3.8252500863, 88.8382094697], rtol=1e-9)  # closed form
    np.testing.assert_allclose(found.frequency, found.omega / (2 * math.pi))
    assert (found.growth == 0).all()


@nojit
def test_double_pendulum_of_rods():
    found = rt.loads(rods()).modes()
    mass = np.array([[4 / 3, 1 / 2], [1 / 2, 1 / 3]])  # small angles; THEORY of any textbook on vibrations
    stiffness = 9.81 * np.diag([3 / 2, 1 / 2])
    squares, shapes = np.linalg.eig(np.linalg.solve(mass, stiffness))
    order = np.argsort(squares)
    np.testing.assert_allclose(found.omega, np.sqrt(squares[order]), rtol=1e-9)
    for k in range(2):
        assert found.shapes[k, 5] / found.shapes[k, 2] == pytest.approx(
            shapes[1, order[k]] / shapes[0, order[k]], rel=1e-7
        )


@nojit
def test_an_upright_rod_falls_at_its_rate():
    m = rt.loads(rods(second=False))
    upright = next(one for one in m.equilibrium() if not one.stable)
    found = m.modes(equilibrium=upright)
    assert math.isnan(found.omega[0])
    assert found.growth[0] == pytest.approx(math.sqrt(1.5 * 9.81), rel=1e-9)
    assert "unstable" in str(found)


def twist(damping: float) -> str:
    """A spring of 12 N m that holds the upper rod where it hangs, with damping [N m s]."""
    return f"""
[loads.twist]
type = "torsion-spring"
connect = ["ground", "rod"]
stiffness = 12
damping = {damping}
free_angle = "-pi/2"
"""


@nojit
def test_damping_is_a_share_of_the_critical():
    found = rt.loads(rods(twist(0.3), second=False)).modes()
    omega = math.sqrt((12 + 9.81 / 2) * 3)
    assert found.omega[0] == pytest.approx(omega, rel=1e-9)
    assert found.damping[0] == pytest.approx(0.3 * 3 / (2 * omega), rel=1e-8)


@nojit
def test_an_overdamped_mode_creeps_back_with_its_two_time_constants():
    found = rt.loads(rods(twist(9), second=False)).modes()
    # J s^2 + c s + k = 0 about the pivot: J = 1/3 kg m^2, k = 12 + 9.81/2
    fast, slow = np.sort(np.roots([1 / 3, 9.0, 12 + 9.81 / 2]))
    assert found.damping[0] > 1.0
    np.testing.assert_allclose(found.time_constants[0], [-1 / slow, -1 / fast], rtol=1e-8)
    assert f"overdamped, time constants {-1 / slow:.6g} s and {-1 / fast:.6g} s" in str(found)
    assert "Hz" not in str(found)
    assert "overdamped" in repr(found)
    assert "overdamped" in found.plot(0).axes[0].get_title(loc="left")
    swinging = rt.loads(rods(twist(0.3), second=False)).modes()
    assert np.isnan(swinging.time_constants).all()
    assert "overdamped" not in str(swinging)


@nojit
def test_no_freedom_no_mode():
    found = rt.loads(paper()).ideal().modes()
    assert len(found) == 0
    assert "no degree of freedom is left" in str(found)


@nojit
@pytest.mark.parametrize("clearance", ["", "clearance = 0.005"])
def test_a_mode_can_be_shown_with_its_joints_closed(clearance):
    found = rt.loads(rods(clearance=clearance)).modes()
    r = found.motion(0, amplitude=0.2)
    gap = np.hypot(r["rod.B.x"] - r["low.T.x"], r["rod.B.y"] - r["low.T.y"])
    assert gap.max() < 1e-12
    assert r["rod.angle"][0] == pytest.approx(r["rod.angle"][-1], abs=1e-12)
    assert np.ptp(r["low.angle"]) > 0.05
    assert r.t[-1] == pytest.approx(2 * math.pi / found.omega[0])
    figure = found.plot(0)
    assert figure.axes[0].get_xlabel() == "x [m]"
    assert f"{found.frequency[0]:.4g} Hz" in figure.axes[0].get_title(loc="left")
    with pytest.raises(ValueError, match="mode 7"):
        found.motion(7)


def test_a_small_swing_has_the_frequency_of_its_mode():
    m = rt.loads(rods(angles=(-math.pi / 2, -math.pi / 2)))
    found = m.modes()
    tilt = 1e-4 * found.shapes[0]
    let_go = rt.loads(rods(angles=(-math.pi / 2 + tilt[2], -math.pi / 2 + tilt[5])))
    t = np.linspace(0, 2 * math.pi / found.omega[0], 9)
    r = let_go.simulate(t_eval=t, rtol=1e-11, atol=1e-14)
    np.testing.assert_allclose(
        r["low.angle"] + math.pi / 2, tilt[5] * np.cos(found.omega[0] * t), atol=1e-6 * abs(tilt[5])
    )
