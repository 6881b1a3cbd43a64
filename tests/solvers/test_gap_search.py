"""No contact is missed: free flight at any spin, rotors, hops of nanometres, guides that turn over."""

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

import rattle as rt
from rattle.jit import functions
from rattle.jit.functions import KernelFunction
from rattle.solvers.contacts import gap_search

IMPACT = '{ model = "impact", restitution = 0.5, friction = 0.1, bush_radius = 0.01 }'
HERTZ = '{ model = "hunt-crossley", restitution = 0.5, stiffness = 1e9, bush_radius = 0.01 }'


def first_root(f, t_end, dt):
    """First t at which f, which starts below zero, is zero: looked for at steps dt, vectorised."""
    t = np.arange(0.0, t_end + dt, dt)
    k = int(np.argmax(f(t) >= 0.0))
    assert k > 0, "no contact in this time"
    return brentq(lambda x: f(np.array([x]))[0], t[k - 1], t[k], xtol=1e-16, rtol=1e-14)


def starts(r, kind):
    """Times at which contacts start: impacts, or the beginnings of compliant contacts."""
    return [one.t for one in r.events if one.kind == kind]


# ---------------------------------------------------------------- rotors
def rotor(omega, contact, g=0.0):
    return rt.loads(f"""
format = 1
gravity = [0.0, {-g}]
[ground.points]
O = [0.0, 0.0]
[bodies.R]
mass = 1.0
inertia = 0.001
points = {{ P = [0.0003, 0.0] }}
[joints.J]
type = "revolute"
connect = ["ground.O", "R.P"]
clearance = 0.0005
contact = {contact}
[initial]
R = {{ x = 0.0, y = 0.0, angle = 0.2, vx = 0.01, vy = 0.02, omega = {omega} }}
""")


@pytest.mark.parametrize("omega", [1000.0, 3000.0, 10000.0, 25000.0])
@pytest.mark.parametrize("g", [0.0, 9.81])
@pytest.mark.parametrize(("contact", "kind"), [(IMPACT, "impact"), (HERTZ, "contact")])
def test_an_unbalanced_rotor_first_touches_its_bush_when_its_path_says(omega, g, contact, kind):
    # |v t + g t^2 / 2 + rho e(w t)| = c, looked for 300 times a turn
    def beyond(t):
        x = 0.01 * t + 0.0003 * np.cos(0.2 + omega * t)
        y = 0.02 * t - 0.5 * g * t * t + 0.0003 * np.sin(0.2 + omega * t)
        return np.hypot(x, y) - 0.0005

    true = first_root(beyond, 0.05, 0.02 / omega)
    for rtol in (1e-6, 1e-8, 1e-11):
        for t_end in (0.05, 1.01 * true):
            r = rotor(omega, contact, g).simulate(t_end, rtol=rtol, t_eval=[0.0, t_end])
            # the angle is known to rounding of omega t: 1e-13 rad of 0.3 mm against an approach of 1 cm/s and more
            assert starts(r, kind)[0] == pytest.approx(true, abs=1e-11)


def test_a_rotor_in_a_compliant_bush_keeps_all_its_contacts_whatever_is_asked_of_the_run():
    runs = [
        rotor(10000.0, HERTZ).simulate(0.0125, rtol=rtol, t_eval=np.linspace(0.0, 0.0125, n))
        for rtol in (1e-7, 1e-9, 1e-11)
        for n in (2, 500)
    ]
    times = [starts(r, "contact") for r in runs]
    assert len(times[0]) >= 3
    for other in times:
        # contacts spread errors tenfold each
        assert other == pytest.approx(times[-1], abs=1e-7)


@pytest.mark.parametrize("joint", ['type = "revolute"', 'type = "slot", axis = 0'])
def test_play_of_nanometres_is_taken_up_at_every_half_period_of_the_block_on_its_two_springs(joint):
    K, m, v, t_end = 1e6, 1.0, 0.1, 0.05
    model = rt.loads(f"""
format = 1
gravity = [0, 0]
parameters = {{ c = 1e-9 }}
ground.points = {{ O = [0, 0] }}
bodies.block = {{ points = {{ C = [0, 0] }}, mass = {m}, inertia = 0.01 }}
[joints.B]
connect = ["ground.O", "block.C"]
clearance = "c"
{joint.replace(", ", chr(10))}
contact = {{ model = "hertz", stiffness = {K}, exponent = 1, damping = 0, bush_radius = 0.01 }}
[initial]
block = {{ x = 0, y = 0, angle = 0, vx = 0, vy = {v}, omega = 0 }}
""")
    plays = np.array([1e-9, 3e-9, 1e-8, 1e-7, 1e-6, 1e-5])
    numbers = range(1, 16)
    asked = [f"time(B.contacts, {k})" for k in numbers]
    beside = model.many({"c": plays}, asked, t_end=t_end)
    for i, c in enumerate(plays):
        own = c / v + np.arange(15) * (2.0 * c / v + math.pi * math.sqrt(m / K))
        alone = starts(model.set(c=c).simulate(t_end), "contact")
        np.testing.assert_allclose(alone[:15], own, rtol=0, atol=1e-8)
        np.testing.assert_allclose([beside[name][i] for name in asked], own, rtol=0, atol=1e-8)


@pytest.mark.parametrize(
    ("c", "K", "d", "v", "count"),
    [
        (3e-9, 3.7135e7, 243.8, 5.2383, 80),
        (1e-9, 1.02404e9, 0.0, 8.67041, 79),
        (7.90513e-10, 2.12844e8, 0.0, 6.16548, 41),
    ],
)
def test_a_flight_of_a_ten_millionth_of_a_step_ends_at_the_other_wall(c, K, d, v, count):
    half_period = math.pi / math.sqrt(K)
    r = rt.loads(f"""
format = 1
gravity = [0, -9.81]
ground.points = {{ O = [0, 0] }}
bodies.pin = {{ points = {{ P = [0, 0] }}, mass = 1, inertia = 1e-3 }}
[joints.B]
type = "revolute"
connect = ["ground.O", "pin.P"]
clearance = {c}
contact = {{ model = "kelvin-voigt", stiffness = {K}, damping = {d}, exponent = 1, bush_radius = 0.01 }}
[initial]
pin = {{ x = 0, y = 0, angle = 0, vx = 0, vy = {v}, omega = 0 }}
""").simulate((count // 2 + 0.5) * half_period, rtol=1e-11)
    assert r.success
    assert len(starts(r, "contact")) == count // 2 + 1


# ---------------------------------------------------------------- two free bodies
BODIES = {"m": (2.0, 0.7), "J": (0.003, 0.0008), "s": ((0.03, 0.01), (-0.02, 0.02))}
C, BORE, E_N, MU = 1e-3, 0.01, 0.73, 0.2


def pair(q, v):
    a, b = (
        f"{{ x = {x!r}, y = {y!r}, angle = {p!r}, vx = {vx!r}, vy = {vy!r}, omega = {w!r} }}"
        for (x, y, p), (vx, vy, w) in zip(q.reshape(2, 3).tolist(), v.reshape(2, 3).tolist(), strict=True)
    )
    return rt.loads(f"""
format = 1
gravity = [0.0, 0.0]
[bodies.A]
mass = 2.0
inertia = 0.003
points = {{ O = [0.03, 0.01] }}
[bodies.B]
mass = 0.7
inertia = 0.0008
points = {{ P = [-0.02, 0.02] }}
[joints.J]
type = "revolute"
connect = ["A.O", "B.P"]
clearance = {C}
contact = {{ model = "impact", restitution = {E_N}, friction = {MU}, bush_radius = {BORE} }}
[initial]
A = {a}
B = {b}
""")


def arms(q):
    """World arms of bush and pin centre, and the offset between them, at the rows q (..., 6)."""
    found = []
    for i, (x, y) in enumerate(BODIES["s"]):
        c, s = np.cos(q[..., 3 * i + 2]), np.sin(q[..., 3 * i + 2])
        found.append(np.stack([c * x - s * y, s * x + c * y], axis=-1))
    return *found, q[..., 3:5] + found[1] - q[..., 0:2] - found[0]


def bounce(q, v):
    """Rates after an impact with Newton's law and Coulomb friction: one contact, sticking tried first."""
    s_a, s_b, e = arms(q)
    n = e / np.hypot(*e)
    t = np.array([-n[1], n[0]])
    p_a, p_b = s_a + BORE * n, s_b + (BORE - C) * n

    def row(d):
        return np.array([*-d, -(p_a[0] * d[1] - p_a[1] * d[0]), *d, p_b[0] * d[1] - p_b[1] * d[0]])

    weight = 1 / np.array([BODIES["m"][0]] * 2 + [BODIES["J"][0]] + [BODIES["m"][1]] * 2 + [BODIES["J"][1]])
    w = np.array([row(n), row(t)])
    delassus = w * weight @ w.T
    u = w @ v
    f = np.linalg.solve(delassus, np.array([-(1 + E_N) * u[0], -u[1]]))
    if abs(f[1]) > MU * abs(f[0]):  # it slides: in the sense in which it goes on sliding
        for sense in (MU, -MU):
            normal = -(1 + E_N) * u[0] / (delassus[0, 0] + sense * delassus[0, 1])
            f = np.array([normal, sense * normal])
            if sense * (u[1] + delassus[1] @ f) > 0.0:
                break
    return v + weight * (w.T @ f), u[0]


def reference(q, v, slowest, most):
    """Times of impacts of the pair while they are faster than `slowest` [m/s], by brute force."""
    t, times = 0.0, []
    while len(times) < most:

        def beyond(x, q=q, v=v):
            return np.hypot(*arms(q + np.multiply.outer(x, v))[2].T) - C

        dt = 2e-3 / np.abs(v[[2, 5]]).max()
        skip = 1e-9 if times else 0.0  # it starts on the wall
        when = skip + first_root(lambda x, f=beyond, s=skip: f(x + s), 0.2, dt)
        t, q = t + when, q + when * v
        v, speed = bounce(q, v)
        # a bounce that rises for less than 100 looks of this reference is not followed
        if speed < slowest:
            break
        times.append(t)
    return times


def random_pair(rng, spin):
    q = np.array([0.0, 0.0, rng.uniform(-3, 3), 0.0, 0.0, rng.uniform(-3, 3)])
    s_a, s_b, _ = arms(q)
    q[3:5] = s_a - s_b + rng.uniform(-0.5e-3, 0.5e-3, 2)
    v = np.array([*rng.uniform(-0.5, 0.5, 2), spin[0], *rng.uniform(-0.5, 0.5, 2), spin[1]])
    return q, v


@pytest.mark.parametrize("spin", [(90.0, -360.0), (140.0, -560.0), (-30.0, 500.0), (12.0, 7.0), (0.0, 900.0)])
def test_two_spinning_bodies_hit_when_brute_force_says(spin):
    rng = np.random.default_rng(int(abs(spin[0])))
    for _ in range(3):
        q, v = random_pair(rng, spin)
        true = reference(q, v, 0.05, 6)
        assert len(true) >= 1
        for rtol in (1e-6, 1e-9):
            r = pair(q, v).simulate(0.05, rtol=rtol)
            # each impact spreads the rounding of the one before tenfold or so
            assert starts(r, "impact")[: len(true)] == pytest.approx(true, abs=1e-8)
            assert r["J.penetration"].max() < 1e-6 * C
            assert r.success


def test_end_step_and_outputs_do_not_change_which_contacts_are_found():
    q = np.array([0.0, 0.0, 0.3, 0.033668033072878176, -0.008721190918795266, -0.5])
    m = pair(q, np.array([0.1, 0.05, 90.0, -0.4, 0.3, -360.0]))
    asked = [
        {"t_end": 0.05},
        {"t_end": 0.004},
        {"t_end": 0.05, "t_eval": [0.0, 0.05]},
        {"t_end": 0.05, "rtol": 1e-6},
        {"t_end": 0.05, "rtol": 1e-11},
        {"t_end": 0.004, "step": 1e-5},
    ]
    runs = [m.simulate(**one) for one in asked]
    times = [[t for t in starts(r, "impact") if t < 0.0039] for r in runs]
    assert len(times[0]) > 20
    for other, r in zip(times, runs, strict=True):
        # the last bounces of the series are 1e-9 s apart
        assert other == pytest.approx(times[0], abs=1e-9)
        assert r["J.penetration"].max() < 1e-6 * C


# ---------------------------------------------------------------- hops of nanometres
LINK = 'contact = { model = "hunt-crossley", restitution = 0.8, stiffness = 1e8, exponent = 1.5, bush_radius = 0.01,'
LINK += ' friction = { model = "coulomb-smooth", mu = 0.1, v1 = 0.01 } }'
HANGING = "\n".join(
    [
        "format = 1\ngravity = [0.0, -9.81]\n[ground.points]\nG = [0.0, 0.0]",
        *(
            f"[bodies.b{k}]\nmass = 0.5\ninertia = 0.001666666666666667\npoints = {{ T = [-0.1, 0.0], B = [0.1, 0.0] }}"
            for k in range(3)
        ),
        *(
            f'[joints.p{k}]\ntype = "revolute"\nconnect = ["{end}", "b{k}.T"]\nclearance = 0.001\n{LINK}'
            for k, end in enumerate(["ground.G", "b0.B", "b1.B"])
        ),
        "[initial]",
        "b0 = { x = 0.03894183423086505, y = -0.09210609940028852, angle = -1.1707963267948966 }",
        "b1 = { x = 0.08856321617609035, y = -0.28364029976110383, angle = -1.4637967953450617 }",
        "b2 = { x = 0.06563440543473067, y = -0.4772516170709985, angle = -1.9135518281424755 }",
    ]
)


@pytest.mark.parametrize("t_end", [0.0575, 0.1, 0.3])
@pytest.mark.parametrize("rtol", [1e-7, 1e-8, 1e-9])
def test_a_hop_of_19_nanometres_is_found_at_any_tolerance_and_end(rtol, t_end):
    # independent integration: p1 lets go at .0570117 s, lands at .0571079 s with .811 mm/s
    r = rt.loads(HANGING).simulate(t_end, rtol=rtol, t_eval=[0.0, 0.057, t_end])
    hop = [e for e in r.events if e.joint == "p1" and 0.0569 < e.t < 0.0573 and e.kind in ("release", "contact")]
    assert [e.kind for e in hop] == ["release", "contact"]
    # a depth of 1e-8 m, known to rtol of the 0.5 m of the chain, moves these instants by a hundredth of the hop
    assert [e.t for e in hop] == pytest.approx([0.0570117, 0.0571079], abs=8e-6)
    assert hop[1].normal_speed == pytest.approx(0.811e-3, rel=0.15 if rtol > 5e-8 else 3e-3)


@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
def test_percussions_of_rounding_are_no_impacts(rtol):
    # a pendulum swings with its pin on the wall; a block that bounces elsewhere is no impact to it
    r = rt.loads("""
format = 1
gravity = [0.0, -10.0]
[ground.points]
O = [0.0, 0.0]
G = [1.0, 0.0]
[bodies.swing]
mass = 1.0
inertia = 0.01
points = { P = [0.0, 0.2] }
[bodies.block]
mass = 2.0
inertia = 0.001
points = { P = [0.0, 0.0] }
[joints.pin]
type = "revolute"
connect = ["ground.O", "swing.P"]
clearance = 0.001
contact = { model = "impact", restitution = 0.0, bush_radius = 0.01 }
[joints.guide]
type = "prismatic"
connect = ["ground.G", "block.P"]
axis = 0
clearance = 0.1
block = { length = 0.2, height = 0.02 }
contact = { model = "impact", restitution = 0.8 }
[initial]
swing = { x = 0.0, y = -0.201, angle = 0.0, omega = 1.0, vx = 0.201 }
block = { x = 1.0, y = 0.0, angle = 0.0 }
""").simulate(1.2, rtol=rtol)
    assert len(starts(r, "impact")) > 10
    late = [e for e in r.events if e.kind == "impact" and e.joint == "pin" and e.t > 0.05]
    assert late == []


# ---------------------------------------------------------------- guides that turn over
def spinning_block(omega, contact, vy, length, height, c):
    return rt.loads(f"""
format = 1
gravity = [0.0, 0.0]
[ground.points]
O = [0.0, 0.0]
[bodies.block]
mass = 1.0
inertia = 0.001
points = {{ P = [0.0, 0.0] }}
[joints.guide]
type = "prismatic"
connect = ["ground.O", "block.P"]
axis = 0.0
clearance = {c}
block = {{ length = {length}, height = {height} }}
contact = {contact}
[initial]
block = {{ x = 0.0, y = 0.0, angle = 0.0, vx = 0.3, vy = {vy}, omega = {omega} }}
""")


CORNERS = '{ model = "hunt-crossley", restitution = 0.5, stiffness = 1e9, exponent = 1.5 }'


@pytest.mark.parametrize(
    ("omega", "vy", "length", "height", "c"),
    [
        (50.0, 0.1, 0.08, 0.03, 0.03),  # half diagonal 42.7 mm, walls at 45 mm: turns over and over
        (-50.0, -0.1, 0.08, 0.03, 0.03),
        (5000.0, 0.11, 0.08, 0.03, 0.03),
        (20000.0, 0.05, 0.03, 0.08, 0.005),
        (3.0, 0.001, 0.08, 0.001, 0.0396),
    ],
)
@pytest.mark.parametrize(("contact", "kind"), [(IMPACT, "impact"), (CORNERS, "contact")])
def test_a_block_that_turns_over_hits_with_the_corner_that_is_there(omega, vy, length, height, c, contact, kind):
    a, b = 0.5 * length, 0.5 * height

    def beyond(t):
        s, k = np.abs(np.sin(omega * t)), np.abs(np.cos(omega * t))
        return np.abs(vy * t) + a * s + b * k - (b + c)

    true = first_root(beyond, 1.0, min(0.005 / abs(omega), 1e-3))
    contact = contact.replace(", bush_radius = 0.01", "")
    for rtol in (1e-6, 1e-10):
        r = spinning_block(omega, contact, vy, length, height, c).simulate(1.05 * true, rtol=rtol, t_eval=[0.0, true])
        # the corner moves at 0.1 m/s and more; a tip that grazes does so quadratically
        assert starts(r, kind)[0] == pytest.approx(true, abs=1e-9)
        assert r["guide.penetration"][-1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("turned", [0.0, math.pi / 2, math.pi, -math.pi / 2, 7 * math.pi])
def test_a_block_may_come_to_rest_on_any_of_its_sides(turned):
    m = rt.loads(f"""
format = 1
gravity = [0.0, -9.81]
[ground.points]
O = [0.0, 0.0]
[bodies.block]
mass = 1.0
inertia = 0.001
points = {{ P = [0.0, 0.0] }}
[joints.guide]
type = "prismatic"
connect = ["ground.O", "block.P"]
axis = 0.0
clearance = 0.025
block = {{ length = 0.06, height = 0.02 }}
contact = {{ model = "impact", restitution = 0.3, friction = 0.2 }}
[initial]
block = {{ x = 0.0, y = 0.0, angle = {turned!r} }}
""")
    r = m.simulate(0.5)
    half = 0.03 if abs(math.cos(turned)) < 0.5 else 0.01
    assert r["block.y"][-1] == pytest.approx(half - 0.035, abs=1e-12)
    assert r["guide.normal"][-1] == pytest.approx(9.81, rel=1e-9)


# ---------------------------------------------------------------- bounces as low as rounding
@pytest.mark.nojit
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("rise", [10.0, 100.0, 1e4])
def test_a_low_bounce_ends_where_it_returns_whatever_the_rounding_of_its_gap(side, rise, monkeypatch):
    """g = v t - a t^2/2 to 1e-16 m, with a gap of that size and either sign at the start."""
    noise, a, rng = 1e-16, 250.0, np.random.default_rng(3)
    v = math.sqrt(2.0 * a * rise * noise)
    flight = 2.0 * v / a

    def rounded(t):
        return v * t - 0.5 * a * t * t + rng.uniform(-noise, noise)

    monkeypatch.setattr(gap_search, "rounding", lambda m, n: 10.0 * noise)
    monkeypatch.setattr(gap_search, "gap_at", lambda m, share, n: (side * rounded(share), side * (v - a * share)))
    m = SimpleNamespace(clock=np.array([0.55]))
    for until in rng.uniform(1.2, 3.0, 50) * flight:
        found = gap_search.first_below.python(m, 1.0, 0, side, 0.0, rounded(0.0), v, until, rounded(until))
        assert found == pytest.approx(flight, abs=2.0 * noise / v)  # where the slope is v, the zero moves by noise / v


@pytest.mark.nojit
@pytest.mark.parametrize("place", [1.0, 100.0, 1e4])
def test_bounces_keep_their_restitution_down_to_the_rounding_of_the_place(place):
    """A bead on a slot of the ground: rounding of its gap grows with the distance, so the last bounce followed does."""
    slope = math.radians(35.0)
    x, y = place * math.cos(slope) + 1e-4 * math.sin(slope), place * math.sin(slope) - 1e-4 * math.cos(slope)
    m = rt.loads(f"""
format = 1
gravity = [0, -10]
[ground.points]
O = [0, 0]
[bodies.bead]
points = {{ P = [0, 0] }}
mass = 2
inertia = 1e-3
[joints.slot]
type = "slot"
connect = ["ground.O", "bead.P"]
axis = "35 deg"
clearance = 1e-4
contact = {{ model = "impact", restitution = 0.5 }}
[initial]
bead = {{ x = {x!r}, y = {y!r}, vx = {-1e-3 * math.sin(slope)!r}, vy = {1e-3 * math.cos(slope)!r} }}
""")
    r = m.simulate(0.01, t_eval=[0.0, 0.01])
    hits = [one for one in r.events if one.kind == "impact"]
    speed = np.array([one.normal_speed for one in hits])
    assert len(speed) >= 4
    assert speed[1:] / speed[:-1] == pytest.approx(0.5, rel=0.05)
    pull = 10.0 * math.cos(slope)
    (closed,) = [one.t for one in r.events if one.kind == "contact"]
    assert closed == pytest.approx(2e-3 / pull / (1.0 - 0.5), rel=1e-3)  # the end of the geometric series


# ---------------------------------------------------------------- never in silence
@pytest.mark.parametrize(("contact", "outputs"), [(IMPACT, 2), (IMPACT, 2000), (HERTZ, 2), (HERTZ, 2000)])
def test_a_contact_that_escapes_the_search_ends_the_run_with_joint_and_time(monkeypatch, contact, outputs):
    def blind(m, h, n, side, until):  # type: ignore[no-untyped-def]
        return 2.0

    found = gap_search.search
    assert found.address  # it has its place, at which machine code looks for it
    place = functions._places[found]
    monkeypatch.setattr(place, "value", KernelFunction(blind, letters=found.letters).address)
    r = rotor(1000.0, contact).simulate(0.05, t_eval=np.linspace(0.0, 0.05, outputs))
    assert not r.success
    assert "joint 'J'" in r.message
    assert "inside its wall" in r.message
    assert r.t[-1] < 0.0125
    assert r["J.penetration"].max() < 1e-6 * 5e-4


def test_moreau_says_how_deep_contacts_sank_into_their_walls():
    # 25000 rad/s: in 0.1 ms the pin goes 2.5 rad round and sinks most of the play, in 0.01 ms a thousandth
    coarse, fine = (rotor(25000.0, IMPACT).simulate(0.05, method="moreau", step=h) for h in (1e-4, 1e-5))
    deepest = 100 * coarse["J.penetration"].max() / 5e-4
    assert deepest > 10
    assert any("sank up to" in note for note in coarse.trust.notes)
    assert not any("sank" in note for note in fine.trust.notes)


@pytest.mark.parametrize("step", [1e-3, 2e-3])
def test_moreau_tells_a_depth_where_its_first_step_goes_through_a_wall(step):
    # shot at 10 m/s through 0.5 mm of play it hits at 0.05 ms; back at 5 m/s it is through the other wall in one step
    contact = {"model": "impact", "restitution": 0.5, "bush_radius": 0.01}
    m = rt.Mechanism("shot", gravity=[0, 0])
    m.ground(O=[0, 0])
    m.body("ball", mass=1.0, inertia=1.0, points={"P": [0, 0]})
    m.revolute("J", "ground.O", "ball.P", clearance=5e-4, contact=contact)
    m.initial("ball", x=0.0, y=0.0, angle=0.0, vx=10.0)
    r = m.simulate(0.1, method="moreau", step=step)
    assert not r.success
    depth = float(re.search(r"is (\S+) m inside its wall", r.message)[1])
    assert depth == pytest.approx(5.0 * (step - 5e-5) - 1e-3, rel=5e-3)  # three digits are told
