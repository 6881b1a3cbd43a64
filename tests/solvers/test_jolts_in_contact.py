"""Drivers that jump in speed while contacts are closed, with play of every kind."""

from __future__ import annotations

import math

import numpy as np
import pytest

import rattle as rt

JUMP = 3.0  # [rad/s]


def hanging(contact, sense=1.0, **more):
    """A crank whose end carries a pendulum by a pin with play; it starts to turn at 0.2 s."""
    m = rt.Mechanism("hanging", gravity=[0, -9.81])
    m.ground(O=[0, 0])
    m.bar("crank", "O", "A", length=0.3, mass=1.0)
    m.bar("rod", "A", "B", length=0.4, mass=2.0)
    m.revolute("O", "ground.O", "crank.O")
    m.revolute("A", "crank.A", "rod.A", clearance=0.001, contact=contact)
    m.driver("motor", "O", angle=f"{sense * JUMP}*max(0, t - 0.2)")
    m.initial("rod", angle=-math.pi / 2, omega=0.0)
    m.initial("A", offset=[0.0, -0.001])
    return m


# a bar hangs at rest below the end of a level crank: a jump of the crank by w lifts that end with 0.3 w
LEVER, ROD = 0.3, 2.0
CRANK = 1.0 * LEVER**2 / 3


@pytest.mark.parametrize("contact", ["impact", {"model": "impact", "restitution": 0.7}])
def test_a_jolt_that_lifts_a_resting_pin_takes_its_load_along(contact):
    result = hanging(contact).simulate(0.25, t_eval=[0.1, 0.2, 0.21, 0.25], rtol=1e-10)
    assert result.success
    jolt = next(event for event in result.events if event.kind == "jolt")
    # the pin is pushed straight through the mass centre below it: the bar rises with the crank's end, nothing turns
    assert result["rod.vy"][1] == pytest.approx(LEVER * JUMP, rel=1e-9)
    assert jolt.impulse == pytest.approx((CRANK + ROD * LEVER**2) * JUMP, rel=1e-9)
    assert -jolt.energy_lost == pytest.approx(0.5 * (CRANK + ROD * LEVER**2) * JUMP**2, rel=1e-9)
    blow = next(event for event in result.events if event.kind == "impact" and event.t == jolt.t)
    assert (blow.joint, blow.impulse) == ("A", pytest.approx(ROD * LEVER * JUMP, rel=1e-9))
    assert result.trust.energy_balance < 1e-8


def test_a_jolt_that_drops_the_bush_leaves_the_pin_behind():
    result = hanging("impact", sense=-1.0).simulate(0.203, t_eval=[0.1, 0.2, 0.202], rtol=1e-10)
    jolt = next(event for event in result.events if event.kind == "jolt")
    assert jolt.impulse == pytest.approx(-CRANK * JUMP, rel=1e-12)  # the crank alone: a pin does not pull
    assert result["rod.vy"][1] == pytest.approx(0.0, abs=1e-12)
    assert result["rod.vy"][2] == pytest.approx(-9.81 * 0.002, rel=1e-9)  # it falls
    assert any(event.kind == "release" and event.t == jolt.t for event in result.events)


def test_a_jolt_does_not_see_the_pin_of_a_compliant_contact():
    contact = {"model": "hunt-crossley", "stiffness": 1e8, "exponent": 1.5, "restitution": 0.8}
    result = hanging(contact).simulate(0.21, t_eval=[0.1, 0.2, 0.21], rtol=1e-10)
    jolt = next(event for event in result.events if event.kind == "jolt")
    assert jolt.impulse == pytest.approx(CRANK * JUMP, rel=1e-12)  # a finite force has no impulse at an instant
    assert result["crank.omega"][1] == pytest.approx(JUMP, rel=1e-12)
    assert result["rod.vy"][2] == pytest.approx(LEVER * JUMP, rel=0.01)  # soon after, but for what the pin still swings
    assert result.trust.energy_balance < 1e-7


def test_a_massless_link_passes_the_jolt_on():
    result = hanging("massless-link").simulate(0.21, t_eval=[0.1, 0.2, 0.21], rtol=1e-10)
    jolt = next(event for event in result.events if event.kind == "jolt")
    assert jolt.impulse == pytest.approx((CRANK + ROD * LEVER**2) * JUMP, rel=1e-9)
    assert result.trust.energy_balance < 1e-9


def test_moreau_ends_steps_on_jolts_and_agrees():
    exact = hanging("impact").simulate(0.3, t_eval=[0.2, 0.3], rtol=1e-10)
    steps = [2e-4, 1e-4, 5e-5]
    error = []
    for step in steps:
        result = hanging("impact").simulate(0.3, t_eval=[0.2, 0.3], method="moreau", step=step)
        assert [event.t for event in result.events if event.kind == "jolt"] == [0.2]
        error.append(abs(result["rod.y"][1] - exact["rod.y"][1]))
    assert error[-1] < 1e-4  # of a lift of 0.09 m: first order in the step
    assert error[-1] < 0.8 * error[0]


def test_a_sliding_block_feels_the_floor_in_the_jolt():
    """A rough block on a rough floor, pulled by a driver along a slope: friction takes its share of the impulse."""
    m = rt.Mechanism("block on a floor", gravity=[0, -9.81])
    m.ground(G=[0, 0])
    m.body("block", points={"C": [0, 0]}, mass=2.0, inertia=0.1)
    m.prismatic("floor", "ground.G", "block.C", clearance=0.001, block={"length": 0.2, "height": 0.1},
                contact={"model": "impact", "friction": 0.25})  # fmt: skip
    m.driver("pull", body="block", coordinate="x", position="2*max(0, t - 0.1)")
    m.initial("block", y=-0.001)
    result = m.simulate(0.2, t_eval=[0.05, 0.1, 0.2], rtol=1e-10)
    jolt = next(event for event in result.events if event.kind == "jolt")
    # the pull is level and so is the floor: no percussion of the floor, no friction in the jolt
    assert jolt.impulse == pytest.approx(2.0 * 2.0, rel=1e-9)
    np.testing.assert_allclose(result["pull.force"][1:], 0.25 * 2 * 9.81, atol=1e-7)
    assert result.trust.energy_balance < 1e-8


def test_contacts_find_their_modes_anew_where_a_load_switches():
    """A block at rest on a rough floor starts to slide at the instant its pull jumps beyond friction."""
    m = rt.Mechanism("pulled block", gravity=[0, -9.81])
    m.ground(G=[0, 0])
    m.body("block", points={"C": [0, 0]}, mass=2.0, inertia=0.1)
    m.prismatic("floor", "ground.G", "block.C", clearance=0.001, block={"length": 0.2, "height": 0.1},
                contact={"model": "impact", "friction": 0.25})  # fmt: skip
    m.load("pull", type="force", at="block.C", force=["3 + 5*step(t - 0.1)", 0])
    m.initial("block", y=-0.001)
    result = m.simulate(0.3, t_eval=[0.05, 0.1, 0.3], rtol=1e-10)
    pull = (8.0 - 0.25 * 2 * 9.81) / 2
    np.testing.assert_allclose(result["block.ax"], [0.0, pull, pull], atol=1e-9)
    assert result["block.x"][2] == pytest.approx(0.5 * pull * 0.2**2, rel=1e-9)
    assert next(event.t for event in result.events if event.kind == "slip") == pytest.approx(0.1, abs=1e-12)


@pytest.mark.parametrize("step", [1e-4, 1.1e-4, 3e-5])
def test_moreau_goes_on_quietly_after_a_jolt_that_drives_a_pin_against_its_bush(step):
    """A spoke that turns back at 0.1 s throws its pendulum; what the jolt left in the contact memory moved the pin."""
    m = rt.Mechanism("spoke")
    m.ground(O=[0, 0])
    m.body("spoke", mass=1.0, inertia=0.02, points={"P": [0, 0], "Q": [0.1, 0]})
    m.body("swing", mass=0.5, inertia=0.01, points={"Q": [-0.1, 0]})
    m.revolute("O", "ground.O", "spoke.P")
    contact = {"model": "impact", "restitution": 0.5, "friction": 0.1, "bush_radius": 0.01}
    m.revolute("Q", "spoke.Q", "swing.Q", clearance=0.001, contact=contact)
    m.driver("motor", "O", angle="2*max(t - 0.1, 0) + 3*max(0.1 - t, 0)")
    result = m.simulate(0.101, method="moreau", step=step, t_eval=[0.1, 0.101])
    assert result.success
    arm = 0.1 * np.array([np.cos(result["swing.angle"]), np.sin(result["swing.angle"])])
    pin = np.array([result["swing.x"], result["swing.y"]]) - arm
    bush = 0.1 * np.array([np.cos(result["spoke.angle"]), np.sin(result["spoke.angle"])])
    offset = np.hypot(*(pin - bush))
    # in 1 ms after a jump of 5 rad/s at 0.1 m a pin moves less than 0.5 mm and stays in its bush of 1 mm
    assert np.all(offset < 1.001e-3)
    assert np.hypot(*np.diff(pin, axis=1)[:, 0]) < 0.5e-3
