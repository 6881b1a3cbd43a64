"""Radau IIA: coefficients, and stiff mechanisms whose fast rates do not limit its steps."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.integrate._ivp import radau as published

import rattle as rt
from rattle.solvers import radau_tableau as tableau

G = 9.81


@pytest.mark.nojit
def test_coefficients_are_those_that_scipy_has():
    assert (tableau.C == published.C).all()
    assert (published.E == tableau.E).all()
    assert (published.T == tableau.T).all()
    assert (published.TI == tableau.TI).all()
    assert (tableau.REAL, complex(tableau.RE, tableau.IM)) == (published.MU_REAL, published.MU_COMPLEX)


@pytest.mark.nojit
def test_weights_are_those_of_collocation_and_split_into_a_real_and_a_complex_system():
    powers = np.vander(tableau.C, 3, increasing=True)  # sum_j A_ij C_j^k = C_i^(k+1) / (k+1)
    assert tableau.A @ powers == pytest.approx(powers * tableau.C[:, None] / [1, 2, 3], abs=1e-15)
    split = tableau.TI @ np.linalg.inv(tableau.A) @ tableau.T
    expected = [[tableau.REAL, 0, 0], [0, tableau.RE, -tableau.IM], [0, tableau.IM, tableau.RE]]
    assert split == pytest.approx(np.array(expected), abs=1e-13)


def damped(rate: float) -> rt.Mechanism:
    """1 kg on a guide, spring and damper with roots of about -1/s and -rate; 1 m apart, 0.1 m off."""
    m = rt.Mechanism("damped", gravity=[0, 0]).ground(O=[0, 0]).body("b", points={"P": [0, 0]}, mass=1, inertia=1)
    m = m.prismatic("g", "ground.O", "b.P").initial("b", x=1.1, vx=0)
    return m.load("s", "spring", connect=["ground.O", "b.P"], stiffness=rate, damping=rate, free_length=1)


@pytest.mark.nojit
@pytest.mark.plain
@pytest.mark.parametrize("rate", [1e6, 1e9])
def test_steps_do_not_follow_a_fast_rate(rate):
    r = damped(rate).simulate(1, t_eval=np.linspace(0, 1, 11), method="radau")
    fast = -0.5 * (rate + math.sqrt(rate * rate - 4 * rate))
    slow = rate / fast
    x = 0.1 * (fast * np.exp(slow * r.t) - slow * np.exp(fast * r.t)) / (fast - slow)
    assert r["b.x"] - 1 == pytest.approx(x, abs=3e-9)  # 30 tolerances of 1e-10 + 1e-8
    assert r.stats["steps"] < 80  # an explicit step is 6 / rate: 160 000 of them at 1e6
    assert abs(r["energy.balance"][-1]) < 2e-7 * 0.5 * rate * 0.1**2


STIFF, DAMPED, HEIGHT = 1e6, 1e6, 0.05  # N/m, N s/m: rates 1/s and 1e6/s of 1 kg


def dashpot(static, delta, ddelta, v0, p):
    """Spring and damper in parallel that do not pull."""
    return max(0.0, static + p.c * ddelta)


def falling(contact: dict) -> rt.Mechanism:
    """1 kg falls on a stop; its weight swings by a half."""
    m = rt.Mechanism("falling", gravity=[0, -G]).ground(O=[0, 0]).body("b", points={"P": [0, 0]}, mass=1, inertia=1)
    m = m.prismatic("g", "ground.O", "b.P", axis="90 deg", stop={"min": 0.0, "contact": contact})
    return m.initial("b", y=HEIGHT).load("f", "force", at="b.P", force=[0, "5*sin(20*t)"])


@pytest.mark.usefixtures("laws")
def test_contact_with_a_damping_rate_of_1e6_is_located_and_followed():
    """Against SciPy's Radau at 1e-11, started at the contact: free flight is a closed form."""
    rt.normal_law("dashpot", c="N*s/m")(dashpot)
    t = np.linspace(0, 0.5, 26)
    law = {"model": "dashpot", "c": DAMPED, "stiffness": STIFF, "exponent": 1.0}
    r = falling(law).simulate(0.5, t_eval=t, method="radau", horizon=False)
    height = lambda s: HEIGHT + s / 4 - np.sin(20 * s) / 80 - G * s * s / 2  # noqa: E731
    hit = r.events[0].t
    assert [event.kind for event in r.events] == ["contact"]
    v = 0.25 - math.cos(20 * hit) / 4 - G * hit
    assert abs(height(hit) / v) < 1e-9  # s: 1e-9 m of the state's tolerances, at 1 m/s
    rate = lambda s, y: [y[1], -G + 5 * np.sin(20 * s) - STIFF * y[0] - DAMPED * y[1]]  # noqa: E731
    known = solve_ivp(rate, (hit, 0.5), [0, v], "Radau", t_eval=t[t > hit], rtol=1e-11, atol=1e-14).y[0]
    assert r["b.y"][t > hit] == pytest.approx(known, abs=3e-9)
    assert r.peaks["g.force"].value == pytest.approx(-DAMPED * v, rel=1e-6)
    assert r.stats["evaluations"] < 2000  # dop853 needs 3 for each microsecond
    assert abs(r["energy.balance"][-1]) < 1e-6 * HEIGHT * G


def test_mass_comes_to_rest_on_a_kelvin_voigt_contact_with_a_rate_of_1e6():
    law = {"model": "kelvin-voigt", "restitution": 0.0, "stiffness": 2.5e11, "exponent": 1.0, "effective_mass": 1.0}
    r = falling(law).simulate(0.5, t_eval=[0.3, 0.5], method="radau", atol=1e-13, horizon=False)  # 4e-11 m deep
    pressed = (G - 5 * np.sin(20 * r.t)) / 2.5e11
    assert -r["b.y"] == pytest.approx(pressed, rel=1e-3)
    assert r["g.stop"] == pytest.approx(G - 5 * np.sin(20 * r.t), rel=1e-3)
    assert r.stats["steps"] < 1500


def test_contacts_and_peaks_are_those_of_dop853():
    m = rt.example("slider_crank_play")
    one, other = (m.simulate(1.8e-3, method=name, horizon=False) for name in ("radau", "dop853"))
    assert [event.kind for event in one.events] == [event.kind for event in other.events]
    assert len(one.events) > 10
    times = [[event.t for event in r.events] for r in (one, other)]
    assert times[0] == pytest.approx(times[1], abs=2e-8)  # s: 1e-8 of the motion after six contacts
    for name in ("B.normal", "O.force"):
        assert one.peaks[name].value == pytest.approx(other.peaks[name].value, rel=1e-5)


def test_steps_end_where_an_expression_switches_and_motion_dies_away():
    m = rt.example("toggle")
    one, other = (m.simulate(0.4, t_eval=[0.1, 0.2, 0.4], method=name) for name in ("radau", "dop853"))
    assert one.stats["switchings"] == other.stats["switchings"] == 1
    for name in ("arm.angle", "jaw.x"):
        assert one[name] == pytest.approx(other[name], abs=1e-8)


@pytest.mark.parametrize("rtol", [1e-7, 3e-8, 1e-8])
def test_switches_of_equal_expressions_do_not_undo_each_other(rtol):
    """Limits of the voltage and of its integral part are one function, whose sign rounding has where it is 0."""
    m = rt.example("dc_motor_pid")
    one = m.simulate(0.02, t_eval=[0.0, 0.02], method="radau", rtol=rtol)
    other = m.simulate(0.02, t_eval=[0.0, 0.02], rtol=1e-10)
    assert one.success, one.message
    assert one.stats["switchings"] <= 6
    assert one["arm.omega"] == pytest.approx(other["arm.omega"], rel=100 * rtol)
