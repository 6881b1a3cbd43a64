"""The start is the one asked for; what cannot be kept is said, with who does not let it be."""

import math
from contextlib import suppress

import numpy as np
import pytest

import rattle as rt
from linkages import slider_crank
from rattle.equations.closure import open_by
from rattle.equations.dense import dense_rows

pytestmark = pytest.mark.nojit

SLIDING = """
format = 1
[ground.points]
O = [0, 0]
[bodies.mass]
points = { P = [0, 0] }
mass = 1.0
inertia = 1
[joints.rail]
type = "prismatic"
connect = ["ground.O", "mass.P"]
[joints.bush]
type = "revolute"
connect = ["ground.O", "mass.P"]
clearance = 0.01
contact = { model = "impact", restitution = 0.8 }
[initial]
mass = { START }
"""


PENDULUM = """
format = 1
[ground.points]
O = [0, 0]
[bodies.rod]
bar = ["A", "B"]
length = 1
mass = 1
[joints.O]
type = "revolute"
connect = ["ground.O", "rod.A"]
[initial]
rod = { angle = ANGLE }
"""


def cranks(count, play, angle, rate=10.0, driven=True):
    """Equal parallel cranks on one beam; the pins numbered in `play` are massless links of 0.2 mm."""
    m = rt.Mechanism("parallel cranks", gravity=[0, -9.81]).ground(**{f"G{k}": [0.15 * k, 0] for k in range(count)})
    m.body("beam", mass=0.5, inertia=0.01, points={f"P{k}": [0.15 * k, 0.0] for k in range(count)})
    for k in range(count):
        m.bar(f"crank{k}", "A", "B", length=0.1, mass=0.3).revolute(f"low{k}", f"ground.G{k}", f"crank{k}.A")
        fields = {"clearance": 2e-4, "contact": "massless-link"} if k in play else {}
        m.revolute(f"top{k}", f"beam.P{k}", f"crank{k}.B", **fields).initial(f"crank{k}", angle=angle, omega=rate)
    m.initial("beam", angle=0)
    return m.driver("motor", "low0", angle=f"{angle} + {rate}*t") if driven else m


def parallelogram(beside, given):
    """Cranks of 0.4 m, a little beside their change point; rates of the bodies in `given`."""
    m = rt.Mechanism("parallelogram").ground(A=[0, 0], D=[1, 0])
    m.bar("crank", "A", "B", length=0.4, mass=1).bar("coupler", "B", "C", length=1, mass=2)
    m.bar("rocker", "D", "C", length=0.4, mass=3)
    m.revolute("A", "ground.A", "crank.A").revolute("B", "crank.B", "coupler.B")
    m.revolute("C", "coupler.C", "rocker.C").revolute("D", "ground.D", "rocker.D")
    for body, angle, omega in (("crank", beside, 10.0), ("coupler", 0.0, 0.0), ("rocker", beside, 10.0)):
        m.initial(body, angle=angle, **({"omega": omega} if body in given else {}))
    return m


# ---------------------------------------------------------------- kept
@pytest.mark.parametrize(
    "start", ["x = 0.001, vx = 0.1", "x = 0.001, vx = 0.1, angle = 0", "x = 0.001, y = 0, vx = 0.1"]
)
def test_place_of_a_body_in_the_bush_is_the_one_given(start):
    m = rt.loads(SLIDING.replace("START", start))
    np.testing.assert_allclose(m.start.q, [0.001, 0, 0], atol=1e-16)
    np.testing.assert_allclose(m.start.v, [0.1, 0, 0], atol=1e-16)
    assert m.start.notes == ()


@pytest.mark.parametrize("x", [0.01, -0.01])
def test_massless_link_stands_on_the_side_where_its_body_was_put(x):
    text = SLIDING.replace("START", f"x = {x}")
    m = rt.loads(text.replace('{ model = "impact", restitution = 0.8 }', '"massless-link"'))
    np.testing.assert_allclose(m.start.q, [x, 0, 0], atol=1e-15)
    assert m.start.notes == ()


def test_place_beyond_the_bush_is_not_taken_and_said():
    m = rt.loads(SLIDING.replace("START", "x = 0.02"))
    assert m.start.q[0] == pytest.approx(0.0, abs=1e-12)
    assert "asked for mass.x = 0.02 m, got 0 m" in m.start.notes[0]


@pytest.mark.parametrize("given", [("crank",), ("crank", "rocker"), ("crank", "coupler", "rocker")])
@pytest.mark.parametrize("beside", [0.3, 1e-3, 1e-5, 1e-7])
def test_consistent_rates_are_kept_to_rounding_however_near_a_change_point(beside, given):
    v = parallelogram(beside, given).start.v
    np.testing.assert_allclose(v[2::3], [10.0, 0.0, 10.0], atol=1e-12)


def test_the_angle_given_stays_and_the_others_close_the_loop():
    m = parallelogram(0.7, ())
    m._document["initial"] = {"crank": {"angle": 0.9}}
    m._forget()
    q = m.start.q
    assert q[2] == 0.9
    crank, coupler, rocker = np.exp(1j * q[2::3])
    assert abs(0.4 * crank + coupler - 1.0 - 0.4 * rocker) < 1e-12
    assert m.start.notes == ()


def test_rates_that_do_not_go_together_change_least_by_mass_among_those_given():
    m = parallelogram(0.7, ("crank",)).initial("rocker", angle=0.7, omega=11.0)
    workspace = m.system.workspace()
    open_by(workspace, 0.0, m.start.q, m.start.v)
    rows = dense_rows(m.system, workspace)
    assert np.abs(rows @ m.start.v).max() < 1e-12
    # one degree of freedom w: inertia about the mass centre weighs what is asked of crank and rocker
    inertia = m.system.arrays["mass"][1:, 2]
    best = (10.0 * inertia[0] + 11.0 * inertia[2]) / (inertia[0] + inertia[2])
    assert m.start.v[2] == pytest.approx(best, rel=1e-9)
    assert "the given values contradict each other" in m.start.notes[0]


# ---------------------------------------------------------------- said
def test_values_against_the_driver_are_said_in_run_check_and_kinematics():
    text = slider_crank('joint = "O"\nangle = "7*t"', crank='{ angle = "90 deg", omega = 5 }')
    m = rt.loads(text)
    said = (
        "asked for crank.angle = 90 deg, got 0 deg; asked for crank.omega = 5 rad/s, got 7 rad/s:"
        " the driver 'motor' holds it"
    )
    assert m.start.notes == (said,)
    assert said in str(m.check())
    assert said in m.simulate(1e-3).trust.notes
    assert said in m.kinematics([0.0, 0.01]).trust.notes


def test_values_against_the_joints_are_said():
    m = rt.Mechanism("slider").ground(O=[0, 0]).body("block", mass=1, inertia=1, points={"P": [0, 0]})
    m.prismatic("rail", "ground.O", "block.P").initial("block", x=0.3, y=0.1, angle=0.2)
    assert m.start.q[0] == 0.3
    assert m.start.notes == (
        "asked for block.y = 0.1 m, got 0 m; asked for block.angle = 11.4592 deg, got 0 deg: the joints hold it",
    )


@pytest.mark.parametrize("angle", [0.0, 1e-30, 1e-9, 1e-3])
@pytest.mark.parametrize(
    "given", [{"crank.vx": 0.1}, {"crank.vx": 0.1, "arm.vy": 0.1}, {"rod.omega": -0.7, "crank.vx": 1e-3}]
)
def test_given_rates_that_a_motor_does_not_let_be_change_no_others(angle, given):
    """At rest on its dead centre a crank's vx hardly depends on its angular velocity: 0.1 m/s were 1e26 rad/s."""
    free = rt.example("wiper").set({"drivers.motor.angle": f"speed*t + {angle}"})
    m = free.set({f"initial.{name}": value for name, value in given.items()})
    np.testing.assert_allclose(m.start.v, free.start.v, rtol=0, atol=1e-7)
    assert all(f"asked for {name} = " in str(m.start.notes) for name in given)


def test_rough_angles_of_a_driven_linkage_are_said_by_the_check_alone():
    m = rt.example("five_bar")
    assert "asked for left_forearm.angle = 50 deg, got 45.3653 deg" in str(m.check())
    assert not m.start.notes  # they select a closing, and have done so
    assert "left_forearm" not in str(m.simulate(1e-3).trust)


def test_results_name_the_values_that_contradict_a_driver_in_one_line():
    m = rt.loads(slider_crank('joint = "O"\nangle = "7*t"', crank='{ angle = "90 deg", omega = 5 }'))
    notes = m.initial("rod", angle=0.4).initial("slider", x=0.1, vx=1).start.notes
    assert len(notes) == 1
    assert "crank.angle" in notes[0]
    assert "rod" not in notes[0]
    assert "and 1 more given values were changed" in notes[0]


def test_the_only_value_given_that_no_position_has_is_not_called_a_contradiction():
    m = rt.Mechanism("rocker").ground(A=[0, 0], D=[4, 0]).bar("crank", "A", "B", length=1, mass=1)
    m.bar("coupler", "B", "C", length=4, mass=1).bar("rocker", "D", "C", length=2, mass=1)
    m.revolute("A", "ground.A", "crank.A").revolute("B", "crank.B", "coupler.B")
    m.revolute("C", "coupler.C", "rocker.C").revolute("D", "ground.D", "rocker.D")
    (change,) = m.initial("rocker", angle="10 deg").start.changes
    assert change.endswith("the joints do not let it get there")


# ---------------------------------------------------------------- bodies that loads hold
def floating(rail="base.P", mount="spring"):
    """A slider-crank on a base that a load alone holds to the ground, with the guide on the base or the ground."""
    m = rt.Mechanism("floating slider-crank").ground(G=[0, 0], R=[0.5, 0], S=[0, -0.05])
    m.body("base", points={"O": [0, 0.1], "P": [0, 0]}, mass=5, inertia=1).bar("crank", "O", "A", length=0.1, mass=1)
    m.bar("rod", "A", "B", length=0.4, mass=1).body("slider", points={"B": [0, 0]}, mass=1, inertia=0.1)
    m.revolute("O", "base.O", "crank.O").revolute("A", "crank.A", "rod.A").revolute("B", "rod.B", "slider.B")
    m.prismatic("guide", rail, "slider.B")
    if mount == "spring":
        return m.load("mount", "spring", connect=["ground.S", "base.P"], stiffness=1000, free_length=0.05)
    offset = [0.02, 0.03, 0.1]
    return m.load("mount", "bushing", connect=["ground.G", "base.P"], stiffness=[1e4, 1e4, 100], offset=offset)


def place_of(m, body):
    k = 3 * m.system.bodies.index(body)
    return m.start.q[k : k + 3]


@pytest.mark.parametrize("rail", ["base.P", "ground.R"])
@pytest.mark.parametrize(("mount", "place"), [("spring", (0, 0, 0)), ("bushing", (0.02, 0.03, 0.1))])
def test_base_that_a_load_holds_stands_at_the_origin_or_without_force_and_the_rest_is_closed_around_it(
    rail, mount, place
):
    m = floating(rail, mount)
    for more in ({}, {"angle": "30 deg"}, {"angle": "100 deg", "omega": 4}):
        if more:
            m.initial("crank", **more)
        np.testing.assert_allclose(place_of(m, "base"), place, atol=1e-12)
        assert m.start.residual < 1e-12
        assert "base" not in "".join(m.start.changes)
    assert m.start.changes == ()
    assert place_of(m, "crank")[2] == pytest.approx(math.radians(100), abs=1e-12)


def test_given_places_go_before_that_of_a_base_on_springs():
    m = floating().initial("crank", x=0.3, y=0.2, angle="90 deg")
    np.testing.assert_allclose(place_of(m, "crank"), [0.3, 0.2, math.pi / 2], atol=1e-12)
    np.testing.assert_allclose(place_of(m, "base"), [0.3, 0.05, 0], atol=1e-12)  # level, below the crank's end
    m = floating().initial("base", x=1, y=2).initial("crank", angle=1)
    np.testing.assert_allclose(place_of(m, "base"), [1, 2, 0], atol=1e-12)


def test_a_body_on_springs_alone_that_given_angles_have_moved_is_named():
    m = floating().initial("crank", angle="30 deg").initial("rod", angle=0)
    for notes in (m.start.notes, m.simulate(1e-3).trust.notes):
        assert sum("closing the joints moved base to x = " in note for note in notes) == 1
    np.testing.assert_allclose(place_of(m, "base")[:2], 0.0, atol=1e-12)
    rod = -math.asin((0.1 + 0.1 * math.sin(math.radians(30))) / 0.4)
    assert not m.initial("base", x=0, y=0, angle=0).initial("rod", angle=rod).start.changes


def test_samples_derivatives_and_neighbours_begin_with_the_same_base():
    m = floating(mount="bushing").parameter("l", 0.4).set({"bodies.rod.length": "l"})
    m.initial("crank", angle="30 deg", omega=3).initial("base", vx=0, vy=0, omega=0)
    longer = m.neighbour({"l": 0.41})
    np.testing.assert_allclose(place_of(longer, "base"), (0.02, 0.03, 0.1), atol=1e-12)
    runs = m.many({"l": [0.4, 0.41]}, ["final(base.x)", "at(base.angle, 0)"], 0.02, rtol=1e-10, atol=1e-12)
    at = longer.simulate(0.02, t_eval=[0.02], rtol=1e-11, atol=1e-13)
    assert runs["final(base.x)"][1] == pytest.approx(at["base.x"][0], abs=1e-9)
    np.testing.assert_allclose(runs["at(base.angle, 0)"], 0.1, atol=1e-12)
    slope = m.sensitivity(["base.x", "slider.x"], ["l"], [0, 0.02])
    assert slope["d(base.x)/d(l)"][0] == pytest.approx(0.0, abs=1e-14)
    assert abs(slope["d(slider.x)/d(l)"][0]) > 0.5


def test_hinged_bodies_with_springs_and_those_that_hang_on_a_given_body_are_where_joints_place_them():
    door = rt.Mechanism().ground(O=[1, 1], A=[0, 0]).bar("door", "O", "E", length=1, mass=1)
    door.revolute("h", "ground.O", "door.O").load("s", "spring", connect=["ground.A", "door.E"], stiffness=100)
    np.testing.assert_allclose(door.start.q, [1.5, 1, 0], atol=1e-12)
    car = rt.Mechanism().ground(F=[1, 0]).body("chassis", points={"F": [1, 0]}, mass=500, inertia=100)
    car.body("arm", points={"C": [0, 0], "P": [0.3, 0]}, mass=20, inertia=1).revolute("j", "chassis.F", "arm.P")
    car.load("tyre", "spring", connect=["ground.F", "arm.C"], stiffness=1e5).initial("chassis", y=0.3)
    np.testing.assert_allclose(car.start.q, [0, 0.3, 0, 0.7, 0.3, 0], atol=1e-12)
    assert (door.start.notes, car.start.notes) == ((), ())


def test_load_whose_ends_coincide_at_rest_is_named_where_it_would_push_in_no_direction():
    m = rt.Mechanism().ground(O=[0, 0]).body("b", points={"P": [0, 0]}, mass=1, inertia=1)
    m.load("push", "spring", connect=["ground.O", "b.P"], stiffness=100, free_length=0.1)
    assert m.start.notes == (
        "the ends of load 'push' coincide at the start: its force has no direction, and nothing is exerted until they"
        " part; give places apart in [initial]",
    )
    assert m.start.notes[0] in str(m.check())
    assert m.set({"loads.push.free_length": 0}).start.notes == ()
    assert m.initial("b", vx=1).start.notes == ()


def test_shipped_starts_without_rough_values_say_nothing():
    assert [rt.example(name).start.notes for name in ("fourbar", "slider_crank", "squeezer", "toggle")] == [()] * 4


# ---------------------------------------------------------------- parallel cranks
@pytest.mark.parametrize("driven", [True, False])
@pytest.mark.parametrize("angle", [0.5, 2.0, -1.2])
@pytest.mark.parametrize(("count", "play"), [(3, (1, 2)), (4, (1, 2, 3)), (4, (1, 3)), (5, (1, 2, 3, 4))])
def test_parallel_cranks_on_massless_links_come_together_near_where_they_were_asked(count, play, angle, driven):
    m = cranks(count, play, angle, driven=driven)
    q = m.start.q
    assert m.start.residual < 1e-15
    np.testing.assert_allclose(q[5::3], angle, atol=0.02)  # a few times the play over the length of a crank
    shift = math.hypot(q[0] - 0.1 * math.cos(angle), q[1] - 0.1 * math.sin(angle))
    assert shift < 1e-3


@pytest.mark.parametrize("written", ["90", '"90"', "-90.0"])
def test_an_angle_of_many_turns_without_a_unit_is_asked_about(written):
    m = rt.loads(PENDULUM.replace("ANGLE", written))
    number = written.strip('"').removesuffix(".0")
    assert (
        m.start.notes[0] == f'initial.rod.angle = {number} is {number} rad; write "{number} deg" if degrees are meant'
    )
    assert m.start.notes[0] in str(m.check())


@pytest.mark.parametrize("written", ['"720 deg"', '"7 rad"', "6.2", '"2*pi + 1"'])
def test_angles_with_a_unit_or_within_one_turn_are_not_asked_about(written):
    m = rt.loads(PENDULUM.replace("ANGLE", written))
    assert "rad; write" not in " ".join(m.start.notes)


# ---------------------------------------------------------------- play that is closed, or a massless link
@pytest.mark.parametrize("name", sorted(rt.examples()))
def test_no_example_hears_of_its_start_however_its_play_is_taken(name):
    """What play leaves open moves by the play and takes the rates of the ideal mechanism: nobody wonders at that."""
    m = rt.example(name)
    for contact in ("", "ideal", "massless-link"):
        with suppress(rt.ModelError, rt.AssemblyError):  # no joint with play, or none that it suits
            notes = (m.with_contact(contact) if contact else m).start.notes
            assert not [note for note in notes if "asked for" in note]


@pytest.mark.parametrize("contact", ["ideal", "massless-link"])
def test_a_place_within_the_play_is_expected_and_one_beyond_it_is_said(contact):
    m = rt.example("slider_crank_play").set({"joints.B.contact": contact})
    assert not m.set({"initial.slider.x": "170.9 mm"}).start.notes
    (note,) = m.set({"initial.slider.x": "176 mm"}).start.notes
    assert note.startswith("asked for slider.x = 0.176 m, got 0.17")


def test_rates_that_play_leaves_free_but_that_do_not_go_together_are_said():
    """One loose pin leaves coupler and rocker one freedom: with the crank driven they turn alike here, not as given."""
    m = rt.example("fourbar").with_contact("ideal", "O4")
    (note,) = m.set({"initial.coupler.omega": 1, "initial.rocker.omega": 3}).start.notes
    assert note.startswith("asked for coupler.omega = 1 rad/s, got 2 rad/s; asked for rocker.omega = 3 rad/s, got 2")
    assert not m.ideal().start.notes  # nothing is free: all rates follow from the driver's
