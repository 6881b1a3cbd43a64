"""Belts: two strands that pull while they are stretched, open and crossed; what is refused."""

import math

import matplotlib.pyplot as plt
import numpy as np
import pytest

import rattle as rt
from rattle.plots.sketch import draw_at

pytestmark = pytest.mark.nojit

FINE = {"rtol": 1e-10, "atol": 1e-12}
K, T0, J = 1e5, 500.0, 0.5


def wheel(name, at, inertia=1.0):
    return f"""
[bodies.{name}]
points = {{ C = [0, 0] }}
mass = 1
inertia = {inertia}
[joints.{name}_pin]
type = "revolute"
connect = ["ground.{at}", "{name}.C"]
"""


def text(
    belt="", law="0", push="0", radii="[0.1, 0.2]", initial="two = { omega = 0 }", distance=0.5, turned=0.0, damping=0
):
    q = f"[{distance * math.cos(turned)!r}, {distance * math.sin(turned)!r}]"
    return f"""
format = 1
gravity = [0, 0]
[ground.points]
O = [0, 0]
Q = {q}
{wheel("one", "O")}{wheel("two", "Q", J)}
[joints.drive]
type = "belt"
connect = ["one.C", "two.C"]
radii = {radii}
stiffness = {K}
damping = {damping}
pretension = {T0}
{belt}
[drivers.motor]
joint = "one_pin"
angle = "{law}"
[loads.push]
type = "torque"
body = "two"
torque = "{push}"
[initial]
{initial}
"""


def test_a_loaded_pulley_swings_on_both_strands():
    """Stiffness 2 K r^2; tensions T0 +- K r phi, while both are stretched."""
    r2, t = 0.2, np.linspace(0.0, 0.04, 6)
    w = math.sqrt(2 * K * r2**2 / J)
    r = rt.loads(text(push="60")).simulate(0.04, t_eval=t, **FINE)
    phi = 60 / (2 * K * r2**2) * (1 - np.cos(w * t))
    assert r["two.angle"] == pytest.approx(phi, abs=1e-10)
    assert r["drive.tight"] == pytest.approx(T0 + K * r2 * phi, abs=1e-4)
    assert r["drive.slack"] == pytest.approx(T0 - K * r2 * phi, abs=1e-4)
    assert abs(r["energy.balance"]).max() < 1e-8


def test_a_slack_strand_does_not_push():
    """At rest in a damped belt a torque above 2 r T0 hangs on one strand alone: r K e = M."""
    r = rt.loads(text(push="300", damping=2000)).simulate(0.5, t_eval=[0, 0.5], rtol=1e-8, atol=1e-10)
    assert r["drive.slack"][1] == 0.0
    assert r["drive.tight"][1] == pytest.approx(300 / 0.2, rel=1e-5)
    assert r["two.angle"][1] == pytest.approx((300 / 0.2 - T0) / K / 0.2, rel=1e-5)
    assert any(e.kind == "contact" and e.t + e.duration < 0.4 for e in r.events), "one strand went slack"


@pytest.mark.machine
def test_pretension_is_energy_that_a_slack_strand_gives_back():
    """Two stretched strands hold T0^2/K; of it nothing is lost where one goes slack, if nothing damps."""
    r = rt.loads(text(push="300")).simulate(0.1, t_eval=[0, 0.1], **FINE)
    assert sum(e.kind == "release" for e in r.events) > 1
    assert r["energy.potential"][0] == pytest.approx(T0**2 / K, rel=1e-12)
    assert r["energy.dissipated"][-1] == pytest.approx(0.0, abs=1e-8)
    belt = r.power(0, 0.1).elements.set_index("element").loc["drive"]
    assert belt.lost == pytest.approx(0.0, abs=1e-6)
    assert belt.stored == pytest.approx(np.ptp(r["energy.potential"]), abs=1e-6)


def test_the_largest_tension_is_found_between_outputs():
    """Pushed by less than 2 r T0 it swings to twice the angle of rest, with T0 + M/r at most."""
    r = rt.loads(text(push="60")).simulate(0.1, t_eval=[0, 0.1], **FINE)
    value, t = r.peak("drive.tight")
    assert value == pytest.approx(T0 + 60 / 0.2, rel=1e-9)
    assert math.cos(math.sqrt(2 * K * 0.2**2 / J) * t) == pytest.approx(-1.0, abs=1e-6)


@pytest.mark.parametrize(("crossed", "sense"), [("false", 1), ("true", -1)])
def test_bearings_carry_both_strands_and_damping_takes_energy(crossed, sense):
    """The strands are inclined by asin((R_B -+ R_A)/l) to the line of centres."""
    r = rt.loads(text(f"crossed = {crossed}", turned=0.7)).simulate(0.01, t_eval=[0, 0.01], **FINE)
    incline = math.asin((0.2 - sense * 0.1) / 0.5)
    pull = 2 * T0 * math.cos(incline)
    assert [r["drive.fx"][0], r["drive.fy"][0]] == pytest.approx(
        [-pull * math.cos(0.7), -pull * math.sin(0.7)], abs=1e-9
    )
    assert abs(r["two.angle"][1]) < 1e-14
    swing = text(f"crossed = {crossed}", initial="two = { omega = 1 }", damping=20)
    r = rt.loads(swing).simulate(0.05, t_eval=[0, 0.05], **FINE)
    decay = 2 * 20 * 0.2**2 / J / 2
    w = math.sqrt(2 * K * 0.2**2 / J - decay**2)
    assert r["two.angle"][1] == pytest.approx(math.exp(-decay * 0.05) * math.sin(w * 0.05) / w, abs=1e-10)
    assert r["energy.dissipated"][1] > 0.0
    assert abs(r["energy.balance"]).max() < 1e-9


@pytest.mark.parametrize(
    ("crossed", "radii", "ratio"),
    [
        ("false", "[0.1, 0.2]", 0.5), ("true", "[0.1, 0.2]", -0.5), ("false", "[0.1, 0.1]", 1.0),
        ("false", "[0.1, 0.11]", 1 / 1.1),
    ],
)  # fmt: skip
def test_the_ratio_is_that_of_the_radii_over_many_turns(crossed, radii, ratio):
    made = text(f"crossed = {crossed}", "20*t", radii=radii, initial=f"two = {{ omega = {20 * ratio} }}", turned=3.1)
    r = rt.loads(made).simulate(1.0, t_eval=[0, 1.0], rtol=1e-8, atol=1e-10)
    assert r["two.angle"][1] == pytest.approx(20 * ratio, abs=1e-8)
    k = rt.loads(made).inverse_dynamics([0.0, 3.0])  # stiff: no stretch, no turning of the whole
    assert k["two.angle"][1] == pytest.approx(60 * ratio, abs=1e-10)
    assert k["drive.tight"] == pytest.approx([T0, T0], abs=1e-9)


def test_a_stiff_belt_carries_the_load_as_the_difference_of_its_strands():
    r = rt.loads(text(push="60")).inverse_dynamics([0.0])
    assert r["drive.tight"][0] - r["drive.slack"][0] == pytest.approx(60 / 0.2, abs=1e-9)
    assert abs(r["motor.torque"][0]) == pytest.approx(30.0, abs=1e-9)


def test_in_equilibrium_the_belt_is_stretched_by_its_load():
    (found,) = rt.loads(text(push="60")).equilibrium()
    assert found["two.angle"] == pytest.approx(60 / (2 * K * 0.2**2), abs=1e-9)


def test_a_belt_is_drawn_with_strands_that_touch_its_pulleys():
    m = rt.loads(text("crossed = true"))
    figure, ax = plt.subplots()
    draw_at(ax, m.kinematics([0.0]), 0)
    ends = [line.get_xydata() for line in ax.lines if len(line.get_xdata()) == 2]
    plt.close(figure)
    touching = 0
    for one, other in ends:
        along = other - one
        if np.hypot(*along) > 0.2 and abs(np.hypot(*one) - 0.1) < 1e-9:
            assert abs(along @ one) < 1e-9
            assert abs(np.hypot(*(other - [0.5, 0.0])) - 0.2) < 1e-9
            touching += 1
    assert touching == 2


@pytest.mark.parametrize(
    ("belt", "says"),
    [
        ('contact = "impact"', "stiffness and damping of its own"),
        ("clearance = 1e-3", "clearance"),
        ("length = 2", "no pin in a bush"),
    ],
)
def test_what_a_belt_cannot_have_is_refused(belt, says):
    with pytest.raises(rt.ModelError, match=says):
        rt.loads(text(belt))


def test_pulleys_that_overlap_are_refused():
    with pytest.raises(rt.AssemblyError, match=r"need their centres farther apart than 0\.3"):
        rt.loads(text(distance=0.25)).simulate(0.1)


def test_a_pretension_that_stretches_the_strands_by_more_than_their_length_is_refused():
    with pytest.raises(rt.AssemblyError, match="the belt is too short for its path"):
        rt.loads(text().replace(f"pretension = {T0}", f"pretension = {0.6 * K}")).simulate(0.1)


def test_a_rigid_stop_beside_an_elastic_belt_is_hit_and_keeps_the_energy():
    stop = {"max": 0.01, "contact": {"model": "impact", "restitution": 0.5}}
    m = rt.loads(text()).set({"joints.two_pin.stop": stop, "initial.two": {"angle": 0, "omega": 3}})
    r = m.simulate(0.1)
    assert r.success, r.message
    hits = [one for one in r.events if one.kind == "impact"]
    assert hits
    assert r["two_pin.angle"].max() < 0.01 + 1e-9
    assert r.trust.energy_balance < 1e-6 * np.abs(r["energy.kinetic"]).max() + 1e-9


# ---------------------------------------------------------------- slip
WRAP = math.pi - 2 * math.asin(0.1 / 0.5)  # about the pulley of 0.1 m


@pytest.mark.parametrize(
    ("mu", "crossed"),
    [(0.2, False), *(pytest.param(*one, marks=pytest.mark.machine) for one in ((None, False), (0.5, True)))],
)
def test_a_run_says_from_when_on_a_belt_would_slip_by_the_formula_of_eytelwein(mu, crossed):
    """Both strands bear T0 +- M/(2 r): they slip from M = 2 r T0 (E - 1)/(E + 1) on, E = exp(mu wrap)."""
    wrap = math.pi + 2 * math.asin(0.3 / 0.5) if crossed else WRAP
    most = math.exp((mu or 0.3) * wrap)
    moment = 2 * 0.2 * T0 * (most - 1) / (most + 1)
    more = (f"friction = {mu}\n" if mu else "") + ("crossed = true\n" if crossed else "")
    t = np.linspace(0.0, 2.0, 401)
    r = rt.loads(text(more, push=f"{moment}*t", damping=2000)).simulate(2.0, t_eval=t, rtol=1e-8, atol=1e-10)
    (note,) = [one for one in r.trust.notes if "would slip" in one]
    assert float(note.split("first at t = ")[1].split(" s")[0]) == pytest.approx(1.0, abs=0.02)
    assert f"friction holds {most:.3g} (Eytelwein, mu = {mu or 0.3:g}{'' if mu else ', assumed'}" in note
    assert f"wrap {math.degrees(wrap):.4g} deg" in note


def test_a_slack_strand_holds_nothing():
    r = rt.loads(text(push="300", damping=2000)).simulate(0.5)
    (note,) = [one for one in r.trust.notes if "would slip" in one]
    assert "without limit: the slack strand hangs" in note


@pytest.mark.parametrize(("more", "push"), [("", "20"), ("toothed = true", "300"), ("", "0")])
def test_a_belt_that_holds_or_has_teeth_has_no_such_note(more, push):
    r = rt.loads(text(more, push=push, damping=2000)).simulate(0.5)
    assert not [one for one in r.trust.notes if "would slip" in one]


def test_inverse_dynamics_says_it_too():
    t = np.linspace(0.0, 1.0, 101)
    r = rt.loads(text(push="100*t", initial="")).inverse_dynamics(t)
    (note,) = [one for one in r.trust.notes if "would slip" in one]
    most = math.exp(0.3 * WRAP)
    assert float(note.split("first at t = ")[1].split(" s")[0]) == pytest.approx(
        2 * 0.2 * T0 * (most - 1) / (most + 1) / 100, abs=0.011
    )
