"""Dry friction of a stated size, whatever the joint bears, against closed forms and an independent integration."""

from __future__ import annotations

from math import asin, cos, sin

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rattle as rt

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

FINE = {"rtol": 1e-11, "atol": 1e-13}
G = 9.81
TORQUE = '{ torque = "brake" }'


def pendulum(friction: str = TORQUE, start: str = "angle = 1.2", more: str = "", gravity: float = G) -> str:
    """A body of 1 kg that hangs 0.3 m below its pin, with 0.4 N m of friction."""
    return f"""
format = 1
gravity = [0, {-gravity}]
ground.points = {{ O = [0, 0] }}
parameters = {{ brake = "0.4 N*m" }}
bodies.bob = {{ points = {{ O = [0, 0.3], T = [0, 0] }}, center = [0, 0], mass = 1, inertia = 0.02 }}
joints.pin = {{ type = "revolute", connect = ["ground.O", "bob.O"], friction = {friction} }}
initial.bob = {{ {start} }}
{more}
"""


def slider(friction: str = '{ force = "3 N" }', more: str = "", kind: str = "prismatic") -> str:
    """A block of 2 kg that slides at 3 m/s along a line without weight."""
    return f"""
format = 1
gravity = [0, 0]
ground.points = {{ O = [0, 0] }}
bodies.block = {{ points = {{ P = [0, 0] }}, mass = 2, inertia = 1 }}
joints.rail = {{ type = "{kind}", connect = ["ground.O", "block.P"], axis = 0, friction = {friction}{more} }}
initial.block = {{ x = 0, vx = 3 }}
"""


def test_a_pendulum_swings_against_its_brake_until_it_holds() -> None:
    """Against each half swing by itself, (I + m l^2) phi'' = -m g l sin phi -+ M, by SciPy."""
    m, times = rt.loads(pendulum()), []
    r = m.simulate(12.0, **FINE)
    phi, sense, t, size = 1.2, -1.0, 0.0, 0.02 + 0.3**2
    while abs(G * 0.3 * sin(phi)) > 0.4:

        def swing(t: float, y: np.ndarray, s: float = sense) -> list[float]:
            return [y[1], (-G * 0.3 * sin(y[0]) - 0.4 * s) / size]

        def turns(t: float, y: np.ndarray, s: float = sense) -> float:
            return float(y[1]) if t > 1e-3 else s

        turns.terminal = True  # type: ignore[attr-defined]
        way = solve_ivp(swing, (0.0, 5.0), [phi, 0.0], events=turns, rtol=1e-12, atol=1e-13)
        t, phi, sense = t + way.t[-1], way.y[0, -1], -sense
        times.append(t)
    turned = [event.t for event in r.events if event.joint == "pin"]
    assert len(turned) == len(times) > 3
    assert turned == pytest.approx(times, abs=1e-8)
    assert r["bob.angle"][-1] == pytest.approx(phi, abs=1e-9)
    assert abs(r["bob.omega"][-1]) < 1e-13
    assert r["energy.dissipated"][-1] == pytest.approx(G * 0.3 * (cos(phi) - cos(1.2)), abs=1e-8)
    assert np.abs(r["energy.balance"]).max() < 1e-8


@pytest.mark.parametrize("kind", ["prismatic", "slot"])
def test_a_slider_stops_where_its_energy_is_used_up(kind: str) -> None:
    """In m v0^2/(2 F) = 3 m, whatever presses on it: a weight across the line changes nothing."""
    for gravity in ("[0, 0]", "[0, -50]"):
        text = slider(kind=kind, more="").replace("gravity = [0, 0]", f"gravity = {gravity}")
        r = rt.loads(text).simulate(3.0, t_eval=[0, 1, 3], **FINE)
        assert r["block.x"] == pytest.approx([0, 2.25, 3.0], abs=1e-9)
        assert r["rail.friction"] == pytest.approx([-3, -3, 0], abs=1e-9)


def test_it_has_no_share_in_an_impact() -> None:
    """A slider between stops: half of its speed is left by each, friction takes 2 F d / m of v^2 between them."""
    stop = ', stop = { min = -0.2, max = 0.2, contact = { model = "impact", restitution = 0.5 } }'
    r = rt.loads(slider(more=stop)).simulate(3.0, **FINE)
    speeds = [event.normal_speed for event in r.events if event.kind == "impact"]
    v = [np.sqrt(9 - 2 * 3 * 0.2 / 2)]
    while (v[-1] / 2) ** 2 > 2 * 3 * 0.4 / 2:
        v.append(np.sqrt((v[-1] / 2) ** 2 - 2 * 3 * 0.4 / 2))
    assert speeds == pytest.approx(v, abs=1e-9)
    rest = (0.2 - (v[-1] / 2) ** 2 / 3) * (1 if len(v) % 2 else -1)
    assert r["block.x"][-1] == pytest.approx(rest, abs=1e-9)


def test_what_it_holds_at_rest_is_its_size_either_way() -> None:
    push = 'loads.M = { type = "torque", body = "bob", torque = 1.5 }'
    m = rt.loads(pendulum(start="angle = 0.5", more=push))
    held = m.holds("M")
    assert [held.low, held.high] == pytest.approx([G * 0.3 * sin(0.5) - 0.4, G * 0.3 * sin(0.5) + 0.4], abs=1e-9)
    band = rt.loads(pendulum(start="angle = 0.1")).dead_band()
    assert band["pin.angle"] == pytest.approx([-asin(0.4 / (G * 0.3)), asin(0.4 / (G * 0.3))], abs=1e-9)


def test_beside_friction_by_the_reaction() -> None:
    """A brake and a rubbing pin on one shaft of two bodies: the load that both hold is the sum."""
    text = """
format = 1
gravity = [0, -9.81]
ground.points = { O = [0, 0], Q = [1, 0] }
bodies.a = { points = { O = [0, 0] }, mass = 2, inertia = 0.02 }
bodies.b = { points = { Q = [0, 0] }, mass = 3, inertia = 0.02 }
joints.O = { type = "revolute", connect = ["ground.O", "a.O"], friction = { mu = 0.2, pin_radius = 0.05 } }
joints.Q = { type = "revolute", connect = ["ground.Q", "b.Q"], friction = { torque = 0.7 } }
joints.couple = { type = "gear", connect = ["a.O", "b.Q"], radii = [0.5, 0.5] }
loads.M = { type = "torque", body = "a", torque = 0.1 }
"""
    held = rt.loads(text).holds("M")
    teeth = 0.7 / 0.5  # [N] they press the pin down if the moment is positive, and lift it otherwise
    wanted = [-0.7 - 0.2 * 0.05 * (2 * G - teeth), 0.7 + 0.2 * 0.05 * (2 * G + teeth)]
    assert [held.low, held.high] == pytest.approx(wanted, abs=1e-9)


def test_a_driver_feels_it_in_inverse_dynamics() -> None:
    m = rt.loads(pendulum(more='drivers.turn = { joint = "pin", angle = "1 + sin(t)" }'))
    t = np.array([0.0, 1.0, 2.5])
    r = m.inverse_dynamics(t)
    phi, sense = 1 + np.sin(t), np.sign(np.cos(t))
    wanted = (0.02 + 0.09) * -np.sin(t) + G * 0.3 * np.sin(phi) + 0.4 * sense
    assert r["turn.torque"] == pytest.approx(wanted, abs=1e-9)
    assert r["pin.friction"] == pytest.approx(-0.4 * sense, abs=1e-9)


@pytest.mark.parametrize(
    ("friction", "words"),
    [
        ('{ torque = "2 N*m", mu = 0.1 }', ("torque", "mu", "one or the other")),
        ('{ torque = 2, pin_radius = "5 mm" }', ("torque", "pin_radius")),
        ('{ force = "2 N" }', ("revolute", "torque", "N*m")),
        ('{ torque = "2 N" }', ("'2 N' is a force",)),
        ("{ torque = -2 }", ("must not be negative",)),
    ],
)
def test_a_size_beside_a_coefficient_and_that_of_another_joint_are_refused(friction: str, words: tuple[str]) -> None:
    with pytest.raises(rt.ModelError) as refusal:
        rt.loads(pendulum(friction))
    assert all(word in str(refusal.value) for word in words)


def test_a_joint_without_a_coordinate_has_none() -> None:
    rod = 'joints.link = { type = "rod", connect = ["ground.O", "bob.T"], length = 0.3, friction = { torque = 1 } }'
    with pytest.raises(
        rt.ModelError, match=r"a rod has no coordinate to brake; expected revolute or prismatic or slot"
    ):
        rt.loads(pendulum(more=rod))
    with pytest.raises(rt.ModelError, match=r"prismatic joint slides: write force"):
        rt.loads(slider("{ torque = 1 }"))


@pytest.mark.machine
def test_in_the_plane_of_a_turning_guide_it_acts_along_the_guide() -> None:
    """A bead on a bar that turns at w: x'' = w^2 x - F/m while it moves outwards; from rest it holds m w^2 x < F."""
    text = """
format = 1
gravity = [0, 0]
ground.points = { O = [0, 0] }
bodies.bar = { points = { O = [0, 0] }, mass = 1, inertia = 1 }
bodies.bead = { points = { P = [0, 0] }, mass = 0.5, inertia = 0.001 }
joints.O = { type = "revolute", connect = ["ground.O", "bar.O"] }
joints.rail = { type = "prismatic", connect = ["bar.O", "bead.P"], axis = 0, friction = { force = 1 } }
drivers.turn = { joint = "O", angle = "4*t" }
initial.bead = { x = 0.1, vy = 0.4 }
"""
    r = rt.loads(text).simulate(1.0, t_eval=[0, 1.0], **FINE)
    assert r["rail.position"] == pytest.approx([0.1, 0.1], abs=1e-10)  # 0.5 16 0.1 = 0.8 N
    far = text.replace("x = 0.1, vy = 0.4", "x = 0.2, vy = 0.8")
    r = rt.loads(far).simulate(0.4, t_eval=[0, 0.4], **FINE)
    at_rest = 1 / (0.5 * 16)
    assert r["rail.position"][-1] == pytest.approx(at_rest + (0.2 - at_rest) * np.cosh(4 * 0.4), rel=1e-9)


@pytest.mark.machine
def test_a_jerk_sets_a_held_slider_going() -> None:
    """1 kg at 3 m/s jerks a rope to 2 kg that 3 N hold: 1 m/s together, then 1 s and 0.5 m to rest."""
    text = """
format = 1
gravity = [0, 0]
ground.points = { O = [0, 0] }
bodies.a = { points = { P = [0, 0] }, mass = 2, inertia = 1 }
bodies.b = { points = { P = [0, 0] }, mass = 1, inertia = 1 }
joints.rail = { type = "prismatic", connect = ["ground.O", "a.P"], axis = 0, friction = { force = "3 N" } }
joints.rope = { type = "rod", connect = ["a.P", "b.P"], stop = { max = 1 } }
initial.a = { x = 0 }
initial.b = { x = 0.4, vx = 3 }
"""
    r = rt.loads(text).simulate(2.0, t_eval=[0, 0.2, 0.7, 1.2, 2.0], **FINE)
    assert r["a.x"] == pytest.approx([0, 0, 0.375, 0.5, 0.5], abs=1e-10)
    assert r["b.x"] == pytest.approx([0.4, 1.0, 1.375, 1.5, 1.5], abs=1e-10)
    assert r["energy.dissipated"][-1] == pytest.approx(4.5, abs=1e-10)
