"""A point of a mechanism pulled by the mouse: joints stay closed, plays and stops hold, branches are kept."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize

import rattle as rt
from at_random import mechanism as pinned
from linkages import fourbar_text, parallelogram, slider_crank
from random_mechanisms import mechanism as stopped
from rattle.errors import AssemblyError, InputError
from rattle.sketch.descent import Hand
from rattle.sketch.movable import Movable
from rattle.sketch.pull import Pull

BARS = (0.1, 0.3, 0.25, 0.3)  # crank, coupler, rocker, ground of a crank-rocker [m]
START = "crank = { angle = 1 }\ncoupler = { angle = 0.4 }\nrocker = { angle = 1.6 }"


def fourbar(joints="", bars=BARS, start=START, **play):
    text = fourbar_text('joint = "A"\nangle = "1 + 2*t"', *bars, start, joints=joints)
    for name, more in play.items():
        text = text.replace(f"[joints.{name}]\n", f"[joints.{name}]\n{more}\n")
    return rt.loads(text)


def place(m, q, end):
    """A point of a body, in the ground frame, from nothing but q."""
    if end.body == "ground":
        return np.array(end.at)
    x, y, angle = q[3 * list(m.system.bodies).index(end.body) :][:3]
    c, s = math.cos(angle), math.sin(angle)
    return np.array([x + c * end.at[0] - s * end.at[1], y + s * end.at[0] + c * end.at[1]])


def angle(m, q, body):
    return 0.0 if body == "ground" else q[3 * list(m.system.bodies).index(body) + 2]


def open_by(m, q):
    """By how much the joints are open and beyond their stops [m or rad]: their geometry written once more."""
    worst = 0.0
    for joint in m.model.joints.values():
        offset = place(m, q, joint.b) - place(m, q, joint.a)
        turn = angle(m, q, joint.b.body) - angle(m, q, joint.a.body)
        far, line = float(np.hypot(*offset)), angle(m, q, joint.a.body) + joint.fields.get("axis", 0.0)
        across = abs(-math.sin(line) * offset[0] + math.cos(line) * offset[1])
        if joint.kind == "revolute":
            worst = max(worst, far - joint.clearance)
        elif joint.kind == "prismatic":
            worst = max(worst, across, abs(turn - joint.fields["angle"]))
        elif joint.kind == "slot":
            worst = max(worst, across)
        elif joint.kind == "rod":
            worst = max(worst, abs(far - joint.fields["length"]))
        if joint.stop is not None:
            worst = max(worst, joint.stop.minimum - turn, turn - joint.stop.maximum)
    return worst


@pytest.mark.parametrize("seed", range(24))
def test_joints_of_a_random_mechanism_stay_closed_wherever_it_is_pulled(seed):
    m, rng = pinned(seed), np.random.default_rng(seed)
    try:
        size = m.system.size
        pull = Pull(m, str(rng.choice(m.model.moving_bodies)), tuple(0.2 * rng.normal(size=2)))
    except AssemblyError:
        pytest.skip("cannot be put together")
    for step in (0.01, 0.05, 0.2, 1.0):
        pulled = pull.to(*(np.array(pull.place) + step * size * rng.normal(size=2)))
        assert open_by(m, pulled.q) < 1e-9 * max(1.0, size)
        assert pulled.reached or pulled.words


@pytest.mark.parametrize("seed", range(24))
def test_nothing_goes_through_a_stop(seed):
    m, rng = rt.loads(stopped(seed, "stops")), np.random.default_rng(seed)
    try:
        pull = Pull(m, str(rng.choice(m.model.moving_bodies)), tuple(0.2 * rng.normal(size=2)))
    except AssemblyError:
        pytest.skip("cannot be put together")
    for step in (0.01, 0.05, 0.2, 1.0, 1.0):
        pulled = pull.to(*(np.array(pull.place) + step * rng.normal(size=2)))
        assert open_by(m, pulled.q) < 1e-9


def test_a_crank_at_its_stop_says_so_and_turns_back():
    m = fourbar(A="stop = { min = 0.8, max = 1.2 }")
    pull = Pull(m, "crank", (0.05, 0.0))
    pulled = pull.to(-0.2, 0.2)
    assert pulled.q[2] == pytest.approx(1.2, abs=1e-9)
    assert not pulled.reached
    assert "'A' is at its stop (max)" in pulled.words
    back = pull.to(0.1 * math.cos(1.0), 0.1 * math.sin(1.0))
    assert back.reached
    assert back.q[2] == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize("bars", [BARS, (0.2, 0.3, 0.25, 0.4), (0.3, 0.15, 0.3, 0.2)])
@pytest.mark.parametrize("moves", [6, 40])
def test_there_and_back_along_the_way_of_the_coupler_is_the_same_position(bars, moves):
    m = fourbar(bars=bars)
    motor = m.kinematics(np.linspace(0.0, 0.35, moves))
    pull = Pull(m, "coupler", (0.0, 0.0))
    way = list(zip(motor["coupler.x"], motor["coupler.y"], motor["rocker.angle"], strict=True))
    for x, y, rocker in [*way, *reversed(way)]:
        pulled = pull.to(float(x), float(y))
        assert pulled.reached
        assert pulled.q[8] == pytest.approx(rocker, abs=1e-4)


def test_a_crank_rocker_stays_on_its_branch_wherever_its_coupler_is_pulled():
    m, rng = fourbar(), np.random.default_rng(3)
    pull = Pull(m, "coupler", (0.0, 0.05))
    for n in range(80):
        q = pull.to(*rng.normal(0.1, 0.05 if n % 4 else 0.5, 2)).q
        assert math.sin(q[8] - q[5]) > 0.1, "the other branch has the coupler on the other side of the rocker's pin"


@pytest.mark.parametrize("beyond", [0.001, 0.05, 1.0])
@pytest.mark.parametrize("moves", [1, 3, 30])
def test_a_rocker_pulled_beyond_its_dead_centre_stays_there_and_comes_back_on_its_side(beyond, moves):
    m = fourbar()
    pull = Pull(m, "rocker", (0.125, 0.0))
    a, b, c, d = BARS
    inner = math.acos(((b - a) ** 2 - c**2 - d**2) / (-2 * c * d))  # folded
    outer = math.pi - math.acos((c**2 + d**2 - (a + b) ** 2) / (2 * c * d))
    start = pull.q.copy()
    for limit, away in ((math.pi - inner, 1.0), (outer, -1.0)):
        pulled = None
        for angle_now in np.linspace(start[8], limit + away * beyond, moves + 1)[1:]:
            pulled = pull.to(d + c * math.cos(angle_now), c * math.sin(angle_now))
        assert pulled.q[8] == pytest.approx(limit, abs=1e-5)
        assert not pulled.reached
        assert "dead centre" in pulled.words
        for angle_now in np.linspace(limit + away * beyond, start[8], moves + 1)[1:]:
            pulled = pull.to(d + c * math.cos(angle_now), c * math.sin(angle_now))
        assert pulled.reached
        assert pulled.q[2] == pytest.approx(start[2], abs=1e-4), "the crank has come back on the side where it was"


def test_a_parallelogram_goes_through_its_change_points_as_one():
    pull = Pull(rt.loads(parallelogram()), "crank", (0.2, 0.0))
    for turn in np.linspace(1.0, 1.0 + 2.0 * math.tau, 200):
        pulled = pull.to(0.4 * math.cos(turn), 0.4 * math.sin(turn))
        assert pulled.reached
        assert abs(pulled.q[5]) < 1e-4, "the coupler stays level"
    assert pulled.q[2] == pytest.approx(1.0 + 2.0 * math.tau, abs=1e-4), "angles are continuous"


def test_a_coupler_moves_by_its_slack_before_anything_else_does():
    play = 'clearance = "0.2 mm"\ncontact = "impact"'
    m = fourbar(B=play, C=play)
    pull = Pull(m, "coupler", (0.0, 0.0))
    first, (x, y) = pull.q.copy(), pull.place
    within = pull.to(x + 0.15e-3, y)
    assert within.reached
    assert np.abs(within.q - first)[[0, 1, 2, 6, 7, 8]].max() < 1e-8, "crank and rocker rest"
    beyond = pull.to(x + 5e-3, y)
    assert np.abs(beyond.q - first)[2] > 1e-3, "the crank follows"
    assert open_by(m, beyond.q) < 1e-12
    joints = m.model.joints
    offset = [place(m, beyond.q, joints[name].b) - place(m, beyond.q, joints[name].a) for name in "BC"]
    assert max(np.hypot(*e) for e in offset) == pytest.approx(0.2e-3, rel=1e-6), "a pin presses on its bush"


LAWS = ('"massless-link"', '"impact"', '{ model = "hertz", stiffness = 1e9, exponent = 1.5 }')


@pytest.mark.parametrize("contact", LAWS)
def test_slack_is_the_same_whatever_the_contact_law(contact):
    """Rocker pin C in a bush of 2 mm play: with the motor held it moves 2 mm to either side of the middle."""
    m = fourbar(C=f'clearance = "2 mm"\ncontact = {contact}')
    pull = Pull(m, "coupler", (0.15, 0.0), motors=True)
    ends = []
    for sense in (1.0, -1.0):
        q = pull.to(place(m, m.start.q, m.model.joints["C"].a)[0], sense).q
        offset = place(m, q, m.model.joints["C"].b) - place(m, q, m.model.joints["C"].a)
        ends.append(q[5])
        assert np.hypot(*offset) == pytest.approx(2e-3, rel=1e-6)
    assert ends[0] - ends[1] > 5e-3


def objective(pull, first, hand):
    scale = pull.movable.scale

    def value(q):
        r = np.array(pull.descent.place(q)) - hand
        return 0.5 * float(r @ r) + 0.5e-3 * float(np.sum((scale * (q - first)) ** 2))

    return value


@pytest.mark.parametrize("hand", [(0.01, -0.02), (0.05, 0.05), (0.4, -0.1), (-0.3, 0.3)])
def test_one_descent_is_the_minimum_that_a_general_programme_finds(hand):
    play = 'clearance = "5 mm"\ncontact = "impact"'
    m = fourbar(B=play, C=play, D="stop = { min = 1.2, max = 2.2 }")
    pull = Pull(m, "coupler", (0.02, 0.05))
    first, target = pull.q.copy(), np.array(pull.place) + hand
    got = pull.descent.lowest(first, Hand(target))
    joints = m.model.joints

    def gap(q, name):
        return place(m, q, joints[name].b) - place(m, q, joints[name].a)

    value = objective(pull, first, target)

    def at(u):
        return first + 0.1 * u

    def closure(u):
        return 1e2 * np.concatenate([gap(at(u), "A"), gap(at(u), "D")])

    def play_left(u):
        return np.array([1e4 * (0.005**2 - gap(at(u), name) @ gap(at(u), name)) for name in "BC"])

    def stop_left(u):
        return np.array([at(u)[8] - 1.2, 2.2 - at(u)[8]])

    held = [{"type": "eq", "fun": closure}, {"type": "ineq", "fun": play_left}, {"type": "ineq", "fun": stop_left}]
    options = {"ftol": 1e-15, "maxiter": 2000}  # it ends with words on rounding: what it finds is compared
    slow = minimize(lambda u: 1e2 * value(at(u)), np.zeros(9), method="SLSQP", constraints=held, options=options)
    assert np.abs(closure(slow.x)).max() < 1e-6
    assert value(got) <= value(at(slow.x)) * (1 + 1e-6) + 1e-12
    assert np.abs(got - at(slow.x)).max() < 1e-5


def test_a_point_on_a_fixed_pivot_says_that_it_does_not_move():
    m = fourbar()
    pulled = Pull(m, "crank", (-0.05, 0.0)).to(0.1, 0.1)
    assert not pulled.reached
    assert "no motion of the mechanism moves this point" in pulled.words


def test_a_light_bar_before_a_heavy_one_is_no_dead_centre():
    text = fourbar_text('joint = "A"\nangle = 1', *BARS, START).replace("mass = 3", "mass = 1e7")
    pull = Pull(rt.loads(text), "crank", (0.05, 0.0))
    words = pull.to(0.3, 0.3).words
    assert "as near as the joints allow" in words


def test_a_frame_does_not_move_and_says_so():
    brace = '[joints.brace]\ntype = "rod"\nconnect = ["ground.D", "crank.B"]\nlength = 0.2599'
    text = fourbar_text('joint = "A"\nangle = "1"', *BARS, START, joints=brace)
    m = rt.loads(text.replace('[drivers.motor]\njoint = "A"\nangle = "1"', ""))
    pull = Pull(m, "coupler", (0.0, 0.0))
    first = pull.q.copy()
    pulled = pull.to(1.0, 1.0)
    assert np.abs(pulled.q - first).max() < 1e-12
    assert "nothing can move" in pulled.words


def test_a_slider_follows_along_its_line_alone():
    pull = Pull(rt.loads(slider_crank()), "slider", (0.0, 0.0))
    pulled = pull.to(0.3, 0.1)
    assert pulled.q[-3:-1] == pytest.approx([0.3, 0.0], abs=1e-6)
    assert "as near" in pulled.words


def test_a_force_closes_every_play_along_it():
    play = 'clearance = "0.2 mm"\ncontact = "impact"'
    m = fourbar(B=play, C=play)
    pull = Pull(m, "coupler", (0.0, 0.0), motors=True)
    right = pull.by_force(10.0, 0.0).q
    left = pull.by_force(-10.0, 0.0).q
    joints = m.model.joints
    for q, sense in ((right, 1.0), (left, -1.0)):
        for name in "BC":
            offset = sense * (place(m, q, joints[name].b) - place(m, q, joints[name].a))
            assert np.hypot(*offset) == pytest.approx(0.2e-3, rel=1e-6), name
    assert right[2] == pytest.approx(left[2], abs=1e-12), "the motor holds the crank"
    assert right[3] - left[3] > 0.3e-3


def test_a_force_turns_a_free_crank_until_its_end_is_highest():
    pulled = Pull(fourbar(), "crank", (0.05, 0.0)).by_force(0.0, 1.0)
    assert pulled.q[2] == pytest.approx(math.pi / 2, abs=1e-3)


def test_a_force_that_nothing_holds_asks_for_a_motor():
    m = rt.Mechanism("free")
    m.ground(O=[0, 0])
    m.body("block", mass=1, inertia=0.01, points={"P": [0, 0]})
    m.prismatic("guide", "ground.O", "block.P")
    assert "hold it by a motor" in Pull(m, "block", (0.0, 0.0)).by_force(1.0, 0.0).words


def test_what_is_no_body_and_no_number_is_refused():
    m = fourbar()
    with pytest.raises(InputError, match="did you mean 'crank'"):
        Pull(m, "cranck", (0.0, 0.0))
    with pytest.raises(InputError, match="finite"):
        Pull(m, "crank", (math.nan, 0.0))
    with pytest.raises(InputError, match="finite"):
        Pull(m, "crank", (0.0, 0.0)).to(math.inf, 0.0)
    with pytest.raises(InputError, match="9 finite numbers"):
        Pull(m, "crank", (0.0, 0.0), np.zeros(6))


def test_a_pin_stays_in_its_slot_and_stops_at_its_end():
    m = rt.Mechanism("slot")
    m.ground(O=[0, 0])
    m.body("block", mass=1, inertia=0.01, points={"P": [0, 0.1]})
    m.joint("line", "slot", "ground.O", "block.P", axis=0.3, length="0.4 m")
    pull = Pull(m, "block", (0.0, 0.1))
    pulled = pull.to(1.0, 0.2)
    assert pull.place == pytest.approx((0.2 * math.cos(0.3), 0.2 * math.sin(0.3)), abs=1e-9)
    assert "'line' is at an end (max)" in pulled.words


def test_gears_turn_each_other():
    """Gears of 20 and 40 mm: a turn of the small one is half a turn of the other, the other way round."""
    m = rt.Mechanism("gears")
    m.ground(A=[0, 0], B=[0.06, 0])
    for name, ground in (("a", "A"), ("b", "B")):
        m.body(name, mass=1, inertia=0.001, points={"C": [0, 0]})
        m.revolute(f"pin_{name}", f"ground.{ground}", f"{name}.C")
    m.joint("mesh", "gear", "a.C", "b.C", radii=["20 mm", "40 mm"])
    pull = Pull(m, "a", (0.02, 0.0))
    for turn in np.linspace(0.1, math.tau, 60):
        pulled = pull.to(0.02 * math.cos(turn), 0.02 * math.sin(turn))
    assert pulled.q[2] == pytest.approx(math.tau, abs=1e-4)
    assert pulled.q[5] == pytest.approx(-0.5 * pulled.q[2], abs=1e-9)


def test_a_block_is_pushed_down_no_farther_than_the_floor():
    m = rt.Mechanism("floor")
    m.ground(O=[0, 0])
    m.body("block", mass=1, inertia=0.01, points={"L": [-0.1, -0.05], "R": [0.1, -0.05]})
    m.joint("floor", "surface", "ground.O", "block.L", axis=0, corners=["L", "R"], contact="impact")
    m.initial("block", x=0, y=0.3, angle=0.2)
    pull = Pull(m, "block", (0.0, 0.0))
    pulled = pull.to(0.1, -1.0)
    assert pulled.q == pytest.approx([0.1, 0.05, 0.0], abs=1e-5), "it lies flat"
    assert "'block' touches 'floor'" in pulled.words
    assert pull.to(0.1, 0.2).reached


@pytest.mark.parametrize("name", ["gear_rattle", "guide_play", "dominoes", "scotch_yoke", "step_ladder", "woodpecker"])
def test_slopes_of_gaps_are_those_of_differences(name):
    """Flanks, a block in a guide, outlines, a pin in a slot, surfaces and stops."""
    m = rt.example(name)
    movable, q, step = Movable(m.system, m.start.q), m.start.q, 1e-7 * m.system.size
    contacts = np.arange(len(movable.acts))
    movable.locate(q)
    slopes = movable.sides(contacts) * movable.scale
    for k in range(len(q)):
        gaps = []
        for sign in (1.0, -1.0):
            movable.locate(q + sign * step * np.eye(len(q))[k])
            gaps.append(movable.gaps)
        assert slopes[:, k] == pytest.approx((gaps[0] - gaps[1]) / (2 * step), abs=1e-6 / m.system.size)


def test_a_block_touches_the_walls_of_its_guide_and_does_not_enter_them():
    """Corners of the block, from its place and angle, against walls at half its height and the clearance."""
    m, rng = rt.example("guide_play"), np.random.default_rng(4)
    joint = next(joint for joint in m.model.joints.values() if joint.dimensions)
    (length, height), line = joint.dimensions["block"], joint.fields["axis"]
    assert joint.a.body == "ground"
    pull, most = Pull(m, joint.b.body, joint.b.at), 0.0
    for n in range(40):
        q = pull.to(*(np.array(pull.place) + rng.normal(0.0, (0.002, 0.05)[n % 2], 2))).q
        turn = angle(m, q, joint.b.body) - joint.fields["angle"] + line
        for x, y in ((length, height), (-length, height), (length, -height), (-length, -height)):
            corner = place(m, q, joint.b) - place(m, q, joint.a)
            corner = corner + 0.5 * np.array(
                [math.cos(turn) * x - math.sin(turn) * y, math.sin(turn) * x + math.cos(turn) * y]
            )
            across = abs(math.cos(line) * corner[1] - math.sin(line) * corner[0])
            most = max(most, across - 0.5 * height - joint.clearance)
    assert abs(most) < 1e-9, "it has touched, and not entered"
