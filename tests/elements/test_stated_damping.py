"""Contacts with stated damping, F = max(0, K delta^n + c ddelta), against closed forms and SciPy."""

from __future__ import annotations

from math import atan2, exp, pi, sin, sqrt

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rattle as rt

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

FINE = {"rtol": 1e-11, "atol": 1e-14}


def slider(contact: str, more: str = "", start: str = "x = 0, vx = 1", mass: float = 0.5) -> str:
    """A mass on a line without weight that meets a stop at 10 mm at 1 m/s."""
    return f"""
format = 1
gravity = [0, 0]
ground.points = {{ O = [0, 0] }}
parameters = {{ c = "60 N*s/m" }}
{more}
bodies.s = {{ points = {{ P = [0, 0] }}, mass = {mass}, inertia = 1 }}
joints.rail.type = "prismatic"
joints.rail.connect = ["ground.O", "s.P"]
joints.rail.axis = 0
joints.rail.stop = {{ max = 0.01, contact = {contact} }}
initial.s = {{ {start} }}
"""


def returned(z: float) -> float:
    """Restitution of a spring and a damper that do not pull, z < 1."""
    w = sqrt(1 - z * z)
    return exp(-z / w * (pi - atan2(2 * z * w, 1 - 2 * z * z)))


@pytest.mark.parametrize("method", ["dop853", "radau"])
@pytest.mark.parametrize("c", [5.0, 60.0, 200.0, 400.0])
def test_a_free_mass_leaves_with_the_restitution_of_its_damper(c: float, method: str) -> None:
    contact = f'{{ model = "hertz", stiffness = 1e5, exponent = 1, damping = "{c} N*s/m" }}'
    r = rt.loads(slider(contact)).simulate(0.03, t_eval=[0, 0.03], method=method, **FINE)
    z, omega = c / (2 * sqrt(1e5 * 0.5)), sqrt(1e5 / 0.5)
    e, w = returned(z), sqrt(1 - z * z)
    assert r["s.vx"][-1] == pytest.approx(-e, abs=1e-9)
    begin, end = [event for event in r.events if event.joint == "rail"]
    assert (begin.kind, end.kind) == ("contact", "release")
    lasts = (pi - atan2(2 * z * w, 1 - 2 * z * z)) / (omega * w)  # until the force is zero, not until the gap opens
    assert [begin.t, begin.duration, end.t] == pytest.approx([0.01, lasts, 0.01 + lasts], abs=1e-9)
    assert begin.energy_lost == pytest.approx(0.25 * (1 - e * e), abs=1e-10)
    t = np.linspace(0, lasts, 100_001)
    delta, fade = np.sin(omega * w * t), np.exp(-z * omega * t) / (omega * w)
    rate = fade * (omega * w * np.cos(omega * w * t) - z * omega * delta)
    assert begin.peak_force == pytest.approx((1e5 * fade * delta + c * rate).max(), rel=1e-7)
    assert np.abs(r["energy.balance"]).max() < 1e-10
    assert r["energy.dissipated"][-1] == pytest.approx(0.25 * (1 - e * e), abs=1e-10)


def test_a_damper_of_zero_is_no_loss_and_an_expression_is_read() -> None:
    free = rt.loads(slider('{ model = "exact", stiffness = 1e5, exponent = 1, damping = 0 }')).simulate(0.03, **FINE)
    assert free["s.vx"][-1] == pytest.approx(-1, abs=1e-9)
    m = rt.loads(slider('{ model = "exact", stiffness = 1e5, exponent = 1, damping = "c" }'))
    r = m.simulate(0.03, t_eval=[0, 0.03], **FINE)
    assert r["s.vx"][-1] == pytest.approx(-returned(60 / (2 * sqrt(1e5 * 0.5))), abs=1e-9)
    r = m.set({"c": 5}).simulate(0.03, t_eval=[0, 0.03], **FINE)
    assert r["s.vx"][-1] == pytest.approx(-returned(5 / (2 * sqrt(1e5 * 0.5))), abs=1e-9)


@pytest.mark.parametrize("exponent", [1.0, 1.5])
@pytest.mark.parametrize("method", ["dop853", pytest.param("radau", marks=pytest.mark.machine)])
def test_a_force_may_end_and_return_inside_the_wall(exponent: float, method: str) -> None:
    """A mass that a force shakes against its stop; SciPy integrates m x'' = F(t) - max(0, K delta^n + c delta')."""
    push = 'loads.F = { type = "force", at = "s.P", force = ["100 + 600*sin(900*t)", 0] }'
    contact = f'{{ model = "hertz", stiffness = 1e5, exponent = {exponent}, damping = 200 }}'
    m = rt.loads(slider(contact, push, "x = 0.009, vx = 0.2"))

    def motion(t: float, y: np.ndarray) -> list[float]:
        depth = y[0] - 0.01
        force = max(0.0, 1e5 * depth**exponent + 200 * y[1]) if depth > 0 else 0.0
        return [y[1], (100 + 600 * sin(900 * t) - force) / 0.5]

    r = m.simulate(0.03, t_eval=np.linspace(0, 0.03, 31), method=method, **FINE)
    y = solve_ivp(motion, (0, 0.03), [0.009, 0.2], t_eval=r.t, rtol=1e-11, atol=1e-14, max_step=1e-5).y
    assert np.abs(r["s.x"] - y[0]).max() < 1e-9
    assert np.abs(r["s.vx"] - y[1]).max() < 1e-7
    assert (r["rail.stop"] <= 0.0).all()
    ended = [event.t for event in r.events if event.kind == "release"]
    assert len(ended) >= 4
    inside = [t for t in ended if np.interp(t, r.t, r["s.x"]) > 0.0101]
    assert inside
    contacts = [event for event in r.events if event.kind == "contact"]
    total = sum(event.energy_lost for event in contacts)
    assert r["energy.dissipated"][-1] == pytest.approx(total, abs=1e-8)
    assert np.abs(r["energy.balance"]).max() < 1e-7


@pytest.mark.machine
def test_beside_a_rigid_contact_and_by_moreau() -> None:
    """An impact elsewhere makes the run event-driven, or a series of steps that converges to it."""
    rigid = """
bodies.w = { points = { O = [0, 0] }, mass = 0.5, inertia = 0.01 }
joints.O = { type = "revolute", connect = ["ground.O", "w.O"], stop = { max = 0.2, contact = "impact" } }
initial.w = { omega = 20 }
"""
    contact = '{ model = "hertz", stiffness = 1e5, exponent = 1, damping = 200 }'
    m, e = rt.loads(slider(contact, rigid, "x = 0.0001317, vx = 1")), returned(200 / (2 * sqrt(1e5 * 0.5)))
    r = m.simulate(0.03, t_eval=[0, 0.03], **FINE)
    assert r["s.vx"][-1] == pytest.approx(-e, abs=1e-9)
    assert r["w.omega"][-1] == 0.0
    errors = []
    for step in (2e-5, 1e-5, 5e-6):
        r = m.simulate(0.03, t_eval=[0, 0.03], method="moreau", step=step)
        errors.append(abs(r["s.vx"][-1] + e))
        lost = [event.energy_lost for event in r.events if event.kind == "contact"]
        assert lost == pytest.approx([0.25 * (1 - e * e)], rel=5e-3)
    assert errors[2] < errors[0] / 2.5 < 0.003


def test_an_angle_takes_a_moment() -> None:
    text = """
format = 1
gravity = [0, 0]
ground.points = { O = [0, 0] }
bodies.w = { points = { O = [0, 0] }, mass = 1, inertia = 0.02 }
joints.O = { type = "revolute", connect = ["ground.O", "w.O"], stop = { max = "5 deg", contact = CONTACT } }
initial.w = { omega = 3 }
"""
    contact = '{ model = "kelvin-voigt", stiffness = 2000, exponent = 1, damping = "3 N*m*s/rad" }'
    r = rt.loads(text.replace("CONTACT", contact)).simulate(0.1, t_eval=[0, 0.1], **FINE)
    assert r["w.omega"][-1] / 3 == pytest.approx(-returned(3 / (2 * sqrt(2000 * 0.02))), abs=1e-9)
    with pytest.raises(rt.ModelError, match=r"is a damping"):
        rt.loads(text.replace("CONTACT", contact.replace("N*m*s/rad", "N*s/m")))


def test_a_pin_in_a_bush_with_friction() -> None:
    """A pin falls straight into its bush: the normal motion is that of the free mass, by n = 1."""
    text = """
format = 1
gravity = [0, 0]
ground.points = { O = [0, 0] }
bodies.s = { points = { P = [0, 0] }, mass = 0.5, inertia = 0.001 }
joints.O = { type = "revolute", connect = ["ground.O", "s.P"], clearance = 0.001, contact = CONTACT }
initial.s = { x = 0, vx = 1 }
"""
    contact = '{ model = "flores", stiffness = 1e5, exponent = 1, damping = 60, bush_radius = 0.01, friction = 0.2 }'
    r = rt.loads(text.replace("CONTACT", contact)).simulate(0.008, t_eval=[0, 0.008], **FINE)
    assert r["s.vx"][-1] == pytest.approx(-returned(60 / (2 * sqrt(1e5 * 0.5))), abs=1e-9)
    m = rt.loads(text.replace("CONTACT", contact))
    assert m.with_contact("hertz").contact_of("O")["damping"] == 60
    assert "damping" not in m.with_contact("impact").contact_of("O")


@pytest.mark.machine
def test_it_rests_and_vibrates_by_spring_and_damper() -> None:
    """Under its weight the depth is m g/K; about it a viscous damper, zeta = c/(2 sqrt(K m))."""
    text = slider('{ model = "hertz", stiffness = 1e3, exponent = 1, damping = 6 }', start="x = 0.009")
    m = rt.loads(text.replace("gravity = [0, 0]", "gravity = [9.81, 0]"))
    (rest,) = m.equilibrium()
    assert rest["s.x"] == pytest.approx(0.01 + 0.5 * 9.81 / 1e3, rel=1e-9)
    root = complex(-6 / (2 * 0.5), sqrt(1e3 / 0.5 - (6 / (2 * 0.5)) ** 2))
    assert m.modes().roots[0, 0] == pytest.approx(root, rel=1e-5)
    r = m.simulate(5.0, t_eval=[0, 5.0], rtol=1e-10, atol=1e-13)
    assert r["s.x"][-1] == pytest.approx(0.01 + 0.5 * 9.81 / 1e3, abs=1e-9)


@pytest.mark.parametrize(
    ("contact", "words"),
    [
        ('{ model = "hertz", stiffness = 1e5, restitution = 0.5, damping = 10 }', ("damping", "restitution")),
        ('{ model = "impact", damping = 10 }', ("damping", "restitution", "rigid")),
        ('{ model = "impact", restitution = 0.2, damping = 10 }', ("damping", "restitution")),
        ('{ model = "hertz", stiffness = 1e5, damping = -1 }', ("damping", "negative")),
        ('{ model = "hertz", stiffness = 1e5, damping = "10 N" }', ("damping in N*s/m",)),
    ],
)
def test_a_damping_that_contradicts_is_refused(contact: str, words: tuple[str, ...]) -> None:
    with pytest.raises(rt.ModelError) as refusal:
        rt.loads(slider(contact))
    assert all(word in str(refusal.value) for word in words)
