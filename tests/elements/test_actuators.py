"""Actuators and motors: closed forms, and what a motor that can move nothing is told."""

import numpy as np
import pytest

import rattle as rt
from rattle.errors import ModelError

pytestmark = [pytest.mark.nojit, pytest.mark.plain]
FINE = {"rtol": 1e-11, "atol": 1e-13}
T = np.array([0.0, 0.3, 1.0])


def wheels(**more):
    """A housing of 2 kg m^2 and a rotor of 0.5 kg m^2 on one axis."""
    m = rt.Mechanism(**more).ground(O=[0, 0])
    for name, inertia in (("housing", 2), ("rotor", 0.5)):
        m.body(name, mass=1, inertia=inertia, points={"C": [0, 0]}).revolute(f"{name}_pin", "ground.O", f"{name}.C")
    return m


def refused(m):
    with pytest.raises(ModelError) as error:
        _ = m.model
    return str(error.value)


def test_motor_with_a_falling_line_of_torque_reaches_its_speed_exponentially_and_keeps_the_angular_momentum():
    r = wheels().motor("M", "housing", "rotor", torque="3*(1 - speed/10)").simulate(1.0, t_eval=T, **FINE)
    speed = 10 * (1 - np.exp(-0.3 * (1 / 2 + 1 / 0.5) * T))  # T0 (1 - s/s0) on the reduced inertia
    np.testing.assert_allclose(r["rotor.omega"] - r["housing.omega"], speed, atol=1e-10)
    np.testing.assert_allclose(2 * r["housing.omega"] + 0.5 * r["rotor.omega"], 0.0, atol=1e-12)
    np.testing.assert_allclose(r["energy.kinetic"], r["energy.work"], atol=1e-9)


def test_speed_of_a_motor_on_the_ground_is_the_rate_of_its_rotor():
    motors = {"speed": "2 - 0.1*speed", "omega": "2 - 0.1*rotor.omega"}
    one, two = (
        wheels().motor("M", "ground", "rotor", torque=line).simulate(0.3, t_eval=[0.3]) for line in motors.values()
    )
    assert one["rotor.omega"] == two["rotor.omega"] > 1.0


def test_cylinder_that_pushes_a_mass_with_a_falling_force():
    m = rt.Mechanism().ground(O=[0, 0], A=[-0.5, 0]).body("ram", mass=4, inertia=1, points={"C": [0, 0]})
    m.prismatic("guide", "ground.O", "ram.C", axis=0, angle=0).actuator(
        "push", "ground.A", "ram.C", force="30 - 8*ram.vx"
    )
    r = m.initial("ram", x=0, vx=0).simulate(1.0, t_eval=T, **FINE)
    v = 3.75 * (1 - np.exp(-2 * T))
    np.testing.assert_allclose(r["ram.vx"], v, atol=1e-10)
    np.testing.assert_allclose(r["energy.work"], 2 * v * v, atol=1e-9)


def test_cylinder_between_two_bodies_holds_a_lid_at_the_angle_where_moments_balance():
    """Lid of 1 m and 2 kg, cylinder from (0.3, -0.2) of the ground to 0.4 m on the lid: F x arm = m g cos/2."""
    m = (
        rt.Mechanism(gravity=[0, -9.81])
        .ground(O=[0, 0], F=[0.3, -0.2])
        .bar("lid", "O", "E", length=1, mass=2, points={"P": [-0.1, 0]})
    )
    m.revolute("hinge", "ground.O", "lid.O").actuator("gas", "ground.F", "lid.P", force=60).initial("lid", angle=0.4)
    rests = m.equilibrium()
    assert len(rests) > 0
    for r in rests:
        angle = r["lid.angle"]
        P, F = 0.4 * np.array([np.cos(angle), np.sin(angle)]), np.array([0.3, -0.2])
        n = (P - F) / np.hypot(*(P - F))
        assert 60 * (P[0] * n[1] - P[1] * n[0]) == pytest.approx(2 * 9.81 * 0.5 * np.cos(angle), abs=1e-9)


def test_coincident_ends_of_a_cylinder_have_no_direction_and_no_force():
    m = rt.Mechanism().ground(O=[0, 0]).body("ram", mass=4, inertia=1, points={"C": [0, 0]})
    r = m.actuator("push", "ground.O", "ram.C", force=30).initial("ram", x=0, y=0).simulate(0.1, t_eval=[0.1])
    assert (r["ram.x"][0], r["ram.vx"][0]) == (0.0, 0.0)


@pytest.mark.parametrize("ends", [("ground", "ground"), ("rotor", "rotor")])
def test_motor_on_one_body_twice_is_refused(ends):
    assert f"both ends are on '{ends[0]}'; expected two different bodies" in refused(
        wheels().motor("M", *ends, torque=1)
    )


def test_motor_between_bodies_that_keep_their_angle_is_refused_with_the_joints_that_keep_it():
    m = wheels().body("cap", mass=1, inertia=1, points={"C": [0, 0]}).fixed("weld", "rotor.C", "cap.C")
    m.body("box", mass=1, inertia=1, points={"C": [0, 0]}).prismatic("rail", "cap.C", "box.C", axis=0)
    said = refused(m.motor("M", "rotor", "box", torque=1))
    assert "loads.M.connect: 'weld' and 'rail' keep 'rotor' and 'box' from turning against each other" in said


def test_motor_between_two_bodies_without_joints_is_refused():
    m = wheels()
    for name in ("one", "two"):
        m.body(name, mass=1, inertia=1, points={"C": [0, 0]})
    assert "neither 'one' nor 'two' has a joint" in refused(m.motor("M", "one", "two", torque=1))


def test_local_name_of_a_motor_is_known_in_its_torque_only_and_must_not_be_that_of_something_else():
    assert "unknown name 'speed' in '2*speed'" in refused(wheels().load("L", "torque", body="rotor", torque="2*speed"))
    m = wheels().motor("M", "housing", "rotor", torque="1 - speed")
    assert "here 'speed' has a meaning of its own; give the parameter 'speed' another name" in refused(
        m.parameter("speed", 3)
    )


def test_units_of_local_names_are_checked():
    m = wheels().parameter("k", "1 N*m*s").motor("M", "housing", "rotor", torque="k*speed**2")
    assert "loads.M.torque: 'k*speed**2' is" in refused(m)


def test_loads_given_by_instants_and_values_follow_straight_lines_between_them():
    """A torque from 0 to 2 N m in 1 s, back to 0 in 0.5 s: w = integral/J; a force along x in the same way."""
    t, push = np.array([0.0, 1.0, 1.5]), np.array([0.0, 2.0, 0.0])
    m = wheels().load("M", "torque", body="rotor", torque=(t, push)).body("ball", mass=2, inertia=1, points={})
    r = m.load("F", "force", at="rotor.C", force=[(t, push), 1]).simulate(1.5, t_eval=[0.5, 1.0, 1.5])
    np.testing.assert_allclose(r["rotor.omega"], np.array([0.25, 1.0, 1.5]) / 0.5, atol=1e-12)
    np.testing.assert_allclose([r["rotor_pin.fx"][1], r["rotor_pin.fy"][1]], [-2, -1], atol=1e-12)
    assert rt.loads(m.to_toml()).model.loads["M"].kind == "torque"  # a table is part of the file


def test_a_spring_whose_ends_coincide_has_no_force_and_an_actuator_no_rate():
    """At no length there is no direction: F = k l + c l' begins at its limit 0, and the motion is that of free fall."""
    m = rt.Mechanism("hung", gravity=[0, -9.81]).ground(O=[0, 0]).body("b", points={"P": [0, 0]}, mass=1, inertia=1)
    m.load("s", "spring", connect=["ground.O", "b.P"], stiffness=100, damping=2)
    m.load("a", "actuator", connect=["ground.O", "b.P"], force="-3*a.rate")
    r = m.simulate(0.01)
    assert [r[name][0] for name in ("s.force", "s.rate", "s.length", "s.power", "a.rate", "a.force")] == [0.0] * 6
    assert r["b.y"][-1] == pytest.approx(-0.5 * 9.81 * 1e-4, rel=0.02)
