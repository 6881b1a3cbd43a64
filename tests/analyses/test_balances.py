"""Balances that hold whatever the mechanism: energy, momentum, and the same motion in another frame or spelling."""

import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rattle as rt
from rattle.results.result import Result

EXAMPLES = sorted(rt.examples())
WORKLESS = ("", "ideal", "massless-link")  # contacts that are constraints, not force laws


@pytest.fixture(scope="module")
def runs() -> dict[str, Result]:
    return {name: rt.example(name).simulate() for name in EXAMPLES}


# ---------------------------------------------------------------- energy and reactions of the examples
@pytest.mark.parametrize("name", EXAMPLES)
def test_energy_audit_closes(runs, name):
    r = runs[name]
    turned_over = r["energy.kinetic"].max() + np.ptp(r["energy.potential"]) + np.abs(r["energy.work"]).max()
    # tolerances are 1e-8 and finer per step, steps up to 1e4; in metres and radians, so small energies need a floor;
    # Moreau-Jean has order one: its step of 1e-4 of the run leaves a few times that
    share = 1e-3 if r.provenance["method"] == "moreau" else 1e-6
    if r.films and r.provenance["method"] == "event":  # what an impact leaves to a film is lost within a part of a step
        share = 2e-5
    assert r.trust.energy_balance < share * turned_over + 2e-7
    total = r["energy.kinetic"] + r["energy.potential"] - r["energy.work"] + r["energy.dissipated"]
    assert r["energy.balance"] == pytest.approx(total - total[0], abs=1e-12 * turned_over)


@pytest.mark.parametrize("name", EXAMPLES)
def test_kinetic_energy_is_that_of_the_bodies(runs, name):
    r, bodies = runs[name], rt.example(name).model.bodies
    kinetic = sum(
        (one.mass * (r[f"{b}.vx"] ** 2 + r[f"{b}.vy"] ** 2) + one.inertia * r[f"{b}.omega"] ** 2) / 2
        for b, one in bodies.items()
    )
    assert r["energy.kinetic"] == pytest.approx(kinetic, rel=1e-12, abs=1e-15)


def motion_of(r: Result, body: str, at: np.ndarray) -> np.ndarray:
    """Velocity (2, n) of the material point of a body that is now at a place (2, n)."""
    if body == "ground":
        return np.zeros_like(at)
    x, y, w = (r[f"{body}.{key}"] for key in ("x", "y", "omega"))
    return np.array([r[f"{body}.vx"] - w * (at[1] - y), r[f"{body}.vy"] + w * (at[0] - x)])


def place_of(r: Result, body: str, at: list[float]) -> np.ndarray:
    """Place (2, n) of a point of a body."""
    if body == "ground":
        return np.tile(np.array(at)[:, None], len(r.t))
    c, s = np.cos(r[f"{body}.angle"]), np.sin(r[f"{body}.angle"])
    return np.array([r[f"{body}.x"] + c * at[0] - s * at[1], r[f"{body}.y"] + s * at[0] + c * at[1]])


def omega_of(r: Result, body: str) -> np.ndarray:
    return np.zeros(len(r.t)) if body == "ground" else r[f"{body}.omega"]


@pytest.mark.parametrize("name", EXAMPLES)
def test_reactions_do_no_work(runs, name):
    """The force on B and its opposite on A: together no power, in whatever joint."""
    r = runs[name]
    for joint, form in r.geometry["joints"].items():
        (a, b), (on_a, on_b) = form["bodies"], form["points"]
        here = place_of(r, b, on_b)
        if form["contact"] not in WORKLESS:
            continue
        if f"{joint}.torque" in r:  # a clutch: its torque where it holds, its slip where it does not
            assert np.abs(r[f"{joint}.torque"] * (omega_of(r, b) - omega_of(r, a))).max() < 1e-9, joint
            continue
        link = form["contact"] == "massless-link"  # a force along the link may be moved along it
        force = np.array([r[f"{joint}.fx"], r[f"{joint}.fy"]])
        speeds = motion_of(r, b, here), motion_of(r, a, place_of(r, a, on_a) if link else here)
        power = (force * (speeds[0] - speeds[1])).sum(axis=0)
        moment = r[f"{joint}.moment"] if f"{joint}.moment" in r else np.zeros(len(r.t))
        power = power + moment * (omega_of(r, b) - omega_of(r, a))
        if f"{joint}.friction" in r:  # that does work
            power = power - r[f"{joint}.friction"] * r[f"{joint}.rate"]
        fast = max(np.abs(one).max() for one in speeds) + 1e-3
        power, force, moment = (one[..., ~r.left_out] for one in (power, force, moment))
        assert np.abs(power).max() <= 1e-9 * (np.abs(force).max() + np.abs(moment).max()) * fast, joint


@pytest.mark.parametrize("name", EXAMPLES)
def test_forces_explain_the_motion_of_every_body_without_loads(runs, name):
    """m a = m g + sum of joint forces, J alpha = their moments about the mass centre: Newton, Euler."""
    r, model = runs[name], rt.example(name).model
    loaded = {one.a.body for one in model.loads.values()} | {one.b.body for one in model.loads.values()}
    loaded |= {driver.point.body for driver in model.drivers.values() if driver.point is not None}
    for form in r.geometry["joints"].values():
        loaded |= set() if form["contact"] in WORKLESS else set(form["bodies"])
    for body in model.bodies.keys() - loaded:
        one = model.bodies[body]
        force = [np.full(len(r.t), one.mass * g) for g in model.gravity]
        torque = np.zeros(len(r.t))
        for joint, form in r.geometry["joints"].items():
            if body not in form["bodies"]:
                continue
            sign = 1 if form["bodies"][1] == body else -1
            if f"{joint}.torque" in r:
                torque = torque + sign * r[f"{joint}.torque"]
                continue
            at = place_of(r, form["bodies"][1], form["points"][1])  # a link's force goes through its end on A as well
            fx, fy = sign * r[f"{joint}.fx"], sign * r[f"{joint}.fy"]
            force[0], force[1] = force[0] + fx, force[1] + fy
            torque = torque + (at[0] - r[f"{body}.x"]) * fy - (at[1] - r[f"{body}.y"]) * fx
            if f"{joint}.moment" in r:
                torque = torque + sign * r[f"{joint}.moment"]
            for motor, driver in model.drivers.items():
                if driver.joint == joint and f"{motor}.torque" in r:
                    torque = torque + sign * r[f"{motor}.torque"]
                if driver.joint == joint and f"{motor}.force" in r:  # along the line of a guide, through B's point
                    line = form["axis"] + (0.0 if form["bodies"][0] == "ground" else r[f"{form['bodies'][0]}.angle"])
                    fx, fy = sign * r[f"{motor}.force"] * np.cos(line), sign * r[f"{motor}.force"] * np.sin(line)
                    force[0], force[1] = force[0] + fx, force[1] + fy
                    torque = torque + (at[0] - r[f"{body}.x"]) * fy - (at[1] - r[f"{body}.y"]) * fx
        kept = ~r.left_out  # next to singular positions there are no reactions
        scale = 1e-9 * (1 + max(np.abs(part[kept]).max() for part in force))
        assert one.mass * r[f"{body}.ax"][kept] == pytest.approx(force[0][kept], abs=scale)
        assert one.mass * r[f"{body}.ay"][kept] == pytest.approx(force[1][kept], abs=scale)
        assert one.inertia * r[f"{body}.alpha"][kept] == pytest.approx(torque[kept], abs=scale)


# ---------------------------------------------------------------- momentum of a linkage that flies
def thrown(gravity: float) -> rt.Mechanism:
    """Three bars, a rod, a spring and a pin with play; nothing holds it to the ground."""
    m = rt.Mechanism("thrown linkage", gravity=[0, -gravity])
    for name, length, mass, angle in (("a", 0.4, 1.0, 0.3), ("b", 0.3, 0.5, 1.2), ("c", 0.5, 0.8, -0.4)):
        m.bar(name, "P", "Q", length=length, mass=mass).initial(name, angle=angle)
    m.revolute("j1", "a.Q", "b.P").revolute("j2", "b.Q", "c.P", clearance="2 mm", contact="massless-link")
    m.load("elastic", "spring", connect=["a.P", "c.Q"], stiffness=200, free_length=0.5)
    m.load("twist", "torsion-spring", connect=["a", "b"], stiffness=3, damping=0.05)
    m.initial("a", x=0, y=0, vx=1.0, vy=4.0, omega=6.0).initial("b", omega=-8.0).initial("c", omega=3.0)
    return m.initial("j2", offset=["2 mm", 0])


@pytest.mark.parametrize("gravity", [0.0, 9.81])
def test_momentum_of_a_thrown_linkage_changes_by_gravity_alone(gravity):
    m = thrown(gravity)
    r = m.simulate(0.5, rtol=1e-11)
    assert r.success, r.message
    total = sum(one.mass for one in m.model.bodies.values())
    linear, centre, angular = np.zeros((2, len(r.t))), np.zeros((2, len(r.t))), np.zeros(len(r.t))
    for name, one in m.model.bodies.items():
        x, y, vx, vy = (r[f"{name}.{key}"] for key in ("x", "y", "vx", "vy"))
        linear += one.mass * np.array([vx, vy])
        centre += one.mass * np.array([x, y]) / total
        angular += one.mass * (x * vy - y * vx) + one.inertia * r[f"{name}.omega"]
    weight = np.array([[0.0], [-gravity * total]])
    assert np.abs(linear - linear[:, :1] - weight * r.t).max() < 1e-9
    flight = centre[:, :1] + linear[:, :1] / total * r.t + weight / total * r.t**2 / 2
    assert np.abs(centre - flight).max() < 1e-9
    about_centre = angular - (centre[0] * linear[1] - centre[1] * linear[0])
    assert np.abs(about_centre - about_centre[0]).max() < 1e-9
    assert r["energy.dissipated"][-1] > 0.1  # the damper between two bodies takes energy and no momentum


# ---------------------------------------------------------------- the same mechanism, told differently
JOINTS = ("O1", "O2", "O3", "O4", "along", "stay", "weight")


def mixture(turn=0.0, shift=(0.0, 0.0), swapped=(), names=None, order=None) -> rt.Mechanism:
    """A driven four-bar with play in O3; a block slides on its coupler, held by a rod; a weight on the rocker."""
    names = names or {}
    order = order or sorted
    c, s = math.cos(turn), math.sin(turn)

    def put(x, y):
        return [shift[0] + c * x - s * y, shift[1] + s * x + c * y]

    def turned(x, y):
        return [c * x - s * y, s * x + c * y]

    def end(text):
        body, point = text.split(".")
        return f"{names.get(body, body)}.{point}"

    joints = {
        "O1": {"type": "revolute", "connect": ["ground.O1", "crank.P"]},
        "O2": {"type": "revolute", "connect": ["crank.Q", "coupler.P"]},
        "O3": {"type": "revolute", "connect": ["coupler.Q", "rocker.P"], "clearance": 3e-3, "contact": "massless-link"},
        "O4": {"type": "revolute", "connect": ["rocker.Q", "ground.O4"]},
        "along": {"type": "prismatic", "connect": ["coupler.P", "block.C"], "axis": 0.0},
        "stay": {"type": "rod", "connect": ["ground.S", "block.C"], "length": 0.45},
        "weight": {"type": "fixed", "connect": ["rocker.M", "lump.C"], "angle": 0.2},
    }  # fmt: skip
    for name in swapped:
        joints[name]["connect"].reverse()
        if "angle" in joints[name]:
            joints[name]["angle"] *= -1
    for one in joints.values():
        one["connect"] = [end(text) for text in one["connect"]]
    rocker = names.get("rocker", "rocker")
    spring = {"stiffness": 300, "free_length": 0.3, "damping": 2}
    bodies = {
        "crank": {"bar": ["P", "Q"], "length": 0.2, "mass": 0.5},
        "coupler": {"bar": ["P", "Q"], "length": 0.6, "mass": 2},
        "rocker": {"bar": ["P", "Q"], "length": 0.6, "mass": 2, "points": {"M": [0.1, 0.05]}},
        "block": {"points": {"C": [0, 0]}, "mass": 0.4, "inertia": 1e-3},
        "lump": {"points": {"C": [0.02, 0.01]}, "mass": 0.3, "inertia": 2e-3},
    }
    sense = -1 if "O1" in swapped else 1
    along = put(0.2 + 0.16 * 0.5, 0.16 * math.sqrt(0.75))
    initial = {
        "coupler": {"angle": math.pi / 3 + turn},
        "rocker": {"angle": -math.pi / 3 + turn},
        "block": {"x": along[0], "y": along[1], "angle": math.pi / 3 + turn},
        "lump": {"angle": -math.pi / 3 + 0.2 + turn},
    }
    offset = np.array(turned(0.003, 0.0)) * (-1 if "O3" in swapped else 1)
    document = {
        "format": 1,
        "gravity": turned(0.0, -9.81),
        "ground": {"points": {"O1": put(0, 0), "O4": put(0.803, 0), "S": put(0.1, 0.55), "W": put(1.0, 0.4)}},
        "bodies": {names.get(name, name): bodies[name] for name in order(bodies)},
        "joints": {name: joints[name] for name in order(joints)},
        "drivers": {"motor": {"joint": "O1", "angle": f"{sense}*(5*t + {turn!r})"}},
        "loads": {
            "pull": {"type": "spring", "connect": ["ground.W", end("rocker.P")], **spring},
            "M": {"type": "torque", "body": rocker, "torque": f"8 - 2*{rocker}.omega"},
        },
        "initial": {**{names.get(name, name): one for name, one in initial.items()}, "O3": {"offset": list(offset)}},
    }  # fmt: skip
    return rt.loads(json.dumps(document))


BODIES = ("crank", "coupler", "rocker", "block", "lump")
TIMES = np.linspace(0, 0.1, 21)


def simulate(m: rt.Mechanism) -> Result:
    r = m.simulate(t_eval=TIMES, rtol=1e-11, atol=1e-13)
    assert r.success, r.message
    return r


def state(r: Result, names=None) -> np.ndarray:
    names = names or {}
    return np.array([[r[f"{names.get(body, body)}.{key}"] for key in ("x", "y", "angle")] for body in BODIES])


def forces(r: Result) -> np.ndarray:
    return np.array([[r[f"{joint}.fx"], r[f"{joint}.fy"]] for joint in JOINTS])


@pytest.fixture(scope="module")
def plain() -> Result:
    return simulate(mixture())


@settings(max_examples=25)
@given(st.floats(-3, 3), st.floats(-10, 10), st.floats(-10, 10))
def test_a_turned_and_shifted_frame_sees_the_same_motion(plain, turn, dx, dy):
    r = simulate(mixture(turn, (dx, dy)))
    c, s = math.cos(turn), math.sin(turn)
    back = np.array([[c, s], [-s, c]])
    there = state(r)
    here = np.einsum("ij,bjt->bit", back, there[:, :2] - np.array([dx, dy])[None, :, None])
    assert np.abs(here - state(plain)[:, :2]).max() < 1e-8
    assert np.abs(there[:, 2] - turn - state(plain)[:, 2]).max() < 1e-8
    seen = np.einsum("ij,bjt->bit", back, forces(r))
    assert np.abs(seen - forces(plain)).max() < 1e-6 * np.abs(forces(plain)).max()
    assert r["motor.torque"] == pytest.approx(plain["motor.torque"], abs=1e-5)
    assert r["O3.normal"] == pytest.approx(plain["O3.normal"], rel=1e-6, abs=1e-4)


@settings(max_examples=25)
@given(st.sets(st.sampled_from(JOINTS)))
def test_swapping_the_sides_of_a_joint_turns_its_forces_and_nothing_else(plain, swapped):
    r = simulate(mixture(swapped=tuple(swapped)))
    assert np.abs(state(r) - state(plain)).max() < 1e-8
    sign = np.array([-1.0 if joint in swapped else 1.0 for joint in JOINTS])[:, None, None]
    assert np.abs(sign * forces(r) - forces(plain)).max() < 1e-6 * np.abs(forces(plain)).max()
    assert r["O3.normal"] == pytest.approx(plain["O3.normal"], rel=1e-6, abs=1e-4)
    assert r["motor.power"] == pytest.approx(plain["motor.power"], abs=1e-5)


@settings(max_examples=25)
@given(st.permutations(["zeta", "alpha1", "m", "x1", "Body_7"]), st.randoms(use_true_random=False))
def test_names_and_order_of_the_tables_do_not_matter(plain, names, random):
    renamed = dict(zip(BODIES, names, strict=True))

    def order(keys):
        mixed = sorted(keys)
        random.shuffle(mixed)
        return mixed

    r = simulate(mixture(names=renamed, order=order))
    assert np.abs(state(r, renamed) - state(plain)).max() < 1e-8
    assert np.abs(forces(r) - forces(plain)).max() < 1e-6 * np.abs(forces(plain)).max()


def test_what_a_damped_contact_loses_is_lost_whatever_follows():
    """Where its force ends inside the wall, the step that follows may reach beyond the other side of the bush."""
    m = rt.loads("""
format = 1
gravity = [0, -9.81]
ground.points.O = [0, 0]
bodies.b = { points = { C = [0.1, 0] }, mass = 1, inertia = 0.02 }
loads.push = { type = "torque", body = "b", torque = "9*(1 - 3*t)" }
initial = { b = { angle = 0, omega = 1 } }
[joints.O]
type = "revolute"
connect = ["ground.O", "b.C"]
clearance = 1e-3
contact = { model = "hertz", stiffness = 1e8, exponent = 1.5, damping = 100 }
""")
    coarse, fine = (
        m.simulate(t_end=0.3, t_eval=np.linspace(0.0, 0.3, 3001), rtol=1e-9, step=step) for step in (None, 1e-4)
    )
    lost = coarse["energy.dissipated"]
    assert np.diff(lost).min() > -2e-6
    assert lost == pytest.approx(fine["energy.dissipated"], abs=2e-6)
    assert 0.02 < lost[-1] < 0.03
