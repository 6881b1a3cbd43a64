"""Gears and racks: closed forms, Willis' equation over many turns, how they are put together, what is refused."""

import cmath
import math

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib import path

import rattle as rt
from moving_bodies import FIRST, SECOND, A, B, H, Path, body_at, rng_for
from rattle import registry
from rattle.drawings.forms.gear import DEPTH, FEWEST, ROOT
from rattle.jit import layout as at
from rattle.plots.sketch import draw_at

nojit = pytest.mark.nojit
FINE = {"rtol": 1e-11, "atol": 1e-13}
HEAD = "format = 1\n"


def body(name, points="C = [0, 0]", mass=1.0, inertia=1.0):
    return f"[bodies.{name}]\npoints = {{ {points} }}\nmass = {mass!r}\ninertia = {inertia!r}\n"


def joint(name, kind, a, b, more=""):
    return f'[joints.{name}]\ntype = "{kind}"\nconnect = ["{a}", "{b}"]\n{more}\n'


def wheel(name, inertia=1.0, at="O", points="C = [0, 0]", mass=1.0):
    """A body that turns about its mass centre on the ground."""
    return body(name, points, mass, inertia) + joint(f"{name}_pin", "revolute", f"ground.{at}", f"{name}.C")


def torque(on, value):
    return f'[loads.push_{on}]\ntype = "torque"\nbody = "{on}"\ntorque = {value}\n'


def driver(on, law):
    return f'[drivers.{on}_motor]\njoint = "{on}_pin"\nangle = "{law}"\n'


def model(*parts, ground="O = [0, 0]", initial="", head=""):
    return rt.loads(f"{HEAD}{head}[ground.points]\n{ground}\n" + "".join(parts) + f"[initial]\n{initial}\n")


def pair(radii="[0.02, 0.04]", distance="0.06", more="", initial="", law="3*t"):
    """Two wheels on the ground, the first one driven."""
    return model(
        wheel("one"), wheel("two", at="Q"), joint("mesh", "gear", "one.C", "two.C", f"radii = {radii}\n{more}"),
        driver("one", law), ground=f"O = [0, 0]\nQ = [{distance}, 0]", initial=initial,
    )  # fmt: skip


def planetary(planets=3, driven=False):
    """Sun of 20 mm, planets of 30 mm on a carrier in a fixed ring of 80 mm; 1 N m on the sun."""
    spots = [0.05 * cmath.exp(2j * math.pi * k / planets) for k in range(planets)]
    arms = ", ".join(f"Q{k} = [{one.real!r}, {one.imag!r}]" for k, one in enumerate(spots))
    parts = [wheel("sun", 2e-5), wheel("carrier", 4e-4, points=f"C = [0, 0], {arms}")]
    for k in range(planets):
        parts += [
            body(f"planet{k}", mass=0.2, inertia=1e-5),
            joint(f"Q{k}", "revolute", f"carrier.Q{k}", f"planet{k}.C"),
        ]
        parts.append(joint(f"inner{k}", "gear", "sun.C", f"planet{k}.C", "radii = [0.02, 0.03]"))
        parts.append(joint(f"outer{k}", "gear", "ground.O", f"planet{k}.C", "radii = [0.08, 0.03]\ninternal = true"))
    parts.append(driver("sun", "40*t + sin(9*t)") if driven else torque("sun", 1.0))
    return model(*parts, initial="sun = { angle = 0 }\ncarrier = { angle = 0 }")


# ---------------------------------------------------------------- the row
@pytest.mark.usefixtures("mode")
@pytest.mark.parametrize("internal", [0.0, 1.0])
def test_row_of_a_gear_is_differentiated_exactly_outside_and_inside_of_a_ring(internal):
    kind, path = registry.kinds("joint")["gear"], Path(rng_for("ring"))
    p = np.array([0.3, -0.2, 0.1, 0.4, 1.7, 0.6, internal, 0.0, 0.0, 0.2])

    def row(t, q=None):
        rows = np.zeros((1, at.width("rows")))
        kind.kernel(body_at(path.q(t) if q is None else q, path.v(t)), A, B, p, 0, 0, rows)
        return rows[0]

    t = 0.3
    here, ahead, behind = row(t), row(t + H), row(t - H)
    jacobian = np.concatenate([here[3:6], here[6:9]])
    rate = jacobian @ np.concatenate([path.v(t)[A], path.v(t)[B]])
    assert rate == pytest.approx((ahead[at.RES] - behind[at.RES]) / (2 * H), abs=FIRST)
    second = jacobian @ np.concatenate([path.dv(t)[A], path.dv(t)[B]]) - here[at.GAMMA]
    assert second == pytest.approx((ahead[at.RES] - 2 * here[at.RES] + behind[at.RES]) / H**2, abs=SECOND)


@nojit
@pytest.mark.parametrize("internal", [0.0, 1.0])
def test_whole_turns_of_the_line_of_centres_do_not_show_in_the_residual(internal):
    """A planet carried around as Willis says stays on its row, also where the direction goes from 180 to -180 deg."""
    kind = registry.kinds("joint")["gear"]
    ra, rb = 0.5, 0.2
    s, sign = (ra - rb, -1.0) if internal else (ra + rb, 1.0)
    for turned in np.linspace(-40.0, 40.0, 161):
        q = np.zeros((3, 3))
        q[A, 2] = 0.7 * turned
        q[B] = s * math.cos(turned), s * math.sin(turned), (s * turned - ra * q[A, 2]) / (sign * rb)
        for off in (-1e-9, 0.0, 1e-9):  # what corrections see on both sides
            moved = q.copy()
            moved[B, 2] += off
            rows = np.zeros((1, at.width("rows")))
            p = np.array([0.0, 0.0, 0.0, 0.0, ra, rb, internal, 0.0, 0.0, 0.0])
            kind.kernel(body_at(moved, np.zeros((3, 3))), A, B, p, 0, 0, rows)
            assert rows[0, at.RES] == pytest.approx(sign * rb * off, abs=2e-14)  # 40 rad have digits of 7e-15


# ---------------------------------------------------------------- trains
def test_planetary_starts_as_its_reduced_inertia_says_and_stays_with_willis():
    r = planetary().simulate(0.05, t_eval=np.linspace(0.0, 0.05, 6), **FINE)
    carrier, planet = 1 / 5, -1 / 3  # per turn of the sun: 20/(20 + 80), and (carrier - 20/30 (1 - carrier))
    assert planet == pytest.approx(carrier - 20 / 30 * (1 - carrier))
    reduced = 2e-5 + carrier**2 * (4e-4 + 3 * 0.2 * 0.05**2) + 3 * planet**2 * 1e-5
    for name, ratio in (("sun", 1.0), ("carrier", carrier), ("planet2", planet)):
        assert r[f"{name}.alpha"] == pytest.approx(np.full(6, ratio / reduced), rel=1e-9)
        assert r[f"{name}.angle"] == pytest.approx(ratio * 0.5 * r.t**2 / reduced, abs=1e-9)
    assert r["sun.angle"][-1] > 4 * math.pi  # two turns
    assert np.abs(r["energy.balance"]).max() < 1e-9 * r["energy.kinetic"].max()
    assert {f"{side}{k}" for side in ("inner", "outer") for k in range(3)} <= set(r.trust.nonunique)


def test_one_planet_shows_its_tooth_forces():
    r = planetary(1).simulate(0.001, t_eval=[0.0, 0.001], **FINE)
    assert r.trust.nonunique == ()
    sun, planet = r["sun.alpha"], r["planet0.alpha"]
    inner, outer = r["inner0.force"], r["outer0.force"]
    assert inner == pytest.approx((1.0 - 2e-5 * sun) / 0.02, rel=1e-9)  # what the sun does not keep of 1 N m
    assert inner - outer == pytest.approx(1e-5 * np.abs(planet) / 0.03, rel=1e-9)
    assert np.hypot(r["inner0.fx"], r["inner0.fy"]) == pytest.approx(inner)
    assert r["inner0.fx"][0] == pytest.approx(0.0, abs=1e-9)  # tangential: the line of centres is along x


def test_rates_of_a_driven_train_of_three_planets_are_those_of_willis_over_many_turns():
    m = planetary(driven=True)
    times = [0.0, 0.3, 4.0, 20.0]
    r = m.kinematics(times)
    for key in ("angle", "omega", "alpha"):
        assert r[f"carrier.{key}"] == pytest.approx(r[f"sun.{key}"] / 5, abs=1e-9)
        assert r[f"planet1.{key}"] == pytest.approx(-r[f"sun.{key}"] / 3, abs=1e-9)
    assert m.kinematics([20.0])["planet1.angle"] == pytest.approx(
        r["planet1.angle"][-1:], abs=1e-9
    )  # not by whole turns
    assert r["sun.angle"][-1] > 120 * 2 * math.pi


def test_cylinder_that_rolls_in_a_cylinder_is_a_pendulum_with_a_turning_mass():
    """From 60 deg: 3/2 m v^2/2 = m g (R - r)/2 at the lowest point; there after K(1/2)/w0, w0^2 = 2 g/(3 (R - r))."""
    w0, quarter = math.sqrt(2 * 9.81 / (3 * 0.25)), 1.6857503548125961
    bowl = model(
        body("roller", inertia=0.00125), joint("arm", "rod", "ground.O", "roller.C", "length = 0.25"),
        joint("mesh", "gear", "ground.O", "roller.C", "radii = [0.3, 0.05]\ninternal = true"),
        head="gravity = [0, -9.81]\n",
        initial=f"roller = {{ x = {0.25 * math.sin(math.pi / 3)!r}, y = -0.125, angle = 0 }}",
    )  # fmt: skip
    r = bowl.simulate(quarter / w0, t_eval=[0.0, quarter / w0], **FINE)
    assert r["roller.x"][1] == pytest.approx(0.0, abs=1e-10)
    assert r["roller.omega"][1] == pytest.approx(5 * w0, abs=1e-8)  # against its motion: v/r
    frequency = bowl.modes().frequency
    assert frequency == pytest.approx([w0 / (2 * math.pi)], rel=1e-6)


def test_rack_is_pushed_as_by_the_reduced_mass():
    r = model(
        body("rack", mass=3.0), joint("guide", "prismatic", "ground.O", "rack.C", "angle = 0"),
        wheel("pinion", 0.02, "Q"), joint("rail", "rack", "rack.C", "pinion.C", "radius = 0.1"), torque("pinion", 2.0),
        ground="O = [0, 0]\nQ = [0, -0.1]", initial="rack = { x = 0 }",
    ).simulate(0.1, t_eval=[0.0, 0.1], **FINE)  # fmt: skip
    assert r["rack.ax"] == pytest.approx([-4.0, -4.0], abs=1e-9)  # -T R/(J + m R^2): the top of the pinion goes to -x
    assert r["rail.force"] == pytest.approx([12.0, 12.0], abs=1e-9)
    assert r.trust.notes == ()


UNEVEN = "3*t + 0.2*sin(5*t)"  # leaves nothing out of the second derivatives


@pytest.mark.parametrize("kind", ["rack", "gear"])
def test_rates_beside_a_turning_body_are_derivatives(kind):
    if kind == "rack":  # its distance changes, which the row allows
        more, spot = "radius = 0.05", "0.1, 0.02"
        m = model(
            wheel("arm"), wheel("pinion", at="Q"), joint("rail", "rack", "arm.C", "pinion.C", more),
            driver("arm", UNEVEN),
            ground=f"O = [0, 0]\nQ = [{spot}]", initial="pinion = { angle = 0 }",
        )  # fmt: skip
    else:
        m = model(
            wheel("sun"), wheel("arm", points="C = [0, 0], Q = [0.05, 0]"), body("pinion"),
            joint("Q", "revolute", "arm.Q", "pinion.C"),
            joint("mesh", "gear", "sun.C", "pinion.C", "radii = [0.02, 0.03]"),
            driver("sun", "-2*t + 0.1*sin(7*t)"), driver("arm", UNEVEN), initial="pinion = { angle = 0 }",
        )  # fmt: skip
    weights = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
    h = 1e-3
    r = m.kinematics(0.7 + h * np.arange(-4, 5))
    assert weights @ r["pinion.angle"] / h == pytest.approx(r["pinion.omega"][4], abs=1e-9)
    assert weights @ r["pinion.omega"] / h == pytest.approx(r["pinion.alpha"][4], abs=1e-8)
    arm = r["arm.angle"]
    if kind == "rack":
        along = 0.1 * np.cos(arm) + 0.02 * np.sin(arm)  # of the pinion's centre, in the frame of the rack
        assert r["pinion.angle"] == pytest.approx(20 * (along - 0.1) + arm, abs=1e-10)
    else:
        assert r["pinion.angle"] == pytest.approx((5 * arm - 2 * r["sun.angle"]) / 3, abs=1e-10)


# ---------------------------------------------------------------- put together as the start stands
def test_gears_turn_on_from_the_angles_of_the_start():
    r = pair(initial='two = { angle = "20 deg" }', law="1 + 3*t").kinematics([0.0, 0.5])
    assert r["two.angle"] == pytest.approx(math.radians(20) - 0.5 * (r["one.angle"] - 1), abs=1e-12)
    ring = pair("[0.06, 0.02]", "0.04", "internal = true").kinematics([0.0, 0.5])
    assert ring["two.angle"] == pytest.approx(3 * ring["one.angle"], abs=1e-12)  # not given: as found, 0


@nojit
def test_start_keeps_angles_that_are_given_and_takes_the_rates_of_the_gears():
    start = pair(initial="two = { angle = 1.25, omega = 7 }").start
    assert start.q[[2, 5]] == pytest.approx([0.0, 1.25], abs=1e-14)
    assert start.v[[2, 5]] == pytest.approx([3.0, -1.5])
    assert "asked for two.omega" in start.notes[0]


@nojit
def test_another_start_puts_the_gears_together_anew():
    m = pair(initial="two = { angle = 1.25 }")
    n = m.set({"initial.two.angle": 0.5, "drivers.one_motor.angle": "2 + t"})
    one, two = (x.system.model.joints["mesh"].constants[0] for x in (m, n))
    assert one == pytest.approx(0.04 * 1.25, abs=1e-15)
    assert two == pytest.approx(0.02 * 2 + 0.04 * 0.5, abs=1e-15)
    assert "constants" not in m.to_toml()


@nojit
def test_pins_with_play_start_where_the_teeth_press_them_and_keep_the_angles_given():
    play = wheel("two", at="Q").replace('"two.C"]', '"two.C"]\nclearance = 1e-4\ncontact = "massless-link"')
    m = model(
        wheel("one"), play, joint("mesh", "gear", "one.C", "two.C", "radii = [0.02, 0.04]"), driver("one", "t**2"),
        ground="O = [0, 0]\nQ = [0.06, 0]", initial="two = { angle = 0.3 }",
    )  # fmt: skip
    assert m.start.residual < 1e-15
    assert m.start.q[5] == pytest.approx(0.3, abs=1e-9)
    # one turns on faster and faster: its teeth take two along, in +y on the side of one, the pin presses in +y
    assert m.start.q[3:5] == pytest.approx([0.06, 1e-4], abs=1e-9)


# ---------------------------------------------------------------- what is refused, and what is said
@nojit
@pytest.mark.parametrize(
    ("radii", "more", "words"),
    [
        (
            "[0.02, 0.03]",
            "",
            r"'mesh': .*0\.02 m and 0\.03 m need a distance of the centres of 0\.05 m.* it is 0\.06 m",
        ),
        ("[0.02, 0.0400001]", "", r"0\.0600001 m, at the start it is 0\.06 m"),
        ("[0.09, 0.02]", "internal = true", r"of 0\.07 m, at the start it is 0\.06 m"),
    ],
)
def test_centres_that_do_not_fit_the_radii_are_an_error_with_both_numbers(radii, more, words):
    with pytest.raises(rt.AssemblyError, match=words):
        _ = pair(radii, more=more).start


@nojit
@pytest.mark.parametrize(
    ("radii", "more", "words"),
    [
        ("[0.02, 0.04]", "internal = true", r"the wheel inside, 0\.04 m, must be smaller than its ring, 0\.02 m"),
        ("[0.04, 0.04]", "internal = true", r"must be smaller than its ring"),
        ("[0, 0.04]", "", r"must be positive"),
        ("[0.02, -0.04]", "", r"must be positive"),
        ("0.02", "", r"expected \[x, y\]"),
        ("[0.02, 0.04]", 'internal = "yes"', r"expected true or false, got 'yes'"),
        ("[0.02, 0.04]", "pressure_angle = 0.3", r"pressure_angle"),
        ("[0.02, 0.04]", "clearance = 1e-4", r"a gear joint cannot have clearance"),
    ],
)
def test_gears_that_cannot_be_are_refused(radii, more, words):
    with pytest.raises(rt.ModelError, match=words):
        _ = pair(radii, more=more).model


@nojit
def test_a_gear_needs_two_bodies_and_no_motor():
    with pytest.raises(rt.ModelError, match="both ends are on 'one'"):
        _ = model(
            wheel("one", points="C = [0, 0], P = [0.06, 0]"), joint("mesh", "gear", "one.C", "one.P", "radii = [1, 2]")
        ).model
    with pytest.raises(rt.ModelError, match="a gear joint has nothing to drive"):
        _ = pair().set({"drivers.one_motor.joint": "mesh"}).model
    with pytest.raises(rt.ModelError, match="must be positive"):
        _ = model(wheel("one"), joint("rail", "rack", "ground.O", "one.C", "radius = 0")).model


def test_centres_that_move_apart_are_noted():
    """A wheel on a driven slide leaves the other one."""
    m = model(
        wheel("one"), body("two"), joint("guide", "slot", "ground.O", "two.C"), driver("one", "t"),
        '[drivers.pull]\njoint = "guide"\nposition = "0.06 + 0.001*t"\n',
        joint("mesh", "gear", "one.C", "two.C", "radii = [0.02, 0.04]"), initial="two = { x = 0.06 }",
    )  # fmt: skip
    (note,) = m.kinematics([0.0, 1.0, 2.0]).trust.notes
    assert "need a distance of the centres of 0.06 m; it is 0.062 m at t = 2 s" in note
    assert m.kinematics([0.0]).trust.notes == ()


@nojit
def test_wheel_on_the_wrong_side_of_its_road_is_noted():
    def cart(axis):
        return model(
            body("cart"), joint("guide", "prismatic", "ground.G", "cart.C"), body("wheel"),
            joint("axle", "revolute", "cart.C", "wheel.C"),
            joint("road", "rack", "ground.O", "wheel.C", f'radius = 0.1\naxis = "{axis} deg"'),
            ground="O = [0, 0]\nG = [0, 0.1]", initial="cart = { vx = 2 }",
        )  # fmt: skip

    assert cart(180).check().start == ()
    assert cart(180).start.v[5] == pytest.approx(-20.0)  # it rolls to the right
    (note,) = cart(0).check().start
    assert "needs a distance of the pinion's centre from the line, to the right along `axis`, of 0.1 m" in note
    assert "it is -0.1 m" in note


@nojit
def test_check_counts_the_meshes_that_only_share_the_load():
    found = planetary().check()
    assert (found.mobility, found.redundant) == (1, 2)
    assert {"inner0", "outer2"} <= set(found.redundant_joints)
    one = planetary(1).check()
    assert (one.mobility, one.redundant) == (1, 0)


@nojit
def test_check_follows_a_gear_that_turns_much_faster_than_its_driver():
    m = pair("[0.3, 0.01]", "0.31", law="t")  # thirty times: 150 deg for 5 deg of the driver
    assert m.check().reach == ("one_motor can turn fully",)


# ---------------------------------------------------------------- pictures
@pytest.fixture
def ax():
    figure, ax = plt.subplots()
    yield ax
    plt.close(figure)


@nojit
def test_pitch_circles_are_drawn_to_scale_each_once_and_their_spokes_turn(ax):
    r = planetary(2).simulate(0.03, t_eval=[0.0, 0.03], method="rk4", step=0.01)
    draw_at(ax, r, 1)
    lines = [line.get_xydata() for line in ax.lines if line.get_zorder() == 2.0]
    wheels = [one for one in lines if len(one) > 4 * FEWEST]
    teeth = [one for one in wheels if len(one) != 98]  # the other is the rim of the ring
    assert len(teeth) == 4  # sun, two planets, the ring once for both
    depth = DEPTH * 2.0 * math.pi * 0.02 / FEWEST
    tips = sorted(np.hypot(*(one[:-1] - one[:-1].mean(axis=0)).T).max() for one in teeth)
    assert tips == pytest.approx([0.02 + depth, 0.03 + depth, 0.03 + depth, 0.08 + ROOT / DEPTH * depth])
    spokes = [line.get_xydata() for line in ax.lines if len(line.get_xdata()) == 2]
    (sun,) = [one for one in spokes if np.allclose(one[0], 0.0) and np.hypot(*one[1]) == pytest.approx(0.8 * 0.02)]
    assert math.atan2(sun[1, 1], sun[1, 0]) == pytest.approx(math.remainder(r["sun.angle"][1], 2 * math.pi), abs=1e-9)
    assert ax.get_xlim()[1] > 0.08


@nojit
def test_gears_that_do_not_fit_are_drawn_with_what_is_wrong():
    ax = pair("[0.02, 0.03]").plot().axes[0]
    said = " ".join(" ".join(text.get_text().split()) for text in (*ax.texts, *ax.figure.texts))
    assert "need a distance of the centres of 0.05 m" in said
    wheels = [line.get_xdata() for line in ax.lines if line.get_zorder() == 2.0 and len(line.get_xdata()) > 4 * FEWEST]
    pitch = 2.0 * math.pi * 0.02 / FEWEST
    assert [float(np.ptp(x)) for x in wheels] == pytest.approx(
        [0.04 + 2 * DEPTH * pitch, 0.06 + 2 * DEPTH * pitch], 0.01
    )


@nojit
def test_rack_is_drawn_along_its_line_with_teeth_in_the_gaps_of_its_pinion(ax):
    m = model(
        wheel("pinion", at="Q"), joint("rail", "rack", "ground.O", "pinion.C", "radius = 0.1"),
        ground="O = [0, 0]\nQ = [0.3, -0.1]",
    )  # fmt: skip
    draw_at(ax, m.equilibrium()[0].result, 0)
    (line,) = [line.get_xydata() for line in ax.lines if line.get_zorder() == 1.8]
    pinion = max((line.get_xydata() for line in ax.lines if line.get_zorder() == 2.0), key=len)
    assert line[:, 0].min() < 0.2 < 0.4 < line[:, 0].max()
    depth = DEPTH * 2 * math.pi * 0.1 / FEWEST
    assert line[:, 1].min() == pytest.approx(-depth)  # towards the pinion, which is below
    inside = path.Path(pinion).contains_points(line)
    assert not inside.any()


# ---------------------------------------------------------------- recorded models: the constant follows from the start
TRAIN = """
[parameters]
rs = 0.02
rp = 0.03
begin = 0.4
tilt = 0.2
push = 0.8
[bodies.sun]
points = { C = [0, 0] }
mass = 1
inertia = 2e-4
[bodies.arm]
points = { C = [0, 0], Q = ["rs + rp", 0] }
mass = 1
inertia = 1e-3
[bodies.planet]
points = { C = [0, 0], P = [0.01, 0] }
mass = 0.3
inertia = 1e-4
[joints]
sun_pin = { type = "revolute", connect = ["ground.O", "sun.C"] }
arm_pin = { type = "revolute", connect = ["ground.O", "arm.C"] }
Q = { type = "revolute", connect = ["arm.Q", "planet.C"] }
mesh = { type = "gear", connect = ["sun.C", "planet.C"], radii = ["rs", "rp"] }
"""
LOADS = """
[loads.push]
type = "torque"
body = "sun"
torque = "push - 0.1*sun.angle"
[loads.drag]
type = "force"
at = "planet.P"
force = [0.5, "-0.2*planet.angle"]
"""
DRIVES = """
[drivers.turn]
joint = "sun_pin"
angle = "begin + 5*t"
[drivers.lead]
joint = "arm_pin"
angle = "tilt + sin(3*t)"
"""


def train(more):
    return model(TRAIN, more, initial='sun = { angle = "begin" }\narm = { angle = "tilt" }')


def test_samples_side_by_side_are_put_together_each_from_its_own_start():
    m, rng = train(LOADS), np.random.default_rng(1)
    samples = {
        name: m.model.parameters[name].value * rng.uniform(0.9, 1.1, 4) for name in ("rs", "rp", "begin", "tilt")
    }
    found = m.many(samples, ["final(planet.angle)", "at(mesh.force, 0.02)"], 0.05)
    assert not len(found.generic)
    for n in range(4):
        one = m.set({name: float(values[n]) for name, values in samples.items()})
        r = one.simulate(0.05, t_eval=[0.0, 0.02, 0.05], rtol=1e-10)
        assert found["final(planet.angle)"][n] == pytest.approx(r["planet.angle"][-1], abs=1e-8)
        assert found["at(mesh.force, 0.02)"][n] == pytest.approx(r["mesh.force"][1], rel=1e-7)


def test_derivatives_of_a_motion_know_that_another_start_meshes_other_teeth():
    m, times = train(LOADS), [0.0, 0.05]
    s = m.sensitivity(["planet.angle", "mesh.force"], ["rs", "tilt"], times)
    for name, h in (("rs", 1e-6), ("tilt", 1e-4)):
        value = m.model.parameters[name].value
        ahead, behind = (m.set({name: value + way}).simulate(t_eval=times, **FINE) for way in (h, -h))
        for curve in ("planet.angle", "mesh.force"):
            slope = (ahead[curve] - behind[curve]) / (2 * h)
            # differences: errors of 1e-11 over h, and h^2 times a third derivative
            assert s[f"d({curve})/d({name})"] == pytest.approx(slope, rel=1e-6, abs=1e-6)


def test_derivatives_of_a_driven_train_are_those_of_willis():
    """planet = ((rs + rp) (arm - tilt) - rs (sun - begin))/rp, as all three start from where they were put together."""
    m, times = train(DRIVES), np.array([0.0, 0.4, 2.0])
    s = m.sensitivity(["planet.angle"], ["rs", "rp", "begin", "tilt"], times, "kinematics")
    arm, sun, rs, rp = np.sin(3 * times), 5 * times, 0.02, 0.03
    assert s["planet.angle"] == pytest.approx(((rs + rp) * arm - rs * sun) / rp, abs=1e-12)
    assert s["d(planet.angle)/d(rs)"] == pytest.approx((arm - sun) / rp, abs=1e-9)
    assert s["d(planet.angle)/d(rp)"] == pytest.approx(-(arm - sun) * rs / rp**2, abs=1e-9)
    for name in ("begin", "tilt"):
        assert s[f"d(planet.angle)/d({name})"] == pytest.approx(np.zeros(3), abs=1e-9)


def test_derivatives_of_an_equilibrium_of_a_train_know_where_it_was_put_together():
    """Springs bring the sun to push/2 and the arm to 0; the planet, without a load of its own, follows by Willis."""
    springs = '[loads.{0}]\ntype = "torque"\nbody = "{0}"\ntorque = "{1} - 2*{0}.angle"\n'
    m = train(springs.format("sun", "push") + springs.format("arm", "0"))
    s = m.sensitivity(["planet.angle"], ["rs", "begin", "tilt", "push"], analysis="equilibrium")
    rs, rp, begin, tilt, push = 0.02, 0.03, 0.4, 0.2, 0.8
    assert s["planet.angle"][0] == pytest.approx((-(rs + rp) * tilt - rs * (push / 2 - begin)) / rp, abs=1e-9)
    wanted = {"rs": (-tilt - push / 2 + begin) / rp, "begin": rs / rp, "tilt": -(rs + rp) / rp, "push": -rs / 2 / rp}
    assert {name: s[f"d(planet.angle)/d({name})"][0] for name in wanted} == pytest.approx(wanted, abs=1e-7)
