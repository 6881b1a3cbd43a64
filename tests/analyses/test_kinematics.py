"""Driven motion against closed forms, against a simulation of the same drive, and at its singular positions."""

import math

import numpy as np
import pytest

import rattle as rt
from linkages import fourbar_text, paper, parallelogram, slider_crank

nojit = pytest.mark.nojit
ROUND = 1e-12  # positions are closed to rounding, whatever the interval


def slider_position(angle, crank=0.1, rod=0.3):
    return crank * np.cos(angle) + np.sqrt(rod**2 - (crank * np.sin(angle)) ** 2)


def rocker_angle(angle, a, b, c, d, side):
    """Closed form of the four-bar: triangle over the diagonal from the crank pin to D."""
    x, y = d - a * np.cos(angle), -a * np.sin(angle)
    diagonal = np.hypot(x, y)
    at_rocker = np.arccos((diagonal**2 + c**2 - b**2) / (2 * diagonal * c))
    return np.arctan2(y, x) + np.pi - side * at_rocker


@nojit
def test_what_is_not_driven_is_named_beside_a_body_that_nothing_joins():
    m = rt.Mechanism("pendulum").ground(O=[0, 0]).body("rod", mass=1, inertia=1, points={"A": [0, 0]})
    m.body("alone", mass=1, inertia=1, points={"C": [0, 0]}).revolute("O", "ground.O", "rod.A")
    with pytest.raises(rt.ModelError, match=r"1 degree of freedom is left \(can still move: rod\)"):
        m.kinematics([0.0, 0.1])


# ---------------------------------------------------------------- closed forms
@nojit
def test_slider_crank_moves_as_its_closed_form():
    t = np.linspace(0, 1, 40)
    r = rt.loads(slider_crank()).kinematics(t)
    x = slider_position(7 * t)
    s, root = 0.1 * np.sin(7 * t), np.sqrt(0.3**2 - (0.1 * np.sin(7 * t)) ** 2)
    slope = -s - s * 0.1 * np.cos(7 * t) / root  # dx/d(angle)
    np.testing.assert_allclose(r["slider.x"], x, atol=ROUND)
    np.testing.assert_allclose(r["slider.vx"], 7 * slope, atol=ROUND)
    bend = -0.1 * np.cos(7 * t) - (0.01 * np.cos(14 * t) * root**2 + 0.25 * (0.01 * np.sin(14 * t)) ** 2) / root**3
    np.testing.assert_allclose(r["slider.ax"], 49 * bend, atol=1e-10)
    assert r.success
    assert r.unit("slider.ax") == "m/s^2"


@nojit
@pytest.mark.parametrize(("side", "start"), [(1, 1.2), (-1, -1.2)])
def test_each_branch_of_a_four_bar_follows_its_own_closed_form(side, start):
    text = fourbar_text('joint = "A"\nangle = "3*t"', 0.2, 0.6, 0.5, 0.7, f"rocker = {{ angle = {math.pi - start} }}")
    r = rt.loads(text).kinematics(np.linspace(0, 2 * math.pi / 3, 5))  # coarse on purpose
    want = rocker_angle(3 * r.t, 0.2, 0.6, 0.5, 0.7, side)
    apart = (r["rocker.angle"] - want + np.pi) % (2 * np.pi) - np.pi
    np.testing.assert_allclose(apart, 0, atol=ROUND)


@nojit
def test_input_torque_of_a_slider_crank_is_its_virtual_work():
    t = np.linspace(0.01, 0.89, 45)
    r = rt.loads(slider_crank()).inverse_dynamics(t)

    def beta(t):
        return -np.arcsin(0.1 / 0.3 * np.sin(7 * t))

    def rate(f, h=1e-5):
        return (f(t_now - 2 * h) - 8 * f(t_now - h) + 8 * f(t_now + h) - f(t_now + 2 * h)) / (12 * h)

    def kinetic():  # at constant crank speed only the rod and the slider count
        vx = rate(lambda t: 0.1 * np.cos(7 * t) + 0.15 * np.cos(beta(t)))
        vy = rate(lambda t: 0.1 * np.sin(7 * t) + 0.15 * np.sin(beta(t)))
        slide = rate(lambda t: slider_position(7 * t))
        return 0.3 * (vx**2 + vy**2) + 0.5 * (0.6 * 0.09 / 12) * rate(beta) ** 2 + 0.4 * slide**2

    energy = []
    for shift in (-2e-4, -1e-4, 1e-4, 2e-4):
        t_now = t + shift
        energy.append(kinetic())
    power = (energy[0] - 8 * energy[1] + 8 * energy[2] - energy[3]) / (12 * 1e-4)
    np.testing.assert_allclose(r["motor.torque"] * 7, power, atol=1e-6)  # differences of differences
    np.testing.assert_allclose(r["motor.power"], r["motor.torque"] * 7, rtol=1e-12)


def test_driven_motion_and_reactions_agree_with_a_simulation_of_the_same_drive():
    text = fourbar_text('joint = "A"\nangle = "4*t + 0.3*sin(5*t)"', 0.2, 0.6, 0.5, 0.7, "rocker = { angle = 1.9 }")
    m = rt.loads(text)
    t = np.linspace(0, 1.5, 16)
    driven, run = m.inverse_dynamics(t), m.simulate(t_eval=t, rtol=1e-11, atol=1e-13)
    for name in driven.names:
        scale = 1 + np.abs(run[name]).max()
        np.testing.assert_allclose(driven[name], run[name], atol=1e-9 * scale, err_msg=name)


@nojit
def test_power_of_driver_and_loads_is_the_change_of_energy():
    loads = """
[loads.spring]
type = "spring"
connect = ["ground.D", "coupler.B"]
stiffness = 300
free_length = 0.2
"""
    text = fourbar_text('joint = "A"\nangle = "4*t + t**2"', 0.2, 0.6, 0.5, 0.7, "rocker = { angle = 1.9 }", loads)
    m = rt.loads(text)
    h = 1e-4
    for t in (0.1, 0.5, 1.1):
        r = m.inverse_dynamics([t - 2 * h, t - h, t, t + h, t + 2 * h])
        energy = r["energy.kinetic"] + r["energy.potential"]
        rate = (energy[0] - 8 * energy[1] + 8 * energy[3] - energy[4]) / (12 * h)
        assert r["motor.power"][2] == pytest.approx(rate, abs=1e-7)


@pytest.mark.machine
@nojit
def test_a_coarse_grid_gives_the_same_positions_as_a_fine_one():
    m = rt.loads(slider_crank('joint = "O"\nangle = "20*t"'))
    fine, coarse = m.kinematics(np.linspace(0, 3, 601)), m.kinematics([0.0, 1.0, 3.0])
    for name in ("rod.angle", "slider.vx", "rod.alpha"):
        np.testing.assert_allclose(coarse[name], fine[name][[0, 200, 600]], atol=1e-10)


@nojit
def test_times_need_not_start_at_zero_nor_be_positive():
    m = rt.loads(slider_crank())
    np.testing.assert_allclose(
        m.kinematics([-2.0, -0.5, 1.5])["slider.x"], slider_position(7 * np.array([-2, -0.5, 1.5])), atol=ROUND
    )
    assert m.kinematics(4.0)["slider.x"] == pytest.approx(slider_position(28.0), abs=ROUND)
    for bad in ([1.0, 1.0], [2.0, 1.0], [math.nan], []):
        with pytest.raises(ValueError, match="t_eval"):
            m.kinematics(bad)


# ---------------------------------------------------------------- drivers anywhere
@nojit
def test_a_driver_on_the_slider_needs_the_force_that_does_the_motors_work():
    law = 'position = "0.1*cos(7*t) + sqrt(0.09 - 0.01*sin(7*t)**2)"'
    driven = slider_crank(f'body = "slider"\ncoordinate = "x"\n{law}', crank="{ angle = 1.05 }")
    t = np.linspace(0.15, 0.3, 9)  # crank between 60 and 120 degrees: no dead centre
    pushed = rt.loads(driven.replace("7*t", "7*(t + 0.15)"))
    r = pushed.inverse_dynamics(t - 0.15)
    motor = rt.loads(slider_crank()).inverse_dynamics(t)
    np.testing.assert_allclose(r["crank.angle"], 7 * t, atol=1e-11)
    np.testing.assert_allclose(r["motor.power"], motor["motor.power"], atol=1e-10)
    np.testing.assert_allclose(r["motor.force"] * r["slider.vx"], r["motor.power"], atol=1e-11)
    # output to input: the torque of a motor at O for this motion, with all reactions as if it drove
    other = pushed.inverse_dynamics(t - 0.15, effort_at="O")
    np.testing.assert_allclose(other["O.torque"], motor["motor.torque"], atol=1e-10)
    np.testing.assert_allclose(other["O.power"], motor["motor.power"], atol=1e-10)
    assert other.unit("O.torque") == "N*m"
    for name in ("A.fx", "B.fy", "guide.moment", "O.fx"):
        np.testing.assert_allclose(other[name], motor[name], atol=1e-9, err_msg=name)
    assert "motor.force" not in other


@nojit
@pytest.mark.parametrize("coordinate", ["x", "y", "angle"])
def test_any_coordinate_of_a_body_or_point_can_be_driven(coordinate):
    key = "angle" if coordinate == "angle" else "position"
    body = "rod" if coordinate == "angle" else "rod.A"
    wanted = {"x": "0.1*cos(1 + t)", "y": "0.1*sin(1 + t)", "angle": "-asin(sin(1 + t)/3)"}[coordinate]
    text = slider_crank(f'body = "{body}"\ncoordinate = "{coordinate}"\n{key} = "{wanted}"', crank="{ angle = 1.0 }")
    r = rt.loads(text).inverse_dynamics(np.linspace(0, 0.3, 4))
    np.testing.assert_allclose(r["crank.angle"], 1 + r.t, atol=1e-11)
    np.testing.assert_allclose(r["crank.alpha"], 0, atol=1e-9)
    motor = rt.loads(slider_crank('joint = "O"\nangle = "1 + t"')).inverse_dynamics(r.t)
    np.testing.assert_allclose(r["motor.power"], motor["motor.power"], atol=1e-10)


@nojit
def test_a_bad_driver_or_motor_is_refused_with_words():
    with pytest.raises(rt.ModelError, match="coordinate = "):
        rt.loads(slider_crank('body = "slider"\ncoordinate = "z"\nposition = 0'))
    with pytest.raises(rt.ModelError, match="driven by 'position'"):
        rt.loads(slider_crank('body = "slider"\ncoordinate = "x"\nangle = 0'))
    m = rt.loads(slider_crank())
    with pytest.raises(ValueError, match="no joint 'Q'"):
        m.inverse_dynamics([0.0], effort_at="Q")
    with pytest.raises(ValueError, match="no driver 'engine'"):
        m.inverse_dynamics([0.0], effort_at={"engine": "A"})


# ---------------------------------------------------------------- singular positions
@nojit
@pytest.mark.parametrize("count", [5, 41, 400])
def test_a_parallelogram_passes_its_change_points_and_says_where_they_are(count):
    r = rt.loads(parallelogram()).inverse_dynamics(np.linspace(0, 4, count))
    np.testing.assert_allclose(r["rocker.angle"], 1 + 2 * r.t, atol=1e-11)
    np.testing.assert_allclose(r["coupler.omega"], 0, atol=1e-9)
    np.testing.assert_allclose([e.t for e in r.events], [(math.pi - 1) / 2, (2 * math.pi - 1) / 2], atol=1e-10)
    assert {e.kind for e in r.events} == {"branch point"}
    assert len(r.trust.notes) == 2
    assert all(all(joint in note for joint in ("A", "B", "C", "D")) and "branch" in note for note in r.trust.notes)
    assert r.success


@nojit
def test_an_output_exactly_at_a_change_point_has_the_rates_of_the_smooth_motion():
    r = rt.loads(parallelogram()).kinematics([0.0, (math.pi - 1) / 2, 2.0])
    np.testing.assert_allclose(r["rocker.omega"], 2, atol=1e-10)
    np.testing.assert_allclose(r["rocker.alpha"], 0, atol=1e-8)


@pytest.mark.machine
@nojit
def test_a_rocker_stops_at_its_dead_centre_which_is_located():
    text = fourbar_text(
        'joint = "D"\nangle = "2 - 1.0*t"', 0.3, 1.0, 0.5, 1.0, "crank = { angle = 1.5 }\ncoupler = { angle = 0.1 }"
    )
    r = rt.loads(text).inverse_dynamics(np.linspace(0, 3, 61))
    inside = math.acos((1 + 0.25 - 1.3**2) / (2 * 0.5))  # crank and coupler in one line
    limit = 2 - (math.pi - inside)
    assert not r.success
    assert r.t[-1] < limit < r.t[-1] + 0.05
    assert r.events[-1].t == pytest.approx(limit, abs=1e-11)
    assert r.events[-1].kind == "dead centre"
    assert "dead centre" in r.message
    assert "'motor'" in r.message
    with pytest.raises(rt.SolverError) as caught:
        rt.loads(text).kinematics(np.linspace(0, 3, 61), strict=True)
    assert len(caught.value.result.t) == len(r.t)


@nojit
def test_drivers_that_jump_or_lose_their_value_are_named():
    jump = rt.loads(slider_crank('joint = "O"\nangle = "2*step(t - 0.5)"'))
    with pytest.raises(rt.ModelError, match=r"'motor' jumps by 2 rad at t = 0\.5 s: no body can follow"):
        jump.kinematics(np.linspace(0, 1, 11))
    ends = rt.loads(slider_crank('joint = "O"\nangle = "sqrt(1 - t)"')).kinematics(np.linspace(0, 2, 21))
    assert not ends.success
    assert "'motor' has no finite value" in ends.message


# ---------------------------------------------------------------- degrees of freedom and redundancy
@nojit
def test_a_mechanism_that_is_not_fully_driven_is_told_what_can_still_move():
    free = paper().replace('[drivers.motor]\njoint = "O1"\nangle = "10*t"', "")
    with pytest.raises(
        rt.ModelError, match=r"2 degrees of freedom are left \(can still move: coupler, rocker\).*O3, O4"
    ):
        rt.loads(paper()).kinematics([0.0])
    with pytest.raises(rt.ModelError, match=r"1 degree of freedom is left .*crank, coupler, rocker.*Add a driver"):
        rt.loads(free).ideal().kinematics([0.0])


@nojit
def test_redundant_cranks_move_right_and_their_reactions_are_flagged():
    third = """
[joints.E]
type = "revolute"
connect = ["ground.E", "middle.E"]
[joints.F]
type = "revolute"
connect = ["middle.F", "coupler.M"]
"""
    text = (
        parallelogram()
        .replace("D = [1.0, 0]", "D = [1.0, 0]\nE = [0.5, 0]")
        .replace("[joints.A]", '[bodies.middle]\nbar = ["E", "F"]\nlength = 0.4\nmass = 1\n[joints.A]')
    )
    text = text.replace('bar = ["B", "C"]', 'bar = ["B", "C"]\npoints = { M = [0, 0] }').replace(
        "[drivers.motor]", third + "[drivers.motor]"
    )
    text = text.replace("rocker = { angle = 1 }", "rocker = { angle = 1 }\nmiddle = { angle = 1 }")
    r = rt.loads(text).inverse_dynamics(np.linspace(0, 0.9, 10))
    np.testing.assert_allclose(r["middle.angle"], 1 + 2 * r.t, atol=1e-11)
    assert {"B", "C", "E", "F"} <= set(r.trust.nonunique)
    assert "motor" not in r.trust.nonunique
    weight = 9.81 * 0.4 * (0.5 * 1 + 2 + 0.5 * 3 + 0.5 * 1)  # only gravity does work at constant speed
    np.testing.assert_allclose(r["motor.torque"], weight * np.cos(1 + 2 * r.t), atol=1e-9)


def test_long_sweeps_in_machine_code_agree_with_plain_python():
    m = rt.loads(slider_crank())
    t = np.linspace(0, 1, 5001)
    np.testing.assert_allclose(m.kinematics(t)["slider.x"], slider_position(7 * t), atol=ROUND)


@nojit
@pytest.mark.parametrize("count", [41, 42])
def test_a_sweep_in_pieces_is_the_sweep_in_one(count, monkeypatch):
    m = rt.loads(parallelogram())  # leaps across its change points, also beyond the end of a piece
    t = np.linspace(0, 1.9, count)
    whole = m.kinematics(t)
    monkeypatch.setattr("rattle.questions.kinematics.sweep.PIECE", 1)  # two positions at a time
    pieces = m.kinematics(t)
    for name in whole.stored:
        np.testing.assert_array_equal(pieces[name], whole[name])
    assert [one.t for one in pieces.events] == [one.t for one in whole.events]


@nojit
def test_signals_are_recorded_with_their_units():
    text = slider_crank(extra='[signals]\nreach = "slider.x - 0.2"\nspeed = "abs(slider.vx)"')
    r = rt.loads(text).kinematics(np.linspace(0, 0.5, 6))
    np.testing.assert_allclose(r["reach"], r["slider.x"] - 0.2, atol=1e-15)
    np.testing.assert_allclose(r["speed"], np.abs(r["slider.vx"]), atol=1e-15)


@pytest.mark.machine
@nojit
def test_hint_at_open_clearance_is_a_sentence_of_its_own():
    """Whether what cannot be assembled is said in one sentence, without a full stop, or in several."""
    outside = rt.example("scotch_yoke").set({"initial.slot.offset": ["-3*c", 0]})
    too_far = rt.loads(paper().replace("0.81", "5"))
    for m, joints in ((outside, "slot"), (too_far, "O3, O4")):
        with pytest.raises(rt.AssemblyError, match=rf"[^.]\. There is clearance in {joints}: close it with .*ideal\.$"):
            m.kinematics([0.0, 0.1])
