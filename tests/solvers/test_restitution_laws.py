"""Restitution of velocities, of impulses and of work: closed forms, an incremental reference, and energy."""

import numpy as np
import pytest

import rattle as rt

LAWS = ("newton", "poisson", "energetic")


def struck(law, e, mu, spin=0.0, slide=-1.0, arm=(0.6, -0.8), inertia=0.08, corners=False) -> rt.Mechanism:
    """A rod of 1 kg whose end is about to hit rough ground below it with 1 m/s; no gravity.

    arm: the end, seen from the mass centre [m]; slide: speed of the end along the ground [m/s].  The ground is the
    lowest place of a bush of 1 m; or, with corners, the wall of a guide and the end a block of 0.1 mm with two corners.
    """
    x, y = arm
    above = -1 + 1e-10 - y  # a hit within a billionth of the mechanism is one at once
    joint = """type = "revolute"
contact = { bush_radius = 1.000001, """
    if corners:
        joint = """type = "prismatic"
block = { length = 1e-4, height = 1e-4 }
contact = { """
    return rt.loads(f"""
format = 1
gravity = [0, 0]
[ground.points]
O = [0, 0]
[bodies.rod]
points = {{ P = [{x}, {y}] }}
mass = 1
inertia = {inertia}
[joints.tip]
connect = ["ground.O", "rod.P"]
clearance = 1
{joint}model = "impact", restitution = {e}, friction = {mu}, restitution_law = "{law}" }}
[initial]
rod = {{ x = {-x}, y = {above}, angle = 0, vx = {slide + spin * y}, vy = {-1 - spin * x}, omega = {spin} }}
""")


def after(m, arm=(0.6, -0.8), t=1e-7):
    """Velocity of the end after its one impact, at t = 0, and the sum of its percussions."""
    r = m.simulate(t, t_eval=[t], rtol=1e-10)
    assert r.success, r.message
    hits = [one for one in r.events if one.kind == "impact"]
    assert {one.t for one in hits} == {0.0}
    w, angle = r["rod.omega"][-1], r["rod.angle"][-1]
    x = arm[0] * np.cos(angle) - arm[1] * np.sin(angle)
    y = arm[0] * np.sin(angle) + arm[1] * np.cos(angle)
    return np.array([r["rod.vx"][-1] - w * y, r["rod.vy"][-1] + w * x]), sum(one.impulse for one in hits)


def incremental(e, mu, arm, inertia, slide, steps=400_000):
    """Darboux and Keller's equations in small increments of the normal impulse, ended by Stronge's work."""
    x, y = arm
    g = np.array([[1 + x * x / inertia, -x * y / inertia], [-x * y / inertia, 1 + y * y / inertia]])  # (n, t)
    rate, slip = -1.0, slide
    step = 3.0 / g[0, 0] / steps
    total, held, work, target = 0.0, 0.0, 0.0, None
    for _ in range(50 * steps):
        hold = -g[0, 1] / g[1, 1]
        if abs(slip) > 2 * mu * g[1, 1] * step:
            share = -mu * np.sign(slip)
        elif abs(hold) <= mu:
            share = hold - slip / (g[1, 1] * step)
        else:
            share = np.clip(hold, -mu, mu)
        old = rate
        rate += (g[0, 0] + g[0, 1] * share) * step
        slip += (g[0, 1] + g[1, 1] * share) * step
        total, held, work = total + step, held + share * step, work + 0.5 * (old + rate) * step
        if target is None and rate >= 0.0:
            target, work = -(e**2) * work, 0.0
        elif target is not None and work >= target:
            return np.array([slip, rate]), total, held
    raise AssertionError("the increments are too small")


def slider(n, e, law) -> rt.Mechanism:
    """n equal balls on a line that touch each other; the first comes in with 1 m/s."""
    text = "format = 1\ngravity = [0, 0]\n[ground.points]\nO = [0, 0]\n"
    joints, start = "", "[initial]\n"
    for k in range(n):
        text += f"[bodies.b{k}]\nmass = 1\ninertia = 1\npoints = {{ P = [0, 0] }}\n"
        joints += f'[joints.g{k}]\ntype = "prismatic"\nconnect = ["ground.O", "b{k}.P"]\naxis = 0\nangle = 0\n'
        start += (
            f"b{k} = {{ x = {-1e-3 * k - (1e-6 if k == 0 else 0)}, y = 0, angle = 0, vx = {1.0 if k == 0 else 0.0} }}\n"
        )
    for k in range(n - 1):
        joints += f"""[joints.c{k}]
type = "revolute"
connect = ["b{k + 1}.P", "b{k}.P"]
clearance = 1e-3
contact = {{ model = "impact", restitution = {e}, restitution_law = "{law}" }}
"""
    return rt.loads(text + joints + start)


# ---------------------------------------------------------------- where all laws agree
@pytest.mark.parametrize("e", [0.0, 0.4, 1.0])
def test_laws_agree_without_friction_at_one_contact(e):
    found = [after(struck(law, e, 0.0, spin=3.0))[0] for law in LAWS]
    assert found[0][1] == pytest.approx(e, abs=1e-5)  # the arm turns on between impact and output
    assert found[1] == pytest.approx(found[0], abs=1e-12)
    assert found[2] == pytest.approx(found[0], abs=1e-12)


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("law", LAWS)
def test_three_balls_part_as_their_closed_form_says(law, e):
    r = slider(3, e, law).simulate(1e-3, t_eval=[1e-3])
    got = [r[f"b{k}.vx"][-1] for k in range(3)]
    assert got == pytest.approx([(1 - 2 * e) / 3, (1 + e) / 3, (1 + e) / 3], abs=1e-12)


# ---------------------------------------------------------------- friction
@pytest.mark.parametrize("e", [0.3, 0.8])
def test_poisson_gives_back_a_share_of_the_impulse_of_compression(e):
    struck_once = [after(struck("poisson", one, 0.3, slide=-1.0))[1] for one in (0.0, e)]
    assert struck_once[1] / struck_once[0] == pytest.approx(1 + e, rel=1e-12)


def test_energetic_impact_with_slip_that_turns_around_meets_the_closed_form():
    # G = [n, -k; -k, t]: slip ends in compression after N_1, turns around, and friction helps from then on
    e, mu, arm, inertia, slide = 0.5, 0.3, (0.6, -0.8), 0.08, -0.5
    n, t, k = 1 + arm[0] ** 2 / inertia, 1 + arm[1] ** 2 / inertia, -arm[0] * arm[1] / inertia
    assert k / t > mu  # it does not stick
    ended = -slide / (k + mu * t)
    speed = -1 + (n + mu * k) * ended
    assert speed < 0
    work = ended * (speed - 1) / 2
    compressed = -speed / (n - mu * k)
    work += compressed * speed / 2
    expanded = np.sqrt(-2 * e**2 * work / (n - mu * k))
    wanted = ((k - mu * t) * (compressed + expanded), (n - mu * k) * expanded)
    got, total = after(struck("energetic", e, mu, slide=slide))
    assert total == pytest.approx(ended + compressed + expanded, rel=1e-6)  # the bush is round: its wall leans by 1e-4
    assert got == pytest.approx(wanted, abs=1e-4)


@pytest.mark.parametrize(
    ("mu", "slide"),
    [
        (0.3, -1.0),
        (1.0, 0.3),
        (3.0, 0.2),
        *(pytest.param(*one, marks=pytest.mark.long) for one in ((0.3, 1.0), (1.0, -0.3))),
    ],
)
def test_energetic_impact_with_friction_is_the_limit_of_small_increments(mu, slide):
    e, arm, inertia = 0.6, (0.6, -0.8), 0.08
    velocity, total = after(struck("energetic", e, mu, slide=slide))
    wanted, pressed, _ = incremental(e, mu, arm, inertia, slide)
    assert velocity == pytest.approx(wanted, abs=2e-4)  # increments, and the lean of the bush
    assert total == pytest.approx(pressed, rel=2e-4)


def test_two_corners_at_the_same_place_share_what_one_contact_gets():
    one = after(struck("energetic", 0.6, 0.3, slide=-1.0))[0]
    two = after(struck("energetic", 0.6, 0.3, slide=-1.0, corners=True))[0]
    assert two == pytest.approx(one, abs=2e-3)  # they are 0.1 mm apart on an arm of 1 m


# ---------------------------------------------------------------- energy
def impacts(r):
    """Energy lost [J] at every instant with an impact, all its contacts together, and how many contacts took part."""
    lost, count = {}, {}
    for one in r.events:
        if one.kind == "impact":
            lost[one.t] = lost.get(one.t, 0.0) + one.energy_lost
            count[one.t] = count.get(one.t, 0) + 1
    return np.array(list(lost.values())), np.array(list(count.values()))


def random_chain(rng, law) -> rt.Mechanism:
    """A hanging chain of two to five bars with play in its pins, rough and springy."""
    n = int(rng.integers(2, 6))
    text, joints, start = "format = 1\ngravity = [0, -9.81]\n[ground.points]\nO = [0, 0]\n", "", "[initial]\n"
    e, mu = rng.uniform(0, 1), rng.uniform(0.05, 1.5)
    for k in range(n):
        text += f'[bodies.b{k}]\nbar = ["P", "Q"]\nlength = {rng.uniform(0.1, 0.3)}\nmass = {rng.uniform(0.1, 1)}\n'
        start += f"b{k} = {{ angle = {rng.uniform(-2, -1)}, omega = {rng.uniform(-5, 5)} }}\n"
        joints += f"""[joints.j{k}]
type = "revolute"
connect = ["{f"b{k - 1}.Q" if k else "ground.O"}", "b{k}.P"]
clearance = 1e-3
contact = {{ model = "impact", restitution = {e}, friction = {mu}, bush_radius = 0.01, restitution_law = "{law}" }}
"""
    return rt.loads(text + joints + start)


def random_block(rng, law) -> rt.Mechanism:
    """A tumbling block thrown onto the floor: two corners, often at once."""
    e, mu = rng.uniform(0, 1), rng.uniform(0, 2)
    return rt.loads(f"""
format = 1
gravity = [0, -9.81]
[ground.points]
O = [0, 0]
[bodies.block]
points = {{ P = [{rng.uniform(-0.02, 0.02)}, 0] }}
mass = 1
inertia = {rng.uniform(2e-4, 3e-3)}
[joints.floor]
type = "prismatic"
connect = ["ground.O", "block.P"]
axis = 0
angle = 0
clearance = 0.2
block = {{ length = {rng.uniform(0.02, 0.1)}, height = {rng.uniform(0.02, 0.1)} }}
contact = {{ model = "impact", restitution = {e}, friction = {mu}, restitution_law = "{law}" }}
[initial.block]
x = 0
y = 0
angle = {rng.uniform(-0.5, 0.5)}
vx = {rng.uniform(-2, 2)}
vy = {rng.uniform(-2, 0)}
omega = {rng.uniform(-3, 3)}
""")


def test_no_energetic_impact_gives_energy():
    rng = np.random.default_rng(8)
    several = 0
    for turn in range(24):
        m = (random_chain if turn % 2 else random_block)(rng, "energetic")
        r = m.simulate(0.3, rtol=1e-7)
        lost, count = impacts(r)
        several += int((count > 1).sum())
        size = max(1e-3, float(np.abs(r["energy.kinetic"]).max()))
        assert lost.min(initial=0.0) > -1e-13 * size  # rounding of the sum over contacts
        assert "created energy" not in " ".join(r.trust.notes)
        assert r.trust.energy_balance < 1e-4 * size  # what the events say is what the motion does
    assert several > 100


def test_newton_gives_energy_where_the_energetic_law_does_not():
    # two free bodies, e = 1 and friction: the second impact under Newton's law
    pair = """
format = 1
gravity = [0, 0]
[bodies.a]
points = { P = ["30 mm", "10 mm"] }
mass = 2
inertia = 3e-3
[bodies.b]
points = { P = ["-20 mm", 0] }
mass = 0.5
inertia = 1e-4
[joints.J]
type = "revolute"
connect = ["a.P", "b.P"]
clearance = "1 mm"
contact = { model = "impact", restitution = 1, friction = 0.1, bush_radius = "10 mm" }
[initial]
a = { x = 0, y = 0, angle = 0, vx = 0.3, vy = 0.1, omega = 2 }
b = { x = "50.3 mm", y = "10.2 mm", angle = 0, vx = -0.4, vy = 0.2, omega = -15 }
"""
    newton = rt.loads(pair)
    assert impacts(newton.simulate(0.02))[0].min() < -0.01
    energetic = newton.set({"joints.J.contact.restitution_law": "energetic"}).simulate(0.02)
    assert len(impacts(energetic)[0]) > 5
    assert impacts(energetic)[0].min() > -1e-16
    assert np.diff(energetic["energy.kinetic"]).max() < 1e-12


# ---------------------------------------------------------------- what is refused
def test_moreau_jean_with_another_law_is_refused_before_the_run():
    with pytest.raises(rt.ModelError, match='"poisson" works with method "event" only'):
        slider(3, 0.5, "poisson").simulate(1e-3, method="moreau")


def test_one_law_for_all_joints():
    m = slider(3, 0.5, "poisson").set({"joints.c1.contact.restitution_law": "energetic"})
    with pytest.raises(rt.ModelError, match="c0: poisson, c1: energetic"):
        m.simulate(1e-3)


@pytest.mark.nojit
def test_tangential_restitution_belongs_to_newton():
    m = struck("newton", 0.5, 0.3).set({"joints.tip.contact.tangential_restitution": 0.5})
    with pytest.raises(rt.ModelError, match='works with restitution_law = "newton" only'):
        m.set({"joints.tip.contact.restitution_law": "energetic"})


@pytest.mark.nojit
def test_law_is_kept_in_the_model_file_and_across_contact_models():
    m = struck("energetic", 0.5, 0.3)
    assert rt.loads(m.to_toml()).to_toml() == m.to_toml()
    assert "energetic" in m.with_contact("impact").to_toml()
    with pytest.raises(rt.ModelError, match="expected one of newton, poisson, energetic"):
        m.set({"joints.tip.contact.restitution_law": "stronge"})
