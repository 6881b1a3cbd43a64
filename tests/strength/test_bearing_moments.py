"""Moments of bearings: stacks by hand, loops against balance in space."""

import math

import numpy as np
import pytest

import rattle as rt

FORCE = (30.0, -80.0)


def stacked(chain=False, length="", z=0.012):
    """A crank in a plane above its bearing, and with `chain` an arm on it, in the plane above; a force at the end."""
    arm = f"""
[bodies.arm]
bar = ["A", "C"]
length = 0.1
mass = 0
z = {2 * z}
[joints.A]
type = "revolute"
connect = ["crank.A", "arm.A"]
[drivers.elbow]
joint = "A"
angle = "0.4 + 0*t"
"""
    return f"""
format = 1
ground.points = {{ O = [0, 0] }}
[bodies.crank]
bar = ["O", "A"]
length = 0.2
mass = 0
z = {z}
[joints.O]
type = "revolute"
connect = ["ground.O", "crank.O"]
z = 0
{length}
[drivers.motor]
joint = "O"
angle = "0.6 + 0*t"
[loads.f]
type = "force"
at = "{"arm.C" if chain else "crank.A"}"
force = {list(FORCE)}
{arm if chain else ""}"""


def moments(text, joint="O", **options):
    return rt.loads(text).inverse_dynamics([0.0, 1.0]).bearing_moments(joint, **options)


def test_a_force_above_a_bearing_tilts_it():
    b = moments(stacked())
    assert (b.fx[0], b.fy[0]) == pytest.approx((-30.0, 80.0))
    assert (b.mx[0], b.my[0]) == pytest.approx((0.012 * -80, 0.012 * -30))
    assert b.determinate
    assert math.isnan(b.edge_load[0])


def test_two_storeys_tilt_the_lower_bearing_by_the_whole_height():
    lower, upper = (moments(stacked(chain=True), name) for name in "OA")
    assert (lower.mx[0], lower.my[0]) == pytest.approx((0.024 * -80, 0.024 * -30))
    assert (upper.mx[0], upper.my[0]) == pytest.approx((0.006 * -80, 0.006 * -30))  # half way between the planes


def test_a_bearing_with_a_length_has_an_edge_and_one_with_play_a_tilt():
    b = moments(stacked(length='length = "20 mm"'))
    force = math.hypot(*FORCE)
    assert b.edge_load[0] == pytest.approx(force / 2 + 0.012 * force / 0.02)
    assert b.tilt == 0.0
    text = stacked(length='length = "20 mm"\nclearance = "0.05 mm"').replace("mass = 0", "mass = 1")
    loose = rt.loads(text.replace('joint = "O"\n', 'body = "crank"\ncoordinate = "angle"\n'))
    assert loose.simulate(1e-4).bearing_moments("O").tilt == pytest.approx(2 * 0.05 / 20)


def test_a_bearing_in_the_plane_of_its_body_is_not_tilted():
    b = moments(stacked(z=0.0))
    assert np.abs([b.mx, b.my]).max() == pytest.approx(0.0, abs=1e-12)


# ---------------------------------------------------------------- loops
LOOP = """
format = 1
gravity = [0, -9.81]
ground.points = { A = [0, 0], D = [0.5, 0] }
bodies.crank = { bar = ["A", "B"], length = 0.12, mass = 1, z = 0.01 }
bodies.coupler = { bar = ["B", "C"], length = 0.45, mass = 2, z = 0.03 }
bodies.rocker = { bar = ["D", "C"], length = 0.4, mass = 3, z = -0.02 }
joints.A = { type = "revolute", connect = ["ground.A", "crank.A"], z = 0.002 }
joints.B = { type = "revolute", connect = ["crank.B", "coupler.B"] }
joints.C = { type = "revolute", connect = ["coupler.C", "rocker.C"] }
joints.D = { type = "revolute", connect = ["ground.D", "rocker.D"], z = 0 }
drivers.motor = { joint = "A", angle = "0.5 + 9*t" }
loads.f = { type = "force", at = "rocker.C", force = [50, 20] }
initial = { crank = { angle = 0.5 }, coupler = { angle = 0.5 }, rocker = { angle = 1.8 } }
"""
ENDS = {"A": ("ground", "crank"), "B": ("crank", "coupler"), "C": ("coupler", "rocker"), "D": ("ground", "rocker")}
HEIGHTS = {"A": 0.002, "B": 0.02, "C": 0.005, "D": 0.0}
PLANES = {"crank": 0.01, "coupler": 0.03, "rocker": -0.02}
MASSES = {"crank": (1, 0.12), "coupler": (2, 0.45), "rocker": (3, 0.4)}


def in_space(r, k, stiffness):
    """All forces and moments in space of four pins: balance of three bodies about the origin, least tilting energy.

    Unknown of each pin, on its second body: force (3), moment about x and y, and the torque of the motor about z.
    """
    places = {"A": np.array([0.0, 0.0]), "D": np.array([0.5, 0.0])}
    for name, body, sense in (("B", "crank", 1.0), ("C", "coupler", 1.0)):
        mass, length = MASSES[body]
        turn = r[f"{body}.angle"][k]
        centre = np.array([r[f"{body}.x"][k], r[f"{body}.y"][k]])
        places[name] = centre + sense * length / 2 * np.array([np.cos(turn), np.sin(turn)])
    bodies, pins = list(PLANES), list(ENDS)
    matrix, right = np.zeros((18, 21)), np.zeros(18)
    for n, pin in enumerate(pins):
        spot = np.array([*places[pin], HEIGHTS[pin]])
        for sense, body in zip((-1.0, 1.0), ENDS[pin], strict=True):
            if body == "ground":
                continue
            row = 6 * bodies.index(body)
            for axis in range(3):
                unit = np.eye(3)[axis]
                matrix[row : row + 3, 5 * n + axis] += sense * unit
                matrix[row + 3 : row + 6, 5 * n + axis] += sense * np.cross(spot, unit)
            matrix[row + 3, 5 * n + 3] += sense
            matrix[row + 4, 5 * n + 4] += sense
    matrix[5, 20] = 1.0  # the motor turns the crank
    for n, body in enumerate(bodies):
        mass, length = MASSES[body]
        centre = np.array([r[f"{body}.x"][k], r[f"{body}.y"][k], PLANES[body]])
        inertia = mass * np.array([r[f"{body}.ax"][k], r[f"{body}.ay"][k] + 9.81, 0.0])
        right[6 * n : 6 * n + 3] = inertia
        right[6 * n + 3 : 6 * n + 6] = np.cross(centre, inertia)
        right[6 * n + 5] += mass * length**2 / 12 * r[f"{body}.alpha"][k]
    force = np.array([50.0, 20.0, 0.0])
    right[12:15] -= force
    right[15:18] -= np.cross([*places["C"], PLANES["rocker"]], force)
    some, *_ = np.linalg.lstsq(matrix, right, rcond=None)
    assert np.abs(matrix @ some - right).max() < 1e-9 * np.abs(right).max()
    _, sizes, axes = np.linalg.svd(matrix)
    free = axes[(sizes > 1e-10 * sizes[0]).sum() :].T
    tilting = [5 * n + i for n in range(4) for i in (3, 4)]
    weight = np.repeat([1.0 / math.sqrt(stiffness.get(pin, 1.0)) for pin in pins], 2)[:, None]
    share, *_ = np.linalg.lstsq(weight * free[tilting], -weight[:, 0] * some[tilting], rcond=None)
    whole = (some + free @ share)[:20].reshape(4, 5)
    return dict(zip(pins, whole, strict=True))


@pytest.mark.parametrize("stiffness", [{}, {"A": 5.0, "B": 1.0, "C": 0.2, "D": 1.0}])
def test_bearings_in_a_loop_share_moments_as_the_least_energy_in_space_does(stiffness):
    r = rt.loads(LOOP).inverse_dynamics([0.01, 0.2, 0.5])
    for pin in ENDS:
        b = r.bearing_moments(pin, tilt_stiffness=stiffness)
        with pytest.raises(rt.InputError, match="state all"):
            r.bearing_moments(pin, tilt_stiffness={"A": 5.0})
        assert not b.determinate
        assert any("share" in remark for remark in b.remarks)
        for k in range(3):
            fx, fy, _, mx, my = in_space(r, k, stiffness)[pin]
            assert (b.fx[k], b.fy[k]) == pytest.approx((fx, fy), abs=1e-7)
            assert (b.mx[k], b.my[k]) == pytest.approx((mx, my), abs=1e-7)


def test_a_pin_that_hangs_on_a_loop_is_in_none():
    more = """bodies.tail = { bar = ["C", "E"], length = 0.1, mass = 1, z = 0.06 }
joints.T = { type = "revolute", connect = ["coupler.C", "tail.C"], z = 0.05 }
drivers.hang = { joint = "T", angle = "1 + 0*t" }
"""
    r = rt.loads(LOOP + more).inverse_dynamics([0.01, 0.2])
    b = r.bearing_moments("T")
    assert b.determinate
    assert b.mx == pytest.approx(-0.01 * b.fy)  # the pin is 10 mm below the plane of the tail
    assert b.my == pytest.approx(0.01 * b.fx)
    assert not r.bearing_moments("B").determinate


# ---------------------------------------------------------------- refusals
def test_what_is_no_bearing_is_refused():
    r = rt.example("gear_rattle").ideal().simulate(0.01)
    gear = next(name for name, form in r.geometry["joints"].items() if form["type"] == "gear")
    with pytest.raises(rt.InputError, match="is a gear"):
        r.bearing_moments(gear)
    with pytest.raises(rt.InputError, match="did you mean"):
        moments(stacked(), "Oo")
    with pytest.raises(rt.InputError, match="must be positive"):
        moments(stacked(), tilt_stiffness={"O": -1.0})


def test_a_body_that_nothing_holds_against_tipping_is_named():
    text = """
format = 1
ground.points = { O = [0, 0] }
bodies.a = { points = { P = [0, 0] }, mass = 1, inertia = 1 }
bodies.b = { points = { P = [0, 0] }, mass = 1, inertia = 1, z = "10 mm" }
joints.J = { type = "revolute", connect = ["a.P", "b.P"], z = 0 }
loads.f = { type = "force", at = "b.P", force = [5, 0] }
"""
    with pytest.raises(rt.InputError, match="against tipping"):
        rt.loads(text).simulate(0.1).bearing_moments("J")


def test_the_command_tells_the_moment_and_the_edge(tmp_path, monkeypatch):
    from click.testing import CliRunner

    from rattle.cli.main import main

    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.toml").write_text(stacked(length='length = "20 mm"'))
    run = CliRunner().invoke(main, ["bearing-moments", "m.toml", "--of", "O", "-o", "b.csv"])
    assert run.exit_code == 0, run.output
    assert "largest tilting moment" in run.output
    assert "largest load of an edge" in run.output
    assert (tmp_path / "b.csv").read_text().startswith("t,fx,fy,mx,my,edge_load")
