"""Cams with a roller and with a flat face: closed forms, rates, tables, any number of turns, what is refused."""

import math
import re

import matplotlib.pyplot as plt
import numpy as np
import pytest

import rattle as rt
from rattle.plots.sketch import draw_at

nojit = pytest.mark.nojit
FINE = {"rtol": 1e-11, "atol": 1e-13}
UNEVEN = "3*t + 0.2*sin(5*t)"
POLAR = "0.04 + 0.01*cos(2*a)"
FACE = "0.05 + 0.01*cos(2*x)"


def body(name, points="C = [0, 0]", mass=1.0, inertia=1.0, center="[0, 0]"):
    return f"[bodies.{name}]\npoints = {{ {points} }}\ncenter = {center}\nmass = {mass!r}\ninertia = {inertia!r}\n"


def joint(name, kind, a, b, more=""):
    return f'[joints.{name}]\ntype = "{kind}"\nconnect = ["{a}", "{b}"]\n{more}\n'


def wheel(name, at="O", points="C = [0, 0]", inertia=1.0):
    return body(name, points, 1.0, inertia) + joint(f"{name}_pin", "revolute", f"ground.{at}", f"{name}.C")


def driver(on, law):
    return f'[drivers.{on}_motor]\njoint = "{on}_pin"\nangle = "{law}"\n'


def model(*parts, ground="O = [0, 0]", initial="", head="", g=0.0):
    text = f"format = 1\ngravity = [0, {-g}]\n{head}\n[ground.points]\n{ground}\n"
    return rt.loads(text + "".join(parts) + f"[initial]\n{initial}\n")


def roller(radius=POLAR, law=UNEVEN, start=150, more="", **head):
    """A driven disc and an arm whose end follows its curve."""
    return model(
        wheel("disc"), wheel("arm", "Q", "C = [0, 0], P = [0.09, 0]"),
        joint("cam", "cam", "disc.C", "arm.P", f'radius = "{radius}"\n{more}'), driver("disc", law),
        ground="O = [0, 0]\nQ = [0.1, 0]", initial=f'arm = {{ angle = "{start} deg" }}', **head,
    )  # fmt: skip


def face(support=FACE, law=UNEVEN, more="", **head):
    """A driven disc and an arm whose flat upper side follows it."""
    return model(
        wheel("disc"), wheel("arm", "Q"),
        joint("cam", "flat-follower", "disc.C", "arm.C", f'axis = "90 deg"\nsupport = "{support}"\n{more}'),
        driver("disc", law), ground="O = [0, 0]\nQ = [0.1, 0]", initial='arm = { angle = "-30 deg" }', **head,
    )  # fmt: skip


# ---------------------------------------------------------------- where they are and how they move
@nojit
def test_point_stays_on_the_polar_curve_and_the_face_touches_the_cam_over_many_turns():
    t = [0.0, 0.3, 1.1, 20.0]
    r = roller().kinematics(t)
    x, y = r["arm.P.x"], r["arm.P.y"]
    a = np.arctan2(y, x) - r["disc.angle"]
    assert np.hypot(x, y) == pytest.approx(0.04 + 0.01 * np.cos(2 * a), abs=1e-10)
    r = face().kinematics(t)
    assert r["disc.angle"][-1] > 9 * 2 * math.pi
    turned = r["arm.angle"] + math.pi / 2 - r["disc.angle"]
    assert -0.1 * np.sin(r["arm.angle"]) == pytest.approx(0.05 + 0.01 * np.cos(2 * turned), abs=1e-10)


def rolling(radius="0.04 + 0.01*cos(3*a)", size="8 mm", **more):
    """A roller on a cam with hollows."""
    return roller(radius, more=f'roller = "{size}"', **more)


@nojit
def test_a_roller_is_its_radius_away_from_the_nearest_point_of_the_cam():
    t = np.linspace(0.0, 2.0, 41)
    r = rolling().kinematics(t)
    a = np.linspace(-math.pi, math.pi, 100_001)
    f = 0.04 + 0.01 * np.cos(3 * a)
    for x, y, turn in zip(r["arm.P.x"], r["arm.P.y"], r["disc.angle"], strict=True):
        apart = np.hypot(x - f * np.cos(a + turn), y - f * np.sin(a + turn))
        assert apart.min() == pytest.approx(0.008, abs=1e-9)  # between the points of the fine curve


@nojit
@pytest.mark.parametrize("make", [roller, face, rolling])
def test_rates_of_a_follower_are_derivatives(make):
    h = 1e-3
    r = make().kinematics(0.7 + h * np.arange(-3, 4))
    first, second = np.array([-1, 9, -45, 0, 45, -9, 1]) / 60, np.array([2, -27, 270, -490, 270, -27, 2]) / 180
    assert r["arm.omega"][3] == pytest.approx(first @ r["arm.angle"] / h, abs=1e-9)
    assert r["arm.alpha"][3] == pytest.approx(second @ r["arm.angle"] / h**2, abs=1e-7)


@nojit
def test_a_table_of_one_turn_or_with_a_period_is_followed_over_many_turns():
    """A table that ends at +-180 deg, and one of 0 to 360 deg with a period, are the same cam."""
    knots = np.linspace(-math.pi, math.pi, 25)
    t = np.linspace(0.0, 8.0, 9)
    found = []
    for at, period in ((knots, ""), (knots + math.pi, f", period = {2 * math.pi!r}")):
        high = 0.04 + 0.01 * np.cos(2 * at)
        low = high if period == "" else [*high[:-1], high[0]]
        table = f'[tables]\nlift = {{ x = {at.tolist()}, y = {list(map(float, low))}, kind = "spline"{period} }}\n'
        found.append(roller("lift(a)", head=table).kinematics(t)["arm.angle"])
    exact = roller().kinematics(t)["arm.angle"]
    assert found[0] == pytest.approx(exact, abs=5e-3)  # splines with knots every 15 deg
    assert found[1] == pytest.approx(exact, abs=5e-3)


def eccentric(kind):
    """Eccentric of 10 mm, 50 mm to the roller's centre: by its path, on the surface, as the rod that it stands for."""
    link = joint("cam", "rod", "disc.E", "arm.R", "length = 0.05")
    if kind != "rod":
        size, on = (0.05, "") if kind == "path" else (0.03, 'roller = "20 mm"')
        curve = f'radius = "0.01*cos(a) + sqrt({size}**2 - (0.01*sin(a))**2)"\n'
        link = joint("cam", "cam", "disc.C", "arm.R", curve + on)
    return model(
        wheel("disc", points="C = [0, 0], E = [0.01, 0]", inertia=0.01),
        body("arm", "Q = [0, 0], R = [0.1, 0]", 1.0, 0.01, "[0.08, 0.01]"), joint("Q", "revolute", "ground.Q", "arm.Q"),
        link, '[loads.push]\ntype = "torque"\nbody = "disc"\ntorque = "0.3 - 0.01*disc.omega"\n',
        ground='O = [0, 0]\nQ = [0.1, "sqrt(0.0024)"]', g=9.81,
        initial='disc = { angle = 0, omega = 20 }\narm = { angle = "180 deg", omega = -2 }',
    )  # fmt: skip


@pytest.mark.parametrize("kind", ["path", "surface"])
def test_an_eccentric_circle_is_the_rod_between_the_centres_with_the_same_force(kind):
    t = np.linspace(0.0, 1.0, 11)
    cam, rod = (eccentric(one).simulate(t_eval=t, **FINE) for one in (kind, "rod"))
    for curve in ("disc.angle", "arm.angle"):
        assert cam[curve] == pytest.approx(rod[curve], abs=1e-10)
    for curve in ("cam.fx", "cam.fy", "Q.fx"):
        assert cam[curve] == pytest.approx(rod[curve], abs=1e-6)
    assert np.abs(cam["energy.balance"]).max() < 1e-9


@nojit
@pytest.mark.parametrize("size", [0.0, 0.02])
def test_a_follower_whose_guide_begins_in_the_cam_starts_outside_in_the_direction_of_the_guide(size):
    """Eccentric of 10 mm, the guide through its axis or beside it; in the middle of a cam nothing says where out is."""
    curve = f'radius = "0.01*cos(a) + sqrt(0.03**2 - (0.01*sin(a))**2)"\nroller = {size}'
    for beside, turn in ((0.0, 0.0), (0.0, -2.0), (0.006, 0.0), (-0.006, 2.0)):
        start = model(
            wheel("disc"), body("follower"), driver("disc", f"{turn} + t"),
            joint("guide", "prismatic", "ground.G", "follower.C", 'axis = "90 deg"\nangle = 0'),
            joint("lift", "cam", "disc.C", "follower.C", curve), ground=f"O = [0, 0]\nG = [{beside}, 0]",
        ).start  # fmt: skip
        across = beside - 0.01 * math.cos(turn)
        high = 0.01 * math.sin(turn) + math.sqrt((0.03 + size) ** 2 - across**2)
        assert start.q[3:5] == pytest.approx([beside, high], abs=1e-12)


def wire(s0, radius=0.25):
    """A bead on a cycloid that hangs from its cusps, given by a table of its distance from the middle between them."""
    s = np.arange(-2.8, 2.80625, 0.0125)
    x, y = radius * (s + np.sin(s)), -radius * (1 + np.cos(s))
    table = f'wire = {{ x = {np.arctan2(y, x).tolist()}, y = {np.hypot(x, y).tolist()}, kind = "spline" }}'
    place = f"x = {radius * (s0 + math.sin(s0))!r}, y = {-radius * (1 + math.cos(s0))!r}"
    return model(
        body("bead"), joint("wire", "cam", "ground.O", "bead.C", 'radius = "wire(a)"'), g=9.81,
        head=f"[tables]\n{table}\n", initial=f"bead = {{ {place} }}",
    )  # fmt: skip


def test_a_bead_on_a_cycloid_swings_as_a_harmonic_oscillator_whatever_its_amplitude():
    """sin(s/2) is harmonic with the frequency sqrt(g/(4 R)); here 2 sqrt(g/R/4) = sqrt(9.81) rad/s."""
    period = 4 * math.pi * math.sqrt(0.25 / 9.81)
    r = wire(1.5).simulate(t_eval=np.linspace(0.0, period, 9), rtol=1e-10, atol=1e-12)
    s = 2 * np.arcsin(math.sin(0.75) * np.cos(r.t * math.sqrt(9.81)))
    assert r["bead.x"] == pytest.approx(0.25 * (s + np.sin(s)), abs=1e-6)


@nojit
def test_contact_force_of_a_flat_follower_is_that_of_its_harmonic_lift():
    """Eccentric circle: lift R + e sin(w t), so m (lift'' + g) presses, e cos(w t) beside the axis."""
    e, w = 0.01, 10.0
    m = model(
        wheel("disc"), body("follower", mass=2.0),
        joint("guide", "prismatic", "ground.O", "follower.C", 'axis = "90 deg"\nangle = 0'),
        joint("face", "flat-follower", "disc.C", "follower.C", f'axis = "90 deg"\nsupport = "0.03 + {e}*cos(x)"'),
        driver("disc", f"{w}*t"), initial="follower = { y = 0.03 }", g=9.81,
    )  # fmt: skip
    r = m.inverse_dynamics([0.0, 0.05, 0.2])
    turn = w * r.t
    press = 2.0 * (9.81 - e * w**2 * np.sin(turn))
    assert r["follower.y"] == pytest.approx(0.03 + e * np.sin(turn), abs=1e-12)
    assert r["face.fy"] == pytest.approx(press, abs=1e-9)
    assert r["face.fx"] == pytest.approx(np.zeros(3), abs=1e-12)
    assert r["disc_motor.torque"] == pytest.approx(press * e * np.cos(turn), abs=1e-10)
    assert r["face.moment"] == pytest.approx(press * e * np.cos(turn), abs=1e-10)


def test_derivatives_of_a_driven_follower_by_parameters_of_its_cam_are_differences():
    times, r0 = [0.0, 0.4, 1.0], 0.04
    round_, flat = "r0 + 0.01*cos(2*a)", "r0 + 0.02 + 0.01*cos(2*x)"
    for make, law in ((roller, round_), (face, flat), (rolling, round_)):
        m = make(law, head=f"[parameters]\nr0 = {r0}\n")
        s = m.sensitivity(["arm.angle"], ["r0"], times, analysis="kinematics")
        ahead, behind = (m.set({"r0": r0 + h}).kinematics(times)["arm.angle"] for h in (1e-6, -1e-6))
        assert s["d(arm.angle)/d(r0)"] == pytest.approx((ahead - behind) / 2e-6, rel=1e-6)


@pytest.mark.parametrize("make", [roller, rolling])
def test_samples_side_by_side_are_the_single_runs(make):
    m = make("r0 + 0.01*cos(2*a)", head="[parameters]\nr0 = 0.04\n")
    values = np.array([0.039, 0.04, 0.0405])
    found = m.many({"r0": values}, ["final(arm.angle)"], 0.2)
    for n, value in enumerate(values):
        one = m.set({"r0": float(value)}).simulate(0.2, **FINE)["arm.angle"][-1]
        assert found["final(arm.angle)"][n] == pytest.approx(one, abs=1e-8)


# ---------------------------------------------------------------- what is refused
@nojit
@pytest.mark.parametrize(
    ("radius", "words"),
    [
        ("0.03 + 0.04*cos(a)", r"radius: must be positive at every angle; it is -0\.01 m at a = -180 deg"),
        ("0.01*sin(a)", r"it is -0\.01 m at a = -90 deg"),
        ("0*a", r"must be positive at every angle"),
        ("late(a)", r"radius: it is not known at any angle a"),
        ("0.03 + b", r"unknown name 'b'"),
    ],
)
def test_a_curve_around_nothing_is_refused(radius, words):
    with pytest.raises(rt.ModelError, match=words):
        _ = roller(radius, head="[tables]\nlate = { x = [4, 5], y = [0.1, 0.2] }\n").model


@nojit
@pytest.mark.parametrize(
    ("radius", "size", "words"),
    [
        ("0.04 + 0.01*cos(3*a)", "20 mm", r"0\.02 m, is larger than that of the hollow of the cam at a = .*0\.015 m"),
        ("0.04 + 0.001*abs(a)", "5 mm", r"the curve of the cam has a corner near a = -1 deg"),
        ("0.035 + 0.002*a", "10 mm", r"roller: on the cam at a = .* deg it would stand 0\.00\d+ m in the cam"),
        ("0.04", "-1 mm", "must not be negative"),
    ],
)
def test_a_roller_that_cannot_follow_its_cam_is_refused(radius, size, words):
    with pytest.raises(rt.ModelError, match=words):
        _ = rolling(radius, size).model


@nojit
@pytest.mark.parametrize("key", ['clearance = "1 mm"', 'roller = "5 mm"', "stop = { min = 0 }"])
def test_play_rollers_and_stops_of_a_cam_are_refused(key):
    with pytest.raises(rt.ModelError, match=key.partition(" ")[0]):
        _ = face(more=key).model


@nojit
@pytest.mark.parametrize(
    ("support", "words"),
    [
        ("0.03 + 0.01*cos(3*x)", r"needs a convex cam; near x = (0|-120|120) deg .* h \+ h'' is -0\.05 m"),
        ("0.02 + 0.01*cos(2*x)", r"near x = (0|-180|180) deg the radius of curvature h \+ h'' is -0\.01 m"),
        ("0.05 - 0.02*abs(sin(x))", r"needs a convex cam"),
        ("-0.02 + 0.001*cos(x)", r"needs a convex cam"),
    ],
)
def test_a_cam_that_is_not_convex_under_a_flat_face_is_refused(support, words):
    with pytest.raises(rt.ModelError, match=words):
        _ = face(support).model


@nojit
@pytest.mark.parametrize("support", ["0.05 + 0.01*cos(2*x)", "0.05 + 0.04*cos(x)", "0.05 + 0.02*abs(sin(x))", "0.05"])
def test_convex_cams_and_those_with_corners_outside_are_taken(support):
    assert face(support).model


@nojit
@pytest.mark.parametrize(
    ("make", "law", "words"),
    [
        (face, "0.05 + 0.0065*cos(3*x)", r"joint 'cam': support: .* h \+ h'' is -0\.002 m: .* cuts off 3\.8\de-05 m"),
        (roller, "0.04 + 0.001*a", r"joint 'cam': radius: .* a = 180 deg, from 0\.04314 m to 0\.03686 m"),
        (face, "0.05 + 0.001*x", r"joint 'cam': support: .* x = 180 deg, from 0\.05314 m to 0\.04686 m"),
    ],
)
def test_small_loops_and_steps_of_a_cam_are_noted(make, law, words):
    def said(m):
        return [note for note in m.kinematics([0.0, 0.01]).trust.notes if "joint 'cam'" in note]

    (note,) = said(make(law))
    assert re.search(words, note)
    assert note in str(make(law).check())
    assert said(make()) == []


# ---------------------------------------------------------------- pictures
@nojit
def test_outlines_are_drawn_to_scale_and_turn_with_their_bodies():
    figure, ax = plt.subplots()
    r = roller().kinematics([0.0, 0.4])
    draw_at(ax, r, 1)
    outline = max((line.get_xydata() for line in ax.lines), key=len)
    a = np.arctan2(outline[:, 1], outline[:, 0]) - r["disc.angle"][1]
    assert np.hypot(*outline.T) == pytest.approx(0.04 + 0.01 * np.cos(2 * a), abs=1e-12)
    plt.close(figure)


@nojit
def test_the_drawn_face_touches_the_drawn_cam():
    figure, ax = plt.subplots()
    r = face().kinematics([0.0, 0.4])
    draw_at(ax, r, 1)
    outline = max((line.get_xydata() for line in ax.lines), key=len)
    turn = r["arm.angle"][1] + math.pi / 2
    n = np.array([math.cos(turn), math.sin(turn)])
    faces = [line.get_xydata() for line in ax.lines if len(line.get_xydata()) == 2]
    (drawn,) = (one for one in faces if abs(np.ptp(one @ n)) < 1e-12)
    gap = drawn[0] @ n - (outline @ n).max()
    assert -1e-12 < gap < 0.05 * (math.pi / 360) ** 2  # a chord of a degree stays inside of the curve by so much
    plt.close(figure)
