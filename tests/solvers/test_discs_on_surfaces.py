"""Discs on lines, segments, discs and in hollows: they bounce, slip, roll, leave and fly off where they have to."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from surfaces import EXACT, G, body, columns, disc, events, impact, on_slope, surface, way, world

R = 0.1


# ---------------------------------------------------------------- on a line
def test_a_ball_bounces_by_its_restitution_and_rests_after_the_sum_of_its_bounces():
    """Impacts at t1 (1 + 2 sum e^k), with v1 e^k; at rest after t1 (1 + e)/(1 - e)."""
    e, drop, g = 0.6, 1.0, 10.0
    first, speed = math.sqrt(2 * drop / g), math.sqrt(2 * g * drop)
    start = (0.0, R + drop, 0.0, 0.0, 0.0, 0.0)
    ends = first * (1 + e) / (1 - e)
    r = disc(impact(e), start, gravity=g).simulate(3.0, t_eval=[0.0, ends - 0.1, ends + 0.1, 3.0], **EXACT)
    times = [first * (1 + 2 * sum(e**j for j in range(1, k + 1))) for k in range(8)]
    assert [event.t for event in events(r)[:8]] == pytest.approx(times, abs=1e-9)
    assert [event.normal_speed for event in events(r)[:8]] == pytest.approx([speed * e**k for k in range(8)], abs=1e-9)
    assert r["disc.y"][2:] == pytest.approx([R, R], abs=1e-10)
    assert r["disc.y"][1] > R + 1e-4
    assert r["floor.normal"] == pytest.approx([0.0, 0.0, 20.0, 20.0], abs=1e-9)
    assert r["floor.gap"] == pytest.approx(r["disc.y"] - R, abs=1e-12)
    assert r["energy.dissipated"][-1] == pytest.approx(2.0 * g * drop, rel=1e-9)


def test_a_ball_bounces_in_moreaus_steps_too():
    start = (0.0, R + 1.0, 0.0, 0.0, 0.0, 0.0)
    ball = disc(impact(0.6), start, gravity=10.0)
    times = [0.0, 0.5, 3.0]
    r = ball.simulate(3.0, t_eval=times, method="moreau", step=5e-4)
    assert r["disc.y"] == pytest.approx(ball.simulate(3.0, t_eval=times)["disc.y"], abs=5e-3)  # of first order


@pytest.mark.parametrize(("v0", "w0", "mu"), [(3.0, 0.0, 0.2), (3.0, 60.0, 0.2), (-1.0, -80.0, 0.15)])
def test_a_disc_slips_until_its_slip_is_used_up_and_rolls_from_then_on(v0, w0, mu):
    """Slip v0 + r w0 falls by 3 mu g."""
    slip = v0 + R * w0
    ends, sense = abs(slip) / (3 * mu * G), math.copysign(1.0, slip)
    r = disc(impact(0, mu), (0, R, 0, v0, 0, w0)).simulate(ends + 0.5, t_eval=[0.0, ends / 2, ends + 0.5], **EXACT)
    v, w = (lambda t: v0 - sense * mu * G * t), (lambda t: w0 - sense * 2 * mu * G / R * t)
    wanted = [(v(t), w(t)) for t in (0.0, ends / 2, ends)]
    assert columns(r, "disc.vx", "disc.omega") == pytest.approx(np.array(wanted), abs=1e-7)
    (stick,) = events(r, "stick")
    assert stick.t == pytest.approx(ends, abs=1e-9)
    assert r["floor.tangential"][1:] == pytest.approx([-sense * mu * 2 * G, 0.0], abs=1e-8)


@pytest.mark.parametrize("mu", [0.2, 0.1])
def test_a_disc_rolls_down_slopes_up_to_three_times_its_friction_and_slips_on_steeper_ones(mu):
    slope = math.radians(20.0)
    rolls = math.tan(slope) <= 3 * mu
    r = disc(impact(0, mu), on_slope(slope, R), slope=slope).simulate(1.0, t_eval=[0.0, 1.0], **EXACT)
    pull = 2 / 3 * G * math.sin(slope) if rolls else G * (math.sin(slope) - mu * math.cos(slope))
    turn = pull / 2 / R if rolls else mu * G * math.cos(slope) / R
    assert way(r, "disc", slope)[1] == pytest.approx(pull / 2, rel=1e-9)
    assert r["disc.angle"][1] - r["disc.angle"][0] == pytest.approx(-turn, rel=1e-8)


def test_a_compliant_floor_stops_a_disc_for_the_time_that_hertz_gives():
    """Duration 2.9432 d/v with d = (5 m v^2/(4 K))^(2/5), peak force K d^(3/2)."""
    k, m, v = 1e7, 0.5, 1.2
    hertz = f'{{ model = "hertz", stiffness = {k}, exponent = 1.5 }}'
    r = disc(hertz, (0, R + 0.01, 0, 0, -v, 0), mass=m, gravity=0.0).simulate(0.02, rtol=1e-10, atol=1e-14)
    depth = (1.25 * m * v * v / k) ** 0.4
    (touch,) = events(r, "contact")
    assert touch.t == pytest.approx(0.01 / v, rel=1e-8)
    assert touch.duration == pytest.approx(2.9432749 * depth / v, rel=1e-6)
    assert touch.peak_force == pytest.approx(k * depth**1.5, rel=1e-6)
    assert r["disc.vy"][-1] == pytest.approx(v, rel=1e-7)


# ---------------------------------------------------------------- resistance to rolling
ARM = 2e-3


def test_resistance_to_rolling_stops_a_disc_after_the_way_of_its_energy():
    """v' = -g (rho/r)/(1 + 1/2)."""
    v0 = 1.0
    pull = G * ARM / R / 1.5
    ends = v0 / pull
    contact = impact(0, 0.5, f", rolling = {ARM}")
    r = disc(contact, (0, R, 0, v0, 0, -v0 / R)).simulate(ends + 1.0, t_eval=[0.0, ends / 2, ends + 1.0], **EXACT)
    assert r["disc.vx"] == pytest.approx([v0, v0 / 2, 0.0], abs=1e-9)
    assert r["disc.x"][-1] == pytest.approx(v0 * ends / 2, rel=1e-9)
    assert r["floor.rolling"] == pytest.approx([ARM * 2 * G] * 2 + [0.0], abs=1e-9)
    assert r["energy.dissipated"][-1] == pytest.approx(0.75 * 2 * v0**2, rel=1e-9)
    soft = f'{{ model = "hertz", stiffness = 1e7, exponent = 1.5, rolling = {ARM}, friction = 0.5 }}'
    r = disc(soft, (0, R - (2 * G / 1e7) ** (2 / 3), 0, v0, 0, -v0 / R)).simulate(ends / 2, t_eval=[0.0, ends / 2])
    assert r["disc.vx"][1] == pytest.approx(v0 / 2, rel=5e-3)  # smooth laws creep


def test_a_disc_rests_on_slopes_up_to_its_arm_over_its_radius():
    for beyond in (-1e-4, 1e-4):
        slope = math.atan(ARM / R) + beyond
        held = disc(impact(0, 0.5, f", rolling = {ARM}"), on_slope(slope, R), slope=slope)
        r = held.simulate(2.0, t_eval=[0.0, 2.0], **EXACT)
        pull = G * max(math.sin(slope) - ARM / R * math.cos(slope), 0.0) / 1.5
        assert way(r, "disc", slope)[1] == pytest.approx(2.0 * pull, abs=1e-8)


# ---------------------------------------------------------------- in a cup, on a drum
CUP = 0.5
REACH = CUP - R


def cup(mu, angle):
    """A disc at rest in a hollow, so far from its bottom [rad]."""
    start = (REACH * math.sin(angle), -REACH * math.cos(angle), 0.0, 0.0, 0.0, 0.0)
    hollow = f", radius = {CUP}, hollow = true, roller = {R}"
    disc_in_cup = body("disc", {"C": (0, 0)}, 2.0, 0.01, start)
    return world(disc_in_cup, surface("cup", "ground.O", "disc.C", impact(0, mu), None, hollow))


@pytest.mark.parametrize(("mu", "more"), [(0.0, 1.0), (2.0, 1.5)])
def test_a_disc_in_a_cup_is_a_pendulum_half_as_long_again_where_it_rolls(mu, more):
    times = [0.0, 0.3, 0.7, 1.5]
    wanted = solve_ivp(
        lambda t, a: [a[1], -G / (more * REACH) * math.sin(a[0])],
        (0, 1.5), [1.0, 0.0], t_eval=times, rtol=1e-11, atol=1e-13,
    ).y  # fmt: skip
    r = cup(mu, 1.0).simulate(1.5, t_eval=times, **EXACT)
    angle = np.arctan2(r["disc.x"], -r["disc.y"])
    assert angle == pytest.approx(wanted[0], abs=1e-8)
    assert r["cup.normal"] == pytest.approx(2 * (G * np.cos(angle) + REACH * wanted[1] ** 2), rel=1e-7)
    turned = -(angle - 1.0) * REACH / R if mu else np.zeros(4)
    assert r["disc.angle"] == pytest.approx(turned, abs=1e-7)


DRUM, TOP = 0.4, 0.1  # radius [m], angle from the top at the start [rad]


def drum(mu):
    """A disc at rest near the top of a fixed disc."""
    start = ((DRUM + R) * math.sin(TOP), (DRUM + R) * math.cos(TOP), 0.0, 0.0, 0.0, 0.0)
    disc_on_drum = body("disc", {"C": (0, 0)}, 2.0, 0.01, start)
    more = f", radius = {DRUM}, roller = {R}"
    return world(disc_on_drum, surface("drum", "ground.O", "disc.C", impact(0, mu), None, more))


def down_a_drum(mu):
    """Angle from the top at which a disc leaves a drum: it rolls, then slips where friction no longer rolls it."""
    reach = DRUM + R

    def pressed(a):
        return G * math.cos(a[0]) - reach * a[1] ** 2  # N/m

    def rolls(t, a):
        return [a[1], 2 / 3 * G * math.sin(a[0]) / reach]

    def slips(t, a):
        return [a[1], (G * math.sin(a[0]) - mu * pressed(a)) / reach]

    def breaks(t, a):
        return mu * pressed(a) - G * math.sin(a[0]) / 3

    def leaves(t, a):
        return pressed(a)

    breaks.terminal = leaves.terminal = True
    numbers = {"rtol": 1e-12, "atol": 1e-14}
    first = solve_ivp(rolls if mu else slips, (0, 3), [TOP, 0.0], events=breaks if mu else leaves, **numbers)
    if not mu:
        return None, first.t_events[0][0], first.y_events[0][0][0]
    at = first.y_events[0][0]
    second = solve_ivp(slips, (first.t_events[0][0], 3), at, events=leaves, **numbers)
    return first.t_events[0][0], second.t_events[0][0], second.y_events[0][0][0]


@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_a_disc_leaves_a_drum_where_nothing_presses_it_any_more(mu):
    """Smooth: at cos = 2/3 of that of the start; rough: it rolls, slips, and then leaves."""
    slip, leave, angle = down_a_drum(mu)
    r = drum(mu).simulate(leave, t_eval=[0.0, leave], **EXACT)
    released = events(r, "release") or events(drum(mu).simulate(leave + 0.01, **EXACT), "release")
    assert released[0].t == pytest.approx(leave, abs=1e-8)
    assert r["disc.y"][1] / (DRUM + R) == pytest.approx(math.cos(angle), abs=1e-8)
    if mu:
        slips = [event.t for event in events(r, "slip") if event.t > 0.0]
        assert slips[0] == pytest.approx(slip, abs=1e-8)
    else:
        assert math.cos(angle) == pytest.approx(2 / 3 * math.cos(TOP), rel=1e-9)


# ---------------------------------------------------------------- the end of a table
def over_an_end(v):
    """A smooth disc that meets the end of a table with the speed v; how long it turns about it, and to which angle."""

    def leaves(t, a):
        return G * math.cos(a[0]) - R * a[1] ** 2

    leaves.terminal = True
    fall = solve_ivp(
        lambda t, a: [a[1], G / R * math.sin(a[0])], (0, 1), [0.0, v / R], events=leaves, rtol=1e-12, atol=1e-14
    )
    return fall.t_events[0][0], fall.y_events[0][0][0]


def table(v, x=-0.15, roller=f", roller = {R}", height=R):
    """A smooth disc, or a point, on a table that ends at the origin."""
    on_table = body("disc", {"C": (0, 0)}, 2.0, 0.01, (x, height, 0, v, 0, 0))
    return world(
        on_table, surface("table", "ground.T", "disc.C", impact(), more=f", length = 2{roller}"), points="T = [-1, 0]"
    )


def test_a_disc_turns_about_the_end_of_a_table_and_leaves_it_where_nothing_presses():
    """cos = 2/3 + v^2/(3 g r); a disc that is faster than sqrt(g r) flies off at once."""
    v = 0.5
    time, angle = over_an_end(v)
    assert math.cos(angle) == pytest.approx(2 / 3 + v * v / (3 * G * R), rel=1e-9)
    r = table(v).simulate(0.5, t_eval=[0.0, 0.3, 0.3 + time, 0.5], **EXACT)
    assert events(r, "release")[-1].t == pytest.approx(0.3 + time, abs=1e-8)
    assert columns(r, "disc.x", "disc.y")[2] == pytest.approx([R * math.sin(angle), R * math.cos(angle)], abs=1e-8)
    assert not events(r)  # nothing knocks where line and end meet
    fast = table(2.0).simulate(0.4, t_eval=[0.0, 0.2, 0.4], **EXACT)
    wanted = [(0.25, R - 0.5 * G * 0.125**2), (0.65, R - 0.5 * G * 0.325**2)]
    assert columns(fast, "disc.x", "disc.y")[1:] == pytest.approx(np.array(wanted), abs=1e-9)


def test_what_a_disc_would_need_behind_the_end_that_it_flies_off_is_no_force():
    """N is m g up to the end, where m g - m v^2/r would pull: no peak, and no value just before the end, has it."""
    r = table(2.0).simulate(0.4, **EXACT)
    weight = 2.0 * G
    assert r.peak("table.force")[0] == pytest.approx(weight, rel=1e-9)
    assert r.rms("table.force") == pytest.approx(weight * math.sqrt(0.075 / 0.4), rel=1e-6)
    around = r.with_breaks
    assert np.unique(around["table.normal"].round(6)) == pytest.approx(np.array([0.0, weight]))
    assert np.abs(around["disc.ay"]).max() == pytest.approx(G, rel=1e-9)


def test_a_point_slides_off_the_end_of_a_table_and_meets_nothing_beside_it():
    r = table(1.0, roller="", height=0.0).simulate(0.4, t_eval=[0.0, 0.1, 0.4], **EXACT)
    assert columns(r, "disc.x", "disc.y")[1:] == pytest.approx(
        np.array([(-0.05, 0), (0.25, -0.5 * G * 0.0625)]), abs=1e-9
    )
    r = table(0.0, x=0.01, roller="", height=1.0).simulate(1.0, t_eval=[0.0, 1.0], **EXACT)
    assert r["disc.y"][1] == pytest.approx(1.0 - 0.5 * G, abs=1e-9)
    assert not r.events


# ---------------------------------------------------------------- surfaces that move
def test_two_discs_exchange_what_newton_and_coulomb_say():
    """An oblique impact with friction: impulses along normal and tangent by the masses seen there."""
    e, mu, w1, w2, m1, m2, r1, r2, y = 0.5, 0.2, 30.0, -10.0, 2.0, 1.0, 0.2, 0.1, 0.15
    x = math.sqrt((r1 + r2) ** 2 - y * y)
    first = body("first", {"C": (0, 0)}, m1, 0.5 * m1 * r1**2, (-1 - x, 0, 0, 2, 0, w1))
    second = body("second", {"C": (0, 0)}, m2, 0.5 * m2 * r2**2, (0, y, 0, 0, 0, w2))
    touch = surface("touch", "first.C", "second.C", impact(e, mu), None, f", radius = {r1}, roller = {r2}")
    r = world(first, second, touch, gravity=0.0).simulate(0.8, t_eval=[0.0, 0.8], **EXACT)
    n = np.array([x, y]) / (r1 + r2)
    u = np.array([n[1], -n[0]])
    approach, slip = -2 * n[0], -2 * u[0] + r2 * w2 + r1 * w1
    normal = -(1 + e) * approach / (1 / m1 + 1 / m2)
    along = np.clip(-slip / (3 / m1 + 3 / m2), -mu * normal, mu * normal)
    p = normal * n + along * u
    wanted = [2 - p[0] / m1, -p[1] / m1, w1 + 2 * along / (m1 * r1), *p / m2, w2 + 2 * along / (m2 * r2)]
    assert events(r)[0].t == pytest.approx(0.5, abs=1e-9)
    rates = columns(r, "first.vx", "first.vy", "first.omega", "second.vx", "second.vy", "second.omega")[-1]
    assert rates == pytest.approx(wanted, abs=1e-8)


def test_a_turning_vane_pushes_a_point_outwards_and_feels_it():
    """x'' = w^2 x, N = 2 m w x'; the torque is N x."""
    w, m, x0 = 3.0, 0.5, 0.2
    arm = body("arm", {"O": (0, 0)}, 1.0, 1.0, (0, 0, 0, 0, 0, w))
    point = body("point", {"C": (0, 0)}, m, 1.0, (x0, 0, 0, 0, w * x0, 0))
    hinge = 'joints.O = { type = "revolute", connect = ["ground.O", "arm.O"] }\n'
    motor = f'drivers.m = {{ joint = "O", angle = "{w}*t" }}\n'
    vane = surface("vane", "arm.O", "point.C", impact())
    r = world(arm, point, hinge, motor, vane, gravity=0.0).simulate(0.5, t_eval=[0.0, 0.25, 0.5], **EXACT)
    x, v = x0 * np.cosh(w * r.t), w * x0 * np.sinh(w * r.t)
    assert np.hypot(r["point.x"], r["point.y"]) == pytest.approx(x, rel=1e-9)
    assert r["vane.normal"] == pytest.approx(2 * m * w * v, abs=1e-9)
    assert r["m.torque"] == pytest.approx(2 * m * w * v * x, abs=1e-9)


def test_a_belt_takes_a_box_along_by_friction_until_it_rides():
    """mu g until the speed of the belt; its drive feels mu m g for so long, and slip takes as much as the box gets."""
    mu, speed, m = 0.25, 1.5, 2.0
    belt = "bodies.belt = { points = { T = [0, 0] }, mass = 1, inertia = 1 }\n"
    rail = 'joints.rail = { type = "prismatic", connect = ["ground.O", "belt.T"], axis = "0 deg" }\n'
    drive = f'drivers.drive = {{ joint = "rail", position = "{speed}*t" }}\n'
    box = body("box", {"P": (-0.1, -0.05), "Q": (0.1, -0.05)}, m, 0.01, (0, 0.05, 0, 0, 0, 0))
    on = surface("on", "belt.T", "box.P", impact(0, mu), more=', corners = ["P", "Q"]')
    r = world(belt, box, rail, drive, on).simulate(1.0, t_eval=[0.0, 0.3, 1.0], **EXACT)
    rides = speed / (mu * G)
    assert r["box.vx"][1:] == pytest.approx([mu * G * 0.3, speed], abs=1e-9)
    assert r["box.x"][2] == pytest.approx(speed * (1.0 - rides / 2), abs=1e-9)
    assert r["drive.force"][1:] == pytest.approx([mu * m * G, 0.0], abs=1e-8)
    assert r["energy.dissipated"][2] == pytest.approx(0.5 * m * speed**2, rel=1e-9)
    assert r["energy.work"][2] == pytest.approx(m * speed**2, rel=1e-9)


def test_a_plank_rocks_on_a_drum_by_its_edge():
    """w^2 = m g (R - h)/(I + m h^2) for a half thickness h below R."""
    drum_radius, h, length, m, a = 0.3, 0.05, 1.0, 2.0, 1e-3
    w = math.sqrt(m * G * (drum_radius - h) / (m * (length**2 + 4 * h * h) / 12 + m * h * h))
    x = -drum_radius * math.sin(a) + drum_radius * a * math.cos(a) - h * math.sin(a)
    y = drum_radius * math.cos(a) + drum_radius * a * math.sin(a) + h * math.cos(a)
    corners = f"[[{-length / 2}, {-h}], [{length / 2}, {-h}], [{length / 2}, {h}], [{-length / 2}, {h}]]"
    plank = f"bodies.plank = {{ polygon = {corners}, mass = {m}, points = {{ A = [0, 0] }} }}\n"
    start = f"initial.plank = {{ x = {x!r}, y = {y!r}, angle = {a} }}\n"
    on = surface("drum", "ground.O", "plank.A", impact(0, 0.8), None, f", radius = {drum_radius}, outline = true")
    period = 2 * math.pi / w
    r = world(plank, start, on).simulate(period, t_eval=np.linspace(0, period, 9), **EXACT)
    assert r["plank.angle"] / a == pytest.approx(np.cos(w * r.t), abs=1e-4)


@pytest.mark.parametrize("seed", range(40))
def test_a_disc_goes_over_the_corner_of_two_segments(seed):
    """Both end there: where it turns about the corner two contacts are one, and their rates are rounding."""
    rng = np.random.default_rng(seed)
    e, mu, r = rng.choice([0.0, 0.3, 0.7]), rng.choice([0.0, 0.2, 0.6]), rng.uniform(0.03, 0.2)
    start = (rng.uniform(-0.3, 0.05), r + rng.uniform(0.001, 0.3), 0.0)
    rates = (rng.uniform(-0.2, 1.5), rng.uniform(-1, 0.5), rng.uniform(-15, 5))
    more = f", length = 1.0, roller = {r}"
    top = surface("top", "ground.T", "disc.C", impact(e, mu), "0 deg", more)
    side = surface("side", "ground.S", "disc.C", impact(e, mu), "-90 deg", more)
    text = body("disc", {"C": (0, 0)}, 2.0, r * r, (*start, *rates))
    run = world(text, top, side, points="T = [-0.5, 0], S = [0, -0.5]").simulate(1.0, rtol=1e-9)
    assert run.success, run.message
    x, y = run["disc.x"], run["disc.y"]
    assert np.hypot(np.maximum(x, 0.0), np.maximum(y, 0.0))[y > -1.0].min() > r - 1e-9
    assert np.abs(run["energy.balance"]).max() < 1e-8
