"""Units behind numbers in the expressions of a model: what they give, and where a name could be meant."""

from __future__ import annotations

import pytest

import rattle as rt

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

MODEL = """format = 1
[parameters]
payload = "10 kg"
{head}
[ground.points]
O = [0, 0]
[bodies.box]
points = {{ C = [0, 0] }}
mass = "{mass}"
inertia = 1
[joints.pin]
type = "revolute"
connect = ["ground.O", "box.C"]
[loads.M]
type = "torque"
body = "box"
torque = "{torque}"
"""


def model(mass="payload", torque="0 N*m", head=""):
    return rt.loads(MODEL.format(mass=mass, torque=torque, head=head)).model


def test_a_mass_may_be_a_sum_with_a_unit():
    assert model("payload + 40 kg").bodies["box"].mass == 50.0
    assert model("2*payload - 500 g").bodies["box"].mass == 19.5


def test_dimensions_are_checked():
    for mass, message in (
        ("payload + 40 N", "cannot add kg and N"),
        ("40 mm + 2 mm", "is a length; expected a mass in kg"),
    ):
        with pytest.raises(rt.ModelError) as caught:
            model(mass)
        assert message in str(caught.value)
    with pytest.raises(rt.ModelError, match="is a force; expected a moment"):
        model(torque="40 N + 2 N*sin(t)")


def test_a_word_that_is_a_unit_and_a_name_is_refused_within_an_expression():
    head = 'm = "3 m"\ns = 2'
    for torque in ("40 N*m + 2*t", "2*t*5 N m", "3 N/(1 s)*m*1 s + 2 N*(m) + 1 kg*m^2/s^2"):
        with pytest.raises(rt.ModelError, match="in this unit is also a name of the model; write the quantity"):
            model(torque=torque, head=head)
    assert model(torque="40 N*m", head=head).loads["M"].values == (40.0,)  # a plain quantity is one in any case
    assert model(torque="(40 N)*m", head=head).loads["M"].values == (120.0,)
    assert model(torque="40 Nm + m*(1 N)", head=head).loads["M"].values == (43.0,)
    assert model(torque="40 N*m + 2 N*m").loads["M"].values == (42.0,)


def test_t_behind_a_number_is_the_time():
    with pytest.raises(rt.ModelError, match=r"write 2\*t for the time"):
        model(torque="1 + 2 t")
    m = rt.loads(MODEL.format(mass="1 t", torque="0", head="") + '[signals]\nway = "5 mm/s*t + 1 mm"\n').model
    assert m.signal_units["way"] == "m"
    assert m.bodies["box"].mass == 1000.0
