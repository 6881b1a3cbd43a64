"""Power between elements and bodies: conserved in every run, and closed forms of energies."""

import math

import numpy as np
import pytest

import rattle as rt
from rattle.loading import examples
from rattle.questions.power.compute import Power
from rattle.questions.power.cycle import parts
from rattle.questions.power.steps import rows_at

SPAN = 0.02  # [s]: some steps of every example
AT_REST = 1e-13  # [J]: what a mechanism that stands exchanges by rounding

TURNED = """
format = 1
[bodies.disc]
points = { C = [0, 0] }
center = [0, 0]
mass = 1
inertia = 0.5
[joints.O]
type = "revolute"
connect = ["ground.O", "disc.C"]
"""
DRIVEN = TURNED + '[ground.points]\nO = [0, 0]\n[drivers.motor]\njoint = "O"\nangle = "ANGLE"\n'
PENDULUM = """
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.rod]
bar = ["O", "E"]
length = 1
mass = 1
[joints.O]
type = "revolute"
connect = ["ground.O", "rod.O"]
stop = { min = "-90 deg", max = "180 deg", contact = { model = "impact", restitution = 0.5 } }
[initial]
rod = { angle = 0, omega = 0 }
"""
SPRUNG = """
format = 1
[ground.points]
O = [0, 0]
[bodies.block]
points = { C = [0, 0] }
center = [0, 0]
mass = 1
inertia = 1
[joints.guide]
type = "prismatic"
connect = ["ground.O", "block.C"]
axis = 0
angle = 0
[loads.spring]
type = "spring"
connect = ["ground.O", "block.C"]
stiffness = 100
damping = 1.2
[initial]
block = { x = 0.1, vx = 0 }
"""


def of(frame, column, element, body=None):
    rows = frame[frame["element"] == element]
    return float((rows if body is None else rows[rows["body"] == body])[column].iloc[0])


@pytest.mark.parametrize("name", list(examples()))
def test_power_is_conserved_in_every_example(name):
    r = rt.example(name).simulate(SPAN)
    p = r.power(0.0, SPAN)
    one, ports = p.cycle, p._ports
    turnover = one.into.sum() + one.out.sum()
    largest = float(np.abs(one.peak).max(initial=0.0))
    # accelerations are those of the solve, so that what a body gets is what it keeps, up to rounding
    assert p.residual <= 1e-13 * largest
    if turnover < AT_REST:
        assert name == "gripper"  # which hangs where its play lets it
        return
    # the run has steps to 1e-8, and its own sums of work and losses do not choose them; radau has few of them
    near = 1e-6 if r.provenance["method"] == "radau" else 1e-7
    for k, (body, masses) in enumerate(zip(ports.bodies, ports.system.arrays["mass"][1:], strict=True), 1):
        kinetic = 0.5 * masses @ np.array([r[f"{body}.{rate}"] ** 2 for rate in ("vx", "vy", "omega")])
        mine = [port.body == k for port in ports.list]
        gained = (one.into - one.out)[mine].sum()
        assert gained == pytest.approx(kinetic[-1] - kinetic[0], rel=near, abs=near * turnover), body
    assert one.supplied.sum() == pytest.approx(r["energy.work"][-1], rel=near, abs=near * turnover)
    assert one.lost.sum() == pytest.approx(r["energy.dissipated"][-1], rel=near, abs=near * turnover)
    net = np.bincount(ports.of_element, one.into - one.out, minlength=len(one.lost))
    kept = one.supplied - one.lost - one.stored
    if r.provenance["method"] == "moreau":  # its losses and drivers are of order one in the step
        assert kept == pytest.approx(net, abs=1e-2 * turnover)
    else:
        assert kept == pytest.approx(net, abs=0.01 * near * turnover)


def test_parts_of_a_power_that_changes_its_sign_in_a_step():
    """Random polynomials in steps of several lengths, against a fine sum of their positive parts."""
    rng = np.random.default_rng(7)
    half = np.array([0.5, 0.02, 1.0])
    points, _ = np.polynomial.legendre.leggauss(8)
    series = rng.normal(size=(8, 3, 5)) / 2.0 ** np.arange(8)[:, None, None]
    values = np.polynomial.legendre.legval(points, series).transpose(0, 2, 1)
    positive, net, extreme = parts(values, half)
    x = (np.arange(200_000) + 0.5) / 100_000 - 1.0
    fine = np.polynomial.legendre.legval(x, series)  # (steps, ports, instants)
    assert positive == pytest.approx(np.einsum("s,spx->p", half, np.maximum(fine, 0.0)) * 1e-5, abs=1e-9)
    assert net == pytest.approx(np.einsum("s,spx->p", half, fine) * 1e-5, abs=1e-9)
    assert np.abs(extreme) == pytest.approx(np.abs(fine).max(axis=(0, 2)), rel=2e-3)


def test_outputs_do_not_change_the_run():
    r = rt.example("fourbar_onesided").simulate(0.05)
    p = r.power(0.0, 0.05)
    rows = rows_at(p._mechanism, p._settings, r.t)
    assert (rows[:, 0] == r[r.stored[0]]).all()
    fine = p.cycle
    coarse = rt.example("fourbar_onesided").simulate(0.05, t_eval=[0.05]).power(0.0, 0.05).cycle
    assert (fine.into == coarse.into).all()
    assert (fine.lost == coarse.lost).all()


def test_powers_of_the_four_bar_at_an_instant():
    """Reactions of a kinematic solution by hand, design of the paper without play, a moment of 40 N*m."""
    p = rt.example("fourbar").ideal().set({"gravity": [0, 0]}).simulate(0.2 * math.pi, rtol=1e-10).power()
    assert (p.t0, p.t1) == pytest.approx((0.0, 0.2 * math.pi))
    found = p.at(0.1)
    expected = {("motor", "crank"): -8.96981020, ("O2", "coupler"): -8.96981020, ("O3", "rocker"): -31.81435051}
    for (element, body), power in expected.items():
        assert of(found, "power", element, body) == pytest.approx(power, abs=2e-7)
    assert np.abs(p.table["net"]).max() < 1e-8  # what is put in comes back in every turn
    motor = of(p.table, "E_in", "motor"), of(p.table, "E_out", "motor")
    assert motor == pytest.approx((54.503454 / 2,) * 2, rel=1e-6)
    assert of(p.table, "recirculated", "motor") == pytest.approx(min(motor), rel=1e-12)
    assert of(p.table, "peak", "motor") == pytest.approx(167.6446, rel=1e-5)


def test_a_steady_motor_gives_what_a_viscous_brake_takes():
    text = (
        DRIVEN.replace("ANGLE", "10*t") + '[loads.oil]\ntype = "torque"\nbody = "disc"\ntorque = "-0.05*disc.omega"\n'
    )
    p = rt.loads(text).simulate(2.0).power()
    turn = 0.2 * math.pi
    assert p.t1 - p.t0 == pytest.approx(turn)
    assert of(p.elements, "supplied", "motor") == pytest.approx(0.05 * 10**2 * turn, rel=1e-12)
    assert of(p.elements, "supplied", "oil") == pytest.approx(-0.05 * 10**2 * turn, rel=1e-12)


def test_positive_and_negative_parts_of_an_oscillation():
    """A driven disc, angle sin(w t): power J w^3 sin(2 w t)/2, half of J w^2/2 in and out twice a period."""
    w = 3.0
    r = rt.loads(DRIVEN.replace("ANGLE", f"sin({w}*t)")).simulate(2 * math.pi / w, rtol=1e-10)
    p = r.power(0.0, 2 * math.pi / w)
    assert of(p.table, "E_in", "motor") == pytest.approx(0.5 * w**2, rel=1e-9)
    assert of(p.table, "E_out", "motor") == pytest.approx(0.5 * w**2, rel=1e-9)
    assert abs(of(p.table, "peak", "motor")) == pytest.approx(0.25 * w**3, rel=1e-4)  # between samples of the step


def test_a_stop_loses_what_its_restitution_says():
    p = rt.loads(PENDULUM).simulate(3.5, rtol=1e-11, atol=1e-13).power()
    assert of(p.elements, "lost", "O") == pytest.approx(4.905 * (1 - 0.25**4), abs=1e-9)  # four impacts
    assert of(p.elements, "stored", "gravity") == pytest.approx(-of(p.table, "net", "gravity"), rel=1e-12)


def test_a_damped_spring_stores_and_loses():
    p = rt.loads(SPRUNG).simulate(1.0, rtol=1e-11, atol=1e-13).power(0.3, 0.9)
    k, c, x0 = 100.0, 1.2, 0.1
    d, w = c / 2, math.sqrt(k - (c / 2) ** 2)

    def state(t):
        x = x0 * math.exp(-d * t) * (math.cos(w * t) + d / w * math.sin(w * t))
        return x, -x0 * math.exp(-d * t) * (w + d * d / w) * math.sin(w * t)

    (xa, va), (xb, vb) = state(0.3), state(0.9)
    stored = 0.5 * k * (xb**2 - xa**2)
    assert of(p.elements, "stored", "spring") == pytest.approx(stored, abs=1e-10)
    assert of(p.elements, "lost", "spring") == pytest.approx(-stored - 0.5 * (vb**2 - va**2), abs=1e-10)


def test_a_jump_of_a_driver_is_its_work():
    r = rt.loads(DRIVEN.replace("ANGLE", "2*t + 8*max(0, t - 0.5)")).simulate(1.0)
    p = r.power(0.0, 1.0)
    assert of(p.elements, "supplied", "motor") == pytest.approx(0.25 * (10**2 - 2**2), rel=1e-12)
    assert r.power(0.0, 0.4).cycle.into.sum() == pytest.approx(0.0, abs=1e-12)


def test_a_result_on_file_holds_what_powers_need(tmp_path):
    r = rt.loads(PENDULUM).set({"bodies.rod.mass": 2}).simulate(1.0)
    r.save(tmp_path / "out.npz")
    again = rt.load_result(tmp_path / "out.npz").power()
    assert again.table.equals(r.power().table)


def test_powers_that_cannot_be_found_say_why():
    m = rt.loads(DRIVEN.replace("ANGLE", "10*t"))
    with pytest.raises(ValueError, match="motion in time"):
        m.kinematics([0.0, 1.0]).power()
    r = m.simulate(1.0)
    with pytest.raises(ValueError, match="in order between 0 and the end, 1 s"):
        r.power(0.5, 2.0)
    with pytest.raises(ValueError, match="within the run"):
        r.power().at(3.0)
    del r.provenance["document"]
    with pytest.raises(ValueError, match="does not hold its model"):
        r.power()
    assert isinstance(m.simulate(1.0).power(), Power)


def test_friction_of_joints_loses_what_the_brake_torque_says():
    text = (
        TURNED.replace("inertia = 0.5", "inertia = 0.001")
        .replace("mass = 1", "mass = 2")
        .replace("[bodies.disc]", "gravity = [0, -9.81]\n[bodies.disc]")
    )
    text += (
        'friction = { mu = 0.1, pin_radius = "8 mm" }\n[ground.points]\nO = [0, 0]\n[initial]\ndisc = { omega = 10 }\n'
    )
    run = rt.loads(text).simulate(1.0, t_eval=[0, 0.3, 1.0])
    power = run.power(0, 1.0)
    torque = 0.1 * 2 * 9.81 * 0.008  # Coulomb at the pin, R = m g: N mu r
    assert of(power.elements, "lost", "O") == pytest.approx(0.5 * 0.001 * 100, rel=1e-9)  # all of the energy
    assert of(power.at(0.3), "power", "O", "disc") == pytest.approx(-torque * (10 - torque / 0.001 * 0.3), rel=1e-9)
    assert power.residual < 1e-9


def test_a_run_that_a_stop_ends_has_powers_up_to_there():
    """A disc driven at 100 rad/s^2 onto its stop at 0.5 rad: the motor has given J w^2/2 at w = 10 rad/s."""
    m = rt.loads(DRIVEN.replace("ANGLE", "50*t**2")).set({"joints.O.stop": {"max": 0.5}})
    r = m.simulate(1.0, rtol=1e-10)
    assert not r.success
    p = r.power()
    assert p.t1 == pytest.approx(0.1, rel=1e-9)
    assert p.elements.set_index("element").supplied["motor"] == pytest.approx(25.0, rel=1e-9)


def test_powers_are_known_up_to_where_friction_locks():
    """A parallelogram jams before its bars are in line; the last steps of its run are as short as rounding."""
    m = rt.Mechanism(gravity=[0, -9.81]).ground(O=[0, 0], Q=[0.4, 0])
    m = (
        m.bar("a", "O", "A", length=0.2, mass=1)
        .bar("b", "Q", "B", length=0.2, mass=1)
        .bar("c", "A", "B", length=0.4, mass=1)
    )
    rubs = {"model": "coulomb", "mu": 0.3, "pin_radius": 0.02}
    for name, one, two in (
        ("O", "ground.O", "a.O"),
        ("A", "a.A", "c.A"),
        ("B", "b.B", "c.B"),
        ("Q", "ground.Q", "b.Q"),
    ):
        m.revolute(name, one, two, friction=rubs)
    r = m.initial("a", angle=0.8).initial("b", angle=0.8).simulate(1.0, rtol=1e-10)
    assert "friction locks" in r.message
    p = r.power(0.0, float(r.t[-1]))
    assert p.elements.lost.sum(skipna=False) == pytest.approx(r["energy.dissipated"][-1], rel=1e-6)
    whole = r.power()
    assert whole.t1 > r.t[-1]
    assert np.isfinite(whole.elements.lost).all()
