"""Bodies without mass: the motion is that of the equations with zeros in M, and of mechanisms without these bodies."""
# ruff: noqa: E501  a case is a line

import math

import numpy as np
import pytest

import rattle as rt
from rattle.equations import system as systems
from rattle.equations.dense import dense_rows
from rattle.equations.motion import derivative
from rattle.equations.state import state_layout
from rattle.jit import layout as at

nojit = pytest.mark.nojit
LAW = {"model": "kelvin-voigt", "stiffness": 1e5, "exponent": 1, "restitution": 0.5}


def four_bar(coupler=0.0, crank=0.5, folded=False, **start):
    """A four-bar on a spring; folded: with a rod, a constraint of one row, in place of a coupler without mass."""
    m = rt.Mechanism("four-bar", gravity=[0, -9.81]).ground(A=[0, 0], D=[0.5, 0])
    m.bar("crank", "A", "B", length=0.15, mass=crank).bar("rocker", "C", "D", length=0.35, mass=2)
    m.revolute("A", "ground.A", "crank.A").revolute("D", "rocker.D", "ground.D")
    if folded:
        m.rod("C", "crank.B", "rocker.C", length=0.5)
    else:
        m.bar("rod", "B", "C", length=0.5, mass=coupler)
        m.revolute("B", "crank.B", "rod.B").revolute("C", "rod.C", "rocker.C")
    m.load("pull", "spring", connect=["ground.A", "rocker.C"], stiffness=200, free_length=0.3, damping=3)
    return m.initial("crank", angle=0.7, **start).initial("rocker", angle=-1.2)


def swung(drive="", folded=False):
    """A crank that pulls a pendulum by a link without mass."""
    m = rt.Mechanism("swung", gravity=[0, -9.81]).ground(A=[0, 0])
    m.bar("crank", "A", "B", length=0.2, mass=0.4).bar("arm", "C", "E", length=0.5, mass=1.5)
    m.revolute("A", "ground.A", "crank.A")
    if folded:
        m.rod("C", "crank.B", "arm.C", length=0.3)
        m.initial("arm", x=0.6, y=-0.3, angle=-0.9)
    else:
        m.bar("link", "B", "C", length=0.3, mass=0).revolute("B", "crank.B", "link.B").revolute("C", "link.C", "arm.C")
    if drive:
        m.driver("motor", "A", angle=drive)
    return m.initial("crank", angle=0.3)


def slider_crank(crank=0.0):
    m = rt.Mechanism("engine").ground(O=[0, 0])
    m.bar("crank", "O", "A", length=0.05, mass=crank).bar("rod", "A", "B", length=0.15, mass=0)
    m.body("piston", mass=0.6, inertia=0, points={"B": [0, 0]}).body(
        "wheel", mass=0, inertia=0.02, points={"O": [0, 0]}
    )
    m.revolute("O", "ground.O", "crank.O").revolute("A", "crank.A", "rod.A").revolute("B", "piston.B", "rod.B")
    m.prismatic("guide", "ground.O", "piston.B").fixed("key", "crank.O", "wheel.O")
    m.load("gas", "force", at="piston.B", force=["-300*max(0, sin(20*t + 1))", 0])
    return m.initial("crank", angle=0.4, omega=30)


def planetary(planet=0.0):
    m = rt.Mechanism("planetary").ground(O=[0, 0])
    for name, mass, inertia, points in (
        ("sun", 1, 0.01, {"C": [0, 0]}),
        ("carrier", 0, 0, {"C": [0, 0], "P": [0.05, 0]}),
        ("planet", planet, 1e-3 * planet, {"P": [0, 0]}),
        ("load", 2, 0.05, {"C": [0, 0]}),
    ):
        m.body(name, mass=mass, inertia=inertia, points=points)
    m.revolute("S", "ground.O", "sun.C").revolute("K", "ground.O", "carrier.C").revolute("P", "carrier.P", "planet.P")
    m.fixed("shaft", "carrier.C", "load.C").joint("inner", "gear", "sun.C", "planet.P", radii=[0.02, 0.03])
    m.joint("outer", "gear", "ground.O", "planet.P", radii=[0.08, 0.03], internal=True)
    return m.load("T", "torque", body="sun", torque=3)


def solved(m, seed=0):
    """Accelerations and multipliers of the kernels at rates that the joints allow, and those of the whole equations."""
    system = m.system
    workspace, start = system.plain_workspace(), m.start
    y = np.zeros(state_layout(system).size)
    nq = 3 * system.body_count
    y[:nq] = start.q
    rate = np.zeros_like(y)
    derivative.python(workspace, 0.0, y, rate)
    rows = dense_rows(system, workspace)
    _, values, v = np.linalg.svd(rows)
    free = v[(values > 1e-9 * values[0]).sum() :]
    drift = np.linalg.lstsq(rows, workspace.rows[:, at.NU], rcond=None)[0]
    y[nq : 2 * nq] = drift + free.T @ np.random.default_rng(seed).normal(size=len(free))
    derivative.python(workspace, 0.0, y, rate)
    nr = len(rows)
    whole = np.zeros((nq + nr, nq + nr))
    whole[:nq, :nq] = np.diag(system.arrays["mass"][1:].ravel().astype(float))
    whole[:nq, nq:], whole[nq:, :nq] = rows.T, rows
    side = np.concatenate([workspace.force[1:].ravel(), workspace.rows[:, at.GAMMA]])
    exact = np.linalg.solve(whole, side)
    return np.concatenate([rate[nq : 2 * nq], workspace.multiplier]), exact


# ---------------------------------------------------------------- the equations
@nojit
@pytest.mark.parametrize(
    "make",
    [four_bar, lambda: four_bar(crank=0.0), swung, lambda: swung("5*t + t**2"), slider_crank, planetary],
    ids=["coupler", "crank and coupler", "link", "driven", "point mass and wheel", "planet and carrier"],
)
@pytest.mark.parametrize("seed", [0, 1])
def test_accelerations_and_reactions_solve_the_equations_with_zeros_in_the_mass_matrix(make, seed):
    found, exact = solved(make(), seed)
    assert found == pytest.approx(exact, rel=1e-10, abs=1e-11 * np.abs(exact).max())


@nojit
def test_small_masses_tend_to_none_with_an_error_proportional_to_them():
    (none, _), one, other = (solved(four_bar(coupler=mass)) for mass in (0.0, 1e-3, 1e-4))
    ratio = (one[0] - none) / (other[0] - none)
    assert ratio[np.abs(other[0] - none) > 1e-6] == pytest.approx(10, rel=2e-2)


@nojit
def test_the_fictitious_inertia_does_not_matter(monkeypatch):
    found = []
    for share in (1e-3, 0.1, 10.0):
        monkeypatch.setattr(systems, "SHARE", share)
        found.append(solved(slider_crank())[0])
    size = np.abs(found[1]).max()
    assert found[0] == pytest.approx(found[1], rel=1e-10, abs=1e-12 * size)
    assert found[2] == pytest.approx(found[1], rel=1e-10, abs=1e-12 * size)


@nojit
def test_rates_that_nobody_has_given_are_those_of_a_very_light_body():
    m = swung("5*t").initial("link", angle=-0.5).initial("arm", angle=-0.9).set({"initial.crank.angle": 0})
    none = m.start.v
    for mass in (1e-6, 1e-8):
        assert none == pytest.approx(m.set({"bodies.link.mass": mass}).start.v, abs=10 * mass + 1e-7)
    assert m.set({"bodies.link.mass": 0.1}).start.v != pytest.approx(none, abs=1e-3)


# ---------------------------------------------------------------- the same mechanism without the body
def test_a_coupler_without_mass_is_a_rod():
    t = np.linspace(0, 1, 21)
    whole, folded = (four_bar(folded=one, omega=5).simulate(1, t_eval=t, rtol=1e-11) for one in (False, True))
    assert whole.success
    for name, size in (("crank.angle", 10), ("rocker.omega", 10), ("C.fx", 100), ("C.fy", 100), ("energy.kinetic", 1)):
        assert whole[name] == pytest.approx(folded[name], abs=1e-8 * size), name
    along = np.array([np.cos(whole["rod.angle"]), np.sin(whole["rod.angle"])])
    assert whole["C.fx"] * along[1] == pytest.approx(whole["C.fy"] * along[0], abs=1e-9)  # no force across it
    assert np.abs(whole["energy.balance"]).max() < 1e-8


def both(change):
    """A four-bar with a coupler without mass and one with a rod, in one position, changed alike."""
    whole = four_bar(omega=5)
    whole._document["initial"].pop("rocker")
    angle = whole.start.q.reshape(-1, 3)[whole.system.bodies.index("rocker"), 2]
    folded = four_bar(folded=True, omega=5).set({"initial.rocker.angle": float(angle)})
    return whole.set(change), folded.set(change)


STOP = {"joints.A.stop": {"max": 1.9, "min": -1.4, "contact": {"model": "impact", "restitution": 0.6}}}
DRY = {"joints.A.friction": {"model": "coulomb", "mu": 0.3, "pin_radius": "2 cm"}}
PLAY = {
    "joints.D.clearance": "1 mm",
    "joints.D.contact": {"model": "impact", "restitution": 0.5, "friction": 0.1, "bush_radius": "1 cm"},
}
CLUTCH = {
    "bodies.rotor": {"mass": 1, "inertia": 0.02, "points": {"D": [0, 0]}},
    "joints.E": {"type": "revolute", "connect": ["ground.D", "rotor.D"]},
    "joints.way": {"type": "clutch", "connect": ["rocker", "rotor"]},
}


@pytest.mark.parametrize(
    ("change", "t_end", "how", "close"),
    [
        (STOP, 1.0, {}, 1e-7),
        (STOP, 0.3, {"method": "moreau", "step": 1e-4}, 1e-3),  # of first order: where it corrects positions, e counts
        (DRY, 1.0, {}, 1e-6),
        ({**STOP, **DRY}, 1.0, {}, 1e-6),
        (PLAY, 0.05, {}, 1e-7),
        ({"joints.D.clearance": "1 mm", "joints.D.contact": {**LAW, "stiffness": "1 kN/mm"}}, 0.05, {}, 1e-5),
        (CLUTCH, 0.5, {}, 1e-7),
    ],
    ids=["stop", "time stepping", "friction", "stop and friction", "play", "compliant play", "clutch"],
)
def test_contacts_friction_and_clutches_of_other_bodies_feel_no_coupler_without_mass(change, t_end, how, close):
    one, other = (m.simulate(t_end, t_eval=np.linspace(0, t_end, 11), **({"rtol": 1e-10} | how)) for m in both(change))
    assert one.success
    assert [event.kind for event in one.events] == [event.kind for event in other.events]
    assert one.events
    for name in ("crank.angle", "rocker.omega", "C.fx"):
        size = np.abs(other[name]).max()
        assert one[name] == pytest.approx(other[name], abs=close * size), name


@nojit
def test_a_stop_of_a_crank_without_mass_stops_what_it_drives():
    m = rt.Mechanism().ground(O=[0, 0]).bar("crank", "O", "A", length=0.2, mass=0)
    m.body("bob", mass=1, inertia=0, points={"P": [0, 0]}).fixed("P", "crank.A", "bob.P")
    m.revolute("O", "ground.O", "crank.O", stop={"max": 0.5, "contact": {"model": "impact", "restitution": 0.4}})
    r = m.initial("crank", angle=0, omega=2).simulate(0.5, t_eval=[0.2, 0.3, 0.5])
    assert r["crank.omega"] == pytest.approx([2, -0.8, -0.8], rel=1e-9)
    (hit,) = [event for event in r.events if event.kind == "impact"]
    assert "without mass or inertia: crank, bob" in str(m.check())
    assert (hit.t, hit.impulse) == pytest.approx((0.25, 0.04 * 2.8), rel=1e-9)  # m l^2 (1 + e) omega


def test_rates_after_a_jump_of_the_driver_are_those_without_the_link():
    drive = "6*(t - 0.1) if t > 0.1 else 0"
    whole, folded = swung(drive).initial("link", angle=-0.5), swung(drive, folded=True)
    place = dict(zip(whole.system.bodies, whole.start.q.reshape(-1, 3), strict=True))["arm"]
    folded.initial("arm", x=place[0], y=place[1], angle=place[2])
    one, other = (m.simulate(0.2, t_eval=[0, 0.05, 0.15, 0.2], rtol=1e-11) for m in (whole, folded))
    for name in ("crank.omega", "arm.vx", "arm.vy", "arm.omega", "arm.x", "arm.y"):
        assert one[name] == pytest.approx(other[name], abs=1e-8), name
    (jolt,), (same,) = ([event for event in r.events if event.kind == "jolt"] for r in (one, other))
    assert jolt.impulse == pytest.approx(same.impulse, rel=1e-9)
    assert jolt.energy_lost == pytest.approx(same.energy_lost, rel=1e-9, abs=1e-12)


@nojit
def test_a_planet_without_mass_gears_the_load_down():
    found, _ = solved(planetary())
    ratio = 1 + 0.08 / 0.02  # of sun to carrier, the ring being held
    alpha = 3 / (0.01 + 0.05 / ratio**2)
    bodies = planetary().system.bodies
    angle = {name: found[3 * n + 2] for n, name in enumerate(bodies)}
    assert angle["sun"] == pytest.approx(alpha, rel=1e-12)
    assert angle["load"] == pytest.approx(alpha / ratio, rel=1e-12)


@nojit
def test_a_point_mass_on_a_rod_without_mass_is_a_simple_pendulum():
    m = rt.Mechanism(gravity=[0, -9.81]).ground(A=[0, 0]).bar("rod", "A", "B", length=0.7, mass=0)
    m.body("bob", mass=2, inertia=0, points={"P": [0, 0]}).revolute("A", "ground.A", "rod.A").fixed(
        "P", "rod.B", "bob.P"
    )
    m.initial("rod", angle=-math.pi / 2)
    assert 2 * math.pi * m.modes().frequency == pytest.approx([math.sqrt(9.81 / 0.7)], rel=1e-9)
    found, exact = solved(m.set({"initial.rod.angle": 0.2}))
    assert found == pytest.approx(exact, abs=1e-11)
    assert found[2] == pytest.approx(-9.81 / 0.7 * math.cos(0.2), rel=1e-12)


@pytest.mark.machine
@nojit
def test_inverse_dynamics_and_equilibrium_do_without_the_mass_too():
    t = [0.0, 0.02, 0.05]
    r = slider_crank().driver("motor", "O", angle="0.4 + 30*t").inverse_dynamics(t)
    work = 0.6 * r["piston.vx"] * r["piston.ax"] - r["piston.vx"] * -300 * np.maximum(0, np.sin(20 * r.t + 1))
    assert r["motor.torque"] * 30 == pytest.approx(work, abs=1e-9)
    one, other = (four_bar(folded=folded).equilibrium()[0] for folded in (False, True))
    assert one["rocker.angle"] == pytest.approx(other["rocker.angle"], abs=1e-9)


def test_many_runs_side_by_side_take_bodies_without_mass():
    m = four_bar().parameter("l", 0.35).set({"bodies.rocker.length": "l"})
    found = m.many({"l": [0.34, 0.36]}, ["final(rocker.angle)"], t_end=0.3, rtol=1e-10)
    assert found.stats["how"].startswith("2 run side by side")
    alone = [m.set(l=value).simulate(0.3, rtol=1e-10)["rocker.angle"][-1] for value in (0.34, 0.36)]
    assert found["final(rocker.angle)"] == pytest.approx(alone, abs=1e-8)


# ---------------------------------------------------------------- where it cannot be
@nojit
def test_a_crank_without_mass_keeps_the_angle_that_was_given():
    m = four_bar(crank=0.0)
    m._document["initial"].pop("rocker")
    assert m.start.q[2] == pytest.approx(0.7, abs=1e-12)
    assert not m.start.notes


def hanging(**joint):
    m = rt.Mechanism(gravity=[0, -9.81]).ground(A=[0, 0]).bar("arm", "A", "B", length=1, mass=1)
    m.bar("rod", "B", "C", length=1, mass=0).revolute("A", "ground.A", "arm.A")
    return m.revolute("B", "arm.B", "rod.B", **joint)


def spinning_point():
    m = rt.Mechanism().ground(A=[0, 0]).body("bob", mass=1, inertia=0, points={"A": [1, 0], "B": [0, 0]})
    return m.rod("A", "ground.A", "bob.B", length=1).initial("bob", x=1, y=0)


@nojit
@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (hanging, rt.AssemblyError, "body 'rod' has no mass, and joints and drivers do not determine its motion: give it a mass"),
        (spinning_point, rt.AssemblyError, "body 'bob' has no inertia, and joints and drivers do not determine its angle"),
        (lambda: hanging(clearance="1 mm", contact="impact"), rt.AssemblyError, "body 'rod' has no mass"),
        (lambda: hanging(stop={"max": 1}), rt.AssemblyError, "body 'rod' has no mass"),
        (lambda: four_bar().set({"joints.B.clearance": "1 mm", "joints.B.contact": LAW}), rt.ModelError, "bodies.rod.mass: joint 'B' has play with a force law: 'rod' needs a mass there"),
        (lambda: four_bar().set({"joints.B.stop": {"max": 1, "contact": LAW}}), rt.ModelError, "bodies.rod.mass: joint 'B' has a stop with a force law"),
        (lambda: four_bar().joint("way", "clutch", "rod", "ground", model="viscous", damping=1), rt.ModelError, "bodies.rod.mass: the clutch 'way' has a force law"),
        (lambda: four_bar(coupler=-1), rt.ModelError, "bodies.rod.mass: -1 must not be negative"),
    ],
)  # fmt: skip
def test_a_body_that_needs_a_mass_is_named(make, error, words):
    with pytest.raises(error) as caught:
        _ = make().start
    assert words in str(caught.value)


def test_a_run_into_a_position_where_only_massless_bodies_move_says_which():
    m = four_bar(crank=0.0)
    m._document["initial"].pop("rocker")
    r = m.simulate(1.0)
    assert not r.success
    assert "in this position 'crank', 'rod' can move without moving any mass" in r.message
    assert r.t[-1] > 0.05
