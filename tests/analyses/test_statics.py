"""Equilibria: reference values, virtual work, stability, partners of clearance pins, quasi-static motions."""

import math

import numpy as np
import pytest

import rattle as rt
from linkages import fourbar_text, paper, parallelogram
from rattle.questions.equilibrium.balance import StaticProblem
from rattle.questions.equilibrium.starts import opened

nojit = pytest.mark.nojit


LOW = """
[bodies.low]
bar = ["T", "B"]
length = 0.5
mass = 2
[joints.P]
type = "revolute"
connect = ["rod.B", "low.T"]
"""
TWICE = """
[joints.again]
type = "fixed"
connect = ["ground.O", "rod.T"]
angle = -1.0
[joints.twice]
type = "rod"
connect = ["ground.S", "rod.T"]
length = 1.5
"""


def pendulum(extra: str = "", angle: float = -1.0, clearance: str = "") -> str:
    """A rod of 1 kg and 1 m, hung at one end."""
    return f"""
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
S = [0, 1.5]
[bodies.rod]
bar = ["T", "B"]
length = 1
mass = 1
[joints.O]
type = "revolute"
connect = ["ground.O", "rod.T"]
{clearance}
{extra}
[initial]
rod = {{ angle = {angle} }}
"""


# ---------------------------------------------------------------- reference values
@nojit
@pytest.mark.parametrize(
    ("load", "gravity", "angles", "normals"),  # independent high-precision reference
    [
        (-40.0, 0.0, (1.028319194262, -1.056636729664), (76.5661893152, 76.5661893152)),
        (40.0, 9.81, (1.044081187923, -1.018844189722), (78.9900595625, 63.6192904624)),
    ],
)
def test_the_papers_mechanism_rests_where_the_reference_says(load, gravity, angles, normals):
    found = rt.loads(paper(load, gravity)).equilibrium(t=0.0)
    best = found[0]
    assert (best["coupler.angle"], best["rocker.angle"]) == pytest.approx(angles, abs=1e-11)
    assert (best["O3.normal"], best["O4.normal"]) == pytest.approx(normals, abs=1e-8)
    assert best.admissible
    assert best.stable
    assert best.reactions_unique
    assert best.residual < 1e-9
    assert best.gap < 1e-14
    assert best.unit("O3.normal") == "N"


@nojit
def test_every_pin_has_its_partner_on_the_other_side():
    found = rt.loads(paper()).equilibrium()
    signs = {(one["O3.normal"] > 0, one["O4.normal"] > 0) for one in found}
    assert signs == {(True, True), (True, False), (False, True), (False, False)}
    assert [one.admissible for one in found] == [True, False, False, False]
    assert not any(one.stable for one in found[1:])  # the paper's pins hang in their bushes only when they press
    assert {one.pulled for one in found} == {(), ("O3",), ("O4",), ("O3", "O4")}


@nojit
def test_a_two_force_coupler_only_changes_its_length():
    play = rt.loads(paper()).equilibrium()[0]
    # reaction at O3 along the coupler, at O4 parallel to it: the coupler acts as if r longer, so does the rocker's arm
    e3, e4 = (np.array([play[f"{pin}.ex"], play[f"{pin}.ey"]]) for pin in ("O3", "O4"))
    along = np.array([math.cos(play["coupler.angle"]), math.sin(play["coupler.angle"])])
    assert abs(along @ e3) == pytest.approx(0.005, abs=1e-12)
    assert abs(along @ e4) == pytest.approx(0.005, abs=1e-12)
    longer = paper().replace("length = 0.6\nmass = 2\n[bodies.rocker]", "length = 0.61\nmass = 2\n[bodies.rocker]")
    assert play["rocker.angle"] == pytest.approx(rt.loads(longer).ideal().equilibrium()[0]["rocker.angle"], abs=1e-10)


# ---------------------------------------------------------------- stability
@nojit
def test_stability_of_a_pendulum():
    found = rt.loads(pendulum()).equilibrium()
    assert [(round(math.sin(one["rod.angle"])), one.stable) for one in found] == [(-1, True), (1, False)]
    assert found[0]["O.fy"] == pytest.approx(9.81, abs=1e-10)
    # a displacement dz turns by dphi, dz^2 = (0.5 dphi)^2 + (size dphi)^2: H = m g l/2 dphi^2/dz^2
    problem = StaticProblem(rt.loads(pendulum()).system, 0.0)
    arm = 0.25 + problem.system.size**2
    assert found[0].eigenvalue == pytest.approx(9.81 * 0.5 / arm, rel=1e-9)
    assert found[1].eigenvalue == pytest.approx(-9.81 * 0.5 / arm, rel=1e-9)


@nojit
def test_reduced_hessian_is_the_second_difference_of_the_energy():
    spring = '[loads.spring]\ntype = "spring"\nconnect = ["ground.S", "rod.B"]\nstiffness = 40\nfree_length = 0.3\n'
    m = rt.loads(pendulum(spring, angle=0.4))
    one = m.equilibrium()[0]
    problem = StaticProblem(m.system, 0.0)
    _, null = problem.reduce(one.q)
    h = problem.hessian(one.q, null)

    def energy(angle):
        end = np.array([math.cos(angle), math.sin(angle)])
        return 9.81 * 0.5 * end[1] + 20 * (np.hypot(*(end - [0, 1.5])) - 0.3) ** 2

    at, step = one["rod.angle"], 1e-3
    second = (
        -energy(at + 2 * step)
        + 16 * energy(at + step)
        - 30 * energy(at)
        + 16 * energy(at - step)
        - energy(at - 2 * step)
    ) / (12 * step**2)
    assert h[0, 0] == pytest.approx(second * float(null[2, 0]) ** 2, rel=1e-7)


@nojit
def test_reduced_hessian_with_clearance_pins_is_that_of_the_energy_over_their_directions():
    m = rt.loads(paper(40.0, 9.81))
    one = m.equilibrium()[0]
    problem = StaticProblem(m.system, 0.0)
    g, null = problem.reduce(one.q)
    h = problem.hessian(one.q, null)

    def energy(z):  # positions closed by least change, gravity and the constant torque
        q = one.q + null @ z
        for _ in range(3):
            problem.close(q)
        bodies = dict(zip(m.system.bodies, q.reshape(-1, 3), strict=True))
        return (
            9.81 * (0.5 * bodies["crank"][1] + 2 * bodies["coupler"][1] + 2 * bodies["rocker"][1])
            - 40 * bodies["rocker"][2]
        )

    step = 2e-5
    axes = np.eye(2)
    found = np.zeros((2, 2))
    for i in range(2):
        for j in range(2):
            corners = [(a * axes[i] + b * axes[j]) * step for a, b in ((1, 1), (1, -1), (-1, 1), (-1, -1))]
            found[i, j] = (energy(corners[0]) - energy(corners[1]) - energy(corners[2]) + energy(corners[3])) / (
                4 * step**2
            )
    np.testing.assert_allclose(h, found, rtol=1e-3, atol=1e-3 * np.abs(h).max())  # rounding of second differences
    assert np.abs(g).max() < 1e-9
    assert one.eigenvalue == pytest.approx(np.linalg.eigvalsh(0.5 * (h + h.T))[0], rel=1e-6)


def test_equilibrium_is_where_a_damped_motion_ends():
    m = rt.example("balanced_arm").set({"loads.spring.damping": 60})
    best = m.equilibrium()[0]
    assert math.degrees(best["arm.angle"]) == pytest.approx(20, abs=1e-9)  # for which its spring is made
    assert best["lamp.angle"] == pytest.approx(-math.pi / 2, abs=1e-9)
    held = m.to_toml() + '\n[loads.air]\ntype = "torque"\nbody = "lamp"\ntorque = "-0.05*lamp.omega"\n'
    r = rt.loads(held).simulate(60.0, t_eval=[0.0, 60.0], rtol=1e-8)
    assert r["arm.angle"][-1] == pytest.approx(best["arm.angle"], abs=1e-6)
    assert r["lamp.angle"][-1] == pytest.approx(best["lamp.angle"], abs=1e-6)


@nojit
def test_all_equilibria_of_a_double_pendulum_are_found_and_one_is_stable():
    text = pendulum(LOW)
    found = rt.loads(text).equilibrium()
    up = {(round(math.sin(one["rod.angle"])), round(math.sin(one["low.angle"]))) for one in found}
    assert up == {(-1, -1), (-1, 1), (1, -1), (1, 1)}
    assert [one.stable for one in found] == [True, False, False, False]


# ---------------------------------------------------------------- branches, redundancy, compliance
@nojit
def test_other_ways_to_put_a_four_bar_together_are_found_when_asked():
    m = rt.loads(paper()).ideal()
    assert len(m.equilibrium()) == 1
    found = m.equilibrium(branches="all")
    assert len(found) == 2
    # the other branch mirrors the triangle at the line from the crank pin to O4
    assert found[1]["coupler.angle"] == pytest.approx(-found[0]["coupler.angle"], abs=1e-10)
    with pytest.raises(ValueError, match="branches"):
        m.equilibrium(branches="some")


@nojit
def test_redundant_reactions_are_flagged():
    text = pendulum(TWICE)
    one = rt.loads(text).equilibrium()[0]
    assert not one.reactions_unique
    assert {"O", "again"} <= set(one.nonunique)
    assert one.dof == 0
    assert one.stable
    assert rt.loads(pendulum()).equilibrium()[0].reactions_unique


@nojit
def test_a_compliant_pin_sinks_in_by_its_law():
    contact = 'clearance = 0.005\ncontact = { model = "hertz", stiffness = 1e7, exponent = 1.5, bush_radius = 0.02 }'
    one = rt.loads(pendulum(clearance=contact)).equilibrium()[0]
    assert one["O.normal"] == pytest.approx(9.81, rel=1e-9)
    assert one["O.penetration"] == pytest.approx((9.81 / 1e7) ** (2 / 3), rel=1e-7)
    assert one["rod.y"] == pytest.approx(-0.5 - 0.005 - (9.81 / 1e7) ** (2 / 3), abs=1e-11)
    assert one.stable


@nojit
def test_forces_that_depend_on_rates_are_taken_at_rest():
    drag = '[loads.drag]\ntype = "torque"\nbody = "rod"\ntorque = "1.0 - 5*rod.omega"\n'
    one = rt.loads(pendulum(drag)).equilibrium()[0]
    assert 9.81 * 0.5 * math.cos(one["rod.angle"]) == pytest.approx(1.0, abs=1e-10)


@nojit
def test_drivers_are_held_where_they_are_at_the_time_asked():
    m = rt.loads(paper(0.0, 9.81)).ideal()
    for t in (0.0, 0.13):
        one, moving = m.equilibrium(t)[0], m.kinematics(t)
        assert one["rocker.angle"] == pytest.approx(moving["rocker.angle"][0], abs=1e-12)
        # virtual work: torque of the motor = rate of the potential energy over the crank's
        h = 1e-5
        near = (
            m.inverse_dynamics([t - 2 * h, t - h, t + h, t + 2 * h])["energy.potential"]
            if t
            else m.inverse_dynamics([-2 * h, -h, h, 2 * h])["energy.potential"]
        )
        slope = (near[0] - 8 * near[1] + 8 * near[2] - near[3]) / (12 * h) / 10
        assert one["motor.torque"] == pytest.approx(slope, abs=1e-7)
        assert one["motor.power"] == 0.0


# ---------------------------------------------------------------- quasi-static motion
@nojit
def test_a_toggle_clamp_amplifies_as_one_over_the_sine():
    r = rt.example("toggle_clamp").equilibrium(np.linspace(0, 1, 14))
    angle = np.radians(40 - 39 * r.t)
    # at one degree from the dead centre rounding is magnified 57 times, twice
    np.testing.assert_allclose(r["work.advantage"], 1 / (0.2 * np.sin(angle)), rtol=1e-9)
    np.testing.assert_allclose(r["hand.torque"], -1000 * 0.2 * np.sin(angle), rtol=1e-9)
    assert r.unit("work.advantage") == "1/m"


@pytest.mark.machine
@nojit
def test_slow_motion_with_play_stays_on_its_branch_and_meets_the_single_positions():
    m = rt.loads(paper(-40.0, 9.81))
    r = m.equilibrium(np.linspace(0, 0.6, 13))
    assert r.success
    assert (r["equilibrium.stable"] == 1).all()
    assert (r["equilibrium.admissible"] == 1).all()
    for k in (3, 8, 12):
        one = m.equilibrium(r.t[k])[0]
        assert r["rocker.angle"][k] == pytest.approx(one["rocker.angle"], abs=1e-9)
        assert r["O3.normal"][k] == pytest.approx(one["O3.normal"], abs=1e-6)
        assert r["motor.torque"][k] == pytest.approx(one["motor.torque"], abs=1e-7)


@nojit
def test_a_pin_changes_sides_where_its_force_goes_through_zero():
    # a slide that hangs on a pin: its load turns from pulling down to pushing up at t = 0.37 s
    text = """
format = 1
[ground.points]
O = [0, 0]
[bodies.slide]
points = { P = [0, 0] }
mass = 1
inertia = 1
[bodies.lift]
points = { Q = [0, 0] }
mass = 1
inertia = 1
[joints.guide]
type = "prismatic"
connect = ["ground.O", "slide.P"]
axis = "90 deg"
[joints.column]
type = "prismatic"
connect = ["ground.O", "lift.Q"]
axis = "90 deg"
[joints.pin]
type = "revolute"
connect = ["lift.Q", "slide.P"]
clearance = "1 mm"
[drivers.up]
joint = "column"
position = "0.1*t"
[loads.pull]
type = "force"
at = "slide.P"
force = [0, "100*(t - 0.37)"]
[initial]
pin = { offset = [0, -0.001] }
"""
    r = rt.loads(text).equilibrium(np.linspace(0, 1, 11))
    assert r.success
    assert [(e.joint, e.kind) for e in r.events] == [("pin", "side")]
    assert r.events[0].t == pytest.approx(0.37, abs=1e-9)
    np.testing.assert_allclose(r["pin.normal"], np.abs(100 * (r.t - 0.37)), atol=1e-9)
    np.testing.assert_allclose(r["pin.ey"], np.sign(r.t - 0.37) * 1e-3, atol=1e-12)
    assert (r["equilibrium.admissible"] == 1).all()


@nojit
def test_slow_motion_of_a_parallelogram_has_the_torque_of_its_weight():
    r = rt.loads(parallelogram()).equilibrium(np.linspace(0, 1, 6))
    np.testing.assert_allclose(r["motor.torque"], 9.81 * 0.4 * (0.5 + 2 + 1.5) * np.cos(1 + 2 * r.t), atol=1e-9)


@nojit
def test_pins_are_displaced_by_what_is_asked():
    m = rt.loads(paper())
    ideal = StaticProblem(m.ideal().system, 0.0)
    start = m.ideal().start.q
    wanted = {"O3": np.array([1e-3, 2e-3]), "O4": np.array([-3e-3, 0.0])}
    moved = StaticProblem(m.system, 0.0).offsets(opened(ideal, start, wanted))
    np.testing.assert_allclose(moved, [wanted["O3"], wanted["O4"]], atol=1e-14)


@nojit
def test_gravity_on_a_four_bar_agrees_with_the_sum_over_its_loads():
    text = fourbar_text('joint = "A"\nangle = "0.7 + 0*t"', 0.2, 0.6, 0.5, 0.7, "rocker = { angle = 1.9 }")
    one = rt.loads(text).equilibrium()[0]
    assert one["A.fy"] + one["D.fy"] == pytest.approx(6 * 9.81, abs=1e-9)
    assert one["A.fx"] + one["D.fx"] == pytest.approx(0, abs=1e-10)


def test_free_motion_leads_through_one_rest_not_through_many():
    # a round pin in its bush may turn as it likes: below it lies, on top it would have to hang
    low, high = rt.loads("""
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.pin]
points = { P = [0, 0] }
mass = 1
inertia = 1e-3
[joints.O]
type = "revolute"
connect = ["ground.O", "pin.P"]
clearance = "1 mm"
contact = "massless-link"
""").equilibrium()
    assert (low.neutral, low.falling, low.admissible) == (1, 0, True)
    assert low["pin.y"] == pytest.approx(-1e-3)
    assert low["O.normal"] == pytest.approx(9.81)
    assert (high.neutral, high.falling, high.admissible) == (1, 1, False)
    assert "neutral (free to move in 1 degree of freedom)" in str(low)


@pytest.mark.parametrize("contact", ["impact", {"model": "exact", "restitution": 0.4, "stiffness": 1e9}])
def test_guide_with_play_is_closed_at_rest(contact):
    found = rt.example("guide_play").set({"joints.guide.contact": contact}).equilibrium()
    assert found[0].stable
    assert found[0]["crank.angle"] == pytest.approx(-math.pi / 2)
    assert abs(found[0]["slider.y"]) < 1e-12


def test_soft_freedom_beside_a_stiff_contact_is_not_taken_for_a_free_one():
    m = rt.example("door_hinge")
    hanging, upright = m.equilibrium()
    hard = [one for one in m.with_contact("impact").equilibrium() if one.admissible]
    assert hanging.stable
    assert upright.falling == 1
    assert [one.eigenvalue for one in (hanging, upright)] == pytest.approx([one.eigenvalue for one in hard], rel=1e-3)
    assert "unstable" not in str(m.modes())
