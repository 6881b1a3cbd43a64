"""Moreau-Jean time stepping: the same motion as with located events, at first order."""

import math

import numpy as np
import pytest

import rattle as rt


def impacts(r, joint=None):
    return sorted({one.t for one in r.events if one.kind == "impact" and joint in (None, one.joint)})


@pytest.fixture(scope="module")
def plays():
    return rt.example("three_plays").simulate(1.0, t_eval=[0.0, 0.2, 0.5, 1.0], step=2e-5)


def test_three_plays_under_control_follow_the_published_run(plays):
    # Siconos example FourBarLinkageWith3clearance, as given in its reference output
    want = [(2.9442292, 0.5899504, 1.8386510), (5.5456132, 0.9158035, 1.4996568), (4.2384556, 0.9189912, 1.9955522)]
    got = np.array([plays[f"{body}.angle"][1:] for body in ("crank", "coupler", "rocker")]).T
    assert got == pytest.approx(np.array(want), abs=1e-3)
    force = np.array([plays[f"{joint}.normal"][1:] for joint in "BCD"]).T
    # published are impulses of one step over the step: they scatter by 2 % about the forces at the instants
    assert force == pytest.approx(
        np.array([(103.27, 37.78, 38.67), (51.33, 0, 10.99), (130.41, 39.33, 26.29)]), rel=0.02, abs=1e-9
    )


def test_friction_of_three_plays_stays_in_its_cone_and_joints_stay_closed(plays):
    for joint in "BCD":
        assert (np.abs(plays[f"{joint}.tangential"]) <= 0.1 * plays[f"{joint}.normal"] * (1 + 1e-9) + 1e-12).all()
        assert plays[f"{joint}.penetration"].max() < 1e-9
    assert plays.trust.drift < 1e-12


def test_both_methods_agree_on_three_plays(plays):
    event = rt.example("three_plays").simulate(1.0, t_eval=[0.0, 0.2, 0.5, 1.0], method="event", rtol=1e-9)
    for body in ("crank", "coupler", "rocker"):
        assert plays[f"{body}.angle"] == pytest.approx(event[f"{body}.angle"], abs=1e-3)
    assert event.trust.energy_balance < 1e-7


def test_guide_of_moreau_and_jean_meets_the_reference():
    r = rt.example("guide_play").simulate(0.1, t_eval=[0.0, 0.01, 0.1], method="moreau", step=1e-5)
    turns = r["crank.angle"][1:] / (2 * math.pi)
    assert turns == pytest.approx([0.1508727302, 1.4324963219], abs=1e-3)
    hits = np.array(impacts(r))
    for t in (0.002692502752, 0.005612363190, 0.007475056212, 0.025889562876):
        assert np.abs(hits - t).min() < 2e-5


def test_error_falls_with_the_step_at_first_order():
    m = rt.example("guide_play")
    exact = m.simulate(0.02, t_eval=[0.0, 0.02], method="event", rtol=1e-11, atol=1e-13)["crank.angle"][-1]
    steps = np.array([8e-5, 4e-5, 2e-5, 1e-5, 5e-6, 2.5e-6])
    errors = [
        abs(m.simulate(0.02, t_eval=[0.0, 0.02], method="moreau", step=h)["crank.angle"][-1] - exact) for h in steps
    ]
    # an impact acts from the end of its step on: up to a step late, so that the error of each is up to its change of
    # rate times the step and scatters below; no power but the first keeps their ratio within 5 over a factor of 32
    ratio = np.array(errors) / steps
    assert ratio.max() < 5.0  # [rad/s], the size of what impacts change
    assert ratio.max() < 5.0 * ratio.min()


def test_between_impacts_error_falls_at_second_order():
    m = rt.example("guide_play")
    flight = 0.0025  # the first impact is at 2.69 ms
    exact = m.simulate(flight, t_eval=[0.0, flight], method="event", rtol=1e-12, atol=1e-14)["crank.angle"][-1]
    errors = [
        abs(m.simulate(flight, t_eval=[0.0, flight], method="moreau", step=flight / n)["crank.angle"][-1] - exact)
        for n in (25, 50, 100, 200)
    ]
    # forces at the midpoint of the step; 0.05: what the next order leaves at 25 steps
    assert np.diff(np.log2(errors)) == pytest.approx([-2.0, -2.0, -2.0], abs=0.05)


def test_one_sided_fourbar_agrees_with_events_while_it_is_predictable():
    m = rt.example("fourbar_onesided")
    times = np.linspace(0.0, 0.05, 11)
    event = m.simulate(t_eval=times)
    moreau = m.simulate(t_eval=times, method="moreau", step=5e-6)
    assert moreau["coupler.angle"] == pytest.approx(event["coupler.angle"], abs=2e-4)
    assert moreau["rocker.angle"] == pytest.approx(event["rocker.angle"], abs=2e-4)
    assert moreau["O3.normal"].min() >= 0.0


def test_bouncing_pin_loses_what_restitution_says():
    r = rt.example("bouncing_pin").simulate(0.02, method="moreau", step=1e-6)
    u = math.sin(math.radians(40))
    assert math.hypot(r["pin.vx"][-1], r["pin.vy"][-1]) == pytest.approx(u, abs=1e-2)
    assert r["energy.dissipated"][-1] == pytest.approx(0.5 * math.cos(math.radians(40)) ** 2, rel=2e-2)
    assert r["O.normal"][-1] == pytest.approx(u * u / 1e-3, rel=2e-2)


def test_step_is_chosen_when_none_is_given_and_methods_have_names():
    r = rt.example("bouncing_pin").simulate(2e-3, method="moreau")
    assert r.success
    assert r.provenance["step"] == pytest.approx(1e-7)
    with pytest.raises(ValueError, match="unknown method"):
        rt.example("bouncing_pin").simulate(1e-3, method="jean")


def test_methods_of_impact_leave_other_models_to_theirs():
    r = rt.example("slider_crank").simulate(1e-3, method="moreau")
    assert r.provenance["method"] == "dop853"


def test_chain_of_loose_pins_hangs_from_its_first():
    links, weight = 6, 9.81
    points = "\n".join(
        f'[bodies.l{n}]\nbar = ["A", "B"]\nlength = 0.1\nmass = 1\n'
        f'[joints.j{n}]\ntype = "revolute"\nconnect = ["{"ground.O" if n == 0 else f"l{n - 1}.B"}", "l{n}.A"]\n'
        f'clearance = "1 mm"\ncontact = {{ model = "impact", friction = 0.2, bush_radius = "10 mm" }}\n'
        for n in range(links)
    )
    initial = "\n".join(
        f'l{n} = {{ angle = "-pi/2", x = 0, y = {-0.05 - 0.1 * n - 1e-3 * (n + 1)}, vx = 0, vy = 0, omega = 0 }}'
        for n in range(links)
    )
    text = f"format = 1\ngravity = [0, {-weight}]\n[ground.points]\nO = [0, 0]\n{points}\n[initial]\n{initial}\n"
    for method in ("moreau", "event"):
        r = rt.loads(text).simulate(0.05, method=method)
        assert r.success, r.message
        for n in range(links):
            assert r[f"j{n}.normal"][-1] == pytest.approx((links - n) * weight, rel=1e-6)
