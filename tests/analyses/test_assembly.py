"""Putting together: what is given is kept, what is not given is found, and what cannot be is said."""

import math
from pathlib import Path

import numpy as np
import pytest

import rattle as rt
from rattle.analyses.assembly import without_play
from rattle.analyses.assembly.assembly import assemble
from rattle.analyses.assembly.rank import independent, left_null
from rattle.equations.closure import open_by
from rattle.equations.dense import LARGE, dense_rows

pytestmark = pytest.mark.nojit

TEXT = (Path(__file__).parents[1] / "data" / "full.toml").read_text()
PLAIN = TEXT[: TEXT.index("[loads.back]")] + TEXT[TEXT.index("[initial]") :]  # the paper's four-bar alone


def angle(m, body):
    return m.start.q[3 * m.system.bodies.index(body) + 2]


def rate(m, body):
    return m.start.v[3 * m.system.bodies.index(body) + 2]


def point(m, body, name):
    """Place of a body's point at the start [m]."""
    x, y, phi = m.start.q[3 * m.system.bodies.index(body) :][:3]
    px, py = m.model.bodies[body].points[name]
    return np.array([x + math.cos(phi) * px - math.sin(phi) * py, y + math.sin(phi) * px + math.cos(phi) * py])


def four_bar(crank=0.1, coupler=0.3, rocker=0.25, ground=0.3, mass=(1, 1, 1)):
    m = rt.Mechanism("four-bar").ground(A=[0, 0], D=[ground, 0])
    m.bar("crank", "A", "B", length=crank, mass=mass[0]).bar("coupler", "B", "C", length=coupler, mass=mass[1])
    m.bar("rocker", "C", "D", length=rocker, mass=mass[2])
    m.revolute("A", "ground.A", "crank.A").revolute("B", "crank.B", "coupler.B")
    return m.revolute("C", "coupler.C", "rocker.C").revolute("D", "rocker.D", "ground.D")


def pendulum(links, **fields):
    m = rt.Mechanism("chain", gravity=[0, -9.81]).ground(P0=[0, 0])
    for n in range(links):
        m.bar(f"b{n}", f"P{n}", f"P{n + 1}", length=0.5, mass=1)
        m.revolute(f"J{n}", f"b{n - 1}.P{n}" if n else "ground.P0", f"b{n}.P{n}", **fields)
    return m


# ---------------------------------------------------------------- positions
def test_angles_given_are_held_and_the_joints_place_the_rest():
    m = pendulum(3).initial("b0", angle=0.3).initial("b1", angle=-1.2).initial("b2", angle=9.0)
    assert [angle(m, f"b{n}") for n in range(3)] == [0.3, -1.2, 9.0]  # never wrapped
    end = 0.5 * sum(np.array([math.cos(a), math.sin(a)]) for a in (0.3, -1.2, 9.0))
    np.testing.assert_allclose(point(m, "b2", "P3"), end, atol=1e-15)


def test_the_papers_start_is_taken_as_it_stands():
    m = rt.loads(PLAIN)
    alpha = math.radians(60)
    assert angle(m, "coupler") == pytest.approx(alpha, abs=1e-14)
    assert angle(m, "rocker") == pytest.approx(-alpha, abs=1e-14)
    np.testing.assert_allclose(point(m, "rocker", "O3") - point(m, "coupler", "O3"), [0.005, 0], atol=1e-15)


def test_angles_that_do_not_close_change_least_by_mass():
    """The change is that of the equations of motion at rest under joint forces: M dq in the span of the rows."""
    closed = four_bar(mass=(1, 5, 0.2)).initial("crank", angle=1.0).initial("coupler", angle=0.3)
    q0 = closed.start.q
    m = four_bar(mass=(1, 5, 0.2))
    for n, body in enumerate(("crank", "coupler", "rocker")):
        x, y, phi = q0[3 * n : 3 * n + 3] + 1e-4 * np.array([1, -2, 3]) * (n + 1)
        m.initial(body, x=x, y=y, angle=phi)
    start = np.array([v for one in m.model.initial.bodies.values() for v in one.values()])
    change = (m.start.q - start) * m.system.arrays["mass"][1:].ravel()
    workspace = m.system.workspace()
    open_by(workspace, 0.0, m.start.q, m.start.v)
    rows = dense_rows(m.system, workspace)
    free = np.linalg.svd(rows)[2][np.linalg.matrix_rank(rows) :]
    assert np.abs(change).max() > 1e-4
    assert np.abs(free @ change).max() < 1e-3 * np.abs(change).max()  # second order in the change


def test_branch_is_that_of_the_angles_given():
    up = four_bar().initial("crank", angle=1.0).initial("coupler", angle=0.5).initial("rocker", angle=-1.0)
    down = four_bar().initial("crank", angle=1.0).initial("coupler", angle=-0.9).initial("rocker", angle=1.5)
    assert point(up, "coupler", "C")[1] > 0 > point(down, "coupler", "C")[1]


@pytest.mark.parametrize("crank", [0.4, 2.0, 3.6, 5.5])
def test_angles_nobody_gave_are_found(crank):
    m = four_bar().driver("motor", "A", angle=crank)
    C = point(m, "coupler", "C")
    B = 0.1 * np.array([math.cos(crank), math.sin(crank)])
    assert np.hypot(*(C - B)) == pytest.approx(0.3, abs=1e-12)
    assert np.hypot(*(C - [0.3, 0])) == pytest.approx(0.25, abs=1e-12)


def test_position_follows_the_driver_to_any_time():
    m = four_bar().driver("motor", "A", angle="1 + 2*t")
    later = assemble(m.system, 0.7)
    assert later.q[2] == pytest.approx(2.4, abs=1e-12)
    assert later.v[2] == pytest.approx(2.0, abs=1e-12)
    assert later.residual < 1e-13


def test_long_chain_is_put_together_like_a_short_one():
    m = pendulum(LARGE)
    for n in range(LARGE):
        m.initial(f"b{n}", angle=0.01 * n)
    assert m.start.residual < 1e-11
    end = 0.5 * sum(np.array([math.cos(0.01 * n), math.sin(0.01 * n)]) for n in range(LARGE))
    np.testing.assert_allclose(point(m, f"b{LARGE - 1}", f"P{LARGE}"), end, atol=1e-10)


# ---------------------------------------------------------------- what cannot be
@pytest.mark.machine
def test_links_too_short_name_the_loop_and_the_gap():
    with pytest.raises(rt.AssemblyError) as caught:
        _ = four_bar(ground=0.8).start
    message = str(caught.value)
    assert "stays open by 0.15 m" in message  # 0.8 - (0.1 + 0.3 + 0.25)
    for joint in "ABCD":
        assert f"-{joint}-" in message
    assert "ground" in message
    assert "coupler" in message


@pytest.mark.machine
def test_impossible_driver_angle_is_told_with_its_value():
    m = four_bar(crank=0.3, coupler=0.1, rocker=0.25, ground=0.3).driver("motor", "A", angle="170 deg")
    with pytest.raises(rt.AssemblyError, match=r"motor = 170 deg"):
        _ = m.start


@pytest.mark.machine
def test_only_the_loop_that_is_open_is_named():
    m = four_bar().initial("crank", angle=1.0)
    m.ground(E=[5, 0]).bar("link", "C", "E", length=1, mass=1)
    m.revolute("E1", "coupler.C", "link.C").revolute("E2", "link.E", "ground.E")
    with pytest.raises(rt.AssemblyError) as caught:
        _ = m.start
    assert "link" in str(caught.value)


# ---------------------------------------------------------------- clearances
@pytest.mark.nojit
def test_offset_along_a_slot_or_guide_is_refused_and_across_it_is_kept():
    """Only the part across is play: along its line the pin goes where the drivers and the bodies put it."""
    yoke, guide = rt.example("scotch_yoke"), rt.example("guide_play")
    across = yoke.set({"initial.slot.offset": [-4e-5, 1e-7]})  # off by 0.1 deg
    t = across.start
    assert t.q[0] + 0.05 * math.cos(t.q[2]) - t.q[3] == pytest.approx(-4e-5, rel=1e-9)
    with pytest.raises(rt.AssemblyError, match=r"'slot' .* 4e-05 m along the slot, which points to 90 deg"):
        _ = yoke.set({"initial.slot.offset": [0, 4e-5]}).start
    with pytest.raises(rt.AssemblyError, match=r"'guide' .* along the guide, .*; place the block along it"):
        _ = guide.set({"initial.guide.offset": ["1e-4", 0]}).start


def test_pin_offsets_not_given_press_along_the_ideal_reactions():
    text = PLAIN[: PLAIN.index("O3 = { offset")] + PLAIN[PLAIN.index("[simulate]") :]
    m = rt.loads(text.replace(", omega = 0 }", " }"))
    ideal = m.ideal().simulate(1e-3, t_eval=[0.0])
    r = m.simulate(1e-3, t_eval=[0.0])
    for joint in ("O3", "O4"):
        e = np.array([r[f"{joint}.ex"][0], r[f"{joint}.ey"][0]])
        force = np.array([ideal[f"{joint}.fx"][0], ideal[f"{joint}.fy"][0]])
        assert np.hypot(*e) == pytest.approx(0.005, rel=1e-9)
        # the force on the pin points back to the bush centre; the loop turns a little when the pins move by r
        assert e @ force / (0.005 * np.hypot(*force)) == pytest.approx(-1.0, abs=1e-3)
        assert r[f"{joint}.normal"][0] > 0.0


def test_offset_given_has_its_direction_and_the_length_of_the_clearance():
    r = rt.loads(PLAIN).simulate(1e-3, t_eval=[0.0])
    for joint in ("O3", "O4"):
        np.testing.assert_allclose([r[f"{joint}.ex"][0], r[f"{joint}.ey"][0]], [0.005, 0.0], atol=1e-14)


# ---------------------------------------------------------------- rates
def test_rates_given_are_kept():
    m = rt.loads(PLAIN)
    assert rate(m, "coupler") == pytest.approx(0.0, abs=1e-12)
    assert rate(m, "rocker") == pytest.approx(0.0, abs=1e-12)
    assert rate(m, "crank") == pytest.approx(10.0, abs=1e-12)


def test_rates_not_given_are_those_of_the_ideal_mechanism():
    m = rt.loads(PLAIN.replace(", omega = 0 }", " }"))
    ideal = rt.loads(PLAIN.replace(", omega = 0 }", " }")).ideal()
    # crank along x at 10 rad/s: 0.2 * 10 = v_y of O2; both other links turn by the same amount
    assert rate(ideal, "coupler") == pytest.approx(-10 / 3, rel=0.02)
    assert rate(m, "coupler") == pytest.approx(rate(ideal, "coupler"), abs=1e-9)
    assert rate(m, "rocker") == pytest.approx(rate(ideal, "rocker"), abs=1e-9)


def test_one_rate_of_a_linkage_makes_the_others():
    m = four_bar().initial("crank", angle=1.0).initial("coupler", angle=0.5).initial("rocker", angle=-1, omega=2.0)
    assert rate(m, "rocker") == pytest.approx(2.0, rel=1e-5)
    workspace = m.system.workspace()
    open_by(workspace, 0.0, m.start.q, m.start.v)
    assert np.abs(dense_rows(m.system, workspace) @ m.start.v).max() < 1e-12


def test_rates_of_an_open_chain_are_free():
    m = pendulum(2).initial("b0", angle=-1.0, omega=3.0).initial("b1", angle=0.2, omega=-2.0)
    assert [rate(m, "b0"), rate(m, "b1")] == pytest.approx([3.0, -2.0], abs=1e-12)
    assert m.start.v[0] == pytest.approx(3.0 * 0.25 * math.sin(1.0))  # -w r sin(phi)


# ---------------------------------------------------------------- mobility
def parallelogram():
    m = rt.Mechanism("three cranks").ground(A=[0, 0], B=[1, 0], C=[2, 0])
    m.body("beam", mass=1, inertia=1, points={"A": [0, 0], "B": [1, 0], "C": [2, 0]})
    for name in "ABC":
        m.bar(f"crank{name}", "O", name, length=0.3, mass=1).initial(f"crank{name}", angle=1.0)
        m.revolute(f"low{name}", f"ground.{name}", f"crank{name}.O")
        m.revolute(f"top{name}", f"crank{name}.{name}", f"beam.{name}")
    return m


def slider():
    m = rt.Mechanism("slider-crank").ground(O=[0, 0])
    m.bar("crank", "O", "A", length=0.1, mass=1).bar("rod", "A", "B", length=0.3, mass=1)
    m.body("slider", mass=1, inertia=1, points={"B": [0, 0]}).initial("crank", angle=1.0)
    m.revolute("O", "ground.O", "crank.O").revolute("A", "crank.A", "rod.A").revolute("B", "rod.B", "slider.B")
    return m.prismatic("guide", "ground.O", "slider.B")


@pytest.mark.parametrize(
    ("make", "mobility", "redundant"),
    [
        (lambda: rt.Mechanism().body("free", mass=1, inertia=1, points={}), 3, 0),
        (lambda: pendulum(1), 1, 0),
        (lambda: pendulum(4), 4, 0),
        (lambda: four_bar().initial("crank", angle=1.0), 1, 0),
        (lambda: four_bar().driver("motor", "A", angle="1 + t"), 0, 0),
        (slider, 1, 0),
        (parallelogram, 1, 1),
        (lambda: rt.loads(PLAIN), 2, 0),
    ],
    ids=["free", "pendulum", "chain", "four-bar", "driven", "slider", "parallelogram", "paper"],
)
def test_mobility_and_redundancy_are_counted(make, mobility, redundant):
    report = make().check()
    assert (report.mobility, report.redundant) == (mobility, redundant)


def test_joints_of_a_redundant_mechanism_are_named():
    report = parallelogram().check()
    assert set(report.redundant_joints) >= {"lowA", "topB", "lowC"}
    assert "not unique" in str(report)


def test_two_drivers_for_two_freedoms_are_no_problem():
    m = pendulum(2).driver("one", "J0", angle="1 + t").driver("two", "J1", angle="0.5*sin(t)")
    assert m.check().mobility == 0


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        (
            "slider_crank_play",
            [{"c": "0.2 mm"}, {"speed": 100.0}, {"initial.B.offset": [1e-4, 0]}],
        ),
        ("slider_crank", [{"c": "0.2 mm"}, {"rod_length": 0.13}, {"speed": 100.0}]),  # pins along reactions
    ],
)
def test_a_start_is_the_same_whatever_was_assembled_before(name, changes, monkeypatch):
    models = [rt.example(name), *(rt.example(name).set(one) for one in changes)]
    alone = []
    for m in models:
        monkeypatch.setattr(without_play, "_kept", ())
        alone.append(assemble(m.system))
    for first in range(len(models)):
        monkeypatch.setattr(without_play, "_kept", ())
        for k in range(len(models)):
            n = (first + k) % len(models)
            made = assemble(models[n].system)
            np.testing.assert_array_equal(made.q, alone[n].q)
            np.testing.assert_array_equal(made.v, alone[n].v)
    assert len({one.q.tobytes() + one.v.tobytes() for one in alone}) > 2


def test_rows_are_called_independent_where_their_singular_values_say_so():
    def seen(m):
        workspace = m.system.workspace()
        open_by(workspace, 0.0, m.start.q, m.start.v)
        return independent(workspace), left_null(m.system, workspace).shape[1] == 0

    for name in rt.examples():
        alone = name != "planetary"  # its three planets share the load
        assert seen(rt.example(name)) == (alone, alone), name
    twice = rt.example("fourbar")
    twice.revolute("again", "ground.O1", "crank.O1")
    assert seen(twice) == (False, False)
