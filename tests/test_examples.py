"""Every shipped example runs, and says a number that is known for a reason of its own."""

import math
import re
import shlex

import click
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import rattle as rt
from rattle.cli.main import main
from rattle.results.result import Result

G = 9.81
NAMES = {
    "chain", "double_pendulum", "five_bar", "fourbar", "quick_return", "slider_crank", "squeezer", "toggle", "windows",
    "slider_crank_play", "door_hinge",
}  # fmt: skip


ALL = sorted(rt.examples())


@pytest.fixture(scope="module")
def runs() -> dict[str, Result]:
    return {name: rt.example(name).simulate() for name in sorted(NAMES)}


# ---------------------------------------------------------------- all of them
@pytest.mark.nojit
def test_these_examples_are_shipped():
    assert set(ALL) >= NAMES | {
        "balanced_arm", "bouncing_pin", "crank_rocker_play", "ellipse", "fourbar_onesided", "guide_play",
        "path_generator", "scotch_yoke", "three_plays", "toggle_clamp", "woodpecker", "dc_motor_pid", "excavator",
        "torque_converter", "torque_converter_epicyclic", "planetary", "rolling_cart", "jansen_leg", "double_wishbone",
        "geneva", "scissor_lift", "door_closer", "ratchet", "piston_engine", "stick_slip",
        "drawer", "cam_lift_off", "gear_rattle", "belt_drive", "slider_crank_oil", "journal_falls", "stribeck",
        "rotor_whirl", "fourbar_oil", "slider_crank_worn", "dominoes", "marble_run", "rimless_wheel", "step_ladder",
        "connecting_rod", "press", "bucket_pins", "gripper", "wiper",
    }  # fmt: skip


@pytest.mark.nojit
@pytest.mark.parametrize("name", ALL)
def test_an_example_assembles(name):
    start = rt.example(name).start
    assert start.residual < 1e-12
    with pytest.raises(ValueError, match="did you mean"):
        rt.example(name + "x")


@pytest.mark.nojit
@pytest.mark.parametrize("name", ALL)
def test_the_comment_on_top_gives_commands_and_names_that_exist(name):
    text = rt.examples()[name].read_text(encoding="utf-8")
    head = text[: text.index("format = 1")]
    assert all(line.startswith("#") or not line for line in head.splitlines())
    assert all(word in head for word in ("Look at", "Try", "Source"))
    assert f"rattle example {name} {'-o' if 'file = ' in text else '>'} {name}.toml" in head
    mechanism = rt.example(name)
    for line in re.findall(r"rattle run .*", head):
        words = shlex.split(re.split(r"\s{2,}", line)[0])
        given = [words[n + 1].split("=", 1) for n, word in enumerate(words) if word == "--set"]
        flags = {"true": True, "false": False}
        mechanism.set({key: flags.get(one, one) for key, one in given})  # raises where the name or value is wrong
    for line in re.findall(r"rattle \w.*", head):
        program, *words = shlex.split(re.split(r"\s{2,}", line)[0])[1:]
        command = main.get_command(click.Context(main), program)
        assert command is not None, line
        options = {one for parameter in command.params for one in (*parameter.opts, *parameter.secondary_opts)}
        assert {word for word in words if word.startswith("-")} <= options, line
    plots = [re.split(r"\s{2,}", line)[0].split()[3:] for line in re.findall(r"rattle plot .*", head)]
    asked = {word for words in plots for word in words} - {"--orbit", "--xy", "--over"} - {*mechanism.model.joints}
    known = {*mechanism.simulate(1e-4).names}
    unknown = {word for word in asked if not {word, f"{word}.x"} & known}
    if unknown and "--path" in head:  # a quasi-static motion has names of its own
        unknown -= {*mechanism.equilibrium(np.linspace(0.0, 1e-3, 3)).names}
    assert not unknown


@pytest.mark.parametrize("name", sorted(NAMES))
def test_an_example_runs_to_its_end(runs, name):
    r = runs[name]
    assert r.success, r.message
    assert r.t[-1] == pytest.approx(rt.example(name).model.settings.t_end)
    assert r.trust.drift < 1e-12
    assert all(np.isfinite(r[one][~r.left_out]).all() for one in r.names)
    assert r.left_out.sum() < 0.02 * len(r.t)


# ---------------------------------------------------------------- four-bar
def test_fourbar_gives_the_reference_at_50_ms_and_says_that_its_pins_pull():
    r = rt.example("fourbar").simulate(0.05, t_eval=[0.0, 0.05], rtol=1e-11)
    # independent reference, two routes that agree to 1e-9
    assert r["coupler.angle"][-1] == pytest.approx(0.8548610709, abs=1e-8)
    assert r["rocker.angle"][-1] == pytest.approx(-1.1619901719, abs=1e-8)
    assert r["O3.normal"] == pytest.approx([275.306033837, 1001.535724], rel=1e-5)
    assert r["O4.normal"] == pytest.approx([-212.474678096, -438.613590], rel=1e-5)
    assert r.trust.first_pull["O4"] == 0.0


def test_fourbar_says_how_far_it_can_be_trusted():
    m = rt.example("fourbar")
    horizon = m.simulate(0.4, horizon=True).trust.horizon
    # chaos: an error grows ten-billion-fold between 0.05 and 0.4 s, from about 1e-10 per step
    assert 0.05 < horizon < 0.35
    assert m.ideal().simulate(0.4, horizon=True).trust.horizon == pytest.approx(0.4)


def test_ideal_fourbar_moves_as_its_triangle_of_diagonals_says():
    r = rt.example("fourbar").ideal().simulate(0.6)
    end = np.array([0.2 * np.cos(10 * r.t), 0.2 * np.sin(10 * r.t)])
    reach = np.array([[0.81], [0.0]]) - end
    d = np.hypot(*reach)
    coupler = np.arctan2(reach[1], reach[0]) + np.arccos(d / 1.2)  # both links 0.6 m: an isosceles triangle
    assert r["coupler.angle"] == pytest.approx(coupler, abs=1e-11)


# ---------------------------------------------------------------- slider-crank
def test_slider_crank_follows_its_closed_form(runs):
    r = runs["slider_crank"]
    a, rod, w = 0.05, 0.12, 5000 * math.pi / 30
    c, s = np.cos(w * r.t), np.sin(w * r.t)
    root = np.sqrt(rod**2 - (a * s) ** 2)
    assert r["slider.x"] == pytest.approx(a * c + root, abs=1e-12)
    assert r["slider.vx"] == pytest.approx(-a * w * s - a**2 * w * s * c / root, abs=1e-9)
    acceleration = -a * w**2 * c - a**2 * w**2 * ((c**2 - s**2) / root + a**2 * s**2 * c**2 / root**3)
    assert r["slider.ax"] == pytest.approx(acceleration, abs=1e-6)


def test_slider_crank_needs_the_torque_that_its_energy_says(runs):
    r = runs["slider_crank"]
    # independent reference +-138.521268 N m at 34.92 and 325.08 deg; between outputs of 0.6 deg a peak loses 1e-4
    assert r["motor.torque"].max() == pytest.approx(138.521268, rel=1e-4)
    assert r["motor.torque"].min() == pytest.approx(-138.521268, rel=1e-4)
    power = 0.14 * r["slider.vx"] * r["slider.ax"] + 2.5e-4 * r["rod.omega"] * r["rod.alpha"]
    power = power + 0.21 * (r["rod.vx"] * r["rod.ax"] + r["rod.vy"] * r["rod.ay"])
    assert r["motor.power"] == pytest.approx(power, abs=1e-7)


def test_slider_crank_with_little_play_stays_near_the_ideal_one(runs):
    play = rt.example("slider_crank").set({"joints.B.contact": "massless-link", "c": "0.01 mm"}).simulate()
    ideal = runs["slider_crank"]
    assert play.success
    assert np.hypot(play["B.ex"], play["B.ey"]) == pytest.approx(np.full(len(play.t), 1e-5), abs=1e-13)
    # a pin that is off by c moves the slider by c/cos(angle of the rod) at most
    assert np.abs(play["slider.x"] - ideal["slider.x"]).max() < 1e-5 / math.sqrt(1 - (0.05 / 0.12) ** 2) + 1e-9


# ---------------------------------------------------------------- pendulums
def open_chain(lengths, masses, angle, times):
    """Angles of uniform bars hung one from the other and let go at one angle: Lagrange's equations in the angles alone.

    sum_j a_ij [cos(p_i - p_j) p_j'' + sin(p_i - p_j) p_j'^2] + g b_i cos p_i = 0
    """
    lengths, masses = np.asarray(lengths, float), np.asarray(masses, float)
    n = len(lengths)
    beyond = masses.sum() - np.cumsum(masses)  # what hangs on each bar
    i, j = np.indices((n, n))
    outer = np.maximum(i, j)
    a = lengths[i] * lengths[j] * (np.where(i == j, 1 / 3, 1 / 2) * masses[outer] + beyond[outer])
    b = lengths * (masses / 2 + beyond)

    def rate(t, y):
        p, w = y[:n], y[n:]
        apart = p[:, None] - p[None, :]
        force = -(a * np.sin(apart)) @ w**2 - G * b * np.cos(p)
        return np.concatenate([w, np.linalg.solve(a * np.cos(apart), force)])

    start = np.concatenate([np.full(n, angle), np.zeros(n)])
    return solve_ivp(rate, (0, times[-1]), start, "DOP853", times, rtol=1e-12, atol=1e-12).y[:n]


def test_double_pendulum_follows_lagranges_equations():
    times = np.linspace(0, 3, 31)
    r = rt.example("double_pendulum").simulate(t_eval=times)
    want = open_chain([0.4, 0.3], [1.0, 0.5], math.radians(60), times)
    assert r["upper.angle"] == pytest.approx(want[0], abs=1e-7)  # errors of 1e-11 grow a thousandfold in 3 s
    assert r["lower.angle"] == pytest.approx(want[1], abs=1e-7)


def test_double_pendulum_keeps_its_energy_but_not_its_memory():
    m = rt.example("double_pendulum")
    r = m.simulate(horizon=True)
    assert r.trust.energy_balance < 1e-9
    assert 8 < r.trust.horizon < 15
    other = m.set(start="60.0001 deg").simulate()
    apart = np.abs(other["lower.angle"] - r["lower.angle"])
    assert apart[r.t < 1].max() < 1e-4 < 1.0 < apart[r.t > 15].max()


def test_chain_follows_lagranges_equations():
    times = np.linspace(0, 0.5, 26)
    r = rt.example("chain").simulate(t_eval=times, rtol=1e-10)
    want = open_chain(np.full(20, 0.05), np.full(20, 0.05), 0.0, times)
    got = np.array([r[f"b{k}.angle"] for k in range(1, 21)])
    assert np.abs(got - want).max() < 1e-6  # after the crack at 0.44 s, where b20 turns with 160 rad/s


def test_chain_keeps_its_energy_and_starts_with_the_closed_form_pull(runs):
    r = runs["chain"]
    height = sum(r[f"b{k}.y"] for k in range(1, 21))
    speed = sum(r[f"b{k}.vx"] ** 2 + r[f"b{k}.vy"] ** 2 + 0.05**2 / 12 * r[f"b{k}.omega"] ** 2 for k in range(1, 21))
    assert 0.05 * (speed / 2 + G * height) == pytest.approx(np.zeros(len(r.t)), abs=1e-8)
    # held out straight all links but the first few fall freely: the angles' equations at rest
    n, k = 20, np.arange(20)
    outer = np.maximum(*np.indices((n, n)))
    a = np.where(np.eye(n), 1 / 3, 1 / 2) + n - 1 - outer
    alpha = -np.linalg.solve(a, n - 1 - k + 0.5) * G / 0.05
    got = np.array([r[f"b{k}.alpha"][0] for k in range(1, 21)])
    assert got == pytest.approx(alpha, abs=1e-7)


# ---------------------------------------------------------------- squeezer
def test_squeezer_gives_the_published_angles_at_30_ms(runs):
    r = runs["squeezer"]
    angle = {k: r[f"k{k}.angle"][-1] for k in range(1, 8)}
    # Mazzia, Magherini, Test Set for IVP Solvers (2008), Andrews' squeezing mechanism
    assert angle[1] == pytest.approx(15.81077119629904, abs=1e-7)
    assert angle[2] - angle[1] == pytest.approx(-15.75637105984298, abs=1e-7)
    published = (0.04082224013073101, -0.5347301163226948, 0.5244099658805304, 0.5347301163226948, 1.048080741042263)
    got = (angle[3], angle[4] - angle[5], angle[5], angle[6] - angle[7], angle[7])
    assert got == pytest.approx(published, abs=1e-8)


# ---------------------------------------------------------------- windows
def windows(n: int) -> rt.Mechanism:
    """n windows of 1 m, 1 kg bars, upper points starting at 1 m/s."""
    m = rt.Mechanism(f"{n} windows", gravity=[0, -G])
    for k in range(n + 1):
        m.ground(**{f"G{k}": [k, 0]})
        m.bar(f"p{k}", "G", "P", length=1, mass=1).revolute(f"G{k}", f"ground.G{k}", f"p{k}.G")
        m.initial(f"p{k}", angle="90 deg", omega=-1)
    for k in range(1, n + 1):
        m.bar(f"c{k}", "L", "R", length=1, mass=1).initial(f"c{k}", angle=0, omega=0)
        m.revolute(f"L{k}", f"p{k - 1}.P", f"c{k}.L").revolute(f"R{k}", f"c{k}.R", f"p{k}.P")
    return m


def test_windows_gives_the_benchmark_value(runs):
    r = runs["windows"]
    # independent reference; Exudyn agrees to 1e-6
    assert r["p0.P.x"][-1] == pytest.approx(0.3284581115, abs=1e-6)
    assert r["p0.P.y"][-1] == pytest.approx(0.9445185382, abs=1e-6)
    assert r.trust.energy_balance < 1e-4


@pytest.mark.parametrize("n", [2, 5, 20])
def test_n_windows_swing_as_one_pendulum(n):
    times = np.linspace(0, 10, 101)
    r = windows(n).simulate(t_eval=times)
    assert r.success, r.message
    assert r.trust.energy_balance < 1e-4
    posts = np.array([r[f"p{k}.angle"] for k in range(n + 1)])
    assert np.ptp(posts, axis=0).max() < 1e-6  # no window folds over
    assert np.abs([r[f"c{k}.angle"] for k in range(1, n + 1)]).max() < 1e-6
    ratio = (9 * n + 3) / (8 * n + 2)  # m g l [(n+1)/2 + n] over m l^2 [(n+1)/3 + n]

    def rate(t, y):
        return [y[1], -G * ratio * np.cos(y[0])]

    one = solve_ivp(rate, (0, 10), [np.pi / 2, -1], "DOP853", times, rtol=1e-12, atol=1e-12)
    assert posts[0] == pytest.approx(one.y[0], abs=1e-5)


# ---------------------------------------------------------------- quick return
@pytest.mark.parametrize("r_over_d", [0.5, 0.4])
def test_quick_return_has_its_time_ratio_and_stroke(r_over_d):
    b = math.asin(r_over_d)
    turns = np.array([b, math.pi - b, 2 * math.pi + b]) / (2 * math.pi)  # where the crank stands square to the lever
    m = rt.example("quick_return").set(r=0.2 * r_over_d)
    r = m.simulate(t_eval=turns)
    assert r["ram.vx"] == pytest.approx(np.zeros(3), abs=1e-9)
    assert r["ram.x"][0] - r["ram.x"][1] == pytest.approx(2 * 0.45 * r_over_d, abs=1e-11)
    dense = m.simulate(t_eval=np.linspace(turns[0], turns[2], 402)[1:-1])
    forth = dense["ram.vx"] > 0
    assert np.array_equal(forth, dense.t > turns[1])  # all the way back, then all the way forth
    ratio = (turns[2] - turns[1]) / (turns[1] - turns[0])
    assert ratio == pytest.approx((math.pi + 2 * b) / (math.pi - 2 * b))


def test_quick_return_follows_its_closed_form_and_the_motor_pays_for_the_cut(runs):
    r = runs["quick_return"]
    a = -2 * np.pi * r.t
    lever = np.arctan2(0.2 + 0.1 * np.sin(a), 0.1 * np.cos(a))
    ram = 0.45 * np.cos(lever) + np.sqrt(0.2**2 - (0.42 - 0.45 * np.sin(lever)) ** 2)
    assert r["ram.x"] == pytest.approx(ram, abs=1e-11)
    # after whole turns all bodies are where they were: the motor's work is the tool's, cut times stroke and a soft edge
    paid = np.trapezoid(r["motor.power"], r.t)
    assert paid == pytest.approx(np.trapezoid(r["cutting"] * r["ram.vx"], r.t), rel=1e-6)
    assert paid == pytest.approx(2 * 800 * 0.45, rel=2e-3)


# ---------------------------------------------------------------- five-bar
def test_five_bar_holds_its_pen_where_two_circles_meet_and_draws_the_heart(runs):
    r = runs["five_bar"]
    left = np.array([r["left_arm.elbow.x"], r["left_arm.elbow.y"]])
    right = np.array([r["right_arm.elbow.x"], r["right_arm.elbow.y"]])
    half = (right - left) / 2
    d = np.hypot(*half)
    up = np.array([-half[1], half[0]]) / d
    pen = left + half + up * np.sqrt(0.3**2 - d**2)
    assert np.array([r["left_forearm.pen.x"], r["left_forearm.pen.y"]]) == pytest.approx(pen, abs=1e-12)
    s = np.pi * r.t
    heart_x = 0.064 * np.sin(s) ** 3
    heart_y = 0.36 + 0.004 * (13 * np.cos(s) - 5 * np.cos(2 * s) - 2 * np.cos(3 * s) - np.cos(4 * s))
    assert pen == pytest.approx(np.array([heart_x, heart_y]), abs=1e-12)


def test_five_bar_motors_mirror_each_other_and_give_back_what_they_take(runs):
    r = runs["five_bar"]
    assert r["left_motor.torque"] == pytest.approx(-r["right_motor.torque"][::-1], abs=1e-12)
    kinetic = sum(
        m * (r[f"{body}.vx"] ** 2 + r[f"{body}.vy"] ** 2 + l**2 / 12 * r[f"{body}.omega"] ** 2) / 2
        for part, m, l in (("arm", 0.2, 0.2), ("forearm", 0.15, 0.3))
        for body in (f"left_{part}", f"right_{part}")
    )
    rate = np.gradient(kinetic, r.t, edge_order=2)
    assert r["left_motor.power"] + r["right_motor.power"] == pytest.approx(rate, abs=1e-4 * np.abs(rate).max() + 1e-5)


# ---------------------------------------------------------------- toggle
def pull(angle):
    """Vertical pull of the toggle's spring on the knee [N], and stretch [m]."""
    down, across = 0.1 + 0.1 * math.sin(angle), 0.1 * math.cos(angle) - 0.1
    length = math.hypot(down, across)
    return 500 * (length - 0.03) * down / length, 500 * (length - 0.03) * across / length, length - 0.03


def grip(angle):
    return 5e6 * max(0.0, 0.2 * (math.cos(angle) - math.cos(math.radians(3))))


def test_toggle_comes_to_rest_where_virtual_work_says(runs):
    r = runs["toggle"]

    def work(angle):  # of all forces for a small turn of the arm: knee (-l sin, l cos), jaw (-2 l sin, 0)
        down, across, _ = pull(angle)
        return down * 0.1 * math.cos(angle) - across * 0.1 * math.sin(angle) - grip(angle) * 0.2 * math.sin(angle)

    rest = brentq(work, math.radians(2.3), math.radians(3), xtol=1e-14)
    assert r["arm.angle"][-1] == pytest.approx(rest, abs=1e-8)
    assert r["grip"][-1] == pytest.approx(grip(rest), rel=1e-6)
    # knee as a two-force corner; the spring is upright within a tenth of a degree
    assert r["grip"][-1] == pytest.approx(pull(rest)[0] / (2 * math.tan(rest)), rel=1e-3)
    assert r["grip"][-1] > 11 * pull(rest)[0]


def test_toggle_accounts_for_the_energy_of_its_spring(runs):
    r = runs["toggle"]
    stored = [500 * pull(angle)[2] ** 2 / 2 for angle in (math.radians(30), r["arm.angle"][-1])]
    squeezed = grip(r["arm.angle"][-1]) ** 2 / (2 * 5e6)
    assert r["energy.kinetic"][-1] < 1e-12
    assert r["energy.dissipated"][-1] == pytest.approx(stored[0] - stored[1] - squeezed, abs=1e-8)
    assert r["energy.work"][-1] == pytest.approx(-squeezed, abs=1e-8)


def test_toggle_snaps_through_under_too_strong_a_spring():
    def most(k):  # largest pull that a knee before the dead centre can bear
        angles = np.radians(np.linspace(0.01, 3, 1000))
        return max(2 * grip(a) * math.tan(a) for a in angles) * k

    assert pull(0.0)[0] < most(1) < 2 * pull(0.0)[0]
    r = rt.example("toggle").set(stiffness="1 kN/m").simulate()
    assert r["arm.angle"][-1] < 0
    assert r["grip"][-1] == 0.0


# ---------------------------------------------------------------- Scotch yoke
def test_scotch_yoke_knocks_once_it_has_flown_across_the_play_of_its_slot():
    """Free at 90 degrees with the speed r w; the pin is across when phi - sin phi = 2 c / r, at r w (1 - cos phi)."""
    m = rt.example("scotch_yoke").set({"joints.slot.contact.friction": 0.0})
    r = m.simulate(0.1, rtol=1e-10)
    play, w, radius = 5e-5, 100.0, 0.05
    phi = brentq(lambda p: p - math.sin(p) - 2 * play / radius, 1e-3, 1.0, xtol=1e-15)
    contacts = [one for one in r.events if one.kind == "contact"]
    assert contacts[0].t == 0.0
    assert contacts[0].duration == pytest.approx(math.pi / 2 / w, rel=1e-9)  # pressed until the force changes sign
    knocks = [one for one in r.events if one.kind == "impact" and one.normal_speed > 0.1]
    assert [w * one.t for one in knocks] == pytest.approx([(n + 0.5) * math.pi + phi for n in range(3)], abs=1e-9)
    assert [one.normal_speed for one in knocks] == pytest.approx([radius * w * (1 - math.cos(phi))] * 3, rel=1e-9)
    assert r["slot.normal"][r["slot.normal"] > 0.0].max() == pytest.approx(500.0, rel=1e-3)  # m r w^2
    assert np.hypot(r["slot.ex"], r["slot.ey"]).max() == pytest.approx(play, rel=1e-9)


# ---------------------------------------------------------------- DC motor
def test_dc_motor_accounts_for_what_its_supply_gave_and_holds_the_arm_with_the_current_of_the_balance():
    r = rt.example("dc_motor_pid").simulate()
    stored = 0.5 * 2e-3 * r["i"] ** 2
    np.testing.assert_allclose(r["spent"], r["heat"] + stored + r["energy.work"], atol=1e-8)
    assert np.abs(r["U"]).max() == 24.0  # the supply is at its limit for a while
    assert r["arm.angle"][-1] == pytest.approx(np.radians(60), abs=2e-6)
    assert r["i"][-1] == pytest.approx(0.5 * G * 0.15 * 0.5 / (50 * 0.05), rel=1e-4)


def test_without_its_integral_part_the_controller_leaves_the_error_that_ohms_law_says():
    """At rest Kp (target - angle) = R i with n k i = m g (l/2) cos(angle)."""
    r = rt.example("dc_motor_pid").set(Ki=0.0).simulate(3.0, t_eval=[3.0])
    at_rest = brentq(lambda a: 60 * (np.pi / 3 - a) - 2 * 0.5 * G * 0.15 * np.cos(a) / 2.5, 0.5, 1.1, xtol=1e-14)
    assert r["arm.angle"][-1] == pytest.approx(at_rest, abs=1e-8)


# ---------------------------------------------------------------- excavator
def test_excavator_holds_its_arm_with_the_force_that_the_moment_of_all_weights_says():
    r = rt.example("excavator").simulate(t_eval=[0.0, 12.0])
    assert np.degrees([r[f"{name}.angle"][-1] for name in ("boom", "stick", "bucket")]) == pytest.approx(
        [45, -100, -190], abs=1e-3
    )
    masses = {"boom": 700, "stick": 350, "bucket": 550, "rocker": 20, "link": 20}
    moment = sum(mass * G * r[f"{name}.x"][-1] for name, mass in masses.items())
    end = np.array([r["boom.L.x"][-1], r["boom.L.y"][-1]])
    along = (end - [0.6, -0.4]) / np.hypot(*(end - [0.6, -0.4]))
    lever = end[0] * along[1] - end[1] * along[0]
    assert r["F_lift"][-1] == pytest.approx(moment / lever, rel=1e-4)  # creeps by 1e-5 rad/s still


# ---------------------------------------------------------------- gears and racks
def test_planetary_gear_set_starts_as_its_reduced_inertia_says_and_turns_by_willis():
    r = rt.example("planetary").simulate()
    carrier, planet, a = 20 / (20 + 80), -1 / 3, 0.05
    reduced = 2e-5 + carrier**2 * (4e-4 + 3 * 0.2 * a**2) + 3 * planet**2 * 1e-5
    assert r["sun.alpha"][0] == pytest.approx(1 / reduced, rel=1e-10)
    for name, ratio in (("carrier", carrier), ("planet2", planet)):
        assert r[f"{name}.angle"] == pytest.approx(ratio * r["sun.angle"], abs=1e-9)
    assert {f"{side}{k}" for side in ("inner", "outer") for k in (1, 2, 3)} <= set(r.trust.nonunique)


def test_rolling_cart_gathers_speed_as_an_exponential_and_ends_where_drag_and_motor_balance():
    m = rt.example("rolling_cart")
    r = m.simulate()
    end = 0.1 * 4 * math.pi
    tau = (20 + 2 * 2 + 2 * 0.5 / 0.1**2) * 0.1 * end / 20
    assert r["cart.vx"] == pytest.approx(end * (1 - np.exp(-r.t / tau)), abs=1e-7)  # the usual tolerance of a run
    assert r["rear.angle"] == pytest.approx(-r["cart.x"] / 0.1, abs=1e-12)
    assert r["road2.force"] == pytest.approx(0.5 / 0.1**2 * r["cart.ax"], abs=1e-6)  # it only turns its wheel
    slow = m.set({"drag": 10}).simulate(20.0)["cart.vx"][-1]
    assert 10 * slow**2 == pytest.approx(20 / 0.1 * (1 - slow / end), rel=1e-6)
