"""Sensitivities: closed forms, differences of runs, jumps at switches, and what is refused."""

import math

import numpy as np
import pytest

import rattle as rt
from rattle.errors import TraceError
from rattle.questions.sensitivity.growth import growth
from rattle.results.result import load_result

nojit = pytest.mark.nojit
BLOCK = """
format = 1
[parameters]
m = "2 kg"
k = "50 N/m"
x0 = "0.1 m"
F = "3 N"
L = "0.2 m"
T = "0.15 s"
half = "k/2"
[bodies.block]
points = { P = [0, 0] }
mass = "m"
inertia = 1
[ground.points]
O = [0, 0]
[joints.guide]
type = "prismatic"
connect = ["ground.O", "block.P"]
axis = 0
[initial]
block = { x = "START", vx = 0 }
[simulate]
t_end = "0.5 s"
"""
FORCE = """
[loads.push]
type = "force"
at = "block.P"
force = ["{}", 0]
"""
PENDULUM = """
format = 1
gravity = [0, -9.81]
[parameters]
l = "0.5 m"
a0 = 1e-4
[ground.points]
O = [0, 0]
[bodies.rod]
bar = ["A", "B"]
length = "l"
mass = 1
[joints.O]
type = "revolute"
connect = ["ground.O", "rod.A"]
[initial]
rod = { angle = "a0 - pi/2", omega = 0 }
"""
LEVER = """
format = 1
gravity = [0, "-g"]
[parameters]
g = 9.81
l = "0.4 m"
k = "20 N*m"
free = "0.3"
m = "3 kg"
[ground.points]
O = [0, 0]
[bodies.lever]
bar = ["A", "B"]
length = "l"
mass = "m"
[joints.O]
type = "revolute"
connect = ["ground.O", "lever.A"]
[loads.spring]
type = "torsion-spring"
connect = ["ground.O", "lever.A"]
stiffness = "k"
free_angle = "free"
[initial]
lever = { angle = 0, omega = 0 }
"""
TIMES = [0.0, 0.1, 0.27, 0.4]


def block(force, start="0"):
    return rt.loads(BLOCK.replace("START", start) + FORCE.format(force))


def along(s, output, *parameters):
    return np.array([s[f"d({output})/d({p})"] for p in parameters])


# ---------------------------------------------------------------- closed forms
@nojit
def test_an_oscillator_has_the_derivatives_of_its_closed_form():
    s = block("-k*block.x", "x0").sensitivity(["block.x", "block.vx"], ["k", "m", "x0"], TIMES)
    t, m, k, x0 = np.array(TIMES), 2.0, 50.0, 0.1
    w = math.sqrt(k / m)
    by_w = -x0 * t * np.sin(w * t)
    rate_by_w = -x0 * (np.sin(w * t) + w * t * np.cos(w * t))
    want = [by_w * w / (2 * k), -by_w * w / (2 * m), np.cos(w * t)]
    rates = [rate_by_w * w / (2 * k), -rate_by_w * w / (2 * m), -w * np.sin(w * t)]
    np.testing.assert_allclose(along(s, "block.x", "k", "m", "x0"), want, rtol=0, atol=1e-9)
    np.testing.assert_allclose(along(s, "block.vx", "k", "m", "x0"), rates, rtol=0, atol=1e-8)
    assert s.unit("d(block.vx)/d(k)") == "m/s/(N/m)"
    np.testing.assert_allclose(s["block.x"], x0 * np.cos(w * t), rtol=0, atol=1e-10)


@nojit
def test_a_parameter_that_is_written_with_another_follows_it():
    m = block("-2*half*block.x", "x0")
    s = m.sensitivity("block.x", ["k", "half"], TIMES)
    by_k, by_half = along(s, "block.x", "k", "half")
    np.testing.assert_allclose(by_half, 2.0 * by_k, rtol=1e-12)
    alone = m.sensitivity("block.x", ["k"], TIMES)
    np.testing.assert_allclose(along(alone, "block.x", "k")[0], by_k, rtol=1e-7, atol=1e-12)


@nojit
def test_a_small_pendulum_has_the_derivatives_of_a_cosine():
    s = rt.loads(PENDULUM).sensitivity(["rod.angle"], ["l", "a0"], TIMES)
    t, l, a0 = np.array(TIMES), 0.5, 1e-4
    w = math.sqrt(1.5 * 9.81 / l)
    want = [a0 * t * np.sin(w * t) * w / (2 * l), np.cos(w * t)]
    got = along(s, "rod.angle", "l", "a0")
    np.testing.assert_allclose(got[0], want[0], rtol=0, atol=1e-8 * a0 * w)  # a0^2: the equation is not linear
    np.testing.assert_allclose(got[1], want[1], rtol=0, atol=1e-7)


@nojit
def test_a_lever_on_a_spring_has_the_derivatives_of_its_balance():
    s = rt.loads(LEVER).sensitivity(["lever.angle", "lever.B.y", "O.fy"], ["k", "free", "m", "l"], 0.0, "equilibrium")
    angle, g, l, k, free, m = s["lever.angle"][0], 9.81, 0.4, 20.0, 0.3, 3.0
    assert k * (free - angle) == pytest.approx(m * g * l / 2 * math.cos(angle), rel=1e-10)
    hard = k - m * g * l / 2 * math.sin(angle)
    cos = math.cos(angle)
    by = np.array([(free - angle) / hard, k / hard, -g * l / 2 * cos / hard, -m * g / 2 * cos / hard])
    np.testing.assert_allclose(along(s, "lever.angle", "k", "free", "m", "l")[:, 0], by, rtol=1e-9)
    end = l * cos * by + np.array([0.0, 0.0, 0.0, math.sin(angle)])
    np.testing.assert_allclose(along(s, "lever.B.y", "k", "free", "m", "l")[:, 0], end, rtol=1e-9)
    np.testing.assert_allclose(along(s, "O.fy", "k", "free", "m", "l")[:, 0], [0.0, 0.0, g, 0.0], atol=1e-9)


@nojit
def test_a_driven_slider_crank_has_the_derivatives_of_its_triangle():
    m = rt.example("slider_crank").ideal()
    t = [0.0, 0.0007, 0.0031]
    a, l, w = (m.parameters[name] for name in ("crank_length", "rod_length", "speed"))
    s = m.sensitivity(["slider.x", "slider.ax"], ["crank_length", "rod_length", "speed"], t, "kinematics")
    forces = m.sensitivity(["slider.x"], ["crank_length", "rod_length", "speed"], t, "inverse-dynamics")

    def place(p, t):
        a, l, w = p
        return a * np.cos(w * t) + np.sqrt(l * l - (a * np.sin(w * t)) ** 2)

    given = np.array([a, l, w], dtype=complex)
    for n, name in enumerate(("crank_length", "rod_length", "speed")):
        step = given.copy()
        step[n] += 1e-30j  # the derivative of an analytic function from its imaginary part, to rounding
        want = place(step, np.array(t)).imag / 1e-30
        np.testing.assert_allclose(s[f"d(slider.x)/d({name})"], want, rtol=0, atol=1e-11)
        np.testing.assert_allclose(forces[f"d(slider.x)/d({name})"], want, rtol=0, atol=1e-11)


# ---------------------------------------------------------------- switches
@nojit
def test_a_force_that_jumps_at_a_place_makes_the_derivatives_jump():
    s = block("F if block.x < L else 2*F").sensitivity(["block.x", "block.vx"], ["F", "L", "m"], [0.3, 0.45, 0.6, 0.8])
    assert s.stats["switchings"] == 1
    t = s.t

    def motion(F, L, m):
        first = np.sqrt(2 * m * L / F)
        late = np.maximum((t - first).real, 0.0) > 0.0
        after = np.where(late, t - first, 0.0)
        v = np.sqrt(2 * F * L / m)
        x = np.where(late, L + v * after + F / m * after**2, F / (2 * m) * t**2)
        return np.array([x, np.where(late, v + 2 * F / m * after, F / m * t)])

    values = {"F": 3.0, "L": 0.2, "m": 2.0}
    for name in values:
        want = motion(**{**values, name: values[name] + 1e-30j}).imag / 1e-30
        got = [s[f"d(block.{key})/d({name})"] for key in ("x", "vx")]
        np.testing.assert_allclose(got, want, rtol=1e-8, atol=1e-9)


@nojit
def test_a_force_that_ends_at_an_instant_given_by_a_parameter():
    s = block("F if t < T else 0").sensitivity(["block.x", "block.vx"], ["F", "T", "m"], [0.1, 0.2, 0.5])
    F, T, m = 3.0, 0.15, 2.0
    late = s.t > T
    np.testing.assert_allclose(along(s, "block.vx", "T")[0], np.where(late, F / m, 0.0), rtol=0, atol=1e-10)
    np.testing.assert_allclose(along(s, "block.x", "T")[0], np.where(late, F / m * (s.t - T), 0.0), rtol=0, atol=1e-10)
    np.testing.assert_allclose(along(s, "block.vx", "F")[0], np.minimum(s.t, T) / m, rtol=0, atol=1e-10)


@nojit
def test_a_kink_needs_no_jump():
    s = block("-k*abs(block.x)", "x0").sensitivity(["block.x"], ["k"], [0.2, 0.4])
    t, w = s.t, 5.0
    turn = math.pi / 2 / w
    by_w = np.where(t < turn, -0.1 * t * np.sin(w * t), 0.0)
    after = t - turn  # x'' = w^2 x from x = 0 with -x0 w: x = -x0 sinh(w (t - turn)), turn = pi/(2 w)
    slope = -0.1 * np.cosh(w * after) * (after + turn)
    np.testing.assert_allclose(along(s, "block.x", "k")[0], np.where(t < turn, by_w, slope) * w / 100.0, rtol=1e-8)


@nojit
def test_sticking_ends_the_result_with_a_message():
    m = block("-F*sign(block.vx)").set({"initial.block.vx": 0.3})
    s = m.sensitivity(["block.x"], ["F"], [0.1, 0.15, 0.3])
    assert not s.success
    assert "stays on the switch" in s.message
    assert list(s.t) == [0.1, 0.15]  # it rests at 0.2 s
    np.testing.assert_allclose(along(s, "block.x", "F")[0], -0.5 * s.t**2 / 2.0, rtol=1e-9)
    with pytest.raises(rt.SolverError, match="stays on the switch"):
        m.sensitivity(["block.x"], ["F"], [0.1, 0.15, 0.3], strict=True)


# ---------------------------------------------------------------- differences of runs
def differences(m, name, outputs, t):
    """Central differences of two step lengths, extrapolated."""
    value = m.parameters[name]

    def run(x):
        r = m.set({name: x}).simulate(t_eval=t, rtol=1e-12, atol=1e-14)
        return np.array([r[output] for output in outputs])

    h = 1e-4 * (abs(value) or 1.0)
    wide, narrow = ((run(value + d) - run(value - d)) / (2 * d) for d in (h, h / 2))
    return (4 * narrow - wide) / 3


@pytest.mark.parametrize(
    ("name", "t", "parameters"),
    [
        ("balanced_arm", [0.1, 0.3], ["l", "angle", "s"]),
        ("double_pendulum", [0.4, 1.0], ["upper_length", "start"]),
        pytest.param("five_bar", [0.1, 0.2], ["a", "size"], marks=pytest.mark.long),
        ("fourbar", [0.01, 0.02], ["l1", "r4", "alpha", "M"]),
        pytest.param("quick_return", [0.1, 0.3], ["d", "cut"], marks=pytest.mark.long),
        ("slider_crank", [0.002, 0.005], ["rod_length", "speed"]),
        ("toggle", [0.1, 0.2], ["l", "stiffness"]),
    ],
)
def test_derivatives_are_the_differences_of_runs(name, t, parameters):
    m = rt.example(name)
    body, joint = list(m.model.bodies)[-1], list(m.model.joints)[-1]
    outputs = [f"{body}.angle", f"{body}.vx", f"{joint}.force", "energy.kinetic"]
    s = m.sensitivity(outputs, parameters, t)
    assert s.success
    for parameter in parameters:
        got = np.array([s[f"d({output})/d({parameter})"] for output in outputs])
        want = differences(m, parameter, outputs, t)
        size = np.abs([s[output] for output in outputs]).max(axis=1)[:, None]
        noise = 1e-12 * size / (1e-4 * (abs(m.parameters[parameter]) or 1.0))  # of a run, over the step
        np.testing.assert_array_less(np.abs(got - want), 1e-6 * np.abs(want) + 100 * noise + 1e-12)


@pytest.mark.parametrize(
    ("name", "outputs", "parameters"),
    [
        ("balanced_arm", ["lamp.x", "O.force", "A.fy"], ["l", "arm_mass", "s"]),
        ("toggle_clamp", ["jaw.x", "hand.torque", "O.force"], ["l", "force", "first"]),  # fully driven
        ("fourbar", ["rocker.angle", "O3.normal", "motor.torque"], ["l2", "r3", "M"]),
    ],
)
def test_derivatives_of_an_equilibrium_are_the_differences_of_equilibria(name, outputs, parameters):
    m = rt.example(name)
    s = m.sensitivity(outputs, parameters, 0.0, "equilibrium")
    near = m.equilibrium(0.0)[0].q

    def at(parameter, value):
        found = m.set({parameter: value}).equilibrium(0.0)
        one = min(found, key=lambda one: np.abs(one.q - near).max())
        return np.array([one[output] for output in outputs])

    for parameter in parameters:
        value = m.parameters[parameter]
        h = 1e-3 * abs(value)
        wide, narrow = ((at(parameter, value + d) - at(parameter, value - d)) / (2 * d) for d in (h, h / 2))
        got = np.array([s[f"d({output})/d({parameter})"][0] for output in outputs])
        size = np.abs([s[output][0] for output in outputs])
        np.testing.assert_allclose(got, (4 * narrow - wide) / 3, rtol=1e-7, atol=1e-8 * size.max() / abs(value))


# central differences of an independent solution of the loop equations, extrapolated
FOURBAR = {  # d of coupler.angle, rocker.angle, O3.normal, O4.normal at 0.01, 0.02, 0.03 s
    "r3": [[0.958022764, 4.00606739, 1568.3309, -20218.2351], [-3.72031028, -5.94284355, -482376.587, 197738.242],
           [-14.9522658, -12.3137016, 948380.806, -727363.289]],
    "M": [[-6.28967749e-05, -1.3299028e-05, -0.289807605, 5.18082765],
          [4.04690506e-05, 0.000277203993, 26.3246969, -19.9837027],
          [0.000134276649, -0.000496971575, -17.9446781, 5.49191133]],
}  # fmt: skip


@nojit
def test_the_four_bar_agrees_with_another_solution():
    m = rt.example("fourbar")
    outputs = ["coupler.angle", "rocker.angle", "O3.normal", "O4.normal"]
    s = m.sensitivity(outputs, list(FOURBAR), [0.01, 0.02, 0.03])
    for parameter, want in FOURBAR.items():
        got, want = np.array([s[f"d({output})/d({parameter})"] for output in outputs]).T, np.array(want)
        size = np.abs(want).max(axis=0)
        np.testing.assert_allclose(got / size, want / size, rtol=0, atol=3e-8)  # the digits of the table


# ---------------------------------------------------------------- what a result says, what is refused
@pytest.mark.machine
@nojit
def test_chaos_is_said(tmp_path):
    s = rt.example("double_pendulum").set(start=1.5).sensitivity(
        ["lower.angle"], ["start"], np.linspace(0, 12, 9), rtol=1e-8
    )  # fmt: skip
    assert any("sensitivities to start grow tenfold every" in note for note in s.trust.notes)
    assert "linearly only until about" in s.trust.notes[-1]
    calm = block("-k*block.x", "x0").sensitivity(["block.x"], ["k"], np.linspace(0, 20, 3), rtol=1e-8)
    assert calm.trust.notes == ()
    path = s.save(tmp_path / "s.npz")
    again = load_result(path)
    assert again.names == ("lower.angle", "d(lower.angle)/d(start)")
    np.testing.assert_array_equal(again["d(lower.angle)/d(start)"], s["d(lower.angle)/d(start)"])
    assert again.unit("d(lower.angle)/d(start)") == "rad"
    with pytest.raises(ValueError, match="holds curves only"):
        again.animate(tmp_path / "s.gif")


@nojit
@pytest.mark.parametrize(
    ("name", "to", "said"),
    [
        ("journal_falls", None, "contacts with oil.*ideal\\(\\)"),
        ("path_generator", ["a"], r"not determined by \[initial\]; give the offset of A, B, Q"),
    ],
)
def test_what_cannot_be_differentiated_is_refused_with_the_reason(name, to, said):
    m = rt.example(name)
    output = f"{next(iter(m.model.bodies))}.x"
    with pytest.raises(TraceError, match=said):
        m.sensitivity([output], to or list(m.parameters)[:1], [0.0, 0.01])


@nojit
def test_a_parameter_that_decides_on_the_parts_of_the_model_is_refused():
    m = rt.loads(rt.example("fourbar").to_toml().replace('min = "0.5 mm", ', ""))
    with pytest.raises(TraceError, match="'r3' decides which parts"):
        m.set(r3=0.0).sensitivity(["rocker.angle"], ["r3"], [0.01])


@nojit
def test_names_and_times_are_checked():
    m = block("-k*block.x", "x0")
    with pytest.raises(KeyError, match=r"no curve 'block\.z'.*'block\.x'"):
        m.sensitivity(["block.z"], ["k"], TIMES)
    with pytest.raises(KeyError, match="no parameter 'kk'; did you mean 'k'"):
        m.sensitivity(["block.x"], ["kk"], TIMES)
    with pytest.raises(ValueError, match="increasing"):
        m.sensitivity(["block.x"], ["k"], [0.2, 0.1])
    with pytest.raises(ValueError, match="unknown analysis 'simulat'; did you mean 'simulate'"):
        m.sensitivity(["block.x"], ["k"], TIMES, "simulat")
    with pytest.raises(ValueError, match="outputs: expected a list"):
        m.sensitivity([], ["k"], TIMES)
    with pytest.raises(ValueError, match="parameters: expected a list"):
        m.sensitivity("block.x", None)
    with pytest.raises(rt.ModelError, match="kinematics needs drivers"):
        m.sensitivity(["block.x"], ["k"], TIMES, "kinematics")


@nojit
def test_a_length_moves_the_start_where_offsets_hold_the_pins_and_angles_are_guesses():
    """Both pins stay at their offsets, so that the angles follow: central differences of the start itself."""
    m, h = rt.example("fourbar"), 1e-6
    s = m.sensitivity(["rocker.angle"], ["l2"], [0.0, 0.001])
    low, high = (m.set(l2=0.6 + step).start.q[8] for step in (-h, h))
    assert s["d(rocker.angle)/d(l2)"][0] == pytest.approx((high - low) / (2 * h), rel=1e-6)


@nojit
def test_what_rests_and_is_then_pushed_has_derivatives_that_do_not_grow_exponentially():
    t = np.linspace(0.0, 1.0, 500)
    late = np.maximum(t - 0.5, 0.0)
    assert growth(t, 1e-17 + late**2) is None
    assert growth(t, 1e-17 + (t >= 0.5)) is None
    assert growth(t, np.exp(20.0 * t)).rate == pytest.approx(20.0, rel=1e-9)
    assert growth(t, 10.0 ** np.floor(8.0 * t)).tenfold == pytest.approx(1 / 8, rel=0.2)  # by impacts


@nojit
def test_parameters_beside_one_that_decides_on_the_parts_have_derivatives():
    m = rt.loads(rt.example("fourbar").to_toml().replace('min = "0.5 mm", ', "")).set(r3=0.0)
    with pytest.raises(TraceError, match="leave it out: the others have derivatives"):
        m.sensitivity(["rocker.angle"], ["r3", "l2"], [0.01])
    assert np.isfinite(m.sensitivity(["rocker.angle"], ["l2"], [0.01])["d(rocker.angle)/d(l2)"]).all()
