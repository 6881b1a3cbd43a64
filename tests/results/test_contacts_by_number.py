"""time(J.contacts, k), speed(...), peak(...): against closed forms; and what is refused."""

import math

import numpy as np
import pytest

import rattle as rt
from balls import G, ball
from rattle.errors import ModelError
from rattle.results.evaluation import evaluate
from rattle.results.reductions import Known, read

ROTOR = """
format = 1
parameters.w = 2.0
ground.points.O = [0, 0]
bodies.rotor = { points = { C = [0, 0] }, mass = 1, inertia = 0.02 }
initial.rotor = { angle = 0.4, omega = "w" }
[joints.pivot]
type = "revolute"
connect = ["ground.O", "rotor.C"]
stop = { min = 0, max = "1 rad", contact = { model = "impact", restitution = 0.5 } }
"""


def asked(m, outputs, t_end, **samples):
    return m.many(samples, outputs, t_end, rtol=1e-11, atol=1e-14)


def test_a_ball_hits_a_rigid_stop_as_the_closed_form_says():
    e, h = np.array([0.8, 0.6]), np.array([1.0, 0.5])
    texts = [
        f"{what}(rail.{word}, {k})" for what in ("time", "speed") for word in ("contacts", "impacts") for k in (1, 4)
    ]
    found = asked(rt.loads(ball()), texts, 3.0, e=e, h=h)
    first = np.sqrt(2 * h / G)
    for word in ("contacts", "impacts"):
        assert found[f"time(rail.{word}, 1)"] == pytest.approx(first, abs=1e-10)
        assert found[f"time(rail.{word}, 4)"] == pytest.approx(first * (1 + 2 * (e + e**2 + e**3)), abs=1e-9)
        assert found[f"speed(rail.{word}, 4)"] == pytest.approx(G * first * e**3, rel=1e-9)


def test_a_ball_that_stays_has_hit_once():
    """That it rests from then on is no contact more."""
    found = asked(rt.loads(ball()), ["count(rail.contacts)", "time(rail.contacts, 2)"], 1.0, e=[0.0])
    assert found["count(rail.contacts)"][0] == 1
    assert np.isnan(found["time(rail.contacts, 2)"][0])


def test_the_largest_force_on_an_elastic_stop_is_that_of_a_spring():
    m = rt.loads(ball('{ model = "hertz", stiffness = "k", exponent = 1 }'))
    k = np.array([1e5, 1e6])
    found = asked(m, ["peak(rail.contacts, 1)", "peak(rail.contacts, 2) - peak(rail.contacts, 1)"], 1.5, k=k)
    assert found["peak(rail.contacts, 1)"] == pytest.approx(G + np.sqrt(G * G + k * 2 * G), rel=1e-8)
    assert found["peak(rail.contacts, 2) - peak(rail.contacts, 1)"] == pytest.approx([0, 0], abs=1e-3)


def test_contacts_of_both_stops_count_in_order_and_one_that_does_not_come_is_no_failure():
    texts = ["time(pivot.contacts, 2) - time(pivot.contacts, 1)", "speed(pivot.contacts, 2)", "time(pivot.contacts, 3)"]
    found = asked(rt.loads(ROTOR), [*texts, "count(pivot.contacts)"], 2.5, w=[2.0, -3.0])
    assert found[texts[0]] == pytest.approx([1.0, 1.0 / 1.5])
    assert found[texts[1]] == pytest.approx([1.0, 1.5])
    assert found["count(pivot.contacts)"] == pytest.approx([2, 3])
    assert np.isnan(found[texts[2]][0])
    assert found[texts[2]][1] == pytest.approx(0.4 / 3 + 1 / 1.5 + 1 / 0.75)
    assert len(found.failed) == 0
    assert read(texts[1], Known.of(rt.loads(ROTOR).simulate(0.1))).unit == "rad/s"


def test_a_clutch_that_takes_up_is_a_contact():
    clutch = """
format = 1
ground.points.O = [0, 0]
bodies.one = { points = { C = [0, 0] }, mass = 1, inertia = 1 }
bodies.two = { points = { C = [0, 0] }, mass = 1, inertia = 2 }
joints.p = { type = "revolute", connect = ["ground.O", "one.C"] }
joints.q = { type = "revolute", connect = ["ground.O", "two.C"] }
joints.way = { type = "clutch", connect = ["one", "two"], model = "ideal" }
loads.push = { type = "torque", body = "one", torque = "T" }
parameters.T = 1.0
initial.one = { angle = 0, omega = 0 }
initial.two = { angle = 0, omega = 2 }
"""
    found = asked(rt.loads(clutch), ["time(way.contacts, 1)"], 6.0, T=[1.0, 2.0])
    assert found["time(way.contacts, 1)"] == pytest.approx([2.0, 1.0])


def test_a_ratchet_that_takes_up_with_an_impact_takes_up_once():
    m = rt.example("ratchet")
    texts = ["count(drive.contacts)", *(f"{w}(drive.contacts, {k})" for w in ("time", "peak", "speed") for k in (1, 2))]
    found = m.many({"A": [m.parameters["A"]]}, [*texts, "time(drive.contacts, 1e20)"])
    count, first, second, *peaks, fast, _ = (float(found[text][0]) for text in texts)
    locks = [event for event in m.simulate().events if event.joint == "drive" and event.kind == "lock"]
    assert count == len(locks) == 3
    assert [first, second] == pytest.approx([event.t for event in locks[:2]], abs=1e-6)
    assert peaks == pytest.approx([event.peak_force for event in locks[:2]], rel=1e-4)
    assert fast > 0.0
    assert math.isnan(found["time(drive.contacts, 1e20)"][0])


def test_of_a_run_that_ends_early_what_came_before_is_known():
    text = ball() + '[loads.late]\ntype = "force"\nat = "ball.C"\nforce = [0, "sqrt(0.7 - t)"]\n'
    r = rt.loads(text).simulate(1.0)
    assert not r.success
    known = Known.of(r)
    assert evaluate(read("time(rail.contacts, 1)", known), r) == pytest.approx(r.events[0].t)
    assert math.isnan(evaluate(read("time(rail.contacts, 9)", known), r))
    assert math.isnan(evaluate(read("count(rail.contacts)", known), r))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time(rail.contacts, 0)", "counted from 1: time(..., k) takes a whole number, not 0"),
        ("time(rail.contacts, 1.5)", "a whole number, not 1.5"),
        ("time(rail.contacts, h)", "takes a whole number"),
        ("speed(rail.contacts, 1 m)", "takes a whole number, not 1 m"),
        ("time(rial.contacts, 1)", "did you mean 'rail.contacts'"),
        ("speed(rail.contact, 1)", "did you mean 'rail.contacts'"),
        ("speed(ball.vy, 1)", "speed takes the contacts of a joint, as in speed(rail.contacts, 1)"),
        ("peak(ball.ay, 1)", "of a curve it is max(abs(x))"),
        ("peak(rail.contacts, 1)", "they have impulses and no largest force; write max(rail.impulse)"),
        ("time(rail.contacts)", "time takes 2 arguments"),
        ("max(rail.contacts)", "time(rail.contacts, 1) of the first"),
    ],
)
def test_what_is_no_contact_is_refused(text, said):
    with pytest.raises(ModelError) as caught:
        rt.loads(ball()).many({"e": [0.5]}, [text], 0.1)
    assert said in str(caught.value)


def test_where_nothing_touches_there_is_no_contact():
    with pytest.raises(ModelError, match="no joint has contacts, of which there is a time"):
        rt.loads(ball().split("stop =")[0]).many({"h": [1.0]}, ["time(rail.contacts, 1)"], 0.1)


def test_a_small_drop_beside_far_ground_points_is_a_drop():
    """A ball 0.18 mm above its stop, in a mechanism of 200 m."""
    h = 1.8e-4
    m = rt.loads(ball(h=h).replace("S = [0, -2]", "S = [200, -2]"))
    t1 = math.sqrt(2.0 * h / G)
    hits = [event.t for event in m.simulate(3.0 * t1).events]
    assert hits == pytest.approx([t1, 2.6 * t1], rel=1e-8)
    assert m.many({"h": [h]}, ["time(rail.contacts, 2)"], t_end=3.0 * t1)["time(rail.contacts, 2)"] == pytest.approx(
        2.6 * t1, rel=1e-8
    )
