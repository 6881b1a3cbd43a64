"""Natural frequencies against closed forms and a matrix problem set up by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eig, eigh

import rattle as rt
from linkages import paper
from rattle.questions.equilibrium.compute import static_problem
from rattle.questions.equilibrium.exact_stiffness import exact_stiffness
from rattle.questions.modes.compute import Modes, _damping
from rattle.questions.modes.small_motions import small_motions

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
    np.testing.assert_allclose(found.omega, np.sqrt(squares[order]), rtol=1e-13)  # rounding of both
    assert found.how == "exact derivatives"
    assert str(found).endswith("stiffness and damping: exact derivatives")
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
    assert found.growth[0] == pytest.approx(math.sqrt(1.5 * 9.81), rel=1e-13)
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
    assert found.omega[0] == pytest.approx(omega, rel=1e-13)
    assert found.damping[0] == pytest.approx(0.3 * 3 / (2 * omega), rel=1e-13)
    assert found.damped_frequency[0] == pytest.approx(math.sqrt(omega**2 - 0.45**2) / (2 * math.pi), rel=1e-13)


@nojit
def test_an_overdamped_mode_creeps_back_with_its_two_time_constants():
    found = rt.loads(rods(twist(9), second=False)).modes()
    # J s^2 + c s + k = 0 about the pivot: J = 1/3 kg m^2, k = 12 + 9.81/2
    fast, slow = np.sort(np.roots([1 / 3, 9.0, 12 + 9.81 / 2]))
    assert found.damping[0] > 1.0
    np.testing.assert_allclose(found.time_constants[0], [-1 / slow, -1 / fast], rtol=1e-12)
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


@nojit
def test_an_upright_rod_with_drag_falls_slower():
    drag = twist(0.9).replace("stiffness = 12", "stiffness = 0")
    m = rt.loads(rods(drag, second=False))
    found = m.modes(equilibrium=next(one for one in m.equilibrium() if not one.stable))
    root = np.roots([1 / 3, 0.9, -9.81 / 2]).max()  # J s^2 + c s - m g l/2 = 0
    assert found.growth[0] == pytest.approx(root, rel=1e-12)
    assert found.damping[0] == 0.0


def follower(push: float, damping: float = 0.0) -> Modes:
    """Two rods of 1 m and 1 kg with hinges of 5 N m, pushed along the second one [N] (Ziegler's column)."""
    hinges = "".join(
        f"""
[loads.hinge{n}]
type = "torsion-spring"
connect = ["{a}", "{b}"]
stiffness = 5
damping = {damping}
free_angle = 0
"""
        for n, (a, b) in enumerate([("ground", "rod"), ("rod", "low")])
    )
    load = f"""
[loads.push]
type = "force"
at = "low.B"
force = ["-{push}*cos(low.angle)", "-{push}*sin(low.angle)"]
"""
    return rt.loads(rods(hinges + load, angles=(0.0, 0.0)).replace("gravity = [0, -9.81]", "gravity = [0, 0]")).modes()


ROD_MASS = np.array([[4 / 3, 1 / 2], [1 / 2, 1 / 3]])  # two rods stretched out, by their angles


@pytest.mark.machine
@nojit
def test_frequencies_under_a_follower_force_are_those_of_the_unsymmetric_stiffness():
    found = follower(8.0)
    stiffness = np.array([[10 - 8, -5 + 8], [-5, 5]])
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(ROD_MASS, stiffness)))
    np.testing.assert_allclose(found.omega, np.sqrt(squares), rtol=1e-12)
    even = np.sort(np.linalg.eigvals(np.linalg.solve(ROD_MASS, 0.5 * (stiffness + stiffness.T))))
    assert not np.allclose(squares, even, rtol=0.05)


def test_a_column_under_a_large_follower_force_flutters():
    found = follower(18.0)
    stiffness = np.array([[10 - 18, -5 + 18], [-5, 5]])
    squares = np.linalg.eigvals(np.linalg.solve(ROD_MASS, stiffness))
    assert follower(14.0).about.startswith("stable statically, unstable by flutter, stiffness")
    assert abs(squares[0].imag) > 1.0
    root = np.sqrt(-squares[0])  # exp(+-root t), and its conjugate
    assert found.growth[0] == pytest.approx(abs(root.real), rel=1e-12)
    assert found.growth[1] == 0.0
    np.testing.assert_allclose(found.omega, abs(root), rtol=1e-12)
    np.testing.assert_allclose(found.damping, np.array([-1, 1]) * abs(root.real) / abs(root), rtol=1e-12)
    np.testing.assert_allclose(found.damped_frequency, abs(root.imag) / (2 * math.pi), rtol=1e-12)
    said = f"flutter at {abs(root) / (2 * math.pi):.6g} Hz, grows at {abs(root.real):.6g} 1/s, damping -"
    assert said in str(found)
    assert found.about.startswith("unstable by flutter, stiffness -")
    way = found.vectors[0, 0, 2::3]  # both angles of the growing motion: K x = -s^2 M x
    np.testing.assert_allclose((stiffness + found.roots[0, 0] ** 2 * ROD_MASS) @ way, 0.0, atol=1e-12 * abs(way).max())


@pytest.mark.machine
@nojit
def test_weak_damping_of_unsymmetric_modes_is_that_of_all_equations_together():
    d = 1e-4
    found = follower(8.0, d)
    stiffness, damping = np.array([[10 - 8, -5 + 8], [-5, 5]]), d * np.array([[2, -1], [-1, 1]])
    system = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(ROD_MASS, np.hstack([stiffness, damping]))]])
    roots = np.linalg.eigvals(system)
    roots = roots[roots.imag > 0][np.argsort(roots[roots.imag > 0].imag)]
    np.testing.assert_allclose(found.damping * found.omega, -roots.real, rtol=1e-6)  # of first order in d


# ---------------------------------------------------------------- exact derivatives, and where there are none
@pytest.mark.parametrize("name", ["balanced_arm", "double_pendulum", "fourbar", "squeezer", "toggle"])
def test_exact_matrices_are_those_of_differences_within_their_error(name):
    m = rt.example(name)
    one = m.equilibrium()[0]
    problem = static_problem(m.system, one)
    g, null = problem.reduce(one.q)
    assert len(g)
    by_differences = problem.hessian(one.q, null), _damping(problem, one.q, null)
    stiffness, damping = exact_stiffness(problem, one.q, null)
    # fourth-order differences over 1e-4 of the size, of forces that are rounded: 1e-16/1e-4, amplified by levers
    np.testing.assert_allclose(by_differences[0], stiffness, rtol=0, atol=1e-9 * np.abs(stiffness).max())
    np.testing.assert_allclose(by_differences[1], damping, rtol=0, atol=1e-9 * np.abs(damping).max() + 1e-13)
    # loads with a potential: symmetric but for rounding, as differences are not
    np.testing.assert_allclose(stiffness, stiffness.T, rtol=0, atol=1e-14 * np.abs(stiffness).max())


def slider(force: str) -> rt.Mechanism:
    """A mass of 2 kg on a rail, held by a spring of 8 N/m at x = 0."""
    return rt.loads(f"""
format = 1
[ground.points]
O = [0, 0]
[bodies.mass]
points = {{ P = [0, 0] }}
mass = 2
inertia = 1
[joints.rail]
type = "prismatic"
connect = ["ground.O", "mass.P"]
axis = 0
[loads.all]
type = "force"
at = "mass.P"
force = ["-8*mass.x {force}", 0]
[initial]
mass = {{ x = 0.1, angle = 0 }}
""")


@nojit
def test_damping_is_the_slope_at_rest_however_soon_it_bends():
    # friction of 1e-6 N that is full at 1e-7 m/s, where differences over 1e-4 m/s would give 0.01 N s/m
    found = slider("- 1e-6*tanh(mass.vx/1e-7)").modes()
    assert found.omega[0] == pytest.approx(2.0, rel=1e-13)
    assert found.damping[0] == pytest.approx(10.0 / (2 * 2.0 * 2.0), rel=1e-12)


@nojit
def test_drag_with_the_square_of_speed_does_not_damp_a_small_vibration():
    found = slider("- 3*abs(mass.vx)*mass.vx").modes()  # a switch at v = 0, over which the slope goes on smoothly
    assert found.how == "exact derivatives"
    assert found.damping[0] == 0.0
    assert found.omega[0] == pytest.approx(2.0, rel=1e-13)


@nojit
@pytest.mark.parametrize("force", ["- 0.1*sign(mass.vx)", "- 5*max(mass.x, 0)", "- 2*abs(mass.vx)"])
def test_a_force_that_bends_right_at_the_equilibrium_is_left_to_differences(force):
    found = slider(force).modes()
    assert found.how.startswith("differences, because loads.all")
    assert "switches right at the equilibrium" in str(found)


@nojit
def test_what_cannot_be_recorded_is_left_to_differences_and_said():
    found = rt.example("door_hinge").modes()
    assert found.how.startswith("differences, because contacts begin and end")
    assert found.how in str(found)
    ideal = rt.example("door_hinge").ideal().modes()
    assert ideal.how == "exact derivatives"


COUPLED = """
format = 1
gravity = [0, 0]
[ground.points]
O = [0, 0]
[bodies.a]
points = { P = [0, 0] }
mass = 2
inertia = 1
[bodies.b]
points = { P = [0, 0] }
mass = 1
inertia = 1
[joints]
one = { type = "prismatic", connect = ["ground.O", "a.P"] }
two = { type = "prismatic", connect = ["ground.O", "b.P"] }
[loads]
p = { type = "force", at = "a.P", force = ["-100*a.x - C1*a.vx + 50*(b.x - a.x) + C2*(b.vx - a.vx)", 0] }
q = { type = "force", at = "b.P", force = ["-50*(b.x - a.x) - C2*(b.vx - a.vx)", 0] }
[initial]
a = { x = 0 }
b = { x = 0 }
"""


def coupled(c1: float, c2: float) -> tuple[rt.Mechanism, np.ndarray, np.ndarray]:
    """Two masses with dampers c1 to the ground and c2 [N s/m] between them, all roots, and M s^2 + C s + K by hand."""
    m = rt.loads(COUPLED.replace("C1", repr(c1)).replace("C2", repr(c2)))
    stiffness, damping = np.array([[150.0, -50.0], [-50.0, 50.0]]), np.array([[c1 + c2, -c2], [-c2, c2]])
    mass, zero = np.diag([2.0, 1.0]), np.zeros((2, 2))
    state = np.block([[zero, np.eye(2)], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)]])
    roots, vectors = eig(state)
    return m, roots, vectors[:2]


@nojit
@pytest.mark.parametrize(
    ("c1", "c2"), [(30.0, -2.5), (80.0, 0.1), (0.02, 0.01), (5.0, 0.0), (60.0, 40.0), (-60.0, 0.0), (-60.0, 40.0)]
)
def test_modes_of_a_damper_that_couples_them_are_the_eigenvalues_of_all_equations(c1, c2):
    m, roots, vectors = coupled(c1, c2)
    found = m.modes()
    left = list(roots)
    for mode in range(2):
        pair = found.roots[mode]
        for side in range(2):
            k = int(np.argmin(np.abs(np.array(left) - pair[side])))
            assert pair[side] == pytest.approx(left[k], rel=1e-12)
            way, want = found.vectors[mode, side, [0, 3]], vectors[:, list(roots).index(left.pop(k))]
            assert way[0] * want[1] == pytest.approx(way[1] * want[0], abs=1e-12 * abs(way).max())
        if pair[0].imag:
            assert found.omega[mode] == pytest.approx(abs(pair[0]), rel=1e-12)
            assert found.damping[mode] == pytest.approx(-pair[0].real / abs(pair[0]), rel=1e-9)
            assert found.damped_frequency[mode] == pytest.approx(pair[0].imag / (2 * math.pi), rel=1e-12)
            assert np.isnan(found.time_constants[mode]).all()
        elif pair[0].real < 0:
            np.testing.assert_allclose(found.time_constants[mode], -1 / pair.real, rtol=1e-12)
            assert found.damping[mode] > 1.0
            assert found.omega[mode] == pytest.approx(math.sqrt((pair[0] * pair[1]).real), rel=1e-12)
    assert not left
    assert found.growth.max() == pytest.approx(max(roots.real.max(), 0.0), rel=1e-12)
    assert ("grows" in str(found)) == (roots.real.max() > 0.0) == ("unstable by" in found.about)
    assert found.note == ""


def test_a_motion_released_in_a_coupled_mode_stays_in_it():
    found = coupled(30.0, -2.5)[0].modes()
    s, way = found.roots[1, 0], 1e-3 * found.vectors[1, 0, [0, 3]]
    assert abs((way[1] / way[0]).imag) > 0.1  # the masses are out of phase
    at, speed = way.real, (s * way).real
    text = COUPLED.replace("C1", "30.0").replace("C2", "-2.5")
    text = text.replace("a = { x = 0 }", f"a = {{ x = {at[0]}, vx = {speed[0]} }}")
    let_go = rt.loads(text.replace("b = { x = 0 }", f"b = {{ x = {at[1]}, vx = {speed[1]} }}"))
    t = np.linspace(0.0, 2.0, 21)
    r = let_go.simulate(t_eval=t, rtol=1e-11, atol=1e-15)
    want = (way[:, None] * np.exp(s * t)).real
    np.testing.assert_allclose([r["a.x"], r["b.x"]], want, rtol=0, atol=1e-8 * np.abs(want).max())


@nojit
def test_a_vibration_out_of_phase_is_shown_with_its_phases():
    found = coupled(30.0, -2.5)[0].modes()
    r, phase = found.motion(1, amplitude=0.2), np.linspace(0.0, 2 * math.pi, 61)
    want = 0.2 * (found.vectors[1, 0, [0, 3], None] * np.exp(1j * phase)).real
    np.testing.assert_allclose([r["a.x"], r["b.x"]], want, rtol=0, atol=1e-12)
    assert r.t[-1] == pytest.approx(1.0 / found.damped_frequency[1])
    assert found.plot(1).axes


@nojit
def test_a_mode_with_negative_damping_grows_at_its_frequency():
    found = slider("+ 3*mass.vx").modes()  # 2 s^2 - 3 s + 8 = 0
    assert found.roots[0, 0] == pytest.approx(complex(0.75, math.sqrt(4 - 0.75**2)), rel=1e-13)
    assert found.growth[0] == pytest.approx(0.75, rel=1e-13)
    assert found.damping[0] == pytest.approx(-0.75 / 2, rel=1e-13)
    assert "flutter at 0.31831 Hz, grows at 0.75 1/s, damping -37.5 %" in str(found)
    fast = slider("+ 20*mass.vx").modes()  # 2 s^2 - 20 s + 8 = 0: no vibration is left
    rates = 5 + math.sqrt(21), 5 - math.sqrt(21)
    np.testing.assert_allclose(fast.roots[0], rates, rtol=1e-13)
    assert fast.growth[0] == pytest.approx(rates[0], rel=1e-13)
    assert f"unstable, grows at {rates[0]:.6g} and {rates[1]:.6g} 1/s" in str(fast)
    assert fast.about.startswith("stable statically, unstable by negative damping")


def crossed(stiffness: float, gyration: float) -> Modes:
    """A body of 1 kg with springs [N/m] along x and y, and a force across its velocity [N s/m] (Foucault, Coriolis)."""
    return rt.loads(f"""
format = 1
gravity = [0, 0]
[bodies.mass]
points = {{ P = [0, 0] }}
mass = 1
inertia = 1
[loads.all]
type = "force"
at = "mass.P"
force = ["-{stiffness}*mass.x + {gyration}*mass.vy", "-{stiffness}*mass.y - {gyration}*mass.vx"]
[initial]
mass = {{ x = 0, y = 0, angle = 0 }}
""").modes()


@nojit
def test_gyroscopic_forces_split_frequencies_and_can_hold_what_would_fall():
    found = crossed(4.0, 3.0)  # s = +- i (sqrt(g^2/4 + k) +- g/2), and the body turns freely
    np.testing.assert_allclose(found.omega, [0.0, 1.0, 4.0], rtol=1e-13)
    assert (found.damping == 0).all()
    assert (found.growth == 0).all()
    circles = found.vectors[1:, 0, 1] / found.vectors[1:, 0, 0]
    np.testing.assert_allclose(circles, [-1j, 1j], atol=1e-12)  # one way round and the other
    held = crossed(-2.0, 3.0)
    np.testing.assert_allclose(held.omega, [0.0, 1.0, 2.0], rtol=1e-13)
    assert held.about.startswith("held by forces without a potential (free")
    fallen = crossed(-4.0, 3.0)  # 9/4 < 4: it spirals out
    np.testing.assert_allclose(fallen.growth.max(), math.sqrt(4 - 9 / 4), rtol=1e-12)
    assert fallen.about.startswith("unstable by flutter (free")


@nojit
def test_what_a_damper_alone_connects_comes_to_rest_together():
    text = COUPLED.replace("-100*a.x - C1*a.vx + 50*(b.x - a.x) + C2*(b.vx - a.vx)", "6*(b.vx - a.vx)")
    found = rt.loads(text.replace("-50*(b.x - a.x) - C2*(b.vx - a.vx)", "-6*(b.vx - a.vx)")).modes()
    rate = 6 * (1 / 2 + 1 / 1)  # c/m of the reduced mass
    np.testing.assert_allclose(np.sort(found.roots.ravel().real), [-rate, 0, 0, 0], rtol=1e-13, atol=0)
    assert (found.roots.imag == 0).all()
    assert (found.omega == 0).all()
    assert f"0 Hz, comes to rest with time constant {1 / rate:.6g} s" in str(found)
    assert "unstable" not in found.about


@nojit
def test_every_overdamped_mode_has_a_slow_and_a_fast_root():
    # dampers far above the critical: every coordinate creeps, C dz + K z = 0, or loses its speed, M dv + C v = 0
    random = np.random.default_rng(4)
    n = 6
    mass, stiffness, damping = (a @ a.T + np.eye(n) for a in random.normal(size=(3, n, n)))
    roots, _ = small_motions(stiffness, 1e3 * damping, mass)
    slow = eigh(stiffness, 1e3 * damping, eigvals_only=True)
    fast = eigh(1e3 * damping, mass, eigvals_only=True)
    np.testing.assert_allclose(np.sort(-roots[:, 0].real), slow, rtol=1e-3)  # to (slow/fast)
    np.testing.assert_allclose(np.sort(-roots[:, 1].real), fast, rtol=1e-3)


@nojit
@pytest.mark.parametrize("kind", ["symmetric", "neutral", "follower", "both"])
def test_roots_and_shapes_solve_the_quadratic_eigenvalue_problem(kind):
    random = np.random.default_rng(3)
    for n in (1, 2, 3, 5, 8) * 5:
        spread = random.normal(size=(n, n))
        mass, stiffness = spread @ spread.T + np.eye(n), random.normal(size=(n, n))
        damping = 10.0 ** random.uniform(-2, 1) * random.normal(size=(n, n))
        if kind in ("symmetric", "neutral"):
            stiffness, damping = stiffness @ stiffness.T, damping @ damping.T
        if kind == "neutral":
            free = random.normal(size=n)
            stiffness -= np.outer(stiffness @ free, free @ stiffness) / (free @ stiffness @ free)
        if kind == "follower":
            damping *= 0.0
        roots, shapes = small_motions(stiffness, damping, mass)
        sizes = [np.linalg.norm(one) for one in (mass, damping, stiffness)]
        for s, x in zip(roots.ravel(), shapes.reshape(-1, n), strict=True):
            scale = (sizes[0] * abs(s) ** 2 + sizes[1] * abs(s) + sizes[2]) * np.linalg.norm(x)
            # roots are right to rounding of the largest, here up to 1e4 times larger
            assert np.linalg.norm((mass * s * s + damping * s + stiffness) @ x) <= 1e-9 * scale
        # the determinant is det M times the product of s - root: no root is missing, none is there twice
        point = 1.3 - 0.7j
        want = np.linalg.det(mass * point**2 + damping * point + stiffness)
        assert np.linalg.det(mass) * np.prod(point - roots) == pytest.approx(want, rel=1e-8)


@nojit
def test_an_equilibrium_of_another_mechanism_is_refused_in_words():
    one, two = rt.loads(rods(second=False)), rt.loads(rods())
    longer = rt.loads(rods(second=False).replace("length = 1", "length = 1.5"))
    twisted = rt.loads(rods(twist(0.3).replace('"-pi/2"', '"-pi/3"'), second=False))
    with pytest.raises(ValueError, match="it has the bodies rod, low, this one rod"):
        one.modes(equilibrium=two.equilibrium()[0])
    with pytest.raises(ValueError, match=r"open by 0\.25 m"):
        one.modes(equilibrium=longer.equilibrium()[0])
    with pytest.raises(ValueError, match=r"another mechanism: .* unbalanced by"):
        one.modes(equilibrium=twisted.equilibrium()[0])
    with pytest.raises(ValueError, match="another mechanism"):  # a pin that carries in its play is no pin without
        one.modes(equilibrium=rt.loads(rods(clearance="clearance = 0.005", second=False)).equilibrium()[0])
    with pytest.raises(TypeError, match=r"got Equilibria; take one of them, such as m.equilibrium\(\)\[0\]"):
        one.modes(equilibrium=one.equilibrium())
    with pytest.raises(TypeError, match="got int"):
        one.modes(equilibrium=0)


@nojit
def test_an_equilibrium_that_stays_one_when_the_damping_changes_is_taken():
    calm, damped = (rt.loads(rods(twist(c), second=False)) for c in (0.0, 0.3))
    found = damped.modes(equilibrium=calm.equilibrium()[0])
    assert found.damping[0] == pytest.approx(damped.modes().damping[0], rel=1e-9)


def test_damping_that_is_rounding_is_none_in_words():
    found = rt.loads(rods()).modes()
    root = complex(found.roots[0, 0])
    rounded = replace(
        found, roots=np.array([[-1e-13 * abs(root) + 1j * root.imag, -1e-13 * abs(root) - 1j * root.imag]])
    )
    assert rounded.rows()[0][2] == "0 %"
    damped = replace(found, roots=np.array([[-1e-6 * abs(root) + 1j * root.imag, -1e-6 * abs(root) - 1j * root.imag]]))
    assert damped.rows()[0][2] == "0.0001 %"


@nojit
@pytest.mark.parametrize(("heavy", "light"), [(1e12, 1e-9), (1.0, 1e-30)])
def test_masses_too_unlike_for_modes_are_named(heavy, light):
    m = rt.loads(rods())
    unlike = m.set({"bodies.rod.mass": heavy, "bodies.low.mass": light})
    with pytest.raises(rt.InputError, match=r"modes cannot be computed: 'rod' has .* times the mass of 'low'"):
        unlike.modes()


@nojit
@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_modes_of_what_has_sunk_in_by_little(exponent):
    """A weight on an elastic stop, 50 um deep beside a mechanism of 0.3 m: omega^2 = n g/delta, F being K delta^n."""
    stiffness = 5 * 9.81 / 5e-5**exponent
    m = rt.loads(f"""
format = 1
gravity = [0, -9.81]
ground.points = {{ O = [0, 0], far = [0.3, 0] }}
bodies.weight = {{ points = {{ C = [0, 0] }}, mass = 5, inertia = 1 }}
[joints.rail]
type = "prismatic"
connect = ["ground.O", "weight.C"]
axis = "-90 deg"
stop = {{ max = 0.1, contact = {{ model = "hertz", stiffness = {stiffness!r}, exponent = {exponent} }} }}
[initial]
weight = {{ y = -0.09 }}
""")
    assert m.modes().omega == pytest.approx([math.sqrt(exponent * 9.81 / 5e-5)], rel=1e-6)
