"""Stiffness of rolling bearings: the integral over all elements by SciPy, and numbers of the books."""

import math

import numpy as np
import pytest
from scipy import integrate

import rattle as rt
from rattle.elements.contact_laws.rolling_bearing import RollingElements, spread
from rattle.errors import ModelError

pytestmark = pytest.mark.nojit


def force(delta, play, count=8, stiffness=1e10, exponent=1.5):
    values = {"elements": count, "element_stiffness": stiffness, "exponent": exponent, "clearance": play}
    return spread.python(delta, [*RollingElements.pack(values)], 0)


def summed(delta, play, count=8, stiffness=1e10, exponent=1.5):
    end = math.acos(play / (play + delta))

    def pressed(angle):
        return max(0.0, (play + delta) * math.cos(angle) - play) ** exponent * math.cos(angle)

    return count * stiffness / (2 * math.pi) * 2 * integrate.quad(pressed, 0, end, epsabs=0, epsrel=1e-12, limit=200)[0]


@pytest.mark.parametrize("exponent", [1.5, 10 / 9])
@pytest.mark.parametrize("share", [0.0, 1e-3, 0.1, 1.0, 10.0, 100.0])
def test_the_force_is_the_integral_over_all_elements(exponent, share):
    delta = 1e-5
    wanted = summed(delta, share * delta, exponent=exponent)
    assert force(delta, share * delta, exponent=exponent) == pytest.approx(
        wanted, rel=1e-9 if exponent == 1.5 else 1e-6
    )


@pytest.mark.parametrize(("exponent", "most"), [(1.5, 4.37), (10 / 9, 4.08)])
def test_without_play_the_most_loaded_element_bears_what_stribeck_says(exponent, most):
    """Q_max = 4.37 F/Z of balls, 4.08 F/Z of rollers."""
    delta, count = 1e-5, 9
    element = 1e10 * delta**exponent
    assert element * count / force(delta, 0.0, count, exponent=exponent) == pytest.approx(most, abs=0.005)


def test_play_lets_fewer_elements_bear():
    delta = 1e-5
    forces = [force(delta, play) for play in (0.0, 5e-6, 2e-5, 1e-4)]
    assert (np.diff(forces) < 0.0).all()


def test_a_bearing_sinks_in_by_its_stiffness():
    text = """
format = 1
gravity = [0, -10]
ground.points.O = [0, 0]
bodies.shaft = { points = { P = [0, 0] }, mass = 100, inertia = 1 }
drivers.hold = { body = "shaft", coordinate = "angle", angle = "0*t" }
[joints.O]
type = "revolute"
connect = ["ground.O", "shaft.P"]
bearing = "6208 C3"
contact = { model = "hertz", geometry = "rolling", elements = 9, element_stiffness = 8e9 }
"""
    m = rt.loads(text)
    rests = m.equilibrium()[0]
    assert force(rests["O.penetration"], 12e-6, 9, 8e9) == pytest.approx(1000.0, rel=1e-6)
    with pytest.raises(ModelError, match="do not hold a shaft"):
        rt.loads(text.replace("elements = 9", "elements = 2"))
    with pytest.raises(ModelError, match="needs element_stiffness"):
        rt.loads(text.replace(", element_stiffness = 8e9", ""))
