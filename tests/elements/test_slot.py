"""Pin in a slot: closed forms without play; with play a billiard, a bead on its wall, and all models of contact."""

import math

import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rattle as rt
from rattle import registry
from rattle.plots.sketch import draw_at

nojit = pytest.mark.nojit


def with_play(clearance=0.0, contact='"ideal"', length=0.0):
    """What stands in the table of a slot with play."""
    play = f"clearance = {clearance}\ncontact = {contact}\n" if clearance else ""
    return play + (f"length = {length}\n" if length else "")


def scotch_yoke(slot="", extra=""):
    """Crank of 0.05 m at 100 rad/s about O, its pin in a slot across the yoke of 1 kg that slides along x."""
    return rt.loads(f"""
format = 1
[ground.points]
O = [0, 0]
[bodies.crank]
points = {{ O = [0, 0], P = [0.05, 0] }}
mass = 1
inertia = 1e-3
[bodies.yoke]
points = {{ S = [0, 0] }}
mass = 1
inertia = 1e-3
[joints.axis]
type = "revolute"
connect = ["ground.O", "crank.O"]
[joints.rail]
type = "prismatic"
connect = ["ground.O", "yoke.S"]
[joints.slot]
type = "slot"
connect = ["yoke.S", "crank.P"]
axis = "90 deg"
{slot}
[drivers.motor]
joint = "axis"
angle = "100*t"
{extra}
""")


def bead(slot, start, gravity=0.0, axis="0 deg", extra=""):
    """A bead of 2 kg in a slot of the ground about the origin."""
    return rt.loads(f"""
format = 1
gravity = [0, {-gravity}]
[ground.points]
O = [0, 0]
A = [0, 1]
[bodies.bead]
points = {{ P = [0, 0] }}
mass = 2
inertia = 1e-3
[joints.slot]
type = "slot"
connect = ["ground.O", "bead.P"]
axis = "{axis}"
{slot}
{extra}
[initial]
bead = {{ {start} }}
""")


def rotor(slot, c=0.0, r=0.1, w=3.0):
    """A bead of 2 kg on the wall of a slot that turns at 3 rad/s, at rest in it, 0.1 m from the axis."""
    return rt.loads(f"""
format = 1
[ground.points]
O = [0, 0]
[bodies.disc]
points = {{ O = [0, 0] }}
mass = 1
inertia = 1e-3
[bodies.bead]
points = {{ P = [0, 0] }}
mass = 2
inertia = 1e-3
[joints.axis]
type = "revolute"
connect = ["ground.O", "disc.O"]
[joints.slot]
type = "slot"
connect = ["disc.O", "bead.P"]
{slot}
[drivers.motor]
joint = "axis"
angle = "{w}*t"
[initial]
bead = {{ x = {r}, y = {-c}, vx = {w * c}, vy = {w * r}, omega = 0 }}
""")


def in_slot(r, w=3.0):
    """Place of the rotor's bead along and across its slot [m]."""
    c, s = np.cos(w * r.t), np.sin(w * r.t)
    return c * r["bead.x"] + s * r["bead.y"], c * r["bead.y"] - s * r["bead.x"]


# ---------------------------------------------------------------- without play
@nojit
def test_scotch_yoke_is_a_cosine_and_its_forces_are_those_of_the_harmonic_motion():
    t = np.linspace(0.0, 0.0628, 40)
    r = scotch_yoke().inverse_dynamics(t)
    assert r["yoke.x"] == pytest.approx(0.05 * np.cos(100 * t), abs=1e-15)
    assert r["slot.fx"] == pytest.approx(500 * np.cos(100 * t), abs=1e-10)  # force on the pin: that of the yoke turned
    assert r["motor.torque"] == pytest.approx(12.5 * np.sin(200 * t), abs=1e-10)  # m r^2 w^2 / 2
    assert "slot.moment" not in r


@nojit
def test_slotted_wheel_turns_as_that_of_geneva():
    """Four slots: C/r = sqrt 2; tan b = sin a / (m - cos a), b' and b'' by derivation."""
    text = """
format = 1
[ground.points]
O = [0, 0]
C = [0.1, 0]
[bodies.crank]
points = { O = [0, 0], P = ["0.1/sqrt(2)", 0] }
mass = 1
inertia = 1e-3
[bodies.wheel]
points = { C = [0, 0] }
mass = 1
inertia = 2e-3
[joints.axis]
type = "revolute"
connect = ["ground.O", "crank.O"]
[joints.hub]
type = "revolute"
connect = ["ground.C", "wheel.C"]
[joints.slot]
type = "slot"
connect = ["wheel.C", "crank.P"]
axis = "180 deg"
[drivers.motor]
joint = "axis"
angle = "2*t - 0.7"
"""
    m, t = math.sqrt(2.0), np.linspace(0.0, 0.7, 29)
    r = rt.loads(text).kinematics(t)
    a, w = 2 * t - 0.7, 2.0
    below = 1 + m * m - 2 * m * np.cos(a)
    assert r["wheel.angle"] == pytest.approx(-np.arctan2(np.sin(a), m - np.cos(a)), abs=1e-14)
    assert r["wheel.omega"] == pytest.approx(-w * (m * np.cos(a) - 1) / below, abs=1e-13)
    assert r["wheel.alpha"] == pytest.approx(-w * w * m * np.sin(a) * (1 - m * m) / below**2, abs=1e-10)
    assert abs(r["wheel.omega"]).max() / w == pytest.approx(1 / (m - 1), rel=1e-12)  # on the line of centres


@nojit
def test_pin_is_driven_along_its_slot():
    m = bead("", "x = 0.2, y = 0", axis="30 deg", extra='[drivers.push]\njoint = "slot"\nposition = "0.2 + 0.1*t**2"\n')
    assert m.check().mobility == 1  # it may turn
    r = m.simulate(1.0, method="rk4", step=0.1)
    assert r["bead.x"] == pytest.approx((0.2 + 0.1 * r.t**2) * math.cos(math.pi / 6), abs=1e-12)
    assert r["push.force"] == pytest.approx(2 * 0.2, rel=1e-12)


@nojit
def test_bead_on_a_spring_hangs_where_its_weight_stretches_it():
    spring = '[loads.s]\ntype = "spring"\nconnect = ["ground.A", "bead.P"]\nstiffness = 100\nfree_length = 0.5\n'
    held = '[drivers.straight]\nbody = "bead"\ncoordinate = "angle"\nangle = 0\n'
    for slot in ("", with_play(0.01, '{ model = "impact" }', 4.0)):
        found = bead(slot, "x = 0, y = 0", 10.0, "90 deg", spring + held).equilibrium()
        stable = [one for one in found if one.stable]
        hanging, standing = 1 - 0.5 - 0.2, 1 + 0.5 - 0.2  # the slot holds it upright on the spring as well
        assert [one["bead.y"] for one in stable] == pytest.approx([hanging, standing], abs=1e-9)


# ---------------------------------------------------------------- the file
@nojit
def test_contact_that_does_not_fit_a_slot_is_refused_with_what_does():
    with pytest.raises(rt.ModelError, match=r"'massless-link' does not work on a slot joint; .* ideal, impact, exact"):
        scotch_yoke(with_play(1e-4, '"massless-link"'))
    given = '{ model = "hertz", bush_radius = 0.01, bush_material = "steel", pin_material = "steel" }'
    with pytest.raises(rt.ModelError, match="a slot needs stiffness and exponent"):
        scotch_yoke(with_play(1e-4, given))
    with pytest.raises(rt.ModelError, match="needs bush_radius in m: friction depends on it"):
        scotch_yoke(with_play(1e-4, '{ model = "impact", friction = 0.1 }'))


@nojit
def test_accuracy_of_a_yoke_is_the_clearance_of_its_slot():
    for contact in ('"ideal"', '{ model = "impact" }'):
        found = scotch_yoke(with_play(1e-4, contact, 0.12)).accuracy("yoke.x", [0.0, 0.01])
        assert found.contributions[:, 0] == pytest.approx(1e-4, rel=1e-12)
        assert found.high - found.nominal == pytest.approx(1e-4, rel=1e-9)
        assert found.low - found.nominal == pytest.approx(-1e-4, rel=1e-9)
        speed = scotch_yoke(with_play(1e-4, contact, 0.12)).accuracy("yoke.vx", [0.01])
        assert speed.worst == pytest.approx(0.0, abs=1e-12)  # the play shifts the yoke, whatever its speed


# ---------------------------------------------------------------- with play
def billiard(c, length, v, e, t_end):
    """Times at which a point reflected with restitution e hits the outline around a line at the distance c."""
    x, v, t, hits = np.zeros(2), np.array(v), 0.0, []
    while True:
        found = []
        for side in (1.0, -1.0):
            if side * v[1] > 0.0:
                s = (c - side * x[1]) / (side * v[1])
                found.append((s, np.array([0.0, side]), abs(x[0] + s * v[0]) <= length / 2))
            d = x - [side * length / 2, 0.0]
            disc = (d @ v) ** 2 - (v @ v) * (d @ d - c * c)
            if disc > 0.0:
                s = (math.sqrt(disc) - d @ v) / (v @ v)
                found.append((s, (d + s * v) / c, side * (x[0] + s * v[0]) > length / 2))
        s, n = min((s, tuple(n)) for s, n, meets in found if meets and s > 1e-13)
        x, t = x + s * v, t + s
        if t > t_end:
            return hits
        v = v - (1.0 + e) * (np.array(n) @ v) * np.array(n)
        hits.append(t)


@pytest.mark.parametrize(
    ("c", "length", "v", "error"),
    # curved walls spread errors: what the step leaves grows at every hit of an end
    [(0.05, 0.4, (0.7, 1.0), 1e-10), (1e-3, 0.2, (3.0, 1.0), 1e-8), (0.05, 0.1, (1.0, 2.3), 1e-10)],
)
def test_pin_bounces_between_walls_and_round_ends_as_in_a_billiard(c, length, v, error):
    m = bead(with_play(c, '{ model = "impact", restitution = 0.9 }', length), f"x = 0, y = 0, vx = {v[0]}, vy = {v[1]}")
    t_end = 30 * c / v[1]
    r = m.simulate(t_end, rtol=1e-11, atol=1e-13)
    hits = billiard(c, length, v, 0.9, t_end)
    assert len(hits) > 8
    assert [one.t for one in r.events if one.kind == "impact"] == pytest.approx(hits, abs=error)
    assert r.trust.energy_balance < 1e-12


def test_bead_slides_along_the_wall_and_round_the_end_and_back():
    """Level wall, then a pendulum of length c round the centre of the end; from wall to end N jumps by m v^2 / c."""
    g, c, length, v = 10.0, 0.1, 0.5, 1.0
    m = bead(with_play(c, '"impact"', length), f"x = 0, y = {-c}, vx = {v}, vy = 0", g)
    t = np.linspace(0.0, 1.2, 1201)
    r = m.simulate(1.2, t_eval=t, rtol=1e-11, atol=1e-13)
    level = length / v

    def returned(_, y):
        return y[0]

    returned.terminal, returned.direction = True, -1.0
    swing = solve_ivp(
        lambda _, y: [y[1], -g / c * math.sin(y[0])], (0, 2), [0.0, v / c], rtol=1e-12, atol=1e-14, events=returned,
        dense_output=True,
    )  # fmt: skip
    around = swing.t_events[0][0]
    expected = []
    for now in t:
        turn, rest = divmod(now + 0.5 * level, level + around)
        x = -0.5 * length + v * rest if rest < level else 0.5 * length + c * math.sin(swing.sol(rest - level)[0])
        expected.append(x if turn % 2 == 0 else -x)
    assert r["bead.x"] == pytest.approx(expected, abs=1e-9)
    energy = r["energy.kinetic"] + r["energy.potential"]
    assert np.ptp(energy) < 1e-8  # of 1 J, over four jumps of the acceleration
    assert abs(r["slot.penetration"]).max() < 1e-14
    on_wall = t < 0.5 * level - 1e-9
    assert r["slot.normal"][on_wall] == pytest.approx(20.0, rel=1e-12)
    just_round = np.flatnonzero(~on_wall)[0] + 1
    lower = math.hypot(r["bead.vx"][just_round], r["bead.vy"][just_round]) ** 2 / c
    assert r["slot.normal"][just_round] == pytest.approx(2 * (lower + g), rel=1e-2)  # 1 ms up the end
    assert np.hypot(r["slot.ex"], r["slot.ey"]) == pytest.approx(c, abs=1e-13)


@pytest.mark.parametrize("moreau", [False, True])
def test_bead_in_a_turning_slot_is_thrown_out_as_a_hyperbolic_cosine(moreau):
    c, w = 0.01, 3.0
    m = rotor(with_play(c, '{ model = "impact" }'), c)
    how = {"method": "moreau", "step": 1e-5} if moreau else {"rtol": 1e-11, "atol": 1e-13}
    r = m.simulate(0.9, t_eval=np.linspace(0, 0.9, 91), **how)
    along, across = in_slot(r)
    assert along == pytest.approx(0.1 * np.cosh(w * r.t), abs=5e-5 if moreau else 1e-9)  # order 1 in the step
    assert across == pytest.approx(-c, abs=1e-14)
    normal = 2 * (2 * w * 0.1 * w * np.sinh(w * r.t) + w * w * c)  # Coriolis, and the pull off the axis
    assert r["slot.normal"][1:] == pytest.approx(normal[1:], rel=5e-3 if moreau else 1e-9)


@pytest.mark.parametrize("law", registry.kinds("normal"))
def test_every_compliant_law_holds_the_bead_near_its_wall_and_accounts_for_its_energy(law):
    kind, c = registry.kinds("normal")[law], 0.01
    if kind.leaf.__module__.endswith("contact_law"):
        pytest.skip("a law of a user")
    needed = "".join(f", {key} = 0.5" for key, one in kind.fields.items() if one.default is registry.REQUIRED)
    stiff = "stiffness = 1e7, exponent = 1.5" if law != "anagnostopoulos" else "stiffness = 1e7, exponent = 1"
    m = rotor(with_play(c, f'{{ model = "{law}"{needed}, {stiff} }}'), c)
    r = m.simulate(0.3)
    assert r.success, r.message
    along, across = in_slot(r)
    assert along == pytest.approx(0.1 * np.cosh(3.0 * r.t), abs=1e-3)  # the wall gives way by 0.1 mm
    assert across == pytest.approx(-c, abs=2e-4)
    assert r.trust.energy_balance < 1e-6


def test_impact_by_event_and_by_time_stepping_and_stiff_walls_agree_with_friction():
    t = np.linspace(0.0, 0.03, 301)
    rough = 'friction = 0.1, bush_radius = "5 mm"'
    event = scotch_yoke(with_play(1e-4, f'{{ model = "impact", restitution = 0.3, {rough} }}', 0.12))
    exact = event.simulate(0.03, t_eval=t, rtol=1e-10, atol=1e-12)
    assert sum(one.kind == "impact" for one in exact.events) > 5
    assert exact.trust.energy_balance < 1e-5
    stepped = event.simulate(0.03, t_eval=t, method="moreau", step=1e-6)
    assert stepped["yoke.x"] == pytest.approx(exact["yoke.x"], abs=1e-7)  # of a play of 1e-4 m
    deviations = []
    for stiffness in (1e9, 1e11):
        soft = f'{{ model = "exact", restitution = 0.3, stiffness = {stiffness}, exponent = 1.5, {rough} }}'
        r = scotch_yoke(with_play(1e-4, soft, 0.12)).simulate(0.03, t_eval=t)
        deviations.append(float(abs(r["yoke.x"] - exact["yoke.x"]).max()))
    assert deviations[1] < 0.3 * deviations[0]  # a hundred times as stiff: 4.6 times less deep
    assert deviations[1] < 2e-5


@pytest.mark.parametrize(("t_end", "rtol", "outputs"), [(5.0, 1e-8, 1001), (5.0, 1e-8, 2), (2.0, 1e-11, 38)])
def test_a_yoke_knocks_the_same_at_every_half_turn_for_minutes_of_angle(t_end, rtol, outputs):
    """Each series of bounces ends and is forgotten while the pin presses, so the motion has half the crank's period."""
    r = rt.example("scotch_yoke").simulate(t_end, t_eval=np.linspace(0.0, t_end, outputs), rtol=rtol)
    assert r.success, r.message
    begun, let_go = ([one.t for one in r.events if one.kind == kind] for kind in ("contact", "release"))
    assert len(let_go) == round(t_end * 100 / math.pi)  # the first after a quarter turn
    # the end of a series is known to a share of its last bounce followed, which takes 1e-8 s to 1e-7 s
    assert np.diff(begun[1:]) == pytest.approx(math.pi / 100, abs=1e-8)
    assert np.diff(let_go[1:]) == pytest.approx(math.pi / 100, abs=1e-10)
    assert any(note.startswith(f"{len(let_go)} infinite series of bounces were closed") for note in r.trust.notes)
    losses = [
        sum(one.energy_lost for one in r.events if start < one.t <= start + math.pi / 100) for start in let_go[1:-1]
    ]
    assert losses == pytest.approx([losses[0]] * len(losses), rel=1e-6)


@pytest.mark.parametrize("friction", ["", ", friction = 0.1, bush_radius = 5e-3"])
@pytest.mark.parametrize("how", [{}, {"method": "moreau", "step": 1e-5}])
def test_a_crank_that_pushes_its_pin_into_the_end_of_its_slot_names_the_dead_end(how, friction):
    """The crank cannot pass asin((30 + 0.1)/50): there the end of the slot stands across the yoke's rail."""
    r = scotch_yoke(with_play(1e-4, f'{{ model = "impact", restitution = 0.3{friction} }}', 0.06)).simulate(0.02, **how)
    assert not r.success
    assert r.trust.t_end == pytest.approx(math.asin(0.602) / 100, abs=2e-5)
    if how and friction:
        assert "Painleve" in r.message
    else:
        assert "dead end" in r.message
        assert "drivers" in r.message  # that push on


def test_slot_is_compared_saved_and_drawn_with_its_walls_and_its_pin(tmp_path):
    m = scotch_yoke(with_play(1e-4, '{ model = "impact", restitution = 0.3, bush_radius = 5e-3 }', 0.12))
    found = m.compare(t_end=0.01)
    assert list(found.results) == ["ideal", "one-sided impact", "compliant"]
    assert "'massless-link' does not work" in found.skipped["massless link"]
    assert any("pin in its slot" in ax.get_title() for ax in found.figure().axes)
    plt.close("all")
    m.simulate(0.001).save(tmp_path / "yoke.nc")
    r = rt.load_result(tmp_path / "yoke.nc")
    figure, ax = plt.subplots()
    draw_at(ax, r, 0)
    outlines = [
        line.get_xydata() for line in ax.lines if line.get_zorder() in (4.0, 5.0) and len(line.get_xydata()) > 15
    ]
    (outline,) = [one for one in outlines if np.ptp(one[:, 1]) > 0.02]
    assert np.ptp(outline, axis=0) == pytest.approx([0.01, 0.12 + 0.01], rel=1e-9)  # width, length over the ends
    (pin,) = [one for one in outlines if np.ptp(one[:, 1]) < 0.02]
    assert np.ptp(pin, axis=0).max() == pytest.approx(2 * (5e-3 - 1e-4), rel=0.02)  # a polygon
    plt.close(figure)


def test_a_slot_without_contacts_says_where_the_pin_leaves_it():
    """The pin of the yoke goes to +-50 mm; the slot is 60 mm long between the centres of its ends."""
    run = scotch_yoke(with_play(length=0.06)).simulate(0.06)
    (note,) = [one for one in run.trust.notes if "beyond its ends" in one]
    assert "joint 'slot' goes beyond its ends, by up to 0.02 m" in note
    first = float(note.split("t = ")[1].split(" s")[0])
    assert first == pytest.approx(math.asin(0.6) / 100, abs=1e-4)
    assert not [one for one in scotch_yoke(with_play(length=0.12)).simulate(0.06).trust.notes if "ends" in one]


def test_an_equilibrium_says_that_the_ends_of_a_slot_are_left_out():
    found = scotch_yoke(with_play(length=0.06)).equilibrium()
    assert "the ends of 'slot' and the play there are left out" in found.note
    assert "ends" not in scotch_yoke().equilibrium().note


@pytest.mark.machine
@nojit
def test_positions_beyond_the_ends_of_a_slot_are_noted_by_every_analysis_of_a_driven_mechanism():
    """The pin of the yoke goes to +-50 mm, beyond 30 mm from asin 0.6 on; a slot of 120 mm holds it."""
    t = np.linspace(0.0, 0.0628, 629)
    first = math.asin(0.6) / 100
    short, long = (scotch_yoke(with_play(1e-4, '{ model = "impact" }', length)) for length in (0.06, 0.12))
    for m, leaves in ((short, True), (long, False)):
        said = [one.trust.notes for one in (m.ideal().kinematics(t), m.ideal().inverse_dynamics(t))]
        said.append(m.accuracy("yoke.x", t[::10]).notes)
        for notes in said:
            found = [one for one in notes if "joint 'slot' goes beyond its ends, by up to 0.02 m" in one]
            assert len(found) == leaves
            if leaves:
                assert 0.0 <= float(found[0].split("t = ")[1].split(" s")[0]) - first < 1e-3
    assert "the ends of 'slot' are left out of the range" in str(short.check())


@nojit
def test_check_says_that_a_slot_without_length_is_a_line_without_ends():
    endless = "ends: slot, a line without ends, which its pin never leaves"
    assert endless in str(scotch_yoke().check())
    assert endless not in str(scotch_yoke(with_play(length=0.12)).check())


@nojit
def test_check_names_a_start_beyond_the_ends_of_a_slot():
    def at(x):
        return str(bead(with_play(length=0.4), f"x = {x}, y = 0").check())

    assert "start: joint 'slot' goes beyond its ends, by up to 0.1 m" in at(0.3)
    assert "ends, by" not in at(0.19)


@nojit
def test_no_equilibrium_of_a_bead_that_rests_at_the_end_of_its_slot_has_that_as_a_reason():
    found = bead(with_play(0.01, '{ model = "impact" }', 0.4), "x = 0, y = 0", 10.0, "60 deg").equilibrium()
    assert not found
    assert "the ends of 'slot' and the play there are left out: where a pin rests at an end" in found.note
    with pytest.raises(ValueError, match="no equilibrium was found at t = 0 s: the ends of 'slot'"):
        found.first_at(0.0)


# ---------------------------------------------------------------- friction without play
@nojit
@pytest.mark.parametrize("mu", [0.1, pytest.param(0.4, marks=pytest.mark.machine)])
def test_friction_in_the_slot_of_a_yoke_takes_the_moment_that_virtual_work_says(mu):
    """N = m r w^2 cos, sliding at r w cos: M = m r^2 w^2 (sin cos + mu cos^2), in inverse dynamics and in a run."""
    t = np.linspace(0.0, 0.0628, 101)
    m = scotch_yoke(f"friction = {mu}")
    c, s = np.cos(100 * t), np.sin(100 * t)
    for r in (m.inverse_dynamics(t), m.simulate(0.0628, t_eval=t)):
        assert r["motor.torque"] == pytest.approx(25 * (s * c + mu * c * c), abs=1e-6)
    assert r["energy.dissipated"][-1] == pytest.approx(25 * mu * math.pi, rel=1e-2)  # a turn but 0.2 deg
    table = r.power().elements
    assert float(table[table["element"] == "slot"]["lost"].iloc[0]) == pytest.approx(25 * mu * math.pi, rel=1e-2)


def on_a_slope(mu, static=None, extra=""):
    rubs = (
        f"friction = {mu}" if static is None else f'friction = {{ model = "coulomb", mu = {mu}, mu_static = {static} }}'
    )
    return bead(rubs, "x = 0, y = 0", 10.0, "20 deg", extra)


SLOPE = math.radians(20.0)


@nojit
@pytest.mark.parametrize("mu", [0.2, 0.5])
def test_a_pin_slides_down_its_slot_or_sticks_as_a_block_on_a_slope(mu):
    r = on_a_slope(mu).simulate(1.0)
    down = max(10.0 * (math.sin(SLOPE) - mu * math.cos(SLOPE)), 0.0)
    way = -(r["bead.x"] * math.cos(SLOPE) + r["bead.y"] * math.sin(SLOPE))
    assert way == pytest.approx(0.5 * down * r.t**2, abs=1e-9)
    assert r["energy.dissipated"][-1] == pytest.approx(mu * 20.0 * math.cos(SLOPE) * way[-1], abs=1e-8)
    rubs = 20.0 * (mu * math.cos(SLOPE) if down else math.sin(SLOPE))
    assert abs(r["slot.friction"][1:]) == pytest.approx(rubs, rel=1e-9)
    assert r.trust.energy_balance < 1e-9


@nojit
def test_a_stuck_pin_breaks_away_at_its_coefficient_at_rest():
    """Pulled down the slot by a growing force: it slides from F = m g (mu_static cos - sin) on."""
    along = '[loads.pull]\ntype = "force"\nat = "bead.P"\nforce = ["-10*t*cos(pi/9)", "-10*t*sin(pi/9)"]\n'
    r = on_a_slope(0.5, 0.6, along).simulate(1.0)
    (breaks,) = [one.t for one in r.events if one.kind == "slip"]
    assert breaks == pytest.approx(20.0 * (0.6 * math.cos(SLOPE) - math.sin(SLOPE)) / 10.0, rel=1e-9)


@nojit
def test_friction_in_a_slot_holds_a_pin_between_two_pulls_and_by_itself_beyond_its_angle():
    held = '[drivers.straight]\nbody = "bead"\ncoordinate = "angle"\nangle = 0\n'
    pull = f'[loads.pull]\ntype = "force"\nat = "bead.P"\nforce = ["{math.cos(SLOPE)}", "{math.sin(SLOPE)}"]\n'
    for mu in (0.2, 0.5):
        found = on_a_slope(mu, extra=held + pull).holds("pull")
        ends = [20.0 * (math.sin(SLOPE) + sense * mu * math.cos(SLOPE)) for sense in (-1.0, 1.0)]
        assert (found.low, found.high) == pytest.approx(tuple(ends), rel=1e-9)
        assert found.self_locking == (mu > math.tan(SLOPE))


@nojit
@pytest.mark.parametrize(
    ("joint", "words"),
    [
        ('"rod"\nlength = 0.1', "needs pin_radius"),
        ('"gear"\nradii = [0.1, 0.1]', "needs module"),
        ('"rack"\nradius = 0.1', "needs module"),
        ('"fixed"', "expected .*prismatic.*slot"),
    ],
)
def test_joints_whose_friction_cannot_be_told_say_why(joint, words):
    ends = "[ground.points]\nO = [0, 0]\n[bodies.b]\npoints = { P = [0, 0] }\nmass = 1\ninertia = 1\n"
    text = f'format = 1\n{ends}[joints.j]\ntype = {joint}\nconnect = ["ground.O", "b.P"]\nfriction = 0.1\n'
    with pytest.raises(rt.ModelError, match=words):
        _ = rt.loads(text).model
