"""Blocks, rods and ladders on surfaces: they slide, stand, tip, rock and fall as textbooks say."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rattle as rt
from rattle.errors import AssemblyError
from surfaces import EXACT, G, block, body, columns, events, impact, on_slope, surface, way, world


def slid(mu, v0, slope, t):
    """The way down a slope of a block with the speed v0 down it, by Coulomb's law."""
    up, down = (G * (math.sin(slope) + sense * mu * math.cos(slope)) for sense in (1.0, -1.0))
    if v0 >= 0.0:
        return v0 * t + 0.5 * max(down, 0.0) * t * t
    ends = -v0 / up
    if t <= ends:
        return v0 * t + 0.5 * up * t * t
    return -v0 * v0 / (2 * up) + 0.5 * max(down, 0.0) * (t - ends) ** 2


@pytest.mark.parametrize(("mu", "v0"), [(0.3, 0.0), (0.3, -2.0), (0.7, -2.0)])
def test_a_block_slides_on_a_slope_by_coulombs_law_and_its_corners_share_its_weight(mu, v0):
    slope, high, mass = math.radians(30.0), 0.05, 3.0
    r = block(0.3, high, impact(0, mu), slope, on_slope(slope, high, v0)).simulate(
        0.8, t_eval=[0, 0.2, 0.5, 0.8], **EXACT
    )
    assert way(r, "block", slope) == pytest.approx([slid(mu, v0, slope, t) for t in r.t], abs=1e-9)
    assert r["floor.normal"] == pytest.approx(mass * G * math.cos(slope), rel=1e-8)
    left, right = r["floor.P.normal"], r["floor.Q.normal"]
    assert left + right == pytest.approx(r["floor.normal"], rel=1e-12)
    # moments about the mass centre: the front corner bears more by T h/b
    assert 0.3 * (right - left) == pytest.approx(-high * r["floor.tangential"], abs=1e-7)
    assert r["floor.T.normal"] == pytest.approx(0.0, abs=1e-12)
    stops = [event.t for event in events(r, "stick", "floor") if event.t > 0.0]
    if mu > math.tan(slope):
        assert stops[0] == pytest.approx(-v0 / (G * (math.sin(slope) + mu * math.cos(slope))), abs=1e-9)
    else:
        assert way(r, "block", slope)[-1] > way(r, "block", slope)[-2]


def test_a_block_stays_on_slopes_up_to_its_angle_of_friction():
    mu = 0.4
    for beyond in (-1e-4, 1e-4):
        slope = math.atan(mu) + beyond
        r = block(0.3, 0.05, impact(0, mu), slope).simulate(1.0, t_eval=[0.0, 1.0], **EXACT)
        pull = max(math.sin(slope) - mu * math.cos(slope), 0.0)
        assert way(r, "block", slope)[1] == pytest.approx(0.5 * G * pull, abs=1e-10)


def turned_over(half, high, tilt, times):
    """Angle past the balance of a block that tips about one corner: a'' = p^2 sin a."""
    length = math.hypot(half, high)
    p2 = G * length / (length**2 * 4 / 3)

    def swing(t, a):
        return [a[1], p2 * math.sin(a[0])]

    return solve_ivp(swing, (0, times[-1]), [tilt, 0.0], t_eval=times, rtol=1e-11, atol=1e-13).y


def test_a_tall_block_tips_from_the_slope_of_its_diagonal_on():
    half, high, times = 0.1, 0.2, [0.0, 0.3, 0.6]
    lean = math.atan(half / high)
    stands = block(half, high, impact(0, 2.0), lean - 1e-3).simulate(2.0, t_eval=[0.0, 2.0], **EXACT)
    assert np.ptp(stands["block.angle"]) < 1e-10
    tips = block(half, high, impact(0, 2.0), lean + 0.02).simulate(0.6, t_eval=times, **EXACT)
    a = turned_over(half, high, 0.02, times)[0]
    assert tips["block.angle"] - tips["block.angle"][0] == pytest.approx(-(a - 0.02), abs=1e-8)
    assert tips["floor.P.normal"] == pytest.approx(0.0, abs=1e-9)


# ---------------------------------------------------------------- rocking
HALF, HIGH = 0.1, 0.4
ALPHA = math.atan(HALF / HIGH)


def rocker(e=0.0, law="newton"):
    """A block tilted by half of what it can be, on its right corner."""
    tilt, length = -0.5 * ALPHA, math.hypot(HALF, HIGH)
    lean = ALPHA + tilt  # of the diagonal from the vertical
    start = (HALF - length * math.sin(lean), length * math.cos(lean), tilt, 0.0, 0.0, 0.0)
    return block(HALF, HIGH, impact(e, 1.0, f', restitution_law = "{law}"'), start=start, mass=10.0)


def quarter(tilt):
    """Time of a fall back to upright: integral of the pendulum turned over."""
    p2 = 0.75 * G / math.hypot(HALF, HIGH)

    def upright(t, a):
        return a[0]

    upright.terminal = True
    fall = solve_ivp(
        lambda t, a: [a[1], -p2 * math.sin(ALPHA - a[0])], (0, 5), [tilt, 0.0], events=upright, rtol=1e-12, atol=1e-14
    )
    return fall.t_events[0][0], fall.y_events[0][0][1]


def test_a_rocking_block_loses_what_housner_says_and_takes_the_time_of_its_pendulum():
    r = rocker().simulate(1.2, **EXACT)
    first, second = events(r)[:2]
    time, rate = quarter(0.5 * ALPHA)
    assert first.t == pytest.approx(time, abs=1e-9)
    energy = 10.0 * G * (math.hypot(HALF, HIGH) * math.cos(0.5 * ALPHA) - HIGH)
    kept = (1.0 - 1.5 * math.sin(ALPHA) ** 2) ** 2
    for k, event in enumerate((first, second)):
        assert 1.0 - event.energy_lost / (energy * kept**k) == pytest.approx(kept, rel=1e-8)
    assert 0.5 * (40.0 / 3.0) * (HALF**2 + HIGH**2) * rate**2 == pytest.approx(energy, rel=1e-9)
    # what is left lifts it to the angle of its energy, and down again in twice that time
    top = ALPHA - math.acos((HIGH + kept * energy / (10.0 * G)) / math.hypot(HALF, HIGH))
    assert second.t - first.t == pytest.approx(2.0 * quarter(top)[0], abs=1e-8)
    assert [event.contact for event in (first, second)] == ["P", "Q"]
    assert np.abs(r["energy.balance"]).max() < 1e-8


@pytest.mark.parametrize("law", ["newton", "poisson", "energetic"])
def test_a_rocking_block_comes_to_rest_with_all_of_its_energy_lost(law):
    r = rocker(0.0, law).simulate(12.0, t_eval=[0.0, 12.0])
    assert r["block.angle"][-1] == pytest.approx(0.0, abs=1e-9)
    assert columns(r, "floor.P.normal", "floor.Q.normal")[-1] == pytest.approx([5 * G, 5 * G], rel=1e-6)
    drop = r["block.y"][0] - r["block.y"][-1]
    assert r["energy.dissipated"][-1] == pytest.approx(10.0 * G * drop, rel=1e-7)


def test_events_keep_the_corner_in_saved_results(tmp_path):
    r = rocker().simulate(0.9, t_eval=[0.0, 0.9])
    r.save(tmp_path / "rocks.npz")
    again = rt.load_result(tmp_path / "rocks.npz")
    corners = [(event.kind, event.joint, event.contact) for event in r.events]
    assert ("impact", "floor", "P") in corners
    assert [(event.kind, event.joint, event.contact) for event in again.events] == corners


# ---------------------------------------------------------------- rods
@pytest.mark.parametrize(
    ("angle", "w", "mu", "slip"),
    [(1.0, 0.0, 0.5, 1), (1.0, 0.0, 0.5, -1), (1.1, 1.5, 1.0, -1), (0.6, -2.0, 0.8, 1), (math.atan(2), 0.0, 1.3, -1)],
)
def test_a_rod_that_slides_on_one_end_presses_as_painleve_says(angle, w, mu, slip):
    """N = m (g - l w^2 sin)/(1 + 3 cos (cos +- mu sin)); the last is near mu = 4/3, where no force is large enough."""
    s, c = math.sin(angle), math.cos(angle)
    start = (c, s, angle, -s * w + slip, c * w, w)
    rod = body("rod", {"A": (-1, 0)}, 1.0, 1 / 3, start)
    r = world(rod, surface("floor", "ground.O", "rod.A", impact(0, mu))).simulate(1e-6, t_eval=[0.0, 1e-6], **EXACT)
    wanted = (G - w * w * s) / (1 + 3 * c * (c + mu * slip * s))
    assert r["floor.normal"][0] == pytest.approx(wanted, rel=1e-7)
    assert r["floor.tangential"][0] == pytest.approx(-slip * mu * wanted, rel=1e-7)


def ladder(angle, mu):
    """A ladder of 2 m and 5 kg between floor and wall, so steep [rad]."""
    start = (math.cos(angle), math.sin(angle), -angle, 0.0, 0.0, 0.0)
    wall = surface("wall", "ground.O", "ladder.B", impact(0, mu), "-90 deg")
    floor = surface("floor", "ground.O", "ladder.A", impact(0, mu))
    return world(body("ladder", {"A": (1, 0), "B": (-1, 0)}, 5.0, 5 / 3, start), floor, wall)


def test_a_smooth_ladder_leaves_the_wall_at_two_thirds_of_its_height():
    """While it touches both, its centre goes on a circle of 1 m: a'' = -3/4 g cos a; it leaves at sin = 2/3 sin."""
    begin = math.radians(60.0)

    def leaves(t, a):
        return math.sin(a[0]) - 2 / 3 * math.sin(begin)

    leaves.terminal = True
    fall = solve_ivp(
        lambda t, a: [a[1], -0.75 * G * math.cos(a[0])], (0, 2), [begin, 0.0], events=leaves, rtol=1e-12, atol=1e-13
    )
    r = ladder(begin, 0.0).simulate(0.6, t_eval=[0.0, 0.2, 0.4, 0.6], **EXACT)
    assert events(r, "release", "wall")[0].t == pytest.approx(fall.t_events[0][0], abs=1e-9)
    alpha = 0.75 * G * math.cos(begin)
    pressed = [5 * (G - alpha * math.cos(begin)), 5 * alpha * math.sin(begin)]
    assert [r["floor.normal"][0], r["wall.normal"][0]] == pytest.approx(pressed, rel=1e-8)
    assert r["wall.gap"][:3] == pytest.approx(0.0, abs=1e-10)
    assert r["wall.gap"][3] > 1e-3
    v = r["ladder.vx"][3]  # nothing pushes it along the floor any more
    assert v == pytest.approx(-fall.y_events[0][0][1] * 2 / 3 * math.sin(begin), rel=1e-8)


def test_a_ladder_stands_from_the_angle_of_its_friction_on():
    mu = 0.3
    steep = math.atan((1 - mu * mu) / (2 * mu))
    for beyond in (1e-3, -1e-3):
        r = ladder(steep + beyond, mu).simulate(0.5, t_eval=[0.0, 0.5], **EXACT)
        assert (np.ptp(r["ladder.angle"]) > 1e-6) == (beyond < 0.0)


# ---------------------------------------------------------------- other ways to run it
def test_moreau_lets_a_block_slide_and_rock_as_events_do():
    slope = math.radians(30.0)
    slides = block(0.3, 0.05, impact(0, 0.7), slope, on_slope(slope, 0.05, -2.0))
    r = slides.simulate(0.8, t_eval=[0.0, 0.8], method="moreau", step=2e-4)
    assert way(r, "block", slope)[1] == pytest.approx(slid(0.7, -2.0, slope, 0.8), abs=1e-3)  # of first order
    r = rocker().simulate(0.6, t_eval=[0.0, 0.6], method="moreau", step=1e-4)
    assert r["block.angle"][1] == pytest.approx(rocker().simulate(0.6, t_eval=[0.0, 0.6])["block.angle"][1], abs=2e-3)


def test_a_start_inside_of_a_surface_is_refused_with_corner_and_depth():
    sunk = block(0.3, 0.05, impact(), start=(0.0, 0.03, 0.0, 0.0, 0.0, 0.0))
    with pytest.raises((AssemblyError, rt.ModelError), match=r"floor.*20 mm|floor.*0\.02"):
        sunk.simulate(0.1)


def test_a_floor_stays_where_joints_lose_their_play():
    hung = block(0.3, 0.05, impact(0, 0.4), more=LOOSE).ideal().model
    assert hung.joints["floor"].contact.rigid
    assert not hung.joints["pin"].is_loose


LOOSE = """
bodies.arm = { bar = ["A", "B"], length = 0.2, mass = 1 }
joints.pin = { type = "revolute", connect = ["block.T", "arm.A"], clearance = 1e-3, contact = "impact" }
"""


@pytest.mark.parametrize("mu", [0.0, 0.1, 0.5])
def test_boxes_that_are_flush_with_each_other_rest_as_they_stand(mu):
    """Corners at ends of segments, on each other and beside each other: what touches there is no matter of rounding."""
    w, h, contact = 0.06, 0.04, impact(0, mu)
    polygon = f"polygon = [[0, 0], [{w}, 0], [{w}, {h}], [0, {h}]]"
    points = f"points = {{ L = [0, {h / 2}], U = [{w / 2}, {h}] }}"
    text = [surface("floor", "ground.O", "b0.L", contact, more=f", length = {5 * w}, outline = true")]
    for n in range(3):
        text.append(f"bodies.b{n} = {{ {polygon}, {points}, mass = 0.2 }}\n")
        text.append(f"initial.b{n} = {{ x = {w / 2}, y = {(n + 0.5) * h}, angle = 0 }}\n")
        if n:
            for name, at, axis, length in (("top", "U", "0 deg", w), ("side", "L", "90 deg", h)):
                more = f", length = {length}, outline = true"
                text.append(surface(f"{name}{n}", f"b{n - 1}.{at}", f"b{n}.L", contact, axis, more))
    r = world(*text).simulate(4.0, t_eval=[0.0, 0.5, 4.0])
    assert r.success, r.message
    assert np.abs(columns(r, "b2.x", "b2.y", "b2.angle") - [w / 2, 2.5 * h, 0.0]).max() < 1e-12
    assert r["floor.normal"] == pytest.approx(0.6 * G, rel=1e-9)
    assert r["top1.normal"] + columns(r, "side1.fy")[:, 0] == pytest.approx(0.4 * G, rel=1e-9)
    assert len(r.events) < 60
