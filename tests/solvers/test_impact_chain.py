"""Impacts of chains by the distributing law: compliant chains, increments of impulse, energy, limits, refusals."""

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rattle as rt
from rattle.errors import ModelError


def chain(masses, rates, stiffness, exponent, restitution, more="", law="lzb"):
    """Balls in a row that touch: bodies on a line, each kept from the one before by a stop."""
    text = "format = 1\ngravity = [0, 0]\nground.points = { O = [0, 0] }\n"
    for i, (mass, rate) in enumerate(zip(masses, rates, strict=True)):
        contact = ""
        if i:
            contact = f"""stop = {{ min = 1, contact = {{ model = "impact", restitution = {restitution[i - 1]},
restitution_law = "{law}", stiffness = {stiffness[i - 1]}, exponent = {exponent} }} }}"""
        text += f"""
[bodies.ball{i}]
points = {{ C = [0, 0] }}
center = [0, 0]
mass = {mass}
inertia = 1
[joints.line{i}]
type = "prismatic"
connect = ["{f"ball{i - 1}.C" if i else "ground.O"}", "ball{i}.C"]
{contact.replace(chr(10), " ")}
[initial.ball{i}]
x = {i}
y = 0
angle = 0
vx = {rate}
"""
    return rt.loads(text + more)


def after(m):
    """Rates of all balls [m/s] after their impact at t = 0, and the run."""
    r = m.simulate(1e-3, t_eval=[0.0, 1e-3], rtol=1e-10)
    assert r.success, r.message
    assert {event.t for event in r.events if event.kind == "impact"} == {0.0}
    return np.array([r[f"{name}.vx"][-1] for name in m.model.bodies]), r


def compliant(masses, rates, stiffness, exponent):
    """The same balls with springs F = K d^n between them, that move, until they have parted; any K will do."""
    n, masses, stiffness = len(masses), np.array(masses, float), np.array(stiffness, float)

    def slope(_, y):
        force = stiffness * np.maximum(y[: n - 1] - y[1:n], 0.0) ** exponent
        return np.concatenate([y[n:], (np.append(0.0, force) - np.append(force, 0.0)) / masses])

    y = np.concatenate([np.zeros(n), rates])
    for _ in range(100):
        y = solve_ivp(slope, (0.0, 1.0), y, method="DOP853", rtol=1e-12, atol=1e-15).y[:, -1]
        if (np.diff(y[:n]) > 0.0).all() and (np.diff(y[n:]) >= -1e-12).all():
            return y[n:]
    raise AssertionError("the balls do not part")


COMPLIANT = {
    "three": ([1, 1, 1], [1, 0, 0], [1, 1], 1.5),
    "three, linear": ([1, 1, 1], [1, 0, 0], [1, 1], 1.0),
    "three, one softer": ([1, 1, 1], [1, 0, 0], [1, 7], 1.5),
    "five": ([1] * 5, [1, 0, 0, 0, 0], [1] * 4, 1.5),
    "five, two of them hit": ([1] * 5, [1, 1, 0, 0, 0], [1, 2, 3, 4], 1.5),
    "a light one between": ([3, 0.1, 1], [1, 0, 0], [1, 1], 1.5),
    "contacts that close again": ([1.33, 0.63, 1.68, 0.25], [1, 0, 0, 0], [0.23, 3.12, 3.19], 1.5),
}


@pytest.mark.parametrize("case", COMPLIANT)
def test_elastic_balls_part_as_those_of_a_compliant_chain(case):
    masses, rates, stiffness, exponent = COMPLIANT[case]
    got, r = after(chain(masses, rates, stiffness, exponent, [1] * len(stiffness)))
    assert got == pytest.approx(compliant(masses, rates, stiffness, exponent), abs=2e-9)  # errors of both integrations
    energy = 0.5 * np.dot(masses, np.square(rates))
    assert -1e-9 * energy < 0.5 * np.dot(masses, got**2) - energy <= 1e-15 * energy
    assert not any("created energy" in note for note in r.trust.notes)


def test_three_equal_balls_part_as_is_known():
    """The numbers of docs/contact.md, of elastic ones."""
    got, _ = after(chain([1, 1, 1], [1, 0, 0], [1, 1], 1.5, [1, 1]))
    assert got == pytest.approx([-0.071, 0.076, 0.995], abs=5e-4)


def increments(masses, rates, stiffness, exponent, restitution, steps=10_000):
    """The scheme of Liu, Zhao and Brogliato: small impulses, shared by the energies of the contacts."""
    masses, stiffness, e = np.array(masses, float), np.array(stiffness, float), np.array(restitution, float)
    n = len(stiffness)
    u, energy, step = np.array(rates, float), np.zeros(n), masses.sum() / steps
    for _ in range(20 * steps):
        gap_rate = np.diff(u)
        if (energy <= 0.0).all() and (gap_rate >= -1e-9).all():
            return u
        energy = np.maximum(energy, 0.0)
        share = stiffness ** (1 / (exponent + 1)) * energy ** (exponent / (exponent + 1))
        if not share.any():
            share[gap_rate.argmin()] = 1.0
        impulse = step * share / share.max()
        u = u + (np.append(0.0, impulse) - np.append(impulse, 0.0)) / masses
        rate = 0.5 * (gap_rate + np.diff(u))
        energy += np.where(rate < 0.0, -rate * impulse, -rate * impulse / np.maximum(e, 1e-6) ** 2)
        waiting = (energy <= 0.0) & (rate < 0.0)  # a contact has to begin with some energy to get any
        energy[waiting] = 1e-12 - 1e-3 * rate[waiting] * step
    raise AssertionError("the impact does not end")


@pytest.mark.parametrize(
    ("masses", "stiffness", "restitution"),
    [
        ([1, 1, 1], [1, 1], [0.7, 0.7]),
        ([1, 1, 1], [1, 5], [0.9, 0.3]),
        ([1, 1, 1], [1, 1], [0.5, 0.0]),
        ([1, 1, 1], [1, 1], [0.0, 0.5]),
        ([5, 1, 1], [1, 10], [0.0, 0.5]),
        ([1] * 5, [1] * 4, [0.9] * 4),
    ],
)
def test_losses_are_those_of_small_increments_of_impulse(masses, stiffness, restitution):
    rates = [1.0] + [0.0] * (len(masses) - 1)
    got, _ = after(chain(masses, rates, stiffness, 1.5, restitution))
    wanted = increments(masses, rates, stiffness, 1.5, restitution)
    assert got == pytest.approx(wanted, abs=1e-3)  # the increments are of first order


@pytest.mark.parametrize(
    ("e", "stiffness", "exponent"), list(itertools.product((0.0, 0.3, 1.0), (1.0, 1e9), (1.0, 1.5)))
)
def test_a_single_contact_returns_its_restitution(e, stiffness, exponent):
    got, _ = after(chain([2.0, 3.0], [1.0, -0.5], [stiffness], exponent, [e]))
    assert got[1] - got[0] == pytest.approx(1.5 * e, abs=1e-9)
    assert 2.0 * got[0] + 3.0 * got[1] == pytest.approx(0.5, abs=1e-14)


def test_only_ratios_of_stiffness_count():
    soft, stiff = (after(chain([1, 2, 1, 1], [1, 0, 0, 0], k, 1.5, [0.8] * 3))[0] for k in ([1, 3, 2], [1e9, 3e9, 2e9]))
    assert soft == pytest.approx(stiff, abs=1e-9)


def test_very_different_stiffness_makes_one_collision_after_the_other():
    """The stiff contact has ended before the soft one begins, and closes once more after it."""
    e, u = 0.6, np.array([1.0, 0.0, 0.0])
    for k in (0, 1, 0):
        assert u[k] > u[k + 1]
        mean, apart = 0.5 * (u[k] + u[k + 1]), 0.5 * e * (u[k] - u[k + 1])
        u[k : k + 2] = mean - apart, mean + apart
    got, _ = after(chain([1, 1, 1], [1, 0, 0], [1e8, 1], 1.5, [e, e]))
    assert got == pytest.approx(u, abs=1e-6)


def test_a_restitution_of_zero_is_the_limit_of_small_ones():
    none, small = (after(chain([1, 1, 1], [1, 0, 0], [1, 1], 1.5, [e, 0.5]))[0] for e in (0.0, 1e-4))
    assert none == pytest.approx(small, abs=1e-4)
    assert none[1] - none[0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("seed", range(12))
def test_momentum_is_kept_and_no_energy_comes_into_being(seed):
    random = np.random.default_rng(seed)
    n = int(random.integers(3, 6))
    masses, rates = 10 ** random.uniform(-1, 1, n), np.sort(random.normal(size=n))[::-1]  # all approach
    got, r = after(
        chain(masses, rates, 10 ** random.uniform(-2, 2, n - 1), random.choice([1.0, 1.5]), random.uniform(0, 1, n - 1))
    )
    assert masses @ got == pytest.approx(masses @ rates, abs=1e-12)
    assert (np.diff(got) >= -1e-10).all()
    lost = 0.5 * masses @ (np.square(rates) - got**2)
    assert lost >= 0.0
    assert sum(event.energy_lost for event in r.events if event.kind == "impact") == pytest.approx(lost, abs=1e-10)


def test_a_block_that_falls_flat_rises_flat():
    """Both corners of a guide's block hit at once: by symmetry each returns its share, and nothing turns."""
    e = 0.4
    r = rt.loads(f"""
format = 1
gravity = [0, 0]
[ground.points]
O = [0, 0]
[bodies.block]
points = {{ C = [0, 0] }}
center = [0, 0]
mass = 2
inertia = 0.1
[joints.guide]
type = "prismatic"
connect = ["ground.O", "block.C"]
clearance = 1e-3
block = {{ length = 0.2, height = 0.1 }}
contact = {{ model = "impact", restitution = {e}, restitution_law = "lzb", stiffness = 1e9 }}
[initial.block]
x = 0
y = 0
angle = 0
vx = 1
vy = -1
""").simulate(2e-3, t_eval=[0.0, 2e-3])
    assert r.success
    assert [r["block.vx"][-1], r["block.vy"][-1], r["block.omega"][-1]] == pytest.approx([1.0, e, 0.0], abs=1e-9)


def test_balls_that_bounce_on_each_other_come_to_rest():
    """A column falls on the ground; its last bounces end in closed form, and what it had is lost."""
    text = "format = 1\ngravity = [0, -10]\nground.points = { O = [0, 0] }\n"
    for i in range(3):
        text += f"""
[bodies.ball{i}]
points = {{ C = [0, 0] }}
mass = 1
inertia = 1
[joints.line{i}]
type = "prismatic"
axis = "90 deg"
angle = 0
connect = ["{f"ball{i - 1}.C" if i else "ground.O"}", "ball{i}.C"]
[joints.line{i}.stop]
min = {0.1 if i else 0}
contact = {{ model = "impact", restitution = 0.5, restitution_law = "lzb", stiffness = {i + 1} }}
[initial.ball{i}]
y = {0.5 + 0.1 * i}
"""
    r = rt.loads(text).simulate(4.0)
    assert r.success
    assert [r[f"ball{i}.y"][-1] for i in range(3)] == pytest.approx([0.0, 0.1, 0.2], abs=1e-12)
    assert r["energy.balance"] == pytest.approx(np.zeros(len(r.t)), abs=1e-9)
    assert r["energy.dissipated"][-1] == pytest.approx(3 * 10 * 0.5, rel=1e-9)


def contact(more):
    return f"""
format = 1
[ground.points]
O = [0, 0]
[bodies.a]
points = {{ C = [0, 0] }}
mass = 1
inertia = 1
[joints.pin]
type = "revolute"
connect = ["ground.O", "a.C"]
clearance = 1e-3
contact = {{ model = "impact", bush_radius = 0.01, {more} }}
"""


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ('restitution_law = "lzb"', "needs stiffness"),
        ('restitution_law = "lzb", stiffness = 0', "positive"),
        ('restitution_law = "lzb", stiffness = "1 kg"', "stiffness"),
        ('restitution_law = "lzb", stiffness = 1, exponent = -1', "positive"),
        ('restitution_law = "lzb", stiffness = 1, friction = 0.1', "no friction"),
        ('restitution_law = "lzb", stiffness = 1, tangential_restitution = 0.1', "newton"),
    ],
)
def test_what_the_law_cannot_take_is_refused(more, words):
    with pytest.raises(ModelError, match=words):
        rt.loads(contact(more))


def test_stiffness_may_have_its_unit_and_is_noted_where_no_law_uses_it():
    m = rt.loads(contact('restitution_law = "lzb", stiffness = "1e9 N/m^1.5"'))
    assert m.model.joints["pin"].contact.fields["stiffness"] == 1e9
    r = rt.loads(contact("stiffness = 1e9")).simulate(1e-3)
    assert any("does not use stiffness" in note for note in r.trust.notes)


def test_another_law_in_one_model_another_method_and_friction_of_joints_are_refused():
    m = chain([1, 1], [1, 0], [1], 1.5, [1])
    with pytest.raises(ModelError, match="works with method"):
        m.simulate(0.1, method="moreau")
    rubbing = """
[bodies.wheel]
points = { C = [0, 0] }
mass = 1
inertia = 1
[joints.axle]
type = "revolute"
connect = ["ground.O", "wheel.C"]
friction = { mu = 0.1, pin_radius = 0.01 }
"""
    with pytest.raises(ModelError, match="no dry friction of joints"):
        chain([1, 1], [1, 0], [1], 1.5, [1], rubbing).simulate(0.1)
    rolling = """
[bodies.wheel]
points = { C = [0, 0] }
mass = 1
inertia = 1
[joints.floor]
type = "surface"
connect = ["ground.O", "wheel.C"]
axis = 0
roller = 0.1
contact = { model = "impact", restitution_law = "lzb", stiffness = 1, rolling = 1e-3 }
[initial]
wheel = { x = 0, y = 0.1 }
"""
    with pytest.raises(ModelError, match=r"floor.contact.rolling: .* knows no rolling resistance"):
        chain([1, 1], [1, 0], [1], 1.5, [1], rolling).simulate(0.1)
    clutch = """
[bodies.wheel]
points = { C = [0, 0] }
mass = 1
inertia = 1
[joints.axle]
type = "revolute"
connect = ["ground.O", "wheel.C"]
[joints.one_way]
type = "clutch"
connect = ["ground", "wheel"]
"""
    with pytest.raises(ModelError, match="clutch has no stiffness"):
        chain([1, 1], [1, 0], [1], 1.5, [1], clutch).simulate(0.1)
