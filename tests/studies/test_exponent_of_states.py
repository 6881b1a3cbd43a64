"""Exponents of models with states: disturbed and measured like positions, whether or not they feed back."""

import math

import pytest

import rattle as rt


def block(force: str, states: str, start: str = "x = 1, vx = 0") -> rt.Mechanism:
    """A mass of 1 kg on a rail, and states beside it."""
    return rt.loads(f"""
format = 1
[ground.points]
O = [0, 0]
[bodies.b]
points = {{ P = [0, 0] }}
mass = 1
inertia = 1
[joints.rail]
type = "prismatic"
connect = ["ground.O", "b.P"]
[loads.all]
type = "force"
at = "b.P"
force = ["{force}", 0]
[initial]
b = {{ {start} }}
{states}
""")


def state(name: str, rate: str, start: float) -> str:
    return f'[states.{name}]\nrate = "{rate}"\nstart = {start}\n'


LORENZ = state("x", "10*(y - x)", 1) + state("y", "x*(28 - z) - y", 1) + state("z", "x*y - 8/3*z", 20)
LORENZ_EXPONENT = 0.9056  # Sprott, Chaos and Time-Series Analysis (2003), appendix A


@pytest.mark.nojit
@pytest.mark.parametrize("start", [0.0, 1.0, -3.0])
@pytest.mark.parametrize("rate", [-0.05, 0.5])
def test_exponent_of_a_linear_model_is_its_largest_eigenvalue_where_a_state_only_drives(rate, start):
    # the block has -0.764 and -5.24
    found = block("u - 4*b.x - 6*b.vx", state("u", f"{rate}*u", start)).lyapunov(200.0)
    assert found.exponent == pytest.approx(rate, rel=1e-9)
    assert abs(found.exponent - rate) <= found.uncertainty < 1e-8


@pytest.mark.nojit
def test_exponent_of_a_state_that_neither_drives_nor_is_driven():
    found = block("-4*b.x - 6*b.vx", state("u", "0.3*(2 - u)*u", 0.1)).lyapunov(200.0)  # ends at u = 2, u' = -0.6 (u-2)
    assert found.exponent == pytest.approx(-0.6, rel=1e-6)


def test_a_state_of_any_unit_gives_the_same_exponent():
    for size in (1e-6, 1.0, 1e6):
        states = state("u", "0.2*u - v", 0.01 * size) + state("v", "0.2*v + u", 0)
        found = block(f"u/{size} - 4*b.x - 6*b.vx", states).lyapunov(60.0)
        assert abs(found.exponent - 0.2) <= found.uncertainty


@pytest.mark.parametrize("coupling", ["0", "1e-6*x", "x"])
def test_exponent_of_lorenz_equations_as_states_does_not_depend_on_what_they_drive(coupling):
    found = block(f"{coupling} - 4*b.x - 6*b.vx", LORENZ).lyapunov(200.0)
    assert abs(found.exponent - LORENZ_EXPONENT) < 1.5 * found.uncertainty
    assert found.uncertainty < 0.1
    assert found.chaotic


def test_states_beside_a_fully_driven_motion_have_an_exponent():
    m = rt.Mechanism("turning").ground(O=[0, 0])
    m = m.body("b", mass=1, inertia=1, points={"C": [0, 0]}).revolute("p", "ground.O", "b.C")
    driven = m.driver("d", joint="p", angle="t")
    with pytest.raises(ValueError, match="no degree of freedom"):
        driven.lyapunov(20.0)
    found = driven.state("u", rate="-0.25*u + sin(p.angle)", start=1.0).lyapunov(100.0)
    assert found.exponent == pytest.approx(-0.25, rel=1e-9)


def test_exponent_of_a_jerk_equation_whose_acceleration_is_a_state():
    # x''' = -2.017 x'' + x'^2 - x; Sprott, Chaos and Time-Series Analysis (2003), appendix A: 0.0551
    found = block("a", state("a", "-2.017*a + 1*b.vx**2 - 1*b.x", 0.5), "x = -0.9, vx = 0").lyapunov(1200.0)
    assert abs(found.exponent - 0.0551) < 1.5 * found.uncertainty
    assert found.uncertainty < 0.02


@pytest.mark.parametrize(("rate", "drives"), [(-0.05, "u"), (0.4, "0*u")])
def test_two_neighbouring_runs_differ_in_states_too(rate, drives):
    found = block(f"{drives} - 4*b.x - 6*b.vx + 0*abs(b.vx)", state("u", f"{rate}*u", 1.0)).lyapunov(100.0)
    assert found.how.startswith("two neighbouring runs")
    assert abs(found.exponent - rate) <= found.uncertainty


@pytest.mark.parametrize("stretch", [math.pi, 1.0])
def test_bound_of_an_impact_oscillator_holds(stretch):
    # one impact in every period pi; multipliers are a conjugate pair, whose product is (e exp(-c pi/2))^2
    m = rt.loads("""
format = 1
[ground.points]
O = [0, 0]
[bodies.b]
points = { P = [0, 0] }
mass = 1
inertia = 1
[joints.rail]
type = "prismatic"
connect = ["ground.O", "b.P"]
stop = { min = 0, contact = { model = "impact", restitution = 0.8 } }
[loads.all]
type = "force"
at = "b.P"
force = ["-1*b.x - 0.04*b.vx + 1*cos(2*t)", 0]
[initial]
b = { x = 0.5, vx = 0 }
""")
    found = m.lyapunov(100 * math.pi, stretch=stretch)
    assert abs(found.exponent - (math.log(0.8) / math.pi - 0.02)) <= found.uncertainty < 0.01
