"""Bodies whose contacts hold each other: an end of a bar in a groove, a box at a wall, a box on a round."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from surfaces import EXACT, G, body, events, impact, surface, world

HALF, MASS, INERTIA = 0.2, 1.5, 0.02


def bar_in_groove(angle, rate, contact, right="54 deg", left="-24 deg"):
    """A bar that turns about its end P, which is where two lines of a groove meet."""
    x, y = HALF * math.cos(angle), HALF * math.sin(angle)
    start = (x, y, angle, -y * rate, x * rate, rate)
    return world(
        body("bar", {"P": (-HALF, 0), "Q": (HALF, 0)}, MASS, INERTIA, start),
        surface("right", "ground.O", "bar.P", contact, right, ', corners = ["P", "Q"]'),
        surface("left", "ground.O", "bar.P", contact, left, ', corners = ["P", "Q"]'),
    )


@pytest.mark.parametrize("mu", [0.1, 0.3])
def test_a_bar_turns_about_its_end_in_a_groove_as_a_pendulum(mu):
    """Both lines hold the end: friction there is not determined, but moves nothing, and its slip is no event."""
    start = (math.radians(100.0), -1.0)
    arm = INERTIA + MASS * HALF**2
    swing = solve_ivp(
        lambda t, z: (z[1], -MASS * G * HALF * math.cos(z[0]) / arm), (0, 0.2), start, rtol=1e-11, atol=1e-13
    )
    r = bar_in_groove(*start, impact(0, mu)).simulate(0.2, t_eval=[0.0, 0.2], **EXACT)
    assert r.success, r.message
    assert r["bar.angle"][-1] == pytest.approx(swing.y[0, -1], abs=1e-9)
    assert r["bar.P.x"][-1] == pytest.approx(0.0, abs=1e-12)
    assert r.stats["steps"] < 200


@pytest.mark.parametrize("angle", [120.0, 80.0])
@pytest.mark.parametrize("e", [0.0, 0.5])
def test_the_end_of_a_bar_comes_to_rest_where_two_lines_meet(angle, e):
    """The line that does not press it is touched without a force: no event, however often it is looked at."""
    r = bar_in_groove(math.radians(angle), 2.0, impact(e, 0.1)).simulate(1.0)
    assert r.success, r.message
    assert r.stats["steps"] < 2000
    assert np.abs(r["energy.balance"]).max() < 1e-6
    x, y = r["bar.P.x"], r["bar.P.y"]
    for line, side in ((54.0, "right"), (-24.0, "left")):
        turned = math.radians(line)
        assert (y * math.cos(turned) - x * math.sin(turned)).min() > -1e-9, side
    ends = [r["bar.P.y"][-1], r["bar.Q.y"][-1]]
    assert min(ends) < 0.5 * HALF  # no end has come out of the groove, nor gone through it


@pytest.mark.parametrize("x", [0.5, 0.61, 0.7])
def test_a_box_that_slides_against_a_rough_wall_goes_on(x):
    """Its corner at floor and wall is held by both, so that friction of the wall is free within limits."""
    box = world(
        body("box", {"C": (0, -0.1), "B": (0.2, -0.1)}, 1.0, 0.01, (x, 0.1, 0, 2, 0, 0)),
        surface("floor", "ground.O", "box.C", impact(0, 0.3), more=', corners = ["C", "B"]'),
        surface("wall", "ground.W", "box.B", impact(0, 0.3), "90 deg"),
        points="O = [0, 0], W = [1, 0]",
    )
    r = box.simulate(0.4, t_eval=np.linspace(0, 0.4, 41))
    assert r.success, r.message
    hit = events(r, joint="wall")[0].t
    slows = 2.0 - math.sqrt(4.0 - 2 * 0.3 * G * (0.8 - x))
    assert hit == pytest.approx(slows / (0.3 * G), abs=1e-8)
    assert r["wall.gap"].min() > -1e-9
    assert np.diff(r["energy.dissipated"]).min() > -1e-8  # no restitution, so that no impact gives energy
    assert any("friction of contacts that hold each other at joint" in note for note in r.trust.notes)


def test_a_box_that_sticks_to_a_disc_leaves_it_where_its_edge_ends():
    """Its force jumps at the corner: rounding of the place does not decide whether there are modes."""
    x, y = 0.23126920927672348, 0.13408952026099263
    radius, mass = 0.3398987259654351, 1.2462484146381252
    contact = impact(0, 1.0)
    start = (
        "x = -0.06812872684989224, y = 1.1912260970534825, angle = -0.20146003676341795, omega = 0.40524286109676066"
    )
    polygon = f"[[{-x}, {-y}], [{x}, {-y}], [{x}, {y}], [{-x}, {y}]]"
    m = world(
        f"bodies.box = {{ polygon = {polygon}, mass = 3.056853907849647, points = {{ C = [0, 0] }} }}\n",
        f"initial.box = {{ {start} }}\n",
        body("disc", {"C": (0, 0)}, mass, mass * radius**2 / 2, (0, radius, 0, 0, 0, 0)),
        surface("under", "ground.O", "disc.C", contact, more=f", roller = {radius}"),
        surface("floor", "ground.O", "box.C", contact, more=", outline = true"),
        surface("on", "disc.C", "box.C", contact, None, f", radius = {radius}, outline = true"),
    )
    r = m.simulate(1.0, t_eval=np.linspace(0, 1.0, 5), method="event", rtol=1e-9, atol=1e-12)
    assert r.success, r.message
    assert events(r, "release", "on")[-1].t == pytest.approx(0.69025882, abs=1e-6)


@pytest.mark.parametrize(("mu", "at"), [(0.1, 0.03), (0.2, 0.03), (0.1, 0.05)])
def test_a_box_that_a_ram_pushes_rocks_back_to_it_and_slides_on(mu, at):
    """Its slip along the ram turns where its lower edge comes down, at one instant, and grows out of rounding."""
    half, high, speed = 0.07, 0.08, 0.4
    corners = {"A": (-half, -high), "B": (half, -high), "W": (-half, 0)}
    m = world(
        body("box", corners, 2.0, 2.0 * (half**2 + high**2) / 3, (half + 0.02, high, 0, 0, 0, 0)),
        body("ram", {"C": (0, 0)}, 1.0, 0.1, (-0.02, at, 0, 0, 0, 0)),
        'joints.rail = { type = "prismatic", connect = ["ground.Y", "ram.C"], axis = 0 }\n',
        f'drivers.motor = {{ joint = "rail", position = "{speed}*t" }}\n',
        surface("floor", "ground.O", "box.A", impact(0, mu), more=', corners = ["A", "B"]'),
        surface("push", "box.W", "ram.C", impact(0, mu), "90 deg", f", length = {2 * high}, roller = 0.02"),
        points=f"O = [0, 0], Y = [-0.02, {at}]",
    )
    r = m.simulate(0.6)
    assert r.success, r.message
    assert (r["box.vx"][-1], r["box.angle"][-1], r["box.y"][-1]) == pytest.approx((speed, 0.0, high), abs=1e-8)
    assert r["push.normal"][-1] == pytest.approx(mu * r["floor.normal"][-1], rel=1e-6)
    assert np.abs(r["energy.balance"]).max() < 1e-6
