"""Bushings: closed forms, Newton's law for the forces that are recorded, and what is refused."""

import math

import numpy as np
import pytest

import rattle as rt
from rattle.errors import ModelError

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
FINE = {"rtol": 1e-11, "atol": 1e-13}
STIFF = [2e4, 5e3, 300]


def on_ground(**fields):
    """A body of 2 kg and 0.03 kg m^2 that is held off its mass centre."""
    m = rt.Mechanism().ground(O=[0, 0]).body("b", mass=2, inertia=0.03, points={"P": [0.15, 0.05]})
    return m.load("bush", "bushing", connect=["ground.O", "b.P"], **{"stiffness": STIFF, **fields})


def two_bodies(gravity=(0, 0)):
    m = rt.Mechanism(gravity=gravity).body("a", mass=1, inertia=0.02, points={"P": [0.1, 0]})
    m.body("b", mass=2, inertia=0.03, points={"P": [-0.1, 0.02]})
    m.load("bush", "bushing", connect=["a.P", "b.P"], stiffness=STIFF, damping=[20, 10, 0.5], offset=[0.01, 0, 0.1])
    m.initial("a", x=0, y=0, angle=0.3, vx=0, vy=1, omega=4)
    return m.initial("b", x=0.25, y=0.02, angle=-0.2, vx=-1, vy=0, omega=-3)


def refused(m):
    with pytest.raises(ModelError) as error:
        _ = m.model
    return str(error.value)


def test_natural_frequencies_of_a_body_held_off_its_mass_centre():
    """K = J^T diag(k) J with the point's rows J = [1, 0, -b; 0, 1, a; 0, 0, 1], by another program: in Hz."""
    m = on_ground().initial("b", x=-0.15, y=-0.05, angle=0)
    np.testing.assert_allclose(m.modes().omega / math.tau, [6.56089677, 14.35613667, 21.40078038], rtol=1e-8)


@pytest.mark.machine
def test_free_pair_keeps_momentum_and_angular_momentum_and_loses_what_is_damped():
    r = two_bodies().simulate(0.3, t_eval=np.linspace(0, 0.3, 7), **FINE)
    px, py, turn = 0.0, 0.0, 0.0
    for name, mass, inertia in (("a", 1, 0.02), ("b", 2, 0.03)):
        x, y, vx, vy = (r[f"{name}.{key}"] for key in ("x", "y", "vx", "vy"))
        px, py = px + mass * vx, py + mass * vy
        turn = turn + mass * (x * vy - y * vx) + inertia * r[f"{name}.omega"]
    for kept in (px, py, turn):
        np.testing.assert_allclose(kept, kept[0], atol=1e-10)
    total = r["energy.kinetic"] + r["energy.potential"]
    np.testing.assert_allclose(total[0] - total, r["energy.dissipated"], atol=1e-8)
    assert r["energy.dissipated"][-1] > 0.5


@pytest.mark.machine
def test_recorded_forces_are_those_that_accelerate_the_second_body():
    r = two_bodies(gravity=[0, -9.81]).simulate(0.1, t_eval=np.linspace(0, 0.1, 5), **FINE)
    np.testing.assert_allclose(r["bush.fx"], 2 * r["b.ax"], atol=1e-8)
    np.testing.assert_allclose(r["bush.fy"], 2 * (r["b.ay"] + 9.81), atol=1e-8)
    arm_x, arm_y = r["b.P.x"] - r["b.x"], r["b.P.y"] - r["b.y"]
    moment = r["bush.torque"] + arm_x * r["bush.fy"] - arm_y * r["bush.fx"]
    np.testing.assert_allclose(moment, 0.03 * r["b.alpha"], atol=1e-8)
    assert np.abs(r["bush.torque"]).min() > 1.0


@pytest.mark.machine
@pytest.mark.parametrize("turned", [False, True])
def test_a_body_on_a_ground_point_that_moves_starts_where_it_is_without_force(turned):
    """As on a point that stays where that one is at the start."""
    ends = ["b.P", "ground.O"] if turned else ["ground.O", "b.P"]
    starts = []
    for x in ("0.5 + 0.01*sin(t/(0.05 s))", 0.5):
        m = rt.Mechanism().ground(O=[x, 0.3]).body("b", mass=2, inertia=0.03, points={"P": [0.15, 0.05]})
        m.load("bush", "bushing", connect=ends, stiffness=STIFF, offset=[0.01, 0, 0.1])
        run = m.simulate(0.01)
        starts.append([run[f"b.{key}"][0] for key in ("x", "y", "angle", "vx", "ax")])
    np.testing.assert_allclose(starts[0], starts[1], atol=1e-9)
    assert starts[1][0] > 0.3


@pytest.mark.machine
def test_load_displaces_along_the_axes_of_the_first_body_beyond_the_offset():
    """A turns by 0.7 rad and stays there: a force along its x axis gives way by F/k_x, and k_y does not matter."""
    m = rt.Mechanism().ground(O=[0, 0]).body("frame", mass=1, inertia=1, points={"O": [0, 0], "P": [0.3, 0.1]})
    m.fixed("weld", "ground.O", "frame.O", angle=0.7).body("b", mass=2, inertia=0.03, points={"P": [0, 0]})
    offset = [0.002, -0.001, 0.05]
    m.load("bush", "bushing", connect=["frame.P", "b.P"], stiffness=STIFF, offset=offset)
    m.load("F", "force", at="b.P", force=[40 * math.cos(0.7), 40 * math.sin(0.7)])
    m.load("T", "torque", body="b", torque=6).initial("b", x=0.15, y=0.27, angle=0.7)
    rest = m.equilibrium()[0]
    c, s = math.cos(0.7), math.sin(0.7)
    own = np.array([[c, s], [-s, c]]) @ [rest["b.x"], rest["b.y"]] - [0.3, 0.1]
    np.testing.assert_allclose(own, [0.002 + 40 / 2e4, -0.001], atol=1e-12)
    assert rest["b.angle"] == pytest.approx(0.7 + 0.05 + 6 / 300, abs=1e-12)
    assert rest["bush.torque"] == pytest.approx(-6, abs=1e-9)


def test_it_is_one_element_of_power_that_loses_and_keeps_what_the_body_gives():
    m = on_ground(damping=[20, 8, 0.5]).initial("b", x=-0.15, y=-0.05, angle=0, vx=0.3, vy=0, omega=5)
    r = m.simulate(0.2, **FINE)
    (bush,) = r.power().elements.itertuples()
    gave = r["energy.kinetic"][0] - r["energy.kinetic"][-1]
    assert bush.lost == pytest.approx(r["energy.dissipated"][-1], abs=1e-9)
    assert (bush.supplied, bush.lost + bush.stored) == (0.0, pytest.approx(gave, abs=1e-9))


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"stiffness": [1e4, -1, 3]}, ("loads.bush.stiffness[1]: -1 must not be negative",)),
        ({"damping": [0, 0, "-1 N*m*s/rad"]}, ("loads.bush.damping[2]", "must not be negative")),
        ({"stiffness": 1e4}, ("expected [x, y, angle] in N/m, N/m, N*m/rad",)),
        ({"stiffness": [1e4, 1e4]}, ("expected [x, y, angle] in N/m, N/m, N*m/rad",)),
        ({"stiffness": [1, 1, "3 N/m"]}, ("N*m/rad",)),
        ({"offset": ["1 deg", 0, 0]}, ("offset",)),
        ({"stiffness": ["1e4 + t", 1, 1]}, ("t",)),
        ({"stifness": [1, 1, 1]}, ("stifness", "stiffness")),
    ],
)
def test_wrong_values_are_refused_with_their_place(fields, words):
    told = refused(on_ground(**fields))
    assert "loads.bush" in told
    assert all(word in told for word in words)


def test_units_and_parameters_are_those_of_three_different_directions():
    plain = on_ground(damping=[20, 8, 0.5], offset=[0.001, 0, 0.1])
    worded = on_ground(
        stiffness=["20 N/mm", "k/4", "300 N*m/rad"], damping=["20 N*s/m", 8, "0.5 N*m*s/rad"],
        offset=["1 mm", 0, "0.1 rad"],
    ).parameter("k", 2e4)  # fmt: skip
    r, s = (m.simulate(0.05, t_eval=[0.05], **FINE) for m in (plain, worded))
    assert [r[f"b.{key}"][0] for key in ("x", "y", "angle")] == [s[f"b.{key}"][0] for key in ("x", "y", "angle")]
    assert r["b.angle"][0] != 0.0


def test_expressions_know_its_forces():
    m = on_ground().signal("size", "hypot(bush.fx, bush.fy) + 1 N").initial("b", x=-0.14, y=-0.05, angle=0)
    r = m.simulate(0.01, t_eval=[0.0])
    assert r["size"][0] == pytest.approx(2e4 * 0.01 + 1)
    assert "already used" in refused(on_ground().signal("bush", "1"))


def test_torque_of_a_motor_against_a_bushing_and_a_cord():
    """By inverse dynamics and by hand: I alpha, the bushing's spring and damper, the cord's pull where it is taut."""
    m = rt.Mechanism().ground(O=[0, 0], A=[0.5, 0.2]).bar("arm", "O", "E", length=0.4, mass=1)
    m.revolute("h", "ground.O", "arm.O").driver("d", "h", angle="sin(3*t)")
    m.load(
        "bush", "bushing", connect=["ground.O", "arm.O"], stiffness=[1, 1, 7], damping=[0, 0, 0.2], offset=[0, 0, 0.1]
    )
    cord = {"stiffness": 300, "free_length": 0.3, "damping": 5, "tension_only": True}
    m.load("cord", "spring", connect=["ground.A", "arm.E"], **cord)
    t = np.linspace(0, 2, 41)
    angle, rate, change = np.sin(3 * t), 3 * np.cos(3 * t), -9 * np.sin(3 * t)
    x, y = 0.4 * np.cos(angle), 0.4 * np.sin(angle)
    length = np.hypot(x - 0.5, y - 0.2)
    pull = 300 * (length - 0.3) + 5 * rate * ((y - 0.2) * x - (x - 0.5) * y) / length
    pull = np.where(length > 0.3, np.maximum(pull, 0), 0) / length
    torque = 0.16 / 3 * change + 7 * (angle - 0.1) + 0.2 * rate + pull * (x * (y - 0.2) - y * (x - 0.5))
    r = m.inverse_dynamics(t)
    np.testing.assert_allclose(r["d.torque"], torque, atol=1e-12)
    assert 5 < r["cord.slack"].sum() < 35
