"""Shipped examples with gears, slots, cylinders, clutches, stops and tables: each against a number of its own."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

import rattle as rt

G = 9.81


# ---------------------------------------------------------------- Jansen's leg
def meet(p, rp, q, rq, side):
    """Points (2, n) where circles about p and q meet, to the left of the way from p to q for side 1."""
    d = q - p
    length = np.hypot(*d)
    along = (length**2 + rp**2 - rq**2) / (2 * length)
    u = d / length
    return p + along * u + side * np.sqrt(rp**2 - along**2) * np.array([-u[1], u[0]])


def test_jansen_leg_steps_as_its_circles_meet():
    r = rt.example("jansen_leg").simulate()
    crank = 0.15 * np.array([np.cos(np.pi * r.t), np.sin(np.pi * r.t)])
    pivot = np.array([[-0.38], [-0.078]])
    upper, lower = meet(crank, 0.5, pivot, 0.415, -1), meet(crank, 0.619, pivot, 0.393, 1)
    back = meet(pivot, 0.401, upper, 0.558, 1)
    knee = meet(back, 0.394, lower, 0.367, -1)
    foot = meet(lower, 0.49, knee, 0.657, 1)
    assert np.array([r["shank.foot.x"], r["shank.foot.y"]]) == pytest.approx(foot, abs=1e-12)
    low = foot[1] < foot[1].min() + 0.01
    assert low[:-1].mean() == pytest.approx(0.431, abs=1 / len(low))
    rise = sum(one.mass * r[f"{name}.vy"] for name, one in rt.example("jansen_leg").model.bodies.items()) * G
    gained = np.gradient(r["energy.kinetic"], r.t, edge_order=2)  # second order: a 300th of the largest power
    assert r["motor.power"] == pytest.approx(rise + gained, abs=0.1)


# ---------------------------------------------------------------- suspension
def test_double_wishbone_gives_the_published_positions_and_comes_to_rest_by_virtual_work():
    m = rt.example("double_wishbone")
    r = m.simulate(0.1, t_eval=[0.0, 0.05, 0.1], rtol=1e-11, atol=1e-13)
    # Nikravesh's program, model AA, to the digits on which it and an independent integration agree
    names = ("lower.y", "lower.angle", "hub.y", "hub.angle")
    assert [r[name][1] for name in names] == pytest.approx(
        [0.235489344, -0.102306104, 0.320264167, 0.046685089], abs=9e-9
    )
    assert [r[name][2] for name in names] == pytest.approx(
        [0.231824214, -0.117670473, 0.313405747, 0.039910680], abs=2e-9
    )
    assert r["hub.ay"][0] == pytest.approx(-50.39157397, abs=1e-7)
    rest = m.equilibrium()[0].result
    tyre, strut = rest["tyre"][0], rest["strut.force"][0]
    assert (tyre, strut) == pytest.approx((1499.066291, -2402.131026), rel=1e-8)

    def at(angle):  # heights of lower arm, hub and upper arm, and length of the strut, by circles alone
        q, o = np.array([[0.2], [0.26]]), np.array([[0.32], [0.4]])
        u = np.array([[math.cos(angle)], [math.sin(angle)]])
        a = q + 0.42 * u
        b = meet(a, math.hypot(0.03, 0.22), o, 0.26, -1)
        turned = math.atan2(*(b - a)[::-1, 0]) - math.atan2(0.22, -0.03)
        hub = a[1, 0] + 0.07 * math.sin(turned) + 0.10 * math.cos(turned)
        strut = math.hypot(*(q + 0.24 * u - [[0.38], [0.43]])[:, 0])
        return np.array([(q + 0.24 * u)[1, 0], hub, (o + b)[1, 0] / 2, strut])

    angle, h = rest["lower.angle"][0], 1e-6
    lower, hub, upper, length = (at(angle + h) - at(angle - h)) / (2 * h)
    work = [-2 * G * lower, (tyre - 30 * G) * hub, -1 * G * upper, -strut * length]
    assert at(angle)[1] == pytest.approx(rest["hub.y"][0], abs=1e-10)
    assert sum(work) == pytest.approx(0.0, abs=1e-6 * max(map(abs, work)))


# ---------------------------------------------------------------- Geneva drive
@pytest.mark.parametrize("how", [{}, {"method": "moreau"}])
def test_geneva_wheel_turns_by_a_quarter_per_turn_and_rests_in_between(how):
    """In a slot within the play of the pin of the closed form; from horn to horn of the arc on the disc at rest."""
    r = rt.example("geneva").simulate(**how)
    w, ratio, play = 4 * math.pi, math.sqrt(2.0), 1e-4
    crank = w * r.t
    turns, rest = np.divmod(crank + 1e-9, 2 * math.pi)
    a = np.minimum(rest, math.pi / 2) - math.pi / 4
    turned = turns * math.pi / 2 + np.arctan2(np.sin(a), ratio - np.cos(a)) + math.pi / 4
    off = abs(r["wheel.angle"][0] - r["wheel.angle"] - turned)
    disc, axes, rim = 0.03 + play, 0.05 * ratio, 0.05
    horn = math.acos((axes**2 + disc**2 - rim**2) / (2 * axes * disc))
    held = (rest > math.pi / 2 + horn) & (rest < 2 * math.pi - horn)
    assert off[held].max() <= 2 * play / (axes * math.sin(horn))
    assert off.max() <= 3 * play / (axes - 0.05)  # where the pin is nearest to the shaft of the wheel
    fastest = np.abs(r["wheel.omega"]).max()
    assert fastest == pytest.approx(w / (ratio - 1), rel=0.03)
    assert {one.joint for one in r.events if one.kind == "impact"} >= {"slot0", "slot1"}


# ---------------------------------------------------------------- scissor lift
def test_scissor_lift_needs_the_force_that_virtual_work_says_wherever_the_load_stands():
    m = rt.example("scissor_lift")
    forces = []
    for aside in (0.3, -0.2):
        slow = m.set(aside=aside).equilibrium(np.linspace(0.0, 10.0, 6))
        rise = slow["platform.y"] / 3.2
        length = 0.8 * np.sqrt(1 + 8 * rise**2)
        assert slow["cylinder.length"] == pytest.approx(length, abs=1e-12)
        assert slow["cylinder.force"] == pytest.approx((500 + 2 * 20) * G * length / (1.6 * rise), rel=1e-9)
        forces.append(slow["cylinder.force"])
    assert forces[0] == pytest.approx(forces[1], rel=1e-9)
    r = m.simulate()
    assert r["cylinder.power"].max() > 1000.0
    power = np.gradient(r["energy.kinetic"], r.t) + G * (
        500 * r["platform.vy"] + sum(20 * r[f"{bar}.vy"] for bar in ("a1", "b1", "a2", "b2"))
    )
    assert r["cylinder.power"][2:-2] == pytest.approx(power[2:-2], abs=2.0)


# ---------------------------------------------------------------- door
def stage(k, c, inertia, phi, omega):
    """Angle from the one at which the closer is unwound, and its rate, as functions of time: two exponentials."""
    root = np.sqrt(complex(c**2 - 4 * k * inertia))
    fast, slow = (-c - root) / (2 * inertia), (-c + root) / (2 * inertia)
    a, b = (slow * phi - omega) / (slow - fast), (omega - fast * phi) / (slow - fast)
    return (
        lambda t: (a * np.exp(fast * t) + b * np.exp(slow * t)).real,
        lambda t: (a * fast * np.exp(fast * t) + b * slow * np.exp(slow * t)).real,
    )


def test_door_meets_its_frame_when_and_as_fast_as_two_stages_of_exponentials_say():
    inertia, k, wound = 30 * 0.9**2 / 3, 20.0, math.radians(60)
    angle, rate = stage(k, 60.0, inertia, wound + math.pi / 2, 0.0)
    latch = brentq(lambda t: angle(t) - wound - math.radians(15), 0.1, 10.0, xtol=1e-14)
    angle2, rate2 = stage(k, 20.0, inertia, wound + math.radians(15), rate(latch))
    shut = brentq(lambda t: angle2(t) - wound, 1e-3, 1.0, xtol=1e-14)
    r = rt.example("door_closer").simulate(rtol=1e-10)
    impacts = [one for one in r.events if one.kind == "impact"]
    assert impacts[0].t == pytest.approx(latch + shut, abs=1e-8)
    assert impacts[0].normal_speed == pytest.approx(-rate2(shut), abs=1e-8)
    angle3, rate3 = stage(k, 20.0, inertia, wound, -0.3 * rate2(shut))
    again = brentq(lambda t: angle3(t) - wound, 1e-2, 1.0, xtol=1e-14)
    assert impacts[1].t - impacts[0].t == pytest.approx(again, abs=1e-8)
    assert impacts[1].normal_speed == pytest.approx(-rate3(again), abs=1e-8)
    assert r["door.omega"][-1] == 0.0
    assert r["hinge.stop"][-1] == pytest.approx(k * wound, rel=1e-9)


# ---------------------------------------------------------------- ratchet
@pytest.mark.parametrize(("swing", "teeth"), [(20, 2), (26, 3), (9, 0)])
def test_ratchet_lifts_its_load_by_whole_teeth_and_loses_the_energy_of_its_impacts(swing, teeth):
    half, lost, pitch = math.radians(swing), math.radians(5), math.pi / 12
    r = rt.example("ratchet").set(A=half).simulate()
    assert r["load.y"][[200, 400, 600]] - 0.12 == pytest.approx(0.04 * teeth * pitch * np.array([1, 2, 3]), abs=1e-9)
    if not teeth:
        return
    # picked up where the arm comes to a tooth, put down where it comes back to the last tooth of the other pawl
    up = math.acos(1 - lost / half)
    down = 2 * math.pi - math.acos(1 - (teeth * pitch + lost) / half)
    hits = [one for one in r.events if one.kind == "impact"]
    turn = 2 * math.pi
    assert [one.t for one in hits] == pytest.approx([n + at / turn for n in range(3) for at in (up, down)], abs=1e-8)
    speeds = [turn * half * abs(math.sin(at)) for at in (up, down)]
    assert [one.normal_speed for one in hits] == pytest.approx(3 * speeds, rel=1e-7)
    coarse = rt.example("ratchet").set(A=half).simulate(rtol=1e-6)  # no more impacts from errors of their instants
    assert sum(one.kind == "impact" for one in coarse.events) == 6
    inertia = 0.01 + 100 * 0.04**2
    assert r["energy.dissipated"][-1] == pytest.approx(3 * inertia * (speeds[0] ** 2 + speeds[1] ** 2) / 2, rel=1e-6)


# ---------------------------------------------------------------- engine
def test_engine_gains_the_area_of_its_indicator_diagram():
    """J(phi) w^2/2 + heights = start + integral of (p - p_0) dV - moment of the brake times angle, at every output."""
    r = rt.example("piston_engine").simulate(0.09, rtol=1e-11)
    table = np.loadtxt(rt.examples()["piston_engine"].parent / "indicator.csv", delimiter=",", skiprows=3)
    cycles = np.radians(table[:, 0] + [[-720], [0], [720]]).ravel(), np.tile(table[:, 1] * 1e5, 3)
    pressure = PchipInterpolator(*cycles)
    radius, rod, area = 0.045, 0.15, math.pi / 4 * 0.08**2

    def lever(phi):  # change of the way of the piston by the angle
        return radius * np.sin(phi) * (1 + radius * np.cos(phi) / np.sqrt(rod**2 - (radius * np.sin(phi)) ** 2))

    nodes, weights = np.polynomial.legendre.leggauss(8)
    fine = np.linspace(0.0, 4 * np.pi, 577)  # parts of a table's interval
    points = fine[:-1, None] + (nodes + 1) / 2 * np.diff(fine)[:, None]
    pieces = (pressure(points) * area * lever(points)) @ weights / 2 * np.diff(fine)
    assert pieces.sum() == pytest.approx(421, abs=0.5)  # what the comment in the file says
    assert pieces.sum() / (4 * np.pi) == pytest.approx(33.48, abs=0.01)  # the brake

    phi = r["crank.angle"] - np.pi / 2
    cuts = np.unique(np.append(phi, cycles[0][(cycles[0] > phi[0]) & (cycles[0] < phi[-1])]))  # outputs and points
    inside = cuts[:-1, None] + (nodes + 1) / 2 * np.diff(cuts)[:, None]
    gained = np.cumsum((((pressure(inside) - 1e5) * area * lever(inside)) @ weights / 2 - 33.48) * np.diff(cuts))
    gained = gained[np.searchsorted(cuts, phi[1:]) - 1]
    energy = sum(
        mass * (r[f"{name}.vx"] ** 2 + r[f"{name}.vy"] ** 2) / 2
        + inertia * r[f"{name}.omega"] ** 2 / 2
        + mass * G * r[f"{name}.y"]
        for name, mass, inertia in (("crank", 15, 0.3), ("rod", 0.5, 0.5 * rod**2 / 12), ("piston", 0.4, 0))
    )
    assert phi[-1] - phi[0] > 4 * np.pi
    assert energy[1:] - energy[0] == pytest.approx(gained, abs=1e-7)


# ---------------------------------------------------------------- friction
def test_block_on_a_belt_sticks_and_slips_in_the_times_of_its_closed_form():
    """It starts to slip D = (mu_s - mu) m g/k beyond the balance of kinetic friction, at the speed of the belt.

    x - x_0 = D cos(w t) + (v/w) sin(w t) has the speed v again where tan(w t/2) = -w D/v, at -D.
    """
    k, v, beyond = 10.0, 0.1, (0.2 - 0.15) * G / 10.0
    w = math.sqrt(k)
    stick, slip = 2 * beyond / v, 2 / w * (math.pi - math.atan(w * beyond / v))
    r = rt.example("stick_slip").simulate(rtol=1e-11, atol=1e-13)
    at = {kind: [one.t for one in r.events if one.kind == kind and one.t > 0.1] for kind in ("stick", "slip")}
    assert np.diff(at["slip"]) == pytest.approx([stick + slip] * 3, abs=1e-9)  # 2.3366 s
    assert [b - a for a, b in zip(at["slip"][:-1], at["stick"][1:], strict=True)] == pytest.approx([slip] * 3, abs=1e-9)
    sticking = r["dry.friction"][(r.t > at["stick"][1]) & (r.t < at["slip"][1])]
    assert sticking == pytest.approx(k * (r["block.x"] - 0.8)[(r.t > at["stick"][1]) & (r.t < at["slip"][1])], abs=1e-9)
    assert r["block.x"].max() == pytest.approx(0.8 + 0.15 * G / k + math.hypot(beyond, v / w), abs=1e-6)


@pytest.mark.parametrize(
    ("mu", "e", "moves"), [(0.5, 0.3, True), (0.66, 0.3, True), (0.68, 0.3, False), (0.68, 0.2, True)]
)
def test_drawer_moves_with_what_its_corners_leave_of_the_pull_or_jams(mu, e, moves):
    r = rt.example("drawer").set(mu=mu, e=e).simulate(1.0, t_eval=[0.0, 0.8, 1.0])
    tilt = brentq(lambda b: 0.2 * math.sin(b) + 0.015 * math.cos(b) - 0.016, 0.0, 0.1, xtol=1e-15)
    assert r["drawer.angle"][1:] == pytest.approx([tilt] * 2, abs=1e-12)
    # moments about the middle; both corners rub at the same distance from it, against each other
    arms = e * math.cos(tilt) - 0.22 * math.sin(tilt), 2 * (0.2 * math.cos(tilt) - 0.015 * math.sin(tilt))
    pressed = 20 * arms[0] / arms[1]
    left = 20 - 2 * mu * pressed
    assert (left > 0) == moves
    if moves:
        assert r["drawer.ax"][1:] == pytest.approx([left / 8] * 2, rel=1e-9)
        assert left / 8 == pytest.approx(20 / 8 * (1 - mu * e / 0.2), abs=0.015)  # without the tilt
    else:
        assert r["drawer.vx"][1:] == pytest.approx([0.0, 0.0], abs=1e-12)
        assert rt.example("drawer").set(mu=mu, P=200).simulate(0.5, t_eval=[0.0, 0.5])["drawer.vx"][1] == pytest.approx(
            0.0, abs=1e-12
        )


# ---------------------------------------------------------------- one-sided elements
def test_cam_follower_lifts_off_above_the_critical_speed_and_lands_where_its_free_flight_says():
    lift, mass, k, rest = 0.008, 0.3, 1e4, 0.01
    critical = math.sqrt((k * (rest + lift) + mass * G) / (2 * mass * lift))
    assert critical * 30 / math.pi == pytest.approx(1864, abs=0.5)  # turns a minute in the comment of the file
    m = rt.example("cam_lift_off")
    for factor, flies in ((0.999, False), (1.001, True)):
        run = m.set(speed=factor * critical).simulate(0.02, rtol=1e-10)
        assert any(one.kind == "release" for one in run.events) == flies
    w = 2000 * math.pi / 30
    r = m.simulate(rtol=1e-10)
    off = math.acos(-(k * (rest + lift / 2) + mass * G) / (2 * mass * w**2 * lift - k * lift / 2)) / 2
    sway, level = math.sqrt(k / mass), rest + mass * G / k
    high, rate = lift * math.sin(off) ** 2 + level, w * lift * math.sin(2 * off)

    def gap(t):
        y = high * math.cos(sway * t) + rate / sway * math.sin(sway * t) - level
        return y - lift * math.sin(off + w * t) ** 2

    flight = brentq(gap, 1e-3, (math.pi - off) / w, xtol=1e-14)
    leaves, lands = (next(one for one in r.events if one.kind == kind) for kind in ("release", "impact"))
    assert leaves.t == pytest.approx((off + 0.2) / w, abs=1e-9)
    assert lands.t == pytest.approx((off + 0.2) / w + flight, abs=1e-8)
    fall = sway * (rate / sway * math.cos(sway * flight) - high * math.sin(sway * flight))
    assert lands.normal_speed == pytest.approx(w * lift * math.sin(2 * (off + w * flight)) - fall, rel=1e-7)
    # the largest force is that of the rise, where the curvature of the cam jumps
    assert r.peak("face.normal")[0] == pytest.approx(k * rest + mass * G + 2 * mass * w**2 * lift, rel=1e-9)


@pytest.mark.parametrize("push", [0.01, 0.05])
def test_rattling_gear_settles_to_two_knocks_a_period_at_the_speed_of_the_symmetric_motion(push):
    """Of flight at one speed from flank to flank, and Newton's law at each, mirrored after half a period:

    A cos p = -K (2 A sin p + b), K = (1 - e)/(pi (1 + e)); relative speed 2 w (2 A sin p + b)/(pi (1 + e)).
    """
    amplitude, backlash, e, w = 1e-4, 3e-4, 0.5, 157.0
    share = (1 - e) / (math.pi * (1 + e))
    phase = brentq(
        lambda p: amplitude * math.cos(p) + share * (2 * amplitude * math.sin(p) + backlash),
        math.pi / 2,
        math.pi,
        xtol=1e-15,
    )
    speed = 2 * w * (2 * amplitude * math.sin(phase) + backlash) / (math.pi * (1 + e))
    r = rt.example("gear_rattle").set(push=push).simulate(2.0, rtol=1e-10)
    knocks = [one for one in r.events if one.kind == "impact"][-20:]
    assert [one.normal_speed for one in knocks] == pytest.approx([speed] * 20, rel=1e-7)
    phases = [(w * one.t - phase) % math.pi for one in knocks]
    assert np.minimum(phases, math.pi - np.array(phases)) == pytest.approx(np.zeros(20), abs=1e-6)
    assert np.diff([one.t for one in knocks]) == pytest.approx([math.pi / w] * 19, rel=1e-6)


def test_belt_drive_swings_on_its_strands_and_settles_to_tight_and_slack_side():
    """Two wheels on two springs that only pull, integrated step by step with SciPy in angles alone."""
    r1, r2, k, c, rest = 0.05, 0.1, 2e4, 10.0, 150.0

    def strands(y):
        stretch, rate = r1 * y[0] - r2 * y[1], r1 * y[2] - r2 * y[3]
        return [max(0.0, rest + k * s * stretch + c * s * rate) if rest / k + s * stretch > 0 else 0.0 for s in (1, -1)]

    def rates(t, y):
        ahead, behind = strands(y)
        pull = ahead - behind
        fan = 15 * y[3] * abs(y[3]) / 25**2
        return [y[2], y[3], (15 * (1 - y[2] / 100) - r1 * pull) / 0.004, (r2 * pull - fan) / 0.2]

    r = rt.example("belt_drive").simulate(2.5)
    early = r.t < 0.2
    slow = solve_ivp(rates, (0, 0.2), [0, 0, 0, 0], "RK45", r.t[early], rtol=1e-9, atol=1e-11, max_step=1e-3)
    tensions = np.sort([strands(y) for y in slow.y.T], axis=1).T
    assert r["belt.slack"][early] == pytest.approx(tensions[0], abs=1e-3)
    assert r["belt.tight"][early] == pytest.approx(tensions[1], abs=1e-3)
    assert r["belt.slack"][early].min() == 0.0
    # the motor's line meets the fan's parabola at 50 rad/s: 7.5 N m of the motor, 15 N m of the fan
    assert (r["motor.omega"][-1], r["wheel.omega"][-1]) == pytest.approx((50.0, 25.0), rel=1e-7)
    assert (r["belt.tight"][-1], r["belt.slack"][-1]) == pytest.approx((rest + 75.0, rest - 75.0), rel=1e-6)


# ---------------------------------------------------------------- oiled and dry pins
def test_oiled_pin_loses_what_petroff_says_and_a_little_more_beside_one_that_rattles():
    m = rt.example("fourbar_oil")
    w, viscosity, radius, length, c = 40.0, 0.1, 0.012, 0.02, 30e-6
    turn = 2 * math.pi / w
    r = m.simulate(2 * turn, t_eval=np.linspace(0.0, 2 * turn, 4001))
    last = r.t >= turn
    slip = r["crank.omega"] - r["coupler.omega"]
    petroff = 2 * math.pi * viscosity * radius**3 * length / c * slip**2
    couette = petroff / np.sqrt(1 - r["O2.eccentricity"] ** 2)
    assert petroff[last].mean() == pytest.approx(1.22, abs=0.01)
    # the film gives way at the speed of its pin, seen from between both bodies: F.v more
    crank, coupler = r["crank.angle"], r["coupler.angle"]
    ex, ey = r["O2.ex"], r["O2.ey"]
    vx = r["crank.vx"] - r["coupler.vx"] - 0.04 * w * np.sin(crank) - 0.13 * r["coupler.omega"] * np.sin(coupler)
    vy = r["crank.vy"] - r["coupler.vy"] + 0.04 * w * np.cos(crank) + 0.13 * r["coupler.omega"] * np.cos(coupler)
    mean = 0.5 * (r["crank.omega"] + r["coupler.omega"])
    pressed = -r["O2.film_fx"] * (vx + mean * ey) - r["O2.film_fy"] * (vy - mean * ex)
    assert r["O2.friction_power"] == pytest.approx(couette + pressed, abs=1e-6 * r["O2.friction_power"].max())
    assert 1.03 * petroff[last].mean() < r["O2.friction_power"][last].mean() < 1.06 * petroff[last].mean()
    assert r["O2.regime"].max() == 0.0
    impacts = [one for one in r.events if one.kind == "impact"]
    assert {one.joint for one in impacts} == {"O3"}
    lost = r.contacts["O3"].energy_lost
    oil = float(np.trapezoid(r["O2.friction_power"], r.t))
    assert lost + oil < r["energy.dissipated"][-1] < 1.02 * (lost + oil)  # impacts squeeze the film for microseconds
    assert r.trust.energy_balance < 1e-4 * r["energy.kinetic"].max()


# ---------------------------------------------------------------- on surfaces
def test_rimless_wheel_walks_at_the_rate_of_its_fixed_point():
    """w+ = eta w-, and the slope gives m g l (cos(a - b) - cos(a + b)) from one foot to the next."""
    m = rt.example("rimless_wheel")
    r = m.simulate("20 s")
    inertia, mass, arm, half, slope = m.model.bodies["wheel"].inertia, 2.0, 0.3, math.radians(22.5), math.radians(4)
    about_foot = inertia + mass * arm**2
    eta = (inertia + mass * arm**2 * math.cos(2 * half)) / about_foot
    gained = 4 * mass * G * arm * math.sin(half) * math.sin(slope) / about_foot
    steps = [event for event in r.events if event.kind == "impact"]
    after = math.sqrt(gained * eta**2 / (1 - eta**2))
    # a foot comes down with the speed w- times the distance from foot to foot
    speed = after / eta * 2 * arm * math.sin(half)
    assert steps[-1].normal_speed == pytest.approx(speed, rel=1e-6)
    feet = [event.contact for event in steps[:9]]
    assert feet == ["f1", "f2", "f3", "f4", "f5", "f6", "f7", "f0", "f1"]
    flat = m.set(slope="1 deg").simulate("12 s")  # too flat: it rests, on two feet
    assert abs(flat["wheel.omega"][-1]) < 1e-9
    bears = np.array([flat[f"road.f{k}.normal"][-1] for k in range(8)])
    assert (bears > 1.0).sum() == 2
    assert bears.sum() == pytest.approx(mass * G * math.cos(math.radians(1)), rel=1e-8)


def test_dominoes_fall_in_turn_if_the_push_lifts_the_first_over_its_corner():
    m = rt.example("dominoes")
    r = m.simulate()
    first = [next(e.t for e in r.events if e.joint == f"hit{k}{k + 1}" and e.kind == "impact") for k in range(1, 5)]
    assert (np.diff(first) > 0.0).all()
    assert (np.diff(first, 2) < 0.0).all()  # each sooner than the one before
    assert r["d5.angle"][-1] == pytest.approx(-math.pi / 2, abs=1e-9)
    leans = [r[f"d{k}.angle"][-1] for k in range(1, 5)]
    assert all(-math.pi / 2 < angle < -1.2 for angle in leans)
    height, width = 0.048, 0.008
    diagonal = math.hypot(height, width)
    needed = math.sqrt(3 * G * (diagonal - height) / diagonal**2)
    for share, falls in ((0.99, False), (1.01, True)):
        pushed = m.set(push=-share * needed).simulate(3.0, t_eval=[0.0, 3.0])
        assert (pushed["d5.angle"][-1] < -1.5) == falls
        assert (pushed["d1.angle"][-1] < -1.0) == falls


def test_step_ladder_slides_until_its_cord_is_taut_or_stands_by_friction():
    m = rt.example("step_ladder")
    r = m.simulate()
    (jerk,) = [event for event in r.events if event.kind == "impact" and event.joint == "cord"]
    before, after = r.t < jerk.t, r.t > jerk.t + 0.1
    assert (r["cord.force"][before] == 0.0).all()
    assert r["cord.position"][after] == pytest.approx(0.8, abs=1e-9)
    assert r["floor_left.normal"][-1] + r["floor_right.normal"][-1] == pytest.approx(700 + 12 * G, rel=1e-9)
    # moments about the hinge of the right leg: N l sin q - m g l/2 sin q - S (l - r) cos q - T l cos q = 0
    lean = math.asin(0.4 / 1.4)
    turned = 2 * (r["floor_right.normal"][-1] - 3 * G) * math.sin(lean)
    held = 1.4 * r["cord.force"][-1] - 2 * r["floor_right.tangential"][-1]
    assert held * math.cos(lean) == pytest.approx(turned, rel=1e-8)
    assert np.ptp(m.set(mu=0.3).simulate()["right.F.x"]) < 1e-9


def test_marble_rolls_by_two_thirds_of_the_slope_less_its_resistance_and_rests_at_last():
    r = rt.example("marble_run").simulate()
    slope, arm, radius = math.radians(8.0), 0.8e-3, 0.01
    on_rail = r.t < 1.0
    down = (r["marble.x"] - r["marble.x"][0])[on_rail] / math.cos(slope)
    pull = 2 / 3 * G * (math.sin(slope) - arm / radius * math.cos(slope))
    assert down == pytest.approx(0.5 * pull * r.t[on_rail] ** 2, abs=1e-9)
    assert [r["marble.vx"][-1], r["marble.omega"][-1]] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert r["marble.y"][-1] == pytest.approx(radius, abs=1e-10)
    lost = 0.03 * G * (r["marble.y"][0] - r["marble.y"][-1])
    assert r["energy.dissipated"][-1] == pytest.approx(lost, rel=1e-9)
