"""Fields that are functions of a variable of their kind, with derivatives, within kernels, in runs and on record."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rattle as rt
from rattle import registry
from rattle.interfaces.joints import JointKind
from rattle.jit import layout as at
from rattle.jit.functions import kernel
from rattle.jit.geometry import angle_row
from rattle.language.expression import parse
from rattle.language.local_function import local_function, packed
from rattle.language.local_jet import function_jet
from rattle.language.tables import NO_TABLES
from rattle.registry import Field, kind


@kernel("joint")
def geared(body, a, b, p, k, row, rows):
    """phi_B = f(phi_A) [rad]; p[k + 4:] = ratio of a second gear, f."""
    f, df, ddf = function_jet(p, k + 5, body[a, at.PHI])
    wa = body[a, at.W]
    angle_row(body, a, b, f * p[k + 4] - body[a, at.PHI], 0.0, 0.0, row, rows)
    rows[row, at.AP] = -df * p[k + 4]
    rows[row, at.GAMMA] = ddf * p[k + 4] * wa * wa


@pytest.fixture
def geared_joint():
    registry.discover()  # the kinds of the package come first, so that the last one can be taken away again

    @kind("joint", "geared", geared)
    class Geared(JointKind):
        """The angle of B follows that of A.

        Source: test.
        """

        rows = ("rad",)
        moment = True
        ratio = Field("", "factor", default=1.0)
        law = Field("rad", "angle of B", function_of="a")

    yield
    del registry.kinds("joint")["geared"]


def pair(law, **parameters):
    """Two wheels on the ground, of which the first turns with 2 rad/s and leads the second."""
    m = rt.Mechanism("pair")
    for name, value in parameters.items():
        m.parameter(name, value)
    m.ground(O=[0, 0], Q=[1, 0])
    for name, place in (("first", "O"), ("second", "Q")):
        m.body(name, points={"C": [0, 0]}, mass=1.0, inertia=1.0)
        m.revolute(f"{name}_pin", f"ground.{place}", f"{name}.C")
    m.joint("law", "geared", "first.C", "second.C", ratio=0.5, law=law)
    return m.driver("motor", "first_pin", angle="0.3 + 2*t")


def curved(a):
    return 0.7 * np.sin(2 * a) + 0.1 * a**2, 1.4 * np.cos(2 * a) + 0.2 * a, -2.8 * np.sin(2 * a) + 0.2


@pytest.mark.parametrize(
    ("law", "f"),
    [
        ("e*sin(2*a) + 0.1*a**2", curved),
        (0.4, lambda a: (0.4 + 0 * a, 0 * a, 0 * a)),
        ("10 deg", lambda a: (math.pi / 18 + 0 * a, 0 * a, 0 * a)),
        ("a if a < 1 else 2*a - 1", lambda a: (np.where(a < 1, a, 2 * a - 1), np.where(a < 1, 1, 2), 0 * a)),
    ],
)  # fmt: skip
def test_motion_follows_the_function_and_its_derivatives(geared_joint, law, f):
    t = np.linspace(0.0, 1.0, 7)
    for result in (pair(law, e=0.7).kinematics(t), pair(law, e=0.7).simulate(t_eval=t, rtol=1e-11)):
        want, slope, bend = f(0.3 + 2 * result.t)
        np.testing.assert_allclose(result["second.angle"], 0.5 * want, atol=1e-9)
        np.testing.assert_allclose(result["second.omega"], 0.5 * 2 * slope, atol=1e-8)
        np.testing.assert_allclose(result["second.alpha"], 0.5 * 4 * bend, atol=1e-8)


def test_a_table_is_read_within_a_kernel(geared_joint):
    from scipy.interpolate import CubicSpline

    x, y = [0.0, 1.0, 2.5, 4.0], [0.1, 0.3, -0.2, 0.1]
    m = pair("2*wave(a) + 1").table("wave", x, y, kind="spline", period=4)
    spline = CubicSpline(x, y, bc_type="periodic")
    r = m.kinematics(np.linspace(0.0, 5.0, 9))
    a = 0.3 + 2 * r.t
    np.testing.assert_allclose(r["second.angle"], spline(a) + 0.5, atol=1e-14)
    np.testing.assert_allclose(r["second.alpha"], 4 * spline(a, 2), atol=1e-12)


def test_a_trace_has_the_function_and_its_derivative_by_parameters(geared_joint):
    m = pair("e*sin(2*a) + 0.1*a**2", e=0.7)
    r = m.sensitivity(["second.angle"], ["e"], [0.0, 0.4, 1.0], analysis="kinematics")
    np.testing.assert_allclose(r["d(second.angle)/d(e)"], 0.5 * np.sin(2 * (0.3 + 2 * r.t)), atol=1e-12)


@pytest.mark.nojit
def test_the_function_can_be_called_on_arrays():
    one = local_function(parse("r + e*cos(a)"), "a", {"r": 3.0, "e": 0.5}, NO_TABLES)
    a = np.array([[0.0, 1.0], [2.0, 3.0]])
    np.testing.assert_allclose(one(a), [3 + 0.5 * np.cos(a), -0.5 * np.sin(a), -0.5 * np.cos(a)], atol=1e-15)
    assert not one.constant
    assert not one.switches
    assert local_function(parse("r"), "a", {"r": 3.0}, NO_TABLES).constant
    assert local_function(parse("abs(a)"), "a", {}, NO_TABLES).switches


@pytest.mark.nojit
def test_several_functions_lie_behind_the_other_parameters():
    one, two = (local_function(parse(text), "a", {}, NO_TABLES) for text in ("a**3", "sin(a)"))
    p = np.array(packed([7.0, one, 8.0, two]))
    assert (p[0], p[2]) == (7.0, 8.0)
    assert function_jet(p, 1, 2.0) == pytest.approx((8, 12, 12))
    assert function_jet(p, 3, 0.5) == pytest.approx((math.sin(0.5), math.cos(0.5), -math.sin(0.5)))


@pytest.mark.nojit
@pytest.mark.parametrize(
    ("law", "message"),
    [
        ("t", "'t' changes during the run; only parameters and a are allowed here"),
        ("b*2", "unknown name 'b'"),
        ("5 mm", "is a length; expected a plain number or angle in rad"),
        ("log(-1)*a", "not a finite number"),
        ("sin(a", "is not closed"),
        ("wave(a)", "there is no function 'wave'"),
    ],
)
def test_what_such_a_field_cannot_be(geared_joint, law, message):
    with pytest.raises(rt.ModelError, match=r"joints\.law\.law") as caught:
        _ = pair(law).model
    assert message in str(caught.value)


@pytest.mark.nojit
def test_the_variable_is_no_parameter(geared_joint):
    with pytest.raises(rt.ModelError, match="here 'a' has a meaning of its own; give the parameter 'a' another name"):
        _ = pair("2*a", a=3).model
