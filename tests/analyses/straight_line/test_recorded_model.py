"""Models recorded with parameters as inputs: the same numbers as reading, compiling and assembling them anew."""

import numpy as np
import pytest

import at_random
import rattle as rt
from rattle.analyses.dynamics.run import start_state
from rattle.analyses.model_form import FORM_PAYS
from rattle.analyses.straight_line.recorded_model import read_at
from rattle.analyses.straight_line.starts import Starts
from rattle.equations.motion import derivative
from rattle.equations.system import compile_system
from rattle.errors import TraceError
from rattle.results.columns import columns, width
from rattle.solvers.output_row import record
from rattle.trace.elementary import lower

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
SMOOTH = (
    "balanced_arm", "chain", "double_pendulum", "five_bar", "fourbar", "path_generator", "quick_return", "slider_crank",
    "squeezer", "toggle", "toggle_clamp", "windows",
)  # fmt: skip
GRAVITY = 'gravity = [0, "-9.81 m/s^2"]'
PENDULUM = """
format = 1
gravity = [0, "-g"]
[parameters]
l = "0.5 m"
g = "9.81 m/s^2"
m = "2*l*kg_per_m"
kg_per_m = "1.5 kg/m"
start = "30 deg"
[ground.points]
O = [0, 0]
[bodies.arm]
bar = ["A", "B"]
length = "l"
mass = "m"
[joints.O]
type = "revolute"
connect = ["ground.O", "arm.A"]
[loads.push]
type = "torque"
body = "arm"
torque = "0.1*m*g*l*sin(3*t) - 0.01*arm.omega"
[initial]
arm = { angle = "start", omega = "sqrt(g/l)" }
"""
HUNG_ON_A_CRANK = """
format = 1
[parameters]
c = "10 mm"
w = "5 rad/s"
[ground.points]
O = [0, 0]
[bodies.crank]
bar = ["O", "A"]
length = 0.3
mass = 1
[bodies.rod]
bar = ["A", "B"]
length = 0.5
mass = 1
[joints]
O = { type = "revolute", connect = ["ground.O", "crank.O"] }
A = { type = "revolute", connect = ["crank.A", "rod.A"], clearance = "c" }
[drivers.motor]
joint = "O"
angle = "w*t"
[initial]
rod = { angle = -1.5, omega = 2 }
A = { offset = [0, "-c"] }
"""


def evaluate(graph, outputs):
    def call(rows_in, rows_out):
        rows_out[:] = graph.evaluate(outputs, rows_in)

    return call


def changed(model, random, spread, count):
    nominal = np.array(list(model.parameters.values()))
    values = nominal[:, None] * (1.0 + spread * random.standard_normal((len(nominal), count)))
    names = list(model.parameters)
    if "l2" in names and "l3" in names:  # the four-bar starts stretched: only with equal lengths can it be put together
        values[names.index("l3")] = values[names.index("l2")]
    return values


@pytest.mark.parametrize("name", SMOOTH)
def test_right_hand_side_and_curves_follow_the_parameters(name):
    m = rt.example(name)
    model = m.recorded(list(m.parameters))
    graph, outputs = lower(model.graph, [model.readable, *model.derivative, *model.curves.values()])
    random = np.random.default_rng(1)
    ny = model.state_size
    for values in changed(model, random, 1e-2, 3).T:
        try:
            system = compile_system(read_at(model, dict(zip(model.parameters, values, strict=True))))
        except rt.ModelError:
            continue
        y = model.start_state + 1e-2 * random.standard_normal(ny)
        t = 0.03
        workspace, rate, row = system.plain_workspace(), np.zeros(ny), np.zeros(width(system))
        derivative.python(workspace, t, y.copy(), rate)
        record.python(workspace, t, y.copy(), row)
        table, _, _ = columns(system, np.array([np.zeros_like(row), row]))
        found = graph.evaluate(outputs, np.concatenate([[t], y, values, [0.0]])[:, None])[:, 0]
        if not (found[0] and found[ny + 1]):  # another form of the model, or next to a singular position
            continue
        forces = np.abs(table[1]).max() / min(one.mass for one in system.model.bodies.values())  # they nearly cancel
        scale = max(np.abs(rate).max(), forces)
        np.testing.assert_allclose(found[1 : ny + 1], rate, rtol=1e-11, atol=1e-12 * scale)
        np.testing.assert_allclose(found[ny + 2 :], table[1], rtol=1e-10, atol=1e-12 * np.abs(table[1]).max())


@pytest.mark.parametrize("name", SMOOTH)
def test_starts_are_those_of_the_assembly(name):
    m = rt.example(name)
    starts = Starts(m.recorded(list(m.parameters)), evaluate)
    values = changed(starts.model, np.random.default_rng(2), np.array([0.0, 1e-6, 1e-3, 1e-2]), 4)
    begun = starts.begin(values)
    assert not begun.assembled[:2].any()  # others may be on another branch
    for n, column in enumerate(values.T):
        want = start_state(*starts.assemble(column))
        np.testing.assert_allclose(begun.y[:, n], want, rtol=0.0, atol=2e-13 * max(1.0, np.abs(want).max()))


@pytest.mark.parametrize(
    ("name", "lacks", "recorded"),
    [
        ("cam_lift_off", [], True),
        ("scotch_yoke", [], True),
        ("gear_rattle", ["idle.omega"], True),  # it begins as teeth without play turn it
        ("slider_crank_play", ["rod.angle", "slider.x"], True),  # with a pin off the middle: likewise
        ("double_pendulum", ["upper.angle"], True),  # which is 0
        ("piston_engine", [], True),  # its angles are rounded, and contradict each other at other parameters
        ("squeezer", [], True),  # likewise, beside a dead centre
        ("fourbar_onesided", [], True),  # likewise, with a motor
        ("wiper", [], True),  # its given angles are far from where its joints close
        ("path_generator", [], True),  # reactions press its pins on their bushes
        ("gripper", [], True),  # which they do not: nothing presses them
        ("torque_converter_epicyclic", [], True),  # its given rates contradict each other at other parameters
        ("crank_rocker_play", [], False),  # likewise, with play
    ],
)
def test_starts_of_samples_are_those_of_their_own_runs(name, lacks, recorded):
    changes = {f"initial.{each}": None for each in lacks}
    if name == "slider_crank_play":
        changes["initial.B.offset"] = [1e-4, 5e-5]
    m = rt.example(name).set(changes)
    starts = Starts(m.recorded(list(m.parameters), contacts=True, lanes=True), evaluate)
    values = changed(starts.model, np.random.default_rng(4), np.array([1e-4, 1e-3, 1e-2]), 3)
    begun, nq = starts.begin(values), 3 * m.system.body_count
    assert begun.assembled.all() != recorded
    for n, column in enumerate(values.T):
        want = m.set(**dict(zip(m.parameters, column.tolist(), strict=True))).start
        np.testing.assert_allclose(begun.y[:nq, n], want.q, rtol=0.0, atol=1e-10)
        np.testing.assert_allclose(
            begun.y[nq : 2 * nq, n], want.v, rtol=0.0, atol=1e-9 * max(1.0, np.abs(want.v).max())
        )


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.machine if name == "squeezer" else ()) for name in SMOOTH]
)
def test_an_assembled_start_has_the_same_bits_read_or_of_a_form(name):
    m = rt.example(name)
    starts = Starts(m.recorded(list(m.parameters)), evaluate)
    (column,) = changed(starts.model, np.random.default_rng(3), np.array([1e-3]), 1).T
    found = [start_state(*starts.assemble(column)) for _ in range(FORM_PAYS + 1)]
    assert all(np.array_equal(one, found[0]) for one in found)


def test_a_parameter_reaches_masses_gravity_drivers_loads_and_the_start_through_expressions():
    m = rt.loads(PENDULUM)
    starts = Starts(m.recorded(["l", "g", "start"]), evaluate)
    l, g, start = 0.6, 9.5, 0.4
    other = m.set(l=l, g=g, start=start)
    begun = starts.begin(np.array([[l], [g], [start]]))
    assert not begun.assembled.any()
    y = begun.y[:, 0]
    np.testing.assert_allclose(y[:6], [*other.start.q, *other.start.v], rtol=1e-14)
    assert y[5] == pytest.approx(np.sqrt(g / l), rel=1e-15)
    model = starts.model
    graph, outputs = lower(model.graph, [model.derivative[5]])
    got = graph.evaluate(outputs, np.concatenate([[0.2], y, [l, g, start, 0.0]])[:, None])[0, 0]
    mass = 2 * l * 1.5
    torque = 0.1 * mass * g * l * np.sin(0.6) - 0.01 * y[5]
    want = (torque - mass * g * l / 2 * np.cos(start)) / (mass * l * l / 3)
    assert got == pytest.approx(want, rel=1e-13)


def test_a_pin_that_starts_at_rest_in_its_bush_has_the_speed_of_the_bush_however_fast_that_turns():
    m = rt.loads(HUNG_ON_A_CRANK)
    begun = Starts(m.recorded(["c", "w"]), evaluate).begin(np.array([[0.02], [7.0]]))
    assert not begun.assembled.any()
    vx, vy, omega = begun.y[9:12, 0]
    assert omega == 2.0
    angle, half = -1.5, 0.25  # of the rod; from its end to its mass centre
    speed = np.array([0.0, 0.3 * 7.0]) + 2.0 * half * np.array([-np.sin(angle), np.cos(angle)])
    np.testing.assert_allclose([vx, vy], speed, atol=1e-14)


def test_samples_that_cannot_be_put_together_have_a_message_and_leave_others_alone():
    m = rt.example("fourbar")
    starts = Starts(m.recorded(["l2", "l3"]), evaluate)
    good = starts.begin(np.array([[0.61], [0.61]])).y[:, 0]
    begun = starts.begin(np.array([[0.61, 0.05, np.nan, 0.61, -1.0], [0.61, 0.6, 0.6, 0.61, 0.6]]))
    assert list(begun.messages) == [1, 2, 4]
    assert "not a finite number" in begun.messages[2]
    assert "positive" in begun.messages[4]
    np.testing.assert_array_equal(begun.y[:, 0], good)
    np.testing.assert_array_equal(begun.y[:, 3], good)
    assert np.isnan(begun.y[:, [1, 2, 4]]).all()


def test_what_reading_assumes_of_a_parameter_is_a_flag():
    m = rt.loads(PENDULUM.replace('torque = "0.1*m', 'torque = "max(l - 0.4, 0.0)*m'))
    model = m.recorded(["l"])
    graph, outputs = lower(model.graph, [model.readable])
    y = np.zeros(model.state_size)

    def readable(l):
        return graph.evaluate(outputs, np.concatenate([[0.0], y, [l, 0.0]])[:, None])[0, 0]

    assert readable(0.5)
    assert readable(0.45)
    assert not readable(-0.5)  # a length must be positive


def test_a_number_that_no_expression_follows_is_found(monkeypatch):
    from rattle.elements.loads import torque

    m = rt.example("fourbar")
    assert m.recorded(["M"]).parameters == {"M": pytest.approx(m.parameters["M"])}
    from rattle.equations import system

    monkeypatch.setattr(system, "array_of", lambda numbers: np.array(numbers, dtype=float))  # loses the record
    with pytest.raises(TraceError, match="those of the kernels differ where 'M' is changed"):
        m.recorded(["M"])
    assert torque


def test_a_driven_mechanism_that_starts_at_rest_under_its_weight_is_recorded():
    """Its accelerations are differences of weights and reactions that cancel: rounding, in the kernels and here."""
    m = rt.example("fourbar").ideal()
    document = m.set(M="0 N*m").to_toml().replace("omega*t", "0.1 + 10*t**3").replace("gravity = [0, 0]", GRAVITY)
    m = rt.loads(document)
    t_eval = np.array([0.05, 0.1])
    slope = m.sensitivity(["rocker.angle"], ["l2"], t_eval, analysis="kinematics")["d(rocker.angle)/d(l2)"]
    l2, step = m.parameters["l2"], 1e-5
    below, above = (m.set(l2=l2 + sign * step).kinematics(t_eval)["rocker.angle"] for sign in (-1.0, 1.0))
    np.testing.assert_allclose(slope, (above - below) / (2.0 * step), rtol=1e-6)  # central differences: step^2


@pytest.mark.filterwarnings("error")
def test_a_driver_whose_acceleration_has_no_value_at_the_start_is_said_and_nothing_else():
    m = rt.loads(rt.example("fourbar").ideal().to_toml().replace("omega*t", "10*t**1.5"))
    with pytest.raises(TraceError, match="no finite value at the start"):
        m.recorded(["l2"])


def test_unknown_parameters_are_named():
    with pytest.raises(KeyError, match="no parameter 'l22'; did you mean 'l2'"):
        rt.example("fourbar").recorded(["l22"])


# ---------------------------------------------------------------- rounding
def kernels(system, t, y):
    """Right-hand side and result columns of the generic kernels, one after the other."""
    workspace, rate, row = system.plain_workspace(), np.zeros(len(y)), np.zeros(width(system))
    derivative.python(workspace, t, y.copy(), rate)
    record.python(workspace, t, y.copy(), row)
    return rate, columns(system, np.array([np.zeros_like(row), row]))[0][1]


def error(found, want):
    """Largest error of right-hand side and columns, as a share of the largest number of each."""
    return max(np.abs(a - b).max() / max(np.abs(b).max(), 1e-300) for a, b in zip(found, want, strict=True))


def require_rounding_only(m, model, seed):
    """The record against the kernels: 1e-13, or ten times what elimination makes of the rounding of y."""
    graph, outputs = lower(model.graph, [*model.derivative, *model.curves.values(), model.sound_curves])
    random, y, t = np.random.default_rng(seed), model.start_state, 0.02
    nq = (len(y) - 2) // 2
    y[nq : 2 * nq] += random.standard_normal(nq)
    found = graph.evaluate(outputs, np.concatenate([[t], y, [0.0]])[:, None])[:, 0]
    assert found[len(y)]
    assert found[-1]
    want = kernels(m.system, t, y)
    wrong = error((found[: len(y)], found[len(y) + 1 : -1]), want)
    if wrong > 1e-13:
        nearby = y * (1.0 + np.finfo(float).eps * random.uniform(-1.0, 1.0, (20, len(y))))
        assert wrong <= 10.0 * max(error(kernels(m.system, t, one), want) for one in nearby)


@pytest.mark.parametrize("name", SMOOTH)
def test_examples_are_recorded_to_rounding(name):
    m = rt.example(name)
    require_rounding_only(m, m.recorded(), 0)


@pytest.mark.long
def test_a_hundred_random_mechanisms_are_recorded_to_rounding():
    recorded = 0
    for seed in range(400):
        try:
            m = at_random.mechanism(seed)
            model = m.recorded()
        except (TraceError, rt.AssemblyError):  # drivers that switch or disagree, redundant rods
            continue
        require_rounding_only(m, model, seed)
        recorded += 1
        if recorded == 100:
            break
    assert recorded == 100


def four_bar(b: float, initial: str, more: str = "", joints: str = "", driver: str = "") -> str:
    """A four-bar of links a = 0.4, b, c = 0.4 on a base of 1 m, at 0.9 rad if it is a parallelogram."""
    return f"""
format = 1
gravity = [0, -9.81]
parameters = {{ g = 1, a = 0.4, b = {b}, c = 0.4, m = 1, w = 5, cl = 1e-3 }}
ground.points = {{ O = [0, 0], D = ["g", 0] }}
bodies.a = {{ bar = ["A", "B"], length = "a", mass = "m" }}
bodies.b = {{ bar = ["B", "C"], length = "b", mass = 0.7 }}
bodies.c = {{ bar = ["D", "C"], length = "c", mass = 0.3 }}
[joints]
O = {{ type = "revolute", connect = ["ground.O", "a.A"] }}
C = {{ type = "revolute", connect = ["b.C", "c.C"] }}
{joints or 'B = { type = "revolute", connect = ["a.B", "b.B"] }'}
D = {{ type = "revolute", connect = ["ground.D", "c.D"]{more} }}
{driver}
[initial]
{initial}
"""


ANGLES = "a = { angle = 0.9 }\nb = { angle = 0 }\nc = { angle = 0.9 }"
LOOSE = 'B = { type = "revolute", connect = ["a.B", "b.B"], clearance = "cl", contact = CONTACT }'
HERTZ = '{ model = "hertz", stiffness = 1e9, exponent = 1.5, restitution = 0.5, bush_radius = 0.02 }'
IMPACT = '{ model = "impact", restitution = 0.3, bush_radius = 0.02 }'
LINK = 'B = { type = "revolute", connect = ["a.B", "b.B"], clearance = "cl", contact = { model = "massless-link" } }'
MOTOR = '[drivers.motor]\njoint = "O"\nangle = "0.9 + w*t"\n'
RATES = ANGLES.replace("0.9 }", '0.9, omega = "w" }', 1).replace("0 }", '0, omega = "w" }')


@pytest.mark.parametrize(
    ("text", "recorded"),
    [
        (four_bar(1.0, ANGLES), True),  # a coupler that does not turn here does elsewhere
        (four_bar(1.0, RATES), False),  # and its rate, contradicted here, has little leverage elsewhere
        (four_bar(1.0, ANGLES, joints=LOOSE.replace("CONTACT", HERTZ)), True),  # whose pin may leave its bush
        (four_bar(1.0, ANGLES, f', clearance = "cl", contact = {IMPACT}', LOOSE.replace("CONTACT", HERTZ)), False),
        (four_bar(1.1, ANGLES.split("\n")[0], f', clearance = "cl", contact = {IMPACT}', LINK, MOTOR), True),
    ],
)
def test_starts_of_samples_of_four_bars_are_those_of_their_own_runs(text, recorded):
    m = rt.loads(text)
    starts = Starts(m.recorded(list(m.parameters), contacts=True), evaluate)
    values = changed(starts.model, np.random.default_rng(4), np.array([1e-6, 1e-5, 1e-4, 1e-3, 1e-2]), 5)
    begun, nq = starts.begin(values), 3 * m.system.body_count
    assert begun.assembled.all() != recorded
    for n in np.flatnonzero(~begun.assembled):
        want = m.set(**dict(zip(m.parameters, values[:, n].tolist(), strict=True))).start
        np.testing.assert_allclose(begun.y[:nq, n], want.q, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(
            begun.y[nq : 2 * nq, n], want.v, rtol=0.0, atol=1e-7 * max(1.0, np.abs(want.v).max())
        )


@pytest.mark.parametrize("angle", [0.3, 1e-2, 1e-3, 1e-4, 1e-5])
def test_contradictory_rates_near_a_dead_centre_keep_the_least_change_side_by_side(angle):
    """vx of a crank at its dead centre hardly moves it: the slider's speed and this one share what they give up."""
    text = f"""
format = 1
parameters = {{ m = 1 }}
ground.points = {{ O = [0, 0] }}
bodies.crank = {{ bar = ["O", "A"], length = 1, mass = "m" }}
bodies.rod = {{ bar = ["A", "B"], length = 2, mass = 0.5 }}
bodies.slider = {{ points = {{ B = [0, 0] }}, mass = 0.3, inertia = 1e-4 }}
[joints]
O = {{ type = "revolute", connect = ["ground.O", "crank.O"] }}
A = {{ type = "revolute", connect = ["crank.A", "rod.A"] }}
B = {{ type = "revolute", connect = ["slider.B", "rod.B"] }}
guide = {{ type = "prismatic", connect = ["ground.O", "slider.B"] }}
[initial]
crank = {{ angle = {angle}, vx = 1 }}
slider = {{ vx = -10 }}
"""
    masses = np.array([1.0, 1.1, 0.9])
    found = rt.loads(text).many({"m": masses}, ["at(crank.omega, 0)"], 1e-6)
    along = np.sin(angle) * np.array([-0.5, -1.0 - np.cos(angle) / np.sqrt(4.0 - np.sin(angle) ** 2)])
    wanted, weights = np.array([1.0, -10.0]), np.stack([masses, np.full(3, 0.3)])
    best = (weights.T * along) @ wanted / ((weights.T * along) @ along)
    np.testing.assert_allclose(found["at(crank.omega, 0)"], best, rtol=1e-8)
