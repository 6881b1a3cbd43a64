"""Laws of motion from rest to rest: their ends, their symmetry, and the largest values that tables give for them."""

import numpy as np
import pytest

import rattle as rt
from rattle.language.expression import value
from rattle.language.motion_laws import LAWS
from rattle.language.syntax import ExpressionError, Number, parse, replaced

pytestmark = pytest.mark.nojit

# largest velocity and acceleration of a rise of 1 in a time of 1: VDI 2143-1, table 4; Norton, table 8-3
PEAKS = {
    "harmonic": (np.pi / 2, np.pi**2 / 2),
    "cycloid": (2.0, 2 * np.pi),
    "poly345": (1.875, 10 / np.sqrt(3)),
    "poly4567": (2.1875, 7.5132),
    "modified_sine": (1.7596, 5.5280),
    "modified_trapezoid": (2.0, 8 * np.pi / (2 + np.pi)),
}


def law(name, shares):
    node = parse(f"{name}(x)")
    return np.array([value(replaced(node, {"x": Number(float(u), 0)}), {}) for u in shares])


@pytest.mark.parametrize("name", LAWS)
def test_a_law_goes_from_rest_to_rest_and_is_the_same_backwards(name):
    u = np.linspace(-0.2, 1.2, 57)
    s = law(name, u)
    assert s[u <= 0] == pytest.approx(0.0, abs=0)
    assert s[u >= 1] == pytest.approx(1.0, abs=0)
    assert s + law(name, 1 - u) == pytest.approx(1.0, abs=1e-14)
    near = 1e-4
    assert law(name, [near, 1 - near]) == pytest.approx([0.0, 1.0], abs=3 * near**2)  # at rest at both ends


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.machine if name.startswith("modified") else ()) for name in PEAKS]
)
def test_the_largest_velocity_and_acceleration_are_those_of_the_tables(name):
    """By a driven slider, whose derivatives are exact; a rise of 20 mm in 0.1 s."""
    assert PEAKS.keys() == LAWS.keys()
    rise, time = 0.02, 0.1
    m = rt.Mechanism("follower").ground(O=[0, 0]).body("b", mass=1, inertia=1, points={"C": [0, 0]})
    m = m.prismatic("guide", "ground.O", "b.C", axis="0 deg").driver(
        "d", joint="guide", position=f"20 mm*{name}(t/(0.1 s))"
    )
    r = m.kinematics(np.linspace(0.0, time, 2001)[1:-1])
    velocity, acceleration = PEAKS[name]
    assert np.abs(r["b.vx"]).max() == pytest.approx(velocity * rise / time, rel=2e-4)
    assert np.abs(r["b.ax"]).max() == pytest.approx(acceleration * rise / time**2, rel=2e-4)
    # the acceleration is that of the positions: a law whose pieces do not fit has jumps
    x = np.gradient(np.gradient(r["b.x"], r.t), r.t)[5:-5]
    assert x == pytest.approx(r["b.ax"][5:-5], abs=2e-2 * np.abs(r["b.ax"]).max())


def test_a_law_is_a_function_of_a_plain_number():
    m = rt.Mechanism("follower").ground(O=[0, 0]).body("b", mass=1, inertia=1, points={"C": [0, 0]})
    m = m.parameter("rise", "1 m").prismatic("guide", "ground.O", "b.C", axis="0 deg")
    for name in LAWS:
        with pytest.raises(rt.ModelError, match=r"cannot .* m.* plain number"):
            m.driver(f"by_{name}", joint="guide", position=f"20 mm*{name}(rise)").check()


def test_laws_that_would_become_too_long_are_refused():
    with pytest.raises(ExpressionError, match="more than 1000 parts"):
        parse("cycloid(" * 5 + "x" + ")" * 5)


def test_names_of_laws_are_still_free_for_parameters():
    assert value(parse("cycloid(cycloid)"), {"cycloid": 0.5}) == pytest.approx(0.5)
