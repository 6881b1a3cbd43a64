"""Measures by a click: against closed forms, and against what a run computes from their entry of [signals]."""

import math

import numpy as np
import pytest

import rattle as rt
from linkages import fourbar_text, parallelogram, slider_crank
from rattle.errors import InputError
from rattle.sketch.measure import angle, distance, mechanical_advantage, transmission_angle, unused_name
from rattle.sketch.over_a_turn import centrodes, path, paths

BARS = (0.1, 0.3, 0.25, 0.3)
START = "crank = { angle = 1 }\ncoupler = { angle = 0.4 }\nrocker = { angle = 1.6 }"


def fourbar(**play):
    text = fourbar_text('joint = "A"\nangle = "1 + 20*t"', *BARS, START)
    for name, more in play.items():
        text = text.replace(f"[joints.{name}]\n", f"[joints.{name}]\n{more}\n")
    return rt.loads(text)


def crank_rocker(crank):
    """Angles of coupler and rocker of the same four-bar, its open branch, by the law of cosines."""
    a, b, c, d = BARS
    x, y = d - a * math.cos(crank), -a * math.sin(crank)
    diagonal = math.hypot(x, y)
    at_d = math.acos((c * c + diagonal**2 - b * b) / (2 * c * diagonal))
    rocker = math.atan2(y, x) + math.pi - at_d
    cx, cy = d + c * math.cos(rocker), c * math.sin(rocker)
    return math.atan2(cy - a * math.sin(crank), cx - a * math.cos(crank)), rocker


def in_a_run(m, *measures, t=0.05):
    """What a run with these signals computes, at its start and at the end, and the result."""
    for measure in measures:
        m = m.signal(measure.name, measure.expression)
    result = m.simulate(t_end=t)
    return result, [(float(result[measure.name][0]), float(result[measure.name][-1])) for measure in measures]


def test_the_four_bar_of_the_formulas_is_that_of_the_model():
    coupler, rocker = crank_rocker(1.0)
    assert fourbar().start.q[[5, 8]] == pytest.approx([coupler, rocker], abs=1e-9)


def test_a_distance_and_an_angle_are_those_of_the_triangle_and_of_a_run():
    m = fourbar()
    coupler, rocker = crank_rocker(1.0)
    span = distance(m, "crank.B", "ground.D")
    assert span.value == pytest.approx(math.hypot(0.3 - 0.1 * math.cos(1.0), 0.1 * math.sin(1.0)), rel=1e-12)
    corner = angle(m, "ground.D", "coupler.C", "coupler.B")
    assert corner.value == pytest.approx(rocker - coupler, rel=1e-9)
    assert (span.unit, corner.unit) == ("m", "rad")
    result, values = in_a_run(fourbar(), span, corner)
    assert [begin for begin, _ in values] == pytest.approx([span.value, corner.value], rel=1e-9)
    coupler, rocker = crank_rocker(result["crank.angle"][-1])
    assert values[1][1] == pytest.approx(rocker - coupler, rel=1e-7)


def test_a_place_without_a_name_is_measured_too():
    m = fourbar()
    span = distance(m, ("coupler", (0.02, 0.05)), ("ground", (-0.1, 0.2)))
    x, y, turn = m.start.q[3:6]
    c, s = math.cos(turn), math.sin(turn)
    assert span.value == pytest.approx(math.hypot(x + 0.02 * c - 0.05 * s + 0.1, y + 0.02 * s + 0.05 * c - 0.2))
    _, values = in_a_run(fourbar(), span)
    assert values[0][0] == pytest.approx(span.value, rel=1e-9)


def test_the_transmission_angle_of_a_crank_rocker_is_in_its_known_limits():
    """Least and largest where the crank lies along the ground: cos mu = (b^2 + c^2 - (d -+ a)^2)/(2 b c)."""
    a, b, c, d = BARS
    m = fourbar()
    mu = transmission_angle(m, "C")
    coupler, rocker = crank_rocker(1.0)
    assert mu.value == pytest.approx(rocker - coupler, rel=1e-9)
    ideal = fourbar().signal(mu.name, mu.expression)
    curve = ideal.kinematics(np.linspace(0, math.tau / 20, 2001))[mu.name]
    ends = [math.acos((b * b + c * c - (d + sign * a) ** 2) / (2 * b * c)) for sign in (-1, 1)]
    ends = [min(end, math.pi - end) for end in ends]
    assert curve.min() == pytest.approx(min(ends), abs=1e-5)
    assert mu.entry == f'transmission_C = "{mu.expression}"'


def test_the_transmission_angle_of_a_slider_is_taken_from_the_normal_of_its_guide():
    m = rt.loads(slider_crank())
    mu = transmission_angle(
        m, next(name for name, j in m.model.joints.items() if {j.a.body, j.b.body} == {"rod", "slider"})
    )
    assert mu.value == pytest.approx(math.pi / 2 - abs(m.start.q[5]), rel=1e-9)
    _, values = in_a_run(rt.loads(slider_crank()), mu)
    assert values[0][0] == pytest.approx(mu.value, rel=1e-9)


def test_the_mechanical_advantage_balances_a_torque():
    """With the force that it gives at the rocker, inverse dynamics of the massless motion needs a unit torque."""
    m = fourbar()
    gain = mechanical_advantage(m, "motor", "rocker.C")
    a, _, c, _ = BARS
    coupler, rocker = crank_rocker(1.0)
    ratio = a * math.sin(1.0 - coupler) / (c * math.sin(rocker - coupler))  # rate of the rocker over that of the crank
    assert gain.value == pytest.approx(1.0 / (c * abs(ratio)), rel=1e-9)
    assert gain.unit == "1/m"
    direction = rocker + math.pi / 2
    signed = mechanical_advantage(m, "motor", "rocker.C", direction)
    assert signed.value == pytest.approx(1.0 / (c * ratio), rel=1e-9)
    _result, values = in_a_run(fourbar(), gain)
    assert values[0][0] == pytest.approx(gain.value, rel=1e-8)
    force = f"[{signed.value * math.cos(direction)!r}, {signed.value * math.sin(direction)!r}]"
    still = fourbar_text(
        'joint = "A"\nangle = 1', *BARS, START, f'[loads.f]\ntype = "force"\nat = "rocker.C"\nforce = {force}'
    )
    balanced = rt.loads(still.replace("-9.81", "0")).inverse_dynamics([0.0])
    assert abs(balanced["motor.torque"][0]) == pytest.approx(1.0, rel=1e-8)


def test_the_mechanical_advantage_of_a_point_at_rest_is_infinite():
    assert mechanical_advantage(fourbar(), "motor", "crank.A").value == math.inf


def test_play_does_not_hide_the_mechanical_advantage():
    play = 'clearance = "0.2 mm"\ncontact = "impact"'
    loose, tight = (mechanical_advantage(m, "motor", "rocker.C").value for m in (fourbar(B=play, C=play), fourbar()))
    assert loose == pytest.approx(tight, rel=1e-9)


def test_the_path_of_the_crank_pin_is_a_circle_of_one_turn():
    drawn = path(fourbar(), "crank.B")
    assert not drawn.words
    assert np.hypot(drawn.x, drawn.y) == pytest.approx(0.1, rel=1e-12)
    assert np.unwrap(np.arctan2(drawn.y, drawn.x))[-1] - 1.0 == pytest.approx(math.tau, rel=1e-9)


def test_paths_of_many_places_are_those_of_a_run_and_their_names_differ():
    places = ["coupler.C", ("coupler", (0.1, 0.08)), ("coupler", (0.0, -0.05))]
    drawn = paths(fourbar(), places)
    names = [name for each in drawn for name in each.signals]
    assert len(set(names)) == 6
    m = fourbar()
    for each in drawn:
        for name, expression in each.signals.items():
            m = m.signal(name, expression)
    run = m.kinematics(drawn[0].t)
    for each in drawn:
        for name, curve in zip(each.signals, (each.x, each.y), strict=True):
            assert run[name] == pytest.approx(curve, abs=1e-12)


def test_the_centrodes_of_a_crank_are_its_pivot():
    curves = centrodes(fourbar(), "crank")
    assert curves.fixed == pytest.approx(0.0, abs=1e-12)
    assert curves.moving == pytest.approx(np.tile([-0.05, 0.0], (len(curves.t), 1)), abs=1e-12)


def test_the_instant_centre_of_the_coupler_is_where_crank_and_rocker_meet():
    curves = centrodes(fourbar(), "coupler")
    for t, (x, y) in zip(curves.t, curves.fixed, strict=True):
        crank = 1.0 + 20.0 * t
        _, rocker = crank_rocker(crank)
        if math.isnan(x):
            assert abs(math.sin(crank - rocker)) < 0.02, "nearly parallel"
            continue
        assert y * math.cos(crank) - x * math.sin(crank) == pytest.approx(0.0, abs=1e-7 * (1 + math.hypot(x, y)))
        assert y * math.cos(rocker) - (x - 0.3) * math.sin(rocker) == pytest.approx(
            0.0, abs=1e-7 * (1 + math.hypot(x, y))
        )


def test_one_centrode_rolls_on_the_other():
    """Arcs of both curves between the same instants are equally long."""
    curves = centrodes(fourbar(), "coupler", "rocker")
    fixed, moving = (np.hypot(*np.diff(curve, axis=0).T) for curve in (curves.fixed, curves.moving))
    near = fixed < 0.02
    assert near.sum() > 50
    assert moving[near] == pytest.approx(fixed[near], rel=2e-3)


def test_the_instant_centre_is_what_its_signals_compute():
    curves = centrodes(fourbar(), "coupler", "crank")
    m = fourbar()
    for name, expression in curves.signals.items():
        m = m.signal(name, expression)
    run, pin = m.kinematics(curves.t), path(fourbar(), "crank.B")
    for name, curve in zip(curves.signals, (pin.x, pin.y), strict=True):
        assert run[name] == pytest.approx(curve, abs=1e-9), "coupler and crank turn about their pin"


def test_parallel_motion_has_no_instant_centre():
    curves = centrodes(rt.loads(parallelogram()), "coupler")
    assert np.isnan(curves.fixed).all()
    assert "does not turn" in curves.words
    m = rt.loads(parallelogram())
    for name, expression in curves.signals.items():
        m = m.signal(name, expression)
    assert m.simulate(t_end=0.1).success, "a signal without a value ends no run"


def test_names_of_signals_are_new():
    m = fourbar().signal("distance", "crank.x")
    assert distance(m, "crank.A", "crank.B").name == "distance_2"
    assert unused_name(m, "motor", ["motor_2"]) == "motor_3"
    assert unused_name(m, "sin") == "sin_2"


@pytest.mark.parametrize(
    ("ask", "words"),
    [
        (lambda m: distance(m, "crank.X", "ground.D"), "'crank' has no point 'X'"),
        (lambda m: distance(m, "crnk.A", "ground.D"), "did you mean 'crank'"),
        (lambda m: distance(m, ("crank", (math.nan, 0.0)), "ground.D"), "two finite numbers"),
        (lambda m: transmission_angle(m, "Q"), "there is no joint 'Q'"),
        (lambda m: transmission_angle(m, "C", ("D", "")), "joint 'D' is not one of 'coupler'"),
        (lambda m: mechanical_advantage(m, "moter", "crank.B"), "did you mean 'motor'"),
        (lambda m: mechanical_advantage(m.remove("joints.D"), "motor", "crank.B"), "2 degrees of freedom are left"),
        (lambda m: centrodes(m, "crank", "crank"), "of two bodies"),
        (lambda m: path(m.remove("drivers.motor"), "crank.B"), "needs a motor"),
    ],
)
def test_what_cannot_be_measured_is_refused(ask, words):
    with pytest.raises(InputError, match=words):
        ask(fourbar())
