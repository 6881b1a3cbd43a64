"""Loads that friction in joints holds at rest, against the closed forms of statics and independent solutions."""

from __future__ import annotations

from math import atan, cos, exp, hypot, inf, pi, sin, tan

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve

import rattle as rt

pytestmark = [pytest.mark.nojit, pytest.mark.plain]

G = 9.81


def ramp(slope: float, friction: str, at: str = "C", force: str = "[1, 0]", gravity: float = G, more: str = "") -> str:
    """A block of 1 kg on a straight line of that slope [rad], pushed by a force."""
    return f"""
format = 1
gravity = [0, {-gravity!r}]
[ground.points]
O = [0, 0]
[bodies.block]
points = {{ C = [0, 0], H = [0, 0.5] }}
mass = 1
inertia = 1
[joints.guide]
type = "prismatic"
connect = ["ground.O", "block.C"]
axis = {slope!r}
{friction}
[loads.push]
type = "force"
at = "block.{at}"
force = {force}
{more}
"""


@pytest.mark.parametrize(("slope", "mu"), [(0.3, 0.1), (0.2, 0.3), (1.0, 0.3), (1.0, 0.7)])
def test_a_block_on_a_slope_rests_between_the_forces_of_the_angle_of_friction(slope, mu):
    held, phi = rt.loads(ramp(slope, f"friction = {mu}")).holds("push"), atan(mu)
    assert abs(held.low / (G * tan(slope - phi)) - 1) < 1e-12
    assert held.high == inf if slope + phi >= pi / 2 else abs(held.high / (G * tan(slope + phi)) - 1) < 1e-12
    assert abs(held.free - G * tan(slope)) < 1e-12
    assert held.self_locking == (tan(slope) <= mu)
    assert held.jams == (slope + phi >= pi / 2)
    assert np.allclose(held.jams_from[1], 1 / (tan(slope) * mu), rtol=1e-9)


def test_the_interval_is_that_of_friction_at_rest_and_counts_along_the_load_as_it_is_given():
    table = 'friction = { model = "coulomb", mu = 0.1, mu_static = 0.25 }'
    held = rt.loads(ramp(0.3, table, force="[-5, 0]")).holds("push")
    assert np.allclose([held.low, held.high], [-G * tan(0.3 + atan(0.25)), -G * tan(0.3 - atan(0.25))], rtol=1e-12)
    assert (held.value, held.unit, held.rests) == (5.0, "N", False)
    run = [rt.loads(ramp(0.3, table, force=f"[{share * -held.high!r}, 0]")) for share in (1.001, 0.999)]
    moved = [abs(one.simulate(1.0, t_eval=[0, 1.0])["block.x"][1]) for one in run]
    assert moved[0] < 1e-14
    assert moved[1] > 0.1


@pytest.mark.parametrize(("mu", "jams"), [(0.199, False), (0.201, True)])
def test_a_drawer_pushed_beside_its_middle_jams_from_a_over_e_on_whatever_it_carries(mu, jams):
    guide = f"block = {{ length = 0.2, height = 0.05 }}\nfriction = {mu}"  # a = 0.1, e = 0.5
    held = rt.loads(ramp(0.0, guide, "H", gravity=0.0)).holds("push")
    assert (held.low, held.high) == ((-inf, inf) if jams else (0.0, 0.0))
    assert np.allclose(held.jams_from, 0.2 / mu, rtol=1e-12)
    loaded = rt.loads(ramp(0.0, guide, "H")).holds("push")
    most = inf if jams else mu * G  # its weight presses more than the moment, as long as p e/a < G
    assert np.allclose([loaded.low, loaded.high], [-most, most], rtol=1e-12)


def lever(mu: float, radius: float = 0.02) -> str:
    """Arms of 0.1 m and 0.3 m on a pin; 60 N down on the short one, the load sought down on the long one."""
    return f"""
format = 1
gravity = [0, 0]
[ground.points]
O = [0, 0]
[bodies.lever]
points = {{ O = [0, 0], P = [-0.1, 0], H = [0.3, 0] }}
mass = 1
inertia = 1
[joints.pin]
type = "revolute"
connect = ["ground.O", "lever.O"]
friction = {{ model = "coulomb", mu = {mu}, pin_radius = {radius} }}
[loads.weight]
type = "force"
at = "lever.P"
force = [0, -60]
[loads.hand]
type = "force"
at = "lever.H"
force = [0, -1]
"""


def test_a_lever_turns_where_the_reaction_touches_the_circle_of_friction():
    held, r = rt.loads(lever(0.3)).holds("hand"), 0.3 * 0.02  # all forces are parallel: M = mu R (60 + p)
    assert np.allclose([held.low, held.high], [60 * (0.1 - r) / (0.3 + r), 60 * (0.1 + r) / (0.3 - r)], rtol=1e-12)
    assert np.allclose(held.jams_from[1], 0.3 / r, rtol=1e-9)  # the circle reaches the hand
    motor = lever(0.3).replace(
        "[loads.hand]", '[loads.motor]\ntype = "torque"\nbody = "lever"\ntorque = -1\n[loads.hand]'
    )
    held = rt.loads(motor.replace("force = [0, -1]", "force = [0, -10]")).holds("motor")
    assert np.allclose([held.low, held.high], [-3 - 70 * r, -3 + 70 * r], rtol=1e-12)
    assert held.unit == "N*m"


def rope(mu: float, wrap: float, shoes: int) -> str:
    """A rope on a drum of radius 1: shoes tied to each other by rods, a force on the first, another on the last."""
    step = wrap / shoes
    at = [(cos(step * (n + 0.5)), sin(step * (n + 0.5))) for n in range(shoes)]
    parts = ["format = 1\ngravity = [0, 0]\n[ground.points]\nO = [0, 0]"]
    for n, (x, y) in enumerate(at):
        parts.append(f"[bodies.s{n}]\npoints = {{ O = [0, 0], P = [{x!r}, {y!r}] }}\nmass = 1\ninertia = 1")
        parts.append(f'[joints.drum{n}]\ntype = "revolute"\nconnect = ["ground.O", "s{n}.O"]')
        parts.append(f'friction = {{ model = "coulomb", mu = {mu}, pin_radius = 1 }}\n[initial.s{n}]\nangle = 0')
        if n:
            length = hypot(x - at[n - 1][0], y - at[n - 1][1])
            parts.append(f'[joints.tie{n}]\ntype = "rod"\nconnect = ["s{n - 1}.P", "s{n}.P"]\nlength = {length!r}')
    for name, n, side in (("slack", 0, -1.0), ("tight", shoes - 1, 1.0)):
        far = step * (n + 0.5 + side)  # towards the point of the next shoe
        fx, fy = cos(far) - at[n][0], sin(far) - at[n][1]
        size = hypot(fx, fy)
        parts.append(f'[loads.{name}]\ntype = "force"\nat = "s{n}.P"\nforce = [{fx / size!r}, {fy / size!r}]')
    return "\n".join(parts)


def test_a_rope_around_a_drum_holds_e_to_the_mu_times_the_wrap():
    mu, wrap, shoes = 0.25, pi, 16
    held = rt.loads(rope(mu, wrap, shoes)).holds("tight")
    step, T = wrap / shoes, 1.0
    for _ in range(shoes):  # one shoe: the difference of tensions on its lever arm against mu times the resultant

        def unbalanced(ahead, T=T):
            resultant = hypot((ahead + T) * sin(step / 2), (ahead - T) * cos(step / 2))
            return (ahead - T) * cos(step / 2) - mu * resultant

        T = brentq(unbalanced, T, 3 * T, xtol=1e-15)
    assert np.allclose([held.low, held.high], [1 / T, T], rtol=1e-11)
    assert abs(held.high / exp(mu * wrap) - 1) < 0.05  # a polygon, whose friction also presses


LINKS = {"crank": (0.3, 1.1), "coupler": (0.9, 0.45), "rocker": (0.6, 1.9)}


def fourbar(mu: float) -> str:
    """A four-bar whose pins rub, under a weight at the middle of the coupler and a torque on its crank."""
    parts = ["format = 1\ngravity = [0, -9.81]\n[ground.points]\nA = [0, 0]\nD = [1, 0.1]"]
    for name, (length, angle) in LINKS.items():
        parts.append(f'[bodies.{name}]\nbar = ["P", "Q"]\nlength = {length}\nmass = {10 * length}')
        parts.append(f"[initial.{name}]\nangle = {angle}")
    ends = [("ground.A", "crank.P"), ("crank.Q", "coupler.P"), ("coupler.Q", "rocker.Q"), ("ground.D", "rocker.P")]
    for n, (a, b) in enumerate(ends):
        parts.append(f'[joints.j{n}]\ntype = "revolute"\nconnect = ["{a}", "{b}"]')
        parts.append(f'friction = {{ model = "coulomb", mu = {mu}, pin_radius = "{20 + 5 * n} mm" }}')
    parts.append('[loads.drive]\ntype = "torque"\nbody = "crank"\ntorque = 1')
    parts.append('[loads.pull]\ntype = "force"\nat = "rocker.Q"\nforce = [-80, 30]')
    return "\n".join(parts)


def pins_by_hand(angle: dict[str, float], mu: float, sense: float) -> float:
    """Torque at which a four-bar is about to move: free-body equations of three bars, one unknown force at each pin."""
    A, D = np.zeros(2), np.array([1.0, 0.1])
    e = {name: np.array([cos(one), sin(one)]) * LINKS[name][0] for name, one in angle.items()}
    B, C = A + e["crank"], D + e["rocker"]
    across = {name: np.array([-one[1], one[0]]) for name, one in e.items()}
    rates = np.linalg.solve(np.stack([across["coupler"], -across["rocker"]], axis=1), -across["crank"])  # crank at 1
    w2, w3 = rates
    slip = np.sign(np.array([1.0, w2 - 1.0, w3 - w2, w3])) * sense  # of the second body of each pin against the first
    radius = mu * np.array([0.020, 0.025, 0.030, 0.035])

    def cross(arm, force):
        return arm[0] * force[1] - arm[1] * force[0]

    def unbalanced(x):
        F = x[:8].reshape(4, 2)  # on the second body of each pin
        M = -slip * radius * np.hypot(*F.T)
        weight = {name: np.array([0.0, -10 * LINKS[name][0] * G]) for name in LINKS}
        pull = np.array([-80.0, 30.0])
        crank = F[0] - F[1] + weight["crank"]
        coupler = F[1] - F[2] + weight["coupler"]
        rocker = F[2] + F[3] + weight["rocker"] + pull
        turning = [
            M[0] - M[1] + cross(B - A, -F[1]) + cross(e["crank"] / 2, weight["crank"]) + x[8],
            M[1] - M[2] + cross(C - B, -F[2]) + cross(e["coupler"] / 2, weight["coupler"]),
            M[2] + M[3] + cross(C - D, F[2] + pull) + cross(e["rocker"] / 2, weight["rocker"]),
        ]
        return [*crank, *coupler, *rocker, *turning]

    return float(fsolve(unbalanced, np.full(9, 10.0), xtol=1e-12)[8])


@pytest.mark.parametrize("mu", [0.0001, 0.15, 0.4])
def test_a_fourbar_with_friction_in_every_pin_agrees_with_its_free_bodies(mu):
    held = rt.loads(fourbar(mu)).holds("drive")
    by_hand = [pins_by_hand(dict(zip(LINKS, held.q[2::3], strict=True)), mu, sense) for sense in (-1.0, 1.0)]
    assert np.allclose([held.low, held.high], by_hand, rtol=1e-9)


def wedge(slope: float, mu: float, sliding: float) -> str:
    """A wedge on the ground under a block of 5 kg in a vertical guide; only the face and the ground rub."""
    return f"""
format = 1
gravity = [0, {-G}]
[ground.points]
O = [0, 0]
[bodies.wedge]
points = {{ C = [0, 0] }}
mass = 1e-9
inertia = 1
[bodies.block]
points = {{ C = [0, 0] }}
mass = 5
inertia = 1
[joints.floor]
type = "prismatic"
connect = ["ground.O", "wedge.C"]
friction = {sliding}
[joints.face]
type = "prismatic"
connect = ["wedge.C", "block.C"]
axis = {slope!r}
angle = 0
friction = {mu}
[joints.shaft]
type = "prismatic"
connect = ["ground.O", "block.C"]
axis = {pi / 2!r}
angle = 0
[loads.push]
type = "force"
at = "wedge.C"
force = [-1, 0]
"""


@pytest.mark.parametrize("sliding", [0.0, 0.12])
def test_a_wedge_lifts_with_the_angles_of_friction_of_its_faces_and_holds_by_itself_if_flat(sliding):
    W, mu = 5 * G, 0.2
    for slope in (0.1, 0.3):  # moments of the three guides are not unique: without `block` they do not press
        held = rt.loads(wedge(slope, mu, sliding)).holds("push")
        lift = W * (tan(slope + atan(mu)) + sliding)
        lower = W * (tan(slope - atan(mu)) - sliding)
        assert np.allclose([held.low, held.high], [lower, lift], rtol=1e-7)  # the wedge weighs a little
        assert held.self_locking == (lower <= 0)
    blocked = wedge(0.1, mu, sliding).replace(
        '"block.C"]\naxis = 0.1', '"block.C"]\nblock = { length = 1, height = 1 }\naxis = 0.1'
    )
    with pytest.raises(rt.ModelError, match=r"joints\.face\.friction: its reaction is not unique"):
        rt.loads(blocked).holds("push")


def test_of_a_driver_the_interval_is_that_of_its_effort():
    motor = '[drivers.screw]\njoint = "guide"\nposition = 0.2\n'
    m = rt.loads(ramp(0.3, "friction = 0.1", force="[1, 0]", more=motor))
    held = m.holds("screw")
    free, normal = G * sin(0.3) - cos(0.3), G * cos(0.3) + sin(0.3)
    assert np.allclose([held.free, held.low, held.high], [free, free - 0.1 * normal, free + 0.1 * normal], rtol=1e-12)
    assert (held.load, held.unit, held.rests) == ("screw.force", "N", False)
    assert abs(m.equilibrium()[0]["screw.force"] - free) < 1e-12
    with pytest.raises(ValueError, match=r"no degree of freedom.*ask for the effort of 'screw'"):
        m.holds("push")


def test_a_multiple_of_gravity_and_of_springs_is_held():
    spring = '[loads.spring]\ntype = "spring"\nconnect = ["ground.O", "block.C"]\nstiffness = 10\nfree_length = 0\n'
    m = rt.loads(ramp(0.0, "friction = 0.1", force="[2, 0]", more=spring + "[initial]\nblock = { x = 0.5 }"))
    held = m.holds("spring")  # pulls with 5 N: tension counts positive
    assert np.allclose([held.low, held.value, held.high], [2 - 0.1 * G, 5, 2 + 0.1 * G], rtol=1e-12)
    held = rt.loads(ramp(0.3, "friction = 0.1", force="[2, 0]")).holds("gravity")
    ends = [2 * (cos(0.3) + s * 0.1 * sin(0.3)) / G / (sin(0.3) - s * 0.1 * cos(0.3)) for s in (-1, 1)]
    assert np.allclose([held.low, held.high], ends, rtol=1e-12)


def test_at_an_equilibrium_the_interval_surrounds_the_load_that_is_there():
    spring = '[loads.spring]\ntype = "spring"\nconnect = ["ground.O", "block.C"]\nstiffness = 10\nfree_length = 0\n'
    m = rt.loads(ramp(0.0, "friction = 0.1", force="[2, 0]", more=spring))
    E = m.equilibrium()
    held = m.holds("push", at=E[0])
    assert np.allclose([held.low, held.free, held.high], [2 - 0.1 * G, 2, 2 + 0.1 * G], rtol=1e-9)
    assert "friction in 'guide' is left out" in E.note
    assert abs(E[0]["block.x"] - 0.2) < 1e-9


def test_what_has_no_interval_is_refused_and_says_why():
    loose = rt.loads(ramp(0.3, ""))
    with pytest.raises(rt.ModelError, match="no joint without play has friction"):
        loose.holds("push")
    with pytest.raises(rt.ModelError, match="creep under any load"):
        rt.loads(ramp(0.3, 'friction = { model = "coulomb-smooth", mu = 0.1, v1 = "1 mm/s" }')).holds("push")
    m = rt.loads(ramp(0.3, "friction = 0.1"))
    with pytest.raises(ValueError, match="no load or driver 'pusch'; did you mean 'push'"):
        m.holds("pusch")
    with pytest.raises(ValueError, match="exerts nothing"):
        m.set(gravity=[0, 0]).holds("gravity")
    with pytest.raises(ValueError, match="does no work in the motion that is left"):
        rt.loads(ramp(0.0, "friction = 0.1", force="[0, 1]")).holds("push")
    free = "[bodies.other]\npoints = { C = [0, 0] }\nmass = 1\ninertia = 1\n[joints.pin]\n"
    free += 'type = "revolute"\nconnect = ["block.H", "other.C"]'
    with pytest.raises(ValueError, match=r"2 degrees of freedom are left.*hold the other with a driver"):
        rt.loads(ramp(0.3, "friction = 0.1", more=free)).holds("push")
    play = free + '\nclearance = "1 mm"\ncontact = { model = "impact", restitution = 0 }'
    with pytest.raises(rt.ModelError, match=r"joints\.pin: .*close it with ideal"):
        rt.loads(ramp(0.3, "friction = 0.1", more=play)).holds("push")


def test_the_words_say_whether_it_rests_holds_itself_or_jams():
    said = {mu: str(rt.loads(ramp(0.2, f"friction = {mu}")).holds("push")).split("\n") for mu in (0.05, 0.3)}
    ends = [f"{G * tan(0.2 + sense * atan(0.05)):.6g} N" for sense in (-1, 1)]
    assert said[0.05] == [
        f"rests for push between {ends[0]} and {ends[1]} ({G * tan(0.2):.6g} N without friction)",
        "now 1 N: it moves, as the load is too small",
        "not self-locking: without push it moves",
    ]
    assert said[0.3][1:] == ["now 1 N: it rests", "self-locking: it rests without push"]
    steep = str(rt.loads(ramp(1.0, "friction = 0.7")).holds("push"))
    assert "rests for push from 4.02413 N on" in steep
    assert "jams: however large push is, it does not move (from 0.9173 times this friction on)" in steep


@pytest.mark.machine
def test_friction_holds_a_block_on_a_spring_and_a_pendulum_in_a_band_of_positions():
    spring = '[loads.spring]\ntype = "spring"\nconnect = ["ground.O", "block.C"]\nstiffness = 10\nfree_length = 0\n'
    m = rt.loads(ramp(0.0, "friction = 0.1", force="[2, 0]", more=spring))
    band = m.dead_band(at=m.equilibrium()[0])
    assert np.allclose(band["block.x"], [0.2 - 0.01 * G, 0.2 + 0.01 * G], rtol=1e-12)
    assert str(band) == "friction holds it from guide.position 0.1019 m to 0.2981 m"
    with pytest.raises(ValueError, match="does not hold it at this position"):
        m.dead_band()
    bar = rt.loads(
        f'format = 1\ngravity = [0, {-G}]\n[ground.points]\nO = [0, 0]\n[bodies.bar]\nbar = ["A", "B"]\nlength = 1\n'
        'mass = 1\n[joints.pin]\ntype = "revolute"\nconnect = ["ground.O", "bar.A"]\n'
        'friction = { model = "coulomb", mu = 0.5, pin_radius = "50 mm" }\n[initial]\nbar = { angle = "-90 deg" }'
    )
    lean = np.arcsin(0.5 * 0.05 / 0.5)  # its weight touches the circle of friction
    for E, middle in zip(bar.equilibrium(), (-pi / 2, pi / 2), strict=True):
        assert np.allclose(bar.dead_band(at=E)["bar.angle"], [middle - lean, middle + lean], rtol=1e-12)


def test_at_the_ends_of_the_band_of_a_fourbar_its_free_bodies_are_about_to_move():
    band = rt.loads(fourbar(0.3).replace("torque = 1", "torque = -18")).dead_band()
    for one, sense in ((band.first, -1.0), (band.last, 1.0)):
        assert abs(pins_by_hand(dict(zip(LINKS, one.q[2::3], strict=True)), 0.3, sense) + 18) < 1e-7


def test_where_friction_holds_all_around_there_is_no_end():
    level = rt.loads(lever(0.3).replace("[0, -60]", "[0, -3]").replace("[0, -1]", "[0, -1.01]"))
    assert str(level.dead_band()) == "friction holds it in every position of its motion"  # M < mu R (3 + 1.01)


def test_a_joint_that_does_not_turn_at_this_instant_rubs_the_way_that_holds_most():
    slider = """
format = 1
gravity = [0, 0]
[ground.points]
O = [0, 0]
[bodies]
crank = { bar = ["A", "B"], length = 0.1, mass = 1 }
rod = { bar = ["A", "B"], length = 0.3, mass = 1 }
piston = { points = { P = [0, 0] }, mass = 1, inertia = 1 }
[joints]
o = { type = "revolute", connect = ["ground.O", "crank.A"] }
p = { type = "revolute", connect = ["crank.B", "rod.A"] }
q = { type = "revolute", connect = ["rod.B", "piston.P"], friction = { mu = 0.2, pin_radius = "30 mm" } }
g = { type = "prismatic", connect = ["ground.O", "piston.P"], friction = 0.2 }
[loads.gas]
type = "force"
at = "piston.P"
force = [-100, 0]
[loads.motor]
type = "torque"
body = "crank"
torque = 1
[initial]
crank = { angle = "90 deg" }
"""
    held = rt.loads(slider).holds("motor")
    c, s = np.sqrt(8) / 3, 1 / 3  # of the rod, which moves in parallel: the moment of pin q presses the guide
    ends = []
    for sense in (-1.0, 1.0):

        def unbalanced(x, sense=sense, way=1.0):
            along, across = x  # force of the rod on the piston
            tilt = 0.2 * 0.03 * hypot(along, across) * way
            return [along * c - across * s - 100 - sense * 0.2 * abs(along * s + across * c), across * 0.3 - tilt]

        forces = [fsolve(unbalanced, [100.0, 0.0], args=(sense, way), xtol=1e-11) for way in (-1.0, 1.0)]
        torques = [-0.1 * (f[0] * c - f[1] * s) for f in forces]
        ends.append(max(torques, key=abs) if sense > 0 else min(torques, key=abs))
    assert np.allclose([held.low, held.high], sorted(ends), rtol=1e-9)
