"""Clutches, friction and stops whose coordinates the joints, or each other, keep from moving; dead centres."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rattle as rt
from linkages import fourbar_text
from mode_enumeration import no_friction_agrees, one_sided_rows_contradict, stopped
from random_mechanisms import FAMILIES, mechanism

A, B, C, D = 0.1, 0.3, 0.25, 0.28
SLIPS = '[joints.c]\ntype = "clutch"\nconnect = ["ground", "rocker"]\nmax_torque = 3\nsense = {}\n'


def dead_centres() -> list[float]:
    """The largest and least angle of the rocker, with crank and coupler in line."""
    return [math.pi - math.acos((C * C + D * D - (B + s * A) ** 2) / (2 * C * D)) for s in (-1, 1)]


def crank_rocker(sense: int, driven: bool) -> rt.Mechanism:
    far = math.hypot(D - A * math.cos(1.0), A * math.sin(1.0))
    coupler = math.atan2(-A * math.sin(1.0), D - A * math.cos(1.0)) + math.acos(
        (B * B + far**2 - C * C) / (2 * B * far)
    )
    at = A * math.cos(1.0) + B * math.cos(coupler), A * math.sin(1.0) + B * math.sin(coupler)
    rocker = math.atan2(at[1], at[0] - D)
    omega = "" if driven else ", omega = 10"
    start = f"crank = {{ x = 0, y = 0, angle = 1.0{omega} }}\ncoupler = {{ angle = {coupler!r} }}\n"
    start += f"rocker = {{ angle = {rocker!r} }}\n"
    text = fourbar_text('joint = "A"\nangle = "1 + 10*t"', A, B, C, D, start, joints=SLIPS.format(sense))
    text = text.replace("gravity = [0, -9.81]", "gravity = [0, 0]")
    text = text if driven else text.replace('[drivers.motor]\njoint = "A"\nangle = "1 + 10*t"\n', "")
    text = text.replace(f'bar = ["A", "B"]\nlength = {A}', "points = { A = [0, 0], B = [0.1, 0] }\ninertia = 2")
    return rt.loads(text)


def test_a_clutch_that_slips_on_a_rocker_passes_its_dead_centres():
    """Driven, its row moves nothing at all; two turns cost twice the torque times the swing."""
    for sense in (1, -1):
        run = crank_rocker(sense, True).simulate(0.4 * math.pi, rtol=1e-9)
        high, low = dead_centres()
        assert run.success
        assert abs(run["energy.dissipated"][-1] - 2 * 3 * (high - low)) < 1e-6


def test_a_clutch_that_slips_on_a_free_linkage_passes_its_dead_centres():
    """Where the rocker rests its clutch can move nothing, in every sense: the mechanism goes on."""
    for sense in (1, -1):
        run = crank_rocker(sense, False).simulate(1.2, rtol=1e-9)
        assert run.success
        assert abs(run["energy.balance"]).max() < 1e-7 * run["energy.kinetic"].max()


def braced(seed: int, more: str, pin: str = "") -> str:
    """A pendulum of two bars that a rod braces, so that they cannot turn against each other."""
    rng = np.random.default_rng(seed)
    length, omega, place = float(rng.uniform(0.3, 1)), float(rng.uniform(-3, 3)), float(rng.uniform(0.2, 0.8))
    return f"""
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.a]
bar = ["P", "Q"]
length = 1
mass = 1
points = {{ S = [{place - 0.5!r}, 0] }}
[bodies.b]
bar = ["Q", "R"]
length = {length!r}
mass = 2
[joints.O]
type = "revolute"
connect = ["ground.O", "a.P"]
[joints.Q]
type = "revolute"
connect = ["a.Q", "b.Q"]
{pin}
[joints.brace]
type = "rod"
connect = ["a.S", "b.R"]
length = {length + 0.1!r}
{more}
[initial]
a = {{ angle = 0, omega = {omega!r} }}
"""


@pytest.mark.parametrize("what", ["clutch", "pin"])
def test_what_acts_across_a_pin_that_cannot_turn_changes_no_motion(what):
    """A clutch there, or friction, is a matter of the reactions: no events, no loss, a torque that is not unique."""
    clutch = '[joints.c]\ntype = "clutch"\nconnect = ["a", "b"]\n'
    rubs = 'friction = { model = "coulomb", mu = 0.2, pin_radius = "10 mm" }'
    run_of = 0
    for seed in range(10):
        try:
            plain = rt.loads(braced(seed, "")).simulate(1.0, t_eval=[0, 1.0])
        except rt.AssemblyError:
            continue
        run = rt.loads(braced(seed, clutch if what == "clutch" else "", rubs if what == "pin" else "")).simulate(
            1.0, t_eval=[0, 1.0]
        )
        assert run.success
        assert abs(run["a.angle"][-1] - plain["a.angle"][-1]) < 1e-6
        assert not run.events
        assert run["energy.dissipated"][-1] == 0.0
        assert any("not unique" in note for note in run.trust.notes)
        run_of += 1
    assert run_of >= 5


WHEEL = """
format = 1
[ground.points]
O = [0, 0]
[bodies.w]
points = { C = [0, 0] }
mass = 1
inertia = 1
[joints.pin]
type = "revolute"
connect = ["ground.O", "w.C"]
"""


@pytest.mark.parametrize("law", ["newton", "poisson", "energetic"])
def test_a_backstop_lets_no_wheel_bounce_from_its_stop(law):
    stop = f'stop = {{ max = 1, contact = {{ model = "impact", restitution = 0.5, restitution_law = "{law}" }} }}\n'
    clutch = '[joints.c]\ntype = "clutch"\nconnect = ["ground", "w"]\n[initial]\nw = { omega = 2 }\n'
    run = rt.loads(WHEEL + stop + clutch).simulate(1.0)
    assert run.success
    assert abs(run["w.angle"][-1] - 1.0) < 1e-12
    assert run["w.omega"][-1] == 0.0
    assert abs(run["energy.dissipated"][-1] - 2.0) < 1e-12


@pytest.mark.parametrize("second", [1, -1])
def test_two_clutches_side_by_side_hold_as_one_and_are_named(second):
    """In the same sense they are one backstop, in opposite senses the wheel is locked."""
    clutches = "".join(
        f'[joints.c{k}]\ntype = "clutch"\nconnect = ["ground", "w"]\nsense = {s}\n' for k, s in enumerate((1, second))
    )
    run = rt.loads(f'{WHEEL}{clutches}[loads.l]\ntype = "torque"\nbody = "w"\ntorque = "-4*cos(3*t)"\n').simulate(2.0)
    assert run.success
    if second == -1:
        assert abs(run["w.angle"]).max() < 1e-12
    else:  # free from cos = 0 on
        t = 2.0 - math.pi / 6
        assert abs(run["w.angle"][-1] - 4 / 9 * (3 * t - math.sin(3 * t))) < 1e-8
    assert any("torque of" in note and "not unique" in note for note in run.trust.notes)


def test_words_name_what_is_in_the_model():
    """A mechanism without drivers is not pushed by drivers, and one without friction is not locked by it."""
    for family in FAMILIES:
        for seed in range(12):
            written = mechanism(seed, family)
            try:
                message = rt.loads(written).simulate(1.0, t_eval=[0, 1.0], most_steps=20_000).message
            except (rt.ModelError, rt.AssemblyError):
                continue
            assert ("drivers push" not in message) or ("[drivers." in written)
            assert ("friction" not in message) or ("friction =" in written)
            assert "without end" not in message


@pytest.mark.parametrize("mu", [0.0, 0.5, 0.8])
def test_a_guide_that_rubs_takes_its_share_of_an_impact(mu):
    """A bar on a block strikes a stop; the guide's impulse is known from the momentum of both, by hand."""
    friction = f"friction = {mu}\n" if mu else ""
    text = f"""
format = 1
[ground.points]
O = [0, 0]
[bodies.block]
points = {{ C = [0, 0] }}
mass = 2
inertia = 1
[bodies.bar]
bar = ["C", "E"]
length = 1
mass = 1
[joints.g]
type = "prismatic"
connect = ["ground.O", "block.C"]
{friction}
[joints.h]
type = "revolute"
connect = ["block.C", "bar.C"]
stop = {{ min = -0.5, contact = {{ model = "impact", restitution = 0 }} }}
[initial]
block = {{ x = 0, y = 0, vx = 0 }}
bar = {{ angle = -0.499999, omega = -5 }}
"""
    run = rt.loads(text).simulate(0.02, t_eval=[0, 1e-6, 0.02], rtol=1e-10)
    along, across = 2.5 * math.sin(0.5), 2.5 * math.cos(0.5)
    assert run["block.vx"][1] == pytest.approx(-max(along - mu * across, 0.0) / 3, abs=1e-5)
    assert abs(run["energy.balance"]).max() < 1e-9


def test_impacts_with_friction_in_joints_keep_the_energy_balance():
    """Stops, clutches and friction at random: what an impact takes is what contacts, stops and joints have lost."""
    impacts = 0
    for seed in range(40):
        text = mechanism(seed, "mixed")
        if "drivers" in text:
            continue
        try:
            run = rt.loads(text).simulate(0.5, t_eval=[0, 0.5], most_steps=20_000)
        except (rt.ModelError, rt.AssemblyError):
            continue
        impacts += sum(event.kind == "impact" for event in run.events)
        assert abs(run["energy.balance"]).max() < 1e-6 * max(1.0, run["energy.kinetic"].max())
    assert impacts > 0


def test_powers_balance_over_impacts_in_which_joints_rub():
    """What bodies and loads give is what joints lose and supply, with the impulses of their friction."""
    impacts = 0
    for seed in range(40):
        text = mechanism(seed, "mixed")
        if "friction" not in text:
            continue
        try:
            run = rt.loads(text).simulate(0.5, t_eval=[0, 0.5], most_steps=20_000, rtol=1e-9)
        except (rt.ModelError, rt.AssemblyError):
            continue
        hits = sum(event.kind == "impact" for event in run.events)
        if not run.success or hits == 0:
            continue
        impacts += hits
        cycle = run.power(0.0, 0.5).cycle
        turnover = cycle.into.sum() + cycle.out.sum()
        assert cycle.lost.sum() == pytest.approx(run["energy.dissipated"][-1], abs=1e-6 * turnover), seed
        assert cycle.supplied.sum() == pytest.approx(run["energy.work"][-1], abs=1e-6 * turnover), seed
        gained = run["energy.kinetic"][-1] - run["energy.kinetic"][0] - run["energy.dissipated"][0]  # of the start
        assert (cycle.into - cycle.out).sum() == pytest.approx(gained, abs=1e-6 * turnover), seed
    assert impacts > 0


HARD = {  # rows that friction which slips, rounding, or a dead centre at a coarse tolerance make hard to decide
    "friction": [19, 63, 137],
    "clutches": [1, 23, 112, 120, 124, 144],
    "stops": [108, 110],
    "mixed": [29, 70, 129, 135, 145, 256, 281, 298],
}


@pytest.mark.parametrize("rtol", [1e-6, 1e-8])
@pytest.mark.parametrize("family", FAMILIES)
def test_a_random_mechanism_stops_only_where_no_motion_is_possible(family, rtol):
    """Every stop is proven, by a linear programme or by trying all modes of friction, and no run that goes on is."""
    for seed in [*range(30 if rtol == 1e-8 else 10), *HARD[family]]:
        try:
            run = stopped(mechanism(seed, family), 1.0, rtol)
        except (rt.ModelError, rt.AssemblyError):
            continue
        proof = no_friction_agrees if "friction locks" in run.message else one_sided_rows_contradict
        assert proof(run) == bool(run.message), f"{family} {seed} at {rtol}: {run.message}"
